//! Does an inverted texture show what a file with turned over values shows, in the final view and in both of the preview's ways to draw?

use burnish_assets::Image;
use burnish_material::{Channel, Kind, Material, Property, TextureRef, Value};
use burnish_renderer::preview::Preview;
use burnish_renderer::scene::{Scene, TextureSet};
use burnish_renderer::stability::suite;
use burnish_tests::gpu::device;
use burnish_tests::materials::{c, f, material};
use burnish_tests::scenes::{environment, final_picture};
use std::sync::Arc;

/// Pixels along each side.
const SIDE: usize = 24;

/// Materials on which a map of the property shows.
fn cases() -> Vec<(Property, Material)> {
    use Property::*;
    let metal = [(metallic, f(1.0)), (base_color, c(0.9, 0.6, 0.3)), (roughness, f(0.4))];
    vec![
        (base_color, material(&[])),
        (roughness, material(&metal)),
        (opacity, material(&[(base_color, c(0.2, 0.6, 0.3))])),
        (normal, material(&metal)),
        (coat_normal, material(&[(coat, f(1.0)), (coat_roughness, f(0.2)), (base_color, c(0.0, 0.0, 0.0))])),
        (height, material(&[(height_scale, f(0.15))])),
        (anisotropy_rotation, material(&[metal.as_slice(), &[(anisotropy, f(0.8))]].concat())),
        (emission_color, material(&[(emission, f(0.7))])),
    ]
}

/// Waves, far from symmetric about one half.
fn waves(turn: impl Fn([f32; 3]) -> [f32; 3]) -> Image {
    let texels = (0..64 * 64).map(|k| {
        let (x, y) = ((k % 64) as f32 / 64.0, (k / 64) as f32 / 64.0);
        let wave = 0.5 + 0.5 * (std::f32::consts::TAU * (2.0 * x + y)).sin();
        let [r, g, b] = turn([0.4 * wave * wave, 0.5 + 0.4 * wave, 0.9]);
        [r, g, b, 1.0]
    });
    Image { width: 64, height: 64, texels: texels.collect(), is_eight_bit: false }
}

/// The ball of the stability suite under soft light with a map.
fn ball(material: &Material, property: Property, image: Image, is_inverted: bool) -> Scene {
    let mut material = material.clone();
    // One channel: the mean of three would round otherwise than the mean of three turned over.
    let channel = if property.def().default.kind() == Kind::Float { Channel::R } else { Channel::Rgb };
    material.slot_mut(property).texture = Some(TextureRef { is_inverted, channel, ..TextureRef::new("waves") });
    let mut scene = suite().swap_remove(0).scene;
    scene.environment = environment(&[4.0, 3.0, 1.5, 0.8, 0.3, 0.2, 0.4, 0.6]);
    for object in &mut scene.objects {
        object.material = Arc::new(material.clone());
        object.textures = Arc::new(TextureSet::from([("waves".to_owned(), Arc::new(image.clone()))]));
    }
    scene
}

/// Stored as is and inverted by the reference; turned over in the image; stored as is.
fn scenes(property: Property, material: &Material) -> [Scene; 3] {
    let turned = waves(|[r, g, b]| match property.def().default {
        Value::Normal(_) => [r, 1.0 - g, b],
        _ => [1.0 - r, 1.0 - g, 1.0 - b],
    });
    [
        ball(material, property, waves(|x| x), true),
        ball(material, property, turned, false),
        ball(material, property, waves(|x| x), false),
    ]
}

/// Mean difference over all channels relative to the mean of the first.
fn apart(a: &[[f32; 3]], b: &[[f32; 3]]) -> f64 {
    let pairs = || a.iter().flatten().zip(b.iter().flatten()).map(|(x, y)| (f64::from(*x), f64::from(*y)));
    pairs().map(|(x, y)| (x - y).abs()).sum::<f64>() / pairs().map(|(x, _)| x).sum::<f64>()
}

#[test]
fn the_final_view_inverts() {
    for (property, material) in cases() {
        let [inverted, turned, plain] = scenes(property, &material).map(|scene| final_picture(&scene, SIDE, 8));
        let (same, other) = (apart(&inverted, &turned), apart(&inverted, &plain));
        println!("{}: {same:.6} from the turned over image, {other:.3} from the plain one", property.def().name);
        assert!(same < 1e-4, "{}: {same}", property.def().name);
        assert!(other > 0.01, "{}: {other}", property.def().name);
    }
}

#[test]
fn the_preview_inverts() {
    let Some((device, queue)) = device() else { return };
    let mut preview = Preview::new(&device, &queue).expect("the preview can be made");
    for (has_rays, frames) in [(false, 4), (true, 12)] {
        preview.set_rays(has_rays);
        for (property, material) in cases() {
            let [inverted, turned, plain] = scenes(property, &material).map(|scene| {
                preview.set_scene(&device, &queue, &scene);
                let pixels = preview.render(&device, &queue, SIDE as u32, SIDE as u32, frames).expect("the preview draws");
                pixels.iter().map(|[r, g, b, _]| [*r, *g, *b]).collect::<Vec<_>>()
            });
            let (same, other) = (apart(&inverted, &turned), apart(&inverted, &plain));
            println!("{}, rays {has_rays}: {same:.6} and {other:.3} apart", property.def().name);
            assert!(same < 1e-3, "{}: {same}", property.def().name);
            assert!(other > 0.01, "{}: {other}", property.def().name);
        }
    }
}
