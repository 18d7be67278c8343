//! What other programs write, by the rules of their extensions.

use burnish_material::exchange::gltf::Source;
use burnish_material::{Channel, ColorSpace, Material, Property, Value, Wrap};
use serde_json::{Value as Json, json};

use super::{PNG, gltf, of_material, only, opened, with_image};

fn near(a: f64, b: f64) {
    assert!((a - b).abs() <= 1e-6, "{a} {b}");
}

fn extended(name: &str, body: Json) -> Json {
    of_material(json!({ "extensions": { name: body } }))
}

#[test]
fn what_a_file_does_not_say_has_the_defaults_of_its_format() {
    let (material, notes) = only(&of_material(json!({})));
    assert!(notes.is_empty(), "{notes:?}");
    assert_eq!(material.float(Property::roughness), 1.0);
    assert_eq!(material.float(Property::metallic), 1.0);
    assert_eq!(material.color(Property::base_color), [1.0; 3]);
    let said: Vec<_> = material.slots().filter(|(_, slot)| slot.value.is_some()).map(|(property, _)| property).collect();
    assert_eq!(said, [Property::base_color, Property::roughness, Property::metallic]);
    let (coated, _) = only(&extended("KHR_materials_clearcoat", json!({ "clearcoatFactor": 1 })));
    assert_eq!(coated.float(Property::coat_ior), 1.5);
}

#[test]
fn alpha_means_what_its_mode_says() {
    let mut json =
        with_image(json!({ "pbrMetallicRoughness": { "baseColorFactor": [1, 1, 1, 0.4], "baseColorTexture": { "index": 0 } } }));
    let opacity = |json: &Json| only(json).0.slot(Property::opacity).clone();
    assert_eq!((opacity(&json).texture, opacity(&json).value), (None, Some(Value::Float(1.0))));
    json["materials"][0]["alphaMode"] = json!("BLEND");
    let blended = opacity(&json).texture.expect("the alpha of the image");
    assert_eq!((blended.channel, blended.scale, blended.bias), (Channel::A, [0.4; 3], [0.0; 3]));
    json["materials"][0]["alphaMode"] = json!("MASK");
    json["materials"][0]["alphaCutoff"] = json!(0.2);
    let masked = opacity(&json).texture.expect("the alpha of the image");
    let value = |alpha: f64| (alpha * masked.scale[0] + masked.bias[0]).clamp(0.0, 1.0);
    assert_eq!((value(0.5), value(0.48), value(1.0)), (1.0, 0.0, 1.0));
    let (material, _) = only(&json);
    // It goes out as it came, until somebody changes it.
    let out = gltf(&material);
    assert_eq!(out["materials"][0]["alphaMode"], "MASK");
    assert_eq!(out["materials"][0]["alphaCutoff"], json!(0.2));
    assert_eq!(out["materials"][0]["pbrMetallicRoughness"], json["materials"][0]["pbrMetallicRoughness"].clone().with_defaults());
    let mut changed = material.clone();
    changed.slot_mut(Property::opacity).texture = None;
    assert!(gltf(&changed)["materials"][0].get("alphaMode").is_none());
    for (alpha, there) in [(0.4, 1.0), (0.39, 0.0)] {
        let masked =
            json!({ "pbrMetallicRoughness": { "baseColorFactor": [1, 1, 1, alpha] }, "alphaMode": "MASK", "alphaCutoff": 0.4 });
        assert_eq!(opacity(&of_material(masked)).value, Some(Value::Float(there)));
    }
    json["materials"][0]["alphaMode"] = json!("DITHER");
    assert!(only(&json).1[0].contains("/materials/0/alphaMode: expected OPAQUE, MASK or BLEND, found the text \"DITHER\""));
}

trait WithDefaults {
    fn with_defaults(self) -> Json;
}

impl WithDefaults for Json {
    /// Numbers as floats, and those that are always written.
    fn with_defaults(mut self) -> Json {
        for (key, value) in [("metallicFactor", 1.0), ("roughnessFactor", 1.0)] {
            self[key] = json!(value);
        }
        if let Some(list) = self["baseColorFactor"].as_array_mut() {
            list.iter_mut().for_each(|number| *number = json!(number.as_f64()));
        }
        self
    }
}

#[test]
fn a_specular_colour_above_one_is_a_level() {
    let json = extended("KHR_materials_specular", json!({ "specularFactor": 0.5, "specularColorFactor": [1.6, 0.8, 0.4] }));
    let (material, _) = only(&json);
    near(material.float(Property::specular_level), 0.4);
    for (found, expected) in material.color(Property::specular_edge_color).into_iter().zip([1.0, 0.5, 0.25]) {
        near(found, expected);
    }
    let mut textured = with_image(json!({ "extensions": { "KHR_materials_specular": {
        "specularColorFactor": [2, 1, 1], "specularColorTexture": { "index": 0 } } } }));
    let (material, _) = only(&textured);
    near(material.float(Property::specular_level), 1.0);
    let edge = material.slot(Property::specular_edge_color).texture.clone().expect("the image");
    assert_eq!((edge.scale, edge.color_space), ([1.0, 0.5, 0.5], ColorSpace::Srgb));
    textured["materials"][0]["extensions"]["KHR_materials_specular"]["specularTexture"] = json!({ "index": 0 });
    let level = only(&textured).0.slot(Property::specular_level).texture.clone().expect("the image");
    assert_eq!((level.channel, level.scale), (Channel::A, [1.0; 3]));
    // An image of levels up to the middle goes out as it came.
    let body = json!({ "specularFactor": 0.8, "specularTexture": { "index": 0 } });
    let (material, _) = only(&with_image(json!({ "extensions": { "KHR_materials_specular": body } })));
    assert_eq!(gltf(&material)["materials"][0]["extensions"]["KHR_materials_specular"], body);
}

#[test]
fn reflections_without_an_index_become_one() {
    let glossy = |specular: [f64; 3]| {
        let body = json!({ "diffuseFactor": [0.5, 0.4, 0.3, 0.6], "specularFactor": specular, "glossinessFactor": 0.75 });
        only(&extended("KHR_materials_pbrSpecularGlossiness", body)).0
    };
    let plastic = glossy([0.04, 0.02, 0.0]);
    near(plastic.float(Property::specular_level), 0.5);
    near(plastic.float(Property::specular_ior), 1.5);
    near(plastic.color(Property::specular_edge_color)[1], 0.5);
    near(plastic.float(Property::roughness), 0.25);
    assert_eq!((plastic.float(Property::metallic), plastic.color(Property::base_color)), (0.0, [0.5, 0.4, 0.3]));
    let metal = glossy([0.81, 0.5, 0.4]);
    near(metal.float(Property::specular_ior), 19.0);
    near(metal.float(Property::specular_level), 0.5);
    // An index of 0 says the same in the newer way.
    let infinite = of_material(json!({ "extensions": {
        "KHR_materials_ior": { "ior": 0 }, "KHR_materials_specular": { "specularColorFactor": [0.81, 0.5, 0.4] } } }));
    near(only(&infinite).0.float(Property::specular_ior), 19.0);
    // Beside metallic and roughness the archived extension is not read.
    let mut both = extended("KHR_materials_pbrSpecularGlossiness", json!({ "glossinessFactor": 0.75 }));
    both["materials"][0]["pbrMetallicRoughness"] = json!({ "roughnessFactor": 0.1 });
    near(only(&both).0.float(Property::roughness), 0.1);
}

#[test]
fn gloss_in_an_image_is_inverted() {
    let json = with_image(json!({ "extensions": { "KHR_materials_pbrSpecularGlossiness": {
        "glossinessFactor": 0.5, "specularGlossinessTexture": { "index": 0 } } } }));
    let rough = only(&json).0.slot(Property::roughness).texture.clone().expect("the image");
    assert_eq!((rough.channel, rough.scale, rough.bias), (Channel::A, [-0.5; 3], [1.0; 3]));
}

#[test]
fn bodies_are_read_with_their_walls() {
    let glass = |volume: Json| {
        only(&of_material(json!({
            "pbrMetallicRoughness": { "baseColorFactor": [0.5, 0.6, 0.7, 1], "metallicFactor": 0 },
            "extensions": { "KHR_materials_transmission": { "transmissionFactor": 0.8 }, "KHR_materials_volume": volume } })))
    };
    let (thick, notes) = glass(json!({ "thicknessFactor": 2, "attenuationDistance": 0.3, "attenuationColor": [0.1, 0.2, 0.3] }));
    near(thick.float(Property::absorption_distance), 3.0);
    near(thick.float(Property::volume_thickness_scale), 2.0);
    assert_eq!(thick.color(Property::absorption_color), [0.1, 0.2, 0.3]);
    assert!(notes[0].contains("baseColorFactor"), "{notes:?}");
    let (thin, notes) = glass(json!({ "attenuationDistance": 0.3 }));
    assert_eq!(thin.float(Property::absorption_distance), 0.0);
    assert!(notes[0].contains("thin wall"), "{notes:?}");
    let (clear, _) = glass(json!({ "thicknessFactor": 1 }));
    assert_eq!(clear.color(Property::absorption_color), [0.5, 0.6, 0.7]);
    let draft = json!({ "extensions": {
        "KHR_materials_transmission": { "transmissionFactor": 0.8 },
        "KHR_materials_volume": { "thicknessFactor": 1, "attenuationDistance": 0.1, "attenuationColor": [0.5, 0.5, 0.5] },
        "KHR_materials_volume_scatter": { "multiscatterColorFactor": [0.9, 0.5, 0.5], "scatterAnisotropy": 0.5 } } });
    let (wax, _) = only(&of_material(draft));
    assert!(wax.switch(Property::scatter));
    near(wax.float(Property::translucency), 0.8);
    near(wax.float(Property::scatter_distance), 1.0 / std::f64::consts::LN_2);
    assert_eq!(wax.color(Property::scatter_color), [0.9, 0.5, 0.5]);
    assert!(wax.foreign["gltf"].contains_key("KHR_materials_volume_scatter"));
}

#[test]
fn anisotropy_over_an_image_of_roughness_is_taken_at_its_half() {
    let anisotropy = json!({ "anisotropyStrength": 0.5 });
    let json = with_image(json!({
        "pbrMetallicRoughness": { "metallicRoughnessTexture": { "index": 0 } },
        "extensions": { "KHR_materials_anisotropy": anisotropy } }));
    let (material, notes) = only(&json);
    near(material.float(Property::anisotropy), (0.75_f64 * 0.25).powf(0.25));
    assert!(material.slot(Property::anisotropy).texture.is_none());
    assert!(notes[0].contains("anisotropyStrength: depends on the image of roughness"), "{notes:?}");
    let out = gltf(&material);
    assert_eq!(out["materials"][0]["extensions"]["KHR_materials_anisotropy"], anisotropy);
    assert_eq!(only(&out), (material, Vec::new()));
}

#[test]
fn a_thin_wall_goes_back_out_thin() {
    let json = of_material(json!({ "extensions": { "KHR_materials_transmission": { "transmissionFactor": 1.0 } } }));
    let (mut material, notes) = only(&json);
    assert_eq!(notes.len(), 1, "{notes:?}");
    let out = gltf(&material);
    assert_eq!(out["materials"][0]["extensions"], json["materials"][0]["extensions"]);
    assert_eq!(only(&out), (material.clone(), Vec::new()));
    material.set(Property::absorption_distance, Value::Float(1.0));
    let volume = &gltf(&material)["materials"][0]["extensions"]["KHR_materials_volume"];
    assert_eq!(volume["thicknessFactor"], json!(1.0));
}

#[test]
fn drafts_are_read_and_kept() {
    let coat = json!({ "coatFactor": 0.7, "coatRoughnessFactor": 0.3, "coatIor": 1.8, "coatColorFactor": [0.9, 0.8, 0.7] });
    let (material, notes) = only(&extended("KHR_materials_coat", coat.clone()));
    assert_eq!(notes.len(), 1, "{notes:?}");
    assert_eq!((material.float(Property::coat), material.float(Property::coat_ior)), (0.7, 1.8));
    assert_eq!(material.color(Property::coat_color), [0.9, 0.8, 0.7]);
    assert_eq!(gltf(&material)["materials"][0]["extensions"]["KHR_materials_coat"], coat);
    let fuzz = json!({ "fuzzFactor": 0.8, "fuzzColorFactor": [0.9, 0.5, 0.2], "fuzzRoughnessFactor": 0.6, "fuzzTexture": { "index": 0 } });
    let (material, notes) = only(&extended("KHR_materials_fuzz", fuzz));
    assert_eq!(notes[0], "/materials/0: the images of KHR_materials_fuzz, a draft, are not read");
    near(material.float(Property::sheen), 0.8);
    near(material.color(Property::sheen_color)[1], 0.5);
    near(material.float(Property::sheen_roughness), 0.6);
}

#[test]
fn sheen_and_emission_keep_their_images() {
    let json = with_image(json!({
        "emissiveFactor": [0.5, 0.25, 0.25], "emissiveTexture": { "index": 0 },
        "extensions": {
            "KHR_materials_emissive_strength": { "emissiveStrength": 4 },
            "KHR_materials_sheen": { "sheenColorFactor": [0.5, 0.25, 0.25], "sheenColorTexture": { "index": 0 } } } }));
    let (material, notes) = only(&json);
    assert!(notes.is_empty(), "{notes:?}");
    near(material.float(Property::emission), 4.0);
    near(material.float(Property::sheen), 0.5);
    let scale = |property| material.slot(property).texture.as_ref().expect("the image").scale;
    assert_eq!(scale(Property::emission_color), [0.5, 0.25, 0.25]);
    assert_eq!(scale(Property::sheen_color), [1.0, 0.5, 0.5]);
    assert!(material.slot(Property::sheen).texture.is_none() && material.slot(Property::emission).texture.is_none());
}

#[test]
fn settings_of_images_are_read() {
    let mut json = with_image(json!({ "occlusionTexture": { "index": 0, "strength": 0.25, "texCoord": 1, "extensions": {
        "KHR_texture_transform": { "offset": [0.1, 0.2], "rotation": std::f64::consts::PI, "scale": [-1, 2] } } } }));
    json["samplers"] = json!([{ "wrapS": 33648, "wrapT": 33648 }]);
    json["textures"][0]["sampler"] = json!(0);
    let (material, notes) = only(&json);
    let found = material.slot(Property::ambient_occlusion).texture.clone().expect("the image");
    assert_eq!((found.scale, found.bias, found.wrap), ([0.25; 3], [0.75; 3], Wrap::Mirror));
    assert_eq!((found.uv_scale, found.uv_offset, found.uv_rotation), ([-1.0, 2.0], [0.1, 0.2], 180.0));
    assert_eq!(
        notes,
        ["/materials/0/occlusionTexture: uses the texture coordinates of set 1; ASM knows set 0 alone, which is used instead"]
    );
    assert_eq!(gltf(&material)["materials"][0]["occlusionTexture"]["strength"], json!(0.25));
}

#[test]
fn what_asm_has_no_place_for_goes_back_out() {
    let kept = json!({
        "doubleSided": true,
        "extras": { "id": 7 },
        "extensions": {
            "KHR_materials_iridescence": { "iridescenceFactor": 0.5, "iridescenceTexture": { "index": 0, "texCoord": 1 } },
            "EXT_new": { "a": [1, { "b": null }] },
            "KHR_materials_anisotropy": { "anisotropyStrength": 0.5, "anisotropyTexture": { "index": 0 } } } });
    let (mut material, notes) = only(&with_image(kept.clone()));
    assert!(notes.iter().any(|note| note.starts_with("KHR_materials_iridescence: ASM has no place")), "{notes:?}");
    let out = gltf(&material);
    let found = &out["materials"][0];
    assert_eq!(found["doubleSided"], kept["doubleSided"]);
    assert_eq!(found["extras"]["id"], kept["extras"]["id"]);
    for (name, body) in kept["extensions"].as_object().expect("extensions") {
        assert_eq!(&found["extensions"][name], body, "{name}");
    }
    assert!(out["extensionsUsed"].as_array().expect("names").contains(&json!("EXT_new")));
    assert_eq!(out["images"], json!([{ "uri": "a.png" }]));
    // Our own file gives the same again.
    assert_eq!(only(&out), (material.clone(), Vec::new()));
    // Beside something that has changed it would say something else.
    material.set(Property::specular_ior, Value::Float(2.0));
    let out = gltf(&material);
    assert!(out["materials"][0]["extensions"].get("KHR_materials_iridescence").is_none());
    assert!(out["materials"][0]["extensions"].get("EXT_new").is_some());
}

#[test]
fn an_unlit_material_shines_and_goes_back_unlit() {
    let json = with_image(json!({
        "pbrMetallicRoughness": { "baseColorFactor": [0.5, 0.5, 0.5, 1], "baseColorTexture": { "index": 0 } },
        "extensions": { "KHR_materials_unlit": {} } }));
    let (mut material, _) = only(&json);
    assert_eq!(material.float(Property::emission), 1.0);
    assert_eq!(material.float(Property::specular_level), 0.0);
    assert_eq!(material.color(Property::base_color), [0.0; 3]);
    assert_eq!(material.slot(Property::emission_color).texture.as_ref().map(|texture| texture.scale), Some([0.5; 3]));
    let out = gltf(&material);
    let core = &out["materials"][0]["pbrMetallicRoughness"];
    assert_eq!((&core["baseColorFactor"], &core["baseColorTexture"]), (&json!([0.5, 0.5, 0.5, 1.0]), &json!({ "index": 0 })));
    assert_eq!(out["materials"][0]["extensions"], json!({ "KHR_materials_unlit": {} }));
    assert_eq!(only(&out).0, material);
    material.set(Property::emission, Value::Float(2.0));
    assert!(gltf(&material)["materials"][0].get("emissiveTexture").is_some());
}

#[test]
fn images_inside_of_documents_are_handed_out() {
    let mut json = with_image(json!({ "normalTexture": { "index": 0 } }));
    json["images"] = json!([{ "uri": "data:image/png;base64,iVBORw==", "name": "bumps" }]);
    let document = opened(json.to_string().as_bytes());
    assert_eq!(document.images[0].path, "bumps.png");
    assert_eq!(document.images[0].source, Source::Bytes(PNG[..4].to_vec()));
    json["images"] = json!([{ "bufferView": 0, "mimeType": "image/jpeg" }]);
    json["bufferViews"] = json!([{ "buffer": 0, "byteOffset": 2, "byteLength": 3 }]);
    json["buffers"] = json!([{ "byteLength": 8, "uri": "mesh.bin" }]);
    let document = opened(json.to_string().as_bytes());
    assert_eq!(document.images[0].source, Source::Part { file: "mesh.bin".to_owned(), range: 2..5 });
    let (material, _) = document.materials[0].material();
    assert_eq!(material.slot(Property::normal).texture.as_ref().map(|t| t.path.as_str()), Some("image_0.jpg"));
    // In a binary file of ours, what the native copies use is there under its name.
    let mut material = Material::named("M");
    material.slot_mut(Property::height).texture = Some(burnish_material::TextureRef::new("h.png"));
    let glb = super::written(&material, None, &Default::default()).glb(|_| Some(PNG.to_vec())).expect("images in order");
    let document = opened(&glb);
    assert_eq!((document.images[0].path.as_str(), &document.images[0].source), ("h.png", &Source::Bytes(PNG.to_vec())));
    assert_eq!(document.materials[0].material().0, material);
}
