//! The dictionary `asm` in a material's `customData`: what makes the shader of the Adobe Standard Material a native copy.
//!
//! The shader has all 40 inputs. The dictionary says which of them were authored, which numbers are wider than single precision, which
//! image bindings USD cannot say, and everything that a material holds beside its properties.

use super::images::as_written;
use super::layer::{Entries, entry};
use super::numbers::{double, file_path, quoted, quoted_list, single};
use crate::exchange::field::Field;
use crate::exchange::merge::is_same;
use crate::exchange::model::Notes;
use crate::exchange::native;
use crate::exchange::short::short;
use crate::file::ASM_VERSION;
use crate::material::Material;
use crate::properties::{PROPERTIES, Property};
use crate::slot::TextureRef;
use crate::value::{Kind, Value};

/// What the dictionary of a file says.
pub(super) struct Copy {
    /// The material without its values.
    pub material: Material,
    /// Whether it holds the texts of the material.
    pub has_document: bool,
    authored: Vec<Property>,
    wide: Vec<(Property, Value)>,
    /// Paths of images as the file has them, where they are others than the material's.
    files: Vec<(Property, String)>,
}

/// The lines of the dictionary. `path_of` says where an image lies beside the file.
pub(super) fn lines(material: &Material, path_of: &dyn Fn(&TextureRef) -> String) -> Vec<String> {
    let mut bare = material.clone();
    let (mut authored, mut wide, mut files) = (Vec::new(), Vec::new(), Vec::new());
    for def in PROPERTIES {
        let slot = bare.slot_mut(def.id);
        if let Some(value) = slot.value.take().filter(is_finite) {
            authored.push(def.name.to_owned());
            if !same_bits(value, held(value)) {
                let numbers: Vec<String> = value.numbers().iter().map(|x| double(*x)).collect();
                wide.push(format!("{}={}", def.name, numbers.join(",")));
            }
        }
        if let Some(texture) = &slot.texture {
            let path = file_path(&path_of(texture));
            if path != texture.path {
                files.push(format!("{}={path}", def.name));
            }
        }
    }
    let mut lines =
        vec![format!("string version = {}", quoted(ASM_VERSION)), format!("string[] authored = {}", quoted_list(authored))];
    for (name, list) in [("wide", wide), ("files", files)] {
        if !list.is_empty() {
            lines.push(format!("string[] {name} = {}", quoted_list(list)));
        }
    }
    lines.push(format!("string document = {}", quoted(&native::write(&bare, None).to_string())));
    lines
}

/// Reads the dictionary; `None`, with a note, where it is of another major version or no such dictionary.
pub(super) fn read(entries: &Entries, notes: &mut Notes) -> Option<Copy> {
    let text = |name: &str| entry(entries, name).and_then(|value| value.text());
    let version = text("version").unwrap_or_default();
    if version.split('.').next() != ASM_VERSION.split('.').next() {
        notes.push(format!(
            "customData.asm: expected version {ASM_VERSION}, found `{}`; the shader alone is read",
            short(version)
        ));
        return None;
    }
    let (mut material, mut has_document) = (Material::default(), false);
    if let Some(document) = text("document") {
        match serde_json::from_str(document) {
            Ok(json) => (material, has_document) = (native::read(&json, None, notes)?.material, true),
            Err(_) => notes.push("customData.asm.document: expected JSON, found something else; not read".to_owned()),
        }
    }
    let list = |name: &str| entry(entries, name).map_or(&[][..], |value| value.texts());
    let pairs = |name: &str| list(name).iter().filter_map(|text| text.split_once('='));
    let named = |name: &str| Property::from_name(name);
    Some(Copy {
        material,
        has_document,
        authored: list("authored").iter().filter_map(|name| named(name)).collect(),
        wide: pairs("wide").filter_map(|(name, numbers)| Some((named(name)?, wide_value(named(name)?, numbers)?))).collect(),
        files: pairs("files").filter_map(|(name, path)| Some((named(name)?, path.to_owned()))).collect(),
    })
}

impl Copy {
    /// What was authored as a property's value, given what the input holds now.
    pub fn value(&self, property: Property, input: Option<Value>, notes: &mut Notes) -> Option<Value> {
        let (input, def) = (input?, property.def());
        if !self.authored.contains(&property) {
            let is_default = same_bits(input, held(def.default));
            if !is_default {
                notes.push(format!("{}: another program set `inputs:{}`; its value holds", def.name, def.usage));
            }
            return (!is_default).then_some(input);
        }
        let wide = self.wide.iter().find(|(name, _)| *name == property).map(|(_, value)| *value);
        Some(wide.filter(|wide| same_bits(held(*wide), held(input))).unwrap_or(input))
    }

    /// What was authored as a property's image, given the one that the network holds now, and where its file lies.
    pub fn texture(&self, property: Property, network: Option<TextureRef>, notes: &mut Notes) -> Option<TextureRef> {
        let def = property.def();
        match (&self.material.slot(property).texture, network) {
            (Some(native), Some(network)) => {
                let written = as_written(def.default.kind(), native, self.file(property, native));
                let field = |texture| Field { value: Value::Bool(false), texture: Some(texture), is_authored: true };
                if written.color_space == network.color_space && is_same(&field(written), &field(network.clone())) {
                    return Some(native.clone());
                }
                notes.push(format!("{}: another program changed its image to `{}`, which holds", def.name, network.path));
                Some(network)
            }
            (Some(native), None) => {
                notes.push(format!("{}: another program took its image `{}` away", def.name, native.path));
                None
            }
            (None, network) => network,
        }
    }

    /// Where the image of a property lies beside the file.
    pub fn file<'t>(&'t self, property: Property, native: &'t TextureRef) -> &'t str {
        self.files.iter().find(|(name, _)| *name == property).map_or(&native.path, |(_, path)| path)
    }
}

/// A value as an input of single precision holds it.
pub(super) fn held(value: Value) -> Value {
    match value {
        Value::Color(v) => Value::Color(v.map(single)),
        Value::Normal(v) => Value::Normal(v.map(single)),
        Value::Float(v) => Value::Float(single(v)),
        Value::Bool(v) => Value::Bool(v),
    }
}

/// Whether all numbers of a value are finite.
pub(super) fn is_finite(value: &Value) -> bool {
    value.numbers().iter().all(|x| x.is_finite())
}

fn same_bits(a: Value, b: Value) -> bool {
    crate::file::same_value(Some(a), Some(b))
}

fn wide_value(property: Property, text: &str) -> Option<Value> {
    let numbers: Vec<f64> =
        text.split(',').map(|x| x.trim().parse().ok().filter(|x: &f64| x.is_finite())).collect::<Option<_>>()?;
    match (property.def().default.kind(), numbers.as_slice()) {
        (Kind::Float, [x]) => Some(Value::Float(*x)),
        (Kind::Color, [x, y, z]) => Some(Value::Color([*x, *y, *z])),
        (Kind::Normal, [x, y, z]) => Some(Value::Normal([*x, *y, *z])),
        _ => None,
    }
}
