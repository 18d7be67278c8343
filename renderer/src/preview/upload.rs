//! What goes to the device: vertices, baked light, material rows, texture maps. Mirrors the structs in the WGSL files.

use super::device::{PreviewError, guarded};
use super::environment::{Level, half_texels};
use crate::scene::{Object, TextureSet};
use burnish_assets::{Image, Mesh};
use burnish_material::{PROPERTIES, PROPERTY_COUNT, Property, TextureRef, Vary, Wrap};
use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use std::sync::Arc;

/// Textured properties at most: one layer of the map array each.
pub(super) const MAPS_MAX: usize = 32;
/// Largest side of a map; larger images are sampled down.
const MAP_SIDE_MAX: usize = 1024;

/// How a height map shows, in `ObjectBlock::params`: 0 not at all, in normals, or in the triangles as well.
pub(super) const BUMPED: f32 = 1.0;
pub(super) const DISPLACED: f32 = 2.0;

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
    pub floor_extent: [f32; 4],
    pub floor_mean: [f32; 4],
    pub floor_open: [f32; 4],
    pub samples: [f32; 4],
    pub body: [f32; 4],
    pub stand: [f32; 4],
    pub sent_on: [f32; 4],
    pub shine: [f32; 4],
}

/// `struct Object` of `maps.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(super) struct ObjectBlock {
    pub rows: [[f32; 4]; PROPERTY_COUNT],
    /// Per map its matrix and its shift.
    pub maps: [[[f32; 4]; 2]; MAPS_MAX],
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
    /// Nine spherical harmonics of what covers the surroundings; the solid angle of it that is another body, and the luminance of that if it
    /// were white, summed over it.
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

/// Uploads a mesh with nothing baked yet; one that replaces another of as many vertices takes over what was baked for those.
pub(super) fn upload_mesh(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    mesh: &Mesh,
    previous: Option<&MeshBuffers>,
) -> Result<MeshBuffers, PreviewError> {
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
    let kept = previous.map(|buffers| &buffers.baked).filter(|kept| kept.size() == size_of_val(&baked[..]) as u64);
    let make = |label, contents: &[u8], usage| filled(device, queue, label, contents, usage);
    Ok(MeshBuffers {
        vertices: make("vertices", bytemuck::cast_slice(&vertices), wgpu::BufferUsages::VERTEX)?,
        baked: match kept {
            Some(kept) => kept.clone(),
            None => make("baked light", bytemuck::cast_slice(&baked), wgpu::BufferUsages::VERTEX)?,
        },
        indices: make("indices", bytemuck::cast_slice(&mesh.triangles), wgpu::BufferUsages::INDEX)?,
        index_count: mesh.triangles.len() as u32 * 3,
    })
}

/// A buffer with these bytes, a multiple of four. It is written and not mapped: mapping what there is no memory for panics.
pub(super) fn filled(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    label: &str,
    bytes: &[u8],
    usage: wgpu::BufferUsages,
) -> Result<wgpu::Buffer, PreviewError> {
    let usage = usage | wgpu::BufferUsages::COPY_DST;
    guarded(device, wgpu::ErrorFilter::OutOfMemory, PreviewError::Memory, || {
        let size = bytes.len() as u64;
        let buffer = device.create_buffer(&wgpu::BufferDescriptor { label: Some(label), size, usage, mapped_at_creation: false });
        if !bytes.is_empty() {
            queue.write_buffer(&buffer, 0, bytes);
        }
        buffer
    })
}

/// The uniform block of an object whose albedos begin at a place of the tables and whose maps begin at a layer; they follow each other in the
/// order of the property table.
pub(super) fn object_block(object: &Object, albedos: u32, first_layer: u32) -> ObjectBlock {
    let mut block = ObjectBlock {
        rows: [[0.0; 4]; PROPERTY_COUNT],
        maps: [[[1.0, 0.0, 0.0, 1.0], [0.0; 4]]; MAPS_MAX],
        params: [object.length_scale as f32, albedos as f32, 0.0, 0.0],
    };
    let inputs = object.material.inputs();
    block.params[3] = (inputs.height_scale * object.length_scale).clamp(-1e20, 1e20) as f32;
    for def in PROPERTIES {
        block.rows[def.id as usize] = object.material.value(def.id).row();
    }
    for (layer, (property, reference, _)) in mapped(object).into_iter().enumerate() {
        block.rows[property as usize][3] = layer as f32;
        if property == Property::height {
            block.params[2] = BUMPED;
        }
        let [[uu, uv, _], [vu, vv, _]] = reference.transform();
        let matrix = [uu, uv, vu, vv].map(|x| x as f32);
        let wrap = match reference.wrap {
            Wrap::Repeat => 0.0,
            Wrap::Clamp => 1.0,
            Wrap::Mirror => 2.0,
        };
        let layer_of_array = first_layer as f32 + layer as f32;
        block.maps[layer] = [matrix, [reference.uv_offset[0] as f32, reference.uv_offset[1] as f32, wrap, layer_of_array]];
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

/// One texel of an image as the property means it.
fn decode(texel: [f32; 4], property: Property, reference: &TextureRef, image: &Image) -> Vec3 {
    Vec3::from(crate::texel::decode(texel, property, reference, image.is_eight_bit))
}

/// The images of a scene's materials as one array of textures with mip levels.
#[derive(Debug)]
pub(super) struct Maps {
    pub view: wgpu::TextureView,
    /// The layer that the maps of each object begin at.
    pub first_layers: Vec<u32>,
    /// What was uploaded: images and references by object.
    key: Vec<MapsKey>,
}

/// Images and references of one object.
#[derive(Debug)]
struct MapsKey {
    textures: Arc<TextureSet>,
    references: Vec<(Property, TextureRef)>,
}

impl MapsKey {
    fn of(object: &Object) -> Self {
        let references = mapped(object).into_iter().map(|(property, reference, _)| (property, reference.clone())).collect();
        Self { textures: object.textures.clone(), references }
    }

    fn is_of(&self, object: &Object) -> bool {
        let references = mapped(object);
        self.references.len() == references.len()
            && (references.is_empty() || Arc::ptr_eq(&self.textures, &object.textures))
            && self.references.iter().zip(references).all(|(a, b)| a.0 == b.0 && a.1 == *b.1)
    }
}

impl Maps {
    /// Whether these are the maps of the objects.
    pub fn are_of(&self, objects: &[Object]) -> bool {
        self.key.len() == objects.len() && self.key.iter().zip(objects).all(|(key, object)| key.is_of(object))
    }

    /// Uploads the maps of all objects; a single texel if there are none. Objects with the same maps share them.
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue, objects: &[Object]) -> Result<Self, PreviewError> {
        let mut key: Vec<MapsKey> = Vec::new();
        let mut first_layers = Vec::new();
        let mut wanted = Vec::new();
        for object in objects {
            let same = key.iter().position(|k| !k.references.is_empty() && k.is_of(object));
            first_layers.push(same.map_or(wanted.len() as u32, |i| first_layers[i]));
            if same.is_none() {
                wanted.extend(mapped(object));
            }
            key.push(MapsKey::of(object));
        }
        // Beyond what the device can hold, maps repeat the first one: nothing better is at hand, and the picture stays whole.
        wanted.truncate(device.limits().max_texture_array_layers as usize);
        let longest = |f: fn(&Image) -> usize| wanted.iter().map(|(_, _, image)| f(image)).max().unwrap_or(1).min(MAP_SIDE_MAX);
        let (width, height) = (longest(|i| i.width), longest(|i| i.height));
        let levels = width.max(height).ilog2() + 1;
        let texture = texture(device, "material maps", (width, height, wanted.len().max(1) as u32), levels)?;
        for (layer, (property, reference, image)) in wanted.iter().enumerate() {
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
        let view = texture.create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(wgpu::TextureViewDimension::D2Array),
            ..Default::default()
        });
        Ok(Self { view, first_layers, key })
    }
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
    use burnish_material::Channel;
    use burnish_material::Material;

    #[test]
    fn inverted_texels_are_those_of_the_final_view() {
        let image = Image { width: 1, height: 1, texels: vec![[0.2, 0.5, 0.8, 0.25]], is_eight_bit: true };
        let read = |property, channel| {
            let reference = TextureRef { is_inverted: true, channel, ..TextureRef::new("a") };
            decode(image.texels[0], property, &reference, &image)
        };
        let is_near = |a: Vec3, b: [f32; 3]| assert!((a - Vec3::from(b)).abs().max_element() < 1e-5, "{a} and {b:?}");
        is_near(read(Property::roughness, Channel::Rgb), [0.5; 3]);
        is_near(read(Property::roughness, Channel::A), [0.75; 3]);
        is_near(read(Property::normal, Channel::Rgb), [-0.6, 0.0, 0.6]);
        let srgb = |x: f32| 1.0 - crate::tonemap::srgb_decode(x);
        is_near(read(Property::base_color, Channel::Rgb), [srgb(0.2), srgb(0.5), srgb(0.8)]);
    }

    #[test]
    fn scaled_texels_are_those_of_the_final_view() {
        let image = Image { width: 1, height: 1, texels: vec![[0.25, 0.5, 0.75, 0.125]], is_eight_bit: false };
        let read = |property, channel| {
            let (scale, bias) = ([2.0, 0.5, 1.0], [0.125, -1.0, 0.0]);
            decode(image.texels[0], property, &TextureRef { scale, bias, channel, ..TextureRef::new("a") }, &image)
        };
        assert_eq!(read(Property::base_color, Channel::Rgb), Vec3::new(0.625, -0.75, 0.75));
        assert_eq!(read(Property::base_color, Channel::A), Vec3::new(0.375, -0.9375, 0.125));
        assert_eq!(read(Property::roughness, Channel::Rgb), Vec3::splat(1.125));
        assert_eq!(read(Property::height, Channel::A), Vec3::splat(0.375));
        assert_eq!(read(Property::normal, Channel::Rgb), Vec3::new(-0.5, 0.0, 0.5));
    }

    #[test]
    fn rows_follow_the_table() {
        let object = Object {
            mesh: Arc::default(),
            material: Arc::new(Material::default()),
            textures: Arc::default(),
            is_document: true,
            length_scale: 1.0,
        };
        let block = object_block(&object, 1024, 0);
        assert_eq!(block.rows[Property::roughness as usize], [0.3, 0.3, 0.3, -1.0]);
        assert_eq!(block.params[1], 1024.0);
        assert_eq!(std::mem::size_of::<ObjectBlock>(), (PROPERTY_COUNT + 2 * MAPS_MAX + 1) * 16);
    }
}
