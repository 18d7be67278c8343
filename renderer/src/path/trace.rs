//! Second stage: nearest hits, sorted into lists by surface; and the free way of light connections.

use super::batch::{Batch, Shadows};
use super::scatter::scatter;
use super::shade::opacity_at;
use super::{PassStats, Prepared};
use crate::bvh::{Hit, Ray};
use glam::Vec3;

/// Interfaces that a ray may pass straight through before it counts as blocked.
pub(super) const PASS_LIMIT: u32 = 128;

/// Traces the active paths and puts each into the list of what it hit; those in scattering bodies after their walk.
pub(super) fn trace(prepared: &Prepared, batch: &mut Batch, vertex: u32, stats: &mut PassStats) {
    let Batch { paths, active, rays, order, hits, .. } = batch;
    let at = |triple: &super::batch::Triples, i: usize| Vec3::new(triple[0][i], triple[1][i], triple[2][i]);
    rays.clear();
    rays.extend(active.iter().map(|&i| {
        let i = i as usize;
        Ray { excluded: paths.excluded[i], ..Ray::new(at(&paths.origin, i), at(&paths.direction, i)) }
    }));
    hits.resize(rays.len(), Hit::MISS);
    prepared.geometry.bvh.trace_ordered(rays, hits, order);
    for (&i, hit) in active.iter().zip(hits.iter()) {
        paths.hits[i as usize] = *hit;
    }
    if prepared.has_scattering {
        scatter(prepared, batch, vertex, stats);
    }
    let Batch { paths, active, lists, missed, .. } = batch;
    lists.iter_mut().for_each(Vec::clear);
    missed.clear();
    for &i in active.iter() {
        let hit = &paths.hits[i as usize];
        if hit.is_miss() {
            // Connections may have brought all that there is.
            if !paths.is_lit[i as usize] {
                missed.push(i);
            }
        } else {
            let object = prepared.geometry.triangles[hit.triangle as usize][3];
            lists[prepared.surface_of_object[object as usize] as usize].push(i);
        }
    }
}

/// Decides which light connections are free, and weakens those that run through cut-through surfaces.
///
/// Opaque surfaces block, refracting ones too: what comes through them is found by the paths themselves.
pub(super) fn trace_shadows(prepared: &Prepared, shadows: &mut Shadows) {
    shadows.blocked.resize(shadows.rays.len(), false);
    if !prepared.has_cut_through {
        prepared.geometry.bvh.trace_any_ordered(&shadows.rays, &mut shadows.blocked, &mut shadows.order);
        // Light from far away does not cross a body that goes on for ever.
        for (blocked, sigma) in shadows.blocked.iter_mut().zip(&shadows.sigmas) {
            *blocked |= sigma.iter().all(|s| *s > 0.0);
        }
        for (contribution, sigma) in shadows.contributions.iter_mut().zip(&shadows.sigmas) {
            extinguish(contribution, sigma);
        }
        return;
    }
    for i in 0..shadows.rays.len() {
        let passage = pass(prepared, shadows.rays[i], shadows.sigmas[i]);
        shadows.blocked[i] = passage == [0.0; 3];
        for (c, p) in shadows.contributions[i].iter_mut().zip(passage) {
            *c *= p;
        }
    }
}

/// Nothing arrives through an absorbing medium without end.
fn extinguish(contribution: &mut [f32; 3], sigma: &[f32; 3]) {
    for (c, s) in contribution.iter_mut().zip(sigma) {
        if *s > 0.0 {
            *c = 0.0;
        }
    }
}

/// What is left of light along a ray through cut-through surfaces, and the absorbing bodies behind them.
fn pass(prepared: &Prepared, mut ray: Ray, mut sigma: [f32; 3]) -> [f32; 3] {
    let mut passage = [1.0f32; 3];
    for _ in 0..PASS_LIMIT {
        let hit = prepared.geometry.bvh.closest(&ray);
        if hit.is_miss() {
            extinguish(&mut passage, &sigma);
            return passage;
        }
        let object = prepared.geometry.triangles[hit.triangle as usize][3];
        let surface = &prepared.surfaces[prepared.surface_of_object[object as usize] as usize];
        if !surface.has_cut_through() {
            return [0.0; 3];
        }
        let (opacity, inside) = opacity_at(prepared, surface, &hit);
        let length = hit.t - ray.t_min;
        for k in 0..3 {
            passage[k] *= (1.0 - opacity) * (-sigma[k] * length).exp();
        }
        if passage == [0.0; 3] {
            return passage;
        }
        let is_entry = Vec3::from(prepared.geometry.normals[hit.triangle as usize]).dot(ray.direction) < 0.0;
        sigma = if is_entry { inside } else { [0.0; 3] };
        ray.t_min = hit.t;
        ray.excluded = hit.triangle;
    }
    [0.0; 3]
}
