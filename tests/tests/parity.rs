//! Do the WGSL twins compute what the Rust lobes compute? Run on the adapter, through the same sources that draw.

#![allow(clippy::needless_range_loop, reason = "a channel indexes several arrays at once")]

use burnish_material::{Lobe, LobeSet, Material, PROPERTIES, Property};
use burnish_renderer::bsdf::dispersion::spectrum;
use burnish_renderer::bsdf::{Albedos, View, Wavelength};
use burnish_renderer::preview::albedo_table_values;
use burnish_renderer::tonemap::{Display, DisplayTransform};
use burnish_renderer::vector::{Rgb, V3};
use burnish_tests::gpu::compute;
use burnish_tests::materials::{c, cases, f, material, random};
use burnish_tests::quadrature::direction;
use burnish_tests::surface::Surface;
use std::sync::Arc;

/// Per query: `wo` and the material's number, `wi` and the begin of its albedos, `u`, the coat's normal (0 without) and the
/// wavelength (0 without), the weights of its channels and whether the path is of that wavelength.
const QUERY: usize = 20;
/// Per result: value and pdf, weight and pdf, direction and flags.
const RESULT: usize = 12;
/// Largest relative difference.
const LIMIT: f32 = 1e-3;

const ENTRY: &str = "
struct Query {
    wo: vec3f, material: f32, wi: vec3f, albedos: f32, u: vec4f,
    coat_normal: vec3f, nm: f32, weights: vec3f, is_dispersed: f32,
}
struct Result { value: vec3f, pdf: f32, weight: vec3f, sample_pdf: f32, wi: vec3f, flags: f32 }
@group(1) @binding(0) var<storage, read_write> results: array<Result>;
@group(1) @binding(1) var<storage, read> materials: array<MaterialRows>;
@group(1) @binding(2) var<storage, read> queries: array<Query>;
@compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= arrayLength(&queries) { return; }
    let q = queries[id.x];
    var optics = interpret(inputs_from_rows(materials[u32(q.material)]), 1.0);
    optics.albedos = u32(q.albedos);
    var view = view_new(q.wo);
    view.throughput = vec3f(1.0, 0.7, 0.4);
    view.has_coat_normal = q.coat_normal.z > 0.0;
    view.coat_normal = q.coat_normal;
    view.has_light = q.nm > 0.0;
    view.nm = q.nm;
    view.weights = q.weights;
    view.is_dispersed = q.is_dispersed > 0.5;
    let bsdf = bsdf_prepare(optics, view);
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

/// A material, its tables, and what a path may bring.
struct Case {
    name: String,
    material: Material,
    albedos: Arc<Albedos>,
    coat_normal: Option<V3<f32>>,
    light: Option<Wavelength<f32>>,
}

impl Case {
    /// Tables that hold everything, with no more axes than the material needs.
    fn new(name: String, material: Material, varies: &[Property]) -> Self {
        let needed = LobeSet::of(&material);
        let lobes = [Lobe::dispersion, Lobe::anisotropy]
            .into_iter()
            .filter(|lobe| !needed.has(*lobe))
            .fold(LobeSet::all(), LobeSet::without);
        let inputs = material.inputs().convert(|x| f64::from(x as f32));
        let albedos = Albedos::new(&inputs, lobes, |p| varies.contains(&p), []);
        Self { name, material, albedos, coat_normal: None, light: None }
    }
}

fn all_cases() -> Vec<Case> {
    use Property::*;
    let mut all = Vec::new();
    for rough in [0.0, 0.05, 0.3, 1.0] {
        for (name, material) in cases(rough) {
            all.push(Case::new(format!("{name}, roughness {rough}"), material, &[]));
        }
    }
    all.extend((0..24).map(|i| Case::new(format!("random {i}"), random(i), &[])));
    // Tables over numbers that images vary.
    let varied = material(&[
        (base_color, c(0.9, 0.6, 0.3)),
        (metallic, f(0.4)),
        (translucency, f(0.3)),
        (roughness, f(0.43)),
        (anisotropy, f(0.61)),
        (specular_level, f(0.37)),
        (coat, f(0.77)),
        (coat_roughness, f(0.29)),
        (coat_specular_level, f(0.81)),
    ]);
    let sets = [&[roughness][..], &[coat_roughness, anisotropy], &[roughness, specular_level, coat, coat_specular_level]];
    all.extend(sets.into_iter().map(|set| Case::new(format!("varied by {} images", set.len()), varied.clone(), set)));
    // A coat with a normal of its own.
    for rough in [0.0, 0.4] {
        let below = [(translucency, 1.0), (metallic, 1.0), (sheen, 0.5)];
        for (property, x) in below {
            let m = material(&[
                (coat, f(0.8)),
                (coat_roughness, f(rough)),
                (coat_color, c(0.9, 0.6, 0.2)),
                (property, f(x)),
                (specular_ior, f(1.7)),
            ]);
            for n in [V3::new(0.3, -0.2, 1.0), V3::new(-0.9, 0.4, 0.3)] {
                let name = format!("coat of roughness {rough} with a normal of its own, {} below", property.def().name);
                all.push(Case { coat_normal: Some(n.normalize()), ..Case::new(name, m.clone(), &[]) });
            }
        }
    }
    // Light of one wavelength, before and after it has refracted.
    for (rough, ior) in [(0.0, 1.5), (0.3, 1.8), (0.6, 0.8)] {
        let values = [(translucency, f(0.9)), (dispersion, f(6.0)), (roughness, f(rough)), (specular_ior, f(ior))];
        for (nm, is_dispersed) in [(400.0, false), (460.5, true), (700.0, true), (601.0, false)] {
            let light = Wavelength { nm: nm as f32, weights: Rgb(spectrum().weights(nm)), is_dispersed };
            let name = format!("dispersive glass, roughness {rough}, IOR {ior}, {nm} nm, dispersed {is_dispersed}");
            all.push(Case { light: Some(light), ..Case::new(name, material(&values), &[]) });
        }
    }
    all
}

struct Query {
    name: String,
    case: usize,
    view: View<f32>,
    wi: V3<f32>,
    u: [f32; 4],
}

/// Every case from eight directions, with directions that the lobes are likely to send light to.
fn queries(all: &[Case], surfaces: &[Surface<f32>]) -> Vec<Query> {
    let mut queries = Vec::new();
    for (case, (given, surface)) in all.iter().zip(surfaces).enumerate() {
        for mu in [1.0, 0.8, 0.3, 0.02, -1.0, -0.7, -0.2, -0.01] {
            let wo: V3<f32> = direction(mu, 1.1);
            let view = View { wo, throughput: Rgb([1.0, 0.7, 0.4]), coat_normal: given.coat_normal, light: given.light };
            let bsdf = surface.bsdf(&view);
            for i in 0..12 {
                let seed = queries.len();
                let u = |k: u64| std::array::from_fn(|d| number(seed, k * 4 + d as u64));
                let likely = bsdf.sample(u(1));
                let any = direction(f64::from(2.0 * number(seed, 90) - 1.0), f64::from(6.3 * number(seed, 91)));
                let wi = if i % 3 != 0 && likely.is_valid { likely.wi } else { any };
                let name = format!("{}, cosine {mu}, query {i}", given.name);
                queries.push(Query { name, case, view, wi, u: u(2) });
            }
        }
    }
    queries
}

#[test]
fn the_whole_bsdf_agrees() {
    let all = all_cases();
    let surfaces: Vec<Surface<f32>> =
        all.iter().map(|case| Surface::with(&case.material, LobeSet::all(), case.albedos.clone())).collect();
    let queries = queries(&all, &surfaces);
    let rows = all.iter().flat_map(|case| PROPERTIES.iter().flat_map(|def| case.material.value(def.id).row())).collect();
    let (tables, begins) = albedo_table_values(all.iter().map(|case| case.albedos.as_ref()));
    let mut flat = Vec::with_capacity(queries.len() * QUERY);
    for q in &queries {
        let (wo, n) = (q.view.wo, q.view.coat_normal.unwrap_or(V3::new(0.0, 0.0, 0.0)));
        flat.extend([wo.x, wo.y, wo.z, q.case as f32, q.wi.x, q.wi.y, q.wi.z, begins[q.case] as f32]);
        flat.extend(q.u);
        flat.extend([n.x, n.y, n.z]);
        match q.view.light {
            Some(light) => {
                flat.push(light.nm);
                flat.extend(light.weights.0);
                flat.push(f32::from(u8::from(light.is_dispersed)));
            }
            None => flat.extend([0.0; 5]),
        }
    }
    let Some(found) = compute(ENTRY, &tables, &[rows, flat], queries.len() * RESULT, queries.len()) else { return };
    let (mut compared, mut flipped) = (0, 0);
    let mut worst = (0.0, String::new());
    for (q, found) in queries.iter().zip(found.chunks_exact(RESULT)) {
        let bsdf = surfaces[q.case].bsdf(&q.view);
        let (value, pdf) = bsdf.eval(q.wi);
        let s = bsdf.sample(q.u);
        assert!(found.iter().all(|x| x.is_finite()), "{}: {found:?}", q.name);
        let mut close = |what: &str, a: f32, b: f32, scale: f32| {
            let share = ((a - b).abs() - 1e-6) / a.abs().max(scale).max(1e-6);
            if share > worst.0 {
                worst = (share, format!("{}: {what}: Rust {a}, WGSL {b}", q.name));
            }
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
    println!(
        "{} queries, {compared} samples compared, {flipped} chose another lobe, largest difference {worst:?}",
        queries.len()
    );
    assert!(worst.0 <= LIMIT, "{worst:?}");
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
    let Some(found) = compute(ENTRY, &[0.0], &[colors.as_flattened().to_vec()], colors.len() * 4, colors.len()) else { return };
    for (color, found) in colors.iter().zip(found.chunks_exact(4)) {
        let display = Display { exposure_ev: 0.5, transform: DisplayTransform::ALL[color[3] as usize].0 };
        let expected = display.apply([color[0], color[1], color[2]]);
        for c in 0..3 {
            assert!((expected[c] - found[c]).abs() < 1e-3, "{display:?} of {color:?}: Rust {expected:?}, WGSL {found:?}");
        }
    }
}
