//! The GGX microfacet distribution with Smith shadowing, anisotropic. Twin of `ggx.wgsl`.
//!
//! All directions are unit, in the frame of the stretch: x along it, z the normal. Nothing here forms `1 - cos^2`.

use crate::lanes::Lanes;
use crate::vector::V3;
use std::f64::consts::PI;

/// Density of microfacet normals `m` per solid angle and projected area, `D(m)`. `alpha_x`, `alpha_y` in `[1e-4, 1]`.
#[inline(always)]
pub fn d_ggx<L: Lanes>(m: V3<L>, alpha_x: L, alpha_y: L) -> L {
    let x = m.x / alpha_x;
    let y = m.y / alpha_y;
    let s = x * x + y * y + m.z * m.z;
    L::one() / (L::of(PI) * alpha_x * alpha_y * s * s)
}

/// `sqrt((ax vx)^2 + (ay vy)^2 + vz^2)`: the length that all Smith terms share.
#[inline(always)]
pub fn smith_length<L: Lanes>(v: V3<L>, alpha_x: L, alpha_y: L) -> L {
    ((alpha_x * v.x).sqr() + (alpha_y * v.y).sqr() + v.z.sqr()).sqrt()
}

/// Smith masking of one direction, `G1`, in `[0, 1]`; `length` from [`smith_length`].
#[inline(always)]
pub fn g1_smith<L: Lanes>(v: V3<L>, length: L) -> L {
    L::of(2.0) * v.z.abs() / (v.z.abs() + length).max(L::of(1e-20))
}

/// Height-correlated Smith `G2 / (4 mu_o mu_i)` times `mu_i`: what a reflection multiplies with `F D`.
#[inline(always)]
pub fn reflection_visibility<L: Lanes>(mu_o: L, mu_i: L, length_o: L, length_i: L) -> L {
    mu_i / (L::of(2.0) * (mu_i * length_o + mu_o * length_i)).max(L::of(1e-20))
}

/// The bound of the spherical cap for `wo`: 1 samples all visible normals, the bounded form leaves out those that
/// reflect below the horizon. Source: Eto and Tokuyoshi 2023, equation 5.
#[inline(always)]
pub fn vndf_bound<L: Lanes>(wo: V3<L>, alpha_x: L, alpha_y: L) -> L {
    let a = L::one().min(alpha_x).min(alpha_y);
    let s = L::one() + (wo.x.sqr() + wo.y.sqr()).sqrt();
    let a2 = a * a;
    let s2 = s * s;
    (L::one() - a2) * s2 / (s2 + a2 * wo.z.sqr())
}

/// Samples a visible microfacet normal for `wo` (`wo.z >= 0`) at `u0`, `u1` in `[0, 1)`; `k` is 1 or [`vndf_bound`].
///
/// Returns a unit normal with `z >= 0`, finite at grazing `wo`. Source: Dupuy and Benyoub 2023.
#[inline(always)]
pub fn vndf_sample<L: Lanes>(wo: V3<L>, alpha_x: L, alpha_y: L, k: L, u0: L, u1: L) -> V3<L> {
    let (sin, cos) = (L::of(2.0 * PI) * u1).sin_cos();
    vndf_sample_at(wo, alpha_x, alpha_y, k, u0, sin, cos)
}

/// [`vndf_sample`] with the azimuth given by its sine and cosine.
#[inline(always)]
pub fn vndf_sample_at<L: Lanes>(wo: V3<L>, alpha_x: L, alpha_y: L, k: L, u0: L, sin: L, cos: L) -> V3<L> {
    let os = V3::new(alpha_x * wo.x, alpha_y * wo.y, wo.z).normalize();
    let b = k * os.z.min(L::one());
    let one_plus_z = (L::one() - u0) * (L::one() + b) + (L::one() - b);
    let one_minus_z = u0 * (L::one() + b);
    let z = (L::one() - u0) * (L::one() + b) - b;
    let st = (one_plus_z * one_minus_z).max(L::zero()).sqrt();
    let h = V3::new(st * cos + os.x, st * sin + os.y, z + os.z);
    V3::new(alpha_x * h.x, alpha_y * h.y, h.z.max(L::zero())).normalize()
}

/// Density per solid angle of a reflected direction whose half vector `m` was drawn by [`vndf_sample`] with bound `k`.
#[inline(always)]
pub fn reflection_pdf<L: Lanes>(wo: V3<L>, d: L, k: L, length_o: L) -> L {
    d / (L::of(2.0) * (k * wo.z + length_o)).max(L::of(1e-20))
}

/// Density per solid angle of a visible normal `m` with `cos_om = o.m > 0`, unbounded (`k = 1`).
#[inline(always)]
pub fn vndf_pdf<L: Lanes>(wo: V3<L>, cos_om: L, d: L, length_o: L) -> L {
    L::of(2.0) * cos_om.max(L::zero()) * d / (wo.z + length_o).max(L::of(1e-20))
}

/// Mirror image of `wo` about `m`.
#[inline(always)]
pub fn reflect<L: Lanes>(wo: V3<L>, m: V3<L>) -> V3<L> {
    m.scale(L::of(2.0) * wo.dot(m)) - wo
}

/// Refracts `wo` at a facet `m` with `cos_om = o.m > 0`; `eta = n_transmitted / n_incident`.
///
/// Returns the direction away from the surface on the other side, and whether it exists (no total reflection).
#[inline(always)]
pub fn refract<L: Lanes>(wo: V3<L>, m: V3<L>, cos_om: L, eta: L) -> (V3<L>, L::Mask) {
    let inverse = L::one() / eta;
    // 1 - sin^2 written as a difference of squares: exact at normal incidence, no loss for eta near 1.
    let cos2 = ((eta - L::one()) * (eta + L::one()) + cos_om * cos_om) * inverse * inverse;
    let exists = cos2.gt(L::zero());
    let cos_t = L::select(exists, cos2, L::zero()).sqrt();
    let wi = m.scale(cos_om * inverse - cos_t) - wo.scale(inverse);
    (wi.normalize(), exists)
}

/// Direction rotated about z by an angle given by its cosine and sine.
#[inline(always)]
pub fn rotate_z<L: Lanes>(v: V3<L>, cos: L, sin: L) -> V3<L> {
    V3::new(cos * v.x - sin * v.y, sin * v.x + cos * v.y, v.z)
}

/// Roughness along and across the stretch. Below the smallest alpha in both directions the surface is a mirror.
///
/// Returns `alpha_x`, `alpha_y` (clamped to `[1e-4, 1]`) and whether it is smooth. Model reference 3.1, 3.2.
#[inline(always)]
pub fn alphas<L: Lanes>(roughness: L, anisotropy: L) -> (L, L, L::Mask) {
    let min = L::of(L::ALPHA_MIN);
    let along_y = roughness.sqr();
    let along_x = (along_y + anisotropy.sqr().sqr()).min(L::one());
    let is_smooth = along_x.lt(min) & along_y.lt(min);
    (along_x.max(min), along_y.max(min), is_smooth)
}

/// A cosine-weighted direction about +z at `u0`, `u1` in `[0, 1)`.
#[inline(always)]
pub fn cosine_sample<L: Lanes>(u0: L, u1: L) -> V3<L> {
    let r = u0.sqrt();
    let (sin, cos) = (L::of(2.0 * PI) * u1).sin_cos();
    V3::new(r * cos, r * sin, (L::one() - u0).max(L::zero()).sqrt())
}
