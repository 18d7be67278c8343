//! `burnish library check`: whether a folder of materials can be handed out, and what became of it since an earlier release.

use super::check::{outcome, with_progress};
use super::library::{Read, read, standard_setup};
use super::scene_options::{SceneOptions, threads};
use super::{CliError, Messages, Outcome, interrupt, print_out};
use crate::digest::Digest;
use crate::library::check::against::compare;
use crate::library::check::report::{Timing, json_library, text};
use crate::library::check::{Options, Shelved, check_library};
use clap::Args;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Arguments of `burnish library check`.
#[derive(Debug, Args)]
pub struct LibraryCheckArguments {
    /// Folder of materials
    #[arg(value_name = "DIR")]
    folder: PathBuf,
    /// Also exits with 1 where there are only warnings
    #[arg(long)]
    strict: bool,
    /// Probes each material numerically, which takes a second or so each
    #[arg(long)]
    stability: bool,
    /// Renders each material small to find those that look the same; without it, fresh small pictures are compared
    #[arg(long)]
    look: bool,
    /// Lists what was added, removed and changed since the library in this folder; that is no finding
    #[arg(long, value_name = "DIR")]
    against: Option<PathBuf>,
    /// Threads that check [default: all]
    #[arg(long, value_name = "N", allow_hyphen_values = true, value_parser = threads)]
    threads: Option<usize>,
    /// Prints one JSON object
    #[arg(long)]
    json: bool,
}

/// Checks, compares and prints. How fast it was goes to standard error.
pub(super) fn run(arguments: &LibraryCheckArguments) -> Result<Outcome, CliError> {
    let mut messages = Messages::default();
    let threads = SceneOptions { threads: arguments.threads, ..SceneOptions::default() }.threads();
    let options = Options { threads, renders_looks: arguments.look, probes_stability: arguments.stability };
    let new = read(&arguments.folder, threads, None, &mut messages)?;
    let old = arguments.against.as_deref().map(|folder| read(folder, threads, None, &mut messages)).transpose()?;
    let setup = standard_setup()?;
    let library = shelved(&arguments.folder, &new, setup);
    let start = Instant::now();
    let checked = with_progress("checking", |tell| check_library(&library, &options, tell, &interrupt::is_interrupted))?;
    let seconds = start.elapsed().as_secs_f64();
    let against = match (arguments.against.as_deref(), &old) {
        (Some(folder), Some(old)) => {
            let old = shelved(folder, old, setup);
            Some(with_progress("comparing", |tell| compare(&old, &library, &options, tell, &interrupt::is_interrupted))?)
        }
        _ => None,
    };
    let rate = checked.files as f64 / seconds.max(1e-9);
    if arguments.json {
        let timing = Timing { seconds, read_seconds: new.seconds };
        let against = against.as_ref().zip(arguments.against.as_deref());
        let object = json_library(&checked, against, timing, messages.warnings());
        print_out(&object.to_string())?;
    } else {
        print_out(&text(&checked, against.as_ref()))?;
    }
    eprintln!("checked in {seconds:.2} s: {rate:.0} files per second, threads: {threads}");
    Ok(outcome(&checked, arguments.strict))
}

fn shelved<'a>(root: &'a Path, read: &'a Read, setup: Digest) -> Shelved<'a> {
    Shelved { root, entries: &read.scanned.index.entries, shelf: &read.shelf, setup }
}
