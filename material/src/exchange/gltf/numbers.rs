//! The numbers of a material on the way out: which are written, and which extensions that takes.

use serde_json::{Map, Value as Json, json};

use super::draft::Draft;
use super::json::put;
use super::slots::{self, is_number};
use crate::exchange::models::gltf::{Gltf, THIN, width};
use crate::exchange::native::value_json;
use crate::properties::Property;
use crate::value::Value;

/// Writes every number that differs from the format's default, as far as it means anything there.
pub(super) fn write(draft: &Draft, material: &mut Map<String, Json>) {
    let (color, alpha) = (draft.value(slots::BASE_COLOR), draft.float(slots::ALPHA));
    if let Value::Color([r, g, b]) = color
        && [r, g, b, alpha] != [1.0; 4]
    {
        put(material, slots::BASE_COLOR, json!([r, g, b, alpha]));
    }
    let has_volume = has_volume(draft);
    let has_coat = has_coat(draft);
    for (def, field) in Gltf::FIELDS.iter().zip(&draft.fields).filter(|(def, _)| is_number(def)) {
        let value = match def.name {
            slots::THICKNESS_FACTOR => Value::Float(thickness(draft)),
            _ => field.value,
        };
        let extension = def.name.split('.').next().unwrap_or_default();
        let is_wanted = match extension {
            _ if def.name == slots::METALLIC || def.name == slots::ROUGHNESS => true,
            _ if value == def.default => false,
            "KHR_materials_volume" => {
                has_volume && (draft.float(slots::ATTENUATION) > 0.0 || def.name == slots::THICKNESS_FACTOR)
            }
            "KHR_materials_sheen" => has_sheen(draft),
            "ADOBE_materials_clearcoat_specular" => has_coat,
            "KHR_materials_diffuse_transmission" => is_there(draft, slots::DIFFUSE),
            "normalTexture" => draft.has_image("normalTexture"),
            _ if def.name.ends_with("NormalTexture.scale") => draft.has_image(def.name.trim_end_matches(".scale")),
            _ => true,
        };
        if is_wanted {
            put(material, def.name, value_json(value));
        }
    }
    if has_volume && !is_there(draft, slots::TRANSMISSION) && !is_there(draft, slots::DIFFUSE) {
        put(material, slots::TRANSMISSION, json!(0.0));
    }
}

/// Puts in what the extensions of a material need beside them. After the images.
pub(super) fn complete(material: &mut Map<String, Json>) {
    let needs_coat = |name: &String| name.starts_with("ADOBE_materials_clearcoat_");
    let extensions = material.get("extensions").and_then(Json::as_object);
    if extensions.is_some_and(|all| all.keys().any(needs_coat) && !all.contains_key("KHR_materials_clearcoat")) {
        put(material, slots::COAT, json!(0.0));
    }
}

/// Whether there is any of a parameter: an image, or a value above 0.
fn is_there(draft: &Draft, name: &str) -> bool {
    draft.has_image(name) || draft.value(name).numbers().iter().any(|x| *x != 0.0)
}

/// Whether the body says more than that it is opaque.
fn has_volume(draft: &Draft) -> bool {
    let is_plain = [0.0, width(&draft.part.context)].contains(&thickness(draft));
    let names = [slots::TRANSMISSION, slots::DIFFUSE, slots::ATTENUATION, slots::DISPERSION];
    names.iter().any(|name| is_there(draft, name)) || draft.has_image(slots::THICKNESS) || !is_plain
}

/// The factor of thickness, with the uniform part of the thickness in it. Never 0, which would be a wall without a body.
fn thickness(draft: &Draft) -> f64 {
    let (factor, share) = (draft.float(slots::THICKNESS_FACTOR), draft.float(slots::THICKNESS));
    if share > 0.0 { factor * share } else { factor * THIN }
}

/// Whether the sheen says anything: amount and colour, or a roughness other than ASM's default.
fn has_sheen(draft: &Draft) -> bool {
    is_there(draft, slots::SHEEN)
        || draft.has_image(slots::SHEEN_ROUGHNESS)
        || draft.value(slots::SHEEN_ROUGHNESS) != Property::sheen_roughness.def().default
}

/// Whether the coat says anything: any parameter of it, or an index other than ASM's default.
fn has_coat(draft: &Draft) -> bool {
    let is_of = |name: &str| name.contains("_materials_clearcoat") && name != slots::COAT_IOR;
    let pairs = Gltf::FIELDS.iter().zip(&draft.fields);
    let says = pairs
        .filter(|(def, _)| is_of(def.name))
        .any(|(def, field)| draft.has_image(def.name) || (field.value != def.default && !def.name.ends_with(".scale")));
    says || draft.value(slots::COAT_IOR) != Property::coat_ior.def().default
}
