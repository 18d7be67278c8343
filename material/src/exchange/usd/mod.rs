//! USD, as text (usda) and as a package (usdz): materials with their images, and meshes with their materials.
//!
//! An export holds three networks for each material: the shader of the Adobe Standard Material, which with the dictionary `asm` beside it is
//! the native copy, UsdPreviewSurface, and OpenPBR. [`read`] takes the first that it finds of them. The binary form (usdc) is refused with
//! a sentence that says how to convert it.

mod connections;
mod copy;
mod error;
mod geometry;
mod images;
mod layer;
mod lex;
mod materials;
mod numbers;
mod parse;
mod transform;
pub mod usdz;
mod values;
mod write;

use super::model::Notes;

pub use error::{MAX_PRIMS, MAX_USDA_BYTES, UsdError};
pub use geometry::{FoundMesh, MAX_MESHES, MAX_TRIANGLES, Part};
pub use materials::{FoundMaterial, MAX_MATERIALS};
pub use write::{ComputedImage, Export, MeshArrays, Options, write};

/// What a layer holds for a material editor.
#[derive(Clone, Debug)]
pub struct Scene {
    /// Its materials, in the order of the text.
    pub materials: Vec<FoundMaterial>,
    /// Its meshes, in the order of the text.
    pub meshes: Vec<FoundMesh>,
    /// Sentences for the user about what did not go as it stands in the file, those of the materials included.
    pub notes: Notes,
}

/// Reads the text of a layer.
pub fn read(text: &str) -> Result<Scene, UsdError> {
    let layer = parse::parse(text)?;
    let mut notes = layer.notes();
    let materials = materials::materials(&layer, &mut notes);
    notes.extend(materials.iter().flat_map(|material| material.notes.iter().cloned()));
    let meshes = geometry::meshes(&layer, &materials, &mut notes);
    Ok(Scene { materials, meshes, notes })
}

/// The text of a layer in these bytes; the binary form is refused.
pub fn layer_text(bytes: &[u8]) -> Result<&str, UsdError> {
    match bytes {
        _ if bytes.starts_with(b"PXR-USDC") => Err(UsdError::Binary),
        _ if bytes.starts_with(b"PK\x03\x04") => Err(UsdError::IsPackage),
        _ => std::str::from_utf8(bytes).map_err(|error| {
            let line = 1 + bytes[..error.valid_up_to()].iter().filter(|b| **b == b'\n').count();
            UsdError::Syntax { line, message: "expected UTF-8, found bytes that are none".to_owned() }
        }),
    }
}
