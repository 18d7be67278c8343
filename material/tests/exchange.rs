//! Every shading model of the interchange: the way there, the way back, and the native copy that makes both exact.

mod common;

use burnish_material::exchange::loss::Fate;
use burnish_material::exchange::model::{Context, Notes};
use burnish_material::exchange::{MODELS, merge, native};
use burnish_material::{Material, PROPERTIES, Property, Value};
use common::material;
use proptest::prelude::*;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn the_native_copy_gives_back_every_bit(material in material()) {
        for model in MODELS {
            let context = Context::of(&material);
            let translation = model.translate(&material, &context);
            let json = native::write(&material, Some((model.fields, &translation.fields))).to_string();
            let mut notes = Notes::new();
            let json = serde_json::from_str(&json).expect("our own JSON");
            let read = native::read(&json, Some(model.fields), &mut notes).expect("our own copy");
            prop_assert_eq!(&read.material, &material);
            let merged = merge::merge(model, &read, &translation.fields, &context, &mut notes);
            prop_assert_eq!(&merged, &material, "{}", model.name);
            // Without the record, what the copy means is translated again.
            let read = native::Native { translation: None, ..read };
            prop_assert_eq!(&merge::merge(model, &read, &translation.fields, &context, &mut notes), &material);
            prop_assert!(notes.is_empty(), "{notes:?}");
        }
    }

    #[test]
    fn what_is_called_exact_comes_back_without_the_native_copy(mut material in material()) {
        for def in PROPERTIES {
            material.slot_mut(def.id).texture = None;
        }
        for model in MODELS {
            let context = Context::of(&material);
            let translation = model.translate(&material, &context);
            let back = model.interpret(&translation.fields, &context, &mut Notes::new());
            for row in translation.rows.iter().filter(|row| row.fate <= Fate::Remapped) {
                let (a, b) = (material.value(row.property), back.value(row.property));
                let near = a.numbers().iter().zip(b.numbers()).all(|(a, b)| (a - b).abs() <= 1e-4 * a.abs().max(1.0));
                let same = match (a, b) { (Value::Bool(a), Value::Bool(b)) => a == b, _ => near };
                prop_assert!(same, "{}: {}: {a:?} became {b:?}, said to be {}", model.name, row.property.def().name, row.fate.word());
            }
        }
    }

    #[test]
    fn one_changed_parameter_changes_its_properties_alone(material in material(), place in 0..1000_usize) {
        for model in MODELS {
            let context = Context::of(&material);
            let mut fields = model.translate(&material, &context).fields;
            let native = native::Native { material: material.clone(), translation: Some(fields.clone()) };
            let place = place % model.fields.len();
            let (def, field) = (&model.fields[place], &mut fields.0[place]);
            let nudge = |x: f64| if x < 0.5 { x + 0.25 } else { x - 0.25 };
            field.value = match field.value {
                Value::Bool(on) => Value::Bool(!on),
                Value::Float(x) => Value::Float(nudge(x)),
                Value::Color(v) => Value::Color(v.map(nudge)),
                Value::Normal(_) => continue,
            };
            (field.texture, field.is_authored) = (None, true);
            let merged = merge::merge(model, &native, &fields, &context, &mut Notes::new());
            for (property, slot) in material.slots().filter(|(property, _)| !def.to.contains(property)) {
                prop_assert_eq!(slot, merged.slot(property), "{}: {} changed {}", model.name, def.name, property.def().name);
            }
        }
    }
}

#[test]
fn every_model_tells_of_every_property_once() {
    for model in MODELS {
        for def in PROPERTIES {
            let count = model.cells.iter().filter(|cell| cell.property == def.id).count();
            assert_eq!(count, 1, "{}: {}", model.name, def.name);
        }
        let inputs = Material::default().inputs();
        let context = Context::of(&Material::default());
        let values = (model.translate)(&inputs, &context);
        assert_eq!(values.len(), model.fields.len());
        for (def, value) in model.fields.iter().zip(&values) {
            assert_eq!(def.default.kind(), value.kind(), "{}: {}", model.name, def.name);
        }
    }
}

#[test]
fn a_copy_that_is_wrong_costs_notes_and_no_values() {
    let mut notes = Notes::new();
    let json = serde_json::json!({ "version": "5.0", "properties": {} });
    assert!(native::read(&json, None, &mut notes).is_none() && notes.len() == 1);
    let json = serde_json::json!({ "version": "4.0", "properties": { "roughness": "smooth", "metallic": 1, "velvet": 2 } });
    let read = native::read(&json, None, &mut notes).expect("a native copy");
    assert_eq!(read.material.float(Property::metallic), 1.0);
    assert!(read.material.slot(Property::roughness).value.is_none());
    assert_eq!(notes.len(), 3, "{notes:?}");
}

/// Properties whose number a model keeps, for a material with every property off its default.
#[test]
fn what_the_mapping_calls_exact_is_found_exact() {
    let kept = [
        (
            "open_pbr_surface",
            "base_color roughness metallic opacity anisotropy anisotropy_rotation emission emission_color translucency \
             specular_ior dispersion absorption_color absorption_distance scatter scatter_color coat coat_color coat_roughness \
             height_scale sheen_color normal coat_normal",
        ),
        (
            "standard_surface",
            "base_color roughness metallic opacity anisotropy anisotropy_rotation emission emission_color translucency specular_ior \
             dispersion absorption_color absorption_distance scatter scatter_color coat coat_color coat_roughness height_scale \
             sheen_color normal coat_normal",
        ),
        (
            "disney_principled",
            "roughness metallic anisotropy specular_level specular_ior translucency scatter coat coat_roughness",
        ),
        (
            "gltf",
            "base_color roughness metallic opacity anisotropy anisotropy_rotation emission emission_color specular_ior dispersion scatter \
              coat coat_color coat_roughness coat_ior coat_specular_level volume_thickness_scale",
        ),
        ("usd_preview_surface", "base_color roughness metallic normal coat coat_roughness ambient_occlusion"),
        (
            "filament",
            "roughness metallic opacity specular_level anisotropy anisotropy_rotation specular_ior coat coat_roughness \
             ambient_occlusion volume_thickness normal coat_normal",
        ),
        (
            "dassault_enterprise_pbr",
            "roughness metallic opacity specular_level anisotropy anisotropy_rotation emission emission_color translucency \
             specular_ior dispersion scatter coat coat_roughness normal coat_normal",
        ),
        ("specular_glossiness", "roughness opacity normal height ambient_occlusion"),
    ];
    let mut material = Material::named("off");
    for (property, value) in [
        (Property::roughness, 0.37),
        (Property::metallic, 0.25),
        (Property::opacity, 0.9),
        (Property::anisotropy, 0.6),
        (Property::anisotropy_rotation, 0.7),
        (Property::emission, 2.5),
        (Property::translucency, 0.6),
        (Property::specular_ior, 1.52),
        (Property::dispersion, 1.36),
        (Property::absorption_distance, 12.5),
        (Property::coat, 0.8),
        (Property::coat_roughness, 0.05),
        (Property::coat_ior, 1.7),
        (Property::height_scale, 0.125),
        (Property::specular_level, 0.4),
    ] {
        material.set(property, Value::Float(value));
    }
    for property in [
        Property::base_color,
        Property::absorption_color,
        Property::scatter_color,
        Property::coat_color,
        Property::emission_color,
    ] {
        material.set(property, Value::Color([0.9, 0.5, 0.2]));
    }
    material.set(Property::scatter, Value::Bool(true));
    for (name, kept) in kept {
        let model = burnish_material::exchange::ShadingModel::named(name).expect("a model of this name");
        let rows = model.translate(&material, &Context::of(&material)).rows;
        for property in kept.split_whitespace() {
            let row = rows.iter().find(|row| row.property.def().name == property).expect("a row for each property");
            assert!(row.fate <= Fate::Remapped, "{name}: {row:?}");
        }
    }
}
