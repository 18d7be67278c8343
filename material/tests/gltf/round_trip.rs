//! There and back: bit by bit with the native copy, and what is called exact without it.

use burnish_material::exchange::gltf::{Mesh, Options, read};
use burnish_material::exchange::loss::Fate;
use burnish_material::exchange::model::Context;
use burnish_material::exchange::models::gltf::MODEL;
use burnish_material::{Material, PROPERTIES, Value};
use proptest::prelude::*;

use super::{PNG, QUAD, bare, beside, common, least, most, off_default, opened, varied, written};

fn check_round_trip(material: &Material, mesh: Option<&Mesh>) {
    let written = written(material, mesh, &Options::default());
    let text = written.gltf("mesh.bin");
    let glb = written.glb(|_| Some(PNG.to_vec())).expect("images in order");
    let expected = beside(&written, material);
    for bytes in [text.as_bytes(), &glb] {
        let document = opened(bytes);
        let (back, notes) = document.materials[0].material();
        assert_eq!(back, expected, "{notes:?}");
        assert!(notes.is_empty() && document.notes.is_empty(), "{notes:?} {:?}", document.notes);
        assert_eq!(document.materials[0].fields, opened(bytes).materials[0].fields);
    }
    for job in &written.plan.jobs {
        for material in [&least(), &most(), material] {
            let texel = job.texel(&MODEL, &material.inputs(), &Context::of(material));
            assert!(texel.iter().all(|x| (0.0..=1.0).contains(x)), "{job:?}");
        }
    }
    assert!(!text.contains("null"), "{text}");
}

#[test]
fn plain_materials_come_back_bit_by_bit() {
    for material in [Material::named("Plain"), off_default(), least(), most()] {
        check_round_trip(&material, None);
        check_round_trip(&material, Some(&QUAD));
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn random_materials_come_back_bit_by_bit(material in common::material(), number: u64) {
        check_round_trip(&varied(material, number), (number % 2 == 0).then_some(&QUAD));
    }

    #[test]
    fn what_is_called_exact_comes_back_without_the_native_copy(mut material in common::material(), has_mesh: bool) {
        for def in PROPERTIES {
            material.slot_mut(def.id).texture = None;
        }
        let mesh = has_mesh.then_some(&QUAD);
        let written = written(&material, mesh, &bare());
        let found = &opened(written.gltf("mesh.bin").as_bytes()).materials[0];
        prop_assert!(found.native.is_none());
        let (back, _) = found.material();
        let context = Context { mesh_width: mesh.map_or(1.0, Mesh::width), ..Context::of(&material) };
        for row in MODEL.translate(&material, &context).rows.iter().filter(|row| row.fate <= Fate::Remapped) {
            let (a, b) = (material.value(row.property), back.value(row.property));
            let near = a.numbers().iter().zip(b.numbers()).all(|(a, b)| (a - b).abs() <= 1e-4 * a.abs().max(1.0));
            let same = match (a, b) { (Value::Bool(a), Value::Bool(b)) => a == b, _ => near };
            // A lobe that is off says nothing; what it would say is the default.
            let is_idle = !row.has_effect && b == row.property.def().default;
            prop_assert!(same || is_idle, "{}: {a:?} became {b:?}, said to be {}", row.property.def().name, row.fate.word());
        }
    }

    #[test]
    fn whatever_stands_in_a_document_is_read_without_a_panic(bytes in proptest::collection::vec(any::<u8>(), 0..200), place in 0..4000_usize) {
        let _ = read(&bytes);
        let written = written(&off_default(), Some(&QUAD), &Options::default());
        for mut file in [written.gltf("mesh.bin").into_bytes(), written.glb(|_| Some(PNG.to_vec())).expect("images in order")] {
            let place = place % file.len();
            file[place] = bytes.first().copied().unwrap_or(b'}');
            if let Ok(document) = read(&file) {
                document.materials.iter().for_each(|found| _ = found.material());
            }
            file.truncate(place);
            let _ = read(&file);
        }
    }
}
