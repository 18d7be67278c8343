//! The specular/glossiness workflow, as `KHR_materials_pbrSpecularGlossiness` (Khronos, archived) defines it: the reflection at normal incidence
//! is given as a colour, and there is no metal. Beside the three parameters stand the maps that go with every workflow of texture sets.
//!
//! A metal is a surface without diffuse reflection whose specular colour is bright. On the way back it stays a dielectric that reflects as
//! much, since nothing tells them apart.

use super::super::formulas as f;
use super::super::loss::{Cell, Fate};
use super::super::model::{Context, Notes, ShadingModel};
use super::fates;
use crate::exchange::interpreting::{default_inputs, emission, unit};
use crate::properties::{Inputs, Property};

crate::shading_fields! {
    /// Parameters of the specular/glossiness workflow.
    SpecularGlossiness {
        diffuse: Color([1.0; 3]), "diffuse", from [base_color, metallic, specular_level, specular_ior, specular_edge_color], to [base_color], image;
        specular: Color([1.0; 3]), "specular", from [base_color, metallic, specular_level, specular_ior, specular_edge_color], to [specular_level, specular_ior, specular_edge_color], image;
        glossiness: Float(1.0), "glossiness", from [roughness], to [roughness], image;
        opacity: Float(1.0), "opacity", from [opacity], to [opacity], image;
        normal: Normal([0.0, 0.0, 1.0]), "normal", from [normal], to [normal], image;
        emissive: Color([0.0; 3]), "emissive", from [emission, emission_color], to [emission, emission_color], image;
        occlusion: Float(1.0), "ambientOcclusion", from [ambient_occlusion], to [ambient_occlusion], image;
        height: Float(0.5), "height", from [height], to [height], image;
    }
}

/// Specular/Glossiness.
pub const MODEL: ShadingModel = ShadingModel {
    name: "specular_glossiness",
    label: "Specular/Glossiness",
    fields: SpecularGlossiness::FIELDS,
    cells: CELLS,
    translate: |inputs, context| translate(inputs, context).to_values(),
    interpret: |values, context, notes| interpret(&SpecularGlossiness::from_values(values), context, notes),
};

/// What a material becomes.
pub fn translate(i: &Inputs<f64>, _: &Context) -> SpecularGlossiness {
    let amount = (2.0 * i.specular_level * f::f0_of_ior(i.specular_ior)).min(1.0);
    let dielectric = i.specular_edge_color.map(|c| amount * c);
    let specular = f::mix(dielectric, i.base_color, i.metallic);
    // The workflow takes the largest specular number off the diffuse colour, ASM that of the dielectric alone.
    let (left, taken) = (1.0 - f::largest(dielectric), 1.0 - f::largest(specular));
    let diffuse = match i.metallic {
        0.0 => 1.0,
        metallic if taken > 0.0 => ((1.0 - metallic) * left / taken).min(1.0),
        _ => 0.0,
    };
    SpecularGlossiness {
        diffuse: i.base_color.map(|c| diffuse * c),
        specular,
        glossiness: glossiness(i.roughness),
        opacity: i.opacity,
        normal: i.normal,
        emissive: i.emission_color.map(|c| i.emission * c),
        occlusion: i.ambient_occlusion,
        height: i.height,
    }
}

/// Glossiness of a roughness, and the other way round.
pub fn glossiness(roughness: f64) -> f64 {
    1.0 - roughness
}

/// What these parameters mean.
pub fn interpret(p: &SpecularGlossiness, _: &Context, notes: &mut Notes) -> Inputs<f64> {
    let mut i = default_inputs();
    i.base_color = p.diffuse.map(|c| unit("diffuse", c, notes));
    let specular = p.specular.map(|c| unit("specular", c, notes));
    (i.specular_ior, i.specular_level, i.specular_edge_color) = f::dielectric_of_f0(specular);
    i.roughness = glossiness(unit("glossiness", p.glossiness, notes));
    i.opacity = unit("opacity", p.opacity, notes);
    i.normal = p.normal;
    (i.emission, i.emission_color) = emission(p.emissive);
    i.ambient_occlusion = unit("ambientOcclusion", p.occlusion, notes);
    i.height = p.height;
    i
}

const CELLS: &[Cell] = &[
    Cell { property: Property::base_color, target: "diffuse, specular", fate: base },
    Cell { property: Property::roughness, target: "glossiness", fate: |_| (Fate::Remapped, "as its opposite") },
    Cell {
        property: Property::metallic,
        target: "diffuse, specular",
        fate: |i| match i.metallic {
            0.0 => (Fate::Exact, ""),
            _ => (Fate::Approximated, "metal is a bright specular colour; it comes back as a dielectric that reflects as much"),
        },
    },
    Cell::exact(Property::opacity, "opacity"),
    Cell { property: Property::specular_level, target: "specular", fate: reflection },
    Cell { property: Property::specular_edge_color, target: "specular", fate: reflection },
    Cell::exact(Property::normal, "normal"),
    Cell::dropped(Property::normal_scale),
    Cell::dropped(Property::combine_normal_and_height),
    Cell::exact(Property::height, "height"),
    Cell::dropped(Property::height_scale),
    Cell::dropped(Property::height_level),
    Cell::dropped(Property::anisotropy),
    Cell::dropped(Property::anisotropy_rotation),
    Cell { property: Property::emission, target: "emissive", fate: fates::emission },
    Cell { property: Property::emission_color, target: "emissive", fate: fates::emission },
    Cell::dropped(Property::sheen),
    Cell::dropped(Property::sheen_color),
    Cell::dropped(Property::sheen_roughness),
    Cell::dropped(Property::translucency),
    Cell { property: Property::specular_ior, target: "specular", fate: reflection },
    Cell::dropped(Property::dispersion),
    Cell::dropped(Property::absorption_color),
    Cell::dropped(Property::absorption_distance),
    Cell::dropped(Property::scatter),
    Cell::dropped(Property::scatter_color),
    Cell::dropped(Property::scatter_distance),
    Cell::dropped(Property::scatter_distance_scale),
    Cell::dropped(Property::scatter_red_shift),
    Cell::dropped(Property::scatter_rayleigh),
    Cell::dropped(Property::coat),
    Cell::dropped(Property::coat_color),
    Cell::dropped(Property::coat_roughness),
    Cell::dropped(Property::coat_ior),
    Cell::dropped(Property::coat_specular_level),
    Cell::dropped(Property::coat_normal),
    Cell::dropped(Property::coat_normal_scale),
    Cell::exact(Property::ambient_occlusion, "ambientOcclusion"),
    Cell::dropped(Property::volume_thickness),
    Cell::dropped(Property::volume_thickness_scale),
];

fn base(i: &Inputs<f64>) -> (Fate, &'static str) {
    if i.metallic == 0.0 { (Fate::Exact, "") } else { (Fate::Approximated, "the colour of metal is a specular colour") }
}

fn reflection(i: &Inputs<f64>) -> (Fate, &'static str) {
    match i.metallic {
        0.0 => (Fate::Remapped, "as the colour of the reflection"),
        _ => (Fate::Approximated, "mixed with that of metal in the colour of the reflection"),
    }
}
