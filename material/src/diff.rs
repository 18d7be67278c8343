//! What two materials differ in, entry by entry, in the words of their files.

use std::collections::BTreeMap;

use crate::file::{MaterialFile, TEXTS, list, same_texture, same_value, string, texture, value_text};
use crate::foreign::{self, differing, entry_key};
use crate::material::Material;
use crate::properties::{PROPERTIES, Property};
use crate::value::{Unit, Value};

/// One entry that differs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Change {
    /// The entry: `name`, `unit_mm`, `provenance.licence`, `foreign.gltf.KHR_materials_iridescence`, a property by its formal name,
    /// `roughness.texture`, or another key of the file.
    pub key: String,
    /// The property, if it is about one.
    pub property: Option<Property>,
    /// The first material's text as a file writes it; `None` where it says nothing or the value is the default one.
    pub a: Option<String>,
    /// The second material's.
    pub b: Option<String>,
    /// Whether a picture can tell: names, notes and sources cannot be seen.
    pub is_visible: bool,
}

/// Everything in which two materials differ: name, other names, tags, notes, unit, provenance, texts of other formats, then values and textures
/// in specification order.
///
/// A default that is written out is no difference to one that is not. Numbers are compared to the last bit.
pub fn changes(a: &Material, b: &Material) -> Vec<Change> {
    let mut found = Vec::new();
    let mut add = |key: String, property, a: Option<String>, b: Option<String>, is_visible| {
        found.push(Change { key, property, a, b, is_visible });
    };
    let texts = [("name", &a.name, &b.name), ("notes", &a.notes, &b.notes)];
    for (key, a, b) in texts.into_iter().filter(|(_, a, b)| a != b) {
        add(key.to_owned(), None, text(a), text(b), false);
    }
    for (key, a, b) in [("aliases", &a.aliases, &b.aliases), ("tags", &a.tags, &b.tags)] {
        if a != b {
            let text = |words: &[String]| (!words.is_empty()).then(|| list(words));
            add(key.to_owned(), None, text(a), text(b), false);
        }
    }
    if a.unit_mm().to_bits() != b.unit_mm().to_bits() {
        let unit = |m: &Material| m.unit_mm.map(|unit| value_text(Value::Float(unit)));
        add("unit_mm".to_owned(), None, unit(a), unit(b), true);
    }
    for (key, get) in TEXTS {
        let (a, b) = (get(&a.provenance), get(&b.provenance));
        if a != b {
            add(format!("provenance.{key}"), None, text(a), text(b), false);
        }
    }
    for (format, key) in differing(a, b) {
        let text = |m: &Material| m.foreign_text(format, key).map(string);
        add(entry_key(format, key), None, text(a), text(b), false);
    }
    for def in PROPERTIES {
        let (value_a, value_b) = (a.value(def.id), b.value(def.id));
        if !same_value(Some(value_a), Some(value_b)) {
            let written = |value| (!same_value(Some(value), Some(def.default))).then(|| value_text(value));
            add(def.name.to_owned(), Some(def.id), written(value_a), written(value_b), true);
        }
        let (image_a, image_b) = (a.slot(def.id).texture.as_ref(), b.slot(def.id).texture.as_ref());
        if !same_texture(image_a, image_b) {
            add(format!("{}.texture", def.name), Some(def.id), image_a.map(texture), image_b.map(texture), true);
        }
    }
    found
}

/// The same of two files, with what this version does not know and with the sources of single values.
pub fn file_changes(a: &MaterialFile, b: &MaterialFile) -> Vec<Change> {
    let mut found = changes(a.material(), b.material());
    let (a, b) = (entries(a), entries(b));
    let keys = a.keys().chain(b.keys().filter(|key| !a.contains_key(*key)));
    for key in keys.filter(|key| a.get(*key) != b.get(*key)) {
        let of = |side: &BTreeMap<String, &str>| side.get(key).map(|text| (*text).to_owned());
        found.push(Change { key: key.clone(), property: None, a: of(&a), b: of(&b), is_visible: false });
    }
    found
}

/// [`MaterialFile::other_entries`] by key.
pub(crate) fn entries(file: &MaterialFile) -> BTreeMap<String, &str> {
    file.other_entries().into_iter().collect()
}

/// A text as a file writes it; `None` if it is empty.
pub(crate) fn text(words: &str) -> Option<String> {
    (!words.is_empty()).then(|| string(words))
}

/// Gives a material an entry of another one, by a key of [`changes`]; whether there is such an entry. Lengths mean nothing without their unit:
/// where the units differ, the unit goes with all lengths, and each length with the unit.
pub fn take(to: &mut Material, from: &Material, key: &str) -> bool {
    let has_one_unit = to.unit_mm().to_bits() == from.unit_mm().to_bits();
    match key {
        "name" => to.name.clone_from(&from.name),
        "notes" => to.notes.clone_from(&from.notes),
        "aliases" => to.aliases.clone_from(&from.aliases),
        "tags" => to.tags.clone_from(&from.tags),
        "unit_mm" => take_lengths(to, from),
        "provenance.source" => to.provenance.source.clone_from(&from.provenance.source),
        "provenance.reference" => to.provenance.reference.clone_from(&from.provenance.reference),
        "provenance.method" => to.provenance.method.clone_from(&from.provenance.method),
        "provenance.licence" => to.provenance.licence.clone_from(&from.provenance.licence),
        _ if key.starts_with("foreign.") => return take_foreign(to, from, key),
        _ => {
            let (name, is_texture) = key.strip_suffix(".texture").map_or((key, false), |name| (name, true));
            let Some(id) = Property::from_name(name) else { return false };
            match (is_texture, id.def().unit == Unit::Length && !has_one_unit) {
                (true, _) => to.slot_mut(id).texture.clone_from(&from.slot(id).texture),
                (false, true) => take_lengths(to, from),
                (false, false) => to.slot_mut(id).value = from.slot(id).value,
            }
        }
    }
    true
}

/// Whether [`take`] finds an entry of this key in either material: unknown keys and sources of single values belong to their files alone.
pub fn can_take(a: &Material, b: &Material, key: &str) -> bool {
    if key.starts_with("foreign.") {
        return [a, b].into_iter().flat_map(foreign::keys).any(|(format, name)| entry_key(format, name) == key);
    }
    take(&mut Material::default(), &Material::default(), key)
}

/// A dot in a name can make two entries of one key; both are taken then.
fn take_foreign(to: &mut Material, from: &Material, key: &str) -> bool {
    let old = to.clone();
    let found: Vec<_> =
        [&old, from].into_iter().flat_map(foreign::keys).filter(|(format, name)| entry_key(format, name) == key).collect();
    // Beyond what a material holds, nothing is taken.
    found.iter().for_each(|(format, name)| _ = to.set_foreign(format, name, from.foreign_text(format, name).map(str::to_owned)));
    !found.is_empty()
}

fn take_lengths(to: &mut Material, from: &Material) {
    to.unit_mm = from.unit_mm;
    for def in PROPERTIES.iter().filter(|def| def.unit == Unit::Length) {
        *to.slot_mut(def.id) = from.slot(def.id).clone();
    }
}
