//! The triangles of a scene as the boundary of a walk.

use super::super::geometry::Geometry;
use super::field::{Depth, Field};
use super::{Boundary, MARGIN, rounding};
use crate::bvh::{Hit, Nearest, Ray};
use glam::{DVec3, Vec3};

/// Triangles that rounding may put between the start of a ray and its point: those around one vertex.
const ACROSS_MAX: usize = 16;

/// The triangles, as seen from inside of one of the objects.
pub(in crate::path) struct Interior<'a> {
    geometry: &'a Geometry,
    field: Option<&'a Field>,
}

impl<'a> Interior<'a> {
    /// `object` is the body's; any number that is none leaves walks without its distances.
    pub(in crate::path) fn new(geometry: &'a Geometry, object: u32) -> Self {
        Self { geometry, field: geometry.field(object) }
    }

    /// Interpolated normal of the surface nearest to a point, unit; none where that would have to be searched.
    pub(in crate::path) fn outer_normal(&self, point: DVec3) -> Option<Vec3> {
        let depth = self.depth(point)?;
        self.geometry.normal_near(depth.triangle, point.as_vec3())
    }
}

impl Boundary for Interior<'_> {
    fn hit(&self, point: DVec3, direction: Vec3, t_max: f32) -> Hit {
        // The ray starts a little behind its point: a point just inside, rounded to just outside, would else fly out unnoticed.
        let back = (MARGIN * rounding(point)) as f32;
        let origin = (point - direction.as_dvec3() * f64::from(back)).as_vec3();
        let mut ray = Ray { t_max: t_max + back, ..Ray::new(origin, direction) };
        for _ in 0..ACROSS_MAX {
            let hit = self.geometry.bvh.closest(&ray);
            let is_behind = !hit.is_miss() && hit.t <= 2.0 * back && self.normal(hit.triangle, point).dot(direction) < 0.0;
            if !is_behind {
                return Hit { t: (hit.t - back).max(0.0), ..hit };
            }
            // The surface that the walk is about to fly away from.
            ray.excluded = hit.triangle;
            ray.t_min = hit.t;
        }
        Hit::MISS
    }

    fn nearest(&self, point: DVec3, r_max: f64, tolerance: f64) -> Option<Nearest> {
        self.geometry.bvh.nearest(point, r_max, tolerance)
    }

    fn depth(&self, point: DVec3) -> Option<Depth> {
        self.field?.depth(&self.geometry.bvh, &self.geometry.normals, point)
    }

    fn normal(&self, triangle: u32, _: DVec3) -> Vec3 {
        self.geometry.normals.get(triangle as usize).map_or(Vec3::Y, |n| Vec3::from(*n))
    }

    fn is_outside(&self, entered: u32, hit: &Hit, direction: Vec3) -> bool {
        let object = |triangle: u32| self.geometry.triangles.get(triangle as usize).map(|t| t[3]);
        object(entered).is_some()
            && object(entered) == object(hit.triangle)
            && self.normal(hit.triangle, DVec3::ZERO).dot(direction) < 0.0
    }
}
