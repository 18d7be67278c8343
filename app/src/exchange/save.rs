//! The way out: materials to a file of any format, with the images that it needs beside it or in it.

use super::documents::{copy_all, of_filament, of_gltf, of_materialx, of_usd};
use super::error::{ExchangeError, Fault};
use super::names::FileNames;
use super::open::is_inside;
use super::{Format, own_text, sets};
use crate::export::rgba_png;
use crate::files::{self, Embedded, save_atomic};
use burnish_assets::Mesh;
use burnish_material::exchange::loss::Row;
use burnish_material::exchange::{ShadingModel, mdl, usd};
use burnish_material::{Material, MaterialFile, TextureRef};
use burnish_renderer::scene::TextureSet;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Largest image that is copied.
pub(crate) const MAX_IMAGE_BYTES: u64 = 1 << 30;

/// A material on the way out.
#[derive(Clone, Debug)]
pub struct Source {
    /// The material.
    pub material: Material,
    /// The file that it came from, whose text a native file keeps.
    pub file: Option<Arc<MaterialFile>>,
    /// Folder that relative paths of its images start at.
    pub folder: Option<PathBuf>,
    /// Its images, decoded, by the path that it names.
    pub textures: TextureSet,
    /// Those that no file on disk holds.
    pub embedded: Embedded,
}

impl Source {
    /// The same for another computer: images outside of the folder are carried along under their last names, since nobody else has those
    /// folders, or should read of them.
    fn portable(&self) -> Self {
        let names = names_of(std::slice::from_ref(self));
        let mut portable = self.clone();
        for def in burnish_material::PROPERTIES {
            let Some(texture) = &mut portable.material.slot_mut(def.id).texture else { continue };
            if is_inside(&texture.path) {
                continue;
            }
            let name = names.file(&texture.path);
            if let Some(Ok(bytes)) = image_bytes(self, &texture.path) {
                portable.embedded.insert(name.clone(), bytes.into());
            }
            if let Some(image) = self.textures.get(&texture.path) {
                portable.textures.insert(name.clone(), image.clone());
            }
            texture.path = name;
        }
        if let Some(file) = &portable.file {
            own_text::put(&mut portable.material, file);
        }
        portable
    }
}

/// How a file is written.
#[derive(Clone, Copy, Debug, Default)]
pub struct SaveOptions<'a> {
    /// A mesh that wears the materials, where the format can hold one, and metres per unit of it.
    pub mesh: Option<(&'a Mesh, f64)>,
    /// Whether the translation stands alone, without the native copy: what other programs see.
    pub is_bare: bool,
    /// One of the format's models, instead of its first.
    pub model: Option<&'static ShadingModel>,
}

/// What was written.
#[derive(Clone, Debug, Default)]
pub struct Saved {
    /// Files, the one that was asked for first.
    pub files: Vec<PathBuf>,
    /// What the translation costs, by material in the order given.
    pub rows: Vec<Vec<Row>>,
    /// Sentences for the user.
    pub notes: Vec<String>,
}

/// Files beside a document, or inside of it.
#[derive(Default)]
pub(super) struct Beside {
    /// What they hold, by path from the document.
    pub files: BTreeMap<String, Vec<u8>>,
    /// Sentences for the user.
    pub notes: Vec<String>,
}

/// A document that is not on disk yet.
#[derive(Clone, Debug)]
pub struct Made {
    /// Its bytes.
    pub document: Vec<u8>,
    /// The files that go beside it, by their paths from its folder, with `/`.
    pub files: BTreeMap<String, Vec<u8>>,
    /// What the translation costs, by material in the order given.
    pub rows: Vec<Vec<Row>>,
    /// Sentences for the user.
    pub notes: Vec<String>,
}

/// Writes materials into one file. `go_on` hears the share that is done and says whether to go on; what is cancelled leaves nothing.
pub fn save(
    sources: &[Source],
    out: &Path,
    options: SaveOptions<'_>,
    go_on: &dyn Fn(f32) -> bool,
) -> Result<Saved, ExchangeError> {
    let Made { document, files, rows, notes } = make(sources, out, options, go_on)?;
    // The images first: a document never names one that is not there.
    let folder = out.parent().unwrap_or(Path::new(""));
    let mut written = vec![out.to_path_buf()];
    for (name, bytes) in &files {
        let path = folder.join(name);
        if let Some(parent) = path.parent().filter(|parent| !parent.as_os_str().is_empty()) {
            let failed = |source| files::FilesError::Write { path: path.clone(), source };
            std::fs::create_dir_all(parent).map_err(failed)?;
        }
        // What is there already and the same stays untouched.
        if files::read_file(&path, MAX_IMAGE_BYTES).is_ok_and(|old| old == *bytes) {
            continue;
        }
        save_atomic(&path, bytes)?;
        written.push(path);
    }
    save_atomic(out, &document)?;
    Ok(Saved { files: written, rows, notes })
}

/// Makes the document that [`save`] would write at `out`, with all that goes beside it.
pub fn make(
    sources: &[Source],
    out: &Path,
    options: SaveOptions<'_>,
    go_on: &dyn Fn(f32) -> bool,
) -> Result<Made, ExchangeError> {
    let format = Format::of(out).ok_or_else(|| ExchangeError::UnknownFormat { path: out.to_path_buf() })?;
    let portable: Vec<Source>;
    let sources = if format == Format::Native {
        sources
    } else {
        portable = sources.iter().map(Source::portable).collect();
        &portable
    };
    let fault = |fault| ExchangeError::Content { path: out.to_path_buf(), fault };
    let Some(first) = sources.first() else { return Err(ExchangeError::NoMaterial { path: out.to_path_buf() }) };
    let model = options.model.or(format.def().model());
    let mut beside = Beside::default();
    let (document, rows) = match format {
        Format::Native => (native(first, out.parent(), &mut beside), vec![Vec::new()]),
        Format::Gltf | Format::Glb => of_gltf(sources, out, options, &mut beside, go_on)?,
        Format::MaterialX => of_materialx(sources, SaveOptions { model, ..options }, &mut beside, go_on)?,
        Format::Usda | Format::Usdz => {
            let (text, rows) = of_usd(sources, options, &mut beside, go_on)?;
            let bytes = if format == Format::Usda {
                text.into_bytes()
            } else {
                let images = std::mem::take(&mut beside.files);
                let images: Vec<(&str, &[u8])> = images.iter().map(|(name, bytes)| (name.as_str(), bytes.as_slice())).collect();
                let layer = format!("{}.usda", stem(out));
                usd::usdz::write(&layer, &text, &images).map_err(|error| fault(Fault::Usd(error)))?
            };
            (bytes, rows)
        }
        Format::Mdl => {
            let names = names_of(std::slice::from_ref(first));
            copy_all(first, &mut beside, &|path| names.file(path));
            let path_of = |texture: &TextureRef| Some(names.file(&texture.path)).filter(|name| !name.is_empty());
            let text = mdl::write(&first.material, mdl::Flavour::Own, &path_of);
            (text.into_bytes(), vec![mdl::loss(&first.material, mdl::Flavour::Own)])
        }
        Format::Filament => of_filament(first, &stem(out), options, &mut beside, go_on)?,
        Format::TextureSet => {
            let name = set_name(out);
            let text = sets::write(first, &name, model, &mut beside, go_on)?;
            (text.into_bytes(), vec![super::rows(format, model, &first.material)])
        }
    };
    if !go_on(1.0) {
        return Err(ExchangeError::Cancelled);
    }
    Ok(Made { document, files: beside.files, rows, notes: beside.notes })
}

pub(super) fn stem(path: &Path) -> String {
    path.file_stem().map_or_else(|| "material".to_owned(), |stem| stem.to_string_lossy().into_owned())
}

/// The name of a set: that of its file without the whole ending.
fn set_name(path: &Path) -> String {
    let stem = stem(path);
    stem.rsplit_once('.').map_or(stem.clone(), |(name, _)| name.to_owned())
}

/// The text of the native file, with its images named from the folder it goes to.
fn native(source: &Source, folder: Option<&Path>, beside: &mut Beside) -> Vec<u8> {
    let mut material = source.material.clone();
    // From the top of the disk, because relative folders say nothing about each other.
    let whole = |folder: Option<&Path>| {
        let folder = folder.map(|folder| if folder.as_os_str().is_empty() { Path::new(".") } else { folder });
        folder.map(|folder| std::path::absolute(folder).unwrap_or_else(|_| folder.to_path_buf()))
    };
    files::move_textures(&mut material, whole(source.folder.as_deref()).as_deref(), whole(folder).as_deref());
    // Images that no file held lie beside the new one.
    for def in burnish_material::PROPERTIES {
        if let Some(held) = source.material.slot(def.id).texture.as_ref().filter(|held| source.embedded.contains_key(&held.path))
            && let Some(texture) = &mut material.slot_mut(def.id).texture
        {
            texture.path.clone_from(&held.path);
        }
    }
    for (path, bytes) in &source.embedded {
        beside.files.insert(path.clone(), bytes.to_vec());
    }
    let text =
        source.file.as_ref().map_or_else(|| MaterialFile::new(&material).text().to_owned(), |file| file.to_text(&material));
    text.into_bytes()
}

/// The bytes of the image that a material calls `path`: as they are on disk, or made. `None` if the material does not name it.
pub(super) fn image_bytes(source: &Source, path: &str) -> Option<Result<Vec<u8>, String>> {
    if let Some(bytes) = source.embedded.get(path) {
        return Some(Ok(bytes.to_vec()));
    }
    let is_named = source.material.slots().any(|(_, slot)| slot.texture.as_ref().is_some_and(|texture| texture.path == path));
    if !is_named {
        return None;
    }
    Some(match files::texture_path(path, source.folder.as_deref()) {
        Some(place) => files::read_file(&place, MAX_IMAGE_BYTES).map_err(|error| error.to_string()),
        None => files::make_built_in_texture(path).and_then(|image| {
            let rgba: Vec<u8> = image.texels.iter().flatten().map(|x| (x.clamp(0.0, 1.0) * 255.0 + 0.5) as u8).collect();
            rgba_png(image.width, image.height, &rgba)
        }),
    })
}

/// Names beside a document for the images of some materials.
pub(super) fn names_of(sources: &[Source]) -> FileNames {
    let slots = sources.iter().flat_map(|source| source.material.slots());
    FileNames::of(slots.filter_map(|(_, slot)| slot.texture.as_ref()).map(|texture| texture.path.as_str()))
}
