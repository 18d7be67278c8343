//! Which paths light brings better than the camera finds them.
//!
//! Bright light that mirrors, glass or a coat throw onto a matt surface is a needle for a path from the camera. So the paths
//!
//! ```text
//! camera, receiver, …, caster, hot light
//! ```
//!
//! are left out there and traced from the light instead (`photon`), all of them and no others: a partition, no weights. It is decided by the
//! first surface, the last one and the radiance alone, so it holds for any roughness. Paths through scattering bodies stay with the
//! camera. Source: the partition is that of light tracing (Dutré et al. 1993) cut by intensity.

use super::geometry::{Geometry, Sphere};
use super::prepared::Surface;
use crate::bsdf::{Optics, interpret};
use burnish_material::{Lobe, Property};

/// Microfacet alpha below which a lobe throws caustics that are worth photons, and above which a surface shows them by itself.
const ALPHA_LIMIT: f64 = 0.3;

/// What a surface is to caustics.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Role {
    /// It throws them.
    Caster,
    /// It shows them: opaque, without narrow lobes.
    Receiver,
    /// Neither.
    #[default]
    Other,
}

/// Where photons are aimed at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Caustics {
    /// Around the casters.
    pub casters: Sphere,
    /// A distance from their middle beyond all geometry, normalised units.
    pub distance: f32,
}

impl Role {
    /// The role of a surface, judged by its uniform values; an image of the roughness may be narrow anywhere.
    pub(super) fn of(surface: &Surface) -> Self {
        let lobes = surface.lobes;
        if lobes.has(Lobe::opacity) || lobes.has(Lobe::scattering) {
            return Self::Other;
        }
        let optics: Optics<f64> = interpret(&surface.inputs, lobes, surface.length_scale);
        let varies = |property| surface.textures.iter().any(|t| t.property == property);
        let is_narrow = optics.alpha_x.min(optics.alpha_y) < ALPHA_LIMIT || varies(Property::roughness);
        let has_interface = lobes.has(Lobe::metal) || lobes.has(Lobe::specular);
        let is_coat_narrow = lobes.has(Lobe::coat) && (optics.coat_alpha < ALPHA_LIMIT || varies(Property::coat_roughness));
        // What a dielectric or a coat reflects over a matt base is too faint to be worth photons.
        if is_narrow && (lobes.has(Lobe::metal) || lobes.has(Lobe::transmission)) {
            Self::Caster
        } else if lobes.has(Lobe::transmission) || (has_interface && is_narrow) || is_coat_narrow {
            Self::Other
        } else {
            Self::Receiver
        }
    }
}

impl Caustics {
    /// The caustics of a scene; `None` without both casters and receivers. `role` tells that of an object.
    pub(super) fn new(geometry: &Geometry, role: impl Fn(usize) -> Role) -> Option<Self> {
        let spheres = || geometry.spheres.iter().enumerate().filter_map(|(object, sphere)| Some((role(object), (*sphere)?)));
        let casters = spheres().filter(|(role, _)| *role == Role::Caster).map(|(_, sphere)| sphere).reduce(Sphere::union)?;
        let has_receiver = spheres().any(|(role, _)| role == Role::Receiver);
        let all = spheres().map(|(_, sphere)| sphere).fold(casters, Sphere::union);
        let distance = 1.01 * (all.center.distance(casters.center) + all.radius);
        (has_receiver && distance.is_finite()).then_some(Self { casters, distance })
    }
}
