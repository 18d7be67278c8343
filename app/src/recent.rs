//! Files that were opened last, as `recent.ron` in the state folder.

use crate::files::FilesError;
use crate::own_files;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::thread;

/// How many files are remembered.
pub const MAX_RECENT: usize = 20;

const FILE: &str = "recent.ron";

/// Files opened or saved last, newest first, each once. Those that are missing stay: a drive may come back.
#[derive(Default)]
pub struct Recent {
    paths: Vec<PathBuf>,
    missing: BTreeSet<PathBuf>,
    looking: Option<Receiver<BTreeSet<PathBuf>>>,
}

impl Recent {
    /// What the state folder remembers, and sentences for the user; a broken file is set aside and counts as empty.
    pub fn load(folder: &Path) -> (Self, Vec<String>) {
        let (paths, message) = own_files::load(&folder.join(FILE), own_files::MAX_BYTES, |text| {
            ron::from_str::<Vec<PathBuf>>(text).map_err(|error| format!("expected a list of files: {error}"))
        });
        let mut recent = Self::default();
        for path in paths.unwrap_or_default().iter().take(MAX_RECENT).rev() {
            recent.add(path);
        }
        (recent, message.into_iter().collect())
    }

    /// Saves the list, without names that are not Unicode: RON has no way to write them.
    pub fn save(&self, folder: &Path) -> Result<(), FilesError> {
        let path = folder.join(FILE);
        let names: Vec<&str> = self.paths.iter().filter_map(|path| path.to_str()).collect();
        let text = ron::ser::to_string_pretty(&names, ron::ser::PrettyConfig::new())
            .map_err(|error| FilesError::Write { path: path.clone(), source: std::io::Error::other(error) })?;
        own_files::save(&path, &text)
    }

    /// Puts a file at the front, wherever it was. A relative path counts from the current folder.
    pub fn add(&mut self, path: &Path) {
        let path = absolute(path);
        self.paths.retain(|other| *other != path);
        self.missing.remove(&path);
        self.paths.insert(0, path);
        self.paths.truncate(MAX_RECENT);
    }

    /// Forgets one file.
    pub fn remove(&mut self, path: &Path) {
        let path = absolute(path);
        self.paths.retain(|other| *other != path);
    }

    /// Forgets all files.
    pub fn clear(&mut self) {
        self.paths.clear();
    }

    /// The files, newest first.
    pub fn paths(&self) -> &[PathBuf] {
        &self.paths
    }

    /// Starts to find out which files are missing, and calls `wake` when that is known; nothing while that goes on.
    ///
    /// It happens on another thread: a network drive that is gone answers after minutes.
    pub fn look(&mut self, wake: impl FnOnce() + Send + 'static) {
        self.receive();
        if self.looking.is_some() {
            return;
        }
        let (sender, receiver) = channel();
        let paths = self.paths.clone();
        let looks = move || {
            let missing = paths.into_iter().filter(|path| !path.is_file()).collect();
            // Nobody listens after the window has closed.
            let _ = sender.send(missing);
            wake();
        };
        if thread::Builder::new().name("recent".into()).spawn(looks).is_ok() {
            self.looking = Some(receiver);
        }
    }

    /// Whether this file was missing at the last [`look`](Self::look); `false` before the first.
    pub fn is_missing(&mut self, path: &Path) -> bool {
        self.receive();
        self.missing.contains(path)
    }

    fn receive(&mut self) {
        match self.looking.as_ref().map(Receiver::try_recv) {
            None | Some(Err(TryRecvError::Empty)) => return,
            Some(Ok(missing)) => self.missing = missing,
            Some(Err(TryRecvError::Disconnected)) => {}
        }
        self.looking = None;
    }
}

/// Without asking the file system, which may take long and would follow links that the user knows by name.
fn absolute(path: &Path) -> PathBuf {
    std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn the_newest_comes_first_and_none_twice() {
        let folder = tempfile::tempdir().unwrap();
        let (mut recent, messages) = Recent::load(folder.path());
        assert!(messages.is_empty() && recent.paths().is_empty());
        for index in 0..30 {
            recent.add(&folder.path().join(format!("{}.ron", index % 25)));
        }
        assert_eq!(recent.paths().len(), MAX_RECENT);
        assert!(recent.paths()[0].ends_with("4.ron") && recent.paths()[5].ends_with("24.ron"), "{:?}", recent.paths());
        recent.remove(&folder.path().join("24.ron"));
        recent.save(folder.path()).unwrap();
        let (again, messages) = Recent::load(folder.path());
        assert!(messages.is_empty(), "{messages:?}");
        assert!(again.paths() == recent.paths() && again.paths().len() == MAX_RECENT - 1);
        recent.clear();
        recent.save(folder.path()).unwrap();
        assert!(Recent::load(folder.path()).0.paths().is_empty());
    }

    #[test]
    fn missing_files_are_flagged_and_kept() {
        let folder = tempfile::tempdir().unwrap();
        let (here, gone) = (folder.path().join("here.ron"), folder.path().join("gone.ron"));
        fs::write(&here, "").unwrap();
        let mut recent = Recent::default();
        recent.add(&here);
        recent.add(&gone);
        assert!(!recent.is_missing(&gone), "not known yet");
        let (sender, receiver) = channel();
        recent.look(move || sender.send(()).unwrap());
        receiver.recv().unwrap();
        assert!(recent.is_missing(&gone) && !recent.is_missing(&here));
        assert_eq!(recent.paths(), [gone.clone(), here]);
        recent.add(&gone);
        assert!(!recent.is_missing(&gone), "it was just opened");
    }

    #[test]
    fn a_broken_list_is_set_aside() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join(FILE), "[\"a\", 3").unwrap();
        let (recent, messages) = Recent::load(folder.path());
        assert!(recent.paths().is_empty());
        assert!(messages.len() == 1 && messages[0].contains("recent.broken-1.ron"), "{messages:?}");
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_name_that_is_no_text_does_not_keep_the_others_from_being_saved() {
        use std::os::unix::ffi::OsStrExt;
        let folder = tempfile::tempdir().unwrap();
        let mut recent = Recent::default();
        recent.add(Path::new("/tmp/plain.ron"));
        recent.add(Path::new(std::ffi::OsStr::from_bytes(b"/tmp/\xff.ron")));
        recent.save(folder.path()).unwrap();
        assert_eq!(Recent::load(folder.path()).0.paths(), [Path::new("/tmp/plain.ron")]);
    }
}
