//! Rendering in the background: the newest request wins, the newest picture is published.
//!
//! A request shows a coarse picture first, as fine as some milliseconds allow, then finer ones, then passes at full resolution until
//! a rule ends them; the finished picture stays until the next request. Within a request no picture is coarser than the one before. Trees and
//! tables are kept from request to request.

use crate::denoise;
use crate::path::render::Run;
use crate::path::{
    ErrorEstimate, ErrorPoint, Film, PassStats, Prepared, SampleCounts, SampleView, Settings, StopReason, render_pass,
    sample_picture,
};
use crate::scene::Scene;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Instant;

/// Pixels of the first coarse picture at most while the speed is not known: well under 100 ms on one thread, also of a busy machine.
const COARSE_PIXELS: usize = 4_096;
/// Seconds that the first picture may take once it is: every picture of a camera being dragged is a first one, so they are all equally fine.
const FIRST_SECONDS: f64 = 0.015;
/// Pixels that it has however slow the scene.
const FIRST_PIXELS: usize = 1_024;

/// A picture on its way to being finished.
#[derive(Clone, Debug)]
pub struct Snapshot {
    /// The request that it belongs to.
    pub revision: u64,
    /// Columns of this picture; the request's divided by `scale`, rounded up.
    pub width: usize,
    /// Rows of this picture.
    pub height: usize,
    /// Linear Rec.709 radiance and coverage, row by row from the top.
    pub pixels: Vec<[f32; 4]>,
    /// Samples per pixel.
    pub spp: u32,
    /// 1: full resolution; 4: a quarter of the columns and rows.
    pub scale: u32,
    /// Seconds of rendering at full resolution.
    pub seconds: f64,
    /// Estimated error.
    pub error: Option<ErrorEstimate>,
    /// Paths per second.
    pub samples_per_second: f64,
    /// Why rendering ended; `None` while it goes on.
    pub done: Option<StopReason>,
    /// The estimates of the error so far.
    pub history: Vec<ErrorPoint>,
    /// Contributions dropped because they were not finite or negative.
    pub nonfinite: u64,
    /// Seconds from the request being taken up to its first picture.
    pub first_image_seconds: f64,
    /// What a denoiser works on: at full resolution, whenever the samples have doubled and at the end.
    pub samples: Option<Samples>,
}

/// What a denoiser and pictures of the samples work on.
#[derive(Clone, Debug)]
pub struct Samples {
    /// The scene, for its guides.
    pub prepared: Arc<Prepared>,
    /// The replicates.
    pub input: Arc<denoise::Input>,
    /// Samples of each pixel.
    pub counts: SampleCounts,
}

impl Samples {
    /// A picture of the samples, row by row from the top ([`sample_picture`]).
    pub fn picture(&self, view: SampleView) -> Vec<[f32; 3]> {
        sample_picture(view, &self.input, &self.counts.per_pixel())
    }
}

/// A background renderer. Dropping it ends its thread.
pub struct Worker {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

struct Shared {
    /// Requests so far; whoever works on an older one gives up.
    revision: AtomicU64,
    state: Mutex<State>,
    changed: Condvar,
    threads: usize,
    on_image: Box<dyn Fn() + Send + Sync>,
}

#[derive(Default)]
struct State {
    request: Option<(u64, Arc<Scene>, Settings)>,
    snapshot: Option<Arc<Snapshot>>,
    is_ending: bool,
}

impl Worker {
    /// A worker that renders with `threads` threads and calls `on_image` from its own
    /// thread whenever there is a newer picture.
    pub fn new(threads: usize, on_image: Box<dyn Fn() + Send + Sync>) -> Self {
        let shared = Arc::new(Shared {
            revision: AtomicU64::new(0),
            state: Mutex::default(),
            changed: Condvar::new(),
            threads: threads.max(1),
            on_image,
        });
        let of_thread = shared.clone();
        let thread = std::thread::Builder::new().name("final view".to_owned()).spawn(move || run(&of_thread)).ok();
        Self { shared, thread }
    }

    /// Replaces whatever is being rendered; never waits. Returns the revision that snapshots of this request carry. The worker's number of
    /// threads holds, not that of the settings.
    pub fn request(&self, scene: Arc<Scene>, settings: Settings) -> u64 {
        let mut state = self.shared.lock();
        let revision = self.shared.revision.fetch_add(1, Ordering::SeqCst) + 1;
        state.request = Some((revision, scene, settings));
        drop(state);
        self.shared.changed.notify_all();
        revision
    }

    /// Stops working and keeps the last picture. The next request starts again.
    pub fn pause(&self) {
        let mut state = self.shared.lock();
        state.request = None;
        self.shared.revision.fetch_add(1, Ordering::SeqCst);
    }

    /// The newest picture; older than the newest request until that has one.
    pub fn snapshot(&self) -> Option<Arc<Snapshot>> {
        self.shared.lock().snapshot.clone()
    }
}

impl Drop for Worker {
    fn drop(&mut self) {
        self.shared.lock().is_ending = true;
        self.pause();
        self.shared.changed.notify_all();
        if let Some(thread) = self.thread.take() {
            // A panic of the render thread has been reported by the panic hook; there is nothing to add while dropping.
            let _ = thread.join();
        }
    }
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, State> {
        // All changes under the lock are single assignments, so the state is whole even after a panic elsewhere.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn is_stale(&self, revision: u64) -> bool {
        self.revision.load(Ordering::Relaxed) != revision
    }

    /// Shows a picture unless a newer request has come. False if one has.
    fn publish(&self, snapshot: Snapshot) -> bool {
        let mut state = self.lock();
        if self.is_stale(snapshot.revision) {
            return false;
        }
        state.snapshot = Some(Arc::new(snapshot));
        drop(state);
        (self.on_image)();
        true
    }
}

/// The thread: waits for requests and works on the newest one.
fn run(shared: &Shared) {
    let mut prepared: Option<Arc<Prepared>> = None;
    let mut coarse_rate = 0.0;
    loop {
        let mut state = shared.lock();
        let request = loop {
            if state.is_ending {
                return;
            }
            if let Some(request) = state.request.take() {
                break request;
            }
            state = shared.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
        };
        drop(state);
        let (revision, scene, settings) = request;
        let start = Instant::now();
        let made = Arc::new(Prepared::new(&scene, prepared.as_deref()));
        let mut job = Job { shared, prepared: &made, revision, settings, start, coarse_rate };
        // `None` means that a newer request waits.
        let _ = job.run();
        coarse_rate = job.coarse_rate;
        prepared = Some(made);
    }
}

/// One request being worked on.
struct Job<'a> {
    shared: &'a Shared,
    prepared: &'a Arc<Prepared>,
    revision: u64,
    settings: Settings,
    start: Instant,
    /// Pixels per second of the latest coarse picture; 0 before the first.
    coarse_rate: f64,
}

impl Job<'_> {
    /// All pictures of a request. `None` if a newer one has come.
    fn run(&mut self) -> Option<()> {
        let (width, height) = (self.settings.width.max(1), self.settings.height.max(1));
        let mut scale = first_scale(width, height, self.coarse_rate);
        let mut first_image_seconds = None;
        while scale > 1 {
            let mut film = Film::new(width.div_ceil(scale), height.div_ceil(scale));
            let begin = Instant::now();
            let stats = self.pass(&mut film, 1)?;
            let first = *first_image_seconds.get_or_insert_with(|| self.start.elapsed().as_secs_f64());
            self.coarse_rate = stats.samples as f64 / begin.elapsed().as_secs_f64().max(1e-9);
            let snapshot = self.snapshot(&film, &stats, 0.0, self.coarse_rate);
            let snapshot = Snapshot { scale: scale as u32, first_image_seconds: first, ..snapshot };
            self.publish(snapshot)?;
            scale /= 2;
        }
        let settings = Settings { width, height, threads: self.shared.threads, ..self.settings };
        let mut run = Run::new(self.prepared, settings);
        loop {
            let done = match run.step(&|| self.is_stale()) {
                Ok(()) => None,
                Err(StopReason::Cancelled) => return None,
                Err(reason) => Some(reason),
            };
            let first = *first_image_seconds.get_or_insert_with(|| self.start.elapsed().as_secs_f64());
            let snapshot = Snapshot {
                error: run.error,
                history: run.history.clone(),
                first_image_seconds: first,
                samples: if done.is_some() || run.film.spp().is_power_of_two() { self.samples(&run) } else { None },
                done,
                ..self.snapshot(&run.film, &run.stats, run.seconds, run.samples_per_second())
            };
            self.publish(snapshot)?;
            if done.is_some() {
                return Some(());
            }
        }
    }

    fn is_stale(&self) -> bool {
        self.shared.is_stale(self.revision)
    }

    fn pass(&self, film: &mut Film, spp: u32) -> Option<PassStats> {
        render_pass(self.prepared, film, spp, self.settings.seed, self.shared.threads, &|| self.is_stale())
    }

    fn samples(&self, run: &Run<'_>) -> Option<Samples> {
        let input = Arc::new(denoise::Input::of(&run.film)?);
        Some(Samples { prepared: self.prepared.clone(), input, counts: run.counts() })
    }

    fn publish(&self, snapshot: Snapshot) -> Option<()> {
        self.shared.publish(snapshot).then_some(())
    }

    fn snapshot(&self, film: &Film, stats: &PassStats, seconds: f64, samples_per_second: f64) -> Snapshot {
        let pixels = film.mean().into_iter().zip(film.alpha()).map(|([r, g, b], a)| [r, g, b, a]).collect();
        Snapshot {
            revision: self.revision,
            width: film.width,
            height: film.height,
            pixels,
            spp: film.spp(),
            scale: 1,
            seconds,
            error: None,
            samples_per_second,
            done: None,
            history: Vec::new(),
            nonfinite: stats.nonfinite + stats.negative,
            first_image_seconds: 0.0,
            samples: None,
        }
    }
}

/// By which power of two the first picture is coarser than `width` x `height`, at `rate` pixels per second (0: not known).
fn first_scale(width: usize, height: usize, rate: f64) -> usize {
    let pixels = if rate > 0.0 { FIRST_PIXELS.max((FIRST_SECONDS * rate) as usize) } else { COARSE_PIXELS };
    let mut scale = 1;
    while (width / scale) * (height / scale) > pixels {
        scale *= 2;
    }
    scale
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::path::StopRules;
    use crate::scene::{Camera, EnvironmentLight};
    use burnish_assets::Environment;
    use glam::Vec3;
    use std::time::Duration;

    fn scene(radiance: f32) -> Arc<Scene> {
        let map = Arc::new(Environment { name: String::new(), width: 2, height: 1, texels: vec![[radiance; 3]; 2] });
        let camera = Camera { origin: Vec3::Z, target: Vec3::ZERO, up: Vec3::Y, fov_deg: 30.0 };
        let environment = EnvironmentLight { map, rotation_deg: 0.0, scale: 1.0 };
        Arc::new(Scene { objects: Vec::new(), environment, camera, max_bounces: 1 })
    }

    fn settings(spp: Option<u32>) -> Settings {
        Settings {
            width: 200,
            height: 150,
            seed: 1,
            threads: 1,
            stop: StopRules { spp, ..StopRules::default() },
            is_adaptive: false,
        }
    }

    /// Waits for a snapshot; gives up after a minute.
    fn wait(worker: &Worker, is_it: impl Fn(&Snapshot) -> bool) -> Arc<Snapshot> {
        for _ in 0..60_000 {
            if let Some(snapshot) = worker.snapshot().filter(|s| is_it(s)) {
                return snapshot;
            }
            std::thread::sleep(Duration::from_millis(1));
        }
        panic!("no such snapshot");
    }

    #[test]
    fn the_newest_request_wins_and_its_picture_stays() {
        let images = Arc::new(AtomicU64::new(0));
        let count = images.clone();
        let worker = Worker::new(
            2,
            Box::new(move || {
                count.fetch_add(1, Ordering::SeqCst);
            }),
        );
        worker.request(scene(1.0), settings(None));
        let last = worker.request(scene(3.0), settings(Some(8)));
        let done = wait(&worker, |s| s.revision == last && s.done.is_some());
        assert_eq!((done.done, done.spp, done.scale, done.width, done.height), (Some(StopReason::Spp), 8, 1, 200, 150));
        assert!(done.pixels.iter().all(|p| (p[0] - 3.0).abs() < 1e-5 && p[3] == 0.0));
        assert!(!done.history.is_empty() && done.first_image_seconds > 0.0);
        let samples = done.samples.as_ref().expect("a finished picture has samples");
        assert!(samples.counts.per_pixel() == vec![8; 200 * 150]);
        let even = |view| samples.picture(view).windows(2).all(|pair| pair[0] == pair[1]);
        assert!(even(SampleView::Count) && even(SampleView::Error), "an even picture");
        assert!(images.load(Ordering::SeqCst) >= 4, "coarse pictures, passes, the end");
        std::thread::sleep(Duration::from_millis(20));
        assert_eq!(worker.snapshot().map(|s| s.revision), Some(last));
    }

    #[test]
    fn a_paused_worker_keeps_its_picture_and_starts_again() {
        let worker = Worker::new(1, Box::new(|| {}));
        let first = worker.request(scene(1.0), settings(None));
        wait(&worker, |s| s.revision == first && s.scale == 1);
        worker.pause();
        std::thread::sleep(Duration::from_millis(50));
        let kept = worker.snapshot().map(|s| s.spp);
        std::thread::sleep(Duration::from_millis(50));
        assert_eq!(worker.snapshot().map(|s| s.spp), kept);
        let second = worker.request(scene(2.0), settings(Some(4)));
        assert!(second > first);
        wait(&worker, |s| s.revision == second && s.done.is_some());
    }

    #[test]
    fn the_first_picture_is_as_fine_as_the_speed_allows() {
        assert_eq!([0.0, 1.0, 1e5, 3e5, 2e6, 1e9].map(|rate| first_scale(512, 512, rate)), [8, 16, 16, 8, 4, 1]);
        assert_eq!(first_scale(1000, 10, 0.0), 2);
        assert_eq!(first_scale(64, 64, 0.0), 1);
    }

    #[test]
    fn pictures_of_a_request_only_become_finer() {
        let (sender, shown) = std::sync::mpsc::channel();
        // Nobody listens any more at the end.
        let worker = Worker::new(2, Box::new(move || _ = sender.send(())));
        let mut last = (0, 0, 0);
        for radiance in [1.0, 2.0] {
            let revision = worker.request(scene(radiance), settings(Some(16)));
            loop {
                shown.recv_timeout(Duration::from_secs(60)).expect("pictures come until it is done");
                let Some(snapshot) = worker.snapshot().filter(|s| s.revision == revision) else { continue };
                let now = (revision, i64::from(snapshot.spp) - 1_000_000 * i64::from(snapshot.scale), snapshot.spp);
                assert!(now.0 > last.0 || now.1 >= last.1, "{now:?} after {last:?}");
                last = now;
                if snapshot.done.is_some() {
                    break;
                }
            }
        }
    }

    #[test]
    fn no_batch_begins_after_a_newer_request() {
        let prepared = Prepared::new(&scene(1.0), None);
        let mut film = Film::new(200, 150);
        // A whole pass asks before each batch of 4096 paths.
        let asked = AtomicU64::new(0);
        let count = || asked.fetch_add(1, Ordering::SeqCst) > 1_000_000;
        assert!(render_pass(&prepared, &mut film, 8, 1, 2, &count).is_some());
        assert!(asked.into_inner() >= 30_000 * 8 / 4096);
        // The fifth asking sees a newer request.
        let taken = film.total_samples();
        for threads in [1, 2, 4] {
            let asked = AtomicU64::new(0);
            let cancel = || asked.fetch_add(1, Ordering::SeqCst) >= 4;
            assert!(render_pass(&prepared, &mut film, 64, 1, threads, &cancel).is_none());
            // Each thread asks once more at most, in vain.
            let asked = asked.into_inner();
            assert!((5..=4 + threads as u64).contains(&asked), "{threads} threads asked {asked} times");
            assert_eq!(film.total_samples(), taken);
        }
    }

    #[test]
    fn nothing_is_left_of_old_requests() {
        let images = Arc::new(AtomicU64::new(0));
        let count = images.clone();
        let worker = Worker::new(2, Box::new(move || _ = count.fetch_add(1, Ordering::SeqCst)));
        let scenes: Vec<Arc<Scene>> = (0..20).map(|i| scene(i as f32)).collect();
        for scene in &scenes {
            worker.request(scene.clone(), settings(None));
            std::thread::sleep(Duration::from_millis(2));
        }
        let last = worker.request(scene(1.0), settings(Some(1)));
        wait(&worker, |s| s.revision == last && s.done.is_some());
        assert!(scenes.iter().all(|scene| Arc::strong_count(scene) == 1), "no request is kept");
        std::thread::sleep(Duration::from_millis(50));
        let shown = images.load(Ordering::SeqCst);
        std::thread::sleep(Duration::from_millis(50));
        assert_eq!(images.load(Ordering::SeqCst), shown, "nobody goes on");
        let shared = Arc::downgrade(&worker.shared);
        drop(worker);
        assert!(shared.upgrade().is_none(), "the thread has ended");
    }
}
