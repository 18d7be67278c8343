//! A folder of materials as a grid of small pictures: searched, selected, opened, dragged onto the view, and edited many at once.

use crate::library::{Entry, Library, Query, State};
use crate::theme;
use crate::widgets::search_field::search_field;
use egui::{
    Align2, Button, Color32, ColorImage, CornerRadius, Label, Rect, Response, RichText, Role, ScrollArea, Sense, Slider,
    TextureHandle, TextureOptions, Ui, WidgetInfo, pos2, vec2,
};
use std::collections::{BTreeSet, HashMap};
use std::path::PathBuf;
use std::sync::Arc;

/// Sides that a picture may have, points.
const SIDES: std::ops::RangeInclusive<f32> = 48.0..=256.0;
/// Textures kept; the others are made again when they come into sight.
const MAX_TEXTURES: usize = 400;
/// Points between cards.
const GAP: f32 = 4.0;
/// What there is to say of a draft.
const DRAFT: &str = "draft: the full picture is still to come";

/// What the panel asks of the application. Paths are relative to the library's folder.
#[derive(Clone, Debug, PartialEq)]
pub enum LibraryAction {
    /// Choose a folder.
    ChooseFolder,
    /// Open these as documents.
    Open(Vec<PathBuf>),
    /// Put this one in the place of the document in front.
    Apply(PathBuf),
    /// Open the page that edits these.
    Edit(Vec<PathBuf>),
    /// Open the page that names this one anew.
    Rename(PathBuf),
    /// Copy these.
    Duplicate(Vec<PathBuf>),
    /// Make these favourites, or not.
    Favour(Vec<PathBuf>, bool),
    /// Compare the document in front with this one.
    Compare(PathBuf),
    /// Show what two of these differ in, or one and the document in front.
    Diff(Vec<PathBuf>),
    /// Look for changes.
    Rescan,
    /// Open the page with the measured materials.
    NewFromMeasured,
    /// Take back the last edit of files, or make it again.
    Undo,
    /// The other way.
    Redo,
}

/// What is being dragged out of the panel: a file relative to the library's folder.
pub struct Dragged(pub PathBuf);

/// State of the panel.
pub struct LibraryPanel {
    search: String,
    side: f32,
    selected: BTreeSet<PathBuf>,
    /// A card to bring into sight.
    sought: Option<PathBuf>,
    /// Where a range begins.
    anchor: Option<PathBuf>,
    /// What was found, for a text, a revision of the library, and a count of marks.
    found: Vec<usize>,
    found_for: Option<(String, u64)>,
    query: Query,
    textures: HashMap<PathBuf, (TextureHandle, State)>,
    makes_pictures: bool,
}

impl Default for LibraryPanel {
    fn default() -> Self {
        Self {
            search: String::new(),
            side: 92.0,
            selected: BTreeSet::new(),
            sought: None,
            anchor: None,
            found: Vec::new(),
            found_for: None,
            query: Query::default(),
            textures: HashMap::new(),
            makes_pictures: true,
        }
    }
}

/// What a card shows.
struct Card<'a> {
    entry: &'a Entry,
    state: State,
    /// Whether it is the document in front.
    is_current: bool,
    is_favourite: bool,
}

/// What the panel knows besides the library.
pub struct Around<'a> {
    /// The file of the document in front.
    pub current: Option<&'a std::path::Path>,
    /// Names of the edits that can be taken back and made again.
    pub undo: Option<&'a str>,
    /// The same.
    pub redo: Option<&'a str>,
}

impl LibraryPanel {
    /// Forgets what was selected and found: another library is shown.
    pub fn reset(&mut self) {
        let (side, makes_pictures) = (self.side, self.makes_pictures);
        *self = Self { side, makes_pictures, ..Self::default() };
    }

    /// Selected files, relative to the library's folder.
    pub fn selected(&self) -> impl Iterator<Item = &PathBuf> {
        self.selected.iter()
    }

    /// Selects a card and brings it into sight; a search that leaves it out is given up.
    pub fn reveal(&mut self, path: PathBuf) {
        self.selected = BTreeSet::from([path.clone()]);
        (self.anchor, self.sought) = (Some(path.clone()), Some(path));
    }

    /// What was found has to be found anew, since marks have changed.
    pub fn refresh(&mut self) {
        self.found_for = None;
    }

    /// There are new pictures, which matters where they are what is searched for.
    pub fn is_new(&mut self) {
        if self.search.contains("is:") {
            self.found_for = None;
        }
    }

    /// Shows the panel.
    pub fn show(&mut self, ui: &mut Ui, library: Option<&mut Library>, around: &Around) -> Option<LibraryAction> {
        let Some(library) = library else {
            return empty(ui);
        };
        let mut action = self.head(ui, library, around);
        let key = (self.search.clone(), library.revision());
        if self.found_for.as_ref() != Some(&key) {
            self.query = Query::parse(&self.search);
            self.found = library.matching(&self.query);
            self.found_for = Some(key);
            let known: BTreeSet<&PathBuf> = library.entries().iter().map(|entry| &entry.path).collect();
            self.selected.retain(|path| known.contains(path));
        }
        if let Some(problem) = self.query.problem() {
            ui.label(RichText::new(format!("⚠ {problem}")).small().color(theme::now().warning));
        }
        egui::Panel::bottom("selected").frame(egui::Frame::new()).show_separator_line(false).show(ui, |ui| {
            action = self.selection_bar(ui, library).or(action.take());
        });
        self.grid(ui, library, around).or(action)
    }

    /// Folder, search, size, and what can be done with the whole.
    fn head(&mut self, ui: &mut Ui, library: &Library, around: &Around) -> Option<LibraryAction> {
        let mut action = None;
        search_field(ui, &mut self.search, "Search library", "metal rough<0.3 tag:measured");
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = 4.0;
            let name = library.root().file_name().unwrap_or(library.root().as_os_str()).to_string_lossy();
            let menu = ui.menu_button(format!("{name} ⏷"), |ui| {
                let mut item = |ui: &mut Ui, text: &str, is_possible: bool, what: LibraryAction| {
                    if ui.add_enabled(is_possible, Button::new(text)).clicked() {
                        action = Some(what);
                        ui.close();
                    }
                };
                item(ui, "Open another folder…", true, LibraryAction::ChooseFolder);
                item(ui, "Look for changes", true, LibraryAction::Rescan);
                item(ui, "New from measured…", true, LibraryAction::NewFromMeasured);
                ui.separator();
                let undo = around.undo.map_or("Undo library edit".to_owned(), |title| format!("Undo: {title}"));
                item(ui, &undo, around.undo.is_some(), LibraryAction::Undo);
                let redo = around.redo.map_or("Redo library edit".to_owned(), |title| format!("Redo: {title}"));
                item(ui, &redo, around.redo.is_some(), LibraryAction::Redo);
                ui.separator();
                ui.checkbox(&mut self.makes_pictures, "Make missing pictures");
            });
            menu.response.on_hover_text(library.root().display().to_string());
            let text = match library.progress() {
                Some(progress) => format!("reading {} of {}", progress.done, progress.total),
                None => format!("{} of {}", self.found.len(), library.entries().len()),
            };
            ui.label(RichText::new(text).small().color(theme::now().weak));
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                ui.spacing_mut().slider_width = 64.0;
                ui.add(Slider::new(&mut self.side, SIDES).show_value(false)).accessible_name("Size of pictures");
            });
        });
        action
    }

    fn grid(&mut self, ui: &mut Ui, library: &mut Library, around: &Around) -> Option<LibraryAction> {
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

    fn paint(&self, ui: &Ui, rect: Rect, response: &Response, card: &Card) {
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
    fn touched(
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

    /// What can be done with what is selected.
    fn selection_bar(&mut self, ui: &mut Ui, library: &Library) -> Option<LibraryAction> {
        let mut action = None;
        let all: Vec<PathBuf> = self.selected.iter().cloned().collect();
        ui.add_space(2.0);
        let has_any = !all.is_empty();
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = 3.0;
            if ui.add_enabled(has_any, Button::new("Open")).clicked() {
                action = Some(LibraryAction::Open(all.clone()));
            }
            let apply = ui.add_enabled(all.len() == 1, Button::new("Apply"));
            let apply = apply.on_hover_text("Put it in the place of the material in front; undo takes it back");
            if let Some(one) = all.first().filter(|_| apply.clicked()) {
                action = Some(LibraryAction::Apply(one.clone()));
            }
            let edit = ui.add_enabled(has_any, Button::new("Edit…"));
            if edit.on_hover_text("Tags, licence and values of all that are selected, in one step").clicked() {
                action = Some(LibraryAction::Edit(all.clone()));
            }
            if ui.button("All").on_hover_text("Select everything that was found").clicked() {
                let paths = self.found.iter().filter_map(|number| library.entries().get(*number));
                self.selected = paths.map(|entry| entry.path.clone()).collect();
            }
            let text = format!("{} selected", all.len());
            ui.add(Label::new(RichText::new(text).small().color(theme::now().weak)).truncate());
        });
        action
    }
}

/// What stands there without a library.
fn empty(ui: &mut Ui) -> Option<LibraryAction> {
    ui.label(RichText::new("Any folder of materials is a library: drop one here, or").weak());
    ui.button("Open a folder…").clicked().then_some(LibraryAction::ChooseFolder)
}
