//! What a pixel is made of, in a box over the picture.

use crate::theme;
use crate::widgets::color_edit::display_color;
use crate::widgets::number;
use burnish_renderer::path::Explanation;
use egui::{Area, Color32, Frame, Grid, Id, Margin, Order, Rect, RichText, Sense, Ui, vec2};

/// Rows below this share of the radiance are left out.
const LEAST_SHARE: f64 = 0.001;

/// Shows the box in the upper right corner of the picture.
pub fn show(ui: &Ui, place: Rect, explanation: &Explanation) {
    let palette = theme::ON_PICTURE;
    let area = Area::new(Id::unique("explanation")).order(Order::Middle).pivot(egui::Align2::RIGHT_TOP);
    area.fixed_pos(place.right_top() + vec2(-10.0, 10.0)).show(ui.ctx(), |ui| {
        let frame = Frame::new().fill(Color32::from_black_alpha(225)).corner_radius(4).inner_margin(Margin::symmetric(10, 7));
        frame.show(ui, |ui| {
            ui.visuals_mut().override_text_color = Some(palette.text);
            let luminance = |c: &[f64; 3]| 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2];
            let all = luminance(&explanation.radiance).max(1e-12);
            match &explanation.surface {
                Some(surface) => {
                    ui.label(RichText::new(format!("{}, seen at {:.0}°", surface.material, surface.view_angle)).strong());
                    let inputs = &surface.inputs;
                    let text = format!(
                        "roughness {}, metallic {}, uv {:.2} {:.2}",
                        number::format(inputs.roughness, 3),
                        number::format(inputs.metallic, 3),
                        surface.uv[0],
                        surface.uv[1]
                    );
                    ui.label(RichText::new(text).small().color(palette.weak));
                }
                None => drop(ui.label(RichText::new("The environment").strong())),
            }
            Grid::new("parts").num_columns(3).spacing(vec2(10.0, 3.0)).show(ui, |ui| {
                let mut row = |name: &str, color: &[f64; 3]| {
                    let share = luminance(color) / all;
                    if share < LEAST_SHARE {
                        return;
                    }
                    ui.label(name.replace('_', " "));
                    let (rect, _) = ui.allocate_exact_size(vec2(96.0, 12.0), Sense::hover());
                    ui.painter().rect_filled(rect, 2, Color32::from_gray(45));
                    let bar = Rect::from_min_size(rect.min, vec2(rect.width() * share.clamp(0.0, 1.0) as f32, rect.height()));
                    ui.painter().rect_filled(bar, 2, display_color(color.map(|x| x / luminance(color).max(1e-12) * 0.5)));
                    ui.label(format!("{:.1} %", 100.0 * share));
                    ui.end_row();
                };
                for lobe in &explanation.lobes {
                    row(lobe.name, &lobe.radiance);
                }
                row("emission", &explanation.emission);
                row("behind it", &explanation.through);
            });
            let [r, g, b] = explanation.radiance.map(|x| number::format(x, 3));
            let text = format!("radiance {r} {g} {b}, {} samples", explanation.samples);
            ui.label(RichText::new(text).small().color(palette.weak));
        });
    });
}
