//! Do samples, values and densities of the whole BSDF belong together, at every width and precision?

#![allow(clippy::needless_range_loop, reason = "a channel indexes several arrays at once")]

use burnish_material::{LobeSet, Material};
use burnish_renderer::bsdf::{Bsdf, Optics, interpret};
use burnish_renderer::lanes::{Lanes, Mask, Wide};
use burnish_renderer::vector::Rgb;
use burnish_tests::materials::cases;
use burnish_tests::quadrature::{direction, integrate};

const ROUGHNESSES: [f64; 3] = [0.1, 0.4, 1.0];
/// Cosines of the viewer: steep, oblique, grazing; from outside and, for what transmits, from inside.
const COSINES: [f64; 6] = [1.0, 0.6, 0.15, -0.9, -0.7, -0.2];

fn optics<L: Lanes>(material: &Material) -> (Optics<L>, LobeSet) {
    let lobes = LobeSet::of(material);
    (interpret(&material.inputs().convert(L::of), lobes, L::one()), lobes)
}

/// Every case at every roughness and cosine.
fn for_each(mut check: impl FnMut(&str, &Material, f64)) {
    for roughness in ROUGHNESSES {
        for (name, material) in cases(roughness) {
            for mu in COSINES {
                check(&format!("{name}, roughness {roughness}, cosine {mu}"), &material, mu);
            }
        }
    }
}

fn number(i: usize, dimension: u32) -> f64 {
    let x = (i as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15).wrapping_add(u64::from(dimension).wrapping_mul(0xD1B5_4A32_D192_ED03));
    let x = (x ^ (x >> 31)).wrapping_mul(0x94D0_49BB_1331_11EB);
    let x = (x ^ (x >> 29)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    (x >> 40) as f64 / (1u64 << 24) as f64
}

fn numbers<L: Lanes>(i: usize) -> [L; 4] {
    std::array::from_fn(|d| L::of(number(i, d as u32)))
}

#[test]
fn sample_weights_average_to_the_integral_of_eval() {
    for_each(|name, material, mu| {
        let (optics, lobes) = optics::<f64>(material);
        let wo = direction(mu, 0.7);
        let bsdf = Bsdf::prepare(&optics, lobes, wo, Rgb::white());
        let integral = integrate(&bsdf, wo, &optics);
        assert!((0.0..1.003).contains(&integral.pdf), "{name}: density integrates to {}", integral.pdf);
        let n = 40_000;
        let (mut sum, mut square, mut valid) = ([0.0; 3], [0.0; 3], 0.0);
        for i in 0..n {
            let s = bsdf.sample(numbers(i));
            if s.is_valid {
                valid += if s.is_delta { 0.0 } else { 1.0 };
                for c in 0..3 {
                    sum[c] += if s.is_delta { 0.0 } else { s.weight.0[c] };
                    square[c] += if s.is_delta { 0.0 } else { s.weight.0[c].powi(2) };
                }
            }
        }
        let n = f64::from(n as u32);
        for c in 0..3 {
            let mean = sum[c] / n;
            let sigma = ((square[c] / n - mean * mean).max(0.0) / n).sqrt();
            let expected = integral.reflected[c] + integral.transmitted[c];
            let limit = 4.5 * sigma + 2e-3 * expected + 1e-4;
            assert!((mean - expected).abs() < limit, "{name}, channel {c}: samples {mean}, integral {expected}, limit {limit}");
            assert!(expected < 1.002, "{name}, channel {c}: gains energy, {expected}");
        }
        let share = valid / n;
        assert!((share - integral.pdf).abs() < 0.012, "{name}: {share} of the samples are valid, density says {}", integral.pdf);
    });
}

#[test]
fn weight_is_eval_over_pdf() {
    for_each(|name, material, mu| {
        let (optics, lobes) = optics::<f64>(material);
        let bsdf = Bsdf::prepare(&optics, lobes, direction(mu, 2.0), Rgb([0.8, 0.5, 1.0]));
        for i in 0..2000 {
            let s = bsdf.sample(numbers(i));
            if !s.is_valid || s.is_delta {
                continue;
            }
            let (value, pdf) = bsdf.eval(s.wi);
            assert!((pdf / s.pdf - 1.0).abs() < 1e-4, "{name}, sample {i}: pdf {pdf} and {}", s.pdf);
            for c in 0..3 {
                let error = (value.0[c] / pdf - s.weight.0[c]).abs();
                assert!(
                    error < 1e-4 * s.weight.max_channel() + 1e-9,
                    "{name}, sample {i}: {} and {}",
                    value.0[c] / pdf,
                    s.weight.0[c]
                );
            }
        }
    });
}

#[test]
fn wide_lanes_give_the_bits_of_one_lane() {
    for_each(|name, material, mu| {
        let (one, lobes) = optics::<f32>(material);
        let (wide, _) = optics::<Wide<16>>(material);
        let b1 = Bsdf::prepare(&one, lobes, direction(mu, 1.0), Rgb::white());
        let b16 = Bsdf::prepare(&wide, lobes, direction(mu, 1.0), Rgb::white());
        let u: [Wide<16>; 4] = std::array::from_fn(|d| Wide::from_fn(|lane| number(lane, d as u32) as f32));
        let s16 = b16.sample(u);
        for lane in 0..16 {
            let s1 = b1.sample(u.map(|u| u.lane(lane)));
            assert_eq!(s1.is_valid, s16.is_valid.lane(lane), "{name}, lane {lane}");
            if s1.is_valid {
                assert_eq!(s1.weight.0.map(f32::to_bits), s16.weight.0.map(|w| w.lane(lane).to_bits()), "{name}, lane {lane}");
                assert_eq!(s1.wi.z.to_bits(), s16.wi.z.lane(lane).to_bits(), "{name}, lane {lane}");
            }
        }
    });
}

#[test]
fn single_precision_follows_double_precision() {
    for_each(|name, material, mu| {
        let (single, lobes) = optics::<f32>(material);
        let (double, _) = optics::<f64>(material);
        let b1 = Bsdf::prepare(&single, lobes, direction(mu, 0.3), Rgb::white());
        let b2 = Bsdf::prepare(&double, lobes, direction(mu, 0.3), Rgb::white());
        for i in 0..500 {
            let wi = direction::<f64>(2.0 * number(i, 7) - 1.0, 6.3 * number(i, 8));
            let (v2, p2) = b2.eval(wi);
            let (v1, p1) = b1.eval(burnish_renderer::vector::V3::new(wi.x as f32, wi.y as f32, wi.z as f32));
            // Nearly matched media divide a difference of 1e-3: seven digits leave four there.
            let limit = if name.contains("nearly matched") { 3e-2 } else { 1e-3 };
            assert!((f64::from(p1) - p2).abs() <= limit * p2 + 1e-6, "{name}, direction {i}: pdf {p1} and {p2}");
            for c in 0..3 {
                assert!(
                    (f64::from(v1.0[c]) - v2.0[c]).abs() <= limit * v2.0[c] + 1e-6,
                    "{name}, direction {i}: {} and {}",
                    v1.0[c],
                    v2.0[c]
                );
            }
        }
    });
}
