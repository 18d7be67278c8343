//! Options of small pictures, and making those that a library lacks: shared by all commands that need pictures.

use super::Read;
use crate::cli::material_argument::LoadedMaterial;
use crate::cli::progress_line::ProgressLine;
use crate::cli::render::{error_text, relmse, transform};
use crate::cli::scene_options::{self, SceneOptions, positive};
use crate::cli::{CliError, Messages, interrupt};
use crate::library::entry::Entry;
use crate::library::maker::{Limits, Maker};
use crate::library::setup::{DEFAULT_RELMSE, DEFAULT_SECONDS, DEFAULT_SIDE, Frame, Made, Setup, Stage};
use crate::library::shelf::{Shelf, State};
use burnish_assets::{ENVIRONMENTS, SHAPES};
use burnish_renderer::path::Progress;
use burnish_renderer::tonemap::{Display, DisplayTransform};
use clap::Args;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// What small pictures show, and when they are done.
#[derive(Debug, Args)]
pub struct SmallPictureOptions {
    /// A picture is done when its estimated relMSE is below this; a percentage is its square root [default: 2%]
    #[arg(long, value_name = "RELMSE", allow_hyphen_values = true, value_parser = relmse)]
    error: Option<f64>,
    /// A picture is also done after this many seconds; it is named then [default: 120]
    #[arg(long, value_name = "SECONDS", allow_hyphen_values = true, value_parser = positive)]
    time_limit: Option<f64>,
    /// How radiance becomes colours
    #[arg(long, value_name = "neutral|agx|aces|standard", default_value = "neutral", value_parser = transform)]
    display_transform: DisplayTransform,
    /// What is drawn, and how large.
    #[command(flatten)]
    pub scene: SceneOptions,
}

impl SmallPictureOptions {
    /// How pictures are taken.
    pub fn setup(&self, messages: &mut Messages) -> Result<Setup, CliError> {
        let options = &self.scene;
        let loaded = options.load(None, Some(LoadedMaterial::default()), messages)?;
        let name_of = |text: &Option<String>, mut known: Vec<&str>| match text {
            _ if options.scene.is_some() && text.is_none() => None,
            None => known.first().map(|name| (*name).to_owned()),
            Some(text) => known.drain(..).find(|name| name.eq_ignore_ascii_case(text)).map(str::to_owned),
        };
        let stage = Stage {
            scene: loaded.scene,
            shape: name_of(&options.mesh, SHAPES.iter().map(|def| def.name).collect()),
            backdrop: options.backdrop,
            environment: name_of(&options.environment, ENVIRONMENTS.iter().map(|def| def.name).collect()),
            has_unit: options.scene.is_none() || options.unit_mm.is_some(),
        };
        let is_standard = options.scene.is_none() && options.size.is_none();
        let (width, height) = if is_standard { (DEFAULT_SIDE, DEFAULT_SIDE) } else { (loaded.width, loaded.height) };
        let display = Display { exposure_ev: options.exposure_ev(), transform: self.display_transform };
        let frame = Frame { width, height, relmse: self.error.unwrap_or(DEFAULT_RELMSE), seed: options.seed, display };
        let set = options.set.iter().map(|assignment| (assignment.property, assignment.value)).collect();
        Ok(Setup::new(stage, frame, set))
    }

    /// Makes and keeps those pictures of entries whose state is among `only`. What became of each entry, and whether nobody interrupted it.
    pub fn make<'a>(
        &self,
        root: &Path,
        entries: &'a [Arc<Entry>],
        only: &[State],
        setup: &Setup,
        shelf: &mut Shelf,
        messages: &mut Messages,
    ) -> (Vec<Row<'a>>, bool) {
        let is_chosen =
            |entry: &Entry, shelf: &Shelf| entry.problem.is_none() && only.contains(&shelf.state(entry, setup.digest()));
        let mut left = entries.iter().filter(|entry| is_chosen(entry, shelf)).count();
        let limits = Limits { seconds: self.time_limit.unwrap_or(DEFAULT_SECONDS), threads: self.scene.threads() };
        let mut maker = Maker::new(root, setup, limits);
        let (mut done, mut seconds) = (0, 0.0);
        let mut line = ProgressLine::new();
        let mut rows: Vec<Row> = Vec::with_capacity(entries.len());
        let mut is_whole = true;
        for entry in entries {
            let before = shelf.state(entry, setup.digest());
            let mut row = Row { entry, before, made: None, problem: entry.problem.clone() };
            if is_chosen(entry, shelf) {
                let total = done + left;
                let mut go_on = |progress: &Progress<'_>| {
                    line.show(|| {
                        let error = progress.error.as_ref().map_or_else(String::new, |error| format!(", {}", error_text(error)));
                        let remaining = remaining(done, left, seconds, progress.seconds);
                        format!("{} of {total}: {}{error}{remaining}", done + 1, entry.path.display())
                    });
                    !interrupt::is_interrupted()
                };
                let made = if interrupt::is_interrupted() { Ok(None) } else { maker.make(entry, shelf, &mut go_on) };
                match made {
                    Ok(Some((made, missing))) => {
                        missing.iter().for_each(|sentence| messages.warn_about(&root.join(&entry.path), sentence));
                        done += 1;
                        seconds += made.seconds;
                        row.made = Some(made);
                    }
                    Ok(None) => is_whole = false,
                    Err(problem) => row.problem = Some(problem),
                }
                left -= 1;
            }
            if !is_whole {
                break;
            }
            rows.push(row);
        }
        line.clear();
        (rows, is_whole)
    }
}

/// Which small pictures a command uses that puts them into something of its own.
#[derive(Debug, Args)]
pub struct ShownPictures {
    /// Makes no pictures: those that are missing are left empty, and old ones are shown
    #[arg(long)]
    no_render: bool,
    /// Folder of the pictures, as `thumbnails --out` names it [default: the cache of this user]
    #[arg(long, value_name = "DIR")]
    pub pictures: Option<PathBuf>,
    /// What the pictures show, and when they are done.
    #[command(flatten)]
    pub making: SmallPictureOptions,
}

impl ShownPictures {
    /// States of pictures that are made first. An error if they could not be kept.
    pub fn due(&self, read: &Read) -> Result<&'static [State], CliError> {
        if self.no_render {
            return Ok(&[]);
        }
        refuse_no_place(read, "--pictures", self.pictures.as_deref())?;
        Ok(&[State::Missing, State::Stale])
    }
}

/// What became of one file.
pub struct Row<'a> {
    /// The file.
    pub entry: &'a Entry,
    /// Its picture as it was.
    pub before: State,
    /// `None` if nothing was made.
    pub made: Option<Made>,
    /// Why there is no picture.
    pub problem: Option<String>,
}

impl Row<'_> {
    /// For `--json`.
    pub fn json(&self, setup: &Setup, shelf: &Shelf) -> Value {
        let state = shelf.state(self.entry, setup.digest());
        let made = self.made.as_ref();
        json!({
            "path": self.entry.path.to_string_lossy(),
            "hash": self.entry.content,
            "look": self.entry.look,
            "state": state.word(),
            "state_before": self.before.word(),
            "file": (state == State::Fresh).then(|| shelf.path(self.entry.look, setup.digest())),
            "seconds": made.map(|made| made.seconds),
            "spp": made.map(|made| made.spp),
            "relmse_estimate": made.and_then(|made| made.relmse),
            "stop_reason": made.map(|made| made.stop_reason.word()),
            "problem": self.problem,
        })
    }
}

/// How many pictures were made.
pub fn made(rows: &[Row<'_>]) -> usize {
    rows.iter().filter(|row| row.made.is_some()).count()
}

/// An error if pictures could not be kept, told before minutes of rendering. `option` names the folder that the user may give.
pub fn refuse_no_place(read: &Read, option: &str, folder: Option<&Path>) -> Result<(), CliError> {
    if folder.is_none() && read.places.pictures.is_none() {
        return Err(CliError::unusable(format!(
            "{option}: expected a folder for the pictures, because this user has no cache folder"
        )));
    }
    read.shelf.probe(1).map_err(CliError::unusable)
}

/// How long all pictures will take yet, if the others take as long as those that are done: `, about 5 min left`.
fn remaining(done: usize, left: usize, seconds: f64, now: f64) -> String {
    if done == 0 {
        return String::new();
    }
    let mean = seconds / done as f64;
    let seconds = (mean - now).max(0.0) + mean * left.saturating_sub(1) as f64;
    match seconds {
        ..90.0 => format!(", about {seconds:.0} s left"),
        ..5400.0 => format!(", about {:.0} min left", seconds / 60.0),
        _ => format!(", about {:.1} h left", seconds / 3600.0),
    }
}

/// One side of a square, or both, for options.
pub fn picture_size(text: &str) -> Result<(usize, usize), String> {
    if text.contains(['x', 'X']) { scene_options::size(text) } else { scene_options::size(&format!("{text}x{text}")) }
}
