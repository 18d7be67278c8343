//! What stands in a MaterialX document: our own node with its graph, images to compute, names.

mod common;
#[path = "common/written.rs"]
mod written;

use burnish_material::exchange::materialx::{WriteOptions, read, write};
use burnish_material::exchange::plan::{Job, Texel};
use burnish_material::exchange::{MODELS, ShadingModel};
use burnish_material::{Material, PROPERTIES, Property, TextureRef, Value};
use proptest::prelude::*;
use written::{one, options, text, without_native_copy};

#[test]
fn what_is_not_finite_is_never_written() {
    let mut material = Material::named("broken");
    material.set(Property::roughness, Value::Float(f64::NAN));
    material.set(Property::emission, Value::Float(f64::INFINITY));
    material.set(Property::height, Value::Float(1e300));
    let mut image = TextureRef::new("a.png");
    image.scale[1] = f64::NAN;
    material.slot_mut(Property::metallic).texture = Some(image);
    let written = write(&[&material], &WriteOptions::default());
    assert!(!written.text.contains("NaN") && !written.text.contains("inf\""));
    assert_eq!(written.materials[0].notes.len(), 3, "{:?}", written.materials[0].notes);
    let found = one(&written.text);
    assert_eq!(found.material.float(Property::height), 1e300);
    assert!(found.material.slot(Property::roughness).value.is_none() && found.material.is_textured(Property::metallic));
}

#[test]
fn images_that_no_file_holds_are_planned() {
    let mut material = Material::named("Two maps");
    for (property, path) in [(Property::roughness, "r.png"), (Property::anisotropy, "a.png"), (Property::metallic, "m.png")] {
        material.slot_mut(property).texture = Some(TextureRef::new(path));
    }
    material.slot_mut(Property::specular_level).texture = Some(TextureRef::new("l.png"));
    let options = WriteOptions { folder: "maps/", path: &|path| format!("images/{path}"), ..WriteOptions::default() };
    let written = write(&[&material], &options);
    let factor = |image: &Job| match image.channels[0] {
        Texel::Number { factor, .. } => factor,
        other => panic!("{other:?}"),
    };
    let planned: Vec<_> = written.materials[0].images.iter().map(|image| (image.file.as_str(), factor(image))).collect();
    let expected = [
        ("maps/Two_maps_specular_weight.png", 2.0),
        ("maps/Two_maps_specular_roughness.png", 1.0),
        ("maps/Two_maps_specular_roughness_anisotropy.png", 1.0),
    ];
    assert_eq!(planned, expected);
    for file in ["maps/Two_maps_specular_weight.png", "images/m.png", "images/r.png"] {
        assert!(written.text.contains(&format!("value=\"{file}\"")), "{file}");
    }
    let found = one(&written.text);
    assert_eq!(found.notes, Vec::<String>::new());
    assert_eq!(found.material.slot(Property::roughness).texture.as_ref().map(|t| t.path.as_str()), Some("images/r.png"));
}

#[test]
fn textures_of_the_program_keep_their_name_in_the_copy() {
    let mut material = Material::named("oak");
    material.slot_mut(Property::base_color).texture = Some(TextureRef::new("builtin:wood-oak/base_color"));
    let options = WriteOptions { path: &|path| path.replace("builtin:wood-oak/", "oak_") + ".png", ..WriteOptions::default() };
    let written = write(&[&material], &options).text;
    assert!(written.contains("value=\"oak_base_color.png\""));
    assert_eq!(one(&written).material, material);
    let other = written.replace("value=\"oak_base_color.png\"", "value=\"pine.png\"");
    let found = one(&other).material;
    assert_eq!(found.slot(Property::base_color).texture.as_ref().map(|t| t.path.as_str()), Some("pine.png"));
}

#[test]
fn every_input_reaches_the_surface_where_it_can() {
    let written = text(&Material::named("a"), MODELS[0]);
    let graph = &written[written.find("<nodegraph").expect("the graph")..written.find("</nodegraph>").expect("its end")];
    let unused = [
        "combine_normal_and_height",
        "height",
        "height_scale",
        "height_level",
        "ambient_occlusion",
        "volume_thickness",
        "volume_thickness_scale",
    ];
    for def in PROPERTIES {
        let is_used = graph.contains(&format!("interfacename=\"{}\"", def.name));
        assert_eq!(is_used, !unused.contains(&def.name), "{}", def.name);
        assert!(written.contains(&format!("<input name=\"{}\" type=", def.name)));
    }
    // Nothing in the graph refers to what does not exist, and nothing in it is left over.
    for name in graph.split("nodename=\"").skip(1).filter_map(|rest| rest.split('"').next()) {
        assert!(graph.contains(&format!(" name=\"{name}\" type=")), "{name}");
    }
    for name in graph
        .lines()
        .filter(|line| !line.contains("<input") && !line.contains("<output"))
        .filter_map(|line| line.split(" name=\"").nth(1)?.split('"').next())
    {
        assert!(name.starts_with("NG_") || graph.contains(&format!("nodename=\"{name}\"")), "{name} is not used");
    }
}

/// The graph of our node with the material's values as its inputs, as a material of its own.
fn implementation(material: &Material) -> String {
    let written = text(material, MODELS[0]);
    let (start, end) = (written.find("<nodegraph").expect("the graph"), written.find("</nodegraph>").expect("its end"));
    let body = &written[start + written[start..end].find('>').expect("its tag") + 1..end];
    let inputs: String = PROPERTIES
        .iter()
        .map(|def| match material.value(def.id) {
            Value::Color([r, g, b]) => format!("<input name=\"{}\" type=\"color3\" value=\"{r}, {g}, {b}\" />", def.name),
            Value::Float(x) => format!("<input name=\"{}\" type=\"float\" value=\"{x}\" />", def.name),
            Value::Bool(on) => format!("<input name=\"{}\" type=\"boolean\" value=\"{on}\" />", def.name),
            Value::Normal(_) => String::new(),
        })
        .collect();
    format!(
        "<materialx version=\"1.39\" colorspace=\"lin_rec709\"><nodegraph name=\"g\">{inputs}{body}</nodegraph><surfacematerial name=\"m\">
         <input name=\"surfaceshader\" type=\"surfaceshader\" nodegraph=\"g\" output=\"out\" /></surfacematerial></materialx>"
    )
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 80, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn the_graph_of_our_node_computes_the_translation(mut material in common::material(), translucency in 0.05..1.0_f64) {
        for def in PROPERTIES {
            material.slot_mut(def.id).texture = None;
        }
        // Where nothing scatters, the graph may say what it likes about the paths.
        material.set(Property::scatter, Value::Bool(true)).set(Property::translucency, Value::Float(translucency));
        let expected = one(&without_native_copy(&text(&material, MODELS[0]))).material;
        let found = one(&implementation(&material)).material;
        for def in PROPERTIES.iter().filter(|def| !["normal_scale", "coat_normal_scale", "height", "height_scale"].contains(&def.name)) {
            let (a, b) = (expected.value(def.id), found.value(def.id));
            // The lobe's width follows the fourth power, of which single precision leaves little near 0.
            let shown = |x: &f64| if def.id == Property::anisotropy { x.powi(4) } else { *x };
            let pairs = a.numbers().iter().map(shown).zip(b.numbers().iter().map(shown));
            let near = pairs.into_iter().all(|(a, b)| (a - b).abs() <= 2e-3 * a.abs().max(1.0));
            prop_assert!(near, "{}: {a:?} {b:?}", def.name);
        }
    }
}

#[test]
fn names_in_a_document_are_free() {
    let names = ["a", "NG_a_textures", "a", "a_ASM", "ND_adobe_standard_material_surfaceshader", "7 °C", ""];
    let mut materials = names.map(Material::named);
    for material in &mut materials {
        material.slot_mut(Property::coat).texture = Some(TextureRef::new("a.png"));
    }
    let written = write(&materials.iter().collect::<Vec<_>>(), &options(MODELS[0]));
    let outermost = written.text.lines().filter(|line| line.starts_with("  <") && !line.starts_with("  </"));
    let mut names: Vec<_> = outermost.filter_map(|line| line.split("name=\"").nth(1)?.split('"').next()).collect();
    let count = names.len();
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), count);
    assert_eq!(read(&written.text).map(|all| all.into_iter().map(|found| found.material).collect()), Ok(materials.to_vec()));
}

#[test]
fn numbers_of_the_mapping() {
    let numbers = |model: &str, roughness: f64, anisotropy: f64| {
        let mut material = Material::named("a");
        material.set(Property::roughness, Value::Float(roughness)).set(Property::anisotropy, Value::Float(anisotropy));
        let model = ShadingModel::named(model).expect("a model");
        let fields = model.translate(&material, &burnish_material::exchange::model::Context::of(&material)).fields;
        let get = |name: &str| fields.get(model.fields, name).map_or(f64::NAN, |field| field.value.numbers()[0]);
        match model.name {
            "open_pbr_surface" => [get("specular_roughness"), get("specular_roughness_anisotropy")],
            _ => [get("specular_roughness"), get("specular_anisotropy")],
        }
    };
    for (roughness, anisotropy, open, standard) in [
        (0.3, 0.5, [0.3538535, 0.4098361], [0.3422773, 0.4098361]),
        (0.1, 0.8, [0.5447809, 0.9761678], [0.2545124, 0.9761678]),
        (0.6, 0.3, [0.6033842, 0.02200489], [0.6033469, 0.02200489]),
        (0.9, 0.9, [0.9539248, 0.19], [0.9486833, 0.19]),
    ] {
        for (model, expected) in [("open_pbr_surface", open), ("standard_surface", standard)] {
            let found = numbers(model, roughness, anisotropy);
            assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6), "{model}: {found:?} {expected:?}");
        }
    }
}
