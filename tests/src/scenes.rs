//! Small scenes whose radiance is known.

use burnish_assets::{Environment, Mesh};
use burnish_material::Material;
use burnish_renderer::path::{Settings, StopRules, render};
use burnish_renderer::{Camera, EnvironmentLight, Object, Scene};
use glam::{Vec2, Vec3, Vec4};
use std::sync::Arc;

/// A map of one row per entry of `rows`, zenith first, the same all around.
pub fn environment(rows: &[f32]) -> EnvironmentLight {
    let width = rows.len() * 2;
    let texels = rows.iter().flat_map(|v| std::iter::repeat_n([*v; 3], width)).collect();
    let map = Environment { name: "test".into(), width, height: rows.len(), texels };
    EnvironmentLight { map: Arc::new(map), rotation_deg: 0.0, scale: 1.0 }
}

/// A square of 200 units in the plane y = 0, facing up; tangent +x, bitangent -z.
pub fn square() -> Mesh {
    let corner = |x: f32, z: f32| Vec3::new(100.0 * x, 0.0, 100.0 * z);
    Mesh {
        name: "square".into(),
        positions: vec![corner(-1.0, 1.0), corner(1.0, 1.0), corner(1.0, -1.0), corner(-1.0, -1.0)],
        normals: vec![Vec3::Y; 4],
        tangents: vec![Vec4::new(1.0, 0.0, 0.0, 1.0); 4],
        uvs: vec![Vec2::new(0.0, 1.0), Vec2::new(1.0, 1.0), Vec2::new(1.0, 0.0), Vec2::new(0.0, 0.0)],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
    }
}

/// A square seen from afar under cosine `mu` (negative: from below) and azimuth `phi`: every pixel has the same `wo`.
pub fn flat(material: Material, environment: EnvironmentLight, mu: f64, phi: f64) -> Scene {
    let s = (1.0 - mu * mu).sqrt();
    let wo = Vec3::new((s * phi.cos()) as f32, mu as f32, -(s * phi.sin()) as f32);
    let object = Object {
        mesh: Arc::new(square()),
        material: Arc::new(material),
        textures: Arc::default(),
        is_document: true,
        length_scale: 1.0,
    };
    let camera = Camera { origin: wo * 20.0, target: Vec3::ZERO, up: Vec3::new(0.3, 0.5, 0.8), fov_deg: 0.1 };
    Scene { objects: vec![object], environment, camera, max_bounces: 16 }
}

/// Mean radiance of a rendering over all pixels.
pub fn mean(film: &burnish_renderer::path::Film) -> [f64; 3] {
    let pixels = film.mean();
    let n = pixels.len() as f64;
    [0, 1, 2].map(|c| pixels.iter().map(|p| f64::from(p[c])).sum::<f64>() / n)
}

/// Linear radiance of the final view, `side` pixels along each side, after this many samples per pixel.
pub fn final_picture(scene: &Scene, side: usize, spp: u32) -> Vec<[f32; 3]> {
    let settings = Settings {
        width: side,
        height: side,
        seed: 7,
        threads: 2,
        stop: StopRules { spp: Some(spp), seconds: None, relmse: None },
        is_adaptive: false,
    };
    render(scene, &settings, &mut |_| true).film.mean()
}
