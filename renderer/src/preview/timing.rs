//! What each pass of a picture takes, measured by the device where it can: milliseconds by name, of a picture some frames ago.

use std::sync::Arc;
use std::sync::atomic::{AtomicU8, Ordering};

/// Passes that are measured in one picture.
const PASSES_MAX: u32 = 16;
/// Pictures whose times may be on their way at once.
const IN_FLIGHT: usize = 3;

/// States of a buffer on its way.
const FREE: u8 = 0;
const WRITTEN: u8 = 1;
const MAPPING: u8 = 2;
const MAPPED: u8 = 3;
const FAILED: u8 = 4;

/// What one picture took.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FrameTimes {
    /// Name and milliseconds of each pass, in order; passes of one name are added up.
    pub passes: Vec<(&'static str, f64)>,
    /// Tiles of rays in it.
    pub tiles: u32,
}

impl FrameTimes {
    /// Milliseconds of all passes.
    pub fn total(&self) -> f64 {
        self.passes.iter().map(|(_, ms)| ms).sum()
    }

    /// Milliseconds of a pass; 0 if it did not run.
    pub fn of(&self, name: &str) -> f64 {
        self.passes.iter().find(|(pass, _)| *pass == name).map_or(0.0, |(_, ms)| *ms)
    }
}

/// Measures passes; does nothing on a device without timestamps.
#[derive(Debug)]
pub(super) struct Timing {
    device: Option<Device>,
    last: FrameTimes,
    /// The picture being made.
    current: FrameTimes,
    names: Vec<&'static str>,
    slot: Option<usize>,
}

#[derive(Debug)]
struct Device {
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    slots: [Slot; IN_FLIGHT],
    /// Nanoseconds per tick.
    period: f64,
}

#[derive(Debug)]
struct Slot {
    buffer: wgpu::Buffer,
    state: Arc<AtomicU8>,
    names: Vec<&'static str>,
    tiles: u32,
}

impl Timing {
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue) -> Self {
        let make = || {
            let size = u64::from(PASSES_MAX) * 16;
            let buffer = |usage| {
                device.create_buffer(&wgpu::BufferDescriptor { label: Some("times"), size, usage, mapped_at_creation: false })
            };
            Device {
                queries: device.create_query_set(&wgpu::QuerySetDescriptor {
                    label: Some("times"),
                    ty: wgpu::QueryType::Timestamp,
                    count: 2 * PASSES_MAX,
                }),
                resolved: buffer(wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC),
                slots: std::array::from_fn(|_| Slot {
                    buffer: buffer(wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ),
                    state: Arc::default(),
                    names: Vec::new(),
                    tiles: 0,
                }),
                period: f64::from(queue.get_timestamp_period()),
            }
        };
        // A software adapter takes the time before it does the work.
        let is_hardware = device.adapter_info().device_type != wgpu::DeviceType::Cpu;
        let device = (is_hardware && device.features().contains(wgpu::Features::TIMESTAMP_QUERY)).then(make);
        Self { device, ..Self::none() }
    }

    /// Measures nothing.
    pub fn none() -> Self {
        Self { device: None, last: FrameTimes::default(), current: FrameTimes::default(), names: Vec::new(), slot: None }
    }

    /// Begins a picture: takes the times that have arrived.
    pub fn begin(&mut self) {
        self.names.clear();
        self.current = FrameTimes::default();
        let Some(device) = &mut self.device else { return };
        let period = device.period;
        for slot in &mut device.slots {
            match slot.state.load(Ordering::Acquire) {
                WRITTEN => {
                    let state = slot.state.clone();
                    state.store(MAPPING, Ordering::Release);
                    slot.buffer.slice(..).map_async(wgpu::MapMode::Read, move |result| {
                        state.store(if result.is_ok() { MAPPED } else { FAILED }, Ordering::Release);
                    });
                }
                MAPPED => {
                    if let Ok(bytes) = slot.buffer.slice(..).get_mapped_range() {
                        let ticks: Vec<u64> = bytes.chunks_exact(8).map(bytemuck::pod_read_unaligned).collect();
                        let mut times = FrameTimes { passes: Vec::new(), tiles: slot.tiles };
                        for (name, pair) in slot.names.iter().zip(ticks.chunks_exact(2)) {
                            let ms = pair[1].saturating_sub(pair[0]) as f64 * period * 1e-6;
                            match times.passes.iter_mut().find(|(pass, _)| pass == name) {
                                Some((_, sum)) => *sum += ms,
                                None => times.passes.push((name, ms)),
                            }
                        }
                        self.last = times;
                    }
                    slot.buffer.unmap();
                    slot.state.store(FREE, Ordering::Release);
                }
                FAILED => slot.state.store(FREE, Ordering::Release),
                _ => {}
            }
        }
        self.slot = device.slots.iter().position(|slot| slot.state.load(Ordering::Acquire) == FREE);
    }

    /// Places of the two times of a pass; `None` where it is not measured.
    fn next(&mut self, name: &'static str) -> Option<[u32; 2]> {
        let place = self.names.len() as u32;
        if self.slot.is_none() || self.device.is_none() || place >= PASSES_MAX {
            return None;
        }
        self.names.push(name);
        Some([2 * place, 2 * place + 1])
    }

    /// What a render pass of this name is to be given.
    pub fn render(&mut self, name: &'static str) -> Option<wgpu::RenderPassTimestampWrites<'_>> {
        let [first, last] = self.next(name)?;
        self.device.as_ref().map(|device| wgpu::RenderPassTimestampWrites {
            query_set: &device.queries,
            beginning_of_pass_write_index: Some(first),
            end_of_pass_write_index: Some(last),
        })
    }

    /// What a compute pass of this name is to be given.
    pub fn compute(&mut self, name: &'static str, tiles: u32) -> Option<wgpu::ComputePassTimestampWrites<'_>> {
        let [first, last] = self.next(name)?;
        self.current.tiles += tiles;
        self.device.as_ref().map(|device| wgpu::ComputePassTimestampWrites {
            query_set: &device.queries,
            beginning_of_pass_write_index: Some(first),
            end_of_pass_write_index: Some(last),
        })
    }

    /// Ends a picture, in its encoder.
    pub fn end(&mut self, encoder: &mut wgpu::CommandEncoder) {
        let (Some(device), Some(slot)) = (&mut self.device, self.slot.take()) else { return };
        let count = 2 * self.names.len() as u32;
        if count == 0 {
            return;
        }
        encoder.resolve_query_set(&device.queries, 0..count, &device.resolved, 0);
        let slot = &mut device.slots[slot];
        encoder.copy_buffer_to_buffer(&device.resolved, 0, &slot.buffer, 0, u64::from(count) * 8);
        slot.names.clone_from(&self.names);
        slot.tiles = self.current.tiles;
        slot.state.store(WRITTEN, Ordering::Release);
    }

    /// The newest times that have arrived; empty where the device measures none.
    pub fn last(&self) -> &FrameTimes {
        &self.last
    }
}
