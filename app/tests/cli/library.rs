//! Materials: presets, checks, stability, features.

use super::Place;
use std::fs;

#[test]
fn presets_are_listed_shown_and_searched() {
    let place = Place::new();
    let all = place.run(&["presets", "list", "--json"]).json();
    let all = all["presets"].as_array().unwrap();
    assert!(all.len() >= 10);
    for row in all {
        for key in ["name", "group", "source"] {
            assert!(row[key].as_str().is_some_and(|text| !text.is_empty()), "{key}: {row}");
        }
    }
    let text = place.run(&["presets", "list"]).out;
    let name = all[0]["name"].as_str().unwrap();
    assert!(text.lines().any(|line| line.trim() == name));

    for words in [["presets", "show", name], ["presets", "show", &format!("preset:{}", name.to_uppercase())]] {
        let shown = place.run(&words);
        assert_eq!(shown.code, Some(0), "{}", shown.err);
        assert!(shown.out.contains("\"properties\""), "{}", shown.out);
    }
    let shown = place.run(&["presets", "show", name, "--json"]).json();
    assert_eq!(shown["presets"][0]["name"], name);

    let found = place.run(&["presets", "search", "gold", "--json"]).json();
    let found = found["presets"].as_array().unwrap();
    assert!(!found.is_empty() && found.len() < all.len());
    let none = place.run(&["presets", "search", "zzzz", "--json"]);
    assert_eq!((none.code, none.json()["presets"].as_array().unwrap().len()), (Some(0), 0));
}

#[test]
fn check_tells_errors_from_warnings() {
    let place = Place::new();
    place.write("lib/good.asm.ron", "{\"asm\": \"4.0\", \"properties\": {\"roughness\": 0.5}}");
    place.write("lib/readme.txt", "not a material");
    let good = place.run(&["check", "lib", "--json"]);
    assert_eq!(good.code, Some(0), "{}", good.err);
    let json = good.json();
    assert_eq!((&json["files"], &json["errors"], &json["warnings"]), (&1.into(), &0.into(), &0.into()), "{json}");

    place.write("lib/deep/er/range.asm.ron", "{\"properties\": {\"roughness\": 1.5}}");
    let warned = place.run(&["check", "lib", "--json"]);
    assert_eq!(warned.code, Some(0), "{}", warned.out);
    assert_eq!(warned.json()["files"], 2);
    assert!(warned.json()["warnings"].as_u64().unwrap() >= 1);
    assert_eq!(place.run(&["check", "lib", "--strict"]).code, Some(1));

    place.write("lib/nan.asm.ron", "{\n\n\"properties\": {\"roughness\": NaN}}");
    place.write("lib/broken.asm.ron", "{\"properties\": ");
    fs::write(place.path("lib/binary.asm.ron"), [0xff, 0xfe, 0x00, 0x80]).unwrap();
    place.write("lib/texture.asm.ron", "{\"properties\": {\"roughness\": {\"texture\": {\"path\": \"none.png\"}}}}");
    let failed = place.run(&["check", "lib", "--json"]);
    assert_eq!((failed.code, failed.err.as_str()), (Some(1), ""));
    let json = failed.json();
    assert_eq!((&json["files"], &json["errors"]), (&6.into(), &3.into()), "{json}");
    let rows = json["rows"].as_array().unwrap();
    assert!(
        rows.iter().any(|row| row["severity"] == "warning" && row["message"].as_str().unwrap().contains("none.png")),
        "{json}"
    );
    let nan =
        rows.iter().find(|row| row["severity"] == "error" && row["file"].as_str().unwrap().ends_with("nan.asm.ron")).unwrap();
    assert_eq!((&nan["severity"], &nan["line"]), (&"error".into(), &3.into()), "{nan}");
    assert!(nan["key"].as_str().unwrap().contains("roughness"), "{nan}");

    let text = place.run(&["check", "lib"]);
    assert_eq!(text.code, Some(1));
    assert!(text.out.contains("nan.asm.ron:3: error: "), "{}", text.out);
    assert!(text.out.trim_end().lines().last().unwrap().starts_with("6 files, 3 errors, "), "{}", text.out);
}

#[test]
fn stability_probes_materials_and_what_their_images_reach() {
    let place = Place::new();
    let run = place.run(&["stability", "red.asm.ron", "--mesh", "sphere", "--json"]);
    assert_eq!(run.code, Some(0), "{}{}", run.out, run.err);
    let json = run.json();
    let cases = json["cases"].as_array().unwrap();
    assert!(cases.len() > 2 && json["failed"] == 0, "{json}");
    assert_eq!(cases[0]["name"], "red.asm.ron");
    for case in cases {
        assert!(case["holds"].is_boolean() && case["worst"].is_string() && case["seconds"].is_number(), "{case}");
        assert!(case["numbers"]["time_ratio"].is_number() && case["numbers"]["nonfinite"].is_number(), "{case}");
    }
    let text = place.run(&["stability", "--scene", "scenes/quad.json", "--threads", "1"]);
    assert_eq!(text.code, Some(0), "{}{}", text.out, text.err);
    assert!(text.out.contains("holds") && text.out.ends_with("0 do not hold\n"), "{}", text.out);

    let missing = place.run(&["stability", "nowhere.asm.ron", "--json"]);
    assert_eq!((missing.code, missing.out.as_str()), (Some(2), ""));
    assert_eq!(missing.err.lines().count(), 1);
}

#[test]
fn features_names_what_switches_each_lobe_and_measures() {
    let place = Place::new();
    let words = ["features", "red.asm.ron", "--mesh", "sphere", "--environment", "studio", "--size", "48x48", "--json"];
    let run = place.run(&words);
    assert_eq!(run.code, Some(0), "{}", run.err);
    let json = run.json();
    let lobes = json["lobes"].as_array().unwrap();
    let named = |name: &str| lobes.iter().find(|lobe| lobe["name"] == name).unwrap();
    assert_eq!(named("coat")["in"], false);
    assert!(named("coat")["reason"].as_str().unwrap().contains("coat is 0"), "{json}");
    assert!(named("coat")["final_ratio"].is_number(), "{json}");
    assert_eq!(named("diffuse")["in"], true);
    assert!(json["final_speedup"].as_f64().unwrap() > 0.0);
    assert!(json["z"].as_f64().unwrap() < 6.0, "{json}");
    // With an adapter there are numbers, without one a reason.
    let has_preview = json["preview_ms"].is_number() && json["preview_full_ms"].is_number() && json["compile_ms"].is_number();
    assert!(has_preview != json["preview_reason"].is_string(), "{json}");
}
