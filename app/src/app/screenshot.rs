//! A picture of the whole window, written once its content stands: for documentation and for checks.

use super::App;
use crate::editor::ViewMode;
use std::path::PathBuf;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::{Duration, Instant};

/// Samples per pixel that a final view should have reached.
const FINAL_SPP: u32 = 64;
/// After this long the picture is taken as it is.
const PATIENCE: Duration = Duration::from_secs(20);
/// Frames after which a preview and all text have been drawn.
const MIN_FRAMES: u32 = 12;

/// A picture of the window that was asked for.
pub struct Screenshot {
    path: PathBuf,
    frames: u32,
    since: Instant,
    is_asked: bool,
    sender: Sender<std::sync::Arc<egui::ColorImage>>,
    receiver: Receiver<std::sync::Arc<egui::ColorImage>>,
}

impl Screenshot {
    /// To be written to `path`.
    pub fn new(path: PathBuf) -> Self {
        let (sender, receiver) = channel();
        Self { path, frames: 0, since: Instant::now(), is_asked: false, sender, receiver }
    }
}

impl App {
    /// Takes the picture when the content stands, writes it and closes the window.
    pub(super) fn mind_the_screenshot(&mut self, ctx: &egui::Context) {
        let is_ready = self.is_content_ready();
        let Some(screenshot) = &mut self.screenshot else { return };
        screenshot.frames += 1;
        if let Ok(image) = screenshot.receiver.try_recv() {
            if let Err(problem) = write(&screenshot.path, &image) {
                eprintln!("{problem}");
            }
            self.screenshot = None;
            self.is_closing = true;
            ctx.send_viewport_cmd(egui::ViewportCommand::Close);
            return;
        }
        let is_late = screenshot.since.elapsed() > PATIENCE;
        if !screenshot.is_asked && screenshot.frames > MIN_FRAMES && (is_ready || is_late) {
            screenshot.is_asked = true;
            let sender = screenshot.sender.clone();
            let wake = ctx.clone();
            ctx.request_screenshot(move |image| {
                let _ = sender.send(image);
                wake.request_repaint();
            });
        }
        ctx.request_repaint_after(Duration::from_millis(30));
    }

    fn is_content_ready(&self) -> bool {
        if self.loader.is_busy() || self.editor.model.is_none() || self.editor.environment.is_none() {
            return false;
        }
        let is_preview_ready = self.preview.problem().is_some() || !self.preview.is_owing();
        let is_final_ready = self
            .final_view
            .as_ref()
            .and_then(|view| view.current())
            .is_some_and(|snapshot| snapshot.done.is_some() || snapshot.spp >= FINAL_SPP);
        match self.editor.view.mode {
            ViewMode::Preview => is_preview_ready,
            ViewMode::Final => is_final_ready,
            ViewMode::Both | ViewMode::Wipe | ViewMode::Difference => is_preview_ready && is_final_ready,
        }
    }
}

fn write(path: &std::path::Path, image: &egui::ColorImage) -> Result<(), String> {
    use image::ImageEncoder as _;
    let mut bytes = Vec::new();
    let [width, height] = image.size.map(|side| side as u32);
    let rgb: Vec<u8> = image.pixels.iter().flat_map(|p| [p.r(), p.g(), p.b()]).collect();
    image::codecs::png::PngEncoder::new(&mut bytes)
        .write_image(&rgb, width, height, image::ExtendedColorType::Rgb8)
        .map_err(|error| format!("{}: the picture could not be encoded: {error}", path.display()))?;
    crate::files::save_atomic(path, &bytes).map_err(|error| error.to_string())
}
