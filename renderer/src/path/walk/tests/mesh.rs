//! Walks inside of triangles.

use super::super::super::geometry::Geometry;
use super::*;
use crate::scene::{Camera, EnvironmentLight, Object, Scene};
use burnish_assets::{Environment, Mesh};
use burnish_material::Material;
use std::sync::Arc;

/// A ball of triangles of radius about 1, off the origin by `shift` in scene units.
fn ball(rings: u32, shift: f32) -> Geometry {
    let mut mesh = Mesh::default();
    for i in 0..=rings {
        for j in 0..2 * rings {
            let (theta, phi) = (f64::from(i) / f64::from(rings), f64::from(j) / f64::from(rings));
            let (st, ct) = (theta * std::f64::consts::PI).sin_cos();
            let (sp, cp) = (phi * std::f64::consts::PI).sin_cos();
            let st = if i == 0 || i == rings { 0.0 } else { st };
            mesh.positions.push(DVec3::new(st * sp, ct, st * cp).as_vec3() + shift);
        }
    }
    let at = |i: u32, j: u32| i * 2 * rings + j % (2 * rings);
    for i in 0..rings {
        for j in 0..2 * rings {
            mesh.triangles.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
            mesh.triangles.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
    }
    let map = Arc::new(Environment { name: "black".to_owned(), width: 2, height: 1, texels: vec![[0.0; 3]; 2] });
    Geometry::new(
        &Scene {
            objects: vec![Object {
                mesh: Arc::new(mesh),
                material: Arc::new(Material::named("test")),
                textures: Arc::default(),
                is_document: true,
                length_scale: 1.0,
            }],
            environment: EnvironmentLight { map, rotation_deg: 0.0, scale: 1.0 },
            camera: Camera { origin: Vec3::Z, target: Vec3::ZERO, up: Vec3::Y, fov_deg: 30.0 },
            max_bounces: 1,
        },
        &mut super::super::super::mip::Sources::default(),
    )
}

/// A grey medium, its extinction in units of the ball's radius.
fn body(geometry: &Geometry, extinction: f32, absorbed: f64) -> Body {
    let scale = geometry.scale as f32;
    Body::new(&medium([extinction / scale; 3], [absorbed; 3]), scale)
}

/// A walk that enters one of the triangles somewhere.
fn through(geometry: &Geometry, body: &Body, method: Method, i: u32, stats: &mut WalkStats) -> [f64; 3] {
    // Rows of triangles near the equator, all of nearly the same size.
    let count = geometry.triangles.len();
    let triangle = (count * 3 / 8 + (number(6, i, 2) * (count / 4) as f64) as usize) as u32;
    let corners = geometry.triangles[triangle as usize];
    let corner = |k: usize| Vec3::from_slice(&geometry.vertices[corners[k] as usize][..3]).as_dvec3();
    let (s, v) = (number(6, i, 3).sqrt(), number(6, i, 4));
    let position = corner(0) * (1.0 - s) + corner(1) * (s * (1.0 - v)) + corner(2) * (s * v);
    let normal = Vec3::from(geometry.normals[triangle as usize]);
    let direction = inwards(normal.as_dvec3(), true, 6, i);
    let ray = crate::bvh::Ray { excluded: triangle, ..crate::bvh::Ray::new(position.as_vec3(), direction) };
    let start =
        Entry { triangle, normal, first: geometry.bvh.closest(&ray), ..entry(&Ball, position, direction, [1.0; 3], 6, i) };
    match walk(&Interior::new(geometry, 0), body, &start, method, stats) {
        End::Surface { throughput, .. } => throughput.map(f64::from),
        End::Absorbed | End::Lost { .. } => [0.0; 3],
    }
}

#[test]
fn a_ball_of_triangles_is_a_ball() {
    let geometry = ball(96, 0.0);
    for (extinction, absorbed) in [(10.0, 0.02), (100.0, 0.01)] {
        let body = body(&geometry, extinction, absorbed);
        let unit = Body::new(&medium([extinction; 3], [absorbed; 3]), 1.0);
        let mut reference = WalkStats::default();
        let exact = measure(0.0, 60_000, [true; 3], |i| {
            let entry = entry(&Ball, DVec3::Z, inwards(DVec3::Z, true, 7, i), [1.0; 3], 7, i);
            match walk(&Ball, &unit, &entry, Method::Jumping, &mut reference) {
                End::Surface { throughput, .. } => throughput.map(f64::from),
                _ => [0.0; 3],
            }
        });
        for method in METHODS {
            let mut stats = WalkStats::default();
            let sums = measure(0.0, 30_000, [true; 3], |i| through(&geometry, &body, method, i, &mut stats));
            assert!((sums.mean(0) - exact.mean(0)).abs() < 4.0 * sums.sigma(0).hypot(exact.sigma(0)), "{method:?}");
            assert_eq!((stats.cut, stats.lost, stats.outside), (0, 0, 0), "{method:?}");
        }
    }
}

#[test]
fn nothing_leaks_out_of_the_densest_body() {
    let geometry = ball(48, 0.0);
    for extinction in [1e3, 1e4, 1e5, 1e9] {
        let body = body(&geometry, extinction, 0.0);
        let mut stats = WalkStats::default();
        let sums = measure(0.0, 40_000, [true; 3], |i| through(&geometry, &body, Method::Jumping, i, &mut stats));
        assert!(1.0 - sums.mean(0) < 2e-4, "{extinction}: {} comes out", sums.mean(0));
        assert_eq!(stats.cut, 0);
    }
}
