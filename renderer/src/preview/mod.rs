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
//! * The object colours and lights the floor as a matt body of its mean colour would; no caustics appear.
//! * Diffuse light comes from irradiance: the coupling with the reflecting interface takes its mean over directions, which is
//!   exact under even light and off by a few percent of the diffuse part elsewhere.
//! * Between a body's own walls light goes to and fro as if all were diffuse and equally lit; concave metal comes out too smooth.
//! * Baked light belongs to vertices of which near ones share a computation: shadows on bodies are softer than they are.
//! * Refraction goes through a sphere in the place of the body (tangent to it where light enters), with inner reflections in
//!   one chain of four; a rough exit is blurred instead of sampled. Other bodies are not seen through it, only floor and environment.
//! * Displaced meshes are refined to 1/40 of the radius; what is finer bends normals.
//! * Opacity blends back faces, then front faces, of each object in order of distance.
//! * The first frames average light over the share of each sample, which softens reflections of small lights; the share
//!   shrinks as frames add up.
//! * Left out of the drawn picture: dispersion.
//!
//! Where the device can, rays bring the rest as soon as nothing changes (`rays`).

mod albedos;
mod bake;
mod bake_job;
mod bloom;
mod cost;
mod crop;
mod device;
mod draw;
mod environment;
mod floor;
mod frame;
mod pipelines;
mod rays;
mod relief;
pub(crate) mod shader;
mod take;
mod targets;
mod timing;
mod upload;

pub use crop::Crop;
pub use device::{PreviewError, device_descriptor, headless_device};
pub use shader::{albedo_table_values, twin_shader};
pub use timing::FrameTimes;

use crate::bsdf::Albedos;
use crate::scene::{Object, Scene};
use crate::tonemap::Display;
use bake::Baker;
use bloom::Bloom;
use burnish_assets::{Environment, Mesh};
use burnish_material::{LobeSet, Material};
use device::guarded;
use environment::Prefiltered;
use floor::{Floor, Pavement};
use pipelines::{PipelineKind, Pipelines};
use rays::Rays;
use relief::Reliefs;
use std::sync::Arc;
use targets::Targets;
use timing::Timing;
use upload::{FrameBlock, Maps, MeshBuffers, ObjectBlock};

/// Pictures after which nothing visible changes any more, without rays.
const STEPS_MAX: u32 = 64;
/// The same beside rays, which bring the rest.
const STEPS_BESIDE_RAYS: u32 = 16;

/// What the rays take of each picture unless told otherwise, seconds.
const PATIENCE_SECONDS: f64 = 0.012;

/// The preview of one scene. Needs a device and a queue, and no window.
#[derive(Debug)]
pub struct Preview {
    pipelines: Pipelines,
    samplers: Samplers,
    tables: albedos::Tables,
    frame_buffer: wgpu::Buffer,
    frame_bind: Option<wgpu::BindGroup>,
    /// Of the mean, and of what is shown.
    output_buffers: [wgpu::Buffer; 2],
    /// What is drawn: the scene that was set last, with earlier objects while the tables of its own are being filled.
    scene: Option<Scene>,
    /// The scene that was set last.
    wanted: Option<Scene>,
    light: Option<Light>,
    filtering: Option<take::Filtering>,
    filling: Option<albedos::Filling>,
    reliefs: Reliefs,
    stage: Stage,
    objects: Vec<Drawn>,
    baker: Baker,
    targets: Option<Targets>,
    maps: Option<Maps>,
    rays: Rays,
    /// `None` while bloom is off.
    bloom: Option<Bloom>,
    /// What the rays may take of each call of [`Preview::draw`], seconds.
    patience: f64,
    /// Whether rays are traced at all.
    has_rays: bool,
    /// The part of the picture that is drawn; `None`: all of it.
    crop: Option<Crop>,
    timing: Timing,
    /// Tiles of rays in the last picture, and seconds of each if someone measured them.
    tiles: u32,
    tile_seconds: f64,
    /// Whether the picture on the display holds samples of the rays.
    is_blended: bool,
    /// Pictures in the mean so far.
    steps: u32,
    /// The picture in the mean was drawn with a pipeline that did not fit.
    is_provisional: bool,
    /// Lobes that are evaluated although the edited material does not need them, and those that are left out although it does.
    changed: [LobeSet; 2],
    /// Samples per lobe in each frame.
    samples: u32,
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
    pavement: Option<Pavement>,
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
    /// What white bodies in the place of the edited ones add to both.
    glow_radiance: wgpu::TextureView,
    glow: wgpu::TextureView,
    /// The same for bodies that shine with radiance 1.
    shine_radiance: wgpu::TextureView,
    shine: wgpu::TextureView,
}

/// One object on the device.
#[derive(Debug)]
struct Drawn {
    object: Object,
    /// Its mesh as it is drawn: displaced where its material has a height.
    mesh: Arc<Mesh>,
    lobes: LobeSet,
    albedos: Arc<Albedos>,
    /// Where its albedos begin in the tables.
    begin: u32,
    /// Where its maps begin in the array.
    first_layer: u32,
    buffers: Arc<MeshBuffers>,
    values: ObjectBlock,
    block: wgpu::Buffer,
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
        let uniform = |label, size: usize| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size: size as u64,
                usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            })
        };
        let (frame_buffer, output_buffers) = guarded(device, wgpu::ErrorFilter::OutOfMemory, PreviewError::Memory, || {
            (uniform("frame", size_of::<FrameBlock>()), [uniform("mean", 32), uniform("display", 32)])
        })?;
        let black = || upload::upload_levels(device, queue, "no floor", &[upload::black()]);
        let stage = Stage {
            key: Vec::new(),
            floor: None,
            radiance: black()?,
            light: black()?,
            glow_radiance: black()?,
            glow: black()?,
            shine_radiance: black()?,
            shine: black()?,
        };
        Ok(Self {
            pipelines,
            samplers: Samplers::new(device),
            tables: albedos::Tables::new(device)?,
            frame_buffer,
            frame_bind: None,
            output_buffers,
            scene: None,
            wanted: None,
            light: None,
            filtering: None,
            filling: None,
            reliefs: Reliefs::default(),
            stage,
            objects: Vec::new(),
            baker: Baker::default(),
            targets: None,
            maps: None,
            rays: Rays::new(device)?,
            bloom: None,
            patience: PATIENCE_SECONDS,
            has_rays: true,
            crop: None,
            timing: Timing::new(device, queue),
            tiles: 0,
            tile_seconds: 0.0,
            is_blended: false,
            steps: 0,
            is_provisional: false,
            changed: [LobeSet::EMPTY; 2],
            samples: frame::samples_on(device),
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

    /// Takes note that someone has dealt with [`Preview::error`].
    pub fn forget_error(&mut self) {
        self.error = None;
    }

    /// Whether light, occlusion or albedos are still being computed, or a pipeline compiled: the picture will still change.
    pub fn is_settling(&self) -> bool {
        self.baker.is_busy() || self.pipelines.is_waiting() || self.is_taking()
    }

    /// Whether the last picture shows the scene that was set last, with the pipelines that fit it: baked light may still follow.
    pub fn is_current(&self) -> bool {
        self.steps > 0 && !self.is_taking() && !self.is_provisional
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

    /// What is shown: `Rgba8Unorm`, gamma-encoded, opaque. `None` until something was drawn.
    pub fn display_view(&self) -> Option<&wgpu::TextureView> {
        self.targets.as_ref().filter(|_| self.steps > 0).map(|t| &t.display)
    }

    /// Linear radiance of what is shown and coverage in alpha, row by row from the top. Submit the last encoder first.
    pub fn read_linear(&mut self, device: &wgpu::Device, queue: &wgpu::Queue) -> Result<Vec<[f32; 4]>, PreviewError> {
        let targets = self.targets.as_ref().filter(|_| self.steps > 0).ok_or(PreviewError::NothingDrawn)?;
        targets.read(device, queue, self.shown())
    }

    /// What the passes of a recent picture took; empty where the device measures none.
    pub fn times(&self) -> &FrameTimes {
        self.timing.last()
    }

    /// Tells how long the last picture took, from [`Preview::draw`] until the device was done: a software adapter's rays are paced by that.
    pub fn took(&mut self, seconds: f64) {
        if self.tiles > 0 {
            let new = seconds / f64::from(self.tiles);
            self.tile_seconds = if self.tile_seconds == 0.0 { new } else { 0.5 * (self.tile_seconds + new) };
        }
    }

    /// Whether the last picture holds samples of rays.
    pub fn is_traced(&self) -> bool {
        self.is_blended
    }

    /// Samples per pixel that the rays have added.
    pub fn ray_samples(&self) -> u32 {
        self.rays.samples()
    }

    /// Why no rays are traced, if that is so: the picture then stays as it is drawn.
    pub fn rays_problem(&self) -> Option<&PreviewError> {
        self.rays.problem()
    }

    /// Switches rays off, or on again: without them the picture stays as it is drawn.
    pub fn set_rays(&mut self, has_rays: bool) {
        if has_rays != self.has_rays {
            self.has_rays = has_rays;
            self.restart();
        }
    }

    /// Draws a part of a picture from now on: the sizes that are asked for are those of the part. `None`: the whole picture.
    pub fn set_crop(&mut self, crop: Option<Crop>) {
        if crop != self.crop {
            self.crop = crop;
            self.restart();
        }
    }

    /// Switches bloom on the display off or on: what is brighter than white spreads around. The picture itself and [`Preview::read_linear`] stay
    /// as they are.
    pub fn set_bloom(&mut self, device: &wgpu::Device, has_bloom: bool) -> Result<(), PreviewError> {
        if !has_bloom {
            self.bloom = None;
        } else if self.bloom.is_none() {
            self.bloom = Some(Bloom::new(device, &self.pipelines)?);
        }
        Ok(())
    }

    /// What the rays may take of each picture from now on, seconds; without a limit each picture adds a sample to every pixel.
    pub fn set_patience(&mut self, seconds: f64) {
        self.patience = seconds;
    }

    /// Draws a finished picture without a window and reads it: waits for pipelines, occlusion and the tree. The first frame is drawn alone;
    /// each further one adds a sample of the rays.
    pub fn render(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        width: u32,
        height: u32,
        frames: u32,
    ) -> Result<Vec<[f32; 4]>, PreviewError> {
        self.settle(device, queue)?;
        for _ in 0..frames.max(1) {
            if !self.render_more(device, queue, width, height, Display::default())? {
                break;
            }
        }
        self.read_linear(device, queue)
    }

    /// Waits for everything that the window would show later: tables, pipelines, occlusion.
    pub fn settle(&mut self, device: &wgpu::Device, queue: &wgpu::Queue) -> Result<(), PreviewError> {
        while self.is_taking() {
            std::thread::sleep(std::time::Duration::from_millis(2));
            self.take_finished(device, queue)?;
        }
        self.compile(device)?;
        self.baker.wait();
        Ok(())
    }

    /// Draws one more frame without a window, with a sample of the rays for every pixel after the first. Returns whether more would refine
    /// the picture.
    pub fn render_more(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        width: u32,
        height: u32,
        display: Display,
    ) -> Result<bool, PreviewError> {
        self.patience = f64::INFINITY;
        if self.steps > 0 && self.has_rays {
            self.prepare_rays(device, queue, [width, height], true);
        }
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("preview") });
        let wants_more = self.draw_frame(device, queue, &mut encoder, width, height, display)?;
        queue.submit([encoder.finish()]);
        // Without this a slow adapter would pile up frames.
        device.poll(wgpu::PollType::wait_indefinitely()).map_err(|e| PreviewError::ReadBack(e.to_string()))?;
        Ok(wants_more)
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
