//! Materials and images of a pack: bytes as they are, each image once, and paths that hold inside the pack.

use super::super::entry::Entry;
use super::super::sheet::slashed;
use super::{PackError, create, write};
use crate::digest::Digest;
use crate::files::{self, FilesError};
use burnish_material::{MAX_FILE_BYTES, Material, MaterialFile};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Component, Path, PathBuf};

/// Where images from outside of the library go.
const IMAGES: &str = "textures";

/// A material in the pack.
pub(super) struct Packed<'a> {
    /// What the library knows of it.
    pub entry: &'a Entry,
    /// As it stands in the pack.
    pub file: MaterialFile,
    /// Its images, by their paths in the folder of the materials, with `/`.
    pub images: Vec<String>,
}

/// What has been packed so far.
pub(super) struct Content<'a> {
    root: PathBuf,
    folder: PathBuf,
    pub materials: Vec<Packed<'a>>,
    /// Files that are not in the pack, with the reason.
    pub left_out: Vec<(&'a Entry, String)>,
    pub warnings: Vec<String>,
    /// Images by what they hold.
    images: BTreeMap<Digest, String>,
    /// Paths of images in lower case: not every system tells cases apart.
    taken: BTreeSet<String>,
}

impl<'a> Content<'a> {
    /// Nothing yet of the library in `root`, to be packed into `folder`.
    pub fn new(root: &Path, folder: &Path) -> Result<Self, PackError> {
        create(folder)?;
        let root = std::path::absolute(root).unwrap_or_else(|_| root.to_path_buf());
        let (images, taken) = Default::default();
        Ok(Self {
            root,
            folder: folder.to_path_buf(),
            materials: Vec::new(),
            left_out: Vec::new(),
            warnings: Vec::new(),
            images,
            taken,
        })
    }

    /// How many images there are.
    pub fn images(&self) -> usize {
        self.images.len()
    }

    /// Packs a material with its images.
    pub fn add(&mut self, entry: &'a Entry) -> Result<(), PackError> {
        let path = self.root.join(&entry.path);
        if let Some(problem) = &entry.problem {
            self.warnings.push(format!("{}: left out: {problem}", entry.path.display()));
            self.left_out.push((entry, problem.clone()));
            return Ok(());
        }
        let text = files::read_text_file(&path, MAX_FILE_BYTES as u64)?;
        if Digest::of(text.as_bytes()) != entry.bytes {
            return Err(PackError::Changed { path });
        }
        let parse = |text: &str| {
            MaterialFile::parse(text).map(|(file, _)| file).map_err(|source| FilesError::Material { path: path.clone(), source })
        };
        let mut file = parse(&text)?;
        let mut edited = file.material().clone();
        let images = self.add_images(entry, &mut edited)?;
        if edited != *file.material() {
            file = parse(&file.to_text(&edited))?;
        }
        let target = self.folder.join(&entry.path);
        target.parent().map_or(Ok(()), create)?;
        write(&target, file.text().as_bytes())?;
        self.materials.push(Packed { entry, file, images });
        Ok(())
    }

    /// Packs the images of a material, and lets it name those by their places in the pack.
    fn add_images(&mut self, entry: &Entry, material: &mut Material) -> Result<Vec<String>, PackError> {
        let group = entry.path.parent().unwrap_or(Path::new(""));
        let properties: Vec<_> =
            material.slots().filter(|(_, slot)| slot.texture.is_some()).map(|(property, _)| property).collect();
        let mut images = Vec::new();
        for property in properties {
            let Some(texture) = &mut material.slot_mut(property).texture else { continue };
            let folder = self.root.join(group);
            let Some(source) = files::texture_path(&texture.path, Some(&folder)) else { continue };
            // What is no image may be anything of this user's.
            let problem = if texture.path.is_empty() {
                Some("it has no path".to_owned())
            } else {
                files::texture_problem(&texture.path, Some(&folder))
            };
            if let Some(problem) = problem {
                let key = property.def().name;
                self.warnings.push(format!("{}: {key}: its image is not in the pack: {problem}", entry.path.display()));
                continue;
            }
            let packed = self.add_image(&source)?;
            let is_valid = !Path::new(&texture.path).is_absolute() && slashed(&plain(&group.join(&texture.path))) == packed;
            if !is_valid {
                texture.path = from_folder(group, &packed);
            }
            if !images.contains(&packed) {
                images.push(packed);
            }
        }
        Ok(images)
    }

    /// Packs an image unless one that holds the same is there. Returns its path in the folder of the materials.
    fn add_image(&mut self, source: &Path) -> Result<String, PackError> {
        let unreadable = |error| FilesError::Read { path: source.to_path_buf(), source: error };
        let digest = Digest::of_file(source, &|| true).map_err(unreadable)?.unwrap_or_default();
        if let Some(known) = self.images.get(&digest) {
            return Ok(known.clone());
        }
        let whole = plain(source);
        let short: String = digest.to_string().chars().take(8).collect();
        let own = whole.strip_prefix(&self.root).map(slashed).ok().filter(|own| !self.taken.contains(&own.to_lowercase()));
        // From outside of the library, or equal to another but for case: a name that cannot meet those of the library.
        let name = own.unwrap_or_else(|| {
            let name = whole.file_name().unwrap_or_default().to_string_lossy();
            let (stem, ending) = name.rsplit_once('.').unwrap_or((&name, ""));
            format!("{IMAGES}/{stem}-{short}.{ending}")
        });
        let target = self.folder.join(&name);
        target.parent().map_or(Ok(()), create)?;
        fs::copy(source, &target).map_err(|error| FilesError::Write { path: target.clone(), source: error })?;
        // It may be written at this very moment.
        if Digest::of_file(&target, &|| true).ok().flatten() != Some(digest) {
            return Err(PackError::Changed { path: source.to_path_buf() });
        }
        self.taken.insert(name.to_lowercase());
        self.images.insert(digest, name.clone());
        Ok(name)
    }
}

/// A path without `.` and `..`, as far as it shows without asking the system.
pub(super) fn plain(path: &Path) -> PathBuf {
    let mut plain = PathBuf::new();
    for part in path.components() {
        match part {
            Component::CurDir => {}
            Component::ParentDir if matches!(plain.components().next_back(), Some(Component::Normal(_))) => _ = plain.pop(),
            part => plain.push(part),
        }
    }
    plain
}

/// How a material in a folder names an image, both below the same place.
fn from_folder(folder: &Path, image: &str) -> String {
    let (folder, image): (Vec<_>, Vec<&str>) =
        (folder.components().map(|part| part.as_os_str().to_string_lossy()).collect(), image.split('/').collect());
    let same = folder.iter().zip(&image).take_while(|(a, b)| a == *b).count();
    let up = std::iter::repeat_n("..", folder.len() - same);
    up.chain(image[same..].iter().copied()).collect::<Vec<_>>().join("/")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_images_lead_from_the_material_to_them() {
        for (folder, image, expected) in [
            ("", "a.png", "a.png"),
            ("metals", "textures/a.png", "../textures/a.png"),
            ("metals/worn", "metals/maps/a.png", "../maps/a.png"),
            ("metals", "metals/a.png", "a.png"),
        ] {
            assert_eq!(from_folder(Path::new(folder), image), expected);
            assert_eq!(slashed(&plain(&Path::new(folder).join(expected))), image);
        }
        assert_eq!(plain(Path::new("/a/./b/../../../c")), Path::new("/../c"));
        assert_eq!(plain(Path::new("../a/../b")), Path::new("../b"));
    }
}
