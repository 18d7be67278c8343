//! Scale and bias of textures: what a file says, what differs, and what becomes of texels.

use burnish_material::Property as P;
use burnish_material::diff::{changes, take};
use burnish_material::merge::{Side, merge};
use burnish_material::{Kind, Material, MaterialFile, TextureRef, Warning};

fn read(text: &str) -> (MaterialFile, Vec<Warning>) {
    MaterialFile::parse(text).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

fn textured(edit: impl Fn(&mut TextureRef)) -> Material {
    let mut material = Material::default();
    edit(material.slot_mut(P::base_color).texture.insert(TextureRef::new("a.png")));
    material
}

fn texture(material: &Material) -> &TextureRef {
    material.slot(P::base_color).texture.as_ref().expect("it has a texture")
}

#[test]
fn only_what_is_not_at_its_default_is_written() {
    for (scale, bias, text) in [
        ([1.0; 3], [0.0; 3], r#"{ "path": "a.png" }"#),
        ([0.5; 3], [0.0; 3], r#"{ "path": "a.png", "scale": 0.5 }"#),
        ([1.0; 3], [-0.25; 3], r#"{ "path": "a.png", "bias": -0.25 }"#),
        ([1.0, 2.0, 1.0], [0.0, 0.0, 1e300], r#"{ "path": "a.png", "scale": (1.0, 2.0, 1.0), "bias": (0.0, 0.0, 1e300) }"#),
    ] {
        let material = textured(|t| (t.scale, t.bias) = (scale, bias));
        let file = MaterialFile::new(&material);
        assert!(file.text().contains(text), "{}", file.text());
        assert_eq!(file.material(), &material);
    }
}

#[test]
fn edits_keep_what_stands_there() {
    let text =
        r#"{"asm":"4.0","properties":{"base_color":{"texture":{"scale":(2, /* g */ 2, 2.0),"path":"a.png","bias":1e-1}}}}"#;
    let (file, warnings) = read(text);
    assert_eq!(warnings, []);
    assert_eq!((texture(file.material()).scale, texture(file.material()).bias), ([2.0; 3], [0.1; 3]));
    type Case<'a> = (&'a str, &'a str, &'a dyn Fn(&mut TextureRef));
    let cases: [Case; 4] = [
        ("(2, /* g */ 2, 2.0)", "(2, /* g */ 0.5, 2.0)", &|t| t.scale[1] = 0.5),
        ("(2, /* g */ 2, 2.0)", "(3.0, /* g */ 3.0, 3.0)", &|t| t.scale = [3.0; 3]),
        ("1e-1", "0.2", &|t| t.bias = [0.2; 3]),
        ("1e-1", "(0.1, 0.1, 0.0)", &|t| t.bias[2] = 0.0),
    ];
    for (old, new, change) in cases {
        let mut edited = file.material().clone();
        change(edited.slot_mut(P::base_color).texture.as_mut().unwrap());
        assert_eq!(file.to_text(&edited), text.replace(old, new));
        assert_eq!(read(&file.to_text(&edited)).0.material(), &edited);
        assert_eq!(file.changed(&edited), 1);
    }
}

#[test]
fn what_is_no_finite_number_costs_one_warning() {
    for key in ["scale", "bias"] {
        for bad in ["NaN", "inf", "1e999", "\"2\"", "(1, 2)", "(1, 2, 3, 4)", "(1, NaN, 1)", "[1, 1, -inf]", "{}", "None"] {
            let text = format!(r#"{{"asm":"4.0","properties":{{"roughness":{{"texture":{{"path":"a.png","{key}":{bad}}}}}}}}}"#);
            let (file, warnings) = read(&text);
            assert!(warnings.len() == 1 && warnings[0].is_refused, "{text}: {warnings:?}");
            assert_eq!(warnings[0].key, format!("roughness.texture.{key}"));
            let expected = format!("expected a finite number or three (r, g, b), found {bad}; kept in the file, default used");
            assert_eq!(warnings[0].message, expected);
            assert_eq!(file.material().slot(P::roughness).texture, Some(TextureRef::new("a.png")));
            assert_eq!(file.to_text(file.material()), text);
        }
    }
}

#[test]
fn scales_are_told_apart_and_merged() {
    let (base, a) = (textured(|_| ()), textured(|t| t.scale[2] = 0.5));
    let b = textured(|t| t.bias = [0.1; 3]);
    let found = changes(&base, &a);
    assert_eq!(found.len(), 1);
    assert_eq!(found[0].b.as_deref(), Some(r#"{ "path": "a.png", "scale": (1.0, 1.0, 0.5) }"#));
    assert!(found[0].is_visible);
    let mut taken = base.clone();
    assert!(take(&mut taken, &a, &found[0].key));
    assert_eq!(taken, a);
    assert_eq!(merge(&base, &base, &b, Side::A).material, b);
    let merged = merge(&base, &a, &b, Side::B);
    assert_eq!((merged.material, merged.conflicts.len()), (b, 1));
}

#[test]
fn texels_are_inverted_then_scaled_then_shifted() {
    let map = |edit: &dyn Fn(&mut TextureRef), kind, texel| {
        let mut reference = TextureRef::new("a");
        edit(&mut reference);
        reference.affine(kind).map(|affine| affine.apply(texel))
    };
    let both = |t: &mut TextureRef| (t.scale, t.bias) = ([2.0, 0.5, -1.0], [0.25, 0.0, 1.0]);
    let turned = |t: &mut TextureRef| {
        both(t);
        t.is_inverted = true;
    };
    let texel = [0.25, 0.5, 0.75];
    for kind in [Kind::Color, Kind::Float, Kind::Bool, Kind::Normal] {
        assert_eq!(map(&|_| (), kind, texel), None);
    }
    assert_eq!(map(&both, Kind::Color, texel), Some([0.75, 0.25, 0.25]));
    assert_eq!(map(&turned, Kind::Color, texel), Some([1.75, 0.25, 0.75]));
    // A scalar has the first numbers, a direction none.
    assert_eq!(map(&both, Kind::Float, [0.25; 3]), Some([0.75; 3]));
    assert_eq!(map(&turned, Kind::Float, [0.25; 3]), Some([1.75; 3]));
    assert_eq!(map(&both, Kind::Normal, texel), None);
    assert_eq!(map(&turned, Kind::Normal, [0.25, 0.125, 0.75]), Some([0.25, 0.875, 0.75]));
    // Every number that a reference and an image can hold gives one.
    let numbers = [0.0, -0.0, 1.0, f64::MAX, f64::MIN, 5e-324, f64::NAN, f64::INFINITY, f64::NEG_INFINITY];
    for (scale, bias, is_inverted) in numbers.iter().flat_map(|s| numbers.map(|b| [(*s, b, false), (*s, b, true)])).flatten() {
        for x in [0.0, 1.0, -0.5, f32::MAX, f32::MIN] {
            let edit = |t: &mut TextureRef| (t.scale, t.bias, t.is_inverted) = ([scale; 3], [bias; 3], is_inverted);
            let found = map(&edit, Kind::Color, [x; 3]).unwrap_or([x; 3]);
            assert!(found.iter().all(|x| x.is_finite()), "{scale} {bias} {is_inverted} {x}: {found:?}");
        }
    }
    assert!(map(&both, Kind::Color, [f32::NAN, f32::INFINITY, 0.0]).unwrap()[..2].iter().all(|x| !x.is_finite()));
}
