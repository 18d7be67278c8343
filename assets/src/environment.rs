//! Light from far away in every direction, as a picture of the whole sphere. What the built-in ones show is in
//! `environments`; how a renderer samples one is its own affair.

use std::f32::consts::{PI, TAU};

use glam::{Vec2, Vec3};

/// A latitude-longitude map of linear Rec.709 radiance, +Y up.
///
/// For a unit direction `d`: `u = fract(atan2(d.x, -d.z) / 2π)`, `v = acos(d.y) / π`. Row 0 is the zenith, the middle
/// of the map is +Z, and u grows to the right as seen from inside. Texel `(i, j)` is centred at
/// `((i + 0.5) / width, (j + 0.5) / height)`.
#[derive(Clone, Debug, PartialEq)]
pub struct Environment {
    /// What to show the user: a label, or the file name without its ending.
    pub name: String,
    /// Number of columns, usually twice `height`.
    pub width: usize,
    /// Number of rows.
    pub height: usize,
    /// Radiance, finite and not negative, row by row from the zenith: `width * height` texels.
    pub texels: Vec<[f32; 3]>,
}

impl Environment {
    /// The radiance arriving from `d`, which points away from the viewer and need not have unit length.
    ///
    /// Bilinear between texel centres; wraps around in u, clamps at the poles. Zero for an environment without texels
    /// and for a direction of no length.
    pub fn lookup(&self, d: Vec3) -> Vec3 {
        let Some(d) = d.try_normalize() else { return Vec3::ZERO };
        if self.width == 0 || self.height == 0 || self.texels.len() < self.width * self.height {
            return Vec3::ZERO;
        }
        let uv = Self::uv(d);
        let x = uv.x * self.width as f32 - 0.5;
        let y = (uv.y * self.height as f32 - 0.5).clamp(0.0, (self.height - 1) as f32);
        let (x0, y0) = (x.floor(), y.floor());
        let (fx, fy) = (x - x0, y - y0);
        // The left neighbour of the first column is the last one.
        let i0 = (x0 as isize).rem_euclid(self.width as isize) as usize;
        let i1 = (i0 + 1) % self.width;
        let j0 = y0 as usize;
        let j1 = (j0 + 1).min(self.height - 1);
        let at = |i: usize, j: usize| Vec3::from_array(self.texels[j * self.width + i]);
        at(i0, j0).lerp(at(i1, j0), fx).lerp(at(i0, j1).lerp(at(i1, j1), fx), fy)
    }

    /// The unit direction that `u` and `v`, both 0 to 1, stand for; the inverse of [`Environment::uv`].
    pub fn direction(u: f32, v: f32) -> Vec3 {
        let (sin_phi, cos_phi) = (u * TAU).sin_cos();
        let (sin_theta, cos_theta) = (v * PI).sin_cos();
        Vec3::new(sin_theta * sin_phi, cos_theta, -sin_theta * cos_phi)
    }

    /// Where the unit direction `d` lies on the map: u in `[0, 1)`, v in `[0, 1]`. At the poles u is arbitrary.
    pub fn uv(d: Vec3) -> Vec2 {
        let turn = d.x.atan2(-d.z) / TAU;
        // A tiny negative angle rounds to exactly 1, which belongs to 0.
        let u = turn - turn.floor();
        let u = if u >= 1.0 { 0.0 } else { u };
        Vec2::new(u, d.y.clamp(-1.0, 1.0).acos() / PI)
    }

    /// An environment with `radiance(direction)` at every texel centre; `width` and `height` at least 1.
    pub(crate) fn from_fn(name: &str, width: usize, height: usize, radiance: impl Fn(Vec3) -> Vec3) -> Self {
        let columns: Vec<(f32, f32)> = (0..width).map(|i| ((i as f32 + 0.5) / width as f32 * TAU).sin_cos()).collect();
        let mut texels = Vec::with_capacity(width * height);
        for j in 0..height {
            let (sin_theta, cos_theta) = ((j as f32 + 0.5) / height as f32 * PI).sin_cos();
            texels.extend(
                columns.iter().map(|&(sin_phi, cos_phi)| {
                    radiance(Vec3::new(sin_theta * sin_phi, cos_theta, -sin_theta * cos_phi)).to_array()
                }),
            );
        }
        Self { name: name.to_owned(), width, height, texels }
    }
}
