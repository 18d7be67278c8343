//! The built-in models: one file each, and a row in the table.
//!
//! All are made by formulas or a fixed computation, so they are the same every time and carry no foreign licence.
//! Objects are about 2 units wide. Closed bodies are watertight by position and never touch one another: a gap of
//! [`GAP`] or more keeps rays that start on one from starting inside the next.

mod backdrop;
mod cloth;
mod floor;
mod lathe;
mod plane;
mod rounded_cube;
mod shader_ball;
mod sphere;
mod stand;
mod torus;

use glam::{Vec2, Vec3};

pub use backdrop::{BACKDROPS, BackdropDef};

use crate::mesh::{Mesh, Model, Part, Role};

/// Smallest distance between two bodies.
const GAP: f32 = 0.02;

/// A built-in model.
#[derive(Clone, Copy, Debug)]
pub struct ShapeDef {
    /// What files and the command line call it.
    pub name: &'static str,
    /// What to show the user.
    pub label: &'static str,
    /// Makes it; the same vertices every time.
    pub make: fn() -> Model,
}

/// Every built-in model; the first is the default.
pub const SHAPES: &[ShapeDef] = &[
    ShapeDef { name: "shader-ball", label: "Shader ball", make: shader_ball::make },
    ShapeDef { name: "sphere", label: "Sphere", make: sphere::make },
    ShapeDef { name: "rounded-cube", label: "Rounded cube", make: rounded_cube::make },
    ShapeDef { name: "torus", label: "Torus", make: torus::make },
    ShapeDef { name: "plane", label: "Plane", make: plane::make },
    ShapeDef { name: "cloth", label: "Cloth", make: cloth::make },
];

/// Makes the built-in model called `name`, in any case; `None` if there is none.
pub fn make_shape(name: &str) -> Option<Model> {
    SHAPES.iter().find(|def| def.name.eq_ignore_ascii_case(name)).map(|def| (def.make)())
}

/// A model of `object`, what it stands on if anything, and the floor.
fn on_floor(name: &str, object: Mesh, stand: Option<Mesh>) -> Model {
    let mut parts = vec![Part { role: Role::Object, mesh: object }];
    parts.extend(stand.map(|mesh| Part { role: Role::Stand, mesh }));
    parts.extend(floor::make());
    Model { name: name.to_owned(), parts, unit_mm: None }
}

/// A point of a surface.
struct SurfacePoint {
    position: Vec3,
    normal: Vec3,
    /// Along dP/du, of any length.
    tangent: Vec3,
    uv: Vec2,
}

impl Mesh {
    /// Adds a vertex and returns its number. The mapping must not be mirrored: normal, dP/du and smaller v are
    /// right-handed.
    fn push(&mut self, point: SurfacePoint) -> u32 {
        let n = point.normal.normalize();
        let t = (point.tangent - n * n.dot(point.tangent)).normalize();
        self.positions.push(point.position);
        self.normals.push(n);
        self.tangents.push(t.extend(1.0));
        self.uvs.push(point.uv);
        self.positions.len() as u32 - 1
    }

    /// Adds a grid of `columns` times `rows` cells; `point(column, row)` is called for every crossing.
    ///
    /// Columns go to the right and rows down, seen from outside.
    fn push_grid(&mut self, columns: u32, rows: u32, mut point: impl FnMut(u32, u32) -> SurfacePoint) {
        let first = self.positions.len() as u32;
        for row in 0..=rows {
            for column in 0..=columns {
                self.push(point(column, row));
            }
        }
        for row in 0..rows {
            for column in 0..columns {
                let upper_left = first + row * (columns + 1) + column;
                let lower_left = upper_left + columns + 1;
                self.triangles.push([upper_left, lower_left, lower_left + 1]);
                self.triangles.push([upper_left, lower_left + 1, upper_left + 1]);
            }
        }
    }
}
