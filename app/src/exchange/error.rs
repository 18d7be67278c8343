//! Why a file of another format could not be read or written.

use crate::files::FilesError;
use burnish_assets::{AssetError, Ended};
use burnish_material::exchange::{gltf, materialx, mdl, usd};
use std::fmt;
use std::path::PathBuf;

/// What went wrong. Shown to the user as it is.
#[derive(Debug)]
pub enum ExchangeError {
    /// The file itself.
    Files(FilesError),
    /// Its mesh.
    Mesh(AssetError),
    /// The name has no ending that is known.
    UnknownFormat {
        /// The file.
        path: PathBuf,
    },
    /// What the file holds.
    Content {
        /// The file.
        path: PathBuf,
        /// The fault.
        fault: Fault,
    },
    /// There is no mesh in it.
    NoMesh {
        /// The file.
        path: PathBuf,
    },
    /// There is no material in it.
    NoMaterial {
        /// The file.
        path: PathBuf,
    },
    /// Somebody ended it.
    Cancelled,
}

/// What is wrong with the contents of a file, by its format.
#[derive(Debug)]
pub enum Fault {
    /// glTF.
    Gltf(gltf::GltfError),
    /// MaterialX.
    MaterialX(materialx::ReadError),
    /// USD.
    Usd(usd::UsdError),
    /// MDL.
    Mdl(mdl::MdlError),
    /// An image of it.
    Image(String),
}

impl fmt::Display for ExchangeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Files(error) => write!(f, "{error}"),
            Self::Mesh(error) => write!(f, "{error}"),
            Self::UnknownFormat { path } => {
                write!(f, "{}: expected a name that ends in one of {}", path.display(), super::endings())
            }
            Self::Content { path, fault } => write!(f, "{}: {fault}", path.display()),
            Self::NoMesh { path } => write!(f, "{}: expected at least one mesh, found none", path.display()),
            Self::NoMaterial { path } => write!(f, "{}: expected at least one material, found none", path.display()),
            Self::Cancelled => f.write_str("cancelled; nothing was read or written"),
        }
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Gltf(error) => write!(f, "{error}"),
            Self::MaterialX(error) => write!(f, "{error}"),
            Self::Usd(error) => write!(f, "{error}"),
            Self::Mdl(error) => write!(f, "{error}"),
            Self::Image(sentence) => f.write_str(sentence),
        }
    }
}

impl std::error::Error for ExchangeError {}

impl From<Ended> for ExchangeError {
    fn from(_: Ended) -> Self {
        Self::Cancelled
    }
}

impl From<FilesError> for ExchangeError {
    fn from(error: FilesError) -> Self {
        Self::Files(error)
    }
}
