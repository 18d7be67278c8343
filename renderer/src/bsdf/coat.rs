//! The coat's tint of what lies below. Its reflection is an ordinary GGX lobe. Twin of `coat.wgsl`.

use crate::lanes::Lanes;
use crate::vector::Rgb;

/// Exponent of the coat tint for one passage at cosine `mu`: longer at grazing angles. Model reference 8.3.
#[inline(always)]
pub fn coat_exponent<L: Lanes>(mu: L) -> L {
    L::of(0.25) + L::of(0.1575) / L::of(0.24).lerp(L::one(), mu * mu)
}

/// Factor on light that passes the coat once at cosine `mu`; `ln_tint` is the logarithm of the tint, at least `ln 1e-6`.
#[inline(always)]
pub fn coat_passage<L: Lanes>(ln_tint: Rgb<L>, mu: L) -> Rgb<L> {
    let p = coat_exponent(mu);
    ln_tint.map(|t| (t * p).exp())
}
