//! The floor as the preview knows it: a horizontal plane with a colour map. Objects see it in their reflections, and it
//! has its own light map, since a floor has too few vertices to carry a shadow.

use crate::scene::{Object, Scene};
use burnish_assets::Mesh;
use burnish_material::Property;
use glam::{Vec2, Vec3};

/// Texels along each side of the colour map.
pub(super) const COLOR_SIZE: usize = 512;
/// Half the width of the maps, in radii of the object: at the edge a shadow has faded.
const HALF_WIDTH_RADII: f32 = 5.0;

/// A horizontal plane that one or more of the scene's meshes lie in.
#[derive(Clone, Debug)]
pub(super) struct Floor {
    /// Height of the plane.
    pub y: f32,
    /// Middle of the maps, x and z.
    pub center: Vec2,
    /// Half the width of the maps.
    pub half_width: f32,
    /// Half the width of the floor itself.
    pub reach: f32,
    /// Albedo, [`COLOR_SIZE`] squared, rows along z.
    pub color: Vec<Vec3>,
    /// Mean albedo of the map.
    pub mean: Vec3,
}

/// Whether an object is a part of the floor: not edited, flat, horizontal, facing up.
pub(super) fn is_floor(object: &Object) -> bool {
    !object.is_document && floor_height(&object.mesh).is_some()
}

fn floor_height(mesh: &Mesh) -> Option<f32> {
    let y = mesh.positions.first()?.y;
    let is_flat = mesh.positions.iter().all(|p| (p.y - y).abs() <= 1e-5) && mesh.normals.iter().all(|n| n.y > 0.9999);
    is_flat.then_some(y)
}

/// The floor of a scene, if it has one.
pub(super) fn find(scene: &Scene) -> Option<Floor> {
    let parts: Vec<&Object> = scene.objects.iter().filter(|o| is_floor(o)).collect();
    let y = floor_height(&parts.first()?.mesh)?;
    let bounds = scene.document_bounds();
    let center = Vec2::new(bounds.center().x, bounds.center().z);
    let half_width = HALF_WIDTH_RADII * bounds.radius().max(1e-6);
    let mut color = vec![Vec3::ZERO; COLOR_SIZE * COLOR_SIZE];
    let mut reach = 0.0_f32;
    for object in &parts {
        let albedo = object.material.color(Property::base_color).map(|c| c as f32).into();
        paint(&object.mesh, albedo, center, half_width, &mut color);
        reach = object.mesh.positions.iter().fold(reach, |r, p| r.max(p.x.abs()).max(p.z.abs()));
    }
    let mean = color.iter().sum::<Vec3>() / color.len() as f32;
    Some(Floor { y, center, half_width, reach, color, mean })
}

/// Gives every texel whose middle lies in a triangle the triangle's colour.
fn paint(mesh: &Mesh, albedo: Vec3, center: Vec2, half_width: f32, color: &mut [Vec3]) {
    let n = COLOR_SIZE as f32;
    let texel = |p: Vec3| (Vec2::new(p.x, p.z) - center) / half_width * (0.5 * n) + 0.5 * n - 0.5;
    for t in &mesh.triangles {
        let [a, b, c] = t.map(|i| texel(mesh.positions[i as usize]));
        let low = a.min(b).min(c).ceil().max(Vec2::ZERO);
        let high = a.max(b).max(c).floor().min(Vec2::splat(n - 1.0));
        if low.x > high.x || low.y > high.y {
            continue;
        }
        let area = (b - a).perp_dot(c - a);
        for j in low.y as usize..=high.y as usize {
            for i in low.x as usize..=high.x as usize {
                let p = Vec2::new(i as f32, j as f32);
                let side = [(a, b), (b, c), (c, a)].map(|(a, b)| (b - a).perp_dot(p - a) * area);
                if side.iter().all(|s| *s >= 0.0) {
                    color[j * COLOR_SIZE + i] = albedo;
                }
            }
        }
    }
}
