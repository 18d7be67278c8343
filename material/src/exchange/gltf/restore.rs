//! A translation as it is written where the material came from glTF: what it said there stands again.

use std::collections::BTreeMap;

use serde_json::Value as Json;

use super::foreign;
use super::slots::{ALPHA, BASE_COLOR, EMISSIVE, METALLIC, ROUGHNESS, field};
use super::write::Part;
use crate::exchange::field::Field;
use crate::exchange::models::gltf::Gltf;
use crate::properties::Property;
use crate::value::Value;

const UNLIT: &str = "KHR_materials_unlit";

/// A material's translation, and what stands beside it.
pub(super) struct Restored {
    /// Parameters, and the properties that those without an image of their own are made of, by place.
    pub content: (Vec<Field>, BTreeMap<usize, Vec<Property>>),
    /// The mask that the opacity was read from.
    pub mask: Option<Json>,
    /// Extensions and keys that go out as they came.
    pub kept: BTreeMap<String, Json>,
}

impl Restored {
    pub fn of(part: &Part) -> Self {
        let mut kept = foreign::unchanged(part.material);
        let mut fields = part.translation.fields.0.clone();
        let mut computed: BTreeMap<usize, Vec<Property>> =
            part.translation.images.iter().map(|image| (image.field, image.from.clone())).collect();
        let place = |name: &str| field(name).map_or(usize::MAX, |(place, _)| place);
        let mask = kept.remove("alphaMode");
        if let Some(mask) = &mask {
            unmask(fields.get_mut(place(ALPHA)), mask);
        }
        if computed.contains_key(&place(EMISSIVE)) {
            // Its image would have to be made of the light that it gives; lit, it looks the same.
            kept.remove(UNLIT);
        }
        let is_unlit = kept.contains_key(UNLIT);
        let emissive = fields.get(place(EMISSIVE)).cloned();
        for (k, (field, def)) in fields.iter_mut().zip(Gltf::FIELDS).enumerate() {
            let extension = def.name.split('.').next().unwrap_or_default();
            let stays = [ALPHA, METALLIC, ROUGHNESS].contains(&def.name);
            if kept.contains_key(extension) || (is_unlit && !stays) {
                *field = Field { value: def.default, texture: None, is_authored: false };
                computed.remove(&k);
            }
        }
        if let (true, Some(base), Some(emissive)) = (is_unlit, fields.get_mut(place(BASE_COLOR)), emissive) {
            *base = emissive;
        }
        Self { content: (fields, computed), mask, kept }
    }
}

/// The opacity that a mask was read from, in place of the mask.
fn unmask(alpha: Option<&mut Field>, mask: &Json) {
    let factor = mask.get("alphaFactor").and_then(Json::as_f64).unwrap_or(1.0);
    let Some(alpha) = alpha else { return };
    alpha.value = Value::Float(factor);
    if let Some(texture) = &mut alpha.texture {
        (texture.scale, texture.bias) = ([factor; 3], [0.0; 3]);
    }
}
