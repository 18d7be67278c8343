//! Light tracing of caustics: photons from the hot light through the casters to what the camera sees of the receivers.
//!
//! Each photon starts in a direction of the hot light, on a disc that covers the casters, and must meet one of them first. At every receiver
//! after that it is connected to the camera; then it goes on. All paths of the partition (`caustics`) are found so, and no others. Photons
//! are numbered like samples: what a number finds does not depend on threads or passes.

mod scatter;

use super::PassStats;
use super::batch::{Batch, Paths};
use super::caustics::Caustics;
use super::frame::Frame;
use super::light::sin_cos_turn;
use super::prepared::Prepared;
use super::raygen::{View, splat};
use super::sampler::{Group, draw, per_lane, pixel_seed};
use super::shade::{lane_of, lane_vector};
use super::trace::{PASS_LIMIT, trace, trace_shadows};
use crate::bsdf::dispersion::spectrum;
use crate::bvh::NONE;
use crate::lanes::{Kernel, Lanes, dispatch};
use scatter::Scatter;
use std::f64::consts::PI;

/// Camera samples for one photon: more photons gain less than they cost.
const SAMPLES_PER_PHOTON: usize = 16;

/// Light that a photon brings to a pixel, for one photon emitted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Splat {
    /// Number of the pixel, row by row.
    pub pixel: u32,
    /// Radiance times the number of photons, linear Rec.709.
    pub light: [f32; 3],
}

/// Consecutive photons of one replicate.
#[derive(Clone, Copy, Debug)]
pub(super) struct Photons {
    /// The replicate.
    pub replicate: u32,
    /// Number of the first.
    pub first: u64,
    /// How many.
    pub count: usize,
}

/// Photons that go with one sample of every pixel.
pub(super) fn photons_per_sample(width: usize, height: usize) -> usize {
    (width * height).div_ceil(SAMPLES_PER_PHOTON)
}

/// Traces photons and appends what they bring to pixels.
#[expect(clippy::too_many_arguments, reason = "called once; a struct would only rename the arguments")]
pub(super) fn trace_photons(
    prepared: &Prepared,
    caustics: &Caustics,
    view: &View,
    photons: Photons,
    seed: u64,
    batch: &mut Batch,
    splats: &mut Vec<Splat>,
    stats: &mut PassStats,
) {
    batch.begin(photons.count, prepared.surfaces.len());
    dispatch(Emit { prepared, caustics, photons, seed, paths: &mut batch.paths });
    let carries = |paths: &Paths, i: usize| (0..3).any(|k| paths.throughput[k][i] > 0.0);
    batch.active.retain(|&i| carries(&batch.paths, i as usize));
    for vertex in 0..prepared.max_bounces.saturating_add(2 + PASS_LIMIT) {
        if batch.active.is_empty() {
            break;
        }
        batch.shadows.clear();
        trace(prepared, batch, vertex, stats);
        let Batch { paths, active, next, lists, shadows, .. } = &mut *batch;
        next.clear();
        for (surface, list) in prepared.surfaces.iter().zip(lists.iter()) {
            if !list.is_empty() {
                dispatch(Scatter { prepared, surface, view, list, vertex, paths, next, shadows, stats });
            }
        }
        if !shadows.rays.is_empty() {
            trace_shadows(prepared, shadows);
            for (i, &pixel) in shadows.targets.iter().enumerate() {
                if !shadows.blocked[i] {
                    splats.push(Splat { pixel, light: shadows.contributions[i] });
                }
            }
        }
        std::mem::swap(active, next);
    }
}

/// First stage: where photons start.
struct Emit<'a> {
    prepared: &'a Prepared,
    caustics: &'a Caustics,
    photons: Photons,
    seed: u64,
    paths: &'a mut Paths,
}

impl Kernel for Emit<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { prepared, caustics, photons, seed, paths } = self;
        let sphere = caustics.casters;
        let (center, radius) = (splat::<L>(sphere.center), L::of(f64::from(sphere.radius)));
        let area = L::of(PI * f64::from(sphere.radius) * f64::from(sphere.radius));
        for start in (0..photons.count).step_by(L::WIDTH) {
            let number = |i: usize| photons.first + (start + i) as u64;
            // Streams of their own beside those of the pixels, which are fewer than 2^31.
            let seeds = per_lane(0u32, |i| pixel_seed(seed, photons.replicate, u32::MAX - (number(i) >> 32) as u32));
            let indices = per_lane(0u32, |i| number(i) as u32);
            let u = draw::<L>(Group::Pixel, 0, &seeds, &indices);
            let light = prepared.light.sample_hot(u[0], u[1]);
            let disc = Frame::around(light.direction);
            let r = radius * u[2].sqrt();
            let (sin, cos) = sin_cos_turn(u[3]);
            let far = light.direction.scale(L::of(f64::from(caustics.distance)));
            let origin = center + far + disc.t.scale(r * cos) + disc.b.scale(r * sin);
            let has_light = light.pdf.gt(L::zero());
            let power = light.radiance.scale(L::select(has_light, area / L::select(has_light, light.pdf, L::one()), L::zero()));
            let color: [L; 4] = draw(Group::Medium, 0, &seeds, &indices);
            for i in 0..L::WIDTH.min(photons.count - start) {
                let path = start + i;
                let (o, d) = (lane_vector(origin, i).to_array(), lane_vector(-light.direction, i).to_array());
                let power = lane_of(power, i);
                for k in 0..3 {
                    paths.origin[k][path] = o[k];
                    paths.direction[k][path] = d[k];
                    paths.throughput[k][path] = power[k];
                    paths.sigma_a[k][path] = 0.0;
                    paths.sigma_s[k][path] = 0.0;
                }
                // What roulette compares with.
                paths.radiance[0][path] = power.iter().fold(0.0, |a, b| f32::max(a, *b));
                if prepared.has_dispersion {
                    paths.wavelength[path] = spectrum().wavelength(f64::from(color[2].lane(i))) as f32;
                }
                paths.is_dispersed[path] = false;
                paths.body[path] = NONE;
                paths.pdf[path] = 0.0;
                paths.cone_width[path] = 0.0;
                paths.cone_spread[path] = 0.0;
                paths.bounces[path] = 0;
                paths.excluded[path] = NONE;
                paths.seeds[path] = seeds[i];
                paths.indices[path] = indices[i];
            }
        }
    }
}
