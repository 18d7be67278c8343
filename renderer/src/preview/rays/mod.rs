//! Rays: paths traced on the device against the whole scene, added up while nothing changes.
//!
//! The estimator is that of the final view with one connection a vertex, through the twins of the lobes, so the sum goes to the same
//! picture. The drawn picture stands alone until the first samples are there, counts as a few samples beside them, and is gone when
//! they are many.

mod pipelines;
mod upload;

use super::Crop;
use super::device::PreviewError;
use super::upload::ObjectBlock;
use crate::path::Flat;
use crate::scene::Scene;
use burnish_material::{Lobe, LobeSet};
use glam::Vec3;
use pipelines::RayPipelines;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use upload::{RaysBlock, SceneBuffers};

/// Samples that the drawn picture counts as while they are few.
pub(super) const DRAWN_COUNTS: f32 = 16.0;
/// Samples per pixel from which the drawn picture fades, and at which it is gone.
pub(super) const DRAWN_FADES: [f32; 2] = [24.0, 64.0];
/// Samples per pixel after which the picture rests: of opaque scenes, and of those that light goes through.
const SAMPLES_MAX: [u32; 2] = [128, 256];
/// Side of a tile, pixels: that of a workgroup.
const TILE: u32 = 8;
/// Deepest tree that the shader's stack holds.
const DEPTH_MAX: u32 = 62;
/// Steps from tile to tile: primes, of which one divides no number of tiles that a picture has.
const STEPS: [u32; 3] = [12_289, 7_919, 6_007];

/// The pass that traces rays.
#[derive(Debug)]
pub(super) struct Rays {
    pipelines: RayPipelines,
    /// The scene being flattened.
    flattening: Option<Receiver<Flat>>,
    flat: Option<Arc<Flat>>,
    buffers: Option<SceneBuffers>,
    block: wgpu::Buffer,
    /// Sums by pixel, and the size of the picture that they belong to.
    sums: Option<(wgpu::Buffer, [u32; 2])>,
    bind: Option<wgpu::BindGroup>,
    /// Whether the sums must be set to 0 before the next sample.
    is_stale: bool,
    /// Tiles traced since then.
    traced: u64,
    /// Lobes of the scene.
    lobes: LobeSet,
    /// Why there are none, if there will be none.
    problem: Option<PreviewError>,
}

/// What rays need from the pass that draws.
pub(super) struct Given<'a> {
    pub scene: &'a Scene,
    /// As in `FrameBlock`.
    pub environment_row: [f32; 4],
    /// Of what is drawn, pixels.
    pub size: [u32; 2],
    /// Where that lies in its picture.
    pub crop: Crop,
    /// The objects as they are drawn, in the order of the scene.
    pub blocks: &'a [ObjectBlock],
    pub albedos: &'a wgpu::Buffer,
    pub environment: (&'a wgpu::TextureView, &'a wgpu::Sampler),
    pub maps: (&'a wgpu::TextureView, &'a wgpu::Sampler),
    pub lobes: LobeSet,
}

impl Rays {
    pub fn new(device: &wgpu::Device) -> Result<Self, PreviewError> {
        Ok(Self {
            pipelines: RayPipelines::new(device)?,
            flattening: None,
            flat: None,
            buffers: None,
            block: device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("rays"),
                size: size_of::<RaysBlock>() as u64,
                usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            }),
            sums: None,
            bind: None,
            is_stale: true,
            traced: 0,
            lobes: LobeSet::EMPTY,
            problem: None,
        })
    }

    /// The picture is another one: samples so far do not count.
    pub fn restart(&mut self) {
        self.is_stale = true;
        self.traced = 0;
    }

    /// Something that is bound was replaced.
    pub fn unbind(&mut self) {
        self.bind = None;
    }

    /// Samples per pixel so far; the part of the picture that has one more is not counted.
    pub fn samples(&self) -> u32 {
        let tiles = self.sums.as_ref().map_or(1, |(_, size)| tiles_of(*size).1);
        if self.is_stale { 0 } else { (self.traced / u64::from(tiles.max(1))) as u32 }
    }

    /// Whether any sample was added.
    pub fn has_any(&self) -> bool {
        !self.is_stale && self.traced > 0
    }

    /// Whether further samples would refine the picture.
    pub fn wants_more(&self) -> bool {
        self.problem.is_none() && self.samples() < SAMPLES_MAX[usize::from(self.lobes.has(Lobe::transmission))]
    }

    /// Why no rays are traced, if that is so.
    pub fn problem(&self) -> Option<&PreviewError> {
        self.problem.as_ref()
    }

    /// Sums by pixel, if they are of this size.
    pub fn sums(&self) -> Option<&wgpu::Buffer> {
        self.sums.as_ref().map(|(buffer, _)| buffer)
    }

    /// Gets what the scene needs: true once samples can be added. With `wait` it returns only then, or with a problem.
    pub fn prepare(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, given: &Given<'_>, wait: bool) -> bool {
        match self.try_prepare(device, queue, given, wait) {
            Ok(is_ready) => {
                if is_ready {
                    self.problem = None;
                }
                is_ready
            }
            Err(e) => {
                self.problem = Some(e);
                false
            }
        }
    }

    fn try_prepare(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        given: &Given<'_>,
        wait: bool,
    ) -> Result<bool, PreviewError> {
        self.lobes = given.lobes;
        if self.flat.as_ref().is_none_or(|flat| !flat.is_of(given.scene)) && !self.flatten(given.scene, wait) {
            return Ok(false);
        }
        let Some(flat) = self.flat.clone() else { return Ok(false) };
        if flat.tree.depth > DEPTH_MAX {
            return Err(PreviewError::Memory("the mesh has a tree too deep to trace rays against".to_owned()));
        }
        if self.pipelines.for_lobes(device, given.lobes, wait)?.is_none() {
            return Ok(false);
        }
        let is_uploaded = self.buffers.as_ref().is_some_and(|b| Arc::ptr_eq(&b.flat, &flat));
        if !is_uploaded {
            let previous = self.buffers.take();
            self.buffers = Some(SceneBuffers::new(device, queue, flat, previous)?);
            self.bind = None;
        }
        Ok(true)
    }

    /// Takes the flattened scene, or has it made. Whether it is there.
    fn flatten(&mut self, scene: &Scene, wait: bool) -> bool {
        loop {
            let (receiver, is_new) = match self.flattening.take() {
                Some(receiver) => (receiver, false),
                None => {
                    let (sender, receiver) = channel();
                    let (scene, previous) = (scene.clone(), self.flat.clone());
                    // Nobody waits any more if the preview is gone.
                    std::thread::spawn(move || _ = sender.send(Flat::new(&scene, previous.as_deref())));
                    (receiver, true)
                }
            };
            let made = if wait { receiver.recv().map_err(|_| TryRecvError::Disconnected) } else { receiver.try_recv() };
            match made {
                Ok(flat) => {
                    let is_of = flat.is_of(scene);
                    self.flat = Some(Arc::new(flat));
                    if is_of {
                        return true;
                    }
                }
                Err(TryRecvError::Empty) => {
                    self.flattening = Some(receiver);
                    return false;
                }
                // The thread is gone without a result; another is tried at the next picture.
                Err(TryRecvError::Disconnected) => return false,
            }
            if !wait && is_new {
                return false;
            }
        }
    }

    /// Adds samples: `tiles` tiles with one each, from where the last call ended. Call only where [`Self::prepare`] was true for this scene.
    pub fn trace(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        encoder: &mut wgpu::CommandEncoder,
        given: &Given<'_>,
        tiles: u32,
        timestamps: Option<wgpu::ComputePassTimestampWrites<'_>>,
    ) -> Result<(), PreviewError> {
        let size = given.size;
        if self.sums.as_ref().is_none_or(|(_, s)| *s != size) {
            self.sums = Some((upload::sums(device, size)?, size));
            self.bind = None;
            self.restart();
        }
        let (Some(buffers), Some((sums, _))) = (&self.buffers, &self.sums) else { return Ok(()) };
        let Some(pipeline) = self.pipelines.for_lobes(device, given.lobes, false)? else { return Ok(()) };
        let objects = buffers.write_objects(device, queue, given)?;
        if objects.is_some() {
            self.bind = None;
        }
        let Some(buffers) = &mut self.buffers else { return Ok(()) };
        if let Some(objects) = objects {
            buffers.objects = objects;
        }
        if self.is_stale {
            encoder.clear_buffer(sums, 0, None);
            self.is_stale = false;
        }
        let (across, all) = tiles_of(size);
        let tiles = tiles.clamp(1, all);
        let step =
            STEPS.into_iter().map(|step| step % all).find(|step| all == 1 || (*step > 0 && gcd(*step, all) == 1)).unwrap_or(1);
        let block = RaysBlock::new(given, buffers, [(self.traced % u64::from(all)) as u32, across, all, step], tiles);
        queue.write_buffer(&self.block, 0, bytemuck::bytes_of(&block));
        if self.bind.is_none() {
            self.bind = Some(buffers.bind(device, self.pipelines.layout(), &self.block, sums, given));
        }
        let mut pass =
            encoder.begin_compute_pass(&wgpu::ComputePassDescriptor { label: Some("rays"), timestamp_writes: timestamps });
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, self.bind.as_ref(), &[]);
        let row = tiles.min(device.limits().max_compute_workgroups_per_dimension);
        pass.dispatch_workgroups(row, tiles.div_ceil(row), 1);
        drop(pass);
        self.traced += u64::from(tiles);
        Ok(())
    }

    /// Tiles that a picture of this size has.
    pub fn tiles(size: [u32; 2]) -> u32 {
        tiles_of(size).1
    }
}

/// Tiles in a row and in all.
fn tiles_of([width, height]: [u32; 2]) -> (u32, u32) {
    let across = width.div_ceil(TILE);
    (across, across * height.div_ceil(TILE))
}

fn gcd(a: u32, b: u32) -> u32 {
    if b == 0 { a } else { gcd(b, a % b) }
}

/// Coefficients of what the camera is in.
fn camera_medium(flat: &Flat, scene: &Scene, origin: Vec3) -> [[f32; 4]; 2] {
    let none = [[0.0; 4]; 2];
    let Some(object) = flat.object_around(origin).and_then(|i| scene.objects.get(i as usize)) else { return none };
    let inputs = object.material.inputs().convert(|x| x as f32);
    let scale = object.length_scale * flat.scale();
    let optics = crate::bsdf::interpret(&inputs, LobeSet::of(&object.material), scale as f32);
    [optics.sigma_a.0, optics.sigma_s.0].map(|[r, g, b]| [r, g, b, 0.0])
}
