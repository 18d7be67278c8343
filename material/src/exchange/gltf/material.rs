//! One material on the way in: JSON to parameters, and what ASM has no place for.

use std::collections::BTreeMap;

use serde_json::Value as Json;

use super::error::Wrong;
use super::images::Images;
use super::json::{at, pointer};
use super::slots::{self, SLOTS, field};
use super::{drafts, foreign, glossiness};
use crate::exchange::field::Fields;
use crate::exchange::model::Notes;
use crate::exchange::models::gltf::Gltf;
use crate::exchange::native::read_value;
use crate::slot::{Channel, ColorSpace, TextureRef};
use crate::value::{Kind, Value};

/// Where alpha counts as there, if a masked material does not say it.
const DEFAULT_CUTOFF: f64 = 0.5;

/// Steepness of the line that stands for a mask: from 0 to 1 in one step of 8 bits.
const MASK_SLOPE: f64 = 255.0;

/// A material as it stands in the file.
pub(super) struct Read {
    pub fields: Fields,
    /// What is kept word for word, by key.
    pub foreign: BTreeMap<String, Json>,
}

/// Reads a material. `place` is its JSON pointer; a value that is wrong costs a note.
pub(super) fn read(json: &Json, place: &str, images: &Images, notes: &mut Notes) -> Read {
    let mut reader = Reader { json, place, images, fields: Fields::unsaid(Gltf::FIELDS), notes };
    reader.numbers();
    reader.base_color("pbrMetallicRoughness.baseColorFactor");
    glossiness::read(&mut reader);
    for slot in SLOTS {
        reader.slot(slot);
    }
    reader.anisotropy();
    drafts::read(&mut reader);
    let mut foreign = foreign::collect(json, images);
    reader.walls(&mut foreign);
    reader.alpha_mode(&mut foreign);
    reader.unlit();
    Read { fields: reader.fields, foreign }
}

pub(super) struct Reader<'a> {
    pub json: &'a Json,
    pub place: &'a str,
    pub images: &'a Images,
    pub fields: Fields,
    pub notes: &'a mut Notes,
}

impl Reader<'_> {
    /// Notes that something is wrong at a place of the material.
    pub fn wrong(&mut self, name: &str, expected: &str) {
        let wrong = Wrong::value(pointer(self.place, name), expected, at(self.json, name));
        self.notes.push(format!("{wrong}; left out"));
    }

    /// Says a uniform value.
    pub fn say(&mut self, name: &str, value: Value) {
        if let Some(field) = self.fields.say(Gltf::FIELDS, name) {
            (field.value, field.texture) = (value, None);
        }
    }

    /// Says an image; `value` is the factor beside it.
    pub fn bind(&mut self, name: &str, value: Value, texture: TextureRef) {
        if let Some(field) = self.fields.say(Gltf::FIELDS, name) {
            (field.value, field.texture) = (value, Some(texture));
        }
    }

    pub fn value(&self, name: &str) -> Value {
        self.fields.get(Gltf::FIELDS, name).map_or(Value::Float(0.0), |field| field.value)
    }

    pub fn float(&self, name: &str) -> f64 {
        self.value(name).numbers().first().copied().unwrap_or(0.0)
    }

    fn numbers(&mut self) {
        for def in Gltf::FIELDS.iter().filter(|def| slots::is_number(def)) {
            let Some(json) = at(self.json, def.name) else { continue };
            match read_value(def.default.kind(), json) {
                Some(Value::Float(x)) if def.name == slots::ATTENUATION && x <= 0.0 => self.wrong(def.name, "a number above 0"),
                Some(value) => self.say(def.name, value),
                None => self.wrong(def.name, def.default.kind().expectation()),
            }
        }
    }

    /// Colour and alpha, four numbers in one.
    pub fn base_color(&mut self, name: &str) {
        let Some(json) = at(self.json, name) else { return };
        let numbers = json.as_array().map(|list| list.iter().filter_map(Json::as_f64).collect::<Vec<_>>());
        match numbers.as_deref() {
            Some([r, g, b, a]) => {
                self.say(slots::BASE_COLOR, Value::Color([*r, *g, *b]));
                self.say(slots::ALPHA, Value::Float(*a));
            }
            _ => self.wrong(name, "four numbers (r, g, b, a), linear"),
        }
    }

    /// The image in full that a place of the material uses.
    pub fn image(&mut self, name: &str) -> Option<TextureRef> {
        let info = at(self.json, name)?;
        match self.images.used(info, &pointer(self.place, name), self.notes) {
            Ok(texture) => Some(texture),
            Err(problem) => {
                self.notes.push(problem);
                None
            }
        }
    }

    fn slot(&mut self, slot: &slots::Slot) {
        let Some(texture) = self.image(slot.name) else { return };
        for (name, channel) in slot.parts {
            let mut texture = TextureRef { channel: *channel, ..texture.clone() };
            if slot.is_srgb && *channel == Channel::Rgb {
                texture.color_space = ColorSpace::Srgb;
            }
            self.part(name, texture);
        }
    }

    /// Binds an image to a parameter, with the factor beside it.
    fn part(&mut self, name: &str, mut texture: TextureRef) {
        let value = self.value(name);
        let factor = match value {
            Value::Color(v) => v,
            Value::Float(v) => [v; 3],
            Value::Normal(_) | Value::Bool(_) => [1.0; 3],
        };
        let most = factor.into_iter().fold(0.0, f64::max);
        match name {
            slots::ROTATION => {
                self.notes
                    .push(format!("{}: the directions in the image are not read", pointer(self.place, slots::ANISOTROPY_IMAGE)));
                return;
            }
            slots::OCCLUSION => {
                let strength = at(self.json, "occlusionTexture.strength").and_then(Json::as_f64).unwrap_or(1.0);
                (texture.scale, texture.bias) = ([strength; 3], [1.0 - strength; 3]);
            }
            _ if field(name).is_some_and(|(_, def)| def.default.kind() == Kind::Normal) => {}
            slots::SHEEN | slots::EMISSIVE if most <= 0.0 => {
                let place = pointer(self.place, name);
                self.notes.push(format!("{place}: is 0, so that the image `{}` beside it is not used", texture.path));
                return;
            }
            slots::SHEEN => {
                self.say(slots::SHEEN_IMAGE, value);
                return self.bind(name, Value::Color([1.0; 3]), texture);
            }
            slots::THICKNESS => {}
            // More than a colour can be belongs to the level.
            slots::SPECULAR_COLOR if most > 1.0 => {
                texture.scale = factor.map(|f| f / most);
                let specular = self.float(slots::SPECULAR) * most;
                if let Some(field) = self.fields.say(Gltf::FIELDS, slots::SPECULAR) {
                    field.value = Value::Float(specular);
                    for scale in field.texture.iter_mut().flat_map(|texture| &mut texture.scale) {
                        *scale *= most;
                    }
                }
                return self.bind(name, Value::Color(texture.scale), texture);
            }
            // An image times 0 says no more than the 0.
            _ if most <= 0.0 => return,
            _ => texture.scale = factor,
        }
        self.bind(name, value, texture);
    }

    /// What alpha means.
    fn alpha_mode(&mut self, foreign: &mut BTreeMap<String, Json>) {
        let alpha = self.fields.get(Gltf::FIELDS, slots::ALPHA).cloned();
        let Some(alpha) = alpha else { return };
        match at(self.json, "alphaMode").map(Json::as_str) {
            Some(Some("BLEND")) => {}
            Some(Some("MASK")) => {
                let cutoff = at(self.json, "alphaCutoff").and_then(Json::as_f64).unwrap_or(DEFAULT_CUTOFF);
                let factor = self.float(slots::ALPHA);
                match alpha.texture {
                    Some(mut texture) => {
                        // Reaches 1 at the cutoff; what leaves 0 to 1 is clamped as opacity.
                        (texture.scale, texture.bias) = ([MASK_SLOPE * factor; 3], [1.0 - MASK_SLOPE * cutoff; 3]);
                        self.bind(slots::ALPHA, Value::Float(1.0), texture);
                    }
                    None => self.say(slots::ALPHA, Value::Float(if factor >= cutoff { 1.0 } else { 0.0 })),
                }
                let kept = serde_json::json!({ "alphaMode": "MASK", "alphaCutoff": cutoff, "alphaFactor": factor });
                foreign.insert("alphaMode".to_owned(), kept);
            }
            mode => {
                if !matches!(mode, None | Some(Some("OPAQUE"))) {
                    self.wrong("alphaMode", "OPAQUE, MASK or BLEND");
                }
                if alpha.texture.is_some() || alpha.value != Value::Float(1.0) {
                    self.say(slots::ALPHA, Value::Float(1.0));
                }
            }
        }
    }

    /// A strength over an image of roughness, which would mean another anisotropy at each texel: taken where the image is halfway.
    fn anisotropy(&mut self) {
        let roughness = self.fields.get(Gltf::FIELDS, slots::ROUGHNESS).is_some_and(|field| field.texture.is_some());
        let strength = self.fields.get(Gltf::FIELDS, slots::ANISOTROPY);
        if !roughness || strength.is_none_or(|field| field.value == Value::Float(0.0)) {
            return;
        }
        let factor = self.float(slots::ROUGHNESS);
        if let Some(field) = self.fields.say(Gltf::FIELDS, slots::ROUGHNESS) {
            field.value = Value::Float(0.5 * factor);
        }
        let place = pointer(self.place, slots::ANISOTROPY);
        self.notes.push(format!("{place}: depends on the image of roughness; taken where that is at its half"));
    }

    /// A body without thickness, a thin wall: kept as such, because ASM makes it solid.
    fn walls(&mut self, foreign: &mut BTreeMap<String, Json>) {
        let passes = self.float(slots::TRANSMISSION) > 0.0 || self.float(slots::DIFFUSE) > 0.0;
        if passes && self.float(slots::THICKNESS_FACTOR) <= 0.0 && self.float(slots::DISPERSION) == 0.0 {
            const VOLUME: &str = "KHR_materials_volume";
            let body = at(self.json, VOLUME).map_or(Json::Null, |body| foreign::named(body, self.images));
            foreign.insert(VOLUME.to_owned(), body);
        }
    }

    /// A material that no light changes: it shines by itself.
    fn unlit(&mut self) {
        if at(self.json, "KHR_materials_unlit").is_none() {
            return;
        }
        let Some(color) = self.fields.get(Gltf::FIELDS, slots::BASE_COLOR).cloned() else { return };
        if let Some(emissive) = self.fields.say(Gltf::FIELDS, slots::EMISSIVE) {
            (emissive.value, emissive.texture) = (color.value, color.texture);
        }
        for (name, value) in [
            (slots::STRENGTH, Value::Float(1.0)),
            (slots::BASE_COLOR, Value::Color([0.0; 3])),
            (slots::SPECULAR, Value::Float(0.0)),
            (slots::METALLIC, Value::Float(0.0)),
        ] {
            self.say(name, value);
        }
        self.notes.push(format!("{}: unlit; shines in its base colour", self.place));
    }
}
