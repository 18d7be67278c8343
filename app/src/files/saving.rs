//! Writing files whole or not at all.

use super::FilesError;
use std::ffi::OsString;
use std::fs::{self, File};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

/// Writes `bytes` to `path` so that the file holds either all of them or what it held before.
///
/// The bytes go to a new file beside it, are forced to disk, read back, compared, and only then renamed.
pub fn save_atomic(path: &Path, bytes: &[u8]) -> Result<(), FilesError> {
    // A rename would replace a link by a file: write through it instead.
    let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf());
    let failed = |source| FilesError::Write { path: path.to_path_buf(), source };
    let temporary = temporary_beside(&target).map_err(failed)?;

    let written = write_and_check(&temporary, bytes, path).and_then(|()| {
        if let Ok(old) = fs::metadata(&target) {
            // Kept on a best effort: some file systems have no permissions to keep.
            let _ = fs::set_permissions(&temporary, old.permissions());
        }
        fs::rename(&temporary, &target).map_err(failed)
    });
    if written.is_err() {
        let _ = fs::remove_file(&temporary);
        return written;
    }
    // The rename itself lies in the folder; not every system lets a folder be synced.
    if let Some(folder) = target.parent().filter(|folder| !folder.as_os_str().is_empty()) {
        let _ = File::open(folder).and_then(|folder| folder.sync_all());
    }
    Ok(())
}

/// An error where [`save_atomic`] would fail: told before minutes of work, not after.
pub fn check_writable(path: &Path) -> Result<(), FilesError> {
    let failed = |source| FilesError::Write { path: path.to_path_buf(), source };
    if path.is_dir() {
        return Err(failed(std::io::ErrorKind::IsADirectory.into()));
    }
    let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf());
    let temporary = temporary_beside(&target).map_err(failed)?;
    File::create(&temporary).map_err(failed)?;
    fs::remove_file(&temporary).map_err(failed)
}

/// Where a file is written before it takes its name.
fn temporary_beside(target: &Path) -> std::io::Result<PathBuf> {
    let invalid = || std::io::Error::new(std::io::ErrorKind::InvalidInput, "the path has no file name");
    let name = target.file_name().ok_or_else(invalid)?;
    let mut beside: OsString = OsString::from(".");
    beside.push(name);
    // Two threads may write the same file.
    static COUNT: AtomicU64 = AtomicU64::new(0);
    beside.push(format!(".{}-{}.tmp", std::process::id(), COUNT.fetch_add(1, Ordering::Relaxed)));
    Ok(target.with_file_name(beside))
}

fn write_and_check(temporary: &Path, bytes: &[u8], path: &Path) -> Result<(), FilesError> {
    let failed = |source| FilesError::Write { path: path.to_path_buf(), source };
    let mut file = File::create(temporary).map_err(failed)?;
    file.write_all(bytes).map_err(failed)?;
    file.sync_all().map_err(failed)?;
    drop(file);
    let read_back = fs::read(temporary).map_err(failed)?;
    if read_back == bytes { Ok(()) } else { Err(FilesError::Differs { path: path.to_path_buf() }) }
}
