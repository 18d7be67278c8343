//! Denoising as an option of the final view: the noisy picture stays the result, the denoised one lies beside it with an error of its own.
//!
//! The four replicates of a film make two halves of two. Each half is denoised from its own samples alone; the picture is the mean of the two.
//! Because no half has seen the samples of the other, the error of the denoised picture can be estimated without bias (`estimate`),
//! whatever the filter does. Filters: cross-filtered non-local means (`means`), always there, and Open Image Denoise (`oidn`) where
//! the library is installed.

mod estimate;
mod guides;
mod means;
mod oidn;
#[cfg(test)]
mod tests;

pub use guides::Guides;
pub use oidn::{LIBRARY_VARIABLE, Oidn, OidnError};

use crate::path::{ErrorEstimate, Film, Prepared, REPLICATES};

/// What a film tells a denoiser.
#[derive(Clone, Debug, Default)]
pub struct Input {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Mean linear radiance of each replicate, per pixel, row by row from the top.
    pub replicates: Vec<[[f32; 3]; REPLICATES]>,
}

impl Input {
    /// The replicates of a film; `None` until each holds a sample.
    pub fn of(film: &Film) -> Option<Self> {
        (film.spp() as usize >= REPLICATES).then(|| Self {
            width: film.width,
            height: film.height,
            replicates: (0..film.width * film.height)
                .map(|pixel| film.replicates(pixel).map(|mean| mean.map(|x| x as f32)))
                .collect(),
        })
    }
}

/// A denoised picture.
#[derive(Clone, Debug)]
pub struct Denoised {
    /// Linear radiance, row by row from the top; finite everywhere.
    pub pixels: Vec<[f32; 3]>,
    /// How far it is from what infinitely many samples would show, what the filter blurs included.
    pub error: ErrorEstimate,
}

/// Who denoises.
#[derive(Debug, Default)]
pub enum Denoiser {
    /// The filter of this crate.
    #[default]
    Own,
    /// Open Image Denoise.
    Oidn(Oidn),
}

impl Denoiser {
    /// Open Image Denoise where it is installed, else the own filter; with what is wrong where [`LIBRARY_VARIABLE`] names no library that
    /// works.
    pub fn best() -> (Self, Option<OidnError>) {
        match Oidn::find() {
            Ok(oidn) => (Self::Oidn(oidn), None),
            Err(error) => {
                (Self::Own, Some(error).filter(|_| std::env::var_os(LIBRARY_VARIABLE).is_some_and(|place| !place.is_empty())))
            }
        }
    }

    /// `burnish`, or `oidn` with its version.
    pub fn name(&self) -> String {
        match self {
            Self::Own => "burnish".to_owned(),
            Self::Oidn(oidn) => format!("oidn {}", oidn.version()),
        }
    }

    /// Denoises a picture and estimates what error is left. `threads` of 0 count as 1. `cancel` is asked every few milliseconds by the own
    /// filter and before each half by Open Image Denoise.
    ///
    /// # Errors
    /// [`DenoiseError`]: cancelled, or the library failed.
    pub fn run(
        &self,
        input: &Input,
        guides: &Guides,
        threads: usize,
        cancel: &(dyn Fn() -> bool + Sync),
    ) -> Result<Denoised, DenoiseError> {
        let input = &input.cleaned();
        let halves = match self {
            Self::Own => means::halves(input, guides, threads.max(1), cancel).ok_or(DenoiseError::Cancelled)?,
            Self::Oidn(oidn) => {
                let half = |which: usize| {
                    if cancel() {
                        return Err(DenoiseError::Cancelled);
                    }
                    oidn.filter(&input.half(which), guides, input.width, input.height).map_err(DenoiseError::Oidn)
                };
                [half(0)?, half(1)?]
            }
        };
        let mean = |(a, b): (&[f32; 3], &[f32; 3])| std::array::from_fn(|k| 0.5 * (a[k] + b[k]));
        let pixels = halves[0].iter().zip(&halves[1]).map(mean).collect();
        Ok(Denoised { pixels, error: estimate::error(input, &halves) })
    }
}

/// Why there is no denoised picture.
#[derive(Debug)]
pub enum DenoiseError {
    /// The caller ended it.
    Cancelled,
    /// Open Image Denoise failed.
    Oidn(OidnError),
}

impl std::fmt::Display for DenoiseError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Cancelled => f.write_str("denoising was cancelled"),
            Self::Oidn(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for DenoiseError {}

/// Larger radiance is cut off before filtering: its square should stay a number.
const RADIANCE_MAX: f32 = 1e15;

impl Input {
    /// The mean of the replicates `2 half` and `2 half + 1`.
    fn half(&self, half: usize) -> Vec<[f32; 3]> {
        self.replicates.iter().map(|r| std::array::from_fn(|k| 0.5 * (r[2 * half][k] + r[2 * half + 1][k]))).collect()
    }

    /// The same with every number finite, and as many pixels as width and height say.
    fn cleaned(&self) -> Self {
        let clean = |x: f32| if x.is_nan() { 0.0 } else { x.clamp(-RADIANCE_MAX, RADIANCE_MAX) };
        let mut replicates: Vec<_> = self.replicates.iter().map(|r| r.map(|c| c.map(clean))).collect();
        replicates.resize(self.width * self.height, [[0.0; 3]; REPLICATES]);
        Self { replicates, ..*self }
    }
}
