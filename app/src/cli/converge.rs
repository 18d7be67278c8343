//! `burnish converge`: error against run time, as JSON, as CSV or as a page with the curve.

use super::progress_line::ProgressLine;
use super::render::{error_text, peak_memory_bytes, transform};
use super::scene_options::{LoadedScene, SceneOptions, positive};
use super::target::{has_ending, refuse_target};
use super::{CliError, Messages, Outcome, interrupt, print_out};
use crate::curve::{self, Curve, Reference, ReferenceSource, Stage};
use crate::files::save_atomic;
use crate::picture_file::read_picture;
use burnish_renderer::path::{Settings, StopRules};
use burnish_renderer::tonemap::{Display, DisplayTransform};
use clap::Args;
use serde_json::json;
use std::path::{Path, PathBuf};

/// Seconds of rendering without a stop rule.
const DEFAULT_SECONDS: f64 = 10.0;

/// Arguments of `burnish converge`.
#[derive(Debug, Args)]
pub struct ConvergeArguments {
    /// Material file (.asm.ron) or preset:NAME; may be left out with --scene
    #[arg(value_name = "MATERIAL")]
    material: Option<String>,
    /// Report to write: .json (what --json prints), .csv, or .html (one page with the curve)
    #[arg(long, value_name = "FILE", required_unless_present = "json")]
    out: Option<PathBuf>,
    /// Stops the curve after this many seconds of rendering [default without --spp-max: 10]
    #[arg(long, value_name = "SECONDS", allow_hyphen_values = true, value_parser = positive)]
    seconds: Option<f64>,
    /// Stops the curve after this many samples per pixel
    #[arg(long, value_name = "N", allow_hyphen_values = true, value_parser = clap::value_parser!(u32).range(1..))]
    spp_max: Option<u32>,
    /// Compares with this picture; the noise of one of ours with a layer `variance` is taken off
    #[arg(long, value_name = "FILE", conflicts_with = "reference_spp")]
    reference: Option<PathBuf>,
    /// Compares with a rendering of another seed and this many samples per pixel, its noise taken off [default: 8 times the curve's largest count]
    #[arg(long, value_name = "N", allow_hyphen_values = true, value_parser = clap::value_parser!(u32).range(1..))]
    reference_spp: Option<u32>,
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

/// Measures, writes and prints.
pub fn run(arguments: &ConvergeArguments) -> Result<Outcome, CliError> {
    let mut messages = Messages::default();
    if let Some(out) = &arguments.out {
        if !["json", "csv", "html"].iter().any(|ending| has_ending(out, ending)) {
            let sentence = format!("--out: {}: expected a file name that ends in .json, .csv or .html", out.display());
            return Err(CliError::unusable(sentence));
        }
        refuse_target("--out", out)?;
    }
    let loaded = arguments.scene.load(arguments.material.as_deref(), None, &mut messages)?;
    let source = match &arguments.reference {
        Some(path) => ReferenceSource::Given(reference(path, &loaded, arguments.scene.seed, &mut messages)?),
        None => ReferenceSource::Own(arguments.reference_spp),
    };
    let has_rule = arguments.seconds.is_some() || arguments.spp_max.is_some();
    let seconds = if has_rule { arguments.seconds } else { Some(DEFAULT_SECONDS) };
    let settings = Settings {
        width: loaded.width,
        height: loaded.height,
        seed: arguments.scene.seed,
        threads: arguments.scene.threads(),
        stop: StopRules { spp: arguments.spp_max, seconds, relmse: None },
        is_adaptive: true,
    };
    let display = Display { exposure_ev: arguments.scene.exposure_ev(), transform: arguments.display_transform };
    let mut line = ProgressLine::new();
    let curve = curve::measure(&name(arguments), &loaded.scene, &settings, source, display, &mut |stage| {
        line.show(|| progress_text(stage, &settings.stop));
        !interrupt::is_interrupted()
    });
    line.clear();
    let curve = curve.ok_or(CliError::Interrupted)?;
    interrupt::check()?;
    if curve.nonfinite > 0 {
        messages.warn(format!("{} contributions were negative or not finite and were left out", curve.nonfinite));
    }
    let object = object(arguments, &curve, &messages);
    if let Some(out) = &arguments.out {
        let text = if has_ending(out, "json") {
            format!("{object}\n")
        } else if has_ending(out, "csv") {
            curve::csv(std::slice::from_ref(&curve))
        } else {
            curve::html("Error against run time", std::slice::from_ref(&curve))
        };
        save_atomic(out, text.as_bytes()).map_err(CliError::unusable)?;
    }
    print_out(&if arguments.json { object } else { table(arguments, &curve) })?;
    Ok(Outcome::Done)
}

/// What the curve is of: the material, the scene or both.
fn name(arguments: &ConvergeArguments) -> String {
    let scene = arguments.scene.scene.as_ref().map(|scene| scene.display().to_string());
    match (&arguments.material, scene) {
        (Some(material), Some(scene)) => format!("{material} in {scene}"),
        (Some(material), None) => material.clone(),
        (None, scene) => scene.unwrap_or_default(),
    }
}

/// A reference from a file.
fn reference(path: &Path, loaded: &LoadedScene, seed: u64, messages: &mut Messages) -> Result<Reference, CliError> {
    let unusable = |error| CliError::unusable(format!("--reference: {error}"));
    let picture = read_picture(path).map_err(unusable)?;
    picture.expect_size([loaded.width, loaded.height], "the curve").map_err(unusable)?;
    let job = |key: &str| picture.job.as_ref().and_then(|job| job[key].as_u64());
    if job("seed") == Some(seed) && picture.job.as_ref().is_some_and(|job| job["view"] == "final") {
        messages.warn_about(path, &format!("was made with seed {seed} as the curve is: errors come out too small"));
    }
    if picture.variance.is_none() {
        messages.warn_about(path, "has no layer `variance`: its own noise counts as error");
    }
    Ok(Reference {
        file: Some(path.display().to_string()),
        spp: job("spp").and_then(|spp| u32::try_from(spp).ok()),
        seed: job("seed"),
        seconds: None,
        pixels: picture.pixels,
        variance: picture.variance,
    })
}

fn progress_text(stage: &Stage<'_>, stop: &StopRules) -> String {
    match stage {
        Stage::Curve(state) => {
            let (spp, seconds) = (state.film.spp(), state.seconds);
            let by_time = stop.seconds.map(|end| end - seconds);
            let by_spp = stop.spp.map(|end| seconds / f64::from(spp.max(1)) * (f64::from(end) - f64::from(spp)));
            let left = by_time.into_iter().chain(by_spp).fold(f64::INFINITY, f64::min).max(0.0);
            let error = state.error.as_ref().map_or_else(String::new, |error| format!(", {}", error_text(error)));
            format!("curve: {spp} spp in {seconds:.1} s{error}, {left:.0} s left, then the reference")
        }
        Stage::Reference { spp, of, seconds } => {
            let left = seconds / f64::from((*spp).max(1)) * f64::from(of.saturating_sub(*spp));
            format!("reference: {spp} of {of} spp, {left:.0} s left")
        }
        Stage::Comparing => "comparing".to_owned(),
    }
}

/// What `--json` prints and `FILE.json` holds.
fn object(arguments: &ConvergeArguments, curve: &Curve, messages: &Messages) -> String {
    let mut object = json!({ "out": arguments.out, "material": arguments.material, "scene": arguments.scene.scene });
    let more = json!({ "peak_memory_bytes": peak_memory_bytes(), "warnings": messages.warnings() });
    for part in [curve::json(curve), more] {
        if let (Some(object), serde_json::Value::Object(part)) = (object.as_object_mut(), part) {
            object.extend(part);
        }
    }
    object.to_string()
}

/// The rows for people.
fn table(arguments: &ConvergeArguments, curve: &Curve) -> String {
    let mut text =
        format!("{:>10} {:>8} {:>11} {:>11} {:>11} {:>8}\n", "seconds", "spp", "relMSE", "trimmed", "estimate", "FLIP");
    for row in &curve.rows {
        let estimate = row.estimate.map_or_else(|| "-".to_owned(), |e| format!("{:.3e}", e.relmse));
        text += &format!(
            "{:>10.3} {:>8} {:>11.3e} {:>11.3e} {estimate:>11} {:>8.4}\n",
            row.seconds, row.spp, row.relmse, row.relmse_trimmed, row.flip
        );
    }
    let [targets, _] = curve.targets();
    for target in targets {
        if let Some(seconds) = target.seconds {
            let how = if target.is_extrapolated { " (predicted)" } else { "" };
            text += &format!("relMSE {}: {seconds:.2} s{how}\n", target.error);
        }
    }
    if let Some(out) = &arguments.out {
        text += &format!("{}\n", out.display());
    }
    text
}
