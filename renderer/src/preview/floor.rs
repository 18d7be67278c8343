//! The floor as the preview knows it: a horizontal plane with a colour map. Objects see it in their reflections, and it
//! has its own light map, since a floor has too few vertices to carry a shadow.

use super::environment::Level;
use super::upload::chain;
use crate::scene::{Object, Scene};
use burnish_assets::Mesh;
use burnish_material::Property;
use glam::{Vec2, Vec3};
use std::f32::consts::PI;

/// Texels along each side of the colour map.
pub(super) const COLOR_SIZE: usize = 512;
/// Texels along each side of the light map.
pub(super) const LIGHT_SIZE: usize = 128;
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
    /// Albedo, [`COLOR_SIZE`] squared, rows along z.
    pub color: Vec<Vec3>,
    /// What wide lobes see of it.
    pub pavement: Pavement,
    /// Its corners, x and z: beyond them is nothing but the environment.
    pub extent: [Vec2; 2],
}

/// A floor as it is seen from the middle of the edited object: one colour, up to its edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Pavement {
    /// Mean albedo.
    pub albedo: Vec3,
    /// How far below the horizon its edge lies: the sine of that angle.
    pub edge: f32,
}

impl Floor {
    /// The middle of a texel of the light map.
    pub fn place(&self, texel: usize) -> Vec3 {
        let at = |k: usize| ((k as f32 + 0.5) / LIGHT_SIZE as f32 * 2.0 - 1.0) * self.half_width;
        Vec3::new(self.center.x + at(texel % LIGHT_SIZE), self.y, self.center.y + at(texel / LIGHT_SIZE))
    }

    /// Radiance of the floor and its averages, for open irradiance `up` and what bodies take of it.
    pub fn radiance(&self, up: Vec3, light: Option<&Level>) -> Vec<Level> {
        let texels = self.color.iter().enumerate().map(|(k, color)| {
            let at = |k: usize| (k as f32 + 0.5) / COLOR_SIZE as f32 * LIGHT_SIZE as f32 - 0.5;
            let change = light.map_or(Vec3::ZERO, |light| bilinear(light, at(k % COLOR_SIZE), at(k / COLOR_SIZE)));
            *color * (up + change).max(Vec3::ZERO) / PI
        });
        chain(Level { width: COLOR_SIZE, height: COLOR_SIZE, texels: texels.collect() })
    }

    /// Whether there is floor at world point `p`.
    pub fn holds(&self, p: Vec3) -> bool {
        let [low, high] = self.extent;
        p.x >= low.x && p.x <= high.x && p.z >= low.y && p.z <= high.y
    }

    /// Radiance at world point `p`, or `None` outside of the maps. Nearest texels: for sums over many.
    pub fn radiance_at(&self, p: Vec3, up: Vec3, light: &Level) -> Option<Vec3> {
        let at = (Vec2::new(p.x, p.z) - self.center) / self.half_width * 0.5 + 0.5;
        if !(at.min_element() >= 0.0 && at.max_element() < 1.0) {
            return None;
        }
        let texel = |n: usize| (at.y * n as f32) as usize * n + (at.x * n as f32) as usize;
        Some(self.color[texel(COLOR_SIZE)] * (up + light.texels[texel(LIGHT_SIZE)]).max(Vec3::ZERO) / PI)
    }
}

fn bilinear(level: &Level, x: f32, y: f32) -> Vec3 {
    let (x, y) = (x.clamp(0.0, (level.width - 1) as f32), y.clamp(0.0, (level.height - 1) as f32));
    let (i, j) = ((x as usize).min(level.width - 2), (y as usize).min(level.height - 2));
    let at = |i: usize, j: usize| level.texels[j * level.width + i];
    let (fx, fy) = (x - i as f32, y - j as f32);
    at(i, j).lerp(at(i + 1, j), fx).lerp(at(i, j + 1).lerp(at(i + 1, j + 1), fx), fy)
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
    for object in &parts {
        let albedo = object.material.color(Property::base_color).map(|c| c as f32).into();
        paint(&object.mesh, albedo, center, half_width, &mut color);
    }
    let covered = color.iter().filter(|c| **c != Vec3::ZERO).count().max(1);
    let albedo = color.iter().sum::<Vec3>() / covered as f32;
    let all = parts.iter().map(|o| o.mesh.bounds()).reduce(|a, b| a.union(b))?;
    let extent = [Vec2::new(all.min.x, all.min.z), Vec2::new(all.max.x, all.max.z)];
    // A disc of the same area about the object stands for the rectangle.
    let size = (extent[1] - extent[0]).max(Vec2::ZERO);
    let reach = (size.x * size.y / PI).sqrt();
    let height = (bounds.center().y - y).max(0.0);
    let edge = if reach > 0.0 { height / height.hypot(reach) } else { 1.0 };
    Some(Floor { y, center, half_width, color, pavement: Pavement { albedo, edge }, extent })
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
