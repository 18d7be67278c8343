//! What a material stores for one property: a value, a texture, both or neither.

use crate::value::{Kind, Value};

/// A value and an optional texture. Both absent means the property has its default and is not written.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Slot {
    /// Authored value; `None` uses the default of the table.
    pub value: Option<Value>,
    /// Texture that replaces the value over the surface.
    pub texture: Option<TextureRef>,
}

/// Reference to an image file and how it is read.
#[derive(Clone, Debug, PartialEq)]
pub struct TextureRef {
    /// Path as authored, with `/`; relative paths start at the folder of the material file. `builtin:TEXTURE/MAP`, such as
    /// `builtin:wood-oak/base_color` or `builtin:wood-oak/base_color?mean=0.4,0.3,0.2&contrast=0.5`, names a texture that comes with the
    /// program (`burnish_assets::TEXTURES`).
    pub path: String,
    /// Which channels are used. A colour reads three, a scalar one.
    pub channel: Channel,
    /// How stored values become linear ones.
    pub color_space: ColorSpace,
    /// Whether 1 - x is read for x, after `color_space` has made x linear: a map of gloss then serves as one of roughness. In maps of
    /// directions only green is turned over, which is what the two conventions of normal maps (+Y and -Y) differ in; the normal stays on
    /// its side.
    pub is_inverted: bool,
    /// Factor by channel on what was read, after the inversion; a scalar has the first. Nothing in maps of directions.
    pub scale: [f64; 3],
    /// What is added to each channel after that; to a scalar the first. Nothing in maps of directions.
    pub bias: [f64; 3],
    /// What lies outside the unit square.
    pub wrap: Wrap,
    /// Repetitions per unit of uv.
    pub uv_scale: [f64; 2],
    /// Shift in uv, after scale and rotation.
    pub uv_offset: [f64; 2],
    /// Counterclockwise rotation about the uv origin, degrees.
    pub uv_rotation: f64,
}

impl TextureRef {
    /// Where on the image a place of the surface lies: two rows of factors on u and v, and a shift. v grows downwards in both, so a
    /// counterclockwise turn has the sine below the diagonal negative.
    pub fn transform(&self) -> [[f64; 3]; 2] {
        let (sin, cos) = self.uv_rotation.to_radians().sin_cos();
        let ([su, sv], [ou, ov]) = (self.uv_scale, self.uv_offset);
        [[cos * su, sin * sv, ou], [-sin * su, cos * sv, ov]]
    }

    /// A reference to `path` with every setting at its default.
    pub fn new(path: impl Into<String>) -> Self {
        Self {
            path: path.into(),
            channel: Channel::Rgb,
            color_space: ColorSpace::Auto,
            is_inverted: false,
            scale: [1.0; 3],
            bias: [0.0; 3],
            wrap: Wrap::Repeat,
            uv_scale: [1.0; 2],
            uv_offset: [0.0; 2],
            uv_rotation: 0.0,
        }
    }

    /// What a property of a kind makes of linear red, green and blue, of which a scalar has its number in each: inversion, scale and bias.
    /// `None` where values are taken as they are. Numbers of the reference that are not finite count as their defaults.
    pub fn affine(&self, kind: Kind) -> Option<Affine> {
        let (scale, bias) = match kind {
            Kind::Color => (self.scale, self.bias),
            Kind::Float | Kind::Bool => ([self.scale[0]; 3], [self.bias[0]; 3]),
            Kind::Normal => ([1.0; 3], [0.0; 3]),
        };
        if !self.is_inverted && scale == [1.0; 3] && bias == [0.0; 3] {
            return None;
        }
        let mut affine = Affine { factor: [0.0; 3], summand: [0.0; 3] };
        for k in 0..3 {
            let scale = if scale[k].is_finite() { scale[k] } else { 1.0 };
            let bias = if bias[k].is_finite() { bias[k] } else { 0.0 };
            let is_turned = self.is_inverted && (kind != Kind::Normal || k == 1);
            // scale (1 - x) + bias
            let (factor, summand) = if is_turned { (-scale, scale + bias) } else { (scale, bias) };
            (affine.factor[k], affine.summand[k]) = (single(factor), single(summand));
        }
        Some(affine)
    }
}

fn single(x: f64) -> f32 {
    x.clamp(f64::from(f32::MIN), f64::from(f32::MAX)) as f32
}

/// A factor and a summand by channel, in the single precision of texels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Affine {
    factor: [f32; 3],
    summand: [f32; 3],
}

impl Affine {
    /// `factor x + summand`, within the range of single precision. What is not finite stays as it is.
    #[inline(always)]
    pub fn apply(&self, linear: [f32; 3]) -> [f32; 3] {
        std::array::from_fn(|k| {
            let x = linear[k];
            if x.is_finite() { (self.factor[k] * x + self.summand[k]).clamp(f32::MIN, f32::MAX) } else { x }
        })
    }
}

macro_rules! named_choice {
    ($(#[doc = $doc:literal])+ $name:ident { $( $(#[doc = $vdoc:literal])+ $variant:ident = $text:literal ),+ $(,)? }) => {
        $(#[doc = $doc])+
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum $name { $( $(#[doc = $vdoc])+ $variant ),+ }

        impl $name {
            /// All choices with the words that files use.
            pub const ALL: &[(Self, &'static str)] = &[$( (Self::$variant, $text) ),+];

            /// The word that files use.
            pub fn word(self) -> &'static str {
                match self { $( Self::$variant => $text ),+ }
            }

            /// The choice that a word in a file means.
            pub fn from_word(word: &str) -> Option<Self> {
                Self::ALL.iter().find(|(_, text)| *text == word).map(|(choice, _)| *choice)
            }
        }
    };
}

named_choice! {
    /// Channels of an image that a property reads.
    Channel {
        /// Red, green and blue; a scalar reads their mean.
        Rgb = "rgb",
        /// Red.
        R = "r",
        /// Green.
        G = "g",
        /// Blue.
        B = "b",
        /// Alpha.
        A = "a",
    }
}

named_choice! {
    /// How stored values become linear ones.
    ColorSpace {
        /// sRGB for colour properties in 8-bit files, linear otherwise.
        Auto = "auto",
        /// Decode the sRGB curve.
        Srgb = "srgb",
        /// Use as stored.
        Linear = "linear",
    }
}

named_choice! {
    /// What lies outside the unit square of uv.
    Wrap {
        /// The image again.
        Repeat = "repeat",
        /// The border pixels.
        Clamp = "clamp",
        /// The image, every other one mirrored.
        Mirror = "mirror",
    }
}
