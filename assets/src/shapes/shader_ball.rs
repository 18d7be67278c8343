//! The default model: a ball that shows a material thick and thin, round, hollow and sharp at once.

use glam::{Mat3, Vec2};

use super::lathe::Profile;
use super::{on_floor, stand};
use crate::mesh::Model;

/// Where the inset faces: to the right of the camera of azimuth 0, and up.
const INSET_AZIMUTH_DEG: f32 = 36.0;
const INSET_ELEVATION_DEG: f32 = 44.0;

/// A ball of radius 1 on the stand, with an inset and an engraved ring about one tilted axis.
///
/// From the axis outwards the inset has a dome in a bowl, a free-standing wall 0.07 thick, and a narrow channel; all
/// edges are rounded. Through the middle the body is 2 thick. The ring runs around it 92 degrees away from the inset.
pub(super) fn make() -> Model {
    let azimuth = INSET_AZIMUTH_DEG.to_radians();
    // +Y, the axis, leans forward to its elevation and then turns to its azimuth; the seam ends up behind.
    let tilt = Mat3::from_rotation_y(azimuth) * Mat3::from_rotation_x((90.0 - INSET_ELEVATION_DEG).to_radians());
    on_floor("Shader ball", profile().turn("Shader ball", 256, tilt, stand::BALL_CENTER), Some(stand::make()))
}

fn profile() -> Profile {
    // The inset, by distance from the axis: dome, bowl up to `BOWL`, wall up to `WALL`, channel up to `CHANNEL`.
    const BOWL: f32 = 0.43;
    const WALL: f32 = 0.50;
    const CHANNEL: f32 = 0.60;
    const WALL_TOP: f32 = 0.86;
    const CHANNEL_FLOOR: f32 = 0.58;
    const BOWL_FLOOR: f32 = 0.46;
    const DOME: f32 = 0.27;
    const DOME_CENTER: Vec2 = Vec2::new(0.0, 0.54);

    let mut profile = Profile::default();
    // The dome, and the fillet at its foot: a circle that touches the dome from outside and the floor from above.
    let foot = 0.05;
    let foot_y = BOWL_FLOOR + foot;
    let foot_center = Vec2::new(((DOME + foot).powi(2) - (foot_y - DOME_CENTER.y).powi(2)).sqrt(), foot_y);
    let toward_foot = angle_deg(foot_center - DOME_CENTER);
    profile.arc(DOME_CENTER, DOME, 0.0, toward_foot, 40);
    profile.arc(foot_center, foot, toward_foot + 180.0, 180.0, 8);
    // The bowl's floor runs into its wall.
    let bowl = 0.06;
    let bowl_center = Vec2::new(BOWL - bowl, BOWL_FLOOR + bowl);
    profile.arc(bowl_center, bowl, 180.0, 90.0, 10);
    // The wall with a round top.
    let top = (WALL - BOWL) / 2.0;
    profile.line(Vec2::new(BOWL, WALL_TOP - top), 6);
    profile.arc(Vec2::new(BOWL + top, WALL_TOP - top), top, -90.0, 90.0, 18);
    // The channel with a round floor.
    let channel = (CHANNEL - WALL) / 2.0;
    profile.line(Vec2::new(WALL, CHANNEL_FLOOR + channel), 6);
    profile.arc(Vec2::new(WALL + channel, CHANNEL_FLOOR + channel), channel, 270.0, 90.0, 18);
    // The edge between channel and ball: a circle that touches both from inside the body.
    let edge = 0.03;
    let edge_x = CHANNEL + edge;
    let edge_center = Vec2::new(edge_x, ((1.0 - edge).powi(2) - edge_x * edge_x).sqrt());
    profile.line(Vec2::new(CHANNEL, edge_center.y), 5);
    let begin = angle_deg(edge_center);
    profile.arc(edge_center, edge, -90.0, begin, 12);
    ball(&mut profile, begin);
    profile
}

/// The rest of the ball from `begin` degrees to the far end of the axis, with the engraved ring.
fn ball(profile: &mut Profile, begin: f32) {
    const RING_DEG: f32 = 92.0;
    const RING_DEPTH: f32 = 0.06;
    /// Half the width of the ring's floor, and the width of its flanks.
    const FLOOR_DEG: f32 = 2.2;
    const FLANK_DEG: f32 = 2.6;

    let radius = |deg: f32| {
        let t = (((deg - RING_DEG).abs() - FLOOR_DEG) / FLANK_DEG).clamp(0.0, 1.0);
        // Its slope and its bend are continuous, so the edges are round.
        1.0 - RING_DEPTH * (1.0 - t * t * t * (t * (6.0 * t - 15.0) + 10.0))
    };
    let mut angles = Vec::new();
    let mut stretch = |from: f32, to: f32, steps: u32| {
        angles.extend((0..steps).map(|k| from + (to - from) * k as f32 / steps as f32));
    };
    let (outer, inner) = (FLOOR_DEG + FLANK_DEG, FLOOR_DEG);
    stretch(begin, RING_DEG - outer, 36);
    stretch(RING_DEG - outer, RING_DEG - inner, 14);
    stretch(RING_DEG - inner, RING_DEG + inner, 4);
    stretch(RING_DEG + inner, RING_DEG + outer, 14);
    stretch(RING_DEG + outer, 180.0, 60);
    for deg in angles {
        let (sin, cos) = deg.to_radians().sin_cos();
        let slope = (radius(deg + 0.01) - radius(deg - 0.01)) / 0.02_f32.to_radians();
        let (out, along) = (Vec2::new(sin, cos), Vec2::new(cos, -sin));
        profile.point(out * radius(deg), out * radius(deg) - along * slope);
    }
    profile.point(Vec2::NEG_Y, Vec2::NEG_Y);
}

/// Angle of `v` from the upper end of the axis outwards, in degrees.
fn angle_deg(v: Vec2) -> f32 {
    v.x.atan2(v.y).to_degrees()
}
