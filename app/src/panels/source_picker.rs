//! A list to choose a material from: open documents, selected files of the library, any file.

use crate::sources::Source;
use egui::{ComboBox, Ui};
use std::path::Path;

/// What can be chosen, with what it is called.
pub type Choices = [(Source, String)];

/// What was chosen.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Picked {
    /// One of the list, or none.
    Source(Option<Source>),
    /// A file that is to be chosen.
    ChooseFile,
}

/// The name of a file without its ending, and its folder.
fn file_title(path: &Path) -> String {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let folder = path.parent().map(|folder| folder.display().to_string()).unwrap_or_default();
    format!("{} ({folder})", name.trim_end_matches(".asm.ron"))
}

/// Shows the list; `none` is what no choice is called where that is possible, `name` is for screen readers.
pub fn show(
    ui: &mut Ui,
    name: &str,
    width: f32,
    chosen: Option<&Source>,
    choices: &Choices,
    none: Option<&str>,
) -> Option<Picked> {
    let mut picked = None;
    let title = |source: &Source| match choices.iter().find(|(other, _)| other == source) {
        Some((_, title)) => title.clone(),
        None => match source {
            Source::File(path) => file_title(path),
            _ => "(closed)".to_owned(),
        },
    };
    let text = chosen.map_or_else(|| none.unwrap_or("Choose…").to_owned(), title);
    let combo = ComboBox::from_id_salt(name).width(width).truncate().selected_text(text).show_ui(ui, |ui| {
        if let Some(none) = none
            && ui.selectable_label(chosen.is_none(), none).clicked()
        {
            picked = Some(Picked::Source(None));
        }
        for (source, title) in choices {
            if ui.selectable_label(chosen == Some(source), title).clicked() {
                picked = Some(Picked::Source(Some(source.clone())));
            }
        }
        ui.separator();
        if ui.button("Choose a file…").clicked() {
            picked = Some(Picked::ChooseFile);
        }
    });
    let response = combo.response.accessible_name(name);
    if let Some(Source::File(path)) = chosen {
        response.on_hover_text(path.display().to_string());
    }
    picked
}
