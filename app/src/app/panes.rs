//! The panes between the bars: what each shows, and how their tabs look.

use super::App;
use crate::dock::{Dock, GAP, Pane};
use crate::live_stability::LiveStability;
use crate::panels::library::{Dragged, LibraryAction};
use crate::panels::toolbar::{self, Tools, Wish};
use crate::panels::viewport;
use crate::panels::{history, hold, messages, stability, status};
use crate::theme;
use burnish_material::LobeSet;
use egui::{CentralPanel, Color32, Frame, Margin, Panel, ScrollArea, Stroke, Ui, Visuals, WidgetText, vec2};
use egui_tiles::{SimplificationOptions, TabState, TileId, Tiles, UiResponse};

/// Draws the panes of the tree with what the application knows.
struct Panes<'a> {
    app: &'a mut App,
    closed: Vec<TileId>,
    /// Whether no other tab is shown beside that of the view.
    is_view_alone: bool,
}

impl egui_tiles::Behavior<Pane> for Panes<'_> {
    fn pane_ui(&mut self, ui: &mut Ui, _tile: TileId, pane: &mut Pane) -> UiResponse {
        self.app.pane(ui, *pane);
        UiResponse::None
    }

    fn tab_title_for_pane(&mut self, pane: &Pane) -> WidgetText {
        pane.title().into()
    }

    fn is_tab_closable(&self, tiles: &Tiles<Pane>, tile: TileId) -> bool {
        tiles.get_pane(&tile).is_some_and(|pane| *pane != Pane::View)
    }

    fn on_tab_close(&mut self, _tiles: &mut Tiles<Pane>, tile: TileId) -> bool {
        // Hidden, not removed: it comes back where it was.
        self.closed.push(tile);
        false
    }

    fn is_tab_bar_visible(&self, _tile: TileId, tabs: &egui_tiles::Tabs) -> bool {
        // The view needs every point, and its own toolbar says what it is.
        !(self.is_view_alone && self.app.view_tile.is_some_and(|view| tabs.children.contains(&view)))
    }

    fn gap_width(&self, _style: &egui::Style) -> f32 {
        GAP
    }

    fn tab_bar_height(&self, style: &egui::Style) -> f32 {
        style.spacing.interact_size.y + 1.0
    }

    fn close_button_outer_size(&self) -> f32 {
        13.0
    }

    fn min_size(&self) -> f32 {
        60.0
    }

    fn tab_bar_color(&self, _visuals: &Visuals) -> Color32 {
        theme::now().bar
    }

    fn tab_bg_color(&self, _visuals: &Visuals, _tiles: &Tiles<Pane>, _tile: TileId, state: &TabState) -> Color32 {
        if state.active { theme::now().panel } else { theme::now().bar }
    }

    fn tab_text_color(&self, _visuals: &Visuals, _tiles: &Tiles<Pane>, _tile: TileId, state: &TabState) -> Color32 {
        if state.active { theme::now().strong } else { theme::now().weak }
    }

    fn tab_outline_stroke(&self, _visuals: &Visuals, _tiles: &Tiles<Pane>, _tile: TileId, _state: &TabState) -> Stroke {
        Stroke::NONE
    }

    fn simplification_options(&self) -> SimplificationOptions {
        SimplificationOptions { all_panes_must_have_tabs: true, ..SimplificationOptions::default() }
    }

    fn preview_dragged_panes(&self) -> bool {
        // A pane drawn twice in a frame would be edited twice.
        false
    }
}

impl App {
    /// Draws what is between the bars.
    pub(super) fn panes(&mut self, ui: &mut Ui) {
        CentralPanel::no_frame().show(ui, |ui| {
            if !self.editor.view.are_panels_shown {
                self.pane(ui, Pane::View);
                return;
            }
            ui.painter().rect_filled(ui.max_rect(), 0, theme::now().bar);
            let mut dock = std::mem::replace(&mut self.dock, Dock::empty());
            let has_view = dock.is_drawn(Pane::View);
            self.view_tile = dock.tree.tiles.find_pane(&Pane::View);
            let mut panes = Panes { app: self, closed: Vec::new(), is_view_alone: dock.is_alone(Pane::View) };
            let text_scale = theme::text_scale(ui);
            dock.show(ui, &mut panes, text_scale);
            let closed = std::mem::take(&mut panes.closed);
            closed.into_iter().for_each(|tile| dock.close(tile));
            // What a pane asked for while the tree was away.
            for pane in std::mem::take(&mut self.to_toggle) {
                dock.toggle(pane);
            }
            for pane in std::mem::take(&mut self.to_show) {
                dock.set_shown(pane, true);
            }
            self.dock = dock;
            // The view tells everybody what changed; behind another tab it is not drawn.
            if !has_view {
                self.view_rect = egui::Rect::NOTHING;
                let ctx = ui.ctx().clone();
                self.sync(&ctx);
            }
        });
        if !self.dock.is_drawn(Pane::Diff) {
            self.compare.forget();
        }
        if !self.dock.is_drawn(Pane::Stability)
            && let Some(stability) = &mut self.stability
        {
            stability.forget();
        }
    }

    /// Shows a pane in front of its tabs; while the tree is being drawn, right after.
    pub(super) fn show_pane(&mut self, pane: Pane) {
        self.editor.view.are_panels_shown = true;
        if self.dock.tree.is_empty() {
            self.to_show.push(pane);
        } else if !self.dock.is_drawn(pane) {
            self.dock.set_shown(pane, true);
        }
    }

    fn pane(&mut self, ui: &mut Ui, pane: Pane) {
        let ctx = ui.ctx().clone();
        if pane == Pane::View {
            return self.view_pane(ui);
        }
        ui.painter().rect_filled(ui.max_rect(), 0, theme::now().panel);
        Frame::new().inner_margin(Margin { left: 9, right: 3, top: 4, bottom: 2 }).show(ui, |ui| match pane {
            Pane::View => {}
            Pane::Library => {
                let name = self.editor.document.file().material().name.clone();
                if let Some(preset) = hold(ui, |ui| self.presets.show(ui, &name)) {
                    self.load_preset(preset, &ctx);
                }
            }
            Pane::Folder => hold(ui, |ui| self.library_pane(ui)),
            Pane::Properties => {
                let sides = self.sides.stored().map(|side| side.material.clone());
                let action =
                    hold(ui, |ui| self.properties.show(ui, &mut self.editor.document, sides.as_deref(), &mut self.small));
                if let Some(action) = action {
                    self.act(action, &ctx);
                }
            }
            Pane::Lobes => hold(ui, |ui| self.lobe_pane(ui)),
            Pane::Chart => hold(ui, |ui| self.chart_pane(ui)),
            Pane::Stability => hold(ui, |ui| self.stability_pane(ui)),
            Pane::Validation => hold(ui, |ui| self.validation_pane(ui)),
            Pane::Diff => hold(ui, |ui| self.diff_pane(ui)),
            Pane::Merge => hold(ui, |ui| self.merge_pane(ui)),
            Pane::History => {
                self.file_steps(ui);
                if let Some(index) = hold(ui, |ui| history::show(ui, &self.history))
                    && let Some(document) = self.history.go_to(index)
                {
                    self.editor.document = document;
                }
            }
            Pane::Export => self.export_pane(ui),
            Pane::Messages => hold(ui, |ui| messages::show_log(ui, &mut self.messages)),
            Pane::Reference => {
                let picked = hold(ui, |ui| self.reference.show(ui, self.picking.is_some()));
                if let Some((color, what)) = picked {
                    self.picked(color, &what);
                }
            }
        });
    }

    fn view_pane(&mut self, ui: &mut Ui) {
        let ctx = ui.ctx().clone();
        let bar = Frame::new().fill(theme::now().bar).inner_margin(Margin::symmetric(8, 4));
        Panel::top("toolbar").frame(bar).show(ui, |ui| {
            let mut tools = Tools {
                has_preview: self.preview.problem().is_none(),
                has_side: self.sides.stored().is_some(),
                keymap: &self.keymap,
                small: &mut self.small,
                debug: &mut self.debug,
            };
            match toolbar::show(ui, &mut self.editor, &mut tools) {
                Some(Wish::Command(command)) => self.carry_out(command, &ctx),
                Some(Wish::Load(job)) => self.loader.start(job, &ctx),
                None => {}
            }
        });
        CentralPanel::no_frame().show(ui, |ui| {
            let (response, layout) = viewport::interact(
                ui,
                &mut self.editor,
                self.preferences.mouse,
                self.preferences.is_wheel_flipped,
                self.picking.is_some() || self.debug.is_explaining(),
            );
            self.view_rect = layout.all;
            let scale = ctx.pixels_per_point();
            let size = (layout.picture_size() * scale).round();
            self.picture_size = ((size.x as usize).clamp(16, 8192), (size.y as usize).clamp(16, 8192));
            self.sync(&ctx);
            self.pictures(ui, layout);
            self.pick_or_explain(ui, &response, layout);
            if let Some(dragged) = response.dnd_release_payload::<Dragged>() {
                self.do_in_library(LibraryAction::Apply(dragged.0.clone()), &ctx);
            }
            self.messages.show(ui, layout.all);
        });
    }

    fn lobe_pane(&mut self, ui: &mut Ui) {
        let needed = LobeSet::of(&self.editor.document.material);
        let costs = self.costs.found(needed);
        let strip = |ui: &mut Ui| status::lobe_strip(ui, &self.editor.document.material, &costs);
        if !ScrollArea::vertical().auto_shrink([false, false]).show(ui, strip).inner {
            return;
        }
        let (width, height) = self.picture_size;
        match self.editor.scene(width.max(1) as f32 / height.max(1) as f32) {
            _ if costs.is_running => self.costs.cancel(),
            Some(scene) => self.costs.start(ui.ctx(), scene, needed, [width as u32, height as u32]),
            None => {}
        }
    }

    fn chart_pane(&mut self, ui: &mut Ui) {
        let size = ui.available_size() - vec2(6.0, 2.0);
        let curve = self.curve();
        viewport::chart_pane(ui, size, curve.as_ref(), self.has_final());
    }

    fn stability_pane(&mut self, ui: &mut Ui) {
        let ctx = ui.ctx().clone();
        let live = self.stability.get_or_insert_with(|| LiveStability::new(ctx.clone()));
        let document = &self.editor.document;
        let state = live.update(&ctx, &document.material, &document.textures, || self.editor.scene(1.0));
        if let Some(fix) = stability::show(ui, &state) {
            self.apply_fix(&fix);
        }
    }

    /// Shows a pane or hides it; while the tree is being drawn, right after.
    pub(super) fn toggle_pane(&mut self, pane: Pane) {
        if self.dock.tree.is_empty() {
            self.to_toggle.push(pane);
        } else {
            self.dock.toggle(pane);
        }
    }

    /// All panes to their places.
    pub(super) fn reset_layout(&mut self) {
        self.dock = Dock::default();
        self.editor.view.are_panels_shown = true;
    }
}
