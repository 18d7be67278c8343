//! How each small picture is made.

use super::{MAX_SIDE, Thumbnail};
use burnish_assets::{Environment, Image, make_environment, make_shape};
use burnish_material::{Channel, Material, Property, Value};
use burnish_renderer::path::{Prepared, Settings, StopReason, StopRules, render_prepared};
use burnish_renderer::scene::{EnvironmentLight, ModelMeshes, Scene};
use burnish_renderer::tonemap::{Display, srgb_decode, srgb_encode};
use std::sync::Arc;
use std::time::Instant;

/// Columns and rows of pictures of meshes.
const SHAPE_SIZE: [usize; 2] = [96, 72];
/// Columns and rows of pictures of environments.
const ENVIRONMENT_SIZE: [usize; 2] = [144, 72];
/// Samples per pixel of what the path tracer draws.
const SPP: u32 = 64;
/// Random stream.
const SEED: u64 = 7;

/// An image, at most `side` pixels along its longer side: means over areas, of linear values, encoded to sRGB.
///
/// Images of 8 bits are taken to be sRGB, so that what is stored is what is shown; others are linear. One channel is shown as grey; of alpha,
/// which is never encoded, the stored number. Values beyond 0 to 1 are clamped, those that are not finite are black. `None` if the image is
/// empty or `is_stopped` says so.
pub fn image_thumbnail(image: &Image, channel: Channel, side: usize, is_stopped: &dyn Fn() -> bool) -> Option<Thumbnail> {
    let longer = image.width.max(image.height);
    let side = side.clamp(1, MAX_SIDE).min(longer);
    let scaled = |n: usize| ((n * side + longer / 2) / longer.max(1)).max(1);
    let decode = |x: f32| {
        let x = if x.is_finite() { x.clamp(0.0, 1.0) } else { 0.0 };
        if image.is_eight_bit { srgb_decode(x) } else { x }
    };
    let read = |x: usize, y: usize| {
        let [r, g, b, a] = image.texels.get(y * image.width + x).copied().unwrap_or_default();
        match channel {
            Channel::Rgb => [r, g, b].map(decode),
            Channel::R => [decode(r); 3],
            Channel::G => [decode(g); 3],
            Channel::B => [decode(b); 3],
            Channel::A => [if a.is_finite() { a.clamp(0.0, 1.0) } else { 0.0 }; 3],
        }
    };
    let size = [scaled(image.width), scaled(image.height)];
    let pixels = shrink([image.width, image.height], size, read, is_stopped)?;
    let encode = |x: f32| if channel == Channel::A { x } else { srgb_encode(x) };
    Some(thumbnail(size, &pixels, |pixel| pixel.map(|x| (encode(x).clamp(0.0, 1.0) * 255.0 + 0.5) as u8)))
}

/// An environment's map in 144 by 72 pixels, tone mapped as views are at first. `None` if it is empty.
pub fn environment_thumbnail(environment: &Environment) -> Option<Thumbnail> {
    let read = |x: usize, y: usize| environment.texels.get(y * environment.width + x).copied().unwrap_or_default();
    let pixels = shrink([environment.width, environment.height], ENVIRONMENT_SIZE, read, &|| false)?;
    Some(thumbnail(ENVIRONMENT_SIZE, &pixels, |radiance| Display::default().apply_u8(radiance)))
}

/// A scene as the final view draws it with few samples, in columns and rows of at most [`MAX_SIDE`], tone mapped as views are at first.
///
/// What the scene shares with `last` is taken from there; it becomes that scene. `None` if `is_stopped` says so, which is asked between passes.
pub fn scene_thumbnail(
    scene: &Scene,
    [width, height]: [usize; 2],
    last: &mut Option<Prepared>,
    is_stopped: &dyn Fn() -> bool,
) -> Option<Thumbnail> {
    let start = Instant::now();
    let prepared = &*last.insert(Prepared::new(scene, last.as_ref()));
    let stop = StopRules { spp: Some(SPP), ..StopRules::default() };
    let size = [width, height].map(|n| n.clamp(1, MAX_SIDE));
    // One thread: what is edited comes first.
    let settings = Settings { width: size[0], height: size[1], seed: SEED, threads: 1, stop, is_adaptive: false };
    let rendering = render_prepared(prepared, &settings, start, &mut |_| !is_stopped());
    let is_whole = rendering.stop_reason != StopReason::Cancelled;
    is_whole.then(|| thumbnail(size, &rendering.film.mean(), |radiance| Display::default().apply_u8(radiance)))
}

/// A built-in mesh in grey clay.
pub(super) fn shape_thumbnail(
    name: &str,
    studio: &mut Option<Arc<Environment>>,
    last: &mut Option<Prepared>,
    is_stopped: &dyn Fn() -> bool,
) -> Option<Thumbnail> {
    let mut clay = Material::named("clay");
    clay.set(Property::base_color, Value::Color([0.2; 3]));
    clay.set(Property::roughness, Value::Float(0.7));
    scene_thumbnail(&shape_scene(name, clay, studio)?, SHAPE_SIZE, last, is_stopped)
}

/// A built-in mesh in the studio, which is made where it is not there yet.
pub(super) fn shape_scene(name: &str, material: Material, studio: &mut Option<Arc<Environment>>) -> Option<Scene> {
    let model: ModelMeshes = make_shape(name)?.into();
    let map = match studio {
        Some(map) => map.clone(),
        None => studio.insert(Arc::new(make_environment("studio")?)).clone(),
    };
    let light = EnvironmentLight { map, rotation_deg: 0.0, scale: 1.0 };
    Some(Scene::of_model(&model, Arc::new(material), Arc::default(), light, model.unit_mm))
}

/// Means over the areas that the pixels of another size cover. `None` for an empty picture or if it was stopped between rows.
fn shrink(
    [from_width, from_height]: [usize; 2],
    [width, height]: [usize; 2],
    read: impl Fn(usize, usize) -> [f32; 3],
    is_stopped: &dyn Fn() -> bool,
) -> Option<Vec<[f32; 3]>> {
    if from_width == 0 || from_height == 0 {
        return None;
    }
    let columns: Vec<Vec<(usize, f64)>> = (0..width).map(|x| covered(x, from_width, width)).collect();
    let mut pixels = Vec::with_capacity(width * height);
    for y in 0..height {
        let mut sums = vec![[0.0_f64; 3]; width];
        for (row, row_weight) in covered(y, from_height, height) {
            if is_stopped() {
                return None;
            }
            for (sum, column) in sums.iter_mut().zip(&columns) {
                for (x, weight) in column {
                    let texel = read(*x, row);
                    (0..3).for_each(|c| sum[c] += f64::from(texel[c]) * weight * row_weight);
                }
            }
        }
        pixels.extend(sums.into_iter().map(|sum| sum.map(|x| x as f32)));
    }
    Some(pixels)
}

/// The texels of `from` that pixel `at` of `to` covers, each with its share of the pixel.
fn covered(at: usize, from: usize, to: usize) -> Vec<(usize, f64)> {
    // In units of 1 / to of a texel, so that all borders are whole numbers.
    let (start, end) = (at * from, (at + 1) * from);
    let share = |texel: usize| (end.min((texel + 1) * to) - start.max(texel * to)) as f64 / from as f64;
    (start / to..end.div_ceil(to)).map(|texel| (texel, share(texel))).collect()
}

fn thumbnail([width, height]: [usize; 2], pixels: &[[f32; 3]], show: impl Fn([f32; 3]) -> [u8; 3]) -> Thumbnail {
    let bytes = |pixel: &[f32; 3]| {
        let [r, g, b] = show(*pixel);
        [r, g, b, 255]
    };
    Thumbnail { width: width as u32, height: height as u32, rgba: pixels.iter().flat_map(bytes).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(width: usize, height: usize, is_eight_bit: bool, f: impl Fn(usize, usize) -> [f32; 4]) -> Image {
        let texels = (0..width * height).map(|k| f(k % width, k / width)).collect();
        Image { width, height, texels, is_eight_bit }
    }

    fn shown(image: &Image, channel: Channel, side: usize) -> Thumbnail {
        image_thumbnail(image, channel, side, &|| false).expect("the image is not empty")
    }

    #[test]
    fn a_red_image_has_a_red_thumbnail() {
        for is_eight_bit in [false, true] {
            let red = shown(&image(37, 19, is_eight_bit, |_, _| [1.0, 0.0, 0.0, 0.5]), Channel::Rgb, 16);
            assert_eq!((red.width, red.height, red.rgba.len()), (16, 8, 16 * 8 * 4));
            assert!(red.rgba.chunks(4).all(|p| p == [255, 0, 0, 255]));
        }
    }

    #[test]
    fn sizes_keep_the_shape_and_never_grow() {
        for (width, height, side, expected) in
            [(64, 32, 16, (16, 8)), (3, 2, 64, (3, 2)), (1000, 1, 10, (10, 1)), (5, 5, 0, (1, 1)), (7, 14, 7, (4, 7))]
        {
            let made = shown(&image(width, height, true, |_, _| [0.5; 4]), Channel::Rgb, side);
            assert_eq!((made.width, made.height), expected);
            assert!(made.rgba.chunks(4).all(|p| p[0].abs_diff(128) <= 1), "{:?}", &made.rgba[..4]);
        }
    }

    #[test]
    fn channels_are_grey_and_means_are_linear() {
        let of = |channel, is_eight_bit| {
            shown(&image(2, 2, is_eight_bit, |x, _| [x as f32, 0.25, 0.5, 0.75]), channel, 1).rgba[..3].to_vec()
        };
        // Half of the light is 188 of 255 in sRGB.
        assert_eq!(of(Channel::R, true), [188; 3]);
        assert_eq!(of(Channel::R, false), [188; 3]);
        assert_eq!(of(Channel::G, true), [64; 3]);
        assert_eq!(of(Channel::G, false), [137; 3]);
        assert_eq!(of(Channel::A, true), [191; 3]);
        assert_eq!(of(Channel::A, false), [191; 3]);
    }

    #[test]
    fn odd_images_give_pictures_or_nothing() {
        let odd = image(3, 1, false, |x, _| [f32::NAN, f32::INFINITY, [-5.0, 9.0, 1.0][x], f32::NAN]);
        assert_eq!(shown(&odd, Channel::Rgb, 3).rgba, [0, 0, 0, 255, 0, 0, 255, 255, 0, 0, 255, 255]);
        assert!(shown(&odd, Channel::A, 3).rgba.chunks(4).all(|p| p == [0, 0, 0, 255]));
        assert!(image_thumbnail(&image(0, 0, true, |_, _| [0.0; 4]), Channel::Rgb, 8, &|| false).is_none());
        assert!(image_thumbnail(&odd, Channel::Rgb, 8, &|| true).is_none());
        // Fewer texels than the size says.
        let short = Image { width: 4, height: 4, texels: vec![[1.0; 4]; 4], is_eight_bit: true };
        assert_eq!(shown(&short, Channel::Rgb, 4).rgba.len(), 64);
    }

    #[test]
    fn every_texel_is_counted_once() {
        for (from, to) in [(16, 4), (13, 7), (3, 8), (1, 5), (5, 1), (100, 99)] {
            let mut shares = vec![0.0; from];
            for at in 0..to {
                let all = covered(at, from, to);
                assert!((all.iter().map(|(_, share)| share).sum::<f64>() - 1.0).abs() < 1e-12, "{at} of {from} to {to}");
                all.iter().for_each(|(texel, share)| shares[*texel] += share);
            }
            assert!(shares.iter().all(|share| (share - to as f64 / from as f64).abs() < 1e-12), "{from} to {to}");
        }
    }
}
