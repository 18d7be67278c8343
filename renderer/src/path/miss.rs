//! Fourth stage: light of the environment on paths that left the scene, and of the connections that were free.

use super::PassStats;
use super::batch::{Paths, Shadows};
use super::prepared::Prepared;
use super::sampler::per_lane;
use super::shade::{add, lane_of, load};
use crate::lanes::{Kernel, Lanes, Mask};
use crate::vector::{Rgb, V3};

/// Adds the environment's light to the paths of `list`, none of which connections have brought all light to.
pub(super) struct Miss<'a> {
    pub prepared: &'a Prepared,
    pub list: &'a [u32],
    pub paths: &'a mut Paths,
    pub stats: &'a mut PassStats,
}

impl Kernel for Miss<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { prepared, list, paths, stats } = self;
        for ids in list.chunks(L::WIDTH) {
            let id = per_lane(0usize, |i| ids[if i < ids.len() { i } else { 0 }] as usize);
            let [x, y, z] = load::<L>(&paths.direction, &id);
            let (mut radiance, light_pdf) = prepared.light.eval(V3::new(x, y, z));
            if prepared.caustics.is_some() {
                let is_cold = <L::Mask as Mask>::from_fn(|i| paths.is_cold[id[i]]);
                radiance = Rgb::select(is_cold, prepared.light.cold(radiance), radiance);
            }
            let pdf = L::gather_at(&paths.pdf, &id);
            // Density 0: a camera ray or a delta lobe, which light sampling cannot replace.
            let weight = L::select(pdf.gt(L::zero()), pdf / (pdf + light_pdf).max(L::of(1e-30)), L::one());
            // Nothing arrives through an absorbing medium without end.
            let sigma = Rgb(load::<L>(&paths.sigma_a, &id)) + Rgb(load(&paths.sigma_s, &id));
            let passage = sigma.map(|s| L::select(s.gt(L::zero()), L::zero(), L::one()));
            let light = (Rgb(load(&paths.throughput, &id)) * radiance * passage).scale(weight);
            for (i, id) in id.iter().enumerate().take(ids.len()) {
                add(paths, stats, *id, lane_of(light, i));
            }
        }
    }
}

/// Adds the light of the connections that are not blocked.
pub(super) fn accumulate(paths: &mut Paths, shadows: &Shadows, stats: &mut PassStats) {
    for (i, path) in shadows.targets.iter().enumerate() {
        if !shadows.blocked[i] {
            add(paths, stats, *path as usize, shadows.contributions[i]);
        }
    }
}
