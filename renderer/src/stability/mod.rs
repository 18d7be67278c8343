//! Whether a material holds where numbers get hard: lobes over angles, and small pictures, checked against what must be true of both.
//!
//! A [`Case`] is a scene; its document material is what is probed. `lobes` asks the BSDF in single and double precision: finite,
//! not negative, density equal to what is drawn, nothing gained, nothing lost where the model promises so. `picture` renders: counts what
//! was dropped, looks for pixels brighter than a white surrounding, and compares the time with that of a plain material. [`suite`] lists
//! built-in cases, [`neighbours`] those around a material, [`fixes`] what brings a material back.
//!
//! All numbers but times are the same in every run.

mod coefficients;
mod fixes;
mod lobes;
mod neighbours;
mod picture;
mod reach;
mod scenes;
mod suite;
#[cfg(test)]
mod tests;

pub use fixes::{Fix, fixes};
pub use lobes::{Draw, Scattering, probe_scattering};
pub use neighbours::neighbours;
pub use picture::time_ratio;
pub use suite::suite;

use crate::path::Prepared;
use crate::scene::Scene;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::Instant;

/// One scene to probe.
#[derive(Clone, Debug)]
pub struct Case {
    /// Unique within a run.
    pub name: String,
    /// What is rendered; the objects with `is_document` carry the material that is probed.
    pub scene: Scene,
}

/// What can be found, in order of how bad it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Check {
    /// Infinite or not a number.
    NonFinite,
    /// Below zero, where light cannot be.
    Negative,
    /// A coefficient that the lobes are made from is outside its stated range.
    Coefficient,
    /// Value over density is not the weight of the sample, or the two densities differ.
    PdfMismatch,
    /// The density integrates to more than 1.
    Density,
    /// More light leaves than arrives.
    Gain,
    /// Light is lost although nothing is coloured.
    Loss,
    /// Single precision gives another result than double precision.
    Precision,
    /// A picture in a white surrounding is brighter than that.
    Brightness,
    /// A picture of the whitened material in a white surrounding loses most of its light: paths end where they should go on.
    Darkness,
    /// A sample takes far longer than one of a plain material.
    Time,
}

/// The largest value of one number, and where it was found.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Worst {
    /// The value; 0 if nothing was found.
    pub value: f64,
    /// Angle, side and channel in words.
    pub place: String,
}

impl Check {
    /// The word for machines.
    pub fn word(self) -> &'static str {
        match self {
            Self::NonFinite => "nonfinite",
            Self::Negative => "negative",
            Self::Coefficient => "coefficient",
            Self::PdfMismatch => "pdf_mismatch",
            Self::Density => "density",
            Self::Gain => "furnace_gain",
            Self::Loss => "furnace_loss",
            Self::Precision => "double_difference",
            Self::Brightness => "brightness",
            Self::Darkness => "darkness",
            Self::Time => "time",
        }
    }
}

impl Worst {
    /// Keeps the larger value. NaN counts as infinite: it must not get lost.
    pub fn note(&mut self, value: f64, place: impl FnOnce() -> String) {
        let value = if value.is_nan() { f64::INFINITY } else { value };
        if value > self.value {
            *self = Self { value, place: place() };
        }
    }
}

/// Everything that was measured of one case.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Numbers {
    /// Values, weights, densities and coefficients that are infinite or not a number; samples and pixels of pictures too.
    pub nonfinite: u64,
    /// The same, negative.
    pub negative: u64,
    /// Where the first of either was met.
    pub first_bad: String,
    /// Coefficients outside their stated ranges, named.
    pub coefficients: Vec<String>,
    /// Relative difference between weight times density and value, in double precision.
    pub pdf_mismatch: Worst,
    /// Integral of the density over all directions, less 1.
    pub density_excess: Worst,
    /// Directional albedo less 1, beyond noise.
    pub gain: Worst,
    /// 1 less the directional albedo with all tints white, beyond noise; `None` where the model promises nothing.
    pub loss: Option<Worst>,
    /// Relative difference of single precision to double precision.
    pub precision: Worst,
    /// Brightness of the picture in a white surrounding less 1, beyond noise; `None` for a material that emits.
    pub brightness: Option<f64>,
    /// 1 less the brightness of the picture in a white surrounding with all tints white; `None` where the model promises nothing.
    pub darkness: Option<f64>,
    /// Time of a sample over that of a plain material in the same scene.
    pub time_ratio: f64,
}

/// What was found of one case.
#[derive(Clone, Debug, PartialEq)]
pub struct Report {
    /// Name of the case.
    pub name: String,
    /// All numbers.
    pub numbers: Numbers,
    /// What does not hold, the worst first.
    pub failed: Vec<Check>,
    /// One sentence about the worst finding, or about the number that is closest to its limit.
    pub worst: String,
    /// Seconds that the probe took.
    pub seconds: f64,
}

impl Report {
    /// Whether every check holds.
    pub fn holds(&self) -> bool {
        self.failed.is_empty()
    }
}

/// Largest relative difference between what a sample says and what `eval` says, double precision: rounding alone, magnified by the
/// narrowest lobe (alpha 1e-4) and the least contrast of refraction.
pub const PDF_MISMATCH_MAX: f64 = 1e-6;
/// Largest excess of the integral of a density: the noise of the estimate with the samples of one direction.
pub const DENSITY_EXCESS_MAX: f64 = 0.04;
/// Largest gain: a closed scene of sixteen bounces then stays within a fifth of the truth. The tables of albedos are made for 0.005.
pub const GAIN_MAX: f64 = 0.012;
/// Largest loss of a white material: below what a picture shows.
pub const LOSS_MAX: f64 = 0.03;
/// Largest relative difference to double precision, beyond [`PRECISION_FLOOR`].
pub const PRECISION_MAX: f64 = 0.02;
/// Values (per steradian) and densities below this are compared with it instead of with themselves: less than a hundredth of a grey wall.
pub const PRECISION_FLOOR: f64 = 1e-2;
/// Largest brightness above white of a picture, beyond six standard errors.
pub const BRIGHTNESS_MAX: f64 = 0.02;
/// Largest loss of a picture of a whitened material. Normals bent far from the surface cost up to three quarters of the light, as they must;
/// all of it is only lost where numbers have become useless without being infinite.
pub const DARKNESS_MAX: f64 = 0.9;
/// Largest ratio of times: sixteen bounces instead of one, and random walks that stay inside for some hundred events.
pub const TIME_RATIO_MAX: f64 = 400.0;

impl Numbers {
    /// Takes over what another probe counted.
    fn add_counts(&mut self, other: Self) {
        self.nonfinite += other.nonfinite;
        self.negative += other.negative;
        if self.first_bad.is_empty() {
            self.first_bad = other.first_bad;
        }
    }

    fn limits(&self) -> Vec<(Check, f64, f64, String)> {
        let count = |n: u64| if n > 0 { f64::INFINITY } else { 0.0 };
        let at = |w: &Worst| if w.place.is_empty() { String::new() } else { format!(" at {}", w.place) };
        let percent = |x: f64| format!("{:.2} %", 100.0 * x);
        let loss = self.loss.clone().unwrap_or_default();
        vec![
            (
                Check::NonFinite,
                count(self.nonfinite),
                1.0,
                format!("{} numbers are infinite or not a number, first {}", self.nonfinite, self.first_bad),
            ),
            (
                Check::Negative,
                count(self.negative),
                1.0,
                format!("{} numbers are negative, first {}", self.negative, self.first_bad),
            ),
            (
                Check::Coefficient,
                count(self.coefficients.len() as u64),
                1.0,
                format!("outside its range: {}", self.coefficients.join(", ")),
            ),
            (
                Check::PdfMismatch,
                self.pdf_mismatch.value,
                PDF_MISMATCH_MAX,
                format!("density and value differ by {:.1e}{}", self.pdf_mismatch.value, at(&self.pdf_mismatch)),
            ),
            (
                Check::Density,
                self.density_excess.value,
                DENSITY_EXCESS_MAX,
                format!("the density integrates to {:.3}{}", 1.0 + self.density_excess.value, at(&self.density_excess)),
            ),
            (Check::Gain, self.gain.value, GAIN_MAX, format!("gains {}{}", percent(self.gain.value), at(&self.gain))),
            (Check::Loss, loss.value, LOSS_MAX, format!("loses {} of white{}", percent(loss.value), at(&loss))),
            (
                Check::Precision,
                self.precision.value,
                PRECISION_MAX,
                format!("single precision is off by {}{}", percent(self.precision.value), at(&self.precision)),
            ),
            (
                Check::Brightness,
                self.brightness.unwrap_or(0.0),
                BRIGHTNESS_MAX,
                format!("a picture in white light is {} brighter than white", percent(self.brightness.unwrap_or(0.0))),
            ),
            (
                Check::Darkness,
                self.darkness.unwrap_or(0.0),
                DARKNESS_MAX,
                format!("a white picture in white light loses {}", percent(self.darkness.unwrap_or(0.0))),
            ),
            (
                Check::Time,
                self.time_ratio,
                TIME_RATIO_MAX,
                format!("a sample takes {:.1} times as long as one of a plain material", self.time_ratio),
            ),
        ]
    }

    /// Judges the numbers: what does not hold, and a sentence.
    fn judge(&self) -> (Vec<Check>, String) {
        let limits = self.limits();
        let failed: Vec<Check> =
            limits.iter().filter(|(_, value, limit, _)| value > limit || value.is_nan()).map(|(check, ..)| *check).collect();
        let sentence = match limits.iter().find(|(check, ..)| failed.first() == Some(check)) {
            Some((.., sentence)) => sentence.clone(),
            None => limits
                .into_iter()
                .max_by(|a, b| (a.1 / a.2).total_cmp(&(b.1 / b.2)))
                .map_or_else(String::new, |(.., sentence)| sentence),
        };
        (failed, sentence)
    }
}

/// Probes one case. `previous` is the scene prepared last on this thread: what fits is taken from it. `None` if cancelled.
pub fn probe(case: &Case, previous: &mut Option<Prepared>, cancel: &(dyn Fn() -> bool + Sync)) -> Option<Report> {
    let start = Instant::now();
    let mut numbers = Numbers::default();
    let prepared = Prepared::new(&case.scene, previous.as_ref());
    lobes::probe_materials(&case.scene, &prepared, &mut numbers, cancel);
    if cancel() {
        return None;
    }
    *previous = Some(picture::probe(&case.scene, prepared, &mut numbers, cancel)?);
    let (failed, worst) = numbers.judge();
    Some(Report { name: case.name.clone(), numbers, failed, worst, seconds: start.elapsed().as_secs_f64() })
}

/// How far a run is.
#[derive(Clone, Debug)]
pub struct Progress {
    /// Cases done.
    pub done: usize,
    /// Cases in all.
    pub total: usize,
    /// Of the done ones, how many do not hold.
    pub failed: usize,
    /// Seconds so far.
    pub seconds: f64,
    /// Seconds that the rest may take.
    pub remaining_seconds: f64,
}

/// Probes all cases on `threads` threads. `progress` is told after each case, from any thread. `cancel` is asked every few dozen milliseconds;
/// once it holds, the result is `None`. Reports are in the order of the cases.
pub fn run(
    cases: &[Case],
    threads: usize,
    progress: &(dyn Fn(&Progress) + Sync),
    cancel: &(dyn Fn() -> bool + Sync),
) -> Option<Vec<Report>> {
    let start = Instant::now();
    let next = AtomicUsize::new(0);
    let is_cancelled = AtomicBool::new(false);
    let reports: Mutex<Vec<Option<Report>>> = Mutex::new(vec![None; cases.len()]);
    let counts = Mutex::new((0, 0));
    let work = || {
        let mut previous = None;
        loop {
            let number = next.fetch_add(1, Ordering::Relaxed);
            let Some(case) = cases.get(number) else { break };
            let Some(report) = probe(case, &mut previous, cancel).filter(|_| !cancel()) else {
                is_cancelled.store(true, Ordering::Relaxed);
                break;
            };
            // Both locks guard single assignments, so what they guard is whole even after a panic elsewhere.
            let mut counts = counts.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
            counts.0 += 1;
            counts.1 += usize::from(!report.holds());
            reports.lock().unwrap_or_else(std::sync::PoisonError::into_inner)[number] = Some(report);
            let seconds = start.elapsed().as_secs_f64();
            let remaining_seconds = seconds / counts.0 as f64 * (cases.len() - counts.0) as f64;
            let now = Progress { done: counts.0, total: cases.len(), failed: counts.1, seconds, remaining_seconds };
            progress(&now);
            if is_cancelled.load(Ordering::Relaxed) {
                break;
            }
        }
    };
    std::thread::scope(|scope| {
        let handles: Vec<_> = (1..threads.clamp(1, cases.len().max(1))).map(|_| scope.spawn(work)).collect();
        work();
        for handle in handles {
            if let Err(panic) = handle.join() {
                std::panic::resume_unwind(panic);
            }
        }
    });
    if is_cancelled.load(Ordering::Relaxed) {
        return None;
    }
    reports.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner).into_iter().collect()
}
