//! The environment as a matt surface sees it: directions drawn in proportion to radiance times the cosine to a normal.
//!
//! Cells of the map are gathered into blocks. Within a block, cells are drawn by their radiance alone; blocks are drawn from tables, one for
//! each of [`SIDE`]² normals on an octahedron (Cigolle et al. 2014), by radiance times cosine. Between the three tables around a normal one is drawn at
//! random. Their barycentric weights make the normal of the three, and the cosine is convex where it is cut off at the horizon, so the
//! density is nowhere less than a fixed share of what it stands for: weights are bounded without another way to draw. On a level floor,
//! whose normal is one of the tables', only shadows are noise.

#![allow(clippy::needless_range_loop, reason = "one number runs over several arrays of lanes or axes")]

use super::distribution::{cell, cumulative, search};
use crate::lanes::Lanes;
use crate::vector::V3;
use std::f64::consts::{PI, TAU};

/// Rows of blocks; there are twice as many columns.
pub(super) const BLOCK_ROWS: usize = 32;
const BLOCK_COLUMNS: usize = 2 * BLOCK_ROWS;
const BLOCKS: usize = BLOCK_ROWS * BLOCK_COLUMNS;
/// Parts of a block, along each side, whose cosines are looked at.
const PARTS: usize = 2;
/// Normals along a side of the unfolded octahedron; odd, so that its corners are among them.
const SIDE: usize = 9;
/// Half of it: where its pole is.
const POLE: f64 = (SIDE / 2) as f64;

/// Tables of one map.
#[derive(Debug)]
pub(super) struct Irradiance {
    /// Rows and columns of cells of the map and of a block.
    rows: usize,
    columns: usize,
    per_block: usize,
    /// For each block: cumulative sums over its rows of cells, then within each of the rows.
    cell_rows: Vec<f32>,
    cell_columns: Vec<f32>,
    /// For each cell, row by row: its share of its block over its share of the block's area.
    cell_density: Vec<f32>,
    /// For each normal: cumulative sums over the rows of blocks, then within each of the rows.
    block_rows: Vec<f32>,
    block_columns: Vec<f32>,
    /// For each normal and block: irradiance by the block over its share of the map's area.
    block_density: Vec<f32>,
    /// For each normal: irradiance by all blocks, as the sum of rounded numbers.
    totals: Vec<f32>,
}

/// A normal's place between three tables.
#[derive(Clone, Copy, Debug)]
pub(super) struct Facing<L> {
    /// Numbers of the tables.
    tables: [L; 3],
    /// Their weights over the irradiance of all of them; zeros where there is none.
    weights: [L; 3],
    /// Probability of the first, and of the first two.
    shares: [L; 2],
}

impl Irradiance {
    /// Tables from the radiance of cells times their solid angles (any unit), row by row; `None` in the dark. `rows` is a multiple of
    /// [`BLOCK_ROWS`], `columns` is twice `rows`.
    pub(super) fn new(mass: &[f64], rows: usize, columns: usize) -> Option<Self> {
        let total: f64 = mass.iter().sum();
        if !(total.is_finite() && total > 0.0) {
            return None;
        }
        let per_block = rows / BLOCK_ROWS;
        let mut tables = Self {
            rows,
            columns,
            per_block,
            cell_rows: Vec::new(),
            cell_columns: Vec::new(),
            cell_density: vec![0.0; rows * columns],
            block_rows: Vec::new(),
            block_columns: Vec::new(),
            block_density: Vec::new(),
            totals: Vec::new(),
        };
        // Parts of blocks, as long as cells are fine enough for them.
        let parts = if per_block.is_multiple_of(PARTS) { PARTS } else { 1 };
        let mut part_mass = vec![0.0; BLOCKS * parts * parts];
        for block in 0..BLOCKS {
            let (top, left) = (block / BLOCK_COLUMNS * per_block, block % BLOCK_COLUMNS * per_block);
            tables.add_block(mass, top, left);
            for j in 0..per_block {
                for i in 0..per_block {
                    let part = j * parts / per_block * parts + i * parts / per_block;
                    part_mass[block * parts * parts + part] += mass[(top + j) * columns + left + i] / total;
                }
            }
        }
        let places = part_places(parts);
        for normal in 0..SIDE * SIDE {
            tables.add_normal(normal_of(normal), &part_mass, &places, parts);
        }
        Some(tables)
    }

    /// The cells of a block.
    fn add_block(&mut self, mass: &[f64], top: usize, left: usize) {
        let n = self.per_block;
        let row = |j: usize| &mass[(top + j) * self.columns + left..][..n];
        let sums: Vec<f64> = (0..n).map(|j| row(j).iter().sum()).collect();
        let p_row = cumulative(&sums, &mut self.cell_rows);
        for j in 0..n {
            let p_column = cumulative(row(j), &mut self.cell_columns);
            for i in 0..n {
                self.cell_density[(top + j) * self.columns + left + i] = (p_row[j] * p_column[i] * (n * n) as f64) as f32;
            }
        }
    }

    /// The blocks as a normal sees them.
    fn add_normal(&mut self, normal: [f64; 3], part_mass: &[f64], places: &[([f64; 3], f64)], parts: usize) {
        let length = normal.iter().map(|x| x * x).sum::<f64>().sqrt();
        let seen: Vec<f64> = part_mass
            .iter()
            .zip(places)
            .map(|(mass, (place, radius))| {
                let cos = (0..3).map(|k| normal[k] * place[k]).sum();
                mass * above_horizon(cos, radius * length)
            })
            .collect();
        let blocks: Vec<f64> = seen.chunks(parts * parts).map(|parts| parts.iter().sum()).collect();
        let rows: Vec<f64> = blocks.chunks(BLOCK_COLUMNS).map(|row| row.iter().sum()).collect();
        let total: f64 = rows.iter().sum();
        let p_row = cumulative(&rows, &mut self.block_rows);
        for (row, p_row) in blocks.chunks(BLOCK_COLUMNS).zip(p_row) {
            let p_column = cumulative(row, &mut self.block_columns);
            self.block_density.extend(p_column.iter().map(|p| (total * p_row * p * BLOCKS as f64) as f32));
        }
        self.totals.push(total as f32);
    }

    /// The tables around a unit normal, in the axes of the map.
    #[inline(always)]
    pub(super) fn facing<L: Lanes>(&self, n: V3<L>) -> Facing<L> {
        let (zero, one) = (L::zero(), L::one());
        let scale = one / (n.x.abs() + n.y.abs() + n.z.abs()).max(L::of(1e-30));
        let (ax, az) = (n.x.abs() * scale, n.z.abs() * scale);
        let is_lower = n.y.lt(zero);
        // A quarter of the unfolded octahedron, in steps of the tables from the pole.
        let x = (L::select(is_lower, one - az, ax) * L::of(POLE)).min(L::of(POLE));
        let z = (L::select(is_lower, one - ax, az) * L::of(POLE)).min(L::of(POLE));
        let (i, j) = (x.floor().min(L::of(POLE - 1.0)), z.floor().min(L::of(POLE - 1.0)));
        let (fx, fz) = (x - i, z - j);
        let is_far = (fx + fz).gt(one);
        let sx = L::select(n.x.lt(zero), -one, one);
        let sz = L::select(n.z.lt(zero), -one, one);
        let corner = L::select(is_far, one, zero);
        // No closures around lanes: they are not always inlined into code for wider instructions.
        let mut tables = [zero; 3];
        for (table, (i, j)) in tables.iter_mut().zip([(i + corner, j + corner), (i + one, j), (i, j + one)]) {
            *table = (L::of(POLE) + sz * j) * L::of(SIDE as f64) + L::of(POLE) + sx * i;
        }
        let weights =
            [L::select(is_far, fx + fz - one, one - fx - fz), L::select(is_far, one - fz, fx), L::select(is_far, one - fx, fz)];
        let mut seen = [zero; 3];
        for k in 0..3 {
            seen[k] = weights[k] * L::gather(&self.totals, tables[k]);
        }
        let sum = seen[0] + seen[1] + seen[2];
        let inverse = L::select(sum.gt(zero), one / L::select(sum.gt(zero), sum, one), zero);
        Facing {
            tables,
            weights: [weights[0] * inverse, weights[1] * inverse, weights[2] * inverse],
            shares: [seen[0] * inverse, (seen[0] + seen[1]) * inverse],
        }
    }

    /// A point `(u, v)` of the map from three numbers in `[0, 1)`, and its density over the map.
    #[inline(always)]
    pub(super) fn sample<L: Lanes>(&self, facing: &Facing<L>, [u0, u1, u2]: [L; 3]) -> (L, L, L) {
        let [first, second, third] = facing.tables;
        let table = L::select(u2.lt(facing.shares[0]), first, L::select(u2.lt(facing.shares[1]), second, third));
        let (row, fy, _) = search(&self.block_rows, table * L::of((BLOCK_ROWS + 1) as f64), BLOCK_ROWS, u1);
        let base = (table * L::of(BLOCK_ROWS as f64) + row) * L::of((BLOCK_COLUMNS + 1) as f64);
        let (column, fx, _) = search(&self.block_columns, base, BLOCK_COLUMNS, u0);
        let block = row * L::of(BLOCK_COLUMNS as f64) + column;
        let n = L::of(self.per_block as f64);
        let (j, fy, p_row) = search(&self.cell_rows, block * (n + L::one()), self.per_block, fy);
        let (i, fx, p_column) = search(&self.cell_columns, (block * n + j) * (n + L::one()), self.per_block, fx);
        let inside = p_row * p_column * (n * n);
        let u = (column * n + i + fx) * L::of(1.0 / self.columns as f64);
        let v = (row * n + j + fy) * L::of(1.0 / self.rows as f64);
        (u, v, inside * self.density_of_block(facing, block))
    }

    /// Density over the map at a point.
    #[inline(always)]
    pub(super) fn density<L: Lanes>(&self, facing: &Facing<L>, u: L, v: L) -> L {
        let inside = L::gather(&self.cell_density, cell(v, self.rows) * L::of(self.columns as f64) + cell(u, self.columns));
        let block = cell(v, BLOCK_ROWS) * L::of(BLOCK_COLUMNS as f64) + cell(u, BLOCK_COLUMNS);
        inside * self.density_of_block(facing, block)
    }

    #[inline(always)]
    fn density_of_block<L: Lanes>(&self, facing: &Facing<L>, block: L) -> L {
        let mut density = L::zero();
        for k in 0..3 {
            let at = facing.tables[k] * L::of(BLOCKS as f64) + block;
            density += facing.weights[k] * L::gather(&self.block_density, at);
        }
        density
    }
}

/// A point of the octahedron: the normal of a table, not of length 1.
fn normal_of(table: usize) -> [f64; 3] {
    let at = |i: usize| i as f64 / POLE - 1.0;
    let (a, b) = (at(table % SIDE), at(table / SIDE));
    let y = 1.0 - a.abs() - b.abs();
    if y >= 0.0 { [a, y, b] } else { [(1.0 - b.abs()).copysign(a), y, (1.0 - a.abs()).copysign(b)] }
}

/// Middle directions and angular radii of the parts of all blocks.
fn part_places(parts: usize) -> Vec<([f64; 3], f64)> {
    let (rows, columns) = ((BLOCK_ROWS * parts) as f64, (BLOCK_COLUMNS * parts) as f64);
    let mut places = Vec::with_capacity(BLOCKS * parts * parts);
    for block in 0..BLOCKS {
        for part in 0..parts * parts {
            let j = (block / BLOCK_COLUMNS * parts + part / parts) as f64 + 0.5;
            let i = (block % BLOCK_COLUMNS * parts + part % parts) as f64 + 0.5;
            let (phi, theta) = (i / columns * TAU, j / rows * PI);
            let across = theta.sin() * PI / columns;
            let radius = (PI / rows / 2.0).hypot(across.max(PI / columns * PI / rows));
            places.push(([theta.sin() * phi.sin(), theta.cos(), -theta.sin() * phi.cos()], radius));
        }
    }
    places
}

/// A cosine, cut off at the horizon, that stands for those up to `radius` above: at least half of the largest of them.
fn above_horizon(cos: f64, radius: f64) -> f64 {
    if cos >= radius { cos } else { (0.5 * (cos + radius)).max(0.0) }
}
