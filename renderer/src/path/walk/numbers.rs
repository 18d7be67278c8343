//! The random numbers of a walk: a hash of (seed, sample, vertex, flight, dimension), so that any thread finds the same walk.

/// What a number decides within one flight and the collision at its end.
#[derive(Clone, Copy)]
pub(super) enum Dimension {
    /// The channel whose density is drawn from.
    Channel,
    /// Steered or isotropic.
    Steer,
    /// Cosine of the new direction.
    Cosine,
    /// Its azimuth.
    Azimuth,
    /// Length of the flight.
    Length,
    /// Whether a faint walk goes on.
    Roulette,
    /// Height of the exit point on the sphere of a jump.
    SphereHeight,
    /// Azimuth of that point.
    SphereAzimuth,
    /// Channel whose exit cosine is drawn.
    JumpChannel,
    /// Cosine against the normal of the sphere.
    JumpCosine,
    /// Azimuth around it.
    JumpAzimuth,
    /// Whether a walk made faint by a jump goes on.
    JumpRoulette,
    /// Whether a collision replaces the one that the reservoir holds.
    Reservoir,
}

/// Numbers of one flight lie this far apart; more than there are dimensions.
const STRIDE: u64 = 16;
const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;

/// SplitMix64's finaliser (Steele, Lea, Flood 2014): 64 bits, because walks draw more numbers than 32 bits keep apart.
fn finalize(mut x: u64) -> u64 {
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

/// All numbers of one walk.
#[derive(Clone, Copy)]
pub(super) struct Numbers {
    key: u64,
}

impl Numbers {
    /// Of the walk that starts at this vertex of this sample.
    pub(super) fn new(seed: u32, index: u32, vertex: u32) -> Self {
        let sample = finalize((u64::from(seed) << 32 | u64::from(index)).wrapping_add(GOLDEN));
        Self { key: finalize(sample ^ finalize(u64::from(vertex).wrapping_mul(GOLDEN).wrapping_add(1))) }
    }

    /// One number in (0, 1), neither end included.
    pub(super) fn at(&self, flight: u32, dimension: Dimension) -> f64 {
        self.number(u64::from(flight) * STRIDE + dimension as u64 + 1)
    }

    /// Numbers that belong to no flight.
    pub(super) fn spare(&self, k: u32) -> f64 {
        self.number(u64::from(u32::MAX) * STRIDE + u64::from(k) + 1)
    }

    fn number(&self, number: u64) -> f64 {
        let x = finalize(self.key.wrapping_add(number.wrapping_mul(GOLDEN)));
        ((x >> 12) as f64 + 0.5) * (1.0 / 4_503_599_627_370_496.0)
    }
}
