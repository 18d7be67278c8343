//! What processes that are gone have left behind.

use super::{FOLDER, Kept, LOCK, take_lock};
use crate::files::FilesError;
use crate::own_files;
use std::fs::{self, File};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// How much is read from one session; the rest is left for the next time.
const MAX_SESSION_BYTES: u64 = 64 << 20;
/// How many documents of one session, and how many sessions, are looked at.
const MAX_ENTRIES: usize = 1000;

/// The documents of a process that is gone, which no other process is offered as long as this exists.
///
/// Dropping it leaves them on disk, to be offered again.
#[derive(Debug)]
pub struct Abandoned {
    folder: PathBuf,
    documents: Vec<Kept>,
    lock: File,
}

impl Abandoned {
    /// The documents, the one that was changed last first.
    pub fn documents(&self) -> &[Kept] {
        &self.documents
    }

    /// Deletes the documents from disk. What could not be read stays.
    ///
    /// Documents taken over must be safe elsewhere before; [`Store::adopt`](super::Store::adopt) sees to that.
    pub fn discard(self) -> Result<(), FilesError> {
        for document in &self.documents {
            remove(&self.folder.join(format!("{}.ron", document.id)))?;
        }
        clear(&self.folder, Some(self.lock))
    }
}

/// Sessions below the state folder `state` whose processes are gone, with what they left unsaved, newest first; and
/// sentences for the user about what could not be read, which is set aside.
///
/// Reads and parses whole files: not for the thread that draws the window.
pub fn left_behind(state: &Path) -> (Vec<Abandoned>, Vec<String>) {
    let (mut found, mut messages) = (Vec::new(), Vec::new());
    let folder = state.join(FOLDER);
    let entries = match fs::read_dir(&folder) {
        Ok(entries) => entries,
        Err(error) if error.kind() == ErrorKind::NotFound => return (found, messages),
        Err(source) => return (found, vec![FilesError::Read { path: folder, source }.to_string()]),
    };
    for entry in entries.flatten().filter(|entry| entry.file_type().is_ok_and(|kind| kind.is_dir())).take(MAX_ENTRIES) {
        let folder = entry.path();
        // Where there are no documents, no lock is made: the process whose folder this is may be about to make its own.
        match take_lock(&folder, !files(&folder).is_empty()) {
            Ok(None) => {}
            Err(error) if error.kind() == ErrorKind::NotFound => {
                // Of a start that was cut off. If it is still going on, it finds another folder.
                let _ = fs::remove_dir(&folder);
            }
            Err(source) => messages.push(FilesError::Read { path: folder.join(LOCK), source }.to_string()),
            Ok(Some(lock)) => {
                let documents = read(&folder, &mut messages);
                if documents.is_empty() {
                    // Nothing is lost if it cannot be cleared: it is looked at again the next time.
                    let _ = clear(&folder, Some(lock));
                } else {
                    found.push(Abandoned { folder, documents, lock });
                }
            }
        }
    }
    found.sort_by_key(|abandoned| std::cmp::Reverse(abandoned.documents.first().map(|document| document.when)));
    (found, messages)
}

/// The documents of a session, newest first.
fn read(folder: &Path, messages: &mut Vec<String>) -> Vec<Kept> {
    let mut left = MAX_SESSION_BYTES;
    let mut documents = Vec::new();
    for (_, id, path, length) in files(folder) {
        if length > left {
            let all = "expected at most 64 MiB of unsaved documents, found more; it stays where it is";
            messages.push(format!("{}: {all}", path.display()));
            continue;
        }
        left -= length;
        let (document, message) = own_files::load(&path, MAX_SESSION_BYTES, |text| Kept::from_ron(id, text));
        documents.extend(document);
        messages.extend(message);
    }
    documents.sort_by_key(|document| std::cmp::Reverse(document.when));
    documents
}

/// When each document of a session was written, its number, file and length in bytes; newest first.
fn files(folder: &Path) -> Vec<(SystemTime, u64, PathBuf, u64)> {
    let Ok(entries) = fs::read_dir(folder) else { return Vec::new() };
    let mut files = Vec::new();
    for entry in entries.flatten() {
        let path = entry.path();
        let (Some(id), Ok(metadata)) = (id(&path), entry.metadata()) else { continue };
        files.push((metadata.modified().unwrap_or(SystemTime::UNIX_EPOCH), id, path, metadata.len()));
    }
    files.sort_by(|a, b| b.cmp(a));
    files.truncate(MAX_ENTRIES);
    files
}

/// The document that a file holds by its name.
fn id(path: &Path) -> Option<u64> {
    path.file_name()?.to_str()?.strip_suffix(".ron")?.parse().ok()
}

/// Removes a session's folder with its lock, but not if there are documents left in it.
pub(super) fn clear(folder: &Path, lock: Option<File>) -> Result<(), FilesError> {
    let entries = fs::read_dir(folder).map_err(|source| FilesError::Read { path: folder.to_path_buf(), source })?;
    let mut is_empty = true;
    for path in entries.flatten().map(|entry| entry.path()) {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        if name == LOCK {
            continue;
        }
        // Of a writing that was cut off.
        if name.starts_with('.') && name.ends_with(".tmp") {
            remove(&path)?;
        } else {
            is_empty = false;
        }
    }
    if is_empty {
        remove(&folder.join(LOCK))?;
        // While it is open, some systems keep the name, and the folder is not empty.
        drop(lock);
        // Another process may have looked into it just now, and clears it itself.
        let _ = fs::remove_dir(folder);
    }
    Ok(())
}

fn remove(path: &Path) -> Result<(), FilesError> {
    match fs::remove_file(path) {
        Err(source) if source.kind() != ErrorKind::NotFound => Err(FilesError::Write { path: path.to_path_buf(), source }),
        _ => Ok(()),
    }
}
