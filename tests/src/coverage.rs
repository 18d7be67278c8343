//! Pictures whose true error is known, to judge estimates of it by.

use burnish_assets::{make_environment, make_shape};
use burnish_renderer::path::{ErrorEstimate, Film, Prepared, Settings, StopReason, StopRules, render_prepared};
use burnish_renderer::scene::{EnvironmentLight, ModelMeshes, Scene};
use std::sync::Arc;
use std::time::Instant;

/// Preset, shape and environment.
pub type Situation = (&'static str, &'static str, &'static str);

/// Situations of every kind: matt and polished, metal and glass, soft and hard light, with and without caustics and scattering.
pub const SITUATIONS: [Situation; 20] = [
    ("porcelain-glazed", "shader-ball", "studio"),
    ("gold-polished", "shader-ball", "studio"),
    ("ruby", "shader-ball", "studio"),
    ("gold-polished", "sphere", "sun"),
    ("frosted-glass", "rounded-cube", "studio"),
    ("velvet-crimson", "cloth", "overcast"),
    ("car-paint-metallic-blue", "shader-ball", "sun"),
    ("diamond", "sphere", "sun"),
    ("aluminium-brushed", "torus", "studio"),
    ("lager-beer", "sphere", "studio"),
    ("chromium-plate", "shader-ball", "sun"),
    ("concrete", "rounded-cube", "sun"),
    ("window-glass-clear", "shader-ball", "overcast"),
    ("moulded-plastic-red", "torus", "sun"),
    ("grey-card", "plane", "studio"),
    ("walnut-lacquered", "sphere", "overcast"),
    ("candy-lacquer-red", "shader-ball", "studio"),
    ("candle-wax", "sphere", "studio"),
    ("skin-light", "sphere", "sun"),
    ("copper-polished", "cloth", "overcast"),
];

/// The scene of a situation.
///
/// # Panics
/// If the preset, shape or environment does not exist.
pub fn scene((preset, shape, environment): Situation) -> Scene {
    let preset = burnish_presets::find(preset).expect("a preset of the library");
    let material = Arc::new(preset.parse().expect("presets are valid").0.material().clone());
    let model = ModelMeshes::from(make_shape(shape).expect("a built-in shape"));
    let map = Arc::new(make_environment(environment).expect("a built-in environment"));
    let light = EnvironmentLight { map, rotation_deg: 0.0, scale: 1.0 };
    Scene::of_model(&model, material, Arc::default(), light, model.unit_mm)
}

/// A picture of a scene with its expected remaining error: mean and variance of a long render.
pub struct Reference {
    mean: Vec<[f32; 3]>,
    variance: Vec<[f32; 3]>,
}

impl Reference {
    /// Renders it with a seed of its own.
    pub fn new(prepared: &Prepared, size: usize, spp: u32) -> Self {
        let stop = StopRules { spp: Some(spp), ..StopRules::default() };
        let film = render_prepared(prepared, &settings(size, 0x5eed, stop, true), Instant::now(), &mut |_| true).film;
        Self { mean: film.mean(), variance: film.variance() }
    }

    /// relMSE of a picture, less what the reference itself contributes.
    pub fn relmse(&self, film: &Film) -> f64 {
        let mean = film.mean();
        let pixels = mean.iter().zip(&self.mean).zip(&self.variance);
        let terms = pixels.flat_map(|((m, r), v)| {
            std::array::from_fn::<f64, 3, _>(|k| {
                let (m, r, v) = (f64::from(m[k]), f64::from(r[k]), f64::from(v[k]));
                ((m - r).powi(2) - v) / (r * r + 0.01)
            })
        });
        terms.sum::<f64>() / (3 * mean.len()) as f64
    }
}

/// What is told and what is true.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    /// Samples per pixel.
    pub spp: u32,
    /// The estimate.
    pub told: ErrorEstimate,
    /// The error.
    pub truth: f64,
}

impl Case {
    /// Whether the true error lies in the interval.
    pub fn is_inside(&self) -> bool {
        self.told.low <= self.truth && self.truth <= self.told.high
    }

    /// Factor that the interval spans.
    pub fn span(&self) -> f64 {
        self.told.high / self.told.low
    }
}

fn settings(size: usize, seed: u64, stop: StopRules, is_adaptive: bool) -> Settings {
    Settings { width: size, height: size, seed, threads: 2, stop, is_adaptive }
}

/// Renders to the last of some powers of two of samples, and judges the estimate at each of them.
pub fn cases(prepared: &Prepared, reference: &Reference, size: usize, seed: u64, spps: &[u32], is_adaptive: bool) -> Vec<Case> {
    let stop = StopRules { spp: spps.last().copied(), ..StopRules::default() };
    let mut cases: Vec<Case> = Vec::new();
    render_prepared(prepared, &settings(size, seed, stop, is_adaptive), Instant::now(), &mut |progress| {
        let spp = progress.film.spp();
        if let Some(told) = progress.error
            && spps.contains(&spp)
        {
            cases.push(Case { spp, told, truth: reference.relmse(progress.film) });
        }
        true
    });
    cases
}

/// Renders until the estimate says that a target is reached, or to a limit of samples.
pub fn stopped(
    prepared: &Prepared,
    reference: &Reference,
    size: usize,
    relmse: f64,
    spp_max: u32,
    is_adaptive: bool,
) -> (StopReason, u32, f64) {
    let stop = StopRules { relmse: Some(relmse), spp: Some(spp_max), seconds: None };
    let rendering = render_prepared(prepared, &settings(size, 3, stop, is_adaptive), Instant::now(), &mut |_| true);
    (rendering.stop_reason, rendering.film.spp(), reference.relmse(&rendering.film))
}
