//! The shading models, one file each.

pub mod disney_principled;
mod fates;
pub mod gltf;
pub mod open_pbr;
pub mod standard_surface;
pub mod usd_preview;
