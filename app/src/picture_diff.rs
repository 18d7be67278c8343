//! Two materials drawn in one scene, and how far the pictures are apart, pixel by pixel (FLIP): for `diff --image` and for the window.

use crate::heatmap::{Heatmap, heatmap};
use burnish_renderer::metrics::flip;
use burnish_renderer::path::{Prepared, Settings, StopReason, StopRules, render_prepared};
use burnish_renderer::scene::Scene;
use burnish_renderer::tonemap::Display;
use std::time::Instant;

/// Error at which each of the two pictures is done: 2 %.
const RELMSE: f64 = 0.0004;

/// How both are drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drawing {
    /// Columns and rows, at least 1 each.
    pub size: [usize; 2],
    /// Random stream.
    pub seed: u64,
    /// Threads; 0 counts as 1.
    pub threads: usize,
    /// Seconds after which each of the two is done, if its error is not below 2 % before.
    pub seconds: f64,
    /// How radiance becomes colours.
    pub display: Display,
}

/// Both pictures and their difference.
#[derive(Clone, Debug, PartialEq)]
pub struct PictureDiff {
    /// Columns.
    pub width: usize,
    /// Both pictures, display-referred, row by row from the top.
    pub pictures: [Vec<[f32; 3]>; 2],
    /// The difference as a picture, with a bar below if there is room.
    pub map: Heatmap,
    /// Mean of FLIP, 0 to 1.
    pub mean: f64,
}

/// Draws two scenes. `tell` hears the share that is done, 0 to 1. `None` if it is cancelled.
pub fn draw(
    scenes: [&Scene; 2],
    drawing: &Drawing,
    tell: &mut dyn FnMut(f32),
    is_cancelled: &dyn Fn() -> bool,
) -> Option<PictureDiff> {
    let mut last = None;
    let mut one = |number: usize| {
        picture(scenes[number], &mut last, drawing, &mut |share| tell((number as f32 + share) / 2.0), is_cancelled)
    };
    let pictures = [one(0)?, one(1)?];
    let width = drawing.size[0];
    let errors = flip(&pictures[0], &pictures[1], width);
    Some(PictureDiff { width, map: heatmap(&errors, width), pictures, mean: mean(&errors) })
}

/// Draws a scene: display-referred, row by row from the top. What it shares with `last` is taken from there; it becomes that scene. `tell` hears the
/// share that is done, 0 to 1. `None` if it is cancelled.
pub fn picture(
    scene: &Scene,
    last: &mut Option<Prepared>,
    drawing: &Drawing,
    tell: &mut dyn FnMut(f32),
    is_cancelled: &dyn Fn() -> bool,
) -> Option<Vec<[f32; 3]>> {
    let [width, height] = drawing.size;
    let stop = StopRules { spp: None, seconds: Some(drawing.seconds), relmse: Some(RELMSE) };
    let settings = Settings { width, height, seed: drawing.seed, threads: drawing.threads.max(1), stop, is_adaptive: true };
    let start = Instant::now();
    let prepared = &*last.insert(Prepared::new(scene, last.as_ref()));
    let rendering = render_prepared(prepared, &settings, start, &mut |progress| {
        // The squared error falls with the number of samples.
        let by_error = progress.error.map_or(0.0, |error| RELMSE / error.relmse.max(RELMSE));
        tell(by_error.max(progress.seconds / drawing.seconds).clamp(0.0, 1.0) as f32);
        !is_cancelled()
    });
    let shown = || rendering.film.mean().iter().map(|rgb| drawing.display.apply(*rgb)).collect();
    (rendering.stop_reason != StopReason::Cancelled && !is_cancelled()).then(shown)
}

/// Mean of FLIP between two pictures of `width` columns, 0 to 1.
pub fn mean_flip(a: &[[f32; 3]], b: &[[f32; 3]], width: usize) -> f64 {
    mean(&flip(a, b, width))
}

fn mean(errors: &[f32]) -> f64 {
    errors.iter().map(|error| f64::from(*error)).sum::<f64>() / errors.len().max(1) as f64
}

impl PictureDiff {
    /// The pictures and their difference beside each other, as rows of 8-bit sRGB; its width and height.
    pub fn beside_each_other(&self) -> (Vec<u8>, usize, usize) {
        let row_of = |picture: &[[f32; 3]], y: usize| -> Vec<u8> {
            let pixels = picture.get(y * self.width..(y + 1) * self.width);
            // The map has a bar below, the others have nothing.
            pixels.map_or_else(|| vec![0; 3 * self.width], |pixels| pixels.as_flattened().iter().map(|x| byte(*x)).collect())
        };
        let mut bytes = Vec::with_capacity(9 * self.width * self.map.height);
        for y in 0..self.map.height {
            self.pictures.iter().for_each(|picture| bytes.extend(row_of(picture, y)));
            bytes.extend(&self.map.bytes[3 * self.width * y..3 * self.width * (y + 1)]);
        }
        (bytes, 3 * self.width, self.map.height)
    }

    /// One of the two pictures as 8-bit sRGB.
    pub fn bytes(&self, number: usize) -> Vec<u8> {
        self.pictures[number].as_flattened().iter().map(|x| byte(*x)).collect()
    }
}

fn byte(x: f32) -> u8 {
    (x.clamp(0.0, 1.0) * 255.0 + 0.5) as u8
}
