//! A grid of distances over one body: how far the nearest surface is, and in which direction, for the price of one look.
//!
//! Cells are filled when a walk first asks for them. What a cell holds depends on the triangles alone, so it does not matter which thread
//! fills it.

use crate::bvh::{Bvh, Nearest};
use glam::{DVec3, Vec3};
use std::sync::atomic::{AtomicU64, Ordering};

/// Cells along the longest extent of the body.
const CELLS: f64 = 64.0;
/// How much farther than the nearest surface the one that a cell holds may be.
const TOLERANCE: f64 = 0.1;

/// The grid; empty cells hold 0.
#[derive(Debug)]
pub(in crate::path) struct Field {
    corner: DVec3,
    cell: f64,
    counts: [usize; 3],
    cells: Vec<AtomicU64>,
}

/// How deep a point lies.
#[derive(Clone, Copy, Debug)]
pub(in crate::path) struct Depth {
    /// No surface is nearer than this; may be negative.
    pub at_least: f64,
    /// About the distance to the nearest surface, at least 0.
    pub about: f64,
    /// The triangle that it is, or one nearly as near.
    pub triangle: u32,
    /// Outward unit normal of it.
    pub normal: DVec3,
    /// What surfaces curved as the body hide from `about`, a length.
    pub error: f64,
    /// Width of a cell.
    pub cell: f64,
}

impl Field {
    /// An empty grid over a box; none for a box without extent.
    pub(in crate::path) fn new(min: Vec3, max: Vec3) -> Option<Self> {
        let size = (max - min).as_dvec3();
        let cell = size.max_element() / CELLS;
        if !(cell.is_finite() && cell > 0.0) {
            return None;
        }
        // Half a cell around: rounding puts points out of the box.
        let corner = min.as_dvec3() - 0.5 * cell;
        let counts = size.to_array().map(|x| (x / cell).ceil() as usize + 1);
        let cells = (0..counts.iter().product()).map(|_| AtomicU64::new(0)).collect();
        Some(Self { corner, cell, counts, cells })
    }

    /// The depth of a point; none outside the box. `nearest` finds surfaces, `normal` is that of a triangle.
    pub(in crate::path) fn depth(&self, bvh: &Bvh, normals: &[[f32; 3]], point: DVec3) -> Option<Depth> {
        let at = ((point - self.corner) / self.cell).floor();
        let inside = |x: f64, n: usize| x >= 0.0 && x < n as f64;
        if !(inside(at.x, self.counts[0]) && inside(at.y, self.counts[1]) && inside(at.z, self.counts[2])) {
            return None;
        }
        let center = self.corner + (at + 0.5) * self.cell;
        let index = (at.z as usize * self.counts[1] + at.y as usize) * self.counts[0] + at.x as usize;
        let mut held = self.cells[index].load(Ordering::Relaxed);
        if held == 0 {
            let nearest = bvh.nearest(center, f64::INFINITY, TOLERANCE)?;
            held = pack(nearest.triangle, Self::distance(&nearest, normals, center));
            self.cells[index].store(held, Ordering::Relaxed);
        }
        let (triangle, distance) = unpack(held);
        let normal = normal_of(normals, triangle);
        let away = center - point;
        // The plane is no farther than the triangle.
        let slack = 1e-6 * (f64::from(distance).abs() + self.cell) + 8.0 * super::rounding(center);
        Some(Depth {
            at_least: f64::from(distance).abs() / (1.0 + TOLERANCE) - away.length() - slack,
            about: (f64::from(distance) + away.dot(normal)).max(0.0),
            triangle,
            normal,
            error: 0.03 * self.cell,
            cell: self.cell,
        })
    }

    /// Distance to the plane of the nearest triangle, negative outside. Not the distance to the triangle: one that is a tenth farther may
    /// lie in quite another direction, but its plane is nearly the same.
    fn distance(nearest: &Nearest, normals: &[[f32; 3]], center: DVec3) -> f32 {
        (nearest.point - center).dot(normal_of(normals, nearest.triangle)) as f32
    }
}

fn normal_of(normals: &[[f32; 3]], triangle: u32) -> DVec3 {
    normals.get(triangle as usize).map_or(DVec3::Y, |n| Vec3::from(*n).as_dvec3())
}

/// Distance above, triangle below, counted from 1 so that no cell looks empty.
fn pack(triangle: u32, distance: f32) -> u64 {
    u64::from(distance.to_bits()) << 32 | u64::from(triangle.wrapping_add(1))
}

fn unpack(held: u64) -> (u32, f32) {
    ((held as u32).wrapping_sub(1), f32::from_bits((held >> 32) as u32))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_packed_comes_out_again() {
        for (triangle, distance) in [(0, 0.0), (0, -0.25), (7, 0.5), (u32::MAX - 1, 1e-9)] {
            let held = pack(triangle, distance);
            assert!(held != 0 && unpack(held) == (triangle, distance), "{triangle} {distance}");
        }
    }
}
