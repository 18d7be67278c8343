//! `burnish turntable`: pictures around the object, each until a rule ends it, resumed from stored samples.

mod probe;
mod state;

use super::develop::{Exposed, develop};
use super::final_picture::left_out;
use super::picture_options::{PictureOptions, relmse, stop_rules};
use super::progress_line::ProgressLine;
use super::render::error_text;
use super::scene_options::{LoadedScene, SceneOptions, finite, positive};
use super::{CliError, Messages, Outcome, interrupt, print_out};
use crate::export::{self, Format};
use crate::picture_job::{PictureJob, Stop, folder_of};
use burnish_renderer::path::{self, Kept, Prepared, Rendering, Settings, StopReason, StopRules};
use clap::Args;
use probe::Prediction;
use serde_json::json;
use state::{Frame, State};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Most frames of a turntable.
const MAX_FRAMES: u32 = 100_000;

/// Arguments of `burnish turntable`.
#[derive(Debug, Default, Args)]
pub struct TurntableArguments {
    /// Material file (.asm.ron), preset:NAME, or a picture of ours; may be left out with --scene
    #[arg(value_name = "MATERIAL")]
    material: Option<String>,
    /// Folder for the frames, made if it is not there
    #[arg(long, value_name = "DIR", required = true)]
    out: PathBuf,
    /// How many frames
    #[arg(long, value_name = "N", required = true, allow_hyphen_values = true, value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_FRAMES)))]
    frames: u32,
    /// What turns, counterclockwise seen from above; the camera stays
    #[arg(long, value_name = "object|light", default_value = "object", value_parser = turn)]
    turn: Turn,
    /// How far all frames together turn
    #[arg(long, value_name = "DEG", default_value_t = 360.0, allow_hyphen_values = true, value_parser = finite)]
    degrees: f64,
    /// Stops a frame after this many samples per pixel [default without any stop rule: 256]
    #[arg(long, value_name = "N", allow_hyphen_values = true, value_parser = clap::value_parser!(u32).range(1..))]
    spp: Option<u32>,
    /// Stops a frame after this many seconds of rendering; with --resume, this many more
    #[arg(long, value_name = "SECONDS", allow_hyphen_values = true, value_parser = positive)]
    time: Option<f64>,
    /// Stops a frame when its estimated relMSE is below this; a percentage is its square root (2% = 0.0004)
    #[arg(long, value_name = "RELMSE", allow_hyphen_values = true, value_parser = relmse)]
    error: Option<f64>,
    /// Frames across the turn that are rendered a little first, to predict how long all take
    #[arg(long, value_name = "N", default_value_t = 5)]
    probe: u32,
    /// Goes on with what is in the folder: frames that stopped short continue from their stored samples
    #[arg(long)]
    resume: bool,
    /// Only part K of N of the frames, every N-th; parts may run on several machines
    #[arg(long, value_name = "K/N", value_parser = shard)]
    shard: Option<(u32, u32)>,
    /// Format of the frames
    #[arg(long, value_name = "png|exr", default_value = "png", value_parser = format)]
    format: Frames,
    /// Most GiB of samples that are stored for frames that stopped short
    #[arg(long, value_name = "GIB", default_value_t = 16.0, allow_hyphen_values = true, value_parser = positive)]
    keep: f64,
    /// Prints one JSON object
    #[arg(long)]
    json: bool,
    /// What the frames hold.
    #[command(flatten)]
    picture: PictureOptions,
    /// What is drawn, and how large.
    #[command(flatten)]
    scene: SceneOptions,
}

/// What turns.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Turn {
    #[default]
    Object,
    Light,
}

/// Format of the frames.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Frames {
    #[default]
    Png,
    Exr,
}

impl Frames {
    fn ending(self) -> &'static str {
        if self == Self::Png { "png" } else { "exr" }
    }
}

/// Renders the frames.
pub fn run(arguments: &TurntableArguments) -> Result<Outcome, CliError> {
    let mut messages = Messages::default();
    let loaded = arguments.scene.load(arguments.material.as_deref(), None, &mut messages)?;
    std::fs::create_dir_all(&arguments.out)
        .map_err(|error| CliError::unusable(format!("--out: {}: {error}", arguments.out.display())))?;
    for sentence in left_out(&loaded.scene) {
        messages.warn(sentence);
    }
    let mut template = PictureJob::new();
    loaded.describe(&mut template, folder_of(&arguments.out.join("frame")).as_deref());
    arguments.picture.describe(&mut template, arguments.scene.exposure_ev());
    template.seed = arguments.scene.seed;
    let settings = json!({
        "frames": arguments.frames,
        "turn": if arguments.turn == Turn::Object { "object" } else { "light" },
        "degrees": arguments.degrees,
        "format": arguments.format.ending(),
        "shard": arguments.shard,
        "picture": template.json(),
    });
    let state = State::open(&arguments.out, arguments.shard, settings, arguments.resume)?;
    let mut table = Table { arguments, loaded, template, state, messages };
    match table.render() {
        Err(CliError::Interrupted) => {
            let (done, all) = table.progress();
            Err(CliError::Stopped(format!(
                "interrupted; {done} of {all} frames in {} are finished, and --resume goes on from there",
                arguments.out.display()
            )))
        }
        other => other,
    }
}

/// A turntable under way.
struct Table<'a> {
    arguments: &'a TurntableArguments,
    loaded: LoadedScene,
    template: PictureJob,
    state: State,
    messages: Messages,
}

impl Table<'_> {
    fn render(&mut self) -> Result<Outcome, CliError> {
        let due: Vec<u32> = self.numbers().filter(|number| !self.is_done(*number)).collect();
        let prediction = self.probe(&due)?;
        if let Some(prediction) = &prediction {
            eprintln!("{}", prediction.text(due.len()));
        }
        let start = Instant::now();
        for (i, number) in due.iter().enumerate() {
            interrupt::check()?;
            let left = (i > 0).then(|| start.elapsed().as_secs_f64() / i as f64 * (due.len() - i) as f64);
            let left = left.map_or_else(String::new, |left| format!(", {} left", probe::duration(left)));
            self.frame(*number, &format!("frame {} of {}{left}: ", i + 1, due.len()))?;
        }
        self.report(prediction.as_ref())?;
        Ok(Outcome::Done)
    }

    /// Numbers of the frames of this part.
    fn numbers(&self) -> impl Iterator<Item = u32> + use<> {
        let (part, parts) = self.arguments.shard.unwrap_or((1, 1));
        (part - 1..self.arguments.frames).step_by(parts as usize)
    }

    fn name(&self, number: u32) -> String {
        let digits = self.arguments.frames.to_string().len().max(4);
        format!("frame_{:0digits$}.{}", number + 1, self.arguments.format.ending())
    }

    /// Where the samples of a frame that stopped short are kept.
    fn samples_path(&self, number: u32) -> PathBuf {
        self.arguments.out.join(self.name(number)).with_extension("samples")
    }

    fn rules(&self) -> StopRules {
        stop_rules(self.arguments.spp, self.arguments.time, self.arguments.error)
    }

    fn is_done(&self, number: u32) -> bool {
        let is_there = |frame: &Frame| self.arguments.out.join(&frame.file).is_file();
        self.state.frame(number).is_some_and(|frame| is_there(frame) && frame.meets(&self.rules()))
    }

    /// Frames that are finished, and all.
    fn progress(&self) -> (usize, usize) {
        (self.numbers().filter(|number| self.is_done(*number)).count(), self.numbers().count())
    }

    /// The scene of a frame.
    fn scene(&self, number: u32) -> LoadedScene {
        let deg = self.arguments.degrees * f64::from(number) / f64::from(self.arguments.frames);
        let mut loaded = self.loaded.clone();
        match self.arguments.turn {
            Turn::Object => loaded.turned(deg),
            Turn::Light => {
                let light = &mut loaded.scene.environment;
                light.rotation_deg = (f64::from(light.rotation_deg) + deg).rem_euclid(360.0) as f32;
                loaded
            }
        }
    }

    /// Renders a frame from its stored samples on, until one of the rules; time counts from now on.
    fn expose(&mut self, number: u32, prepared: &Prepared, rules: StopRules, text: &str) -> Result<Rendering, CliError> {
        let path = self.samples_path(number);
        let kept = match std::fs::read(&path) {
            Ok(bytes) => match Kept::read(&bytes) {
                Ok(kept) => Some(kept),
                Err(error) => {
                    self.messages.warn(format!("{}: {error}; the frame is rendered anew", path.display()));
                    None
                }
            },
            Err(_) => None,
        };
        let seconds = rules.seconds.map(|seconds| seconds + kept.as_ref().map_or(0.0, Kept::seconds));
        let settings = Settings {
            width: self.loaded.width,
            height: self.loaded.height,
            seed: self.arguments.scene.seed,
            threads: self.arguments.scene.threads(),
            stop: StopRules { seconds, ..rules },
            is_adaptive: !self.arguments.picture.no_adaptive,
        };
        let mut line = ProgressLine::new();
        let mut progress = |state: &path::Progress<'_>| {
            let error = state.error.as_ref().map_or_else(String::new, |error| format!(", {}", error_text(error)));
            line.show(|| format!("{text}{} spp in {:.1} s{error}", state.film.spp(), state.seconds));
            !interrupt::is_interrupted()
        };
        let rendering = match kept {
            Some(kept) => kept
                .go_on(prepared, &settings, Instant::now(), &mut progress)
                .map_err(|error| CliError::unusable(format!("{}: {error}", path.display())))?,
            None => path::render_prepared(prepared, &settings, Instant::now(), &mut progress),
        };
        line.clear();
        if rendering.stop_reason == StopReason::Cancelled {
            self.keep(number, &rendering)?;
            return Err(CliError::Interrupted);
        }
        Ok(rendering)
    }

    /// Stores the samples of a frame that is not finished, if there is room.
    fn keep(&mut self, number: u32, rendering: &Rendering) -> Result<(), CliError> {
        if rendering.film.total_samples() == 0 {
            return Ok(());
        }
        let (path, bytes) = (self.samples_path(number), rendering.keep());
        let room = self.arguments.keep * (1u64 << 30) as f64;
        if state::stored_bytes(&self.arguments.out, &path) as f64 + bytes.len() as f64 > room {
            let most = self.arguments.keep;
            self.messages.warn(format!(
                "{}: samples are not stored beyond --keep {most} GiB; --resume renders such frames anew",
                self.arguments.out.display()
            ));
            return Ok(());
        }
        crate::files::save_atomic(&path, &bytes).map_err(CliError::unusable)
    }

    fn frame(&mut self, number: u32, text: &str) -> Result<(), CliError> {
        let rules = self.rules();
        let loaded = self.scene(number);
        let prepared = self.arguments.picture.prepare(&loaded.scene, None);
        let rendering = self.expose(number, &prepared, rules, text)?;
        let film = &rendering.film;
        let (seed, threads) = (self.arguments.scene.seed, self.arguments.scene.threads());
        let exposed = Exposed { scene: &loaded.scene, prepared: &prepared, film, seed, threads };
        let developed = develop(&exposed, &self.arguments.picture, &mut self.messages);
        if matches!(developed, Err(CliError::Interrupted)) {
            self.keep(number, &rendering)?;
        }
        let (mut picture, denoised) = developed?;
        let mut job = self.template.clone();
        job.scene.rotation_deg = loaded.scene.environment.rotation_deg;
        job.scene.turn_deg = loaded.turn_deg();
        job.stop = Stop { spp: self.arguments.spp, seconds: self.arguments.time, relmse: self.arguments.error };
        job.samples = vec![film.total_samples()];
        job.denoiser = denoised.map(|denoised| denoised.denoiser);
        job.reach(film.spp(), Some(rendering.stop_reason.word()), rendering.error.as_ref());
        picture.job = Some(job.json());
        let name = self.name(number);
        let display = self.arguments.picture.display(self.arguments.scene.exposure_ev());
        export::write(&self.arguments.out.join(&name), &picture, display).map_err(CliError::unusable)?;
        if rendering.nonfinite > 0 {
            let count = rendering.nonfinite;
            self.messages.warn(format!("{name}: {count} contributions were negative or not finite and were left out"));
        }
        if rendering.stop_reason == StopReason::Time {
            self.keep(number, &rendering)?;
        } else {
            // There are none where the frame was never stopped.
            let _ = std::fs::remove_file(self.samples_path(number));
        }
        self.state.finish(number, Frame::new(name, &rendering, &rules))
    }

    /// Renders some frames a little and tells how long all that are due will take. Their samples are the first of the frames'.
    fn probe(&mut self, due: &[u32]) -> Result<Option<Prediction>, CliError> {
        let rules = self.rules();
        let mut prediction = Prediction::new(rules);
        let chosen = probe::chosen(due, self.arguments.probe as usize);
        for (i, number) in chosen.iter().enumerate() {
            interrupt::check()?;
            let loaded = self.scene(*number);
            let prepared = self.arguments.picture.prepare(&loaded.scene, None);
            let text = format!("probe {} of {}: ", i + 1, chosen.len());
            let rendering = self.expose(*number, &prepared, probe::rules(&rules), &text)?;
            self.keep(*number, &rendering)?;
            prediction.add(self.name(*number), &rendering);
        }
        Ok((!chosen.is_empty()).then_some(prediction))
    }

    fn report(&self, prediction: Option<&Prediction>) -> Result<(), CliError> {
        let frames: Vec<&Frame> = self.numbers().filter_map(|number| self.state.frame(number)).collect();
        let limited: Vec<&&Frame> = frames.iter().filter(|frame| frame.stop_reason == StopReason::Time.word()).collect();
        if self.arguments.json {
            let object = json!({
                "out": self.arguments.out,
                "encoding": Format::of(Path::new(&self.name(0))).map(Format::encoding),
                "frames": frames,
                "time_limited": limited.iter().map(|frame| &frame.file).collect::<Vec<_>>(),
                "prediction": prediction.map(|prediction| prediction.json(frames.len())),
                "threads": self.arguments.scene.threads(),
                "seed": self.arguments.scene.seed,
                "peak_memory_bytes": super::render::peak_memory_bytes(),
                "warnings": self.messages.warnings(),
            });
            return print_out(&object.to_string());
        }
        let encoding = Format::of(Path::new(&self.name(0))).map_or("", Format::encoding);
        let seconds: f64 = frames.iter().map(|frame| frame.seconds).sum();
        let out = self.arguments.out.display();
        let mut text = format!("{out}: {} frames in {} of rendering\n{encoding}\n", frames.len(), probe::duration(seconds));
        if !limited.is_empty() {
            let names: Vec<String> = limited.iter().map(|frame| frame.text()).collect();
            text += &format!("{} frames hit the time limit; --resume continues them: {}\n", names.len(), names.join(", "));
        }
        print_out(&text)
    }
}

fn turn(word: &str) -> Result<Turn, String> {
    match word {
        "object" => Ok(Turn::Object),
        "light" => Ok(Turn::Light),
        _ => Err("expected object or light".to_owned()),
    }
}

fn format(word: &str) -> Result<Frames, String> {
    match word {
        "png" => Ok(Frames::Png),
        "exr" => Ok(Frames::Exr),
        _ => Err("expected png or exr".to_owned()),
    }
}

fn shard(text: &str) -> Result<(u32, u32), String> {
    let read = text.split_once('/').and_then(|(part, parts)| Some((part.trim().parse().ok()?, parts.trim().parse().ok()?)));
    read.filter(|(part, parts)| (1..=*parts).contains(part) && *parts <= MAX_FRAMES)
        .ok_or_else(|| "expected K/N with K from 1 to N, such as 2/4".to_owned())
}
