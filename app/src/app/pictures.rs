//! The pictures in the middle of the window: preview, final view, both, a wipe between them, or their difference; and what is said of them.

use super::App;
use crate::command::Command;
use crate::editor::ViewMode;
use crate::live_debug::Choice;
use crate::live_final::LiveFinal;
use crate::live_preview::{LivePreview, REST};
use crate::panels::chart::ErrorCurve;
use crate::panels::status::{self, Status};
use crate::panels::viewport::{self, Layout, Picture, WayOut};
use crate::panels::wipe;
use crate::work::{Ends, Work};
use burnish_material::{LOBES, LobeSet};
use burnish_renderer::worker::Snapshot;
use egui::{Rect, Ui};
use std::time::Duration;

impl App {
    /// Draws and shows the pictures of the mode that is on.
    pub(super) fn pictures(&mut self, ui: &mut Ui, layout: Layout) {
        let ctx = ui.ctx().clone();
        let (mode, share) = (self.editor.view.mode, self.editor.view.wipe);
        let is_named = layout.preview.is_some() && layout.final_view.is_some();
        let part_of = |rect: Rect, is_left: bool| match mode {
            ViewMode::Wipe if is_left => wipe::split(rect, share).0,
            ViewMode::Wipe => wipe::split(rect, share).1,
            _ => rect,
        };
        self.update_debug(&ctx);
        if self.is_comparing() {
            self.paint_sides(ui, layout, part_of);
        } else {
            if let Some(rect) = layout.preview {
                let texture = self.draw_preview(&ctx);
                let notes = self.preview.complaint().into_iter().collect();
                let problem = self.preview.problem();
                let picture = Picture { texture, name: "Preview", notes, label: None, problem };
                let picture = self.debugged(picture);
                if mode != ViewMode::Difference {
                    let way = viewport::paint(ui, rect, part_of(rect, true), &picture, is_named || self.debug.choice().is_some());
                    self.take_way(way, &ctx);
                }
            }
            self.paint_final(ui, layout, |rect| part_of(rect, false), is_named);
        }
        if layout.preview.is_none() {
            self.preview.forget_edit();
        }
        if mode == ViewMode::Wipe {
            wipe::paint(ui, layout.all, share);
        }
        if let Some(choice) = self.debug.choice() {
            viewport::paint_legend(ui, layout.all, choice);
        }
    }

    /// Side A or B as stored on the left, the state being edited on the right; both by the preview.
    fn paint_sides(&mut self, ui: &mut Ui, layout: Layout, part_of: impl Fn(Rect, bool) -> Rect) {
        let ctx = ui.ctx().clone();
        let (here, there) = self.sides.letters();
        let label = self.sides.stored().map(|side| side.label.clone()).filter(|label| label.len() > 1);
        let size = (self.picture_size.0 as u32, self.picture_size.1 as u32);
        let (display, idle) = (self.editor.view.display, self.last_input.elapsed());
        let stored = self.side_preview.as_mut().and_then(|preview| preview.draw(size, display, idle));
        if self.side_preview.as_ref().is_some_and(|preview| preview.is_owing() || preview.is_finishing()) {
            ctx.request_repaint_after(REST.saturating_sub(idle).min(Duration::from_millis(60)));
        }
        let current = self.draw_preview(&ctx);
        for (rect, is_left, texture, name, label) in [
            (layout.preview, true, stored, format!("Side {there}, stored"), label),
            (layout.final_view, false, current, format!("Side {here}, being edited"), None),
        ] {
            let Some(rect) = rect else { continue };
            let picture = Picture { texture, name: &name, notes: Vec::new(), label, problem: self.preview.problem() };
            let way = viewport::paint(ui, rect, part_of(rect, is_left), &picture, true);
            self.take_way(way, &ctx);
        }
    }

    fn paint_final(&mut self, ui: &mut Ui, layout: Layout, part_of: impl Fn(Rect) -> Rect, is_named: bool) {
        let Some(rect) = layout.final_view else { return };
        let ctx = ui.ctx().clone();
        if let Some(view) = &mut self.final_view {
            view.update(&ctx, self.editor.view.display, self.editor.view.is_denoise_on);
        }
        if self.editor.view.mode == ViewMode::Difference {
            return self.paint_difference(ui, rect);
        }
        let mut picture = Picture { texture: None, name: "Final", notes: Vec::new(), label: None, problem: None };
        if let Some(view) = &mut self.final_view {
            picture.texture = view.texture().map(|texture| texture.id());
            picture.notes.clone_from(&self.left_out);
            picture.notes.extend(view.problem().map(str::to_owned));
            picture.label = view.label().map(str::to_owned);
        }
        let is_alone = layout.preview.is_none();
        let picture = if is_alone { self.debugged(picture) } else { picture };
        viewport::paint(ui, rect, part_of(rect), &picture, is_named || (is_alone && self.debug.choice().is_some()));
    }

    /// The picture, or the debug view that is shown in its place.
    fn debugged<'a>(&'a self, picture: Picture<'a>) -> Picture<'a> {
        let Some(choice) = self.debug.choice() else { return picture };
        let texture = self.debug.texture().map(|texture| texture.id());
        let is_waiting = texture.is_none() && matches!(choice, Choice::Samples(_)) && !self.has_final();
        let label = is_waiting.then(|| "The final view is not shown, so it has no samples.".to_owned());
        Picture { texture, name: choice.label(), label, notes: Vec::new(), ..picture }
    }

    fn update_debug(&mut self, ctx: &egui::Context) {
        let snapshot = self.final_view.as_ref().and_then(LiveFinal::current).cloned();
        let (width, height) = self.picture_size;
        let editor = &self.editor;
        let aspect = width as f32 / height as f32;
        self.debug.update(ctx, self.revision, (width, height), snapshot.as_ref(), || editor.scene(aspect));
    }

    /// The error of the final picture over time, once there are enough estimates.
    pub(super) fn curve(&self) -> Option<ErrorCurve> {
        let snapshot = self.final_view.as_ref().filter(|_| self.has_final())?.current()?;
        ErrorCurve::new(&snapshot.history, self.editor.view.stop.relmse, snapshot.done.is_some())
    }

    fn draw_preview(&mut self, ctx: &egui::Context) -> Option<egui::TextureId> {
        let size = (self.picture_size.0 as u32, self.picture_size.1 as u32);
        let idle = self.last_input.elapsed();
        if self.editor.model.is_none() || self.editor.environment.is_none() {
            return None;
        }
        self.preview.set_bloom(self.editor.view.is_bloom_on && self.editor.view.mode == ViewMode::Preview);
        let texture = self.preview.draw(size, self.editor.view.display, idle);
        if self.preview.is_finishing() {
            ctx.request_repaint_after(Duration::from_millis(1));
        }
        if self.preview.is_owing() {
            // Right after an event, wait for the hand to rest; then go on without a pause.
            ctx.request_repaint_after(REST.saturating_sub(idle).min(Duration::from_millis(60)));
        }
        texture
    }

    fn paint_difference(&mut self, ui: &mut Ui, rect: Rect) {
        let newest = self.final_view.as_ref().and_then(LiveFinal::current).cloned();
        let display = self.editor.view.display;
        self.difference.update(ui.ctx(), &mut self.preview, newest.as_ref(), display);
        let texture = self.difference.texture().map(|texture| texture.id());
        let label = (!self.difference.text().is_empty()).then(|| self.difference.text().to_owned());
        let problem = self.preview.problem();
        let picture = Picture { texture, name: "Difference", notes: Vec::new(), label, problem };
        let way = viewport::paint(ui, rect, rect, &picture, true);
        self.take_way(way, &ui.ctx().clone());
    }

    /// Out of having no preview.
    fn take_way(&mut self, way: Option<WayOut>, ctx: &egui::Context) {
        match way {
            Some(WayOut::ShowFinal) => self.carry_out(Command::ShowFinal, ctx),
            Some(WayOut::TryAgain) => {
                self.preview = LivePreview::new(self.render_state.as_ref());
                // Everything is told to it again.
                self.sent = None;
            }
            None => {}
        }
    }

    /// What the status line says.
    pub(super) fn status(&self) -> Status {
        let (width, height) = self.picture_size;
        let stop = &self.editor.view.stop;
        let adapter = self.preview.adapter().unwrap_or_default();
        let samples = self.preview.ray_samples();
        let rays = if samples > 0 { format!("   {samples} samples of rays") } else { String::new() };
        let edit = self.preview.latency().map_or_else(String::new, |(last, worst)| {
            format!("   edit to pixel {:.0} ms (worst {:.0} ms, {} frames)", last.ms, worst.ms, worst.frames)
        });
        let preview = format!("Preview {width} × {height}{rays}{edit}");
        let graph = self.preview.frame_graph().map_or_else(String::new, |(times, problem)| status::frame_text(times, problem));
        let snapshot = self.final_view.as_ref().and_then(LiveFinal::current);
        let (picture, details) = match (self.has_final() && self.is_view_seen(), snapshot) {
            (true, Some(snapshot)) => {
                let details = status::final_details(snapshot, stop);
                let shown = if self.editor.view.mode.has_preview() {
                    format!("\n\n{preview} on {adapter}\n{graph}")
                } else {
                    String::new()
                };
                let details = format!("Final view, {width} × {height}\n{details}{shown}");
                let held = self.final_view.as_ref().filter(|view| view.is_held());
                let held = held.map_or("", |_| "waits for the rendering   ");
                (format!("Final   {held}{}", status::final_text(snapshot, stop)), details)
            }
            (true, None) => ("Final   starting…".into(), String::new()),
            (false, _) => {
                let state = if self.preview.is_owing() { "refining" } else { "" };
                (
                    format!("{preview}   {state}"),
                    format!("{preview} on {adapter}\n{graph}\nThe final view is paused; press \\ to see it."),
                )
            }
        };
        Status { work: self.work(), info: self.messages.last_info().to_owned(), picture, details }
    }

    /// Everything that is being worked at.
    pub(super) fn work(&self) -> Vec<Work> {
        let mut list = Vec::new();
        list.extend(self.loader.work());
        list.extend(self.exporting.work());
        if let Some((done, all)) = self.small.progress() {
            let progress = Some(done as f32 / all.max(1) as f32);
            list.push(Work {
                progress,
                ends: Some(Ends::SmallPictures),
                ..Work::new(format!("Small pictures, {done} of {all}"))
            });
        }
        let costs = self.costs.found(LobeSet::of(&self.editor.document.material));
        if costs.is_running {
            let progress = Some(costs.lobes.len() as f32 / LOBES.len() as f32);
            list.push(Work { progress, ends: Some(Ends::Costs), ..Work::new("Measuring lobes") });
        }
        list.extend(self.check_work());
        list.extend(self.compare.work());
        if self.library_work.is_editing() {
            list.push(Work::new("Writing files of the library"));
        }
        list.extend(self.hand_out_work());
        list.extend(self.exchange_work());
        if self.pictures_to_write > 0 {
            list.push(Work::new("Writing the picture"));
        }
        if self.preview.is_preparing() {
            list.push(Work::new("Preview: light and heights"));
        }
        if self.debug.is_busy() {
            let progress = self.debug.progress();
            list.push(Work { progress, ends: Some(Ends::Debug), ..Work::new("Looking at the surface") });
        }
        let is_unfinished = |snapshot: &&std::sync::Arc<Snapshot>| snapshot.done.is_none();
        if let Some(snapshot) = self
            .final_view
            .as_ref()
            .filter(|view| self.has_final() && self.is_view_seen() && !view.is_held())
            .and_then(LiveFinal::current)
            .filter(is_unfinished)
        {
            let end = status::end(snapshot, &self.editor.view.stop).map(|(end, _)| end);
            let progress = end.map(|end| (snapshot.seconds / end.max(1e-3)).clamp(0.0, 1.0) as f32);
            let remaining = end.map(|end| (end - snapshot.seconds).max(0.0));
            list.push(Work { text: "Final view".into(), progress, remaining, ends: Some(Ends::FinalView) });
        }
        list
    }

    /// Ends a piece of work.
    pub(super) fn end_work(&mut self, ends: Ends, ctx: &egui::Context) {
        match ends {
            Ends::Loading(number) => {
                self.loader.end(number);
                self.messages.info("Loading was ended.");
            }
            Ends::SmallPictures => self.small.cancel(),
            Ends::HandOut => self.end_hand_out(),
            Ends::Measuring => self.end_measuring(),
            Ends::Exchange => self.end_exchange(),
            Ends::Debug => self.debug.end(),
            Ends::Check => self.end_check(),
            Ends::Release => self.end_release(),
            Ends::PictureDiff => self.compare.end(),
            Ends::Costs => self.costs.cancel(),
            Ends::Export => self.exporting.live.cancel(),
            Ends::FinalView => self.carry_out(Command::ShowPreview, ctx),
        }
    }
}
