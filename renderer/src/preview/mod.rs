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
//! * The object only darkens the floor, as a black body would: its colour does not bleed, refracting and cut-through bodies cast full
//!   shadows, and no caustics appear. The floor about the object is a few percent too dark.
//! * Diffuse light comes from irradiance: the coupling with the reflecting interface takes its mean over directions, which is
//!   exact under even light and off by a few percent of the diffuse part elsewhere.
//! * Between a body's own walls light goes to and fro as if all were diffuse and equally lit; concave metal comes out too smooth.
//! * Baked light belongs to vertices of which near ones share a computation: shadows on bodies are softer than they are.
//! * Refraction goes through a sphere in the place of the body (tangent to it where light enters), with inner reflections in
//!   one chain of four; a rough exit is blurred instead of sampled. Other bodies are not seen through it, only floor and environment.
//! * Opacity blends back faces, then front faces, of each object in order of distance.
//! * The first frames average light over the share of each sample, which softens reflections of small lights; the share
//!   shrinks as frames add up.
//! * Left out: scattering in the body, dispersion, height, the maps of occlusion and thickness, and the normal map of the coat
//!   (the coat follows the mapped surface).

mod albedos;
mod bake;
mod bake_job;
mod cost;
mod device;
mod environment;
mod floor;
mod frame;
mod pipelines;
mod shader;
mod take;
mod targets;
mod upload;

pub use device::{PreviewError, device_descriptor, headless_device};
pub use shader::{albedo_table_values, twin_shader};

use crate::bsdf::Albedos;
use crate::scene::{Object, Scene};
use crate::tonemap::Display;
use bake::Baker;
use burnish_assets::{Environment, Mesh};
use burnish_material::{LobeSet, Material};
use device::guarded;
use environment::Prefiltered;
use floor::Floor;
use frame::{First, TAPS_MAX};
use glam::Vec3;
use pipelines::{PipelineKind, Pipelines};
use std::sync::Arc;
use targets::Targets;
use upload::{FrameBlock, MeshBuffers};

/// Pictures after which nothing visible changes any more.
const STEPS_MAX: u32 = 64;

/// The preview of one scene. Needs a device and a queue, and no window.
#[derive(Debug)]
pub struct Preview {
    pipelines: Pipelines,
    samplers: Samplers,
    tables: albedos::Tables,
    frame_blocks: Vec<wgpu::Buffer>,
    frame_binds: Vec<wgpu::BindGroup>,
    output_blocks: Vec<wgpu::Buffer>,
    /// What is drawn: the scene that was set last, with earlier objects while the tables of its own are being filled.
    scene: Option<Scene>,
    /// The scene that was set last.
    wanted: Option<Scene>,
    light: Option<Light>,
    filtering: Option<take::Filtering>,
    filling: Option<albedos::Filling>,
    stage: Stage,
    objects: Vec<Drawn>,
    baker: Baker,
    targets: Option<Targets>,
    /// Pictures in the mean so far.
    steps: u32,
    /// The picture in the mean was drawn with a pipeline that did not fit.
    is_provisional: bool,
    /// Lobes that are evaluated although the edited material does not need them.
    more: LobeSet,
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
    albedos: Arc<Albedos>,
    /// Where its albedos begin in the tables.
    begin: u32,
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
        let black = || upload::upload_levels(device, queue, "no floor", &[upload::black()]);
        let stage = Stage { key: Vec::new(), floor: None, radiance: black()?, light: black()? };
        Ok(Self {
            pipelines,
            samplers: Samplers::new(device),
            tables: albedos::Tables::new(device)?,
            frame_blocks,
            frame_binds: Vec::new(),
            output_blocks,
            scene: None,
            wanted: None,
            light: None,
            filtering: None,
            filling: None,
            stage,
            objects: Vec::new(),
            baker: Baker::default(),
            targets: None,
            steps: 0,
            is_provisional: false,
            more: LobeSet::EMPTY,
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

    /// Whether light, occlusion or albedos are still being computed, or a pipeline compiled: the picture will still change.
    pub fn is_settling(&self) -> bool {
        self.baker.is_busy() || self.pipelines.is_waiting() || self.filtering.is_some() || self.filling.is_some()
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
        self.take_finished(device, queue)?;
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
        while self.filtering.is_some() || self.filling.is_some() {
            std::thread::sleep(std::time::Duration::from_millis(2));
            self.take_finished(device, queue)?;
        }
        self.compile(device)?;
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
