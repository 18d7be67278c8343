//! Noise that tiles: every function repeats with period 1 in both coordinates of the tile.

use glam::{UVec2, Vec2};

/// Well mixed bits of a lattice point.
pub(super) fn hash(x: u32, y: u32, seed: u32) -> u32 {
    let mut h = x.wrapping_mul(0x9E37_79B1) ^ y.wrapping_mul(0x85EB_CA77) ^ seed.wrapping_mul(0xC2B2_AE3D);
    h = (h ^ (h >> 16)).wrapping_mul(0x7FEB_352D);
    h = (h ^ (h >> 15)).wrapping_mul(0x846C_A68B);
    h ^ (h >> 16)
}

/// A number in 0 to 1 from bits.
pub(super) fn unit(bits: u32) -> f32 {
    (bits >> 8) as f32 / (1 << 24) as f32
}

/// A sequence of random numbers.
pub(super) struct Random {
    seed: u32,
    count: u32,
}

impl Random {
    pub(super) fn new(seed: u32) -> Self {
        Self { seed, count: 0 }
    }

    /// The next number in 0 to 1.
    pub(super) fn next(&mut self) -> f32 {
        self.count += 1;
        unit(hash(self.count, 0x51ED, self.seed))
    }

    /// The next number in `low` to `high`.
    pub(super) fn between(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.next()
    }

    /// The next point of the tile.
    pub(super) fn point(&mut self) -> Vec2 {
        Vec2::new(self.next(), self.next())
    }
}

/// 0 below `from`, 1 above `to`, smooth between.
pub(super) fn smoothstep(from: f32, to: f32, x: f32) -> f32 {
    let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// The largest whole number that is not above `x`. The library's `floor` is a call on many machines, and this is the innermost loop.
fn floor(x: f32) -> i32 {
    let whole = x as i32;
    whole - i32::from(whole as f32 > x)
}

/// The lattice cell of a coordinate, the next cell, both wrapped into the tile, and the place between the two.
fn locate(x: f32, cells: u32) -> ([u32; 2], f32) {
    let scaled = (x - floor(x) as f32) * cells as f32;
    let whole = (scaled as u32).min(cells - 1);
    ([whole, if whole + 1 == cells { 0 } else { whole + 1 }], scaled - whole as f32)
}

/// Gradient noise of `cells` lattice cells per tile, about -1 to 1.
pub(super) fn gradient(p: Vec2, cells: UVec2, seed: u32) -> f32 {
    let ((x, fx), (y, fy)) = (locate(p.x, cells.x), locate(p.y, cells.y));
    let f = Vec2::new(fx, fy);
    let corner = |i: usize, j: usize| {
        // Eight directions; the diagonal ones are as strong as the others.
        const D: f32 = std::f32::consts::FRAC_1_SQRT_2;
        const DIRECTIONS: [Vec2; 8] = [
            Vec2::new(1.0, 0.0),
            Vec2::new(-1.0, 0.0),
            Vec2::new(0.0, 1.0),
            Vec2::new(0.0, -1.0),
            Vec2::new(D, D),
            Vec2::new(-D, D),
            Vec2::new(D, -D),
            Vec2::new(-D, -D),
        ];
        let direction = DIRECTIONS[(hash(x[i], y[j], seed) >> 29) as usize];
        direction.dot(f - Vec2::new(i as f32, j as f32))
    };
    let s = f * f * f * (f * (f * 6.0 - 15.0) + 10.0);
    let upper = corner(0, 0) + (corner(1, 0) - corner(0, 0)) * s.x;
    let lower = corner(0, 1) + (corner(1, 1) - corner(0, 1)) * s.x;
    1.5 * (upper + (lower - upper) * s.y)
}

/// Sum of `octaves` gradient noises, each twice as fine and half as strong as the one before; about -1 to 1.
pub(super) fn fbm(p: Vec2, cells: UVec2, octaves: u32, seed: u32) -> f32 {
    let (mut sum, mut amplitude, mut whole) = (0.0, 1.0, 0.0);
    for octave in 0..octaves {
        sum += amplitude * gradient(p, cells << octave, seed + octave);
        whole += amplitude;
        amplitude *= 0.5;
    }
    sum / whole
}

/// Two independent [`fbm`]s as a vector, for bending the coordinates of other noise.
pub(super) fn warp(p: Vec2, cells: UVec2, octaves: u32, seed: u32) -> Vec2 {
    Vec2::new(fbm(p, cells, octaves, seed), fbm(p, cells, octaves, seed ^ 0x5BD1))
}

/// Random points, one in each cell of a lattice, which repeat with the tile.
pub(super) struct Cells {
    size: UVec2,
    /// Places in their own cells, 0 to 1.
    points: Vec<Vec2>,
    seed: u32,
}

/// What is known of a place among the points of [`Cells`]. Lengths are in lattice cells.
#[derive(Clone, Copy, Default)]
pub(super) struct Cell {
    /// Random bits of the nearest point.
    pub(super) id: u32,
    /// From the nearest point to the place.
    pub(super) offset: Vec2,
    /// Distance to the nearest point.
    pub(super) nearest: f32,
    /// Distance to the border between the nearest point's cell and the next.
    pub(super) border: f32,
}

impl Cells {
    /// `size` cells per tile; `jitter` 0 leaves the points in the middle of their cells, 1 puts them anywhere.
    pub(super) fn new(size: UVec2, jitter: f32, seed: u32) -> Self {
        let place = |k: u32| 0.5 + jitter * (unit(k) - 0.5);
        let point = |i: u32| {
            let bits = hash(i % size.x, i / size.x, seed);
            Vec2::new(place(bits), place(hash(bits, 1, seed)))
        };
        Self { size, points: (0..size.x * size.y).map(point).collect(), seed }
    }

    /// What is around a place of the tile.
    pub(super) fn at(&self, p: Vec2) -> Cell {
        let ((column, fx), (row, fy)) = (locate(p.x, self.size.x), locate(p.y, self.size.y));
        let f = Vec2::new(fx, fy);
        let wrap = |first: u32, d: i32, n: u32| {
            let k = first as i32 + d;
            (if k < 0 {
                k + n as i32
            } else if k >= n as i32 {
                k - n as i32
            } else {
                k
            }) as u32
        };
        // The neighbours, without the corners of the square: none of them can be near.
        let mut offsets = [Vec2::ZERO; 21];
        let (mut best, mut nearest, mut count) = (0, f32::INFINITY, 0);
        let mut id = 0;
        for dy in -2..=2_i32 {
            let y = wrap(row[0], dy, self.size.y);
            let reach = if dy.abs() == 2 { 1 } else { 2 };
            for dx in -reach..=reach {
                let x = wrap(column[0], dx, self.size.x);
                let index = y * self.size.x + x;
                let offset = f - Vec2::new(dx as f32, dy as f32) - self.points[index as usize];
                let distance = offset.length_squared();
                if distance < nearest {
                    (best, nearest, id) = (count, distance, index);
                }
                offsets[count] = offset;
                count += 1;
            }
        }
        // Distance to the line halfway between both points, squared so that there is one root in all.
        let own = offsets[best];
        let border = |other: &Vec2| {
            let beyond = other.length_squared() - nearest;
            0.25 * beyond * beyond / (own - *other).length_squared().max(1e-9)
        };
        let borders = offsets.iter().enumerate().map(|(k, other)| if k == best { f32::INFINITY } else { border(other) });
        let border = borders.fold(f32::INFINITY, f32::min).sqrt();
        Cell { id: hash(id, 0xCE11, self.seed), offset: own, nearest: nearest.sqrt(), border }
    }
}
