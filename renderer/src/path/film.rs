//! The picture: sums of samples in independent replicates, with its own number of samples for every pixel.

mod bytes;

use super::estimate::{EPSILON, ErrorEstimate, estimate, variance_of_mean};
use super::photon::Splat;
use std::ops::Range;
use std::sync::{Mutex, PoisonError};

/// Independent randomisations of the sample sequence. Sample `i` of a pixel belongs to replicate `i % REPLICATES`. Their differences
/// are the only honest measure of the error of low-discrepancy samples.
pub const REPLICATES: usize = 4;

/// Side of the squares of pixels that follow each other in the order of work.
const SQUARE: usize = 64;

/// What a pixel holds.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Cell {
    /// Sum of the samples of each replicate.
    pub sums: [[f64; 3]; REPLICATES],
    /// Samples.
    pub count: u32,
    /// Samples that met a surface.
    pub covered: u32,
}

/// Which part of a picture a film is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Window {
    /// Columns and rows of the picture.
    pub full: [usize; 2],
    /// Column and row of the picture where the film begins.
    pub at: [usize; 2],
}

/// Samples that a pass adds to a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Quota {
    /// Pixel, row by row from the top.
    pub pixel: u32,
    /// Samples, 1 at least.
    pub count: u32,
}

/// Sums of samples, per pixel and replicate.
#[derive(Clone, Debug)]
pub struct Film {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Where it lies in its picture.
    pub(super) window: Window,
    /// Samples of all pixels together.
    samples: u64,
    cells: Vec<Cell>,
    /// Sums of what photons brought, for each pixel and replicate; empty in a scene without them.
    splats: Vec<[[f64; 3]; REPLICATES]>,
    /// Photons emitted, by replicate.
    photons: [u64; REPLICATES],
    /// Samples per pixel that photons have been emitted for.
    photon_samples: u32,
    /// Where a pass in progress writes; becomes part of the film when it is complete.
    next: Vec<Cell>,
    /// Pixels in an order in which neighbours are near each other.
    order: Vec<u32>,
}

/// A pass in progress: threads put finished pixels in.
pub(super) struct PassTarget<'a> {
    cells: &'a [Cell],
    next: Mutex<&'a mut [Cell]>,
}

impl Film {
    /// A film without samples.
    pub fn new(width: usize, height: usize) -> Self {
        Self::of_window(width, height, Window { full: [width, height], at: [0, 0] })
    }

    /// A film of a part of a picture.
    pub(super) fn of_window(width: usize, height: usize, window: Window) -> Self {
        let pixels = width * height;
        let cells = vec![Cell::default(); pixels];
        Self {
            width,
            height,
            window,
            samples: 0,
            next: cells.clone(),
            cells,
            splats: Vec::new(),
            photons: [0; REPLICATES],
            photon_samples: 0,
            order: order(width, height),
        }
    }

    /// Samples per pixel: the mean over the picture, rounded down.
    pub fn spp(&self) -> u32 {
        (self.samples / self.cells.len().max(1) as u64) as u32
    }

    /// Samples of all pixels together.
    pub fn total_samples(&self) -> u64 {
        self.samples
    }

    /// Number of pixels.
    pub(super) fn pixels(&self) -> usize {
        self.cells.len()
    }

    /// Samples of each pixel, row by row from the top.
    pub fn samples(&self) -> Vec<u32> {
        self.cells.iter().map(|cell| cell.count).collect()
    }

    /// Samples of one pixel.
    pub(super) fn count(&self, pixel: usize) -> u32 {
        self.cells[pixel].count
    }

    /// Mean radiance of a pixel in each replicate: four independent estimates of the same number, linear Rec.709. Zeros in replicates
    /// without samples. Everything that the film tells about radiance is made of these.
    pub fn replicates(&self, pixel: usize) -> [[f64; 3]; REPLICATES] {
        let cell = &self.cells[pixel];
        let splats = self.splats.get(pixel);
        std::array::from_fn(|r| {
            let scale = 1.0 / replicate_count(cell.count, r).max(1.0);
            let photons = 1.0 / self.photons[r].max(1) as f64;
            std::array::from_fn(|k| cell.sums[r][k] * scale + splats.map_or(0.0, |s| s[r][k] * photons))
        })
    }

    /// Share of each replicate in the mean of a pixel: they sum to 1 and are equal where the number of samples is a multiple of
    /// [`REPLICATES`]. Zeros without samples.
    pub(super) fn weights(&self, pixel: usize) -> [f64; REPLICATES] {
        replicate_weights(self.cells[pixel].count)
    }

    /// The pixel whose samples stand for this one: itself as soon as it has any, before that one above and to the left.
    fn source(&self, pixel: usize) -> usize {
        if self.cells[pixel].count > 0 {
            return pixel;
        }
        let (x, y) = (pixel % self.width, pixel / self.width);
        let of = |side: usize| y / side * side * self.width + x / side * side;
        [2, 4, 8, 16, LATTICE].into_iter().map(of).find(|p| self.cells[*p].count > 0).unwrap_or(pixel)
    }

    /// Mean radiance per pixel, linear Rec.709, row by row from the top. Zeros without samples.
    pub fn mean(&self) -> Vec<[f32; 3]> {
        let mean = |pixel: usize| {
            let pixel = self.source(pixel);
            let (b, w) = (self.replicates(pixel), self.weights(pixel));
            std::array::from_fn(|k| (0..REPLICATES).map(|r| w[r] * b[r][k]).sum::<f64>() as f32)
        };
        (0..self.cells.len()).map(mean).collect()
    }

    /// Share of samples that met a surface, `[0, 1]`.
    pub fn alpha(&self) -> Vec<f32> {
        let alpha = |pixel: usize| {
            let cell = &self.cells[self.source(pixel)];
            cell.covered as f32 / cell.count.max(1) as f32
        };
        (0..self.cells.len()).map(alpha).collect()
    }

    /// Variance of the mean, per pixel and channel. Zeros where a replicate holds no sample.
    pub fn variance(&self) -> Vec<[f32; 3]> {
        let variance = |pixel: usize| {
            if (self.cells[pixel].count as usize) < REPLICATES {
                return [0.0; 3];
            }
            let (b, w) = (self.replicates(pixel), self.weights(pixel));
            std::array::from_fn(|k| variance_of_mean(&b.map(|b| b[k]), &w) as f32)
        };
        (0..self.cells.len()).map(variance).collect()
    }

    /// Standard error of the mean of each pixel relative to its brightness: the root of the mean over channels of variance over squared mean, to
    /// which a hundredth is added. Zeros where a replicate holds no sample.
    pub fn relative_error(&self) -> Vec<f32> {
        let one = |(variance, mean): ([f32; 3], [f32; 3])| {
            let terms = (0..3).map(|k| f64::from(variance[k]) / (f64::from(mean[k]).powi(2) + EPSILON));
            (terms.sum::<f64>() / 3.0).sqrt() as f32
        };
        self.variance().into_iter().zip(self.mean()).map(one).collect()
    }

    /// The error of the picture, estimated from its replicates. `None` until every replicate of every pixel holds a sample.
    pub fn error(&self) -> Option<ErrorEstimate> {
        self.error_by(1)
    }

    /// [`Film::error`], by some threads. The result does not depend on their number.
    pub fn error_by(&self, threads: usize) -> Option<ErrorEstimate> {
        if self.cells.is_empty() || self.cells.iter().any(|cell| (cell.count as usize) < REPLICATES) {
            return None;
        }
        Some(estimate(self, threads.max(1)))
    }

    /// `spp` more samples for every pixel.
    pub(super) fn evenly(&self, spp: u32) -> Vec<Quota> {
        if spp == 0 { Vec::new() } else { self.order.iter().map(|pixel| Quota { pixel: *pixel, count: spp }).collect() }
    }

    /// What is missing to `counts` samples of each pixel.
    pub(super) fn up_to(&self, counts: &[u32]) -> Vec<Quota> {
        let missing = |pixel: &u32| {
            let count = counts[*pixel as usize].saturating_sub(self.cells[*pixel as usize].count);
            (count > 0).then_some(Quota { pixel: *pixel, count })
        };
        self.order.iter().filter_map(missing).collect()
    }

    /// A first sample for every `side`-th pixel of every `side`-th row that has none.
    pub(super) fn lattice(&self, side: usize) -> Vec<Quota> {
        let is_due = |pixel: &&u32| {
            let (x, y) = (**pixel as usize % self.width, **pixel as usize / self.width);
            x.is_multiple_of(side) && y.is_multiple_of(side) && self.cells[**pixel as usize].count == 0
        };
        self.order.iter().filter(is_due).map(|pixel| Quota { pixel: *pixel, count: 1 }).collect()
    }

    /// The first `total` samples of a picture that has not yet one in every pixel: coarse lattices before finer ones.
    pub(super) fn beginning(&self, total: usize) -> Vec<Quota> {
        let mut quotas = Vec::with_capacity(total);
        let mut side = LATTICE;
        while quotas.len() < total && side > 0 {
            let is_coarser = |x: usize, y: usize| side < LATTICE && x.is_multiple_of(2 * side) && y.is_multiple_of(2 * side);
            let is_new = |quota: &Quota| !is_coarser(quota.pixel as usize % self.width, quota.pixel as usize / self.width);
            quotas.extend(self.lattice(side).into_iter().filter(is_new).take(total - quotas.len()));
            side /= 2;
        }
        quotas
    }

    /// The samples per pixel that a pass owes photons for: those of the mean over the picture.
    pub(super) fn photon_samples_due(&self, quotas: &[Quota]) -> Range<u32> {
        let samples = self.samples + quotas.iter().map(|quota| u64::from(quota.count)).sum::<u64>();
        self.photon_samples..(samples / self.cells.len().max(1) as u64) as u32
    }

    /// The pixel of the film that a pixel of its picture is, if it is one.
    fn pixel_of(&self, pixel: u32) -> Option<usize> {
        let Window { full, at } = self.window;
        let (x, y) = ((pixel as usize % full[0]).checked_sub(at[0])?, (pixel as usize / full[0]).checked_sub(at[1])?);
        (x < self.width && y < self.height).then_some(y * self.width + x)
    }

    /// Adds what a number of photons of a replicate brought to pixels of the picture.
    pub(super) fn add_photons(&mut self, replicate: usize, emitted: u64, splats: &[Splat]) {
        if self.splats.is_empty() {
            self.splats = vec![[[0.0; 3]; REPLICATES]; self.cells.len()];
        }
        self.photons[replicate] += emitted;
        for splat in splats {
            let Some(pixel) = self.pixel_of(splat.pixel) else { continue };
            for (sum, light) in self.splats[pixel][replicate].iter_mut().zip(splat.light) {
                *sum += f64::from(light);
            }
        }
    }

    /// Opens the film for a pass.
    pub(super) fn begin(&mut self) -> PassTarget<'_> {
        PassTarget { cells: &self.cells, next: Mutex::new(&mut self.next) }
    }

    /// Makes a completed pass part of the film. Without this call the film is as before.
    pub(super) fn commit(&mut self, quotas: &[Quota]) {
        if quotas.len() == self.cells.len() {
            std::mem::swap(&mut self.cells, &mut self.next);
        } else {
            for quota in quotas {
                self.cells[quota.pixel as usize] = self.next[quota.pixel as usize];
            }
        }
        self.photon_samples = self.photon_samples_due(quotas).end;
        self.samples += quotas.iter().map(|quota| u64::from(quota.count)).sum::<u64>();
    }
}

/// Widest spacing of the pixels that a first pass may start with.
pub(super) const LATTICE: usize = 32;

/// Samples of one replicate of a pixel that holds `count`.
fn replicate_count(count: u32, replicate: usize) -> f64 {
    f64::from((count + (REPLICATES - 1 - replicate) as u32) / REPLICATES as u32)
}

/// Share of each replicate in the mean of a pixel that holds `count` samples.
pub(super) fn replicate_weights(count: u32) -> [f64; REPLICATES] {
    let scale = 1.0 / f64::from(count.max(1));
    std::array::from_fn(|r| replicate_count(count, r) * scale)
}

/// All pixels, square by square and within a square along a Z-order curve: any run of them is compact.
fn order(width: usize, height: usize) -> Vec<u32> {
    // Every second bit of a number.
    let half = |z: usize| (0..6).fold(0, |x, bit| x | (z >> (2 * bit) & 1) << bit);
    let square: Vec<(usize, usize)> = (0..SQUARE * SQUARE).map(|z| (half(z), half(z >> 1))).collect();
    let mut order = Vec::with_capacity(width * height);
    for y in (0..height).step_by(SQUARE) {
        for x in (0..width).step_by(SQUARE) {
            let inside = square.iter().filter(|(i, j)| x + i < width && y + j < height);
            order.extend(inside.map(|(i, j)| ((y + j) * width + x + i) as u32));
        }
    }
    order
}

impl PassTarget<'_> {
    /// Copies what some pixels hold so far. Samples are then added one by one in the order of their numbers, so the sums do not depend
    /// on how samples are divided into passes, batches and threads, to the bit.
    pub(super) fn load(&self, quotas: &[Quota], cells: &mut Vec<Cell>) {
        cells.clear();
        cells.extend(quotas.iter().map(|quota| self.cells[quota.pixel as usize]));
    }

    /// Stores finished pixels.
    pub(super) fn store(&self, quotas: &[Quota], cells: &[Cell]) {
        // A thread that panicked while holding the lock ends the pass with its panic; until then data are whole pixels.
        let mut next = self.next.lock().unwrap_or_else(PoisonError::into_inner);
        for (quota, cell) in quotas.iter().zip(cells) {
            next[quota.pixel as usize] = *cell;
        }
    }
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
                    film.cells[pixel].sums[i as usize % REPLICATES][k] += x;
                }
            }
            film.cells[pixel].count = spp;
            truth += (total / f64::from(spp) - mean).powi(2) / (mean * mean + 0.01);
        }
        film.samples = 64 * 64 * u64::from(spp);
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

    /// A film of even light and a share of samples 400 times as bright, after 64 samples per pixel, and its true error.
    fn fireflies(share: f64, seed: u32) -> (Film, f64) {
        let limit = 0.5 + share * 199.5;
        let (mut film, mut truth) = (Film::new(64, 64), 0.0);
        for (pixel, cell) in film.cells.iter_mut().enumerate() {
            for i in 0..64u32 {
                let random = f64::from(mix(mix(pixel as u32 ^ mix(seed + 77)) ^ mix(i + 1))) / 4_294_967_296.0;
                let x = if random < share { 200.0 } else { 0.5 };
                cell.sums[i as usize % REPLICATES].iter_mut().for_each(|sum| *sum += x);
            }
            cell.count = 64;
            let mean: f64 = cell.sums.iter().map(|sum| sum[0]).sum::<f64>() / 64.0;
            truth += (mean - limit).powi(2) / (limit * limit + 0.01) / 4096.0;
        }
        (film, truth)
    }

    #[test]
    fn the_interval_holds_an_error_of_fireflies() {
        // About 100 of 4096 pixels: many alike are known well. About 10: each could as well show something bright.
        for (share, is_known) in [(4e-4, true), (4e-5, false)] {
            let mut inside = 0;
            for seed in 0..20 {
                let (film, truth) = fireflies(share, seed);
                let e = film.error().expect("every replicate has samples");
                assert_eq!(film.error_by(3), Some(e));
                inside += u32::from(e.low <= truth && truth <= e.high);
                let is_near = (e.relmse / truth - 1.0).abs() < 0.35;
                assert!(if is_known { is_near } else { e.is_firefly_limited }, "{e:?} {truth}");
            }
            assert!(inside >= 18, "{share}: {inside} of 20");
        }
    }

    #[test]
    fn uneven_replicates_are_weighed() {
        // 5 samples: 2, 1, 1, 1. With equal weights the estimate would be off by 7 %.
        let (mut sum, mut truth) = (0.0, 0.0);
        for seed in 0..20 {
            let (film, true_error) = synthetic(5, seed * 31 + 2);
            let variance = film.variance();
            for (pixel, v) in variance.iter().enumerate() {
                let mean = 0.05 + (pixel % 64) as f64 / 40.0;
                sum += f64::from(v[0]) / (mean * mean + 0.01);
            }
            truth += 4096.0 * true_error;
        }
        assert!((sum / truth - 1.0).abs() < 0.03, "{}", sum / truth);
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

    #[test]
    fn every_pixel_is_ordered_once_and_holes_are_filled() {
        for (width, height) in [(1, 1), (17, 9), (130, 70)] {
            let mut pixels = order(width, height);
            pixels.sort_unstable();
            assert!(pixels.iter().enumerate().all(|(i, p)| i == *p as usize) && pixels.len() == width * height);
        }
        let mut film = Film::new(20, 10);
        for side in [8, 4, 2, 1] {
            for quota in film.lattice(side) {
                let (x, y) = (quota.pixel % 20, quota.pixel / 20);
                film.cells[quota.pixel as usize] =
                    Cell { sums: [[f64::from(x), f64::from(y), 1.0], [0.0; 3], [0.0; 3], [0.0; 3]], count: 1, covered: 1 };
            }
            let (side, mean) = (side as f32, film.mean());
            for (pixel, [x, y, one]) in mean.iter().enumerate() {
                let nearest = |a: usize| (a as f32 / side).floor() * side;
                assert_eq!([*x, *y, *one], [nearest(pixel % 20), nearest(pixel / 20), 1.0]);
            }
            assert!(film.alpha().iter().all(|a| *a == 1.0));
        }
        assert_eq!(film.lattice(1), []);
    }
}
