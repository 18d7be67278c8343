//! A material's BSDF as shader code of its own: eval, sample and density, with only the lobes that it needs.
//!
//! Made from the WGSL that draws the preview ([`crate::bsdf`]): branches of lobes that are left out go, and what only they used; the
//! material's values and tables are written into the code. Other languages come from that text by way of naga; OSL is written on its
//! own, as closures of the same meaning.

mod comments;
mod conditions;
mod languages;
mod osl;
mod prune;
mod source;
mod tree;
mod types;

use burnish_material::{LobeSet, Material};
use source::Source;
use std::fmt;

/// Languages that shader code is written in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Language {
    /// Of WebGPU.
    Wgsl,
    /// Of Direct3D, shader model 6.0.
    Hlsl,
    /// Of OpenGL 4.5 and Vulkan.
    Glsl,
    /// Of Metal, version 2.0.
    Msl,
    /// Of Vulkan: a module with a compute shader that evaluates a list of directions.
    Spirv,
    /// Open Shading Language: closures instead of functions.
    Osl,
}

impl Language {
    /// All languages with the words of the command line.
    pub const ALL: [(Self, &'static str); 6] = [
        (Self::Wgsl, "wgsl"),
        (Self::Hlsl, "hlsl"),
        (Self::Glsl, "glsl"),
        (Self::Msl, "msl"),
        (Self::Spirv, "spirv"),
        (Self::Osl, "osl"),
    ];

    /// The word of the command line.
    pub fn word(self) -> &'static str {
        Self::ALL.iter().find(|(language, _)| *language == self).map_or("", |(_, word)| word)
    }

    /// The name for the user.
    pub fn label(self) -> &'static str {
        match self {
            Self::Wgsl => "WGSL",
            Self::Hlsl => "HLSL",
            Self::Glsl => "GLSL",
            Self::Msl => "MSL",
            Self::Spirv => "SPIR-V",
            Self::Osl => "OSL",
        }
    }
}

/// What may be chosen about the code.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ShaderOptions {
    /// Values lie in a uniform block (in OSL: are parameters) where the code can follow them; otherwise all are constants.
    pub is_uniform: bool,
}

/// Shader code.
#[derive(Clone, Debug)]
pub struct ShaderCode {
    /// Text in UTF-8, or a module of SPIR-V.
    pub bytes: Vec<u8>,
    /// Lobes that the material needs; the code holds those of them that are a matter of the BSDF.
    pub lobes: LobeSet,
}

/// The code could not be made: a fault of this program, which no material should lead to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ShaderError {
    /// Language that it was to be.
    pub language: Language,
    /// What was refused, and by whom.
    pub message: String,
}

impl fmt::Display for ShaderError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the material cannot be written as {}: {}", self.language.label(), self.message)
    }
}

impl std::error::Error for ShaderError {}

/// Writes a material as shader code. Images stay the caller's: it fills in what they hold at the point.
///
/// Takes up to a second where images vary several numbers that tables have to run over.
pub fn write(material: &Material, language: Language, options: ShaderOptions) -> Result<ShaderCode, ShaderError> {
    let lobes = LobeSet::of(material);
    let bytes = match language {
        Language::Osl => osl::text(material, options).into_bytes(),
        Language::Spirv => languages::spirv(&Source::new(material, options), material)?,
        _ => languages::text(&Source::new(material, options), material, language)?.into_bytes(),
    };
    Ok(ShaderCode { bytes, lobes })
}
