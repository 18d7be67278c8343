//! The environment as a light: densities, directions and radiances against integrals and the scene itself.

use super::*;
use crate::path::sampler::mix;
use burnish_assets::Environment;
use glam::Vec3;

fn map(width: usize, height: usize, f: impl Fn(f32, f32) -> f32) -> Arc<Environment> {
    let texels = (0..width * height)
        .map(|i| [f(((i % width) as f32 + 0.5) / width as f32, ((i / width) as f32 + 0.5) / height as f32); 3])
        .collect();
    Arc::new(Environment { name: "test".to_owned(), width, height, texels })
}

fn light(map: &Arc<Environment>, rotation_deg: f32) -> Light {
    let tables = Arc::new(LightTables::new(map));
    Light::new(&EnvironmentLight { map: map.clone(), rotation_deg, scale: 1.0 }, tables)
}

fn maps() -> Vec<Arc<Environment>> {
    vec![
        map(64, 32, |u, v| if (u - 0.3).abs() < 0.02 && (v - 0.2).abs() < 0.03 { 500.0 } else { 0.5 + v }),
        map(1024, 512, |u, v| 1.0 + (u * 20.0).sin() * (v * 9.0).cos()),
        map(2048, 1024, |u, v| if (u - 0.7).abs() < 0.001 && (v - 0.5).abs() < 0.001 { 6000.0 } else { 0.1 }),
    ]
}

#[test]
fn density_integrates_to_one() {
    for map in maps() {
        let light = light(&map, 30.0);
        // One point per cell is exact: density times sine is constant in a cell.
        let (rows, columns) = (512usize, 1024usize);
        let mut sum = 0.0;
        for j in 0..rows {
            let theta = (j as f64 + 0.5) / rows as f64 * PI;
            for i in 0..columns {
                let phi = (i as f64 + 0.5) / columns as f64 * TAU;
                let d = V3::new((theta.sin() * phi.sin()) as f32, theta.cos() as f32, (-theta.sin() * phi.cos()) as f32);
                sum += f64::from(light.eval(d).1) * theta.sin();
            }
        }
        let integral = sum * 2.0 * PI * PI / (rows * columns) as f64;
        assert!((integral - 1.0).abs() < 1e-3, "{}x{}: {integral}", map.width, map.height);
    }
}

#[test]
fn drawn_directions_follow_the_density() {
    const N: u32 = 200_000;
    for map in maps() {
        let light = light(&map, 45.0);
        let peak = map.texels.iter().fold(0.0f32, |m, t| m.max(t[0]));
        let (rows, columns) = (16usize, 32usize);
        let mut counts = vec![0.0f64; rows * columns];
        let mut reciprocal = 0.0;
        for i in 0..N {
            let (a, b) = (mix(2 * i + 1), mix(2 * i + 2));
            let s = light.sample((a >> 8) as f32 / 16_777_216.0, (b >> 8) as f32 / 16_777_216.0);
            let d = Vec3::new(s.direction.x, s.direction.y, s.direction.z);
            assert!((d.length() - 1.0).abs() < 1e-5);
            let (radiance, pdf) = light.eval(s.direction);
            // Directions are rounded, so a few land in the next cell.
            reciprocal += f64::from(u8::from((pdf / s.pdf - 1.0).abs() > 1e-2));
            assert!(s.pdf > 0.0);
            assert!((radiance.0[0] - s.radiance.0[0]).abs() <= 0.05 * s.radiance.0[0] + 2e-3 * peak);
            let uv = Environment::uv(d);
            let bin =
                ((uv.y * rows as f32) as usize).min(rows - 1) * columns + ((uv.x * columns as f32) as usize).min(columns - 1);
            counts[bin] += 1.0;
        }
        assert!(reciprocal / f64::from(N) < 5e-3, "{reciprocal}");
        let fine = 32usize;
        let (mut chi2, mut freedom) = (0.0, 0.0);
        for (bin, count) in counts.iter().enumerate() {
            let mut expected = 0.0;
            for j in 0..fine {
                let theta = ((bin / columns * fine + j) as f64 + 0.5) / (rows * fine) as f64 * PI;
                for i in 0..fine {
                    let phi = ((bin % columns * fine + i) as f64 + 0.5) / (columns * fine) as f64 * TAU;
                    let d = V3::new((theta.sin() * phi.sin()) as f32, theta.cos() as f32, (-theta.sin() * phi.cos()) as f32);
                    expected += f64::from(light.eval(d).1) * theta.sin();
                }
            }
            expected *= 2.0 * PI * PI / (rows * columns * fine * fine) as f64 * f64::from(N);
            if expected > 10.0 {
                chi2 += (count - expected).powi(2) / expected;
                freedom += 1.0;
            }
        }
        if freedom > 1.0 {
            // Four standard deviations, and some room for rounding at the borders of bright cells.
            assert!(chi2 < freedom + 4.0 * (2.0 * freedom).sqrt() + 10.0, "{chi2} for {freedom} bins");
        }
    }
}

#[test]
fn a_constant_map_is_not_sampled() {
    assert!(!light(&map(64, 32, |_, _| 0.7), 0.0).is_sampled());
    assert!(!light(&map(64, 32, |_, _| 0.0), 0.0).is_sampled());
}

#[test]
fn radiance_is_that_of_the_scene() {
    let map = map(128, 64, |u, v| u + 3.0 * v);
    let scene = EnvironmentLight { map: map.clone(), rotation_deg: 40.0, scale: 1.0 };
    let light = light(&map, 40.0);
    for i in 0..2000u32 {
        let z = 1.0 - 2.0 * (i as f32 + 0.5) / 2000.0;
        let (s, c) = (i as f32 * 2.4).sin_cos();
        let d = Vec3::new(c * (1.0 - z * z).sqrt(), z, s * (1.0 - z * z).sqrt());
        let expected = scene.radiance(d);
        let got = Vec3::from(light.eval(V3::new(d.x, d.y, d.z)).0.0);
        assert!(got.distance(expected) < 2e-3, "{d}: {got} {expected}");
    }
}

#[test]
fn angles_agree_with_the_library() {
    for i in 0..10_000 {
        let turn = f64::from(i) / 10_000.0;
        let (s, c) = sin_cos_turn(turn as f32);
        let (es, ec) = (f64::from(turn as f32) * TAU).sin_cos();
        assert!((f64::from(s) - es).abs() < 5e-7 && (f64::from(c) - ec).abs() < 5e-7, "{turn}: {s} {es} {c} {ec}");
        let angle = f64::from(atan2(es as f32, ec as f32));
        assert!((angle - f64::from(es as f32).atan2(f64::from(ec as f32))).abs() < 6e-7, "{turn}");
    }
    assert_eq!([atan2(0.0f32, 0.0), atan2(0.0f32, 1.0)], [0.0, 0.0]);
}

/// Normals on the tables' octahedron, between them, and in all octants.
fn normals() -> Vec<Vec3> {
    let mut normals = vec![Vec3::Y, Vec3::NEG_Y, Vec3::X, Vec3::NEG_Z, Vec3::new(0.5, 0.25, 0.25), Vec3::new(-0.25, -0.5, 0.25)];
    normals.extend((0..12u32).map(|i| {
        let z = 1.0 - 2.0 * (i as f32 + 0.5) / 12.0;
        let (s, c) = (i as f32 * 2.4).sin_cos();
        Vec3::new(c * (1.0 - z * z).sqrt(), z, s * (1.0 - z * z).sqrt())
    }));
    normals.into_iter().map(Vec3::normalize).collect()
}

fn facing(light: &Light, n: Vec3) -> Facing<f32> {
    light.facing(V3::new(n.x, n.y, n.z)).expect("there is light")
}

/// Unit directions of the middles of a grid over the sphere, and their solid angles.
fn sphere(rows: usize) -> impl Iterator<Item = (V3<f32>, f64)> {
    (0..rows * 2 * rows).map(move |i| {
        let theta = ((i / (2 * rows)) as f64 + 0.5) / rows as f64 * PI;
        let phi = ((i % (2 * rows)) as f64 + 0.5) / (2 * rows) as f64 * TAU;
        let d = V3::new((theta.sin() * phi.sin()) as f32, theta.cos() as f32, (-theta.sin() * phi.cos()) as f32);
        (d, theta.sin() * PI * PI / (rows * rows) as f64)
    })
}

#[test]
fn even_density_integrates_to_one() {
    for map in maps() {
        let light = light(&map, 0.0);
        for n in normals() {
            let facing = facing(&light, n);
            // One point per cell is exact: density times sine is constant in a cell.
            let total: f64 = sphere(light.tables.rows).map(|(d, omega)| f64::from(light.eval_facing(&facing, d).1) * omega).sum();
            assert!((total - 1.0).abs() < 2e-3, "{n}: {total}");
        }
    }
}

#[test]
fn even_directions_follow_their_density() {
    const N: u32 = 40_000;
    for (m, map) in maps().into_iter().enumerate() {
        let light = light(&map, 70.0);
        for n in normals() {
            let facing = facing(&light, n);
            // By thirds of a turn and slices of the height: shares of samples against shares of the density.
            let bin = |d: V3<f32>| {
                let slice = ((0.5 - 0.5 * d.y) * 4.0).clamp(0.0, 3.0) as usize;
                slice * 3 + ((d.x.atan2(d.z) / std::f32::consts::TAU + 0.5) * 3.0).clamp(0.0, 2.0) as usize
            };
            let mut drawn = [0.0; 12];
            for i in 0..N {
                let u = [1, 2, 3].map(|k| (mix(i ^ mix(k + 7 * m as u32)) >> 8) as f32 / 16_777_216.0);
                let sample = light.sample_facing(&facing, u);
                let (radiance, pdf) = light.eval_facing(&facing, sample.direction);
                // At the border of cells rounding may put the two into different ones.
                assert!(sample.pdf > 0.0 && radiance.0[0].is_finite(), "{n}: {}", sample.pdf);
                if (pdf / sample.pdf - 1.0).abs() < 1e-3 {
                    drawn[bin(sample.direction)] += 1.0 / f64::from(N);
                }
            }
            let mut expected = [0.0; 12];
            for (d, omega) in sphere(light.tables.rows) {
                expected[bin(d)] += f64::from(light.eval_facing(&facing, d).1) * omega;
            }
            for (drawn, expected) in drawn.iter().zip(expected) {
                assert!((drawn - expected).abs() < 0.02 + 0.02 * expected, "map {m}, {n}: {drawn} {expected}");
            }
        }
    }
}

/// Largest weight of any direction of a light, over the irradiance of a surface with a normal.
fn largest_weight(light: &Light, n: Vec3) -> f64 {
    let facing = facing(light, n);
    let lit = |d: V3<f32>, radiance: Rgb<f32>| f64::from(radiance.0[0] * (d.x * n.x + d.y * n.y + d.z * n.z).max(0.0));
    let irradiance: f64 = sphere(light.tables.map.height).map(|(d, omega)| lit(d, light.eval(d).0) * omega).sum();
    sphere(300).fold(0.0f64, |largest, (d, _)| {
        let (radiance, pdf) = light.eval_facing(&facing, d);
        let brought = lit(d, radiance);
        assert!(brought <= 0.0 || pdf > 0.0, "{n}: light without density");
        largest.max(brought / f64::from(pdf).max(1e-30) / irradiance)
    })
}

#[test]
fn even_directions_leave_no_light_out() {
    for map in maps() {
        let light = light(&map, 0.0);
        for n in normals() {
            let largest = largest_weight(&light, n);
            assert!(largest < 10.0, "{n}: a weight of {largest}");
        }
    }
}

#[test]
fn a_floor_without_shadows_is_without_noise() {
    let map = map(1024, 512, |u, v| 2.0 + (u * 6.3).sin() * (v * 3.0).cos());
    let light = light(&map, 20.0);
    let facing = facing(&light, Vec3::Y);
    let weights: Vec<f64> = (0..4096u32)
        .map(|i| {
            let u = [1, 2, 3].map(|k| (mix(i ^ mix(k)) >> 8) as f32 / 16_777_216.0);
            let sample = light.sample_facing(&facing, u);
            f64::from(sample.radiance.0[0] * sample.direction.y.max(0.0) / sample.pdf)
        })
        .collect();
    let mean = weights.iter().sum::<f64>() / weights.len() as f64;
    let variance = weights.iter().map(|w| (w / mean - 1.0).powi(2)).sum::<f64>() / weights.len() as f64;
    assert!(variance < 0.01, "{variance}");
}
