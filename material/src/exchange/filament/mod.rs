//! Material definitions of Filament (`.mat`): the lit model, as text.
//!
//! [`write()`] makes a definition whose fragment block sets the parameters; images are parameters of the material that the application binds,
//! and comments say which, as [`Written`] does. The native copy stands in a comment. [`read()`] takes that copy, and assignments of plain numbers; everything
//! else of a definition is a program, which is told and not read.

mod read;
mod write;

use super::model::Context;
use crate::material::Material;

pub use read::{FilamentError, MAX_BYTES, Read, read};
pub use write::{Bound, WriteOptions, Written, write};

/// What stands before the JSON of the native copy.
const NATIVE: &str = "// asm: ";

/// The context of a definition: no mesh, lengths of the material.
fn context(material: &Material) -> Context {
    Context::of(material)
}
