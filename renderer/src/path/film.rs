//! The picture: sums of samples in independent replicates, and what they tell about its error.

use std::sync::Mutex;

/// Independent randomisations of the sample sequence. Sample `i` belongs to replicate `i % REPLICATES`. Their differences are the only
/// honest measure of the error of low-discrepancy samples.
pub const REPLICATES: usize = 4;

/// Side of the blocks of pixels whose means estimate the spread of the error.
const BLOCK: usize = 8;
/// Added to squared values where errors are made relative.
const EPSILON: f64 = 0.01;
/// The two error estimates agree when they differ by less than this ratio.
const AGREEMENT: f64 = 1.15;

/// Sums of samples, per pixel and replicate.
#[derive(Clone, Debug)]
pub struct Film {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    spp: u32,
    /// `REPLICATES` sums for each pixel, row by row.
    sums: Vec<[f64; 3]>,
    /// Samples that met a surface, per pixel.
    covered: Vec<u32>,
    /// Where a pass in progress writes; swapped in when it is complete.
    next_sums: Vec<[f64; 3]>,
    next_covered: Vec<u32>,
}

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
    /// Rare bright samples dominate: the estimates from below and above differ by more than 15 %, and `relmse` is their mean.
    pub is_firefly_limited: bool,
}

/// A pass in progress: threads put finished tiles in.
pub(super) struct PassTarget<'a> {
    width: usize,
    sums: &'a [[f64; 3]],
    covered: &'a [u32],
    next: Mutex<(&'a mut [[f64; 3]], &'a mut [u32])>,
}

impl Film {
    /// A film without samples.
    pub fn new(width: usize, height: usize) -> Self {
        let pixels = width * height;
        Self {
            width,
            height,
            spp: 0,
            sums: vec![[0.0; 3]; pixels * REPLICATES],
            covered: vec![0; pixels],
            next_sums: vec![[0.0; 3]; pixels * REPLICATES],
            next_covered: vec![0; pixels],
        }
    }

    /// Samples per pixel.
    pub fn spp(&self) -> u32 {
        self.spp
    }

    /// Mean radiance per pixel, linear Rec.709, row by row from the top. Zeros without samples.
    pub fn mean(&self) -> Vec<[f32; 3]> {
        let scale = 1.0 / f64::from(self.spp.max(1));
        let sum = |r: &[[f64; 3]]| std::array::from_fn(|k| (r.iter().map(|s| s[k]).sum::<f64>() * scale) as f32);
        self.sums.chunks(REPLICATES).map(sum).collect()
    }

    /// Mean radiance of each replicate, per pixel. Zeros where a replicate holds no sample.
    pub fn replicates(&self) -> Vec<[[f32; 3]; REPLICATES]> {
        let counts = self.counts().map(|n| n.max(1.0));
        let means = |r: &[[f64; 3]]| std::array::from_fn(|i| r[i].map(|sum| (sum / counts[i]) as f32));
        self.sums.chunks(REPLICATES).map(means).collect()
    }

    /// Share of samples that met a surface, `[0, 1]`.
    pub fn alpha(&self) -> Vec<f32> {
        let scale = 1.0 / self.spp.max(1) as f32;
        self.covered.iter().map(|c| *c as f32 * scale).collect()
    }

    /// Variance of the mean, per pixel and channel. Zeros until every replicate holds a sample.
    pub fn variance(&self) -> Vec<[f32; 3]> {
        if (self.spp as usize) < REPLICATES {
            return vec![[0.0; 3]; self.width * self.height];
        }
        let counts = self.counts();
        self.sums.chunks(REPLICATES).map(|r| std::array::from_fn(|k| variance_of_mean(&means(r, &counts, k)) as f32)).collect()
    }

    /// Samples in each replicate.
    fn counts(&self) -> [f64; REPLICATES] {
        std::array::from_fn(|r| f64::from((self.spp + (REPLICATES - 1 - r) as u32) / REPLICATES as u32))
    }

    /// The error of the picture, estimated from its replicates. `None` until every replicate holds a sample.
    ///
    /// Two estimates bracket the truth. The plug-in one divides the variance by the squared mean of the same samples: too low, since a
    /// bright accident enters both. The cross one divides the squared difference of two replicates by the mean of the two others: too
    /// high by Jensen's inequality, which a second-order term corrects. Where they agree within 15 % the cross estimate is reported, else
    /// their mean. The interval reaches from the lower end of the first to the upper end of the second; widths come from the spread
    /// over blocks of 8 by 8 pixels, times sqrt(2) because the error of this one picture fluctuates as well.
    pub fn error(&self) -> Option<ErrorEstimate> {
        let counts = self.counts();
        if counts.contains(&0.0) || self.width * self.height == 0 {
            return None;
        }
        let (columns, rows) = (self.width.div_ceil(BLOCK), self.height.div_ceil(BLOCK));
        let mut plug_in = vec![0.0; columns * rows];
        let mut cross = vec![0.0; columns * rows];
        let mut weight = vec![0.0; columns * rows];
        for (pixel, sums) in self.sums.chunks(REPLICATES).enumerate() {
            let block = pixel / self.width / BLOCK * columns + pixel % self.width / BLOCK;
            for k in 0..3 {
                let b = means(sums, &counts, k);
                plug_in[block] += plug_in_term(&b);
                cross[block] += cross_term(&b);
            }
            weight[block] += 3.0;
        }
        let summary = |sums: &[f64]| {
            let total: f64 = weight.iter().sum();
            let mean = sums.iter().sum::<f64>() / total;
            let blocks = sums.len() as f64;
            let spread: f64 = sums.iter().zip(&weight).map(|(s, w)| (s / w - mean).powi(2)).sum();
            let error = if blocks > 1.0 { (spread / (blocks - 1.0) / blocks).sqrt() } else { mean };
            (mean, 1.96 * std::f64::consts::SQRT_2 * error)
        };
        let (p, p_width) = summary(&plug_in);
        let (e, e_width) = summary(&cross);
        let agrees = e <= p * AGREEMENT && p <= e * AGREEMENT;
        Some(ErrorEstimate {
            relmse: if agrees { e.max(0.0) } else { 0.5 * (p + e) },
            low: (p - p_width).min(e - e_width).max(0.0),
            high: (p + p_width).max(e + e_width),
            is_firefly_limited: !agrees,
        })
    }

    /// Opens the film for a pass.
    pub(super) fn begin(&mut self) -> PassTarget<'_> {
        PassTarget {
            width: self.width,
            sums: &self.sums,
            covered: &self.covered,
            next: Mutex::new((&mut self.next_sums, &mut self.next_covered)),
        }
    }

    /// Makes a completed pass of `spp` samples part of the film. Without this call the film is as before.
    pub(super) fn commit(&mut self, spp: u32) {
        std::mem::swap(&mut self.sums, &mut self.next_sums);
        std::mem::swap(&mut self.covered, &mut self.next_covered);
        self.spp += spp;
    }
}

impl PassTarget<'_> {
    /// Copies what a tile holds so far. Samples are then added one by one in the order of their numbers, so the sums do not depend on
    /// how samples are divided into passes, tiles and threads, to the bit.
    pub(super) fn load(&self, tile: [usize; 4], sums: &mut Vec<[f64; 3]>, covered: &mut Vec<u32>) {
        sums.clear();
        covered.clear();
        let [x, y, width, height] = tile;
        for row in y..y + height {
            let first = row * self.width + x;
            sums.extend_from_slice(&self.sums[first * REPLICATES..(first + width) * REPLICATES]);
            covered.extend_from_slice(&self.covered[first..first + width]);
        }
    }

    /// Stores a finished tile.
    pub(super) fn store(&self, tile: [usize; 4], sums: &[[f64; 3]], covered: &[u32]) {
        let [x, y, width, height] = tile;
        // A thread that panicked while holding the lock ends the pass with its panic; until then data are whole tiles.
        let mut next = self.next.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        for row in 0..height {
            let first = (y + row) * self.width + x;
            next.0[first * REPLICATES..(first + width) * REPLICATES]
                .copy_from_slice(&sums[row * width * REPLICATES..(row + 1) * width * REPLICATES]);
            next.1[first..first + width].copy_from_slice(&covered[row * width..(row + 1) * width]);
        }
    }
}

fn means(sums: &[[f64; 3]], counts: &[f64; REPLICATES], channel: usize) -> [f64; REPLICATES] {
    std::array::from_fn(|r| sums[r][channel] / counts[r])
}

fn variance_of_mean(b: &[f64; REPLICATES]) -> f64 {
    let n = REPLICATES as f64;
    let mean = b.iter().sum::<f64>() / n;
    b.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (n * (n - 1.0))
}

fn plug_in_term(b: &[f64; REPLICATES]) -> f64 {
    let mean = b.iter().sum::<f64>() / REPLICATES as f64;
    variance_of_mean(b) / (mean * mean + EPSILON)
}

/// Mean over the six ways to take two replicates for the numerator and the two others for the denominator.
fn cross_term(b: &[f64; REPLICATES]) -> f64 {
    const PAIRS: [[usize; 4]; 6] = [[0, 1, 2, 3], [0, 2, 1, 3], [0, 3, 1, 2], [1, 2, 0, 3], [1, 3, 0, 2], [2, 3, 0, 1]];
    let term = |[i, j, k, l]: [usize; 4]| {
        let numerator = (b[i] - b[j]).powi(2) / (2.0 * REPLICATES as f64);
        let mean = 0.5 * (b[k] + b[l]);
        let v = 0.25 * (b[k] - b[l]).powi(2);
        let g = 1.0 / (mean * mean + EPSILON);
        let second = (6.0 * mean * mean - 2.0 * EPSILON) * g * g * g;
        numerator * (g - 0.5 * second * v).max(0.2 * g)
    };
    PAIRS.into_iter().map(term).sum::<f64>() / PAIRS.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::path::sampler::mix;

    /// A film of exponential noise around known means.
    fn synthetic(spp: u32, seed: u32) -> (Film, f64) {
        let mut film = Film::new(64, 64);
        let mut truth = 0.0;
        for pixel in 0..64 * 64 {
            let mean = 0.05 + (pixel % 64) as f64 / 40.0;
            let mut total = 0.0;
            for i in 0..spp {
                let u = f64::from(mix(mix(pixel as u32 ^ seed) ^ mix(i + 1))) / 4_294_967_296.0;
                let x = -mean * (1.0 - u).ln();
                total += x;
                for k in 0..3 {
                    film.sums[pixel * REPLICATES + i as usize % REPLICATES][k] += x;
                }
            }
            truth += (total / f64::from(spp) - mean).powi(2) / (mean * mean + EPSILON);
        }
        film.spp = spp;
        (film, truth / (64.0 * 64.0))
    }

    #[test]
    fn the_interval_holds_the_true_error() {
        let mut inside = 0;
        for seed in 0..20 {
            let (film, truth) = synthetic(64, seed * 977 + 5);
            let e = film.error().expect("every replicate has samples");
            assert!(!e.is_firefly_limited, "{e:?}");
            assert!((e.relmse / truth - 1.0).abs() < 0.15, "{e:?} {truth}");
            assert!(e.low <= e.relmse && e.relmse <= e.high);
            inside += u32::from(e.low <= truth && truth <= e.high);
        }
        assert!(inside >= 18, "{inside} of 20");
    }

    #[test]
    fn there_is_no_error_without_a_sample_in_every_replicate() {
        assert_eq!(synthetic(3, 1).0.error(), None);
        assert!(synthetic(4, 1).0.error().is_some());
        assert_eq!(Film::new(0, 0).error(), None);
    }

    #[test]
    fn variance_is_that_of_the_mean() {
        let (film, _) = synthetic(64, 3);
        let variance = film.variance();
        // Exponential noise has the variance mean^2.
        let (mut sum, mut expected) = (0.0, 0.0);
        for (pixel, v) in variance.iter().enumerate() {
            let mean = 0.05 + (pixel % 64) as f64 / 40.0;
            sum += f64::from(v[0]);
            expected += mean * mean / 64.0;
        }
        assert!((sum / expected - 1.0).abs() < 0.05, "{sum} {expected}");
    }
}
