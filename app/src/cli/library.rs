//! `burnish library`: a folder of materials as a library: what is in it, small pictures of it, and whether it can be handed out.
//!
//! A file that cannot be used is a finding and does not keep the others from being looked at. What is known of a library is kept in the cache
//! folder of the user, and with it small pictures unless an option names another folder.

mod making;
mod pack;
mod sheet;
mod thumbnails;

use super::library_check::{self, LibraryCheckArguments};
use super::progress_line::ProgressLine;
use super::scene_options::SceneOptions;
use super::{CliError, Messages, Outcome, interrupt, print_out};
use crate::digest::Digest;
use crate::library::entry::Entry;
use crate::library::index::Index;
use crate::library::query::{Facts, Query};
use crate::library::scan::{Event, Progress, Scan, Scanned};
use crate::library::setup::{Frame, Setup, Stage};
use crate::library::shelf::{Shelf, State};
use crate::library::{LibraryPlaces, marks::Marks};
use crate::places::Places;
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
    /// Lists the materials in a folder and below, and whether the pictures that `thumbnails` makes without options are there
    Index(IndexArguments),
    /// Makes small pictures of the materials in a folder and below
    #[command(mut_arg("size", |size| {
        size.value_name("SIDE|WxH").value_parser(making::picture_size).help("Size of the pictures in pixels [default: 256]")
    }))]
    Thumbnails(Box<thumbnails::ThumbnailsArguments>),
    /// Shows the materials in a folder and below on one sheet: a page that needs nothing beside itself, a picture, or both
    #[command(mut_arg("size", |size| {
        size.value_name("SIDE|WxH").value_parser(making::picture_size).help("Size of the pictures in pixels [default: 256]")
    }))]
    Sheet(Box<sheet::SheetArguments>),
    /// Packs the materials in a folder and below to hand them out: with their images, as USD, MaterialX and glTF, a contact sheet, licences and the report of a check
    #[command(mut_arg("size", |size| {
        size.value_name("SIDE|WxH").value_parser(making::picture_size).help("Size of the pictures in pixels [default: 256]")
    }))]
    Pack(Box<pack::PackArguments>),
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

/// Lists, or makes pictures.
pub fn run(arguments: &LibraryArguments) -> Result<Outcome, CliError> {
    match &arguments.action {
        Action::Index(arguments) => index(arguments),
        Action::Thumbnails(arguments) => thumbnails::run(arguments),
        Action::Sheet(arguments) => sheet::run(arguments),
        Action::Pack(arguments) => pack::run(arguments),
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

/// What `--search` asks for; everything without it.
fn query_of(search: Option<&str>) -> Result<Query, CliError> {
    let query = Query::parse(search.unwrap_or_default());
    match query.problem() {
        Some(problem) => Err(CliError::unusable(format!("--search: {problem}"))),
        None => Ok(query),
    }
}

impl Read {
    /// Those entries that a query matches.
    fn matching(&self, query: &Query, setup: Digest, messages: &mut Messages) -> Vec<Arc<Entry>> {
        let (marks, problem) = self.places.marks.as_deref().map_or_else(Default::default, Marks::load);
        problem.into_iter().for_each(|problem| messages.warn(problem));
        let facts =
            |entry: &Entry| Facts { state: self.shelf.state(entry, setup), is_favourite: marks.is_favourite(&entry.path) };
        self.scanned.index.entries.iter().filter(|entry| query.matches(entry, || facts(entry))).cloned().collect()
    }

    /// The name of the library: that of its folder.
    fn name(&self, folder: &Path) -> String {
        let whole = std::fs::canonicalize(folder).unwrap_or_else(|_| folder.to_path_buf());
        whole.file_name().unwrap_or(whole.as_os_str()).to_string_lossy().into_owned()
    }
}

fn index(arguments: &IndexArguments) -> Result<Outcome, CliError> {
    let mut messages = Messages::default();
    let query = query_of(arguments.search.as_deref())?;
    let read = read(&arguments.folder, SceneOptions::default().threads(), None, &mut messages)?;
    let setup = standard_setup()?;
    let entries = &read.scanned.index.entries;
    let state_of = |entry: &Entry| read.shelf.state(entry, setup);
    let start = Instant::now();
    let found = read.matching(&query, setup, &mut messages);
    let search_seconds = start.elapsed().as_secs_f64();
    let broken = entries.iter().filter(|entry| entry.problem.is_some()).count();
    if arguments.json {
        let rows: Vec<Value> = found.iter().map(|entry| index_row(entry, state_of(entry))).collect();
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
                None => format!("{path}: {} ({})\n", entry.name, state_of(entry).word()),
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
        "aliases": entry.aliases,
        "tags": entry.tags,
        "licence": entry.licence,
        "textures": entry.textures,
        "lobes": entry.lobes().names(true),
        "problem": entry.problem,
    })
}
