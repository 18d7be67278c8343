//! What a ray sees at its hit, one point at a time: for pictures and answers about a scene. Rendering does the same for many at once (`shade`).

use super::detail::{Footprint, Shading};
use super::frame::{Frame, Point, point, span};
use super::prepared::{Prepared, Surface};
use super::raygen::splat;
use super::sampler::MAX_LANES;
use crate::bsdf::{Bsdf, ByLobe, Optics, View, Wavelength, interpret};
use crate::bvh::Hit;
use crate::vector::V3;
use burnish_material::Inputs;
use glam::Vec3;

/// A point of a surface and who looks at it.
#[derive(Clone, Debug)]
pub(super) struct Seen<'a> {
    /// Number of the object.
    pub object: u32,
    /// Its surface.
    pub surface: &'a Surface,
    /// The point, normalised units.
    pub at: Point<f32>,
    /// Direction to the viewer, unit, world.
    pub wo: V3<f32>,
    /// Axes of the shading frame, maps included.
    pub frame: Frame<f32>,
    /// Normal of the coat, unit, world.
    pub coat_normal: V3<f32>,
    /// Values there, images included.
    pub inputs: Inputs<f32>,
    /// What they mean.
    pub optics: Optics<f32>,
    /// Length in uv that the viewer's pixel covers.
    footprint: f32,
}

impl<'a> Seen<'a> {
    /// What a ray along `direction` (unit) sees at a hit where its cone is `width` wide, normalised units. It must hit something.
    pub(super) fn new(prepared: &'a Prepared, hit: &Hit, direction: Vec3, width: f32) -> Self {
        let object = prepared.geometry.triangles[hit.triangle as usize][3];
        let surface = &prepared.surfaces[prepared.surface_of_object[object as usize] as usize];
        let hits = [*hit; MAX_LANES];
        let at: Point<f32> = point(&prepared.geometry, &hits, surface.needs_tangent(), true);
        let span = span(&prepared.geometry, &hits);
        let footprint = Footprint { uv: span.uv_length(width), span };
        let uniform = surface.inputs.convert(|x| x as f32);
        let inputs = surface.textured(&uniform, &at.uv, footprint.uv).unwrap_or(uniform);
        let wo = -splat::<f32>(direction);
        let Shading { frame, coat_normal } = surface.shading(&at, &inputs, Some(&footprint), wo, wo.dot(at.ng) > 0.0);
        let optics = interpret(&inputs, surface.lobes, surface.length_scale as f32);
        Self { object, surface, at, wo, frame, coat_normal, inputs, optics, footprint: footprint.uv }
    }

    /// The values with all digits of those that no image replaces.
    pub(super) fn exact_inputs(&self) -> Inputs<f64> {
        let uv = self.at.uv.map(f64::from);
        self.surface.textured(&self.surface.inputs, &uv, f64::from(self.footprint)).unwrap_or(self.surface.inputs)
    }

    /// The same point of a material whose colours are all white.
    pub(super) fn whitened(&self) -> Self {
        let white = [1.0; 3];
        let inputs = Inputs {
            base_color: white,
            specular_edge_color: white,
            sheen_color: white,
            coat_color: white,
            absorption_color: white,
            ..self.inputs
        };
        let optics = interpret(&inputs, self.surface.lobes, self.surface.length_scale as f32);
        Self { inputs, optics, ..self.clone() }
    }

    /// Shares of the lobes in light that comes from a world direction and is scattered to the viewer.
    pub(super) fn shares(&self, direction: Vec3, light: Option<Wavelength<f32>>, is_delta: bool) -> ByLobe<[f32; 3]> {
        let coat_normal = self.surface.has_coat_normal().then(|| self.frame.local(self.coat_normal));
        let view = View { coat_normal, light, ..View::new(self.frame.local(self.wo)) };
        let bsdf = Bsdf::prepare(&self.optics, &self.surface.albedos, self.surface.lobes, &view);
        bsdf.shares(self.frame.local(splat(direction)), is_delta).map(|share| share.0)
    }
}
