//! The way in: a file of any format to its materials, with the images that it holds.

use super::error::{ExchangeError, Fault};
use super::{Format, sets};
use crate::files::{self, Embedded, OpenedMaterial};
use burnish_assets::{BuiltInTexture, Image, Mesh, Model, Part, Role, decode_image, load_model};
use burnish_material::exchange::paths::refusal;
use burnish_material::exchange::{filament, gltf, materialx, mdl, usd};
use burnish_material::{Material, MaterialFile};
use burnish_renderer::scene::TextureSet;
use glam::{Vec2, Vec3};
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
        let material = &material;
        let names = || material.slots().filter_map(|(_, slot)| slot.texture.as_ref()).map(|texture| texture.path.as_str());
        let embedded = embedded.iter().filter(|(path, _)| names().any(|name| name == path.as_str()));
        let embedded = embedded.map(|(path, bytes)| (path.clone(), bytes.clone())).collect();
        Self { file: MaterialFile::new(material), folder: folder.map(Path::to_path_buf), embedded, notes }
    }

    /// The same for a document that no file holds yet: images beside the file are named by their whole paths.
    pub fn apart(self) -> OpenedMaterial {
        let (textures, problems) = self.textures();
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
        let warnings = self.notes.into_iter().chain(problems).collect();
        OpenedMaterial { path: None, file, warnings, textures: Arc::new(textures), embedded: Arc::new(self.embedded) }
    }

    /// Its images, decoded, and a sentence for each that cannot be read.
    pub fn textures(&self) -> (TextureSet, Vec<String>) {
        let (mut textures, mut problems) = (TextureSet::new(), Vec::new());
        for (path, bytes) in &self.embedded {
            match decode_image(Path::new(path), bytes) {
                Ok(image) => _ = textures.insert(path.clone(), Arc::<Image>::new(image)),
                Err(error) => problems.push(format!("the value is used instead of the texture: {error}")),
            }
        }
        let mut beside = self.file.material().clone();
        for def in burnish_material::PROPERTIES {
            let slot = beside.slot_mut(def.id);
            if slot.texture.as_ref().is_some_and(|texture| self.embedded.contains_key(&texture.path)) {
                slot.texture = None;
            }
        }
        let (read, missing) = files::load_textures(&beside, self.folder.as_deref());
        textures.extend(read);
        problems.extend(missing);
        (textures, problems)
    }
}

/// Whether the path of an image stays in the folder of the file that names it, or is that of a texture that comes with the program.
pub(super) fn is_inside(path: &str) -> bool {
    refusal(path).is_none() && (!path.starts_with("builtin:") || BuiltInTexture::parse(path).is_some())
}

/// Reads all materials of a file, or of a folder of texture sets. At least one; notes about the whole are the first one's.
pub fn open(path: &Path) -> Result<Vec<Opened>, ExchangeError> {
    if path.is_dir() {
        return sets::open_folder(path);
    }
    let format = Format::of(path).ok_or_else(|| ExchangeError::UnknownFormat { path: path.to_path_buf() })?;
    let content = |fault| ExchangeError::Content { path: path.to_path_buf(), fault };
    let folder = path.parent();
    let text = || -> Result<String, ExchangeError> { Ok(files::read_text_file(path, MAX_BYTES)?) };
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
        Format::Usda => {
            let bytes = files::read_file(path, MAX_BYTES)?;
            let layer = usd::layer_text(&bytes).map_err(|error| content(Fault::Usd(error)))?;
            of_usd(layer, folder, &Embedded::new()).map_err(|error| content(Fault::Usd(error)))?
        }
        Format::Usdz => {
            let bytes = files::read_file(path, MAX_BYTES)?;
            let package = usd::usdz::read(&bytes).map_err(|error| content(Fault::Usd(error)))?;
            let embedded = package.files().skip(1).map(|(name, bytes)| (name.to_owned(), bytes.into())).collect();
            let layer = package.layer().map_err(|error| content(Fault::Usd(error)))?;
            of_usd(layer, folder, &embedded).map_err(|error| content(Fault::Usd(error)))?
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
    if opened.is_empty() { Err(ExchangeError::NoMaterial { path: path.to_path_buf() }) } else { Ok(opened) }
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

fn of_usd(layer: &str, folder: Option<&Path>, embedded: &Embedded) -> Result<Vec<Opened>, usd::UsdError> {
    let scene = usd::read(layer)?;
    let all: Vec<Opened> = scene
        .materials
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
        .collect();
    Ok(all)
}

/// The mesh of a file of glTF or USD, if it holds one, and sentences about it.
pub fn open_model(path: &Path) -> Option<(Model, Vec<String>)> {
    match Format::of(path)? {
        Format::Gltf | Format::Glb => load_model(path).ok(),
        Format::Usda => usd_model(path, usd::layer_text(&files::read_file(path, MAX_BYTES).ok()?).ok()?),
        Format::Usdz => {
            let bytes = files::read_file(path, MAX_BYTES).ok()?;
            usd_model(path, usd::usdz::read(&bytes).ok()?.layer().ok()?)
        }
        Format::Native | Format::MaterialX | Format::Mdl | Format::Filament | Format::TextureSet => None,
    }
}

/// All meshes of a layer as one.
fn usd_model(path: &Path, layer: &str) -> Option<(Model, Vec<String>)> {
    let mut mesh = Mesh::default();
    let meshes = usd::read(layer).ok()?.meshes;
    let have = |of: fn(&usd::FoundMesh) -> bool| meshes.iter().all(of);
    let (has_normals, has_uvs) = (have(|mesh| mesh.normals.is_some()), have(|mesh| mesh.uvs.is_some()));
    for found in meshes {
        let first = mesh.positions.len() as u32;
        mesh.positions.extend(found.positions.into_iter().map(Vec3::from));
        mesh.normals.extend(found.normals.into_iter().flatten().filter(|_| has_normals).map(Vec3::from));
        // The lower left corner there, the upper left one here.
        mesh.uvs.extend(found.uvs.into_iter().flatten().filter(|_| has_uvs).map(|[u, v]| Vec2::new(u, 1.0 - v)));
        mesh.triangles.extend(found.triangles.into_iter().map(|triangle| triangle.map(|vertex| first + vertex)));
    }
    let (mut mesh, notes) = mesh.complete();
    let name = path.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
    mesh.name.clone_from(&name);
    let parts = vec![Part { role: Role::Object, mesh }];
    (!parts[0].mesh.triangles.is_empty()).then_some((Model { name, parts, unit_mm: Some(1000.0) }, notes))
}
