//! What rays need on the device. Mirrors the structs of `scene.wgsl`.

use super::super::device::{PreviewError, guarded};
use super::super::upload::ObjectBlock;
use super::{Given, camera_medium};
use crate::path::Flat;
use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use std::sync::Arc;

/// `struct Rays` of `scene.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(super) struct RaysBlock {
    origin: [f32; 4],
    right: [f32; 4],
    up: [f32; 4],
    forward: [f32; 4],
    environment: [f32; 4],
    absorption: [f32; 4],
    scattering: [f32; 4],
    light: [u32; 4],
    picture: [u32; 4],
    tiles: [u32; 4],
    seed: [u32; 4],
    whole: [u32; 4],
}

impl RaysBlock {
    /// `tiles`: the first, those in a row, all, and the step between them; `count` of them are traced.
    pub fn new(given: &Given<'_>, buffers: &SceneBuffers, tiles: [u32; 4], count: u32) -> Self {
        let [width, height] = given.size;
        let (mut camera, [across, upwards]) = given.crop.basis(&given.scene.camera, given.size);
        camera.forward += across * camera.right + upwards * camera.up;
        let four = |v: Vec3, w: f32| v.extend(w).to_array();
        let spread = 2.0 * camera.up.length() / height.max(1) as f32;
        let [absorption, scattering] = camera_medium(&buffers.flat, given.scene, camera.origin);
        let [rows, columns] = buffers.light_size;
        Self {
            origin: four(buffers.flat.normalized(camera.origin), spread),
            right: four(camera.right, 0.0),
            up: four(camera.up, 0.0),
            forward: four(camera.forward, 0.0),
            environment: given.environment_row,
            absorption,
            scattering,
            light: [rows, columns, buffers.flat.tree.root.unwrap_or(u32::MAX), 0],
            picture: [width, height, 0, 1],
            tiles,
            seed: [0x5eed, given.scene.max_bounces, count, 0],
            whole: [given.crop.at[0], given.crop.at[1], given.crop.full[0], 0],
        }
    }
}

/// Geometry, light and materials on the device.
#[derive(Debug)]
pub(super) struct SceneBuffers {
    pub flat: Arc<Flat>,
    nodes: wgpu::Buffer,
    leaves: wgpu::Buffer,
    vertices: wgpu::Buffer,
    triangles: wgpu::Buffer,
    light: wgpu::Buffer,
    /// Rows and columns of the light's table; zeros without one.
    pub light_size: [u32; 2],
    pub objects: wgpu::Buffer,
}

impl SceneBuffers {
    /// Uploads a scene; what it shares with the previous one is kept.
    pub fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        flat: Arc<Flat>,
        previous: Option<Self>,
    ) -> Result<Self, PreviewError> {
        let (nodes, leaves, vertices, triangles) = match previous.as_ref().filter(|p| p.flat.has_geometry_of(&flat)) {
            Some(p) => (p.nodes.clone(), p.leaves.clone(), p.vertices.clone(), p.triangles.clone()),
            None => (
                filled(device, queue, "tree", bytemuck::cast_slice(&flat.tree.nodes))?,
                filled(device, queue, "leaves", bytemuck::cast_slice(&flat.tree.triangles))?,
                filled(device, queue, "ray vertices", bytemuck::cast_slice(flat.vertices()))?,
                filled(device, queue, "ray triangles", bytemuck::cast_slice(&flat.triangles))?,
            ),
        };
        let (light, light_size) = match previous.as_ref().filter(|p| p.flat.has_light_of(&flat)) {
            Some(p) => (p.light.clone(), p.light_size),
            None => match flat.light() {
                Some(table) => {
                    let size = [table.rows as u32, table.columns as u32];
                    (filled(device, queue, "light table", bytemuck::cast_slice(&table.values))?, size)
                }
                None => (filled(device, queue, "light table", &[])?, [0; 2]),
            },
        };
        let objects = match previous {
            Some(p) => p.objects,
            None => filled(device, queue, "ray objects", &[])?,
        };
        Ok(Self { flat, nodes, leaves, vertices, triangles, light, light_size, objects })
    }

    /// Writes the materials of all objects; a new buffer where the old one is too small.
    pub fn write_objects(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        given: &Given<'_>,
    ) -> Result<Option<wgpu::Buffer>, PreviewError> {
        let scale = self.flat.scale() as f32;
        let mut blocks = given.blocks.to_vec();
        for (i, block) in blocks.iter_mut().enumerate() {
            // Lengths in units of the flattened scene; bumps stand on the mesh as rays meet it.
            block.params[0] *= scale;
            block.params[2] = self.flat.relief(i);
            block.params[3] *= scale;
        }
        let bytes: &[u8] = bytemuck::cast_slice(&blocks);
        if bytes.len() as u64 > self.objects.size() {
            return filled(device, queue, "ray objects", bytes).map(Some);
        }
        queue.write_buffer(&self.objects, 0, bytes);
        Ok(None)
    }

    pub fn bind(
        &self,
        device: &wgpu::Device,
        layout: &wgpu::BindGroupLayout,
        block: &wgpu::Buffer,
        sums: &wgpu::Buffer,
        given: &Given<'_>,
    ) -> wgpu::BindGroup {
        let buffers =
            [block, &self.nodes, &self.leaves, &self.vertices, &self.triangles, &self.light, &self.objects, given.albedos];
        let view = |binding, view| wgpu::BindGroupEntry { binding, resource: wgpu::BindingResource::TextureView(view) };
        let sampler = |binding, sampler| wgpu::BindGroupEntry { binding, resource: wgpu::BindingResource::Sampler(sampler) };
        let mut entries: Vec<_> = buffers
            .into_iter()
            .enumerate()
            .map(|(i, buffer)| wgpu::BindGroupEntry { binding: i as u32, resource: buffer.as_entire_binding() })
            .collect();
        entries.extend([
            view(8, given.environment.0),
            sampler(9, given.environment.1),
            view(10, given.maps.0),
            sampler(11, given.maps.1),
            wgpu::BindGroupEntry { binding: 12, resource: sums.as_entire_binding() },
        ]);
        device.create_bind_group(&wgpu::BindGroupDescriptor { label: Some("rays"), layout, entries: &entries })
    }
}

/// Room for the sums of a picture.
pub(super) fn sums(device: &wgpu::Device, [width, height]: [u32; 2]) -> Result<wgpu::Buffer, PreviewError> {
    let size = u64::from(width) * u64::from(height) * 16;
    buffer(device, "sums", size, wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST)
}

/// A storage buffer with these bytes, and room for at least one element of any type.
fn filled(device: &wgpu::Device, queue: &wgpu::Queue, label: &str, bytes: &[u8]) -> Result<wgpu::Buffer, PreviewError> {
    let size = (bytes.len() as u64).next_multiple_of(16).max(size_of::<ObjectBlock>() as u64);
    let made = buffer(device, label, size, wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST)?;
    if !bytes.is_empty() {
        queue.write_buffer(&made, 0, bytes);
    }
    Ok(made)
}

fn buffer(device: &wgpu::Device, label: &str, size: u64, usage: wgpu::BufferUsages) -> Result<wgpu::Buffer, PreviewError> {
    let limits = device.limits();
    let limit = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
    if size > limit {
        let sentence = format!("{label}: {} MB are needed and {} MB allowed", size >> 20, limit >> 20);
        return Err(PreviewError::Memory(sentence));
    }
    guarded(device, wgpu::ErrorFilter::OutOfMemory, PreviewError::Memory, || {
        device.create_buffer(&wgpu::BufferDescriptor { label: Some(label), size, usage, mapped_at_creation: false })
    })
}
