//! Reflectance of smooth interfaces: dielectric Fresnel, specular level, F82-tint metals. Twin of `fresnel.wgsl`.

use crate::lanes::Lanes;
use crate::vector::Rgb;

/// Largest reflectance at normal incidence that a dielectric may reach; keeps the index of refraction finite.
pub const F0_MAX: f64 = 0.9999;

/// Reflectance at normal incidence of an index of refraction `n > 0`.
#[inline(always)]
pub fn f0_from_ior<L: Lanes>(n: L) -> L {
    ((n - L::one()) / (n + L::one())).sqr()
}

/// Index of refraction, at least 1, with this reflectance at normal incidence. `f0` in `[0, 1]`, capped at [`F0_MAX`].
#[inline(always)]
pub fn ior_from_f0<L: Lanes>(f0: L) -> L {
    let s = f0.max(L::zero()).min(L::of(F0_MAX)).sqrt();
    (L::one() + s) / (L::one() - s)
}

/// Index of refraction after the specular level: linear in reflectance, 0.5 leaves it. For `n < 1` the reciprocal rule applies.
/// Source: specification "Specular level"; model reference 5.1.
#[inline(always)]
pub fn level_to_ior<L: Lanes>(n: L, level: L) -> L {
    let scaled = ior_from_f0(L::of(2.0) * level * f0_from_ior(n));
    L::select(n.lt(L::one()), L::one() / scaled, scaled)
}

/// Unpolarised Fresnel reflectance for `c = |cos|` in `[0, 1]` and `eta = n_transmitted / n_incident > 0`.
///
/// Exactly 0 for `eta = 1`, exactly 1 under total internal reflection. Keeps full relative precision for `eta` near 1,
/// because no difference of nearly equal terms is formed. Model reference 5.2.
#[inline(always)]
pub fn fresnel<L: Lanes>(c: L, eta: L) -> L {
    let d = (eta - L::one()) * (eta + L::one());
    let g2 = d + c * c;
    let is_matched = eta.eq(L::one());
    let is_total = g2.le(L::zero());
    let g = L::select(is_total | is_matched, L::one(), g2).sqrt();
    let f = L::select(is_total, L::one(), fresnel_bent(c, g, eta));
    L::select(is_matched, L::zero(), f)
}

/// [`fresnel`] of light that is known to refract, `g` being `eta` times the cosine of refraction, above 0: near total reflection the
/// difference under its root would leave few digits of what passes. `eta` is not 1.
#[inline(always)]
pub fn fresnel_bent<L: Lanes>(c: L, g: L, eta: L) -> L {
    let d = (eta - L::one()) * (eta + L::one());
    let q = L::one() / (c + g);
    let rs = -(d * q * q);
    let b = (c * (g + c) - L::one()) / (c * d * q + L::one());
    (L::of(0.5) * rs * rs * (L::one() + b * b)).sat()
}

/// Coefficient of the F82-tint curve for reflectance `r` at normal incidence and edge tint `t`, both in `[0, 1]`. Model reference 4.
#[inline(always)]
pub fn f82_coefficient<L: Lanes>(r: L, t: L) -> L {
    (L::one() - t) * (L::of(49.0 / 6.0) + L::of(9.484_717_935_528) * r)
}

/// F82-tint reflectance of a metal for `mu = |o.m|` in `[0, 1]`. Clamped to `[0, 1]`: dark tints would go negative.
/// Source: Kutz, Hasan, Edmondson 2021; model reference 4.
#[inline(always)]
pub fn f82_tint<L: Lanes>(mu: L, r: Rgb<L>, b: Rgb<L>) -> Rgb<L> {
    let u = L::one() - mu;
    let u2 = u * u;
    let u5 = u2 * u2 * u;
    let Rgb([r0, r1, r2]) = r;
    let Rgb([b0, b1, b2]) = b;
    Rgb([f82_channel(r0, b0, mu, u, u5), f82_channel(r1, b1, mu, u, u5), f82_channel(r2, b2, mu, u, u5)])
}

/// One channel of [`f82_tint`], with `u = 1 - mu` and its fifth power.
#[inline(always)]
fn f82_channel<L: Lanes>(r: L, b: L, mu: L, u: L, u5: L) -> L {
    (r + (L::one() - r - b * mu * u) * u5).sat()
}

/// Cosine-weighted mean of [`f82_tint`], clamped to `[0, 1]`. Exact where the curve needs no clamp.
#[inline(always)]
pub fn f82_average<L: Lanes>(r: Rgb<L>, b: Rgb<L>) -> Rgb<L> {
    let Rgb([r0, r1, r2]) = r;
    let Rgb([b0, b1, b2]) = b;
    Rgb([f82_channel_average(r0, b0), f82_channel_average(r1, b1), f82_channel_average(r2, b2)])
}

/// One channel of [`f82_average`].
#[inline(always)]
fn f82_channel_average<L: Lanes>(r: L, b: L) -> L {
    (r + (L::one() - r) * L::of(1.0 / 21.0) - b * L::of(1.0 / 126.0)).sat()
}
