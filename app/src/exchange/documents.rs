//! Documents of the formats that translate: what is written, and the images beside it.

use super::Format;
use super::bake::bake;
use super::error::{ExchangeError, Fault};
use super::save::{Beside, SaveOptions, Source, image_bytes, names_of, stem};
use crate::export::rgba_png;
use burnish_assets::{Image, Mesh};
use burnish_material::exchange::loss::Row;
use burnish_material::exchange::model::{Context, Translation};
use burnish_material::exchange::plan::Job;
use burnish_material::exchange::{ShadingModel, filament, gltf, materialx, models, usd};
use burnish_material::{Material, TextureRef};
use std::collections::BTreeSet;
use std::path::Path;

fn translated(sources: &[Source], model: &ShadingModel, options: SaveOptions<'_>) -> Vec<Translation> {
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

/// The bytes of a document, and what becomes of each property of each material.
pub(super) type Document = (Vec<u8>, Vec<Vec<Row>>);

pub(super) fn of_gltf(
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

pub(super) fn of_materialx(
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

pub(super) fn of_filament(
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

pub(super) fn of_usd(
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
pub(super) fn copy_all(source: &Source, beside: &mut Beside, file: &dyn Fn(&str) -> String) {
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
