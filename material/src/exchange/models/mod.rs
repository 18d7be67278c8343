//! The shading models, one file each.

pub mod gltf;
pub mod open_pbr;
pub mod usd_preview;
