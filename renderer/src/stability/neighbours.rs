//! Cases around a material: as it is, and with each property that it uses at both ends.

use super::Case;
use crate::scene::Scene;
use burnish_material::{Kind, Lobe, LobeSet, Material, PROPERTIES, Property, Slot, Value, idle_lobe};
use std::sync::Arc;

/// The material of the scene's document as it is (with all that its images reach), then one case for each end of each property that
/// acts in it. Names begin with `name`.
pub fn neighbours(name: &str, scene: &Scene) -> Vec<Case> {
    let mut cases = vec![Case { name: name.to_owned(), scene: scene.clone() }];
    let Some(material) = scene.objects.iter().find(|object| object.is_document).map(|object| object.material.clone()) else {
        return cases;
    };
    for def in PROPERTIES.iter().filter(|def| is_used(&material, def.id)) {
        let low = def.limits.min.unwrap_or(0.0);
        let high = def.limits.max.unwrap_or(def.limits.slider_max);
        let ends = match def.default.kind() {
            Kind::Float => [(low.to_string(), Value::Float(low)), (high.to_string(), Value::Float(high))],
            Kind::Color => [("black".into(), Value::Color([0.0; 3])), ("white".into(), Value::Color([1.0; 3]))],
            Kind::Bool | Kind::Normal => continue,
        };
        for (text, value) in ends {
            if material.slot(def.id).texture.is_none() && material.value(def.id) == value {
                continue;
            }
            let mut made = (*material).clone();
            *made.slot_mut(def.id) = Slot { value: Some(value), texture: None };
            let made = Arc::new(made);
            let mut scene = scene.clone();
            for object in scene.objects.iter_mut().filter(|object| object.is_document) {
                object.material = made.clone();
            }
            cases.push(Case { name: format!("{name}, {} {text}", def.name), scene });
        }
    }
    cases
}

/// Whether a property is set or acts, so that its ends are within reach of a slider.
fn is_used(material: &Material, property: Property) -> bool {
    let slot = material.slot(property);
    let is_set = slot.texture.is_some() || slot.value.is_some_and(|value| value != property.def().default);
    if is_set {
        return true;
    }
    let lobes = LobeSet::of(material);
    let is_common = match property {
        Property::base_color | Property::roughness | Property::metallic => true,
        Property::specular_ior => lobes.has(Lobe::specular) || lobes.has(Lobe::transmission),
        _ => {
            property.def().default.kind() == Kind::Float
                && burnish_material::LOBES.iter().any(|def| lobes.has(def.lobe) && def.properties.contains(&property))
        }
    };
    is_common && idle_lobe(material, property).is_none()
}
