//! How far the preview is from the final view, for a dozen presets in small pictures. The whole table is made by hand (README).

use burnish::parity::{ParitySettings, compare};
use burnish_assets::make_shape;
use burnish_presets::find;
use burnish_renderer::scene::{EnvironmentLight, ModelMeshes, Scene};
use burnish_renderer::tonemap::Display;
use burnish_tests::gpu::device;
use std::sync::Arc;

/// Presets, and the largest FLIP of the accumulated and of the first picture. The first picture of a software adapter has one place a pixel.
const CASES: [(&str, f64, f64); 12] = [
    ("Moulded plastic, red", OPAQUE, 0.15),
    ("Gold, polished", OPAQUE, 0.25),
    ("Copper, polished", OPAQUE, 0.25),
    ("Aluminium, brushed", OPAQUE, 0.20),
    ("Porcelain, glazed", OPAQUE, 0.15),
    ("Velvet, crimson", OPAQUE, 0.15),
    ("Terracotta", OPAQUE, 0.15),
    ("Candle flame", OPAQUE, 0.20),
    ("Crown glass N-BK7", CLEAR, 0.25),
    ("Frosted glass", CLEAR, 0.25),
    ("Amber", CLEAR, 0.30),
    ("Red wine", CLEAR, 0.30),
];
/// Pixels along each side.
const SIDE: usize = 56;
const OPAQUE: f64 = 0.05;
const CLEAR: f64 = 0.10;
/// Departure of luminance on the object and on the rest: what noise leaves at this size, and rare bright dots behind glass.
const LUMINANCE: [f64; 2] = [0.015, 0.03];

#[test]
fn the_accumulated_preview_is_near_the_final_view() {
    let Some((device, queue)) = device() else { return };
    let model: ModelMeshes = make_shape("shader-ball").expect("the shader ball is built in").into();
    let map = Arc::new((burnish_assets::ENVIRONMENTS[0].make)());
    let mut failed = false;
    for (name, accumulated, first) in CASES {
        let (file, _) = find(name).expect(name).parse().expect(name);
        let light = EnvironmentLight { map: map.clone(), rotation_deg: 0.0, scale: 1.0 };
        let scene = Scene::of_model(&model, Arc::new(file.material().clone()), Arc::default(), light, 100.0);
        // Glass is noisy on both sides.
        let (samples, final_samples) = if accumulated == CLEAR { (256, 768) } else { (80, 192) };
        let (threads, display) = (2, Display::default());
        let settings = ParitySettings { width: SIDE, height: SIDE, samples, final_samples, seed: 3, threads, display };
        let parity = compare(&device, &queue, &scene, &settings, &mut |_| true).expect(name);
        let (found, drawn) = (&parity.accumulated, &parity.first);
        let furthest = found.luminance.iter().flatten().map(|x| (x - 1.0).abs()).fold(0.0, f64::max);
        println!(
            "{name:<24} first {:.3}, accumulated {:.3}, noise {:.3}, luminance {:.2} % off",
            drawn.flip_mean,
            found.flip_mean,
            parity.noise,
            100.0 * furthest
        );
        failed |= found.flip_mean > accumulated || drawn.flip_mean > first;
        failed |= furthest > LUMINANCE[usize::from(accumulated == CLEAR)];
    }
    assert!(!failed, "see above");
}
