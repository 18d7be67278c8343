//! Hits against brute force, watertightness, and the same hits by every way through the tree.

use super::*;
use crate::lanes::Kernel;
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

/// Rays that aim everywhere, at edges and corners, along axes, and such that are no rays at all.
fn awkward_rays(triangles: &[[Vec3; 3]], numbers: &mut Numbers) -> Vec<Ray> {
    let mut rays = Vec::new();
    for i in 0..6000 {
        let target = (numbers.next() * triangles.len() as f32) as usize % triangles.len();
        let [a, b, c] = triangles[target];
        let middle = (a + b + c) / 3.0;
        let origin = if i % 5 == 0 { middle } else { numbers.point() * 1.5 };
        let aim = match i % 4 {
            0 => a,
            1 => a.lerp(b, numbers.next()),
            2 => middle,
            _ => numbers.point(),
        };
        let mut direction = (aim - origin).normalize_or(Vec3::Y);
        let mut ray = Ray::new(origin, direction);
        if i % 7 == 0 {
            // Along an axis, or two of them, with zeros of both signs; in the plane of box sides.
            let axis = numbers.point().signum() * Vec3::new(1.0, f32::from(u8::from(i % 2 == 0)), 0.0);
            direction = [axis, Vec3::new(axis.z, axis.x, axis.y), Vec3::new(axis.y, axis.z, axis.x)][i % 3];
            ray = Ray::new(a - direction * numbers.next() * 2.0, direction);
        }
        if i % 11 == 0 {
            ray.t_max = numbers.next() * 2.0;
            ray.t_min = numbers.next() * 0.5;
        }
        if i % 3 == 0 {
            ray.excluded = target as u32;
        }
        rays.push(ray);
    }
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 0.0, 1e-40, 1e38] {
        for k in 0..3 {
            let mut at = numbers.point();
            at[k] = bad;
            rays.push(Ray::new(at, numbers.point()));
            rays.push(Ray::new(numbers.point(), at));
            rays.push(Ray::new(Vec3::splat(bad), Vec3::splat(bad)));
            rays.push(Ray { t_min: bad, ..Ray::new(numbers.point(), numbers.point()) });
            rays.push(Ray { t_max: bad, ..Ray::new(numbers.point(), numbers.point()) });
        }
    }
    rays
}

/// Many rays at once with lanes of a given type.
struct Packets<'a>(&'a Bvh, &'a [Ray]);

impl Kernel for Packets<'_> {
    type Output = (Vec<Hit>, Vec<bool>);
    #[inline(always)]
    fn run<L: crate::lanes::Lanes>(self) -> Self::Output {
        let Self(bvh, rays) = self;
        let (mut hits, mut results) = (vec![Hit::MISS; rays.len()], vec![false; rays.len()]);
        let mut order = Order::default();
        order.sort(rays);
        packet::Trace { bvh, rays, hits: &mut hits, order: &order }.run::<L>();
        packet::TraceAny { bvh, rays, results: &mut results, order: &order }.run::<L>();
        (hits, results)
    }
}

#[test]
fn packets_hit_what_single_rays_hit() {
    let mut numbers = Numbers(11);
    let mut soup: Vec<[Vec3; 3]> = (0..700)
        .map(|_| {
            let c = numbers.point();
            std::array::from_fn(|_| c + numbers.point() * 0.2)
        })
        .collect();
    // Equally near hits: the same triangles again, and a flat grid whose boxes have no height.
    soup.extend_from_within(..100);
    for i in 0..64 {
        let p = Vec3::new((i % 8) as f32 * 0.25 - 1.0, 0.125, (i / 8) as f32 * 0.25 - 1.0);
        soup.push([p, p + Vec3::X * 0.25, p + Vec3::Z * 0.25]);
        soup.push([p + Vec3::X * 0.25, p + Vec3::new(0.25, 0.0, 0.25), p + Vec3::Z * 0.25]);
    }
    for triangles in [soup, sphere(24, 1.0)] {
        let bvh = Bvh::new(&triangles);
        let rays = awkward_rays(&triangles, &mut numbers);
        let nearest: Vec<Hit> = rays.iter().map(|ray| bvh.closest(ray)).collect();
        let any: Vec<bool> = rays.iter().map(|ray| bvh.occluded(ray)).collect();
        assert!(nearest.iter().filter(|hit| !hit.is_miss()).count() > rays.len() / 3);
        for (name, (hits, results)) in [
            ("eight", Packets(&bvh, &rays).run::<crate::lanes::Wide<8>>()),
            ("this processor's", crate::lanes::dispatch(Packets(&bvh, &rays))),
        ] {
            for i in 0..rays.len() {
                assert_eq!(hits[i], nearest[i], "{name} lanes: {:?}", rays[i]);
                assert_eq!(results[i], any[i], "{name} lanes: {:?}", rays[i]);
                assert!(results[i] || hits[i].is_miss(), "{:?}", rays[i]);
            }
        }
        // Fewer at a time, in another order.
        let mut order = Order::default();
        let mut hits = vec![Hit::MISS; rays.len()];
        for (rays, hits) in rays.chunks(37).zip(hits.chunks_mut(37)) {
            bvh.trace_ordered(rays, hits, &mut order);
        }
        assert_eq!(hits, nearest);
    }
}
