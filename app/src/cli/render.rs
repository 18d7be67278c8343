//! `burnish render`: one picture, by the path tracer or by the preview.
//!
//! Stop rules work together, the first to hit wins; with none given, 256 samples per pixel are taken.

use super::material_argument::LoadedMaterial;
use super::progress_line::ProgressLine;
use super::scene_options::{LoadedScene, SceneOptions, positive};
use super::{CliError, Messages, Outcome, interrupt, print_out, target};
use crate::export::{self, Format, Layer, LayerKind, Picture};
use burnish_material::{LOBES, Lobe, LobeSet, Material, MaterialFile, Property, TextureRef};
use burnish_renderer::denoise::{self, DenoiseError, Denoiser, Oidn};
use burnish_renderer::path::{self, ErrorEstimate, Film, Prepared, Progress, Settings, StopReason, StopRules};
use burnish_renderer::preview::{self, Preview};
use burnish_renderer::scene::Scene;
use burnish_renderer::tonemap::{Display, DisplayTransform};
use clap::Args;
use glam::Vec3;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

/// Samples per pixel without a stop rule: enough for a picture without visible grain of most materials.
pub const DEFAULT_SPP: u32 = 256;

/// Frames of the preview without a stop rule; it settles earlier by itself.
const PREVIEW_FRAMES: u32 = 4096;

/// Arguments of `burnish render`.
#[derive(Debug, Default, Args)]
pub struct RenderArguments {
    /// Material file (.asm.ron) or preset:NAME; may be left out with --scene
    #[arg(value_name = "MATERIAL")]
    pub material: Option<String>,
    /// Picture to write: .png (display-referred sRGB) or .exr (linear radiance)
    #[arg(long, value_name = "FILE", required = true)]
    pub out: PathBuf,
    /// Path tracer (final) or rasteriser (preview)
    #[arg(long, value_name = "final|preview", default_value = "final", value_parser = view)]
    view: View,
    /// Stops after this many samples per pixel [default without any stop rule: 256]
    #[arg(long, value_name = "N", allow_hyphen_values = true, value_parser = clap::value_parser!(u32).range(1..))]
    pub spp: Option<u32>,
    /// Stops after this many seconds of rendering
    #[arg(long, value_name = "SECONDS", allow_hyphen_values = true, value_parser = positive)]
    pub time: Option<f64>,
    /// Stops when the estimated relMSE is below this; a percentage is its square root (2% = 0.0004)
    #[arg(long, value_name = "RELMSE", allow_hyphen_values = true, value_parser = relmse)]
    pub error: Option<f64>,
    /// Gives every pixel the same number of samples
    #[arg(long)]
    no_adaptive: bool,
    /// Further layers: channels of an .exr, or files NAME.LAYER.png beside a .png
    #[arg(long, value_name = "albedo,normal,depth,variance,samples", value_delimiter = ',', value_parser = layer)]
    aov: Vec<LayerKind>,
    /// Leaves lobes out also where they are needed, to see what they add (names: `burnish features`)
    #[arg(long, value_name = "LOBE,...", value_delimiter = ',', value_parser = lobe)]
    without: Vec<Lobe>,
    /// Finds caustics by paths from the camera alone, to see what tracing them from the light is worth
    #[arg(long)]
    no_photons: bool,
    /// Leaves the background out; the picture gets an alpha channel
    #[arg(long)]
    transparent: bool,
    /// How radiance becomes colours in a .png
    #[arg(long, value_name = "neutral|agx|aces|standard", default_value = "neutral", value_parser = transform)]
    display_transform: DisplayTransform,
    /// Writes the picture denoised and the raw one beside it: NAME.raw.png, or channels raw.R, raw.G, raw.B of an .exr;
    /// auto is Open Image Denoise where it is installed (BURNISH_OIDN may say where), else the own filter
    #[arg(long, value_name = "auto|burnish|oidn", num_args = 0..=1, require_equals = true, default_missing_value = "auto", value_parser = denoiser)]
    denoise: Option<Denoise>,
    /// Not in this version
    #[arg(long = "material", value_name = "NAME|INDEX", hide = true)]
    choice: Option<String>,
    /// Prints one JSON object
    #[arg(long)]
    json: bool,
    /// What is drawn, and how large.
    #[command(flatten)]
    pub scene: SceneOptions,
}

fn lobe(text: &str) -> Result<Lobe, String> {
    let names = || LOBES.iter().map(|def| def.name).collect::<Vec<_>>().join(", ");
    LOBES.iter().find(|def| def.name == text).map(|def| def.lobe).ok_or_else(|| format!("expected one of {}", names()))
}

/// Which renderer draws.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum View {
    #[default]
    Final,
    Preview,
}

/// Which filter `--denoise` takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Denoise {
    Auto,
    Own,
    Oidn,
}

/// What is told about a denoised picture.
struct DenoiseReport {
    denoiser: String,
    seconds: f64,
    error: ErrorEstimate,
}

/// Linear radiance without noise, and what is told about it.
type DenoisedFilm = (Vec<[f32; 3]>, DenoiseReport);

/// A picture and what is told about its making.
struct Rendered {
    picture: Picture,
    spp: u32,
    seconds: f64,
    first_image_seconds: f64,
    load_seconds: f64,
    stop_reason: &'static str,
    error: Option<ErrorEstimate>,
    /// `None` where the picture is the raw one.
    denoised: Option<DenoiseReport>,
    nonfinite: u64,
    lobes: LobeSet,
}

impl Rendered {
    fn reached(&self) -> serde_json::Map<String, Value> {
        export::reached(self.spp, Some(self.stop_reason), self.error.as_ref())
    }
}

/// Renders and writes one picture.
pub fn run(arguments: &RenderArguments) -> Result<Outcome, CliError> {
    render(arguments, None)
}

/// Renders and writes one picture; of `material` where the arguments name none.
pub fn run_or_default(arguments: &RenderArguments, material: LoadedMaterial) -> Result<Outcome, CliError> {
    render(arguments, Some(material))
}

fn render(arguments: &RenderArguments, default: Option<LoadedMaterial>) -> Result<Outcome, CliError> {
    let start = Instant::now();
    let mut messages = Messages::default();
    refuse_later_options(arguments)?;
    refuse_target(&arguments.out)?;
    let loaded = arguments.scene.load(arguments.material.as_deref(), default, &mut messages)?;
    let loading_seconds = start.elapsed().as_secs_f64();

    let mut rendered = match arguments.view {
        View::Final => final_view(arguments, &loaded, &mut messages)?,
        View::Preview => preview(arguments, &loaded, &mut messages)?,
    };
    interrupt::check()?;
    rendered.load_seconds += loading_seconds;
    rendered.first_image_seconds += loading_seconds;
    if rendered.nonfinite > 0 {
        messages.warn(format!("{} contributions were negative or not finite and were left out", rendered.nonfinite));
    }
    rendered.picture.has_alpha = arguments.transparent;
    rendered.picture.job = Some(job(arguments, &loaded, &rendered));

    let display = Display { exposure_ev: arguments.scene.exposure_ev(), transform: arguments.display_transform };
    let files = export::write(&arguments.out, &rendered.picture, display).map_err(CliError::unusable)?;
    report(arguments, &rendered, &files, &messages)?;
    Ok(Outcome::Done)
}

/// Options of the contract whose engine comes later.
fn refuse_later_options(arguments: &RenderArguments) -> Result<(), CliError> {
    match arguments.choice {
        Some(_) => Err(CliError::unusable("--material: not in this version; expected the options that --help lists")),
        None => Ok(()),
    }
}

/// Fails early where the picture could not be written after minutes of rendering.
fn refuse_target(path: &Path) -> Result<(), CliError> {
    if Format::of(path).is_none() {
        return Err(CliError::unusable(export::ExportError::UnknownFormat { path: path.to_path_buf() }));
    }
    target::refuse_target("--out", path)
}

fn final_view(arguments: &RenderArguments, loaded: &LoadedScene, messages: &mut Messages) -> Result<Rendered, CliError> {
    for sentence in left_out(&loaded.scene) {
        messages.warn(sentence);
    }
    let has_rule = arguments.spp.is_some() || arguments.time.is_some() || arguments.error.is_some();
    let spp = if has_rule { arguments.spp } else { Some(DEFAULT_SPP) };
    let settings = Settings {
        width: loaded.width,
        height: loaded.height,
        seed: arguments.scene.seed,
        threads: arguments.scene.threads(),
        stop: StopRules { spp, seconds: arguments.time, relmse: arguments.error },
        is_adaptive: !arguments.no_adaptive,
    };
    let mut line = ProgressLine::new();
    let less = arguments.without.iter().fold(LobeSet::EMPTY, |set, lobe| set.with(*lobe));
    let start = Instant::now();
    let prepared = Prepared::with_lobes(&loaded.scene, None, LobeSet::EMPTY, less);
    let prepared = if arguments.no_photons { prepared.without_photons() } else { prepared };
    let rendering = path::render_prepared(&prepared, &settings, start, &mut |progress| {
        line.show(|| progress_text(progress));
        !interrupt::is_interrupted()
    });
    line.clear();
    if matches!(rendering.stop_reason, StopReason::Cancelled) {
        return Err(CliError::Interrupted);
    }
    let film = &rendering.film;
    let developed = |mean: &[[f32; 3]]| {
        if arguments.transparent { without_background(&loaded.scene, mean, film) } else { opaque(mean) }
    };
    let mut pixels = developed(&film.mean());
    let (mut raw, mut denoised) = (None, None);
    if let Some(choice) = arguments.denoise
        && let Some((picture, report)) = denoise_film(choice, film, &prepared, settings.threads, messages)?
    {
        raw = Some(std::mem::replace(&mut pixels, developed(&picture)));
        denoised = Some(report);
    }
    let mut layers = Vec::new();
    if !arguments.aov.is_empty() {
        let surfaces = surfaces(arguments, loaded);
        for (i, kind) in arguments.aov.iter().enumerate() {
            if arguments.aov[..i].contains(kind) {
                continue;
            }
            let planes = match kind {
                LayerKind::Albedo => split(&surfaces.albedo),
                LayerKind::Normal => split(&surfaces.normal),
                LayerKind::Depth => vec![surfaces.depth.clone()],
                LayerKind::Variance => split(&film.variance()),
                LayerKind::Samples => vec![film.samples().into_iter().map(|count| count as f32).collect()],
            };
            layers.push(Layer { kind: *kind, planes });
        }
    }
    Ok(Rendered {
        picture: Picture { width: loaded.width, height: loaded.height, pixels, raw, layers, ..Picture::default() },
        spp: film.spp(),
        seconds: rendering.seconds,
        first_image_seconds: rendering.first_image_seconds,
        load_seconds: rendering.load_seconds,
        stop_reason: rendering.stop_reason.word(),
        error: rendering.error,
        denoised,
        nonfinite: rendering.nonfinite,
        lobes: lobes(&loaded.scene, LobeSet::of).minus(less),
    })
}

/// The denoised mean of a film and what is told about it. `None`, with a warning, where there are too few samples.
fn denoise_film(
    choice: Denoise,
    film: &Film,
    prepared: &Prepared,
    threads: usize,
    messages: &mut Messages,
) -> Result<Option<DenoisedFilm>, CliError> {
    let Some(input) = denoise::Input::of(film) else {
        let replicates = path::REPLICATES;
        messages.warn(format!(
            "--denoise: expected at least {replicates} samples per pixel, found {}; the picture is not denoised",
            film.spp()
        ));
        return Ok(None);
    };
    let start = Instant::now();
    let (denoiser, problem) = match choice {
        Denoise::Auto => Denoiser::best(),
        Denoise::Own => (Denoiser::Own, None),
        Denoise::Oidn => match Oidn::find() {
            Ok(oidn) => (Denoiser::Oidn(oidn), None),
            Err(error) => (Denoiser::Own, Some(error)),
        },
    };
    if let Some(problem) = problem {
        messages.warn(format!("--denoise: {problem}; the own filter is used"));
    }
    let guides = denoise::Guides::new(prepared, film.width, film.height);
    let cancel = || interrupt::is_interrupted();
    let denoised = denoiser.run(&input, &guides, threads, &cancel).map_err(|error| match error {
        DenoiseError::Cancelled => CliError::Interrupted,
        DenoiseError::Oidn(_) => CliError::unusable(format!("--denoise: {error}")),
    })?;
    let report = DenoiseReport { denoiser: denoiser.name(), seconds: start.elapsed().as_secs_f64(), error: denoised.error };
    Ok(Some((denoised.pixels, report)))
}

/// What the path tracer leaves out, other than images that are not there: loading told each with its reason.
fn left_out(scene: &Scene) -> Vec<String> {
    let mut scene = scene.clone();
    for object in &mut scene.objects {
        let textures = &object.textures;
        let is_missing = |texture: &TextureRef| !textures.contains_key(&texture.path);
        let slots = object.material.slots().filter(|(_, slot)| slot.texture.as_ref().is_some_and(is_missing));
        let missing: Vec<Property> = slots.map(|(property, _)| property).collect();
        for property in missing {
            Arc::make_mut(&mut object.material).slot_mut(property).texture = None;
        }
    }
    path::unsupported(&scene)
}

fn opaque(mean: &[[f32; 3]]) -> Vec<[f32; 4]> {
    mean.iter().map(|[r, g, b]| [*r, *g, *b, 1.0]).collect()
}

/// The picture less the environment that shows beside the objects, multiplied by coverage.
///
/// A film does not keep apart what arrived from where, so at edges the environment's mean over the pixel is taken off by
/// the share of samples that met nothing. That is exact where the environment is smooth within a pixel.
fn without_background(scene: &Scene, mean: &[[f32; 3]], film: &Film) -> Vec<[f32; 4]> {
    /// Directions per side of a pixel.
    const GRID: usize = 4;
    let (width, height) = (film.width, film.height);
    let basis = scene.camera.basis(width as f32 / height as f32);
    let background = |x: usize, y: usize| {
        let within = |cell: usize| (cell as f32 + 0.5) / GRID as f32;
        let sum = (0..GRID * GRID).fold(Vec3::ZERO, |sum, cell| {
            let (u, v) = (x as f32 + within(cell % GRID), y as f32 + within(cell / GRID));
            sum + scene.environment.radiance(basis.direction(u / width as f32, v / height as f32))
        });
        sum / (GRID * GRID) as f32
    };
    let pixels = mean.iter().copied().zip(film.alpha()).enumerate();
    pixels
        .map(|(i, (mean, alpha))| {
            let color = match alpha {
                0.0 => Vec3::ZERO,
                1.0 => Vec3::from(mean),
                _ => (Vec3::from(mean) - (1.0 - alpha) * background(i % width, i / width)).max(Vec3::ZERO),
            };
            color.extend(alpha).to_array()
        })
        .collect()
}

/// What the camera sees first; left empty unless a layer asks for it.
fn surfaces(arguments: &RenderArguments, loaded: &LoadedScene) -> path::Aovs {
    let is_seen = |kind: &LayerKind| matches!(kind, LayerKind::Albedo | LayerKind::Normal | LayerKind::Depth);
    if !arguments.aov.iter().any(is_seen) {
        return path::Aovs::default();
    }
    path::aovs(&Prepared::new(&loaded.scene, None), loaded.width, loaded.height)
}

fn split(values: &[[f32; 3]]) -> Vec<Vec<f32>> {
    (0..3).map(|c| values.iter().map(|value| value[c]).collect()).collect()
}

fn preview(arguments: &RenderArguments, loaded: &LoadedScene, messages: &mut Messages) -> Result<Rendered, CliError> {
    if arguments.transparent || !arguments.aov.is_empty() || arguments.error.is_some() || arguments.denoise.is_some() {
        return Err(CliError::unusable(
            "--view preview: expected no --transparent, --aov, --error or --denoise; they belong to --view final",
        ));
    }
    let unusable = |error| CliError::unusable(format!("--view preview: {error}"));
    let start = Instant::now();
    let (_adapter, device, queue) = preview::headless_device().map_err(unusable)?;
    let mut preview = Preview::new(&device, &queue).map_err(unusable)?;
    preview.set_scene(&device, &queue, &loaded.scene);
    let load_seconds = start.elapsed().as_secs_f64();

    let side = |pixels: usize| {
        let limit = device.limits().max_texture_dimension_2d;
        u32::try_from(pixels)
            .ok()
            .filter(|side| *side <= limit)
            .ok_or_else(|| CliError::unusable(format!("--size: expected at most {limit} pixels for this GPU, found {pixels}")))
    };
    let (width, height) = (side(loaded.width)?, side(loaded.height)?);
    let display = Display { exposure_ev: arguments.scene.exposure_ev(), transform: arguments.display_transform };
    let frames = arguments.spp.unwrap_or(PREVIEW_FRAMES);
    let start = Instant::now();
    // The first frame waits for everything that the window would show later.
    preview.settle(&device, &queue).map_err(unusable)?;
    preview.render_more(&device, &queue, width, height, display).map_err(unusable)?;
    let first_image_seconds = start.elapsed().as_secs_f64();
    let mut drawn = 1;
    let stop_reason = loop {
        interrupt::check()?;
        if drawn >= frames {
            break StopReason::Spp.word();
        }
        if arguments.time.is_some_and(|seconds| start.elapsed().as_secs_f64() >= seconds) {
            break StopReason::Time.word();
        }
        let would_refine = preview.render_more(&device, &queue, width, height, display).map_err(unusable)?;
        drawn += 1;
        if !would_refine {
            break "converged";
        }
    };
    if let Some(error) = preview.error() {
        return Err(CliError::unusable(format!("--view preview: {error}")));
    }
    let pixels = preview.read_linear(&device, &queue).map_err(unusable)?;
    let nonfinite = pixels.iter().filter(|pixel| pixel.iter().any(|x| !x.is_finite())).count() as u64;
    if arguments.scene.threads.is_some() {
        messages.warn("--threads has no effect with --view preview");
    }
    Ok(Rendered {
        picture: Picture { width: loaded.width, height: loaded.height, pixels, ..Picture::default() },
        spp: drawn,
        seconds: start.elapsed().as_secs_f64(),
        first_image_seconds: load_seconds + first_image_seconds,
        load_seconds,
        stop_reason,
        error: None,
        denoised: None,
        nonfinite,
        lobes: lobes(&loaded.scene, LobeSet::of),
    })
}

/// Lobes of the document's objects, as one of the renderers counts them.
fn lobes(scene: &Scene, of: impl Fn(&Material) -> LobeSet) -> LobeSet {
    scene.objects.iter().filter(|object| object.is_document).fold(LobeSet::EMPTY, |set, object| set.union(of(&object.material)))
}

/// What the picture was made from; no times, so that equal jobs give equal files.
fn job(arguments: &RenderArguments, loaded: &LoadedScene, rendered: &Rendered) -> Value {
    let material = loaded.material().map(|material| MaterialFile::new(material).text().to_owned());
    let mut job = json!({
        "program": concat!("Burnish ", env!("CARGO_PKG_VERSION")),
        "view": if arguments.view == View::Final { "final" } else { "preview" },
        "seed": arguments.scene.seed,
        "adaptive": arguments.view == View::Final && !arguments.no_adaptive,
        "max_bounces": loaded.scene.max_bounces,
        "denoiser": rendered.denoised.as_ref().map(|denoised| &denoised.denoiser),
        "material": material,
    });
    extend(&mut job, rendered.reached());
    job
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
        let error = rendered.error.as_ref().map_or_else(String::new, |error| format!(", {}", error_text(error)));
        let denoised = rendered.denoised.as_ref().map_or_else(String::new, |denoised| {
            format!(", denoised by {} in {:.1} s, estimated {}", denoised.denoiser, denoised.seconds, error_text(&denoised.error))
        });
        return print_out(&format!(
            "{} ({}x{}): {} spp in {:.1} s{error}{denoised}, stopped by {}",
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
        "width": rendered.picture.width,
        "height": rendered.picture.height,
        "view": if arguments.view == View::Final { "final" } else { "preview" },
        "seconds": rendered.seconds,
        "load_seconds": rendered.load_seconds,
        "first_image_seconds": rendered.first_image_seconds,
        "adaptive": arguments.view == View::Final && !arguments.no_adaptive,
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
    extend(&mut object, rendered.reached());
    print_out(&object.to_string())
}

/// `error 1.9 % (±0.2)`: the square root of relMSE, with half the width of its interval.
pub fn error_text(error: &ErrorEstimate) -> String {
    let percent = |relmse: f64| 100.0 * relmse.max(0.0).sqrt();
    let half_width = 0.5 * (percent(error.high) - percent(error.low));
    let fireflies = if error.is_firefly_limited { ", mostly few bright pixels" } else { "" };
    format!("error {:.1} % (±{half_width:.1}{fireflies})", percent(error.relmse))
}

fn progress_text(progress: &Progress<'_>) -> String {
    let error = progress.error.as_ref().map_or_else(String::new, |error| format!(", {}", error_text(error)));
    format!("{} spp in {:.1} s{error}", progress.film.spp(), progress.seconds)
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

fn denoiser(word: &str) -> Result<Denoise, String> {
    match word {
        "auto" => Ok(Denoise::Auto),
        "burnish" => Ok(Denoise::Own),
        "oidn" => Ok(Denoise::Oidn),
        _ => Err("expected auto, burnish or oidn".to_owned()),
    }
}

/// A display transform, for options.
pub fn transform(word: &str) -> Result<DisplayTransform, String> {
    DisplayTransform::from_word(word).ok_or_else(|| "expected neutral, agx, aces or standard".to_owned())
}

fn layer(word: &str) -> Result<LayerKind, String> {
    let known = || LayerKind::ALL.map(|(_, word)| word).join(", ");
    LayerKind::from_word(word).ok_or_else(|| format!("expected layers among {}", known()))
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
