//! Small pictures for a window: loaded from disk and made on two threads, kept in memory up to a bound.

#[cfg(test)]
mod tests;

use super::entry::Entry;
use super::queue::Queue;
use super::setup::{self, DEFAULT_SECONDS, DRAFT_SECONDS, Setup};
use super::shelf::{Shelf, State};
use crate::digest::Digest;
use crate::thumbnails::Thumbnail;
use burnish_renderer::path::{Prepared, StopReason};
use image::ImageReader;
use std::collections::{HashMap, HashSet, VecDeque};
use std::io::Cursor;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

/// Bytes of pictures in memory; those that were out of sight longest go first.
pub const MAX_BYTES: usize = 128 << 20;
/// Larger files are none of ours.
const MAX_FILE_BYTES: u64 = 64 << 20;
/// Wider or higher pictures are not shown.
const MAX_SIDE: u32 = 2048;

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

/// A picture to make.
#[derive(Clone)]
struct Order {
    entry: Arc<Entry>,
    setup: Arc<Setup>,
    /// Whether a better one follows: this one is made to have something to look at, and not kept on disk.
    is_draft: bool,
}

/// Pictures in memory, and those that will be.
pub struct Pictures {
    made: HashMap<Key, Thumbnail>,
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
        let (may_make, made) = (Arc::<Mutex<HashSet<Digest>>>::default(), HashSet::new());
        // One thread unless somebody says otherwise: what is edited comes first.
        let threads = Arc::new(AtomicUsize::new(1));
        let maker = Maker {
            root: root.to_path_buf(),
            shelf,
            queue: makes.clone(),
            may_make: may_make.clone(),
            threads: threads.clone(),
            made,
            sender,
            wake,
        };
        // Without a thread nothing comes, which shows as pictures that are missing.
        _ = std::thread::Builder::new().name("library pictures".to_owned()).spawn(move || loader.run());
        _ = std::thread::Builder::new().name("library renderer".to_owned()).spawn(move || maker.run());
        Self {
            made: HashMap::new(),
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

    /// Bytes of the pictures in memory.
    pub fn memory_bytes(&self) -> usize {
        self.bytes
    }

    /// Orders the pictures of entries that are in sight, instead of what was ordered before: drafts of looks that there is no picture of,
    /// then all that are not fresh.
    pub fn want(&mut self, entries: &[&Arc<Entry>], shelf: &Shelf, setup: &Arc<Setup>, makes: bool) {
        let digest = setup.digest();
        let shown: Vec<Key> = entries.iter().filter_map(|entry| shelf.best(entry, digest)).collect();
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
            let order = |entry: &&&Arc<Entry>, setup: &Arc<Setup>, is_draft| Order {
                entry: (**entry).clone(),
                setup: setup.clone(),
                is_draft,
            };
            let draft = Arc::new(setup.draft());
            let mut orders: VecDeque<Order> =
                in_sight.iter().filter(|entry| !shelf.has_any(entry.look)).map(|entry| order(entry, &draft, true)).collect();
            orders.extend(in_sight.iter().map(|entry| order(entry, setup, false)));
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
            .map(|entry| Order { entry: (*entry).clone(), setup: setup.clone(), is_draft: false })
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
            match done {
                Done::Loaded(key, Some(thumbnail)) => self.keep(key, thumbnail),
                Done::Loaded(key, None) => _ = self.failed.insert(key),
                Done::Made(new) => {
                    let New { key, path, thumbnail, is_limited, is_draft, problem } = *new;
                    shelf.note(key.0, key.1);
                    self.failed.remove(&key);
                    self.keep(key, thumbnail);
                    if is_draft {
                        continue;
                    }
                    if is_limited {
                        self.making.limited.push(path);
                    }
                    // A disk that is full would say the same for each picture.
                    problems.extend(problem.filter(|problem| !problems.contains(problem)));
                    self.count(key.0);
                }
                Done::Failed(look, sentence) => {
                    self.hopeless.insert(look);
                    self.count(look);
                    problems.push(sentence);
                }
            }
        }
        is_new
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
            && let Some(oldest) = self.order.pop_front()
        {
            self.bytes -= self.made.remove(&oldest).map_or(0, |old| old.rgba.len());
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

struct Loader {
    shelf: Option<Shelf>,
    queue: Arc<Queue<Key>>,
    sender: Sender<Done>,
    wake: Wake,
}

impl Loader {
    fn run(self) {
        while let Some(key) = self.queue.next() {
            let path = self.shelf.as_ref().map(|shelf| shelf.path(key.0, key.1));
            if self.sender.send(Done::Loaded(key, path.and_then(|path| load(&path)))).is_err() {
                return;
            }
            (self.wake)();
        }
    }
}

struct Maker {
    root: PathBuf,
    shelf: Option<Shelf>,
    queue: Arc<Queue<Order>>,
    may_make: Arc<Mutex<HashSet<Digest>>>,
    threads: Arc<AtomicUsize>,
    /// What was made: it may be ordered again before that is known there.
    made: HashSet<Key>,
    sender: Sender<Done>,
    wake: Wake,
}

impl Maker {
    fn run(mut self) {
        // Pictures that follow each other share tables of their light.
        let mut last: Option<Prepared> = None;
        while let Some(order) = self.queue.next() {
            let place = self.root.join(&order.entry.path);
            let made = setup::guarded(|| self.make(&order, &mut last));
            let failed = |problem: String| Some(Done::Failed(order.entry.look, format!("{}: {problem}", place.display())));
            let done = made.unwrap_or_else(failed);
            if let Some(done) = done {
                if self.sender.send(done).is_err() {
                    return;
                }
                (self.wake)();
            }
        }
    }

    /// Makes and keeps a picture; `None` if it is not wanted any more.
    fn make(&mut self, order: &Order, last: &mut Option<Prepared>) -> Result<Option<Done>, String> {
        let Order { entry, setup, is_draft } = order;
        let is_wanted = || self.may_make.lock().unwrap_or_else(PoisonError::into_inner).contains(&entry.look);
        let key = (entry.look, setup.digest());
        if self.made.contains(&key) || !is_wanted() {
            return Ok(None);
        }
        let (material, textures, _) = setup::read(&self.root, entry)?;
        let scene = setup.scene_of(material, textures);
        let threads = self.threads.load(Ordering::Relaxed);
        let seconds = if *is_draft { DRAFT_SECONDS } else { DEFAULT_SECONDS };
        let Some(made) = setup.render(&scene, last, seconds, threads, &mut |_| is_wanted())? else { return Ok(None) };
        self.made.insert(key);
        let kept = self.shelf.as_mut().filter(|_| !is_draft).map(|shelf| shelf.put(key.0, key.1, &made.png));
        let problem = kept.and_then(|kept| kept.err().map(|error| error.to_string()));
        let frame = setup.frame();
        let rgba = made.rgb.as_chunks::<3>().0.iter().flat_map(|[r, g, b]| [*r, *g, *b, 255]).collect();
        let thumbnail = Thumbnail { width: frame.width as u32, height: frame.height as u32, rgba };
        let is_limited = made.stop_reason == StopReason::Time;
        Ok(Some(Done::Made(Box::new(New { key, path: entry.path.clone(), thumbnail, is_limited, is_draft: *is_draft, problem }))))
    }
}

/// A picture from disk; `None` if it cannot be used.
pub(super) fn load(path: &Path) -> Option<Thumbnail> {
    if std::fs::metadata(path).ok()?.len() > MAX_FILE_BYTES {
        return None;
    }
    let mut reader = ImageReader::new(Cursor::new(std::fs::read(path).ok()?)).with_guessed_format().ok()?;
    let mut limits = image::Limits::default();
    (limits.max_image_width, limits.max_image_height) = (Some(MAX_SIDE), Some(MAX_SIDE));
    reader.limits(limits);
    let picture = reader.decode().ok()?.into_rgba8();
    Some(Thumbnail { width: picture.width(), height: picture.height(), rgba: picture.into_raw() })
}
