//! `burnish library sheet`: a contact sheet of a folder of materials, with pictures that are made where they are missing.

use super::making::{self, Row, ShownPictures};
use super::{query_of, read};
use crate::cli::progress_line::ProgressLine;
use crate::cli::target::{has_ending, refuse_target};
use crate::cli::{CliError, Messages, Outcome, interrupt, print_out};
use crate::files::save_atomic;
use crate::library::entry::Entry;
use crate::library::setup::Setup;
use crate::library::sheet::{Sheet, is_page};
use crate::library::shelf::Shelf;
use clap::Args;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Arguments of `burnish library sheet`.
#[derive(Debug, Args)]
pub struct SheetArguments {
    /// Folder of materials
    #[arg(value_name = "DIR")]
    folder: PathBuf,
    /// File to write, as page or picture; may be given twice for both
    #[arg(long, value_name = "FILE.html|.png", default_value = "contact-sheet.html")]
    out: Vec<PathBuf>,
    /// Title of the sheet [default: the folder's name]
    #[arg(long, value_name = "TEXT")]
    title: Option<String>,
    /// Shows only what matches, such as `metal rough<0.3 tag:measured -glass is:stale`
    #[arg(long, value_name = "QUERY", allow_hyphen_values = true)]
    search: Option<String>,
    /// Largest side of the pictures on the sheet, 16 to 1024 pixels [default: as they are, in a PNG 256 or what fits]
    #[arg(long, value_name = "PIXELS", allow_hyphen_values = true, value_parser = clap::value_parser!(u32).range(16..=1024))]
    side: Option<u32>,
    /// Columns of a PNG [default: about three by two]
    #[arg(long, value_name = "N", allow_hyphen_values = true, value_parser = clap::value_parser!(u32).range(1..=256))]
    columns: Option<u32>,
    /// Prints one JSON object
    #[arg(long)]
    json: bool,
    /// The pictures on the sheet.
    #[command(flatten)]
    shown: ShownPictures,
}

/// Makes pictures, writes the sheet and prints what became of each file.
pub fn run(arguments: &SheetArguments) -> Result<Outcome, CliError> {
    let mut messages = Messages::default();
    let query = query_of(arguments.search.as_deref())?;
    for out in &arguments.out {
        if !is_page(out) && !has_ending(out, "png") {
            return Err(CliError::unusable(format!("--out: {}: expected a file name that ends in .html or .png", out.display())));
        }
        refuse_target("--out", out)?;
    }
    let setup = arguments.shown.making.setup(&mut messages)?;
    let pictures = arguments.shown.pictures.as_deref();
    let mut read = read(&arguments.folder, arguments.shown.making.scene.threads(), pictures, &mut messages)?;
    let entries = read.matching(&query, setup.digest(), &mut messages);
    if entries.is_empty() {
        return Err(CliError::unusable("--search: nothing in this library matches"));
    }
    let title = arguments.title.clone().unwrap_or_else(|| read.name(&arguments.folder));
    // Told before hours of rendering.
    let shelf = &read.shelf;
    let planned = Sheet::of(&title, &arguments.folder, &entries, shelf, setup.digest()).0;
    let planned = planned.shaped(arguments.side, arguments.columns);
    arguments
        .out
        .iter()
        .try_for_each(|out| planned.refuse_too_many(out))
        .map_err(|error| CliError::unusable(format!("--out: {error}")))?;
    let only = arguments.shown.due(&read)?;
    let (rows, is_whole) = arguments.shown.making.make(&arguments.folder, &entries, only, &setup, &mut read.shelf, &mut messages);
    if !is_whole {
        let made = making::made(&rows);
        report(arguments, &setup, &read.shelf, &rows, None, &messages)?;
        return Err(CliError::Stopped(format!("interrupted; {made} pictures were made and are kept, no sheet was written")));
    }
    let sheet = write(arguments, &title, &entries, &setup, &read.shelf, &mut messages)?;
    report(arguments, &setup, &read.shelf, &rows, Some(&sheet), &messages)?;
    Ok(if rows.iter().any(|row| row.problem.is_some()) { Outcome::Findings } else { Outcome::Done })
}

fn write(
    arguments: &SheetArguments,
    title: &str,
    entries: &[Arc<Entry>],
    setup: &Setup,
    shelf: &Shelf,
    messages: &mut Messages,
) -> Result<Sheet, CliError> {
    let (sheet, problems) = Sheet::of(title, &arguments.folder, entries, shelf, setup.digest());
    problems.into_iter().for_each(|problem| messages.warn(problem));
    let sheet = sheet.shaped(arguments.side, arguments.columns);
    let mut line = ProgressLine::new();
    for out in &arguments.out {
        let total = sheet.cards().len();
        let bytes = sheet.bytes(out, &mut |done| {
            line.show(|| format!("{}: {done} of {total}", out.display()));
            !interrupt::is_interrupted()
        });
        line.clear();
        let bytes = bytes.map_err(|error| CliError::unusable(format!("--out: {}: {error}", out.display())))?;
        save_atomic(out, &bytes.ok_or(CliError::Interrupted)?).map_err(CliError::unusable)?;
    }
    if arguments.out.iter().any(|out| !is_page(out)) {
        warn_of_boxes(&sheet, messages);
    }
    Ok(sheet)
}

/// Tells of names that a PNG cannot show.
fn warn_of_boxes(sheet: &Sheet, messages: &mut Messages) {
    let count = sheet.names_with_boxes();
    if count > 0 {
        messages.warn(format!("{count} names have letters that the font of the PNG lacks; a page (.html) shows them"));
    }
}

fn report(
    arguments: &SheetArguments,
    setup: &Setup,
    shelf: &Shelf,
    rows: &[Row<'_>],
    sheet: Option<&Sheet>,
    messages: &Messages,
) -> Result<(), CliError> {
    let made = making::made(rows);
    let failed = rows.iter().filter(|row| row.problem.is_some()).count();
    let shown = sheet.map(|sheet| sheet.cards().len());
    if arguments.json {
        let rows: Vec<Value> = rows.iter().map(|row| row.json(setup, shelf)).collect();
        let out: &[PathBuf] = if sheet.is_some() { &arguments.out } else { &[] };
        return print_out(
            &json!({
                "out": out.iter().map(|path| path.to_string_lossy()).collect::<Vec<_>>(),
                "shown": shown,
                "made": made,
                "failed": failed,
                "rows": rows,
                "warnings": messages.warnings(),
            })
            .to_string(),
        );
    }
    let problems = rows.iter().filter_map(|row| Some((row.entry.path.display(), row.problem.as_ref()?)));
    let mut lines: String = problems.map(|(path, problem)| format!("{path}: {problem}\n")).collect();
    if let Some(shown) = shown {
        let names: Vec<String> = arguments.out.iter().map(|path: &PathBuf| Path::display(path).to_string()).collect();
        lines += &format!("{}: {shown} materials, {made} pictures made, {failed} that cannot be shown", names.join(", "));
    }
    print_out(&lines)
}
