//! One ray through the tree: eight boxes or four triangles at a time.

use super::order::dominant_axis;
use super::{Block, Bvh, EMPTY, Hit, LEAF, NONE, Node, Ray};
use crate::lanes::{Kernel, Lanes};

/// 1 + 2 gamma(3): the exit of a box is moved by its rounding error, so that no box is missed (Ize 2013).
pub(super) const WIDEN: f32 = 1.000_000_4;

/// Nearest hit of a ray.
pub(super) struct Closest<'a> {
    pub bvh: &'a Bvh,
    pub ray: &'a Ray,
}

impl Kernel for Closest<'_> {
    type Output = Hit;
    #[inline(always)]
    fn run<L: Lanes>(self) -> Hit {
        let mut hit = Hit { t: self.ray.t_max, ..Hit::MISS };
        self.bvh.walk::<false>(self.ray, (self.ray.t_min, 0), &mut hit, &mut Vec::with_capacity(64));
        if hit.is_miss() { Hit::MISS } else { hit }
    }
}

/// Whether a ray hits anything.
pub(super) struct Occluded<'a> {
    pub bvh: &'a Bvh,
    pub ray: &'a Ray,
}

impl Kernel for Occluded<'_> {
    type Output = bool;
    #[inline(always)]
    fn run<L: Lanes>(self) -> bool {
        let mut hit = Hit { t: self.ray.t_max, ..Hit::MISS };
        self.bvh.walk::<true>(self.ray, (self.ray.t_min, 0), &mut hit, &mut Vec::with_capacity(64));
        !hit.is_miss()
    }
}

impl Bvh {
    /// Walks the tree below `start` (where the ray enters it, and the child). With `ANY`, the first hit found ends the walk. `stack` is memory
    /// to work in.
    #[inline(always)]
    pub(super) fn walk<const ANY: bool>(&self, ray: &Ray, start: (f32, u32), hit: &mut Hit, stack: &mut Vec<(f32, u32)>) {
        stack.clear();
        if !self.nodes.is_empty() {
            stack.push(start);
        }
        let slabs = Slabs::new(ray);
        let shear = Shear::new(ray);
        while let Some((t, child)) = stack.pop() {
            if t > hit.t {
                continue;
            }
            if child & LEAF != 0 {
                if self.blocks[(child & !LEAF) as usize].intersect(ray, &shear, t, hit) && ANY {
                    return;
                }
                continue;
            }
            let node = &self.nodes[child as usize];
            let (near, far) = slabs.test(node, ray.t_min, hit.t);
            let mut crossed = 0u32;
            for i in 0..8 {
                // Numbers that are none cross even slots that are inside out.
                crossed |= u32::from((near[i] <= far[i]) & (node.children[i] != EMPTY)) << i;
            }
            let first = stack.len();
            while crossed != 0 {
                let i = crossed.trailing_zeros() as usize & 7;
                crossed &= crossed - 1;
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
        let (near, far) = rows(d);
        Self { origin: ray.origin.to_array(), inverse: d.map(|x| 1.0 / x), near, far }
    }

    /// Entry and exit of the eight children. A comparison that drops NaN (0 times infinity, an origin in the plane of a slab that
    /// the ray runs along) keeps the bound of the other axes.
    #[inline(always)]
    fn test(&self, node: &Node, t_min: f32, t_max: f32) -> ([f32; 8], [f32; 8]) {
        let mut near = [t_min; 8];
        let mut far = [f32::INFINITY; 8];
        for k in 0..3 {
            let (o, inverse) = (self.origin[k], self.inverse[k]);
            let (lower, upper) = (&node.bounds[self.near[k]], &node.bounds[self.far[k]]);
            for i in 0..8 {
                let a = (lower[i] - o) * inverse;
                let b = (upper[i] - o) * inverse;
                near[i] = if a > near[i] { a } else { near[i] };
                far[i] = if b < far[i] { b } else { far[i] };
            }
        }
        for far in &mut far {
            let widened = *far * WIDEN;
            *far = if widened < t_max { widened } else { t_max };
        }
        (near, far)
    }
}

/// Rows of a node's bounds that a direction meets first and last.
#[inline(always)]
pub(super) fn rows(d: [f32; 3]) -> ([usize; 3], [usize; 3]) {
    let row = |k: usize, is_upper: bool| if is_upper { k + 3 } else { k };
    let s = d.map(f32::is_sign_negative);
    ([row(0, s[0]), row(1, s[1]), row(2, s[2])], [row(0, !s[0]), row(1, !s[1]), row(2, !s[2])])
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
        let kz = dominant_axis(d);
        let (kx, ky) = ((kz + 1) % 3, (kz + 2) % 3);
        let inverse = 1.0 / d[kz];
        let o = ray.origin.to_array();
        Self { axes: [kx, ky, kz], shear: [d[kx] * inverse, d[ky] * inverse, inverse], origin: [o[kx], o[ky], o[kz]] }
    }
}

/// The three edge functions again where one of them is 0: on an edge as far as single precision can tell. Products of two singles are
/// exact in double precision, so both neighbours agree on the side. `None`: not inside.
#[inline(always)]
pub(super) fn edges_in_double(x: [f32; 3], y: [f32; 3]) -> Option<[f32; 3]> {
    let w = [(1, 2), (2, 0), (0, 1)]
        .map(|(a, b): (usize, usize)| f64::from(x[b]) * f64::from(y[a]) - f64::from(y[b]) * f64::from(x[a]));
    let is_outside = w.iter().any(|w| *w < 0.0) && w.iter().any(|w| *w > 0.0);
    (!is_outside).then(|| w.map(|w| w as f32))
}

impl Block {
    /// Tests four triangles and keeps the nearest in `hit`. Returns whether any counted. `entry`: where the ray enters their box.
    #[inline(always)]
    fn intersect(&self, ray: &Ray, shear: &Shear, entry: f32, hit: &mut Hit) -> bool {
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
        let mut touched = 0u32;
        for i in 0..4 {
            let touches =
                (e[0][i] >= 0.0) & (e[1][i] >= 0.0) & (e[2][i] >= 0.0) | (e[0][i] <= 0.0) & (e[1][i] <= 0.0) & (e[2][i] <= 0.0);
            touched |= u32::from(touches) << i;
        }
        let mut found = false;
        while touched != 0 {
            let i = touched.trailing_zeros() as usize & 3;
            touched &= touched - 1;
            if self.ids[i] == ray.excluded || self.ids[i] == NONE {
                continue;
            }
            let mut w = [e[0][i], e[1][i], e[2][i]];
            if w.contains(&0.0) {
                let Some(exact) = edges_in_double([x[0][i], x[1][i], x[2][i]], [y[0][i], y[1][i], y[2][i]]) else { continue };
                w = exact;
            }
            let det = w[0] + w[1] + w[2];
            if det == 0.0 {
                continue;
            }
            let inverse = 1.0 / det;
            let t = (w[0] * z[0][i] + w[1] * z[1][i] + w[2] * z[2][i]) * inverse;
            let is_after_start = t > ray.t_min;
            let t = if t > entry { t } else { entry };
            if is_after_start && hit.is_behind(t, self.ids[i]) {
                *hit = Hit { t, triangle: self.ids[i], u: w[1] * inverse, v: w[2] * inverse };
                found = true;
            }
        }
        found
    }
}
