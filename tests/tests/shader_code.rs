//! Is a material's shader code accepted by those who read it, does it hold no more than it needs, and does it compute what the lobes compute?

use burnish_material::{Lobe, LobeSet, Material, Property, Property::*, TextureRef, Value};
use burnish_renderer::bsdf::{Albedos, View};
use burnish_renderer::shader_code::{Language, ShaderOptions, write};
use burnish_renderer::vector::V3;
use burnish_tests::gpu::{Buffer, run};
use burnish_tests::materials::{c, cases, f, material, random};
use burnish_tests::number::Random;
use burnish_tests::quadrature::direction;
use burnish_tests::surface::Surface;
use std::path::Path;
use std::process::Command;

/// Environment variable that turns a missing checker from a visible skip into a failure.
const REQUIRE: &str = "BURNISH_REQUIRE_SHADER_TOOLS";
/// Largest relative difference between both renderers' lobes, as `parity.rs` has it.
const LIMIT: f32 = 1e-3;
const CONSTANT: ShaderOptions = ShaderOptions { is_uniform: false };
const UNIFORM: ShaderOptions = ShaderOptions { is_uniform: true };

fn everything() -> Material {
    let mut all = material(&[
        (base_color, c(0.8, 0.4, 0.2)),
        (metallic, f(0.3)),
        (translucency, f(0.5)),
        (roughness, f(0.35)),
        (anisotropy, f(0.6)),
        (anisotropy_rotation, f(0.1)),
        (sheen, f(0.4)),
        (coat, f(0.7)),
        (coat_roughness, f(0.3)),
        (coat_color, c(0.9, 0.8, 0.7)),
        (emission, f(2.0)),
        (opacity, f(0.9)),
        (absorption_color, c(0.9, 0.5, 0.2)),
        (absorption_distance, f(2.0)),
        (dispersion, f(1.0)),
    ]);
    all.set(scatter, Value::Bool(true));
    for property in [normal, coat_normal, height] {
        all.slot_mut(property).texture = Some(TextureRef::new("map.png"));
    }
    all
}

fn textured(mut material: Material, properties: &[Property]) -> Material {
    for property in properties {
        material.slot_mut(*property).texture = Some(TextureRef::new("map.png"));
    }
    material
}

fn named() -> Vec<(&'static str, Material)> {
    let glass =
        [(translucency, f(1.0)), (roughness, f(0.2)), (absorption_color, c(0.6, 0.9, 0.8)), (absorption_distance, f(1.0))];
    let paint =
        [(base_color, c(0.7, 0.05, 0.05)), (metallic, f(0.6)), (roughness, f(0.4)), (coat, f(1.0)), (coat_roughness, f(0.05))];
    let cloth = [(base_color, c(0.1, 0.1, 0.5)), (roughness, f(0.9)), (sheen, f(0.8)), (sheen_color, c(0.6, 0.6, 1.0))];
    vec![
        ("default", Material::named("default")),
        ("lambert", material(&[(specular_level, f(0.0))])),
        ("glass", material(&glass)),
        ("car paint", material(&paint)),
        ("cloth", material(&cloth)),
        ("everything", everything()),
        ("everything, textured", textured(everything(), &[base_color, roughness, coat_roughness, scatter_color])),
    ]
}

fn text_of(material: &Material, language: Language, options: ShaderOptions) -> String {
    let code = write(material, language, options).unwrap_or_else(|error| panic!("{error}"));
    String::from_utf8(code.bytes).expect("text is UTF-8")
}

/// Runs a checker over a file; `None`, said aloud, where there is no such program.
fn checked(program: &str, arguments: &[&str], file: &Path) -> Option<Result<(), String>> {
    match Command::new(program).args(arguments).arg(file).output() {
        Ok(output) if output.status.success() => Some(Ok(())),
        Ok(output) => Some(Err(String::from_utf8_lossy(&[output.stdout, output.stderr].concat()).into_owned())),
        Err(error) => {
            // Debian has no package with `oslc`.
            assert!(std::env::var_os(REQUIRE).is_none() || program == "oslc", "{program}: {error}");
            eprintln!("SKIPPED: {program}: {error}");
            None
        }
    }
}

/// HLSL with an entry point. Casts of 0 to structs and arrays, which naga writes and this checker does not know, are left out.
fn with_hlsl_entry(code: &[u8]) -> String {
    let text = std::str::from_utf8(code).expect("text is UTF-8");
    let plain = |line: &str| match line.split_once(" = (") {
        Some((left, cast)) if cast.ends_with(")0;") => format!("{left};\n"),
        _ => format!("{line}\n"),
    };
    let (declare, pass) = if text.contains("struct Textured {") { ("Textured textured; ", "textured, ") } else { ("", "") };
    let call = format!("material_sample({pass}float3(0.0, 0.0, 1.0), float4(0.5, 0.5, 0.5, 0.5))");
    let entry = format!("[numthreads(1, 1, 1)] void main() {{ {declare}BsdfSample s = {call}; }}\n");
    text.lines().map(plain).collect::<String>() + &entry
}

fn valid_wgsl(text: &str, what: &str) {
    let module = naga::front::wgsl::parse_str(text).unwrap_or_else(|error| panic!("{what}: {}", error.emit_to_string(text)));
    let flags = naga::valid::ValidationFlags::all();
    let validated = naga::valid::Validator::new(flags, naga::valid::Capabilities::empty()).validate(&module);
    assert!(validated.is_ok(), "{what}: {validated:?}");
}

#[test]
fn every_language_is_accepted_by_its_readers() {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, material) in named() {
        for (language, word) in Language::ALL {
            let options = if name == "lambert" || name == "glass" { &[CONSTANT][..] } else { &[CONSTANT, UNIFORM] };
            for options in options.iter().copied() {
                let what = format!("{name} as {word}, {options:?}");
                let code = write(&material, language, options).unwrap_or_else(|error| panic!("{what}: {error}"));
                assert_eq!(code.lobes, LobeSet::of(&material), "{what}");
                let file = folder.path().join(format!("code.{word}"));
                std::fs::write(&file, &code.bytes).expect("the folder is writable");
                let verdict = match language {
                    Language::Glsl => checked("glslangValidator", &["-S", "comp"], &file),
                    Language::Spirv => checked("spirv-val", &["--target-env", "vulkan1.1"], &file),
                    Language::Hlsl => {
                        std::fs::write(&file, with_hlsl_entry(&code.bytes)).expect("the folder is writable");
                        checked("glslangValidator", &["-D", "-V", "-S", "comp", "-e", "main", "-o", "/dev/null"], &file)
                    }
                    Language::Osl => checked("oslc", &["-q", "-o", "/dev/null"], &file),
                    _ => None,
                };
                assert_eq!(verdict.unwrap_or(Ok(())), Ok(()), "{what}");
                if language == Language::Spirv {
                    assert_eq!(code.bytes[..4], 0x0723_0203_u32.to_le_bytes(), "{what}");
                    continue;
                }
                let text = String::from_utf8(code.bytes).expect("text is UTF-8");
                assert!(text.contains(&format!("Lobes in: {}", code.lobes.names(true)[0])), "{what}");
                let has_functions =
                    ["material_eval(", "material_pdf(", "material_sample("].iter().all(|name| text.contains(name));
                assert!(has_functions || language == Language::Osl, "{what}");
                if language == Language::Wgsl {
                    valid_wgsl(&text, &what);
                }
            }
        }
    }
}

#[test]
fn any_mix_of_lobes_is_valid() {
    let mut all: Vec<Material> = cases(0.3).into_iter().map(|(_, material)| material).collect();
    all.extend((0..24).map(random));
    all.extend(named().into_iter().map(|(_, material)| material));
    for (i, material) in all.iter().enumerate() {
        // Every other one with its values in a block: the code is checked as it is written.
        let options = ShaderOptions { is_uniform: i % 2 == 0 };
        let language = [Language::Wgsl, Language::Hlsl, Language::Msl, Language::Glsl][i / 2 % 4];
        assert!(!text_of(material, language, options).is_empty());
    }
}

#[test]
fn what_is_left_out_is_not_in_the_code() {
    let by_lobe = [
        (Lobe::metal, "fn f82_tint("),
        (Lobe::transmission, "fn refract_at("),
        (Lobe::sheen, "fn sheen_eval("),
        (Lobe::coat, "fn coat_passage("),
        (Lobe::dispersion, "fn dispersed_ior("),
        (Lobe::scattering, "fn scattering("),
        (Lobe::emission, "fn material_emission("),
        (Lobe::opacity, "fn material_opacity("),
    ];
    for (name, material) in named() {
        let text = text_of(&material, Language::Wgsl, CONSTANT);
        let lobes = LobeSet::of(&material);
        for (lobe, function) in by_lobe {
            assert_eq!(text.contains(function), lobes.has(lobe), "{name}: {function}");
        }
        // A coat does not follow the frame that the base's maps bend.
        let is_bent = [Lobe::normal_map, Lobe::coat_normal_map, Lobe::height].into_iter().any(|lobe| lobes.has(lobe));
        assert_eq!(text.contains("fn coat_frame_new("), lobes.has(Lobe::coat) && is_bent, "{name}");
        for def in burnish_material::LOBES {
            assert!(!text.contains(def.switch), "{name}: {} is decided", def.switch);
        }
    }
}

#[test]
fn values_stand_in_the_code_or_in_the_block() {
    let material =
        textured(material(&[(base_color, c(0.25, 0.5, 0.75)), (roughness, f(0.625)), (coat, f(0.5))]), &[specular_level]);
    let constant = text_of(&material, Language::Wgsl, CONSTANT);
    assert!(constant.contains("inputs.base_color = vec3f(0.25, 0.5, 0.75);") && !constant.contains("var<uniform>"));
    let uniform = text_of(&material, Language::Wgsl, UNIFORM);
    assert!(uniform.contains("inputs.roughness = material.roughness.x;") && uniform.contains("var<uniform> material"));
    for text in [&constant, &uniform] {
        assert!(text.contains("inputs.specular_level = textured.specular_level;"));
        // The tables were made for this coat.
        assert!(text.contains("inputs.coat = 0.5;"));
    }
    let osl = text_of(&material, Language::Osl, UNIFORM);
    assert!(osl.contains("color base_color = color(0.25, 0.5, 0.75)") && osl.contains("surface asm_case("));
}

#[test]
fn names_and_licences_stay_in_their_comment() {
    let mut material = Material::named("brass\n*/ } evil \\");
    material.provenance.licence = "CC0\\\nint x;".to_owned();
    for (language, _) in Language::ALL.into_iter().filter(|(language, _)| *language != Language::Spirv) {
        let text = text_of(&material, language, CONSTANT);
        assert!(text.lines().any(|line| line.starts_with("// Licence of the material: CC0")), "{text}");
        for line in text.lines().filter(|line| line.contains("evil") || line.contains("int x;")) {
            assert!(line.starts_with("//") && !line.ends_with('\\') || line.starts_with("surface asm_brass_evil"), "{line}");
        }
    }
}

/// Words of OSL and of its library that the shaders use.
const OSL_WORDS: &str = "surface float color normal vector int closure return if N I Ci dPdu M_PI ggx normalize cos sin cross abs dot max min length \
    clamp sqrt pow mix log layer dielectric_bsdf generalized_schlick_bsdf oren_nayar_diffuse_bsdf sheen_bsdf anisotropic_vdf backfacing \
    emission transparent";

#[test]
fn osl_says_nothing_that_it_does_not_declare() {
    let types = ["float", "color", "normal", "vector", "int"];
    for (name, material) in named() {
        for options in [CONSTANT, UNIFORM] {
            let text = text_of(&material, Language::Osl, options);
            let code: Vec<&str> = text.lines().filter(|line| !line.trim_start().starts_with("//")).collect();
            let code = code.join("\n");
            for (open, close) in [('(', ')'), ('{', '}')] {
                assert_eq!(code.matches(open).count(), code.matches(close).count(), "{name}: {open}");
            }
            let mut declared: Vec<&str> = OSL_WORDS.split_whitespace().collect();
            let mut before = "";
            for word in code.split(|c: char| !c.is_ascii_alphanumeric() && c != '_').filter(|word| !word.is_empty()) {
                if types.contains(&before) || before == "surface" {
                    declared.push(word);
                }
                let is_number = word.starts_with(|c: char| c.is_ascii_digit());
                assert!(is_number || declared.contains(&word), "{name}: `{word}` is not declared in\n{text}");
                before = word;
            }
        }
    }
}

/// Floats of a query and of a result.
const QUERY: usize = 12;
const RESULT: usize = 12;

const ENTRY: &str = "
struct Query { wo: vec4f, wi: vec4f, u: vec4f }
struct Result { value: vec3f, pdf: f32, wi: vec3f, sample_pdf: f32, weight: vec3f, flags: f32 }
@group(GROUP) @binding(0) var<storage, read_write> results: array<Result>;
@group(GROUP) @binding(1) var<storage, read> queries: array<Query>;
@group(GROUP) @binding(2) var<storage, read> albedo_tables: array<f32>;
@compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= arrayLength(&queries) { return; }
    let q = queries[id.x];
    TEXTURED
    let s = material_sample(PASS q.wo.xyz, q.u);
    let flags = select(0.0, 1.0, s.is_valid) + select(0.0, 2.0, s.is_delta) + select(0.0, 4.0, s.is_transmission);
    let value = material_eval(PASS q.wo.xyz, q.wi.xyz);
    results[id.x] = Result(value, material_pdf(PASS q.wo.xyz, q.wi.xyz), s.wi, s.pdf, s.weight, flags);
}
";

/// The code without its tables, and what they hold: a software adapter takes minutes to compile a large array, so they go into a buffer.
fn apart(text: &str) -> (String, Vec<f32>) {
    let (before, tables) = text.split_once("var<private> albedo_tables: array<f32, ").expect("tables");
    let (count, rest) = tables.split_once('>').expect("their number");
    let (numbers, after) = rest.split_once("(\n").and_then(|(_, rest)| rest.split_once(");")).expect("their numbers");
    let numbers: Vec<f32> = numbers.split(',').map(|x| x.trim().parse().expect("a number")).collect();
    assert_eq!(count.parse(), Ok(numbers.len()));
    (format!("{before}{after}"), numbers)
}

/// One shader beside the lobes of the final view: `text` with what it needs, against a surface.
fn compare(name: &str, text: &str, surface: &Surface<f32>, textured: &[(&str, f32)], block: Option<&[f32]>) {
    let mut random = Random::new(7);
    let mut queries = Vec::new();
    for mu in [1.0, 0.7, 0.2, 0.03, -0.9, -0.3] {
        let wo: V3<f32> = direction(mu, 0.9);
        let bsdf = surface.bsdf(&View::new(wo));
        for i in 0..16 {
            let mut u = || [0; 4].map(|_: i32| random.unit() as f32);
            let (likely, drawn) = (bsdf.sample(u()), u());
            let any = direction(2.0 * f64::from(drawn[0]) - 1.0, 6.3 * f64::from(drawn[1]));
            queries.push((wo, if i % 3 != 0 && likely.is_valid { likely.wi } else { any }, u()));
        }
    }
    let flat: Vec<f32> =
        queries.iter().flat_map(|(o, i, u)| [o.x, o.y, o.z, 0.0, i.x, i.y, i.z, 0.0, u[0], u[1], u[2], u[3]]).collect();
    assert_eq!(flat.len(), QUERY * queries.len());
    let fill: String = textured.iter().map(|(name, x)| format!("textured.{name} = {x:?};")).collect();
    let (declare, pass) =
        if textured.is_empty() { (String::new(), "") } else { (format!("var textured: Textured; {fill}"), "textured,") };
    let group = if block.is_some() { "1" } else { "0" };
    let entry = ENTRY.replace("GROUP", group).replace("TEXTURED", &declare).replace("PASS", pass);
    let (text, tables) = apart(text);
    let data = vec![Buffer::Result(RESULT * queries.len()), Buffer::Storage(&flat), Buffer::Storage(&tables)];
    let groups = match block {
        Some(block) => vec![vec![Buffer::Uniform(block)], data],
        None => vec![data],
    };
    let Some(found) = run(&format!("{text}{entry}"), &groups, queries.len()) else { return };
    let (mut sampled, mut bright) = (0, 0);
    for ((wo, wi, u), found) in queries.iter().zip(found.chunks_exact(RESULT)) {
        let bsdf = surface.bsdf(&View::new(*wo));
        let (value, pdf) = bsdf.eval(*wi);
        let s = bsdf.sample(*u);
        assert!(found.iter().all(|x| x.is_finite()), "{name}: {found:?}");
        let close = |what: &str, a: f32, b: f32, scale: f32| {
            let share = ((a - b).abs() - 1e-6) / a.abs().max(scale).max(1e-6);
            assert!(share <= LIMIT, "{name}, {wo:?}, {wi:?}: {what}: Rust {a}, shader {b}");
        };
        for (rust, shader) in value.0.iter().zip(found) {
            close("value", *rust, *shader, value.max_channel());
        }
        close("density", pdf, found[3], 0.0);
        bright += usize::from(value.max_channel() > 0.0);
        let flags = f32::from(u8::from(s.is_valid) + 2 * u8::from(s.is_delta) + 4 * u8::from(s.is_transmission));
        // A number on the boundary between two lobes may be rounded to either.
        if s.is_valid && flags == found[11] {
            sampled += 1;
            close("density drawn", s.pdf, found[7], 0.0);
            for k in 0..3 {
                close("weight", s.weight.0[k], found[8 + k], s.weight.max_channel());
                let (a, b) = ([s.wi.x, s.wi.y, s.wi.z][k], found[4 + k]);
                assert!((a - b).abs() < 1e-3, "{name}: direction: Rust {a}, shader {b}");
            }
        }
    }
    let count = queries.len();
    assert!(sampled * 2 > count && bright * 3 > count, "{name}: {sampled} samples, {bright} values of {count} compared");
}

#[test]
fn the_code_computes_what_the_lobes_compute() {
    for (name, material) in named().into_iter().filter(|(name, _)| !["lambert", "default", "everything, textured"].contains(name))
    {
        let text = text_of(&material, Language::Wgsl, CONSTANT);
        // The code has tables for one wavelength.
        let lobes = LobeSet::of(&material);
        let inputs = material.inputs().convert(|x| f64::from(x as f32));
        let albedos = Albedos::uniform(&inputs, lobes.without(Lobe::dispersion));
        compare(name, &text, &Surface::with(&material, lobes, albedos), &[], None);
    }
}

#[test]
fn images_and_blocks_take_the_place_of_values() {
    let plain = material(&[
        (base_color, c(0.8, 0.3, 0.1)),
        (metallic, f(0.5)),
        (roughness, f(0.45)),
        (coat, f(0.5)),
        (coat_roughness, f(0.2)),
    ]);
    let inputs = plain.inputs().convert(|x| f64::from(x as f32));
    let lobes = LobeSet::of(&plain);
    let varied = |varies: &[Property], lobes: LobeSet| {
        let albedos = Albedos::new(&inputs, lobes, |p| varies.contains(&p), []);
        Surface::<f32>::with(&plain, lobes, albedos)
    };
    let with_image = textured(plain.clone(), &[roughness]);
    let text = text_of(&with_image, Language::Wgsl, CONSTANT);
    compare("image of roughness", &text, &varied(&[roughness], LobeSet::of(&with_image)), &[("roughness", 0.45)], None);

    let text = text_of(&plain, Language::Wgsl, UNIFORM);
    let (_, members) = text.split_once("struct MaterialBlock {").expect("a block");
    let (members, _) = members.split_once('}').expect("its end");
    let names = members.lines().filter_map(|line| line.trim().strip_suffix(": vec4f,"));
    let block: Vec<f32> = names
        .flat_map(|name| {
            let value = plain.value(Property::from_name(name).expect("a property"));
            let numbers = value.numbers();
            [0, 1, 2, 3].map(|k| numbers.get(k).map_or(0.0, |x| *x as f32))
        })
        .collect();
    compare("block of values", &text, &varied(&[roughness, coat_roughness], lobes), &[], Some(&block));
}
