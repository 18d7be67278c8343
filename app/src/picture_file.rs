//! Finished pictures read back, ours or of other programs: to be compared, or for what they were made from.

use crate::export::{Format, JOB_ATTRIBUTE, LayerKind};
use crate::picture_job::PictureJob;
use burnish_assets::{AssetError, load_image};
use burnish_renderer::tonemap::{Display, srgb_decode, srgb_encode};
use exr::meta::attribute::AttributeValue;
use exr::prelude::{Text, read_first_flat_layer_from_file};
use std::fmt;
use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};

/// Longest job that is read: one with the largest material, every character escaped.
pub const MAX_JOB_BYTES: usize = 64 << 20;

/// A picture from a file, row by row from the top.
#[derive(Clone, Debug)]
pub struct PictureFile {
    /// Where it came from.
    pub path: PathBuf,
    /// Pixels.
    pub width: usize,
    /// Pixels.
    pub height: usize,
    /// Linear Rec.709 over black, finite.
    pub pixels: Vec<[f32; 3]>,
    /// Variance of the mean of each pixel and channel, where the file is an EXR with that layer.
    pub variance: Option<Vec<[f32; 3]>>,
    /// What a picture of ours was made from.
    pub job: Option<serde_json::Value>,
    /// Whether the file holds what a display shows, not radiance.
    is_display_referred: bool,
}

/// Why a picture cannot be compared; shown to the user as one sentence.
#[derive(Debug)]
pub enum PictureError {
    /// The file cannot be read as a picture.
    Asset(AssetError),
    /// The file cannot be opened.
    Read {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The file is no whole picture of its kind.
    Damaged {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        problem: String,
    },
    /// What the picture was made from is longer than any job.
    JobTooLarge {
        /// The file.
        path: PathBuf,
    },
    /// What the picture was made from cannot be understood.
    Job {
        /// The file.
        path: PathBuf,
        /// Where and why.
        source: serde_json::Error,
    },
    /// A value is infinite or not a number.
    NotFinite {
        /// The file.
        path: PathBuf,
        /// Column and row of the first such pixel.
        at: [usize; 2],
    },
    /// Two pictures do not have the same size.
    Size {
        /// The file.
        path: PathBuf,
        /// Width and height.
        found: [usize; 2],
        /// What it is compared with, and its size.
        other: String,
        /// Width and height.
        expected: [usize; 2],
    },
}

impl fmt::Display for PictureError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Asset(error) => error.fmt(f),
            Self::Read { path, source } => write!(f, "{}: cannot be read: {source}", path.display()),
            Self::Damaged { path, problem } => write!(f, "{}: expected a whole picture: {problem}", path.display()),
            Self::JobTooLarge { path } => write!(
                f,
                "{}: expected at most {} MiB about how the picture was made, found more",
                path.display(),
                MAX_JOB_BYTES >> 20
            ),
            Self::Job { path, source } => {
                write!(f, "{}: what it says about how it was made cannot be read: {source}", path.display())
            }
            Self::NotFinite { path, at: [x, y] } => {
                write!(f, "{}: expected finite values, found another in column {x} of row {y}", path.display())
            }
            Self::Size { path, found, other, expected } => write!(
                f,
                "{}: expected {} x {} pixels as {other} has, found {} x {}",
                path.display(),
                expected[0],
                expected[1],
                found[0],
                found[1]
            ),
        }
    }
}

impl std::error::Error for PictureError {}

/// Reads a `.png`, `.jpg`, `.exr` or `.hdr` picture. PNG and JPEG hold display-referred sRGB, the others linear radiance; of layers, the
/// one without a name is the picture.
pub fn read_picture(path: &Path) -> Result<PictureFile, PictureError> {
    let image = load_image(path).map_err(PictureError::Asset)?;
    let has_ending = |known: &str| path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case(known));
    let is_display_referred = !has_ending("exr") && !has_ending("hdr");
    let pixels: Vec<[f32; 3]> = image
        .texels
        .iter()
        .map(|&[r, g, b, alpha]| {
            // Colours of PNG are not multiplied by their coverage, those of EXR are.
            if is_display_referred { [r, g, b].map(|x| alpha * srgb_decode(x)) } else { [r, g, b] }
        })
        .collect();
    if let Some(i) = pixels.iter().position(|pixel| !pixel.iter().all(|x| x.is_finite())) {
        return Err(PictureError::NotFinite { path: path.to_path_buf(), at: [i % image.width, i / image.width] });
    }
    let (variance, job) = if has_ending("exr") { beside(path, pixels.len()) } else { (None, None) };
    let (width, height) = (image.width, image.height);
    Ok(PictureFile { path: path.to_path_buf(), width, height, pixels, variance, job, is_display_referred })
}

/// The text that tells what a picture was made from, and nothing of its pixels. `None`: the picture is not ours.
///
/// # Errors
/// The file cannot be read, its head is damaged, or the text is longer than [`MAX_JOB_BYTES`].
pub fn embedded_text(path: &Path) -> Result<Option<String>, PictureError> {
    let file = || File::open(path).map(BufReader::new).map_err(|source| PictureError::Read { path: path.to_path_buf(), source });
    match Format::of(path) {
        None => Ok(None),
        Some(Format::Png) => text_of_png(path, file()?),
        Some(Format::Exr) => text_of_exr(path, file()?),
    }
}

fn text_of_png(path: &Path, file: BufReader<File>) -> Result<Option<String>, PictureError> {
    let too_large = || PictureError::JobTooLarge { path: path.to_path_buf() };
    let failed = |error: png::DecodingError| match error {
        png::DecodingError::LimitsExceeded => too_large(),
        error => PictureError::Damaged { path: path.to_path_buf(), problem: error.to_string() },
    };
    let limits = png::Limits { bytes: 2 * MAX_JOB_BYTES };
    let reader = png::Decoder::new_with_limits(file, limits).read_info().map_err(failed)?;
    let Some(chunk) = reader.info().utf8_text.iter().find(|chunk| chunk.keyword == JOB_ATTRIBUTE) else { return Ok(None) };
    let mut chunk = chunk.clone();
    // A few bytes can stand for very many.
    chunk.decompress_text_with_limit(MAX_JOB_BYTES).map_err(|_| too_large())?;
    let text = chunk.get_text().map_err(failed)?;
    if text.len() > MAX_JOB_BYTES { Err(too_large()) } else { Ok(Some(text)) }
}

fn text_of_exr(path: &Path, file: BufReader<File>) -> Result<Option<String>, PictureError> {
    let damaged = |error: exr::error::Error| PictureError::Damaged { path: path.to_path_buf(), problem: error.to_string() };
    let head = exr::meta::MetaData::read_from_buffered(file, false).map_err(damaged)?;
    let attribute = head.headers.first().and_then(|header| header.own_attributes.other.get(&Text::from(JOB_ATTRIBUTE)));
    match attribute {
        Some(AttributeValue::Text(text)) if text.bytes().len() > MAX_JOB_BYTES => {
            Err(PictureError::JobTooLarge { path: path.to_path_buf() })
        }
        Some(AttributeValue::Text(text)) => Ok(Some(text.to_string())),
        _ => Ok(None),
    }
}

/// What a picture was made from. `None`: it is not ours.
///
/// # Errors
/// As [`embedded_text`], or the text is no job.
pub fn embedded_job(path: &Path) -> Result<Option<PictureJob>, PictureError> {
    let Some(text) = embedded_text(path)? else { return Ok(None) };
    serde_json::from_str(&text).map(Some).map_err(|source| PictureError::Job { path: path.to_path_buf(), source })
}

/// The material file that a picture was made from, byte by byte. `None`: the picture is not ours, or was made without one.
///
/// # Errors
/// As [`embedded_job`].
pub fn embedded_material(path: &Path) -> Result<Option<Vec<u8>>, PictureError> {
    Ok(embedded_job(path)?.and_then(|job| job.material).map(String::into_bytes))
}

/// Layer `variance` and job of an EXR of ours. Pictures of others have neither, which is no fault.
fn beside(path: &Path, pixels: usize) -> (Option<Vec<[f32; 3]>>, Option<serde_json::Value>) {
    let Ok(image) = read_first_flat_layer_from_file(path) else { return (None, None) };
    let layer = image.layer_data;
    let plane = |name: &str| -> Option<Vec<f32>> {
        let name = format!("{}.{name}", LayerKind::Variance.word());
        let channel = layer.channel_data.list.iter().find(|channel| channel.name.to_string() == name)?;
        let values: Vec<f32> = channel.sample_data.values_as_f32().collect();
        (values.len() == pixels && values.iter().all(|v| v.is_finite() && *v >= 0.0)).then_some(values)
    };
    let variance = (|| {
        let (r, g, b) = (plane("R")?, plane("G")?, plane("B")?);
        Some((0..pixels).map(|i| [r[i], g[i], b[i]]).collect())
    })();
    let job = match layer.attributes.other.get(&Text::from(JOB_ATTRIBUTE)) {
        Some(AttributeValue::Text(text)) => serde_json::from_str(&text.to_string()).ok(),
        _ => None,
    };
    (variance, job)
}

impl PictureFile {
    /// An error unless the picture has this size, which is that of `other`.
    pub fn expect_size(&self, expected: [usize; 2], other: impl fmt::Display) -> Result<(), PictureError> {
        let found = [self.width, self.height];
        if found == expected {
            return Ok(());
        }
        Err(PictureError::Size { path: self.path.clone(), found, other: other.to_string(), expected })
    }

    /// What a display shows of it, sRGB in `[0, 1]`: radiance through `display`, anything else as it is.
    pub fn shown(&self, display: Display) -> Vec<[f32; 3]> {
        if self.is_display_referred {
            return self.pixels.iter().map(|pixel| pixel.map(srgb_encode)).collect();
        }
        self.pixels.iter().map(|pixel| display.apply(*pixel)).collect()
    }
}
