//! A block with rounded edges: flat faces beside tight curves.

use glam::{Mat3, Vec2, Vec3};

use super::{SurfacePoint, on_floor};
use crate::mesh::{Mesh, Model};

/// Half the edge length.
const HALF: f32 = 0.75;

/// Radius of the rounding.
const BEVEL: f32 = 0.1;

/// Cells across the rounding of one edge, up to its middle, and across the flat part, where their number is even.
const BEVEL_CELLS: u32 = 10;
const FLAT_CELLS: u32 = 24;

/// A cube of edge length 1.5 with edges rounded to a radius of 0.1, turned by 35 degrees, just above the floor.
///
/// Each of the six faces has the whole uv square, upright on the sides.
pub(super) fn make() -> Model {
    let world_from_local = Mat3::from_rotation_y(-35_f32.to_radians());
    let center = Vec3::new(0.0, HALF + 0.005, 0.0);
    // Normal and direction of u; v goes along u x n, which is down.
    let faces = [
        (Vec3::Z, Vec3::X),
        (Vec3::X, Vec3::NEG_Z),
        (Vec3::NEG_Z, Vec3::NEG_X),
        (Vec3::NEG_X, Vec3::Z),
        (Vec3::Y, Vec3::X),
        (Vec3::NEG_Y, Vec3::X),
    ];
    let stops = stops();
    let cells = stops.len() as u32 - 1;
    let mut mesh = Mesh { name: "Rounded cube".to_owned(), ..Mesh::default() };
    for (n, right) in faces {
        let down = right.cross(n);
        mesh.push_grid(cells, cells, |column, row| {
            let (x, y) = (stops[column as usize], stops[row as usize]);
            // `on_cube` is a point of the sharp cube. The nearest point of the inner cube is the centre of the
            // rounding; both are symmetric between faces, so that the borders meet bit by bit.
            let on_cube = n * HALF + right * x + down * y;
            let core = on_cube.clamp(Vec3::splat(BEVEL - HALF), Vec3::splat(HALF - BEVEL));
            let normal = (on_cube - core).normalize();
            let reach = |t: f32| t.abs().max(HALF - BEVEL) - (HALF - BEVEL);
            // dP/du turns from the face's own direction as the surface bends.
            let tangent = right - normal * normal.dot(right);
            SurfacePoint {
                position: center + world_from_local * (core + normal * BEVEL),
                normal: world_from_local * normal,
                tangent: world_from_local * tangent,
                uv: Vec2::new(unrolled(x, reach(x)), unrolled(y, reach(y))),
            }
        });
    }
    on_floor("Rounded cube", mesh, None)
}

/// Places across a face of the sharp cube, from -HALF to HALF, whose normals turn in equal steps in the rounding.
fn stops() -> Vec<f32> {
    let flat = HALF - BEVEL;
    let bevel = |k: u32| {
        let angle = k as f32 / BEVEL_CELLS as f32 * std::f32::consts::FRAC_PI_4;
        // The middle of the edge must be hit exactly, for the next face begins there.
        if k == BEVEL_CELLS { HALF } else { flat + BEVEL * angle.tan() }
    };
    // One half mirrors the other bit by bit, for neighbouring faces run their common edge in opposite directions.
    let mut half: Vec<f32> = (1..=FLAT_CELLS / 2).map(|k| flat * (2 * k) as f32 / FLAT_CELLS as f32).collect();
    half.extend((1..=BEVEL_CELLS).map(bevel));
    let mut stops: Vec<f32> = half.iter().rev().map(|x| -x).collect();
    stops.push(0.0);
    stops.extend(half);
    stops
}

/// The texture coordinate of place `x` on a face, in proportion to the length along the rounded surface.
fn unrolled(x: f32, reach: f32) -> f32 {
    let flat = HALF - BEVEL;
    let arc = BEVEL * (reach / BEVEL).atan();
    let whole = flat + BEVEL * std::f32::consts::FRAC_PI_4;
    0.5 + 0.5 * (x.clamp(-flat, flat) + arc * x.signum()) / whole
}
