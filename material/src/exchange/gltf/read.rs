//! The way in: a document to its materials.

use std::collections::{BTreeMap, BTreeSet};

use serde_json::Value as Json;

use super::container;
use super::error::{GltfError, Wrong};
use super::foreign;
use super::images::{Image, Images, list};
use super::material;
use super::uri;
use crate::exchange::field::Fields;
use crate::exchange::merge::merge;
use crate::exchange::model::{Context, Notes};
use crate::exchange::models::gltf::{Gltf, MODEL};
use crate::exchange::native::{self, Native};
use crate::exchange::short::short;
use crate::material::Material;

/// Longest JSON that is read, bytes.
pub const MAX_JSON_BYTES: usize = 256 << 20;
/// Most values in it, told by its commas: each takes memory, however short it is.
pub const MAX_JSON_VALUES: usize = 2_000_000;
/// Most materials that are read.
pub const MAX_MATERIALS: usize = 4096;
/// Most textures, and most images, that are read.
pub const MAX_TEXTURES: usize = 16_384;

/// What a document holds.
#[derive(Clone, Debug)]
pub struct Document {
    /// Its materials, in its order.
    pub materials: Vec<Found>,
    /// Its images. Textures of the materials name them by path; not each one is used.
    pub images: Vec<Image>,
    /// What could not be used, beside the materials.
    pub notes: Notes,
}

/// A material as it stands in a document.
#[derive(Clone, Debug)]
pub struct Found {
    /// Its name there; may be empty.
    pub name: String,
    /// The parameters of the shading model `gltf`.
    pub fields: Fields,
    /// The copy that this program left in it.
    pub native: Option<Native>,
    /// What ASM has no place for: JSON by key, with images by their paths.
    pub foreign: BTreeMap<String, Json>,
    /// Width of the first mesh that wears it, in units of the document.
    pub mesh_width: Option<f64>,
    /// What of the parameters could not be read as it stands.
    pub notes: Notes,
    /// What of the native copy could not be read.
    pub native_notes: Notes,
}

impl Found {
    /// The material, and what the user should know of how it was read.
    pub fn material(&self) -> (Material, Notes) {
        let mut notes = Notes::new();
        let unit = self.native.as_ref().map_or_else(Material::default, |native| native.material.clone());
        let context = Context { mesh_width: self.mesh_width.unwrap_or(1.0), ..Context::of(&unit) };
        let mut material = match &self.native {
            Some(native) => merge(&MODEL, native, &self.fields, &context, &mut notes),
            None => MODEL.interpret(&self.fields, &context, &mut notes),
        };
        // What is wrong with parameters is nobody's concern while the native copy decides about all of them.
        if self.native.is_none() || !notes.is_empty() {
            notes.splice(0..0, self.notes.iter().cloned());
        }
        notes.splice(0..0, self.native_notes.iter().cloned());
        if !self.name.is_empty() && self.name != material.name {
            if self.native.is_some() && !material.name.is_empty() {
                notes.push(format!("renamed from `{}` to `{}` by another program", short(&material.name), short(&self.name)));
            }
            material.name.clone_from(&self.name);
        }
        foreign::take(&self.foreign, self.native.is_some(), &mut material, &mut notes);
        for key in self.foreign.keys().filter(|key| self.native.is_none() && foreign::is_worth_a_note(key)) {
            notes.push(format!("{}: ASM has no place for it; kept for the way back to glTF", short(key)));
        }
        (material, notes)
    }
}

/// Reads the materials of a document: JSON text, or the bytes of a binary file.
///
/// What is wrong in a material costs a note there; only what is no glTF 2.0 is an error. Opens no files.
pub fn read(bytes: &[u8]) -> Result<Document, GltfError> {
    let (json, blob) = container::split(bytes)?;
    let json = json.strip_prefix(b"\xef\xbb\xbf").unwrap_or(json);
    at_most("bytes of JSON", MAX_JSON_BYTES, json.len())?;
    at_most("values in the JSON", MAX_JSON_VALUES, json.iter().filter(|byte| **byte == b',').count())?;
    let root: Json = serde_json::from_slice(json).map_err(|error| GltfError::NotJson {
        line: error.line(),
        column: error.column(),
        message: error.to_string().split(" at line ").next().unwrap_or_default().to_owned(),
    })?;
    check(&root)?;
    let images = Images::of(&root, blob);
    let mut notes: Notes = images.all.iter().filter_map(|image| image.as_ref().err().cloned()).collect();
    for name in list(&root, "extensionsRequired").iter().filter_map(Json::as_str) {
        if !name.contains("_materials_") && !["KHR_texture_transform", "KHR_texture_basisu", "EXT_texture_webp"].contains(&name) {
            notes.push(format!("extensionsRequired: {} is not read; materials alone are", short(name)));
        }
    }
    let widths = widths(&root);
    let materials = list(&root, "materials").iter().enumerate();
    let materials = materials.map(|(k, json)| Found { mesh_width: widths.get(&k).copied(), ..found(json, k, &images) }).collect();
    Ok(Document { materials, images: images.into_found(), notes })
}

fn at_most(what: &'static str, most: usize, found: usize) -> Result<(), GltfError> {
    if found > most { Err(GltfError::TooMuch { what, most, found }) } else { Ok(()) }
}

/// What a document must be for its materials to be found.
fn check(root: &Json) -> Result<(), GltfError> {
    let wrong = |place: &str, expected: &str, found| Err(GltfError::NotGltf(Wrong::value(place, expected, found)));
    if !root.is_object() {
        return wrong("/", "an object", Some(root));
    }
    let version = root.pointer("/asset/version");
    if !version.and_then(Json::as_str).is_some_and(|version| version.starts_with("2.")) {
        return wrong("/asset/version", "\"2.0\"", version);
    }
    for (key, most) in [
        ("materials", MAX_MATERIALS),
        ("textures", MAX_TEXTURES),
        ("images", MAX_TEXTURES),
        ("samplers", MAX_TEXTURES),
        ("extensionsRequired", MAX_TEXTURES),
    ] {
        let Some(json) = root.get(key) else { continue };
        let Some(entries) = json.as_array() else { return wrong(&format!("/{key}"), "a list", Some(json)) };
        at_most(key, most, entries.len())?;
    }
    for (k, material) in list(root, "materials").iter().enumerate() {
        if !material.is_object() {
            return wrong(&format!("/materials/{k}"), "an object", Some(material));
        }
    }
    Ok(())
}

/// Reads one material of a document.
pub(super) fn found(json: &Json, index: usize, images: &Images) -> Found {
    let mut notes = Notes::new();
    let material::Read { fields, foreign } = material::read(json, &format!("/materials/{index}"), images, &mut notes);
    let copy = json.pointer("/extras/asm");
    let mut native_notes = Notes::new();
    let mut native = copy.and_then(|copy| native::read(copy, Some(Gltf::FIELDS), &mut native_notes));
    if let Some(native) = &mut native {
        keep_inside(&mut native.material, &mut native_notes);
    }
    let name = json.get("name").and_then(Json::as_str).unwrap_or_default().to_owned();
    Found { name, fields, native, foreign, mesh_width: None, notes, native_notes }
}

/// Takes images out of a native copy that would lie outside of the document's folder.
fn keep_inside(material: &mut Material, notes: &mut Notes) {
    let properties: Vec<_> = material.slots().map(|(property, _)| property).collect();
    for property in properties {
        let slot = material.slot_mut(property);
        let is_outside = |path: &str| !is_builtin(path) && uri::safe(path).is_none();
        if let Some(texture) = slot.texture.take_if(|texture| is_outside(&texture.path)) {
            let (name, path) = (property.def().name, super::error::start_of(&texture.path));
            notes.push(format!("native copy: {name}: expected a relative path, found \"{path}\"; the image is not read"));
        }
    }
}

/// Whether a path names an image of this program.
pub(super) fn is_builtin(path: &str) -> bool {
    path.starts_with("builtin:")
}

/// Widths of the meshes, by the materials that they wear: the first mesh of each.
fn widths(root: &Json) -> BTreeMap<usize, f64> {
    let number = |json: Option<&Json>| json.and_then(Json::as_u64).and_then(|n| usize::try_from(n).ok());
    let mut widths = BTreeMap::new();
    for mesh in list(root, "meshes") {
        let primitives = list(mesh, "primitives");
        let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
        for primitive in primitives {
            let accessor = number(primitive.pointer("/attributes/POSITION")).and_then(|k| list(root, "accessors").get(k));
            let end = |key: &str| accessor.and_then(|a| a.get(key)?.get(0)?.as_f64());
            if let (Some(min), Some(max)) = (end("min"), end("max")) {
                (least, most) = (least.min(min), most.max(max));
            }
        }
        let worn: BTreeSet<usize> = primitives.iter().filter_map(|primitive| number(primitive.get("material"))).collect();
        if most > least {
            for material in worn {
                widths.entry(material).or_insert(most - least);
            }
        }
    }
    widths
}
