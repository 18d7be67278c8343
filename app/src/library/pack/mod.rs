//! A pack: what the author of a library hands out. Materials with the images that they use, the same in the formats of other programs with what
//! that costs, a contact sheet, licences, the report of the check, and a list of all files with their hashes.
//!
//! A pack is made beside its place and renamed, so it is there whole or not at all. The same library gives the same bytes.

mod content;
mod formats;
mod licences;
mod manifest;
mod place;

use super::LibraryError;
use super::check::{Options, Shelved, check_library, report};
use super::entry::Entry;
use super::index::Index;
use super::scan::{Progress, Scan};
use super::sheet::{Card, Sheet, SheetError};
use super::shelf::Shelf;
use crate::digest::Digest;
use crate::exchange::ExchangeError;
use crate::files::FilesError;
use content::Content;
pub use formats::{FORMATS, Formats};
pub use manifest::{FORMAT, MANIFEST};
use place::Place;
use std::collections::BTreeMap;
use std::fmt;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Folder of the materials in a pack.
pub const MATERIALS: &str = "materials";

/// Why there is no pack. Shown to the user as it is.
#[derive(Debug)]
pub enum PackError {
    /// Its place cannot be taken.
    Taken {
        /// The place.
        path: PathBuf,
        /// Why, and what was expected.
        reason: String,
    },
    /// A file cannot be read or written.
    Files(FilesError),
    /// A file is not any more what the library knows of it.
    Changed {
        /// The file.
        path: PathBuf,
    },
    /// What has been packed cannot be read again.
    Library(LibraryError),
    /// There is no contact sheet.
    Sheet(SheetError),
    /// A material does not go into another format.
    Exchange(ExchangeError),
}

impl fmt::Display for PackError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Taken { path, reason } => write!(f, "{}: {reason}", path.display()),
            Self::Files(error) => error.fmt(f),
            Self::Changed { path } => write!(f, "{}: was changed while it was packed; pack again", path.display()),
            Self::Library(error) => error.fmt(f),
            Self::Sheet(error) => write!(f, "contact sheet: {error}"),
            Self::Exchange(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for PackError {}

impl From<FilesError> for PackError {
    fn from(error: FilesError) -> Self {
        Self::Files(error)
    }
}

/// What is packed.
pub struct Pack<'a> {
    /// Name of the library.
    pub name: &'a str,
    /// Its folder.
    pub root: &'a Path,
    /// Its files, by the order of their paths. Those that cannot be used are left out.
    pub entries: &'a [Arc<Entry>],
    /// Its small pictures.
    pub shelf: &'a Shelf,
    /// How they were taken.
    pub setup: Digest,
    /// Threads that check; 0 counts as 1.
    pub threads: usize,
    /// In which other formats the materials are written, too.
    pub formats: Formats,
}

/// What became of it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Packed {
    /// Materials in it.
    pub materials: usize,
    /// Images in it.
    pub images: usize,
    /// All files in it.
    pub files: usize,
    /// Sentences for the user.
    pub warnings: Vec<String>,
}

/// Told of what is being done, and how far it is, from any thread.
pub type Tell<'a> = dyn Fn(&str, Progress) + Sync + 'a;

/// An error if a pack of the library in `root` cannot be put at `target`: told before minutes of work.
pub fn refuse(target: &Path, root: &Path) -> Result<(), PackError> {
    Place::find(target, root).map(|_| ())
}

impl Pack<'_> {
    /// Writes the pack. An older pack at the place is replaced; anything else there is an error. `None` if it is cancelled.
    pub fn write(
        &self,
        target: &Path,
        tell: &Tell<'_>,
        is_cancelled: &(dyn Fn() -> bool + Sync),
    ) -> Result<Option<Packed>, PackError> {
        let place = Place::find(target, self.root)?;
        let staging = place.begin()?;
        let folder = staging.path();
        let mut content = Content::new(self.root, &folder.join(MATERIALS))?;
        for (done, entry) in self.entries.iter().enumerate() {
            if is_cancelled() {
                return Ok(None);
            }
            tell("copying", Progress { done, total: self.entries.len() });
            content.add(entry)?;
        }
        let Some(entries) = self.check(folder, tell, is_cancelled)? else { return Ok(None) };
        let mut warnings = std::mem::take(&mut content.warnings);
        let Some(sheet) = self.sheet(&content, &entries, folder, &mut warnings, (tell, is_cancelled))? else { return Ok(None) };
        let written = formats::write_all(&content, folder, self.formats, &mut warnings, (tell, is_cancelled))?;
        let Some(written) = written else { return Ok(None) };
        let boxes = sheet.names_with_boxes();
        if boxes > 0 {
            warnings.push(format!("sheet.png: {boxes} names have letters that its font lacks; sheet.html shows them"));
        }
        write(&folder.join("LICENCES.md"), licences::text(self.name, &content.materials).as_bytes())?;
        let (text, files) = manifest::text(self.name, folder, &content, &entries, &written)?;
        write(&folder.join(MANIFEST), text.as_bytes())?;
        if is_cancelled() {
            return Ok(None);
        }
        staging.put()?;
        Ok(Some(Packed { materials: content.materials.len(), images: content.images(), files: files + 1, warnings }))
    }

    /// Reads and checks what was packed, and writes the report.
    fn check(
        &self,
        folder: &Path,
        tell: &Tell<'_>,
        is_cancelled: &(dyn Fn() -> bool + Sync),
    ) -> Result<Option<Vec<Arc<Entry>>>, PackError> {
        let root = folder.join(MATERIALS);
        let scan = Scan {
            root: &root,
            old: &Index::default(),
            threads: self.threads,
            has_picture: &|_| false,
            is_cancelled,
            tell: &|_| {},
        };
        let scanned = scan.run().map_err(PackError::Library)?;
        let library = Shelved { root: &root, entries: &scanned.index.entries, shelf: self.shelf, setup: self.setup };
        let options = Options { threads: self.threads, ..Options::default() };
        let progress = |progress| tell("checking", progress);
        let Some(checked) = check_library(&library, &options, &progress, is_cancelled) else { return Ok(None) };
        // The pack lies elsewhere soon: its paths begin in itself.
        let prefix = format!("{}{}", folder.display(), std::path::MAIN_SEPARATOR);
        let spelled = |text: &str| serde_json::Value::from(text).to_string().trim_matches('"').to_owned();
        let text = format!("{:#}\n", report::json_object(&checked)).replace(&spelled(&prefix), "");
        write(&folder.join("check.json"), text.as_bytes())?;
        Ok(Some(scanned.index.entries))
    }

    /// Writes both contact sheets.
    fn sheet(
        &self,
        content: &Content<'_>,
        packed: &[Arc<Entry>],
        folder: &Path,
        warnings: &mut Vec<String>,
        (tell, is_cancelled): (&Tell<'_>, &(dyn Fn() -> bool + Sync)),
    ) -> Result<Option<Sheet>, PackError> {
        let hashes: BTreeMap<&Path, Digest> = packed.iter().map(|entry| (entry.path.as_path(), entry.content)).collect();
        let cards = content.materials.iter().map(|one| {
            let mut card = Card::of(one.entry, one.file.material(), self.shelf, self.setup);
            card.hash = hashes.get(one.entry.path.as_path()).copied().unwrap_or(card.hash);
            card
        });
        let sheet = Sheet::new(self.name, cards.collect());
        let total = sheet.cards().len();
        for name in ["sheet.html", "sheet.png"] {
            let path = folder.join(name);
            let mut go_on = |done| {
                tell(name, Progress { done, total });
                !is_cancelled()
            };
            match sheet.bytes(&path, &mut go_on) {
                Ok(Some(bytes)) => write(&path, &bytes)?,
                Ok(None) => return Ok(None),
                // A library is not to be kept back by its overview.
                Err(error @ SheetError::TooMany { .. }) => warnings.push(format!("{name} is not in the pack: {error}")),
                Err(error) => return Err(PackError::Sheet(error)),
            }
        }
        Ok(Some(sheet))
    }
}

/// Makes a folder of a pack that nobody sees yet, with those above it.
fn create(folder: &Path) -> Result<(), PackError> {
    fs::create_dir_all(folder).map_err(|source| FilesError::Write { path: folder.to_path_buf(), source }.into())
}

/// Writes a file of a pack that nobody sees yet.
fn write(path: &Path, bytes: &[u8]) -> Result<(), PackError> {
    fs::write(path, bytes).map_err(|source| FilesError::Write { path: path.to_path_buf(), source }.into())
}

#[cfg(test)]
mod tests;
