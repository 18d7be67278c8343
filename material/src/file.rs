//! The lossless material file, `.asm.ron`: text to [`Material`] and back.
//!
//! The file keeps its source text. Saving is the source with the spans of what differs replaced, so comments, order,
//! number spelling, line ends and everything this version cannot read survive by construction, and an edit taken back
//! gives the starting bytes. This module opens no files: text in, text out.

mod edit;
mod read;
mod tree;
mod write;

use std::fmt;
use std::ops::Range;

use crate::material::Material;
use crate::properties::Property;
use crate::value::Value;
use tree::Block;
pub(crate) use write::{
    TEXTS, list, same_slot, same_texture, same_value, slot as slot_text, string, texture, value as value_text,
};

/// Version of the model that new files state.
pub const ASM_VERSION: &str = "4.0";

/// Largest text that is read, bytes. A material is a few kilobytes; this bounds time and memory on anything else.
pub const MAX_FILE_BYTES: usize = 16 << 20;

/// A material file: its source text and what was read from it.
#[derive(Clone, Debug)]
pub struct MaterialFile {
    text: String,
    material: Material,
    top: Block,
    properties: Option<Block>,
    unreadable: Vec<Unreadable>,
    unknown: Vec<String>,
    /// Values of the unknown keys.
    unknown_spans: Vec<Range<usize>>,
}

impl MaterialFile {
    /// A fresh file that holds `material`; values at their default are not written.
    pub fn new(material: &Material) -> Self {
        let skeleton = format!("{{\n    \"asm\": \"{ASM_VERSION}\",\n}}\n");
        let fresh = |text: String| match read::read(text) {
            Ok((file, _)) => file,
            Err(error) => unreachable!("the writer makes readable text: {error}"),
        };
        fresh(fresh(skeleton).to_text(material))
    }

    /// Reads a file. Strange values and keys cost a warning each; only text that is no material file is an error.
    pub fn parse(text: &str) -> Result<(Self, Vec<Warning>), FileError> {
        if text.len() > MAX_FILE_BYTES {
            return Err(FileError::TooLarge { bytes: text.len() });
        }
        read::read(text.to_owned())
    }

    /// The material as read. Values that could not be read are absent.
    pub fn material(&self) -> &Material {
        &self.material
    }

    /// The source text.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The source text with only what differs between `edited` and [`Self::material`] replaced.
    ///
    /// Numbers that changed are written as the shortest text that reads back as the same `f64`. Non-finite numbers are
    /// written as RON spells them, although reading refuses them: rereading then shows the loss instead of hiding it.
    pub fn to_text(&self, edited: &Material) -> String {
        write::to_text(self, edited)
    }

    /// Number of entries that differ: properties, and the texts and numbers beside them.
    pub fn changed(&self, edited: &Material) -> usize {
        write::changed(&self.material, edited)
    }

    /// Property values that stand in the file but could not be read.
    pub fn unreadable(&self) -> &[Unreadable] {
        &self.unreadable
    }

    /// Keys that mean nothing to this version, as paths such as `properties.velvet`. They are kept.
    pub fn unknown_keys(&self) -> &[String] {
        &self.unknown
    }

    /// What is kept in the file beside the material, as pairs of key and text: unknown keys in the order of the file, and entries of
    /// `sources` such as `sources.roughness`.
    pub fn other_entries(&self) -> Vec<(String, &str)> {
        let unknown = self.unknown.iter().zip(&self.unknown_spans).map(|(key, span)| (key.clone(), &self.text[span.clone()]));
        unknown.chain(read::sources(&self.text, &self.top)).collect()
    }

    /// Where the value of one property comes from, if the file says so under `sources`.
    pub fn source_of(&self, property: Property) -> Option<ValueSource> {
        read::source_of(&self.text, &self.top, property)
    }
}

/// Where one value comes from. Texts are empty where the file says nothing.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ValueSource {
    /// Dataset or person.
    pub dataset: String,
    /// Paper, standard or page.
    pub paper: String,
    /// How the value was obtained, with conversions.
    pub method: String,
    /// Licence of the data.
    pub licence: String,
    /// Lowest value among the datasets, of the property's own kind.
    pub spread_min: Option<Value>,
    /// Highest value among the datasets, of the property's own kind.
    pub spread_max: Option<Value>,
}

/// A value that stands in the file but could not be read. Its text is kept until the property is set.
#[derive(Clone, Debug, PartialEq)]
pub struct Unreadable {
    /// The property at its default because of this.
    pub property: Property,
    /// The text in the file, shortened if long.
    pub text: String,
    /// Line in the file, from 1.
    pub line: usize,
    /// What was expected and found.
    pub reason: String,
}

/// Something strange in a file that was read nevertheless.
#[derive(Clone, Debug, PartialEq)]
pub struct Warning {
    /// Line in the file, from 1.
    pub line: usize,
    /// Column in the file, from 1, in characters.
    pub column: usize,
    /// Key in the file, with the keys above it where the name alone is not clear.
    pub key: String,
    /// What was expected, what was found and what happens.
    pub message: String,
    /// Whether a value was refused. The editor shows the default; the command line stops.
    pub is_refused: bool,
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "line {}: {}: {}", self.line, self.key, self.message)
    }
}

/// Why a text is no material file. The caller adds the file name.
#[derive(Clone, Debug, PartialEq)]
pub enum FileError {
    /// More text than a material can need.
    TooLarge {
        /// Size of the text.
        bytes: usize,
    },
    /// The text is not RON.
    NotRon {
        /// Line of the fault, from 1.
        line: usize,
        /// Column of the fault, from 1.
        column: usize,
        /// What ron expected.
        message: String,
    },
    /// The text is RON, but no map.
    NotMap {
        /// Line of the value, from 1.
        line: usize,
        /// Column of the value, from 1.
        column: usize,
    },
    /// A key stands twice in one map, so it is unclear which value holds.
    DuplicateKey {
        /// Line of the second entry, from 1.
        line: usize,
        /// Line of the first entry, from 1.
        first_line: usize,
        /// The key with the keys above it.
        key: String,
    },
}

impl fmt::Display for FileError {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::TooLarge { bytes } => {
                write!(f, "expected a material file of at most {MAX_FILE_BYTES} bytes, found {bytes} bytes")
            }
            Self::NotRon { line, column, message } => write!(f, "line {line}, column {column}: not valid RON: {message}"),
            Self::NotMap { line, column } => {
                write!(f, "line {line}, column {column}: expected a map {{ \"asm\": \"{ASM_VERSION}\", … }}, found another value")
            }
            Self::DuplicateKey { line, first_line, key } => {
                write!(f, "line {line}: {key}: expected each key once, but it already stands in line {first_line}")
            }
        }
    }
}

impl std::error::Error for FileError {}
