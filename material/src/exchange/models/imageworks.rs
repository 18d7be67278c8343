//! The physically based shading model of Sony Pictures Imageworks, as far as it is public (Kulla and Conty, Revisiting Physically Based Shading
//! at Imageworks, 2017): a table of what would hold each property.
//!
//! The talk gives formulas for single parts, not the parameters of the shader or files of them, so nothing is translated. Of its formulas ASM's
//! own relatives use three: the widths `(1 ± anisotropy) roughness²` ([`crate::exchange::formulas::balanced_roughness`]), the albedo behind the
//! colour of a scattering body ([`crate::exchange::formulas::single_scattering_albedo`]), and the lobe of the sheen. Names are descriptions.

use super::super::loss::{Cell, Fate};
use crate::properties::{Inputs, Property};

/// Name for the user.
pub const LABEL: &str = "Imageworks";

/// How the model would hold each property.
pub const CELLS: &[Cell] = &[
    Cell { property: Property::base_color, target: "base colour", fate: alike },
    Cell { property: Property::roughness, target: "roughness", fate: alike },
    Cell { property: Property::metallic, target: "metalness", fate: alike },
    Cell::dropped(Property::opacity),
    Cell::dropped(Property::specular_level),
    Cell { property: Property::specular_edge_color, target: "edge tint", fate: edge },
    Cell::dropped(Property::normal),
    Cell::dropped(Property::normal_scale),
    Cell::dropped(Property::combine_normal_and_height),
    Cell::dropped(Property::height),
    Cell::dropped(Property::height_scale),
    Cell::dropped(Property::height_level),
    Cell { property: Property::anisotropy, target: "anisotropy", fate: alike },
    Cell { property: Property::anisotropy_rotation, target: "anisotropy direction", fate: alike },
    Cell::dropped(Property::emission),
    Cell::dropped(Property::emission_color),
    Cell { property: Property::sheen, target: "sheen weight", fate: alike },
    Cell { property: Property::sheen_color, target: "sheen colour", fate: alike },
    Cell { property: Property::sheen_roughness, target: "sheen roughness", fate: alike },
    Cell { property: Property::translucency, target: "refraction weight", fate: alike },
    Cell { property: Property::specular_ior, target: "index of refraction", fate: alike },
    Cell::dropped(Property::dispersion),
    Cell { property: Property::absorption_color, target: "refraction colour", fate: alike },
    Cell { property: Property::absorption_distance, target: "refraction colour at depth", fate: alike },
    Cell { property: Property::scatter, target: "subsurface weight", fate: alike },
    Cell { property: Property::scatter_color, target: "subsurface colour", fate: alike },
    Cell { property: Property::scatter_distance, target: "subsurface mean free path", fate: alike },
    Cell::dropped(Property::scatter_distance_scale),
    Cell::dropped(Property::scatter_red_shift),
    Cell::dropped(Property::scatter_rayleigh),
    Cell { property: Property::coat, target: "coat weight", fate: alike },
    Cell::dropped(Property::coat_color),
    Cell { property: Property::coat_roughness, target: "coat roughness", fate: alike },
    Cell::dropped(Property::coat_ior),
    Cell::dropped(Property::coat_specular_level),
    Cell::dropped(Property::coat_normal),
    Cell::dropped(Property::coat_normal_scale),
    Cell::dropped(Property::ambient_occlusion),
    Cell::dropped(Property::volume_thickness),
    Cell::dropped(Property::volume_thickness_scale),
];

fn alike(_: &Inputs<f64>) -> (Fate, &'static str) {
    (Fate::Approximated, "a part of the same meaning is described; its parameters are not published")
}

fn edge(_: &Inputs<f64>) -> (Fate, &'static str) {
    (Fate::Approximated, "tints the edge of metal by another formula")
}
