//! A render put aside: bytes from which it goes on as if it had never stopped.

use super::{Progress, Rendering, Run, Settings, finish};
use crate::PICTURE_VERSION;
use crate::path::adaptive::Allocation;
use crate::path::bytes::{Reader, Writer};
use crate::path::convergence::ErrorPoint;
use crate::path::film::Film;
use crate::path::{PassStats, Prepared};
use std::fmt;
use std::sync::Arc;
use std::time::Instant;

/// What such bytes begin with.
const MAGIC: u64 = u64::from_le_bytes(*b"BURNKEPT");

/// A render that has stopped and can go on.
#[derive(Clone, Debug)]
pub struct Kept {
    film: Film,
    allocation: Option<Arc<Allocation>>,
    judged: Option<(u32, f64)>,
    predicted: Option<u32>,
    relmse: Option<f64>,
    seconds: f64,
    nonfinite: u64,
    history: Vec<ErrorPoint>,
}

/// Why bytes are no render that can go on; part of a sentence.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum KeptError {
    /// They are cut short, damaged or of something else.
    Damaged,
    /// Another version wrote them, whose samples differ.
    Version(u32),
    /// They are of a picture of another size.
    Size([usize; 2]),
}

impl fmt::Display for KeptError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Damaged => f.write_str("expected the samples of a render, found other or damaged bytes"),
            Self::Version(version) => {
                write!(f, "expected samples of picture version {PICTURE_VERSION}, found those of version {version}")
            }
            Self::Size([width, height]) => write!(f, "found the samples of a picture of {width} x {height} pixels"),
        }
    }
}

impl std::error::Error for KeptError {}

impl Rendering {
    /// The render as bytes: 104 for each pixel, up to 208 with caustics and adaptive sampling.
    pub fn keep(&self) -> Vec<u8> {
        let mut to = Writer::default();
        to.u64(MAGIC);
        to.u32(PICTURE_VERSION);
        to.f64(self.seconds);
        to.u64(self.nonfinite);
        for (spp, error) in [self.plan.judged, self.plan.predicted.map(|spp| (spp, 0.0))].map(Option::unwrap_or_default) {
            to.u32(spp);
            to.f64(error);
        }
        to.f64(self.plan.stop.relmse.unwrap_or(0.0));
        to.u64(self.history.len() as u64);
        for point in &self.history {
            [point.seconds, point.relmse, point.low, point.high].into_iter().for_each(|x| to.f64(x));
            to.u32(point.spp);
        }
        self.film.write(&mut to);
        let allocation = self.allocation.as_deref();
        to.u64(allocation.map_or(0, |allocation| allocation.base.len() as u64));
        for (base, level) in allocation.iter().flat_map(|a| a.base.iter().zip(&a.levels)) {
            to.u32(*base);
            to.u32(*level as u32);
        }
        let sum = checksum(&to.bytes);
        to.u64(sum);
        to.bytes
    }
}

impl Kept {
    /// Reads what [`Rendering::keep`] made. Damage is found.
    pub fn read(bytes: &[u8]) -> Result<Self, KeptError> {
        let (body, sum) = bytes.split_last_chunk::<8>().ok_or(KeptError::Damaged)?;
        let mut from = Reader::new(body);
        let (magic, version) = (from.u64(), from.u32().ok_or(KeptError::Damaged)?);
        if magic != Some(MAGIC) || u64::from_le_bytes(*sum) != checksum(body) {
            return Err(KeptError::Damaged);
        }
        if version != PICTURE_VERSION {
            return Err(KeptError::Version(version));
        }
        let kept = Self::read_rest(&mut from).filter(|_| from.is_empty());
        kept.ok_or(KeptError::Damaged)
    }

    fn read_rest(from: &mut Reader<'_>) -> Option<Self> {
        let (seconds, nonfinite) = (from.f64()?, from.u64()?);
        let judged = Some((from.u32()?, from.f64()?)).filter(|(spp, _)| *spp > 0);
        let predicted = Some((from.u32()?, from.f64()?)).map(|(spp, _)| spp).filter(|spp| *spp > 0);
        let relmse = Some(from.f64()?).filter(|relmse| *relmse > 0.0);
        let mut history = Vec::new();
        for _ in 0..from.count(36)? {
            let [seconds, relmse, low, high] = [from.f64()?, from.f64()?, from.f64()?, from.f64()?];
            history.push(ErrorPoint { seconds, spp: from.u32()?, relmse, low, high });
        }
        let film = Film::read(from)?;
        let count = from.count(8)?;
        let (mut base, mut levels) = (Vec::new(), Vec::new());
        for _ in 0..count {
            base.push(from.u32()?);
            levels.push(from.u32()? as i32);
        }
        let is_fitting = count == 0 || count == film.pixels();
        let allocation = (count > 0).then(|| Arc::new(Allocation::of(base, levels)));
        is_fitting.then_some(Self { film, allocation, judged, predicted, relmse, seconds, nonfinite, history })
    }

    /// Seconds that were rendered.
    pub fn seconds(&self) -> f64 {
        self.seconds
    }

    /// Samples per pixel so far.
    pub fn spp(&self) -> u32 {
        self.film.spp()
    }

    /// Goes on until a rule ends it; seconds count from the very beginning. With the scene, the size and the seed of before, the samples are those of
    /// a render that never stopped.
    pub fn go_on(
        self,
        prepared: &Prepared,
        settings: &Settings,
        start: Instant,
        progress: &mut dyn FnMut(&Progress<'_>) -> bool,
    ) -> Result<Rendering, KeptError> {
        if [self.film.width, self.film.height] != [settings.width, settings.height]
            || self.film.window.full != [settings.width, settings.height]
        {
            return Err(KeptError::Size([self.film.width, self.film.height]));
        }
        let mut run = Run::of_film(prepared, *settings, self.film);
        run.allocation = self.allocation;
        run.plan.judged = self.judged;
        // A number of samples that was foreseen for another target says nothing.
        run.plan.predicted = self.predicted.filter(|_| self.relmse == settings.stop.relmse);
        run.seconds = self.seconds;
        run.history = self.history;
        run.stats = PassStats { samples: run.film.total_samples(), nonfinite: self.nonfinite, ..PassStats::default() };
        run.pace = self.seconds / run.film.total_samples().max(1) as f64;
        run.estimate_again();
        Ok(finish(run, start, progress))
    }
}

impl Run<'_> {
    /// The error of what was taken up, which is no new point of the history.
    fn estimate_again(&mut self) {
        let points = self.history.len();
        self.estimate();
        self.history.truncate(points.max(1));
    }
}

/// FNV-1a over words of eight bytes.
fn checksum(bytes: &[u8]) -> u64 {
    let word = |chunk: &[u8]| chunk.iter().rev().fold(0, |word, byte| word << 8 | u64::from(*byte));
    bytes.chunks(8).fold(0xcbf2_9ce4_8422_2325, |sum, chunk| (sum ^ word(chunk)).wrapping_mul(0x0100_0000_01b3))
}
