//! What an Adobe Standard Material 4.0 is: properties, document, file text, lobes.
//!
//! This crate opens no files, starts no threads and knows neither a window nor a GPU: text in, text out.

mod check;
pub mod diff;
pub mod exchange;
mod file;
mod foreign;
mod lobes;
mod material;
pub mod merge;
mod properties;
mod reference;
mod slot;
mod value;
mod wgsl;

pub use check::{Finding, FindingKind, Severity, check, has_errors};
pub use file::{ASM_VERSION, FileError, MAX_FILE_BYTES, MaterialFile, Unreadable, ValueSource, Warning};
pub use foreign::{Foreign, ForeignError, MAX_FOREIGN_BYTES, MAX_FOREIGN_TEXTS};
pub use lobes::{LOBES, Lobe, LobeDef, LobeSet, acts_through, idle_lobe};
pub use material::{DEFAULT_UNIT_MM, Material, Provenance};
pub use properties::{Inputs, PROPERTIES, PROPERTY_COUNT, Property};
pub use reference::reference_page;
pub use slot::{Affine, Channel, ColorSpace, Slot, TextureRef, Wrap};
pub use value::{Group, Kind, LimitKind, Limits, PropertyDef, Unit, Value, Vary};
pub use wgsl::{ASM_MATERIAL_WGSL, inputs_wgsl};
