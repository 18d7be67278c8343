//! Does the preview show what the final view shows: rays against paths, every property, every case of the stability suite?

use burnish_material::{Kind, Material, PROPERTIES, Property, TextureRef, Value, Vary};
use burnish_renderer::preview::Preview;
use burnish_renderer::scene::{Scene, TextureSet};
use burnish_renderer::stability::suite;
use burnish_tests::gpu::device;
use burnish_tests::materials::{c, f, material};
use burnish_tests::scenes::{environment, final_picture};
use std::sync::Arc;

/// Pixels along each side.
const SIDE: usize = 24;

/// The ball of the stability suite under soft light, with a material.
fn ball(material: Material, textures: TextureSet) -> Scene {
    let mut scene = suite().swap_remove(0).scene;
    scene.environment = environment(&[4.0, 3.0, 1.5, 0.8, 0.3, 0.2, 0.4, 0.6]);
    scene.max_bounces = 12;
    for object in &mut scene.objects {
        object.material = Arc::new(material.clone());
        object.textures = Arc::new(textures.clone());
    }
    scene
}

fn on(values: &[(Property, Value)]) -> Material {
    material(values)
}

/// A map of waves.
fn waves() -> burnish_assets::Image {
    let texels = (0..64 * 64).map(|k| {
        let (x, y) = ((k % 64) as f32 / 64.0, (k / 64) as f32 / 64.0);
        let wave = 0.5 + 0.5 * (std::f32::consts::TAU * (2.0 * x + y)).sin();
        [wave, 0.3 + 0.4 * wave, 0.9, 1.0]
    });
    burnish_assets::Image { width: 64, height: 64, texels: texels.collect(), is_eight_bit: false }
}

fn with_map(mut material: Material, property: Property) -> (Material, TextureSet) {
    material.slot_mut(property).texture = Some(TextureRef::new("waves"));
    (material, TextureSet::from([("waves".to_owned(), Arc::new(waves()))]))
}

fn inverted((mut material, textures): (Material, TextureSet), property: Property) -> (Material, TextureSet) {
    if let Some(texture) = &mut material.slot_mut(property).texture {
        texture.is_inverted = true;
    }
    (material, textures)
}

/// Means over the four quarters of a picture, three channels each.
fn quarters(pixels: impl Iterator<Item = [f32; 3]>, side: usize) -> [f64; 12] {
    let mut sums = [0.0; 12];
    for (k, pixel) in pixels.enumerate() {
        let quarter = 2 * (k / side * 2 / side) + k % side * 2 / side;
        (0..3).for_each(|c| sums[3 * quarter + c] += f64::from(pixel[c]) * 4.0 / (side * side) as f64);
    }
    sums
}

#[test]
fn rays_go_to_the_final_picture() {
    use Property::*;
    let Some((device, queue)) = device() else { return };
    let metal = [(metallic, f(1.0)), (base_color, c(0.9, 0.6, 0.3)), (roughness, f(0.4))];
    let glass = [(translucency, f(1.0)), (roughness, f(0.0))];
    let plain = |values: &[(Property, Value)]| (on(values), TextureSet::new());
    let cases = [
        ("plastic", plain(&[(base_color, c(0.7, 0.2, 0.1))])),
        ("stretched metal", plain(&[metal.as_slice(), &[(anisotropy, f(0.8)), (anisotropy_rotation, f(0.2))]].concat())),
        ("bent coat", plain(&[(coat, f(1.0)), (coat_roughness, f(0.2)), (coat_normal, Value::Normal([0.3, 0.2, 0.93]))])),
        ("sheen", plain(&[(sheen, f(1.0)), (sheen_color, c(0.9, 0.3, 0.3)), (base_color, c(0.1, 0.05, 0.05))])),
        ("clear glass", plain(&[glass.as_slice(), &[(absorption_color, c(0.2, 0.7, 0.5))]].concat())),
        ("rough glass", plain(&[(translucency, f(1.0)), (roughness, f(0.5))])),
        ("dispersion", plain(&[glass.as_slice(), &[(dispersion, f(8.0))]].concat())),
        (
            "scattering",
            plain(&[
                (translucency, f(1.0)),
                (scatter, Value::Bool(true)),
                (scatter_color, c(0.8, 0.5, 0.3)),
                (scatter_distance, f(0.4)),
                (scatter_red_shift, f(0.3)),
                (roughness, f(0.3)),
            ]),
        ),
        ("cut through", plain(&[(opacity, f(0.4)), (base_color, c(0.2, 0.6, 0.3))])),
        ("lamp", plain(&[(emission, f(0.7)), (emission_color, c(1.0, 0.5, 0.2))])),
        ("colour map", with_map(on(&[]), base_color)),
        ("normal map", with_map(on(&metal), normal)),
        ("inverted roughness map", inverted(with_map(on(&metal), roughness), roughness)),
        ("inverted normal map", inverted(with_map(on(&metal), normal), normal)),
        ("height map", with_map(on(&[(height_scale, f(0.15))]), height)),
    ];
    let mut preview = Preview::new(&device, &queue).expect("the preview can be made");
    let mut failed = false;
    for (name, (material, textures)) in cases {
        let scene = ball(material, textures);
        preview.set_scene(&device, &queue, &scene);
        // From 64 samples on nothing of the drawn picture is left.
        let pixels = preview.render(&device, &queue, SIDE as u32, SIDE as u32, 130).expect("the preview draws");
        assert!(preview.rays_problem().is_none() && preview.ray_samples() >= 128, "{name}: {:?}", preview.rays_problem());
        let found = quarters(pixels.iter().map(|[r, g, b, _]| [*r, *g, *b]), SIDE);
        let expected = quarters(final_picture(&scene, SIDE, 1024).into_iter(), SIDE);
        let furthest = found.iter().zip(&expected).map(|(a, b)| (a / b - 1.0).abs()).fold(0.0, f64::max);
        println!("{name}: {:.2} % apart", 100.0 * furthest);
        failed |= furthest > 0.03;
    }
    assert!(!failed, "see above");
}

/// A material in which the property acts, and two slots that differ in it alone.
fn pair(property: Property) -> [(Material, TextureSet); 2] {
    use Property::*;
    let base: &[(Property, Value)] = match property {
        metallic | specular_edge_color => &[(metallic, f(0.5)), (roughness, f(0.3))],
        anisotropy | anisotropy_rotation => &[(metallic, f(1.0)), (roughness, f(0.3)), (anisotropy, f(0.6))],
        translucency | specular_ior => &[(translucency, f(0.5)), (roughness, f(0.2))],
        dispersion => &[(translucency, f(1.0)), (roughness, f(0.0))],
        absorption_color | absorption_distance | volume_thickness | volume_thickness_scale => {
            &[(translucency, f(1.0)), (absorption_color, c(0.8, 0.3, 0.2)), (absorption_distance, f(0.5))]
        }
        scatter | scatter_color | scatter_distance | scatter_distance_scale | scatter_red_shift | scatter_rayleigh => {
            &[(translucency, f(1.0)), (scatter, Value::Bool(true)), (scatter_color, c(0.7, 0.6, 0.5)), (scatter_distance, f(0.3))]
        }
        coat | coat_color | coat_roughness | coat_ior | coat_specular_level | coat_normal | coat_normal_scale => {
            &[(coat, f(0.8)), (coat_color, c(0.9, 0.7, 0.5)), (coat_normal, Value::Normal([0.3, 0.0, 0.95]))]
        }
        sheen | sheen_color | sheen_roughness => &[(sheen, f(0.8)), (base_color, c(0.1, 0.1, 0.1))],
        emission | emission_color => &[(emission, f(0.5))],
        normal_scale | combine_normal_and_height => &[(normal, Value::Normal([0.4, 0.1, 0.9])), (height_scale, f(0.2))],
        height | height_scale | height_level => &[(height_scale, f(0.2))],
        _ => &[(roughness, f(0.4))],
    };
    let needs_map = match property {
        height_scale | height_level | combine_normal_and_height => Some(height),
        volume_thickness_scale => Some(volume_thickness),
        _ => None,
    };
    let base = match needs_map {
        Some(map) => with_map(on(base), map),
        None => (on(base), TextureSet::new()),
    };
    let def = property.def();
    let changed = |value: Value| {
        let (mut material, textures) = base.clone();
        material.set(property, value);
        (material, textures)
    };
    if def.vary == Vary::TextureOnly {
        return [base.clone(), with_map(base.0.clone(), property)];
    }
    match def.default.kind() {
        Kind::Float => [changed(f(0.25)), changed(f(0.75))],
        Kind::Bool => [changed(Value::Bool(false)), changed(Value::Bool(true))],
        Kind::Color => [changed(c(0.9, 0.5, 0.2)), changed(c(0.3, 0.6, 0.9))],
        Kind::Normal => [changed(Value::Normal([0.4, 0.0, 0.9])), changed(Value::Normal([0.0, 0.4, 0.9]))],
    }
}

/// Mean difference of two pictures relative to the first.
fn change(a: &[[f32; 3]], b: &[[f32; 3]]) -> f64 {
    let sum = |values: &mut dyn Iterator<Item = f32>| values.map(f64::from).sum::<f64>();
    let all = sum(&mut a.iter().flatten().copied());
    sum(&mut a.iter().flatten().zip(b.iter().flatten()).map(|(a, b)| (a - b).abs())) / all.max(1e-9)
}

#[test]
fn no_property_is_dead() {
    use Property::*;
    /// What the drawn picture leaves to the rays.
    const LEFT_TO_RAYS: [Property; 1] = [dispersion];
    let Some((device, queue)) = device() else { return };
    let rgb = |pixels: Vec<[f32; 4]>| pixels.into_iter().map(|[r, g, b, _]| [r, g, b]).collect::<Vec<_>>();
    let mut preview = Preview::new(&device, &queue).expect("the preview can be made");
    let mut failed = Vec::new();
    let side = 16;
    for def in PROPERTIES {
        let scenes = pair(def.id).map(|(material, textures)| ball(material, textures));
        let mut picture = |scene: &Scene, has_rays: bool| {
            preview.set_scene(&device, &queue, scene);
            preview.set_rays(has_rays);
            rgb(preview.render(&device, &queue, side, side, if has_rays { 5 } else { 1 }).expect("the preview draws"))
        };
        let drawn = change(&picture(&scenes[0], false), &picture(&scenes[1], false));
        let traced = change(&picture(&scenes[0], true), &picture(&scenes[1], true));
        let finals = scenes.each_ref().map(|scene| final_picture(scene, side as usize, 16));
        let of_final = change(&finals[0], &finals[1]);
        println!("{:<26} drawn {drawn:.4} with rays {traced:.4} final {of_final:.4}", def.name);
        let is_auxiliary = matches!(def.id, ambient_occlusion | volume_thickness | volume_thickness_scale);
        let is_drawn = drawn > 1e-3 || LEFT_TO_RAYS.contains(&def.id);
        // The final view finds out by itself what these three stand in for.
        let is_final_right = if is_auxiliary { of_final == 0.0 } else { of_final > 1e-3 };
        if !is_drawn || traced <= 1e-3 || !is_final_right {
            failed.push(def.name);
        }
    }
    assert!(failed.is_empty(), "{failed:?}");
}

#[test]
fn the_stability_suite_is_drawn_without_a_hole() {
    let Some((device, queue)) = device() else { return };
    let mut preview = Preview::new(&device, &queue).expect("the preview can be made");
    let side = 8;
    let mut failed = Vec::new();
    // Every third case: the suite varies one property at a time, and a shader is compiled for every new set of lobes.
    for case in suite().into_iter().step_by(3) {
        preview.set_scene(&device, &queue, &case.scene);
        let pixels = match preview.render(&device, &queue, side, side, 3) {
            Ok(pixels) => pixels,
            Err(error) => {
                failed.push(format!("{}: {error}", case.name));
                continue;
            }
        };
        if let Some(error) = preview.error() {
            failed.push(format!("{}: {error}", case.name));
        }
        let truth = final_picture(&case.scene, side as usize, 16);
        // Only where all that is near is bright as well: at an edge it depends on the few samples what a pixel shows.
        let is_bright = |k: usize| {
            let (x, y, n) = (k as isize % side as isize, k as isize / side as isize, side as isize);
            let near = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (x + dx, y + dy)));
            near.filter(|(x, y)| (0..n).contains(x) && (0..n).contains(y))
                .all(|(x, y)| truth[(y * n + x) as usize].iter().any(|c| *c > 0.02))
        };
        let is_bad = |(k, pixel): (usize, &[f32; 4])| {
            let is_number = pixel.iter().all(|x| x.is_finite() && *x >= 0.0);
            // What is not a number is drawn black.
            !is_number || (pixel[..3].iter().all(|x| *x == 0.0) && is_bright(k))
        };
        let bad = pixels.iter().enumerate().filter(|pair| is_bad(*pair)).count();
        if bad > 0 {
            failed.push(format!("{}: {bad} pixels", case.name));
        }
    }
    assert!(failed.is_empty(), "{} cases: {failed:#?}", failed.len());
}

#[test]
fn what_is_left_out_would_not_have_shown() {
    use Property::*;
    use burnish_material::LobeSet;
    let Some((device, queue)) = device() else { return };
    let cases: [&[(Property, Value)]; 5] = [
        &[(base_color, c(0.7, 0.2, 0.1))],
        &[(metallic, f(1.0)), (roughness, f(0.2))],
        &[(translucency, f(1.0)), (roughness, f(0.1))],
        &[(coat, f(1.0)), (sheen, f(0.5))],
        &[(emission, f(1.0)), (roughness, f(0.8))],
    ];
    for values in cases {
        let scene = ball(on(values), TextureSet::new());
        let picture = |more: LobeSet| {
            let mut preview = Preview::new(&device, &queue).expect("the preview can be made");
            preview.set_scene(&device, &queue, &scene);
            preview.set_lobes(more, LobeSet::EMPTY);
            preview.render(&device, &queue, SIDE as u32, SIDE as u32, 2).expect("the preview draws");
            preview.read_linear(&device, &queue).expect("the picture can be read")
        };
        let shown = |pixels: Vec<[f32; 4]>| -> Vec<[f32; 3]> {
            let display = burnish_renderer::tonemap::Display::default();
            pixels.into_iter().map(|[r, g, b, _]| display.apply([r, g, b])).collect()
        };
        let (pruned, full) = (shown(picture(LobeSet::EMPTY)), shown(picture(LobeSet::all())));
        let furthest = pruned.iter().flatten().zip(full.iter().flatten()).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(furthest <= 1.0 / 255.0, "{values:?}: {furthest}");
    }
}
