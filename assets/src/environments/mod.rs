//! The built-in environments: one file each, and a row in the table.

mod overcast;
mod studio;
mod sun;
mod uniform;

use glam::Vec3;

use crate::environment::Environment;

/// A built-in environment.
#[derive(Clone, Copy, Debug)]
pub struct EnvironmentDef {
    /// What files and the command line call it.
    pub name: &'static str,
    /// What to show the user.
    pub label: &'static str,
    /// Makes it; the same texels every time.
    pub make: fn() -> Environment,
}

/// Every built-in environment; the first is the default.
pub const ENVIRONMENTS: &[EnvironmentDef] = &[
    EnvironmentDef { name: "studio", label: "Studio", make: studio::make },
    EnvironmentDef { name: "sun", label: "Clear sky and sun", make: sun::make },
    EnvironmentDef { name: "overcast", label: "Overcast sky", make: overcast::make },
    EnvironmentDef { name: "white-furnace", label: "White furnace", make: uniform::white_furnace },
    EnvironmentDef { name: "black", label: "Black", make: uniform::black },
];

/// Makes the built-in environment called `name`, in any case; `None` if there is none.
pub fn make_environment(name: &str) -> Option<Environment> {
    ENVIRONMENTS.iter().find(|def| def.name.eq_ignore_ascii_case(name)).map(|def| (def.make)())
}

/// The unit direction at `azimuth_deg` from +Z towards +X and `elevation_deg` above the horizon.
fn toward(azimuth_deg: f32, elevation_deg: f32) -> Vec3 {
    let (sin_azimuth, cos_azimuth) = azimuth_deg.to_radians().sin_cos();
    let (sin_elevation, cos_elevation) = elevation_deg.to_radians().sin_cos();
    Vec3::new(cos_elevation * sin_azimuth, sin_elevation, cos_elevation * cos_azimuth)
}

/// 0 below `from`, 1 above `to`, smooth between.
fn smoothstep(from: f32, to: f32, x: f32) -> f32 {
    let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}
