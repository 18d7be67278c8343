//! Between tracing and shading: paths inside scattering bodies walk until they meet a surface.

use super::PassStats;
use super::batch::{Batch, Paths};
use super::inside::{self, CONNECTIONS, Connection, Passage};
use super::prepared::Prepared;
use super::sampler::{Group, MAX_LANES, draw};
use super::walk::{Body, End, Entry, Interior, Medium, Method, Reservoir, WalkStats, walk};
use crate::bvh::{Hit, NONE};
use glam::Vec3;

/// Walks on with the paths of `active` that are in a scattering body; their first segments have been traced. Those that meet a surface get
/// that hit; the others are removed. `vertex` counts the interfaces that each path met before.
pub(super) fn scatter(prepared: &Prepared, batch: &mut Batch, vertex: u32, stats: &mut PassStats) {
    let mut done = WalkStats::default();
    let Batch { paths, active, inside, .. } = &mut *batch;
    active.retain(|&id| {
        let i = id as usize;
        let sigma_s = [0, 1, 2].map(|k| paths.sigma_s[k][i]);
        sigma_s.iter().all(|s| *s <= 0.0) || step(prepared, paths, inside, i, sigma_s, vertex, &mut done)
    });
    stats.walks += done.walks;
    stats.collisions += done.collisions;
    stats.cut_walks += done.cut;
    if !batch.inside.is_empty() {
        inside::connect(prepared, batch, vertex, stats);
    }
}

/// One walk. False: nothing is left of the path.
fn step(
    prepared: &Prepared,
    paths: &mut Paths,
    inside: &mut Vec<Connection>,
    i: usize,
    sigma_s: [f32; 3],
    vertex: u32,
    done: &mut WalkStats,
) -> bool {
    let at = |triple: &super::batch::Triples| [0, 1, 2].map(|k| triple[k][i]);
    let medium = Medium { sigma_s, sigma_a: at(&paths.sigma_a) };
    let radius = prepared.radius_of_object.get(paths.body[i] as usize).copied().unwrap_or(1.0);
    let triangle = paths.excluded[i];
    let direction = Vec3::from(at(&paths.direction));
    let normal = if triangle == NONE { -direction } else { Vec3::from(prepared.geometry.normals[triangle as usize]) };
    let u = draw::<f32>(Group::Medium, vertex, &[paths.seeds[i]; MAX_LANES], &[paths.indices[i]; MAX_LANES]);
    let entry = Entry {
        position: Vec3::from(at(&paths.origin)).as_dvec3(),
        direction,
        triangle,
        normal,
        throughput: at(&paths.throughput),
        first: paths.hits[i],
        seed: paths.seeds[i],
        index: paths.indices[i],
        vertex,
        channel_u: u[1],
    };
    let collisions = done.collisions;
    let interior = Interior::new(&prepared.geometry, paths.body[i]);
    let body = Body::new(&medium, radius);
    let passage = passage(prepared, paths, i);
    let mut reservoir = Reservoir::new(passage.is_some());
    let end = walk(&interior, &body, &entry, Method::Jumping, &mut reservoir, done);
    if let (Some(mut source), Some(passage)) = (reservoir.source(), passage) {
        source.normal = interior.outer_normal(source.position).unwrap_or(source.normal);
        for number in 0..CONNECTIONS {
            let u = [0, 1, 2].map(|k| entry.number(3 * number + k) as f32);
            inside.push(Connection::new(i as u32, number, source, body.extinction(), passage.over(source.depth / radius), u));
        }
    }
    match end {
        End::Surface { hit, position, direction, throughput, source_normal } => {
            paths.is_connected[i] = source_normal.is_some_and(|n| {
                let n = interior.outer_normal(position).unwrap_or(n);
                inside::reaches(prepared, n, &hit)
            });
            paths.hits[i] = hit;
            let position = position.as_vec3();
            for k in 0..3 {
                paths.origin[k][i] = position[k];
                paths.direction[k][i] = direction[k];
                paths.throughput[k][i] = throughput[k];
            }
            if done.collisions > collisions {
                // Light sampling could not have found what scattering sends out.
                paths.pdf[i] = 0.0;
            }
            true
        }
        // Nothing arrives through a scattering body without end, but for channels that it does not touch.
        End::Lost { throughput, .. } => {
            for (column, t) in paths.throughput.iter_mut().zip(throughput) {
                column[i] = t;
            }
            paths.hits[i] = Hit::MISS;
            throughput.iter().any(|t| *t > 0.0)
        }
        End::Absorbed => false,
    }
}

/// How the body of a path is connected to the light; none where it is not.
fn passage(prepared: &Prepared, paths: &Paths, i: usize) -> Option<Passage> {
    if !prepared.light.is_sampled() || paths.bounces[i] > prepared.max_bounces {
        return None;
    }
    prepared.passage_of_object.get(paths.body[i] as usize).copied().flatten()
}
