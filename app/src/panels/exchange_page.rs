//! The page before an export: into which format, and what that costs, property by property.

use crate::exchange::measure::Measured;
use crate::exchange::{FORMATS, Format, rows};
use crate::theme;
use burnish_material::exchange::ShadingModel;
use burnish_material::exchange::loss::{Fate, Row};
use burnish_material::{Material, Property};
use egui::{Align, ComboBox, Label, Layout, ProgressBar, RichText, ScrollArea, Ui, vec2};

/// What the page asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExchangeAction {
    /// Choose a file and write it.
    Export,
    /// Draw the material before and after.
    Measure,
    /// End that.
    Stop,
}

/// The page.
#[derive(Clone, Debug)]
pub struct ExchangePage {
    /// The format.
    pub format: Format,
    /// Name of the model that was chosen, where the format has several.
    model: &'static str,
    /// Whether the mesh goes along, where the format can hold one.
    pub has_mesh: bool,
    /// Whether only what is lost is listed.
    is_short: bool,
    /// What the rows are about.
    known: Option<(Format, &'static str, Material)>,
    rows: Vec<Row>,
    /// What the pictures told, as long as nothing has changed since.
    measured: Option<Measured>,
}

impl Default for ExchangePage {
    fn default() -> Self {
        Self { format: Format::Gltf, model: "", has_mesh: true, is_short: true, known: None, rows: Vec::new(), measured: None }
    }
}

impl ExchangePage {
    /// What the material becomes for other programs; `None` for a format that brings ASM along.
    pub fn model(&self) -> Option<&'static ShadingModel> {
        let def = self.format.def();
        def.models.iter().copied().find(|model| model.name == self.model).or(def.model())
    }

    /// Takes what pictures of this material in this model told; what has changed since is told anew.
    pub fn take_measured(&mut self, model: &ShadingModel, material: &Material, measured: Measured) {
        if self.known.as_ref().is_some_and(|(_, known, same)| *known == model.name && same == material) {
            self.measured = Some(measured);
        }
    }

    /// What becomes of each property.
    pub fn rows(&self) -> &[Row] {
        &self.rows
    }

    fn update(&mut self, material: &Material) {
        let (model, format) = (self.model(), self.format);
        let name = model.map_or("", |model| model.name);
        if self.known.as_ref().is_some_and(|(known, of, same)| (*known, *of) == (format, name) && same == material) {
            return;
        }
        self.rows = rows(format, model, material);
        (self.known, self.measured) = (Some((format, name, material.clone())), None);
    }

    /// Shows the page. `share`: how far measuring is, if it goes on.
    pub fn show(&mut self, ui: &mut Ui, material: &Material, share: Option<f32>) -> Option<ExchangeAction> {
        let mut action = None;
        ui.horizontal(|ui| {
            ui.label("Format");
            let combo = ComboBox::from_id_salt("exchange format").selected_text(self.format.def().label).show_ui(ui, |ui| {
                for def in FORMATS.iter().filter(|def| def.format != Format::Native) {
                    ui.selectable_value(&mut self.format, def.format, format!("{} (.{})", def.label, def.ending));
                }
            });
            combo.response.accessible_name("Format of the export");
            if let (Some(model), several @ [_, _, ..]) = (self.model(), self.format.def().models) {
                let combo = ComboBox::from_id_salt("exchange model").selected_text(model.label).show_ui(ui, |ui| {
                    for def in several {
                        let is_chosen = def.name == model.name;
                        if ui.selectable_label(is_chosen, def.label).clicked() {
                            self.model = def.name;
                        }
                    }
                });
                combo.response.accessible_name("Model of the export").on_hover_text("What the material is for other programs");
            }
            let holds_mesh = matches!(self.format, Format::Gltf | Format::Glb | Format::Usda | Format::Usdz);
            ui.add_enabled(holds_mesh, egui::Checkbox::new(&mut self.has_mesh, "with the mesh"));
            ui.checkbox(&mut self.is_short, "only what changes");
        });
        self.update(material);
        ui.label(RichText::new(self.summary()).strong());
        ui.label(
            RichText::new(
                "This is what other programs see. Burnish itself reads everything back bit by bit from a copy in the file.",
            )
            .weak(),
        );
        ui.add_space(4.0);
        let shown: Vec<&Row> = self.rows.iter().filter(|row| !self.is_short || row.fate > Fate::Remapped).collect();
        let height = (ui.available_height() - 74.0).max(80.0);
        ScrollArea::vertical().max_height(height).auto_shrink([false, false]).show(ui, |ui| {
            if shown.is_empty() {
                ui.label("Nothing is lost.");
            }
            for row in shown {
                ui.horizontal_top(|ui| {
                    cell(ui, 150.0, Label::new(row.property.def().label).truncate());
                    cell(ui, 100.0, Label::new(RichText::new(row.fate.word()).color(fate_color(row.fate))));
                    ui.vertical(|ui| {
                        ui.add(Label::new(&row.note).wrap());
                        if !row.target.is_empty() {
                            ui.add(Label::new(RichText::new(&row.target).small().weak()).wrap());
                        }
                    });
                });
                ui.separator();
            }
        });
        ui.add_space(4.0);
        match (share, &self.measured) {
            (Some(share), _) => {
                ui.horizontal(|ui| {
                    ui.add(ProgressBar::new(share).desired_width(220.0).text("drawing before and after"));
                    if ui.button("Stop").clicked() {
                        action = Some(ExchangeAction::Stop);
                    }
                });
            }
            (None, Some(measured)) => _ = ui.label(sentence(measured)),
            (None, None) if self.format.def().models.is_empty() => {}
            (None, None) => {
                let button = ui.button("Measure the difference");
                if button.on_hover_text("Draws the material as it is and as other programs see it, and tells which property explains the difference.").clicked() {
                    action = Some(ExchangeAction::Measure);
                }
            }
        }
        if ui.button("Export…").clicked() {
            action = Some(ExchangeAction::Export);
        }
        action
    }

    fn summary(&self) -> String {
        let of = |fate: Fate| self.rows.iter().filter(|row| row.fate == fate).count();
        Fate::ALL.iter().map(|(fate, word)| format!("{} {word}", of(*fate))).collect::<Vec<_>>().join(", ")
    }
}

/// A label at the left of its column.
fn cell(ui: &mut Ui, width: f32, label: Label) {
    let size = vec2(width, ui.spacing().interact_size.y);
    ui.allocate_ui_with_layout(size, Layout::left_to_right(Align::Center), |ui| {
        ui.set_min_width(width);
        ui.add(label);
    });
}

/// What the pictures told, in a sentence.
fn sentence(measured: &Measured) -> String {
    let name = |property: Property| property.def().label;
    let because = measured.explanation().map_or_else(String::new, |(property, alone)| {
        format!("; most of it is due to {} ({:.1} % alone)", name(property), 100.0 * alone)
    });
    format!("Difference to other programs: {:.1} % (FLIP){because}.", 100.0 * measured.flip_mean)
}

fn fate_color(fate: Fate) -> egui::Color32 {
    let theme = theme::now();
    match fate {
        Fate::Exact | Fate::Remapped => theme.text,
        Fate::Approximated => theme.warning,
        Fate::Dropped => theme.error,
    }
}
