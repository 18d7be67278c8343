//! MaterialX documents that are broken on purpose: one clear error each, or a note, and never more than bounded work.

#[path = "common/mtlx.rs"]
mod mtlx;

use burnish_material::exchange::materialx::{
    MAX_BYTES, MAX_DEPTH, MAX_ELEMENTS, MAX_MATERIALS, ReadError, WriteOptions, read, write,
};
use burnish_material::{Material, PROPERTIES, Property, TextureRef};
use mtlx::{color, document, near, node, number, one, open_pbr};
use proptest::prelude::*;

proptest! {
    #![proptest_config(ProptestConfig { cases: 100, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn a_damaged_document_is_read_or_refused(places in proptest::collection::vec((any::<prop::sample::Index>(), "[a-z0-9<>/\"=&;.,{} -]{0,4}"), 1..6)) {
        let mut material = Material::named("a");
        for def in PROPERTIES {
            material.slot_mut(def.id).texture = Some(TextureRef::new("a.png"));
        }
        material.slot_mut(Property::roughness).texture = None;
        let mut text = write(&[&material], &WriteOptions::default()).text;
        // The definition is not read.
        let from = text.find("</nodedef>").unwrap_or(0);
        for (place, new) in &places {
            let at = from + place.index(text.len() - from);
            let end = (at + new.len()).min(text.len());
            text.replace_range(at..end, new);
        }
        let first = read(&text);
        prop_assert_eq!(&first, &read(&text));
        for found in first.unwrap_or_default() {
            for (_, slot) in found.material.slots() {
                prop_assert!(slot.value.is_none_or(|value| value.numbers().iter().all(|x| x.is_finite())));
                prop_assert!(slot.texture.as_ref().is_none_or(is_finite));
            }
            prop_assert!(read(&write(&[&found.material], &WriteOptions::default()).text).is_ok());
        }
    }
}

fn is_finite(texture: &TextureRef) -> bool {
    let TextureRef { scale, bias, uv_scale, uv_offset, uv_rotation, .. } = texture;
    [scale.as_slice(), bias, uv_scale, uv_offset, &[*uv_rotation]].concat().iter().all(|x| x.is_finite())
}

#[test]
fn products_that_are_not_finite_are_not_taken() {
    let huge = "1e300, 1e300, 1e300";
    let inputs = format!(
        "<input name=\"subsurface_weight\" type=\"float\" value=\"1\" /><input name=\"subsurface_radius\" type=\"float\" value=\"1e300\" />
         <input name=\"subsurface_radius_scale\" type=\"color3\" value=\"{huge}\" />"
    );
    let found = open_pbr("", &inputs);
    assert!(found.material.slot(Property::scatter_distance).value.is_none(), "{found:?}");
    assert!(found.notes.iter().any(|note| note.contains("scatter_distance: expected finite")), "{:?}", found.notes);
    let image = node("image", "i", "color3", &[("file", "filename", "a.png")]);
    let scaled = image + &node("multiply", "f", "color3", &[("in1", "color3", "@i"), ("in2", "color3", huge)]);
    let found = color(&(scaled + &node("multiply", "o", "color3", &[("in1", "color3", "@f"), ("in2", "color3", huge)])));
    assert!(found.material.slot(Property::base_color).texture.as_ref().is_none_or(is_finite));
}

#[test]
fn circles_and_depth_end() {
    let circle = node("add", "a", "color3", &[("in1", "color3", "@b")]) + &node("add", "b", "color3", &[("in1", "color3", "@a")]);
    let found = color(&(circle + &node("dot", "o", "color3", &[("in", "color3", "@a")])));
    assert!(found.notes.iter().any(|note| note.contains("connected to itself")), "{:?}", found.notes);
    let own = "<nodegraph name=\"g\"><input name=\"x\" type=\"float\" interfacename=\"x\" /><output name=\"o\" type=\"float\" nodegraph=\"g\" output=\"o\" /></nodegraph>";
    assert!(!open_pbr(own, "<input name=\"coat_weight\" type=\"float\" nodegraph=\"g\" output=\"o\" />").notes.is_empty());

    // A long chain, last node first: no recursion, each node once.
    let count = 20_000;
    let chain: String = (0..count).rev().map(|k| format!("<add name=\"n{}\"  type=\"float\"><input name=\"in1\" type=\"float\" nodename=\"n{k}\" /><input name=\"in2\" type=\"float\" value=\"0.000025\" /></add>", k + 1)).collect();
    let chain = chain
        + &node("constant", "n0", "float", &[])
        + &format!("<dot name=\"o\" type=\"float\"><input name=\"in\" type=\"float\" nodename=\"n{count}\" /></dot>");
    let found = number(&chain.replace(
        "<constant name=\"n0\" type=\"float\">",
        "<constant name=\"n0\" type=\"float\"><input name=\"value\" type=\"float\" value=\"0.25\" />",
    ));
    assert!(near(found.material.value(Property::roughness), &[0.75]), "{:?}", found.notes);
    // Every node twice as often as the one before, if nodes were copied.
    let doubled: String = (0..200)
        .map(|k| {
            node(
                "add",
                &format!("n{}", k + 1),
                "float",
                &[("in1", "float", &format!("@n{k}")), ("in2", "float", &format!("@n{k}"))],
            )
        })
        .collect();
    let zero = node("constant", "n0", "float", &[("value", "float", "0")]);
    let found = number(&(zero + &doubled + &node("dot", "o", "float", &[("in", "float", "@n200")])));
    assert_eq!(found.material.float(Property::roughness), 0.0);
}

#[test]
fn no_other_file_is_opened() {
    let text =
        document("open_pbr_surface", "xmlns:xi=\"http://www.w3.org/2001/XInclude\"", "<xi:include href=\"/etc/passwd\" />", "");
    assert!(one(&text).notes.iter().any(|note| note.contains("/etc/passwd") && note.contains("no other file")));
    for entities in [
        "<!DOCTYPE x [<!ENTITY a \"b\"><!ENTITY c \"&a;&a;\">]>",
        "<!DOCTYPE x SYSTEM \"file:///etc/passwd\">",
        "<!DOCTYPE x [<!ENTITY a SYSTEM \"file:///etc/passwd\">]>",
    ] {
        assert_eq!(
            read(&format!("{entities}\n<materialx version=\"1.39\" />")),
            Err(ReadError::Entities { line: 1 }),
            "{entities}"
        );
    }
    assert!(matches!(read("<materialx version=\"&a;\" />"), Err(ReadError::NotXml { line: 1, .. })));
}

#[test]
fn broken_texts_are_one_clear_error() {
    let not_xml = [
        "<materialx",
        "<materialx></materialy>",
        "<materialx><a></materialx>",
        "<materialx a=\"1\" a=\"2\"/>",
        "<materialx a=1/>",
        "<materialx/><materialx/>",
        "</materialx>",
        "<materialx><a>",
    ];
    for text in not_xml {
        assert!(matches!(read(text), Err(ReadError::NotXml { .. })), "{text}: {:?}", read(text));
    }
    for text in ["", "   ", "Hello", "<svg />", "{\"a\": 1}"] {
        assert!(matches!(read(text), Err(ReadError::NotMaterialX { .. })), "{text}: {:?}", read(text));
    }
    for text in [
        "<materialx version=\"1.39\" />",
        "<materialx version=\"1.39\"><surfacematerial name=\"a\" type=\"material\" /></materialx>",
        "<materialx version=\"1.39\"><surfacematerial name=\"a\" type=\"material\"><input name=\"surfaceshader\" nodename=\"x\" /></surfacematerial></materialx>",
        &document("lama_surface", "", "", ""),
    ] {
        let error = read(text).expect_err(text);
        assert!(
            matches!(error, ReadError::NoMaterial { .. }) && error.to_string().contains("expected a surfacematerial"),
            "{error}"
        );
    }
    let whole = document("open_pbr_surface", "", "", "<input name=\"base_color\" type=\"color3\" value=\"0.1, 0.2, 0.3\" />");
    for end in 0..whole.len() - 12 {
        assert!(read(&whole[..end]).is_err(), "{end}");
    }
}

#[test]
fn too_much_of_anything_is_refused() {
    let inside = |elements: &str| format!("<materialx version=\"1.39\">{elements}</materialx>");
    assert!(matches!(read(&" ".repeat(MAX_BYTES + 1)), Err(ReadError::TooLarge { .. })));
    assert!(matches!(read(&inside(&"<a/>".repeat(MAX_ELEMENTS))), Err(ReadError::TooMany { what: "elements", .. })));
    assert!(matches!(read(&inside(&"<a>".repeat(MAX_DEPTH))), Err(ReadError::TooDeep { line: 1 })));
    let attributes: String = (0..1000).map(|k| format!(" a{k}=\"\"")).collect();
    assert!(matches!(read(&format!("<materialx{attributes}/>")), Err(ReadError::TooMany { .. })));
    let material = "<surfacematerial name=\"a\" type=\"material\" />";
    assert!(matches!(read(&inside(&material.repeat(MAX_MATERIALS + 1))), Err(ReadError::TooMany { what: "materials", .. })));
    let wrong = "<input name=\"x\" type=\"float\" value=\"?\" />";
    let found = open_pbr("", &(0..300).map(|k| wrong.replace("\"x\"", &format!("\"x{k}\""))).collect::<String>());
    assert_eq!(found.notes.len(), 101, "the last one counts the rest");
}

#[test]
fn long_names_and_shared_copies_stay_small() {
    let long = "n".repeat(100_000);
    let before = node("noise2d", &long, "float", &[]);
    let found = open_pbr(&before, &format!("<input name=\"coat_weight\" type=\"float\" nodename=\"{long}\" />"));
    assert!(found.notes.len() == 1 && found.notes[0].len() < 400, "{} bytes", found.notes[0].len());
    let written = write(&[&Material::named("a")], &WriteOptions::default()).text;
    let start = written.find("<surfacematerial name=\"a\"").expect("a material");
    let end = start + written[start..].find("</surfacematerial>").expect("its end") + 18;
    let second = written[start..end].replace("name=\"a\"", "name=\"b\"");
    let found = read(&format!("{}{second}{}", &written[..end], &written[end..])).expect("two materials");
    assert_eq!(found.iter().map(|found| found.is_native).collect::<Vec<_>>(), [true, false]);
}
