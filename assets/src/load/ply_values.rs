//! The numbers in a PLY file's data, one after the other, whatever their encoding.

use std::path::Path;

use super::AssetError;

/// How numbers are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    Ascii,
    LittleEndian,
    BigEndian,
}

impl Encoding {
    /// The encoding that a header calls `name`.
    pub(super) fn named(name: &str) -> Option<Self> {
        match name {
            "ascii" => Some(Self::Ascii),
            "binary_little_endian" => Some(Self::LittleEndian),
            "binary_big_endian" => Some(Self::BigEndian),
            _ => None,
        }
    }
}

/// The type of one number. All fit into an `f64` without loss.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ScalarType {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl ScalarType {
    /// The type that a header calls `name`.
    pub(super) fn named(name: &str) -> Option<Self> {
        match name {
            "char" | "int8" => Some(Self::I8),
            "uchar" | "uint8" => Some(Self::U8),
            "short" | "int16" => Some(Self::I16),
            "ushort" | "uint16" => Some(Self::U16),
            "int" | "int32" => Some(Self::I32),
            "uint" | "uint32" => Some(Self::U32),
            "float" | "float32" => Some(Self::F32),
            "double" | "float64" => Some(Self::F64),
            _ => None,
        }
    }

    /// Number of bytes in a binary file.
    pub(super) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }
}

/// What is left of the data.
pub(super) struct Values<'a> {
    file: &'a Path,
    encoding: Encoding,
    rest: &'a [u8],
}

impl<'a> Values<'a> {
    pub(super) fn new(file: &'a Path, encoding: Encoding, data: &'a [u8]) -> Self {
        Self { file, encoding, rest: data }
    }

    pub(super) fn bytes_left(&self) -> usize {
        self.rest.len()
    }

    /// The next number; `element` and `record` are for the message when there is none.
    pub(super) fn next(&mut self, kind: ScalarType, element: &str, record: usize) -> Result<f64, AssetError> {
        match self.encoding {
            Encoding::Ascii => self.next_word(element, record),
            Encoding::LittleEndian => self.next_binary(kind).ok_or_else(|| self.truncated(element, record)),
            Encoding::BigEndian => self.next_binary(kind).ok_or_else(|| self.truncated(element, record)),
        }
    }

    fn next_binary(&mut self, kind: ScalarType) -> Option<f64> {
        let (head, rest) = self.rest.split_at_checked(kind.size())?;
        self.rest = rest;
        // Little-endian order in the lowest bytes, whatever the file's own order is.
        let mut bytes = [0; 8];
        bytes[..head.len()].copy_from_slice(head);
        if self.encoding == Encoding::BigEndian {
            bytes[..head.len()].reverse();
        }
        let [a, b, c, d, ..] = bytes;
        Some(match kind {
            ScalarType::I8 => f64::from(i8::from_le_bytes([a])),
            ScalarType::U8 => f64::from(a),
            ScalarType::I16 => f64::from(i16::from_le_bytes([a, b])),
            ScalarType::U16 => f64::from(u16::from_le_bytes([a, b])),
            ScalarType::I32 => f64::from(i32::from_le_bytes([a, b, c, d])),
            ScalarType::U32 => f64::from(u32::from_le_bytes([a, b, c, d])),
            ScalarType::F32 => f64::from(f32::from_le_bytes([a, b, c, d])),
            ScalarType::F64 => f64::from_le_bytes(bytes),
        })
    }

    fn next_word(&mut self, element: &str, record: usize) -> Result<f64, AssetError> {
        let rest = self.rest.trim_ascii_start();
        let length = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        let (word, rest) = rest.split_at(length);
        self.rest = rest;
        if word.is_empty() {
            return Err(self.truncated(element, record));
        }
        let number = str::from_utf8(word).ok().and_then(|word| word.parse().ok());
        number.ok_or_else(|| {
            let found = String::from_utf8_lossy(&word[..word.len().min(40)]);
            self.malformed(element, record, format!("expected a number, found \"{}\"", found.escape_debug()))
        })
    }

    pub(super) fn malformed(&self, element: &str, record: usize, problem: String) -> AssetError {
        AssetError::malformed(self.file, format!("element {element}, record {record}"), problem)
    }

    fn truncated(&self, element: &str, record: usize) -> AssetError {
        let place = format!("element {element}, record {record}");
        AssetError::truncated(self.file, place, "expected another number, found the end of the file")
    }
}
