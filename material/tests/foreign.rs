//! Texts of other formats: how a file holds them, and how they are compared and merged.

use burnish_material::diff::{can_take, changes, file_changes, take};
use burnish_material::merge::{Side, merge, merge_files};
use burnish_material::{ForeignError, MAX_FOREIGN_BYTES, MAX_FOREIGN_TEXTS, Material, MaterialFile, Warning};

fn read(text: &str) -> (MaterialFile, Vec<Warning>) {
    MaterialFile::parse(text).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

fn with(texts: &[(&str, &str, &str)]) -> Material {
    let mut material = Material::named("m");
    for (format, key, text) in texts {
        material.set_foreign(format, key, Some((*text).to_owned())).expect("the text is taken");
    }
    material
}

const IRIDESCENCE: &str = r#"{"iridescenceFactor":1.0}"#;

/// Two texts of glTF and one of USD.
fn three() -> Material {
    let gltf = [("gltf", "KHR_materials_iridescence", IRIDESCENCE), ("gltf", "extras", "{\n\t\"a\": [1, \"é\"]\n}")];
    with(&[gltf[0], gltf[1], ("usd", "ui", "null")])
}

const THREE: &str = r#"{
    "asm": "4.0",
    "name": "m",
    "foreign": {
        "gltf": {
            "KHR_materials_iridescence": "{\"iridescenceFactor\":1.0}",
            "extras": "{\n\t\"a\": [1, \"é\"]\n}",
        },
        "usd": {
            "ui": "null",
        },
    },
}
"#;

#[test]
fn files_hold_them() {
    let file = MaterialFile::new(&three());
    assert_eq!(file.text(), THREE);
    let (file, warnings) = read(THREE);
    assert_eq!(warnings, []);
    assert_eq!(file.material(), &three());
    assert_eq!(file.material().foreign_text("gltf", "KHR_materials_iridescence"), Some(IRIDESCENCE));
    assert!(file.unknown_keys().is_empty());
}

#[test]
fn edits_change_only_their_own_text() {
    let (file, _) = read(THREE);
    let edit = |change: &dyn Fn(&mut Material)| {
        let mut edited = file.material().clone();
        change(&mut edited);
        let new = file.to_text(&edited);
        assert_eq!(read(&new).0.material(), &edited, "{new}");
        (file.changed(&edited), new)
    };
    let set = |m: &mut Material, format: &str, key: &str, text: Option<&str>| {
        m.set_foreign(format, key, text.map(str::to_owned)).expect("the text is taken");
    };
    assert_eq!(edit(&|m| set(m, "usd", "ui", Some("[]"))), (1, THREE.replace("\"null\"", "\"[]\"")));
    let added = THREE.replace("\"null\",\n", "\"null\",\n            \"x\": \"1\",\n");
    assert_eq!(edit(&|m| set(m, "usd", "x", Some("1"))), (1, added));
    let without_usd = THREE.replace("        \"usd\": {\n            \"ui\": \"null\",\n        },\n", "");
    assert_eq!(edit(&|m| set(m, "usd", "ui", None)), (1, without_usd));
    let other = "        },\n        \"mtlx\": {\n            \"x\": \"1\",\n        },\n    },\n}";
    assert_eq!(edit(&|m| set(m, "mtlx", "x", Some("1"))), (1, THREE.replace("        },\n    },\n}", other)));
    assert_eq!(edit(&|m| m.foreign.clear()), (3, "{\n    \"asm\": \"4.0\",\n    \"name\": \"m\",\n}\n".to_owned()));
}

#[test]
fn what_is_strange_is_kept_with_one_warning() {
    for (text, key, expected) in [
        ("[1]", "foreign", "expected a map { … } of maps of texts"),
        ("{\"gltf\": 3}", "foreign.gltf", "expected a map { … } of texts"),
        ("{gltf: {}}", "foreign.gltf", "expected a map { … } of texts"),
        ("{\"gltf\": {\"a\": 3}}", "foreign.gltf.a", "expected JSON as a text"),
        ("{\"gltf\": {a: \"3\"}}", "foreign.gltf.a", "expected JSON as a text"),
        ("{\"gltf\": {\"a\": \"{\"}}", "foreign.gltf.a", "expected JSON as a text"),
        ("{\"gltf\": {\"a\": \"[NaN]\"}}", "foreign.gltf.a", "expected JSON as a text"),
        ("{\"gltf\": {\"a\": \"1e999\"}}", "foreign.gltf.a", "expected JSON as a text"),
        ("{\"gltf\": {\"a\\u{7}\": \"3\"}}", "foreign.gltf.a ", "expected names of at most 200 bytes without control characters"),
    ] {
        let text = format!("{{\"asm\": \"4.0\", \"foreign\": {text} /* kept */}}");
        let (file, warnings) = read(&text);
        assert_eq!(file.material(), &Material::default(), "{text}");
        assert_eq!(warnings.len(), 1, "{text}: {warnings:?}");
        assert_eq!((warnings[0].key.as_str(), &warnings[0].message), (key, &format!("{expected}; kept in the file")));
        assert!(!warnings[0].is_refused);
        assert_eq!(file.unknown_keys(), [key]);
        // It stays beside others, and gives way to one that takes its place.
        for (format, name) in [("usd", "x"), ("gltf", "a")] {
            let mut edited = file.material().clone();
            edited.set_foreign(format, name, Some("1".to_owned())).expect("the text is taken");
            let new = file.to_text(&edited);
            assert_eq!(read(&new).0.material(), &edited, "{new}");
            assert!(new.ends_with("/* kept */}"), "{new}");
            assert_eq!(new.contains("NaN"), text.contains("NaN") && format == "usd", "{new}");
        }
    }
    let twice = MaterialFile::parse("{\"foreign\": {\"gltf\": {\"a\": \"1\", \"a\": \"2\"}}}").expect_err("a key stands twice");
    assert!(twice.to_string().contains("foreign.gltf.a: expected each key once"), "{twice}");
}

#[test]
fn there_is_an_end_to_it() {
    let mut material = Material::default();
    let mut set = |key: &str, text: String| material.set_foreign("gltf", key, Some(text));
    let long = |bytes: usize| format!("\"{}\"", "x".repeat(bytes - 2));
    assert_eq!(set("a", long(MAX_FOREIGN_BYTES + 1)), Err(ForeignError::TooMuch));
    assert_eq!(set("a", long(MAX_FOREIGN_BYTES)), Ok(()));
    assert_eq!(set("b", "1".to_owned()), Err(ForeignError::TooMuch));
    // What goes makes room for what comes.
    assert_eq!(set("a", long(MAX_FOREIGN_BYTES - 1)), Ok(()));
    assert_eq!(set("b", "1".to_owned()), Ok(()));
    assert_eq!(set("c", "22".to_owned()), Err(ForeignError::TooMuch));
    assert_eq!(set("b", "[".repeat(500) + &"]".repeat(500)), Err(ForeignError::NotJson));
    assert_eq!(set(&"k".repeat(201), "1".to_owned()), Err(ForeignError::Name));
    assert_eq!(read(MaterialFile::new(&material).text()).0.material(), &material);

    for entry in ["\"1\"", "\"{\"", "3"] {
        let many: String = (0..20_000).map(|i| format!("\"{i}\":{entry},")).collect();
        let (file, warnings) = read(&format!("{{\"asm\": \"4.0\", \"foreign\": {{\"x\": {{{many}}}}}}}"));
        let count = file.material().foreign.get("x").map_or(0, |texts| texts.len());
        assert_eq!(count, if entry == "\"1\"" { MAX_FOREIGN_TEXTS } else { 0 });
        assert!(warnings.len() < 2000 && file.unknown_keys().len() == 20_000 - count);
    }
}

#[test]
fn differences_are_told_and_taken_one_by_one() {
    let a = three();
    let b =
        with(&[("gltf", "KHR_materials_iridescence", "{}"), ("gltf", "extras", "{\n\t\"a\": [1, \"é\"]\n}"), ("x.y", "z", "1")]);
    let found = changes(&a, &b);
    let entries: Vec<_> = found.iter().map(|change| (change.key.as_str(), change.a.as_deref(), change.b.as_deref())).collect();
    let quoted = "\"{\\\"iridescenceFactor\\\":1.0}\"";
    assert_eq!(
        entries,
        [
            ("foreign.gltf.KHR_materials_iridescence", Some(quoted), Some("\"{}\"")),
            ("foreign.usd.ui", Some("\"null\""), None),
            ("foreign.x.y.z", None, Some("\"1\"")),
        ]
    );
    assert!(found.iter().all(|change| !change.is_visible && change.property.is_none()));
    let mut taken = a.clone();
    for (done, change) in found.iter().enumerate() {
        assert_eq!(changes(&taken, &b).len(), found.len() - done);
        assert!(take(&mut taken, &b, &change.key));
    }
    assert_eq!(taken, b);
    for (key, is_there) in [("foreign.x.y.z", true), ("foreign.usd.ui", false), ("foreign.", false), ("foreign", false)] {
        assert_eq!((can_take(&taken, &b, key), take(&mut taken, &b, key)), (is_there, is_there), "{key}");
    }
    assert!(can_take(&a, &b, "foreign.usd.ui") && can_take(&a, &b, "roughness.texture") && !can_take(&a, &b, "velvet"));
    // The same of files, with what is strange in one of them.
    let strange = read("{\"asm\": \"4.0\", \"name\": \"m\", \"foreign\": {\"x\": 3}}").0;
    let keys: Vec<_> = file_changes(&MaterialFile::new(&b), &strange).into_iter().map(|change| change.key).collect();
    assert_eq!(keys, ["foreign.gltf.KHR_materials_iridescence", "foreign.gltf.extras", "foreign.x.y.z", "foreign.x"]);
}

#[test]
fn versions_are_merged_text_by_text() {
    let base = with(&[("gltf", "a", "1"), ("gltf", "b", "1"), ("usd", "c", "1"), ("usd", "d", "1")]);
    let a = with(&[("gltf", "a", "2"), ("gltf", "b", "1"), ("usd", "d", "2"), ("usd", "e", "1")]);
    let b = with(&[("gltf", "a", "1"), ("gltf", "b", "2"), ("usd", "c", "1"), ("usd", "d", "3"), ("mtlx", "f", "1")]);
    let expected =
        |d: &'static str| with(&[("gltf", "a", "2"), ("gltf", "b", "2"), ("usd", "d", d), ("usd", "e", "1"), ("mtlx", "f", "1")]);
    for (prefer, d) in [(Side::A, "2"), (Side::B, "3")] {
        let merged = merge(&base, &a, &b, prefer);
        assert_eq!(merged.material, expected(d));
        let conflicts: Vec<_> = merged.conflicts.iter().map(|conflict| conflict.key.as_str()).collect();
        assert_eq!(conflicts, ["foreign.usd.d"]);
        assert_eq!(merged.conflicts[0].a.as_deref(), Some("\"2\""));
    }
    let [base, a, b] = [base, a, b].map(|material| MaterialFile::new(&material));
    let merged = merge_files(&base, &a, &b, Side::B);
    assert_eq!(read(&merged.text).0.material(), &expected("3"));
    assert_eq!(merged.left_out, []);
}
