//! The progressive CPU path tracer: thousands of paths per thread at a time, one depth after the other, each stage over all of them.
//!
//! Stages in order: `raygen` (camera rays), `trace` (nearest hits, lists by material), `shade` (emission, light connection, scattered
//! direction), `miss` (the environment), `film` (sums). `schedule` drives them over tiles and threads, `render` over passes. A stage reads
//! its queue and writes its queue.
//!
//! Left out so far, and named by [`unsupported`]: random walks in the body, dispersion, a coat with its own normals. A path is in at
//! most one body at a time: bodies within bodies keep only the innermost one's absorption.
//!
//! Height maps displace the mesh, refined to 1/128 of its radius (`displace`), and bend normals where they are finer (`detail`). Paths carry
//! cones (`cone`), by which images are read from averaged copies (`mip`).

mod aov;
mod batch;
mod cone;
mod detail;
mod displace;
mod film;
mod frame;
mod geometry;
mod light;
mod mip;
mod miss;
mod prepared;
mod raygen;
pub(crate) mod render;
mod sampler;
mod schedule;
mod shade;
#[cfg(test)]
mod surface_tests;
#[cfg(test)]
mod tests;
mod texture;
mod trace;

pub use aov::{Aovs, aovs};
pub use film::{ErrorEstimate, Film, REPLICATES};
pub use prepared::Prepared;
pub use render::{Progress, Rendering, SPP_MAX, Settings, StopReason, StopRules, render};
pub use schedule::render_pass;

use crate::scene::Scene;
use burnish_material::{Lobe, LobeSet, Material};
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
}

impl PassStats {
    /// Adds the counts of another pass or thread.
    pub fn add(&mut self, other: &Self) {
        self.samples += other.samples;
        self.nonfinite += other.nonfinite;
        self.negative += other.negative;
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

/// Lobes that this renderer does not have, and what it draws instead.
const LEFT_OUT: [(Lobe, &str); 3] = [
    (Lobe::scattering, "scattering in the body is left out; light passes it as if it were clear"),
    (Lobe::dispersion, "dispersion is left out; all colours refract alike"),
    (Lobe::coat_normal_map, "the coat's normal map is left out; the coat follows the surface"),
];

/// The lobes of a material that this renderer evaluates.
pub fn evaluated_lobes(material: &Material) -> LobeSet {
    LEFT_OUT.iter().fold(LobeSet::of(material), |set, (lobe, _)| set.without(*lobe))
}

/// Sentences that name what the materials of a scene ask for and this renderer leaves out.
pub fn unsupported(scene: &Scene) -> Vec<String> {
    let mut sentences = Vec::new();
    for object in &scene.objects {
        let material = &object.material;
        let lobes = LobeSet::of(material);
        let mut say = |what: &str| {
            let sentence = format!("{}: {what}.", if material.name.is_empty() { "material" } else { &material.name });
            if !sentences.contains(&sentence) {
                sentences.push(sentence);
            }
        };
        for (lobe, what) in LEFT_OUT {
            if lobes.has(lobe) {
                say(what);
            }
        }
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
