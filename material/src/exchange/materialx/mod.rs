//! MaterialX documents (`.mtlx`), version 1.39: materials to text and back.
//!
//! Every material is written twice: as a surface that other programs know, and as an instance of our own node, which holds it bit for bit
//! (`native_copy`). Both are read; where somebody changed the surface, the change holds. Graphs are folded (`walk`): what is constant becomes
//! a value, an image behind factors and offsets becomes a binding, and anything else is named in a note.
//!
//! Files that others wrote are read within bounds (`xml`). No file is opened: images are references for the caller to resolve, includes
//! are refused.

mod color;
mod definition;
mod fields;
mod foreign;
mod graph;
mod image;
mod native_copy;
mod nodes;
mod numbers;
mod read;
mod surfaces;
mod textures;
mod walk;
mod write;
mod xml;
mod xml_write;

pub use read::{MAX_MATERIALS, ReadMaterial, read};
pub use surfaces::{SURFACES, Surface};
pub use write::{WriteOptions, Written, WrittenMaterial, write};
pub use xml::{MAX_BYTES, MAX_DEPTH, MAX_ELEMENTS, ReadError};
