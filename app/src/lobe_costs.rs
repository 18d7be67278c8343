//! What each lobe takes of a frame of the preview: pictures with and without it in turn, on a device of their own.

use burnish_material::LobeSet;
use burnish_renderer::preview::{self, Preview, PreviewError};
use burnish_renderer::scene::Scene;
use burnish_renderer::tonemap::Display;
use egui_wgpu::wgpu;
use std::time::Instant;

/// Lobes that a picture is drawn with beside those that the material needs, and without although it needs them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Change {
    /// Evaluated as well; the picture stays the same.
    pub more: LobeSet,
    /// Left out; the picture becomes another.
    pub less: LobeSet,
}

impl Change {
    /// What tells the cost of a lobe: the material without it, or with it where it is not needed; and 1 or -1, by which the difference of
    /// both times is to be multiplied.
    pub fn of(lobe: burnish_material::Lobe, needed: LobeSet) -> (Self, f64) {
        let set = LobeSet::EMPTY.with(lobe);
        if needed.has(lobe) {
            (Self { less: set, ..Self::default() }, -1.0)
        } else {
            (Self { more: set, ..Self::default() }, 1.0)
        }
    }
}

/// A preview without a window that pictures are timed with. Rays are left out: what a value costs under the hand is the drawn picture.
pub struct Meter {
    device: wgpu::Device,
    queue: wgpu::Queue,
    preview: Preview,
    size: [u32; 2],
    /// Name of the graphics adapter.
    pub adapter: String,
    /// Seconds that the material's own pipelines took to compile.
    pub compile: f64,
}

impl Meter {
    /// Prepares a scene for pictures of this size, in pixels.
    pub fn new(scene: &Scene, size: [u32; 2]) -> Result<Self, PreviewError> {
        let (adapter, device, queue) = preview::headless_device()?;
        let limit = device.limits().max_texture_dimension_2d;
        let mut preview = Preview::new(&device, &queue)?;
        preview.set_scene(&device, &queue, scene);
        preview.set_rays(false);
        let compile = preview.compile(&device)?.as_secs_f64();
        preview.settle(&device, &queue)?;
        let size = size.map(|side| side.clamp(1, limit));
        Ok(Self { device, queue, preview, size, adapter: adapter.get_info().name, compile })
    }

    /// Takes smaller pictures where one takes longer than `limit` seconds. Returns how many times as many pixels there were.
    pub fn hurry(&mut self, limit: f64) -> Result<f64, PreviewError> {
        let whole = self.size;
        while self.frame()? > limit && self.size.iter().all(|side| *side >= 128) {
            self.size = self.size.map(|side| side / 2);
        }
        let pixels = |[width, height]: [u32; 2]| f64::from(width) * f64::from(height);
        Ok(pixels(whole) / pixels(self.size))
    }

    /// Seconds of the fastest frame with the first change and with the second (whatever else the machine does only adds), and seconds that the second took to compile.
    pub fn compare(&mut self, changes: [Change; 2], repeats: usize) -> Result<([f64; 2], f64), PreviewError> {
        let mut compiled = 0.0;
        for change in changes {
            self.preview.set_lobes(change.more, change.less);
            compiled = self.preview.compile(&self.device)?.as_secs_f64();
            self.frame()?;
        }
        let mut times = [Vec::new(), Vec::new()];
        for _ in 0..repeats {
            for (change, times) in changes.into_iter().zip(&mut times) {
                self.preview.set_lobes(change.more, change.less);
                times.push(self.frame()?);
            }
        }
        Ok((times.map(|times| times.into_iter().fold(f64::INFINITY, f64::min)), compiled))
    }

    fn frame(&mut self) -> Result<f64, PreviewError> {
        let start = Instant::now();
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        self.preview.draw(&self.device, &self.queue, &mut encoder, self.size[0], self.size[1], Display::default());
        self.queue.submit([encoder.finish()]);
        self.device.poll(wgpu::PollType::wait_indefinitely()).map_err(|e| PreviewError::ReadBack(e.to_string()))?;
        self.preview.error().map_or_else(|| Ok(start.elapsed().as_secs_f64()), |error| Err(error.clone()))
    }
}
