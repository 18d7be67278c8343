//! The check of the open library or document, and its comparison with an earlier release: run on threads, shown in one pane.

use super::App;
use super::release::Release;
use crate::background::Background;
use crate::dialogs::Purpose;
use crate::dock::Pane;
use crate::editor::Document;
use crate::files;
use crate::library::check::report::{Timing, command_line, json_library, text};
use crate::library::check::{Checked, Known, Options, check_library_again, check_text};
use crate::panels::library::LibraryAction;
use crate::panels::validation::{ValidationAction, ValidationPanel, ValidationView, search_words};
use crate::sources::Source;
use burnish_material::Property;
use egui::{Context, Ui};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

/// What is checked.
enum Subject {
    /// A library as of a revision, in this way.
    Library(PathBuf, u64, Options),
    /// A document as it is.
    Document(Box<Document>),
}

impl Subject {
    fn is_same(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Library(a, n, x), Self::Library(b, m, y)) => (a, n, x) == (b, m, y),
            (Self::Document(a), Self::Document(b)) => a.is_same(b),
            _ => false,
        }
    }

    /// Whether it is the same library, of another moment perhaps.
    fn is_later(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Library(a, _, x), Self::Library(b, _, y)) => (a, x) == (b, y),
            (Self::Document(a), Self::Document(b)) => a.shares_origin(b),
            _ => false,
        }
    }
}

/// What was found, what its rows are found by, and how many seconds that took.
type Answer = Option<(Checked, Vec<String>, f64)>;

/// The check, the comparison, and their panels.
#[derive(Default)]
pub(super) struct CheckWork {
    panel: ValidationPanel,
    options: Options,
    /// What was checked last, or is being checked.
    asked: Option<Subject>,
    running: Background<Answer>,
    known: Arc<Mutex<Known>>,
    checked: Option<Arc<Checked>>,
    words: Vec<String>,
    timing: Timing,
    note: Option<&'static str>,
    pub(super) release: Release,
    /// A property to bring into sight once its file is in front.
    sought: Option<(PathBuf, Property)>,
    pub(super) writing: Background<Result<String, String>>,
}

impl App {
    /// What the check found, for tests.
    pub fn checked(&self) -> Option<&Checked> {
        self.check.checked.as_deref().filter(|_| !self.check.running.is_running())
    }

    /// The check and the comparison for the list of all work.
    pub(super) fn check_work(&self) -> impl Iterator<Item = crate::work::Work> {
        use crate::work::Ends;
        [self.check.running.work(Ends::Check), self.check.release.running.work(Ends::Release)].into_iter().flatten()
    }

    /// Gives up the check.
    pub(super) fn end_check(&mut self) {
        if self.check.running.cancel() {
            self.check.note = Some("ended before it was done");
        }
    }

    /// Takes what was found, and begins anew where something has changed. Once per frame.
    pub(super) fn mind_the_check(&mut self, ctx: &Context) {
        if let Some(done) = self.check.running.poll() {
            match done {
                Ok(Some((checked, words, seconds))) => {
                    self.check.words = words;
                    self.check.checked = Some(Arc::new(checked));
                    self.check.timing = Timing { seconds, read_seconds: 0.0 };
                }
                Ok(None) => {}
                Err(problem) => self.messages.error(problem),
            }
        }
        match self.check.release.running.poll() {
            Some(Ok(Ok(against))) => self.check.release.against = against.map(Arc::new),
            Some(Ok(Err(problem)) | Err(problem)) => self.check.release.note = Some(problem),
            None => {}
        }
        match self.check.writing.poll() {
            Some(Ok(Ok(info))) => self.messages.info(info),
            Some(Ok(Err(problem)) | Err(problem)) => self.messages.error(problem),
            None => {}
        }
        let front = self.editor.document.path();
        if let Some((_, property)) = self.check.sought.take_if(|(path, _)| front == Some(path.as_path())) {
            self.properties.go_to(property);
        }
        if !self.dock.is_drawn(Pane::Validation) || !self.editor.view.are_panels_shown {
            return;
        }
        self.check_again(ctx);
        if self.check.release.is_shown {
            self.compare_again(ctx);
        }
    }

    /// What is to be checked now; `None` while that is not known yet.
    fn subject(&self, ctx: &Context) -> Option<Subject> {
        match self.library() {
            Some(library) => {
                let is_ready = library.progress().is_none() && library.setup().is_some();
                let of = || Subject::Library(library.root().to_path_buf(), library.revision(), self.check.options.clone());
                is_ready.then(of)
            }
            None => {
                let is_resting = !ctx.input(|i| i.pointer.any_down());
                is_resting.then(|| Subject::Document(Box::new(self.editor.document.clone())))
            }
        }
    }

    fn check_again(&mut self, ctx: &Context) {
        let Some(subject) = self.subject(ctx) else { return };
        let is_same = self.check.asked.as_ref().is_some_and(|asked| asked.is_same(&subject));
        let is_later = self.check.asked.as_ref().is_some_and(|asked| asked.is_later(&subject));
        if is_same || (is_later && self.check.running.is_running()) {
            return;
        }
        if !is_later {
            self.check.checked = None;
        }
        self.check.note = None;
        match &subject {
            Subject::Library(..) => {
                let Some(snapshot) = self.library().and_then(crate::library::Library::snapshot) else { return };
                let options = Options { threads: self.threads(), ..self.check.options.clone() };
                let known = self.check.known.clone();
                self.check.running.start("Checking the library", ctx, move |control| {
                    // An earlier check that was given up ends soon.
                    let mut known = known.lock().unwrap_or_else(PoisonError::into_inner);
                    let start = Instant::now();
                    let tell = |now: crate::library::scan::Progress| control.tell_count(now.done, now.total);
                    let is_cancelled = || control.is_cancelled();
                    let checked = check_library_again(&snapshot.shelved(), &options, &mut known, &tell, &is_cancelled)?;
                    let seconds = start.elapsed().as_secs_f64();
                    let words = search_words(&checked);
                    Some((checked, words, seconds))
                });
            }
            Subject::Document(document) => {
                let path = document.path().map_or_else(|| PathBuf::from(document.title()), Path::to_path_buf);
                let text = document.file().to_text(&document.material);
                self.check.running.start("Checking the material", ctx, move |_| {
                    let checked = check_text(&path, &text);
                    let words = search_words(&checked);
                    Some((checked, words, 0.0))
                });
            }
        }
        self.check.asked = Some(subject);
    }

    /// How many threads work that is not the final view may use.
    pub(super) fn threads(&self) -> usize {
        self.preferences.threads.unwrap_or_else(|| std::thread::available_parallelism().map_or(1, std::num::NonZero::get))
    }

    /// The pane.
    pub(super) fn validation_pane(&mut self, ui: &mut Ui) {
        let ctx = ui.ctx().clone();
        if self.check.release.is_shown && self.library().is_some() {
            return self.release_view(ui);
        }
        let root = self.library().map(|library| library.root().to_path_buf());
        let subject = match &root {
            Some(root) => root.file_name().unwrap_or(root.as_os_str()).to_string_lossy().into_owned(),
            None => self.editor.document.title(),
        };
        let against = self.check.release.against.as_ref().and(self.check.release.folder.as_deref());
        let renders_looks = self.check.options.renders_looks || (against.is_some() && self.check.release.renders_looks);
        let options = Options { renders_looks, ..self.check.options.clone() };
        let command = root.as_ref().map(|root| command_line(root, &options, against));
        let view = ValidationView {
            checked: self.check.checked.as_ref(),
            words: &self.check.words,
            subject: &subject,
            root: root.as_deref(),
            options: &self.check.options,
            share: self.check.running.share(),
            command: command.as_deref(),
            note: self.check.note,
        };
        if let Some(action) = self.check.panel.show(ui, &view) {
            self.do_with_findings(action, &ctx);
        }
    }

    fn do_with_findings(&mut self, action: ValidationAction, ctx: &Context) {
        match action {
            ValidationAction::Show(path, property) => {
                self.show_card(&path);
                let is_front = self.library().is_none() || self.editor.document.path() == Some(&path);
                if let Some(property) = property.filter(|_| is_front) {
                    self.properties.go_to(property);
                }
            }
            ValidationAction::Open(path, property) => {
                self.show_card(&path);
                self.open_at(path, property, ctx);
            }
            ValidationAction::Diff(a, b) => self.compare_sources(Source::File(a), Source::File(b)),
            ValidationAction::Unite(a, b) => self.unite(a, b, ctx),
            ValidationAction::Again => {
                self.check.known = Arc::default();
                self.check.asked = None;
            }
            ValidationAction::End => self.end_check(),
            ValidationAction::Set(options) => self.check.options = options,
            ValidationAction::Save => self.ask(Purpose::SaveReport, ctx),
            ValidationAction::Release => self.show_release(ctx),
        }
    }

    /// Marks the card of a file and brings it into sight.
    pub(super) fn show_card(&mut self, path: &Path) {
        let root = self.library().map(crate::library::Library::root);
        if let Some(below) = root.and_then(|root| path.strip_prefix(root).ok()).map(Path::to_path_buf) {
            self.reveal_card(below);
            self.show_pane(Pane::Folder);
        }
    }

    /// Opens a file, or brings its document to the front, with a property in sight.
    fn open_at(&mut self, path: PathBuf, property: Option<Property>, ctx: &Context) {
        let place = self.tabs.documents(&self.editor.document).position(|(_, document)| document.path() == Some(&path));
        match (place, self.library().and_then(|library| path.strip_prefix(library.root()).ok())) {
            (Some(place), _) => self.with_front(|tabs, front| tabs.bring_to_front(place, front)),
            (None, Some(below)) => self.do_in_library(LibraryAction::Open(vec![below.to_path_buf()]), ctx),
            (None, None) => {}
        }
        self.check.sought = property.map(|property| (path, property));
        if self.library().is_none()
            && let Some((_, property)) = self.check.sought.take()
        {
            self.properties.go_to(property);
        }
    }

    /// Writes the report: as JSON where the name says so, else as text.
    pub(super) fn save_report(&mut self, path: PathBuf, ctx: &Context) {
        let Some(checked) = self.check.checked.clone() else { return };
        let release = &self.check.release;
        let against = release.against.clone().zip(release.folder.clone());
        let timing = self.check.timing;
        self.check.writing.start("Writing the report", ctx, move |_| {
            let text = if has_ending(&path, "json") {
                let against = against.as_ref().map(|(against, folder)| (against.as_ref(), folder.as_path()));
                format!("{}\n", json_library(&checked, against, timing, &[]))
            } else {
                format!("{}\n", text(&checked, against.as_ref().map(|(against, _)| against.as_ref())))
            };
            written(&path, &text)
        });
    }
}

pub(super) fn has_ending(path: &Path, ending: &str) -> bool {
    path.extension().is_some_and(|found| found.eq_ignore_ascii_case(ending))
}

pub(super) fn written(path: &Path, text: &str) -> Result<String, String> {
    files::save_atomic(path, text.as_bytes()).map_err(|error| error.to_string()).map(|()| format!("Wrote {}", path.display()))
}
