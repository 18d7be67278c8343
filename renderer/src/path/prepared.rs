//! What a scene becomes before it is rendered: one tree, tables of the light, one surface per material.

use super::batch::Batch;
use super::caustics::{Caustics, Role};
use super::detail::Bumps;
use super::direct::Connection;
use super::displace::{Relief, length_scale};
use super::geometry::Geometry;
use super::inside::Passage;
use super::light::{Light, LightTables};
use super::mip::Sources;
use super::texture::Texture;
use crate::bsdf::{Albedos, Optics, interpret};
use crate::bvh::NONE;
use crate::scene::{Camera, Object, Scene, TextureSet};
use burnish_material::{Inputs, Lobe, LobeSet, Material, Property};
use std::sync::{Arc, Mutex};

/// Microfacet alpha below which refracting surfaces count as sharp.
const SPLIT_ALPHA: f64 = 0.03;

/// An immutable scene ready for the path tracer.
#[derive(Debug)]
pub struct Prepared {
    pub(super) geometry: Arc<Geometry>,
    pub(super) light: Light,
    pub(super) surfaces: Vec<Surface>,
    pub(super) surface_of_object: Vec<u32>,
    pub(super) camera: Camera,
    pub(super) max_bounces: u32,
    /// What is around the camera.
    pub(super) camera_medium: CameraMedium,
    /// Whether any body scatters.
    pub(super) has_scattering: bool,
    /// Whether any body lets light through that it bends.
    pub(super) refracts: bool,
    /// Whether any material disperses.
    pub(super) has_dispersion: bool,
    /// How each object is connected to the light from inside; none where it is not.
    pub(super) passage_of_object: Vec<Option<Passage>>,
    /// Half the smallest extent of each object, normalised units: how far its inside is from its surface at most.
    pub(super) radius_of_object: Vec<f32>,
    /// Whether any surface lets rays pass straight through.
    pub(super) has_cut_through: bool,
    /// Whether any surface reads images.
    pub(super) has_images: bool,
    /// Whether direct light near the camera is chosen from several candidates.
    pub(super) resamples: bool,
    /// Where photons bring the light of caustics; `None` where paths from the camera bring all light.
    pub(super) caustics: Option<Caustics>,
    /// The images that surfaces and geometry read.
    sources: Sources,
    /// Buffers of threads that rest.
    pub(super) pool: Arc<Mutex<Vec<Batch>>>,
}

/// The body that the camera is in; zeros outside.
#[derive(Clone, Copy, Debug)]
pub(super) struct CameraMedium {
    /// Absorption, 1/normalised unit.
    pub sigma_a: [f32; 3],
    /// Scattering, 1/normalised unit.
    pub sigma_s: [f32; 3],
    /// Its object, or [`NONE`].
    pub object: u32,
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
    /// Tables of its albedos.
    pub albedos: Arc<Albedos>,
    /// How it is connected to the light.
    pub connection: Connection,
    /// Whether what it reflects and what it lets through are both followed where the camera sees it first: where both are sharp, the choice
    /// between them is most of the noise.
    pub splits: bool,
    /// What it is to caustics; [`Role::Other`] for all surfaces of a scene without photons.
    pub role: Role,
}

impl Surface {
    fn new<'a>(
        object: &Object,
        relief: &Relief,
        lobes: impl Fn(&Material) -> LobeSet,
        scale: f64,
        sources: &mut Sources,
        albedos: impl IntoIterator<Item = &'a Arc<Albedos>>,
    ) -> Self {
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
        let (lobes, textures) = (lobes(&object.material), Texture::all_of(object, sources));
        let varies = |property| textures.iter().any(|t| t.property == property);
        let optics: Optics<f64> = interpret(&inputs, lobes, length_scale);
        Self {
            connection: Connection::of(&optics, lobes, varies),
            splits: lobes.has(Lobe::transmission)
                && optics.alpha_x.max(optics.alpha_y) < SPLIT_ALPHA
                && !varies(Property::roughness),
            albedos: Albedos::new(&inputs, lobes, varies, albedos),
            lobes,
            textures,
            bumps,
            inputs,
            length_scale,
            images: object.textures.clone(),
            material: object.material.clone(),
            role: Role::Other,
        }
    }

    fn is_of(&self, object: &Object) -> bool {
        Arc::ptr_eq(&self.material, &object.material) && Arc::ptr_eq(&self.images, &object.textures)
    }

    /// Name of the material.
    pub(super) fn name(&self) -> &str {
        &self.material.name
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
        Self::with_lobes(scene, previous, LobeSet::EMPTY, LobeSet::EMPTY)
    }

    /// The same with other lobes than the materials need. `more` are evaluated as well: the picture is the same, and shows what leaving them
    /// out saves; [`LobeSet::all`] leaves nothing out. `less` are left out also where they are needed: what they add to the picture.
    pub fn with_lobes(scene: &Scene, previous: Option<&Self>, more: LobeSet, less: LobeSet) -> Self {
        let lobes = |material: &Material| LobeSet::of(material).union(more).minus(less);
        let mut sources = previous.map(|p| p.sources.clone()).unwrap_or_default();
        let same_geometry = previous.map(|p| &p.geometry).filter(|geometry| geometry.is_of(scene));
        let same_tables = previous.map(|p| p.light.tables()).filter(|tables| tables.is_of(&scene.environment.map));
        // What has to be made anew is made side by side.
        let (geometry, tables) = std::thread::scope(|scope| {
            let tables = same_tables.cloned().ok_or_else(|| scope.spawn(|| Arc::new(LightTables::new(&scene.environment.map))));
            let geometry = same_geometry.cloned().unwrap_or_else(|| Arc::new(Geometry::new(scene, &mut sources)));
            let tables = tables.unwrap_or_else(|thread| thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)));
            (geometry, tables)
        });
        let mut surfaces: Vec<Surface> = Vec::new();
        let mut surface_of_object = Vec::with_capacity(scene.objects.len());
        for (object, relief) in scene.objects.iter().zip(&geometry.reliefs) {
            // What another material of this or the last scene has made may fit.
            let known = previous.map_or(&[][..], |p| &p.surfaces).iter().chain(&surfaces).map(|s| &s.albedos);
            let made = Surface::new(object, relief, lobes, geometry.scale, &mut sources, known);
            let is_same = |s: &Surface| s.is_of(object) && s.length_scale == made.length_scale && s.is_bent_as(&made);
            let same = surfaces.iter().position(is_same);
            surface_of_object.push(same.unwrap_or(surfaces.len()) as u32);
            if same.is_none() {
                surfaces.push(made);
            }
        }
        let lobes = surfaces.iter().fold(LobeSet::EMPTY, |set, s| set.union(s.lobes));
        let has = |lobe| lobes.has(lobe);
        let mut camera_medium = CameraMedium { sigma_a: [0.0; 3], sigma_s: [0.0; 3], object: NONE };
        if (has(Lobe::absorption) || has(Lobe::scattering))
            && let Some(object) = geometry.object_around(geometry.normalized(scene.camera.origin))
        {
            let surface = &surfaces[surface_of_object[object as usize] as usize];
            let inputs = surface.inputs.convert(|x| x as f32);
            let optics = interpret(&inputs, surface.lobes, surface.length_scale as f32);
            camera_medium = CameraMedium { sigma_a: optics.sigma_a.0, sigma_s: optics.sigma_s.0, object };
        }
        let radius = |object: &Object| {
            let extent = f64::from(object.mesh.bounds().size().min_element()) * 0.5 * geometry.scale;
            if extent.is_finite() { extent.max(1e-6) as f32 } else { 1.0 }
        };
        sources.drop_unused();
        let light = Light::new(&scene.environment, tables);
        let is_outside = camera_medium.object == NONE;
        let roles: Vec<Role> = surfaces.iter().map(Role::of).collect();
        let caustics = Caustics::new(&geometry, |object| roles[surface_of_object[object] as usize]);
        // Bright enough light is asked for last: finding out takes the longest.
        let caustics = caustics.filter(|_| is_outside && light.has_hot());
        if caustics.is_some() {
            surfaces.iter_mut().zip(roles).for_each(|(surface, role)| surface.role = role);
        }
        if surfaces.iter().any(|surface| surface.connection.is_even(surface.lobes)) {
            light.lights_evenly();
        }
        let passages: Vec<_> = surfaces.iter().map(Passage::of).collect();
        let passage_of_object = surface_of_object.iter().map(|s| passages[*s as usize]).collect();
        Self {
            light,
            caustics,
            resamples: true,
            has_images: surfaces.iter().any(Surface::reads_images),
            sources,
            has_cut_through: has(Lobe::opacity),
            surfaces,
            surface_of_object,
            camera: scene.camera,
            max_bounces: scene.max_bounces,
            camera_medium,
            has_scattering: has(Lobe::scattering),
            refracts: has(Lobe::transmission),
            has_dispersion: has(Lobe::dispersion),
            passage_of_object,
            radius_of_object: scene.objects.iter().map(radius).collect(),
            pool: previous.map_or_else(Arc::default, |p| p.pool.clone()),
            geometry,
        }
    }

    /// Lobes that the materials of this scene need.
    pub fn lobes(&self) -> LobeSet {
        self.surfaces.iter().fold(LobeSet::EMPTY, |set, s| set.union(s.lobes))
    }

    /// The same scene without photons: all light is left to paths from the camera.
    pub fn without_photons(mut self) -> Self {
        self.caustics = None;
        self.surfaces.iter_mut().for_each(|surface| surface.role = Role::Other);
        self
    }

    /// Whether photons bring the light of caustics.
    pub fn has_photons(&self) -> bool {
        self.caustics.is_some()
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
