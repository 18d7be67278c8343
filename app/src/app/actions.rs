//! What commands do to the application.

use super::App;
use crate::command::Command;
use crate::dialogs::Purpose;
use crate::dock::Pane;
use crate::editor::Document;
use crate::editor::{Orbit, View, ViewMode};
use crate::loading::Job;
use crate::pages::Page;
use crate::panels::export::{ExportAction, Kind};
use crate::panels::texture_page::TexturePage;
use crate::panels::toolbar::AS_IT_COMES;
use crate::sides::Side;
use crate::widgets::value_edit::RowAction;
use crate::work::Ends;
use burnish_assets::{BACKDROPS, ENVIRONMENTS, SHAPES};
use burnish_material::Slot;
use burnish_renderer::stability::Fix;
use egui::{Context, FocusDirection, Key, Modifiers, ViewportCommand};
use std::path::Path;
use std::sync::Arc;

/// A third of a stop.
const EXPOSURE_STEP: f32 = 1.0 / 3.0;

/// What an event types.
fn text_of(event: &egui::Event) -> Option<&str> {
    match event {
        egui::Event::Text(text) => Some(text),
        _ => None,
    }
}

impl App {
    /// Whether a command would do something now.
    pub(super) fn is_possible(&self, command: Command) -> bool {
        match command {
            Command::Undo => self.undo_label().is_some(),
            Command::Redo => self.redo_label().is_some(),
            Command::ResetAll => self.editor.document.material.slots().any(|(_, slot)| *slot != Slot::default()),
            // The preview's own place says why there is none, and tries again.
            Command::ShowBoth | Command::ShowWipe | Command::ShowDifference | Command::ToggleFinal => {
                self.preview.problem().is_none()
            }
            Command::CompareRelease => self.library().is_some(),
            Command::FlipSides | Command::CompareSides => self.sides.stored().is_some(),
            Command::NextTab | Command::PreviousTab => self.tabs.count() > 1,
            Command::ContactSheet | Command::ExportPack => self.library().is_some_and(|library| !library.entries().is_empty()),
            Command::StopRendering => !self.can_render(),
            Command::NextBookmark => !self.editor.view.bookmarks.is_empty(),
            _ => true,
        }
    }

    /// The name of the step that undo takes back: of the library, if that was last, or of the material.
    pub(super) fn undo_label(&self) -> Option<&str> {
        self.file_undo().or_else(|| self.history.undo_label())
    }

    /// The same for what redo makes again.
    pub(super) fn redo_label(&self) -> Option<&str> {
        self.file_redo().or_else(|| self.history.redo_label())
    }

    /// Whether a command's menu item is marked.
    pub(super) fn is_on(&self, command: Command) -> bool {
        let view = &self.editor.view;
        match command {
            Command::ShowPreview => view.mode == ViewMode::Preview,
            Command::ShowFinal => view.mode == ViewMode::Final,
            Command::ShowBoth => view.mode == ViewMode::Both,
            Command::ShowWipe => view.mode == ViewMode::Wipe,
            Command::ShowDifference => view.mode == ViewMode::Difference,
            Command::CompareSides => view.compares_sides,
            Command::ToggleBloom => view.is_bloom_on,
            Command::ToggleDenoise => view.is_denoise_on,
            Command::TogglePanels => !view.are_panels_shown,
            _ => pane_of(command).is_some_and(|pane| self.dock.is_drawn(pane)),
        }
    }

    /// Carries out the commands whose keys were pressed.
    pub(super) fn carry_out_keys(&mut self, ctx: &Context) {
        // A page that takes keys for itself, such as the one where they are chosen, comes first.
        if self.pages.takes_keys() || self.asking.is_some() {
            return;
        }
        // Tab walks through the controls; with the mouse over the picture and nothing in hand it hides the panels.
        let is_over_view = ctx.pointer_latest_pos().is_some_and(|place| self.view_rect.contains(place));
        if is_over_view
            && ctx.memory(|memory| memory.focused().is_none())
            && ctx.input_mut(|i| i.consume_key(Modifiers::NONE, Key::Tab))
        {
            ctx.memory_mut(|memory| memory.move_focus(FocusDirection::None));
            self.carry_out(Command::TogglePanels, ctx);
        }
        if self.picking.is_some() && ctx.input_mut(|i| i.consume_key(Modifiers::NONE, Key::Escape)) {
            self.picking = None;
        }
        let commands = self.keymap.pressed(ctx);
        if commands.contains(&Command::Palette) {
            // On a slow machine the first letters come in the same frame; they are meant for the palette.
            self.carry_out(Command::Palette, ctx);
            let typed = ctx.input(|i| i.events.iter().filter_map(text_of).collect::<String>());
            self.pages.search.push_str(&typed);
            return;
        }
        for command in commands {
            self.carry_out(command, ctx);
        }
    }

    /// Does what a command says.
    pub fn carry_out(&mut self, command: Command, ctx: &Context) {
        if !self.is_possible(command) {
            return;
        }
        if command == Command::ToggleDiff && !self.dock.is_drawn(Pane::Diff) {
            self.compare_selected();
        }
        if let Some(pane) = pane_of(command) {
            self.editor.view.are_panels_shown = true;
            return self.toggle_pane(pane);
        }
        let view = &mut self.editor.view;
        match command {
            Command::New => self.new_tab(),
            Command::Open => self.ask(Purpose::OpenMaterial, ctx),
            Command::OpenRecent => self.pages.open(Page::Recent),
            Command::OpenLibrary => self.ask(Purpose::OpenLibrary, ctx),
            Command::CompareRelease => self.show_release(ctx),
            Command::NewFromMeasured => self.open_measured(),
            Command::Save => self.save(ctx),
            Command::SaveAs => self.ask(Purpose::SaveMaterial, ctx),
            Command::CloseTab => self.close_tab(ctx),
            Command::LoadModel => self.ask(Purpose::LoadModel, ctx),
            Command::LoadEnvironment => self.ask(Purpose::LoadEnvironment, ctx),
            Command::LoadTextureSet => self.ask(Purpose::LoadTextureSet, ctx),
            Command::LoadReference => self.ask(Purpose::LoadReference, ctx),
            Command::SavePng => self.ask(Purpose::SavePng, ctx),
            Command::SaveExr => self.ask(Purpose::SaveExr, ctx),
            Command::ContactSheet => self.ask(Purpose::SaveSheet, ctx),
            Command::ExportPack => self.pages.open(Page::Pack),
            Command::ExportMaterial => self.open_exchange(),
            Command::RenderPicture => {
                self.show_export(Kind::Picture);
                self.export(ExportAction::Render, ctx);
            }
            Command::RenderTurntable => {
                self.show_export(Kind::Turntable);
                self.export(ExportAction::Start, ctx);
            }
            Command::StopRendering => self.end_work(Ends::Export, ctx),
            Command::Preferences => self.pages.open(Page::Preferences),
            Command::Quit => self.close_window(ctx),
            Command::Undo => {
                if self.undo_files(false, ctx) {
                    return;
                }
                if let Some((label, document)) = self.history.undo() {
                    self.return_to(document, format!("Undid: {label}"));
                }
            }
            Command::Redo => {
                if self.redo_files(false, ctx) {
                    return;
                }
                if let Some((label, document)) = self.history.redo() {
                    self.return_to(document, format!("Redid: {label}"));
                }
            }
            Command::ResetAll => {
                self.history.settle();
                for def in burnish_material::PROPERTIES {
                    *self.editor.document.material.slot_mut(def.id) = Slot::default();
                }
                self.history.commit("Reset all properties", &self.editor.document);
            }
            Command::StoreSide => {
                self.sides.store(Side::of(&self.editor.document, "A"));
                let flip = self.keymap.shown(Command::FlipSides);
                self.messages.info(format!("This state is side A; go on with B. {flip} flips, and the wipe can show both."));
            }
            Command::FlipSides => {
                self.history.settle();
                if self.sides.flip(&mut self.editor.document) {
                    let (here, _) = self.sides.letters();
                    self.history.commit(format!("Flip to side {here}"), &self.editor.document);
                    self.messages.info(format!("This is side {here}."));
                }
            }
            Command::CompareSides => {
                view.compares_sides = !view.compares_sides;
                if view.compares_sides && !matches!(view.mode, ViewMode::Both | ViewMode::Wipe) {
                    view.mode = ViewMode::Both;
                }
            }
            Command::ToggleFinal => {
                view.mode = if view.mode == ViewMode::Final { ViewMode::Preview } else { ViewMode::Final };
            }
            Command::ShowPreview => view.mode = ViewMode::Preview,
            Command::ShowFinal => view.mode = ViewMode::Final,
            Command::ShowBoth => view.mode = ViewMode::Both,
            Command::ShowWipe => view.mode = ViewMode::Wipe,
            Command::ShowDifference => view.mode = ViewMode::Difference,
            Command::Frame => {
                if let Some(model) = &self.editor.model {
                    view.orbit.frame(model);
                }
            }
            Command::ResetView => {
                let fresh = View::default();
                view.environment_deg = fresh.environment_deg;
                view.display.exposure_ev = fresh.display.exposure_ev;
                if let Some(model) = &self.editor.model {
                    view.orbit = Orbit::of_model(model);
                }
            }
            Command::BookmarkCamera => {
                view.bookmarks.push(view.orbit);
                let count = view.bookmarks.len();
                self.messages.info(format!("Camera bookmark {count} kept."));
            }
            Command::NextBookmark => {
                let here = view.bookmarks.iter().position(|orbit| *orbit == view.orbit);
                let next = here.map_or(0, |index| (index + 1) % view.bookmarks.len());
                view.orbit = view.bookmarks[next];
            }
            Command::NextMesh | Command::PreviousMesh => {
                let here = self.editor.model.as_ref().and_then(|model| SHAPES.iter().position(|def| def.label == model.name));
                let step = if command == Command::NextMesh { 1 } else { SHAPES.len() - 1 };
                let next = here.map_or(0, |index| (index + step) % SHAPES.len());
                self.loader.start(Job::Shape(SHAPES[next].name), ctx);
            }
            Command::NextBackdrop => {
                let here = self.editor.backdrop().and_then(|shown| BACKDROPS.iter().position(|def| def.name == shown.name));
                let next = BACKDROPS.get(here.map_or(0, |index| index + 1));
                self.editor.set_backdrop(next);
                self.messages.info(format!("Backdrop: {}", next.map_or(AS_IT_COMES, |def| def.label)));
            }
            Command::NextEnvironment => {
                let name = self.editor.environment.as_ref().map(|environment| environment.name.as_str());
                let here = ENVIRONMENTS.iter().position(|def| Some(def.label) == name);
                let next = here.map_or(0, |index| (index + 1) % ENVIRONMENTS.len());
                self.loader.start(Job::BuiltInEnvironment(ENVIRONMENTS[next].name), ctx);
            }
            Command::ExposureUp => view.display.exposure_ev = third(view.display.exposure_ev + EXPOSURE_STEP),
            Command::ExposureDown => view.display.exposure_ev = third(view.display.exposure_ev - EXPOSURE_STEP),
            Command::ToggleBloom => view.is_bloom_on = !view.is_bloom_on,
            Command::ToggleDenoise => view.is_denoise_on = !view.is_denoise_on,
            Command::NextDebug => self.debug.next(),
            Command::ShowMaterial => self.debug.end(),
            Command::ExplainPixel => self.debug.toggle_explaining(),
            Command::TogglePanels => view.are_panels_shown = !view.are_panels_shown,
            Command::Fullscreen => {
                let is_full = ctx.input(|i| i.viewport().fullscreen.unwrap_or(false));
                ctx.send_viewport_cmd(ViewportCommand::Fullscreen(!is_full));
            }
            Command::NextTab | Command::PreviousTab => {
                let (count, front) = (self.tabs.count(), self.tabs.front());
                let place = if command == Command::NextTab { front + 1 } else { front + count - 1 } % count;
                self.with_front(|tabs, front| tabs.bring_to_front(place, front));
            }
            Command::ResetLayout => self.reset_layout(),
            Command::Palette => self.pages.open(Page::Palette),
            Command::Help => {
                let row = ctx.pointer_latest_pos().and_then(|place| self.properties.row_at(place));
                let is_shown = self.dock.is_drawn(Pane::Properties) && self.editor.view.are_panels_shown;
                match row.filter(|_| is_shown) {
                    Some(property) => self.pages.open(Page::Reference(property)),
                    None => self.pages.open(Page::Help),
                }
            }
            Command::ToggleLibrary
            | Command::ToggleFolder
            | Command::ToggleProperties
            | Command::ToggleLobes
            | Command::ToggleChart
            | Command::ToggleStability
            | Command::ToggleValidation
            | Command::ToggleDiff
            | Command::ToggleMerge
            | Command::ToggleHistory
            | Command::ToggleMessages
            | Command::ToggleExport => {}
        }
    }

    /// Does what a row of the properties asks for.
    pub(super) fn act(&mut self, action: RowAction, ctx: &Context) {
        match action {
            RowAction::ChooseMap(property) => self.ask_for_map(property, ctx),
            RowAction::ChooseBuiltIn(property) => {
                self.textures = TexturePage::new(&self.editor.document.material, property);
                self.pages.open(Page::Textures(property));
            }
            RowAction::PickColor(property) => {
                self.picking = Some(property);
                self.messages.info(format!("Click into a picture to take a colour for {}; Esc ends it.", property.def().label));
            }
            RowAction::ShowReference(property) => self.pages.open(Page::Reference(property)),
        }
    }

    /// Makes the changes of a fix as one step of its name.
    pub(super) fn apply_fix(&mut self, fix: &Fix) {
        self.history.settle();
        fix.apply(&mut self.editor.document.material);
        self.history.commit(fix.name.as_str(), &self.editor.document);
        self.messages.info(format!("{}; undo takes it back.", fix.name));
    }

    fn return_to(&mut self, document: Document, info: String) {
        // Images loaded since stay loaded: an undone map may come back.
        let loaded = Arc::clone(&self.editor.document.textures);
        let is_same_file = self.editor.document.shares_origin(&document);
        self.editor.document = document;
        if is_same_file && loaded.len() > self.editor.document.textures.len() {
            self.editor.document.textures = loaded;
        }
        self.messages.info(info);
    }

    /// Takes what finished in the background.
    pub(super) fn collect(&mut self, ctx: &Context) {
        while let Some((purpose, path)) = self.dialogs.poll() {
            match path {
                Some(path) => self.answered(purpose, path, ctx),
                None => {
                    self.after_save = None;
                    self.exporting.forget_answer();
                }
            }
        }
        while let Ok(written) = self.written.try_recv() {
            self.pictures_to_write -= 1;
            match written {
                Ok(info) => self.messages.info(info),
                Err(problem) => self.messages.error(problem),
            }
        }
        self.collect_exports(ctx);
        self.collect_exchange();
        while let Some(done) = self.loader.poll() {
            self.loaded(done, ctx);
        }
        self.small.collect();
    }

    /// Keeps the title current and asks before closing.
    pub(super) fn mind_the_window(&mut self, ctx: &Context) {
        if ctx.input(|i| i.viewport().close_requested()) && !self.is_closing {
            ctx.send_viewport_cmd(ViewportCommand::CancelClose);
            if self.asking.is_none() {
                self.close_window(ctx);
            }
        }
        let document = &self.editor.document;
        let mark = if document.is_modified() { " •" } else { "" };
        let import = document.import().and_then(Path::file_name);
        let import = import.map_or_else(String::new, |name| format!(" ({})", name.to_string_lossy()));
        let title = format!("{}{import}{mark} — Burnish", document.title());
        if title != self.title {
            ctx.send_viewport_cmd(ViewportCommand::Title(title.clone()));
            self.title = title;
        }
    }
}

/// The pane that a command shows or hides.
fn pane_of(command: Command) -> Option<Pane> {
    Some(match command {
        Command::ToggleLibrary => Pane::Library,
        Command::ToggleFolder => Pane::Folder,
        Command::ToggleProperties => Pane::Properties,
        Command::ToggleLobes => Pane::Lobes,
        Command::ToggleChart => Pane::Chart,
        Command::ToggleStability => Pane::Stability,
        Command::ToggleValidation => Pane::Validation,
        Command::ToggleDiff => Pane::Diff,
        Command::ToggleMerge => Pane::Merge,
        Command::ToggleHistory => Pane::History,
        Command::ToggleMessages => Pane::Messages,
        Command::ToggleExport => Pane::Export,
        _ => return None,
    })
}

/// Exposure on whole thirds of a stop.
fn third(ev: f32) -> f32 {
    (ev * 3.0).round() / 3.0
}
