//! Getting a device: what the preview asks for, a device without a window, and everything that can go wrong.

use std::fmt;

/// Why the preview cannot draw. Each is a state that the application shows, not a crash.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum PreviewError {
    /// There is no graphics adapter, not even a software one.
    NoAdapter(String),
    /// The adapter gave no device.
    NoDevice(String),
    /// A shader was refused; the text names file and line.
    Shader(String),
    /// A texture or buffer could not be made.
    Memory(String),
    /// The textures of a picture of this size could not be made; a smaller one may do.
    TooLarge(String),
    /// A picture was asked for before any was drawn.
    NothingDrawn,
    /// The picture could not be read back.
    ReadBack(String),
}

impl fmt::Display for PreviewError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoAdapter(why) => write!(f, "No graphics adapter was found, so there is no live preview: {why}"),
            Self::NoDevice(why) => write!(f, "The graphics adapter could not be opened, so there is no live preview: {why}"),
            Self::Shader(why) => write!(f, "The graphics driver refused a shader of the preview: {why}"),
            Self::Memory(why) => write!(f, "The graphics adapter has no memory left for the preview: {why}"),
            Self::TooLarge(why) => write!(f, "The graphics adapter has no memory for a picture of this size: {why}"),
            Self::NothingDrawn => f.write_str("The preview has not drawn anything yet."),
            Self::ReadBack(why) => write!(f, "The preview's picture could not be read from the graphics adapter: {why}"),
        }
    }
}

impl std::error::Error for PreviewError {}

/// What the preview asks of a device, for whoever makes it: the default limits of WebGPU, buffers as large as there are, and times of passes
/// where they can be had.
///
/// Where the adapter offers less (OpenGL), its own limits; the preview then does what it can.
pub fn device_descriptor(adapter: &wgpu::Adapter) -> wgpu::DeviceDescriptor<'static> {
    let limits = if adapter.get_info().backend == wgpu::Backend::Gl {
        wgpu::Limits::downlevel_defaults().using_resolution(adapter.limits())
    } else {
        wgpu::Limits::default()
    };
    // Large meshes need large buffers; times of passes are shown where they can be had.
    let offered = adapter.limits();
    let limits = wgpu::Limits {
        max_buffer_size: limits.max_buffer_size.max(offered.max_buffer_size),
        max_storage_buffer_binding_size: limits.max_storage_buffer_binding_size.max(offered.max_storage_buffer_binding_size),
        ..limits
    };
    wgpu::DeviceDescriptor {
        label: Some("preview"),
        required_limits: limits,
        required_features: adapter.features() & wgpu::Features::TIMESTAMP_QUERY,
        ..Default::default()
    }
}

/// A device without a window: a real GPU if there is one, else a software adapter.
pub fn headless_device() -> Result<(wgpu::Adapter, wgpu::Device, wgpu::Queue), PreviewError> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env());
    let options = wgpu::RequestAdapterOptions { power_preference: wgpu::PowerPreference::HighPerformance, ..Default::default() };
    let adapter = pollster::block_on(instance.request_adapter(&options)).map_err(|e| PreviewError::NoAdapter(e.to_string()))?;
    let (device, queue) = pollster::block_on(adapter.request_device(&device_descriptor(&adapter)))
        .map_err(|e| PreviewError::NoDevice(e.to_string()))?;
    Ok((adapter, device, queue))
}

/// Runs `work` and returns what it made, or the first error of this kind that the device reported meanwhile. What is made of things that there was
/// no memory for is invalid in turn: such errors are told as the first one.
pub(super) fn guarded<T>(
    device: &wgpu::Device,
    filter: wgpu::ErrorFilter,
    wrap: impl Fn(String) -> PreviewError,
    work: impl FnOnce() -> T,
) -> Result<T, PreviewError> {
    let outer = (filter == wgpu::ErrorFilter::OutOfMemory).then(|| device.push_error_scope(wgpu::ErrorFilter::Validation));
    let scope = device.push_error_scope(filter);
    let made = work();
    let first = pollster::block_on(scope.pop());
    let follows = outer.and_then(|outer| pollster::block_on(outer.pop()));
    match first.or(follows) {
        None => Ok(made),
        Some(error) => Err(wrap(error.to_string())),
    }
}
