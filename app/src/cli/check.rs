//! `burnish check`: whether material files can be read, and what about them is hardly meant.
//!
//! Findings are the result, so they go to standard output. A folder that is handed out is checked by `burnish library check`, which is stricter.

use super::progress_line::ProgressLine;
use super::scene_options::SceneOptions;
use super::{CliError, Outcome, interrupt, print_out};
use crate::library::check::report::{counts, json_object, text_row};
use crate::library::check::{Checked, Options, check_files};
use crate::library::scan::Progress;
use crate::library::walk::walk;
use clap::Args;
use std::fs;
use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};

/// Arguments of `burnish check`.
#[derive(Debug, Args)]
pub struct CheckArguments {
    /// Material files, or folders that are searched for .asm.ron files
    #[arg(required = true, value_name = "PATH")]
    paths: Vec<PathBuf>,
    /// Also exits with 1 where there are only warnings
    #[arg(long)]
    strict: bool,
    /// Prints one JSON object
    #[arg(long)]
    json: bool,
}

/// Checks all files and prints what was found.
pub fn run(arguments: &CheckArguments) -> Result<Outcome, CliError> {
    let files = material_files(&arguments.paths)?;
    let options = Options { threads: SceneOptions::default().threads(), ..Options::default() };
    let checked = with_progress("checking", |tell| check_files(&files, &options, tell, &interrupt::is_interrupted))?;
    if arguments.json {
        print_out(&json_object(&checked).to_string())?;
    } else {
        let lines: String = checked.rows.iter().map(text_row).collect();
        print_out(&format!("{lines}{}", counts(&checked)))?;
    }
    Ok(outcome(&checked, arguments.strict))
}

/// Does something that takes a while with a line that says how far it is; an error if it was interrupted.
pub(super) fn with_progress<T>(what: &str, work: impl FnOnce(&(dyn Fn(Progress) + Sync)) -> Option<T>) -> Result<T, CliError> {
    let line = Mutex::new(ProgressLine::new());
    let tell = |Progress { done, total }: Progress| {
        line.lock().unwrap_or_else(PoisonError::into_inner).show(|| format!("{what}: {done} of {total}"));
    };
    let answer = work(&tell);
    line.into_inner().unwrap_or_else(PoisonError::into_inner).clear();
    interrupt::check()?;
    answer.ok_or(CliError::Interrupted)
}

/// Exit code 1 from the first error; where it is strict, from the first warning.
pub(super) fn outcome(checked: &Checked, is_strict: bool) -> Outcome {
    if checked.errors > 0 || (is_strict && checked.warnings > 0) { Outcome::Findings } else { Outcome::Done }
}

/// All material files among the paths and below them, each once, in the order of their names.
fn material_files(paths: &[PathBuf]) -> Result<Vec<PathBuf>, CliError> {
    let mut files = Vec::new();
    for path in paths {
        let unusable = |error| CliError::unusable(format!("{}: expected a file or a folder: {error}", path.display()));
        if fs::metadata(path).map_err(unusable)?.is_dir() {
            let found = walk(path, &interrupt::is_interrupted).map_err(unusable)?;
            interrupt::check()?;
            if let Some(problem) = found.problems.first() {
                return Err(CliError::unusable(problem));
            }
            let before = files.len();
            files.extend(found.files.iter().map(|file| path.join(&file.path)));
            if files.len() == before {
                return Err(CliError::unusable(format!(
                    "{}: expected .asm.ron files in this folder, found none",
                    path.display()
                )));
            }
        } else {
            files.push(path.clone());
        }
    }
    files.sort();
    files.dedup();
    Ok(files)
}
