//! What is known of an environment's map before anything is drawn from it: texels as they are read, and tables of where they are bright.

#![allow(clippy::needless_range_loop, reason = "one number runs over several arrays of lanes or axes")]

use super::super::distribution::Distribution;
use super::super::flat::FlatLight;
use super::super::irradiance::{BLOCK_ROWS, Irradiance};
use crate::lanes::Lanes;
use burnish_assets::Environment;
use half::f16;
use std::f64::consts::PI;
use std::sync::{Arc, OnceLock};

/// Luminance of linear Rec.709.
pub(super) const LUMINANCE: [f64; 3] = [0.212_639_0, 0.715_168_7, 0.072_192_3];
/// Least number of rows of the table; there are twice as many columns.
const ROWS_MIN: usize = 256;
/// Largest number of rows; finer maps are summed up.
const ROWS_MAX: usize = 512;
/// Least share of a map's power that is worth photons.
const HOT_SHARE_MIN: f64 = 0.05;
/// Luminance over the mean of the map from which light is hot. Any value is exact.
pub(super) const HOT: f64 = 4.0;
/// What [`Lanes::halves`] are to be multiplied by.
pub(super) const HALVES: f64 = 5_192_296_858_534_827_628_530_496_329_220_096.0;

/// Tables of one map; independent of rotation and scale.
#[derive(Debug)]
pub(in crate::path) struct LightTables {
    pub(super) map: Arc<Environment>,
    pub(super) rows: usize,
    pub(super) columns: usize,
    /// Mean luminance of the map over the sphere.
    pub(super) mean: f64,
    /// For light sampling; `None` if nothing is brighter than the mean.
    pub(super) compensated: Option<Distribution>,
    /// For surfaces that scatter evenly, made when first asked for; `None` in the dark.
    irradiance: OnceLock<Option<Irradiance>>,
    /// For hot light, made when first asked for.
    hot: OnceLock<Option<Distribution>>,
    /// Texels in half precision: red in the lower and green in the upper bits of the first word, blue in the second. The first column is
    /// repeated behind the last: `height` rows of `width + 1`.
    pub(super) texels: Vec<[f32; 2]>,
    /// Radiance of a texel that holds 1.
    pub(super) unit: f64,
}

impl LightTables {
    /// Tables of a map, in double precision until they are stored.
    pub(in crate::path) fn new(map: &Arc<Environment>) -> Self {
        let (width, height) = (map.width.max(1), map.height.max(1));
        let rows = height.clamp(ROWS_MIN, ROWS_MAX).next_multiple_of(BLOCK_ROWS);
        let columns = 2 * rows;
        // A power of two that brings the brightest texel to the upper end of half precision: dark ones keep their digits.
        let brightest = map.texels.iter().flatten().fold(0.0f32, |a, b| if b.is_finite() { a.max(*b) } else { a });
        let exponent = (14 - brightest.max(f32::MIN_POSITIVE).log2().floor() as i32).clamp(-100, 100);
        let scale = 2f32.powi(exponent);
        let half = |x: f32| u32::from(f16::from_f32((x * scale).clamp(0.0, f32::from(f16::MAX))).to_bits());
        let mut texels = Vec::with_capacity((width + 1) * height);
        for j in 0..height {
            for i in 0..=width {
                let [r, g, b] = map.texels.get(j * width + i % width).copied().unwrap_or_default().map(half);
                texels.push([f32::from_bits(r | g << 16), f32::from_bits(b)]);
            }
        }
        let mut tables = Self {
            map: map.clone(),
            rows,
            columns,
            mean: 0.0,
            compensated: None,
            irradiance: OnceLock::new(),
            hot: OnceLock::new(),
            texels,
            unit: 2f64.powi(-exponent),
        };
        tables.mean = tables.mean_above(0.0);
        tables.compensated = Distribution::new(&tables.mass_above(tables.mean), rows, columns);
        tables
    }

    /// Tables for surfaces that scatter evenly.
    pub(super) fn irradiance(&self) -> Option<&Irradiance> {
        let make = || Irradiance::new(&self.mass_above(0.0), self.rows, self.columns);
        self.irradiance.get_or_init(make).as_ref()
    }

    /// The table of hot light; `None` if a map has too little of it.
    pub(super) fn hot(&self) -> Option<&Distribution> {
        let make = || {
            let threshold = HOT * self.mean;
            let is_worth_it = self.mean_above(threshold) >= HOT_SHARE_MIN * self.mean;
            is_worth_it.then(|| Distribution::new(&self.mass_above(threshold), self.rows, self.columns)).flatten()
        };
        self.hot.get_or_init(make).as_ref()
    }

    /// Luminance of a texel.
    fn luminance(&self, texel: &[f32; 2]) -> f64 {
        let ((r, g), (b, _)) = (texel[0].halves(), texel[1].halves());
        let [r, g, b] = [r, g, b].map(|x| f64::from(x) * HALVES * self.unit);
        LUMINANCE[0] * r + LUMINANCE[1] * g + LUMINANCE[2] * b
    }

    /// Mean over the sphere of the luminance above a threshold.
    fn mean_above(&self, threshold: f64) -> f64 {
        let (width, height) = (self.map.width.max(1), self.map.height.max(1));
        let (mut mean, mut weight) = (0.0, 0.0);
        for (j, row) in self.texels.chunks(width + 1).enumerate() {
            let sin = ((j as f64 + 0.5) / height as f64 * PI).sin();
            mean += sin * row[..width].iter().map(|c| (self.luminance(c) - threshold).max(0.0)).sum::<f64>() / width as f64;
            weight += sin;
        }
        mean / weight
    }

    /// The table for light sampling as one array; `None` if nothing is brighter than the mean.
    pub(in crate::path) fn flat(&self) -> Option<FlatLight> {
        let table = self.compensated.as_ref()?;
        Some(FlatLight { rows: self.rows, columns: self.columns, values: table.flat() })
    }

    /// Whether the tables are those of this map.
    pub(in crate::path) fn is_of(&self, map: &Arc<Environment>) -> bool {
        Arc::ptr_eq(&self.map, map)
    }

    /// Largest luminance above a threshold of each cell, times its solid angle. The largest of nine points, because that is the maximum of
    /// a bilinear surface with texels as large as cells: with the value at the centre, the neighbours of a sun would hold light
    /// and have density 0.
    fn mass_above(&self, threshold: f64) -> Vec<f64> {
        let (width, height) = (self.map.width.max(1), self.map.height.max(1));
        // A lattice of texel centres and everything halfway between them, refined or thinned to the cells.
        let per_cell_x = width.div_ceil(self.columns);
        let per_cell_y = height.div_ceil(self.rows);
        let (nx, ny) = (2 * self.columns * per_cell_x, 2 * self.rows * per_cell_y);
        let mut mass = vec![0.0f64; self.rows * self.columns];
        let columns: Vec<(usize, f64)> = (0..nx)
            .map(|i| {
                let x = (i as f64 / nx as f64 * width as f64 - 0.5).rem_euclid(width as f64);
                ((x as usize).min(width - 1), x.fract())
            })
            .collect();
        let lattice_row = |j: usize| -> Vec<f64> {
            let y = (j as f64 / ny as f64 * height as f64 - 0.5).clamp(0.0, (height - 1) as f64);
            let (j0, fy) = (y as usize, y.fract());
            let j1 = (j0 + 1).min(height - 1);
            let (a, b) = (&self.texels[j0 * (width + 1)..], &self.texels[j1 * (width + 1)..]);
            columns
                .iter()
                .map(|&(i, fx)| {
                    let upper = self.luminance(&a[i]) * (1.0 - fx) + self.luminance(&a[i + 1]) * fx;
                    let lower = self.luminance(&b[i]) * (1.0 - fx) + self.luminance(&b[i + 1]) * fx;
                    (upper * (1.0 - fy) + lower * fy - threshold).max(0.0)
                })
                .collect()
        };
        let mut above = lattice_row(0);
        for sub in 0..ny / 2 {
            let (middle, below) = (lattice_row(2 * sub + 1), lattice_row(2 * sub + 2));
            let j = sub / per_cell_y;
            let sin = ((sub as f64 + 0.5) / (ny / 2) as f64 * PI).sin();
            for i in 0..nx / 2 {
                let mut largest = 0.0f64;
                for row in [&above, &middle, &below] {
                    for k in 0..3 {
                        largest = largest.max(row[(2 * i + k) % nx]);
                    }
                }
                mass[j * self.columns + i / per_cell_x] += largest * sin;
            }
            above = below;
        }
        let total: f64 = mass.iter().sum();
        // Rounding of the mean must not make a light of a constant map.
        if total <= 1e-5 * self.mean * (nx * ny / 4) as f64 {
            mass.fill(0.0);
        }
        mass
    }
}
