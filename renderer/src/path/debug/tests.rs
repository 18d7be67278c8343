//! Facts of the encodings, and pictures whose result is known.

use super::super::tests::{environment, object, scene, sphere};
use super::*;
use crate::denoise::Input;
use crate::path::REPLICATES;
use burnish_assets::Image;
use burnish_material::{Material, Property as P, TextureRef, Value, Value::Color as Rgb, Value::Float};
use glam::Vec3;
use std::sync::Arc;

const SIZE: usize = 33;
const MIDDLE: usize = SIZE / 2 * SIZE + SIZE / 2;

/// A ball seen along -z from 3 units, with an image of some property, if any.
fn ball(values: &[(P, Value)], map: Option<(P, [[f32; 3]; 2])>) -> Prepared {
    let mut material = Material::named("test");
    for (property, value) in values {
        material.set(*property, *value);
    }
    let mut ball = object(sphere(1.0, 32), Arc::new(material.clone()));
    if let Some((property, [left, right])) = map {
        let texels = (0..64 * 4).map(|i| if i % 64 < 32 { left } else { right }).map(|[r, g, b]| [r, g, b, 1.0]).collect();
        let image = Arc::new(Image { width: 64, height: 4, texels, is_eight_bit: false });
        material.slot_mut(property).texture = Some(TextureRef::new("map"));
        ball.material = Arc::new(material);
        ball.textures = Arc::new([("map".to_owned(), image)].into());
    }
    let mut scene = scene(vec![ball], environment(|_, _| 1.0));
    scene.camera.origin = Vec3::new(0.0, 0.0, 3.0);
    Prepared::new(&scene, None)
}

fn picture(prepared: &Prepared, view: DebugView) -> Vec<Color> {
    let pixels = debug_picture(prepared, view, (SIZE, SIZE), 2, &DebugProgress::default()).unwrap();
    assert_eq!(pixels.len(), SIZE * SIZE);
    assert!(pixels.iter().flatten().all(|c| (0.0..=1.0).contains(c)), "{view:?}");
    assert_eq!(pixels[0], [0.0; 3], "{view:?}: the environment is black");
    let alone = debug_picture(prepared, view, (SIZE, SIZE), 1, &DebugProgress::default()).unwrap();
    assert!(pixels == alone, "{view:?}: threads change nothing");
    pixels
}

fn is_near(a: Color, b: Color, tolerance: f32) -> bool {
    (0..3).all(|k| (a[k] - b[k]).abs() <= tolerance)
}

#[test]
fn lists_are_in_order_and_legends_differ() {
    assert!(DebugView::ALL.iter().all(|def| def.view.def().view == def.view));
    assert!(SampleView::ALL.iter().all(|def| def.view.def().view == def.view));
    let words: Vec<_> = DebugView::ALL.iter().map(|d| d.word).chain(SampleView::ALL.iter().map(|d| d.word)).collect();
    assert!(words.iter().enumerate().all(|(i, word)| !words[..i].contains(word)));
    let legends = DebugView::ALL.iter().map(|d| d.view.legend()).chain(SampleView::ALL.iter().map(|d| d.view.legend()));
    for legend in legends {
        for (i, (name, color)) in legend.iter().enumerate() {
            assert!(color.iter().all(|c| (0.0..=1.0).contains(c)));
            assert!(legend[..i].iter().all(|(n, c)| n != name && !is_near(*c, *color, 0.01)), "{name}");
        }
    }
}

#[test]
fn encodings_are_as_described() {
    let prepared = ball(&[(P::base_color, Rgb([0.8, 0.3, 0.1]))], None);
    assert!(is_near(picture(&prepared, DebugView::Albedo)[MIDDLE], [0.8, 0.3, 0.1], 1e-6));
    assert!(is_near(picture(&prepared, DebugView::Normal)[MIDDLE], [0.5, 0.5, 1.0], 0.02));
    // To the right of the picture the normal has more x, above more y.
    let normals = picture(&prepared, DebugView::Normal);
    assert!(normals[MIDDLE + 8][0] > 0.65 && normals[MIDDLE - 8 * SIZE][1] > 0.65);
    let depth = picture(&prepared, DebugView::Depth);
    assert!(is_near(depth[MIDDLE], [1.0; 3], 1e-3) && depth[MIDDLE + 10][0] < 0.95);
    // v is 0.5 along the equator; u grows to the right, and the square changes eight times per unit.
    let uv = picture(&prepared, DebugView::Uv);
    assert!((uv[MIDDLE][1] - 0.5).abs() < 0.03 && uv[MIDDLE + 8][0] > uv[MIDDLE + 2][0]);
    assert_eq!(
        [checker([0.01, 0.01])[2], checker([0.13, 0.01])[2], checker([0.13, 0.13])[2], checker([-0.01, 0.01])[2]],
        [0.8, 0.1, 0.8, 0.1]
    );
    assert_eq!(checker([f32::NAN, 0.0])[0], 0.0);
    // A normal map tilts the shading normal towards +u.
    let tilted = ball(&[], Some((P::normal, [[0.8, 0.5, 0.9]; 2])));
    assert!(is_near(picture(&tilted, DebugView::Normal)[MIDDLE], [0.8, 0.5, 0.9], 0.03));
}

#[test]
fn the_strongest_lobe_is_shown() {
    let color_of =
        |lobe: Lobe| DebugView::Lobes.legend().into_iter().find(|(name, _)| *name == lobe.def().name).map(|(_, color)| color);
    let shown = |values: &[(P, Value)]| Some(picture(&ball(values, None), DebugView::Lobes)[MIDDLE]);
    let metal = [(P::metallic, Float(1.0)), (P::roughness, Float(0.0))];
    assert_eq!(shown(&metal), color_of(Lobe::metal));
    assert_eq!(shown(&[(P::base_color, Rgb([0.7; 3]))]), color_of(Lobe::diffuse));
    assert_eq!(shown(&[(P::base_color, Rgb([0.0; 3]))]), color_of(Lobe::specular));
    assert_eq!(
        shown(&[(P::base_color, Rgb([0.0; 3])), (P::coat, Float(1.0)), (P::specular_level, Float(0.0))]),
        color_of(Lobe::coat)
    );
    assert_eq!(shown(&[(P::translucency, Float(1.0))]), color_of(Lobe::transmission));
    assert_eq!(shown(&[(P::base_color, Rgb([0.0; 3])), (P::specular_level, Float(0.0))]), Some(NO_LOBE));
    // Plastic turns into a mirror at grazing angles.
    let plastic = ball(&[(P::base_color, Rgb([0.3; 3]))], None);
    let row: Vec<_> = picture(&plastic, DebugView::Lobes).into_iter().map(Some).collect();
    assert_eq!(row[MIDDLE], color_of(Lobe::diffuse));
    assert!(row.contains(&color_of(Lobe::specular)));
}

#[test]
fn lobes_at_work_follow_images() {
    let legend = DebugView::Overdraw.legend();
    let count = |values: &[(P, Value)]| {
        let color = picture(&ball(values, None), DebugView::Overdraw)[MIDDLE];
        legend.iter().position(|(_, c)| *c == color)
    };
    assert_eq!(count(&[(P::metallic, Float(1.0)), (P::roughness, Float(0.0))]), Some(1));
    assert_eq!(count(&[]), Some(2));
    assert_eq!(count(&[(P::coat, Float(1.0)), (P::sheen, Float(0.5))]), Some(4));
    // Textures with metal and its further scattering on one side, with specular and diffuse reflection on the other.
    let halves = picture(&ball(&[], Some((P::metallic, [[1.0; 3], [0.0; 3]]))), DebugView::Overdraw);
    let counts: Vec<_> = [MIDDLE - 5, MIDDLE + 5].map(|i| legend.iter().position(|(_, c)| *c == halves[i])).to_vec();
    assert!(counts == [Some(3), Some(3)], "{counts:?}");
    let coated = picture(&ball(&[], Some((P::coat, [[1.0; 3], [0.0; 3]]))), DebugView::Overdraw);
    let counts = [MIDDLE - 5, MIDDLE + 5].map(|i| legend.iter().position(|(_, c)| *c == coated[i]).unwrap_or(99));
    // The left half of the image begins at the front and goes round to the right.
    assert_eq!(counts, [3, 4]);
}

/// Directional albedos of all pixels that show a surface.
fn albedos(prepared: &Prepared, is_white: bool) -> Vec<f32> {
    let camera = View::new(prepared, SIZE, SIZE);
    let direction = |i: usize| camera.basis.direction((i % SIZE) as f32 / SIZE as f32, (i / SIZE) as f32 / SIZE as f32);
    let seen = |i: usize| {
        let hit = prepared.geometry.bvh.closest(&Ray::new(camera.basis.origin, direction(i)));
        (!hit.is_miss()).then(|| Seen::new(prepared, &hit, direction(i), 0.0))
    };
    let albedo = |s: Seen<'_>| brightest(albedo::total(&if is_white { s.whitened() } else { s }, FURNACE_SAMPLES));
    (0..SIZE * SIZE).filter_map(seen).map(albedo).collect()
}

#[test]
fn the_furnace_keeps_energy() {
    let white = (P::base_color, Rgb([1.0; 3]));
    let conserving: [&[(P, Value)]; 5] = [
        &[white, (P::metallic, Float(1.0)), (P::roughness, Float(0.7))],
        &[white, (P::metallic, Float(1.0)), (P::roughness, Float(0.0))],
        &[white, (P::roughness, Float(1.0)), (P::specular_level, Float(0.0))],
        &[white, (P::roughness, Float(0.4))],
        &[(P::translucency, Float(1.0)), (P::roughness, Float(0.5))],
    ];
    for values in conserving {
        let albedos = albedos(&ball(values, None), false);
        assert!(albedos.len() > 100);
        let mean = albedos.iter().sum::<f32>() / albedos.len() as f32;
        assert!((mean - 1.0).abs() < 2e-3, "{values:?}: {mean}");
        // Two per cent of the pixels may be further off, at the rim of glass some more.
        let far = albedos.iter().filter(|a| (**a - 1.0).abs() > 0.01).count();
        let share = if values.iter().any(|(property, _)| *property == P::translucency) { 10 } else { 50 };
        assert!(far * share < albedos.len(), "{values:?}: {far} of {}", albedos.len());
        assert!(albedos.iter().all(|a| (a - 1.0).abs() < 0.02), "{values:?}");
    }
    // A coloured one loses its colour, but not in the white furnace.
    let gold = ball(&[(P::base_color, Rgb([0.5, 0.4, 0.1])), (P::metallic, Float(1.0)), (P::roughness, Float(0.3))], None);
    assert!(albedos(&gold, false)[100] < 0.7);
    assert!((albedos(&gold, true)[100] - 1.0).abs() < 0.01);
    let pixels = [DebugView::Furnace, DebugView::WhiteFurnace].map(|view| picture(&gold, view)[MIDDLE]);
    assert!(pixels[0][2] > 2.0 * pixels[0][0] && is_near(pixels[1], [MIDDLE_GREY; 3], 0.08), "{pixels:?}");
    assert!(furnace_color(1.05)[0] > 0.7 && furnace_color(1.05)[2] < 0.1);
}

#[test]
fn samples_are_coloured_by_count_and_error() {
    let flat = |x: f32| [[x; 3]; REPLICATES];
    let noisy = [[1.1; 3], [0.9; 3], [1.1; 3], [0.9; 3]];
    let input = Input { width: 4, height: 1, replicates: vec![flat(1.0), noisy, flat(0.0), flat(2.0)] };
    let counts = sample_picture(SampleView::Count, &input, &[4, 8, 16, 4]);
    assert_eq!(counts.len(), 4);
    assert!(
        counts[2][0] > counts[2][2] && counts[0][2] > counts[0][0] && is_near(counts[1], counts[1].map(|_| counts[1][0]), 0.01)
    );
    let errors = sample_picture(SampleView::Error, &input, &[]);
    assert_eq!(errors[0], colors::ramp(0.0));
    // Variance of the mean: 0.04 / 12.
    let expected = (0.04f32 / 12.0 / 1.01).sqrt().log10() / 3.0 + 1.0;
    assert!(is_near(errors[1], colors::ramp(expected), 1e-4), "{errors:?} {expected}");
    assert!(sample_picture(SampleView::Error, &Input::default(), &[]).is_empty());
}
