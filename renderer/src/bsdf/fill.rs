//! Computes the entries of [`super::albedos`] by midpoint sums over visible normals, many cosines at a time.

use super::albedos::QUANTITIES;
use super::fresnel::fresnel;
use super::ggx::{g1_smith, reflect, refract, smith_length, vndf_sample_at};
use crate::lanes::{Kernel, Lanes, Mask, dispatch};
use crate::vector::V3;
use std::f64::consts::{PI, TAU};

/// An interface with a rough surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct Interface {
    /// GGX alpha along and across the stretch.
    pub alpha: [f64; 2],
    /// A perfect mirror.
    pub is_smooth: bool,
    /// Index of refraction for the reflectance seen from outside.
    pub eta_reflection: f64,
    /// Index of refraction for bending, and for the reflectance seen from inside.
    pub eta: f64,
    /// Refraction passes straight through.
    pub is_matched: bool,
}

/// Quantities to compute.
#[derive(Clone, Copy, Debug)]
pub(super) struct Wanted {
    pub metal: bool,
    pub dielectric: bool,
    pub glass: bool,
}

/// Points along the polar and the azimuthal number of the visible normals, by how many numbers of the material vary: tables with many
/// rows are coarse anyway. Isotropic first, then stretched ones, which have many more entries. Isotropic sums use half the circle.
const POINTS: [[(usize, usize); 4]; 2] = [[(80, 64), (40, 32), (24, 20), (16, 12)], [(64, 56), (32, 28), (20, 16), (16, 12)]];

/// One row: `[azimuth][sqrt(mu)]` per quantity; empty where a quantity is not wanted.
pub(super) fn fill(
    interface: &Interface,
    wanted: Wanted,
    azimuths: usize,
    cosines: usize,
    varying: usize,
) -> [Vec<f32>; QUANTITIES] {
    let stretched = usize::from(azimuths > 1);
    let (polar, circle) = POINTS[stretched][varying.min(POINTS[0].len() - 1)];
    let circle: Vec<(f64, f64)> = if azimuths == 1 {
        (0..circle / 2).map(|i| (PI * (i as f64 + 0.5) / (circle / 2) as f64).sin_cos()).collect()
    } else {
        (0..circle).map(|i| (TAU * (i as f64 + 0.5) / circle as f64).sin_cos()).collect()
    };
    dispatch(Fill { interface, wanted, azimuths, cosines, polar, circle: &circle })
}

struct Fill<'a> {
    interface: &'a Interface,
    wanted: Wanted,
    azimuths: usize,
    cosines: usize,
    polar: usize,
    /// Sines and cosines.
    circle: &'a [(f64, f64)],
}

impl Kernel for Fill<'_> {
    type Output = [Vec<f32>; QUANTITIES];

    #[inline(always)]
    fn run<L: Lanes>(self) -> Self::Output {
        let mut out: Self::Output = Default::default();
        for azimuth in 0..self.azimuths {
            // Share of the quarter turn, as `Grid::slant` measures it.
            let p = if self.azimuths > 1 { azimuth as f64 / (self.azimuths - 1) as f64 } else { 0.0 };
            let length = p.hypot(1.0 - p);
            let (x, y) = ((1.0 - p) / length, p / length);
            let mut start = 0;
            while start < self.cosines {
                let t = L::from_fn(|lane| ((start + lane).min(self.cosines - 1) as f64 / (self.cosines - 1) as f64) as f32);
                let mu = (t * t).max(L::of(1e-5));
                let sin = (L::one() - mu * mu).max(L::zero()).sqrt();
                let made = self.column(V3::new(sin * L::of(x), sin * L::of(y), mu));
                let held = [self.wanted.metal, self.wanted.dielectric, self.wanted.glass, self.wanted.glass];
                for q in 0..QUANTITIES {
                    if held[q] {
                        for lane in 0..L::WIDTH.min(self.cosines - start) {
                            out[q].push(made[q].lane(lane));
                        }
                    }
                }
                start += L::WIDTH;
            }
        }
        out
    }
}

impl Fill<'_> {
    #[inline(always)]
    fn column<L: Lanes>(&self, wo: V3<L>) -> [L; QUANTITIES] {
        let (zero, one) = (L::zero(), L::one());
        let s = self.interface;
        let (eta_reflection, eta) = (L::of(s.eta_reflection), L::of(s.eta));
        if s.is_smooth {
            return [zero, one - fresnel(wo.z, eta_reflection), one, one];
        }
        let (ax, ay) = (L::of(s.alpha[0]), L::of(s.alpha[1]));
        let inside = one / eta;
        let length_o = smith_length(wo, ax, ay);
        let (mut metal, mut dielectric, mut outwards, mut inwards) = (zero, zero, zero, zero);
        for i in 0..self.polar {
            // Finer towards 1: the tail of steep facets, where light goes below the horizon, holds about alpha^2 of the whole.
            let tail = |s: f64| (1.0 - s / self.polar as f64).powi(3);
            let share = L::of(tail(i as f64) - tail(i as f64 + 1.0));
            for (j, &(sin, cos)) in self.circle.iter().enumerate() {
                // A lattice rather than a grid: seen from inside, the limit of total reflection runs along one coordinate.
                let u0 = L::of(
                    1.0 - tail(
                        i as f64 + f64::from((j as u32).reverse_bits()) / 4_294_967_296.0 + 0.5 / self.circle.len() as f64,
                    ),
                );
                let m = vndf_sample_at(wo, ax, ay, one, u0, L::of(sin), L::of(cos));
                let cos_om = wo.dot(m).sat();
                let wi = reflect(wo, m);
                let is_up = wi.z.gt(zero);
                let mu_i = L::select(is_up, wi.z, zero);
                let length_i = smith_length(wi, ax, ay);
                // G2 / G1 of the height-correlated form.
                let w = mu_i * (wo.z + length_o) / (mu_i * length_o + wo.z * length_i).max(L::of(1e-20));
                metal += share * (one - w);
                let f = fresnel(cos_om, eta_reflection);
                dielectric += share * (one - f * w);
                if self.wanted.glass {
                    let through = |eta: L| {
                        let (bent, exists) = refract(wo, m, cos_om, eta);
                        let bent = V3::select(<L::Mask as Mask>::splat(s.is_matched), -wo, bent);
                        let g1 = if s.is_matched { one } else { g1_smith(bent, smith_length(bent, ax, ay)) };
                        let is_open = bent.z.lt(zero) & (exists | <L::Mask as Mask>::splat(s.is_matched));
                        L::select(is_open, g1, zero)
                    };
                    outwards += share * (f * w + (one - f) * through(eta));
                    let f = fresnel(cos_om, inside);
                    inwards += share * (f * w + (one - f) * through(inside));
                }
            }
        }
        let n = L::of(self.circle.len() as f64);
        let miss = |sum: L| (sum / n).sat();
        let kept = |sum: L| (sum / n).sat();
        [miss(metal), miss(dielectric), kept(outwards), kept(inwards)]
    }
}
