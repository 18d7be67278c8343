//! `burnish shader`: a material's BSDF as shader code with only the lobes that it needs.

use super::material_argument::{load, load_file, preset_name};
use super::target::refuse_target;
use super::{CliError, Messages, Outcome, interrupt, print_out};
use crate::files::save_atomic;
use burnish_renderer::shader_code::{Language, ShaderOptions, write};
use clap::Args;
use serde_json::json;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Arguments of `burnish shader`.
#[derive(Debug, Args)]
pub struct ShaderArguments {
    /// Material file (.asm.ron), picture of ours or preset:NAME
    #[arg(value_name = "MATERIAL")]
    material: String,
    /// Which material of a file with several, by name or number from 1 [default: the first]
    #[arg(long = "material", value_name = "NAME|INDEX")]
    choice: Option<String>,
    /// Language of the code
    #[arg(long, value_name = "wgsl|hlsl|glsl|msl|spirv|osl", value_parser = language)]
    lang: Language,
    /// Where the code goes
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Puts values into a uniform block (OSL: parameters) where the code can follow them, instead of writing them as constants
    #[arg(long)]
    uniform: bool,
    /// Prints one JSON object
    #[arg(long)]
    json: bool,
}

/// Writes the code and prints what is in it.
pub fn run(arguments: &ShaderArguments) -> Result<Outcome, CliError> {
    refuse_target("--out", &arguments.out)?;
    let mut messages = Messages::default();
    let (text, choice) = (&arguments.material, arguments.choice.as_deref());
    // Images are the reader's, so only a picture that holds them is read with them.
    let is_picture = preset_name(text).is_none() && burnish_assets::is_image_path(Path::new(text));
    let material = match is_picture {
        true => load(text, choice, &mut messages)?.material,
        false => Arc::new(load_file(text, choice, &mut messages)?.material().clone()),
    };
    let options = ShaderOptions { is_uniform: arguments.uniform };
    let code = write(&material, arguments.lang, options).map_err(CliError::unusable)?;
    interrupt::check()?;
    save_atomic(&arguments.out, &code.bytes).map_err(CliError::unusable)?;
    let (lobes, left_out) = (code.lobes.names(true), code.lobes.names(false));
    let text = if arguments.json {
        json!({
            "out": arguments.out,
            "language": arguments.lang.word(),
            "lobes": lobes,
            "left_out": left_out,
            "bytes": code.bytes.len(),
            "warnings": messages.warnings(),
        })
        .to_string()
    } else {
        let list = |names: &[&str]| if names.is_empty() { "none".to_owned() } else { names.join(", ") };
        format!(
            "{}: {} bytes of {}; lobes: {}; left out: {}",
            arguments.out.display(),
            code.bytes.len(),
            arguments.lang.label(),
            list(&lobes),
            list(&left_out)
        )
    };
    print_out(&text)?;
    Ok(Outcome::Done)
}

fn language(word: &str) -> Result<Language, String> {
    let word = word.to_lowercase();
    let found = Language::ALL.into_iter().find(|(_, known)| *known == word).map(|(language, _)| language);
    found.ok_or_else(|| "expected wgsl, hlsl, glsl, msl, spirv or osl".to_owned())
}
