//! The denoised final view: a thread that denoises the newest samples, and the last picture that it made.

use burnish_renderer::denoise::{Denoised, Denoiser, Guides};
use burnish_renderer::path::{ErrorEstimate, Prepared};
use burnish_renderer::worker::Snapshot;
use egui::Context;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

/// A denoised picture and the samples that it was made from.
#[derive(Clone, Debug)]
pub struct DenoisedPicture {
    /// The raw picture.
    pub raw: Arc<Snapshot>,
    /// The same with denoised pixels.
    pub picture: Arc<Snapshot>,
    /// Who denoised it, as files say it.
    pub denoiser: String,
    /// What error is left.
    pub error: ErrorEstimate,
}

impl DenoisedPicture {
    /// What stands in the picture while it is shown.
    pub fn label(&self) -> String {
        let percent = 100.0 * self.error.relmse.max(0.0).sqrt();
        let name = if self.denoiser == Denoiser::Own.name() { "Burnish" } else { &self.denoiser };
        format!("Denoised ({name}), {} spp, error est. {} %", self.raw.spp, crate::widgets::number::format(percent, 2))
    }
}

/// What the thread shares with the window.
#[derive(Default)]
struct Tray {
    job: Option<Arc<Snapshot>>,
    picture: Option<DenoisedPicture>,
    problem: Option<String>,
    is_closing: bool,
}

struct Shared {
    tray: Mutex<Tray>,
    bell: Condvar,
    /// Request whose pictures are wanted; work on another is given up.
    revision: AtomicU64,
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, Tray> {
        // The tray is whole between two statements, so a panic elsewhere cannot leave it half changed.
        self.tray.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Denoises while it lives; the newest samples win.
pub struct LiveDenoise {
    shared: Arc<Shared>,
    sent: Option<Arc<Snapshot>>,
}

impl LiveDenoise {
    /// Starts the thread, which denoises with `threads` threads.
    pub fn new(ctx: &Context, threads: usize) -> Self {
        let shared = Arc::new(Shared { tray: Mutex::default(), bell: Condvar::new(), revision: AtomicU64::new(0) });
        let (theirs, ctx) = (shared.clone(), ctx.clone());
        std::thread::spawn(move || work(&theirs, &ctx, threads));
        Self { shared, sent: None }
    }

    /// Has these samples denoised unless they already were. Work on samples of an older request ends.
    pub fn send(&mut self, snapshot: &Arc<Snapshot>) {
        if self.sent.as_ref().is_some_and(|sent| Arc::ptr_eq(sent, snapshot)) {
            return;
        }
        self.sent = Some(snapshot.clone());
        self.shared.revision.store(snapshot.revision, Ordering::Relaxed);
        self.shared.lock().job = Some(snapshot.clone());
        self.shared.bell.notify_one();
    }

    /// The last picture, and why Open Image Denoise is not used if it should be.
    pub fn state(&self) -> (Option<DenoisedPicture>, Option<String>) {
        let tray = self.shared.lock();
        (tray.picture.clone(), tray.problem.clone())
    }
}

impl Drop for LiveDenoise {
    fn drop(&mut self) {
        self.shared.lock().is_closing = true;
        // No request has this number: what is being denoised is given up.
        self.shared.revision.store(u64::MAX, Ordering::Relaxed);
        self.shared.bell.notify_one();
    }
}

/// The thread.
fn work(shared: &Shared, ctx: &Context, threads: usize) {
    let (denoiser, problem) = Denoiser::best();
    shared.lock().problem = problem.map(|problem| format!("{problem}; the own filter is used."));
    // Guides do not change while samples are added.
    let mut known: Option<(Arc<Prepared>, Guides)> = None;
    loop {
        let mut open = shared.lock();
        let raw = loop {
            if open.is_closing {
                return;
            }
            if let Some(job) = open.job.take() {
                break job;
            }
            open = shared.bell.wait(open).unwrap_or_else(PoisonError::into_inner);
        };
        drop(open);
        let Some(samples) = &raw.samples else { continue };
        let guides = match known.take() {
            Some((prepared, guides)) if Arc::ptr_eq(&prepared, &samples.prepared) => guides,
            _ => Guides::new(&samples.prepared, raw.width, raw.height),
        };
        let cancel = || shared.revision.load(Ordering::Relaxed) != raw.revision;
        let result = denoiser.run(&samples.input, &guides, threads, &cancel);
        known = Some((samples.prepared.clone(), guides));
        match result {
            Ok(Denoised { pixels, error }) => {
                let pixels = pixels.iter().zip(&raw.pixels).map(|([r, g, b], raw)| [*r, *g, *b, raw[3]]).collect();
                let picture = Arc::new(Snapshot { pixels, ..(*raw).clone() });
                let denoiser = denoiser.name();
                shared.lock().picture = Some(DenoisedPicture { raw, picture, denoiser, error });
            }
            // A newer picture is on its way, or nobody looks any more.
            Err(_) if cancel() => continue,
            Err(problem) => shared.lock().problem = Some(format!("{problem}.")),
        }
        ctx.request_repaint();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use burnish_assets::Environment;
    use burnish_renderer::path::{Settings, StopRules};
    use burnish_renderer::scene::{Camera, EnvironmentLight, Scene};
    use burnish_renderer::worker::Worker;
    use glam::Vec3;
    use std::time::Duration;

    /// Waits for something; gives up after a minute.
    fn wait<T>(mut look: impl FnMut() -> Option<T>) -> T {
        for _ in 0..60_000 {
            if let Some(found) = look() {
                return found;
            }
            std::thread::sleep(Duration::from_millis(1));
        }
        panic!("it never came");
    }

    #[test]
    fn the_picture_says_that_it_is_denoised() {
        let map = Arc::new(Environment { name: String::new(), width: 2, height: 1, texels: vec![[0.5; 3]; 2] });
        let camera = Camera { origin: Vec3::Z, target: Vec3::ZERO, up: Vec3::Y, fov_deg: 30.0 };
        let environment = EnvironmentLight { map, rotation_deg: 0.0, scale: 1.0 };
        let scene = Arc::new(Scene { objects: Vec::new(), environment, camera, max_bounces: 1 });
        let stop = StopRules { spp: Some(8), ..StopRules::default() };
        let worker = Worker::new(1, Box::new(|| {}));
        worker.request(scene, Settings { width: 20, height: 10, seed: 1, threads: 1, stop, is_adaptive: false });
        let done = wait(|| worker.snapshot().filter(|snapshot| snapshot.done.is_some()));
        assert!(done.samples.is_some());
        let mut live = LiveDenoise::new(&Context::default(), 1);
        assert!(live.state().0.is_none());
        live.send(&done);
        let denoised = wait(|| live.state().0);
        assert!(Arc::ptr_eq(&denoised.raw, &done));
        assert_eq!((denoised.picture.spp, denoised.picture.pixels.len()), (8, 200));
        let label = denoised.label();
        assert!(label.starts_with("Denoised (") && label.contains("8 spp") && label.contains("error est."), "{label}");
    }
}
