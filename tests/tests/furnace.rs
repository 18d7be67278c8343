//! Does the path tracer return what each lobe reflects and transmits, and never more than it received?

#![allow(clippy::needless_range_loop, reason = "a channel indexes several arrays at once")]

use burnish_material::Material;
use burnish_renderer::bsdf::View;
use burnish_renderer::path::{Settings, StopRules, render};
use burnish_renderer::scene::Scene;
use burnish_tests::materials::cases;
use burnish_tests::quadrature::{Integral, direction, integrate};
use burnish_tests::scenes::{environment, flat, mean};
use burnish_tests::surface::Surface;

const ROUGHNESSES: [f64; 3] = [0.05, 0.3, 1.0];
const AZIMUTH: f64 = 0.7;

fn picture(scene: &Scene, spp: u32) -> [f64; 3] {
    let stop = StopRules { spp: Some(spp), ..StopRules::default() };
    let rendering =
        render(scene, &Settings { width: 32, height: 32, seed: 7, threads: 2, stop, is_adaptive: false }, &mut |_| true);
    assert_eq!(rendering.nonfinite, 0, "non-finite samples");
    mean(&rendering.film)
}

fn integral(material: &Material, mu: f64) -> Integral {
    let surface = Surface::new(material);
    let wo = direction(mu, AZIMUTH);
    integrate(&surface.bsdf(&View::new(wo)), wo, &surface.optics)
}

#[test]
fn white_furnace_gives_the_directional_albedo() {
    for roughness in ROUGHNESSES {
        for (name, material) in cases(roughness) {
            for mu in [0.9, 0.35, -0.7] {
                let expected = integral(&material, mu);
                let found = picture(&flat(material.clone(), environment(&[1.0; 8]), mu, AZIMUTH), 64);
                for c in 0..3 {
                    let expected = expected.reflected[c] + expected.transmitted[c];
                    let error = (found[c] - expected).abs();
                    assert!(
                        error < 0.005 * expected.max(0.05),
                        "{name}, roughness {roughness}, cosine {mu}, channel {c}: rendered {}, by quadrature {expected}",
                        found[c]
                    );
                }
            }
        }
    }
}

/// Half a furnace: light sampling and BSDF sampling share the work, and only the reflected part returns.
#[test]
fn bright_sky_over_darkness_gives_the_reflected_part() {
    let mut rows = [0.0; 256];
    rows[..128].fill(1.0);
    for roughness in ROUGHNESSES {
        for (name, material) in cases(roughness) {
            let mu = 0.8;
            let expected = integral(&material, mu).reflected;
            let found = picture(&flat(material, environment(&rows), mu, AZIMUTH), 256);
            for c in 0..3 {
                let error = (found[c] - expected[c]).abs();
                assert!(
                    error < 0.007 * expected[c].max(0.05),
                    "{name}, roughness {roughness}, channel {c}: rendered {}, by quadrature {}",
                    found[c],
                    expected[c]
                );
            }
        }
    }
}
