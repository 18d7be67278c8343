//! A folder of materials as a grid of small pictures: searched, selected, opened, dragged onto the view, and edited many at once.

mod card;
mod grid;

use crate::library::{Library, Query, State};
use crate::theme;
use crate::widgets::search_field::search_field;
use egui::{Button, Label, RichText, Slider, TextureHandle, Ui};
use std::collections::{BTreeSet, HashMap};
use std::path::PathBuf;

/// Sides that a picture may have, points.
const SIDES: std::ops::RangeInclusive<f32> = 48.0..=256.0;

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
