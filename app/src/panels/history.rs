//! The steps made in the document in front, to click back to.

use crate::history::History;
use crate::theme;
use egui::{Button, Color32, RichText, ScrollArea, Ui};

/// Shows the list, newest first; the place of the step that was clicked.
pub fn show(ui: &mut Ui, history: &History) -> Option<usize> {
    let labels: Vec<(&str, bool)> = history.labels().collect();
    let mut chosen = None;
    let height = ui.spacing().interact_size.y;
    let now = labels.iter().position(|(_, is_now)| *is_now).unwrap_or(0);
    // Thousands of steps cost no more than those that are seen.
    ScrollArea::vertical().auto_shrink([false, false]).show_rows(ui, height, labels.len(), |ui, rows| {
        for row in rows {
            let index = labels.len() - 1 - row;
            let (label, is_now) = labels[index];
            let text = RichText::new(label).color(if index > now { theme::now().weak } else { theme::now().text });
            let button = Button::selectable(is_now, text).truncate().min_size(egui::vec2(0.0, height));
            let button = if is_now { button } else { button.fill(Color32::TRANSPARENT) };
            let response = ui.add(button);
            let state = if index > now { ", taken back" } else { "" };
            response.widget_info(|| {
                egui::WidgetInfo::selected(egui::Role::Button, true, is_now, format!("Step {}: {label}{state}", index + 1))
            });
            if response.clicked() && !is_now {
                chosen = Some(index);
            }
        }
    });
    chosen
}
