//! Do pictures stay finite where numbers get hard?

use burnish_assets::make_shape;
use burnish_material::{LimitKind, Material, PROPERTIES, Property, Value};
use burnish_renderer::path::{Film, Prepared, Settings, StopRules, render, render_pass};
use burnish_renderer::scene::{ModelMeshes, Scene};
use burnish_tests::scenes::environment;
use std::sync::Arc;

/// Numbers that a property may hold in a file: both ends of its range, beyond them, and far beyond.
const NUMBERS: [f64; 9] = [0.0, 1.0, 1e-30, 1e-4, 3.0, 20.0, -1.0, 1e30, 1e300];

fn materials() -> Vec<(String, Material)> {
    let bases: [(&str, &[(Property, f64)]); 4] = [
        ("default", &[]),
        ("metal", &[(Property::metallic, 1.0), (Property::roughness, 0.0)]),
        ("glass", &[(Property::translucency, 1.0), (Property::roughness, 0.0), (Property::absorption_distance, 1e-3)]),
        ("coated", &[(Property::coat, 1.0), (Property::sheen, 1.0), (Property::emission, 1e38), (Property::opacity, 0.5)]),
    ];
    let mut made = Vec::new();
    for (name, values) in bases {
        for def in PROPERTIES {
            for x in NUMBERS {
                let value = match def.default {
                    Value::Float(_) => Value::Float(x),
                    Value::Color(_) => Value::Color([x, 0.0, 1.0]),
                    _ => continue,
                };
                // Within a hard range most of these numbers are the same two.
                if def.limits.kind == LimitKind::Hard && !def.limits.contains(x) && x.abs() < 1e30 {
                    continue;
                }
                let mut material = Material::named(format!("{name}, {} {x}", def.name));
                for (property, x) in values {
                    material.set(*property, Value::Float(*x));
                }
                material.set(def.id, value);
                made.push((material.name.clone(), material));
            }
        }
    }
    made
}

#[test]
fn every_property_at_its_extremes_gives_finite_pixels() {
    let model: ModelMeshes = make_shape("torus").expect("the torus is built in").into();
    let mut rows = [0.2; 16];
    rows[2] = 5e4;
    let light = environment(&rows);
    let mut prepared: Option<Prepared> = None;
    for (name, material) in materials() {
        let mut scene = Scene::of_model(&model, Arc::new(material), Arc::default(), light.clone(), 100.0);
        scene.max_bounces = 8;
        // The tree and the light's tables are the same for all.
        let now = Prepared::new(&scene, prepared.as_ref());
        let mut film = Film::new(12, 12);
        let stats = render_pass(&now, &mut film, 4, 3, 1, &|| false).expect("nobody cancels");
        assert_eq!((stats.nonfinite, stats.negative), (0, 0), "{name}: samples were dropped");
        for pixel in film.mean() {
            assert!(pixel.iter().all(|c| c.is_finite() && *c >= 0.0), "{name}: {pixel:?}");
        }
        prepared = Some(now);
    }
}

#[test]
fn a_light_beyond_single_precision_gives_finite_pixels() {
    let model: ModelMeshes = make_shape("sphere").expect("the sphere is built in").into();
    let mut light = environment(&[1.0, 0.5, 3.0, 1.0]);
    light.scale = 1e38;
    let scene = Scene::of_model(&model, Arc::new(Material::named("grey")), Arc::default(), light, 100.0);
    let stop = StopRules { spp: Some(8), ..StopRules::default() };
    let rendering = render(&scene, &Settings { width: 16, height: 16, seed: 3, threads: 1, stop }, &mut |_| true);
    assert_eq!(rendering.nonfinite, 0, "samples were dropped");
    assert!(rendering.film.mean().iter().flatten().all(|c| c.is_finite()));
}
