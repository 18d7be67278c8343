//! `burnish stability`: whether materials hold where numbers get hard. Without one, the built-in suite.

use super::progress_line::ProgressLine;
use super::scene_options::SceneOptions;
use super::{CliError, Messages, Outcome, interrupt, print_out};
use burnish_renderer::stability::{self, Case, Numbers, Progress, Report, Worst};
use clap::Args;
use serde_json::{Value, json};
use std::sync::Mutex;
use std::time::Instant;

/// Arguments of `burnish stability`.
#[derive(Debug, Default, Args)]
pub struct StabilityArguments {
    /// Material files (.asm.ron) or preset:NAME; without any, the built-in suite of stiff and extreme cases
    #[arg(value_name = "MATERIAL")]
    materials: Vec<String>,
    /// Prints one JSON object
    #[arg(long)]
    json: bool,
    /// What the materials are shown on.
    #[command(flatten)]
    scene: SceneOptions,
}

/// Probes all cases and prints what was found. The built-in suite brings its own scenes: of the options it takes `--threads`.
pub fn run(arguments: &StabilityArguments) -> Result<Outcome, CliError> {
    let mut messages = Messages::default();
    let cases = cases(arguments, &mut messages)?;
    let start = Instant::now();
    let line = Mutex::new(ProgressLine::new());
    let progress = |progress: &Progress| {
        let text = || {
            let failed = if progress.failed > 0 { format!(", {} do not hold", progress.failed) } else { String::new() };
            format!("{} of {} cases{failed}, {:.0} s left", progress.done, progress.total, progress.remaining_seconds)
        };
        if let Ok(mut line) = line.lock() {
            line.show(text);
        }
    };
    let reports = stability::run(&cases, arguments.scene.threads(), &progress, &interrupt::is_interrupted);
    if let Ok(mut line) = line.lock() {
        line.clear();
    }
    let reports = reports.ok_or(CliError::Interrupted)?;
    interrupt::check()?;
    let failed = reports.iter().filter(|report| !report.holds()).count();
    let text = if arguments.json {
        let rows: Vec<Value> = reports.iter().map(json_row).collect();
        let seconds = start.elapsed().as_secs_f64();
        json!({ "cases": rows, "failed": failed, "seconds": seconds, "warnings": messages.warnings() }).to_string()
    } else {
        table(&reports, failed)
    };
    print_out(&text)?;
    Ok(if failed > 0 { Outcome::Findings } else { Outcome::Done })
}

/// The suite, or each material with its neighbours.
fn cases(arguments: &StabilityArguments, messages: &mut Messages) -> Result<Vec<Case>, CliError> {
    let options = &arguments.scene;
    let is_set = options.scene.is_some() || !options.set.is_empty() || options.mesh.is_some();
    if arguments.materials.is_empty() && !is_set {
        return Ok(stability::suite());
    }
    let mut cases: Vec<Case> = Vec::new();
    if arguments.materials.is_empty() {
        // `--scene` brings a material; anything else is refused with the sentence that says so.
        let scene = options.load(None, None, messages)?.scene;
        return Ok(stability::neighbours("scene", &scene));
    }
    for text in &arguments.materials {
        let scene = options.load(Some(text), None, messages)?.scene;
        let names = arguments.materials.iter().filter(|other| *other == text).count();
        if names > 1 && cases.iter().any(|case| case.name == *text) {
            messages.warn(format!("{text}: named twice; probed once"));
            continue;
        }
        cases.extend(stability::neighbours(text, &scene));
    }
    Ok(cases)
}

/// One line per case that does not hold and per case that is near its limits, then the counts.
fn table(reports: &[Report], failed: usize) -> String {
    let width = reports.iter().map(|report| report.name.chars().count()).max().unwrap_or(0);
    let mut text = String::new();
    for report in reports {
        let verdict = if report.holds() { "holds" } else { "FAILS" };
        text += &format!("{verdict}  {:<width$}  {:>6.2} s  {}\n", report.name, report.seconds, report.worst);
    }
    let cases = if reports.len() == 1 { "case" } else { "cases" };
    text + &format!("{} {cases}, {failed} do not hold", reports.len())
}

fn json_row(report: &Report) -> Value {
    json!({
        "name": report.name,
        "holds": report.holds(),
        "worst": report.worst,
        "seconds": report.seconds,
        "failed_checks": report.failed.iter().map(|check| check.word()).collect::<Vec<_>>(),
        "numbers": json_numbers(&report.numbers),
    })
}

fn json_numbers(n: &Numbers) -> Value {
    // JSON has no infinity: what is beyond all numbers is null.
    let worst = |w: &Worst| json!({ "value": finite(w.value), "at": w.place });
    json!({
        "nonfinite": n.nonfinite,
        "negative": n.negative,
        "first_bad": n.first_bad,
        "coefficients_out_of_range": n.coefficients,
        "pdf_mismatch": worst(&n.pdf_mismatch),
        "density_excess": worst(&n.density_excess),
        "furnace_gain": worst(&n.gain),
        "furnace_loss": n.loss.as_ref().map(worst),
        "double_difference": worst(&n.precision),
        "brightness_excess": n.brightness.and_then(finite),
        "darkness": n.darkness.and_then(finite),
        "time_ratio": finite(n.time_ratio),
    })
}

fn finite(x: f64) -> Option<f64> {
    Some(x).filter(|x| x.is_finite())
}
