//! Are the built-in models what a renderer relies on: closed, facing outwards, apart, and complete?

use std::collections::HashMap;

use burnish_assets::{Mesh, Role, SHAPES, make_shape};
use glam::Vec3;

/// The same number for the same place.
fn weld(mesh: &Mesh) -> Vec<usize> {
    let mut numbers = HashMap::new();
    let places = mesh.positions.iter().map(|p| {
        let key = p.to_array().map(|x| (x + 0.0).to_bits());
        let next = numbers.len();
        *numbers.entry(key).or_insert(next)
    });
    places.collect()
}

/// How many directed edges have no partner running the other way, and how many occur twice.
fn loose_edges(mesh: &Mesh) -> (usize, usize) {
    let number = weld(mesh);
    let mut edges: HashMap<(usize, usize), usize> = HashMap::new();
    for t in &mesh.triangles {
        for k in 0..3 {
            *edges.entry((number[t[k] as usize], number[t[(k + 1) % 3] as usize])).or_default() += 1;
        }
    }
    let open = edges.keys().filter(|&&(a, b)| !edges.contains_key(&(b, a))).count();
    (open, edges.values().filter(|&&count| count != 1).count())
}

fn corners(mesh: &Mesh, t: [u32; 3]) -> [Vec3; 3] {
    t.map(|i| mesh.positions[i as usize])
}

#[test]
fn names_are_unique_and_found() {
    for (k, def) in SHAPES.iter().enumerate() {
        assert!(SHAPES[..k].iter().all(|other| other.name != def.name), "{}", def.name);
        let model = make_shape(&def.name.to_uppercase()).expect(def.name);
        assert_eq!(model, (def.make)(), "{} is made twice the same", def.name);
    }
    assert_eq!(SHAPES[0].name, "shader-ball");
    assert!(make_shape("teapot").is_none());
}

#[test]
fn bodies_are_closed_and_face_outwards() {
    for def in SHAPES {
        for part in (def.make)().parts {
            let (mesh, name) = (&part.mesh, format!("{}, {:?}", def.name, part.role));
            let is_open = def.name == "plane" || matches!(part.role, Role::FloorLight | Role::FloorDark | Role::Sweep);
            if is_open {
                continue;
            }
            assert_eq!(loose_edges(mesh), (0, 0), "{name}");
            let volume: f64 = mesh
                .triangles
                .iter()
                .map(|&t| {
                    let [a, b, c] = corners(mesh, t).map(|p| p.as_dvec3());
                    a.dot(b.cross(c)) / 6.0
                })
                .sum();
            assert!(volume > 0.05, "{name} has the volume {volume}");
        }
    }
}

#[test]
fn meshes_are_complete() {
    for def in SHAPES {
        for part in (def.make)().parts {
            let (mesh, name) = (&part.mesh, format!("{}, {:?}", def.name, part.role));
            let count = mesh.positions.len();
            assert!([mesh.normals.len(), mesh.tangents.len(), mesh.uvs.len()] == [count; 3], "{name}");
            assert!(mesh.uvs.iter().all(|uv| uv.is_finite()), "{name}");
            for (n, t) in mesh.normals.iter().zip(&mesh.tangents) {
                assert!((n.length() - 1.0).abs() < 1e-4 && (t.truncate().length() - 1.0).abs() < 1e-4, "{name}");
                assert!(n.dot(t.truncate()).abs() < 1e-4 && t.w == 1.0, "{name}");
            }
            let mut worst = 1.0_f32;
            for &t in &mesh.triangles {
                let [a, b, c] = corners(mesh, t);
                let ng = (b - a).cross(c - a).normalize();
                assert!(ng.is_finite(), "{name} has a triangle without area at {a}");
                worst = t.iter().fold(worst, |worst, &i| worst.min(ng.dot(mesh.normals[i as usize])));
            }
            assert!(worst > 0.6, "{name}: a normal leaves its triangle's by the cosine {worst}");
            let (again, notes) = mesh.clone().complete();
            assert!(notes.is_empty() && again.triangles.len() == mesh.triangles.len(), "{name}: {notes:?}");
        }
    }
}

/// Tangents follow dP/du and the uvs are unmirrored: both taken from the triangles alone.
#[test]
fn tangents_follow_the_uvs() {
    for def in SHAPES {
        for part in (def.make)().parts {
            let mesh = &part.mesh;
            let (mut agree, mut mirrored) = (0, 0);
            for &t in &mesh.triangles {
                let [a, b, c] = corners(mesh, t);
                let [ua, ub, uc] = t.map(|i| mesh.uvs[i as usize]);
                let (e1, e2) = (ub - ua, uc - ua);
                let area = e1.perp_dot(e2);
                // v grows downwards, so outside and unmirrored is negative.
                mirrored += usize::from(area >= 0.0);
                let along = (((b - a) * e2.y - (c - a) * e1.y) * area.signum()).normalize();
                agree += usize::from(t.iter().all(|&i| mesh.tangents[i as usize].truncate().dot(along) > 0.9));
            }
            let name = format!("{}, {:?}", def.name, part.role);
            assert_eq!(mirrored, 0, "{name}");
            // Around a pole the tangent turns within one triangle.
            assert!(agree * 100 >= mesh.triangles.len() * 96, "{name}: {agree} of {}", mesh.triangles.len());
        }
    }
}

#[test]
fn sizes() {
    for def in SHAPES {
        let model = (def.make)();
        let object = model.object_bounds();
        let triangles: usize = model.parts.iter().filter(|p| p.role == Role::Object).map(|p| p.mesh.triangles.len()).sum();
        assert!((8_000..=130_000).contains(&triangles), "{}: {triangles}", def.name);
        let width = object.size().x.max(object.size().z);
        assert!((1.5..=2.2).contains(&width), "{}: {width}", def.name);
        assert!(object.min.y >= 0.0 && object.min.y < 0.3, "{}: {}", def.name, object.min.y);
        let floor = model.parts.iter().find(|part| part.role == Role::FloorLight);
        assert_eq!(floor.is_some(), def.name != "plane");
        if let Some(floor) = floor {
            assert!(floor.mesh.bounds().size().x >= 60.0 && floor.mesh.bounds().size().y == 0.0);
        }
    }
    let ball = make_shape("shader-ball").expect("in the table").object_bounds();
    assert!((ball.center() - Vec3::new(0.0, 1.27, 0.0)).length() < 1e-3 && (ball.size().x - 2.0).abs() < 1e-3);
}

/// The vertices of the object keep away from those of the stand. Both are fine enough for that to speak for the faces.
#[test]
fn objects_do_not_touch_their_stands() {
    for def in SHAPES {
        let model = (def.make)();
        let Some(stand) = model.parts.iter().find(|part| part.role == Role::Stand) else { continue };
        // Cells of this size, so that only neighbours need to be compared.
        const CELL: f32 = 0.05;
        let cell = |p: Vec3| (p / CELL).floor().as_ivec3();
        let mut cells: HashMap<glam::IVec3, Vec<Vec3>> = HashMap::new();
        for &p in &stand.mesh.positions {
            cells.entry(cell(p)).or_default().push(p);
        }
        let mut nearest = f32::INFINITY;
        for &p in &model.parts[0].mesh.positions {
            for k in 0..27 {
                let beside = cell(p) + glam::IVec3::new(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1);
                let near = cells.get(&beside).into_iter().flatten();
                nearest = near.fold(nearest, |nearest, q| nearest.min(p.distance(*q)));
            }
        }
        assert!(nearest > 0.015, "{}: {nearest}", def.name);
        assert!(stand.mesh.bounds().min.y >= 0.004, "{}", def.name);
    }
}
