//! Numbers drawn from a table of cells over the unit square: rows by their sums, columns within a row.
//!
//! Cumulative tables and no alias table: they keep neighbouring numbers in neighbouring cells, and with that the stratification of the
//! samples.

use crate::lanes::Lanes;

/// Least share of anything that has weight: several steps of single precision.
const SHARE_MIN: f64 = 1e-6;

/// Probabilities of the cells of a grid over the unit square; within a cell they are uniform.
#[derive(Debug)]
pub(super) struct Distribution {
    rows: usize,
    columns: usize,
    /// `rows + 1` values from 0 to 1.
    marginal: Vec<f32>,
    /// `rows` times `columns + 1` values from 0 to 1.
    conditional: Vec<f32>,
    /// Probability of each cell times the number of cells, as the rounded tables give it.
    density: Vec<f32>,
}

impl Distribution {
    /// Cells in proportion to `mass`, row by row, at least 0; `None` if there is no mass. In double precision until the tables are stored.
    pub(super) fn new(mass: &[f64], rows: usize, columns: usize) -> Option<Self> {
        let total: f64 = mass.iter().sum();
        if !(total.is_finite() && total > 0.0) {
            return None;
        }
        let sums: Vec<f64> = mass.chunks(columns).map(|row| row.iter().sum()).collect();
        let mut marginal = Vec::with_capacity(rows + 1);
        let p_row = cumulative(&sums, &mut marginal);
        let mut conditional = Vec::with_capacity(rows * (columns + 1));
        let mut density = Vec::with_capacity(rows * columns);
        let cells = (rows * columns) as f64;
        for (row, p_row) in mass.chunks(columns).zip(p_row) {
            let p_column = cumulative(row, &mut conditional);
            density.extend(p_column.iter().map(|p| (p_row * p * cells) as f32));
        }
        Some(Self { rows, columns, marginal, conditional, density })
    }

    /// Cumulative rows, cumulative columns of each row, densities: one after the other.
    pub(super) fn flat(&self) -> Vec<f32> {
        [&self.marginal[..], &self.conditional, &self.density].concat()
    }

    /// A point `(u, v)` of the unit square from two numbers in `[0, 1)`, and its density over the square.
    #[inline(always)]
    pub(super) fn sample<L: Lanes>(&self, u0: L, u1: L) -> (L, L, L) {
        let (row, fy, _) = search(&self.marginal, L::zero(), self.rows, u1);
        let (column, fx, _) = search(&self.conditional, row * L::of((self.columns + 1) as f64), self.columns, u0);
        let u = (column + fx) * L::of(1.0 / self.columns as f64);
        let v = (row + fy) * L::of(1.0 / self.rows as f64);
        (u, v, L::gather(&self.density, row * L::of(self.columns as f64) + column))
    }

    /// Density over the square at a point.
    #[inline(always)]
    pub(super) fn density<L: Lanes>(&self, u: L, v: L) -> L {
        L::gather(&self.density, cell(v, self.rows) * L::of(self.columns as f64) + cell(u, self.columns))
    }
}

/// Appends cumulative shares of weights, from 0 to 1, and returns the shares as the rounded numbers give them. What has weight has a
/// share that rounding does not lose; without any weight all shares are equal.
pub(super) fn cumulative(weights: &[f64], out: &mut Vec<f32>) -> Vec<f64> {
    let sum: f64 = weights.iter().sum();
    let least = if sum > 0.0 { sum * SHARE_MIN } else { 1.0 };
    let raised = |w: f64| if w > 0.0 || sum <= 0.0 { w.max(least) } else { 0.0 };
    let sum: f64 = weights.iter().map(|w| raised(*w)).sum();
    let first = out.len();
    out.push(0.0);
    let mut running = 0.0;
    for w in weights {
        running += raised(*w);
        out.push((running / sum).min(1.0) as f32);
    }
    // Exactly 1 from the last that holds anything, so that no number below 1 falls behind it.
    let end = out[out.len() - 1];
    for value in &mut out[first..] {
        if *value == end {
            *value = 1.0;
        }
    }
    out[first..].windows(2).map(|c| f64::from(c[1]) - f64::from(c[0])).collect()
}

/// The cell of `n` that a number in `[0, 1]` lies in.
#[inline(always)]
pub(super) fn cell<L: Lanes>(x: L, n: usize) -> L {
    (x * L::of(n as f64)).floor().max(L::zero()).min(L::of((n - 1) as f64))
}

/// Largest `i < count` with `table[base + i] <= u`, where `u` lies between it and the next, `[0, 1)`, and the step between the two.
#[inline(always)]
pub(super) fn search<L: Lanes>(table: &[f32], base: L, count: usize, u: L) -> (L, L, L) {
    let mut found = L::zero();
    let mut step = count.next_power_of_two() / 2;
    while step > 0 {
        let candidate = found + L::of(step as f64);
        let is_inside = candidate.lt(L::of(count as f64));
        let value = L::gather(table, base + candidate);
        found = L::select(is_inside & value.le(u), candidate, found);
        step /= 2;
    }
    let (low, high) = (L::gather(table, base + found), L::gather(table, base + found + L::one()));
    let is_empty = high.le(low);
    let fraction = (u - low) / L::select(is_empty, L::one(), high - low);
    (found, fraction.max(L::zero()).min(L::of(1.0 - 1.0 / 16_777_216.0)), high - low)
}
