//! Pictures and turntables of what the window shows: from the settings of the panel to a thread, and what comes back.

use super::App;
use super::pages::{Answer, question};
use crate::dialogs::Purpose;
use crate::dock::Pane;
use crate::export::Format;
use crate::files::texture_path;
use crate::live_export::{LiveExport, News, Task, Unwritten};
use crate::live_final::{LiveFinal, SEED};
use crate::offline::OfflineError;
use crate::offline::loaded_scene::{LoadedScene, Origin};
use crate::offline::picture::{Order, View};
use crate::offline::picture_options::PictureOptions;
use crate::offline::turntable::{KEEP_GIB, TurntableOrder};
use crate::panels::export::turntable::percent;
use crate::panels::export::{Around, ExportAction, ExportPanel, Kind};
use crate::panels::hold;
use crate::picture_job::Stop;
use crate::work::{Ends, Work};
use burnish_renderer::path::StopRules;
use egui::{Context, Ui};
use std::path::PathBuf;
use std::time::Duration;

/// The panel, what is being made, and what waits for an answer.
#[derive(Default)]
pub(super) struct Exporting {
    pub panel: ExportPanel,
    pub live: LiveExport,
    /// What goes on once the folder is chosen.
    after_folder: Option<ExportAction>,
    /// Whether closing the window waits for an answer.
    is_asking: bool,
    /// A picture that could not be written where it should be.
    unwritten: Option<Unwritten>,
}

impl Exporting {
    /// No folder was chosen.
    pub fn forget_answer(&mut self) {
        self.after_folder = None;
    }

    /// What is being made, for the list of work.
    pub fn work(&self) -> Option<Work> {
        let (title, step) = self.live.now()?;
        let text = step.text();
        let title = if self.live.is_ending() { format!("Ending: {}", title.to_lowercase()) } else { title.to_owned() };
        let text = if text.is_empty() { title } else { format!("{title}: {text}") };
        Some(Work { text, progress: step.share.map(|share| share as f32), remaining: step.remaining, ends: Some(Ends::Export) })
    }
}

impl App {
    /// The panel with the settings of pictures and turntables.
    pub fn export_panel(&self) -> &ExportPanel {
        &self.exporting.panel
    }

    /// The same, to be changed: for tests.
    pub fn export_panel_mut(&mut self) -> &mut ExportPanel {
        &mut self.exporting.panel
    }

    /// What is being made, as the list of work shows it.
    pub fn export_work(&self) -> Option<Work> {
        self.exporting.work()
    }

    /// Whether a picture or a turntable is being made.
    pub fn is_exporting(&self) -> bool {
        self.exporting.live.now().is_some()
    }

    pub(super) fn export_pane(&mut self, ui: &mut Ui) {
        let (width, height) = self.picture_size;
        let around = Around {
            view_size: [width.max(1), height.max(1)],
            display: &mut self.editor.view.display,
            has_preview: self.preview.problem().is_none(),
            work: self.exporting.work(),
            is_ending: self.exporting.live.is_ending(),
        };
        let panel = &mut self.exporting.panel;
        if let Some(action) = hold(ui, |ui| panel.show(ui, around)) {
            let ctx = ui.ctx().clone();
            self.export(action, &ctx);
        }
    }

    /// Does what the panel, or a command, asks for.
    pub(super) fn export(&mut self, action: ExportAction, ctx: &Context) {
        let panel = &mut self.exporting.panel;
        match action {
            ExportAction::Render => {
                panel.kind = Kind::Picture;
                let format = panel.format;
                self.ask(Purpose::RenderPicture(format), ctx);
            }
            ExportAction::ChooseFolder => self.ask(Purpose::TurntableFolder, ctx),
            ExportAction::Predict | ExportAction::Start if panel.folder.is_none() => {
                self.exporting.after_folder = Some(action);
                self.ask(Purpose::TurntableFolder, ctx);
            }
            ExportAction::Predict | ExportAction::Start => {
                panel.kind = Kind::Turntable;
                if let Some(order) = self.turntable_order() {
                    let is_start = action == ExportAction::Start;
                    self.start_export(if is_start { Task::Turntable(order) } else { Task::Predict(order) }, ctx);
                }
            }
            ExportAction::WriteElsewhere => {
                let format = panel.format;
                self.ask(Purpose::WriteElsewhere(format), ctx);
            }
            ExportAction::Discard => self.drop_unwritten(),
            ExportAction::Cancel => self.end_work(Ends::Export, ctx),
        }
    }

    /// A file was chosen for a picture.
    pub(super) fn render_picture(&mut self, path: PathBuf, ctx: &Context) {
        let panel = &self.exporting.panel;
        let (stop, view, seconds) = (panel.stop, panel.view, panel.preview_seconds);
        if let Some(mut order) = self.order(stop) {
            if view == View::Preview {
                // What is set for the final view stays set, and has no meaning here.
                let PictureOptions { display_transform, bits, half, .. } = order.options;
                order.options = PictureOptions { display_transform, bits, half, ..PictureOptions::default() };
                order.stop = Stop { seconds, ..Stop::default() };
            }
            self.start_export(Task::Picture(order, view, path), ctx);
        }
    }

    /// A file was chosen for a picture that could not be written.
    pub(super) fn write_elsewhere(&mut self, path: PathBuf, ctx: &Context) {
        if self.can_render()
            && let Some(unwritten) = self.exporting.unwritten.take()
        {
            self.exporting.panel.has_unwritten = false;
            self.start_export(Task::Write(unwritten, path), ctx);
        }
    }

    fn drop_unwritten(&mut self) {
        self.exporting.unwritten = None;
        self.exporting.panel.has_unwritten = false;
    }

    /// A folder was chosen for the turntable.
    pub(super) fn turntable_folder(&mut self, folder: PathBuf, ctx: &Context) {
        let panel = &mut self.exporting.panel;
        if panel.folder.as_ref() != Some(&folder) {
            (panel.prediction, panel.rows) = (None, Vec::new());
        }
        panel.folder = Some(folder.clone());
        if self.can_render() {
            self.start_export(Task::Look(folder), ctx);
        } else {
            self.exporting.forget_answer();
        }
    }

    fn start_export(&mut self, task: Task, ctx: &Context) {
        let is_heavy = task.is_heavy();
        match self.exporting.live.start(task, ctx) {
            // Both would take twice as long, and a time limit would mean half of the samples.
            Ok(()) if is_heavy => self.final_view.iter_mut().for_each(LiveFinal::hold),
            Ok(()) => {}
            Err(problem) => self.messages.error(problem),
        }
    }

    fn turntable_order(&mut self) -> Option<TurntableOrder> {
        let frame = self.order(self.exporting.panel.frame_stop)?;
        let ExportPanel { folder, frames, turn, degrees, format, .. } = &self.exporting.panel;
        Some(TurntableOrder {
            frame,
            out: folder.clone()?,
            frames: *frames,
            turn: *turn,
            degrees: *degrees,
            shard: None,
            format: *format,
            keep_gib: KEEP_GIB,
        })
    }

    /// What the window shows, as large as the panel says; `None`, with a message, while a part of it is being loaded.
    fn order(&mut self, stop: StopRules) -> Option<Order> {
        let (panel, editor, view) = (&self.exporting.panel, &self.editor, &self.editor.view);
        let [width, height] = panel.size([self.picture_size.0.max(1), self.picture_size.1.max(1)]);
        let Some(scene) = editor.scene(width as f32 / height as f32) else {
            self.messages.error("Not rendered: the scene is still being loaded.");
            return None;
        };
        let document = &editor.document;
        let file_of = |name: &String| Some((name.clone(), texture_path(name, document.folder())?));
        let [mesh, environment] = editor.places.clone();
        let origin = Origin {
            mesh,
            backdrop: editor.backdrop(),
            environment,
            replaces_material: true,
            unit_mm: editor.model.as_ref().map(|model| model.unit_mm),
            file: Some(document.file_shared()),
            texture_files: document.textures.keys().filter_map(file_of).collect(),
            ..Origin::default()
        };
        let mut options = panel.options.clone();
        options.display_transform = view.display.transform;
        let threads = || std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
        Some(Order {
            loaded: LoadedScene { scene, width, height, origin },
            options,
            exposure_ev: view.display.exposure_ev,
            seed: SEED,
            threads: self.preferences.threads.unwrap_or_else(threads),
            stop: Stop { spp: stop.spp, seconds: stop.seconds, relmse: stop.relmse },
        })
    }

    /// Whether the window stays open until it is said what becomes of a rendering.
    pub(super) fn asks_to_end_rendering(&mut self) -> bool {
        self.exporting.is_asking = !self.can_render() && !self.exporting.live.is_ending();
        self.exporting.is_asking
    }

    /// Asks before closing whether a rendering is to end.
    pub(super) fn ask_about_rendering(&mut self, ctx: &Context) {
        self.exporting.is_asking &= !self.can_render();
        if !self.exporting.is_asking {
            return;
        }
        let answers = [("End it and quit", "A turntable goes on from there another day"), ("Go on rendering", "")];
        let answer = question(ctx, "Still rendering", &answers, |ui| {
            ui.label("A picture or turntable is being rendered.");
        });
        match answer {
            Answer::Waiting => return,
            Answer::Chosen(0) => {
                self.end_work(Ends::Export, ctx);
                self.close_window(ctx);
            }
            Answer::Chosen(_) | Answer::None => {}
        }
        self.exporting.is_asking = false;
    }

    /// Takes what was made in the background.
    pub(super) fn collect_exports(&mut self, ctx: &Context) {
        if self.can_render() && self.final_view.as_ref().is_some_and(LiveFinal::is_held) {
            // Everything is told to it again.
            self.sent = None;
        }
        if !self.can_render() {
            // The thread may know only a window that was opened anew since.
            ctx.request_repaint_after(Duration::from_millis(250));
        }
        let mut after = None;
        for news in self.exporting.live.collect() {
            let panel = &mut self.exporting.panel;
            match news {
                News::Warning(sentence) => self.messages.warning(sentence),
                News::Rows(rows) => panel.rows = rows,
                News::Row(place, row) => {
                    if let Some(old) = panel.rows.get_mut(place) {
                        *old = row;
                    }
                }
                News::Begun(begun, rows) => {
                    if let Some(begun) = begun {
                        self.messages.info(format!("The folder has a turntable of {} frames, which can go on.", begun.frames));
                        (panel.frames, panel.turn, panel.degrees) = (begun.frames, begun.turn, begun.degrees);
                        (panel.format, panel.size, panel.options) = (begun.format, Some(begun.size), begun.options);
                        panel.rows = rows;
                    }
                    // What asked for the folder goes on.
                    after = self.exporting.after_folder.take();
                }
                News::Wrote(files, text) => {
                    let names: Vec<String> = files.iter().map(|path| path.display().to_string()).collect();
                    self.messages.info(format!("Wrote {}: {text}", names.join(", ")));
                    panel.last = files.into_iter().next().map(|path| (path, text));
                }
                News::Predicted(Some(prediction), due) => {
                    self.messages.info(prediction.text(due));
                    panel.prediction = Some((prediction, due));
                }
                News::Predicted(None, _) => self.messages.info("All frames are finished: there is nothing to predict."),
                News::Ended(done, all) => {
                    panel.prediction = None;
                    let (limited, _) = panel.due();
                    let goal = panel.frame_stop.relmse.map_or_else(String::new, |relmse| format!(" to {}", percent(relmse)));
                    let more = match (done == all, limited) {
                        (true, _) => String::new(),
                        (false, 0) => "; starting again goes on from there".to_owned(),
                        (false, limited) => format!("; {limited} hit their time limit and can be resumed{goal}"),
                    };
                    let folder = panel.folder.as_ref().map_or_else(String::new, |folder| folder.display().to_string());
                    self.messages.info(format!("Turntable in {folder}: {done} of {all} frames are finished{more}."));
                }
                News::Unwritten(unwritten, error) => {
                    self.messages
                        .error(format!("Not written: {error}. The picture is kept; the Export panel writes it elsewhere."));
                    panel.has_unwritten = true;
                    self.exporting.unwritten = Some(unwritten);
                }
                News::Failed(OfflineError::Cancelled) => self.messages.info("Rendering was ended; nothing was written."),
                News::Failed(error) => self.messages.error(format!("Not rendered: {error}")),
            }
        }
        if let Some(action) = after {
            self.export(action, ctx);
        }
    }

    /// Whether nothing is being made, so that something can begin.
    pub(super) fn can_render(&self) -> bool {
        self.exporting.live.now().is_none()
    }

    /// Shows the panel with what a command began.
    pub(super) fn show_export(&mut self, kind: Kind) {
        self.exporting.panel.kind = kind;
        self.editor.view.are_panels_shown = true;
        if !self.dock.is_drawn(Pane::Export) {
            self.dock.set_shown(Pane::Export, true);
        }
    }
}

/// The name of a picture with the ending of its format.
pub(super) fn with_ending(path: PathBuf, format: Format) -> PathBuf {
    if Format::of(&path) == Some(format) { path } else { PathBuf::from(format!("{}.{}", path.display(), format.ending())) }
}
