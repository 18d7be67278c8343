//! `burnish parity`: how far the preview is from the final view, and which property explains it.

use super::compare::write_heatmap;
use super::progress_line::ProgressLine;
use super::render::transform;
use super::scene_options::SceneOptions;
use super::target::{has_ending, refuse_target};
use super::{CliError, Messages, Outcome, interrupt, print_out};
use crate::parity::{Difference, Explained, Parity, ParityError, ParitySettings, Stage, compare, rank};
use burnish_renderer::preview;
use burnish_renderer::tonemap::{Display, DisplayTransform};
use clap::Args;
use serde_json::{Value, json};
use std::path::PathBuf;

/// Side of the pictures unless something says otherwise.
const SIDE: usize = 256;

/// Arguments of `burnish parity`.
#[derive(Debug, Args)]
pub struct ParityArguments {
    /// Material file (.asm.ron) or preset:NAME; may be left out with --scene
    #[arg(value_name = "MATERIAL")]
    material: Option<String>,
    /// Draws FLIP per pixel of the accumulated picture, 0 dark blue to 1 yellow
    #[arg(long, value_name = "FILE.png")]
    heatmap: Option<PathBuf>,
    /// Samples per pixel of the rays in the accumulated picture: at most 128, or 256 where light goes through the material
    #[arg(long, value_name = "N", default_value_t = 64, allow_hyphen_values = true, value_parser = clap::value_parser!(u32).range(1..=256))]
    spp: u32,
    /// Samples per pixel of each of the two finals
    #[arg(long, value_name = "N", default_value_t = 256, allow_hyphen_values = true, value_parser = clap::value_parser!(u32).range(1..))]
    final_spp: u32,
    /// Does not switch properties off to find which explains the difference
    #[arg(long)]
    no_ranking: bool,
    /// How radiance becomes the colours that FLIP compares
    #[arg(long, value_name = "neutral|agx|aces|standard", default_value = "neutral", value_parser = transform)]
    display_transform: DisplayTransform,
    /// Prints one JSON object
    #[arg(long)]
    json: bool,
    /// What is drawn, and how large.
    #[command(flatten)]
    scene: SceneOptions,
}

/// Compares, writes and prints.
pub fn run(arguments: &ParityArguments) -> Result<Outcome, CliError> {
    let mut messages = Messages::default();
    if let Some(path) = &arguments.heatmap {
        if !has_ending(path, "png") {
            let sentence = format!("--heatmap: {}: expected a file name that ends in .png", path.display());
            return Err(CliError::unusable(sentence));
        }
        refuse_target("--heatmap", path)?;
    }
    let loaded = arguments.scene.load(arguments.material.as_deref(), None, &mut messages)?;
    let is_sized = arguments.scene.size.is_some() || arguments.scene.scene.is_some();
    let (width, height) = if is_sized { (loaded.width, loaded.height) } else { (SIDE, SIDE) };
    let (adapter, device, queue) = preview::headless_device().map_err(CliError::unusable)?;
    let limit = device.limits().max_texture_dimension_2d as usize;
    if width > limit || height > limit {
        return Err(CliError::unusable(format!("--size: expected at most {limit} pixels for this GPU, found {width}x{height}")));
    }
    let settings = ParitySettings {
        width,
        height,
        samples: arguments.spp,
        final_samples: arguments.final_spp,
        seed: arguments.scene.seed,
        threads: arguments.scene.threads(),
        display: Display { exposure_ev: arguments.scene.exposure_ev(), transform: arguments.display_transform },
    };
    let mut line = ProgressLine::new();
    let mut go_on = |stage: Stage| {
        line.show(|| match stage {
            Stage::Final(number, spp) => format!("final {} of 2: {spp} of {} spp", number + 1, settings.final_samples),
            Stage::Preview(spp) => format!("preview: {spp} of {} spp", settings.samples),
            Stage::Ranking(property) => format!("without {}", property.def().name),
        });
        !interrupt::is_interrupted()
    };
    let parity = compare(&device, &queue, &loaded.scene, &settings, &mut go_on).map_err(cli_error)?;
    let ranked = match arguments.no_ranking {
        true => Vec::new(),
        false => rank(&device, &queue, &loaded.scene, &settings, &mut go_on).map_err(cli_error)?,
    };
    line.clear();
    if let Some(problem) = &parity.rays_problem {
        messages.warn(format!("no rays were traced: {problem}"));
    }
    if let Some(path) = &arguments.heatmap {
        write_heatmap(path, &parity.accumulated.flip, width)?;
    }
    let text = if arguments.json {
        object(arguments, &parity, &ranked, &adapter.get_info().name, (width, height), &messages).to_string()
    } else {
        table(&parity, &ranked)
    };
    print_out(&text)?;
    Ok(Outcome::Done)
}

fn cli_error(error: ParityError) -> CliError {
    match error {
        ParityError::Preview(error) => CliError::unusable(error),
        ParityError::Cancelled => CliError::Interrupted,
    }
}

fn object(
    arguments: &ParityArguments,
    parity: &Parity,
    ranked: &[Explained],
    adapter: &str,
    (width, height): (usize, usize),
    messages: &Messages,
) -> Value {
    let of = |d: &Difference| json!({ "flip_mean": d.flip_mean, "flip_p99": d.flip_p99, "mean": d.mean, "luminance_object": d.luminance[0], "luminance_rest": d.luminance[1] });
    let ranked: Vec<Value> = ranked.iter().map(|e| json!({ "property": e.property.def().name, "flip": e.flip })).collect();
    json!({
        "material": arguments.material,
        "scene": arguments.scene.scene,
        "width": width,
        "height": height,
        "flip_mean": parity.accumulated.flip_mean,
        "flip_p99": parity.accumulated.flip_p99,
        "mean_preview": parity.accumulated.mean,
        "mean_final": parity.mean_final,
        "noise_floor": parity.noise,
        "first": of(&parity.first),
        "accumulated": of(&parity.accumulated),
        "spp": parity.samples,
        "final_spp": arguments.final_spp,
        "ranked": ranked,
        "heatmap": arguments.heatmap,
        "adapter": adapter,
        "warnings": messages.warnings(),
    })
}

fn table(parity: &Parity, ranked: &[Explained]) -> String {
    let mut text = format!("{:<22} {:>9} {:>9} {:>9} {:>9}\n", "preview", "FLIP", "99 %", "object", "rest");
    for (name, d) in [("first picture", &parity.first), ("accumulated", &parity.accumulated)] {
        let [object, rest] = d.luminance.map(|x| x.map_or_else(|| "-".to_owned(), |x| format!("{:+.2} %", 100.0 * (x - 1.0))));
        text += &format!("{name:<22} {:>9.4} {:>9.4} {object:>9} {rest:>9}\n", d.flip_mean, d.flip_p99);
    }
    text += &format!("{:<22} {:>9.4}   between two finals\n", "noise", parity.noise);
    text += &format!("{} samples per pixel of rays\n", parity.samples);
    for e in ranked {
        text += &format!("{:+.4}  without {}\n", -e.flip, e.property.def().name);
    }
    text
}
