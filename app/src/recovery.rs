//! Unsaved work on disk: what is left of it after a crash, a killed process or a power failure is offered at the next start.
//!
//! Every process has a folder of its own, `recovery/PROCESS-TIME` below the state folder, and in it one file per unsaved
//! document and a `lock` that the system holds for as long as the process lives. A folder whose lock is free was left
//! behind. Documents are written by a thread, each whole or not at all.

mod left;
#[cfg(test)]
mod tests;
mod writer;

pub use left::{Abandoned, left_behind};

use crate::files::FilesError;
use serde::{Deserialize, Serialize};
use std::fs::{self, File, OpenOptions};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, SystemTime, UNIX_EPOCH};
use writer::{Request, Writer};

/// Name of the folder below the state folder.
const FOLDER: &str = "recovery";
/// Name of the file whose lock tells whether the process lives.
const LOCK: &str = "lock";

/// An unsaved document.
#[derive(Clone, Debug, PartialEq)]
pub struct Kept {
    /// Tells the documents of one process apart.
    pub id: u64,
    /// Its file, if it has one. One whose name is not Unicode comes back without it: RON has no way to write that.
    pub path: Option<PathBuf>,
    /// The file of another format that it came from, with the images that it brought along. One whose name is not Unicode is forgotten.
    pub import: Option<PathBuf>,
    /// What the user calls it.
    pub title: String,
    /// The material file as it would be saved now.
    pub text: String,
    /// The material file as it was opened or saved last.
    pub original: String,
    /// When the text was like this, in whole seconds once it comes back.
    pub when: SystemTime,
}

/// A document as its file holds it.
#[derive(Serialize, Deserialize)]
struct Stored {
    /// Seconds since 1970.
    when: u64,
    path: Option<String>,
    #[serde(default)]
    import: Option<String>,
    title: String,
    text: String,
    original: String,
}

impl Kept {
    fn to_ron(&self) -> Result<String, ron::Error> {
        let text_of = |path: &Option<PathBuf>| path.as_ref().and_then(|path| path.to_str()).map(str::to_owned);
        let stored = Stored {
            when: self.when.duration_since(UNIX_EPOCH).unwrap_or_default().as_secs(),
            path: text_of(&self.path),
            import: text_of(&self.import),
            title: self.title.clone(),
            text: self.text.clone(),
            original: self.original.clone(),
        };
        // Readable as it stands, should somebody have to rescue it by hand.
        ron::ser::to_string_pretty(&stored, ron::ser::PrettyConfig::new().escape_strings(false))
    }

    fn from_ron(id: u64, text: &str) -> Result<Self, String> {
        let stored: Stored = ron::from_str(text).map_err(|error| format!("expected an unsaved document: {error}"))?;
        let when = UNIX_EPOCH.checked_add(Duration::from_secs(stored.when)).unwrap_or(UNIX_EPOCH);
        let [path, import] = [stored.path, stored.import].map(|path| path.map(PathBuf::from));
        Ok(Self { id, path, import, title: stored.title, text: stored.text, original: stored.original, when })
    }

    /// Whether both would be restored to the same, but for the time.
    fn is_like(&self, other: &Self) -> bool {
        let places = (&self.path, &self.import) == (&other.path, &other.import);
        places && (&self.title, &self.text, &self.original) == (&other.title, &other.text, &other.original)
    }
}

/// The recovery store of this process.
///
/// Dropping it leaves what is unsaved on disk, to be offered at the next start; only [`close`](Self::close) removes it.
pub struct Store {
    folder: PathBuf,
    /// `None` once no more is to come.
    sender: Option<Sender<Request>>,
    writer: Option<JoinHandle<()>>,
    problem: Arc<Mutex<Option<String>>>,
    /// Held until the writer has ended.
    lock: Option<File>,
}

impl Store {
    /// Makes this process's folder below the state folder `state` and takes its lock.
    pub fn open(state: &Path) -> Result<Self, FilesError> {
        let (folder, lock) = make_session(&state.join(FOLDER))?;
        let problem = Arc::new(Mutex::new(None));
        let (sender, receiver) = channel();
        let mut writer = Writer::new(folder.clone(), problem.clone());
        let runs = thread::Builder::new().name("recovery".into()).spawn(move || writer.run(&receiver));
        let writer = runs.map_err(|source| FilesError::Write { path: folder.clone(), source })?;
        Ok(Self { folder, sender: Some(sender), writer: Some(writer), problem, lock: Some(lock) })
    }

    /// Makes the store hold these documents and no others, soon: another thread writes those that have changed.
    pub fn write(&self, documents: Vec<Kept>) {
        self.send(Request::Write(documents, None));
    }

    /// Makes the store hold these documents, which include those taken over from `abandoned`, and once they are written
    /// discards `abandoned`. So at every moment one of the two has them.
    pub fn adopt(&self, documents: Vec<Kept>, abandoned: Abandoned) {
        self.send(Request::Write(documents, Some(abandoned)));
    }

    /// Waits until everything handed over is on disk.
    ///
    /// Fails with a sentence if the last writing did.
    pub fn flush(&self) -> Result<(), String> {
        let (sender, receiver) = channel();
        self.send(Request::Flush(sender));
        receiver.recv().unwrap_or_else(|_| Err(format!("{}: nobody writes unsaved changes any more", self.folder.display())))
    }

    /// Why unsaved changes could not be written, once per reason: a sentence for the user.
    pub fn problem(&self) -> Option<String> {
        self.problem.lock().unwrap_or_else(PoisonError::into_inner).take()
    }

    /// Removes what was kept: the program ends in order, and whatever is still unsaved is not wanted.
    pub fn close(mut self) -> Result<(), FilesError> {
        self.send(Request::Write(Vec::new(), None));
        self.finish();
        left::clear(&self.folder, self.lock.take())
    }

    fn send(&self, request: Request) {
        if let Some(sender) = &self.sender {
            // Without a writer, `flush` says so.
            let _ = sender.send(request);
        }
    }

    fn finish(&mut self) {
        self.sender = None;
        if let Some(writer) = self.writer.take() {
            let _ = writer.join();
        }
    }
}

impl Drop for Store {
    fn drop(&mut self) {
        self.finish();
    }
}

/// Makes a folder that no other process has, with its lock.
fn make_session(recovery: &Path) -> Result<(PathBuf, File), FilesError> {
    fs::create_dir_all(recovery).map_err(|source| FilesError::Write { path: recovery.to_path_buf(), source })?;
    let nanos = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default().as_nanos();
    let mut problem = None;
    for attempt in 0..16 {
        let folder = recovery.join(format!("{}-{}", std::process::id(), nanos + attempt));
        match fs::create_dir(&folder).and_then(|()| take_lock(&folder, true)) {
            Ok(Some(lock)) => {
                // So that the folder outlives a power failure; not every system lets one be synced.
                let _ = File::open(recovery).and_then(|recovery| recovery.sync_all());
                return Ok((folder, lock));
            }
            // Another process, which starts at this moment, has taken it for left behind.
            Ok(None) => {}
            Err(error) => problem = Some(FilesError::Write { path: folder, source: error }),
        }
    }
    Err(problem.unwrap_or_else(|| FilesError::Write {
        path: recovery.to_path_buf(),
        source: std::io::Error::from(std::io::ErrorKind::WouldBlock),
    }))
}

/// The lock of a session's folder; `None` if another process has it, or has removed it meanwhile.
fn take_lock(folder: &Path, is_made: bool) -> std::io::Result<Option<File>> {
    let path = folder.join(LOCK);
    let lock = OpenOptions::new().read(true).write(true).create(is_made).truncate(false).open(&path)?;
    match lock.try_lock() {
        // A lock on a file without a name would tell nobody anything.
        Ok(()) => Ok(path.exists().then_some(lock)),
        Err(fs::TryLockError::WouldBlock) => Ok(None),
        Err(fs::TryLockError::Error(error)) => Err(error),
    }
}
