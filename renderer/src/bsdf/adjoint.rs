//! The BSDF for light that is followed from its source: what a photon's power is multiplied by where it scatters.
//!
//! Paths from the camera and photons must agree on every path, so the value is that of the viewer's side, also where layers that act on
//! the view side alone make it not reciprocal: the direction drawn here is the one that the viewer looks along (Veach 1997, section 5.3).

use super::{Bsdf, BsdfSample, COS_MIN};
use crate::lanes::Lanes;
use crate::vector::{Rgb, V3};

/// Cosines to the geometric normal below this are raised to it where they divide.
const COS_GEOMETRIC_MIN: f64 = 1e-3;

/// The directions of a scattering photon against its surface.
#[derive(Clone, Copy, Debug)]
pub struct Crossing<L: Lanes> {
    /// To where the photon came from, unit, local in the frame of the viewer's side.
    pub to_light: V3<L>,
    /// Cosine between that direction and the shading normal of the photon's side.
    pub cos_light: L,
    /// Cosines of the geometric normal with the directions to light and viewer.
    pub cos_geometric: [L; 2],
    /// Cosine between the direction to the viewer and the shading normal of the photon's side.
    pub cos_viewer: L,
}

impl<L: Lanes> Bsdf<'_, L> {
    /// Factor of a photon's power. `self` is seen from where the photon came, `sample` was drawn from it; `from_viewer` is the same surface
    /// seen along the drawn direction.
    ///
    /// Power crosses a refracting surface without the square of the index that values for the viewer leave out as well: between places
    /// outside of all bodies both conventions agree.
    #[inline(always)]
    pub fn adjoint(&self, sample: &BsdfSample<L>, from_viewer: &Bsdf<'_, L>, at: &Crossing<L>) -> Rgb<L> {
        let one = L::one();
        let [light, viewer] = at.cos_geometric.map(L::abs);
        let spread = viewer / light.max(L::of(COS_GEOMETRIC_MIN));
        let (value, _) = from_viewer.eval(at.to_light);
        let eta = L::select(sample.is_transmission, self.eta.sqr(), one);
        let drawn = value.scale(spread * eta / L::select(sample.pdf.gt(L::zero()), sample.pdf, one));

        // A delta lobe returns as much both ways, but for the layers that light crosses towards the viewer.
        let normals = at.cos_light.abs() / at.cos_viewer.abs().max(L::of(COS_MIN));
        let (seen, met) = (from_viewer.layers_across(at.to_light), self.layers_across(sample.wi));
        let ratio = seen.zip(met, |seen, met| seen / L::select(met.gt(L::zero()), met, one));
        let across = sample.weight * Rgb::select(sample.is_transmission, ratio, Rgb::white());
        Rgb::select(sample.is_delta, across.scale(spread * normals), drawn)
    }
}
