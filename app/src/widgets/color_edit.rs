//! A colour: swatch with picker, and three linear numbers.
//!
//! The swatch and the picker show what a screen shows (sRGB); the numbers and the file are linear. Colours above 1 keep
//! their brightness: the picker changes their hue and saturation.

use crate::widgets::number;
use crate::widgets::number_field::NumberField;
use crate::widgets::value_edit::edit_range;
use burnish_material::PropertyDef;
use burnish_renderer::tonemap::{srgb_decode, srgb_encode};
use egui::color_picker::{Alpha, color_picker_hsva_2d};
use egui::{Color32, Popup, PopupCloseBehavior, Role, Sense, Stroke, StrokeKind, Ui, WidgetInfo, ecolor::Hsva, vec2};

/// How far the picker's numbers must move to count as an edit. It converts its colour back and forth each frame, and the
/// rounding of that (about 1e-6) must not change the document.
const PICKER_NOISE: f32 = 1e-4;

/// Edits a linear colour. Returns the new one when it changed.
pub fn color_edit(ui: &mut Ui, def: &PropertyDef, old: [f64; 3]) -> Option<[f64; 3]> {
    let mut new = swatch(ui, def, old);
    let spacing = ui.spacing().item_spacing.x.min(4.0);
    ui.spacing_mut().item_spacing.x = spacing;
    let width = ((ui.available_width() - 2.0 * spacing) / 3.0).floor();
    for (i, channel) in ["red", "green", "blue"].iter().enumerate() {
        let name = format!("{} {channel}", def.label);
        let value = new.unwrap_or(old)[i];
        if let Some(v) =
            (NumberField { range: edit_range(def), format: number::color_field, ..NumberField::plain(&name, width, 0.004) })
                .show(ui, value)
        {
            new.get_or_insert(old)[i] = v;
        }
    }
    new
}

/// The display colour of a linear one, scaled down where it is brighter than a screen.
pub fn display_color(linear: [f64; 3]) -> Color32 {
    let peak = linear.iter().copied().fold(1.0, f64::max);
    let [r, g, b] = linear.map(|x| (srgb_encode((x / peak).clamp(0.0, 1.0) as f32) * 255.0 + 0.5) as u8);
    Color32::from_rgb(r, g, b)
}

fn swatch(ui: &mut Ui, def: &PropertyDef, old: [f64; 3]) -> Option<[f64; 3]> {
    let (rect, response) = ui.allocate_exact_size(vec2(30.0, ui.spacing().interact_size.y), Sense::click());
    let color = display_color(old);
    response.widget_info(|| WidgetInfo::labeled(Role::ColorWell, ui.is_enabled(), def.label));
    if ui.is_rect_visible(rect) {
        let visuals = ui.style().interact(&response);
        ui.painter().rect(rect.shrink(1.0), 3, color, Stroke::new(1.0, visuals.bg_fill), StrokeKind::Outside);
    }
    let response = response.on_hover_text(format!("sRGB {}\nclick to pick; the numbers are linear", hex(color)));

    let id = ui.scope_id().with("picker");
    let is_open = Popup::is_id_open(ui.ctx(), id);
    let mut new = None;
    Popup::menu(&response).id(id).close_behavior(PopupCloseBehavior::CloseOnClickOutside).show(|ui| {
        ui.spacing_mut().slider_width = 220.0;
        // Kept while open, so that hue and saturation survive black, white and grey.
        let peak = old.iter().copied().fold(1.0, f64::max);
        let here = Hsva::from_rgb(old.map(|x| (x / peak).clamp(0.0, 1.0) as f32));
        let kept = ui.data(|data| data.get_temp::<(Hsva, [f64; 3])>(id)).filter(|(_, of)| is_open && *of == old);
        let before = kept.map_or(here, |(hsva, _)| hsva);
        let mut hsva = before;
        color_picker_hsva_2d(ui, &mut hsva, Alpha::Opaque);
        let moved = [(hsva.h, before.h), (hsva.s, before.s), (hsva.v, before.v)];
        if moved.iter().any(|(a, b)| (a - b).abs() > PICKER_NOISE) {
            new = Some(hsva.to_rgb().map(|x| number::rounded(f64::from(x) * peak, 4)));
        } else {
            hsva = before;
        }
        if let Some(typed) = hex_field(ui, def, color) {
            new = Some(typed);
        }
        ui.data_mut(|data| data.insert_temp(id, (hsva, new.unwrap_or(old))));
    });
    new.filter(|new| *new != old)
}

fn hex(color: Color32) -> String {
    format!("#{:02X}{:02X}{:02X}", color.r(), color.g(), color.b())
}

/// A field for `#AF363C`, which is sRGB; returns the linear colour when one was entered.
fn hex_field(ui: &mut Ui, def: &PropertyDef, color: Color32) -> Option<[f64; 3]> {
    let shown = hex(color);
    let id = ui.scope_id().with("hex");
    let mut text = ui.data(|data| data.get_temp::<String>(id)).unwrap_or_else(|| shown.clone());
    let response = ui
        .horizontal(|ui| {
            ui.label("sRGB hex");
            let edit = egui::TextEdit::singleline(&mut text).desired_width(80.0).font(egui::TextStyle::Monospace);
            ui.add(edit).accessible_name(format!("{} hex", def.label))
        })
        .inner;
    if response.has_focus() {
        ui.data_mut(|data| data.insert_temp(id, text));
        return None;
    }
    ui.data_mut(|data| data.remove::<String>(id));
    if !response.lost_focus() || text == shown {
        return None;
    }
    parse_hex(&text)
}

/// Reads `#AF363C`, `AF363C` or `#fff` as a linear colour.
pub fn parse_hex(text: &str) -> Option<[f64; 3]> {
    let digits = text.trim().trim_start_matches('#');
    if !digits.bytes().all(|b| b.is_ascii_hexdigit()) {
        return None;
    }
    let step = match digits.len() {
        3 => 1,
        6 => 2,
        _ => return None,
    };
    let mut color = [0.0; 3];
    for (i, channel) in color.iter_mut().enumerate() {
        let byte = u8::from_str_radix(&digits[i * step..(i + 1) * step], 16).ok()?;
        let byte = if step == 1 { byte * 17 } else { byte };
        *channel = number::rounded(f64::from(srgb_decode(f32::from(byte) / 255.0)), 4);
    }
    Some(color)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hex_is_srgb() {
        assert_eq!(parse_hex("#fff"), Some([1.0; 3]));
        assert_eq!(parse_hex("808080"), Some([0.2159; 3]));
        assert_eq!(parse_hex("#80808"), None);
        assert_eq!(parse_hex("#ü123"), None);
        assert_eq!(display_color([0.2159; 3]), Color32::from_gray(128));
        assert_eq!(display_color([4.0, 2.0, 0.0]), display_color([1.0, 0.5, 0.0]));
    }
}
