//! What we write, read by the reference programs of the formats: the Khronos validator, MaterialX and OpenUSD.
//!
//! `tests/run` installs them where it can and says so where it cannot; without it these tests are skipped, since the programs are large.

use burnish::exchange::Format;
use burnish::exchange::save::{SaveOptions, Source, save};
use burnish_assets::make_shape;
use burnish_material::{Channel, Material, PROPERTIES, Property, TextureRef, Value};
use burnish_tests::exchange::{extremes, random};
use serde_json::Value as Json;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Environment variable: a Python with MaterialX and usd-core.
const PYTHON: &str = "BURNISH_INTERCHANGE_PYTHON";
/// Environment variable: a folder with the npm package gltf-validator.
const GLTF_VALIDATOR: &str = "BURNISH_GLTF_VALIDATOR";

/// What a variable says; `None`, and a word about it, where the program is not there.
fn program(variable: &str) -> Option<String> {
    let found = std::env::var(variable).ok().filter(|text| !text.is_empty());
    if found.is_none() {
        eprintln!("skipped: {variable} is not set");
    }
    found
}

fn script(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("interchange").join(name)
}

/// Runs a checker: its report by file, after no file had a fault.
fn check(mut command: Command, files: &[PathBuf]) -> BTreeMap<String, Json> {
    let output = command.args(files).output().expect("the checker starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let report: BTreeMap<String, Json> = serde_json::from_slice(&output.stdout).expect("a report");
    assert_eq!(report.len(), files.len());
    for (file, found) in &report {
        let faults = found["faults"].as_array().expect("a list of faults");
        assert!(faults.is_empty(), "{file}: {faults:#?}");
    }
    report
}

/// A material with maps: colours, one channel, scaled, inverted, and two that share an image in one format and not in others.
fn with_maps() -> Material {
    let mut material = Material::named("Maps");
    for (property, file) in [
        (Property::base_color, "colors.png"),
        (Property::roughness, "grey.png"),
        (Property::metallic, "grey.png"),
        (Property::coat, "colors.png"),
        (Property::normal, "colors.png"),
        (Property::emission_color, "colors.png"),
    ] {
        material.slot_mut(property).texture = Some(TextureRef::new(file.to_owned()));
    }
    material.set(Property::emission, Value::Float(3.0));
    let mut change = |property: Property, change: &dyn Fn(&mut TextureRef)| {
        material.slot_mut(property).texture.as_mut().map(change);
    };
    change(Property::coat, &|texture| texture.channel = Channel::G);
    change(Property::metallic, &|texture| texture.is_inverted = true);
    change(Property::base_color, &|texture| (texture.scale, texture.bias) = ([0.5, 0.25, 1.0], [0.1, 0.0, 0.0]));
    material
}

/// Writes files of every kind of material; several in one file, alone, with maps, and worn by a mesh.
fn written(folder: &Path, endings: &[&str]) -> Vec<PathBuf> {
    let grey: Vec<u8> = (0..64).map(|k| k * 4).collect();
    let colors: Vec<u8> = (0..192).collect();
    image::save_buffer(folder.join("grey.png"), &grey, 8, 8, image::ExtendedColorType::L8).expect("a file");
    image::save_buffer(folder.join("colors.png"), &colors, 8, 8, image::ExtendedColorType::Rgb8).expect("a file");
    let sphere = make_shape("sphere").expect("a built-in shape").parts.remove(0).mesh;
    let source = |material: Material| {
        let (textures, _) = burnish::files::load_textures(&material, Some(folder));
        Source { material, file: None, folder: Some(folder.to_path_buf()), textures, embedded: Default::default() }
    };
    let mut files = Vec::new();
    for ending in endings {
        let mut write = |name: &str, materials: Vec<Material>, has_mesh: bool| {
            let path = folder.join("out").join(format!("{name}.{ending}"));
            std::fs::create_dir_all(folder.join("out")).expect("a folder");
            let sources: Vec<Source> = materials.into_iter().map(source).collect();
            let options = SaveOptions { mesh: has_mesh.then_some((&sphere, 0.1)), ..SaveOptions::default() };
            save(&sources, &path, options, &|_| true).expect("it can be written");
            files.push(path);
        };
        write("all", extremes().into_iter().chain((0..40).map(random)).collect(), false);
        write("maps", vec![with_maps()], false);
        if Format::of(Path::new(&format!("a.{ending}"))) != Some(Format::MaterialX) {
            write("mesh", vec![extremes().remove(1)], true);
        }
    }
    files
}

#[test]
fn the_khronos_validator_accepts_gltf() {
    let Some(package) = program(GLTF_VALIDATOR) else { return };
    let folder = tempfile::tempdir().expect("a folder");
    let mut command = Command::new("node");
    command.arg(script("check_gltf.mjs")).arg(package);
    check(command, &written(folder.path(), &["gltf", "glb"]));
}

#[test]
fn materialx_accepts_documents_and_makes_code_of_them() {
    let Some(python) = program(PYTHON) else { return };
    let folder = tempfile::tempdir().expect("a folder");
    let mut command = Command::new(python);
    command.arg(script("check_mtlx.py"));
    let report = check(command, &written(folder.path(), &["mtlx"]));
    assert!(report.values().all(|found| found["code"].as_u64().is_some_and(|length| length > 10_000)), "{report:?}");
}

#[test]
fn openusd_accepts_layers_and_reads_all_forty_inputs() {
    let Some(python) = program(PYTHON) else { return };
    let folder = tempfile::tempdir().expect("a folder");
    let mut command = Command::new(python);
    command.arg(script("check_usd.py"));
    let report = check(command, &written(folder.path(), &["usda", "usdz"]));
    let off_default = &extremes()[1];
    for (file, found) in report.iter().filter(|(file, _)| file.contains("all.") || file.contains("mesh.")) {
        let inputs = found["inputs"][&off_default.name].as_object().expect("the inputs of the material");
        assert_eq!(inputs.len(), PROPERTIES.len(), "{file}: {inputs:?}");
        for property in PROPERTIES {
            let read: Vec<f64> = match &inputs[property.usage] {
                Json::Array(numbers) => numbers.iter().filter_map(Json::as_f64).collect(),
                Json::Bool(flag) => vec![f64::from(u8::from(*flag))],
                number => vec![number.as_f64().expect("a number")],
            };
            let ours = match off_default.value(property.id) {
                Value::Bool(flag) => vec![f64::from(u8::from(flag))],
                Value::Float(x) => vec![x],
                Value::Color(c) => c.to_vec(),
                // Not a number: the direction that no map changes.
                _ => continue,
            };
            let is_near = |(a, b): (&f64, &f64)| (a - b).abs() <= 1e-6 * b.abs().max(1.0);
            assert!(
                read.len() == ours.len() && read.iter().zip(&ours).all(is_near),
                "{file}: {}: {read:?} for {ours:?}",
                property.name
            );
        }
    }
}
