//! Ways to bring light that must not change the picture: photons, candidates, branches. Each is compared with paths that do without it.

use super::tests::{environment, object, sphere};
use super::*;
use crate::scene::{Camera, EnvironmentLight, Object};
use burnish_assets::Mesh;
use burnish_material::{Material, Property, Value};
use glam::{Vec2, Vec3, Vec4};
use std::sync::Arc;

/// A level square around the point below the origin.
fn floor(y: f32, half: f32) -> Mesh {
    let corners = [(-1.0, -1.0), (-1.0, 1.0), (1.0, 1.0), (1.0, -1.0)];
    Mesh {
        positions: corners.map(|(x, z)| Vec3::new(x * half, y, z * half)).to_vec(),
        normals: vec![Vec3::Y; 4],
        tangents: vec![Vec4::new(1.0, 0.0, 0.0, 1.0); 4],
        uvs: corners.map(|(x, z)| Vec2::new(x, z)).to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..Mesh::default()
    }
}

fn material(values: &[(Property, Value)]) -> Arc<Material> {
    let mut material = Material::named("test");
    for (property, value) in values {
        material.set(*property, *value);
    }
    Arc::new(material)
}

fn metal(roughness: f64) -> Arc<Material> {
    let gold = Value::Color([0.9, 0.7, 0.3]);
    material(&[
        (Property::metallic, Value::Float(1.0)),
        (Property::base_color, gold),
        (Property::roughness, Value::Float(roughness)),
    ])
}

fn glass(roughness: f64) -> Arc<Material> {
    material(&[
        (Property::translucency, Value::Float(1.0)),
        (Property::roughness, Value::Float(roughness)),
        (Property::absorption_color, Value::Color([0.5, 0.8, 0.9])),
        (Property::absorption_distance, Value::Float(1.0)),
    ])
}

fn coated(base: &Arc<Material>, roughness: f64) -> Arc<Material> {
    let mut material = (**base).clone();
    material.set(Property::coat, Value::Float(1.0));
    material.set(Property::coat_roughness, Value::Float(roughness));
    material.set(Property::coat_color, Value::Color([0.9, 0.5, 0.4]));
    Arc::new(material)
}

fn matt(color: f64) -> Arc<Material> {
    let values = [(Property::roughness, Value::Float(1.0)), (Property::specular_level, Value::Float(0.0))];
    material(&[&values[..], &[(Property::base_color, Value::Color([color; 3]))]].concat())
}

/// A lamp of 28 degrees, high up, in a dim room: large enough for paths without photons to find it.
fn lamp() -> EnvironmentLight {
    environment(|i, j| if (29..34).contains(&i) && (6..11).contains(&j) { 50.0 } else { 0.3 })
}

/// A ball over a floor, seen from above.
fn ball(material: Arc<Material>) -> Scene {
    let floor = Object { is_document: false, ..object(floor(-1.05, 6.0), matt(0.6)) };
    let camera = Camera { origin: Vec3::new(1.0, 3.0, 5.0), target: Vec3::new(0.0, -0.5, 0.0), up: Vec3::Y, fov_deg: 40.0 };
    Scene { objects: vec![object(sphere(1.0, 48), material), floor], environment: lamp(), camera, max_bounces: 8 }
}

const SIZE: usize = 32;

fn picture(prepared: &Prepared, spp: u32, seed: u64) -> Film {
    let mut film = Film::new(SIZE, SIZE);
    render_pass(prepared, &mut film, spp, seed, 2, &|| false).expect("nothing cancels");
    film
}

/// Asserts that two independent films show the same picture: blocks of 4 by 4 pixels differ as their variances say, and all together
/// by less than `tolerance`.
fn assert_same(a: &Film, b: &Film, tolerance: f64, what: &str) {
    let (ma, mb, va, vb) = (a.mean(), b.mean(), a.variance(), b.variance());
    let blocks = SIZE / 4;
    let (mut squares, mut count) = (0.0, 0.0);
    for block in 0..blocks * blocks {
        let pixels = (0..16).map(|i| (block / blocks * 4 + i / 4) * SIZE + block % blocks * 4 + i % 4);
        for k in 0..3 {
            let sum = |f: &[[f32; 3]]| pixels.clone().map(|p| f64::from(f[p][k])).sum::<f64>();
            let variance = sum(&va) + sum(&vb);
            if variance > 0.0 {
                squares += (sum(&ma) - sum(&mb)).powi(2) / variance;
                count += 1.0;
            }
        }
    }
    // Channels share their noise, and a variance from four numbers is itself uncertain.
    let mean_square = squares / count;
    assert!(count > 50.0 && mean_square < 1.7, "{what}: blocks differ, mean square {mean_square}");
    let total = |f: &[[f32; 3]]| f.iter().flatten().map(|c| f64::from(*c)).sum::<f64>();
    let ratio = total(&ma) / total(&mb);
    assert!((ratio - 1.0).abs() < tolerance, "{what}: {ratio}");
}

#[test]
fn photons_bring_what_paths_find() {
    for (what, material) in [
        ("mirror", metal(0.0)),
        ("metal", metal(0.4)),
        ("glass", glass(0.0)),
        ("rough glass", glass(0.4)),
        ("coated metal", coated(&metal(0.4), 0.0)),
        ("coated glass", coated(&glass(0.2), 0.3)),
    ] {
        let scene = ball(material);
        let with = Prepared::new(&scene, None);
        assert!(with.has_photons(), "{what}");
        let photons = picture(&with, 1024, 1);
        assert_same(&photons, &picture(&with.without_photons(), 2048, 2), 0.01, what);
    }
}

#[test]
fn photons_start_only_where_there_is_something_to_gain() {
    let is_on = |scene: &Scene| Prepared::new(scene, None).has_photons();
    assert!(!is_on(&ball(matt(0.5))), "nothing throws caustics");
    assert!(!is_on(&ball(material(&[(Property::roughness, Value::Float(0.2))]))), "faint ones");
    let mut scene = ball(glass(0.0));
    scene.environment = environment(|_, j| 1.0 + j as f32 / 32.0);
    assert!(!is_on(&scene), "no light is hot");
    let mut scene = ball(glass(0.0));
    scene.objects.truncate(1);
    assert!(!is_on(&scene), "nothing shows them");
}

#[test]
fn candidates_bring_what_one_direction_brings() {
    for (what, material) in [
        ("plastic", material(&[(Property::roughness, Value::Float(0.3))])),
        ("metal", metal(0.5)),
        ("brushed", {
            let mut material = (*metal(0.3)).clone();
            material.set(Property::anisotropy, Value::Float(0.8));
            Arc::new(material)
        }),
        ("coated metal", coated(&metal(0.5), 0.0)),
        ("coated plastic", coated(&matt(0.4), 0.2)),
    ] {
        let scene = ball(material);
        let mut prepared = Prepared::new(&scene, None).without_photons();
        let candidates = picture(&prepared, 128, 3);
        prepared.resamples = false;
        assert_same(&candidates, &picture(&prepared, 256, 4), 0.01, what);
    }
}

#[test]
fn even_directions_bring_what_one_direction_brings() {
    for (what, material) in [("dark", matt(0.2)), ("bright", matt(0.9))] {
        let mut prepared = Prepared::new(&ball(material), None);
        assert_eq!(prepared.surfaces[0].connection, direct::Connection::Matt, "{what}");
        let even = picture(&prepared, 128, 7);
        prepared.resamples = false;
        assert_same(&even, &picture(&prepared, 256, 8), 0.01, what);
    }
}

#[test]
fn both_branches_make_up_the_choice_between_them() {
    for (what, material) in [
        ("glass", glass(0.0)),
        ("coated glass", coated(&glass(0.0), 0.2)),
        ("half glass", {
            let mut material = (*glass(0.0)).clone();
            material.set(Property::translucency, Value::Float(0.5));
            Arc::new(material)
        }),
    ] {
        let mut prepared = Prepared::new(&ball(material), None).without_photons();
        assert!(prepared.surfaces[0].splits, "{what}");
        let branches = picture(&prepared, 128, 5);
        prepared.surfaces[0].splits = false;
        assert_same(&branches, &picture(&prepared, 256, 6), 0.01, what);
    }
}

#[test]
fn sharp_surfaces_are_not_connected() {
    let connection = |material| Prepared::new(&ball(material), None).surfaces[0].connection;
    assert_eq!(connection(glass(0.0)), direct::Connection::None);
    assert_eq!(connection(glass(0.3)), direct::Connection::One);
    assert_ne!(connection(metal(0.3)), direct::Connection::None);
    assert_ne!(connection(coated(&glass(0.0), 0.3)), direct::Connection::None);
}
