//! Numbers for tests: the same in every run.

use burnish_renderer::lanes::Lanes;

/// A number in `[0, 1)` in every lane: a Kronecker sequence in `i`, so that sums over many converge fast.
pub fn unit<L: Lanes>(i: usize, dimension: u32) -> L {
    // Powers of the inverse of the root of x^(d+1) = x + 1 for d = 4 dimensions; further ones begin elsewhere.
    const STEPS: [f64; 4] = [0.856_674_883_854_503, 0.733_891_856_627_152, 0.628_706_720_892_446, 0.538_597_256_984_949];
    let x = 0.5 + (i as f64 + 1.0) * STEPS[dimension as usize % 4] + 0.377 * f64::from(dimension / 4) * (1.0 + i as f64 * 0.618);
    L::of(x - x.floor())
}

/// Random numbers, the same in every run. Source: Steele, Lea, Flood 2014 (SplitMix64).
#[derive(Clone, Debug)]
pub struct Random(u64);

impl Random {
    /// A sequence of its own for every seed.
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0xA076_1D64_78BD_642F) ^ 0xE703_7ED1_A0B4_28DB)
    }

    /// The next number in `[0, 1)`.
    pub fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    /// The next number in `[a, b)`.
    pub fn between(&mut self, a: f64, b: f64) -> f64 {
        a + (b - a) * self.unit()
    }

    /// The next whole number below `count`.
    pub fn below(&mut self, count: usize) -> usize {
        (self.unit() * count as f64) as usize
    }

    /// True that often.
    pub fn chance(&mut self, p: f64) -> bool {
        self.unit() < p
    }
}
