//! A line to search by, with a button that empties it.

use egui::{Button, Layout, Response, TextEdit, Ui, vec2};

/// Shows the field over the whole width. `name` is for screen readers, `hint` stands in the empty field. Returns the line itself.
pub fn search_field(ui: &mut Ui, text: &mut String, name: &str, hint: &str) -> Response {
    let size = vec2(ui.available_width(), ui.spacing().interact_size.y);
    ui.allocate_ui_with_layout(size, Layout::right_to_left(egui::Align::Center), |ui| {
        ui.spacing_mut().button_padding = vec2(4.0, 1.0);
        let clear = ui.add_enabled(!text.is_empty(), Button::new("×").frame_when_inactive(false));
        if clear.accessible_name(format!("Clear {}", name.to_lowercase())).clicked() {
            text.clear();
        }
        let edit = TextEdit::singleline(text).hint_text(hint).desired_width(f32::INFINITY);
        ui.add(edit).accessible_name(name)
    })
    .inner
}
