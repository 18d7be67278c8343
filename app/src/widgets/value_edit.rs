//! One row of the property panel: marks, label, the editor for its kind of value, map, reset.
//!
//! Showing a row never changes the slot. Only a drag, a click or a committed text does, and a text that was not edited
//! puts back the exact number even where fewer digits are shown.

use crate::theme;
use crate::widgets::number_field::{NumberField, Scale, take_copy_paste};
use crate::widgets::row_notes::{notes, tooltip, value_text};
use crate::widgets::track::{Marks, Track};
use crate::widgets::{color_edit, gesture, number, texture_slot};
use burnish_material::{Kind, LimitKind, Material, Property, PropertyDef, Slot, Unit, Unreadable, Value, ValueSource, Vary};
use burnish_presets::measured;
use egui::{Align2, FontId, Id, Key, Label, Layout, Rect, Response, RichText, Sense, Ui, ViewportCommand, pos2, vec2};

/// Width of the marks before the label.
pub const GUTTER: f32 = 12.0;
/// Width of the label column at the usual size of text.
const LABEL_WIDTH: f32 = 144.0;
/// Width of the number field beside a track at the usual size of text.
const NUMBER_WIDTH: f32 = 64.0;
/// Width of the map and reset buttons together.
const TRAILING_WIDTH: f32 = 48.0;

/// Width of the label column.
pub fn label_width(ui: &Ui) -> f32 {
    (LABEL_WIDTH * theme::text_scale(ui)).round()
}

/// What a row needs to know beside the material.
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
    /// What the file or the preset had when it was opened.
    pub opened: Option<&'a Slot>,
    /// What the other side of the comparison has.
    pub other: Option<&'a Slot>,
    /// Why the value is unlikely to be meant.
    pub cue: Option<&'a str>,
    /// The image of the slot's map, small, if it is loaded.
    pub thumbnail: Option<egui::TextureId>,
    /// Whether the image of the slot's map is loaded.
    pub is_map_loaded: bool,
}

/// What a row asks of the application.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RowAction {
    /// Choose an image for this property.
    ChooseMap(Property),
    /// Choose a built-in texture for this property.
    ChooseBuiltIn(Property),
    /// Take the colour of this property from a picture.
    PickColor(Property),
    /// Show everything that is known about this property.
    ShowReference(Property),
}

/// Shows the row of one property and edits its slot in place. The whole row's response catches dropped images.
pub fn value_edit(ui: &mut Ui, def: &'static PropertyDef, material: &mut Material, row: &Row) -> (Response, Option<RowAction>) {
    let mut action = None;
    let inner = ui.push_id(def.name, |ui| {
        ui.vertical(|ui| {
            if row.without_effect.is_some() {
                ui.multiply_opacity(0.6);
            }
            ui.horizontal(|ui| {
                marks(ui, material.slot(def.id), row);
                label_column(ui, def, material, row, &mut action);
                let width = (ui.available_width() - TRAILING_WIDTH - ui.spacing().item_spacing.x).max(60.0);
                ui.allocate_ui_with_layout(
                    vec2(width, ui.spacing().interact_size.y),
                    Layout::left_to_right(egui::Align::Center),
                    |ui| {
                        ui.set_width(width);
                        editor(ui, def, material, row, &mut action);
                    },
                );
                trailing(ui, def, material.slot_mut(def.id), &mut action);
            });
            let slot = material.slot_mut(def.id);
            notes(ui, def, slot, row);
            if slot.texture.is_some() || def.vary == Vary::TextureOnly {
                texture_slot::texture_slot(ui, def, &mut slot.texture, row, &mut action);
            }
        });
    });
    let response = inner.response;
    keys(ui, def, material.slot_mut(def.id), &response, row.unit_mm);
    (response, action)
}

/// Keys for the row under the pointer: Backspace resets, Ctrl+C and Ctrl+V (a colour whole with Alt as well) copy and paste.
fn keys(ui: &Ui, def: &PropertyDef, slot: &mut Slot, response: &Response, unit_mm: f64) {
    let awaited = ui.data(|data| data.get_temp::<Property>(paste_target())) == Some(def.id);
    let is_under_pointer = response.contains_pointer() && !ui.ctx().text_edit_focused();
    if !(awaited || is_under_pointer) {
        return;
    }
    // Never while a text is being typed.
    if is_under_pointer && ui.input_mut(|i| i.consume_key(egui::Modifiers::NONE, Key::Backspace)) {
        *slot = Slot::default();
        gesture::end(ui.ctx());
    }
    let is_answered = awaited && ui.input(|i| i.events.iter().any(|event| matches!(event, egui::Event::Paste(_))));
    if is_answered {
        ui.data_mut(|data| data.remove::<Property>(paste_target()));
    }
    if let Some(value) = take_copy_paste(ui, || exact_text(slot.value.unwrap_or(def.default)), |text| pasted(def, text, unit_mm))
    {
        slot.value = Some(value);
        gesture::end(ui.ctx());
    }
}

/// Which row waits for what the clipboard holds.
fn paste_target() -> Id {
    Id::unique("the row to paste into")
}

/// A value with all its digits, as [`pasted`] reads it.
pub fn exact_text(value: Value) -> String {
    match value {
        Value::Float(v) => v.to_string(),
        Value::Bool(v) => if v { "on" } else { "off" }.to_owned(),
        Value::Color([x, y, z]) | Value::Normal([x, y, z]) => format!("({x}, {y}, {z})"),
    }
}

/// The value that a copied text means for a property, brought into what edits may set; `None` if it means none.
///
/// `unit_mm` is millimetres per unit of length.
pub fn pasted(def: &PropertyDef, text: &str, unit_mm: f64) -> Option<Value> {
    let range = edit_range(def);
    let limited = |x: f64| x.max(*range.start()).min(*range.end());
    match def.default.kind() {
        Kind::Float => number::parse(text, def.unit, unit_mm).map(|x| Value::Float(limited(x))),
        Kind::Bool => match text.trim().to_lowercase().as_str() {
            "on" | "true" | "1" | "yes" => Some(Value::Bool(true)),
            "off" | "false" | "0" | "no" => Some(Value::Bool(false)),
            _ => None,
        },
        Kind::Color => color_edit::parse_color(text).map(|color| Value::Color(color.map(limited))),
        Kind::Normal => color_edit::parse_triple(text).map(Value::Normal),
    }
}

/// Signs before the label: a dot where the value is not the default, a diamond where it is not what was opened, a letter where the other side
/// has another. Shapes, so that nothing hangs on colour.
fn marks(ui: &mut Ui, slot: &Slot, row: &Row) {
    let (rect, response) =
        ui.allocate_exact_size(vec2(GUTTER - ui.spacing().item_spacing.x, ui.spacing().interact_size.y), Sense::hover());
    let palette = theme::now();
    let is_set = *slot != Slot::default();
    let is_edited = row.opened.is_some_and(|opened| opened != slot);
    let differs = row.other.is_some_and(|other| other != slot);
    let x = rect.left() + 4.0;
    let mut said = Vec::new();
    if is_edited {
        let c = pos2(x, rect.center().y);
        let corners = [c - vec2(4.0, 0.0), c - vec2(0.0, 4.0), c + vec2(4.0, 0.0), c + vec2(0.0, 4.0)];
        ui.painter().add(egui::Shape::convex_polygon(corners.to_vec(), palette.accent, egui::Stroke::NONE));
        said.push("differs from what was opened");
    } else if is_set {
        ui.painter().circle_filled(pos2(x, rect.center().y), 2.5, palette.accent);
        said.push("differs from the default");
    }
    if differs {
        ui.painter().text(pos2(x, rect.top() - 1.0), Align2::CENTER_TOP, "B", FontId::proportional(9.0), palette.good);
        said.push("differs from the other side");
    }
    if !said.is_empty() {
        response.on_hover_text(said.join(", "));
    }
}

fn label_column(ui: &mut Ui, def: &PropertyDef, material: &mut Material, row: &Row, action: &mut Option<RowAction>) {
    let slot = material.slot_mut(def.id);
    let is_set = *slot != Slot::default();
    let color = if is_set { ui.visuals().strong_text_color() } else { theme::now().text.gamma_multiply(0.86) };
    let size = vec2(label_width(ui), ui.spacing().interact_size.y);
    let response = ui
        .allocate_ui_with_layout(size, Layout::left_to_right(egui::Align::Center), |ui| {
            ui.set_width(size.x);
            // The longest names are set smaller rather than cut off.
            let font = egui::TextStyle::Body.resolve(ui.style());
            let width = ui.painter().layout_no_wrap(def.label.into(), font.clone(), color).size().x;
            let text = RichText::new(def.label).color(color).size(font.size * ((size.x - 2.0) / width).min(1.0));
            ui.add(Label::new(text).truncate().selectable(false).sense(Sense::click()))
        })
        .inner;
    response.context_menu(|ui| {
        if ui.add_enabled(is_set, egui::Button::new("Reset to default").shortcut_text("Backspace")).clicked() {
            *slot = Slot::default();
        }
        if let Some(opened) = row.opened
            && ui.add_enabled(opened != slot, egui::Button::new("Back to what was opened")).clicked()
        {
            *slot = opened.clone();
        }
        if let Some(other) = row.other
            && ui.add_enabled(other != slot, egui::Button::new("Take from the other side")).clicked()
        {
            *slot = other.clone();
        }
        ui.separator();
        if ui.add(egui::Button::new("Copy value").shortcut_text("Ctrl+C")).clicked() {
            ui.ctx().copy_text(exact_text(slot.value.unwrap_or(def.default)));
        }
        if ui.add(egui::Button::new("Paste value").shortcut_text("Ctrl+V")).clicked() {
            ui.data_mut(|data| data.insert_temp(paste_target(), def.id));
            ui.ctx().send_viewport_cmd(ViewportCommand::RequestPaste);
        }
        if ui.button("Copy formal name").clicked() {
            ui.ctx().copy_text(def.name.into());
        }
        if def.default.kind() == Kind::Color && ui.button("Pick from a picture").clicked() {
            *action = Some(RowAction::PickColor(def.id));
        }
        if def.vary != Vary::Uniform {
            ui.separator();
            texture_slot::sources(ui, def, action);
        }
        ui.separator();
        if ui.add(egui::Button::new("Reference").shortcut_text("F1")).clicked() {
            *action = Some(RowAction::ShowReference(def.id));
        }
    });
    if response.double_clicked() {
        *slot = Slot::default();
    }
    response.on_hover_ui(|ui| tooltip(ui, def, material, row));
}

fn editor(ui: &mut Ui, def: &PropertyDef, material: &mut Material, row: &Row, action: &mut Option<RowAction>) {
    let old = material.value(def.id);
    let new = match old {
        Value::Float(v) => float_edit(ui, def, v, material, row),
        Value::Bool(v) => {
            let mut is_on = v;
            let response = ui.checkbox(&mut is_on, if v { "On" } else { "Off" }).accessible_name(def.label);
            response.changed().then_some(Some(Value::Bool(is_on)))
        }
        Value::Color(v) => color_edit::color_edit(ui, def, v, action).map(|color| Some(Value::Color(color))),
        Value::Normal(v) => vector_edit(ui, def, v).map(|v| Some(Value::Normal(v))),
    };
    match new {
        Some(Some(value)) => material.slot_mut(def.id).value = Some(value),
        Some(None) => material.slot_mut(def.id).value = None,
        None => {}
    }
}

/// A track over the stated range and a field that goes beyond it where the range is only typical. `Some(None)` asks for the default.
fn float_edit(ui: &mut Ui, def: &PropertyDef, old: f64, material: &Material, row: &Row) -> Option<Option<Value>> {
    let limits = def.limits;
    let (min, max) = (limits.min.unwrap_or(0.0), limits.slider_max);
    let is_logarithmic = matches!(def.unit, Unit::Length | Unit::Radiance);
    let step = step(def);
    let number_of = |slot: Option<&Slot>| match slot.map(|slot| slot.value.unwrap_or(def.default)) {
        Some(Value::Float(v)) => Some(v),
        _ => None,
    };
    let spread = match row.source.map(|source| (source.spread_min, source.spread_max)) {
        Some((Some(Value::Float(low)), Some(Value::Float(high)))) => Some((low, high)),
        _ => None,
    };
    let marks = Marks {
        zone: measured::zone(material, def.id),
        measured: &measured::marks(material, def.id).collect::<Vec<_>>(),
        spread,
        default: number_of(Some(&Slot::default())).unwrap_or(min),
        other: number_of(row.other).filter(|other| *other != old),
    };
    let number_width = (NUMBER_WIDTH * theme::text_scale(ui)).round();
    let width = (ui.available_width() - number_width - ui.spacing().item_spacing.x).max(30.0);
    let (track, moved) = Track { name: def.label, min, max, is_logarithmic, step, marks }.show(ui, width, old);
    let range = edit_range(def);
    let moved = moved.map(|v| v.max(*range.start()).min(*range.end())).filter(|v| *v != old);
    if track.double_clicked() {
        return Some(None);
    }
    let near = || measured::sentence(material, def.id);
    if track.dragged() {
        let text = number::field(moved.unwrap_or(old)) + def.unit.suffix();
        track.show_tooltip_text(near().map_or(text.clone(), |near| format!("{text}\n{near}")));
    } else {
        track.on_hover_ui(|ui| {
            if let Some(near) = near() {
                ui.label(near);
            }
            ui.label(RichText::new("Shift: finer   Ctrl: in steps   two clicks: reset").small().weak());
        });
    }
    let scale = if is_logarithmic { Scale::Logarithmic } else { Scale::Linear((max - min) / 300.0) };
    let field = NumberField {
        scale,
        step,
        range,
        unit: def.unit,
        unit_mm: row.unit_mm,
        ..NumberField::plain(def.label, number_width, 1.0)
    };
    field.show(ui, moved.unwrap_or(old)).or(moved).map(|v| Some(Value::Float(v)))
}

/// What Ctrl snaps to: a twentieth of the track, rounded to 1, 2 or 5 of its decade.
fn step(def: &PropertyDef) -> f64 {
    let rough = (def.limits.slider_max - def.limits.min.unwrap_or(0.0)) / 20.0;
    let decade = 10_f64.powf(rough.log10().floor());
    let leading = [1.0, 2.0, 5.0, 10.0].into_iter().find(|x| rough <= x * decade * 1.000_001).unwrap_or(10.0);
    number::rounded(leading * decade, 6)
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
        paint_checker(ui, button.rect, if button.hovered() { ui.visuals().strong_text_color() } else { theme::now().weak });
        let button =
            button.accessible_name(format!("{} map", def.label)).on_hover_text("Choose a map, or drop an image on this row");
        egui::Popup::menu(&button).show(|ui| texture_slot::sources(ui, def, action));
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
fn paint_checker(ui: &Ui, rect: Rect, color: egui::Color32) {
    let side = 3.5;
    let corner = rect.center() - vec2(1.5 * side, 1.5 * side);
    for i in 0..9_u8 {
        if i % 2 == 0 {
            let place = corner + side * vec2(f32::from(i % 3), f32::from(i / 3));
            ui.painter().rect_filled(Rect::from_min_size(place, vec2(side, side)), 0, color);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_copied_is_pasted() {
        for def in burnish_material::PROPERTIES {
            assert_eq!(pasted(def, &exact_text(def.default), 100.0), Some(def.default), "{}", def.name);
            assert_eq!(pasted(def, "what?", 100.0), None, "{}", def.name);
        }
        let color = Property::base_color.def();
        assert_eq!(pasted(color, "#fff", 100.0), Some(Value::Color([1.0; 3])));
        assert_eq!(pasted(color, "2 0.5 -1", 100.0), Some(Value::Color([1.0, 0.5, 0.0])), "brought into the range");
    }

    #[test]
    fn steps_are_round() {
        assert_eq!(step(Property::roughness.def()), 0.05);
        assert_eq!(step(Property::dispersion.def()), 1.0);
        assert_eq!(step(Property::specular_ior.def()), 0.1);
    }
}
