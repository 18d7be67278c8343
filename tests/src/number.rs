//! Numbers for tests: the same in every run.

use burnish_renderer::lanes::Lanes;

/// A number in `[0, 1)` in every lane: a Kronecker sequence in `i`, so that sums over many converge fast.
pub fn unit<L: Lanes>(i: usize, dimension: u32) -> L {
    // Powers of the inverse of the root of x^(d+1) = x + 1 for d = 4 dimensions; further ones begin elsewhere.
    const STEPS: [f64; 4] = [0.856_674_883_854_503, 0.733_891_856_627_152, 0.628_706_720_892_446, 0.538_597_256_984_949];
    let x = 0.5 + (i as f64 + 1.0) * STEPS[dimension as usize % 4] + 0.377 * f64::from(dimension / 4) * (1.0 + i as f64 * 0.618);
    L::of(x - x.floor())
}
