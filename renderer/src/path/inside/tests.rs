//! Connections against renders without them, and the density of their directions.

use super::super::sampler::mix;
use super::super::tests::{object, scene, sphere, window};
use super::super::{Film, render_pass};
use super::*;
use burnish_material::{Material, Property, Value};
use std::sync::Arc;

fn number(i: u32, k: u32) -> f32 {
    (mix(i.wrapping_mul(0x9e37_79b9) ^ mix(k + 1)) >> 8) as f32 / 16_777_216.0
}

#[test]
fn directions_inwards_follow_their_density() {
    let axis = V3::new(0.36f32, 0.48, -0.8);
    let score = |w: V3<f32>| (3.0 * w.dot(axis)).exp();
    for (z, alpha, eta) in [(0.9f32, 0.09f32, 1.4f32), (0.4, 0.3, 1.5), (0.06, 0.12, 1.33), (0.7, 0.2, 0.8)] {
        let lobes = Lobes { wo: V3::new((1.0 - z * z).sqrt(), 0.0, z), alpha, eta };
        let count = 400_000;
        let (mut sum, mut square, mut missing) = (0.0, 0.0, 0.0);
        for i in 0..count {
            let (w, pdf) = lobes.sample([0, 1, 2].map(|k| number(i, k)));
            let x = if pdf > 0.0 { f64::from(score(w) / pdf) } else { 0.0 };
            sum += x / f64::from(count);
            square += x * x / f64::from(count);
            missing += if pdf > 0.0 { 0.0 } else { 1.0 / f64::from(count) };
            assert!((pdf == 0.0 || (w.length_squared() - 1.0).abs() < 1e-4) && pdf >= 0.0 && pdf.is_finite());
        }
        // Integral of exp(3 cos) over the sphere; of what is lost to total reflection nothing is drawn.
        let known = 4.0 * PI * 3f64.sinh() / 3.0;
        let sigma = ((square - sum * sum) / f64::from(count)).sqrt();
        assert!((sum - known).abs() < 4.0 * sigma && sigma < 0.05 * known, "{z} {alpha} {eta}: {sum} {known} {sigma}");
        let inside = density_over_the_sphere(&lobes);
        assert!((inside + missing - 1.0).abs() < 0.02, "{z} {alpha} {eta}: {inside} {missing}");
    }
}

fn density_over_the_sphere(lobes: &Lobes<f32>) -> f64 {
    let n = 800;
    let mut sum = 0.0;
    for i in 0..n {
        for j in 0..2 * n {
            let z = (2.0 * (f64::from(i) + 0.5) / f64::from(n) - 1.0) as f32;
            let (sin, cos) = ((f64::from(j) + 0.5) / f64::from(n) * PI).sin_cos();
            let across = (1.0 - z * z).sqrt();
            sum += f64::from(lobes.density(V3::new(across * cos as f32, across * sin as f32, z)));
        }
    }
    sum * 4.0 * PI / f64::from(2 * n * n)
}

/// Pixels of a picture, and the sum over them of their variances over seeds.
fn pictures(prepared: &Prepared, seeds: u64) -> (Vec<f64>, f64) {
    let (size, mut means, mut variance) = (24, Vec::new(), 0.0);
    let mut sums = vec![[0.0f64; 2]; size * size];
    for seed in 0..seeds {
        let mut film = Film::new(size, size);
        render_pass(prepared, &mut film, 16, seed + 11, 2, &|| false).expect("not cancelled");
        let pixels = film.mean().iter().map(|p| f64::from(p[0] + p[1] + p[2])).collect::<Vec<_>>();
        means.push(pixels.iter().sum::<f64>());
        for (sum, x) in sums.iter_mut().zip(pixels) {
            *sum = [sum[0] + x, sum[1] + x * x];
        }
    }
    for [sum, square] in sums {
        variance += square / seeds as f64 - (sum / seeds as f64).powi(2);
    }
    (means, variance)
}

#[test]
fn connections_change_noise_only() {
    for (roughness, distance, more) in [(0.3, 0.08, 0.0), (0.5, 0.3, 0.0), (0.4, 0.02, 0.6)] {
        let mut wax = Material::named("wax");
        for (property, value) in [
            (Property::translucency, Value::Float(1.0)),
            (Property::roughness, Value::Float(roughness)),
            (Property::scatter, Value::Bool(true)),
            (Property::scatter_color, Value::Color([0.9, 0.7, 0.4])),
            (Property::scatter_distance, Value::Float(distance)),
            (Property::coat, Value::Float(more)),
        ] {
            wax.set(property, value);
        }
        let scene = scene(vec![object(sphere(1.0, 48), Arc::new(wax))], window());
        let mut prepared = Prepared::new(&scene, None);
        assert!(prepared.passage_of_object[0].is_some());
        let (connected, variance) = pictures(&prepared, 8);
        prepared.passage_of_object.fill(None);
        let (plain, plain_variance) = pictures(&prepared, 24);
        let mean = |x: &[f64]| x.iter().sum::<f64>() / x.len() as f64;
        let of_mean = |x: &[f64]| {
            let m = mean(x);
            (x.iter().map(|v| (v - m).powi(2)).sum::<f64>() / (x.len() * (x.len() - 1)) as f64).sqrt()
        };
        let sigma = of_mean(&connected).hypot(of_mean(&plain));
        let difference = mean(&connected) - mean(&plain);
        let what = format!("{roughness} {distance} {more}: {difference} of {}, sigma {sigma}", mean(&plain));
        assert!(difference.abs() < 4.0 * sigma && sigma < 0.012 * mean(&plain), "{what}");
        assert!(variance < 0.5 * plain_variance, "{what}: variance {variance} {plain_variance}");
    }
}
