//! Where a pack goes: a place that is free or holds an older pack, and a folder beside it in which the pack is made.

use super::manifest::{self, MANIFEST};
use super::{FORMAT, PackError};
use crate::digest::Digest;
use crate::files::{FilesError, read_text_file};
use std::fs;
use std::path::{Path, PathBuf};

/// Larger lists are none of ours.
const MAX_MANIFEST_BYTES: u64 = 1 << 28;

/// What is at the place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Found {
    Nothing,
    EmptyFolder,
    Pack,
}

/// A place for a pack.
pub(super) struct Place {
    target: PathBuf,
    found: Found,
}

impl Place {
    /// Looks at a place. An error where something would be lost, or where the library in `root` would pack itself.
    pub fn find(target: &Path, root: &Path) -> Result<Self, PackError> {
        let target = std::path::absolute(target).unwrap_or_else(|_| target.to_path_buf());
        let taken = |reason: &str| PackError::Taken { path: target.clone(), reason: reason.to_owned() };
        let parent =
            target.parent().filter(|_| target.file_name().is_some()).ok_or_else(|| taken("expected a folder with a name"))?;
        let parent = fs::canonicalize(parent).map_err(|_| taken("expected a place in a folder that exists"))?;
        if fs::canonicalize(root).is_ok_and(|root| parent.starts_with(root)) {
            return Err(taken("expected a place outside the library's folder"));
        }
        let found = match fs::symlink_metadata(&target) {
            Err(_) => Found::Nothing,
            Ok(metadata) if !metadata.is_dir() => return Err(taken("expected a folder or nothing, found a file")),
            Ok(_) if fs::read_dir(&target).is_ok_and(|mut entries| entries.next().is_none()) => Found::EmptyFolder,
            Ok(_) => {
                refuse_other_files(&target)?;
                Found::Pack
            }
        };
        Ok(Self { target, found })
    }

    /// The folder to make the pack in.
    pub fn begin(self) -> Result<Staging, PackError> {
        let folder = self.beside("tmp");
        fs::create_dir(&folder).map_err(|source| FilesError::Write { path: folder.clone(), source })?;
        Ok(Staging { place: self, folder })
    }

    fn beside(&self, ending: &str) -> PathBuf {
        let name = self.target.file_name().unwrap_or_default().to_string_lossy();
        self.target.with_file_name(format!(".{name}.{}.{ending}", std::process::id()))
    }
}

/// A pack that is being made; what is left of it goes when this is dropped.
pub(super) struct Staging {
    place: Place,
    folder: PathBuf,
}

impl Staging {
    pub fn path(&self) -> &Path {
        &self.folder
    }

    /// Puts the pack in its place.
    pub fn put(self) -> Result<(), PackError> {
        let target = &self.place.target;
        let failed = |source| FilesError::Write { path: target.clone(), source };
        let old = self.place.beside("old");
        match self.place.found {
            Found::Nothing => {}
            Found::EmptyFolder => fs::remove_dir(target).map_err(failed)?,
            Found::Pack => fs::rename(target, &old).map_err(failed)?,
        }
        if let Err(source) = fs::rename(&self.folder, target) {
            if self.place.found == Found::Pack {
                // Where this fails as well, the old pack still lies beside its place.
                _ = fs::rename(&old, target);
            }
            return Err(failed(source).into());
        }
        if self.place.found == Found::Pack {
            _ = fs::remove_dir_all(&old);
        }
        Ok(())
    }
}

impl Drop for Staging {
    fn drop(&mut self) {
        // After `put` there is nothing there any more.
        _ = fs::remove_dir_all(&self.folder);
    }
}

/// An error if a folder holds anything but an unchanged pack.
fn refuse_other_files(folder: &Path) -> Result<(), PackError> {
    let taken = |reason: String| PackError::Taken { path: folder.to_path_buf(), reason };
    let path = folder.join(MANIFEST);
    if !path.is_file() {
        return Err(taken("expected nothing there or an older pack, found a folder without its manifest.json".to_owned()));
    }
    let text = read_text_file(&path, MAX_MANIFEST_BYTES)?;
    let known = manifest::hashes(&text)
        .ok_or_else(|| taken(format!("expected an older pack, found a manifest.json that is not of {FORMAT}")))?;
    for file in files(folder).map_err(|source| FilesError::Read { path: folder.to_path_buf(), source })? {
        let name = super::super::sheet::slashed(file.strip_prefix(folder).unwrap_or(&file));
        if name == MANIFEST {
            continue;
        }
        match known.get(&name) {
            None => {
                return Err(taken(format!("holds {name}, which is not of the older pack; move it away or choose another place")));
            }
            Some(hash) if Digest::of_file(&file, &|| true).ok().flatten() != Some(*hash) => {
                return Err(taken(format!("{name} was changed since it was packed; move it away or choose another place")));
            }
            Some(_) => {}
        }
    }
    Ok(())
}

/// All files below a folder, in the order of their paths. Links are files here: they are not followed.
pub(super) fn files(folder: &Path) -> std::io::Result<Vec<PathBuf>> {
    let (mut files, mut folders) = (Vec::new(), vec![folder.to_path_buf()]);
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder)? {
            let entry = entry?;
            if entry.file_type()?.is_dir() { folders.push(entry.path()) } else { files.push(entry.path()) }
        }
    }
    files.sort();
    Ok(files)
}
