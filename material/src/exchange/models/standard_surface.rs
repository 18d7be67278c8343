//! Autodesk Standard Surface 1.0.1, as MaterialX's `standard_surface` names its parameters.
//!
//! It has no level above the index of refraction and no width of the highlight beyond an anisotropy of 0.98; its sheen is another lobe,
//! whose roughness follows ASM's by a power that the MaterialX library uses between Standard Surface and OpenPBR.

use super::super::formulas as f;
use super::super::loss::{Cell, Fate};
use super::super::model::{Context, Notes, ShadingModel};
use super::fates;
use crate::exchange::interpreting::{default_inputs, distances, turn, unit};
use crate::properties::{Inputs, Property};

/// Power from ASM's roughness of the sheen to this model's, chosen by eye in the MaterialX library.
const SHEEN_POWER: f64 = 2.5;

crate::shading_fields! {
    /// Parameters of `standard_surface`.
    StandardSurface {
        base: Float(1.0), "base", from [], to [base_color], image;
        base_color: Color([0.8; 3]), "base_color", from [base_color], to [base_color], image;
        metalness: Float(0.0), "metalness", from [metallic], to [metallic], image;
        specular: Float(1.0), "specular", from [specular_level], to [specular_level], image;
        specular_color: Color([1.0; 3]), "specular_color", from [specular_edge_color], to [specular_edge_color], image;
        specular_roughness: Float(0.2), "specular_roughness", from [roughness, anisotropy], to [roughness, anisotropy], image;
        specular_ior: Float(1.5), "specular_IOR", from [specular_ior, specular_level], to [specular_ior], uniform;
        specular_anisotropy: Float(0.0), "specular_anisotropy", from [roughness, anisotropy], to [roughness, anisotropy], image;
        /// Turns, clockwise.
        specular_rotation: Float(0.0), "specular_rotation", from [anisotropy_rotation], to [anisotropy_rotation], image;
        transmission: Float(0.0), "transmission", from [translucency, scatter], to [translucency, scatter], image;
        transmission_color: Color([1.0; 3]), "transmission_color", from [absorption_color], to [absorption_color], image;
        transmission_depth: Float(0.0), "transmission_depth", from [absorption_distance], to [absorption_distance], uniform;
        /// Abbe number; 0 means none.
        transmission_dispersion: Float(0.0), "transmission_dispersion", from [dispersion], to [dispersion], uniform;
        subsurface: Float(0.0), "subsurface", from [translucency, scatter], to [translucency, scatter], image;
        subsurface_color: Color([1.0; 3]), "subsurface_color", from [scatter_color], to [scatter_color], image;
        subsurface_radius: Color([1.0; 3]), "subsurface_radius", from [scatter_distance, scatter_distance_scale, scatter_color, scatter_red_shift, scatter_rayleigh], to [scatter_distance, scatter_distance_scale, scatter_red_shift, scatter_rayleigh], image;
        subsurface_scale: Float(1.0), "subsurface_scale", from [scatter_distance, scatter_distance_scale, scatter_color, scatter_red_shift, scatter_rayleigh], to [scatter_distance, scatter_distance_scale, scatter_red_shift, scatter_rayleigh], uniform;
        sheen: Float(0.0), "sheen", from [sheen], to [sheen], image;
        sheen_color: Color([1.0; 3]), "sheen_color", from [sheen_color], to [sheen_color], image;
        sheen_roughness: Float(0.3), "sheen_roughness", from [sheen_roughness], to [sheen_roughness], image;
        coat: Float(0.0), "coat", from [coat], to [coat], image;
        coat_color: Color([1.0; 3]), "coat_color", from [coat_color], to [coat_color], image;
        coat_roughness: Float(0.1), "coat_roughness", from [coat_roughness], to [coat_roughness], image;
        coat_ior: Float(1.5), "coat_IOR", from [coat_ior, coat_specular_level], to [coat_ior, coat_specular_level], uniform;
        coat_normal: Normal([0.0, 0.0, 1.0]), "coat_normal", from [coat_normal], to [coat_normal], image;
        coat_normal_scale: Float(1.0), "coat_normal.scale", from [coat_normal_scale], to [coat_normal_scale], uniform;
        emission: Float(0.0), "emission", from [emission], to [emission], uniform;
        emission_color: Color([1.0; 3]), "emission_color", from [emission_color], to [emission_color], image;
        opacity: Color([1.0; 3]), "opacity", from [opacity], to [opacity], image;
        normal: Normal([0.0, 0.0, 1.0]), "normal", from [normal], to [normal], image;
        normal_scale: Float(1.0), "normal.scale", from [normal_scale], to [normal_scale], uniform;
        /// Signed, in heights: written as a displacement beside the surface.
        displacement: Float(0.0), "displacement", from [height, height_level], to [height, height_level], image;
        displacement_scale: Float(1.0), "displacement.scale", from [height_scale], to [height_scale], uniform;
    }
}

/// Autodesk Standard Surface.
pub const MODEL: ShadingModel = ShadingModel {
    name: "standard_surface",
    label: "Standard Surface",
    fields: StandardSurface::FIELDS,
    cells: CELLS,
    translate: |inputs, context| translate(inputs, context).to_values(),
    interpret: |values, context, notes| interpret(&StandardSurface::from_values(values), context, notes),
};

/// What a material becomes.
pub fn translate(i: &Inputs<f64>, _: &Context) -> StandardSurface {
    let (roughness, anisotropy) = f::aspect_roughness(i.roughness, i.anisotropy);
    let scatter = if i.scatter { 1.0 } else { 0.0 };
    let (radius, radius_scale) = f::mean_free_paths(f::extinction(i));
    StandardSurface {
        base: 1.0,
        base_color: i.base_color,
        metalness: i.metallic,
        specular: (2.0 * i.specular_level).min(1.0),
        specular_color: i.specular_edge_color,
        specular_roughness: roughness,
        specular_ior: f::fold_level(i.specular_ior, i.specular_level.max(0.5)),
        specular_anisotropy: anisotropy,
        specular_rotation: if i.anisotropy_rotation == 0.0 { 0.0 } else { 1.0 - i.anisotropy_rotation },
        transmission: i.translucency * (1.0 - scatter),
        transmission_color: i.absorption_color,
        transmission_depth: i.absorption_distance,
        // Below that, nothing is seen of it, and the quotient leaves single precision.
        transmission_dispersion: if i.dispersion > 1e-6 { 20.0 / i.dispersion } else { 0.0 },
        subsurface: i.translucency * scatter,
        subsurface_color: i.scatter_color,
        subsurface_radius: if i.scatter { radius_scale } else { i.scatter_distance_scale },
        subsurface_scale: if i.scatter { radius } else { i.scatter_distance },
        sheen: i.sheen,
        sheen_color: i.sheen_color,
        sheen_roughness: i.sheen_roughness.powf(SHEEN_POWER),
        coat: i.coat,
        coat_color: i.coat_color,
        coat_roughness: i.coat_roughness,
        coat_ior: f::fold_level(i.coat_ior, i.coat_specular_level),
        coat_normal: i.coat_normal,
        coat_normal_scale: i.coat_normal_scale,
        emission: i.emission,
        emission_color: i.emission_color,
        opacity: [i.opacity; 3],
        normal: i.normal,
        normal_scale: i.normal_scale,
        displacement: i.height - i.height_level,
        displacement_scale: i.height_scale,
    }
}

/// What these parameters mean.
pub fn interpret(p: &StandardSurface, _: &Context, notes: &mut Notes) -> Inputs<f64> {
    let mut i = default_inputs();
    i.base_color = p.base_color.map(|c| unit("base_color", p.base * c, notes));
    i.metallic = unit("metalness", p.metalness, notes);
    i.specular_level = 0.5 * unit("specular", p.specular, notes);
    i.specular_edge_color = p.specular_color.map(|c| unit("specular_color", c, notes));
    i.specular_ior = p.specular_ior.max(1.0);
    (i.roughness, i.anisotropy) = f::roughness_of_aspect(p.specular_roughness, p.specular_anisotropy);
    i.anisotropy_rotation = if p.specular_rotation == 0.0 { 0.0 } else { turn(1.0 - p.specular_rotation) };
    i.scatter = p.subsurface > 0.0;
    i.translucency = unit("transmission", if i.scatter { p.subsurface } else { p.transmission }, notes);
    if i.scatter && p.transmission > 0.0 {
        notes.push("transmission: ASM's body either scatters or is clear; it scatters".to_owned());
    }
    i.absorption_color = p.transmission_color.map(|c| unit("transmission_color", c, notes));
    i.absorption_distance = p.transmission_depth.max(0.0);
    i.dispersion = if p.transmission_dispersion > 0.0 { (20.0 / p.transmission_dispersion).min(20.0) } else { 0.0 };
    i.scatter_color = p.subsurface_color.map(|c| unit("subsurface_color", c, notes));
    let paths = p.subsurface_radius.map(|s| s.max(0.0) * p.subsurface_scale.max(0.0));
    (i.scatter_distance, i.scatter_distance_scale) = match i.scatter {
        true => distances(i.scatter_color, paths, "subsurface_radius", notes),
        false => (p.subsurface_scale.max(0.0), p.subsurface_radius),
    };
    i.sheen = unit("sheen", p.sheen, notes);
    i.sheen_color = p.sheen_color.map(|c| unit("sheen_color", c, notes));
    i.sheen_roughness = unit("sheen_roughness", p.sheen_roughness, notes).powf(1.0 / SHEEN_POWER);
    i.coat = unit("coat", p.coat, notes);
    i.coat_color = p.coat_color.map(|c| unit("coat_color", c, notes));
    i.coat_roughness = unit("coat_roughness", p.coat_roughness, notes);
    i.coat_ior = p.coat_ior.max(1.0);
    (i.coat_normal, i.coat_normal_scale) = (p.coat_normal, p.coat_normal_scale);
    i.emission = p.emission.max(0.0);
    i.emission_color = p.emission_color;
    i.opacity = unit("opacity", p.opacity.iter().sum::<f64>() / 3.0, notes);
    if p.opacity.iter().any(|o| (o - p.opacity[0]).abs() > 1e-6) {
        notes.push("opacity: ASM's has no colour; the mean of the three channels is taken".to_owned());
    }
    (i.normal, i.normal_scale) = (p.normal, p.normal_scale);
    i.height = p.displacement + i.height_level;
    i.height_scale = p.displacement_scale;
    i
}

const CELLS: &[Cell] = &[
    Cell::exact(Property::base_color, "base_color"),
    Cell { property: Property::roughness, target: "specular_roughness", fate: fates::aspect },
    Cell::exact(Property::metallic, "metalness"),
    Cell { property: Property::opacity, target: "opacity", fate: |_| (Fate::Remapped, "the same in three channels") },
    Cell { property: Property::specular_level, target: "specular, specular_IOR", fate: level },
    Cell {
        property: Property::specular_edge_color,
        target: "specular_color",
        fate: |i| match i.specular_edge_color {
            [1.0, 1.0, 1.0] => (Fate::Exact, ""),
            _ => (Fate::Approximated, "metal is tinted by another formula at grazing angles"),
        },
    },
    Cell::exact(Property::normal, "normal"),
    Cell { property: Property::normal_scale, target: "normalmap.scale", fate: |i| fates::slope(i.normal_scale) },
    Cell::dropped(Property::combine_normal_and_height),
    Cell { property: Property::height, target: "displacement", fate: fates::height },
    Cell::exact(Property::height_scale, "displacement.scale"),
    Cell { property: Property::height_level, target: "displacement", fate: fates::height },
    Cell { property: Property::anisotropy, target: "specular_anisotropy", fate: fates::aspect },
    Cell {
        property: Property::anisotropy_rotation,
        target: "specular_rotation",
        fate: |_| (Fate::Remapped, "turns the other way"),
    },
    Cell::exact(Property::emission, "emission"),
    Cell::exact(Property::emission_color, "emission_color"),
    Cell { property: Property::sheen, target: "sheen", fate: sheen },
    Cell { property: Property::sheen_color, target: "sheen_color", fate: sheen },
    Cell { property: Property::sheen_roughness, target: "sheen_roughness", fate: sheen },
    Cell {
        property: Property::translucency,
        target: "transmission, subsurface",
        fate: |i| if i.scatter { (Fate::Remapped, "the body scatters: written as subsurface") } else { (Fate::Exact, "") },
    },
    Cell { property: Property::specular_ior, target: "specular_IOR", fate: folded_ior },
    Cell { property: Property::dispersion, target: "transmission_dispersion", fate: |_| (Fate::Remapped, "as an Abbe number") },
    Cell::exact(Property::absorption_color, "transmission_color"),
    Cell::exact(Property::absorption_distance, "transmission_depth"),
    Cell { property: Property::scatter, target: "subsurface", fate: fates::scatter },
    Cell::exact(Property::scatter_color, "subsurface_color"),
    Cell { property: Property::scatter_distance, target: "subsurface_scale", fate: fates::mean_free_path },
    Cell { property: Property::scatter_distance_scale, target: "subsurface_radius", fate: fates::mean_free_path },
    Cell { property: Property::scatter_red_shift, target: "subsurface_radius", fate: fates::folded_path },
    Cell { property: Property::scatter_rayleigh, target: "subsurface_radius", fate: fates::folded_path },
    Cell::exact(Property::coat, "coat"),
    Cell::exact(Property::coat_color, "coat_color"),
    Cell::exact(Property::coat_roughness, "coat_roughness"),
    Cell { property: Property::coat_ior, target: "coat_IOR", fate: fates::coat_level },
    Cell { property: Property::coat_specular_level, target: "coat_IOR", fate: fates::coat_level },
    Cell::exact(Property::coat_normal, "coat_normal"),
    Cell { property: Property::coat_normal_scale, target: "normalmap.scale", fate: |i| fates::slope(i.coat_normal_scale) },
    Cell::dropped(Property::ambient_occlusion),
    Cell::dropped(Property::volume_thickness),
    Cell::dropped(Property::volume_thickness_scale),
];

fn level(i: &Inputs<f64>) -> (Fate, &'static str) {
    match i.specular_level {
        0.5 => (Fate::Exact, ""),
        l if l > 0.5 => (Fate::Approximated, "the level became part of the index of refraction"),
        _ if i.metallic == 0.0 => (Fate::Remapped, ""),
        _ => (Fate::Approximated, "the weight dims the edge of metal as well, which a level does not"),
    }
}

fn folded_ior(i: &Inputs<f64>) -> (Fate, &'static str) {
    if i.specular_level <= 0.5 { (Fate::Exact, "") } else { (Fate::Approximated, "with the level in it, which refracts more") }
}

fn sheen(i: &Inputs<f64>) -> (Fate, &'static str) {
    match i.sheen {
        0.0 => (Fate::Remapped, ""),
        _ => (Fate::Approximated, "another lobe, its roughness fitted by eye"),
    }
}
