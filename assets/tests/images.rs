//! Do loaders of images and environments read what is stored, and refuse the rest with a sentence?

use std::path::{Path, PathBuf};

use burnish_assets::{AssetError, is_environment_path, is_image_path, load_environment, load_image};
use exr::prelude::*;
use image::{ImageBuffer, Luma, Rgb, Rgba};

fn folder() -> tempfile::TempDir {
    tempfile::tempdir().expect("a temporary folder")
}

/// Channels of 4 x 2 texels, whose value is the texel's number plus 100 times the channel's.
fn write_exr(path: &Path, layer: Option<&str>, names: &[&str]) {
    let channel = |(k, name): (usize, &&str)| {
        let samples: Vec<f32> = (0..8).map(|texel| (texel + 100 * k) as f32).collect();
        AnyChannel::new(*name, FlatSamples::F32(samples))
    };
    let channels = AnyChannels::sort(names.iter().enumerate().map(channel).collect());
    let attributes = layer.map_or_else(LayerAttributes::default, LayerAttributes::named);
    let layer = Layer::new((4, 2), attributes, Encoding::FAST_LOSSLESS, channels);
    Image::from_layer(layer).write().to_file(path).expect("a temporary file");
}

#[test]
fn exr_channels() {
    let folder = folder();
    let path = folder.path().join("a.exr");
    let cases: [(Option<&str>, &[&str], [f32; 4]); 6] = [
        (None, &["R", "G", "B"], [3.0, 103.0, 203.0, 1.0]),
        (Some("beauty"), &["R", "G", "B", "A"], [3.0, 103.0, 203.0, 303.0]),
        (None, &["B", "A", "G", "R"], [303.0, 203.0, 3.0, 103.0]),
        (None, &["diffuse.R", "diffuse.G", "diffuse.B", "depth.Z"], [3.0, 103.0, 203.0, 1.0]),
        (None, &["a.R", "a.G", "a.B", "R", "G", "B"], [303.0, 403.0, 503.0, 1.0]),
        (None, &["Y"], [3.0, 3.0, 3.0, 1.0]),
    ];
    for (layer, names, expected) in cases {
        write_exr(&path, layer, names);
        let image = load_image(&path).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!((image.width, image.height, image.is_eight_bit), (4, 2, false), "{names:?}");
        assert_eq!(image.texels[3], expected, "{names:?}");
    }
    write_exr(&path, None, &["Z"]);
    assert!(matches!(load_image(&path), Err(AssetError::Unsupported { .. })));
}

#[test]
fn half_floats_are_exact() {
    let folder = folder();
    let path = folder.path().join("half.exr");
    let channel = |name| AnyChannel::new(name, FlatSamples::F16(vec![f16::from_f32(0.333); 8]));
    let channels = AnyChannels::sort(["R", "G", "B"].into_iter().map(channel).collect());
    let layer = Layer::new((4, 2), LayerAttributes::default(), Encoding::SMALL_LOSSLESS, channels);
    Image::from_layer(layer).write().to_file(&path).expect("a temporary file");
    let (environment, warnings) = load_environment(&path).expect("a good file");
    assert!(warnings.is_empty() && environment.name == "half");
    assert_eq!(environment.texels, vec![[f16::from_f32(0.333).to_f32(); 3]; 8]);
}

#[test]
fn strange_environments_cost_a_warning() {
    let folder = folder();
    let path = folder.path().join("odd.exr");
    let samples = vec![1.0, f32::NAN, -1.0, f32::INFINITY, 5.0, 0.0, 2.0, 2.0, 2.0];
    let channel = |name| AnyChannel::new(name, FlatSamples::F32(samples.clone()));
    let channels = AnyChannels::sort(["R", "G", "B"].into_iter().map(channel).collect());
    let layer = Layer::new((3, 3), LayerAttributes::default(), Encoding::UNCOMPRESSED, channels);
    Image::from_layer(layer).write().to_file(&path).expect("a temporary file");
    let (environment, warnings) = load_environment(&path).expect("a good file");
    let reds: Vec<f32> = environment.texels.iter().map(|t| t[0]).collect();
    assert_eq!(reds, [1.0, 0.0, 0.0, 0.0, 5.0, 0.0, 2.0, 2.0, 2.0]);
    assert_eq!(warnings.len(), 2, "{warnings:?}");
    assert!(warnings[0].contains("3 x 3") && warnings[1].contains("3 of 9"), "{warnings:?}");
}

#[test]
fn common_formats() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    let eight: ImageBuffer<Rgba<u8>, _> = ImageBuffer::from_fn(3, 2, |x, y| Rgba([51 * x as u8, 255, y as u8, 128]));
    eight.save(at("a.png")).expect("a temporary file");
    let image = load_image(&at("a.png")).expect("a good file");
    assert_eq!((image.width, image.height, image.is_eight_bit), (3, 2, true));
    assert_eq!(image.texels[1], [0.2, 1.0, 0.0, 128.0 / 255.0]);

    let sixteen: ImageBuffer<Luma<u16>, _> = ImageBuffer::from_pixel(2, 1, Luma([13107_u16]));
    sixteen.save(at("b.PNG")).expect("a temporary file");
    let image = load_image(&at("b.PNG")).expect("a good file");
    assert!(!image.is_eight_bit && (image.texels[0][2] - 0.2).abs() < 1e-6 && image.texels[0][3] == 1.0);

    let photo: ImageBuffer<Rgb<u8>, _> = ImageBuffer::from_pixel(16, 16, Rgb([255_u8, 255, 255]));
    photo.save(at("c.jpeg")).expect("a temporary file");
    let image = load_image(&at("c.jpeg")).expect("a good file");
    assert!(image.is_eight_bit && image.texels[5][0] > 0.98);

    let light: ImageBuffer<Rgb<f32>, _> = ImageBuffer::from_pixel(4, 2, Rgb([2.0_f32, 1.0, 0.5]));
    light.save(at("d.hdr")).expect("a temporary file");
    let (environment, warnings) = load_environment(&at("d.hdr")).expect("a good file");
    assert!(warnings.is_empty() && environment.texels[0] == [2.0, 1.0, 0.5], "{:?}", environment.texels[0]);
}

#[test]
fn endings() {
    assert!(is_image_path(Path::new("a/b.PNG")) && is_image_path(Path::new("b.exr")) && !is_image_path(Path::new("png")));
    assert!(is_environment_path(Path::new("a.HDR")) && !is_environment_path(Path::new("a.png")));
    assert!(matches!(load_environment(Path::new("a.png")), Err(AssetError::UnknownFormat { .. })));
    let message = load_image(Path::new("absent.png")).expect_err("there is no such file").to_string();
    assert!(message.starts_with("absent.png: expected a readable file"), "{message}");
}

#[test]
fn huge_pictures_are_refused_by_their_header() {
    let folder = folder();
    let path = folder.path().join("huge.hdr");
    std::fs::write(&path, "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 100000 +X 200000\n").expect("a temporary file");
    assert!(matches!(load_image(&path), Err(AssetError::TooLarge { .. })));
}

#[test]
fn damaged_pictures_do_not_panic() {
    let folder = folder();
    let at = |name: &str| -> PathBuf { folder.path().join(name) };
    write_exr(&at("a.exr"), Some("x"), &["R", "G", "B", "A"]);
    let photo: ImageBuffer<Rgb<u8>, _> = ImageBuffer::from_fn(20, 20, |x, y| Rgb([x as u8 * 9, y as u8 * 7, 99]));
    let light: ImageBuffer<Rgb<f32>, _> = ImageBuffer::from_fn(20, 10, |x, y| Rgb([x as f32, y as f32, 0.5]));
    photo.save(at("b.png")).expect("a temporary file");
    photo.save(at("c.jpg")).expect("a temporary file");
    light.save(at("d.hdr")).expect("a temporary file");
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    let mut below = |end: usize| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state % end as u64) as usize
    };
    for name in ["a.exr", "b.png", "c.jpg", "d.hdr"] {
        let whole = std::fs::read(at(name)).expect("just written");
        let path = at(&format!("damaged.{}", name.rsplit('.').next().unwrap_or_default()));
        for length in (0..whole.len()).step_by((whole.len() / 50).max(1)) {
            std::fs::write(&path, &whole[..length]).expect("a temporary file");
            let read = load_image(&path);
            // What follows the last row may be missing.
            assert!(read.is_err() || length * 10 > whole.len() * 9, "{name}: {length} of {} bytes", whole.len());
            if let Err(error) = read {
                let message = error.to_string();
                assert!(message.contains("damaged") && message.ends_with('.') && !message.contains('\n'), "{message}");
            }
        }
        for _ in 0..400 {
            let mut bytes = whole.clone();
            for _ in 0..=below(3) {
                let place = below(bytes.len());
                bytes[place] = below(256) as u8;
            }
            std::fs::write(&path, &bytes).expect("a temporary file");
            if let Ok(image) = load_image(&path) {
                assert_eq!(image.texels.len(), image.width * image.height);
            }
        }
    }
}
