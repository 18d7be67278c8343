//! A plain ball.

use glam::{Mat3, Vec2};

use super::lathe::Profile;
use super::{on_floor, stand};
use crate::mesh::Model;

/// A ball of radius 1 on the stand.
pub(super) fn make() -> Model {
    let mut profile = Profile::default();
    profile.arc(Vec2::ZERO, 1.0, 0.0, 180.0, 160);
    on_floor("Sphere", profile.turn("Sphere", 256, Mat3::IDENTITY, stand::BALL_CENTER), Some(stand::make()))
}
