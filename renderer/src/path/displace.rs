//! Displacement: meshes refined until the height map shows, and moved along their normals (model reference 13).

use super::geometry::Vertex;
use super::mip::Sources;
use super::texture::Texture;
use crate::scene::Object;
use burnish_assets::{Bounds, Image, Mesh};
use burnish_material::{Lobe, LobeSet, Property, TextureRef};
use glam::Vec3;
use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};
use std::sync::Arc;

/// Longest edge of a displaced mesh, as a fraction of the radius of the object's bounds. What is finer only bends normals.
pub(super) const EDGE: f32 = 1.0 / 128.0;
/// Most triangles that a displaced object is expected to have.
const TRIANGLES_MAX: f64 = 2e6;
/// Area of the triangles that edges of length 1 at most end in, on average: bisection leaves lengths from 0.5 to 1.
const AREA: f64 = 0.2;
/// Refinements at most. Each halves the edges, and none is longer than 256 of the longest allowed; the rest is for the new edges across
/// triangles, which can be as long as the old ones.
const PASSES_MAX: u32 = 16;
/// Furthest displacement, in normalised units: the edited object's size is about 1.
pub(super) const REACH: f32 = 16.0;

/// How the height of a material is drawn on an object.
#[derive(Clone, Debug)]
pub(super) enum Relief {
    /// Not at all.
    Flat,
    /// The whole surface is moved by this many units of height.
    Offset(f64),
    /// The mesh is refined and displaced.
    Displaced(Texture),
    /// The map bends normals only: the mesh would become too large.
    Bumped(Texture),
    /// There are no texture coordinates that the map could be found by.
    Unplaced,
}

/// What the displaced mesh of an object depends on, apart from the mesh.
#[derive(Clone, Debug)]
pub(crate) struct HeightKey {
    map: Option<(Arc<Image>, TextureRef)>,
    height: f64,
    level: f64,
    scale: f64,
}

impl PartialEq for HeightKey {
    fn eq(&self, other: &Self) -> bool {
        let is_same_map = match (&self.map, &other.map) {
            (Some((a, ra)), Some((b, rb))) => Arc::ptr_eq(a, b) && ra == rb,
            (None, None) => true,
            _ => false,
        };
        is_same_map && (self.height, self.level, self.scale) == (other.height, other.level, other.scale)
    }
}

impl HeightKey {
    /// The key of an object; `None` if its material has no height.
    pub(crate) fn of(object: &Object) -> Option<Self> {
        let material = &object.material;
        if !LobeSet::of(material).has(Lobe::height) {
            return None;
        }
        let inputs = material.inputs();
        let reference = material.slot(Property::height).texture.as_ref();
        let map = reference.and_then(|r| Some((object.textures.get(&r.path)?.clone(), r.clone())));
        // With a map the uniform height has no say.
        let height = if map.is_some() { 0.0 } else { inputs.height };
        Some(Self { map, height, level: inputs.height_level, scale: length_scale(object) * inputs.height_scale })
    }
}

/// Scene units per unit of the object's lengths.
pub(super) fn length_scale(object: &Object) -> f64 {
    if object.length_scale.is_finite() && object.length_scale > 0.0 { object.length_scale } else { 1.0 }
}

impl Relief {
    /// Decides how the height of an object is drawn.
    pub(super) fn of(object: &Object, sources: &mut Sources) -> Self {
        if !LobeSet::of(&object.material).has(Lobe::height) {
            return Self::Flat;
        }
        let inputs = object.material.inputs();
        let offset =
            |height: f64| if height == inputs.height_level { Self::Flat } else { Self::Offset(height - inputs.height_level) };
        let Some(texture) = Texture::of(object, Property::height, sources) else { return offset(inputs.height) };
        if let Some(value) = texture.constant() {
            // The level is a file's number of double precision; a map that holds it in single precision means the same.
            let is_level = value[0] == inputs.height_level as f32;
            return if is_level { Self::Flat } else { offset(f64::from(value[0])) };
        }
        let mesh = &object.mesh;
        if mesh.uvs.len() != mesh.positions.len() || mesh.uvs.windows(2).all(|pair| pair[0] == pair[1]) {
            return Self::Unplaced;
        }
        if expected_triangles(mesh) > TRIANGLES_MAX { Self::Bumped(texture) } else { Self::Displaced(texture) }
    }

    /// What is left out, in words that follow a material's name.
    pub(super) fn shortcoming(&self) -> Option<&'static str> {
        match self {
            Self::Flat | Self::Offset(_) | Self::Displaced(_) => None,
            Self::Bumped(_) => {
                Some("displacing the surface would take more than 2 million triangles; the height map bends its normals only")
            }
            Self::Unplaced => Some("the mesh has no texture coordinates; the height map is left out"),
        }
    }
}

/// Triangles that refinement is expected to end with.
fn expected_triangles(mesh: &Mesh) -> f64 {
    let longest = f64::from(longest_edge(mesh.bounds(), 1.0, EDGE));
    let corner = |i: u32| mesh.positions.get(i as usize).copied().unwrap_or_default().as_dvec3();
    let of = |t: &[u32; 3]| {
        let [a, b, c] = t.map(corner);
        let area = 0.5 * (b - a).cross(c - a).length();
        let edge = a.distance(b).max(b.distance(c)).max(c.distance(a));
        (area / (AREA * longest * longest)).max(edge / longest).max(1.0)
    };
    mesh.triangles.iter().map(of).sum()
}

/// Longest edge after refinement to a fraction `edge` of the radius, where the mesh's lengths are multiplied by `scale`.
fn longest_edge(bounds: Bounds, scale: f64, edge: f32) -> f32 {
    (f64::from(bounds.radius() * edge) * scale) as f32
}

/// A mesh in normalised units.
#[derive(Clone, Debug, Default)]
pub(super) struct Patch {
    /// Vertices; normals and tangents need not be unit.
    pub vertices: Vec<Vertex>,
    /// Three vertices each.
    pub triangles: Vec<[u32; 3]>,
}

impl Patch {
    /// A mesh as it is, its places moved by `place`. Triangles that use vertices which do not exist are left out.
    pub(super) fn new(mesh: &Mesh, place: impl Fn(Vec3) -> Vec3) -> Self {
        let mut patch = Self::default();
        for (i, p) in mesh.positions.iter().enumerate() {
            let p = place(*p);
            let n = mesh.normals.get(i).copied().unwrap_or(Vec3::ZERO);
            let t = mesh.tangents.get(i).copied().unwrap_or(glam::Vec4::ZERO);
            let uv = mesh.uvs.get(i).copied().unwrap_or_default();
            patch.vertices.push([p.x, p.y, p.z, n.x, n.y, n.z, t.x, t.y, t.z, t.w, uv.x, uv.y]);
        }
        let exists = |t: &&[u32; 3]| t.iter().all(|&i| (i as usize) < mesh.positions.len());
        patch.triangles.extend(mesh.triangles.iter().filter(exists));
        patch
    }

    /// Moves every vertex along its unit normal by `distance`, normalised units.
    pub(super) fn offset(&mut self, distance: f64) {
        let distances = vec![reach(distance); self.vertices.len()];
        self.displace(&distances);
    }

    /// Refines the mesh for a height map and displaces it. `scale`: normalised units per unit of height; `bounds` of the mesh in units of which
    /// a normalised one has `1 / unit`; edges end no longer than a fraction `edge` of their radius.
    pub(super) fn displace_by(&mut self, texture: &Texture, level: f64, scale: f64, (bounds, unit): (Bounds, f64), edge: f32) {
        let longest = longest_edge(bounds, unit, edge);
        if longest > 0.0 && longest.is_finite() {
            for _ in 0..PASSES_MAX {
                // The second condition ends what the expectation missed; whole passes leave no cracks.
                if !self.refine(longest) || self.triangles.len() as f64 > 2.0 * TRIANGLES_MAX {
                    break;
                }
            }
        }
        // The map is read as finely as the vertices stand.
        let mut spacing = vec![(0.0f32, 0.0f32); self.vertices.len()];
        for t in &self.triangles {
            for k in 0..3 {
                let (a, b) = (t[k] as usize, t[(k + 1) % 3] as usize);
                let (p, q) = (&self.vertices[a], &self.vertices[b]);
                let length = (p[10] - q[10]).hypot(p[11] - q[11]);
                for i in [a, b] {
                    spacing[i].0 += length;
                    spacing[i].1 += 1.0;
                }
            }
        }
        let distance = |(v, (sum, count)): (&Vertex, &(f32, f32))| {
            let height = texture.lookup([v[10], v[11]], texture.level(sum / count.max(1.0)))[0];
            reach((f64::from(height) - level) * scale)
        };
        let distances: Vec<f32> = self.vertices.iter().zip(&spacing).map(distance).collect();
        self.displace(&distances);
    }

    /// Moves each vertex by its distance. Vertices at one place stay together, or the surface would crack where uvs or normals are
    /// repeated: all go by the mean of their distances, along the mean of their normals divided by its squared length, so that
    /// planes that meet there at any angle up to a cube's corner all move by that distance.
    fn displace(&mut self, distances: &[f32]) {
        let place = |v: &Vertex| {
            // Adding 0 makes -0 and 0 one place.
            let [x, y, z] = [v[0], v[1], v[2]].map(|x| u64::from((x + 0.0).to_bits()));
            (x << 32 | y, z)
        };
        let normal = |v: &Vertex| Vec3::new(v[3], v[4], v[5]).normalize_or_zero();
        let mut places: Quick<(u64, u64), (Vec3, f32, f32)> =
            HashMap::with_capacity_and_hasher(self.vertices.len(), BuildHasherDefault::default());
        for (v, d) in self.vertices.iter().zip(distances) {
            let sum = places.entry(place(v)).or_default();
            *sum = (sum.0 + normal(v), sum.1 + d, sum.2 + 1.0);
        }
        for v in &mut self.vertices {
            let Some((n, d, count)) = places.get(&place(v)) else { continue };
            let n = *n / *count;
            let by = n * (d / count) / n.length_squared().max(0.25);
            for (x, by) in v.iter_mut().zip(by.to_array()) {
                *x += by;
            }
        }
    }

    /// Splits every edge longer than `longest` in the middle. False if there is none.
    ///
    /// The end points alone decide and their order does not matter, so both sides of an edge agree to the bit, also where they have
    /// vertices of their own.
    fn refine(&mut self, longest: f32) -> bool {
        let limit = longest * longest;
        let vertices = &mut self.vertices;
        let mut middles: Quick<u64, u32> = HashMap::default();
        let mut refined = Vec::with_capacity(self.triangles.len());
        for &t in &self.triangles {
            let middle = [0, 1, 2].map(|k| {
                let (a, b) = (t[k], t[(k + 1) % 3]);
                let (p, q) = (vertices[a as usize], vertices[b as usize]);
                let length = squared(&p, &q);
                // A place that is not finite stays where it is.
                (length > limit && length.is_finite()).then(|| {
                    *middles.entry(u64::from(a.min(b)) << 32 | u64::from(a.max(b))).or_insert_with(|| {
                        let half = std::array::from_fn(|k| 0.5 * p[k] + 0.5 * q[k]);
                        vertices.push(half);
                        (vertices.len() - 1) as u32
                    })
                })
            });
            split(t, middle, vertices, &mut refined);
        }
        self.triangles = refined;
        !middles.is_empty()
    }
}

/// A table that is filled from a mesh: millions of entries, and nobody who would choose keys that collide.
type Quick<K, V> = HashMap<K, V, BuildHasherDefault<Mix>>;

/// The multiply and rotate of FxHash.
#[derive(Default)]
struct Mix(u64);

impl Hasher for Mix {
    fn finish(&self) -> u64 {
        // The last product's best bits are its upper ones; the table looks at both ends.
        self.0.rotate_left(26)
    }

    fn write(&mut self, bytes: &[u8]) {
        bytes.iter().for_each(|b| self.write_u64(u64::from(*b)));
    }

    fn write_u64(&mut self, x: u64) {
        self.0 = (self.0.rotate_left(23) ^ x).wrapping_mul(0x517c_c1b7_2722_0a95);
    }
}

/// A distance that single precision holds and the picture can show.
fn reach(distance: f64) -> f32 {
    let limit = f64::from(REACH);
    if distance.is_nan() { 0.0 } else { distance.clamp(-limit, limit) as f32 }
}

fn squared(p: &Vertex, q: &Vertex) -> f32 {
    let [x, y, z] = [0, 1, 2].map(|k| p[k] - q[k]);
    x * x + y * y + z * z
}

/// The parts of a triangle whose edges (each after the corner of its number) are split at the given vertices.
fn split(t: [u32; 3], middle: [Option<u32>; 3], vertices: &[Vertex], out: &mut Vec<[u32; 3]>) {
    // Turned so that the first edge is split, and of two, the last is whole.
    let turn = match middle {
        [None, None, None] => return out.push(t),
        [Some(_), Some(_), _] | [Some(_), None, None] => 0,
        [None, Some(_), _] => 1,
        [Some(_), None, Some(_)] => 2,
        [None, None, Some(_)] => 2,
    };
    let at = |k: usize| (k + turn) % 3;
    let [a, b, c] = [t[at(0)], t[at(1)], t[at(2)]];
    match [middle[at(0)], middle[at(1)], middle[at(2)]] {
        [Some(m), Some(n), Some(o)] => out.extend([[a, m, o], [m, b, n], [o, n, c], [m, n, o]]),
        [Some(m), Some(n), None] => {
            out.push([m, b, n]);
            let length = |i: u32, j: u32| squared(&vertices[i as usize], &vertices[j as usize]);
            // The shorter diagonal gives rounder triangles.
            if length(a, n) <= length(m, c) {
                out.extend([[a, m, n], [a, n, c]]);
            } else {
                out.extend([[a, m, c], [m, n, c]]);
            }
        }
        [Some(m), ..] => out.extend([[a, m, c], [m, b, c]]),
        _ => out.push(t),
    }
}
