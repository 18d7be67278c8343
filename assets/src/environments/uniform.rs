//! The same light from everywhere, for tests that know the answer.

use glam::Vec3;

use crate::environment::Environment;

/// Radiance of exactly 1 in every direction: what reflects everything becomes invisible in it.
pub(super) fn white_furnace() -> Environment {
    Environment::from_fn("White furnace", 64, 32, |_| Vec3::ONE)
}

/// No light at all: what is seen then, the material emits.
pub(super) fn black() -> Environment {
    Environment::from_fn("Black", 64, 32, |_| Vec3::ZERO)
}
