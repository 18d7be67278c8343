//! Does light that scatters in a body come out as transport theory says, through the whole path tracer?

use burnish_assets::{Mesh, make_shape};
use burnish_material::{Material, Property, Value};
use burnish_renderer::path::{Settings, StopRules, render};
use burnish_renderer::scene::{ModelMeshes, Scene};
use burnish_renderer::{Camera, Object};
use burnish_tests::materials::{c, f, material};
use burnish_tests::scenes::{environment, mean};
use glam::Vec3;
use std::sync::Arc;

/// Colour whose inverted albedo is `a`: van de Hulst's formula.
fn color(a: f64) -> f64 {
    let s = (1.0 - a).sqrt();
    (1.0 - s) * (1.0 - 0.139 * s) / (1.0 + 1.17 * s)
}

fn body(albedos: [f64; 3], distance: f64, more: &[(Property, Value)]) -> Material {
    let mut m = material(&[
        (Property::translucency, f(1.0)),
        (Property::roughness, f(0.0)),
        (Property::scatter, Value::Bool(true)),
        (Property::scatter_distance, f(distance)),
    ]);
    let [r, g, b] = albedos.map(color);
    m.set(Property::scatter_color, c(r, g, b));
    for (property, value) in more {
        m.set(*property, *value);
    }
    m
}

/// A block with its upper side in the plane y = 0.
fn block(half: f32, depth: f32) -> Mesh {
    let mut mesh = Mesh::default();
    for x in [-half, half] {
        for y in [-depth, 0.0] {
            for z in [-half, half] {
                mesh.positions.push(Vec3::new(x, y, z));
            }
        }
    }
    let quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];
    for [a, b, c, d] in quads {
        mesh.triangles.push([a, b, c]);
        mesh.triangles.push([a, c, d]);
    }
    mesh
}

fn reflectance(material: Material, mesh: Mesh, spp: u32) -> [f64; 3] {
    let object = Object {
        mesh: Arc::new(mesh),
        material: Arc::new(material),
        textures: Arc::default(),
        is_document: true,
        length_scale: 1.0,
    };
    let camera = Camera { origin: Vec3::new(0.0, 40.0, 0.0), target: Vec3::ZERO, up: Vec3::Z, fov_deg: 0.1 };
    let scene = Scene { objects: vec![object], environment: environment(&[1.0; 8]), camera, max_bounces: 256 };
    let stop = StopRules { spp: Some(spp), ..StopRules::default() };
    let rendering =
        render(&scene, &Settings { width: 32, height: 32, seed: 7, threads: 2, stop, is_adaptive: false }, &mut |_| true);
    assert_eq!(rendering.nonfinite, 0);
    mean(&rendering.film)
}

/// Reflectance of a half-space at normal incidence, with and without a boundary. Reference: H functions of Chandrasekhar (1960).
#[test]
fn a_thick_block_reflects_like_a_half_space() {
    let matched = [(Property::specular_ior, f(1.0))];
    let pure = [(Property::opacity, f(0.0)), (Property::translucency, f(0.0))];
    let glass = [(Property::specular_ior, f(1.4))];
    type Case<'a> = (&'a str, &'a [(Property, Value)], [f64; 3], [f64; 3]);
    let cases: [Case<'_>; 4] = [
        ("matched", &matched, [0.3, 0.8, 0.99], [0.05721, 0.28525, 0.75272]),
        ("without surface", &pure, [0.5, 0.9, 0.999], [0.11523, 0.41495, 0.91285]),
        ("IOR 1.4", &glass, [0.3, 0.8, 0.99], [0.05221, 0.18082, 0.63137]),
        ("IOR 1.4", &glass, [0.5, 0.9, 0.999], [0.08008, 0.27837, 0.85789]),
    ];
    for (name, more, albedos, expected) in cases {
        let found = reflectance(body(albedos, 0.05, more), block(50.0, 80.0), 1024);
        for k in 0..3 {
            let error = found[k] / expected[k] - 1.0;
            println!("{name}, albedo {}: {:.5}, expected {} ({:+.3} %)", albedos[k], found[k], expected[k], 100.0 * error);
            assert!(error.abs() < 0.005, "{name}, albedo {}: {}, expected {}", albedos[k], found[k], expected[k]);
        }
    }
}

/// Nothing is lost in a body that absorbs nothing, however dense, with or without a surface.
#[test]
fn a_white_body_before_white_is_white() {
    let model: ModelMeshes = make_shape("sphere").expect("the sphere is built in").into();
    for (name, distance, more) in [
        ("thin", 1.0, vec![]),
        ("dense", 0.02, vec![]),
        ("stiff", 1e-5, vec![]),
        ("beyond the floor", 0.0, vec![]),
        ("stiff, without surface", 1e-5, vec![(Property::opacity, f(0.0))]),
        ("dense, half there", 0.05, vec![(Property::opacity, f(0.5)), (Property::roughness, f(0.3))]),
        ("spread 1000:1", 0.5, vec![(Property::scatter_distance_scale, c(1.0, 0.03, 0.001))]),
    ] {
        let material = body([1.0; 3], distance, &more);
        let mut scene = Scene::of_model(&model, Arc::new(material), Arc::default(), environment(&[1.0; 8]), 100.0);
        scene.objects.retain(|o| o.is_document);
        scene.max_bounces = 1024;
        let stop = StopRules { spp: Some(32), ..StopRules::default() };
        let rendering =
            render(&scene, &Settings { width: 24, height: 24, seed: 7, threads: 2, stop, is_adaptive: false }, &mut |_| true);
        let found = mean(&rendering.film);
        println!("{name}: {found:?}, {:.1} s", rendering.seconds);
        assert!(found.iter().all(|x| (x - 1.0).abs() < 0.01), "{name}: {found:?}");
    }
}
