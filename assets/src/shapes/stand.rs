//! What balls stand on.

use glam::{Mat3, Vec2, Vec3};

use super::GAP;
use super::lathe::Profile;
use crate::mesh::Mesh;

/// Height of the centre of a ball of radius 1 on the stand.
pub(super) const BALL_CENTER: Vec3 = Vec3::new(0.0, 1.27, 0.0);

/// A flat round foot with a dish for a ball of radius 1 about [`BALL_CENTER`], [`GAP`] away from it.
///
/// It begins 0.005 above the floor, so that the two surfaces do not coincide.
pub(super) fn make() -> Mesh {
    const BOTTOM: f32 = 0.005;
    const FOOT_RADIUS: f32 = 0.78;
    const EDGE: f32 = 0.03;
    let dish = 1.0 + GAP;
    let center = Vec2::new(0.0, BALL_CENTER.y);

    let mut profile = Profile::default();
    // The dish, seen from above a hollow: up to 26 degrees from the lowest point.
    let dish_deg = 180.0 - 26.0;
    profile.arc(center, dish, 180.0, dish_deg, 24);
    // Its rim, a bulge of radius `EDGE` that touches the dish from inside the body.
    let toward_rim = Vec2::new(dish_deg.to_radians().sin(), dish_deg.to_radians().cos());
    let rim = center + toward_rim * (dish + EDGE);
    profile.arc(rim, EDGE, dish_deg - 180.0, 100.0, 18);
    // A hollow shoulder that sweeps out to the rounded foot.
    let foot = Vec2::new(FOOT_RADIUS - EDGE, BOTTOM + EDGE);
    let from = rim + EDGE * Vec2::new(100_f32.to_radians().sin(), 100_f32.to_radians().cos());
    let to = foot + EDGE * Vec2::new(8_f32.to_radians().sin(), 8_f32.to_radians().cos());
    sweep(&mut profile, from, to);
    profile.arc(foot, EDGE, 8.0, 180.0, 20);
    profile.line(Vec2::new(0.0, BOTTOM), 4);
    profile.point(Vec2::new(0.0, BOTTOM), Vec2::NEG_Y);
    profile.turn("Stand", 160, Mat3::IDENTITY, Vec3::ZERO)
}

/// A quadratic curve that leaves `from` along an arc's end at 100 degrees and reaches `to` along one's start at 8.
fn sweep(profile: &mut Profile, from: Vec2, to: Vec2) {
    // Both tangents are those of the neighbouring arcs: their normals turned by a right angle.
    let leave = Vec2::new(100_f32.to_radians().cos(), -100_f32.to_radians().sin());
    let arrive = Vec2::new(8_f32.to_radians().cos(), -8_f32.to_radians().sin());
    // The control point lies where the tangents meet.
    let s = (to - from).perp_dot(arrive) / leave.perp_dot(arrive);
    let control = from + leave * s;
    for step in 1..20 {
        let t = step as f32 / 20.0;
        let along = (control - from).lerp(to - control, t);
        let place = from.lerp(control, t).lerp(control.lerp(to, t), t);
        profile.point(place, Vec2::new(-along.y, along.x));
    }
}
