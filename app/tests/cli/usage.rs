//! Arguments, exit codes, and what cannot be used.

use super::{Place, SCENE};
use std::fs;
use std::process::Command;

#[test]
fn unusable_arguments_exit_with_2_and_one_line() {
    let place = Place::new();
    place.write("nan.asm.ron", "{\n\"properties\": {\n\"roughness\": NaN}}");
    place.write("broken.asm.ron", "{\"properties\": ");
    place.write("scenes/schema.json", "{\"schema\": \"other/7\"}");
    place.write("scenes/broken.json", "{\"schema\": ");
    place.write("scenes/fov.json", &SCENE.replace("\"fov_deg\": 40", "\"fov_deg\": \"wide\""));
    place.write("scenes/mesh.json", &SCENE.replace("quad.ply", "none.ply"));
    place.write("scenes/asm.json", &SCENE.replace("\"roughness\": 0.5", "\"roughness\": [1, 2]"));
    place.write("scenes/name.json", &SCENE.replace("\"material\": \"test\"", "\"material\": \"chalk\""));
    place.write("scenes/film.json", &SCENE.replace("\"width\": 24, \"height\": 16", "\"width\": 8192, \"height\": 8192"));
    fs::create_dir(place.path("folder.asm.ron")).unwrap();
    fs::File::create(place.path("huge.asm.ron")).unwrap().set_len((16 << 20) + 1).unwrap();
    place.write("scenes/plain.json", &SCENE.replace("\"test\"", "\"chalk\""));
    exr::prelude::write_rgb_file(place.path("other.exr"), 4, 8, |_, _| (0.5_f32, 0.5_f32, 0.5_f32)).unwrap();
    let nan = |x, y| if (x, y) == (3, 1) { f32::NAN } else { 0.5 };
    exr::prelude::write_rgb_file(place.path("nan.exr"), 8, 4, |x, y| (0.5_f32, nan(x, y), 0.5_f32)).unwrap();
    let cases: &[(&[&str], &[&str])] = &[
        (&["render"], &["--out"]),
        (&["shader", "red.asm.ron", "--out", "a.wgsl"], &["--lang"]),
        (&["shader", "red.asm.ron", "--lang", "cg", "--out", "a.cg"], &["wgsl, hlsl, glsl, msl, spirv or osl"]),
        (&["shader", "red.asm.ron", "--lang", "osl", "--out", "none/a.osl"], &["none/a.osl", "folder"]),
        (&["render", "red.asm.ron"], &["--out"]),
        (&["render", "--out", "a.png"], &["expected MATERIAL"]),
        (&["render", "red.asm.ron", "--out", "a.jpg"], &["a.jpg", ".png or .exr"]),
        (&["render", "red.asm.ron", "--out", "none/a.png"], &["none/a.png", "folder"]),
        (&["render", "nowhere.asm.ron", "--out", "a.png"], &["nowhere.asm.ron"]),
        (&["render", "nan.asm.ron", "--out", "a.png"], &["nan.asm.ron", "line 3", "roughness"]),
        (&["render", "broken.asm.ron", "--out", "a.png"], &["broken.asm.ron", "line 1"]),
        (&["render", "folder.asm.ron", "--out", "a.png"], &["folder.asm.ron", "expected a file, found a folder"]),
        (&["render", "huge.asm.ron", "--out", "a.png"], &["huge.asm.ron", "at most 16777216 bytes"]),
        (&["render", "--scene", "scenes", "--out", "a.png"], &["scenes", "expected a file, found a folder"]),
        (&["render", "--scene", "scenes/film.json", "--out", "a.png"], &["film.json", "film.width", "16777216"]),
        (&["render", "preset:no such thing", "--out", "a.png"], &["presets list"]),
        (&["render", "chair.gltf", "--out", "a.png"], &["chair.gltf", "cannot be read"]),
        (&["render", "old.exr", "--out", "a.png"], &["old.exr", "cannot be read"]),
        (&["render", "env/grey.exr", "--out", "a.png"], &["grey.exr", "expected a material, or a picture"]),
        (&["render", "env/grey.exr", "--spp", "1", "--out", "a.png"], &["grey.exr", "expected a material, or a picture"]),
        (&["render", "red.asm.ron", "--bits", "12", "--out", "a.png"], &["--bits", "8 or 16"]),
        (&["render", "red.asm.ron", "--denoise=blur", "--out", "a.png"], &["--denoise", "auto, burnish or oidn"]),
        (&["render", "red.asm.ron", "--material", "2", "--out", "a.png"], &["--material", "from 1 to 1 of red.asm.ron"]),
        (&["render", "--scene", "scenes/quad.json", "--material", "2", "--out", "a.png"], &["--material 2", "several materials"]),
        (&["convert", "red.asm.ron", "a.glb", "--model", "open_pbr"], &["--model", "expected gltf for .glb"]),
        (&["convert", "red.asm.ron", "a.mdl", "--model", "open_pbr"], &["--model", "expected no model for .mdl"]),
        (&["convert", "env", "a.asm.ron"], &["env", "wood_BaseColor.png"]),
        (&["render", "red.asm.ron", "--set", "roughnes=1", "--out", "a.png"], &["did you mean `roughness`"]),
        (&["render", "red.asm.ron", "--set", "roughness=rough", "--out", "a.png"], &["roughness", "a finite number", "rough"]),
        (&["render", "red.asm.ron", "--set", "baseColor=1", "--out", "a.png"], &["base_color", "r,g,b"]),
        (&["render", "red.asm.ron", "--mesh", "spher", "--out", "a.png"], &["--mesh", "sphere"]),
        (&["render", "red.asm.ron", "--environment", "none.hdr", "--out", "a.png"], &["none.hdr"]),
        (&["render", "red.asm.ron", "--size", "5", "--out", "a.png"], &["--size", "WIDTHxHEIGHT"]),
        (&["render", "red.asm.ron", "--size", "8192x8193", "--out", "a.png"], &["--size", "67108864 (2^26)"]),
        (&["render", "red.asm.ron", "--size", "4096x4097", "--aov", "albedo", "--out", "a.png"], &["--size", "16777216 (2^24)"]),
        (&["parity", "red.asm.ron", "--size", "4096x4097"], &["--size", "16777216 (2^24)"]),
        (&["render", "red.asm.ron", "--camera", "0,0,1e39", "--out", "a.png"], &["--camera", "distance 1e-15 to 1e15"]),
        (&["render", "red.asm.ron", "--camera", "0,1e300,1", "--out", "a.png"], &["--camera", "AZIMUTH,ELEVATION,DISTANCE"]),
        (&["render", "red.asm.ron", "--fov", "-1", "--out", "a.png"], &["--fov", "0.1 to 179 degrees"]),
        (&["render", "red.asm.ron", "--seed", "-1", "--out", "a.png"], &["--seed", "whole number"]),
        (&["render", "red.asm.ron", "--threads", "-1", "--out", "a.png"], &["--threads", "whole number, 1 to"]),
        (&["render", "red.asm.ron", "--error", "-1", "--out", "a.png"], &["--error", "relMSE above 0"]),
        (&["render", "red.asm.ron", "--camera", "1,2", "--out", "a.png"], &["AZIMUTH,ELEVATION,DISTANCE"]),
        (&["render", "red.asm.ron", "--spp", "0", "--out", "a.png"], &["--spp"]),
        (&["render", "red.asm.ron", "--error", "0%", "--out", "a.png"], &["--error", "relMSE"]),
        (&["render", "red.asm.ron", "--threads", "0", "--out", "a.png"], &["--threads", "whole number"]),
        (&["render", "red.asm.ron", "--aov", "albedo,smell", "--out", "a.png"], &["--aov", "albedo, normal, depth"]),
        (&["render", "red.asm.ron", "--display-transform", "film", "--out", "a.png"], &["neutral, agx, aces or standard"]),
        (&["render", "--scene", "none.json", "--out", "a.png"], &["none.json"]),
        (&["render", "--scene", "scenes/broken.json", "--out", "a.png"], &["broken.json", "line 1"]),
        (&["render", "--scene", "scenes/schema.json", "--out", "a.png"], &["schema.json", "schema", "asm-bench-scene/1"]),
        (&["render", "--scene", "scenes/fov.json", "--out", "a.png"], &["fov.json", "camera.fov_deg", "degrees", "wide"]),
        (&["render", "--scene", "scenes/mesh.json", "--out", "a.png"], &["mesh.json", "objects[0].mesh", "none.ply"]),
        (&["render", "--scene", "scenes/asm.json", "--out", "a.png"], &["materials.test.asm.roughness", "a number"]),
        (&["render", "--scene", "scenes/name.json", "--out", "a.png"], &["objects[0].material", "chalk"]),
        (&["render", "red.asm.ron", "--scene", "scenes/plain.json", "--out", "a.png"], &["plain.json", "`test`"]),
        (&["render", "--scene", "scenes/quad.json", "--mesh", "sphere", "--out", "a.png"], &["--mesh", "--scene"]),
        (&["turntable", "red.asm.ron"], &["--out"]),
        (&["turntable", "red.asm.ron", "--out", "t"], &["--frames"]),
        (&["turntable", "red.asm.ron", "--out", "t", "--frames", "0"], &["--frames"]),
        (&["turntable", "red.asm.ron", "--out", "red.asm.ron", "--frames", "2"], &["--out", "red.asm.ron"]),
        (&["turntable", "red.asm.ron", "--out", "t", "--frames", "2", "--shard", "3/2"], &["--shard", "K from 1 to N"]),
        (&["turntable", "red.asm.ron", "--out", "t", "--frames", "2", "--turn", "camera"], &["object or light"]),
        (&["converge", "red.asm.ron"], &["--out"]),
        (&["converge", "--json"], &["expected MATERIAL"]),
        (&["converge", "red.asm.ron", "--out", "a.txt"], &["--out", "a.txt", ".json, .csv or .html"]),
        (&["converge", "red.asm.ron", "--out", "none/a.csv"], &["none/a.csv", "folder"]),
        (&["converge", "red.asm.ron", "--json", "--seconds", "-1"], &["--seconds", "above 0"]),
        (&["converge", "red.asm.ron", "--json", "--spp-max", "0"], &["--spp-max"]),
        (&["converge", "red.asm.ron", "--json", "--reference", "none.exr"], &["--reference", "none.exr"]),
        (&["converge", "red.asm.ron", "--json", "--reference", "env/grey.exr"], &["grey.exr", "512 x 512", "8 x 4"]),
        (&["converge", "red.asm.ron", "--json", "--reference", "a.exr", "--reference-spp", "4"], &["--reference-spp"]),
        (&["compare", "env/grey.exr"], &["<B>"]),
        (&["compare", "env/grey.exr", "none.exr"], &["none.exr"]),
        (&["compare", "env/grey.exr", "red.asm.ron"], &["red.asm.ron", "expected"]),
        (&["compare", "env/grey.exr", "other.exr"], &["other.exr", "expected 8 x 4", "env/grey.exr", "found 4 x 8"]),
        (&["compare", "env/grey.exr", "nan.exr"], &["nan.exr", "finite", "column 3 of row 1"]),
        (&["compare", "env/grey.exr", "env/grey.exr", "--limit", "speed=1"], &["--limit", "relmse, relmse_trimmed, flip_mean"]),
        (&["compare", "env/grey.exr", "env/grey.exr", "--limit", "flip_mean=x"], &["--limit", "flip_mean", "`x`"]),
        (&["compare", "env/grey.exr", "env/grey.exr", "--heatmap", "a.exr"], &["--heatmap", "a.exr", ".png"]),
        (&["compare", "env/grey.exr", "env/grey.exr", "--heatmap", "none/a.png"], &["none/a.png", "folder"]),
        (&["presets"], &["--help"]),
        (&["presets", "show", "no such thing"], &["no such thing", "presets list"]),
        (&["check"], &["PATH"]),
        (&["check", "nowhere"], &["nowhere"]),
        (&["check", "meshes"], &["meshes", "found none"]),
        (&["library", "check", "nowhere"], &["nowhere"]),
        (&["library", "sheet", "nowhere"], &["nowhere"]),
        (&["library", "sheet", "meshes"], &["meshes", "found none"]),
        (&["library", "pack", "meshes"], &["--out"]),
        (&["library", "pack", "meshes", "--out", "pack"], &["meshes", "found none"]),
        (&["library", "check", "meshes"], &["meshes", "found none"]),
        (&["diff", "red.asm.ron"], &["<B>"]),
        (&["diff", "red.asm.ron", "none.asm.ron"], &["none.asm.ron"]),
        (&["diff", "red.asm.ron", "red.asm.ron", "--image", "a.exr"], &["--image", "a.exr", ".png"]),
        (&["merge", "red.asm.ron", "red.asm.ron", "red.asm.ron"], &["--out"]),
        (&["merge", "red.asm.ron", "red.asm.ron", "red.asm.ron", "--out", "a.png"], &["--out", "a.png", ".asm.ron"]),
        (&["merge", "red.asm.ron", "red.asm.ron", "red.asm.ron", "--out=a.asm.ron", "--prefer=c"], &["--prefer", "a or b"]),
        (&["nowhere.asm.ron"], &["nowhere.asm.ron"]),
        (&["--frobnicate"], &["--frobnicate"]),
    ];
    let before = place.names();
    for (words, expected) in cases {
        let run = place.run(words);
        assert_eq!(run.code, Some(2), "{words:?}: {}", run.err);
        assert_eq!(run.out, "", "{words:?}");
        assert_eq!(run.err.lines().count(), 1, "{words:?}: {}", run.err);
        for text in *expected {
            assert!(run.err.contains(text), "{words:?}: expected `{text}` in: {}", run.err);
        }
    }
    assert_eq!(place.names(), before, "a failed run leaves no file");
}

#[test]
fn help_and_version_exit_with_0() {
    let place = Place::new();
    for words in [
        &["--help"][..],
        &["--version"],
        &["render", "--help"],
        &["converge", "--help"],
        &["compare", "--help"],
        &["presets", "--help"],
        &["check", "--help"],
        &["library", "check", "--help"],
        &["library", "sheet", "--help"],
        &["library", "pack", "--help"],
        &["diff", "--help"],
        &["merge", "--help"],
    ] {
        let run = place.run(words);
        assert_eq!((run.code, run.err.as_str()), (Some(0), ""), "{words:?}");
        assert!(!run.out.is_empty());
    }
}

#[cfg(unix)]
#[test]
fn pipes_and_devices_are_refused_instead_of_read() {
    let place = Place::new();
    // Where there is no `mkfifo`, the device still tells.
    let has_pipe = Command::new("mkfifo").arg(place.path("pipe")).status().is_ok_and(|status| status.success());
    for file in ["/dev/zero", "pipe"].into_iter().take(1 + usize::from(has_pipe)) {
        for words in [["render", file, "--out", "a.png"], ["render", "--scene", file, "--out=a.png"]] {
            let run = place.run(&words);
            assert_eq!(run.code, Some(2), "{words:?}: {}", run.err);
            assert!(run.err.contains("expected a file, found a pipe"), "{words:?}: {}", run.err);
        }
        let checked = place.run(&["check", file]);
        assert_eq!(checked.code, Some(1), "{}", checked.err);
        assert!(checked.out.contains("expected a file, found a pipe"), "{}", checked.out);
    }
}

#[test]
fn with_no_display_it_renders_a_picture_instead() {
    let place = Place::new();
    let run = place.run(&["env/grey.exr", "meshes/quad.ply", "red.asm.ron"]);
    assert_eq!(run.code, Some(0), "{}", run.err);
    assert!(run.err.contains("no display") && run.out.contains("burnish.png"), "{} {}", run.err, run.out);
    assert!(image::open(place.path("burnish.png")).unwrap().width() > 0);
    let run = place.run(&["--screenshot", "window.png"]);
    assert_eq!(run.code, Some(2), "{}", run.err);
}
