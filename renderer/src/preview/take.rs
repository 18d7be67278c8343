//! Taking a scene: finds what changed since the last one and uploads only that.

use super::device::PreviewError;
use super::environment::{self, Prefiltered};
use super::floor::Pavement;
use super::{Drawn, Light, Preview, Stage, floor, upload};
use crate::bsdf::Albedos;
use crate::scene::{Object, Scene};
use burnish_assets::{Environment, Mesh};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, channel};

/// An environment that is being filtered on a thread of its own.
#[derive(Debug)]
pub(super) struct Filtering {
    map: Arc<Environment>,
    pavement: Option<Pavement>,
    result: Receiver<Prefiltered>,
}

impl Filtering {
    fn start(map: Arc<Environment>, pavement: Option<Pavement>) -> Self {
        let (sender, result) = channel();
        let source = map.clone();
        std::thread::spawn(move || {
            // Nobody waits any more if another environment was chosen meanwhile.
            _ = sender.send(environment::prefilter(&source, pavement));
        });
        Self { map, pavement, result }
    }
}

impl Preview {
    pub(super) fn take_scene(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, scene: &Scene) -> Result<(), PreviewError> {
        self.wanted = Some(scene.clone());
        let (objects, albedos) = self.objects_with_albedos(scene);
        let scene = &Scene { objects, ..scene.clone() };
        let mut is_rebound = self.frame_bind.is_none();
        is_rebound |= self.take_stage(device, queue, scene)?;
        is_rebound |= self.take_light(device, queue, scene)?;
        let (begins, is_moved) = self.tables.hold(device, queue, &albedos)?;
        is_rebound |= is_moved;
        if self.maps.as_ref().is_none_or(|maps| !maps.are_of(&scene.objects)) {
            self.maps = Some(upload::Maps::new(device, queue, &scene.objects)?);
            self.rays.unbind();
            let Some(maps) = &self.maps else { return Ok(()) };
            for drawn in &mut self.objects {
                drawn.bind = bind_object(device, &self.pipelines.layouts.object, &drawn.block, &maps.view, &self.samplers.maps);
            }
        }
        let displaced = self.displaced(scene);
        let is_changed = self.take_objects(device, queue, scene, &displaced, &albedos, &begins)?;
        let is_same_view = self.scene.as_ref().is_some_and(|old| {
            old.camera == scene.camera
                && old.environment.rotation_deg == scene.environment.rotation_deg
                && old.environment.scale == scene.environment.scale
        });
        if is_rebound || is_changed || !is_same_view {
            self.restart();
        }
        self.scene = Some(scene.clone());
        if let (Some(light), None) = (&self.light, &self.filtering) {
            self.baker.request(&displaced, self.stage.floor.as_ref(), &light.made);
        }
        if is_rebound {
            self.bind_frame(device);
            self.rays.unbind();
        }
        Ok(())
    }

    fn take_stage(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, scene: &Scene) -> Result<bool, PreviewError> {
        // The floor's map is placed by the edited object, so that counts too; its material does not.
        let key: Vec<_> = scene
            .objects
            .iter()
            .map(|o| (o.mesh.clone(), if o.is_document { Arc::default() } else { o.material.clone() }))
            .collect();
        let is_same = key.len() == self.stage.key.len()
            && key
                .iter()
                .zip(&self.stage.key)
                .zip(&scene.objects)
                .all(|((a, b), o)| Arc::ptr_eq(&a.0, &b.0) && (o.is_document || *a.1 == *b.1));
        if is_same {
            return Ok(false);
        }
        let floor = floor::find(scene);
        // The environment was filtered for the old floor: near enough until it has been filtered for the new one.
        let radiance = match (&floor, &self.light) {
            (Some(floor), Some(light)) => floor.radiance(light.made.up, None),
            _ => vec![upload::black()],
        };
        let radiance = upload::upload_levels(device, queue, "floor radiance", &radiance)?;
        let light = upload::upload_levels(device, queue, "floor light", &[upload::black()])?;
        let black = || upload::upload_levels(device, queue, "no glow", &[upload::black()]);
        self.stage = Stage {
            key,
            floor,
            radiance,
            light,
            glow_radiance: black()?,
            glow: black()?,
            shine_radiance: black()?,
            shine: black()?,
        };
        Ok(true)
    }

    /// A new environment is filtered on a thread of its own while the old one lights the picture; only the first is waited for.
    fn take_light(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, scene: &Scene) -> Result<bool, PreviewError> {
        let map = &scene.environment.map;
        let pavement = self.stage.floor.as_ref().map(|f| f.pavement);
        if self.light.as_ref().is_some_and(|l| Arc::ptr_eq(&l.map, map) && l.pavement == pavement) {
            self.filtering = None;
            return Ok(false);
        }
        let is_first = self.light.is_none();
        let filtering = match self.filtering.take() {
            Some(filtering) if Arc::ptr_eq(&filtering.map, map) && filtering.pavement == pavement => filtering,
            _ => Filtering::start(map.clone(), pavement),
        };
        let made = if is_first { filtering.result.recv().ok() } else { filtering.result.try_recv().ok() };
        let Some(made) = made else {
            self.filtering = Some(filtering);
            return Ok(false);
        };
        if let Some(floor) = &self.stage.floor {
            self.stage.radiance = upload::upload_levels(device, queue, "floor radiance", &floor.radiance(made.up, None))?;
            self.stage.light = upload::upload_levels(device, queue, "floor light", &[upload::black()])?;
        }
        self.light = Some(Light {
            map: map.clone(),
            pavement,
            radiance: upload::upload_levels(device, queue, "environment", &made.levels)?,
            irradiance: upload::upload_levels(device, queue, "irradiance", std::slice::from_ref(&made.irradiance))?,
            made: Arc::new(made),
        });
        Ok(true)
    }

    /// Whether threads work on what the scene that was set last needs.
    pub fn is_taking(&self) -> bool {
        self.filtering.is_some() || self.filling.is_some() || self.reliefs.is_making()
    }

    /// Takes the environment that has been filtered, the albedos that have been filled and the meshes that have been displaced meanwhile,
    /// if they are ready.
    pub(super) fn take_finished(&mut self, device: &wgpu::Device, queue: &wgpu::Queue) -> Result<(), PreviewError> {
        if !self.is_taking() {
            return Ok(());
        }
        self.wanted.clone().map_or(Ok(()), |scene| self.take_scene(device, queue, &scene))
    }

    fn take_objects(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        scene: &Scene,
        displaced: &Scene,
        albedos: &[Arc<Albedos>],
        begins: &[u32],
    ) -> Result<bool, PreviewError> {
        let mut is_changed = self.objects.len() != scene.objects.len();
        let mut old: Vec<Option<Drawn>> = self.objects.drain(..).map(Some).collect();
        for (i, (object, drawn)) in scene.objects.iter().zip(&displaced.objects).enumerate() {
            let first_layer = self.maps.as_ref().and_then(|maps| maps.first_layers.get(i).copied()).unwrap_or(0);
            let same_mesh = |d: &Drawn| Arc::ptr_eq(&d.object.mesh, &object.mesh);
            // The same place first, then any: a list that got shorter keeps its uploads.
            let place = Some(i)
                .filter(|&i| old.get(i).is_some_and(|d| d.as_ref().is_some_and(same_mesh)))
                .or_else(|| old.iter().position(|d| d.as_ref().is_some_and(same_mesh)));
            let found = place.and_then(|k| old[k].take());
            let is_same = found.as_ref().is_some_and(|d| {
                Arc::ptr_eq(&d.object.textures, &object.textures)
                    && Arc::ptr_eq(&d.mesh, &drawn.mesh)
                    && d.first_layer == first_layer
                    && d.object.length_scale == object.length_scale
                    && d.begin == begins[i]
                    && Arc::ptr_eq(&d.albedos, &albedos[i])
                    && (Arc::ptr_eq(&d.object.material, &object.material) || *d.object.material == *object.material)
            });
            let drawn = match found {
                Some(drawn) if is_same => Drawn { object: object.clone(), ..drawn },
                found => {
                    is_changed = true;
                    let of_albedos = (&albedos[i], begins[i]);
                    match self.upload_object(device, queue, (object, &drawn.mesh), of_albedos, first_layer, found) {
                        Ok(drawn) => drawn,
                        Err(error) => {
                            // What was not looked at yet stays as it was.
                            self.objects.extend(old.into_iter().flatten());
                            return Err(error);
                        }
                    }
                }
            };
            self.objects.push(drawn);
        }
        Ok(is_changed)
    }

    fn upload_object(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        (object, mesh): (&Object, &Arc<Mesh>),
        (albedos, begin): (&Arc<Albedos>, u32),
        first_layer: u32,
        previous: Option<Drawn>,
    ) -> Result<Drawn, PreviewError> {
        let mut values = upload::object_block(object, begin, first_layer);
        if !Arc::ptr_eq(mesh, &object.mesh) {
            values.params[2] = upload::DISPLACED;
        }
        let (lobes, albedos, mesh) = (self.lobes_of(object), albedos.clone(), mesh.clone());
        if let Some(drawn) = previous {
            queue.write_buffer(&drawn.block, 0, bytemuck::bytes_of(&values));
            let buffers = if Arc::ptr_eq(&drawn.mesh, &mesh) {
                drawn.buffers
            } else {
                Arc::new(upload::upload_mesh(device, queue, &mesh, Some(&drawn.buffers))?)
            };
            return Ok(Drawn { object: object.clone(), mesh, lobes, albedos, begin, first_layer, buffers, values, ..drawn });
        }
        let buffers = Arc::new(upload::upload_mesh(device, queue, &mesh, None)?);
        let block = upload::filled(device, queue, "object", bytemuck::bytes_of(&values), wgpu::BufferUsages::UNIFORM)?;
        let maps = self.maps.as_ref().map(|maps| &maps.view).ok_or(PreviewError::NothingDrawn)?;
        let bind = bind_object(device, &self.pipelines.layouts.object, &block, maps, &self.samplers.maps);
        Ok(Drawn { object: object.clone(), mesh, lobes, albedos, begin, first_layer, buffers, values, block, bind })
    }

    pub(super) fn bind_frame(&mut self, device: &wgpu::Device) {
        let Some(light) = &self.light else { return };
        let view = |binding, view| wgpu::BindGroupEntry { binding, resource: wgpu::BindingResource::TextureView(view) };
        let sampler = |binding, sampler| wgpu::BindGroupEntry { binding, resource: wgpu::BindingResource::Sampler(sampler) };
        self.frame_bind = Some(device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("frame"),
            layout: &self.pipelines.layouts.frame,
            entries: &[
                wgpu::BindGroupEntry { binding: 0, resource: self.frame_buffer.as_entire_binding() },
                view(1, &light.radiance),
                sampler(2, &self.samplers.sphere),
                view(3, &light.irradiance),
                view(4, &self.stage.light),
                view(5, &self.stage.radiance),
                sampler(6, &self.samplers.floor),
                wgpu::BindGroupEntry { binding: 7, resource: self.tables.buffer.as_entire_binding() },
                view(8, &self.stage.glow),
                view(9, &self.stage.glow_radiance),
                view(10, &self.stage.shine),
                view(11, &self.stage.shine_radiance),
            ],
        }));
    }
}

fn bind_object(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    block: &wgpu::Buffer,
    maps: &wgpu::TextureView,
    sampler: &wgpu::Sampler,
) -> wgpu::BindGroup {
    device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("object"),
        layout,
        entries: &[
            wgpu::BindGroupEntry { binding: 0, resource: block.as_entire_binding() },
            wgpu::BindGroupEntry { binding: 1, resource: wgpu::BindingResource::TextureView(maps) },
            wgpu::BindGroupEntry { binding: 2, resource: wgpu::BindingResource::Sampler(sampler) },
        ],
    })
}
