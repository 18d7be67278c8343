//! Clicks into a picture that take a colour from it or ask what a pixel is made of.

use super::App;
use crate::live_final::LiveFinal;
use crate::panels::explain;
use crate::panels::viewport::Layout;
use crate::widgets::value_edit::edit_range;
use burnish_material::Value;
use egui::{Pos2, Response, Ui};

impl App {
    /// Takes the click where one is awaited.
    pub(super) fn pick_or_explain(&mut self, ui: &mut Ui, response: &Response, layout: Layout) {
        if let Some(explanation) = self.debug.explanation() {
            explain::show(ui, layout.all, explanation);
        }
        if self.picking.is_none() && !self.debug.is_explaining() {
            return;
        }
        ui.set_cursor_icon(egui::CursorIcon::Crosshair);
        let Some(place) = response.interact_pointer_pos().filter(|_| response.clicked()) else { return };
        let Some((is_final, x, y)) = self.pixel_at(place, layout) else { return };
        if self.picking.is_some() {
            match self.radiance_at(is_final, x, y) {
                Ok((color, what)) => self.picked(color, &what),
                Err(problem) => self.messages.error(format!("No colour was taken: {problem}.")),
            }
            return;
        }
        let (width, height) = self.picture_size;
        if let Some(scene) = self.editor.scene(width as f32 / height as f32) {
            self.debug.explain(ui.ctx(), self.revision, (x, y), (width, height), scene);
        }
    }

    /// Which picture is at a place, and which of its pixels.
    fn pixel_at(&self, place: Pos2, layout: Layout) -> Option<(bool, usize, usize)> {
        let is_wiped = layout.preview == layout.final_view;
        let left_of_line = layout.all.left() + self.editor.view.wipe * layout.all.width();
        let is_left = if is_wiped { place.x < left_of_line } else { layout.preview.is_some_and(|rect| rect.contains(place)) };
        let rect = if is_left { layout.preview } else { layout.final_view }.or(layout.preview)?;
        let (u, v) = ((place.x - rect.left()) / rect.width(), (place.y - rect.top()) / rect.height());
        let (width, height) = self.picture_size;
        let index = |t: f32, count: usize| ((t.clamp(0.0, 1.0) * count as f32) as usize).min(count - 1);
        Some((!is_left && self.has_final(), index(u, width), index(v, height)))
    }

    /// The linear colour of a pixel, and what it was read from.
    fn radiance_at(&mut self, is_final: bool, x: usize, y: usize) -> Result<([f64; 3], String), String> {
        let (width, height) = self.picture_size;
        let pick = |w: usize, h: usize, pixels: &[[f32; 4]]| {
            let index = (y * h / height).min(h.saturating_sub(1)) * w + (x * w / width).min(w.saturating_sub(1));
            pixels.get(index).map(|[r, g, b, _]| [*r, *g, *b].map(f64::from)).ok_or_else(|| "there is no picture yet".to_owned())
        };
        if is_final {
            let view = self.final_view.as_ref().and_then(LiveFinal::newest).ok_or("the final view has no picture yet")?;
            let color = pick(view.width, view.height, &view.pixels)?;
            return Ok((color, "the final view, before the display transform".into()));
        }
        let (w, h, pixels) = self.preview.read_linear()?;
        Ok((pick(w as usize, h as usize, &pixels)?, "the preview, before the display transform".into()))
    }

    /// Gives the colour that was picked to the property that waits for it, as one step.
    pub(super) fn picked(&mut self, color: [f64; 3], what: &str) {
        let Some(property) = self.picking.take() else { return };
        let range = edit_range(property.def());
        let color = color.map(|x| crate::widgets::number::rounded(x, 4).max(*range.start()).min(*range.end()));
        self.history.settle();
        self.editor.document.material.set(property, Value::Color(color));
        self.history.commit(format!("{} picked", property.def().label), &self.editor.document);
        self.messages.info(format!("{} taken from {what}.", property.def().label));
    }
}
