//! `burnish library thumbnails`: small pictures of the materials in a folder, in parts if that is wished, kept one by one.

use super::making::{self, Row, SmallPictureOptions};
use super::{Read, read};
use crate::cli::{CliError, Messages, Outcome, print_out};
use crate::library::entry::Entry;
use crate::library::setup::Setup;
use crate::library::shelf::{MAX_ORPHAN_BYTES, State};
use burnish_renderer::path::StopReason;
use clap::Args;
use serde_json::{Value, json};
use std::path::PathBuf;
use std::sync::Arc;

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
    /// Folder for the pictures, named by what they show [default: the cache of this user]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Prints one JSON object
    #[arg(long)]
    json: bool,
    /// What the pictures show, and when they are done.
    #[command(flatten)]
    pictures: SmallPictureOptions,
}

/// Makes the pictures and prints what became of each file.
pub fn run(arguments: &ThumbnailsArguments) -> Result<Outcome, CliError> {
    let mut messages = Messages::default();
    let setup = arguments.pictures.setup(&mut messages)?;
    let out = arguments.out.as_deref();
    let mut read = read(&arguments.folder, arguments.pictures.scene.threads(), out, &mut messages)?;
    making::refuse_no_place(&read, "--out", out)?;
    let (part, parts) = arguments.shard;
    let entries: Vec<Arc<Entry>> =
        read.scanned.index.entries.iter().filter(|entry| entry.look.part(parts) + 1 == part).cloned().collect();
    let (rows, is_whole) =
        arguments.pictures.make(&arguments.folder, &entries, &arguments.only, &setup, &mut read.shelf, &mut messages);
    if out.is_none() {
        read.shelf.clean(read.scanned.index.entries.iter().map(Arc::as_ref), MAX_ORPHAN_BYTES);
    }
    report(arguments, &setup, &read, &rows, is_whole, &messages)?;
    if !is_whole {
        let made = making::made(&rows);
        return Err(CliError::Stopped(format!("interrupted; {made} pictures were made and are kept")));
    }
    Ok(if rows.iter().any(|row| row.problem.is_some()) { Outcome::Findings } else { Outcome::Done })
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
    let made = making::made(rows);
    let failed = rows.iter().filter(|row| row.problem.is_some()).count();
    let limited: Vec<_> = rows.iter().filter(is_limited).map(|row| row.entry.path.to_string_lossy()).collect();
    if arguments.json {
        let rows: Vec<Value> = rows.iter().map(|row| row.json(setup, &read.shelf)).collect();
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
    let mut told: Vec<(&str, usize)> = Vec::new();
    for row in rows {
        let path = row.entry.path.display();
        if let Some(problem) = &row.problem {
            // A disk that is full says the same of each.
            if let Some((_, more)) = told.iter_mut().find(|(known, _)| known == problem) {
                *more += 1;
            } else {
                told.push((problem, 0));
                lines += &format!("{path}: {problem}\n");
            }
        } else if let Some(made) = &row.made {
            let error =
                made.relmse.map_or_else(|| "error unknown".to_owned(), |relmse| format!("error {:.1} %", 100.0 * relmse.sqrt()));
            let limit = if is_limited(&row) { ", stopped by the time limit" } else { "" };
            lines += &format!("{path}: {:.1} s, {error}{limit}\n", made.seconds);
        }
    }
    for (problem, more) in told.iter().filter(|(_, more)| *more > 0) {
        lines += &format!("{more} more files: {problem}\n");
    }
    let total = rows.len();
    print_out(&format!(
        "{lines}{total} files, {made} pictures made, {} of them stopped by the time limit, {failed} that cannot be made",
        limited.len()
    ))
}

fn state(word: &str) -> Result<State, String> {
    // Drafts are only in windows.
    let state = State::from_word(word).filter(|state| *state != State::Draft);
    state.ok_or_else(|| "expected missing, stale or fresh".to_owned())
}

fn shard(text: &str) -> Result<(u32, u32), String> {
    let read = text.split_once('/').and_then(|(k, n)| Some((k.trim().parse().ok()?, n.trim().parse().ok()?)));
    read.filter(|(k, n)| (1..=*n).contains(k)).ok_or_else(|| "expected K/N with K from 1 to N, such as 1/4".to_owned())
}
