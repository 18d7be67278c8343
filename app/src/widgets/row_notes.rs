//! What a row of the property panel says beside its value: the tooltip, and short lines under the editor.

use crate::theme;
use crate::widgets::number;
use crate::widgets::value_edit::{GUTTER, Row, label_width};
use burnish_material::{Kind, LimitKind, Material, PropertyDef, Slot, Unit, Value, Vary};
use egui::{Color32, Label, RichText, Ui, vec2};

/// Doc, the three names, range, default, and why it may have no effect now.
pub fn tooltip(ui: &mut Ui, def: &PropertyDef, material: &Material, row: &Row) {
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
    if let Some(near) = burnish_presets::measured::sentence(material, def.id) {
        ui.add_space(3.0);
        ui.label(near);
    }
    if let Some(reason) = row.without_effect {
        ui.colored_label(theme::now().warning, format!("No effect now. {reason}"));
    }
}

/// A value in few digits.
pub fn value_text(value: Value) -> String {
    match value {
        Value::Float(v) => number::format(v, 4),
        Value::Bool(v) => if v { "on" } else { "off" }.into(),
        Value::Color(v) | Value::Normal(v) => {
            format!("({}, {}, {})", number::format(v[0], 4), number::format(v[1], 4), number::format(v[2], 4))
        }
    }
}

/// Shows lines under the editor. Their number stays while a button of the mouse is down, so that nothing moves under a drag.
pub fn notes(ui: &mut Ui, def: &PropertyDef, slot: &Slot, row: &Row) {
    let mut lines = lines(def, slot, row);
    let id = ui.scope_id().with("notes");
    let held = ui.data(|data| data.get_temp::<usize>(id)).filter(|_| ui.input(|i| i.pointer.any_down()));
    match held {
        Some(count) => lines.resize_with(count, || (Color32::TRANSPARENT, " ".to_owned())),
        None => ui.data_mut(|data| _ = data.insert_temp(id, lines.len())),
    }
    for (color, text) in lines {
        ui.horizontal(|ui| {
            ui.add_space(GUTTER + label_width(ui) + ui.spacing().item_spacing.x);
            ui.add(Label::new(RichText::new(text).small().color(color)).wrap());
        });
    }
}

/// Unit, range, unreadable text. Kept short; they take height only where they are needed.
fn lines(def: &PropertyDef, slot: &Slot, row: &Row) -> Vec<(Color32, String)> {
    let value = slot.value.unwrap_or(def.default);
    let mut lines = Vec::new();
    let mut note = |color, text: String| lines.push((color, text));
    if let (Unit::Length, Value::Float(v)) = (def.unit, value) {
        let units = if v == 1.0 { "unit" } else { "units" };
        note(theme::now().weak, format!("{} {units} = {}", number::format(v, 4), length_text(v * row.unit_mm)));
    }
    if let Some(outside) = value.numbers().iter().find(|x| !def.limits.contains(**x)) {
        let text = number::format(*outside, 4);
        match def.limits.kind {
            LimitKind::Hard => note(
                theme::now().warning,
                format!(
                    "⚠ {text} is outside the {}; drawn as {}",
                    def.limits.text(),
                    number::format(def.limits.enforce(*outside), 4)
                ),
            ),
            LimitKind::Typical => note(theme::now().weak, format!("⚠ {text} is beyond the {}", def.limits.text())),
            LimitKind::Open => {}
        }
    }
    if let Some(cue) = row.cue.filter(|_| value.numbers().iter().all(|x| def.limits.contains(*x))) {
        note(theme::now().warning, format!("⚠ {cue}"));
    }
    if let Some(unreadable) = row.unreadable
        && slot.value.is_none()
    {
        let text = if unreadable.reason.contains(&unreadable.text) { String::new() } else { format!("{}: ", unreadable.text) };
        note(theme::now().warning, format!("⚠ line {}: {text}{}", unreadable.line, unreadable.reason));
    }
    if let Some(reason) = row.without_effect
        && *slot != Slot::default()
        && def.default.kind() != Kind::Bool
    {
        note(theme::now().weak, format!("no effect now: {}", reason.split(';').next_back().unwrap_or(reason).trim()));
    }
    lines
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
