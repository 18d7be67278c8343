//! The native copy beside a set: what its material holds, and what each image was when it was written.

use serde_json::{Value as Json, json};
use std::collections::BTreeMap;

use crate::exchange::model::Notes;
use crate::exchange::native;
use crate::material::Material;
use crate::properties::Property;
use crate::slot::{Channel, TextureRef};

/// Ending of its name, after the name of the set and a dot.
pub const ENDING: &str = "textures.json";
/// Longest text of a native copy that is read, in bytes.
pub const MAX_BYTES: usize = 64 << 20;

/// Why a text is no native copy of a set.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum SetError {
    /// The text is longer than [`MAX_BYTES`].
    TooLong {
        /// Its length in bytes.
        bytes: usize,
    },
    /// It is no JSON.
    NotJson {
        /// What the reader says.
        message: String,
    },
    /// It is another JSON.
    NoMaterial {
        /// What is wrong with its material.
        reason: String,
    },
}

impl std::fmt::Display for SetError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::TooLong { bytes } => write!(f, "expected a file of at most {MAX_BYTES} bytes, found {bytes}"),
            Self::NotJson { message } => write!(f, "expected the JSON of a texture set: {message}"),
            Self::NoMaterial { reason } => write!(f, "material: expected what a texture set of this program holds: {reason}"),
        }
    }
}

impl std::error::Error for SetError {}

/// A native copy.
#[derive(Clone, Debug)]
pub struct NativeSet {
    /// The material, with its images where the set has them.
    pub material: Material,
    /// Fingerprints of the images when they were written, by their names.
    pub images: BTreeMap<String, String>,
    /// What of it could not be read.
    pub notes: Notes,
}

/// An image in the folder of a set, and how a property reads it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Placed {
    /// Whose image it is.
    pub property: Property,
    /// Its name.
    pub file: String,
    /// The channels that are read.
    pub channel: Channel,
    /// Whether it is read inverted.
    pub is_inverted: bool,
}

/// The text of a native copy. `images`: a fingerprint by name of each image of the set.
pub fn write(material: &Material, images: &BTreeMap<String, String>) -> String {
    format!("{:#}\n", json!({ "material": native::write(material, None), "images": images }))
}

/// Reads a native copy.
pub fn read(text: &str) -> Result<NativeSet, SetError> {
    if text.len() > MAX_BYTES {
        return Err(SetError::TooLong { bytes: text.len() });
    }
    let json: Json = serde_json::from_str(text).map_err(|error| SetError::NotJson { message: error.to_string() })?;
    let mut notes = Notes::new();
    let native = json.get("material").and_then(|material| native::read(material, None, &mut notes));
    let Some(native) = native else {
        return Err(SetError::NoMaterial { reason: notes.pop().unwrap_or_else(|| "found none".to_owned()) });
    };
    let images = json.get("images").and_then(Json::as_object).into_iter().flatten();
    let images = images.filter_map(|(file, print)| Some((file.clone(), print.as_str()?.to_owned()))).collect();
    Ok(NativeSet { material: native.material, images, notes })
}

/// The material of a set. `found` are its images as they lie there now; `print_of` gives the fingerprint of one, `None` where it cannot be
/// read.
///
/// A property whose image is what it was has its native value, bit for bit. Where somebody changed the image or put one there, it holds,
/// and a note tells of it. Without a native copy the images are all there is.
pub fn merge(native: Option<NativeSet>, found: &[Placed], print_of: &dyn Fn(&str) -> Option<String>) -> (Material, Notes) {
    let Some(NativeSet { mut material, images, mut notes }) = native else {
        let mut material = Material::default();
        for placed in found {
            material.slot_mut(placed.property).texture = Some(placed.texture(None));
        }
        return (material, Notes::new());
    };
    for (file, print) in &images {
        let now = print_of(file);
        let moved: Vec<&Placed> = found.iter().filter(|placed| placed.file == *file).collect();
        let names: Vec<&str> = moved.iter().map(|placed| placed.property.def().name).collect();
        match now {
            None => notes.push(format!("the image `{file}` of the set cannot be read; the native copy holds")),
            Some(now) if now == *print => continue,
            Some(_) if moved.is_empty() => {
                notes.push(format!(
                    "another program changed the image `{file}`; no property reads it alone, so that the native copy holds"
                ));
            }
            Some(_) => notes.push(format!("{}: another program changed the image `{file}`; it holds", names.join(", "))),
        }
        if now.is_some() {
            moved.into_iter().for_each(|placed| placed.put(&mut material));
        }
    }
    for placed in found.iter().filter(|placed| !images.contains_key(&placed.file)) {
        notes.push(format!("{}: the image `{}` is new in the set; it holds", placed.property.def().name, placed.file));
        placed.put(&mut material);
    }
    (material, notes)
}

impl Placed {
    /// The reference, which wraps as the one before it.
    fn texture(&self, before: Option<&TextureRef>) -> TextureRef {
        let fresh = TextureRef::new(self.file.clone());
        TextureRef {
            channel: self.channel,
            is_inverted: self.is_inverted,
            wrap: before.map_or(fresh.wrap, |before| before.wrap),
            ..fresh
        }
    }

    fn put(&self, material: &mut Material) {
        let slot = material.slot_mut(self.property);
        slot.texture = Some(self.texture(slot.texture.as_ref()));
    }
}
