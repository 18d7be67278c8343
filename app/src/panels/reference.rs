//! A photo beside the view, to look at and to pick colours from.

use crate::theme;
use burnish_assets::Image;
use burnish_renderer::tonemap::{srgb_decode, srgb_encode};
use egui::{Color32, ColorImage, Rect, RichText, Role, Sense, TextureHandle, TextureOptions, Ui, WidgetInfo, pos2, vec2};
use std::path::Path;
use std::sync::Arc;

/// Largest side of the texture; larger photos are shown smaller, and picked from in full.
const MAX_SIDE: usize = 1024;

/// The photo and its texture.
#[derive(Default)]
pub struct ReferencePanel {
    image: Option<Arc<Image>>,
    name: String,
    texture: Option<TextureHandle>,
}

impl ReferencePanel {
    /// Shows another photo.
    pub fn set(&mut self, path: &Path, image: &Arc<Image>) {
        self.name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        (self.image, self.texture) = (Some(image.clone()), None);
    }

    /// Shows the photo; the linear colour that was clicked, and what it was read from.
    pub fn show(&mut self, ui: &mut Ui, is_picking: bool) -> Option<([f64; 3], String)> {
        let Some(image) = self.image.clone() else {
            ui.label(RichText::new("Drop an image on the picture, or load one from the File menu.").color(theme::now().weak));
            return None;
        };
        let texture =
            self.texture.get_or_insert_with(|| ui.ctx().load_texture("reference", shown(&image), TextureOptions::LINEAR));
        let room = ui.available_size() - vec2(6.0, 22.0);
        let size = texture.size_vec2();
        let size = size * (room.x / size.x).min(room.y / size.y).max(0.01);
        let (rect, response) = ui.allocate_exact_size(size, Sense::click());
        response.widget_info(|| WidgetInfo::labeled(Role::Image, true, format!("Reference {}", self.name)));
        ui.painter().image(texture.id(), rect, Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0)), Color32::WHITE);
        ui.label(RichText::new(&self.name).small().color(theme::now().weak));
        if !is_picking {
            return None;
        }
        let response = response.on_hover_cursor(egui::CursorIcon::Crosshair);
        let at = (response.hover_pos().or(response.interact_pointer_pos())? - rect.min) / rect.size();
        let color = pixel(&image, at.x, at.y);
        let [r, g, b] = color.map(|x| (srgb_encode(x.clamp(0.0, 1.0) as f32) * 255.0 + 0.5) as u8);
        response.show_tooltip_text(format!("sRGB #{r:02X}{g:02X}{b:02X}"));
        response.clicked().then(|| (color, format!("{}, its sRGB made linear", self.name)))
    }
}

/// The photo as the screen shows it, every so manieth texel of a large one.
fn shown(image: &Image) -> ColorImage {
    let step = image.width.max(image.height).div_ceil(MAX_SIDE).max(1);
    let [width, height] = [image.width, image.height].map(|n| n.div_ceil(step));
    let places = (0..height).flat_map(|y| (0..width).map(move |x| (x * step, y * step)));
    let colors = places.map(|(x, y)| {
        let [r, g, b] = texel(image, x, y);
        let encode = |x: f32| if image.is_eight_bit { x } else { srgb_encode(x.clamp(0.0, 1.0)) };
        let [r, g, b] = [r, g, b].map(|x| (encode(x).clamp(0.0, 1.0) * 255.0 + 0.5) as u8);
        Color32::from_rgb(r, g, b)
    });
    ColorImage::new([width, height], colors.collect())
}

/// As stored; black outside.
fn texel(image: &Image, x: usize, y: usize) -> [f32; 3] {
    image.texels.get(y * image.width + x).map_or([0.0; 3], |[r, g, b, _]| [*r, *g, *b])
}

/// The linear colour of a place, 0 to 1 from the upper left.
fn pixel(image: &Image, u: f32, v: f32) -> [f64; 3] {
    let place = |t: f32, count: usize| ((t.max(0.0) * count as f32) as usize).min(count.saturating_sub(1));
    let stored = texel(image, place(u, image.width), place(v, image.height));
    stored.map(|x| f64::from(if image.is_eight_bit { srgb_decode(x) } else { x }).max(0.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_are_picked_linear() {
        let texels = vec![[0.0, 0.0, 0.0, 1.0], [1.0, 0.5, 0.0, 1.0]];
        let image = Image { width: 2, height: 1, texels, is_eight_bit: true };
        let [r, g, b] = pixel(&image, 0.9, 0.5);
        assert!(r == 1.0 && (g - 0.214).abs() < 1e-3 && b == 0.0, "{r} {g} {b}");
        assert_eq!(pixel(&image, -3.0, 9.0), [0.0; 3]);
        assert_eq!(shown(&image).pixels[1], Color32::from_rgb(255, 128, 0));
        let linear = Image { is_eight_bit: false, ..image };
        assert_eq!(pixel(&linear, 0.9, 0.5)[1], 0.5);
        assert_eq!(shown(&linear).pixels[1], Color32::from_rgb(255, 188, 0));
    }
}
