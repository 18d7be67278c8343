//! Bringing an index up to date with the folder: only files that have changed are read, on all threads that are given.

use super::LibraryError;
use super::entry::Entry;
use super::index::{ImageHash, Index, image_places, with_images};
use super::walk::{Found, Stamp, walk};
use crate::digest::{Digest, Digesting};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

/// Entries that are told of at once.
const BATCH: usize = 64;
/// Of larger images only the size counts: no renderer reads them.
const MAX_IMAGE_BYTES: u64 = 2 << 30;

/// The next number to work on.
type Next<'a> = dyn Fn() -> Option<usize> + 'a;

/// How far a scan is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Progress {
    /// Files and images that were read.
    pub done: usize,
    /// Those that are to be read; 0 while the folder is searched.
    pub total: usize,
}

/// What a scan tells on its way.
pub enum Event {
    /// How far it is.
    Progress(Progress),
    /// Some entries that are new or have changed; their images may not be hashed yet.
    Read(Vec<Arc<Entry>>),
}

/// What a scan came to.
#[derive(Clone, Debug, Default)]
pub struct Scanned {
    /// The index as it is now.
    pub index: Index,
    /// Material files that were read.
    pub read: usize,
    /// Images that were read.
    pub images_read: usize,
    /// Folders that could not be read, a sentence each.
    pub problems: Vec<String>,
    /// Whether the index differs from the old one.
    pub is_changed: bool,
    /// Whether it was not cancelled. What was not looked at is then as it was in the old index.
    pub is_whole: bool,
}

/// How a scan works.
pub struct Scan<'a> {
    /// The library's folder.
    pub root: &'a Path,
    /// What is known.
    pub old: &'a Index,
    /// Threads that read; 0 counts as 1.
    pub threads: usize,
    /// Whether there is a small picture of this look, see [`Entry::previous`].
    pub has_picture: &'a (dyn Fn(Digest) -> bool + Sync),
    /// Asked between files.
    pub is_cancelled: &'a (dyn Fn() -> bool + Sync),
    /// Told on several threads.
    pub tell: &'a (dyn Fn(Event) + Sync),
}

impl Scan<'_> {
    /// Scans the folder. An error only if it is not there or cannot be read.
    pub fn run(&self) -> Result<Scanned, LibraryError> {
        (self.tell)(Event::Progress(Progress::default()));
        let found = walk(self.root, self.is_cancelled)
            .map_err(|source| LibraryError::Folder { path: self.root.to_path_buf(), source })?;
        if (self.is_cancelled)() {
            return Ok(Scanned { index: self.old.clone(), ..Scanned::default() });
        }
        let mut entries: Vec<Arc<Entry>> = Vec::with_capacity(found.files.len());
        let mut changed: Vec<&Found> = Vec::new();
        for file in &found.files {
            match self.old.find(&file.path).filter(|old| file.stamp.is_like(old.stamp)) {
                Some(old) => entries.push(old.clone()),
                None => changed.push(file),
            }
        }
        let read = self.read(&changed);
        let read_count = read.len();
        let is_done: BTreeSet<&Path> = read.iter().map(|entry| entry.path.as_path()).collect();
        let left = changed.iter().filter(|file| !is_done.contains(file.path.as_path()));
        entries.extend(left.filter_map(|file| self.old.find(&file.path)).cloned());
        entries.extend(read.iter().cloned());
        entries.extend(found.no_files.into_iter().map(|(path, problem)| Arc::new(Entry::unusable(&path, problem))));
        entries.sort_by(|a, b| a.path.cmp(&b.path));

        let (images, images_read) = self.images(&entries, read_count);
        entries.iter_mut().for_each(|entry| self.complete(entry, &images));
        let is_same = |(a, b): (&Arc<Entry>, &Arc<Entry>)| Arc::ptr_eq(a, b) || a == b;
        let is_changed = entries.len() != self.old.entries.len()
            || images != self.old.images
            || !entries.iter().zip(&self.old.entries).all(is_same);
        let index = Index { entries, images };
        Ok(Scanned {
            index,
            read: read_count,
            images_read,
            problems: found.problems,
            is_changed,
            is_whole: !(self.is_cancelled)(),
        })
    }

    /// Reads files, in no particular order; not all of them if it is cancelled.
    fn read(&self, files: &[&Found]) -> Vec<Arc<Entry>> {
        let read = Mutex::new(Vec::with_capacity(files.len()));
        let pass_on = |batch: &mut Vec<Arc<Entry>>| {
            let mut read = read.lock().unwrap_or_else(PoisonError::into_inner);
            read.extend(batch.iter().cloned());
            (self.tell)(Event::Progress(Progress { done: read.len(), total: files.len() }));
            drop(read);
            (self.tell)(Event::Read(std::mem::take(batch)));
        };
        self.on_threads(files.len(), &|next| {
            let mut batch = Vec::new();
            while let Some(file) = next().and_then(|at| files.get(at)) {
                let entry = Entry::read(self.root, file);
                batch.push(Arc::new(with_images(entry, self.root, &self.old.images)));
                if batch.len() == BATCH {
                    pass_on(&mut batch);
                }
            }
            if !batch.is_empty() {
                pass_on(&mut batch);
            }
        });
        read.into_inner().unwrap_or_else(PoisonError::into_inner)
    }

    /// The hashes of all images that entries name, and how many had to be read for that.
    fn images(&self, entries: &[Arc<Entry>], before: usize) -> (BTreeMap<PathBuf, ImageHash>, usize) {
        let places: BTreeSet<PathBuf> = entries.iter().flat_map(|entry| image_places(self.root, entry)).collect();
        let places: Vec<PathBuf> = places.into_iter().collect();
        let images = Mutex::new(BTreeMap::new());
        let read = AtomicUsize::new(0);
        self.on_threads(places.len(), &|next| {
            while let Some(place) = next().and_then(|at| places.get(at)) {
                let old = self.old.images.get(place);
                let image = match (image_stamp(place), old) {
                    (Some(stamp), Some(old)) if stamp.is_like(old.stamp) && old.digest.is_some() => *old,
                    (Some(stamp), _) => {
                        let done = before + read.fetch_add(1, Ordering::Relaxed);
                        (self.tell)(Event::Progress(Progress { done, total: before + places.len() }));
                        ImageHash { stamp: stamp.settled(), digest: self.image_hash(place, stamp.size) }
                    }
                    (None, _) => ImageHash { stamp: Stamp::default(), digest: None },
                };
                // A hash that was broken off is worth nothing.
                if !(self.is_cancelled)() {
                    images.lock().unwrap_or_else(PoisonError::into_inner).insert(place.clone(), image);
                }
            }
        });
        let mut images = images.into_inner().unwrap_or_else(PoisonError::into_inner);
        if (self.is_cancelled)() {
            self.old.images.iter().for_each(|(place, image)| _ = images.entry(place.clone()).or_insert(*image));
        }
        (images, read.into_inner())
    }

    /// The hash of a file's bytes; `None` if it cannot be read or the scan is cancelled.
    fn image_hash(&self, place: &Path, size: u64) -> Option<Digest> {
        if size > MAX_IMAGE_BYTES {
            return Some(Digesting::default().whole(&[size]).end());
        }
        Digest::of_file(place, &|| !(self.is_cancelled)()).ok()?
    }

    /// Sets the hashes that depend on images, and what looked different before.
    fn complete(&self, entry: &mut Arc<Entry>, images: &BTreeMap<PathBuf, ImageHash>) {
        let old = self.old.find(&entry.path);
        let is_known = old.is_some_and(|old| Arc::ptr_eq(old, entry));
        if is_known && entry.textures.is_empty() {
            return;
        }
        let mut new = with_images((**entry).clone(), self.root, images);
        if let Some(old) = old {
            let is_replaced = old.look != new.look && (self.has_picture)(old.look);
            new.previous = if is_replaced { Some(old.look) } else { old.previous };
        }
        if **entry != new {
            *entry = Arc::new(new);
        }
    }

    /// Calls `work` on each thread with a source of numbers below `count`, which ends when all are given out or the scan is cancelled.
    fn on_threads(&self, count: usize, work: &(dyn Fn(&Next<'_>) + Sync)) {
        let given = AtomicUsize::new(0);
        let next = || Some(given.fetch_add(1, Ordering::Relaxed)).filter(|at| *at < count && !(self.is_cancelled)());
        let threads = self.threads.clamp(1, count.max(1));
        std::thread::scope(|scope| {
            for _ in 1..threads {
                // Where the system has no more threads, this one does all.
                _ = std::thread::Builder::new().name("library".to_owned()).spawn_scoped(scope, || work(&next));
            }
            work(&next);
        });
    }
}

fn image_stamp(place: &Path) -> Option<Stamp> {
    fs::metadata(place).ok().filter(fs::Metadata::is_file).map(|metadata| Stamp::of(&metadata))
}
