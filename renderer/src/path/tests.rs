//! Whole renders of small scenes whose result is known.

use super::batch::Batch;
use super::raygen::{Place, Raygen, Tile, View};
use super::shade::Shade;
use super::trace::trace;
use super::*;
use crate::lanes::{Kernel, Wide};
use crate::scene::{Camera, EnvironmentLight, Object};
use burnish_assets::{Environment, Mesh};
use burnish_material::{Material, Property, Value};
use glam::{Vec2, Vec3, Vec4};
use std::sync::Arc;

/// A sphere around the origin.
pub(super) fn sphere(radius: f32, rings: u32) -> Mesh {
    let mut mesh = Mesh::default();
    for i in 0..=rings {
        for j in 0..=2 * rings {
            let (u, v) = (j as f32 / (2 * rings) as f32, i as f32 / rings as f32);
            // The seam repeats its first column to the bit.
            let phi = (j % (2 * rings)) as f32 / (2 * rings) as f32 * std::f32::consts::TAU;
            let ring = if i == 0 || i == rings { 0.0 } else { (v * std::f32::consts::PI).sin() };
            let n = Vec3::new(ring * phi.sin(), (v * std::f32::consts::PI).cos(), ring * phi.cos());
            mesh.positions.push(n * radius);
            mesh.normals.push(n.normalize());
            mesh.tangents.push(Vec4::new(phi.cos(), 0.0, -phi.sin(), 1.0));
            mesh.uvs.push(Vec2::new(u, v));
        }
    }
    let at = |i: u32, j: u32| i * (2 * rings + 1) + j;
    for i in 0..rings {
        for j in 0..2 * rings {
            mesh.triangles.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
            mesh.triangles.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
    }
    mesh
}

fn material(values: &[(Property, Value)]) -> Arc<Material> {
    let mut material = Material::named("test");
    for (property, value) in values {
        material.set(*property, *value);
    }
    Arc::new(material)
}

fn white() -> Arc<Material> {
    material(&[
        (Property::base_color, Value::Color([1.0; 3])),
        (Property::roughness, Value::Float(1.0)),
        (Property::specular_level, Value::Float(0.0)),
    ])
}

fn glass() -> Arc<Material> {
    material(&[
        (Property::translucency, Value::Float(1.0)),
        (Property::roughness, Value::Float(0.2)),
        (Property::absorption_color, Value::Color([0.9, 0.6, 0.3])),
        (Property::absorption_distance, Value::Float(0.8)),
    ])
}

pub(super) fn object(mesh: Mesh, material: Arc<Material>) -> Object {
    Object { mesh: Arc::new(mesh), material, textures: Arc::default(), is_document: true, length_scale: 1.0 }
}

pub(super) fn environment(f: impl Fn(usize, usize) -> f32) -> EnvironmentLight {
    let texels = (0..64 * 32).map(|i| [f(i % 64, i / 64); 3]).collect();
    let map = Arc::new(Environment { name: "test".to_owned(), width: 64, height: 32, texels });
    EnvironmentLight { map, rotation_deg: 25.0, scale: 1.0 }
}

/// Grey with a bright window.
pub(super) fn window() -> EnvironmentLight {
    environment(|i, j| if (20..26).contains(&i) && (8..12).contains(&j) { 40.0 } else { 0.4 })
}

pub(super) fn scene(objects: Vec<Object>, environment: EnvironmentLight) -> Scene {
    let camera = Camera { origin: Vec3::new(0.4, 0.7, 3.2), target: Vec3::ZERO, up: Vec3::Y, fov_deg: 40.0 };
    Scene { objects, environment, camera, max_bounces: 16 }
}

pub(super) fn picture(scene: &Scene, size: usize, passes: &[u32], threads: usize) -> (Film, PassStats) {
    let prepared = Prepared::new(scene, None);
    let mut film = Film::new(size, size);
    let mut total = PassStats::default();
    for &spp in passes {
        total.add(&render_pass(&prepared, &mut film, spp, 7, threads, &|| false).expect("nothing cancels"));
    }
    (film, total)
}

pub(super) fn average(film: &Film) -> f64 {
    let mean = film.mean();
    mean.iter().flatten().map(|c| f64::from(*c)).sum::<f64>() / (3 * mean.len()) as f64
}

pub(super) fn mixed() -> Scene {
    let mut floor = sphere(0.5, 12);
    floor.positions.iter_mut().for_each(|p| *p += Vec3::new(0.9, -0.6, 0.2));
    scene(vec![object(sphere(1.0, 24), glass()), object(floor, white())], window())
}

#[test]
fn bits_do_not_depend_on_threads_and_passes() {
    let scene = mixed();
    let (one, stats) = picture(&scene, 50, &[1, 3, 12], 1);
    assert_eq!(stats, PassStats { samples: 50 * 50 * 16, ..PassStats::default() });
    for (threads, passes) in [(2, vec![16]), (4, vec![4, 4, 8]), (3, vec![5, 11])] {
        let (film, _) = picture(&scene, 50, &passes, threads);
        assert_eq!(film.mean(), one.mean(), "{threads} threads");
        assert_eq!(film.alpha(), one.alpha());
        assert_eq!(film.error(), one.error());
    }
}

#[test]
fn a_white_body_vanishes_in_a_white_room() {
    let room = || environment(|_, _| 1.0);
    let (film, stats) = picture(&scene(vec![object(sphere(1.0, 24), white())], room()), 48, &[64], 2);
    assert_eq!(stats.nonfinite + stats.negative, 0);
    let mean = average(&film);
    assert!((mean - 1.0).abs() < 5e-3, "{mean}");
    // Clear glass, and a body that is half cut through.
    let clear = material(&[(Property::translucency, Value::Float(1.0)), (Property::roughness, Value::Float(0.0))]);
    let mut lace = (*white()).clone();
    lace.set(Property::opacity, Value::Float(0.4));
    for (material, tolerance) in [(clear, 2e-2), (Arc::new(lace), 5e-3)] {
        let mean = average(&picture(&scene(vec![object(sphere(1.0, 24), material)], room()), 48, &[64], 2).0);
        assert!((mean - 1.0).abs() < tolerance, "{mean}");
    }
}

#[test]
fn light_sampling_changes_noise_only() {
    // The same map with a hidden bright texel below the horizon would change the table; instead compare with light sampling off
    // by asking for the same picture under a scale of the map, which must scale the picture.
    let bright = mixed();
    let mut dim = mixed();
    dim.environment.scale = 0.25;
    let (a, b) = (average(&picture(&bright, 32, &[64], 2).0), average(&picture(&dim, 32, &[64], 2).0));
    assert!((a * 0.25 / b - 1.0).abs() < 1e-4, "{a} {b}");
}

#[test]
fn size_does_not_change_the_picture() {
    let reference = picture(&mixed(), 32, &[16], 2).0.mean();
    for scale in [1e-4f32, 1e4] {
        let mut scaled = mixed();
        for object in &mut scaled.objects {
            let mesh = Arc::make_mut(&mut object.mesh);
            mesh.positions.iter_mut().for_each(|p| *p *= scale);
            object.length_scale = f64::from(scale);
        }
        scaled.camera.origin *= scale;
        let got = picture(&scaled, 32, &[16], 2).0.mean();
        let difference: f64 =
            got.iter().flatten().zip(reference.iter().flatten()).map(|(a, b)| f64::from((a - b).abs())).sum::<f64>()
                / (3.0 * 1024.0);
        // Rounding sends a few paths elsewhere.
        assert!(difference < 2e-2, "{scale}: {difference}");
        let sums: [f64; 2] = [&got, &reference].map(|p| p.iter().flatten().map(|c| f64::from(*c)).sum());
        assert!((sums[0] / sums[1] - 1.0).abs() < 5e-3, "{scale}: {sums:?}");
    }
}

#[test]
fn absorption_is_that_of_beer_and_lambert() {
    // An index-matched body: rays run straight, and the middle of the picture sees two radii of absorption.
    let body = material(&[
        (Property::translucency, Value::Float(1.0)),
        (Property::specular_ior, Value::Float(1.0)),
        (Property::absorption_color, Value::Color([0.5, 0.25, 1.0])),
        (Property::absorption_distance, Value::Float(1.0)),
    ]);
    let mut scene = scene(vec![object(sphere(1.0, 96), body)], environment(|_, _| 1.0));
    scene.camera.fov_deg = 0.5;
    let expected = [0.25, 0.0625, 1.0];
    let check = |scene: &Scene, expected: [f64; 3]| {
        for c in picture(scene, 8, &[4], 1).0.mean() {
            for k in 0..3 {
                assert!((f64::from(c[k]) - expected[k]).abs() < 2e-3, "{c:?}");
            }
        }
    };
    check(&scene, expected);
    // Without refraction, cut-through does the same.
    let mut cut = Material::named("cut");
    cut.set(Property::opacity, Value::Float(0.0));
    cut.set(Property::absorption_color, Value::Color([0.5, 0.25, 1.0]));
    cut.set(Property::absorption_distance, Value::Float(1.0));
    scene.objects[0].material = Arc::new(cut);
    check(&scene, expected);
    // From the middle only one radius is left.
    scene.camera.origin = Vec3::new(0.0, 0.0, 1e-3);
    check(&scene, [0.5, 0.25, 1.0]);
}

#[test]
fn bounces_are_limited() {
    // Inside a white ball that glows by nothing: with no scattering event after the first, only the emission of the second hit counts.
    let lamp = material(&[
        (Property::emission, Value::Float(1.0)),
        (Property::base_color, Value::Color([0.5; 3])),
        (Property::roughness, Value::Float(1.0)),
        (Property::specular_level, Value::Float(0.0)),
    ]);
    let mut shell = sphere(2.0, 24);
    // Front faces inwards.
    shell.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    shell.normals.iter_mut().for_each(|n| *n = -*n);
    let mut scene = scene(vec![object(shell, lamp)], environment(|_, _| 0.0));
    scene.camera.origin = Vec3::new(0.0, 0.0, 0.5);
    for (bounces, expected) in [(0, 1.5), (1, 1.75), (3, 1.9375), (64, 2.0)] {
        scene.max_bounces = bounces;
        let mean = average(&picture(&scene, 16, &[64], 2).0);
        assert!((mean - expected).abs() < 1e-2, "{bounces}: {mean}");
    }
}

#[test]
fn one_lane_shades_as_many_do() {
    let scene = mixed();
    let prepared = Prepared::new(&scene, None);
    let view = View::new(&prepared, 32, 32);
    let places: Vec<Place> = (0..1024).map(|pixel| Place { cell: pixel, pixel, sample: 0 }).collect();
    let tile = Tile { places: &places };
    let run = |is_wide: bool| {
        let mut batch = Batch::default();
        let mut stats = PassStats::default();
        batch.begin(tile.paths(), prepared.surfaces.len());
        Raygen { prepared: &prepared, view: &view, tile, seed: 3, paths: &mut batch.paths }.run::<f32>();
        trace(&prepared, &mut batch, 0, &mut PassStats::default());
        let Batch { paths, next, lists, shadows, .. } = &mut batch;
        for (surface, list) in prepared.surfaces.iter().zip(lists.iter()) {
            let shade = Shade {
                prepared: &prepared,
                surface,
                list,
                vertex: 0,
                paths: &mut *paths,
                next: &mut *next,
                shadows: &mut *shadows,
                stats: &mut stats,
            };
            if is_wide { shade.run::<Wide<16>>() } else { shade.run::<f32>() }
        }
        batch
    };
    let (one, wide) = (run(false), run(true));
    assert!(!one.next.is_empty() && !one.shadows.rays.is_empty());
    assert_eq!(one.next, wide.next);
    // Paths of a group are connected by turns; those of each path keep their order.
    let connections = |batch: &Batch| {
        let mut sorted: Vec<_> = batch.shadows.targets.iter().copied().zip(batch.shadows.contributions.iter().copied()).collect();
        sorted.sort_by_key(|(target, _)| *target);
        sorted
    };
    let (a, b) = (connections(&one), connections(&wide));
    assert_eq!(a.len(), b.len());
    for ((a_target, a), (b_target, b)) in a.iter().zip(&b) {
        assert_eq!(a_target, b_target);
        assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() <= 1e-5 * b.abs()), "{a:?} {b:?}");
    }
    for k in 0..3 {
        for (a, b) in one.paths.throughput[k].iter().zip(&wide.paths.throughput[k]) {
            assert!((a - b).abs() <= 1e-5 * b.abs(), "{a} {b}");
        }
    }
}

#[test]
fn nothing_and_odd_sizes_render() {
    let empty = scene(Vec::new(), environment(|_, _| 0.5));
    let (film, stats) = picture(&empty, 17, &[2], 2);
    assert!(film.mean().iter().flatten().all(|c| (c - 0.5).abs() < 1e-6) && film.alpha().iter().all(|a| *a == 0.0));
    assert_eq!(stats.nonfinite, 0);
    let settings = Settings {
        width: 0,
        height: 5,
        seed: 0,
        threads: 0,
        stop: StopRules { spp: Some(3), ..StopRules::default() },
        is_adaptive: true,
    };
    assert_eq!(render(&mixed(), &settings, &mut |_| true).stop_reason, StopReason::Spp);
}

#[test]
fn a_cancelled_pass_leaves_the_film_as_it_was() {
    let scene = mixed();
    let prepared = Prepared::new(&scene, None);
    let mut film = Film::new(32, 32);
    render_pass(&prepared, &mut film, 4, 7, 2, &|| false).expect("nothing cancels");
    let before = film.mean();
    let count = std::sync::atomic::AtomicUsize::new(0);
    let cancel = || count.fetch_add(1, std::sync::atomic::Ordering::Relaxed) > 3;
    assert!(render_pass(&prepared, &mut film, 4, 7, 2, &cancel).is_none());
    assert_eq!(film.mean(), before);
    render_pass(&prepared, &mut film, 4, 7, 2, &|| false).expect("nothing cancels");
    assert_eq!(film.mean(), picture(&scene, 32, &[8], 1).0.mean());
}

#[test]
fn features_are_those_of_the_first_hit() {
    let mut scene = mixed();
    scene.objects.truncate(1);
    scene.camera.origin = Vec3::new(0.0, 0.0, 3.0);
    let features = aovs(&Prepared::new(&scene, None), 33, 33);
    let middle = 16 * 33 + 16;
    assert!((features.depth[middle] - 2.0).abs() < 1e-2 && features.depth[0].is_infinite());
    assert!(features.normal[middle][2] > 0.99);
    assert_eq!(features.albedo[middle], [0.5; 3]);
}
