//! Does the live preview keep the energy of white materials, and does it draw what was set last?

use burnish_assets::make_shape;
use burnish_material::{Material, Property, Value};
use burnish_renderer::preview::Preview;
use burnish_renderer::scene::{ModelMeshes, Scene};
use burnish_tests::gpu::device;
use burnish_tests::materials::{c, f, material};
use burnish_tests::scenes::environment;
use std::sync::Arc;

/// Pixels along each side.
const SIDE: u32 = 32;
/// Largest departure from white under white light: of any channel (at the silhouette, where few samples are drawn), and of the mean.
const FURTHEST: f32 = 0.05;
const MEAN: f32 = 0.003;

fn sphere(material: Material) -> Scene {
    let model: ModelMeshes = make_shape("sphere").expect("the sphere is built in").into();
    let mut scene = Scene::of_model(&model, Arc::new(material), Arc::default(), environment(&[1.0; 8]), 100.0);
    // No floor: it is not white.
    scene.objects.retain(|object| object.is_document);
    scene
}

fn white(values: &[(Property, f64)]) -> Material {
    let mut m = material(&[(Property::base_color, c(1.0, 1.0, 1.0))]);
    for (property, x) in values {
        m.set(*property, Value::Float(*x));
    }
    m
}

/// Least and largest channel over the pixels of the picture.
fn range(pixels: &[[f32; 4]]) -> [f32; 2] {
    pixels.iter().flat_map(|p| &p[..3]).fold([f32::MAX, 0.0], |[low, high], x| [low.min(*x), high.max(*x)])
}

#[test]
fn white_materials_vanish_in_a_white_furnace() {
    use Property::*;
    let Some((device, queue)) = device() else { return };
    let mut preview = Preview::new(&device, &queue).expect("the preview can be made");
    let mut failed = false;
    for (name, values) in [
        ("metal", &[(metallic, 1.0), (roughness, 0.2)][..]),
        ("rough metal", &[(metallic, 1.0), (roughness, 1.0)]),
        ("stretched metal", &[(metallic, 1.0), (roughness, 0.3), (anisotropy, 0.8)]),
        ("dielectric", &[(roughness, 0.5)]),
        ("rough, dense dielectric", &[(roughness, 1.0), (specular_ior, 2.5)]),
        ("half metal", &[(roughness, 0.8), (metallic, 0.5)]),
        ("rough coat over rough metal", &[(metallic, 1.0), (roughness, 0.7), (coat, 1.0), (coat_roughness, 0.4)]),
        ("sheen over metal", &[(metallic, 1.0), (roughness, 0.7), (sheen, 1.0)]),
        ("rough glass", &[(translucency, 1.0), (roughness, 0.6)]),
    ] {
        preview.set_scene(&device, &queue, &sphere(white(values)));
        preview.set_rays(false);
        let pixels = preview.render(&device, &queue, SIDE, SIDE, 24).expect("the preview draws");
        let [low, high] = range(&pixels);
        let mean = |pixels: &[[f32; 4]]| pixels.iter().map(|p| p[1]).sum::<f32>() / pixels.len() as f32;
        // Rays are noisy pixel by pixel; at 64 samples nothing of the drawn picture is left.
        preview.set_rays(true);
        let traced = mean(&preview.render(&device, &queue, SIDE, SIDE, 66).expect("the preview draws"));
        let drawn = mean(&pixels);
        println!("{name}: {low} to {high}, mean {drawn}, of rays {traced}");
        failed |= low < 1.0 - FURTHEST || high > 1.0 + FURTHEST;
        failed |= (drawn - 1.0).abs() > MEAN || (traced - 1.0).abs() > MEAN;
    }
    assert!(!failed, "see above");
}

#[test]
fn what_was_set_last_is_drawn_in_the_end() {
    let Some((device, queue)) = device() else { return };
    let colored = |r: f64, stretch: f64| {
        let mut m = white(&[(Property::metallic, 1.0), (Property::roughness, 0.4), (Property::anisotropy, stretch)]);
        m.set(Property::base_color, c(r, 0.5, 0.2));
        m.set(Property::sheen, f(0.2));
        sphere(m)
    };
    let mut expected = Preview::new(&device, &queue).expect("the preview can be made");
    expected.set_scene(&device, &queue, &colored(0.9, 0.77));
    let expected = expected.render(&device, &queue, SIDE, SIDE, 4).expect("the preview draws");

    let mut preview = Preview::new(&device, &queue).expect("the preview can be made");
    preview.set_scene(&device, &queue, &colored(0.1, 0.0));
    preview.render(&device, &queue, SIDE, SIDE, 1).expect("the preview draws");
    // A value that changes faster than its tables can be filled.
    for i in 0..8 {
        preview.set_scene(&device, &queue, &colored(0.1 * f64::from(i), 0.1 * f64::from(i)));
        assert!(preview.error().is_none(), "{:?}", preview.error());
    }
    preview.set_scene(&device, &queue, &colored(0.9, 0.77));
    let found = preview.render(&device, &queue, SIDE, SIDE, 4).expect("the preview draws");
    assert!(!preview.is_settling());
    let furthest = found.iter().flatten().zip(expected.iter().flatten()).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(furthest < 1e-6, "{furthest}");
}
