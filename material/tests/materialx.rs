//! MaterialX documents: materials there and back, edits by other programs, graphs that fold.

mod common;

use burnish_material::exchange::ShadingModel;
use burnish_material::exchange::loss::Fate;
use burnish_material::exchange::materialx::{ReadMaterial, SURFACES, WriteOptions, read, write};
use burnish_material::exchange::plan::{Job, Texel};
use burnish_material::{Channel, ColorSpace, Kind, Material, PROPERTIES, Property, Provenance, TextureRef, Value, Vary, Wrap};
use proptest::prelude::*;

/// The models of MaterialX's surfaces that are written; others are read only.
fn surfaces() -> impl Iterator<Item = &'static ShadingModel> {
    SURFACES.iter().map(|surface| surface.model).filter(|model| ShadingModel::named(model.name).is_some())
}

fn options(surface: &'static ShadingModel) -> WriteOptions<'static> {
    WriteOptions { surface, ..WriteOptions::default() }
}

fn text(material: &Material, surface: &'static ShadingModel) -> String {
    write(&[material], &options(surface)).text
}

fn one(text: &str) -> ReadMaterial {
    let mut all = read(text).unwrap_or_else(|error| panic!("{error}\n{text}"));
    assert_eq!(all.len(), 1);
    all.remove(0)
}

/// The document without anything that only this program reads.
fn without_native_copy(text: &str) -> String {
    let mut text = text.replace(" asm_source=", " other_source=");
    for tag in ["adobe_standard_material name=", "surfacematerial name="] {
        let mut from = 0;
        while let Some(start) = text[from..].find(&format!("<{tag}")).map(|at| at + from) {
            let name = tag.split(' ').next().unwrap_or_default();
            let end = text[start..].find(&format!("</{name}>")).map_or(text.len(), |at| start + at + name.len() + 3);
            if name == "surfacematerial" && !text[start..end].contains("_native\"") {
                from = end;
            } else {
                text.replace_range(start..end, "");
            }
        }
    }
    text
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
        for model in surfaces() {
            let written = write(&[&material], &options(model));
            let found = one(&without_native_copy(&written.text));
            prop_assert!(!found.is_native && found.surface == model.name);
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
    let written = text(&Material::named("a"), SURFACES[0].model);
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
    let written = text(material, SURFACES[0].model);
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
        let expected = one(&without_native_copy(&text(&material, SURFACES[0].model))).material;
        let found = one(&implementation(&material)).material;
        for def in PROPERTIES.iter().filter(|def| !["normal_scale", "coat_normal_scale", "height", "height_scale"].contains(&def.name)) {
            let (a, b) = (expected.value(def.id), found.value(def.id));
            let near = a.numbers().iter().zip(b.numbers()).all(|(a, b)| (a - b).abs() <= 2e-3 * a.abs().max(1.0));
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
    let written = write(&materials.iter().collect::<Vec<_>>(), &WriteOptions::default());
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
