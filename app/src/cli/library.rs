//! `burnish library`: a folder of materials as a library: what is in it, small pictures of it, and whether it can be handed out.
//!
//! A file that cannot be used is a finding and does not keep the others from being looked at. What is known of a library is kept in the cache
//! folder of the user, and with it small pictures unless `--out` names another folder.

use super::library_check::{self, LibraryCheckArguments};
use super::material_argument::LoadedMaterial;
use super::progress_line::ProgressLine;
use super::render::{error_text, relmse, transform};
use super::scene_options::{self, SceneOptions, positive};
use super::{CliError, Messages, Outcome, interrupt, print_out};
use crate::library::digest::Digest;
use crate::library::entry::Entry;
use crate::library::index::Index;
use crate::library::query::{Facts, Query};
use crate::library::scan::{Event, Progress, Scan, Scanned};
use crate::library::setup::{self, DEFAULT_RELMSE, DEFAULT_SECONDS, DEFAULT_SIDE, Frame, Made, Setup, Stage};
use crate::library::shelf::{MAX_ORPHAN_BYTES, Shelf, State};
use crate::library::{LibraryPlaces, marks::Marks};
use crate::places::Places;
use burnish_assets::{ENVIRONMENTS, SHAPES};
use burnish_renderer::path::{Prepared, StopReason};
use burnish_renderer::tonemap::{Display, DisplayTransform};
use clap::{Args, Subcommand};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

/// Arguments of `burnish library`.
#[derive(Debug, Args)]
pub struct LibraryArguments {
    #[command(subcommand)]
    action: Action,
}

#[derive(Debug, Subcommand)]
enum Action {
    /// Lists the materials in a folder and below; only files that have changed are read
    Index(IndexArguments),
    /// Makes small pictures of the materials in a folder and below
    #[command(mut_arg("size", |size| {
        size.value_name("SIDE|WxH").value_parser(picture_size).help("Size of the pictures in pixels [default: 256]")
    }))]
    Thumbnails(Box<ThumbnailsArguments>),
    /// Checks the materials in a folder and below before they are handed out, and compares them with an earlier release
    Check(LibraryCheckArguments),
}

/// Arguments of `burnish library index`.
#[derive(Debug, Args)]
pub struct IndexArguments {
    /// Folder of materials
    #[arg(value_name = "DIR")]
    folder: PathBuf,
    /// Lists only what matches, such as `metal rough<0.3 tag:measured -glass is:stale`
    #[arg(long, value_name = "QUERY", allow_hyphen_values = true)]
    search: Option<String>,
    /// Prints one JSON object
    #[arg(long)]
    json: bool,
}

/// Arguments of `burnish library thumbnails`.
#[derive(Debug, Args)]
pub struct ThumbnailsArguments {
    /// Folder of materials
    #[arg(value_name = "DIR")]
    folder: PathBuf,
    /// Which pictures are made, by what is there already
    #[arg(long, value_name = "missing,stale,fresh", value_delimiter = ',', default_value = "missing,stale", value_parser = state)]
    only: Vec<State>,
    /// Makes part K of N, from 1: parts have no file in common, and all parts together are all files
    #[arg(long, value_name = "K/N", default_value = "1/1", value_parser = shard)]
    shard: (u32, u32),
    /// A picture is done when its estimated relMSE is below this; a percentage is its square root [default: 2%]
    #[arg(long, value_name = "RELMSE", allow_hyphen_values = true, value_parser = relmse)]
    error: Option<f64>,
    /// A picture is also done after this many seconds; it is named then [default: 120]
    #[arg(long, value_name = "SECONDS", allow_hyphen_values = true, value_parser = positive)]
    time_limit: Option<f64>,
    /// Folder for the pictures, named by what they show [default: the cache of this user]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// How radiance becomes colours
    #[arg(long, value_name = "neutral|agx|aces|standard", default_value = "neutral", value_parser = transform)]
    display_transform: DisplayTransform,
    /// Prints one JSON object
    #[arg(long)]
    json: bool,
    /// What is drawn, and how large.
    #[command(flatten)]
    scene: SceneOptions,
}

/// Lists, or makes pictures.
pub fn run(arguments: &LibraryArguments) -> Result<Outcome, CliError> {
    match &arguments.action {
        Action::Index(arguments) => index(arguments),
        Action::Thumbnails(arguments) => thumbnails(arguments),
        Action::Check(arguments) => library_check::run(arguments),
    }
}

/// A library that was read.
pub(super) struct Read {
    pub scanned: Scanned,
    places: LibraryPlaces,
    pub shelf: Shelf,
    pub seconds: f64,
}

/// Reads the library in a folder, and keeps what is known of it. Pictures are those in `out`, else those in the cache.
pub(super) fn read(folder: &Path, threads: usize, out: Option<&Path>, messages: &mut Messages) -> Result<Read, CliError> {
    let start = Instant::now();
    let places = LibraryPlaces::of(folder, &Places::find());
    let shelf = out.or(places.pictures.as_deref()).map_or_else(Shelf::default, Shelf::open);
    let old = places.index.as_deref().map_or_else(Index::default, |path| Index::load(path, folder));
    let line = Mutex::new(ProgressLine::new());
    let show = |event| {
        if let Event::Progress(Progress { done, total }) = event {
            line.lock().unwrap_or_else(PoisonError::into_inner).show(|| format!("reading: {done} of {total}"));
        }
    };
    let scan = Scan {
        root: folder,
        old: &old,
        threads,
        has_picture: &|look| shelf.has_any(look),
        is_cancelled: &interrupt::is_interrupted,
        tell: &show,
    };
    let scanned = scan.run().map_err(CliError::unusable)?;
    line.into_inner().unwrap_or_else(PoisonError::into_inner).clear();
    if let Some(path) = places.index.as_ref().filter(|_| scanned.is_changed)
        && let Err(error) = scanned.index.save(path)
    {
        messages.warn(error.to_string());
    }
    interrupt::check()?;
    scanned.problems.iter().for_each(|problem| messages.warn(problem));
    if scanned.index.entries.is_empty() {
        return Err(CliError::unusable(format!("{}: expected .asm.ron files in this folder, found none", folder.display())));
    }
    Ok(Read { scanned, places, shelf, seconds: start.elapsed().as_secs_f64() })
}

fn index(arguments: &IndexArguments) -> Result<Outcome, CliError> {
    let mut messages = Messages::default();
    let query = Query::parse(arguments.search.as_deref().unwrap_or_default());
    if let Some(problem) = query.problem() {
        return Err(CliError::unusable(format!("--search: {problem}")));
    }
    let read = read(&arguments.folder, SceneOptions::default().threads(), None, &mut messages)?;
    let setup = standard_setup()?;
    let (marks, problem) = read.places.marks.as_deref().map_or_else(Default::default, Marks::load);
    problem.into_iter().for_each(|problem| messages.warn(problem));

    let entries = &read.scanned.index.entries;
    let facts = |entry: &Entry| Facts { state: read.shelf.state(entry, setup), is_favourite: marks.is_favourite(&entry.path) };
    let start = Instant::now();
    let found: Vec<&Arc<Entry>> = entries.iter().filter(|entry| query.matches(entry, || facts(entry))).collect();
    let search_seconds = start.elapsed().as_secs_f64();
    let broken = entries.iter().filter(|entry| entry.problem.is_some()).count();
    if arguments.json {
        let rows: Vec<Value> = found.iter().map(|entry| index_row(entry, facts(entry).state)).collect();
        print_out(
            &json!({
                "files": entries.len(),
                "read": read.scanned.read,
                "images_read": read.scanned.images_read,
                "broken": broken,
                "seconds": read.seconds,
                "search_seconds": search_seconds,
                "rows": rows,
                "warnings": messages.warnings(),
            })
            .to_string(),
        )?;
    } else {
        let mut lines = String::new();
        for entry in &found {
            let path = entry.path.display();
            lines += &match &entry.problem {
                Some(problem) => format!("{path}: {problem}\n"),
                None => format!("{path}: {} ({})\n", entry.name, facts(entry).state.word()),
            };
        }
        let (files, read_files) = (entries.len(), read.scanned.read);
        lines += &format!(
            "{} of {files} files, {broken} that cannot be used; {read_files} read in {:.2} s",
            found.len(),
            read.seconds
        );
        print_out(&lines)?;
    }
    Ok(if broken > 0 { Outcome::Findings } else { Outcome::Done })
}

/// How small pictures are taken unless something says otherwise.
pub(super) fn standard_setup() -> Result<Digest, CliError> {
    let stage = Stage::standard().ok_or_else(|| CliError::unusable("there is no mesh or no environment"))?;
    Ok(Setup::new(stage, Frame::default(), Vec::new()).digest())
}

fn index_row(entry: &Entry, state: State) -> Value {
    json!({
        "path": entry.path.to_string_lossy(),
        "hash": entry.content,
        "look": entry.look,
        "state": state.word(),
        "name": entry.name,
        "group": entry.group(),
        "tags": entry.tags,
        "licence": entry.licence,
        "textures": entry.textures,
        "lobes": entry.lobes().names(true),
        "problem": entry.problem,
    })
}

/// What became of one file.
struct Row<'a> {
    entry: &'a Entry,
    before: State,
    /// `None` if nothing was made.
    made: Option<Made>,
    problem: Option<String>,
}

fn thumbnails(arguments: &ThumbnailsArguments) -> Result<Outcome, CliError> {
    let mut messages = Messages::default();
    let setup = setup_of(arguments, &mut messages)?;
    let threads = arguments.scene.threads();
    let mut read = read(&arguments.folder, threads, arguments.out.as_deref(), &mut messages)?;
    if arguments.out.is_none() && read.places.pictures.is_none() {
        return Err(CliError::unusable("--out: expected a folder for the pictures, because this user has no cache folder"));
    }
    // Told before minutes of rendering.
    read.shelf.probe().map_err(CliError::unusable)?;

    let (part, parts) = arguments.shard;
    let entries: Vec<Arc<Entry>> =
        read.scanned.index.entries.iter().filter(|entry| entry.look.part(parts) + 1 == part).cloned().collect();
    let is_chosen =
        |entry: &Entry, shelf: &Shelf| entry.problem.is_none() && arguments.only.contains(&shelf.state(entry, setup.digest()));
    let mut left = entries.iter().filter(|entry| is_chosen(entry, &read.shelf)).count();
    let mut maker =
        Maker { arguments, setup: &setup, threads, last: None, line: ProgressLine::new(), done: 0, seconds: 0.0, is_full: false };
    let mut rows: Vec<Row> = Vec::with_capacity(entries.len());
    let mut is_whole = true;
    for entry in &entries {
        let before = read.shelf.state(entry, setup.digest());
        let mut row = Row { entry, before, made: None, problem: entry.problem.clone() };
        if is_chosen(entry, &read.shelf) {
            match maker.make(entry, left, &mut read.shelf, &mut messages) {
                Ok(Some(made)) => row.made = Some(made),
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
    maker.line.clear();
    if arguments.out.is_none() {
        read.shelf.clean(read.scanned.index.entries.iter().map(Arc::as_ref), MAX_ORPHAN_BYTES);
    }
    report(arguments, &setup, &read, &rows, is_whole, &messages)?;
    if !is_whole {
        let made = rows.iter().filter(|row| row.made.is_some()).count();
        return Err(CliError::InterruptedAfter(format!("interrupted; {made} pictures were made and are kept")));
    }
    Ok(if rows.iter().any(|row| row.problem.is_some()) { Outcome::Findings } else { Outcome::Done })
}

/// Makes one picture after the other.
struct Maker<'a> {
    arguments: &'a ThumbnailsArguments,
    setup: &'a Setup,
    threads: usize,
    last: Option<Prepared>,
    line: ProgressLine,
    done: usize,
    seconds: f64,
    /// Whether the last picture could not be written.
    is_full: bool,
}

impl Maker<'_> {
    /// Makes and keeps the picture of an entry, of which there are `left` with this one. `None` if the user has interrupted it.
    fn make(&mut self, entry: &Entry, left: usize, shelf: &mut Shelf, messages: &mut Messages) -> Result<Option<Made>, String> {
        if interrupt::is_interrupted() {
            return Ok(None);
        }
        if self.is_full {
            shelf.probe().map_err(|error| error.to_string())?;
        }
        let path = self.arguments.folder.join(&entry.path);
        let (material, textures, missing) = setup::read(&self.arguments.folder, entry)?;
        missing.iter().for_each(|sentence| messages.warn_about(&path, sentence));
        let scene = self.setup.scene_of(material, textures);
        let limit = self.arguments.time_limit.unwrap_or(DEFAULT_SECONDS);
        let (done, total, seconds, line) = (self.done, self.done + left, self.seconds, &mut self.line);
        let made = self.setup.render(&scene, &mut self.last, limit, self.threads, &mut |progress| {
            line.show(|| {
                let error = progress.error.as_ref().map_or_else(String::new, |error| format!(", {}", error_text(error)));
                let remaining = remaining(done, left, seconds, progress.seconds);
                format!("{} of {total}: {}{error}{remaining}", done + 1, entry.path.display())
            });
            !interrupt::is_interrupted()
        })?;
        let Some(made) = made else { return Ok(None) };
        self.done += 1;
        self.seconds += made.seconds;
        let put = shelf.put(entry.look, self.setup.digest(), &made.png);
        self.is_full = put.is_err();
        put.map_err(|error| error.to_string())?;
        Ok(Some(made))
    }
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

fn setup_of(arguments: &ThumbnailsArguments, messages: &mut Messages) -> Result<Setup, CliError> {
    let options = &arguments.scene;
    let loaded = options.load(None, Some(LoadedMaterial::default()), messages)?;
    let name_of = |text: &Option<String>, mut known: Vec<&str>| match text {
        _ if options.scene.is_some() && text.is_none() => None,
        None => known.first().map(|name| (*name).to_owned()),
        Some(text) => known.drain(..).find(|name| name.eq_ignore_ascii_case(text)).map(str::to_owned),
    };
    let stage = Stage {
        scene: loaded.scene,
        shape: name_of(&options.mesh, SHAPES.iter().map(|def| def.name).collect()),
        environment: name_of(&options.environment, ENVIRONMENTS.iter().map(|def| def.name).collect()),
        has_unit: options.scene.is_none() || options.unit_mm.is_some(),
    };
    let is_standard = options.scene.is_none() && options.size.is_none();
    let (width, height) = if is_standard { (DEFAULT_SIDE, DEFAULT_SIDE) } else { (loaded.width, loaded.height) };
    let display = Display { exposure_ev: options.exposure_ev(), transform: arguments.display_transform };
    let frame = Frame { width, height, relmse: arguments.error.unwrap_or(DEFAULT_RELMSE), seed: options.seed, display };
    let set = options.set.iter().map(|assignment| (assignment.property, assignment.value)).collect();
    Ok(Setup::new(stage, frame, set))
}

fn report(
    arguments: &ThumbnailsArguments,
    setup: &Setup,
    read: &Read,
    rows: &[Row<'_>],
    is_whole: bool,
    messages: &Messages,
) -> Result<(), CliError> {
    let is_limited = |row: &&Row| row.made.as_ref().is_some_and(|made| made.stop_reason == StopReason::Time);
    let made = rows.iter().filter(|row| row.made.is_some()).count();
    let failed = rows.iter().filter(|row| row.problem.is_some()).count();
    let limited: Vec<_> = rows.iter().filter(is_limited).map(|row| row.entry.path.to_string_lossy()).collect();
    if arguments.json {
        let rows: Vec<Value> = rows.iter().map(|row| thumbnail_row(row, setup, &read.shelf)).collect();
        let (part, parts) = arguments.shard;
        return print_out(
            &json!({
                "files": read.scanned.index.entries.len(),
                "shard": format!("{part}/{parts}"),
                "setup": setup.digest(),
                "made": made,
                "failed": failed,
                "limited": limited,
                "is_interrupted": !is_whole,
                "rows": rows,
                "warnings": messages.warnings(),
            })
            .to_string(),
        );
    }
    let mut lines = String::new();
    for row in rows {
        let path = row.entry.path.display();
        if let Some(problem) = &row.problem {
            lines += &format!("{path}: {problem}\n");
        } else if let Some(made) = &row.made {
            let error =
                made.relmse.map_or_else(|| "error unknown".to_owned(), |relmse| format!("error {:.1} %", 100.0 * relmse.sqrt()));
            let limit = if is_limited(&row) { ", stopped by the time limit" } else { "" };
            lines += &format!("{path}: {:.1} s, {error}{limit}\n", made.seconds);
        }
    }
    let total = rows.len();
    print_out(&format!(
        "{lines}{total} files, {made} pictures made, {} of them stopped by the time limit, {failed} that cannot be made",
        limited.len()
    ))
}

fn thumbnail_row(row: &Row<'_>, setup: &Setup, shelf: &Shelf) -> Value {
    let state = shelf.state(row.entry, setup.digest());
    let made = row.made.as_ref();
    json!({
        "path": row.entry.path.to_string_lossy(),
        "hash": row.entry.content,
        "look": row.entry.look,
        "state": state.word(),
        "state_before": row.before.word(),
        "file": (state == State::Fresh).then(|| shelf.path(row.entry.look, setup.digest())),
        "seconds": made.map(|made| made.seconds),
        "spp": made.map(|made| made.spp),
        "relmse_estimate": made.and_then(|made| made.relmse),
        "stop_reason": made.map(|made| made.stop_reason.word()),
        "problem": row.problem,
    })
}

fn state(word: &str) -> Result<State, String> {
    State::from_word(word).ok_or_else(|| "expected missing, stale or fresh".to_owned())
}

fn shard(text: &str) -> Result<(u32, u32), String> {
    let read = text.split_once('/').and_then(|(k, n)| Some((k.trim().parse().ok()?, n.trim().parse().ok()?)));
    read.filter(|(k, n)| (1..=*n).contains(k)).ok_or_else(|| "expected K/N with K from 1 to N, such as 1/4".to_owned())
}

/// One side of a square, or both.
fn picture_size(text: &str) -> Result<(usize, usize), String> {
    if text.contains(['x', 'X']) { scene_options::size(text) } else { scene_options::size(&format!("{text}x{text}")) }
}
