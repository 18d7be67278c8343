//! `burnish turntable`: pictures around the object, each until a rule ends it, resumed from stored samples.

use super::progress_line::ProgressLine;
use super::render::{peak_memory_bytes, relmse};
use super::scene_options::{LoadedScene, SceneOptions, finite, positive};
use super::{CliError, Messages, Outcome, interrupt, print_out};
use crate::export::Format;
use crate::offline::OfflineError;
use crate::offline::picture::Order;
use crate::offline::picture_options::PictureOptions;
use crate::offline::turntable::{
    Existing, Frame, KEEP_GIB, MAX_FRAMES, PROBES, Prediction, Turn, Turntable, TurntableOrder, duration,
};
use crate::offline::watch::Watch;
use crate::picture_job::Stop;
use clap::Args;
use serde_json::json;
use std::path::PathBuf;

/// Arguments of `burnish turntable`.
#[derive(Debug, Args)]
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
    #[arg(long, value_name = "N", default_value_t = PROBES)]
    probe: u32,
    /// Goes on with what is in the folder: frames that stopped short continue from their stored samples
    #[arg(long)]
    resume: bool,
    /// Only part K of N of the frames, every N-th; parts may run on several machines
    #[arg(long, value_name = "K/N", value_parser = shard)]
    shard: Option<(u32, u32)>,
    /// Format of the frames
    #[arg(long, value_name = "png|exr", default_value = "png", value_parser = format)]
    format: Format,
    /// Most GiB of samples that are stored for frames that stopped short
    #[arg(long, value_name = "GIB", default_value_t = KEEP_GIB, allow_hyphen_values = true, value_parser = positive)]
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

/// Renders the frames.
pub fn run(arguments: &TurntableArguments) -> Result<Outcome, CliError> {
    let mut messages = Messages::default();
    let order = arguments.order(arguments.scene.load(arguments.material.as_deref(), None, &mut messages)?);
    let existing = if arguments.resume { Existing::Resume } else { Existing::Refuse };
    let mut line = ProgressLine::new();
    let mut watch = Watch {
        is_cancelled: &interrupt::is_interrupted,
        warn: &mut |sentence| messages.warn(sentence),
        tell: &mut |step| {
            let left = step.remaining.map_or_else(String::new, |left| format!("; {} left", duration(left)));
            line.show(|| format!("{}{left}", step.text()));
        },
    };
    let mut table = Turntable::open(order, existing, &mut watch)?;
    let made = table.predict(arguments.probe, &mut watch).and_then(|prediction| {
        if let Some(prediction) = &prediction {
            eprintln!("{}", prediction.text(table.due().len()));
        }
        table.render(&mut watch, &mut |_, _| {})?;
        Ok(prediction)
    });
    line.clear();
    match made {
        Ok(prediction) => report(arguments, &table, prediction.as_ref(), &messages),
        Err(OfflineError::Cancelled) => {
            let (done, all) = table.progress();
            Err(CliError::Stopped(format!(
                "interrupted; {done} of {all} frames in {} are finished, and --resume goes on from there",
                arguments.out.display()
            )))
        }
        Err(error) => Err(error.into()),
    }
}

impl TurntableArguments {
    fn order(&self, loaded: LoadedScene) -> TurntableOrder {
        TurntableOrder {
            frame: Order {
                loaded,
                options: self.picture.clone(),
                exposure_ev: self.scene.exposure_ev(),
                seed: self.scene.seed,
                threads: self.scene.threads(),
                stop: Stop { spp: self.spp, seconds: self.time, relmse: self.error },
            },
            out: self.out.clone(),
            frames: self.frames,
            turn: self.turn,
            degrees: self.degrees,
            shard: self.shard,
            format: self.format,
            keep_gib: self.keep,
        }
    }
}

fn report(
    arguments: &TurntableArguments,
    table: &Turntable,
    prediction: Option<&Prediction>,
    messages: &Messages,
) -> Result<Outcome, CliError> {
    let frames: Vec<&Frame> = table.numbers().filter_map(|number| table.frame(number)).collect();
    let limited: Vec<&&Frame> = frames.iter().filter(|frame| frame.is_time_limited()).collect();
    if arguments.json {
        let object = json!({
            "out": arguments.out,
            "encoding": arguments.format.encoding(),
            "frames": frames,
            "time_limited": limited.iter().map(|frame| &frame.file).collect::<Vec<_>>(),
            "prediction": prediction.map(|prediction| prediction.json(frames.len())),
            "threads": arguments.scene.threads(),
            "seed": arguments.scene.seed,
            "peak_memory_bytes": peak_memory_bytes(),
            "warnings": messages.warnings(),
        });
        print_out(&object.to_string())?;
        return Ok(Outcome::Done);
    }
    let seconds: f64 = frames.iter().map(|frame| frame.seconds).sum();
    let (out, encoding) = (arguments.out.display(), arguments.format.encoding());
    let mut text = format!("{out}: {} frames in {} of rendering\n{encoding}\n", frames.len(), duration(seconds));
    if !limited.is_empty() {
        let names: Vec<String> = limited.iter().map(|frame| frame.text()).collect();
        text += &format!("{} frames hit the time limit; --resume continues them: {}\n", names.len(), names.join(", "));
    }
    print_out(&text)?;
    Ok(Outcome::Done)
}

fn turn(word: &str) -> Result<Turn, String> {
    let known = Turn::ALL.into_iter().find(|(_, known)| *known == word).map(|(turn, _)| turn);
    known.ok_or_else(|| "expected object or light".to_owned())
}

fn format(word: &str) -> Result<Format, String> {
    let known = [Format::Png, Format::Exr].into_iter().find(|format| format.ending() == word);
    known.ok_or_else(|| "expected png or exr".to_owned())
}

fn shard(text: &str) -> Result<(u32, u32), String> {
    let read = text.split_once('/').and_then(|(part, parts)| Some((part.trim().parse().ok()?, parts.trim().parse().ok()?)));
    read.filter(|(part, parts)| (1..=*parts).contains(part) && *parts <= MAX_FRAMES)
        .ok_or_else(|| "expected K/N with K from 1 to N, such as 2/4".to_owned())
}
