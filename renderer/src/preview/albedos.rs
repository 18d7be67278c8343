//! The albedos of the materials: filled on a thread of its own where that takes long, and one buffer of all of them on the device.

use super::device::{PreviewError, guarded};
use super::shader::albedo_table_values;
use super::upload::mapped;
use super::{Drawn, Preview};
use crate::bsdf::Albedos;
use crate::scene::{Object, Scene};
use burnish_material::LobeSet;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::Duration;

/// What a changed material may delay a picture: uniform isotropic ones are filled in less. Stretched ones take tens of milliseconds,
/// several textured numbers a second or two.
const PATIENCE: Duration = Duration::from_millis(4);

/// Tables of an object, if one of `made` fits.
fn fitting<'a>(object: &Object, made: impl IntoIterator<Item = &'a Arc<Albedos>>) -> Option<Arc<Albedos>> {
    let maps = mapped(object);
    let varies = |property| maps.iter().any(|(p, _, _)| *p == property);
    Albedos::fitting(&object.material.inputs(), LobeSet::of(&object.material), varies, made)
}

/// Tables of every object; those of `made` that fit are taken.
fn fill(objects: &[Object], mut made: Vec<Arc<Albedos>>) -> Vec<Arc<Albedos>> {
    let known = made.len();
    for object in objects {
        let maps = mapped(object);
        let varies = |property| maps.iter().any(|(p, _, _)| *p == property);
        let filled = Albedos::new(&object.material.inputs(), LobeSet::of(&object.material), varies, &made);
        made.push(filled);
    }
    made.split_off(known)
}

/// Tables that are being filled.
#[derive(Debug)]
pub(super) struct Filling {
    objects: Vec<Object>,
    result: Receiver<Vec<Arc<Albedos>>>,
}

impl Filling {
    fn start(objects: Vec<Object>, made: Vec<Arc<Albedos>>) -> Self {
        let (sender, result) = channel();
        let given = objects.clone();
        std::thread::spawn(move || {
            // The receiver may be gone with the preview; then nobody wants the tables.
            _ = sender.send(fill(&given, made));
        });
        Self { objects, result }
    }
}

impl Preview {
    /// The objects to draw now, each with its tables: those of `scene`, or those of an earlier one while tables are being filled.
    ///
    /// One filling at a time: while a value changes all the time, pictures follow as fast as tables do.
    pub(super) fn objects_with_albedos(&mut self, scene: &Scene) -> (Vec<Object>, Vec<Arc<Albedos>>) {
        let is_same_model = self.objects.len() == scene.objects.len()
            && self.objects.iter().zip(&scene.objects).all(|(d, o)| Arc::ptr_eq(&d.object.mesh, &o.mesh));
        let mut shown: (Vec<Object>, Vec<Arc<Albedos>>) =
            self.objects.iter().map(|d: &Drawn| (d.object.clone(), d.albedos.clone())).unzip();
        loop {
            let found: Option<Vec<_>> = scene.objects.iter().map(|object| fitting(object, &shown.1)).collect();
            if let Some(albedos) = found {
                self.filling = None;
                return (scene.objects.clone(), albedos);
            }
            let (filling, is_new) = match self.filling.take() {
                Some(filling) => (filling, false),
                None => (Filling::start(scene.objects.clone(), shown.1.clone()), true),
            };
            // A new model is waited for, and what was ordered before must not delay the picture twice.
            let made = if is_same_model {
                filling.result.recv_timeout(if is_new { PATIENCE } else { Duration::ZERO })
            } else {
                filling.result.recv().map_err(|_| RecvTimeoutError::Disconnected)
            };
            match made {
                Ok(made) => shown = (filling.objects, made),
                Err(RecvTimeoutError::Timeout) => {
                    self.filling = Some(filling);
                    return shown;
                }
                // The thread is gone without a result: fill here.
                Err(RecvTimeoutError::Disconnected) => {
                    return (scene.objects.clone(), fill(&scene.objects, shown.1));
                }
            }
        }
    }
}

/// The tables on the device.
#[derive(Debug)]
pub(super) struct Tables {
    pub buffer: wgpu::Buffer,
    held: Vec<Arc<Albedos>>,
    begins: Vec<u32>,
}

impl Tables {
    /// Without any material.
    pub fn new(device: &wgpu::Device) -> Result<Self, PreviewError> {
        Ok(Self { buffer: buffer(device, 0)?, held: Vec::new(), begins: Vec::new() })
    }

    /// Holds the tables of these materials and no others. Returns where each begins, and whether the buffer is a new one.
    pub fn hold(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        albedos: &[Arc<Albedos>],
    ) -> Result<(Vec<u32>, bool), PreviewError> {
        let mut unique: Vec<Arc<Albedos>> = Vec::new();
        let mut place = |albedos: &Arc<Albedos>| {
            unique.iter().position(|held| Arc::ptr_eq(held, albedos)).unwrap_or_else(|| {
                unique.push(albedos.clone());
                unique.len() - 1
            })
        };
        let places: Vec<usize> = albedos.iter().map(&mut place).collect();
        let is_same = unique.len() == self.held.len() && unique.iter().zip(&self.held).all(|(a, b)| Arc::ptr_eq(a, b));
        let mut is_new = false;
        if !is_same {
            let (values, begins) = albedo_table_values(unique.iter().map(Arc::as_ref));
            if size_of_val(&values[..]) as u64 > self.buffer.size() {
                self.buffer = buffer(device, values.len())?;
                is_new = true;
            }
            queue.write_buffer(&self.buffer, 0, bytemuck::cast_slice(&values));
            (self.held, self.begins) = (unique, begins);
        }
        Ok((places.into_iter().map(|place| self.begins[place]).collect(), is_new))
    }
}

/// Room for that many numbers, and some more.
fn buffer(device: &wgpu::Device, numbers: usize) -> Result<wgpu::Buffer, PreviewError> {
    guarded(device, wgpu::ErrorFilter::OutOfMemory, PreviewError::Memory, || {
        device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("albedo tables"),
            size: 4 * numbers.max(16384).next_power_of_two() as u64,
            usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        })
    })
}
