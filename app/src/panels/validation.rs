//! What a check of the library found: counts, a list by file that can be filtered, files that are one material, and options of the check.

use super::finding::{details, file_name, pair_line, property_of, sentence, short};
use crate::library::check::{Checked, Kind, Options, Pair, Row};
use crate::theme;
use crate::widgets::search_field::search_field;
use burnish_material::{Property, Severity};
use egui::{Button, Color32, Frame, Label, RichText, Role, ScrollArea, Ui, WidgetInfo};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Severities with the words for several of them.
const SEVERITIES: [(Severity, &str, &str); 3] =
    [(Severity::Error, "error", "errors"), (Severity::Warning, "warning", "warnings"), (Severity::Note, "note", "notes")];

/// Points across above which counts have words beside their marks, at the usual size of text.
const WIDE: f32 = 560.0;

/// What the panel asks of the application. Paths are whole.
#[derive(Clone, Debug, PartialEq)]
pub enum ValidationAction {
    /// Show the card of a file and the property, without opening the file.
    Show(PathBuf, Option<Property>),
    /// Open a file, with a property in sight.
    Open(PathBuf, Option<Property>),
    /// Open both beside each other.
    Diff(PathBuf, PathBuf),
    /// The first takes in the second.
    Unite(PathBuf, PathBuf),
    /// Look at all files anew.
    Again,
    /// End the check.
    End,
    /// Check in this way from now on.
    Set(Options),
    /// Write the report to a file.
    Save,
    /// Show what became of the library since a release.
    Release,
}

/// What is shown.
pub struct ValidationView<'a> {
    /// What was found; `None` before the first check is done.
    pub checked: Option<&'a Arc<Checked>>,
    /// What each row and each pair is found by, see [`search_words`].
    pub words: &'a [String],
    /// What is checked.
    pub subject: &'a str,
    /// The folder that paths are shown from.
    pub root: Option<&'a Path>,
    /// How it is checked.
    pub options: &'a Options,
    /// How far the check is, while it goes on.
    pub share: Option<f32>,
    /// The command line that does the same; `None` where there is no library.
    pub command: Option<&'a str>,
    /// What is to be said of the check itself.
    pub note: Option<&'a str>,
}

/// A line of the list.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Line {
    Pair(usize),
    /// The file of the row, with how many of its rows are listed.
    File(usize, usize),
    Row(usize),
}

/// State of the panel.
#[derive(Default)]
pub struct ValidationPanel {
    search: String,
    /// Severities that are left out, in the order of the counts.
    hidden: [bool; 3],
    hides_pairs: bool,
    selected: Option<usize>,
    /// How many rows there are of each severity.
    counts: [usize; 3],
    lines: Vec<Line>,
    lines_for: Option<(Arc<Checked>, String, [bool; 3], bool)>,
}

impl ValidationPanel {
    /// Shows the panel.
    pub fn show(&mut self, ui: &mut Ui, view: &ValidationView) -> Option<ValidationAction> {
        if let Some(checked) = view.checked {
            self.filter(checked, view.words);
        }
        let mut action = self.head(ui, view);
        let Some(checked) = view.checked else {
            ui.label(RichText::new(if view.share.is_some() { "Checking…" } else { "Nothing was checked yet." }).weak());
            return action;
        };
        if let Some(row) = self.selected.and_then(|at| checked.rows.get(at)) {
            let frame = Frame::new().inner_margin(egui::Margin { left: 0, right: 6, top: 3, bottom: 2 });
            egui::Panel::bottom("finding").frame(frame).show_separator_line(true).show(ui, |ui| {
                action = details(ui, row, view).or(action.take());
            });
        }
        self.list(ui, checked, view).or(action)
    }

    /// Counts that filter, the search, and what can be done with the whole.
    fn head(&mut self, ui: &mut Ui, view: &ValidationView) -> Option<ValidationAction> {
        let mut action = None;
        let is_wide = ui.available_width() > WIDE * theme::text_scale(ui);
        ui.horizontal_wrapped(|ui| {
            ui.spacing_mut().item_spacing = egui::vec2(3.0, 3.0);
            for (at, (severity, one, many)) in SEVERITIES.into_iter().enumerate() {
                let count = view.checked.map_or(0, |_| self.counts[at]);
                let (mark, color) = mark(severity);
                let words = if is_wide { format!(" {}", if count == 1 { one } else { many }) } else { String::new() };
                let text = RichText::new(format!("{mark} {count}{words}")).color(color);
                let button = ui.add(Button::selectable(!self.hidden[at], text).small());
                let button = button.on_hover_text(format!("Show or hide {many}"));
                if button.accessible_name(format!("Show {many}, {count}")).clicked() {
                    self.hidden[at] = !self.hidden[at];
                }
            }
            let pairs = view.checked.map_or(0, |checked| checked.pairs.len());
            let words = if is_wide { format!(" {}", if pairs == 1 { "pair" } else { "pairs" }) } else { String::new() };
            let text = format!("🗐 {pairs}{words}");
            let button = ui.add(Button::selectable(!self.hides_pairs, text).small());
            let button = button.on_hover_text("Files with the same values, or that look the same within 0.3 %");
            if button.accessible_name(format!("Show pairs, {pairs}")).clicked() {
                self.hides_pairs = !self.hides_pairs;
            }
            action = menu(ui, view);
            match view.share {
                Some(share) => {
                    ui.add(egui::ProgressBar::new(share).desired_width(90.0).show_percentage());
                    if ui.small_button("End").accessible_name("End the check").clicked() {
                        action = Some(ValidationAction::End);
                    }
                }
                None => {
                    let text = view.note.map_or_else(|| view.subject.to_owned(), |note| format!("{}: {note}", view.subject));
                    ui.add(Label::new(RichText::new(text).small().color(theme::now().weak)).truncate());
                }
            }
        });
        search_field(ui, &mut self.search, "Search findings", "words of file, key or sentence");
        action
    }

    /// Finds the lines to show, where something has changed.
    fn filter(&mut self, checked: &Arc<Checked>, texts: &[String]) {
        let is_same = self.lines_for.as_ref().is_some_and(|(known, search, hidden, hides)| {
            Arc::ptr_eq(known, checked) && *search == self.search && *hidden == self.hidden && *hides == self.hides_pairs
        });
        if is_same {
            return;
        }
        if self.lines_for.as_ref().is_some_and(|(known, ..)| !Arc::ptr_eq(known, checked)) {
            self.selected = None;
        }
        let is_of = |severity| move |row: &&Row| row.severity == severity && is_listed(row);
        self.counts = SEVERITIES.map(|(severity, ..)| checked.rows.iter().filter(is_of(severity)).count());
        let search = self.search.to_lowercase();
        let words: Vec<&str> = search.split_whitespace().collect();
        let holds = |text: &str| words.iter().all(|word| text.contains(word));
        self.lines.clear();
        if !self.hides_pairs {
            let of = |at: &usize| texts.get(checked.rows.len() + at).is_some_and(|text| holds(text));
            self.lines.extend((0..checked.pairs.len()).filter(of).map(Line::Pair));
        }
        let mut head: Option<usize> = None;
        for (at, row) in checked.rows.iter().enumerate() {
            let place = SEVERITIES.iter().position(|(severity, ..)| *severity == row.severity).unwrap_or(0);
            if self.hidden[place] || !is_listed(row) || !texts.get(at).is_some_and(|text| holds(text)) {
                continue;
            }
            match head.and_then(|head| self.lines.get_mut(head)) {
                Some(Line::File(first, count)) if checked.rows[*first].path.as_os_str() == row.path.as_os_str() => *count += 1,
                _ => {
                    head = Some(self.lines.len());
                    self.lines.push(Line::File(at, 1));
                }
            }
            self.lines.push(Line::Row(at));
        }
        self.lines_for = Some((checked.clone(), self.search.clone(), self.hidden, self.hides_pairs));
    }

    fn list(&mut self, ui: &mut Ui, checked: &Arc<Checked>, view: &ValidationView) -> Option<ValidationAction> {
        let mut action = None;
        if self.lines.is_empty() {
            let is_clean = checked.rows.iter().all(|row| !is_listed(row));
            let text = match is_clean {
                _ if checked.files == 0 => "There is no material in this folder.",
                true => "✔ Nothing was found.",
                false => "Nothing matches.",
            };
            let is_clean = is_clean && checked.files > 0;
            ui.label(RichText::new(text).color(if is_clean { theme::now().good } else { theme::now().weak }));
        }
        let height = ui.spacing().interact_size.y;
        ui.spacing_mut().item_spacing.y = 1.0;
        ScrollArea::vertical().id_salt("findings").auto_shrink([false, false]).show_rows(
            ui,
            height,
            self.lines.len(),
            |ui, shown| {
                for at in shown {
                    match self.lines[at] {
                        Line::Pair(pair) => action = pair_line(ui, &checked.pairs[pair], view, height).or(action.take()),
                        Line::File(row, count) => {
                            let path = &checked.rows[row].path;
                            let text = RichText::new(format!("{}  ({count})", short(path, view.root))).strong();
                            let button = ui.add_sized(
                                [ui.available_width(), height],
                                Button::new(text).frame(false).truncate().right_text(""),
                            );
                            let name = format!("File {}, {count} listed", short(path, view.root));
                            button.widget_info(|| WidgetInfo::labeled(Role::Button, true, &name));
                            if button.double_clicked() {
                                action = Some(ValidationAction::Open(path.clone(), None));
                            } else if button.clicked() {
                                action = Some(ValidationAction::Show(path.clone(), None));
                            }
                        }
                        Line::Row(number) => {
                            action = self.row_line(ui, number, &checked.rows[number], view, height).or(action.take())
                        }
                    }
                }
            },
        );
        action
    }

    fn row_line(
        &mut self,
        ui: &mut Ui,
        number: usize,
        row: &Row,
        view: &ValidationView,
        height: f32,
    ) -> Option<ValidationAction> {
        let (mark, color) = mark(row.severity);
        let message = sentence(row, view.root);
        let is_selected = self.selected == Some(number);
        let mut job = egui::text::LayoutJob::default();
        let font = egui::TextStyle::Body.resolve(ui.style());
        let mut add = |text: String, color| job.append(&text, 0.0, egui::TextFormat::simple(font.clone(), color));
        add(format!("   {mark} "), color);
        if !row.key.is_empty() {
            add(format!("{}  ", row.key), theme::now().strong);
        }
        add(message.clone(), theme::now().text);
        let button = Button::selectable(is_selected, job).truncate().right_text("");
        let response = ui.add_sized([ui.available_width(), height], button);
        let name = format!("{} in {}: {} {}", row.severity.word(), file_name(&row.path), row.key, message);
        response.widget_info(|| WidgetInfo::selected(Role::Button, true, is_selected, &name));
        let property = property_of(row);
        if response.double_clicked() {
            return Some(ValidationAction::Open(row.path.clone(), property));
        }
        let is_clicked = response.clicked();
        response.on_hover_text(format!("{message}\n\nTwo clicks open the file with the property in sight."));
        is_clicked.then(|| {
            self.selected = Some(number);
            ValidationAction::Show(row.path.clone(), property)
        })
    }
}

/// Options of the check and what can be done with its report.
fn menu(ui: &mut Ui, view: &ValidationView) -> Option<ValidationAction> {
    let mut action = None;
    let options = ui.menu_button("Check ⏷", |ui| {
        let mut set = view.options.clone();
        let look = ui.checkbox(&mut set.renders_looks, "By look: render each");
        look.on_hover_text(
            "Renders each material small to find those that look the same; without it, fresh small pictures are compared",
        );
        let probe = ui.checkbox(&mut set.probes_stability, "Stability: probe each");
        probe.on_hover_text("Probes each material numerically, which takes a second or so each");
        if set != *view.options {
            action = Some(ValidationAction::Set(set));
        }
        if ui.add_enabled(view.root.is_some(), Button::new("Against a release…")).clicked() {
            action = Some(ValidationAction::Release);
            ui.close();
        }
        if ui.button("Check all again").clicked() {
            action = Some(ValidationAction::Again);
            ui.close();
        }
    });
    options.response.accessible_name("How to check");
    let report = ui.menu_button("Report ⏷", |ui| {
        if ui
            .add_enabled(view.checked.is_some(), Button::new("Save report…"))
            .on_hover_text("As .json or as text, as the command line gives it")
            .clicked()
        {
            action = Some(ValidationAction::Save);
            ui.close();
        }
        if let Some(command) = view.command {
            ui.separator();
            ui.label(RichText::new("The same from the command line:").small().weak());
            ui.add(Label::new(RichText::new(command).monospace().small()).wrap());
            if ui.button("Copy command").clicked() {
                ui.ctx().copy_text(command.to_owned());
                ui.close();
            }
        }
    });
    report.response.accessible_name("Report of the check");
    action
}

/// What each row, and after them each pair, is found by, in lower case: of ten thousand files too much for a frame.
pub fn search_words(checked: &Checked) -> Vec<String> {
    let text = |row: &Row| format!("{} {} {} {}", row.path.display(), row.key, row.message, row.severity.word());
    let pair = |pair: &Pair| format!("{} {} pair", pair.a.display(), pair.b.display());
    checked.rows.iter().map(text).chain(checked.pairs.iter().map(pair)).map(|text| text.to_lowercase()).collect()
}

/// Small pictures that are stale are no fault of a file.
fn is_listed(row: &Row) -> bool {
    row.kind != Kind::Thumbnail
}

fn mark(severity: Severity) -> (&'static str, Color32) {
    match severity {
        Severity::Error => ("⊗", theme::now().error),
        Severity::Warning => ("⚠", theme::now().warning),
        Severity::Note => ("ℹ", theme::now().weak),
    }
}
