//! Pictures around the object: each until a rule ends it, predicted from a few of them, resumed from stored samples.

mod probe;
mod state;

pub use probe::{Prediction, duration};
pub use state::{Existing, Frame};

use super::OfflineError;
use super::develop::{Exposed, develop};
use super::final_picture::left_out;
use super::loaded_scene::LoadedScene;
use super::picture::{Order, View};
use super::picture_options::PictureOptions;
use super::watch::{Step, Watch};
use crate::export::{self, Format};
use crate::files::save_atomic;
use crate::picture_job::{PictureJob, folder_of};
use crate::scene_file::MAX_PIXELS;
use burnish_renderer::path::{self, Kept, Prepared, Rendering, Settings, StopReason, StopRules};
use serde_json::json;
use state::State;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Most frames of a turntable.
pub const MAX_FRAMES: u32 = 100_000;

/// Frames across the turn that are rendered a little to predict how long all take.
pub const PROBES: u32 = 5;

/// GiB of samples that are stored for frames that stopped short.
pub const KEEP_GIB: f64 = 16.0;

/// What turns.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Turn {
    /// The objects, counterclockwise seen from above.
    #[default]
    Object,
    /// The environment.
    Light,
}

impl Turn {
    /// Both with the words that options and files use.
    pub const ALL: [(Self, &'static str); 2] = [(Self::Object, "object"), (Self::Light, "light")];

    /// The word that options and files use.
    pub fn word(self) -> &'static str {
        Self::ALL[self as usize].1
    }
}

/// Which pictures are to be made.
#[derive(Clone, Debug)]
pub struct TurntableOrder {
    /// Each of them; the rules are those of a frame.
    pub frame: Order,
    /// Folder for the frames, made if it is not there.
    pub out: PathBuf,
    /// How many.
    pub frames: u32,
    /// What turns.
    pub turn: Turn,
    /// How far all frames together turn.
    pub degrees: f64,
    /// Only part `K` of `N` of the frames, every `N`-th.
    pub shard: Option<(u32, u32)>,
    /// Format of the frames.
    pub format: Format,
    /// Most GiB of samples that are stored for frames that stopped short.
    pub keep_gib: f64,
}

/// A turntable that was begun before.
#[derive(Clone, Debug)]
pub struct Begun {
    /// How many frames.
    pub frames: u32,
    /// What turns.
    pub turn: Turn,
    /// How far all frames together turn.
    pub degrees: f64,
    /// Format of the frames.
    pub format: Format,
    /// Columns and rows.
    pub size: [usize; 2],
    /// What the frames hold.
    pub options: PictureOptions,
    /// What is known of each frame, with its name.
    pub rows: Vec<(String, Option<Frame>)>,
}

impl Begun {
    /// That of a folder; `None` where it has none that can be read.
    pub fn of(folder: &Path) -> Option<Self> {
        let (settings, known) = State::read(folder)?;
        let frames = settings["frames"].as_u64().and_then(|n| u32::try_from(n).ok()).filter(|n| (1..=MAX_FRAMES).contains(n))?;
        let word = |key: &str| settings[key].as_str().map(str::to_owned);
        let (turn, format) = (word("turn")?, word("format")?);
        let format = [Format::Png, Format::Exr].into_iter().find(|known| known.ending() == format)?;
        let job: PictureJob = serde_json::from_value(settings["picture"].clone()).ok()?;
        let row = |number: u32| (name(number, frames, format), known.get(&number).cloned());
        Some(Self {
            frames,
            turn: Turn::ALL.into_iter().find(|(_, known)| *known == turn).map(|(turn, _)| turn)?,
            degrees: settings["degrees"].as_f64()?,
            format,
            size: job.size,
            options: PictureOptions::of_job(&job).ok()?,
            rows: (0..frames).map(row).collect(),
        })
    }
}

/// Name of a frame's file.
fn name(number: u32, frames: u32, format: Format) -> String {
    let digits = frames.to_string().len().max(4);
    format!("frame_{:0digits$}.{}", number + 1, format.ending())
}

/// A turntable with what is known of its frames.
pub struct Turntable {
    order: TurntableOrder,
    template: PictureJob,
    state: State,
}

impl Turntable {
    /// A turntable in the folder of the order. Says what frames will lack.
    pub fn open(order: TurntableOrder, existing: Existing, watch: &mut Watch<'_>) -> Result<Self, OfflineError> {
        let (frame, out) = (&order.frame, &order.out);
        let (width, height) = (frame.loaded.width, frame.loaded.height);
        frame.refuse(View::Final)?;
        if width * height > MAX_PIXELS {
            return Err(OfflineError::TooLarge { found: [width, height] });
        }
        std::fs::create_dir_all(out).map_err(|source| OfflineError::Folder { path: out.clone(), source })?;
        left_out(&frame.loaded.scene).into_iter().for_each(|sentence| (watch.warn)(sentence));
        let mut template = PictureJob::new();
        frame.loaded.describe(&mut template, folder_of(&out.join("frame")).as_deref());
        frame.options.describe(&mut template, frame.exposure_ev);
        template.seed = frame.seed;
        let settings = json!({
            "frames": order.frames,
            "turn": order.turn.word(),
            "degrees": order.degrees,
            "format": order.format.ending(),
            "shard": order.shard,
            "picture": template.json(),
        });
        let state = State::open(out, order.shard, settings, existing)?;
        Ok(Self { order, template, state })
    }

    /// Numbers of the frames of this part, from 0.
    pub fn numbers(&self) -> impl Iterator<Item = u32> + use<> {
        let (part, parts) = self.order.shard.unwrap_or((1, 1));
        (part - 1..self.order.frames).step_by(parts as usize)
    }

    /// Numbers of the frames that are to be rendered, or further.
    pub fn due(&self) -> Vec<u32> {
        self.numbers().filter(|number| !self.is_done(*number)).collect()
    }

    /// What is known of a frame.
    pub fn frame(&self, number: u32) -> Option<&Frame> {
        self.state.frame(number)
    }

    /// Frames of this part that are finished, and all.
    pub fn progress(&self) -> (usize, usize) {
        (self.numbers().filter(|number| self.is_done(*number)).count(), self.numbers().count())
    }

    /// Name of a frame's file in the folder.
    pub fn name(&self, number: u32) -> String {
        name(number, self.order.frames, self.order.format)
    }

    /// Renders some frames that are due a little and tells how long all of them will take; `None` where there are none. Their samples are the
    /// first of the frames'.
    pub fn predict(&mut self, probes: u32, watch: &mut Watch<'_>) -> Result<Option<Prediction>, OfflineError> {
        let rules = self.order.frame.rules();
        let (mut prediction, start) = (Prediction::new(rules), Instant::now());
        let chosen = probe::chosen(&self.due(), probes as usize);
        for (i, number) in chosen.iter().enumerate() {
            let prepared = self.order.frame.options.prepare(&self.scene(*number).scene, None);
            let part = Part { text: format!("probe {} of {}", i + 1, chosen.len()), place: i, count: chosen.len() };
            let rendering = self.expose(*number, &prepared, probe::rules(&rules), &part, start, watch)?;
            self.keep(*number, &rendering, watch)?;
            prediction.add(self.name(*number), &rendering);
        }
        Ok((!chosen.is_empty()).then_some(prediction))
    }

    /// Renders what is due, each frame written as it ends; `told` is called with its number when it begins, and again with what is known. Where it is cancelled, the frame in work has its samples stored.
    pub fn render(&mut self, watch: &mut Watch<'_>, told: &mut dyn FnMut(u32, Option<&Frame>)) -> Result<(), OfflineError> {
        let (due, start) = (self.due(), Instant::now());
        for (i, number) in due.iter().enumerate() {
            let part = Part { text: format!("frame {} of {}", i + 1, due.len()), place: i, count: due.len() };
            told(*number, None);
            let frame = self.render_frame(*number, &part, start, watch)?;
            self.state.finish(*number, frame.clone())?;
            told(*number, Some(&frame));
        }
        Ok(())
    }

    /// Where the samples of a frame that stopped short are kept.
    fn samples_path(&self, number: u32) -> PathBuf {
        self.order.out.join(self.name(number)).with_extension("samples")
    }

    fn is_done(&self, number: u32) -> bool {
        let is_there = |frame: &Frame| self.order.out.join(&frame.file).is_file();
        self.state.frame(number).is_some_and(|frame| is_there(frame) && frame.meets(&self.order.frame.rules()))
    }

    /// The scene of a frame.
    fn scene(&self, number: u32) -> LoadedScene {
        let deg = self.order.degrees * f64::from(number) / f64::from(self.order.frames);
        let mut loaded = self.order.frame.loaded.clone();
        match self.order.turn {
            Turn::Object => loaded.turned(deg),
            Turn::Light => {
                let light = &mut loaded.scene.environment;
                light.rotation_deg = (f64::from(light.rotation_deg) + deg).rem_euclid(360.0) as f32;
                loaded
            }
        }
    }

    /// Renders a frame from its stored samples on, until one of the rules; time counts from now on.
    fn expose(
        &mut self,
        number: u32,
        prepared: &Prepared,
        rules: StopRules,
        part: &Part,
        start: Instant,
        watch: &mut Watch<'_>,
    ) -> Result<Rendering, OfflineError> {
        if (watch.is_cancelled)() {
            return Err(OfflineError::Cancelled);
        }
        let path = self.samples_path(number);
        let kept = match std::fs::read(&path) {
            Ok(bytes) => match Kept::read(&bytes) {
                Ok(kept) => Some(kept),
                Err(error) => {
                    (watch.warn)(format!("{}: {error}; the frame is rendered anew", path.display()));
                    None
                }
            },
            Err(_) => None,
        };
        let seconds = rules.seconds.map(|seconds| seconds + kept.as_ref().map_or(0.0, Kept::seconds));
        let order = &self.order.frame;
        let settings = Settings {
            width: order.loaded.width,
            height: order.loaded.height,
            seed: order.seed,
            threads: order.threads,
            stop: StopRules { seconds, ..rules },
            is_adaptive: !order.options.no_adaptive,
        };
        let mut progress = |state: &path::Progress<'_>| {
            let mut step = Step::of(&part.text, state, &settings.stop);
            let share = (part.place as f64 + step.share.unwrap_or(0.0)) / part.count as f64;
            step.share = Some(share);
            step.remaining = (share > 0.0).then(|| start.elapsed().as_secs_f64() * (1.0 / share - 1.0));
            (watch.tell)(&step);
            !(watch.is_cancelled)()
        };
        let rendering = match kept {
            Some(kept) => kept
                .go_on(prepared, &settings, Instant::now(), &mut progress)
                .map_err(|error| OfflineError::unusable(format!("{}: {error}", path.display())))?,
            None => path::render_prepared(prepared, &settings, Instant::now(), &mut progress),
        };
        if rendering.stop_reason == StopReason::Cancelled {
            self.keep(number, &rendering, watch)?;
            return Err(OfflineError::Cancelled);
        }
        Ok(rendering)
    }

    /// Stores the samples of a frame that is not finished, if there is room.
    fn keep(&mut self, number: u32, rendering: &Rendering, watch: &mut Watch<'_>) -> Result<(), OfflineError> {
        if rendering.film.total_samples() == 0 {
            return Ok(());
        }
        let (path, bytes) = (self.samples_path(number), rendering.keep());
        let (most, out) = (self.order.keep_gib, &self.order.out);
        if state::stored_bytes(out, &path) as f64 + bytes.len() as f64 > most * (1u64 << 30) as f64 {
            (watch.warn)(format!(
                "{}: samples are not stored beyond {most} GiB; going on renders such frames anew",
                out.display()
            ));
            return Ok(());
        }
        save_atomic(&path, &bytes).map_err(OfflineError::unusable)
    }

    fn render_frame(&mut self, number: u32, part: &Part, start: Instant, watch: &mut Watch<'_>) -> Result<Frame, OfflineError> {
        let rules = self.order.frame.rules();
        let loaded = self.scene(number);
        let prepared = self.order.frame.options.prepare(&loaded.scene, None);
        let rendering = self.expose(number, &prepared, rules, part, start, watch)?;
        let (order, film) = (&self.order.frame, &rendering.film);
        let exposed = Exposed { scene: &loaded.scene, prepared: &prepared, film, seed: order.seed, threads: order.threads };
        let developed = develop(&exposed, &order.options, watch);
        if matches!(developed, Err(OfflineError::Cancelled)) {
            self.keep(number, &rendering, watch)?;
        }
        let (mut picture, denoised) = developed?;
        let mut job = self.template.clone();
        job.scene.rotation_deg = loaded.scene.environment.rotation_deg;
        job.scene.turn_deg = loaded.turn_deg();
        job.stop = self.order.frame.stop;
        job.samples = vec![film.total_samples()];
        job.denoiser = denoised.map(|denoised| denoised.denoiser);
        job.reach(film.spp(), Some(rendering.stop_reason.word()), rendering.error.as_ref());
        picture.job = Some(job.json());
        let name = self.name(number);
        let display = self.order.frame.options.display(self.order.frame.exposure_ev);
        export::write(&self.order.out.join(&name), &picture, display).map_err(OfflineError::Export)?;
        if rendering.nonfinite > 0 {
            let count = rendering.nonfinite;
            (watch.warn)(format!("{name}: {count} contributions were negative or not finite and were left out"));
        }
        if rendering.stop_reason == StopReason::Time {
            self.keep(number, &rendering, watch)?;
        } else {
            // There are none where the frame was never stopped.
            let _ = std::fs::remove_file(self.samples_path(number));
        }
        Ok(Frame::new(name, &rendering, &rules))
    }
}

/// Which of several frames is being rendered.
struct Part {
    text: String,
    place: usize,
    count: usize,
}
