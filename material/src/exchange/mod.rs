//! Interchange: what a material becomes in other programs' formats, what comes back, and what is lost on the way.
//!
//! A *shading model* is a set of parameters with a meaning ([`model`], one row each in [`MODELS`]); a *format* is a way to write them
//! down (a module each). Every export carries the translation that others understand and a native copy that only this program reads
//! ([`native`]); [`merge`] decides on import, property by property, which of both holds. [`loss`] says what a translation costs.
//!
//! Text in, text out: files, images and meshes are the caller's.

pub mod field;
pub mod filament;
pub mod formulas;
pub mod gltf;
pub mod interpreting;
pub mod loss;
pub mod materialx;
pub mod mdl;
pub mod merge;
pub mod model;
pub mod models;
pub mod native;
pub mod page;
pub mod paths;
pub mod plan;
mod short;
pub mod texture;
pub mod texture_set;
pub mod usd;
pub mod uv;

pub use model::{MODELS, ShadingModel};
