//! The progressive CPU path tracer: thousands of paths per thread at a time, one depth after the other, each stage over all of them.
//!
//! Stages in order: `raygen` (camera rays), `trace` (nearest hits, walks through scattering bodies, lists by material), `shade` (emission, light connection, scattered
//! direction), `miss` (the environment), `film` (sums). `schedule` drives them over tiles and threads, `render` over passes. A stage reads
//! its queue and writes its queue.
//!
//! A path is in at most one body at a time: of bodies within bodies it keeps only the innermost one's interior.
//!
//! Height maps displace the mesh, refined to 1/128 of its radius (`displace`), and bend normals where they are finer (`detail`). Paths carry
//! cones (`cone`), by which images are read from averaged copies (`mip`).

mod adaptive;
mod aov;
mod batch;
mod bytes;
mod caustics;
mod cone;
mod convergence;
mod debug;
mod detail;
mod direct;
mod displace;
mod displaced_mesh;
mod distribution;
mod estimate;
mod explain;
mod film;
mod flat;
mod frame;
mod geometry;
mod inside;
mod irradiance;
mod light;
#[cfg(test)]
mod light_tests;
mod mip;
mod miss;
mod photon;
mod prepared;
mod raygen;
pub(crate) mod render;
mod sampler;
mod scatter;
mod schedule;
mod seen;
mod shade;
#[cfg(test)]
mod surface_tests;
#[cfg(test)]
mod tests;
mod texture;
mod trace;
mod walk;

pub use adaptive::SampleCounts;
pub use aov::{Aovs, aovs};
pub use convergence::{Convergence, ErrorPoint, Prediction};
pub use debug::{DebugProgress, DebugView, LegendEntry, SampleView, ViewDef, debug_picture, sample_picture};
pub(crate) use displace::HeightKey;
pub(crate) use displaced_mesh::displaced_mesh;
pub use estimate::ErrorEstimate;
pub use explain::{Explanation, LightLayer, LobeShare, SurfacePoint, explain, light_layers};
pub use film::{Film, REPLICATES};
pub(crate) use flat::Flat;
pub use prepared::Prepared;
pub use render::{
    Kept, KeptError, Progress, Rendering, SPP_MAX, Settings, StopReason, StopRules, Tile, render, render_prepared, render_tile,
    repeat,
};
pub use schedule::render_pass;

use crate::scene::Scene;
use displace::Relief;
use mip::Sources;

/// What a pass did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PassStats {
    /// Paths traced.
    pub samples: u64,
    /// Contributions dropped because they were infinite or not a number.
    pub nonfinite: u64,
    /// Contributions dropped because they were negative.
    pub negative: u64,
    /// Random walks through scattering bodies.
    pub walks: u64,
    /// Collisions in them.
    pub collisions: u64,
    /// Walks that the last guard against endless ones cut short: a loss of light, 0 unless something is wrong.
    pub cut_walks: u64,
}

impl PassStats {
    /// Adds the counts of another pass or thread.
    pub fn add(&mut self, other: &Self) {
        self.samples += other.samples;
        self.nonfinite += other.nonfinite;
        self.negative += other.negative;
        self.walks += other.walks;
        self.collisions += other.collisions;
        self.cut_walks += other.cut_walks;
    }

    /// Whether light may be added; counts it where it arises if not.
    #[inline(always)]
    pub(crate) fn accepts(&mut self, light: [f32; 3]) -> bool {
        if light.iter().all(|c| c.is_finite() && *c >= 0.0) {
            return true;
        }
        if light.iter().all(|c| c.is_finite()) {
            self.negative += 1;
        } else {
            self.nonfinite += 1;
        }
        false
    }
}

/// Sentences that name what the materials of a scene ask for and this renderer leaves out.
pub fn unsupported(scene: &Scene) -> Vec<String> {
    let mut sentences = Vec::new();
    for object in &scene.objects {
        let material = &object.material;
        let mut say = |what: &str| {
            let sentence = format!("{}: {what}.", if material.name.is_empty() { "material" } else { &material.name });
            if !sentences.contains(&sentence) {
                sentences.push(sentence);
            }
        };
        if let Some(what) = Relief::of(object, &mut Sources::default()).shortcoming() {
            say(what);
        }
        for (property, slot) in material.slots() {
            if let Some(texture) = &slot.texture
                && !object.textures.contains_key(&texture.path)
            {
                say(&format!("the image {} of {} is not there; its uniform value is used", texture.path, property.def().name));
            }
        }
    }
    sentences
}
