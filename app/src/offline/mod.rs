//! Pictures rendered into files, one or a series around the object, whoever asks for them: the command line or the window.

pub mod develop;
mod final_picture;
pub mod loaded_scene;
pub mod picture;
pub mod picture_options;
mod preview_picture;
pub(crate) mod tiles;
pub mod turntable;
pub mod watch;

use crate::export::ExportError;
use crate::scene_file::MAX_PIXELS;
use std::fmt;
use std::path::PathBuf;

/// Why something was not made; shown to the user as one sentence.
#[derive(Debug)]
pub enum OfflineError {
    /// Whoever watches has ended it.
    Cancelled,
    /// More pixels than are rendered at a time, where they cannot be rendered in parts.
    TooLarge {
        /// Columns and rows.
        found: [usize; 2],
    },
    /// The preview was asked for what only the final view has.
    NotOfPreview,
    /// The preview cannot be drawn.
    Preview(String),
    /// The denoiser failed.
    Denoise(String),
    /// The picture cannot be written.
    Export(ExportError),
    /// The folder cannot be made.
    Folder {
        /// The folder.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The folder holds a turntable already.
    HasTurntable {
        /// The file that tells of it.
        path: PathBuf,
    },
    /// A file or a folder cannot be used: its name, and what was expected.
    Unusable(String),
}

impl OfflineError {
    /// An error with this sentence.
    pub fn unusable(message: impl fmt::Display) -> Self {
        Self::Unusable(message.to_string())
    }
}

impl fmt::Display for OfflineError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Cancelled => f.write_str("cancelled; nothing was written"),
            Self::TooLarge { found: [width, height] } => write!(
                f,
                "expected at most {MAX_PIXELS} (2^24) pixels in all with passes, denoising or many frames, found {width} x {height}"
            ),
            Self::NotOfPreview => f.write_str(
                "the preview has no transparent background, passes, stop at an error or denoising; the final view has",
            ),
            Self::Preview(problem) => write!(f, "the preview cannot be drawn: {problem}"),
            Self::Denoise(problem) => write!(f, "denoising failed: {problem}"),
            Self::Export(error) => error.fmt(f),
            Self::Folder { path, source } => write!(f, "{}: {source}", path.display()),
            Self::HasTurntable { path } => write!(f, "{}: expected a folder without a turntable", path.display()),
            Self::Unusable(message) => f.write_str(message),
        }
    }
}

impl std::error::Error for OfflineError {}
