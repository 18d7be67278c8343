//! What a scene becomes before it is rendered: one tree, tables of the light, one surface per material.

use super::batch::Batch;
use super::evaluated_lobes;
use super::geometry::Geometry;
use super::light::{Light, LightTables};
use super::texture::Texture;
use crate::bsdf::{Albedos, interpret};
use crate::scene::{Camera, Object, Scene, TextureSet};
use burnish_material::{Inputs, Lobe, LobeSet, Material};
use std::sync::{Arc, Mutex};

/// An immutable scene ready for the path tracer.
#[derive(Debug)]
pub struct Prepared {
    pub(super) geometry: Arc<Geometry>,
    pub(super) light: Light,
    pub(super) surfaces: Vec<Surface>,
    pub(super) surface_of_object: Vec<u32>,
    pub(super) camera: Camera,
    pub(super) max_bounces: u32,
    /// Absorption around the camera, 1/normalised unit.
    pub(super) camera_sigma: [f32; 3],
    /// Whether any surface lets rays pass straight through.
    pub(super) has_cut_through: bool,
    /// Buffers of threads that rest.
    pub(super) pool: Arc<Mutex<Vec<Batch>>>,
}

/// A material as the shade stage needs it. Objects that share a material share it.
#[derive(Debug)]
pub(super) struct Surface {
    material: Arc<Material>,
    images: Arc<TextureSet>,
    /// Lobes that are evaluated.
    pub lobes: LobeSet,
    /// Uniform values.
    pub inputs: Inputs<f64>,
    /// Images that replace some of them.
    pub textures: Vec<Texture>,
    /// Normalised units per unit of the material's lengths.
    pub length_scale: f64,
    /// Tables of its albedos.
    pub albedos: Arc<Albedos>,
}

impl Surface {
    fn new<'a>(object: &Object, lobes: LobeSet, length_scale: f64, albedos: impl IntoIterator<Item = &'a Arc<Albedos>>) -> Self {
        let (lobes, inputs, textures) =
            (evaluated_lobes(&object.material, lobes), object.material.inputs(), Texture::all_of(object));
        let varies = |property| textures.iter().any(|t| t.property == property);
        Self {
            albedos: Albedos::new(&inputs, lobes, varies, albedos),
            lobes,
            inputs,
            textures,
            length_scale,
            images: object.textures.clone(),
            material: object.material.clone(),
        }
    }

    /// Normalised units per unit of the material's lengths.
    fn length_scale(object: &Object, scale: f64) -> f64 {
        let length_scale = if object.length_scale.is_finite() && object.length_scale > 0.0 { object.length_scale } else { 1.0 };
        length_scale * scale
    }

    fn is_of(&self, object: &Object) -> bool {
        Arc::ptr_eq(&self.material, &object.material) && Arc::ptr_eq(&self.images, &object.textures)
    }

    /// Whether rays may pass straight through.
    pub(super) fn has_cut_through(&self) -> bool {
        self.lobes.has(Lobe::opacity)
    }

    /// Whether the direction of the tangent matters.
    pub(super) fn needs_tangent(&self) -> bool {
        self.lobes.has(Lobe::anisotropy) || self.lobes.has(Lobe::normal_map)
    }
}

impl Prepared {
    /// Prepares a scene. What is the same as in `previous` (by identity of the shared parts) is taken from there.
    pub fn new(scene: &Scene, previous: Option<&Self>) -> Self {
        Self::with_lobes(scene, previous, LobeSet::EMPTY)
    }

    /// The same with these lobes evaluated also where a material does not need them: the picture is the same, and shows what leaving them out
    /// saves. [`LobeSet::all`] leaves nothing out.
    pub fn with_lobes(scene: &Scene, previous: Option<&Self>, lobes: LobeSet) -> Self {
        let geometry = match previous {
            Some(p) if p.geometry.is_of(scene) => p.geometry.clone(),
            _ => Arc::new(Geometry::new(scene)),
        };
        let tables = match previous {
            Some(p) if p.light.tables().is_of(&scene.environment.map) => p.light.tables().clone(),
            _ => Arc::new(LightTables::new(&scene.environment.map)),
        };
        let mut surfaces: Vec<Surface> = Vec::new();
        let mut surface_of_object = Vec::with_capacity(scene.objects.len());
        for object in &scene.objects {
            let length_scale = Surface::length_scale(object, geometry.scale);
            let same = surfaces.iter().position(|s| s.is_of(object) && s.length_scale == length_scale);
            surface_of_object.push(same.unwrap_or(surfaces.len()) as u32);
            if same.is_none() {
                // What another material of this or the last scene has made may fit.
                let known = previous.map_or(&[][..], |p| &p.surfaces).iter().chain(&surfaces);
                surfaces.push(Surface::new(object, lobes, length_scale, known.map(|s| &s.albedos)));
            }
        }
        let has_interior = |s: &Surface| s.lobes.has(Lobe::absorption);
        let camera_sigma = if surfaces.iter().any(has_interior) {
            let around = geometry.object_around(geometry.normalized(scene.camera.origin));
            around.map_or([0.0; 3], |object| {
                let surface = &surfaces[surface_of_object[object as usize] as usize];
                let inputs = surface.inputs.convert(|x| x as f32);
                interpret(&inputs, surface.lobes, surface.length_scale as f32).sigma_a.0
            })
        } else {
            [0.0; 3]
        };
        Self {
            light: Light::new(&scene.environment, tables),
            has_cut_through: surfaces.iter().any(Surface::has_cut_through),
            surfaces,
            surface_of_object,
            camera: scene.camera,
            max_bounces: scene.max_bounces,
            camera_sigma,
            pool: previous.map_or_else(Arc::default, |p| p.pool.clone()),
            geometry,
        }
    }

    /// Lobes that the materials of this scene need.
    pub fn lobes(&self) -> LobeSet {
        self.surfaces.iter().fold(LobeSet::EMPTY, |set, s| set.union(s.lobes))
    }

    /// Tables of the albedos of all materials.
    pub(crate) fn albedos(&self) -> impl Iterator<Item = &Arc<Albedos>> {
        self.surfaces.iter().map(|s| &s.albedos)
    }

    /// Buffers for one thread.
    pub(super) fn take_batch(&self) -> Batch {
        self.pool.lock().ok().and_then(|mut pool| pool.pop()).unwrap_or_default()
    }

    /// Returns them.
    pub(super) fn give_batch(&self, batch: Batch) {
        if let Ok(mut pool) = self.pool.lock() {
            pool.push(batch);
        }
    }
}
