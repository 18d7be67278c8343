//! Which pixels get the next samples: those among noisy ones.
//!
//! A decision is taken at a few fixed totals from all samples so far. A pixel's own samples take no part in it: whoever goes on where the
//! samples were bright ends too bright (Kirk and Arvo 1991). What counts is the noise of its neighbours. Between decisions the number
//! of samples of a pixel is a function of the total alone, so a picture does not depend on how it was divided into passes.

use super::estimate::{EPSILON, variance_of_mean};
use super::film::Film;
use super::sampler::mix;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Samples per pixel at the first decision; each further one comes at four times the samples.
const FIRST: u32 = 16;
/// Pixels to each side whose noise counts.
const REACH: usize = 3;
/// Levels per doubling.
const OCTAVE: i32 = 64;
/// A pixel gets at most this many doublings more or less than the mean.
const RANGE: i32 = 2;

/// Whether pixels are to be weighed anew at this many samples per pixel.
pub(super) fn is_decision(spp: u32) -> bool {
    spp >= FIRST && spp.is_power_of_two() && (spp / FIRST).trailing_zeros().is_multiple_of(2)
}

/// The first decision after `spp` samples per pixel: no pass may cross it.
pub(super) fn next_decision(spp: u32) -> u32 {
    let mut decision = FIRST;
    while decision <= spp {
        decision = decision.saturating_mul(4);
    }
    decision
}

/// A decision.
#[derive(Clone, Debug)]
pub(super) struct Allocation {
    /// Samples that each pixel had then.
    pub(super) base: Vec<u32>,
    /// Logarithm of the number of samples it deserves, in [`OCTAVE`]ths of a doubling.
    pub(super) levels: Vec<i32>,
    /// Pixels by level and base.
    kinds: BTreeMap<(i32, u32), u64>,
}

impl Allocation {
    /// Weighs the pixels of a film in which every replicate of every pixel holds samples.
    ///
    /// The error of the picture is least for a given number of samples where these are in proportion to the standard deviation of a
    /// pixel's samples.
    pub(super) fn new(film: &Film) -> Self {
        let noise: Vec<f64> = (0..film.pixels()).map(|pixel| sample_variance(film, pixel)).collect();
        let priorities: Vec<f64> = (0..film.pixels()).map(|pixel| around(&noise, film, pixel).sqrt()).collect();
        let mean = priorities.iter().sum::<f64>() / priorities.len().max(1) as f64;
        let level = |(pixel, priority): (usize, &f64)| {
            // A little noise of its own keeps equal pixels from being served row by row.
            let dither = (mix(pixel as u32) % 17) as i32 - 8;
            let octaves = (priority / mean).log2();
            let octaves = if octaves.is_nan() { 0.0 } else { octaves.clamp(f64::from(-RANGE), f64::from(RANGE)) };
            (octaves * f64::from(OCTAVE)).round() as i32 + dither
        };
        let levels: Vec<i32> = priorities.iter().enumerate().map(level).collect();
        Self::of(film.samples(), levels)
    }

    /// The decision of these numbers, one of each per pixel.
    pub(super) fn of(base: Vec<u32>, levels: Vec<i32>) -> Self {
        let mut kinds = BTreeMap::new();
        for kind in levels.iter().copied().zip(base.iter().copied()) {
            *kinds.entry(kind).or_insert(0) += 1;
        }
        Self { base, levels, kinds }
    }

    /// Samples of each pixel when all together hold `total`, at least what they held at the decision. They never fall as the total grows.
    /// All are powers of two, which keeps their sequences whole, but for those still growing from an odd base and the one that takes
    /// the remainder.
    pub(super) fn counts(&self, total: u64) -> Vec<u32> {
        let sum =
            |height: i32| self.kinds.iter().map(|((level, base), n)| n * u64::from(count(height, *level, *base))).sum::<u64>();
        let (mut height, mut above) = (0, 30 * OCTAVE);
        while above - height > 1 {
            let middle = (height + above) / 2;
            if sum(middle) <= total { height = middle } else { above = middle }
        }
        let mut rest = total.saturating_sub(sum(height));
        let next = |(level, base): (&i32, &u32)| {
            let least = count(height, *level, *base);
            let more = u64::from(count(above, *level, *base) - least).min(rest);
            rest -= more;
            least + more as u32
        };
        self.levels.iter().zip(&self.base).map(next).collect()
    }
}

/// How many samples each pixel of a picture holds: worked out when it is asked for.
#[derive(Clone, Debug)]
pub struct SampleCounts {
    allocation: Option<Arc<Allocation>>,
    pixels: usize,
    total: u64,
}

impl SampleCounts {
    /// Those of a film in which every pixel holds samples, filled evenly up to the allocation and by it from there.
    pub(super) fn new(film: &Film, allocation: Option<&Arc<Allocation>>) -> Self {
        Self { allocation: allocation.cloned(), pixels: film.pixels(), total: film.total_samples() }
    }

    /// Samples of each pixel, row by row from the top.
    pub fn per_pixel(&self) -> Vec<u32> {
        match &self.allocation {
            Some(allocation) => allocation.counts(self.total),
            None => vec![(self.total / self.pixels.max(1) as u64) as u32; self.pixels],
        }
    }
}

/// The power of two nearest to what a pixel deserves.
fn count(height: i32, level: i32, base: u32) -> u32 {
    (1u32 << ((height + level + OCTAVE / 2).div_euclid(OCTAVE)).clamp(0, 30)).max(base)
}

/// Variance of a sample, relative to the pixel's brightness: the mean over channels.
fn sample_variance(film: &Film, pixel: usize) -> f64 {
    let (b, weights) = (film.replicates(pixel), film.weights(pixel));
    let relative = |k: usize| {
        let b = b.map(|b| b[k]);
        let mean: f64 = b.iter().zip(&weights).map(|(b, w)| w * b).sum();
        variance_of_mean(&b, &weights) / (mean * mean + EPSILON)
    };
    f64::from(film.count(pixel)) * (0..3).map(relative).sum::<f64>() / 3.0
}

/// Mean over the neighbourhood of a pixel, without the pixel. 0 where it has no neighbour.
fn around(values: &[f64], film: &Film, pixel: usize) -> f64 {
    let (x, y) = (pixel % film.width, pixel / film.width);
    let (mut sum, mut count) = (0.0, 0);
    for row in y.saturating_sub(REACH)..(y + REACH + 1).min(film.height) {
        for column in x.saturating_sub(REACH)..(x + REACH + 1).min(film.width) {
            if (column, row) != (x, y) {
                sum += values[row * film.width + column];
                count += 1;
            }
        }
    }
    sum / f64::from(count.max(1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::path::film::{Quota, REPLICATES};

    #[test]
    fn decisions_come_at_fixed_totals() {
        let decisions: Vec<u32> = (0..5000).filter(|spp| is_decision(*spp)).collect();
        assert_eq!(decisions, [16, 64, 256, 1024, 4096]);
        assert_eq!([0, 15, 16, 63, 64].map(next_decision), [16, 16, 64, 64, 256]);
    }

    #[test]
    fn samples_follow_the_levels_and_are_all_given_out() {
        let levels: Vec<i32> = (0..500).map(|i| -2 * OCTAVE + i * 4 * OCTAVE / 499).collect();
        let mut kinds = BTreeMap::new();
        levels.iter().for_each(|level| *kinds.entry((*level, 64)).or_insert(0) += 1);
        let allocation = Allocation { base: vec![64; 500], levels, kinds };
        let mut before = vec![64; 500];
        for spp in 64..=400 {
            let counts = allocation.counts(500 * spp);
            assert_eq!(counts.iter().map(|n| u64::from(*n)).sum::<u64>(), 500 * spp);
            assert!(counts.iter().zip(&before).all(|(a, b)| a >= b));
            assert!(counts.iter().filter(|n| !n.is_power_of_two()).count() <= 1);
            before = counts;
        }
        assert_eq!((before[0], before[499]), (64, 1024));
    }

    /// Adds samples that are 1 once in 64 times and else 0.
    fn add_spikes(film: &mut Film, quotas: &[Quota], seed: u32) {
        let target = film.begin();
        let mut cells = Vec::new();
        target.load(quotas, &mut cells);
        for (quota, cell) in quotas.iter().zip(&mut cells) {
            for _ in 0..quota.count {
                let random = mix(mix(quota.pixel ^ mix(seed)) ^ mix(cell.count + 1));
                if random < 1 << 26 {
                    cell.sums[cell.count as usize % REPLICATES].iter_mut().for_each(|sum| *sum += 1.0);
                }
                cell.count += 1;
            }
        }
        target.store(quotas, &cells);
        film.commit(quotas);
    }

    #[test]
    fn deciding_does_not_bias_the_mean() {
        // By a pixel's own noise, who was lucky would go on: 17 % too dark here.
        let (pictures, side) = (48, 40);
        let pixels = side * side;
        let mut sum = 0.0;
        for seed in 0..pictures {
            let mut film = Film::new(side, side);
            let first = film.evenly(FIRST);
            add_spikes(&mut film, &first, 91 * seed + 3);
            let counts = Allocation::new(&film).counts(3 * pixels as u64 * u64::from(FIRST) / 2);
            assert!(counts.iter().min() < counts.iter().max());
            let rest = film.up_to(&counts);
            add_spikes(&mut film, &rest, 91 * seed + 3);
            sum += film.mean().iter().map(|c| f64::from(c[0])).sum::<f64>();
        }
        let ratio = 64.0 * sum / (f64::from(pictures) * pixels as f64);
        // One standard deviation is below 0.8 %.
        assert!((ratio - 1.0).abs() < 0.03, "{ratio}");
    }
}
