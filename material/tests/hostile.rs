//! Files that mean harm, the same items for every format: one sentence or a note each, in little time.
//!
//! What only one format knows (packages, connections, graphs, buffers) stands in the tests of that format.

use std::time::{Duration, Instant};

use burnish_material::exchange::{filament, gltf, materialx, mdl, usd};
use burnish_material::{Material, MaterialFile, Property};

/// What a file may take, on a slow machine without optimisation.
const MOST: Duration = Duration::from_secs(60);

/// Roughness where a file says none: every model has its own. 0.25 and 0 stand in files.
const UNSAID: [f64; 6] = [0.25, 0.0, 0.3, 0.4, 0.5, 1.0];

type Found = (Material, Vec<String>);

/// A format: a good file with its roughness at 0.25, and how it is read: its first material with what is said about it.
struct Format {
    name: &'static str,
    good: &'static str,
    read: fn(&str) -> Result<Found, String>,
}

const FORMATS: [Format; 6] = [
    Format {
        name: "native",
        good: "{ \"asm\": \"4.0\", \"properties\": { \"roughness\": 0.25 } }",
        read: |text| {
            let (file, warnings) = MaterialFile::parse(text).map_err(|error| error.to_string())?;
            Ok((file.material().clone(), warnings.iter().map(ToString::to_string).collect()))
        },
    },
    Format {
        name: "gltf",
        good: r#"{ "asset": { "version": "2.0" }, "materials": [{ "pbrMetallicRoughness": { "roughnessFactor": 0.25 } }] }"#,
        read: |text| {
            let document = gltf::read(text.as_bytes()).map_err(|error| error.to_string())?;
            let (material, notes) = document.materials.first().map(gltf::Found::material).unwrap_or_default();
            Ok((material, [document.notes, notes].concat()))
        },
    },
    Format {
        name: "materialx",
        good: r#"<materialx version="1.39"><open_pbr_surface name="s" type="surfaceshader"><input name="specular_roughness" type="float" value="0.25"/></open_pbr_surface></materialx>"#,
        read: |text| {
            let found = materialx::read(text).map_err(|error| error.to_string())?.remove(0);
            Ok((found.material, found.notes))
        },
    },
    Format {
        name: "usda",
        good: "#usda 1.0\ndef Material \"M\" {\n token outputs:surface.connect = </M/S.outputs:surface>\n def Shader \"S\" {\n  uniform token info:id = \"UsdPreviewSurface\"\n  float inputs:roughness = 0.25\n  token outputs:surface\n }\n}\n",
        read: |text| {
            let scene = usd::read(text).map_err(|error| error.to_string())?;
            Ok((scene.materials.first().map(|found| found.material.clone()).unwrap_or_default(), scene.notes))
        },
    },
    Format {
        name: "mdl",
        good: "mdl 1.7;\nexport material M(*) = ::adobe::materials::standard(\n    roughness: 0.25\n);\n",
        read: |text| {
            let found = mdl::read(text).map_err(|error| error.to_string())?.remove(0);
            Ok((found.material, found.notes))
        },
    },
    Format {
        name: "filament",
        good: "material { name : M, shadingModel : lit }\nfragment { void material(inout MaterialInputs material) { prepareMaterial(material); material.roughness = 0.25; } }\n",
        read: |text| {
            let found = filament::read(text).map_err(|error| error.to_string())?;
            Ok((found.material, found.notes))
        },
    },
];

impl Format {
    /// Reads in bounded time, and holds what is said against what people can read.
    fn read(&self, what: &str, text: &str) -> Result<Found, String> {
        let start = Instant::now();
        let result = (self.read)(text);
        assert!(start.elapsed() < MOST, "{}: {what} takes {:?}", self.name, start.elapsed());
        let said = result.as_ref().map_or_else(std::slice::from_ref, |(_, notes)| notes);
        assert!(said.len() <= 2100, "{}: {what}: {} sentences", self.name, said.len());
        for sentence in said {
            assert!(sentence.len() < 1000 && !sentence.contains('\n'), "{}: {what}: {sentence:?}", self.name);
        }
        result
    }

    /// The good file with something in the place of the number.
    fn with(&self, value: &str) -> String {
        self.good.replace("0.25", value)
    }
}

#[test]
fn the_good_files_are_good() {
    for format in &FORMATS {
        let (material, notes) = format.read("a good file", format.good).expect(format.name);
        assert_eq!((material.float(Property::roughness), notes), (0.25, Vec::new()), "{}", format.name);
    }
}

#[test]
fn cut_files_are_refused_or_hold_what_stood_before_the_cut() {
    for format in &FORMATS {
        for sixteenth in 0..16 {
            let cut = &format.good[..format.good.len() * sixteenth / 16];
            match format.read("a cut file", cut) {
                // Numbers may end at the cut, too.
                Ok((material, _)) => {
                    let number = material.float(Property::roughness);
                    assert!(number == 0.2 || UNSAID.contains(&number), "{}: {number}: {cut}", format.name);
                }
                Err(sentence) => assert!(!sentence.is_empty()),
            }
        }
        assert!(format.read("nothing", "").is_err(), "{}", format.name);
    }
}

#[test]
fn wrong_numbers_cost_a_sentence_and_are_not_taken() {
    for format in &FORMATS {
        for wrong in
            ["nan", "NaN", "inf", "-inf", "1e400", "-1e400", "\"x\"", "(0.1, 0.2)", "[0.1]", "{a}", "yes", "0.1.2", "--1", ""]
        {
            // Quotes end an attribute.
            let text = format.with(&if format.name == "materialx" { wrong.replace('"', "'") } else { wrong.to_owned() });
            match format.read(wrong, &text) {
                Ok((material, notes)) => {
                    let number = material.float(Property::roughness);
                    assert!(number != 0.25 && UNSAID.contains(&number), "{}: {wrong}: {number}", format.name);
                    assert!(!notes.is_empty(), "{}: {wrong}: no word", format.name);
                }
                Err(sentence) => assert!(!sentence.is_empty()),
            }
        }
    }
}

#[test]
fn deep_nesting_is_refused_or_passed_over() {
    const DEPTH: usize = 100_000;
    for format in &FORMATS {
        for (open, close) in
            [("[", "]"), ("(", ")"), ("{", "}"), ("{\"a\":", "}"), ("Some(", ")"), ("<a>", "</a>"), ("/*", "*/"), ("-", "")]
        {
            for text in [
                open.repeat(DEPTH),
                format.with(&open.repeat(DEPTH)),
                format.with(&format!("{}1{}", open.repeat(DEPTH), close.repeat(DEPTH))),
            ] {
                _ = format.read(open, &text);
            }
        }
    }
}

/// A million of what a format has many of, around its good file.
fn million(format: &Format) -> Vec<String> {
    // RON is not optimised while developing.
    let many = if format.name == "native" { 100_000 } else { 1_000_000 };
    let lines = |line: &dyn Fn(usize) -> String| (0..many).map(line).collect::<String>();
    let fewer = |line: &dyn Fn(usize) -> String| (0..many / 5).map(line).collect::<String>();
    let before = |place: &str, lines: String| format.good.replacen(place, &format!("{lines}{place}"), 1);
    match format.name {
        "native" => vec![
            before("\"properties\"", lines(&|k| format!("\"k{k}\": 0,\n"))),
            before("\"roughness\"", fewer(&|k| format!("\"k{k}\": 0,"))),
        ],
        "gltf" => vec![
            before("\"materials\"", format!("\"nodes\": [{}{{}}],", "{},".repeat(many))),
            format!("{{ \"asset\": {{ \"version\": \"2.0\" }}, \"materials\": [{}{{}}] }}", "{},".repeat(many)),
            before(
                "\"pbrMetallicRoughness\"",
                format!("\"extensions\": {{ {}\"z\": 0 }},", fewer(&|k| format!("\"EXT_{k}\":{k},"))),
            ),
        ],
        "materialx" => vec![
            before("<open", lines(&|k| format!("<add name=\"n{k}\" type=\"float\"/>"))),
            before("<input", fewer(&|k| format!("<input name=\"i{k}\" type=\"float\" value=\"x\"/>"))),
            before("<open", "<open_pbr_surface name=\"t\" type=\"surfaceshader\"/>".repeat(many / 5)),
        ],
        "usda" => vec![
            before("def Material", lines(&|k| format!("def \"p{k}\" {{}}\n"))),
            before("  float", fewer(&|k| format!("float inputs:i{k} = 1\n"))),
            before("def Material", fewer(&|k| format!("def Material \"m{k}\" {{}}\n"))),
        ],
        "mdl" => vec![
            before("roughness", lines(&|k| format!("a{k}: 1.0, "))),
            format!("mdl 1.7;\n{}", "export material M(*) = ::adobe::materials::standard();".repeat(200_000)),
        ],
        _ => vec![
            before("material.roughness", "material.ior = x;".repeat(200_000)),
            "// asm: {}\n".repeat(300_000),
            "name ".repeat(800_000),
        ],
    }
}

#[test]
fn a_million_entries_are_read_or_refused_in_time() {
    for format in &FORMATS {
        for (place, text) in million(format).iter().enumerate() {
            let start = Instant::now();
            let result = format.read("a million entries", text);
            let result = result.map(|(_, notes)| notes.len());
            println!("{} {place}: {} bytes, {:?}: {result:?}", format.name, text.len(), start.elapsed());
        }
    }
}

#[test]
fn a_large_data_uri_is_an_image_or_one_sentence() {
    let gltf = &FORMATS[1];
    let large = "AAAA".repeat(12_000_000);
    for (end, words) in [("", "none"), ("*", "expected base64, found the byte 0x2a at 48000000")] {
        let images = format!("\"images\": [{{ \"uri\": \"data:image/png;base64,{large}{end}\" }}], \"materials\"");
        let (material, notes) = gltf.read("a data URI", &gltf.good.replacen("\"materials\"", &images, 1)).expect("a document");
        assert_eq!(material.float(Property::roughness), 0.25);
        assert!(if end.is_empty() { notes.is_empty() } else { notes.len() == 1 && notes[0].contains(words) }, "{notes:?}");
    }
}
