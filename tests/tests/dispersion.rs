//! Does glass bend colours as Cauchy's formula says, and does white light stay white in sum?

use burnish_assets::make_shape;
use burnish_material::{LobeSet, Property};
use burnish_renderer::bsdf::dispersion::{WAVELENGTH_RANGE, spectrum};
use burnish_renderer::bsdf::{Albedos, Bsdf, View, Wavelength, interpret};
use burnish_renderer::path::{Settings, StopRules, render};
use burnish_renderer::scene::{ModelMeshes, Scene};
use burnish_renderer::vector::{Rgb, V3};
use burnish_tests::materials::{f, material};
use burnish_tests::number::unit;
use burnish_tests::scenes::{environment, mean};
use std::sync::Arc;

/// Apex of the prism.
const APEX: f64 = 0.7;

fn glass(ior: f64, dispersion: f64, roughness: f64) -> burnish_material::Material {
    material(&[
        (Property::translucency, f(1.0)),
        (Property::roughness, f(roughness)),
        (Property::specular_ior, f(ior)),
        (Property::dispersion, f(dispersion)),
    ])
}

/// Direction after one smooth interface, for light of one wavelength; both in the frame of the interface.
fn refracted(material: &burnish_material::Material, wo: V3<f64>, nm: f64) -> V3<f64> {
    let (lobes, inputs) = (LobeSet::of(material), material.inputs());
    let optics = interpret(&inputs, lobes, 1.0);
    let albedos = Albedos::uniform(&inputs, lobes);
    let light = Wavelength { nm, weights: Rgb(spectrum().weights(nm).map(f64::from)), is_dispersed: true };
    let bsdf = Bsdf::prepare(&optics, &albedos, lobes, &View { light: Some(light), ..View::new(wo) });
    let s = bsdf.sample([0.5, 0.5, 0.5, 0.999_999]);
    assert!(s.is_valid && s.is_transmission && s.is_delta);
    s.wi
}

#[test]
fn a_prism_deviates_colours_as_cauchys_formula_says() {
    for (ior, dispersion) in [(1.5, 1.0), (1.52, 0.36), (1.8, 2.0), (1.3, 5.0)] {
        let material = glass(ior, dispersion, 0.0);
        for nm in [400.0, 486.1, 587.6, 656.3, 700.0] {
            // Constants of the formula from the wavelengths of the Fraunhofer lines, not from the renderer's own.
            let (lf, ld, lc): (f64, f64, f64) = (486.1, 587.6, 656.3);
            let b = (ior - 1.0) * dispersion / 20.0 / (lf.powi(-2) - lc.powi(-2));
            let n = ior - b / (ld * ld) + b / (nm * nm);
            for incidence in [0.3, 0.55, 0.8] {
                let inner = (f64::sin(incidence) / n).asin();
                let second: f64 = APEX - inner;
                let leaving = (n * second.sin()).asin();
                if !leaving.is_finite() || leaving > 1.4 {
                    continue;
                }
                // In: the angle inside. Out: the angle outside, from below the second face.
                let first = refracted(&material, V3::new(-f64::sin(incidence), 0.0, f64::cos(incidence)), nm);
                let found_inner = first.x.atan2(-first.z);
                let last = refracted(&material, V3::new(-f64::sin(APEX - found_inner), 0.0, -f64::cos(APEX - found_inner)), nm);
                let deviation = incidence + last.x.atan2(last.z) - APEX;
                let expected = incidence + leaving - APEX;
                assert!(
                    (deviation - expected).abs() < 1e-4,
                    "IOR {ior}, dispersion {dispersion}, {nm} nm, {incidence} rad: {deviation}, expected {expected}"
                );
            }
        }
    }
}

#[test]
fn weights_of_wavelengths_sum_to_white() {
    let mut sum = [0.0; 3];
    let n = 64;
    for i in 0..n {
        let nm = spectrum().wavelength((f64::from(i) + 0.5) / f64::from(n));
        assert!((WAVELENGTH_RANGE[0]..WAVELENGTH_RANGE[1]).contains(&nm));
        for (sum, w) in sum.iter_mut().zip(spectrum().weights(nm)) {
            *sum += f64::from(w) / f64::from(n);
        }
    }
    assert!(sum.iter().all(|s| (s - 1.0).abs() < 1e-3), "{sum:?}");
}

/// Per wavelength the directions differ, in sum what is reflected and what passes is white: for smooth and rough glass, and from inside.
#[test]
fn white_light_stays_white_in_sum() {
    for (roughness, mu) in [(0.0, 0.8), (0.0, -0.8), (0.3, 0.6), (0.3, -0.9), (0.0, 0.3)] {
        let material = glass(1.5, 2.0, roughness);
        let (lobes, inputs) = (LobeSet::of(&material), material.inputs());
        let optics = interpret(&inputs, lobes, 1.0);
        let albedos = Albedos::uniform(&inputs, lobes);
        let n = 1 << 16;
        let mut sum = [0.0; 3];
        for i in 0..n {
            let nm = spectrum().wavelength((i as f64 + 0.5) / n as f64);
            let weights = Rgb(spectrum().weights(nm).map(f64::from));
            let light = Some(Wavelength { nm, weights, is_dispersed: false });
            let wo = burnish_tests::quadrature::direction(mu, 0.4);
            let bsdf = Bsdf::prepare(&optics, &albedos, lobes, &View { light, ..View::new(wo) });
            let s = bsdf.sample([0, 1, 2, 3].map(|d| unit(i, d)));
            if s.is_valid {
                for (sum, w) in sum.iter_mut().zip(s.weight.0) {
                    *sum += w / n as f64;
                }
            }
        }
        assert!(sum.iter().all(|s| (s - 1.0).abs() < 3e-3), "roughness {roughness}, cosine {mu}: {sum:?}");
    }
}

#[test]
fn a_dispersive_ball_before_white_is_white() {
    let model: ModelMeshes = make_shape("sphere").expect("the sphere is built in").into();
    let mut scene = Scene::of_model(&model, Arc::new(glass(1.6, 3.0, 0.0)), Arc::default(), environment(&[1.0; 8]), 100.0);
    scene.objects.retain(|o| o.is_document);
    scene.max_bounces = 64;
    let stop = StopRules { spp: Some(64), ..StopRules::default() };
    let rendering =
        render(&scene, &Settings { width: 32, height: 32, seed: 7, threads: 2, stop, is_adaptive: false }, &mut |_| true);
    let found = mean(&rendering.film);
    assert!(found.iter().all(|c| (c - 1.0).abs() < 0.004), "{found:?}");
}
