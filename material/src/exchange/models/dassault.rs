//! The Enterprise PBR Shading Model of Dassault Systèmes, version 2022x, with the names of the glTF extension `3DS_materials_enterprise_pbr` and of
//! the sample renderer dspbr-pt. Formulas: the published specification of the model.
//!
//! Widths are `r²` and `r² (1 - anisotropy)²`; the specular number scales reflection at every angle, the tint the one at normal incidence; the
//! colour of scattering is turned into an albedo by the same formula as ASM's, so that a scattering body carries over. The specification
//! draws the rotation clockwise in its formula and calls it counterclockwise in its table: the table is followed. Light through the body
//! is tinted by the albedo. By eye: the sheen, another lobe with the same number, and the emission, 1000 nits (times π in lux) for 1.
//!
//! Without counterpart in ASM, and left alone: flakes, thin films, thin walls, the phase function, and energy normalization.

use std::f64::consts::PI;

use super::super::formulas as f;
use super::super::loss::{Cell, Fate};
use super::super::model::{Context, Notes, ShadingModel};
use super::fates;
use super::gltf::attenuation;
use crate::exchange::interpreting::{default_inputs, distances, sheen, unit};
use crate::properties::{Inputs, Property};

/// Index of refraction of the coat.
const COAT_IOR: f64 = 1.5;
/// Metres, where a file does not say the distance: as good as none.
const NO_ATTENUATION: f64 = 1e5;

crate::shading_fields! {
    /// Parameters of the Enterprise PBR Shading Model.
    Dassault {
        albedo: Color([1.0; 3]), "albedo", from [base_color, metallic, translucency, absorption_color, absorption_distance], to [base_color, absorption_color, scatter_color], image;
        metallic: Float(0.0), "metallic", from [metallic], to [metallic], image;
        roughness: Float(0.0), "roughness", from [roughness, anisotropy], to [roughness, anisotropy], image;
        anisotropy: Float(0.0), "anisotropy", from [roughness, anisotropy], to [roughness, anisotropy], image;
        /// Turns, counterclockwise.
        anisotropy_rotation: Float(0.0), "anisotropyRotation", from [anisotropy_rotation], to [anisotropy_rotation], image;
        normal: Normal([0.0, 0.0, 1.0]), "normal", from [normal], to [normal], image;
        /// The component along the normal.
        displacement: Float(0.0), "displacement", from [height, height_level, height_scale], to [height], image;
        /// Diffuse light through the surface.
        translucency: Float(0.0), "translucency", from [], to [translucency, scatter, scatter_color], image;
        transparency: Float(0.0), "transparency", from [translucency], to [translucency], image;
        cutout_opacity: Float(1.0), "cutoutOpacity", from [opacity], to [opacity], image;
        specular: Float(1.0), "specular", from [specular_level], to [specular_level], image;
        specular_tint: Color([1.0; 3]), "specularTint", from [specular_edge_color], to [specular_edge_color], image;
        sheen_color: Color([0.0; 3]), "sheenColor", from [sheen, sheen_color], to [sheen, sheen_color], image;
        sheen_roughness: Float(0.3), "sheenRoughness", from [sheen_roughness], to [sheen_roughness], image;
        clearcoat: Float(0.0), "clearcoat", from [coat], to [coat, coat_ior], image;
        clearcoat_roughness: Float(0.0), "clearcoatRoughness", from [coat_roughness], to [coat_roughness], image;
        clearcoat_normal: Normal([0.0, 0.0, 1.0]), "clearcoatNormal", from [coat_normal], to [coat_normal], image;
        emission_color: Color([1.0; 3]), "emissionColor", from [emission_color], to [emission_color], image;
        /// Lux.
        emission_value: Float(0.0), "emissionValue", from [emission], to [emission], uniform;
        thin_walled: Bool(true), "thinWalled", from [translucency], to [absorption_color, absorption_distance, scatter], uniform;
        ior: Float(1.5), "ior", from [specular_ior, specular_level], to [specular_ior], uniform;
        /// 0 means none.
        abbe_number: Float(0.0), "abbeNumber", from [dispersion], to [dispersion], uniform;
        attenuation_color: Color([1.0; 3]), "attenuationColor", from [absorption_color, absorption_distance, scatter, scatter_color, scatter_distance, scatter_distance_scale, scatter_red_shift, scatter_rayleigh], to [absorption_color, scatter_distance, scatter_distance_scale, scatter_red_shift, scatter_rayleigh], uniform;
        /// Metres.
        attenuation_distance: Float(NO_ATTENUATION), "attenuationDistance", from [absorption_color, absorption_distance, scatter, scatter_color, scatter_distance, scatter_distance_scale, scatter_red_shift, scatter_rayleigh], to [absorption_distance, scatter_distance, scatter_distance_scale, scatter_red_shift, scatter_rayleigh], uniform;
        /// Black means none.
        subsurface_color: Color([0.0; 3]), "subsurfaceColor", from [absorption_color, absorption_distance, scatter, scatter_color, scatter_distance, scatter_distance_scale, scatter_red_shift, scatter_rayleigh], to [scatter, scatter_color, scatter_distance_scale], uniform;
    }
}

/// Dassault Enterprise PBR.
pub const MODEL: ShadingModel = ShadingModel {
    name: "dassault_enterprise_pbr",
    label: "Dassault Enterprise PBR",
    fields: Dassault::FIELDS,
    cells: CELLS,
    translate: |inputs, context| translate(inputs, context).to_values(),
    interpret: |values, context, notes| interpret(&Dassault::from_values(values), context, notes),
};

/// What a material becomes.
pub fn translate(i: &Inputs<f64>, context: &Context) -> Dassault {
    let (along, across) = f::alphas(i.roughness, i.anisotropy);
    let tint = if i.absorption_distance == 0.0 { i.absorption_color } else { [1.0; 3] };
    let (attenuation_color, distance) = attenuation(i, context);
    Dassault {
        albedo: f::mix(i.base_color, tint, (1.0 - i.metallic) * i.translucency),
        metallic: i.metallic,
        roughness: if i.anisotropy == 0.0 { i.roughness } else { along.sqrt() },
        anisotropy: if i.anisotropy == 0.0 || along <= 0.0 { 0.0 } else { 1.0 - (across / along).sqrt() },
        anisotropy_rotation: i.anisotropy_rotation,
        normal: i.normal,
        displacement: (i.height - i.height_level) * i.height_scale,
        translucency: 0.0,
        transparency: i.translucency,
        cutout_opacity: i.opacity,
        specular: (2.0 * i.specular_level).min(1.0),
        specular_tint: i.specular_edge_color,
        sheen_color: i.sheen_color.map(|c| i.sheen * c),
        sheen_roughness: i.sheen_roughness,
        clearcoat: i.coat,
        clearcoat_roughness: i.coat_roughness,
        clearcoat_normal: i.coat_normal,
        emission_color: i.emission_color,
        emission_value: (PI * f::NITS * i.emission).min(f64::from(f32::MAX)),
        thin_walled: i.translucency == 0.0,
        ior: f::fold_level(i.specular_ior, i.specular_level.max(0.5)).max(1.0),
        // Below that, nothing is seen of it, and the quotient leaves single precision.
        abbe_number: if i.dispersion > 1e-6 { 20.0 / i.dispersion } else { 0.0 },
        attenuation_color,
        attenuation_distance: if distance > 0.0 { distance } else { NO_ATTENUATION },
        subsurface_color: scattered(i),
    }
}

/// The colour that the body has after all scattering, where absorption takes its part of what scattering leaves.
fn scattered(i: &Inputs<f64>) -> [f64; 3] {
    if !i.scatter {
        return [0.0; 3];
    }
    let (extinction, absorption) = (f::extinction(i), f::absorption(i));
    std::array::from_fn(|k| match absorption[k] {
        0.0 => i.scatter_color[k],
        a => f::scatter_color_of(f::single_scattering_albedo(i.scatter_color[k]) * extinction[k] / (extinction[k] + a)),
    })
}

/// What these parameters mean.
pub fn interpret(p: &Dassault, context: &Context, notes: &mut Notes) -> Inputs<f64> {
    let mut i = default_inputs();
    i.base_color = p.albedo.map(|c| unit("albedo", c, notes));
    i.metallic = unit("metallic", p.metallic, notes);
    let (roughness, anisotropy) = (unit("roughness", p.roughness, notes), unit("anisotropy", p.anisotropy, notes));
    (i.roughness, i.anisotropy) = match anisotropy {
        0.0 => (roughness, 0.0),
        a => f::roughness_anisotropy(roughness * roughness, (roughness * (1.0 - a)).powi(2)),
    };
    i.anisotropy_rotation = unit("anisotropyRotation", p.anisotropy_rotation, notes);
    (i.normal, i.coat_normal) = (p.normal, p.clearcoat_normal);
    i.height = p.displacement + i.height_level;
    i.opacity = unit("cutoutOpacity", p.cutout_opacity, notes);
    i.specular_level = 0.5 * unit("specular", p.specular, notes);
    i.specular_edge_color = p.specular_tint.map(|c| unit("specularTint", c, notes));
    i.specular_ior = p.ior.max(1.0);
    (i.sheen, i.sheen_color) = sheen("sheenColor", p.sheen_color, notes);
    i.sheen_roughness = unit("sheenRoughness", p.sheen_roughness, notes);
    i.coat = unit("clearcoat", p.clearcoat, notes);
    if i.coat > 0.0 {
        i.coat_ior = COAT_IOR;
    }
    i.coat_roughness = unit("clearcoatRoughness", p.clearcoat_roughness, notes);
    i.emission = p.emission_value.max(0.0) / (PI * f::NITS);
    i.emission_color = p.emission_color.map(|c| c.max(0.0));
    i.dispersion = if p.abbe_number > 0.0 { (20.0 / p.abbe_number).min(20.0) } else { 0.0 };
    interior(p, context, &mut i, notes);
    i
}

fn interior(p: &Dassault, context: &Context, i: &mut Inputs<f64>, notes: &mut Notes) {
    let diffuse = unit("translucency", p.translucency, notes);
    i.translucency = unit("transparency", p.transparency, notes);
    if diffuse > 0.0 && i.translucency == 0.0 {
        notes.push("translucency: diffuse light through the surface there; taken as a body that scatters".to_owned());
        (i.translucency, i.scatter, i.scatter_color) = (diffuse, true, i.base_color);
    }
    if p.thin_walled && i.translucency > 0.0 {
        notes.push("thinWalled: ASM knows bodies only, so this one became a body without absorption".to_owned());
        i.absorption_color = if i.scatter { [1.0; 3] } else { i.base_color };
        return;
    }
    let color = p.attenuation_color.map(|c| unit("attenuationColor", c, notes));
    let distance = p.attenuation_distance.max(0.0) / context.meters_per_unit;
    let is_attenuated = distance > 0.0 && distance.is_finite() && color.iter().any(|c| *c < 1.0 - 1e-6);
    let body = p.subsurface_color.map(|c| unit("subsurfaceColor", c, notes));
    if f::largest(body) > 0.0 {
        (i.scatter, i.scatter_color) = (true, body);
        if is_attenuated {
            let paths = color.map(|c| distance / -c.clamp(1e-30, 0.999).ln());
            (i.scatter_distance, i.scatter_distance_scale) = distances(body, paths, "attenuationColor", notes);
        }
    } else if is_attenuated {
        (i.absorption_color, i.absorption_distance) = (color, distance);
    } else if i.translucency > 0.0 {
        i.absorption_color = i.base_color;
    }
}

const CELLS: &[Cell] = &[
    Cell { property: Property::base_color, target: "albedo", fate: fates::tinting_base },
    Cell { property: Property::roughness, target: "roughness", fate: fates::widths },
    Cell::exact(Property::metallic, "metallic"),
    Cell::exact(Property::opacity, "cutoutOpacity"),
    Cell { property: Property::specular_level, target: "specular, ior", fate: level },
    Cell {
        property: Property::specular_edge_color,
        target: "specularTint",
        fate: |i| match i.specular_edge_color {
            [1.0, 1.0, 1.0] => (Fate::Exact, ""),
            _ => (Fate::Approximated, "tints neither metal nor grazing angles there"),
        },
    },
    Cell::exact(Property::normal, "normal"),
    Cell::dropped(Property::normal_scale),
    Cell::dropped(Property::combine_normal_and_height),
    Cell { property: Property::height, target: "displacement", fate: fates::displacement },
    Cell { property: Property::height_scale, target: "displacement", fate: fates::displacement },
    Cell { property: Property::height_level, target: "displacement", fate: fates::displacement },
    Cell { property: Property::anisotropy, target: "anisotropy", fate: fates::widths },
    Cell::exact(Property::anisotropy_rotation, "anisotropyRotation"),
    Cell { property: Property::emission, target: "emissionValue", fate: |_| (Fate::Remapped, "in lux: 1 is 1000 nits") },
    Cell::exact(Property::emission_color, "emissionColor"),
    Cell { property: Property::sheen, target: "sheenColor", fate: fates::sheen_product },
    Cell { property: Property::sheen_color, target: "sheenColor", fate: fates::sheen_product },
    Cell { property: Property::sheen_roughness, target: "sheenRoughness", fate: fates::sheen_roughness },
    Cell::exact(Property::translucency, "transparency"),
    Cell {
        property: Property::specular_ior,
        target: "ior",
        fate: |i| match i.specular_level <= 0.5 {
            true => (Fate::Exact, ""),
            false => (Fate::Approximated, "with the level in it, which refracts more"),
        },
    },
    Cell { property: Property::dispersion, target: "abbeNumber", fate: |_| (Fate::Remapped, "as an Abbe number") },
    Cell { property: Property::absorption_color, target: "attenuationColor, albedo", fate: absorption },
    Cell { property: Property::absorption_distance, target: "attenuationDistance", fate: absorption },
    Cell { property: Property::scatter, target: "subsurfaceColor", fate: |_| (Fate::Remapped, "a colour other than black") },
    Cell { property: Property::scatter_color, target: "subsurfaceColor", fate: scattering },
    Cell { property: Property::scatter_distance, target: "attenuationDistance", fate: path },
    Cell { property: Property::scatter_distance_scale, target: "attenuationColor", fate: path },
    Cell { property: Property::scatter_red_shift, target: "attenuationColor", fate: folded },
    Cell { property: Property::scatter_rayleigh, target: "attenuationColor", fate: folded },
    Cell::exact(Property::coat, "clearcoat"),
    Cell::dropped(Property::coat_color),
    Cell::exact(Property::coat_roughness, "clearcoatRoughness"),
    Cell { property: Property::coat_ior, target: "clearcoat", fate: fates::fixed_coat_ior },
    Cell::dropped(Property::coat_specular_level),
    Cell::exact(Property::coat_normal, "clearcoatNormal"),
    Cell::dropped(Property::coat_normal_scale),
    Cell::dropped(Property::ambient_occlusion),
    Cell::dropped(Property::volume_thickness),
    Cell::dropped(Property::volume_thickness_scale),
];

fn level(i: &Inputs<f64>) -> (Fate, &'static str) {
    match i.specular_level {
        l if l <= 0.5 => (Fate::Remapped, ""),
        _ => (Fate::Approximated, "the level became part of the index of refraction"),
    }
}

fn absorption(i: &Inputs<f64>) -> (Fate, &'static str) {
    match i.scatter {
        true => (Fate::Approximated, "one attenuation for scattering and absorption"),
        false => (Fate::Remapped, "in metres"),
    }
}

fn scattering(i: &Inputs<f64>) -> (Fate, &'static str) {
    match (i.scatter, f::absorption(i) == [0.0; 3]) {
        (false, _) => (Fate::Dropped, "there is no colour without scattering"),
        (true, true) => (Fate::Exact, ""),
        (true, false) => (Fate::Approximated, "with the absorption in it"),
    }
}

/// Scattering distances, which absorption shortens.
fn path(i: &Inputs<f64>) -> (Fate, &'static str) {
    match (i.scatter, f::absorption(i) == [0.0; 3]) {
        (false, _) => (Fate::Dropped, "there is no distance without scattering"),
        (true, true) => fates::mean_free_path(i),
        (true, false) => (Fate::Approximated, "with the absorption in it"),
    }
}

/// Red shift and Rayleigh scattering, part of the attenuation.
fn folded(i: &Inputs<f64>) -> (Fate, &'static str) {
    if i.scatter { fates::folded_path(i) } else { (Fate::Dropped, "there is none without scattering") }
}
