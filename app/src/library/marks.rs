//! Favourites of a library and what was opened in it last. Both belong to the user and not to the files, so they lie in the state folder.

use crate::files::FilesError;
use crate::own_files;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// How many files are remembered as opened last.
pub const MAX_RECENT: usize = 50;
/// Larger files are none of ours: this is room for some ten thousand favourites.
const MAX_BYTES: u64 = 4 << 20;

/// Favourites and recent files, by paths relative to the library's folder.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Marks {
    favourites: BTreeSet<PathBuf>,
    recent: Vec<PathBuf>,
}

impl Marks {
    /// What the file holds, and a sentence if it is broken: it is set aside then, and counts as empty.
    pub fn load(path: &Path) -> (Self, Option<String>) {
        let (marks, message) = own_files::load(path, MAX_BYTES, |text| {
            ron::from_str::<Self>(text).map_err(|error| format!("expected favourites and recent files: {error}"))
        });
        (marks.unwrap_or_default(), message)
    }

    /// Writes the file, without paths that are not Unicode: RON has no way to write them.
    pub fn save(&self, path: &Path) -> Result<(), FilesError> {
        let is_text = |path: &&PathBuf| path.to_str().is_some();
        let plain = Self {
            favourites: self.favourites.iter().filter(is_text).cloned().collect(),
            recent: self.recent.iter().filter(is_text).cloned().collect(),
        };
        let text = ron::ser::to_string_pretty(&plain, ron::ser::PrettyConfig::new())
            .map_err(|error| FilesError::Write { path: path.to_path_buf(), source: std::io::Error::other(error) })?;
        own_files::save(path, &text)
    }

    /// Whether a file is a favourite.
    pub fn is_favourite(&self, path: &Path) -> bool {
        self.favourites.contains(path)
    }

    /// Makes a file a favourite, or takes that back.
    pub fn set_favourite(&mut self, path: &Path, is_favourite: bool) {
        if is_favourite {
            self.favourites.insert(path.to_path_buf());
        } else {
            self.favourites.remove(path);
        }
    }

    /// Puts a file in front of the recent ones, each once.
    pub fn opened(&mut self, path: &Path) {
        self.recent.retain(|other| other != path);
        self.recent.insert(0, path.to_path_buf());
        self.recent.truncate(MAX_RECENT);
    }

    /// The recent files, newest first. They may be gone.
    pub fn recent(&self) -> &[PathBuf] {
        &self.recent
    }

    /// A file has another name now.
    pub fn renamed(&mut self, from: &Path, to: &Path) {
        if self.favourites.remove(from) {
            self.favourites.insert(to.to_path_buf());
        }
        self.recent.iter_mut().filter(|path| *path == from).for_each(|path| *path = to.to_path_buf());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_last_and_follow_their_files() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("below/marks.ron");
        let (mut marks, problem) = Marks::load(&file);
        assert_eq!((&marks, problem), (&Marks::default(), None));
        let [gold, copper] = ["metals/gold.asm.ron", "metals/copper.asm.ron"].map(Path::new);
        for number in 0..2 * MAX_RECENT {
            marks.opened(Path::new(&number.to_string()));
        }
        marks.opened(gold);
        marks.opened(copper);
        marks.opened(gold);
        marks.set_favourite(gold, true);
        marks.set_favourite(copper, true);
        marks.set_favourite(copper, false);
        assert_eq!((marks.recent().len(), &marks.recent()[..2]), (MAX_RECENT, &[gold.to_path_buf(), copper.to_path_buf()][..]));
        marks.renamed(gold, Path::new("au.asm.ron"));
        marks.save(&file).unwrap();
        let (again, _) = Marks::load(&file);
        assert!(again == marks && again.is_favourite(Path::new("au.asm.ron")) && !again.is_favourite(gold));
        assert_eq!(again.recent()[0], Path::new("au.asm.ron"));

        std::fs::write(&file, "(favourites: 3)").unwrap();
        let (marks, problem) = Marks::load(&file);
        assert!(marks == Marks::default() && problem.is_some_and(|problem| problem.contains("marks.broken-1.ron")));
    }
}
