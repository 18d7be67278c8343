//! Nearest and any intersection of rays with triangles, and the nearest point of them.
//!
//! The tree is built by `obvhs` and collapsed to eight children a node, so that one node is tested with eight lanes. The triangle
//! test is watertight (Woop, Benthin, Wald 2013): neighbours compute the same edge function for a shared edge, so no ray slips
//! between them. It knows nothing of objects or materials; a hit names a triangle by its position in the input.

#![allow(clippy::needless_range_loop, reason = "one number runs over several arrays of lanes or axes")]

use crate::lanes::{Kernel, Lanes, dispatch};
use glam::Vec3;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2_from_tris;
use obvhs::triangle::Triangle;
use obvhs::{BvhBuildParams, ploc::PlocSearchDistance};
use std::time::Duration;

mod nearest;

pub use nearest::Nearest;

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

impl Ray {
    /// A ray without limits.
    pub fn new(origin: Vec3, direction: Vec3) -> Self {
        Self { origin, direction, t_min: 0.0, t_max: f32::INFINITY, excluded: NONE }
    }
}

/// Children of a node: lower bounds of x, y, z, then upper ones. Empty slots are inside out.
#[derive(Clone, Debug)]
#[repr(align(64))]
struct Node {
    bounds: [[f32; 8]; 6],
    children: [u32; 8],
}

/// Four triangles: `corners[vertex][axis][triangle]`. Unused slots repeat a point and are never hit.
#[derive(Clone, Debug)]
#[repr(align(64))]
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

/// The tree.
#[derive(Clone, Debug, Default)]
pub struct Bvh {
    nodes: Vec<Node>,
    blocks: Vec<Block>,
}

impl Bvh {
    /// A tree over these triangles. Those without area, or with corners that are not finite, are left out.
    pub fn new(triangles: &[[Vec3; 3]]) -> Self {
        let ids: Vec<u32> = (0..triangles.len() as u32)
            .filter(|&i| {
                let [a, b, c] = triangles[i as usize];
                let area = (b - a).as_dvec3().cross((c - a).as_dvec3()).length_squared();
                area > 0.0 && area.is_finite()
            })
            .collect();
        if ids.is_empty() {
            return Self::default();
        }
        let kept: Vec<Triangle> = ids
            .iter()
            .map(|&i| {
                let [a, b, c] = triangles[i as usize];
                Triangle { v0: a.into(), v1: b.into(), v2: c.into() }
            })
            .collect();
        let params = BvhBuildParams {
            ploc_search_distance: PlocSearchDistance::Low,
            max_prims_per_leaf: BLOCK as u32,
            ..BvhBuildParams::medium_build()
        };
        let mut build_time = Duration::ZERO;
        let binary = build_bvh2_from_tris(&kept, params, &mut build_time);
        let mut builder = Collapse { binary: &binary, triangles, ids: &ids, bvh: Self::default() };
        builder.run();
        builder.bvh
    }

    /// Nearest hits of many rays; `hits` has the length of `rays`.
    pub fn trace(&self, rays: &[Ray], hits: &mut [Hit]) {
        dispatch(Trace { bvh: self, rays, hits });
    }

    /// Whether many rays hit anything; `results` has the length of `rays`.
    pub fn trace_any(&self, rays: &[Ray], results: &mut [bool]) {
        dispatch(TraceAny { bvh: self, rays, results });
    }

    /// Nearest hit of one ray.
    pub fn closest(&self, ray: &Ray) -> Hit {
        let mut hit = [Hit::MISS];
        self.trace(std::slice::from_ref(ray), &mut hit);
        hit[0]
    }

    /// Whether a ray hits anything.
    pub fn occluded(&self, ray: &Ray) -> bool {
        let mut result = [false];
        self.trace_any(std::slice::from_ref(ray), &mut result);
        result[0]
    }

    /// Walks the tree. With `ANY`, the first hit found ends the walk.
    #[inline(always)]
    fn walk<const ANY: bool>(&self, ray: &Ray, stack: &mut Vec<(f32, u32)>) -> Hit {
        let mut hit = Hit { t: ray.t_max, ..Hit::MISS };
        stack.clear();
        if !self.nodes.is_empty() {
            stack.push((0.0, 0));
        }
        let slabs = Slabs::new(ray);
        let shear = Shear::new(ray);
        while let Some((t, child)) = stack.pop() {
            if t >= hit.t {
                continue;
            }
            if child & LEAF != 0 {
                if self.blocks[(child & !LEAF) as usize].intersect(ray, &shear, &mut hit) && ANY {
                    return hit;
                }
                continue;
            }
            let node = &self.nodes[child as usize];
            let (near, far) = slabs.test(node, ray.t_min, hit.t);
            let first = stack.len();
            for i in 0..8 {
                if near[i] <= far[i] {
                    stack.push((near[i], node.children[i]));
                    if !ANY {
                        // Insertion keeps the new entries sorted, farthest first, so that the nearest is popped first.
                        let mut k = stack.len() - 1;
                        while k > first && stack[k - 1].0 < stack[k].0 {
                            stack.swap(k - 1, k);
                            k -= 1;
                        }
                    }
                }
            }
        }
        if hit.is_miss() { Hit::MISS } else { hit }
    }
}

struct Trace<'a> {
    bvh: &'a Bvh,
    rays: &'a [Ray],
    hits: &'a mut [Hit],
}

impl Kernel for Trace<'_> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lanes>(self) {
        let mut stack = Vec::with_capacity(64);
        for (ray, hit) in self.rays.iter().zip(self.hits) {
            *hit = self.bvh.walk::<false>(ray, &mut stack);
        }
    }
}

struct TraceAny<'a> {
    bvh: &'a Bvh,
    rays: &'a [Ray],
    results: &'a mut [bool],
}

impl Kernel for TraceAny<'_> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lanes>(self) {
        let mut stack = Vec::with_capacity(64);
        for (ray, result) in self.rays.iter().zip(self.results) {
            *result = !self.bvh.walk::<true>(ray, &mut stack).is_miss();
        }
    }
}

/// What the box test needs of a ray.
struct Slabs {
    origin: [f32; 3],
    inverse: [f32; 3],
    /// Rows of the node's bounds that the ray meets first and last.
    near: [usize; 3],
    far: [usize; 3],
}

impl Slabs {
    #[inline(always)]
    fn new(ray: &Ray) -> Self {
        let d = ray.direction.to_array();
        let near = std::array::from_fn(|k| if d[k].is_sign_negative() { k + 3 } else { k });
        let far = std::array::from_fn(|k| if d[k].is_sign_negative() { k } else { k + 3 });
        Self { origin: ray.origin.to_array(), inverse: d.map(|x| 1.0 / x), near, far }
    }

    /// Entry and exit of the eight children. A comparison that drops NaN (0 times infinity, an origin in the plane of a slab that
    /// the ray runs along) keeps the bound of the other axes.
    #[inline(always)]
    fn test(&self, node: &Node, t_min: f32, t_max: f32) -> ([f32; 8], [f32; 8]) {
        // 1 + 2 gamma(3): the exit is moved by its rounding error, so that no box is missed (Ize 2013).
        const WIDEN: f32 = 1.000_000_4;
        let mut near = [t_min; 8];
        let mut far = [t_max; 8];
        for k in 0..3 {
            let (o, inverse) = (self.origin[k], self.inverse[k]);
            let (lower, upper) = (&node.bounds[self.near[k]], &node.bounds[self.far[k]]);
            for i in 0..8 {
                let a = (lower[i] - o) * inverse;
                let b = (upper[i] - o) * inverse * WIDEN;
                near[i] = if a > near[i] { a } else { near[i] };
                far[i] = if b < far[i] { b } else { far[i] };
            }
        }
        (near, far)
    }
}

/// The transformation that makes a ray the z axis.
struct Shear {
    axes: [usize; 3],
    shear: [f32; 3],
    origin: [f32; 3],
}

impl Shear {
    #[inline(always)]
    fn new(ray: &Ray) -> Self {
        let d = ray.direction.to_array();
        let a = d.map(f32::abs);
        let kz = if a[0] > a[1] && a[0] > a[2] {
            0
        } else if a[1] > a[2] {
            1
        } else {
            2
        };
        let (kx, ky) = ((kz + 1) % 3, (kz + 2) % 3);
        let inverse = 1.0 / d[kz];
        let o = ray.origin.to_array();
        Self { axes: [kx, ky, kz], shear: [d[kx] * inverse, d[ky] * inverse, inverse], origin: [o[kx], o[ky], o[kz]] }
    }
}

impl Block {
    /// Tests four triangles and keeps the nearest in `hit`. Returns whether any counted.
    #[inline(always)]
    fn intersect(&self, ray: &Ray, shear: &Shear, hit: &mut Hit) -> bool {
        let [kx, ky, kz] = shear.axes;
        let [sx, sy, sz] = shear.shear;
        // Corners relative to the ray, sheared: x and y across the ray, z along it.
        let mut x = [[0.0f32; 4]; 3];
        let mut y = [[0.0f32; 4]; 3];
        let mut z = [[0.0f32; 4]; 3];
        for c in 0..3 {
            let corner = &self.corners[c];
            for i in 0..4 {
                let along = corner[kz][i] - shear.origin[2];
                x[c][i] = (corner[kx][i] - shear.origin[0]) - sx * along;
                y[c][i] = (corner[ky][i] - shear.origin[1]) - sy * along;
                z[c][i] = sz * along;
            }
        }
        let mut e = [[0.0f32; 4]; 3];
        for c in 0..3 {
            let (a, b) = ((c + 1) % 3, (c + 2) % 3);
            for i in 0..4 {
                e[c][i] = x[b][i] * y[a][i] - y[b][i] * x[a][i];
            }
        }
        let mut touches = [false; 4];
        for i in 0..4 {
            touches[i] =
                (e[0][i] >= 0.0 && e[1][i] >= 0.0 && e[2][i] >= 0.0) || (e[0][i] <= 0.0 && e[1][i] <= 0.0 && e[2][i] <= 0.0);
        }
        let mut found = false;
        for i in 0..4 {
            if !touches[i] || self.ids[i] == ray.excluded || self.ids[i] == NONE {
                continue;
            }
            let mut w = [f64::from(e[0][i]), f64::from(e[1][i]), f64::from(e[2][i])];
            if w.contains(&0.0) {
                // On an edge as far as single precision can tell: products of two singles are exact in double precision,
                // so both neighbours agree on the side.
                for (c, w) in w.iter_mut().enumerate() {
                    let (a, b) = ((c + 1) % 3, (c + 2) % 3);
                    *w = f64::from(x[b][i]) * f64::from(y[a][i]) - f64::from(y[b][i]) * f64::from(x[a][i]);
                }
                if w.iter().any(|w| *w < 0.0) && w.iter().any(|w| *w > 0.0) {
                    continue;
                }
            }
            let w = w.map(|w| w as f32);
            let det = w[0] + w[1] + w[2];
            if det == 0.0 {
                continue;
            }
            let inverse = 1.0 / det;
            let t = (w[0] * z[0][i] + w[1] * z[1][i] + w[2] * z[2][i]) * inverse;
            if t > ray.t_min && t < hit.t {
                *hit = Hit { t, triangle: self.ids[i], u: w[1] * inverse, v: w[2] * inverse };
                found = true;
            }
        }
        found
    }
}

/// Turns the binary tree into one with eight children a node.
struct Collapse<'a> {
    binary: &'a Bvh2,
    triangles: &'a [[Vec3; 3]],
    /// Input positions of the triangles that the binary tree holds.
    ids: &'a [u32],
    bvh: Bvh,
}

impl Collapse<'_> {
    fn run(&mut self) {
        self.bvh.nodes.push(Node { bounds: [[0.0; 8]; 6], children: [EMPTY; 8] });
        let mut open = vec![(0usize, 0usize)];
        while let Some((source, target)) = open.pop() {
            let mut members = vec![source];
            // Opening the largest inner child first keeps the sum of areas small.
            while members.len() < 8 {
                let largest = (0..members.len()).filter(|&i| !self.binary.nodes[members[i]].is_leaf()).max_by(|&a, &b| {
                    let area = |i: usize| self.binary.nodes[members[i]].aabb().half_area();
                    area(a).total_cmp(&area(b))
                });
                let Some(i) = largest else { break };
                let first = self.binary.nodes[members[i]].first_index as usize;
                members[i] = first;
                members.push(first + 1);
            }
            let mut node = Node {
                bounds: std::array::from_fn(|k| [if k < 3 { f32::INFINITY } else { f32::NEG_INFINITY }; 8]),
                children: [EMPTY; 8],
            };
            for (slot, member) in members.into_iter().enumerate() {
                let source = &self.binary.nodes[member];
                let (min, max) = (source.aabb().min.to_array(), source.aabb().max.to_array());
                for k in 0..3 {
                    node.bounds[k][slot] = min[k];
                    node.bounds[k + 3][slot] = max[k];
                }
                node.children[slot] = if source.is_leaf() {
                    let first = source.first_index as usize;
                    self.leaf(first, first + source.prim_count as usize)
                } else {
                    self.bvh.nodes.push(Node { bounds: [[0.0; 8]; 6], children: [EMPTY; 8] });
                    open.push((member, self.bvh.nodes.len() - 1));
                    (self.bvh.nodes.len() - 1) as u32
                };
            }
            self.bvh.nodes[target] = node;
        }
    }

    /// A block, or, where a leaf holds more than a block does, a node over blocks.
    fn leaf(&mut self, first: usize, end: usize) -> u32 {
        if end - first <= BLOCK {
            let mut block = Block { corners: [[[0.0; 4]; 3]; 3], ids: [NONE; 4] };
            for (slot, i) in (first..end).enumerate() {
                let id = self.ids[self.binary.primitive_indices[i] as usize];
                block.ids[slot] = id;
                for (c, corner) in self.triangles[id as usize].iter().enumerate() {
                    for (k, x) in corner.to_array().into_iter().enumerate() {
                        block.corners[c][k][slot] = x;
                    }
                }
            }
            self.bvh.blocks.push(block);
            return LEAF | (self.bvh.blocks.len() - 1) as u32;
        }
        let index = self.bvh.nodes.len();
        self.bvh.nodes.push(Node {
            bounds: std::array::from_fn(|k| [if k < 3 { f32::INFINITY } else { f32::NEG_INFINITY }; 8]),
            children: [EMPTY; 8],
        });
        let step = (end - first).div_ceil(8).max(BLOCK);
        for (slot, start) in (first..end).step_by(step).enumerate() {
            let stop = (start + step).min(end);
            let child = self.leaf(start, stop);
            let node = &mut self.bvh.nodes[index];
            node.children[slot] = child;
            for i in start..stop {
                let id = self.ids[self.binary.primitive_indices[i] as usize];
                for corner in self.triangles[id as usize] {
                    for (k, x) in corner.to_array().into_iter().enumerate() {
                        node.bounds[k][slot] = node.bounds[k][slot].min(x);
                        node.bounds[k + 3][slot] = node.bounds[k + 3][slot].max(x);
                    }
                }
            }
        }
        index as u32
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    /// Numbers in `[0, 1)` from a counter.
    pub(super) struct Numbers(pub u32);

    impl Numbers {
        pub fn next(&mut self) -> f32 {
            self.0 = self.0.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
            let x = ((self.0 >> ((self.0 >> 28) + 4)) ^ self.0).wrapping_mul(277_803_737);
            ((x >> 22) ^ x) as f32 / 4_294_967_296.0
        }
        pub fn point(&mut self) -> Vec3 {
            Vec3::new(self.next(), self.next(), self.next()) * 2.0 - 1.0
        }
    }

    /// Distance by Moeller and Trumbore in double precision; `None` within a small margin of an edge is not decided.
    fn brute_force(triangles: &[[Vec3; 3]], ray: &Ray) -> (f64, bool) {
        let mut nearest = f64::INFINITY;
        let mut is_clear = true;
        for t in triangles {
            let [a, b, c] = t.map(|p| p.as_dvec3());
            let (o, d): (DVec3, DVec3) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
            let (e1, e2) = (b - a, c - a);
            let p = d.cross(e2);
            let det = e1.dot(p);
            let s = o - a;
            let u = s.dot(p) / det;
            let q = s.cross(e1);
            let v = d.dot(q) / det;
            let t = e2.dot(q) / det;
            let inside = u.min(v).min(1.0 - u - v);
            is_clear &= inside.abs() > 1e-5 || t < 0.0;
            if inside >= 0.0 && t > 0.0 && t < nearest {
                nearest = t;
            }
        }
        (nearest, is_clear)
    }

    #[test]
    fn hits_are_those_of_brute_force() {
        let mut numbers = Numbers(1);
        let triangles: Vec<[Vec3; 3]> = (0..400)
            .map(|_| {
                let c = numbers.point();
                std::array::from_fn(|_| c + numbers.point() * 0.2)
            })
            .collect();
        let bvh = Bvh::new(&triangles);
        let rays: Vec<Ray> = (0..3000).map(|_| Ray::new(numbers.point() * 1.5, numbers.point().normalize_or(Vec3::X))).collect();
        let mut hits = vec![Hit::MISS; rays.len()];
        bvh.trace(&rays, &mut hits);
        let mut decided = 0;
        for (ray, hit) in rays.iter().zip(&hits) {
            let (t, is_clear) = brute_force(&triangles, ray);
            if !is_clear {
                continue;
            }
            decided += 1;
            assert_eq!(hit.is_miss(), t.is_infinite(), "{ray:?}");
            assert_eq!(bvh.occluded(ray), t.is_finite());
            if t.is_finite() {
                assert!((f64::from(hit.t) - t).abs() < 1e-4 * t.max(1.0), "{} {t}", hit.t);
                let [a, b, c] = triangles[hit.triangle as usize];
                let p = a * (1.0 - hit.u - hit.v) + b * hit.u + c * hit.v;
                assert!(p.distance(ray.origin + ray.direction * hit.t) < 1e-4);
            }
        }
        assert!(decided > 2000);
    }

    /// A unit sphere of triangles whose shared vertices are equal to the bit.
    pub(super) fn sphere(rings: u32, scale: f32) -> Vec<[Vec3; 3]> {
        let at = |i: u32, j: u32| {
            let theta = i as f32 / rings as f32 * std::f32::consts::PI;
            let phi = (j % (2 * rings)) as f32 / rings as f32 * std::f32::consts::PI;
            if i == 0 || i == rings {
                return Vec3::new(0.0, if i == 0 { scale } else { -scale }, 0.0);
            }
            Vec3::new(theta.sin() * phi.cos(), theta.cos(), theta.sin() * phi.sin()) * scale
        };
        let mut triangles = Vec::new();
        for i in 0..rings {
            for j in 0..2 * rings {
                triangles.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
                triangles.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
            }
        }
        triangles
    }

    #[test]
    fn no_ray_leaves_a_closed_mesh() {
        for scale in [1e-4, 1.0, 1e4] {
            let triangles = sphere(24, scale);
            let bvh = Bvh::new(&triangles);
            let mut numbers = Numbers(7);
            for i in 0..40_000 {
                let origin = numbers.point() * 0.5 * scale;
                let [a, b, _] = triangles[(numbers.next() * triangles.len() as f32) as usize % triangles.len()];
                // Aimed at edges and vertices, where leaks would be.
                let aim = match i % 3 {
                    0 => a,
                    1 => a.lerp(b, numbers.next()),
                    _ => numbers.point() * scale * 4.0,
                };
                let ray = Ray::new(origin, (aim - origin).normalize_or(Vec3::Y));
                assert!(!bvh.closest(&ray).is_miss(), "{ray:?}");
                assert!(bvh.occluded(&ray), "{ray:?}");
            }
        }
    }

    #[test]
    fn flat_triangles_and_no_triangles_are_never_hit() {
        let flat = [[Vec3::ZERO, Vec3::X, Vec3::X * 2.0], [Vec3::NAN, Vec3::X, Vec3::Y]];
        for bvh in [Bvh::new(&[]), Bvh::new(&flat)] {
            assert!(bvh.closest(&Ray::new(Vec3::new(0.5, 0.0, 1.0), Vec3::NEG_Z)).is_miss());
        }
    }

    #[test]
    fn an_excluded_triangle_is_passed() {
        let quad = [[Vec3::ZERO, Vec3::X, Vec3::Y], [Vec3::Z, Vec3::X + Vec3::Z, Vec3::Y + Vec3::Z]];
        let bvh = Bvh::new(&quad);
        let mut ray = Ray::new(Vec3::new(0.2, 0.2, 3.0), Vec3::NEG_Z);
        assert_eq!(bvh.closest(&ray).triangle, 1);
        ray.excluded = 1;
        assert_eq!(bvh.closest(&ray).triangle, 0);
        ray.t_max = 2.5;
        assert!(bvh.closest(&ray).is_miss());
    }
}
