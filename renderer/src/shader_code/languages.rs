//! WGSL of a material in other languages, by way of naga.

use super::comments::{Comments, header, uncommented};
use super::source::{Source, Tables, rows};
use super::{Language, ShaderError};
use burnish_material::{Kind, Material};
use naga::back::{glsl, hlsl, msl, spv};
use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};
use naga::{Module, ShaderStage};
use std::fmt::Write;

/// Without an entry point naga writes no GLSL, and without a call no uniform block.
const ENTRY: &str = "
@compute @workgroup_size(1) fn main() {
    let s = material_sample({textured}vec3f(0.0, 0.0, 1.0), vec4f(0.5));
}
";

/// Evaluates a list of queries: what a SPIR-V module is for that nothing is linked to.
const EVALUATE: &str = "
struct Query {
    wo: vec4f,
    wi: vec4f,
    u: vec4f,
{members}}

struct Result {
    value: vec3f,
    pdf: f32,
    wi: vec3f,
    sample_pdf: f32,
    weight: vec3f,
    flags: f32,
}

@group(0) @binding(1) var<storage, read> queries: array<Query>;
@group(0) @binding(2) var<storage, read_write> results: array<Result>;

@compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= arrayLength(&queries) || id.x >= arrayLength(&results) { return; }
    let query = queries[id.x];
{textured}    let bsdf = material_prepare({pass}view_new(query.wo.xyz));
    let e = bsdf_eval(bsdf, query.wi.xyz);
    let s = bsdf_sample(bsdf, query.u);
    let flags = select(0.0, 1.0, s.is_valid) + select(0.0, 2.0, s.is_delta) + select(0.0, 4.0, s.is_transmission);
    results[id.x] = Result(e.value, e.pdf, s.wi, s.pdf, s.weight, flags);
}
";

/// The text of a language, with header and comments.
pub(super) fn text(source: &Source, material: &Material, language: Language) -> Result<String, ShaderError> {
    let head = header(source, material, language);
    let tables = |declaration| source.tables(declaration).map(|text| format!("\n{text}")).unwrap_or_default();
    let comments = Comments::of(&source.text);
    let failed = |error: String| ShaderError { language, message: error };
    let body = match language {
        Language::Wgsl => {
            let text = format!("{}{}", source.text, tables(Tables::Variable));
            validated(&text).map_err(failed)?;
            return Ok(format!("{head}\n{text}"));
        }
        Language::Hlsl => {
            let (module, info) = validated(&format!("{}{}", source.text, tables(Tables::Empty))).map_err(failed)?;
            let options = hlsl::Options { shader_model: hlsl::ShaderModel::V6_0, ..hlsl::Options::default() };
            let mut text = String::new();
            let pipeline = hlsl::PipelineOptions::default();
            hlsl::Writer::new(&mut text, &options, &pipeline)
                .write(&module, &info, None)
                .map_err(|error| failed(error.to_string()))?;
            with_tables(&text, source)
        }
        Language::Msl => {
            let (module, info) = validated(&format!("{}{}", source.text, tables(Tables::Constant))).map_err(failed)?;
            let options = msl::Options { lang_version: (2, 0), force_loop_bounding: false, ..msl::Options::default() };
            let (text, _) = msl::write_string(&module, &info, &options, &msl::PipelineOptions::default())
                .map_err(|error| failed(error.to_string()))?;
            text
        }
        Language::Glsl => {
            let main = ENTRY.replace("{textured}", if source.textured.is_empty() { "" } else { "Textured(), " });
            let (module, info) = validated(&format!("{}{}{main}", source.text, tables(Tables::Constant))).map_err(failed)?;
            without_main(&glsl_text(&module, &info).map_err(failed)?)
        }
        // Neither comes from naga as text.
        Language::Spirv | Language::Osl => String::new(),
    };
    Ok(comments.added(&head, &body))
}

/// The module of SPIR-V as little-endian words; the header stands in it as an `OpString`.
pub(super) fn spirv(source: &Source, material: &Material) -> Result<Vec<u8>, ShaderError> {
    let failed = |error: String| ShaderError { language: Language::Spirv, message: error };
    let (mut members, mut textured) = (String::new(), String::new());
    if !source.textured.is_empty() {
        textured += "    var textured: Textured;\n";
    }
    for def in &source.textured {
        let component = if def.default.kind() == Kind::Float { "x" } else { "xyz" };
        // Writing to a String cannot fail.
        _ = writeln!(members, "    {}: vec4f,", def.name);
        _ = writeln!(textured, "    textured.{0} = query.{0}.{component};", def.name);
    }
    let pass = if source.textured.is_empty() { "" } else { "textured, " };
    let main = EVALUATE.replace("{members}", &members).replace("{textured}", &textured).replace("{pass}", pass);
    let tables = source.tables(Tables::Variable).unwrap_or_default();
    let (module, info) = validated(&format!("{}\n{tables}{main}", source.text)).map_err(failed)?;
    let options = spv::Options {
        lang_version: (1, 3),
        flags: spv::WriterFlags::DEBUG,
        force_loop_bounding: false,
        ..spv::Options::default()
    };
    let words = spv::write_vec(&module, &info, &options, None).map_err(|error| failed(error.to_string()))?;
    let words = with_string(words, &uncommented(&header(source, material, Language::Spirv)));
    Ok(words.iter().flat_map(|word| word.to_le_bytes()).collect())
}

/// The module of a WGSL text; a sentence where it is refused.
fn validated(text: &str) -> Result<(Module, ModuleInfo), String> {
    let module = naga::front::wgsl::parse_str(text).map_err(|error| error.emit_to_string(text))?;
    let info = Validator::new(ValidationFlags::all(), Capabilities::empty())
        .validate(&module)
        .map_err(|error| error.emit_to_string(text))?;
    Ok((module, info))
}

fn glsl_text(module: &Module, info: &ModuleInfo) -> Result<String, String> {
    let options = glsl::Options {
        version: glsl::Version::Desktop(450),
        writer_flags: glsl::WriterFlags::empty(),
        ..glsl::Options::default()
    };
    let pipeline = glsl::PipelineOptions { shader_stage: ShaderStage::Compute, entry_point: "main".to_owned(), multiview: None };
    let policies = naga::proc::BoundsCheckPolicies::default();
    let mut text = String::new();
    glsl::Writer::new(&mut text, module, info, &options, &pipeline, policies)
        .and_then(|mut writer| writer.write())
        .map_err(|error| error.to_string())?;
    Ok(text)
}

/// GLSL without the entry point that stood for the caller's.
fn without_main(text: &str) -> String {
    let text = text.split("void main()").next().unwrap_or_default();
    let lines = text.lines().filter(|line| !line.starts_with("layout(local_size_x"));
    lines.map(|line| format!("{line}\n")).collect()
}

/// HLSL whose constant arrays are lists: naga passes their numbers to a function, which not every compiler takes for a constant.
fn with_tables(text: &str, source: &Source) -> String {
    let count = source.tables.len();
    let declaration = format!("static float albedo_tables[{count}]");
    let (mut out, mut makers) = (String::new(), Vec::new());
    for line in text.lines() {
        let made = line.strip_prefix("static const ").and_then(|rest| rest.split_once(" = Constructarray"));
        if line.starts_with(&declaration) {
            out += &format!("static const float albedo_tables[{count}] = {{\n{}}};\n", rows(&source.tables));
        } else if let Some((left, (maker, numbers))) = made.and_then(|(left, call)| Some((left, call.split_once('(')?))) {
            makers.push(format!("Constructarray{maker}("));
            out += &format!("static const {left} = {{{}}};\n", numbers.trim_end_matches(");"));
        } else {
            out += &format!("{line}\n");
        }
    }
    for maker in makers.iter().filter(|maker| text.matches(maker.as_str()).count() == 2) {
        // Its type, which a line before declares, and its body.
        let start = out.find(&format!("typedef float4 ret_{}", maker.trim_end_matches('(')));
        let end = start.and_then(|start| Some(start + out[start..].find("\n}\n")? + "\n}\n".len()));
        if let (Some(start), Some(end)) = (start, end) {
            out.replace_range(start..end, "");
        }
    }
    out
}

/// The module with a string among its debug information, before the first name.
fn with_string(mut words: Vec<u32>, text: &str) -> Vec<u32> {
    const HEADER: usize = 5;
    const OP_STRING: u32 = 7;
    const OP_NAMES: [u32; 2] = [5, 6];
    // An instruction holds its length in 16 bits.
    let bytes: Vec<u8> = text.bytes().take(4 * 65_000).collect();
    let mut at = HEADER;
    while at < words.len() && !OP_NAMES.contains(&(words[at] & 0xFFFF)) {
        at += (words[at] >> 16).max(1) as usize;
    }
    if at >= words.len() {
        return words;
    }
    let id = words[3];
    words[3] += 1;
    // A string ends with at least one zero.
    let mut packed: Vec<u32> = bytes
        .chunks(4)
        .map(|chunk| chunk.iter().enumerate().fold(0, |word, (i, byte)| word | u32::from(*byte) << (8 * i)))
        .collect();
    if bytes.len().is_multiple_of(4) {
        packed.push(0);
    }
    let length = 2 + packed.len() as u32;
    words.splice(at..at, [length << 16 | OP_STRING, id].into_iter().chain(packed));
    words
}
