//! The map of a property: its path, choosing and clearing it, and how it is read.

use crate::theme;
use crate::widgets::number_field::NumberField;
use crate::widgets::value_edit::{GUTTER, Row, RowAction, label_width};
use burnish_assets::BuiltInTexture;
use burnish_material::{Channel, ColorSpace, Kind, PropertyDef, TextureRef, Wrap};
use egui::{Label, Popup, PopupCloseBehavior, RichText, Ui, vec2};

/// Shows the map line under a property and edits the reference in place.
pub fn texture_slot(ui: &mut Ui, def: &PropertyDef, texture: &mut Option<TextureRef>, row: &Row, action: &mut Option<RowAction>) {
    ui.horizontal(|ui| {
        ui.add_space(GUTTER + label_width(ui) + ui.spacing().item_spacing.x);
        ui.spacing_mut().button_padding = vec2(5.0, 1.0);
        let Some(reference) = texture else {
            let choose = ui.button("Choose map…").accessible_name(format!("{} map", def.label));
            Popup::menu(&choose).show(|ui| sources(ui, def, action));
            ui.label(RichText::new("or drop an image").small().weak());
            return;
        };
        let mut is_cleared = false;
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            if ui.button("×").accessible_name(format!("Remove {} map", def.label)).on_hover_text("Remove the map").clicked() {
                is_cleared = true;
            }
            let settings = ui.button("⚙").accessible_name(format!("{} map settings", def.label));
            let settings = settings.on_hover_text("Channel, colour space, scale, wrap and placement");
            Popup::menu(&settings)
                .close_behavior(PopupCloseBehavior::CloseOnClickOutside)
                .show(|ui| settings_grid(ui, def, reference));
            let other = ui.button("…").accessible_name(format!("{} map", def.label)).on_hover_text("Choose another image");
            Popup::menu(&other).show(|ui| sources(ui, def, action));
            ui.with_layout(egui::Layout::left_to_right(egui::Align::Center), |ui| {
                let is_loaded = row.is_map_loaded;
                if let Some(thumbnail) = row.thumbnail {
                    let image = egui::Image::new((thumbnail, vec2(28.0, 28.0))).alt_text(format!("{} map, small", def.label));
                    ui.add(image).on_hover_ui(|ui| drop(ui.image((thumbnail, vec2(192.0, 192.0)))));
                }
                let (color, hint) = if is_loaded { (theme::now().accent, "") } else { (theme::now().warning, "⚠ ") };
                let label =
                    ui.add(Label::new(RichText::new(hint.to_owned() + &name(&reference.path)).small().color(color)).truncate());
                let note = if is_loaded { "" } else { "\nThis image is not loaded; the value is used instead." };
                label.on_hover_text(format!("{}{note}", reference.path));
            });
        });
        if is_cleared {
            *texture = None;
        }
    });
}

/// Where a map comes from.
pub fn sources(ui: &mut Ui, def: &PropertyDef, action: &mut Option<RowAction>) {
    if ui.button("Choose an image…").clicked() {
        *action = Some(RowAction::ChooseMap(def.id));
    }
    if ui.button("Choose a built-in texture…").clicked() {
        *action = Some(RowAction::ChooseBuiltIn(def.id));
    }
}

/// The file of a map, or the built-in texture with its map.
fn name(path: &str) -> String {
    match BuiltInTexture::parse(path) {
        Some(Ok(texture)) => format!("{} · {}", texture.def.name, texture.map.word().replace('_', " ")),
        _ => path.rsplit('/').next().unwrap_or(path).to_owned(),
    }
}

fn settings_grid(ui: &mut Ui, def: &PropertyDef, reference: &mut TextureRef) {
    ui.label(RichText::new(format!("{} map", def.label)).strong());
    egui::Grid::new("map settings").num_columns(2).spacing(vec2(12.0, 5.0)).show(ui, |ui| {
        let name = |what: &str| format!("{} map {what}", def.label);
        if def.default.kind() == Kind::Float {
            ui.label("Channel");
            choice(ui, &name("channel"), &mut reference.channel, Channel::ALL);
            ui.end_row();
        }
        ui.label("Colour space");
        choice(ui, &name("colour space"), &mut reference.color_space, ColorSpace::ALL);
        ui.end_row();
        ui.label("Invert");
        ui.checkbox(&mut reference.is_inverted, "").accessible_name(name("inverted"));
        ui.end_row();
        if def.default.kind() != Kind::Normal {
            for (label, numbers) in [("Scale", &mut reference.scale), ("Bias", &mut reference.bias)] {
                ui.label(label);
                channels(ui, &name(&label.to_lowercase()), def.default.kind(), numbers);
                ui.end_row();
            }
        }
        ui.label("Wrap");
        choice(ui, &name("wrap"), &mut reference.wrap, Wrap::ALL);
        ui.end_row();
        ui.label("Repeat");
        pair(ui, &name("repeat"), &mut reference.uv_scale, 0.02);
        ui.end_row();
        ui.label("Offset");
        pair(ui, &name("offset"), &mut reference.uv_offset, 0.005);
        ui.end_row();
        ui.label("Rotation");
        let rotation = reference.uv_rotation;
        if let Some(v) = NumberField::plain(&name("rotation, degrees"), 62.0, 0.5).show(ui, rotation) {
            reference.uv_rotation = v;
        }
        ui.end_row();
    });
}

fn choice<T: Copy + PartialEq>(ui: &mut Ui, name: &str, value: &mut T, all: &[(T, &'static str)]) {
    let word = all.iter().find(|(choice, _)| choice == value).map_or("", |(_, word)| word);
    let combo = egui::ComboBox::from_id_salt(name).selected_text(word).show_ui(ui, |ui| {
        for (choice, word) in all {
            ui.selectable_value(value, *choice, *word);
        }
    });
    combo.response.accessible_name(name);
}

/// A number for each channel of a colour, or one for a scalar.
fn channels(ui: &mut Ui, name: &str, kind: Kind, value: &mut [f64; 3]) {
    if kind != Kind::Color {
        if let Some(v) = NumberField::plain(name, 62.0, 0.01).show(ui, value[0]) {
            *value = [v; 3];
        }
        return;
    }
    ui.horizontal(|ui| {
        for (x, channel) in value.iter_mut().zip(["red", "green", "blue"]) {
            if let Some(v) = NumberField::plain(&format!("{name} {channel}"), 62.0, 0.01).show(ui, *x) {
                *x = v;
            }
        }
    });
}

fn pair(ui: &mut Ui, name: &str, value: &mut [f64; 2], speed: f64) {
    ui.horizontal(|ui| {
        for (x, axis) in value.iter_mut().zip(["u", "v"]) {
            if let Some(v) = NumberField::plain(&format!("{name} {axis}"), 62.0, speed).show(ui, *x) {
                *x = v;
            }
        }
    });
}
