//! Pictures as PNG.

use super::{JOB_ATTRIBUTE, Layer, Picture};
use burnish_renderer::tonemap::Display;
use png::text_metadata::ITXtChunk;
use png::{BitDepth, ColorType, Compression, Encoder, SrgbRenderingIntent};

/// The picture as PNG. With alpha, colours are not multiplied by it, as PNG wants.
pub fn png_bytes(picture: &Picture, display: Display) -> Result<Vec<u8>, String> {
    let is_fine = picture.precision.is_sixteen_bit;
    if !picture.has_alpha {
        let values = picture.pixels.iter().flat_map(|[r, g, b, _]| display.apply([*r, *g, *b]));
        return encode([picture.width, picture.height], is_fine, ColorType::Rgb, &stored(values, is_fine), picture.job.as_ref());
    }
    let values = picture.pixels.iter().flat_map(|[r, g, b, coverage]| {
        let alpha = if coverage.is_finite() { coverage.clamp(0.0, 1.0) } else { 1.0 };
        let unmultiplied = if alpha > 0.0 { [r, g, b].map(|x| x / alpha) } else { [0.0; 3] };
        let [r, g, b] = display.apply(unmultiplied);
        [r, g, b, alpha]
    });
    encode([picture.width, picture.height], is_fine, ColorType::Rgba, &stored(values, is_fine), picture.job.as_ref())
}

/// An image of 8 bits per channel as PNG: `rgba` as it is to be stored, row by row from the top, four bytes a pixel.
pub fn rgba_png(width: usize, height: usize, rgba: &[u8]) -> Result<Vec<u8>, String> {
    encode([width, height], false, ColorType::Rgba, rgba, None)
}

/// A layer of the picture, made visible.
pub(super) fn layer_bytes(picture: &Picture, layer: &Layer, display: Display) -> Result<Vec<u8>, String> {
    let values = layer.shown(display).flatten();
    let is_fine = picture.precision.is_sixteen_bit;
    encode([picture.width, picture.height], is_fine, ColorType::Rgb, &stored(values, is_fine), None)
}

/// Values in `[0, 1]` as one byte or two each.
fn stored(values: impl Iterator<Item = f32>, is_fine: bool) -> Vec<u8> {
    // What is not a number is stored as 0.
    let rounded = |x: f32, most: f32| x.clamp(0.0, 1.0) * most + 0.5;
    if is_fine {
        values.flat_map(|x| (rounded(x, 65_535.0) as u16).to_be_bytes()).collect()
    } else {
        values.map(|x| rounded(x, 255.0) as u8).collect()
    }
}

fn encode(
    [width, height]: [usize; 2],
    is_fine: bool,
    color: ColorType,
    bytes: &[u8],
    job: Option<&serde_json::Value>,
) -> Result<Vec<u8>, String> {
    let side = |pixels: usize| u32::try_from(pixels).map_err(|_| format!("{pixels} pixels are more than PNG can hold"));
    let mut file = Vec::new();
    let mut encoder = Encoder::new(&mut file, side(width)?, side(height)?);
    encoder.set_color(color);
    encoder.set_depth(if is_fine { BitDepth::Sixteen } else { BitDepth::Eight });
    encoder.set_compression(Compression::Fast);
    encoder.set_source_srgb(SrgbRenderingIntent::Perceptual);
    let failed = |error: png::EncodingError| error.to_string();
    let mut writer = encoder.write_header().map_err(failed)?;
    if let Some(job) = job {
        let mut chunk = ITXtChunk::new(JOB_ATTRIBUTE, job.to_string());
        chunk.compressed = true;
        writer.write_text_chunk(&chunk).map_err(failed)?;
    }
    writer.write_image_data(bytes).map_err(failed)?;
    writer.finish().map_err(failed)?;
    Ok(file)
}
