//! MaterialX documents: materials there and back, edits by other programs, graphs that fold.

mod common;
#[path = "common/written.rs"]
mod written;

use burnish_material::exchange::ShadingModel;
use burnish_material::exchange::loss::Fate;
use burnish_material::exchange::materialx::{SURFACES, Surface, read, write};
use burnish_material::{Channel, ColorSpace, Kind, Material, PROPERTIES, Property, Provenance, TextureRef, Value, Vary, Wrap};
use proptest::prelude::*;
use written::{one, options, text, without_native_copy};

/// The models of MaterialX's surfaces.
fn surfaces() -> impl Iterator<Item = &'static ShadingModel> {
    SURFACES.iter().map(|surface| surface.model)
}

/// A material with every property at what `f` makes of its range.
fn at(f: impl Fn(f64, f64) -> f64, switches: bool) -> Material {
    let mut material = Material::named("All of them");
    for def in PROPERTIES {
        let (low, high) = (def.limits.min.unwrap_or(0.0), def.limits.max.unwrap_or(def.limits.slider_max));
        let x = f(low, high);
        material.slot_mut(def.id).value = match def.default {
            Value::Color(_) => Some(Value::Color([x, f(low, 0.9 * high), f(low, 0.8 * high)])),
            Value::Float(_) => Some(Value::Float(x)),
            Value::Bool(_) => Some(Value::Bool(switches)),
            Value::Normal(_) => None,
        };
    }
    material
}

fn corners() -> [Material; 4] {
    [
        Material::named("default"),
        at(|low, _| low, false),
        at(|_, high| high, true),
        at(|low, high| low + 0.371 * (high - low), true),
    ]
}

/// Random settings of an image.
fn texture() -> impl Strategy<Value = TextureRef> {
    let numbers =
        (prop::array::uniform3(-2.0..2.0_f64), prop::array::uniform3(-1.0..1.0_f64), prop::array::uniform2(0.1..9.0_f64));
    let places = (prop::array::uniform2(-3.0..3.0_f64), prop_oneof![Just(0.0), Just(90.0), -400.0..400.0_f64]);
    (0..5_usize, 0..3_usize, 0..3_usize, any::<bool>(), any::<bool>(), numbers, places).prop_map(
        |(channel, space, wrap, is_inverted, is_scaled, (scale, bias, uv_scale), (uv_offset, uv_rotation))| {
            let plain = TextureRef {
                channel: Channel::ALL[channel].0,
                color_space: ColorSpace::ALL[space].0,
                wrap: Wrap::ALL[wrap].0,
                is_inverted,
                ..TextureRef::new("tex/a & b.png")
            };
            if is_scaled { TextureRef { scale, bias, uv_scale, uv_offset, uv_rotation, ..plain } } else { plain }
        },
    )
}

/// Random materials with digits beyond single precision, texts, and images with settings.
fn material() -> impl Strategy<Value = Material> {
    let textures = proptest::collection::vec((0..PROPERTIES.len(), texture()), 0..5);
    (common::material(), textures, ".{0,40}", proptest::option::of(0.1..2000.0_f64)).prop_map(
        |(mut material, textures, words, unit)| {
            for (place, texture) in textures {
                material.slot_mut(PROPERTIES[place].id).texture = Some(texture);
            }
            material.name = words.clone();
            material.notes = format!("first line\nsecond \"line\" <{words}>\t&amp;");
            (material.tags, material.aliases, material.unit_mm) =
                (vec![words.clone(), "b".to_owned()], vec![words.clone()], unit);
            material.provenance =
                Provenance { source: words.clone(), reference: "r".to_owned(), method: words, licence: "CC0".to_owned() };
            material
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 80, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn a_document_gives_back_every_bit(material in material()) {
        for model in surfaces() {
            let written = text(&material, model);
            let found = one(&written);
            prop_assert!(found.is_native);
            prop_assert_eq!(&found.material, &material, "{}: {:?}", model.name, found.notes);
            prop_assert!(found.notes.is_empty(), "{}: {:?}", model.name, found.notes);
            prop_assert_eq!(written, text(&material, model), "written twice");
        }
    }

    #[test]
    fn what_is_called_exact_comes_back_from_the_surface(mut material in common::material()) {
        for def in PROPERTIES {
            material.slot_mut(def.id).texture = None;
        }
        for Surface { node, model } in SURFACES {
            let written = write(&[&material], &options(model));
            let found = one(&without_native_copy(&written.text));
            prop_assert!(!found.is_native && found.surface == *node);
            for row in written.materials[0].rows.iter().filter(|row| row.fate <= Fate::Remapped) {
                let (a, b) = (material.value(row.property), found.material.value(row.property));
                let near = a.numbers().iter().zip(b.numbers()).all(|(a, b)| (a - b).abs() <= 1e-4 * a.abs().max(1.0));
                let same = if let (Value::Bool(a), Value::Bool(b)) = (a, b) { a == b } else { near };
                prop_assert!(same, "{}: {}: {a:?} became {b:?}", model.name, row.property.def().name);
            }
        }
    }

    #[test]
    fn an_image_comes_back_from_the_surface(texture in texture()) {
        // Of a number, red stands for all channels; a turn more is no turn.
        for (property, channel) in [(Property::base_color, texture.channel), (Property::coat, Channel::R)] {
            let mut material = Material::named("a");
            let texture = TextureRef { channel: if texture.channel == Channel::Rgb { channel } else { texture.channel }, ..texture.clone() };
            material.slot_mut(property).texture = Some(texture.clone());
            let found = one(&without_native_copy(&text(&material, SURFACES[0].model)));
            let back = found.material.slot(property).texture.clone().expect("an image");
            prop_assert_eq!((&back.path, back.channel, back.wrap), (&texture.path, texture.channel, texture.wrap));
            let count = if property == Property::coat { 1 } else { 3 };
            for k in 0..count {
                for x in [0.0, 0.25, 1.0] {
                    let x_of = |t: &TextureRef| t.scale[k] * if t.is_inverted { 1.0 - x } else { x } + t.bias[k];
                    prop_assert!((x_of(&back) - x_of(&texture)).abs() < 1e-5, "{back:?} {texture:?}");
                }
            }
            for uv in [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.3, -0.7]] {
                let (a, b) = (placed(&back, uv), placed(&texture, uv));
                prop_assert!((a[0] - b[0]).abs() < 1e-4 && (a[1] - b[1]).abs() < 1e-4, "{back:?} {texture:?}");
            }
        }
    }
}

/// Coordinates in an image: scaled, turned counterclockwise, shifted.
fn placed(texture: &TextureRef, uv: [f64; 2]) -> [f64; 2] {
    let (sin, cos) = texture.uv_rotation.to_radians().sin_cos();
    let [u, v] = [uv[0] * texture.uv_scale[0], uv[1] * texture.uv_scale[1]];
    [u * cos - v * sin + texture.uv_offset[0], u * sin + v * cos + texture.uv_offset[1]]
}

#[test]
fn corners_of_the_ranges_come_back_and_several_share_a_document() {
    let materials = corners();
    for model in surfaces() {
        let written = write(&materials.iter().collect::<Vec<_>>(), &options(model));
        let found = read(&written.text).expect("our own document");
        assert_eq!(found.iter().map(|found| &found.material).collect::<Vec<_>>(), materials.iter().collect::<Vec<_>>());
        let names: Vec<_> = written.materials.iter().map(|material| material.name.as_str()).collect();
        assert_eq!(names, ["default", "All_of_them", "All_of_them_2", "All_of_them_3"]);
        for material in &materials {
            assert_eq!(&one(&text(material, model)).material, material);
        }
    }
}

/// Replaces the value of an input of the node with this tag.
fn edited(text: &str, tag: &str, input: &str, value: &str) -> String {
    let node = text.rfind(&format!("<{tag} name=")).expect("the node");
    let start = node + text[node..].find(&format!("<input name=\"{input}\"")).expect("the input");
    let start = start + text[start..].find("value=\"").expect("a value") + 7;
    let end = start + text[start..].find('"').expect("its end");
    format!("{}{value}{}", &text[..start], &text[end..])
}

#[test]
fn an_edited_surface_changes_its_properties_alone() {
    let material = at(|low, high| low + 0.371 * (high - low), false);
    let (model, written) = (SURFACES[0].model, text(&material, SURFACES[0].model));
    for (input, value, property, expected) in [
        ("base_color", "0.1, 0.2, 0.3", Property::base_color, Value::Color([0.1, 0.2, 0.3])),
        ("specular_ior", "1.9", Property::specular_ior, Value::Float(1.9)),
        ("coat_weight", "1", Property::coat, Value::Float(1.0)),
        ("emission_luminance", "500", Property::emission, Value::Float(0.5)),
    ] {
        let found = one(&edited(&written, model.name, input, value));
        assert_eq!(found.material.value(property), expected, "{input}");
        assert_eq!(found.notes.len(), 1, "{:?}", found.notes);
        let def = model.fields.iter().find(|def| def.name == input).expect("a parameter");
        for (other, slot) in material.slots().filter(|(other, _)| !def.to.contains(other)) {
            assert_eq!(found.material.slot(other), slot, "{input} changed {}", other.def().name);
        }
    }
    // The copy itself is edited, and the digits beyond single precision hold only beside their own number.
    let mut fine = material.clone();
    fine.set(Property::roughness, Value::Float(0.1 + 0.2));
    let written = text(&fine, model);
    assert!(written.contains("name=\"roughness\" type=\"float\" value=\"0.3\" asm_wide=\"0.30000000000000004\""));
    assert_eq!(one(&written).material, fine);
    let found = one(&edited(&written, "adobe_standard_material", "roughness", "0.5"));
    assert_eq!(found.material.float(Property::roughness), 0.5);
    fine.set(Property::roughness, Value::Float(0.5));
    assert_eq!(found.material, fine);
}

#[test]
fn a_copy_that_cannot_be_read_leaves_its_place_to_the_surface() {
    let mut material = Material::named("a");
    material.set(Property::roughness, Value::Float(0.7)).set(Property::metallic, Value::Float(0.25));
    let written = text(&material, SURFACES[0].model);
    for value in ["smooth", "nan", "1e400", "0.1, 0.2"] {
        let found = one(&edited(&written, "adobe_standard_material", "roughness", value));
        assert_eq!(found.material.float(Property::roughness), 0.7, "{value}");
        assert_eq!(found.notes.len(), 2, "{:?}", found.notes);
    }
    let found = one(&written.replace("type=\"surfaceshader\" version=\"4.0\" asm", "type=\"surfaceshader\" version=\"5.0\" asm"));
    assert!(!found.is_native && found.notes[0].contains("5.0"), "{:?}", found.notes);
    assert_eq!(found.material.float(Property::roughness), 0.7);
    // A record that is no JSON costs what only it holds.
    let start = written.find("asm_record=\"").expect("a record") + 12;
    let end = start + written[start..].find('"').expect("its end");
    let found = one(&format!("{}{{{{{}", &written[..start], &written[end..]));
    assert!(found.is_native && !found.notes.is_empty());
    assert_eq!(found.material.float(Property::roughness), 0.7);
    assert_eq!(found.material.float(Property::metallic), 0.25);
}

#[test]
fn what_asm_has_no_place_for_goes_back_while_its_neighbours_stay() {
    let source = "<materialx version=\"1.39\"><open_pbr_surface name=\"s\" type=\"surfaceshader\">
        <input name=\"thin_film_weight\" type=\"float\" value=\"0.75\" /><input name=\"coat_weight\" type=\"float\" value=\"1\" />
        <input name=\"geometry_thin_walled\" type=\"boolean\" value=\"true\" /></open_pbr_surface>
        <surfacematerial name=\"pearl\" type=\"material\"><input name=\"surfaceshader\" type=\"surfaceshader\" nodename=\"s\" /></surfacematerial></materialx>";
    let mut material = one(source).material;
    let written = text(&material, SURFACES[0].model);
    for input in [
        "name=\"thin_film_weight\" type=\"float\" value=\"0.75\"",
        "name=\"geometry_thin_walled\" type=\"boolean\" value=\"true\"",
        "name=\"coat_darkening\" type=\"float\" value=\"1\"",
    ] {
        assert_eq!(written.matches(input).count(), 1, "{input}");
    }
    let found = one(&written);
    assert_eq!((&found.material, &found.notes), (&material, &Vec::new()));
    assert!(!text(&material, SURFACES[1].model).contains("thin_film_weight\" type"), "another surface has no such input");
    material.set(Property::specular_level, Value::Float(0.1));
    material.set(Property::coat_roughness, Value::Float(0.2));
    let written = text(&material, SURFACES[0].model);
    assert!(
        !written.contains("thin_film_weight\" type") && written.contains("name=\"coat_darkening\" type=\"float\" value=\"0\"")
    );
    assert_eq!(one(&written).material, material);
}

#[test]
fn textured_properties_of_every_kind_come_back() {
    let mut material = Material::named("textured");
    for def in PROPERTIES.iter().filter(|def| def.vary != Vary::Uniform) {
        let mut texture = TextureRef::new(format!("{}.png", def.name));
        texture.is_inverted = def.default.kind() == Kind::Normal;
        material.slot_mut(def.id).texture = Some(texture);
        material.slot_mut(def.id).value = Some(def.default);
    }
    for model in surfaces() {
        let found = one(&text(&material, model));
        assert_eq!((&found.material, &found.notes), (&material, &Vec::new()), "{}", model.name);
    }
}
