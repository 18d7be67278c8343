//! The GPU preview inside the window: its device, its texture in egui, and why there is none.

use burnish_renderer::preview::Preview;
use burnish_renderer::scene::Scene;
use burnish_renderer::tonemap::Display;
use egui_wgpu::{RenderState, wgpu};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

/// The preview, or the sentence that says why there is none.
pub struct LivePreview {
    state: Result<Gpu, String>,
    /// What the device complained about while running.
    complaint: Arc<Mutex<Option<String>>>,
    is_refining: bool,
    pace: Pace,
}

/// How long frames take, so that a slow adapter draws fewer pixels while the mouse is down.
#[derive(Clone, Copy, Debug, Default)]
struct Pace {
    /// Seconds per million pixels, smoothed; 0 before the first measurement.
    seconds_per_megapixel: f64,
    /// When the last frame was drawn, and of how many million pixels.
    last: Option<(Instant, f64)>,
}

/// A frame that takes longer than this feels slow under the hand.
const SMOOTH_SECONDS: f64 = 0.06;

impl Pace {
    /// The divisor of width and height that keeps a frame below [`SMOOTH_SECONDS`].
    fn divisor(&self, megapixels: f64) -> u32 {
        let seconds = self.seconds_per_megapixel * megapixels;
        [1, 2, 3].into_iter().find(|d| seconds / f64::from(d * d) < SMOOTH_SECONDS).unwrap_or(4)
    }

    /// Notes that a frame begins. Frames in a row tell how long one takes; after a pause they tell nothing.
    fn begin(&mut self, megapixels: f64) {
        let now = Instant::now();
        if let Some((since, drawn)) = self.last {
            let seconds = (now - since).as_secs_f64();
            if drawn > 0.0 && seconds < 2.0 {
                let measured = seconds / drawn;
                let old = self.seconds_per_megapixel;
                self.seconds_per_megapixel = if old == 0.0 { measured } else { 0.6 * old + 0.4 * measured };
            }
        }
        self.last = Some((now, megapixels));
    }
}

struct Gpu {
    preview: Preview,
    render_state: RenderState,
    texture: Option<egui::TextureId>,
    /// What the target was drawn for; `None` when something changed since.
    drawn: Option<((u32, u32), Display)>,
    has_scene: bool,
}

impl LivePreview {
    /// Makes the preview on the window's device. Without one, or where it does not suffice, that is a state to show.
    pub fn new(render_state: Option<&RenderState>) -> Self {
        let complaint: Arc<Mutex<Option<String>>> = Arc::default();
        let state = match render_state {
            None => Err("this window has no GPU device".to_owned()),
            Some(render_state) => Preview::new(&render_state.device, &render_state.queue).map_err(|error| error.to_string()).map(|preview| {
                let sink = complaint.clone();
                render_state.device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
                    sink.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert_with(|| error.to_string());
                }));
                Gpu { preview, render_state: render_state.clone(), texture: None, drawn: None, has_scene: false }
            }),
        };
        Self { state, complaint, is_refining: false, pace: Pace::default() }
    }

    /// A preview that is switched off, with the reason.
    pub fn off(reason: impl Into<String>) -> Self {
        Self { state: Err(reason.into()), complaint: Arc::default(), is_refining: false, pace: Pace::default() }
    }

    /// Why there is no preview.
    pub fn problem(&self) -> Option<&str> {
        self.state.as_ref().err().map(String::as_str)
    }

    /// What is not as it should be although the preview draws.
    pub fn complaint(&self) -> Option<String> {
        self.state.as_ref().ok()?.preview.error().map(ToString::to_string)
    }

    /// Name of the graphics adapter.
    pub fn adapter(&self) -> Option<String> {
        self.state.as_ref().ok().map(|gpu| gpu.render_state.adapter.get_info().name)
    }

    /// Tells the preview what to draw from now on.
    pub fn set_scene(&mut self, scene: &Scene) {
        if let Ok(gpu) = &mut self.state {
            gpu.preview.set_scene(&gpu.render_state.device, &gpu.render_state.queue, scene);
            gpu.drawn = None;
            gpu.has_scene = true;
        }
    }

    /// Draws one more frame if there is anything to draw, and returns the texture to show.
    ///
    /// While the user `is_busy` with the mouse, a slow adapter draws fewer pixels; the full number follows.
    pub fn draw(&mut self, (width, height): (u32, u32), display: Display, is_busy: bool) -> Option<egui::TextureId> {
        let complaint = self.complaint.lock().unwrap_or_else(PoisonError::into_inner).take();
        if let Some(complaint) = complaint {
            let first_line = complaint.lines().find(|line| !line.trim().is_empty()).unwrap_or_default().trim().to_owned();
            self.state = Err(format!("the graphics driver refused it: {first_line}"));
        }
        let Ok(gpu) = &mut self.state else { return None };
        if !gpu.has_scene || width == 0 || height == 0 {
            return None;
        }
        let divisor = if is_busy { self.pace.divisor(f64::from(width) * f64::from(height) * 1e-6) } else { 1 };
        let (width, height) = ((width / divisor).max(1), (height / divisor).max(1));
        if gpu.drawn == Some(((width, height), display)) && !self.is_refining {
            self.pace.last = None;
            return gpu.texture;
        }
        self.pace.begin(f64::from(width) * f64::from(height) * 1e-6);
        let RenderState { device, queue, renderer, .. } = &gpu.render_state;
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("preview") });
        self.is_refining = gpu.preview.draw(device, queue, &mut encoder, width, height, display);
        queue.submit([encoder.finish()]);
        if let Some(view) = gpu.preview.display_view() {
            let mut renderer = renderer.write();
            let filter = wgpu::FilterMode::Linear;
            match gpu.texture {
                Some(id) => renderer.update_egui_texture_from_wgpu_texture(device, view, filter, id),
                None => gpu.texture = Some(renderer.register_native_texture(device, view, filter)),
            }
        }
        gpu.drawn = Some(((width, height), display));
        gpu.texture
    }

    /// Whether further frames would refine the picture.
    pub fn is_refining(&self) -> bool {
        self.state.is_ok() && self.is_refining
    }

    /// Size and linear radiance of the last frame, for export.
    pub fn read_linear(&mut self) -> Result<(u32, u32, Vec<[f32; 4]>), String> {
        let gpu = self.state.as_mut().map_err(|reason| reason.clone())?;
        let Some(((width, height), _)) = gpu.drawn else { return Err("the preview has not drawn yet".into()) };
        let pixels = gpu.preview.read_linear(&gpu.render_state.device, &gpu.render_state.queue).map_err(|error| error.to_string())?;
        Ok((width, height, pixels))
    }
}
