//! A lost graphics device: the window hands everything to the next one and closes.

use super::App;
use crate::editor::Editor;
use crate::files;
use crate::history::History;
use crate::loading::Loader;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Where a material goes that no window can be opened for.
const RESCUED_FILE: &str = "burnish-rescued.asm.ron";

/// What one window leaves to the next; shared by both.
#[derive(Clone, Default)]
pub(super) struct Rescue(Arc<Mutex<Option<Rescued>>>);

/// All that is not on the device.
struct Rescued {
    editor: Editor,
    history: History,
    why: String,
}

impl Rescue {
    fn lock(&self) -> MutexGuard<'_, Option<Rescued>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Whether a window has left something.
    pub fn holds_any(&self) -> bool {
        self.lock().is_some()
    }

    /// Writes what cannot be shown any more, and says where it is.
    pub fn write(&self) -> String {
        let Some(rescued) = self.lock().take() else { return String::new() };
        let document = &rescued.editor.document;
        if !document.is_modified() {
            return "no unsaved changes are lost".to_owned();
        }
        let mut path = document.path().and_then(Path::parent).map_or_else(PathBuf::new, Path::to_path_buf).join(RESCUED_FILE);
        for number in 2.. {
            if !path.exists() {
                break;
            }
            path.set_file_name(format!("burnish-rescued-{number}.asm.ron"));
        }
        match files::save_atomic(&path, document.file().to_text(&document.material).as_bytes()) {
            Ok(()) => format!("unsaved changes were written to {}", path.display()),
            Err(error) => format!("unsaved changes could not be written: {error}"),
        }
    }
}

impl App {
    /// Goes on with what an earlier window has left, and leaves to later ones through the same hands.
    pub(super) fn take_over(&mut self, rescue: Rescue) {
        let left = rescue.lock().take();
        self.rescue = rescue;
        let Some(Rescued { editor, history, why }) = left else { return };
        // With a model and a light at hand nothing has to be loaded.
        if editor.model.is_some() && editor.environment.is_some() {
            self.loader = Loader::default();
        }
        (self.editor, self.history) = (editor, history);
        self.messages.warning(format!("The graphics device was lost ({why}); the window was opened anew, and nothing is lost."));
    }

    /// Leaves everything to the next window and closes, if the device is gone. Nothing is painted any more then: the window's painter panics on
    /// a lost device.
    pub(super) fn has_lost_device(&mut self, ctx: &egui::Context) -> bool {
        if let Some(when) = self.loses_device {
            if Instant::now() >= when {
                self.loses_device = None;
                self.preview.lose_device();
            }
            ctx.request_repaint_after(Duration::from_millis(50));
        }
        if self.preview.loss().is_none() {
            return false;
        }
        if !self.is_closing {
            self.leave();
            self.is_closing = true;
            ctx.send_viewport_cmd(egui::ViewportCommand::Close);
        }
        ctx.graphics_mut(|graphics| *graphics = egui::layers::GraphicLayers::default());
        true
    }

    /// Leaves everything to the next window if the device is gone.
    fn leave(&mut self) {
        let Some(why) = self.preview.loss() else { return };
        self.history.settle();
        let (editor, history) = (std::mem::take(&mut self.editor), self.history.clone());
        self.rescue.lock().get_or_insert(Rescued { editor, history, why });
    }
}

impl Drop for App {
    fn drop(&mut self) {
        // Whoever paints with a lost device may panic before the window closes.
        if std::thread::panicking() {
            self.leave();
        }
    }
}
