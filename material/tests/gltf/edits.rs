//! What happens to a file between writing and reading: edits of one value, other programs' copies, the same file again.

use burnish_material::exchange::field::FieldDef;
use burnish_material::exchange::gltf::{Options, Part, write};
use burnish_material::exchange::model::Context;
use burnish_material::exchange::models::gltf::MODEL;
use burnish_material::{Material, Property, TextureRef, Value};
use serde_json::{Value as Json, json};

use super::{common, gltf, least, most, off_default, only, opened, parsed, written};
use proptest::prelude::*;

/// Every number in a material's JSON, with its place; the native copy left out.
fn numbers(json: &Json, place: &str, all: &mut Vec<String>) {
    match json {
        Json::Number(_) if !place.contains("Texture") => all.push(place.to_owned()),
        Json::Array(list) => list.iter().enumerate().for_each(|(k, json)| numbers(json, &format!("{place}/{k}"), all)),
        Json::Object(entries) => {
            for (key, json) in entries.iter().filter(|(key, _)| *key != "extras") {
                numbers(json, &format!("{place}/{key}"), all);
            }
        }
        _ => {}
    }
}

/// The parameter that a place in a material belongs to.
fn owner(place: &str) -> &'static FieldDef {
    let name = place.trim_start_matches('/').trim_start_matches("extensions/").replace('/', ".");
    let name = match name.as_str() {
        "pbrMetallicRoughness.baseColorFactor.3" => "pbrMetallicRoughness.baseColorFactor.alpha",
        name => name,
    };
    let fits = |def: &&FieldDef| name == def.name || name.strip_prefix(def.name).is_some_and(|rest| rest.parse::<f64>().is_ok());
    MODEL.fields.iter().find(fits).unwrap_or_else(|| panic!("a parameter at {place}"))
}

fn check_edits(material: &Material) {
    let json = gltf(material);
    let mut places = Vec::new();
    numbers(&json["materials"][0], "", &mut places);
    assert!(places.len() >= 4, "{places:?}");
    for place in places {
        let mut edited = json.clone();
        let number = edited["materials"][0].pointer_mut(&place).expect("a place that was just found");
        let old = number.as_f64().expect("a number");
        *number = json!(if old < 0.5 { old + 0.25 } else { old - 0.25 });
        let (back, notes) = only(&edited);
        let def = owner(&place);
        // Alpha is nothing to an opaque material.
        let is_ignored = def.name.ends_with("alpha") && json["materials"][0].get("alphaMode").is_none();
        assert_eq!(notes.is_empty(), is_ignored, "{place}");
        for (property, slot) in material.slots().filter(|(property, _)| !def.to.contains(property)) {
            assert_eq!(slot, back.slot(property), "{place} changed {}", property.def().name);
        }
        // A difference below single precision is no edit.
        let mut stored = json.clone();
        *stored["materials"][0].pointer_mut(&place).expect("a place that was just found") = json!(f64::from(old as f32));
        assert_eq!(only(&stored), (material.clone(), Vec::new()), "{place}");
    }
}

#[test]
fn an_edited_number_changes_its_properties_alone() {
    for material in [Material::named("Plain"), off_default(), least(), most()] {
        check_edits(&material);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(20))]

    #[test]
    fn an_edited_number_changes_its_properties_alone_in_any_material(mut material in common::material()) {
        material.unit_mm = Some(1000.0);
        check_edits(&material);
    }
}

#[test]
fn an_edit_means_what_the_format_says() {
    let mut material = off_default();
    material.set(Property::translucency, Value::Float(0.0));
    let mut json = gltf(&material);
    json["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"] = json!([0.1, 0.2, 0.3, 0.25]);
    json["materials"][0]["extensions"]["KHR_materials_ior"]["ior"] = json!(2.0);
    json["materials"][0]["name"] = json!("Renamed");
    let (back, notes) = only(&json);
    assert_eq!(back.color(Property::base_color), [0.1, 0.2, 0.3]);
    assert_eq!(back.float(Property::opacity), 0.25);
    assert_eq!(back.float(Property::specular_ior), 2.0);
    assert_eq!(back.name, "Renamed");
    assert_eq!(notes.iter().filter(|note| note.contains("another program")).count(), 4, "{notes:?}");
    material.name = "Renamed".to_owned();
    for property in [Property::base_color, Property::opacity, Property::specular_ior] {
        material.slot_mut(property).value = back.slot(property).value;
    }
    assert_eq!(back, material);
}

#[test]
fn a_removed_image_is_removed_here() {
    let mut json = gltf(&off_default());
    json["materials"][0].as_object_mut().expect("a material").shift_remove("normalTexture");
    let (back, notes) = only(&json);
    assert!(back.slot(Property::normal).texture.is_none());
    assert!(back.slot(Property::roughness).texture.is_some());
    assert!(!notes.is_empty());
}

#[test]
fn a_native_copy_of_another_version_is_not_trusted() {
    let mut json = gltf(&off_default());
    json["materials"][0]["extras"]["asm"]["version"] = json!("5.0");
    let (back, notes) = only(&json);
    assert!(notes[0].contains("5.0"), "{notes:?}");
    assert_eq!(back.slot(Property::height_scale).value, None);
    for copy in [json!(3), json!([]), json!({ "version": "4.0" })] {
        json["materials"][0]["extras"]["asm"] = copy;
        assert!(opened(json.to_string().as_bytes()).materials[0].native.is_none());
    }
}

#[test]
fn images_of_a_native_copy_stay_beside_the_document() {
    let mut json = gltf(&off_default());
    for path in ["/etc/passwd", "../a.png", "https://a/b.png", "C:\\a.png"] {
        json["materials"][0]["extras"]["asm"]["textures"]["normal"]["path"] = json!(path);
        let (back, notes) = only(&json);
        assert!(back.slot(Property::normal).texture.is_none());
        assert!(notes.iter().any(|note| note.starts_with("native copy: normal: expected a relative path")), "{notes:?}");
    }
}

#[test]
fn several_materials_share_images_and_come_back_in_order() {
    let mut second = off_default();
    second.name = "Second".to_owned();
    second.slot_mut(Property::height).texture = Some(TextureRef::new("tex/normal.png"));
    let materials = [off_default(), second, Material::named("Third")];
    let contexts: Vec<_> = materials.iter().map(Context::of).collect();
    let translations: Vec<_> = materials.iter().zip(&contexts).map(|(m, c)| MODEL.translate(m, c)).collect();
    let parts = materials.iter().zip(&translations).zip(&contexts);
    let parts: Vec<_> =
        parts.map(|((material, translation), context)| Part { material, translation, context: *context }).collect();
    let written = write(&parts, None, &Options::default()).expect("no mesh");
    assert_eq!(written, write(&parts, None, &Options::default()).expect("no mesh"));
    assert_eq!(written.plan.copies.len(), 2);
    let document = opened(written.gltf("").as_bytes());
    let back: Vec<_> = document.materials.iter().map(|found| found.material().0).collect();
    assert_eq!(back, materials);
}

#[test]
fn the_same_material_makes_the_same_bytes() {
    let one = written(&off_default(), None, &Options::default());
    assert_eq!(one.gltf(""), written(&off_default(), None, &Options::default()).gltf(""));
    let again = only(&parsed(&one)).0;
    assert_eq!(one.gltf(""), written(&again, None, &Options::default()).gltf(""));
}
