//! The Disney principled model, as MaterialX's `disney_principled` names its parameters and its nodegraph uses them.
//!
//! One colour serves diffuse reflection, metal, transmission and scattering; what is refracted is never rough; the coat has a fixed index of
//! refraction. There is no emission, no opacity and no normal map.

use super::super::formulas as f;
use super::super::loss::{Cell, Fate};
use super::super::model::{Context, Notes, ShadingModel};
use super::fates;
use crate::exchange::interpreting::{default_inputs, distances, unit};
use crate::properties::{Inputs, Property};

/// Reflection at normal incidence of a specular of 1.
const FULL_F0: f64 = 0.08;
/// Index of refraction of the coat, which reflects 0.04.
const COAT_IOR: f64 = 1.5;

crate::shading_fields! {
    /// Parameters of `disney_principled`.
    Disney {
        base_color: Color([0.16; 3]), "baseColor", from [base_color, metallic, translucency, absorption_color, absorption_distance, scatter, scatter_color], to [base_color, absorption_color, scatter_color, specular_edge_color, sheen_color], image;
        metallic: Float(0.0), "metallic", from [metallic], to [metallic], image;
        roughness: Float(0.5), "roughness", from [roughness, anisotropy], to [roughness, anisotropy], image;
        anisotropic: Float(0.0), "anisotropic", from [roughness, anisotropy], to [roughness, anisotropy], image;
        specular: Float(0.5), "specular", from [specular_level, specular_ior], to [specular_level], image;
        specular_tint: Float(0.0), "specularTint", from [], to [specular_edge_color], image;
        sheen: Float(0.0), "sheen", from [sheen], to [sheen], image;
        sheen_tint: Float(0.5), "sheenTint", from [], to [sheen_color], image;
        clearcoat: Float(0.0), "clearcoat", from [coat], to [coat, coat_ior], image;
        clearcoat_gloss: Float(1.0), "clearcoatGloss", from [coat_roughness], to [coat_roughness], image;
        spec_trans: Float(0.0), "specTrans", from [translucency, scatter], to [translucency, scatter], image;
        ior: Float(1.5), "ior", from [specular_ior], to [specular_ior, specular_level], uniform;
        subsurface: Float(0.0), "subsurface", from [translucency, scatter], to [translucency, scatter], image;
        subsurface_distance: Color([1.0; 3]), "subsurfaceDistance", from [scatter_distance, scatter_distance_scale, scatter_color, scatter_red_shift, scatter_rayleigh], to [scatter_distance, scatter_distance_scale, scatter_red_shift, scatter_rayleigh], image;
    }
}

/// Disney principled.
pub const MODEL: ShadingModel = ShadingModel {
    name: "disney_principled",
    label: "Disney Principled",
    fields: Disney::FIELDS,
    cells: CELLS,
    translate: |inputs, context| translate(inputs, context).to_values(),
    interpret: |values, context, notes| interpret(&Disney::from_values(values), context, notes),
};

/// What a material becomes.
pub fn translate(i: &Inputs<f64>, _: &Context) -> Disney {
    let (roughness, anisotropic) = f::aspect_roughness(i.roughness, i.anisotropy);
    let scatter = if i.scatter { 1.0 } else { 0.0 };
    let (radius, radius_scale) = f::mean_free_paths(f::extinction(i));
    Disney {
        base_color: f::mix(i.base_color, body_color(i), (1.0 - i.metallic) * i.translucency),
        metallic: i.metallic,
        roughness,
        anisotropic,
        specular: (2.0 * i.specular_level * f::f0_of_ior(i.specular_ior) / FULL_F0).min(1.0),
        specular_tint: 0.0,
        sheen: i.sheen,
        sheen_tint: 0.0,
        clearcoat: i.coat,
        clearcoat_gloss: 1.0 - i.coat_roughness,
        spec_trans: i.translucency * (1.0 - scatter),
        ior: i.specular_ior,
        subsurface: i.translucency * scatter,
        subsurface_distance: if i.scatter {
            radius_scale.map(|s| s * radius)
        } else {
            i.scatter_distance_scale.map(|s| s * i.scatter_distance)
        },
    }
}

/// The colour that the one parameter has to give to the light which entered the body.
fn body_color(i: &Inputs<f64>) -> [f64; 3] {
    match (i.scatter, i.absorption_distance) {
        (true, _) => i.scatter_color,
        (false, 0.0) => i.absorption_color,
        _ => [1.0; 3],
    }
}

/// What these parameters mean.
pub fn interpret(p: &Disney, _: &Context, notes: &mut Notes) -> Inputs<f64> {
    let mut i = default_inputs();
    i.base_color = p.base_color.map(|c| unit("baseColor", c, notes));
    i.metallic = unit("metallic", p.metallic, notes);
    (i.roughness, i.anisotropy) = f::roughness_of_aspect(p.roughness, p.anisotropic);
    i.specular_ior = p.ior.max(1.0);
    let f0 = f::f0_of_ior(i.specular_ior);
    i.specular_level = if f0 > 0.0 { (0.5 * FULL_F0 * p.specular.max(0.0) / f0).min(1.0) } else { i.specular_level };
    i.specular_edge_color = f::mix([1.0; 3], i.base_color, unit("specularTint", p.specular_tint, notes));
    i.sheen = unit("sheen", p.sheen, notes);
    if i.sheen > 0.0 {
        i.sheen_color = f::mix([1.0; 3], i.base_color, unit("sheenTint", p.sheen_tint, notes));
    }
    i.coat = unit("clearcoat", p.clearcoat, notes);
    if i.coat > 0.0 {
        i.coat_ior = COAT_IOR;
    }
    i.coat_roughness = 1.0 - unit("clearcoatGloss", p.clearcoat_gloss, notes);
    i.scatter = p.subsurface > 0.0;
    i.translucency = unit("specTrans", if i.scatter { p.subsurface } else { p.spec_trans }, notes);
    if i.scatter && p.spec_trans > 0.0 {
        notes.push("specTrans: ASM's body either scatters or is clear; it scatters".to_owned());
    }
    let paths = p.subsurface_distance.map(|d| d.max(0.0));
    if i.scatter {
        i.scatter_color = i.base_color;
        (i.scatter_distance, i.scatter_distance_scale) = distances(i.scatter_color, paths, "subsurfaceDistance", notes);
    } else if i.translucency > 0.0 {
        i.absorption_color = i.base_color;
    }
    i
}

const CELLS: &[Cell] = &[
    Cell {
        property: Property::base_color,
        target: "baseColor",
        fate: |i| match i.translucency > 0.0 && i.metallic < 1.0 {
            false => (Fate::Exact, ""),
            true => (Fate::Approximated, "mixed with the colour of the body, for which there is no parameter of its own"),
        },
    },
    Cell { property: Property::roughness, target: "roughness", fate: fates::aspect },
    Cell::exact(Property::metallic, "metallic"),
    Cell::dropped(Property::opacity),
    Cell { property: Property::specular_level, target: "specular", fate: level },
    Cell::dropped(Property::specular_edge_color),
    Cell::dropped(Property::normal),
    Cell::dropped(Property::normal_scale),
    Cell::dropped(Property::combine_normal_and_height),
    Cell::dropped(Property::height),
    Cell::dropped(Property::height_scale),
    Cell::dropped(Property::height_level),
    Cell { property: Property::anisotropy, target: "anisotropic", fate: fates::aspect },
    Cell::dropped(Property::anisotropy_rotation),
    Cell::dropped(Property::emission),
    Cell::dropped(Property::emission_color),
    Cell { property: Property::sheen, target: "sheen", fate: |_| (Fate::Approximated, "another lobe") },
    Cell::dropped(Property::sheen_color),
    Cell::dropped(Property::sheen_roughness),
    Cell { property: Property::translucency, target: "specTrans, subsurface", fate: translucency },
    Cell { property: Property::specular_ior, target: "ior", fate: |_| (Fate::Remapped, "reflection and refraction apart") },
    Cell::dropped(Property::dispersion),
    Cell {
        property: Property::absorption_color,
        target: "baseColor",
        fate: |_| (Fate::Approximated, "mixed into the one colour"),
    },
    Cell::dropped(Property::absorption_distance),
    Cell { property: Property::scatter, target: "subsurface", fate: fates::scatter },
    Cell { property: Property::scatter_color, target: "baseColor", fate: |_| (Fate::Approximated, "mixed into the one colour") },
    Cell { property: Property::scatter_distance, target: "subsurfaceDistance", fate: fates::mean_free_path },
    Cell { property: Property::scatter_distance_scale, target: "subsurfaceDistance", fate: fates::mean_free_path },
    Cell { property: Property::scatter_red_shift, target: "subsurfaceDistance", fate: fates::folded_path },
    Cell { property: Property::scatter_rayleigh, target: "subsurfaceDistance", fate: fates::folded_path },
    Cell::exact(Property::coat, "clearcoat"),
    Cell::dropped(Property::coat_color),
    Cell { property: Property::coat_roughness, target: "clearcoatGloss", fate: |_| (Fate::Remapped, "as its opposite") },
    Cell { property: Property::coat_ior, target: "clearcoat", fate: |_| (Fate::Approximated, "the coat's is always 1.5") },
    Cell::dropped(Property::coat_specular_level),
    Cell::dropped(Property::coat_normal),
    Cell::dropped(Property::coat_normal_scale),
    Cell::dropped(Property::ambient_occlusion),
    Cell::dropped(Property::volume_thickness),
    Cell::dropped(Property::volume_thickness_scale),
];

fn level(i: &Inputs<f64>) -> (Fate, &'static str) {
    match 2.0 * i.specular_level * f::f0_of_ior(i.specular_ior) {
        f0 if f0 <= FULL_F0 => (Fate::Remapped, "with the index of refraction in it"),
        _ => (Fate::Approximated, "the model reflects 8 percent at most"),
    }
}

fn translucency(i: &Inputs<f64>) -> (Fate, &'static str) {
    match (i.scatter, i.roughness) {
        (true, _) => (Fate::Remapped, "the body scatters: written as subsurface"),
        (false, 0.0) => (Fate::Exact, ""),
        _ if i.translucency == 0.0 => (Fate::Exact, ""),
        _ => (Fate::Approximated, "what is seen through it is never blurred there"),
    }
}
