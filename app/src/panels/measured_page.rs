//! The page with all measured materials: what was measured, by whom, how far datasets are apart; one of them becomes a new material.

use crate::theme;
use crate::widgets::color_edit::display_color;
use crate::widgets::row_notes::value_text;
use crate::widgets::search_field::search_field;
use burnish_material::{Property, Unit, Value};
use burnish_presets::measured::{Measured, measured};
use egui::{Button, Grid, Label, RichText, ScrollArea, Sense, Ui, vec2};

/// What is typed and chosen.
#[derive(Clone, Debug, Default)]
pub struct MeasuredPage {
    search: String,
    chosen: Option<&'static str>,
    /// Whether it was opened just now: what is typed next is searched for.
    is_new: bool,
}

impl MeasuredPage {
    /// It is opened.
    pub fn begin(&mut self) {
        self.is_new = true;
    }

    /// Shows the page; the measurement that is to become a material.
    pub fn show(&mut self, ui: &mut Ui) -> Option<&'static Measured> {
        let line = search_field(ui, &mut self.search, "Search measured materials", "copper, glass, milk…");
        if std::mem::take(&mut self.is_new) {
            line.request_focus();
        }
        ui.add_space(4.0);
        let words = self.search.to_lowercase();
        let holds = |row: &&Measured| {
            let text = format!("{} {} {}", row.name, row.group, row.reference).to_lowercase();
            words.split_whitespace().all(|word| text.contains(word))
        };
        let found: Vec<&'static Measured> = measured().iter().filter(holds).collect();
        let height = ui.spacing().interact_size.y;
        ui.push_id("rows", |ui| {
            ScrollArea::vertical().max_height(210.0).auto_shrink([false, false]).show_rows(
                ui,
                height,
                found.len(),
                |ui, rows| {
                    for row in &found[rows] {
                        let text = format!("{}  ·  {}", row.name, row.group);
                        let note = row.dataset.rsplit('/').next().unwrap_or(row.dataset).trim_end_matches(')');
                        let button = Button::selectable(self.chosen == Some(row.id), text).shortcut_text(note).truncate();
                        if ui.add_sized([ui.available_width(), height], button).clicked() {
                            self.chosen = Some(row.id);
                        }
                    }
                },
            );
        });
        ui.separator();
        let Some(row) = self.chosen.and_then(burnish_presets::measured::find) else {
            ui.label(RichText::new("Choose a measurement. Several datasets of one material stand below each other.").weak());
            return None;
        };
        details(ui, row);
        ui.add_space(6.0);
        ui.button(format!("New material from {}", row.name)).clicked().then_some(row)
    }
}

/// Values, spread and sources of a measurement.
fn details(ui: &mut Ui, row: &'static Measured) {
    Grid::new("values").num_columns(3).spacing(vec2(14.0, 3.0)).show(ui, |ui| {
        for (property, value) in &row.values {
            ui.label(property.def().label);
            ui.horizontal(|ui| {
                if let Value::Color(color) = value {
                    let (rect, _) = ui.allocate_exact_size(vec2(14.0, 14.0), Sense::hover());
                    ui.painter().rect(rect, 2, display_color(*color), (1.0, theme::now().line), egui::StrokeKind::Inside);
                }
                ui.label(with_unit(*property, *value));
            });
            let spread = row.spread(*property).map(|(low, high)| format!("{} to {}", value_text(low), value_text(high)));
            ui.label(RichText::new(spread.unwrap_or_default()).small().weak());
            ui.end_row();
        }
    });
    ui.add_space(4.0);
    for text in [row.reference, row.dataset, row.licence] {
        ui.add(Label::new(RichText::new(text).small().weak()).wrap());
    }
}

fn with_unit(property: Property, value: Value) -> String {
    let unit = if property.def().unit == Unit::Length { " mm" } else { "" };
    format!("{}{unit}", value_text(value))
}
