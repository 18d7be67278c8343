//! `KHR_materials_pbrSpecularGlossiness`, the archived extension, as the parameters that took its place.
//!
//! Its specular colour is the reflection itself: an index of refraction of 0 says so in the newer extensions.

use serde_json::Value as Json;

use super::json::at;
use super::material::Reader;
use super::slots::{ALPHA, BASE_COLOR, IOR, METALLIC, ROUGHNESS, SPECULAR_COLOR};
use crate::exchange::models::specular_glossiness::{SpecularGlossiness, glossiness};
use crate::exchange::native::read_value;
use crate::slot::{Channel, ColorSpace, TextureRef};
use crate::value::Value;

const NAME: &str = "KHR_materials_pbrSpecularGlossiness";

/// Reads the extension, where the file does not say the same by metallic and roughness.
pub(super) fn read(reader: &mut Reader) {
    let Some(json) = at(reader.json, NAME) else { return };
    if says_metallic_roughness(reader.json) {
        return reader.notes.push(format!("{}: {NAME} is not read beside metallic and roughness", reader.place));
    }
    reader.say(BASE_COLOR, Value::Color([1.0; 3]));
    reader.base_color(&format!("{NAME}.diffuseFactor"));
    let mut number = |parameter: &str| {
        let (key, name) = (format!("{parameter}Factor"), format!("{NAME}.{parameter}Factor"));
        let default =
            SpecularGlossiness::FIELDS.iter().find(|def| def.name == parameter).map_or(Value::Float(1.0), |def| def.default);
        let kind = default.kind();
        json.get(&key).map_or(default, |json| {
            read_value(kind, json).unwrap_or_else(|| {
                reader.wrong(&name, kind.expectation());
                default
            })
        })
    };
    let specular = number("specular");
    let gloss = number("glossiness").numbers().first().copied().unwrap_or(1.0);
    reader.say(METALLIC, Value::Float(0.0));
    reader.say(IOR, Value::Float(0.0));
    reader.say(SPECULAR_COLOR, specular);
    reader.say(ROUGHNESS, Value::Float(glossiness(gloss)));
    if let Some(image) = reader.image(&format!("{NAME}.diffuseTexture")) {
        let (color, alpha) = (reader.value(BASE_COLOR), reader.value(ALPHA));
        let scale = |value: Value| match value {
            Value::Color(v) => v,
            value => [value.numbers().first().copied().unwrap_or(1.0); 3],
        };
        let rgb = TextureRef { color_space: ColorSpace::Srgb, scale: scale(color), ..image.clone() };
        reader.bind(BASE_COLOR, color, rgb);
        reader.bind(ALPHA, alpha, TextureRef { channel: Channel::A, scale: scale(alpha), ..image });
    }
    if let Some(image) = reader.image(&format!("{NAME}.specularGlossinessTexture")) {
        let rough = TextureRef { channel: Channel::A, scale: [-gloss; 3], bias: [1.0; 3], ..image };
        reader.bind(ROUGHNESS, Value::Float(glossiness(gloss)), rough);
        reader
            .notes
            .push(format!("{}: the specular colours in the image of {NAME} are not read; its factor holds", reader.place));
    }
}

/// Whether the core of the material says anything but its defaults.
fn says_metallic_roughness(material: &Json) -> bool {
    let core = material.get("pbrMetallicRoughness").and_then(Json::as_object);
    core.into_iter().flatten().any(|(key, value)| match key.as_str() {
        "baseColorFactor" => *value != serde_json::json!([1, 1, 1, 1]) && *value != serde_json::json!([1.0, 1.0, 1.0, 1.0]),
        "metallicFactor" | "roughnessFactor" => value.as_f64() != Some(1.0),
        "baseColorTexture" | "metallicRoughnessTexture" => true,
        _ => false,
    })
}
