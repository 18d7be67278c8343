//! Pictures of the light that each lobe contributes: every pixel explained by the samples that it got.

use super::super::film::Film;
use super::super::raygen::View;
use super::{Ledger, follow};
use crate::bsdf::SCATTERING;
use crate::path::Prepared;
use crate::path::batch::BATCH;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

/// Part of the light of a picture.
#[derive(Clone, Debug)]
pub struct LightLayer {
    /// Name of the lobe, or `emission` (what the surfaces emit) or `through` (what no surface scattered).
    pub name: &'static str,
    /// Linear Rec.709, row by row from the top.
    pub pixels: Vec<[f32; 3]>,
}

/// The light of a picture by what sent it to the camera; all layers together sum to the picture.
///
/// The paths are those of `film`, which was rendered with this seed; caustics that it got from photons are found by paths, with more noise.
/// Layers that are black everywhere are left out. Takes longer than rendering did. `None`: cancelled.
pub fn light_layers(
    prepared: &Prepared,
    film: &Film,
    seed: u64,
    threads: usize,
    cancel: &(dyn Fn() -> bool + Sync),
) -> Option<Vec<LightLayer>> {
    const PARTS: usize = SCATTERING.len() + 2;
    let (width, height) = (film.width, film.height);
    let counts = film.samples();
    let rows: Vec<Mutex<Vec<[[f32; 3]; PARTS]>>> = (0..height).map(|_| Mutex::default()).collect();
    let (next, is_cancelled) = (AtomicUsize::new(0), AtomicBool::new(false));
    let view = View::new(prepared, width, height);
    let work = || {
        let mut batch = prepared.take_batch();
        loop {
            let y = next.fetch_add(1, Ordering::Relaxed);
            is_cancelled.fetch_or(cancel(), Ordering::Relaxed);
            if y >= height || is_cancelled.load(Ordering::Relaxed) {
                break;
            }
            let mut row = Vec::with_capacity(width);
            for (pixel, &count) in counts.iter().enumerate().skip(y * width).take(width) {
                let mut ledger = Ledger::default();
                for first in (0..count).step_by(BATCH) {
                    let numbers = first..count.min(first + BATCH as u32);
                    follow(prepared, &view, pixel as u32, numbers, seed, &mut batch, &mut ledger);
                }
                let scale = 1.0 / f64::from(count.max(1));
                let mut sums = ledger.lobes.iter().chain([&ledger.emission, &ledger.through]);
                let part = |sum: Option<&[f64; 3]>| sum.map_or([0.0; 3], |sum| sum.map(|c| (c * scale) as f32));
                row.push(std::array::from_fn(|_| part(sums.next())));
            }
            *rows[y].lock().unwrap_or_else(PoisonError::into_inner) = row;
        }
        prepared.give_batch(batch);
    };
    std::thread::scope(|scope| {
        (1..threads.max(1)).for_each(|_| drop(scope.spawn(work)));
        work();
    });
    if is_cancelled.load(Ordering::Relaxed) {
        return None;
    }
    let pixels: Vec<[[f32; 3]; PARTS]> =
        rows.into_iter().flat_map(|row| row.into_inner().unwrap_or_else(PoisonError::into_inner)).collect();
    let names = SCATTERING.iter().map(|lobe| lobe.def().name).chain(["emission", "through"]);
    let layer = |(part, name)| LightLayer { name, pixels: pixels.iter().map(|parts| parts[part]).collect() };
    let is_lit = |layer: &LightLayer| layer.pixels.iter().any(|pixel| *pixel != [0.0; 3]);
    Some(names.enumerate().map(layer).filter(is_lit).collect())
}
