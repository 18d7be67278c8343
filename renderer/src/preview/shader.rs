//! Joins WGSL files to shaders and finds the file that an error is in.
//!
//! There is no preprocessor: declarations may stand in any order, so a shader is a list of files one after the other, and
//! lobes are switched by `override` constants that the lobe table prints.

use crate::bsdf::Albedos;
use crate::bsdf::albedos::{AXES, HEAD};
use crate::bsdf::dispersion::{LAMBDA_D, WAVELENGTH_RANGE, spectrum};
use crate::bsdf::tables::{COSINES, ROUGHNESSES, sheen_table};
use crate::lanes::Lanes;
use burnish_material::{ASM_MATERIAL_WGSL, LOBES, LobeSet, PROPERTIES, Vary};
use std::fmt::Write;

/// A piece of a shader: where it comes from and its text.
pub(crate) type Piece = (&'static str, String);

macro_rules! file {
    ($path:literal) => {
        ($path, include_str!(concat!("../", $path)).to_owned())
    };
}

/// Constants that are written once in Rust: lobe switches, table sizes, the smallest alpha, wavelengths.
fn printed(lobes: Option<LobeSet>) -> String {
    let mut text = String::new();
    // Writing to a String cannot fail.
    for def in LOBES {
        _ = match lobes {
            None => writeln!(text, "override {}: bool = true;", def.switch),
            Some(lobes) => writeln!(text, "const {}: bool = {};", def.switch, lobes.has(def.lobe)),
        };
    }
    _ = writeln!(text, "const ALPHA_MIN: f32 = {:e};", <f32 as Lanes>::ALPHA_MIN);
    for (name, value) in [("ROUGHNESSES", ROUGHNESSES), ("COSINES", COSINES), ("AXES", AXES), ("HEAD", HEAD)] {
        _ = writeln!(text, "const {name}: u32 = {value};");
    }
    let [first, last] = WAVELENGTH_RANGE;
    for (name, value) in [("WAVELENGTH_FIRST", first), ("WAVELENGTH_LAST", last), ("LAMBDA_D", LAMBDA_D)] {
        _ = writeln!(text, "const {name}: f32 = {value:e};");
    }
    let [r, g, b] = spectrum().inverse_square;
    _ = writeln!(text, "const INVERSE_SQUARE = vec3f({r:e}, {g:e}, {b:e});");
    text
}

/// Wavelengths that rays choose from.
const SPECTRUM_STEPS: usize = 64;

/// The function that puts textures in the place of values, row by row of the property table.
fn mapped_rows() -> String {
    let mut text = "fn mapped_rows(given: MaterialRows, place: MapPlace) -> MaterialRows {\n    var rows = given;\n".to_owned();
    for def in PROPERTIES.iter().filter(|def| def.vary != Vary::Uniform) {
        _ = writeln!(text, "    rows.{0} = mapped(rows.{0}, place);", def.name);
    }
    text + "    return rows;\n}\n"
}

/// The lobes, without anything that draws: they need an array `albedo_tables` beside them. A set of lobes holds for good; without one, pipelines
/// choose it.
pub(crate) fn twins(lobes: Option<LobeSet>) -> Vec<Piece> {
    vec![
        ("printed constants", printed(lobes)),
        ("asm_material.gen.wgsl", ASM_MATERIAL_WGSL.to_owned()),
        file!("bsdf/numbers.wgsl"),
        file!("bsdf/fresnel.wgsl"),
        file!("bsdf/ggx.wgsl"),
        file!("bsdf/coat.wgsl"),
        file!("bsdf/sheen.wgsl"),
        file!("bsdf/tables.wgsl"),
        file!("bsdf/albedos.wgsl"),
        file!("bsdf/dispersion.wgsl"),
        file!("bsdf/interpret.wgsl"),
        file!("bsdf/bsdf.wgsl"),
        file!("bsdf/eval.wgsl"),
        file!("bsdf/sample.wgsl"),
    ]
}

/// The shader that draws objects and background.
pub(super) fn scene_pieces() -> Vec<Piece> {
    let mut pieces = twins(None);
    pieces.extend([
        file!("preview/frame.wgsl"),
        file!("preview/maps.wgsl"),
        file!("preview/object.wgsl"),
        ("mapped rows", mapped_rows()),
        file!("preview/detail.wgsl"),
        file!("preview/vertex.wgsl"),
        file!("preview/environment.wgsl"),
        file!("preview/refraction.wgsl"),
        file!("preview/lighting.wgsl"),
    ]);
    pieces
}

/// The shader that traces rays.
pub(super) fn rays_pieces() -> Vec<Piece> {
    let mut pieces = twins(None);
    pieces.extend([
        ("printed spectrum", printed_spectrum()),
        file!("preview/maps.wgsl"),
        ("mapped rows", mapped_rows()),
        file!("preview/detail.wgsl"),
        file!("preview/rays/scene.wgsl"),
        file!("preview/rays/sampler.wgsl"),
        file!("preview/rays/traverse.wgsl"),
        file!("preview/rays/light.wgsl"),
        file!("preview/rays/path.wgsl"),
    ]);
    pieces
}

/// Wavelengths of equal probability and the weights of the channels for each, which sum to white.
pub(crate) fn printed_spectrum() -> String {
    let steps = spectrum().steps(SPECTRUM_STEPS);
    let rows = steps.map(|[nm, r, g, b]| format!("    vec4f({nm:e}, {r:e}, {g:e}, {b:e}),\n")).collect::<String>();
    format!("const SPECTRUM: u32 = {SPECTRUM_STEPS}u;\nconst SPECTRUM_OF = array<vec4f, SPECTRUM>(\n{rows});\n")
}

/// The shader that averages frames and shows them.
pub(super) fn output_pieces() -> Vec<Piece> {
    vec![file!("tonemap.wgsl"), file!("preview/output.wgsl")]
}

/// The files of bloom.
pub(super) fn bloom_pieces() -> Vec<Piece> {
    vec![file!("tonemap.wgsl"), file!("preview/output.wgsl"), file!("preview/bloom.wgsl")]
}

/// The source of a shader.
pub(crate) fn join(pieces: &[Piece]) -> String {
    pieces.iter().map(|(_, text)| text.as_str()).collect::<Vec<_>>().join("\n")
}

/// `file:line` of a line (from 1) of the joined source.
pub(super) fn place_of(pieces: &[Piece], line: usize) -> String {
    let mut left = line;
    for (name, text) in pieces {
        // A file that ends in a line break is followed by the empty line that `join` puts in.
        let lines = text.split('\n').count();
        if left <= lines {
            return format!("{name}:{left}");
        }
        left -= lines;
    }
    format!("line {line}")
}

/// The message of a refused shader with the places in it translated: `wgsl:120:5` becomes `bsdf/ggx.wgsl:14:5`.
pub(crate) fn translate(pieces: &[Piece], message: &str) -> String {
    let mut out = String::new();
    let mut rest = message;
    while let Some(at) = rest.find("wgsl:") {
        out.push_str(&rest[..at]);
        let tail = &rest[at + 5..];
        let digits = tail.len() - tail.trim_start_matches(|c: char| c.is_ascii_digit()).len();
        match tail[..digits].parse::<usize>() {
            Ok(line) => out.push_str(&place_of(pieces, line)),
            Err(_) => {
                out.push_str("wgsl:");
                out.push_str(&tail[..digits]);
            }
        }
        rest = &tail[digits..];
    }
    out + rest
}

/// The twins of the lobes with `extra` after them: for tests that call a twin through the very code that draws.
///
/// `extra` holds the entry points and may use bindings of group 1; group 0 binding 0 is the array of the albedo tables,
/// to be filled with [`albedo_table_values`].
pub fn twin_shader(extra: &str) -> String {
    let mut pieces = twins(None);
    pieces.push(("table binding", "@group(0) @binding(0) var<storage, read> albedo_tables: array<f32>;\n".to_owned()));
    pieces.push(file!("tonemap.wgsl"));
    pieces.push(("entry points", extra.to_owned()));
    join(&pieces)
}

/// What `albedo_tables` holds: the table of sheen, then the words of each material. The second list says where those begin.
pub fn albedo_table_values<'a>(materials: impl IntoIterator<Item = &'a Albedos>) -> (Vec<f32>, Vec<u32>) {
    let mut values = sheen_table().to_vec();
    let begins = materials
        .into_iter()
        .map(|albedos| {
            let begin = values.len() as u32;
            values.extend(albedos.words());
            begin
        })
        .collect();
    (values, begins)
}

#[cfg(test)]
mod tests {
    use super::*;
    use burnish_material::Lobe;

    fn parse(pieces: &[Piece]) -> naga::Module {
        let source = join(pieces);
        match naga::front::wgsl::parse_str(&source) {
            Ok(module) => module,
            Err(e) => panic!("{}", translate(pieces, &e.emit_to_string(&source))),
        }
    }

    fn validate(module: &naga::Module, what: &str) {
        let mut validator = naga::valid::Validator::new(naga::valid::ValidationFlags::all(), naga::valid::Capabilities::empty());
        if let Err(e) = validator.validate(module) {
            panic!("{what}: {e:?}");
        }
    }

    #[test]
    fn joined_shaders_are_valid() {
        validate(&parse(&output_pieces()), "output");
        validate(&parse(&bloom_pieces()), "bloom");
        let scene = parse(&scene_pieces());
        validate(&scene, "scene");
        let extra = "@compute @workgroup_size(1) fn main() { _ = fresnel(0.5, 1.5); _ = display_apply(vec3f(1.0), 0.0, 0u); }";
        let twin = twin_shader(extra);
        validate(&naga::front::wgsl::parse_str(&twin).expect("the twins parse alone"), "twins");
    }

    #[test]
    fn every_lobe_set_is_valid() {
        for (pieces, stage, entry) in [
            (scene_pieces(), naga::ShaderStage::Fragment, "fragment_object"),
            (rays_pieces(), naga::ShaderStage::Compute, "trace_paths"),
        ] {
            every_set(&parse(&pieces), stage, entry);
        }
    }

    fn every_set(scene: &naga::Module, stage: naga::ShaderStage, entry: &str) {
        let mut validator = naga::valid::Validator::new(naga::valid::ValidationFlags::all(), naga::valid::Capabilities::empty());
        let info = validator.validate(scene).expect("the shader is valid");
        let mut sets = vec![LobeSet::all(), LobeSet::EMPTY];
        for (i, a) in LOBES.iter().enumerate() {
            sets.push(LobeSet::all().without(a.lobe));
            sets.push(LobeSet::EMPTY.with(a.lobe));
            sets.extend(LOBES[i + 1..].iter().map(|b| LobeSet::EMPTY.with(a.lobe).with(b.lobe)));
        }
        for set in sets {
            let constants: naga::back::PipelineConstants =
                LOBES.iter().map(|def| (def.switch.to_owned(), f64::from(u8::from(set.has(def.lobe))))).collect();
            let entry = Some((stage, entry));
            if let Err(e) = naga::back::pipeline_constants::process_overrides(scene, &info, entry, &constants) {
                panic!("{:?}: {e:?}", set.names(true));
            }
        }
        assert!(LobeSet::all().has(Lobe::coat));
    }

    #[test]
    fn places_point_into_files() {
        let pieces: Vec<Piece> = vec![("a.wgsl", "1\n2\n".to_owned()), ("b.wgsl", "1\n2".to_owned())];
        assert_eq!(join(&pieces), "1\n2\n\n1\n2");
        assert_eq!(place_of(&pieces, 2), "a.wgsl:2");
        assert_eq!(place_of(&pieces, 5), "b.wgsl:2");
        assert_eq!(translate(&pieces, "  wgsl:5:3 here"), "  b.wgsl:2:3 here");
    }
}
