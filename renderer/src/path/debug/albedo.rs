//! Directional albedos of a point towards the camera, by drawing directions from its BSDF.

use super::colors::Color;
use crate::bsdf::{Bsdf, ByLobe, SCATTERING, View, interpret};
use crate::lanes::{Kernel, Lanes, Mask, dispatch};
use crate::path::raygen::splat;
use crate::path::sampler::{Group, MAX_LANES, draw, per_lane};
use crate::path::seen::Seen;
use crate::vector::{Rgb, V3};
use glam::Vec3;

/// What the surface reflects and lets through to the camera of light from everywhere.
pub(super) fn total(seen: &Seen<'_>, samples: usize) -> Color {
    dispatch(Albedo { seen, samples, divides: false })[0]
}

/// The same for each lobe.
pub(super) fn by_lobe(seen: &Seen<'_>, samples: usize) -> ByLobe<Color> {
    dispatch(Albedo { seen, samples, divides: true })
}

struct Albedo<'a> {
    seen: &'a Seen<'a>,
    samples: usize,
    /// Whether lobes are told apart; otherwise all stands in the first place.
    divides: bool,
}

impl Kernel for Albedo<'_> {
    type Output = ByLobe<Color>;

    #[inline(always)]
    fn run<L: Lanes>(self) -> ByLobe<Color> {
        let Self { seen, samples, divides } = self;
        let surface = seen.surface;
        let vector = |v: V3<f32>| splat::<L>(Vec3::new(v.x, v.y, v.z));
        let optics = interpret(&seen.inputs.convert(L::splat), surface.lobes, L::of(surface.length_scale));
        let coat_normal = surface.has_coat_normal().then(|| vector(seen.frame.local(seen.coat_normal)));
        let view = View { coat_normal, ..View::new(vector(seen.frame.local(seen.wo))) };
        let bsdf = Bsdf::prepare(&optics, &surface.albedos, surface.lobes, &view);
        let mut sums = [Rgb::black(); SCATTERING.len()];
        for first in (0..samples).step_by(L::WIDTH) {
            let indices = per_lane(0u32, |i| (first + i) as u32);
            let sample = bsdf.sample(draw(Group::Bsdf, 0, &[0; MAX_LANES], &indices));
            let is_used = sample.is_valid & <L::Mask as Mask>::from_fn(|i| first + i < samples);
            let weight = Rgb::select(is_used, sample.weight, Rgb::black());
            if !divides {
                sums[0] = sums[0] + weight;
                continue;
            }
            for (sum, share) in sums.iter_mut().zip(bsdf.shares(sample.wi, sample.is_delta)) {
                *sum = *sum + weight * share;
            }
        }
        // No closures around lanes: they are not always inlined into code for wider instructions.
        let scale = 1.0 / samples.max(1) as f32;
        let mut albedos = [[0.0; 3]; SCATTERING.len()];
        for (albedo, sum) in albedos.iter_mut().zip(&sums).take(if divides { SCATTERING.len() } else { 1 }) {
            for (mean, sum) in albedo.iter_mut().zip(&sum.0) {
                *mean = scale * sum.to_array().iter().sum::<f32>();
            }
        }
        albedos
    }
}
