//! What is wrong with a file, in sentences for the user.

use std::fmt;

use serde_json::Value as Json;

/// Why a file is not read, or a document not written. The caller adds the file name.
#[derive(Clone, Debug, PartialEq)]
pub enum GltfError {
    /// More than a file of materials can need.
    TooMuch {
        /// What there is too much of: `bytes of JSON`, `materials`.
        what: &'static str,
        /// The most that is read.
        most: usize,
        /// What the file has.
        found: usize,
    },
    /// The text is not JSON.
    NotJson {
        /// Line of the fault, from 1.
        line: usize,
        /// Column of the fault, from 1.
        column: usize,
        /// What the JSON reader says.
        message: String,
    },
    /// The bytes are no binary glTF.
    NotBinary(Wrong),
    /// The JSON is no glTF 2.0.
    NotGltf(Wrong),
    /// The mesh cannot be written.
    Mesh(Wrong),
}

/// One thing that is not as it must be.
#[derive(Clone, Debug, PartialEq)]
pub struct Wrong {
    /// Where: a JSON pointer such as `/materials/0/alphaMode`, or a part of a binary file.
    pub place: String,
    /// What belongs there.
    pub expected: String,
    /// What stands there.
    pub found: String,
}

impl Wrong {
    pub(super) fn new(place: impl Into<String>, expected: impl Into<String>, found: impl Into<String>) -> Self {
        Self { place: place.into(), expected: expected.into(), found: found.into() }
    }

    /// Of a value in the JSON; `None` is one that is not there.
    pub(super) fn value(place: impl Into<String>, expected: impl Into<String>, found: Option<&Json>) -> Self {
        Self::new(place, expected, found.map_or_else(|| "nothing".to_owned(), described))
    }
}

/// A JSON value in a few words.
fn described(json: &Json) -> String {
    match json {
        Json::Null => "null".to_owned(),
        Json::Bool(_) => json.to_string(),
        Json::Number(number) => format!("the number {number}"),
        Json::String(text) => format!("the text \"{}\"", start_of(text)),
        Json::Array(list) => format!("a list of {}", list.len()),
        Json::Object(_) => "an object".to_owned(),
    }
}

/// The first letters of a text that may be long.
pub(super) fn start_of(text: &str) -> String {
    const MOST: usize = 60;
    let start: String = text.chars().take(MOST).flat_map(char::escape_default).collect();
    if text.chars().nth(MOST).is_some() { format!("{start}…") } else { start }
}

impl fmt::Display for Wrong {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{}: expected {}, found {}", self.place, self.expected, self.found)
    }
}

impl fmt::Display for GltfError {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::TooMuch { what, most, found } => write!(f, "expected at most {most} {what}, found {found}"),
            Self::NotJson { line, column, message } => write!(f, "line {line}, column {column}: not valid JSON: {message}"),
            Self::NotBinary(wrong) => write!(f, "not a binary glTF file: {wrong}"),
            Self::NotGltf(wrong) => write!(f, "not glTF 2.0: {wrong}"),
            Self::Mesh(wrong) => write!(f, "the mesh cannot be written: {wrong}"),
        }
    }
}

impl std::error::Error for GltfError {}
