//! The final view while it runs: requests to the worker, its newest picture, and that picture developed for the screen.
//!
//! Developing (exposure and display transform of every pixel) takes longer than a frame may, so a thread does it.

use burnish_renderer::path::Settings;
use burnish_renderer::scene::Scene;
use burnish_renderer::tonemap::Display;
use burnish_renderer::worker::{Snapshot, Worker};
use egui::{ColorImage, Context, TextureHandle, TextureOptions};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use crate::editor::View;
use crate::live_denoise::{DenoisedPicture, LiveDenoise};

/// A request that has produced nothing yet is given this long before a newer one takes its place. Otherwise a slow
/// machine would show nothing for as long as a slider moves.
const PATIENCE: Duration = Duration::from_millis(150);

/// Random stream of all pictures: what is dragged keeps the pattern of its noise.
pub const SEED: u64 = 0;

/// The worker and what it has shown so far.
pub struct LiveFinal {
    worker: Worker,
    threads: usize,
    pending: Option<(Arc<Scene>, Settings)>,
    requested: Option<(u64, Instant)>,
    snapshot: Option<Arc<Snapshot>>,
    developer: Developer,
    sent: Option<(Arc<Snapshot>, Display)>,
    texture: Option<TextureHandle>,
    /// What the texture says about itself, where it is denoised.
    label: Option<String>,
    /// The newest picture with samples for a denoiser.
    sampled: Option<Arc<Snapshot>>,
    /// There while denoising is switched on.
    denoise: Option<LiveDenoise>,
    denoised: Option<DenoisedPicture>,
    problem: Option<String>,
    is_held: bool,
}

impl LiveFinal {
    /// Starts the threads: one per core unless told otherwise. The window needs little, and gets it as what wakes up comes before what runs all
    /// the time.
    pub fn new(ctx: &Context, threads: Option<usize>) -> Self {
        let threads = threads.unwrap_or_else(|| std::thread::available_parallelism().map_or(1, std::num::NonZero::get));
        let repaint = ctx.clone();
        Self {
            worker: Worker::new(threads, Box::new(move || repaint.request_repaint())),
            threads,
            pending: None,
            requested: None,
            snapshot: None,
            developer: Developer::new(ctx.clone()),
            sent: None,
            texture: None,
            label: None,
            sampled: None,
            denoise: None,
            denoised: None,
            problem: None,
            is_held: false,
        }
    }

    /// Asks for a picture of this scene; the newest request wins.
    pub fn request(&mut self, scene: Arc<Scene>, (width, height): (usize, usize), view: &View) {
        let settings = Settings { width, height, seed: SEED, threads: self.threads, stop: view.stop, is_adaptive: true };
        self.pending = Some((scene, settings));
        self.is_held = false;
    }

    /// Stops working. The last picture goes: by the time the view is shown again, it may be of another scene and another shape.
    pub fn pause(&mut self) {
        self.pending = None;
        self.is_held = false;
        self.requested = None;
        self.worker.pause();
        (self.snapshot, self.sampled, self.denoised) = (None, None, None);
        (self.texture, self.sent, self.label) = (None, None, None);
    }

    /// Stops working on a picture that is not finished, and keeps it: the threads are wanted elsewhere. The next request begins again.
    pub fn hold(&mut self) {
        self.is_held = self.requested.is_some() && self.snapshot.as_ref().is_none_or(|snapshot| snapshot.done.is_none());
        if self.is_held {
            self.pending = None;
            self.worker.pause();
        }
    }

    /// Whether a picture was left unfinished by [`Self::hold`].
    pub fn is_held(&self) -> bool {
        self.is_held
    }

    /// Sends what is pending, takes the newest picture and has it developed, denoised if that is switched on and done. Once per frame.
    pub fn update(&mut self, ctx: &Context, display: Display, is_denoise_on: bool) {
        // After a pause the worker may still hold a picture of before.
        let requested = self.requested.map(|(revision, _)| revision);
        let is_wanted = |revision| self.snapshot.is_some() || requested.is_some_and(|requested| revision >= requested);
        if let Some(snapshot) = self.worker.snapshot().filter(|snapshot| is_wanted(snapshot.revision)) {
            if snapshot.samples.is_some() {
                self.sampled = Some(snapshot.clone());
            }
            self.snapshot = Some(snapshot);
        }
        let shown = self.snapshot.as_ref().map_or(0, |snapshot| snapshot.revision);
        let is_waiting = self.requested.is_some_and(|(revision, since)| shown < revision && since.elapsed() < PATIENCE);
        if self.pending.is_some() && is_waiting {
            ctx.request_repaint_after(PATIENCE / 3);
        } else if let Some((scene, settings)) = self.pending.take() {
            self.requested = Some((self.worker.request(scene, settings), Instant::now()));
        }

        self.denoise(ctx, is_denoise_on);
        let label = self.denoised.as_ref().map(DenoisedPicture::label);
        if let Some(snapshot) = self.denoised.as_ref().map(|denoised| &denoised.picture).or(self.snapshot.as_ref()) {
            let is_sent = self.sent.as_ref().is_some_and(|(sent, by)| Arc::ptr_eq(sent, snapshot) && *by == display);
            if !is_sent {
                self.developer.send((snapshot.clone(), display, label));
                self.sent = Some((snapshot.clone(), display));
            }
        }
        if let Some((image, label)) = self.developer.take().filter(|_| self.sent.is_some()) {
            self.label = label;
            // Blocks of a coarse picture would flicker while a camera is dragged; the status line says how far it is.
            match &mut self.texture {
                Some(texture) => texture.set(image, TextureOptions::LINEAR),
                None => self.texture = Some(ctx.load_texture("final view", image, TextureOptions::LINEAR)),
            }
        }
    }

    /// Has the newest samples denoised. A denoised picture stays while samples are added to those it was made from; when the scene changes, the
    /// raw picture comes back until there is a new one.
    fn denoise(&mut self, ctx: &Context, is_on: bool) {
        self.denoised = None;
        self.problem = None;
        let Some(snapshot) = self.snapshot.as_ref().filter(|_| is_on) else {
            self.denoise = None;
            return;
        };
        let live = self.denoise.get_or_insert_with(|| LiveDenoise::new(ctx, self.threads));
        if let Some(sampled) = self.sampled.as_ref().filter(|sampled| sampled.revision == snapshot.revision) {
            live.send(sampled);
        }
        let (picture, problem) = live.state();
        self.denoised = picture.filter(|picture| picture.raw.revision == snapshot.revision);
        self.problem = problem;
    }

    /// What the developed picture says about itself: that it is denoised, by whom and with what error. `None` for the raw picture.
    pub fn label(&self) -> Option<&str> {
        self.label.as_deref()
    }

    /// Why denoising is not done as it should be.
    pub fn problem(&self) -> Option<&str> {
        self.problem.as_deref()
    }

    /// The denoised picture that is shown, or about to be.
    pub fn denoised(&self) -> Option<&DenoisedPicture> {
        self.denoised.as_ref()
    }

    /// The developed picture.
    pub fn texture(&self) -> Option<&TextureHandle> {
        self.texture.as_ref()
    }

    /// Number of the newest request that was sent; `None` before the first and while the view is paused.
    pub fn revision(&self) -> Option<u64> {
        self.requested.map(|(revision, _)| revision)
    }

    /// The newest picture of the newest request, with its numbers.
    pub fn current(&self) -> Option<&Arc<Snapshot>> {
        let (revision, _) = self.requested?;
        self.snapshot.as_ref().filter(|snapshot| self.pending.is_none() && snapshot.revision >= revision)
    }

    /// The newest picture, even of an older request.
    pub fn newest(&self) -> Option<&Arc<Snapshot>> {
        self.snapshot.as_ref()
    }
}

/// What the developing thread shares with the window.
#[derive(Default)]
struct Tray {
    job: Option<DevelopJob>,
    image: Option<(ColorImage, Option<String>)>,
    is_closing: bool,
}

/// A picture, how it is shown, and the label that goes with it.
type DevelopJob = (Arc<Snapshot>, Display, Option<String>);

/// A thread that turns radiance into screen colours; the newest job wins.
struct Developer {
    shared: Arc<(Mutex<Tray>, Condvar)>,
}

fn lock(tray: &Mutex<Tray>) -> MutexGuard<'_, Tray> {
    // The tray is whole between two statements, so a panic elsewhere cannot leave it half changed.
    tray.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Developer {
    fn new(ctx: Context) -> Self {
        let shared: Arc<(Mutex<Tray>, Condvar)> = Arc::default();
        let theirs = shared.clone();
        std::thread::spawn(move || {
            let (tray, bell) = &*theirs;
            loop {
                let mut open = lock(tray);
                let (snapshot, display, label) = loop {
                    if open.is_closing {
                        return;
                    }
                    if let Some(job) = open.job.take() {
                        break job;
                    }
                    open = bell.wait(open).unwrap_or_else(PoisonError::into_inner);
                };
                drop(open);
                let image = develop(&snapshot, display);
                lock(tray).image = Some((image, label));
                ctx.request_repaint();
            }
        });
        Self { shared }
    }

    fn send(&self, job: DevelopJob) {
        lock(&self.shared.0).job = Some(job);
        self.shared.1.notify_one();
    }

    fn take(&self) -> Option<(ColorImage, Option<String>)> {
        lock(&self.shared.0).image.take()
    }
}

impl Drop for Developer {
    fn drop(&mut self) {
        lock(&self.shared.0).is_closing = true;
        self.shared.1.notify_one();
    }
}

fn develop(snapshot: &Snapshot, display: Display) -> ColorImage {
    let pixels = snapshot.pixels.iter().map(|p| {
        let [r, g, b] = display.apply_u8([p[0], p[1], p[2]]);
        egui::Color32::from_rgb(r, g, b)
    });
    let (width, height) = (snapshot.width, snapshot.height);
    let mut pixels: Vec<_> = pixels.collect();
    // The image type asserts this; a picture that disagrees with itself is shown padded rather than not at all.
    pixels.resize(width * height, egui::Color32::BLACK);
    ColorImage::new([width, height], pixels)
}
