//! One whole render: passes that double, and the rules that end them.
//!
//! * Samples: exact.
//! * Time: the next pass is made as large as the measured speed says will fit; rendering ends when not even one more sample per
//!   pixel would. Seconds count rendering alone.
//! * Error: judged only where every replicate holds a power of two of samples (testing after each pass stops early by luck), when the
//!   estimate is not firefly-limited and its interval reaches less than 15 % to either side, or when even the upper end of the
//!   interval is below the target. Where the target lies less than a factor 2.5 below, the missing samples are computed from the
//!   slope of the error and rendered without another test. A render with no other rule ends at [`SPP_MAX`] at the latest.

use super::PassStats;
use super::film::{ErrorEstimate, Film, REPLICATES};
use super::prepared::Prepared;
use super::schedule::render_pass;
use crate::scene::Scene;
use burnish_material::LobeSet;
use std::time::Instant;

/// Samples per pixel after which a render ends in any case.
pub const SPP_MAX: u32 = 1 << 20;
/// Seconds that a pass may take before it is divided, so that progress is reported and can be cancelled.
const PASS_SECONDS: f64 = 0.5;
/// Half width of the interval, relative to the estimate, with which an error may be judged.
const HALF_WIDTH_MAX: f64 = 0.15;

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
    /// Samples (paths) per second.
    pub samples_per_second: f64,
}

/// A finished render.
#[derive(Clone, Debug)]
pub struct Rendering {
    /// The picture.
    pub film: Film,
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
}

/// Decides how many samples come next. Shared by [`render`] and the background worker.
#[derive(Clone, Debug)]
pub(crate) struct Plan {
    stop: StopRules,
    /// Total samples at which the error was judged last, and what it was.
    judged: Option<(u32, f64)>,
    /// Total samples that reach the target by prediction.
    predicted: Option<u32>,
}

impl Plan {
    pub(crate) fn new(stop: StopRules) -> Self {
        Self { stop, judged: None, predicted: None }
    }

    /// Samples for the next pass, or why there is none. `seconds` of rendering so far, `error` estimated at `spp` samples.
    pub(crate) fn next(&mut self, spp: u32, seconds: f64, error: Option<&ErrorEstimate>) -> Result<u32, StopReason> {
        let limit = self.stop.spp.unwrap_or(SPP_MAX).max(1);
        if spp >= limit {
            return Err(StopReason::Spp);
        }
        if self.judge(spp, error) {
            return Err(StopReason::Error);
        }
        // Totals 1, 4, 8, 16, …: an image at once, then whole replicates, doubling.
        let goal = match spp {
            0 => 1,
            1..4 => REPLICATES as u32,
            _ if spp.is_power_of_two() => spp.saturating_mul(2),
            _ => spp.checked_next_power_of_two().unwrap_or(SPP_MAX),
        };
        let goal = self.predicted.unwrap_or(goal).min(limit);
        let mut step = goal.saturating_sub(spp).max(1);
        if spp > 0 {
            let per_sample = seconds / f64::from(spp);
            let cap = |room: f64| (room / per_sample.max(1e-9)).min(f64::from(SPP_MAX)) as u32;
            // Not below one sample per replicate: shorter passes cost more than they show.
            let chunk = cap(PASS_SECONDS).max(REPLICATES as u32);
            step = step.min(if chunk >= 16 { chunk / 16 * 16 } else { chunk });
            if let Some(end) = self.stop.seconds {
                let fits = cap(end - seconds);
                if fits == 0 {
                    return Err(StopReason::Time);
                }
                step = step.min(fits);
            }
            if spp >= REPLICATES as u32 && step > REPLICATES as u32 {
                step -= step % REPLICATES as u32;
            }
        }
        Ok(step)
    }

    /// Whether the picture is good enough.
    fn judge(&mut self, spp: u32, error: Option<&ErrorEstimate>) -> bool {
        let (Some(target), Some(error)) = (self.stop.relmse, error) else { return false };
        if let Some(predicted) = self.predicted {
            return spp >= predicted;
        }
        if spp < REPLICATES as u32 || !(spp / REPLICATES as u32).is_power_of_two() || !spp.is_multiple_of(REPLICATES as u32) {
            return false;
        }
        if error.high <= target {
            return true;
        }
        let half_width = 0.5 * (error.high - error.low);
        let is_reliable = !error.is_firefly_limited && half_width < HALF_WIDTH_MAX * error.relmse;
        if is_reliable && error.relmse <= target {
            return true;
        }
        let ratio = error.relmse / target;
        if is_reliable && ratio < 2.5 {
            let slope = match self.judged {
                Some((n, e)) if n < spp => ((e / error.relmse).ln() / (f64::from(spp) / f64::from(n)).ln()).clamp(0.8, 1.6),
                _ => 1.0,
            };
            // In quarters of the present count: other counts lose the stratification of the sequence.
            let quarters = (4.0 * ratio.powf(1.0 / slope)).ceil().clamp(5.0, 16.0);
            self.predicted = Some((quarters * f64::from(spp) / 4.0) as u32);
        }
        self.judged = Some((spp, error.relmse));
        false
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
    let load_seconds = start.elapsed().as_secs_f64();
    let mut film = Film::new(settings.width, settings.height);
    let mut plan = Plan::new(settings.stop);
    let mut total = PassStats::default();
    let mut seconds = 0.0;
    let mut first_image_seconds = 0.0;
    let mut error = None;
    let stop_reason = loop {
        let step = match plan.next(film.spp(), seconds, error.as_ref()) {
            Ok(step) => step,
            Err(reason) => break reason,
        };
        let begin = Instant::now();
        let Some(stats) = render_pass(prepared, &mut film, step, settings.seed, settings.threads, &|| false) else {
            break StopReason::Cancelled;
        };
        seconds += begin.elapsed().as_secs_f64();
        if total.samples == 0 {
            first_image_seconds = start.elapsed().as_secs_f64();
        }
        total.add(&stats);
        error = film.error();
        let samples_per_second = total.samples as f64 / seconds.max(1e-9);
        if !progress(&Progress { film: &film, seconds, error, samples_per_second }) {
            break StopReason::Cancelled;
        }
    };
    Rendering {
        film,
        seconds,
        load_seconds,
        first_image_seconds,
        stop_reason,
        nonfinite: total.nonfinite + total.negative,
        samples: total.samples,
        lobes: prepared.lobes(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn totals(stop: StopRules, seconds_per_sample: f64, error: impl Fn(u32) -> Option<ErrorEstimate>) -> (Vec<u32>, StopReason) {
        let (mut plan, mut spp, mut all) = (Plan::new(stop), 0, Vec::new());
        loop {
            match plan.next(spp, f64::from(spp) * seconds_per_sample, error(spp).as_ref()) {
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
    fn error_is_judged_at_powers_of_two() {
        let estimate = |spp: u32| {
            let relmse = 1.0 / f64::from(spp.max(1));
            (spp >= 4).then_some(ErrorEstimate { relmse, low: 0.95 * relmse, high: 1.05 * relmse, is_firefly_limited: false })
        };
        let stop = |target| StopRules { relmse: Some(target), ..StopRules::default() };
        assert_eq!(totals(stop(1.0 / 64.0), 1e-6, estimate), (vec![1, 4, 8, 16, 32, 64], StopReason::Error));
        assert_eq!(totals(stop(1.0 / 90.0), 1e-6, estimate), (vec![1, 4, 8, 16, 32, 64, 96], StopReason::Error));
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
}
