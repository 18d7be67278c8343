//! Pipelines by lobe set. The first one is made on the spot; later ones on a thread, while the picture goes on with the
//! nearest one that is ready. Values live in uniform blocks, so changing one never makes a pipeline.

use super::device::{PreviewError, guarded};
use super::shader::{self, Piece};
use super::upload::{BAKED_ATTRIBUTES, BakedVertex, VERTEX_ATTRIBUTES, Vertex};
use burnish_material::{LOBES, LobeSet};
use std::collections::{HashMap, HashSet};
use std::sync::mpsc::{Receiver, Sender, channel};

/// Format that a frame is drawn in.
pub(super) const COLOR_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;
/// Format of the mean of many frames.
pub(super) const MEAN_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;
/// Format that is shown; the values are gamma-encoded already.
pub(super) const DISPLAY_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;
/// Places in a pixel where a frame is drawn; values are computed once for those that a triangle covers. A software adapter takes four times as
/// long for four.
pub(super) fn places(device: &wgpu::Device) -> u32 {
    if device.adapter_info().device_type == wgpu::DeviceType::Cpu { 1 } else { 4 }
}

/// Depth is near / distance.
pub(super) const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// Bind group layouts that all passes share.
#[derive(Debug)]
pub(super) struct Layouts {
    pub frame: wgpu::BindGroupLayout,
    pub object: wgpu::BindGroupLayout,
    pub output: wgpu::BindGroupLayout,
}

/// The two ways an object is drawn: its front, and its back where that shows through.
#[derive(Clone, Debug)]
pub(super) struct ObjectPipelines {
    pub back: Option<wgpu::RenderPipeline>,
    pub front: wgpu::RenderPipeline,
}

/// What a pipeline is made for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct PipelineKind {
    pub lobes: LobeSet,
    pub is_floor: bool,
}

/// Everything compiled so far.
#[derive(Debug)]
pub(super) struct Pipelines {
    pub layouts: Layouts,
    pub background: wgpu::RenderPipeline,
    pub mean: wgpu::RenderPipeline,
    pub blend: wgpu::RenderPipeline,
    pub display: wgpu::RenderPipeline,
    /// Of passes over the whole picture.
    pub output_layout: wgpu::PipelineLayout,
    module: wgpu::ShaderModule,
    object_layout: wgpu::PipelineLayout,
    ready: HashMap<PipelineKind, ObjectPipelines>,
    pending: HashSet<PipelineKind>,
    finished: (Sender<Finished>, Receiver<Finished>),
}

type Finished = (PipelineKind, Result<ObjectPipelines, PreviewError>);

impl Pipelines {
    /// Compiles what every picture needs. Objects follow as they appear.
    pub fn new(device: &wgpu::Device) -> Result<Self, PreviewError> {
        let layouts = Layouts { frame: frame_layout(device), object: object_layout(device), output: output_layout(device) };
        let scene = shader::scene_pieces();
        let module = compile(device, "scene", &scene)?;
        let output = compile(device, "output", &shader::output_pieces())?;
        let layout_of = |label, groups: &[Option<&wgpu::BindGroupLayout>]| {
            device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some(label),
                bind_group_layouts: groups,
                immediate_size: 0,
            })
        };
        let frame_only = layout_of("background", &[Some(&layouts.frame)]);
        let object_layout = layout_of("object", &[Some(&layouts.frame), Some(&layouts.object)]);
        let output_layout = layout_of("output", &[Some(&layouts.output)]);
        let background = screen_pipeline(
            device,
            "background",
            &module,
            &frame_only,
            ["vertex_screen", "fragment_background"],
            COLOR_FORMAT.into(),
            Some(depth_state(false, wgpu::CompareFunction::GreaterEqual)),
        )?;
        let screen = |label, entry, format: wgpu::TextureFormat| {
            screen_pipeline(device, label, &output, &output_layout, ["vertex_output", entry], format.into(), None)
        };
        let mean = screen("mean", "fragment_mean", MEAN_FORMAT)?;
        let blend = screen("blend", "fragment_blend", MEAN_FORMAT)?;
        let display = screen("display", "fragment_display", DISPLAY_FORMAT)?;
        Ok(Self {
            layouts,
            background,
            mean,
            blend,
            display,
            output_layout,
            module,
            object_layout,
            ready: HashMap::new(),
            pending: HashSet::new(),
            finished: channel(),
        })
    }

    /// The pipelines for a kind, or those of the smallest larger lobe set, or any: never nothing once one is ready.
    ///
    /// A kind that is missing is ordered; with `wait`, or while there is nothing else to draw with, it is made at once.
    /// The flag says whether the picture is the right one.
    pub fn for_lobes(
        &mut self,
        device: &wgpu::Device,
        kind: PipelineKind,
        wait: bool,
    ) -> Result<(ObjectPipelines, bool), PreviewError> {
        self.collect()?;
        if let Some(made) = self.ready.get(&kind) {
            return Ok((made.clone(), true));
        }
        let size = |k: &PipelineKind| k.lobes.names(true).len();
        let holds = |k: &PipelineKind| k.is_floor == kind.is_floor && k.lobes.union(kind.lobes) == k.lobes;
        let larger = self.ready.keys().filter(|k| holds(k)).min_by_key(|k| size(k)).copied();
        let like = |k: &&PipelineKind| k.is_floor == kind.is_floor;
        let Some(nearest) = larger.or_else(|| self.ready.keys().filter(like).max_by_key(|k| size(k)).copied()).filter(|_| !wait)
        else {
            let made = make(device, &self.module, &self.object_layout, kind)?;
            self.ready.insert(kind, made.clone());
            return Ok((made, true));
        };
        self.order(device, kind);
        match self.ready.get(&nearest) {
            Some(made) => Ok((made.clone(), false)),
            None => Err(PreviewError::Shader("no pipeline is ready".to_owned())),
        }
    }

    /// Compiles a kind on a thread, unless that is under way.
    fn order(&mut self, device: &wgpu::Device, kind: PipelineKind) {
        if !self.pending.insert(kind) {
            return;
        }
        let (device, module, layout) = (device.clone(), self.module.clone(), self.object_layout.clone());
        let sender = self.finished.0.clone();
        let work = move || {
            // The receiver may be gone with the preview; then nobody wants the pipeline.
            _ = sender.send((kind, make(&device, &module, &layout, kind)));
        };
        if std::thread::Builder::new().name("preview pipeline".to_owned()).spawn(work).is_err() {
            self.pending.remove(&kind);
        }
    }

    /// Whether a pipeline is being made.
    pub fn is_waiting(&self) -> bool {
        !self.pending.is_empty()
    }

    /// Takes what the threads have finished.
    fn collect(&mut self) -> Result<(), PreviewError> {
        while let Ok((kind, made)) = self.finished.1.try_recv() {
            self.pending.remove(&kind);
            self.ready.insert(kind, made?);
        }
        Ok(())
    }
}

/// Makes a shader module; a refusal names file and line.
pub(super) fn compile(device: &wgpu::Device, label: &str, pieces: &[Piece]) -> Result<wgpu::ShaderModule, PreviewError> {
    guarded(
        device,
        wgpu::ErrorFilter::Validation,
        |e| PreviewError::Shader(shader::translate(pieces, &e)),
        || {
            device.create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some(label),
                source: wgpu::ShaderSource::Wgsl(shader::join(pieces).into()),
            })
        },
    )
}

fn multisample(device: &wgpu::Device) -> wgpu::MultisampleState {
    wgpu::MultisampleState { count: places(device), ..Default::default() }
}

fn depth_state(writes: bool, compare: wgpu::CompareFunction) -> wgpu::DepthStencilState {
    wgpu::DepthStencilState {
        format: DEPTH_FORMAT,
        depth_write_enabled: Some(writes),
        depth_compare: Some(compare),
        stencil: wgpu::StencilState::default(),
        bias: wgpu::DepthBiasState::default(),
    }
}

/// Makes the pipelines of one kind.
fn make(
    device: &wgpu::Device,
    module: &wgpu::ShaderModule,
    layout: &wgpu::PipelineLayout,
    kind: PipelineKind,
) -> Result<ObjectPipelines, PreviewError> {
    let number = |x: bool| f64::from(u8::from(x));
    let mut constants: Vec<(&str, f64)> = LOBES.iter().map(|def| (def.switch, number(kind.lobes.has(def.lobe)))).collect();
    constants.push(("IS_FLOOR", number(kind.is_floor)));
    let is_cut = kind.lobes.has(burnish_material::Lobe::opacity);
    let one = |cull_mode| {
        device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("object"),
            layout: Some(layout),
            vertex: wgpu::VertexState {
                module,
                entry_point: Some("vertex_object"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: &[
                    Some(wgpu::VertexBufferLayout {
                        array_stride: std::mem::size_of::<Vertex>() as u64,
                        step_mode: wgpu::VertexStepMode::Vertex,
                        attributes: &VERTEX_ATTRIBUTES,
                    }),
                    Some(wgpu::VertexBufferLayout {
                        array_stride: std::mem::size_of::<BakedVertex>() as u64,
                        step_mode: wgpu::VertexStepMode::Vertex,
                        attributes: &BAKED_ATTRIBUTES,
                    }),
                ],
            },
            primitive: wgpu::PrimitiveState { cull_mode, ..Default::default() },
            depth_stencil: Some(depth_state(true, wgpu::CompareFunction::Greater)),
            multisample: multisample(device),
            fragment: Some(wgpu::FragmentState {
                module,
                entry_point: Some("fragment_object"),
                compilation_options: wgpu::PipelineCompilationOptions { constants: &constants, ..Default::default() },
                targets: &[Some(wgpu::ColorTargetState {
                    format: COLOR_FORMAT,
                    blend: is_cut.then_some(wgpu::BlendState::PREMULTIPLIED_ALPHA_BLENDING),
                    write_mask: wgpu::ColorWrites::ALL,
                })],
            }),
            multiview_mask: None,
            cache: None,
        })
    };
    guarded(device, wgpu::ErrorFilter::Validation, PreviewError::Shader, || ObjectPipelines {
        back: is_cut.then(|| one(Some(wgpu::Face::Front))),
        front: one(if is_cut { Some(wgpu::Face::Back) } else { None }),
    })
}

const FRAGMENT: wgpu::ShaderStages = wgpu::ShaderStages::FRAGMENT;

fn entry(binding: u32, visibility: wgpu::ShaderStages, ty: wgpu::BindingType) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry { binding, visibility, ty, count: None }
}

fn uniform(binding: u32, visibility: wgpu::ShaderStages) -> wgpu::BindGroupLayoutEntry {
    let ty =
        wgpu::BindingType::Buffer { ty: wgpu::BufferBindingType::Uniform, has_dynamic_offset: false, min_binding_size: None };
    entry(binding, visibility, ty)
}

/// A pass over the whole picture; with a depth it is one among objects.
pub(super) fn screen_pipeline(
    device: &wgpu::Device,
    label: &str,
    module: &wgpu::ShaderModule,
    layout: &wgpu::PipelineLayout,
    entry: [&str; 2],
    format: wgpu::ColorTargetState,
    depth: Option<wgpu::DepthStencilState>,
) -> Result<wgpu::RenderPipeline, PreviewError> {
    guarded(device, wgpu::ErrorFilter::Validation, PreviewError::Shader, || {
        device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(label),
            layout: Some(layout),
            vertex: wgpu::VertexState {
                module,
                entry_point: Some(entry[0]),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: &[],
            },
            primitive: wgpu::PrimitiveState::default(),
            multisample: if depth.is_some() { multisample(device) } else { wgpu::MultisampleState::default() },
            depth_stencil: depth,
            fragment: Some(wgpu::FragmentState {
                module,
                entry_point: Some(entry[1]),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                targets: &[Some(format)],
            }),
            multiview_mask: None,
            cache: None,
        })
    })
}

fn picture(binding: u32, is_filtered: bool, view_dimension: wgpu::TextureViewDimension) -> wgpu::BindGroupLayoutEntry {
    let sample_type = wgpu::TextureSampleType::Float { filterable: is_filtered };
    entry(binding, FRAGMENT, wgpu::BindingType::Texture { sample_type, view_dimension, multisampled: false })
}

fn sampler(binding: u32) -> wgpu::BindGroupLayoutEntry {
    entry(binding, FRAGMENT, wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering))
}

fn layout(device: &wgpu::Device, label: &str, entries: &[wgpu::BindGroupLayoutEntry]) -> wgpu::BindGroupLayout {
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(label), entries })
}

fn frame_layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    let plain = wgpu::TextureViewDimension::D2;
    let tables = wgpu::BindingType::Buffer {
        ty: wgpu::BufferBindingType::Storage { read_only: true },
        has_dynamic_offset: false,
        min_binding_size: None,
    };
    let entries = [
        uniform(0, wgpu::ShaderStages::VERTEX_FRAGMENT),
        picture(1, true, plain),
        sampler(2),
        picture(3, true, plain),
        picture(4, true, plain),
        picture(5, true, plain),
        sampler(6),
        entry(7, FRAGMENT, tables),
        picture(8, true, plain),
        picture(9, true, plain),
        picture(10, true, plain),
        picture(11, true, plain),
    ];
    layout(device, "frame", &entries)
}

fn object_layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    let entries = [uniform(0, FRAGMENT), picture(1, true, wgpu::TextureViewDimension::D2Array), sampler(2)];
    layout(device, "object", &entries)
}

fn output_layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    let plain = wgpu::TextureViewDimension::D2;
    let sums = wgpu::BindingType::Buffer {
        ty: wgpu::BufferBindingType::Storage { read_only: true },
        has_dynamic_offset: false,
        min_binding_size: None,
    };
    let entries = [uniform(0, FRAGMENT), picture(1, false, plain), picture(2, false, plain), entry(3, FRAGMENT, sums)];
    layout(device, "output", &entries)
}
