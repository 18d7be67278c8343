//! What files of other formats said that ASM has no place for.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

use crate::material::Material;

/// JSON texts by format, such as `gltf`, and key, such as `KHR_materials_iridescence`. No format is without keys.
pub type Foreign = BTreeMap<String, BTreeMap<String, String>>;

/// Most texts of other formats in a material.
pub const MAX_FOREIGN_TEXTS: usize = 1000;
/// Most bytes of all texts of other formats together.
pub const MAX_FOREIGN_BYTES: usize = 1 << 20;
/// Most bytes in the name of a format and in a key.
const MAX_NAME_BYTES: usize = 200;

/// Why a text of another format cannot be kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ForeignError {
    /// The format or the key is no name.
    Name,
    /// The text is not JSON.
    NotJson,
    /// There would be more than a material holds.
    TooMuch,
}

impl fmt::Display for ForeignError {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Name => write!(f, "expected names of at most {MAX_NAME_BYTES} bytes without control characters"),
            Self::NotJson => f.write_str("expected JSON as a text"),
            Self::TooMuch => write!(f, "expected at most {MAX_FOREIGN_TEXTS} texts of {MAX_FOREIGN_BYTES} bytes in all"),
        }
    }
}

impl std::error::Error for ForeignError {}

impl Material {
    /// What another format said at a key: JSON.
    pub fn foreign_text(&self, format: &str, key: &str) -> Option<&str> {
        self.foreign.get(format)?.get(key).map(String::as_str)
    }

    /// Sets what another format said at a key, or takes it out. An error leaves everything as it is.
    pub fn set_foreign(&mut self, format: &str, key: &str, text: Option<String>) -> Result<(), ForeignError> {
        let Some(text) = text else {
            if let Some(entries) = self.foreign.get_mut(format) {
                entries.remove(key);
                if entries.is_empty() {
                    self.foreign.remove(format);
                }
            }
            return Ok(());
        };
        if [format, key].iter().any(|name| name.len() > MAX_NAME_BYTES || name.chars().any(char::is_control)) {
            return Err(ForeignError::Name);
        }
        if text.len() > MAX_FOREIGN_BYTES {
            return Err(ForeignError::TooMuch);
        }
        // Read as a value, since that bounds the depth, too.
        serde_json::from_str::<serde_json::Value>(&text).map_err(|_| ForeignError::NotJson)?;
        let all = self.foreign.iter().flat_map(|(f, texts)| texts.iter().map(move |(k, text)| (f, k, text.len())));
        let others = all.filter(|(f, k, _)| (f.as_str(), k.as_str()) != (format, key));
        let (count, bytes) = others.fold((0, 0), |(count, bytes), (.., length)| (count + 1, bytes + length));
        if count >= MAX_FOREIGN_TEXTS || bytes + text.len() > MAX_FOREIGN_BYTES {
            return Err(ForeignError::TooMuch);
        }
        self.foreign.entry(format.to_owned()).or_default().insert(key.to_owned(), text);
        Ok(())
    }
}

/// Formats and keys of all texts of other formats.
pub(crate) fn keys(material: &Material) -> impl Iterator<Item = (&str, &str)> {
    material.foreign.iter().flat_map(|(format, texts)| texts.keys().map(|key| (format.as_str(), key.as_str())))
}

/// Formats and keys that stand in either of two materials and not with the same text in both.
pub(crate) fn differing<'a>(a: &'a Material, b: &'a Material) -> BTreeSet<(&'a str, &'a str)> {
    keys(a).chain(keys(b)).filter(|(format, key)| a.foreign_text(format, key) != b.foreign_text(format, key)).collect()
}

/// The key of an entry among those of a file: `foreign.gltf.KHR_materials_iridescence`.
pub(crate) fn entry_key(format: &str, key: &str) -> String {
    format!("foreign.{format}.{key}")
}
