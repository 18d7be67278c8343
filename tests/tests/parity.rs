//! Do the WGSL twins compute what the Rust lobes compute? Run on the adapter, through the same sources that draw.

#![allow(clippy::needless_range_loop, reason = "a channel indexes several arrays at once")]

use burnish_material::{LobeSet, Material, PROPERTIES};
use burnish_renderer::bsdf::{Bsdf, interpret};
use burnish_renderer::tonemap::{Display, DisplayTransform};
use burnish_renderer::vector::{Rgb, V3};
use burnish_tests::gpu::compute;
use burnish_tests::materials::cases;
use burnish_tests::quadrature::direction;

/// Per query: `wo` and the material's number, `wi`, `u`.
const QUERY: usize = 12;
/// Per result: value and pdf, weight and pdf, direction and flags.
const RESULT: usize = 12;

const ENTRY: &str = "
struct Query { wo: vec3f, material: f32, wi: vec3f, unused: f32, u: vec4f }
struct Result { value: vec3f, pdf: f32, weight: vec3f, sample_pdf: f32, wi: vec3f, flags: f32 }
@group(1) @binding(0) var<storage, read_write> results: array<Result>;
@group(1) @binding(1) var<storage, read> materials: array<MaterialRows>;
@group(1) @binding(2) var<storage, read> queries: array<Query>;
@compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= arrayLength(&queries) { return; }
    let q = queries[id.x];
    let optics = interpret(inputs_from_rows(materials[u32(q.material)]), 1.0);
    let bsdf = bsdf_prepare(optics, q.wo, vec3f(1.0, 0.7, 0.4));
    let e = bsdf_eval(bsdf, q.wi);
    let s = bsdf_sample(bsdf, q.u);
    let flags = select(0.0, 1.0, s.is_valid) + select(0.0, 2.0, s.is_delta) + select(0.0, 4.0, s.is_transmission);
    results[id.x] = Result(e.value, e.pdf, s.weight, s.pdf, s.wi, flags);
}
";

fn number(i: usize, dimension: u64) -> f32 {
    let x = (i as u64 + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ dimension.wrapping_mul(0xD1B5_4A32_D192_ED03);
    let x = (x ^ (x >> 31)).wrapping_mul(0x94D0_49BB_1331_11EB);
    let x = (x ^ (x >> 29)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    (x >> 40) as f32 / (1u64 << 24) as f32
}

struct Query {
    name: String,
    material: Material,
    wo: V3<f32>,
    wi: V3<f32>,
    u: [f32; 4],
}

/// Every case at four roughnesses, from eight directions, with directions that the lobes are likely to send light to.
fn queries() -> (Vec<Material>, Vec<(usize, Query)>) {
    let (mut materials, mut queries) = (Vec::new(), Vec::new());
    for roughness in [0.0, 0.05, 0.3, 1.0] {
        for (name, material) in cases(roughness) {
            let inputs = material.inputs().convert(|x| x as f32);
            let optics = interpret(&inputs, LobeSet::all(), 1.0f32);
            for mu in [1.0, 0.8, 0.3, 0.02, -1.0, -0.7, -0.2, -0.01] {
                let wo: V3<f32> = direction(mu, 1.1);
                let bsdf = Bsdf::prepare(&optics, LobeSet::all(), wo, Rgb([1.0, 0.7, 0.4]));
                for i in 0..12 {
                    let seed = queries.len();
                    let u = |k: u64| std::array::from_fn(|d| number(seed, k * 4 + d as u64));
                    let likely = bsdf.sample(u(1));
                    let any = direction(f64::from(2.0 * number(seed, 90) - 1.0), f64::from(6.3 * number(seed, 91)));
                    let wi = if i % 3 != 0 && likely.is_valid { likely.wi } else { any };
                    let name = format!("{name}, roughness {roughness}, cosine {mu}, query {i}");
                    queries.push((materials.len(), Query { name, material: material.clone(), wo, wi, u: u(2) }));
                }
            }
            materials.push(material);
        }
    }
    (materials, queries)
}

#[test]
fn the_whole_bsdf_agrees() {
    let (materials, queries) = queries();
    let rows = materials.iter().flat_map(|m| PROPERTIES.iter().flat_map(|def| m.value(def.id).row())).collect();
    let mut flat = Vec::with_capacity(queries.len() * QUERY);
    for (material, q) in &queries {
        flat.extend([q.wo.x, q.wo.y, q.wo.z, *material as f32, q.wi.x, q.wi.y, q.wi.z, 0.0]);
        flat.extend(q.u);
    }
    let Some(found) = compute(ENTRY, &[rows, flat], queries.len() * RESULT, queries.len()) else { return };
    let (mut compared, mut flipped) = (0, 0);
    for ((_, q), found) in queries.iter().zip(found.chunks_exact(RESULT)) {
        let optics = interpret(&q.material.inputs().convert(|x| x as f32), LobeSet::all(), 1.0f32);
        let bsdf = Bsdf::prepare(&optics, LobeSet::all(), q.wo, Rgb([1.0, 0.7, 0.4]));
        let (value, pdf) = bsdf.eval(q.wi);
        let s = bsdf.sample(q.u);
        assert!(found.iter().all(|x| x.is_finite()), "{}: {found:?}", q.name);
        // Nearly matched media divide by a difference of 1e-3, which leaves four of seven digits to each side.
        let limit = if q.name.contains("nearly matched") { 2e-2 } else { 1e-3 };
        let close = |what: &str, a: f32, b: f32, scale: f32| {
            assert!((a - b).abs() <= limit * a.abs().max(scale) + 1e-6, "{}: {what}: Rust {a}, WGSL {b}", q.name);
        };
        for c in 0..3 {
            close("value", value.0[c], found[c], value.max_channel());
        }
        close("pdf", pdf, found[3], 0.0);
        let flags = f32::from(u8::from(s.is_valid) + 2 * u8::from(s.is_delta) + 4 * u8::from(s.is_transmission));
        if flags != found[11] {
            // A number that falls on the boundary between two lobes may be rounded to either.
            flipped += 1;
            continue;
        }
        if s.is_valid {
            compared += 1;
            for c in 0..3 {
                close("weight", s.weight.0[c], found[4 + c], s.weight.max_channel());
            }
            for (a, b) in [s.wi.x, s.wi.y, s.wi.z].into_iter().zip(&found[8..11]) {
                assert!((a - b).abs() < 1e-3, "{}: direction: Rust {a}, WGSL {b}", q.name);
            }
        }
    }
    assert!(compared > queries.len() / 2, "{compared} of {} samples were compared", queries.len());
    assert!(flipped * 200 < queries.len(), "{flipped} of {} samples chose another lobe", queries.len());
}

#[test]
fn the_display_transforms_agree() {
    const ENTRY: &str = "
@group(1) @binding(0) var<storage, read_write> results: array<vec4f>;
@group(1) @binding(1) var<storage, read> colors: array<vec4f>;
@compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3u) {
    _ = albedo_tables[0];
    if id.x >= arrayLength(&colors) { return; }
    let c = colors[id.x];
    results[id.x] = vec4f(display_apply(c.xyz, 0.5, u32(c.w)), 0.0);
}
";
    let levels = [0.0f32, 1e-4, 0.02, 0.18, 0.7, 1.0, 3.0, 40.0, 1e5];
    let mut colors = Vec::new();
    for t in 0..DisplayTransform::ALL.len() {
        for r in levels {
            for g in levels {
                colors.push([r, g, 0.3 * r + 0.1, t as f32]);
            }
        }
    }
    let Some(found) = compute(ENTRY, &[colors.as_flattened().to_vec()], colors.len() * 4, colors.len()) else { return };
    for (color, found) in colors.iter().zip(found.chunks_exact(4)) {
        let display = Display { exposure_ev: 0.5, transform: DisplayTransform::ALL[color[3] as usize].0 };
        let expected = display.apply([color[0], color[1], color[2]]);
        for c in 0..3 {
            assert!((expected[c] - found[c]).abs() < 1e-3, "{display:?} of {color:?}: Rust {expected:?}, WGSL {found:?}");
        }
    }
}
