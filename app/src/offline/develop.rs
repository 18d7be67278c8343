//! What becomes of the samples of the path tracer: a picture with its layers, with or without background, raw or denoised.

use super::OfflineError;
use super::picture_options::{Denoise, PictureOptions};
use super::watch::Watch;
use crate::export::{Layer, LayerKind, Picture};
use burnish_renderer::denoise::{self, DenoiseError, Denoiser, Oidn};
use burnish_renderer::path::{self, ErrorEstimate, Film, Prepared, light_layers};
use burnish_renderer::scene::Scene;
use glam::Vec3;
use std::time::Instant;

/// What is told about a denoised picture.
pub struct DenoiseReport {
    /// Which filter, with its version.
    pub denoiser: String,
    /// What it took.
    pub seconds: f64,
    /// What error is left.
    pub error: ErrorEstimate,
}

/// Linear radiance without noise, and what is told about it.
type DenoisedFilm = (Vec<[f32; 3]>, DenoiseReport);

/// Samples with what they were taken of.
pub struct Exposed<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The same, prepared.
    pub prepared: &'a Prepared,
    /// The samples.
    pub film: &'a Film,
    /// Their random stream.
    pub seed: u64,
    /// Threads that may work.
    pub threads: usize,
}

/// The finished picture without its job, and what is told about denoising.
pub fn develop(
    exposed: &Exposed<'_>,
    options: &PictureOptions,
    watch: &mut Watch<'_>,
) -> Result<(Picture, Option<DenoiseReport>), OfflineError> {
    let film = exposed.film;
    let developed = |mean: &[[f32; 3]]| {
        if options.transparent {
            without_background(exposed.scene, mean, film, [0, 0], [film.width, film.height])
        } else {
            opaque(mean)
        }
    };
    let mut pixels = developed(&film.mean());
    let (mut raw, mut denoised) = (None, None);
    if let Some(choice) = options.denoise
        && let Some((picture, report)) = denoise_film(choice, exposed, watch)?
    {
        raw = Some(std::mem::replace(&mut pixels, developed(&picture)));
        denoised = Some(report);
    }
    let picture = Picture {
        width: film.width,
        height: film.height,
        pixels,
        has_alpha: options.transparent,
        raw,
        layers: layers(exposed, &options.aov, watch)?,
        job: None,
        precision: options.precision(),
    };
    Ok((picture, denoised))
}

/// The pixels of a part of a picture.
pub fn develop_tile(scene: &Scene, film: &Film, options: &PictureOptions, at: [usize; 2], full: [usize; 2]) -> Vec<[f32; 4]> {
    let mean = film.mean();
    if options.transparent { without_background(scene, &mean, film, at, full) } else { opaque(&mean) }
}

/// The denoised mean of a film and what is told about it. `None`, with a warning, where there are too few samples.
fn denoise_film(choice: Denoise, exposed: &Exposed<'_>, watch: &mut Watch<'_>) -> Result<Option<DenoisedFilm>, OfflineError> {
    let film = exposed.film;
    let Some(input) = denoise::Input::of(film) else {
        let replicates = path::REPLICATES;
        (watch.warn)(format!(
            "denoising: expected at least {replicates} samples per pixel, found {}; the picture is not denoised",
            film.spp()
        ));
        return Ok(None);
    };
    let start = Instant::now();
    let (denoiser, problem) = match choice {
        Denoise::Auto => Denoiser::best(),
        Denoise::Own => (Denoiser::Own, None),
        Denoise::Oidn => match Oidn::find() {
            Ok(oidn) => (Denoiser::Oidn(oidn), None),
            Err(error) => (Denoiser::Own, Some(error)),
        },
    };
    if let Some(problem) = problem {
        (watch.warn)(format!("denoising: {problem}; the own filter is used"));
    }
    let guides = denoise::Guides::new(exposed.prepared, film.width, film.height);
    let denoised = denoiser.run(&input, &guides, exposed.threads, watch.is_cancelled).map_err(|error| match error {
        DenoiseError::Cancelled => OfflineError::Cancelled,
        DenoiseError::Oidn(_) => OfflineError::Denoise(error.to_string()),
    })?;
    let report = DenoiseReport { denoiser: denoiser.name(), seconds: start.elapsed().as_secs_f64(), error: denoised.error };
    Ok(Some((denoised.pixels, report)))
}

fn opaque(mean: &[[f32; 3]]) -> Vec<[f32; 4]> {
    mean.iter().map(|[r, g, b]| [*r, *g, *b, 1.0]).collect()
}

/// The picture less the environment that shows beside the objects, multiplied by coverage. The film lies at `at` in a picture of size `full`.
///
/// A film does not keep apart what arrived from where, so at edges the environment's mean over the pixel is taken off by
/// the share of samples that met nothing. That is exact where the environment is smooth within a pixel.
fn without_background(scene: &Scene, mean: &[[f32; 3]], film: &Film, at: [usize; 2], full: [usize; 2]) -> Vec<[f32; 4]> {
    /// Directions per side of a pixel.
    const GRID: usize = 4;
    let [width, height] = full;
    let basis = scene.camera.basis(width as f32 / height as f32);
    let background = |x: usize, y: usize| {
        let within = |cell: usize| (cell as f32 + 0.5) / GRID as f32;
        let sum = (0..GRID * GRID).fold(Vec3::ZERO, |sum, cell| {
            let (u, v) = (x as f32 + within(cell % GRID), y as f32 + within(cell / GRID));
            sum + scene.environment.radiance(basis.direction(u / width as f32, v / height as f32))
        });
        sum / (GRID * GRID) as f32
    };
    let pixels = mean.iter().copied().zip(film.alpha()).enumerate();
    pixels
        .map(|(i, (mean, alpha))| {
            let color = match alpha {
                0.0 => Vec3::ZERO,
                1.0 => Vec3::from(mean),
                _ => {
                    let behind = background(at[0] + i % film.width, at[1] + i / film.width);
                    (Vec3::from(mean) - (1.0 - alpha) * behind).max(Vec3::ZERO)
                }
            };
            color.extend(alpha).to_array()
        })
        .collect()
}

fn layers(exposed: &Exposed<'_>, kinds: &[LayerKind], watch: &Watch<'_>) -> Result<Vec<Layer>, OfflineError> {
    let film = exposed.film;
    let is_seen = |kind: &LayerKind| {
        matches!(kind, LayerKind::Albedo | LayerKind::Normal | LayerKind::Depth | LayerKind::Position | LayerKind::Emission)
    };
    // What the camera sees first.
    let surfaces =
        if kinds.iter().any(is_seen) { path::aovs(exposed.prepared, film.width, film.height) } else { path::Aovs::default() };
    let mut layers = Vec::new();
    for (i, kind) in kinds.iter().enumerate() {
        if kinds[..i].contains(kind) {
            continue;
        }
        let planes = match kind {
            LayerKind::Albedo => split(&surfaces.albedo),
            LayerKind::Normal => split(&surfaces.normal),
            LayerKind::Depth => vec![surfaces.depth.clone()],
            LayerKind::Position => split(&surfaces.position),
            LayerKind::Emission => split(&surfaces.emission),
            LayerKind::Variance => split(&film.variance()),
            LayerKind::Samples => vec![film.samples().into_iter().map(|count| count as f32).collect()],
            LayerKind::Error => vec![film.relative_error()],
            LayerKind::Lobes => {
                let light = light_layers(exposed.prepared, film, exposed.seed, exposed.threads, watch.is_cancelled);
                for part in light.ok_or(OfflineError::Cancelled)? {
                    layers.push(Layer { kind: *kind, part: Some(part.name), planes: split(&part.pixels) });
                }
                continue;
            }
        };
        layers.push(Layer { kind: *kind, part: None, planes });
    }
    Ok(layers)
}

fn split(values: &[[f32; 3]]) -> Vec<Vec<f32>> {
    (0..3).map(|c| values.iter().map(|value| value[c]).collect()).collect()
}
