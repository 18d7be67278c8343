//! Do the crates know only what they may know? The README lists these invariants.

use std::fs;
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Lines of `[dependencies]` of a crate.
fn dependencies(package: &str) -> String {
    let text = fs::read_to_string(root().join(package).join("Cargo.toml")).expect("every crate has a manifest");
    let (_, rest) = text.split_once("[dependencies]").expect("every crate has dependencies");
    rest.split("\n[").next().unwrap_or_default().to_owned()
}

fn sources(package: &str) -> Vec<(PathBuf, String)> {
    let mut found = Vec::new();
    let mut folders = vec![root().join(package).join("src")];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).expect("the folder is part of the crate").flatten() {
            let path = entry.path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == "rs" || e == "wgsl") {
                let text = fs::read_to_string(&path).expect("sources are text");
                found.push((path, text));
            }
        }
    }
    found
}

#[test]
fn crates_depend_only_downwards() {
    let may_know = [
        ("material", &[][..]),
        ("assets", &[][..]),
        ("presets", &["burnish-material"][..]),
        ("renderer", &["burnish-material", "burnish-assets"][..]),
    ];
    for (package, allowed) in may_know {
        for line in dependencies(package).lines().filter(|line| line.starts_with("burnish")) {
            let name = line.split(['.', ' ']).next().unwrap_or_default();
            assert!(allowed.contains(&name), "{package} depends on {name}");
        }
    }
}

#[test]
fn windows_and_graphics_stay_where_they_belong() {
    for package in ["material", "assets", "presets", "renderer"] {
        let text = dependencies(package);
        for name in ["egui", "eframe", "rfd"] {
            assert!(!text.contains(name), "{package} depends on {name}");
        }
        assert!(package == "renderer" || !text.contains("wgpu"), "{package} depends on wgpu");
    }
}

#[test]
fn a_material_opens_no_files_and_starts_no_threads() {
    for (path, text) in sources("material") {
        for word in ["std::fs", "std::thread", "std::net", "File::open"] {
            assert!(!text.contains(word), "{}: {word}", path.display());
        }
    }
}

#[test]
fn unsafe_code_stays_in_two_places() {
    for package in ["material", "assets", "presets", "renderer", "app"] {
        for (path, text) in sources(package) {
            let name = path.strip_prefix(root().join("renderer/src")).unwrap_or(Path::new(""));
            let is_exempt =
                name.starts_with("lanes") || ["lanes.rs", "denoise/oidn.rs"].iter().any(|file| name == Path::new(file));
            assert!(is_exempt || !(text.contains("unsafe {") || text.contains("unsafe impl")), "{}", path.display());
        }
    }
}

#[test]
fn shader_twins_lie_beside_each_other() {
    let bsdf = root().join("renderer/src/bsdf");
    for entry in fs::read_dir(&bsdf).expect("the folder is part of the crate").flatten() {
        let path = entry.path();
        let stem = path.file_stem().and_then(|s| s.to_str()).unwrap_or_default().to_owned();
        let twin = match path.extension().and_then(|e| e.to_str()) {
            // What `lanes` and `vector` are to Rust: arithmetic that WGSL lacks.
            Some("wgsl") if stem == "numbers" => continue,
            // Makes the numbers that shaders read.
            Some("rs") if stem == "fill" => continue,
            // Pixels are explained by the path tracer alone.
            Some("rs") if stem == "parts" => continue,
            // Only the path tracer follows light from its source.
            Some("rs") if stem == "adjoint" => continue,
            Some("rs") if stem == "mod" => bsdf.join("bsdf.wgsl"),
            Some("rs") => path.with_extension("wgsl"),
            Some("wgsl") if stem == "bsdf" => bsdf.join("mod.rs"),
            Some("wgsl") => path.with_extension("rs"),
            _ => continue,
        };
        assert!(twin.exists(), "{} has no twin {}", path.display(), twin.display());
    }
}
