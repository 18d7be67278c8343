//! Small pictures of a case: what was dropped, what is brighter than white, and the time beside that of a plain material.

use super::{Numbers, TIME_RATIO_MAX};
use crate::path::{Film, Prepared, render_pass};
use crate::scene::{EnvironmentLight, Scene};
use burnish_assets::Environment;
use burnish_material::{Lobe, LobeSet, Material, Property, Slot, Value};
use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant};

/// Pixels a side: a picture of an object still has grazing and facing parts.
const SIDE: usize = 16;
/// Samples per pixel of a picture.
const SPP: u32 = 4;
/// Pictures of the case and of the plain material that take turns; the median of the ratios counts.
const REPEATS: usize = 3;
/// Samples per pixel in a white surrounding.
const FURNACE_SPP: u32 = 16;
/// With fewer bounces even white glass is dark.
const BOUNCES_MIN: u32 = 4;
/// Standard errors by which a picture must be too bright.
const SIGMAS: f64 = 6.0;

/// Renders the prepared case. Returns what was prepared, for the next case to take from; `None` if cancelled.
pub(super) fn probe(
    scene: &Scene,
    prepared: Prepared,
    numbers: &mut Numbers,
    cancel: &(dyn Fn() -> bool + Sync),
) -> Option<Prepared> {
    let plain = Prepared::new(&plain(scene), Some(&prepared));
    let mut dropped = (0, 0);
    let mut film = Film::new(SIDE, SIDE);
    let mut is_endless = false;
    let limit = std::cell::Cell::new(None::<Duration>);
    let ratio = time_ratio(
        REPEATS,
        &mut || {
            let mut other = Film::new(SIDE, SIDE);
            let begin = Instant::now();
            render_pass(&plain, &mut other, SPP, 1, 1, cancel)?;
            // Far beyond the limit there is nothing to learn from waiting for the end.
            limit.set(Some(begin.elapsed().mul_f64(4.0 * TIME_RATIO_MAX)));
            Some(())
        },
        &mut || {
            let begin = Instant::now();
            let end = limit.get();
            let stop = || cancel() || end.is_some_and(|end| begin.elapsed() > end);
            match render_pass(&prepared, &mut film, SPP, 1, 1, &stop) {
                Some(stats) => {
                    dropped.0 += stats.nonfinite;
                    dropped.1 += stats.negative;
                    Some(())
                }
                None if cancel() => None,
                None => {
                    is_endless = true;
                    Some(())
                }
            }
        },
    )?;
    numbers.time_ratio = ratio;
    if dropped != (0, 0) {
        numbers.nonfinite += dropped.0;
        numbers.negative += dropped.1;
        note(numbers, "samples of a picture");
    }
    check_pixels(&film, numbers);
    // What emits is brighter than its surroundings, and what takes for ever does not get another picture.
    let emits = scene.objects.iter().any(|o| LobeSet::of(&o.material).has(Lobe::emission));
    let mut kept = prepared;
    if !emits && !is_endless {
        let furnace = Prepared::new(&Scene { environment: white_light(), ..scene.clone() }, Some(&kept));
        let mut film = Film::new(SIDE, SIDE);
        let stats = render_pass(&furnace, &mut film, FURNACE_SPP, 2, 1, cancel)?;
        if stats.nonfinite + stats.negative > 0 {
            numbers.nonfinite += stats.nonfinite;
            numbers.negative += stats.negative;
            note(numbers, "samples of a picture in a white surrounding");
        }
        check_pixels(&film, numbers);
        numbers.brightness = Some(brightness(&film.mean(), &film.alpha()));
        if let Some(white) = whitened(scene) {
            let white = Prepared::new(&white, Some(&furnace));
            let mut film = Film::new(SIDE, SIDE);
            render_pass(&white, &mut film, SPP, 3, 1, cancel)?;
            numbers.darkness = Some(darkness(&film.mean(), &film.alpha()));
        }
        kept = furnace;
    }
    Some(kept)
}

fn note(numbers: &mut Numbers, what: &str) {
    if numbers.first_bad.is_empty() {
        numbers.first_bad = what.to_owned();
    }
}

fn check_pixels(film: &Film, numbers: &mut Numbers) {
    for (i, pixel) in film.mean().iter().enumerate() {
        let is_finite = pixel.iter().all(|c| c.is_finite());
        if !is_finite || pixel.iter().any(|c| *c < 0.0) {
            numbers.nonfinite += u64::from(!is_finite);
            numbers.negative += u64::from(is_finite);
            note(numbers, &format!("pixel {}, {} of a picture", i % film.width, i / film.width));
        }
    }
}

/// How far the pixels that show the object are above 1 on average, beyond what may be chance. The brightest channel; at least 0.
///
/// A single pixel of few samples may be brighter by chance; their mean over the picture may not.
pub(super) fn brightness(pixels: &[[f32; 3]], alpha: &[f32]) -> f64 {
    let excess = |k: usize| {
        let (mut count, mut sum, mut squares) = (0.0, 0.0, 0.0);
        for (pixel, alpha) in pixels.iter().zip(alpha) {
            if *alpha > 0.0 {
                // What shows beside the object is exactly 1.
                let x = f64::from(pixel[k]) - 1.0;
                count += f64::from(*alpha);
                sum += x;
                squares += x * x;
            }
        }
        if count < 1.0 {
            return 0.0;
        }
        sum / count - SIGMAS * squares.sqrt() / count
    };
    (0..3).map(excess).fold(0.0, f64::max)
}

/// 1 less the mean of the pixels that show the object, in the darkest channel; at least 0.
fn darkness(pixels: &[[f32; 3]], alpha: &[f32]) -> f64 {
    let shown = || pixels.iter().zip(alpha).filter(|(_, alpha)| **alpha > 0.0);
    let weight: f64 = shown().map(|(_, alpha)| f64::from(*alpha)).sum();
    let lost = |k: usize| shown().map(|(pixel, _)| 1.0 - f64::from(pixel[k])).sum::<f64>() / weight.max(1.0);
    (0..3).map(lost).fold(0.0, f64::max)
}

/// The scene in white light with white tints and no images of tints; `None` where light may be lost all the same: in a medium (its
/// walks are long), with few bounces, or with a camera inside, where displacement may bring it.
fn whitened(scene: &Scene) -> Option<Scene> {
    use Property as P;
    let mut scene = Scene { environment: white_light(), ..scene.clone() };
    let bounds = scene.document_bounds();
    let distance = scene.camera.origin.distance(bounds.center());
    if scene.max_bounces < BOUNCES_MIN || distance <= 1.01 * bounds.radius() || scene.objects.iter().any(|o| !o.is_document) {
        return None;
    }
    for object in &mut scene.objects {
        let lobes = LobeSet::of(&object.material);
        if lobes.has(Lobe::scattering) || lobes.has(Lobe::height) {
            return None;
        }
        let mut material = (*object.material).clone();
        for property in [P::base_color, P::specular_edge_color, P::sheen_color, P::absorption_color, P::coat_color] {
            *material.slot_mut(property) = Slot { value: Some(Value::Color([1.0; 3])), texture: None };
        }
        object.material = Arc::new(material);
    }
    Some(scene)
}

/// Median of the ratios of the times of `case` over those of `plain`, which take turns, so that what else the machine does weighs on
/// both. `None` as soon as one of them gives up.
pub fn time_ratio(repeats: usize, plain: &mut dyn FnMut() -> Option<()>, case: &mut dyn FnMut() -> Option<()>) -> Option<f64> {
    let mut ratios = Vec::with_capacity(repeats);
    for _ in 0..repeats.max(1) {
        let begin = Instant::now();
        plain()?;
        let middle = Instant::now();
        case()?;
        ratios.push(middle.elapsed().as_secs_f64() / (middle - begin).as_secs_f64().max(1e-9));
        // One that is far beyond every limit is not repeated.
        if ratios[0] > 2.0 * TIME_RATIO_MAX {
            break;
        }
    }
    ratios.sort_by(f64::total_cmp);
    Some(ratios[ratios.len() / 2])
}

/// The scene with a plain material on the document's objects.
fn plain(scene: &Scene) -> Scene {
    let mut scene = scene.clone();
    let material = Arc::new(Material::named("plain"));
    for object in scene.objects.iter_mut().filter(|object| object.is_document) {
        object.material = material.clone();
        object.textures = Arc::default();
        object.length_scale = 1.0;
    }
    scene
}

/// Radiance 1 from everywhere. Always the same map, so that its tables are made once.
fn white_light() -> EnvironmentLight {
    static MAP: OnceLock<Arc<Environment>> = OnceLock::new();
    let map = MAP.get_or_init(|| Arc::new(Environment { name: "white".into(), width: 2, height: 1, texels: vec![[1.0; 3]; 2] }));
    EnvironmentLight { map: map.clone(), rotation_deg: 0.0, scale: 1.0 }
}
