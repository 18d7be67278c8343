//! What became of the library since an earlier release: a list to look through, and to export for release notes.

use crate::library::check::against::{Against, Changed, LookChange};
use crate::library::check::report::{change_words, sums};
use crate::theme;
use crate::widgets::search_field::search_field;
use egui::{Align, Button, Label, Layout, RichText, Role, ScrollArea, TextEdit, Ui, WidgetInfo};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// What the panel asks of the application.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ReleaseAction {
    /// Back to the findings.
    Findings,
    /// Choose the folder of the release.
    Choose,
    /// Compare with the release in this folder.
    Folder(PathBuf),
    /// Compare again.
    Again,
    /// End comparing.
    End,
    /// Whether pictures are rendered to compare looks.
    Render(bool),
    /// Put the notes into a file.
    Save,
    /// Put the notes where they can be pasted from.
    Copy,
    /// Open what a file was and is beside each other; relative to both folders.
    Diff(PathBuf),
    /// Show the card of a file.
    Show(PathBuf),
}

/// What is shown.
pub struct ReleaseView<'a> {
    /// The folder of the release, once it is chosen.
    pub folder: Option<&'a Path>,
    /// What became of the library since.
    pub against: Option<&'a Arc<Against>>,
    /// How far comparing is, while it goes on.
    pub share: Option<f32>,
    /// Whether pictures are rendered to compare looks.
    pub renders_looks: bool,
    /// What is to be said of the comparison.
    pub note: Option<&'a str>,
}

/// State of the panel.
#[derive(Default)]
pub struct ReleasePanel {
    search: String,
    /// What is typed as the folder; `None` where it is the one that is compared with.
    typed: Option<String>,
    lines: Vec<Line>,
    /// What the lines are of, and what was searched for.
    lines_for: Option<(Arc<Against>, String)>,
}

/// A line of the list: its text, its path, and whether both versions can be compared.
struct Line {
    mark: &'static str,
    path: PathBuf,
    words: String,
    is_in_both: bool,
}

impl ReleasePanel {
    /// Shows the panel.
    pub fn show(&mut self, ui: &mut Ui, view: &ReleaseView) -> Option<ReleaseAction> {
        let mut action = self.folder(ui, view);
        ui.horizontal_wrapped(|ui| {
            ui.spacing_mut().item_spacing = egui::vec2(3.0, 3.0);
            let mut button = |ui: &mut Ui, text: &str, can: bool, what: ReleaseAction| {
                if ui.add_enabled(can, Button::new(text).small()).clicked() {
                    action = Some(what);
                }
            };
            button(ui, "Save notes…", view.against.is_some(), ReleaseAction::Save);
            button(ui, "Copy notes", view.against.is_some(), ReleaseAction::Copy);
            button(ui, "Again", view.folder.is_some(), ReleaseAction::Again);
            let mut renders = view.renders_looks;
            let look = ui.checkbox(&mut renders, "Render looks");
            look.on_hover_text("Renders both versions of what has changed; without it, fresh small pictures are compared");
            if renders != view.renders_looks {
                action = Some(ReleaseAction::Render(renders));
            }
            if let Some(share) = view.share {
                ui.add(egui::ProgressBar::new(share).desired_width(90.0).show_percentage());
                if ui.small_button("End").accessible_name("End comparing with the release").clicked() {
                    action = Some(ReleaseAction::End);
                }
            }
        });
        let (text, all) = match (view.folder, view.against, view.note) {
            (_, _, Some(note)) => (note.to_owned(), note.to_owned()),
            (None, ..) => ("Type or choose the folder of an earlier release of this library.".to_owned(), String::new()),
            (Some(_), None, None) => ("Comparing…".to_owned(), String::new()),
            (Some(_), Some(against), None) => (short_sums(against), sums(against)),
        };
        let label = ui.add(Label::new(RichText::new(text).small().color(theme::now().text)).truncate());
        if !all.is_empty() {
            label.on_hover_text(all);
        }
        let Some(against) = view.against else { return action };
        search_field(ui, &mut self.search, "Search changes", "words of file, key or change: new, gone, value, look");
        self.filter(against);
        self.list(ui).or(action)
    }

    /// The folder of the release, to be typed or chosen.
    fn folder(&mut self, ui: &mut Ui, view: &ReleaseView) -> Option<ReleaseAction> {
        let mut action = None;
        let name = view.folder.map(|folder| folder.display().to_string());
        let mut typed = self.typed.clone().or_else(|| name.clone()).unwrap_or_default();
        let size = egui::vec2(ui.available_width(), ui.spacing().interact_size.y);
        ui.allocate_ui_with_layout(size, Layout::right_to_left(Align::Center), |ui| {
            ui.spacing_mut().item_spacing.x = 3.0;
            if ui.button("Choose…").accessible_name("Choose the folder of the release").clicked() {
                action = Some(ReleaseAction::Choose);
            }
            ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
                if ui.button("◀").accessible_name("Back to the findings").on_hover_text("Back to the findings").clicked() {
                    action = Some(ReleaseAction::Findings);
                }
                let field =
                    TextEdit::singleline(&mut typed).hint_text("folder of an earlier release").desired_width(f32::INFINITY);
                let field = ui.add(field).accessible_name("Folder of the release");
                if field.changed() {
                    self.typed = Some(typed.clone());
                }
                if field.lost_focus() {
                    let typed = self.typed.take().filter(|text| !text.trim().is_empty() && Some(text) != name.as_ref());
                    if let Some(typed) = typed.filter(|_| ui.input(|i| i.key_pressed(egui::Key::Enter))) {
                        action = Some(ReleaseAction::Folder(PathBuf::from(typed.trim())));
                    }
                }
            });
        });
        action
    }

    /// Finds the lines to show, where something has changed.
    fn filter(&mut self, against: &Arc<Against>) {
        let is_same = |(known, search): &(Arc<Against>, String)| Arc::ptr_eq(known, against) && *search == self.search;
        if self.lines_for.as_ref().is_some_and(is_same) {
            return;
        }
        let search = self.search.to_lowercase();
        let plain = |mark: &'static str, word: &str, path: &PathBuf| Line {
            mark,
            path: path.clone(),
            words: word.to_owned(),
            is_in_both: false,
        };
        let changed = against.changed.iter().map(|changed| Line {
            mark: if changed.is_by_value { "≠" } else { "≈" },
            path: changed.path.clone(),
            words: words(changed),
            is_in_both: changed.problem.is_none(),
        });
        let added = against.added.iter().map(|path| plain("+", "new", path));
        let removed = against.removed.iter().map(|path| plain("−", "gone", path));
        let lines = added.chain(removed).chain(changed);
        let holds = |line: &Line| {
            let text = format!("{} {}", line.path.display(), line.words).to_lowercase();
            search.split_whitespace().all(|word| text.contains(word))
        };
        self.lines = lines.filter(holds).collect();
        self.lines_for = Some((against.clone(), self.search.clone()));
    }

    fn list(&self, ui: &mut Ui) -> Option<ReleaseAction> {
        let (mut action, lines) = (None, &self.lines);
        let height = ui.spacing().interact_size.y;
        ui.spacing_mut().item_spacing.y = 1.0;
        ScrollArea::vertical().id_salt("changes").auto_shrink([false, false]).show_rows(ui, height, lines.len(), |ui, shown| {
            for line in &lines[shown] {
                let text = format!("{} {}   {}", line.mark, super::finding::short(&line.path, None), line.words);
                let button = Button::selectable(false, &text).truncate().right_text("");
                let response = ui.add_sized([ui.available_width(), height], button);
                response.widget_info(|| WidgetInfo::labeled(Role::Button, true, &text));
                let tip = if line.is_in_both { "Show both versions beside each other" } else { "Show its card" };
                if response.on_hover_text(tip).clicked() {
                    let path = line.path.clone();
                    action = Some(if line.is_in_both { ReleaseAction::Diff(path) } else { ReleaseAction::Show(path) });
                }
            }
        });
        action
    }
}

/// The counts in few words.
fn short_sums(against: &Against) -> String {
    let count = |is: &dyn Fn(&Changed) -> bool| against.changed.iter().filter(|changed| is(changed)).count();
    let unknown = match count(&|changed| changed.look == LookChange::Unknown) {
        0 => String::new(),
        n => format!(" ({n} not known)"),
    };
    format!(
        "{} new, {} gone, {} changed by value, {} by look{unknown}",
        against.added.len(),
        against.removed.len(),
        count(&|changed| changed.is_by_value),
        count(&|changed| matches!(changed.look, LookChange::Changed(_)))
    )
}

/// What changed in a file, with words to search by.
fn words(changed: &Changed) -> String {
    let kind = match (changed.is_by_value, changed.look) {
        (true, LookChange::Changed(_)) => "by value and look",
        (true, _) => "by value",
        (false, _) => "not by value",
    };
    format!("changed {kind}: {}", change_words(changed))
}
