//! What a picture was made from: enough to make it again, bit by bit. Stands in every PNG and EXR that this program writes.
//!
//! Jobs hold no times and no number of threads, so that equal jobs give equal files.

use crate::digest::Digest;
use crate::files::texture_name;
use burnish_renderer::PICTURE_VERSION;
use burnish_renderer::path::ErrorEstimate;
use burnish_renderer::scene::Camera;
use glam::Vec3;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// This program and its version.
pub const PROGRAM: &str = concat!("Burnish ", env!("CARGO_PKG_VERSION"));

/// A picture's job. Keys that a file lacks have their defaults; those that this version does not know are ignored.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct PictureJob {
    /// Program and version that made it.
    pub program: String,
    /// Version of the bits of its pictures ([`PICTURE_VERSION`]); 0 where the file does not say.
    pub picture_version: u32,
    /// `final` or `preview`.
    pub view: String,
    /// Graphics adapter of a preview.
    pub adapter: Option<String>,
    /// Columns and rows.
    pub size: [usize; 2],
    /// Random stream.
    pub seed: u64,
    /// Whether noisy pixels got more samples.
    pub adaptive: bool,
    /// Whether caustics were traced from the light.
    pub photons: bool,
    /// Lobes left out although they were needed.
    pub without: Vec<String>,
    /// What is seen.
    pub scene: SceneSource,
    /// Text of the material file.
    pub material: Option<String>,
    /// Its images.
    pub textures: Vec<Texture>,
    /// Stops of exposure of a PNG.
    pub exposure_ev: f32,
    /// Display transform of a PNG, by its word.
    pub display_transform: String,
    /// Whether the background was left out.
    pub transparent: bool,
    /// Further layers by their words.
    pub aov: Vec<String>,
    /// Which filter was asked for: `auto`, `burnish`, `oidn`.
    pub denoise: Option<String>,
    /// Which filter this picture went through, with its version; `None`: it is the raw one.
    pub denoiser: Option<String>,
    /// Bits per channel of a PNG.
    pub bits: u8,
    /// Whether an EXR holds halves.
    pub half: bool,
    /// Rules that should end it.
    pub stop: Stop,
    /// Samples of all pixels together when it ended, one number for each tile that it was rendered in; frames of a preview.
    pub samples: Vec<u64>,
    /// Samples per pixel, rounded down.
    pub spp: u32,
    /// The rule that ended it.
    pub stop_reason: Option<String>,
    /// Error that it reached.
    pub relmse_estimate: Option<f64>,
    /// Lower end of its 95 % interval.
    pub relmse_low: Option<f64>,
    /// Upper end.
    pub relmse_high: Option<f64>,
    /// Whether rare bright samples dominate.
    pub is_firefly_limited: Option<bool>,
}

/// Stop rules, as far as they were given.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Stop {
    /// Samples per pixel.
    pub spp: Option<u32>,
    /// Seconds of rendering.
    pub seconds: Option<f64>,
    /// Estimated relative mean squared error.
    pub relmse: Option<f64>,
}

/// What is seen, and from where.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct SceneSource {
    /// The mesh; `None`: the default, or that of the scene file.
    pub mesh: Option<Source>,
    /// What the mesh stands on, where that is not what it brings: a built-in backdrop by its name.
    pub backdrop: Option<String>,
    /// The environment; `None`: the default, or that of the scene file.
    pub environment: Option<Source>,
    /// A scene file.
    pub scene: Option<Source>,
    /// What the scene file names.
    pub assets: Vec<Source>,
    /// Whether the material took the place of the scene file's.
    pub replaces_material: bool,
    /// Millimetres per scene unit, where that was given.
    pub unit_mm: Option<f64>,
    /// Rotation of the environment, degrees.
    pub rotation_deg: f32,
    /// By how much the objects were turned about the vertical, degrees.
    pub turn_deg: f64,
    /// Where the camera stands.
    pub camera: CameraSource,
    /// Scattering events after the first hit, at most.
    pub max_bounces: u32,
}

/// Something built in, or a file with what it held.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Source {
    /// By its name.
    BuiltIn {
        /// The name.
        name: String,
    },
    /// By its path: relative to the picture if it lies below its folder.
    File {
        /// The path.
        file: String,
        /// What it held ([`Digest::of_file`]).
        hash: String,
    },
}

/// Where a part of a scene was loaded from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Place {
    /// A built-in one, by its name.
    BuiltIn(String),
    /// A file.
    File(PathBuf),
}

impl Place {
    /// The same as a picture in `folder` names it. Reads the file.
    pub fn source(&self, folder: Option<&Path>) -> Source {
        match self {
            Self::BuiltIn(name) => Source::BuiltIn { name: name.clone() },
            Self::File(path) => Source::of_file(path, folder),
        }
    }
}

/// An image of the material.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct Texture {
    /// As the material names it.
    pub name: String,
    /// Where it was, as [`Source::File`].
    pub file: String,
    /// What it held.
    pub hash: String,
}

/// A pinhole camera, world.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct CameraSource {
    /// Position.
    pub origin: [f32; 3],
    /// Point in the middle of the picture.
    pub target: [f32; 3],
    /// Up direction.
    pub up: [f32; 3],
    /// Full vertical angle, degrees.
    pub fov_deg: f32,
}

impl From<Camera> for CameraSource {
    fn from(Camera { origin, target, up, fov_deg }: Camera) -> Self {
        Self { origin: origin.to_array(), target: target.to_array(), up: up.to_array(), fov_deg }
    }
}

impl CameraSource {
    /// The camera; `None` where it looks nowhere.
    pub fn camera(&self) -> Option<Camera> {
        let [origin, target, up] = [self.origin, self.target, self.up].map(Vec3::from);
        let sees = (target - origin).cross(up).try_normalize().is_some() && (0.1..=179.0).contains(&self.fov_deg);
        (sees && origin.is_finite()).then_some(Camera { origin, target, up, fov_deg: self.fov_deg })
    }
}

impl Source {
    /// A file as a picture in `folder` names it. What cannot be read has an empty hash, which no file has.
    pub fn of_file(path: &Path, folder: Option<&Path>) -> Self {
        let (file, hash) = named(path, folder);
        Self::File { file, hash }
    }
}

/// The hash of a file as a job names it.
pub fn hash_of(path: &Path) -> std::io::Result<String> {
    Ok(Digest::of_file(path, &|| true)?.map(|digest| digest.to_string()).unwrap_or_default())
}

impl Texture {
    /// An image as a picture in `folder` names it.
    pub fn of_file(name: &str, path: &Path, folder: Option<&Path>) -> Self {
        let (file, hash) = named(path, folder);
        Self { name: name.to_owned(), file, hash }
    }
}

fn named(path: &Path, folder: Option<&Path>) -> (String, String) {
    let path = std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf());
    (texture_name(&path, folder), hash_of(&path).unwrap_or_default())
}

/// The folder that paths in a picture start at: that of the picture.
pub fn folder_of(picture: &Path) -> Option<PathBuf> {
    std::path::absolute(picture).ok()?.parent().map(Path::to_path_buf)
}

impl PictureJob {
    /// A job of this program that has no picture yet.
    pub fn new() -> Self {
        Self {
            program: PROGRAM.to_owned(),
            picture_version: PICTURE_VERSION,
            view: "final".to_owned(),
            adaptive: true,
            photons: true,
            bits: 8,
            display_transform: "neutral".to_owned(),
            ..Self::default()
        }
    }

    /// Notes how far the picture is: samples per pixel, the rule that ended it (`None`: it was not ended), and its error.
    pub fn reach(&mut self, spp: u32, stop_reason: Option<&str>, error: Option<&ErrorEstimate>) {
        self.spp = spp;
        self.stop_reason = stop_reason.map(str::to_owned);
        self.relmse_estimate = error.map(|error| error.relmse);
        self.relmse_low = error.map(|error| error.low);
        self.relmse_high = error.map(|error| error.high);
        self.is_firefly_limited = error.map(|error| error.is_firefly_limited);
    }

    /// The job as JSON.
    pub fn json(&self) -> serde_json::Value {
        serde_json::to_value(self).unwrap_or_default()
    }

    /// How a picture that this program makes of the job may differ from the one it stands in; `None` where it is the same to the bit.
    pub fn difference(&self) -> Option<String> {
        if self.picture_version == PICTURE_VERSION {
            return None;
        }
        let (by, error) = (if self.program.is_empty() { "another version" } else { &self.program }, self.relmse_estimate);
        let noise = error.map_or_else(String::new, |relmse| format!(", which was about {:.1} %", 100.0 * relmse.max(0.0).sqrt()));
        let known = burnish_renderer::PICTURE_CHANGES.get((self.picture_version as usize).saturating_sub(1)..);
        let changes =
            known.filter(|changes| !changes.is_empty()).map_or_else(String::new, |changes| format!(": {}", changes.join("; ")));
        Some(format!(
            "was made by {by} (pictures of version {}); {PROGRAM} makes pictures of version {PICTURE_VERSION}{changes}. \
             Material, scene and samples are the same, but the noise may differ, and brightness within the error{noise}",
            self.picture_version
        ))
    }
}
