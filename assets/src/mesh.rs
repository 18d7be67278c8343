//! Triangle meshes and what they are put together to. How they are made is in `shapes`, how they are read in `load`.

use glam::{Vec2, Vec3, Vec4};

use crate::progress::Progress;
use crate::tangents;

/// A triangle mesh with one normal, tangent and texture coordinate per vertex.
///
/// A complete mesh has as many normals, tangents and uvs as positions, and indices below that number; made shapes and
/// loaded models are complete. Lengths are scene units.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// What to show the user.
    pub name: String,
    /// Points in space. Where a surface needs two uvs or normals at one place, the point is repeated bit by bit.
    pub positions: Vec<Vec3>,
    /// Unit normals, outwards.
    pub normals: Vec<Vec3>,
    /// Unit tangents, orthogonal to the normals, along dP/du; `w` is 1 or -1.
    ///
    /// The bitangent is `w * cross(n, t)` and points to smaller v, which is upwards in the image; so an unmirrored
    /// mapping has `w` = 1 and normal maps with green upwards apply as they are (the convention of glTF).
    pub tangents: Vec<Vec4>,
    /// Texture coordinates; (0, 0) is the upper left corner of an image.
    pub uvs: Vec<Vec2>,
    /// Three vertex numbers each, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// The smallest box around all positions; [`Bounds::EMPTY`] if there are none.
    pub fn bounds(&self) -> Bounds {
        self.positions.iter().fold(Bounds::EMPTY, |bounds, &p| bounds.with(p))
    }

    /// Makes the mesh complete, and says in sentences what that took.
    ///
    /// Triangles that have no area, use a vertex that does not exist or lie at a place that is not finite are dropped,
    /// and so, without a word, are vertices that no triangle uses. Missing or unusable normals become the area-weighted mean of the
    /// triangles that share the vertex, missing uvs zero, missing tangents those of MikkTSpace (where uvs do not tell
    /// any: an arbitrary direction in the surface). Vertices are repeated where tangents differ on both sides of an
    /// edge.
    pub fn complete(self) -> (Self, Vec<String>) {
        self.complete_telling(Progress::NONE)
    }

    /// The same, telling how far it is; it goes on whatever the answer.
    pub(crate) fn complete_telling(mut self, progress: Progress<'_>) -> (Self, Vec<String>) {
        let mut notes = Vec::new();
        self.drop_bad_triangles(&mut notes);
        let count = self.positions.len();

        let has_uvs = self.uvs.len() == count;
        if !has_uvs {
            if !self.uvs.is_empty() {
                notes.push(format!("{} texture coordinates for {count} vertices: they were left out.", self.uvs.len()));
            }
            self.uvs = vec![Vec2::ZERO; count];
        }
        let odd_uvs = self.uvs.iter_mut().filter(|uv| !uv.is_finite()).map(|uv| *uv = Vec2::ZERO).count();
        if odd_uvs > 0 {
            notes.push(format!("{odd_uvs} texture coordinates are not finite: they were set to 0."));
        }

        self.fill_normals(&mut notes);

        let has_tangents = self.tangents.len() == count;
        if !has_tangents {
            if !self.tangents.is_empty() {
                notes.push(format!("{} tangents for {count} vertices: they were made anew.", self.tangents.len()));
            }
            if !has_uvs {
                notes.push("There are no texture coordinates, so the direction of tangents is arbitrary.".to_owned());
            }
            tangents::generate(&mut self, progress);
        }
        tangents::orthonormalize(&mut self);
        (self, notes)
    }

    /// Keeps the triangles that have an area, and the vertices that those use.
    fn drop_bad_triangles(&mut self, notes: &mut Vec<String>) {
        let before = self.triangles.len();
        let count = self.positions.len();
        self.triangles.retain(|t| t.iter().all(|&i| (i as usize) < count));
        let out_of_range = before - self.triangles.len();
        if out_of_range > 0 {
            notes.push(format!("{out_of_range} triangles use vertices that do not exist: they were left out."));
        }
        let valid = self.triangles.len();
        let positions = &self.positions;
        self.triangles.retain(|&t| {
            let area = doubled_area(positions, t).length_squared();
            area > 0.0 && area.is_finite()
        });
        let flat = valid - self.triangles.len();
        if flat > 0 {
            notes.push(format!("{flat} triangles have no area: they were left out."));
        }

        let mut is_used = vec![false; count];
        for &i in self.triangles.iter().flatten() {
            is_used[i as usize] = true;
        }
        if is_used.iter().all(|&used| used) {
            return;
        }
        let mut next = 0;
        let renumbered: Vec<u32> = is_used
            .iter()
            .map(|&used| {
                next += u32::from(used);
                next.wrapping_sub(1)
            })
            .collect();
        for i in self.triangles.iter_mut().flatten() {
            *i = renumbered[*i as usize];
        }
        keep(&mut self.positions, &is_used);
        keep(&mut self.normals, &is_used);
        keep(&mut self.tangents, &is_used);
        keep(&mut self.uvs, &is_used);
    }

    /// Gives every vertex a unit normal.
    fn fill_normals(&mut self, notes: &mut Vec<String>) {
        let count = self.positions.len();
        if self.normals.len() != count {
            if !self.normals.is_empty() {
                notes.push(format!("{} normals for {count} vertices: they were made anew.", self.normals.len()));
            }
            self.normals = self.area_weighted_normals();
            return;
        }
        let mut odd = 0;
        for n in &mut self.normals {
            *n = n.try_normalize().unwrap_or_else(|| {
                odd += 1;
                Vec3::ZERO
            });
        }
        if odd > 0 {
            notes.push(format!("{odd} normals have no direction: they were made anew."));
            let made = self.area_weighted_normals();
            for (n, made) in self.normals.iter_mut().zip(made) {
                if *n == Vec3::ZERO {
                    *n = made;
                }
            }
        }
    }

    /// For each vertex the mean direction of the triangles that share it, weighted by their areas.
    pub fn area_weighted_normals(&self) -> Vec<Vec3> {
        let mut normals = vec![Vec3::ZERO; self.positions.len()];
        for &t in &self.triangles {
            let area = doubled_area(&self.positions, t);
            for i in t {
                normals[i as usize] += area;
            }
        }
        // The sum can vanish where a surface folds back onto itself; any unit vector serves there. Large or tiny
        // models would leave the range of f32 in a squared length, hence the scaling first.
        for n in &mut normals {
            *n = (*n / n.abs().max_element().max(f32::MIN_POSITIVE)).try_normalize().unwrap_or(Vec3::Y);
        }
        normals
    }
}

/// Normal of a triangle, as long as twice its area.
fn doubled_area(positions: &[Vec3], [a, b, c]: [u32; 3]) -> Vec3 {
    let [a, b, c] = [a, b, c].map(|i| positions[i as usize]);
    (b - a).cross(c - a)
}

/// Keeps the entries whose flag is set, if there is one flag per entry.
fn keep<T>(entries: &mut Vec<T>, flags: &[bool]) {
    if entries.len() == flags.len() {
        let mut flags = flags.iter();
        entries.retain(|_| flags.next().is_some_and(|&flag| flag));
    }
}

/// A box along the axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// The corner with the smallest coordinates.
    pub min: Vec3,
    /// The corner with the largest coordinates.
    pub max: Vec3,
}

impl Bounds {
    /// The box around nothing: the neutral element of [`Bounds::union`]. Its size is 0.
    pub const EMPTY: Self = Self { min: Vec3::splat(f32::INFINITY), max: Vec3::splat(f32::NEG_INFINITY) };

    /// True if the box holds no point at all.
    pub fn is_empty(&self) -> bool {
        self.min.cmpgt(self.max).any()
    }

    /// The middle of the box; the origin for an empty one.
    pub fn center(&self) -> Vec3 {
        if self.is_empty() { Vec3::ZERO } else { self.min * 0.5 + self.max * 0.5 }
    }

    /// The three edge lengths; zero for an empty box.
    pub fn size(&self) -> Vec3 {
        if self.is_empty() { Vec3::ZERO } else { self.max - self.min }
    }

    /// Half the diagonal: the radius of the sphere through the corners. Zero for an empty box.
    pub fn radius(&self) -> f32 {
        self.size().length() * 0.5
    }

    /// The smallest box around both.
    pub fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// The smallest box around this one and `p`.
    pub fn with(self, p: Vec3) -> Self {
        Self { min: self.min.min(p), max: self.max.max(p) }
    }
}

/// What a part of a model is for.
///
/// The document's material goes on the objects; a renderer gives the other roles fixed materials of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Role {
    /// What is shown: carries the document's material.
    Object,
    /// What the object stands on.
    Stand,
    /// The light tiles of the floor.
    FloorLight,
    /// The dark tiles of the floor.
    FloorDark,
    /// A seamless floor with what rises behind it.
    Sweep,
}

/// A mesh and what it is for.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// What the mesh is for.
    pub role: Role,
    /// The triangles.
    pub mesh: Mesh,
}

/// Everything that is put before the camera together.
#[derive(Clone, Debug, PartialEq)]
pub struct Model {
    /// What to show the user: a label, or the file name without its ending.
    pub name: String,
    /// The parts; loaded models have only objects.
    pub parts: Vec<Part>,
    /// Size of a scene unit in millimetres, where the file states it: 1000 for glTF.
    pub unit_mm: Option<f64>,
}

impl Model {
    /// The smallest box around the parts with [`Role::Object`].
    pub fn object_bounds(&self) -> Bounds {
        let objects = self.parts.iter().filter(|part| part.role == Role::Object);
        objects.fold(Bounds::EMPTY, |bounds, part| bounds.union(part.mesh.bounds()))
    }

    /// The smallest box around all parts, the floor included.
    pub fn bounds(&self) -> Bounds {
        self.parts.iter().fold(Bounds::EMPTY, |bounds, part| bounds.union(part.mesh.bounds()))
    }
}
