//! OpenPBR Surface 1.1 (Academy Software Foundation), as MaterialX's `open_pbr_surface` names its parameters.
//!
//! Metal covers the translucent dielectric in both models, so metalness and transmission carry over unchanged. The fuzz lies over the coat,
//! ASM's sheen below it: told, not compensated.

use super::super::formulas as f;
use super::super::loss::{Cell, Fate};
use super::super::model::{Context, Notes, ShadingModel};
use super::fates;
use crate::exchange::interpreting::{default_inputs, distances, turn, unit};
use crate::properties::{Inputs, Property};

crate::shading_fields! {
    /// Parameters of `open_pbr_surface`.
    OpenPbr {
        base_weight: Float(1.0), "base_weight", from [], to [base_color], image;
        base_color: Color([0.8; 3]), "base_color", from [base_color], to [base_color], image;
        base_metalness: Float(0.0), "base_metalness", from [metallic], to [metallic], image;
        specular_weight: Float(1.0), "specular_weight", from [specular_level, metallic], to [specular_level], image;
        specular_color: Color([1.0; 3]), "specular_color", from [specular_edge_color], to [specular_edge_color], image;
        specular_roughness: Float(0.3), "specular_roughness", from [roughness, anisotropy], to [roughness, anisotropy], image;
        specular_roughness_anisotropy: Float(0.0), "specular_roughness_anisotropy", from [roughness, anisotropy], to [roughness, anisotropy], image;
        specular_ior: Float(1.5), "specular_ior", from [specular_ior], to [specular_ior], uniform;
        /// Turns, counterclockwise: written as a rotation of `geometry_tangent`.
        tangent_rotation: Float(0.0), "geometry_tangent", from [anisotropy_rotation], to [anisotropy_rotation], image;
        transmission_weight: Float(0.0), "transmission_weight", from [translucency, scatter], to [translucency, scatter], image;
        transmission_color: Color([1.0; 3]), "transmission_color", from [absorption_color], to [absorption_color], image;
        transmission_depth: Float(0.0), "transmission_depth", from [absorption_distance], to [absorption_distance], uniform;
        dispersion_scale: Float(0.0), "transmission_dispersion_scale", from [dispersion], to [dispersion], uniform;
        dispersion_abbe: Float(20.0), "transmission_dispersion_abbe_number", from [dispersion], to [dispersion], uniform;
        subsurface_weight: Float(0.0), "subsurface_weight", from [translucency, scatter], to [translucency, scatter], image;
        subsurface_color: Color([0.8; 3]), "subsurface_color", from [scatter_color], to [scatter_color], image;
        subsurface_radius: Float(1.0), "subsurface_radius", from [scatter_distance, scatter_distance_scale, scatter_color, scatter_red_shift, scatter_rayleigh], to [scatter_distance, scatter_distance_scale, scatter_red_shift, scatter_rayleigh], uniform;
        subsurface_radius_scale: Color([1.0, 0.5, 0.25]), "subsurface_radius_scale", from [scatter_distance, scatter_distance_scale, scatter_color, scatter_red_shift, scatter_rayleigh], to [scatter_distance, scatter_distance_scale, scatter_red_shift, scatter_rayleigh], image;
        coat_weight: Float(0.0), "coat_weight", from [coat], to [coat], image;
        coat_color: Color([1.0; 3]), "coat_color", from [coat_color], to [coat_color], image;
        coat_roughness: Float(0.0), "coat_roughness", from [coat_roughness], to [coat_roughness], image;
        coat_ior: Float(1.6), "coat_ior", from [coat_ior, coat_specular_level], to [coat_ior, coat_specular_level], uniform;
        coat_darkening: Float(1.0), "coat_darkening", from [], to [], uniform;
        fuzz_weight: Float(0.0), "fuzz_weight", from [sheen], to [sheen], image;
        fuzz_color: Color([1.0; 3]), "fuzz_color", from [sheen_color], to [sheen_color], image;
        fuzz_roughness: Float(0.5), "fuzz_roughness", from [sheen_roughness], to [sheen_roughness], image;
        emission_luminance: Float(0.0), "emission_luminance", from [emission], to [emission], uniform;
        emission_color: Color([1.0; 3]), "emission_color", from [emission_color], to [emission_color], image;
        geometry_opacity: Float(1.0), "geometry_opacity", from [opacity], to [opacity], image;
        geometry_normal: Normal([0.0, 0.0, 1.0]), "geometry_normal", from [normal], to [normal], image;
        normal_scale: Float(1.0), "geometry_normal.scale", from [normal_scale], to [normal_scale], uniform;
        geometry_coat_normal: Normal([0.0, 0.0, 1.0]), "geometry_coat_normal", from [coat_normal], to [coat_normal], image;
        coat_normal_scale: Float(1.0), "geometry_coat_normal.scale", from [coat_normal_scale], to [coat_normal_scale], uniform;
        /// Signed, in heights: written as a displacement beside the surface.
        displacement: Float(0.0), "displacement", from [height, height_level], to [height, height_level], image;
        displacement_scale: Float(1.0), "displacement.scale", from [height_scale], to [height_scale], uniform;
    }
}

/// OpenPBR Surface.
pub const MODEL: ShadingModel = ShadingModel {
    name: "open_pbr_surface",
    label: "OpenPBR",
    fields: OpenPbr::FIELDS,
    cells: CELLS,
    translate: |inputs, context| translate(inputs, context).to_values(),
    interpret: |values, context, notes| interpret(&OpenPbr::from_values(values), context, notes),
};

/// What a material becomes.
pub fn translate(i: &Inputs<f64>, _: &Context) -> OpenPbr {
    let (along, across) = f::alphas(i.roughness, i.anisotropy);
    let scatter = if i.scatter { 1.0 } else { 0.0 };
    let (radius, radius_scale) = f::mean_free_paths(f::extinction(i));
    OpenPbr {
        base_weight: 1.0,
        base_color: i.base_color,
        base_metalness: i.metallic,
        // The weight dims metal as well, which ASM's level does not.
        specular_weight: 2.0 * i.specular_level * (1.0 - i.metallic) + i.metallic,
        specular_color: i.specular_edge_color,
        specular_roughness: if i.anisotropy == 0.0 { i.roughness } else { ((along * along + across * across) / 2.0).powf(0.25) },
        specular_roughness_anisotropy: if along > 0.0 { 1.0 - across / along } else { 0.0 },
        specular_ior: i.specular_ior,
        tangent_rotation: i.anisotropy_rotation,
        transmission_weight: i.translucency * (1.0 - scatter),
        transmission_color: i.absorption_color,
        transmission_depth: i.absorption_distance,
        dispersion_scale: i.dispersion.min(1.0),
        dispersion_abbe: 20.0 / i.dispersion.max(1.0),
        subsurface_weight: i.translucency * scatter,
        subsurface_color: i.scatter_color,
        subsurface_radius: if i.scatter { radius } else { i.scatter_distance },
        subsurface_radius_scale: if i.scatter { radius_scale } else { i.scatter_distance_scale },
        coat_weight: i.coat,
        coat_color: i.coat_color,
        coat_roughness: i.coat_roughness,
        coat_ior: f::fold_level(i.coat_ior, i.coat_specular_level),
        coat_darkening: 0.0,
        fuzz_weight: i.sheen,
        fuzz_color: i.sheen_color,
        fuzz_roughness: i.sheen_roughness,
        emission_luminance: f::NITS * i.emission,
        emission_color: i.emission_color,
        geometry_opacity: i.opacity,
        geometry_normal: i.normal,
        normal_scale: i.normal_scale,
        geometry_coat_normal: i.coat_normal,
        coat_normal_scale: i.coat_normal_scale,
        displacement: i.height - i.height_level,
        displacement_scale: i.height_scale,
    }
}

/// What these parameters mean.
pub fn interpret(p: &OpenPbr, _: &Context, notes: &mut Notes) -> Inputs<f64> {
    let mut i = default_inputs();
    i.base_color = p.base_color.map(|c| unit("base_color", p.base_weight * c, notes));
    i.metallic = unit("base_metalness", p.base_metalness, notes);
    i.specular_ior = p.specular_ior.max(1.0);
    let dielectric = 1.0 - i.metallic;
    // Where all is metal, the weight says nothing about a dielectric.
    let weight = if dielectric > 1e-9 { ((p.specular_weight - i.metallic) / dielectric).max(0.0) } else { 1.0 };
    i.specular_level = (0.5 * weight).min(1.0);
    if weight > 2.0 {
        i.specular_ior = f::ior_of_f0(weight / 2.0 * f::f0_of_ior(i.specular_ior));
        notes.push(format!(
            "specular_weight: {weight} is more than a level can say; the rest became part of the index of refraction"
        ));
    }
    i.specular_edge_color = p.specular_color.map(|c| unit("specular_color", c, notes));
    let (roughness, anisotropy) = (p.specular_roughness.clamp(0.0, 1.0), p.specular_roughness_anisotropy.clamp(0.0, 1.0));
    if anisotropy == 0.0 {
        i.roughness = roughness;
    } else {
        let along = roughness * roughness * (2.0 / (1.0 + (1.0 - anisotropy) * (1.0 - anisotropy))).sqrt();
        (i.roughness, i.anisotropy) = f::roughness_anisotropy(along, (1.0 - anisotropy) * along);
        i.roughness = i.roughness.min(1.0);
    }
    i.anisotropy_rotation = turn(p.tangent_rotation);
    i.scatter = p.subsurface_weight > 0.0;
    i.translucency = unit("transmission_weight", if i.scatter { p.subsurface_weight } else { p.transmission_weight }, notes);
    if i.scatter && p.transmission_weight > 0.0 {
        notes.push("transmission_weight: ASM's body either scatters or is clear; it scatters".to_owned());
    }
    i.absorption_color = p.transmission_color.map(|c| unit("transmission_color", c, notes));
    i.absorption_distance = p.transmission_depth.max(0.0);
    i.dispersion = (p.dispersion_scale * 20.0 / p.dispersion_abbe.max(1e-3)).clamp(0.0, 20.0);
    i.scatter_color = p.subsurface_color.map(|c| unit("subsurface_color", c, notes));
    let paths = p.subsurface_radius_scale.map(|s| s.max(0.0) * p.subsurface_radius.max(0.0));
    (i.scatter_distance, i.scatter_distance_scale) = match i.scatter {
        true => distances(i.scatter_color, paths, "subsurface_radius_scale", notes),
        false => (p.subsurface_radius.max(0.0), p.subsurface_radius_scale),
    };
    i.coat = unit("coat_weight", p.coat_weight, notes);
    i.coat_color = p.coat_color.map(|c| unit("coat_color", c, notes));
    i.coat_roughness = unit("coat_roughness", p.coat_roughness, notes);
    i.coat_ior = p.coat_ior.max(1.0);
    i.sheen = unit("fuzz_weight", p.fuzz_weight, notes);
    i.sheen_color = p.fuzz_color.map(|c| unit("fuzz_color", c, notes));
    i.sheen_roughness = unit("fuzz_roughness", p.fuzz_roughness, notes);
    i.emission = (p.emission_luminance / f::NITS).max(0.0);
    i.emission_color = p.emission_color;
    i.opacity = unit("geometry_opacity", p.geometry_opacity, notes);
    (i.normal, i.normal_scale) = (p.geometry_normal, p.normal_scale);
    (i.coat_normal, i.coat_normal_scale) = (p.geometry_coat_normal, p.coat_normal_scale);
    i.height = p.displacement + i.height_level;
    i.height_scale = p.displacement_scale;
    i
}

const CELLS: &[Cell] = &[
    Cell::exact(Property::base_color, "base_color"),
    Cell { property: Property::roughness, target: "specular_roughness", fate: highlight },
    Cell::exact(Property::metallic, "base_metalness"),
    Cell::exact(Property::opacity, "geometry_opacity"),
    Cell {
        property: Property::specular_level,
        target: "specular_weight",
        fate: |i| match i.metallic {
            0.0 => (Fate::Remapped, ""),
            1.0 => (Fate::Dropped, "metal has no level"),
            _ => (Fate::Approximated, "the weight dims metal as well, which a level does not"),
        },
    },
    Cell {
        property: Property::specular_edge_color,
        target: "specular_color",
        fate: |i| match i.specular_edge_color {
            [1.0, 1.0, 1.0] => (Fate::Exact, ""),
            _ if i.metallic == 1.0 => (Fate::Exact, ""),
            _ => (Fate::Approximated, "a dielectric is tinted a little differently towards grazing angles"),
        },
    },
    Cell::exact(Property::normal, "geometry_normal"),
    Cell { property: Property::normal_scale, target: "normalmap.scale", fate: |i| fates::slope(i.normal_scale) },
    Cell::dropped(Property::combine_normal_and_height),
    Cell { property: Property::height, target: "displacement", fate: fates::height },
    Cell::exact(Property::height_scale, "displacement.scale"),
    Cell { property: Property::height_level, target: "displacement", fate: fates::height },
    Cell { property: Property::anisotropy, target: "specular_roughness_anisotropy", fate: highlight },
    Cell {
        property: Property::anisotropy_rotation,
        target: "geometry_tangent",
        fate: |_| (Fate::Remapped, "a rotation of the tangent"),
    },
    Cell { property: Property::emission, target: "emission_luminance", fate: |_| (Fate::Remapped, "1 is 1000 nits") },
    Cell::exact(Property::emission_color, "emission_color"),
    Cell { property: Property::sheen, target: "fuzz_weight", fate: fuzz },
    Cell { property: Property::sheen_color, target: "fuzz_color", fate: fuzz },
    Cell { property: Property::sheen_roughness, target: "fuzz_roughness", fate: fuzz },
    Cell {
        property: Property::translucency,
        target: "transmission_weight, subsurface_weight",
        fate: |i| if i.scatter { (Fate::Remapped, "the body scatters: written as subsurface") } else { (Fate::Exact, "") },
    },
    Cell::exact(Property::specular_ior, "specular_ior"),
    Cell { property: Property::dispersion, target: "transmission_dispersion_scale", fate: |_| (Fate::Remapped, "") },
    Cell::exact(Property::absorption_color, "transmission_color"),
    Cell::exact(Property::absorption_distance, "transmission_depth"),
    Cell { property: Property::scatter, target: "subsurface_weight", fate: fates::scatter },
    Cell::exact(Property::scatter_color, "subsurface_color"),
    Cell { property: Property::scatter_distance, target: "subsurface_radius", fate: fates::mean_free_path },
    Cell { property: Property::scatter_distance_scale, target: "subsurface_radius_scale", fate: fates::mean_free_path },
    Cell { property: Property::scatter_red_shift, target: "subsurface_radius_scale", fate: fates::folded_path },
    Cell { property: Property::scatter_rayleigh, target: "subsurface_radius_scale", fate: fates::folded_path },
    Cell::exact(Property::coat, "coat_weight"),
    Cell::exact(Property::coat_color, "coat_color"),
    Cell::exact(Property::coat_roughness, "coat_roughness"),
    Cell { property: Property::coat_ior, target: "coat_ior", fate: fates::coat_level },
    Cell { property: Property::coat_specular_level, target: "coat_ior", fate: fates::coat_level },
    Cell::exact(Property::coat_normal, "geometry_coat_normal"),
    Cell { property: Property::coat_normal_scale, target: "normalmap.scale", fate: |i| fates::slope(i.coat_normal_scale) },
    Cell::dropped(Property::ambient_occlusion),
    Cell::dropped(Property::volume_thickness),
    Cell::dropped(Property::volume_thickness_scale),
];

fn highlight(i: &Inputs<f64>) -> (Fate, &'static str) {
    match i.anisotropy {
        0.0 => (Fate::Exact, ""),
        a if i.roughness * i.roughness + a.powi(4) <= 1.0 => (Fate::Remapped, "another split of the same two widths"),
        _ => (Fate::Approximated, "the lobe is as wide as it can be; how much further was asked for is lost"),
    }
}

fn fuzz(i: &Inputs<f64>) -> (Fate, &'static str) {
    match i.sheen {
        0.0 => (Fate::Exact, ""),
        _ if i.coat > 0.0 => (Fate::Approximated, "the fuzz lies over the coat there, below it here"),
        _ => (Fate::Approximated, "another lobe with the same numbers"),
    }
}
