//! Why a file could not be loaded.

use std::fmt;
use std::path::{Path, PathBuf};

/// Why a file could not be loaded; shown to the user as one sentence.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum AssetError {
    /// The file cannot be opened or read.
    Unreadable {
        /// The file.
        file: PathBuf,
        /// What the system says.
        problem: String,
    },
    /// The name does not end in one of the formats that are read for this purpose.
    UnknownFormat {
        /// The file.
        file: PathBuf,
        /// The endings that would do.
        expected: &'static str,
    },
    /// The contents are not what the format prescribes.
    Malformed {
        /// The file.
        file: PathBuf,
        /// Where in the file.
        place: String,
        /// What was expected there, and what was found instead.
        problem: String,
    },
    /// The file ends before what it announces.
    Truncated {
        /// The file.
        file: PathBuf,
        /// What is cut off.
        place: String,
        /// How much was expected, and how much was found.
        problem: String,
    },
    /// The file is in order, but uses a feature that is not supported.
    Unsupported {
        /// The file.
        file: PathBuf,
        /// Where in the file.
        place: String,
        /// The feature, and what to do instead.
        problem: String,
    },
    /// Data that the file refers to cannot be had.
    MissingData {
        /// The file.
        file: PathBuf,
        /// Where in the file.
        place: String,
        /// What is missing.
        problem: String,
    },
    /// Larger than this program is prepared to hold.
    TooLarge {
        /// The file.
        file: PathBuf,
        /// What it is and what the limit is.
        problem: String,
    },
    /// The file holds nothing that can be shown.
    Empty {
        /// The file.
        file: PathBuf,
        /// What was expected.
        expected: &'static str,
    },
    /// Somebody ended the loading.
    Ended {
        /// The file.
        file: PathBuf,
    },
}

impl AssetError {
    /// The file that could not be loaded.
    pub fn file(&self) -> &Path {
        match self {
            Self::Unreadable { file, .. }
            | Self::UnknownFormat { file, .. }
            | Self::Malformed { file, .. }
            | Self::Truncated { file, .. }
            | Self::Unsupported { file, .. }
            | Self::MissingData { file, .. }
            | Self::TooLarge { file, .. }
            | Self::Empty { file, .. }
            | Self::Ended { file } => file,
        }
    }

    pub(super) fn unreadable(file: &Path, problem: impl fmt::Display) -> Self {
        Self::Unreadable { file: file.to_owned(), problem: problem.to_string() }
    }

    pub(super) fn malformed(file: &Path, place: impl Into<String>, problem: impl Into<String>) -> Self {
        Self::Malformed { file: file.to_owned(), place: one_line(place.into()), problem: one_line(problem.into()) }
    }

    pub(super) fn truncated(file: &Path, place: impl Into<String>, problem: impl Into<String>) -> Self {
        Self::Truncated { file: file.to_owned(), place: one_line(place.into()), problem: one_line(problem.into()) }
    }

    pub(super) fn unsupported(file: &Path, place: impl Into<String>, problem: impl Into<String>) -> Self {
        Self::Unsupported { file: file.to_owned(), place: one_line(place.into()), problem: one_line(problem.into()) }
    }

    pub(super) fn missing(file: &Path, place: impl Into<String>, problem: impl Into<String>) -> Self {
        Self::MissingData { file: file.to_owned(), place: one_line(place.into()), problem: one_line(problem.into()) }
    }

    pub(super) fn too_large(file: &Path, problem: impl Into<String>) -> Self {
        Self::TooLarge { file: file.to_owned(), problem: problem.into() }
    }
}

/// What may quote the file: without line ends, and not too long.
pub(super) fn one_line(text: String) -> String {
    const LENGTH: usize = 300;
    let is_long = text.chars().nth(LENGTH).is_some();
    let line = text.chars().take(LENGTH).map(|c| if c.is_control() { ' ' } else { c });
    line.chain(is_long.then_some('…')).collect()
}

impl fmt::Display for AssetError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: ", self.file().display())?;
        match self {
            Self::Unreadable { problem, .. } => write!(f, "expected a readable file: {problem}."),
            Self::UnknownFormat { expected, .. } => write!(f, "expected a file name that ends in {expected}."),
            Self::Malformed { place, problem, .. }
            | Self::Truncated { place, problem, .. }
            | Self::Unsupported { place, problem, .. }
            | Self::MissingData { place, problem, .. } => write!(f, "{place}: {problem}."),
            Self::TooLarge { problem, .. } => write!(f, "{problem}."),
            Self::Empty { expected, .. } => write!(f, "expected {expected}, found none."),
            Self::Ended { .. } => f.write_str("loading was ended."),
        }
    }
}

impl std::error::Error for AssetError {}
