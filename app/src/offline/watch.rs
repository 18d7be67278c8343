//! Whoever waits for long work: told how far it is, and able to end it.

use burnish_renderer::path::{Convergence, ErrorEstimate, Progress, StopRules};

/// How far work is.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Step {
    /// Which part of it is being done, `frame 3 of 120`; empty where it has none.
    pub part: String,
    /// Samples per pixel of the part.
    pub spp: u32,
    /// Seconds of rendering of the part.
    pub seconds: f64,
    /// Error of the part so far.
    pub error: Option<ErrorEstimate>,
    /// How much of the whole is done, 0 to 1, if that is known.
    pub share: Option<f64>,
    /// Seconds until the whole is done, if that is known.
    pub remaining: Option<f64>,
}

impl Step {
    /// The state of a render as a step; its rules tell how far it is.
    pub fn of(part: &str, progress: &Progress<'_>, rules: &StopRules) -> Self {
        let (seconds, spp) = (progress.seconds, progress.film.spp());
        let end = end(progress, rules);
        Self {
            part: part.to_owned(),
            spp,
            seconds,
            error: progress.error,
            share: end.map(|end| (seconds / end.max(1e-9)).clamp(0.0, 1.0)),
            remaining: end.map(|end| (end - seconds).max(0.0)),
        }
    }

    /// `frame 3 of 120: 64 spp in 1.2 s, error 1.9 % (±0.2)`.
    pub fn text(&self) -> String {
        let part = if self.part.is_empty() { String::new() } else { format!("{}: ", self.part) };
        if self.spp == 0 && self.seconds == 0.0 {
            return self.part.clone();
        }
        let error = self.error.as_ref().map_or_else(String::new, |error| format!(", {}", error_text(error)));
        format!("{part}{} spp in {:.1} s{error}", self.spp, self.seconds)
    }
}

/// The second at which a render will end: the first of its rules. `None` before the error can be foreseen that is one of them.
fn end(progress: &Progress<'_>, rules: &StopRules) -> Option<f64> {
    let by_spp = rules.spp.filter(|_| progress.film.spp() > 0);
    let by_spp = by_spp.map(|spp| progress.seconds * f64::from(spp) / f64::from(progress.film.spp()));
    let by_error = rules.relmse.map(|relmse| Convergence::fit(progress.history)?.seconds_to(relmse).map(|at| at.seconds));
    if by_error == Some(None) {
        // Before there is a line, any other rule may come second.
        return None;
    }
    let ends = [by_spp, by_error.flatten(), rules.seconds];
    ends.into_iter().flatten().min_by(f64::total_cmp)
}

/// `error 1.9 % (±0.2)`: the square root of relMSE, with half the width of its interval.
pub fn error_text(error: &ErrorEstimate) -> String {
    let percent = |relmse: f64| 100.0 * relmse.max(0.0).sqrt();
    let half_width = 0.5 * (percent(error.high) - percent(error.low));
    let fireflies = if error.is_firefly_limited { ", mostly few bright pixels" } else { "" };
    format!("error {:.1} % (±{half_width:.1}{fireflies})", percent(error.relmse))
}

/// Whoever waits.
pub struct Watch<'a> {
    /// Whether to stop at the next seam.
    pub is_cancelled: &'a (dyn Fn() -> bool + Sync),
    /// Takes a sentence about what is strange; nothing is lost.
    pub warn: &'a mut dyn FnMut(String),
    /// Is told how far work is, several times a second.
    pub tell: &'a mut dyn FnMut(&Step),
}
