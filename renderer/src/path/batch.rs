//! State of the paths in flight on one thread: one array per number, one entry per path, reused from batch to batch.

use super::film::Cell;
use super::inside::Connection;
use super::raygen::Place;
use super::sampler::mix;
use crate::bvh::{Hit, NONE, Order, Ray};

/// Paths in flight per thread. Their state stays in the second-level cache, and lists by material are long enough to fill lanes.
pub(super) const BATCH: usize = 4096;

/// Three numbers per path.
pub(super) type Triples = [Vec<f32>; 3];

/// Paths, by number in the batch.
#[derive(Debug, Default)]
pub(super) struct Paths {
    /// Start of the next ray, normalised units.
    pub origin: Triples,
    /// Unit direction of the next ray.
    pub direction: Triples,
    /// Product of weights.
    pub throughput: Triples,
    /// Light found so far.
    pub radiance: Triples,
    /// Absorption in the body that the path is in, 1/normalised unit; zeros outside.
    pub sigma_a: Triples,
    /// Scattering in it.
    pub sigma_s: Triples,
    /// The object whose body that is, where it scatters.
    pub body: Vec<u32>,
    /// Wavelength of the path, nanometres: where anything disperses.
    pub wavelength: Vec<f32>,
    /// Whether the path has become light of its wavelength.
    pub is_dispersed: Vec<bool>,
    /// Density of the last direction that a non-delta lobe chose; 0 if light sampling could not have found it.
    pub pdf: Vec<f32>,
    /// Whether the path arrives from a collision that has been connected to the light.
    pub is_connected: Vec<bool>,
    /// Width of the cone where the ray starts, normalised units.
    pub cone_width: Vec<f32>,
    /// How fast it widens: width per distance.
    pub cone_spread: Vec<f32>,
    /// Scattering events so far.
    pub bounces: Vec<u32>,
    /// The triangle that the path leaves.
    pub excluded: Vec<u32>,
    /// Seed of the pixel and replicate.
    pub seeds: Vec<u32>,
    /// Sample number within the replicate.
    pub indices: Vec<u32>,
    /// Whether the path met a surface that did not let it pass straight on.
    pub is_covered: Vec<bool>,
    /// Whether the path came from the camera to a receiver of caustics first, and through no scattering body since.
    pub is_from_receiver: Vec<bool>,
    /// Whether photons bring the hot part of the light that the next ray may find.
    pub is_cold: Vec<bool>,
    /// Whether connections have brought the light that the next ray may find.
    pub is_lit: Vec<bool>,
    /// Where the last ray arrived.
    pub hits: Vec<Hit>,
    /// Paths that began at the camera; those after them are branches.
    pub trunks: usize,
    /// The path that each branch grew from.
    pub parents: Vec<u32>,
}

impl Paths {
    /// Room for `count` paths; values of earlier paths are left over.
    pub(super) fn resize(&mut self, count: usize) {
        for triple in [
            &mut self.origin,
            &mut self.direction,
            &mut self.throughput,
            &mut self.radiance,
            &mut self.sigma_a,
            &mut self.sigma_s,
        ] {
            for column in triple {
                column.resize(count, 0.0);
            }
        }
        for column in [&mut self.pdf, &mut self.cone_width, &mut self.cone_spread] {
            column.resize(count, 0.0);
        }
        self.body.resize(count, NONE);
        self.wavelength.resize(count, 0.0);
        self.is_dispersed.resize(count, false);
        self.is_connected.resize(count, false);
        self.bounces.resize(count, 0);
        self.excluded.resize(count, NONE);
        self.seeds.resize(count, 0);
        self.indices.resize(count, 0);
        for column in [&mut self.is_covered, &mut self.is_from_receiver, &mut self.is_cold, &mut self.is_lit] {
            column.resize(count, false);
        }
        self.hits.resize(count, Hit::MISS);
    }

    /// A second path from where one is, with its state but for the light found and the random numbers. There must be room.
    #[inline(always)]
    pub(super) fn branch(&mut self, path: usize) -> usize {
        let branch = self.trunks + self.parents.len();
        self.parents.push(path as u32);
        for triple in [&mut self.origin, &mut self.direction, &mut self.throughput, &mut self.sigma_a, &mut self.sigma_s] {
            for column in triple {
                column[branch] = column[path];
            }
        }
        for column in &mut self.radiance {
            column[branch] = 0.0;
        }
        for column in [&mut self.pdf, &mut self.cone_width, &mut self.cone_spread, &mut self.wavelength] {
            column[branch] = column[path];
        }
        for column in [&mut self.body, &mut self.bounces, &mut self.excluded, &mut self.indices] {
            column[branch] = column[path];
        }
        for column in [
            &mut self.is_dispersed,
            &mut self.is_connected,
            &mut self.is_covered,
            &mut self.is_from_receiver,
            &mut self.is_cold,
            &mut self.is_lit,
        ] {
            column[branch] = column[path];
        }
        self.seeds[branch] = mix(self.seeds[path] ^ BRANCH_SALT);
        self.hits[branch] = self.hits[path];
        branch
    }

    /// Adds what branches have found to the paths that they grew from.
    pub(super) fn fold_branches(&mut self) {
        for (i, parent) in self.parents.iter().enumerate() {
            for column in &mut self.radiance {
                column[*parent as usize] += column[self.trunks + i];
            }
        }
    }
}

/// Sets the random numbers of a branch apart.
const BRANCH_SALT: u32 = 0x5bd1_e995;

/// Rays towards the light that still have to be found free.
#[derive(Debug, Default)]
pub(super) struct Shadows {
    /// From the surface, normalised units.
    pub rays: Vec<Ray>,
    /// What arrives if the way is free.
    pub contributions: Vec<[f32; 3]>,
    /// Extinction along the first stretch, 1/normalised unit.
    pub sigmas: Vec<[f32; 3]>,
    /// What gets the light: the path, or the pixel where a photon is connected to the camera.
    pub targets: Vec<u32>,
    /// Whether the way is blocked.
    pub blocked: Vec<bool>,
    /// Memory to sort them in.
    pub order: Order,
}

impl Shadows {
    /// No rays; memory stays.
    pub(super) fn clear(&mut self) {
        self.rays.clear();
        self.contributions.clear();
        self.sigmas.clear();
        self.targets.clear();
    }
}

/// Everything that one thread needs for a batch.
#[derive(Debug, Default)]
pub(super) struct Batch {
    /// Paths by number.
    pub paths: Paths,
    /// Numbers of the paths that have a ray to trace.
    pub active: Vec<u32>,
    /// Those that will have one at the next depth.
    pub next: Vec<u32>,
    /// Paths by what they hit: one list per surface.
    pub lists: Vec<Vec<u32>>,
    /// Paths that left the scene.
    pub missed: Vec<u32>,
    /// Light connections of this depth.
    pub shadows: Shadows,
    /// Connections from inside of scattering bodies of this depth.
    pub inside: Vec<Connection>,
    /// Rays of the active paths.
    pub rays: Vec<Ray>,
    /// Memory to sort them in.
    pub order: Order,
    /// Their hits.
    pub hits: Vec<Hit>,
    /// What the pixels of the job hold.
    pub cells: Vec<Cell>,
    /// Where each path belongs.
    pub places: Vec<Place>,
}

impl Batch {
    /// Prepares for `count` paths over `surfaces` kinds of surface; each path may grow one branch.
    pub(super) fn begin(&mut self, count: usize, surfaces: usize) {
        self.paths.resize(2 * count);
        self.paths.trunks = count;
        self.paths.parents.clear();
        self.lists.resize_with(surfaces, Vec::new);
        self.active.clear();
        self.active.extend(0..count as u32);
    }
}
