//! The status line and the strip of lobes: what was done last, what is being loaded, how far the picture is.

use crate::panels::chart;
use crate::theme;
use crate::widgets::number;
use burnish_material::{LOBES, LobeSet};
use burnish_renderer::path::StopReason;
use burnish_renderer::worker::Snapshot;
use egui::{Color32, FontId, Label, Layout, Rect, RichText, Role, Sense, StrokeKind, Ui, WidgetInfo, vec2};

/// What the status line says.
#[derive(Clone, Debug, Default)]
pub struct Status {
    /// What is being loaded.
    pub loading: Option<String>,
    /// What was done last.
    pub info: String,
    /// How far the picture is.
    pub picture: String,
    /// More about it, as a tooltip.
    pub details: String,
}

/// Shows the line.
pub fn show(ui: &mut Ui, status: &Status) {
    ui.horizontal_centered(|ui| {
        ui.with_layout(Layout::right_to_left(egui::Align::Center), |ui| {
            let picture = ui.add(Label::new(RichText::new(&status.picture).small().color(theme::TEXT)).selectable(false));
            if !status.details.is_empty() {
                picture.on_hover_text(&status.details);
            }
            ui.with_layout(Layout::left_to_right(egui::Align::Center), |ui| match &status.loading {
                Some(text) => {
                    ui.add(egui::Spinner::new().size(12.0));
                    ui.add(Label::new(RichText::new(text).small().color(theme::ACCENT)).truncate());
                }
                None => {
                    ui.add(Label::new(RichText::new(&status.info).small().color(theme::WEAK)).truncate());
                }
            });
        });
    });
}

/// How far a final picture is: samples, error, time, speed and why it stopped.
pub fn final_text(snapshot: &Snapshot, goal_relmse: Option<f64>) -> String {
    let mut parts = vec![format!("{} spp", snapshot.spp)];
    if snapshot.scale > 1 {
        parts.push(format!("1/{} resolution", snapshot.scale));
    }
    if let Some(error) = &snapshot.error {
        let spread = 50.0 * (error.high.max(0.0).sqrt() - error.low.max(0.0).sqrt());
        let marker = if error.is_firefly_limited { " (few bright pixels dominate)" } else { "" };
        parts.push(format!("error {} ± {} %{marker}", number::format(100.0 * error.relmse.sqrt(), 2), number::format(spread, 1)));
    }
    parts.push(format!("{:.1} s", snapshot.seconds));
    parts.push(format!("{} M samples/s", number::format(snapshot.samples_per_second / 1e6, 3)));
    if snapshot.nonfinite > 0 {
        parts.push(format!("⚠ {} samples not finite", snapshot.nonfinite));
    }
    parts.push(match snapshot.done {
        Some(StopReason::Spp) => "done: samples reached".into(),
        Some(StopReason::Time) => "done: time is up".into(),
        Some(StopReason::Error) => "done: error reached".into(),
        Some(StopReason::Cancelled) => "stopped".into(),
        None => match (goal_relmse, &snapshot.error) {
            (Some(goal), Some(error)) => {
                chart::seconds_to(goal, snapshot.seconds, error.relmse).filter(|rest| *rest < 36_000.0).map_or_else(
                    || "rendering".into(),
                    |rest| format!("{} % in about {rest:.0} s", number::format(100.0 * goal.sqrt(), 2)),
                )
            }
            _ => "rendering".into(),
        },
    });
    parts.join("   ")
}

/// Shows which lobes are in use and which are left out, each with the reason.
pub fn lobe_strip(ui: &mut Ui, lobes: LobeSet) {
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing = vec2(4.0, 3.0);
        for def in LOBES {
            let is_in = lobes.has(def.lobe);
            let (fill, stroke, color) = if is_in {
                (Color32::from_rgb(72, 56, 36), theme::ACCENT.gamma_multiply(0.55), Color32::from_gray(225))
            } else {
                (Color32::TRANSPARENT, Color32::from_gray(62), Color32::from_gray(112))
            };
            let name = def.name.replace('_', " ");
            let state = if is_in { "in use" } else { "left out" };
            let galley = ui.painter().layout_no_wrap(name.clone(), FontId::proportional(11.5), color);
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
                ui.label(def.doc);
            });
        }
    });
}
