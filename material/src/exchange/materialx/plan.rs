//! Images that a document needs and that have to be computed first: the caller computes and writes them, texel by texel.

use crate::exchange::model::ShadingModel;
use crate::exchange::texture::Image;
use crate::properties::Inputs;
use crate::slot::ColorSpace;
use crate::value::Value;

/// An image to compute: at each texel the properties take their images' values, the model is translated, and the parameter's components
/// are stored.
#[derive(Clone, Debug, PartialEq)]
pub struct PlannedImage {
    /// Its file, relative to the document.
    pub file: String,
    /// What the red, green and blue channels hold: place of the parameter in the model's table, and component. One entry is a grey image.
    pub channels: Vec<(usize, usize)>,
    /// What the parameter's numbers are divided by before they are stored, so that they lie within 0 and 1.
    pub divisor: f64,
    /// How they are stored.
    pub color_space: ColorSpace,
}

impl PlannedImage {
    /// The image of a parameter, one component per channel.
    pub fn of(model: &ShadingModel, image: &Image, file: String, largest: f64) -> Option<Self> {
        let count = model.fields.get(image.field)?.default.numbers().len();
        let color_space = if count == 3 { ColorSpace::Srgb } else { ColorSpace::Linear };
        Some(Self { file, channels: (0..count).map(|k| (image.field, k)).collect(), divisor: largest.max(1.0), color_space })
    }
}

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
