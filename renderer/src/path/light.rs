//! The environment as a light: radiance of a direction, and directions drawn where it is bright.
//!
//! Directions are drawn in two ways. In general from rows and columns of a table proportional to `max(L - mean, 0)`: what lies below the mean
//! is left to BSDF sampling, which is always combined with it (MIS compensation; Karlik et al. 2019). So that density may only be used
//! together with BSDF sampling, and delta lobes take the full light. For a normal, in proportion to `L cos` (`irradiance`): complete by itself.
//!
//! Where a scene has caustics (`caustics`), light is divided by its radiance: what exceeds [`HOT`] times the mean of the map is *hot*, the
//! rest *cold*. Hot light has a table of its own, from which photons start.
//!
//! Emissive objects are found by BSDF sampling alone: unbiased, but noisy for small bright ones.

#![allow(clippy::needless_range_loop, reason = "one number runs over several arrays of lanes or axes")]

use super::distribution::Distribution;
use super::irradiance::{BLOCK_ROWS, Facing, Irradiance};
use crate::bsdf::interpret::EMISSION_MAX;
use crate::lanes::{Lanes, MAX_LANES, Routine};
use crate::scene::EnvironmentLight;
use crate::vector::{Rgb, V3};
use burnish_assets::Environment;
use half::f16;
use std::f64::consts::{PI, TAU};
use std::sync::{Arc, OnceLock};

/// Luminance of linear Rec.709.
const LUMINANCE: [f64; 3] = [0.212_639_0, 0.715_168_7, 0.072_192_3];
/// Least number of rows of the table; there are twice as many columns.
const ROWS_MIN: usize = 256;
/// Largest number of rows; finer maps are summed up.
const ROWS_MAX: usize = 512;
/// Smallest sine of the polar angle in a density.
const SIN_MIN: f64 = 1e-6;
/// What [`Lanes::halves`] are to be multiplied by.
const HALVES: f64 = 5_192_296_858_534_827_628_530_496_329_220_096.0;
/// Largest scale of texels: the brightest is then infinite and clamped, the darkest still a number.
const SCALE_MAX: f64 = 1e37;
/// Luminance over the mean of the map from which light is hot. Any value is exact.
const HOT: f64 = 4.0;
/// Least share of a map's power that is worth photons.
const HOT_SHARE_MIN: f64 = 0.05;

/// Tables of one map; independent of rotation and scale.
#[derive(Debug)]
pub(super) struct LightTables {
    map: Arc<Environment>,
    rows: usize,
    columns: usize,
    /// Mean luminance of the map over the sphere.
    mean: f64,
    /// For light sampling; `None` if nothing is brighter than the mean.
    compensated: Option<Distribution>,
    /// For surfaces that scatter evenly, made when first asked for; `None` in the dark.
    irradiance: OnceLock<Option<Irradiance>>,
    /// For hot light, made when first asked for.
    hot: OnceLock<Option<Distribution>>,
    /// Texels in half precision: red in the lower and green in the upper bits of the first word, blue in the second. The first column is
    /// repeated behind the last: `height` rows of `width + 1`.
    texels: Vec<[f32; 2]>,
    /// Radiance of a texel that holds 1.
    unit: f64,
}

/// A light with its place in the scene.
#[derive(Clone, Debug)]
pub(super) struct Light {
    tables: Arc<LightTables>,
    sin: f32,
    cos: f32,
    scale: f32,
}

/// A direction towards the light.
pub(super) struct LightSample<L> {
    /// Unit, world.
    pub direction: V3<L>,
    /// Radiance that arrives from there.
    pub radiance: Rgb<L>,
    /// Density, 1/sr; 0 where nothing was drawn.
    pub pdf: L,
}

impl LightTables {
    /// Tables of a map, in double precision until they are stored.
    pub(super) fn new(map: &Arc<Environment>) -> Self {
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
    fn irradiance(&self) -> Option<&Irradiance> {
        let make = || Irradiance::new(&self.mass_above(0.0), self.rows, self.columns);
        self.irradiance.get_or_init(make).as_ref()
    }

    /// The table of hot light; `None` if a map has too little of it.
    fn hot(&self) -> Option<&Distribution> {
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

    /// Whether the tables are those of this map.
    pub(super) fn is_of(&self, map: &Arc<Environment>) -> bool {
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

/// [`Light::eval`].
struct Eval<'a, L> {
    light: &'a Light,
    direction: V3<L>,
}

impl<L: Lanes> Routine<L> for Eval<'_, L> {
    type Output = (Rgb<L>, L);
    #[inline(always)]
    fn run(self) -> (Rgb<L>, L) {
        self.light.eval_inline(self.direction)
    }
}

/// [`Light::eval_facing`].
struct EvalFacing<'a, L> {
    light: &'a Light,
    facing: &'a Facing<L>,
    direction: V3<L>,
}

impl<L: Lanes> Routine<L> for EvalFacing<'_, L> {
    type Output = (Rgb<L>, L);
    #[inline(always)]
    fn run(self) -> (Rgb<L>, L) {
        let (u, v, sin_theta) = self.light.place(self.direction);
        let density = if let Some(table) = self.light.tables.irradiance() { table.density(self.facing, u, v) } else { L::zero() };
        (self.light.radiance_at(u, v), density / (L::of(2.0 * PI * PI) * sin_theta.max(L::of(SIN_MIN))))
    }
}

/// [`Light::draw`].
struct Draw<'a, L> {
    light: &'a Light,
    table: Option<&'a Distribution>,
    u: [L; 2],
}

impl<L: Lanes> Routine<L> for Draw<'_, L> {
    type Output = LightSample<L>;
    #[inline(always)]
    fn run(self) -> LightSample<L> {
        // No closures around lanes: they are not always inlined into code for wider instructions.
        let [u0, u1] = self.u;
        let (u, v, density) = if let Some(table) = self.table { table.sample(u0, u1) } else { (u0, u1, L::zero()) };
        self.light.towards(u, v, density)
    }
}

/// [`Light::sample_facing`].
struct DrawFacing<'a, L> {
    light: &'a Light,
    facing: &'a Facing<L>,
    u: [L; 3],
}

impl<L: Lanes> Routine<L> for DrawFacing<'_, L> {
    type Output = LightSample<L>;
    #[inline(always)]
    fn run(self) -> LightSample<L> {
        let [u0, u1, _] = self.u;
        let (u, v, density) = if let Some(table) = self.light.tables.irradiance() {
            table.sample(self.facing, self.u)
        } else {
            (u0, u1, L::zero())
        };
        self.light.towards(u, v, density)
    }
}

impl Light {
    /// A light with tables for its map.
    pub(super) fn new(light: &EnvironmentLight, tables: Arc<LightTables>) -> Self {
        let (sin, cos) = if light.rotation_deg.is_finite() { light.rotation_deg.to_radians().sin_cos() } else { (0.0, 1.0) };
        let scale = if light.scale.is_finite() { light.scale.max(0.0) } else { 0.0 };
        Self { tables, sin, cos, scale }
    }

    /// The tables, for use by another light of the same map.
    pub(super) fn tables(&self) -> &Arc<LightTables> {
        &self.tables
    }

    /// Whether directions are drawn at all.
    pub(super) fn is_sampled(&self) -> bool {
        self.tables.compensated.is_some() && self.scale > 0.0
    }

    /// Radiance and density (1/sr) of a unit world direction. Density 0 if light sampling is left out.
    #[inline(always)]
    pub(super) fn eval<L: Lanes>(&self, direction: V3<L>) -> (Rgb<L>, L) {
        L::call(Eval { light: self, direction })
    }

    #[inline(always)]
    fn eval_inline<L: Lanes>(&self, direction: V3<L>) -> (Rgb<L>, L) {
        let (u, v, sin_theta) = self.place(direction);
        let pdf = if self.is_sampled() { self.density_at(u, v, sin_theta) } else { L::zero() };
        (self.radiance_at(u, v), pdf)
    }

    /// A direction in the axes of the map.
    #[inline(always)]
    fn in_map<L: Lanes>(&self, w: V3<L>) -> V3<L> {
        let (s, c) = (L::of(f64::from(self.sin)), L::of(f64::from(self.cos)));
        V3::new(c * w.x - s * w.z, w.y, s * w.x + c * w.z)
    }

    /// Where the map shows a unit world direction, `[0, 1]`, and the sine of the polar angle.
    #[inline(always)]
    fn place<L: Lanes>(&self, direction: V3<L>) -> (L, L, L) {
        let V3 { x, y, z } = self.in_map(direction);
        let turn = atan2(x, -z) * L::of(1.0 / TAU);
        let u = L::select(turn.lt(L::zero()), turn + L::one(), turn);
        let sin_theta = (x * x + z * z).sqrt();
        // The angle from both components keeps its digits near the poles, where the arc cosine does not.
        let v = atan2(sin_theta, y) * L::of(1.0 / PI);
        (u, v, sin_theta)
    }

    /// Makes the tables for surfaces that scatter evenly, and whether there is any use in them: not where all directions are as bright.
    pub(super) fn lights_evenly(&self) -> bool {
        self.is_sampled() && self.tables.irradiance().is_some()
    }

    /// What a surface with a unit normal is lit by; `None` in the dark.
    #[inline(always)]
    pub(super) fn facing<L: Lanes>(&self, n: V3<L>) -> Option<Facing<L>> {
        if !self.is_sampled() {
            return None;
        }
        let irradiance = self.tables.irradiance()?;
        Some(irradiance.facing(self.in_map(n)))
    }

    /// Draws a direction in proportion to radiance times cosine, from three numbers in `[0, 1)`. Nothing that lights a surface has density 0.
    #[inline(always)]
    pub(super) fn sample_facing<L: Lanes>(&self, facing: &Facing<L>, u: [L; 3]) -> LightSample<L> {
        L::call(DrawFacing { light: self, facing, u })
    }

    /// Radiance of a unit world direction, and the density (1/sr) of [`Light::sample_facing`] there.
    #[inline(always)]
    pub(super) fn eval_facing<L: Lanes>(&self, facing: &Facing<L>, direction: V3<L>) -> (Rgb<L>, L) {
        L::call(EvalFacing { light: self, facing, direction })
    }

    /// Draws a direction from two numbers in `[0, 1)`. Density 0 if light sampling is left out.
    #[inline(always)]
    pub(super) fn sample<L: Lanes>(&self, u0: L, u1: L) -> LightSample<L> {
        self.draw(self.tables.compensated.as_ref(), u0, u1)
    }

    /// Whether there is enough hot light for photons.
    pub(super) fn has_hot(&self) -> bool {
        self.scale > 0.0 && self.tables.hot().is_some()
    }

    /// Draws a direction of hot light; the radiance is that of the hot part.
    #[inline(always)]
    pub(super) fn sample_hot<L: Lanes>(&self, u0: L, u1: L) -> LightSample<L> {
        let sample = self.draw(self.tables.hot(), u0, u1);
        let cold = self.cold(sample.radiance);
        LightSample { radiance: sample.radiance.zip(cold, |all, cold| all - cold), ..sample }
    }

    /// The cold part of a radiance of this light.
    #[inline(always)]
    pub(super) fn cold<L: Lanes>(&self, radiance: Rgb<L>) -> Rgb<L> {
        let threshold = L::of(HOT * self.tables.mean * f64::from(self.scale));
        let [r, g, b] = radiance.0;
        let luminance = r * L::of(LUMINANCE[0]) + g * L::of(LUMINANCE[1]) + b * L::of(LUMINANCE[2]);
        let is_hot = luminance.gt(threshold);
        radiance.scale(L::select(is_hot, threshold / L::select(is_hot, luminance, L::one()), L::one()))
    }

    #[inline(always)]
    fn draw<L: Lanes>(&self, table: Option<&Distribution>, u0: L, u1: L) -> LightSample<L> {
        L::call(Draw { light: self, table, u: [u0, u1] })
    }

    /// The direction that the map shows at a place, with its radiance; `density` is over the map.
    #[inline(always)]
    fn towards<L: Lanes>(&self, u: L, v: L, density: L) -> LightSample<L> {
        let (sin_phi, cos_phi) = sin_cos_turn(u);
        let (sin_theta, cos_theta) = sin_cos_turn(v * L::of(0.5));
        let (x, y, z) = (sin_theta * sin_phi, cos_theta, -(sin_theta * cos_phi));
        let (s, c) = (L::of(f64::from(self.sin)), L::of(f64::from(self.cos)));
        LightSample {
            direction: V3::new(c * x + s * z, y, c * z - s * x),
            radiance: self.radiance_at(u, v),
            pdf: density / (L::of(2.0 * PI * PI) * sin_theta.max(L::of(SIN_MIN))),
        }
    }

    #[inline(always)]
    fn density_at<L: Lanes>(&self, u: L, v: L, sin_theta: L) -> L {
        let density = if let Some(table) = &self.tables.compensated { table.density(u, v) } else { L::zero() };
        density / (L::of(2.0 * PI * PI) * sin_theta.max(L::of(SIN_MIN)))
    }

    /// Bilinear between texel centres; wraps around in u, clamps at the poles.
    #[inline(always)]
    fn radiance_at<L: Lanes>(&self, u: L, v: L) -> Rgb<L> {
        let (width, height) = (self.tables.map.width.max(1), self.tables.map.height.max(1));
        let x = u * L::of(width as f64) - L::of(0.5);
        let x = L::select(x.lt(L::zero()), x + L::of(width as f64), x);
        let y = (v * L::of(height as f64) - L::of(0.5)).max(L::zero()).min(L::of((height - 1) as f64));
        let x0 = x.floor().min(L::of((width - 1) as f64));
        let y0 = y.floor();
        let (fx, fy) = (x - x0, y - y0);
        // Places of the four texels; they lie in the table for lanes that hold a direction.
        let mut taps = [[0usize; MAX_LANES]; 4];
        let (columns, rows) = (x0.to_array(), y0.to_array());
        for lane in 0..L::WIDTH {
            let (i, j) = (columns[lane] as usize, rows[lane] as usize);
            let upper = j * (width + 1) + i;
            let lower = (j + 1).min(height - 1) * (width + 1) + i;
            for (tap, at) in taps.iter_mut().zip([upper, upper + 1, lower, lower + 1]) {
                tap[lane] = 2 * at;
            }
        }
        let texels = self.tables.texels.as_flattened();
        let mut corners = [[L::zero(); 3]; 4];
        for (corner, tap) in corners.iter_mut().zip(&taps) {
            let (r, g) = L::gather_at(texels, tap).halves();
            let (b, _) = L::gather_at(&texels[1..], tap).halves();
            *corner = [r, g, b];
        }
        let (halves, scale) = (L::of(HALVES), L::of((f64::from(self.scale) * self.tables.unit).min(SCALE_MAX)));
        let mut channels = [L::zero(); 3];
        for (k, channel) in channels.iter_mut().enumerate() {
            let [a, b, c, d] = [corners[0][k] * halves, corners[1][k] * halves, corners[2][k] * halves, corners[3][k] * halves];
            *channel = (a.lerp(b, fx).lerp(c.lerp(d, fx), fy) * scale).min(L::of(EMISSION_MAX));
        }
        Rgb(channels)
    }
}

/// Sine and cosine of a number of turns in `[0, 1]`. Taylor series on an eighth of a turn; error below 2e-7.
#[inline(always)]
pub(super) fn sin_cos_turn<L: Lanes>(turn: L) -> (L, L) {
    let quadrant = (turn * L::of(4.0) + L::of(0.5)).floor();
    let x = (turn - quadrant * L::of(0.25)) * L::of(TAU);
    let x2 = x * x;
    let s = x
        * (L::one()
            + x2 * (L::of(-1.0 / 6.0) + x2 * (L::of(1.0 / 120.0) + x2 * (L::of(-1.0 / 5040.0) + x2 * L::of(1.0 / 362_880.0)))));
    let c = L::one() + x2 * (L::of(-0.5) + x2 * (L::of(1.0 / 24.0) + x2 * (L::of(-1.0 / 720.0) + x2 * L::of(1.0 / 40_320.0))));
    let is = |q: f64| quadrant.eq(L::of(q));
    let is_swapped = is(1.0) | is(3.0);
    let (a, b) = (L::select(is_swapped, c, s), L::select(is_swapped, s, c));
    (L::select(is(2.0) | is(3.0), -a, a), L::select(is(1.0) | is(2.0), -b, b))
}

/// Angle of the point (x, y) from the x axis, radians, `[-pi, pi]`. Odd polynomial of Abramowitz and Stegun's kind on `[0, 1]` after
/// a reduction by 45 degrees; error below 3e-7.
#[inline(always)]
fn atan2<L: Lanes>(y: L, x: L) -> L {
    let (ax, ay) = (x.abs(), y.abs());
    let (large, small) = (ax.max(ay), ax.min(ay));
    let is_zero = large.le(L::zero());
    let r = small / L::select(is_zero, L::one(), large);
    // atan(r) = pi/8 + atan((r - k) / (1 + k r)) with k = tan(pi/8), for r above k/2: the argument then stays below 0.415.
    let k = L::of(0.414_213_562_373_095_03);
    let is_upper = r.gt(L::of(0.207));
    let z = L::select(is_upper, (r - k) / (L::one() + k * r), r);
    let z2 = z * z;
    let series = L::one()
        + z2 * (L::of(-1.0 / 3.0)
            + z2 * (L::of(0.2)
                + z2 * (L::of(-1.0 / 7.0) + z2 * (L::of(1.0 / 9.0) + z2 * (L::of(-1.0 / 11.0) + z2 * L::of(1.0 / 13.0))))));
    let a = z * series + L::select(is_upper, L::of(PI / 8.0), L::zero());
    let a = L::select(ay.gt(ax), L::of(PI / 2.0) - a, a);
    let a = L::select(x.lt(L::zero()), L::of(PI) - a, a);
    L::select(y.lt(L::zero()), -a, a)
}

#[cfg(test)]
mod tests;
