//! The thread that scans a library for a window.

use super::entry::Entry;
use super::index::Index;
use super::pictures::Wake;
use super::scan::{Event, Progress, Scan, Scanned};
use super::setup::{Frame, Setup, Stage};
use super::shelf::Shelf;
use super::{LibraryError, LibraryPlaces};
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::Sender;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Time between two sights of a library that is being read.
const SHOWN_EVERY: Duration = Duration::from_millis(250);

/// What the scanning thread tells.
pub(super) enum Message {
    /// What was known before.
    Known(Index, Shelf),
    /// How pictures are taken at first.
    Setup(Arc<Setup>),
    /// How far it is.
    Progress(Progress),
    /// What is known by now, by the order of paths.
    Entries(Vec<Arc<Entry>>),
    /// All there is, or why nothing can be known.
    Done(Result<Scanned, LibraryError>),
    /// A sentence for the user.
    Problem(String),
}

/// The scanning thread.
pub(super) struct Scanner {
    /// The library's folder.
    pub root: PathBuf,
    /// Where its index and pictures lie.
    pub places: LibraryPlaces,
    /// What is known; `None` if it is on disk.
    pub old: Option<Index>,
    /// Whether the setup is to be made, too.
    pub needs_setup: bool,
    /// Ends the scan.
    pub is_cancelled: Arc<AtomicBool>,
    /// Who listens.
    pub sender: Sender<Message>,
    /// Held while the index is written.
    pub writing: Arc<Mutex<()>>,
    /// Wakes who listens.
    pub wake: Wake,
}

impl Scanner {
    /// Scans, tells, and keeps what is known.
    pub fn run(self) {
        let shelf = self.places.pictures.as_deref().map_or_else(Shelf::default, Shelf::open);
        let load = || self.places.index.as_deref().map_or_else(Index::default, |path| Index::load(path, &self.root));
        let old = self.old.clone().unwrap_or_else(load);
        self.tell(Message::Known(old.clone(), shelf.clone()));
        if self.needs_setup
            && let Some(stage) = Stage::standard()
        {
            self.tell(Message::Setup(Arc::new(Setup::new(stage, Frame::default(), Vec::new()))));
        }
        let in_sight = Mutex::new(InSight { entries: old.entries.clone(), read: Vec::new(), shown: None });
        let scan = Scan {
            root: &self.root,
            old: &old,
            threads: std::thread::available_parallelism().map_or(1, std::num::NonZero::get),
            has_picture: &|look| shelf.has_any(look),
            is_cancelled: &|| self.is_cancelled.load(Ordering::Relaxed),
            tell: &|event| match event {
                Event::Progress(progress) => self.tell(Message::Progress(progress)),
                Event::Read(entries) => {
                    let now = in_sight.lock().unwrap_or_else(PoisonError::into_inner).add(entries);
                    now.into_iter().for_each(|entries| self.tell(Message::Entries(entries)));
                }
            },
        };
        let scanned = scan.run();
        if let (Ok(scanned), Some(path)) = (&scanned, &self.places.index)
            && scanned.is_changed
        {
            let writing = self.writing.lock().unwrap_or_else(PoisonError::into_inner);
            if let Err(error) = scanned.index.save(path) {
                self.tell(Message::Problem(error.to_string()));
            }
            drop(writing);
        }
        self.tell(Message::Done(scanned));
    }

    fn tell(&self, message: Message) {
        // Nobody listens after the library was closed or is scanned anew.
        if self.sender.send(message).is_ok() {
            (self.wake)();
        }
    }
}

/// What a window sees while files are read.
struct InSight {
    /// By the order of their paths.
    entries: Vec<Arc<Entry>>,
    /// Those that are to be put among them.
    read: Vec<Arc<Entry>>,
    /// When it was shown last.
    shown: Option<Instant>,
}

impl InSight {
    /// Adds entries. Some times a second returns all there are; sorting them is nothing for the thread of the window.
    fn add(&mut self, read: Vec<Arc<Entry>>) -> Option<Vec<Arc<Entry>>> {
        self.read.extend(read);
        if self.shown.is_some_and(|shown| shown.elapsed() < SHOWN_EVERY) {
            return None;
        }
        let known = self.entries.len();
        for entry in self.read.drain(..) {
            match self.entries[..known].binary_search_by(|other| other.path.cmp(&entry.path)) {
                Ok(at) => self.entries[at] = entry,
                Err(_) => self.entries.push(entry),
            }
        }
        self.entries.sort_by(|a, b| a.path.cmp(&b.path));
        self.shown = Some(Instant::now());
        Some(self.entries.clone())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn entries_come_into_sight_in_order_and_replace_older_ones() {
        let entry = |path: &str, problem: &str| Arc::new(Entry::unusable(Path::new(path), problem.to_owned()));
        let mut in_sight = InSight { entries: vec![entry("b", "old"), entry("d", "old")], read: Vec::new(), shown: None };
        let shown = in_sight.add(vec![entry("c", "new"), entry("b", "new")]).unwrap();
        let plain = |entries: &[Arc<Entry>]| -> Vec<(String, String)> {
            entries.iter().map(|entry| (entry.name.clone(), entry.problem.clone().unwrap_or_default())).collect()
        };
        let pair = |name: &str, problem: &str| (name.to_owned(), problem.to_owned());
        assert_eq!(plain(&shown), [pair("b", "new"), pair("c", "new"), pair("d", "old")]);
        assert!(in_sight.add(vec![entry("a", "new")]).is_none(), "a moment ago");
        in_sight.shown = None;
        assert_eq!(in_sight.add(Vec::new()).unwrap().len(), 4);
    }
}
