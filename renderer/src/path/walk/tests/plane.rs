//! Half-spaces and slabs against quadrature: Chandrasekhar's function, adding and doubling, discrete ordinates.

use super::*;
use crate::bsdf::fresnel::fresnel;

/// Deep enough to be a half-space.
const HALF_SPACE: Slab = Slab { depth: 1e7 };
/// Radius of the half-space for the rules that depend on one, with an extinction of order 1.
const RADIUS: f32 = 3e3;

/// `1 - albedo`, then the reflectance of a matched half-space (normal, diffuse incidence) and of one under a smooth boundary with
/// n = 1.4.
const KNOWN: [(f64, [f64; 4]); 9] = [
    (0.7, [0.057_214_4, 0.074_451_4, 0.052_206, 0.101_773]),
    (0.5, [0.115_225_9, 0.146_544_4, 0.080_079, 0.130_012]),
    (0.3, [0.208_68, 0.256_556_7, 0.131_822, 0.181_866]),
    (0.2, [0.285_254_5, 0.341_866_8, 0.180_823, 0.230_41]),
    (0.1, [0.414_947_5, 0.478_024_5, 0.278_374, 0.325_747]),
    (0.05, [0.535_541, 0.596_668_8, 0.386_903, 0.430_192]),
    (0.01, [0.752_720_7, 0.794_563_7, 0.631_367, 0.660_819]),
    (0.001, [0.912_845_3, 0.929_713_3, 0.857_893, 0.870_249]),
    (0.0001, [0.971_417_8, 0.977_187, 0.951_841, 0.956_154]),
];

fn known(absorbed: f64) -> [f64; 4] {
    KNOWN.iter().find(|(b, _)| *b == absorbed).expect("a tabulated albedo").1
}

/// What comes back out of the upper plane, matched.
fn reflected<B: Boundary>(
    boundary: &B,
    body: &Body,
    method: Method,
    is_diffuse: bool,
    light: [f32; 3],
    i: u32,
    stats: &mut WalkStats,
) -> [[f64; 3]; 2] {
    let direction = inwards(DVec3::Z, is_diffuse, 1, i);
    match walk(boundary, body, &entry(boundary, DVec3::ZERO, direction, light, 1, i), method, stats) {
        End::Surface { hit, throughput, .. } if hit.triangle == 0 => [throughput.map(f64::from), [0.0; 3]],
        End::Surface { throughput, .. } => [[0.0; 3], throughput.map(f64::from)],
        End::Absorbed => [[0.0; 3]; 2],
        End::Lost { .. } => panic!("nothing to get lost in"),
    }
}

/// Extinction, absorbed share and light of the channels.
type Case = ([f32; 3], [f64; 3], [f32; 3]);

fn check_half_space(cases: &[Case], precision: f64, tolerance: f64) {
    for (extinction, absorbed, light) in cases {
        let body = Body::new(&medium(*extinction, *absorbed), RADIUS);
        for (n, is_diffuse) in [false, true].into_iter().enumerate() {
            for method in METHODS {
                let mut stats = WalkStats::default();
                let watched = light.map(|x| x > 0.0);
                let sums = measure(precision, 8_000_000, watched, |i| {
                    reflected(&HALF_SPACE, &body, method, is_diffuse, *light, i, &mut stats)[0]
                });
                for k in (0..3).filter(|k| watched[*k]) {
                    let error = sums.mean(k) / known(absorbed[k])[n] - 1.0;
                    assert!(
                        error.abs() < tolerance,
                        "{method:?} {extinction:?} {absorbed:?} [{k}] diffuse {is_diffuse}: {error}"
                    );
                }
                assert_eq!((stats.cut, stats.lost, stats.outside), (0, 0, 0));
            }
        }
    }
}

#[test]
fn one_channel_reflects_what_theory_says() {
    let of = |absorbed: f64| ([1.0; 3], [absorbed; 3], [1.0, 0.0, 0.0]);
    check_half_space(&[of(0.7), of(0.5), of(0.2), of(0.1), of(0.05), of(0.01), of(0.001)], 0.0015, 0.005);
}

#[test]
fn channels_that_share_a_walk_reflect_what_theory_says() {
    let even = ([1.0; 3], [0.5, 0.1, 0.01], [1.0; 3]);
    let uneven = ([1.0, 3.0, 7.0], [0.3, 0.01, 0.05], [1.0; 3]);
    // One channel of three is known three times as badly for the same work.
    check_half_space(&[even, uneven], 0.003, 0.01);
}

#[test]
fn reflectance_does_not_depend_on_the_mean_free_path() {
    check_half_space(&[([1.0, 30.0, 1000.0], [0.01, 0.1, 0.2], [1.0; 3])], 0.003, 0.01);
}

#[test]
fn a_smooth_boundary_sends_light_back_inside() {
    const N: f64 = 1.4;
    let absorbed = [0.1, 0.05, 0.01];
    let body = Body::new(&medium([1.0; 3], absorbed), RADIUS);
    for (n, is_diffuse) in [false, true].into_iter().enumerate() {
        for method in METHODS {
            let mut stats = WalkStats::default();
            let sums = measure(0.0016, 4_000_000, [false, true, true], |i| {
                let outside = f64::from(-inwards(DVec3::Z, is_diffuse, 2, i).z);
                let surface = fresnel(outside, N);
                // Snell's law.
                let inside = (1.0 - (1.0 - outside * outside) / (N * N)).sqrt();
                let mut direction = guide::around(DVec3::NEG_Z, inside, number(2, i, 2)).as_vec3();
                let mut position = DVec3::ZERO;
                let mut throughput = [(1.0 - surface) as f32; 3];
                for vertex in 0..10_000 {
                    let mut start = entry(&HALF_SPACE, position, direction, throughput, 2, i);
                    start.vertex = vertex;
                    let End::Surface { hit, position: from, direction: d, throughput: left, .. } =
                        walk(&HALF_SPACE, &body, &start, method, &mut stats)
                    else {
                        return [surface; 3];
                    };
                    throughput = left;
                    if number(2, i, 10 + vertex) >= fresnel(f64::from(d.z).min(1.0), 1.0 / N) {
                        return throughput.map(|x| f64::from(x) + surface);
                    }
                    position = from + d.as_dvec3() * f64::from(hit.t);
                    position.z = 0.0;
                    direction = Vec3::new(d.x, d.y, -d.z);
                }
                panic!("reflected for ever");
            });
            for k in 0..3 {
                let error = sums.mean(k) / known(absorbed[k])[2 + n] - 1.0;
                assert!(error.abs() < 0.005, "{method:?} {absorbed:?} [{k}] diffuse {is_diffuse}: {error}");
            }
        }
    }
}

#[test]
fn slabs_reflect_and_transmit_what_theory_says() {
    // 1 - albedo, optical depth, then R and T for normal and for diffuse incidence.
    for (absorbed, depth, known) in [
        (0.5, 1.0, [0.099_119, 0.446_058, 0.134_165, 0.306_709]),
        (0.1, 1.0, [0.267_41, 0.591_625, 0.352_712, 0.474_746]),
        (0.1, 5.0, [0.412_541, 0.076_65, 0.476_338, 0.053_421]),
        (0.01, 5.0, [0.680_078, 0.220_628, 0.737_507, 0.173_152]),
        (0.0, 1.0, [0.341_329, 0.658_671, 0.446_594, 0.553_406]),
        (0.0, 10.0, [0.853_005, 0.146_995, 0.883_255, 0.116_745]),
    ] {
        let slab = Slab { depth };
        let body = Body::new(&medium([1.0; 3], [absorbed; 3]), depth as f32 / 2.0);
        for (n, is_diffuse) in [false, true].into_iter().enumerate() {
            for method in METHODS {
                let mut stats = WalkStats::default();
                let sums = measure(0.0016, 150_000, [true, true, false], |i| {
                    let [r, t] = reflected(&slab, &body, method, is_diffuse, [1.0, 0.0, 0.0], i, &mut stats);
                    [r[0], t[0], 0.0]
                });
                for k in 0..2 {
                    let error = sums.mean(k) / known[2 * n + k] - 1.0;
                    // What little comes through thick slabs is known less well.
                    let sigma = sums.sigma(k) / known[2 * n + k];
                    assert!(
                        sigma < 0.02 && error.abs() < (3.5 * sigma).max(0.005),
                        "{method:?} {absorbed} {depth} diffuse {is_diffuse} {k}: {error}"
                    );
                }
            }
        }
    }
}
