//! Which material files lie below a folder.

use crate::files::MATERIAL_EXTENSION;
use std::collections::BTreeSet;
use std::fs::{self, DirEntry, Metadata};
use std::path::{Path, PathBuf};
use std::time::UNIX_EPOCH;

/// Deeper folders are not looked into: a file system can be without end.
pub const MAX_DEPTH: usize = 64;

/// A file with what tells whether it was changed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Found {
    /// Relative to the folder that was searched.
    pub path: PathBuf,
    /// When it was changed last, and how large it is.
    pub stamp: Stamp,
}

/// Size and time of a file: the same stamp is taken for the same content.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Stamp {
    /// Bytes.
    pub size: u64,
    /// Nanoseconds since 1970 of the last change; `None` where it is not known or too young to tell a later change from.
    pub modified: Option<i64>,
}

impl Stamp {
    /// What the system says of a file.
    pub fn of(metadata: &Metadata) -> Self {
        let since = metadata.modified().ok().and_then(|time| time.duration_since(UNIX_EPOCH).ok());
        Self { size: metadata.len(), modified: since.and_then(|time| i64::try_from(time.as_nanos()).ok()) }
    }

    /// The stamp to remember for content that is read from now on: without its time where that is so young that a further change could carry
    /// the same one. Some file systems count in steps of two seconds.
    pub fn settled(self) -> Self {
        const STEP: i64 = 2_000_000_000;
        let now = std::time::SystemTime::now().duration_since(UNIX_EPOCH).ok().and_then(|now| i64::try_from(now.as_nanos()).ok());
        let is_old = |modified: &i64| now.is_some_and(|now| now.saturating_sub(*modified) > STEP);
        Self { modified: self.modified.filter(is_old), ..self }
    }

    /// Whether a file with this stamp has the content that had the `remembered` one.
    pub fn is_like(self, remembered: Self) -> bool {
        self.modified.is_some() && self == remembered
    }
}

/// What a search found.
#[derive(Clone, Debug, Default)]
pub struct Walk {
    /// Material files, by the order of their paths.
    pub files: Vec<Found>,
    /// What is named like one and is none, relative to the folder: a folder, a pipe, a link that leads nowhere; with what is wrong.
    pub no_files: Vec<(PathBuf, String)>,
    /// Folders below that could not be read, a sentence each.
    pub problems: Vec<String>,
}

/// Searches a folder and those below it for material files, until `is_cancelled` says so.
///
/// Each folder is searched once, by its own path if it has one below `root`. Links to folders are followed, but not those that lead to a folder
/// around `root`. An error only if `root` itself is no folder that can be read.
pub fn walk(root: &Path, is_cancelled: &dyn Fn() -> bool) -> Result<Walk, std::io::Error> {
    let start = fs::canonicalize(root)?;
    // Told here, because everything below is only left out.
    fs::read_dir(root)?;
    let mut walk = Walk::default();
    let mut seen = BTreeSet::new();
    let mut folders = vec![(PathBuf::new(), 0)];
    let mut links: Vec<(PathBuf, usize)> = Vec::new();
    while let Some((folder, depth)) = folders.pop().or_else(|| links.pop()) {
        if is_cancelled() {
            break;
        }
        let place = root.join(&folder);
        let problem = |error: std::io::Error| format!("{}: expected a folder that can be read: {error}", place.display());
        let entries = match fs::canonicalize(&place) {
            Ok(path) if !seen.insert(path.clone()) || (depth > 0 && start.starts_with(&path)) => continue,
            Ok(_) => fs::read_dir(&place),
            Err(error) => Err(error),
        };
        let entries = match entries {
            Ok(entries) => entries,
            Err(error) => {
                walk.problems.push(problem(error));
                continue;
            }
        };
        for entry in entries {
            match entry {
                Ok(entry) => look_at(&entry, &folder, depth, &mut walk, &mut folders, &mut links),
                Err(error) => walk.problems.push(problem(error)),
            }
        }
    }
    walk.files.sort_by(|a, b| a.path.cmp(&b.path));
    walk.no_files.sort();
    Ok(walk)
}

fn look_at(
    entry: &DirEntry,
    folder: &Path,
    depth: usize,
    walk: &mut Walk,
    folders: &mut Vec<(PathBuf, usize)>,
    links: &mut Vec<(PathBuf, usize)>,
) {
    let path = folder.join(entry.file_name());
    let is_link = entry.file_type().is_ok_and(|kind| kind.is_symlink());
    let is_named = is_material_name(&path);
    // Most files of a folder of textures need not be asked for.
    if !is_named && !is_link && entry.file_type().is_ok_and(|kind| kind.is_file()) {
        return;
    }
    let metadata = if is_link { fs::metadata(entry.path()) } else { entry.metadata() };
    let is_folder = metadata.as_ref().is_ok_and(Metadata::is_dir);
    if is_folder && depth < MAX_DEPTH {
        // Links come last, so that a folder keeps its own path.
        if is_link { &mut *links } else { &mut *folders }.push((path.clone(), depth + 1));
    }
    match metadata {
        _ if !is_named => {}
        Ok(metadata) if metadata.is_file() => walk.files.push(Found { path, stamp: Stamp::of(&metadata) }),
        Ok(_) if is_folder => walk.no_files.push((path, "expected a file, found a folder".to_owned())),
        Ok(_) => walk.no_files.push((path, "expected a file, found a pipe, socket or device".to_owned())),
        Err(error) => walk.no_files.push((path, format!("cannot be read: {error}"))),
    }
}

/// Whether a name ends in `.asm.ron`, in any case.
fn is_material_name(path: &Path) -> bool {
    let name = path.file_name().map(|name| name.to_string_lossy().to_lowercase()).unwrap_or_default();
    name.strip_suffix(MATERIAL_EXTENSION).is_some_and(|stem| stem.ends_with('.'))
}
