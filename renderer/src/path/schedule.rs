//! Jobs and passes: which thread does what, and when to give up.
//!
//! A job is a run of pixels, each with the number of samples it is due. Jobs share nothing but a counter. What a pixel holds depends on its sample numbers alone, so the bits of a picture are the
//! same for any number of threads and any division into passes.

use super::PassStats;
use super::batch::{BATCH, Batch};
use super::film::{Film, PassTarget, Quota, REPLICATES};
use super::miss::{Miss, accumulate};
use super::photon::{Photons, Splat, photons_per_sample, trace_photons};
use super::prepared::Prepared;
use super::raygen::{Place, Raygen, Tile, View};
use super::shade::Shade;
use super::trace::{PASS_LIMIT, trace, trace_shadows};
use crate::lanes::dispatch;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

/// Batches per thread at least, so that threads end together.
const JOBS_PER_THREAD: usize = 8;
/// Paths of a job at least, however small the picture.
const JOB_MIN: usize = 256;

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
    let quotas = film.evenly(spp);
    render_quotas(prepared, film, &quotas, seed, threads, cancel)
}

/// Adds samples to some pixels, each of which occurs once. `None`: cancelled, and the film is as before.
pub(super) fn render_quotas(
    prepared: &Prepared,
    film: &mut Film,
    quotas: &[Quota],
    seed: u64,
    threads: usize,
    cancel: &(dyn Fn() -> bool + Sync),
) -> Option<PassStats> {
    let threads = threads.max(1);
    let view = View::of_film(prepared, film);
    let jobs = jobs(quotas, threads);
    let photons = photon_work(prepared, film, quotas);
    let splats: Vec<Mutex<Vec<Splat>>> = photons.iter().map(|_| Mutex::default()).collect();
    let counter = AtomicUsize::new(0);
    let is_cancelled = AtomicBool::new(false);
    let target = film.begin();
    let work = || {
        let mut batch = prepared.take_batch();
        let mut stats = PassStats::default();
        loop {
            let number = counter.fetch_add(1, Ordering::Relaxed);
            if number >= jobs.len() + photons.len() || is_cancelled.load(Ordering::Relaxed) {
                break;
            }
            if let (Some(caustics), Some(number)) = (&prepared.caustics, number.checked_sub(jobs.len())) {
                is_cancelled.fetch_or(cancel(), Ordering::Relaxed);
                let mut brought = Vec::new();
                trace_photons(prepared, caustics, &view, photons[number], seed, &mut batch, &mut brought, &mut stats);
                *splats[number].lock().unwrap_or_else(PoisonError::into_inner) = brought;
                continue;
            }
            if !render_job(prepared, &view, &target, jobs[number], seed, &mut batch, &mut stats, &|| {
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
    if threads == 1 || jobs.len() <= 1 {
        total.add(&work());
    } else {
        std::thread::scope(|scope| {
            let handles: Vec<_> = (1..threads.min(jobs.len())).map(|_| scope.spawn(work)).collect();
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
    film.commit(quotas);
    // In the order of their numbers, so that the sums are the same to the bit whoever traced them.
    for (work, splats) in photons.iter().zip(splats) {
        let splats = splats.into_inner().unwrap_or_else(PoisonError::into_inner);
        film.add_photons(work.replicate as usize, work.count as u64, &splats);
    }
    Some(total)
}

/// The photons that go with a pass, in parts of a batch.
fn photon_work(prepared: &Prepared, film: &Film, quotas: &[Quota]) -> Vec<Photons> {
    if prepared.caustics.is_none() {
        return Vec::new();
    }
    let [width, height] = film.window.full;
    let each = photons_per_sample(width, height);
    let parts = |sample: u32| {
        let first = u64::from(sample / REPLICATES as u32) * each as u64;
        (0..each).step_by(BATCH).map(move |start| Photons {
            replicate: sample % REPLICATES as u32,
            first: first + start as u64,
            count: BATCH.min(each - start),
        })
    };
    film.photon_samples_due(quotas).flat_map(parts).collect()
}

/// Cuts a pass into runs of pixels: as many paths as a batch holds, but enough runs for all threads.
fn jobs(quotas: &[Quota], threads: usize) -> Vec<&[Quota]> {
    let total: usize = quotas.iter().map(|quota| quota.count as usize).sum();
    let most = (total / (threads * JOBS_PER_THREAD)).clamp(JOB_MIN, BATCH);
    let (mut jobs, mut rest) = (Vec::new(), quotas);
    while !rest.is_empty() {
        let mut paths = 0;
        let fits = |quota: &&Quota| {
            paths += quota.count as usize;
            paths <= most
        };
        // One pixel at least: it takes several batches where it does not fit into one.
        let count = rest.iter().take_while(fits).count().max(1);
        let (job, others) = rest.split_at(count);
        jobs.push(job);
        rest = others;
    }
    jobs
}

/// All samples of some pixels. False if cancelled.
#[expect(clippy::too_many_arguments, reason = "called once; a struct would only rename the arguments")]
fn render_job(
    prepared: &Prepared,
    view: &View,
    target: &PassTarget<'_>,
    quotas: &[Quota],
    seed: u64,
    batch: &mut Batch,
    stats: &mut PassStats,
    cancel: &dyn Fn() -> bool,
) -> bool {
    let (mut cells, mut places) = (std::mem::take(&mut batch.cells), std::mem::take(&mut batch.places));
    target.load(quotas, &mut cells);
    let samples = |(cell, (quota, first)): (usize, (&Quota, u32))| {
        let pixel = view.in_picture(quota.pixel);
        (first..first + quota.count).map(move |sample| Place { cell: cell as u32, pixel, sample })
    };
    let firsts: Vec<u32> = cells.iter().map(|cell| cell.count).collect();
    let mut all = quotas.iter().zip(firsts).enumerate().flat_map(samples);
    let mut is_complete = true;
    loop {
        places.clear();
        places.extend(all.by_ref().take(BATCH));
        if places.is_empty() {
            break;
        }
        if cancel() {
            is_complete = false;
            break;
        }
        run_batch(prepared, view, Tile { places: &places }, seed, batch, stats);
        for (path, place) in places.iter().enumerate() {
            let cell = &mut cells[place.cell as usize];
            for (k, sum) in cell.sums[place.sample as usize % REPLICATES].iter_mut().enumerate() {
                *sum += f64::from(batch.paths.radiance[k][path]);
            }
            cell.count += 1;
            cell.covered += u32::from(batch.paths.is_covered[path]);
        }
        stats.samples += places.len() as u64;
    }
    if is_complete {
        target.store(quotas, &cells);
    }
    (batch.cells, batch.places) = (cells, places);
    is_complete
}

/// Follows a batch of paths to their ends, one depth at a time.
fn run_batch(prepared: &Prepared, view: &View, tile: Tile<'_>, seed: u64, batch: &mut Batch, stats: &mut PassStats) {
    batch.begin(tile.paths(), prepared.surfaces.len());
    dispatch(Raygen { prepared, view, tile, seed, paths: &mut batch.paths });
    for vertex in 0..prepared.max_bounces.saturating_add(2 + PASS_LIMIT) {
        if batch.active.is_empty() {
            break;
        }
        meet(prepared, batch, vertex, stats);
        shade(prepared, batch, vertex, stats);
        let Batch { paths, active, next, shadows, .. } = &mut *batch;
        if !shadows.rays.is_empty() {
            trace_shadows(prepared, shadows);
            accumulate(paths, shadows, stats);
        }
        std::mem::swap(active, next);
    }
    batch.paths.fold_branches();
}

/// First part of a depth: the active paths go to what they meet next; those that leave the scene find the environment there.
pub(super) fn meet(prepared: &Prepared, batch: &mut Batch, vertex: u32, stats: &mut PassStats) {
    batch.shadows.clear();
    trace(prepared, batch, vertex, stats);
    let Batch { paths, missed, .. } = &mut *batch;
    if !missed.is_empty() {
        dispatch(Miss { prepared, list: missed, paths, stats });
    }
}

/// Second part: what happens there. Connections to the light are left in `shadows`, the paths that go on in `next`.
pub(super) fn shade(prepared: &Prepared, batch: &mut Batch, vertex: u32, stats: &mut PassStats) {
    let Batch { paths, next, lists, shadows, .. } = &mut *batch;
    next.clear();
    for (surface, list) in prepared.surfaces.iter().zip(lists.iter()) {
        if !list.is_empty() {
            dispatch(Shade { prepared, surface, list, vertex, paths, next, shadows, stats });
        }
    }
}
