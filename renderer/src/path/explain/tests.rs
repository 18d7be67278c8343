//! The parts of a pixel make up the pixel that the renderer shows, and each is what its lobe alone would bring.

use super::super::tests::{environment, object, scene, sphere, window};
use super::*;
use crate::bsdf::albedos::Quantity;
use crate::bsdf::tables::sheen_albedo;
use crate::path::{Film, render_pass};
use crate::scene::{Object, Scene};
use burnish_material::{Material, Property as P, Value, Value::Bool, Value::Color, Value::Float};
use glam::Vec3;
use std::sync::Arc;

const SIZE: usize = 16;

fn body(name: &str, values: &[(P, Value)]) -> Object {
    let mut material = Material::named(name);
    for (property, value) in values {
        material.set(*property, *value);
    }
    object(sphere(1.0, 24), Arc::new(material))
}

/// A ball above another, so that light goes between them.
fn two(first: Object) -> Scene {
    let mut floor = body("floor", &[(P::base_color, Color([0.7, 0.6, 0.5])), (P::roughness, Float(1.0))]);
    Arc::make_mut(&mut floor.mesh).positions.iter_mut().for_each(|p| *p = *p * 3.0 - Vec3::Y * 4.0);
    scene(vec![first, floor], window())
}

fn materials() -> Vec<Object> {
    vec![
        body("plastic", &[(P::base_color, Color([0.8, 0.2, 0.1])), (P::roughness, Float(0.3))]),
        body(
            "coated metal",
            &[
                (P::metallic, Float(1.0)),
                (P::base_color, Color([0.9, 0.6, 0.3])),
                (P::roughness, Float(0.5)),
                (P::coat, Float(1.0)),
                (P::coat_roughness, Float(0.0)),
                (P::coat_color, Color([0.9, 0.8, 0.9])),
            ],
        ),
        body("mirror under a mirror", &[(P::metallic, Float(1.0)), (P::roughness, Float(0.0)), (P::coat, Float(0.8))]),
        body(
            "cloth",
            &[(P::roughness, Float(0.8)), (P::sheen, Float(1.0)), (P::sheen_roughness, Float(0.4)), (P::emission, Float(0.2))],
        ),
        body("glass", &[(P::translucency, Float(1.0)), (P::roughness, Float(0.0))]),
        body("prism", &[(P::translucency, Float(1.0)), (P::roughness, Float(0.2)), (P::dispersion, Float(5.0))]),
        body(
            "wax",
            &[
                (P::translucency, Float(1.0)),
                (P::roughness, Float(0.4)),
                (P::scatter, Bool(true)),
                (P::scatter_color, Color([0.9, 0.7, 0.5])),
                (P::scatter_distance, Float(0.2)),
            ],
        ),
        body("lace", &[(P::opacity, Float(0.4)), (P::roughness, Float(0.6))]),
    ]
}

fn sum_of(explanation: &Explanation) -> [f64; 3] {
    let lobes = explanation.lobes.iter().map(|part| part.radiance);
    lobes.chain([explanation.emission, explanation.through]).fold([0.0; 3], |a, b| [0, 1, 2].map(|k| a[k] + b[k]))
}

fn part(explanation: &Explanation, lobe: Lobe) -> [f64; 3] {
    explanation.lobes.iter().find(|part| part.lobe == lobe).map_or([0.0; 3], |part| part.radiance)
}

#[test]
fn parts_sum_to_the_pixel_of_the_renderer() {
    for body in materials() {
        let prepared = Prepared::new(&two(body.clone()), None).without_photons();
        let mut film = Film::new(SIZE, SIZE);
        render_pass(&prepared, &mut film, 64, SEED, 1, &|| false).expect("nothing cancels");
        let (mean, variance) = (film.mean(), film.variance());
        for (x, y) in [(8, 8), (8, 5), (5, 7), (3, 8), (8, 13), (0, 0)] {
            let explanation = explain(&prepared, x, y, SIZE, SIZE, 64);
            let (sum, pixel) = (sum_of(&explanation), y * SIZE + x);
            for k in 0..3 {
                let name = &body.material.name;
                let expected = f64::from(mean[pixel][k]);
                // The same paths: what differs is rounding.
                assert!(
                    (explanation.radiance[k] - expected).abs() <= 1e-4 * expected,
                    "{name} {x} {y}: {explanation:?} {expected}"
                );
                assert!((sum[k] - expected).abs() <= 1e-4 * expected, "{name} {x} {y}: {sum:?} {expected}");
                let error = f64::from(variance[pixel][k]).sqrt();
                assert!((explanation.standard_error[k] - error).abs() <= 1e-3 * error + 1e-6, "{name}: {error}");
            }
            let shares: f64 = explanation.lobes.iter().map(|part| part.share).sum();
            assert!(shares <= 1.0 + 1e-6 && explanation.lobes.windows(2).all(|pair| pair[0].share >= pair[1].share));
        }
    }
}

#[test]
fn without_photons_the_limit_is_the_same() {
    // A lens over a matt ball throws a caustic, which a picture gets from photons.
    let lens = body("glass", &[(P::translucency, Float(1.0)), (P::roughness, Float(0.1))]);
    let prepared = Prepared::new(&two(lens), None);
    assert!(prepared.has_photons());
    let (mut got, mut expected) = (0.0, 0.0);
    let mut film = Film::new(SIZE, SIZE);
    render_pass(&prepared, &mut film, 256, 3, 2, &|| false).expect("nothing cancels");
    for (x, y) in (10..15).flat_map(|y| (4..12).map(move |x| (x, y))) {
        got += explain(&prepared, x, y, SIZE, SIZE, 256).radiance[1];
        expected += f64::from(film.mean()[y * SIZE + x][1]);
    }
    assert!((got / expected - 1.0).abs() < 0.03, "{got} {expected}");
}

/// A convex body under even light of radiance 1: each part is the directional albedo of its lobe.
fn in_a_white_room(body: Object) -> (Prepared, Explanation) {
    let mut scene = scene(vec![body], environment(|_, _| 1.0));
    // A narrow pixel: one angle.
    scene.camera.fov_deg = 0.2;
    scene.camera.target = Vec3::new(0.5, 0.4, 0.6);
    let prepared = Prepared::new(&scene, None);
    let explanation = explain(&prepared, 0, 0, 1, 1, 4096);
    (prepared, explanation)
}

#[test]
fn each_part_is_what_its_lobe_reflects() {
    let kept = |prepared: &Prepared, explanation: &Explanation, is_coat: bool, quantity: Quantity| {
        let albedos = &prepared.surfaces[0].albedos;
        let grid = if is_coat { &albedos.coat } else { &albedos.base };
        let mu = explanation.surface.as_ref().expect("it is hit").view_angle.to_radians().cos();
        let wo = V3::new((1.0 - mu * mu).sqrt(), 0.0, mu);
        (1.0 - grid.at(quantity, &grid.place([0.0; 5]), &grid.slant(wo)), mu)
    };
    let near = |got: f64, expected: f64, what: &str| {
        assert!((got - expected).abs() < 0.01 * expected.max(0.1), "{what}: {got} {expected}")
    };

    let (prepared, plastic) = in_a_white_room(body("plastic", &[(P::base_color, Color([0.8; 3])), (P::roughness, Float(0.3))]));
    let (reflected, _) = kept(&prepared, &plastic, false, Quantity::DielectricMiss);
    near(part(&plastic, Lobe::specular)[0], reflected, "specular");
    near(part(&plastic, Lobe::diffuse)[0], 0.8 * (1.0 - reflected), "diffuse");

    let (prepared, metal) = in_a_white_room(body(
        "metal",
        &[(P::metallic, Float(1.0)), (P::base_color, Color([1.0; 3])), (P::roughness, Float(0.7))],
    ));
    let (reflected, _) = kept(&prepared, &metal, false, Quantity::MetalMiss);
    near(part(&metal, Lobe::metal)[0], reflected, "metal");
    near(part(&metal, Lobe::multiple_scattering)[0], 1.0 - reflected, "further");

    let coated = [(P::metallic, Float(1.0)), (P::roughness, Float(0.0)), (P::coat, Float(0.5)), (P::coat_roughness, Float(0.4))];
    let (prepared, coated) = in_a_white_room(body("coated", &coated));
    let (reflected, _) = kept(&prepared, &coated, true, Quantity::DielectricMiss);
    near(part(&coated, Lobe::coat)[0], 0.5 * reflected, "coat");

    let cloth =
        [(P::roughness, Float(1.0)), (P::sheen, Float(0.5)), (P::sheen_color, Color([0.4; 3])), (P::sheen_roughness, Float(0.6))];
    let (prepared, cloth) = in_a_white_room(body("cloth", &cloth));
    let (_, mu) = kept(&prepared, &cloth, false, Quantity::DielectricMiss);
    near(part(&cloth, Lobe::sheen)[0], 0.2 * sheen_albedo(0.6, mu), "sheen");

    let (_, glass) = in_a_white_room(body("glass", &[(P::translucency, Float(1.0)), (P::roughness, Float(0.0))]));
    near(part(&glass, Lobe::transmission)[0] + part(&glass, Lobe::specular)[0], 1.0, "glass");
    assert!(part(&glass, Lobe::transmission)[0] > 0.9);
}

#[test]
fn the_point_is_told() {
    let mut lamp = body("lamp", &[(P::emission, Float(2.0)), (P::base_color, Color([0.25; 3])), (P::roughness, Float(0.1))]);
    lamp.mesh = Arc::new({
        let mut mesh = sphere(1.0, 24);
        mesh.positions.iter_mut().for_each(|p| *p = *p * 10.0 + Vec3::new(5.0, 0.0, 0.0));
        mesh
    });
    let mut scene = scene(vec![lamp], window());
    scene.camera.origin = Vec3::new(5.0, 0.0, 40.0);
    scene.camera.target = Vec3::new(5.0, 0.0, 0.0);
    let prepared = Prepared::new(&scene, None);
    let explanation = explain(&prepared, 16, 16, 33, 33, 16);
    let surface = explanation.surface.as_ref().expect("the lamp is in the middle");
    let position = [5.0, 0.0, 10.0];
    assert!((0..3).all(|k| (surface.position[k] - position[k]).abs() < 0.05), "{surface:?}");
    assert!((surface.depth - 30.0).abs() < 0.05 && surface.view_angle < 3.0 && surface.normal[2] > 0.99, "{surface:?}");
    assert_eq!((surface.object, surface.material.as_str()), (0, "lamp"));
    assert_eq!((surface.inputs.base_color, surface.inputs.roughness), ([0.25; 3], 0.1));
    assert!((explanation.emission[1] - 2.0).abs() < 1e-6 && explanation.through == [0.0; 3]);
    assert_eq!(explanation.lobes.iter().map(|part| part.name).collect::<Vec<_>>(), {
        let mut names = vec!["diffuse", "specular"];
        names.sort_by_key(|name| *name != explanation.lobes[0].name);
        names
    });
}

#[test]
fn the_environment_is_no_surface() {
    let prepared = Prepared::new(&two(materials().remove(0)), None);
    let explanation = explain(&prepared, 0, 0, 64, 64, 1);
    assert!(explanation.surface.is_none() && explanation.lobes.is_empty());
    assert_eq!((explanation.samples, explanation.through), (4, explanation.radiance));
    assert!(explanation.radiance[0] > 0.1);
    // Beyond the picture and without one.
    assert_eq!(explain(&prepared, 99, 99, 8, 8, 8).radiance, explain(&prepared, 7, 7, 8, 8, 8).radiance);
    assert!(explain(&prepared, 3, 3, 0, 0, 0).radiance[0].is_finite());
    // Cut away: looked through, to the floor.
    let gone = Prepared::new(&two(body("gone", &[(P::opacity, Float(0.0))])), None);
    let explanation = explain(&gone, 8, 13, SIZE, SIZE, 16);
    assert_eq!(explanation.surface.map(|surface| surface.material), Some("floor".to_owned()));
}
