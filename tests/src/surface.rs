//! A material with all that its BSDF needs, at one precision.

use burnish_material::{LobeSet, Material};
use burnish_renderer::bsdf::{Albedos, Bsdf, Optics, View, interpret};
use burnish_renderer::lanes::Lanes;
use std::sync::Arc;

/// A uniform material, interpreted. Its numbers are rounded to single precision first, so that all precisions see the same ones.
#[derive(Debug)]
pub struct Surface<L: Lanes> {
    /// What the lobes read.
    pub optics: Optics<L>,
    /// Its tables.
    pub albedos: Arc<Albedos>,
    /// Lobes that are evaluated.
    pub lobes: LobeSet,
}

impl<L: Lanes> Surface<L> {
    /// The material with the lobes that it needs.
    pub fn new(material: &Material) -> Self {
        let lobes = LobeSet::of(material);
        let albedos = Albedos::uniform(&material.inputs().convert(|x| f64::from(x as f32)), lobes);
        Self::with(material, lobes, albedos)
    }

    /// The material with these lobes and tables.
    pub fn with(material: &Material, lobes: LobeSet, albedos: Arc<Albedos>) -> Self {
        let inputs = material.inputs().convert(|x| L::of(f64::from(x as f32)));
        Self { optics: interpret(&inputs, lobes, L::one()), albedos, lobes }
    }

    /// Seen this way.
    pub fn bsdf(&self, view: &View<L>) -> Bsdf<'_, L> {
        Bsdf::prepare(&self.optics, &self.albedos, self.lobes, view)
    }
}
