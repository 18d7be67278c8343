//! Why a file of another format could not be read or written.

use crate::files::FilesError;
use burnish_assets::{AssetError, Ended};
use burnish_material::exchange::texture_set::copy::SetError;
use burnish_material::exchange::{filament, gltf, materialx, mdl, usd};
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
    /// No image of a folder has a name that says what it is.
    NoSet {
        /// The folder.
        path: PathBuf,
    },
    /// A folder cannot be read: a sentence that names it.
    Folder(String),
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
    /// Filament.
    Filament(filament::FilamentError),
    /// A texture set.
    Set(SetError),
    /// An image of it.
    Image(String),
}

impl fmt::Display for ExchangeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Files(error) => write!(f, "{error}"),
            Self::Mesh(error) => write!(f, "{error}"),
            Self::UnknownFormat { path } => {
                let expected = "expected a folder of images, or a name that ends in one of";
                write!(f, "{}: {expected} {}", path.display(), super::endings())
            }
            Self::Content { path, fault } => write!(f, "{}: {fault}", path.display()),
            Self::NoMesh { path } => write!(f, "{}: expected at least one mesh, found none", path.display()),
            Self::NoMaterial { path } => write!(f, "{}: expected at least one material, found none", path.display()),
            Self::NoSet { path } => {
                let expected = "expected images named after properties, such as wood_BaseColor.png, found none";
                write!(f, "{}: {expected}", path.display())
            }
            Self::Folder(sentence) => f.write_str(sentence),
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
            Self::Filament(error) => write!(f, "{error}"),
            Self::Set(error) => write!(f, "{error}"),
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
