//! The error of a denoised picture, from the samples that its halves have not seen.
//!
//! Half `D1` is made from the replicates `R0, R1`, half `D2` from `R2, R3`; `t` is the truth. For fixed `D1`,
//!
//! ```text
//! E (D1 - R2)(D1 - R3) = (D1 - t)^2            since R2 and R3 are independent of D1 and of each other
//! (D - t)^2 = ((D1 - t)^2 + (D2 - t)^2) / 2 - (D1 - D2)^2 / 4      for D = (D1 + D2) / 2, exactly
//! ```
//!
//! so the squared error of the picture is estimated without bias, for any filter. Only the division by the squared truth is not exact. By
//! `D^2` it reads too low where rare bright samples enter numerator and denominator; by the square of the half that a numerator tests against,
//! too high. Between them lies the division by `D1 D2`, whose noise is not squared: that is reported, the two others widen the interval.

use super::Input;
use crate::path::ErrorEstimate;

/// Side of the blocks of pixels whose means estimate the spread of the error.
const BLOCK: usize = 8;
/// Added to squared values where errors are made relative.
const EPSILON: f64 = 0.01;
/// The two error estimates agree when they differ by less than this ratio.
const AGREEMENT: f64 = 1.15;

/// Error of the mean of two halves that were denoised apart.
pub(super) fn error(input: &Input, halves: &[Vec<[f32; 3]>; 2]) -> ErrorEstimate {
    let (columns, rows) = (input.width.div_ceil(BLOCK), input.height.div_ceil(BLOCK));
    // Sums of the three estimates, and how many terms there are.
    let mut blocks = vec![[0.0; 4]; columns * rows];
    for (pixel, ((replicates, d1), d2)) in input.replicates.iter().zip(&halves[0]).zip(&halves[1]).enumerate() {
        let block = &mut blocks[pixel / input.width / BLOCK * columns + pixel % input.width / BLOCK];
        for k in 0..3 {
            let terms = terms(replicates.map(|r| f64::from(r[k])), f64::from(d1[k]), f64::from(d2[k]));
            for (sum, term) in block.iter_mut().zip(terms) {
                *sum += term;
            }
            block[3] += 1.0;
        }
    }
    let all = [0, 1, 2].map(|which| summary(&blocks, which));
    let [[plug_in, _], [between, _], [cross, _]] = all;
    ErrorEstimate {
        relmse: between.max(0.0),
        low: all.iter().map(|[mean, width]| mean - width).fold(f64::INFINITY, f64::min).max(0.0),
        high: all.iter().map(|[mean, width]| mean + width).fold(0.0, f64::max),
        is_firefly_limited: !(cross <= plug_in * AGREEMENT && plug_in <= cross * AGREEMENT),
    }
}

/// The squared error of one channel of one pixel, divided in the three ways, lowest first.
fn terms(r: [f64; 4], d1: f64, d2: f64) -> [f64; 3] {
    let of_1 = (d1 - r[2]) * (d1 - r[3]);
    let of_2 = (d2 - r[0]) * (d2 - r[1]);
    let apart = 0.25 * (d1 - d2).powi(2);
    let squared_error = 0.5 * (of_1 + of_2) - apart;
    let relative = |square: f64| 1.0 / (square.max(0.0) + EPSILON);
    let (g1, g2) = (relative(d1 * d1), relative(d2 * d2));
    let cross = 0.5 * (g2 * of_1 + g1 * of_2) - 0.5 * (g1 + g2) * apart;
    [relative(0.25 * (d1 + d2).powi(2)) * squared_error, relative(d1 * d2) * squared_error, cross]
}

/// Mean over all terms, and half the width of its 95 % interval from the spread between blocks.
fn summary(blocks: &[[f64; 4]], which: usize) -> [f64; 2] {
    let total: f64 = blocks.iter().map(|b| b[3]).sum::<f64>().max(1.0);
    let mean = blocks.iter().map(|b| b[which]).sum::<f64>() / total;
    let count = blocks.len() as f64;
    let spread: f64 = blocks.iter().map(|b| (b[which] / b[3] - mean).powi(2)).sum();
    let error = if count > 1.0 { (spread / (count - 1.0) / count).sqrt() } else { mean.abs() };
    [mean, 1.96 * std::f64::consts::SQRT_2 * error]
}
