//! The lossless file, case by case: what is read, what is refused, and what an edit changes in the text.

use burnish_material::Property as P;
use burnish_material::{Channel, FileError, Material, MaterialFile, Property, TextureRef, Value, Warning, Wrap};

fn read(text: &str) -> (MaterialFile, Vec<Warning>) {
    MaterialFile::parse(text).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

/// Reads, edits and writes; checks that the result reads back as the edited material and that taking the edit back,
/// also after rereading, gives a text that reads as the original.
fn edit(text: &str, change: impl Fn(&mut Material)) -> String {
    let (file, _) = read(text);
    assert_eq!(file.to_text(file.material()), text);
    let mut edited = file.material().clone();
    change(&mut edited);
    let new = file.to_text(&edited);
    let (reread, _) = read(&new);
    assert_eq!(reread.material(), &edited, "\n{text}\n{new}");
    assert_eq!(read(&reread.to_text(file.material())).0.material(), file.material(), "\n{new}");
    // What is unknown goes only together with the texture that holds it.
    let kept: Vec<_> = file.unknown_keys().iter().filter(|key| new.contains("\"lod\"") || !key.ends_with(".lod")).collect();
    assert!(reread.unknown_keys().iter().eq(kept), "{new}");
    new
}

fn set(property: Property, x: f64) -> impl Fn(&mut Material) {
    move |m| _ = m.set(property, Value::Float(x))
}

fn reset(property: Property) -> impl Fn(&mut Material) {
    move |m| *m.slot_mut(property) = Default::default()
}

const GOLD: &str = r#"// comments are welcome
{
    "asm": "4.0",
    "name": "Gold, polished", // its name
    "tags": ["metal", "measured"],
    "notes": "",
    "unit_mm": 1.0,
    "provenance": { "source": "refractiveindex.info", "licence": "CC0-1.0" },
    "sources": {"base_color": {"dataset": "Yakubovsky", "licence": "CC0-1.0", "spread_min": (0.9, 0.7, 0.3), "spread_max": (1.0, 0.8, 0.4)}},
    "properties": {
        /* linear */ "base_color": (1.00, 0.71e0, 0.31),
        "metallic": 1, // fully
        "velvet": Soft(3),
        "roughness": { "value": 3e-1, "gain": 2, "texture": { "path": "rough.png", "channel": "g", "lod": 2, "uv_scale": (2.0, 2) } },
        "scatter": true
    },
}
"#;

#[test]
fn everything_is_read() {
    let (file, warnings) = read(GOLD);
    let m = file.material();
    assert_eq!((m.name.as_str(), m.unit_mm, m.tags.len()), ("Gold, polished", Some(1.0), 2));
    assert_eq!((m.provenance.source.as_str(), m.provenance.method.as_str()), ("refractiveindex.info", ""));
    assert_eq!(m.color(P::base_color), [1.0, 0.71, 0.31]);
    assert_eq!((m.float(P::metallic), m.float(P::roughness), m.switch(P::scatter)), (1.0, 0.3, true));
    let texture = m.slot(P::roughness).texture.clone().unwrap();
    assert_eq!(texture, TextureRef { channel: Channel::G, uv_scale: [2.0; 2], ..TextureRef::new("rough.png") });
    assert_eq!(file.unknown_keys(), ["properties.velvet", "roughness.gain", "roughness.texture.lod"]);
    assert_eq!(warnings.len(), 3);
    assert!(warnings.iter().all(|warning| !warning.is_refused));
    assert_eq!(warnings[0].to_string(), "line 13: properties.velvet: unknown property; kept in the file");
    let source = file.source_of(P::base_color).unwrap();
    assert_eq!((source.dataset.as_str(), source.paper.as_str()), ("Yakubovsky", ""));
    assert_eq!(source.spread_min, Some(Value::Color([0.9, 0.7, 0.3])));
    assert_eq!(file.source_of(P::roughness), None);
}

#[test]
fn edits_change_only_their_own_text() {
    type Case<'a> = (&'a str, &'a str, &'a dyn Fn(&mut Material));
    let cases: &[Case] = &[
        ("0.71e0", "0.72", &|m| _ = m.set(P::base_color, Value::Color([1.0, 0.72, 0.31]))),
        ("\"metallic\": 1,", "\"metallic\": 0.5,", &set(P::metallic, 0.5)),
        ("3e-1", "0.125", &set(P::roughness, 0.125)),
        ("\"scatter\": true", "\"scatter\": false", &|m| _ = m.set(P::scatter, Value::Bool(false))),
        ("\"scatter\": true", "\"scatter\": true,\n        \"coat\": 1.0", &set(P::coat, 1.0)),
        ("        \"metallic\": 1, // fully\n", "", &reset(P::metallic)),
        ("        \"scatter\": true\n", "", &reset(P::scatter)),
        ("/* linear */ \"base_color\": (1.00, 0.71e0, 0.31),", "/* linear */", &reset(P::base_color)),
        ("\"value\": 3e-1, \"gain\"", "\"gain\"", &|m| m.slot_mut(P::roughness).value = None),
        (
            "\"value\": 3e-1, \"gain\": 2, \"texture\": { \"path\": \"rough.png\", \"channel\": \"g\", \"lod\": 2, \"uv_scale\": (2.0, 2) }",
            "\"gain\": 2",
            &reset(P::roughness),
        ),
        ("\"g\"", "\"b\"", &|m| m.slot_mut(P::roughness).texture.as_mut().unwrap().channel = Channel::B),
        ("(2.0, 2)", "(2.0, 3.0)", &|m| m.slot_mut(P::roughness).texture.as_mut().unwrap().uv_scale[1] = 3.0),
        ("(2.0, 2) }", "(2.0, 2), \"wrap\": \"clamp\" }", &|m| {
            m.slot_mut(P::roughness).texture.as_mut().unwrap().wrap = Wrap::Clamp
        }),
        ("(2.0, 2) }", "(2.0, 2), \"invert\": true }", &|m| {
            m.slot_mut(P::roughness).texture.as_mut().unwrap().is_inverted = true
        }),
        ("\"Gold, polished\"", "\"Say \\\"Gold\\\"\\n\\\\ é\"", &|m| m.name = "Say \"Gold\"\n\\ é".into()),
        ("\"measured\"]", "\"measured\", \"warm\"]", &|m| m.tags.push("warm".into())),
        ("\"metal\", ", "", &|m| _ = m.tags.remove(0)),
        (", \"measured\"", "", &|m| _ = m.tags.pop()),
        ("    \"tags\": [\"metal\", \"measured\"],\n", "", &|m| m.tags.clear()),
        ("\"notes\": \"\"", "\"notes\": \"n\"", &|m| m.notes = "n".into()),
        ("    \"unit_mm\": 1.0,\n", "", &|m| m.unit_mm = None),
        ("\"unit_mm\": 1.0", "\"unit_mm\": 10.0", &|m| m.unit_mm = Some(10.0)),
        ("\"CC0-1.0\" }", "\"CC0-1.0\", \"method\": \"read\" }", &|m| m.provenance.method = "read".into()),
        (", \"licence\": \"CC0-1.0\" }", " }", &|m| m.provenance.licence.clear()),
        ("    \"provenance\": { \"source\": \"refractiveindex.info\", \"licence\": \"CC0-1.0\" },\n", "", &|m| {
            m.provenance = Default::default()
        }),
    ];
    for (old, new, change) in cases {
        assert_eq!(GOLD.matches(old).count(), 1, "{old}");
        assert_eq!(edit(GOLD, change), GOLD.replacen(old, new, 1));
    }
}

#[test]
fn entries_come_and_go_in_any_layout() {
    let add = |text: &str| edit(text, |m| _ = m.set(P::coat, Value::Float(1.0)).set(P::sheen, Value::Float(0.5)));
    for (text, expected) in [
        ("{}", r#"{ "properties": { "sheen": 0.5, "coat": 1.0, } }"#),
        (r#"{"asm":"4.0"}"#, r#"{"asm":"4.0", "properties": { "sheen": 0.5, "coat": 1.0, }}"#),
        (r#"{"properties":{}}"#, r#"{"properties":{ "sheen": 0.5, "coat": 1.0 }}"#),
        (r#"{"properties":{"metallic":1}}"#, r#"{"properties":{"metallic":1, "sheen": 0.5, "coat": 1.0}}"#),
        (r#"{"properties":{"metallic":1,}}"#, r#"{"properties":{"metallic":1, "sheen": 0.5, "coat": 1.0,}}"#),
        (r#"{"properties":{ /* none */ }}"#, r#"{"properties":{ /* none */ "sheen": 0.5, "coat": 1.0 }}"#),
        (
            "{\n  \"asm\": \"4.0\" // v\n}",
            "{\n  \"asm\": \"4.0\", // v\n  \"properties\": {\n    \"sheen\": 0.5,\n    \"coat\": 1.0,\n  }\n}",
        ),
        ("{\n\t\"properties\": {},\n}", "{\n\t\"properties\": {\n\t\t\"sheen\": 0.5,\n\t\t\"coat\": 1.0,\n\t},\n}"),
        (
            "{\r\n \"properties\": {\r\n  // none yet\r\n }\r\n}\r\n",
            "{\r\n \"properties\": {\r\n  // none yet\r\n  \"sheen\": 0.5,\r\n  \"coat\": 1.0,\r\n }\r\n}\r\n",
        ),
        (
            "{ \"properties\": {\n  \"metallic\": 1 // one\n  , // two\n} }",
            "{ \"properties\": {\n  \"metallic\": 1 // one\n  , // two\n  \"sheen\": 0.5,\n  \"coat\": 1.0,\n} }",
        ),
        (
            "{ \"properties\": {\n  \"metallic\": 1 /* a\n b */ } }",
            "{ \"properties\": {\n  \"metallic\": 1,\n  \"sheen\": 0.5,\n  \"coat\": 1.0 /* a\n b */ } }",
        ),
        (
            "{ \"properties\": {\n  \"metallic\": 1, // a\r\n} }",
            "{ \"properties\": {\n  \"metallic\": 1, // a\n  \"sheen\": 0.5,\n  \"coat\": 1.0,\r\n} }",
        ),
        ("\u{feff}{\"properties\": 3}", "\u{feff}{\"properties\": { \"sheen\": 0.5, \"coat\": 1.0, }}"),
    ] {
        assert_eq!(add(text), expected);
    }
    let remove = |text: &str| edit(text, |m| m.slot_mut(P::metallic).value = None);
    for (text, expected) in [
        (r#"{"properties":{"metallic":1}}"#, r#"{"properties":{}}"#),
        (r#"{"properties":{"metallic":1,"coat":1}}"#, r#"{"properties":{"coat":1}}"#),
        (r#"{"properties":{"coat":1, "metallic":1}}"#, r#"{"properties":{"coat":1}}"#),
        (r#"{"properties":{"coat":1, /* c */ "metallic":1}}"#, r#"{"properties":{"coat":1, /* c */}}"#),
        (r#"{"properties":{ "metallic": 1 /* c */ , "coat":1}}"#, r#"{"properties":{ "coat":1}}"#),
        ("{\"properties\":{ \"coat\":1, \"metallic\": 1, // both\n }}", "{\"properties\":{ \"coat\":1, // both\n }}"),
        ("{\"properties\":{\n \"coat\":1, \"metallic\": 1,\n }}", "{\"properties\":{\n \"coat\":1,\n }}"),
        ("{\"properties\":{\n // keep\n \"metallic\": 1, // go\n }}", "{\"properties\":{\n // keep\n }}"),
        ("{\"properties\":{\n \"metallic\": 1, /* keep\n this */\n }}", "{\"properties\":{\n /* keep\n this */\n }}"),
        ("{\"properties\":{\n \"metallic\":\n // here\n 1\n }}", "{\"properties\":{\n }}"),
        ("{\"properties\":{\r\n \"metallic\": 1, // go\r\n \"coat\": 1 }}", "{\"properties\":{\r\n \"coat\": 1 }}"),
    ] {
        assert_eq!(remove(text), expected);
    }
}

#[test]
fn entries_that_go_make_room_for_those_that_come() {
    let swap = |text: &str| {
        edit(text, |m| {
            *m.slot_mut(P::metallic) = Default::default();
            _ = m.set(P::coat, Value::Float(1.0));
        })
    };
    assert_eq!(swap(r#"{"properties":{"metallic":1}}"#), r#"{"properties":{"coat": 1.0}}"#);
    assert_eq!(swap(r#"{"properties":{"sheen":1, "metallic":1}}"#), r#"{"properties":{"sheen":1, "coat": 1.0}}"#);
    assert_eq!(
        swap("{\"properties\":{\n \"sheen\":1, // s\n \"metallic\":1, // m\n}}"),
        "{\"properties\":{\n \"sheen\":1, // s\n \"coat\": 1.0,\n}}"
    );
}

#[test]
fn textures_wrap_the_spelling_that_stands_there() {
    let texture = |m: &mut Material| m.slot_mut(P::base_color).texture = Some(TextureRef::new("a.png"));
    let text = "{\"properties\":{\"base_color\": [1.0, // red\n .5, 0_0.2]}}";
    assert_eq!(
        edit(text, texture),
        "{\"properties\":{\"base_color\": { \"value\": [1.0, // red\n .5, 0_0.2], \"texture\": { \"path\": \"a.png\" } }}}"
    );
    // What cannot be read goes along too.
    assert_eq!(
        edit(r#"{"properties":{"base_color": NaN}}"#, texture),
        r#"{"properties":{"base_color": { "value": NaN, "texture": { "path": "a.png" } }}}"#
    );
}

#[test]
fn refused_values_stay_until_they_are_set() {
    for (bad, words) in [
        ("NaN", "found NaN"),
        ("inf", "found inf"),
        ("-inf", "found -inf"),
        ("1e400", "found 1e400"),
        ("0x10", "found 0x10"),
        ("1.0f32", "found 1.0f32"),
        ("\"0.5\"", "expected a number, found \"0.5\""),
        ("true", "expected a number, found true"),
        ("(1.0, 2.0, 3.0)", "expected a number"),
        ("Some(0.5)", "expected a number"),
        ("Rough", "found Rough"),
    ] {
        let text = format!("{{ \"asm\": \"4.0\",\n \"properties\": {{ \"coat\": 1,\n \"roughness\": {bad} }} }}");
        let (file, warnings) = read(&text);
        assert_eq!(warnings.len(), 1, "{warnings:?}");
        assert!(warnings[0].is_refused);
        let line = warnings[0].to_string();
        assert!(line.starts_with("line 3: roughness: expected ") && line.contains(words), "{line}");
        assert!(line.ends_with("; kept in the file, default used"), "{line}");
        assert_eq!(warnings[0].column, 15);
        assert_eq!(file.material().slot(P::roughness).value, None);
        assert_eq!(file.material().float(P::coat), 1.0);
        let unreadable = &file.unreadable()[0];
        assert_eq!((unreadable.property, unreadable.text.as_str(), unreadable.line), (P::roughness, bad, 3));
        assert_eq!(edit(&text, set(P::coat, 0.5)), text.replace("\"coat\": 1", "\"coat\": 0.5"));
        assert_eq!(edit(&text, set(P::roughness, 0.5)), text.replace(bad, "0.5"));
    }
    for (key, bad) in [
        ("base_color", "(1.0, 0.5)"),
        ("base_color", "(1.0, 0.5, NaN)"),
        ("base_color", "(1.0, 0.5, 0.5, 0.5)"),
        ("base_color", "(r: 1.0, g: 0.5, b: 0.5)"),
        ("base_color", "Rgb(1.0, 0.5, 0.5)"),
        ("base_color", "0.5"),
        ("normal", "\"n.png\""),
        ("scatter", "1"),
        ("roughness", "{ \"texture\": \"a.png\" }"),
        ("roughness", "{ \"texture\": { \"channel\": \"g\" } }"),
        ("roughness", "{ \"texture\": { \"path\": 3 } }"),
    ] {
        let (file, warnings) = read(&format!("{{\"asm\":\"4.0\",\"properties\":{{\"{key}\":{bad}}}}}"));
        assert!(warnings.len() == 1 && warnings[0].is_refused, "{key} {bad} {warnings:?}");
        assert_eq!(file.material(), &Material::default());
        assert_eq!(file.unreadable().len(), 1);
    }
    for (key, bad) in [
        ("name", "3"),
        ("tags", "[\"a\", 3]"),
        ("tags", "\"a\""),
        ("aliases", "[3]"),
        ("unit_mm", "inf"),
        ("provenance", "[]"),
        ("properties", "3"),
    ] {
        let text = format!("{{\"asm\":\"4.0\",\"{key}\":{bad}}}");
        let (file, warnings) = read(&text);
        assert!(warnings.len() == 1 && warnings[0].is_refused && warnings[0].key == key, "{key} {warnings:?}");
        assert_eq!(file.material(), &Material::default());
        edit(&text, |m| {
            (m.name, m.notes, m.tags, m.unit_mm) = ("n".into(), "n".into(), vec!["t".into()], Some(2.0));
            m.aliases = vec!["o".into()];
            m.provenance.method = "m".into();
            _ = m.set(P::coat, Value::Float(1.0));
        });
    }
}

#[test]
fn a_bad_field_of_a_texture_costs_only_itself() {
    let text = r#"{"asm":"4.0","properties":{"roughness":{"texture":{"path":"a.png","channel":"q","uv_scale":(NaN, 1),"invert":1,"wrap":"clamp"}}}}"#;
    let (file, warnings) = read(text);
    let keys: Vec<_> = warnings.iter().map(|warning| warning.key.as_str()).collect();
    assert_eq!(keys, ["roughness.texture.channel", "roughness.texture.uv_scale", "roughness.texture.invert"]);
    assert_eq!(warnings[2].message, "expected true or false, found 1; kept in the file, default used");
    let texture = TextureRef { wrap: Wrap::Clamp, ..TextureRef::new("a.png") };
    assert_eq!(file.material().slot(P::roughness).texture, Some(texture));
    assert_eq!(file.unreadable().len(), 3);
    let new = edit(text, |m| m.slot_mut(P::roughness).texture.as_mut().unwrap().uv_scale = [1.0, 2.0]);
    assert_eq!(new, text.replace("(NaN, 1)", "(1.0, 2.0)"));
}

#[test]
fn inversion_is_written_where_it_is_on() {
    let mut material = Material::default();
    for (is_inverted, text) in [(true, r#"{ "path": "g.png", "invert": true }"#), (false, r#"{ "path": "g.png" }"#)] {
        material.slot_mut(P::roughness).texture = Some(TextureRef { is_inverted, ..TextureRef::new("g.png") });
        let file = MaterialFile::new(&material);
        assert!(file.text().contains(text), "{}", file.text());
        assert_eq!(file.material(), &material);
        let turned = edit(file.text(), |m| m.slot_mut(P::roughness).texture.as_mut().unwrap().is_inverted = !is_inverted);
        assert_eq!(read(&turned).0.material().slot(P::roughness).texture.as_ref().map(|t| t.is_inverted), Some(!is_inverted));
    }
}

#[test]
fn strange_files_open_with_warnings() {
    for (text, line) in [
        ("{\"asm\": \"3.0\"}", "line 1: asm: expected \"4.0\", found \"3.0\"; read as 4.0"),
        ("{\n\"asm\": 4}", "line 2: asm: expected \"4.0\", found 4; read as 4.0"),
        ("// empty\n{}", "line 2: asm: expected \"4.0\", found no version; read as 4.0"),
        ("{\"asm\": \"4.0\", \"future\": Some({1: 2})}", "line 1: future: unknown key; kept in the file"),
        ("{\"asm\": \"4.0\", name: \"x\"}", "line 1: name: expected a key in quotes; kept in the file"),
        (
            "{\"asm\": \"4.0\", \"properties\": {\"baseColor\": (1, 1, 1)}}",
            "line 1: properties.baseColor: expected the formal name \"base_color\"; kept in the file",
        ),
        (
            "{\"asm\": \"4.0\", \"properties\": {\"coat\": 1e-400}}",
            "line 1: coat: expected a number from 5e-324 on, found 1e-400; used as 0",
        ),
    ] {
        let (file, warnings) = read(text);
        assert_eq!(warnings.iter().map(|warning| warning.to_string()).collect::<Vec<_>>(), [line]);
        assert!(!warnings[0].is_refused);
        assert_eq!(file.text(), text);
    }
    assert!(read("{\"asm\":\"4.0\",\"properties\":{\"coat\":0e-400,\"base_color\":(0.0, -0.0, 5e-324)}}").1.is_empty());
}

#[test]
fn unusable_texts_are_errors() {
    for (text, words) in [
        ("", "line 1, column 1: not valid RON: expected opening `{`"),
        ("{\n  \"a\": 1\n  \"b\": 2 }", "line 3, column 3: not valid RON: expected comma"),
        ("{\"a\": }", "not valid RON"),
        ("{} {}", "not valid RON"),
        ("{\"a\": \"", "not valid RON"),
        ("{ /* ", "not valid RON: unclosed block comment"),
        ("// c\n[1, 2]", "line 2, column 1: expected a map"),
        ("(\"asm\": 3)", "not valid RON"),
        ("Material", "expected a map"),
        ("3", "expected a map"),
        ("(1, 2)", "expected a map"),
        ("{\"name\": \"a\",\n\"name\": \"b\"}", "line 2: name: expected each key once, but it already stands in line 1"),
        ("{\"name\": \"a\", \"n\\u{61}me\": \"b\"}", "line 1: name: expected each key once"),
        ("{\"properties\": {\"coat\": 1, \"coat\": 1}}", "properties.coat: expected each key once"),
        ("{\"properties\": {\"coat\": {\"value\": 1, \"value\": 1}}}", "coat.value: expected each key once"),
        ("{\"properties\": {\"coat\": {\"texture\": {\"a\": 1, \"a\": 1}}}}", "coat.texture.a: expected each key once"),
        ("{\"provenance\": {\"a\": 1, \"a\": 1}}", "provenance.a: expected each key once"),
    ] {
        let error = MaterialFile::parse(text).expect_err(text).to_string();
        assert!(error.contains(words), "{text:?}: {error}");
    }
}

#[test]
fn extensions_and_attributes_open() {
    let text = "#![enable(implicit_some)]\n{\"asm\": \"4.0\", \"properties\": {\"coat\": 1}}";
    assert_eq!(edit(text, set(P::coat, 0.5)), text.replace(": 1}", ": 0.5}"));
    // Whatever only an extension makes valid is an error, never a crash.
    _ = MaterialFile::parse("#![enable(implicit_some)]\n{\"x\": Some 3}");
    _ = MaterialFile::parse("#![enable(unwrap_variant_newtypes)]\n{\"x\": Some(1, 2)}");
}

#[test]
fn a_new_file_holds_its_material() {
    let mut material = Material::named("Glass \u{7} \u{2028}\"\\");
    material.tags = vec!["clear".into(), "ünï".into()];
    material.notes = "two\r\nlines".into();
    material.unit_mm = Some(1.0);
    material.provenance.source = "me".into();
    material.set(P::translucency, Value::Float(1.0)).set(P::specular_ior, Value::Float(1.5168));
    material.slot_mut(P::roughness).texture = Some(TextureRef { wrap: Wrap::Mirror, ..TextureRef::new("r \"1\".png") });
    let file = MaterialFile::new(&material);
    assert_eq!(file.material(), &material);
    assert_eq!(file.changed(&material), 0);
    assert!(file.unknown_keys().is_empty() && file.unreadable().is_empty());
    assert_eq!(read(file.text()).1, []);
    let expected = r#"{
    "asm": "4.0",
    "name": "Water",
    "provenance": {
        "source": "me",
    },
    "properties": {
        "translucency": 1.0,
        "specular_ior": 1.33,
    },
}
"#;
    let mut water = Material::named("Water");
    water.provenance.source = "me".into();
    water.set(P::translucency, Value::Float(1.0)).set(P::specular_ior, Value::Float(1.33));
    assert_eq!(MaterialFile::new(&water).text(), expected);
    assert_eq!(MaterialFile::new(&Material::default()).text(), "{\n    \"asm\": \"4.0\",\n}\n");
}

#[test]
fn differences_are_counted_by_entry() {
    let (file, _) = read(GOLD);
    let mut edited = file.material().clone();
    assert_eq!(file.changed(&edited), 0);
    edited.set(P::coat, Value::Float(0.0)).set(P::roughness, Value::Float(0.1));
    edited.slot_mut(P::roughness).texture = None;
    edited.name.push('!');
    edited.provenance.licence.clear();
    assert_eq!(file.changed(&edited), 4);
}

#[test]
fn bombs_end_in_time() {
    let deep = |open: &str, close: &str, n: usize| format!("{{\"a\": {}1{}}}", open.repeat(n), close.repeat(n));
    for (open, close) in [("[", "]"), ("(", ")"), ("{1:", "}"), ("Some(", ")"), ("A(", ")"), ("/*", "*/")] {
        for n in [100, 127, 200, 100_000] {
            _ = MaterialFile::parse(&deep(open, close, n));
            _ = MaterialFile::parse(&deep(open, "", n));
        }
    }
    let long = format!("{{\"name\": \"{}\", \"tags\": [{}]}}", "x".repeat(4 << 20), "\"t\",".repeat(100_000));
    assert_eq!(read(&long).0.material().name.len(), 4 << 20);
    let many: String = (0..100_000).map(|i| format!("\"k{i}\": {{\"v\": [1, 2]}},\n")).collect();
    let (file, warnings) = read(&format!("{{{many}}}"));
    assert_eq!(file.unknown_keys().len(), 100_000);
    assert!(warnings.len() < 2000 && warnings.last().unwrap().message.contains("more warnings"));
    let huge = format!("{{\"name\": \"{}\"}}", "x".repeat(100 << 20));
    assert!(matches!(MaterialFile::parse(&huge), Err(FileError::TooLarge { .. })));
}
