//! Finished pictures as files: PNG for showing, EXR for working on. A file appears whole or not at all.
//!
//! PNG holds 8 or 16 bits of display-referred sRGB; EXR holds linear Rec.709 radiance as 32-bit floats or as halves, with further layers
//! as channels `layer.CHANNEL`. Both hold what they were made from. Neither holds anything that differs between two runs of the same job, unless
//! its caller writes such things into the job.

mod exr_file;
mod layers;
mod png_file;

pub use exr_file::exr_bytes;
pub use layers::{Layer, LayerKind};
pub use png_file::{png_bytes, rgba_png};

use crate::files::{FilesError, save_atomic};
use burnish_renderer::path::ErrorEstimate;
use burnish_renderer::tonemap::Display;
use std::fmt;
use std::path::{Path, PathBuf};

/// Name of the EXR attribute, and keyword of the PNG text, that holds [`Picture::job`].
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
    /// What the picture was made from, as JSON: a [`crate::picture_job::PictureJob`].
    pub job: Option<serde_json::Value>,
    /// How finely it is stored.
    pub precision: Precision,
}

/// How finely values are stored.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Precision {
    /// PNG with 16 bits a channel instead of 8.
    pub is_sixteen_bit: bool,
    /// EXR with halves instead of 32-bit floats for colours; distances, places, counts and errors stay floats.
    pub is_half: bool,
}

/// Formats of pictures, told by the ending of the name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// 8 or 16 bits, display-referred.
    Png,
    /// Floats or halves, linear.
    Exr,
}

impl Format {
    /// The format that the ending of a path stands for, in any case.
    pub fn of(path: &Path) -> Option<Self> {
        let ending = path.extension()?.to_str()?;
        [Self::Png, Self::Exr].into_iter().find(|format| format.ending().eq_ignore_ascii_case(ending))
    }

    /// The ending of its files.
    pub fn ending(self) -> &'static str {
        match self {
            Self::Png => "png",
            Self::Exr => "exr",
        }
    }

    /// What the numbers mean.
    pub fn encoding(self) -> &'static str {
        match self {
            Self::Png => "PNG: display-referred sRGB",
            Self::Exr => "EXR: linear Rec.709, no transform",
        }
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
/// which EXR holds as `raw.R` and so on. The picture and the raw one hold the job. All are encoded before the first is
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
                let job = picture.job.clone().map(without_denoising);
                let raw = Picture { pixels: raw.clone(), layers: Vec::new(), raw: None, job, ..picture.clone() };
                files.push((path.with_extension("raw.png"), png_bytes(&raw, display).map_err(failed)?));
            }
            for layer in &picture.layers {
                let beside = path.with_extension(format!("{}.png", layer.name()));
                files.push((beside, png_file::layer_bytes(picture, layer, display).map_err(failed)?));
            }
        }
    }
    for (path, bytes) in &files {
        save_atomic(path, bytes).map_err(ExportError::Write)?;
    }
    Ok(files.into_iter().map(|(path, _)| path).collect())
}

/// The job of the raw picture of a denoised one.
fn without_denoising(mut job: serde_json::Value) -> serde_json::Value {
    for key in ["denoiser", "denoise"] {
        if let Some(value) = job.get_mut(key) {
            *value = serde_json::Value::Null;
        }
    }
    job
}

#[cfg(test)]
mod tests {
    use super::*;
    use exr::prelude::{Text, read_all_flat_layers_from_file};
    use serde_json::json;

    fn picture() -> Picture {
        Picture {
            width: 3,
            height: 2,
            pixels: (0..6).map(|i| [i as f32 * 100_000.0, 0.25, 0.0, 0.5]).collect(),
            has_alpha: true,
            raw: None,
            layers: vec![Layer {
                kind: LayerKind::Depth,
                part: None,
                planes: vec![vec![1.0, 2.0, 3.0, f32::INFINITY, 0.0, 1.0]],
            }],
            job: Some(json!({ "seed": 7, "material": "Käse 🧀" })),
            precision: Precision::default(),
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
