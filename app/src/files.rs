//! Materials on disk: opening one with its textures, and saving so that nothing can be lost halfway.
//!
//! What a material file means is in `burnish_material`; here it only gets its path, its folder and its images.

mod error;
mod saving;
mod textures;

pub use error::FilesError;
pub use saving::{check_writable, save_atomic};
pub use textures::{
    load_textures, load_textures_of, make_built_in_texture, move_textures, texture_name, texture_path, texture_problem,
};

use crate::picture_job::{self, PictureJob};
use burnish_assets::{BuiltInTexture, TextureMaker};
use burnish_material::{MAX_FILE_BYTES, MaterialFile, Warning};
use burnish_renderer::scene::TextureSet;
use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use textures::load_texture;

/// Ending of material files, without the first dot.
pub const MATERIAL_EXTENSION: &str = "asm.ron";

/// A material with its text, its images and what was strange about them.
#[derive(Clone, Debug)]
pub struct OpenedMaterial {
    /// Where it came from; `None` for a new material or a preset.
    pub path: Option<PathBuf>,
    /// The file of another format that it came from.
    pub import: Option<PathBuf>,
    /// The text with everything this version does not know.
    pub file: MaterialFile,
    /// Sentences for the user.
    pub warnings: Vec<String>,
    /// Images by the path that the material names.
    pub textures: Arc<TextureSet>,
    /// Those that lie in no file of their own, as whole files: saving writes them beside the material.
    pub embedded: Arc<Embedded>,
}

impl OpenedMaterial {
    /// A material that no file holds yet, and that names no images.
    pub fn new(file: MaterialFile) -> Self {
        let (textures, embedded) = Default::default();
        Self { path: None, import: None, file, warnings: Vec::new(), textures, embedded }
    }
}

/// Images by the path that a material names, as whole files.
pub type Embedded = BTreeMap<String, Arc<[u8]>>;

/// Whether a path has the ending of a material file; case is ignored.
pub fn is_material_path(path: &Path) -> bool {
    let name = path.file_name().map(|name| name.to_string_lossy().to_lowercase()).unwrap_or_default();
    name.ends_with(".asm.ron") || name.ends_with(".ron")
}

/// What is at a path that is no file, with its article.
fn kind_of(metadata: &fs::Metadata) -> &'static str {
    if metadata.is_dir() { "a folder" } else { "a pipe, socket or device" }
}

/// Reads a file of at most `max_bytes` as text in UTF-8.
pub fn read_text_file(path: &Path, max_bytes: u64) -> Result<String, FilesError> {
    String::from_utf8(read_file(path, max_bytes)?).map_err(|_| FilesError::NotText { path: path.to_path_buf() })
}

/// Reads a file of at most `max_bytes`.
///
/// What is no file is refused before it is opened: opening a pipe can wait forever, and a device can be without end.
pub fn read_file(path: &Path, max_bytes: u64) -> Result<Vec<u8>, FilesError> {
    let unreadable = |source| FilesError::Read { path: path.to_path_buf(), source };
    let too_large = || FilesError::TooLarge { path: path.to_path_buf(), max_bytes };
    let metadata = fs::metadata(path).map_err(unreadable)?;
    if !metadata.is_file() {
        return Err(FilesError::NotFile { path: path.to_path_buf(), found: kind_of(&metadata) });
    }
    if metadata.len() > max_bytes {
        return Err(too_large());
    }
    let mut bytes = Vec::new();
    // The length may be wrong: a file can grow meanwhile, and those that the system makes up have length 0.
    File::open(path).and_then(|file| file.take(max_bytes + 1).read_to_end(&mut bytes)).map_err(unreadable)?;
    if bytes.len() as u64 > max_bytes {
        return Err(too_large());
    }
    Ok(bytes)
}

/// Reads a material file with all that is strange about it, but without its images.
pub fn read_material(path: &Path) -> Result<(MaterialFile, Vec<Warning>), FilesError> {
    let text = read_text_file(path, MAX_FILE_BYTES as u64)?;
    MaterialFile::parse(&text).map_err(|source| FilesError::Material { path: path.to_path_buf(), source })
}

/// Reads a material file and the images it names, relative to its folder.
///
/// A strange value or a missing image is a warning; only unreadable text is an error.
pub fn open_material(path: &Path) -> Result<OpenedMaterial, FilesError> {
    let (file, warnings) = read_material(path)?;
    let mut warnings: Vec<String> = warnings.iter().map(|warning| format!("{}: {warning}", path.display())).collect();
    let (textures, missing) = load_textures(file.material(), path.parent());
    warnings.extend(missing);
    let textures = Arc::new(textures);
    Ok(OpenedMaterial { path: Some(path.to_path_buf()), warnings, textures, ..OpenedMaterial::new(file) })
}

/// Opens the material that a picture of ours was made from: a new document without a file, since the picture is not to be saved over. Also
/// returns where its images came from, by the path that the material names.
///
/// A strange value, or an image that is not there any more or has changed, is a warning; a picture without a material is an error.
pub fn open_embedded(path: &Path, job: Option<&PictureJob>) -> Result<(OpenedMaterial, Vec<(String, PathBuf)>), FilesError> {
    let missing = || FilesError::NoMaterial { path: path.to_path_buf() };
    let (job, text) = job.and_then(|job| Some((job, job.material.as_deref()?))).ok_or_else(missing)?;
    let (file, warnings) =
        MaterialFile::parse(text).map_err(|source| FilesError::Material { path: path.to_path_buf(), source })?;
    let mut warnings: Vec<String> = warnings.iter().map(|warning| format!("{}: {warning}", path.display())).collect();
    let folder = picture_job::folder_of(path);
    let (mut textures, mut places) = (TextureSet::new(), Vec::new());
    for texture in &job.textures {
        let place = folder.as_deref().map_or_else(|| PathBuf::from(&texture.file), |folder| folder.join(&texture.file));
        match burnish_assets::load_image(&place) {
            Ok(image) => {
                if picture_job::hash_of(&place).ok().as_ref() != Some(&texture.hash) {
                    warnings.push(format!("{}: has changed since {} was made", place.display(), path.display()));
                }
                textures.insert(texture.name.clone(), Arc::new(image));
                places.push((texture.name.clone(), place));
            }
            Err(error) => warnings.push(format!("{}: the value is used instead of the texture: {error}", path.display())),
        }
    }
    // What code makes is in no list of files.
    let mut maker = TextureMaker::default();
    let names = file.material().slots().filter_map(|(_, slot)| slot.texture.as_ref());
    for name in names.map(|texture| texture.path.as_str()).filter(|name| BuiltInTexture::parse(name).is_some()) {
        match load_texture(name, None, &mut maker) {
            Ok(image) => _ = textures.insert(name.to_owned(), Arc::new(image)),
            Err(error) => warnings.push(format!("{}: the value is used instead of the texture: {error}", path.display())),
        }
    }
    Ok((OpenedMaterial { warnings, textures: Arc::new(textures), ..OpenedMaterial::new(file) }, places))
}
