//! A turntable: what turns, how far it is, how long it will take at which error, and its frames.

use super::picture::{stop_fields, whole};
use super::{Around, ExportAction, ExportPanel, heading, note, row, section};
use crate::live_export::{FrameState, Row, due};
use crate::offline::picture_options::stop_rules;
pub use crate::offline::turntable::duration;
use crate::offline::turntable::{MAX_FRAMES, Turn};
use crate::theme;
use crate::widgets::number_field::NumberField;
use burnish_renderer::path::StopRules;
use egui::{Label, RichText, ScrollArea, Slider, Ui};
use std::path::PathBuf;

/// Errors of a frame that can be chosen with the slider, percent.
const PERCENT: std::ops::RangeInclusive<f64> = 0.1..=10.0;
/// Errors whose time is listed, percent.
const LISTED: [f64; 5] = [0.5, 1.0, 2.0, 3.0, 5.0];

impl ExportPanel {
    /// The settings of a turntable, its prediction and its frames.
    pub(super) fn turntable(&mut self, ui: &mut Ui, around: &mut Around<'_>) -> Option<ExportAction> {
        let mut action = None;
        let before = (self.frames, self.turn, self.degrees.to_bits());
        section(ui, "Turn", |ui| {
            row(ui, "Frames", |ui| {
                if let Some(frames) = whole(ui, "Frames of the turntable", f64::from(self.frames), f64::from(MAX_FRAMES)) {
                    self.frames = frames as u32;
                }
                ui.label("over");
                let field = NumberField { range: -3600.0..=3600.0, ..NumberField::plain("Degrees of the turntable", 54.0, 1.0) };
                self.degrees = field.show(ui, self.degrees).unwrap_or(self.degrees);
                ui.label("°");
            });
            row(ui, "Turns", |ui| {
                ui.radio_value(&mut self.turn, Turn::Object, "object").on_hover_text("The light stays where it is");
                ui.radio_value(&mut self.turn, Turn::Light, "light").on_hover_text("The object stays where it is");
            });
            row(ui, "Folder", |ui| {
                if ui.button("Choose…").accessible_name("Choose the folder of the turntable").clicked() {
                    action = Some(ExportAction::ChooseFolder);
                }
                let name = |folder: &PathBuf| folder.file_name().unwrap_or(folder.as_os_str()).to_string_lossy().into_owned();
                let name = self.folder.as_ref().map_or_else(|| "none yet".to_owned(), name);
                let label = ui.add(Label::new(RichText::new(name).small()).truncate());
                if let Some(folder) = &self.folder {
                    label.on_hover_text(folder.display().to_string());
                }
            });
        });
        if before != (self.frames, self.turn, self.degrees.to_bits()) {
            (self.prediction, self.rows) = (None, Vec::new());
        }
        if !self.rows.is_empty() {
            self.frame_list(ui);
        }
        self.predicted(ui);
        stop_fields(ui, &mut self.frame_stop, " of a frame");
        self.content(ui, around);
        action
    }

    /// Frames that are due since they hit their time limit, and for other reasons.
    pub fn due(&self) -> (usize, usize) {
        due(&self.rows, &self.frame_rules())
    }

    fn frame_rules(&self) -> StopRules {
        stop_rules(self.frame_stop.spp, self.frame_stop.seconds, self.frame_stop.relmse)
    }

    /// What the button says that starts.
    pub(super) fn start_text(&self) -> String {
        let (limited, left) = self.due();
        let goal = self.frame_stop.relmse.map_or_else(String::new, |relmse| format!(" to {}", percent(relmse)));
        match (self.rows.is_empty(), limited, left) {
            (true, ..) => format!("Start {} frames", self.frames),
            (false, 0, 0) => "Check all frames".to_owned(),
            (false, limited, 0) => format!("Resume those {limited}{goal}"),
            (false, _, left) if left == self.rows.len() => format!("Start {left} frames"),
            (false, limited, left) => format!("Resume {} frames{goal}", limited + left),
        }
    }

    /// The time that all frames take, and a slider that makes it fit.
    fn predicted(&mut self, ui: &mut Ui) {
        let rules = self.frame_rules();
        let Some((prediction, due)) = &mut self.prediction else { return };
        let due = *due;
        // The other rules may have changed since.
        prediction.rules = rules;
        heading(ui, "Prediction");
        let alone = prediction.without_limits();
        let listed = LISTED.iter().filter_map(|at| {
            let total = alone.total(Some((0.01 * at) * (0.01 * at)), due)?;
            Some(format!("{at} %: {}", duration(total)).replace(' ', "\u{a0}"))
        });
        note(ui, &format!("All {due} frames to   {}", listed.collect::<Vec<_>>().join("   ")));
        let mut at = self.frame_stop.relmse.map_or(*PERCENT.end(), |relmse| 100.0 * relmse.sqrt());
        let slider = Slider::new(&mut at, PERCENT).logarithmic(true).suffix(" %").max_decimals(2);
        let response = ui.horizontal(|ui| {
            ui.label("Error");
            ui.spacing_mut().slider_width = (ui.available_width() - 80.0).max(60.0);
            ui.add(slider).accessible_name("Error of a frame, percent")
        });
        if response.inner.changed() {
            self.frame_stop.relmse = Some((0.01 * at) * (0.01 * at));
        }
        let relmse = self.frame_stop.relmse;
        let text = match (prediction.total(relmse, due), prediction.slowest(relmse)) {
            (Some(total), Some((name, seconds))) => {
                let goal = relmse.map_or_else(String::new, |relmse| format!(" at {}", percent(relmse)));
                let limited = relmse.map(|relmse| prediction.limited(relmse)).filter(|(limited, _)| *limited > 0);
                let limited = limited.map_or_else(String::new, |(limited, probes)| {
                    format!("; {limited} of {probes} probes end before that, by another limit")
                });
                let (total, seconds) = (duration(total), duration(seconds));
                format!("About {total} for {due} frames{goal}; the slowest, {name}, {seconds}{limited}")
            }
            _ => "The probes tell no error yet.".to_owned(),
        };
        ui.add(Label::new(RichText::new(text).color(theme::now().accent)).wrap());
    }

    fn frame_list(&self, ui: &mut Ui) {
        let ((limited, left), rules) = (self.due(), self.frame_rules());
        let finished = self.rows.len() - left - limited;
        heading(ui, "Frames");
        let marked = if limited > 0 { format!(", {limited} hit the time limit") } else { String::new() };
        note(ui, &format!("{finished} of {} done{marked}", self.rows.len()));
        let height = ui.text_style_height(&egui::TextStyle::Small);
        let shown = (height + ui.spacing().item_spacing.y) * self.rows.len().min(8) as f32;
        ScrollArea::vertical().id_salt("frames").max_height(shown).auto_shrink([false, true]).show_rows(
            ui,
            height,
            self.rows.len(),
            |ui, range| {
                for row in range.filter_map(|index| self.rows.get(index)) {
                    let (color, text) = told(row, row.is_due(&rules));
                    ui.add(Label::new(RichText::new(text).small().color(color)).truncate());
                }
            },
        );
    }
}

/// A frame in one line.
fn told(row: &Row, is_due: bool) -> (egui::Color32, String) {
    let reached = row.relmse.map_or_else(String::new, |relmse| format!("   {}", percent(relmse)));
    let time = duration(row.seconds);
    let palette = theme::now();
    match row.state {
        FrameState::Waiting => (palette.weak, format!("·  {}", row.name)),
        FrameState::Working => (palette.accent, format!("▶  {}   rendering", row.name)),
        FrameState::Limited if is_due => (palette.warning, format!("⚠  {}{reached}   {time}, hit its time limit", row.name)),
        _ if is_due => (palette.weak, format!("·  {}{reached}   {time}, to go on", row.name)),
        _ => (palette.text, format!("✔  {}{reached}   {time}", row.name)),
    }
}

/// A relMSE as the percentage whose square it is.
pub fn percent(relmse: f64) -> String {
    let percent = 100.0 * relmse.max(0.0).sqrt();
    if percent < 1.0 { format!("{percent:.2} %") } else { format!("{percent:.1} %") }
}
