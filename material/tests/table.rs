//! The property table: complete, consistent, and equal to a transcription of the specification.

use std::collections::HashSet;

use burnish_material::exchange::page::interchange_page;
use burnish_material::{
    ASM_MATERIAL_WGSL, Group, Kind, LimitKind, Material, PROPERTIES, PROPERTY_COUNT, Property, PropertyDef, Value, Vary,
    inputs_wgsl, reference_page,
};

/// Property, usage, kind, texturable, default, lower end, upper end, kind of range: written down from the specification,
/// independently of the table.
const TRANSCRIPTION: &str = "
    base_color,baseColor,color,yes,0.5 0.5 0.5,0,1,hard
    roughness,roughness,float,yes,0.3,0,1,hard
    metallic,metallic,float,yes,0,0,1,hard
    opacity,opacity,float,yes,1,0,1,hard
    specular_level,specularLevel,float,yes,0.5,0,1,hard
    specular_edge_color,specularEdgeColor,color,yes,1 1 1,0,1,hard
    normal,normal,normal,texture only,none,,,none
    normal_scale,normalScale,float,no,1,0,,typical
    combine_normal_and_height,combineNormalAndHeight,bool,no,false,,,none
    height,height,float,texture only,0.5,,,none
    height_scale,heightScale,float,no,1,0,,typical
    height_level,heightLevel,float,no,0.5,0,1,hard
    anisotropy,anisotropyLevel,float,yes,0,0,1,hard
    anisotropy_rotation,anisotropyAngle,float,yes,0,0,1,hard
    emission,emissiveIntensity,float,no,0,0,,hard
    emission_color,emissive,color,yes,1 1 1,0,,none
    sheen,sheenOpacity,float,yes,0,0,1,hard
    sheen_color,sheenColor,color,yes,1 1 1,0,1,hard
    sheen_roughness,sheenRoughness,float,yes,0.5,0,1,hard
    translucency,translucency,float,yes,0,0,1,hard
    specular_ior,IOR,float,no,1.5,1,3,typical
    dispersion,dispersion,float,no,0,0,20,hard
    absorption_color,absorptionColor,color,yes,1 1 1,0,1,hard
    absorption_distance,absorptionDistance,float,no,0,0,,hard
    scatter,scatter,bool,no,false,,,none
    scatter_color,scatteringColor,color,yes,1 1 1,0,1,hard
    scatter_distance,scatteringDistance,float,no,1,0,,hard
    scatter_distance_scale,scatteringDistanceScale,color,yes,1 1 1,0,,none
    scatter_red_shift,scatteringRedShift,float,no,0,0,1,typical
    scatter_rayleigh,scatteringRayleigh,float,no,0,0,1,typical
    coat,coatOpacity,float,yes,0,0,1,hard
    coat_color,coatColor,color,yes,1 1 1,0,1,hard
    coat_roughness,coatRoughness,float,yes,0,0,1,hard
    coat_ior,coatIOR,float,no,1.6,1,3,typical
    coat_specular_level,coatSpecularLevel,float,yes,0.5,0,1,hard
    coat_normal,coatNormal,normal,texture only,none,,,none
    coat_normal_scale,coatNormalScale,float,no,1,0,,typical
    ambient_occlusion,ambientOcclusion,float,texture only,1,0,1,hard
    volume_thickness,volumeThickness,float,texture only,1,0,1,hard
    volume_thickness_scale,volumeThicknessScale,float,no,1,0,,hard
";

fn transcribed(def: &PropertyDef) -> String {
    let kind = match def.default.kind() {
        Kind::Color => "color",
        Kind::Float => "float",
        Kind::Bool => "bool",
        Kind::Normal => "normal",
    };
    let vary = match def.vary {
        Vary::Uniform => "no",
        Vary::Texturable => "yes",
        Vary::TextureOnly => "texture only",
    };
    let default = match def.default {
        Value::Color([r, g, b]) => format!("{r} {g} {b}"),
        Value::Float(x) => x.to_string(),
        Value::Bool(x) => x.to_string(),
        Value::Normal(normal) => {
            assert_eq!(normal, [0.0, 0.0, 1.0], "{}: no map must mean an unchanged surface", def.name);
            "none".into()
        }
    };
    let range = match def.limits.kind {
        LimitKind::Hard => "hard",
        LimitKind::Typical => "typical",
        LimitKind::Open => "none",
    };
    let end = |end: Option<f64>| end.map_or(String::new(), |x| x.to_string());
    let (min, max) = (end(def.limits.min), end(def.limits.max));
    format!("{},{},{kind},{vary},{default},{min},{max},{range}", def.name, def.usage)
}

#[test]
fn the_table_equals_the_transcription() {
    // Two rows of the transcription state a lower end of 0 although the specification states no range.
    let no_range = ["emission_color", "scatter_distance_scale"];
    let expected: Vec<_> = TRANSCRIPTION.trim().lines().map(str::trim).collect();
    assert_eq!(expected.len(), 40);
    assert_eq!(PROPERTY_COUNT, 40);
    for (def, expected) in PROPERTIES.iter().zip(expected) {
        let expected = if no_range.contains(&def.name) { expected.replace(",0,,none", ",,,none") } else { expected.to_owned() };
        assert_eq!(transcribed(def), expected);
    }
}

#[test]
fn names_are_unique_and_find_their_property() {
    let mut names = HashSet::new();
    for (row, def) in PROPERTIES.iter().enumerate() {
        assert_eq!(def.id as usize, row, "{}", def.name);
        assert_eq!(def.id.def().name, def.name);
        assert_eq!(Property::from_name(def.name), Some(def.id));
        for name in [def.name, def.usage, def.label] {
            assert_eq!(Property::from_any_name(name), Some(def.id), "{name}");
        }
        // A name may equal the same property's other names, never another property's.
        for name in HashSet::from([def.name.to_owned(), def.usage.to_owned(), def.label.to_owned()]) {
            assert!(names.insert(name.clone()), "{name} names two properties");
        }
    }
}

#[test]
fn groups_follow_the_specification() {
    let mut order: Vec<_> = PROPERTIES.iter().map(|def| def.group).collect();
    assert!(order.is_sorted());
    order.dedup();
    assert_eq!(order, Group::ALL);
}

#[test]
fn defaults_lie_inside_their_limits() {
    for def in PROPERTIES {
        for number in def.default.numbers() {
            assert!(def.limits.contains(*number), "{}: {number}", def.name);
            assert_eq!(def.limits.enforce(*number), *number);
        }
        assert!(def.limits.slider_max > def.limits.min.unwrap_or(0.0), "{}", def.name);
    }
}

#[test]
fn docs_are_sentences() {
    for def in PROPERTIES {
        let is_sentence = def.doc.starts_with(|c: char| c.is_uppercase()) && def.doc.ends_with('.') && !def.doc.contains("  ");
        assert!(is_sentence, "{}: {:?}", def.name, def.doc);
        assert!(!def.label.is_empty());
    }
}

#[test]
fn inputs_enforce_hard_limits_only() {
    let mut material = Material::default();
    for def in PROPERTIES {
        match def.default {
            Value::Float(_) => _ = material.set(def.id, Value::Float(-3.0)),
            Value::Color(_) => _ = material.set(def.id, Value::Color([-3.0, f64::NAN, 1e300])),
            _ => {}
        }
    }
    let inputs = material.inputs();
    assert_eq!(inputs.roughness, 0.0);
    assert_eq!(inputs.specular_ior, -3.0);
    assert_eq!(inputs.base_color, [0.0, 0.5, 1.0]);
    assert_eq!(inputs.emission_color, [-3.0, 1.0, f64::from(f32::MAX)]);
}

/// Compares a generated file with its source; `UPDATE_GENERATED=1` writes it instead.
fn expect_current(path: &str, current: &str, generated: &str) {
    if std::env::var_os("UPDATE_GENERATED").is_some() {
        std::fs::write(format!("{}/{path}", env!("CARGO_MANIFEST_DIR")), generated).expect("the source folder is writable");
        return;
    }
    assert!(current == generated, "{path} is out of date; run: UPDATE_GENERATED=1 cargo test -p burnish-material --test table");
}

#[test]
fn generated_files_are_current() {
    expect_current("src/asm_material.gen.wgsl", ASM_MATERIAL_WGSL, &inputs_wgsl());
    let page = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/PROPERTIES.md")).unwrap_or_default();
    expect_current("PROPERTIES.md", &page, &reference_page());
    let page = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/INTERCHANGE.md")).unwrap_or_default();
    expect_current("INTERCHANGE.md", &page, &interchange_page());
}

#[test]
fn generated_names_are_free_in_wgsl() {
    // Keywords and reserved words of WGSL that a property could plausibly be called.
    let taken = [
        "active",
        "alias",
        "asm",
        "attribute",
        "break",
        "case",
        "common",
        "const",
        "continue",
        "default",
        "discard",
        "else",
        "enable",
        "false",
        "filter",
        "final",
        "fn",
        "for",
        "if",
        "let",
        "loop",
        "meta",
        "mod",
        "noise",
        "override",
        "packed",
        "partition",
        "pass",
        "patch",
        "pixelfragment",
        "precise",
        "precision",
        "priv",
        "resource",
        "return",
        "self",
        "shared",
        "smooth",
        "snorm",
        "sizeof",
        "struct",
        "subroutine",
        "super",
        "switch",
        "target",
        "true",
        "type",
        "unorm",
        "var",
        "volatile",
        "while",
        "with",
        "yield",
        "texture",
        "sampler",
        "texture_2d",
    ];
    for def in PROPERTIES {
        assert!(!taken.contains(&def.name), "{}", def.name);
        assert!(def.name.bytes().all(|b| b.is_ascii_lowercase() || b == b'_') && !def.name.contains("__"), "{}", def.name);
    }
}

#[test]
fn rows_hold_every_kind() {
    assert_eq!(Value::Color([0.25, 0.5, 1.0]).row(), [0.25, 0.5, 1.0, -1.0]);
    assert_eq!(Value::Float(1e300).row()[0], f32::MAX);
    assert_eq!(Value::Bool(true).row()[0], 1.0);
}
