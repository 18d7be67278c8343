//! Why a file could not be read or written.

use burnish_material::FileError;
use std::fmt;
use std::path::PathBuf;

/// Why a file could not be read or written. Shown to the user as it is.
#[derive(Debug)]
pub enum FilesError {
    /// The system refused to read.
    Read {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The path is a folder, a pipe or a device, whose reading may never end.
    NotFile {
        /// What is there.
        path: PathBuf,
        /// What it is, with its article.
        found: &'static str,
    },
    /// The file is larger than anything of its kind should be.
    TooLarge {
        /// The file.
        path: PathBuf,
        /// What was expected at most.
        max_bytes: u64,
    },
    /// The system refused to write; the old file is as it was.
    Write {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// What was read back after writing differs from what was written; the old file is as it was.
    Differs {
        /// The file.
        path: PathBuf,
    },
    /// The file is not text in UTF-8.
    NotText {
        /// The file.
        path: PathBuf,
    },
    /// The file holds no material.
    NoMaterial {
        /// The file.
        path: PathBuf,
    },
    /// The text is not a material.
    Material {
        /// The file.
        path: PathBuf,
        /// Where and why.
        source: FileError,
    },
}

impl fmt::Display for FilesError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Read { path, source } => write!(f, "{}: cannot be read: {source}", path.display()),
            Self::NotFile { path, found } => write!(f, "{}: expected a file, found {found}", path.display()),
            Self::TooLarge { path, max_bytes } => {
                write!(f, "{}: expected a file of at most {max_bytes} bytes, found a larger one", path.display())
            }
            Self::Write { path, source } if source.kind() == std::io::ErrorKind::StorageFull => {
                write!(f, "{}: cannot be written: the disk is full; make room or choose another place", path.display())
            }
            Self::Write { path, source } => write!(f, "{}: cannot be written: {source}", path.display()),
            Self::Differs { path } => {
                write!(f, "{}: not saved, because what was read back differs from what was written", path.display())
            }
            Self::NotText { path } => write!(f, "{}: expected text in UTF-8, found other bytes", path.display()),
            Self::NoMaterial { path } => {
                write!(f, "{}: expected a material, or a picture that this program made of one, found neither", path.display())
            }
            Self::Material { path, source } => write!(f, "{}: {source}", path.display()),
        }
    }
}

impl std::error::Error for FilesError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Self::Read { source, .. } | Self::Write { source, .. } => Some(source),
            Self::Material { source, .. } => Some(source),
            Self::NotFile { .. }
            | Self::TooLarge { .. }
            | Self::Differs { .. }
            | Self::NotText { .. }
            | Self::NoMaterial { .. } => None,
        }
    }
}
