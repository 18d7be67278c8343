//! Do loaders of meshes read what the formats allow, and refuse the rest with a sentence?

use std::path::{Path, PathBuf};

use burnish_assets::{AssetError, Mesh, Model, Progress, Role, is_model_path, load_model, load_model_with};
use glam::{Vec2, Vec3};

/// A folder with files, gone with the test.
struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().expect("a temporary folder"))
    }

    fn write(&self, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
        let path = self.0.path().join(name);
        std::fs::write(&path, bytes).expect("a temporary file");
        path
    }
}

fn load(path: &Path) -> (Mesh, Vec<String>) {
    let (model, warnings) = load_model(path).unwrap_or_else(|error| panic!("{error}"));
    let Model { parts, .. } = model;
    assert!(parts.len() == 1 && parts[0].role == Role::Object);
    (parts.into_iter().next().expect("one part").mesh, warnings)
}

/// The message of a file that cannot be read; one sentence that names the file.
fn refusal(path: &Path) -> String {
    let message = match load_model(path) {
        Ok(_) => panic!("{} was read", path.display()),
        Err(error) => error.to_string(),
    };
    assert!(message.contains(&path.display().to_string()) && message.ends_with('.'), "{message}");
    assert!(!message.contains('\n'), "{message}");
    message
}

/// Everything that a renderer relies on.
fn assert_complete(mesh: &Mesh) {
    let count = mesh.positions.len();
    assert!([mesh.normals.len(), mesh.tangents.len(), mesh.uvs.len()] == [count; 3]);
    assert!(mesh.positions.iter().all(|p| p.is_finite()) && mesh.uvs.iter().all(|uv| uv.is_finite()));
    for (n, t) in mesh.normals.iter().zip(&mesh.tangents) {
        assert!((n.length() - 1.0).abs() < 1e-3 && (t.truncate().length() - 1.0).abs() < 1e-3, "{n} {t}");
        assert!(n.dot(t.truncate()).abs() < 1e-3 && t.w.abs() == 1.0, "{n} {t}");
    }
    assert!(!mesh.triangles.is_empty() && mesh.triangles.iter().flatten().all(|&i| (i as usize) < count));
}

/// Numbers that look random and are the same every time (xorshift).
struct Noise(u64);

impl Noise {
    fn below(&mut self, end: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 % end as u64) as usize
    }
}

/// Loads the file cut off at many places and with bytes changed: any answer will do, but there must be one.
fn fuzz(folder: &Folder, name: &str, whole: &[u8], tries: usize) {
    let mut noise = Noise(0x1234_5678_9abc_def1);
    for length in (0..whole.len()).step_by((whole.len() / 60).max(1)) {
        let _ = load_model(&folder.write(name, &whole[..length]));
    }
    for _ in 0..tries {
        let mut bytes = whole.to_vec();
        for _ in 0..=noise.below(3) {
            let at = noise.below(bytes.len());
            bytes[at] = match noise.below(4) {
                0 => bytes[at] ^ (1 << noise.below(8)),
                1 => 0xff,
                2 => b'9',
                _ => noise.below(256) as u8,
            };
        }
        if let Ok((model, _)) = load_model(&folder.write(name, &bytes)) {
            assert_complete(&model.parts[0].mesh);
        }
    }
}

const HEADER: &str =
    "property float x\nproperty float y\nproperty float z\nproperty uchar red\nproperty double s\nproperty double t\n";

/// A unit square facing +Z as one quad and one needless triangle of two corners, in binary PLY.
fn binary_ply(is_big: bool) -> Vec<u8> {
    let order = if is_big { "binary_big_endian" } else { "binary_little_endian" };
    let mut bytes = format!(
        "ply\r\nformat {order} 1.0\r\ncomment made here\r\nelement vertex 4\n{HEADER}element edge 1\nproperty list ushort short twist\n\
         element face 2\nproperty list uint8 int32 vertex_indices\nproperty uchar flag\nend_header\n"
    )
    .into_bytes();
    let mut put = |number: &[u8]| {
        let mut number = number.to_vec();
        if is_big {
            number.reverse();
        }
        bytes.extend(number);
    };
    for (x, y) in [(0.0_f32, 0.0_f32), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)] {
        [x, y, 0.0].iter().for_each(|c| put(&c.to_le_bytes()));
        put(&[200]);
        [f64::from(x), 1.0 - f64::from(y)].iter().for_each(|c| put(&c.to_le_bytes()));
    }
    put(&2_u16.to_le_bytes());
    [-1_i16, 7].iter().for_each(|c| put(&c.to_le_bytes()));
    for face in [&[0_i32, 1, 2, 3][..], &[0, 1]] {
        put(&[face.len() as u8]);
        face.iter().for_each(|c| put(&c.to_le_bytes()));
        put(&[1]);
    }
    bytes
}

fn text_ply(vertices: &str, faces: &str) -> String {
    format!(
        "ply\nformat ascii 1.0\nelement vertex {vertices}\n{HEADER}element face 1\nproperty list uchar int vertex_index\nend_header\n\
         0 0 0 1 0 1\n1 0 0 1 1 1\n1 1 0 1 1 0\n0 1 0 1 0 0\n{faces}"
    )
}

#[test]
fn ply_in_every_encoding() {
    let folder = Folder::new();
    let paths = [
        folder.write("little.ply", binary_ply(false)),
        folder.write("big.PLY", binary_ply(true)),
        folder.write("text.ply", text_ply("4", "4 0 1 2 3")),
    ];
    for path in paths {
        let (mesh, warnings) = load(&path);
        assert_complete(&mesh);
        assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3]]);
        assert_eq!(mesh.uvs[0], Vec2::new(0.0, 1.0));
        for (n, t) in mesh.normals.iter().zip(&mesh.tangents) {
            assert!(n.distance(Vec3::Z) < 1e-6 && t.distance(Vec3::X.extend(1.0)) < 1e-6, "{n} {t}");
        }
        let is_text = path.ends_with("text.ply");
        assert_eq!(warnings.is_empty(), is_text, "{warnings:?}");
    }
}

#[test]
fn ply_that_is_wrong() {
    let folder = Folder::new();
    let check = |text: &str, expected: &str| {
        let message = refusal(&folder.write("bad.ply", text));
        assert!(message.contains(expected), "{message}");
    };
    check("", "header line 1");
    check("plx\n", "expected \"ply\"");
    check("ply\nformat ascii 1.0\n", "end_header");
    check("ply\nend_header\n", "format");
    check("ply\nformat middle_endian 1.0\nend_header\n", "middle_endian");
    check("ply\nformat ascii 1.0\nproperty int x\nend_header\n", "an element before");
    check("ply\nformat ascii 1.0\nelement vertex -3\nend_header\n", "-3");
    check("ply\nformat ascii 1.0\nend_header\n", "vertices");
    check(&text_ply("4000000000", "3 0 1 2"), "4000000000 records");
    check(&text_ply("18446744073709551615", "3 0 1 2"), "records");
    check(&text_ply("4", "3 0 1 4"), "found 4");
    check(&text_ply("4", "3 0 1 -1"), "found -1");
    check(&text_ply("4", "3 0 1"), "end of the file");
    check(&text_ply("4", "4294967295 0 1 2"), "end of the file");
    check(&text_ply("4", "3 0 1 x"), "\"x\"");
    check(&text_ply("4", "3 0 1 1"), "triangle");
    check("ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n0\n", "x, y and z");
    assert!(matches!(load_model(Path::new("absent.ply")), Err(AssetError::Unreadable { .. })));
    assert!(matches!(load_model(Path::new("a.obj")), Err(AssetError::UnknownFormat { .. })));
}

#[test]
fn damaged_ply_does_not_panic() {
    let folder = Folder::new();
    fuzz(&folder, "fuzz.ply", &binary_ply(false), 600);
    fuzz(&folder, "fuzz.ply", text_ply("4", "4 0 1 2 3").as_bytes(), 600);
}

/// Positions of a triangle facing +Z, and the indices 0, 1, 2 as u16 after them.
fn triangle_buffer() -> Vec<u8> {
    let mut bytes = Vec::new();
    for p in [[0.0_f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]] {
        p.iter().for_each(|c| bytes.extend(c.to_le_bytes()));
    }
    [0_u16, 1, 2].iter().for_each(|i| bytes.extend(i.to_le_bytes()));
    bytes
}

/// A document around that buffer, whose nodes and buffer are given.
fn document(nodes: &str, buffer: &str) -> String {
    format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],"nodes":[{nodes}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"indices":1}}]}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}},
                     {{"bufferView":1,"componentType":5123,"count":3,"type":"SCALAR"}}],
        "bufferViews":[{{"buffer":0,"byteLength":36}},{{"buffer":0,"byteOffset":36,"byteLength":6}}],
        "buffers":[{buffer}]}}"#
    )
}

fn glb(json: &str, blob: &[u8]) -> Vec<u8> {
    let mut json = json.as_bytes().to_vec();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut blob = blob.to_vec();
    blob.resize(blob.len().next_multiple_of(4), 0);
    let mut bytes = b"glTF\x02\0\0\0".to_vec();
    bytes.extend((28 + json.len() as u32 + blob.len() as u32).to_le_bytes());
    for (kind, data) in [(b"JSON", json), (b"BIN\0", blob)] {
        bytes.extend((data.len() as u32).to_le_bytes());
        bytes.extend(kind);
        bytes.extend(data);
    }
    bytes
}

const NODE: &str = r#"{"mesh":0}"#;
/// The buffer of `triangle_buffer` in base64.
const INLINE: &str =
    r#"{"byteLength":42,"uri":"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAABAAIA"}"#;

#[test]
fn gltf_with_buffers_of_every_kind() {
    let folder = Folder::new();
    folder.write("my data.bin", triangle_buffer());
    let beside = r#"{"byteLength":42,"uri":"my%20data.bin"}"#;
    let paths = [
        folder.write("inline.gltf", document(NODE, INLINE)),
        folder.write("beside.GLTF", document(NODE, beside)),
        folder.write("binary.glb", glb(&document(NODE, r#"{"byteLength":42}"#), &triangle_buffer())),
    ];
    for path in paths {
        assert!(is_model_path(&path));
        let (mesh, warnings) = load(&path);
        assert_complete(&mesh);
        assert_eq!((mesh.positions.len(), mesh.triangles.as_slice()), (3, &[[0, 1, 2]][..]));
        assert_eq!(mesh.normals[0], Vec3::Z);
        assert!(warnings.iter().all(|w| w.contains("texture coordinates")), "{warnings:?}");
        let (model, _) = load_model(&path).expect("as before");
        assert_eq!(model.unit_mm, Some(1000.0));
        assert_eq!(Some(model.name.as_str()), path.file_stem().and_then(|stem| stem.to_str()));
    }
}

#[test]
fn gltf_transforms() {
    let folder = Folder::new();
    let front = |nodes: &str| {
        let (mesh, _) = load(&folder.write("moved.gltf", document(nodes, INLINE)));
        assert_complete(&mesh);
        let [a, b, c] = mesh.triangles[0].map(|i| mesh.positions[i as usize]);
        let ng = (b - a).cross(c - a).normalize();
        assert!(ng.distance(mesh.normals[0]) < 1e-5, "{ng} {}", mesh.normals[0]);
        (mesh.bounds(), ng)
    };
    // A quarter turn about x by a matrix (columns), above a scale that mirrors z.
    let nodes = r#"{"children":[1],"matrix":[1,0,0,0, 0,0,1,0, 0,-1,0,0, 5,0,0,1]},
                   {"mesh":0,"scale":[2,3,-1],"translation":[0,0,1]}"#;
    let (bounds, ng) = front(nodes);
    // The triangle faced +Z; the mirror leaves its outside there turned to -Z; the matrix takes z to -y.
    assert!(ng.distance(Vec3::Y) < 1e-5, "{ng}");
    assert!(bounds.min.distance(Vec3::new(5.0, -1.0, 0.0)) < 1e-5, "{bounds:?}");
    assert!(bounds.max.distance(Vec3::new(7.0, -1.0, 3.0)) < 1e-5, "{bounds:?}");
    // A shear-like scale: normals go with the inverse transpose.
    let (_, ng) = front(r#"{"mesh":0,"rotation":[0,0.70710678,0,0.70710678],"scale":[1,1,4]}"#);
    assert!(ng.distance(Vec3::X) < 1e-5, "{ng}");
}

#[test]
fn gltf_strips_and_fans() {
    let folder = Folder::new();
    let positions: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];
    let mut bytes: Vec<u8> = positions.iter().flatten().flat_map(|c| c.to_le_bytes()).collect();
    bytes.extend([0, 1, 3, 2]);
    for (mode, indices, expected) in [(5, "", [[0, 1, 2], [2, 1, 3]]), (6, r#","indices":1"#, [[0, 1, 3], [0, 3, 2]])] {
        let json = format!(
            r#"{{"asset":{{"version":"2.0"}},"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"mode":{mode}{indices}}}]}}],
            "accessors":[{{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3"}},
                         {{"bufferView":1,"componentType":5121,"count":4,"type":"SCALAR"}}],
            "bufferViews":[{{"buffer":0,"byteLength":48}},{{"buffer":0,"byteOffset":48,"byteLength":4}}],
            "buffers":[{{"byteLength":52}}]}}"#
        );
        let (mesh, _) = load(&folder.write("strip.glb", glb(&json, &bytes)));
        assert_eq!(mesh.triangles, expected, "mode {mode}");
        assert!(mesh.normals.iter().all(|n| n.distance(Vec3::Z) < 1e-6));
    }
}

#[test]
fn gltf_that_is_wrong() {
    let folder = Folder::new();
    let whole = document(NODE, INLINE);
    // What is replaced by what, and what the message speaks of.
    let cases = [
        ("\"count\":3,\"type\":\"VEC3\"", "\"count\":4,\"type\":\"VEC3\"", "expected 4 elements"),
        ("\"count\":3,\"type\":\"VEC3\"", "\"count\":18446744073709551615,\"type\":\"VEC3\"", "bufferView of 36"),
        ("\"byteLength\":36", "\"byteLength\":18446744073709551615,\"byteOffset\":18446744073709551615", "buffer 0"),
        ("\"componentType\":5126", "\"componentType\":1", "componentType"),
        ("\"type\":\"VEC3\"", "\"type\":\"VEC2\"", "Vec3"),
        ("\"bufferView\":0,", "", "expected a bufferView"),
        ("\"bufferView\":1,", "\"bufferView\":9,", "bufferView below 2"),
        ("\"indices\":1", "\"indices\":7", "accessor 7"),
        ("\"POSITION\":0", "\"NORMAL\":0", "POSITION"),
        ("\"mesh\":0", "\"mesh\":3", "node.mesh"),
        ("\"mesh\":0", "\"mesh\":0,\"children\":[0]", "loop"),
        ("\"nodes\":[0]", "\"nodes\":[5]", "nodes"),
        ("\"scene\":0", "\"scene\":2", "scene"),
        ("\"version\":\"2.0\"", "\"version\":\"1.0\"", "1.0"),
        ("AAABAAIA\"", "AAABAAkA\"", "found 9"),
        ("AAABAAIA\"", "AAAB\"", "buffer 0"),
        ("\"uri\":\"data:application/octet-stream;base64", "\"uri\":\"gone.bin\",\"name\":\"", "gone.bin"),
        ("\"uri\":\"data:", "\"uri\":\"http:", "in the folder of the file"),
        ("\"uri\":\"data:", "\"uri\":\"../\",\"name\":\"", "in the folder of the file"),
        ("\"uri\":\"data:", "\"uri\":\"%2Fdev%2Fzero\",\"name\":\"", "in the folder of the file"),
        ("\"scene\":0", "\"extensionsRequired\":[\"KHR_draco_mesh_compression\"],\"scene\":0", "draco"),
        (
            "\"count\":3,\"type\":\"VEC3\"",
            "\"count\":3,\"type\":\"VEC3\",\"sparse\":{\"count\":1,\"indices\":{\"bufferView\":0,\"componentType\":5123},\"values\":{\"bufferView\":0}}",
            "sparse",
        ),
        ("{\"asset\"", "{", "JSON"),
    ];
    for (from, to, expected) in cases {
        assert!(whole.contains(from), "{from}");
        let message = refusal(&folder.write("bad.gltf", whole.replacen(from, to, 1)));
        assert!(message.contains(expected), "{to}: {message}");
    }
    for bytes in
        [&b"glTF"[..], b"glTF\x02\0\0\0\x05\0\0\0", b"glTF\x01\0\0\0\0\0\0\0", b"glTF\x02\0\0\0\xff\0\0\0\xff\xff\xff\xffJSON{}"]
    {
        refusal(&folder.write("bad.glb", bytes));
    }
}

#[test]
fn gltf_says_what_it_leaves_out() {
    let folder = Folder::new();
    let extra = r#""cameras":[{"type":"perspective","perspective":{"yfov":1,"znear":1}}],"asset""#;
    let (_, warnings) = load(&folder.write("camera.gltf", document(NODE, INLINE).replacen("\"asset\"", extra, 1)));
    assert!(warnings.iter().any(|w| w.contains("1 cameras")), "{warnings:?}");
}

#[test]
fn damaged_gltf_does_not_panic() {
    let folder = Folder::new();
    fuzz(&folder, "fuzz.gltf", document(NODE, INLINE).as_bytes(), 500);
    let json = document(r#"{"mesh":0,"scale":[1,2,-3]}"#, r#"{"byteLength":42}"#);
    fuzz(&folder, "fuzz.glb", &glb(&json, &triangle_buffer()), 500);
}

#[test]
fn complete_mends_what_it_can() {
    let nan = Vec3::splat(f32::NAN);
    let mesh = Mesh {
        positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::X, nan, Vec3::ONE],
        normals: vec![Vec3::Z, Vec3::ZERO, nan, Vec3::Z, Vec3::Z, Vec3::Z],
        uvs: vec![Vec2::NAN; 6],
        triangles: vec![[0, 1, 2], [0, 1, 1], [0, 1, 3], [0, 1, 4], [0, 1, 9]],
        ..Mesh::default()
    };
    let (mesh, notes) = mesh.complete();
    assert_complete(&mesh);
    assert_eq!((mesh.positions.len(), mesh.triangles.len()), (3, 1));
    assert!(mesh.normals.iter().all(|n| n.distance(Vec3::Z) < 1e-6));
    assert_eq!(notes.len(), 4, "{notes:?}");
    let (nothing, notes) = Mesh::default().complete();
    assert!(nothing == Mesh::default() && notes.is_empty() && nothing.bounds().size() == Vec3::ZERO);
}

#[test]
fn loading_tells_how_far_it_is_and_ends_when_nobody_wants_it() {
    let folder = Folder::new();
    // Two meshes of the same corners: a seam in each, so that the whole algorithm for tangents runs.
    let triangle = |x: f32| [[x, 0.0, 0.0], [x + 1.0, 0.0, 0.0], [x, 1.0, 0.0]].concat();
    let numbers: Vec<u8> = [triangle(0.0), triangle(2.0)].concat().iter().flat_map(|x| x.to_le_bytes()).collect();
    folder.write("a.bin", &numbers);
    let accessor = |k: usize| format!(r#"{{"bufferView":{k},"componentType":5126,"count":3,"type":"VEC3"}}"#);
    let view = |k: usize| format!(r#"{{"buffer":0,"byteOffset":{},"byteLength":36}}"#, 36 * k);
    let mesh = |k: usize| format!(r#"{{"primitives":[{{"attributes":{{"POSITION":{k}}}}}]}}"#);
    let both = |of: &dyn Fn(usize) -> String| format!("[{},{}]", of(0), of(1));
    let text = format!(
        r#"{{"asset":{{"version":"2.0"}},"buffers":[{{"uri":"a.bin","byteLength":72}}],"bufferViews":{},"accessors":{},"meshes":{}}}"#,
        both(&view),
        both(&accessor),
        both(&mesh)
    );
    let path = folder.write("a.gltf", text);
    let shares = std::cell::RefCell::new(Vec::new());
    let listen = |share: f32| {
        shares.borrow_mut().push(share);
        true
    };
    load_model_with(&path, Progress::new(&listen)).expect("two triangles");
    let heard = shares.take();
    assert!(heard.len() >= 4 && heard.is_sorted() && heard.iter().all(|share| (0.0..=1.0).contains(share)), "{heard:?}");
    assert!(heard.iter().any(|share| (0.3..0.7).contains(share)), "half of the meshes is half of the work: {heard:?}");
    for limit in 0..heard.len() {
        let left = std::cell::Cell::new(limit);
        let listen = |_| left.replace(left.get().saturating_sub(1)) > 0;
        let result = load_model_with(&path, Progress::new(&listen));
        assert!(matches!(&result, Err(AssetError::Ended { .. })), "{limit}: {result:?}");
    }
}
