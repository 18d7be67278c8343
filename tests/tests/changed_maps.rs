//! Does a texture that is inverted, or scaled and shifted, show what a file with such values shows, in the final view and in both of the
//! preview's ways to draw?

use burnish_assets::Image;
use burnish_material::{Channel, Kind, Material, Property, TextureRef};
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

/// What becomes of the values of an image.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Change {
    Inverted,
    Scaled,
    Both,
}

const CHANGES: [Change; 3] = [Change::Inverted, Change::Scaled, Change::Both];
const SCALE: [f32; 3] = [0.5, 0.25, 0.75];
const BIAS: [f32; 3] = [0.375, 0.5, 0.125];

impl Change {
    fn of(self, kind: Kind, texel: [f32; 3]) -> [f32; 3] {
        std::array::from_fn(|k| {
            let is_turned = self != Self::Scaled && (kind != Kind::Normal || k == 1);
            let x = if is_turned { 1.0 - texel[k] } else { texel[k] };
            if self == Self::Inverted || kind == Kind::Normal { x } else { SCALE[k] * x + BIAS[k] }
        })
    }

    /// Whether a map of directions stays what it is.
    fn is_idle(self, property: Property) -> bool {
        self == Self::Scaled && property.def().default.kind() == Kind::Normal
    }
}

/// Waves, far from symmetric about one half.
fn waves(change: impl Fn([f32; 3]) -> [f32; 3]) -> Image {
    let texels = (0..64 * 64).map(|k| {
        let (x, y) = ((k % 64) as f32 / 64.0, (k / 64) as f32 / 64.0);
        let wave = 0.5 + 0.5 * (std::f32::consts::TAU * (2.0 * x + y)).sin();
        let [r, g, b] = change([0.4 * wave * wave, 0.5 + 0.4 * wave, 0.9]);
        [r, g, b, 1.0]
    });
    Image { width: 64, height: 64, texels: texels.collect(), is_eight_bit: false }
}

/// The ball of the stability suite under soft light with a map.
fn ball(material: &Material, property: Property, image: Image, change: Option<Change>) -> Scene {
    let mut material = material.clone();
    // One channel: the mean of three would round otherwise than the mean of three turned over.
    let channel = if property.def().default.kind() == Kind::Float { Channel::R } else { Channel::Rgb };
    let mut reference = TextureRef { channel, ..TextureRef::new("waves") };
    reference.is_inverted = matches!(change, Some(Change::Inverted | Change::Both));
    if matches!(change, Some(Change::Scaled | Change::Both)) {
        (reference.scale, reference.bias) = (SCALE.map(f64::from), BIAS.map(f64::from));
    }
    material.slot_mut(property).texture = Some(reference);
    let mut scene = suite().swap_remove(0).scene;
    scene.environment = environment(&[4.0, 3.0, 1.5, 0.8, 0.3, 0.2, 0.4, 0.6]);
    for object in &mut scene.objects {
        object.material = Arc::new(material.clone());
        object.textures = Arc::new(TextureSet::from([("waves".to_owned(), Arc::new(image.clone()))]));
    }
    scene
}

/// Stored as is.
fn plain(property: Property, material: &Material) -> Scene {
    ball(material, property, waves(|x| x), None)
}

/// Changed by the reference; changed in the image.
fn changed(property: Property, material: &Material, change: Change) -> [Scene; 2] {
    let image = waves(|texel| change.of(property.def().default.kind(), texel));
    [ball(material, property, waves(|x| x), Some(change)), ball(material, property, image, None)]
}

/// Mean difference over all channels relative to the mean of the first.
fn apart(a: &[[f32; 3]], b: &[[f32; 3]]) -> f64 {
    let pairs = || a.iter().flatten().zip(b.iter().flatten()).map(|(x, y)| (f64::from(*x), f64::from(*y)));
    pairs().map(|(x, y)| (x - y).abs()).sum::<f64>() / pairs().map(|(x, _)| x).sum::<f64>()
}

/// Compares pictures of all cases: the change in the reference and in the image within `tolerance`, and far from the plain one.
fn compare(tolerance: f64, mut draw: impl FnMut(&Scene) -> Vec<[f32; 3]>) {
    for (property, material) in cases() {
        let plain = draw(&plain(property, &material));
        for change in CHANGES {
            let [by_reference, in_image] = changed(property, &material, change).map(|scene| draw(&scene));
            let (same, other) = (apart(&by_reference, &in_image), apart(&by_reference, &plain));
            let name = property.def().name;
            eprintln!("{name}, {change:?}: {same:.6} from the changed image, {other:.3} from the plain one");
            assert!(same < tolerance, "{name}, {change:?}: {same}");
            assert!(if change.is_idle(property) { other == 0.0 } else { other > 0.01 }, "{name}, {change:?}: {other}");
        }
    }
}

#[test]
fn the_final_view_changes_values() {
    compare(1e-4, |scene| final_picture(scene, SIDE, 8));
}

#[test]
fn the_preview_changes_values() {
    let Some((device, queue)) = device() else { return };
    let mut preview = Preview::new(&device, &queue).expect("the preview can be made");
    for (has_rays, frames) in [(false, 4), (true, 12)] {
        preview.set_rays(has_rays);
        println!("rays {has_rays}");
        compare(1e-3, |scene| {
            preview.set_scene(&device, &queue, scene);
            let pixels = preview.render(&device, &queue, SIDE as u32, SIDE as u32, frames).expect("the preview draws");
            pixels.iter().map(|[r, g, b, _]| [*r, *g, *b]).collect()
        });
    }
}
