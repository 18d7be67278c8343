//! The GPU preview inside the window: its device, its texture in egui, and why there is none.

use crate::latency::{Latency, Shown};
use burnish_renderer::preview::{FrameTimes, Preview, PreviewError};
use burnish_renderer::scene::Scene;
use burnish_renderer::tonemap::Display;
use egui_wgpu::{RenderState, wgpu};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// The preview, or the sentence that says why there is none.
pub struct LivePreview {
    state: Result<Gpu, String>,
    /// What the device complained about while running.
    complaint: Arc<Mutex<Option<String>>>,
    /// The window's device, also where the preview cannot use it.
    device: Option<wgpu::Device>,
    /// Why the device is gone, if it is.
    loss: Arc<Mutex<Option<String>>>,
    /// From edits to pictures; the device tells when it has finished one.
    latency: Arc<Mutex<Latency>>,
    /// What width and height are divided by because there is no memory for more, and the size that this is about.
    memory: (u32, (u32, u32)),
    is_refining: bool,
    /// Whether the picture is not yet what it will be.
    is_owing: bool,
    pace: Pace,
}

/// How long frames take, so that a slow adapter draws less while the user is at work.
#[derive(Clone, Copy, Debug, Default)]
struct Pace {
    /// Whether the adapter is a program on the processor. Its work blocks the window, so it can be timed by waiting for it.
    is_software: bool,
    /// Seconds per million pixels, smoothed; 0 before the first measurement.
    seconds_per_megapixel: f64,
    /// When the last frame was drawn, and of how many million pixels; `None` after a pause.
    last: Option<(Instant, f64)>,
}

/// A frame that takes longer than this feels slow under the hand.
const SMOOTH_SECONDS: f64 = 0.06;
/// The hand counts as resting this long after the last event.
pub const REST: Duration = Duration::from_millis(250);
/// What a frame may take after [`REST`], and after a long rest, when nobody waits for the window.
const REST_SECONDS: f64 = 0.4;
const LONG_REST: Duration = Duration::from_millis(1500);
const LONG_REST_SECONDS: f64 = 1.0;
/// What rays may take of a frame on hardware.
const RAY_SECONDS: f64 = 0.010;
/// Most that a picture is made smaller by for want of memory.
const MEMORY_DIVISOR_MAX: u32 = 8;
/// What is assumed of a software adapter before it was measured.
const SOFTWARE_SECONDS_PER_MEGAPIXEL: f64 = 0.8;

impl Pace {
    fn of(adapter: &wgpu::AdapterInfo) -> Self {
        let is_software = adapter.device_type == wgpu::DeviceType::Cpu;
        Self { is_software, seconds_per_megapixel: if is_software { SOFTWARE_SECONDS_PER_MEGAPIXEL } else { 0.0 }, last: None }
    }

    fn is_slow(&self, pixels: (u32, u32)) -> bool {
        self.seconds_per_megapixel * megapixels(pixels) > SMOOTH_SECONDS
    }

    /// The divisor of width and height that keeps a frame below `limit` seconds, at most 5.
    fn divisor(&self, pixels: (u32, u32), limit: f64) -> u32 {
        let seconds = self.seconds_per_megapixel * megapixels(pixels);
        (1..5).find(|d| seconds / f64::from(d * d) < limit).unwrap_or(5)
    }

    fn measured(&mut self, seconds: f64, megapixels: f64) {
        let new = seconds / megapixels.max(1e-3);
        let old = self.seconds_per_megapixel;
        self.seconds_per_megapixel = if old == 0.0 { new } else { 0.5 * (old + new) };
    }

    /// Notes that a frame begins. On hardware, frames in a row tell how long one takes.
    fn begin(&mut self, pixels: (u32, u32)) {
        let now = Instant::now();
        if let Some((since, drawn)) = self.last
            && !self.is_software
        {
            self.measured((now - since).as_secs_f64().min(1.0), drawn);
        }
        self.last = Some((now, megapixels(pixels)));
    }

    /// Waits for the frame where waiting costs nothing, and notes its time.
    /// Returns the seconds where it waited.
    fn end(&mut self, device: &wgpu::Device, is_traced: bool) -> Option<f64> {
        if is_traced && !self.is_software {
            self.last = None;
        }
        let (since, drawn) = self.last.filter(|_| self.is_software)?;
        device.poll(wgpu::PollType::wait_indefinitely()).ok()?;
        let seconds = since.elapsed().as_secs_f64();
        if !is_traced {
            self.measured(seconds, drawn);
        }
        Some(seconds)
    }
}

fn megapixels((width, height): (u32, u32)) -> f64 {
    f64::from(width) * f64::from(height) * 1e-6
}

struct Gpu {
    preview: Preview,
    render_state: RenderState,
    texture: Option<egui::TextureId>,
    /// What the target was drawn for.
    drawn: Option<((u32, u32), Display)>,
    /// Whether the scene changed since.
    is_stale: bool,
    has_scene: bool,
    has_bloom: bool,
}

impl Drop for Gpu {
    fn drop(&mut self) {
        if let Some(id) = self.texture {
            self.render_state.renderer.write().free_texture(&id);
        }
    }
}

fn locked<T>(shared: &Mutex<T>) -> MutexGuard<'_, T> {
    // What is kept is whole between two statements, so a panic elsewhere cannot leave it half changed.
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}

impl LivePreview {
    /// Makes the preview on the window's device. Without one, or where it does not suffice, that is a state to show.
    pub fn new(render_state: Option<&RenderState>) -> Self {
        let complaint: Arc<Mutex<Option<String>>> = Arc::default();
        let loss: Arc<Mutex<Option<String>>> = Arc::default();
        if let Some(RenderState { device, .. }) = render_state {
            let sink = loss.clone();
            device.set_device_lost_callback(move |reason, message| {
                let what = if message.is_empty() { format!("{reason:?}").to_lowercase() } else { message };
                locked(&sink).get_or_insert(what);
            });
        }
        let pace = render_state.map(|state| Pace::of(&state.adapter.get_info())).unwrap_or_default();
        let state = match render_state {
            None => Err("this window has no GPU device".to_owned()),
            Some(render_state) => {
                Preview::new(&render_state.device, &render_state.queue).map_err(|error| error.to_string()).map(|preview| {
                    let sink = complaint.clone();
                    render_state.device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
                        locked(&sink).get_or_insert_with(|| error.to_string());
                    }));
                    Gpu {
                        preview,
                        render_state: render_state.clone(),
                        texture: None,
                        drawn: None,
                        is_stale: true,
                        has_scene: false,
                        has_bloom: false,
                    }
                })
            }
        };
        let (latency, memory) = (Arc::default(), (1, (0, 0)));
        let device = render_state.map(|state| state.device.clone());
        Self { state, complaint, device, loss, latency, memory, is_refining: false, is_owing: false, pace }
    }

    /// A preview that is switched off, with the reason.
    pub fn off(reason: impl Into<String>) -> Self {
        Self { state: Err(reason.into()), ..Self::new(None) }
    }

    /// Why there is no preview.
    pub fn problem(&self) -> Option<&str> {
        self.state.as_ref().err().map(String::as_str)
    }

    /// What is not as it should be although the preview draws.
    pub fn complaint(&self) -> Option<String> {
        let error = self.state.as_ref().ok()?.preview.error();
        match (error, self.memory.0) {
            (Some(error), _) => Some(error.to_string()),
            (None, 1) => None,
            (None, divisor) => {
                Some(format!("Drawn at 1/{divisor} of the resolution: the graphics adapter has no memory for more."))
            }
        }
    }

    /// Why the window's device is gone, if it is: nothing can be drawn with it any more.
    pub fn loss(&self) -> Option<String> {
        if let Some(device) = self.device.as_ref().filter(|_| self.known_loss().is_none()) {
            // The device tells when it is asked, and panics then where its driver has crashed.
            _ = catch_unwind(AssertUnwindSafe(|| device.poll(wgpu::PollType::Poll)));
        }
        self.known_loss()
    }

    /// The same, without asking the device.
    pub fn known_loss(&self) -> Option<String> {
        locked(&self.loss).clone()
    }

    /// The picture is not shown now: how long edits take to reach it counts for nothing.
    pub fn forget_edit(&self) {
        locked(&self.latency).forget();
    }

    /// Whether the device has yet to tell that it has finished the picture of an edit: it does when it is asked.
    pub fn is_finishing(&self) -> bool {
        locked(&self.latency).is_finishing()
    }

    /// Whether threads filter an environment, fill tables or displace meshes for it; it shows the earlier ones meanwhile.
    pub fn is_preparing(&self) -> bool {
        self.state.as_ref().is_ok_and(|gpu| gpu.preview.is_taking())
    }

    /// The last edit that reached the picture, and the worst of the last hundred.
    pub fn latency(&self) -> Option<(Shown, Shown)> {
        locked(&self.latency).last_and_worst()
    }

    /// Gives the device up, as a driver does that crashes or is updated.
    pub fn lose_device(&self) {
        if let Some(device) = &self.device {
            device.destroy();
        }
    }

    /// Switches bloom on the display on or off.
    pub fn set_bloom(&mut self, has_bloom: bool) {
        let Ok(gpu) = &mut self.state else { return };
        if gpu.has_bloom == has_bloom {
            return;
        }
        gpu.has_bloom = has_bloom;
        gpu.drawn = None;
        if let Err(error) = gpu.preview.set_bloom(&gpu.render_state.device, has_bloom) {
            self.state = Err(error.to_string());
        }
    }

    /// Name of the graphics adapter.
    pub fn adapter(&self) -> Option<String> {
        self.state.as_ref().ok().map(|gpu| gpu.render_state.adapter.get_info().name)
    }

    /// Tells the preview what to draw from now on.
    pub fn set_scene(&mut self, scene: &Scene) {
        if let Ok(gpu) = &mut self.state {
            gpu.preview.set_scene(&gpu.render_state.device, &gpu.render_state.queue, scene);
            gpu.is_stale = true;
            gpu.has_scene = true;
            if gpu.drawn.is_some() {
                locked(&self.latency).edited();
            }
        }
    }

    /// Draws one more frame if there is anything to draw, and returns the texture to show.
    ///
    /// `full` is the size of the picture in pixels, `idle` the time since the user did anything. A slow adapter draws what
    /// changed in fewer pixels first, so that the window follows the hand, and more of them the longer the hand rests.
    pub fn draw(&mut self, full: (u32, u32), display: Display, idle: Duration) -> Option<egui::TextureId> {
        let complaint = locked(&self.complaint).take();
        if let Some(complaint) = complaint {
            let first_line = complaint.lines().find(|line| !line.trim().is_empty()).unwrap_or_default().trim().to_owned();
            self.state = Err(format!("the graphics driver refused it: {first_line}"));
        }
        let Ok(gpu) = &mut self.state else { return None };
        if !gpu.has_scene || full.0 == 0 || full.1 == 0 {
            return None;
        }
        let is_new = gpu.is_stale || gpu.drawn.is_none_or(|(_, by)| by != display);
        let is_held_back = !is_new && idle < REST && self.pace.is_slow(full);
        let limit = match idle {
            _ if is_new || idle < REST => SMOOTH_SECONDS,
            idle if idle < LONG_REST => REST_SECONDS,
            _ => LONG_REST_SECONDS,
        };
        if self.memory.1 != full {
            self.memory = (1, full);
        }
        let divisor = self.pace.divisor(full, limit).max(self.memory.0);
        let mut size = ((full.0 / divisor).max(1), (full.1 / divisor).max(1));
        if let Some((drawn, _)) = gpu.drawn
            && !is_new
        {
            // What is finer than it had to be stays, unless the picture's size changed.
            let [across, down] = [(drawn.0, full.1), (drawn.1, full.0)].map(|(a, b)| u64::from(a) * u64::from(b));
            let keeps_shape = across.abs_diff(down) <= u64::from(full.0 + full.1);
            if drawn.0 > size.0 && drawn.0 <= full.0 && keeps_shape {
                size = drawn;
            }
            if is_held_back || (drawn == size && !self.is_refining) {
                self.is_owing = self.is_refining || (drawn != full && self.memory.0 == 1 && idle < LONG_REST + REST);
                self.pace.last = None;
                return gpu.texture;
            }
        }
        // The rays take what a frame may take, at rest more of it.
        gpu.preview.set_patience(if self.pace.is_software { 0.5 * limit } else { RAY_SECONDS });
        self.pace.begin(size);
        let RenderState { device, queue, renderer, .. } = &gpu.render_state;
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("preview") });
        self.is_refining = gpu.preview.draw(device, queue, &mut encoder, size.0, size.1, display);
        queue.submit([encoder.finish()]);
        // With rays a frame takes as long as they are given: that says nothing about the next.
        let waited = self.pace.end(device, gpu.preview.is_traced());
        if let Some(seconds) = waited {
            gpu.preview.took(seconds);
        }
        if matches!(gpu.preview.error(), Some(PreviewError::TooLarge(_))) && self.memory.0 < MEMORY_DIVISOR_MAX {
            // Smaller pictures need less: what was there before has to do for this frame.
            self.memory.0 = 2 * divisor.min(MEMORY_DIVISOR_MAX / 2);
            gpu.preview.forget_error();
            (gpu.drawn, self.is_owing) = (None, true);
            return gpu.texture;
        }
        let edit = locked(&self.latency).drawn(gpu.preview.is_current());
        if let Some(edit) = edit {
            let latency = self.latency.clone();
            let note = move || locked(&latency).finished(edit);
            if waited.is_some() { note() } else { queue.on_submitted_work_done(note) }
        }
        if let Some(view) = gpu.preview.display_view() {
            let mut renderer = renderer.write();
            let filter = wgpu::FilterMode::Linear;
            match gpu.texture {
                Some(id) => renderer.update_egui_texture_from_wgpu_texture(device, view, filter, id),
                None => gpu.texture = Some(renderer.register_native_texture(device, view, filter)),
            }
        }
        gpu.drawn = Some((size, display));
        gpu.is_stale = false;
        self.is_owing = self.is_refining || (size != full && self.memory.0 == 1);
        gpu.texture
    }

    /// Samples per pixel that rays have added to the picture.
    pub fn ray_samples(&self) -> u32 {
        self.state.as_ref().map_or(0, |gpu| gpu.preview.ray_samples())
    }

    /// What the passes of a recent frame took, and why there are no rays, if there are none.
    pub fn frame_graph(&self) -> Option<(&FrameTimes, Option<String>)> {
        let preview = &self.state.as_ref().ok()?.preview;
        Some((preview.times(), preview.rays_problem().map(ToString::to_string)))
    }

    /// Whether the picture is not yet what it will be.
    pub fn is_owing(&self) -> bool {
        self.state.is_ok() && self.is_owing
    }

    /// Size and linear radiance of the last frame, for export.
    pub fn read_linear(&mut self) -> Result<(u32, u32, Vec<[f32; 4]>), String> {
        let gpu = self.state.as_mut().map_err(|reason| reason.clone())?;
        let Some(((width, height), _)) = gpu.drawn else { return Err("the preview has not drawn yet".into()) };
        let pixels =
            gpu.preview.read_linear(&gpu.render_state.device, &gpu.render_state.queue).map_err(|error| error.to_string())?;
        Ok((width, height, pixels))
    }
}
