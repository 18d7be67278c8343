//! Why a file cannot be read as USD.

use std::fmt;

use crate::exchange::short::short;

/// Largest text that is read, bytes.
pub const MAX_USDA_BYTES: usize = 64 << 20;
/// Most prims of a layer.
pub const MAX_PRIMS: usize = 500_000;
/// Most attributes and relationships of a layer.
pub const MAX_ATTRIBUTES: usize = 2_000_000;
/// Most sets of variants of a layer.
pub const MAX_VARIANT_SETS: usize = 10_000;
/// Most entries of one dictionary, and of the metadata of one prim or attribute.
pub const MAX_ENTRIES: usize = 10_000;
/// Longest name of a prim, an attribute or anything else, bytes.
pub const MAX_NAME_BYTES: usize = 1_000;
/// Deepest nesting of prims, dictionaries and variants.
pub const MAX_DEPTH: usize = 100;

/// Why bytes cannot be read as USD. The caller adds the file name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum UsdError {
    /// The binary form of USD.
    Binary,
    /// A package where a layer was expected.
    IsPackage,
    /// Neither of the three forms of USD.
    NotUsd,
    /// More text than is read.
    TooLarge {
        /// Size of the text.
        bytes: usize,
    },
    /// The text is no usda.
    Syntax {
        /// Line of the fault, from 1.
        line: usize,
        /// What was expected and found.
        message: String,
    },
    /// More than is read of something.
    TooMuch {
        /// Line where the limit was passed, from 1.
        line: usize,
        /// Of what, with the limit.
        what: String,
    },
    /// The zip archive of a usdz is not as it must be.
    Package {
        /// The file in the archive; empty where the archive itself is meant.
        entry: String,
        /// What was expected and found.
        message: String,
    },
}

impl fmt::Display for UsdError {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Binary => f.write_str(
                "expected USD as text (usda), found its binary form (usdc): convert it with `usdcat --flatten in.usdc --out out.usda`",
            ),
            Self::IsPackage => f.write_str("expected a layer of USD, found a package (usdz) in its place"),
            Self::NotUsd => f.write_str("expected a text that begins with `#usda 1.0`, or a usdz package, found neither"),
            Self::TooLarge { bytes } => write!(f, "expected a layer of at most {MAX_USDA_BYTES} bytes, found {bytes} bytes"),
            Self::Syntax { line, message } => write!(f, "line {line}: {message}"),
            Self::TooMuch { line, what } => write!(f, "line {line}: expected at most {what}, found more"),
            Self::Package { entry, message } if entry.is_empty() => write!(f, "usdz: {message}"),
            Self::Package { entry, message } => write!(f, "usdz: `{}`: {message}", short(entry)),
        }
    }
}

impl std::error::Error for UsdError {}
