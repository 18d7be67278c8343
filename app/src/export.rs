//! Finished pictures as files: PNG for showing, EXR for working on. A file appears whole or not at all.
//!
//! PNG holds 8 bits of display-referred sRGB; EXR holds linear Rec.709 radiance as 32-bit floats, with further layers
//! as channels `layer.CHANNEL`. Neither holds anything that differs between two runs of the same job, unless its caller writes such things
//! into the job.

use crate::files::{FilesError, save_atomic};
use burnish_renderer::path::ErrorEstimate;
use burnish_renderer::tonemap::{Display, srgb_encode};
use exr::prelude::{
    AnyChannel, AnyChannels, Compression, Encoding, FlatSamples, Image, Layer as ExrLayer, LayerAttributes, LineOrder, Text,
    WritableImage,
};
use image::{ExtendedColorType, ImageEncoder, codecs::png::PngEncoder};
use std::fmt;
use std::io::Cursor;
use std::path::{Path, PathBuf};

/// Name of the EXR attribute that holds [`Picture::job`].
pub const JOB_ATTRIBUTE: &str = "burnish";

/// A finished picture, row by row from the top.
#[derive(Clone, Debug, Default)]
pub struct Picture {
    /// Pixels.
    pub width: usize,
    /// Pixels.
    pub height: usize,
    /// Linear radiance, multiplied by the coverage that stands last.
    pub pixels: Vec<[f32; 4]>,
    /// Whether the coverage is written.
    pub has_alpha: bool,
    /// The picture before it was denoised, if it was: as `pixels`.
    pub raw: Option<Vec<[f32; 4]>>,
    /// What else is known of each pixel.
    pub layers: Vec<Layer>,
    /// What the picture was made from, as JSON.
    pub job: Option<serde_json::Value>,
}

/// Further values per pixel, for compositing and for looking into.
#[derive(Clone, Debug)]
pub struct Layer {
    /// What it holds; also how PNG shows it.
    pub kind: LayerKind,
    /// One plane of `width * height` values per channel of the kind.
    pub planes: Vec<Vec<f32>>,
}

/// Layers that a picture can have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LayerKind {
    /// Linear colour of the surface that is seen first.
    Albedo,
    /// World-space shading normal of that surface; zero where there is none.
    Normal,
    /// Distance to that surface in scene units; not finite or 0 where there is none.
    Depth,
    /// Variance of the pixel's mean.
    Variance,
    /// Samples in the pixel.
    Samples,
}

impl LayerKind {
    /// All kinds with the words that options and files use.
    pub const ALL: [(Self, &'static str); 5] = [
        (Self::Albedo, "albedo"),
        (Self::Normal, "normal"),
        (Self::Depth, "depth"),
        (Self::Variance, "variance"),
        (Self::Samples, "samples"),
    ];

    /// The word that options and files use.
    pub fn word(self) -> &'static str {
        Self::ALL[self as usize].1
    }

    /// The kind that a word means, in any case.
    pub fn from_word(word: &str) -> Option<Self> {
        Self::ALL.iter().find(|(_, text)| text.eq_ignore_ascii_case(word)).map(|(kind, _)| *kind)
    }

    /// Names of the planes, as other programs know them.
    pub fn channels(self) -> &'static [&'static str] {
        match self {
            Self::Albedo | Self::Variance => &["R", "G", "B"],
            Self::Normal => &["X", "Y", "Z"],
            Self::Depth => &["Z"],
            Self::Samples => &["V"],
        }
    }
}

/// Formats of pictures, told by the ending of the name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// 8 bits, display-referred.
    Png,
    /// 32-bit floats, linear.
    Exr,
}

impl Format {
    /// The format that the ending of a path stands for, in any case.
    pub fn of(path: &Path) -> Option<Self> {
        let ending = path.extension()?.to_str()?;
        [(Self::Png, "png"), (Self::Exr, "exr")]
            .into_iter()
            .find(|(_, word)| word.eq_ignore_ascii_case(ending))
            .map(|(format, _)| format)
    }
}

/// Why a picture could not be written; shown to the user as one sentence.
#[derive(Debug)]
pub enum ExportError {
    /// The ending of the name is that of no format.
    UnknownFormat {
        /// The file.
        path: PathBuf,
    },
    /// The encoder refused.
    Encode {
        /// The file.
        path: PathBuf,
        /// What the encoder said.
        problem: String,
    },
    /// The bytes could not be written.
    Write(FilesError),
}

impl fmt::Display for ExportError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::UnknownFormat { path } => write!(f, "{}: expected a file name that ends in .png or .exr", path.display()),
            Self::Encode { path, problem } => write!(f, "{}: cannot be written: {problem}", path.display()),
            Self::Write(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for ExportError {}

/// What a job says about how far its picture is: samples per pixel, the rule that ended it (`None`: it was not ended), and its error.
pub fn reached(spp: u32, stop_reason: Option<&str>, error: Option<&ErrorEstimate>) -> serde_json::Map<String, serde_json::Value> {
    let values = [
        ("spp", spp.into()),
        ("stop_reason", stop_reason.into()),
        ("relmse_estimate", error.map(|error| error.relmse).into()),
        ("relmse_low", error.map(|error| error.low).into()),
        ("relmse_high", error.map(|error| error.high).into()),
        ("is_firefly_limited", error.map(|error| error.is_firefly_limited).into()),
    ];
    values.into_iter().map(|(key, value)| (key.to_owned(), value)).collect()
}

/// Writes a picture; the ending of the name tells the format.
///
/// PNG has no layers: each goes to a file of its own beside it, `NAME.albedo.png`; so does the raw picture of a denoised one, `NAME.raw.png`,
/// which EXR holds as `raw.R` and so on. All are encoded before the first is
/// written. Returns the files, the picture first.
pub fn write(path: &Path, picture: &Picture, display: Display) -> Result<Vec<PathBuf>, ExportError> {
    let format = Format::of(path).ok_or_else(|| ExportError::UnknownFormat { path: path.to_path_buf() })?;
    let failed = |problem| ExportError::Encode { path: path.to_path_buf(), problem };
    let mut files = Vec::new();
    match format {
        Format::Exr => files.push((path.to_path_buf(), exr_bytes(picture).map_err(failed)?)),
        Format::Png => {
            files.push((path.to_path_buf(), png_bytes(picture, display).map_err(failed)?));
            if let Some(raw) = &picture.raw {
                let raw = Picture { pixels: raw.clone(), layers: Vec::new(), raw: None, ..picture.clone() };
                files.push((path.with_extension("raw.png"), png_bytes(&raw, display).map_err(failed)?));
            }
            for layer in &picture.layers {
                let beside = path.with_extension(format!("{}.png", layer.kind.word()));
                files.push((beside, encode_png(picture, &layer_pixels(layer), ExtendedColorType::Rgb8).map_err(failed)?));
            }
        }
    }
    for (path, bytes) in &files {
        save_atomic(path, bytes).map_err(ExportError::Write)?;
    }
    Ok(files.into_iter().map(|(path, _)| path).collect())
}

/// The picture as PNG. With alpha, colours are not multiplied by it, as PNG wants.
pub fn png_bytes(picture: &Picture, display: Display) -> Result<Vec<u8>, String> {
    if !picture.has_alpha {
        let bytes: Vec<u8> = picture.pixels.iter().flat_map(|[r, g, b, _]| display.apply_u8([*r, *g, *b])).collect();
        return encode_png(picture, &bytes, ExtendedColorType::Rgb8);
    }
    let bytes = picture.pixels.iter().flat_map(|[r, g, b, coverage]| {
        let alpha = if coverage.is_finite() { coverage.clamp(0.0, 1.0) } else { 1.0 };
        let unmultiplied = if alpha > 0.0 { [r, g, b].map(|x| x / alpha) } else { [0.0; 3] };
        let [r, g, b] = display.apply_u8(unmultiplied);
        [r, g, b, byte(alpha)]
    });
    encode_png(picture, &bytes.collect::<Vec<u8>>(), ExtendedColorType::Rgba8)
}

fn encode_png(picture: &Picture, bytes: &[u8], color: ExtendedColorType) -> Result<Vec<u8>, String> {
    let side = |pixels: usize| u32::try_from(pixels).map_err(|_| format!("{pixels} pixels are more than PNG can hold"));
    let mut file = Vec::new();
    PngEncoder::new(&mut file)
        .write_image(bytes, side(picture.width)?, side(picture.height)?, color)
        .map_err(|error| error.to_string())?;
    Ok(file)
}

fn byte(x: f32) -> u8 {
    (x.clamp(0.0, 1.0) * 255.0 + 0.5) as u8
}

/// A layer made visible: colours through the sRGB curve, normals from -1..1, variance as the standard deviation, the
/// nearest depth white and the farthest dark, samples relative to the most.
fn layer_pixels(layer: &Layer) -> Vec<u8> {
    let count = layer.planes.first().map_or(0, Vec::len);
    let value = |channel: usize, i: usize| {
        let plane = layer.planes.get(channel).or(layer.planes.first());
        plane.and_then(|plane| plane.get(i)).copied().unwrap_or(0.0)
    };
    let is_depth = |d: &f32| d.is_finite() && *d > 0.0;
    let first = layer.planes.first().map_or(&[][..], Vec::as_slice);
    let nearest = first.iter().copied().filter(is_depth).fold(f32::INFINITY, f32::min);
    let largest = first.iter().copied().filter(|x| x.is_finite()).fold(0.0, f32::max);
    let shown = |channel: usize, i: usize| {
        let x = value(channel, i);
        byte(match layer.kind {
            LayerKind::Albedo => srgb_encode(x),
            LayerKind::Normal => 0.5 + 0.5 * x,
            LayerKind::Variance => srgb_encode(x.max(0.0).sqrt()),
            LayerKind::Samples => x / largest.max(1.0),
            // A picture of one depth is white, so the range is not divided by if it is empty.
            LayerKind::Depth if is_depth(&x) => 1.0 - 0.8 * (x - nearest) / (largest - nearest).max(f32::MIN_POSITIVE),
            LayerKind::Depth => 0.0,
        })
    };
    (0..count).flat_map(|i| [shown(0, i), shown(1, i), shown(2, i)]).collect()
}

/// The picture as EXR with its layers. Colours are multiplied by alpha, as EXR wants.
pub fn exr_bytes(picture: &Picture) -> Result<Vec<u8>, String> {
    let channels = if picture.has_alpha { 4 } else { 3 };
    let colors = |prefix: &'static str, pixels: &[[f32; 4]]| {
        let plane = |c: usize| FlatSamples::F32(pixels.iter().map(|pixel| pixel[c]).collect());
        let channel = |(c, name): (usize, &&str)| AnyChannel::new(format!("{prefix}{name}").as_str(), plane(c));
        ["R", "G", "B", "A"].iter().enumerate().take(channels).map(channel).collect::<Vec<_>>()
    };
    let raw = picture.raw.iter().flat_map(|raw| colors("raw.", raw));
    let layers = picture.layers.iter().flat_map(|layer| {
        let channels = layer.kind.channels().iter().zip(&layer.planes);
        channels.map(|(name, values)| {
            AnyChannel::new(format!("{}.{name}", layer.kind.word()).as_str(), FlatSamples::F32(values.clone()))
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

#[cfg(test)]
mod tests {
    use super::*;
    use exr::prelude::read_all_flat_layers_from_file;
    use serde_json::json;

    fn picture() -> Picture {
        Picture {
            width: 3,
            height: 2,
            pixels: (0..6).map(|i| [i as f32 * 100_000.0, 0.25, 0.0, 0.5]).collect(),
            has_alpha: true,
            raw: None,
            layers: vec![Layer { kind: LayerKind::Depth, planes: vec![vec![1.0, 2.0, 3.0, f32::INFINITY, 0.0, 1.0]] }],
            job: Some(json!({ "seed": 7, "material": "Käse 🧀" })),
        }
    }

    #[test]
    fn exr_keeps_values_layers_and_job() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        assert_eq!(write(&path, &picture(), Display::default()).unwrap(), std::slice::from_ref(&path));
        let read = read_all_flat_layers_from_file(&path).unwrap();
        let layer = &read.layer_data[0];
        let names: Vec<String> = layer.channel_data.list.iter().map(|channel| channel.name.to_string()).collect();
        assert_eq!(names, ["A", "B", "G", "R", "depth.Z"]);
        let red: Vec<f32> = layer.channel_data.list[3].sample_data.values_as_f32().collect();
        assert_eq!(red[5], 500_000.0);
        let Some(exr::meta::attribute::AttributeValue::Text(job)) = layer.attributes.other.get(&Text::from(JOB_ATTRIBUTE)) else {
            panic!("the job is there")
        };
        let job: serde_json::Value = serde_json::from_str(&job.to_string()).unwrap();
        assert_eq!(Some(job), picture().job);
    }

    #[test]
    fn the_raw_picture_is_kept() {
        let folder = tempfile::tempdir().unwrap();
        let denoised = Picture { raw: Some(vec![[1.0, 0.5, 0.25, 1.0]; 6]), ..picture() };
        let exr = folder.path().join("a.exr");
        write(&exr, &denoised, Display::default()).unwrap();
        let read = read_all_flat_layers_from_file(&exr).unwrap();
        let list = &read.layer_data[0].channel_data.list;
        let green = list.iter().find(|channel| channel.name.to_string() == "raw.G").unwrap();
        assert!(green.sample_data.values_as_f32().all(|x| x == 0.5));
        let files = write(&folder.path().join("a.png"), &denoised, Display::default()).unwrap();
        let names: Vec<_> = files.iter().map(|file| file.file_name().unwrap().to_str().unwrap()).collect();
        assert_eq!(names, ["a.png", "a.raw.png", "a.depth.png"]);
        let raw = image::open(&files[1]).unwrap().to_rgba8();
        assert_eq!(raw.get_pixel(0, 0)[3], 255);
        assert!(raw.get_pixel(0, 0) == raw.get_pixel(2, 1), "every pixel of it is the same");
    }

    #[test]
    fn png_has_layers_beside_it() {
        let folder = tempfile::tempdir().unwrap();
        let files = write(&folder.path().join("a.png"), &picture(), Display::default()).unwrap();
        let names: Vec<_> = files.iter().map(|file| file.file_name().unwrap().to_str().unwrap()).collect();
        assert_eq!(names, ["a.png", "a.depth.png"]);
        let depth = image::open(&files[1]).unwrap().to_rgb8();
        assert_eq!([depth.get_pixel(0, 0)[0], depth.get_pixel(2, 0)[0], depth.get_pixel(0, 1)[0]], [255, 51, 0]);
        let alpha = image::open(&files[0]).unwrap().to_rgba8();
        assert_eq!(alpha.get_pixel(0, 0)[3], 128);
    }

    #[test]
    fn bytes_do_not_depend_on_the_run() {
        assert_eq!(exr_bytes(&picture()).unwrap(), exr_bytes(&picture()).unwrap());
    }

    #[test]
    fn a_failed_write_leaves_nothing() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["a.jpg", "missing/a.png"] {
            assert!(write(&folder.path().join(name), &picture(), Display::default()).is_err(), "{name}");
        }
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}
