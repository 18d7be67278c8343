//! Texts in pictures that are no window: laid out with the window's fonts, drawn by the processor.

use crate::theme;
use egui::epaint::text::{Fonts, LayoutJob, TextOptions, TextWrapping};
use egui::{Color32, FontId, Galley, Pos2};
use image::{Rgb, RgbImage};
use std::sync::Arc;

/// Fonts and the letters that were needed so far.
pub struct Lettering {
    fonts: Fonts,
}

impl Default for Lettering {
    fn default() -> Self {
        Self { fonts: Fonts::new(TextOptions::default(), theme::fonts()) }
    }
}

impl Lettering {
    /// A text in rows of at most `width` pixels, broken between words where that is possible. More than `max_rows` rows end in an ellipsis.
    /// Letters are `size` pixels high; runs of white space and line ends count as one space.
    pub fn lay_out(&mut self, text: &str, size: f32, width: f32, max_rows: usize) -> Galley {
        let text: Vec<&str> = text.split(|c: char| c.is_whitespace() || c.is_control()).filter(|word| !word.is_empty()).collect();
        let mut job = LayoutJob::simple(text.join(" "), FontId::proportional(size), Color32::WHITE, width);
        job.wrap = TextWrapping { max_width: width, max_rows, ..TextWrapping::default() };
        self.fonts.layout_uncached(1.0, Arc::new(job))
    }

    /// Whether the fonts have all letters of a text. Those they lack are drawn as boxes.
    pub fn has_all(&mut self, text: &str) -> bool {
        text.chars().filter(|c| !c.is_whitespace() && !c.is_control()).all(|c| self.fonts.has_glyph(&FontId::default(), c))
    }

    /// Draws a text with its upper left corner at `x`, `y` pixels. What lies outside the picture is left out.
    pub fn draw(&self, galley: &Galley, picture: &mut RgbImage, [x, y]: [u32; 2], color: [u8; 3]) {
        let atlas = self.fonts.texture_atlas().image();
        for row in &galley.rows {
            let letters = row.visuals.mesh.vertices.get(row.visuals.glyph_vertex_range.clone()).unwrap_or_default();
            // Each letter is a rectangle of four corners whose texels are pixels.
            for corners in letters.as_chunks::<4>().0 {
                let least =
                    |of: fn(&egui::epaint::Vertex) -> Pos2| corners.iter().map(of).fold(Pos2::new(f32::MAX, f32::MAX), Pos2::min);
                let most = |of: fn(&egui::epaint::Vertex) -> Pos2| corners.iter().map(of).fold(Pos2::ZERO, Pos2::max);
                let (from, to, at) =
                    (least(|corner| corner.uv), most(|corner| corner.uv), least(|corner| corner.pos) + row.pos.to_vec2());
                let (left, top) = (i64::from(x) + at.x.round() as i64, i64::from(y) + at.y.round() as i64);
                for v in from.y as usize..to.y as usize {
                    for u in from.x as usize..to.x as usize {
                        let place = [left + (u - from.x as usize) as i64, top + (v - from.y as usize) as i64];
                        let [Ok(px), Ok(py)] = place.map(u32::try_from) else { continue };
                        let cover = atlas.pixels.get(v * atlas.width() + u).map_or(0, Color32::a);
                        if let Some(Rgb(pixel)) = picture.get_pixel_mut_checked(px, py) {
                            mix(pixel, color, cover);
                        }
                    }
                }
            }
        }
    }
}

fn mix(pixel: &mut [u8; 3], color: [u8; 3], cover: u8) {
    for (old, new) in pixel.iter_mut().zip(color) {
        let sum = u32::from(*old) * (255 - u32::from(cover)) + u32::from(new) * u32::from(cover);
        *old = ((sum + 127) / 255) as u8;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drawn(text: &str, at: [u32; 2]) -> RgbImage {
        let mut lettering = Lettering::default();
        let galley = lettering.lay_out(text, 16.0, 90.0, 3);
        let mut picture = RgbImage::new(100, 70);
        lettering.draw(&galley, &mut picture, at, [255; 3]);
        picture
    }

    fn ink(picture: &RgbImage) -> usize {
        picture.pixels().filter(|pixel| pixel[0] > 127).count()
    }

    #[test]
    fn letters_become_pixels_within_their_width() {
        let (one, many) = (drawn("I", [0, 0]), drawn("Copper\n\tpolished, an alloy", [0, 0]));
        assert!(ink(&one) > 8 && ink(&many) > 10 * ink(&one), "{} {}", ink(&one), ink(&many));
        assert!(many.enumerate_pixels().all(|(x, _, pixel)| x < 91 || pixel[0] == 0));
        // Moved, it is the same.
        let moved = drawn("I", [30, 20]);
        assert!(one.enumerate_pixels().all(|(x, y, pixel)| x >= 20 || y >= 40 || moved.get_pixel(x + 30, y + 20) == pixel));
        assert_eq!(ink(&one), ink(&moved));
        assert_eq!(ink(&drawn("", [0, 0])), 0);
    }

    #[test]
    fn long_texts_keep_all_rows_or_end_in_an_ellipsis() {
        let mut lettering = Lettering::default();
        let whole = lettering.lay_out("Copper, polished and then left in the rain", 13.0, 120.0, 9);
        assert!(!whole.elided && whole.rows.len() > 1 && whole.rect.width() <= 120.0, "{:?}", whole.rect);
        let cut = lettering.lay_out("Copper, polished and then left in the rain", 13.0, 120.0, 1);
        assert!(cut.elided && cut.rows.len() == 1 && cut.rect.width() <= 121.0);
        // A word that is wider than the room is broken.
        let word = lettering.lay_out(&"x".repeat(60), 13.0, 100.0, 9);
        assert!(word.rows.len() > 2 && word.rect.width() <= 101.0, "{:?}", word.rect);
    }

    #[test]
    fn any_text_can_be_drawn() {
        let mut lettering = Lettering::default();
        assert!(lettering.has_all("Müller, Ω Эмаль 2 µm") && !lettering.has_all("漆"));
        for text in ["漆器 うるし", "ذهب", "🟥👩‍👩‍👧‍👦", "a\u{0}\u{301}\u{202e}b", "\u{10ffff}"] {
            drawn(text, [90, 65]);
            drawn(text, [u32::MAX, 0]);
        }
    }
}
