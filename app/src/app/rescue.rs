//! A lost graphics device: the window hands everything to the next one and closes.

use super::App;
use super::exporting::Exporting;
use super::keeping::Keeping;
use crate::dock::Dock;
use crate::editor::{Document, Editor};
use crate::files;
use crate::history::History;
use crate::keymap::Keymap;
use crate::loading::Loader;
use crate::preferences::Preferences;
use crate::sides::Sides;
use crate::tabs::Tabs;
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
    sides: Sides,
    tabs: Tabs,
    preferences: Preferences,
    keymap: Keymap,
    dock: Dock,
    keeping: Keeping,
    exporting: Exporting,
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
        let modified = rescued.tabs.documents(&rescued.editor.document).map(|(_, document)| document);
        let written: Vec<String> = modified.filter(|document| document.is_modified()).map(write).collect();
        if written.is_empty() { "no unsaved changes are lost".to_owned() } else { written.join("; ") }
    }
}

/// Writes a document beside its file, or where it can be found, and says where that is.
fn write(document: &Document) -> String {
    let text = document.file().to_text(&document.material);
    let home = std::env::var_os("HOME").or_else(|| std::env::var_os("USERPROFILE")).map(PathBuf::from);
    let own = document.path().and_then(Path::parent).map(Path::to_path_buf);
    let mut problem = String::new();
    for folder in [own, Some(PathBuf::new()), home, Some(std::env::temp_dir())].into_iter().flatten() {
        let path = free_path(&folder);
        match files::save_atomic(&path, text.as_bytes()) {
            Ok(()) => return format!("unsaved changes were written to {}", path.display()),
            Err(error) => problem = error.to_string(),
        }
    }
    format!("unsaved changes could not be written: {problem}")
}

/// A file of that folder that is not there yet.
fn free_path(folder: &Path) -> PathBuf {
    let numbered = (2..).map(|number| format!("burnish-rescued-{number}.asm.ron"));
    let mut names = std::iter::once(RESCUED_FILE.to_owned()).chain(numbered).map(|name| folder.join(name));
    names.find(|path| !path.exists()).unwrap_or_else(|| folder.join(RESCUED_FILE))
}

impl App {
    /// Goes on with what an earlier window has left, and leaves to later ones through the same hands.
    pub(super) fn take_over(&mut self, rescue: Rescue, ctx: &egui::Context) {
        let left = rescue.lock().take();
        self.rescue = rescue;
        let Some(left) = left else { return };
        // With a model and a light at hand nothing has to be loaded.
        if left.editor.model.is_some() && left.editor.environment.is_some() {
            self.loader = Loader::default();
        }
        (self.editor, self.history, self.sides, self.tabs) = (left.editor, left.history, left.sides, left.tabs);
        (self.preferences, self.keymap, self.dock, self.keeping) = (left.preferences, left.keymap, left.dock, left.keeping);
        self.exporting = left.exporting;
        self.apply_preferences(ctx);
        let why = left.why;
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
        // Asking a lost device may panic, and this may be called while that happens.
        let Some(why) = self.preview.known_loss() else { return };
        self.history.settle();
        let mut lock = self.rescue.lock();
        if lock.is_none() {
            *lock = Some(Rescued {
                editor: std::mem::take(&mut self.editor),
                history: self.history.clone(),
                sides: std::mem::take(&mut self.sides),
                tabs: std::mem::take(&mut self.tabs),
                preferences: self.preferences.clone(),
                keymap: self.keymap.clone(),
                dock: std::mem::take(&mut self.dock),
                keeping: std::mem::take(&mut self.keeping),
                exporting: std::mem::take(&mut self.exporting),
                why,
            });
        }
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
