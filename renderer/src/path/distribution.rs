//! Numbers drawn from a table of cells over the unit square: rows by their sums, columns within a row.
//!
//! Cumulative tables and no alias table: they keep neighbouring numbers in neighbouring cells, and with that the stratification of the
//! samples.

use crate::lanes::Lanes;

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
        let cumulative = |weights: &mut dyn Iterator<Item = f64>, count: usize, sum: f64, out: &mut Vec<f32>| {
            let mut running = 0.0;
            let first = out.len();
            out.push(0.0);
            for (i, w) in weights.enumerate() {
                running += w;
                let value = if sum > 0.0 { running / sum } else { (i + 1) as f64 / count as f64 };
                out.push(value.min(1.0) as f32);
            }
            // Exactly 1 from the last cell that holds anything, so that no number below 1 falls behind it.
            let last = out.len() - 1;
            let end = out[last];
            for value in &mut out[first..] {
                if *value == end {
                    *value = 1.0;
                }
            }
        };
        let sums: Vec<f64> = mass.chunks(columns).map(|row| row.iter().sum()).collect();
        let mut marginal = Vec::with_capacity(rows + 1);
        cumulative(&mut sums.iter().copied(), rows, total, &mut marginal);
        let mut conditional = Vec::with_capacity(rows * (columns + 1));
        for (row, sum) in mass.chunks(columns).zip(&sums) {
            cumulative(&mut row.iter().copied(), columns, *sum, &mut conditional);
        }
        let cells = (rows * columns) as f64;
        let mut density = Vec::with_capacity(rows * columns);
        for j in 0..rows {
            // What the single-precision tables really give.
            let p = f64::from(marginal[j + 1]) - f64::from(marginal[j]);
            let row = &conditional[j * (columns + 1)..(j + 1) * (columns + 1)];
            density.extend(row.windows(2).map(|c| (p * (f64::from(c[1]) - f64::from(c[0])) * cells) as f32));
        }
        Some(Self { rows, columns, marginal, conditional, density })
    }

    /// A point `(u, v)` of the unit square from two numbers in `[0, 1)`, and its density over the square.
    #[inline(always)]
    pub(super) fn sample<L: Lanes>(&self, u0: L, u1: L) -> (L, L, L) {
        let (row, fy) = search(&self.marginal, L::zero(), self.rows, u1);
        let (column, fx) = search(&self.conditional, row * L::of((self.columns + 1) as f64), self.columns, u0);
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

/// The cell of `n` that a number in `[0, 1]` lies in.
#[inline(always)]
fn cell<L: Lanes>(x: L, n: usize) -> L {
    (x * L::of(n as f64)).floor().max(L::zero()).min(L::of((n - 1) as f64))
}

/// Largest `i < count` with `table[base + i] <= u`, and where `u` lies between it and the next, `[0, 1)`.
#[inline(always)]
fn search<L: Lanes>(table: &[f32], base: L, count: usize, u: L) -> (L, L) {
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
    (found, fraction.max(L::zero()).min(L::of(1.0 - 1.0 / 16_777_216.0)))
}
