//! A folder of materials as a library: what is in it, searching it, small pictures of it, and edits of many files at once.
//!
//! Nothing here blocks a window: the folder is scanned and pictures are loaded and made on threads; [`Library::poll`] collects what is there.
//! What is known is kept in the cache folder, so that opening a library again reads only what has changed ([`index`]).

pub mod check;
pub mod edit;
pub mod entry;
pub mod export;
pub mod index;
pub mod maker;
pub mod marks;
pub mod pack;
pub mod pictures;
pub mod query;
mod queue;
pub mod scan;
mod scanner;
pub mod setup;
pub mod sheet;
pub mod shelf;
pub mod snapshot;
pub mod walk;

pub use entry::Entry;
pub use query::Query;
pub use shelf::State;

use crate::digest::Digest;
use crate::places::Places;
use crate::thumbnails::Thumbnail;
use export::{Order, Product};
use index::Index;
use marks::Marks;
use pictures::{Making, Pictures, Wake};
use query::Facts;
use scan::Progress;
use scanner::{Message, Scanner};
use setup::Setup;
use shelf::Shelf;
use snapshot::Snapshot;
use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::sync::{Arc, Mutex};

/// Why a library cannot be used. Shown to the user as it is.
#[derive(Debug)]
pub enum LibraryError {
    /// Its folder is not there, is none, or cannot be read.
    Folder {
        /// The folder.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
}

impl fmt::Display for LibraryError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self::Folder { path, source } = self;
        write!(f, "{}: expected a folder that can be read: {source}", path.display())
    }
}

impl std::error::Error for LibraryError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        let Self::Folder { source, .. } = self;
        Some(source)
    }
}

/// Where the program keeps what belongs to one library. `None` where the platform has no such folder: it is then not kept.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LibraryPlaces {
    /// The index.
    pub index: Option<PathBuf>,
    /// Folder of small pictures.
    pub pictures: Option<PathBuf>,
    /// Favourites and recent files.
    pub marks: Option<PathBuf>,
}

impl LibraryPlaces {
    /// The places for the library in a folder. Two paths to one folder share them.
    pub fn of(root: &Path, places: &Places) -> Self {
        let path = std::fs::canonicalize(root).or_else(|_| std::path::absolute(root)).unwrap_or_else(|_| root.to_path_buf());
        let key = Digest::of(path.as_os_str().as_encoded_bytes()).to_string();
        let below = |folder: &Option<PathBuf>| Some(folder.as_ref()?.join("libraries").join(&key));
        let cache = below(&places.cache);
        Self {
            index: cache.as_ref().map(|folder| folder.join("index.json")),
            pictures: cache.map(|folder| folder.join("pictures")),
            marks: below(&places.state).map(|folder| folder.join("marks.ron")),
        }
    }
}

/// An open library.
pub struct Library {
    root: PathBuf,
    places: LibraryPlaces,
    /// By the order of their paths.
    entries: Vec<Arc<Entry>>,
    index: Index,
    shelf: Shelf,
    marks: Marks,
    setup: Option<Arc<Setup>>,
    pictures: Pictures,
    progress: Option<Progress>,
    problems: Vec<String>,
    revision: u64,
    is_cancelled: Arc<AtomicBool>,
    messages: Receiver<Message>,
    /// Held while the index is written: a scan that was given up may still do that.
    writing: Arc<Mutex<()>>,
    wake: Wake,
}

impl Library {
    /// Opens the library in a folder and begins to scan it. `wake` is called on other threads when there is something to [`Self::poll`].
    pub fn open(root: &Path, places: &Places, wake: impl Fn() + Send + Sync + 'static) -> Self {
        let places = LibraryPlaces::of(root, places);
        let wake: Wake = Arc::new(wake);
        let (marks, problem) = places.marks.as_deref().map_or_else(Default::default, Marks::load);
        let pictures = Pictures::new(root, places.pictures.as_deref(), wake.clone());
        let mut library = Self {
            root: root.to_path_buf(),
            places,
            entries: Vec::new(),
            index: Index::default(),
            shelf: Shelf::default(),
            marks,
            setup: None,
            pictures,
            progress: None,
            problems: problem.into_iter().collect(),
            revision: 0,
            is_cancelled: Arc::default(),
            messages: channel().1,
            writing: Arc::default(),
            wake,
        };
        library.start(true);
        library
    }

    /// Scans the folder again; only what has changed is read. A scan that is going on is given up.
    pub fn rescan(&mut self) {
        self.cancel();
        self.start(false);
    }

    /// Gives up scanning; what was found stays.
    pub fn cancel(&mut self) {
        self.is_cancelled.store(true, Ordering::Relaxed);
        self.progress = None;
    }

    fn start(&mut self, is_first: bool) {
        let (sender, messages) = channel();
        self.messages = messages;
        self.is_cancelled = Arc::default();
        self.progress = Some(Progress::default());
        let scanner = Scanner {
            root: self.root.clone(),
            places: self.places.clone(),
            old: (!is_first).then(|| self.index.clone()),
            needs_setup: self.setup.is_none(),
            is_cancelled: self.is_cancelled.clone(),
            sender,
            writing: self.writing.clone(),
            wake: self.wake.clone(),
        };
        if let Err(error) = std::thread::Builder::new().name("library".to_owned()).spawn(move || scanner.run()) {
            self.progress = None;
            self.problems
                .push(format!("{}: cannot be searched, because the system has no more threads: {error}", self.root.display()));
        }
    }

    /// Takes what the threads have found and made. True if there is something new.
    pub fn poll(&mut self) -> bool {
        let mut is_new = false;
        loop {
            let message = match self.messages.try_recv() {
                Ok(message) => message,
                Err(TryRecvError::Disconnected) if self.progress.take().is_some() => {
                    let problem = format!("{}: could not be searched, because the program failed at it", self.root.display());
                    Message::Problem(problem)
                }
                Err(_) => break,
            };
            is_new = true;
            match message {
                Message::Known(index, shelf) => {
                    self.shelf.take(shelf);
                    self.entries.clone_from(&index.entries);
                    self.index = index;
                    self.revision += 1;
                }
                Message::Setup(setup) => self.setup = Some(setup),
                Message::Progress(progress) => self.progress = Some(progress),
                Message::Entries(entries) => {
                    self.entries = entries;
                    self.revision += 1;
                }
                Message::Done(Ok(scanned)) => {
                    self.progress = None;
                    self.problems.extend(scanned.problems);
                    self.entries.clone_from(&scanned.index.entries);
                    self.index = scanned.index;
                    self.revision += 1;
                }
                // What is known stays in sight: a drive may come back.
                Message::Done(Err(error)) => {
                    self.progress = None;
                    self.problems.push(error.to_string());
                }
                Message::Problem(sentence) => self.problems.push(sentence),
            }
        }
        self.pictures.poll(&mut self.shelf, &mut self.problems) || is_new
    }

    /// The library's folder.
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// What is known of the files, by the order of their paths. Numbers of entries hold until [`Self::revision`] changes.
    pub fn entries(&self) -> &[Arc<Entry>] {
        &self.entries
    }

    /// Changes whenever [`Self::entries`] does.
    pub fn revision(&self) -> u64 {
        self.revision
    }

    /// How far the scan is; `None` if none is going on.
    pub fn progress(&self) -> Option<Progress> {
        self.progress
    }

    /// Sentences for the user that came up since this was asked last.
    pub fn take_problems(&mut self) -> Vec<String> {
        std::mem::take(&mut self.problems)
    }

    /// Numbers of the entries that match, by the order of their paths.
    pub fn matching(&self, query: &Query) -> Vec<usize> {
        let matches = |entry: &Entry| query.matches(entry, || self.facts(entry));
        self.entries.iter().enumerate().filter(|(_, entry)| matches(entry)).map(|(number, _)| number).collect()
    }

    fn facts(&self, entry: &Entry) -> Facts {
        Facts { state: self.state(entry), is_favourite: self.marks.is_favourite(&entry.path) }
    }

    /// Whether the small picture of an entry shows it as it is.
    pub fn state(&self, entry: &Entry) -> State {
        self.setup.as_ref().map_or(State::Missing, |setup| self.pictures.best(entry, &self.shelf, setup.digest()).0)
    }

    /// The small picture of an entry if it is in memory: the fresh one, else a draft or an older one.
    pub fn picture(&self, entry: &Entry) -> Option<&Thumbnail> {
        self.pictures.get(self.pictures.best(entry, &self.shelf, self.setup.as_ref()?.digest()).1?)
    }

    /// Tells which entries are in sight. Their pictures are loaded and, if `makes` says so, made where they are missing or stale, the quick
    /// ones first; a picture that is being made of something else is given up. To be called in each frame.
    pub fn show(&mut self, numbers: &[usize], makes: bool) {
        let Some(setup) = &self.setup else { return };
        let entries: Vec<&Arc<Entry>> = numbers.iter().filter_map(|number| self.entries.get(*number)).collect();
        self.pictures.want(&entries, &self.shelf, setup, makes);
    }

    /// Makes the pictures of all these entries that are missing or stale, after those in sight, on `threads` threads. An earlier such order is
    /// given up, with an empty one nothing else comes. [`Self::show`] has to be called on.
    pub fn make_all(&mut self, numbers: &[usize], threads: usize) {
        let Some(setup) = &self.setup else { return };
        let entries: Vec<&Arc<Entry>> = numbers.iter().filter_map(|number| self.entries.get(*number)).collect();
        self.pictures.make_all(&entries, &self.shelf, setup);
        self.pictures.set_threads(threads);
    }

    /// How far the last [`Self::make_all`] is.
    pub fn making(&self) -> &Making {
        self.pictures.making()
    }

    /// Takes other pictures from now on. Those of the old setup count as stale.
    pub fn set_setup(&mut self, setup: Arc<Setup>) {
        self.setup = Some(setup);
    }

    /// All that is known now, to be looked at on another thread; `None` in the first moments.
    pub fn snapshot(&self) -> Option<Snapshot> {
        let (root, entries, shelf) = (self.root.clone(), self.entries.clone(), self.shelf.clone());
        Some(Snapshot { root, entries, shelf, setup: self.setup.as_ref()?.digest() })
    }

    /// How pictures are taken; `None` in the first moments.
    pub fn setup(&self) -> Option<&Arc<Setup>> {
        self.setup.as_ref()
    }

    /// What makes a contact sheet or a pack of what is known by now, on any thread, rendering on `threads` threads. `None` in the first moments.
    pub fn export(&self, product: Product, threads: usize) -> Option<Order> {
        Some(Order {
            root: self.root.clone(),
            entries: self.entries.clone(),
            pictures: self.places.pictures.clone(),
            setup: self.setup.clone().filter(|_| self.progress.is_none())?,
            threads,
            product,
        })
    }

    /// Favourites and recent files.
    pub fn marks(&self) -> &Marks {
        &self.marks
    }

    /// Changes favourites or recent files, and keeps them on disk. What cannot be kept is among the problems.
    pub fn change_marks(&mut self, change: impl FnOnce(&mut Marks)) {
        let before = self.marks.clone();
        change(&mut self.marks);
        if let Some(path) = self.places.marks.as_ref().filter(|_| self.marks != before)
            && let Err(error) = self.marks.save(path)
        {
            self.problems.push(error.to_string());
        }
    }

    /// Bytes of memory that entries and pictures take, about.
    pub fn memory_bytes(&self) -> usize {
        self.entries.iter().map(|entry| entry.memory_bytes()).sum::<usize>() + self.pictures.memory_bytes()
    }
}

impl Drop for Library {
    fn drop(&mut self) {
        self.cancel();
    }
}
