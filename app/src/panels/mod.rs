//! The parts of the window, one file each. A panel edits the document or asks for something; it carries nothing out.

pub mod axis;
pub mod batch_page;
pub mod chart;
pub mod diff;
pub mod exchange_page;
pub mod explain;
pub mod export;
pub mod finding;
pub mod help;
pub mod history;
pub mod library;
pub mod measured_page;
pub mod merge;
pub mod messages;
pub mod pack_page;
pub mod palette;
pub mod preferences;
pub mod presets;
pub mod properties;
pub mod property_page;
pub mod reference;
pub mod release;
pub mod source_picker;
pub mod stability;
pub mod status;
pub mod texture_page;
pub mod toolbar;
pub mod validation;
pub mod viewport;
pub mod wipe;

/// Draws a side panel's content in exactly the panel's space.
///
/// A row that is a little too wide would otherwise widen the panel, and the next frame's rows with it.
pub fn hold<R>(ui: &mut egui::Ui, content: impl FnOnce(&mut egui::Ui) -> R) -> R {
    let rect = ui.available_rect_before_wrap();
    let mut inner = ui.new_child(egui::UiBuilder::new().max_rect(rect).layout(egui::Layout::top_down(egui::Align::Min)));
    inner.set_clip_rect(rect.intersect(ui.clip_rect()));
    let result = content(&mut inner);
    ui.advance_cursor_after_rect(rect);
    result
}
