//! Extensions that exist as proposals only: their numbers are read, as what they mean in the ratified ones; all of them are kept.

use super::json::at;
use super::material::Reader;
use super::slots;
use crate::exchange::native::read_value;
use crate::value::{Kind, Value};

/// Reads what the ratified extensions do not say.
pub(super) fn read(reader: &mut Reader) {
    scatter(reader);
    coat(reader);
    fuzz(reader);
}

/// A number of a draft, if it says it.
fn number(reader: &mut Reader, name: &str, kind: Kind) -> Option<Value> {
    let value = read_value(kind, at(reader.json, name)?);
    if value.is_none() {
        reader.wrong(name, kind.expectation());
    }
    value
}

/// Tells that the images of a draft are not read.
fn tell_of_images(reader: &mut Reader, name: &str) {
    let body = at(reader.json, name).and_then(|body| body.as_object());
    if body.is_some_and(|body| body.keys().any(|key| key.ends_with("Texture"))) {
        reader.notes.push(format!("{}: the images of {name}, a draft, are not read", reader.place));
    }
}

/// The colour of scattering: the body then scatters, whichever way light goes through it.
fn scatter(reader: &mut Reader) {
    const NAME: &str = "KHR_materials_volume_scatter";
    if at(reader.json, NAME).is_none() {
        return;
    }
    let (diffuse, clear) = (reader.float(slots::DIFFUSE), reader.float(slots::TRANSMISSION));
    reader.say(slots::DIFFUSE, Value::Float(diffuse.max(clear)));
    reader.say(slots::TRANSMISSION, Value::Float(0.0));
    let names = ["multiscatterColorFactor", "multiscatterColor"].map(|key| format!("{NAME}.{key}"));
    let color = names.iter().find_map(|name| number(reader, name, Kind::Color));
    reader.say(slots::DIFFUSE_COLOR, color.unwrap_or(Value::Color([0.0; 3])));
    tell_of_images(reader, NAME);
}

/// A coat with a colour and an index.
fn coat(reader: &mut Reader) {
    const NAME: &str = "KHR_materials_coat";
    if at(reader.json, NAME).is_none() || at(reader.json, "KHR_materials_clearcoat").is_some() {
        return;
    }
    for (key, name, kind) in [
        ("coatFactor", slots::COAT, Kind::Float),
        ("coatRoughnessFactor", slots::COAT_ROUGHNESS, Kind::Float),
        ("coatIor", slots::COAT_IOR, Kind::Float),
        ("coatColorFactor", slots::COAT_TINT, Kind::Color),
    ] {
        if let Some(value) = number(reader, &format!("{NAME}.{key}"), kind) {
            reader.say(name, value);
        }
    }
    tell_of_images(reader, NAME);
}

/// A sheen whose amount stands apart from its colour.
fn fuzz(reader: &mut Reader) {
    const NAME: &str = "KHR_materials_fuzz";
    if at(reader.json, NAME).is_none() || at(reader.json, "KHR_materials_sheen").is_some() {
        return;
    }
    let amount = number(reader, &format!("{NAME}.fuzzFactor"), Kind::Float).unwrap_or(Value::Float(0.0));
    let amount = amount.numbers().first().copied().unwrap_or(0.0);
    if amount > 0.0 {
        let color = number(reader, &format!("{NAME}.fuzzColorFactor"), Kind::Color).unwrap_or(Value::Color([1.0; 3]));
        reader.say(slots::SHEEN, color);
        reader.say(slots::SHEEN_IMAGE, Value::Color([amount; 3]));
        let roughness = number(reader, &format!("{NAME}.fuzzRoughnessFactor"), Kind::Float);
        reader.say(slots::SHEEN_ROUGHNESS, roughness.unwrap_or(Value::Float(0.5)));
    }
    tell_of_images(reader, NAME);
}
