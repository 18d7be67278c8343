//! Pictures in PNG, JPEG, Radiance HDR and OpenEXR files.

use std::io::Cursor;
use std::path::Path;

use exr::image::{AnyChannel, FlatSamples};
use exr::meta::MetaData;
use exr::prelude::{ReadChannels, ReadLayers};
use image::{DynamicImage, ImageDecoder, ImageError, ImageFormat, ImageReader, Limits};

use super::AssetError;
use crate::image::Image;

/// Larger pictures are refused, in one direction and in all.
const MAX_SIDE: usize = 16384;
const MAX_TEXELS: usize = 256 << 20;

/// What decoded layers of one EXR file may take together.
const MAX_EXR_BYTES: usize = 6 << 30;

/// Reads PNG, JPEG and HDR; which one it is, the contents say.
pub(super) fn read_common(file: &Path, bytes: &[u8]) -> Result<Image, AssetError> {
    let reader = ImageReader::new(Cursor::new(bytes));
    let mut reader = reader.with_guessed_format().map_err(|problem| AssetError::unreadable(file, problem))?;
    if !matches!(reader.format(), Some(ImageFormat::Png | ImageFormat::Jpeg | ImageFormat::Hdr)) {
        return Err(AssetError::malformed(file, "contents", "expected a PNG, JPEG or HDR picture, found something else"));
    }
    // Decoders fill what is missing with grey and say nothing.
    if reader.format() == Some(ImageFormat::Jpeg) && !is_jpeg_whole(bytes) {
        return Err(AssetError::truncated(file, "contents", "expected the end of the picture, found the end of the file"));
    }
    // The size is checked before anything is decoded; what remains of the limits bounds the decoder's own buffers.
    let mut limits = Limits::no_limits();
    limits.max_alloc = Some(8 << 30);
    reader.limits(limits);
    let decoder = reader.into_decoder().map_err(|problem| common_error(file, problem))?;
    let (width, height) = decoder.dimensions();
    check_size(file, width as usize, height as usize)?;
    let decoded = DynamicImage::from_decoder(decoder).map_err(|problem| common_error(file, problem))?;

    let is_eight_bit = matches!(
        decoded,
        DynamicImage::ImageLuma8(_) | DynamicImage::ImageLumaA8(_) | DynamicImage::ImageRgb8(_) | DynamicImage::ImageRgba8(_)
    );
    let (width, height) = (width as usize, height as usize);
    let texels = match decoded {
        DynamicImage::ImageRgba8(pixels) => pixels.pixels().map(|p| p.0.map(|x| f32::from(x) / 255.0)).collect(),
        DynamicImage::ImageRgb8(pixels) => {
            let opaque = |p: &image::Rgb<u8>| [p.0[0], p.0[1], p.0[2], 255].map(|x| f32::from(x) / 255.0);
            pixels.pixels().map(opaque).collect()
        }
        DynamicImage::ImageRgb32F(pixels) => pixels.pixels().map(|p| [p.0[0], p.0[1], p.0[2], 1.0]).collect(),
        // The rest is rare enough for a second copy.
        other => other.into_rgba32f().pixels().map(|p| p.0).collect(),
    };
    Ok(Image { width, height, texels, is_eight_bit })
}

/// Whether an end-of-image marker comes after the last scan begins. Neither marker occurs within the data of a scan (ITU T.81, B.1.1.5).
fn is_jpeg_whole(bytes: &[u8]) -> bool {
    let last = |marker: u8| bytes.windows(2).rposition(|pair| pair == [0xff, marker]);
    last(0xd9) > last(0xda)
}

fn common_error(file: &Path, problem: ImageError) -> AssetError {
    match problem {
        ImageError::Limits(_) => AssetError::too_large(file, "expected a picture that fits into memory, found a larger one"),
        ImageError::Unsupported(problem) => AssetError::unsupported(file, "contents", one_line(&problem)),
        ImageError::IoError(problem) if problem.kind() == std::io::ErrorKind::UnexpectedEof => {
            AssetError::truncated(file, "contents", "expected more bytes, found the end of the file")
        }
        problem => AssetError::malformed(file, "contents", one_line(&problem)),
    }
}

/// The message of a decoder as part of a sentence.
fn one_line(problem: &dyn std::fmt::Display) -> String {
    let text = problem.to_string();
    let words: Vec<&str> = text.split_whitespace().collect();
    format!("expected a valid picture: {}", words.join(" ").trim_end_matches('.'))
}

fn check_size(file: &Path, width: usize, height: usize) -> Result<(), AssetError> {
    if width == 0 || height == 0 {
        return Err(AssetError::Empty { file: file.to_owned(), expected: "at least one texel" });
    }
    if width > MAX_SIDE || height > MAX_SIDE || width * height > MAX_TEXELS {
        let problem = format!("expected at most {MAX_SIDE} x {MAX_SIDE} texels, found {width} x {height}");
        return Err(AssetError::too_large(file, problem));
    }
    Ok(())
}

/// Reads red, green, blue and alpha, or luminance, of the first layer in an OpenEXR file that has them.
pub(super) fn read_exr(file: &Path, bytes: &[u8]) -> Result<Image, AssetError> {
    check_exr_headers(file, bytes)?;
    let decoded = exr::image::read::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .all_layers()
        .all_attributes()
        .from_buffered(Cursor::new(bytes))
        .map_err(|problem| exr_error(file, problem))?;
    for layer in &decoded.layer_data {
        let (width, height) = (layer.size.width(), layer.size.height());
        let channels = &layer.channel_data.list;
        let Some(chosen) = choose_channels(channels) else { continue };
        if let Some(channel) = chosen.iter().flatten().find(|channel| channel.sampling != exr::math::Vec2(1, 1)) {
            let problem = "a channel at reduced resolution is not supported; expected full resolution";
            return Err(AssetError::unsupported(file, format!("channel {}", channel.name), problem));
        }
        let mut texels = vec![[0.0, 0.0, 0.0, 1.0]; width * height];
        for (c, channel) in chosen.iter().enumerate() {
            let Some(channel) = channel else { continue };
            match &channel.sample_data {
                FlatSamples::F16(samples) => fill(&mut texels, c, samples.iter().map(|x| x.to_f32())),
                FlatSamples::F32(samples) => fill(&mut texels, c, samples.iter().copied()),
                FlatSamples::U32(samples) => fill(&mut texels, c, samples.iter().map(|&x| x as f32)),
            }
        }
        return Ok(Image { width, height, texels, is_eight_bit: false });
    }
    Err(AssetError::unsupported(file, "channels", "expected R, G and B, or Y, found other channels"))
}

/// Refuses what is too large or of a kind that is not read, before anything is decoded.
fn check_exr_headers(file: &Path, bytes: &[u8]) -> Result<(), AssetError> {
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(|problem| exr_error(file, problem))?;
    let mut needed = 0_usize;
    for header in &meta.headers {
        if header.deep {
            return Err(AssetError::unsupported(file, "header", "deep data are not supported; expected a flat picture"));
        }
        check_size(file, header.layer_size.width(), header.layer_size.height())?;
        let texels = header.layer_size.area();
        for channel in &header.channels.list {
            needed = needed.saturating_add(texels.saturating_mul(channel.sample_type.bytes_per_sample()));
        }
    }
    if needed > MAX_EXR_BYTES {
        let problem = format!("expected layers of at most {MAX_EXR_BYTES} bytes, found {needed}");
        return Err(AssetError::too_large(file, problem));
    }
    Ok(())
}

fn exr_error(file: &Path, problem: exr::error::Error) -> AssetError {
    match problem {
        exr::error::Error::NotSupported(problem) => {
            AssetError::unsupported(file, "contents", format!("expected a flat picture: {problem}"))
        }
        exr::error::Error::Io(problem) if problem.kind() == std::io::ErrorKind::UnexpectedEof => {
            AssetError::truncated(file, "contents", "expected more bytes, found the end of the file")
        }
        problem => AssetError::malformed(file, "contents", one_line(&problem)),
    }
}

type Channel = AnyChannel<FlatSamples>;

/// The channels for red, green, blue and alpha; a luminance stands for all three colours.
///
/// Names may carry a layer before the last dot, as `diffuse.R` does; those without one are preferred.
fn choose_channels(channels: &[Channel]) -> Option<[Option<&Channel>; 4]> {
    let split = |channel: &Channel| -> (String, String) {
        let name = channel.name.to_string();
        match name.rsplit_once('.') {
            Some((layer, last)) => (layer.to_owned(), last.to_owned()),
            None => (String::new(), name),
        }
    };
    let mut layers: Vec<String> = channels.iter().map(|channel| split(channel).0).collect();
    layers.sort();
    layers.dedup();
    let find = |layer: &str, names: &[&str]| {
        channels.iter().find(|channel| {
            let (own, last) = split(channel);
            own == layer && names.iter().any(|name| last.eq_ignore_ascii_case(name))
        })
    };
    for layer in &layers {
        let alpha = find(layer, &["A"]);
        let colour = [find(layer, &["R", "red"]), find(layer, &["G", "green"]), find(layer, &["B", "blue"])];
        if let [Some(r), Some(g), Some(b)] = colour {
            return Some([Some(r), Some(g), Some(b), alpha]);
        }
        if let Some(y) = find(layer, &["Y", "L"]) {
            return Some([Some(y), Some(y), Some(y), alpha]);
        }
    }
    None
}

fn fill(texels: &mut [[f32; 4]], channel: usize, samples: impl Iterator<Item = f32>) {
    for (texel, sample) in texels.iter_mut().zip(samples) {
        texel[channel] = sample;
    }
}
