//! State of the paths in flight on one thread: one array per number, one entry per path, reused from batch to batch.

use super::inside::Connection;
use crate::bvh::{Hit, NONE, Ray};

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
    /// Where the last ray arrived.
    pub hits: Vec<Hit>,
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
        self.is_covered.resize(count, false);
        self.hits.resize(count, Hit::MISS);
    }
}

/// Rays towards the light that still have to be found free.
#[derive(Debug, Default)]
pub(super) struct Shadows {
    /// From the surface, normalised units.
    pub rays: Vec<Ray>,
    /// What arrives if the way is free.
    pub contributions: Vec<[f32; 3]>,
    /// Extinction along the first stretch, 1/normalised unit.
    pub sigmas: Vec<[f32; 3]>,
    /// The path that gets the light.
    pub paths: Vec<u32>,
    /// Whether the way is blocked.
    pub blocked: Vec<bool>,
}

impl Shadows {
    /// No rays; memory stays.
    pub(super) fn clear(&mut self) {
        self.rays.clear();
        self.contributions.clear();
        self.sigmas.clear();
        self.paths.clear();
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
    /// Rays in the order in which they are traced.
    pub rays: Vec<Ray>,
    /// Their paths.
    pub order: Vec<u32>,
    /// Their hits.
    pub hits: Vec<Hit>,
    /// Sums of one tile, per pixel and replicate.
    pub sums: Vec<[f64; 3]>,
    /// Covered samples of one tile, per pixel.
    pub covered: Vec<u32>,
}

impl Batch {
    /// Prepares for `count` paths over `surfaces` kinds of surface.
    pub(super) fn begin(&mut self, count: usize, surfaces: usize) {
        self.paths.resize(count);
        self.lists.resize_with(surfaces, Vec::new);
        self.active.clear();
        self.active.extend(0..count as u32);
    }
}
