//! The native copy: everything that a material holds, as JSON for the places that formats reserve for such data.
//!
//! Numbers are the shortest decimals that read back as the same bits. What stands at its default and was never said stays unsaid.

use serde_json::{Map, Value as Json, json};

use super::field::{FieldDef, Fields};
use super::model::Notes;
use super::short::short;
use crate::file::ASM_VERSION;
use crate::foreign::ForeignError;
use crate::material::{Material, Provenance};
use crate::properties::Property;
use crate::slot::{Channel, ColorSpace, TextureRef, Wrap};
use crate::value::{Kind, Value};

/// Most sentences; a file may hold millions of wrong entries.
const MAX_NOTES: usize = 500;

/// A native copy as a file holds it.
#[derive(Clone, Debug)]
pub struct Native {
    /// The material.
    pub material: Material,
    /// What the translation said when it was written, if the copy says so.
    pub translation: Option<Fields>,
}

/// The JSON of a material, with what its translation says beside it where the format needs that.
pub fn write(material: &Material, translation: Option<(&[FieldDef], &Fields)>) -> Json {
    let mut all = Map::new();
    all.insert("version".to_owned(), json!(ASM_VERSION));
    let mut text = |key: &str, text: &str| {
        if !text.is_empty() {
            all.insert(key.to_owned(), json!(text));
        }
    };
    text("name", &material.name);
    text("notes", &material.notes);
    let Provenance { source, reference, method, licence } = &material.provenance;
    for (key, value) in [("source", source), ("reference", reference), ("method", method), ("licence", licence)]
        .map(|(k, v)| (format!("provenance.{k}"), v))
    {
        text(&key, value);
    }
    for (key, words) in [("aliases", &material.aliases), ("tags", &material.tags)] {
        if !words.is_empty() {
            all.insert(key.to_owned(), json!(words));
        }
    }
    if let Some(unit) = material.unit_mm {
        all.insert("unit_mm".to_owned(), json!(unit));
    }
    let (mut properties, mut textures) = (Map::new(), Map::new());
    for (property, slot) in material.slots() {
        if let Some(value) = slot.value {
            properties.insert(property.def().name.to_owned(), value_json(value));
        }
        if let Some(texture) = &slot.texture {
            textures.insert(property.def().name.to_owned(), texture_json(texture));
        }
    }
    all.insert("properties".to_owned(), Json::Object(properties));
    if !textures.is_empty() {
        all.insert("textures".to_owned(), Json::Object(textures));
    }
    if !material.foreign.is_empty() {
        all.insert("foreign".to_owned(), json!(material.foreign));
    }
    if let Some((table, fields)) = translation {
        all.insert("translation".to_owned(), fields_json(table, fields));
    }
    Json::Object(all)
}

/// Reads a native copy. `None`, with a note, where it is of another major version or no native copy at all; a value that is wrong costs a
/// note and is left out, so that the translation decides about it.
pub fn read(json: &Json, table: Option<&[FieldDef]>, notes: &mut Notes) -> Option<Native> {
    let version = json.get("version").and_then(Json::as_str).unwrap_or_default();
    if version.split('.').next() != ASM_VERSION.split('.').next() {
        notes.push(format!(
            "the native copy is of version `{}`, expected {ASM_VERSION}: the translation is read instead",
            short(version)
        ));
        return None;
    }
    let Some(properties) = json.get("properties").and_then(Json::as_object) else {
        notes.push("the native copy has no properties: the translation is read instead".to_owned());
        return None;
    };
    let mut material = Material::default();
    let text = |key: &str| json.get(key).and_then(Json::as_str).unwrap_or_default().to_owned();
    let words = |key: &str| -> Vec<String> {
        let list = json.get(key).and_then(Json::as_array).into_iter().flatten();
        list.filter_map(Json::as_str).map(str::to_owned).collect()
    };
    (material.name, material.notes) = (text("name"), text("notes"));
    (material.aliases, material.tags) = (words("aliases"), words("tags"));
    material.provenance = Provenance {
        source: text("provenance.source"),
        reference: text("provenance.reference"),
        method: text("provenance.method"),
        licence: text("provenance.licence"),
    };
    material.unit_mm = json.get("unit_mm").and_then(Json::as_f64).filter(|mm| mm.is_finite() && *mm > 0.0);
    for (name, value) in properties {
        let Some(property) = Property::from_name(name) else {
            notes.push(format!("native copy: `{}` is no property of ASM {ASM_VERSION}; not read", short(name)));
            continue;
        };
        let kind = property.def().default.kind();
        match read_value(kind, value) {
            Some(value) => _ = material.set(property, value),
            None => notes.push(format!("native copy: {name}: expected {}; the translation decides", kind.expectation())),
        }
    }
    for (name, value) in json.get("textures").and_then(Json::as_object).into_iter().flatten() {
        match (Property::from_name(name), read_texture(value)) {
            (Some(property), Some(texture)) => material.slot_mut(property).texture = Some(texture),
            _ => notes.push(format!("native copy: {}: expected an image of a property; not read", short(name))),
        }
    }
    for (format, entries) in json.get("foreign").and_then(Json::as_object).into_iter().flatten() {
        for (key, value) in entries.as_object().into_iter().flatten() {
            let text = value.as_str().map(str::to_owned).ok_or(ForeignError::NotJson);
            if let Err(error) = text.and_then(|text| material.set_foreign(format, key, Some(text))) {
                notes.push(format!("native copy: foreign.{}.{}: {error}; not read", short(format), short(key)));
            }
        }
    }
    notes.truncate(MAX_NOTES);
    // A record without any of these parameters is of another make and says nothing about them.
    let translation =
        table.zip(json.get("translation")).filter(|(table, json)| table.iter().any(|def| json.get(def.name).is_some()));
    let translation = translation.map(|(table, json)| read_fields(table, json));
    Some(Native { material, translation })
}

/// A value as JSON: a number, three, or a truth.
pub fn value_json(value: Value) -> Json {
    match value {
        Value::Color(v) | Value::Normal(v) => json!(v),
        Value::Float(v) => json!(v),
        Value::Bool(v) => json!(v),
    }
}

/// A value of this kind; `None` where the JSON holds another, or a number that is not finite.
pub fn read_value(kind: Kind, json: &Json) -> Option<Value> {
    let number = |json: &Json| json.as_f64().filter(|x| x.is_finite());
    let three = || {
        let list = json.as_array().filter(|list| list.len() == 3)?;
        Some([number(&list[0])?, number(&list[1])?, number(&list[2])?])
    };
    match kind {
        Kind::Color => three().map(Value::Color),
        Kind::Normal => three().map(Value::Normal),
        Kind::Float => number(json).map(Value::Float),
        Kind::Bool => json.as_bool().map(Value::Bool),
    }
}

/// An image with every setting that is not at its default.
pub fn texture_json(texture: &TextureRef) -> Json {
    let default = TextureRef::new(texture.path.clone());
    let mut all = Map::new();
    all.insert("path".to_owned(), json!(texture.path));
    let mut add = |key: &str, differs: bool, value: Json| {
        if differs {
            all.insert(key.to_owned(), value);
        }
    };
    add("channel", texture.channel != default.channel, json!(texture.channel.word()));
    add("color_space", texture.color_space != default.color_space, json!(texture.color_space.word()));
    add("invert", texture.is_inverted, json!(true));
    add("scale", texture.scale != default.scale, json!(texture.scale));
    add("bias", texture.bias != default.bias, json!(texture.bias));
    add("wrap", texture.wrap != default.wrap, json!(texture.wrap.word()));
    add("uv_scale", texture.uv_scale != default.uv_scale, json!(texture.uv_scale));
    add("uv_offset", texture.uv_offset != default.uv_offset, json!(texture.uv_offset));
    add("uv_rotation", texture.uv_rotation != default.uv_rotation, json!(texture.uv_rotation));
    Json::Object(all)
}

/// The image that such a JSON means; settings that cannot be read have their defaults.
pub fn read_texture(json: &Json) -> Option<TextureRef> {
    let mut texture = TextureRef::new(json.get("path")?.as_str()?);
    let word = |key: &str| json.get(key).and_then(Json::as_str);
    let numbers = |key: &str, into: &mut [f64]| {
        let list = json.get(key).and_then(Json::as_array).filter(|list| list.len() == into.len());
        for (number, json) in into.iter_mut().zip(list.into_iter().flatten()) {
            *number = json.as_f64().filter(|x| x.is_finite()).unwrap_or(*number);
        }
    };
    texture.channel = word("channel").and_then(Channel::from_word).unwrap_or(texture.channel);
    texture.color_space = word("color_space").and_then(ColorSpace::from_word).unwrap_or(texture.color_space);
    texture.wrap = word("wrap").and_then(Wrap::from_word).unwrap_or(texture.wrap);
    texture.is_inverted = json.get("invert").and_then(Json::as_bool).unwrap_or(false);
    texture.uv_rotation = json.get("uv_rotation").and_then(Json::as_f64).filter(|x| x.is_finite()).unwrap_or(0.0);
    numbers("scale", &mut texture.scale);
    numbers("bias", &mut texture.bias);
    numbers("uv_scale", &mut texture.uv_scale);
    numbers("uv_offset", &mut texture.uv_offset);
    Some(texture)
}

fn fields_json(table: &[FieldDef], fields: &Fields) -> Json {
    let said = table.iter().zip(&fields.0).filter(|(_, field)| field.is_authored);
    let entry = |texture: Option<&TextureRef>, value| match texture {
        Some(texture) => json!({ "value": value_json(value), "texture": texture_json(texture) }),
        None => value_json(value),
    };
    Json::Object(said.map(|(def, field)| (def.name.to_owned(), entry(field.texture.as_ref(), field.value))).collect())
}

fn read_fields(table: &[FieldDef], json: &Json) -> Fields {
    let mut fields = Fields::unsaid(table);
    for (def, field) in table.iter().zip(&mut fields.0) {
        let Some(entry) = json.get(def.name) else { continue };
        let (value, texture) = (entry.get("value").unwrap_or(entry), entry.get("texture"));
        field.value = read_value(def.default.kind(), value).unwrap_or(def.default);
        (field.texture, field.is_authored) = (texture.and_then(read_texture), true);
    }
    fields
}
