//! What the cases of the suite stand in: a ball and broken variants of it, lights, images.

use super::Case;
use crate::scene::{Camera, EnvironmentLight, Object, Scene, TextureSet};
use burnish_assets::{Environment, Image, Mesh};
use burnish_material::{Material, Property, TextureRef};
use glam::{Vec2, Vec3, Vec4};
use std::sync::Arc;

/// Bounces of a case: enough for light to go to and fro in glass.
const MAX_BOUNCES: u32 = 8;
/// Name of the one image of a textured case.
const IMAGE: &str = "image";

/// Things that many cases share.
pub(super) struct Stage {
    pub ball: Arc<Mesh>,
    pub light: EnvironmentLight,
}

impl Stage {
    pub(super) fn new() -> Self {
        let mut rows = vec![[0.2; 3]; 32 * 16];
        // A sun of one texel, which light sampling must find.
        rows[4 * 32 + 20] = [5e4, 4e4, 3e4];
        rows[12 * 32 + 3] = [0.0; 3];
        Self { ball: Arc::new(ball(24, 12)), light: light(32, rows) }
    }

    /// A material on the ball.
    pub(super) fn case(&self, name: impl Into<String>, material: Material) -> Case {
        self.case_on(name, material, Arc::default(), &self.ball)
    }

    /// A material with its images on a mesh.
    pub(super) fn case_on(
        &self,
        name: impl Into<String>,
        material: Material,
        textures: Arc<TextureSet>,
        mesh: &Arc<Mesh>,
    ) -> Case {
        let name = name.into();
        let object = Object { mesh: mesh.clone(), material: Arc::new(material), textures, is_document: true, length_scale: 1.0 };
        let bounds = mesh.bounds();
        let (center, radius) = (bounds.center(), bounds.radius());
        let camera = Camera::orbit(center, 25.0, 20.0, 3.0 * radius, 40.0);
        Case { name, scene: Scene { objects: vec![object], environment: self.light.clone(), camera, max_bounces: MAX_BOUNCES } }
    }
}

/// A map with so many columns.
pub(super) fn light(width: usize, texels: Vec<[f32; 3]>) -> EnvironmentLight {
    let map = Environment { name: "light".into(), width, height: texels.len() / width, texels };
    EnvironmentLight { map: Arc::new(map), rotation_deg: 0.0, scale: 1.0 }
}

/// The material with one image in the slot of a property.
pub(super) fn textured(mut material: Material, property: Property, texels: Vec<f32>) -> (Material, Arc<TextureSet>) {
    material.slot_mut(property).texture = Some(TextureRef::new(IMAGE));
    let width = 2.min(texels.len());
    // Colours differ by channel, so that one channel at an end meets others that are not.
    let texel = |(i, x): (usize, f32)| [x, if i % 2 == 0 { x } else { 0.5 }, x, 1.0];
    let texels: Vec<[f32; 4]> = texels.into_iter().enumerate().map(texel).collect();
    let image = Image { width, height: texels.len() / width, texels, is_eight_bit: false };
    (material, Arc::new([(IMAGE.to_owned(), Arc::new(image))].into()))
}

/// A ball of radius 1 with normals, tangents and uvs. Triangles at the poles have no area, as in many files.
pub(super) fn ball(columns: usize, rows: usize) -> Mesh {
    let mut mesh = Mesh { name: "ball".into(), ..Mesh::default() };
    for j in 0..=rows {
        for i in 0..=columns {
            let (u, v) = (i as f32 / columns as f32, j as f32 / rows as f32);
            let (sp, cp) = (std::f32::consts::TAU * u).sin_cos();
            let (st, ct) = (std::f32::consts::PI * v).sin_cos();
            let n = Vec3::new(st * sp, ct, st * cp);
            mesh.positions.push(n);
            mesh.normals.push(n);
            mesh.tangents.push(Vec4::new(cp, 0.0, -sp, 1.0));
            mesh.uvs.push(Vec2::new(u, v));
        }
    }
    let at = |i: usize, j: usize| (j * (columns + 1) + i) as u32;
    for j in 0..rows {
        for i in 0..columns {
            mesh.triangles.push([at(i, j), at(i, j + 1), at(i + 1, j + 1)]);
            mesh.triangles.push([at(i, j), at(i + 1, j + 1), at(i + 1, j)]);
        }
    }
    mesh
}

/// The ball, changed.
fn changed(edit: impl FnOnce(&mut Mesh)) -> Arc<Mesh> {
    let mut mesh = ball(24, 12);
    edit(&mut mesh);
    Arc::new(mesh)
}

/// Meshes that no loader would pass on, and sizes at the ends of what is modelled.
pub(super) fn meshes() -> Vec<(&'static str, Arc<Mesh>)> {
    let scaled = |s: f32| changed(|m| m.positions.iter_mut().for_each(|p| *p *= s));
    vec![
        (
            "zero-area triangles",
            changed(|m| {
                let extra: Vec<[u32; 3]> = m.triangles.iter().step_by(3).map(|t| [t[0], t[1], t[1]]).collect();
                m.triangles.extend(extra);
            }),
        ),
        ("all uvs zero", changed(|m| m.uvs.iter_mut().for_each(|uv| *uv = Vec2::ZERO))),
        ("uvs not finite", changed(|m| m.uvs.iter_mut().step_by(2).for_each(|uv| *uv = Vec2::new(f32::NAN, f32::INFINITY)))),
        ("uvs of a million tiles", changed(|m| m.uvs.iter_mut().for_each(|uv| *uv *= 1e6))),
        ("flipped normals", changed(|m| m.normals.iter_mut().for_each(|n| *n = -*n))),
        (
            "normals along the surface",
            changed(|m| {
                for (n, t) in m.normals.iter_mut().zip(&m.tangents) {
                    *n = Vec3::new(t.x, t.y, t.z);
                }
            }),
        ),
        ("no normals", changed(|m| m.normals.clear())),
        ("no tangents", changed(|m| m.tangents.clear())),
        (
            "zero normals and tangents",
            changed(|m| {
                m.normals.iter_mut().for_each(|n| *n = Vec3::ZERO);
                m.tangents.iter_mut().for_each(|t| *t = Vec4::ZERO);
            }),
        ),
        ("normals opposite at the ends of an edge", changed(|m| m.normals.iter_mut().step_by(2).for_each(|n| *n = -*n))),
        ("a hole", changed(|m| m.triangles.truncate(m.triangles.len() / 2))),
        ("scale 1e-4", scaled(1e-4)),
        ("scale 1e4", scaled(1e4)),
        ("far from the origin", changed(|m| m.positions.iter_mut().for_each(|p| *p += Vec3::splat(1e4)))),
    ]
}

/// Lights at the ends of what files hold.
pub(super) fn lights() -> Vec<(&'static str, EnvironmentLight)> {
    let one_lit = |x: f32| {
        let mut texels = vec![[0.0; 3]; 64 * 32];
        texels[20 * 64 + 17] = [x; 3];
        light(64, texels)
    };
    let mut beyond = light(4, vec![[10.0, 5.0, 30.0]; 8]);
    beyond.scale = 1e38;
    let noise = |i: u32| {
        let x = i.wrapping_mul(2_654_435_761) >> 16;
        [(x as f32 / 65536.0).powi(8) * 100.0; 3]
    };
    vec![
        ("black", light(2, vec![[0.0; 3]; 2])),
        ("one texel in all", light(1, vec![[1.0; 3]])),
        ("one lit texel", one_lit(1.0)),
        ("one lit texel of 1e6", one_lit(1e6)),
        ("one lit texel of 1e30", one_lit(1e30)),
        ("all texels 1e6", light(32, vec![[1e6; 3]; 32 * 16])),
        ("a million texels", light(1024, (0..1024 * 1024).map(noise).collect())),
        ("times 1e38", beyond),
        ("blue alone", light(32, (0..32 * 16).map(|i| [0.0, 0.0, if i % 7 == 0 { 3.0 } else { 0.1 }]).collect())),
    ]
}
