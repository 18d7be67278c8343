//! The way out: materials to a file of any format, with the images that it needs beside it or in it.

use super::bake::bake;
use super::error::{ExchangeError, Fault};
use super::names::FileNames;
use super::open::is_inside;
use super::{Format, own_text, sets};
use crate::export::rgba_png;
use crate::files::{self, Embedded, save_atomic};
use burnish_assets::{Image, Mesh};
use burnish_material::exchange::loss::Row;
use burnish_material::exchange::model::Context;
use burnish_material::exchange::plan::Job;
use burnish_material::exchange::{ShadingModel, filament, gltf, materialx, mdl, models, usd};
use burnish_material::{Material, MaterialFile, TextureRef};
use burnish_renderer::scene::TextureSet;
use std::collections::{BTreeMap, BTreeSet};
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

fn stem(path: &Path) -> String {
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

fn translated(
    sources: &[Source],
    model: &ShadingModel,
    options: SaveOptions<'_>,
) -> Vec<burnish_material::exchange::model::Translation> {
    sources.iter().map(|source| model.translate(&source.material, &context(source, options))).collect()
}

fn context(source: &Source, options: SaveOptions<'_>) -> Context {
    let of = Context::of(&source.material);
    match options.mesh {
        Some((mesh, unit)) => {
            let width = f64::from(mesh.bounds().size().x) * unit / of.meters_per_unit;
            Context { mesh_width: if width > 0.0 && width.is_finite() { width } else { 1.0 }, ..of }
        }
        None => of,
    }
}

type Document = (Vec<u8>, Vec<Vec<Row>>);

fn of_gltf(
    sources: &[Source],
    out: &Path,
    options: SaveOptions<'_>,
    beside: &mut Beside,
    go_on: &dyn Fn(f32) -> bool,
) -> Result<Document, ExchangeError> {
    let fault = |error| ExchangeError::Content { path: out.to_path_buf(), fault: Fault::Gltf(error) };
    let contexts: Vec<Context> = sources.iter().map(|source| context(source, options)).collect();
    let translations = translated(sources, &models::gltf::MODEL, options);
    let parts: Vec<gltf::Part<'_>> = sources
        .iter()
        .zip(&translations)
        .zip(&contexts)
        .map(|((source, translation), context)| gltf::Part { material: &source.material, translation, context: *context })
        .collect();
    let facts = sources.iter().flat_map(|source| &source.textures).map(|(path, image)| (path.clone(), facts(image))).collect();
    let arrays = options.mesh.map(|(mesh, unit)| Arrays::of(mesh, unit, false));
    let mesh = arrays.as_ref().map(|arrays| gltf::Mesh {
        positions: &arrays.positions,
        normals: &arrays.normals,
        tangents: &arrays.tangents,
        uvs: &arrays.uvs,
        triangles: &arrays.triangles,
    });
    let write_options = gltf::Options { has_native_copy: !options.is_bare, facts };
    let written = gltf::write(&parts, mesh.as_ref(), &write_options).map_err(fault)?;
    beside.notes.extend(written.plan.notes.iter().cloned());
    for copy in &written.plan.copies {
        let bytes = sources.iter().find_map(|source| image_bytes(source, &copy.path));
        match bytes {
            Some(Ok(bytes)) => _ = beside.files.insert(copy.file.clone(), bytes),
            Some(Err(problem)) => beside.notes.push(problem),
            None => beside.notes.push(format!("{}: expected an image, found none; not copied", copy.path)),
        }
    }
    compute(&written.plan.jobs, &models::gltf::MODEL, sources, &contexts, beside, go_on)?;
    let document = if Format::of(out) == Some(Format::Glb) {
        let images = std::mem::take(&mut beside.files);
        let glb = written.glb(|name| images.get(name).cloned()).map_err(fault)?;
        // What the binary file cannot hold stays beside it.
        let held: BTreeSet<String> =
            written.plan.copies.iter().filter(|copy| copy.is_used).map(|copy| copy.file.clone()).collect();
        let jobs: BTreeSet<&str> = written.plan.jobs.iter().map(|job| job.file.as_str()).collect();
        beside.files = images.into_iter().filter(|(name, _)| !held.contains(name) && !jobs.contains(name.as_str())).collect();
        glb
    } else {
        let buffer = format!("{}.bin", stem(out));
        if !written.buffer().is_empty() {
            beside.files.insert(buffer.clone(), written.buffer().to_vec());
        }
        written.gltf(&buffer).into_bytes()
    };
    Ok((document, translations.into_iter().map(|translation| translation.rows).collect()))
}

fn of_materialx(
    sources: &[Source],
    options: SaveOptions<'_>,
    beside: &mut Beside,
    go_on: &dyn Fn(f32) -> bool,
) -> Result<Document, ExchangeError> {
    let surface = options.model.unwrap_or(&models::open_pbr::MODEL);
    let materials: Vec<&Material> = sources.iter().map(|source| &source.material).collect();
    let names = names_of(sources);
    let path = |path: &str| names.file(path);
    let written = materialx::write(
        &materials,
        &materialx::WriteOptions { surface, path: &path, folder: "", has_native_copy: !options.is_bare },
    );
    let contexts: Vec<Context> = sources.iter().map(|source| Context::of(&source.material)).collect();
    sources.iter().for_each(|source| copy_all(source, beside, &path));
    let mut rows = Vec::new();
    for (place, material) in written.materials.into_iter().enumerate() {
        let jobs: Vec<Job> = material.images.into_iter().map(|image| Job { material: place, ..image }).collect();
        compute(&jobs, surface, sources, &contexts, beside, go_on)?;
        beside.notes.extend(material.notes);
        rows.push(material.rows);
    }
    Ok((written.text.into_bytes(), rows))
}

fn of_filament(
    source: &Source,
    stem: &str,
    options: SaveOptions<'_>,
    beside: &mut Beside,
    go_on: &dyn Fn(f32) -> bool,
) -> Result<Document, ExchangeError> {
    let names = names_of(std::slice::from_ref(source));
    let path = |path: &str| names.file(path);
    let prefix = format!("{stem}_");
    let written = filament::write(
        &source.material,
        &filament::WriteOptions { path: &path, prefix: &prefix, has_native_copy: !options.is_bare },
    );
    copy_all(source, beside, &path);
    let (sources, contexts) = (std::slice::from_ref(source), [Context::of(&source.material)]);
    compute(&written.jobs, &models::filament::MODEL, sources, &contexts, beside, go_on)?;
    Ok((written.text.into_bytes(), vec![written.rows]))
}

fn of_usd(
    sources: &[Source],
    options: SaveOptions<'_>,
    beside: &mut Beside,
    go_on: &dyn Fn(f32) -> bool,
) -> Result<(String, Vec<Vec<Row>>), ExchangeError> {
    let materials: Vec<&Material> = sources.iter().map(|source| &source.material).collect();
    let names = names_of(sources);
    let path = |path: &str| names.file(path);
    let path_of = |texture: &TextureRef| path(&texture.path);
    let arrays = options.mesh.map(|(mesh, unit)| Arrays::of(mesh, unit, true));
    let all = [(0, 0..usize::MAX)];
    let mesh = arrays.as_ref().map(|arrays| usd::MeshArrays {
        name: "Mesh",
        positions: &arrays.positions,
        normals: &arrays.normals,
        tangents: &arrays.tangents,
        uvs: &arrays.uvs,
        triangles: &arrays.triangles,
        parts: &all,
    });
    let export = usd::write(
        &materials,
        &usd::Options { path_of: &path_of, image_folder: "", mesh: mesh.as_ref(), has_native_copy: !options.is_bare },
    );
    let contexts: Vec<Context> = sources.iter().map(|source| Context::of(&source.material)).collect();
    sources.iter().for_each(|source| copy_all(source, beside, &path));
    for job in &export.images {
        compute(std::slice::from_ref(&job.job), job.model, sources, &contexts, beside, go_on)?;
    }
    beside.notes.extend(export.notes);
    let rows =
        translated(sources, &models::usd_preview::MODEL, options).into_iter().map(|translation| translation.rows).collect();
    Ok((export.text, rows))
}

/// Computes images and keeps them as PNG.
pub(super) fn compute(
    jobs: &[Job],
    model: &ShadingModel,
    sources: &[Source],
    contexts: &[Context],
    beside: &mut Beside,
    go_on: &dyn Fn(f32) -> bool,
) -> Result<(), ExchangeError> {
    for (number, job) in jobs.iter().enumerate() {
        let (Some(source), Some(context)) = (sources.get(job.material), contexts.get(job.material)) else { continue };
        let share = |share: f32| go_on((number as f32 + share) / jobs.len() as f32);
        let baked = bake(job, model, &source.material, &source.textures, context, &share).ok_or(ExchangeError::Cancelled)?;
        match rgba_png(baked.width, baked.height, &baked.rgba) {
            Ok(png) => _ = beside.files.insert(job.file.clone(), png),
            Err(problem) => beside.notes.push(format!("{}: {problem}", job.file)),
        }
    }
    Ok(())
}

/// Copies every image of a material to where `file` says.
fn copy_all(source: &Source, beside: &mut Beside, file: &dyn Fn(&str) -> String) {
    for texture in source.material.slots().filter_map(|(_, slot)| slot.texture.as_ref()) {
        let name = file(&texture.path);
        if name.is_empty() || beside.files.contains_key(&name) {
            continue;
        }
        match image_bytes(source, &texture.path) {
            Some(Ok(bytes)) => _ = beside.files.insert(name, bytes),
            Some(Err(problem)) => beside.notes.push(problem),
            None => {}
        }
    }
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

/// What is known of an image.
fn facts(image: &Image) -> gltf::Facts {
    gltf::Facts {
        is_gray: image.texels.iter().all(|[r, g, b, _]| r == g && g == b),
        is_wide: !image.is_eight_bit,
        is_opaque: image.texels.iter().all(|[.., a]| *a == 1.0),
    }
}

/// A mesh as formats take it: metres.
struct Arrays {
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    tangents: Vec<[f32; 4]>,
    uvs: Vec<[f32; 2]>,
    triangles: Vec<[u32; 3]>,
}

impl Arrays {
    fn of(mesh: &Mesh, unit: f64, is_v_up: bool) -> Self {
        let uv = |uv: &glam::Vec2| if is_v_up { [uv.x, 1.0 - uv.y] } else { uv.to_array() };
        Self {
            positions: mesh.positions.iter().map(|p| (p.as_dvec3() * unit).as_vec3().to_array()).collect(),
            normals: mesh.normals.iter().map(|n| n.to_array()).collect(),
            tangents: mesh.tangents.iter().map(|t| t.to_array()).collect(),
            uvs: mesh.uvs.iter().map(uv).collect(),
            triangles: mesh.triangles.clone(),
        }
    }
}
