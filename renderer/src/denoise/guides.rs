//! What tells surfaces apart without noise: albedo, normal and depth of what the camera sees first.

use super::Prepared;
use crate::path::aovs;

/// Guides of a picture, row by row from the top; zeros where there is nothing.
#[derive(Clone, Debug, Default)]
pub struct Guides {
    /// Base colour, `[0, 1]`.
    pub albedo: Vec<[f32; 3]>,
    /// World normal, mean over the pixel: shorter than 1 at edges.
    pub normal: Vec<[f32; 3]>,
    /// The smallest depth of the picture over this depth, `[0, 1]`: linear across planes, and 0 where there is nothing.
    pub nearness: Vec<f32>,
}

/// Rays per side of a pixel: edges of the guides are as soft as those of the picture.
const GRID: usize = 2;

impl Guides {
    /// Guides of a picture of this size: four rays per pixel.
    pub fn new(prepared: &Prepared, width: usize, height: usize) -> Self {
        let fine = aovs(prepared, GRID * width, GRID * height);
        let nearest = fine.depth.iter().copied().fold(f32::INFINITY, f32::min);
        let cells = |x: usize, y: usize| {
            (0..GRID * GRID).map(move |cell| (GRID * y + cell / GRID) * GRID * width + GRID * x + cell % GRID)
        };
        let scale = 1.0 / (GRID * GRID) as f32;
        let mut out = Self::default();
        for (y, x) in (0..height).flat_map(|y| (0..width).map(move |x| (y, x))) {
            let mean = |plane: &[[f32; 3]]| std::array::from_fn(|k| scale * cells(x, y).map(|i| plane[i][k]).sum::<f32>());
            out.albedo.push(mean(&fine.albedo));
            out.normal.push(mean(&fine.normal));
            let nearness = |i: usize| if fine.depth[i].is_finite() { nearest / fine.depth[i].max(nearest) } else { 0.0 };
            out.nearness.push(scale * cells(x, y).map(nearness).sum::<f32>());
        }
        out
    }
}
