//! Targets for fuzzing, one per reader of files: each takes bytes, reads them, and holds what was read against what every reader promises.
//!
//! `cargo +nightly fuzz run -s none NAME FOLDER fuzz/corpus/NAME -- -max_len=65536` in `tests` looks for inputs that break a promise, and puts
//! new ones into FOLDER; `tests/tests/corpus.rs` replays the corpus and mutates it a little.

use std::path::Path;

use burnish_assets::{Mesh, decode_image, decode_model};
use burnish_material::exchange::model::Context;
use burnish_material::exchange::{filament as mat, gltf as khr, materialx as mtlx, mdl as nv, models, texture_set as set, usd};
use burnish_material::{LimitKind, Material, MaterialFile, PROPERTIES, Slot, TextureRef};

/// What a target is: the name of its folder in the corpus, and its function.
pub type Target = (&'static str, fn(&[u8]));

/// All targets.
pub const TARGETS: &[Target] = &[
    ("native", native),
    ("gltf", gltf),
    ("materialx", materialx),
    ("usda", usda),
    ("usdz", usdz),
    ("mdl", mdl),
    ("filament", filament),
    ("texture_set", texture_set),
    ("mesh", mesh),
    ("image", image),
];

/// Materials of one file that are looked at; others are the same again.
const MOST: usize = 3;
/// Longest sentence about a file, in bytes.
const SENTENCE: usize = 2000;

/// Material files.
pub fn native(bytes: &[u8]) {
    let Some(text) = text(bytes) else { return };
    let (file, warnings) = match MaterialFile::parse(text) {
        Ok(read) => read,
        Err(error) => return sentence(&error.to_string()),
    };
    warnings.iter().for_each(|warning| sentence(&warning.to_string()));
    let material = file.material();
    assert_eq!(file.to_text(material), text, "an unedited file is written as the same bytes");
    check(material, true);
    // Every property edited: what is written is read back.
    let mut edited = material.clone();
    for def in PROPERTIES {
        let slot = edited.slot_mut(def.id);
        let value = slot.value.map_or(Some(def.default), |_| None);
        *slot = Slot { value, texture: slot.texture.clone().xor(Some(TextureRef::new("a.png"))) };
    }
    match MaterialFile::parse(&file.to_text(&edited)) {
        Ok((again, _)) => assert_eq!(*again.material(), edited),
        Err(error) => panic!("cannot read what was written: {error}"),
    }
}

/// glTF as text or as a binary file: its materials.
pub fn gltf(bytes: &[u8]) {
    let document = match khr::read(bytes) {
        Ok(document) => document,
        Err(error) => return sentence(&error.to_string()),
    };
    sentences(&document.notes);
    for found in document.materials.iter().take(MOST) {
        let (material, notes) = found.material();
        sentences(&notes);
        check(&material, found.native.is_some());
        for has_native_copy in [true, false] {
            let context = Context::of(&material);
            let translation = models::gltf::MODEL.translate(&material, &context);
            let part = khr::Part { material: &material, translation: &translation, context };
            let options = khr::Options { has_native_copy, ..khr::Options::default() };
            let written = match khr::write(&[part], None, &options) {
                Ok(written) => written,
                Err(error) => panic!("cannot write a material: {error}"),
            };
            let again = khr::read(written.gltf("mesh.bin").as_bytes()).map(|document| document.materials[0].material().0);
            assert!(again.is_ok(), "{again:?}");
            if has_native_copy {
                assert_eq!(again.as_ref(), Ok(&material));
            }
            match written.glb(|_| None).and_then(|bytes| khr::read(&bytes)) {
                Ok(document) => assert_eq!(Ok(document.materials[0].material().0), again),
                Err(error) => panic!("cannot read what was written: {error}"),
            }
        }
    }
}

/// Documents of MaterialX.
pub fn materialx(bytes: &[u8]) {
    let Some(text) = text(bytes) else { return };
    let all = match mtlx::read(text) {
        Ok(all) => all,
        Err(error) => return sentence(&error.to_string()),
    };
    for found in all.iter().take(MOST) {
        sentences(&found.notes);
        check(&found.material, found.is_native);
        for surface in mtlx::SURFACES {
            let options = mtlx::WriteOptions { surface: surface.model, ..mtlx::WriteOptions::default() };
            let written = mtlx::write(&[&found.material], &options).text;
            match mtlx::read(&written) {
                Ok(again) => assert_eq!(again[0].material, found.material),
                Err(error) => panic!("cannot read what was written: {error}"),
            }
        }
    }
}

/// Layers of USD as text: materials and meshes.
pub fn usda(bytes: &[u8]) {
    let scene = match usd::layer_text(bytes).and_then(usd::read) {
        Ok(scene) => scene,
        Err(error) => return sentence(&error.to_string()),
    };
    sentences(&scene.notes);
    let path_of = |texture: &TextureRef| texture.path.clone();
    let options = usd::Options { path_of: &path_of, image_folder: "", mesh: None, has_native_copy: true };
    for found in scene.materials.iter().take(MOST) {
        // The values of Adobe's own shader are those of ASM, wherever they lie.
        check(&found.material, found.is_native || found.network.starts_with("AdobeStandardMaterial"));
        let written = usd::write(&[&found.material], &options).text;
        match usd::read(&written) {
            Ok(again) => assert_eq!(again.materials[0].material, found.material),
            Err(error) => panic!("cannot read what was written: {error}"),
        }
    }
    let material = Material::named("M");
    for found in scene.meshes.iter().take(MOST) {
        let count = found.positions.len();
        let lengths = [found.normals.as_ref().map(Vec::len), found.uvs.as_ref().map(Vec::len)];
        assert!(lengths.iter().flatten().all(|length| *length == count));
        assert!(found.positions.as_flattened().iter().all(|x| x.is_finite()));
        assert!(found.triangles.as_flattened().iter().all(|corner| (*corner as usize) < count));
        let mut end = 0;
        for part in &found.parts {
            assert!(part.triangles.start == end && part.material.is_none_or(|place| place < scene.materials.len()));
            end = part.triangles.end;
        }
        assert_eq!(end, found.triangles.len());
        let arrays = usd::MeshArrays {
            name: "mesh",
            positions: &found.positions,
            normals: found.normals.as_deref().unwrap_or_default(),
            tangents: &[],
            uvs: found.uvs.as_deref().unwrap_or_default(),
            triangles: &found.triangles,
            parts: &[],
        };
        let options = usd::Options { path_of: &path_of, image_folder: "", mesh: Some(&arrays), has_native_copy: true };
        let again = usd::read(&usd::write(&[&material], &options).text);
        assert!(again.is_ok(), "{:?}", again.map(|scene| scene.notes));
    }
}

/// Packages of USD.
pub fn usdz(bytes: &[u8]) {
    let package = match usd::usdz::read(bytes) {
        Ok(package) => package,
        Err(error) => return sentence(&error.to_string()),
    };
    let files: Vec<(&str, &[u8])> = package.files().collect();
    assert!(files.iter().map(|(_, bytes)| bytes.len()).sum::<usize>() <= bytes.len(), "files share no bytes");
    match package.layer() {
        Ok(layer) => {
            usda(layer.as_bytes());
            let written = usd::usdz::write(files[0].0, layer, &files[1..]);
            match written.as_ref().map(|bytes| usd::usdz::read(bytes)) {
                Ok(Ok(again)) => assert!(again.files().eq(files)),
                other => panic!("cannot read what was written: {other:?}"),
            }
        }
        Err(error) => sentence(&error.to_string()),
    }
}

/// Modules of MDL.
pub fn mdl(bytes: &[u8]) {
    let Some(text) = text(bytes) else { return };
    let all = match nv::read(text) {
        Ok(all) => all,
        Err(error) => return sentence(&error.to_string()),
    };
    for found in all.iter().take(MOST) {
        sentences(&found.notes);
        check(&found.material, true);
        for flavour in [nv::Flavour::Adobe, nv::Flavour::Own] {
            let written = nv::write(&found.material, flavour, &|texture| Some(texture.path.clone()));
            match nv::read(&written) {
                Ok(again) => assert_eq!(again[0].material, found.material),
                Err(error) => panic!("cannot read what was written: {error}"),
            }
        }
    }
}

/// Material definitions of Filament.
pub fn filament(bytes: &[u8]) {
    let Some(text) = text(bytes) else { return };
    let found = match mat::read(text) {
        Ok(found) => found,
        Err(error) => return sentence(&error.to_string()),
    };
    sentences(&found.notes);
    check(&found.material, found.is_native);
    match mat::read(&mat::write(&found.material, &mat::WriteOptions::default()).text) {
        Ok(again) => assert_eq!(again.material, found.material),
        Err(error) => panic!("cannot read what was written: {error}"),
    }
}

/// What lies beside a texture set.
pub fn texture_set(bytes: &[u8]) {
    let Some(text) = text(bytes) else { return };
    let found = match set::copy::read(text) {
        Ok(found) => found,
        Err(error) => return sentence(&error.to_string()),
    };
    sentences(&found.notes);
    check(&found.material, true);
    let again = set::copy::read(&set::copy::write(&found.material, &found.images));
    assert_eq!(again.map(|again| (again.material, again.images)).ok(), Some((found.material, found.images)));
}

/// Meshes in glTF and PLY.
pub fn mesh(bytes: &[u8]) {
    // No such folder: buffers beside the document are not there.
    let path = Path::new(if bytes.starts_with(b"ply") { "nowhere/mesh.ply" } else { "nowhere/mesh.gltf" });
    let (model, warnings) = match decode_model(path, bytes) {
        Ok(read) => read,
        Err(error) => return sentence(&error.to_string()),
    };
    sentences(&warnings);
    for mesh in model.parts.iter().map(|part| &part.mesh) {
        check_mesh(mesh);
        let arrays = khr::Mesh {
            positions: &mesh.positions.iter().map(|p| p.to_array()).collect::<Vec<_>>(),
            normals: &mesh.normals.iter().map(|n| n.to_array()).collect::<Vec<_>>(),
            tangents: &mesh.tangents.iter().map(|t| t.to_array()).collect::<Vec<_>>(),
            uvs: &mesh.uvs.iter().map(|uv| uv.to_array()).collect::<Vec<_>>(),
            triangles: &mesh.triangles,
        };
        let written = khr::write(&[], Some(&arrays), &khr::Options::default()).and_then(|written| written.glb(|_| None));
        match written.map(|bytes| decode_model(Path::new("nowhere/mesh.glb"), &bytes)) {
            Ok(Ok((again, _))) => assert_eq!(again.parts[0].mesh.triangles.len(), mesh.triangles.len()),
            Ok(Err(error)) => panic!("cannot read what was written: {error}"),
            Err(error) => panic!("cannot write what was read: {error}"),
        }
    }
}

/// Images in PNG, JPEG, Radiance HDR and OpenEXR.
pub fn image(bytes: &[u8]) {
    let path = Path::new(if bytes.starts_with(&[0x76, 0x2f, 0x31, 0x01]) { "a.exr" } else { "a.png" });
    match decode_image(path, bytes) {
        Ok(image) => assert_eq!(image.texels.len(), image.width * image.height),
        Err(error) => sentence(&error.to_string()),
    }
}

/// Readers of text take text; whoever reads the file says so of others.
fn text(bytes: &[u8]) -> Option<&str> {
    std::str::from_utf8(bytes).ok()
}

/// What people are told is one line, and not too long.
fn sentence(text: &str) {
    assert!(!text.is_empty() && text.len() <= SENTENCE && !text.contains(['\n', '\r']), "{} bytes: {text:?}", text.len());
}

fn sentences(all: &[String]) {
    all.iter().for_each(|text| sentence(text));
}

/// All numbers are finite, those of a translation within the ranges that bind, and the program's own file holds the material.
fn check(material: &Material, may_leave_ranges: bool) {
    for def in PROPERTIES {
        let slot = material.slot(def.id);
        for x in slot.value.iter().flat_map(|value| value.numbers().to_vec()) {
            let is_inside = may_leave_ranges || def.limits.kind != LimitKind::Hard || def.limits.contains(x);
            assert!(x.is_finite() && is_inside, "{}: {x}", def.name);
        }
        if let Some(TextureRef { scale, bias, uv_scale, uv_offset, uv_rotation, .. }) = &slot.texture {
            let numbers = [scale.as_slice(), bias, uv_scale, uv_offset, &[*uv_rotation]].concat();
            assert!(numbers.iter().all(|x| x.is_finite()), "{}: {numbers:?}", def.name);
        }
    }
    assert_eq!(MaterialFile::new(material).material(), material);
}

fn check_mesh(mesh: &Mesh) {
    let count = mesh.positions.len();
    assert!([mesh.normals.len(), mesh.tangents.len(), mesh.uvs.len()].iter().all(|length| *length == count));
    assert!(mesh.triangles.as_flattened().iter().all(|corner| (*corner as usize) < count));
    assert!(mesh.positions.iter().all(|p| p.is_finite()) && mesh.uvs.iter().all(|uv| uv.is_finite()));
    assert!(mesh.normals.iter().all(|n| n.is_normalized()), "{:?}", mesh.normals);
    assert!(mesh.tangents.iter().all(|t| t.truncate().is_normalized() && t.w.abs() == 1.0), "{:?}", mesh.tangents);
}
