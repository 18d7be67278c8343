//! Makes the list of preset files, so that adding a preset is adding one file under `data/`.
//!
//! Reads only the lines that listings and search need (name, tags, source) and leaves understanding the rest to
//! `burnish-material`. A file that does not follow the layout of its neighbours stops the build with its path.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::{env, fs};

const EXTENSION: &str = ".asm.ron";
/// The table of measurements, which the crate reads itself.
const MEASURED: &str = "measured.txt";

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-changed=data");
    let root = PathBuf::from(env::var_os("CARGO_MANIFEST_DIR").expect("cargo sets CARGO_MANIFEST_DIR"));
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets OUT_DIR"));

    // Keyed by group and name: the order that `presets()` promises.
    let mut rows = BTreeMap::new();
    for folder in entries(&root.join("data")).into_iter().filter(|path| file_name(path) != MEASURED) {
        let group = file_name(&folder);
        for path in entries(&folder) {
            let Some(stem) = file_name(&path).strip_suffix(EXTENSION).map(str::to_owned) else {
                panic!("{}: expected a file name that ends with {EXTENSION}", path.display());
            };
            let text = fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
            let name = quoted(&text, "    \"name\": \"", "\",", &path);
            let tags = quoted(&text, "    \"tags\": [", "],", &path);
            let source = quoted(&text, "        \"source\": \"", "\",", &path);
            // The path is joined by the compiler, so the generated list holds nothing of this machine.
            let row = format!(
                "Preset {{ group: {group:?}, name: {name:?}, file_stem: {stem:?}, tags: &[{tags}], source: {source:?}, \
                 text: include_str!(concat!(env!(\"CARGO_MANIFEST_DIR\"), \"/data/{group}/{stem}{EXTENSION}\")) }},\n"
            );
            if rows.insert((group.clone(), name.to_owned()), row).is_some() {
                panic!("{}: another preset of this group has the name {name:?}", path.display());
            }
        }
    }

    let mut list = String::from("&[\n");
    for row in rows.values() {
        write!(list, "    {row}").expect("writing to a string does not fail");
    }
    list.push_str("]\n");
    fs::write(out.join("presets.rs"), list).expect("cargo gives a writable OUT_DIR");
}

/// Paths inside `folder`, without hidden files that editors leave behind.
fn entries(folder: &Path) -> Vec<PathBuf> {
    let read = fs::read_dir(folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
    let paths = read.map(|entry| entry.expect("a folder that could be opened can be read").path());
    paths.filter(|path| !file_name(path).starts_with('.')).collect()
}

fn file_name(path: &Path) -> String {
    path.file_name().expect("read_dir yields names").to_str().expect("preset files have plain names").to_owned()
}

/// What stands between `start` at the beginning of a line and `end` at its end. Escapes are refused: the text goes
/// into the list as it is.
fn quoted<'a>(text: &'a str, start: &str, end: &str, path: &Path) -> &'a str {
    let found = text.lines().find_map(|line| line.strip_prefix(start)?.strip_suffix(end));
    match found {
        Some(value) if !value.contains('\\') => value,
        _ => panic!("{}: expected a line {start}…{end} without escapes", path.display()),
    }
}
