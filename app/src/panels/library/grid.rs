//! The grid of cards, and the textures of their pictures.

use super::card::Card;
use super::{Around, LibraryAction, LibraryPanel};
use crate::library::{Entry, Library, State};
use crate::theme;
use egui::{ColorImage, RichText, ScrollArea, Sense, TextureOptions, Ui, vec2};
use std::collections::BTreeSet;
use std::path::PathBuf;
use std::sync::Arc;

/// Textures kept; the others are made again when they come into sight.
const MAX_TEXTURES: usize = 400;
/// Points between cards.
const GAP: f32 = 4.0;

impl LibraryPanel {
    pub(super) fn grid(&mut self, ui: &mut Ui, library: &mut Library, around: &Around) -> Option<LibraryAction> {
        let mut action = None;
        if self.found.is_empty() {
            let text = if library.entries().is_empty() { "There is no material in this folder." } else { "Nothing matches." };
            ui.label(RichText::new(if library.progress().is_some() { "Reading…" } else { text }).weak());
        }
        let scale = theme::text_scale(ui);
        let card = vec2(self.side, self.side + 16.0 * scale);
        let across = ((ui.available_width() - 10.0 + GAP) / (card.x + GAP)).floor().max(1.0) as usize;
        let rows = self.found.len().div_ceil(across);
        let mut sight = Vec::new();
        ui.spacing_mut().item_spacing = vec2(GAP, GAP);
        let mut area = ScrollArea::vertical().auto_shrink([false, false]);
        if let Some(path) = self.sought.take_if(|_| library.progress().is_none()) {
            let place = |panel: &Self| panel.found.iter().position(|number| library.entries()[*number].path == path);
            match place(self) {
                Some(place) => area = area.vertical_scroll_offset((place / across) as f32 * (card.y + GAP)),
                None if !self.search.is_empty() => {
                    self.search.clear();
                    self.sought = Some(path);
                }
                None => {}
            }
        }
        area.show_rows(ui, card.y, rows, |ui, shown| {
            for row in shown {
                ui.horizontal(|ui| {
                    for place in row * across..((row + 1) * across).min(self.found.len()) {
                        let number = self.found[place];
                        let Some(entry) = library.entries().get(number).cloned() else { continue };
                        sight.push(number);
                        let (rect, response) = ui.allocate_exact_size(card, Sense::click_and_drag());
                        let state = library.state(&entry);
                        self.load_texture(ui, library, &entry, state);
                        let is_current = around.current.is_some_and(|path| path == library.root().join(&entry.path));
                        let is_favourite = library.marks().is_favourite(&entry.path);
                        self.paint(ui, rect, &response, &Card { entry: &entry, state, is_current, is_favourite });
                        action = self.touched(ui, &response, &entry, place, library).or(action.take());
                    }
                });
            }
        });
        library.show(&sight, self.makes_pictures);
        if self.textures.len() > MAX_TEXTURES {
            let kept: BTreeSet<&PathBuf> =
                sight.iter().filter_map(|n| library.entries().get(*n)).map(|entry| &entry.path).collect();
            self.textures.retain(|path, _| kept.contains(path));
        }
        action
    }

    fn load_texture(&mut self, ui: &Ui, library: &Library, entry: &Arc<Entry>, state: State) {
        if self.textures.get(&entry.path).is_some_and(|(_, known)| *known == state) {
            return;
        }
        if let Some(small) = library.picture(entry) {
            let image = ColorImage::from_rgba_unmultiplied([small.width as usize, small.height as usize], &small.rgba);
            let texture = ui.ctx().load_texture("library picture", image, TextureOptions::LINEAR);
            self.textures.insert(entry.path.clone(), (texture, state));
        }
    }
}
