//! `gltf_pbr`, version 2.0.1: glTF's material as a surface of MaterialX. Lengths are those of the document, and there is a displacement; what
//! scatters inside, tints a coat or changes its index has no input.

use super::super::formulas as f;
use super::super::loss::{Cell, Fate};
use super::super::model::{Context, Notes, ShadingModel};
use super::gltf::{self, THIN};
use super::{fates, gltf::Gltf};
use crate::exchange::interpreting::{default_inputs, turn, unit};
use crate::properties::{Inputs, Property};

/// Index of refraction of the coat.
const COAT_IOR: f64 = 1.5;
/// The alpha mode that mixes.
const BLEND: f64 = 2.0;

crate::shading_fields! {
    /// Parameters of `gltf_pbr`.
    GltfPbr {
        base_color: Color([1.0; 3]), "base_color", from [base_color, metallic, translucency, scatter, absorption_color, absorption_distance], to [base_color, absorption_color], image;
        metallic: Float(1.0), "metallic", from [metallic], to [metallic], image;
        roughness: Float(1.0), "roughness", from [roughness], to [roughness, anisotropy], image;
        normal: Normal([0.0, 0.0, 1.0]), "normal", from [normal], to [normal], image;
        normal_scale: Float(1.0), "normal.scale", from [normal_scale], to [normal_scale], uniform;
        occlusion: Float(1.0), "occlusion", from [ambient_occlusion], to [ambient_occlusion], image;
        transmission: Float(0.0), "transmission", from [translucency, scatter], to [translucency, absorption_color, absorption_distance, volume_thickness_scale], image;
        specular: Float(1.0), "specular", from [specular_level, specular_ior, coat, coat_ior, coat_specular_level], to [specular_level], image;
        specular_color: Color([1.0; 3]), "specular_color", from [specular_level, specular_edge_color, specular_ior, coat, coat_ior, coat_specular_level], to [specular_edge_color, specular_level], image;
        ior: Float(1.5), "ior", from [specular_ior], to [specular_ior], uniform;
        alpha: Float(1.0), "alpha", from [opacity], to [opacity], image;
        /// 0 opaque, 1 mask, 2 blend.
        alpha_mode: Float(0.0), "alpha_mode", from [], to [opacity], uniform;
        alpha_cutoff: Float(0.5), "alpha_cutoff", from [], to [opacity], uniform;
        sheen_color: Color([0.0; 3]), "sheen_color", from [sheen, sheen_color], to [sheen, sheen_color], image;
        sheen_roughness: Float(0.0), "sheen_roughness", from [sheen_roughness], to [sheen_roughness], image;
        clearcoat: Float(0.0), "clearcoat", from [coat], to [coat, coat_ior], image;
        clearcoat_roughness: Float(0.0), "clearcoat_roughness", from [coat_roughness], to [coat_roughness], image;
        clearcoat_normal: Normal([0.0, 0.0, 1.0]), "clearcoat_normal", from [coat_normal], to [coat_normal], image;
        clearcoat_normal_scale: Float(1.0), "clearcoat_normal.scale", from [coat_normal_scale], to [coat_normal_scale], uniform;
        emissive: Color([0.0; 3]), "emissive", from [emission, emission_color], to [emission, emission_color], image;
        emissive_strength: Float(1.0), "emissive_strength", from [emission, emission_color], to [emission], uniform;
        thickness: Float(0.0), "thickness", from [volume_thickness_scale, translucency, scatter], to [volume_thickness_scale, absorption_color, absorption_distance], uniform;
        /// 0 where the file says nothing: no absorption.
        attenuation_distance: Float(0.0), "attenuation_distance", from [absorption_distance, translucency, scatter], to [absorption_distance, absorption_color], uniform;
        attenuation_color: Color([1.0; 3]), "attenuation_color", from [absorption_color, absorption_distance, translucency, scatter], to [absorption_color], image;
        anisotropy_strength: Float(0.0), "anisotropy_strength", from [anisotropy, roughness], to [anisotropy], image;
        /// Radians, counterclockwise.
        anisotropy_rotation: Float(0.0), "anisotropy_rotation", from [anisotropy_rotation], to [anisotropy_rotation], image;
        dispersion: Float(0.0), "dispersion", from [dispersion], to [dispersion], uniform;
        displacement: Float(0.0), "displacement", from [height, height_level], to [height], image;
        displacement_scale: Float(1.0), "displacement.scale", from [height_scale], to [height_scale], uniform;
    }
}

/// glTF's surface of MaterialX.
pub const MODEL: ShadingModel = ShadingModel {
    name: "gltf_pbr",
    label: "glTF PBR (MaterialX)",
    fields: GltfPbr::FIELDS,
    cells: CELLS,
    translate: |inputs, context| translate(inputs, context).to_values(),
    interpret: |values, _, notes| interpret(&GltfPbr::from_values(values), notes),
};

/// What a material becomes.
pub fn translate(i: &Inputs<f64>, context: &Context) -> GltfPbr {
    let g: Gltf = gltf::translate(i, context);
    let is_body = g.transmission > 0.0;
    let is_absorbing = is_body && i.absorption_distance > 0.0;
    GltfPbr {
        base_color: g.base_color,
        metallic: g.metallic,
        roughness: g.roughness,
        normal: g.normal,
        normal_scale: g.normal_scale,
        occlusion: g.occlusion,
        transmission: g.transmission,
        specular: g.specular,
        specular_color: g.specular_color,
        ior: g.ior,
        alpha: g.opacity,
        alpha_mode: BLEND,
        alpha_cutoff: 0.5,
        sheen_color: g.sheen_color,
        sheen_roughness: g.sheen_roughness,
        clearcoat: g.clearcoat,
        clearcoat_roughness: g.clearcoat_roughness,
        clearcoat_normal: g.clearcoat_normal,
        clearcoat_normal_scale: g.clearcoat_normal_scale,
        emissive: g.emissive,
        emissive_strength: g.emissive_strength,
        // Without one, the body is a thin wall there.
        thickness: if is_body { i.volume_thickness_scale.max(THIN) } else { 0.0 },
        attenuation_distance: if is_absorbing { i.absorption_distance } else { 0.0 },
        attenuation_color: if is_absorbing { i.absorption_color } else { [1.0; 3] },
        anisotropy_strength: g.anisotropy_strength,
        anisotropy_rotation: g.anisotropy_rotation,
        dispersion: g.dispersion,
        displacement: i.height - i.height_level,
        displacement_scale: i.height_scale,
    }
}

/// What these parameters mean.
pub fn interpret(p: &GltfPbr, notes: &mut Notes) -> Inputs<f64> {
    let mut i = default_inputs();
    i.base_color = p.base_color.map(|c| unit("base_color", c, notes));
    i.metallic = unit("metallic", p.metallic, notes);
    i.roughness = unit("roughness", p.roughness, notes);
    let alpha = i.roughness * i.roughness;
    let strength = unit("anisotropy_strength", p.anisotropy_strength, notes);
    i.anisotropy = ((1.0 - alpha) * strength * strength).powf(0.25);
    i.anisotropy_rotation = turn(p.anisotropy_rotation / std::f64::consts::TAU);
    (i.normal, i.normal_scale) = (p.normal, p.normal_scale);
    i.ambient_occlusion = unit("occlusion", p.occlusion, notes);
    let above = f::largest(p.specular_color).max(1.0);
    i.specular_edge_color = p.specular_color.map(|c| unit("specular_color", c / above, notes));
    i.specular_ior = p.ior.max(1.0);
    i.opacity = match p.alpha_mode {
        0.0 => 1.0,
        1.0 => {
            if p.alpha >= p.alpha_cutoff {
                1.0
            } else {
                0.0
            }
        }
        _ => unit("alpha", p.alpha, notes),
    };
    if p.alpha_mode == 1.0 {
        notes.push("opacity: cut off at a threshold there; a value is cut off here too, an image is taken as it is".to_owned());
    }
    (i.sheen, i.sheen_color) = f::split_amount(p.sheen_color.map(|c| unit("sheen_color", c, notes)));
    i.sheen_roughness = unit("sheen_roughness", p.sheen_roughness, notes);
    i.coat = unit("clearcoat", p.clearcoat, notes);
    i.coat_roughness = unit("clearcoat_roughness", p.clearcoat_roughness, notes);
    if i.coat > 0.0 {
        i.coat_ior = COAT_IOR;
    }
    let left = 0.5 * p.specular.max(0.0) * above;
    let is_said = p.specular != 1.0 || p.specular_color != [1.0; 3];
    i.specular_level = if is_said { gltf::uncoated_level(left, &i).min(1.0) } else { 0.5 };
    (i.coat_normal, i.coat_normal_scale) = (p.clearcoat_normal, p.clearcoat_normal_scale);
    if f::largest(p.emissive) > 0.0 {
        (i.emission, i.emission_color) = (p.emissive_strength.max(0.0), p.emissive);
    }
    i.dispersion = p.dispersion.clamp(0.0, 20.0);
    i.translucency = unit("transmission", p.transmission, notes);
    if i.translucency > 0.0 {
        if p.thickness <= 0.0 {
            notes.push(
                "thickness: without one the surface is a thin wall, which ASM has not; it became a body without absorption"
                    .to_owned(),
            );
            i.absorption_color = i.base_color;
        } else if p.attenuation_distance > 0.0 {
            i.absorption_color = p.attenuation_color.map(|c| unit("attenuation_color", c, notes));
            i.absorption_distance = p.attenuation_distance;
            if i.base_color != [1.0; 3] {
                notes.push("base_color: here it does not tint the light that goes through".to_owned());
            }
        } else {
            i.absorption_color = i.base_color;
        }
        i.volume_thickness_scale = if p.thickness > 0.0 { p.thickness } else { i.volume_thickness_scale };
    }
    i.height = p.displacement + i.height_level;
    i.height_scale = p.displacement_scale;
    i
}

const CELLS: &[Cell] = &[
    Cell {
        property: Property::base_color,
        target: "base_color",
        fate: |i| if i.scatter { (Fate::Exact, "") } else { fates::tinting_base(i) },
    },
    Cell::exact(Property::roughness, "roughness"),
    Cell::exact(Property::metallic, "metallic"),
    Cell::exact(Property::opacity, "alpha"),
    Cell { property: Property::specular_level, target: "specular", fate: gltf::cells::specular },
    Cell { property: Property::specular_edge_color, target: "specular_color", fate: gltf::cells::specular },
    Cell::exact(Property::normal, "normal"),
    Cell { property: Property::normal_scale, target: "normalmap.scale", fate: |i| fates::slope(i.normal_scale) },
    Cell::dropped(Property::combine_normal_and_height),
    Cell { property: Property::height, target: "displacement", fate: fates::height },
    Cell::exact(Property::height_scale, "displacement.scale"),
    Cell { property: Property::height_level, target: "displacement", fate: fates::height },
    Cell { property: Property::anisotropy, target: "anisotropy_strength", fate: fates::widths },
    Cell {
        property: Property::anisotropy_rotation,
        target: "anisotropy_rotation",
        fate: |i| match i.anisotropy_rotation {
            1.0 => (Fate::Approximated, "a whole turn is none there"),
            _ => (Fate::Remapped, "in radians"),
        },
    },
    Cell::exact(Property::emission, "emissive_strength"),
    Cell::exact(Property::emission_color, "emissive"),
    Cell { property: Property::sheen, target: "sheen_color", fate: fates::sheen_product },
    Cell { property: Property::sheen_color, target: "sheen_color", fate: fates::sheen_product },
    Cell { property: Property::sheen_roughness, target: "sheen_roughness", fate: fates::sheen_roughness },
    Cell {
        property: Property::translucency,
        target: "transmission",
        fate: |i| match i.scatter && i.translucency > 0.0 {
            true => (Fate::Dropped, "the body scatters, which this surface cannot: it becomes opaque"),
            false => (Fate::Exact, ""),
        },
    },
    Cell::exact(Property::specular_ior, "ior"),
    Cell::exact(Property::dispersion, "dispersion"),
    Cell { property: Property::absorption_color, target: "attenuation_color, base_color", fate: absorption },
    Cell { property: Property::absorption_distance, target: "attenuation_distance", fate: absorption },
    Cell::dropped(Property::scatter),
    Cell::dropped(Property::scatter_color),
    Cell::dropped(Property::scatter_distance),
    Cell::dropped(Property::scatter_distance_scale),
    Cell::dropped(Property::scatter_red_shift),
    Cell::dropped(Property::scatter_rayleigh),
    Cell::exact(Property::coat, "clearcoat"),
    Cell::dropped(Property::coat_color),
    Cell::exact(Property::coat_roughness, "clearcoat_roughness"),
    Cell { property: Property::coat_ior, target: "clearcoat", fate: fates::fixed_coat_ior },
    Cell::dropped(Property::coat_specular_level),
    Cell::exact(Property::coat_normal, "clearcoat_normal"),
    Cell { property: Property::coat_normal_scale, target: "normalmap.scale", fate: |i| fates::slope(i.coat_normal_scale) },
    Cell::exact(Property::ambient_occlusion, "occlusion"),
    Cell::dropped(Property::volume_thickness),
    Cell {
        property: Property::volume_thickness_scale,
        target: "thickness",
        fate: |i| if is_body(i) { (Fate::Exact, "") } else { (Fate::Dropped, "there is no body that light goes through") },
    },
];

fn is_body(i: &Inputs<f64>) -> bool {
    i.translucency > 0.0 && !i.scatter
}

fn absorption(i: &Inputs<f64>) -> (Fate, &'static str) {
    if !is_body(i) {
        (Fate::Dropped, "there is no body that light goes through")
    } else if i.absorption_distance > 0.0 || i.absorption_color == [1.0; 3] {
        (Fate::Exact, "")
    } else {
        (Fate::Approximated, "mixed into the base colour, which tints transmitted light there")
    }
}
