//! What goes to the device: vertices, baked light, material rows, texture maps. Mirrors the structs in the WGSL files.

use super::device::{PreviewError, guarded};
use super::environment::{Level, half_texels};
use crate::scene::Object;
use burnish_assets::{Image, Mesh};
use burnish_material::{Channel, ColorSpace, Kind, PROPERTIES, PROPERTY_COUNT, Property, TextureRef, Vary, Wrap};
use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use wgpu::util::DeviceExt;

/// Textured properties at most: one layer of the map array each.
pub(super) const MAPS_MAX: usize = 32;
/// Largest side of a map; larger images are sampled down.
const MAP_SIDE_MAX: usize = 1024;

/// `struct Frame` of `frame.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(super) struct FrameBlock {
    pub origin: [f32; 4],
    pub right_inverse: [f32; 4],
    pub up_inverse: [f32; 4],
    pub right: [f32; 4],
    pub up: [f32; 4],
    pub forward: [f32; 4],
    pub jitter: [f32; 4],
    pub environment: [f32; 4],
    pub floor: [f32; 4],
    pub floor_mean: [f32; 4],
    pub floor_open: [f32; 4],
    pub samples: [f32; 4],
    pub body: [f32; 4],
}

/// `struct Object` of `object.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(super) struct ObjectBlock {
    pub rows: [[f32; 4]; PROPERTY_COUNT],
    pub map_matrix: [[f32; 4]; MAPS_MAX],
    pub map_shift: [[f32; 4]; MAPS_MAX],
    pub params: [f32; 4],
}

/// `struct VertexIn` of `vertex.wgsl`, the part that never changes.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(super) struct Vertex {
    position: [f32; 3],
    normal: [f32; 3],
    tangent: [f32; 4],
    uv: [f32; 2],
}

/// The part of a vertex that is baked.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub(super) struct BakedVertex {
    /// Light taken or added, and the share of the body itself.
    pub light: [f32; 4],
    /// Spherical harmonics of what covers the surroundings; nine are used.
    pub covered: [f32; 12],
}

/// Attributes of [`Vertex`].
pub(super) const VERTEX_ATTRIBUTES: [wgpu::VertexAttribute; 4] =
    wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3, 2 => Float32x4, 3 => Float32x2];
/// Attributes of [`BakedVertex`].
pub(super) const BAKED_ATTRIBUTES: [wgpu::VertexAttribute; 4] =
    wgpu::vertex_attr_array![4 => Float32x4, 5 => Float32x4, 6 => Float32x4, 7 => Float32x4];

/// A mesh on the device.
#[derive(Debug)]
pub(super) struct MeshBuffers {
    pub vertices: wgpu::Buffer,
    pub baked: wgpu::Buffer,
    pub indices: wgpu::Buffer,
    pub index_count: u32,
}

/// Uploads a mesh with nothing baked yet.
pub(super) fn upload_mesh(device: &wgpu::Device, mesh: &Mesh) -> Result<MeshBuffers, PreviewError> {
    let count = mesh.positions.len();
    let vertices: Vec<Vertex> = (0..count)
        .map(|i| Vertex {
            position: mesh.positions[i].into(),
            normal: mesh.normals.get(i).copied().unwrap_or(Vec3::Y).into(),
            tangent: mesh.tangents.get(i).map_or([1.0, 0.0, 0.0, 1.0], |t| t.to_array()),
            uv: mesh.uvs.get(i).copied().unwrap_or_default().into(),
        })
        .collect();
    let baked = vec![BakedVertex::default(); count];
    let make = |label, contents: &[u8], usage| {
        device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: Some(label), contents, usage })
    };
    guarded(device, wgpu::ErrorFilter::OutOfMemory, PreviewError::Memory, || MeshBuffers {
        vertices: make("vertices", bytemuck::cast_slice(&vertices), wgpu::BufferUsages::VERTEX),
        baked: make("baked light", bytemuck::cast_slice(&baked), wgpu::BufferUsages::VERTEX | wgpu::BufferUsages::COPY_DST),
        indices: make("indices", bytemuck::cast_slice(&mesh.triangles), wgpu::BufferUsages::INDEX),
        index_count: mesh.triangles.len() as u32 * 3,
    })
}

/// The uniform block of an object whose albedos begin at a place of the tables; textures get their layers in the order of the
/// property table.
pub(super) fn object_block(object: &Object, albedos: u32) -> ObjectBlock {
    let mut block = ObjectBlock {
        rows: [[0.0; 4]; PROPERTY_COUNT],
        map_matrix: [[1.0, 0.0, 0.0, 1.0]; MAPS_MAX],
        map_shift: [[0.0; 4]; MAPS_MAX],
        params: [object.length_scale as f32, albedos as f32, 0.0, 0.0],
    };
    for def in PROPERTIES {
        block.rows[def.id as usize] = object.material.value(def.id).row();
    }
    for (layer, (property, reference, _)) in mapped(object).into_iter().enumerate() {
        block.rows[property as usize][3] = layer as f32;
        let (sin, cos) = reference.uv_rotation.to_radians().sin_cos();
        let [sx, sy] = reference.uv_scale;
        // Counterclockwise in an image whose v grows downwards.
        block.map_matrix[layer] = [cos * sx, sin * sy, -sin * sx, cos * sy].map(|x| x as f32);
        let wrap = match reference.wrap {
            Wrap::Repeat => 0.0,
            Wrap::Clamp => 1.0,
            Wrap::Mirror => 2.0,
        };
        block.map_shift[layer] = [reference.uv_offset[0] as f32, reference.uv_offset[1] as f32, wrap, 0.0];
    }
    block
}

/// Properties with a texture whose image is there, in the order of the table.
pub(super) fn mapped(object: &Object) -> Vec<(Property, &TextureRef, &Image)> {
    PROPERTIES
        .iter()
        .filter(|def| def.vary != Vary::Uniform)
        .filter_map(|def| {
            let reference = object.material.slot(def.id).texture.as_ref()?;
            let image = object.textures.get(&reference.path)?;
            let is_whole = image.width > 0 && image.height > 0 && image.texels.len() >= image.width * image.height;
            is_whole.then_some((def.id, reference, image.as_ref()))
        })
        .take(MAPS_MAX)
        .collect()
}

/// One texel of an image as the property means it: linear colour, a number in all channels, or a direction.
fn decode(texel: [f32; 4], property: Property, reference: &TextureRef, image: &Image) -> Vec3 {
    let def = property.def();
    let is_srgb = match reference.color_space {
        ColorSpace::Srgb => true,
        ColorSpace::Linear => false,
        ColorSpace::Auto => image.is_eight_bit && def.default.kind() == Kind::Color,
    };
    let linear = |x: f32| if is_srgb { crate::tonemap::srgb_decode(x) } else { x };
    let [r, g, b, a] = texel;
    let picked = match reference.channel {
        Channel::Rgb => None,
        Channel::R => Some(linear(r)),
        Channel::G => Some(linear(g)),
        Channel::B => Some(linear(b)),
        Channel::A => Some(a),
    };
    let color = picked.map_or_else(|| Vec3::new(linear(r), linear(g), linear(b)), Vec3::splat);
    match def.default.kind() {
        Kind::Color => color,
        Kind::Normal => color * 2.0 - 1.0,
        Kind::Float | Kind::Bool => Vec3::splat(picked.unwrap_or((color.x + color.y + color.z) / 3.0)),
    }
}

/// Uploads the maps of an object as one array of textures with mip levels; a single texel if it has none.
pub(super) fn upload_maps(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    object: &Object,
) -> Result<wgpu::TextureView, PreviewError> {
    let maps = mapped(object);
    let longest = |f: fn(&Image) -> usize| maps.iter().map(|(_, _, image)| f(image)).max().unwrap_or(1).min(MAP_SIDE_MAX);
    let (width, height) = (longest(|i| i.width), longest(|i| i.height));
    let levels = width.max(height).ilog2() + 1;
    let layers = maps.len().max(1) as u32;
    let texture = texture(device, "material maps", (width, height, layers), levels)?;
    for (layer, (property, reference, image)) in maps.iter().enumerate() {
        let mut level = Level { width, height, texels: Vec::with_capacity(width * height) };
        for j in 0..height {
            for i in 0..width {
                let (x, y) = (i * image.width / width, j * image.height / height);
                level.texels.push(decode(image.texels[y * image.width + x], *property, reference, image));
            }
        }
        for mip in 0..levels {
            write_level(queue, &texture, mip, layer as u32, &level);
            level = halve(&level);
        }
    }
    Ok(texture
        .create_view(&wgpu::TextureViewDescriptor { dimension: Some(wgpu::TextureViewDimension::D2Array), ..Default::default() }))
}

/// Half the size by plain means.
pub(super) fn halve(from: &Level) -> Level {
    let (width, height) = ((from.width / 2).max(1), (from.height / 2).max(1));
    let at = |x: usize, y: usize| from.texels[y.min(from.height - 1) * from.width + x.min(from.width - 1)];
    let mut texels = Vec::with_capacity(width * height);
    for j in 0..height {
        for i in 0..width {
            texels.push((at(2 * i, 2 * j) + at(2 * i + 1, 2 * j) + at(2 * i, 2 * j + 1) + at(2 * i + 1, 2 * j + 1)) * 0.25);
        }
    }
    Level { width, height, texels }
}

/// An `Rgba16Float` texture to sample from.
pub(super) fn texture(
    device: &wgpu::Device,
    label: &str,
    (width, height, layers): (usize, usize, u32),
    levels: u32,
) -> Result<wgpu::Texture, PreviewError> {
    guarded(device, wgpu::ErrorFilter::OutOfMemory, PreviewError::Memory, || {
        device.create_texture(&wgpu::TextureDescriptor {
            label: Some(label),
            size: wgpu::Extent3d { width: width as u32, height: height as u32, depth_or_array_layers: layers },
            mip_level_count: levels,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Rgba16Float,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        })
    })
}

/// Fills one level of one layer.
pub(super) fn write_level(queue: &wgpu::Queue, texture: &wgpu::Texture, mip: u32, layer: u32, level: &Level) {
    let texels = half_texels(&level.texels);
    queue.write_texture(
        wgpu::TexelCopyTextureInfo {
            texture,
            mip_level: mip,
            origin: wgpu::Origin3d { x: 0, y: 0, z: layer },
            aspect: wgpu::TextureAspect::All,
        },
        bytemuck::cast_slice(&texels),
        wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(level.width as u32 * 8),
            rows_per_image: Some(level.height as u32),
        },
        wgpu::Extent3d { width: level.width as u32, height: level.height as u32, depth_or_array_layers: 1 },
    );
}

/// A texture with these levels.
pub(super) fn upload_levels(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    label: &str,
    levels: &[Level],
) -> Result<wgpu::TextureView, PreviewError> {
    let Some(base) = levels.first() else { return upload_levels(device, queue, label, &[black()]) };
    let texture = texture(device, label, (base.width, base.height, 1), levels.len() as u32)?;
    for (mip, level) in levels.iter().enumerate() {
        write_level(queue, &texture, mip as u32, 0, level);
    }
    Ok(texture.create_view(&wgpu::TextureViewDescriptor::default()))
}

/// A single black texel.
pub(super) fn black() -> Level {
    Level { width: 1, height: 1, texels: vec![Vec3::ZERO] }
}

/// The level and all its halves.
pub(super) fn chain(base: Level) -> Vec<Level> {
    let mut levels = vec![base];
    while let Some(last) = levels.last().filter(|l| l.width > 1 || l.height > 1) {
        levels.push(halve(last));
    }
    levels
}

#[cfg(test)]
mod tests {
    use super::*;
    use burnish_material::Material;
    use std::sync::Arc;

    #[test]
    fn rows_follow_the_table() {
        let object = Object {
            mesh: Arc::default(),
            material: Arc::new(Material::default()),
            textures: Arc::default(),
            is_document: true,
            length_scale: 1.0,
        };
        let block = object_block(&object, 1024);
        assert_eq!(block.rows[Property::roughness as usize], [0.3, 0.3, 0.3, -1.0]);
        assert_eq!(block.params[1], 1024.0);
        assert_eq!(std::mem::size_of::<ObjectBlock>(), (PROPERTY_COUNT + 2 * MAPS_MAX + 1) * 16);
    }
}
