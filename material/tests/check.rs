//! Findings about single values and their combinations; one row per case.

use burnish_material::Property as P;
use burnish_material::Severity::{Error, Note, Warning};
use burnish_material::{Finding, LimitKind, Material, PROPERTIES, Property, Severity, TextureRef, Value, check, has_errors};

fn float(property: Property, x: f64) -> (Property, Value) {
    (property, Value::Float(x))
}

fn color(property: Property, x: [f64; 3]) -> (Property, Value) {
    (property, Value::Color(x))
}

fn findings(values: &[(Property, Value)]) -> Vec<Finding> {
    let mut material = Material::default();
    values.iter().for_each(|(property, value)| _ = material.set(*property, *value));
    check(&material)
}

fn expect(values: &[(Property, Value)], severity: Severity, property: Property, words: &str) {
    let found = findings(values);
    let is_there = found.iter().any(|f| f.severity == severity && f.property == Some(property) && f.message.contains(words));
    assert!(is_there, "expected {severity:?} of {property:?} with {words:?} for {values:?}, found {found:#?}");
}

#[test]
fn plain_materials_have_no_findings() {
    assert_eq!(check(&Material::default()), []);
    let mut written_out = Material::default();
    PROPERTIES.iter().for_each(|def| _ = written_out.set(def.id, def.default));
    assert_eq!(check(&written_out), []);
    assert_eq!(findings(&[color(P::base_color, [1.0, 0.77, 0.31]), float(P::metallic, 1.0)]), []);
    assert_eq!(findings(&[float(P::translucency, 1.0), float(P::dispersion, 0.31), float(P::specular_ior, 1.52)]), []);
}

#[test]
fn limits_of_every_property_are_checked() {
    for def in PROPERTIES {
        let value = |x: f64| match def.default {
            Value::Float(_) => Some(Value::Float(x)),
            Value::Color(_) => Some(Value::Color([0.5, x, 0.5])),
            _ => None,
        };
        let ends = [def.limits.min.map(|x| x - 0.25), def.limits.max.map(|x| x + 0.25)];
        for value in ends.into_iter().flatten().filter_map(value) {
            match def.limits.kind {
                LimitKind::Hard => expect(&[(def.id, value)], Error, def.id, "by the renderers"),
                LimitKind::Typical => expect(&[(def.id, value)], Note, def.id, "typical range"),
                LimitKind::Open => unreachable!("an open range has no ends"),
            }
        }
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY].into_iter().filter_map(value) {
            expect(&[(def.id, bad)], Error, def.id, "not a finite number");
        }
    }
    expect(&[color(P::base_color, [1.4, -0.1, 0.5])], Error, P::base_color, "1.4 is outside the range 0 to 1; used as 1");
}

#[test]
fn values_without_effect_are_noted() {
    for (property, value, lobe) in [
        (P::coat_roughness, Value::Float(0.2), "coat"),
        (P::sheen_color, Value::Color([0.5; 3]), "sheen"),
        (P::dispersion, Value::Float(0.5), "dispersion"),
        (P::absorption_color, Value::Color([0.5; 3]), "absorption"),
        (P::scatter, Value::Bool(true), "scattering"),
        (P::emission_color, Value::Color([0.5; 3]), "emission"),
        (P::normal_scale, Value::Float(0.5), "normal_map"),
        (P::height_scale, Value::Float(0.5), "height"),
        (P::anisotropy_rotation, Value::Float(0.5), "anisotropy"),
    ] {
        expect(&[(property, value)], Note, property, &format!("no effect on this material: {lobe} is left out"));
    }
    expect(&[float(P::metallic, 1.0), float(P::translucency, 0.5)], Note, P::translucency, "transmission is left out");
    // A value that switches its own lobe off does have an effect.
    assert_eq!(findings(&[float(P::specular_level, 0.0)]), []);
}

#[test]
fn unlikely_combinations_are_found() {
    let metal = float(P::metallic, 1.0);
    expect(&[float(P::metallic, 0.5)], Note, P::metallic, "between a dielectric and a metal");
    expect(&[metal, color(P::base_color, [0.9, 0.7, 0.02])], Warning, P::base_color, "0.02 in blue is below every metal");
    // Flakes below a clear coat.
    let paint = [metal, float(P::coat, 1.0), color(P::base_color, [0.02, 0.1, 0.4])];
    expect(&paint, Note, P::base_color, "0.02 in red is below every metal");
    expect(&[color(P::base_color, [0.95; 3])], Note, P::base_color, "fresh snow");
    expect(&[color(P::base_color, [0.01; 3])], Note, P::base_color, "soot");
    expect(&[float(P::specular_ior, 0.9)], Warning, P::specular_ior, "below 1");
    expect(&[float(P::coat, 1.0), float(P::coat_ior, 0.9)], Warning, P::coat_ior, "below 1");
    expect(&[float(P::coat, 1.0), float(P::coat_ior, 1.0)], Note, P::coat_ior, "only tints");
    expect(&[float(P::opacity, 0.9), float(P::translucency, 1.0)], Warning, P::opacity, "evaluated at every interface");
    let glass = float(P::translucency, 1.0);
    let dense = [glass, (P::scatter, Value::Bool(true)), float(P::scatter_distance, 0.0)];
    expect(&dense, Error, P::scatter_distance, "0 while scatter is on");
    assert!(has_errors(&findings(&dense)));
    expect(&[glass, float(P::absorption_distance, 2.0)], Note, P::absorption_distance, "white");
    expect(&[glass, float(P::dispersion, 9.0)], Note, P::dispersion, "zinc selenide");
}

#[test]
fn textures_are_checked_and_silence_what_they_replace() {
    let mut material = Material::default();
    material.set(P::metallic, Value::Float(0.5));
    material.slot_mut(P::metallic).texture = Some(TextureRef::new("m.png"));
    assert_eq!(check(&material), []);
    material.slot_mut(P::metallic).texture = Some(TextureRef { uv_scale: [1.0, 0.0], ..TextureRef::new("m.png") });
    assert_eq!(check(&material)[0].severity, Warning);
    material.slot_mut(P::metallic).texture = Some(TextureRef { uv_rotation: f64::NAN, ..TextureRef::new("m.png") });
    assert_eq!(check(&material)[0].severity, Error);
    for (scale, bias, words) in [([0.0; 3], [0.5; 3], "scaled by 0"), ([1.0; 3], [f64::INFINITY; 3], "not finite")] {
        material.slot_mut(P::metallic).texture = Some(TextureRef { scale, bias, ..TextureRef::new("m.png") });
        assert!(check(&material)[0].message.contains(words));
    }
    let mut bent = Material::default();
    bent.slot_mut(P::normal).texture = Some(TextureRef { bias: [0.1; 3], ..TextureRef::new("n.png") });
    assert_eq!(check(&bent)[0].severity, Note);
    material.slot_mut(P::metallic).texture = Some(TextureRef::new(""));
    assert!(check(&material)[0].message.contains("without a path"));
    material = Material::default();
    material.slot_mut(P::specular_ior).texture = Some(TextureRef::new("ior.png"));
    assert_eq!(check(&material)[0].to_string().split(", but").next(), Some("error: specular_ior: has a texture"));
}

#[test]
fn units_and_directions_are_checked() {
    for unit in [0.0, -1.0, f64::NAN] {
        let mut material = Material::default();
        material.unit_mm = Some(unit);
        assert!(check(&material)[0].message.contains("used as 100"));
    }
    expect(&[(P::normal, Value::Normal([1.0, 1.0, 1.0]))], Warning, P::normal, "length 1.732");
}
