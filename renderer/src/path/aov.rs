//! What the middle of each pixel shows first, for denoisers, masks and picking.

use super::frame::{point, span};
use super::prepared::Prepared;
use super::raygen::View;
use super::sampler::MAX_LANES;
use crate::bsdf::interpret;
use crate::bvh::{Hit, Ray};
use crate::vector::V3;
use burnish_material::Lobe;
use glam::DVec3;

/// Features of the first hits, row by row from the top. Zeros where a pixel shows the environment, except for the depth.
#[derive(Clone, Debug, Default)]
pub struct Aovs {
    /// Base colour, images included. Linear Rec.709.
    pub albedo: Vec<[f32; 3]>,
    /// Interpolated normal, unit, world, outwards.
    pub normal: Vec<[f32; 3]>,
    /// Distance from the camera along the ray, scene units; infinite where there is nothing.
    pub depth: Vec<f32>,
    /// The point, world, scene units.
    pub position: Vec<[f32; 3]>,
    /// Radiance that the surface emits by itself, linear Rec.709.
    pub emission: Vec<[f32; 3]>,
}

/// Features of the pixel centres. Cut-through is ignored.
pub fn aovs(prepared: &Prepared, width: usize, height: usize) -> Aovs {
    let view = View::new(prepared, width, height);
    let mut out = Aovs::default();
    let mut hits = vec![Hit::MISS; width];
    for y in 0..height {
        let rays: Vec<Ray> = (0..width)
            .map(|x| {
                let (u, v) = ((x as f32 + 0.5) / width as f32, (y as f32 + 0.5) / height as f32);
                Ray::new(view.basis.origin, view.basis.direction(u, v))
            })
            .collect();
        prepared.geometry.bvh.trace(&rays, &mut hits);
        for hit in &hits {
            if hit.is_miss() {
                out.albedo.push([0.0; 3]);
                out.normal.push([0.0; 3]);
                out.depth.push(f32::INFINITY);
                out.position.push([0.0; 3]);
                out.emission.push([0.0; 3]);
                continue;
            }
            let object = prepared.geometry.triangles[hit.triangle as usize][3];
            let surface = &prepared.surfaces[prepared.surface_of_object[object as usize] as usize];
            let at = point::<f32>(&prepared.geometry, &[*hit; MAX_LANES], false, true);
            let uniform = surface.inputs.convert(|x| x as f32);
            let inputs = if surface.textures.is_empty() {
                uniform
            } else {
                let footprint = span::<f32>(&prepared.geometry, &[*hit; MAX_LANES]).uv_length(view.spread() * hit.t);
                surface.textured(&uniform, &at.uv, footprint).unwrap_or(uniform)
            };
            let V3 { x, y, z } = at.n;
            let V3 { x: px, y: py, z: pz } = at.position;
            let optics = interpret(&inputs, surface.lobes, surface.length_scale as f32);
            let position = prepared.geometry.in_scene(DVec3::new(f64::from(px), f64::from(py), f64::from(pz)));
            out.position.push(position.as_vec3().to_array());
            out.emission.push(if surface.lobes.has(Lobe::emission) { optics.emission.0 } else { [0.0; 3] });
            out.albedo.push(inputs.base_color.map(|c| c.clamp(0.0, 1.0)));
            out.normal.push([x, y, z]);
            out.depth.push((f64::from(hit.t) / prepared.geometry.scale) as f32);
        }
    }
    out
}
