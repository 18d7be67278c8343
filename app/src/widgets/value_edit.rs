//! One row of the property panel: label, the editor for its kind of value, map, reset.
//!
//! Showing a row never changes the slot. Only a drag, a click or a committed text does, and a text that was not edited
//! puts back the exact number even where fewer digits are shown.

use crate::theme;
use crate::widgets::number_field::NumberField;
use crate::widgets::{color_edit, number, texture_slot};
use burnish_material::{Kind, LimitKind, Property, PropertyDef, Slot, Unit, Unreadable, Value, ValueSource, Vary};
use egui::{Key, Label, Layout, Response, RichText, Sense, Slider, SliderClamping, Ui, vec2};

/// Width of the label column.
pub const LABEL_WIDTH: f32 = 150.0;
/// Letters above which a label would not fit the column at full size.
const LONG_LABEL: usize = 22;
/// Width of the number field beside a slider.
const NUMBER_WIDTH: f32 = 70.0;
/// Width of the map and reset buttons together.
const TRAILING_WIDTH: f32 = 50.0;

/// What a row needs to know beside the slot.
#[derive(Clone, Copy, Debug, Default)]
pub struct Row<'a> {
    /// Millimetres per unit of the material.
    pub unit_mm: f64,
    /// Why the property has no effect now.
    pub without_effect: Option<&'static str>,
    /// What stands in the file but could not be read.
    pub unreadable: Option<&'a Unreadable>,
    /// Where the value comes from.
    pub source: Option<&'a ValueSource>,
    /// Whether the image of the slot's map is loaded.
    pub is_map_loaded: bool,
}

/// What a row asks of the application.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RowAction {
    /// Choose an image for this property.
    ChooseMap(Property),
}

/// Shows the row of one property and edits its slot in place. The whole row's response catches dropped images.
pub fn value_edit(ui: &mut Ui, def: &'static PropertyDef, slot: &mut Slot, row: &Row) -> (Response, Option<RowAction>) {
    let mut action = None;
    let inner = ui.push_id(def.name, |ui| {
        ui.vertical(|ui| {
            if row.without_effect.is_some() {
                ui.multiply_opacity(0.5);
            }
            ui.horizontal(|ui| {
                label_column(ui, def, slot, row);
                let width = (ui.available_width() - TRAILING_WIDTH - ui.spacing().item_spacing.x).max(60.0);
                ui.allocate_ui_with_layout(
                    vec2(width, ui.spacing().interact_size.y),
                    Layout::left_to_right(egui::Align::Center),
                    |ui| {
                        ui.set_width(width);
                        editor(ui, def, slot, row);
                    },
                );
                trailing(ui, def, slot, &mut action);
            });
            notes(ui, def, slot, row);
            if slot.texture.is_some() || def.vary == Vary::TextureOnly {
                texture_slot::texture_slot(ui, def, &mut slot.texture, row.is_map_loaded, &mut action);
            }
        });
    });
    let response = inner.response;
    // Backspace under the pointer resets, as in other editors; never while a text is being typed.
    if response.contains_pointer() && !ui.ctx().text_edit_focused() && ui.input(|i| i.key_pressed(Key::Backspace)) {
        *slot = Slot::default();
    }
    (response, action)
}

fn label_column(ui: &mut Ui, def: &PropertyDef, slot: &mut Slot, row: &Row) {
    let is_set = *slot != Slot::default();
    let color = if is_set { ui.visuals().strong_text_color() } else { theme::TEXT.gamma_multiply(0.8) };
    let size = vec2(LABEL_WIDTH, ui.spacing().interact_size.y);
    let response = ui
        .allocate_ui_with_layout(size, Layout::left_to_right(egui::Align::Center), |ui| {
            ui.set_width(LABEL_WIDTH);
            // The longest names are set a little smaller rather than cut off.
            let text = RichText::new(def.label).color(color);
            let text = if def.label.len() > LONG_LABEL { text.size(12.0) } else { text };
            ui.add(Label::new(text).truncate().selectable(false).sense(Sense::click()))
        })
        .inner;
    response.context_menu(|ui| {
        if ui.add_enabled(is_set, egui::Button::new("Reset to default")).clicked() {
            *slot = Slot::default();
        }
        if ui.button("Copy formal name").clicked() {
            ui.ctx().copy_text(def.name.into());
        }
    });
    if response.double_clicked() {
        *slot = Slot::default();
    }
    response.on_hover_ui(|ui| tooltip(ui, def, row));
}

/// Doc, the three names, range, default, and why it may have no effect now.
fn tooltip(ui: &mut Ui, def: &PropertyDef, row: &Row) {
    ui.label(RichText::new(def.label).strong());
    ui.label(def.doc);
    ui.add_space(3.0);
    egui::Grid::new("names").num_columns(2).spacing(vec2(10.0, 2.0)).show(ui, |ui| {
        let mut line = |name: &str, text: &str| {
            ui.label(RichText::new(name).small().weak());
            ui.label(RichText::new(text).small().monospace());
            ui.end_row();
        };
        line("formal name", def.name);
        line("usage", def.usage);
        let range = def.limits.text();
        if !range.is_empty() {
            line(
                if def.limits.kind == LimitKind::Hard { "range" } else { "typical" },
                range.trim_start_matches("typical ").trim_start_matches("range "),
            );
        }
        line("default", &value_text(def.default));
        line(
            "varies",
            match def.vary {
                Vary::Uniform => "no, one value for the whole material",
                Vary::Texturable => "a value or a map",
                Vary::TextureOnly => "a map; a value is a constant map",
            },
        );
        if let Some(source) = row.source {
            for (name, text) in
                [("method", &source.method), ("dataset", &source.dataset), ("paper", &source.paper), ("licence", &source.licence)]
            {
                if !text.is_empty() {
                    line(name, text);
                }
            }
            if let (Some(low), Some(high)) = (source.spread_min, source.spread_max) {
                line("spread", &format!("{} … {}", value_text(low), value_text(high)));
            }
        }
    });
    if let Some(reason) = row.without_effect {
        ui.colored_label(theme::WARNING, format!("No effect now. {reason}"));
    }
}

fn value_text(value: Value) -> String {
    match value {
        Value::Float(v) => number::format(v, 4),
        Value::Bool(v) => if v { "on" } else { "off" }.into(),
        Value::Color(v) | Value::Normal(v) => {
            format!("({}, {}, {})", number::format(v[0], 4), number::format(v[1], 4), number::format(v[2], 4))
        }
    }
}

fn editor(ui: &mut Ui, def: &PropertyDef, slot: &mut Slot, row: &Row) {
    let old = slot.value.unwrap_or(def.default);
    let new = match old {
        Value::Float(v) => float_edit(ui, def, v, row.unit_mm).map(Value::Float),
        Value::Bool(v) => {
            let mut is_on = v;
            let response = ui.checkbox(&mut is_on, if v { "On" } else { "Off" }).accessible_name(def.label);
            response.changed().then_some(Value::Bool(is_on))
        }
        Value::Color(v) => color_edit::color_edit(ui, def, v).map(Value::Color),
        Value::Normal(v) => vector_edit(ui, def, v).map(Value::Normal),
    };
    if let Some(new) = new {
        slot.value = Some(new);
    }
}

/// A slider over the stated range and a field that goes beyond it where the range is only typical.
fn float_edit(ui: &mut Ui, def: &PropertyDef, old: f64, unit_mm: f64) -> Option<f64> {
    let limits = def.limits;
    let (min, max) = (limits.min.unwrap_or(0.0), limits.slider_max);
    let is_logarithmic = matches!(def.unit, Unit::Length | Unit::Radiance);
    let mut new = None;

    ui.spacing_mut().slider_width = (ui.available_width() - NUMBER_WIDTH - ui.spacing().item_spacing.x).max(30.0);
    let slider = Slider::from_get_set(min..=max, |set| {
        if let Some(v) = set
            && v != old
        {
            new = Some(number::rounded(v, 4));
        }
        new.unwrap_or(old)
    })
    .show_value(false)
    .logarithmic(is_logarithmic)
    .smallest_positive(1e-3)
    .clamping(if limits.kind == LimitKind::Hard { SliderClamping::Edits } else { SliderClamping::Never });
    let slider = ui.add(slider).accessible_name(def.label);
    if slider.dragged() {
        slider.show_tooltip_text(number::field(new.unwrap_or(old)) + def.unit.suffix());
    }

    let speed = if is_logarithmic { (old.abs() * 0.01).max(1e-3) } else { (max - min) / 300.0 };
    let field =
        NumberField { range: edit_range(def), unit: def.unit, unit_mm, ..NumberField::plain(def.label, NUMBER_WIDTH, speed) };
    field.show(ui, new.unwrap_or(old)).or(new)
}

/// What edits may set: the hard range, or anything finite.
pub fn edit_range(def: &PropertyDef) -> std::ops::RangeInclusive<f64> {
    match def.limits.kind {
        LimitKind::Hard => def.limits.min.unwrap_or(f64::MIN)..=def.limits.max.unwrap_or(f64::MAX),
        LimitKind::Typical | LimitKind::Open => f64::MIN..=f64::MAX,
    }
}

/// Three numbers of a direction.
fn vector_edit(ui: &mut Ui, def: &PropertyDef, old: [f64; 3]) -> Option<[f64; 3]> {
    let width = ((ui.available_width() - 2.0 * ui.spacing().item_spacing.x) / 3.0).floor();
    let mut new = None;
    for (i, axis) in ["x", "y", "z"].iter().enumerate() {
        let name = format!("{} {axis}", def.label);
        if let Some(v) = NumberField::plain(&name, width, 0.005).show(ui, old[i]) {
            new.get_or_insert(old)[i] = v;
        }
    }
    new
}

fn trailing(ui: &mut Ui, def: &PropertyDef, slot: &mut Slot, action: &mut Option<RowAction>) {
    let size = vec2(20.0, ui.spacing().interact_size.y);
    ui.spacing_mut().button_padding = vec2(2.0, 1.0);
    if def.vary == Vary::Texturable && slot.texture.is_none() {
        let button = ui.add(egui::Button::new("").frame_when_inactive(false).min_size(size));
        paint_checker(ui, button.rect, if button.hovered() { ui.visuals().strong_text_color() } else { theme::WEAK });
        if button
            .accessible_name(format!("{} map", def.label))
            .on_hover_text("Choose a map, or drop an image on this row")
            .clicked()
        {
            *action = Some(RowAction::ChooseMap(def.id));
        }
    } else {
        ui.add_space(size.x + ui.spacing().item_spacing.x);
    }
    if *slot == Slot::default() {
        return;
    }
    let button = ui.add(egui::Button::new("⟲").frame_when_inactive(false).min_size(size));
    let text = format!("Reset to {}", value_text(def.default));
    if button.accessible_name(format!("Reset {}", def.label)).on_hover_text(text).clicked() {
        *slot = Slot::default();
    }
}

/// A small checkerboard, the sign of a map.
fn paint_checker(ui: &Ui, rect: egui::Rect, color: egui::Color32) {
    let side = 3.5;
    let corner = rect.center() - vec2(1.5 * side, 1.5 * side);
    for i in 0..9_u8 {
        if i % 2 == 0 {
            let place = corner + side * vec2(f32::from(i % 3), f32::from(i / 3));
            ui.painter().rect_filled(egui::Rect::from_min_size(place, vec2(side, side)), 0, color);
        }
    }
}

/// Lines under the editor: unit, range, unreadable text. Kept short; they take height only where they are needed.
fn notes(ui: &mut Ui, def: &PropertyDef, slot: &Slot, row: &Row) {
    let value = slot.value.unwrap_or(def.default);
    let mut note = |color, text: String| {
        ui.horizontal(|ui| {
            ui.add_space(LABEL_WIDTH + ui.spacing().item_spacing.x);
            ui.add(Label::new(RichText::new(text).small().color(color)).wrap());
        });
    };
    if let (Unit::Length, Value::Float(v)) = (def.unit, value) {
        let units = if v == 1.0 { "unit" } else { "units" };
        note(theme::WEAK, format!("{} {units} = {}", number::format(v, 4), length_text(v * row.unit_mm)));
    }
    if let Some(outside) = value.numbers().iter().find(|x| !def.limits.contains(**x)) {
        let text = number::format(*outside, 4);
        match def.limits.kind {
            LimitKind::Hard => note(
                theme::WARNING,
                format!(
                    "⚠ {text} is outside the {}; drawn as {}",
                    def.limits.text(),
                    number::format(def.limits.enforce(*outside), 4)
                ),
            ),
            LimitKind::Typical => note(theme::WEAK, format!("⚠ {text} is beyond the {}", def.limits.text())),
            LimitKind::Open => {}
        }
    }
    if let Some(unreadable) = row.unreadable
        && slot.value.is_none()
    {
        let text = if unreadable.reason.contains(&unreadable.text) { String::new() } else { format!("{}: ", unreadable.text) };
        note(theme::WARNING, format!("⚠ line {}: {text}{}", unreadable.line, unreadable.reason));
    }
    if let Some(reason) = row.without_effect
        && *slot != Slot::default()
        && def.default.kind() != Kind::Bool
    {
        note(theme::WEAK, format!("no effect now: {}", reason.split(';').next_back().unwrap_or(reason).trim()));
    }
}

/// A length in the unit that reads best.
pub fn length_text(mm: f64) -> String {
    let (value, unit) = match mm.abs() {
        x if x >= 10_000.0 => (mm / 1000.0, "m"),
        x if x > 0.0 && x < 0.01 => (mm * 1000.0, "µm"),
        _ => (mm, "mm"),
    };
    format!("{} {unit}", number::format(value, 4))
}
