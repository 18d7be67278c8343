//! How far a picture is from its limit, told by its replicates.

use super::film::{Film, REPLICATES};
use std::collections::VecDeque;

/// Added to squared values where errors are made relative.
pub(super) const EPSILON: f64 = 0.01;
/// Pixels to each side whose brightness helps to tell that of a pixel.
const REACH: usize = 2;
/// Share of the noise that is taken away where denominators are smoothed.
const SMOOTHING: f32 = 0.8;
/// A pixel with this share of the error is judged on its own, whereupon others may have that share of the rest.
const OUTLIER: f64 = 0.03;
const OUTLIER_ROUNDS: usize = 3;
/// Half width of a 95 % interval in standard deviations.
const HALF_WIDTH: f64 = 1.96;
/// Relative deviation that no estimate is free of: that of its denominators.
const DEVIATION_MIN: f64 = 0.09;
/// Share of the logarithm of the ratio of the two estimates that counts as a standard deviation.
const DISAGREEMENT: f64 = 0.12;
/// Factor that an interval spans at most where an error is known.
const SPAN_MAX: f64 = 3.0;
/// Radiance beyond which squares would overflow.
const BRIGHTEST: f64 = 1e9;

/// The six ways to take two replicates; each leaves the two of its counterpart from the other end.
const PAIRS: [[usize; 2]; 6] = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]];
/// Numbers per channel that windows sum: replicates, their squares, the products of the [`PAIRS`].
const MOMENTS: usize = 14;

/// How far a picture is from its limit, as relative mean squared error: the mean over pixels and channels of
/// `(x - r)^2 / (r^2 + 0.01)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ErrorEstimate {
    /// The estimate.
    pub relmse: f64,
    /// Lower end of the 95 % interval.
    pub low: f64,
    /// Upper end.
    pub high: f64,
    /// Rare bright samples dominate: the interval spans more than a factor of three.
    pub is_firefly_limited: bool,
}

/// What one pixel adds: means over its channels.
#[derive(Clone, Copy, Debug, Default)]
struct Terms {
    /// Variance of the mean over the square of the same mean.
    plug_in: f64,
    /// Variance by two replicates over the square that the two others and their surroundings tell.
    cross: f64,
    /// Variance of the difference between estimated variance and true squared error.
    scatter: f64,
}

/// Means of the replicates of a pixel, by channel.
type Channels = [[f32; REPLICATES]; 3];
/// Sums of [`MOMENTS`] by channel.
type Window = [[f32; MOMENTS]; 3];

/// The error of a film in which every replicate of every pixel holds a sample, at least one pixel.
///
/// *Numerators* are known without bias: the variance of the mean of a pixel from the differences of its replicates.
///
/// *Denominators* are squares of what a pixel tends to. The plug-in estimate takes the mean of the same samples: too low, since a bright
/// accident enters both. The cross estimate takes the two replicates that are not in the numerator; their noise makes it too high by Jensen's
/// inequality, by factors where light is rare. So they are smoothed by their surroundings as far as noise explains what they differ by
/// (Lee 1980), and never darkened: beside a lamp a dark pixel has little say, but a lamp among dark pixels would. The cross estimate is
/// reported.
///
/// *The interval* is one of the error of this very picture. With `X` the deviations of four like replicates from the limit, estimated variance
/// less squared error is `-(1/6) sum over i < j of X_i X_j`, of variance `s^4 / 6` whatever the distribution, `s^2` being the
/// variance of one replicate; products of variances by disjoint pairs estimate `s^4` without bias. A single firefly makes no such product, and
/// rightly: estimate and error contain it alike. Disagreement of the two estimates widens the interval.
///
/// *Outliers*: whether a pixel that makes up much of the error is an accident or shows something small and bright, its own samples cannot
/// tell. Its part lies between the plug-in and the cross estimate.
pub(super) fn estimate(film: &Film, threads: usize) -> ErrorEstimate {
    let mut pixels = vec![Terms::default(); film.pixels()];
    let rows = film.height.div_ceil(threads.max(1));
    if threads <= 1 {
        fill(film, 0, &mut pixels);
    } else {
        std::thread::scope(|scope| {
            for (i, part) in pixels.chunks_mut(rows * film.width).enumerate() {
                scope.spawn(move || fill(film, i * rows, part));
            }
        });
    }
    let mut limit = f64::INFINITY;
    for _ in 0..OUTLIER_ROUNDS {
        let of_others: f64 = pixels.iter().map(|terms| terms.cross).filter(|cross| *cross <= limit).sum();
        limit = limit.min(OUTLIER * of_others);
    }
    let (mut bulk, mut outliers) = (Terms::default(), Terms::default());
    for terms in &pixels {
        let sums = if terms.cross > limit { &mut outliers } else { &mut bulk };
        sums.plug_in += terms.plug_in;
        sums.cross += terms.cross;
        sums.scatter += terms.scatter;
    }
    bracket(&bulk, &outliers, 1.0 / pixels.len() as f64)
}

/// The estimate from sums over many like pixels and over few unlike ones.
fn bracket(bulk: &Terms, outliers: &Terms, scale: f64) -> ErrorEstimate {
    let deviation = |sums: &Terms| if sums.plug_in > 0.0 { sums.scatter.sqrt() / sums.plug_in } else { 0.0 };
    let is_known = bulk.plug_in > 0.0 && bulk.cross > 0.0;
    let disagreement = if is_known { DISAGREEMENT * (bulk.cross / bulk.plug_in).ln() } else { 0.0 };
    let width = HALF_WIDTH * [DEVIATION_MIN, disagreement, deviation(bulk)].map(|x| x * x).iter().sum::<f64>().sqrt();
    let (least, most) = (outliers.plug_in.min(outliers.cross), outliers.plug_in.max(outliers.cross));
    let of_outliers = HALF_WIDTH * deviation(outliers).hypot(DEVIATION_MIN);
    let low = bulk.cross * (-width).exp() + least * (-of_outliers).exp();
    let high = bulk.cross * width.exp() + most * (1.0 + of_outliers);
    ErrorEstimate {
        relmse: scale * (bulk.cross + (least * most).sqrt()),
        low: scale * low,
        high: scale * high,
        is_firefly_limited: high > SPAN_MAX * low,
    }
}

/// Terms of the pixels from row `first` on.
fn fill(film: &Film, first: usize, pixels: &mut [Terms]) {
    let width = film.width;
    // The rows that the window covers, from row `begin` on, and their sums.
    let mut rows: VecDeque<Vec<Channels>> = VecDeque::new();
    let mut begin = first.saturating_sub(REACH);
    let mut end = begin;
    let mut columns = vec![Window::default(); width];
    for (i, row) in pixels.chunks_mut(width).enumerate() {
        let y = first + i;
        while end < (y + REACH + 1).min(film.height) {
            rows.push_back((0..width).map(|x| channels(film, end * width + x)).collect());
            end += 1;
        }
        while begin + REACH < y {
            rows.pop_front();
            begin += 1;
        }
        columns.iter_mut().for_each(|column| *column = Window::default());
        for row in &rows {
            row.iter().zip(&mut columns).for_each(|(b, column)| add_moments(b, column));
        }
        for (x, terms) in row.iter_mut().enumerate() {
            let beside = x.saturating_sub(REACH)..(x + REACH + 1).min(width);
            let scale = 1.0 / (rows.len() * beside.len()) as f32;
            let mut window = Window::default();
            for column in &columns[beside] {
                for (sums, of_column) in window.iter_mut().zip(column) {
                    sums.iter_mut().zip(of_column).for_each(|(sum, x)| *sum += scale * x);
                }
            }
            *terms = pixel_terms(&rows[y - begin][x], &film.weights(y * width + x), &window);
        }
    }
}

fn channels(film: &Film, pixel: usize) -> Channels {
    let b = film.replicates(pixel);
    std::array::from_fn(|k| b.map(|b| b[k].min(BRIGHTEST) as f32))
}

fn add_moments(b: &Channels, sums: &mut Window) {
    for (b, sums) in b.iter().zip(sums) {
        for i in 0..REPLICATES {
            sums[i] += b[i];
            sums[REPLICATES + i] += b[i] * b[i];
        }
        for (sum, [i, j]) in sums[2 * REPLICATES..].iter_mut().zip(PAIRS) {
            *sum += b[i] * b[j];
        }
    }
}

/// Terms of a pixel from its replicates, their shares (none of them 0), and the mean moments of its surroundings.
fn pixel_terms(b: &Channels, weights: &[f64; REPLICATES], window: &Window) -> Terms {
    let weights = weights.map(|w| w as f32);
    let (mut plug_in, mut cross) = (0.0, 0.0);
    // Variance of one replicate by two of them, all channels together: these share their paths.
    let mut halves = [0.0f32; PAIRS.len()];
    for (b, around) in b.iter().zip(window) {
        let mean: f32 = b.iter().zip(weights).map(|(b, w)| w * b).sum();
        let g = 1.0 / (mean * mean + EPSILON as f32);
        let variance = b.iter().zip(weights).map(|(b, w)| w * (b - mean) * (b - mean)).sum::<f32>() / (REPLICATES - 1) as f32;
        plug_in += variance * g;
        for (pair, [i, j]) in PAIRS.into_iter().enumerate() {
            let rest = PAIRS.len() - 1 - pair;
            let [k, l] = PAIRS[rest];
            let square = (b[i] - b[j]) * (b[i] - b[j]);
            let share = weights[i] * weights[j] / (weights[i] + weights[j]);
            cross += square * share * reciprocal(0.5 * (b[k] + b[l]), k, l, around[2 * REPLICATES + rest], around);
            halves[pair] += 0.5 * square * g;
        }
    }
    let [a, b, c, d, e, f] = halves.map(f64::from);
    Terms {
        plug_in: f64::from(plug_in) / 3.0,
        cross: f64::from(cross) / (3 * PAIRS.len()) as f64,
        scatter: (a * f + b * e + c * d) / (18.0 * 9.0),
    }
}

/// `1 / (r^2 + 0.01)` where two replicates have this mean and their surroundings these moments.
fn reciprocal(mean: f32, k: usize, l: usize, product: f32, around: &[f32; MOMENTS]) -> f32 {
    let smooth = 0.5 * (around[k] + around[l]);
    let squares = around[REPLICATES + k] + around[REPLICATES + l];
    let noise = (0.25 * squares - 0.5 * product).max(0.0);
    // Cancellation leaves a rounding error, which must not look like a flat surrounding.
    let spread = (0.25 * squares + 0.5 * product - smooth * smooth).max(1e-6 * smooth * smooth) + 1e-30;
    let share = (SMOOTHING * noise / spread).min(1.0);
    let r = mean.max(mean + share * (smooth - mean));
    1.0 / (r * r + EPSILON as f32)
}

/// Unbiased variance of the mean of independent replicates, whose own variances are in inverse proportion to their weights.
pub(super) fn variance_of_mean(b: &[f64; REPLICATES], weights: &[f64; REPLICATES]) -> f64 {
    let mean: f64 = b.iter().zip(weights).map(|(b, w)| w * b).sum();
    b.iter().zip(weights).map(|(b, w)| w * (b - mean).powi(2)).sum::<f64>() / (REPLICATES - 1) as f64
}
