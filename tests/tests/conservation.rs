//! White materials in a white furnace: nothing gained, nothing lost, whatever the roughness, stretch, index and mix.

use burnish_material::{LobeSet, Material, Property, Value};
use burnish_renderer::bsdf::{Albedos, Bsdf, View, interpret};
use burnish_tests::materials::material;
use burnish_tests::number::unit;
use burnish_tests::quadrature::direction;

/// Largest gain and loss over all channels.
const GAIN: f64 = 0.002;
const LOSS: f64 = 0.01;
/// The gain of rough glass in surroundings of nearly its own index, seen close to the horizon: almost all light passes straight
/// on, where single scattering finds almost none, and tables make up for it by factors of 10 to 20.
const GAIN_MATCHED: f64 = 0.006;
/// Contrasts of refraction that count as that.
const MATCHED: f64 = 0.2;
/// Samples per direction.
const SAMPLES: usize = 32768;
/// Cosines of the viewer, and azimuths that a stretched material tells apart.
const COSINES: [f64; 4] = [1.0, 0.5, 0.2, 0.06];
const AZIMUTHS: [f64; 2] = [0.1, std::f64::consts::FRAC_PI_2];

/// Reflected and transmitted share of white light for one direction.
fn albedo(material: &Material, albedos: &Albedos, mu: f64, azimuth: f64) -> [f64; 3] {
    let lobes = LobeSet::of(material);
    let optics = interpret(&material.inputs(), lobes, 1.0);
    let bsdf = Bsdf::prepare(&optics, albedos, lobes, &View::new(direction(mu, azimuth)));
    let mut sum = [0.0; 3];
    for i in 0..SAMPLES {
        let s = bsdf.sample([0, 1, 2, 3].map(|d| unit(i, d)));
        if s.is_valid {
            for (sum, w) in sum.iter_mut().zip(s.weight.0) {
                *sum += w / SAMPLES as f64;
            }
        }
    }
    sum
}

fn check(name: &str, material: &Material, azimuths: &[f64], worst: &mut (f64, f64, String, String)) {
    let lobes = LobeSet::of(material);
    let optics = interpret(&material.inputs(), lobes, 1.0);
    let albedos = Albedos::uniform(&material.inputs(), lobes);
    let is_matched = optics.w_transmission > 0.0 && (optics.eta - 1.0).abs() < MATCHED;
    for side in [1.0, -1.0] {
        for mu in COSINES {
            for azimuth in azimuths {
                for found in albedo(material, &albedos, side * mu, *azimuth) {
                    let gain = (found - 1.0) * if is_matched && mu < 0.1 { GAIN / GAIN_MATCHED } else { 1.0 };
                    if gain > worst.0 {
                        (worst.0, worst.2) = (gain, format!("{name}, cosine {}, azimuth {azimuth}", side * mu));
                    }
                    if 1.0 - found > worst.1 {
                        (worst.1, worst.3) = (1.0 - found, format!("{name}, cosine {}, azimuth {azimuth}", side * mu));
                    }
                }
            }
        }
    }
}

fn report(worst: &(f64, f64, String, String)) {
    eprintln!("largest gain {:.5} ({}), largest loss {:.5} ({})", worst.0, worst.2, worst.1, worst.3);
    assert!(worst.0 <= GAIN, "gains {:.5}: {}", worst.0, worst.2);
    assert!(worst.1 <= LOSS, "loses {:.5}: {}", worst.1, worst.3);
}

#[test]
fn every_layer_over_every_base_conserves_energy() {
    use Property::*;
    let mut worst = (0.0, 0.0, String::new(), String::new());
    let layers: [(&str, &[(Property, f64)]); 4] = [
        ("", &[]),
        ("coat over ", &[(coat, 1.0)]),
        ("rough coat over ", &[(coat, 1.0), (coat_roughness, 0.4)]),
        ("sheen over ", &[(sheen, 1.0)]),
    ];
    for (layer, extra) in layers {
        for (base, values) in [("metal", [1.0, 0.0]), ("diffuse", [0.0, 0.0]), ("glass", [0.0, 1.0])] {
            for r in [0.0, 0.05, 0.3, 0.6, 1.0] {
                for a in [0.0, 0.5, 1.0] {
                    for ior in [1.0, 1.01, 1.5, 3.0] {
                        if base == "metal" && ior != 1.5 {
                            continue;
                        }
                        let mut m = material(&[(base_color, Value::Color([1.0; 3]))]);
                        for (p, v) in [
                            (metallic, values[0]),
                            (translucency, values[1]),
                            (roughness, r),
                            (anisotropy, a),
                            (specular_ior, ior),
                        ] {
                            m.set(p, Value::Float(v));
                        }
                        for (p, v) in extra {
                            m.set(*p, Value::Float(*v));
                        }
                        let name = format!("{layer}{base}, roughness {r}, anisotropy {a}, IOR {ior}");
                        let azimuths = if a > 0.0 && r < 1.0 { &AZIMUTHS[..] } else { &AZIMUTHS[..1] };
                        check(&name, &m, azimuths, &mut worst);
                    }
                }
            }
        }
    }
    report(&worst);
}

#[test]
fn random_mixes_conserve_energy() {
    use Property::*;
    let mut worst = (0.0, 0.0, String::new(), String::new());
    for i in 0..50 {
        let mut m = material(&[(base_color, Value::Color([1.0; 3]))]);
        let properties = [metallic, translucency, coat, sheen, roughness, coat_roughness, sheen_roughness, specular_level];
        for (d, p) in properties.into_iter().enumerate() {
            m.set(p, Value::Float(unit::<f64>(i * 7 + 1, d as u32)));
        }
        m.set(specular_ior, Value::Float(1.0 + 2.0 * unit::<f64>(i, 9)));
        m.set(coat_ior, Value::Float(1.0 + unit::<f64>(i, 10)));
        if i % 3 == 0 {
            m.set(anisotropy, Value::Float(unit::<f64>(i, 11)));
        }
        check(&format!("mix {i}"), &m, &AZIMUTHS[..1], &mut worst);
    }
    report(&worst);
}

/// The tests above measure what they say: half of the light, where half is kept.
#[test]
fn grey_keeps_half() {
    let m = material(&[(Property::base_color, Value::Color([0.5; 3])), (Property::specular_level, Value::Float(0.0))]);
    let found = albedo(&m, &Albedos::uniform(&m.inputs(), LobeSet::of(&m)), 0.6, 0.0);
    assert!(found.iter().all(|x| (x - 0.5).abs() < 1e-4), "{found:?}");
}
