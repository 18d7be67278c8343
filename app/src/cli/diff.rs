//! `burnish diff`: what two materials differ in, value by value, and how they look beside each other.

use super::material_argument::load_file;
use super::scene_options::{SceneOptions, positive};
use super::target::{has_ending, refuse_target};
use super::{CliError, Messages, Outcome, interrupt, one_line, print_out};
use crate::files::save_atomic;
use crate::picture_diff::{self, Drawing};
use burnish_material::diff::{Change, file_changes};
use burnish_renderer::tonemap::Display;
use clap::Args;
use image::{ExtendedColorType, ImageEncoder, codecs::png::PngEncoder};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Arguments of `burnish diff`.
#[derive(Debug, Args)]
pub struct DiffArguments {
    /// Material file (.asm.ron) or preset:NAME
    #[arg(value_name = "A")]
    a: String,
    /// Material to compare it with
    #[arg(value_name = "B")]
    b: String,
    /// Draws both and their difference (FLIP, 0 dark blue to 1 yellow) beside each other
    #[arg(long, value_name = "FILE.png")]
    image: Option<PathBuf>,
    /// Seconds after which each of the two pictures is done, if its error is not below 2 % before
    #[arg(long, value_name = "SECONDS", default_value_t = 30.0, allow_hyphen_values = true, value_parser = positive)]
    time: f64,
    /// Prints one JSON object
    #[arg(long)]
    json: bool,
    /// What the materials are shown on.
    #[command(flatten)]
    scene: SceneOptions,
}

/// Compares, draws and prints. Exit code 1 where they differ.
pub fn run(arguments: &DiffArguments) -> Result<Outcome, CliError> {
    if let Some(path) = &arguments.image {
        if !has_ending(path, "png") {
            let sentence = format!("--image: {}: expected a file name that ends in .png", path.display());
            return Err(CliError::unusable(sentence));
        }
        refuse_target("--image", path)?;
    }
    let mut messages = Messages::default();
    let choice = arguments.scene.choice.as_deref();
    let a = load_file(&arguments.a, choice, &mut messages)?;
    let b = load_file(&arguments.b, choice, &mut messages)?;
    let changes = file_changes(&a, &b);
    let flip_mean = match &arguments.image {
        Some(path) => Some(draw(arguments, path, &mut messages)?),
        None => None,
    };
    if arguments.json {
        let rows: Vec<Value> = changes.iter().map(json_row).collect();
        let object = json!({
            "a": arguments.a,
            "b": arguments.b,
            "changed": rows,
            "image": arguments.image,
            "flip_mean": flip_mean,
            "warnings": messages.warnings(),
        });
        print_out(&object.to_string())?;
    } else {
        let rows: String = changes.iter().map(text_row).collect();
        let flip = flip_mean.map_or_else(String::new, |flip| format!("; FLIP of the pictures {flip:.4}"));
        let count = match changes.len() {
            0 => "no difference".to_owned(),
            1 => "1 difference".to_owned(),
            count => format!("{count} differences"),
        };
        print_out(&format!("{rows}{count}{flip}"))?;
    }
    Ok(if changes.is_empty() { Outcome::Done } else { Outcome::Findings })
}

fn text_row(change: &Change) -> String {
    let show = |side: &Option<String>| match (side, default_of(change)) {
        // Sources of values have several lines.
        (Some(text), _) => one_line(text),
        (None, Some(default)) => format!("{default} (default)"),
        (None, None) => "nothing".to_owned(),
    };
    format!("{}: {} -> {}\n", change.key, show(&change.a), show(&change.b))
}

fn json_row(change: &Change) -> Value {
    let value = |side: &Option<String>| match side {
        Some(text) => typed(text),
        None => default_of(change).unwrap_or(Value::Null),
    };
    json!({
        "property": change.key,
        "a": value(&change.a),
        "b": value(&change.b),
        "a_is_set": change.a.is_some(),
        "b_is_set": change.b.is_some(),
        "is_visible": change.is_visible,
    })
}

/// What a text of a material file means to other programs: numbers, lists and texts; anything else stays a text.
fn typed(text: &str) -> Value {
    ron::from_str(text).unwrap_or_else(|_| text.into())
}

/// The default of the value that was changed, if it is one of a property.
fn default_of(change: &Change) -> Option<Value> {
    let def = change.property?.def();
    (change.key == def.name).then_some(match def.default {
        burnish_material::Value::Float(x) => json!(x),
        burnish_material::Value::Bool(x) => json!(x),
        burnish_material::Value::Color(x) | burnish_material::Value::Normal(x) => json!(x),
    })
}

/// Renders both and writes them with their difference. Returns the mean of FLIP.
fn draw(arguments: &DiffArguments, path: &Path, messages: &mut Messages) -> Result<f64, CliError> {
    let options = &arguments.scene;
    let mut load = |text: &str| options.load(Some(text), None, messages);
    let (a, b) = (load(&arguments.a)?, load(&arguments.b)?);
    let drawing = Drawing {
        size: [a.width, a.height],
        seed: options.seed,
        threads: options.threads(),
        seconds: arguments.time,
        display: Display { exposure_ev: options.exposure_ev(), ..Display::default() },
    };
    let drawn = picture_diff::draw([&a.scene, &b.scene], &drawing, &mut |_| {}, &interrupt::is_interrupted);
    interrupt::check()?;
    let drawn = drawn.ok_or(CliError::Interrupted)?;
    let (bytes, width, height) = drawn.beside_each_other();
    let mut png = Vec::new();
    // Sides of pictures are far below the limit of PNG.
    PngEncoder::new(&mut png)
        .write_image(&bytes, width as u32, height as u32, ExtendedColorType::Rgb8)
        .map_err(|error| CliError::unusable(format!("--image: {}: cannot be written: {error}", path.display())))?;
    save_atomic(path, &png).map_err(CliError::unusable)?;
    Ok(drawn.mean)
}
