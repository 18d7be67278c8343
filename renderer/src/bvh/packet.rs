//! As many rays as there are lanes through the tree at once.
//!
//! The rays of a packet share octant and dominant axis, so the rows of a box and the axes of the triangle test are the same for all,
//! and every lane does what `single` does for its ray. Each entry of the stack says which rays go there. To go on one by one where few are
//! left gains nothing.

use super::order::{Order, dominant_axis};
use super::single::{WIDEN, edges_in_double, rows};
use super::{Block, Bvh, EMPTY, Hit, LEAF, NONE, Ray};
use crate::lanes::{Kernel, Lanes, MAX_LANES, Mask, prefetch};

/// Nearest hits.
pub(super) struct Trace<'a> {
    pub bvh: &'a Bvh,
    pub rays: &'a [Ray],
    pub hits: &'a mut [Hit],
    pub order: &'a Order,
}

impl Kernel for Trace<'_> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { bvh, rays, hits, order } = self;
        let mut stack = Stack::<L>::default();
        let mut start = 0;
        while start < rays.len() {
            let ids = order.group(start, L::WIDTH);
            start += ids.len();
            let found = bvh.walk_packet::<L, false>(rays, ids, &mut stack);
            for (lane, &id) in ids.iter().enumerate() {
                let hit = found.lane(lane);
                hits[id as usize] = if hit.is_miss() { Hit::MISS } else { hit };
            }
        }
    }
}

/// Whether anything is hit.
pub(super) struct TraceAny<'a> {
    pub bvh: &'a Bvh,
    pub rays: &'a [Ray],
    pub results: &'a mut [bool],
    pub order: &'a Order,
}

impl Kernel for TraceAny<'_> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { bvh, rays, results, order } = self;
        let mut stack = Stack::<L>::default();
        let mut start = 0;
        while start < rays.len() {
            let ids = order.group(start, L::WIDTH);
            start += ids.len();
            let found = bvh.walk_packet::<L, true>(rays, ids, &mut stack);
            for (lane, &id) in ids.iter().enumerate() {
                results[id as usize] = found.triangle[lane] != NONE;
            }
        }
    }
}

/// What waits to be visited.
struct Stack<L> {
    /// Where the rays enter.
    entries: Vec<L>,
    /// Child, and the rays that go there.
    heads: Vec<(u32, u32)>,
}

impl<L> Default for Stack<L> {
    fn default() -> Self {
        Self { entries: Vec::with_capacity(128), heads: Vec::with_capacity(128) }
    }
}

/// What the tests need of the rays.
struct Packet<L> {
    origin: [L; 3],
    inverse: [L; 3],
    t_min: L,
    shear: [L; 3],
    /// Rows of a node's bounds that the rays meet first and last.
    near: [usize; 3],
    far: [usize; 3],
    axes: [usize; 3],
}

/// The best hits so far.
struct Found<L> {
    t: L,
    triangle: [u32; MAX_LANES],
    u: [f32; MAX_LANES],
    v: [f32; MAX_LANES],
}

impl<L: Lanes> Found<L> {
    #[inline(always)]
    fn lane(&self, i: usize) -> Hit {
        Hit { t: self.t.lane(i), triangle: self.triangle[i], u: self.u[i], v: self.v[i] }
    }
}

/// Set bits, from the lowest.
#[inline(always)]
fn lanes_of(mut bits: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        (bits != 0).then(|| {
            let i = bits.trailing_zeros() as usize & (MAX_LANES - 1);
            bits &= bits - 1;
            i
        })
    })
}

impl<L: Lanes> Packet<L> {
    #[inline(always)]
    fn new(rays: &[Ray], ids: &[u32]) -> (Self, L) {
        let mut columns = [[0.0f32; MAX_LANES]; 8];
        for lane in 0..L::WIDTH {
            // Lanes beyond the last ray repeat the first, and are not live.
            let ray = &rays[ids[if lane < ids.len() { lane } else { 0 }] as usize];
            let (o, d) = (ray.origin, ray.direction);
            for (column, x) in columns.iter_mut().zip([o.x, o.y, o.z, d.x, d.y, d.z, ray.t_min, ray.t_max]) {
                column[lane] = x;
            }
        }
        let column = |k: usize| L::from_array(&columns[k]);
        let direction = [column(3), column(4), column(5)];
        let inverse = [L::one() / direction[0], L::one() / direction[1], L::one() / direction[2]];
        let first = rays[ids[0] as usize].direction.to_array();
        let kz = dominant_axis(first);
        let (kx, ky) = ((kz + 1) % 3, (kz + 2) % 3);
        let (near, far) = rows(first);
        let packet = Self {
            origin: [column(0), column(1), column(2)],
            shear: [direction[kx] * inverse[kz], direction[ky] * inverse[kz], inverse[kz]],
            inverse,
            t_min: column(6),
            near,
            far,
            axes: [kx, ky, kz],
        };
        (packet, column(7))
    }

    /// Entry into a child of a node, and whether it lies before the exit and `t_max`.
    #[inline(always)]
    fn test(&self, bounds: &[[f32; 8]; 6], slot: usize, t_max: L) -> (L, L::Mask) {
        let mut near = self.t_min;
        let mut far = L::splat(f32::INFINITY);
        for k in 0..3 {
            let a = (L::splat(bounds[self.near[k]][slot]) - self.origin[k]) * self.inverse[k];
            let b = (L::splat(bounds[self.far[k]][slot]) - self.origin[k]) * self.inverse[k];
            near = a.greater(near);
            far = b.lesser(far);
        }
        let far = (far * L::splat(WIDEN)).lesser(t_max);
        (near, near.le(far))
    }
}

impl Bvh {
    /// Brings a child near that will be visited soon.
    #[inline(always)]
    fn prefetch(&self, child: u32) {
        if child & LEAF != 0 {
            prefetch(&self.blocks, (child & !LEAF) as usize);
        } else {
            prefetch(&self.nodes, child as usize);
        }
    }

    /// Walks the tree with the rays `ids`. With `ANY`, a ray ends at the first hit found.
    #[inline(always)]
    fn walk_packet<L: Lanes, const ANY: bool>(&self, rays: &[Ray], ids: &[u32], stack: &mut Stack<L>) -> Found<L> {
        let (packet, t_max) = Packet::<L>::new(rays, ids);
        let mut found = Found { t: t_max, triangle: [NONE; MAX_LANES], u: [0.0; MAX_LANES], v: [0.0; MAX_LANES] };
        // Rays that still look for a hit.
        let mut live = ((1u64 << ids.len()) - 1) as u32;
        let Stack { entries, heads } = stack;
        entries.clear();
        heads.clear();
        if !self.nodes.is_empty() {
            entries.push(packet.t_min);
            heads.push((0, live));
        }
        while let (Some(entry), Some((child, bits))) = (entries.pop(), heads.pop()) {
            let bits = bits & live & entry.le(found.t).bits();
            if bits == 0 {
                continue;
            }
            if child & LEAF != 0 {
                let block = &self.blocks[(child & !LEAF) as usize];
                let hit = block.intersect_packet::<L, ANY>(&packet, rays, ids, entry, bits, &mut found);
                if ANY {
                    live &= !hit;
                }
            } else {
                let node = &self.nodes[child as usize];
                let mask = L::Mask::from_bits(bits);
                // Children that are met: least entry, slot, rays. Farthest first, so that the nearest is popped first.
                let mut met = [(0.0f32, 0u32, 0u32); 8];
                let mut nears = [L::zero(); 8];
                let mut count = 0;
                for slot in 0..8 {
                    if node.children[slot] == EMPTY {
                        break;
                    }
                    let (near, is_met) = packet.test(&node.bounds, slot, found.t);
                    let is_met = is_met & mask;
                    if !is_met.any() {
                        continue;
                    }
                    self.prefetch(node.children[slot]);
                    nears[slot] = near;
                    let least = if ANY { 0.0 } else { L::select(is_met, near, L::splat(f32::INFINITY)).least_lane() };
                    let mut k = count;
                    while !ANY && k > 0 && met[k - 1].0 < least {
                        met[k] = met[k - 1];
                        k -= 1;
                    }
                    met[k] = (least, slot as u32, is_met.bits());
                    count += 1;
                }
                for &(_, slot, bits) in &met[..count] {
                    entries.push(nears[slot as usize & 7]);
                    heads.push((node.children[slot as usize & 7], bits));
                }
            }
            if ANY && live == 0 {
                break;
            }
        }
        found
    }
}

impl Block {
    /// Tests the rays `bits` against four triangles and keeps the nearest hits. Returns which rays hit any. `entry`: where they enter the box
    /// of the triangles.
    #[inline(always)]
    fn intersect_packet<L: Lanes, const ANY: bool>(
        &self,
        packet: &Packet<L>,
        rays: &[Ray],
        ids: &[u32],
        entry: L,
        bits: u32,
        found: &mut Found<L>,
    ) -> u32 {
        let mut hit = 0;
        let mask = L::Mask::from_bits(bits);
        let zero = L::zero();
        let [kx, ky, kz] = packet.axes;
        let [ox, oy, oz] = packet.axes.map(|k| packet.origin[k]);
        let [sx, sy, sz] = packet.shear;
        for slot in 0..4 {
            let id = self.ids[slot];
            if id == NONE {
                break;
            }
            let (mut x, mut y, mut along) = ([zero; 3], [zero; 3], [zero; 3]);
            for c in 0..3 {
                let corner = &self.corners[c];
                along[c] = L::splat(corner[kz][slot]) - oz;
                x[c] = (L::splat(corner[kx][slot]) - ox) - sx * along[c];
                y[c] = (L::splat(corner[ky][slot]) - oy) - sy * along[c];
            }
            let mut e = [x[2] * y[1] - y[2] * x[1], x[0] * y[2] - y[0] * x[2], x[1] * y[0] - y[1] * x[0]];
            let is_left = e[0].ge(zero) & e[1].ge(zero) & e[2].ge(zero);
            let is_right = e[0].le(zero) & e[1].le(zero) & e[2].le(zero);
            let mut touches = (is_left | is_right) & mask;
            if !touches.any() {
                continue;
            }
            let on_edge = (touches & (e[0].eq(zero) | e[1].eq(zero) | e[2].eq(zero))).bits();
            if on_edge != 0 {
                let (xs, ys, mut es) = (x.map(L::to_array), y.map(L::to_array), e.map(L::to_array));
                let mut kept = touches.bits();
                for i in lanes_of(on_edge) {
                    match edges_in_double([xs[0][i], xs[1][i], xs[2][i]], [ys[0][i], ys[1][i], ys[2][i]]) {
                        Some(w) => (es[0][i], es[1][i], es[2][i]) = (w[0], w[1], w[2]),
                        None => kept &= !(1 << i),
                    }
                }
                e = [L::from_array(&es[0]), L::from_array(&es[1]), L::from_array(&es[2])];
                touches = L::Mask::from_bits(kept);
            }
            let det = e[0] + e[1] + e[2];
            let inverse = L::one() / det;
            let t = (e[0] * (sz * along[0]) + e[1] * (sz * along[1]) + e[2] * (sz * along[2])) * inverse;
            let is_after_start = t.gt(packet.t_min) & !det.eq(zero);
            let t = t.greater(entry);
            let candidates = (touches & is_after_start & t.le(found.t)).bits();
            if candidates == 0 {
                continue;
            }
            let (ts, us, vs) = (t.to_array(), (e[1] * inverse).to_array(), (e[2] * inverse).to_array());
            let mut accepted = 0;
            for i in lanes_of(candidates) {
                if rays[ids[i] as usize].excluded != id && found.lane(i).is_behind(ts[i], id) {
                    (found.triangle[i], found.u[i], found.v[i]) = (id, us[i], vs[i]);
                    accepted |= 1 << i;
                }
            }
            if !ANY {
                found.t = L::select(L::Mask::from_bits(accepted), t, found.t);
            }
            hit |= accepted;
        }
        hit
    }
}
