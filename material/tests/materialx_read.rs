//! MaterialX documents of others: graphs that fold and names that lead somewhere.

#[path = "common/mtlx.rs"]
mod mtlx;

use burnish_material::exchange::materialx::ReadMaterial;
use burnish_material::{Channel, ColorSpace, Property, TextureRef, Value, Wrap};
use mtlx::{color, document, near, node, number, one, open_pbr};

#[test]
fn constants_fold() {
    let float = |name: &'static str, value: &'static str| (name, "float", value);
    for (tag, inputs, expected) in [
        ("add", vec![float("in1", "0.25"), float("in2", "0.5")], 0.75),
        ("subtract", vec![float("in1", "0.75"), float("in2", "0.5")], 0.25),
        ("multiply", vec![float("in1", "0.5"), float("in2", "0.5")], 0.25),
        ("divide", vec![float("in1", "0.5"), float("in2", "4")], 0.125),
        ("power", vec![float("in1", "0.5"), float("in2", "3")], 0.125),
        ("min", vec![float("in1", "0.5"), float("in2", "0.25")], 0.25),
        ("max", vec![float("in1", "0.5"), float("in2", "0.25")], 0.5),
        ("modulo", vec![float("in1", "0.75"), float("in2", "0.5")], 0.25),
        ("clamp", vec![float("in", "7"), float("low", "0"), float("high", "0.5")], 0.5),
        ("invert", vec![float("in", "0.25")], 0.75),
        ("mix", vec![float("fg", "1"), float("bg", "0"), float("mix", "0.25")], 0.25),
        ("remap", vec![float("in", "2"), float("inhigh", "4")], 0.5),
        ("dot", vec![float("in", "0.5")], 0.5),
        ("sqrt", vec![float("in", "0.25")], 0.5),
        ("constant", vec![float("value", "0.125")], 0.125),
        ("ifgreater", vec![float("value1", "2"), float("value2", "1"), float("in1", "0.25"), float("in2", "1")], 0.25),
        ("switch", vec![float("in1", "1"), float("in2", "0.25"), ("which", "integer", "1")], 0.25),
        ("extract", vec![("in", "color3", "0.1, 0.2, 0.3"), ("index", "integer", "2")], 0.3),
        ("swizzle", vec![("in", "color3", "0.1, 0.2, 0.3"), ("channels", "string", "g")], 0.2),
        ("convert", vec![("in", "boolean", "true")], 1.0),
        ("dotproduct", vec![("in1", "vector3", "0.1, 0.2, 0.3"), ("in2", "vector3", "1, 1, 1")], 0.6),
        ("geompropvalue", vec![("geomprop", "string", "dirt"), float("default", "0.25")], 0.25),
    ] {
        let found = number(&node(tag, "o", "float", &inputs));
        assert!(near(found.material.value(Property::roughness), &[expected]), "{tag}: {found:?}");
    }
    let parts = node("separate3", "x", "multioutput", &[("in", "color3", "0.1, 0.2, 0.3")]);
    let swapped =
        node("combine3", "o", "color3", &[("in1", "float", "@x.outb"), ("in2", "float", "@x.outg"), ("in3", "float", "@x.outr")]);
    assert!(near(color(&(parts + &swapped)).material.value(Property::base_color), &[0.3, 0.2, 0.1]));
    let swizzled = node("swizzle", "o", "color3", &[("in", "color3", "0.1, 0.2, 0.3"), ("channels", "string", "b1r")]);
    assert!(near(color(&swizzled).material.value(Property::base_color), &[0.3, 1.0, 0.1]));
}

const IMAGE: [(&str, &str, &str); 1] = [("file", "filename", "tex/a.png")];

fn texture(found: &ReadMaterial, property: Property) -> &TextureRef {
    found.material.slot(property).texture.as_ref().unwrap_or_else(|| panic!("no image: {found:?}"))
}

#[test]
fn images_behind_factors_and_offsets_are_bindings() {
    let image = node("image", "i", "color3", &IMAGE);
    let found = color(
        &(image.clone()
            + &node("multiply", "f", "color3", &[("in1", "color3", "@i"), ("in2", "color3", "1, 0.5, 0.25")])
            + &node("add", "o", "color3", &[("in1", "color3", "@f"), ("in2", "float", "0.125")])),
    );
    let bound = texture(&found, Property::base_color);
    assert_eq!((bound.scale, bound.bias, bound.channel), ([1.0, 0.5, 0.25], [0.125; 3], Channel::Rgb));
    assert_eq!(found.notes, Vec::<String>::new());

    // A gloss map in green: 1 - x, weighed.
    let found = number(
        &(node("image", "i", "vector3", &IMAGE)
            + &node("extract", "e", "float", &[("in", "vector3", "@i"), ("index", "integer", "1")])
            + &node("invert", "v", "float", &[("in", "float", "@e")])
            + &node("mix", "o", "float", &[("fg", "float", "@v"), ("bg", "float", "0.5"), ("mix", "float", "0.5")])),
    );
    let bound = texture(&found, Property::roughness);
    assert_eq!((bound.scale[0], bound.bias[0], bound.channel), (-0.5, 0.75, Channel::G));

    let found = color(&(image.clone() + &node("multiply", "o", "color3", &[("in1", "color3", "@i"), ("in2", "color3", "@i")])));
    assert!(!found.material.is_textured(Property::base_color));
    assert!(found.notes.iter().any(|note| note.contains("g/o") && note.contains("multiply")), "{:?}", found.notes);
    let found = color(&node("noise2d", "o", "color3", &[("amplitude", "vector3", "1, 1, 1")]));
    assert!(found.notes.iter().any(|note| note.contains("g/o") && note.contains("noise2d")), "{:?}", found.notes);
    assert!(near(found.material.value(Property::base_color), &[0.8; 3]), "OpenPBR's default");
}

#[test]
fn settings_of_images_are_read() {
    let uv = node("texcoord", "uv", "vector2", &[]);
    let place = [
        ("texcoord", "vector2", "@uv"),
        ("scale", "vector2", "0.5, 0.25"),
        ("offset", "vector2", "-0.1, -0.2"),
        ("rotate", "float", "-90"),
    ];
    let image =
        [IMAGE[0], ("texcoord", "vector2", "@p"), ("uaddressmode", "string", "mirror"), ("vaddressmode", "string", "mirror")];
    let found = color(&(uv.clone() + &node("place2d", "p", "vector2", &place) + &node("image", "o", "color3", &image)));
    let bound = texture(&found, Property::base_color);
    assert_eq!((bound.uv_scale, bound.uv_offset, bound.uv_rotation, bound.wrap), ([2.0, 4.0], [-3.9, 0.8], 90.0, Wrap::Mirror));
    assert_eq!(bound.color_space, ColorSpace::Linear);

    let tiled = [IMAGE[0], ("uvtiling", "vector2", "3, 2"), ("uvoffset", "vector2", "0.5, 0")];
    let found = color(
        &node("tiledimage", "o", "color3", &tiled)
            .replace("value=\"tex/a.png\"", "value=\"tex/a.png\" colorspace=\"srgb_texture\""),
    );
    let bound = texture(&found, Property::base_color);
    assert_eq!((bound.uv_scale, bound.uv_offset, bound.color_space), ([3.0, 2.0], [-0.5, -1.0], ColorSpace::Srgb));

    let found =
        color(&(uv + &node("place2d", "p", "vector2", &[("scale", "vector2", "0, 1")]) + &node("image", "o", "color3", &image)));
    assert_eq!(texture(&found, Property::base_color).uv_scale, [1.0, 1.0]);
    assert_eq!(found.notes.len(), 1, "{:?}", found.notes);

    let uv_texture = [
        IMAGE[0],
        ("scale", "color4", "0.5, 0.5, 0.5, 1"),
        ("bias", "color4", "0.25, 0, 0, 0"),
        ("wrapS", "string", "clamp"),
        ("wrapT", "string", "clamp"),
    ];
    let before = node("UsdUVTexture", "t", "multioutput", &uv_texture);
    let inputs = "<input name=\"diffuseColor\" type=\"color3\" nodename=\"t\" output=\"rgb\" /><input name=\"opacity\" type=\"float\" nodename=\"t\" output=\"a\" />";
    let found = one(&document("UsdPreviewSurface", "", &before, inputs));
    let bound = texture(&found, Property::base_color);
    assert_eq!((bound.scale, bound.bias, bound.wrap), ([0.5; 3], [0.25, 0.0, 0.0], Wrap::Clamp));
    assert_eq!(texture(&found, Property::opacity).channel, Channel::A);

    let before = node(
        "gltf_colorimage",
        "t",
        "multioutput",
        &[IMAGE[0], ("color", "color4", "0.5, 1, 1, 0.5"), ("scale", "vector2", "2, 2")],
    );
    let inputs = "<input name=\"base_color\" type=\"color3\" nodename=\"t\" output=\"outcolor\" /><input name=\"alpha\" type=\"float\" nodename=\"t\" output=\"outa\" />
                  <input name=\"alpha_mode\" type=\"integer\" value=\"2\" />";
    let found = one(&document("gltf_pbr", "", &before, inputs));
    let bound = texture(&found, Property::base_color);
    assert_eq!((bound.scale, bound.uv_scale, bound.uv_offset), ([0.5, 1.0, 1.0], [2.0, 2.0], [0.0, 0.0]));
    assert_eq!(texture(&found, Property::opacity).scale[0], 0.5);
    assert_eq!(found.material.float(Property::metallic), 1.0, "glTF's default");
}

#[test]
fn normals_and_tangents_are_read() {
    let before = node("image", "i", "vector3", &IMAGE)
        + &node("multiply", "f", "vector3", &[("in1", "vector3", "@i"), ("in2", "vector3", "1, -1, 1")])
        + &node("add", "d", "vector3", &[("in1", "vector3", "@f"), ("in2", "vector3", "0, 1, 0")])
        + &node("normalmap", "n", "vector3", &[("in", "vector3", "@d"), ("scale", "float", "0.5")])
        + &node("normal", "up", "vector3", &[])
        + &node("tangent", "along", "vector3", &[])
        + &node(
            "rotate3d",
            "t",
            "vector3",
            &[("in", "vector3", "@along"), ("amount", "float", "-90"), ("axis", "vector3", "@up")],
        );
    let inputs = "<input name=\"geometry_normal\" type=\"vector3\" nodename=\"n\" /><input name=\"geometry_tangent\" type=\"vector3\" nodename=\"t\" />";
    let found = open_pbr(&before, inputs);
    assert!(texture(&found, Property::normal).is_inverted);
    assert_eq!(found.material.float(Property::normal_scale), 0.5);
    assert_eq!(found.material.float(Property::anisotropy_rotation), 0.25);
    assert_eq!(found.notes, Vec::<String>::new());

    let before = node(
        "UsdUVTexture",
        "t",
        "multioutput",
        &[IMAGE[0], ("scale", "color4", "2, 2, 2, 1"), ("bias", "color4", "-1, -1, -1, 0")],
    ) + &node("convert", "v", "vector3", &[("in", "color3", "@t.rgb")]);
    let found = one(&document("UsdPreviewSurface", "", &before, "<input name=\"normal\" type=\"vector3\" nodename=\"v\" />"));
    assert_eq!(texture(&found, Property::normal).path, "tex/a.png");
    assert!(!texture(&found, Property::normal).is_inverted);
}

#[test]
fn names_lead_through_graphs_and_interfaces() {
    let before = format!(
        "<nodegraph name=\"g\"><input name=\"tint\" type=\"float\" value=\"0.25\" /><input name=\"shine\" type=\"float\" nodename=\"outer\" />{}
         <output name=\"a\" type=\"float\" nodename=\"twice\" /><output name=\"b\" type=\"float\" nodename=\"shiny\" /></nodegraph>{}",
        "<multiply name=\"twice\" type=\"float\"><input name=\"in1\" type=\"float\" interfacename=\"tint\" /><input name=\"in2\" type=\"float\" value=\"2\" /></multiply>
         <dot name=\"shiny\" type=\"float\"><input name=\"in\" type=\"float\" interfacename=\"shine\" /></dot>",
        node("constant", "outer", "float", &[("value", "float", "0.125")])
    );
    let inputs = "<input name=\"specular_roughness\" type=\"float\" nodegraph=\"g\" output=\"a\" /><input name=\"base_metalness\" type=\"float\" nodegraph=\"g\" output=\"b\" />
                  <input name=\"coat_weight\" type=\"float\" nodename=\"nobody\" />";
    let found = open_pbr(&before, inputs);
    assert_eq!(found.material.float(Property::roughness), 0.5);
    assert_eq!(found.material.float(Property::metallic), 0.125);
    assert!(found.notes.iter().any(|note| note.contains("nobody")), "{:?}", found.notes);
}

#[test]
fn colours_are_converted_to_linear_rec709() {
    let found = one(&document(
        "open_pbr_surface",
        "colorspace=\"acescg\"",
        "",
        "<input name=\"base_color\" type=\"color3\" value=\"0.3, 0.2, 0.1\" />",
    ));
    assert!(near(found.material.value(Property::base_color), &[0.378_830_99, 0.188_028_94, 0.082_302_43]), "{found:?}");
    assert_eq!(found.notes.len(), 1, "{:?}", found.notes);
    let srgb = "<input name=\"base_color\" type=\"color3\" value=\"0.5, 0.02, 1\" colorspace=\"srgb_texture\" />";
    let found = open_pbr("", srgb);
    assert!(near(found.material.value(Property::base_color), &[0.214_041_14, 0.001_547_99, 1.0]), "{found:?}");
    let found = one(&document(
        "open_pbr_surface",
        "colorspace=\"kodachrome\"",
        "",
        srgb.replace(" colorspace=\"srgb_texture\"", "").as_str(),
    ));
    assert!(found.notes[0].contains("kodachrome"));
}

#[test]
fn each_surface_has_its_own_defaults() {
    for (surface, base, roughness) in [
        ("open_pbr_surface", [0.8; 3], 0.3),
        ("standard_surface", [0.8; 3], 0.2),
        ("gltf_pbr", [1.0; 3], 1.0),
        ("UsdPreviewSurface", [0.18; 3], 0.5),
        ("disney_principled", [0.16; 3], 0.5),
    ] {
        let found = one(&document(surface, "", "", ""));
        assert_eq!(found.surface, surface);
        assert_eq!(found.material.value(Property::base_color), Value::Color(base), "{surface}");
        assert_eq!(found.material.float(Property::roughness), roughness, "{surface}");
    }
    // Without a material, surfaces stand for themselves.
    let found = one("<materialx version=\"1.39\"><gltf_pbr name=\"alone\" type=\"surfaceshader\" /></materialx>");
    assert_eq!((found.name.as_str(), found.surface.as_str()), ("alone", "gltf_pbr"));
}

#[test]
fn images_outside_of_the_folder_are_refused_in_a_sentence() {
    for file in ["/etc/a.png", "C:\\a.png", "../a.png", "tex/../../a.png", "https://example.org/a.png", "\\\\host\\a.png"] {
        let found = color(&node("image", "o", "color3", &[("file", "filename", file)]));
        assert!(!found.material.is_textured(Property::base_color), "{file}");
        assert!(found.notes.iter().any(|note| note.contains(&file.replace('\\', "/"))), "{:?}", found.notes);
    }
    let text = document(
        "open_pbr_surface",
        "fileprefix=\"maps/\"",
        &node("image", "i", "color3", &IMAGE),
        "<input name=\"base_color\" type=\"color3\" nodename=\"i\" />",
    );
    assert_eq!(texture(&one(&text), Property::base_color).path, "maps/tex/a.png");
}

#[test]
fn wrong_values_cost_a_note_each_and_nothing_else() {
    for value in ["red", "", "1, 2", "nan, 0, 0", "1e400, 0, 0", "0.1 0.2 0.3 0.4"] {
        let found = open_pbr(
            "",
            &format!(
                "<input name=\"base_color\" type=\"color3\" value=\"{value}\" /><input name=\"base_metalness\" type=\"float\" value=\"0.5\" />"
            ),
        );
        assert_eq!(found.material.value(Property::base_color), Value::Color([0.8; 3]), "{value}");
        assert_eq!(found.material.float(Property::metallic), 0.5);
        assert!(!found.notes.is_empty() && found.notes.iter().all(|note| note.contains("s/base_color")), "{:?}", found.notes);
    }
    for (kind, value) in [("float", "0.5"), ("string", "red"), ("color4", "1, 1, 1, 1"), ("matrix33", "1")] {
        let found = open_pbr("", &format!("<input name=\"base_color\" type=\"{kind}\" value=\"{value}\" />"));
        assert_eq!(
            (found.material.value(Property::base_color), found.notes.len()),
            (Value::Color([0.8; 3]), 1),
            "{kind}: {:?}",
            found.notes
        );
    }
    let found = open_pbr(
        "",
        "<input name=\"specular_roughness\" type=\"float\" value=\"-3\" /><input name=\"flavour\" type=\"float\" value=\"1\" />",
    );
    assert_eq!(found.material.float(Property::roughness), 0.0);
    assert!(found.notes.iter().any(|note| note.contains("flavour")), "{:?}", found.notes);
}
