//! Small pictures for a window: loaded from disk and made on two threads, kept in memory up to a bound.

mod loader;
mod renderer;
mod slices;
#[cfg(test)]
mod tests;

pub use loader::load;

use super::entry::Entry;
use super::maker::Renderer;
use super::queue::Queue;
use super::setup::{CHANGED, Setup};
use super::shelf::{Shelf, State};
use crate::digest::Digest;
use crate::thumbnails::Thumbnail;
use loader::Loader;
use renderer::PictureThread;
use slices::{SLICES, Slices};
use std::collections::{HashMap, HashSet, VecDeque};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

/// Bytes of pictures in memory; those that were out of sight longest go first.
pub const MAX_BYTES: usize = 128 << 20;

/// Look and setup.
pub type Key = (Digest, Digest);
/// Wakes the window from another thread.
pub type Wake = Arc<dyn Fn() + Send + Sync>;

/// What the threads send back.
enum Done {
    /// A picture from disk; `None` if it cannot be used.
    Loaded(Key, Option<Thumbnail>),
    /// A picture that was made.
    Made(Box<New>),
    /// Why there is no picture, with the entry's look.
    Failed(Digest, String),
}

/// A picture that was made.
struct New {
    key: Key,
    /// Whose picture it is.
    path: PathBuf,
    thumbnail: Thumbnail,
    /// Whether the time limit ended it.
    is_limited: bool,
    /// Whether a better one follows.
    is_draft: bool,
    /// Why it is not on disk.
    problem: Option<String>,
}

/// Pictures that were ordered at once.
#[derive(Clone, Debug, Default)]
pub struct Making {
    /// Those that are made, or cannot be.
    pub done: usize,
    /// All of them; 0 before any were ordered.
    pub total: usize,
    /// Seconds until all are done, if the others take as long as those that are; `None` before the first is.
    pub seconds_left: Option<f64>,
    /// Materials whose pictures the time limit ended.
    pub limited: Vec<PathBuf>,
}

/// What a picture is made for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Purpose {
    /// To have something to look at before the real one; it is not kept on disk.
    Draft,
    /// To be looked at now.
    Sight,
    /// To be there later, together with many others.
    Batch,
}

/// A picture to make.
#[derive(Clone)]
struct Order {
    entry: Arc<Entry>,
    setup: Arc<Setup>,
    purpose: Purpose,
}

impl Order {
    fn key(&self) -> Key {
        (self.entry.look, self.setup.digest())
    }
}

/// Pictures in memory, and those that will be.
pub struct Pictures {
    made: HashMap<Key, Thumbnail>,
    /// Setups of the drafts in memory, by look.
    drafts: HashMap<Digest, Digest>,
    /// Keys of `made`, longest out of sight first.
    order: VecDeque<Key>,
    bytes: usize,
    /// What was in sight and what was ordered last, so that the same orders are given once.
    shown: Vec<Key>,
    ordered: Option<Vec<Key>>,
    /// What is made when nothing in sight is left to make.
    batch: Vec<Order>,
    making: Making,
    begun: Instant,
    failed: HashSet<Key>,
    hopeless: HashSet<Digest>,
    loads: Arc<Queue<Key>>,
    makes: Arc<Queue<Order>>,
    /// Looks that may be made at present.
    may_make: Arc<Mutex<HashSet<Digest>>>,
    threads: Arc<AtomicUsize>,
    results: Receiver<Done>,
}

impl Pictures {
    /// Starts the threads. Without a folder, pictures are made and not kept.
    pub fn new(root: &Path, folder: Option<&Path>, wake: Wake) -> Self {
        let (sender, results) = channel();
        let (loads, makes): (Arc<Queue<Key>>, Arc<Queue<Order>>) = Default::default();
        let shelf = folder.map(Shelf::empty);
        let loader = Loader { shelf: shelf.clone(), queue: loads.clone(), sender: sender.clone(), wake: wake.clone() };
        let may_make = Arc::<Mutex<HashSet<Digest>>>::default();
        // One thread unless somebody says otherwise: what is edited comes first.
        let threads = Arc::new(AtomicUsize::new(1));
        let maker = PictureThread {
            renderer: Renderer::new(root),
            shelf,
            queue: makes.clone(),
            may_make: may_make.clone(),
            threads: threads.clone(),
            made: HashSet::new(),
            slices: Slices::new(SLICES, slices::MAX_BYTES),
            sender,
            wake,
        };
        // Without a thread nothing comes, which shows as pictures that are missing.
        _ = std::thread::Builder::new().name("library pictures".to_owned()).spawn(move || loader.run());
        _ = std::thread::Builder::new().name("library renderer".to_owned()).spawn(move || maker.run());
        Self {
            made: HashMap::new(),
            drafts: HashMap::new(),
            order: VecDeque::new(),
            bytes: 0,
            shown: Vec::new(),
            ordered: None,
            batch: Vec::new(),
            making: Making::default(),
            begun: Instant::now(),
            failed: HashSet::new(),
            hopeless: HashSet::new(),
            loads,
            makes,
            may_make,
            threads,
            results,
        }
    }

    /// A picture that is in memory.
    pub fn get(&self, key: Key) -> Option<&Thumbnail> {
        self.made.get(&key)
    }

    /// How well the picture of an entry shows it in a setup, and which picture that is: the fresh one, else one in another setup, else a draft, else
    /// one of how it looked before.
    pub fn best(&self, entry: &Entry, shelf: &Shelf, setup: Digest) -> (State, Option<Key>) {
        let kept = shelf.best(entry, setup);
        let draft = self.drafts.get(&entry.look).map(|setup| (entry.look, *setup));
        let is_of_now = kept.is_some_and(|(look, _)| look == entry.look);
        match draft.filter(|_| entry.problem.is_none() && !is_of_now) {
            Some(draft) => (State::Draft, Some(draft)),
            None => (shelf.state(entry, setup), kept),
        }
    }

    /// Bytes of the pictures in memory.
    pub fn memory_bytes(&self) -> usize {
        self.bytes
    }

    /// Orders the pictures of entries that are in sight, instead of what was ordered before: drafts of looks that there is no picture of,
    /// then all that are not fresh, in slices of time that grow, so that none waits long for others.
    pub fn want(&mut self, entries: &[&Arc<Entry>], shelf: &Shelf, setup: &Arc<Setup>, makes: bool) {
        let digest = setup.digest();
        let shown: Vec<Key> = entries.iter().filter_map(|entry| self.best(entry, shelf, digest).1).collect();
        let needs = |entry: &&&Arc<Entry>| {
            makes && entry.problem.is_none() && !self.hopeless.contains(&entry.look) && shelf.state(entry, digest) != State::Fresh
        };
        let in_sight: Vec<&&Arc<Entry>> = entries.iter().filter(needs).collect();
        if shown != self.shown {
            let is_new = |key: &&Key| !self.made.contains_key(key) && !self.failed.contains(key);
            self.loads.set(shown.iter().filter(is_new).copied().collect());
            self.shown.clone_from(&shown);
        }
        let keys: Vec<Key> = in_sight.iter().map(|entry| (entry.look, digest)).collect();
        if self.ordered.as_ref() != Some(&keys) {
            let order = |entry: &&&Arc<Entry>, setup: &Arc<Setup>, purpose| Order {
                entry: (**entry).clone(),
                setup: setup.clone(),
                purpose,
            };
            let draft = Arc::new(setup.draft());
            let has_none = |entry: &&&&Arc<Entry>| !shelf.has_any(entry.look) && !self.drafts.contains_key(&entry.look);
            let mut orders: VecDeque<Order> =
                in_sight.iter().filter(has_none).map(|entry| order(entry, &draft, Purpose::Draft)).collect();
            orders.extend(in_sight.iter().map(|entry| order(entry, setup, Purpose::Sight)));
            orders.extend(self.batch.iter().cloned());
            let looks = orders.iter().map(|order| order.entry.look).collect();
            *self.may_make.lock().unwrap_or_else(PoisonError::into_inner) = looks;
            self.makes.set(orders);
            self.ordered = Some(keys);
        }
        // What is in sight goes last.
        let in_sight: HashSet<Key> = shown.into_iter().filter(|key| self.made.contains_key(key)).collect();
        if self.bytes > MAX_BYTES / 2 {
            self.order.retain(|key| !in_sight.contains(key));
            self.order.extend(in_sight);
        }
    }

    /// Orders the pictures of all these entries that are not fresh, after those in sight, instead of the last such order.
    pub fn make_all(&mut self, entries: &[&Arc<Entry>], shelf: &Shelf, setup: &Arc<Setup>) {
        let mut looks = HashSet::new();
        let needs = |entry: &&&Arc<Entry>| entry.problem.is_none() && shelf.state(entry, setup.digest()) != State::Fresh;
        let is_first = |entry: &&&Arc<Entry>| looks.insert(entry.look);
        self.batch = entries
            .iter()
            .filter(needs)
            .filter(is_first)
            .map(|entry| Order { entry: (*entry).clone(), setup: setup.clone(), purpose: Purpose::Batch })
            .collect();
        self.making = Making { total: self.batch.len(), ..Making::default() };
        self.begun = Instant::now();
        self.hopeless.clear();
        self.ordered = None;
    }

    /// How far the last [`Self::make_all`] is.
    pub fn making(&self) -> &Making {
        &self.making
    }

    /// Renders on this many threads from the next picture on; 0 counts as 1.
    pub fn set_threads(&mut self, threads: usize) {
        self.threads.store(threads, Ordering::Relaxed);
    }

    /// Takes note that there is a picture of a look, or can be none.
    fn count(&mut self, look: Digest) {
        let before = self.batch.len();
        self.batch.retain(|order| order.entry.look != look);
        if self.batch.len() < before {
            self.making.done += 1;
            let mean = self.begun.elapsed().as_secs_f64() / self.making.done as f64;
            self.making.seconds_left = Some(mean * self.batch.len() as f64);
        }
    }

    /// Takes what was loaded and made; tells the shelf, and the user what went wrong. True if there is something new.
    pub fn poll(&mut self, shelf: &mut Shelf, problems: &mut Vec<String>) -> bool {
        let mut is_new = false;
        while let Ok(done) = self.results.try_recv() {
            is_new = true;
            self.take(done, shelf, problems);
        }
        is_new
    }

    fn take(&mut self, done: Done, shelf: &mut Shelf, problems: &mut Vec<String>) {
        match done {
            Done::Loaded(key, Some(thumbnail)) => self.keep(key, thumbnail),
            Done::Loaded(key, None) => _ = self.failed.insert(key),
            // Where the real one was made elsewhere meanwhile, its draft is of no use.
            Done::Made(new) if new.is_draft && shelf.has_any(new.key.0) => {}
            Done::Made(new) if new.is_draft => {
                self.drafts.insert(new.key.0, new.key.1);
                self.keep(new.key, new.thumbnail);
            }
            Done::Made(new) => {
                let New { key, path, thumbnail, is_limited, problem, .. } = *new;
                shelf.note(key.0, key.1);
                self.failed.remove(&key);
                self.keep(key, thumbnail);
                if let Some(setup) = self.drafts.get(&key.0) {
                    self.forget((key.0, *setup));
                }
                if is_limited {
                    self.making.limited.push(path);
                }
                // A disk that is full would say the same for each picture.
                problems.extend(problem.filter(|problem| !problems.contains(problem)));
                self.count(key.0);
            }
            // The library is read again already.
            Done::Failed(look, sentence) if sentence.ends_with(CHANGED) => self.count(look),
            Done::Failed(look, sentence) => {
                self.hopeless.insert(look);
                self.count(look);
                problems.push(sentence);
            }
        }
    }

    fn keep(&mut self, key: Key, thumbnail: Thumbnail) {
        self.bytes += thumbnail.rgba.len();
        self.order.retain(|other| *other != key);
        self.order.push_back(key);
        if let Some(old) = self.made.insert(key, thumbnail) {
            self.bytes -= old.rgba.len();
        }
        while self.bytes > MAX_BYTES
            && self.order.len() > 1
            && let Some(oldest) = self.order.front()
        {
            self.forget(*oldest);
        }
    }

    fn forget(&mut self, key: Key) {
        self.order.retain(|other| *other != key);
        self.bytes -= self.made.remove(&key).map_or(0, |old| old.rgba.len());
        if self.drafts.get(&key.0) == Some(&key.1) {
            self.drafts.remove(&key.0);
        }
    }
}

impl Drop for Pictures {
    fn drop(&mut self) {
        self.may_make.lock().unwrap_or_else(PoisonError::into_inner).clear();
        self.loads.close();
        self.makes.close();
    }
}
