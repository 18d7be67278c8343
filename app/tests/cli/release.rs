//! Handing a library out: checks, comparison with an earlier release, differences and merges of two versions.

use super::{Place, Run};
use std::fs;

fn run(place: &Place, words: &[&str]) -> Run {
    // What is known of a library must not go to the cache of the user.
    place.command().env("BURNISH_HOME", place.path("home")).args(words).output().unwrap().into()
}

fn write(place: &Place, file: &str, name: &str, properties: &str) {
    let text = format!(
        "{{\n    \"asm\": \"4.0\",\n    \"name\": \"{name}\",\n    \"provenance\": {{ \"source\": \"me\", \"licence\": \"MIT\" }},\n    \
         \"properties\": {{ {properties} }},\n}}\n"
    );
    place.write(file, &text);
}

#[test]
fn a_library_is_checked_and_compared() {
    let place = Place::new();
    write(&place, "old/a.asm.ron", "A", "\"roughness\": 0.2");
    write(&place, "old/b.asm.ron", "B", "\"roughness\": 0.4");
    write(&place, "new/a.asm.ron", "A", "\"roughness\": 0.3");
    let good = run(&place, &["library", "check", "new", "--against", "old", "--json"]);
    assert_eq!(good.code, Some(0), "{}", good.err);
    assert!(good.err.contains("files per second"), "{}", good.err);
    let json = good.json();
    assert_eq!((&json["files"], &json["errors"], &json["warnings"]), (&1.into(), &0.into(), &0.into()), "{json}");
    assert_eq!(json["rows"][0]["kind"], "thumbnail");
    let against = &json["against"];
    assert_eq!((&against["added"], &against["removed"][0]), (&serde_json::json!([]), &"b.asm.ron".into()), "{json}");
    let changed = &against["changed"][0];
    assert_eq!(
        (&changed["path"], &changed["by_value"], &changed["look"]),
        (&"a.asm.ron".into(), &true.into(), &"not known".into())
    );
    assert_eq!(changed["changed"][0]["property"], "roughness");

    write(&place, "new/c.asm.ron", "C", "\"roughness\": 0.30");
    assert_eq!(run(&place, &["library", "check", "new"]).code, Some(0));
    assert_eq!(run(&place, &["library", "check", "new", "--strict"]).code, Some(1));
    write(&place, "new/d.asm.ron", "D", "\"base_color\": (1.4, 0.2, 0.2)");
    let failed = run(&place, &["library", "check", "new", "--against", "old"]);
    assert_eq!(failed.code, Some(1), "{}", failed.err);
    for text in [
        "d.asm.ron: error: base_color: 1.4 is outside",
        "c.asm.ron: warning: has the values and textures of",
        "removed  b.asm.ron",
        "changed  a.asm.ron: roughness; look not known",
        "2 added, 1 removed, 1 changed by value, 0 changed in look, 1 of which the look is not known, 0 unchanged",
        "3 small pictures are stale or missing",
    ] {
        assert!(failed.out.contains(text), "{text}: {}", failed.out);
    }
    assert_eq!(failed.out.lines().last(), Some("3 files, 1 error, 1 warning"));
    let nothing = run(&place, &["library", "check", "new", "--against", "meshes", "--json"]);
    assert_eq!((nothing.code, nothing.out.as_str()), (Some(2), ""), "{}", nothing.err);
    // The same is no error where nobody hands it out.
    assert_eq!(run(&place, &["check", "new"]).code, Some(0));
}

#[test]
fn two_materials_are_compared_and_drawn() {
    let place = Place::new();
    write(&place, "a.asm.ron", "A", "\"roughness\": 0.2");
    write(&place, "b.asm.ron", "A", "\"roughness\": 0.2, \"metallic\": 1.0");
    let same = run(&place, &["diff", "a.asm.ron", "a.asm.ron", "--json"]);
    assert_eq!((same.code, &same.json()["changed"]), (Some(0), &serde_json::json!([])), "{}", same.err);
    let words = ["diff", "a.asm.ron", "b.asm.ron", "--image", "d.png", "--size=80x48", "--time=1", "--mesh=sphere", "--json"];
    let differ = run(&place, &words);
    assert_eq!(differ.code, Some(1), "{}", differ.err);
    let json = differ.json();
    let row = &json["changed"][0];
    assert_eq!(
        (&row["property"], &row["a"], &row["b"], &row["a_is_set"]),
        (&"metallic".into(), &0.0.into(), &1.0.into(), &false.into())
    );
    assert!(json["flip_mean"].as_f64().unwrap() > 0.01, "{json}");
    let picture = image::open(place.path("d.png")).unwrap().into_rgb8();
    assert_eq!((picture.width(), picture.height() >= 48), (240, true));
    let text = run(&place, &["diff", "a.asm.ron", "b.asm.ron"]);
    assert_eq!((text.code, text.out.as_str()), (Some(1), "metallic: 0.0 (default) -> 1.0\n1 difference\n"));
}

#[test]
fn versions_are_merged_and_conflicts_told() {
    let place = Place::new();
    write(&place, "base.asm.ron", "A", "\"roughness\": 0.2, \"coat\": 0.5");
    write(&place, "a.asm.ron", "A", "\"roughness\": 0.3, \"coat\": 0.5");
    write(&place, "b.asm.ron", "A", "\"roughness\": 0.2, \"coat\": 0.7");
    write(&place, "c.asm.ron", "A", "\"roughness\": 0.9, \"coat\": 0.5");
    let merge = |a, b, more: &[&str]| run(&place, &[&["merge", "base.asm.ron", a, b, "--out", "out.asm.ron"], more].concat());
    let out = || fs::read_to_string(place.path("out.asm.ron")).unwrap();
    let good = merge("a.asm.ron", "b.asm.ron", &["--json"]);
    assert_eq!((good.code, &good.json()["taken"]), (Some(0), &serde_json::json!(["coat"])), "{}", good.err);
    assert!(out().contains("\"roughness\": 0.3, \"coat\": 0.7"), "{}", out());

    let open = merge("a.asm.ron", "c.asm.ron", &[]);
    assert_eq!(open.code, Some(1), "{}", open.err);
    assert!(open.out.contains("conflict: roughness: 0.2 became 0.3 in A and 0.9 in B; that of A is kept"), "{}", open.out);
    assert!(out().contains("\"roughness\": 0.3"), "{}", out());
    let decided = merge("a.asm.ron", "c.asm.ron", &["--prefer", "b", "--json"]);
    assert_eq!((decided.code, &decided.json()["conflicts"][0]["b"]), (Some(0), &"0.9".into()), "{}", decided.err);
    assert!(out().contains("\"roughness\": 0.9"), "{}", out());
}
