//! One picture: rendered by the path tracer or by the preview, and written with what it was made from.

use super::OfflineError;
use super::develop::DenoiseReport;
use super::final_picture::final_view;
use super::loaded_scene::LoadedScene;
use super::picture_options::{PictureOptions, stop_rules};
use super::preview_picture::preview;
use super::tiles;
use super::watch::{Step, Watch};
use crate::export::{self, Picture};
use crate::picture_job::{PictureJob, Stop, folder_of};
use burnish_material::{LobeSet, Material};
use burnish_renderer::path::{ErrorEstimate, StopRules};
use burnish_renderer::scene::Scene;
use std::path::{Path, PathBuf};

/// Which renderer draws.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum View {
    /// The path tracer.
    #[default]
    Final,
    /// The rasteriser.
    Preview,
}

impl View {
    /// The word that options and files use.
    pub fn word(self) -> &'static str {
        if self == Self::Final { "final" } else { "preview" }
    }
}

/// What is to be made, and how.
#[derive(Clone, Debug)]
pub struct Order {
    /// What is drawn, and how large.
    pub loaded: LoadedScene,
    /// What the picture holds.
    pub options: PictureOptions,
    /// Stops of exposure of a PNG.
    pub exposure_ev: f32,
    /// Random stream.
    pub seed: u64,
    /// Threads that render.
    pub threads: usize,
    /// Rules that end it, as far as they were given.
    pub stop: Stop,
}

impl Order {
    /// The rules that end it.
    pub fn rules(&self) -> StopRules {
        stop_rules(self.stop.spp, self.stop.seconds, self.stop.relmse)
    }

    /// An error where this cannot be made by that renderer, told before minutes of work.
    pub fn refuse(&self, view: View) -> Result<(), OfflineError> {
        let (options, size) = (&self.options, [self.loaded.width, self.loaded.height]);
        let is_more = !options.aov.is_empty() || options.denoise.is_some();
        if view == View::Preview && (is_more || options.transparent || self.stop.relmse.is_some()) {
            return Err(OfflineError::NotOfPreview);
        }
        if is_more && tiles::of_final(size[0], size[1]).len() > 1 {
            return Err(OfflineError::TooLarge { found: size });
        }
        Ok(())
    }
}

/// How far a picture was that is made again.
pub struct Repeat {
    /// Samples of each part; frames of a preview.
    pub samples: Vec<u64>,
    /// The rules that it had.
    pub stop: Stop,
    /// The one that ended it.
    pub stop_reason: Option<String>,
    /// The picture.
    pub picture: PathBuf,
    /// What denoised it.
    pub denoiser: Option<String>,
    /// What drew it, if that was the preview.
    pub adapter: Option<String>,
}

impl Repeat {
    /// What is to be said where another filter denoised than before.
    fn denoiser_note(&self, now: Option<&DenoiseReport>) -> Option<String> {
        let (before, now) = (self.denoiser.as_deref()?, now.map_or("none", |report| report.denoiser.as_str()));
        let picture = self.picture.display();
        (before != now)
            .then(|| format!("{picture}: was denoised by {before}, and now by {now}: only the raw picture is the same"))
    }

    /// What is to be said where another adapter draws than before.
    pub(super) fn adapter_note(&self, now: &str) -> Option<String> {
        let before = self.adapter.as_deref().filter(|before| *before != now)?;
        Some(format!("{}: was drawn by {before}, and now by {now}: pixels may differ by rounding", self.picture.display()))
    }
}

/// A picture and what is told about its making.
pub struct Rendered {
    /// The picture.
    pub picture: Picture,
    /// Samples of each part of the picture; frames of a preview.
    pub samples: Vec<u64>,
    /// Samples per pixel, rounded down.
    pub spp: u32,
    /// Seconds of rendering.
    pub seconds: f64,
    /// Seconds from the start to the first whole picture.
    pub first_image_seconds: f64,
    /// Seconds for trees and tables.
    pub load_seconds: f64,
    /// The rule that ended it.
    pub stop_reason: String,
    /// Its error, of the final view.
    pub error: Option<ErrorEstimate>,
    /// `None` where the picture is the raw one.
    pub denoised: Option<DenoiseReport>,
    /// What drew it, if that was the preview.
    pub adapter: Option<String>,
    /// Contributions that were left out since they were no positive numbers.
    pub nonfinite: u64,
    /// Lobes that were evaluated.
    pub lobes: LobeSet,
}

/// Renders a picture, as far as `again` says where that is given, and writes it. Returns it with its files, the picture first.
pub fn make(
    order: &Order,
    view: View,
    out: &Path,
    again: Option<&Repeat>,
    watch: &mut Watch<'_>,
) -> Result<(Rendered, Vec<PathBuf>), OfflineError> {
    let mut rendered = render(order, view, again, watch)?;
    let files = write(order, view, out, again, &mut rendered, watch)?;
    Ok((rendered, files))
}

/// Renders a picture, as far as `again` says where that is given.
pub fn render(order: &Order, view: View, again: Option<&Repeat>, watch: &mut Watch<'_>) -> Result<Rendered, OfflineError> {
    order.refuse(view)?;
    let rendered = match view {
        View::Final => final_view(order, again, watch)?,
        View::Preview => preview(order, again, watch)?,
    };
    if (watch.is_cancelled)() {
        return Err(OfflineError::Cancelled);
    }
    if rendered.nonfinite > 0 {
        (watch.warn)(format!("{} contributions were negative or not finite and were left out", rendered.nonfinite));
    }
    if let Some(sentence) = again.and_then(|again| again.denoiser_note(rendered.denoised.as_ref())) {
        (watch.warn)(sentence);
    }
    Ok(rendered)
}

/// Writes a picture with what it was made from. Returns its files, the picture first.
pub fn write(
    order: &Order,
    view: View,
    out: &Path,
    again: Option<&Repeat>,
    rendered: &mut Rendered,
    watch: &mut Watch<'_>,
) -> Result<Vec<PathBuf>, OfflineError> {
    (watch.tell)(&Step { part: "writing".to_owned(), ..Step::default() });
    rendered.picture.job = Some(job(order, view, out, again, rendered).json());
    export::write(out, &rendered.picture, order.options.display(order.exposure_ev)).map_err(OfflineError::Export)
}

/// What the picture was made from; no times but that of the rule, so that equal jobs give equal files.
fn job(order: &Order, view: View, out: &Path, again: Option<&Repeat>, rendered: &Rendered) -> PictureJob {
    let mut job = PictureJob::new();
    order.loaded.describe(&mut job, folder_of(out).as_deref());
    order.options.describe(&mut job, order.exposure_ev);
    job.view = view.word().to_owned();
    job.adaptive &= view == View::Final;
    job.adapter = rendered.adapter.clone();
    job.seed = order.seed;
    job.stop = again.map_or(order.stop, |again| again.stop);
    job.samples = rendered.samples.clone();
    job.denoiser = rendered.denoised.as_ref().map(|denoised| denoised.denoiser.clone());
    job.reach(rendered.spp, Some(&rendered.stop_reason), rendered.error.as_ref());
    job
}

/// Lobes of the document's objects, as one of the renderers counts them.
pub(super) fn lobes(scene: &Scene, of: impl Fn(&Material) -> LobeSet) -> LobeSet {
    scene.objects.iter().filter(|object| object.is_document).fold(LobeSet::EMPTY, |set, object| set.union(of(&object.material)))
}
