//! Rays in an order in which neighbours walk the same part of the tree.

use super::Ray;

/// Directions of one octant and dominant axis: rays of a packet share both.
const CLASSES: usize = 24;
/// Cells of a class: each of the other two axes below or above half of the dominant one.
const CELLS: usize = 4;

/// Rays sorted by direction; within a cell they keep their order, so what starts at neighbouring pixels stays together. Memory for it, to
/// be used again.
#[derive(Clone, Debug, Default)]
pub struct Order {
    keys: Vec<u8>,
    /// Positions in the input.
    order: Vec<u32>,
    /// Ends of the classes in `order`.
    ends: [u32; CLASSES],
}

/// The axis along which a ray is traced, the largest component of its direction.
#[inline(always)]
pub(super) fn dominant_axis(d: [f32; 3]) -> usize {
    let a = d.map(f32::abs);
    if a[0] > a[1] && a[0] > a[2] {
        0
    } else if a[1] > a[2] {
        1
    } else {
        2
    }
}

impl Order {
    /// A counting sort.
    pub(super) fn sort(&mut self, rays: &[Ray]) {
        let mut starts = [0u32; CLASSES * CELLS + 1];
        self.keys.clear();
        self.keys.extend(rays.iter().map(|ray| key(ray.direction.to_array())));
        for &key in &self.keys {
            starts[key as usize + 1] += 1;
        }
        for k in 0..CLASSES * CELLS {
            starts[k + 1] += starts[k];
        }
        for (class, end) in self.ends.iter_mut().enumerate() {
            *end = starts[(class + 1) * CELLS];
        }
        self.order.resize(rays.len(), 0);
        for (i, &key) in self.keys.iter().enumerate() {
            let place = &mut starts[key as usize];
            self.order[*place as usize] = i as u32;
            *place += 1;
        }
    }

    /// At most `width` rays that share octant and dominant axis, from a place in the order.
    #[inline(always)]
    pub(super) fn group(&self, start: usize, width: usize) -> &[u32] {
        let class = usize::from(self.keys[self.order[start] as usize]) / CELLS;
        &self.order[start..(start + width).min(self.ends[class] as usize)]
    }
}

#[inline(always)]
fn key(d: [f32; 3]) -> u8 {
    let axis = dominant_axis(d);
    let bit = |x: bool, at: usize| usize::from(x) << at;
    let octant = bit(d[0].is_sign_negative(), 0) | bit(d[1].is_sign_negative(), 1) | bit(d[2].is_sign_negative(), 2);
    let half = d[axis].abs() * 0.5;
    let cell = bit(d[(axis + 1) % 3].abs() > half, 0) | bit(d[(axis + 2) % 3].abs() > half, 1);
    ((octant * 3 + axis) * CELLS + cell) as u8
}
