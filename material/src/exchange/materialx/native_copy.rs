//! The native copy: an instance of our own node.
//!
//! Its inputs hold the authored values, with an attribute beside each that single precision does not hold. One attribute of the node holds
//! as JSON what inputs cannot: the texts about the material, the bindings of its images in full, and what the translation said. An image
//! whose binding stands there and whose nodes still say the same has that binding; a property whose input is gone is not authored.

use serde_json::{Map, Value as Json, json};

use super::definition::type_of;
use super::numbers;
use super::textures::{TextureGraph, writable};
use super::walk::Walk;
use super::write::{Feed, Input, WriteOptions, stored};
use super::xml::Id;
use super::{definition, fields};
use crate::exchange::field::{Field, Fields};
use crate::exchange::merge::is_same;
use crate::exchange::model::{Notes, ShadingModel};
use crate::exchange::native::{self, Native, value_json};
use crate::exchange::short::short;
use crate::file::ASM_VERSION;
use crate::material::Material;
use crate::properties::{PROPERTIES, Property};
use crate::slot::{Slot, TextureRef};
use crate::value::{Kind, Value};

/// Attribute of a surfacematerial that names the node.
pub const SOURCE: &str = "asm_source";
/// Attribute of a surfacematerial with the version of the model.
pub const VERSION: &str = "asm_version";
/// Attribute of an input with its numbers in double precision.
pub const WIDE: &str = "asm_wide";
/// Attribute of the node with everything else, as JSON.
pub const RECORD: &str = "asm_record";
/// Largest record that is read, bytes.
const MAX_RECORD: usize = 4 << 20;

/// A native copy to write.
pub struct NativeCopy {
    /// Inputs of the node.
    pub inputs: Vec<Input>,
    /// The record.
    pub record: Json,
}

/// Makes the native copy of a material. `found` is what a reader finds of the translation.
pub fn write(
    material: &Material,
    options: &WriteOptions,
    found: &Fields,
    graph: &mut TextureGraph,
    notes: &mut Notes,
) -> NativeCopy {
    let (mut inputs, mut files, mut moved) = (Vec::new(), Map::new(), material.clone());
    let mut is_held = |property: Property, slot: &Slot| -> bool {
        let def = property.def();
        let kind = def.default.kind();
        if let Some(texture) = &slot.texture {
            let path = (options.path)(&texture.path);
            match writable(texture, kind, path.clone()) {
                Ok((binding, _)) => {
                    let node = match kind {
                        Kind::Normal => graph.normal(Some(&binding), [0.0, 0.0, 1.0], 1.0),
                        _ => graph.numbers(&binding, kind, kind == Kind::Color),
                    };
                    let output = graph.output(&format!("asm_{}", def.name), type_of(kind), node);
                    inputs.push(Input::plain(def.name, type_of(kind), Feed::Output(output)));
                }
                Err(reason) => notes.push(format!("{}: the image `{}` {reason}; in the record alone", def.name, texture.path)),
            }
            // Textures that come with the program are the same everywhere; files lie where the document says.
            if texture.path.starts_with("builtin:") {
                files.insert(texture.path.clone(), json!(path));
            } else if let Some(texture) = &mut moved.slot_mut(property).texture {
                texture.path = path;
            }
            return false;
        }
        match slot.value {
            Some(value @ Value::Normal(constant)) if stored(value) != def.default => {
                let node = graph.normal(None, constant, 1.0);
                let output = graph.output(&format!("asm_{}", def.name), "vector3", node);
                inputs.push(Input::plain(def.name, "vector3", Feed::Output(output)));
                false
            }
            Some(Value::Normal(_)) | None => false,
            Some(value) => {
                let is_narrow = value.numbers().iter().all(|x| numbers::stored(*x).to_bits() == x.to_bits());
                let wide = || value.numbers().iter().map(|x| numbers::wide(*x)).collect::<Vec<_>>().join(", ");
                inputs.push(Input {
                    name: def.name.to_owned(),
                    kind: type_of(kind),
                    feed: Feed::Value(definition::value_text(value)),
                    wide: (!is_narrow).then(wide),
                });
                true
            }
        }
    };
    let held: Vec<Property> =
        material.slots().filter(|(property, slot)| is_held(*property, slot)).map(|(property, _)| property).collect();
    let mut record = native::write(&moved, Some((options.surface.fields, found)));
    if let Some(all) = record.as_object_mut() {
        if let Some(properties) = all.get_mut("properties").and_then(Json::as_object_mut) {
            properties.retain(|name, _| !held.iter().any(|property| property.def().name == name));
        }
        all.insert("surface".to_owned(), json!(options.surface.name));
        if !files.is_empty() {
            all.insert("files".to_owned(), Json::Object(files));
        }
    }
    NativeCopy { inputs, record }
}

/// A native copy that was read.
pub struct Found {
    /// The material, and the translation as it was written if that is of the model asked for.
    pub native: Native,
    /// Properties whose values could not be read: the translation decides about them.
    pub broken: Vec<Property>,
}

/// Reads the native copy that a node holds. None, with a note, where it is of another version.
pub fn read(walk: &mut Walk, node: Id, version: Option<&str>, model: Option<&ShadingModel>) -> Option<Found> {
    let is_recorded = walk.graph.tree.attribute(node, RECORD).is_some();
    let mut json = record(walk, node);
    let version = walk.graph.tree.attribute(node, "version").or(version).unwrap_or(ASM_VERSION).to_owned();
    json.insert("version".to_owned(), json!(version));
    let mut properties = match json.remove("properties") {
        Some(Json::Object(properties)) => properties,
        _ => Map::new(),
    };
    let (mut broken, mut images) = (Vec::new(), Vec::new());
    let inputs: Vec<Id> = walk.graph.inputs(node).take(4 * PROPERTIES.len()).collect();
    for input in inputs {
        let name = walk.graph.tree.attribute(input, "name").unwrap_or_default();
        let Some(property) = property_of(name) else {
            let note = format!("{}: no property of ASM {ASM_VERSION}; not read", walk.graph.path(input));
            walk.note(note);
            continue;
        };
        let (name, kind) = (property.def().name, property.def().default.kind());
        match read_input(walk, input, kind) {
            Ok(Field { texture: Some(texture), .. }) => images.push((property, Ok(texture))),
            Ok(Field { value: Value::Normal(constant), .. }) => images.push((property, Err(constant))),
            Ok(Field { value, .. }) => _ = properties.insert(name.to_owned(), value_json(value)),
            Err(()) => {
                properties.remove(name);
                broken.push(property);
            }
        }
    }
    json.insert("properties".to_owned(), Json::Object(properties));
    let files = json.get("files").cloned().unwrap_or_default();
    let is_of_model = model.is_some_and(|model| json.get("surface").and_then(Json::as_str) == Some(model.name));
    let table = model.filter(|_| is_of_model).map(|model| model.fields);
    let mut faults = Notes::new();
    let read = native::read(&Json::Object(json), table, &mut faults);
    faults.into_iter().for_each(|fault| walk.note(fault));
    let mut native = read?;
    for def in PROPERTIES {
        let found = images.iter().find(|(property, _)| *property == def.id).map(|(_, found)| found.clone());
        let mut changes = Notes::new();
        settle(native.material.slot_mut(def.id), def.id, found, &files, &mut changes);
        if is_recorded {
            walk.notes.append(&mut changes);
        }
    }
    Some(Found { native, broken })
}

fn record(walk: &mut Walk, node: Id) -> Map<String, Json> {
    let text = walk.graph.tree.attribute(node, RECORD).unwrap_or("{}");
    let json = if text.len() > MAX_RECORD { None } else { serde_json::from_str(text).ok() };
    match json {
        Some(Json::Object(all)) => all,
        _ => {
            let note = format!("{}: expected JSON of at most {MAX_RECORD} bytes in `{RECORD}`; not read", walk.graph.path(node));
            walk.note(note);
            Map::new()
        }
    }
}

/// The property of an input: case counts only where it has to.
fn property_of(name: &str) -> Option<Property> {
    let in_any_case = || PROPERTIES.iter().find(|def| def.name.eq_ignore_ascii_case(name)).map(|def| def.id);
    Property::from_name(name).or_else(in_any_case)
}

/// What an input of the node says.
fn read_input(walk: &mut Walk, input: Id, kind: Kind) -> Result<Field, ()> {
    let tree = walk.graph.tree;
    let field = fields::read_input(walk, input, kind).map_err(|note| walk.note(format!("{note}; the translation decides")))?;
    let (Some(text), Some(wide)) = (tree.attribute(input, "value"), tree.attribute(input, WIDE)) else { return Ok(field) };
    let count = field.value.numbers().len();
    let (Some(narrow), Some(wide)) = (numbers::parse(text, count), numbers::parse(wide, count)) else {
        let note =
            format!("{}: expected {} in `{WIDE}`, found `{}`; not read", walk.graph.path(input), kind.expectation(), short(wide));
        walk.note(note);
        return Ok(field);
    };
    // Somebody who changes the input leaves the attribute behind.
    let still_holds = narrow.iter().zip(wide).all(|(narrow, wide)| *narrow as f32 == numbers::stored(wide) as f32);
    let value = match field.value {
        Value::Color(_) => Value::Color([wide[0], wide[1], wide[2]]),
        Value::Float(_) => Value::Float(wide[0]),
        value => value,
    };
    Ok(if still_holds { Field { value, ..field } } else { field })
}

/// Decides between the binding of the record and what the nodes say: a binding, or a constant normal.
fn settle(slot: &mut Slot, property: Property, found: Option<Result<TextureRef, [f64; 3]>>, files: &Json, notes: &mut Notes) {
    let def = property.def();
    let kind = def.default.kind();
    let of = |texture: Option<TextureRef>, value: Value| Field { value, texture, is_authored: true };
    let written = slot.texture.as_ref().and_then(|texture| {
        let path = files.get(&texture.path).and_then(Json::as_str).unwrap_or(&texture.path);
        writable(texture, kind, path.to_owned()).ok().map(|(_, found)| found)
    });
    match found {
        Some(Ok(texture)) => {
            let is_same =
                written.is_some_and(|written| is_same(&of(Some(written), def.default), &of(Some(texture.clone()), def.default)));
            if !is_same {
                notes.push(format!("{}: the image was changed in the native copy to `{}`", def.name, texture.path));
                slot.texture = Some(texture);
            }
        }
        Some(Err(constant)) => {
            let constant = Value::Normal(constant);
            slot.texture = None;
            if !slot.value.is_some_and(|value| is_same(&of(None, stored(value)), &of(None, constant))) {
                slot.value = Some(constant);
            }
        }
        None if written.is_some() => {
            notes.push(format!("{}: the image was taken out of the native copy", def.name));
            slot.texture = None;
        }
        None => {}
    }
}
