//! Whether the open material holds where numbers get hard: the verdict, the worst numbers, and a button per change that helps.

use crate::live_stability::{Outcome, State};
use crate::theme;
use burnish_renderer::stability::{self, Fix, Report};
use egui::{Button, Color32, Label, ProgressBar, RichText, ScrollArea, Ui};

/// Cases that do not hold shown at most.
const MAX_SHOWN: usize = 12;

/// Shows the report. Returns the change that was asked for.
pub fn show(ui: &mut Ui, state: &State) -> Option<Fix> {
    ui.horizontal(|ui| {
        ui.label(RichText::new("Stability").strong());
        match state {
            State::Waiting => line(ui, theme::now().weak, "waiting for the material to rest"),
            State::Running(None) => line(ui, theme::now().weak, "probing angles, extremes and small pictures"),
            State::Running(Some(progress)) => {
                let text = format!("{} of {} cases, {:.0} s left", progress.done, progress.total, progress.remaining_seconds);
                let share = progress.done as f32 / progress.total.max(1) as f32;
                ui.add(ProgressBar::new(share).desired_width(260.0).text(text));
            }
            State::Done(outcome) => {
                let (color, text) = verdict(outcome);
                line(ui, color, &text);
            }
        }
    });
    let State::Done(outcome) = state else { return None };
    let mut chosen = None;
    ScrollArea::vertical().auto_shrink([false, false]).show(ui, |ui| {
        if let Some(own) = outcome.reports.first() {
            ui.add(Label::new(RichText::new(numbers(own)).small().color(theme::now().text)).wrap());
        }
        for fix in &outcome.fixes {
            ui.horizontal_wrapped(|ui| {
                if ui.add(Button::new(&fix.name)).on_hover_text(&fix.reason).clicked() {
                    chosen = Some(fix.clone());
                }
                ui.label(RichText::new(&fix.reason).small().color(theme::now().weak));
            });
        }
        let failed: Vec<&Report> = outcome.reports.iter().filter(|report| !report.holds()).collect();
        for report in failed.iter().take(MAX_SHOWN) {
            let text = format!("⚠ {}: {}", report.name, report.worst);
            ui.add(Label::new(RichText::new(text).small().color(theme::now().warning)).wrap());
        }
        if failed.len() > MAX_SHOWN {
            ui.label(
                RichText::new(format!("{} more cases do not hold", failed.len() - MAX_SHOWN)).small().color(theme::now().weak),
            );
        }
    });
    chosen
}

fn line(ui: &mut Ui, color: Color32, text: &str) {
    ui.add(Label::new(RichText::new(text).color(color)).truncate());
}

/// One sentence: whether the material holds, and whether what a slider can reach does.
pub fn verdict(outcome: &Outcome) -> (Color32, String) {
    let Some((own, others)) = outcome.reports.split_first() else { return (theme::now().weak, "nothing was probed".into()) };
    let failed = others.iter().filter(|report| !report.holds()).count();
    let at_ends = match failed {
        0 => format!("and so it does at {} ends of its properties", others.len()),
        _ => format!("but not at {failed} of {} ends of its properties", others.len()),
    };
    if own.holds() {
        (if failed == 0 { theme::now().good } else { theme::now().warning }, format!("✔ This material holds, {at_ends}."))
    } else {
        (theme::now().error, format!("⊗ This material does not hold: {}.", own.worst))
    }
}

/// The numbers of the material as it is, each with its limit.
fn numbers(report: &Report) -> String {
    let n = &report.numbers;
    let percent = |x: f64| format!("{:.2} %", 100.0 * x);
    let loss = n.loss.as_ref().map_or_else(|| "not promised".to_owned(), |w| percent(w.value));
    format!(
        "not finite {}   negative {}   density against value {:.0e} (limit {:.0e})   gain {} (limit {})   loss of white {loss} (limit {})   \
         single against double precision {} (limit {})   time of a sample ×{:.1} (limit ×{:.0})   probed in {:.1} s",
        n.nonfinite,
        n.negative,
        n.pdf_mismatch.value,
        stability::PDF_MISMATCH_MAX,
        percent(n.gain.value),
        percent(stability::GAIN_MAX),
        percent(stability::LOSS_MAX),
        percent(n.precision.value),
        percent(stability::PRECISION_MAX),
        n.time_ratio,
        stability::TIME_RATIO_MAX,
        report.seconds,
    )
}
