//! UsdPreviewSurface, version 2.6 (Pixar): the surface that every program with USD shows.
//!
//! It knows neither refraction nor scattering: what is seen through a translucent body becomes opacity. Its coat has no index of refraction
//! of its own, and no level.

use super::super::formulas as f;
use super::super::loss::{Cell, Fate};
use super::super::model::{Context, Notes, ShadingModel};
use super::fates;
use crate::exchange::interpreting::{default_inputs, emission, unit};
use crate::properties::{Inputs, Property};

/// Index of refraction of the coat.
const COAT_IOR: f64 = 1.5;

crate::shading_fields! {
    /// Parameters of `UsdPreviewSurface`.
    UsdPreview {
        diffuse_color: Color([0.18; 3]), "diffuseColor", from [base_color], to [base_color], image;
        emissive_color: Color([0.0; 3]), "emissiveColor", from [emission, emission_color], to [emission, emission_color], image;
        use_specular: Bool(false), "useSpecularWorkflow", from [], to [metallic, specular_level, specular_edge_color, specular_ior], uniform;
        specular_color: Color([0.0; 3]), "specularColor", from [], to [specular_level, specular_edge_color, specular_ior], image;
        metallic: Float(0.0), "metallic", from [metallic], to [metallic], image;
        roughness: Float(0.5), "roughness", from [roughness], to [roughness], image;
        clearcoat: Float(0.0), "clearcoat", from [coat], to [coat, coat_ior], image;
        clearcoat_roughness: Float(0.01), "clearcoatRoughness", from [coat_roughness], to [coat_roughness], image;
        opacity: Float(1.0), "opacity", from [opacity, metallic, translucency], to [opacity], image;
        opacity_threshold: Float(0.0), "opacityThreshold", from [], to [opacity], uniform;
        ior: Float(1.5), "ior", from [specular_ior, specular_level], to [specular_ior, specular_level], uniform;
        normal: Normal([0.0, 0.0, 1.0]), "normal", from [normal], to [normal], image;
        /// Some writers put it into the scale and bias of the normal map. Checkers of USD accept no other than 2 and -1, so it is only read.
        normal_scale: Float(1.0), "normal.scale", from [], to [normal_scale], uniform;
        displacement: Float(0.0), "displacement", from [height, height_level, height_scale], to [height, height_level, height_scale], image;
        occlusion: Float(1.0), "occlusion", from [ambient_occlusion], to [ambient_occlusion], image;
    }
}

/// UsdPreviewSurface.
pub const MODEL: ShadingModel = ShadingModel {
    name: "usd_preview_surface",
    label: "USD Preview Surface",
    fields: UsdPreview::FIELDS,
    cells: CELLS,
    translate: |inputs, context| translate(inputs, context).to_values(),
    interpret: |values, context, notes| interpret(&UsdPreview::from_values(values), context, notes),
};

/// What a material becomes.
pub fn translate(i: &Inputs<f64>, _: &Context) -> UsdPreview {
    UsdPreview {
        diffuse_color: i.base_color,
        emissive_color: i.emission_color.map(|c| i.emission * c),
        use_specular: false,
        specular_color: [0.0; 3],
        metallic: i.metallic,
        roughness: i.roughness,
        clearcoat: i.coat,
        clearcoat_roughness: i.coat_roughness,
        opacity: i.opacity * (1.0 - (1.0 - i.metallic) * i.translucency),
        opacity_threshold: 0.0,
        ior: f::fold_level(i.specular_ior, i.specular_level),
        normal: i.normal,
        normal_scale: 1.0,
        displacement: (i.height - i.height_level) * i.height_scale,
        occlusion: i.ambient_occlusion,
    }
}

/// What these parameters mean.
pub fn interpret(p: &UsdPreview, _: &Context, notes: &mut Notes) -> Inputs<f64> {
    let mut i = default_inputs();
    i.base_color = p.diffuse_color.map(|c| unit("diffuseColor", c, notes));
    (i.emission, i.emission_color) = emission(p.emissive_color);
    i.specular_ior = p.ior.max(1.0);
    i.metallic = unit("metallic", p.metallic, notes);
    if p.use_specular {
        i.metallic = 0.0;
        let f0 = p.specular_color.map(|c| unit("specularColor", c, notes));
        (i.specular_ior, i.specular_level, i.specular_edge_color) = f::dielectric_of_f0(f0);
    }
    i.roughness = unit("roughness", p.roughness, notes);
    i.coat = unit("clearcoat", p.clearcoat, notes);
    if i.coat > 0.0 {
        i.coat_ior = COAT_IOR;
    }
    i.coat_roughness = unit("clearcoatRoughness", p.clearcoat_roughness, notes);
    i.opacity = unit("opacity", p.opacity, notes);
    if p.opacity_threshold > 0.0 {
        i.opacity = if i.opacity >= p.opacity_threshold { 1.0 } else { 0.0 };
        notes.push("opacity: cut off at a threshold there; a value is cut off here too, an image is taken as it is".to_owned());
    }
    (i.normal, i.normal_scale) = (p.normal, p.normal_scale);
    i.height = p.displacement + i.height_level;
    i.ambient_occlusion = unit("occlusion", p.occlusion, notes);
    i
}

const CELLS: &[Cell] = &[
    Cell::exact(Property::base_color, "diffuseColor"),
    Cell::exact(Property::roughness, "roughness"),
    Cell::exact(Property::metallic, "metallic"),
    Cell {
        property: Property::opacity,
        target: "opacity",
        fate: |i| match is_clear(i) {
            false => (Fate::Exact, ""),
            true => (Fate::Approximated, "with the translucency in it"),
        },
    },
    Cell { property: Property::specular_level, target: "ior", fate: level },
    Cell::dropped(Property::specular_edge_color),
    Cell::exact(Property::normal, "normal"),
    Cell::dropped(Property::normal_scale),
    Cell::dropped(Property::combine_normal_and_height),
    Cell { property: Property::height, target: "displacement", fate: fates::displacement },
    Cell { property: Property::height_scale, target: "displacement", fate: fates::displacement },
    Cell { property: Property::height_level, target: "displacement", fate: fates::displacement },
    Cell::dropped(Property::anisotropy),
    Cell::dropped(Property::anisotropy_rotation),
    Cell { property: Property::emission, target: "emissiveColor", fate: fates::emission },
    Cell { property: Property::emission_color, target: "emissiveColor", fate: fates::emission },
    Cell::dropped(Property::sheen),
    Cell::dropped(Property::sheen_color),
    Cell::dropped(Property::sheen_roughness),
    Cell {
        property: Property::translucency,
        target: "opacity",
        fate: |i| match i.translucency {
            0.0 => (Fate::Exact, ""),
            _ => (Fate::Approximated, "seen through as if cut out, without refraction"),
        },
    },
    Cell { property: Property::specular_ior, target: "ior", fate: level },
    Cell::dropped(Property::dispersion),
    Cell::dropped(Property::absorption_color),
    Cell::dropped(Property::absorption_distance),
    Cell::dropped(Property::scatter),
    Cell::dropped(Property::scatter_color),
    Cell::dropped(Property::scatter_distance),
    Cell::dropped(Property::scatter_distance_scale),
    Cell::dropped(Property::scatter_red_shift),
    Cell::dropped(Property::scatter_rayleigh),
    Cell::exact(Property::coat, "clearcoat"),
    Cell::dropped(Property::coat_color),
    Cell::exact(Property::coat_roughness, "clearcoatRoughness"),
    Cell { property: Property::coat_ior, target: "clearcoat", fate: fates::fixed_coat_ior },
    Cell::dropped(Property::coat_specular_level),
    Cell::dropped(Property::coat_normal),
    Cell::dropped(Property::coat_normal_scale),
    Cell::exact(Property::ambient_occlusion, "occlusion"),
    Cell::dropped(Property::volume_thickness),
    Cell::dropped(Property::volume_thickness_scale),
];

fn is_clear(i: &Inputs<f64>) -> bool {
    i.translucency > 0.0 && i.metallic < 1.0
}

fn level(i: &Inputs<f64>) -> (Fate, &'static str) {
    if i.specular_level == 0.5 {
        (Fate::Exact, "")
    } else {
        (Fate::Approximated, "the level became part of the index of refraction")
    }
}
