//! One material of the grid: its picture with marks, its name, and what clicks, drags and its menu mean.

use super::{Dragged, LibraryAction, LibraryPanel};
use crate::library::{Entry, Library, State};
use crate::theme;
use egui::{Align2, Color32, CornerRadius, Rect, Response, RichText, Role, Ui, WidgetInfo, pos2, vec2};
use std::collections::BTreeSet;
use std::path::PathBuf;
use std::sync::Arc;

/// What there is to say of a draft.
const DRAFT: &str = "draft: the full picture is still to come";

/// What a card shows.
pub(super) struct Card<'a> {
    pub entry: &'a Entry,
    pub state: State,
    /// Whether it is the document in front.
    pub is_current: bool,
    pub is_favourite: bool,
}

impl LibraryPanel {
    pub(super) fn paint(&self, ui: &Ui, rect: Rect, response: &Response, card: &Card) {
        let Card { entry, state, is_current, is_favourite } = *card;
        let font = egui::TextStyle::Small.resolve(ui.style());
        let is_selected = self.selected.contains(&entry.path);
        let palette = theme::now();
        let visuals = ui.style().interact_selectable(response, is_selected);
        let painter = ui.painter_at(rect.expand(2.0));
        if is_selected || response.hovered() || response.has_focus() {
            painter.rect_filled(rect, 3, visuals.weak_bg_fill);
        }
        let room = Rect::from_min_size(rect.min, vec2(rect.width(), rect.width())).shrink(2.0);
        match self.textures.get(&entry.path) {
            Some((texture, _)) => {
                egui::Image::new((texture.id(), room.size())).corner_radius(CornerRadius::same(3)).paint_at(ui, room);
            }
            None => {
                painter.rect_filled(room, 3, palette.surround);
            }
        }
        if is_selected {
            painter.rect_stroke(room, 3, (2.0, palette.accent), egui::StrokeKind::Inside);
        }
        let mark = match (&entry.problem, state) {
            (Some(_), _) => Some(("⚠ broken", palette.error)),
            (None, State::Draft) => Some(("draft", palette.text)),
            (None, State::Stale) => Some(("stale", palette.warning)),
            (None, State::Missing) => Some(("no picture", palette.weak)),
            (None, State::Fresh) => None,
        };
        if let Some((text, color)) = mark {
            let galley = painter.layout_no_wrap(text.into(), egui::FontId::proportional(10.0), color);
            let at = room.left_bottom() + vec2(3.0, -3.0 - galley.size().y);
            painter.rect_filled(
                Rect::from_min_size(at, galley.size()).expand2(vec2(2.0, 0.0)),
                2,
                Color32::from_black_alpha(190),
            );
            painter.galley(at, galley, color);
        }
        if is_favourite {
            painter.text(
                room.right_top() + vec2(-3.0, 1.0),
                Align2::RIGHT_TOP,
                "★",
                egui::FontId::proportional(14.0),
                palette.accent,
            );
        }
        let text = if is_current { format!("▸ {}", entry.name) } else { entry.name.clone() };
        let color = if is_selected { visuals.text_color() } else { palette.text };
        let line = Rect::from_min_max(pos2(rect.left(), room.bottom() + 1.0), rect.max).shrink2(vec2(3.0, 0.0));
        let mut job = egui::text::LayoutJob::simple_singleline(text, font, color);
        job.wrap = egui::text::TextWrapping::truncate_at_width(line.width());
        let galley = ui.painter().layout_job(job);
        painter.galley(line.min, galley, color);
    }

    /// What clicks, drags and the menu of a card mean.
    pub(super) fn touched(
        &mut self,
        ui: &Ui,
        response: &Response,
        entry: &Arc<Entry>,
        place: usize,
        library: &Library,
    ) -> Option<LibraryAction> {
        let is_selected = self.selected.contains(&entry.path);
        let (is_draft, is_favourite) = (library.state(entry) == State::Draft, library.marks().is_favourite(&entry.path));
        let name = if is_draft { format!("{}, {DRAFT}", entry.name) } else { entry.name.clone() };
        response.widget_info(|| WidgetInfo::selected(Role::ListBoxOption, true, is_selected, &name));
        response.dnd_set_drag_payload(Dragged(entry.path.clone()));
        let mut action = None;
        if response.clicked() {
            let modifiers = ui.input(|i| i.modifiers);
            if modifiers.shift {
                let paths = |place: usize| library.entries().get(self.found[place]).map(|entry| entry.path.clone());
                let from = self.anchor.as_ref();
                let from = (0..self.found.len()).find(|other| paths(*other).as_ref() == from).unwrap_or(place);
                self.selected.extend((from.min(place)..=from.max(place)).filter_map(paths));
            } else if modifiers.command {
                if !self.selected.remove(&entry.path) {
                    self.selected.insert(entry.path.clone());
                }
                self.anchor = Some(entry.path.clone());
            } else {
                self.selected = BTreeSet::from([entry.path.clone()]);
                self.anchor = Some(entry.path.clone());
            }
        }
        if response.double_clicked() {
            action = Some(LibraryAction::Open(vec![entry.path.clone()]));
        }
        if response.secondary_clicked() && !is_selected {
            self.selected = BTreeSet::from([entry.path.clone()]);
        }
        response.context_menu(|ui| {
            let all: Vec<PathBuf> = self.selected.iter().cloned().collect();
            let one = entry.path.clone();
            let mut item = |ui: &mut Ui, text: &str, what: LibraryAction| {
                if ui.button(text).clicked() {
                    action = Some(what);
                    ui.close();
                }
            };
            item(ui, "Open", LibraryAction::Open(all.clone()));
            item(ui, "Apply to this material", LibraryAction::Apply(one.clone()));
            item(ui, "Compare with this material", LibraryAction::Compare(one.clone()));
            let differences = if all.len() == 2 { "Differences of both" } else { "Differences from this material" };
            item(ui, differences, LibraryAction::Diff(if all.len() == 2 { all.clone() } else { vec![one.clone()] }));
            ui.separator();
            item(ui, "Edit tags, licence, values…", LibraryAction::Edit(all.clone()));
            item(ui, "Rename…", LibraryAction::Rename(one));
            item(ui, "Duplicate", LibraryAction::Duplicate(all.clone()));
            let favour = if is_favourite { "No favourite any more" } else { "Favourite" };
            item(ui, favour, LibraryAction::Favour(all, !is_favourite));
        });
        response.clone().on_hover_ui(|ui| {
            ui.label(RichText::new(&entry.name).strong());
            if let Some(problem) = &entry.problem {
                ui.label(RichText::new(problem).color(theme::now().error));
            }
            if is_draft {
                ui.label(DRAFT);
            }
            if !entry.tags.is_empty() {
                ui.label(entry.tags.join(", "));
            }
            if !entry.notes.is_empty() {
                ui.label(&entry.notes);
            }
            let licence = if entry.licence.is_empty() { "no licence stated" } else { &entry.licence };
            ui.label(RichText::new(format!("{}\n{licence}", entry.path.display())).small().weak());
        });
        action
    }
}
