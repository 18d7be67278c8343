//! How glTF holds each property, and what it cannot say.

use crate::exchange::formulas as f;
use crate::exchange::loss::{Cell, Fate};
use crate::properties::{Inputs, Property};

pub(super) const CELLS: &[Cell] = &[
    Cell {
        property: Property::base_color,
        target: "baseColorFactor",
        fate: |i| match i.scatter || i.translucency == 0.0 || i.metallic == 1.0 {
            true => (Fate::Exact, ""),
            false => (Fate::Approximated, "mixed with the colour of transmitted light, which glTF tints with it"),
        },
    },
    Cell::exact(Property::roughness, "roughnessFactor"),
    Cell::exact(Property::metallic, "metallicFactor"),
    Cell::exact(Property::opacity, "baseColorFactor alpha"),
    Cell { property: Property::specular_level, target: "specularFactor", fate: specular_level },
    Cell { property: Property::specular_edge_color, target: "specularColorFactor", fate: specular },
    Cell::exact(Property::normal, "normalTexture"),
    Cell { property: Property::normal_scale, target: "normalTexture.scale", fate: |i| normal_scale(i.normal_scale) },
    Cell::dropped(Property::combine_normal_and_height),
    Cell::dropped(Property::height),
    Cell::dropped(Property::height_scale),
    Cell::dropped(Property::height_level),
    Cell {
        property: Property::anisotropy,
        target: "anisotropyStrength",
        fate: |i| match i.anisotropy {
            0.0 => (Fate::Exact, ""),
            a if i.roughness * i.roughness + a.powi(4) <= 1.0 => (Fate::Remapped, "another measure of the same two widths"),
            _ => (Fate::Approximated, "the lobe is as wide as it can be; how much further was asked for is lost"),
        },
    },
    Cell { property: Property::anisotropy_rotation, target: "anisotropyRotation", fate: |_| (Fate::Remapped, "in radians") },
    Cell { property: Property::emission, target: "emissiveStrength", fate: |_| (Fate::Exact, "") },
    Cell { property: Property::emission_color, target: "emissiveFactor", fate: |_| (Fate::Exact, "") },
    Cell { property: Property::sheen, target: "sheenColorFactor", fate: sheen_product },
    Cell { property: Property::sheen_color, target: "sheenColorFactor", fate: sheen_product },
    Cell {
        property: Property::sheen_roughness,
        target: "sheenRoughnessFactor",
        fate: |i| match i.sheen {
            0.0 => (Fate::Exact, ""),
            _ => (Fate::Approximated, "another lobe with the same number"),
        },
    },
    Cell {
        property: Property::translucency,
        target: "transmissionFactor, diffuseTransmissionFactor",
        fate: |i| match i.scatter && i.translucency > 0.0 {
            true => (Fate::Approximated, "the body scatters: written as diffuse transmission"),
            false => (Fate::Exact, ""),
        },
    },
    Cell::exact(Property::specular_ior, "ior"),
    Cell::exact(Property::dispersion, "dispersion"),
    Cell { property: Property::absorption_color, target: "attenuationColor", fate: absorption },
    Cell { property: Property::absorption_distance, target: "attenuationDistance", fate: absorption },
    Cell {
        property: Property::scatter,
        target: "diffuseTransmissionFactor",
        fate: |i| match i.translucency {
            0.0 if i.scatter => (Fate::Dropped, "scattering without translucency has no factor to stand in"),
            _ if i.scatter => (Fate::Remapped, "as diffuse transmission"),
            _ => (Fate::Exact, ""),
        },
    },
    Cell { property: Property::scatter_color, target: "diffuseTransmissionColorFactor", fate: scattering },
    Cell { property: Property::scatter_distance, target: "attenuationDistance", fate: scattering },
    Cell { property: Property::scatter_distance_scale, target: "attenuationColor", fate: scattering },
    Cell { property: Property::scatter_red_shift, target: "attenuationColor", fate: scattering },
    Cell { property: Property::scatter_rayleigh, target: "attenuationColor", fate: scattering },
    Cell::exact(Property::coat, "clearcoatFactor"),
    Cell::exact(Property::coat_color, "clearcoatTintFactor"),
    Cell::exact(Property::coat_roughness, "clearcoatRoughnessFactor"),
    Cell { property: Property::coat_ior, target: "clearcoatIor", fate: coat_level },
    Cell { property: Property::coat_specular_level, target: "clearcoatSpecularFactor", fate: coat_level },
    Cell::exact(Property::coat_normal, "clearcoatNormalTexture"),
    Cell {
        property: Property::coat_normal_scale,
        target: "clearcoatNormalTexture.scale",
        fate: |i| normal_scale(i.coat_normal_scale),
    },
    Cell {
        property: Property::ambient_occlusion,
        target: "occlusionTexture",
        fate: |i| match i.ambient_occlusion {
            1.0 => (Fate::Exact, ""),
            _ => (Fate::Approximated, "as an image of one texel, in steps of 1/255"),
        },
    },
    Cell { property: Property::volume_thickness, target: "thicknessFactor", fate: thickness },
    Cell { property: Property::volume_thickness_scale, target: "thicknessFactor", fate: thickness },
];

pub(in crate::exchange) fn specular(i: &Inputs<f64>) -> (Fate, &'static str) {
    match (i.specular_level, i.specular_edge_color) {
        (0.5, [1.0, 1.0, 1.0]) => (Fate::Exact, ""),
        _ => (Fate::Approximated, "towards grazing angles glTF scales the reflection and does not tint it; metal keeps its own"),
    }
}

fn specular_level(i: &Inputs<f64>) -> (Fate, &'static str) {
    let share = f::share_under_coat(i.specular_ior.max(1.0), super::clearcoat_ior(i), i.coat);
    match specular(i) {
        _ if share <= super::NO_REFLECTION => (Fate::Approximated, "the coat leaves nothing of the reflection under it"),
        (Fate::Exact, _) if share != 1.0 => (Fate::Remapped, "what the coat leaves of it, since glTF's coat leaves everything"),
        fate => fate,
    }
}

fn normal_scale(scale: f64) -> (Fate, &'static str) {
    match scale {
        1.0 => (Fate::Exact, ""),
        s if s > 1.0 => (Fate::Approximated, "stands beside a normal map alone"),
        _ => (Fate::Approximated, "stands beside a normal map alone; below 1 ASM scales the angle, glTF the slope"),
    }
}

fn sheen_product(i: &Inputs<f64>) -> (Fate, &'static str) {
    match i.sheen {
        0.0 => (Fate::Dropped, "without sheen there is no colour to write"),
        _ => (Fate::Approximated, "only the product of amount and colour is kept, and the lobe is another"),
    }
}

fn absorption(i: &Inputs<f64>) -> (Fate, &'static str) {
    if i.scatter {
        (Fate::Approximated, "folded into the extinction of the scattering body")
    } else if i.absorption_distance > 0.0 || i.absorption_color == [1.0; 3] {
        (Fate::Exact, "")
    } else if i.translucency == 0.0 {
        (Fate::Dropped, "without translucency and distance there is nothing to write it to")
    } else {
        (Fate::Approximated, "mixed into the base colour, which tints transmitted light there")
    }
}

fn scattering(i: &Inputs<f64>) -> (Fate, &'static str) {
    match i.scatter && i.translucency > 0.0 {
        true => (Fate::Approximated, "diffuse transmission and an extinction, without scattering in between"),
        false => (Fate::Dropped, "nothing scatters, so nothing is written"),
    }
}

fn coat_level(i: &Inputs<f64>) -> (Fate, &'static str) {
    if i.coat_specular_level <= 0.5 {
        (Fate::Exact, "")
    } else {
        (Fate::Approximated, "the level became part of the index of refraction")
    }
}

fn thickness(i: &Inputs<f64>) -> (Fate, &'static str) {
    match i.volume_thickness {
        1.0 => (Fate::Exact, ""),
        _ => (Fate::Approximated, "only the product of thickness and scale is kept"),
    }
}
