//! `burnish features`: which lobes a material needs, why, and what it saves to leave the others out.

use super::progress_line::ProgressLine;
use super::scene_options::{LoadedScene, SceneOptions};
use super::{CliError, Messages, Outcome, interrupt, print_out};
use crate::lobe_costs::{Change, Meter};
use crate::switches::switched_by;
use burnish_material::{LOBES, LobeSet, Material};
use burnish_renderer::path::{Film, Prepared, render_pass};
use burnish_renderer::preview::PreviewError;
use clap::Args;
use serde_json::{Value, json};
use std::time::Instant;

/// Pictures with and without that take turns; the median of the ratios counts.
const REPEATS: usize = 5;
/// The same for a single lobe.
const REPEATS_OF_LOBE: usize = 3;
/// Seconds that one of the pictures should take: longer than what else a machine does in between.
const SECONDS: f64 = 0.25;
/// Samples per pixel of one picture at most.
const SPP_MAX: u32 = 256;
/// Frames of the preview that are timed, pruned and full in turn.
const FRAMES: usize = 12;
/// The same for a single lobe.
const FRAMES_OF_LOBE: usize = 5;

/// Arguments of `burnish features`.
#[derive(Debug, Default, Args)]
pub struct FeaturesArguments {
    /// Material file (.asm.ron) or preset:NAME; may be left out with --scene
    #[arg(value_name = "MATERIAL")]
    material: Option<String>,
    /// Prints one JSON object
    #[arg(long)]
    json: bool,
    /// What the material is shown on.
    #[command(flatten)]
    scene: SceneOptions,
}

/// What the path tracer takes longer with more lobes.
struct Cost {
    /// Time with them over time without.
    ratio: f64,
    /// Difference of the mean pictures in standard errors; the largest of three channels.
    z: f64,
}

/// What the preview takes, milliseconds.
struct PreviewCost {
    frame: f64,
    frame_full: f64,
    compile: f64,
    compile_full: f64,
    /// What each lobe takes of a frame, or would, in the order of the table.
    lobes: Vec<f64>,
    adapter: String,
}

/// Measures and prints.
pub fn run(arguments: &FeaturesArguments) -> Result<Outcome, CliError> {
    let mut messages = Messages::default();
    let loaded = arguments.scene.load(arguments.material.as_deref(), None, &mut messages)?;
    let material = loaded.material().ok_or_else(|| CliError::unusable("the scene has no object with a material"))?.clone();
    let needed = LobeSet::of(&material);
    let mut line = ProgressLine::new();
    line.show(|| "final view with all lobes".to_owned());
    let mut meter = FinalMeter::new(&loaded, arguments.scene.threads(), arguments.scene.seed)?;
    let full = meter.cost(LobeSet::all(), REPEATS)?;
    let mut of_lobes = Vec::new();
    for def in LOBES {
        line.show(|| format!("final view with {}", def.name));
        let more = LobeSet::EMPTY.with(def.lobe);
        let is_evaluated = !needed.has(def.lobe);
        of_lobes.push(if is_evaluated { Some(meter.cost(more, REPEATS_OF_LOBE)?) } else { None });
    }
    line.show(|| "preview".to_owned());
    let preview = preview_cost(&loaded, needed, &mut line);
    line.clear();
    interrupt::check()?;

    let text = if arguments.json {
        let lobes: Vec<Value> = LOBES
            .iter()
            .zip(&of_lobes)
            .enumerate()
            .map(|(i, (def, cost))| {
                json!({
                    "name": def.name,
                    "in": needed.has(def.lobe),
                    "reason": reason(&material, needed, def),
                    "final_ratio": cost.as_ref().map(|cost| cost.ratio),
                    "z": cost.as_ref().map(|cost| cost.z),
                    "preview_ms": preview.as_ref().ok().and_then(|p| p.lobes.get(i)),
                })
            })
            .collect();
        json!({
            "lobes": lobes,
            "preview_ms": preview.as_ref().ok().map(|p| p.frame),
            "preview_full_ms": preview.as_ref().ok().map(|p| p.frame_full),
            "compile_ms": preview.as_ref().ok().map(|p| p.compile),
            "compile_full_ms": preview.as_ref().ok().map(|p| p.compile_full),
            "adapter": preview.as_ref().ok().map(|p| p.adapter.clone()),
            "preview_reason": preview.as_ref().err().map(ToString::to_string),
            "final_speedup": full.ratio,
            "z": full.z,
            "warnings": messages.warnings(),
        })
        .to_string()
    } else {
        let mut text = String::new();
        for (i, (def, cost)) in LOBES.iter().zip(&of_lobes).enumerate() {
            let state = if needed.has(def.lobe) { "in " } else { "out" };
            let ratio = cost.as_ref().map_or_else(String::new, |cost| format!("  final x{:.2} with it", cost.ratio));
            let ms = preview.as_ref().ok().and_then(|p| p.lobes.get(i));
            let ms = ms.map_or_else(String::new, |ms| format!("  preview {ms:+.2} ms"));
            text += &format!("{state}  {:<20}{}{ratio}{ms}\n", def.name, reason(&material, needed, def));
        }
        text += &format!(
            "final: {:.2} times as fast as with all lobes (pictures differ by {:.1} standard errors)\n",
            full.ratio, full.z
        );
        text += &match &preview {
            Ok(p) => format!(
                "preview: {:.2} ms a frame, {:.2} ms with all lobes; compiled in {:.0} ms, {:.0} ms with all lobes ({})",
                p.frame, p.frame_full, p.compile, p.compile_full, p.adapter
            ),
            Err(error) => format!("preview: not measured: {error}"),
        };
        text
    };
    print_out(&text)?;
    Ok(Outcome::Done)
}

/// The values that put a lobe in or out, and what it is.
fn reason(material: &Material, needed: LobeSet, def: &burnish_material::LobeDef) -> String {
    let values = switched_by(material, def.lobe);
    let state = if needed.has(def.lobe) { "in" } else { "left out" };
    if values.is_empty() { def.doc.to_owned() } else { format!("{state} because {values}. {}", def.doc) }
}

/// Renders with and without lobes in turn.
struct FinalMeter<'a> {
    loaded: &'a LoadedScene,
    pruned: Prepared,
    spp: u32,
    threads: usize,
    seed: u64,
}

impl<'a> FinalMeter<'a> {
    fn new(loaded: &'a LoadedScene, threads: usize, seed: u64) -> Result<Self, CliError> {
        let mut meter = Self { loaded, pruned: Prepared::new(&loaded.scene, None), spp: 1, threads, seed };
        // Twice: the first picture also warms buffers up.
        meter.picture(&meter.pruned, seed)?;
        let (seconds, _) = meter.picture(&meter.pruned, seed)?;
        meter.spp = (SECONDS / seconds.max(1e-6)).clamp(4.0, f64::from(SPP_MAX)) as u32;
        Ok(meter)
    }

    /// Seconds of one picture, and the picture.
    fn picture(&self, prepared: &Prepared, seed: u64) -> Result<(f64, Film), CliError> {
        let mut film = Film::new(self.loaded.width, self.loaded.height);
        let start = Instant::now();
        render_pass(prepared, &mut film, self.spp, seed, self.threads, &interrupt::is_interrupted)
            .ok_or(CliError::Interrupted)?;
        Ok((start.elapsed().as_secs_f64(), film))
    }

    /// Cost of evaluating these lobes as well.
    fn cost(&mut self, more: LobeSet, repeats: usize) -> Result<Cost, CliError> {
        let full = Prepared::with_lobes(&self.loaded.scene, Some(&self.pruned), more, LobeSet::EMPTY);
        let mut ratios = Vec::new();
        let mut z = 0.0;
        for repeat in 0..repeats {
            // Different seeds: equal ones would hide a difference that only shows in the mean.
            let (without, a) = self.picture(&self.pruned, self.seed)?;
            let (with, b) = self.picture(&full, self.seed.wrapping_add(1))?;
            ratios.push(with / without.max(1e-9));
            if repeat == 0 {
                z = difference(&a, &b);
            }
        }
        Ok(Cost { ratio: median(&mut ratios), z })
    }
}

/// Difference of the means of two independent pictures over its standard error; the largest of the channels.
fn difference(a: &Film, b: &Film) -> f64 {
    let sum = |values: &[[f32; 3]], k: usize| values.iter().map(|v| f64::from(v[k])).sum::<f64>();
    let (mean_a, mean_b, var_a, var_b) = (a.mean(), b.mean(), a.variance(), b.variance());
    let z = |k: usize| {
        let distance = (sum(&mean_a, k) - sum(&mean_b, k)).abs();
        let error = (sum(&var_a, k) + sum(&var_b, k)).sqrt();
        if distance == 0.0 { 0.0 } else { distance / error.max(1e-30) }
    };
    (0..3).map(z).fold(0.0, f64::max)
}

fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(1.0)
}

fn preview_cost(loaded: &LoadedScene, needed: LobeSet, line: &mut ProgressLine) -> Result<PreviewCost, PreviewError> {
    let mut meter = Meter::new(&loaded.scene, [loaded.width as u32, loaded.height as u32])?;
    let pruned = Change::default();
    let full = Change { more: LobeSet::all(), ..pruned };
    let ([frame, frame_full], compile_full) = meter.compare([pruned, full], FRAMES)?;
    let mut lobes = Vec::new();
    for def in LOBES {
        if interrupt::is_interrupted() {
            break;
        }
        line.show(|| format!("preview with and without {}", def.name));
        let (change, sign) = Change::of(def.lobe, needed);
        let ([as_is, changed], _) = meter.compare([pruned, change], FRAMES_OF_LOBE)?;
        lobes.push(1e3 * sign * (changed - as_is));
    }
    Ok(PreviewCost {
        frame: 1e3 * frame,
        frame_full: 1e3 * frame_full,
        compile: 1e3 * meter.compile,
        compile_full: 1e3 * compile_full,
        lobes,
        adapter: meter.adapter,
    })
}
