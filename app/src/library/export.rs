//! Contact sheets and packs of an open library, made on another thread while the window goes on.

use super::check::{Options, Shelved, check_library};
use super::entry::Entry;
use super::maker::{Limits, Maker};
use super::pack::{self, Formats, Pack};
use super::scan::Progress;
use super::setup::{DEFAULT_SECONDS, Setup};
use super::sheet::{Sheet, is_page};
use super::shelf::{Shelf, State};
use crate::files::save_atomic;
use burnish_material::Severity;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// What is made.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Product {
    /// A contact sheet, as page or as picture by the ending of the file.
    Sheet(PathBuf),
    /// A pack in a folder of its own, with the materials in other formats.
    Pack(PathBuf, Formats),
}

/// A library as it is when something is made of it.
pub struct Order {
    pub(super) root: PathBuf,
    pub(super) entries: Vec<Arc<Entry>>,
    /// Where its small pictures lie; without, none are made.
    pub(super) pictures: Option<PathBuf>,
    pub(super) setup: Arc<Setup>,
    pub(super) threads: usize,
    pub(super) product: Product,
}

/// What became of it: a sentence and warnings, `None` if it was cancelled, or why it could not be made.
pub type Outcome = Result<Option<(String, Vec<String>)>, String>;

impl Order {
    /// Makes it. `tell` hears what is being done and how much of that is done; after a yes of `is_cancelled` it ends, and the pictures that were
    /// made are kept.
    pub fn run(&self, tell: &pack::Tell<'_>, is_cancelled: &(dyn Fn() -> bool + Sync)) -> Outcome {
        let mut shelf = self.pictures.as_deref().map_or_else(Shelf::default, Shelf::open);
        if let Product::Pack(target, _) = &self.product {
            pack::refuse(target, &self.root).map_err(|error| error.to_string())?;
            if !self.is_sound(&shelf, tell, is_cancelled)? {
                return Ok(None);
            }
        }
        let mut warnings = Vec::new();
        if !self.make_pictures(&mut shelf, &mut warnings, tell, is_cancelled) {
            return Ok(None);
        }
        let name = self.root.file_name().unwrap_or(self.root.as_os_str()).to_string_lossy();
        let sentence = match &self.product {
            Product::Sheet(path) => self.sheet(path, &name, &shelf, &mut warnings, (tell, is_cancelled))?,
            Product::Pack(target, formats) => {
                let (root, setup) = (self.root.as_path(), self.setup.digest());
                let (entries, threads, formats) = (&self.entries, self.threads, *formats);
                let pack = Pack { name: &name, root, entries, shelf: &shelf, setup, threads, formats };
                let packed = pack.write(target, tell, is_cancelled).map_err(|error| error.to_string())?;
                packed.map(|packed| {
                    warnings.extend(packed.warnings);
                    let pack::Packed { materials, images, files, .. } = packed;
                    format!("Packed {}: materials {materials}, images {images}, files {files}", target.display())
                })
            }
        };
        Ok(sentence.map(|sentence| (sentence, warnings)))
    }

    /// An error if the library has errors; false if it was cancelled.
    fn is_sound(&self, shelf: &Shelf, tell: &pack::Tell<'_>, is_cancelled: &(dyn Fn() -> bool + Sync)) -> Result<bool, String> {
        let library = Shelved { root: &self.root, entries: &self.entries, shelf, setup: self.setup.digest() };
        let options = Options { threads: self.threads, ..Options::default() };
        let checked = check_library(&library, &options, &|progress| tell("Checking", progress), is_cancelled);
        let Some(checked) = checked else { return Ok(false) };
        match checked.rows.iter().find(|row| row.severity == Severity::Error) {
            None => Ok(true),
            Some(row) => {
                let key = if row.key.is_empty() { String::new() } else { format!("{}: ", row.key) };
                let (count, path, message) = (checked.errors, row.path.display(), &row.message);
                Err(format!("not packed, because the check finds errors ({count}); the first: {path}: {key}{message}"))
            }
        }
    }

    /// Makes the pictures that are missing or stale; false if it was cancelled. Materials that cannot be drawn go without.
    fn make_pictures(
        &self,
        shelf: &mut Shelf,
        warnings: &mut Vec<String>,
        tell: &pack::Tell<'_>,
        is_cancelled: &(dyn Fn() -> bool + Sync),
    ) -> bool {
        let needs = |entry: &&Arc<Entry>| entry.problem.is_none() && shelf.state(entry, self.setup.digest()) != State::Fresh;
        let entries: Vec<Arc<Entry>> = self.entries.iter().filter(needs).filter(|_| self.pictures.is_some()).cloned().collect();
        let mut maker = Maker::new(&self.root, &self.setup, Limits { seconds: DEFAULT_SECONDS, threads: self.threads });
        for (done, entry) in entries.iter().enumerate() {
            tell("Small pictures", Progress { done, total: entries.len() });
            // Two materials may look the same.
            if shelf.state(entry, self.setup.digest()) == State::Fresh {
                continue;
            }
            match maker.make(entry, shelf, &mut |_| !is_cancelled()) {
                Ok(Some(_)) => {}
                Ok(None) => return false,
                Err(problem) => warnings.push(format!("{}: {problem}", entry.path.display())),
            }
        }
        !is_cancelled()
    }

    fn sheet(
        &self,
        path: &Path,
        name: &str,
        shelf: &Shelf,
        warnings: &mut Vec<String>,
        (tell, is_cancelled): (&pack::Tell<'_>, &(dyn Fn() -> bool + Sync)),
    ) -> Result<Option<String>, String> {
        let (sheet, problems) = Sheet::of(name, &self.root, &self.entries, shelf, self.setup.digest());
        warnings.extend(problems);
        let total = sheet.cards().len();
        let mut go_on = |done| {
            tell("Contact sheet", Progress { done, total });
            !is_cancelled()
        };
        let bytes = sheet.bytes(path, &mut go_on).map_err(|error| format!("{}: {error}", path.display()))?;
        let Some(bytes) = bytes else { return Ok(None) };
        save_atomic(path, &bytes).map_err(|error| error.to_string())?;
        let boxes = if is_page(path) { 0 } else { sheet.names_with_boxes() };
        if boxes > 0 {
            warnings.push(format!("{boxes} names have letters that the font of the PNG lacks; a page (.html) shows them"));
        }
        Ok(Some(format!("Wrote {}: {total} materials", path.display())))
    }
}
