//! Three versions of a material become one: what both changed differently is decided entry by entry.

use super::diff::{entry_label, plain};
use super::source_picker::{self, Choices, Picked};
use crate::merging::Merging;
use crate::sources::Source;
use crate::theme;
use crate::widgets::color_edit::display_color;
use burnish_material::Property;
use burnish_material::merge::{Conflict, Side};
use egui::{Align, Button, Label, Layout, Rect, RichText, ScrollArea, StrokeKind, Ui, vec2};
use std::collections::BTreeMap;

/// One of the three versions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Version {
    /// What both were made from.
    Base,
    /// The one whose text is kept.
    Mine,
    /// The other one.
    Theirs,
}

impl Version {
    /// All versions with their names.
    pub const ALL: [(Self, &'static str); 3] = [(Self::Base, "Base"), (Self::Mine, "Mine"), (Self::Theirs, "Theirs")];
}

/// What the panel asks of the application.
#[derive(Clone, Debug, PartialEq)]
pub enum MergeAction {
    /// Use another version.
    Choose(Version, Option<Source>),
    /// Ask for a file.
    ChooseFile(Version),
    /// Open the result as a new document.
    Open,
    /// Write the result over the file of the first version.
    Save,
}

/// What is shown.
pub struct MergeView<'a> {
    /// Base, mine and theirs.
    pub sources: [Option<&'a Source>; 3],
    /// What could be.
    pub choices: &'a Choices,
    /// What is to be decided; a sentence where that is not known.
    pub merging: Result<&'a Merging, &'a str>,
    /// The file that the result can be written over.
    pub target: Option<&'a std::path::Path>,
}

/// Shows the panel and changes what is decided.
pub fn show(ui: &mut Ui, view: &MergeView, decided: &mut BTreeMap<String, Side>) -> Option<MergeAction> {
    let mut action = None;
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        let width = (ui.available_width() / 3.0 - 46.0).clamp(84.0, 200.0);
        for ((version, name), source) in Version::ALL.into_iter().zip(view.sources) {
            ui.label(RichText::new(name).small().color(theme::now().weak));
            let none = (version == Version::Base).then_some("none: two-way");
            match source_picker::show(ui, &format!("Merge {}", name.to_lowercase()), width, source, view.choices, none) {
                Some(Picked::Source(source)) => action = Some(MergeAction::Choose(version, source)),
                Some(Picked::ChooseFile) => action = Some(MergeAction::ChooseFile(version)),
                None => {}
            }
        }
    });
    let merging = match view.merging {
        Ok(merging) => merging,
        Err(sentence) => {
            ui.add(Label::new(RichText::new(sentence).color(theme::now().weak)).wrap());
            return action;
        }
    };
    let open = merging.open(decided);
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        let can = open == 0;
        let wait = "Decide all conflicts first";
        if ui.add_enabled(can, Button::new("Open result").small()).on_disabled_hover_text(wait).clicked() {
            action = Some(MergeAction::Open);
        }
        let save = ui.add_enabled(can && view.target.is_some(), Button::new("Write over mine").small());
        let why = if can { "Mine is no file, or has changes that are not saved" } else { wait };
        let tip = view.target.map(|path| format!("{}: undo takes it back", path.display())).unwrap_or_default();
        if save.on_hover_text(tip).on_disabled_hover_text(why).clicked() {
            action = Some(MergeAction::Save);
        }
        for (text, side) in [("All mine", Side::A), ("All theirs", Side::B)] {
            if ui.add_enabled(!merging.conflicts.is_empty(), Button::new(text).small()).clicked() {
                decided.extend(merging.conflicts.iter().map(|conflict| (conflict.key.clone(), side)));
            }
        }
        let color = if open > 0 { theme::now().warning } else { theme::now().weak };
        ui.label(RichText::new(summary(merging, open)).small().color(color));
    });
    rows(ui, merging, decided);
    action
}

/// How many conflicts there are, and what is not one.
fn summary(merging: &Merging, open: usize) -> String {
    let many = |n: usize, word: &str| format!("{n} {word}{}", if n == 1 { "" } else { "s" });
    let conflicts = match (merging.conflicts.len(), open) {
        (0, _) => "no conflict".to_owned(),
        (all, 0) => format!("{} decided", many(all, "conflict")),
        (all, open) => format!("{}, {open} to decide", many(all, "conflict")),
    };
    format!(
        "{conflicts}; {} taken from theirs; {} left out",
        many(merging.taken.len(), "entry").replace("entrys", "entries"),
        merging.left_out.len()
    )
}

/// A line of the list.
enum Line<'a> {
    Conflict(&'a Conflict),
    Note(String),
}

fn rows(ui: &mut Ui, merging: &Merging, decided: &mut BTreeMap<String, Side>) {
    let property = |key: &str| Property::from_name(key);
    let taken = merging.taken.iter().map(|key| Line::Note(format!("{}: from theirs", entry_label(key, property(key)))));
    let left = merging.left_out.iter().map(|change| Line::Note(format!("{}: the text of mine is kept", change.key)));
    let lines: Vec<Line> = merging.conflicts.iter().map(Line::Conflict).chain(taken).chain(left).collect();
    let height = ui.spacing().interact_size.y;
    if !merging.conflicts.is_empty() {
        let cell = (ui.available_width() - 4.0 * ui.spacing().item_spacing.x - ui.spacing().scroll.bar_width) / 4.0;
        ui.horizontal(|ui| {
            for title in ["Conflict", "Base", "Mine", "Theirs"] {
                text_cell(ui, cell, ui.text_style_height(&egui::TextStyle::Small), title, theme::now().weak, "");
            }
        });
    }
    ScrollArea::vertical().id_salt("conflicts").auto_shrink([false, false]).show_rows(ui, height, lines.len(), |ui, shown| {
        let gap = ui.spacing().item_spacing.x;
        let cell = (ui.available_width() - 4.0 * gap) / 4.0;
        for line in &lines[shown] {
            ui.horizontal(|ui| match line {
                Line::Note(text) => _ = ui.add(Label::new(RichText::new(text).small().color(theme::now().weak)).truncate()),
                Line::Conflict(conflict) => {
                    let label = entry_label(&conflict.key, conflict.property);
                    let is_open = !decided.contains_key(&conflict.key);
                    let mark = if is_open { "? " } else { "" };
                    let color = if is_open { theme::now().warning } else { theme::now().text };
                    text_cell(ui, cell, height, &format!("{mark}{label}"), color, &conflict.key);
                    let base = conflict.base.as_deref().map_or_else(|| "—".to_owned(), plain);
                    text_cell(ui, cell, height, &base, theme::now().weak, "What stood there before");
                    for (side, name, value) in [(Side::A, "mine", &conflict.a), (Side::B, "theirs", &conflict.b)] {
                        let is_chosen = decided.get(&conflict.key) == Some(&side);
                        let text = value.as_deref().map_or_else(|| "nothing".to_owned(), plain);
                        if choice(ui, [cell, height], &text, is_chosen, &format!("{label}: {name}, {text}")) {
                            decided.insert(conflict.key.clone(), side);
                        }
                    }
                }
            });
        }
    });
}

fn text_cell(ui: &mut Ui, width: f32, height: f32, text: &str, color: egui::Color32, tip: &str) {
    ui.allocate_ui_with_layout(vec2(width, height), Layout::left_to_right(Align::Center), |ui| {
        ui.set_min_width(width);
        let label = ui.add(Label::new(RichText::new(text).color(color)).truncate());
        if !tip.is_empty() {
            label.on_hover_text(tip);
        }
    });
}

/// A value as a button that is marked where it is chosen; colours with a swatch.
fn choice(ui: &mut Ui, size: [f32; 2], text: &str, is_chosen: bool, name: &str) -> bool {
    let mark = if is_chosen { "● " } else { "○ " };
    let swatch = color_in(text);
    let room = if swatch.is_some() { "     " } else { "" };
    let button = Button::selectable(is_chosen, format!("{room}{mark}{text}")).truncate().right_text("");
    let response = ui.add_sized(size, button);
    if let Some(color) = swatch {
        let rect = Rect::from_min_size(response.rect.left_center() + vec2(4.0, -6.0), vec2(12.0, 12.0));
        ui.painter().rect(rect, 2, display_color(color), (1.0, theme::now().line), StrokeKind::Inside);
    }
    response.widget_info(|| egui::WidgetInfo::selected(egui::Role::RadioButton, true, is_chosen, name));
    response.on_hover_text(text).clicked()
}

/// The colour that a text of a file means.
fn color_in(text: &str) -> Option<[f64; 3]> {
    let (r, g, b): (f64, f64, f64) = ron::from_str(text).ok()?;
    [r, g, b].iter().all(|x| x.is_finite()).then_some([r, g, b])
}
