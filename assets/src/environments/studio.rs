//! Soft boxes in a dark room: the light that products are photographed in.

use glam::Vec3;

use super::{smoothstep, toward};
use crate::environment::Environment;

/// A rectangular light that faces the middle of the room.
struct Softbox {
    azimuth_deg: f32,
    elevation_deg: f32,
    /// Half the angles it spans across and along, before the roll.
    half_width_deg: f32,
    half_height_deg: f32,
    /// Turn about its own middle, counter-clockwise as seen from the room.
    roll_deg: f32,
    radiance: Vec3,
    /// How much darker the rim is than the middle, 0 to 1: cloth is brightest before its lamp.
    falloff: f32,
}

const BOXES: &[Softbox] = &[
    // Key: large, warm, left in front and above.
    Softbox {
        azimuth_deg: -50.0,
        elevation_deg: 44.0,
        half_width_deg: 17.0,
        half_height_deg: 20.0,
        roll_deg: -8.0,
        radiance: Vec3::new(14.6, 14.0, 13.0),
        falloff: 0.45,
    },
    // Fill: a tall cool strip at the right.
    Softbox {
        azimuth_deg: 68.0,
        elevation_deg: 16.0,
        half_width_deg: 8.0,
        half_height_deg: 28.0,
        roll_deg: 4.0,
        radiance: Vec3::new(5.0, 5.4, 6.0),
        falloff: 0.3,
    },
    // Rim lights behind the object: they draw its outline.
    Softbox {
        azimuth_deg: 148.0,
        elevation_deg: 30.0,
        half_width_deg: 6.0,
        half_height_deg: 26.0,
        roll_deg: 0.0,
        radiance: Vec3::new(19.0, 20.0, 22.0),
        falloff: 0.3,
    },
    Softbox {
        azimuth_deg: -142.0,
        elevation_deg: 22.0,
        half_width_deg: 5.0,
        half_height_deg: 22.0,
        roll_deg: 0.0,
        radiance: Vec3::new(14.0, 12.8, 10.8),
        falloff: 0.3,
    },
    // Top: a long strip across.
    Softbox {
        azimuth_deg: 0.0,
        elevation_deg: 82.0,
        half_width_deg: 20.0,
        half_height_deg: 8.0,
        roll_deg: 0.0,
        radiance: Vec3::new(12.8, 13.0, 13.3),
        falloff: 0.35,
    },
    // A small hard lamp: rough and polished surfaces differ most in its reflection.
    Softbox {
        azimuth_deg: 24.0,
        elevation_deg: 46.0,
        half_width_deg: 2.4,
        half_height_deg: 2.4,
        roll_deg: 0.0,
        radiance: Vec3::new(60.0, 58.0, 54.0),
        falloff: 0.2,
    },
];

/// Six lights on a gradient that is darkest below and behind.
///
/// A grey ball of reflectance 0.5 has a mean radiance of about 0.6 in it.
pub(super) fn make() -> Environment {
    let frames: Vec<_> = BOXES.iter().map(|light| (light, Frame::of(light))).collect();
    Environment::from_fn("Studio", 1024, 512, |d| {
        frames.iter().fold(room(d), |radiance, (light, frame)| radiance + light.radiance * frame.strength(light, d))
    })
}

/// The walls: a bright horizon band in front of a dark ceiling and floor, and darker behind the object.
fn room(d: Vec3) -> Vec3 {
    const ZENITH: Vec3 = Vec3::new(0.12, 0.13, 0.15);
    const HORIZON: Vec3 = Vec3::new(0.34, 0.35, 0.38);
    const NADIR: Vec3 = Vec3::new(0.055, 0.052, 0.05);
    let base = if d.y >= 0.0 { HORIZON.lerp(ZENITH, d.y.powf(0.6)) } else { HORIZON.lerp(NADIR, (-d.y).powf(0.4)) };
    base * (0.8 + 0.2 * d.z)
}

/// A light's own axes, and its half width and height on a plane at distance 1.
struct Frame {
    forward: Vec3,
    right: Vec3,
    up: Vec3,
    half_width: f32,
    half_height: f32,
}

impl Frame {
    fn of(light: &Softbox) -> Self {
        let forward = toward(light.azimuth_deg, light.elevation_deg);
        // Horizontal, and defined straight above as well.
        let right = toward(light.azimuth_deg + 90.0, 0.0);
        let up = forward.cross(right);
        let (sin_roll, cos_roll) = light.roll_deg.to_radians().sin_cos();
        Self {
            forward,
            right: right * cos_roll + up * sin_roll,
            up: up * cos_roll - right * sin_roll,
            half_width: light.half_width_deg.to_radians().tan(),
            half_height: light.half_height_deg.to_radians().tan(),
        }
    }

    /// The part of the light's radiance in direction `d`: 0 outside, soft at the edge.
    fn strength(&self, light: &Softbox, d: Vec3) -> f32 {
        let z = d.dot(self.forward);
        if z < 0.05 {
            return 0.0;
        }
        let x = (d.dot(self.right) / (z * self.half_width)).abs();
        let y = (d.dot(self.up) / (z * self.half_height)).abs();
        if x > 1.1 || y > 1.1 {
            return 0.0;
        }
        let edge = |t: f32| 1.0 - smoothstep(0.9, 1.1, t);
        // Brightest in the middle, as cloth before a lamp.
        let middle = 1.0 - light.falloff * (0.5 * (x * x + y * y)).min(1.0);
        edge(x) * edge(y) * middle
    }
}
