//! Pictures of how the samples of a render are spread and how far each pixel has come.

use super::colors::{Color, diverging, ramp};
use super::{LegendEntry, ViewDef};
use crate::denoise::Input;
use crate::path::estimate::{EPSILON, variance_of_mean};
use crate::path::film::{REPLICATES, replicate_weights};

/// What a picture of samples shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SampleView {
    /// Samples of a pixel.
    Count,
    /// Standard error of a pixel.
    Error,
}

/// Doublings more or less than the mean that reach the end of the colours.
const DOUBLINGS: f32 = 2.0;
/// Relative errors at the ends of the ramp.
const ERRORS: [f64; 2] = [1e-3, 1.0];

impl SampleView {
    /// All views, in the order of a list.
    pub const ALL: &'static [ViewDef<Self>] = &[
        ViewDef {
            view: Self::Count,
            word: "samples",
            label: "Sample count",
            doc: "Samples of each pixel over the mean of the picture: grey is the mean, orange more, blue fewer.",
        },
        ViewDef {
            view: Self::Error,
            word: "error",
            label: "Error",
            doc: "Estimated standard error of each pixel relative to its value; for pixels darker than a tenth, to about a tenth.",
        },
    ];

    /// The entry of this view.
    pub fn def(self) -> &'static ViewDef<Self> {
        &Self::ALL[self as usize]
    }

    /// What the colours stand for, in the order to be shown.
    pub fn legend(self) -> Vec<LegendEntry> {
        match self {
            Self::Count => [("4 times the mean", 4.0), ("2 times", 2.0), ("mean", 1.0), ("half", 0.5), ("a quarter", 0.25)]
                .map(|(name, ratio)| (name, count_color(ratio)))
                .to_vec(),
            Self::Error => [("0.1 %", 1e-3), ("1 %", 1e-2), ("10 %", 0.1), ("100 %", 1.0)]
                .map(|(name, error)| (name, error_color(error)))
                .to_vec(),
        }
    }
}

/// A picture of the samples of a render, row by row from the top. `counts` are those of each pixel; missing ones count as the replicates being
/// equally full.
pub fn sample_picture(view: SampleView, input: &Input, counts: &[u32]) -> Vec<Color> {
    let mean = counts.iter().map(|n| f64::from(*n)).sum::<f64>() / counts.len().max(1) as f64;
    let color = |(pixel, replicates): (usize, &[[f32; 3]; REPLICATES])| {
        let count = counts.get(pixel).copied();
        match view {
            SampleView::Count => count_color(count.map_or(1.0, |n| f64::from(n) / mean.max(1e-9)) as f32),
            SampleView::Error => error_color(relative_error(replicates, count.unwrap_or(0))),
        }
    };
    input.replicates.iter().enumerate().map(color).collect()
}

/// Standard error of the mean over the mean: the root of the mean over channels of the square, where a hundredth is added to squared values.
fn relative_error(replicates: &[[f32; 3]; REPLICATES], count: u32) -> f64 {
    let weights = replicate_weights(count.max(REPLICATES as u32));
    let of_channel = |k: usize| {
        let b = replicates.map(|b| f64::from(b[k]));
        let mean: f64 = b.iter().zip(&weights).map(|(b, w)| b * w).sum();
        variance_of_mean(&b, &weights) / (mean * mean + EPSILON)
    };
    ((0..3).map(of_channel).sum::<f64>() / 3.0).sqrt()
}

fn count_color(ratio: f32) -> Color {
    diverging(ratio.max(1e-6).log2() / DOUBLINGS)
}

fn error_color(error: f64) -> Color {
    let [low, high] = ERRORS.map(f64::ln);
    ramp(((error.max(1e-12).ln() - low) / (high - low)) as f32)
}
