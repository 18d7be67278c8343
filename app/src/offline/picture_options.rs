//! Options that say what a finished picture holds. Shared by all commands that write pictures.

use super::OfflineError;
use crate::export::{LayerKind, Precision};
use crate::picture_job::PictureJob;
use burnish_material::{LOBES, Lobe, LobeSet};
use burnish_renderer::path::{Prepared, StopRules};
use burnish_renderer::scene::Scene;
use burnish_renderer::tonemap::{Display, DisplayTransform};
use clap::Args;

/// Samples per pixel without a stop rule: enough for a picture without visible grain of most materials.
pub const DEFAULT_SPP: u32 = 256;

/// What a finished picture holds, and by which samples.
#[derive(Clone, Debug, Default, PartialEq, Args)]
#[command(next_help_heading = "Picture")]
pub struct PictureOptions {
    /// Gives every pixel the same number of samples
    #[arg(long)]
    pub no_adaptive: bool,
    /// Further layers: channels of an .exr, or files NAME.LAYER.png beside a .png; lobes (light by the lobe that scattered it) takes another rendering
    #[arg(
        long,
        value_name = "albedo,normal,depth,position,emission,lobes,samples,error,variance",
        value_delimiter = ',',
        value_parser = layer
    )]
    pub aov: Vec<LayerKind>,
    /// Leaves lobes out also where they are needed, to see what they add (names: `burnish features`)
    #[arg(long, value_name = "LOBE,...", value_delimiter = ',', value_parser = lobe)]
    pub without: Vec<Lobe>,
    /// Finds caustics by paths from the camera alone, to see what tracing them from the light is worth
    #[arg(long)]
    pub no_photons: bool,
    /// Leaves the background out; the picture gets an alpha channel
    #[arg(long)]
    pub transparent: bool,
    /// How radiance becomes colours in a .png
    #[arg(long, value_name = "neutral|agx|aces|standard", default_value = "neutral", value_parser = transform)]
    pub display_transform: DisplayTransform,
    /// Bits per channel of a .png [default: 8]
    #[arg(long, value_name = "8|16", value_parser = bits)]
    pub bits: Option<u8>,
    /// Stores colours of an .exr as halves; distances, places, counts and errors stay floats
    #[arg(long)]
    pub half: bool,
    /// Writes the picture denoised and the raw one beside it: NAME.raw.png, or channels raw.R, raw.G, raw.B of an .exr;
    /// auto is Open Image Denoise where it is installed (BURNISH_OIDN may say where), else the own filter
    #[arg(long, value_name = "auto|burnish|oidn", num_args = 0..=1, require_equals = true, default_missing_value = "auto", value_parser = denoiser)]
    pub denoise: Option<Denoise>,
}

/// Which filter `--denoise` takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Denoise {
    /// Open Image Denoise where it is installed, else the own one.
    Auto,
    /// The own one.
    Own,
    /// Open Image Denoise.
    Oidn,
}

impl Denoise {
    /// All of them with the words that options and files use.
    pub const WORDS: [(Self, &'static str); 3] = [(Self::Auto, "auto"), (Self::Own, "burnish"), (Self::Oidn, "oidn")];
}

impl PictureOptions {
    /// How finely the picture is stored.
    pub fn precision(&self) -> Precision {
        Precision { is_sixteen_bit: self.bits == Some(16), is_half: self.half }
    }

    /// How it is shown.
    pub fn display(&self, exposure_ev: f32) -> Display {
        Display { exposure_ev, transform: self.display_transform }
    }

    /// The scene ready for the path tracer; with `previous` what both share is kept.
    pub fn prepare(&self, scene: &Scene, previous: Option<&Prepared>) -> Prepared {
        let prepared = Prepared::with_lobes(scene, previous, LobeSet::EMPTY, self.left_out());
        if self.no_photons { prepared.without_photons() } else { prepared }
    }

    /// The lobes that are left out.
    pub fn left_out(&self) -> LobeSet {
        self.without.iter().fold(LobeSet::EMPTY, |set, lobe| set.with(*lobe))
    }

    /// Notes the options.
    pub fn describe(&self, job: &mut PictureJob, exposure_ev: f32) {
        job.adaptive = !self.no_adaptive;
        job.photons = !self.no_photons;
        job.without = self.without.iter().map(|lobe| lobe.def().name.to_owned()).collect();
        job.exposure_ev = exposure_ev;
        job.display_transform = self.display_transform.to_string();
        job.transparent = self.transparent;
        job.aov = self.aov.iter().map(|kind| kind.word().to_owned()).collect();
        job.bits = self.bits.unwrap_or(8);
        job.half = self.half;
        let word =
            |choice: Denoise| Denoise::WORDS.iter().find(|(known, _)| *known == choice).map(|(_, word)| (*word).to_owned());
        job.denoise = self.denoise.and_then(word);
    }

    /// The options that [`Self::describe`] noted.
    pub fn of_job(job: &PictureJob) -> Result<Self, OfflineError> {
        let unusable = |problem: String| OfflineError::unusable(format!("the picture's job: {problem}"));
        Ok(Self {
            no_adaptive: !job.adaptive,
            no_photons: !job.photons,
            without: job.without.iter().map(|word| lobe(word)).collect::<Result<_, _>>().map_err(unusable)?,
            transparent: job.transparent,
            display_transform: transform(&job.display_transform).map_err(unusable)?,
            aov: job.aov.iter().map(|word| layer(word)).collect::<Result<_, _>>().map_err(unusable)?,
            bits: Some(job.bits).filter(|bits| *bits == 16),
            half: job.half,
            denoise: job.denoise.as_deref().map(denoiser).transpose().map_err(unusable)?,
        })
    }
}

/// The rules, or as many samples as pictures have without one.
pub fn stop_rules(spp: Option<u32>, seconds: Option<f64>, relmse: Option<f64>) -> StopRules {
    let has_rule = spp.is_some() || seconds.is_some() || relmse.is_some();
    StopRules { spp: if has_rule { spp } else { Some(DEFAULT_SPP) }, seconds, relmse }
}

fn lobe(text: &str) -> Result<Lobe, String> {
    let names = || LOBES.iter().map(|def| def.name).collect::<Vec<_>>().join(", ");
    LOBES.iter().find(|def| def.name == text).map(|def| def.lobe).ok_or_else(|| format!("expected one of {}", names()))
}

fn denoiser(word: &str) -> Result<Denoise, String> {
    let known = Denoise::WORDS.iter().find(|(_, known)| *known == word).map(|(choice, _)| *choice);
    known.ok_or_else(|| "expected auto, burnish or oidn".to_owned())
}

fn bits(word: &str) -> Result<u8, String> {
    word.parse().ok().filter(|bits| [8, 16].contains(bits)).ok_or_else(|| "expected 8 or 16".to_owned())
}

/// A display transform, for options.
pub fn transform(word: &str) -> Result<DisplayTransform, String> {
    DisplayTransform::from_word(word).ok_or_else(|| "expected neutral, agx, aces or standard".to_owned())
}

fn layer(word: &str) -> Result<LayerKind, String> {
    let known = || LayerKind::ALL.map(|(_, word)| word).join(", ");
    LayerKind::from_word(word).ok_or_else(|| format!("expected layers among {}", known()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_job_holds_all_options() {
        let options = PictureOptions {
            no_adaptive: true,
            aov: LayerKind::ALL.map(|(kind, _)| kind).to_vec(),
            without: vec![Lobe::coat],
            no_photons: true,
            transparent: true,
            display_transform: DisplayTransform::Aces,
            bits: Some(16),
            half: true,
            denoise: Some(Denoise::Own),
        };
        for options in [options, PictureOptions::default()] {
            let mut job = PictureJob::new();
            options.describe(&mut job, 0.5);
            assert_eq!(PictureOptions::of_job(&job).unwrap(), options);
        }
    }
}
