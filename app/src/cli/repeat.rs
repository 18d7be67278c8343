//! Making a picture again from what it says about itself.

use super::material_argument::LoadedMaterial;
use super::render::RenderArguments;
use super::scene_options::{LoadedScene, SceneOptions};
use super::{CliError, Messages};
use crate::files;
use crate::offline::picture::Repeat;
use crate::offline::picture_options::PictureOptions;
use crate::offline::tiles;
use crate::picture_file::embedded_job;
use crate::picture_job::{PROGRAM, PictureJob, Source, folder_of, hash_of};
use crate::scene_file::{MAX_SIDE, MAX_TILED_PIXELS};
use burnish_assets::{BackdropDef, make_environment, make_shape};
use burnish_renderer::path::SPP_MAX;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// What is rendered again.
pub(super) struct Again {
    /// As if the options of then had been given.
    pub arguments: RenderArguments,
    /// The scene of then.
    pub loaded: LoadedScene,
    /// How far the picture was.
    pub repeat: Repeat,
}

/// Reads the job of a picture and everything that it names. Says how the result may differ where another version made the picture.
pub(super) fn load(picture: &Path, arguments: &RenderArguments, messages: &mut Messages) -> Result<Again, CliError> {
    let name = picture.display();
    let job = embedded_job(picture).map_err(CliError::unusable)?;
    let job = job.ok_or_else(|| CliError::unusable(files::FilesError::NoMaterial { path: picture.to_path_buf() }))?;
    if let Some(difference) = job.difference() {
        messages.warn(format!("{name}: {difference}"));
    } else if job.program != PROGRAM {
        messages.warn(format!("{name}: was made by {}; {PROGRAM} makes the same bits of it", job.program));
    }
    let incomplete = |what: &str| CliError::unusable(format!("{name}: does not say {what}, so that it cannot be made again"));
    let camera = job.scene.camera.camera().ok_or_else(|| incomplete("where its camera stands"))?;
    let scene = scene_options(picture, &job, arguments)?;
    for texture in &job.textures {
        unchanged(picture, "image", &texture.file, &texture.hash)?;
    }
    let material = match (&job.scene.scene, job.scene.replaces_material) {
        (Some(_), false) => None,
        _ => {
            let (opened, texture_files) = files::open_embedded(picture, Some(&job)).map_err(CliError::unusable)?;
            opened.warnings.iter().for_each(|warning| messages.warn_about(picture, warning));
            let material = Arc::new(opened.file.material().clone());
            Some(LoadedMaterial { material, textures: opened.textures, file: Some(Arc::new(opened.file)), texture_files })
        }
    };
    let mut loaded = scene.load_tiled(None, material, messages)?;
    loaded.scene.camera = camera;
    loaded.scene.environment.rotation_deg = job.scene.rotation_deg;
    loaded.scene.max_bounces = job.scene.max_bounces;
    let loaded = loaded.turned(job.scene.turn_deg);

    let arguments = arguments.of_job(&job, PictureOptions::of_job(&job)?, scene);
    let parts = if job.view == "preview" { job.samples.len() } else { tiles::of_final(loaded.width, loaded.height).len() };
    let is_possible = |samples: &u64| samples / (loaded.width * loaded.height) as u64 <= u64::from(SPP_MAX);
    if job.samples.is_empty() || job.samples.len() != parts || !job.samples.iter().all(is_possible) {
        return Err(incomplete("how many samples it has"));
    }
    let repeat = Repeat {
        samples: job.samples,
        stop: job.stop,
        stop_reason: job.stop_reason,
        picture: picture.to_path_buf(),
        denoiser: job.denoiser,
        adapter: job.adapter,
    };
    Ok(Again { arguments, loaded, repeat })
}

/// The scene options that lead to the same scene.
fn scene_options(picture: &Path, job: &PictureJob, arguments: &RenderArguments) -> Result<SceneOptions, CliError> {
    let [width, height] = job.size;
    let sides = 1..=MAX_SIDE;
    if !sides.contains(&width) || !sides.contains(&height) || width * height > MAX_TILED_PIXELS {
        return Err(CliError::unusable(format!(
            "{}: expected a picture of at most {MAX_TILED_PIXELS} pixels, found one of {width} x {height}",
            picture.display()
        )));
    }
    let source = &job.scene;
    if source.mesh.is_none() && source.scene.is_none() {
        return Err(CliError::unusable(format!(
            "{}: does not say which scene it shows, so that it cannot be made again",
            picture.display()
        )));
    }
    for asset in &source.assets {
        text(picture, "part of the scene", Some(asset), |_| false)?;
    }
    let scene = text(picture, "scene", source.scene.as_ref(), |_| false)?.map(PathBuf::from);
    Ok(SceneOptions {
        mesh: text(picture, "mesh", source.mesh.as_ref(), |name| make_shape(name).is_some())?,
        backdrop: backdrop(picture, source.backdrop.as_deref())?,
        environment: text(picture, "environment", source.environment.as_ref(), |name| make_environment(name).is_some())?,
        scene,
        unit_mm: source.unit_mm,
        exposure: Some(f64::from(job.exposure_ev)),
        seed: job.seed,
        size: Some((width, height)),
        threads: arguments.scene.threads,
        ..SceneOptions::default()
    })
}

/// A built-in backdrop by its name.
fn backdrop(picture: &Path, name: Option<&str>) -> Result<Option<&'static BackdropDef>, CliError> {
    let Some(name) = name else { return Ok(None) };
    let unknown = || {
        CliError::unusable(format!(
            "{}: shows the built-in backdrop `{name}`, which this version does not have",
            picture.display()
        ))
    };
    BackdropDef::named(name).map(Some).ok_or_else(unknown)
}

/// What an option would say to mean the same; an error where that is not there any more or has changed.
fn text(
    picture: &Path,
    what: &str,
    source: Option<&Source>,
    is_known: impl Fn(&str) -> bool,
) -> Result<Option<String>, CliError> {
    match source {
        None => Ok(None),
        Some(Source::File { file, hash }) => unchanged(picture, what, file, hash).map(|path| Some(path.display().to_string())),
        Some(Source::BuiltIn { name }) if is_known(name) => Ok(Some(name.clone())),
        Some(Source::BuiltIn { name }) => Err(CliError::unusable(format!(
            "{}: shows the built-in {what} `{name}`, which this version does not have",
            picture.display()
        ))),
    }
}

/// A file that holds what it held when the picture was made.
fn unchanged(picture: &Path, what: &str, file: &str, hash: &str) -> Result<PathBuf, CliError> {
    let path = folder_of(picture).map_or_else(|| PathBuf::from(file), |folder| folder.join(file));
    let name = picture.display();
    match hash_of(&path) {
        Ok(found) if found == hash => Ok(path),
        Ok(_) => Err(CliError::unusable(format!(
            "{name}: the {what} {} is not what it was when the picture was made, so that it cannot be made again",
            path.display()
        ))),
        Err(error) => Err(CliError::unusable(format!("{name}: needs the {what} {}: {error}", path.display()))),
    }
}
