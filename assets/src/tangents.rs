//! Tangents for meshes whose files bring none: MikkTSpace, which is what normal maps are baked for.
//!
//! Where vertices are shared exactly as MikkTSpace would share them, which is usual for smooth surfaces, its formula is
//! applied directly: ten times as fast as its search for what belongs together.

use bevy_mikktspace::{Geometry, TangentSpace, generate_tangents};
use glam::{Vec2, Vec3, Vec4};

use crate::mesh::Mesh;
use crate::progress::Progress;
use std::cell::Cell;

/// How often the algorithm asks for a position, for each face.
const POSITIONS_PER_FACE: usize = 21;
/// So many questions are one more word about the progress.
const TELLING: usize = 1 << 16;

/// One tangent per corner of each triangle; zero where the algorithm has no answer.
struct Corners<'a> {
    mesh: &'a Mesh,
    tangents: Vec<[Vec4; 3]>,
    /// Positions that were asked for, which tells how far the algorithm is.
    asked: Cell<usize>,
    progress: Progress<'a>,
}

impl Corners<'_> {
    fn vertex(&self, face: usize, vert: usize) -> usize {
        self.mesh.triangles[face][vert] as usize
    }
}

impl Geometry for Corners<'_> {
    fn num_faces(&self) -> usize {
        self.mesh.triangles.len()
    }

    fn num_vertices_of_face(&self, _face: usize) -> usize {
        3
    }

    fn position(&self, face: usize, vert: usize) -> [f32; 3] {
        let asked = self.asked.get() + 1;
        self.asked.set(asked);
        if asked.is_multiple_of(TELLING) {
            // It cannot be stopped on its way.
            _ = self.progress.tell_count(asked, POSITIONS_PER_FACE * self.num_faces());
        }
        self.mesh.positions[self.vertex(face, vert)].to_array()
    }

    fn normal(&self, face: usize, vert: usize) -> [f32; 3] {
        self.mesh.normals[self.vertex(face, vert)].to_array()
    }

    fn tex_coord(&self, face: usize, vert: usize) -> [f32; 2] {
        self.mesh.uvs[self.vertex(face, vert)].to_array()
    }

    fn set_tangent(&mut self, space: Option<TangentSpace>, face: usize, vert: usize) {
        // The algorithm takes v as growing upwards, the mesh as growing downwards: the handedness turns round.
        let [x, y, z, w] = space.map_or([0.0; 4], |space| space.tangent_encoded());
        self.tangents[face][vert] = Vec4::new(x, y, z, -w);
    }
}

/// Gives every vertex of `mesh` a tangent; all its other fields must be complete.
///
/// Uses the direct sum where it applies, else the whole algorithm.
pub(crate) fn generate(mesh: &mut Mesh, progress: Progress<'_>) {
    match shared(mesh) {
        Some(tangents) => mesh.tangents = tangents,
        None => generate_split(mesh, progress),
    }
}

/// For each vertex the sum over its triangles of dP/du, projected onto the vertex' plane and weighted by the angle at the
/// vertex there; that is the formula of MikkTSpace for one group of triangles.
///
/// `None` where groups are not simply the triangles around a vertex: two vertices are equal, a mapping is mirrored in
/// one part only or has no area somewhere. (Triangles that meet in nothing but the vertex count as one group here.)
fn shared(mesh: &Mesh) -> Option<Vec<Vec4>> {
    // Equal vertices have equal keys. Should different ones have too, the whole algorithm runs, and nothing is lost.
    let vertices = mesh.positions.iter().zip(&mesh.normals).zip(&mesh.uvs);
    let mut keys: Vec<u64> = vertices.map(|((&p, &n), &uv)| key(p, n, uv)).collect();
    keys.sort_unstable();
    if keys.windows(2).any(|pair| pair[0] == pair[1]) {
        return None;
    }
    let mut sums = vec![Vec4::ZERO; mesh.positions.len()];
    for t in &mesh.triangles {
        let corner = t.map(|i| i as usize);
        let p = corner.map(|i| mesh.positions[i]);
        let uv = corner.map(|i| mesh.uvs[i]);
        let (d1, d2) = (p[1] - p[0], p[2] - p[0]);
        let (e1, e2) = (uv[1] - uv[0], uv[2] - uv[0]);
        let area = e1.perp_dot(e2);
        if !area.is_normal() {
            return None;
        }
        let along = (d1 * e2.y - d2 * e1.y) * area.signum();
        for k in 0..3 {
            let n = mesh.normals[corner[k]];
            let flat = |v: Vec3| (v - n * n.dot(v)).normalize_or_zero();
            let (to_next, to_last) = (flat(p[(k + 1) % 3] - p[k]), flat(p[(k + 2) % 3] - p[k]));
            let angle = to_next.dot(to_last).clamp(-1.0, 1.0).acos();
            let sum = &mut sums[corner[k]];
            if sum.w * area > 0.0 {
                return None;
            }
            *sum = (sum.truncate() + flat(along) * angle).extend(-area.signum());
        }
    }
    Some(sums)
}

/// A number that is the same for equal vertices and most likely another for others (the multiply and rotate of FxHash).
fn key(p: Vec3, n: Vec3, uv: Vec2) -> u64 {
    [p.x, p.y, p.z, n.x, n.y, n.z, uv.x, uv.y].iter().fold(0_u64, |key, x| {
        // Adding 0 makes -0 and 0 one number.
        (key.rotate_left(23) ^ u64::from((x + 0.0).to_bits())).wrapping_mul(0x517c_c1b7_2722_0a95)
    })
}

/// Runs the whole algorithm. A vertex whose triangles disagree (a mirrored mapping, or the end of a seam) is repeated once for each tangent.
fn generate_split(mesh: &mut Mesh, progress: Progress<'_>) {
    let mut corners = Corners { tangents: vec![[Vec4::ZERO; 3]; mesh.triangles.len()], mesh, asked: Cell::new(0), progress };
    // The error type has no values: the call cannot fail.
    let _ = generate_tangents(&mut corners);
    let tangents = corners.tangents;

    // `next_twin` chains the copies of a vertex; copies are appended, so 0 never is one and stands for "none".
    let count = mesh.positions.len();
    mesh.tangents = vec![Vec4::ZERO; count];
    let mut is_set = vec![false; count];
    let mut next_twin = vec![0u32; count];
    for (triangle, tangents) in mesh.triangles.iter_mut().zip(tangents) {
        for (corner, tangent) in triangle.iter_mut().zip(tangents) {
            let mut i = *corner as usize;
            if !is_set[i] {
                is_set[i] = true;
                mesh.tangents[i] = tangent;
                continue;
            }
            while mesh.tangents[i] != tangent && next_twin[i] != 0 {
                i = next_twin[i] as usize;
            }
            if mesh.tangents[i] != tangent {
                let Ok(twin) = u32::try_from(mesh.positions.len()) else { continue };
                next_twin[i] = twin;
                i = twin as usize;
                mesh.positions.push(mesh.positions[*corner as usize]);
                mesh.normals.push(mesh.normals[*corner as usize]);
                mesh.uvs.push(mesh.uvs[*corner as usize]);
                mesh.tangents.push(tangent);
                is_set.push(true);
                next_twin.push(0);
            }
            *corner = i as u32;
        }
    }
}

/// Makes tangents unit, orthogonal to the normals, and their `w` 1 or -1; those without direction become arbitrary.
pub(crate) fn orthonormalize(mesh: &mut Mesh) {
    for (tangent, &n) in mesh.tangents.iter_mut().zip(&mesh.normals) {
        let t = tangent.truncate().try_normalize().unwrap_or(Vec3::ZERO);
        let across = t - n * n.dot(t);
        // Below a thousandth, rounding decides the direction.
        let t = if across.length_squared() > 1e-6 { across.normalize() } else { n.any_orthonormal_vector() };
        let t = (t - n * n.dot(t)).normalize();
        *tangent = t.extend(if tangent.w < 0.0 { -1.0 } else { 1.0 });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A ball's tangents by both ways; they must agree but for rounding.
    #[test]
    fn direct_sum_agrees_with_the_whole_algorithm() {
        let model = crate::make_shape("torus").expect("it is in the table");
        let mut direct = model.parts.into_iter().next().expect("it has an object").mesh;
        direct.tangents.clear();
        let mut whole = direct.clone();
        direct.tangents = shared(&direct).expect("the torus shares vertices as it should");
        generate_split(&mut whole, Progress::NONE);
        orthonormalize(&mut direct);
        orthonormalize(&mut whole);
        assert_eq!(direct.positions.len(), whole.positions.len(), "nothing to split");
        let worst = direct.tangents.iter().zip(&whole.tangents).map(|(a, b)| a.distance(*b)).fold(0.0, f32::max);
        assert!(worst < 1e-3, "{worst}");
    }

    #[test]
    fn a_mirrored_seam_is_split() {
        // Two triangles that share an edge; u grows towards it from both sides.
        let positions = vec![Vec3::ZERO, Vec3::X, Vec3::new(0.0, 1.0, 0.0), Vec3::NEG_X];
        let uvs = vec![Vec2::new(1.0, 1.0), Vec2::new(0.0, 1.0), Vec2::new(1.0, 0.0), Vec2::new(0.0, 1.0)];
        let triangles = vec![[0, 1, 2], [0, 2, 3]];
        let mesh = Mesh { positions, uvs, triangles, ..Mesh::default() };
        let (mesh, notes) = mesh.complete();
        assert!(notes.is_empty(), "{notes:?}");
        assert_eq!(mesh.positions.len(), 6, "the two shared vertices are repeated");
        for (t, x) in mesh.triangles.iter().zip([-1.0, 1.0]) {
            for &i in t {
                let tangent = mesh.tangents[i as usize];
                assert!((tangent.x - x).abs() < 1e-5 && tangent.w == x.signum(), "{tangent}");
            }
        }
    }
}
