//! Which values of a material put a lobe in or leave it out.

use burnish_material::{Lobe, LobeSet, Material, PROPERTIES, Property, Slot, Value};

/// The values, in words: `coat is 0`. Empty where no single value and no pair of them decides.
pub fn switched_by(material: &Material, lobe: Lobe) -> String {
    let is_in = LobeSet::of(material).has(lobe);
    let flips = |material: &Material, property: Property| {
        others(property).into_iter().any(|slot| {
            let mut changed = material.clone();
            *changed.slot_mut(property) = slot;
            LobeSet::of(&changed).has(lobe) != is_in
        })
    };
    let properties = || PROPERTIES.iter().map(|def| def.id);
    let alone: Vec<Property> = properties().filter(|property| flips(material, *property)).collect();
    let named = |properties: &[Property], joint: &str| {
        let words: Vec<String> = properties.iter().map(|p| words(material, *p)).collect();
        words.join(joint)
    };
    if !alone.is_empty() {
        // Any of them leaves it out; all of them together put it in.
        return named(&alone, " and ");
    }
    for first in properties() {
        for slot in others(first) {
            let mut changed = material.clone();
            *changed.slot_mut(first) = slot;
            if let Some(second) = properties().find(|second| *second != first && flips(&changed, *second)) {
                return named(&[first, second], " and ");
            }
        }
    }
    String::new()
}

/// What else could stand in a slot: enough to reach both sides of every switch.
fn others(property: Property) -> Vec<Slot> {
    let def = property.def();
    let slot = |value| Slot { value: Some(value), texture: None };
    match def.default {
        Value::Float(x) => [0.0, 1.0, x, 0.5 * (def.limits.slider_max + x)].map(|x| slot(Value::Float(x))).into(),
        Value::Color(_) => [[0.0; 3], [0.5; 3], [1.0; 3]].map(|c| slot(Value::Color(c))).into(),
        Value::Bool(_) => [false, true].map(|x| slot(Value::Bool(x))).into(),
        Value::Normal(_) => [[0.0, 0.0, 1.0], [0.6, 0.0, 0.8]].map(|n| slot(Value::Normal(n))).into(),
    }
}

fn words(material: &Material, property: Property) -> String {
    let name = property.def().name;
    if let Some(texture) = &material.slot(property).texture {
        return format!("{name} has the image {}", texture.path);
    }
    match material.value(property) {
        Value::Float(x) => format!("{name} is {x}"),
        Value::Bool(x) => format!("{name} is {}", if x { "on" } else { "off" }),
        Value::Color(v) | Value::Normal(v) => format!("{name} is ({}, {}, {})", v[0], v[1], v[2]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use burnish_material::LOBES;

    #[test]
    fn every_lobe_names_what_switches_it() {
        let plain = Material::named("plain");
        for def in LOBES.iter().filter(|def| def.lobe != Lobe::textures) {
            assert!(!switched_by(&plain, def.lobe).is_empty(), "{}", def.name);
        }
        assert_eq!(switched_by(&plain, Lobe::coat), "coat is 0");
        assert_eq!(switched_by(&plain, Lobe::metal), "metallic is 0");
        assert!(switched_by(&plain, Lobe::dispersion).contains("translucency is 0"));
        let mut coated = plain;
        coated.set(Property::coat, Value::Float(0.25));
        assert_eq!(switched_by(&coated, Lobe::coat), "coat is 0.25");
    }
}
