//! The built-in cases: every property at both ends and beyond, pairs that interact, images, meshes, lights, stiff media.

use super::Case;
use super::scenes::{Stage, lights, meshes, textured};
use burnish_material::{LimitKind, Material, PROPERTIES, Property, Property::*, PropertyDef, Value, Vary};
use glam::Vec3;
use std::sync::Arc;

/// Values of a material.
type Values = [(Property, Value)];

const fn f(x: f64) -> Value {
    Value::Float(x)
}

const fn c(r: f64, g: f64, b: f64) -> Value {
    Value::Color([r, g, b])
}

const ON: Value = Value::Bool(true);

const PLAIN: &Values = &[(base_color, c(0.8, 0.5, 0.2))];
const METAL: &Values = &[(base_color, c(1.0, 0.7, 0.3)), (metallic, f(1.0)), (roughness, f(0.2))];
const GLASS: &Values = &[(translucency, f(1.0)), (roughness, f(0.1))];
const COATED: &Values =
    &[(base_color, c(0.8, 0.5, 0.2)), (coat, f(1.0)), (coat_color, c(0.9, 0.4, 0.1)), (coat_roughness, f(0.1))];
const CLOTH: &Values = &[(base_color, c(0.3, 0.1, 0.1)), (sheen, f(1.0)), (roughness, f(0.8))];
const TINTED: &Values = &[(translucency, f(1.0)), (absorption_color, c(0.9, 0.5, 0.05)), (absorption_distance, f(0.5))];
const MILK: &Values =
    &[(translucency, f(1.0)), (scatter, ON), (scatter_color, c(0.95, 0.9, 0.7)), (scatter_distance, f(0.3)), (roughness, f(0.3))];
const BRUSHED: &Values = &[(base_color, c(0.9, 0.9, 0.9)), (metallic, f(1.0)), (roughness, f(0.2)), (anisotropy, f(0.7))];
const LAMP: &Values = &[(emission, f(2.0)), (emission_color, c(1.0, 0.5, 0.2))];
const BENT: &Values = &[(normal, Value::Normal([0.3, 0.2, 0.93])), (metallic, f(0.5))];
const BENT_COAT: &Values = &[(coat, f(1.0)), (coat_normal, Value::Normal([0.3, 0.2, 0.93]))];

/// The material in which a property acts, with its name.
fn base_of(property: Property) -> (&'static str, &'static Values) {
    match property {
        metallic | roughness | specular_edge_color => ("metal", METAL),
        translucency | specular_ior | dispersion => ("glass", GLASS),
        absorption_color | absorption_distance => ("tinted glass", TINTED),
        scatter | scatter_color | scatter_distance | scatter_distance_scale | scatter_red_shift | scatter_rayleigh => {
            ("milk", MILK)
        }
        coat | coat_color | coat_roughness | coat_ior | coat_specular_level => ("coated", COATED),
        coat_normal | coat_normal_scale => ("bent coat", BENT_COAT),
        sheen | sheen_color | sheen_roughness => ("cloth", CLOTH),
        anisotropy | anisotropy_rotation => ("brushed", BRUSHED),
        emission | emission_color => ("lamp", LAMP),
        normal | normal_scale => ("bent", BENT),
        _ => ("plain", PLAIN),
    }
}

/// Some properties act otherwise in another base.
const SECOND_BASES: &[(Property, &str, &Values)] = &[
    (base_color, "metal", METAL),
    (roughness, "glass", GLASS),
    (roughness, "plain", PLAIN),
    (anisotropy, "glass", GLASS),
    (specular_level, "glass", GLASS),
    (specular_edge_color, "glass", GLASS),
    (specular_ior, "plain", PLAIN),
    (specular_ior, "coated", COATED),
    (opacity, "milk", MILK),
    (opacity, "tinted glass", TINTED),
    (metallic, "glass", GLASS),
    (coat, "glass", GLASS),
];

fn material(parts: &[&Values]) -> Material {
    let mut m = Material::named("case");
    for (property, value) in parts.iter().copied().flatten() {
        m.set(*property, *value);
    }
    m
}

/// Numbers that a file may hold for a property: ends, beyond them, far beyond, none at all.
fn numbers(def: &PropertyDef) -> Vec<f64> {
    let low = def.limits.min.unwrap_or(-1.0);
    let high = def.limits.max.unwrap_or(def.limits.slider_max);
    let mut all = vec![low, high];
    match def.limits.kind {
        // All values beyond a hard end are used as the end: one stands for them.
        LimitKind::Hard => all.push(low - 1.0),
        LimitKind::Typical | LimitKind::Open => all.extend([low - 0.5, -1.0, 0.0, 2.0 * high, 10.0 * high]),
    }
    if def.limits.min == Some(0.0) {
        all.extend([1e-30, 1e-4]);
    }
    all.extend([1e30, f64::NAN]);
    let mut distinct: Vec<f64> = Vec::new();
    for x in all {
        if !distinct.contains(&x) {
            distinct.push(x);
        }
    }
    distinct
}

/// The built-in suite. Names are unique, and names and order are the same in every run.
pub fn suite() -> Vec<Case> {
    let stage = Stage::new();
    let mut cases = Vec::new();
    properties(&stage, &mut cases);
    pairs(&stage, &mut cases);
    media(&stage, &mut cases);
    images(&stage, &mut cases);
    surroundings(&stage, &mut cases);
    cases
}

fn properties(stage: &Stage, cases: &mut Vec<Case>) {
    for def in PROPERTIES {
        let second = SECOND_BASES.iter().filter(|(p, ..)| *p == def.id).map(|(_, name, values)| (*name, *values));
        for (base, values) in std::iter::once(base_of(def.id)).chain(second) {
            let mut add = |text: String, value: Value| {
                let made = material(&[values, &[(def.id, value)]]);
                cases.push(stage.case(format!("{} {text}, {base}", def.name), made));
            };
            match def.default {
                Value::Float(_) => numbers(def).into_iter().for_each(|x| add(format!("{x:e}"), f(x))),
                Value::Color(_) => {
                    for (text, [r, g, b]) in [
                        ("black", [0.0; 3]),
                        ("white", [1.0; 3]),
                        ("red", [1.0, 0.0, 0.0]),
                        ("beyond", [-1.0, 2.0, 1e30]),
                        ("not a number", [f64::NAN, 0.5, 1e-30]),
                    ] {
                        add(text.to_owned(), c(r, g, b));
                    }
                }
                Value::Bool(_) => [true, false].into_iter().for_each(|x| add(x.to_string(), Value::Bool(x))),
                Value::Normal(_) => {
                    for (text, n) in [
                        ("zero", [0.0; 3]),
                        ("flat", [0.0, 0.0, 1.0]),
                        ("sideways", [1.0, 0.0, 0.0]),
                        ("inwards", [0.1, 0.2, -1.0]),
                        ("huge", [1e30, -1e30, 1e30]),
                        ("not a number", [f64::NAN, 0.0, 1.0]),
                    ] {
                        add(text.to_owned(), Value::Normal(n));
                    }
                }
            }
        }
    }
}

/// Every combination of two lists.
fn cross(
    stage: &Stage,
    cases: &mut Vec<Case>,
    (base, values): (&str, &Values),
    (first, firsts): (Property, &[f64]),
    (second, seconds): (Property, &[f64]),
) {
    for x in firsts {
        for y in seconds {
            let name = format!("{} {x:e} with {} {y:e}, {base}", first.def().name, second.def().name);
            cases.push(stage.case(name, material(&[values, &[(first, f(*x)), (second, f(*y))]])));
        }
    }
}

fn pairs(stage: &Stage, cases: &mut Vec<Case>) {
    let mut pair = |base: (&str, &Values), a: (Property, &[f64]), b: (Property, &[f64])| cross(stage, cases, base, a, b);
    for base in [("brushed", BRUSHED), ("glass", GLASS)] {
        pair(base, (roughness, &[0.0, 0.01, 0.3, 1.0]), (anisotropy, &[0.05, 0.3, 1.0]));
    }
    for base in [("plain", PLAIN), ("glass", GLASS)] {
        pair(base, (specular_ior, &[0.5, 1.0001, 1.01, 3.0, 20.0]), (specular_level, &[0.0, 1e-4, 1.0]));
    }
    pair(("coated", COATED), (coat_ior, &[1.0, 1.6, 3.0]), (specular_ior, &[0.7, 1.0, 1.6, 3.0]));
    pair(
        ("coated glass", &[(coat, f(1.0)), (translucency, f(1.0)), (roughness, f(0.3))]),
        (coat_ior, &[1.0, 1.6, 3.0]),
        (specular_ior, &[0.7, 1.0, 1.6, 3.0]),
    );
    pair(("mix", PLAIN), (metallic, &[1e-7, 0.5, 1.0 - 1e-7]), (translucency, &[1e-7, 0.5, 1.0 - 1e-7]));
    for (layer, values) in [("smooth coat", 0.0), ("rough coat", 0.6)] {
        pair((layer, &[(coat_roughness, f(values))]), (sheen, &[0.5, 1.0]), (coat, &[0.5, 1.0]));
    }
    pair(("cloth", CLOTH), (sheen_roughness, &[0.0, 1e-3, 0.05, 1.0]), (sheen, &[0.01, 1.0]));
    pair(("glass", GLASS), (dispersion, &[1.0, 20.0]), (specular_ior, &[0.7, 1.001, 1.5, 3.0]));
    pair(("lamp", LAMP), (emission, &[1e-6, 1e6, 1e38]), (opacity, &[0.0, 0.5]));
    pair(("milk", MILK), (opacity, &[0.0, 0.5]), (translucency, &[0.0, 0.5]));
    pair(("tinted glass", TINTED), (roughness, &[0.0, 0.5, 1.0]), (specular_ior, &[1.0, 1.33, 3.0]));
    pair(("coated", COATED), (coat_roughness, &[0.0, 0.01, 1.0]), (coat_specular_level, &[0.0, 1.0]));
    for (text, edge) in [("black edge", c(0.0, 0.0, 0.0)), ("red edge", c(1.0, 0.0, 0.0))] {
        for (name, base) in [("black", 0.0), ("dark", 0.05), ("white", 1.0)] {
            let made = material(&[METAL, &[(base_color, c(base, base, base)), (specular_edge_color, edge)]]);
            cases.push(stage.case(format!("{name} metal with a {text}"), made));
        }
    }
}

fn media(stage: &Stage, cases: &mut Vec<Case>) {
    let mut add = |name: String, values: &Values| cases.push(stage.case(name, material(&[MILK, values])));
    for (text, distance) in [("0", 0.0), ("1e-30", 1e-30), ("1e-5", 1e-5), ("1e-2", 1e-2), ("1", 1.0), ("1e6", 1e6)] {
        for (name, color) in [("white", c(1.0, 1.0, 1.0)), ("black", c(0.0, 0.0, 0.0)), ("red", c(1.0, 0.0, 0.5))] {
            add(format!("medium: mean free path {text}, {name}"), &[(scatter_distance, f(distance)), (scatter_color, color)]);
        }
    }
    let spread = (scatter_distance_scale, c(1.0, 0.03, 1e-3));
    for (text, distance) in [("1e-5", 1e-5), ("1e-2", 1e-2), ("1", 1.0)] {
        add(
            format!("medium: lossless, extinctions 1000:1, mean free path {text}"),
            &[(scatter_distance, f(distance)), (scatter_color, c(1.0, 1.0, 1.0)), spread],
        );
    }
    for (text, red, rayleigh) in
        [("most", 1.0, 1.0), ("beyond", 10.0, 5.0), ("negative", -1.0, -5.0), ("far beyond", 1e30, -1e30)]
    {
        add(format!("medium: shifts {text}"), &[(scatter_red_shift, f(red)), (scatter_rayleigh, f(rayleigh)), spread]);
    }
    add("medium: no surface".into(), &[(opacity, f(0.0)), (scatter_distance, f(0.1))]);
    add(
        "medium: index-matched".into(),
        &[(specular_ior, f(1.0)), (scatter_distance, f(0.01)), (scatter_color, c(1.0, 1.0, 1.0))],
    );
    add("medium: total reflection from outside".into(), &[(specular_ior, f(0.5)), (scatter_distance, f(0.1))]);
    add(
        "medium: scattering with dark absorption".into(),
        &[(scatter_distance, f(0.01)), (absorption_color, c(1.0, 0.0, 0.5)), (absorption_distance, f(1e-4))],
    );
    for (text, distance) in [("0", 0.0), ("1e-40", 1e-40), ("1e-9", 1e-9), ("1e-3", 1e-3), ("1e30", 1e30)] {
        for (name, color) in [("black", c(0.0, 0.0, 0.0)), ("white but one", c(1.0, 1.0, 0.0)), ("dark", c(1e-6, 0.01, 0.5))] {
            let made = material(&[GLASS, &[(absorption_distance, f(distance)), (absorption_color, color)]]);
            cases.push(stage.case(format!("absorption: distance {text}, {name}"), made));
        }
    }
}

/// Images with texels that a file of floats may hold, on every property that takes one.
fn images(stage: &Stage, cases: &mut Vec<Case>) {
    for def in PROPERTIES.iter().filter(|def| def.vary != Vary::Uniform) {
        let (base, values) = base_of(def.id);
        for (text, texels) in [
            ("0 and 1", vec![0.0, 1.0, 1.0, 0.0]),
            ("NaN", vec![f32::NAN, 0.5, f32::NAN, f32::INFINITY]),
            ("65504", vec![65504.0, 0.5, 1e30, 65504.0]),
            ("negative", vec![-1.0, 0.5, -65504.0, -1e-30]),
        ] {
            let (made, set) = textured(material(&[values]), def.id, texels);
            cases.push(stage.case_on(format!("{} image of {text}, {base}", def.name), made, set, &stage.ball));
        }
    }
    let (made, set) = textured(material(&[GLASS]), roughness, vec![f32::NAN]);
    cases.push(stage.case_on("roughness image of one NaN, glass", made, set, &stage.ball));
}

fn surroundings(stage: &Stage, cases: &mut Vec<Case>) {
    let mapped = || textured(material(&[BRUSHED, &[(normal_scale, f(3.0))]]), normal, vec![0.0, 0.5, 1.0, 0.5]);
    for (text, mesh) in meshes() {
        for (name, values) in [("brushed", BRUSHED), ("tinted glass", TINTED)] {
            cases.push(stage.case_on(format!("mesh: {text}, {name}"), material(&[values]), Arc::default(), &mesh));
        }
        let (made, set) = mapped();
        cases.push(stage.case_on(format!("mesh: {text}, with a normal map"), made, set, &mesh));
    }
    for (text, light) in lights() {
        for (name, values) in [("coated", COATED), ("glass", GLASS)] {
            let mut case = stage.case(format!("light: {text}, {name}"), material(&[values]));
            case.scene.environment = light.clone();
            cases.push(case);
        }
    }
    for (name, values) in [("tinted glass", TINTED), ("milk", MILK), ("plain", PLAIN), ("lamp", LAMP)] {
        let mut case = stage.case(format!("camera inside, {name}"), material(&[values]));
        case.scene.camera.origin = Vec3::new(0.1, 0.2, 0.3);
        case.scene.camera.target = Vec3::new(0.1, 0.9, -0.3);
        cases.push(case);
        let mut case = stage.case(format!("camera on the surface, {name}"), material(&[values]));
        case.scene.camera.origin = Vec3::Z;
        case.scene.camera.target = Vec3::new(1.0, 0.0, 1.0);
        cases.push(case);
    }
    for bounces in [0, 64] {
        let mut case = stage.case(format!("{bounces} bounces, glass"), material(&[GLASS]));
        case.scene.max_bounces = bounces;
        cases.push(case);
    }
    for (text, scale) in [("1e-6", 1e-6), ("1e6", 1e6)] {
        let mut case = stage.case(format!("a unit of the material is {text} of the scene, tinted glass"), material(&[TINTED]));
        case.scene.objects[0].length_scale = scale;
        cases.push(case);
    }
}
