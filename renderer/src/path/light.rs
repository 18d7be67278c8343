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
use super::irradiance::Facing;
use crate::bsdf::interpret::EMISSION_MAX;
use crate::lanes::{Lanes, MAX_LANES, Routine};
use crate::scene::EnvironmentLight;
use crate::vector::{Rgb, V3};
use angle::atan2;
use std::f64::consts::{PI, TAU};
use std::sync::Arc;
use tables::{HALVES, HOT, LUMINANCE};

mod angle;
mod tables;
#[cfg(test)]
mod tests;

pub(super) use angle::sin_cos_turn;
pub(super) use tables::LightTables;

/// Smallest sine of the polar angle in a density.
const SIN_MIN: f64 = 1e-6;
/// Largest scale of texels: the brightest is then infinite and clamped, the darkest still a number.
const SCALE_MAX: f64 = 1e37;

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
        (self.light.radiance_at(u, v), over_sphere(density, sin_theta))
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
        let density = match &self.tables.compensated {
            Some(table) if self.is_sampled() => table.density(u, v),
            _ => L::zero(),
        };
        (self.radiance_at(u, v), over_sphere(density, sin_theta))
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
            pdf: over_sphere(density, sin_theta),
        }
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

/// A density over the map as one over the sphere, 1/sr.
#[inline(always)]
fn over_sphere<L: Lanes>(density: L, sin_theta: L) -> L {
    density / (L::of(2.0 * PI * PI) * sin_theta.max(L::of(SIN_MIN)))
}
