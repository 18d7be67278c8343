//! The page that changes tags, licence and values of many materials in one step.

use crate::library::edit::Change;
use crate::widgets::value_edit::{exact_text, pasted};
use burnish_material::{DEFAULT_UNIT_MM, PROPERTIES, Property, Value};
use egui::{Button, ComboBox, Grid, TextEdit, Ui};
use std::path::PathBuf;

/// What is typed on the page.
#[derive(Clone, Debug, Default)]
pub struct BatchPage {
    /// The files, as whole paths.
    pub paths: Vec<PathBuf>,
    add: String,
    remove: String,
    licence: String,
    sets_licence: bool,
    property: Option<Property>,
    value: String,
}

impl BatchPage {
    /// For these files, with nothing typed.
    pub fn new(paths: Vec<PathBuf>) -> Self {
        Self { paths, ..Self::default() }
    }

    /// The changes that are typed; an error where a value cannot be read.
    fn changes(&self) -> Result<Vec<Change>, String> {
        let words =
            |text: &str| text.split(',').map(str::trim).filter(|word| !word.is_empty()).map(str::to_owned).collect::<Vec<_>>();
        let mut changes: Vec<Change> = words(&self.add).into_iter().map(Change::AddTag).collect();
        changes.extend(words(&self.remove).into_iter().map(Change::RemoveTag));
        if self.sets_licence {
            changes.push(Change::SetLicence(self.licence.trim().to_owned()));
        }
        if let Some(property) = self.property {
            let value = pasted(property.def(), &self.value, DEFAULT_UNIT_MM);
            let value = value.ok_or_else(|| format!("{}: expected {}", property.def().label, example(property)))?;
            changes.push(Change::SetValue(property, value));
        }
        Ok(changes)
    }

    /// Shows the page; the changes to make when the user says so.
    pub fn show(&mut self, ui: &mut Ui) -> Option<Vec<Change>> {
        let count = self.paths.len();
        ui.label(format!("{count} material{}; one step that can be taken back.", if count == 1 { "" } else { "s" }));
        ui.add_space(6.0);
        Grid::new("batch edit").num_columns(2).spacing(egui::vec2(12.0, 6.0)).show(ui, |ui| {
            ui.label("Add tags");
            ui.add(TextEdit::singleline(&mut self.add).hint_text("metal, worn").desired_width(260.0)).accessible_name("Add tags");
            ui.end_row();
            ui.label("Remove tags");
            ui.add(TextEdit::singleline(&mut self.remove).desired_width(260.0)).accessible_name("Remove tags");
            ui.end_row();
            ui.checkbox(&mut self.sets_licence, "Licence");
            let field = TextEdit::singleline(&mut self.licence).hint_text("CC0-1.0").desired_width(260.0);
            ui.add_enabled(self.sets_licence, field).accessible_name("Licence of all");
            ui.end_row();
            ui.label("Value");
            ui.horizontal(|ui| {
                let shown = self.property.map_or("none", |property| property.def().label);
                let combo = ComboBox::from_id_salt("property").width(150.0).selected_text(shown).show_ui(ui, |ui| {
                    ui.selectable_value(&mut self.property, None, "none");
                    for def in PROPERTIES.iter().filter(|def| !matches!(def.default, Value::Normal(_))) {
                        if ui.selectable_label(self.property == Some(def.id), def.label).clicked() {
                            (self.property, self.value) = (Some(def.id), exact_text(def.default));
                        }
                    }
                });
                combo.response.accessible_name("Property of all");
                ui.add_enabled(self.property.is_some(), TextEdit::singleline(&mut self.value).desired_width(98.0))
                    .accessible_name("Value of all");
            });
            ui.end_row();
        });
        let changes = self.changes();
        if let Err(problem) = &changes {
            ui.label(egui::RichText::new(format!("⚠ {problem}")).color(crate::theme::now().warning));
        }
        ui.add_space(8.0);
        let changes = changes.unwrap_or_default();
        let text = format!("Change {count} material{}", if count == 1 { "" } else { "s" });
        ui.add_enabled(!changes.is_empty(), Button::new(text)).clicked().then_some(changes)
    }
}

/// What may be typed for a property.
fn example(property: Property) -> &'static str {
    match property.def().default {
        Value::Float(_) => "a number such as 0.5, 20/64 or 30%",
        Value::Bool(_) => "on or off",
        Value::Color(_) | Value::Normal(_) => "three numbers or #RRGGBB",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_typed_becomes_changes() {
        let edit = BatchPage {
            add: "metal, worn ,".into(),
            remove: "old".into(),
            sets_licence: true,
            licence: " CC0-1.0 ".into(),
            property: Some(Property::roughness),
            value: "20/64".into(),
            ..BatchPage::default()
        };
        let expected = [
            Change::AddTag("metal".into()),
            Change::AddTag("worn".into()),
            Change::RemoveTag("old".into()),
            Change::SetLicence("CC0-1.0".into()),
            Change::SetValue(Property::roughness, Value::Float(0.3125)),
        ];
        assert_eq!(edit.changes().unwrap(), expected);
        assert_eq!(BatchPage { property: None, ..edit.clone() }.changes().unwrap().len(), 4);
        let bad = BatchPage { value: "rough".into(), ..edit };
        assert!(bad.changes().unwrap_err().contains("a number such as"));
    }
}
