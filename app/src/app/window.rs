//! Opening the window, and opening it again where the graphics device was lost.

use super::App;
use super::rescue::Rescue;
use super::screenshot::Screenshot;
use crate::dialogs::SystemDialogs;
use crate::places::Places;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Times that a window is opened anew for a lost device, in a row.
const REOPENINGS_MAX: u32 = 3;
/// A window that stood this long has had its device for good.
const LASTING: Duration = Duration::from_secs(60);

/// What the window is to do besides showing files.
#[derive(Clone, Debug, Default)]
pub struct WindowOptions {
    /// Writes a picture of itself there as soon as its content stands, and closes.
    pub screenshot: Option<PathBuf>,
    /// Gives its graphics device up after this long, as a crashing driver does.
    pub loses_device_after: Option<Duration>,
}

/// Why there is no window.
#[derive(Clone, Debug)]
pub enum WindowError {
    /// None could be opened.
    NotOpened(String),
    /// One was open, and no other could be opened in its place; the text says where unsaved changes are.
    Lost(String),
}

/// Opens the window on these files: materials, meshes and environments, told apart by their endings.
///
/// Where the graphics device is lost, the window closes and opens again with everything as it was. An error means that the window could not be
/// opened, which on a machine without any graphics adapter is expected; what was being edited is then written to a file that the error names.
pub fn run(files: Vec<PathBuf>, options: &WindowOptions) -> Result<(), WindowError> {
    let rescue = Rescue::default();
    let (mut reopenings, mut files, mut loses_device_after) = (0, files, options.loses_device_after);
    loop {
        let since = Instant::now();
        let (given, after) = (std::mem::take(&mut files), loses_device_after.take());
        let (screenshot, left) = (options.screenshot.clone(), rescue.clone());
        // Painting with a lost device panics in the window's painter. The application has left everything to `rescue` then, but the event loop
        // cannot be used any more.
        let opened = catch_unwind(AssertUnwindSafe(move || open(given, screenshot, after, left)));
        let opened = match opened {
            Ok(opened) => opened.map_err(|error| error.to_string()),
            Err(_) if rescue.holds_any() => Err("the graphics device was lost".to_owned()),
            Err(panic) => resume_unwind(panic),
        };
        if !rescue.holds_any() {
            return opened.map_err(WindowError::NotOpened);
        }
        reopenings = if since.elapsed() > LASTING { 1 } else { reopenings + 1 };
        if opened.is_err() || reopenings > REOPENINGS_MAX {
            let why = opened.err().unwrap_or_else(|| "the graphics device was lost again and again".to_owned());
            return Err(WindowError::Lost(format!("{why}; {}", rescue.write())));
        }
    }
}

fn open(
    files: Vec<PathBuf>,
    screenshot: Option<PathBuf>,
    loses_device_after: Option<Duration>,
    rescue: Rescue,
) -> Result<(), eframe::Error> {
    let viewport = egui::ViewportBuilder::default()
        .with_title("Burnish")
        .with_app_id("burnish")
        .with_inner_size([1280.0, 800.0])
        .with_min_inner_size([480.0, 300.0])
        .with_icon(icon())
        .with_drag_and_drop(true);
    let mut setup = egui_wgpu::WgpuSetupCreateNew::without_display_handle();
    setup.device_descriptor = Arc::new(burnish_renderer::preview::device_descriptor);
    let wgpu_options = egui_wgpu::WgpuConfiguration { wgpu_setup: setup.into(), ..Default::default() };
    let options = eframe::NativeOptions { viewport, wgpu_options, dithering: false, ..Default::default() };
    eframe::run_native(
        "Burnish",
        options,
        Box::new(move |cc| {
            let mut app = App::new(&cc.egui_ctx, cc.wgpu_render_state.as_ref(), Box::new(SystemDialogs::default()));
            // A window that comes after a lost one goes on with what that one kept.
            if !rescue.holds_any() {
                app = app.keep_in(Places::find(), &cc.egui_ctx);
            }
            app.take_over(rescue, &cc.egui_ctx);
            for file in files {
                app.load_path(&file, &cc.egui_ctx);
            }
            app.screenshot = screenshot.map(Screenshot::new);
            app.loses_device = loses_device_after.map(|after| Instant::now() + after);
            Ok(Box::new(app))
        }),
    )
}

/// A lit ball, drawn by formula so that no binary stands in the source.
fn icon() -> egui::IconData {
    const SIZE: u32 = 64;
    let mut rgba = Vec::with_capacity((SIZE * SIZE * 4) as usize);
    for i in 0..SIZE * SIZE {
        let (x, y) = ((i % SIZE) as f32 - 31.5, (i / SIZE) as f32 - 31.5);
        let r2 = (x * x + y * y) / (30.0 * 30.0);
        let z = (1.0 - r2).max(0.0).sqrt();
        let light = ((-0.5 * x - 0.6 * y) / 30.0 + 0.62 * z).clamp(0.05, 1.0);
        let glint = light.powi(24);
        let alpha = ((1.0 - r2) * 24.0).clamp(0.0, 1.0);
        let shade = |c: f32| (255.0 * (c * light + glint).min(1.0)) as u8;
        rgba.extend([shade(0.95), shade(0.66), shade(0.32), (255.0 * alpha) as u8]);
    }
    egui::IconData { rgba, width: SIZE, height: SIZE }
}
