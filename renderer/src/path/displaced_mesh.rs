//! A displaced mesh of few triangles, for whoever draws it by rasterising.

use super::displace::{Patch, Relief, length_scale};
use super::mip::Sources;
use crate::scene::Object;
use burnish_assets::Mesh;
use glam::{Vec2, Vec3, Vec4};
use std::sync::Arc;

/// Longest edge as a fraction of the radius of the object's bounds: outlines show no corners, and normals bend by the map.
const EDGE: f32 = 1.0 / 40.0;

/// The mesh of an object as its height displaces it, in scene units; its own where nothing is displaced. Normals stay those of the flat mesh,
/// and every height has the same vertices in the same order.
pub(crate) fn displaced_mesh(object: &Object) -> Arc<Mesh> {
    let (mesh, inputs) = (&object.mesh, object.material.inputs());
    let bounds = mesh.bounds();
    let (center, radius) = (bounds.center().as_dvec3(), f64::from(bounds.radius()));
    if !(radius > 0.0 && radius.is_finite()) {
        return mesh.clone();
    }
    let unit = 1.0 / radius;
    let mut patch = Patch::new(mesh, |p| ((p.as_dvec3() - center) * unit).as_vec3());
    let scale = inputs.height_scale * length_scale(object) * unit;
    match Relief::of(object, &mut Sources::default()) {
        Relief::Offset(height) => patch.offset(height * scale),
        Relief::Displaced(texture) => patch.displace_by(&texture, inputs.height_level, scale, (bounds, unit), EDGE),
        Relief::Flat | Relief::Bumped(_) | Relief::Unplaced => return mesh.clone(),
    }
    let three = |v: &[f32; 12], k: usize| Vec3::new(v[k], v[k + 1], v[k + 2]);
    let each = patch.vertices.iter();
    Arc::new(Mesh {
        name: mesh.name.clone(),
        positions: each.clone().map(|v| (three(v, 0).as_dvec3() * radius + center).as_vec3()).collect(),
        normals: each.clone().map(|v| three(v, 3).normalize_or_zero()).collect(),
        tangents: each
            .clone()
            .map(|v| three(v, 6).normalize_or_zero().extend(if v[9] < 0.0 { -1.0 } else { 1.0 }))
            .collect::<Vec<Vec4>>(),
        uvs: each.map(|v| Vec2::new(v[10], v[11])).collect(),
        triangles: patch.triangles,
    })
}
