//! Which lobe scatters what: the BSDF's value at a direction, divided among its lobes. For explanations, never for rendering.

use super::albedos::Quantity;
use super::fresnel::fresnel;
use super::{Bsdf, spreads_metal};
use crate::lanes::{Lanes, Mask};
use crate::vector::{Rgb, V3};
use burnish_material::{Lobe, LobeSet};

/// Lobes that send light in other directions, outermost first. The others change these or the body below.
///
/// `specular` reflects for all dielectrics, glass included; `multiple_scattering` is the further, even reflection of rough metal, since what glass
/// regains is a factor on its two lobes; `transmission` is all that crosses the surface, whatever the body does with it.
pub const SCATTERING: [Lobe; 7] =
    [Lobe::coat, Lobe::sheen, Lobe::specular, Lobe::metal, Lobe::multiple_scattering, Lobe::diffuse, Lobe::transmission];

/// Numbers of the lobes of [`SCATTERING`], in its order.
pub type ByLobe<T> = [T; SCATTERING.len()];

/// Cosines between the half vector and two normals that differ by less belong to both mirrors.
const SAME_MIRROR: f64 = 1e-4;

impl<L: Lanes> Bsdf<'_, L> {
    /// Shares of the lobes in what the surface scatters between `wi` (unit, local) and the viewer, by channel: they sum to 1, or are all 0
    /// where nothing is scattered. `is_delta`: the direction was drawn from a delta lobe.
    ///
    /// A lobe's value includes what the layers above it take away. Multiplying light that came by any estimator of the whole with
    /// these shares estimates the part of each lobe without bias.
    #[inline(always)]
    pub(crate) fn shares(&self, wi: V3<L>, is_delta: L::Mask) -> ByLobe<Rgb<L>> {
        let local = self.mirrored(wi);
        let is_across = local.z.lt(L::zero());
        let mut parts = [Rgb::black(); SCATTERING.len()];
        let mut sum = Rgb::black();
        for (part, lobe) in parts.iter_mut().zip(SCATTERING) {
            let is_there = self.lobes.has(lobe) || (lobe == Lobe::specular && self.lobes.has(Lobe::transmission));
            if !is_there || lobe == Lobe::transmission {
                continue;
            }
            let spread = if lobe == Lobe::multiple_scattering { self.spread(local) } else { self.only(lobe).eval(wi).0 };
            *part = if is_delta.any() { Rgb::select(is_delta, self.mirror(lobe, local), spread) } else { spread };
            sum = sum + *part;
        }
        for (part, lobe) in parts.iter_mut().zip(SCATTERING) {
            let across = if lobe == Lobe::transmission { Rgb::white() } else { Rgb::black() };
            let share = part.zip(sum, |part, sum| L::select(sum.gt(L::zero()), part / sum, L::zero()));
            *part = Rgb::select(is_across, across, share);
        }
        parts
    }

    /// The same surface with one lobe left, under layers that take what they took before. Its reflection alone is right.
    #[inline(always)]
    fn only(&self, lobe: Lobe) -> Self {
        let zero = L::zero();
        let interface = LobeSet::EMPTY.with(Lobe::metal).with(Lobe::specular).with(Lobe::transmission);
        let kept = match lobe {
            Lobe::metal => LobeSet::EMPTY.with(Lobe::metal),
            Lobe::specular => LobeSet::EMPTY.with(Lobe::specular).with(Lobe::transmission),
            _ => LobeSet::EMPTY,
        };
        Self {
            lobes: self.lobes.minus(interface.minus(kept)),
            coat: if lobe == Lobe::coat { self.coat } else { zero },
            sheen: if lobe == Lobe::sheen { self.sheen } else { zero },
            diffuse_scale: if lobe == Lobe::diffuse { self.diffuse_scale } else { zero },
            metal_scale: Rgb::black(),
            ..*self
        }
    }

    /// The further scattering of metal, in the mirrored frame.
    #[inline(always)]
    fn spread(&self, wi: V3<L>) -> Rgb<L> {
        if !spreads_metal(self.lobes) {
            return Rgb::black();
        }
        let o = self.optics;
        let grid = &self.albedos.base;
        let slant = grid.slant(super::ggx::rotate_z(wi, o.rotation_cos, -o.rotation_sin));
        let miss = grid.at(Quantity::MetalMiss, &self.place, &slant);
        (self.metal_scale * self.layers(wi)).scale(miss * wi.z * self.below_sheen)
    }

    /// Reflectance of a lobe that is a mirror at the facet that reflects `wi` (mirrored frame) to the viewer; 0 for one that is not, or mirrors
    /// elsewhere.
    #[inline(always)]
    fn mirror(&self, lobe: Lobe, wi: V3<L>) -> Rgb<L> {
        let o = self.optics;
        let m = (self.wo + wi).normalize();
        let cos_om = self.wo.dot(m).max(L::zero()).min(L::one());
        let slack = L::of(SAME_MIRROR);
        let (on_base, on_coat) = (m.z, self.in_coat(m).z);
        match lobe {
            Lobe::coat => {
                let is_mirror = o.coat_is_smooth & on_coat.ge(on_base - slack);
                Rgb::grey(L::select(is_mirror, self.coat * fresnel(cos_om, o.coat_eta), L::zero()))
            }
            Lobe::metal | Lobe::specular => {
                let is_mirror = o.is_smooth & on_base.ge(on_coat - slack);
                let (reflected, _) = self.only(lobe).interface(cos_om, None);
                Rgb::select(is_mirror, (reflected * self.layers(wi)).scale(self.below_sheen), Rgb::black())
            }
            _ => Rgb::black(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bsdf::{Albedos, Optics, View, interpret};
    use burnish_material::{Material, Property as P, Value::Color, Value::Float};

    /// A material with every lobe that scatters.
    fn everything(roughness: f64) -> Material {
        let mut material = Material::named("test");
        for (property, value) in [
            (P::metallic, Float(0.4)),
            (P::translucency, Float(0.5)),
            (P::base_color, Color([0.8, 0.5, 0.2])),
            (P::roughness, Float(roughness)),
            (P::anisotropy, Float(if roughness > 0.0 { 0.5 } else { 0.0 })),
            (P::sheen, Float(0.6)),
            (P::coat, Float(0.7)),
            (P::coat_color, Color([0.9, 0.6, 0.5])),
            (P::coat_roughness, Float(roughness * 0.5)),
        ] {
            material.set(property, value);
        }
        material
    }

    fn unit(x: f64, y: f64, z: f64) -> V3<f64> {
        V3::new(x, y, z).normalize()
    }

    #[test]
    fn parts_make_up_the_value() {
        let material = everything(0.4);
        let (inputs, lobes) = (material.inputs(), LobeSet::of(&material));
        assert!(SCATTERING.iter().all(|lobe| lobes.has(*lobe)));
        let albedos = Albedos::uniform(&inputs, lobes);
        let optics: Optics<f64> = interpret(&inputs, lobes, 1.0);
        for wo in [unit(0.3, 0.1, 1.0), unit(-1.0, 0.4, 0.3), unit(0.5, 0.2, -0.8)] {
            for coat_normal in [None, Some(unit(0.2, -0.1, 1.0))] {
                let bsdf = Bsdf::prepare(&optics, &albedos, lobes, &View { coat_normal, ..View::new(wo) });
                for wi in [unit(-0.2, 0.1, 0.9), unit(0.9, 0.5, 0.2), unit(0.1, 0.4, -0.7)] {
                    let (whole, _) = bsdf.eval(wi);
                    let is_across = wi.z * wo.z < 0.0;
                    let parts: Vec<Rgb<f64>> = SCATTERING
                        .iter()
                        .map(|lobe| match lobe {
                            Lobe::transmission => {
                                if is_across {
                                    whole
                                } else {
                                    Rgb::black()
                                }
                            }
                            _ if is_across => Rgb::black(),
                            Lobe::multiple_scattering => bsdf.spread(bsdf.mirrored(wi)),
                            lobe => bsdf.only(*lobe).eval(wi).0,
                        })
                        .collect();
                    let shares = bsdf.shares(wi, false);
                    for k in 0..3 {
                        let sum: f64 = parts.iter().map(|part| part.0[k]).sum();
                        assert!((sum - whole.0[k]).abs() <= 1e-9 * whole.0[k], "{wo:?} {wi:?}: {sum} {whole:?}");
                        assert!((shares.iter().map(|s| s.0[k]).sum::<f64>() - 1.0).abs() < 1e-9 || whole.0[k] == 0.0);
                        for (share, part) in shares.iter().zip(&parts) {
                            assert!((share.0[k] * sum - part.0[k]).abs() <= 1e-9 * sum);
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn mirrors_are_told_apart_by_where_they_send_light() {
        let material = everything(0.0);
        let (inputs, lobes) = (material.inputs(), LobeSet::of(&material));
        let albedos = Albedos::uniform(&inputs, lobes);
        let optics: Optics<f64> = interpret(&inputs, lobes, 1.0);
        let wo = unit(0.4, 0.0, 1.0);
        let coat = SCATTERING.iter().position(|lobe| *lobe == Lobe::coat).expect("it scatters");
        let share_of_coat = |coat_normal: Option<V3<f64>>, wi: V3<f64>| {
            let bsdf = Bsdf::prepare(&optics, &albedos, lobes, &View { coat_normal, ..View::new(wo) });
            bsdf.shares(wi, true)[coat].0[1]
        };
        let up = V3::new(-wo.x, -wo.y, wo.z);
        let both = share_of_coat(None, up);
        assert!(both > 0.01 && both < 0.9, "{both}");
        let n = unit(0.3, 0.0, 1.0);
        let about_coat = n.scale(2.0 * wo.dot(n)) - wo;
        assert_eq!([share_of_coat(Some(n), about_coat), share_of_coat(Some(n), up)], [1.0, 0.0]);
    }
}
