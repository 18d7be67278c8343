//! Broken files of every kind: an error or a note that names the place, what belongs there and what stands there.

use burnish_material::exchange::gltf::{GltfError, MAX_JSON_VALUES, MAX_MATERIALS, Mesh, Options, read};
use burnish_material::{Material, Property};
use serde_json::{Value as Json, json};

use super::{PNG, QUAD, bare, gltf, of_material, only, opened, with_image, written};

fn refused(bytes: &[u8]) -> String {
    read(bytes).expect_err("a broken document").to_string()
}

#[test]
fn what_is_no_document_is_refused() {
    for (text, expected) in [
        ("", "line 1, column 0: not valid JSON: EOF while parsing a value"),
        ("{\n  \"asset\": }", "line 2, column 12: not valid JSON: expected value"),
        ("[]", "not glTF 2.0: /: expected an object, found a list of 0"),
        ("{}", "not glTF 2.0: /asset/version: expected \"2.0\", found nothing"),
        (r#"{ "asset": { "version": "1.0" } }"#, "not glTF 2.0: /asset/version: expected \"2.0\", found the text \"1.0\""),
        (r#"{ "asset": { "version": "2.0" }, "materials": {} }"#, "not glTF 2.0: /materials: expected a list, found an object"),
        (
            r#"{ "asset": { "version": "2.0" }, "materials": [{}, 5] }"#,
            "not glTF 2.0: /materials/1: expected an object, found the number 5",
        ),
    ] {
        assert_eq!(refused(text.as_bytes()), expected);
    }
    assert!(refused(br#"{ "asset": { "version": "2.0" }, "x": 1e999 }"#).contains("number out of range"));
    let deep = "[".repeat(100_000);
    assert!(refused(deep.as_bytes()).contains("recursion limit"));
    assert!(read(b"\xef\xbb\xbf{ \"asset\": { \"version\": \"2.0\" } }").is_ok());
}

#[test]
fn too_much_is_refused() {
    let mut many = of_material(json!({}));
    many["materials"] = json!(vec![json!({}); MAX_MATERIALS + 1]);
    assert_eq!(
        refused(many.to_string().as_bytes()),
        format!("expected at most {MAX_MATERIALS} materials, found {}", MAX_MATERIALS + 1)
    );
    let commas = ",".repeat(MAX_JSON_VALUES + 1);
    assert!(matches!(read(commas.as_bytes()), Err(GltfError::TooMuch { .. })));
}

/// Every place in a document, as JSON pointers.
fn places(json: &Json, place: String, all: &mut Vec<String>) {
    match json {
        Json::Array(list) => list.iter().enumerate().for_each(|(k, json)| places(json, format!("{place}/{k}"), all)),
        Json::Object(entries) => entries.iter().for_each(|(key, json)| places(json, format!("{place}/{key}"), all)),
        _ => {}
    }
    all.push(place);
}

#[test]
fn odd_values_anywhere_break_nothing() {
    let mut material = super::off_default();
    material.slot_mut(Property::coat).texture = Some(burnish_material::TextureRef::new("coat.png"));
    let mut whole = gltf(&material);
    let kept = json!({ "iridescenceTexture": { "index": 0, "extensions": { "KHR_texture_transform": { "scale": [2, 2] } } } });
    whole["materials"][0]["extensions"]["KHR_materials_iridescence"] = kept;
    whole["materials"][0]["extensions"]["KHR_materials_pbrSpecularGlossiness"] = json!({ "diffuseTexture": { "index": 0 } });
    let mut all = Vec::new();
    places(&whole, String::new(), &mut all);
    let odd = [json!(null), json!(-1), json!(1e300), json!("x"), json!([]), json!({}), json!([{}, 1]), json!(true)];
    for (k, place) in all.iter().enumerate() {
        for value in [&odd[k % odd.len()], &odd[(k / odd.len() + 3) % odd.len()]] {
            let mut json = whole.clone();
            *json.pointer_mut(place).expect("a place that was just found") = value.clone();
            let Ok(document) = read(json.to_string().as_bytes()) else { continue };
            for found in &document.materials {
                let (material, notes) = found.material();
                assert!(notes.iter().all(|note| note.len() < 1000), "{notes:?}");
                // What was read can be written, and is then in order.
                let again = only(&gltf(&material));
                assert_eq!(again, (material, Vec::new()), "{place}: {value}");
            }
        }
    }
}

#[test]
fn kept_images_from_elsewhere_do_not_go_out() {
    let mut material = Material::named("M");
    let entry = r#"{"json":{"aTexture":{"index":{"path":"/etc/passwd"}},"bTexture":{"index":{"path":"b.png"}}},"beside":{}}"#;
    material.foreign.entry("gltf".to_owned()).or_default().insert("EXT_new".to_owned(), entry.to_owned());
    let written = written(&material, None, &Options::default());
    assert_eq!(written.plan.copies.iter().map(|copy| copy.path.as_str()).collect::<Vec<_>>(), ["b.png"]);
}

#[test]
fn broken_binary_files_are_refused() {
    let whole = written(&Material::named("M"), Some(&QUAD), &Options::default()).glb(|_| None).expect("no images");
    assert!(read(&whole).is_ok());
    let changed = |at: usize, byte: u8| {
        let mut file = whole.clone();
        file[at] = byte;
        refused(&file)
    };
    assert_eq!(changed(4, 3), "not a binary glTF file: header: expected version 2, found version 3");
    assert!(changed(15, 0xff).starts_with("not a binary glTF file: chunk at byte 12: expected"));
    assert_eq!(changed(16, b'j'), "not a binary glTF file: file: expected a chunk of JSON, found none");
    for length in [4, 7, 12, 14, 19, 40, whole.len() - 1] {
        assert!(refused(&whole[..length]).starts_with("not a binary glTF file"), "{length}");
    }
}

#[test]
fn wrong_values_cost_a_note_each() {
    let (material, notes) = only(&of_material(json!({
        "pbrMetallicRoughness": { "baseColorFactor": [1, 1], "metallicFactor": "much", "roughnessFactor": 1.5 },
        "normalTexture": 3,
        "emissiveTexture": { "index": 9 },
        "extensions": {
            "KHR_materials_volume": { "attenuationDistance": 0, "thicknessFactor": -1 },
            "KHR_materials_ior": { "ior": 0.5 },
            "KHR_materials_dispersion": { "dispersion": 50 },
            "KHR_materials_sheen": [] } })));
    let expected = [
        "/materials/0/pbrMetallicRoughness/metallicFactor: expected a number, found the text \"much\"; left out",
        "/materials/0/extensions/KHR_materials_volume/attenuationDistance: expected a number above 0, found the number 0; left out",
        "/materials/0/pbrMetallicRoughness/baseColorFactor: expected four numbers (r, g, b, a), linear, found a list of 2; left out",
        "/materials/0/normalTexture/index: expected a number below 0, the number of textures, found nothing",
        "/materials/0/emissiveTexture/index: expected a number below 0, the number of textures, found the number 9",
        "roughnessFactor: 1.5 was brought into 0 to 1",
        "dispersion: 50 was brought into 0 to 20",
        "ior: 0.5 became 1",
    ];
    assert_eq!(notes, expected);
    assert_eq!(material.float(Property::metallic), 1.0);
    assert_eq!(material.float(Property::specular_ior), 1.0);
}

#[test]
fn images_from_elsewhere_are_refused() {
    for (image, problem) in [
        (json!({ "uri": "/etc/passwd" }), "expected a relative path, found \"/etc/passwd\""),
        (json!({ "uri": "../../a.png" }), "expected a relative path, found \"../../a.png\""),
        (json!({ "uri": "https://a/b.png" }), "expected a relative path, found \"https://a/b.png\""),
        (json!({ "uri": "%2e%2e/a.png" }), "expected a relative path, found \"%2e%2e/a.png\""),
        (json!({ "uri": "data:image/png;base64,*" }), "expected base64, found the byte 0x2a at 0"),
        (json!({ "uri": "data:image/png" }), "expected a comma in the data URI, found none"),
        (json!({ "bufferView": 4 }), "bufferView: expected the number of a bufferView, found the number 4"),
        (json!({ "bufferView": 0 }), "bufferView: expected bytes 0 to 4000, found 3"),
        (json!({ "bufferView": 1 }), "bufferView: expected the number of a buffer, found the number 7"),
        (json!({}), "expected a uri or a bufferView, found neither"),
    ] {
        let mut json = with_image(json!({ "normalTexture": { "index": 0 } }));
        json["images"] = json!([image]);
        json["bufferViews"] = json!([{ "buffer": 0, "byteLength": 4000 }, { "buffer": 7, "byteLength": 1 }]);
        json["buffers"] = json!([{ "uri": "data:;base64,AAAA", "byteLength": 3 }]);
        let document = opened(json.to_string().as_bytes());
        assert!(document.images.is_empty());
        assert_eq!(document.notes, [format!("/images/0: {problem}")]);
        let (material, notes) = document.materials[0].material();
        assert!(material.slot(Property::normal).texture.is_none());
        assert!(
            notes[0].starts_with("/materials/0/normalTexture: the image is not used") && notes[0].ends_with(problem),
            "{notes:?}"
        );
    }
}

#[test]
fn meshes_that_cannot_be_written_are_refused() {
    let plain = Material::named("M");
    let problem = |mesh: Mesh| {
        let context = burnish_material::exchange::model::Context::of(&plain);
        let translation = burnish_material::exchange::models::gltf::MODEL.translate(&plain, &context);
        let part = burnish_material::exchange::gltf::Part { material: &plain, translation: &translation, context };
        burnish_material::exchange::gltf::write(&[part], Some(&mesh), &bare()).expect_err("a broken mesh").to_string()
    };
    let nan = [[f32::NAN, 0.0, 0.0]; 4];
    for (mesh, expected) in [
        (Mesh { triangles: &[], ..QUAD }, "mesh: expected triangles, found none"),
        (Mesh { triangles: &[[0, 1, 4]], ..QUAD }, "triangles: expected numbers below 4, found 4"),
        (Mesh { uvs: &[[0.0; 2]], ..QUAD }, "uvs: expected 4, one per position, or none, found 1"),
        (Mesh { positions: &nan, ..QUAD }, "mesh: expected finite numbers, found NaN"),
        (Mesh { normals: &[[0.0; 3]; 4], ..QUAD }, "normals: expected unit vectors, found [0.0, 0.0, 0.0]"),
        (Mesh { normals: &[], ..QUAD }, "tangents: expected normals beside them, found none"),
    ] {
        assert_eq!(problem(mesh), format!("the mesh cannot be written: {expected}"));
    }
}

#[test]
fn what_is_no_image_is_not_put_into_a_binary_file() {
    let mut material = Material::named("M");
    material.slot_mut(Property::normal).texture = Some(burnish_material::TextureRef::new("n.png"));
    let written = written(&material, None, &Options::default());
    let problem = written.glb(|_| Some(b"text".to_vec())).expect_err("no image").to_string();
    assert_eq!(problem, "not a binary glTF file: n.png: expected a file of PNG, JPEG, WebP or KTX 2, found another");
    assert!(written.glb(|_| Some(PNG.to_vec())).is_ok());
}

#[test]
fn nothing_that_is_not_finite_is_written() {
    let mut material = super::most();
    for property in [Property::emission, Property::absorption_distance, Property::normal_scale, Property::scatter_distance] {
        material.set(property, burnish_material::Value::Float(f64::MAX));
    }
    material.set(Property::emission_color, burnish_material::Value::Color([f64::MAX; 3]));
    let text = gltf(&material).to_string();
    assert!(!text.contains("null"), "{text}");
}
