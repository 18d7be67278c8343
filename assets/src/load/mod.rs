//! Reading meshes, environments and images. Which format a file has is told by the ending of its name.
//!
//! Nothing a file contains may end the program: every count is compared with the bytes that are there before memory
//! is asked for, every index before it is used.

mod accessors;
mod error;
mod gltf;
mod images;
mod ply;
mod ply_values;
mod uri;

use std::io::Read;
use std::path::Path;

pub use self::error::AssetError;
use crate::environment::Environment;
use crate::image::Image;
use crate::mesh::{Model, Part, Role};
use crate::progress::{Ended, Progress};

/// Larger files are refused: they are read into memory as a whole.
const MAX_FILE_BYTES: u64 = 2 << 30;

/// Share of loading a mesh after which its file is read.
const READ: f32 = 0.05;
/// Share after which all parts of a glTF mesh have their tangents.
const PARTS: f32 = 0.95;

const MODEL_ENDINGS: &[&str] = &["gltf", "glb", "ply"];
const ENVIRONMENT_ENDINGS: &[&str] = &["hdr", "exr"];
const IMAGE_ENDINGS: &[&str] = &["png", "jpg", "jpeg", "exr", "hdr"];

/// True if [`load_model`] reads files with such a name: `.gltf`, `.glb`, `.ply`, in any case.
pub fn is_model_path(path: &Path) -> bool {
    has_ending(path, MODEL_ENDINGS)
}

/// True if [`load_environment`] reads files with such a name: `.hdr`, `.exr`, in any case.
pub fn is_environment_path(path: &Path) -> bool {
    has_ending(path, ENVIRONMENT_ENDINGS)
}

/// True if [`load_image`] reads files with such a name: `.png`, `.jpg`, `.jpeg`, `.exr`, `.hdr`, in any case.
pub fn is_image_path(path: &Path) -> bool {
    has_ending(path, IMAGE_ENDINGS)
}

/// Reads all triangles of a `.gltf`, `.glb` or `.ply` file as one part with [`Role::Object`], and sentences about
/// what was strange or left out.
///
/// Node transforms are applied; the mesh is complete (see [`Mesh::complete`](crate::Mesh::complete)). The unit is 1000 mm for glTF and
/// unknown for PLY. An error if the file cannot be read, is damaged, or holds no triangle with an area.
pub fn load_model(path: &Path) -> Result<(Model, Vec<String>), AssetError> {
    load_model_with(path, Progress::NONE)
}

/// The same, telling how far it is, and ending with [`AssetError::Ended`] where nobody wants it any more.
pub fn load_model_with(path: &Path, progress: Progress<'_>) -> Result<(Model, Vec<String>), AssetError> {
    let ended = |Ended| AssetError::Ended { file: path.to_owned() };
    if !is_model_path(path) {
        return Err(AssetError::UnknownFormat { file: path.to_owned(), expected: ".gltf, .glb or .ply" });
    }
    let bytes = read_file(path)?;
    progress.tell(READ).map_err(ended)?;
    decode(path, &bytes, progress)
}

/// The same of bytes that lie elsewhere. `path` is for messages, its ending for the format, its folder for buffers beside a document.
pub fn decode_model(path: &Path, bytes: &[u8]) -> Result<(Model, Vec<String>), AssetError> {
    decode(path, bytes, Progress::NONE)
}

fn decode(path: &Path, bytes: &[u8], progress: Progress<'_>) -> Result<(Model, Vec<String>), AssetError> {
    let ended = |Ended| AssetError::Ended { file: path.to_owned() };
    let (mesh, mut warnings, unit_mm) = if has_ending(path, &["ply"]) {
        let (mesh, warnings) = ply::read(path, bytes)?;
        (mesh, warnings, None)
    } else {
        let (mesh, warnings) = gltf::read(path, bytes, progress.part(READ, PARTS))?;
        (mesh, warnings, Some(1000.0))
    };
    progress.tell(PARTS).map_err(ended)?;
    let (mut mesh, notes) = mesh.complete_telling(progress.part(PARTS, 1.0));
    warnings.extend(notes);
    if mesh.triangles.is_empty() {
        return Err(AssetError::Empty { file: path.to_owned(), expected: "at least one triangle with an area" });
    }
    let name = stem(path);
    mesh.name.clone_from(&name);
    Ok((Model { name, parts: vec![Part { role: Role::Object, mesh }], unit_mm }, warnings))
}

/// Reads a latitude-longitude environment from an `.hdr` or `.exr` file, and sentences about what was strange.
///
/// Texels that are not finite or negative become 0 and are counted in a sentence; so is a map that is not twice as
/// wide as high. An error if the file cannot be read, is damaged or too large.
pub fn load_environment(path: &Path) -> Result<(Environment, Vec<String>), AssetError> {
    if !is_environment_path(path) {
        return Err(AssetError::UnknownFormat { file: path.to_owned(), expected: ".hdr or .exr" });
    }
    let image = load_image(path)?;
    let mut warnings = Vec::new();
    if image.width != 2 * image.height {
        warnings.push(format!(
            "{}: expected a map twice as wide as high, found {} x {}; it is stretched over the sphere.",
            path.display(),
            image.width,
            image.height
        ));
    }
    let mut odd = 0_usize;
    let texels = image.texels.iter().map(|&[r, g, b, _]| {
        let is_radiance = [r, g, b].iter().all(|x| x.is_finite() && *x >= 0.0);
        odd += usize::from(!is_radiance);
        [r, g, b].map(|x| if x.is_finite() && x >= 0.0 { x } else { 0.0 })
    });
    let texels = texels.collect();
    if odd > 0 {
        warnings.push(format!(
            "{}: {odd} of {} texels are negative or not finite; 0 is used there.",
            path.display(),
            image.texels.len()
        ));
    }
    Ok((Environment { name: stem(path), width: image.width, height: image.height, texels }, warnings))
}

/// Reads a `.png`, `.jpg`, `.jpeg`, `.exr` or `.hdr` file as it is stored.
///
/// An error if the file cannot be read, is damaged or larger than 16384 texels in one direction or 256 million in all.
pub fn load_image(path: &Path) -> Result<Image, AssetError> {
    if !is_image_path(path) {
        return Err(AssetError::UnknownFormat { file: path.to_owned(), expected: ".png, .jpg, .jpeg, .exr or .hdr" });
    }
    decode_image(path, &read_file(path)?)
}

/// The same of bytes that lie elsewhere. `path` is for messages, and its ending for what no contents tell.
pub fn decode_image(path: &Path, bytes: &[u8]) -> Result<Image, AssetError> {
    if has_ending(path, &["exr"]) { images::read_exr(path, bytes) } else { images::read_common(path, bytes) }
}

/// The bytes of a file, if it is not larger than [`MAX_FILE_BYTES`].
fn read_file(path: &Path) -> Result<Vec<u8>, AssetError> {
    let unreadable = |problem| AssetError::unreadable(path, problem);
    let file = std::fs::File::open(path).map_err(unreadable)?;
    let metadata = file.metadata().map_err(unreadable)?;
    if metadata.is_dir() {
        return Err(AssetError::unreadable(path, "it is a folder"));
    }
    let mut bytes = Vec::new();
    // The length in the metadata is only a hint: a device can go on forever.
    file.take(MAX_FILE_BYTES + 1).read_to_end(&mut bytes).map_err(unreadable)?;
    if bytes.len() as u64 > MAX_FILE_BYTES {
        return Err(AssetError::too_large(path, "expected at most 2 GiB, found a larger file"));
    }
    Ok(bytes)
}

fn has_ending(path: &Path, endings: &[&str]) -> bool {
    let ending = path.extension().and_then(|ending| ending.to_str());
    ending.is_some_and(|ending| endings.iter().any(|known| known.eq_ignore_ascii_case(ending)))
}

/// The file name without its ending.
fn stem(path: &Path) -> String {
    path.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned())
}
