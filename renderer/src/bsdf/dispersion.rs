//! Dispersion: index of refraction by wavelength, and wavelengths for paths. Twin of `dispersion.wgsl`.
//!
//! A path draws one wavelength from the mean of three sensitivity curves. Where it first refracts in a dispersive material it becomes light of
//! that wavelength: each channel is weighted by its sensitivity over the mean (the balance heuristic over three channels), and those weights
//! average to white. Reflections before that are evaluated per channel and stay free of it. Model reference 9; light transport
//! reference 5.

use crate::lanes::Lanes;
use std::sync::OnceLock;

/// First and last wavelength, nanometres.
pub const WAVELENGTH_RANGE: [f64; 2] = [380.0, 780.0];
/// Middles of the sensitivity of red, green and blue, nanometres.
const CENTERS: [f64; 3] = [620.0, 540.0, 450.0];
/// Standard deviation of each, nanometres.
const WIDTH: f64 = 30.0;
/// Entries of the spectrum, one nanometre each.
const BINS: usize = 400;
/// Wavelength of the sodium line, where the index of refraction is the authored one, nanometres.
pub const LAMBDA_D: f64 = 587.6;

/// Piecewise constant sensitivities. Sums are exact: sampling by them leaves white white.
#[derive(Debug)]
pub struct Spectrum {
    /// Cumulative mean sensitivity at the end of each bin; the last is 1.
    cumulative: Vec<f64>,
    /// Per bin the weights of the channels: sensitivity over mean sensitivity. They sum to 3.
    weights: Vec<[f32; 3]>,
    /// Mean of `1 / lambda^2` over each channel's sensitivity, 1/nm^2.
    pub inverse_square: [f64; 3],
}

/// The spectrum, made at first use.
pub fn spectrum() -> &'static Spectrum {
    static SPECTRUM: OnceLock<Spectrum> = OnceLock::new();
    SPECTRUM.get_or_init(|| {
        let middle = |bin: usize| WAVELENGTH_RANGE[0] + bin as f64 + 0.5;
        let curves = CENTERS.map(|center| {
            let curve: Vec<f64> = (0..BINS).map(|bin| (-0.5 * ((middle(bin) - center) / WIDTH).powi(2)).exp()).collect();
            let sum: f64 = curve.iter().sum();
            curve.into_iter().map(|s| s / sum).collect::<Vec<f64>>()
        });
        let mean: Vec<f64> = (0..BINS).map(|bin| curves.iter().map(|c| c[bin]).sum::<f64>() / 3.0).collect();
        let mut sum = 0.0;
        let mut cumulative: Vec<f64> = mean
            .iter()
            .map(|p| {
                sum += p;
                sum
            })
            .collect();
        cumulative[BINS - 1] = 1.0;
        let weights = (0..BINS).map(|bin| [0, 1, 2].map(|c| (curves[c][bin] / mean[bin]) as f32)).collect();
        let inverse_square = [0, 1, 2].map(|c| (0..BINS).map(|bin| curves[c][bin] / middle(bin).powi(2)).sum());
        Spectrum { cumulative, weights, inverse_square }
    })
}

impl Spectrum {
    /// Wavelength in nanometres at `u` in `[0, 1)`, distributed as the mean sensitivity.
    pub fn wavelength(&self, u: f64) -> f64 {
        let bin = self.cumulative.partition_point(|c| *c <= u).min(BINS - 1);
        let before = if bin == 0 { 0.0 } else { self.cumulative[bin - 1] };
        let within = ((u - before) / (self.cumulative[bin] - before).max(1e-300)).clamp(0.0, 1.0 - 1e-7);
        WAVELENGTH_RANGE[0] + bin as f64 + within
    }

    /// Wavelengths in the middles of `count` steps of equal probability, and the mean weights of the channels over each: they average to
    /// white.
    pub fn steps(&self, count: usize) -> impl Iterator<Item = [f64; 4]> + '_ {
        const PARTS: usize = 256;
        let mean = move |step: usize| {
            let mut sum = [0.0; 3];
            for part in 0..PARTS {
                let u = (step as f64 + (part as f64 + 0.5) / PARTS as f64) / count as f64;
                let weights = self.weights(self.wavelength(u));
                (0..3).for_each(|c| sum[c] += f64::from(weights[c]) / PARTS as f64);
            }
            sum
        };
        let all = (0..count).map(mean).fold([0.0; 3], |sum, w| [0, 1, 2].map(|c| sum[c] + w[c] / count as f64));
        (0..count).map(move |step| {
            let [r, g, b] = mean(step);
            [self.wavelength((step as f64 + 0.5) / count as f64), r / all[0], g / all[1], b / all[2]]
        })
    }

    /// Weights of red, green and blue for light of a wavelength in nanometres; they sum to 3.
    pub fn weights(&self, wavelength: f64) -> [f32; 3] {
        let bin = (wavelength - WAVELENGTH_RANGE[0]).clamp(0.0, (BINS - 1) as f64) as usize;
        self.weights[bin]
    }
}

/// Index of refraction at an inverse squared wavelength (1/nm^2). `n_d` at the sodium line; `dispersion` in `[0, 20]`, 20 over the Abbe
/// number. At least 1 where `n_d` is; the reciprocal rule holds below 1. Cauchy's formula with two terms.
#[inline(always)]
pub fn dispersed_ior<L: Lanes>(n_d: L, dispersion: L, inverse_square: L) -> L {
    let is_thin = n_d.lt(L::one());
    let n = L::select(is_thin, L::one() / n_d, n_d);
    let n = n + (n - L::one()) * dispersion * L::of(1.0 / 20.0) * (L::of(523_454.0) * inverse_square - L::of(1.516_05));
    let n = n.max(L::one());
    L::select(is_thin, L::one() / n, n)
}
