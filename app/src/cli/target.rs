//! Where results are written: refused before minutes of work, not after.

use super::CliError;
use std::path::Path;

/// An error where a file could not be written: its folder is not there, or it is a folder itself.
pub fn refuse_target(option: &str, path: &Path) -> Result<(), CliError> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    if !folder.is_dir() {
        return Err(CliError::unusable(format!(
            "{option}: {}: expected a folder that exists: {}",
            path.display(),
            folder.display()
        )));
    }
    if path.is_dir() {
        return Err(CliError::unusable(format!("{option}: {}: expected a file, found a folder", path.display())));
    }
    Ok(())
}

/// Whether a path ends in `.ending`, in any case.
pub fn has_ending(path: &Path, ending: &str) -> bool {
    path.extension().is_some_and(|found| found.eq_ignore_ascii_case(ending))
}
