//! The command line as scripts see it: exit codes, what goes to which stream, files written whole or not at all.

#![allow(clippy::unwrap_used)] // A helper that fails fails its test.

use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use tempfile::TempDir;

mod convert;
mod handing_out;
mod library;
mod measure;
mod openjd;
mod pictures;
mod release;
mod render;
mod shader;
mod thumbnails;
mod turntable;
mod usage;

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
