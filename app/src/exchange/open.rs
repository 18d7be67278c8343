//! The way in: a file of any format to its materials, with the images that it holds.

use super::error::{ExchangeError, Fault};
use super::{Format, own_text, sets};
use crate::files::{self, Embedded, OpenedMaterial};
use burnish_assets::{BuiltInTexture, Ended, Progress};
use burnish_material::exchange::paths::refusal;
use burnish_material::exchange::{filament, gltf, materialx, mdl, usd};
use burnish_material::{Material, MaterialFile};
use burnish_renderer::scene::TextureSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Larger files are refused: they are read as a whole.
const MAX_BYTES: u64 = 1 << 30;

/// A material of a file.
#[derive(Clone, Debug)]
pub struct Opened {
    /// Its text and values.
    pub file: MaterialFile,
    /// Folder that relative paths of images start at.
    pub folder: Option<PathBuf>,
    /// Images that stand in the file itself and not beside it.
    pub embedded: Embedded,
    /// Sentences for the user about what did not go as it stands in the file.
    pub notes: Vec<String>,
}

impl Opened {
    pub(super) fn of(material: &Material, folder: Option<&Path>, embedded: &Embedded, mut notes: Vec<String>) -> Self {
        let mut material = material.clone();
        for def in burnish_material::PROPERTIES {
            let slot = material.slot_mut(def.id);
            if let Some(texture) = slot.texture.take_if(|texture| !is_inside(&texture.path)) {
                let expected = "expected an image in the folder of the file or below";
                notes.push(format!("{}: the image `{}`: {expected}; not used", def.name, texture.path));
            }
        }
        let names = || material.slots().filter_map(|(_, slot)| slot.texture.as_ref()).map(|texture| texture.path.as_str());
        let embedded = embedded.iter().filter(|(path, _)| names().any(|name| name == path.as_str()));
        let embedded = embedded.map(|(path, bytes)| (path.clone(), bytes.clone())).collect();
        Self { file: own_text::take(material), folder: folder.map(Path::to_path_buf), embedded, notes }
    }

    /// The same for a document that no file holds yet: images beside the file are named by their whole paths.
    ///
    /// `images` are those of its file, decoded.
    pub fn apart(self, images: &TextureSet) -> OpenedMaterial {
        let of_it = self.file.material().slots().filter_map(|(_, slot)| slot.texture.as_ref());
        let textures: TextureSet = of_it
            .filter_map(|texture| images.get_key_value(&texture.path))
            .map(|(path, image)| (path.clone(), image.clone()))
            .collect();
        let mut material = self.file.material().clone();
        let moved = files::move_textures(&mut material, self.folder.as_deref(), None);
        for (property, slot) in self.file.material().slots() {
            let Some(held) = slot.texture.as_ref().filter(|held| self.embedded.contains_key(&held.path)) else { continue };
            if let Some(texture) = &mut material.slot_mut(property).texture {
                texture.path.clone_from(&held.path);
            }
        }
        let name = |old: String| match moved.iter().find(|(before, _)| *before == old) {
            Some((_, new)) if !self.embedded.contains_key(&old) => new.clone(),
            _ => old,
        };
        let textures = textures.into_iter().map(|(old, image)| (name(old), image)).collect();
        let file = match MaterialFile::parse(&self.file.to_text(&material)) {
            Ok((file, _)) => file,
            Err(_) => MaterialFile::new(&material),
        };
        let (textures, embedded) = (Arc::new(textures), Arc::new(self.embedded));
        OpenedMaterial { warnings: self.notes, textures, embedded, ..OpenedMaterial::new(file) }
    }

    /// Its images, decoded, and a sentence for each that cannot be read.
    pub fn textures(&self) -> (TextureSet, Vec<String>) {
        // Without a listener nothing ends.
        textures_of(std::slice::from_ref(self), Progress::NONE).unwrap_or_default()
    }
}

/// The images of all materials of one file, each decoded once, and a sentence for each that cannot be read.
pub fn textures_of(opened: &[Opened], progress: Progress<'_>) -> Result<(TextureSet, Vec<String>), Ended> {
    let materials: Vec<&Material> = opened.iter().map(|opened| opened.file.material()).collect();
    let embedded = opened.iter().flat_map(|opened| opened.embedded.iter()).map(|(path, bytes)| (path.clone(), bytes.clone()));
    let folder = opened.first().and_then(|opened| opened.folder.as_deref());
    files::load_textures_of(&materials, folder, &embedded.collect(), progress)
}

/// Whether the path of an image stays in the folder of the file that names it, or is that of a texture that comes with the program.
pub(super) fn is_inside(path: &str) -> bool {
    refusal(path).is_none() && (!path.starts_with("builtin:") || BuiltInTexture::parse(path).is_some())
}

/// Reads all materials of a file, or of a folder of texture sets. At least one; notes about the whole are the first one's.
pub fn open(path: &Path) -> Result<Vec<Opened>, ExchangeError> {
    let opened = read(path)?.0;
    if opened.is_empty() { Err(ExchangeError::NoMaterial { path: path.to_path_buf() }) } else { Ok(opened) }
}

/// All materials of a file, and its meshes where they are read in the same go.
pub(super) fn read(path: &Path) -> Result<(Vec<Opened>, Option<Vec<usd::FoundMesh>>), ExchangeError> {
    if path.is_dir() {
        return Ok((sets::open_folder(path)?, None));
    }
    let format = Format::of(path).ok_or_else(|| ExchangeError::UnknownFormat { path: path.to_path_buf() })?;
    let content = |fault| ExchangeError::Content { path: path.to_path_buf(), fault };
    let folder = path.parent();
    let text = || -> Result<String, ExchangeError> { Ok(files::read_text_file(path, MAX_BYTES)?) };
    let mut meshes = None;
    let mut opened = match format {
        Format::Native => {
            let (file, warnings) = files::read_material(path)?;
            let notes = warnings.iter().map(ToString::to_string).collect();
            vec![Opened { file, folder: folder.map(Path::to_path_buf), embedded: Embedded::new(), notes }]
        }
        Format::Gltf | Format::Glb => {
            let bytes = files::read_file(path, MAX_BYTES)?;
            of_gltf(&bytes, folder).map_err(|error| content(Fault::Gltf(error)))?
        }
        Format::MaterialX => {
            let read = materialx::read(&text()?).map_err(|error| content(Fault::MaterialX(error)))?;
            read.into_iter().map(|found| Opened::of(&found.material, folder, &Embedded::new(), found.notes)).collect()
        }
        Format::Usda | Format::Usdz => {
            let (scene, embedded) = usd_scene(path)?;
            meshes = Some(scene.meshes);
            of_usd(scene.materials, folder, &embedded)
        }
        Format::Mdl => {
            let read = mdl::read(&text()?).map_err(|error| content(Fault::Mdl(error)))?;
            read.into_iter().map(|found| Opened::of(&found.material, folder, &Embedded::new(), found.notes)).collect()
        }
        Format::Filament => {
            let found = filament::read(&text()?).map_err(|error| content(Fault::Filament(error)))?;
            vec![Opened::of(&found.material, folder, &Embedded::new(), found.notes)]
        }
        Format::TextureSet => vec![sets::open_copy(path)?],
    };
    opened.iter_mut().for_each(|found| found.notes.dedup());
    Ok((opened, meshes))
}

fn of_gltf(bytes: &[u8], folder: Option<&Path>) -> Result<Vec<Opened>, gltf::GltfError> {
    let document = gltf::read(bytes)?;
    let mut embedded = Embedded::new();
    let mut notes = document.notes;
    for image in document.images {
        let bytes: Arc<[u8]> = match image.source {
            gltf::Source::File => continue,
            gltf::Source::Bytes(bytes) => bytes.into(),
            gltf::Source::Part { file, range } => {
                let path = folder.map_or_else(|| PathBuf::from(&file), |folder| folder.join(&file));
                match files::read_file(&path, MAX_BYTES) {
                    Ok(all) if range.end <= all.len() => all[range].into(),
                    Ok(all) => {
                        notes.push(format!("{file}: expected at least {} bytes, found {}", range.end, all.len()));
                        continue;
                    }
                    Err(error) => {
                        notes.push(error.to_string());
                        continue;
                    }
                }
            }
        };
        embedded.insert(image.path, bytes);
    }
    let mut opened: Vec<Opened> = document
        .materials
        .iter()
        .map(|found| {
            let (material, notes) = found.material();
            Opened::of(&material, folder, &embedded, notes)
        })
        .collect();
    if let Some(first) = opened.first_mut() {
        first.notes.splice(0..0, notes);
    }
    Ok(opened)
}

/// The layer of a USD file or package, and the images that a package holds.
pub(super) fn usd_scene(path: &Path) -> Result<(usd::Scene, Embedded), ExchangeError> {
    let content = |error| ExchangeError::Content { path: path.to_path_buf(), fault: Fault::Usd(error) };
    let bytes = files::read_file(path, MAX_BYTES)?;
    if Format::of(path) != Some(Format::Usdz) {
        return Ok((usd::layer_text(&bytes).and_then(usd::read).map_err(content)?, Embedded::new()));
    }
    let package = usd::usdz::read(&bytes).map_err(content)?;
    let embedded = package.files().skip(1).map(|(name, bytes)| (name.to_owned(), bytes.into())).collect();
    Ok((package.layer().and_then(usd::read).map_err(content)?, embedded))
}

pub(super) fn of_usd(materials: Vec<usd::FoundMaterial>, folder: Option<&Path>, embedded: &Embedded) -> Vec<Opened> {
    materials
        .into_iter()
        .map(|found| {
            let mut material = found.material;
            // The native copy calls images as it did at home; where that leads nowhere, the layer's own place counts.
            let is_lost = |name: &str| !embedded.contains_key(name) && files::texture_problem(name, folder).is_some();
            for (name, place) in found.files.iter().filter(|(name, _)| is_lost(name)) {
                for def in burnish_material::PROPERTIES {
                    if let Some(texture) = material.slot_mut(def.id).texture.as_mut().filter(|texture| texture.path == *name) {
                        texture.path.clone_from(place);
                    }
                }
            }
            Opened::of(&material, folder, embedded, found.notes)
        })
        .collect()
}
