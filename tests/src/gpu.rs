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
    let (device, queue) = device()?;
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some("twins"),
        source: wgpu::ShaderSource::Wgsl(twin_shader(entry).into()),
    });
    let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some("twins"),
        layout: None,
        module: &module,
        entry_point: Some("main"),
        compilation_options: wgpu::PipelineCompilationOptions::default(),
        cache: None,
    });
    let storage = |values: &[f32]| {
        device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: None,
            contents: bytemuck::cast_slice(values),
            usage: wgpu::BufferUsages::STORAGE,
        })
    };
    let size = 4 * count as u64;
    let buffer = |usage| device.create_buffer(&wgpu::BufferDescriptor { label: None, size, usage, mapped_at_creation: false });
    let result = buffer(wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC);
    let readable = buffer(wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST);
    let tables = storage(tables);
    let inputs: Vec<_> = inputs.iter().map(|values| storage(values)).collect();
    let mut entries = vec![wgpu::BindGroupEntry { binding: 0, resource: result.as_entire_binding() }];
    for (i, input) in inputs.iter().enumerate() {
        entries.push(wgpu::BindGroupEntry { binding: 1 + i as u32, resource: input.as_entire_binding() });
    }
    let group = |index, entries: &[wgpu::BindGroupEntry<'_>]| {
        let layout = pipeline.get_bind_group_layout(index);
        device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout: &layout, entries })
    };
    let table_group = group(0, &[wgpu::BindGroupEntry { binding: 0, resource: tables.as_entire_binding() }]);
    let data_group = group(1, &entries);
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &table_group, &[]);
        pass.set_bind_group(1, &data_group, &[]);
        pass.dispatch_workgroups(invocations.div_ceil(64) as u32, 1, 1);
    }
    encoder.copy_buffer_to_buffer(&result, 0, &readable, 0, size);
    queue.submit([encoder.finish()]);
    readable.slice(..).map_async(wgpu::MapMode::Read, |result| result.expect("a buffer made for reading can be mapped"));
    device.poll(wgpu::PollType::wait_indefinitely()).expect("the device is alive");
    let mapped = readable.slice(..).get_mapped_range().expect("mapping has finished");
    Some(mapped.chunks_exact(4).map(bytemuck::pod_read_unaligned::<f32>).collect())
}
