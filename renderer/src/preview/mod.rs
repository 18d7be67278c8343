//! The live preview: the same scene, camera and lobes as the path tracer, drawn by rasterising, in a few milliseconds.
//!
//! Each frame draws the meshes once more with a shifted picture and new sample directions, and the mean of all frames is
//! shown. The first frame stands alone: it has no noise, because all pixels share their directions and each
//! direction sees the light averaged over its share of the sphere. Exposure and display transform act on the mean and restart
//! nothing. The material's values live in one uniform block; its lobe set chooses the pipeline.
//!
//! What is approximated, and what that changes:
//!
//! * Bounces. Objects see the environment, the floor with its light map, and soft shapes of what is near (nine spherical
//!   harmonics per vertex); they do not see sharp images of themselves, of the stand or of each other.
//! * Colour does not bleed from the object to the floor, and no caustics appear: the object only darkens the floor.
//! * Diffuse light comes from irradiance: the coupling with the reflecting interface takes its mean over directions, which is
//!   exact under even light and off by a few percent of the diffuse part elsewhere.
//! * Refraction goes through a sphere in the place of the body (tangent to it where light enters), with all inner reflections in
//!   one chain; a rough exit is blurred instead of sampled.
//! * Opacity blends back faces, then front faces, of each object in order of distance; bodies behind a refracting one are not seen through it.
//! * The first frames average light over the share of each sample, which softens reflections of small lights; the share
//!   shrinks as frames add up.
//! * Left out: scattering in the body, dispersion, height, the normal map of the coat (the coat follows the surface).

mod bake;
mod device;
mod environment;
mod floor;
mod pipelines;
mod shader;
mod targets;
mod upload;

pub use device::{PreviewError, device_descriptor, headless_device};
pub use shader::{albedo_table_values, twin_shader};

use crate::scene::{Object, Scene};
use crate::tonemap::Display;
use bake::Baker;
use burnish_assets::{Environment, Mesh};
use burnish_material::{LobeSet, Material};
use device::guarded;
use environment::Prefiltered;
use floor::Floor;
use glam::{Vec2, Vec3};
use pipelines::{PipelineKind, Pipelines};
use std::sync::Arc;
use targets::Targets;
use upload::{FrameBlock, MeshBuffers};
use wgpu::util::DeviceExt;

/// Pictures that the first frame is the mean of, at most: they stand in for anti-aliasing.
const TAPS_MAX: u32 = 4;
/// Pictures after which nothing visible changes any more.
const STEPS_MAX: u32 = 64;

/// How frames are made.
#[derive(Clone, Copy, Debug)]
struct First {
    /// Pictures, at most [`TAPS_MAX`].
    taps: u32,
    /// Samples per lobe in each.
    samples: u32,
    /// Samples per lobe in each picture that follows.
    later: u32,
}

impl First {
    /// A software adapter takes as long for the vertices as for everything else: one picture there, four elsewhere.
    fn on(device: &wgpu::Device) -> Self {
        match device.adapter_info().device_type {
            wgpu::DeviceType::Cpu => Self { taps: 1, samples: 4, later: 4 },
            _ => Self { taps: TAPS_MAX, samples: 4, later: 8 },
        }
    }
}

/// The preview of one scene. Needs a device and a queue, and no window.
#[derive(Debug)]
pub struct Preview {
    pipelines: Pipelines,
    samplers: Samplers,
    tables: wgpu::Buffer,
    frame_blocks: Vec<wgpu::Buffer>,
    frame_binds: Vec<wgpu::BindGroup>,
    output_blocks: Vec<wgpu::Buffer>,
    scene: Option<Scene>,
    light: Option<Light>,
    stage: Stage,
    objects: Vec<Drawn>,
    baker: Baker,
    targets: Option<Targets>,
    /// Pictures in the mean so far.
    steps: u32,
    /// The picture in the mean was drawn with a pipeline that did not fit.
    is_provisional: bool,
    first: First,
    error: Option<PreviewError>,
}

#[derive(Debug)]
struct Samplers {
    sphere: wgpu::Sampler,
    floor: wgpu::Sampler,
    maps: wgpu::Sampler,
}

/// The environment on the device.
#[derive(Debug)]
struct Light {
    map: Arc<Environment>,
    floor_albedo: Option<Vec3>,
    made: Arc<Prefiltered>,
    radiance: wgpu::TextureView,
    irradiance: wgpu::TextureView,
}

/// The floor on the device, and the meshes and materials that it was made from.
#[derive(Debug)]
struct Stage {
    key: Vec<(Arc<Mesh>, Arc<Material>)>,
    floor: Option<Floor>,
    /// Radiance of the floor, as reflections see it; needs the environment.
    radiance: wgpu::TextureView,
    /// Irradiance that the floor gains or loses.
    light: wgpu::TextureView,
}

/// One object on the device.
#[derive(Debug)]
struct Drawn {
    object: Object,
    lobes: LobeSet,
    buffers: Arc<MeshBuffers>,
    block: wgpu::Buffer,
    maps: wgpu::TextureView,
    bind: wgpu::BindGroup,
}

impl Drawn {
    fn kind(&self) -> PipelineKind {
        PipelineKind { lobes: self.lobes, is_floor: floor::is_floor(&self.object) }
    }
}

impl Preview {
    /// Compiles the passes that every picture needs. Takes some tens of milliseconds.
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue) -> Result<Self, PreviewError> {
        let pipelines = Pipelines::new(device)?;
        let blocks = |label, size: usize| {
            (0..TAPS_MAX + 1)
                .map(|_| {
                    device.create_buffer(&wgpu::BufferDescriptor {
                        label: Some(label),
                        size: size as u64,
                        usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
                        mapped_at_creation: false,
                    })
                })
                .collect()
        };
        let (frame_blocks, output_blocks) = guarded(device, wgpu::ErrorFilter::OutOfMemory, PreviewError::Memory, || {
            (blocks("frame", size_of::<FrameBlock>()), blocks("output", 16))
        })?;
        let tables = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("albedo tables"),
            contents: bytemuck::cast_slice(&albedo_table_values()),
            usage: wgpu::BufferUsages::STORAGE,
        });
        let black = || upload::upload_levels(device, queue, "no floor", &[upload::black()]);
        let stage = Stage { key: Vec::new(), floor: None, radiance: black()?, light: black()? };
        Ok(Self {
            pipelines,
            samplers: Samplers::new(device),
            tables,
            frame_blocks,
            frame_binds: Vec::new(),
            output_blocks,
            scene: None,
            light: None,
            stage,
            objects: Vec::new(),
            baker: Baker::default(),
            targets: None,
            steps: 0,
            is_provisional: false,
            first: First::on(device),
            error: None,
        })
    }

    /// Takes a scene: uploads what changed and starts the picture anew if anything did.
    ///
    /// Meshes, maps and environments count as unchanged where their `Arc`s are the same. An error is kept and returned by
    /// [`Preview::error`]; what could be taken is drawn.
    pub fn set_scene(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, scene: &Scene) {
        match self.take_scene(device, queue, scene) {
            Ok(()) => self.error = None,
            Err(e) => self.error = Some(e),
        }
    }

    /// What went wrong last, if the picture is not what it should be.
    pub fn error(&self) -> Option<&PreviewError> {
        self.error.as_ref()
    }

    /// Whether occlusion is still being computed, or a pipeline compiled: the picture will still change.
    pub fn is_settling(&self) -> bool {
        self.baker.is_busy() || self.pipelines.is_waiting()
    }

    /// Pictures in the mean so far.
    pub fn steps(&self) -> u32 {
        self.steps
    }

    fn take_scene(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, scene: &Scene) -> Result<(), PreviewError> {
        let mut is_rebound = self.frame_binds.is_empty();
        is_rebound |= self.take_stage(device, queue, scene)?;
        is_rebound |= self.take_light(device, queue, scene)?;
        let is_changed = self.take_objects(device, queue, scene)?;
        let is_same_view = self.scene.as_ref().is_some_and(|old| {
            old.camera == scene.camera
                && old.environment.rotation_deg == scene.environment.rotation_deg
                && old.environment.scale == scene.environment.scale
        });
        if is_rebound || is_changed || !is_same_view {
            self.steps = 0;
        }
        self.scene = Some(scene.clone());
        if let Some(light) = &self.light {
            self.baker.request(scene, self.stage.floor.as_ref(), &light.made);
        }
        if is_rebound {
            self.bind_frame(device);
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
        let black = |label| upload::upload_levels(device, queue, label, &[upload::black()]);
        self.stage = Stage { key, floor: floor::find(scene), radiance: black("floor radiance")?, light: black("floor light")? };
        // The environment was filtered for the old floor.
        self.light = None;
        Ok(true)
    }

    fn take_light(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, scene: &Scene) -> Result<bool, PreviewError> {
        let floor_albedo = self.stage.floor.as_ref().map(|f| f.mean);
        if self.light.as_ref().is_some_and(|l| Arc::ptr_eq(&l.map, &scene.environment.map) && l.floor_albedo == floor_albedo) {
            return Ok(false);
        }
        let made = environment::prefilter(&scene.environment.map, floor_albedo);
        if let Some(floor) = &self.stage.floor {
            self.stage.radiance = upload::upload_levels(device, queue, "floor radiance", &floor.radiance(made.up, None))?;
            self.stage.light = upload::upload_levels(device, queue, "floor light", &[upload::black()])?;
        }
        self.light = Some(Light {
            map: scene.environment.map.clone(),
            floor_albedo,
            radiance: upload::upload_levels(device, queue, "environment", &made.levels)?,
            irradiance: upload::upload_levels(device, queue, "irradiance", std::slice::from_ref(&made.irradiance))?,
            made: Arc::new(made),
        });
        Ok(true)
    }

    fn take_objects(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, scene: &Scene) -> Result<bool, PreviewError> {
        let mut is_changed = self.objects.len() != scene.objects.len();
        let mut old: Vec<Option<Drawn>> = self.objects.drain(..).map(Some).collect();
        for (i, object) in scene.objects.iter().enumerate() {
            let same_mesh = |d: &Drawn| Arc::ptr_eq(&d.object.mesh, &object.mesh);
            // The same place first, then any: a list that got shorter keeps its uploads.
            let place = Some(i)
                .filter(|&i| old.get(i).is_some_and(|d| d.as_ref().is_some_and(same_mesh)))
                .or_else(|| old.iter().position(|d| d.as_ref().is_some_and(same_mesh)));
            let found = place.and_then(|k| old[k].take());
            let is_same = found.as_ref().is_some_and(|d| {
                Arc::ptr_eq(&d.object.textures, &object.textures)
                    && d.object.length_scale == object.length_scale
                    && (Arc::ptr_eq(&d.object.material, &object.material) || *d.object.material == *object.material)
            });
            let drawn = match found {
                Some(drawn) if is_same => Drawn { object: object.clone(), ..drawn },
                found => {
                    is_changed = true;
                    self.upload_object(device, queue, object, found)?
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
        object: &Object,
        previous: Option<Drawn>,
    ) -> Result<Drawn, PreviewError> {
        let block = upload::object_block(object);
        let lobes = LobeSet::of(&object.material);
        if let Some(mut drawn) = previous {
            queue.write_buffer(&drawn.block, 0, bytemuck::bytes_of(&block));
            let slots = |o: &Object| o.material.slots().map(|(_, s)| s.texture.clone()).collect::<Vec<_>>();
            if !Arc::ptr_eq(&drawn.object.textures, &object.textures) || slots(&drawn.object) != slots(object) {
                drawn.maps = upload::upload_maps(device, queue, object)?;
                drawn.bind = self.bind_object(device, &drawn.block, &drawn.maps);
            }
            drawn.object = object.clone();
            drawn.lobes = lobes;
            return Ok(drawn);
        }
        let buffers = Arc::new(upload::upload_mesh(device, &object.mesh)?);
        let block = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("object"),
            contents: bytemuck::bytes_of(&block),
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
        });
        let maps = upload::upload_maps(device, queue, object)?;
        let bind = self.bind_object(device, &block, &maps);
        Ok(Drawn { object: object.clone(), lobes, buffers, block, maps, bind })
    }

    fn bind_object(&self, device: &wgpu::Device, block: &wgpu::Buffer, maps: &wgpu::TextureView) -> wgpu::BindGroup {
        device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("object"),
            layout: &self.pipelines.layouts.object,
            entries: &[
                wgpu::BindGroupEntry { binding: 0, resource: block.as_entire_binding() },
                wgpu::BindGroupEntry { binding: 1, resource: wgpu::BindingResource::TextureView(maps) },
                wgpu::BindGroupEntry { binding: 2, resource: wgpu::BindingResource::Sampler(&self.samplers.maps) },
            ],
        })
    }

    fn bind_frame(&mut self, device: &wgpu::Device) {
        let Some(light) = &self.light else { return };
        let view = |binding, view| wgpu::BindGroupEntry { binding, resource: wgpu::BindingResource::TextureView(view) };
        let sampler = |binding, sampler| wgpu::BindGroupEntry { binding, resource: wgpu::BindingResource::Sampler(sampler) };
        self.frame_binds = self
            .frame_blocks
            .iter()
            .map(|block| {
                device.create_bind_group(&wgpu::BindGroupDescriptor {
                    label: Some("frame"),
                    layout: &self.pipelines.layouts.frame,
                    entries: &[
                        wgpu::BindGroupEntry { binding: 0, resource: block.as_entire_binding() },
                        view(1, &light.radiance),
                        sampler(2, &self.samplers.sphere),
                        view(3, &light.irradiance),
                        view(4, &self.stage.light),
                        view(5, &self.stage.radiance),
                        sampler(6, &self.samplers.floor),
                        wgpu::BindGroupEntry { binding: 7, resource: self.tables.as_entire_binding() },
                    ],
                })
            })
            .collect();
    }

    /// Draws one more frame and adds it to the mean. Returns whether further frames would refine the picture.
    ///
    /// A new size starts anew. The caller submits the encoder before the next call. Without a scene nothing is drawn.
    pub fn draw(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        encoder: &mut wgpu::CommandEncoder,
        width: u32,
        height: u32,
        display: Display,
    ) -> bool {
        match self.draw_frame(device, queue, encoder, width, height, display) {
            Ok(wants_more) => wants_more,
            Err(e) => {
                self.error = Some(e);
                false
            }
        }
    }

    fn draw_frame(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        encoder: &mut wgpu::CommandEncoder,
        width: u32,
        height: u32,
        display: Display,
    ) -> Result<bool, PreviewError> {
        let Some(scene) = self.scene.clone() else { return Ok(false) };
        let limit = device.limits().max_texture_dimension_2d;
        let (width, height) = (width.clamp(1, limit), height.clamp(1, limit));
        if self.targets.as_ref().is_none_or(|t| (t.width, t.height) != (width, height)) {
            self.targets = Some(Targets::new(device, width, height)?);
            self.steps = 0;
        }
        self.take_baked(device, queue)?;

        let mut order: Vec<usize> = (0..self.objects.len()).collect();
        let is_cut = |d: &Drawn| d.lobes.has(burnish_material::Lobe::opacity);
        let distance = |d: &Drawn| d.object.mesh.bounds().center().distance(scene.camera.origin);
        order.sort_by(|&a, &b| {
            let (a, b) = (&self.objects[a], &self.objects[b]);
            is_cut(a).cmp(&is_cut(b)).then(if is_cut(a) {
                distance(b).total_cmp(&distance(a))
            } else {
                std::cmp::Ordering::Equal
            })
        });
        let mut pipelines = Vec::with_capacity(order.len());
        let mut is_fitting = true;
        for &i in &order {
            let (made, fits) = self.pipelines.for_lobes(device, self.objects[i].kind(), false)?;
            is_fitting &= fits;
            pipelines.push(made);
        }
        if self.is_provisional && is_fitting {
            self.steps = 0;
        }
        self.is_provisional = !is_fitting;

        let Some(targets) = &self.targets else { return Ok(false) };
        let taps = if self.steps == 0 { self.first.taps } else { u32::from(self.steps < STEPS_MAX) };
        for tap in 0..taps {
            let step = self.steps + tap;
            let block = self.frame_block(&scene, width, height, step);
            let slot = tap as usize;
            queue.write_buffer(&self.frame_blocks[slot], 0, bytemuck::bytes_of(&block));
            self.draw_objects(encoder, targets, slot, &order, &pipelines);
            let weight = 1.0 / (step + 1) as f32;
            queue.write_buffer(&self.output_blocks[slot], 0, bytemuck::cast_slice(&[weight, 0.0, 0.0, 0.0_f32]));
            let [to, from] = [step as usize % 2, (step as usize + 1) % 2];
            let bind = targets.bind(
                device,
                &self.pipelines.layouts,
                &self.output_blocks[slot],
                &targets.color,
                &targets.mean_views[from],
            );
            screen_pass(encoder, "mean", &targets.mean_views[to], &self.pipelines.mean, &bind);
        }
        self.steps += taps;

        let last = (self.steps as usize + 1) % 2;
        let slot = TAPS_MAX as usize;
        let params = [0.0, display.exposure_ev, display.transform as u32 as f32, 0.0];
        queue.write_buffer(&self.output_blocks[slot], 0, bytemuck::cast_slice(&params));
        let bind =
            targets.bind(device, &self.pipelines.layouts, &self.output_blocks[slot], &targets.mean_views[last], &targets.color);
        screen_pass(encoder, "display", &targets.display, &self.pipelines.display, &bind);
        Ok(self.steps < STEPS_MAX || self.is_provisional || self.is_settling())
    }

    /// Takes what the baker has finished; the picture starts anew with it.
    fn take_baked(&mut self, device: &wgpu::Device, queue: &wgpu::Queue) -> Result<(), PreviewError> {
        let Some(baked) = self.baker.take() else { return Ok(()) };
        for (mesh, vertices) in &baked.meshes {
            for drawn in self.objects.iter().filter(|d| Arc::ptr_eq(&d.object.mesh, mesh)) {
                queue.write_buffer(&drawn.buffers.baked, 0, bytemuck::cast_slice(vertices));
            }
        }
        if let Some((light, radiance)) = baked.floor {
            self.stage.light = upload::upload_levels(device, queue, "floor light", std::slice::from_ref(&light))?;
            self.stage.radiance = upload::upload_levels(device, queue, "floor radiance", &radiance)?;
            self.bind_frame(device);
        }
        self.steps = 0;
        Ok(())
    }

    fn draw_objects(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        targets: &Targets,
        slot: usize,
        order: &[usize],
        pipelines: &[pipelines::ObjectPipelines],
    ) {
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("objects"),
            color_attachments: &[Some(color_attachment(&targets.color))],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &targets.depth,
                depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(0.0), store: wgpu::StoreOp::Discard }),
                stencil_ops: None,
            }),
            ..Default::default()
        });
        let Some(frame) = self.frame_binds.get(slot) else { return };
        pass.set_bind_group(0, frame, &[]);
        // The background comes after what hides it and before what lets it through.
        let mut background = Some(&self.pipelines.background);
        let mut draw_background = |pass: &mut wgpu::RenderPass<'_>| {
            if let Some(pipeline) = background.take() {
                pass.set_pipeline(pipeline);
                pass.draw(0..3, 0..1);
            }
        };
        for (&i, made) in order.iter().zip(pipelines) {
            let drawn = &self.objects[i];
            if made.back.is_some() {
                draw_background(&mut pass);
            }
            pass.set_bind_group(1, &drawn.bind, &[]);
            pass.set_vertex_buffer(0, drawn.buffers.vertices.slice(..));
            pass.set_vertex_buffer(1, drawn.buffers.baked.slice(..));
            pass.set_index_buffer(drawn.buffers.indices.slice(..), wgpu::IndexFormat::Uint32);
            for pipeline in made.back.iter().chain([&made.front]) {
                pass.set_pipeline(pipeline);
                pass.draw_indexed(0..drawn.buffers.index_count, 0, 0..1);
            }
        }
        draw_background(&mut pass);
    }

    fn frame_block(&self, scene: &Scene, width: u32, height: u32, step: u32) -> FrameBlock {
        let basis = scene.camera.basis(width as f32 / height as f32);
        let four = |v: Vec3, w: f32| v.extend(w).to_array();
        let bounds = scene.document_bounds();
        let near = ((basis.origin - bounds.center()).length() * 1e-3).max(1e-6);
        let shift = (jitter(step, self.first.taps) * 2.0) / Vec2::new(width as f32, height as f32);
        let (sin, cos) = scene.environment.rotation_deg.to_radians().sin_cos();
        let light = self.light.as_ref();
        let floor = self.stage.floor.as_ref();
        let First { taps, samples, later } = self.first;
        let (first, count, all) = if step < taps {
            (step * samples, samples, taps * samples)
        } else {
            let before = taps * samples + (step - taps) * later;
            (before, later, before + later)
        };
        FrameBlock {
            origin: four(basis.origin, near),
            right_inverse: four(basis.right / basis.right.length_squared(), 0.0),
            up_inverse: four(basis.up / basis.up.length_squared(), 0.0),
            right: four(basis.right, 0.0),
            up: four(basis.up, 0.0),
            forward: four(basis.forward, 0.0),
            jitter: [shift.x, shift.y, width as f32, height as f32],
            environment: [cos, sin, scene.environment.scale, light.map_or(1.0, |l| l.made.levels.len() as f32)],
            floor: floor.map_or([0.0; 4], |f| [f.center.x, f.y, f.center.y, f.half_width]),
            floor_mean: four(light.map_or(Vec3::ZERO, |l| l.made.floor_mean), 0.0),
            floor_open: four(light.map_or(Vec3::ZERO, |l| l.made.up), 0.0),
            samples: [first as f32, count as f32, all as f32, f32::from(u8::from(self.baker.has_result()))],
            body: four(bounds.center(), bounds.radius()),
        }
    }

    /// What is shown: `Rgba8Unorm`, gamma-encoded, opaque. `None` until something was drawn.
    pub fn display_view(&self) -> Option<&wgpu::TextureView> {
        self.targets.as_ref().filter(|_| self.steps > 0).map(|t| &t.display)
    }

    /// Linear radiance of the mean and coverage in alpha, row by row from the top. Submit the last encoder first.
    pub fn read_linear(&mut self, device: &wgpu::Device, queue: &wgpu::Queue) -> Result<Vec<[f32; 4]>, PreviewError> {
        let targets = self.targets.as_ref().filter(|_| self.steps > 0).ok_or(PreviewError::NothingDrawn)?;
        targets.read(device, queue, (self.steps as usize + 1) % 2)
    }

    /// Draws a finished picture without a window and reads it: waits for pipelines and occlusion, then adds `frames` frames.
    pub fn render(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        width: u32,
        height: u32,
        frames: u32,
    ) -> Result<Vec<[f32; 4]>, PreviewError> {
        for kind in self.objects.iter().map(Drawn::kind).collect::<Vec<_>>() {
            self.pipelines.for_lobes(device, kind, true)?;
        }
        self.baker.wait();
        for _ in 0..frames.max(1) {
            let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("preview") });
            let wants_more = self.draw_frame(device, queue, &mut encoder, width, height, Display::default())?;
            queue.submit([encoder.finish()]);
            // Without this a slow adapter would pile up frames.
            device.poll(wgpu::PollType::wait_indefinitely()).map_err(|e| PreviewError::ReadBack(e.to_string()))?;
            if !wants_more {
                break;
            }
        }
        self.read_linear(device, queue)
    }
}

impl Samplers {
    fn new(device: &wgpu::Device) -> Self {
        let make = |label, u, v| {
            device.create_sampler(&wgpu::SamplerDescriptor {
                label: Some(label),
                address_mode_u: u,
                address_mode_v: v,
                mag_filter: wgpu::FilterMode::Linear,
                min_filter: wgpu::FilterMode::Linear,
                mipmap_filter: wgpu::MipmapFilterMode::Linear,
                ..Default::default()
            })
        };
        let (repeat, clamp) = (wgpu::AddressMode::Repeat, wgpu::AddressMode::ClampToEdge);
        Self { sphere: make("sphere", repeat, clamp), floor: make("floor", clamp, clamp), maps: make("maps", repeat, repeat) }
    }
}

fn color_attachment(view: &wgpu::TextureView) -> wgpu::RenderPassColorAttachment<'_> {
    let ops = wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT), store: wgpu::StoreOp::Store };
    wgpu::RenderPassColorAttachment { view, depth_slice: None, resolve_target: None, ops }
}

fn screen_pass(
    encoder: &mut wgpu::CommandEncoder,
    label: &str,
    view: &wgpu::TextureView,
    pipeline: &wgpu::RenderPipeline,
    bind: &wgpu::BindGroup,
) {
    let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some(label),
        color_attachments: &[Some(color_attachment(view))],
        ..Default::default()
    });
    pass.set_pipeline(pipeline);
    pass.set_bind_group(0, bind, &[]);
    pass.draw(0..3, 0..1);
}

/// Place of a picture within the pixel, -0.5 to 0.5: its middle or a rotated grid first, then an even sequence (Roberts 2018).
fn jitter(step: u32, taps: u32) -> Vec2 {
    const GRID: [Vec2; TAPS_MAX as usize] =
        [Vec2::new(-0.125, -0.375), Vec2::new(0.375, -0.125), Vec2::new(-0.375, 0.125), Vec2::new(0.125, 0.375)];
    match GRID.get(step as usize) {
        Some(place) if taps == TAPS_MAX => *place,
        _ => {
            let k = step.saturating_sub(if taps == TAPS_MAX { taps } else { 0 }) as f32;
            Vec2::new((0.5 + k * 0.754_877_7).fract() - 0.5, (0.5 + k * 0.569_840_3).fract() - 0.5)
        }
    }
}
