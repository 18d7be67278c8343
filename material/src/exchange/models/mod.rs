//! The shading models, one file each.

pub mod dassault;
pub mod disney_principled;
mod fates;
pub mod filament;
pub mod gltf;
pub mod gltf_pbr;
pub mod imageworks;
pub mod maps;
pub mod open_pbr;
pub mod specular_glossiness;
pub mod standard_surface;
pub mod usd_preview;
