//! Images that a document needs and nobody has, and how each texel of them is computed. The caller does it: this crate opens no files.

use super::model::{Context, ShadingModel};
use super::texture::Image;
use crate::properties::{Inputs, Property};
use crate::value::{Kind, Value};

/// An image that has to be computed: a PNG with 8 or 16 bits per channel.
///
/// At each texel the properties in `from` take the values of their images, with all settings of their references; [`Self::texel`] then
/// says what to store. An image `from` nothing needs one texel only; others need as many as the largest image they are made of.
#[derive(Clone, Debug, PartialEq)]
pub struct Job {
    /// Where the document expects it: a path relative to its folder.
    pub file: String,
    /// Number of the material among those that are written.
    pub material: usize,
    /// Properties whose images it is made of.
    pub from: Vec<Property>,
    /// Whether all these images lie in the same way on the surface. Then a texel of the image is a texel of theirs, whatever their
    /// transforms and wrap modes, and the document says how the image lies. If not, the image covers uv from 0 to 1, and the transforms
    /// and wrap modes of the images apply.
    pub is_in_place: bool,
    /// Whether red, green and blue are stored by the sRGB curve. Alpha never is.
    pub is_srgb: bool,
    /// Red, green, blue and alpha; an image whose alpha is [`Texel::ONE`] needs none.
    pub channels: [Texel; 4],
}

/// What a channel of an image holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Texel {
    /// The same everywhere, 0 to 1.
    Constant(f64),
    /// A number of a parameter of the model, divided by the factor that stands beside the image.
    Number {
        /// The parameter, by its place in the model's table.
        field: usize,
        /// Which of its numbers.
        component: usize,
        /// The factor; above 0.
        factor: f64,
    },
    /// A component of a direction, -1 to 1.
    Direction {
        /// The parameter, by its place in the model's table.
        field: usize,
        /// Which of its numbers.
        component: usize,
    },
    /// The cosine of an angle, -1 to 1.
    Cosine {
        /// The parameter, by its place in the model's table.
        field: usize,
    },
    /// The sine of an angle, -1 to 1.
    Sine {
        /// The parameter, by its place in the model's table.
        field: usize,
    },
}

impl Texel {
    /// A channel that changes nothing.
    pub const ONE: Self = Self::Constant(1.0);

    fn of(self, values: &[Value]) -> f64 {
        let number = |field: usize, component: usize| {
            values.get(field).and_then(|value| value.numbers().get(component).copied()).unwrap_or(0.0)
        };
        let signed = |x: f64| 0.5 + 0.5 * x;
        match self {
            Self::Constant(x) => x,
            Self::Number { field, component, factor } => number(field, component) / factor,
            Self::Direction { field, component } => signed(number(field, component)),
            Self::Cosine { field } => signed(number(field, 0).cos()),
            Self::Sine { field } => signed(number(field, 0).sin()),
        }
    }
}

impl Job {
    /// The image of one parameter alone: its numbers in red, green and blue, divided by `factor`; colours by the sRGB curve. It covers uv from 0
    /// to 1. `None` where the model has no such parameter.
    pub fn of_parameter(model: &ShadingModel, image: &Image, file: String, factor: f64) -> Option<Self> {
        let default = model.fields.get(image.field)?.default;
        let (field, last) = (image.field, default.numbers().len().saturating_sub(1));
        let texel = |channel: usize| match default.kind() {
            Kind::Normal => Texel::Direction { field, component: channel },
            _ => Texel::Number { field, component: channel.min(last), factor: factor.max(f64::MIN_POSITIVE) },
        };
        let is_srgb = default.kind() == Kind::Color;
        let channels = [texel(0), texel(1), texel(2), Texel::ONE];
        Some(Self { file, material: 0, from: image.from.clone(), is_in_place: false, is_srgb, channels })
    }

    /// Parameters that the image is made for, by their places.
    pub fn fields(&self) -> impl Iterator<Item = usize> {
        self.channels.iter().filter_map(|channel| match channel {
            Texel::Constant(_) => None,
            Texel::Number { field, .. } | Texel::Direction { field, .. } | Texel::Cosine { field } | Texel::Sine { field } => {
                Some(*field)
            }
        })
    }

    /// Linear values of the four channels, 0 to 1, where the properties have these values. `model`: what the document translates to.
    pub fn texel(&self, model: &ShadingModel, inputs: &Inputs<f64>, context: &Context) -> [f64; 4] {
        let values = (model.translate)(inputs, context);
        let inside = |x: f64| if x.is_nan() { 0.0 } else { x.clamp(0.0, 1.0) };
        self.channels.map(|channel| inside(channel.of(&values)))
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
