//! The pipelines of the rays, by lobe set: compiled on a thread, one at a time.

use super::super::device::{PreviewError, guarded};
use super::super::pipelines::compile;
use super::super::shader;
use burnish_material::{LOBES, LobeSet};
use std::collections::HashMap;
use std::sync::mpsc::{Receiver, TryRecvError, channel};

/// Pipelines that are kept.
const KEPT: usize = 32;

type Compiled = (LobeSet, Result<wgpu::ComputePipeline, PreviewError>);

/// Compiled pipelines and the one being compiled.
#[derive(Debug)]
pub(super) struct RayPipelines {
    layout: wgpu::BindGroupLayout,
    ready: HashMap<LobeSet, wgpu::ComputePipeline>,
    compiling: Option<(LobeSet, Receiver<Compiled>)>,
}

impl RayPipelines {
    pub fn new(device: &wgpu::Device) -> Result<Self, PreviewError> {
        Ok(Self { layout: layout(device), ready: HashMap::new(), compiling: None })
    }

    pub fn layout(&self) -> &wgpu::BindGroupLayout {
        &self.layout
    }

    /// The pipeline for a lobe set; `None` while it is being compiled. With `wait` it is there.
    pub fn for_lobes(
        &mut self,
        device: &wgpu::Device,
        lobes: LobeSet,
        wait: bool,
    ) -> Result<Option<wgpu::ComputePipeline>, PreviewError> {
        loop {
            if let Some(pipeline) = self.ready.get(&lobes) {
                return Ok(Some(pipeline.clone()));
            }
            let (wanted, receiver) = self.compiling.take().unwrap_or_else(|| (lobes, order(device, &self.layout, lobes)));
            let made = if wait { receiver.recv().map_err(|_| TryRecvError::Disconnected) } else { receiver.try_recv() };
            match made {
                Ok((set, pipeline)) => {
                    if self.ready.len() >= KEPT {
                        self.ready.clear();
                    }
                    self.ready.insert(set, pipeline?);
                }
                Err(TryRecvError::Empty) => {
                    self.compiling = Some((wanted, receiver));
                    return Ok(None);
                }
                Err(TryRecvError::Disconnected) => {
                    return Err(PreviewError::Shader("the thread that compiled the rays ended early".to_owned()));
                }
            }
        }
    }
}

/// Compiles on a thread.
fn order(device: &wgpu::Device, layout: &wgpu::BindGroupLayout, lobes: LobeSet) -> Receiver<Compiled> {
    let (sender, receiver) = channel();
    let (device, layout) = (device.clone(), layout.clone());
    // The receiver may be gone with the preview; then nobody wants the pipeline.
    std::thread::spawn(move || _ = sender.send((lobes, make(&device, &layout, lobes))));
    receiver
}

fn make(device: &wgpu::Device, layout: &wgpu::BindGroupLayout, lobes: LobeSet) -> Result<wgpu::ComputePipeline, PreviewError> {
    let module = compile(device, "rays", &shader::rays_pieces())?;
    let constants: Vec<(&str, f64)> = LOBES.iter().map(|def| (def.switch, f64::from(u8::from(lobes.has(def.lobe))))).collect();
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some("rays"),
        bind_group_layouts: &[Some(layout)],
        immediate_size: 0,
    });
    guarded(device, wgpu::ErrorFilter::Validation, PreviewError::Shader, || {
        device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some("rays"),
            layout: Some(&layout),
            module: &module,
            entry_point: Some("trace_paths"),
            compilation_options: wgpu::PipelineCompilationOptions { constants: &constants, ..Default::default() },
            cache: None,
        })
    })
}

fn layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    let entry = |binding, ty| wgpu::BindGroupLayoutEntry { binding, visibility: wgpu::ShaderStages::COMPUTE, ty, count: None };
    let buffer = |ty| wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None };
    let storage = |read_only| buffer(wgpu::BufferBindingType::Storage { read_only });
    let picture = |view_dimension| wgpu::BindingType::Texture {
        sample_type: wgpu::TextureSampleType::Float { filterable: true },
        view_dimension,
        multisampled: false,
    };
    let sampler = wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering);
    let mut entries = vec![entry(0, buffer(wgpu::BufferBindingType::Uniform))];
    entries.extend((1..=7).map(|binding| entry(binding, storage(true))));
    entries.extend([
        entry(8, picture(wgpu::TextureViewDimension::D2)),
        entry(9, sampler),
        entry(10, picture(wgpu::TextureViewDimension::D2Array)),
        entry(11, sampler),
        entry(12, storage(false)),
    ]);
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some("rays"), entries: &entries })
}
