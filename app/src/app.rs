//! The window: one frame, in order. What commands do is in `app/actions.rs`.

mod actions;
mod asking;
mod bars;
mod checking;
mod comparing;
mod documents;
mod drops;
mod exchanging;
mod exported;
mod exporting;
mod handing_out;
mod job;
mod keeping;
mod library;
mod loaded;
mod merge;
mod pages;
mod panes;
mod pick;
mod pictures;
mod release;
mod rescue;
mod saving;
mod screenshot;
mod sync;
mod window;

pub use window::{WindowError, WindowOptions, run};

use crate::dialogs::Dialogs;
use crate::dock::{Dock, Pane};
use crate::editor::{Document, Editor, ViewMode};
use crate::history::History;
use crate::keymap::Keymap;
use crate::live_costs::LiveCosts;
use crate::live_debug::LiveDebug;
use crate::live_difference::LiveDifference;
use crate::live_final::LiveFinal;
use crate::live_preview::LivePreview;
use crate::live_stability::LiveStability;
use crate::loading::{Job, Loader};
use crate::pages::Pages;
use crate::panels::messages::Messages;
use crate::panels::presets::PresetPanel;
use crate::panels::properties::PropertyPanel;
use crate::panels::reference::ReferencePanel;
use crate::panels::texture_page::TexturePage;
use crate::preferences::Preferences;
use crate::sides::Sides;
use crate::small_pictures::SmallPictures;
use crate::tabs::{Tabs, Work};
use crate::theme;
use crate::typing::TypingInOrder;
use burnish_assets::{BackdropDef, ENVIRONMENTS, SHAPES};
use burnish_material::{Material, Property};
use checking::CheckWork;
use comparing::CompareWork;
use documents::After;
use egui::Ui;
use exchanging::Exchanging;
use exporting::Exporting;
use keeping::Keeping;
use library::LibraryWork;
use merge::MergeWork;
use rescue::Rescue;
use screenshot::Screenshot;
use std::sync::mpsc::{Receiver, Sender};
use std::time::Instant;
use sync::Sent;

/// The application.
pub struct App {
    editor: Editor,
    history: History,
    sides: Sides,
    tabs: Tabs,
    preferences: Preferences,
    keymap: Keymap,
    messages: Messages,
    dock: Dock,
    /// The tile of the view.
    view_tile: Option<egui_tiles::TileId>,
    /// What is to be shown or hidden once the tree is drawn.
    to_toggle: Vec<Pane>,
    /// What is to be shown once the tree is drawn.
    to_show: Vec<Pane>,
    pages: Pages,
    presets: PresetPanel,
    library_work: LibraryWork,
    exchanging: Exchanging,
    textures: TexturePage,
    check: CheckWork,
    compare: CompareWork,
    merge: MergeWork,
    properties: PropertyPanel,
    reference: ReferencePanel,
    /// Small pictures of maps, meshes and lights.
    small: SmallPictures,
    loader: Loader,
    dialogs: Box<dyn Dialogs>,
    preview: LivePreview,
    /// The preview of the stored side, while sides are compared.
    side_preview: Option<LivePreview>,
    difference: LiveDifference,
    final_view: Option<LiveFinal>,
    stability: Option<LiveStability>,
    costs: LiveCosts,
    /// What is shown instead of the material, and what a pixel is made of.
    debug: LiveDebug,
    /// The window's device, if it has one.
    render_state: Option<egui_wgpu::RenderState>,
    /// What a window without its device leaves to the next.
    rescue: Rescue,
    /// When the device is to be given up, to see what comes of it.
    loses_device: Option<Instant>,
    sent: Option<Sent>,
    /// Counts the scenes that were sent.
    revision: u64,
    /// Size of one picture in pixels, from the last frame.
    picture_size: (usize, usize),
    /// Where the view is.
    view_rect: egui::Rect,
    /// When the user last did anything.
    last_input: Instant,
    /// The property whose colour the next click in a picture sets.
    picking: Option<Property>,
    /// What the question about unsaved changes is for.
    asking: Option<After>,
    /// What goes on once the document is saved.
    after_save: Option<After>,
    is_closing: bool,
    title: String,
    /// What the final view leaves out of this material, in sentences.
    left_out: Vec<String>,
    /// What is remembered between runs, if anything.
    keeping: Keeping,
    screenshot: Option<Screenshot>,
    /// Pictures that threads are writing.
    pictures_to_write: usize,
    /// Pictures and turntables to give away.
    exporting: Exporting,
    written: Receiver<Result<String, String>>,
    writer: Sender<Result<String, String>>,
}

impl App {
    /// An application in this context, with the preview on its device if it has one. It remembers nothing unless [`Self::keep_in`] says where.
    pub fn new(ctx: &egui::Context, render_state: Option<&egui_wgpu::RenderState>, dialogs: Box<dyn Dialogs>) -> Self {
        ctx.set_fonts(theme::fonts());
        // A press elsewhere may begin a drag: what is being typed is done before that.
        ctx.options_mut(|options| options.input_options.surrender_focus_on = egui::SurrenderFocusOn::Presses);
        ctx.add_plugin(TypingInOrder::default());
        let preview = LivePreview::new(render_state);
        let mut editor = Editor::new();
        if preview.problem().is_some() {
            editor.view.mode = ViewMode::Final;
        }
        let history = History::new(&editor.document);
        let (writer, written) = std::sync::mpsc::channel();
        let mut messages = Messages::default();
        messages.info("Ready. Choose a preset, or drop a material, a mesh or an environment.");
        let mut app = Self {
            editor,
            history,
            sides: Sides::default(),
            tabs: Tabs::default(),
            preferences: Preferences::default(),
            keymap: Keymap::default(),
            messages,
            dock: Dock::default(),
            view_tile: None,
            to_toggle: Vec::new(),
            to_show: Vec::new(),
            pages: Pages::default(),
            presets: PresetPanel::default(),
            library_work: LibraryWork::default(),
            exchanging: Exchanging::default(),
            textures: TexturePage::default(),
            check: CheckWork::default(),
            compare: CompareWork::default(),
            merge: MergeWork::default(),
            properties: PropertyPanel::default(),
            reference: ReferencePanel::default(),
            small: SmallPictures::default(),
            debug: LiveDebug::default(),
            loader: Loader::default(),
            dialogs,
            preview,
            side_preview: None,
            difference: LiveDifference::default(),
            final_view: None,
            stability: None,
            costs: LiveCosts::default(),
            render_state: render_state.cloned(),
            rescue: Rescue::default(),
            loses_device: None,
            sent: None,
            revision: 0,
            picture_size: (0, 0),
            view_rect: egui::Rect::NOTHING,
            last_input: Instant::now(),
            picking: None,
            asking: None,
            after_save: None,
            is_closing: false,
            title: String::new(),
            left_out: Vec::new(),
            keeping: Keeping::default(),
            screenshot: None,
            pictures_to_write: 0,
            exporting: Exporting::default(),
            written,
            writer,
        };
        app.apply_preferences(ctx);
        app.editor.set_backdrop(BackdropDef::named(&app.preferences.backdrop));
        app.load_first_scene(ctx);
        app
    }

    /// Starts loading the mesh and the light that the user prefers, as far as there is none.
    fn load_first_scene(&mut self, ctx: &egui::Context) {
        let mesh = SHAPES.iter().find(|def| def.name == self.preferences.mesh).or(SHAPES.first());
        if let Some(shape) = mesh.filter(|_| self.editor.model.is_none()) {
            self.loader.start(Job::Shape(shape.name), ctx);
        }
        let light = ENVIRONMENTS.iter().find(|def| def.name == self.preferences.light).or(ENVIRONMENTS.first());
        if let Some(environment) = light.filter(|_| self.editor.environment.is_none()) {
            self.loader.start(Job::BuiltInEnvironment(environment.name), ctx);
        }
    }

    /// A document with every property at its default, in units of the user's choice.
    fn new_document(&self) -> Document {
        let mut material = Material::named("New material");
        if self.preferences.unit_mm != burnish_material::DEFAULT_UNIT_MM {
            material.unit_mm = Some(self.preferences.unit_mm);
        }
        Document::new(material)
    }

    /// The document and the view settings.
    pub fn editor(&self) -> &Editor {
        &self.editor
    }

    /// The same, for tests and for what opens the window.
    pub fn editor_mut(&mut self) -> &mut Editor {
        &mut self.editor
    }

    /// The steps made so far in the document in front.
    pub fn history(&self) -> &History {
        &self.history
    }

    /// What the document in front is compared with.
    pub fn sides(&self) -> &Sides {
        &self.sides
    }

    /// What the user was told.
    pub fn messages(&self) -> &Messages {
        &self.messages
    }

    /// Which keys do what.
    pub fn keymap(&self) -> &Keymap {
        &self.keymap
    }

    /// What the user prefers.
    pub fn preferences(&self) -> &Preferences {
        &self.preferences
    }

    /// Where the panels are.
    pub fn dock(&self) -> &Dock {
        &self.dock
    }

    /// The same, to move them: for tests and benches.
    pub fn dock_mut(&mut self) -> &mut Dock {
        &mut self.dock
    }

    /// How many documents are open.
    pub fn document_count(&self) -> usize {
        self.tabs.count()
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

    /// Lets the list of documents exchange the one in front.
    fn with_front<R>(&mut self, change: impl FnOnce(&mut Tabs, &mut Work) -> R) -> R {
        self.history.settle();
        let blank = Document::new(Material::default());
        let history = std::mem::replace(&mut self.history, History::new(&blank));
        let document = std::mem::replace(&mut self.editor.document, blank);
        let mut front = Work { document, history, sides: std::mem::take(&mut self.sides) };
        let result = change(&mut self.tabs, &mut front);
        self.editor.document = front.document;
        self.history = front.history;
        self.sides = front.sides;
        result
    }

    /// One frame.
    pub fn frame(&mut self, ui: &mut Ui) {
        let ctx = ui.ctx().clone();
        if ctx.input(|i| !i.raw.events.is_empty() || i.pointer.any_down()) {
            self.last_input = Instant::now();
        }
        if ctx.input(|i| i.raw.events.contains(&egui::Event::WindowFocused(true))) {
            self.look_for_changes();
        }
        if self.has_lost_device(&ctx) {
            return;
        }
        theme::fit(&ctx, self.preferences.text_scale);
        self.collect(&ctx);
        self.mind_the_library(&ctx);
        self.mind_the_check(&ctx);
        self.carry_out_keys(&ctx);
        self.panels(ui);
        self.show_pages(&ctx);
        self.ask_about_unsaved(&ctx);
        self.ask_about_rendering(&ctx);
        self.take_drops(&ctx);
        self.mind_the_window(&ctx);
        self.keep(&ctx);
        self.has_lost_device(&ctx);
        self.mind_the_screenshot(&ctx);
    }
}

impl eframe::App for App {
    fn ui(&mut self, ui: &mut Ui, _frame: &mut eframe::Frame) {
        self.frame(ui);
    }

    fn on_exit(&mut self) {
        self.keep_for_next_time();
    }
}
