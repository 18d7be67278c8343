//! The property panel: every row of the table in the specification's groups, a search over the three names, and what the
//! file says about the material as a whole.

use crate::editor::Document;
use crate::small_pictures::SmallPictures;
use crate::theme;
use crate::widgets::number;
use crate::widgets::number_field::NumberField;
use crate::widgets::search_field::search_field;
use crate::widgets::value_edit::{GUTTER, Row, RowAction, label_width, value_edit};
use burnish_material::{
    Finding, Group, LOBES, LobeSet, Material, PROPERTIES, Property, PropertyDef, Severity, Slot, ValueSource, check,
};
use egui::text::LayoutJob;
use egui::{CollapsingHeader, Rect, RichText, ScrollArea, TextEdit, TextFormat, TextStyle, Ui};
use std::collections::BTreeMap;

/// State of the panel.
#[derive(Clone, Debug, Default)]
pub struct PropertyPanel {
    search: String,
    /// Where each row was drawn last, for dropped images.
    rows: Vec<(Property, Rect)>,
    /// What the file says about the sources of values, read again when the document comes from another file.
    sources: BTreeMap<&'static str, ValueSource>,
    sources_of: Option<Document>,
    /// What is odd about the values, found anew when they change.
    findings: Vec<Finding>,
    findings_of: Option<Material>,
    /// The row that is to be brought into sight.
    sought: Option<Property>,
}

impl PropertyPanel {
    /// Shows the panel and edits the document's material in place.
    ///
    /// `other` is what it is compared with, for marks; `small` has pictures of its maps.
    pub fn show(
        &mut self,
        ui: &mut Ui,
        document: &mut Document,
        other: Option<&Material>,
        small: &mut SmallPictures,
    ) -> Option<RowAction> {
        self.read_sources(document);
        if self.findings_of.as_ref() != Some(&document.material) {
            self.findings = check(&document.material);
            self.findings.retain(|finding| finding.severity == Severity::Warning);
            self.findings_of = Some(document.material.clone());
        }
        self.rows.clear();
        let mut action = None;
        search_field(ui, &mut self.search, "Search properties", "Search the three names");
        ui.add_space(2.0);
        let query = self.search.trim().to_lowercase();
        ScrollArea::vertical().auto_shrink([false, false]).show(ui, |ui| {
            ui.spacing_mut().item_spacing.y = 3.0;
            if query.is_empty() {
                about(ui, document);
            }
            let lobes = LobeSet::of(&document.material);
            let mut is_any_found = false;
            for group in Group::ALL {
                let rows: Vec<&'static PropertyDef> =
                    PROPERTIES.iter().filter(|def| def.group == group && matches(def, &query)).collect();
                if rows.is_empty() {
                    continue;
                }
                is_any_found = true;
                let title = group_title(ui, group, &document.material);
                let mut body = |ui: &mut Ui| {
                    for &def in &rows {
                        action = self.row(ui, def, document, lobes, other, small).or(action);
                    }
                    ui.add_space(4.0);
                };
                if query.is_empty() {
                    CollapsingHeader::new(title).id_salt(group.title()).default_open(true).show_unindented(ui, body);
                } else {
                    ui.label(RichText::new(group.title()).color(theme::now().weak));
                    body(ui);
                }
            }
            if !is_any_found {
                ui.label(RichText::new("No property has this in its name.").weak());
            }
        });
        action
    }

    fn row(
        &mut self,
        ui: &mut Ui,
        def: &'static PropertyDef,
        document: &mut Document,
        lobes: LobeSet,
        other: Option<&Material>,
        small: &mut SmallPictures,
    ) -> Option<RowAction> {
        let texture = document.material.slot(def.id).texture.as_ref();
        let image = texture.and_then(|texture| Some((texture, document.textures.get(&texture.path)?)));
        let is_map_loaded = texture.is_none() || image.is_some();
        let thumbnail = image.and_then(|(texture, image)| small.map(ui.ctx(), &texture.path, image, texture.channel));
        let file = document.file_shared();
        let row = Row {
            unit_mm: document.material.unit_mm(),
            without_effect: without_effect(def.id, lobes),
            unreadable: file.unreadable().iter().find(|unreadable| unreadable.property == def.id),
            source: self.sources.get(def.name),
            opened: Some(file.material().slot(def.id)),
            other: other.map(|material| material.slot(def.id)),
            cue: self.findings.iter().find(|finding| finding.property == Some(def.id)).map(|finding| finding.message.as_str()),
            thumbnail,
            is_map_loaded,
        };
        let (response, action) = value_edit(ui, def, &mut document.material, &row);
        if self.sought == Some(def.id) {
            self.sought = None;
            response.scroll_to_me(Some(egui::Align::Center));
        }
        self.rows.push((def.id, response.rect.intersect(ui.clip_rect())));
        action
    }

    /// The property whose row is at a place of the window.
    pub fn row_at(&self, place: egui::Pos2) -> Option<Property> {
        self.rows.iter().find(|(_, rect)| rect.contains(place)).map(|(property, _)| *property)
    }

    /// Brings the row of a property into sight.
    pub fn go_to(&mut self, property: Property) {
        self.search.clear();
        self.sought = Some(property);
    }

    fn read_sources(&mut self, document: &Document) {
        if self.sources_of.as_ref().is_some_and(|of| of.shares_origin(document)) {
            return;
        }
        let sources = PROPERTIES.iter().filter_map(|def| Some((def.name, document.file().source_of(def.id)?)));
        self.sources = sources.collect();
        self.sources_of = Some(document.clone());
    }
}

/// Whether a search text stands in one of the three names.
fn matches(def: &PropertyDef, query: &str) -> bool {
    query.is_empty() || [def.label, def.name, def.usage].iter().any(|name| name.to_lowercase().contains(query))
}

/// Why a property has no effect now: the lobe that uses it is left out.
pub fn without_effect(property: Property, lobes: LobeSet) -> Option<&'static str> {
    LOBES.iter().find(|lobe| lobe.properties.contains(&property) && !lobes.has(lobe.lobe)).map(|lobe| lobe.doc)
}

fn group_title(ui: &Ui, group: Group, material: &Material) -> LayoutJob {
    let count = PROPERTIES.iter().filter(|def| def.group == group && *material.slot(def.id) != Slot::default()).count();
    let mut job = LayoutJob::default();
    let format = |style: TextStyle, color| TextFormat { font_id: style.resolve(ui.style()), color, ..Default::default() };
    job.append(group.title(), 0.0, format(TextStyle::Body, theme::now().strong));
    if count > 0 {
        job.append(&format!("{count} set"), 8.0, format(TextStyle::Small, theme::now().accent));
    }
    job
}

/// Name, unit and provenance of the material.
fn about(ui: &mut Ui, document: &mut Document) {
    let unknown = document.file().unknown_keys().len();
    let material = &mut document.material;
    CollapsingHeader::new(RichText::new("Material").color(theme::now().strong)).default_open(true).show_unindented(ui, |ui| {
        text_row(ui, "Name", &mut material.name, false);
        ui.horizontal(|ui| {
            label(ui, "Unit of lengths").on_hover_text(
                "How large one unit of this material's lengths is. Absorption, scattering and height distances are lengths.",
            );
            let old = material.unit_mm();
            if let Some(new) =
                (NumberField { range: 1e-6..=1e9, ..NumberField::plain("Unit of lengths", 70.0, old * 0.01) }).show(ui, old)
            {
                material.unit_mm = Some(new);
            }
            ui.label(RichText::new(format!("mm    1 unit = {} mm", number::format(old, 4))).small().weak());
        });
    });
    let title = RichText::new("Notes and sources").color(theme::now().weak);
    CollapsingHeader::new(title).id_salt("notes").default_open(false).show_unindented(ui, |ui| {
        words_row(ui, "Other names", &mut material.aliases);
        words_row(ui, "Tags", &mut material.tags);
        text_row(ui, "Notes", &mut material.notes, true);
        text_row(ui, "Source", &mut material.provenance.source, false);
        text_row(ui, "Reference", &mut material.provenance.reference, true);
        text_row(ui, "Method", &mut material.provenance.method, true);
        text_row(ui, "Licence", &mut material.provenance.licence, false);
        if unknown > 0 {
            let text = format!("{unknown} entries of the file are unknown to this version; they are kept.");
            ui.label(RichText::new(text).small().weak());
        }
    });
}

fn label(ui: &mut Ui, text: &str) -> egui::Response {
    let size = egui::vec2(GUTTER + label_width(ui), ui.spacing().interact_size.y);
    ui.allocate_ui_with_layout(size, egui::Layout::left_to_right(egui::Align::Center), |ui| {
        ui.set_width(size.x);
        ui.add_space(GUTTER - ui.spacing().item_spacing.x);
        ui.label(RichText::new(text).color(theme::now().text.gamma_multiply(0.8)))
    })
    .inner
}

fn text_row(ui: &mut Ui, name: &str, text: &mut String, is_long: bool) -> egui::Response {
    ui.horizontal_top(|ui| {
        label(ui, name);
        let edit = if is_long { TextEdit::multiline(text).desired_rows(3) } else { TextEdit::singleline(text) };
        ui.add(edit.desired_width(f32::INFINITY)).accessible_name(format!("Material {}", name.to_lowercase()))
    })
    .inner
}

/// Words as one text with commas. While it is typed it may end in a comma, so the list takes it over when it is left.
fn words_row(ui: &mut Ui, name: &str, words: &mut Vec<String>) {
    let id = ui.scope_id().with(name);
    let mut text = ui.data(|data| data.get_temp::<String>(id)).unwrap_or_else(|| words.join(", "));
    let response = text_row(ui, name, &mut text, false);
    if response.lost_focus() {
        *words = text.split(',').map(|word| word.trim().to_owned()).filter(|word| !word.is_empty()).collect();
    }
    if response.has_focus() {
        ui.data_mut(|data| data.insert_temp(id, text));
    } else {
        ui.data_mut(|data| data.remove::<String>(id));
    }
}
