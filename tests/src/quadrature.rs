//! Independent integration of a BSDF over the sphere: knows `eval` only, nothing of sampling.

use burnish_renderer::bsdf::{Bsdf, Optics};
use burnish_renderer::lanes::Lanes;
use burnish_renderer::vector::V3;

/// Points along the polar angle and the azimuth of each half.
const POLAR: usize = 480;
const AZIMUTH: usize = 360;

/// Integral over all directions of `eval`: value per channel on the viewer's side and across, and of the density.
#[derive(Clone, Copy, Debug, Default)]
pub struct Integral {
    /// Reflected share per channel.
    pub reflected: [f64; 3],
    /// Transmitted share per channel.
    pub transmitted: [f64; 3],
    /// Integral of the density: the share of samples that are valid.
    pub pdf: f64,
}

/// Integrates about the mirror direction and about the refracted direction, with polar angles spaced
/// geometrically: a lobe of width 1e-4 is resolved as well as a cosine. Streaks that are wide one way and very thin the other (alpha 1
/// along and 1e-4 across) are not: far from the middle the azimuth is too coarse for them.
pub fn integrate(bsdf: &Bsdf<'_, f64>, wo: V3<f64>, optics: &Optics<f64>) -> Integral {
    // A stretched lobe is a thin streak far from its middle.
    let azimuth = if optics.alpha_x > 4.0 * optics.alpha_y { 16 * AZIMUTH } else { AZIMUTH };
    let mut result = Integral::default();
    let mirror = V3::new(-wo.x, -wo.y, wo.z);
    let side = wo.z.signum();
    let eta = if wo.z < 0.0 { 1.0 / optics.eta } else { optics.eta };
    let sin = (1.0 - wo.z * wo.z).max(0.0).sqrt() / eta;
    let bent = V3::new(-wo.x / eta, -wo.y / eta, -side * (1.0 - sin * sin).max(1e-6).sqrt()).normalize();
    // Facets of nearly matched media hardly bend, whatever their tilt: a wide lobe piles up at the straight direction.
    let bent = if (eta - 1.0).abs() < 0.01 && optics.alpha_x > 0.1 { -wo } else { bent };
    for (axis, is_across) in [(mirror, false), (bent, true)] {
        let helper = if axis.x.abs() < 0.5 { V3::new(1.0, 0.0, 0.0) } else { V3::new(0.0, 1.0, 0.0) };
        let t = axis.cross(helper).normalize();
        let b = axis.cross(t);
        // theta = pi * (e^(k s) - 1) / (e^k - 1), s in [0, 1]
        let k: f64 = 12.0;
        for i in 0..POLAR {
            let s = (i as f64 + 0.5) / POLAR as f64;
            let theta = std::f64::consts::PI * (k * s).exp_m1() / k.exp_m1();
            let weight_theta = std::f64::consts::PI * k * (k * s).exp() / k.exp_m1() / POLAR as f64;
            let (st, ct) = theta.sin_cos();
            for j in 0..azimuth {
                let phi = std::f64::consts::TAU * (j as f64 + 0.5) / azimuth as f64;
                let (sp, cp) = phi.sin_cos();
                let wi = t.scale(st * cp) + b.scale(st * sp) + axis.scale(ct);
                if (wi.z * side > 0.0) == is_across || wi.z == 0.0 {
                    continue;
                }
                let (value, pdf) = bsdf.eval(wi);
                let w = st * weight_theta * std::f64::consts::TAU / azimuth as f64;
                let target = if is_across { &mut result.transmitted } else { &mut result.reflected };
                for (sum, value) in target.iter_mut().zip(value.0) {
                    *sum += value * w;
                }
                result.pdf += pdf * w;
            }
        }
    }
    result
}

/// A direction at cosine `mu` (negative: below) and azimuth `phi`.
pub fn direction<L: Lanes>(mu: f64, phi: f64) -> V3<L> {
    let s = (1.0 - mu * mu).max(0.0).sqrt();
    V3::new(L::of(s * phi.cos()), L::of(s * phi.sin()), L::of(mu))
}
