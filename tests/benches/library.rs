//! What a library of 10 000 files costs: opening cold and warm, searching, memory, and the processor time of scrolling.
//!
//! `cargo bench -p burnish-tests --bench library -- [COUNT]` prints seconds, milliseconds and megabytes. Files lie in a folder of their own, and
//! cold means without an index: the system has the files in memory in either case.

use burnish::library::index::Index;
use burnish::library::query::Facts;
use burnish::library::scan::Scan;
use burnish::library::shelf::State;
use burnish::library::{Entry, Library, Query};
use burnish::places::Places;
use burnish_tests::library::write;
use std::io::Write;
use std::path::Path;
use std::sync::mpsc::channel;
use std::time::Instant;

/// Queries of growing length.
const QUERIES: [&str; 5] = [
    "metal",
    "metal rough<0.3 tag:measured",
    "-glass \"made up\"",
    "group:wool base_color>0.5 licence:CC0",
    "is:missing notes:number",
];
/// Times that each query is measured.
const TIMES: usize = 20;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let count = std::env::args().skip(1).find_map(|word| word.parse().ok()).unwrap_or(10_000);
    let mut out = std::io::stdout().lock();
    let folder = tempfile::tempdir()?;
    let root = folder.path().join("library");
    write(&root, count)?;
    let below = |name| Some(folder.path().join(name));
    let places = Places { config: None, state: below("state"), cache: below("cache") };
    let before = resident_bytes();

    let cold = open(&root, &places, count)?;
    let Opened { first, whole, poll, .. } = &cold;
    writeln!(out, "{count} files, opened cold: {whole:.2} s ({first:.2} s to the first entries; longest poll {poll:.2} ms)")?;
    drop(cold);
    for _ in 0..3 {
        let warm = open(&root, &places, count)?;
        let Opened { first, whole, poll, .. } = &warm;
        writeln!(out, "opened warm: {whole:.3} s ({first:.3} s to all entries in sight; longest poll {poll:.2} ms)")?;
    }
    let Opened { mut library, .. } = open(&root, &places, count)?;

    let mut worst: f64 = 0.0;
    for text in QUERIES {
        let mut times: Vec<f64> = Vec::new();
        let mut found = 0;
        for _ in 0..TIMES {
            let start = Instant::now();
            found = library.matching(&Query::parse(text)).len();
            times.push(1e3 * start.elapsed().as_secs_f64());
        }
        times.sort_by(f64::total_cmp);
        writeln!(out, "search `{text}`: {found} found, {:.2} ms, at worst {:.2} ms", times[TIMES / 2], times[TIMES - 1])?;
        worst = worst.max(times[TIMES - 1]);
    }
    writeln!(out, "worst search: {worst:.2} ms")?;

    // A window of 60 cards that moves over all of them; pictures are loaded, none are made.
    let mut slowest: f64 = 0.0;
    for first in (0..library.entries().len()).step_by(7) {
        let seen: Vec<usize> = (first..first + 60).collect();
        let start = Instant::now();
        library.show(&seen, false);
        library.poll();
        let known =
            seen.iter().filter_map(|number| library.entries().get(*number)).filter(|entry| library.state(entry) == State::Fresh);
        std::hint::black_box(known.count());
        slowest = slowest.max(1e3 * start.elapsed().as_secs_f64());
    }
    writeln!(out, "scrolling: {slowest:.2} ms at worst of a frame")?;

    let megabytes = |bytes: usize| bytes as f64 / 1e6;
    writeln!(out, "memory: {:.1} MB of entries", megabytes(library.memory_bytes()))?;
    if let Some((after, before)) = resident_bytes().zip(before) {
        let grown = megabytes(after.saturating_sub(before));
        writeln!(out, "the process grew by {grown:.1} MB, with the scene of small pictures and what was freed")?;
    }
    let size = std::fs::read_dir(folder.path().join("cache/libraries"))?.flatten().next().ok_or("no index")?;
    let size = std::fs::metadata(size.path().join("index.json"))?.len();
    writeln!(out, "index on disk: {:.1} MB", size as f64 / 1e6)?;

    // What is asked of one thread and no disk.
    let index = Index::load(&places_index(&root, &places).ok_or("no index")?, &root);
    let start = Instant::now();
    let scan = Scan { root: &root, old: &index, threads: 1, has_picture: &|_| false, is_cancelled: &|| false, tell: &|_| {} };
    let scanned = scan.run()?;
    writeln!(out, "scan on one thread: {:.3} s, {} read", start.elapsed().as_secs_f64(), scanned.read)?;
    let facts = |_: &Entry| Facts { state: State::Missing, is_favourite: false };
    let query = Query::parse("metal");
    let start = Instant::now();
    let found = index.entries.iter().filter(|entry| query.matches(entry, || facts(entry))).count();
    writeln!(out, "one word without a window: {found} found, {:.2} ms", 1e3 * start.elapsed().as_secs_f64())?;
    Ok(())
}

struct Opened {
    library: Library,
    /// Seconds.
    first: f64,
    /// Seconds.
    whole: f64,
    /// Milliseconds of the longest time that a window would have waited.
    poll: f64,
}

/// Opens a library until all is known.
fn open(root: &Path, places: &Places, count: usize) -> Result<Opened, Box<dyn std::error::Error>> {
    let (sender, receiver) = channel();
    let start = Instant::now();
    let mut library = Library::open(root, places, move || _ = sender.send(()));
    let (mut first, mut poll) = (None, 0.0_f64);
    while library.progress().is_some() || library.setup().is_none() {
        receiver.recv()?;
        let now = Instant::now();
        library.poll();
        poll = poll.max(1e3 * now.elapsed().as_secs_f64());
        if !library.entries().is_empty() {
            first.get_or_insert(start.elapsed().as_secs_f64());
        }
    }
    let whole = start.elapsed().as_secs_f64();
    if library.entries().len() != count {
        return Err(format!("{} of {count} entries", library.entries().len()).into());
    }
    Ok(Opened { library, first: first.unwrap_or(whole), whole, poll })
}

fn places_index(root: &Path, places: &Places) -> Option<std::path::PathBuf> {
    burnish::library::LibraryPlaces::of(root, places).index
}

/// Memory of this process, where the system tells (Linux).
fn resident_bytes() -> Option<usize> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmRSS:"))?;
    Some(line.split_whitespace().nth(1)?.parse::<usize>().ok()? * 1024)
}
