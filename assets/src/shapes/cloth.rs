//! A cloth over a ball: folds, thin everywhere, seen at every angle at once.
//!
//! The cloth is let fall by a small simulation on a coarse grid, with fixed steps and nothing but additions,
//! multiplications, divisions and square roots, so that it lies the same on every machine. A smooth surface through
//! that grid is then given its thickness.

use glam::{Mat3, Vec2, Vec3};

use super::lathe::Profile;
use super::{SurfacePoint, on_floor};
use crate::mesh::{Mesh, Model};

/// Vertices of the coarse grid along an edge.
const COARSE: usize = 41;

/// Edge length of the cloth.
const EDGE: f32 = 2.9;

/// Thickness of the cloth.
const THICKNESS: f32 = 0.03;

/// Cells of the fine surface along an edge.
const FINE: u32 = 168;

/// Radius and centre of the ball below.
const BALL: f32 = 0.62;
const BALL_CENTER: Vec3 = Vec3::new(0.0, 1.02, 0.0);

/// Distance of the cloth's middle surface from the ball and from the floor.
const CLEARANCE: f32 = 0.045;

/// A square cloth, 0.03 thick and closed, that hangs over a ball on a post.
pub(super) fn make() -> Model {
    on_floor("Cloth", thicken(&drape()), Some(support()))
}

/// The ball and its post, one closed body.
fn support() -> Mesh {
    const POST: f32 = 0.09;
    let mut profile = Profile::default();
    let center = Vec2::new(0.0, BALL_CENTER.y);
    let end_deg = 180.0 - (POST / BALL).asin().to_degrees();
    profile.arc(center, BALL, 0.0, end_deg, 60);
    let top = center + BALL * Vec2::new(end_deg.to_radians().sin(), end_deg.to_radians().cos());
    let bottom = Vec2::new(top.x, 0.06);
    profile.point(top, Vec2::X);
    profile.line(bottom, 4);
    profile.point(bottom, Vec2::X);
    // The foot: a flat cone with a round edge.
    let edge = 0.02;
    let foot = Vec2::new(0.42, 0.005);
    profile.point(bottom, Vec2::new(0.05, 1.0));
    profile.arc(foot + Vec2::new(-edge, edge), edge, 3.0, 180.0, 12);
    profile.point(Vec2::new(0.0, foot.y), Vec2::NEG_Y);
    profile.turn("Stand", 96, Mat3::IDENTITY, Vec3::ZERO)
}

/// The middle surface of the cloth at rest: `COARSE` rows of `COARSE` places, rows along +Z before it fell.
fn drape() -> Vec<Vec3> {
    const STEPS: usize = 105;
    const ITERATIONS: usize = 8;
    const TIME_STEP: f32 = 1.0 / 48.0;
    const GRAVITY: f32 = 6.0;
    const SPACING: f32 = EDGE / (COARSE - 1) as f32;

    // Turned by some odd angle, so that no corner points at the camera; a slight wave decides where folds begin,
    // which on a perfect grid rounding would.
    let (sin, cos) = (0.4493, 0.8934);
    let top = BALL_CENTER.y + BALL + CLEARANCE + 0.02;
    let mut places: Vec<Vec3> = (0..COARSE * COARSE)
        .map(|k| {
            let x = (k % COARSE) as f32 * SPACING - EDGE / 2.0;
            let z = (k / COARSE) as f32 * SPACING - EDGE / 2.0;
            let wave = 0.02 * ((7 * (k % COARSE) + 3 * (k / COARSE)) % 11) as f32 / 11.0;
            Vec3::new(cos * x + sin * z + 0.05, top + wave, cos * z - sin * x - 0.03)
        })
        .collect();
    let mut before = places.clone();
    let links = links(SPACING);
    for _ in 0..STEPS {
        for (place, before) in places.iter_mut().zip(&mut before) {
            let velocity = (*place - *before) * 0.985;
            *before = *place;
            *place += velocity + Vec3::new(0.0, -GRAVITY * TIME_STEP * TIME_STEP, 0.0);
        }
        for _ in 0..ITERATIONS {
            for &Link { a, b, length, stiffness } in &links {
                let apart = places[b] - places[a];
                let distance = apart.length().max(1e-6);
                let move_by = apart * (0.5 * stiffness * (distance - length) / distance);
                places[a] += move_by;
                places[b] -= move_by;
            }
        }
        for (place, before) in places.iter_mut().zip(&mut before) {
            keep_out(place, before);
        }
    }
    places
}

/// Moves a place out of the ball and the floor, and slows it there.
fn keep_out(place: &mut Vec3, before: &mut Vec3) {
    const FRICTION: f32 = 0.35;
    let from_center = *place - BALL_CENTER;
    let distance = from_center.length();
    if distance < BALL + CLEARANCE {
        *place = BALL_CENTER + from_center * ((BALL + CLEARANCE) / distance.max(1e-6));
        *before = before.lerp(*place, FRICTION);
    }
    if place.y < CLEARANCE {
        place.y = CLEARANCE;
        *before = before.lerp(*place, FRICTION);
    }
}

/// Two places that want to be `length` apart; `stiffness` 1 insists.
struct Link {
    a: usize,
    b: usize,
    length: f32,
    stiffness: f32,
}

/// Threads along both directions insist; diagonals yield, and so does what keeps the cloth from creasing sharply.
fn links(spacing: f32) -> Vec<Link> {
    let mut links = Vec::new();
    let diagonal = 2_f32.sqrt();
    let kinds =
        [(1, 0, 1.0, 1.0), (0, 1, 1.0, 1.0), (1, 1, diagonal, 0.25), (1, -1, diagonal, 0.25), (2, 0, 2.0, 0.2), (0, 2, 2.0, 0.2)];
    for (across, down, lengths, stiffness) in kinds {
        for row in 0..COARSE as isize {
            for column in 0..COARSE as isize {
                let (to_row, to_column) = (row + down, column + across);
                let inside = 0..COARSE as isize;
                if inside.contains(&to_row) && inside.contains(&to_column) {
                    let number = |row: isize, column: isize| row as usize * COARSE + column as usize;
                    let (a, b) = (number(row, column), number(to_row, to_column));
                    links.push(Link { a, b, length: lengths * spacing, stiffness });
                }
            }
        }
    }
    links
}

/// A place on the smooth surface and its derivatives along the columns and rows.
#[derive(Clone, Copy)]
struct Jet {
    place: Vec3,
    along_u: Vec3,
    along_v: Vec3,
}

/// The uniform cubic B-spline over the coarse places, at `u` and `v` of 0 to 1.
///
/// It does not pass through the places, which removes the last unrest of the simulation.
fn surface(places: &[Vec3], u: f32, v: f32) -> Jet {
    let (column, weights_u, slopes_u) = basis(u);
    let (row, weights_v, slopes_v) = basis(v);
    let mut jet = Jet { place: Vec3::ZERO, along_u: Vec3::ZERO, along_v: Vec3::ZERO };
    for j in 0..4 {
        for i in 0..4 {
            let place = places[(row + j) * COARSE + column + i];
            jet.place += place * (weights_u[i] * weights_v[j]);
            jet.along_u += place * (slopes_u[i] * weights_v[j]);
            jet.along_v += place * (weights_u[i] * slopes_v[j]);
        }
    }
    jet
}

/// The first of four places that `t` depends on, with their weights and the slopes of these.
fn basis(t: f32) -> (usize, [f32; 4], [f32; 4]) {
    let spans = COARSE - 3;
    let x = t * spans as f32;
    let span = (x as usize).min(spans - 1);
    let s = x - span as f32;
    let r = 1.0 - s;
    let weights = [
        r * r * r / 6.0,
        (3.0 * s * s * s - 6.0 * s * s + 4.0) / 6.0,
        (3.0 * r * r * r - 6.0 * r * r + 4.0) / 6.0,
        s * s * s / 6.0,
    ];
    let slopes = [-0.5 * r * r, 0.5 * s * (3.0 * s - 4.0), -0.5 * r * (3.0 * r - 4.0), 0.5 * s * s];
    (span, weights, slopes)
}

/// A closed body around the middle surface: outside, inside and a half-round rim.
fn thicken(places: &[Vec3]) -> Mesh {
    /// Steps of the rim from the outside to the inside.
    const RIM: u32 = 6;
    let mut mesh = Mesh { name: "Cloth".to_owned(), ..Mesh::default() };
    let jets: Vec<Jet> = (0..=FINE)
        .flat_map(|row| (0..=FINE).map(move |column| (column, row)))
        .map(|(column, row)| surface(places, column as f32 / FINE as f32, row as f32 / FINE as f32))
        .collect();
    let jet = |column: u32, row: u32| jets[(row * (FINE + 1) + column) as usize];
    let half = THICKNESS / 2.0;
    let fraction = |k: u32| k as f32 / FINE as f32;
    // Rows go along +Z, towards the viewer: down the image, so this is the upper side.
    let up = |jet: Jet| jet.along_v.cross(jet.along_u).normalize();
    mesh.push_grid(FINE, FINE, |column, row| {
        let jet = jet(column, row);
        let n = up(jet);
        let uv = Vec2::new(fraction(column), fraction(row));
        SurfacePoint { position: jet.place + n * half, normal: n, tangent: jet.along_u, uv }
    });
    // From below, columns run the other way.
    mesh.push_grid(FINE, FINE, |column, row| {
        let jet = jet(FINE - column, row);
        let n = -up(jet);
        let uv = Vec2::new(fraction(column), fraction(row));
        SurfacePoint { position: jet.place + n * half, normal: n, tangent: -jet.along_u, uv }
    });
    // The rim along each edge, counter-clockwise seen from above: along it goes u, from above to below v.
    for side in 0..4 {
        mesh.push_grid(FINE, RIM, |k, step| {
            let (column, row) = match side {
                0 => (k, FINE),
                1 => (FINE, FINE - k),
                2 => (FINE - k, 0),
                _ => (0, k),
            };
            let jet = jet(column, row);
            let along = [jet.along_u, -jet.along_v, -jet.along_u, jet.along_v][side];
            let up = up(jet);
            let out = along.cross(up).normalize();
            // The ends of the rim lie exactly where the two sides end.
            let normal = match step {
                0 => up,
                RIM => -up,
                _ => {
                    let (sin, cos) = (step as f32 / RIM as f32 * std::f32::consts::PI).sin_cos();
                    up * cos + corner_out(side, k, out, up, jet) * sin
                }
            };
            let v = step as f32 / RIM as f32 * THICKNESS / EDGE;
            SurfacePoint { position: jet.place + normal * half, normal, tangent: along, uv: Vec2::new(fraction(k), v) }
        });
    }
    mesh
}

/// The outward direction of the rim; at a corner of the cloth the mean of both edges, so that the rims meet there.
fn corner_out(side: usize, k: u32, out: Vec3, up: Vec3, jet: Jet) -> Vec3 {
    let is_first = k == 0;
    if !is_first && k != FINE {
        return out;
    }
    // Which two edges meet: this one and the one before or after it, counted from the lower number.
    let other = if is_first { (side + 3) % 4 } else { (side + 1) % 4 };
    let directions = [jet.along_u, -jet.along_v, -jet.along_u, jet.along_v];
    let outward = |side: usize| directions[side].cross(up).normalize();
    let (a, b) = (side.min(other), side.max(other));
    (outward(a) + outward(b)).normalize()
}
