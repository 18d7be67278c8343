//! What all ways back to ASM share: defaults, and numbers brought into their range with a note.

use super::model::Notes;
use crate::material::Material;
use crate::properties::Inputs;

/// Every property at ASM's default.
pub fn default_inputs() -> Inputs<f64> {
    Material::default().inputs()
}

/// A number brought into [0, 1]. What lies outside by more than a rounding is told.
pub fn unit(name: &str, x: f64, notes: &mut Notes) -> f64 {
    let inside = if x.is_nan() { 0.0 } else { x.clamp(0.0, 1.0) };
    if (x - inside).abs() > 1e-6 {
        notes.push(format!("{name}: {x} was brought into 0 to 1"));
    }
    inside
}
