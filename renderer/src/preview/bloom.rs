//! Bloom: what is brighter than the display can show spreads around. Only on the way to the display; nothing of it exists while it is off.

use super::device::{PreviewError, guarded};
use super::draw::screen_pass;
use super::pipelines::{COLOR_FORMAT, DISPLAY_FORMAT, Pipelines, compile, screen_pipeline};
use super::shader;
use super::targets::Targets;

/// Levels at most, each of half the size.
const LEVELS_MAX: u32 = 6;

/// Pipelines, and the levels for one size of picture.
#[derive(Debug)]
pub(super) struct Bloom {
    first: wgpu::RenderPipeline,
    halved: wgpu::RenderPipeline,
    added: wgpu::RenderPipeline,
    display: wgpu::RenderPipeline,
    size: (u32, u32),
    /// Excess, halved again and again.
    levels: Vec<wgpu::TextureView>,
    /// Sums of a level and all coarser ones; there is none of the coarsest.
    sums: Vec<wgpu::TextureView>,
}

impl Bloom {
    /// Compiles the passes.
    pub fn new(device: &wgpu::Device, pipelines: &Pipelines) -> Result<Self, PreviewError> {
        let module = compile(device, "bloom", &shader::bloom_pieces())?;
        let make = |entry: &str, format: wgpu::TextureFormat| {
            screen_pipeline(device, "bloom", &module, &pipelines.output_layout, ["vertex_output", entry], format.into(), None)
        };
        Ok(Self {
            first: make("fragment_first", COLOR_FORMAT)?,
            halved: make("fragment_halved", COLOR_FORMAT)?,
            added: make("fragment_added", COLOR_FORMAT)?,
            display: make("fragment_display_bloom", DISPLAY_FORMAT)?,
            size: (0, 0),
            levels: Vec::new(),
            sums: Vec::new(),
        })
    }

    /// Makes the levels for this size unless they are there.
    fn fit(&mut self, device: &wgpu::Device, width: u32, height: u32) -> Result<(), PreviewError> {
        if self.size == (width, height) {
            return Ok(());
        }
        let count = width.max(height).max(2).ilog2().clamp(1, LEVELS_MAX);
        let make = |level: u32| {
            let texture = device.create_texture(&wgpu::TextureDescriptor {
                label: Some("bloom"),
                size: wgpu::Extent3d {
                    width: width.div_ceil(2 << level),
                    height: height.div_ceil(2 << level),
                    depth_or_array_layers: 1,
                },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format: COLOR_FORMAT,
                usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::RENDER_ATTACHMENT,
                view_formats: &[],
            });
            texture.create_view(&wgpu::TextureViewDescriptor::default())
        };
        let (levels, sums) = guarded(device, wgpu::ErrorFilter::OutOfMemory, PreviewError::TooLarge, || {
            ((0..count).map(make).collect(), (0..count - 1).map(make).collect())
        })?;
        (self.levels, self.sums, self.size) = (levels, sums, (width, height));
        Ok(())
    }

    /// Puts `picture` on the display with its bloom. `params`: the block of the display pass.
    pub fn show(
        &mut self,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        (pipelines, targets): (&Pipelines, &Targets),
        params: &wgpu::Buffer,
        picture: &wgpu::TextureView,
    ) -> Result<(), PreviewError> {
        self.fit(device, targets.width, targets.height)?;
        let mut pass = |to: &wgpu::TextureView, pipeline, from: &wgpu::TextureView, before: &wgpu::TextureView| {
            let bind = targets.bind(device, &pipelines.layouts, params, from, before, None);
            screen_pass(encoder, to, pipeline, &bind, None);
        };
        // What a pass does not read must still be bound, and be another texture than it writes.
        pass(&self.levels[0], &self.first, picture, &targets.color);
        for pair in self.levels.windows(2) {
            pass(&pair[1], &self.halved, &pair[0], &targets.color);
        }
        let mut coarser = &self.levels[self.levels.len() - 1];
        for (sum, level) in self.sums.iter().zip(&self.levels).rev() {
            pass(sum, &self.added, coarser, level);
            coarser = sum;
        }
        pass(&targets.display, &self.display, picture, coarser);
        Ok(())
    }
}
