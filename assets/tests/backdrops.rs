//! Backdrops under meshes of any size.

use burnish_assets::{BACKDROPS, BackdropDef, Bounds, Role, make_shape};
use glam::Vec3;

fn own(bounds: Bounds) -> Vec<(Role, Bounds)> {
    vec![(Role::Object, bounds)]
}

fn sweep() -> &'static BackdropDef {
    BackdropDef::named("Grey-Sweep").expect("in the table")
}

#[test]
fn triangles_face_the_side_of_their_normals() {
    let model = own(Bounds { min: Vec3::ZERO, max: Vec3::ONE });
    for part in BACKDROPS.iter().flat_map(|def| def.parts(model.iter().copied())) {
        let mesh = &part.mesh;
        for t in &mesh.triangles {
            let [a, b, c] = t.map(|i| mesh.positions[i as usize]);
            let face = (b - a).cross(c - a).normalize();
            assert!(t.iter().all(|i| face.dot(mesh.normals[*i as usize]) > 0.97), "{}", mesh.name);
        }
        assert!(mesh.normals.iter().all(|n| (n.length() - 1.0).abs() < 1e-5));
    }
}

#[test]
fn a_mesh_of_any_size_stands_on_it_without_touching() {
    for size in [1e-3, 1.0, 5e4_f32] {
        let min = Vec3::new(3.0, -2.0, 1.0) * size;
        let bounds = Bounds { min, max: min + Vec3::new(2.0, 1.0, 0.5) * size };
        let parts = sweep().parts(own(bounds).into_iter());
        let all = parts.iter().fold(Bounds::EMPTY, |all, part| all.union(part.mesh.bounds()));
        let gap = (bounds.min.y - all.min.y) / size;
        assert!((0.001..0.05).contains(&gap), "{gap}");
        assert!((all.center().x - bounds.center().x).abs() < 1e-3 * size);
        // Behind it, and on both sides of the first camera.
        assert!(all.min.z < bounds.min.z - 5.0 * size && all.max.z > bounds.max.z + 10.0 * size);
    }
}

#[test]
fn the_wall_rises_from_the_edge_of_the_floor() {
    let parts = sweep().parts(own(Bounds { min: Vec3::NEG_ONE, max: Vec3::ONE }).into_iter());
    let [flat, risen] = [&parts[0].mesh, &parts[1].mesh].map(|mesh| mesh.bounds());
    assert_eq!(flat.min.y, flat.max.y);
    assert!((risen.min.y - flat.min.y).abs() < 1e-5 && risen.max.z > flat.min.z && risen.max.z - flat.min.z < 0.5);
    assert_eq!((risen.min.x, risen.max.x), (flat.min.x, flat.max.x));
}

#[test]
fn it_lies_where_the_floor_of_a_built_in_mesh_was_and_nothing_needs_a_mesh() {
    let model = make_shape("shader-ball").expect("in the table");
    let parts = sweep().parts(model.parts.iter().map(|part| (part.role, part.mesh.bounds())));
    assert_eq!(parts[0].mesh.bounds().min.y, 0.0);
    assert!(sweep().parts(own(Bounds::EMPTY).into_iter()).is_empty());
    let point = Bounds { min: Vec3::ONE, max: Vec3::ONE };
    assert!(sweep().parts(own(point).into_iter()).is_empty());
}
