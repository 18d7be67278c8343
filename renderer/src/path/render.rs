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

pub use kept::{Kept, KeptError};

use super::PassStats;
use super::adaptive::{Allocation, SampleCounts, is_decision, next_decision};
use super::convergence::ErrorPoint;
use super::estimate::ErrorEstimate;
use super::film::{Film, LATTICE, Quota, REPLICATES, Window};
use super::prepared::Prepared;
use super::schedule::render_quotas;
use crate::scene::Scene;
use burnish_material::LobeSet;
use std::sync::Arc;
use std::time::Instant;

/// Samples per pixel after which a render ends in any case.
pub const SPP_MAX: u32 = 1 << 20;
/// Seconds that a pass may take before it is divided, so that progress is reported and can be cancelled.
const PASS_SECONDS: f64 = 0.5;
/// Share of a time limit by which a pass may exceed it before it is dropped.
const OVERTIME: f64 = 0.03;
/// Growth of the samples after which the error is estimated anew.
const ESTIMATE_GROWTH: f64 = 1.4;
/// How far the next power of two may divide the error: beyond this ratio to the target it is rendered without a prediction.
const PREDICTED_RATIO: f64 = 3.0;
/// Share of the predicted samples after which the error is looked at once more.
const FIRST_STEP: f64 = 0.9;
/// With this ratio to the target, a predicted number of samples is taken to have reached it.
const REACHED: f64 = 1.05;

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

/// Decides how many samples come next.
#[derive(Clone, Debug)]
struct Plan {
    stop: StopRules,
    /// Samples per pixel at which the error was judged last, and what it was.
    judged: Option<(u32, f64)>,
    /// Samples per pixel that reach the target by prediction.
    predicted: Option<u32>,
}

impl Plan {
    fn new(stop: StopRules) -> Self {
        Self { stop, judged: None, predicted: None }
    }

    /// Samples per pixel for the next pass, or why there is none. `seconds` have gone for `spp` samples, at now `pace` seconds for one;
    /// `error` is their estimate, if there is one.
    fn next(&mut self, spp: u32, seconds: f64, pace: f64, error: Option<&ErrorEstimate>) -> Result<u32, StopReason> {
        let limit = self.limit();
        if spp >= limit {
            return Err(StopReason::Spp);
        }
        if self.judge(spp, error) {
            return Err(StopReason::Error);
        }
        let goal = self.predicted.unwrap_or(power(spp)).min(limit);
        let mut step = goal.saturating_sub(spp).max(1);
        if spp > 0 {
            let cap = |room: f64| (room / pace.max(1e-9)).min(f64::from(SPP_MAX)) as u32;
            // Not below one sample per replicate: shorter passes cost more than they show.
            let chunk = cap(PASS_SECONDS).max(REPLICATES as u32);
            if step > chunk {
                step = if chunk >= 16 { chunk / 16 * 16 } else { chunk / 4 * 4 };
            }
            if let Some(end) = self.stop.seconds {
                let fits = cap(end - seconds);
                if fits == 0 {
                    return Err(StopReason::Time);
                }
                if step > fits {
                    step = if fits > REPLICATES as u32 { fits / REPLICATES as u32 * REPLICATES as u32 } else { fits };
                }
            }
        }
        Ok(step)
    }

    fn limit(&self) -> u32 {
        self.stop.spp.unwrap_or(SPP_MAX).max(1)
    }

    /// Whether the error at `spp` decides anything.
    fn is_due(&self, spp: u32) -> bool {
        match self.predicted {
            Some(predicted) => spp >= predicted,
            None => spp >= REPLICATES as u32 && spp.is_power_of_two(),
        }
    }

    /// Whether the picture is good enough.
    fn judge(&mut self, spp: u32, error: Option<&ErrorEstimate>) -> bool {
        let (Some(target), Some(error)) = (self.stop.relmse, error) else { return false };
        if !self.is_due(spp) {
            return false;
        }
        let is_predicted = self.predicted.take().is_some();
        let is_reliable = !error.is_firefly_limited;
        let ratio = error.relmse / target;
        if error.high <= target || (is_reliable && ratio <= if is_predicted { REACHED } else { 1.0 }) {
            return true;
        }
        if is_reliable && ratio < PREDICTED_RATIO {
            let slope = match self.judged {
                Some((n, e)) if n < spp => ((e / error.relmse).ln() / (f64::from(spp) / f64::from(n)).ln()).clamp(0.8, 1.6),
                _ => 1.0,
            };
            let needed = f64::from(spp) * ratio.powf(1.0 / slope);
            // A long way is gone in two steps: no sample can be taken back.
            let goal = if needed > 1.3 * f64::from(spp) { FIRST_STEP * needed } else { needed };
            // Whole replicates, except where they would be too coarse a step.
            let unit = if spp >= 32 { REPLICATES as f64 } else { 1.0 };
            self.predicted = Some(((goal / unit).round() * unit).clamp(f64::from(spp) + unit, f64::from(SPP_MAX)) as u32);
        }
        self.judged = Some((spp, error.relmse));
        false
    }
}

/// The total after `spp`: 1, 4, 8, 16, …: an image at once, then whole replicates, doubling.
fn power(spp: u32) -> u32 {
    match spp {
        0 => 1,
        1..4 => REPLICATES as u32,
        _ => (spp + 1).checked_next_power_of_two().unwrap_or(SPP_MAX),
    }
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
mod tests {
    use super::*;
    use crate::path::tests::{mixed, picture};

    fn totals(stop: StopRules, pace: f64, error: impl Fn(u32) -> Option<ErrorEstimate>) -> (Vec<u32>, StopReason) {
        let (mut plan, mut spp, mut all) = (Plan::new(stop), 0, Vec::new());
        loop {
            match plan.next(spp, f64::from(spp) * pace, pace, error(spp).as_ref()) {
                Ok(step) => spp += step,
                Err(reason) => return (all, reason),
            }
            all.push(spp);
        }
    }

    #[test]
    fn samples_are_exact_and_double() {
        let stop = StopRules { spp: Some(100), ..StopRules::default() };
        assert_eq!(totals(stop, 1e-6, |_| None), (vec![1, 4, 8, 16, 32, 64, 100], StopReason::Spp));
    }

    #[test]
    fn counts_worked_out_later_are_those_of_the_film() {
        let prepared = Prepared::new(&mixed(), None);
        let stop = StopRules { spp: Some(100), ..StopRules::default() };
        for is_adaptive in [false, true] {
            let mut run = Run::new(&prepared, Settings { width: 24, height: 16, seed: 5, threads: 2, stop, is_adaptive });
            while run.step(&|| false).is_ok() {
                assert!(run.counts().per_pixel() == run.film.samples(), "{is_adaptive}: {}", run.film.spp());
            }
            let counts = run.counts().per_pixel();
            assert_eq!((counts.iter().sum::<u32>(), counts.iter().min() < counts.iter().max()), (24 * 16 * 100, is_adaptive));
        }
    }

    #[test]
    fn time_is_kept() {
        for limit in [0.5, 1.0, 3.3, 10.0] {
            let stop = StopRules { seconds: Some(limit), ..StopRules::default() };
            let (all, reason) = totals(stop, 0.01, |_| None);
            let end = f64::from(*all.last().expect("at least one pass")) * 0.01;
            assert_eq!(reason, StopReason::Time);
            assert!(end <= limit && end > limit - 0.02, "{end} for {limit}");
        }
    }

    #[test]
    fn a_target_between_powers_of_two_is_met() {
        let stop = |target| StopRules { relmse: Some(target), ..StopRules::default() };
        for slope in [0.9, 1.0, 1.3] {
            let estimate = |spp: u32| {
                let relmse = f64::from(spp.max(1)).powf(-slope);
                (spp >= 4).then_some(ErrorEstimate { relmse, low: 0.9 * relmse, high: 1.1 * relmse, is_firefly_limited: false })
            };
            for needed in [16.0f64, 23.0, 50.0, 64.0, 65.0, 90.0, 127.0, 1000.0] {
                let target = needed.powf(-slope);
                let (all, reason) = totals(stop(target), 1e-6, estimate);
                let reached = f64::from(*all.last().expect("at least one pass")).powf(-slope) / target;
                assert!(reason == StopReason::Error && (0.8..1.1).contains(&reached), "{slope} {needed}: {reached} {all:?}");
            }
        }
        // Fireflies: the upper end decides.
        let wild = |spp: u32| {
            (spp >= 4).then_some(ErrorEstimate {
                relmse: 1.0 / f64::from(spp),
                low: 0.5 / f64::from(spp),
                high: 2.0 / f64::from(spp),
                is_firefly_limited: true,
            })
        };
        assert_eq!(totals(stop(1.0 / 64.0), 1e-6, wild).0.last(), Some(&128));
    }

    fn run_to(spp: u32, threads: usize, is_adaptive: bool, seed: u64) -> Film {
        let stop = StopRules { spp: Some(spp), ..StopRules::default() };
        let settings = Settings { width: 24, height: 24, seed, threads, stop, is_adaptive };
        let rendering = render(&mixed(), &settings, &mut |_| true);
        assert_eq!((rendering.stop_reason, rendering.film.spp()), (StopReason::Spp, spp));
        assert_eq!(rendering.samples, 24 * 24 * u64::from(spp));
        rendering.film
    }

    #[test]
    fn adaptive_bits_do_not_depend_on_threads_and_passes() {
        let one = run_to(150, 1, true, 7);
        let counts = one.samples();
        assert!(counts.iter().min() < counts.iter().max());
        for threads in [2, 4] {
            let film = run_to(150, threads, true, 7);
            assert_eq!((film.mean(), film.samples()), (one.mean(), counts.clone()), "{threads} threads");
        }
        // By other steps to the same total.
        let scene = mixed();
        let prepared = Prepared::new(&scene, None);
        let stop = StopRules { spp: Some(150), ..StopRules::default() };
        let mut run = Run::new(&prepared, Settings { width: 24, height: 24, seed: 7, threads: 2, stop, is_adaptive: true });
        for goal in [3, 40, 64, 70, 81, 150] {
            run.plan.stop.spp = Some(goal);
            while run.step(&|| false).is_ok() {}
            assert_eq!(run.film.spp(), goal);
        }
        assert_eq!(run.film.mean(), one.mean());
        assert_eq!(run.film.samples(), counts);
    }

    #[test]
    fn adaptive_sampling_keeps_the_mean() {
        // Against the same number of pictures with equal samples, pixel sums in standard errors of their own scatter.
        const PICTURES: u64 = 12;
        let sums = |is_adaptive: bool| -> Vec<f64> {
            (0..PICTURES)
                .map(|seed| {
                    let film = run_to(128, 2, is_adaptive, 2 * seed + u64::from(is_adaptive));
                    film.mean().iter().flatten().map(|c| f64::from(*c)).sum()
                })
                .collect()
        };
        let moments = |sums: &[f64]| {
            let mean = sums.iter().sum::<f64>() / PICTURES as f64;
            (mean, sums.iter().map(|s| (s - mean).powi(2)).sum::<f64>() / (PICTURES * (PICTURES - 1)) as f64)
        };
        let (a, b) = (moments(&sums(true)), moments(&sums(false)));
        let z = (a.0 - b.0) / (a.1 + b.1).sqrt();
        assert!(z.abs() < 3.5, "{z}: {a:?} {b:?}");
    }

    #[test]
    fn any_stopped_picture_is_repeated_and_goes_on_as_if_it_had_not_stopped() {
        let prepared = Prepared::new(&mixed(), None);
        let settings = |stop| Settings { width: 40, height: 36, seed: 9, threads: 2, stop, is_adaptive: true };
        let by = |relmse| StopRules { relmse: Some(relmse), ..StopRules::default() };
        let whole = Tile { at: [0, 0], size: [40, 36] };
        let again = |samples| repeat(&prepared, &settings(by(1e-9)), whole, samples, Instant::now(), &mut |_| true).film;
        let through = render_prepared(&prepared, &settings(by(2e-3)), Instant::now(), &mut |_| true);
        assert_eq!(through.stop_reason, StopReason::Error);
        assert!(again(through.film.total_samples()).mean() == through.film.mean());
        // Not even one sample in every pixel: any beginning of the coarse picture.
        let mut first = Run::new(&prepared, settings(StopRules { seconds: Some(1e3), ..StopRules::default() }));
        first.step(&|| false).expect("there is time");
        first.pace = PASS_SECONDS / 100.0;
        for _ in 0..5 {
            first.step(&|| false).expect("there is time");
            first.pace = PASS_SECONDS / 100.0;
            let film = again(first.film.total_samples());
            assert!(film.samples() == first.film.samples() && film.mean() == first.film.mean());
        }
        // Stopped in the middle, put aside, taken up.
        let mut passes = 0;
        let stopped = render_prepared(&prepared, &settings(by(2e-3)), Instant::now(), &mut |state| {
            passes += 1;
            state.film.spp() < 32
        });
        assert_eq!(stopped.stop_reason, StopReason::Cancelled);
        let bytes = stopped.keep();
        let kept = Kept::read(&bytes).expect("it was just made");
        assert_eq!(kept.spp(), stopped.film.spp());
        let on = kept.go_on(&prepared, &settings(by(2e-3)), Instant::now(), &mut |_| true).expect("it is of this size");
        assert!(on.film.mean() == through.film.mean() && on.film.samples() == through.film.samples());
        assert_eq!((on.error, on.stop_reason), (through.error, StopReason::Error));
        // The same from the very beginning, with a time limit that was over before every pixel had a sample.
        let early = settings(StopRules { seconds: Some(1e3), ..StopRules::default() });
        let begun = render_prepared(&prepared, &early, Instant::now(), &mut |_| false);
        assert_eq!(begun.film.spp(), 0);
        let kept = Kept::read(&begun.keep()).expect("it was just made");
        let on = kept.go_on(&prepared, &settings(by(2e-3)), Instant::now(), &mut |_| true).expect("it is of this size");
        assert!(on.film.mean() == through.film.mean() && on.film.samples() == through.film.samples());
        // Damage is found, wherever it is.
        for at in [0, 9, 40, bytes.len() / 2, bytes.len() - 1] {
            let mut damaged = bytes.clone();
            damaged[at] ^= 1;
            assert!(Kept::read(&damaged).is_err(), "{at}");
        }
        assert!(Kept::read(&bytes[..bytes.len() - 8]).is_err() && Kept::read(&[]).is_err());
    }

    #[test]
    fn tiles_are_parts_of_the_picture() {
        let prepared = Prepared::new(&mixed(), None);
        let stop = StopRules { spp: Some(6), ..StopRules::default() };
        let settings = Settings { width: 40, height: 30, seed: 3, threads: 2, stop, is_adaptive: false };
        let whole = render_prepared(&prepared, &settings, Instant::now(), &mut |_| true).film.mean();
        for tile in [Tile { at: [0, 0], size: [17, 30] }, Tile { at: [17, 11], size: [23, 19] }] {
            let part = render_tile(&prepared, &settings, tile, Instant::now(), &mut |_| true).film;
            assert_eq!([part.width, part.height], tile.size);
            let row = |y: usize| &whole[(tile.at[1] + y) * 40 + tile.at[0]..][..tile.size[0]];
            assert!(part.mean().chunks(tile.size[0]).enumerate().all(|(y, of_part)| of_part == row(y)), "{tile:?}");
        }
    }

    #[test]
    fn a_time_limit_within_the_first_pass_leaves_a_whole_picture() {
        let scene = mixed();
        let prepared = Prepared::new(&scene, None);
        let stop = StopRules { seconds: Some(1e3), ..StopRules::default() };
        let mut run = Run::new(&prepared, Settings { width: 40, height: 40, seed: 7, threads: 1, stop, is_adaptive: false });
        run.step(&|| false).expect("there is time");
        assert_eq!((run.film.total_samples(), run.film.spp(), run.error), (4, 0, None));
        assert!(run.film.mean().iter().all(|c| c[0] > 0.0));
        // Time is up: what came in time is kept, and it is the beginning of the same picture.
        run.settings.stop.seconds = Some(0.0);
        run.plan.stop.seconds = Some(0.0);
        assert_eq!(run.step(&|| false), Err(StopReason::Time));
        assert_eq!(run.film.total_samples(), 4);
        run.settings.stop.seconds = Some(1e3);
        while run.film.spp() == 0 {
            run.step(&|| false).expect("there is time");
        }
        assert_eq!(run.film.mean(), picture(&scene, 40, &[1], 1).0.mean());
    }
}
