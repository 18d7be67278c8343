//! A ring.

use std::f32::consts::TAU;

use glam::{Mat3, Vec2, Vec3};

use super::{SurfacePoint, on_floor};
use crate::mesh::{Mesh, Model};

/// A ring 2 units wide and 0.6 thick that stands upright on the floor, turned a little away from the front.
///
/// u goes around the axis, v around the tube; both seams lie where the camera of azimuth 0 does not see them.
pub(super) fn make() -> Model {
    const RADIUS: f32 = 0.7;
    const TUBE: f32 = 0.3;
    const COLUMNS: u32 = 256;
    const ROWS: u32 = 128;
    // The axis of the ring, +Y before this, comes to lie level.
    let world_from_local = Mat3::from_rotation_y(0.55) * Mat3::from_rotation_x(std::f32::consts::FRAC_PI_2);
    let center = Vec3::new(0.0, RADIUS + TUBE + 0.005, 0.0);
    let mut mesh = Mesh { name: "Torus".to_owned(), ..Mesh::default() };
    mesh.push_grid(COLUMNS, ROWS, |column, row| {
        // The last column and row repeat the first ones' places exactly.
        let (sin_u, cos_u) = ((column % COLUMNS) as f32 / COLUMNS as f32 * TAU).sin_cos();
        let (sin_v, cos_v) = ((row % ROWS) as f32 / ROWS as f32 * TAU).sin_cos();
        let out = Vec3::new(-sin_u, 0.0, -cos_u);
        // Rows start inside the ring, and go over the top outwards and down.
        let normal = out * -cos_v + Vec3::Y * sin_v;
        SurfacePoint {
            position: center + world_from_local * (out * RADIUS + normal * TUBE),
            normal: world_from_local * normal,
            tangent: world_from_local * Vec3::new(-cos_u, 0.0, sin_u),
            uv: Vec2::new(column as f32 / COLUMNS as f32, row as f32 / ROWS as f32),
        }
    });
    on_floor("Torus", mesh, None)
}
