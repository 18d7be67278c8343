//! How light moves: one scene, two renderers. A wgpu preview and a progressive CPU path tracer share camera, material
//! interpretation, lobes and display transform.
//!
//! Lobes are plain functions over [`lanes::Lanes`]; their WGSL twins lie beside them. Rendering never changes a document.

pub mod bsdf;
pub mod bvh;
pub mod denoise;
pub mod lanes;
pub mod metrics;
pub mod path;
pub mod preview;
pub mod scene;
pub mod shader_code;
pub mod stability;
pub mod texel;
pub mod tonemap;
pub mod vector;
pub mod worker;

/// What changed in the bits of final pictures from version to version: entry `i` says what version `i + 2` does otherwise than the one before.
///
/// Whoever changes what the path tracer computes for the same job, be it by one rounding, adds a sentence.
pub const PICTURE_CHANGES: &[&str] = &[];

/// Version of the bits of final pictures: equal jobs give equal bits as long as this number is the same.
pub const PICTURE_VERSION: u32 = PICTURE_CHANGES.len() as u32 + 1;

pub use scene::{Camera, CameraBasis, EnvironmentLight, ModelMeshes, Object, Scene, TextureSet};
pub use tonemap::{Display, DisplayTransform};
