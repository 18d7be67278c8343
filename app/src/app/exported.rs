//! What comes of pictures and turntables in the background, and whether the window may close before that.

use super::App;
use super::exporting::Exporting;
use super::pages::{Answer, question};
use crate::live_export::{News, Row, due};
use crate::live_final::LiveFinal;
use crate::offline::OfflineError;
use crate::offline::turntable::Begun;
use crate::panels::export::turntable::percent;
use crate::work::Ends;
use egui::Context;
use std::time::Duration;

impl App {
    /// Whether the window stays open until it is said what becomes of a rendering.
    pub(super) fn asks_to_end_rendering(&mut self) -> bool {
        let live = &self.exporting.live;
        self.exporting.is_asking = live.waiting().len() > 0 || live.now().is_some() && !live.is_ending();
        self.exporting.is_asking
    }

    /// Asks before closing whether a rendering is to end.
    pub(super) fn ask_about_rendering(&mut self, ctx: &Context) {
        let waiting = self.exporting.live.waiting().len();
        self.exporting.is_asking &= waiting > 0 || !self.can_render();
        if !self.exporting.is_asking {
            return;
        }
        let answers = [("End it and quit", "A turntable goes on from there another day"), ("Go on rendering", "")];
        let is_rendering = !self.can_render();
        let answer = question(ctx, "Still rendering", &answers, |ui| {
            if is_rendering {
                ui.label("A picture or turntable is being rendered.");
            }
            match waiting {
                0 => {}
                1 => _ = ui.label("1 more waits in the queue and would not be made."),
                _ => _ = ui.label(format!("{waiting} more wait in the queue and would not be made.")),
            }
        });
        match answer {
            Answer::Waiting => return,
            Answer::Chosen(0) => {
                self.exporting.live.remove_all();
                self.end_work(Ends::Export, ctx);
                self.close_window(ctx);
            }
            Answer::Chosen(_) | Answer::None => {}
        }
        self.exporting.is_asking = false;
    }

    /// Takes what was made in the background.
    pub(super) fn collect_exports(&mut self, ctx: &Context) {
        if !self.exporting.live.is_heavy() && self.final_view.as_ref().is_some_and(LiveFinal::is_held) {
            // Everything is told to it again.
            self.sent = None;
        }
        if !self.can_render() {
            // The thread may know only a window that was opened anew since.
            ctx.request_repaint_after(Duration::from_millis(250));
        }
        for news in self.exporting.live.collect() {
            self.take_export_news(news);
        }
        self.go_on_exporting(ctx);
        if let Some(begun) = self.exporting.looking.poll() {
            self.looked_into_folder(begun.unwrap_or_default(), ctx);
        }
    }

    fn take_export_news(&mut self, news: News) {
        let Exporting { panel, table, unwritten: kept, .. } = &mut self.exporting;
        let is_shown = panel.folder.as_ref() == Some(&table.folder);
        match news {
            News::Warning(sentence) => self.messages.warning(sentence),
            News::Rows(rows) => {
                if is_shown {
                    panel.rows.clone_from(&rows);
                }
                table.rows = rows;
            }
            News::Row(place, row) => {
                if let Some(old) = panel.rows.get_mut(place).filter(|_| is_shown) {
                    old.clone_from(&row);
                }
                if let Some(old) = table.rows.get_mut(place) {
                    *old = row;
                }
            }
            News::Wrote(files, text) => {
                let names: Vec<String> = files.iter().map(|path| path.display().to_string()).collect();
                self.messages.info(format!("Wrote {}: {text}", names.join(", ")));
                panel.last = files.into_iter().next().map(|path| (path, text));
            }
            News::Predicted(Some(prediction), due) => {
                self.messages.info(prediction.text(due));
                panel.prediction = Some((prediction, due)).filter(|_| is_shown);
            }
            News::Predicted(None, _) => self.messages.info("All frames are finished: there is nothing to predict."),
            News::Ended(done, all) => {
                if is_shown {
                    panel.prediction = None;
                }
                let (limited, _) = due(&table.rows, &table.rules);
                let goal = table.rules.relmse.map_or_else(String::new, |relmse| format!(" to {}", percent(relmse)));
                let more = match (done == all, limited) {
                    (true, _) => String::new(),
                    (false, 0) => "; starting again goes on from there".to_owned(),
                    (false, limited) => format!("; {limited} hit their time limit and can be resumed{goal}"),
                };
                let folder = table.folder.display();
                self.messages.info(format!("Turntable in {folder}: {done} of {all} frames are finished{more}."));
            }
            News::Unwritten(unwritten, error) => {
                self.messages.error(format!("Not written: {error}. The picture is kept; the Export panel writes it elsewhere."));
                panel.has_unwritten = true;
                *kept = Some(unwritten);
            }
            News::Failed(OfflineError::Cancelled) => self.messages.info("Rendering was ended; nothing was written."),
            News::Failed(error) => self.messages.error(format!("Not rendered: {error}")),
        }
    }

    /// Takes the settings and frames of a turntable that was begun in the folder; what asked for the folder goes on.
    fn looked_into_folder(&mut self, begun: Option<(Begun, Vec<Row>)>, ctx: &Context) {
        if let Some((begun, rows)) = begun {
            self.messages.info(format!("The folder has a turntable of {} frames, which can go on.", begun.frames));
            let panel = &mut self.exporting.panel;
            (panel.frames, panel.turn, panel.degrees) = (begun.frames, begun.turn, begun.degrees);
            (panel.format, panel.size, panel.options) = (begun.format, Some(begun.size), begun.options);
            panel.rows = rows;
        }
        if let Some(action) = self.exporting.after_folder.take() {
            self.export(action, ctx);
        }
    }
}
