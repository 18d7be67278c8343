//! Which lobe contributes what to one pixel.
//!
//! The paths are those of the ordinary renderer, to the bit, followed depth by depth. Light that a path finds after it was scattered for the
//! first time came along the direction in which it left its first surface, be it a connection or the path's own; there it is divided by the shares of
//! the lobes in the value of the BSDF for that direction ([`crate::bsdf`]). Since the pixel is linear in that value, each part estimates without
//! bias what its lobe alone would bring, and the parts add up to the estimate of the whole, path by path.
//!
//! Two things differ from a picture: caustics that a picture gets from photons are left to the paths, which find the same light with more noise;
//! and nothing is resolved below the layers, so light that a lobe sends through a coat counts for the lobe.

mod layers;

pub use layers::{LightLayer, light_layers};

use super::PassStats;
use super::batch::{BATCH, Batch, Paths};
use super::estimate::variance_of_mean;
use super::film::{REPLICATES, replicate_weights};
use super::prepared::Prepared;
use super::raygen::{Place, Raygen, Tile, View};
use super::sampler::MAX_LANES;
use super::schedule::{meet, shade};
use super::seen::Seen;
use super::shade::wavelength;
use super::trace::{PASS_LIMIT, trace_shadows};
use crate::bsdf::{ByLobe, SCATTERING, Wavelength};
use crate::bvh::Ray;
use crate::lanes::dispatch;
use crate::vector::{Rgb, V3};
use burnish_material::{Inputs, Lobe, LobeSet};
use glam::Vec3;
use std::ops::Range;

/// Random stream of the paths.
const SEED: u64 = 0;

/// What a pixel shows and why. Radiance is linear Rec.709, without exposure.
#[derive(Clone, Debug)]
pub struct Explanation {
    /// What the middle of the pixel shows; `None` for the environment.
    pub surface: Option<SurfacePoint>,
    /// Light by the lobe that scattered it to the camera, brightest first: all scattering lobes of the surfaces in the pixel. Together with `emission`
    /// and `through` they sum to `radiance`.
    pub lobes: Vec<LobeShare>,
    /// Light that the surfaces in the pixel emit.
    pub emission: [f64; 3],
    /// Light that no surface scattered: the environment beside the objects or through cut-through surfaces.
    pub through: [f64; 3],
    /// Mean radiance of the pixel.
    pub radiance: [f64; 3],
    /// Its estimated standard error.
    pub standard_error: [f64; 3],
    /// Paths, [`REPLICATES`] at least.
    pub samples: u32,
}

/// A point of a surface as the camera sees it.
#[derive(Clone, Debug)]
pub struct SurfacePoint {
    /// Position, scene units.
    pub position: [f64; 3],
    /// Shading normal, unit, world: normal and height maps included, on the outside.
    pub normal: [f64; 3],
    /// Texture coordinate.
    pub uv: [f64; 2],
    /// Angle between the shading normal and the direction to the camera, degrees, `[0, 180]`; above 90 the inside is seen.
    pub view_angle: f64,
    /// Distance from the camera, scene units.
    pub depth: f64,
    /// Number of the object in its scene.
    pub object: usize,
    /// Name of its material.
    pub material: String,
    /// Values of the properties there, images included.
    pub inputs: Inputs<f64>,
}

/// What a lobe contributes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LobeShare {
    /// The lobe; what it stands for is told at [`SCATTERING`].
    pub lobe: Lobe,
    /// Its name in [`burnish_material::LOBES`].
    pub name: &'static str,
    /// Its part of the radiance.
    pub radiance: [f64; 3],
    /// The luminance of that over the luminance of the pixel, `[0, 1]`; 0 in a black pixel.
    pub share: f64,
}

/// Explains the pixel in column `x` and row `y` (from the top) of a picture of this size; beyond its border, the nearest one. Equal arguments give
/// equal answers. Takes some microseconds per sample, on the calling thread.
pub fn explain(prepared: &Prepared, x: usize, y: usize, width: usize, height: usize, samples: u32) -> Explanation {
    let (width, height, samples) = (width.max(1), height.max(1), samples.max(REPLICATES as u32));
    let (x, y) = (x.min(width - 1), y.min(height - 1));
    let view = View::new(prepared, width, height);
    let mut ledger = Ledger::default();
    let mut batch = prepared.take_batch();
    for first in (0..samples).step_by(BATCH) {
        let numbers = first..samples.min(first + BATCH as u32);
        follow(prepared, &view, (y * width + x) as u32, numbers, SEED, &mut batch, &mut ledger);
    }
    prepared.give_batch(batch);

    let weights = replicate_weights(samples);
    let scale = 1.0 / f64::from(samples);
    let radiance = std::array::from_fn(|k| scale * ledger.totals.iter().map(|total| total[k]).sum::<f64>());
    let of_replicate = |r: usize, k: usize| ledger.totals[r][k] * scale / weights[r];
    let variance = |k: usize| variance_of_mean(&std::array::from_fn(|r| of_replicate(r, k)), &weights);
    let luminance = Rgb(radiance).luminance();
    let part = |(lobe, sum): (Lobe, [f64; 3])| {
        let radiance = sum.map(|c| scale * c);
        let share = if luminance > 0.0 { Rgb(radiance).luminance() / luminance } else { 0.0 };
        LobeShare { lobe, name: lobe.def().name, radiance, share }
    };
    let is_shown = |(lobe, sum): &(Lobe, [f64; 3])| ledger.seen.has(*lobe) || sum.iter().any(|c| *c > 0.0);
    let mut lobes: Vec<LobeShare> = SCATTERING.into_iter().zip(ledger.lobes).filter(is_shown).map(part).collect();
    lobes.sort_by(|a, b| b.share.total_cmp(&a.share));
    Explanation {
        surface: middle(prepared, &view, x, y),
        lobes,
        emission: ledger.emission.map(|c| scale * c),
        through: ledger.through.map(|c| scale * c),
        radiance,
        standard_error: std::array::from_fn(|k| variance(k).sqrt()),
        samples,
    }
}

/// Sums of what paths found.
#[derive(Default)]
struct Ledger {
    /// All, by replicate.
    totals: [[f64; 3]; REPLICATES],
    emission: [f64; 3],
    through: [f64; 3],
    lobes: ByLobe<[f64; 3]>,
    /// Lobes of the surfaces that scattered.
    seen: LobeSet,
}

/// What light found by a path is put down to.
enum Cause<'a> {
    Through,
    Emission,
    Lobes(&'a ByLobe<[f32; 3]>),
}

impl Ledger {
    fn add(&mut self, replicate: usize, cause: &Cause<'_>, light: [f32; 3]) {
        for (k, c) in light.map(f64::from).into_iter().enumerate() {
            self.totals[replicate][k] += c;
            match cause {
                Cause::Through => self.through[k] += c,
                Cause::Emission => self.emission[k] += c,
                Cause::Lobes(shares) => {
                    for (sum, share) in self.lobes.iter_mut().zip(*shares) {
                        sum[k] += f64::from(share[k]) * c;
                    }
                }
            }
        }
    }
}

/// What is known of the paths of a batch, branches included.
struct Book<'a> {
    /// Sample number of the first path.
    first: u32,
    /// What each saw at its latest hit before it was scattered, and its wavelength where that matters.
    seen: Vec<Option<(Seen<'a>, Option<Wavelength<f32>>)>>,
    /// How the lobes of its first surface share what it finds from there.
    shares: Vec<Option<ByLobe<[f32; 3]>>>,
}

impl Book<'_> {
    /// The path from the camera that a path is or grew from.
    fn trunk(paths: &Paths, path: usize) -> usize {
        if path < paths.trunks { path } else { paths.parents[path - paths.trunks] as usize }
    }

    fn replicate(&self, paths: &Paths, path: usize) -> usize {
        (self.first as usize + Self::trunk(paths, path)) % REPLICATES
    }

    /// Shares for light that comes to the first surface of a path from a direction.
    fn shares(&self, paths: &Paths, path: usize, direction: Vec3, is_delta: bool) -> Option<ByLobe<[f32; 3]>> {
        let (seen, light) = self.seen[Self::trunk(paths, path)].as_ref()?;
        Some(seen.shares(direction, *light, is_delta))
    }

    /// Moves the light that paths have found to the ledger; `otherwise` is the cause for those that no surface has scattered yet.
    fn collect(&self, paths: &mut Paths, ledger: &mut Ledger, otherwise: &Cause<'_>) {
        for path in 0..paths.trunks + paths.parents.len() {
            let light = [0, 1, 2].map(|k| std::mem::take(&mut paths.radiance[k][path]));
            if light == [0.0; 3] {
                continue;
            }
            let replicate = self.replicate(paths, path);
            match &self.shares[path] {
                Some(shares) => ledger.add(replicate, &Cause::Lobes(shares), light),
                None => ledger.add(replicate, otherwise, light),
            }
        }
    }
}

/// Follows samples of a pixel to their ends.
fn follow(prepared: &Prepared, view: &View, pixel: u32, samples: Range<u32>, seed: u64, batch: &mut Batch, ledger: &mut Ledger) {
    let places: Vec<Place> = samples.clone().map(|sample| Place { cell: 0, pixel, sample }).collect();
    let tile = Tile { places: &places };
    let room = 2 * places.len();
    let mut book = Book { first: samples.start, seen: vec![None; room], shares: vec![None; room] };
    let mut stats = PassStats::default();
    batch.begin(tile.paths(), prepared.surfaces.len());
    dispatch(Raygen { prepared, view, tile, seed, paths: &mut batch.paths });
    for vertex in 0..prepared.max_bounces.saturating_add(2 + PASS_LIMIT) {
        if batch.active.is_empty() {
            break;
        }
        meet(prepared, batch, vertex, &mut stats);
        // Of bodies that a path entered without being scattered.
        let from_inside = batch.shadows.rays.len();
        book.collect(&mut batch.paths, ledger, &Cause::Through);
        look(prepared, batch, &mut book, ledger);
        // Photons are not traced, so paths must find all light.
        batch.paths.is_from_receiver.fill(false);
        shade(prepared, batch, vertex, &mut stats);
        book.collect(&mut batch.paths, ledger, &Cause::Emission);
        connect(prepared, batch, from_inside, &book, ledger, &mut stats);
        std::mem::swap(&mut batch.active, &mut batch.next);
        let paths = &batch.paths;
        for &id in &batch.active {
            let path = id as usize;
            if paths.bounces[path] > 0 && book.shares[path].is_none() {
                let direction = Vec3::from([0, 1, 2].map(|k| paths.direction[k][path]));
                book.shares[path] = book.shares(paths, path, direction, paths.pdf[path] == 0.0);
            }
        }
    }
}

/// Notes what paths that no surface has scattered yet see.
fn look<'a>(prepared: &'a Prepared, batch: &Batch, book: &mut Book<'a>, ledger: &mut Ledger) {
    let paths = &batch.paths;
    for &id in batch.lists.iter().flatten() {
        let path = id as usize;
        if book.shares[path].is_some() {
            continue;
        }
        let direction = Vec3::from([0, 1, 2].map(|k| paths.direction[k][path]));
        let seen = Seen::new(prepared, &paths.hits[path], direction, paths.width_at_hit(path));
        let light = seen.surface.lobes.has(Lobe::dispersion).then(|| wavelength::<f32>(paths, &[path; MAX_LANES]));
        ledger.seen = ledger.seen.union(seen.surface.lobes);
        book.seen[path] = Some((seen, light));
    }
}

/// Adds the light of connections; the first `from_inside` start within bodies.
fn connect(
    prepared: &Prepared,
    batch: &mut Batch,
    from_inside: usize,
    book: &Book<'_>,
    ledger: &mut Ledger,
    stats: &mut PassStats,
) {
    let Batch { paths, shadows, .. } = batch;
    if shadows.rays.is_empty() {
        return;
    }
    trace_shadows(prepared, shadows);
    for (i, (&target, &light)) in shadows.targets.iter().zip(&shadows.contributions).enumerate() {
        if shadows.blocked[i] || !stats.accepts(light) {
            continue;
        }
        let path = target as usize;
        let replicate = book.replicate(paths, path);
        match &book.shares[path] {
            Some(shares) => ledger.add(replicate, &Cause::Lobes(shares), light),
            None if i < from_inside => ledger.add(replicate, &Cause::Through, light),
            None => {
                let shares = book.shares(paths, path, shadows.rays[i].direction, false).unwrap_or_default();
                ledger.add(replicate, &Cause::Lobes(&shares), light);
            }
        }
    }
}

/// What the ray through the middle of a pixel meets first; surfaces that are cut away there are passed.
fn middle(prepared: &Prepared, view: &View, x: usize, y: usize) -> Option<SurfacePoint> {
    let (u, v) = ((x as f32 + 0.5) / view.width as f32, (y as f32 + 0.5) / view.height as f32);
    let direction = view.basis.direction(u, v);
    let mut ray = Ray::new(view.basis.origin, direction);
    for _ in 0..PASS_LIMIT {
        let hit = prepared.geometry.bvh.closest(&ray);
        if hit.is_miss() {
            return None;
        }
        let seen = Seen::new(prepared, &hit, direction, view.spread() * hit.t);
        if seen.optics.opacity > 0.0 {
            let vector = |v: V3<f32>| [v.x, v.y, v.z].map(f64::from);
            let cosine = f64::from(seen.wo.dot(seen.frame.n)).clamp(-1.0, 1.0);
            return Some(SurfacePoint {
                position: prepared.geometry.in_scene(vector(seen.at.position).into()).to_array(),
                normal: vector(seen.frame.n),
                uv: seen.at.uv.map(f64::from),
                view_angle: cosine.acos().to_degrees(),
                depth: f64::from(hit.t) / prepared.geometry.scale,
                object: seen.object as usize,
                material: seen.surface.name().to_owned(),
                inputs: seen.exact_inputs(),
            });
        }
        (ray.t_min, ray.excluded) = (hit.t, hit.triangle);
    }
    None
}

#[cfg(test)]
mod tests;
