//! `burnish render`: one picture, by the path tracer or by the preview.
//!
//! Stop rules work together, the first to hit wins; with none given, 256 samples per pixel are taken.

pub use crate::offline::picture_options::{DEFAULT_SPP, transform};
pub use crate::offline::watch::error_text;

use super::material_argument::LoadedMaterial;
use super::progress_line::ProgressLine;
use super::repeat;
use super::scene_options::{LoadedScene, SceneOptions, positive};
use super::{CliError, Messages, Outcome, interrupt, print_out, target};
use crate::export::{self, Format};
use crate::offline::picture::{self, Order, Rendered, Repeat, View};
use crate::offline::picture_options::PictureOptions;
use crate::offline::watch::Watch;
use crate::picture_job::{PictureJob, Stop};
use clap::Args;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Arguments of `burnish render`.
#[derive(Clone, Debug, Default, PartialEq, Args)]
pub struct RenderArguments {
    /// Material file (.asm.ron), preset:NAME, or a picture of ours; may be left out with --scene. A picture with no option but --out is made again
    #[arg(value_name = "MATERIAL")]
    pub material: Option<String>,
    /// Picture to write: .png (display-referred sRGB) or .exr (linear Rec.709 radiance, no transform)
    #[arg(long, value_name = "FILE", required = true)]
    pub out: PathBuf,
    /// Path tracer (final) or rasteriser (preview)
    #[arg(long, value_name = "final|preview", default_value = "final", value_parser = view)]
    pub(super) view: View,
    /// Stops after this many samples per pixel [default without any stop rule: 256]
    #[arg(long, value_name = "N", allow_hyphen_values = true, value_parser = clap::value_parser!(u32).range(1..))]
    pub spp: Option<u32>,
    /// Stops after this many seconds of rendering
    #[arg(long, value_name = "SECONDS", allow_hyphen_values = true, value_parser = positive)]
    pub time: Option<f64>,
    /// Stops when the estimated relMSE is below this; a percentage is its square root (2% = 0.0004)
    #[arg(long, value_name = "RELMSE", allow_hyphen_values = true, value_parser = relmse)]
    pub error: Option<f64>,
    /// Prints one JSON object
    #[arg(long)]
    json: bool,
    /// What the picture holds.
    #[command(flatten)]
    pub picture: PictureOptions,
    /// What is drawn, and how large.
    #[command(flatten)]
    pub scene: SceneOptions,
}

/// Renders and writes one picture.
pub fn run(arguments: &RenderArguments) -> Result<Outcome, CliError> {
    if let Some(picture) = arguments.repeated() {
        let start = Instant::now();
        let mut messages = Messages::default();
        refuse_target(&arguments.out)?;
        let again = repeat::load(Path::new(picture), arguments, &mut messages)?;
        return finish(&again.arguments, &again.loaded, Some(&again.repeat), start, messages);
    }
    render(arguments, None)
}

/// Renders and writes one picture; of `material` where the arguments name none.
pub fn run_or_default(arguments: &RenderArguments, material: LoadedMaterial) -> Result<Outcome, CliError> {
    render(arguments, Some(material))
}

impl RenderArguments {
    /// The picture whose job is to be repeated: one in the place of the material, with no option that changes the picture.
    fn repeated(&self) -> Option<&str> {
        let material = self.material.as_deref().filter(|text| burnish_assets::is_image_path(Path::new(text)))?;
        let scene = SceneOptions { threads: self.scene.threads, ..SceneOptions::default() };
        let plain = Self { material: self.material.clone(), out: self.out.clone(), json: self.json, scene, ..Self::default() };
        (*self == plain).then_some(material)
    }

    fn order(&self, loaded: &LoadedScene) -> Order {
        Order {
            loaded: loaded.clone(),
            options: self.picture.clone(),
            exposure_ev: self.scene.exposure_ev(),
            seed: self.scene.seed,
            threads: self.scene.threads(),
            stop: Stop { spp: self.spp, seconds: self.time, relmse: self.error },
        }
    }

    /// The arguments that a job was made by.
    pub(super) fn of_job(&self, job: &PictureJob, picture: PictureOptions, scene: SceneOptions) -> Self {
        Self {
            out: self.out.clone(),
            json: self.json,
            view: if job.view == View::Preview.word() { View::Preview } else { View::Final },
            picture,
            scene,
            ..Self::default()
        }
    }
}

fn render(arguments: &RenderArguments, default: Option<LoadedMaterial>) -> Result<Outcome, CliError> {
    let start = Instant::now();
    let mut messages = Messages::default();
    refuse_target(&arguments.out)?;
    let loaded = arguments.scene.load_tiled(arguments.material.as_deref(), default, &mut messages)?;
    finish(arguments, &loaded, None, start, messages)
}

/// Renders what is loaded, as often before where `again` says so, and writes it.
fn finish(
    arguments: &RenderArguments,
    loaded: &LoadedScene,
    again: Option<&Repeat>,
    start: Instant,
    mut messages: Messages,
) -> Result<Outcome, CliError> {
    let loading_seconds = start.elapsed().as_secs_f64();
    if arguments.view == View::Preview && arguments.scene.threads.is_some() {
        messages.warn("--threads has no effect with --view preview");
    }
    let order = arguments.order(loaded);
    let mut line = ProgressLine::new();
    let made = picture::make(
        &order,
        arguments.view,
        &arguments.out,
        again,
        &mut Watch {
            is_cancelled: &interrupt::is_interrupted,
            warn: &mut |sentence| messages.warn(sentence),
            tell: &mut |step| line.show(|| step.text()),
        },
    );
    line.clear();
    let (mut rendered, files) = made?;
    rendered.load_seconds += loading_seconds;
    rendered.first_image_seconds += loading_seconds;
    report(arguments, &rendered, &files, &messages)?;
    Ok(Outcome::Done)
}

/// Fails early where the picture could not be written after minutes of rendering.
fn refuse_target(path: &Path) -> Result<(), CliError> {
    if Format::of(path).is_none() {
        return Err(CliError::unusable(export::ExportError::UnknownFormat { path: path.to_path_buf() }));
    }
    target::refuse_target("--out", path)
}

fn extend(object: &mut Value, more: serde_json::Map<String, Value>) {
    if let Some(object) = object.as_object_mut() {
        object.extend(more);
    }
}

fn report(arguments: &RenderArguments, rendered: &Rendered, files: &[PathBuf], messages: &Messages) -> Result<(), CliError> {
    let samples = rendered.picture.width as f64 * rendered.picture.height as f64 * f64::from(rendered.spp);
    if !arguments.json {
        let names: Vec<String> = files.iter().map(|file| file.display().to_string()).collect();
        let encoding = Format::of(&arguments.out).map_or_else(String::new, |format| format!("\n{}", format.encoding()));
        let error = rendered.error.as_ref().map_or_else(String::new, |error| format!(", {}", error_text(error)));
        let denoised = rendered.denoised.as_ref().map_or_else(String::new, |denoised| {
            format!(", denoised by {} in {:.1} s, estimated {}", denoised.denoiser, denoised.seconds, error_text(&denoised.error))
        });
        return print_out(&format!(
            "{} ({}x{}): {} spp in {:.1} s{error}{denoised}, stopped by {}{encoding}",
            names.join(", "),
            rendered.picture.width,
            rendered.picture.height,
            rendered.spp,
            rendered.seconds,
            rendered.stop_reason
        ));
    }
    let mut object = json!({
        "out": arguments.out,
        "files": files,
        "encoding": Format::of(&arguments.out).map(Format::encoding),
        "width": rendered.picture.width,
        "height": rendered.picture.height,
        "view": arguments.view.word(),
        "seconds": rendered.seconds,
        "load_seconds": rendered.load_seconds,
        "first_image_seconds": rendered.first_image_seconds,
        "adaptive": arguments.view == View::Final && !arguments.picture.no_adaptive,
        "denoiser": rendered.denoised.as_ref().map(|denoised| &denoised.denoiser),
        "denoise_seconds": rendered.denoised.as_ref().map(|denoised| denoised.seconds),
        "relmse_estimate_denoised": rendered.denoised.as_ref().map(|denoised| denoised.error.relmse),
        "relmse_low_denoised": rendered.denoised.as_ref().map(|denoised| denoised.error.low),
        "relmse_high_denoised": rendered.denoised.as_ref().map(|denoised| denoised.error.high),
        "samples_per_second": samples / rendered.seconds.max(1e-9),
        "threads": arguments.scene.threads(),
        "seed": arguments.scene.seed,
        "lobes": rendered.lobes.names(true),
        "left_out": rendered.lobes.names(false),
        "peak_memory_bytes": peak_memory_bytes(),
        "nonfinite_samples": rendered.nonfinite,
        "warnings": messages.warnings(),
    });
    extend(&mut object, export::reached(rendered.spp, Some(&rendered.stop_reason), rendered.error.as_ref()));
    print_out(&object.to_string())
}

/// Most memory this process has held, where the system tells (Linux).
pub fn peak_memory_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    let kibibytes: u64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kibibytes * 1024)
}

fn view(word: &str) -> Result<View, String> {
    match word {
        "final" => Ok(View::Final),
        "preview" => Ok(View::Preview),
        _ => Err("expected final or preview".to_owned()),
    }
}

/// A relMSE as a number, or as the percentage whose square it is.
pub fn relmse(text: &str) -> Result<f64, String> {
    let read = match text.trim().strip_suffix('%') {
        Some(percent) => positive(percent).map(|percent| (percent / 100.0).powi(2)),
        None => positive(text),
    };
    let expected = || "expected a relMSE above 0, such as 0.001, or a percentage, such as 2%".to_owned();
    // A square can become 0 although the percentage was not.
    read.ok().filter(|relmse| *relmse > 0.0).ok_or_else(expected)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_numbers_or_percentages() {
        assert_eq!(relmse("0.001"), Ok(0.001));
        assert!((relmse("2%").unwrap() - 0.0004).abs() < 1e-12);
        assert!((relmse("10 %").unwrap() - 0.01).abs() < 1e-12);
        for text in ["", "0", "-1", "NaN", "inf", "%", "1e-300%", "two"] {
            assert!(relmse(text).is_err(), "{text}");
        }
    }
}
