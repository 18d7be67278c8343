//! ASM to every format and back, for materials of all kinds: bit by bit with the native copy, and without it as the sheet of losses says.

use burnish::exchange::open::open;
use burnish::exchange::save::{SaveOptions, Source, save};
use burnish::exchange::{FORMATS, Format, FormatDef};
use burnish_material::exchange::loss::{Fate, Row};
use burnish_material::{Material, PROPERTIES, Value};
use burnish_tests::exchange::{extremes, random};
use std::path::Path;

/// Materials per file, where a file holds several.
const PER_FILE: usize = 100;
/// What "exact" allows without the native copy: numbers go through text, other units and other colour spaces.
const EXACT: f64 = 1e-4;

fn materials(count: usize) -> Vec<Material> {
    extremes().into_iter().chain((0..count).map(random)).collect()
}

fn source(material: &Material) -> Source {
    let (folder, textures, embedded) = Default::default();
    Source { material: material.clone(), file: None, folder, textures, embedded }
}

/// Written by the shipped code and read again; with what the sheet of losses says.
fn there_and_back(folder: &Path, def: &FormatDef, materials: &[Material], is_bare: bool) -> Vec<(Material, Vec<Row>)> {
    let per_file = if def.format.holds_one() { 1 } else { PER_FILE };
    let mut all = Vec::new();
    for (k, part) in materials.chunks(per_file).enumerate() {
        let folder = folder.join(k.to_string());
        std::fs::create_dir_all(&folder).expect("a folder");
        let path = folder.join(format!("all.{}", def.ending));
        let sources: Vec<Source> = part.iter().map(source).collect();
        let saved =
            save(&sources, &path, SaveOptions { is_bare, ..SaveOptions::default() }, &|_| true).expect("it can be written");
        let opened = open(&path).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(opened.len(), part.len(), "{}", def.label);
        all.extend(opened.into_iter().map(|opened| opened.file.material().clone()).zip(saved.rows));
    }
    all
}

#[test]
fn a_thousand_materials_come_back_bit_by_bit_from_every_format() {
    let materials = materials(1000);
    let folder = tempfile::tempdir().expect("a folder");
    for def in FORMATS {
        // A set is a folder full of images.
        let count = if def.format == Format::TextureSet { 24 } else { materials.len() };
        let materials = &materials[..count];
        for (before, (after, _)) in materials.iter().zip(there_and_back(folder.path(), def, materials, false)) {
            for property in PROPERTIES {
                let (before, after) = (before.slot(property.id), after.slot(property.id));
                assert_eq!(before, after, "{}: {}", def.label, property.name);
            }
            assert_eq!(*before, after, "{}", def.label);
        }
    }
}

/// How far two values lie apart, relative to the larger where that is above 1.
fn difference(a: Value, b: Value) -> f64 {
    let numbers = |value| match value {
        Value::Bool(flag) => vec![f64::from(u8::from(flag))],
        Value::Float(x) => vec![x],
        Value::Color(c) => c.to_vec(),
        _ => Vec::new(),
    };
    numbers(a).iter().zip(numbers(b)).map(|(a, b)| (a - b).abs() / a.abs().max(b.abs()).max(1.0)).fold(0.0, f64::max)
}

#[test]
fn without_the_native_copy_the_sheet_names_everything_that_changes() {
    let materials = materials(200);
    let folder = tempfile::tempdir().expect("a folder");
    for def in FORMATS.iter().filter(|def| def.model().is_some() && def.format != Format::TextureSet) {
        for (before, (after, rows)) in materials.iter().zip(there_and_back(folder.path(), def, &materials, true)) {
            for property in PROPERTIES {
                let row = rows.iter().find(|row| row.property == property.id).expect("a row for each property");
                let change = difference(before.value(property.id), after.value(property.id));
                let is_told = row.fate > Fate::Remapped;
                assert!(
                    is_told || change <= EXACT,
                    "{}: {}: {} is {} and changes from {:?} to {:?}",
                    def.label,
                    before.name,
                    property.name,
                    row.fate.word(),
                    before.value(property.id),
                    after.value(property.id)
                );
            }
        }
    }
}
