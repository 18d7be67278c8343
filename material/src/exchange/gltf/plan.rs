//! Which images a document needs, and how those that do not exist are computed. The caller does it: this crate opens no files.

use crate::exchange::model::Context;
use crate::exchange::models::gltf::MODEL;
use crate::properties::{Inputs, Property};
use crate::value::Value;

/// All images of a document.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Plan {
    /// Files that are taken as they are.
    pub copies: Vec<Copy>,
    /// Images that have to be computed.
    pub jobs: Vec<Job>,
    /// What comes out different, in sentences for the user.
    pub notes: Vec<String>,
}

/// A file that a document uses, or keeps for the native copies in it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Copy {
    /// Path as the material has it: a file, or an image of this program (`builtin:…`), which is written as PNG.
    pub path: String,
    /// Where the document expects it: a path relative to its folder.
    pub file: String,
    /// Whether a texture of the document uses it; if not, it is there for the native copy.
    pub is_used: bool,
}

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
    /// Linear values of the four channels, 0 to 1, where the properties have these values.
    pub fn texel(&self, inputs: &Inputs<f64>, context: &Context) -> [f64; 4] {
        let values = (MODEL.translate)(inputs, context);
        let inside = |x: f64| if x.is_nan() { 0.0 } else { x.clamp(0.0, 1.0) };
        self.channels.map(|channel| inside(channel.of(&values)))
    }
}
