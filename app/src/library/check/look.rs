//! Small pictures to compare: of what material is this, to the eye?

use super::super::pictures::load;
use burnish_renderer::path::{Prepared, Settings, StopReason, StopRules, render_prepared};
use burnish_renderer::scene::Scene;
use burnish_renderer::tonemap::{Display, srgb_decode};
use std::path::Path;
use std::time::Instant;

/// Columns and rows that are compared.
const SIDE: usize = 32;
/// Columns and rows that are rendered, and samples in each pixel: the same random numbers for all, so that noise is no difference.
const RENDERED: (usize, u32) = (64, 16);
/// Radiance, as a display shows it, below which differences count absolutely: that of relMSE.
const FLOOR: f32 = 0.1;

/// Pictures closer than this look the same: 0.3 %.
pub const ALIKE: f64 = 0.003;

/// A picture of 32 × 32 pixels, in steps of equal relative difference.
#[derive(Clone, Debug, PartialEq)]
pub struct Look {
    tones: Vec<f32>,
    mean: f32,
}

impl Look {
    /// The picture in a file; `None` if it cannot be used.
    pub fn load(path: &Path) -> Option<Self> {
        let picture = load(path)?;
        let pixels: Vec<[f32; 3]> = picture
            .rgba
            .as_chunks::<4>()
            .0
            .iter()
            .map(|[r, g, b, _]| [*r, *g, *b].map(|x| srgb_decode(f32::from(x) / 255.0)))
            .collect();
        Self::of(&pixels, picture.width as usize)
    }

    /// Renders a scene in some tenths of a second on this thread. `None` if it is cancelled. What the scene shares with `last` is taken from there.
    pub fn render(scene: &Scene, last: &mut Option<Prepared>, is_cancelled: &(dyn Fn() -> bool + Sync)) -> Option<Self> {
        let (side, spp) = RENDERED;
        let prepared = &*last.insert(Prepared::new(scene, last.as_ref()));
        let stop = StopRules { spp: Some(spp), seconds: None, relmse: None };
        let settings = Settings { width: side, height: side, seed: 0, threads: 1, stop, is_adaptive: false };
        let rendering = render_prepared(prepared, &settings, Instant::now(), &mut |_| !is_cancelled());
        if rendering.stop_reason == StopReason::Cancelled {
            return None;
        }
        let display = Display::default();
        let pixels: Vec<[f32; 3]> = rendering.film.mean().iter().map(|rgb| display.apply(*rgb).map(srgb_decode)).collect();
        Self::of(&pixels, side)
    }

    /// The look of linear pixels in `[0, 1]`, row by row of `width`; `None` if there are none.
    pub fn of(pixels: &[[f32; 3]], width: usize) -> Option<Self> {
        let height = pixels.len().checked_div(width).filter(|height| *height > 0)?;
        let span = |at: usize, length: usize| {
            let start = at * length / SIDE;
            start..((at + 1) * length / SIDE).max(start + 1)
        };
        let mut tones = Vec::with_capacity(3 * SIDE * SIDE);
        for (row, column) in (0..SIDE).flat_map(|row| (0..SIDE).map(move |column| (row, column))) {
            let mut sum = [0.0_f32; 3];
            let (rows, columns) = (span(row, height), span(column, width));
            let count = (rows.len() * columns.len()) as f32;
            for y in rows {
                for pixel in &pixels[y * width..][columns.clone()] {
                    (0..3).for_each(|c| sum[c] += pixel[c]);
                }
            }
            // Equal steps of this are equal relative differences above the floor.
            tones.extend(sum.map(|sum| (sum / count / FLOOR).asinh()));
        }
        let mean = tones.iter().sum::<f32>() / tones.len() as f32;
        Some(Self { tones, mean })
    }

    /// How far two pictures are apart: near 0 the root of relMSE, for which 0.01 is 1 %. Symmetric, and never less than the difference of the means.
    pub fn distance(&self, other: &Self) -> f64 {
        let sum: f64 = self.tones.iter().zip(&other.tones).map(|(a, b)| f64::from(a - b).powi(2)).sum();
        (sum / self.tones.len() as f64).sqrt()
    }

    /// Mean of all tones, at least 0.
    pub(super) fn mean(&self) -> f32 {
        self.mean
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distance_is_relative_difference() {
        let grey = |x: f32| Look::of(&vec![[x; 3]; 64 * 48], 64).unwrap();
        for (x, share) in [(0.5_f32, 0.002_f32), (0.2, 0.01), (0.9, -0.003)] {
            let relmse = f64::from(x * share).powi(2) / (f64::from(x).powi(2) + 0.01);
            let distance = grey(x).distance(&grey(x * (1.0 + share)));
            assert!((distance / relmse.sqrt() - 1.0).abs() < 0.02, "{x} {share}: {distance}");
        }
        assert_eq!(grey(0.3).distance(&grey(0.3)), 0.0);
        assert_eq!(Look::of(&[], 0), None);
        // Smaller pictures are compared, too.
        assert_eq!(Look::of(&[[0.5; 3]; 4], 2).unwrap().distance(&grey(0.5)), 0.0);
    }
}
