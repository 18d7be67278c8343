//! The window: one frame, in order. What commands do is in `app/actions.rs`.

mod actions;
mod pictures;
mod rescue;
mod screenshot;
mod window;

pub use window::{WindowError, WindowOptions, run};

use crate::command::{Command, Menu};
use crate::dialogs::Dialogs;
use crate::editor::{Document, Editor, ViewMode};
use crate::history::History;
use crate::live_costs::LiveCosts;
use crate::live_difference::LiveDifference;
use crate::live_final::LiveFinal;
use crate::live_preview::LivePreview;
use crate::live_stability::LiveStability;
use crate::loading::{Job, Loader};
use crate::panels::messages::Messages;
use crate::panels::presets::PresetPanel;
use crate::panels::properties::PropertyPanel;
use crate::panels::status;
use crate::panels::viewport::{self, Wish};
use crate::panels::{hold, stability};
use crate::theme;
use crate::widgets::value_edit::RowAction;
use burnish_assets::{ENVIRONMENTS, Environment, SHAPES};
use burnish_material::LobeSet;
use burnish_renderer::path::{StopRules, unsupported};
use burnish_renderer::scene::ModelMeshes;
use egui::{CentralPanel, Frame, Margin, Panel, Ui};
use rescue::Rescue;
use screenshot::Screenshot;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

/// What waits for an answer about unsaved changes.
#[derive(Clone, Debug, PartialEq)]
enum After {
    New,
    AskOpen,
    Open(PathBuf),
    Close,
}

/// What both renderers were told last.
struct Sent {
    document: Document,
    model: Arc<ModelMeshes>,
    environment: Arc<Environment>,
    camera: burnish_renderer::scene::Camera,
    environment_deg: f32,
    /// Size of the final picture if one is wanted, and when it stops.
    final_request: Option<((usize, usize), StopRules)>,
}

/// The application.
pub struct App {
    editor: Editor,
    history: History,
    messages: Messages,
    presets: PresetPanel,
    properties: PropertyPanel,
    loader: Loader,
    dialogs: Box<dyn Dialogs>,
    preview: LivePreview,
    difference: LiveDifference,
    final_view: Option<LiveFinal>,
    stability: Option<LiveStability>,
    costs: LiveCosts,
    /// The window's device, if it has one.
    render_state: Option<egui_wgpu::RenderState>,
    /// What a window without its device leaves to the next.
    rescue: Rescue,
    /// When the device is to be given up, to see what comes of it.
    loses_device: Option<Instant>,
    sent: Option<Sent>,
    /// Size of one picture in pixels, from the last frame.
    picture_size: (usize, usize),
    /// When the user last did anything.
    last_input: Instant,
    /// What the question about unsaved changes is for.
    asking: Option<After>,
    /// What goes on once the document is saved.
    after_save: Option<After>,
    is_closing: bool,
    title: String,
    /// What the final view leaves out of this material, in sentences.
    left_out: Vec<String>,
    screenshot: Option<Screenshot>,
    written: std::sync::mpsc::Receiver<Result<String, String>>,
    writer: std::sync::mpsc::Sender<Result<String, String>>,
}

impl App {
    /// An application in this context, with the preview on its device if it has one.
    pub fn new(ctx: &egui::Context, render_state: Option<&egui_wgpu::RenderState>, dialogs: Box<dyn Dialogs>) -> Self {
        theme::apply(ctx);
        let preview = LivePreview::new(render_state);
        let mut editor = Editor::new();
        if preview.problem().is_some() {
            editor.view.mode = ViewMode::Final;
        }
        let history = History::new(&editor.document);
        let mut loader = Loader::default();
        if let Some(shape) = SHAPES.first() {
            loader.start(Job::Shape(shape.name), ctx);
        }
        if let Some(environment) = ENVIRONMENTS.first() {
            loader.start(Job::BuiltInEnvironment(environment.name), ctx);
        }
        let (writer, written) = std::sync::mpsc::channel();
        let mut messages = Messages::default();
        messages.info("Ready. Choose a preset, or drop a material, a mesh or an environment.");
        Self {
            editor,
            history,
            messages,
            presets: PresetPanel::default(),
            properties: PropertyPanel::default(),
            loader,
            dialogs,
            preview,
            difference: LiveDifference::default(),
            final_view: None,
            stability: None,
            costs: LiveCosts::default(),
            render_state: render_state.cloned(),
            rescue: Rescue::default(),
            loses_device: None,
            sent: None,
            picture_size: (0, 0),
            last_input: Instant::now(),
            asking: None,
            after_save: None,
            is_closing: false,
            title: String::new(),
            left_out: Vec::new(),
            screenshot: None,
            written,
            writer,
        }
    }

    /// The document and the view settings.
    pub fn editor(&self) -> &Editor {
        &self.editor
    }

    /// The same, for tests and for what opens the window.
    pub fn editor_mut(&mut self) -> &mut Editor {
        &mut self.editor
    }

    /// The steps made so far.
    pub fn history(&self) -> &History {
        &self.history
    }

    /// What the user was told.
    pub fn messages(&self) -> &Messages {
        &self.messages
    }

    /// Whether something is being loaded.
    pub fn is_loading(&self) -> bool {
        self.loader.is_busy()
    }

    /// The final view, once it was asked for.
    pub fn final_view(&self) -> Option<&LiveFinal> {
        self.final_view.as_ref()
    }

    /// Switches the final view's worker off, where only panels are of interest.
    pub fn without_final_view(mut self) -> Self {
        self.editor.view.mode = ViewMode::Preview;
        self
    }

    /// One frame.
    pub fn frame(&mut self, ui: &mut Ui) {
        let ctx = ui.ctx().clone();
        if ctx.input(|i| !i.raw.events.is_empty() || i.pointer.any_down()) {
            self.last_input = Instant::now();
        }
        if self.has_lost_device(&ctx) {
            return;
        }
        self.collect(&ctx);
        for command in Command::pressed(&ctx) {
            self.carry_out(command, &ctx);
        }
        self.panels(ui);
        self.ask_about_unsaved(&ctx);
        self.take_drops(&ctx);
        self.mind_the_window(&ctx);
        self.has_lost_device(&ctx);
        self.mind_the_screenshot(&ctx);
    }

    fn panels(&mut self, ui: &mut Ui) {
        let ctx = ui.ctx().clone();
        let bar = |margin| Frame::new().fill(theme::BAR).inner_margin(margin);
        Panel::top("menu").frame(bar(Margin::symmetric(6, 3))).show(ui, |ui| self.menu_bar(ui));
        Panel::bottom("status").exact_size(25.0).frame(bar(Margin::symmetric(9, 0))).show(ui, |ui| {
            status::show(ui, &self.status());
        });
        let side = Frame::new().fill(theme::PANEL).inner_margin(Margin { left: 9, right: 3, top: 4, bottom: 0 });
        if self.editor.view.are_panels_shown {
            let panel = Panel::left("presets").default_size(214.0).size_range(150.0..=320.0).frame(side);
            let name = self.editor.document.file().material().name.clone();
            if let Some(preset) = panel.show(ui, |ui| hold(ui, |ui| self.presets.show(ui, &name))).inner {
                self.load_preset(preset);
            }
            let panel = Panel::right("properties").default_size(398.0).size_range(340.0..=560.0).frame(side);
            let action = panel.show(ui, |ui| hold(ui, |ui| self.properties.show(ui, &mut self.editor.document))).inner;
            if let Some(RowAction::ChooseMap(property)) = action {
                self.ask_for_map(property, &ctx);
            }
        }
        Panel::top("toolbar").frame(bar(Margin::symmetric(8, 4))).show(ui, |ui| {
            match viewport::toolbar(ui, &mut self.editor, self.preview.problem().is_none()) {
                Some(Wish::Command(command)) => self.carry_out(command, &ctx),
                Some(Wish::Load(job)) => self.loader.start(job, &ctx),
                None => {}
            }
        });
        Panel::bottom("lobes").frame(bar(Margin::symmetric(8, 5))).show(ui, |ui| {
            self.lobe_strip(ui);
        });
        self.stability_panel(ui, &ctx);
        CentralPanel::no_frame().show(ui, |ui| {
            let (_, layout) = viewport::interact(ui, &mut self.editor);
            let scale = ctx.pixels_per_point();
            let size = (layout.picture_size() * scale).round();
            self.picture_size = ((size.x as usize).clamp(16, 8192), (size.y as usize).clamp(16, 8192));
            self.sync(&ctx);
            self.pictures(ui, layout);
            self.messages.show(ui, layout.all);
        });
    }

    fn lobe_strip(&mut self, ui: &mut Ui) {
        let material = &self.editor.document.material;
        let needed = LobeSet::of(material);
        let costs = self.costs.found(needed);
        if !status::lobe_strip(ui, material, &costs) {
            return;
        }
        let (width, height) = self.picture_size;
        match self.editor.scene(width.max(1) as f32 / height.max(1) as f32) {
            _ if costs.is_running => self.costs.cancel(),
            Some(scene) => self.costs.start(ui.ctx(), scene, needed, [width as u32, height as u32]),
            None => {}
        }
    }

    fn stability_panel(&mut self, ui: &mut Ui, ctx: &egui::Context) {
        if !self.editor.view.is_stability_shown {
            if let Some(stability) = &mut self.stability {
                stability.forget();
            }
            return;
        }
        let live = self.stability.get_or_insert_with(|| LiveStability::new(ctx.clone()));
        let document = &self.editor.document;
        let state = live.update(ctx, &document.material, &document.textures, || self.editor.scene(1.0));
        let frame = Frame::new().fill(theme::PANEL).inner_margin(Margin::symmetric(8, 5));
        let panel = Panel::bottom("stability").default_size(150.0).size_range(60.0..=400.0).frame(frame);
        if let Some(fix) = panel.show(ui, |ui| hold(ui, |ui| stability::show(ui, &state))).inner {
            self.apply_fix(&fix);
        }
    }

    /// The one place where edits leave the document: history, preview and final view are told, in this order.
    fn sync(&mut self, ctx: &egui::Context) {
        let wants_final = self.editor.view.mode.has_final();
        let aspect = self.picture_size.0 as f32 / self.picture_size.1 as f32;
        if let (Some(model), Some(environment)) = (self.editor.model.clone(), self.editor.environment.clone()) {
            let now = Sent {
                document: self.editor.document.clone(),
                model,
                environment,
                camera: self.editor.view.orbit.camera(aspect),
                environment_deg: self.editor.view.environment_deg,
                final_request: wants_final.then_some((self.picture_size, self.editor.view.stop)),
            };
            let (is_edited, is_changed, is_asked) = match &self.sent {
                Some(sent) => (
                    sent.document.material != now.document.material,
                    !now.is_same_scene(sent),
                    now.final_request != sent.final_request,
                ),
                None => (true, true, true),
            };
            if is_edited || is_changed || is_asked {
                if let Some(scene) = self.editor.scene(aspect).map(Arc::new) {
                    if is_edited {
                        self.history.feed(&self.editor.document);
                    }
                    if is_changed {
                        self.preview.set_scene(&scene);
                    }
                    if wants_final {
                        self.left_out = unsupported(&scene);
                        let view = self.final_view.get_or_insert_with(|| LiveFinal::new(ctx));
                        view.request(scene, self.picture_size, &self.editor.view);
                    }
                }
                if !wants_final && let Some(view) = &mut self.final_view {
                    view.pause();
                }
                self.sent = Some(now);
            }
        } else if self.history_differs() {
            // The first scene is still being made: nothing is drawn yet, but nothing is lost either.
            self.history.feed(&self.editor.document);
        }

        // A gesture ends when the mouse is up and no text is being typed.
        let is_resting = !ctx.input(|i| i.pointer.any_down()) && !ctx.text_edit_focused();
        if is_resting {
            self.history.settle();
        }
    }

    fn history_differs(&self) -> bool {
        !self.history.holds(&self.editor.document)
    }

    fn menu_bar(&mut self, ui: &mut Ui) {
        egui::MenuBar::new().ui(ui, |ui| {
            for (menu, title) in Menu::ALL {
                ui.menu_button(title, |ui| {
                    ui.set_min_width(230.0);
                    for command in Command::ALL.into_iter().filter(|command| command.menu() == menu) {
                        if command.starts_section() {
                            ui.separator();
                        }
                        self.menu_item(ui, command);
                    }
                    match menu {
                        Menu::Edit => {
                            ui.separator();
                            self.history_menu(ui);
                        }
                        Menu::View => {
                            ui.menu_button("Final view stops at", |ui| viewport::stop_rules(ui, &mut self.editor.view.stop));
                        }
                        Menu::File => {}
                    }
                });
            }
            let document = &self.editor.document;
            let place = document.path().map_or_else(|| "not saved yet".into(), |path| path.display().to_string());
            let mark = if document.is_modified() { " •" } else { "" };
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                let text = egui::RichText::new(format!("{}{mark}", document.title())).color(theme::TEXT);
                ui.add(egui::Label::new(text).truncate().selectable(false)).on_hover_text(place);
            });
        });
    }

    fn menu_item(&mut self, ui: &mut Ui, command: Command) {
        let mut text = command.text().to_owned();
        match command {
            Command::Undo => text = self.history.undo_label().map_or(text.clone(), |label| format!("{text}: {label}")),
            Command::Redo => text = self.history.redo_label().map_or(text.clone(), |label| format!("{text}: {label}")),
            _ => {}
        }
        let keys = command.shortcuts().first().map_or_else(String::new, |keys| ui.ctx().format_shortcut(keys));
        let button = egui::Button::new(text).shortcut_text(keys);
        let response = ui.add_enabled(self.is_possible(command), button).on_hover_text(command.tooltip());
        if response.clicked() {
            let ctx = ui.ctx().clone();
            self.carry_out(command, &ctx);
            ui.close();
        }
    }

    fn history_menu(&mut self, ui: &mut Ui) {
        ui.menu_button("History", |ui| {
            ui.set_min_width(240.0);
            let labels: Vec<(String, bool)> = self.history.labels().map(|(label, is_now)| (label.to_owned(), is_now)).collect();
            egui::ScrollArea::vertical().max_height(360.0).show(ui, |ui| {
                for (index, (label, is_now)) in labels.iter().enumerate().rev() {
                    if ui.add(egui::Button::selectable(*is_now, label.as_str())).clicked() {
                        if let Some(document) = self.history.go_to(index) {
                            self.editor.document = document;
                        }
                        ui.close();
                    }
                }
            });
        });
    }
}

impl Sent {
    fn is_same_scene(&self, other: &Self) -> bool {
        self.document.material == other.document.material
            && Arc::ptr_eq(&self.document.textures, &other.document.textures)
            && Arc::ptr_eq(&self.model, &other.model)
            && Arc::ptr_eq(&self.environment, &other.environment)
            && self.camera == other.camera
            && self.environment_deg == other.environment_deg
    }
}

impl eframe::App for App {
    fn ui(&mut self, ui: &mut Ui, _frame: &mut eframe::Frame) {
        self.frame(ui);
    }
}
