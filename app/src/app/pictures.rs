//! The pictures in the middle of the window: preview, final view, both, a wipe between them, or their difference; and what is said of them.

use super::App;
use crate::command::Command;
use crate::editor::{View, ViewMode};
use crate::live_final::LiveFinal;
use crate::live_preview::{LivePreview, REST};
use crate::panels::chart::{self, ErrorCurve};
use crate::panels::status::{self, Status};
use crate::panels::viewport::{self, Layout, Picture, WayOut};
use crate::panels::wipe;
use egui::{Rect, Ui};
use std::time::Duration;

impl App {
    /// Draws and shows the pictures of the mode that is on.
    pub(super) fn pictures(&mut self, ui: &mut Ui, layout: Layout) {
        let ctx = ui.ctx().clone();
        let View { mode, display, wipe: share, .. } = self.editor.view;
        let is_named = layout.preview.is_some() && layout.final_view.is_some();
        let part_of = |rect: Rect, is_preview: bool| match mode {
            ViewMode::Wipe if is_preview => wipe::split(rect, share).0,
            ViewMode::Wipe => wipe::split(rect, share).1,
            _ => rect,
        };
        if let Some(rect) = layout.preview {
            let texture = self.draw_preview(&ctx);
            let notes = self.preview.complaint().into_iter().collect();
            let problem = self.preview.problem();
            let picture = Picture { texture, name: "Preview", notes, label: None, reserved: 0.0, problem };
            if mode != ViewMode::Difference {
                let way = viewport::paint(ui, rect, part_of(rect, true), &picture, is_named);
                self.take_way(way, &ctx);
            }
        }
        if layout.preview.is_none() {
            self.preview.forget_edit();
        }
        let Some(rect) = layout.final_view else { return };
        if let Some(view) = &mut self.final_view {
            view.update(&ctx, display, self.editor.view.is_denoise_on);
        }
        if mode == ViewMode::Difference {
            return self.paint_difference(ui, rect);
        }
        let mut picture = Picture { texture: None, name: "Final", notes: Vec::new(), label: None, reserved: 0.0, problem: None };
        let mut curve = None;
        if let Some(view) = &mut self.final_view {
            picture.texture = view.texture().map(|texture| texture.id());
            picture.notes.clone_from(&self.left_out);
            picture.notes.extend(view.problem().map(str::to_owned));
            picture.label = view.label().map(str::to_owned);
            let is_shown = self.editor.view.is_chart_shown;
            curve = view.current().filter(|_| is_shown).and_then(|snapshot| {
                let target = self.editor.view.stop.relmse;
                let curve = ErrorCurve::new(&snapshot.history, target, snapshot.done.is_some())?;
                Some((curve, chart::size(part_of(rect, false).size())?))
            });
        }
        if let Some((_, size)) = &curve {
            picture.reserved = size.y + 22.0;
        }
        viewport::paint(ui, rect, part_of(rect, false), &picture, is_named);
        if let Some((curve, size)) = &curve {
            viewport::show_chart(ui, rect, *size, curve);
        }
        if mode == ViewMode::Wipe {
            wipe::paint(ui, rect, share);
        }
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
        let picture = Picture { texture, name: "Difference", notes: Vec::new(), label, reserved: 0.0, problem };
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
        let (picture, details) = match (self.editor.view.mode.has_final(), snapshot) {
            (true, Some(snapshot)) => {
                let details = status::final_details(snapshot, stop);
                let shown = if self.editor.view.mode.has_preview() {
                    format!("\n\n{preview} on {adapter}\n{graph}")
                } else {
                    String::new()
                };
                let details = format!("Final view, {width} × {height}\n{details}{shown}");
                (format!("Final   {}", status::final_text(snapshot, stop)), details)
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
        Status { loading: self.loader.text(), info: self.messages.last_info().to_owned(), picture, details }
    }
}
