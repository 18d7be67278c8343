//! Messages over the viewport's upper left corner: what failed, what was strange, what went well. They never move anything, and the log keeps all of them.

use crate::theme::{self, Palette};
use std::collections::VecDeque;

use egui::{Align2, Area, Color32, Frame, Id, Label, Layout, Margin, Order, Rect, RichText, Ui, vec2};

/// How much a message matters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Severity {
    /// Something was done.
    Info,
    /// Something is strange; nothing is lost.
    Warning,
    /// Something could not be done; nothing is lost.
    Error,
}

/// A message.
#[derive(Clone, Debug, PartialEq)]
pub struct Message {
    /// How much it matters.
    pub severity: Severity,
    /// One sentence.
    pub text: String,
    /// When it was first shown, seconds; `None` before that.
    since: Option<f64>,
}

/// Seconds after which a warning leaves the picture; the log keeps it. Errors stay until they are dismissed.
const WARNING_SECONDS: f64 = 15.0;
/// Messages shown at once.
const MAX_SHOWN: usize = 5;
/// Messages in the log.
const MAX_LOGGED: usize = 1000;

/// The messages that were not dismissed.
#[derive(Clone, Debug, Default)]
pub struct Messages {
    list: Vec<Message>,
    /// The newest information, which stays in the status line.
    last_info: String,
    /// Everything that was said, oldest first.
    log: VecDeque<(Severity, String)>,
}

impl Messages {
    /// Something was done. Shown in the status line.
    pub fn info(&mut self, text: impl Into<String>) {
        self.last_info = text.into();
        self.note(Severity::Info, self.last_info.clone());
    }

    /// Something is strange.
    pub fn warning(&mut self, text: impl Into<String>) {
        self.push(Severity::Warning, text.into());
    }

    /// Something failed.
    pub fn error(&mut self, text: impl Into<String>) {
        self.push(Severity::Error, text.into());
    }

    fn note(&mut self, severity: Severity, text: String) {
        self.log.push_back((severity, text));
        if self.log.len() > MAX_LOGGED {
            self.log.pop_front();
        }
    }

    fn push(&mut self, severity: Severity, text: String) {
        self.note(severity, text.clone());
        self.list.retain(|message| message.text != text);
        self.list.push(Message { severity, text, since: None });
    }

    /// What was done last.
    pub fn last_info(&self) -> &str {
        &self.last_info
    }

    /// All messages, oldest first.
    pub fn iter(&self) -> impl Iterator<Item = &Message> {
        self.list.iter()
    }

    /// Shows the messages inside `place`.
    pub fn show(&mut self, ui: &Ui, place: Rect) {
        let now = ui.input(|i| i.time);
        for message in &mut self.list {
            message.since.get_or_insert(now);
        }
        self.list.retain(|m| m.severity == Severity::Error || m.since.is_none_or(|since| now - since < WARNING_SECONDS));
        if self.list.is_empty() {
            return;
        }
        if self.list.iter().any(|m| m.severity != Severity::Error) {
            ui.ctx().request_repaint_after_secs(1.0);
        }
        let mut dismissed = None;
        Area::new(Id::unique("messages"))
            .order(Order::Middle)
            .pivot(Align2::LEFT_TOP)
            .fixed_pos(place.left_top() + vec2(10.0, 10.0))
            .constrain_to(place)
            .show(ui.ctx(), |ui| {
                ui.set_max_width((place.width() - 20.0).clamp(120.0, 560.0));
                let hidden = self.list.len().saturating_sub(MAX_SHOWN);
                for (i, message) in self.list.iter().enumerate().skip(hidden) {
                    show_one(ui, i, message, &mut dismissed);
                }
                if hidden > 0 {
                    ui.label(RichText::new(format!("{hidden} older messages")).small().weak());
                }
            });
        if let Some(index) = dismissed {
            self.list.remove(index);
        }
    }
}

fn look(severity: Severity, palette: &Palette) -> (Color32, &'static str) {
    match severity {
        Severity::Info => (palette.text, "ℹ"),
        Severity::Warning => (palette.warning, "⚠"),
        Severity::Error => (palette.error, "⊗"),
    }
}

/// Shows everything that was said, newest first.
pub fn show_log(ui: &mut Ui, messages: &mut Messages) {
    let count = messages.log.len();
    let height = ui.text_style_height(&egui::TextStyle::Body);
    egui::ScrollArea::vertical().auto_shrink([false, false]).show_rows(ui, height, count, |ui, rows| {
        for row in rows {
            let Some((severity, text)) = messages.log.get(count - 1 - row) else { continue };
            let (color, icon) = look(*severity, theme::now());
            ui.horizontal(|ui| {
                ui.label(RichText::new(icon).color(color));
                ui.add(Label::new(text).truncate()).on_hover_text(text);
            });
        }
    });
}

fn show_one(ui: &mut Ui, index: usize, message: &Message, dismissed: &mut Option<usize>) {
    let (color, icon) = look(message.severity, theme::ON_PICTURE);
    Frame::new()
        .fill(Color32::from_black_alpha(215))
        .stroke((1.0, color.gamma_multiply(0.5)))
        .corner_radius(4)
        .inner_margin(Margin::symmetric(8, 5))
        .show(ui, |ui| {
            ui.set_width(ui.available_width());
            ui.horizontal_top(|ui| {
                ui.label(RichText::new(icon).color(color));
                let text_width = (ui.available_width() - 30.0).max(60.0);
                ui.allocate_ui_with_layout(vec2(text_width, 0.0), Layout::top_down(egui::Align::Min), |ui| {
                    ui.set_width(text_width);
                    ui.add(Label::new(RichText::new(&message.text).color(theme::ON_PICTURE.text)).wrap());
                });
                let button = ui.add(egui::Button::new("×").frame_when_inactive(false));
                if button.accessible_name(format!("Dismiss message {}", index + 1)).clicked() {
                    *dismissed = Some(index);
                }
            });
        });
}
