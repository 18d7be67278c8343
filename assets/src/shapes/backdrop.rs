//! What objects stand on and before, whatever mesh they are.

use glam::{Vec2, Vec3};
use std::f32::consts::FRAC_PI_2;

use super::{SurfacePoint, floor};
use crate::mesh::{Bounds, Mesh, Part, Role};

/// A backdrop.
#[derive(Clone, Copy, Debug)]
pub struct BackdropDef {
    /// What files and the command line call it.
    pub name: &'static str,
    /// What to show the user.
    pub label: &'static str,
    /// One sentence for the user.
    pub doc: &'static str,
    /// Makes its parts for an object with half an extent of 1 that stands on the origin.
    make: fn() -> Vec<Part>,
}

/// Every backdrop.
pub const BACKDROPS: &[BackdropDef] = &[
    BackdropDef { name: "none", label: "Nothing", doc: "The environment alone, below the object too.", make: Vec::new },
    BackdropDef { name: "tiles", label: "Tiled floor", doc: "The floor of the built-in meshes.", make: || floor::make().into() },
    BackdropDef {
        name: "grey-sweep",
        label: "Product, grey sweep",
        doc: "A seamless grey floor that rises to a wall behind the object, as in a photographer's studio.",
        make: || sweep().into(),
    },
];

impl PartialEq for BackdropDef {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

impl BackdropDef {
    /// The backdrop called `name`, in any case.
    pub fn named(name: &str) -> Option<&'static Self> {
        BACKDROPS.iter().find(|def| def.name.eq_ignore_ascii_case(name))
    }

    /// What stands in for the floor of a model, in its units: below its lowest point, or where its own floor lies. `model`: what is there,
    /// with its bounds. Nothing for a model without extent.
    pub fn parts(&self, model: impl Iterator<Item = (Role, Bounds)> + Clone) -> Vec<Part> {
        let union = |of: fn(Role) -> bool| {
            model.clone().filter(|(role, _)| of(*role)).fold(Bounds::EMPTY, |all, (_, bounds)| all.union(bounds))
        };
        let (object, standing, floor) =
            (union(|role| role == Role::Object), union(|role| !role.is_floor()), union(Role::is_floor));
        let scale = (0.5 * object.size()).max_element();
        if !(scale > 0.0 && scale.is_finite()) {
            return Vec::new();
        }
        // Surfaces that touch would hide one another by turns.
        let y = if floor.min.y.is_finite() { floor.min.y } else { standing.min.y - super::GAP * scale };
        let center = Vec3::new(object.center().x, y, object.center().z);
        let mut parts = (self.make)();
        for p in parts.iter_mut().flat_map(|part| &mut part.mesh.positions) {
            *p = *p * scale + center;
        }
        parts
    }
}

impl Role {
    /// Whether it lies below everything, and another backdrop takes its place.
    pub fn is_floor(self) -> bool {
        matches!(self, Self::FloorLight | Self::FloorDark | Self::Sweep)
    }
}

/// Where the wall stands, behind the object: further away than the camera is at first, so that it can go all around.
const WALL: f32 = 7.0;
/// Radius of the bend between floor and wall.
const BEND: f32 = 3.5;
/// Upper edge of the wall: above the picture, and low enough for light from behind.
const HEIGHT: f32 = 6.5;
/// How far the floor goes on below the bend, so that nothing shows between them.
const OVERLAP: f32 = 0.3;
/// Half the width, and how far the floor reaches to the front.
const REACH: f32 = 16.0;

/// A flat floor, and what rises behind it: two meshes, since a floor can be drawn in more detail. Open, facing up and to the front.
fn sweep() -> [Part; 2] {
    /// Cells across, along the bend and up the wall: light is kept by vertex there.
    const COLUMNS: u32 = 32;
    const BENT: u32 = 16;
    const UPRIGHT: u32 = 6;
    let across = |column: u32, columns: u32| REACH * (2.0 * column as f32 / columns as f32 - 1.0);
    let mut flat = Mesh { name: "Sweep, floor".to_owned(), ..Mesh::default() };
    let back = BEND - WALL;
    flat.push_grid(1, 1, |column, row| SurfacePoint {
        position: Vec3::new(across(column, 1), 0.0, if row == 0 { back - OVERLAP } else { REACH }),
        normal: Vec3::Y,
        tangent: Vec3::X,
        uv: Vec2::new(column as f32, row as f32),
    });
    let mut risen = Mesh { name: "Sweep, wall".to_owned(), ..Mesh::default() };
    risen.push_grid(COLUMNS, BENT + UPRIGHT, |column, row| {
        // Rows go down, from the upper edge of the wall to the floor.
        let (y, z, angle) = if row < UPRIGHT {
            (HEIGHT + (BEND - HEIGHT) * row as f32 / UPRIGHT as f32, -WALL, FRAC_PI_2)
        } else {
            let angle = FRAC_PI_2 * (1.0 - (row - UPRIGHT) as f32 / BENT as f32);
            (BEND * (1.0 - angle.cos()), back - BEND * angle.sin(), angle)
        };
        // Exactly on the edge of the floor.
        let y = if row == BENT + UPRIGHT { 0.0 } else { y };
        SurfacePoint {
            position: Vec3::new(across(column, COLUMNS), y, z),
            normal: Vec3::new(0.0, angle.cos(), angle.sin()),
            tangent: Vec3::X,
            uv: Vec2::new(column as f32 / COLUMNS as f32, row as f32 / (BENT + UPRIGHT) as f32),
        }
    });
    [flat, risen].map(|mesh| Part { role: Role::Sweep, mesh })
}
