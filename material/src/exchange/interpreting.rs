//! What all ways back to ASM share: defaults, and numbers brought into their range with a note.

use super::formulas as f;
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

/// Emission and its colour from their product. A colour within 0 to 1 stays as it is, so that an image of it does.
pub fn emission(product: [f64; 3]) -> (f64, [f64; 3]) {
    let product = product.map(|c| c.max(0.0));
    match f::largest(product) {
        most if most > 1.0 => (most, product.map(|c| c / most)),
        most if most > 0.0 => (1.0, product),
        _ => (0.0, [1.0; 3]),
    }
}

/// Sheen and its colour from their product, 0 to 1.
pub fn sheen(name: &str, product: [f64; 3], notes: &mut Notes) -> (f64, [f64; 3]) {
    f::split_amount(product.map(|c| unit(name, c, notes)))
}

/// Turns brought into [0, 1]; a full one is kept.
pub fn turn(turns: f64) -> f64 {
    if (0.0..=1.0).contains(&turns) { turns } else { turns.rem_euclid(1.0) }
}

/// Scattering distance and its scale by channel from a body's colour and its mean free paths, red shift and Rayleigh scattering off (5.6).
pub fn distances(color: [f64; 3], paths: [f64; 3], name: &str, notes: &mut Notes) -> (f64, [f64; 3]) {
    let scale = f::distance_scale(color, paths);
    if scale.iter().any(|s| *s > 1.0 + 1e-6) {
        notes.push(format!("{name}: a dark channel travels further than ASM lets it; shortened"));
    }
    (f::largest(paths), scale.map(|s| s.clamp(0.0, 1.0)))
}
