//! What is lit and by what: meshes, environments and images, made by code or loaded from files.
//!
//! This crate knows nothing of materials, windows or GPUs, and prints nothing: what a loader finds strange it
//! returns as sentences, what it cannot read as an [`AssetError`].
//!
//! Conventions, everywhere: right-handed, +Y up, front faces counter-clockwise seen from outside, linear
//! Rec.709 colours. Texture coordinates follow images: (0, 0) is the upper left corner and v grows downwards.

mod environment;
mod environments;
mod image;
mod load;
mod mesh;
mod progress;
mod shapes;
mod tangents;
mod textures;

pub use crate::environment::Environment;
pub use crate::environments::{ENVIRONMENTS, EnvironmentDef, make_environment};
pub use crate::image::Image;
pub use crate::load::{
    AssetError, decode_image, decode_model, is_environment_path, is_image_path, is_model_path, load_environment, load_image,
    load_model, load_model_with,
};
pub use crate::mesh::{Bounds, Mesh, Model, Part, Role};
pub use crate::progress::{Ended, Progress};
pub use crate::shapes::{BACKDROPS, BackdropDef, SHAPES, ShapeDef, make_shape};
pub use crate::textures::{
    BUILT_IN_PREFIX, BuiltInTexture, MAX_CONTRAST, TEXTURES, TextureDef, TextureError, TextureMaker, TextureMap,
};
