//! The stability report while it is made: a thread of its own probes the open material, and gives up as soon as that changes.

use burnish_material::Material;
use burnish_renderer::scene::{Scene, TextureSet};
use burnish_renderer::stability::{self, Case, Fix, Progress, Report};
use egui::Context;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// A material must rest for this long before it is probed: a slider that moves changes it with every frame.
const REST: Duration = Duration::from_millis(400);
/// Name of the case that is the material itself.
pub const AS_IT_IS: &str = "As it is";

/// What was found of one material.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// The material as it is first, then its neighbours.
    pub reports: Vec<Report>,
    /// What would bring it back.
    pub fixes: Vec<Fix>,
}

/// How far the report of the open material is.
#[derive(Clone, Debug)]
pub enum State {
    /// The material has just changed, or nothing can be shown yet.
    Waiting,
    /// Being made; no progress until the first case is done.
    Running(Option<Progress>),
    /// Complete.
    Done(Arc<Outcome>),
}

/// The thread and what it has found so far.
pub struct LiveStability {
    shared: Arc<Shared>,
    /// What is asked about, and when it changed.
    asked: Option<(Material, Arc<TextureSet>, Instant)>,
    is_sent: bool,
}

#[derive(Default)]
struct Shared {
    /// Changes of the question so far; whoever works on an older one gives up.
    revision: AtomicU64,
    tray: Mutex<Tray>,
    bell: Condvar,
}

#[derive(Default)]
struct Tray {
    job: Option<(u64, Material, Vec<Case>)>,
    progress: Option<Progress>,
    outcome: Option<Arc<Outcome>>,
    is_closing: bool,
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, Tray> {
        // The tray is whole between two statements, so a panic elsewhere cannot leave it half changed.
        self.tray.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn is_stale(&self, revision: u64) -> bool {
        self.revision.load(Ordering::Relaxed) != revision
    }
}

impl LiveStability {
    /// Starts the thread.
    pub fn new(ctx: Context) -> Self {
        let shared: Arc<Shared> = Arc::default();
        let theirs = shared.clone();
        // Without a thread the report stays as it is, and everything else works.
        let _ = std::thread::Builder::new().name("stability".to_owned()).spawn(move || work(&theirs, &ctx));
        Self { shared, asked: None, is_sent: false }
    }

    /// Asks about this material, unless that is what was asked last. `scene` is called when it is time to begin. Once per frame.
    pub fn update(
        &mut self,
        ctx: &Context,
        material: &Material,
        textures: &Arc<TextureSet>,
        scene: impl FnOnce() -> Option<Scene>,
    ) -> State {
        let is_same = self.asked.as_ref().is_some_and(|(m, t, _)| m == material && Arc::ptr_eq(t, textures));
        if !is_same {
            self.forget();
            self.asked = Some((material.clone(), textures.clone(), Instant::now()));
        }
        let rest = self.asked.as_ref().map_or(REST, |(.., since)| REST.saturating_sub(since.elapsed()));
        if !self.is_sent {
            if !rest.is_zero() {
                ctx.request_repaint_after(rest);
                return State::Waiting;
            }
            let Some(scene) = scene() else { return State::Waiting };
            let revision = self.shared.revision.load(Ordering::Relaxed);
            self.shared.lock().job = Some((revision, material.clone(), stability::neighbours(AS_IT_IS, &scene)));
            self.shared.bell.notify_one();
            self.is_sent = true;
        }
        let tray = self.shared.lock();
        match &tray.outcome {
            Some(outcome) => State::Done(outcome.clone()),
            None => State::Running(tray.progress.clone()),
        }
    }

    /// Stops working; the next question begins anew.
    pub fn forget(&mut self) {
        if self.asked.take().is_none() {
            return;
        }
        self.is_sent = false;
        let mut tray = self.shared.lock();
        self.shared.revision.fetch_add(1, Ordering::Relaxed);
        (tray.job, tray.progress, tray.outcome) = (None, None, None);
    }
}

impl Drop for LiveStability {
    fn drop(&mut self) {
        self.shared.lock().is_closing = true;
        self.shared.revision.fetch_add(1, Ordering::Relaxed);
        self.shared.bell.notify_one();
    }
}

/// The thread: waits for questions and answers the newest one. One core is enough, and leaves the others to the pictures.
fn work(shared: &Shared, ctx: &Context) {
    loop {
        let mut tray = shared.lock();
        let (revision, material, cases) = loop {
            if tray.is_closing {
                return;
            }
            if let Some(job) = tray.job.take() {
                break job;
            }
            tray = shared.bell.wait(tray).unwrap_or_else(PoisonError::into_inner);
        };
        drop(tray);
        let progress = |now: &Progress| {
            let mut tray = shared.lock();
            if !shared.is_stale(revision) {
                tray.progress = Some(now.clone());
                ctx.request_repaint();
            }
        };
        let Some(reports) = stability::run(&cases, 1, &progress, &|| shared.is_stale(revision)) else { continue };
        let fixes = stability::fixes(&material, reports.first());
        let mut tray = shared.lock();
        if !shared.is_stale(revision) {
            tray.outcome = Some(Arc::new(Outcome { reports, fixes }));
            ctx.request_repaint();
        }
    }
}
