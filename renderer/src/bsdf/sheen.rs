//! Sheen: a thin slab of fibre-like microflakes along the normal, single scattering in closed form. Twin of `sheen.wgsl`.
//! Model reference 7; scale 1/2 stands in for multiple scattering and keeps the albedo below 1.

use crate::lanes::Lanes;
use crate::vector::V3;
use std::f64::consts::PI;

/// Smallest sheen roughness that is evaluated.
pub const SHEEN_ROUGHNESS_MIN: f64 = 1e-3;

/// Projected area of the flakes towards unit `v`; `r` in `[1e-3, 1]`. In `[r, 1]`.
#[inline(always)]
pub fn sheen_sigma<L: Lanes>(v: V3<L>, r: L) -> L {
    (v.x.sqr() + v.y.sqr() + (r * v.z).sqr()).sqrt()
}

/// Density of flake normals `m`.
#[inline(always)]
pub fn sheen_d<L: Lanes>(m: V3<L>, r: L) -> L {
    let s = m.x.sqr() + m.y.sqr() + (m.z / r).sqr();
    L::one() / (L::of(PI) * r * s * s)
}

/// Untinted sheen times `mu_i`, and its sampling density per solid angle. `wo.z > 0` and `wi.z > 0`.
#[inline(always)]
pub fn sheen_eval<L: Lanes>(wo: V3<L>, wi: V3<L>, r: L) -> (L, L) {
    let d = sheen_d((wo + wi).normalize(), r);
    let sigma_o = sheen_sigma(wo, r);
    let sigma_i = sheen_sigma(wi, r);
    let cross = (sigma_i * wo.z + sigma_o * wi.z).max(L::of(1e-12));
    let depth = cross / (wo.z * wi.z).max(L::of(1e-12));
    let absorbed = -(-depth.min(L::of(80.0))).exp_m1();
    let value = L::of(0.5) * d * absorbed * wi.z / cross;
    (value, d / (L::of(4.0) * sigma_o))
}

/// Samples a direction by visible flake normals. The result may lie below the horizon: the caller rejects it.
/// Source: Heitz, Dupuy, Crassin, Dachsbacher 2015 (SGGX), reduced to this slab.
#[inline(always)]
pub fn sheen_sample<L: Lanes>(wo: V3<L>, r: L, u0: L, u1: L) -> V3<L> {
    let axis = V3::new(wo.x, wo.y, r * wo.z).normalize();
    let h = super::ggx::cosine_sample(u0, u1);
    // Any frame about the axis will do, and this one has no branch and no pole (Duff et al. 2017).
    let sign = L::select(axis.z.lt(L::zero()), -L::one(), L::one());
    let a = -(L::one() / (sign + axis.z));
    let b = axis.x * axis.y * a;
    let t = V3::new(L::one() + sign * axis.x * axis.x * a, sign * b, -(sign * axis.x));
    let s = V3::new(b, sign + axis.y * axis.y * a, -axis.y);
    let h = t.scale(h.x) + s.scale(h.y) + axis.scale(h.z);
    let m = V3::new(h.x, h.y, r * h.z).normalize();
    super::ggx::reflect(wo, m)
}
