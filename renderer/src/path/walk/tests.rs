//! Walks in bodies whose answer is known, with every method.

mod extremes;
mod mesh;
mod plane;
mod sphere;

use super::numbers::{Dimension, Numbers};
use super::*;
use crate::bvh::NONE;

const METHODS: [Method; 3] = [Method::Plain, Method::Guided, Method::Jumping];

/// Everything between two planes: `-depth < z < 0`. Triangle 0 is the upper plane, 1 the lower.
struct Slab {
    depth: f64,
}

impl Boundary for Slab {
    fn hit(&self, p: DVec3, d: Vec3, t_max: f32) -> Hit {
        let dz = f64::from(d.z);
        let tolerance = 1e-4 + 1e-6 * self.depth;
        assert!(p.z < tolerance && p.z > -self.depth - tolerance, "a walk left the slab unnoticed: {p}");
        let (t, triangle) = if dz > 0.0 { (-p.z / dz, 0) } else { (-(p.z + self.depth) / dz, 1) };
        // Flights along the planes never arrive.
        if dz != 0.0 && t < f64::from(t_max) { Hit { t: t.max(0.0) as f32, triangle, u: 0.0, v: 0.0 } } else { Hit::MISS }
    }
    fn nearest(&self, p: DVec3, r_max: f64, _: f64) -> Option<Nearest> {
        let is_upper = -p.z <= p.z + self.depth;
        let (z, triangle) = if is_upper { (0.0, 0) } else { (-self.depth, 1) };
        ((p.z - z).abs() <= r_max).then_some(Nearest { point: DVec3::new(p.x, p.y, z), triangle, u: 0.0, v: 0.0 })
    }
    fn normal(&self, triangle: u32, _: DVec3) -> Vec3 {
        if triangle == 0 { Vec3::Z } else { Vec3::NEG_Z }
    }
    fn is_outside(&self, _: u32, _: &Hit, _: Vec3) -> bool {
        false
    }
}

/// The unit ball.
struct Ball;

impl Boundary for Ball {
    fn hit(&self, p: DVec3, d: Vec3, t_max: f32) -> Hit {
        let d = d.as_dvec3();
        let (b, c) = (p.dot(d), p.length_squared() - 1.0);
        assert!(c < 1e-5, "a walk left the ball unnoticed: {p}");
        let root = (b * b - d.length_squared() * c).max(0.0).sqrt();
        let t = if b > 0.0 { -c / (b + root) } else { root - b };
        if t < f64::from(t_max) { Hit { t: t.max(0.0) as f32, triangle: 0, u: 0.0, v: 0.0 } } else { Hit::MISS }
    }
    fn nearest(&self, p: DVec3, r_max: f64, _: f64) -> Option<Nearest> {
        let point = p.normalize_or(DVec3::Z);
        (point.distance(p) <= r_max).then_some(Nearest { point, triangle: 0, u: 0.0, v: 0.0 })
    }
    fn normal(&self, _: u32, p: DVec3) -> Vec3 {
        p.normalize_or(DVec3::Z).as_vec3()
    }
    fn is_outside(&self, _: u32, _: &Hit, _: Vec3) -> bool {
        false
    }
}

/// A walk whose collisions nobody asks for.
fn walk<B: Boundary>(boundary: &B, body: &Body, entry: &Entry, method: Method, stats: &mut WalkStats) -> End {
    super::walk(boundary, body, entry, method, &mut Reservoir::new(false), stats)
}

/// A medium by extinction and albedo.
fn medium(extinction: [f32; 3], absorbed: [f64; 3]) -> Medium {
    Medium {
        sigma_s: std::array::from_fn(|k| (f64::from(extinction[k]) * (1.0 - absorbed[k])) as f32),
        sigma_a: std::array::from_fn(|k| (f64::from(extinction[k]) * absorbed[k]) as f32),
    }
}

/// Numbers of a test apart from those of the walks.
fn number(seed: u32, index: u32, k: u32) -> f64 {
    Numbers::new(seed ^ 0x5bd1_e995, index, 1000 + k).at(0, Dimension::Channel)
}

/// A direction into the body at `normal`, straight or as uniform light enters.
fn inwards(normal: DVec3, is_diffuse: bool, seed: u32, index: u32) -> Vec3 {
    let mu = if is_diffuse { number(seed, index, 0).sqrt() } else { 1.0 };
    guide::around(-normal, mu, number(seed, index, 1)).as_vec3()
}

/// An entry with its first segment traced.
fn entry<B: Boundary>(boundary: &B, position: DVec3, direction: Vec3, throughput: [f32; 3], seed: u32, index: u32) -> Entry {
    Entry {
        position,
        direction,
        triangle: NONE,
        normal: boundary.normal(0, position),
        throughput,
        first: boundary.hit(position, direction, f32::INFINITY),
        seed,
        index,
        vertex: 0,
        // Stratified: the first channel for the first third of any three consecutive walks, and so on.
        channel_u: ((f64::from(index) * 0.618_033_988_749_895).fract()) as f32,
    }
}

/// Sums of a score per channel.
#[derive(Clone, Copy, Default)]
struct Sums {
    count: f64,
    sum: [f64; 3],
    square: [f64; 3],
}

impl Sums {
    fn add(&mut self, x: [f64; 3]) {
        self.count += 1.0;
        for k in 0..3 {
            assert!(x[k].is_finite() && x[k] >= 0.0, "{x:?}");
            self.sum[k] += x[k];
            self.square[k] += x[k] * x[k];
        }
    }
    fn mean(&self, k: usize) -> f64 {
        self.sum[k] / self.count
    }
    fn variance(&self, k: usize) -> f64 {
        (self.square[k] / self.count - self.mean(k).powi(2)).max(0.0)
    }
    /// Standard deviation of the mean.
    fn sigma(&self, k: usize) -> f64 {
        (self.variance(k) / self.count).sqrt()
    }
}

/// Runs walks until the mean of every channel that is `watched` is known to a relative error, at most `most`.
fn measure(precision: f64, most: u32, watched: [bool; 3], mut walk: impl FnMut(u32) -> [f64; 3]) -> Sums {
    let mut sums = Sums::default();
    for i in 0..most {
        sums.add(walk(i));
        if i % 4096 == 4095 && (0..3).all(|k| !watched[k] || sums.sigma(k) < precision * sums.mean(k)) {
            break;
        }
    }
    sums
}
