//! Small pictures of materials on disk, named by what they show: `LOOK-SETUP.png`, both as 32 digits.
//!
//! So pictures that several machines made lie side by side in one folder after a plain copy, and one that is there is never made again.

use super::entry::Entry;
use crate::digest::Digest;
use crate::files::{FilesError, save_atomic};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// Bytes of pictures of materials that are gone or look different now, which are kept: an undo brings them back.
pub const MAX_ORPHAN_BYTES: u64 = 256 << 20;

/// Whether the small picture of a material shows it as it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum State {
    /// It does.
    Fresh,
    /// There is one that was made in a moment, small and coarse, and is not kept on disk; the full one is still to come.
    Draft,
    /// There is one of how the material looked before, or one in another mesh, light, size or quality.
    Stale,
    /// There is none.
    Missing,
}

impl State {
    /// All states with their words.
    pub const ALL: [(Self, &'static str); 4] =
        [(Self::Fresh, "fresh"), (Self::Draft, "draft"), (Self::Stale, "stale"), (Self::Missing, "missing")];

    /// The word for machines and searches.
    pub fn word(self) -> &'static str {
        Self::ALL[self as usize].1
    }

    /// The state that a word means.
    pub fn from_word(word: &str) -> Option<Self> {
        Self::ALL.iter().find(|(_, text)| *text == word).map(|(state, _)| *state)
    }
}

/// A folder of pictures, and which are in it.
#[derive(Clone, Debug, Default)]
pub struct Shelf {
    folder: PathBuf,
    /// Setups by look.
    pictures: BTreeMap<Digest, BTreeSet<Digest>>,
}

impl Shelf {
    /// Looks which pictures a folder holds; none if it is not there.
    pub fn open(folder: &Path) -> Self {
        let mut shelf = Self::empty(folder);
        for (name, _) in files(folder) {
            if let Some((look, setup)) = parse(&name) {
                shelf.pictures.entry(look).or_default().insert(setup);
            }
        }
        shelf
    }

    /// A folder of which nothing is known yet, to write into.
    pub fn empty(folder: &Path) -> Self {
        Self { folder: folder.to_path_buf(), pictures: BTreeMap::new() }
    }

    /// Adds what somebody else knows of the same folder, or changes to that one.
    pub fn take(&mut self, other: Self) {
        self.folder = other.folder;
        for (look, setups) in other.pictures {
            self.pictures.entry(look).or_default().extend(setups);
        }
    }

    /// Where a picture lies or would lie.
    pub fn path(&self, look: Digest, setup: Digest) -> PathBuf {
        self.folder.join(format!("{look}-{setup}.png"))
    }

    /// Whether there is a picture of a look in any setup.
    pub fn has_any(&self, look: Digest) -> bool {
        self.pictures.contains_key(&look)
    }

    /// How well the picture of an entry shows it in a setup; never a draft.
    pub fn state(&self, entry: &Entry, setup: Digest) -> State {
        match self.best(entry, setup) {
            Some(best) if best == (entry.look, setup) => State::Fresh,
            Some(_) => State::Stale,
            None => State::Missing,
        }
    }

    /// Look and setup of the picture to show for an entry: the fresh one, else one in another setup, else one of how it looked before.
    pub fn best(&self, entry: &Entry, setup: Digest) -> Option<(Digest, Digest)> {
        let of = |look: Digest| {
            let setups = self.pictures.get(&look)?;
            let setup = setups.get(&setup).or_else(|| setups.first())?;
            Some((look, *setup))
        };
        if entry.problem.is_some() {
            return None;
        }
        of(entry.look).or_else(|| of(entry.previous?))
    }

    /// Writes a picture whole or not at all.
    pub fn put(&mut self, look: Digest, setup: Digest, png: &[u8]) -> Result<PathBuf, FilesError> {
        let path = self.path(look, setup);
        fs::create_dir_all(&self.folder).map_err(|source| FilesError::Write { path: self.folder.clone(), source })?;
        save_atomic(&path, png)?;
        self.note(look, setup);
        Ok(path)
    }

    /// Takes note of a picture that somebody else has written.
    pub fn note(&mut self, look: Digest, setup: Digest) {
        self.pictures.entry(look).or_default().insert(setup);
    }

    /// An error if a file of this many bytes cannot be written now. Minutes of rendering are not to end in a full disk.
    pub fn probe(&self, bytes: usize) -> Result<(), FilesError> {
        let failed = |source| FilesError::Write { path: self.folder.clone(), source };
        fs::create_dir_all(&self.folder).map_err(failed)?;
        let path = self.folder.join(format!(".probe-{}", std::process::id()));
        let written = fs::write(&path, vec![0; bytes]).map_err(failed);
        let _ = fs::remove_file(&path);
        written
    }

    /// Deletes pictures that none of the entries can show, the oldest first, until those left take `max_bytes` at most. Returns how many.
    pub fn clean<'a>(&mut self, entries: impl Iterator<Item = &'a Entry>, max_bytes: u64) -> usize {
        let wanted: BTreeSet<Digest> = entries.flat_map(|entry| [Some(entry.look), entry.previous]).flatten().collect();
        let mut orphans: Vec<(SystemTime, u64, PathBuf, (Digest, Digest))> = Vec::new();
        for (name, path) in files(&self.folder) {
            let Some(key) = parse(&name).filter(|(look, _)| !wanted.contains(look)) else { continue };
            if let Ok(metadata) = fs::metadata(&path) {
                orphans.push((metadata.modified().unwrap_or(SystemTime::UNIX_EPOCH), metadata.len(), path, key));
            }
        }
        orphans.sort();
        let mut left: u64 = orphans.iter().map(|(_, size, ..)| size).sum();
        let mut deleted = 0;
        for (_, size, path, (look, setup)) in orphans {
            if left <= max_bytes {
                break;
            }
            if fs::remove_file(path).is_ok() {
                left -= size;
                deleted += 1;
                if let Some(setups) = self.pictures.get_mut(&look) {
                    setups.remove(&setup);
                    if setups.is_empty() {
                        self.pictures.remove(&look);
                    }
                }
            }
        }
        deleted
    }
}

/// Names and paths in a folder.
fn files(folder: &Path) -> impl Iterator<Item = (String, PathBuf)> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    entries.filter_map(|entry| Some((entry.file_name().into_string().ok()?, entry.path())))
}

fn parse(name: &str) -> Option<(Digest, Digest)> {
    let (look, setup) = name.strip_suffix(".png")?.split_once('-')?;
    Some((Digest::parse(look)?, Digest::parse(setup)?))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entry(look: &[u8], previous: Option<&[u8]>) -> Entry {
        let mut entry = Entry::unusable(Path::new("any.asm.ron"), String::new());
        (entry.problem, entry.look, entry.previous) = (None, Digest::of(look), previous.map(Digest::of));
        entry
    }

    #[test]
    fn pictures_are_fresh_stale_or_missing() {
        let folder = tempfile::tempdir().unwrap();
        let shelf_folder = folder.path().join("pictures");
        let (setup, other) = (Digest::of(b"setup"), Digest::of(b"other"));
        let mut shelf = Shelf::open(&shelf_folder);
        let now = entry(b"now", Some(b"before"));
        assert_eq!(shelf.state(&now, setup), State::Missing);
        shelf.put(Digest::of(b"before"), setup, b"png").unwrap();
        assert_eq!(shelf.state(&now, setup), State::Stale);
        shelf.put(Digest::of(b"now"), other, b"png").unwrap();
        assert_eq!(shelf.best(&now, setup), Some((now.look, other)));
        let path = shelf.put(Digest::of(b"now"), setup, b"png").unwrap();
        fs::write(shelf_folder.join("note-x.png"), "").unwrap();
        for shelf in [&shelf, &Shelf::open(&shelf_folder)] {
            assert_eq!(shelf.state(&now, setup), State::Fresh);
            assert_eq!(shelf.path(now.look, setup), path);
        }
        let mut broken = now;
        broken.problem = Some("none".to_owned());
        assert_eq!(shelf.state(&broken, setup), State::Missing);
    }

    #[test]
    fn only_old_pictures_that_nothing_shows_are_deleted() {
        let folder = tempfile::tempdir().unwrap();
        let mut shelf = Shelf::open(folder.path());
        let setup = Digest::of(b"setup");
        for (age, name) in ["a", "b", "c", "kept", "before"].into_iter().enumerate() {
            let path = shelf.put(Digest::of(name.as_bytes()), setup, &[0; 100]).unwrap();
            let time = SystemTime::UNIX_EPOCH + std::time::Duration::from_secs(1000 + age as u64);
            fs::File::options().write(true).open(path).unwrap().set_modified(time).unwrap();
        }
        let kept = entry(b"kept", Some(b"before"));
        assert_eq!(shelf.clean([&kept].into_iter(), 150), 2);
        let has =
            |name: &str| shelf.path(Digest::of(name.as_bytes()), setup).exists() && shelf.has_any(Digest::of(name.as_bytes()));
        assert_eq!(["a", "b", "c", "kept", "before"].map(has), [false, false, true, true, true]);
    }

    #[test]
    fn a_folder_that_cannot_be_written_is_told() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("file"), "").unwrap();
        let mut shelf = Shelf::open(&folder.path().join("file"));
        for error in [shelf.probe(1).unwrap_err(), shelf.put(Digest::default(), Digest::default(), b"x").unwrap_err()] {
            assert!(error.to_string().contains("file: cannot be written"), "{error}");
        }
    }
}
