//! `convert`: every format there and back, several materials, images that come along, and what cannot be read.

use super::Place;
use serde_json::json;
use std::fs;

const FORMATS: [&str; 8] = ["gltf", "glb", "mtlx", "usda", "usdz", "mdl", "mat", "textures.json"];

/// Every property off its default, with numbers that single precision does not hold.
const FULL: &str = r#"{
    "asm": "4.0",
    "name": "Full",
    "tags": ["a", "b"],
    "notes": "Line one.\nLine two: \"quoted\".",
    "unit_mm": 7.3,
    "provenance": { "source": "me", "licence": "CC0-1.0" },
    "properties": {
        "base_color": (0.1, 0.2, 0.7000000000000001),
        "roughness": 0.30000000000000004,
        "metallic": 0.25,
        "specular_level": 0.65,
        "anisotropy": 0.6,
        "emission": 2.5,
        "sheen": 0.3,
        "translucency": 0.6,
        "specular_ior": 1.52,
        "dispersion": 0.36,
        "absorption_distance": 12.5,
        "scatter": true,
        "scatter_red_shift": 0.5,
        "coat": 0.8,
        "coat_specular_level": 0.4,
        "height_scale": 0.125,
        "volume_thickness_scale": 1.6,
    },
}
"#;

#[test]
fn every_format_gives_back_the_same_material() {
    let place = Place::new();
    place.write("full.asm.ron", FULL);
    for format in FORMATS {
        let there = format!("full.{format}");
        let run = place.run(&["convert", "full.asm.ron", &there, "--json"]);
        assert_eq!(run.code, Some(0), "{format}: {}", run.err);
        let sheet = run.json();
        assert_eq!(sheet["rows"].as_array().map(Vec::len), Some(40), "{format}");
        assert!(sheet["rows"].as_array().unwrap().iter().all(|row| {
            ["exact", "remapped", "approximated", "dropped"].iter().any(|word| row["fate"] == *word)
                && row["property"].is_string()
        }));
        let back = format!("{format}-back.asm.ron");
        let run = place.run(&["convert", &there, &back]);
        assert_eq!((run.code, run.err.as_str()), (Some(0), ""), "{format}");
        let run = place.run(&["diff", "full.asm.ron", &back]);
        assert_eq!(run.code, Some(0), "{format}: {}", run.out);
    }
}

#[test]
fn comments_and_unknown_keys_come_back_too() {
    let place = Place::new();
    let text = r#"// Measured on a rainy day.
{
    "asm": "4.0",
    "name": "Commented",
    "properties": {
        "roughness": 0.250, // as the spectrometer prints it
        "sources": { "roughness": "lab" },
        "shininess": 12,
    },
    "studio": { "shelf": 7 },
}
"#;
    place.write("commented.asm.ron", text);
    for format in FORMATS {
        let there = format!("commented.{format}");
        for pair in [["commented.asm.ron", &there], [&there, "back.asm.ron"]] {
            let run = place.run(&["convert", pair[0], pair[1]]);
            assert_eq!(run.code, Some(0), "{format}: {}", run.err);
        }
        assert_eq!(fs::read_to_string(place.path("back.asm.ron")).unwrap(), text, "{format}");
    }
    // What another program changed stands in the text that was taken along.
    let gltf = fs::read_to_string(place.path("commented.gltf")).unwrap();
    let place_of = gltf.find("\"roughnessFactor\"").expect("a factor") + "\"roughnessFactor\":".len();
    let end = place_of + gltf[place_of..].find([',', '}']).unwrap();
    place.write("edited.gltf", &format!("{}0.75{}", &gltf[..place_of], &gltf[end..]));
    assert_eq!(place.run(&["convert", "edited.gltf", "back.asm.ron"]).code, Some(0));
    assert_eq!(fs::read_to_string(place.path("back.asm.ron")).unwrap(), text.replace("0.250,", "0.75,"));
}

#[test]
fn images_come_along_and_are_computed_where_nothing_else_serves() {
    let place = Place::new();
    let grey: Vec<u8> = (0..64).map(|k| k * 4).collect();
    for name in ["rough.png", "metal.png"] {
        image::save_buffer(place.path(name), &grey, 8, 8, image::ExtendedColorType::L8).unwrap();
    }
    place.write(
        "maps.asm.ron",
        r#"{ "asm": "4.0", "name": "Maps", "properties": {
            "roughness": { "texture": { "path": "rough.png" } }, "metallic": { "texture": { "path": "metal.png" } } } }"#,
    );
    for format in FORMATS {
        let there = format!("out/maps.{format}");
        fs::create_dir_all(place.path("out")).unwrap();
        let run = place.run(&["convert", "maps.asm.ron", &there]);
        assert_eq!((run.code, run.err.as_str()), (Some(0), ""), "{format}");
        let run = place.run(&["convert", &there, &format!("out/{format}.asm.ron")]);
        assert_eq!(run.code, Some(0), "{format}: {}", run.err);
        let text = fs::read_to_string(place.path(&format!("out/{format}.asm.ron"))).unwrap();
        assert!(text.contains("roughness") && text.contains(".png"), "{format}: {text}");
        let run = place.run(&["check", &format!("out/{format}.asm.ron")]);
        assert!(run.code == Some(0) && !run.out.contains("found no file"), "{format}: {}", run.out);
    }
}

#[test]
fn what_others_see_is_measured_and_explained() {
    let place = Place::new();
    place.write("coat.asm.ron", r#"{ "asm": "4.0", "properties": { "coat": 1.0, "base_color": (0.8, 0.1, 0.1) } }"#);
    let words = ["convert", "coat.asm.ron", "coat.usda", "--measure", "--time", "0.5", "--report", "sheet.json", "--json"];
    let run = place.run(&words);
    assert_eq!(run.code, Some(0), "{}", run.err);
    let sheet = run.json();
    let flip = sheet["flip_mean"].as_f64().unwrap();
    assert!((0.0..0.5).contains(&flip), "{flip}");
    let report: serde_json::Value = serde_json::from_str(&fs::read_to_string(place.path("sheet.json")).unwrap()).unwrap();
    assert_eq!(report, sheet);
}

#[test]
fn several_materials_become_several_files() {
    let place = Place::new();
    let material = |name: &str, metallic: f64| json!({ "name": name, "pbrMetallicRoughness": { "metallicFactor": metallic } });
    let document = json!({ "asset": { "version": "2.0" }, "materials": [material("Body", 0.0), material("Lid", 1.0)] });
    place.write("two.gltf", &document.to_string());
    let run = place.run(&["convert", "two.gltf", "parts/"]);
    assert_eq!(run.code, Some(0), "{}", run.err);
    assert!(place.path("parts/Body.asm.ron").is_file() && place.path("parts/Lid.asm.ron").is_file());
    let run = place.run(&["convert", "two.gltf", "lid.mtlx", "--material", "lid"]);
    assert_eq!(run.code, Some(0), "{}", run.err);
    let run = place.run(&["convert", "two.gltf", "none.mtlx", "--material", "lod"]);
    assert!(run.code == Some(2) && run.err.contains("did you mean `Lid`"), "{}", run.err);
    // A material argument takes the first, or the one that is chosen.
    let run = place.render(&["two.gltf", "--spp", "1", "--out", "a.png"]);
    assert!(run.code == Some(0) && run.err.contains("Lid"), "{}", run.err);
    let run = place.render(&["two.gltf", "--material", "lid", "--spp", "1", "--out", "b.png"]);
    assert_eq!((run.code, run.err.as_str()), (Some(0), ""));
    let name = |picture: &str| {
        let run = place.run(&["convert", picture, "of-picture.asm.ron"]);
        assert_eq!(run.code, Some(0), "{}", run.err);
        fs::read_to_string(place.path("of-picture.asm.ron")).unwrap()
    };
    assert!(name("a.png").contains("Body") && name("b.png").contains("Lid"));
    let run = place.run(&["diff", "two.gltf", "parts/Lid.asm.ron", "--material", "Lid"]);
    assert_eq!(run.code, Some(0), "{}{}", run.out, run.err);
    let run = place.run(&["shader", "two.gltf", "--material", "2", "--lang", "wgsl", "--out", "lid.wgsl"]);
    assert_eq!((run.code, run.err.as_str()), (Some(0), ""));
    let run = place.run(&["shader", "two.gltf", "--material", "3", "--lang", "wgsl", "--out", "lid.wgsl"]);
    assert!(run.code == Some(2) && run.err.contains("from 1 to 2 of two.gltf"), "{}", run.err);
}

#[test]
fn every_model_of_a_format_gives_back_the_same_material() {
    let place = Place::new();
    place.write("full.asm.ron", FULL);
    for (out, model, word) in [
        ("a.mtlx", "open_pbr", "<open_pbr_surface "),
        ("b.mtlx", "standard_surface", "<standard_surface "),
        ("c.mtlx", "gltf_pbr", "<gltf_pbr "),
        ("d.mtlx", "UsdPreviewSurface", "<UsdPreviewSurface "),
        ("e.mtlx", "disney_principled", "<disney_principled "),
        ("f.textures.json", "metallic_roughness", "f_Metallic.png"),
        ("g.textures.json", "specular_glossiness", "g_Glossiness.png"),
    ] {
        let run = place.run(&["convert", "full.asm.ron", out, "--model", model, "--json"]);
        assert_eq!(run.code, Some(0), "{model}: {}", run.err);
        assert!(fs::read_to_string(place.path(out)).unwrap().contains(word), "{model}");
        let run = place.run(&["convert", out, "back.asm.ron"]);
        assert_eq!((run.code, run.err.as_str()), (Some(0), ""), "{model}");
        let run = place.run(&["diff", "full.asm.ron", "back.asm.ron"]);
        assert_eq!(run.code, Some(0), "{model}: {}", run.out);
    }
}

#[test]
fn folders_of_images_become_a_material_for_each_set() {
    let place = Place::new();
    fs::create_dir(place.path("maps")).unwrap();
    let save = |name: &str, level: u8| {
        image::save_buffer(place.path(name), &[level; 16], 4, 4, image::ExtendedColorType::L8).unwrap();
    };
    for name in ["Wood_BaseColor", "Wood_Roughness", "Old-Brick_2k_Roughness", "Old-Brick_normal_2k", "preview"] {
        save(&format!("maps/{name}.png"), 100);
    }
    let run = place.run(&["convert", "maps", "out/"]);
    assert_eq!(run.code, Some(0), "{}", run.err);
    assert!(run.err.contains("preview.png") && run.err.trim().lines().count() == 1, "{}", run.err);
    let text = |name: &str| fs::read_to_string(place.path(name)).unwrap();
    let (wood, brick) = (text("out/Wood.asm.ron"), text("out/Old-Brick.asm.ron"));
    assert!(wood.contains("maps/Wood_BaseColor.png") && wood.contains("maps/Wood_Roughness.png"), "{wood}");
    assert!(brick.contains("Old-Brick_normal_2k.png") && !brick.contains("Wood"), "{brick}");
    let run = place.run(&["check", "out/Wood.asm.ron", "out/Old-Brick.asm.ron"]);
    assert!(run.code == Some(0) && !run.out.contains("found no file"), "{}", run.out);
    let run = place.render(&["maps", "--material", "wood", "--spp", "1", "--out", "a.png"]);
    assert_eq!(run.code, Some(0), "{}", run.err);
    // A set that lies where its images come from, with one that is painted over and one that is new.
    let run = place.run(&["convert", "out/Wood.asm.ron", "set/", "--format", "textures.json"]);
    assert_eq!(run.code, Some(0), "{}", run.err);
    let run = place.run(&["convert", "set/", "back.asm.ron"]);
    assert_eq!((run.code, run.err.as_str()), (Some(0), ""));
    save("set/Wood_Roughness.png", 200);
    save("set/Wood_Metallic.png", 255);
    let run = place.run(&["convert", "set/Wood.textures.json", "edited.asm.ron"]);
    assert_eq!(run.code, Some(0), "{}", run.err);
    let lines: Vec<&str> = run.err.trim().lines().collect();
    assert!(lines.len() == 2 && lines[0].contains("roughness") && lines[1].contains("metallic"), "{}", run.err);
    let run = place.run(&["diff", "back.asm.ron", "edited.asm.ron", "--json"]);
    let changed = run.json()["changed"].as_array().unwrap().clone();
    assert!(changed.iter().all(|row| row["property"].as_str().unwrap().starts_with("metallic")), "{changed:?}");
}

#[test]
fn what_is_no_material_is_one_sentence() {
    let place = Place::new();
    for (name, text) in [
        ("a.gltf", "{"),
        ("b.gltf", "{\"asset\": {\"version\": \"2.0\"}}"),
        ("c.mtlx", "<materialx"),
        ("d.usda", "#usda 1.0\ndef Material \"x"),
        ("e.usdz", "PK no zip"),
        ("f.mdl", "mdl 1.7;"),
        ("g.glb", "glTF"),
        ("h.blend", ""),
        ("i.mat", "material {}"),
        ("j.textures.json", "{}"),
    ] {
        place.write(name, text);
        let run = place.run(&["convert", name, "out.asm.ron"]);
        assert_eq!(run.code, Some(2), "{name}");
        assert!(run.err.contains(name) && run.err.trim().lines().count() == 1, "{name}: {}", run.err);
        assert!(!place.path("out.asm.ron").exists());
    }
    let run = place.run(&["convert", "red.asm.ron", "red.fbx"]);
    assert!(run.code == Some(2) && run.err.contains(".usdz"), "{}", run.err);
}
