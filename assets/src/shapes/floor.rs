//! The floor that everything stands on.

use glam::{Vec2, Vec3};

use super::SurfacePoint;
use crate::mesh::{Mesh, Part, Role};

/// Edge length of a tile.
const TILE: f32 = 0.75;

/// Tiles from the middle to the edge. The edge lies 36 units away: at eye height 2.5, four degrees below the horizon.
const REACH: i32 = 48;

/// Two meshes of square tiles at y = 0, of alternate colour, facing up; open, since nothing can be below them.
///
/// The uvs repeat on every tile, u towards +X and v towards +Z.
pub(super) fn make() -> [Part; 2] {
    [(Role::FloorLight, 0, "Light tiles"), (Role::FloorDark, 1, "Dark tiles")].map(|(role, parity, name)| {
        let mut mesh = Mesh { name: name.to_owned(), ..Mesh::default() };
        for row in -REACH..REACH {
            for column in (-REACH..REACH).filter(|column| (row + column) & 1 == parity) {
                mesh.push_grid(1, 1, |i, j| SurfacePoint {
                    position: Vec3::new((column + i as i32) as f32, 0.0, (row + j as i32) as f32) * TILE,
                    normal: Vec3::Y,
                    tangent: Vec3::X,
                    uv: Vec2::new(i as f32, j as f32),
                });
            }
        }
        Part { role, mesh }
    })
}
