//! Pictures as OpenEXR.

use super::{JOB_ATTRIBUTE, Picture};
use exr::prelude::{
    AnyChannel, AnyChannels, Compression, Encoding, FlatSamples, Image, Layer as ExrLayer, LayerAttributes, LineOrder, Text,
    WritableImage, f16,
};
use std::io::Cursor;

/// The picture as EXR with its layers. Colours are multiplied by alpha, as EXR wants.
pub fn exr_bytes(picture: &Picture) -> Result<Vec<u8>, String> {
    let channels = if picture.has_alpha { 4 } else { 3 };
    let is_half = picture.precision.is_half;
    let colors = |prefix: &'static str, pixels: &[[f32; 4]]| {
        let plane = |c: usize| samples(pixels.iter().map(|pixel| pixel[c]), is_half);
        let channel = |(c, name): (usize, &&str)| AnyChannel::new(format!("{prefix}{name}").as_str(), plane(c));
        ["R", "G", "B", "A"].iter().enumerate().take(channels).map(channel).collect::<Vec<_>>()
    };
    let raw = picture.raw.iter().flat_map(|raw| colors("raw.", raw));
    let layers = picture.layers.iter().flat_map(|layer| {
        let is_half = is_half && layer.kind.fits_half();
        let channels = layer.kind.channels().iter().zip(&layer.planes);
        channels.map(move |(name, values)| {
            AnyChannel::new(format!("{}.{name}", layer.name()).as_str(), samples(values.iter().copied(), is_half))
        })
    });
    let channels = AnyChannels::sort(colors("", &picture.pixels).into_iter().chain(raw).chain(layers).collect());

    let mut attributes = LayerAttributes { software_name: Text::new_or_none("Burnish"), ..LayerAttributes::default() };
    // One attribute only: the library keeps others in a map whose order changes from run to run.
    if let Some(job) = picture.job.as_ref().and_then(|job| Text::new_or_none(ascii(&job.to_string()))) {
        attributes.other.insert(Text::from(JOB_ATTRIBUTE), exr::meta::attribute::AttributeValue::Text(job));
    }
    let encoding = Encoding { compression: Compression::ZIP16, line_order: LineOrder::Increasing, ..Encoding::SMALL_LOSSLESS };
    let layer = ExrLayer::new((picture.width, picture.height), attributes, encoding, channels);
    let mut file = Cursor::new(Vec::new());
    Image::from_layer(layer).write().to_buffered(&mut file).map_err(|error| error.to_string())?;
    Ok(file.into_inner())
}

/// Values as floats or halves; what is too large for a half becomes the largest.
fn samples(values: impl Iterator<Item = f32>, is_half: bool) -> FlatSamples {
    let most = f16::MAX.to_f32();
    let half = |x: f32| f16::from_f32(if x.is_finite() { x.clamp(-most, most) } else { x });
    if is_half { FlatSamples::F16(values.map(half).collect()) } else { FlatSamples::F32(values.collect()) }
}

/// JSON with everything beyond ASCII escaped: EXR texts have one byte per character.
fn ascii(json: &str) -> String {
    let mut text = String::with_capacity(json.len());
    for c in json.chars() {
        if c.is_ascii() {
            text.push(c);
        } else {
            text.extend(c.encode_utf16(&mut [0; 2]).iter().map(|unit| format!("\\u{unit:04x}")));
        }
    }
    text
}
