//! All triangles of a scene in one tree, in units of the edited object's size, and what shading needs at a hit.

use super::displace::{EDGE, HeightKey, Patch, Relief, length_scale};
use super::mip::Sources;
use super::walk::Field;
use crate::bvh::{Bvh, Hit, Ray};
use crate::scene::{Object, Scene};
use burnish_assets::Mesh;
use glam::{DVec3, Vec3};
use std::sync::{Arc, OnceLock};

/// Position, normal, tangent with handedness, texture coordinate of a vertex.
pub(super) type Vertex = [f32; 12];

/// Triangles in normalised units: the offset that leaves a surface is made for coordinates of order 1, so a scene of any size
/// renders the same picture.
#[derive(Debug)]
pub(super) struct Geometry {
    origins: Vec<Origin>,
    /// How the height of each object is drawn.
    pub reliefs: Vec<Relief>,
    /// Scene point that becomes the origin.
    center: DVec3,
    /// Normalised units per scene unit; a power of two, so that coordinates keep their digits.
    pub scale: f64,
    /// The tree; triangle numbers are positions in `triangles`.
    pub bvh: Bvh,
    /// Vertex attributes of all meshes.
    pub vertices: Vec<Vertex>,
    /// Three vertices and the object.
    pub triangles: Vec<[u32; 4]>,
    /// Unit geometric normals, outwards, by triangle.
    pub normals: Vec<[f32; 3]>,
    /// A sphere around each object; `None` around nothing.
    pub spheres: Vec<Option<Sphere>>,
    /// Distances inside of the objects, made when a walk first asks for them.
    fields: Vec<OnceLock<Option<Field>>>,
}

/// A ball of space, normalised units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sphere {
    /// Middle.
    pub center: Vec3,
    /// Radius, above 0.
    pub radius: f32,
}

impl Sphere {
    /// Around the middle of the points' bounds.
    fn around(points: &[[Vec3; 3]]) -> Option<Self> {
        let points = points.iter().flatten();
        let (min, max) = points.clone().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(a, b), p| (a.min(*p), b.max(*p)));
        let center = 0.5 * (min + max);
        let square = points.fold(0.0f32, |r, p| r.max(center.distance_squared(*p)));
        let radius = square.sqrt() * 1.000_1;
        (center.is_finite() && radius.is_finite() && radius > 0.0).then_some(Self { center, radius })
    }

    /// A sphere around both.
    pub(super) fn union(self, other: Self) -> Self {
        let offset = other.center - self.center;
        let distance = offset.length();
        if distance + other.radius <= self.radius {
            return self;
        }
        if distance + self.radius <= other.radius {
            return other;
        }
        let radius = 0.5 * (distance + self.radius + other.radius);
        Self { center: self.center + offset * ((radius - self.radius) / distance), radius: radius * 1.000_1 }
    }
}

/// What the triangles of an object depend on.
#[derive(Debug)]
struct Origin {
    mesh: Arc<Mesh>,
    is_document: bool,
    height: Option<HeightKey>,
}

impl Origin {
    fn of(object: &Object) -> Self {
        Self { mesh: object.mesh.clone(), is_document: object.is_document, height: HeightKey::of(object) }
    }

    fn is_of(&self, object: &Object) -> bool {
        Arc::ptr_eq(&self.mesh, &object.mesh) && self.is_document == object.is_document && self.height == HeightKey::of(object)
    }
}

impl Geometry {
    /// Collects the triangles. Those that use vertices which do not exist are left out.
    pub(super) fn new(scene: &Scene, sources: &mut Sources) -> Self {
        let bounds = scene.document_bounds();
        let radius = f64::from(bounds.radius());
        let exponent = if radius.is_finite() && radius > 0.0 { radius.log2().round().clamp(-120.0, 120.0) } else { 0.0 };
        let center = bounds.center().as_dvec3();
        let mut geometry = Self {
            origins: scene.objects.iter().map(Origin::of).collect(),
            reliefs: scene.objects.iter().map(|o| Relief::of(o, sources)).collect(),
            center: if center.is_finite() { center } else { DVec3::ZERO },
            scale: (-exponent).exp2(),
            bvh: Bvh::default(),
            vertices: Vec::new(),
            triangles: Vec::new(),
            normals: Vec::new(),
            spheres: Vec::new(),
            fields: scene.objects.iter().map(|_| OnceLock::new()).collect(),
        };
        let mut corners = Vec::new();
        for (number, object) in scene.objects.iter().enumerate() {
            let first = corners.len();
            geometry.add(object, number as u32, &mut corners);
            geometry.spheres.push(Sphere::around(&corners[first..]));
        }
        geometry.bvh = Bvh::new(&corners);
        geometry
    }

    /// Whether this is the geometry of the scene.
    pub(super) fn is_of(&self, scene: &Scene) -> bool {
        self.origins.len() == scene.objects.len() && self.origins.iter().zip(&scene.objects).all(|(a, b)| a.is_of(b))
    }

    fn add(&mut self, object: &Object, number: u32, corners: &mut Vec<[Vec3; 3]>) {
        let mut patch = Patch::new(&object.mesh, |p| self.normalized(p));
        let inputs = object.material.inputs();
        let scale = inputs.height_scale * length_scale(object) * self.scale;
        match &self.reliefs[number as usize] {
            Relief::Offset(height) => patch.offset(height * scale),
            Relief::Displaced(texture) => {
                patch.displace_by(texture, inputs.height_level, scale, (object.mesh.bounds(), self.scale), EDGE);
            }
            Relief::Flat | Relief::Bumped(_) | Relief::Unplaced => {}
        }
        let first = self.vertices.len() as u32;
        for t in &patch.triangles {
            let points = t.map(|i| {
                let v = &patch.vertices[i as usize];
                Vec3::new(v[0], v[1], v[2])
            });
            let [a, b, c] = points.map(|p| p.as_dvec3());
            let n = (b - a).cross(c - a).try_normalize().unwrap_or(DVec3::Y).as_vec3();
            self.triangles.push([t[0] + first, t[1] + first, t[2] + first, number]);
            self.normals.push(n.to_array());
            corners.push(points);
        }
        self.vertices.append(&mut patch.vertices);
    }

    /// Interpolated normal at a hit, unit, on the side of the geometric one; none where there is no triangle.
    pub(super) fn shading_normal(&self, hit: &Hit) -> Option<Vec3> {
        let [a, b, c, _] = *self.triangles.get(hit.triangle as usize)?;
        let normal = |corner: u32| {
            let vertex = &self.vertices[corner as usize];
            Vec3::new(vertex[3], vertex[4], vertex[5])
        };
        let ng = Vec3::from(self.normals[hit.triangle as usize]);
        let n = normal(a) * (1.0 - hit.u - hit.v) + normal(b) * hit.u + normal(c) * hit.v;
        let n = n.try_normalize().unwrap_or(ng);
        Some(if n.dot(ng) < 0.0 { -n } else { n })
    }

    /// The same for the point of a triangle's plane that is nearest to another, or the border of the triangle where that lies outside.
    pub(super) fn normal_near(&self, triangle: u32, point: Vec3) -> Option<Vec3> {
        let [a, b, c] = self.triangles.get(triangle as usize).map(|t| {
            [t[0], t[1], t[2]].map(|corner| {
                let vertex = &self.vertices[corner as usize];
                Vec3::new(vertex[0], vertex[1], vertex[2])
            })
        })?;
        let ([e, f], p) = ([b - a, c - a], point - a);
        let (ee, ef, ff, ep, fp) = (e.dot(e), e.dot(f), f.dot(f), e.dot(p), f.dot(p));
        let area = ee * ff - ef * ef;
        let inverse = if area > 0.0 { 1.0 / area } else { 0.0 };
        let u = ((ff * ep - ef * fp) * inverse).clamp(0.0, 1.0);
        let v = ((ee * fp - ef * ep) * inverse).clamp(0.0, 1.0);
        let outside = (u + v).max(1.0);
        self.shading_normal(&Hit { t: 0.0, triangle, u: u / outside, v: v / outside })
    }

    /// A scene point in normalised units.
    pub(super) fn normalized(&self, p: Vec3) -> Vec3 {
        ((p.as_dvec3() - self.center) * self.scale).as_vec3()
    }

    /// A point in normalised units in the scene.
    pub(super) fn in_scene(&self, p: DVec3) -> DVec3 {
        p / self.scale + self.center
    }

    /// Distances inside of an object; none for an object that is not there or has no extent.
    pub(super) fn field(&self, object: u32) -> Option<&Field> {
        let made = self.fields.get(object as usize)?.get_or_init(|| {
            let mut bounds = (Vec3::INFINITY, Vec3::NEG_INFINITY);
            for t in self.triangles.iter().filter(|t| t[3] == object) {
                for &i in &t[..3] {
                    let p = Vec3::from_slice(&self.vertices[i as usize][..3]);
                    bounds = (bounds.0.min(p), bounds.1.max(p));
                }
            }
            Field::new(bounds.0, bounds.1)
        });
        made.as_ref()
    }

    /// The object that holds a point (normalised units), if any: the one whose surface a ray leaves first without having entered
    /// it. Three rays vote, because one may run through a crack of an open mesh.
    pub(super) fn object_around(&self, point: Vec3) -> Option<u32> {
        let votes = [Vec3::new(0.36, 0.48, 0.8), Vec3::new(-0.8, 0.36, 0.48), Vec3::new(0.48, -0.8, -0.36)].map(|d| {
            let mut depth: Vec<(u32, i32)> = Vec::new();
            let mut ray = Ray::new(point, d);
            for _ in 0..1000 {
                let hit = self.bvh.closest(&ray);
                if hit.is_miss() {
                    return None;
                }
                let object = self.triangles[hit.triangle as usize][3];
                let is_exit = Vec3::from(self.normals[hit.triangle as usize]).dot(d) > 0.0;
                let position = depth.iter().position(|e| e.0 == object).unwrap_or_else(|| {
                    depth.push((object, 0));
                    depth.len() - 1
                });
                depth[position].1 += if is_exit { -1 } else { 1 };
                if depth[position].1 < 0 {
                    return Some(object);
                }
                ray.t_min = hit.t;
                ray.excluded = hit.triangle;
            }
            None
        });
        if votes[0] == votes[1] || votes[0] == votes[2] {
            votes[0]
        } else if votes[1] == votes[2] {
            votes[1]
        } else {
            None
        }
    }
}

/// A point moved off its surface along `n` (unit, to the side where the ray goes on), just beyond its rounding error. Per
/// component. Source: Waechter and Binder, Ray Tracing Gems 2019, chapter 6.
#[inline(always)]
pub(super) fn offset(p: f32, n: f32) -> f32 {
    const NEAR_ZERO: f32 = 1.0 / 32.0;
    let steps = (256.0 * n) as i32;
    let moved = f32::from_bits((p.to_bits() as i32).wrapping_add(if p < 0.0 { -steps } else { steps }) as u32);
    if p.abs() < NEAR_ZERO { p + n * (1.0 / 65536.0) } else { moved }
}
