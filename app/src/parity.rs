//! How far the preview is from the final view: same scene, camera and display transform, on the pictures as they are shown.
//!
//! The final counts as the mean of two renderings of different seeds; how far those are apart is the noise that no preview could be better
//! than.

use burnish_material::{PROPERTIES, Property, Slot, idle_lobe};
use burnish_renderer::metrics::{flip, quantile};
use burnish_renderer::path::{Prepared, Progress, Settings, StopRules, aovs, render_prepared};
use burnish_renderer::preview::{Preview, PreviewError};
use burnish_renderer::scene::Scene;
use burnish_renderer::tonemap::Display;
use egui_wgpu::wgpu;
use std::sync::Arc;
use std::time::Instant;

/// Longest side of the pictures that properties are switched off in.
const RANKING_SIDE: usize = 96;
/// Samples per pixel of those pictures: rays, and each of the two finals.
const RANKING_SAMPLES: [u32; 2] = [32, 128];
/// Least weight of a pixel's luminance in means: black objects have none to compare.
const BLACK: f64 = 1e-6;

/// What to compare, and how well.
#[derive(Clone, Copy, Debug)]
pub struct ParitySettings {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Samples per pixel of the rays in the accumulated picture.
    pub samples: u32,
    /// Samples per pixel of each of the two finals.
    pub final_samples: u32,
    /// Random stream of the finals.
    pub seed: u64,
    /// Threads that render them.
    pub threads: usize,
    /// How radiance is shown.
    pub display: Display,
}

/// One picture of the preview beside the final.
#[derive(Clone, Debug)]
pub struct Difference {
    /// Mean of FLIP.
    pub flip_mean: f64,
    /// Its 99th percentile.
    pub flip_p99: f64,
    /// FLIP by pixel.
    pub flip: Vec<f32>,
    /// Mean radiance of the preview.
    pub mean: f64,
    /// Luminance of the preview over that of the final, on the edited object and on everything else; `None` where the final is black.
    pub luminance: [Option<f64>; 2],
    /// Linear radiance of the preview.
    pub pixels: Vec<[f32; 3]>,
}

/// The comparison of a scene.
#[derive(Clone, Debug)]
pub struct Parity {
    /// The first picture, drawn at once.
    pub first: Difference,
    /// The picture after all samples.
    pub accumulated: Difference,
    /// FLIP between the two finals.
    pub noise: f64,
    /// Mean radiance of the final.
    pub mean_final: f64,
    /// Linear radiance of the final.
    pub final_pixels: Vec<[f32; 3]>,
    /// Samples per pixel that the rays brought.
    pub samples: u32,
    /// Why there were no rays.
    pub rays_problem: Option<String>,
}

/// What switching a property off does to the difference.
#[derive(Clone, Copy, Debug)]
pub struct Explained {
    /// The property, set to its default in both views.
    pub property: Property,
    /// By how much FLIP is smaller then; below 0 where it is larger.
    pub flip: f64,
}

/// Where the work is.
#[derive(Clone, Copy, Debug)]
pub enum Stage {
    /// One of the two finals, and its samples so far.
    Final(u32, u32),
    /// The preview, and its samples so far.
    Preview(u32),
    /// A property is switched off.
    Ranking(Property),
}

/// Why there is no comparison.
#[derive(Clone, Debug)]
pub enum ParityError {
    /// The preview cannot draw.
    Preview(PreviewError),
    /// The caller wanted no more.
    Cancelled,
}

impl From<PreviewError> for ParityError {
    fn from(error: PreviewError) -> Self {
        Self::Preview(error)
    }
}

/// Compares. `go_on` is told where the work is and answers whether to go on.
pub fn compare(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    scene: &Scene,
    settings: &ParitySettings,
    go_on: &mut dyn FnMut(Stage) -> bool,
) -> Result<Parity, ParityError> {
    let ParitySettings { width, height, display, .. } = *settings;
    let finals = finals(scene, settings, go_on).ok_or(ParityError::Cancelled)?;
    let shown = |pixels: &[[f32; 3]]| -> Vec<[f32; 3]> { pixels.iter().map(|c| display.apply(*c)).collect() };
    let [a, b] = &finals;
    let noise = average(&flip(&shown(a), &shown(b), width));
    let truth: Vec<[f32; 3]> = a.iter().zip(b).map(|(a, b)| [0, 1, 2].map(|k| 0.5 * (a[k] + b[k]))).collect();
    let is_object = object_mask(scene, width, height);
    let shown_truth = shown(&truth);
    let difference = |pixels: Vec<[f32; 4]>| {
        let pixels: Vec<[f32; 3]> = pixels.into_iter().map(|[r, g, b, _]| [r, g, b]).collect();
        let flip = flip(&shown(&pixels), &shown_truth, width);
        let luminance = [true, false].map(|of_object| {
            let sum = |pixels: &[[f32; 3]]| -> f64 {
                pixels.iter().zip(&is_object).filter(|(_, is)| **is == of_object).map(|(c, _)| luminance(c)).sum()
            };
            let of_final = sum(&truth);
            (of_final > BLACK * truth.len() as f64).then(|| sum(&pixels) / of_final)
        });
        Difference { flip_mean: average(&flip), flip_p99: quantile(&flip, 0.99), mean: mean(&pixels), flip, luminance, pixels }
    };

    let mut preview = Preview::new(device, queue)?;
    preview.set_scene(device, queue, scene);
    let (columns, rows) = (width as u32, height as u32);
    let first = preview.render(device, queue, columns, rows, 1)?;
    while preview.ray_samples() < settings.samples {
        if !go_on(Stage::Preview(preview.ray_samples())) {
            return Err(ParityError::Cancelled);
        }
        if !preview.render_more(device, queue, columns, rows, display)? {
            break;
        }
    }
    if let Some(error) = preview.error() {
        return Err(error.clone().into());
    }
    let accumulated = preview.read_linear(device, queue)?;
    Ok(Parity {
        first: difference(first),
        accumulated: difference(accumulated),
        noise,
        mean_final: mean(&truth),
        samples: preview.ray_samples(),
        rays_problem: preview.rays_problem().map(ToString::to_string),
        final_pixels: truth,
    })
}

/// Which properties explain the difference: each that is not at its default is set to it in both views, in small pictures. The one whose
/// absence brings the views nearest comes first.
pub fn rank(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    scene: &Scene,
    settings: &ParitySettings,
    go_on: &mut dyn FnMut(Stage) -> bool,
) -> Result<Vec<Explained>, ParityError> {
    let Some(material) = scene.objects.iter().find(|o| o.is_document).map(|o| o.material.clone()) else { return Ok(Vec::new()) };
    let divisor = (settings.width.max(settings.height) as f64 / RANKING_SIDE as f64).max(1.0);
    let side = |pixels: usize| ((pixels as f64 / divisor).round() as usize).max(8);
    let small = ParitySettings {
        width: side(settings.width),
        height: side(settings.height),
        samples: RANKING_SAMPLES[0],
        final_samples: RANKING_SAMPLES[1],
        ..*settings
    };
    let mut flip_of = |scene: &Scene, stage: Stage| -> Result<f64, ParityError> {
        if !go_on(stage) {
            return Err(ParityError::Cancelled);
        }
        Ok(compare(device, queue, scene, &small, &mut |_| go_on(stage))?.accumulated.flip_mean)
    };
    let candidates: Vec<Property> = PROPERTIES
        .iter()
        .map(|def| def.id)
        .filter(|p| *material.slot(*p) != Slot::default() && idle_lobe(&material, *p).is_none())
        .collect();
    let Some(first) = candidates.first() else { return Ok(Vec::new()) };
    let whole = flip_of(scene, Stage::Ranking(*first))?;
    let mut ranked = Vec::new();
    for property in candidates {
        let mut plain = (*material).clone();
        *plain.slot_mut(property) = Slot::default();
        let (plain, mut without) = (Arc::new(plain), scene.clone());
        without.objects.iter_mut().filter(|o| o.is_document).for_each(|o| o.material = plain.clone());
        ranked.push(Explained { property, flip: whole - flip_of(&without, Stage::Ranking(property))? });
    }
    ranked.sort_by(|a, b| b.flip.total_cmp(&a.flip));
    Ok(ranked)
}

/// Two renderings of different seeds.
fn finals(scene: &Scene, settings: &ParitySettings, go_on: &mut dyn FnMut(Stage) -> bool) -> Option<[Vec<[f32; 3]>; 2]> {
    let prepared = Prepared::new(scene, None);
    let mut render = |number: u32| {
        let job = Settings {
            width: settings.width,
            height: settings.height,
            seed: settings.seed + 1_000_003 * u64::from(number),
            threads: settings.threads,
            stop: StopRules { spp: Some(settings.final_samples), seconds: None, relmse: None },
            is_adaptive: true,
        };
        let mut is_cancelled = false;
        let rendering = render_prepared(&prepared, &job, Instant::now(), &mut |progress: &Progress<'_>| {
            is_cancelled = !go_on(Stage::Final(number, progress.film.spp()));
            !is_cancelled
        });
        (!is_cancelled).then(|| rendering.film.mean())
    };
    Some([render(0)?, render(1)?])
}

/// Pixels that show an object with the edited material.
fn object_mask(scene: &Scene, width: usize, height: usize) -> Vec<bool> {
    let all = aovs(&Prepared::new(scene, None), width, height).depth;
    let mut stand = scene.clone();
    stand.objects.retain(|object| !object.is_document);
    let stand = aovs(&Prepared::new(&stand, None), width, height).depth;
    all.iter().zip(&stand).map(|(all, stand)| all != stand).collect()
}

fn luminance(c: &[f32; 3]) -> f64 {
    0.212_639 * f64::from(c[0]) + 0.715_168_7 * f64::from(c[1]) + 0.072_192_3 * f64::from(c[2])
}

fn mean(pixels: &[[f32; 3]]) -> f64 {
    pixels.iter().flatten().map(|x| f64::from(*x)).sum::<f64>() / (3 * pixels.len()).max(1) as f64
}

fn average(values: &[f32]) -> f64 {
    values.iter().map(|e| f64::from(*e)).sum::<f64>() / values.len().max(1) as f64
}
