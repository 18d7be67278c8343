//! `burnish library pack`: a folder to hand out, with everything that belongs to the materials of a library.

use super::making::{self, ShownPictures};
use super::read;
use crate::cli::check::with_progress;
use crate::cli::progress_line::ProgressLine;
use crate::cli::{CliError, Messages, Outcome, interrupt, print_out};
use crate::library::check::{Checked, Options, Shelved, check_library, report};
use crate::library::entry::Entry;
use crate::library::pack::{self, Formats, Pack, Packed};
use crate::library::scan::Progress;
use crate::library::setup::Setup;
use crate::library::shelf::Shelf;
use burnish_material::Severity;
use clap::Args;
use serde_json::{Value, json};
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

/// Arguments of `burnish library pack`.
#[derive(Debug, Args)]
pub struct PackArguments {
    /// Folder of materials
    #[arg(value_name = "DIR")]
    folder: PathBuf,
    /// Folder to make; an older pack there is replaced, anything else is left alone
    #[arg(long, value_name = "FOLDER", required = true)]
    out: PathBuf,
    /// Name of the library [default: the folder's name]
    #[arg(long, value_name = "TEXT")]
    name: Option<String>,
    /// Packs although the check finds errors; files that cannot be used are left out
    #[arg(long)]
    allow_errors: bool,
    /// Other formats that every material is written in: usd, materialx and gltf with commas between, or none
    #[arg(long, value_name = "LIST", default_value = "usd,materialx,gltf", value_parser = Formats::parse)]
    formats: Formats,
    /// Prints one JSON object
    #[arg(long)]
    json: bool,
    /// The pictures on the sheet.
    #[command(flatten)]
    shown: ShownPictures,
}

/// Checks, makes pictures, packs, and prints what became of it.
pub fn run(arguments: &PackArguments) -> Result<Outcome, CliError> {
    let mut messages = Messages::default();
    let setup = arguments.shown.making.setup(&mut messages)?;
    let (folder, pictures) = (arguments.folder.as_path(), arguments.shown.pictures.as_deref());
    let threads = arguments.shown.making.scene.threads();
    let mut read = read(folder, threads, pictures, &mut messages)?;
    let name = arguments.name.clone().unwrap_or_else(|| read.name(folder));
    let entries = read.scanned.index.entries.clone();
    pack::refuse(&arguments.out, folder).map_err(|error| CliError::unusable(format!("--out: {error}")))?;

    let library = Shelved { root: folder, entries: &entries, shelf: &read.shelf, setup: setup.digest() };
    let options = Options { threads, ..Options::default() };
    let checked = with_progress("checking", |tell| check_library(&library, &options, tell, &interrupt::is_interrupted))?;
    if checked.errors > 0 && !arguments.allow_errors {
        return refused(arguments, &checked, &messages);
    }
    let only = arguments.shown.due(&read)?;
    let (rows, is_whole) = arguments.shown.making.make(folder, &entries, only, &setup, &mut read.shelf, &mut messages);
    let made = making::made(&rows);
    for row in rows.iter().filter(|row| row.entry.problem.is_none()) {
        row.problem.iter().for_each(|problem| messages.warn_about(&row.entry.path, problem));
    }
    let packed = if is_whole { write(arguments, &name, &entries, &setup, &read.shelf)? } else { None };
    if let Some(packed) = &packed {
        packed.warnings.iter().for_each(|warning| messages.warn(warning));
    }
    if arguments.json {
        let rows: Vec<Value> = rows.iter().map(|row| row.json(&setup, &read.shelf)).collect();
        print_out(&json_object(arguments, packed.as_ref(), &checked, rows, &messages).to_string())?;
    }
    let Some(Packed { materials, images, files, .. }) = packed else {
        return Err(CliError::Stopped(format!("interrupted; {made} pictures were made and are kept, no pack was written")));
    };
    if !arguments.json {
        let (out, counts) = (arguments.out.display(), report::counts(&checked));
        print_out(&format!(
            "{out}: packed; materials: {materials}, images: {images}, files: {files}, pictures made: {made}; check: {counts}"
        ))?;
    }
    Ok(Outcome::Done)
}

/// Writes the pack with a line that says how far it is. `None` if it was interrupted.
fn write(
    arguments: &PackArguments,
    name: &str,
    entries: &[Arc<Entry>],
    setup: &Setup,
    shelf: &Shelf,
) -> Result<Option<Packed>, CliError> {
    let line = Mutex::new(ProgressLine::new());
    let tell = |what: &str, Progress { done, total }: Progress| {
        line.lock().unwrap_or_else(PoisonError::into_inner).show(|| format!("{what}: {done} of {total}"));
    };
    let (root, threads, formats) = (arguments.folder.as_path(), arguments.shown.making.scene.threads(), arguments.formats);
    let pack = Pack { name, root, entries, shelf, setup: setup.digest(), threads, formats };
    let packed = pack.write(&arguments.out, &tell, &interrupt::is_interrupted);
    line.into_inner().unwrap_or_else(PoisonError::into_inner).clear();
    packed.map_err(CliError::unusable)
}

fn json_object(
    arguments: &PackArguments,
    packed: Option<&Packed>,
    checked: &Checked,
    rows: Vec<Value>,
    messages: &Messages,
) -> Value {
    json!({
        "out": arguments.out.to_string_lossy(),
        "is_packed": packed.is_some(),
        "materials": packed.map(|packed| packed.materials),
        "images": packed.map(|packed| packed.images),
        "files": packed.map(|packed| packed.files),
        "formats": arguments.formats.chosen().map(|(word, _)| word).collect::<Vec<_>>(),
        "made": rows.iter().filter(|row| !row["seconds"].is_null()).count(),
        "check": report::json_object(checked),
        "rows": rows,
        "warnings": messages.warnings(),
    })
}

/// Prints the errors that stand against packing.
fn refused(arguments: &PackArguments, checked: &Checked, messages: &Messages) -> Result<Outcome, CliError> {
    let sentence = format!("not packed: {}; correct the errors, or --allow-errors packs all the same", report::counts(checked));
    if arguments.json {
        let object = json_object(arguments, None, checked, Vec::new(), messages);
        print_out(&object.to_string())?;
    } else {
        let errors = checked.rows.iter().filter(|row| row.severity == Severity::Error);
        print_out(&errors.map(report::text_row).collect::<String>())?;
    }
    eprintln!("error: {sentence}");
    Ok(Outcome::Findings)
}
