//! The textures that a picture is drawn into, and reading it back.

use super::device::{PreviewError, guarded};
use super::pipelines::{COLOR_FORMAT, DEPTH_FORMAT, DISPLAY_FORMAT, Layouts, MEAN_FORMAT, places};

/// The place of the picture that holds the rays' samples too, beside the two means.
pub(super) const BLENDED: usize = 2;

/// Textures of one picture size.
#[derive(Debug)]
pub(super) struct Targets {
    pub width: u32,
    pub height: u32,
    /// One frame.
    pub color: wgpu::TextureView,
    /// The same before the places of a pixel are averaged, if there are several.
    pub places: Option<wgpu::TextureView>,
    pub depth: wgpu::TextureView,
    /// Means of all frames so far: one is read while the other is written. The third is [`BLENDED`].
    means: [wgpu::Texture; 3],
    pub mean_views: [wgpu::TextureView; 3],
    /// Stands in for sums where there are none.
    no_sums: wgpu::Buffer,
    /// What is shown.
    pub display: wgpu::TextureView,
}

impl Targets {
    /// Makes textures of `width` times `height` pixels, both at least 1 and at most what the device allows.
    pub fn new(device: &wgpu::Device, width: u32, height: u32) -> Result<Self, PreviewError> {
        let size = wgpu::Extent3d { width, height, depth_or_array_layers: 1 };
        let make_of = |label, format, usage, sample_count| {
            device.create_texture(&wgpu::TextureDescriptor {
                label: Some(label),
                size,
                mip_level_count: 1,
                sample_count,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: usage | wgpu::TextureUsages::RENDER_ATTACHMENT,
                view_formats: &[],
            })
        };
        let make = |label, format, usage| make_of(label, format, usage, 1);
        let places = places(device);
        let nothing_else = wgpu::TextureUsages::empty();
        let view = |texture: &wgpu::Texture| texture.create_view(&wgpu::TextureViewDescriptor::default());
        guarded(device, wgpu::ErrorFilter::OutOfMemory, PreviewError::TooLarge, || {
            let read = wgpu::TextureUsages::TEXTURE_BINDING;
            let means = [(); 3].map(|()| make("mean", MEAN_FORMAT, read | wgpu::TextureUsages::COPY_SRC));
            let mean_views = [view(&means[0]), view(&means[1]), view(&means[BLENDED])];
            let no_sums = device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("no sums"),
                size: 16,
                usage: wgpu::BufferUsages::STORAGE,
                mapped_at_creation: false,
            });
            Self {
                width,
                height,
                color: view(&make("frame", COLOR_FORMAT, read)),
                places: (places > 1).then(|| view(&make_of("places", COLOR_FORMAT, nothing_else, places))),
                depth: view(&make_of("depth", DEPTH_FORMAT, nothing_else, places)),
                means,
                mean_views,
                no_sums,
                display: view(&make("display", DISPLAY_FORMAT, read | wgpu::TextureUsages::COPY_SRC)),
            }
        })
    }

    /// Bindings of a pass that reads `picture`, `before` and `sums`.
    pub fn bind(
        &self,
        device: &wgpu::Device,
        layouts: &Layouts,
        params: &wgpu::Buffer,
        picture: &wgpu::TextureView,
        before: &wgpu::TextureView,
        sums: Option<&wgpu::Buffer>,
    ) -> wgpu::BindGroup {
        device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("output"),
            layout: &layouts.output,
            entries: &[
                wgpu::BindGroupEntry { binding: 0, resource: params.as_entire_binding() },
                wgpu::BindGroupEntry { binding: 1, resource: wgpu::BindingResource::TextureView(picture) },
                wgpu::BindGroupEntry { binding: 2, resource: wgpu::BindingResource::TextureView(before) },
                wgpu::BindGroupEntry { binding: 3, resource: sums.unwrap_or(&self.no_sums).as_entire_binding() },
            ],
        })
    }

    /// Reads one of the means: linear radiance and coverage, row by row from the top.
    pub fn read(&self, device: &wgpu::Device, queue: &wgpu::Queue, which: usize) -> Result<Vec<[f32; 4]>, PreviewError> {
        let row = (self.width * 16).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let buffer = guarded(device, wgpu::ErrorFilter::OutOfMemory, PreviewError::Memory, || {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("read back"),
                size: u64::from(row) * u64::from(self.height),
                usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
                mapped_at_creation: false,
            })
        })?;
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("read back") });
        encoder.copy_texture_to_buffer(
            self.means[which].as_image_copy(),
            wgpu::TexelCopyBufferInfo {
                buffer: &buffer,
                layout: wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row), rows_per_image: None },
            },
            wgpu::Extent3d { width: self.width, height: self.height, depth_or_array_layers: 1 },
        );
        queue.submit([encoder.finish()]);
        let (sender, receiver) = std::sync::mpsc::channel();
        buffer.slice(..).map_async(wgpu::MapMode::Read, move |result| {
            // Nobody waits any more if the receiver is gone.
            _ = sender.send(result);
        });
        let failed = |e: &dyn std::fmt::Display| PreviewError::ReadBack(e.to_string());
        device.poll(wgpu::PollType::wait_indefinitely()).map_err(|e| failed(&e))?;
        receiver.recv().map_err(|e| failed(&e))?.map_err(|e| failed(&e))?;
        let mapped = buffer.slice(..).get_mapped_range().map_err(|e| failed(&e))?;
        let mut pixels = Vec::with_capacity((self.width * self.height) as usize);
        for line in mapped.chunks_exact(row as usize) {
            let line = &line[..self.width as usize * 16];
            pixels.extend(line.chunks_exact(16).map(bytemuck::pod_read_unaligned::<[f32; 4]>));
        }
        Ok(pixels)
    }
}
