//! Materials that tests loop over: one row per lobe and the mixes that interact.

use crate::number::Random;
use burnish_material::{Material, Property, Property::*, Value};

/// A material with these values.
pub fn material(values: &[(Property, Value)]) -> Material {
    let mut m = Material::named("case");
    for (property, value) in values {
        m.set(*property, *value);
    }
    m
}

/// Shorthand for a number.
pub const fn f(x: f64) -> Value {
    Value::Float(x)
}

/// Shorthand for a colour.
pub const fn c(r: f64, g: f64, b: f64) -> Value {
    Value::Color([r, g, b])
}

/// Named materials at one roughness: every lobe alone, and the mixes.
pub fn cases(rough: f64) -> Vec<(&'static str, Material)> {
    let white = (base_color, c(1.0, 1.0, 1.0));
    let with = |values: &[(Property, Value)]| {
        let mut m = material(values);
        m.set(roughness, f(rough));
        m
    };
    vec![
        ("dielectric", with(&[white])),
        ("lambert", with(&[white, (specular_level, f(0.0))])),
        ("dielectric, black", with(&[(base_color, c(0.0, 0.0, 0.0)), (specular_edge_color, c(0.9, 0.5, 0.2))])),
        ("metal, white", with(&[white, (metallic, f(1.0))])),
        (
            "metal, gold",
            with(&[(base_color, c(1.0, 0.71, 0.31)), (metallic, f(1.0)), (specular_edge_color, c(0.94, 0.96, 0.91))]),
        ),
        ("metal, stretched", with(&[white, (metallic, f(1.0)), (anisotropy, f(0.6)), (anisotropy_rotation, f(0.1))])),
        ("half metal", with(&[(base_color, c(0.9, 0.4, 0.2)), (metallic, f(0.5))])),
        ("glass", with(&[(translucency, f(1.0))])),
        (
            "glass, tinted",
            with(&[(translucency, f(1.0)), (absorption_color, c(0.8, 0.5, 0.2)), (specular_edge_color, c(1.0, 0.6, 0.6))]),
        ),
        ("glass, nearly matched", with(&[(translucency, f(1.0)), (specular_ior, f(1.001))])),
        ("glass, dense", with(&[(translucency, f(1.0)), (specular_ior, f(3.0)), (specular_level, f(1.0))])),
        ("glass, thin", with(&[(translucency, f(1.0)), (specular_ior, f(0.7))])),
        ("half glass", with(&[white, (translucency, f(0.5)), (metallic, f(0.2))])),
        ("glass, stretched", with(&[(translucency, f(1.0)), (anisotropy, f(0.7)), (anisotropy_rotation, f(0.2))])),
        ("half metal, half glass", with(&[(base_color, c(0.9, 0.6, 0.3)), (metallic, f(0.5)), (translucency, f(1.0))])),
        ("coat, rough", with(&[white, (coat, f(1.0)), (coat_roughness, f(0.3))])),
        (
            "coat, tinted metal",
            with(&[white, (metallic, f(1.0)), (coat, f(0.7)), (coat_roughness, f(0.2)), (coat_color, c(0.9, 0.3, 0.1))]),
        ),
        (
            "coat over glass",
            with(&[(translucency, f(1.0)), (coat, f(1.0)), (coat_roughness, f(0.2)), (coat_color, c(0.5, 0.8, 0.9))]),
        ),
        ("sheen", with(&[white, (sheen, f(1.0)), (sheen_roughness, f(0.4))])),
        (
            "sheen under coat",
            with(&[white, (sheen, f(0.5)), (sheen_color, c(0.9, 0.1, 0.4)), (coat, f(0.5)), (coat_roughness, f(0.4))]),
        ),
    ]
}

/// A random mix of everything, the same for the same number: metal, glass, coat, sheen, stretched, coloured. Rough enough to be
/// integrated over bins of some degrees.
pub fn random(i: usize) -> Material {
    let mut r = Random::new(i as u64 + 1);
    let mut m = Material::named(format!("random {i}"));
    for property in [base_color, specular_edge_color, sheen_color, coat_color, absorption_color] {
        m.set(property, c(r.unit(), r.unit(), r.unit()));
    }
    for property in [metallic, translucency, coat, sheen, anisotropy] {
        // A third is off, a third fully on.
        let x = r.between(-1.0, 2.0).clamp(0.0, 1.0);
        m.set(property, f(x));
    }
    if m.float(metallic) == 1.0 && r.chance(0.7) {
        m.set(metallic, f(0.5));
    }
    for property in [roughness, coat_roughness, sheen_roughness] {
        m.set(property, f(r.between(0.3, 1.0)));
    }
    if r.chance(0.15) {
        m.set(coat_roughness, f(0.0));
    }
    m.set(anisotropy_rotation, f(r.unit()));
    m.set(specular_level, f(r.unit()));
    m.set(coat_specular_level, f(r.unit()));
    m.set(specular_ior, f(r.between(1.2, 3.0)));
    m.set(coat_ior, f(r.between(1.1, 2.5)));
    if i.is_multiple_of(8) {
        m.set(dispersion, f(r.between(0.5, 10.0)));
    }
    m
}
