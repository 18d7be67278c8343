//! Parts of the list of findings: one in full, two files that are one, and how both are told.

use super::validation::{ValidationAction, ValidationView};
use crate::library::check::{Kind, Pair, Row};
use crate::theme;
use burnish_material::Property;
use egui::{Button, Label, RichText, ScrollArea, Ui};
use std::path::{Path, PathBuf};

/// What was selected, in full.
pub fn details(ui: &mut Ui, row: &Row, view: &ValidationView) -> Option<ValidationAction> {
    let mut action = None;
    ui.horizontal(|ui| {
        let open = ui.small_button("Open").on_hover_text("Open the file with the property in sight");
        if open.accessible_name(format!("Open {} at {}", file_name(&row.path), row.key)).clicked() {
            action = Some(ValidationAction::Open(row.path.clone(), property_of(row)));
        }
        let line = row.line.map_or_else(String::new, |line| format!(", line {line}"));
        let key = if row.key.is_empty() { String::new() } else { format!(": {}", row.key) };
        let text = format!("{}{line}{key}", short(&row.path, view.root));
        ui.add(Label::new(RichText::new(text).small().color(theme::now().weak)).truncate());
    });
    let height = (0.22 * ui.available_height()).clamp(18.0, 64.0);
    ScrollArea::vertical().id_salt("details").max_height(height).min_scrolled_height(height).show(ui, |ui| {
        ui.add(Label::new(RichText::new(sentence(row, view.root)).color(theme::now().strong)).wrap());
    });
    action
}

/// Two files that are one material, with what can be done about it.
pub fn pair_line(ui: &mut Ui, pair: &Pair, view: &ValidationView, height: f32) -> Option<ValidationAction> {
    let mut action = None;
    ui.allocate_ui_with_layout(
        egui::vec2(ui.available_width(), height),
        egui::Layout::right_to_left(egui::Align::Center),
        |ui| {
            ui.spacing_mut().item_spacing.x = 3.0;
            // A copy has the longer name mostly, and the other one is to stay.
            let length = |path: &PathBuf| path.as_os_str().len();
            let (first, second) = if length(&pair.b) < length(&pair.a) { (&pair.b, &pair.a) } else { (&pair.a, &pair.b) };
            let [a, b] = [first, second].map(|path| short(path, view.root));
            let unite = ui.add_enabled(view.root.is_some(), Button::new("Merge").small());
            let tip = format!("{a} gets the names of {b} as other names, and {b} goes: one step that undo takes back");
            if unite.accessible_name(format!("Merge {a} and {b}")).on_hover_text(tip).clicked() {
                action = Some(ValidationAction::Unite(first.clone(), second.clone()));
            }
            let diff = ui.add(Button::new("Side by side").small());
            if diff
                .accessible_name(format!("Side by side {a} and {b}"))
                .on_hover_text("Values and pictures beside each other")
                .clicked()
            {
                action = Some(ValidationAction::Diff(first.clone(), second.clone()));
            }
            let what = match pair.kind {
                Kind::Value => "same values".to_owned(),
                _ => format!("{:.2} % apart", 100.0 * pair.distance),
            };
            ui.with_layout(egui::Layout::left_to_right(egui::Align::Center), |ui| {
                let text = format!("🗐 {a} = {b}, {what}");
                ui.add(Label::new(RichText::new(&text).color(theme::now().accent)).truncate()).on_hover_text(text);
            });
        },
    );
    action
}

/// What was found, with paths from the library's folder.
pub fn sentence(row: &Row, root: Option<&Path>) -> String {
    match root {
        Some(root) => row.message.replace(&format!("{}{}", root.display(), std::path::MAIN_SEPARATOR), ""),
        None => row.message.clone(),
    }
}

/// The property that a row is about.
pub fn property_of(row: &Row) -> Option<Property> {
    Property::from_name(row.key.split('.').next().unwrap_or_default())
}

/// The name of a file.
pub fn file_name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

/// A path from the library's folder, without what all files end in.
pub fn short(path: &Path, root: Option<&Path>) -> String {
    let below = root.and_then(|root| path.strip_prefix(root).ok()).unwrap_or(path);
    let text = below.to_string_lossy();
    text.strip_suffix(".asm.ron").map_or_else(|| text.to_string(), str::to_owned)
}
