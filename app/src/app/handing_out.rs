//! Contact sheets and packs of the open library: asking where to, and what became of them.

use super::App;
use crate::dialogs::Purpose;
use crate::library::export::Product;
use crate::work::{Ends, Work};
use egui::Context;
use std::path::{Path, PathBuf};

impl App {
    /// The name to propose for a sheet or pack of the open library.
    pub(super) fn hand_out_name(&self, purpose: Purpose) -> String {
        let name = self.library().and_then(|library| library.root().file_name()).unwrap_or_default().to_string_lossy();
        if purpose == Purpose::SaveSheet { format!("{name}.html") } else { format!("{name}-pack") }
    }

    /// Makes a sheet or pack of the open library.
    pub(super) fn hand_out(&mut self, purpose: Purpose, path: PathBuf, ctx: &Context) {
        if self.library_work.export.is_some() {
            return self.messages.warning("A sheet or pack is still being made; try again when it is done.");
        }
        let product = match purpose {
            Purpose::SaveSheet if has_ending(&path, &["html", "htm", "png"]) => Product::Sheet(path),
            Purpose::SaveSheet => Product::Sheet(PathBuf::from(format!("{}.html", path.display()))),
            _ => Product::Pack(path),
        };
        // What is edited comes first, so not on all threads.
        let threads = std::thread::available_parallelism().map_or(1, |n| n.get().div_ceil(2));
        let wake = ctx.clone();
        self.library_work.export =
            self.library().and_then(|library| library.export(product, threads, move || wake.request_repaint()));
        if self.library_work.export.is_none() {
            self.messages.warning("The library is still being read; try again in a moment.");
        }
    }

    /// Says what became of a sheet or pack. Once per frame.
    pub(super) fn collect_hand_out(&mut self) {
        let Some(outcome) = self.library_work.export.as_ref().and_then(|export| export.poll()) else { return };
        self.library_work.export = None;
        match outcome {
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
        let (what, share) = self.library_work.export.as_ref()?.stage();
        let text = if what.is_empty() { "Library".to_owned() } else { format!("Library: {}", what.to_lowercase()) };
        Some(Work { progress: Some(share), ends: Some(Ends::HandOut), ..Work::new(text) })
    }

    /// Ends making it.
    pub(super) fn end_hand_out(&mut self) {
        if let Some(export) = &self.library_work.export {
            export.cancel();
        }
    }
}

fn has_ending(path: &Path, endings: &[&str]) -> bool {
    path.extension().is_some_and(|found| endings.iter().any(|ending| found.eq_ignore_ascii_case(ending)))
}
