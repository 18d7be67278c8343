//! How bright images have to be that are computed for a document.

use crate::exchange::texture::Image;
use crate::properties::Inputs;
use crate::value::Value;

/// The largest number that a parameter takes while the images that decide about it run from 0 to 1: at the corners, which is exact where the
/// formula is a product of straight lines.
pub fn largest(image: &Image, inputs: &Inputs<f64>, value_of: impl Fn(&Inputs<f64>) -> Option<Value>) -> f64 {
    let corners = 1_usize << image.from.len().min(6);
    let corner = |corner: usize| {
        let mut inputs = *inputs;
        for (bit, property) in image.from.iter().enumerate().take(6) {
            let x = if corner >> bit & 1 == 1 { 1.0 } else { 0.0 };
            let value = match property.def().default {
                Value::Color(_) => Value::Color([x; 3]),
                Value::Float(_) => Value::Float(x),
                value => value,
            };
            inputs.set(*property, value);
        }
        value_of(&inputs).map_or(0.0, |value| value.numbers().iter().copied().filter(|x| x.is_finite()).fold(0.0, f64::max))
    };
    (0..corners).map(corner).fold(0.0, f64::max)
}
