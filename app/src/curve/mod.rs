//! Error against run time: one picture rendered in doublings, each compared with a reference of another seed.
//!
//! The seconds of a row are rendering alone: pictures are kept and compared after the last one is done. What the reference's own noise
//! adds to an error is known where the reference is ours, from the variance of its pixels, and taken off.

mod chart;
mod report;
mod targets;

pub use report::{csv, html, json};
pub use targets::{TARGETS, Target, targets};

use burnish_renderer::metrics::{flip, relative_error, relative_noise};
use burnish_renderer::path::{
    ErrorEstimate, Film, Prepared, Progress, Rendering, Settings, StopReason, StopRules, render_prepared,
};
use burnish_renderer::scene::Scene;
use burnish_renderer::tonemap::Display;
use std::time::Instant;

/// Samples of a reference of our own relative to the largest count of the curve: its noise is an eighth of the last error or less, and what
/// is left after taking it off is far below the interval of the estimate.
pub const REFERENCE_FACTOR: u32 = 8;

/// Added to the seed of the curve for the seed of its reference.
const REFERENCE_SEED: u64 = 1_000_003;

/// What a curve is measured against.
#[derive(Clone, Debug)]
pub enum ReferenceSource {
    /// A rendering of ours of another seed, of so many samples per pixel; `None`: [`REFERENCE_FACTOR`] times the curve's largest count.
    Own(Option<u32>),
    /// A picture of the size of the curve.
    Given(Reference),
}

/// A picture that counts as the truth.
#[derive(Clone, Debug, Default)]
pub struct Reference {
    /// The file; `None` for a rendering of ours made for this curve.
    pub file: Option<String>,
    /// Linear radiance.
    pub pixels: Vec<[f32; 3]>,
    /// Variance of the mean per pixel and channel; taken off where it is known.
    pub variance: Option<Vec<[f32; 3]>>,
    /// Samples per pixel, where known.
    pub spp: Option<u32>,
    /// Seed, where known.
    pub seed: Option<u64>,
    /// Seconds that rendering it took, where it was rendered here.
    pub seconds: Option<f64>,
}

impl Reference {
    /// relMSE of the reference itself, where its variance is known.
    pub fn relmse(&self) -> Option<f64> {
        self.variance.as_ref().map(|variance| relative_noise(&self.pixels, variance))
    }
}

/// One picture of a curve.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Seconds of rendering so far.
    pub seconds: f64,
    /// Samples per pixel.
    pub spp: u32,
    /// What the renderer itself says of its error.
    pub estimate: Option<ErrorEstimate>,
    /// Error against the reference, the reference's own noise taken off where it is known.
    pub relmse: f64,
    /// The same without the worst 0.1 % of the pixels.
    pub relmse_trimmed: f64,
    /// Mean FLIP of what a display shows.
    pub flip: f64,
}

/// A measured curve.
#[derive(Clone, Debug)]
pub struct Curve {
    /// What was rendered, for people.
    pub name: String,
    /// How it was rendered.
    pub settings: Settings,
    /// One row per doubling, and one for what was reached last.
    pub rows: Vec<Row>,
    /// What the rows were compared with.
    pub reference: Reference,
    /// Why the curve ended.
    pub stop_reason: StopReason,
    /// Seconds for the tree and the tables.
    pub load_seconds: f64,
    /// Contributions that were dropped because they were not finite or negative.
    pub nonfinite: u64,
    /// Paths per second.
    pub samples_per_second: f64,
}

/// What is being done, for a line of progress.
#[derive(Debug)]
pub enum Stage<'a> {
    /// Renders the pictures of the curve.
    Curve(&'a Progress<'a>),
    /// Renders the reference.
    Reference {
        /// Samples per pixel so far.
        spp: u32,
        /// Samples per pixel in the end.
        of: u32,
        /// Seconds so far.
        seconds: f64,
    },
    /// Compares.
    Comparing,
}

/// A picture of the curve until it is compared.
struct Kept {
    seconds: f64,
    spp: u32,
    estimate: Option<ErrorEstimate>,
    mean: Vec<[f32; 3]>,
}

/// Renders a scene in doublings until one of the rules of `settings` ends it, and compares. `None`: `progress` returned false.
///
/// A reference that is given must have as many pixels as the settings say.
pub fn measure(
    name: &str,
    scene: &Scene,
    settings: &Settings,
    source: ReferenceSource,
    display: Display,
    progress: &mut dyn FnMut(&Stage<'_>) -> bool,
) -> Option<Curve> {
    let start = Instant::now();
    let prepared = Prepared::new(scene, None);
    let mut kept: Vec<Kept> = Vec::new();
    let rendering = render_prepared(&prepared, settings, start, &mut |state| {
        let next = kept.last().map_or(1, |last| (last.spp + 1).next_power_of_two());
        if state.film.spp() >= next {
            kept.push(Kept::new(state.film, state.seconds, state.error));
        }
        progress(&Stage::Curve(state))
    });
    if matches!(rendering.stop_reason, StopReason::Cancelled) {
        return None;
    }
    let film = &rendering.film;
    if kept.last().is_none_or(|last| last.spp < film.spp()) {
        kept.push(Kept::new(film, rendering.seconds, film.error()));
    }
    let reference = match source {
        ReferenceSource::Given(reference) => reference,
        ReferenceSource::Own(spp) => {
            let spp = spp.unwrap_or(film.spp().saturating_mul(REFERENCE_FACTOR));
            own_reference(&prepared, settings, spp, progress)?
        }
    };
    let shown = |pixels: &[[f32; 3]]| pixels.iter().map(|pixel| display.apply(*pixel)).collect::<Vec<_>>();
    let reference_shown = shown(&reference.pixels);
    let mut rows = Vec::new();
    for picture in &kept {
        if !progress(&Stage::Comparing) {
            return None;
        }
        let error = relative_error(&picture.mean, &reference.pixels, reference.variance.as_deref());
        let errors = flip(&shown(&picture.mean), &reference_shown, settings.width);
        rows.push(Row {
            seconds: picture.seconds,
            spp: picture.spp,
            estimate: picture.estimate,
            relmse: error.relmse,
            relmse_trimmed: error.trimmed,
            flip: errors.iter().map(|e| f64::from(*e)).sum::<f64>() / errors.len().max(1) as f64,
        });
    }
    Some(Curve {
        name: name.to_owned(),
        settings: *settings,
        rows,
        reference,
        stop_reason: rendering.stop_reason,
        load_seconds: rendering.load_seconds,
        nonfinite: rendering.nonfinite,
        samples_per_second: rendering.samples as f64 / rendering.seconds.max(1e-9),
    })
}

impl Kept {
    fn new(film: &Film, seconds: f64, estimate: Option<ErrorEstimate>) -> Self {
        Self { seconds, spp: film.spp(), estimate, mean: film.mean() }
    }
}

fn own_reference(
    prepared: &Prepared,
    settings: &Settings,
    spp: u32,
    progress: &mut dyn FnMut(&Stage<'_>) -> bool,
) -> Option<Reference> {
    let seed = settings.seed.wrapping_add(REFERENCE_SEED);
    let settings = Settings { seed, stop: StopRules { spp: Some(spp), ..StopRules::default() }, ..*settings };
    let Rendering { film, stop_reason, seconds, .. } = render_prepared(prepared, &settings, Instant::now(), &mut |state| {
        progress(&Stage::Reference { spp: state.film.spp(), of: spp, seconds: state.seconds })
    });
    if matches!(stop_reason, StopReason::Cancelled) {
        return None;
    }
    let variance = film.error().map(|_| film.variance());
    Some(Reference { file: None, pixels: film.mean(), variance, spp: Some(film.spp()), seed: Some(seed), seconds: Some(seconds) })
}
