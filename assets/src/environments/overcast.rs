//! A closed cover of clouds: the light without direction that hides nothing and flatters nothing.

use glam::Vec3;

use super::smoothstep;
use crate::environment::Environment;

/// Radiance at the zenith, slightly blue.
const ZENITH: Vec3 = Vec3::new(1.27, 1.29, 1.32);

/// Diffuse reflectance of the ground.
const GROUND: Vec3 = Vec3::new(0.19, 0.18, 0.165);

/// The overcast sky of the CIE, `L = L_zenith (1 + 2 sin(elevation)) / 3`, over a matte ground.
///
/// The irradiance of that sky on level ground is `7/9 π L_zenith`, so the ground shines with `7/9 GROUND L_zenith`; over one degree
/// around the horizon the two melt into each other.
pub(super) fn make() -> Environment {
    Environment::from_fn("Overcast sky", 512, 256, |d| {
        let sky = ZENITH * (1.0 + 2.0 * d.y.max(0.0)) / 3.0;
        let ground = GROUND * ZENITH * (7.0 / 9.0);
        ground.lerp(sky, smoothstep(-0.012, 0.006, d.y))
    })
}
