//! What a library knows of its files, kept on disk so that only what has changed is read again.

use super::entry::Entry;
use super::walk::Stamp;
use crate::digest::{Digest, Digesting};
use crate::files::FilesError;
use crate::own_files;
use burnish_material::{LOBES, PROPERTIES};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Raised whenever an entry means something else than before.
const VERSION: u32 = 2;
/// Larger files are none of ours.
const MAX_BYTES: u64 = 1 << 30;

/// Entries by path, and the hashes of images by their place on disk.
#[derive(Clone, Debug, Default)]
pub struct Index {
    /// By the order of their paths.
    pub entries: Vec<Arc<Entry>>,
    /// Images that entries name.
    pub images: BTreeMap<PathBuf, ImageHash>,
}

/// The hash of an image's bytes when it had this stamp; `None` where it could not be read.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ImageHash {
    /// Size and time.
    pub stamp: Stamp,
    /// Hash of its bytes.
    pub digest: Option<Digest>,
}

/// The file.
#[derive(Serialize, Deserialize)]
struct IndexFile<E, I> {
    version: u32,
    /// Entries number the rows of tables, so other tables make another index.
    tables: Digest,
    entries: Vec<E>,
    images: Vec<I>,
}

impl Index {
    /// What the file at `path` holds, as long as it is one of this version; otherwise an empty index, which costs a whole scan and no word.
    pub fn load(path: &Path, root: &Path) -> Self {
        let bytes =
            fs::metadata(path).ok().filter(|found| found.is_file() && found.len() <= MAX_BYTES).and_then(|_| fs::read(path).ok());
        let read = |bytes: Vec<u8>| serde_json::from_slice::<IndexFile<Entry, (PathBuf, ImageHash)>>(&bytes).ok();
        let Some(file) = bytes.and_then(read).filter(|file| file.version == VERSION && file.tables == tables()) else {
            return Self::default();
        };
        let images = file.images.into_iter().collect();
        let mut entries: Vec<Arc<Entry>> =
            file.entries.into_iter().map(|entry| Arc::new(with_images(entry.completed(), root, &images))).collect();
        entries.sort_by(|a, b| a.path.cmp(&b.path));
        Self { entries, images }
    }

    /// Writes the file whole or not at all, with its folder. Paths that are not Unicode are left out: they are read again each time.
    pub fn save(&self, path: &Path) -> Result<(), FilesError> {
        let entries: Vec<&Entry> = self.entries.iter().map(Arc::as_ref).filter(|entry| entry.path.to_str().is_some()).collect();
        let images: Vec<(&PathBuf, &ImageHash)> = self.images.iter().filter(|(path, _)| path.to_str().is_some()).collect();
        let text = serde_json::to_string(&IndexFile { version: VERSION, tables: tables(), entries, images })
            .map_err(|error| FilesError::Write { path: path.to_path_buf(), source: error.into() })?;
        own_files::save(path, &text)
    }

    /// The entry of a path.
    pub fn find(&self, path: &Path) -> Option<&Arc<Entry>> {
        self.entries.binary_search_by(|entry| entry.path.as_path().cmp(path)).ok().map(|at| &self.entries[at])
    }
}

/// The entry with the hashes of its images.
pub(super) fn with_images(mut entry: Entry, root: &Path, images: &BTreeMap<PathBuf, ImageHash>) -> Entry {
    let places = image_places(root, &entry);
    let hashes: Vec<_> = places.iter().map(|place| images.get(place).and_then(|image| image.digest)).collect();
    entry.set_images(&hashes);
    entry
}

/// Where the images of an entry lie that are files, in the order in which it names them.
pub(super) fn image_places(root: &Path, entry: &Entry) -> Vec<PathBuf> {
    let file = root.join(&entry.path);
    entry.textures.iter().filter_map(|texture| crate::files::texture_path(texture, file.parent())).collect()
}

fn tables() -> Digest {
    let mut all = Digesting::default();
    PROPERTIES.iter().for_each(|def| _ = all.text(def.name));
    LOBES.iter().for_each(|def| _ = all.text(def.name));
    all.end()
}
