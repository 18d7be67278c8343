//! How many samples the next pass adds, and when there is none.

use super::{SPP_MAX, StopReason, StopRules};
use crate::path::estimate::ErrorEstimate;
use crate::path::film::REPLICATES;

/// Seconds that a pass may take before it is divided, so that progress is reported and can be cancelled.
pub(super) const PASS_SECONDS: f64 = 0.5;
/// How far the next power of two may divide the error: beyond this ratio to the target it is rendered without a prediction.
const PREDICTED_RATIO: f64 = 3.0;
/// Share of the predicted samples after which the error is looked at once more.
const FIRST_STEP: f64 = 0.9;
/// With this ratio to the target, a predicted number of samples is taken to have reached it.
const REACHED: f64 = 1.05;

/// Decides how many samples come next.
#[derive(Clone, Debug)]
pub(super) struct Plan {
    pub stop: StopRules,
    /// Samples per pixel at which the error was judged last, and what it was.
    pub judged: Option<(u32, f64)>,
    /// Samples per pixel that reach the target by prediction.
    pub predicted: Option<u32>,
}

impl Plan {
    pub fn new(stop: StopRules) -> Self {
        Self { stop, judged: None, predicted: None }
    }

    /// Samples per pixel for the next pass, or why there is none. `seconds` have gone for `spp` samples, at now `pace` seconds for one;
    /// `error` is their estimate, if there is one.
    pub fn next(&mut self, spp: u32, seconds: f64, pace: f64, error: Option<&ErrorEstimate>) -> Result<u32, StopReason> {
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
    pub fn is_due(&self, spp: u32) -> bool {
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
