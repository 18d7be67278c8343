//! Meshes that are displaced.

use super::super::geometry::Geometry;
use super::super::tests::{picture, scene, sphere, window};
use super::super::unsupported;
use super::{base_plane, coarse, geometry, hills, image, matt, place, textured, white_room};
use crate::bvh::Ray;
use crate::scene::Object;
use burnish_assets::{Image, Mesh};
use burnish_material::{Property, Value};
use glam::{Vec2, Vec3};
use std::collections::HashMap;
use std::sync::Arc;

#[test]
fn a_constant_height_makes_a_larger_ball() {
    // (0.75 - 0.5) * 0.8 = 0.2.
    let values = [(Property::height, Value::Float(0.75)), (Property::height_scale, Value::Float(0.8))];
    let uniform = textured(sphere(1.0, 48), &matt(&values), &[]);
    // A map that varies by next to nothing is displaced like any other.
    let map = image(4, 4, |x, _| [0.75 + 1e-6 * x as f32; 3]);
    let mapped = textured(sphere(1.0, 48), &matt(&values), &[(Property::height, map)]);
    for object in [&uniform, &mapped] {
        let g = geometry(object);
        for v in &g.vertices {
            let radius = f64::from(place(v).length()) / g.scale;
            // Flat triangles of the ball lie up to 1 - cos(pi / 96) inside, twice.
            assert!((radius - 1.2).abs() < 2e-3, "{radius}");
        }
    }
    assert!(geometry(&mapped).triangles.len() > 10 * geometry(&uniform).triangles.len());
    // The picture is that of a larger ball: it covers the same pixels.
    let alpha = |o: &Object| picture(&scene(vec![o.clone()], white_room()), 48, &[4], 2).0.alpha();
    let large = textured(sphere(1.2, 48), &matt(&[]), &[]);
    for object in [uniform, mapped] {
        let differing = alpha(&object).iter().zip(alpha(&large)).filter(|(a, b)| (*a - b).abs() > 0.26).count();
        assert!(differing <= 2, "{differing} pixels");
    }
}

/// Edges by the places of their ends, with how often triangles run along them one way less the other.
fn open_edges(g: &Geometry) -> usize {
    let mut edges: HashMap<[[u32; 3]; 2], i32> = HashMap::new();
    for t in &g.triangles {
        let bits = [0, 1, 2].map(|k| place(&g.vertices[t[k] as usize]).to_array().map(|x| (x + 0.0).to_bits()));
        for k in 0..3 {
            let (a, b) = (bits[k], bits[(k + 1) % 3]);
            if a != b {
                *edges.entry([a.min(b), a.max(b)]).or_default() += if a < b { 1 } else { -1 };
            }
        }
    }
    edges.values().filter(|n| **n != 0).count()
}

/// A cube whose faces have uvs and normals of their own.
fn cube() -> Mesh {
    let mut mesh = Mesh::default();
    for axis in 0..3 {
        for sign in [-1.0f32, 1.0] {
            let (n, a, b) = (
                [Vec3::X, Vec3::Y, Vec3::Z][axis] * sign,
                [Vec3::Y, Vec3::Z, Vec3::X][axis],
                [Vec3::Z, Vec3::X, Vec3::Y][axis] * sign,
            );
            let first = mesh.positions.len() as u32;
            for (s, t) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
                mesh.positions.push(n + a * s + b * t);
                mesh.normals.push(n);
                mesh.uvs.push(Vec2::new(s * 0.31 + 0.1 * axis as f32, t * 0.47 * sign));
            }
            mesh.triangles.push([first, first + 1, first + 2]);
            mesh.triangles.push([first, first + 2, first + 3]);
        }
    }
    mesh.complete().0
}

#[test]
fn displaced_bodies_stay_closed() {
    for (name, mesh) in [("ball", sphere(1.0, 24)), ("cube", cube())] {
        let scale = [(Property::height_scale, Value::Float(0.3))];
        let g = geometry(&textured(mesh.clone(), &matt(&scale), &[(Property::height, hills())]));
        assert!(g.triangles.len() > 50_000, "{name}: {}", g.triangles.len());
        assert_eq!(open_edges(&g), 0, "{name}");
        // Nothing gets out of the body, whatever the direction.
        let rays = (0..2000).map(|i| {
            let z = (i as f32 + 0.5) / 1000.0 - 1.0;
            let (sin, cos) = (i as f32 * 2.399_963).sin_cos();
            let r = (1.0 - z * z).sqrt();
            Ray::new(Vec3::new(0.01, 0.02, -0.01), Vec3::new(r * cos, z, r * sin))
        });
        for ray in rays {
            assert!(!g.bvh.closest(&ray).is_miss(), "{name}: {:?}", ray.direction);
        }
    }
    // A cube that grows evenly stays a cube.
    let grown = geometry(&textured(cube(), &matt(&[(Property::height, Value::Float(0.7))]), &[]));
    for v in &grown.vertices {
        let p = place(v) / grown.scale as f32;
        assert!(p.abs().cmpgt(Vec3::splat(1.19)).all() && p.abs().cmplt(Vec3::splat(1.21)).all(), "{p}");
    }
}

#[test]
fn height_at_its_level_changes_no_bit() {
    let bits = |values: &[(Property, Value)], maps: &[(Property, Arc<Image>)]| {
        let object = textured(sphere(1.0, 24), &[&[(Property::coat, Value::Float(0.5))], values].concat(), maps);
        picture(&scene(vec![object], window()), 24, &[4], 2).0.mean()
    };
    let plain = bits(&[], &[]);
    let level = [(Property::height_level, Value::Float(0.3)), (Property::height, Value::Float(0.3))];
    assert_eq!(bits(&level, &[]), plain);
    assert_eq!(bits(&level[..1], &[(Property::height, image(8, 8, |_, _| [0.3; 3]))]), plain);
    assert_eq!(bits(&[(Property::height_scale, Value::Float(0.0))], &[(Property::height, hills())]), plain);
    assert_ne!(bits(&[], &[(Property::height, hills())]), plain);
}

#[test]
fn odd_heights_render() {
    let odd = image(8, 8, |x, y| {
        let values = [f32::NAN, f32::INFINITY, 65504.0, -65504.0, f32::MAX, f32::MIN, -0.0, 0.5];
        [values[(x + 3 * y) % 8]; 3]
    });
    let hills = hills();
    let mut bare = sphere(1.0, 8);
    bare.uvs.clear();
    let mut unmapped = sphere(1.0, 8);
    unmapped.uvs.iter_mut().for_each(|uv| *uv = Vec2::ZERO);
    let mut line = sphere(1.0, 8);
    line.uvs.iter_mut().for_each(|uv| uv.y = uv.x);
    let mut flat = sphere(1.0, 8);
    flat.triangles.push([0, 0, 0]);
    flat.triangles.push([3, 40, 3]);
    flat.positions[5] = Vec3::splat(f32::NAN);
    let mut point = sphere(1.0, 4);
    point.positions.iter_mut().for_each(|p| *p = Vec3::ZERO);
    for (name, mesh, is_placed) in [
        ("ball", sphere(1.0, 8), true),
        ("no uvs", bare, false),
        ("one uv", unmapped, false),
        ("uvs on a line", line, true),
        ("flat triangles", flat, true),
        ("a point", point, true),
    ] {
        for (scale, map) in [(-0.3, &odd), (1e300, &odd), (f64::INFINITY, &hills)] {
            let values = [(Property::height_scale, Value::Float(scale)), (Property::normal_scale, Value::Float(scale))];
            let maps = [(Property::height, map.clone()), (Property::normal, map.clone())];
            let scene = scene(vec![textured(coarse(mesh.clone()), &values, &maps)], white_room());
            let (film, stats) = picture(&scene, 8, &[1], 1);
            assert_eq!((stats.nonfinite, stats.negative), (0, 0), "{name}, scale {scale}");
            assert!(film.mean().iter().flatten().all(|c| c.is_finite() && *c >= 0.0), "{name}, scale {scale}");
            let is_said = unsupported(&scene).iter().any(|s| s.contains("no texture coordinates"));
            assert_eq!(is_said, !is_placed, "{name}");
        }
    }
}

#[test]
fn odd_uniform_heights_render() {
    let glass = [(Property::translucency, Value::Float(1.0)), (Property::opacity, Value::Float(0.5))];
    for height in [1e300, -1e30, 3.0, -1.0, 0.5 + 1e-9, f64::NAN, f64::INFINITY] {
        for scale in [1.0, 1e300, -1e-30] {
            let values = [&glass[..], &[(Property::height, Value::Float(height)), (Property::height_scale, Value::Float(scale))]];
            let scene = scene(vec![textured(sphere(1.0, 8), &values.concat(), &[])], window());
            let (film, stats) = picture(&scene, 8, &[2], 1);
            assert_eq!((stats.nonfinite, stats.negative), (0, 0), "{height} times {scale}");
            assert!(film.mean().iter().flatten().all(|c| c.is_finite() && *c >= 0.0), "{height} times {scale}");
        }
    }
}

#[test]
fn what_is_only_bent_is_said() {
    let scale = [(Property::height_scale, Value::Float(0.1))];
    let sentences = |parts: bool| {
        let object = textured(base_plane(parts), &matt(&scale), &[(Property::height, hills())]);
        unsupported(&scene(vec![object], white_room()))
    };
    assert_eq!(sentences(true), Vec::<String>::new());
    assert!(sentences(false)[0].contains("2 million"));
}
