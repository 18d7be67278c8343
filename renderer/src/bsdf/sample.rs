//! Directions drawn from the BSDF. Twin of `sample.wgsl`.

use super::fresnel::fresnel;
use super::ggx::{cosine_sample, d_ggx, g1_smith, reflect, refract, rotate_z, smith_length, vndf_pdf, vndf_sample};
use super::sheen::sheen_sample;
use super::{Bsdf, spreads_metal};
use crate::lanes::{Lanes, Mask};
use crate::vector::{Rgb, V3};
use burnish_material::Lobe;

/// A sampled direction.
#[derive(Clone, Copy, Debug)]
pub struct BsdfSample<L: Lanes> {
    /// Unit, local.
    pub wi: V3<L>,
    /// Value times cosine over density; for a delta lobe its reflectance over the probability of choosing it.
    pub weight: Rgb<L>,
    /// Density over all lobes that are not delta; 0 for a delta lobe.
    pub pdf: L,
    /// The direction comes from a delta lobe: light sampling cannot find it.
    pub is_delta: L::Mask,
    /// The direction crosses the surface. With dispersion the path is light of its wavelength from here on.
    pub is_transmission: L::Mask,
    /// Where this does not hold the path ends.
    pub is_valid: L::Mask,
}

/// Which directions are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// All.
    Both,
    /// Those on the viewer's side. With those across the surface, drawn besides, they make up all.
    Same,
    /// Those across the surface.
    Across,
}

impl<L: Lanes> Bsdf<'_, L> {
    /// Draws a direction. `u` in `[0, 1)`: choice of lobe, direction (2), reflection or refraction.
    #[inline(always)]
    pub fn sample(&self, u: [L; 4]) -> BsdfSample<L> {
        self.sample_side(u, Side::Both)
    }

    /// Draws a direction on a side. The weights are those of that side alone; the density remains that of [`Self::sample`], so that it
    /// weighs against light sampling as before.
    #[inline(always)]
    pub fn sample_side(&self, u: [L; 4], side: Side) -> BsdfSample<L> {
        let o = self.optics;
        let (zero, one) = (L::zero(), L::one());
        let none = <L::Mask as Mask>::splat(false);
        let c1 = self.p_coat;
        let c2 = c1 + self.p_sheen;
        let c3 = c2 + self.p_interface;
        let total = c3 + self.p_diffuse;
        let has_choice = <L::Mask as Mask>::splat(side != Side::Across);
        let is_coat = u[0].lt(c1) & has_choice;
        let is_sheen = u[0].lt(c2) & !is_coat & has_choice;
        // The last lobe with any probability takes what rounding leaves.
        let is_diffuse = (u[0].ge(c3) | self.p_interface.le(zero)) & self.p_diffuse.gt(zero) & !is_coat & !is_sheen & has_choice;
        let is_interface = !is_coat & !is_sheen & !is_diffuse;

        // One visible normal serves coat and base: each lane has its own alpha and frame.
        let (mut cos, mut sin) = (o.rotation_cos, o.rotation_sin);
        let (mut wo, mut alpha_x, mut alpha_y) = (self.wo_stretch, o.alpha_x, o.alpha_y);
        let (mut bound, mut is_smooth) = (self.bound, o.is_smooth);
        if self.lobes.has(Lobe::coat) {
            cos = L::select(is_coat, one, cos);
            sin = L::select(is_coat, zero, sin);
            wo = V3::select(is_coat, self.coat_wo, wo);
            alpha_x = L::select(is_coat, o.coat_alpha, alpha_x);
            alpha_y = L::select(is_coat, o.coat_alpha, alpha_y);
            bound = L::select(is_coat, self.coat_bound, bound);
            is_smooth = (is_coat & o.coat_is_smooth) | (!is_coat & is_smooth);
        }
        let up = V3::new(zero, zero, one);
        let m = vndf_sample(wo, alpha_x, alpha_y, bound, u[1], u[2]);
        let mut m = V3::select(is_smooth, up, rotate_z(m, cos, sin));
        if let Some(frame) = self.coat_frame {
            m = V3::select(is_coat, frame.outer(m), m);
        }
        let cos_om = self.wo.dot(m).max(zero).min(one);
        let mut wi = reflect(self.wo, m);

        // Refraction at the drawn facet.
        let mut is_transmission = none;
        let (mut through, mut through_pdf) = (Rgb::black(), zero);
        let mut is_delta = is_smooth & (is_coat | is_interface);
        let (reflected, transmitted) = self.interface(cos_om, None);
        let p_reflect = self.p_reflect(reflected, transmitted);
        if self.lobes.has(Lobe::transmission) {
            let p_refract = one - p_reflect;
            let (bent, exists) = refract(self.wo, m, cos_om, self.eta);
            let bent = V3::select(o.is_matched, -self.wo, bent);
            let is_chosen = match side {
                Side::Both => u[3].ge(p_reflect),
                Side::Same => none,
                Side::Across => !none,
            };
            is_transmission = is_interface & is_chosen & p_refract.gt(zero);
            let is_open = (exists | o.is_matched) & bent.z.lt(zero);
            wi = V3::select(is_transmission, bent, wi);
            is_delta = is_delta | (is_transmission & o.is_matched);

            // The weight comes from the facet itself: dividing `eval` by the density would cancel badly for eta near 1.
            let stretch = |v: V3<L>| rotate_z(v, o.rotation_cos, -o.rotation_sin);
            let wi_stretch = stretch(bent);
            let is_straight = is_smooth | o.is_matched;
            let g1 = L::select(is_straight, one, g1_smith(wi_stretch, smith_length(wi_stretch, alpha_x, alpha_y)));
            let p = (self.p_interface * p_refract).max(L::of(1e-30));
            let chosen = if side == Side::Across { one } else { p };
            let factor = transmitted.scale(g1 / chosen) * self.layers_across(bent);
            through = Rgb::select(is_open, factor, Rgb::black());
            let d = d_ggx(stretch(m), alpha_x, alpha_y);
            let cos_im = bent.dot(m);
            // cos_om + eta cos_im by Snell's law, without the difference.
            let denominator = self.contrast * (self.eta + one) / (cos_om + self.eta * cos_im.abs()).max(L::of(1e-20));
            let jacobian = self.eta.sqr() * cos_im.abs() / denominator.sqr().max(L::of(1e-20));
            through_pdf = L::select(is_straight, zero, p * vndf_pdf(self.wo, cos_om, d, self.length_o) * jacobian);
        }

        if self.lobes.has(Lobe::diffuse) || spreads_metal(self.lobes) {
            wi = V3::select(is_diffuse, cosine_sample(u[1], u[2]), wi);
        }
        if self.lobes.has(Lobe::sheen) {
            wi = V3::select(is_sheen, sheen_sample(self.wo, o.sheen_roughness, u[1], u[2]), wi);
        }

        // A coat with its own normal reflects nothing below its own horizon.
        let is_up = wi.z.gt(L::of(1e-7)) & (!is_coat | self.in_coat(wi).z.gt(zero));
        let wi_up = V3::new(wi.x, wi.y, wi.z.abs().max(L::of(1e-7)));
        let (value, pdf) = self.eval_reflection(wi_up);
        let mut weight = value.scale(one / L::select(pdf.gt(zero), pdf, one));
        let mut is_valid = is_up & (pdf.gt(zero) | is_delta);
        let mut pdf = L::select(is_delta, zero, pdf);

        // Delta reflections: the lobe's own reflectance over the probability of having chosen it.
        if is_delta.any() {
            let p = (self.p_interface * p_reflect).max(L::of(1e-30));
            let mut mirror = (reflected * self.layers(wi_up)).scale(self.below_sheen / p);
            if self.lobes.has(Lobe::coat) {
                let coat = self.coat * fresnel(cos_om, o.coat_eta) / self.p_coat.max(L::of(1e-30));
                mirror = Rgb::select(is_coat, Rgb::grey(coat), mirror);
            }
            weight = Rgb::select(is_delta, mirror, weight);
        }
        if side == Side::Same && self.lobes.has(Lobe::transmission) {
            // The interface reflects for certain, not with its probability.
            weight = weight.scale(L::select(is_interface, p_reflect, one));
        }
        weight = Rgb::select(is_transmission, through, weight);
        pdf = L::select(is_transmission, through_pdf, pdf);
        is_valid = (is_transmission & wi.z.lt(zero)) | (!is_transmission & is_valid & has_choice);
        is_valid = is_valid & total.gt(zero) & weight.max_channel().gt(zero);
        BsdfSample { wi: self.mirrored(wi), weight, pdf, is_delta, is_transmission, is_valid }
    }
}
