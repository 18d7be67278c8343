//! Normals of bumps, normal maps and coats.

use super::super::Prepared;
use super::super::detail::Footprint;
use super::super::frame::{point, span};
use super::super::sampler::MAX_LANES;
use super::super::tests::scene;
use super::{base_plane, coarse, image, matt, plane, stacked, textured, white_room};
use crate::bvh::Ray;
use crate::scene::Object;
use crate::vector::V3;
use burnish_assets::Image;
use burnish_material::{Property, Value};
use glam::{Mat2, Vec2, Vec3};
use std::f32::consts::TAU;
use std::sync::Arc;

#[test]
fn slopes_are_those_of_the_height_field() {
    let (size, scale) = (512usize, 0.05f32);
    // height = sin(2 pi (2 u + 3 v)) / 2 + 1/2 at texel centres.
    let phase = |u: f32, v: f32| TAU * (2.0 * u + 3.0 * v);
    let height = image(size, 256, |x, y| [0.5 + 0.5 * phase((x as f32 + 0.5) / size as f32, (y as f32 + 0.5) / 256.0).sin(); 3]);
    let rotated = Mat2::from_angle(0.6) * Mat2::from_diagonal(Vec2::new(0.5, 0.3));
    let sheared = Mat2::from_cols(Vec2::new(0.4, 0.1), Vec2::new(0.35, 0.5));
    let mirrored = Mat2::from_diagonal(Vec2::new(-0.5, 0.5));
    for uv in [Mat2::IDENTITY * 0.5, Mat2::from_diagonal(Vec2::new(0.7, 0.2)), rotated, sheared, mirrored] {
        let object = textured(
            coarse(plane(uv, Vec2::splat(0.1), 1)),
            &matt(&[(Property::height_scale, Value::Float(f64::from(scale)))]),
            &[(Property::height, height.clone())],
        );
        let mut bumped = scene(vec![object], white_room());
        // Beyond the cap: bumps only. The same slopes must come out of the displaced plane.
        for is_displaced in [true, false] {
            if !is_displaced {
                bumped.objects[0].mesh = Arc::new(stacked(plane(uv, Vec2::splat(0.1), 1), 60));
            }
            let prepared = Prepared::new(&bumped, None);
            let surface = &prepared.surfaces[0];
            assert_eq!(surface.bumps.as_ref().map(|b| b.is_displaced), Some(is_displaced));
            for (x, z) in [(0.13f32, -0.4f32), (-0.71, 0.22), (0.05, 0.63), (0.5, 0.5)] {
                let at = prepared.geometry.normalized(Vec3::new(x, 1.0, z));
                let hit = prepared.geometry.bvh.closest(&Ray::new(at, Vec3::NEG_Y));
                let hits = [hit; MAX_LANES];
                let p = point::<f32>(&prepared.geometry, &hits, true, true);
                let footprint = Footprint { span: span(&prepared.geometry, &hits), uv: 0.0 };
                let inputs = surface.inputs.convert(|x| x as f32);
                let n = surface.shading(&p, &inputs, Some(&footprint), V3::new(0.0, 1.0, 0.0), true).frame.n;
                let c = uv * Vec2::new(x, z) + 0.1;
                let by_phase = 0.5 * scale * phase(c.x, c.y).cos() * TAU;
                let gradient = uv.transpose() * Vec2::new(2.0, 3.0) * by_phase;
                let (sx, sz) = (-n.x / n.y, -n.z / n.y);
                let error = (Vec2::new(sx, sz) - gradient).length();
                assert!(error < 0.02 * (gradient.length() + 0.1), "{uv}: {sx} {sz} instead of {gradient}");
            }
        }
    }
}

/// Normals of base and coat at a hit from above, in the frame x, -z, y of the plane.
fn normals(object: Object) -> [Vec3; 2] {
    let prepared = Prepared::new(&scene(vec![object], white_room()), None);
    let surface = &prepared.surfaces[0];
    let at = prepared.geometry.normalized(Vec3::new(0.21, 1.0, 0.13));
    let hits = [prepared.geometry.bvh.closest(&Ray::new(at, Vec3::NEG_Y)); MAX_LANES];
    let p = point::<f32>(&prepared.geometry, &hits, surface.needs_tangent(), surface.reads_images());
    let footprint = surface.reads_images().then(|| Footprint { span: span(&prepared.geometry, &hits), uv: 0.0f32 });
    let uniform = surface.inputs.convert(|x| x as f32);
    let inputs = surface.textured(&uniform, &p.uv, 0.0).unwrap_or(uniform);
    let shading = surface.shading(&p, &inputs, footprint.as_ref(), V3::new(0.0, 1.0, 0.0), true);
    [shading.frame.n, shading.coat_normal].map(|n| Vec3::new(n.x, -n.z, n.y))
}

/// Height that grows by u: a slope of 0.4 where the map is repeated once over the plane of 2 units, 1 of them per unit of height.
fn ramp() -> Arc<Image> {
    image(256, 4, |x, _| [x as f32 / 256.0; 3])
}

#[test]
fn normal_and_height_combine_as_asked() {
    let map = Vec3::new(0.1, 0.5, 0.8).normalize();
    let stored = image(1, 1, |_, _| (map * 0.5 + 0.5).to_array());
    let slope = Vec3::new(-0.4, 0.0, 1.0).normalize();
    for is_displaced in [false, true] {
        let make = |combine: bool, has_map: bool, has_height: bool| {
            let values =
                [(Property::height_scale, Value::Float(0.8)), (Property::combine_normal_and_height, Value::Bool(combine))];
            let mut maps = Vec::new();
            if has_map {
                maps.push((Property::normal, stored.clone()));
            }
            if has_height {
                maps.push((Property::height, ramp()));
            }
            normals(textured(base_plane(is_displaced), &matt(&values), &maps))[0]
        };
        let near = |a: Vec3, b: Vec3, what: &str| assert!(a.distance(b) < 2e-3, "{what}, displaced {is_displaced}: {a} {b}");
        near(make(false, false, true), slope, "height alone");
        near(make(true, false, true), slope, "height alone");
        near(make(false, true, true), map, "the map holds the height");
        near(make(false, true, false), map, "map alone");
        near(make(true, true, false), map, "map alone");
        // Slopes add up as bumps; displaced, the map stands in the frame of the slope.
        let sum = Vec3::new(map.x * slope.z + slope.x * map.z, map.y * slope.z, map.z * slope.z).normalize();
        let tangent = Vec3::new(slope.z, 0.0, -slope.x);
        let stacked = tangent * map.x + Vec3::Y * map.y + slope * map.z;
        near(make(true, true, true), if is_displaced { stacked } else { sum }, "both");
    }
}

#[test]
fn the_coat_has_its_own_normal() {
    let store = |n: Vec3| image(1, 1, move |_, _| (n.normalize() * 0.5 + 0.5).to_array());
    let (base, coat) = (Vec3::new(0.5, 0.1, 0.8), Vec3::new(-0.3, 0.4, 0.9));
    let make = |maps: &[(Property, Arc<Image>)], values: &[(Property, Value)]| {
        normals(textured(base_plane(true), &matt(&[&[(Property::coat, Value::Float(1.0))], values].concat()), maps))
    };
    let near = |a: Vec3, b: Vec3| assert!(a.distance(b.normalize()) < 1e-5, "{a} {b}");
    let [n, c] = make(&[(Property::normal, store(base))], &[]);
    near(n, base);
    near(c, Vec3::Z);
    let [n, c] = make(&[(Property::normal, store(base)), (Property::coat_normal, store(coat))], &[]);
    near(n, base);
    near(c, coat);
    let [n, c] = make(&[(Property::coat_normal, store(coat))], &[]);
    near(n, Vec3::Z);
    near(c, coat);
    let [_, c] = make(&[(Property::coat_normal, store(coat))], &[(Property::coat_normal_scale, Value::Float(2.0))]);
    near(c, Vec3::new(2.0 * coat.x, 2.0 * coat.y, coat.z));
    // Height moves the surface that the coat lies on; the base's map does not.
    let height = [(Property::normal, store(base)), (Property::height, ramp())];
    let [n, c] = make(&height, &[(Property::height_scale, Value::Float(0.8))]);
    near(n, base);
    assert!(c.distance(Vec3::new(-0.4, 0.0, 1.0).normalize()) < 2e-3, "{c}");
}
