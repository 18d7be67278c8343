//! What a material stores for one property: a value, a texture, both or neither.

use crate::value::Value;

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
    /// directions only green is turned over, see [`Kind::inverted`](crate::Kind::inverted).
    pub is_inverted: bool,
    /// Factor by channel on what was read, after the inversion. Nothing in maps of directions.
    pub scale: [f64; 3],
    /// What is added to each channel after that. Nothing in maps of directions.
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
