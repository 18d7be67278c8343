//! Fine detail of surfaces: normal maps, bumps from height maps, and the coat's normal (model reference 8.4 and 13).

use super::batch::Paths;
use super::frame::{Frame, Point, Span, facing, scale_normal, span};
use super::geometry::Geometry;
use super::prepared::Surface;
use super::sampler::MAX_LANES;
use super::texture::Texture;
use crate::bvh::Hit;
use crate::lanes::Lanes;
use crate::vector::V3;
use burnish_material::{Inputs, Lobe};

/// A height map that bends normals, of a surface that is displaced by it or of one that is not.
#[derive(Clone, Debug)]
pub(super) struct Bumps {
    /// The map.
    pub texture: Texture,
    /// Normalised units per unit of height.
    pub scale: f64,
    /// Whether the triangles follow the map already.
    pub is_displaced: bool,
}

/// The directions that reflection and refraction go by at the hits of one group of lanes, world space.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shading<L> {
    /// Frame of the base.
    pub frame: Frame<L>,
    /// Normal of the coat; that of the base where the material has no coat or nothing tells them apart.
    pub coat_normal: V3<L>,
}

/// How much of an image a path sees at its hit.
#[derive(Clone, Copy, Debug)]
pub(super) struct Footprint<L> {
    /// The triangles.
    pub span: Span<L>,
    /// Length in uv.
    pub uv: L,
}

impl<L: Lanes> Footprint<L> {
    /// The footprints of paths at their hits.
    #[inline(always)]
    pub(super) fn new(geometry: &Geometry, hits: &[Hit; MAX_LANES], paths: &Paths, id: &[usize; MAX_LANES]) -> Self {
        let span = span(geometry, hits);
        Self { uv: span.uv_length(L::from_fn(|i| paths.width_at_hit(id[i]))), span }
    }
}

impl Surface {
    /// Frame and coat normal at the hits. `normal_maps` are the texels or uniform values of the surface's and the coat's map.
    /// `wo` points to the viewer, who is on the side `is_front` of the geometric normal.
    #[inline(always)]
    pub(super) fn shading<L: Lanes>(
        &self,
        at: &Point<L>,
        inputs: &Inputs<L>,
        footprint: Option<&Footprint<L>>,
        wo: V3<L>,
        is_front: L::Mask,
    ) -> Shading<L> {
        if !self.has_detail() {
            let n = facing(at.n, wo, is_front);
            let frame = if self.needs_tangent() { Frame::along(n, at.tangent) } else { Frame::around(n) };
            return Shading { frame, coat_normal: n };
        }
        let smooth = Frame::along(at.n, at.tangent);
        let outwards = |n: V3<L>| V3::select(n.dot(at.ng).gt(L::zero()), n, at.n);
        let is_displaced = self.bumps.as_ref().is_some_and(|b| b.is_displaced);
        // The normal of the height map in the smooth frame. A normal map that holds its detail leaves it to a displaced coat.
        let is_needed = !self.lobes.has(Lobe::normal_map)
            || self.inputs.combine_normal_and_height
            || (is_displaced && self.has_coat_normal());
        let bump = match (&self.bumps, footprint) {
            (Some(bumps), Some(footprint)) if is_needed => Some(bumps.normal(&smooth, &at.uv, footprint)),
            _ => None,
        };
        let bumped = bump.map_or(at.n, |h| outwards(smooth.world(h)));
        let n = if self.lobes.has(Lobe::normal_map) {
            let m = scale_normal(inputs.normal, self.inputs.normal_scale);
            let mapped = match bump {
                Some(_) if self.inputs.combine_normal_and_height && is_displaced => Frame::along(bumped, at.tangent).world(m),
                Some(h) if self.inputs.combine_normal_and_height => smooth.world(combined(m, h)),
                // The map holds the detail of the height map.
                _ => smooth.world(m),
            };
            outwards(mapped)
        } else {
            bumped
        };
        let n = facing(n, wo, is_front);
        // The coat lies on the surface as it is: on the displaced one if it was displaced. The base's maps are not its own.
        let coat_normal = if self.has_coat_normal() {
            let own = if is_displaced { Frame::along(bumped, at.tangent) } else { smooth };
            let own = if self.lobes.has(Lobe::coat_normal_map) {
                outwards(own.world(scale_normal(inputs.coat_normal, self.inputs.coat_normal_scale)))
            } else {
                own.n
            };
            facing(own, wo, is_front)
        } else {
            n
        };
        Shading { frame: Frame::along(n, at.tangent), coat_normal }
    }

    /// Whether anything but the mesh bends normals.
    fn has_detail(&self) -> bool {
        self.bumps.is_some() || self.lobes.has(Lobe::normal_map) || self.lobes.has(Lobe::coat_normal_map)
    }

    /// Whether the coat's normal may differ from the base's.
    pub(super) fn has_coat_normal(&self) -> bool {
        self.lobes.has(Lobe::coat) && self.has_detail()
    }
}

impl Bumps {
    /// Normal of the height map in the smooth frame of the surface.
    #[inline(always)]
    fn normal<L: Lanes>(&self, smooth: &Frame<L>, uv: &[L; 2], footprint: &Footprint<L>) -> V3<L> {
        let mut by_uv = [[0.0f32; 2]; MAX_LANES];
        for (i, by_uv) in by_uv.iter_mut().enumerate().take(L::WIDTH) {
            let level = self.texture.level(footprint.uv.lane(i));
            *by_uv = self.texture.gradient([uv[0].lane(i), uv[1].lane(i)], level);
        }
        let scale = L::of(self.scale);
        let [along, across] = footprint.span.slopes(smooth, [0, 1].map(|k| L::from_fn(|i| by_uv[i][k]) * scale));
        V3::new(-along, -across, L::one()).normalize()
    }
}

/// A normal map on top of bumps: their slopes add up.
#[inline(always)]
fn combined<L: Lanes>(map: V3<L>, bump: V3<L>) -> V3<L> {
    V3::new(map.x * bump.z + bump.x * map.z, map.y * bump.z + bump.y * map.z, map.z * bump.z).normalize()
}
