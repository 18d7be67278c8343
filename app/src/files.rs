//! Materials on disk: opening one with its textures, and saving so that nothing can be lost halfway.
//!
//! What a material file means is in `burnish_material`; here it only gets its path, its folder and its images.

use crate::cli::suggest;
use crate::picture_job::{self, PictureJob};
use burnish_assets::{BuiltInTexture, Image, TextureError, TextureMaker};
use burnish_material::{FileError, MAX_FILE_BYTES, Material, MaterialFile, Warning};
use burnish_renderer::scene::TextureSet;
use std::ffi::OsString;
use std::fmt;
use std::fs::{self, File};
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Ending of material files, without the first dot.
pub const MATERIAL_EXTENSION: &str = "asm.ron";

/// Why a file could not be read or written. Shown to the user as it is.
#[derive(Debug)]
pub enum FilesError {
    /// The system refused to read.
    Read {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The path is a folder, a pipe or a device, whose reading may never end.
    NotFile {
        /// What is there.
        path: PathBuf,
        /// What it is, with its article.
        found: &'static str,
    },
    /// The file is larger than anything of its kind should be.
    TooLarge {
        /// The file.
        path: PathBuf,
        /// What was expected at most.
        max_bytes: u64,
    },
    /// The system refused to write; the old file is as it was.
    Write {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// What was read back after writing differs from what was written; the old file is as it was.
    Differs {
        /// The file.
        path: PathBuf,
    },
    /// The file is not text in UTF-8.
    NotText {
        /// The file.
        path: PathBuf,
    },
    /// The file holds no material.
    NoMaterial {
        /// The file.
        path: PathBuf,
    },
    /// The text is not a material.
    Material {
        /// The file.
        path: PathBuf,
        /// Where and why.
        source: FileError,
    },
}

impl fmt::Display for FilesError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Read { path, source } => write!(f, "{}: cannot be read: {source}", path.display()),
            Self::NotFile { path, found } => write!(f, "{}: expected a file, found {found}", path.display()),
            Self::TooLarge { path, max_bytes } => {
                write!(f, "{}: expected a file of at most {max_bytes} bytes, found a larger one", path.display())
            }
            Self::Write { path, source } if source.kind() == std::io::ErrorKind::StorageFull => {
                write!(f, "{}: cannot be written: the disk is full; make room or choose another place", path.display())
            }
            Self::Write { path, source } => write!(f, "{}: cannot be written: {source}", path.display()),
            Self::Differs { path } => {
                write!(f, "{}: not saved, because what was read back differs from what was written", path.display())
            }
            Self::NotText { path } => write!(f, "{}: expected text in UTF-8, found other bytes", path.display()),
            Self::NoMaterial { path } => {
                write!(f, "{}: expected a material, or a picture that this program made of one, found neither", path.display())
            }
            Self::Material { path, source } => write!(f, "{}: {source}", path.display()),
        }
    }
}

impl std::error::Error for FilesError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Self::Read { source, .. } | Self::Write { source, .. } => Some(source),
            Self::Material { source, .. } => Some(source),
            Self::NotFile { .. }
            | Self::TooLarge { .. }
            | Self::Differs { .. }
            | Self::NotText { .. }
            | Self::NoMaterial { .. } => None,
        }
    }
}

/// A material with its text, its images and what was strange about them.
#[derive(Clone, Debug)]
pub struct OpenedMaterial {
    /// Where it came from; `None` for a new material or a preset.
    pub path: Option<PathBuf>,
    /// The text with everything this version does not know.
    pub file: MaterialFile,
    /// Sentences for the user.
    pub warnings: Vec<String>,
    /// Images by the path that the material names.
    pub textures: Arc<TextureSet>,
}

/// Whether a path has the ending of a material file; case is ignored.
pub fn is_material_path(path: &Path) -> bool {
    let name = path.file_name().map(|name| name.to_string_lossy().to_lowercase()).unwrap_or_default();
    name.ends_with(".asm.ron") || name.ends_with(".ron")
}

/// Writes `bytes` to `path` so that the file holds either all of them or what it held before.
///
/// The bytes go to a new file beside it, are forced to disk, read back, compared, and only then renamed.
pub fn save_atomic(path: &Path, bytes: &[u8]) -> Result<(), FilesError> {
    // A rename would replace a link by a file: write through it instead.
    let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf());
    let failed = |source| FilesError::Write { path: path.to_path_buf(), source };
    let temporary = temporary_beside(&target).map_err(failed)?;

    let written = write_and_check(&temporary, bytes, path).and_then(|()| {
        if let Ok(old) = fs::metadata(&target) {
            // Kept on a best effort: some file systems have no permissions to keep.
            let _ = fs::set_permissions(&temporary, old.permissions());
        }
        fs::rename(&temporary, &target).map_err(failed)
    });
    if written.is_err() {
        let _ = fs::remove_file(&temporary);
        return written;
    }
    // The rename itself lies in the folder; not every system lets a folder be synced.
    if let Some(folder) = target.parent().filter(|folder| !folder.as_os_str().is_empty()) {
        let _ = File::open(folder).and_then(|folder| folder.sync_all());
    }
    Ok(())
}

/// An error where [`save_atomic`] would fail: told before minutes of work, not after.
pub fn check_writable(path: &Path) -> Result<(), FilesError> {
    let failed = |source| FilesError::Write { path: path.to_path_buf(), source };
    if path.is_dir() {
        return Err(failed(std::io::ErrorKind::IsADirectory.into()));
    }
    let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf());
    let temporary = temporary_beside(&target).map_err(failed)?;
    File::create(&temporary).map_err(failed)?;
    fs::remove_file(&temporary).map_err(failed)
}

/// Where a file is written before it takes its name.
fn temporary_beside(target: &Path) -> std::io::Result<PathBuf> {
    let invalid = || std::io::Error::new(std::io::ErrorKind::InvalidInput, "the path has no file name");
    let name = target.file_name().ok_or_else(invalid)?;
    let mut beside: OsString = OsString::from(".");
    beside.push(name);
    // Two threads may write the same file.
    static COUNT: AtomicU64 = AtomicU64::new(0);
    beside.push(format!(".{}-{}.tmp", std::process::id(), COUNT.fetch_add(1, Ordering::Relaxed)));
    Ok(target.with_file_name(beside))
}

fn write_and_check(temporary: &Path, bytes: &[u8], path: &Path) -> Result<(), FilesError> {
    let failed = |source| FilesError::Write { path: path.to_path_buf(), source };
    let mut file = File::create(temporary).map_err(failed)?;
    file.write_all(bytes).map_err(failed)?;
    file.sync_all().map_err(failed)?;
    drop(file);
    let read_back = fs::read(temporary).map_err(failed)?;
    if read_back == bytes { Ok(()) } else { Err(FilesError::Differs { path: path.to_path_buf() }) }
}

/// What is at a path that is no file, with its article.
fn kind_of(metadata: &fs::Metadata) -> &'static str {
    if metadata.is_dir() { "a folder" } else { "a pipe, socket or device" }
}

/// Reads a file of at most `max_bytes` as text in UTF-8.
///
/// What is no file is refused before it is opened: opening a pipe can wait forever, and a device can be without end.
pub fn read_text_file(path: &Path, max_bytes: u64) -> Result<String, FilesError> {
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
    String::from_utf8(bytes).map_err(|_| FilesError::NotText { path: path.to_path_buf() })
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
    Ok(OpenedMaterial { path: Some(path.to_path_buf()), file, warnings, textures: Arc::new(textures) })
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
    Ok((OpenedMaterial { path: None, file, warnings, textures: Arc::new(textures) }, places))
}

/// Loads or makes every image that a material names. Relative paths start at `folder`, or at the current one.
///
/// Returns the images that could be read, and a sentence for each that could not.
pub fn load_textures(material: &Material, folder: Option<&Path>) -> (TextureSet, Vec<String>) {
    let mut textures = TextureSet::new();
    let mut maker = TextureMaker::default();
    let mut failed: Vec<(String, String)> = Vec::new();
    for (property, slot) in material.slots() {
        let Some(texture) = &slot.texture else { continue };
        if textures.contains_key(&texture.path) || failed.iter().any(|(path, _)| *path == texture.path) {
            continue;
        }
        let name = property.def().name;
        if texture.path.is_empty() {
            // In the words of `burnish_material::check`, so that who prints both can tell that they are one.
            failed.push((String::new(), format!("{name}: has a texture without a path")));
            continue;
        }
        match load_texture(&texture.path, folder, &mut maker) {
            Ok(image) => {
                textures.insert(texture.path.clone(), Arc::new(image));
            }
            Err(error) => {
                failed.push((texture.path.clone(), format!("{name}: the value is used instead of the texture: {error}")));
            }
        }
    }
    (textures, failed.into_iter().map(|(_, sentence)| sentence).collect())
}

fn load_texture(path: &str, folder: Option<&Path>, maker: &mut TextureMaker) -> Result<Image, String> {
    match texture_source(path, folder)? {
        TextureSource::BuiltIn(texture) => Ok(maker.make(&texture)),
        TextureSource::File(path) => match file_problem(&path) {
            Some(problem) => Err(problem),
            None => burnish_assets::load_image(&path).map_err(|error| error.to_string()),
        },
    }
}

/// Makes the map of a built-in texture that a path names, or says why there is none.
pub fn make_built_in_texture(path: &str) -> Result<Image, String> {
    load_texture(path, None, &mut TextureMaker::default())
}

/// Where the image comes from that a material names.
enum TextureSource {
    /// It is made by code.
    BuiltIn(BuiltInTexture),
    /// It is read.
    File(PathBuf),
}

fn texture_source(path: &str, folder: Option<&Path>) -> Result<TextureSource, String> {
    match BuiltInTexture::parse(path) {
        Some(parsed) => parsed.map(TextureSource::BuiltIn).map_err(|error| built_in_problem(path, &error)),
        None => Ok(TextureSource::File(folder.map_or_else(|| PathBuf::from(path), |folder| folder.join(path)))),
    }
}

/// One sentence, with the name that was probably meant.
fn built_in_problem(path: &str, error: &TextureError) -> String {
    let hint = error.unknown().map(|(name, known)| suggest::hint(name, known)).unwrap_or_default();
    format!("{path}: {error}{hint}")
}

/// Why there cannot be an image for this path of a texture, as far as that shows without opening a file.
pub fn texture_problem(path: &str, folder: Option<&Path>) -> Option<String> {
    match texture_source(path, folder) {
        Ok(TextureSource::BuiltIn(_)) => None,
        Ok(TextureSource::File(path)) => file_problem(&path),
        Err(problem) => Some(problem),
    }
}

fn file_problem(path: &Path) -> Option<String> {
    let found = match fs::metadata(path) {
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => "no file".to_owned(),
        Err(error) => error.to_string(),
        Ok(metadata) if !metadata.is_file() => kind_of(&metadata).to_owned(),
        Ok(_) if !burnish_assets::is_image_path(path) => "a name without the ending of one".to_owned(),
        Ok(_) => return None,
    };
    Some(format!("expected an image (.png, .jpg, .jpeg, .exr or .hdr) at {}, found {found}", path.display()))
}

/// Where a texture lies on disk: `path` itself if absolute, else below `folder`; `None` for a built-in one.
pub fn texture_path(path: &str, folder: Option<&Path>) -> Option<PathBuf> {
    match texture_source(path, folder) {
        Ok(TextureSource::File(path)) => Some(path),
        Ok(TextureSource::BuiltIn(_)) | Err(_) => None,
    }
}

/// Names the images of a material anew, so that its relative paths lead to the same files from another folder. Returns old and new names.
pub fn move_textures(material: &mut Material, from: Option<&Path>, to: Option<&Path>) -> Vec<(String, String)> {
    let mut moved = Vec::new();
    for def in burnish_material::PROPERTIES.iter().filter(|_| from != to) {
        let Some(texture) = &mut material.slot_mut(def.id).texture else { continue };
        let Some(path) = texture_path(&texture.path, from) else { continue };
        let name = texture_name(&path, to);
        moved.push((std::mem::replace(&mut texture.path, name.clone()), name));
    }
    moved
}

/// How a material file in `folder` should name the image at `path`: relative if it lies below, with `/` either way.
pub fn texture_name(path: &Path, folder: Option<&Path>) -> String {
    let relative = folder.and_then(|folder| path.strip_prefix(folder).ok()).unwrap_or(path);
    let text = relative.to_string_lossy();
    if std::path::MAIN_SEPARATOR == '/' { text.into_owned() } else { text.replace(std::path::MAIN_SEPARATOR, "/") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_files_have_a_path() {
        let folder = Some(Path::new("library"));
        assert_eq!(texture_path("oak.png", folder), Some(PathBuf::from("library/oak.png")));
        assert_eq!(texture_path("builtin:wood-oak/height", folder), None);
        assert_eq!(texture_path("builtin:no such texture", folder), None);
        assert!(texture_problem("builtin:wood-oak/height", folder).is_none());
        let problem = texture_problem("builtin:wood-oka/height", folder).unwrap_or_default();
        assert!(
            problem.starts_with("builtin:wood-oka/height: expected") && problem.ends_with("did you mean `wood-oak`?"),
            "{problem}"
        );
    }
}
