//! A contact sheet: all pictures of a library with their names, as a page that needs nothing beside itself or as one picture.

mod html;
mod png;

use super::entry::Entry;
use super::pictures;
use super::shelf::{Shelf, State};
use crate::digest::Digest;
use crate::files;
use crate::lettering::Lettering;
use burnish_material::{Material, Provenance};
use image::RgbImage;
use image::imageops::{self, FilterType};
use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Most materials of a page: it is then some 100 MB large.
pub const MAX_CARDS: usize = 20_000;

/// Why there is no sheet. Shown to the user as it is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum SheetError {
    /// There are more materials than it can show.
    TooMany {
        /// How many there are.
        count: usize,
        /// How many there can be, in words.
        most: String,
    },
    /// The encoder refused.
    Encode(String),
}

impl fmt::Display for SheetError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooMany { count, most } => write!(f, "{count} materials are too many for a sheet: expected {most}"),
            Self::Encode(problem) => write!(f, "cannot be written: {problem}"),
        }
    }
}

impl std::error::Error for SheetError {}

/// What a sheet says of one material.
#[derive(Clone, Debug)]
pub struct Card {
    /// Relative to the library's folder, with `/`.
    pub path: String,
    /// Name of the material.
    pub name: String,
    /// Folder of the file.
    pub group: String,
    /// Free words.
    pub tags: Vec<String>,
    /// Where its values come from.
    pub provenance: Provenance,
    /// Hash of the file and its images.
    pub hash: Digest,
    /// Where its small picture lies, if there is one.
    pub picture: Option<PathBuf>,
    /// Whether the picture is one of how the material looked before, or was taken in another way.
    pub is_stale: bool,
}

impl Card {
    /// What is known of a material that has been read.
    pub fn of(entry: &Entry, material: &Material, shelf: &Shelf, setup: Digest) -> Self {
        Self {
            path: slashed(&entry.path),
            name: entry.name.clone(),
            group: entry.group(),
            tags: entry.tags.clone(),
            provenance: material.provenance.clone(),
            hash: entry.content,
            picture: shelf.best(entry, setup).map(|(look, setup)| shelf.path(look, setup)),
            is_stale: shelf.state(entry, setup) == State::Stale,
        }
    }

    /// Its picture, at most `side` pixels wide and high; `None` if there is none that can be read.
    fn small_picture(&self, side: u32) -> Option<RgbImage> {
        let loaded = pictures::load(self.picture.as_deref()?)?;
        let rgb = loaded.rgba.as_chunks::<4>().0.iter().flat_map(|[r, g, b, _]| [*r, *g, *b]).collect();
        let picture = RgbImage::from_raw(loaded.width, loaded.height, rgb)?;
        let longer = loaded.width.max(loaded.height);
        if longer <= side {
            return Some(picture);
        }
        let scaled = |n: u32| ((u64::from(n) * u64::from(side) / u64::from(longer)) as u32).max(1);
        Some(imageops::resize(&picture, scaled(loaded.width), scaled(loaded.height), FilterType::Triangle))
    }
}

/// A path as other systems read it too.
pub(super) fn slashed(path: &Path) -> String {
    path.components().map(|part| part.as_os_str().to_string_lossy()).collect::<Vec<_>>().join("/")
}

/// What a sheet shows, group by group.
#[derive(Clone, Debug)]
pub struct Sheet {
    title: String,
    cards: Vec<Card>,
    side: Option<u32>,
    columns: Option<u32>,
}

impl Sheet {
    /// A sheet of these cards.
    pub fn new(title: &str, mut cards: Vec<Card>) -> Self {
        cards.sort_by(|a, b| (&a.group, &a.path).cmp(&(&b.group, &b.path)));
        Self { title: title.to_owned(), cards, side: None, columns: None }
    }

    /// With pictures of at most `side` pixels, and in a PNG so many columns. `None` as it fits best.
    pub fn shaped(self, side: Option<u32>, columns: Option<u32>) -> Self {
        Self { side, columns, ..self }
    }

    /// Reads the materials of those entries that can be used, and shows them. Files that cannot be read any more are left out, with a
    /// sentence each.
    pub fn of(title: &str, root: &Path, entries: &[Arc<Entry>], shelf: &Shelf, setup: Digest) -> (Self, Vec<String>) {
        let (mut cards, mut problems) = (Vec::with_capacity(entries.len()), Vec::new());
        for entry in entries.iter().filter(|entry| entry.problem.is_none()) {
            match files::read_material(&root.join(&entry.path)) {
                Ok((file, _)) => cards.push(Card::of(entry, file.material(), shelf, setup)),
                Err(error) => problems.push(error.to_string()),
            }
        }
        (Self::new(title, cards), problems)
    }

    /// What it shows, by group and then by path.
    pub fn cards(&self) -> &[Card] {
        &self.cards
    }

    /// The groups with their cards.
    fn groups(&self) -> impl Iterator<Item = &[Card]> {
        self.cards.chunk_by(|a, b| a.group == b.group)
    }

    /// `206 materials in 14 groups`.
    fn facts(&self) -> String {
        let counted = |n: usize, word: &str| format!("{n} {word}{}", if n == 1 { "" } else { "s" });
        let groups = self.groups().count();
        let groups = if groups > 1 { format!(" in {}", counted(groups, "group")) } else { String::new() };
        format!("{}{groups}", counted(self.cards.len(), "material"))
    }

    /// An error if there are more materials than the format of a path can hold; without looking at pictures.
    pub fn refuse_too_many(&self, path: &Path) -> Result<(), SheetError> {
        if is_page(path) { self.refuse_too_long() } else { self.fitting(&mut Lettering::default()).map(|_| ()) }
    }

    /// Writes it in the format that the ending of a path stands for: `.html`, or else `.png`. `go_on` is asked after each card with how many are
    /// done; `None` if it says no.
    pub fn bytes(&self, path: &Path, go_on: &mut dyn FnMut(usize) -> bool) -> Result<Option<Vec<u8>>, SheetError> {
        if is_page(path) { Ok(self.html(go_on)?.map(String::into_bytes)) } else { self.png(go_on) }
    }
}

/// Whether a path is one of a page.
pub fn is_page(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("html") || ending.eq_ignore_ascii_case("htm"))
}

#[cfg(test)]
mod tests;
