//! Whether material files can be handed out: what is wrong with each of them, and which of them are one material twice.
//!
//! Files are read on all threads, and of each only its findings, a hash and, if asked for, a picture of 12 KB stay in memory. The order of the rows
//! is that of the paths, whatever thread was first.

pub mod against;
mod doubts;
mod file;
mod known;
mod look;
mod pairs;
pub mod report;
mod threads;

pub use known::Known;
pub use look::Look;
pub use threads::map;

use super::entry::Entry;
use super::scan::Progress;
use super::setup::{Frame, Setup, Stage};
use super::shelf::{Shelf, State};
use crate::digest::Digest;
use crate::files::FilesError;
use burnish_material::{FindingKind, MaterialFile, Severity};
use file::{Checker, Report};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use threads::Kept;

/// Rows of one file that are listed; the others are counted in a last one.
const MAX_ROWS: usize = 100;

/// What a row is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Kind {
    /// The file, or something in it, cannot be read.
    Parse,
    /// A value outside the range that renderers enforce.
    Range,
    /// A value outside the typical range.
    Typical,
    /// A value that no real substance has.
    Unlikely,
    /// Values that are odd only together.
    Combination,
    /// A value without effect.
    Effect,
    /// An image that is missing or unreadable, or placed oddly.
    Texture,
    /// A length that makes no sense in its unit.
    Scale,
    /// No source or no licence.
    Provenance,
    /// The same values as another file.
    Value,
    /// The same picture as another file.
    Look,
    /// Numbers do not hold.
    Stability,
    /// The small picture is stale or missing.
    Thumbnail,
}

impl Kind {
    /// The word for machines.
    pub fn word(self) -> &'static str {
        match self {
            Self::Parse => "parse",
            Self::Range => "range",
            Self::Typical => "typical",
            Self::Unlikely => "unlikely",
            Self::Combination => "combination",
            Self::Effect => "effect",
            Self::Texture => "texture",
            Self::Scale => "scale",
            Self::Provenance => "provenance",
            Self::Value => "duplicate_value",
            Self::Look => "duplicate_look",
            Self::Stability => "stability",
            Self::Thumbnail => "thumbnail",
        }
    }
}

impl From<FindingKind> for Kind {
    fn from(kind: FindingKind) -> Self {
        match kind {
            FindingKind::Range => Self::Range,
            FindingKind::Typical => Self::Typical,
            FindingKind::Texture => Self::Texture,
            FindingKind::Unlikely => Self::Unlikely,
            FindingKind::Combination => Self::Combination,
            FindingKind::Effect => Self::Effect,
            FindingKind::Scale => Self::Scale,
        }
    }
}

/// One finding in one file.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// The file as it was given.
    pub path: PathBuf,
    /// Line in the file, from 1, where one is to blame.
    pub line: Option<usize>,
    /// How much it matters.
    pub severity: Severity,
    /// Property or key of the file; empty for the file as a whole.
    pub key: String,
    /// A sentence without path and key.
    pub message: String,
    /// What it is about.
    pub kind: Kind,
}

/// Two files that are one material.
#[derive(Clone, Debug, PartialEq)]
pub struct Pair {
    /// The one that comes first by its path.
    pub a: PathBuf,
    /// The other one, which has the row.
    pub b: PathBuf,
    /// [`Kind::Value`] or [`Kind::Look`].
    pub kind: Kind,
    /// How far their pictures are apart, see [`Look::distance`]; 0 for equal values.
    pub distance: f64,
}

/// What a library is known by, for [`check_library`].
pub struct Shelved<'a> {
    /// The library's folder.
    pub root: &'a Path,
    /// Its files, by the order of their paths.
    pub entries: &'a [Arc<Entry>],
    /// Its small pictures.
    pub shelf: &'a Shelf,
    /// How they should have been taken.
    pub setup: Digest,
}

impl Shelved<'_> {
    /// The fresh small picture of an entry, to be compared.
    pub fn look(&self, entry: &Entry) -> Option<Look> {
        let is_fresh = self.shelf.state(entry, self.setup) == State::Fresh;
        is_fresh.then(|| Look::load(&self.shelf.path(entry.look, self.setup))).flatten()
    }
}

/// How much is looked at.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Options {
    /// Threads; 0 counts as 1.
    pub threads: usize,
    /// Renders a picture of each material, so that those that look the same are found without small pictures.
    pub renders_looks: bool,
    /// Probes each material numerically, which takes a second or so each.
    pub probes_stability: bool,
}

/// What was found.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Checked {
    /// By path, and in a file from its head to its neighbours.
    pub rows: Vec<Row>,
    /// Files that were looked at.
    pub files: usize,
    /// Findings that are errors, unlisted ones included.
    pub errors: usize,
    /// Findings that are warnings, unlisted ones included.
    pub warnings: usize,
    /// Files that are one material. Of several that are all the same, each is named with the first.
    pub pairs: Vec<Pair>,
}

/// Checks files, in the order in which they are given. What renderers cope with is a warning at most, so that errors are files that cannot be used.
///
/// `None` if it is cancelled.
pub fn check_files(
    paths: &[PathBuf],
    options: &Options,
    progress: &(dyn Fn(Progress) + Sync),
    is_cancelled: &(dyn Fn() -> bool + Sync),
) -> Option<Checked> {
    check(paths, None, options, &mut Known::default(), progress, is_cancelled)
}

/// Checks the text of one file that may not be saved; images are looked for beside its path.
pub fn check_text(path: &Path, text: &str) -> Checked {
    let read = MaterialFile::parse(text).map_err(|source| FilesError::Material { path: path.to_path_buf(), source });
    let checker = Checker { library: None, options: &Options::default(), setup: None, is_cancelled: &|| false };
    Checked { files: 1, ..collected([checker.report_of(path, read, None, &mut Kept::default())]) }
}

/// Checks a library that is to be handed out: values outside their range and missing images are errors, a missing
/// source or licence is a warning, and small pictures are looked at.
///
/// `None` if it is cancelled.
pub fn check_library(
    library: &Shelved<'_>,
    options: &Options,
    progress: &(dyn Fn(Progress) + Sync),
    is_cancelled: &(dyn Fn() -> bool + Sync),
) -> Option<Checked> {
    check_library_again(library, options, &mut Known::default(), progress, is_cancelled)
}

/// The same where some of it is known from before: only files that have changed are looked at, and all are compared with each other.
pub fn check_library_again(
    library: &Shelved<'_>,
    options: &Options,
    known: &mut Known,
    progress: &(dyn Fn(Progress) + Sync),
    is_cancelled: &(dyn Fn() -> bool + Sync),
) -> Option<Checked> {
    let paths: Vec<PathBuf> = library.entries.iter().map(|entry| library.root.join(&entry.path)).collect();
    check(&paths, Some(library), options, known, progress, is_cancelled)
}

fn check(
    paths: &[PathBuf],
    library: Option<&Shelved<'_>>,
    options: &Options,
    known: &mut Known,
    progress: &(dyn Fn(Progress) + Sync),
    is_cancelled: &(dyn Fn() -> bool + Sync),
) -> Option<Checked> {
    // Only rendering needs a scene.
    let needs_setup = options.renders_looks || options.probes_stability;
    let setup = needs_setup.then(Stage::standard).flatten().map(|stage| Setup::new(stage, Frame::default(), Vec::new()));
    let checker = Checker { library, options, setup: setup.as_ref(), is_cancelled };
    let mut reports: Vec<Report> = map(paths.len(), options.threads, progress, is_cancelled, |state, at| {
        let entry = library.and_then(|library| library.entries.get(at));
        let mut report = || checker.report(&paths[at], entry.map(AsRef::as_ref), state);
        match library.zip(entry) {
            Some((library, entry)) => known.get(library, entry, options).unwrap_or_else(&mut report),
            None => report(),
        }
    })?;
    if let Some(library) = library {
        known.set(library, &reports, options);
    }
    let found = pairs::find(&reports, options.threads, is_cancelled)?;

    let mut pairs = Vec::new();
    for pair in found {
        let (a, b) = (&paths[pair.first], &paths[pair.second]);
        let name = &reports[pair.first].name;
        let message = match pair.kind {
            Kind::Value => format!("has the values and textures of {} ({name})", a.display()),
            _ => format!("looks like {} ({name}): {:.2} % apart", a.display(), 100.0 * pair.distance),
        };
        pairs.push(Pair { a: a.clone(), b: b.clone(), kind: pair.kind, distance: pair.distance });
        reports[pair.second].add(b, None, Severity::Warning, "", message, pair.kind);
    }
    Some(Checked { files: paths.len(), pairs, ..collected(reports) })
}

/// Rows of files and how many there are.
fn collected(reports: impl IntoIterator<Item = Report>) -> Checked {
    let mut checked = Checked::default();
    for report in reports {
        let count = |severity| report.rows.iter().filter(|row| row.severity == severity).count();
        checked.errors += count(Severity::Error);
        checked.warnings += count(Severity::Warning);
        let mut rows = report.rows;
        let left = rows.split_off(rows.len().min(MAX_ROWS));
        if let (Some(worst), Some(last)) = (left.iter().map(|row| row.severity).max(), rows.last()) {
            let message = format!("{} more findings are not listed", left.len());
            rows.push(Row { line: None, severity: worst, key: String::new(), message, kind: Kind::Parse, ..last.clone() });
        }
        checked.rows.extend(rows);
    }
    checked
}
