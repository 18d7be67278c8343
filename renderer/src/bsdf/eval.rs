//! Values and densities of the BSDF. Twin of `eval.wgsl`.

use super::albedos::Quantity;
use super::coat::coat_passage;
use super::fresnel::{f82_tint, fresnel, fresnel_bent};
use super::ggx::{d_ggx, g1_smith, reflection_pdf, reflection_visibility, rotate_z, smith_length, vndf_pdf};
use super::sheen::sheen_eval;
use super::{Bsdf, COS_MIN, spreads_metal};
use crate::lanes::{Lanes, Routine};
use crate::vector::{Rgb, V3};
use burnish_material::Lobe;
use std::f64::consts::FRAC_1_PI;

/// [`Bsdf::eval`].
struct Eval<'a, L: Lanes> {
    bsdf: &'a Bsdf<'a, L>,
    wi: V3<L>,
}

impl<L: Lanes> Routine<L> for Eval<'_, L> {
    type Output = (Rgb<L>, L);
    #[inline(always)]
    fn run(self) -> (Rgb<L>, L) {
        self.bsdf.eval_inline(self.wi)
    }
}

impl<L: Lanes> Bsdf<'_, L> {
    /// Reflectance of the interface at a facet seen under `cos_om`, and what its refracting share lets through. `cos_im`: of the refracted
    /// direction, where it is known.
    #[inline(always)]
    pub(super) fn interface(&self, cos_om: L, cos_im: Option<L>) -> (Rgb<L>, Rgb<L>) {
        let o = self.optics;
        let mut reflected = Rgb::black();
        let mut transmitted = Rgb::black();
        if self.lobes.has(Lobe::metal) {
            reflected = f82_tint(cos_om, o.base_color, o.f82).scale(o.w_metal);
        }
        if self.lobes.has(Lobe::transmission) {
            let mut f = fresnel(cos_om, self.eta_fresnel);
            if let Some(cos_im) = cos_im {
                // Under a coat, light reflects by another index than it bends by.
                let g = (self.eta * cos_im.abs()).max(L::of(1e-20));
                f = L::select(self.eta_fresnel.eq(self.eta) & !o.is_matched, fresnel_bent(cos_om, g, self.eta), f);
            }
            let tint = Rgb::select(self.is_inside, Rgb::white(), o.edge_color);
            let share = o.w_transmission * self.glass_gain;
            transmitted = o.transmission_tint.scale(share * (L::one() - f));
            if self.lobes.has(Lobe::dispersion) {
                let Rgb([r, g, b]) = self.eta_channels;
                let f = Rgb([fresnel(cos_om, r), fresnel(cos_om, g), fresnel(cos_om, b)]);
                reflected = reflected + (tint * f).scale(share);
                transmitted = transmitted * self.spectral;
            } else {
                reflected = reflected + tint.scale(share * f);
            }
        }
        if self.lobes.has(Lobe::specular) && self.lobes.has(Lobe::diffuse) {
            reflected = reflected + o.edge_color.scale(o.w_diffuse * fresnel(cos_om, o.eta_specular));
        }
        (reflected, transmitted)
    }

    /// Probability of reflecting rather than refracting at a facet.
    #[inline(always)]
    pub(super) fn p_reflect(&self, reflected: Rgb<L>, transmitted: Rgb<L>) -> L {
        let r = (self.throughput * reflected).max_channel();
        let t = (self.throughput * transmitted).max_channel();
        L::select(t.gt(L::zero()), r / (r + t).max(L::of(1e-30)), L::one())
    }

    /// What reaches the base from the light side, and what remains for the viewer.
    #[inline(always)]
    pub(super) fn layers(&self, wi: V3<L>) -> Rgb<L> {
        if !self.lobes.has(Lobe::coat) {
            return self.below_coat;
        }
        let light = coat_passage(self.optics.coat_ln_tint, self.in_coat(wi).z.max(L::of(COS_MIN)));
        Rgb::select(self.is_inside, self.below_coat, self.below_coat * light)
    }

    /// Value times `|cos_theta_i|` of all lobes that are not delta, and their density. `wi` is unit and local.
    #[inline(always)]
    pub fn eval(&self, wi: V3<L>) -> (Rgb<L>, L) {
        L::call(Eval { bsdf: self, wi })
    }

    #[inline(always)]
    fn eval_inline(&self, wi: V3<L>) -> (Rgb<L>, L) {
        let wi = self.mirrored(wi);
        let is_reflection = wi.z.gt(L::zero());
        let (value, pdf) = self.eval_reflection(V3::new(wi.x, wi.y, wi.z.abs().max(L::of(1e-7))));
        if !self.lobes.has(Lobe::transmission) {
            return (Rgb::select(is_reflection, value, Rgb::black()), L::select(is_reflection, pdf, L::zero()));
        }
        let (through, through_pdf) = self.eval_transmission(V3::new(wi.x, wi.y, -wi.z.abs().max(L::of(1e-7))));
        (Rgb::select(is_reflection, value, through), L::select(is_reflection, pdf, through_pdf))
    }

    /// `eval` for directions on the viewer's side, in the mirrored frame.
    #[inline(always)]
    pub(super) fn eval_reflection(&self, wi: V3<L>) -> (Rgb<L>, L) {
        let o = self.optics;
        let zero = L::zero();
        let h = (self.wo + wi).normalize();
        let cos_om = self.wo.dot(h).max(zero).min(L::one());
        let mut base = Rgb::black();
        let mut pdf = zero;
        if self.lobes.has(Lobe::metal) || self.lobes.has(Lobe::specular) || self.lobes.has(Lobe::transmission) {
            let m = rotate_z(h, o.rotation_cos, -o.rotation_sin);
            let wi_stretch = rotate_z(wi, o.rotation_cos, -o.rotation_sin);
            let d = L::select(o.is_smooth, zero, d_ggx(m, o.alpha_x, o.alpha_y));
            let length_i = smith_length(wi_stretch, o.alpha_x, o.alpha_y);
            let visibility = d * reflection_visibility(self.wo.z, wi.z, self.length_o, length_i);
            let (reflected, transmitted) = self.interface(cos_om, None);
            base = reflected.scale(visibility);
            let p = self.p_interface * self.p_reflect(reflected, transmitted);
            pdf = p * reflection_pdf(self.wo, d, self.bound, self.length_o);
        }
        if self.lobes.has(Lobe::diffuse) || spreads_metal(self.lobes) {
            let grid = &self.albedos.base;
            let slant = grid.slant(rotate_z(wi, o.rotation_cos, -o.rotation_sin));
            if self.lobes.has(Lobe::diffuse) {
                let miss = grid.at(Quantity::DielectricMiss, &self.place, &slant);
                base = base + o.base_color.scale(self.diffuse_scale * miss * wi.z);
            }
            if spreads_metal(self.lobes) {
                base = base + self.metal_scale.scale(grid.at(Quantity::MetalMiss, &self.place, &slant) * wi.z);
            }
            pdf += self.p_diffuse * wi.z * L::of(FRAC_1_PI);
        }
        base = base.scale(self.below_sheen);
        if self.lobes.has(Lobe::sheen) {
            let (value, density) = sheen_eval(self.wo, wi, o.sheen_roughness);
            base = base + o.sheen_color.scale(self.sheen * value);
            pdf += self.p_sheen * density;
        }
        let mut value = base * self.layers(wi);
        if self.lobes.has(Lobe::coat) {
            let (h, wi) = (self.in_coat(h), self.in_coat(wi));
            let is_hidden = o.coat_is_smooth | wi.z.le(zero) | h.z.le(zero);
            let d = L::select(is_hidden, zero, d_ggx(h, o.coat_alpha, o.coat_alpha));
            let length_i = smith_length(wi, o.coat_alpha, o.coat_alpha);
            let f = fresnel(cos_om, o.coat_eta);
            let mu_i = wi.z.max(L::of(1e-7));
            let coat = self.coat * f * d * reflection_visibility(self.coat_wo.z, mu_i, self.coat_length_o, length_i);
            value = value + Rgb::grey(coat);
            pdf += self.p_coat * reflection_pdf(self.coat_wo, d, self.coat_bound, self.coat_length_o);
        }
        (value, pdf)
    }

    /// Factor of the layers on light that crosses the surface: the outer side alone passes coat and sheen.
    #[inline(always)]
    pub(super) fn layers_across(&self, wi: V3<L>) -> Rgb<L> {
        let from_outside = self.below_coat.scale(self.below_sheen);
        if !self.lobes.has(Lobe::coat) {
            return from_outside;
        }
        let leaving = coat_passage(self.optics.coat_ln_tint, wi.z.abs().max(L::of(COS_MIN)));
        Rgb::select(self.is_inside, leaving, from_outside)
    }

    /// `eval` for directions across the surface, in the mirrored frame (`wi.z < 0`). Source: Walter et al. 2007.
    #[inline(always)]
    fn eval_transmission(&self, wi: V3<L>) -> (Rgb<L>, L) {
        let o = self.optics;
        let zero = L::zero();
        // wo + eta wi, and its length in the place of cos_om + eta cos_im: nearly matched media leave no digits of either otherwise.
        let sum = (self.wo + wi) + wi.scale(self.contrast);
        let sign = L::select(sum.z.lt(zero), -L::one(), L::one());
        let m = sum.scale(sign).normalize();
        let cos_om = self.wo.dot(m);
        let cos_im = wi.dot(m);
        let square = sum.length_squared();
        let is_possible =
            cos_om.gt(zero) & cos_im.lt(zero) & m.z.gt(zero) & !o.is_smooth & !o.is_matched & square.gt(L::of(1e-24));
        let m_stretch = rotate_z(m, o.rotation_cos, -o.rotation_sin);
        let wi_stretch = rotate_z(wi, o.rotation_cos, -o.rotation_sin);
        let d = d_ggx(m_stretch, o.alpha_x, o.alpha_y);
        let pdf_m = vndf_pdf(self.wo, cos_om, d, self.length_o);
        let jacobian = self.eta.sqr() * cos_im.abs() / square.max(L::of(1e-20));
        let g1 = g1_smith(wi_stretch, smith_length(wi_stretch, o.alpha_x, o.alpha_y));
        let (reflected, transmitted) = self.interface(cos_om.max(zero).min(L::one()), Some(cos_im));
        let p = self.p_interface * (L::one() - self.p_reflect(reflected, transmitted));
        let value = transmitted.scale(pdf_m * g1 * jacobian) * self.layers_across(wi);
        (Rgb::select(is_possible, value, Rgb::black()), L::select(is_possible, p * pdf_m * jacobian, zero))
    }
}
