//! A file of another format as a whole, for the window: its materials with their images, and its mesh.

use super::mesh::{load_mesh, usd_model};
use super::open::{self, Opened};
use super::{ExchangeError, Format};
use crate::files::{Embedded, OpenedMaterial};
use burnish_assets::{Model, Progress};
use burnish_renderer::scene::TextureSet;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::sync::Arc;

/// Share of an import after which the text of the file is read.
const READ: f32 = 0.1;
/// A byte of a mesh without tangents takes as long as so many of a PNG, by measurement.
const MESH_BYTES: f64 = 4.0;

/// What a file holds.
#[derive(Debug)]
pub struct Import {
    /// Its materials, which no file of ours holds yet.
    pub materials: Vec<OpenedMaterial>,
    /// Its mesh, if there is one.
    pub model: Option<Model>,
    /// Sentences for the user about what did not go as it stands in the file.
    pub notes: Vec<String>,
}

/// Reads a file of another format. A mesh without materials is one as well.
pub fn import(path: &Path, progress: Progress<'_>) -> Result<Import, ExchangeError> {
    let (opened, meshes) = open::read(path)?;
    progress.tell(READ)?;
    let images = READ + (1.0 - READ) * image_share(path, &opened);
    let (textures, problems) = open::textures_of(&opened, progress.part(READ, images))?;
    progress.tell(images)?;
    let is_gltf = matches!(Format::of(path), Some(Format::Gltf | Format::Glb));
    let mut notes = problems;
    let found = match meshes {
        Some(meshes) => usd_model(path, meshes),
        None if is_gltf => match load_mesh(path, progress.part(images, 1.0)) {
            Ok(found) => Some(found),
            Err(ExchangeError::NoMesh { .. }) => None,
            Err(error @ ExchangeError::Cancelled) => return Err(error),
            // Its materials can be of use without it.
            Err(error) if !opened.is_empty() => {
                notes.push(error.to_string());
                None
            }
            Err(error) => return Err(error),
        },
        None => None,
    };
    if opened.is_empty() && found.is_none() {
        return Err(ExchangeError::NoMaterial { path: path.to_path_buf() });
    }
    let mut materials: Vec<OpenedMaterial> = opened.into_iter().map(|opened| opened.apart(&textures)).collect();
    for material in &mut materials {
        material.import = Some(path.to_path_buf());
        let name = &material.file.material().name;
        notes.extend(material.warnings.drain(..).map(|note| format!("{}: {name}: {note}", path.display())));
    }
    let model = found.map(|(model, sentences)| {
        notes.extend(sentences);
        model
    });
    Ok(Import { materials, model, notes })
}

/// The images that stand inside of a file of another format, as whole files and decoded, and a sentence for each that cannot be read.
pub fn imported_images(path: &Path, progress: Progress<'_>) -> Result<(Embedded, TextureSet, Vec<String>), ExchangeError> {
    let embedded: Embedded = open::read(path)?.0.into_iter().flat_map(|opened| opened.embedded).collect();
    let (mut textures, mut problems) = (TextureSet::new(), Vec::new());
    for (k, (name, bytes)) in embedded.iter().enumerate() {
        progress.tell_count(k, embedded.len())?;
        match burnish_assets::decode_image(Path::new(name), bytes) {
            Ok(image) => _ = textures.insert(name.clone(), Arc::new(image)),
            Err(error) => problems.push(error.to_string()),
        }
    }
    Ok((embedded, textures, problems))
}

/// How much of what comes after reading the text goes into images, 0 to 1.
fn image_share(path: &Path, opened: &[Opened]) -> f32 {
    let size = |path: &Path| fs::metadata(path).map_or(0, |metadata| metadata.len()) as f64;
    let embedded: BTreeMap<&str, usize> =
        opened.iter().flat_map(|opened| &opened.embedded).map(|(name, bytes)| (name.as_str(), bytes.len())).collect();
    let embedded = embedded.values().sum::<usize>() as f64;
    (embedded / (embedded + MESH_BYTES * (size(path) - embedded).max(1.0))) as f32
}
