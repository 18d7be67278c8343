//! What became of the library since an earlier release: a list to look through, and to export for release notes.

use crate::library::check::against::{Against, Changed, LookChange};
use crate::library::check::report::{change_words, sums};
use crate::theme;
use crate::widgets::search_field::search_field;
use egui::{Button, Label, RichText, Role, ScrollArea, Ui, WidgetInfo};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// What the panel asks of the application.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ReleaseAction {
    /// Back to the findings.
    Findings,
    /// Choose the folder of the release.
    Choose,
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
        let mut action = None;
        ui.horizontal_wrapped(|ui| {
            ui.spacing_mut().item_spacing = egui::vec2(3.0, 3.0);
            let mut button = |ui: &mut Ui, text: &str, can: bool, what: ReleaseAction| {
                if ui.add_enabled(can, Button::new(text).small()).clicked() {
                    action = Some(what);
                }
            };
            button(ui, "◀ Findings", true, ReleaseAction::Findings);
            button(ui, "Choose release…", true, ReleaseAction::Choose);
            button(ui, "Compare again", view.folder.is_some(), ReleaseAction::Again);
            button(ui, "Save notes…", view.against.is_some(), ReleaseAction::Save);
            button(ui, "Copy notes", view.against.is_some(), ReleaseAction::Copy);
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
        let name = view.folder.map(|folder| folder.display().to_string());
        let text = match (&name, view.against, view.note) {
            (_, _, Some(note)) => note.to_owned(),
            (None, ..) => "Choose the folder of an earlier release of this library.".to_owned(),
            (Some(name), None, None) => format!("Comparing with {name}…"),
            (Some(name), Some(against), None) => format!("Since {name}: {}", sums(against)),
        };
        ui.add(Label::new(RichText::new(text).small().color(theme::now().weak)).wrap());
        let Some(against) = view.against else { return action };
        search_field(ui, &mut self.search, "Search changes", "words of file, key or change: new, gone, value, look");
        self.list(ui, against).or(action)
    }

    fn list(&self, ui: &mut Ui, against: &Against) -> Option<ReleaseAction> {
        let mut action = None;
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
        let lines: Vec<Line> = lines.filter(holds).collect();
        let height = ui.spacing().interact_size.y;
        ui.spacing_mut().item_spacing.y = 1.0;
        ScrollArea::vertical().id_salt("changes").auto_shrink([false, false]).show_rows(ui, height, lines.len(), |ui, shown| {
            for line in &lines[shown] {
                let text = format!("{} {}   {}", line.mark, super::validation::short(&line.path, None), line.words);
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

/// What changed in a file, with words to search by.
fn words(changed: &Changed) -> String {
    let kind = match (changed.is_by_value, changed.look) {
        (true, LookChange::Changed(_)) => "by value and look",
        (true, _) => "by value",
        (false, _) => "not by value",
    };
    format!("changed {kind}: {}", change_words(changed))
}
