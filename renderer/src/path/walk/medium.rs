//! What a walk needs to know of a body, worked out once per body or entry point.

use super::guide::{diffusion_length, span};

/// A homogeneous interior, per channel, in 1/normalised unit. Two coefficients instead of extinction and albedo: absorption keeps its
/// digits where it is a millionth of the extinction. Negative values and values that are not numbers count as 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::path) struct Medium {
    /// Scattering coefficient.
    pub sigma_s: [f32; 3],
    /// Absorption coefficient.
    pub sigma_a: [f32; 3],
}

/// Shortest mean free path, as a fraction of the body's radius. Shorter ones are raised to it with the albedo kept: reflectance does
/// not depend on the mean free path, so the bias is a blur of a few such lengths, less than a pixel in any picture of the whole body.
/// It keeps a mean free path well above the rounding of single-precision surfaces, about 1e-7 of the radius.
pub(in crate::path) const MEAN_FREE_PATH_MIN: f64 = 1e-5;

/// One channel.
#[derive(Clone, Copy, Debug)]
pub(super) struct Channel {
    /// Extinction after the floor, 1/normalised unit.
    pub extinction: f64,
    /// Scattering over extinction, `[0, 1]`; 0 where there is no extinction.
    pub albedo: f64,
    /// Absorption over extinction.
    pub absorbed: f64,
    /// Diffusion length in mean free paths.
    pub nu: f64,
    /// `ln((nu + 1)/(nu - 1))`.
    pub span: f64,
    /// Share of steered directions.
    pub steered: f64,
}

/// A medium in a body of known size.
#[derive(Clone, Copy, Debug)]
pub(in crate::path) struct Body {
    pub(super) channels: [Channel; 3],
    pub(super) radius: f64,
}

impl Body {
    /// `radius` is that of the object in normalised units, or half the thickness where it is thin. It decides how much to steer, never
    /// what is right.
    pub(in crate::path) fn new(medium: &Medium, radius: f32) -> Self {
        let radius = if radius.is_finite() && radius > 0.0 { f64::from(radius) } else { 1.0 };
        let channels = std::array::from_fn(|k| {
            let coefficient = |x: f32| if x > 0.0 { f64::from(x.min(f32::MAX)) } else { 0.0 };
            let (scattering, absorption) = (coefficient(medium.sigma_s[k]), coefficient(medium.sigma_a[k]));
            let extinction = scattering + absorption;
            let (albedo, absorbed) =
                if extinction > 0.0 { (scattering / extinction, absorption / extinction) } else { (0.0, 1.0) };
            let extinction = extinction.min(1.0 / (MEAN_FREE_PATH_MIN * radius));
            let nu = diffusion_length(absorbed);
            Channel { extinction, albedo, absorbed, nu, span: span(nu), steered: steered(nu / extinction, radius) }
        });
        Self { channels, radius }
    }

    /// Extinction per channel, 1/normalised unit.
    pub(in crate::path) fn extinction(&self) -> [f32; 3] {
        self.channels.map(|channel| channel.extinction as f32)
    }
}

/// Share of steered directions for a diffusion length: a body that is not many of them thick sends light out on all sides, and steering
/// to one of them would leave the others to rare walks of great weight.
fn steered(length: f64, radius: f64) -> f64 {
    if length < radius / 6.0 {
        0.75
    } else if length < radius / 2.0 {
        0.5
    } else {
        0.0
    }
}
