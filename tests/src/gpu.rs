//! Runs a compute shader over arrays of floats. Where the machine must have an adapter, its absence is a failure.

use burnish_renderer::preview::{headless_device, twin_shader};
use wgpu::util::DeviceExt;

/// Environment variable that turns a missing adapter from a visible skip into a failure.
const REQUIRE: &str = "BURNISH_REQUIRE_GPU";

/// A device; `None` without an adapter, which is said, or is a failure where there must be one.
pub fn device() -> Option<(wgpu::Device, wgpu::Queue)> {
    match headless_device() {
        Ok((_, device, queue)) => Some((device, queue)),
        Err(error) => {
            assert!(std::env::var(REQUIRE).is_err_and(|e| e == std::env::VarError::NotPresent), "{error}");
            eprintln!("SKIPPED: {error}");
            None
        }
    }
}

/// Runs `entry` (a shader text with one entry point `main` of workgroup size 64) over `inputs`, bound as read-only storage
/// buffers of group 1 from binding 1; binding 0 of group 1 is the result of `count` floats. `tables` is what `albedo_tables`
/// holds. `None` without an adapter.
pub fn compute(entry: &str, tables: &[f32], inputs: &[Vec<f32>], count: usize, invocations: usize) -> Option<Vec<f32>> {
    let mut data = vec![Buffer::Result(count)];
    data.extend(inputs.iter().map(|values| Buffer::Storage(values)));
    run(&twin_shader(entry), &[vec![Buffer::Storage(tables)], data], invocations)
}

/// What a binding holds.
#[derive(Clone, Copy, Debug)]
pub enum Buffer<'a> {
    /// A read-only storage buffer.
    Storage(&'a [f32]),
    /// A uniform buffer.
    Uniform(&'a [f32]),
    /// The result: so many floats in a storage buffer.
    Result(usize),
}

/// Runs a whole shader text with one entry point `main` of workgroup size 64, its bindings by group from 0. The result; `None` without an
/// adapter.
pub fn run(text: &str, groups: &[Vec<Buffer<'_>>], invocations: usize) -> Option<Vec<f32>> {
    let (device, queue) = device()?;
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some("tested"),
        source: wgpu::ShaderSource::Wgsl(text.into()),
    });
    let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some("tested"),
        layout: None,
        module: &module,
        entry_point: Some("main"),
        compilation_options: wgpu::PipelineCompilationOptions::default(),
        cache: None,
    });
    let filled = |values: &[f32], usage| {
        let contents = bytemuck::cast_slice(values);
        device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: None, contents, usage })
    };
    let empty = |count: usize, usage| {
        device.create_buffer(&wgpu::BufferDescriptor { label: None, size: 4 * count as u64, usage, mapped_at_creation: false })
    };
    let mut result = None;
    let mut bound = Vec::new();
    for (index, group) in groups.iter().enumerate() {
        let buffers: Vec<wgpu::Buffer> = group
            .iter()
            .map(|buffer| match buffer {
                Buffer::Storage(values) => filled(values, wgpu::BufferUsages::STORAGE),
                Buffer::Uniform(values) => filled(values, wgpu::BufferUsages::UNIFORM),
                Buffer::Result(count) => {
                    let made = empty(*count, wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC);
                    result = Some((made.clone(), *count));
                    made
                }
            })
            .collect();
        let entries: Vec<_> = buffers
            .iter()
            .enumerate()
            .map(|(i, buffer)| wgpu::BindGroupEntry { binding: i as u32, resource: buffer.as_entire_binding() })
            .collect();
        let layout = pipeline.get_bind_group_layout(index as u32);
        bound.push(device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout: &layout, entries: &entries }));
    }
    let (result, count) = result.expect("a shader is run for its result");
    let readable = empty(count, wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST);
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        pass.set_pipeline(&pipeline);
        for (index, group) in bound.iter().enumerate() {
            pass.set_bind_group(index as u32, group, &[]);
        }
        pass.dispatch_workgroups(invocations.div_ceil(64) as u32, 1, 1);
    }
    encoder.copy_buffer_to_buffer(&result, 0, &readable, 0, 4 * count as u64);
    queue.submit([encoder.finish()]);
    readable.slice(..).map_async(wgpu::MapMode::Read, |result| result.expect("a buffer made for reading can be mapped"));
    device.poll(wgpu::PollType::wait_indefinitely()).expect("the device is alive");
    let mapped = readable.slice(..).get_mapped_range().expect("mapping has finished");
    Some(mapped.chunks_exact(4).map(bytemuck::pod_read_unaligned::<f32>).collect())
}
