//! Images of materials: where they are, how they are named, and loading or making them.

use super::{Embedded, kind_of};
use crate::cli::suggest;
use burnish_assets::{BuiltInTexture, Ended, Image, Progress, TextureError, TextureMaker};
use burnish_material::{Material, Property};
use burnish_renderer::scene::TextureSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Loads or makes every image that a material names. Relative paths start at `folder`, or at the current one.
///
/// Returns the images that could be read, and a sentence for each that could not.
pub fn load_textures(material: &Material, folder: Option<&Path>) -> (TextureSet, Vec<String>) {
    // Without a listener nothing ends.
    load_textures_of(&[material], folder, &Embedded::new(), Progress::NONE).unwrap_or_default()
}

/// The same of several materials of one file: each image once. Those in `embedded` stand in the file itself.
pub fn load_textures_of(
    materials: &[&Material],
    folder: Option<&Path>,
    embedded: &Embedded,
    progress: Progress<'_>,
) -> Result<(TextureSet, Vec<String>), Ended> {
    let mut named: Vec<(Property, &str)> = Vec::new();
    for (property, slot) in materials.iter().flat_map(|material| material.slots()) {
        if let Some(texture) = &slot.texture
            && !named.iter().any(|(_, path)| *path == texture.path)
        {
            named.push((property, &texture.path));
        }
    }
    let (mut textures, mut failed, mut maker) = (TextureSet::new(), Vec::new(), TextureMaker::default());
    for (k, &(property, path)) in named.iter().enumerate() {
        progress.tell_count(k, named.len())?;
        let name = property.def().name;
        if path.is_empty() {
            // In the words of `burnish_material::check`, so that who prints both can tell that they are one.
            failed.push(format!("{name}: has a texture without a path"));
            continue;
        }
        let image = match embedded.get(path) {
            Some(bytes) => burnish_assets::decode_image(Path::new(path), bytes).map_err(|error| error.to_string()),
            None => load_texture(path, folder, &mut maker),
        };
        match image {
            Ok(image) => _ = textures.insert(path.to_owned(), Arc::new(image)),
            Err(error) => failed.push(format!("{name}: the value is used instead of the texture: {error}")),
        }
    }
    Ok((textures, failed))
}

pub(super) fn load_texture(path: &str, folder: Option<&Path>, maker: &mut TextureMaker) -> Result<Image, String> {
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
