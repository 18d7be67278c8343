//! Pictures and turntables of what the window shows: from the settings of the panel to a thread, or to the queue before it.

use super::App;
use crate::background::Background;
use crate::dialogs::Purpose;
use crate::dock::Pane;
use crate::export::Format;
use crate::files::texture_path;
use crate::live_export::{LiveExport, Row, Task, Unwritten, Waiting, begun};
use crate::live_final::{LiveFinal, SEED};
use crate::offline::loaded_scene::{LoadedScene, Origin};
use crate::offline::picture::{Order, View};
use crate::offline::picture_options::PictureOptions;
use crate::offline::turntable::{Begun, KEEP_GIB, TurntableOrder};
use crate::panels::export::{Around, ExportAction, ExportPanel, Kind, Queued};
use crate::panels::hold;
use crate::picture_job::Stop;
use crate::work::{Ends, Work};
use burnish_renderer::path::StopRules;
use egui::{Context, Ui};
use std::path::PathBuf;

/// The panel, what is being made, and what waits for an answer.
#[derive(Default)]
pub(super) struct Exporting {
    pub panel: ExportPanel,
    pub live: LiveExport,
    /// The turntable that is being made or predicted, or was last.
    pub table: Table,
    /// Whether a folder that was chosen has a turntable that was begun before.
    pub looking: Background<Option<(Begun, Vec<Row>)>>,
    /// What goes on once the folder is chosen.
    pub after_folder: Option<ExportAction>,
    /// Whether closing the window waits for an answer.
    pub is_asking: bool,
    /// A picture that could not be written where it should be.
    pub unwritten: Option<Unwritten>,
}

/// A turntable as it is made; the panel may be set to another one meanwhile.
#[derive(Default)]
pub(super) struct Table {
    pub folder: PathBuf,
    /// What ends a frame.
    pub rules: StopRules,
    pub rows: Vec<Row>,
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
        let waiting = self.live.waiting().len();
        let text = if waiting > 0 { format!("{text}; {waiting} more in the queue") } else { text };
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

    /// Whether a picture or a turntable is being made, or will be without anybody doing anything.
    pub fn is_exporting(&self) -> bool {
        let Exporting { live, looking, unwritten, .. } = &self.exporting;
        live.now().is_some() || looking.is_running() || (live.waiting().len() > 0 && unwritten.is_none())
    }

    pub(super) fn export_pane(&mut self, ui: &mut Ui) {
        let (width, height) = self.picture_size;
        let queued = |waiting: &Waiting| {
            let (number, text, target) = (waiting.number, waiting.text(), waiting.target().to_path_buf());
            Queued { number, text, target }
        };
        let around = Around {
            view_size: [width.max(1), height.max(1)],
            display: &mut self.editor.view.display,
            has_preview: self.preview.problem().is_none(),
            work: self.exporting.work(),
            is_ending: self.exporting.live.is_ending(),
            queue: self.exporting.live.waiting().map(queued).collect(),
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
                match self.turntable_order() {
                    Some(order) if action == ExportAction::Start => self.queue_export(Task::Turntable(order), ctx),
                    Some(order) => self.start_export(Task::Predict(order), ctx),
                    None => {}
                }
            }
            ExportAction::WriteElsewhere => {
                let format = panel.format;
                self.ask(Purpose::WriteElsewhere(format), ctx);
            }
            ExportAction::Discard => {
                self.drop_unwritten();
                self.go_on_exporting(ctx);
            }
            ExportAction::Cancel => self.end_work(Ends::Export, ctx),
            ExportAction::Remove(number) => self.exporting.live.remove(number),
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
            self.queue_export(Task::Picture(order, view, path), ctx);
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
        self.exporting.looking.start("Looking into the folder", ctx, move |_| begun(&folder));
    }

    /// Makes this once what is before it is done, which is at once where there is nothing.
    fn queue_export(&mut self, task: Task, ctx: &Context) {
        let text = task.text();
        if let Err(problem) = self.exporting.live.queue(task) {
            return self.messages.error(problem);
        }
        self.go_on_exporting(ctx);
        let waiting = self.exporting.live.waiting().len();
        if waiting > 0 {
            self.messages.info(format!("Queued {text}, number {waiting} of what waits."));
        }
    }

    /// Begins with what waits first. Not before it is said what becomes of a picture that could not be written: the next may not be either.
    pub(super) fn go_on_exporting(&mut self, ctx: &Context) {
        if self.exporting.unwritten.is_none()
            && let Some(task) = self.exporting.live.take_next()
        {
            self.start_export(task, ctx);
        }
    }

    fn start_export(&mut self, task: Task, ctx: &Context) {
        let is_heavy = task.is_heavy();
        let table = match &task {
            Task::Predict(order) | Task::Turntable(order) => {
                Some(Table { folder: order.out.clone(), rules: order.frame.rules(), rows: Vec::new() })
            }
            Task::Picture(..) | Task::Write(..) => None,
        };
        match self.exporting.live.start(task, ctx) {
            Ok(()) => {
                self.exporting.table = table.unwrap_or_default();
                // Both would take twice as long, and a time limit would mean half of the samples.
                self.final_view.iter_mut().filter(|_| is_heavy).for_each(LiveFinal::hold);
            }
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
