//! The status line and the strip of lobes: what was done last, what is being worked at, how far the picture is.

use crate::live_costs::Costs;
use crate::panels::chart::{duration, percent};
use crate::switches::switched_by;
use crate::theme;
use crate::widgets::number;
use crate::work::{Ends, Work};
use burnish_material::{LOBES, Lobe, LobeSet, Material};
use burnish_renderer::path::{Convergence, SPP_MAX, StopReason, StopRules};
use burnish_renderer::preview::FrameTimes;
use burnish_renderer::worker::Snapshot;
use egui::{Color32, FontId, Label, Layout, Rect, RichText, Role, Sense, StrokeKind, Ui, WidgetInfo, vec2};

/// What the status line says.
#[derive(Clone, Debug, Default)]
pub struct Status {
    /// What is being worked at, the most telling first.
    pub work: Vec<Work>,
    /// What was done last.
    pub info: String,
    /// How far the picture is.
    pub picture: String,
    /// More about it, as a tooltip.
    pub details: String,
}

/// Shows the line. What the user wants to end.
pub fn show(ui: &mut Ui, status: &Status) -> Option<Ends> {
    let mut ended = None;
    ui.horizontal_centered(|ui| {
        ui.with_layout(Layout::right_to_left(egui::Align::Center), |ui| {
            let picture = ui.add(Label::new(RichText::new(&status.picture).small().color(theme::now().text)).selectable(false));
            if !status.details.is_empty() {
                picture.on_hover_text(&status.details);
            }
            ui.with_layout(Layout::left_to_right(egui::Align::Center), |ui| {
                if let Some(first) = status.work.first() {
                    let more = if status.work.len() > 1 { format!("  + {} more", status.work.len() - 1) } else { String::new() };
                    ui.add(egui::Spinner::new().size(12.0));
                    let text = RichText::new(format!("{}{more}", first.text)).small().color(theme::now().accent);
                    let button = ui.add(egui::Button::new(text).frame_when_inactive(false).small());
                    button.widget_info(|| WidgetInfo::labeled(Role::Button, true, format!("Work: {}", first.text)));
                    let button = button.on_hover_text("What is being worked at; click to see all of it and to end it");
                    egui::Popup::menu(&button)
                        .close_behavior(egui::PopupCloseBehavior::CloseOnClickOutside)
                        .show(|ui| ended = work_list(ui, &status.work));
                }
                ui.add(Label::new(RichText::new(&status.info).small().color(theme::now().weak)).truncate());
            });
        });
    });
    ended
}

fn work_list(ui: &mut Ui, list: &[Work]) -> Option<Ends> {
    let mut ended = None;
    ui.set_min_width(320.0);
    for work in list {
        ui.horizontal(|ui| {
            ui.label(&work.text);
            ui.with_layout(Layout::right_to_left(egui::Align::Center), |ui| {
                if let Some(ends) = work.ends
                    && ui.small_button("End").accessible_name(format!("End {}", work.text)).clicked()
                {
                    ended = Some(ends);
                }
                if let Some(remaining) = work.remaining {
                    ui.label(RichText::new(format!("about {} yet", duration(remaining))).small().weak());
                }
            });
        });
        if let Some(progress) = work.progress {
            ui.add(egui::ProgressBar::new(progress).desired_height(4.0));
        }
    }
    ended
}

/// How far a final picture is: what ended it or will, samples, error, time and speed.
pub fn final_text(snapshot: &Snapshot, stop: &StopRules) -> String {
    let mut parts = vec![match snapshot.done {
        Some(reason) => ended(reason, stop),
        None => forecast(snapshot, stop).unwrap_or_else(|| "rendering".into()),
    }];
    parts.push(format!("{} spp", snapshot.spp));
    if snapshot.scale > 1 {
        parts.push(format!("1/{} resolution", snapshot.scale));
    }
    if let Some(error) = &snapshot.error {
        let limited = if error.is_firefly_limited { ", uncertain: few bright pixels dominate" } else { "" };
        let [relmse, low, high] = [error.relmse, error.low, error.high].map(percent);
        parts.push(format!("error {relmse} % ({low} to {high}{limited})"));
    }
    parts.push(duration(snapshot.seconds));
    parts.push(format!("{} M samples/s", number::format(snapshot.samples_per_second / 1e6, 2)));
    if snapshot.nonfinite > 0 {
        parts.push(format!("⚠ {} samples not finite", snapshot.nonfinite));
    }
    parts.join("   ")
}

/// What the numbers of [`final_text`] mean.
pub fn final_details(snapshot: &Snapshot, stop: &StopRules) -> String {
    let mut lines = vec![
        format!("First image after {:.0} ms.", 1000.0 * snapshot.first_image_seconds),
        "The error is estimated from the picture itself: the square root of the mean squared relative error, with an interval that holds \
         the true one 95 times in 100."
            .to_owned(),
    ];
    if snapshot.error.is_some_and(|error| error.is_firefly_limited) {
        lines.push(
            "Light that few samples find makes up much of it: the estimate may still jump, and the interval is wide.".into(),
        );
    }
    let mut rules = Vec::new();
    rules.extend(stop.relmse.map(|relmse| format!("{} % error", percent(relmse))));
    rules.extend(stop.spp.map(|spp| format!("{spp} samples per pixel")));
    rules.extend(stop.seconds.map(|seconds| format!("{seconds} seconds")));
    if !rules.is_empty() {
        lines.push(format!("It stops at the first of: {}.", rules.join(", ")));
    }
    lines.join("\n")
}

/// What each pass of a preview's frame took, in lines.
pub fn frame_text(times: &FrameTimes, rays_problem: Option<String>) -> String {
    let mut lines: Vec<String> = times.passes.iter().map(|(name, ms)| format!("{ms:7.2} ms  {name}")).collect();
    if lines.is_empty() {
        lines.push("This adapter measures no times of passes.".into());
    } else {
        lines.push(format!("{:7.2} ms  in all", times.total()));
    }
    lines.extend(rays_problem.map(|problem| format!("No rays: {problem}")));
    lines.join("\n")
}

/// The rule that ended a picture.
fn ended(reason: StopReason, stop: &StopRules) -> String {
    match reason {
        StopReason::Error => format!("stopped: error {} % reached", stop.relmse.map_or_else(String::new, percent)),
        StopReason::Spp => format!("stopped: {} samples per pixel reached", stop.spp.unwrap_or(SPP_MAX)),
        StopReason::Time => format!("stopped: {} are up", stop.seconds.map_or_else(String::new, duration)),
        StopReason::Cancelled => "stopped".into(),
    }
}

/// The rule that will end a picture first, and when. `None` as long as nothing can be told.
fn forecast(snapshot: &Snapshot, stop: &StopRules) -> Option<String> {
    end(snapshot, stop).map(|(_, text)| text)
}

/// The second at which a picture will end, and the rule that ends it.
pub fn end(snapshot: &Snapshot, stop: &StopRules) -> Option<(f64, String)> {
    let now = snapshot.seconds;
    let mut ends: Vec<(f64, String)> = Vec::new();
    if let Some(end) = stop.seconds {
        ends.push((end, format!("time is up in {}", duration((end - now).max(0.0)))));
    }
    if let Some(spp) = stop.spp.filter(|_| snapshot.spp > 0 && snapshot.scale == 1) {
        let end = now * f64::from(spp) / f64::from(snapshot.spp);
        ends.push((end, format!("{spp} spp in about {}", duration((end - now).max(0.0)))));
    }
    let line = Convergence::fit(&snapshot.history);
    if let (Some(target), Some(line)) = (stop.relmse, line)
        && let Some(prediction) = line.seconds_to(target)
    {
        let [rest, low, high] = [prediction.seconds, prediction.low, prediction.high].map(|end| duration((end - now).max(0.0)));
        ends.push((prediction.seconds, format!("{} % in about {rest} ({low} to {high})", percent(target))));
    } else if stop.relmse.is_some() {
        // Before there is a line, any other rule may come second.
        return None;
    }
    ends.into_iter().min_by(|a, b| a.0.total_cmp(&b.0))
}

/// Which values put a lobe in or out. Finding that out tries many materials: the answer is kept while the same chip is pointed at.
fn reasons(ui: &Ui, material: &Material, lobe: Lobe) -> String {
    let id = egui::Id::unique("reasons of a lobe");
    let kept = ui.data(|data| data.get_temp::<(Lobe, Material, String)>(id));
    if let Some((_, _, values)) = kept.filter(|(l, m, _)| *l == lobe && m == material) {
        return values;
    }
    let values = switched_by(material, lobe);
    ui.data_mut(|data| data.insert_temp(id, (lobe, material.clone(), values.clone())));
    values
}

/// Shows which lobes are in use and which are left out, each with the reason and, once they were measured, the milliseconds that it takes
/// of a frame of the preview, or would. Returns whether measuring is to begin or to end.
pub fn lobe_strip(ui: &mut Ui, material: &Material, costs: &Costs) -> bool {
    let lobes = LobeSet::of(material);
    let mut is_asked = false;
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing = vec2(4.0, 3.0);
        let text = if costs.is_running { format!("ms {:02}/{}", costs.lobes.len(), LOBES.len()) } else { "ms".to_owned() };
        let button = ui.add(egui::Button::new(RichText::new(text).size(11.5)).small());
        button.widget_info(|| WidgetInfo::labeled(Role::Button, true, "Measure lobes"));
        let hint = match (&costs.problem, costs.is_running) {
            (Some(problem), _) => format!("Not measured: {problem}"),
            (None, true) => "Measuring; click to end it.".to_owned(),
            (None, false) => "Measure what each lobe takes of a frame of the preview, on a device of its own.".to_owned(),
        };
        is_asked = button.on_hover_text(hint).clicked();
        for def in LOBES {
            let is_in = lobes.has(def.lobe);
            let (fill, stroke, color) = if is_in {
                (theme::now().selection.gamma_multiply(0.6), theme::now().accent.gamma_multiply(0.55), theme::now().strong)
            } else {
                (Color32::TRANSPARENT, theme::now().line, theme::now().weak)
            };
            let name = def.name.replace('_', " ");
            let state = if is_in { "in use" } else { "left out" };
            let ms = costs.of(def.lobe).map(|ms| format!("{ms:+.1} ms"));
            // Room is kept for numbers to come, so that nothing moves as they do.
            let shown = match costs.of(def.lobe) {
                Some(ms) => format!("{name} {ms:.*}", usize::from(ms.abs() < 9.95)),
                None if costs.is_running => format!("{name} ····"),
                None => name.clone(),
            };
            let galley = ui.painter().layout_no_wrap(shown, FontId::proportional(11.5), color);
            let (rect, chip) = ui.allocate_exact_size(galley.size() + vec2(12.0, 3.0), Sense::hover());
            chip.widget_info(|| WidgetInfo::labeled(Role::Label, true, format!("{name} {state}")));
            ui.painter().rect(rect, 8, fill, (1.0, stroke), StrokeKind::Inside);
            let text = Rect::from_center_size(rect.center(), galley.size());
            ui.painter().galley(text.min, galley, color);
            // Struck out as well as grey, so that the difference does not hang on colour.
            if !is_in {
                ui.painter().hline(text.x_range(), text.center().y + 1.0, (1.0, color));
            }
            chip.on_hover_ui(|ui| {
                ui.label(RichText::new(format!("{name}: {state}")).strong());
                let values = reasons(ui, material, def.lobe);
                if !values.is_empty() {
                    ui.label(format!("Because {values}."));
                }
                ui.label(def.doc);
                if let Some(ms) = &ms {
                    let verb = if is_in { "It takes" } else { "It would take" };
                    ui.label(format!("{verb} {ms} of a frame of the preview."));
                }
            });
        }
    });
    is_asked
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::panels::chart::tests::history;
    use burnish_renderer::path::{ErrorEstimate, ErrorPoint};

    /// A picture of 64 samples after 8 s, with an error of 7.1 %.
    fn snapshot(done: Option<StopReason>) -> Snapshot {
        let history = history(5);
        let ErrorPoint { seconds, spp, relmse, low, high } = history[4];
        Snapshot {
            revision: 1,
            width: 1,
            height: 1,
            pixels: vec![[0.0; 4]],
            spp,
            scale: 1,
            seconds,
            error: Some(ErrorEstimate { relmse, low, high, is_firefly_limited: false }),
            samples_per_second: 1.2e6,
            done,
            history,
            nonfinite: 0,
            first_image_seconds: 0.01,
            samples: None,
        }
    }

    fn stop(spp: Option<u32>, seconds: Option<f64>, relmse: Option<f64>) -> StopRules {
        StopRules { spp, seconds, relmse }
    }

    #[test]
    fn the_rule_that_stopped_is_told() {
        let rules = stop(Some(64), Some(60.0), Some(0.071 * 0.071));
        let text = |reason| final_text(&snapshot(Some(reason)), &rules);
        let rest = "   64 spp   error 7.1 % (6.5 to 7.7)   8 s   1.2 M samples/s";
        assert_eq!(text(StopReason::Error), format!("stopped: error 7.1 % reached{rest}"));
        assert_eq!(text(StopReason::Spp), format!("stopped: 64 samples per pixel reached{rest}"));
        assert_eq!(text(StopReason::Time), format!("stopped: 60 s are up{rest}"));
        let without = final_text(&snapshot(Some(StopReason::Spp)), &StopRules::default());
        assert!(without.starts_with("stopped: 1048576 samples"), "{without}");
    }

    #[test]
    fn the_first_rule_to_come_is_told() {
        let text = |rules| final_text(&snapshot(None), &rules);
        // By its line the error is 5 % after 16 s, 1 % after 400 s.
        for (rules, expected) in [
            (stop(None, None, Some(25e-4)), "5 % in about 8 s ("),
            (stop(None, Some(12.0), Some(25e-4)), "time is up in 4 s   "),
            (stop(Some(128), None, Some(1e-4)), "128 spp in about 8 s   "),
            (stop(Some(4096), Some(600.0), Some(1e-4)), "1 % in about 7 min ("),
            (stop(None, None, None), "rendering   64 spp"),
        ] {
            assert!(text(rules).starts_with(expected), "{}", text(rules));
        }
        let few = Snapshot { history: Vec::new(), error: None, ..snapshot(None) };
        assert_eq!(final_text(&few, &stop(Some(4096), None, Some(1e-4))), "rendering   64 spp   8 s   1.2 M samples/s");
    }

    #[test]
    fn a_firefly_limited_picture_says_so() {
        let mut limited = snapshot(None);
        limited.error = limited.error.map(|error| ErrorEstimate { is_firefly_limited: true, ..error });
        let text = final_text(&limited, &StopRules::default());
        assert!(text.contains("(6.5 to 7.7, uncertain: few bright pixels dominate)"), "{text}");
    }
}
