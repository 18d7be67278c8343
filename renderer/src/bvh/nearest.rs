//! The point of the triangles that lies nearest to a given point.

use super::{Block, Bvh, LEAF, NONE, Node};
use crate::lanes::{Kernel, Lanes, dispatch};
use glam::DVec3;

/// A point on a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nearest {
    /// Where it lies, in the unit of the triangles.
    pub point: DVec3,
    /// Position of the triangle in the input.
    pub triangle: u32,
    /// Weight of the second vertex.
    pub u: f32,
    /// Weight of the third vertex.
    pub v: f32,
}

impl Bvh {
    /// The nearest point of all triangles, none if there is none within `r_max` (a length, may be infinite). Double precision where
    /// it decides, so that the distance can serve as a bound. Of equally near points any may be returned, but always the same.
    ///
    /// With a `tolerance`, a point that is at most `1 + tolerance` times as far as the nearest. A little saves much: from the middle of
    /// a round body all triangles are nearly as far as the nearest, and finding out which one it is means looking at all.
    pub fn nearest(&self, p: DVec3, r_max: f64, tolerance: f64) -> Option<Nearest> {
        dispatch(Query { bvh: self, p, r_max, narrow: (1.0 + tolerance.max(0.0)).powi(-2) })
    }
}

struct Query<'a> {
    bvh: &'a Bvh,
    p: DVec3,
    r_max: f64,
    /// Only squared distances below this times the best so far are worth a look.
    narrow: f64,
}

impl Kernel for Query<'_> {
    type Output = Option<Nearest>;
    #[inline(always)]
    fn run<L: Lanes>(self) -> Option<Nearest> {
        let Self { bvh, p, r_max, narrow } = self;
        if bvh.nodes.is_empty() || !p.is_finite() || r_max.is_nan() || r_max < 0.0 {
            return None;
        }
        let boxes = Boxes::new(p);
        let mut found = None;
        // Squared: what a triangle has to beat, and what a box has to.
        let mut best = r_max * r_max;
        let mut limit = best;
        let mut stack: Vec<(f32, u32)> = Vec::with_capacity(64);
        stack.push((0.0, 0));
        while let Some((d2, child)) = stack.pop() {
            if f64::from(d2) > limit {
                continue;
            }
            if child & LEAF != 0 {
                bvh.blocks[(child & !LEAF) as usize].nearest(p, &mut best, &mut found);
                limit = if found.is_some() { best * narrow } else { best };
                continue;
            }
            let node = &bvh.nodes[child as usize];
            let d2 = boxes.test(node);
            let first = stack.len();
            for i in 0..8 {
                // Empty slots are inside out: infinitely far.
                if d2[i] < f32::INFINITY && f64::from(d2[i]) <= limit {
                    stack.push((d2[i], node.children[i]));
                    // Insertion keeps the new entries sorted, farthest first, so that the nearest is popped first.
                    let mut k = stack.len() - 1;
                    while k > first && stack[k - 1].0 < stack[k].0 {
                        stack.swap(k - 1, k);
                        k -= 1;
                    }
                }
            }
        }
        found
    }
}

/// Squared distances to eight boxes at once, never too long.
struct Boxes {
    p: [f32; 3],
    /// What rounding the point to single precision may have moved it by, per axis.
    slack: [f32; 3],
}

impl Boxes {
    #[inline(always)]
    fn new(p: DVec3) -> Self {
        let p = p.as_vec3().to_array();
        Self { p, slack: p.map(|x| x.abs() * f32::EPSILON + f32::MIN_POSITIVE) }
    }

    #[inline(always)]
    fn test(&self, node: &Node) -> [f32; 8] {
        // Four roundings of at most half a unit each.
        const SHORTEN: f32 = 1.0 - 4.0 * f32::EPSILON;
        let mut sum = [0.0f32; 8];
        for k in 0..3 {
            let (lower, upper) = (&node.bounds[k], &node.bounds[k + 3]);
            for i in 0..8 {
                let below = lower[i] - self.p[k];
                let above = self.p[k] - upper[i];
                let outside = if below > above { below } else { above } - self.slack[k];
                let outside = if outside > 0.0 { outside } else { 0.0 };
                sum[i] += outside * outside;
            }
        }
        sum.map(|x| x * SHORTEN)
    }
}

impl Block {
    #[inline(always)]
    fn nearest(&self, p: DVec3, best: &mut f64, found: &mut Option<Nearest>) {
        for i in 0..4 {
            if self.ids[i] == NONE {
                continue;
            }
            // Relative to the point: what is near keeps its digits.
            let [a, b, c] = self.corners.map(|corner| DVec3::from(corner.map(|axis| f64::from(axis[i]))) - p);
            let (v, w) = nearest_to_origin(a, b, c);
            let q = a + (b - a) * v + (c - a) * w;
            let d2 = q.length_squared();
            if d2 < *best || (found.is_none() && d2 <= *best) {
                *best = d2;
                *found = Some(Nearest { point: q + p, triangle: self.ids[i], u: v as f32, v: w as f32 });
            }
        }
    }
}

/// Weights of the second and third corner of the point of a triangle that is nearest to the origin: the foot on the plane if it lies
/// inside, else the nearest of the three feet on the edges.
#[inline(always)]
fn nearest_to_origin(a: DVec3, b: DVec3, c: DVec3) -> (f64, f64) {
    let (ab, ac) = (b - a, c - a);
    let n = ab.cross(ac);
    let nn = n.length_squared();
    // Barycentric weights of the foot, times the squared length of the normal.
    let wb = -(a.cross(ac)).dot(n);
    let wc = a.cross(ab).dot(n);
    if nn > 0.0 && wb >= 0.0 && wc >= 0.0 && wb + wc <= nn {
        return (wb / nn, wc / nn);
    }
    let foot = |from: DVec3, along: DVec3| {
        let l2 = along.length_squared();
        let s = if l2 > 0.0 { (-from.dot(along) / l2).clamp(0.0, 1.0) } else { 0.0 };
        (s, (from + along * s).length_squared())
    };
    let (s_ab, d_ab) = foot(a, ab);
    let (s_ac, d_ac) = foot(a, ac);
    let (s_bc, d_bc) = foot(b, c - b);
    if d_ab <= d_ac && d_ab <= d_bc {
        (s_ab, 0.0)
    } else if d_ac <= d_bc {
        (0.0, s_ac)
    } else {
        (1.0 - s_bc, s_bc)
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{Numbers, sphere};
    use super::*;
    use glam::Vec3;

    /// The least distance over a fine grid of a triangle, an upper bound that is short by at most `step` of its longest edge.
    fn by_grid(triangle: [Vec3; 3], p: DVec3, n: u32) -> f64 {
        let [a, b, c] = triangle.map(|q| q.as_dvec3());
        let mut least = f64::INFINITY;
        for i in 0..=n {
            for j in 0..=n - i {
                let (u, v) = (f64::from(i) / f64::from(n), f64::from(j) / f64::from(n));
                least = least.min((a + (b - a) * u + (c - a) * v).distance(p));
            }
        }
        least
    }

    #[test]
    fn the_nearest_point_of_a_triangle_is_nearer_than_any_other() {
        let mut numbers = Numbers(3);
        for i in 0..600 {
            // Slivers too.
            let thin = if i % 3 == 0 { 1e-3 } else { 1.0 };
            let a = numbers.point();
            let b = a + numbers.point();
            let triangle = [a, b, a.lerp(b, numbers.next()) + numbers.point() * thin];
            let p = (numbers.point() * 1.5).as_dvec3();
            let nearest = Bvh::new(&[triangle]).nearest(p, f64::INFINITY, 0.0).expect("one triangle");
            let [a, b, c] = triangle.map(|q| q.as_dvec3());
            let (u, v) = (f64::from(nearest.u), f64::from(nearest.v));
            assert!(u >= 0.0 && v >= 0.0 && u + v <= 1.0 + 1e-6, "{u} {v}");
            assert!((a + (b - a) * u + (c - a) * v).distance(nearest.point) < 1e-6);
            let (exact, grid) = (nearest.point.distance(p), by_grid(triangle, p, 48));
            let step = a.distance(b).max(a.distance(c)).max(b.distance(c)) / 48.0;
            assert!(exact <= grid + 1e-12 && exact >= grid - step, "{exact} {grid} {step}");
        }
    }

    #[test]
    fn the_tree_finds_what_a_look_at_every_triangle_finds() {
        let mut numbers = Numbers(5);
        for size in [0.02, 0.3] {
            let triangles: Vec<[Vec3; 3]> = (0..700)
                .map(|_| {
                    let c = numbers.point();
                    std::array::from_fn(|_| c + numbers.point() * size)
                })
                .collect();
            let bvh = Bvh::new(&triangles);
            for _ in 0..1500 {
                let p = (numbers.point() * 1.3).as_dvec3();
                let distance = |t: &[Vec3; 3]| {
                    let [a, b, c] = t.map(|q| q.as_dvec3() - p);
                    let (v, w) = nearest_to_origin(a, b, c);
                    (a + (b - a) * v + (c - a) * w).length()
                };
                let least = triangles.iter().map(distance).fold(f64::INFINITY, f64::min);
                let found = bvh.nearest(p, f64::INFINITY, 0.0).expect("there are triangles");
                assert!((found.point.distance(p) - least).abs() < 1e-12);
                assert!((distance(&triangles[found.triangle as usize]) - least).abs() < 1e-12);
                assert_eq!(bvh.nearest(p, least * 1.000_001, 0.0).map(|n| n.triangle), Some(found.triangle));
                assert_eq!(bvh.nearest(p, least * 0.999_999, 0.0), None);
                let near = bvh.nearest(p, least * 1.01, 0.3).expect("one is within").point.distance(p);
                assert!(near >= least * 0.999_999 && near <= least * 1.01);
                let near = bvh.nearest(p, f64::INFINITY, 0.3).expect("there are triangles").point.distance(p);
                assert!(near >= least * 0.999_999 && near <= least * 1.3);
            }
        }
    }

    #[test]
    fn a_sphere_is_as_far_as_its_radius() {
        let bvh = Bvh::new(&sphere(64, 1.0));
        let mut numbers = Numbers(9);
        for _ in 0..500 {
            let p = (numbers.point() * 0.5).as_dvec3();
            let r = bvh.nearest(p, f64::INFINITY, 0.0).expect("there are triangles").point.distance(p);
            assert!((r - (1.0 - p.length())).abs() < 2e-3, "{p}: {r}");
        }
        assert_eq!(Bvh::new(&[]).nearest(DVec3::ZERO, f64::INFINITY, 0.0), None);
        assert_eq!(bvh.nearest(DVec3::NAN, f64::INFINITY, 0.0), None);
    }
}
