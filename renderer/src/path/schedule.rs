//! Tiles and passes: which thread does what, and when to give up.
//!
//! Tiles share nothing but a counter. What a pixel holds depends on its sample numbers alone, so the bits of a picture are the
//! same for any number of threads and any division into passes.

use super::PassStats;
use super::batch::{BATCH, Batch};
use super::film::{Film, PassTarget, REPLICATES};
use super::miss::{Miss, accumulate};
use super::prepared::Prepared;
use super::raygen::{Raygen, Tile, View};
use super::shade::Shade;
use super::trace::{PASS_LIMIT, trace, trace_shadows};
use crate::lanes::dispatch;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// Samples of a pixel that go together at most; longer passes take a tile in several batches.
const SAMPLES_MAX: u32 = 16;
/// Tiles per thread at least, so that threads end together.
const TILES_PER_THREAD: usize = 8;

/// Adds `spp` samples to every pixel. `None`: cancelled, and the film is as before.
///
/// `cancel` is asked before every batch (some milliseconds each), from all threads' own loops; it should be quick.
pub fn render_pass(
    prepared: &Prepared,
    film: &mut Film,
    spp: u32,
    seed: u64,
    threads: usize,
    cancel: &(dyn Fn() -> bool + Sync),
) -> Option<PassStats> {
    let (width, height, first) = (film.width, film.height, film.spp());
    let threads = threads.max(1);
    let view = View::new(prepared, width, height);
    let side = tile_side(width * height, spp, threads);
    let columns = width.div_ceil(side);
    let tiles = columns * height.div_ceil(side);
    let counter = AtomicUsize::new(0);
    let is_cancelled = AtomicBool::new(false);
    let target = film.begin();
    let work = || {
        let mut batch = prepared.take_batch();
        let mut stats = PassStats::default();
        loop {
            let number = counter.fetch_add(1, Ordering::Relaxed);
            if number >= tiles || is_cancelled.load(Ordering::Relaxed) {
                break;
            }
            let (x, y) = (number % columns * side, number / columns * side);
            let tile = Tile { x, y, width: side.min(width - x), height: side.min(height - y), first, count: spp };
            if !render_tile(prepared, &view, &target, tile, seed, &mut batch, &mut stats, &|| {
                let stop = is_cancelled.load(Ordering::Relaxed) || cancel();
                is_cancelled.fetch_or(stop, Ordering::Relaxed);
                stop
            }) {
                break;
            }
        }
        prepared.give_batch(batch);
        stats
    };
    let mut total = PassStats::default();
    if threads == 1 || tiles <= 1 {
        total.add(&work());
    } else {
        std::thread::scope(|scope| {
            let handles: Vec<_> = (1..threads.min(tiles)).map(|_| scope.spawn(work)).collect();
            total.add(&work());
            for handle in handles {
                match handle.join() {
                    Ok(stats) => total.add(&stats),
                    Err(panic) => std::panic::resume_unwind(panic),
                }
            }
        });
    }
    if is_cancelled.load(Ordering::Relaxed) {
        return None;
    }
    film.commit(spp);
    Some(total)
}

/// Side of square tiles: as many paths as a batch holds, but enough tiles for all threads.
fn tile_side(pixels: usize, spp: u32, threads: usize) -> usize {
    let samples = spp.clamp(1, SAMPLES_MAX) as usize;
    let fits = |side: &usize| side * side * samples <= BATCH && pixels >= side * side * threads * TILES_PER_THREAD;
    [64, 32, 16].into_iter().find(fits).unwrap_or(8)
}

/// All samples of one tile. False if cancelled.
#[expect(clippy::too_many_arguments, reason = "called once; a struct would only rename the arguments")]
fn render_tile(
    prepared: &Prepared,
    view: &View,
    target: &PassTarget<'_>,
    tile: Tile,
    seed: u64,
    batch: &mut Batch,
    stats: &mut PassStats,
    cancel: &dyn Fn() -> bool,
) -> bool {
    let place = [tile.x, tile.y, tile.width, tile.height];
    let (mut sums, mut covered) = (std::mem::take(&mut batch.sums), std::mem::take(&mut batch.covered));
    target.load(place, &mut sums, &mut covered);
    let mut done = 0;
    let mut is_complete = true;
    while done < tile.count {
        if cancel() {
            is_complete = false;
            break;
        }
        let part = Tile { first: tile.first + done, count: SAMPLES_MAX.min(tile.count - done), ..tile };
        run_batch(prepared, view, part, seed, batch, stats);
        for path in 0..part.paths() {
            let (pixel, sample) = part.place(path);
            let sum = &mut sums[pixel * REPLICATES + sample as usize % REPLICATES];
            for (k, sum) in sum.iter_mut().enumerate() {
                *sum += f64::from(batch.paths.radiance[k][path]);
            }
            covered[pixel] += u32::from(batch.paths.is_covered[path]);
        }
        stats.samples += part.paths() as u64;
        done += part.count;
    }
    if is_complete {
        target.store(place, &sums, &covered);
    }
    (batch.sums, batch.covered) = (sums, covered);
    is_complete
}

/// Follows a batch of paths to their ends, one depth at a time.
fn run_batch(prepared: &Prepared, view: &View, tile: Tile, seed: u64, batch: &mut Batch, stats: &mut PassStats) {
    batch.begin(tile.paths(), prepared.surfaces.len());
    dispatch(Raygen { prepared, view, tile, seed, paths: &mut batch.paths });
    for vertex in 0..prepared.max_bounces.saturating_add(2 + PASS_LIMIT) {
        if batch.active.is_empty() {
            break;
        }
        batch.shadows.clear();
        trace(prepared, batch, vertex, stats);
        let Batch { paths, active, next, lists, missed, shadows, .. } = &mut *batch;
        if !missed.is_empty() {
            dispatch(Miss { prepared, list: missed, paths, stats });
        }
        next.clear();
        for (surface, list) in prepared.surfaces.iter().zip(lists.iter()) {
            if !list.is_empty() {
                dispatch(Shade { prepared, surface, list, vertex, paths, next, shadows, stats });
            }
        }
        if !shadows.rays.is_empty() {
            trace_shadows(prepared, shadows);
            accumulate(paths, shadows, stats);
        }
        std::mem::swap(active, next);
    }
}
