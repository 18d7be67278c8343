//! What differs from picture to picture: the place within the pixel, the stretch of samples, and the camera.

use super::upload::FrameBlock;
use super::{Crop, Preview};
use crate::bsdf::interpret;
use crate::scene::Scene;
use burnish_material::{LobeSet, Property};
use glam::{Vec2, Vec3};

/// Largest factor on the environment: products with the largest radiance stay numbers.
const SCALE_MAX: f32 = 1e30;

/// Samples per lobe in each picture. A software adapter has little time for them.
pub(super) fn samples_on(device: &wgpu::Device) -> u32 {
    if device.adapter_info().device_type == wgpu::DeviceType::Cpu { 6 } else { 8 }
}

impl Preview {
    /// The uniform block of picture number `step`.
    pub(super) fn frame_block(&self, scene: &Scene, width: u32, height: u32, step: u32) -> FrameBlock {
        let crop = self.crop.unwrap_or(Crop::all([width, height]));
        let (basis, middle) = crop.basis(&scene.camera, [width, height]);
        let four = |v: Vec3, w: f32| v.extend(w).to_array();
        let bounds = scene.document_bounds();
        let near = ((basis.origin - bounds.center()).length() * 1e-3).max(1e-6);
        // What lies in the middle of the part must come to the middle of what is drawn.
        let shift = (jitter(step) * 2.0) / Vec2::new(width as f32, height as f32) - Vec2::from(middle);
        let (sin, cos) = scene.environment.rotation_deg.to_radians().sin_cos();
        let light = self.light.as_ref();
        let floor = self.stage.floor.as_ref();
        let (first, count, all) = (step * self.samples, self.samples, (step + 1) * self.samples);
        let [sent_on, shine] = sent_on(scene, bounds.radius());
        FrameBlock {
            origin: four(basis.origin, near),
            right_inverse: four(basis.right / basis.right.length_squared(), 0.0),
            up_inverse: four(basis.up / basis.up.length_squared(), 0.0),
            right: four(basis.right, bounds.size().x),
            up: four(basis.up, 0.0),
            forward: four(basis.forward, 0.0),
            jitter: [shift.x, shift.y, width as f32, height as f32],
            environment: [
                cos,
                sin,
                scene.environment.scale.clamp(0.0, SCALE_MAX),
                light.map_or(1.0, |l| l.made.levels.len() as f32),
            ],
            floor: floor.map_or([0.0; 4], |f| [f.center.x, f.y, f.center.y, f.half_width]),
            floor_extent: floor.map_or([0.0; 4], |f| [f.extent[0].x, f.extent[0].y, f.extent[1].x, f.extent[1].y]),
            floor_mean: four(light.map_or(Vec3::ZERO, |l| l.made.floor_mean), 0.0),
            floor_open: four(light.map_or(Vec3::ZERO, |l| l.made.up), 0.0),
            samples: [first as f32, count as f32, all as f32, f32::from(u8::from(self.baker.has_result()))],
            body: four(bounds.center(), bounds.radius()),
            stand: four(stand_color(scene), 0.0),
            sent_on,
            shine,
        }
    }
}

/// Mean colour of the bodies that are neither edited nor floor.
fn stand_color(scene: &Scene) -> Vec3 {
    let stands = || scene.objects.iter().filter(|o| !o.is_document && !super::floor::is_floor(o));
    let sum: Vec3 = stands().map(|o| Vec3::from(o.material.color(Property::base_color).map(|c| c as f32))).sum();
    sum / stands().count().max(1) as f32
}

/// Share of light that the edited objects send on where it falls on them, all ways together, and how much of it they stop at all; and the
/// radiance that they shine with under an environment of factor 1.
fn sent_on(scene: &Scene, radius: f32) -> [[f32; 4]; 2] {
    let nothing = [[0.0, 0.0, 0.0, 1.0], [0.0; 4]];
    let Some(object) = scene.objects.iter().find(|o| o.is_document) else { return nothing };
    let inputs = object.material.inputs().convert(|x| x as f32);
    let optics = interpret(&inputs, LobeSet::of(&object.material), object.length_scale as f32);
    let f0 = 0.04 * (1.0 - optics.w_metal);
    let color = |k: usize| {
        let surface = optics.base_color.0[k] * (optics.w_metal + optics.w_diffuse) + f0;
        // Through the body on a mean way; what scatters stays in the game.
        let depth = optics.sigma_a.0[k] * radius;
        let through = optics.w_transmission * (1.0 - f0) * optics.transmission_tint.0[k].powi(2) * (-depth.min(80.0)).exp();
        (surface + through).clamp(0.0, 1.0)
    };
    let shine = optics.emission.0.map(|x| (x / scene.environment.scale.max(1e-6)).min(1e6));
    [[color(0), color(1), color(2), optics.opacity], [shine[0], shine[1], shine[2], 0.0]]
}

/// Place of a picture within the pixel, -0.5 to 0.5: its middle first, then an even sequence (Roberts 2018).
fn jitter(step: u32) -> Vec2 {
    let k = step as f32;
    Vec2::new((0.5 + k * 0.754_877_7).fract() - 0.5, (0.5 + k * 0.569_840_3).fract() - 0.5)
}
