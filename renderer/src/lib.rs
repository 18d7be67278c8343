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
pub mod stability;
pub mod tonemap;
pub mod vector;
pub mod worker;

pub use scene::{Camera, CameraBasis, EnvironmentLight, ModelMeshes, Object, Scene, TextureSet};
pub use tonemap::{Display, DisplayTransform};
