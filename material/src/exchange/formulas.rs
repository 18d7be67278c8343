//! Formulas that several formats share. Numbers in brackets are sections of the mapping that the page `INTERCHANGE.md` explains.
//!
//! All in double precision. Inverses are exact where the forward direction does not clamp.

use crate::properties::Inputs;

/// Share of light that a surface with this index of refraction reflects at normal incidence.
pub fn f0_of_ior(ior: f64) -> f64 {
    let e = (ior - 1.0) / (ior + 1.0);
    e * e
}

/// The index of refraction that reflects `f0` at normal incidence, at least 1.
pub fn ior_of_f0(f0: f64) -> f64 {
    let e = f0.clamp(0.0, 0.999_999).sqrt();
    (1.0 + e) / (1.0 - e)
}

/// Share of a dielectric's reflection at normal incidence that is left under a coat, where ASM's base has the coat as its surroundings
/// (model reference 8.2).
pub fn share_under_coat(ior: f64, coat_ior: f64, coat: f64) -> f64 {
    let bare = f0_of_ior(ior);
    if coat <= 0.0 || bare <= 0.0 { 1.0 } else { 1.0 + coat * (f0_of_ior(ior / coat_ior.max(1e-3)) / bare - 1.0) }
}

/// Luminance, in nits, of an emission of 1 (5.4). Adobe's convention.
pub const NITS: f64 = 1000.0;

/// Index of refraction, specular level and edge colour of a dielectric that reflects `f0` at normal incidence, 0 to 1 by channel. What a
/// common dielectric of index 1.5 reaches, 0.08, becomes its level; what reflects more, up to 0.98, an index.
pub fn dielectric_of_f0(f0: [f64; 3]) -> (f64, f64, [f64; 3]) {
    const MOST_OF_LEVELS: f64 = 0.08;
    let (most, edge) = split_amount(f0);
    match most.min(0.98) {
        most if most <= MOST_OF_LEVELS => (1.5, most.max(0.0) / MOST_OF_LEVELS, edge),
        most => (ior_of_f0(most), 0.5, edge),
    }
}

/// A specular level made part of the index of refraction (5.2): what a model without levels needs to reflect as much.
pub fn fold_level(ior: f64, level: f64) -> f64 {
    if level == 0.5 {
        return ior;
    }
    ior_of_f0(2.0 * level * f0_of_ior(ior))
}

/// Roughness squared along the tangent and across it, of ASM's lobe (5.1).
pub fn alphas(roughness: f64, anisotropy: f64) -> (f64, f64) {
    let alpha = roughness * roughness;
    ((alpha + anisotropy.powi(4)).min(1.0), alpha)
}

/// Roughness and anisotropy of ASM's lobe from its roughness squared along and across (5.1).
pub fn roughness_anisotropy(along: f64, across: f64) -> (f64, f64) {
    (across.max(0.0).sqrt(), (along - across).max(0.0).powf(0.25).min(1.0))
}

/// Largest anisotropy of models that split the two widths by an aspect (5.1).
pub const MAX_ASPECT: f64 = 0.98;

/// Roughness and anisotropy of models with `aspect = sqrt(1 - anisotropy)` that have the widths of ASM's lobe (5.1).
pub fn aspect_roughness(roughness: f64, anisotropy: f64) -> (f64, f64) {
    let (along, across) = alphas(roughness, anisotropy);
    if anisotropy == 0.0 {
        return (roughness, 0.0);
    }
    let aspect = if along > 0.0 { (1.0 - across / along).min(MAX_ASPECT) } else { 0.0 };
    // The roughness follows the widths: where the aspect is cut off, the longer one stays.
    ((along * (1.0 - aspect).sqrt()).sqrt(), aspect)
}

/// ASM's roughness and anisotropy from those of models with an aspect (5.1). Clamped to [0, 1].
pub fn roughness_of_aspect(roughness: f64, anisotropy: f64) -> (f64, f64) {
    let (roughness, anisotropy) = (roughness.clamp(0.0, 1.0), anisotropy.clamp(0.0, MAX_ASPECT));
    if anisotropy == 0.0 {
        return (roughness, 0.0);
    }
    let aspect = (1.0 - anisotropy).sqrt();
    let (roughness, anisotropy) = roughness_anisotropy(roughness * roughness / aspect, roughness * roughness * aspect);
    (roughness.min(1.0), anisotropy)
}

/// Roughness and anisotropy of models that widen the lobe along the tangent as much as they narrow it across, `(1 + a) R²` and `(1 - a) R²`
/// (Kulla and Conty 2017), with the widths of ASM's lobe.
pub fn balanced_roughness(roughness: f64, anisotropy: f64) -> (f64, f64) {
    let (along, across) = alphas(roughness, anisotropy);
    if anisotropy == 0.0 || along <= 0.0 {
        return (roughness, 0.0);
    }
    ((0.5 * (along + across)).sqrt(), (along - across) / (along + across))
}

/// ASM's roughness and anisotropy from those. Both 0 to 1.
pub fn roughness_of_balanced(roughness: f64, anisotropy: f64) -> (f64, f64) {
    if anisotropy == 0.0 {
        return (roughness, 0.0);
    }
    let alpha = roughness * roughness;
    roughness_anisotropy((alpha * (1.0 + anisotropy)).min(1.0), alpha * (1.0 - anisotropy))
}

/// Single-scattering albedo that gives a thick body this colour (5.6): the exact inverse of [`scatter_color_of`], with all its digits.
pub fn single_scattering_albedo(color: f64) -> f64 {
    let c = color.clamp(0.0, 1.0);
    let b = 1.139 + 1.17 * c;
    let q = 2.0 * (1.0 - c) / (b + (b * b - 0.556 * (1.0 - c)).sqrt());
    (1.0 - q) * (1.0 + q)
}

/// The colour of a thick body with this single-scattering albedo (5.6): the inverse.
pub fn scatter_color_of(albedo: f64) -> f64 {
    let q = (1.0 - albedo.clamp(0.0, 1.0)).sqrt();
    ((1.0 - q) * (1.0 - 0.139 * q) / (1.0 + 1.17 * q)).clamp(0.0, 1.0)
}

/// Extinction of the scattering body per channel, per unit of length of the material (5.6). 0 while scattering is off.
pub fn extinction(i: &Inputs<f64>) -> [f64; 3] {
    const RAYLEIGH: [f64; 3] = [0.506_82, 1.0, 1.899_08];
    if !i.scatter {
        return [0.0; 3];
    }
    let albedo = i.scatter_color.map(single_scattering_albedo);
    let most = albedo.iter().copied().fold(0.0, f64::max);
    std::array::from_fn(|k| {
        let ratio = if most > 0.0 { most / albedo[k].max(most / 1000.0) } else { 1.0 };
        let rayleigh = 1.0 + i.scatter_rayleigh * (RAYLEIGH[k] - 1.0);
        let red = if k == 0 { 0.1_f64.powf(i.scatter_red_shift) } else { 1.0 };
        ratio / i.scatter_distance.max(1e-9) / i.scatter_distance_scale[k].max(1e-3) * rayleigh * red
    })
}

/// Mean free path by channel: the longest, and each one as a share of it (5.6).
pub fn mean_free_paths(extinction: [f64; 3]) -> (f64, [f64; 3]) {
    let paths = extinction.map(|e| if e > 0.0 { 1.0 / e } else { 0.0 });
    let longest = paths.iter().copied().fold(0.0, f64::max);
    (longest, paths.map(|path| if longest > 0.0 { path / longest } else { 1.0 }))
}

/// `scatter_distance_scale` that gives these mean free paths for this colour, red shift and Rayleigh scattering off (5.6). Not clamped.
pub fn distance_scale(color: [f64; 3], paths: [f64; 3]) -> [f64; 3] {
    let albedo = color.map(single_scattering_albedo);
    let most = albedo.iter().copied().fold(0.0, f64::max);
    let longest = paths.iter().copied().fold(0.0, f64::max);
    std::array::from_fn(|k| {
        if longest <= 0.0 || most <= 0.0 { 1.0 } else { paths[k] * most / (albedo[k].max(most / 1000.0) * longest) }
    })
}

/// Absorption per channel, per unit of length of the material; 0 where the distance is 0 (5.5).
pub fn absorption(i: &Inputs<f64>) -> [f64; 3] {
    if i.absorption_distance <= 0.0 {
        return [0.0; 3];
    }
    i.absorption_color.map(|c| -c.clamp(1e-3, 1.0).ln() / i.absorption_distance)
}

/// Weighted mean of two colours; `t` 0 gives `a`.
pub fn mix(a: [f64; 3], b: [f64; 3], t: f64) -> [f64; 3] {
    std::array::from_fn(|k| if t == 0.0 { a[k] } else { a[k] + (b[k] - a[k]) * t })
}

/// The largest number of a colour.
pub fn largest(color: [f64; 3]) -> f64 {
    color.into_iter().fold(f64::NEG_INFINITY, f64::max)
}

/// Amount and colour from their product: the largest number, and the colour scaled so that its largest is 1. White where the amount is 0.
pub fn split_amount(product: [f64; 3]) -> (f64, [f64; 3]) {
    let amount = largest(product);
    if amount > 0.0 { (amount, product.map(|c| c / amount)) } else { (0.0, [1.0; 3]) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(a: f64, b: f64) {
        assert!((a - b).abs() <= 1e-6, "{a} {b}");
    }

    #[test]
    fn levels_fold_as_published() {
        for (ior, level, folded) in [(1.5, 0.25, 1.329431), (1.5, 1.0, 1.788789), (2.4, 0.8, 3.174021), (1.6, 0.4, 1.520181)] {
            near(fold_level(ior, level), folded);
        }
    }

    #[test]
    fn scattering_colours_and_albedos_are_inverse() {
        for (color, albedo) in [(0.2, 0.613357), (0.5, 0.911709), (0.8, 0.990589), (0.0, 0.0), (1.0, 1.0)] {
            assert!((single_scattering_albedo(color) - albedo).abs() <= 6e-6);
            near(scatter_color_of(single_scattering_albedo(color)), color);
        }
    }
}
