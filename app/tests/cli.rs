//! The command line as scripts see it: exit codes, what goes to which stream, files written whole or not at all.

#![allow(clippy::unwrap_used)] // A helper that fails fails its test.

use exr::meta::attribute::AttributeValue;
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use tempfile::TempDir;

/// What one run left.
struct Run {
    code: Option<i32>,
    out: String,
    err: String,
}

impl Run {
    fn json(&self) -> Value {
        serde_json::from_str(&self.out).unwrap_or_else(|error| panic!("one JSON object expected: {error}: {}", self.out))
    }
}

impl From<Output> for Run {
    fn from(output: Output) -> Self {
        let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
        Self { code: output.status.code(), out: text(output.stdout), err: text(output.stderr) }
    }
}

/// A folder with a tiny scene and materials, in which the program runs without a display.
struct Place {
    folder: TempDir,
}

impl Place {
    fn new() -> Self {
        let place = Self { folder: tempfile::tempdir().unwrap() };
        for folder in ["scenes", "meshes", "env"] {
            fs::create_dir(place.path(folder)).unwrap();
        }
        fs::write(place.path("meshes/quad.ply"), quad()).unwrap();
        exr::prelude::write_rgb_file(place.path("env/grey.exr"), 8, 4, |_, y| (0.5_f32, 0.5_f32, 0.2 * y as f32)).unwrap();
        place.write("scenes/quad.json", SCENE);
        place.write("red.asm.ron", "{\"asm\": \"4.0\", \"properties\": {\"base_color\": (0.8, 0.1, 0.1)}}");
        place
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn write(&self, name: &str, text: &str) {
        if let Some(folder) = self.path(name).parent() {
            fs::create_dir_all(folder).unwrap();
        }
        fs::write(self.path(name), text).unwrap();
    }

    fn command(&self) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_burnish"));
        command.current_dir(self.folder.path()).env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY");
        command
    }

    fn run(&self, words: &[&str]) -> Run {
        self.command().args(words).output().unwrap().into()
    }

    /// Runs `render` on the tiny scene with these words.
    fn render(&self, words: &[&str]) -> Run {
        let scene = ["render", "--scene", "scenes/quad.json", "--size", "32x32"];
        self.run(&[&scene[..], words].concat())
    }

    fn names(&self) -> Vec<String> {
        let mut names: Vec<_> =
            fs::read_dir(self.folder.path()).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }
}

/// A quad of 2 by 2 that faces +Z, as binary little-endian PLY.
fn quad() -> Vec<u8> {
    let head = "ply\nformat binary_little_endian 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
                property float nx\nproperty float ny\nproperty float nz\nproperty float u\nproperty float v\n\
                element face 2\nproperty list uchar int vertex_indices\nend_header\n";
    let mut bytes = head.as_bytes().to_vec();
    for (x, y) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0_f32)] {
        let vertex: [f32; 8] = [x, y, 0.0, 0.0, 0.0, 1.0, 0.5 + 0.5 * x, 0.5 - 0.5 * y];
        bytes.extend(vertex.iter().flat_map(|x| x.to_le_bytes()));
    }
    for face in [[0, 1, 2], [0, 2, 3_i32]] {
        bytes.push(3);
        bytes.extend(face.iter().flat_map(|i| i.to_le_bytes()));
    }
    bytes
}

const SCENE: &str = r#"{
    "schema": "asm-bench-scene/1",
    "camera": { "type": "pinhole", "origin": [0, 0, 5], "target": [0, 0, 0], "up": [0, 1, 0], "fov_deg": 40 },
    "film": { "width": 24, "height": 16, "filter": "box", "filter_width_px": 1.0 },
    "integrator": { "max_bounces": 3, "clamp": null },
    "environment": { "file": "env/grey.exr", "mapping": "latlong_yup_center_plus_z", "scale": 1.5 },
    "objects": [{ "mesh": "meshes/quad.ply", "material": "test" }],
    "materials": { "test": { "asm": { "baseColor": [0.2, 0.4, 0.6], "roughness": 0.5 } } }
}"#;

fn pixels(path: &Path) -> Vec<[f32; 3]> {
    let image = exr::prelude::read_first_rgba_layer_from_file(
        path,
        |size, _| vec![vec![[0.0; 3]; size.width()]; size.height()],
        |rows, at, (r, g, b, _): (f32, f32, f32, f32)| rows[at.y()][at.x()] = [r, g, b],
    );
    image.unwrap().layer_data.channel_data.pixels.concat()
}

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
        (&["render", "chair.gltf", "--out", "a.png"], &["chair.gltf", "not in this version"]),
        (&["render", "old.exr", "--out", "a.png"], &["old.exr", "not in this version"]),
        (&["render", "red.asm.ron", "--denoise=blur", "--out", "a.png"], &["--denoise", "auto, burnish or oidn"]),
        (&["render", "red.asm.ron", "--material", "2", "--out", "a.png"], &["--material", "not in this version"]),
        (&["render", "red.asm.ron", "--set", "roughnes=1", "--out", "a.png"], &["did you mean `roughness`"]),
        (&["render", "red.asm.ron", "--set", "roughness=rough", "--out", "a.png"], &["roughness", "a finite number", "rough"]),
        (&["render", "red.asm.ron", "--set", "baseColor=1", "--out", "a.png"], &["base_color", "r,g,b"]),
        (&["render", "red.asm.ron", "--mesh", "spher", "--out", "a.png"], &["--mesh", "sphere"]),
        (&["render", "red.asm.ron", "--environment", "none.hdr", "--out", "a.png"], &["none.hdr"]),
        (&["render", "red.asm.ron", "--size", "5", "--out", "a.png"], &["--size", "WIDTHxHEIGHT"]),
        (&["render", "red.asm.ron", "--size", "4096x4097", "--out", "a.png"], &["--size", "16777216 (2^24)"]),
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
        (&["turntable", "red.asm.ron"], &["turntable", "not in this version"]),
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
    ] {
        let run = place.run(words);
        assert_eq!((run.code, run.err.as_str()), (Some(0), ""), "{words:?}");
        assert!(!run.out.is_empty());
    }
}

#[test]
fn render_json_is_one_object_with_the_promised_fields() {
    let place = Place::new();
    let run = place.render(&["--spp", "4", "--out", "a.png", "--json"]);
    assert_eq!(run.code, Some(0), "{}", run.err);
    assert_eq!(run.err, "");
    let json = run.json();
    for key in [
        "out",
        "width",
        "height",
        "spp",
        "seconds",
        "load_seconds",
        "first_image_seconds",
        "stop_reason",
        "relmse_estimate",
        "relmse_low",
        "relmse_high",
        "samples_per_second",
        "threads",
        "seed",
        "lobes",
        "left_out",
        "peak_memory_bytes",
        "nonfinite_samples",
    ] {
        assert!(json.get(key).is_some(), "{key}: {json}");
    }
    assert_eq!((&json["width"], &json["height"], &json["spp"]), (&32.into(), &32.into(), &4.into()));
    assert_eq!((&json["stop_reason"], &json["nonfinite_samples"], &json["seed"]), (&"spp".into(), &0.into(), &0.into()));
    assert!(json["lobes"].as_array().unwrap().contains(&"diffuse".into()), "{json}");
    assert!(json["left_out"].as_array().unwrap().contains(&"coat".into()), "{json}");
    let picture = image::open(place.path("a.png")).unwrap();
    assert_eq!((picture.width(), picture.height()), (32, 32));
}

#[test]
fn text_tells_error_against_time() {
    let place = Place::new();
    let run = place.render(&["--spp", "8", "--out", "a.png"]);
    assert_eq!(run.code, Some(0), "{}", run.err);
    for text in ["a.png", "8 spp in ", " s, error ", " % (±", "stopped by spp"] {
        assert!(run.out.contains(text), "{text}: {}", run.out);
    }
}

#[test]
fn the_first_stop_rule_to_hit_wins() {
    let place = Place::new();
    let cases: &[(&[&str], &str)] = &[
        (&["--time", "0.2"], "time"),
        (&["--time", "100", "--spp", "2"], "spp"),
        (&["--error", "50%", "--time", "100"], "error"),
    ];
    for (words, reason) in cases {
        let json = place.render(&[words, &["--out", "a.exr", "--json"][..]].concat()).json();
        assert_eq!(json["stop_reason"], *reason, "{words:?}: {json}");
        // The picture itself says the same.
        let image = exr::prelude::read_first_flat_layer_from_file(place.path("a.exr")).unwrap();
        let Some(AttributeValue::Text(job)) = image.layer_data.attributes.other.get(&exr::prelude::Text::from("burnish")) else {
            panic!("the job is there")
        };
        let job: Value = serde_json::from_str(&job.to_string()).unwrap();
        for key in ["stop_reason", "spp", "relmse_estimate", "relmse_low", "relmse_high", "is_firefly_limited"] {
            assert_eq!(job.get(key), json.get(key), "{key}: {job} {json}");
        }
    }
}

#[test]
fn pictures_do_not_depend_on_threads_but_on_the_seed() {
    let place = Place::new();
    let file = |name: &str, words: &[&str]| {
        let run = place.render(&[words, &["--spp", "5", "--aov", "albedo,variance", "--out", name][..]].concat());
        assert_eq!(run.code, Some(0), "{}", run.err);
        fs::read(place.path(name)).unwrap()
    };
    for ending in ["exr", "png"] {
        let one = file(&format!("1.{ending}"), &["--threads", "1"]);
        assert!(one == file(&format!("2.{ending}"), &["--threads", "2"]), "{ending}: threads change the picture");
        assert!(one == file(&format!("3.{ending}"), &["--seed", "0"]), "{ending}: a run changes the picture");
    }
    assert!(file("4.exr", &["--seed", "1"]) != file("5.exr", &["--seed", "2"]), "the seed changes nothing");
}

#[test]
fn exr_holds_layers_and_png_has_them_beside_it() {
    let place = Place::new();
    let layers = ["--aov", "albedo,normal,depth,variance,samples,albedo", "--transparent", "--spp", "4"];
    assert_eq!(place.render(&[&layers[..], &["--out", "a.exr"]].concat()).code, Some(0));
    let image = exr::prelude::read_first_flat_layer_from_file(place.path("a.exr")).unwrap();
    let channels = &image.layer_data.channel_data.list;
    let names: Vec<String> = channels.iter().map(|channel| channel.name.to_string()).collect();
    for name in ["R", "G", "B", "A", "albedo.R", "normal.X", "depth.Z", "variance.B", "samples.V"] {
        assert!(names.iter().any(|known| known == name), "{name}: {names:?}");
    }
    let middle = |name: &str| {
        let channel = channels.iter().find(|channel| channel.name.to_string() == name).unwrap();
        channel.sample_data.values_as_f32().nth(32 * 16 + 16).unwrap()
    };
    assert!((middle("albedo.B") - 0.6).abs() < 0.05, "{}", middle("albedo.B"));
    assert!((middle("normal.Z") - 1.0).abs() < 1e-3 && (middle("depth.Z") - 5.0).abs() < 0.01);
    assert_eq!((middle("samples.V"), middle("A")), (4.0, 1.0));

    let json = place.render(&[&layers[..], &["--out", "b.png", "--json"]].concat()).json();
    assert_eq!(json["files"].as_array().unwrap().len(), 6);
    for name in ["b.png", "b.albedo.png", "b.normal.png", "b.depth.png", "b.variance.png", "b.samples.png"] {
        assert!(place.path(name).is_file(), "{name}");
    }
    let picture = image::open(place.path("b.png")).unwrap().to_rgba8();
    assert_eq!((picture.get_pixel(16, 16)[3], picture.get_pixel(0, 0)[3]), (255, 0));
}

#[test]
fn denoised_pictures_say_so_and_keep_the_raw_one() {
    let place = Place::new();
    let words = ["--denoise=burnish", "--spp", "8", "--json"];
    let render = |more: &[&str]| {
        let run = place.render(&[&words[..], more].concat());
        assert_eq!(run.code, Some(0), "{}", run.err);
        run.json()
    };
    let json = render(&["--out", "a.exr"]);
    assert_eq!(json["denoiser"], "burnish");
    let [low, relmse, high] =
        ["relmse_low_denoised", "relmse_estimate_denoised", "relmse_high_denoised"].map(|key| json[key].as_f64().unwrap());
    assert!(low <= relmse && relmse <= high, "{json}");
    let channel = |name: &str, channel: &str| -> Vec<f32> {
        let image = exr::prelude::read_first_flat_layer_from_file(place.path(name)).unwrap();
        let list = &image.layer_data.channel_data.list;
        let found = list.iter().find(|known| known.name.to_string() == channel);
        found.unwrap_or_else(|| panic!("{name}: no {channel}")).sample_data.values_as_f32().collect()
    };
    assert!(fs::read(place.path("a.exr")).unwrap().windows(20).any(|text| text == b"\"denoiser\":\"burnish\""[..20].as_ref()));
    // The raw layer is the picture without the option; the picture itself is another.
    assert_eq!(place.render(&["--spp", "8", "--out", "b.exr"]).code, Some(0));
    assert!(channel("a.exr", "raw.R") == channel("b.exr", "R") && channel("a.exr", "R") != channel("b.exr", "R"));

    let json = render(&["--transparent", "--threads", "2", "--out", "c.png"]);
    let files: Vec<&str> = json["files"].as_array().unwrap().iter().map(|file| file.as_str().unwrap()).collect();
    assert_eq!(files, ["c.png", "c.raw.png"]);
    assert_eq!(place.render(&["--transparent", "--spp", "8", "--out", "d.png"]).code, Some(0));
    let read = |name: &str| fs::read(place.path(name)).unwrap();
    assert!(read("c.raw.png") == read("d.png") && read("c.png") != read("d.png"));
    render(&["--transparent", "--threads", "1", "--out", "e.png"]);
    assert!(read("c.png") == read("e.png"), "threads change the denoised picture");

    // Too few samples, and a library that is not there, are told.
    let few = place.render(&["--denoise=burnish", "--spp", "3", "--json", "--out", "f.png"]);
    assert_eq!((few.code, &few.json()["denoiser"]), (Some(0), &Value::Null));
    assert!(few.err.contains("at least 4 samples") && !place.path("f.raw.png").exists(), "{}", few.err);
    let mut command = place.command();
    command.args([
        "render",
        "red.asm.ron",
        "--scene",
        "scenes/quad.json",
        "--denoise=oidn",
        "--spp",
        "4",
        "--out",
        "g.png",
        "--json",
    ]);
    let missing = Run::from(command.env("BURNISH_OIDN", "nowhere.so").output().unwrap());
    assert_eq!((missing.code, &missing.json()["denoiser"]), (Some(0), &"burnish".into()), "{}", missing.err);
    assert!(missing.err.contains("nowhere.so") && missing.err.contains("own filter"), "{}", missing.err);
}

#[test]
fn the_preview_needs_an_adapter_and_says_so() {
    let place = Place::new();
    let run = place.render(&["--view", "preview", "--spp", "2", "--out", "a.png", "--json"]);
    if run.code == Some(2) && std::env::var_os("BURNISH_REQUIRE_GPU").is_none() {
        assert!(run.err.contains("--view preview: ") && !place.path("a.png").exists(), "{}", run.err);
        eprintln!("skipped: {}", run.err);
        return;
    }
    assert_eq!(run.code, Some(0), "{}", run.err);
    assert_eq!((&run.json()["view"], &run.json()["relmse_estimate"]), (&"preview".into(), &Value::Null));
    let picture = image::open(place.path("a.png")).unwrap().to_rgb8();
    assert!(picture.get_pixel(16, 16) != picture.get_pixel(0, 0), "the quad differs from the background");
    for words in [&["--aov", "albedo"][..], &["--transparent"], &["--error", "1%"]] {
        let refused = place.render(&[words, &["--view", "preview", "--out", "b.png"]].concat());
        assert_eq!(refused.code, Some(2), "{words:?}");
        assert!(refused.err.contains("--view final"), "{}", refused.err);
    }
}

#[test]
fn scene_options_change_the_picture() {
    let place = Place::new();
    let mean = |words: &[&str]| {
        let run = place.render(&[words, &["--spp", "16", "--out", "a.exr"][..]].concat());
        assert_eq!(run.code, Some(0), "{words:?}: {}", run.err);
        let pixels = pixels(&place.path("a.exr"));
        pixels.iter().fold([0.0; 3], |sum, pixel| [0, 1, 2].map(|c| sum[c] + pixel[c] / pixels.len() as f32))
    };
    let plain = mean(&[]);
    for words in [
        &["red.asm.ron"][..],
        &["preset:gold, POLISHED"],
        &["--set", "baseColor=#ff0000"],
        &["--set", "base_color=0.9,0.9,0.9"],
        &["--set", "metallic=1", "--set", "roughness=0"],
        &["--environment", "white-furnace"],
        &["--environment", "env/grey.exr"],
        &["--camera", "40,10,3"],
        &["--fov", "80"],
        &["--set", "emission=3"],
    ] {
        assert!(mean(words) != plain, "{words:?} changes nothing");
    }
    // Exposure belongs to the display, so the radiance stays.
    assert_eq!(mean(&["--exposure", "2"]), plain);
    let size = place.run(&["render", "--scene", "scenes/quad.json", "--spp", "1", "--out", "a.png", "--json"]).json();
    assert_eq!((&size["width"], &size["height"]), (&24.into(), &16.into()), "the size of the film holds");
}

#[test]
fn warnings_are_told_and_do_not_stop() {
    let place = Place::new();
    place.write("odd.asm.ron", "{\"properties\": {\"velvet\": 1}}");
    place.write("scenes/odd.json", &SCENE.replace("\"roughness\": 0.5", "\"roughness\": 1.5, \"velvet\": 1"));
    for (words, text) in [
        (&["odd.asm.ron", "--scene", "scenes/quad.json"][..], "velvet"),
        (&["--scene", "scenes/odd.json"], "velvet"),
        (&["--scene", "scenes/odd.json"], "range 0 to 1"),
        (&["--scene", "scenes/quad.json", "--set", "roughness=7"], "range 0 to 1"),
    ] {
        let run = place.run(&[&["render"], words, &["--spp", "1", "--out", "a.png", "--json"]].concat());
        assert_eq!(run.code, Some(0), "{words:?}: {}", run.err);
        assert!(run.err.contains("warning: ") && run.err.contains(text), "{words:?}: {}", run.err);
        assert!(!run.json()["warnings"].as_array().unwrap().is_empty(), "{words:?}");
    }
}

#[test]
fn a_material_file_is_warned_about_once_each() {
    let place = Place::new();
    let texture = |path: &str| format!("{{\"texture\": {{\"path\": \"{path}\"}}}}");
    let cases = [
        ("1.5".to_owned(), "roughness: expected range 0 to 1, found 1.5"),
        (texture("none.png"), "none.png, found no file"),
        (texture("env"), "env, found a folder"),
        (texture("red.asm.ron"), "red.asm.ron, found a name without"),
        (texture(""), "roughness: has a texture without a path"),
    ];
    for (value, text) in cases {
        place.write("odd.asm.ron", &format!("{{\"asm\": \"4.0\", \"properties\": {{\"roughness\": {value}}}}}"));
        let run = place.render(&["odd.asm.ron", "--spp", "1", "--out", "a.png", "--json"]);
        assert_eq!(run.code, Some(0), "{value}: {}", run.err);
        let json = run.json();
        let warnings: Vec<_> = json["warnings"].as_array().unwrap().iter().filter_map(Value::as_str).collect();
        assert!(matches!(warnings[..], [only] if only.starts_with("odd.asm.ron: ") && only.contains(text)), "{warnings:?}");
        assert_eq!(run.err.lines().count(), 1, "{}", run.err);

        let rows = place.run(&["check", "odd.asm.ron", "--json"]).json();
        assert_eq!((&rows["errors"], &rows["warnings"]), (&0.into(), &1.into()), "{rows}");
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
fn presets_are_listed_shown_and_searched() {
    let place = Place::new();
    let all = place.run(&["presets", "list", "--json"]).json();
    let all = all["presets"].as_array().unwrap();
    assert!(all.len() >= 10);
    for row in all {
        for key in ["name", "group", "source"] {
            assert!(row[key].as_str().is_some_and(|text| !text.is_empty()), "{key}: {row}");
        }
    }
    let text = place.run(&["presets", "list"]).out;
    let name = all[0]["name"].as_str().unwrap();
    assert!(text.lines().any(|line| line.trim() == name));

    for words in [["presets", "show", name], ["presets", "show", &format!("preset:{}", name.to_uppercase())]] {
        let shown = place.run(&words);
        assert_eq!(shown.code, Some(0), "{}", shown.err);
        assert!(shown.out.contains("\"properties\""), "{}", shown.out);
    }
    let shown = place.run(&["presets", "show", name, "--json"]).json();
    assert_eq!(shown["presets"][0]["name"], name);

    let found = place.run(&["presets", "search", "gold", "--json"]).json();
    let found = found["presets"].as_array().unwrap();
    assert!(!found.is_empty() && found.len() < all.len());
    let none = place.run(&["presets", "search", "zzzz", "--json"]);
    assert_eq!((none.code, none.json()["presets"].as_array().unwrap().len()), (Some(0), 0));
}

#[test]
fn check_tells_errors_from_warnings() {
    let place = Place::new();
    place.write("lib/good.asm.ron", "{\"asm\": \"4.0\", \"properties\": {\"roughness\": 0.5}}");
    place.write("lib/readme.txt", "not a material");
    let good = place.run(&["check", "lib", "--json"]);
    assert_eq!(good.code, Some(0), "{}", good.err);
    let json = good.json();
    assert_eq!((&json["files"], &json["errors"], &json["warnings"]), (&1.into(), &0.into(), &0.into()), "{json}");

    place.write("lib/deep/er/range.asm.ron", "{\"properties\": {\"roughness\": 1.5}}");
    let warned = place.run(&["check", "lib", "--json"]);
    assert_eq!(warned.code, Some(0), "{}", warned.out);
    assert_eq!(warned.json()["files"], 2);
    assert!(warned.json()["warnings"].as_u64().unwrap() >= 1);
    assert_eq!(place.run(&["check", "lib", "--strict"]).code, Some(1));

    place.write("lib/nan.asm.ron", "{\n\n\"properties\": {\"roughness\": NaN}}");
    place.write("lib/broken.asm.ron", "{\"properties\": ");
    fs::write(place.path("lib/binary.asm.ron"), [0xff, 0xfe, 0x00, 0x80]).unwrap();
    place.write("lib/texture.asm.ron", "{\"properties\": {\"roughness\": {\"texture\": {\"path\": \"none.png\"}}}}");
    let failed = place.run(&["check", "lib", "--json"]);
    assert_eq!((failed.code, failed.err.as_str()), (Some(1), ""));
    let json = failed.json();
    assert_eq!((&json["files"], &json["errors"]), (&6.into(), &3.into()), "{json}");
    let rows = json["rows"].as_array().unwrap();
    assert!(
        rows.iter().any(|row| row["severity"] == "warning" && row["message"].as_str().unwrap().contains("none.png")),
        "{json}"
    );
    let nan =
        rows.iter().find(|row| row["severity"] == "error" && row["file"].as_str().unwrap().ends_with("nan.asm.ron")).unwrap();
    assert_eq!((&nan["severity"], &nan["line"]), (&"error".into(), &3.into()), "{nan}");
    assert!(nan["key"].as_str().unwrap().contains("roughness"), "{nan}");

    let text = place.run(&["check", "lib"]);
    assert_eq!(text.code, Some(1));
    assert!(text.out.contains("nan.asm.ron:3: error: "), "{}", text.out);
    assert!(text.out.trim_end().lines().last().unwrap().starts_with("6 files, 3 errors, "), "{}", text.out);
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

#[cfg(unix)]
#[test]
fn an_interrupted_render_exits_with_130_and_leaves_nothing() {
    let place = Place::new();
    let before = place.names();
    let mut child = place
        .command()
        .args(["render", "--scene", "scenes/quad.json", "--time", "600", "--out", "a.png", "--json"])
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    // Long enough to be inside the render on a slow machine; the outcome is the same if it is not.
    std::thread::sleep(std::time::Duration::from_millis(1500));
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    let code = child.wait().unwrap().code();
    let run: Run = child.wait_with_output().unwrap().into();
    assert_eq!((code, run.out.as_str()), (Some(130), ""), "{}", run.err);
    assert_eq!(place.names(), before);
}

#[test]
fn stability_probes_materials_and_what_their_images_reach() {
    let place = Place::new();
    let run = place.run(&["stability", "red.asm.ron", "--mesh", "sphere", "--json"]);
    assert_eq!(run.code, Some(0), "{}{}", run.out, run.err);
    let json = run.json();
    let cases = json["cases"].as_array().unwrap();
    assert!(cases.len() > 2 && json["failed"] == 0, "{json}");
    assert_eq!(cases[0]["name"], "red.asm.ron");
    for case in cases {
        assert!(case["holds"].is_boolean() && case["worst"].is_string() && case["seconds"].is_number(), "{case}");
        assert!(case["numbers"]["time_ratio"].is_number() && case["numbers"]["nonfinite"].is_number(), "{case}");
    }
    let text = place.run(&["stability", "--scene", "scenes/quad.json", "--threads", "1"]);
    assert_eq!(text.code, Some(0), "{}{}", text.out, text.err);
    assert!(text.out.contains("holds") && text.out.ends_with("0 do not hold\n"), "{}", text.out);

    let missing = place.run(&["stability", "nowhere.asm.ron", "--json"]);
    assert_eq!((missing.code, missing.out.as_str()), (Some(2), ""));
    assert_eq!(missing.err.lines().count(), 1);
}

#[test]
fn features_names_what_switches_each_lobe_and_measures() {
    let place = Place::new();
    let words = ["features", "red.asm.ron", "--mesh", "sphere", "--environment", "studio", "--size", "48x48", "--json"];
    let run = place.run(&words);
    assert_eq!(run.code, Some(0), "{}", run.err);
    let json = run.json();
    let lobes = json["lobes"].as_array().unwrap();
    let named = |name: &str| lobes.iter().find(|lobe| lobe["name"] == name).unwrap();
    assert_eq!(named("coat")["in"], false);
    assert!(named("coat")["reason"].as_str().unwrap().contains("coat is 0"), "{json}");
    assert!(named("coat")["final_ratio"].is_number(), "{json}");
    assert_eq!(named("diffuse")["in"], true);
    assert!(json["final_speedup"].as_f64().unwrap() > 0.0);
    assert!(json["z"].as_f64().unwrap() < 6.0, "{json}");
    // With an adapter there are numbers, without one a reason.
    let has_preview = json["preview_ms"].is_number() && json["preview_full_ms"].is_number() && json["compile_ms"].is_number();
    assert!(has_preview != json["preview_reason"].is_string(), "{json}");
}

#[test]
fn compare_tells_how_far_pictures_are_apart() {
    let place = Place::new();
    let write = |name: &str, value: f32| {
        exr::prelude::write_rgb_file(place.path(name), 96, 8, |_, _| (value, 0.5 * value, 0.25_f32)).unwrap();
    };
    write("a.exr", 0.5);
    write("b.exr", 0.4);
    let same = place.run(&["compare", "a.exr", "a.exr", "--limit", "relmse=0", "--limit", "flip_p99=0", "--json"]);
    assert_eq!((same.code, same.err.as_str()), (Some(0), ""));
    let json = same.json();
    for key in ["relmse", "relmse_trimmed", "flip_mean", "flip_p99"] {
        assert_eq!(json[key], 0.0, "{key}: {json}");
    }
    let json = place.run(&["compare", "a.exr", "b.exr", "--json", "--heatmap", "map.png"]).json();
    let number = |key: &str| json[key].as_f64().unwrap();
    let expected = (0.01 / (0.16 + 0.01) + 0.0025 / (0.04 + 0.01)) / 3.0;
    assert!((number("relmse") - expected).abs() < 1e-6 && (number("relmse_trimmed") - expected).abs() < 1e-6, "{json}");
    assert!(number("flip_mean") > 0.0 && (number("flip_mean") - number("flip_p99")).abs() < 1e-6, "{json}");
    assert!((number("mean_a") - (0.5 + 0.25 + 0.25) / 3.0).abs() < 1e-6, "{json}");
    assert!((number("mean_b") - (0.4 + 0.2 + 0.25) / 3.0).abs() < 1e-6, "{json}");
    let map = image::open(place.path("map.png")).unwrap();
    assert_eq!((map.width(), map.height()), (96, 8 + 16));

    let over = place.run(&["compare", "a.exr", "b.exr", "--limit", "relmse=1%", "--limit", "flip_mean=1"]);
    assert_eq!(over.code, Some(1), "{}", over.err);
    assert!(over.out.contains("relmse: ") && over.out.contains("is over 0.0001"), "{}", over.out);
    assert!(!over.out.contains("flip_mean: "), "{}", over.out);
    let json = place.run(&["compare", "a.exr", "b.exr", "--limit", "relmse=1%", "--limit", "flip_mean=1", "--json"]);
    assert_eq!(json.code, Some(1));
    assert_eq!((&json.json()["limits"][0]["holds"], &json.json()["limits"][1]["holds"]), (&false.into(), &true.into()));
}

#[test]
fn compare_takes_the_picture_of_a_file_with_layers_and_pictures_of_a_display() {
    let place = Place::new();
    for (name, words) in [("layers.exr", &["--aov", "albedo,normal,variance"][..]), ("plain.exr", &[]), ("plain.png", &[])] {
        assert_eq!(place.render(&[words, &["--spp", "4", "--out", name][..]].concat()).code, Some(0));
    }
    let json = place.run(&["compare", "layers.exr", "plain.exr", "--json"]).json();
    assert_eq!((&json["relmse"], &json["width"]), (&0.0.into(), &32.into()), "{json}");
    // What the display shows of radiance is what the PNG holds, up to the rounding of its bytes.
    let json = place.run(&["compare", "plain.exr", "plain.png", "--json"]).json();
    assert!(json["flip_mean"].as_f64().unwrap() < 0.02, "{json}");
    let shifted = place.run(&["compare", "plain.exr", "plain.png", "--exposure", "1", "--json"]).json();
    assert!(shifted["flip_mean"].as_f64().unwrap() > 0.05, "{shifted}");
}

#[test]
fn converge_writes_the_curve_in_three_formats() {
    let place = Place::new();
    let curve = |words: &[&str]| {
        let scene = ["converge", "--scene", "scenes/quad.json", "--size", "32x32", "--spp-max", "64", "--set", "roughness=0.2"];
        let run = place.run(&[&scene[..], words].concat());
        assert_eq!(run.code, Some(0), "{}", run.err);
        run
    };
    let run = curve(&["--out", "a.json", "--json"]);
    assert_eq!(run.err, "");
    assert_eq!(fs::read_to_string(place.path("a.json")).unwrap(), run.out, "the file holds what is printed");
    let json = run.json();
    let rows = json["rows"].as_array().unwrap();
    let spp: Vec<u64> = rows.iter().map(|row| row["spp"].as_u64().unwrap()).collect();
    assert_eq!(spp, [1, 4, 8, 16, 32, 64]);
    let values = |key: &str| rows.iter().map(|row| row[key].as_f64().unwrap_or(f64::NAN)).collect::<Vec<_>>();
    assert!(values("seconds").is_sorted() && values("seconds")[0] > 0.0, "{json}");
    let errors = values("relmse");
    assert!(errors[5] < 0.2 * errors[1] && errors[5] > 0.0, "{errors:?}");
    assert!(values("flip")[5] < values("flip")[0] && values("relmse_trimmed")[1] <= errors[1], "{json}");
    // The renderer's own estimate tells the same as the comparison; one sample has none.
    assert!(rows[0]["relmse_estimate"].is_null());
    let ratio = values("relmse_estimate")[5] / errors[5];
    assert!((0.5..2.0).contains(&ratio), "{ratio}: {json}");
    let reference = &json["reference"];
    assert_eq!((&reference["kind"], &reference["spp"], &reference["is_subtracted"]), (&"own".into(), &512.into(), &true.into()));
    assert!(reference["seed"] != json["seed"] && reference["relmse_of_reference"].as_f64().unwrap() < 0.3 * errors[5], "{json}");
    assert!(json["slope"].as_f64().unwrap() >= 0.8 && json["targets"][1]["relmse"] == 0.001, "{json}");

    let text = curve(&["--out", "a.csv", "--threads", "1"]).out;
    assert!(text.contains("relMSE 0.001: ") && text.contains("a.csv"), "{text}");
    let csv = fs::read_to_string(place.path("a.csv")).unwrap();
    assert_eq!(csv.lines().count(), 7);
    let fields = |line: &str| line.split(',').map(str::to_owned).collect::<Vec<_>>();
    let last = fields(csv.lines().last().unwrap());
    assert_eq!(fields(csv.lines().next().unwrap()).len(), last.len());
    let error: f64 = last[6].parse().unwrap();
    assert!(last[2] == "64" && (error / errors[5] - 1.0).abs() < 1e-12, "threads change nothing but seconds: {error} {errors:?}");

    curve(&["--out", "a.html"]);
    let html = fs::read_to_string(place.path("a.html")).unwrap();
    for text in
        ["<svg", "role=\"img\"", "<title id=", "<desc id=", "class=\"band\"", "<table>", "Slope", "prefers-color-scheme: dark"]
    {
        assert!(html.contains(text), "{text}");
    }
    for text in ["http:", "https:", "src=", "<link", "@import", "<script", "NaN", "inf"] {
        assert!(!html.contains(text), "{text}: the page needs nothing beside itself");
    }
    assert_eq!(html.matches("<tr>").count(), 7);
}

#[test]
fn converge_takes_a_reference_from_a_file() {
    let place = Place::new();
    let render = |name: &str, words: &[&str]| {
        assert_eq!(place.render(&[words, &["--spp", "256", "--out", name][..]].concat()).code, Some(0));
    };
    let curve = |reference: &str| {
        let words = ["converge", "--scene", "scenes/quad.json", "--size", "32x32", "--spp-max", "32", "--json"];
        let run = place.run(&[&words[..], &["--reference", reference]].concat());
        assert_eq!(run.code, Some(0), "{}", run.err);
        (run.json(), run.err)
    };
    render("with.exr", &["--seed", "9", "--aov", "variance"]);
    render("without.exr", &["--seed", "9"]);
    render("same.exr", &["--aov", "variance"]);
    let last = |json: &Value| json["rows"][4]["relmse"].as_f64().unwrap();
    let (with, err) = curve("with.exr");
    assert_eq!(err, "");
    let reference = &with["reference"];
    assert_eq!((&reference["kind"], &reference["seed"], &reference["spp"]), (&"file".into(), &9.into(), &256.into()), "{with}");
    let (without, err) = curve("without.exr");
    assert!(err.contains("without.exr") && err.contains("variance"), "{err}");
    assert_eq!(without["reference"]["is_subtracted"], false);
    assert!(last(&with) < last(&without), "the noise of the reference is taken off");
    let (same, err) = curve("same.exr");
    assert!(err.contains("same.exr") && err.contains("seed 0"), "{err}");
    assert!(last(&same) < last(&with));
}

#[cfg(unix)]
#[test]
fn an_interrupted_curve_exits_with_130_and_leaves_nothing() {
    let place = Place::new();
    let before = place.names();
    let words = ["converge", "--scene", "scenes/quad.json", "--seconds", "600", "--out", "a.html"];
    let mut command = place.command();
    let command = command.args(words).stdout(std::process::Stdio::piped()).stderr(std::process::Stdio::piped());
    let mut child = command.spawn().unwrap();
    std::thread::sleep(std::time::Duration::from_millis(1500));
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    let code = child.wait().unwrap().code();
    let run: Run = child.wait_with_output().unwrap().into();
    assert_eq!((code, run.out.as_str()), (Some(130), ""), "{}", run.err);
    assert_eq!(place.names(), before);
}
