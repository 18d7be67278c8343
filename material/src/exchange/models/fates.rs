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

/// Emission and its colour as a product.
pub fn emission(i: &Inputs<f64>) -> (Fate, &'static str) {
    match i.emission {
        0.0 if i.emission_color != [1.0; 3] => (Fate::Approximated, "without emission the colour is lost"),
        _ => (Fate::Remapped, "as a product"),
    }
}

/// Sheen and its colour as a product, of another lobe.
pub fn sheen_product(i: &Inputs<f64>) -> (Fate, &'static str) {
    match i.sheen {
        0.0 if i.sheen_color != [1.0; 3] => (Fate::Approximated, "without sheen the colour is lost"),
        0.0 => (Fate::Remapped, ""),
        _ => (Fate::Approximated, "as a product, of another lobe"),
    }
}

/// Roughness of the sheen, as the same number of another lobe.
pub fn sheen_roughness(i: &Inputs<f64>) -> (Fate, &'static str) {
    if i.sheen == 0.0 { (Fate::Exact, "") } else { (Fate::Approximated, "another lobe with the same number") }
}

/// The two widths of the highlight as another split of them, which knows no limit but that of ASM's lobe.
pub fn widths(i: &Inputs<f64>) -> (Fate, &'static str) {
    match i.anisotropy {
        0.0 => (Fate::Exact, ""),
        a if i.roughness * i.roughness + a.powi(4) <= 1.0 => (Fate::Remapped, "another split of the same two widths"),
        _ => (Fate::Approximated, "the lobe is as wide as it can be; how much further was asked for is lost"),
    }
}

/// The index of a coat that always has 1.5.
pub fn fixed_coat_ior(i: &Inputs<f64>) -> (Fate, &'static str) {
    match i.coat {
        0.0 => (Fate::Dropped, "the format has nothing that means it"),
        _ => (Fate::Approximated, "the coat there has one of 1.5"),
    }
}

/// A base colour that tints what goes through the body as well.
pub fn tinting_base(i: &Inputs<f64>) -> (Fate, &'static str) {
    match i.translucency == 0.0 || i.metallic == 1.0 {
        true => (Fate::Exact, ""),
        false => (Fate::Approximated, "mixed with the colour of transmitted light, which is tinted with it there"),
    }
}

/// Height as the displacement itself, signed.
pub fn displacement(i: &Inputs<f64>) -> (Fate, &'static str) {
    match i.height_level == 0.5 && i.height_scale == 1.0 {
        true => (Fate::Remapped, ""),
        false => (Fate::Approximated, "only the displacement itself is kept"),
    }
}
