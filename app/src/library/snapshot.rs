//! A library as it is at one moment, to be looked at on another thread.

use super::check::Shelved;
use super::entry::Entry;
use super::index::Index;
use super::scan::{Event, Progress, Scan};
use super::shelf::Shelf;
use super::{LibraryError, LibraryPlaces};
use crate::digest::Digest;
use crate::places::Places;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Files, small pictures, and how those are taken.
#[derive(Clone, Debug)]
pub struct Snapshot {
    /// The library's folder.
    pub root: PathBuf,
    /// Its files, by the order of their paths.
    pub entries: Vec<Arc<Entry>>,
    /// Its small pictures.
    pub shelf: Shelf,
    /// How they are taken.
    pub setup: Digest,
}

impl Snapshot {
    /// Reads the library in a folder, as much of it as has changed since it was read last. `None` if it is cancelled.
    pub fn read(
        root: &Path,
        places: &Places,
        setup: Digest,
        threads: usize,
        progress: &(dyn Fn(Progress) + Sync),
        is_cancelled: &(dyn Fn() -> bool + Sync),
    ) -> Result<Option<Self>, LibraryError> {
        let places = LibraryPlaces::of(root, places);
        let shelf = places.pictures.as_deref().map_or_else(Shelf::default, Shelf::open);
        let old = places.index.as_deref().map_or_else(Index::default, |path| Index::load(path, root));
        let tell = |event| {
            if let Event::Progress(now) = event {
                progress(now);
            }
        };
        let scan = Scan { root, old: &old, threads, has_picture: &|look| shelf.has_any(look), is_cancelled, tell: &tell };
        let scanned = scan.run()?;
        let entries = scanned.index.entries;
        Ok(scanned.is_whole.then(|| Self { root: root.to_path_buf(), entries, shelf, setup }))
    }

    /// The same for checks and comparisons.
    pub fn shelved(&self) -> Shelved<'_> {
        Shelved { root: &self.root, entries: &self.entries, shelf: &self.shelf, setup: self.setup }
    }
}
