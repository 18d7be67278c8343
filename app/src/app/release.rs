//! What became of the open library since an earlier release: compared on a thread, shown in the pane of the check.

use super::App;
use super::checking::{has_ending, written};
use crate::background::Background;
use crate::dialogs::Purpose;
use crate::dock::Pane;
use crate::library::check::Options;
use crate::library::check::against::{Against, compare};
use crate::library::check::report::{markdown, text_against};
use crate::library::scan::Progress;
use crate::library::snapshot::Snapshot;
use crate::panels::release::{ReleaseAction, ReleasePanel, ReleaseView};
use crate::sources::Source;
use egui::{Context, Ui};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Share of a comparison that reading the release takes.
const READING: f32 = 0.3;

/// The comparison with a release.
#[derive(Default)]
pub(super) struct Release {
    panel: ReleasePanel,
    pub is_shown: bool,
    pub renders_looks: bool,
    pub folder: Option<PathBuf>,
    /// Of which library, of what moment and how it was compared last.
    asked: Option<(PathBuf, u64, bool)>,
    pub running: Background<Result<Option<Against>, String>>,
    pub against: Option<Arc<Against>>,
    pub note: Option<String>,
}

impl App {
    /// What became of the library since the release, for tests.
    pub fn against(&self) -> Option<&Against> {
        self.check.release.against.as_deref().filter(|_| !self.check.release.running.is_running())
    }

    /// Gives up the comparison with a release.
    pub(super) fn end_release(&mut self) {
        if self.check.release.running.cancel() {
            self.check.release.note = Some("Comparing was ended before it was done.".to_owned());
        }
    }

    /// Compares where that was not done yet.
    pub(super) fn compare_again(&mut self, ctx: &Context) {
        let Some(library) = self.library().filter(|library| library.progress().is_none()) else { return };
        let (Some(folder), Some(snapshot)) = (self.check.release.folder.clone(), library.snapshot()) else { return };
        let asked = (folder.clone(), library.revision(), self.check.release.renders_looks);
        if self.check.release.asked.as_ref() == Some(&asked) {
            return;
        }
        if self.check.release.asked.as_ref().is_none_or(|(known, ..)| *known != folder) {
            self.check.release.against = None;
        }
        let options = Options { threads: self.threads(), renders_looks: asked.2, probes_stability: false };
        let places = self.keeping.places().clone();
        self.check.release.note = None;
        self.check.release.asked = Some(asked);
        self.check.release.running.start("Comparing with the release", ctx, move |control| {
            let is_cancelled = || control.is_cancelled();
            let share = |now: Progress| now.done as f32 / now.total.max(1) as f32;
            let reading = |now| control.tell(READING * share(now));
            let old = Snapshot::read(&folder, &places, snapshot.setup, options.threads, &reading, &is_cancelled);
            let Some(old) = old.map_err(|error| error.to_string())? else { return Ok(None) };
            if old.entries.is_empty() {
                return Err(format!("{}: expected .asm.ron files in this folder, found none", folder.display()));
            }
            let tell = |now| control.tell(READING + (1.0 - READING) * share(now));
            Ok(compare(&old.shelved(), &snapshot.shelved(), &options, &tell, &is_cancelled))
        });
    }

    /// What the pane of the check shows in place of findings.
    pub(super) fn release_view(&mut self, ui: &mut Ui) {
        let ctx = ui.ctx().clone();
        let release = &mut self.check.release;
        let view = ReleaseView {
            folder: release.folder.as_deref(),
            against: release.against.as_ref(),
            share: release.running.share(),
            renders_looks: release.renders_looks,
            note: release.note.as_deref(),
        };
        if let Some(action) = release.panel.show(ui, &view) {
            self.do_with_release(action, &ctx);
        }
    }

    /// Shows what became of the library since a release; asks for its folder where none is chosen.
    pub(super) fn show_release(&mut self, ctx: &Context) {
        self.show_pane(Pane::Validation);
        self.check.release.is_shown = true;
        if self.check.release.folder.is_none() {
            self.ask(Purpose::CompareRelease, ctx);
        }
    }

    /// Whether a file belongs to the release that the library is compared with.
    pub(super) fn is_released(&self, path: &Path) -> bool {
        self.check.release.folder.as_ref().is_some_and(|folder| path.starts_with(folder))
    }

    /// Compares with the release in a folder from now on.
    pub(super) fn set_release(&mut self, folder: PathBuf) {
        let release = &mut self.check.release;
        (release.folder, release.asked, release.against, release.is_shown) = (Some(folder), None, None, true);
    }

    fn do_with_release(&mut self, action: ReleaseAction, ctx: &Context) {
        let release = &mut self.check.release;
        match action {
            ReleaseAction::Findings => release.is_shown = false,
            ReleaseAction::Folder(folder) => self.set_release(folder),
            ReleaseAction::Choose => self.ask(Purpose::CompareRelease, ctx),
            ReleaseAction::Again => release.asked = None,
            ReleaseAction::End => self.end_release(),
            ReleaseAction::Render(renders) => release.renders_looks = renders,
            ReleaseAction::Save => self.ask(Purpose::SaveNotes, ctx),
            ReleaseAction::Copy => {
                if let (Some(against), Some(folder)) = (&release.against, &release.folder) {
                    ctx.copy_text(markdown(against, folder));
                    self.messages.info("The notes can be pasted.");
                }
            }
            ReleaseAction::Diff(path) => {
                if let (Some(folder), Some(root)) = (release.folder.clone(), self.library().map(|l| l.root().to_path_buf())) {
                    self.compare_sources(Source::File(folder.join(&path)), Source::File(root.join(path)));
                }
            }
            ReleaseAction::Show(path) => {
                if let Some(root) = self.library().map(|library| library.root().to_path_buf()) {
                    self.show_card(&root.join(path));
                }
            }
        }
    }

    /// Writes what became of the library: as Markdown where the name says so, else as the text of the command line.
    pub(super) fn save_notes(&mut self, path: PathBuf, ctx: &Context) {
        let release = &self.check.release;
        let (Some(against), Some(folder)) = (release.against.clone(), release.folder.clone()) else { return };
        self.check.writing.start("Writing the notes", ctx, move |_| {
            let is_markdown = has_ending(&path, "md");
            let text = if is_markdown { markdown(&against, &folder) } else { text_against(&against) };
            written(&path, &text)
        });
    }
}
