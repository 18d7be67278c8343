//! Meshes out of USD: faces, primvars, transforms, units and materials.

use burnish_material::exchange::usd::{self, FoundMesh, MeshArrays, Options};
use burnish_material::{Material, Property};

use super::read;

/// A square of two units in a layer of metres, with these lines.
fn square(lines: &str) -> String {
    format!(
        "#usda 1.0\n(\nmetersPerUnit = 1\nupAxis = \"Y\"\n)\ndef Mesh \"Q\" {{\npoint3f[] points = [(0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0)]\n\
         int[] faceVertexCounts = [4]\nint[] faceVertexIndices = [0, 1, 2, 3]\n{lines}\n}}\n"
    )
}

fn one(text: &str) -> FoundMesh {
    let mut scene = read(text);
    assert!(scene.notes.is_empty() && scene.meshes.len() == 1, "{:?}\n{text}", scene.notes);
    scene.meshes.remove(0)
}

fn near(a: [f32; 3], b: [f32; 3]) -> bool {
    a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-5)
}

#[test]
fn faces_become_fans() {
    let mesh = one(&square(""));
    assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3]]);
    assert_eq!((mesh.normals, mesh.uvs, mesh.parts.len(), mesh.parts[0].material), (None, None, 1, None));
    let mirrored = one(&square("uniform token orientation = \"leftHanded\""));
    assert_eq!(mirrored.triangles, [[0, 2, 1], [0, 3, 2]]);
}

#[test]
fn every_interpolation_finds_its_corners() {
    let uvs = |text: &str| {
        let mesh = one(&square(text));
        let uvs = mesh.uvs.expect("uv");
        let corner = |triangle: usize, k: usize| uvs[mesh.triangles[triangle][k] as usize];
        (corner(0, 0), corner(0, 1), corner(0, 2), corner(1, 2), mesh.positions.len())
    };
    let all = "[(0, 0), (1, 0), (1, 1), (0, 1)]";
    let expected = ([0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], 4);
    for kind in ["vertex", "varying", "faceVarying"] {
        assert_eq!(uvs(&format!("texCoord2f[] primvars:st = {all} ( interpolation = \"{kind}\" )")), expected, "{kind}");
    }
    let half = ([0.5, 0.25], [0.5, 0.25], [0.5, 0.25], [0.5, 0.25], 4);
    for kind in ["constant", "uniform"] {
        assert_eq!(uvs(&format!("texCoord2f[] primvars:st = [(0.5, 0.25)] ( interpolation = \"{kind}\" )")), half, "{kind}");
    }
    assert_eq!(uvs("float2[] primvars:map1 = [(0.5, 0.25)]"), half);
    let indexed = format!(
        "texCoord2f[] primvars:st = {all} (\n interpolation = \"faceVarying\"\n)\nint[] primvars:st:indices = [3, 3, 3, 0]"
    );
    assert_eq!(uvs(&indexed), ([0.0, 1.0], [0.0, 1.0], [0.0, 1.0], [0.0, 0.0], 4));
}

#[test]
fn corners_that_differ_become_vertices_of_their_own() {
    let text = "#usda 1.0\ndef Mesh \"M\" {\nint[] faceVertexCounts = [3, 3]\nint[] faceVertexIndices = [0, 1, 2, 0, 2, 3]\n\
                point3f[] points = [(0, 0, 0), (100, 0, 0), (100, 100, 0), (0, 100, 0)]\n\
                normal3f[] normals = [(0, 0, 1), (0, 0, 1), (0, 0, 1), (0, 0, 1), (0, 0, -1), (0, 0, 1)] ( interpolation = \"faceVarying\" )\n}\n";
    let mesh = one(text);
    assert_eq!((mesh.positions.len(), mesh.triangles.clone()), (5, vec![[0, 1, 2], [0, 3, 4]]));
    assert_eq!(mesh.normals.map(|normals| normals[3]), Some([0.0, 0.0, -1.0]));
    // Centimetres are the unit of a layer that says none.
    assert_eq!(mesh.positions[2], [1.0, 1.0, 0.0]);
}

#[test]
fn transforms_apply_in_their_order() {
    let at = |lines: &str| one(&square(lines)).positions[1];
    let order = |names: &str| format!("uniform token[] xformOpOrder = [{names}]");
    let moved = "double3 xformOp:translate = (1, 0, 0)\nfloat3 xformOp:scale = (3, 1, 1)\nfloat xformOp:rotateZ = 90\n";
    // The point (2, 0, 0), by the last operation first.
    for (names, expected) in [
        ("\"xformOp:translate\", \"xformOp:rotateZ\", \"xformOp:scale\"", [1.0, 6.0, 0.0]),
        ("\"xformOp:scale\", \"xformOp:rotateZ\", \"xformOp:translate\"", [0.0, 3.0, 0.0]),
        ("\"xformOp:translate\", \"!invert!xformOp:translate\"", [2.0, 0.0, 0.0]),
    ] {
        assert!(near(at(&format!("{moved}{}", order(names))), expected), "{names}");
    }
    assert!(near(at(moved), [2.0, 0.0, 0.0]), "operations that the order does not name do nothing");
    let turned = |op: &str, name: &str| at(&format!("{op}\n{}", order(&format!("\"{name}\""))));
    // X first: (2, 0, 0) stays, then Y turns it to -z, then Z leaves that.
    assert!(near(turned("float3 xformOp:rotateXYZ = (90, 90, 90)", "xformOp:rotateXYZ"), [0.0, 0.0, -2.0]));
    assert!(near(turned("float3 xformOp:rotateZYX = (90, 90, 90)", "xformOp:rotateZYX"), [0.0, 0.0, 2.0]));
    assert!(near(turned("quatf xformOp:orient = (0.70710677, 0, 0, 0.70710677)", "xformOp:orient"), [0.0, 2.0, 0.0]));
    let matrix = "matrix4d xformOp:transform = ((0, 1, 0, 0), (-1, 0, 0, 0), (0, 0, 1, 0), (5, 6, 7, 1))";
    assert!(near(turned(matrix, "xformOp:transform"), [5.0, 8.0, 7.0]));
    let turns: String =
        square("").replace("def Mesh", &format!("def Xform \"P\" {{ {moved} {} def Mesh", order("\"xformOp:translate\"")));
    assert!(near(one(&format!("{turns}}}")).positions[1], [3.0, 0.0, 0.0]));
    let reset = turns.replace("int[] faceVertexCounts", &format!("{} int[] faceVertexCounts", order("\"!resetXformStack!\"")));
    assert!(near(one(&format!("{reset}}}")).positions[1], [2.0, 0.0, 0.0]));
}

#[test]
fn units_and_axes_become_metres_with_y_up() {
    let lines = "normal3f[] normals = [(0, 0, 1)] ( interpolation = \"constant\" )\n\
                 float3 xformOp:scale = (1, 1, -1)\nuniform token[] xformOpOrder = [\"xformOp:scale\"]";
    let text = square(lines).replace("metersPerUnit = 1", "metersPerUnit = 0.5").replace("upAxis = \"Y\"", "upAxis = \"Z\"");
    let mesh = one(&text);
    assert!(near(mesh.positions[2], [1.0, 0.0, -1.0]));
    assert!(near(mesh.normals.as_ref().expect("normals")[0], [0.0, -1.0, 0.0]));
    assert_eq!(mesh.triangles[0], [0, 2, 1], "a mirrored mesh is turned inside out");
}

const LOOKS: &str = "def Scope \"Looks\" {\ndef Material \"A\" {}\ndef Material \"B\" {}\ndef \"Group\" (active = false) { def Material \"Gone\" {} }\n}\n";

#[test]
fn materials_are_bound_by_prim_subset_and_ancestor() {
    let subset = "def GeomSubset \"S\" { uniform token elementType = \"face\"; int[] indices = [0, 7]; rel material:binding = </Looks/B> }";
    let faces = square(subset).replace("[4]", "[3, 3]").replace("[0, 1, 2, 3]", "[0, 1, 2, 0, 2, 3]");
    let bound = faces.replace("def Mesh", &format!("{LOOKS}def Xform \"P\" {{ rel material:binding = </Looks/A> def Mesh"));
    let scene = read(&format!("{bound}}}"));
    assert_eq!(scene.materials.iter().map(|found| found.path.as_str()).collect::<Vec<_>>(), ["/Looks/A", "/Looks/B"]);
    let mesh = &scene.meshes[0];
    assert_eq!(mesh.triangles, [[0, 2, 3], [0, 1, 2]], "sorted by part");
    let parts: Vec<_> = mesh.parts.iter().map(|part| (part.material, part.triangles.clone())).collect();
    assert_eq!(parts, [(Some(0), 0..1), (Some(1), 1..2)]);
}

#[test]
fn variants_overs_and_references() {
    let text = "#usda 1.0\ndef \"Root\" (\n variants = { string look = \"red\" }\n prepend variantSets = \"look\"\n references = @other.usda@</X> (offset = 2)\n) {\n\
                def Material \"M\" { token outputs:surface.connect = </Root/M/S.outputs:surface>\n def Shader \"S\" { uniform token info:id = \"UsdPreviewSurface\" \
                float inputs:roughness = 0.25 } }\n variantSet \"look\" = {\n \"blue\" { over \"M\" { over \"S\" { color3f inputs:diffuseColor = (0, 0, 1) } } }\n \
                \"red\" (doc = \"it is\") { over \"M\" { over \"S\" { color3f inputs:diffuseColor = (1, 0, 0); float inputs:roughness = 0.75 } } }\n }\n}\n\
                class Material \"Abstract\" {}\n";
    let scene = read(text);
    let notes = &scene.notes;
    assert!(notes.len() == 1 && notes[0].contains("references `other.usda`") || notes[0].contains("not followed"), "{notes:?}");
    assert_eq!(scene.materials.len(), 1);
    let material = &scene.materials[0].material;
    assert_eq!(material.color(Property::base_color), [1.0, 0.0, 0.0]);
    assert_eq!(material.float(Property::roughness), 0.25, "what the prim itself says counts more");
}

#[test]
fn broken_meshes_cost_a_note_each() {
    for (from, to) in [
        ("[0, 1, 2, 3]", "[0, 1, 2, 4]"),
        ("[0, 1, 2, 3]", "[0, 1, 2, -1]"),
        ("[0, 1, 2, 3]", "[0, 1, 2, 0.5]"),
        ("[0, 1, 2, 3]", "[]"),
        ("[4]", "[5]"),
        ("[4]", "[1000000000, 1000000000]"),
        ("[4]", "[2, 2]"),
        ("(2, 2, 0)", "(2, 2, 1e300)"),
        ("(2, 2, 0)", "(2, 2, nan)"),
        ("point3f[] points", "point3f[] dots"),
    ] {
        let scene = read(&square("").replace(from, to));
        assert!(scene.meshes.is_empty() && !scene.notes.is_empty(), "{to}: {:?}", scene.notes);
    }
    for lines in [
        "texCoord2f[] primvars:st = [(1e300, 0)] ( interpolation = \"constant\" )",
        "texCoord2f[] primvars:st = [(0, 0)] ( interpolation = \"vertex\" )",
        "texCoord2f[] primvars:st = [(0, 0)] ( interpolation = \"sideways\" )",
        "texCoord2f[] primvars:st = [(0, 0)] ( interpolation = \"vertex\" )\nint[] primvars:st:indices = [0, 0, 0, 9]",
    ] {
        let scene = read(&square(lines));
        assert!(scene.meshes[0].uvs.is_none() && scene.notes.len() == 1, "{:?}", scene.notes);
    }
    let flat = "float3 xformOp:scale = (1, 1, 0)\nuniform token[] xformOpOrder = [\"xformOp:scale\"]";
    assert!(read(&square(flat)).meshes.is_empty());
    let unknown = read(&square("uniform token[] xformOpOrder = [\"xformOp:twist\"]"));
    assert!(unknown.meshes.len() == 1 && unknown.notes.len() == 1);
}

#[test]
fn a_mesh_opens_with_its_materials() {
    let (a, b) = (Material::named("Same"), Material::named("Same"));
    let mesh = MeshArrays {
        name: "Quad",
        positions: &[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.5], [0.0, 1.0, 0.5]],
        normals: &[[0.0, 0.0, 1.0]; 4],
        tangents: &[[1.0, 0.0, 0.0, 1.0]; 4],
        uvs: &[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]],
        triangles: &[[0, 1, 2], [0, 2, 3]],
        parts: &[(1, 0..1), (0, 1..2)],
    };
    let options =
        Options { path_of: &|texture| texture.path.clone(), image_folder: "", mesh: Some(&mesh), has_native_copy: true };
    let scene = read(&usd::write(&[&a, &b], &options).text);
    assert!(scene.notes.is_empty(), "{:?}", scene.notes);
    let found = &scene.meshes[0];
    assert_eq!(found.path, "/Scene/Quad");
    for (p, q) in found.positions.iter().zip(mesh.positions) {
        assert!(p.iter().zip(q).all(|(p, q)| (p - q).abs() < 1e-6), "{p:?} {q:?}");
    }
    assert_eq!((found.uvs.as_deref(), found.normals.as_deref()), (Some(mesh.uvs), Some(mesh.normals)));
    assert_eq!(found.triangles, mesh.triangles);
    let parts: Vec<_> = found.parts.iter().map(|part| (part.material, part.triangles.clone())).collect();
    assert_eq!(parts, [(Some(1), 0..1), (Some(0), 1..2)]);
    assert_eq!(scene.materials[1].path, "/Scene/Materials/Same_2");
}
