//! What a scene becomes before it is rendered: one tree, tables of the light, one surface per material.

use super::batch::Batch;
use super::detail::Bumps;
use super::displace::{Relief, length_scale};
use super::evaluated_lobes;
use super::geometry::Geometry;
use super::light::{Light, LightTables};
use super::mip::Sources;
use super::texture::Texture;
use crate::bsdf::interpret;
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
    /// Whether any surface reads images.
    pub(super) has_images: bool,
    /// The images that surfaces and geometry read.
    sources: Sources,
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
    /// The height map, where it bends normals.
    pub bumps: Option<Bumps>,
    /// Normalised units per unit of the material's lengths.
    pub length_scale: f64,
}

impl Surface {
    fn new(object: &Object, relief: &Relief, scale: f64, sources: &mut Sources) -> Self {
        let length_scale = length_scale(object) * scale;
        let inputs = object.material.inputs();
        let bumps = match relief {
            Relief::Displaced(texture) | Relief::Bumped(texture) => Some(Bumps {
                texture: texture.clone(),
                // Larger ones bend every normal as far as they go; products with texels should stay numbers.
                scale: (inputs.height_scale * length_scale).clamp(-1e20, 1e20),
                is_displaced: matches!(relief, Relief::Displaced(_)),
            }),
            _ => None,
        };
        Self {
            lobes: evaluated_lobes(&object.material),
            textures: Texture::all_of(object, sources),
            bumps,
            inputs,
            length_scale,
            images: object.textures.clone(),
            material: object.material.clone(),
        }
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
        self.bumps.is_some() || [Lobe::anisotropy, Lobe::normal_map, Lobe::coat_normal_map].iter().any(|l| self.lobes.has(*l))
    }

    /// Whether the texture coordinate matters.
    pub(super) fn reads_images(&self) -> bool {
        !self.textures.is_empty() || self.bumps.is_some()
    }

    /// Whether the same triangles are bent alike.
    fn is_bent_as(&self, other: &Self) -> bool {
        let kind = |s: &Self| s.bumps.as_ref().map(|b| b.is_displaced);
        kind(self) == kind(other)
    }
}

impl Prepared {
    /// Prepares a scene. What is the same as in `previous` (by identity of the shared parts) is taken from there.
    pub fn new(scene: &Scene, previous: Option<&Self>) -> Self {
        let mut sources = previous.map(|p| p.sources.clone()).unwrap_or_default();
        let geometry = match previous {
            Some(p) if p.geometry.is_of(scene) => p.geometry.clone(),
            _ => Arc::new(Geometry::new(scene, &mut sources)),
        };
        let tables = match previous {
            Some(p) if p.light.tables().is_of(&scene.environment.map) => p.light.tables().clone(),
            _ => Arc::new(LightTables::new(&scene.environment.map)),
        };
        let mut surfaces: Vec<Surface> = Vec::new();
        let mut surface_of_object = Vec::with_capacity(scene.objects.len());
        for (object, relief) in scene.objects.iter().zip(&geometry.reliefs) {
            let made = Surface::new(object, relief, geometry.scale, &mut sources);
            let is_same = |s: &Surface| s.is_of(object) && s.length_scale == made.length_scale && s.is_bent_as(&made);
            let same = surfaces.iter().position(is_same);
            surface_of_object.push(same.unwrap_or(surfaces.len()) as u32);
            if same.is_none() {
                surfaces.push(made);
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
        sources.drop_unused();
        Self {
            light: Light::new(&scene.environment, tables),
            has_images: surfaces.iter().any(Surface::reads_images),
            sources,
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
