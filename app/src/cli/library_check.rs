//! `burnish library check`: whether a folder of materials can be handed out, and what became of it since an earlier release.

use super::check::{counts, outcome, text_row, with_progress};
use super::library::{Read, read, standard_setup};
use super::scene_options::{SceneOptions, threads};
use super::{CliError, Messages, Outcome, interrupt, print_out};
use crate::digest::Digest;
use crate::library::check::against::{Against, Changed, LookChange, compare};
use crate::library::check::{Checked, Kind, Options, Shelved, check_library, report};
use clap::Args;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Arguments of `burnish library check`.
#[derive(Debug, Args)]
pub struct LibraryCheckArguments {
    /// Folder of materials
    #[arg(value_name = "DIR")]
    folder: PathBuf,
    /// Also exits with 1 where there are only warnings
    #[arg(long)]
    strict: bool,
    /// Probes each material numerically, which takes a second or so each
    #[arg(long)]
    stability: bool,
    /// Renders each material small to find those that look the same; without it, fresh small pictures are compared
    #[arg(long)]
    look: bool,
    /// Lists what was added, removed and changed since the library in this folder; that is no finding
    #[arg(long, value_name = "DIR")]
    against: Option<PathBuf>,
    /// Threads that check [default: all]
    #[arg(long, value_name = "N", allow_hyphen_values = true, value_parser = threads)]
    threads: Option<usize>,
    /// Prints one JSON object
    #[arg(long)]
    json: bool,
}

/// Checks, compares and prints. How fast it was goes to standard error.
pub(super) fn run(arguments: &LibraryCheckArguments) -> Result<Outcome, CliError> {
    let mut messages = Messages::default();
    let threads = SceneOptions { threads: arguments.threads, ..SceneOptions::default() }.threads();
    let options = Options { threads, renders_looks: arguments.look, probes_stability: arguments.stability };
    let new = read(&arguments.folder, threads, None, &mut messages)?;
    let old = arguments.against.as_deref().map(|folder| read(folder, threads, None, &mut messages)).transpose()?;
    let setup = standard_setup()?;
    let library = shelved(&arguments.folder, &new, setup);
    let start = Instant::now();
    let checked = with_progress("checking", |tell| check_library(&library, &options, tell, &interrupt::is_interrupted))?;
    let seconds = start.elapsed().as_secs_f64();
    let against = match (arguments.against.as_deref(), &old) {
        (Some(folder), Some(old)) => {
            let old = shelved(folder, old, setup);
            Some(with_progress("comparing", |tell| compare(&old, &library, &options, tell, &interrupt::is_interrupted))?)
        }
        _ => None,
    };
    let rate = checked.files as f64 / seconds.max(1e-9);
    if arguments.json {
        let mut object = report::json(&checked);
        object["seconds"] = seconds.into();
        object["read_seconds"] = new.seconds.into();
        object["files_per_second"] = rate.into();
        object["against"] = against.as_ref().map_or(Value::Null, |against| json_against(against, arguments.against.as_deref()));
        object["notices"] = messages.warnings().into();
        print_out(&object.to_string())?;
    } else {
        print_out(&text(&checked, against.as_ref()))?;
    }
    eprintln!("checked in {seconds:.2} s: {rate:.0} files per second, threads: {threads}");
    Ok(outcome(&checked, arguments.strict))
}

fn shelved<'a>(root: &'a Path, read: &'a Read, setup: Digest) -> Shelved<'a> {
    Shelved { root, entries: &read.scanned.index.entries, shelf: &read.shelf, setup }
}

fn text(checked: &Checked, against: Option<&Against>) -> String {
    let is_listed = |kind| kind != Kind::Thumbnail;
    let mut text: String = checked.rows.iter().filter(|row| is_listed(row.kind)).map(text_row).collect();
    if let Some(against) = against {
        let paths = |word: &str, paths: &[PathBuf]| -> String {
            paths.iter().map(|path| format!("{word:<8} {}\n", path.display())).collect()
        };
        text += &paths("added", &against.added);
        text += &paths("removed", &against.removed);
        against.changed.iter().for_each(|changed| text += &text_changed(changed));
        let count = |is: &dyn Fn(&Changed) -> bool| against.changed.iter().filter(|changed| is(changed)).count();
        text += &format!(
            "{} added, {} removed, {} changed by value, {} changed in look, {} of which the look is not known, {} unchanged\n",
            against.added.len(),
            against.removed.len(),
            count(&|changed| changed.is_by_value),
            count(&|changed| matches!(changed.look, LookChange::Changed(_))),
            count(&|changed| changed.look == LookChange::Unknown),
            against.unchanged
        );
    }
    let pictures = checked.rows.iter().filter(|row| !is_listed(row.kind)).count();
    if pictures > 0 {
        text += &format!("{pictures} small pictures are stale or missing; `burnish library thumbnails` makes them\n");
    }
    text + &counts(checked)
}

fn text_changed(changed: &Changed) -> String {
    let path = changed.path.display();
    if let Some(problem) = &changed.problem {
        return format!("changed  {path}: cannot be compared: {problem}\n");
    }
    let keys: Vec<&str> = changed.changes.iter().map(|change| change.key.as_str()).collect();
    let keys = match (keys.is_empty(), changed.is_by_value) {
        (false, _) => keys.join(", "),
        (true, true) => "images".to_owned(),
        (true, false) => "spelling".to_owned(),
    };
    let look = match changed.look {
        LookChange::Same(_) => "looks the same".to_owned(),
        LookChange::Changed(distance) => format!("looks {:.1} % different", 100.0 * distance),
        LookChange::Unknown => "look not known".to_owned(),
    };
    format!("changed  {path}: {keys}; {look}\n")
}

fn json_against(against: &Against, folder: Option<&Path>) -> Value {
    let names = |paths: &[PathBuf]| -> Vec<String> { paths.iter().map(|path| path.to_string_lossy().into_owned()).collect() };
    let changed = against.changed.iter().map(|changed| {
        let (look, distance) = match changed.look {
            LookChange::Same(distance) => ("same", Some(distance)),
            LookChange::Changed(distance) => ("changed", Some(distance)),
            LookChange::Unknown => ("not known", None),
        };
        let changes = changed.changes.iter().map(|change| json!({ "property": change.key, "a": change.a, "b": change.b }));
        json!({
            "path": changed.path.to_string_lossy(),
            "by_value": changed.is_by_value,
            "look": look,
            "distance": distance,
            "changed": changes.collect::<Vec<_>>(),
            "problem": changed.problem,
        })
    });
    json!({
        "folder": folder.map(Path::to_string_lossy),
        "added": names(&against.added),
        "removed": names(&against.removed),
        "changed": changed.collect::<Vec<_>>(),
        "unchanged": against.unchanged,
    })
}
