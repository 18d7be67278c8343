//! Random materials for the tests of the interchange.

use burnish_material::{Kind, Material, PROPERTIES, TextureRef, Value};
use proptest::prelude::*;

/// Values of one property: inside its range, at its ends, and its default.
fn number(def: &'static burnish_material::PropertyDef) -> impl Strategy<Value = f64> {
    let low = def.limits.min.unwrap_or(0.0);
    let high = def.limits.max.unwrap_or(def.limits.slider_max);
    prop_oneof![Just(low), Just(high), low..=high, (low..=high).prop_map(|x| (x * 64.0).round() / 64.0)]
}

fn value(def: &'static burnish_material::PropertyDef) -> BoxedStrategy<Option<Value>> {
    let some = match def.default.kind() {
        Kind::Bool => any::<bool>().prop_map(Value::Bool).boxed(),
        Kind::Float => number(def).prop_map(Value::Float).boxed(),
        Kind::Normal => Just(def.default).boxed(),
        Kind::Color => [number(def), number(def), number(def)].prop_map(Value::Color).boxed(),
    };
    prop_oneof![1 => Just(None), 3 => some.prop_map(Some)].boxed()
}

/// Random materials, some of their properties with images.
pub fn material() -> impl Strategy<Value = Material> {
    let values: Vec<_> = PROPERTIES.iter().map(value).collect();
    let textured = proptest::collection::vec(0..PROPERTIES.len(), 0..4);
    (values, textured).prop_map(|(values, textured)| {
        let mut material = Material::named("random");
        for (def, value) in PROPERTIES.iter().zip(values) {
            material.slot_mut(def.id).value = value;
        }
        for place in textured {
            let property = PROPERTIES[place].id;
            material.slot_mut(property).texture = Some(TextureRef::new(format!("{}.png", property.def().name)));
        }
        material
    })
}
