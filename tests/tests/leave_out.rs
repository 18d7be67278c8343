//! Is a picture the same whether the path tracer leaves out what a material does not need, or evaluates it all the same?

use burnish_assets::make_shape;
use burnish_material::{LOBES, LobeSet, Material, Property, Value};
use burnish_renderer::path::{Film, Prepared, render_pass};
use burnish_renderer::scene::{ModelMeshes, Scene};
use burnish_tests::materials::{c, f, material};
use burnish_tests::scenes::environment;
use std::sync::Arc;

const SIZE: usize = 24;
const SPP: u32 = 64;
/// Side of the blocks that are compared.
const BLOCK: usize = 4;

/// Materials with few lobes each, so that every lobe is out in some of them.
fn materials() -> Vec<(&'static str, Material)> {
    use Property::*;
    vec![
        ("default", material(&[])),
        ("metal", material(&[(metallic, f(1.0)), (base_color, c(0.9, 0.6, 0.3))])),
        ("glass", material(&[(translucency, f(1.0)), (roughness, f(0.2))])),
        (
            "wax",
            material(&[
                (translucency, f(1.0)),
                (scatter, Value::Bool(true)),
                (scatter_color, c(0.9, 0.6, 0.4)),
                (scatter_distance, f(0.2)),
            ]),
        ),
        ("coated", material(&[(coat, f(1.0)), (sheen, f(0.5)), (anisotropy, f(0.6)), (opacity, f(0.8))])),
    ]
}

fn film(scene: &Scene, more: LobeSet, seed: u64) -> Film {
    let prepared = Prepared::with_lobes(scene, None, more, LobeSet::EMPTY);
    let mut film = Film::new(SIZE, SIZE);
    let stats = render_pass(&prepared, &mut film, SPP, seed, 2, &|| false).expect("nobody cancels");
    assert_eq!((stats.nonfinite, stats.negative), (0, 0));
    film
}

/// Differences of block means in standard errors: their mean square is 1 if both pictures have the same expectation.
fn statistics(a: &Film, b: &Film) -> (f64, f64) {
    let (means, variances) = ([a.mean(), b.mean()], [a.variance(), b.variance()]);
    let (mut square, mut sum, mut count) = (0.0, 0.0, 0.0);
    for y in (0..SIZE).step_by(BLOCK) {
        for x in (0..SIZE).step_by(BLOCK) {
            let (mut difference, mut variance) = (0.0, 0.0);
            for p in (0..BLOCK * BLOCK).map(|i| (y + i / BLOCK) * SIZE + x + i % BLOCK) {
                let sum = |v: &Vec<[f32; 3]>| v[p].iter().map(|c| f64::from(*c)).sum::<f64>();
                difference += sum(&means[0]) - sum(&means[1]);
                // Channels share their paths: standard deviations add.
                let deviation = |v: &Vec<[f32; 3]>| v[p].iter().map(|v| f64::from(*v).sqrt()).sum::<f64>();
                variance += deviation(&variances[0]).powi(2) + deviation(&variances[1]).powi(2);
            }
            if variance > 1e-12 {
                let z = difference / variance.sqrt();
                (square, sum, count) = (square + z * z, sum + z, count + 1.0);
            }
        }
    }
    (square / count, sum / f64::sqrt(count))
}

#[test]
fn every_lobe_can_be_left_out_where_it_is_not_needed() {
    let model: ModelMeshes = make_shape("torus").expect("the torus is built in").into();
    let mut rows = [0.3; 16];
    rows[3] = 4.0;
    let light = environment(&rows);
    let mut tested = LobeSet::EMPTY;
    for (name, material) in materials() {
        let needed = LobeSet::of(&material);
        let scene = Scene::of_model(&model, Arc::new(material), Arc::default(), light.clone(), 100.0);
        let pruned = film(&scene, LobeSet::EMPTY, 1);
        let mut cases: Vec<(&str, LobeSet)> = vec![("all lobes", LobeSet::all())];
        for def in LOBES.iter().filter(|def| !needed.has(def.lobe)) {
            cases.push((def.name, LobeSet::EMPTY.with(def.lobe)));
            tested = tested.with(def.lobe);
        }
        for (lobe, more) in cases {
            // Other random numbers: equal ones would agree also where both are wrong about the noise.
            let (square, sum) = statistics(&pruned, &film(&scene, more, 2));
            assert!(square < 1.9, "{name} with {lobe}: squared differences are {square} of what noise explains");
            assert!(sum.abs() < 4.5, "{name} with {lobe}: the mean differs by {sum} standard errors");
        }
    }
    assert_eq!(tested, LobeSet::all(), "not tested: {:?}", LobeSet::all().minus(tested).names(true));
}

/// The test above would see a lobe that is really missing.
#[test]
fn a_lobe_that_is_needed_shows() {
    let model: ModelMeshes = make_shape("torus").expect("the torus is built in").into();
    let coated = material(&[(Property::coat, f(1.0)), (Property::base_color, c(0.02, 0.02, 0.02))]);
    let scene = Scene::of_model(&model, Arc::new(coated), Arc::default(), environment(&[0.3, 0.3, 4.0, 0.3]), 100.0);
    let whole = film(&scene, LobeSet::EMPTY, 1);
    let less = Prepared::with_lobes(&scene, None, LobeSet::EMPTY, LobeSet::EMPTY.with(burnish_material::Lobe::coat));
    let mut without = Film::new(SIZE, SIZE);
    render_pass(&less, &mut without, SPP, 2, 2, &|| false).expect("nobody cancels");
    let (square, sum) = statistics(&whole, &without);
    assert!(square > 3.0 || sum.abs() > 6.0, "{square} {sum}");
}
