//! One collision out of all of a walk, from which light is then looked for outside.
//!
//! Every collision may send light straight out of the body. To connect all of them to a light would cost more than the walk; one of
//! them, chosen in proportion to what is expected of it and weighted by the inverse of its chance, stands for all. Source: resampling
//! by reservoir, Chao 1982; Talbot et al. 2005.

use glam::{DVec3, Vec3};

/// The collision that stands for those that were offered so far.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::path) struct Reservoir {
    /// Whether collisions are wanted at all.
    is_open: bool,
    total: f64,
    position: DVec3,
    normal: Vec3,
    depth: f64,
    /// Weights of the walk there over what was expected.
    ratio: [f64; 3],
}

/// A collision that sends light out in all directions alike.
#[derive(Clone, Copy, Debug)]
pub(in crate::path) struct Source {
    /// Where, normalised units.
    pub position: DVec3,
    /// Outward normal of the nearest surface, as far as it is known, unit.
    pub normal: Vec3,
    /// About its distance, normalised units.
    pub depth: f32,
    /// What it sends out in all directions together, per channel, for the whole walk.
    pub throughput: [f32; 3],
}

impl Reservoir {
    /// `is_open`: whether a walk needs to offer anything.
    pub(in crate::path) fn new(is_open: bool) -> Self {
        Self { is_open, ..Self::default() }
    }

    /// Offers a collision with the weights `beta`, the nearest surface in the direction `normal` at about `depth`, of which `expected` (above 0, any common scale) is thought to come out. `u` in (0, 1).
    pub(super) fn offer(&mut self, position: DVec3, (normal, depth): (Vec3, f64), beta: [f64; 3], expected: f64, u: f64) {
        if !(expected > 0.0 && expected.is_finite()) {
            return;
        }
        self.total += expected;
        if u * self.total < expected {
            self.position = position;
            (self.normal, self.depth) = (normal, depth);
            self.ratio = beta.map(|x| x / expected);
        }
    }

    /// Whether collisions are wanted.
    pub(super) fn is_open(&self) -> bool {
        self.is_open
    }

    /// The chosen collision; none if nothing was offered.
    pub(in crate::path) fn source(&self) -> Option<Source> {
        let throughput = self.ratio.map(|x| (x * self.total) as f32);
        (self.total > 0.0).then_some(Source {
            position: self.position,
            normal: self.normal,
            depth: self.depth as f32,
            throughput,
        })
    }
}
