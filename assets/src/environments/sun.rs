//! A clear sky with the sun in it: one small, very bright light, and the shadows and highlights that come of it.

use glam::Vec3;

use super::{smoothstep, toward};
use crate::environment::Environment;

const WIDTH: usize = 1024;
const HEIGHT: usize = 512;

/// Left in front, in the afternoon.
const SUN_AZIMUTH_DEG: f32 = -42.0;
const SUN_ELEVATION_DEG: f32 = 40.0;

/// Angular radius of the disc: three times the true one, which would be smaller than a texel.
const SUN_RADIUS_DEG: f32 = 0.75;

/// Irradiance of the sun alone on a surface that faces it. About five times that of the sky on level ground.
const SUN_IRRADIANCE: Vec3 = Vec3::new(6.6, 6.1, 5.3);

/// Sky, ground and a disc.
///
/// The sky goes from `HORIZON` to `ZENITH` with `(1 - sin(elevation))^3.5`, times `1 + 0.25 cos²` for the angle to the
/// sun (the shape of Rayleigh scattering), plus a halo that falls by half every four degrees. The texels that the disc
/// covers share its irradiance in proportion to the covered part, so that no energy is lost to the grid.
pub(super) fn make() -> Environment {
    const ZENITH: Vec3 = Vec3::new(0.13, 0.23, 0.46);
    const HORIZON: Vec3 = Vec3::new(0.62, 0.72, 0.84);
    const HALO: Vec3 = Vec3::new(1.5, 1.35, 1.1);
    const GROUND: Vec3 = Vec3::new(0.33, 0.30, 0.26);

    let sun = toward(SUN_AZIMUTH_DEG, SUN_ELEVATION_DEG);
    let mut environment = Environment::from_fn("Clear sky and sun", WIDTH, HEIGHT, |d| {
        let cos_sun = d.dot(sun).clamp(-1.0, 1.0);
        let haze = (1.0 - d.y.max(0.0)).powf(3.5);
        let halo = HALO * (-cos_sun.acos().to_degrees() * std::f32::consts::LN_2 / 4.0).exp();
        let sky = ZENITH.lerp(HORIZON, haze) * (1.0 + 0.25 * cos_sun * cos_sun) + halo;
        GROUND.lerp(sky, smoothstep(-0.012, 0.006, d.y))
    });
    add_disc(&mut environment, sun);
    environment
}

/// Adds the sun's disc, sampled `GRID` times `GRID` in every texel that may touch it.
fn add_disc(environment: &mut Environment, sun: Vec3) {
    const GRID: usize = 16;
    let cos_radius = f64::from(SUN_RADIUS_DEG).to_radians().cos();
    let mut covered = Vec::new();
    let mut solid_angle = 0.0;
    let reach = (SUN_RADIUS_DEG / 180.0 * HEIGHT as f32).ceil() as usize + 2;
    let row = ((90.0 - SUN_ELEVATION_DEG) / 180.0 * HEIGHT as f32) as usize;
    for j in row - reach..=row + reach {
        let rows: Vec<f64> = (0..GRID).map(|k| (j as f64 + (k as f64 + 0.5) / GRID as f64) / HEIGHT as f64).collect();
        for i in 0..WIDTH {
            if Environment::direction((i as f32 + 0.5) / WIDTH as f32, rows[GRID / 2] as f32).dot(sun) < 0.998 {
                continue;
            }
            let mut texel = 0.0;
            for &v in &rows {
                let theta = v * std::f64::consts::PI;
                for k in 0..GRID {
                    let phi = (i as f64 + (k as f64 + 0.5) / GRID as f64) / WIDTH as f64 * std::f64::consts::TAU;
                    let d = glam::DVec3::new(theta.sin() * phi.sin(), theta.cos(), -theta.sin() * phi.cos());
                    texel += f64::from(u8::from(d.dot(sun.as_dvec3()) > cos_radius));
                }
            }
            if texel > 0.0 {
                let part = texel / (GRID * GRID) as f64;
                covered.push((j * WIDTH + i, part));
                // What counts is the integral over the map as a renderer takes it: at the texel's centre.
                let theta = (j as f64 + 0.5) / HEIGHT as f64 * std::f64::consts::PI;
                solid_angle += part * texel_solid_angle(theta);
            }
        }
    }
    let radiance = SUN_IRRADIANCE / solid_angle as f32;
    for (texel, part) in covered {
        let with_sun = Vec3::from_array(environment.texels[texel]) + radiance * part as f32;
        environment.texels[texel] = with_sun.to_array();
    }
}

/// Solid angle of a texel in the row at `theta`, in sr.
fn texel_solid_angle(theta: f64) -> f64 {
    use std::f64::consts::{PI, TAU};
    theta.sin() * (PI / HEIGHT as f64) * (TAU / WIDTH as f64)
}
