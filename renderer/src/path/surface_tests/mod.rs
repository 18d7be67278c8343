//! Renders and hits of surfaces with images.

mod displacement;
mod footprints;
mod normals;

use super::geometry::{Geometry, Vertex};
use super::mip::Sources;
use super::tests::{environment, object, scene};
use crate::scene::{EnvironmentLight, Object, TextureSet};
use burnish_assets::{Image, Mesh};
use burnish_material::{Material, Property, TextureRef, Value};
use glam::{Mat2, Vec2, Vec3, Vec4};
use std::f32::consts::TAU;
use std::sync::Arc;

fn image(width: usize, height: usize, f: impl Fn(usize, usize) -> [f32; 3]) -> Arc<Image> {
    let texel = |i: usize| {
        let [r, g, b] = f(i % width, i / width);
        [r, g, b, 1.0]
    };
    Arc::new(Image { width, height, texels: (0..width * height).map(texel).collect(), is_eight_bit: false })
}

/// A square from -1 to 1 in the plane y = 0, seen from above; `uv` maps (x, z) to texture coordinates.
fn plane(uv: Mat2, shift: Vec2, parts: usize) -> Mesh {
    let mut mesh = Mesh::default();
    let side = parts + 1;
    for j in 0..side {
        for i in 0..side {
            let p = Vec2::new(i as f32, j as f32) * (2.0 / parts as f32) - 1.0;
            mesh.positions.push(Vec3::new(p.x, 0.0, p.y));
            mesh.normals.push(Vec3::Y);
            mesh.uvs.push(uv * p + shift);
        }
    }
    for j in 0..parts {
        for i in 0..parts {
            let a = (j * side + i) as u32;
            let (b, c, d) = (a + 1, a + side as u32, a + side as u32 + 1);
            mesh.triangles.push([a, c, d]);
            mesh.triangles.push([a, d, b]);
        }
    }
    mesh.complete().0
}

/// A mesh with a material whose properties have values and images.
fn textured(mesh: Mesh, values: &[(Property, Value)], maps: &[(Property, Arc<Image>)]) -> Object {
    let mut material = Material::named("test");
    for (property, value) in values {
        material.set(*property, *value);
    }
    let mut textures = TextureSet::new();
    for (property, image) in maps {
        material.slot_mut(*property).texture = Some(TextureRef::new(property.def().name));
        textures.insert(property.def().name.to_owned(), image.clone());
    }
    Object { textures: Arc::new(textures), ..object(mesh, Arc::new(material)) }
}

const MATT: [(Property, Value); 2] = [(Property::roughness, Value::Float(1.0)), (Property::specular_level, Value::Float(0.0))];

fn matt(more: &[(Property, Value)]) -> Vec<(Property, Value)> {
    MATT.iter().chain(more).copied().collect()
}

fn white_room() -> EnvironmentLight {
    environment(|_, _| 1.0)
}

fn geometry(object: &Object) -> Geometry {
    Geometry::new(&scene(vec![object.clone()], white_room()), &mut Sources::default())
}

fn place(v: &Vertex) -> Vec3 {
    Vec3::new(v[0], v[1], v[2])
}

fn checker(size: usize) -> Arc<Image> {
    image(size, size, |x, y| [if (x + y) % 2 == 0 { 0.9 } else { 0.1 }; 3])
}

/// A height map without symmetry.
fn hills() -> Arc<Image> {
    image(64, 32, |x, y| {
        let (u, v) = (x as f32 / 64.0, y as f32 / 32.0);
        [0.5 + 0.3 * (TAU * (3.0 * u + v)).sin() + 0.2 * (TAU * (5.0 * v - 2.0 * u)).cos(); 3]
    })
}

/// Copies of a mesh close below each other.
fn stacked(mesh: Mesh, copies: u32) -> Mesh {
    let mut all = Mesh::default();
    for k in 0..copies {
        let first = all.positions.len() as u32;
        all.positions.extend(mesh.positions.iter().map(|p| *p - Vec3::Y * (1e-3 * k as f32)));
        all.normals.extend(&mesh.normals);
        all.tangents.extend(&mesh.tangents);
        all.uvs.extend(&mesh.uvs);
        all.triangles.extend(mesh.triangles.iter().map(|t| t.map(|i| i + first)));
    }
    all
}

/// A plane on which the image lies once, or many of them, which are too much to be displaced.
fn base_plane(is_displaced: bool) -> Mesh {
    stacked(plane(Mat2::IDENTITY * 0.5, Vec2::splat(0.5), 1), if is_displaced { 1 } else { 60 })
}

/// The mesh and a speck far away: bounds become large, and displaced meshes coarse.
fn coarse(mut mesh: Mesh) -> Mesh {
    let first = mesh.positions.len() as u32;
    for p in [Vec3::ZERO, Vec3::Y * 1e-3, Vec3::Z * 1e-3] {
        mesh.positions.push(Vec3::X * 20.0 + p);
        mesh.normals.push(Vec3::X);
        mesh.tangents.push(Vec4::new(0.0, 0.0, -1.0, 1.0));
        if !mesh.uvs.is_empty() {
            mesh.uvs.push(mesh.uvs[0]);
        }
    }
    mesh.triangles.push([first, first + 1, first + 2]);
    mesh
}
