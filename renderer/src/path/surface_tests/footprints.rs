//! How finely images are read, and what is made anew when something changes.

use super::super::frame::{Frame, span};
use super::super::sampler::MAX_LANES;
use super::super::tests::sphere;
use super::super::tests::{average, picture, scene};
use super::super::{Film, Prepared, render_pass};
use super::{checker, coarse, geometry, hills, image, matt, plane, textured, white_room};
use crate::bvh::Hit;
use crate::scene::{Object, Scene};
use crate::vector::V3;
use burnish_material::{Material, Property, Value};
use glam::{Mat2, Vec2, Vec3, Vec4};
use std::sync::Arc;

/// A scene that looks down on a plane from a height.
fn from_above(object: Object, height: f32, fov_deg: f32) -> Scene {
    let mut scene = scene(vec![object], white_room());
    scene.camera.origin = Vec3::new(0.0, height, 0.0);
    scene.camera.up = Vec3::NEG_Z;
    scene.camera.fov_deg = fov_deg;
    scene
}

#[test]
fn a_far_checker_is_its_mean_at_one_sample() {
    let far = |height: f32| {
        let object = textured(plane(Mat2::IDENTITY * 4.0, Vec2::ZERO, 1), &matt(&[]), &[(Property::base_color, checker(64))]);
        // The picture shows a part of the plane whatever the height.
        let fov = 2.0 * (0.5 / height).atan().to_degrees();
        let mut scene = from_above(object, height, fov);
        scene.max_bounces = 0;
        (picture(&scene, 16, &[1], 1).0, scene)
    };
    // 16 pixels over 1 unit with 4 * 64 squares of the checker: 16 squares in a pixel.
    let (film, _) = far(10.0);
    let features = |film: &Film| film.mean().iter().map(|c| c[1]).collect::<Vec<_>>();
    let (low, high) = features(&film).iter().fold((f32::MAX, 0.0f32), |(l, h), x| (l.min(*x), h.max(*x)));
    assert!(high / low < 1.04, "{low} to {high}");
    // Read at the finest level, samples fall on single squares.
    let (_, scene) = far(10.0);
    let mut prepared = Prepared::new(&scene, None);
    prepared.has_images = false;
    let mut film = Film::new(16, 16);
    render_pass(&prepared, &mut film, 1, 7, 1, &|| false).expect("nothing cancels");
    let (low, high) = features(&film).iter().fold((f32::MAX, 0.0f32), |(l, h), x| (l.min(*x), h.max(*x)));
    assert!(high / low > 2.0, "{low} to {high}");
}

#[test]
fn footprints_do_not_change_the_mean() {
    // Two planes at a right angle light each other; the camera sees both, slanted.
    let map = image(128, 64, |x, y| [if (x / 3 + y / 5) % 2 == 0 { 0.85 } else { 0.15 }; 3]);
    let make = || {
        let floor = textured(plane(Mat2::IDENTITY * 3.0, Vec2::ZERO, 1), &matt(&[]), &[(Property::base_color, map.clone())]);
        let mut wall = plane(Mat2::IDENTITY * 3.0, Vec2::ZERO, 1);
        wall.positions.iter_mut().for_each(|p| *p = Vec3::new(p.x, -p.z, -1.0));
        wall.normals.iter_mut().for_each(|n| *n = Vec3::Z);
        wall.tangents.iter_mut().for_each(|t| *t = Vec4::new(1.0, 0.0, 0.0, 1.0));
        let metal = [(Property::metallic, Value::Float(1.0)), (Property::roughness, Value::Float(0.4))];
        let wall = textured(wall, &metal, &[(Property::base_color, map.clone())]);
        let mut scene = scene(vec![floor, wall], white_room());
        scene.camera.origin = Vec3::new(0.3, 1.2, 3.0);
        scene
    };
    let render = |is_fine: bool, seed: u64| {
        let mut prepared = Prepared::new(&make(), None);
        prepared.has_images &= !is_fine;
        let mut film = Film::new(24, 24);
        render_pass(&prepared, &mut film, 64, seed, 2, &|| false).expect("nothing cancels");
        average(&film)
    };
    let differences: Vec<f64> = (0..12).map(|seed| render(false, seed) - render(true, seed + 100)).collect();
    let mean = differences.iter().sum::<f64>() / 12.0;
    let error = (differences.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / 11.0 / 12.0).sqrt();
    assert!(error < 2e-3, "{error}");
    assert!(mean.abs() < 3.5 * error + 1e-3 * render(true, 1), "{mean} with error {error}");
}

#[test]
fn the_first_triangle_tells_the_length_in_uv() {
    let object = textured(plane(Mat2::from_diagonal(Vec2::new(4.0, 1.0)), Vec2::ZERO, 1), &[], &[]);
    let g = geometry(&object);
    let hits = [Hit { triangle: 0, ..Hit::MISS }; MAX_LANES];
    let span = span::<f32>(&g, &hits);
    // 4 by 1 repetitions in a unit of area: 2 along a side on average.
    assert!((span.uv_length(g.scale as f32) - 2.0).abs() < 1e-5);
    let frame = Frame::along(V3::new(0.0, 1.0, 0.0), (V3::new(1.0, 0.0, 0.0), 1.0));
    let [along, across] = span.slopes(&frame, [1.0, 0.0]);
    assert!((along * g.scale as f32 - 4.0).abs() < 1e-4 && across.abs() < 1e-4);
}

#[test]
fn maps_do_not_rebuild_what_they_do_not_touch() {
    let make = |roughness: f64, scale: f64| {
        let values = [(Property::roughness, Value::Float(roughness)), (Property::height_scale, Value::Float(scale))];
        textured(coarse(sphere(1.0, 8)), &values, &[(Property::height, hills()), (Property::base_color, checker(8))])
    };
    let mut scene = scene(vec![make(0.5, 0.1)], white_room());
    let change = |scene: &mut Scene, edit: &dyn Fn(&mut Material)| {
        let mut material = (*scene.objects[0].material).clone();
        edit(&mut material);
        scene.objects[0].material = Arc::new(material);
    };
    let mut last = Prepared::new(&scene, None);
    let mut is_kept = |scene: &Scene| {
        let next = Prepared::new(scene, Some(&last));
        let is_kept = Arc::ptr_eq(&next.geometry, &last.geometry);
        last = next;
        is_kept
    };
    change(&mut scene, &|m| _ = m.set(Property::roughness, Value::Float(0.7)));
    assert!(is_kept(&scene), "roughness");
    change(&mut scene, &|m| _ = m.set(Property::combine_normal_and_height, Value::Bool(true)));
    assert!(is_kept(&scene), "how maps combine");
    change(&mut scene, &|m| _ = m.set(Property::height_scale, Value::Float(0.2)));
    assert!(!is_kept(&scene), "scale");
    change(&mut scene, &|m| _ = m.set(Property::height_level, Value::Float(0.4)));
    assert!(!is_kept(&scene), "level");
    scene.objects[0].length_scale = 2.0;
    assert!(!is_kept(&scene), "length");
    let wider = |m: &mut Material| {
        let texture = m.slot_mut(Property::height).texture.as_mut();
        texture.expect("it was set").uv_scale = [2.0, 2.0];
    };
    change(&mut scene, &wider);
    assert!(!is_kept(&scene), "placement");
    let mut textures = (*scene.objects[0].textures).clone();
    textures.insert("base_color".to_owned(), checker(16));
    scene.objects[0].textures = Arc::new(textures.clone());
    assert!(is_kept(&scene), "another image");
    textures.insert("height".to_owned(), hills());
    scene.objects[0].textures = Arc::new(textures);
    assert!(!is_kept(&scene), "another height map");
    change(&mut scene, &|m| _ = m.slot_mut(Property::height).texture.take());
    assert!(!is_kept(&scene), "no height map");
    change(&mut scene, &|m| _ = m.set(Property::height_scale, Value::Float(0.9)));
    assert!(!is_kept(&scene), "the uniform height differs from the level");
    change(&mut scene, &|m| _ = m.set(Property::height_level, Value::Float(0.5)));
    assert!(!is_kept(&scene), "flat again");
    change(&mut scene, &|m| _ = m.set(Property::height_scale, Value::Float(0.1)));
    assert!(is_kept(&scene), "no height, no matter");
}
