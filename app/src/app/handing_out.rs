//! Contact sheets and packs of the open library: asking where to, and what became of them.

use super::App;
use crate::dialogs::Purpose;
use crate::library::export::Product;
use crate::panels::pack_page;
use crate::work::{Ends, Work};
use egui::{Context, Ui};
use std::path::{Path, PathBuf};

impl App {
    /// The page before a pack; whether it stays open.
    pub(super) fn pack_page(&mut self, ui: &mut Ui) -> bool {
        let is_asked = pack_page::show(ui, &mut self.library_work.formats);
        if is_asked {
            let ctx = ui.ctx().clone();
            self.ask(Purpose::SavePack, &ctx);
        }
        !is_asked
    }

    /// The name to propose for a sheet or pack of the open library.
    pub(super) fn hand_out_name(&self, purpose: Purpose) -> String {
        let name = self.library().and_then(|library| library.root().file_name()).unwrap_or_default().to_string_lossy();
        if purpose == Purpose::SaveSheet { format!("{name}.html") } else { format!("{name}-pack") }
    }

    /// Makes a sheet or pack of the open library.
    pub(super) fn hand_out(&mut self, purpose: Purpose, path: PathBuf, ctx: &Context) {
        if self.library_work.export.is_running() {
            return self.messages.warning("A sheet or pack is still being made; try again when it is done.");
        }
        let product = match purpose {
            Purpose::SaveSheet if has_ending(&path, &["html", "htm", "png"]) => Product::Sheet(path),
            Purpose::SaveSheet => Product::Sheet(PathBuf::from(format!("{}.html", path.display()))),
            _ => Product::Pack(path, self.library_work.formats),
        };
        // What is edited comes first, so not on all threads.
        let threads = std::thread::available_parallelism().map_or(1, |n| n.get().div_ceil(2));
        let Some(order) = self.library().and_then(|library| library.export(product, threads)) else {
            return self.messages.warning("The library is still being read; try again in a moment.");
        };
        self.library_work.export.start("Library", ctx, move |control| {
            order.run(&|stage, progress| control.tell_stage(stage, progress.done, progress.total), &|| control.is_cancelled())
        });
    }

    /// Says what became of a sheet or pack. Once per frame.
    pub(super) fn collect_hand_out(&mut self) {
        let Some(outcome) = self.library_work.export.poll() else { return };
        match outcome.unwrap_or_else(|_| Err("nothing was made, because the program failed at it".to_owned())) {
            Ok(Some((sentence, warnings))) => {
                warnings.into_iter().for_each(|warning| self.messages.warning(warning));
                self.messages.info(sentence);
            }
            Ok(None) => self.messages.info("Ended; nothing was written, and the pictures that were made are kept."),
            Err(problem) => self.messages.error(problem),
        }
    }

    /// The sheet or pack that is being made.
    pub(super) fn hand_out_work(&self) -> Option<Work> {
        self.library_work.export.work(Ends::HandOut)
    }

    /// Ends making it.
    pub(super) fn end_hand_out(&mut self) {
        self.library_work.export.end();
    }
}

fn has_ending(path: &Path, endings: &[&str]) -> bool {
    path.extension().is_some_and(|found| endings.iter().any(|ending| found.eq_ignore_ascii_case(ending)))
}
