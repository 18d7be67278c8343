//! glTF 2.0, as `.gltf` and `.glb`: materials to and from documents.
//!
//! [`write()`] makes a document of materials, each with what it was translated to, and [`Plan`] says which images it needs: files to copy,
//! and images to compute. [`read()`] finds the materials of a document, whoever wrote it. Images and files are the caller's.
//!
//! Every material carries its native copy in `extras.asm`; its record of the translation is what [`read()`] finds in the same document, so
//! that a file nobody touched gives back every bit. What a material of another program says beyond ASM is kept (`foreign`), and goes out
//! again beside properties that have not changed.

mod container;
mod document;
mod draft;
mod drafts;
mod error;
mod files;
mod foreign;
mod glossiness;
mod images;
mod json;
mod material;
mod mesh;
mod numbers;
mod plan;
mod read;
mod restore;
mod slots;
mod uri;
mod write;

pub use document::Written;
pub use error::{GltfError, Wrong};
pub use images::{Image, MAX_EMBEDDED_BYTES, Source};
pub use mesh::Mesh;
pub use plan::{Copy, Plan};
pub use read::{Document, Found, MAX_JSON_BYTES, MAX_JSON_VALUES, MAX_MATERIALS, MAX_TEXTURES, read};
pub use write::{Facts, Options, Part, write};
