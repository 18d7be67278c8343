//! One whole render: passes that double, and the rules that end them.
//!
//! * Samples: exact.
//! * Time: the next pass is made as large as the measured speed says will fit; rendering ends when not even one more sample per
//!   pixel would. A pass that takes longer than expected is dropped shortly after the limit, so that the number of samples alone says
//!   what the picture holds. The first pass goes from a coarse lattice to all pixels, and where time ends before, the pixels between
//!   show their neighbours. Seconds count rendering and the estimates of the error, not loading.
//! * Error: judged only where every replicate holds a power of two of samples (testing after each pass stops early by luck), when the
//!   estimate is not firefly-limited, or when even the upper end of its interval is below the target. Where the target comes before the next power of two, the missing samples are computed from the slope of the error and
//!   rendered in two steps. A render with no other rule ends at [`SPP_MAX`] at the latest.

mod kept;
mod plan;

pub use kept::{Kept, KeptError};

use super::PassStats;
use super::adaptive::{Allocation, SampleCounts, is_decision, next_decision};
use super::convergence::ErrorPoint;
use super::estimate::ErrorEstimate;
use super::film::{Film, LATTICE, Quota, Window};
use super::prepared::Prepared;
use super::schedule::render_quotas;
use crate::scene::Scene;
use burnish_material::LobeSet;
use plan::{PASS_SECONDS, Plan};
use std::sync::Arc;
use std::time::Instant;

/// Samples per pixel after which a render ends in any case.
pub const SPP_MAX: u32 = 1 << 20;
/// Share of a time limit by which a pass may exceed it before it is dropped.
const OVERTIME: f64 = 0.03;
/// Growth of the samples after which the error is estimated anew.
const ESTIMATE_GROWTH: f64 = 1.4;

/// When a render ends: the first rule that holds. Without any, it runs until it is cancelled or reaches [`SPP_MAX`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StopRules {
    /// Samples per pixel.
    pub spp: Option<u32>,
    /// Seconds of rendering.
    pub seconds: Option<f64>,
    /// Estimated relative mean squared error.
    pub relmse: Option<f64>,
}

/// Why a render ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StopReason {
    /// All samples were taken.
    Spp,
    /// The time was used up.
    Time,
    /// The error is below the target.
    Error,
    /// The caller ended it.
    Cancelled,
}

impl StopReason {
    /// The word for machines: `spp`, `time`, `error`, `cancelled`.
    pub fn word(self) -> &'static str {
        match self {
            Self::Spp => "spp",
            Self::Time => "time",
            Self::Error => "error",
            Self::Cancelled => "cancelled",
        }
    }
}

/// What to render.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Random stream; equal seeds give equal bits.
    pub seed: u64,
    /// Threads; 0 counts as 1.
    pub threads: usize,
    /// When to stop.
    pub stop: StopRules,
    /// Whether noisy pixels get more samples than quiet ones, from 64 samples per pixel on.
    pub is_adaptive: bool,
}

/// Where a render stands after a pass.
#[derive(Debug)]
pub struct Progress<'a> {
    /// The picture so far.
    pub film: &'a Film,
    /// Seconds of rendering.
    pub seconds: f64,
    /// The latest estimate.
    pub error: Option<ErrorEstimate>,
    /// All estimates so far.
    pub history: &'a [ErrorPoint],
    /// Samples (paths) per second.
    pub samples_per_second: f64,
}

/// A finished render.
#[derive(Clone, Debug)]
pub struct Rendering {
    /// The picture.
    pub film: Film,
    /// Its error.
    pub error: Option<ErrorEstimate>,
    /// The estimates on the way.
    pub history: Vec<ErrorPoint>,
    /// Seconds of rendering alone.
    pub seconds: f64,
    /// Seconds for the tree and the tables.
    pub load_seconds: f64,
    /// Seconds from the start, loading included, to the first whole picture.
    pub first_image_seconds: f64,
    /// Why it ended.
    pub stop_reason: StopReason,
    /// Contributions that were dropped because they were not finite or negative.
    pub nonfinite: u64,
    /// Paths traced.
    pub samples: u64,
    /// Lobes that the materials need.
    pub lobes: LobeSet,
    /// What goes on from here needs to know.
    plan: Plan,
    allocation: Option<Arc<Allocation>>,
}

/// A part of a picture, pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tile {
    /// Column and row of its first pixel.
    pub at: [usize; 2],
    /// Columns and rows.
    pub size: [usize; 2],
}

/// A render under way. Shared by [`render`] and the background worker.
pub(crate) struct Run<'a> {
    prepared: &'a Prepared,
    settings: Settings,
    plan: Plan,
    allocation: Option<Arc<Allocation>>,
    /// The picture.
    pub film: Film,
    /// What was done.
    pub stats: PassStats,
    /// Seconds of rendering.
    pub seconds: f64,
    /// The latest estimate.
    pub error: Option<ErrorEstimate>,
    /// All estimates.
    pub history: Vec<ErrorPoint>,
    /// Samples of all pixels at the latest estimate, and the seconds that it took.
    estimated: (u64, f64),
    /// Seconds per sample of the last pass.
    pace: f64,
    /// Spacing of the pixels that get their first sample now.
    side: usize,
}

impl<'a> Run<'a> {
    /// A render that has no samples yet.
    pub(crate) fn new(prepared: &'a Prepared, settings: Settings) -> Self {
        Self::of_film(prepared, settings, Film::new(settings.width, settings.height))
    }

    fn of_film(prepared: &'a Prepared, settings: Settings, film: Film) -> Self {
        Self {
            prepared,
            settings,
            plan: Plan::new(settings.stop),
            allocation: None,
            film,
            stats: PassStats::default(),
            seconds: 0.0,
            error: None,
            history: Vec::new(),
            estimated: (0, 0.0),
            pace: 0.0,
            side: LATTICE,
        }
    }

    /// One pass, or why there is none. After [`StopReason::Cancelled`] the film is as before.
    pub(crate) fn step(&mut self, cancel: &(dyn Fn() -> bool + Sync)) -> Result<(), StopReason> {
        let (begin, before) = (Instant::now(), self.seconds);
        let taken = self.film.total_samples();
        let result = self.pass(cancel);
        self.seconds = before + begin.elapsed().as_secs_f64();
        let new = self.film.total_samples() - taken;
        if new > 0 {
            self.pace = (self.seconds - before) / new as f64;
        }
        let has_grown = (taken + new) as f64 >= ESTIMATE_GROWTH * self.estimated.0 as f64;
        let is_due = self.plan.is_due(self.film.spp());
        if result != Err(StopReason::Cancelled) && (result.is_err() || has_grown || is_due) {
            self.estimate();
        }
        result
    }

    fn pass(&mut self, cancel: &(dyn Fn() -> bool + Sync)) -> Result<(), StopReason> {
        let begin = Instant::now();
        let quotas = self.quotas()?;
        let room = self.settings.stop.seconds.map(|limit| limit * (1.0 + OVERTIME) - self.seconds);
        let stop = || cancel() || room.is_some_and(|room| begin.elapsed().as_secs_f64() > room);
        match render_quotas(self.prepared, &mut self.film, &quotas, self.settings.seed, self.settings.threads, &stop) {
            Some(stats) => {
                self.stats.add(&stats);
                Ok(())
            }
            None if cancel() => Err(StopReason::Cancelled),
            None => Err(StopReason::Time),
        }
    }

    /// What the next pass adds.
    fn quotas(&mut self) -> Result<Vec<Quota>, StopReason> {
        let (spp, pixels) = (self.film.spp(), self.film.pixels() as u64);
        if pixels == 0 {
            return Err(StopReason::Spp);
        }
        if spp == 0 {
            return self.first();
        }
        let fresh = self.error.filter(|_| self.estimated.0 == self.film.total_samples());
        let pace = pixels as f64 * self.pace.max(self.seconds / self.film.total_samples() as f64);
        // The last estimate takes its time as well.
        let step = self.plan.next(spp, self.seconds + self.estimated.1, pace, fresh.as_ref())?;
        if !self.settings.is_adaptive {
            return Ok(self.film.evenly(step));
        }
        if is_decision(spp) {
            self.allocation = Some(Arc::new(Allocation::new(&self.film)));
        }
        let goal = (spp + step).min(next_decision(spp));
        Ok(match &self.allocation {
            Some(allocation) => self.film.up_to(&allocation.counts(u64::from(goal) * pixels)),
            None => self.film.evenly(goal - spp),
        })
    }

    /// The first sample of every pixel. Where time is short, a coarse lattice comes first, then as much of finer ones as fits.
    fn first(&mut self) -> Result<Vec<Quota>, StopReason> {
        // All that have none yet: what goes on may have begun with a time limit.
        let Some(limit) = self.settings.stop.seconds else { return Ok(self.film.lattice(1)) };
        if self.film.total_samples() == 0 {
            return Ok(self.film.lattice(LATTICE));
        }
        let room = PASS_SECONDS.min(limit - self.seconds);
        let fits = (room / self.pace.max(1e-9)) as usize;
        if fits == 0 {
            return Err(StopReason::Time);
        }
        let all = self.film.lattice(1);
        if all.len() <= fits {
            return Ok(all);
        }
        let mut quotas = self.film.lattice(self.side);
        while quotas.is_empty() && self.side > 1 {
            self.side /= 2;
            quotas = self.film.lattice(self.side);
        }
        quotas.truncate(fits);
        Ok(quotas)
    }

    fn estimate(&mut self) {
        let samples = self.film.total_samples();
        if samples == self.estimated.0 {
            return;
        }
        let begin = Instant::now();
        self.error = self.film.error_by(self.settings.threads);
        let (seconds, spp) = (self.seconds, self.film.spp());
        let point = |e: ErrorEstimate| ErrorPoint { seconds, spp, relmse: e.relmse, low: e.low, high: e.high };
        self.history.extend(self.error.map(point));
        self.estimated = (samples, begin.elapsed().as_secs_f64());
        self.seconds += self.estimated.1;
    }

    /// Samples of each pixel; right once every pixel has some.
    pub(crate) fn counts(&self) -> SampleCounts {
        SampleCounts::new(&self.film, self.allocation.as_ref())
    }

    /// Paths per second so far.
    pub(crate) fn samples_per_second(&self) -> f64 {
        self.stats.samples as f64 / self.seconds.max(1e-9)
    }
}

/// Renders a scene until a rule ends it. `progress` is called after every pass, at least about twice a second; it returns false to cancel.
pub fn render(scene: &Scene, settings: &Settings, progress: &mut dyn FnMut(&Progress<'_>) -> bool) -> Rendering {
    let start = Instant::now();
    let prepared = Prepared::new(scene, None);
    render_prepared(&prepared, settings, start, progress)
}

/// [`render`] for a scene that is prepared, loading begun at `start`.
pub fn render_prepared(
    prepared: &Prepared,
    settings: &Settings,
    start: Instant,
    progress: &mut dyn FnMut(&Progress<'_>) -> bool,
) -> Rendering {
    finish(Run::new(prepared, *settings), start, progress)
}

/// [`render_prepared`] for a part of the picture that the settings describe: without adaptive sampling, its bits are those of the whole.
/// Memory is that of the part.
pub fn render_tile(
    prepared: &Prepared,
    settings: &Settings,
    tile: Tile,
    start: Instant,
    progress: &mut dyn FnMut(&Progress<'_>) -> bool,
) -> Rendering {
    let full = [settings.width, settings.height];
    let at = [0, 1].map(|k| tile.at[k].min(full[k]));
    let [width, height] = [0, 1].map(|k| tile.size[k].min(full[k] - at[k]));
    finish(Run::of_film(prepared, *settings, Film::of_window(width, height, Window { full, at })), start, progress)
}

/// The picture, or the part of it, that a render holds after `samples` samples of all its pixels together, whatever ended that render: the same
/// bits. The stop rules of the settings are not looked at.
pub fn repeat(
    prepared: &Prepared,
    settings: &Settings,
    tile: Tile,
    samples: u64,
    start: Instant,
    progress: &mut dyn FnMut(&Progress<'_>) -> bool,
) -> Rendering {
    let pixels = (tile.size[0] * tile.size[1]) as u64;
    let spp = u32::try_from(samples / pixels.max(1)).unwrap_or(SPP_MAX);
    let settings = Settings { stop: StopRules { spp: Some(spp), ..StopRules::default() }, ..*settings };
    if spp > 0 {
        return render_tile(prepared, &settings, tile, start, progress);
    }
    let window = Window { full: [settings.width, settings.height], at: tile.at };
    let mut run = Run::of_film(prepared, settings, Film::of_window(tile.size[0], tile.size[1], window));
    let quotas = run.film.beginning(samples as usize);
    if let Some(stats) = render_quotas(prepared, &mut run.film, &quotas, settings.seed, settings.threads, &|| false) {
        run.stats.add(&stats);
    }
    // No time is left for another.
    run.settings.stop.seconds = Some(0.0);
    run.plan.stop.seconds = Some(0.0);
    finish(run, start, progress)
}

/// Steps until a rule ends it.
fn finish(mut run: Run<'_>, start: Instant, progress: &mut dyn FnMut(&Progress<'_>) -> bool) -> Rendering {
    let load_seconds = start.elapsed().as_secs_f64();
    let mut first_image_seconds = 0.0;
    let stop_reason = loop {
        let is_first = run.stats.samples == 0;
        if let Err(reason) = run.step(&|| false) {
            break reason;
        }
        if is_first {
            first_image_seconds = start.elapsed().as_secs_f64();
        }
        let Run { film, seconds, error, history, .. } = &run;
        let samples_per_second = run.samples_per_second();
        if !progress(&Progress { film, seconds: *seconds, error: *error, history, samples_per_second }) {
            break StopReason::Cancelled;
        }
    };
    Rendering {
        error: run.error,
        history: run.history,
        seconds: run.seconds,
        load_seconds,
        first_image_seconds,
        stop_reason,
        nonfinite: run.stats.nonfinite + run.stats.negative,
        samples: run.stats.samples,
        lobes: run.prepared.lobes(),
        film: run.film,
        plan: run.plan,
        allocation: run.allocation,
    }
}

#[cfg(test)]
mod tests;
