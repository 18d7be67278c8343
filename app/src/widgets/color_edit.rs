//! A colour: swatch with picker, and three linear numbers.
//!
//! The swatch and the picker show what a screen shows (sRGB); the numbers and the file are linear. Colours above 1 keep
//! their brightness: the picker changes their hue and saturation.

use crate::theme;
use crate::widgets::number;
use crate::widgets::number_field::{NumberField, Scale};
use crate::widgets::value_edit::{RowAction, edit_range};
use burnish_material::{LimitKind, PropertyDef};
use burnish_renderer::tonemap::{srgb_decode, srgb_encode};
use egui::color_picker::{Alpha, color_picker_hsva_2d};
use egui::{Color32, Grid, Popup, PopupCloseBehavior, Role, Sense, Stroke, StrokeKind, Ui, WidgetInfo, ecolor::Hsva, vec2};

/// How far the picker's numbers must move to count as an edit. It converts its colour back and forth each frame, and the
/// rounding of that (about 1e-6) must not change the document.
const PICKER_NOISE: f32 = 1e-4;

/// Below this width three decimals do not fit, points.
const NARROW: f32 = 46.0;

/// Edits a linear colour. Returns the new one when it changed.
pub fn color_edit(ui: &mut Ui, def: &PropertyDef, old: [f64; 3], action: &mut Option<RowAction>) -> Option<[f64; 3]> {
    let mut new = swatch(ui, def, old, action);
    let spacing = ui.spacing().item_spacing.x.min(4.0);
    ui.spacing_mut().item_spacing.x = spacing;
    let width = ((ui.available_width() - 2.0 * spacing) / 3.0).floor();
    let edited = channels(ui, def, "", width, new.unwrap_or(old));
    new = edited.or(new);
    new
}

/// Three fields of linear numbers.
fn channels(ui: &mut Ui, def: &PropertyDef, note: &str, width: f32, old: [f64; 3]) -> Option<[f64; 3]> {
    let mut new = None;
    for (i, channel) in ["red", "green", "blue"].iter().enumerate() {
        let name = format!("{} {channel}{note}", def.label);
        let field = NumberField {
            range: edit_range(def),
            format: if width < NARROW * theme::text_scale(ui) { number::narrow_color_field } else { number::color_field },
            step: 0.05,
            ..NumberField::plain(&name, width, 0.004)
        };
        if let Some(v) = field.show(ui, old[i]) {
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

fn swatch(ui: &mut Ui, def: &PropertyDef, old: [f64; 3], action: &mut Option<RowAction>) -> Option<[f64; 3]> {
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
        ui.spacing_mut().slider_width = 240.0;
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
        new = entries(ui, def, old, color).or(new);
        ui.data_mut(|data| data.insert_temp(id, (hsva, new.unwrap_or(old))));
        ui.add_space(2.0);
        if ui.button("Pick from a picture").on_hover_text("Click into a view or a reference image to take its colour").clicked() {
            *action = Some(RowAction::PickColor(def.id));
            ui.close();
        }
    });
    new.filter(|new| *new != old)
}

/// The same colour in the ways people have it: on screen in hexadecimal or of 255, linear, and how bright where it may exceed 1.
fn entries(ui: &mut Ui, def: &PropertyDef, old: [f64; 3], color: Color32) -> Option<[f64; 3]> {
    let mut new = None;
    Grid::new("entries").num_columns(4).spacing(vec2(6.0, 4.0)).show(ui, |ui| {
        ui.label("sRGB hex");
        new = hex_field(ui, def, color);
        ui.end_row();
        ui.label("sRGB 0–255");
        let peak = old.iter().copied().fold(1.0, f64::max);
        for (i, channel) in ["red", "green", "blue"].iter().enumerate() {
            let name = format!("{} {channel} of 255", def.label);
            let shown = f64::from(srgb_encode((old[i] / peak).clamp(0.0, 1.0) as f32)) * 255.0;
            let field = NumberField {
                range: 0.0..=255.0,
                step: 1.0,
                format: |x| format!("{x:.0}"),
                ..NumberField::plain(&name, 52.0, 0.5)
            };
            if let Some(v) = field.show(ui, number::rounded(shown, 5)) {
                let linear = f64::from(srgb_decode((v / 255.0) as f32)) * peak;
                new.get_or_insert(old)[i] = number::rounded(linear, 4);
            }
        }
        ui.end_row();
        ui.label("linear");
        new = channels(ui, def, ", linear", 52.0, old).or(new);
        ui.end_row();
        if def.limits.kind != LimitKind::Hard || def.limits.max.is_none() {
            ui.label("brightness");
            let brightest = old.iter().copied().fold(0.0, f64::max);
            let name = format!("{} brightness", def.label);
            let field = NumberField {
                scale: Scale::Logarithmic,
                range: 0.0..=f64::MAX,
                step: 0.1,
                ..NumberField::plain(&name, 52.0, 0.01)
            };
            if let Some(v) = field.show(ui, brightest) {
                new = Some(old.map(|x| if brightest > 0.0 { number::rounded(x / brightest * v, 6) } else { v }));
            }
            ui.end_row();
        }
    });
    new
}

fn hex(color: Color32) -> String {
    format!("#{:02X}{:02X}{:02X}", color.r(), color.g(), color.b())
}

/// A field for `#AF363C`, which is sRGB; returns the linear colour when one was entered.
fn hex_field(ui: &mut Ui, def: &PropertyDef, color: Color32) -> Option<[f64; 3]> {
    let shown = hex(color);
    let id = ui.scope_id().with("hex");
    let mut text = ui.data(|data| data.get_temp::<String>(id)).unwrap_or_else(|| shown.clone());
    let edit = egui::TextEdit::singleline(&mut text).desired_width(64.0).font(egui::TextStyle::Monospace);
    let response = ui.add(edit).accessible_name(format!("{} hex", def.label));
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

/// Reads a colour as people copy it: hexadecimal sRGB, or three linear numbers.
pub fn parse_color(text: &str) -> Option<[f64; 3]> {
    parse_triple(text).or_else(|| parse_hex(text))
}

/// Reads `(0.1, 0.2, 0.3)`, `0.1 0.2 0.3` or the same with semicolons.
pub fn parse_triple(text: &str) -> Option<[f64; 3]> {
    let text = text.trim().trim_start_matches(['(', '[']).trim_end_matches([')', ']']);
    let is_listed = text.contains([',', ';']);
    let parts = text.split(|c: char| if is_listed { c == ',' || c == ';' } else { c.is_whitespace() });
    let numbers: Vec<f64> = parts.filter_map(|part| part.trim().parse().ok()).filter(|x: &f64| x.is_finite()).collect();
    let parts = if is_listed { text.split([',', ';']).count() } else { text.split_whitespace().count() };
    (parts == 3).then_some(numbers)?.try_into().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hex_is_srgb() {
        assert_eq!(parse_hex("#fff"), Some([1.0; 3]));
        assert_eq!(parse_hex("808080"), Some([0.2159; 3]));
        assert_eq!(parse_triple("(0.1, 2e-1, 0.3)"), Some([0.1, 0.2, 0.3]));
        assert_eq!(parse_triple("0.1 0.2 0.3"), Some([0.1, 0.2, 0.3]));
        assert_eq!(parse_triple("0.1, 0.2"), None);
        assert_eq!(parse_triple("0.1, x, 0.2, 0.3"), None);
        assert_eq!(parse_color("#fff"), Some([1.0; 3]));
        assert_eq!(parse_hex("#80808"), None);
        assert_eq!(parse_hex("#ü123"), None);
        assert_eq!(display_color([0.2159; 3]), Color32::from_gray(128));
        assert_eq!(display_color([4.0, 2.0, 0.0]), display_color([1.0, 0.5, 0.0]));
    }
}
