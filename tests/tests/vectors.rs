//! Numbers that the model reference states for its formulas.

#![allow(clippy::needless_range_loop, reason = "a channel indexes several arrays at once")]

use burnish_renderer::bsdf::coat::coat_exponent;
use burnish_renderer::bsdf::fresnel::{f0_from_ior, f82_average, f82_coefficient, f82_tint, fresnel, ior_from_f0, level_to_ior};
use burnish_renderer::bsdf::ggx::alphas;
use burnish_renderer::bsdf::tables::{dielectric_albedo, dielectric_albedo_mean, sheen_albedo};
use burnish_renderer::vector::Rgb;

fn close(what: &str, found: f64, expected: f64, tolerance: f64) {
    assert!((found - expected).abs() <= tolerance, "{what}: found {found}, expected {expected}");
}

#[test]
fn roughness_and_anisotropy_to_alpha() {
    let cases = [
        (0.0, 0.5, 0.0625, 1e-4), // alpha_y 0 is raised to the smallest that is evaluated
        (0.0, 1.0, 1.0, 1e-4),
        (0.3, 0.5, 0.1525, 0.09),
        (0.3, 0.8, 0.4996, 0.09),
        (0.3, 1.0, 1.0, 0.09),
        (1.0, 0.5, 1.0, 1.0),
    ];
    for (roughness, anisotropy, x, y) in cases {
        let (alpha_x, alpha_y, is_smooth) = alphas::<f64>(roughness, anisotropy);
        close("alpha_x", alpha_x, x, 1e-9);
        close("alpha_y", alpha_y, y, 1e-9);
        assert!(!is_smooth, "only both below the smallest alpha make a mirror");
    }
    assert!(alphas::<f64>(0.0, 0.0).2);
    assert!(alphas::<f64>(0.0099, 0.0).2 && !alphas::<f64>(0.0101, 0.0).2);
}

#[test]
fn specular_level_to_index() {
    for (ior, expected) in [(1.5, [1.0, 1.3294, 1.5, 1.6488, 1.7888]), (3.0, [1.0, 2.0938, 3.0, 4.1596, 5.8284])] {
        for (level, expected) in [0.0, 0.25, 0.5, 0.75, 1.0].into_iter().zip(expected) {
            close(&format!("IOR {ior} at level {level}"), level_to_ior::<f64>(ior, level), expected, 5e-5);
        }
    }
    assert_eq!(level_to_ior::<f32>(1.5, 0.0), 1.0, "level 0 matches the index exactly");
}

#[test]
fn dielectric_fresnel() {
    assert_eq!(fresnel::<f32>(0.0, 1.0), 0.0, "matched media reflect nothing, even at grazing");
    assert_eq!(fresnel::<f32>(0.3, 1.0 / 1.5), 1.0, "total reflection");
    close("normal incidence", fresnel::<f64>(1.0, 1.5), 0.04, 1e-12);
    // Textbook form in double precision, for many angles and ratios.
    for i in 0..=200 {
        let c: f64 = f64::from(i) / 200.0;
        for eta in [1.0001, 1.01, 1.33, 1.5, 3.0, 0.5, 0.99] {
            let s2 = (1.0 - c * c) / (eta * eta);
            let expected = if s2 >= 1.0 {
                1.0
            } else {
                let t = (1.0 - s2).sqrt();
                let (s, p) = ((c - eta * t) / (c + eta * t), (eta * c - t) / (eta * c + t));
                0.5 * (s * s + p * p)
            };
            close(&format!("c {c}, eta {eta}"), fresnel(c, eta), expected, 1e-9);
            let single = f64::from(fresnel::<f32>(c as f32, eta as f32));
            assert!(
                (single - fresnel(f64::from(c as f32), f64::from(eta as f32))).abs() <= 2e-5 * single + 1e-12,
                "f32, c {c}, eta {eta}"
            );
        }
    }
}

#[test]
fn average_fresnel_of_the_tables() {
    for (ior, expected) in [(1.5, 0.09178), (1.6, 0.10625), (2.0, 0.16060), (3.0, 0.27620)] {
        close(&format!("IOR {ior}"), dielectric_albedo_mean::<f64>(ior, 0.0), expected, 6e-4);
        // The jump at the critical angle falls between two entries of the table; for dense glass all that leaves falls into the
        // last one. From inside the table only weighs lobes against each other.
        let tolerance = if ior > 2.0 { 4e-2 } else { 1e-2 };
        let inside = 1.0 - (1.0 - expected) / (ior * ior);
        close(&format!("IOR {ior} from inside"), dielectric_albedo_mean::<f64>(1.0 / ior, 0.0), inside, tolerance);
    }
}

#[test]
fn white_conductor_albedo_is_the_table_at_infinite_contrast() {
    let eta = 1e6;
    for (alpha, mean) in [(1.0, 0.409), (0.64, 0.604), (0.36, 0.803), (0.16, 0.940), (0.04, 0.995)] {
        close(&format!("alpha {alpha}"), dielectric_albedo_mean::<f64>(eta, f64::sqrt(alpha)), mean, 1e-3);
    }
    close("alpha 1, normal", dielectric_albedo::<f64>(eta, 1.0, 1.0), 0.307, 1e-3);
    close("alpha 1, cosine 0.5", dielectric_albedo::<f64>(eta, 1.0, 0.5), 0.451, 1e-3);
}

#[test]
fn f82_tint_of_gold() {
    let r = Rgb([1.0, 0.7099, 0.3148]);
    let b = r.zip(Rgb([0.9408, 0.9636, 0.9099]), f82_coefficient::<f64>);
    let rows = [
        (0.5, [0.99184, 0.71473, 0.32836]),
        (1.0 / 7.0, [0.94080, 0.81339, 0.57489]),
        (0.05, [0.96159, 0.91444, 0.80806]),
        (1.0, [1.0, 0.7099, 0.3148]),
        (0.0, [1.0, 1.0, 1.0]),
    ];
    for (mu, expected) in rows {
        for c in 0..3 {
            close(&format!("mu {mu}, channel {c}"), f82_tint(mu, r, b).0[c], expected[c], 1e-5);
        }
    }
    for (found, expected) in f82_average(r, b).0.into_iter().zip([0.99171, 0.71941, 0.33945]) {
        close("average", found, expected, 1e-5);
    }
}

#[test]
fn f82_tint_never_leaves_its_range() {
    for i in 0..=100 {
        let mu = f64::from(i) / 100.0;
        for r in [0.0, 0.04, 0.5, 1.0] {
            for t in [0.0, 0.5, 1.0] {
                let b = Rgb::grey(f82_coefficient(r, t));
                let f = f82_tint(mu, Rgb::grey(r), b).0[0];
                assert!((0.0..=1.0).contains(&f), "mu {mu}, r {r}, t {t}: {f}");
            }
        }
    }
}

#[test]
fn sheen_albedo_of_the_tables() {
    let rows = [
        (0.5, [0.7329, 0.4170, 0.2331, 0.1415, 0.0916, 0.0633]),
        (1.0, [0.8478, 0.6409, 0.4911, 0.3963, 0.3312, 0.2842]),
        (0.25, [0.5716, 0.2004, 0.0698, 0.0305, 0.0159, 0.0098]),
    ];
    for (r, expected) in rows {
        for (mu, expected) in [0.05, 0.2, 0.4, 0.6, 0.8, 1.0].into_iter().zip(expected) {
            close(&format!("sheen roughness {r}, cosine {mu}"), sheen_albedo::<f64>(r, mu), expected, 2.5e-3);
        }
    }
}

#[test]
fn coat_exponents_and_the_layer_below() {
    for (mu, expected) in [(1.0, 0.4075), (0.5, 0.6163), (0.0, 0.90625)] {
        close(&format!("exponent at {mu}"), coat_exponent::<f64>(mu), expected, 5e-5);
    }
    close("1.5 under a coat of 1.6", f0_from_ior(1.5f64 / 1.6), 0.00104, 5e-6);
    close("index of that", f0_from_ior(ior_from_f0(0.00104f64)), 0.00104, 1e-12);
}
