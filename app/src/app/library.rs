//! The open library: its panel, edits of its files as steps that can be taken back, and the pages about it.

use super::App;
use crate::background::Background;
use crate::dialogs::Purpose;
use crate::dock::Pane;
use crate::files;
use crate::library::Library;
use crate::library::edit::{self, BatchEdit, Planned};
use crate::library::export::Outcome;
use crate::library::pack::Formats;
use crate::loading::Job;
use crate::own_files;
use crate::pages::Page;
use crate::panels::batch_page::BatchPage;
use crate::panels::library::{Around, LibraryAction, LibraryPanel};
use crate::panels::measured_page::MeasuredPage;
use crate::sources::Source;
use burnish_material::MaterialFile;
use burnish_presets::measured::Measured;
use egui::{Context, Ui};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, TryRecvError, channel};

/// The library that was open last, in the state folder.
const FILE: &str = "library.ron";
/// Edits that can be taken back.
const MAX_STEPS: usize = 200;

/// Where an edit of files belongs once it is done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Step {
    New,
    Undo,
    Redo,
}

/// An edit that a thread carries out: what of it was done, and why files were left as they were.
type Running = (Step, Receiver<(BatchEdit, Vec<String>)>);

/// The library and what belongs to it.
#[derive(Default)]
pub(super) struct LibraryWork {
    library: Option<Library>,
    panel: LibraryPanel,
    done: Vec<BatchEdit>,
    undone: Vec<BatchEdit>,
    running: Option<Running>,
    /// The document in front and its steps when files were edited last: if both are the same still, nothing was done since.
    last: Option<(u64, usize)>,
    batch: BatchPage,
    /// A file that is to be named anew, and the name.
    renamed: Option<(PathBuf, String)>,
    measured: MeasuredPage,
    /// The contact sheet or pack that is being made.
    pub(super) export: Background<Outcome>,
    /// In which other formats the next pack is written, too.
    pub(super) formats: Formats,
}

impl LibraryWork {
    /// The open library.
    pub fn library(&self) -> Option<&Library> {
        self.library.as_ref()
    }

    /// Whether files are being written.
    pub fn is_editing(&self) -> bool {
        self.running.is_some()
    }
}

impl App {
    /// The open library, for tests.
    pub fn library(&self) -> Option<&Library> {
        self.library_work.library()
    }

    /// Opens a folder as library, and remembers it.
    pub fn open_library(&mut self, root: &Path, ctx: &Context) {
        let wake = ctx.clone();
        let root = std::path::absolute(root).unwrap_or_else(|_| root.to_path_buf());
        self.library_work.library = Some(Library::open(&root, self.keeping.places(), move || wake.request_repaint()));
        self.library_work.panel.reset();
        (self.library_work.done, self.library_work.undone, self.library_work.last) = (Vec::new(), Vec::new(), None);
        self.dock.set_shown(Pane::Folder, true);
        if let (Some(state), Some(text)) = (&self.keeping.places().state, root.to_str()) {
            // Not being remembered is no reason to disturb anybody.
            _ = ron::to_string(text).is_ok_and(|text| own_files::save(&state.join(FILE), &text).is_ok());
        }
        self.messages.info(format!("Library {}", root.display()));
    }

    /// The folder that was open last time, if it is still there.
    pub(super) fn reopen_library(&mut self, ctx: &Context) {
        let Some(state) = self.keeping.places().state.clone() else { return };
        let (root, problem) = own_files::load(&state.join(FILE), own_files::MAX_BYTES, |text| {
            ron::from_str::<PathBuf>(text).map_err(|error| format!("expected the folder of a library: {error}"))
        });
        problem.into_iter().for_each(|problem| self.messages.warning(problem));
        if let Some(root) = root.filter(|_| self.dock.is_shown(Pane::Folder)) {
            let wake = ctx.clone();
            self.library_work.library = Some(Library::open(&root, self.keeping.places(), move || wake.request_repaint()));
        }
    }

    /// Takes what threads have found, made and written. Once per frame.
    pub(super) fn mind_the_library(&mut self, ctx: &Context) {
        if let Some(library) = &mut self.library_work.library {
            if library.poll() {
                self.library_work.panel.is_new();
            }
            library.take_problems().into_iter().for_each(|problem| self.messages.warning(problem));
        }
        self.collect_hand_out();
        let Some((step, receiver)) = &self.library_work.running else { return };
        let (step, result) = (*step, receiver.try_recv());
        match result {
            Err(TryRecvError::Empty) => {}
            Err(TryRecvError::Disconnected) => self.library_work.running = None,
            Ok((edit, refused)) => {
                self.library_work.running = None;
                self.edited_files(step, edit, refused, ctx);
            }
        }
    }

    fn edited_files(&mut self, step: Step, edit: BatchEdit, refused: Vec<String>, ctx: &Context) {
        refused.into_iter().for_each(|sentence| self.messages.warning(sentence));
        if edit.files.is_empty() {
            return self.messages.info(format!("{}: nothing had to be changed.", edit.title));
        }
        self.compare.sources.forget_files();
        for gone in edit.files.iter().filter(|file| file.after.is_none()).filter_map(|file| file.before.as_ref()) {
            self.keeping.saved(&gone.path);
        }
        for path in edit.files.iter().filter_map(|file| Some(&file.after.as_ref()?.path)) {
            self.keeping.saved(path);
            let open = self.tabs.documents(&self.editor.document).find(|(_, document)| document.path() == Some(path));
            match open.map(|(id, document)| (id, document.is_modified(), document.title())) {
                Some((id, false, _)) => self.loader.start(Job::Reload(id, path.clone()), ctx),
                Some((id, true, title)) => self.pages.ask_about_change(id, path.clone(), title, true),
                None => {}
            }
        }
        let (count, title) = (edit.files.len(), edit.title.clone());
        match step {
            Step::New => {
                self.library_work.done.push(edit);
                self.library_work.undone.clear();
                let surplus = self.library_work.done.len().saturating_sub(MAX_STEPS);
                self.library_work.done.drain(..surplus);
            }
            Step::Undo => self.library_work.undone.push(edit.reversed()),
            Step::Redo => self.library_work.done.push(edit),
        }
        let what = match step {
            Step::New => "",
            Step::Undo => "Undid: ",
            Step::Redo => "Redid: ",
        };
        let files = if count == 1 { "1 file".to_owned() } else { format!("{count} files") };
        self.messages.info(format!("{what}{title}: {files} written."));
        self.library_work.last = Some((self.tabs.front_id(), self.history.labels().count()));
        if let Some(library) = &mut self.library_work.library {
            library.rescan();
        }
    }

    /// Carries an edit out on a thread; one at a time.
    fn edit_files(&mut self, step: Step, plan: impl FnOnce() -> Planned + Send + 'static, ctx: &Context) {
        if self.library_work.running.is_some() {
            return self.messages.warning("Files are still being written; try again in a moment.");
        }
        let (sender, receiver) = channel();
        let wake = ctx.clone();
        std::thread::spawn(move || {
            let planned = plan();
            let (done, failed) = planned.edit.carry_out();
            let refused = planned.refused.into_iter().chain(failed).collect();
            // Nobody listens where the window has closed.
            _ = sender.send((done, refused));
            wake.request_repaint();
        });
        self.library_work.running = Some((step, receiver));
    }

    /// The same for an edit that is not taken back or made again.
    pub(super) fn edit_files_anew(&mut self, plan: impl FnOnce() -> Planned + Send + 'static, ctx: &Context) {
        self.edit_files(Step::New, plan, ctx);
    }

    /// A document was saved: if that was in the library, it has changed.
    pub(super) fn saved_in_library(&mut self, path: &Path) {
        self.compare.sources.forget_files();
        if let Some(library) = self.library_work.library.as_mut().filter(|library| path.starts_with(library.root())) {
            library.rescan();
        }
    }

    /// Looks for changes that other programs have made to files of the library while the window was not in use.
    pub(super) fn look_for_changes(&mut self) {
        self.compare.sources.forget_files();
        if let Some(library) = self.library_work.library.as_mut().filter(|library| library.progress().is_none()) {
            library.rescan();
        }
    }

    /// Whole paths of the selected cards.
    pub(super) fn selected_cards(&self) -> Vec<PathBuf> {
        let Some(library) = &self.library_work.library else { return Vec::new() };
        self.library_work.panel.selected().map(|path| library.root().join(path)).collect()
    }

    /// Selects a card and brings it into sight; relative to the library's folder.
    pub(super) fn reveal_card(&mut self, path: PathBuf) {
        self.library_work.panel.reveal(path);
    }

    /// Whether files were edited last, and nothing else was done since.
    fn are_files_last(&self) -> bool {
        let here = (self.tabs.front_id(), self.history.labels().count());
        self.library_work.running.is_none() && self.library_work.last == Some(here) && !self.history.is_pending()
    }

    /// The edit of files that undo takes back, if it is its turn.
    pub(super) fn file_undo(&self) -> Option<&str> {
        self.library_work.done.last().filter(|_| self.are_files_last()).map(|step| step.title.as_str())
    }

    /// The edit of files that redo makes again, if it is its turn.
    pub(super) fn file_redo(&self) -> Option<&str> {
        self.library_work.undone.last().filter(|_| self.are_files_last()).map(|step| step.title.as_str())
    }

    /// Takes the last edit of files back if nothing was done since; whether it was so.
    pub(super) fn undo_files(&mut self, is_asked: bool, ctx: &Context) -> bool {
        let is_due = self.are_files_last() || (is_asked && self.library_work.running.is_none());
        let Some(step) = self.library_work.done.pop_if(|_| is_due) else { return false };
        let edit = step.reversed();
        self.edit_files(Step::Undo, move || Planned { edit, refused: Vec::new() }, ctx);
        true
    }

    /// The same for making it again.
    pub(super) fn redo_files(&mut self, is_asked: bool, ctx: &Context) -> bool {
        let is_due = self.are_files_last() || (is_asked && self.library_work.running.is_none());
        let Some(edit) = self.library_work.undone.pop_if(|_| is_due) else { return false };
        self.edit_files(Step::Redo, move || Planned { edit, refused: Vec::new() }, ctx);
        true
    }

    /// The last edit of files in the list of steps, with what takes it back or makes it again; nothing where there is none.
    pub(super) fn file_steps(&mut self, ui: &mut Ui) {
        let title = |step: Option<&BatchEdit>| step.map(|step| step.title.clone());
        let (done, undone) = (title(self.library_work.done.last()), title(self.library_work.undone.last()));
        for (title, text, action) in [(done, "Undo", LibraryAction::Undo), (undone, "Redo", LibraryAction::Redo)] {
            let Some(title) = title else { continue };
            ui.horizontal(|ui| {
                if ui.small_button(text).accessible_name(format!("{text} in the library: {title}")).clicked() {
                    let ctx = ui.ctx().clone();
                    self.do_in_library(action, &ctx);
                }
                ui.add(egui::Label::new(egui::RichText::new(format!("Library: {title}")).small()).truncate());
            });
        }
    }

    /// The panel.
    pub(super) fn library_pane(&mut self, ui: &mut Ui) {
        let ctx = ui.ctx().clone();
        let path = self.editor.document.path().map(Path::to_path_buf);
        let around = Around {
            current: path.as_deref(),
            undo: self.library_work.done.last().map(|step| step.title.as_str()),
            redo: self.library_work.undone.last().map(|step| step.title.as_str()),
        };
        if let Some(action) = self.library_work.panel.show(ui, self.library_work.library.as_mut(), &around) {
            self.do_in_library(action, &ctx);
        }
    }

    /// Does what the panel asks for.
    pub fn do_in_library(&mut self, action: LibraryAction, ctx: &Context) {
        if action == LibraryAction::ChooseFolder {
            return self.ask(Purpose::OpenLibrary, ctx);
        }
        let Some(library) = &mut self.library_work.library else { return };
        let root = library.root().to_path_buf();
        let whole = |paths: Vec<PathBuf>| paths.into_iter().map(|path| root.join(path)).collect::<Vec<_>>();
        match action {
            LibraryAction::ChooseFolder => {}
            LibraryAction::Open(paths) => {
                for path in paths {
                    library.change_marks(|marks| marks.opened(&path));
                    self.loader.start(Job::Material(root.join(path)), ctx);
                }
            }
            LibraryAction::Apply(path) => self.apply_file(&root.join(path), ctx),
            LibraryAction::Compare(path) => self.loader.start(Job::Compare(self.tabs.front_id(), root.join(path)), ctx),
            LibraryAction::Diff(paths) => match whole(paths).as_slice() {
                [a, b] => self.compare_sources(Source::File(a.clone()), Source::File(b.clone())),
                [one] => self.compare_sources(Source::File(one.clone()), Source::Front),
                _ => {}
            },
            LibraryAction::Edit(paths) => {
                self.library_work.batch = BatchPage::new(whole(paths));
                self.pages.open(Page::BatchEdit);
            }
            LibraryAction::Rename(path) => {
                let name = library.entries().iter().find(|entry| entry.path == path).map(|entry| entry.name.clone());
                self.library_work.renamed = Some((root.join(path), name.unwrap_or_default()));
                self.pages.open(Page::Rename);
            }
            LibraryAction::Duplicate(paths) => {
                let paths = whole(paths);
                self.edit_files(Step::New, move || edit::duplicate(&paths), ctx);
            }
            LibraryAction::Favour(paths, is_favourite) => {
                library.change_marks(|marks| paths.iter().for_each(|path| marks.set_favourite(path, is_favourite)));
                self.library_work.panel.refresh();
            }
            LibraryAction::Rescan => library.rescan(),
            LibraryAction::NewFromMeasured => self.open_measured(),
            LibraryAction::Undo => _ = self.undo_files(true, ctx),
            LibraryAction::Redo => _ = self.redo_files(true, ctx),
        }
    }

    /// Puts a file's material in the place of the document in front, as one step.
    pub fn apply_file(&mut self, path: &Path, ctx: &Context) {
        self.loader.start(Job::Apply(self.tabs.front_id(), path.to_path_buf()), ctx);
    }

    /// The page that edits many files; whether it stays open.
    pub(super) fn batch_page(&mut self, ui: &mut Ui) -> bool {
        let Some(changes) = self.library_work.batch.show(ui) else { return true };
        let paths = self.library_work.batch.paths.clone();
        let ctx = ui.ctx().clone();
        self.edit_files(Step::New, move || edit::change(&paths, &changes), &ctx);
        false
    }

    /// The page that names a file anew; whether it stays open.
    pub(super) fn rename_page(&mut self, ui: &mut Ui) -> bool {
        let Some((path, name)) = &mut self.library_work.renamed else { return false };
        ui.label("The material and its file get this name; undo brings back the old one.");
        let field = ui.add(egui::TextEdit::singleline(name).desired_width(f32::INFINITY)).accessible_name("New name");
        let is_entered = field.lost_focus() && ui.input(|i| i.key_pressed(egui::Key::Enter));
        if !field.has_focus() && !is_entered {
            field.request_focus();
        }
        if !(ui.button("Rename").clicked() || is_entered) {
            return true;
        }
        let (path, name) = (path.clone(), name.clone());
        let ctx = ui.ctx().clone();
        self.edit_files(Step::New, move || edit::rename(&path, &name), &ctx);
        false
    }

    /// Opens the page with measured materials.
    pub(super) fn open_measured(&mut self) {
        self.library_work.measured.begin();
        self.pages.open(Page::Measured);
    }

    /// The page with measured materials; whether it stays open.
    pub(super) fn measured_page(&mut self, ui: &mut Ui) -> bool {
        let Some(row) = self.library_work.measured.show(ui) else { return true };
        self.new_from_measured(row, &ui.ctx().clone());
        false
    }

    /// A new material from a measurement: a file in the library, or a document where none is open.
    pub fn new_from_measured(&mut self, row: &'static Measured, ctx: &Context) {
        let text = row.file_text();
        match self.library_work.library.as_ref().map(|library| library.root().to_path_buf()) {
            Some(root) => {
                let name = row.name.replace(['/', '\\', ':', '*', '?', '"', '<', '>', '|'], "-");
                self.edit_files(Step::New, move || edit::create(&root, &name, text), ctx);
            }
            None => match MaterialFile::parse(&text) {
                Ok((file, _)) => self.open_new(file),
                Err(error) => self.messages.error(format!("{}: {error}", row.name)),
            },
        }
    }
}

/// Whether a folder holds materials, itself or in a folder of its own.
pub(super) fn holds_materials(folder: &Path) -> bool {
    /// Entries that are looked at: dropping is answered at once.
    const MAX: usize = 2000;
    let entries = |folder: &Path| std::fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path()).take(MAX);
    entries(folder).any(|path| {
        files::is_material_path(&path) || (path.is_dir() && entries(&path).take(200).any(|path| files::is_material_path(&path)))
    })
}
