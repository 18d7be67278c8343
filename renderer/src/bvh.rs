//! Nearest and any intersection of rays with triangles, and the nearest point of them.
//!
//! The tree is built by `obvhs` and collapsed to eight children a node, so that one node is tested with eight lanes. The triangle
//! test is watertight (Woop, Benthin, Wald 2013): neighbours compute the same edge function for a shared edge, so no ray slips
//! between them. It knows nothing of objects or materials; a hit names a triangle by its position in the input.
//!
//! Two ways through the tree: one ray against eight boxes (`single`), and as many rays as there are lanes against one box after the
//! other (`packet`), for rays that `order` has put next to each other. Both give the same hits to the bit: the arithmetic is the
//! same, a hit is never nearer than the box of its block, and of equally near hits the triangle with the lowest number counts. So the
//! nearest one does not depend on the order in which boxes are visited.

#![allow(clippy::needless_range_loop, reason = "one number runs over several arrays of lanes or axes")]

use crate::lanes::dispatch;
use glam::Vec3;

mod build;
mod flat;
mod nearest;
mod order;
mod packet;
mod single;
#[cfg(test)]
mod tests;

pub(crate) use flat::FlatTree;
pub use nearest::Nearest;
pub use order::Order;

/// "No triangle": a miss, or nothing excluded.
pub const NONE: u32 = u32::MAX;

/// A half line. Lengths are those of the triangles.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    /// Start.
    pub origin: Vec3,
    /// Direction; `t` is measured in its length.
    pub direction: Vec3,
    /// Hits at or below this distance do not count.
    pub t_min: f32,
    /// Hits at or beyond this distance do not count.
    pub t_max: f32,
    /// A triangle that is not hit: the one that the ray leaves. [`NONE`] if there is none.
    pub excluded: u32,
}

/// Where a ray meets a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Distance along the ray; infinite for a miss.
    pub t: f32,
    /// Position of the triangle in the input; [`NONE`] for a miss.
    pub triangle: u32,
    /// Weight of the second vertex.
    pub u: f32,
    /// Weight of the third vertex.
    pub v: f32,
}

impl Hit {
    /// Nothing was hit.
    pub const MISS: Self = Self { t: f32::INFINITY, triangle: NONE, u: 0.0, v: 0.0 };

    /// Whether nothing was hit.
    pub fn is_miss(&self) -> bool {
        self.triangle == NONE
    }
}

impl Hit {
    /// Whether a hit of `triangle` at `t` comes before this one. Before the first hit, `self.t` is the end of the ray.
    #[inline(always)]
    fn is_behind(&self, t: f32, triangle: u32) -> bool {
        t < self.t || (t == self.t && triangle < self.triangle && !self.is_miss())
    }
}

impl Ray {
    /// A ray without limits.
    pub fn new(origin: Vec3, direction: Vec3) -> Self {
        Self { origin, direction, t_min: 0.0, t_max: f32::INFINITY, excluded: NONE }
    }
}

/// Children of a node: lower bounds of x, y, z, then upper ones. Empty slots are inside out.
#[derive(Clone, Debug)]
#[repr(align(32))]
struct Node {
    bounds: [[f32; 8]; 6],
    children: [u32; 8],
}

/// Four triangles: `corners[vertex][axis][triangle]`. Unused slots repeat a point and are never hit.
#[derive(Clone, Debug)]
#[repr(align(32))]
struct Block {
    corners: [[[f32; 4]; 3]; 3],
    ids: [u32; 4],
}

/// Marks a child as a block of triangles.
const LEAF: u32 = 1 << 31;
/// A child that is not there.
const EMPTY: u32 = u32::MAX;
/// Triangles a block.
const BLOCK: usize = 4;
/// Fewer rays than this are traced one by one.
const FEW: usize = 8;

/// The tree.
#[derive(Clone, Debug, Default)]
pub struct Bvh {
    nodes: Vec<Node>,
    blocks: Vec<Block>,
}

impl Bvh {
    /// Nearest hits of many rays; `hits` has the length of `rays`.
    pub fn trace(&self, rays: &[Ray], hits: &mut [Hit]) {
        self.trace_ordered(rays, hits, &mut Order::default());
    }

    /// The same with memory to sort the rays in.
    pub fn trace_ordered(&self, rays: &[Ray], hits: &mut [Hit], order: &mut Order) {
        if rays.len() < FEW {
            for (ray, hit) in rays.iter().zip(hits) {
                *hit = self.closest(ray);
            }
            return;
        }
        order.sort(rays);
        dispatch(packet::Trace { bvh: self, rays, hits, order });
    }

    /// Whether many rays hit anything; `results` has the length of `rays`.
    pub fn trace_any(&self, rays: &[Ray], results: &mut [bool]) {
        self.trace_any_ordered(rays, results, &mut Order::default());
    }

    /// The same with memory to sort the rays in.
    pub fn trace_any_ordered(&self, rays: &[Ray], results: &mut [bool], order: &mut Order) {
        if rays.len() < FEW {
            for (ray, result) in rays.iter().zip(results) {
                *result = self.occluded(ray);
            }
            return;
        }
        order.sort(rays);
        dispatch(packet::TraceAny { bvh: self, rays, results, order });
    }

    /// Nearest hit of one ray.
    pub fn closest(&self, ray: &Ray) -> Hit {
        dispatch(single::Closest { bvh: self, ray })
    }

    /// Whether a ray hits anything.
    pub fn occluded(&self, ray: &Ray) -> bool {
        dispatch(single::Occluded { bvh: self, ray })
    }
}
