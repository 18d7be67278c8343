//! Definitions of Filament's lit model: there and back, edits, and what is no number.

mod common;

use burnish_material::exchange::filament::{self, Written};
use burnish_material::exchange::filament::{FilamentError, MAX_BYTES, Read, WriteOptions, read};
use burnish_material::{Channel, Material, PROPERTIES, Property, TextureRef, Value};
use common::material;
use proptest::prelude::*;

fn write(material: &Material) -> Written {
    filament::write(material, &WriteOptions::default())
}

fn opened(text: &str) -> Read {
    read(text).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

/// The text without the native copy.
fn bare(text: &str) -> String {
    text.split_once('\n').map_or(String::new(), |(_, rest)| rest.to_owned())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn a_definition_gives_back_every_bit(mut material in material(), name in ".{0,30}") {
        material.name = name;
        let written = write(&material);
        let found = opened(&written.text);
        prop_assert!(found.is_native && found.notes.is_empty(), "{:?}\n{}", found.notes, written.text);
        prop_assert_eq!(&found.material, &material);
        prop_assert!(!written.text.contains("inf;") && !written.text.contains("NaN"));
        for bound in &written.bound {
            let parameter = format!("materialParams_{},", bound.parameter);
            prop_assert!(written.text.contains(&parameter), "{parameter}");
        }
    }

    #[test]
    fn no_text_is_too_odd(text in ".{0,200}", tail in "(material\\.|fragment|\\{|\\}|=|;|vec3\\(|//|/\\*|\\*/|0\\.5|,|\\)| |é){0,60}") {
        _ = read(&text);
        _ = read(&format!("fragment {tail}"));
    }
}

#[test]
fn plain_numbers_are_read_without_the_native_copy() {
    let mut material = Material::named("Brass");
    for (property, value) in
        [(Property::metallic, 1.0), (Property::roughness, 0.37), (Property::coat, 0.8), (Property::anisotropy, 0.5)]
    {
        material.set(property, Value::Float(value));
    }
    material.set(Property::base_color, Value::Color([0.9, 0.6, 0.2]));
    let found = opened(&bare(&write(&material).text));
    assert!(!found.is_native && found.notes.is_empty(), "{:?}", found.notes);
    assert_eq!(found.material.name, "Brass");
    for property in [Property::metallic, Property::roughness, Property::coat, Property::anisotropy, Property::base_color] {
        let (a, b) = (found.material.value(property), material.value(property));
        assert!(a.numbers().iter().zip(b.numbers()).all(|(a, b)| (a - b).abs() < 1e-9), "{a:?} {b:?}");
    }
}

#[test]
fn an_edited_number_holds_and_the_rest_stays() {
    let mut material = Material::named("a");
    material.set(Property::metallic, Value::Float(0.25)).set(Property::height_scale, Value::Float(0.1));
    let text = write(&material).text.replace("material.metallic = 0.25", "material.metallic = 0.75");
    let found = opened(&text);
    assert_eq!(found.material.float(Property::metallic), 0.75);
    assert_eq!(found.notes.len(), 1, "{:?}", found.notes);
    material.set(Property::metallic, Value::Float(0.75));
    assert_eq!(found.material, material);
}

#[test]
fn programs_are_told_and_not_run() {
    let text = "material { name : Test, shadingModel : lit }\n\
                fragment { void material(inout MaterialInputs material) {\n\
                /* material.metallic = 0.1; */ prepareMaterial(material); // material.metallic = 0.2;\n\
                material.baseColor = vec4(0.8, 0.4, 0.2, 0.5);\n\
                material.roughness = texture(materialParams_r, getUV0()).g;\n\
                material.metallic = 1.0f; material.reflectance = materialParams.reflectance;\n\
                material.clearCoatRoughness = 0.25; material.microThickness = 0.1; } }";
    let found = opened(text);
    assert_eq!(found.material.color(Property::base_color), [0.8, 0.4, 0.2]);
    assert_eq!((found.material.float(Property::opacity), found.material.float(Property::metallic)), (0.5, 1.0));
    assert_eq!((found.material.float(Property::coat), found.material.float(Property::coat_ior)), (1.0, 1.5));
    assert_eq!(found.material.name, "Test");
    assert_eq!(found.notes.len(), 3, "{:?}", found.notes);
    assert!(found.notes[0].contains("roughness") && found.notes[2].contains("microThickness"));
}

#[test]
fn what_is_no_lit_definition_is_refused() {
    assert_eq!(read("hello").unwrap_err(), FilamentError::NoFragment);
    let cloth = "material { shadingModel : cloth } fragment { }";
    assert_eq!(read(cloth).unwrap_err(), FilamentError::OtherModel { found: "cloth".to_owned() });
    assert_eq!(read(&" ".repeat(MAX_BYTES + 1)).unwrap_err(), FilamentError::TooLong { bytes: MAX_BYTES + 1 });
    let broken = "// asm: {\"version\"\nfragment { material.metallic = 1.0; }";
    let found = opened(broken);
    assert!(!found.is_native && found.notes.len() == 1 && found.material.float(Property::metallic) == 1.0);
}

#[test]
fn images_are_bound_and_placed() {
    let mut material = Material::named("a");
    let placed = TextureRef { channel: Channel::G, uv_rotation: 90.0, uv_offset: [0.5, 0.0], ..TextureRef::new("orm.png") };
    material.slot_mut(Property::metallic).texture = Some(placed);
    material.slot_mut(Property::base_color).texture = Some(TextureRef { scale: [0.5; 3], ..TextureRef::new("c.png") });
    material.slot_mut(Property::specular_level).texture = Some(TextureRef::new("l.png"));
    let written = write(&material);
    assert!(written.text.contains("baseColor.rgb = texture(materialParams_baseColorMap, getUV0()).rgb * vec3(0.5, 0.5, 0.5);"));
    assert!(written.text.contains("* getUV0() + vec2(0.5, 0.0)).g;"), "{}", written.text);
    let paths: Vec<_> = written.bound.iter().map(|bound| (bound.path.as_str(), bound.is_srgb)).collect();
    assert_eq!(paths, [("c.png", true), ("orm.png", false), ("reflectanceMap.png", false)]);
    // The reflectance follows the square root of the level.
    assert_eq!((written.jobs.len(), written.jobs[0].file.as_str()), (1, "reflectanceMap.png"));
    assert_eq!(written.rows.len(), PROPERTIES.len());
}
