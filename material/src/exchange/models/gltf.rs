//! The material of glTF 2.0 (Khronos) with its ratified extensions, `KHR_materials_diffuse_transmission` and Adobe's two for clear coats.
//!
//! A parameter's name is its place in the file's `materials[i]`: keys with dots between them, `extensions` left out. Lengths are metres
//! there; the thickness is in units of the mesh. Metal covers the translucent body in both models.

pub(super) mod cells;

use std::f64::consts::TAU;

use super::super::formulas as f;
use super::super::model::{Context, Notes, ShadingModel};
use crate::exchange::interpreting::{default_inputs, unit};
use crate::properties::Inputs;

/// Index of refraction of a coat where a file does not say it.
const PLAIN_COAT_IOR: f64 = 1.5;

/// Below this share a coat leaves nothing of the reflection under it.
pub(super) const NO_REFLECTION: f64 = 1e-6;

/// Thickness, as a share of the width, that stands for none: 0 means an infinitely thin wall to glTF.
pub(in crate::exchange) const THIN: f64 = 1e-4;

crate::shading_fields! {
    /// Parameters of a glTF material.
    Gltf {
        base_color: Color([1.0; 3]), "pbrMetallicRoughness.baseColorFactor", from [base_color, metallic, translucency, scatter, absorption_color, absorption_distance], to [base_color, absorption_color], image;
        /// What the alpha mode makes of alpha: 1 where a material is opaque, 0 or 1 where it is masked.
        opacity: Float(1.0), "pbrMetallicRoughness.baseColorFactor.alpha", from [opacity], to [opacity], image;
        metallic: Float(1.0), "pbrMetallicRoughness.metallicFactor", from [metallic], to [metallic], image;
        roughness: Float(1.0), "pbrMetallicRoughness.roughnessFactor", from [roughness], to [roughness], image;
        normal: Normal([0.0, 0.0, 1.0]), "normalTexture", from [normal], to [normal], image;
        normal_scale: Float(1.0), "normalTexture.scale", from [normal_scale], to [normal_scale], uniform;
        occlusion: Float(1.0), "occlusionTexture", from [ambient_occlusion], to [ambient_occlusion], image;
        emissive: Color([0.0; 3]), "emissiveFactor", from [emission, emission_color], to [emission, emission_color], image;
        emissive_strength: Float(1.0), "KHR_materials_emissive_strength.emissiveStrength", from [emission, emission_color], to [emission], uniform;
        /// 0 is an infinite index: the reflection is the specular colour alone.
        ior: Float(1.5), "KHR_materials_ior.ior", from [specular_ior], to [specular_ior], uniform;
        specular: Float(1.0), "KHR_materials_specular.specularFactor", from [specular_level, specular_ior, coat, coat_ior, coat_specular_level], to [specular_level], image;
        specular_color: Color([1.0; 3]), "KHR_materials_specular.specularColorFactor", from [specular_level, specular_edge_color, specular_ior, coat, coat_ior, coat_specular_level], to [specular_level, specular_edge_color], image;
        anisotropy_strength: Float(0.0), "KHR_materials_anisotropy.anisotropyStrength", from [anisotropy, roughness], to [anisotropy], image;
        /// Radians.
        anisotropy_rotation: Float(0.0), "KHR_materials_anisotropy.anisotropyRotation", from [anisotropy_rotation], to [anisotropy_rotation], image;
        sheen_color: Color([0.0; 3]), "KHR_materials_sheen.sheenColorFactor", from [sheen, sheen_color], to [sheen, sheen_color], image;
        /// The factor beside an image of the colour, which then is the colour alone; 0 where there is no image.
        sheen_image_factor: Color([0.0; 3]), "KHR_materials_sheen.sheenColorTexture.factor", from [], to [sheen, sheen_color], uniform;
        sheen_roughness: Float(0.0), "KHR_materials_sheen.sheenRoughnessFactor", from [sheen_roughness], to [sheen_roughness], image;
        transmission: Float(0.0), "KHR_materials_transmission.transmissionFactor", from [translucency, scatter], to [translucency, scatter], image;
        dispersion: Float(0.0), "KHR_materials_dispersion.dispersion", from [dispersion], to [dispersion], uniform;
        thickness_factor: Float(0.0), "KHR_materials_volume.thicknessFactor", from [volume_thickness_scale], to [volume_thickness_scale], uniform;
        /// Uniform values other than 1 become part of the factor in files.
        thickness: Float(1.0), "KHR_materials_volume.thicknessTexture", from [volume_thickness], to [volume_thickness], image;
        attenuation_color: Color([1.0; 3]), "KHR_materials_volume.attenuationColor", from [absorption_color, absorption_distance, scatter, scatter_color, scatter_distance, scatter_distance_scale, scatter_red_shift, scatter_rayleigh], to [absorption_color, scatter_distance, scatter_distance_scale, scatter_red_shift, scatter_rayleigh], uniform;
        /// Metres; 0 is none, which a file says by leaving it out.
        attenuation_distance: Float(0.0), "KHR_materials_volume.attenuationDistance", from [absorption_color, absorption_distance, scatter, scatter_color, scatter_distance, scatter_distance_scale, scatter_red_shift, scatter_rayleigh], to [absorption_distance, scatter_distance, scatter_distance_scale, scatter_red_shift, scatter_rayleigh], uniform;
        diffuse_transmission: Float(0.0), "KHR_materials_diffuse_transmission.diffuseTransmissionFactor", from [translucency, scatter], to [translucency, scatter], image;
        diffuse_transmission_color: Color([1.0; 3]), "KHR_materials_diffuse_transmission.diffuseTransmissionColorFactor", from [scatter_color, scatter], to [scatter_color], image;
        clearcoat: Float(0.0), "KHR_materials_clearcoat.clearcoatFactor", from [coat], to [coat], image;
        clearcoat_roughness: Float(0.0), "KHR_materials_clearcoat.clearcoatRoughnessFactor", from [coat_roughness], to [coat_roughness], image;
        clearcoat_normal: Normal([0.0, 0.0, 1.0]), "KHR_materials_clearcoat.clearcoatNormalTexture", from [coat_normal], to [coat_normal], image;
        clearcoat_normal_scale: Float(1.0), "KHR_materials_clearcoat.clearcoatNormalTexture.scale", from [coat_normal_scale], to [coat_normal_scale], uniform;
        clearcoat_tint: Color([1.0; 3]), "ADOBE_materials_clearcoat_tint.clearcoatTintFactor", from [coat_color], to [coat_color], image;
        clearcoat_ior: Float(PLAIN_COAT_IOR), "ADOBE_materials_clearcoat_specular.clearcoatIor", from [coat_ior, coat_specular_level], to [coat_ior], uniform;
        clearcoat_specular: Float(1.0), "ADOBE_materials_clearcoat_specular.clearcoatSpecularFactor", from [coat_specular_level], to [coat_specular_level], image;
    }
}

/// glTF 2.0.
pub const MODEL: ShadingModel = ShadingModel {
    name: "gltf",
    label: "glTF",
    fields: Gltf::FIELDS,
    cells: cells::CELLS,
    translate: |inputs, context| translate(inputs, context).to_values(),
    interpret: |values, context, notes| interpret(&Gltf::from_values(values), context, notes),
};

/// What a material becomes.
pub fn translate(i: &Inputs<f64>, context: &Context) -> Gltf {
    let transmission = if i.scatter { 0.0 } else { i.translucency };
    let tint = if i.absorption_distance == 0.0 { i.absorption_color } else { [1.0; 3] };
    let brightest = f::largest(i.emission_color).max(1.0);
    let is_dark = i.emission == 0.0 || f::largest(i.emission_color) <= 0.0;
    let (attenuation_color, attenuation_distance) = attenuation(i, context);
    let coat_level = 2.0 * i.coat_specular_level;
    let coat_ior = clearcoat_ior(i);
    let ior = i.specular_ior.max(1.0);
    // Here the coat is the surroundings of what it covers; there the base reflects as ever.
    let level = 2.0 * i.specular_level * f::share_under_coat(ior, coat_ior, i.coat);
    Gltf {
        // Transmitted light is tinted by the base colour there, not here.
        base_color: f::mix(i.base_color, tint, (1.0 - i.metallic) * transmission),
        opacity: i.opacity,
        metallic: i.metallic,
        roughness: i.roughness,
        normal: i.normal,
        normal_scale: i.normal_scale,
        occlusion: i.ambient_occlusion,
        emissive: if is_dark { [0.0; 3] } else { i.emission_color.map(|c| c.max(0.0) / brightest) },
        emissive_strength: if is_dark { 1.0 } else { (i.emission * brightest).min(f64::from(f32::MAX)) },
        ior,
        specular: level.min(1.0),
        specular_color: i.specular_edge_color.map(|c| c * level.max(1.0)),
        anisotropy_strength: strength(i.roughness, i.anisotropy),
        anisotropy_rotation: TAU * i.anisotropy_rotation,
        sheen_color: i.sheen_color.map(|c| i.sheen * c),
        sheen_image_factor: [0.0; 3],
        sheen_roughness: i.sheen_roughness,
        transmission,
        dispersion: i.dispersion,
        thickness_factor: width(context) * if i.volume_thickness_scale > 0.0 { i.volume_thickness_scale } else { THIN },
        thickness: i.volume_thickness,
        attenuation_color,
        attenuation_distance,
        diffuse_transmission: if i.scatter { i.translucency } else { 0.0 },
        diffuse_transmission_color: if i.scatter { i.scatter_color } else { [1.0; 3] },
        clearcoat: i.coat,
        clearcoat_roughness: i.coat_roughness,
        clearcoat_normal: i.coat_normal,
        clearcoat_normal_scale: i.coat_normal_scale,
        clearcoat_tint: i.coat_color,
        clearcoat_ior: coat_ior,
        clearcoat_specular: coat_level.min(1.0),
    }
}

/// The index of the coat; it takes a level above the plain one along, which the format cannot say.
pub(super) fn clearcoat_ior(i: &Inputs<f64>) -> f64 {
    if i.coat_specular_level > 0.5 { f::fold_level(i.coat_ior, i.coat_specular_level) } else { i.coat_ior }.max(1.0)
}

/// Width of the mesh; 1 where there is none.
pub(in crate::exchange) fn width(context: &Context) -> f64 {
    if context.mesh_width > 0.0 && context.mesh_width.is_finite() { context.mesh_width } else { 1.0 }
}

fn strength(roughness: f64, anisotropy: f64) -> f64 {
    let (along, across) = f::alphas(roughness, anisotropy);
    if across >= 1.0 { 0.0 } else { ((along - across) / (1.0 - across)).max(0.0).sqrt() }
}

/// Colour that is left after a distance, and the distance in metres: absorption, and what scattering takes out of a ray.
pub(super) fn attenuation(i: &Inputs<f64>, context: &Context) -> ([f64; 3], f64) {
    let meters = |distance: f64| (distance * context.meters_per_unit).min(f64::from(f32::MAX));
    if !i.scatter {
        return if i.absorption_distance > 0.0 { (i.absorption_color, meters(i.absorption_distance)) } else { ([1.0; 3], 0.0) };
    }
    let (extinction, absorption) = (f::extinction(i), f::absorption(i));
    let sigma: [f64; 3] = std::array::from_fn(|k| (extinction[k] + absorption[k]).max(1e-12));
    let distance = 1.0 / sigma.iter().copied().fold(f64::INFINITY, f64::min);
    (sigma.map(|s| (-s * distance).exp()), meters(distance))
}

/// What these parameters mean.
pub fn interpret(p: &Gltf, context: &Context, notes: &mut Notes) -> Inputs<f64> {
    let mut i = default_inputs();
    i.base_color = p.base_color.map(|c| unit("baseColorFactor", c, notes));
    i.opacity = unit("baseColorFactor alpha", p.opacity, notes);
    i.metallic = unit("metallicFactor", p.metallic, notes);
    i.roughness = unit("roughnessFactor", p.roughness, notes);
    (i.normal, i.normal_scale) = (p.normal, p.normal_scale);
    i.ambient_occlusion = unit("occlusionTexture", p.occlusion, notes);
    if f::largest(p.emissive) > 0.0 {
        (i.emission, i.emission_color) = (p.emissive_strength.max(0.0), p.emissive.map(|c| c.max(0.0)));
    }
    let alpha = i.roughness * i.roughness;
    let strength = unit("anisotropyStrength", p.anisotropy_strength, notes);
    i.anisotropy = ((1.0 - alpha) * strength * strength).powf(0.25);
    let turns = p.anisotropy_rotation / TAU;
    i.anisotropy_rotation = if (0.0..=1.0).contains(&turns) { turns } else { turns.rem_euclid(1.0) };
    sheen(p, &mut i, notes);
    interior(p, context, &mut i, notes);
    i.coat = unit("clearcoatFactor", p.clearcoat, notes);
    i.coat_roughness = unit("clearcoatRoughnessFactor", p.clearcoat_roughness, notes);
    (i.coat_normal, i.coat_normal_scale) = (p.clearcoat_normal, p.clearcoat_normal_scale);
    i.coat_color = p.clearcoat_tint.map(|c| unit("clearcoatTintFactor", c, notes));
    // A coat that is not there has nothing to say about its index.
    if p.clearcoat != 0.0 || p.clearcoat_ior != PLAIN_COAT_IOR {
        i.coat_ior = at_least("clearcoatIor", p.clearcoat_ior, 1.0, notes);
    }
    i.coat_specular_level = 0.5 * unit("clearcoatSpecularFactor", p.clearcoat_specular, notes);
    reflection(p, &mut i, notes);
    i
}

fn at_least(name: &str, x: f64, least: f64, notes: &mut Notes) -> f64 {
    if x < least {
        notes.push(format!("{name}: {x} became {least}"));
    }
    x.max(least)
}

fn reflection(p: &Gltf, i: &mut Inputs<f64>, notes: &mut Notes) {
    let specular = p.specular.max(0.0);
    let color = p.specular_color.map(|c| c.max(0.0));
    if p.ior == 0.0 {
        // The reflection is given, not the index: as much of it as possible becomes an index.
        let f0 = color.map(|c| (specular * c).min(1.0));
        (i.specular_ior, i.specular_level, i.specular_edge_color) = f::dielectric_of_f0(f0);
        return;
    }
    i.specular_ior = at_least("ior", p.ior, 1.0, notes);
    let excess = f::largest(color).max(1.0);
    i.specular_edge_color = color.map(|c| c / excess);
    let is_said = p.specular != 1.0 || p.specular_color != [1.0; 3];
    let level = if is_said { uncoated_level(0.5 * specular * excess, i) } else { 0.5 };
    if level > 1.0 + 1e-6 {
        notes.push(format!("specularColorFactor: reflects {level} times what a level of 1 does; reduced to that"));
    }
    i.specular_level = level.min(1.0);
}

/// The level that has this one left under the coat of `i`, which takes nothing away in glTF; 0.5 where the coat leaves nothing.
pub(super) fn uncoated_level(left: f64, i: &Inputs<f64>) -> f64 {
    let share = f::share_under_coat(i.specular_ior, i.coat_ior, i.coat);
    if share <= NO_REFLECTION { 0.5 } else { left / share }
}

fn sheen(p: &Gltf, i: &mut Inputs<f64>, notes: &mut Notes) {
    let color = p.sheen_color.map(|c| unit("sheenColorFactor", c, notes));
    let (of_image, tint) = f::split_amount(p.sheen_image_factor);
    if of_image > 0.0 {
        i.sheen = unit("sheenColorFactor", of_image, notes);
        i.sheen_color = std::array::from_fn(|k| color[k] * tint[k]);
    } else {
        (i.sheen, i.sheen_color) = f::split_amount(color);
        i.sheen = i.sheen.max(0.0);
    }
    // A sheen that is not there has nothing to say about its roughness.
    if i.sheen > 0.0 || p.sheen_roughness != 0.0 {
        i.sheen_roughness = unit("sheenRoughnessFactor", p.sheen_roughness, notes);
    }
}

fn interior(p: &Gltf, context: &Context, i: &mut Inputs<f64>, notes: &mut Notes) {
    let transmission = unit("transmissionFactor", p.transmission, notes);
    let diffuse = unit("diffuseTransmissionFactor", p.diffuse_transmission, notes);
    i.scatter = diffuse > 0.0;
    i.translucency = if i.scatter { diffuse } else { transmission };
    if i.scatter && transmission > 0.0 {
        notes.push("transmissionFactor: ASM's body either scatters or is clear; it scatters".to_owned());
    }
    i.dispersion = p.dispersion.clamp(0.0, 20.0);
    if p.dispersion != i.dispersion {
        notes.push(format!("dispersion: {} was brought into 0 to 20", p.dispersion));
    }
    i.volume_thickness = unit("thicknessTexture", p.thickness, notes);
    let is_thin = p.thickness_factor <= 0.0;
    if !is_thin {
        i.volume_thickness_scale = p.thickness_factor / width(context);
    }
    let distance = p.attenuation_distance.max(0.0) / context.meters_per_unit;
    let color = p.attenuation_color.map(|c| unit("attenuationColor", c, notes));
    let is_attenuated = distance > 0.0 && distance.is_finite() && !(is_thin && i.translucency > 0.0);
    if is_thin && i.translucency > 0.0 {
        notes.push(
            "thicknessFactor: a thin wall there; ASM knows bodies only, so this one became a body without absorption".to_owned(),
        );
    }
    if i.scatter {
        i.scatter_color = p.diffuse_transmission_color.map(|c| unit("diffuseTransmissionColorFactor", c, notes));
        if is_attenuated && color.iter().any(|c| *c < 1.0 - 1e-6) {
            let paths = color.map(|c| distance / -c.min(0.999).ln());
            i.scatter_distance = f::largest(paths);
            let scale = f::distance_scale(i.scatter_color, paths);
            i.scatter_distance_scale = scale.map(|s| s.clamp(0.0, 1.0));
            if scale.iter().any(|s| *s > 1.0 + 1e-6) {
                notes.push("attenuationColor: a dark channel travels further than ASM lets it; shortened".to_owned());
            }
        }
    } else if is_attenuated {
        (i.absorption_color, i.absorption_distance) = (color, distance);
        if i.translucency > 0.0 && i.base_color.iter().any(|c| *c < 1.0) {
            notes.push("baseColorFactor: tints transmitted light there, not here; kept as the base colour".to_owned());
        }
    } else if i.translucency > 0.0 {
        i.absorption_color = i.base_color;
    }
}
