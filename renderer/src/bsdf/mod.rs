//! How a surface scatters light: the layered material as one BSDF with `prepare`, `eval`, `sample`.
//!
//! Conventions: local frame with z the shading normal on the outside of the body; `wo` towards the viewer, `wi` towards the
//! light, both unit and away from the surface; `eta` is transmitted over incident. Values include `|cos_theta_i|`, densities are per
//! solid angle over all lobes that are not delta. Layers nest: the coat holds the sheen, the sheen holds the base. Attenuation by coat and
//! sheen acts on the view side only (model reference 2), which conserves energy; the coat's tint acts on both sides.
//! Radiance is not scaled by `eta^2` at crossings (model reference 3.3). Twin of `bsdf.wgsl`.

pub mod coat;
pub mod fresnel;
pub mod ggx;
pub mod interpret;
pub mod sheen;
pub mod tables;

use crate::lanes::{Lanes, Mask};
use crate::vector::{Rgb, V3};
use burnish_material::{Lobe, LobeSet};
use coat::coat_passage;
use fresnel::{f82_tint, fresnel};
use ggx::{
    cosine_sample, d_ggx, g1_smith, reflect, reflection_pdf, reflection_visibility, refract, rotate_z, smith_length, vndf_bound,
    vndf_pdf, vndf_sample,
};
pub use interpret::{Optics, interpret};
use sheen::{sheen_eval, sheen_sample};
use std::f64::consts::FRAC_1_PI;
use tables::{dielectric_albedo, dielectric_albedo_mean, sheen_albedo};

/// Smallest share of the selection that a lobe with any weight gets: bounds sample weights by its inverse.
const SELECTION_MIN: f64 = 0.05;
/// Cosines below this are raised to it where they divide.
const COS_MIN: f64 = 1e-4;

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
    /// The direction crosses the surface.
    pub is_transmission: L::Mask,
    /// Where this does not hold the path ends.
    pub is_valid: L::Mask,
}

/// The BSDF at one point for one viewing direction.
#[derive(Clone, Copy, Debug)]
pub struct Bsdf<'a, L: Lanes> {
    optics: &'a Optics<L>,
    lobes: LobeSet,
    throughput: Rgb<L>,
    /// Viewing direction in the mirrored frame where its z is positive.
    wo: V3<L>,
    /// The same in the frame of the stretch.
    wo_stretch: V3<L>,
    /// The true frame has `wo` below the surface.
    is_below: L::Mask,
    /// Seen through the body: no coat, no sheen, inverted refraction. Opaque surfaces look the same from both sides.
    is_inside: L::Mask,
    /// Transmitted over incident index for bending.
    eta: L,
    /// The same for the reflectance of the refracting share.
    eta_fresnel: L,
    length_o: L,
    bound: L,
    coat: L,
    coat_length_o: L,
    coat_bound: L,
    /// What the coat's attenuation and the sheen's leave of the sheen and of the base.
    below_coat: Rgb<L>,
    below_sheen: L,
    sheen: L,
    diffuse_scale: L,
    /// Probability of choosing coat, sheen, interface, diffuse.
    p_coat: L,
    p_sheen: L,
    p_interface: L,
    p_diffuse: L,
}

impl<'a, L: Lanes> Bsdf<'a, L> {
    /// Everything that depends on the viewing direction: albedos of the layers and the probabilities of the lobes.
    ///
    /// `wo` is unit and local; below the surface it sees the body's inside. `throughput` of the path weights the choice of lobe and nothing
    /// else. Lobes that are not in `lobes` are not evaluated.
    #[inline(always)]
    pub fn prepare(optics: &'a Optics<L>, lobes: LobeSet, wo: V3<L>, throughput: Rgb<L>) -> Self {
        let one = L::one();
        let zero = L::zero();
        let is_below = wo.z.lt(zero);
        let is_inside = is_below & optics.w_transmission.gt(zero);
        let wo = V3::new(wo.x, wo.y, wo.z.abs().max(L::of(1e-6)));
        let wo_stretch = rotate_z(wo, optics.rotation_cos, -optics.rotation_sin);
        let mu = wo.z.max(L::of(COS_MIN));
        let beta = throughput.scale(one / throughput.max_channel().max(L::of(1e-30)));
        let eta = L::select(is_inside, one / optics.eta, optics.eta);
        let eta_fresnel = L::select(is_inside, eta, optics.eta_specular);

        let coat = L::select(is_inside, zero, optics.coat);
        let (mut e_coat, mut passage, mut coat_length_o, mut coat_bound) = (zero, Rgb::white(), one, one);
        if lobes.has(Lobe::coat) {
            let exact = fresnel(mu, optics.coat_eta);
            let rough = dielectric_albedo(optics.coat_eta, optics.coat_roughness, mu);
            e_coat = coat * L::select(optics.coat_is_smooth, exact, rough);
            passage = Rgb::select(is_inside, Rgb::white(), coat_passage(optics.coat_ln_tint, mu));
            coat_length_o = smith_length(wo, optics.coat_alpha, optics.coat_alpha);
            coat_bound = vndf_bound(wo, optics.coat_alpha, optics.coat_alpha);
        }
        let below_coat = passage.scale(one - e_coat);
        let (mut sheen, mut e_sheen) = (zero, zero);
        if lobes.has(Lobe::sheen) {
            sheen = L::select(is_inside, zero, optics.sheen);
            e_sheen = sheen_albedo(optics.sheen_roughness, mu);
        }
        let below_sheen = one - sheen * e_sheen;

        // Selection in proportion to what each lobe is expected to return for this path.
        let k1 = below_coat.max_channel();
        let k2 = k1 * below_sheen;
        let w_coat = e_coat;
        let w_sheen = k1 * sheen * optics.sheen_color.max_channel() * e_sheen;
        let e_dielectric = if lobes.has(Lobe::specular) || lobes.has(Lobe::transmission) {
            let outside = dielectric_albedo(optics.eta_specular, optics.roughness, mu);
            L::select(is_inside, fresnel(mu, eta_fresnel), outside)
        } else {
            zero
        };
        let mut reflected = Rgb::black();
        if lobes.has(Lobe::metal) {
            reflected = f82_tint(mu, optics.base_color, optics.f82).scale(optics.w_metal);
        }
        if lobes.has(Lobe::specular) {
            let tint = Rgb::select(is_inside, Rgb::white(), optics.edge_color);
            reflected = reflected + tint.scale((optics.w_diffuse + optics.w_transmission) * e_dielectric);
        }
        let mut w_interface = k2 * (beta * reflected).max_channel();
        if lobes.has(Lobe::transmission) {
            w_interface += k2 * optics.w_transmission * (beta * optics.transmission_tint).max_channel() * (one - e_dielectric);
        }
        let (mut w_diffuse, mut diffuse_scale) = (zero, zero);
        if lobes.has(Lobe::diffuse) {
            let e = dielectric_albedo(optics.eta_specular, optics.roughness, mu);
            let mean = dielectric_albedo_mean(optics.eta_specular, optics.roughness);
            w_diffuse = k2 * optics.w_diffuse * (beta * optics.base_color).max_channel() * (one - e);
            diffuse_scale = optics.w_diffuse * (one - e) * L::of(FRAC_1_PI) / (one - mean).max(L::of(1e-6));
        }
        let [p_coat, p_sheen, p_interface, p_diffuse] = probabilities([w_coat, w_sheen, w_interface, w_diffuse]);
        let transmits = optics.w_transmission.gt(zero);
        let bound = L::select(transmits, one, vndf_bound(wo_stretch, optics.alpha_x, optics.alpha_y));
        Self {
            optics,
            lobes,
            throughput: beta,
            wo,
            wo_stretch,
            is_below,
            is_inside,
            eta,
            eta_fresnel,
            length_o: smith_length(wo_stretch, optics.alpha_x, optics.alpha_y),
            bound,
            coat,
            coat_length_o,
            coat_bound,
            below_coat,
            below_sheen,
            sheen,
            diffuse_scale,
            p_coat,
            p_sheen,
            p_interface,
            p_diffuse,
        }
    }

    /// The other direction in the mirrored frame, and back.
    #[inline(always)]
    fn mirrored(&self, w: V3<L>) -> V3<L> {
        V3::new(w.x, w.y, L::select(self.is_below, -w.z, w.z))
    }

    /// Reflectance of the interface at a facet seen under `cos_om`, and what its refracting share lets through.
    #[inline(always)]
    fn interface(&self, cos_om: L) -> (Rgb<L>, Rgb<L>) {
        let o = self.optics;
        let mut reflected = Rgb::black();
        let mut transmitted = Rgb::black();
        if self.lobes.has(Lobe::metal) {
            reflected = f82_tint(cos_om, o.base_color, o.f82).scale(o.w_metal);
        }
        let f_outside = fresnel(cos_om, o.eta_specular);
        if self.lobes.has(Lobe::transmission) {
            let f = fresnel(cos_om, self.eta_fresnel);
            let tint = Rgb::select(self.is_inside, Rgb::white(), o.edge_color);
            reflected = reflected + tint.scale(o.w_transmission * f);
            transmitted = o.transmission_tint.scale(o.w_transmission * (L::one() - f));
        }
        if self.lobes.has(Lobe::specular) {
            reflected = reflected + o.edge_color.scale(o.w_diffuse * f_outside);
        }
        (reflected, transmitted)
    }

    /// Probability of reflecting rather than refracting at a facet.
    #[inline(always)]
    fn p_reflect(&self, reflected: Rgb<L>, transmitted: Rgb<L>) -> L {
        let r = (self.throughput * reflected).max_channel();
        let t = (self.throughput * transmitted).max_channel();
        L::select(t.gt(L::zero()), r / (r + t).max(L::of(1e-30)), L::one())
    }

    /// What reaches the base from the light side, and what remains for the viewer.
    #[inline(always)]
    fn layers(&self, mu_i: L) -> Rgb<L> {
        if !self.lobes.has(Lobe::coat) {
            return self.below_coat;
        }
        let light = coat_passage(self.optics.coat_ln_tint, mu_i.max(L::of(COS_MIN)));
        Rgb::select(self.is_inside, self.below_coat, self.below_coat * light)
    }

    /// Value times `|cos_theta_i|` of all lobes that are not delta, and their density. `wi` is unit and local.
    #[inline(always)]
    pub fn eval(&self, wi: V3<L>) -> (Rgb<L>, L) {
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
    fn eval_reflection(&self, wi: V3<L>) -> (Rgb<L>, L) {
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
            let (reflected, transmitted) = self.interface(cos_om);
            base = reflected.scale(visibility);
            let p = self.p_interface * self.p_reflect(reflected, transmitted);
            pdf = p * reflection_pdf(self.wo, d, self.bound, self.length_o);
        }
        if self.lobes.has(Lobe::diffuse) {
            let e = dielectric_albedo(o.eta_specular, o.roughness, wi.z);
            base = base + o.base_color.scale(self.diffuse_scale * (L::one() - e) * wi.z);
            pdf += self.p_diffuse * wi.z * L::of(FRAC_1_PI);
        }
        base = base.scale(self.below_sheen);
        if self.lobes.has(Lobe::sheen) {
            let (value, density) = sheen_eval(self.wo, wi, o.sheen_roughness);
            base = base + o.sheen_color.scale(self.sheen * value);
            pdf += self.p_sheen * density;
        }
        let mut value = base * self.layers(wi.z);
        if self.lobes.has(Lobe::coat) {
            let d = L::select(o.coat_is_smooth, zero, d_ggx(h, o.coat_alpha, o.coat_alpha));
            let length_i = smith_length(wi, o.coat_alpha, o.coat_alpha);
            let f = fresnel(cos_om, o.coat_eta);
            let coat = self.coat * f * d * reflection_visibility(self.wo.z, wi.z, self.coat_length_o, length_i);
            value = value + Rgb::grey(coat);
            pdf += self.p_coat * reflection_pdf(self.wo, d, self.coat_bound, self.coat_length_o);
        }
        (value, pdf)
    }

    /// Factor of the layers on light that crosses the surface: the outer side alone passes coat and sheen.
    #[inline(always)]
    fn layers_across(&self, mu_i: L) -> Rgb<L> {
        let from_outside = self.below_coat.scale(self.below_sheen);
        if !self.lobes.has(Lobe::coat) {
            return from_outside;
        }
        let leaving = coat_passage(self.optics.coat_ln_tint, mu_i.max(L::of(COS_MIN)));
        Rgb::select(self.is_inside, leaving, from_outside)
    }

    /// `eval` for directions across the surface, in the mirrored frame (`wi.z < 0`). Source: Walter et al. 2007.
    #[inline(always)]
    fn eval_transmission(&self, wi: V3<L>) -> (Rgb<L>, L) {
        let o = self.optics;
        let zero = L::zero();
        let sum = self.wo + wi.scale(self.eta);
        let sign = L::select(sum.z.lt(zero), -L::one(), L::one());
        let m = sum.scale(sign).normalize();
        let cos_om = self.wo.dot(m);
        let cos_im = wi.dot(m);
        let denominator = cos_om + self.eta * cos_im;
        let is_possible =
            cos_om.gt(zero) & cos_im.lt(zero) & m.z.gt(zero) & !o.is_smooth & !o.is_matched & denominator.abs().gt(L::of(1e-12));
        let m_stretch = rotate_z(m, o.rotation_cos, -o.rotation_sin);
        let wi_stretch = rotate_z(wi, o.rotation_cos, -o.rotation_sin);
        let d = d_ggx(m_stretch, o.alpha_x, o.alpha_y);
        let pdf_m = vndf_pdf(self.wo, cos_om, d, self.length_o);
        let jacobian = self.eta.sqr() * cos_im.abs() / denominator.sqr().max(L::of(1e-20));
        let g1 = g1_smith(wi_stretch, smith_length(wi_stretch, o.alpha_x, o.alpha_y));
        let (reflected, transmitted) = self.interface(cos_om.max(zero).min(L::one()));
        let p = self.p_interface * (L::one() - self.p_reflect(reflected, transmitted));
        let value = transmitted.scale(pdf_m * g1 * jacobian) * self.layers_across(wi.z.abs());
        (Rgb::select(is_possible, value, Rgb::black()), L::select(is_possible, p * pdf_m * jacobian, zero))
    }

    /// Draws a direction. `u` in `[0, 1)`: choice of lobe, direction (2), reflection or refraction.
    #[inline(always)]
    pub fn sample(&self, u: [L; 4]) -> BsdfSample<L> {
        let o = self.optics;
        let (zero, one) = (L::zero(), L::one());
        let none = <L::Mask as Mask>::splat(false);
        let c1 = self.p_coat;
        let c2 = c1 + self.p_sheen;
        let c3 = c2 + self.p_interface;
        let total = c3 + self.p_diffuse;
        let is_coat = u[0].lt(c1);
        let is_sheen = u[0].lt(c2) & !is_coat;
        // The last lobe with any probability takes what rounding leaves.
        let is_diffuse = (u[0].ge(c3) | self.p_interface.le(zero)) & self.p_diffuse.gt(zero) & !is_coat & !is_sheen;
        let is_interface = !is_coat & !is_sheen & !is_diffuse;

        // One visible normal serves coat and base: each lane has its own alpha and frame.
        let (mut cos, mut sin) = (o.rotation_cos, o.rotation_sin);
        let (mut wo, mut alpha_x, mut alpha_y) = (self.wo_stretch, o.alpha_x, o.alpha_y);
        let (mut bound, mut is_smooth) = (self.bound, o.is_smooth);
        if self.lobes.has(Lobe::coat) {
            cos = L::select(is_coat, one, cos);
            sin = L::select(is_coat, zero, sin);
            wo = V3::select(is_coat, self.wo, wo);
            alpha_x = L::select(is_coat, o.coat_alpha, alpha_x);
            alpha_y = L::select(is_coat, o.coat_alpha, alpha_y);
            bound = L::select(is_coat, self.coat_bound, bound);
            is_smooth = (is_coat & o.coat_is_smooth) | (!is_coat & is_smooth);
        }
        let up = V3::new(zero, zero, one);
        let m = vndf_sample(wo, alpha_x, alpha_y, bound, u[1], u[2]);
        let m = V3::select(is_smooth, up, rotate_z(m, cos, sin));
        let cos_om = self.wo.dot(m).max(zero).min(one);
        let mut wi = reflect(self.wo, m);

        // Refraction at the drawn facet.
        let mut is_transmission = none;
        let (mut through, mut through_pdf) = (Rgb::black(), zero);
        let mut is_delta = is_smooth & (is_coat | is_interface);
        let (reflected, transmitted) = self.interface(cos_om);
        let p_reflect = self.p_reflect(reflected, transmitted);
        if self.lobes.has(Lobe::transmission) {
            let p_refract = one - p_reflect;
            let (bent, exists) = refract(self.wo, m, cos_om, self.eta);
            let bent = V3::select(o.is_matched, -self.wo, bent);
            is_transmission = is_interface & u[3].ge(p_reflect) & p_refract.gt(zero);
            let is_open = (exists | o.is_matched) & bent.z.lt(zero);
            wi = V3::select(is_transmission, bent, wi);
            is_delta = is_delta | (is_transmission & o.is_matched);

            // The weight comes from the facet itself: dividing `eval` by the density would cancel badly for eta near 1.
            let stretch = |v: V3<L>| rotate_z(v, o.rotation_cos, -o.rotation_sin);
            let wi_stretch = stretch(bent);
            let is_straight = is_smooth | o.is_matched;
            let g1 = L::select(is_straight, one, g1_smith(wi_stretch, smith_length(wi_stretch, alpha_x, alpha_y)));
            let p = (self.p_interface * p_refract).max(L::of(1e-30));
            let factor = transmitted.scale(g1 / p) * self.layers_across(bent.z.abs());
            through = Rgb::select(is_open, factor, Rgb::black());
            let d = d_ggx(stretch(m), alpha_x, alpha_y);
            let cos_im = bent.dot(m);
            let denominator = cos_om + self.eta * cos_im;
            let jacobian = self.eta.sqr() * cos_im.abs() / denominator.sqr().max(L::of(1e-20));
            through_pdf = L::select(is_straight, zero, p * vndf_pdf(self.wo, cos_om, d, self.length_o) * jacobian);
        }

        if self.lobes.has(Lobe::diffuse) {
            wi = V3::select(is_diffuse, cosine_sample(u[1], u[2]), wi);
        }
        if self.lobes.has(Lobe::sheen) {
            wi = V3::select(is_sheen, sheen_sample(self.wo, o.sheen_roughness, u[1], u[2]), wi);
        }

        let is_up = wi.z.gt(L::of(1e-7));
        let wi_up = V3::new(wi.x, wi.y, wi.z.abs().max(L::of(1e-7)));
        let (value, pdf) = self.eval_reflection(wi_up);
        let mut weight = value.scale(one / L::select(pdf.gt(zero), pdf, one));
        let mut is_valid = is_up & (pdf.gt(zero) | is_delta);
        let mut pdf = L::select(is_delta, zero, pdf);

        // Delta reflections: the lobe's own reflectance over the probability of having chosen it.
        if is_delta.any() {
            let p = (self.p_interface * p_reflect).max(L::of(1e-30));
            let mut mirror = (reflected * self.layers(wi_up.z)).scale(self.below_sheen / p);
            if self.lobes.has(Lobe::coat) {
                let coat = self.coat * fresnel(cos_om, o.coat_eta) / self.p_coat.max(L::of(1e-30));
                mirror = Rgb::select(is_coat, Rgb::grey(coat), mirror);
            }
            weight = Rgb::select(is_delta, mirror, weight);
        }
        weight = Rgb::select(is_transmission, through, weight);
        pdf = L::select(is_transmission, through_pdf, pdf);
        is_valid = (is_transmission & wi.z.lt(zero)) | (!is_transmission & is_valid);
        is_valid = is_valid & total.gt(zero) & weight.max_channel().gt(zero);
        BsdfSample { wi: self.mirrored(wi), weight, pdf, is_delta, is_transmission, is_valid }
    }
}

/// Weights to probabilities: every lobe with any weight gets at least [`SELECTION_MIN`] before they are normalised.
#[inline(always)]
fn probabilities<L: Lanes>(weights: [L; 4]) -> [L; 4] {
    let sum = weights[0] + weights[1] + weights[2] + weights[3];
    let inverse = L::one() / L::select(sum.gt(L::zero()), sum, L::one());
    let p = weights.map(|w| L::select(w.gt(L::zero()), (w * inverse).max(L::of(SELECTION_MIN)), L::zero()));
    let sum = p[0] + p[1] + p[2] + p[3];
    let inverse = L::one() / L::select(sum.gt(L::zero()), sum, L::one());
    p.map(|p| p * inverse)
}
