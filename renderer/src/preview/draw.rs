//! Drawing a picture: objects front to back, the mean of many frames, the rays beside it, the way to the display.

use super::device::PreviewError;
use super::rays::{self, Rays};
use super::targets::{BLENDED, Targets};
use super::timing::Timing;
use super::upload::ObjectBlock;
use super::{Crop, Drawn, Preview, STEPS_BESIDE_RAYS, STEPS_MAX, pipelines, upload};
use crate::tonemap::Display;
use burnish_material::{Lobe, LobeSet};
use std::sync::Arc;

/// Seconds that a tile is taken to need where none was measured: on hardware, and by a program on the processor.
const TILE_SECONDS: [f64; 2] = [2e-6, 1e-3];

impl Preview {
    pub(super) fn draw_frame(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        encoder: &mut wgpu::CommandEncoder,
        width: u32,
        height: u32,
        display: Display,
    ) -> Result<bool, PreviewError> {
        self.take_finished(device, queue)?;
        if self.scene.is_none() {
            return Ok(false);
        }
        let limit = device.limits().max_texture_dimension_2d;
        let (width, height) = (width.clamp(1, limit), height.clamp(1, limit));
        if self.targets.as_ref().is_none_or(|t| (t.width, t.height) != (width, height)) {
            self.targets = Some(Targets::new(device, width, height)?);
            self.restart();
        }
        self.take_baked(device, queue)?;
        self.timing.begin();
        self.tiles = 0;
        let is_first = self.steps == 0;
        self.draw_mean(device, queue, encoder, [width, height])?;
        // The first picture stands alone: whoever drags a value waits for nothing else.
        if !is_first && self.wants_rays() && self.prepare_rays(device, queue, [width, height], false) {
            self.trace_rays(device, queue, encoder, [width, height])?;
        }
        self.is_blended = self.rays.has_any();
        self.show(device, queue, encoder, display)?;
        self.timing.end(encoder);
        let wants_drawn = self.steps < self.steps_wanted() || self.is_provisional || self.is_settling();
        Ok(wants_drawn || self.wants_rays())
    }

    /// Frames after which drawing more changes nothing.
    fn steps_wanted(&self) -> u32 {
        if self.has_rays && self.rays.problem().is_none() { STEPS_BESIDE_RAYS } else { STEPS_MAX }
    }

    fn wants_rays(&self) -> bool {
        self.has_rays && self.rays.wants_more()
    }

    /// The picture is another one: nothing drawn or traced so far counts.
    pub(super) fn restart(&mut self) {
        self.steps = 0;
        self.rays.restart();
    }

    /// Draws frames and adds them to the mean.
    fn draw_mean(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        encoder: &mut wgpu::CommandEncoder,
        [width, height]: [u32; 2],
    ) -> Result<(), PreviewError> {
        let Some(scene) = self.scene.clone() else { return Ok(()) };
        let mut order: Vec<usize> = (0..self.objects.len()).collect();
        let is_cut = |d: &Drawn| d.lobes.has(Lobe::opacity);
        let distance = |d: &Drawn| d.object.mesh.bounds().center().distance(scene.camera.origin);
        order.sort_by(|&a, &b| {
            let (a, b) = (&self.objects[a], &self.objects[b]);
            is_cut(a).cmp(&is_cut(b)).then(if is_cut(a) {
                distance(b).total_cmp(&distance(a))
            } else {
                std::cmp::Ordering::Equal
            })
        });
        let mut objects = Vec::with_capacity(order.len());
        let mut is_fitting = true;
        for drawn in order.iter().map(|&i| &self.objects[i]) {
            let (made, fits) = self.pipelines.for_lobes(device, drawn.kind(), false)?;
            is_fitting &= fits;
            objects.push((drawn, made));
        }
        if self.is_provisional && is_fitting {
            self.steps = 0;
        }
        self.is_provisional = !is_fitting;

        let Some(targets) = &self.targets else { return Ok(()) };
        if self.steps >= self.steps_wanted() {
            return Ok(());
        }
        let step = self.steps;
        let block = self.frame_block(&scene, width, height, step);
        queue.write_buffer(&self.frame_buffer, 0, bytemuck::bytes_of(&block));
        let Some(frame) = &self.frame_bind else { return Ok(()) };
        draw_objects(encoder, targets, frame, &self.pipelines.background, &objects, self.timing.render("draw"));
        let params: [f32; 8] = [1.0 / (step + 1) as f32, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        let [of_mean, _] = &self.output_buffers;
        queue.write_buffer(of_mean, 0, bytemuck::cast_slice(&params));
        let [to, from] = [step as usize % 2, (step as usize + 1) % 2];
        let (layouts, before) = (&self.pipelines.layouts, &targets.mean_views[from]);
        let bind = targets.bind(device, layouts, of_mean, &targets.color, before, None);
        screen_pass(encoder, &targets.mean_views[to], &self.pipelines.mean, &bind, self.timing.render("mean"));
        self.steps += 1;
        Ok(())
    }

    /// Which of the targets is shown.
    pub(super) fn shown(&self) -> usize {
        if self.is_blended { BLENDED } else { (self.steps as usize + 1) % 2 }
    }

    /// Blends the mean with the rays' samples and puts it on the display.
    fn show(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        encoder: &mut wgpu::CommandEncoder,
        display: Display,
    ) -> Result<(), PreviewError> {
        let Some(targets) = &self.targets else { return Ok(()) };
        let [fades, gone] = rays::DRAWN_FADES;
        let (ev, transform) = (display.exposure_ev, display.transform as u32 as f32);
        let params: [f32; 8] = [0.0, ev, transform, 0.0, rays::DRAWN_COUNTS, fades, gone, f32::from(u8::from(self.is_blended))];
        let ([_, block], layouts) = (&self.output_buffers, &self.pipelines.layouts);
        queue.write_buffer(block, 0, bytemuck::cast_slice(&params));
        let mean = (self.steps as usize + 1) % 2;
        if self.is_blended {
            let bind = targets.bind(device, layouts, block, &targets.mean_views[mean], &targets.color, self.rays.sums());
            let times = self.timing.render("blend");
            screen_pass(encoder, &targets.mean_views[BLENDED], &self.pipelines.blend, &bind, times);
        }
        let shown = &targets.mean_views[self.shown()];
        if let Some(bloom) = &mut self.bloom {
            return bloom.show(device, encoder, (&self.pipelines, targets), block, shown);
        }
        let bind = targets.bind(device, layouts, block, shown, &targets.color, None);
        screen_pass(encoder, &targets.display, &self.pipelines.display, &bind, self.timing.render("display"));
        Ok(())
    }

    /// Gets what rays need. Whether samples can be added; with `wait` that is so unless there is a problem.
    pub(super) fn prepare_rays(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, size: [u32; 2], wait: bool) -> bool {
        self.with_rays(size, |rays, given| rays.prepare(device, queue, given, wait)).unwrap_or(false)
    }

    fn trace_rays(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        encoder: &mut wgpu::CommandEncoder,
        size: [u32; 2],
    ) -> Result<(), PreviewError> {
        // Where nothing is measured, a guess that is too slow rather than too fast. A software adapter does the work after it has taken the
        // time, so whoever waits for it measures instead.
        let times = self.timing.last();
        let is_software = device.adapter_info().device_type == wgpu::DeviceType::Cpu;
        let by_device = 1e-3 * times.of("rays") / f64::from(times.tiles.max(1));
        let measured = if is_software { self.tile_seconds } else { by_device };
        let tile_seconds = if measured > 0.0 { measured } else { TILE_SECONDS[usize::from(is_software)] };
        let tiles = ((self.patience / tile_seconds).min(f64::from(Rays::tiles(size))) as u32).max(1);
        // Taken out for the while, so that the rest of the preview can be lent to the rays.
        let mut timing = std::mem::replace(&mut self.timing, Timing::none());
        self.tiles = tiles;
        let writes = timing.compute("rays", tiles);
        let traced =
            self.with_rays(size, |rays, given| rays.trace(device, queue, encoder, given, tiles, writes)).unwrap_or(Ok(()));
        self.timing = timing;
        traced
    }

    /// Calls `work` with the rays and what they need; `None` while there is no scene.
    fn with_rays<T>(&mut self, size: [u32; 2], work: impl FnOnce(&mut Rays, &rays::Given<'_>) -> T) -> Option<T> {
        let scene = self.scene.clone()?;
        let frame = self.frame_block(&scene, size[0], size[1], 0);
        let (light, maps) = (self.light.as_ref()?, self.maps.as_ref()?);
        let lobes = self.objects.iter().fold(LobeSet::EMPTY, |set, drawn| set.union(drawn.lobes));
        let values: Vec<ObjectBlock> = self.objects.iter().map(|drawn| drawn.values).collect();
        let given = rays::Given {
            scene: &scene,
            environment_row: frame.environment,
            size,
            crop: self.crop.unwrap_or(Crop::all(size)),
            blocks: &values,
            albedos: &self.tables.buffer,
            environment: (&light.radiance, &self.samplers.sphere),
            maps: (&maps.view, &self.samplers.maps),
            lobes,
        };
        Some(work(&mut self.rays, &given))
    }

    /// Takes what the baker has finished; the picture starts anew with it.
    fn take_baked(&mut self, device: &wgpu::Device, queue: &wgpu::Queue) -> Result<(), PreviewError> {
        let Some(baked) = self.baker.take() else { return Ok(()) };
        for (mesh, vertices) in &baked.meshes {
            for drawn in self.objects.iter().filter(|d| Arc::ptr_eq(&d.mesh, mesh)) {
                queue.write_buffer(&drawn.buffers.baked, 0, bytemuck::cast_slice(vertices));
            }
        }
        if let Some(floor) = baked.floor {
            self.stage.light = upload::upload_levels(device, queue, "floor light", std::slice::from_ref(&floor.light))?;
            self.stage.radiance = upload::upload_levels(device, queue, "floor radiance", &floor.radiance)?;
            self.stage.glow = upload::upload_levels(device, queue, "floor glow", std::slice::from_ref(&floor.glow))?;
            self.stage.glow_radiance = upload::upload_levels(device, queue, "floor glow radiance", &floor.glow_radiance)?;
            self.stage.shine = upload::upload_levels(device, queue, "floor shine", std::slice::from_ref(&floor.shine))?;
            self.stage.shine_radiance = upload::upload_levels(device, queue, "floor shine radiance", &floor.shine_radiance)?;
            self.bind_frame(device);
        }
        self.steps = 0;
        Ok(())
    }
}

/// Draws objects, and the background behind what hides it and before what lets it through.
fn draw_objects(
    encoder: &mut wgpu::CommandEncoder,
    targets: &Targets,
    frame: &wgpu::BindGroup,
    background: &wgpu::RenderPipeline,
    objects: &[(&Drawn, pipelines::ObjectPipelines)],
    timestamp_writes: Option<wgpu::RenderPassTimestampWrites<'_>>,
) {
    let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("objects"),
        color_attachments: &[Some(match &targets.places {
            Some(places) => wgpu::RenderPassColorAttachment {
                view: places,
                resolve_target: Some(&targets.color),
                ops: wgpu::Operations { store: wgpu::StoreOp::Discard, ..color_attachment(places).ops },
                depth_slice: None,
            },
            None => color_attachment(&targets.color),
        })],
        depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
            view: &targets.depth,
            depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(0.0), store: wgpu::StoreOp::Discard }),
            stencil_ops: None,
        }),
        timestamp_writes,
        ..Default::default()
    });
    pass.set_bind_group(0, frame, &[]);
    let mut background = Some(background);
    let mut draw_background = |pass: &mut wgpu::RenderPass<'_>| {
        if let Some(pipeline) = background.take() {
            pass.set_pipeline(pipeline);
            pass.draw(0..3, 0..1);
        }
    };
    for (drawn, made) in objects {
        if made.back.is_some() {
            draw_background(&mut pass);
        }
        pass.set_bind_group(1, &drawn.bind, &[]);
        pass.set_vertex_buffer(0, drawn.buffers.vertices.slice(..));
        pass.set_vertex_buffer(1, drawn.buffers.baked.slice(..));
        pass.set_index_buffer(drawn.buffers.indices.slice(..), wgpu::IndexFormat::Uint32);
        for pipeline in made.back.iter().chain([&made.front]) {
            pass.set_pipeline(pipeline);
            pass.draw_indexed(0..drawn.buffers.index_count, 0, 0..1);
        }
    }
    draw_background(&mut pass);
}

fn color_attachment(view: &wgpu::TextureView) -> wgpu::RenderPassColorAttachment<'_> {
    let ops = wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT), store: wgpu::StoreOp::Store };
    wgpu::RenderPassColorAttachment { view, depth_slice: None, resolve_target: None, ops }
}

/// Fills a picture.
pub(super) fn screen_pass(
    encoder: &mut wgpu::CommandEncoder,
    view: &wgpu::TextureView,
    pipeline: &wgpu::RenderPipeline,
    bind: &wgpu::BindGroup,
    timestamp_writes: Option<wgpu::RenderPassTimestampWrites<'_>>,
) {
    let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("screen"),
        color_attachments: &[Some(color_attachment(view))],
        timestamp_writes,
        ..Default::default()
    });
    pass.set_pipeline(pipeline);
    pass.set_bind_group(0, bind, &[]);
    pass.draw(0..3, 0..1);
}
