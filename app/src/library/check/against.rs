//! What became of a library since an earlier release of it.

use super::super::entry::Entry;
use super::super::scan::Progress;
use super::super::setup::{self, Frame, Setup, Stage};
use super::look::ALIKE;
use super::threads::Kept;
use super::{Look, Options, Shelved, map};
use crate::files;
use burnish_material::diff::{Change, file_changes};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Whether a file shows another picture than before.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LookChange {
    /// It does not: nothing visible was changed, or the pictures are this close.
    Same(f64),
    /// Its picture is this far from the earlier one, see [`Look::distance`].
    Changed(f64),
    /// One of the two has no fresh small picture.
    Unknown,
}

/// A file that is in both libraries and not the same.
#[derive(Clone, Debug, PartialEq)]
pub struct Changed {
    /// Relative to both folders.
    pub path: PathBuf,
    /// Entries that differ, `a` before and `b` now. Empty where only the spelling, comments or pixels of images do.
    pub changes: Vec<Change>,
    /// Whether values, textures or the images themselves differ.
    pub is_by_value: bool,
    /// Whether it looks different.
    pub look: LookChange,
    /// Why it could not be compared, as a sentence with the path.
    pub problem: Option<String>,
}

/// What became of a library.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Against {
    /// Files that are only in the new library.
    pub added: Vec<PathBuf>,
    /// Files that are only in the old library.
    pub removed: Vec<PathBuf>,
    /// Files that differ, by the order of their paths.
    pub changed: Vec<Changed>,
    /// Files with the same bytes and the same images.
    pub unchanged: usize,
}

/// Compares a library with an earlier one, file by file of the same path. `None` if it is cancelled.
pub fn compare(
    old: &Shelved<'_>,
    new: &Shelved<'_>,
    options: &Options,
    progress: &(dyn Fn(Progress) + Sync),
    is_cancelled: &(dyn Fn() -> bool + Sync),
) -> Option<Against> {
    let mut against = Against::default();
    let find = |side: &Shelved<'_>, path: &Path| -> Option<usize> {
        side.entries.binary_search_by(|entry| entry.path.as_path().cmp(path)).ok()
    };
    let mut differing: Vec<(&Arc<Entry>, &Arc<Entry>)> = Vec::new();
    for entry in new.entries {
        match find(old, &entry.path).map(|at| &old.entries[at]) {
            None => against.added.push(entry.path.clone()),
            Some(before) if before.content == entry.content && before.problem == entry.problem => against.unchanged += 1,
            Some(before) => differing.push((before, entry)),
        }
    }
    let is_gone = |entry: &&Arc<Entry>| find(new, &entry.path).is_none();
    against.removed = old.entries.iter().filter(is_gone).map(|entry| entry.path.clone()).collect();
    let stage = options.renders_looks.then(Stage::standard).flatten();
    let setup = stage.map(|stage| Setup::new(stage, Frame::default(), Vec::new()));
    against.changed = map(differing.len(), options.threads, progress, is_cancelled, |kept, at| {
        let (before, after) = differing[at];
        let mut look = |side: &Shelved<'_>, entry: &Entry| match &setup {
            Some(setup) => rendered(setup, side.root, entry, kept, is_cancelled),
            None => side.look(entry),
        };
        changed([(old, before.as_ref()), (new, after.as_ref())], &mut look)
    })?;
    Some(against)
}

/// The picture of an entry, rendered; `None` if it cannot be.
fn rendered(
    setup: &Setup,
    root: &Path,
    entry: &Entry,
    kept: &mut Kept,
    is_cancelled: &(dyn Fn() -> bool + Sync),
) -> Option<Look> {
    let (material, textures, _) = setup::read(root, entry).ok()?;
    Look::render(&setup.scene_of(material, textures), &mut kept.look, is_cancelled)
}

fn changed(sides: [(&Shelved<'_>, &Entry); 2], look: &mut dyn FnMut(&Shelved<'_>, &Entry) -> Option<Look>) -> Changed {
    let [(_, before), (_, after)] = sides;
    let read = |(side, entry): (&Shelved<'_>, &Entry)| {
        files::read_material(&side.root.join(&entry.path)).map(|(file, _)| file).map_err(|error| error.to_string())
    };
    let (changes, problem) = match (read(sides[0]), read(sides[1])) {
        (Ok(a), Ok(b)) => (file_changes(&a, &b), None),
        (Err(problem), _) | (_, Err(problem)) => (Vec::new(), Some(problem)),
    };
    let is_by_value = before.look != after.look || before.problem.is_some() != after.problem.is_some();
    let look = match is_by_value.then(|| Some((look(sides[0].0, before)?, look(sides[1].0, after)?))) {
        None => LookChange::Same(0.0),
        Some(None) => LookChange::Unknown,
        Some(Some((a, b))) => match a.distance(&b) {
            distance if distance <= ALIKE => LookChange::Same(distance),
            distance => LookChange::Changed(distance),
        },
    };
    Changed { path: after.path.clone(), changes, is_by_value, look, problem }
}
