//! Finished pictures read back, ours or of other programs, to be compared.

use crate::export::{JOB_ATTRIBUTE, LayerKind};
use burnish_assets::{AssetError, load_image};
use burnish_renderer::tonemap::{Display, srgb_decode, srgb_encode};
use exr::meta::attribute::AttributeValue;
use exr::prelude::{Text, read_first_flat_layer_from_file};
use std::fmt;
use std::path::{Path, PathBuf};

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
