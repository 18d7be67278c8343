//! `burnish check`: whether material files can be read, and whether their values lie in the stated ranges.
//!
//! Findings are the result, so they go to standard output. It does not judge pictures, provenance or duplicates.

use super::{CliError, Outcome, interrupt, print_out};
use crate::files::{self, FilesError};
use crate::library::walk::walk;
use burnish_material::{FileError, Material, Severity};
use clap::Args;
use serde_json::json;
use std::fs;
use std::path::{Path, PathBuf};

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

/// One finding in one file.
struct Row {
    file: String,
    line: Option<usize>,
    severity: Severity,
    key: String,
    message: String,
}

/// Checks all files and prints what was found.
pub fn run(arguments: &CheckArguments) -> Result<Outcome, CliError> {
    let files = material_files(&arguments.paths)?;
    let mut rows = Vec::new();
    for path in &files {
        interrupt::check()?;
        check_file(path, &mut rows);
    }
    let count_of = |severity| rows.iter().filter(|row| row.severity == severity).count();
    let (errors, warnings) = (count_of(Severity::Error), count_of(Severity::Warning));
    if arguments.json {
        let rows: Vec<_> = rows.iter().map(json_row).collect();
        print_out(&json!({ "files": files.len(), "errors": errors, "warnings": warnings, "rows": rows }).to_string())?;
    } else {
        let lines: String = rows.iter().map(text_row).collect();
        let counts = [(files.len(), "file"), (errors, "error"), (warnings, "warning")].map(|(n, word)| count(n, word));
        print_out(&format!("{lines}{}", counts.join(", ")))?;
    }
    Ok(if errors > 0 || (arguments.strict && warnings > 0) { Outcome::Findings } else { Outcome::Done })
}

fn count(n: usize, word: &str) -> String {
    format!("{n} {word}{}", if n == 1 { "" } else { "s" })
}

fn json_row(row: &Row) -> serde_json::Value {
    json!({ "file": row.file, "line": row.line, "severity": row.severity.word(), "key": row.key, "message": row.message })
}

fn text_row(row: &Row) -> String {
    let line = row.line.map_or_else(String::new, |line| format!(":{line}"));
    let key = if row.key.is_empty() { String::new() } else { format!("{}: ", row.key) };
    format!("{}{line}: {}: {key}{}\n", row.file, row.severity.word(), row.message)
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

fn check_file(path: &Path, rows: &mut Vec<Row>) {
    let file_name = path.display().to_string();
    let mut add = |line: Option<usize>, severity: Severity, key: &str, message: String| {
        rows.push(Row { file: file_name.clone(), line, severity, key: key.to_owned(), message });
    };
    let (file, warnings) = match files::read_material(path) {
        Ok(read) => read,
        Err(FilesError::Material { source, .. }) => {
            let line = match source {
                FileError::NotRon { line, .. } | FileError::NotMap { line, .. } | FileError::DuplicateKey { line, .. } => {
                    Some(line)
                }
                FileError::TooLarge { .. } => None,
            };
            return add(line, Severity::Error, "", source.to_string());
        }
        Err(error) => {
            let message = error.to_string();
            let message = message.strip_prefix(&format!("{file_name}: ")).unwrap_or(&message);
            return add(None, Severity::Error, "", message.to_owned());
        }
    };
    for warning in warnings {
        let severity = if warning.is_refused { Severity::Error } else { Severity::Warning };
        add(Some(warning.line), severity, &warning.key, warning.message);
    }
    for finding in burnish_material::check(file.material()) {
        let key = finding.property.map_or("", |property| property.def().name);
        // A value outside its range can be rendered, clamped: only what cannot be read fails the file.
        add(None, finding.severity.min(Severity::Warning), key, finding.message);
    }
    for (key, message) in unusable_textures(file.material(), path.parent()) {
        add(None, Severity::Warning, key, message);
    }
}

/// Images that a material names and that cannot be read; their pixels are not looked at.
fn unusable_textures(material: &Material, folder: Option<&Path>) -> Vec<(&'static str, String)> {
    let textures = material.slots().filter_map(|(property, slot)| Some((property.def().name, slot.texture.as_ref()?)));
    // A texture without a path is a finding already.
    textures
        .filter(|(_, texture)| !texture.path.is_empty())
        .filter_map(|(key, texture)| Some((key, files::texture_problem(&texture.path, folder)?)))
        .collect()
}
