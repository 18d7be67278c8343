//! What an Adobe Standard Material 4.0 is: properties, document, file text, lobes.
//!
//! This crate opens no files, starts no threads and knows neither a window nor a GPU: text in, text out.

mod lobes;
mod material;
mod properties;
mod slot;
mod value;

pub use lobes::{LOBES, Lobe, LobeDef, LobeSet};
pub use material::{DEFAULT_UNIT_MM, Material, Provenance};
pub use properties::{Inputs, PROPERTIES, PROPERTY_COUNT, Property};
pub use slot::{Channel, ColorSpace, Slot, TextureRef, Wrap};
pub use value::{Group, Kind, LimitKind, Limits, PropertyDef, Unit, Value, Vary};
