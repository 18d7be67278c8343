//! What becomes of properties that several models hold in the same way.

use super::super::formulas as f;
use super::super::loss::Fate;
use crate::properties::Inputs;

/// Height as a displacement above and below the level.
pub fn height(i: &Inputs<f64>) -> (Fate, &'static str) {
    if i.height_level == 0.5 { (Fate::Remapped, "") } else { (Fate::Approximated, "only the height above the level is kept") }
}

/// Strength of a normal map (5.9).
pub fn slope(scale: f64) -> (Fate, &'static str) {
    if scale >= 1.0 { (Fate::Exact, "") } else { (Fate::Approximated, "below 1 ASM scales the angle, MaterialX the slope") }
}

/// The switch of scattering, as a weight of subsurface scattering above 0.
pub fn scatter(i: &Inputs<f64>) -> (Fate, &'static str) {
    match i.translucency {
        0.0 if i.scatter => (Fate::Dropped, "scattering without translucency has no weight to stand in"),
        _ => (Fate::Remapped, ""),
    }
}

/// Scattering distances as mean free paths (5.6).
pub fn mean_free_path(i: &Inputs<f64>) -> (Fate, &'static str) {
    match i.scatter_red_shift == 0.0 && i.scatter_rayleigh == 0.0 {
        true => (Fate::Remapped, "as mean free paths"),
        false => (Fate::Approximated, "with red shift and Rayleigh scattering folded in"),
    }
}

/// Red shift and Rayleigh scattering, folded into mean free paths (5.6).
pub fn folded_path(i: &Inputs<f64>) -> (Fate, &'static str) {
    match i.scatter_red_shift == 0.0 && i.scatter_rayleigh == 0.0 {
        true => (Fate::Exact, ""),
        false => (Fate::Approximated, "the same look, folded into the radii"),
    }
}

/// The coat's level, folded into its index of refraction (5.2).
pub fn coat_level(i: &Inputs<f64>) -> (Fate, &'static str) {
    match i.coat_specular_level {
        0.5 => (Fate::Exact, ""),
        _ => (Fate::Approximated, "the level became part of the index of refraction"),
    }
}

/// The two widths of the highlight as a roughness and an aspect of at most 0.98 (5.1).
pub fn aspect(i: &Inputs<f64>) -> (Fate, &'static str) {
    let (along, across) = f::alphas(i.roughness, i.anisotropy);
    match i.anisotropy {
        0.0 => (Fate::Exact, ""),
        _ if 1.0 - across / along > f::MAX_ASPECT => (Fate::Approximated, "the highlight cannot be stretched that far"),
        a if i.roughness * i.roughness + a.powi(4) <= 1.0 => (Fate::Remapped, "another split of the same two widths"),
        _ => (Fate::Approximated, "the lobe is as wide as it can be; how much further was asked for is lost"),
    }
}
