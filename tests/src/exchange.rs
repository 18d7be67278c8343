//! Materials for interchange: all that a property can be, and not only what looks good.

use crate::number::Random;
use burnish_material::{Kind, Material, PROPERTIES, PropertyDef, Value};

/// Which end of the ranges.
#[derive(Clone, Copy)]
enum End {
    Low,
    High,
}

fn end(def: &PropertyDef, end: End) -> f64 {
    match end {
        End::Low => def.limits.min.unwrap_or(-def.limits.slider_max),
        End::High => def.limits.max.unwrap_or(def.limits.slider_max),
    }
}

fn of(name: &str, mut value: impl FnMut(&PropertyDef) -> Option<Value>) -> Material {
    let mut material = Material::named(name);
    for def in PROPERTIES {
        material.slot_mut(def.id).value = value(def);
    }
    material
}

fn made(def: &PropertyDef, mut number: impl FnMut() -> f64, flag: bool) -> Option<Value> {
    Some(match def.default.kind() {
        Kind::Bool => Value::Bool(flag),
        Kind::Float => Value::Float(number()),
        Kind::Color => Value::Color([number(), number(), number()]),
        Kind::Normal => return None,
    })
}

/// Nothing set, everything off its default, all minima, all maxima.
pub fn extremes() -> Vec<Material> {
    let off = |def: &PropertyDef| {
        let (low, high) = (end(def, End::Low), end(def, End::High));
        let mut k = 0.0;
        // Thirds and sevenths: numbers that single precision does not hold.
        let number = || {
            k += 1.0;
            low + (high - low) * (k / 7.0 + 0.1)
        };
        made(def, number, def.default != Value::Bool(true))
    };
    vec![
        Material::named("Default"),
        of("Off default", off),
        of("Minima", |def| made(def, || end(def, End::Low), false)),
        of("Maxima", |def| made(def, || end(def, End::High), true)),
    ]
}

/// A random material, the same for the same number: a quarter of the properties is not set, the others lie anywhere in their ranges,
/// often at an end or on a 64th.
pub fn random(number: usize) -> Material {
    let mut r = Random::new(number as u64 + 1);
    of(&format!("Random {number}"), |def| {
        if r.chance(0.25) {
            return None;
        }
        let flag = r.chance(0.5);
        let (low, high) = (end(def, End::Low), end(def, End::High));
        let number = || match r.below(8) {
            0 => low,
            1 => high,
            2 => (r.between(low, high) * 64.0).round() / 64.0,
            _ => r.between(low, high),
        };
        made(def, number, flag)
    })
}
