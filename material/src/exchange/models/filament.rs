//! The lit model of Filament (Google), as the fragment block of a material definition names its parameters. Sources: the Filament materials
//! guide, and the Filament design document for the formulas.
//!
//! Reflection at normal incidence is `0.16 reflectance²`; widths are `(1 ± anisotropy) roughness²`; light through the body is tinted with the
//! base colour and thinned by `exp(-absorption x)`, x in metres. Of the two ways of refraction only the solid body is used: ASM has no thin
//! walls. The lit model does not scatter, its coat has an index of 1.5, and there is no displacement. That a coat, a sheen and an emission of
//! 1 look the same (1000 nits, by Adobe's convention) is a choice, not a measurement.

use std::f64::consts::TAU;

use super::super::formulas as f;
use super::super::loss::{Cell, Fate};
use super::super::model::{Context, Notes, ShadingModel};
use super::fates;
use super::gltf::width;
use crate::exchange::interpreting::{default_inputs, emission, sheen, turn, unit};
use crate::properties::{Inputs, Property};

/// Reflection at normal incidence of a reflectance of 1.
const FULL_F0: f64 = 0.16;
/// Index of refraction of the coat.
const COAT_IOR: f64 = 1.5;

crate::shading_fields! {
    /// Parameters of Filament's lit model.
    Filament {
        base_color: Color([1.0; 3]), "baseColor.rgb", from [base_color, metallic, scatter_color, translucency, scatter, absorption_color, absorption_distance], to [base_color, absorption_color], image;
        opacity: Float(1.0), "baseColor.a", from [opacity], to [opacity], image;
        metallic: Float(0.0), "metallic", from [metallic], to [metallic], image;
        roughness: Float(1.0), "roughness", from [roughness, anisotropy], to [roughness, anisotropy], image;
        reflectance: Float(0.5), "reflectance", from [specular_level, specular_ior], to [specular_level, specular_ior], image;
        /// 0 where it follows the reflectance.
        ior: Float(0.0), "ior", from [specular_level, specular_ior], to [specular_level, specular_ior], uniform;
        sheen_color: Color([0.0; 3]), "sheenColor", from [sheen, sheen_color], to [sheen, sheen_color], image;
        sheen_roughness: Float(0.0), "sheenRoughness", from [sheen_roughness], to [sheen_roughness], image;
        clear_coat: Float(0.0), "clearCoat", from [coat], to [coat, coat_ior], image;
        clear_coat_roughness: Float(0.0), "clearCoatRoughness", from [coat_roughness], to [coat_roughness], image;
        clear_coat_normal: Normal([0.0, 0.0, 1.0]), "clearCoatNormal", from [coat_normal], to [coat_normal], image;
        /// Below 0 the highlight is stretched across the direction.
        anisotropy: Float(0.0), "anisotropy", from [roughness, anisotropy], to [roughness, anisotropy, anisotropy_rotation], image;
        anisotropy_direction: Normal([1.0, 0.0, 0.0]), "anisotropyDirection", from [anisotropy_rotation], to [anisotropy_rotation], image;
        ambient_occlusion: Float(1.0), "ambientOcclusion", from [ambient_occlusion], to [ambient_occlusion], image;
        normal: Normal([0.0, 0.0, 1.0]), "normal", from [normal], to [normal], image;
        /// Nits.
        emissive: Color([0.0; 3]), "emissive.rgb", from [emission, emission_color], to [emission, emission_color], image;
        transmission: Float(0.0), "transmission", from [translucency, scatter], to [translucency], image;
        /// Per metre.
        absorption: Color([0.0; 3]), "absorption", from [translucency, scatter, absorption_color, absorption_distance], to [absorption_color, absorption_distance], image;
        /// In units of the mesh.
        thickness: Float(0.5), "thickness", from [volume_thickness, volume_thickness_scale], to [volume_thickness, volume_thickness_scale], image;
    }
}

/// Filament.
pub const MODEL: ShadingModel = ShadingModel {
    name: "filament",
    label: "Filament",
    fields: Filament::FIELDS,
    cells: CELLS,
    translate: |inputs, context| translate(inputs, context).to_values(),
    interpret: |values, context, notes| interpret(&Filament::from_values(values), context, notes),
};

/// What a material becomes.
pub fn translate(i: &Inputs<f64>, context: &Context) -> Filament {
    let (roughness, anisotropy) = f::balanced_roughness(i.roughness, i.anisotropy);
    let f0 = 2.0 * i.specular_level * f::f0_of_ior(i.specular_ior);
    let tint = match (i.scatter, i.absorption_distance) {
        (true, _) => i.scatter_color,
        (false, 0.0) => i.absorption_color,
        _ => [1.0; 3],
    };
    let direction = TAU * i.anisotropy_rotation;
    let absorption = f::absorption(i).map(|a| (a / context.meters_per_unit).min(f64::from(f32::MAX)));
    Filament {
        base_color: f::mix(i.base_color, tint, (1.0 - i.metallic) * i.translucency),
        opacity: i.opacity,
        metallic: i.metallic,
        roughness,
        reflectance: (f0.clamp(0.0, FULL_F0) / FULL_F0).sqrt(),
        ior: if i.specular_level == 0.5 && f0 <= FULL_F0 { 0.0 } else { i.specular_ior.max(1.0) },
        sheen_color: i.sheen_color.map(|c| i.sheen * c),
        sheen_roughness: i.sheen_roughness,
        clear_coat: i.coat,
        clear_coat_roughness: i.coat_roughness,
        clear_coat_normal: i.coat_normal,
        anisotropy,
        anisotropy_direction: if i.anisotropy_rotation == 0.0 {
            [1.0, 0.0, 0.0]
        } else {
            [direction.cos(), direction.sin(), 0.0]
        },
        ambient_occlusion: i.ambient_occlusion,
        normal: i.normal,
        emissive: i.emission_color.map(|c| (f::NITS * i.emission * c).min(f64::from(f32::MAX))),
        transmission: if i.scatter { 0.0 } else { i.translucency },
        absorption: if i.scatter { [0.0; 3] } else { absorption },
        thickness: i.volume_thickness * i.volume_thickness_scale * width(context),
    }
}

/// What these parameters mean.
pub fn interpret(p: &Filament, context: &Context, notes: &mut Notes) -> Inputs<f64> {
    let mut i = default_inputs();
    i.base_color = p.base_color.map(|c| unit("baseColor", c, notes));
    i.opacity = unit("baseColor.a", p.opacity, notes);
    i.metallic = unit("metallic", p.metallic, notes);
    let stretch = p.anisotropy.clamp(-1.0, 1.0);
    (i.roughness, i.anisotropy) = f::roughness_of_balanced(unit("roughness", p.roughness, notes), stretch.abs());
    let [x, y, _] = p.anisotropy_direction;
    let across = if stretch < 0.0 { 0.25 } else { 0.0 };
    i.anisotropy_rotation = turn((y.atan2(x) / TAU).rem_euclid(1.0) + across);
    let reflectance = unit("reflectance", p.reflectance, notes);
    let f0 = FULL_F0 * reflectance * reflectance;
    if p.ior > 0.0 {
        i.specular_ior = p.ior.max(1.0);
        let of_ior = f::f0_of_ior(i.specular_ior);
        i.specular_level = if of_ior > 0.0 { (0.5 * f0 / of_ior).min(1.0) } else { i.specular_level };
    } else {
        i.specular_ior = f::ior_of_f0(f0);
    }
    (i.sheen, i.sheen_color) = sheen("sheenColor", p.sheen_color, notes);
    // A sheen that is not there has nothing to say about its roughness.
    if i.sheen > 0.0 || p.sheen_roughness != 0.0 {
        i.sheen_roughness = unit("sheenRoughness", p.sheen_roughness, notes);
    }
    i.coat = unit("clearCoat", p.clear_coat, notes);
    if i.coat > 0.0 {
        i.coat_ior = COAT_IOR;
    }
    i.coat_roughness = unit("clearCoatRoughness", p.clear_coat_roughness, notes);
    (i.coat_normal, i.normal) = (p.clear_coat_normal, p.normal);
    i.ambient_occlusion = unit("ambientOcclusion", p.ambient_occlusion, notes);
    (i.emission, i.emission_color) = emission(p.emissive.map(|c| c / f::NITS));
    i.translucency = unit("transmission", p.transmission, notes);
    if i.translucency == 0.0 {
        // A body that nothing enters has nothing to say about itself.
        return i;
    }
    let absorption = p.absorption.map(|a| a.max(0.0) * context.meters_per_unit);
    let most = f::largest(absorption);
    if most > 1e-12 {
        // Any distance serves; this one is the mean free path of the darkest channel.
        i.absorption_distance = 1.0 / most;
        i.absorption_color = absorption.map(|a| (-a / most).exp());
    } else {
        i.absorption_color = i.base_color;
    }
    let thickness = p.thickness.max(0.0) / width(context);
    i.volume_thickness = thickness.min(1.0);
    i.volume_thickness_scale = thickness.max(1.0);
    i
}

const CELLS: &[Cell] = &[
    Cell { property: Property::base_color, target: "baseColor.rgb", fate: fates::tinting_base },
    Cell { property: Property::roughness, target: "roughness", fate: fates::widths },
    Cell::exact(Property::metallic, "metallic"),
    Cell::exact(Property::opacity, "baseColor.a"),
    Cell { property: Property::specular_level, target: "reflectance", fate: level },
    Cell::dropped(Property::specular_edge_color),
    Cell::exact(Property::normal, "normal"),
    Cell::dropped(Property::normal_scale),
    Cell::dropped(Property::combine_normal_and_height),
    Cell::dropped(Property::height),
    Cell::dropped(Property::height_scale),
    Cell::dropped(Property::height_level),
    Cell { property: Property::anisotropy, target: "anisotropy", fate: fates::widths },
    Cell { property: Property::anisotropy_rotation, target: "anisotropyDirection", fate: |_| (Fate::Remapped, "as a direction") },
    Cell { property: Property::emission, target: "emissive.rgb", fate: fates::emission },
    Cell { property: Property::emission_color, target: "emissive.rgb", fate: fates::emission },
    Cell { property: Property::sheen, target: "sheenColor", fate: fates::sheen_product },
    Cell { property: Property::sheen_color, target: "sheenColor", fate: fates::sheen_product },
    Cell { property: Property::sheen_roughness, target: "sheenRoughness", fate: fates::sheen_roughness },
    Cell {
        property: Property::translucency,
        target: "transmission",
        fate: |i| match i.scatter && i.translucency > 0.0 {
            true => (Fate::Approximated, "the lit model does not scatter: the colour of the body became the base colour"),
            false => (Fate::Exact, ""),
        },
    },
    Cell {
        property: Property::specular_ior,
        target: "ior, reflectance",
        fate: |_| (Fate::Remapped, "as the reflectance, where that says the same"),
    },
    Cell::dropped(Property::dispersion),
    Cell { property: Property::absorption_color, target: "absorption, baseColor.rgb", fate: absorption },
    Cell { property: Property::absorption_distance, target: "absorption", fate: absorption },
    Cell::dropped(Property::scatter),
    Cell {
        property: Property::scatter_color,
        target: "baseColor.rgb",
        fate: |i| match i.scatter && i.translucency > 0.0 {
            true => (Fate::Approximated, "mixed into the base colour"),
            false => (Fate::Dropped, "the format has nothing that means it"),
        },
    },
    Cell::dropped(Property::scatter_distance),
    Cell::dropped(Property::scatter_distance_scale),
    Cell::dropped(Property::scatter_red_shift),
    Cell::dropped(Property::scatter_rayleigh),
    Cell::exact(Property::coat, "clearCoat"),
    Cell::dropped(Property::coat_color),
    Cell::exact(Property::coat_roughness, "clearCoatRoughness"),
    Cell { property: Property::coat_ior, target: "clearCoat", fate: fates::fixed_coat_ior },
    Cell::dropped(Property::coat_specular_level),
    Cell::exact(Property::coat_normal, "clearCoatNormal"),
    Cell::dropped(Property::coat_normal_scale),
    Cell::exact(Property::ambient_occlusion, "ambientOcclusion"),
    Cell { property: Property::volume_thickness, target: "thickness", fate: thickness },
    Cell { property: Property::volume_thickness_scale, target: "thickness", fate: thickness },
];

const UNREFRACTED: &str = "nothing is refracted, so nothing is written";

fn level(i: &Inputs<f64>) -> (Fate, &'static str) {
    match 2.0 * i.specular_level * f::f0_of_ior(i.specular_ior) {
        f0 if f0 <= FULL_F0 => (Fate::Remapped, "as the reflectance"),
        _ => (Fate::Approximated, "the model reflects 16 percent at most"),
    }
}

fn absorption(i: &Inputs<f64>) -> (Fate, &'static str) {
    match (i.scatter, i.absorption_distance) {
        (true, _) => (Fate::Dropped, "the format has nothing that means it"),
        _ if i.translucency == 0.0 => (Fate::Dropped, UNREFRACTED),
        (false, 0.0) => (Fate::Remapped, "as the tint of the base colour"),
        _ => (Fate::Approximated, "as a coefficient per metre, which many pairs of colour and distance have"),
    }
}

fn thickness(i: &Inputs<f64>) -> (Fate, &'static str) {
    match i.volume_thickness_scale {
        _ if i.scatter || i.translucency == 0.0 => (Fate::Dropped, UNREFRACTED),
        1.0 => (Fate::Remapped, ""),
        _ => (Fate::Approximated, "as a product"),
    }
}
