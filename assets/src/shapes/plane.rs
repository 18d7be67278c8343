//! A flat sheet, to look at textures.

use glam::{Mat3, Vec2, Vec3};

use super::SurfacePoint;
use crate::mesh::{Mesh, Model, Part, Role};

/// An open square, 2 units wide, that faces +Z and leans back by 15 degrees; alone, without a floor.
///
/// Its lower edge lies at y = 0. The uvs run once over it, upright as the image is.
pub(super) fn make() -> Model {
    const CELLS: u32 = 64;
    let lean = Mat3::from_rotation_x(-15_f32.to_radians());
    let mut mesh = Mesh { name: "Plane".to_owned(), ..Mesh::default() };
    mesh.push_grid(CELLS, CELLS, |column, row| {
        let uv = Vec2::new(column as f32, row as f32) / CELLS as f32;
        SurfacePoint {
            position: lean * Vec3::new(2.0 * uv.x - 1.0, 2.0 - 2.0 * uv.y, 0.0),
            normal: lean * Vec3::Z,
            tangent: Vec3::X,
            uv,
        }
    });
    Model { name: "Plane".to_owned(), parts: vec![Part { role: Role::Object, mesh }], unit_mm: None }
}
