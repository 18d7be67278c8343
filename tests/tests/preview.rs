//! Does the live preview keep the energy of white materials, and does it draw what was set last?

use burnish_assets::make_shape;
use burnish_material::{Material, PROPERTIES, Property, TextureRef, Value};
use burnish_renderer::preview::Preview;
use burnish_renderer::scene::{ModelMeshes, Scene, TextureSet};
use burnish_renderer::tonemap::Display;
use burnish_tests::gpu::device;
use burnish_tests::materials::{c, f, material};
use burnish_tests::scenes::{environment, final_picture};
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

#[test]
fn heights_move_the_outline_as_in_the_final_view() {
    use Property::*;
    let Some((device, queue)) = device() else { return };
    let side = 48;
    // A lamp in the dark: what is lit is its outline.
    let lamp = |values: &[(Property, Value)], map: Option<burnish_assets::Image>| {
        let mut m = material(&[(emission, f(1.0)), (specular_level, f(0.0))]);
        for (property, value) in values {
            m.set(*property, *value);
        }
        let mut textures = TextureSet::new();
        if let Some(map) = map {
            m.slot_mut(height).texture = Some(TextureRef::new("map"));
            textures.insert("map".to_owned(), Arc::new(map));
        }
        let mut scene = sphere(m);
        scene.environment.scale = 0.0;
        scene.objects.iter_mut().for_each(|object| object.textures = Arc::new(textures.clone()));
        scene
    };
    let waves = || {
        let wave = |k: usize| 0.5 + 0.5 * (std::f32::consts::TAU * 6.0 * (k % 128) as f32 / 128.0).sin();
        let texels = (0..128 * 8).map(|k| [wave(k), wave(k), wave(k), 1.0]).collect();
        burnish_assets::Image { width: 128, height: 8, texels, is_eight_bit: false }
    };
    let lit = |pixels: &mut dyn Iterator<Item = f32>| pixels.map(|x| f64::from(x.min(1.0))).sum::<f64>();
    let mut preview = Preview::new(&device, &queue).expect("the preview can be made");
    preview.set_rays(false);
    let mut areas = Vec::new();
    for (name, scene) in [
        ("flat", lamp(&[], None)),
        ("moved", lamp(&[(height, f(1.0)), (height_scale, f(0.3))], None)),
        ("waves", lamp(&[(height_scale, f(0.4))], Some(waves()))),
        ("waves inwards", lamp(&[(height_scale, f(0.4)), (height_level, f(1.0))], Some(waves()))),
    ] {
        preview.set_scene(&device, &queue, &scene);
        let pixels = preview.render(&device, &queue, side, side, 16).expect("the preview draws");
        let drawn = lit(&mut pixels.iter().map(|p| p[1]));
        let expected = lit(&mut final_picture(&scene, side as usize, 64).iter().map(|p| p[1]));
        println!("{name}: {drawn:.1} pixels drawn, {expected:.1} traced");
        assert!((drawn / expected - 1.0).abs() < 0.015, "{name}: {drawn} {expected}");
        areas.push(drawn);
    }
    assert!(areas[1] > 1.1 * areas[0] && areas[3] < 0.95 * areas[2], "{areas:?}");
}

#[test]
fn the_maps_of_the_base_leave_the_coat_alone() {
    use Property::*;
    let Some((device, queue)) = device() else { return };
    let mut preview = Preview::new(&device, &queue).expect("the preview can be made");
    // Black below: what is seen is the coat, and a base that leans cannot show but in it.
    let coated = |values: &[(Property, Value)]| {
        let mut m =
            material(&[(base_color, c(0.0, 0.0, 0.0)), (specular_level, f(0.0)), (coat, f(1.0)), (coat_roughness, f(0.1))]);
        for (property, value) in values {
            m.set(*property, *value);
        }
        let mut scene = sphere(m);
        scene.environment = environment(&[8.0, 2.0, 1.0, 0.5, 0.3, 0.2, 0.1, 0.0]);
        scene
    };
    let lean = Value::Normal([0.6, 0.0, 0.8]);
    for is_traced in [false, true] {
        preview.set_rays(is_traced);
        let mut draw = |values: &[(Property, Value)]| {
            preview.set_scene(&device, &queue, &coated(values));
            preview.render(&device, &queue, SIDE, SIDE, 64).expect("the preview draws")
        };
        let plain = draw(&[]);
        let [leaning, other] = [normal, coat_normal].map(|property| draw(&[(property, lean)]));
        let distance = |a: &[[f32; 4]]| a.iter().zip(&plain).map(|(a, b)| (a[1] - b[1]).abs()).sum::<f32>() / a.len() as f32;
        // The leaning base still shades the coat a little, in the final view as well.
        let [bent, flat] = [&[(normal, lean)][..], &[]].map(|values| final_picture(&coated(values), SIDE as usize, 64));
        let expected = bent.iter().zip(&flat).map(|(a, b)| (a[1] - b[1]).abs()).sum::<f32>() / bent.len() as f32;
        let [found, of_coat] = [distance(&leaning), distance(&other)];
        assert!(
            (found - expected).abs() < 0.1 * of_coat,
            "traced {is_traced}: {found} for {expected}, {of_coat} with the coat's"
        );
    }
}

#[test]
fn bloom_spreads_what_is_brighter_than_white_and_nothing_else() {
    use Property::*;
    let Some((device, queue)) = device() else { return };
    for (strength, is_spread) in [(8.0, true), (0.5, false)] {
        let mut scene = sphere(material(&[(emission, f(strength)), (base_color, c(0.0, 0.0, 0.0)), (specular_level, f(0.0))]));
        scene.environment.scale = 0.1;
        let shown = |has_bloom: bool| {
            let mut preview = Preview::new(&device, &queue).expect("the preview can be made");
            preview.set_rays(false);
            preview.set_scene(&device, &queue, &scene);
            preview.set_bloom(&device, has_bloom).expect("bloom compiles");
            let linear = preview.render(&device, &queue, SIDE, SIDE, 2).expect("the preview draws");
            let view = preview.display_view().expect("something was drawn").texture().clone();
            (linear, read_bytes(&device, &queue, &view))
        };
        let [(plain, without), (same, with)] = [shown(false), shown(true)];
        assert!(plain == same, "the picture itself stays as it is");
        // Just outside of the ball, on its left.
        let beside = ((SIDE / 2) * SIDE + 1) as usize * 4;
        let brighter = i32::from(with[beside]) - i32::from(without[beside]);
        println!("emission {strength}: {} without, {} with bloom", without[beside], with[beside]);
        assert_eq!(brighter > 3, is_spread, "emission {strength}: {brighter}");
        assert!(is_spread || with == without, "nothing is brighter than white");
    }
}

/// The bytes of an `Rgba8Unorm` texture whose rows need no padding.
fn read_bytes(device: &wgpu::Device, queue: &wgpu::Queue, texture: &wgpu::Texture) -> Vec<u8> {
    let row = 256.max(texture.width() * 4);
    let buffer = device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: u64::from(row * texture.height()),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row), rows_per_image: None };
    let to = wgpu::TexelCopyBufferInfo { buffer: &buffer, layout };
    encoder.copy_texture_to_buffer(texture.as_image_copy(), to, texture.size());
    queue.submit([encoder.finish()]);
    buffer.slice(..).map_async(wgpu::MapMode::Read, |result| result.expect("a buffer made for reading can be mapped"));
    device.poll(wgpu::PollType::wait_indefinitely()).expect("the device is alive");
    let mapped = buffer.slice(..).get_mapped_range().expect("mapping has finished");
    mapped.chunks_exact(row as usize).flat_map(|line| line[..texture.width() as usize * 4].to_vec()).collect()
}

#[test]
fn a_dragged_value_is_shown_within_a_few_frames() {
    // Two where nothing else runs; tables are filled on a thread, and tests share the cores.
    const MOST: u32 = 4;
    let Some((device, queue)) = device() else { return };
    let mut preview = Preview::new(&device, &queue).expect("the preview can be made");
    let mut late = Vec::new();
    for def in PROPERTIES {
        let mut worst = 0;
        // The first value may bring a lobe in, whose pipeline is compiled while the old one draws on.
        for step in 0..6 {
            let x = 0.2 + 0.1 * f64::from(step);
            let mut m = material(&[(Property::sheen, f(0.3)), (Property::coat, f(0.3)), (Property::translucency, f(0.3))]);
            let value = match def.default {
                Value::Float(_) => f(x),
                Value::Color(_) => c(x, 0.5, 0.4),
                Value::Normal(_) => Value::Normal([0.5 * x, 0.0, 0.9]),
                Value::Bool(_) => Value::Bool(step % 2 == 0),
            };
            m.set(def.id, value);
            preview.set_scene(&device, &queue, &sphere(m));
            let mut frames = 0;
            while frames == 0 || !preview.is_current() && frames < 1000 {
                let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
                preview.draw(&device, &queue, &mut encoder, SIDE, SIDE, Display::default());
                queue.submit([encoder.finish()]);
                device.poll(wgpu::PollType::wait_indefinitely()).expect("the device is alive");
                frames += 1;
            }
            // On and off in turn, a flag brings a lobe in with its second value.
            if step > 1 {
                worst = worst.max(frames);
            }
        }
        println!("{:<26} {worst} frames", def.name);
        if worst > MOST {
            late.push((def.name, worst));
        }
    }
    assert!(late.is_empty(), "{late:?}");
}

#[test]
fn a_small_floor_lights_no_more_than_it_covers() {
    let Some((device, queue)) = device() else { return };
    // Bright above, dark below: what shines from below is the floor.
    let model: ModelMeshes = make_shape("sphere").expect("the sphere is built in").into();
    let matt =
        material(&[(Property::roughness, f(1.0)), (Property::specular_level, f(0.0)), (Property::base_color, c(0.8, 0.8, 0.8))]);
    let light = environment(&[1.0, 1.0, 1.0, 1.0, 0.02, 0.02, 0.02, 0.02]);
    let mut scene = Scene::of_model(&model, Arc::new(matt.clone()), Arc::default(), light, 100.0);
    let bounds = scene.document_bounds();
    // Seen from below its middle, without the floor in the way of the look.
    scene.camera.origin.y = bounds.center().y - 0.3 * bounds.radius();
    let lower = |pixels: &mut dyn Iterator<Item = (f64, bool)>| {
        let (mut sum, mut count) = (0.0, 0.0);
        for (k, (x, is_object)) in pixels.enumerate() {
            if is_object && k / SIDE as usize > SIDE as usize / 2 {
                sum += x;
                count += 1.0;
            }
        }
        sum / f64::max(count, 1.0)
    };
    let mut means = Vec::new();
    for reach in [f32::INFINITY, 2.0 * bounds.radius()] {
        let mut scene = scene.clone();
        for object in scene.objects.iter_mut().filter(|object| !object.is_document) {
            let mut mesh = (*object.mesh).clone();
            let positions = mesh.positions.clone();
            mesh.triangles
                .retain(|t| t.iter().all(|&i| positions[i as usize].x.abs().max(positions[i as usize].z.abs()) <= reach));
            let (mesh, _) = mesh.complete();
            object.mesh = Arc::new(mesh);
            object.material = Arc::new(matt.clone());
        }
        let mut preview = Preview::new(&device, &queue).expect("the preview can be made");
        preview.set_rays(false);
        preview.set_scene(&device, &queue, &scene);
        let drawn = preview.render(&device, &queue, SIDE, SIDE, 4).expect("the preview draws");
        let traced = final_picture(&scene, SIDE as usize, 256);
        let is_object = |k: usize| drawn[k][3] > 0.99 && k / (SIDE as usize) < SIDE as usize * 3 / 4;
        let of = |pixels: Vec<f32>| lower(&mut pixels.into_iter().enumerate().map(|(k, x)| (f64::from(x), is_object(k))));
        let [ours, theirs] = [of(drawn.iter().map(|p| p[1]).collect()), of(traced.iter().map(|p| p[1]).collect())];
        println!("floor to {reach}: {ours:.4} drawn, {theirs:.4} traced");
        means.push((ours, theirs));
    }
    assert!(means.iter().all(|(ours, theirs)| (ours / theirs - 1.0).abs() < 0.07), "{means:?}");
    assert!(means[1].1 < 0.9 * means[0].1, "the small floor makes a difference: {means:?}");
}
