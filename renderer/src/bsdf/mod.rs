//! How a surface scatters light: the layered material as one BSDF with `prepare`, `eval`, `sample`.
//!
//! Conventions: local frame with z the shading normal on the outside of the body; `wo` towards the viewer, `wi` towards the
//! light, both unit and away from the surface; `eta` is transmitted over incident. Values include `|cos_theta_i|`, densities are per
//! solid angle over all lobes that are not delta. Layers nest: the coat holds the sheen, the sheen holds the base. Attenuation by coat and
//! sheen acts on the view side only (model reference 2), which conserves energy; the coat's tint acts on both sides.
//! Radiance is not scaled by `eta^2` at crossings (model reference 3.3).
//!
//! Light that meets several facets is not lost: a metal gets a further diffuse lobe for it (Kulla and Conty 2017; colour as the square of
//! the mean reflectance), glass is scaled up by what its single scattering misses, a dielectric passes it to the diffuse lobe below
//! (model reference 3.4, 5.3). The scale of glass depends on the viewer alone, so rough glass is not strictly reciprocal. Twin of `bsdf.wgsl`.

pub mod adjoint;
pub mod albedos;
pub mod coat;
pub mod dispersion;
mod eval;
mod fill;
pub mod fresnel;
pub mod ggx;
pub mod interpret;
mod parts;
mod sample;
pub mod sheen;
pub mod tables;

use crate::lanes::{Lanes, Routine};
use crate::vector::{Rgb, V3};
pub use albedos::Albedos;
use albedos::{Place, Quantity};
use burnish_material::{Lobe, LobeSet};
use coat::{CoatFrame, coat_passage};
use dispersion::WAVELENGTH_RANGE;
use fresnel::{f82_average, f82_tint, fresnel};
use ggx::{rotate_z, smith_length, vndf_bound};
pub use interpret::{Optics, interpret};
pub use parts::{ByLobe, SCATTERING};
pub use sample::{BsdfSample, Side};
use std::f64::consts::FRAC_1_PI;
use tables::sheen_albedo;

/// Share of the selection that a lobe gets at least, unless that were more than ten times what it is expected to return: bounds weights.
const SELECTION_MIN: f64 = 0.05;
/// Cosines below this are raised to it where they divide.
const COS_MIN: f64 = 1e-4;

/// Least share of light that rough glass counts as keeping: bounds its gain at the very horizon.
const GLASS_KEPT_MIN: f64 = 0.01;

/// What a path brings to a point.
#[derive(Clone, Copy, Debug)]
pub struct View<L: Lanes> {
    /// Direction to the viewer: unit, local; below the surface it sees the body's inside.
    pub wo: V3<L>,
    /// Weight of the path: it steers the choice of lobe and nothing else.
    pub throughput: Rgb<L>,
    /// Normal of the coat, unit, local, on the outside; `None`: that of the base.
    pub coat_normal: Option<V3<L>>,
    /// Wavelength of the path; needed with [`Lobe::dispersion`] only.
    pub light: Option<Wavelength<L>>,
}

/// Wavelength of a path.
#[derive(Clone, Copy, Debug)]
pub struct Wavelength<L: Lanes> {
    /// Nanometres.
    pub nm: L,
    /// Weights of the channels for light of this wavelength ([`dispersion::Spectrum::weights`]).
    pub weights: Rgb<L>,
    /// The path is light of this wavelength already: its throughput holds the weights.
    pub is_dispersed: L::Mask,
}

impl<L: Lanes> View<L> {
    /// A view along `wo` of white light, without a coat normal of its own, at the sodium line.
    #[inline(always)]
    pub fn new(wo: V3<L>) -> Self {
        Self { wo, throughput: Rgb::white(), coat_normal: None, light: None }
    }
}

/// The BSDF at one point for one viewing direction.
#[derive(Clone, Copy, Debug)]
pub struct Bsdf<'a, L: Lanes> {
    optics: &'a Optics<L>,
    albedos: &'a Albedos,
    lobes: LobeSet,
    throughput: Rgb<L>,
    /// Place of the material on its own tables, without dispersion.
    place: Place<L>,
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
    /// `eta - 1` with all its digits, which a difference would lose for nearly matched media.
    contrast: L,
    /// The same as `eta` for the reflectance of the refracting share.
    eta_fresnel: L,
    /// The same as red, green and blue see it: with dispersion only.
    eta_channels: Rgb<L>,
    /// Weights of the channels on light that refracts: with dispersion only.
    spectral: Rgb<L>,
    /// Makes up for multiple scattering in the refracting share.
    glass_gain: L,
    length_o: L,
    bound: L,
    coat: L,
    /// Frame of the coat where it is not that of the base.
    coat_frame: Option<CoatFrame<L>>,
    coat_wo: V3<L>,
    coat_length_o: L,
    coat_bound: L,
    /// What the coat's attenuation and the sheen's leave of the sheen and of the base.
    below_coat: Rgb<L>,
    below_sheen: L,
    sheen: L,
    diffuse_scale: L,
    /// Scale of the further scattering of metal.
    metal_scale: Rgb<L>,
    /// Probability of choosing coat, sheen, interface, and the cosine lobe of diffuse and further metallic scattering.
    p_coat: L,
    p_sheen: L,
    p_interface: L,
    p_diffuse: L,
}

impl<'a, L: Lanes> Bsdf<'a, L> {
    /// Everything that depends on the viewing direction: albedos of the layers and the probabilities of the lobes.
    ///
    /// Lobes that are not in `lobes` are not evaluated; `albedos` must have been made for the same set.
    #[inline(always)]
    pub fn prepare(optics: &'a Optics<L>, albedos: &'a Albedos, lobes: LobeSet, view: &View<L>) -> Self {
        L::call(Prepare { optics, albedos, lobes, view })
    }

    #[inline(always)]
    fn prepare_inline(Prepare { optics, albedos, lobes, view }: Prepare<'a, '_, L>) -> Self {
        let one = L::one();
        let zero = L::zero();
        let is_below = view.wo.z.lt(zero);
        let is_inside = is_below & optics.w_transmission.gt(zero);
        let wo = V3::new(view.wo.x, view.wo.y, view.wo.z.abs().max(L::of(1e-6)));
        let wo_stretch = rotate_z(wo, optics.rotation_cos, -optics.rotation_sin);
        let mu = wo.z.max(L::of(COS_MIN));
        let beta = view.throughput.scale(one / view.throughput.max_channel().max(L::of(1e-30)));

        let numbers = |wavelength: f64| {
            let [first, last] = WAVELENGTH_RANGE;
            [optics.roughness, optics.anisotropy, optics.level.sqrt(), optics.coat, L::of((wavelength - first) / (last - first))]
        };
        let base = &albedos.base;
        let place = base.place(numbers(dispersion::LAMBDA_D));
        let slant = base.slant(wo_stretch);
        let (mut eta_outside, mut eta_specular) = (optics.eta, optics.eta_specular);
        let (mut eta_channels, mut spectral, mut glass_place) = (Rgb::white(), Rgb::white(), place);
        if lobes.has(Lobe::dispersion)
            && let Some(light) = &view.light
        {
            let at = optics.at_wavelength(light.nm);
            (eta_outside, eta_specular) = (at.eta, at.eta_specular);
            let [first, last] = WAVELENGTH_RANGE;
            let mut at = numbers(0.0);
            at[4] = (light.nm - L::of(first)) * L::of(1.0 / (last - first));
            glass_place = base.place(at);
            let outside = Rgb::select(light.is_dispersed, Rgb::grey(eta_specular), optics.per_channel(optics.eta_specular));
            let inside = Rgb::select(light.is_dispersed, Rgb::grey(eta_outside), optics.per_channel(optics.eta));
            eta_channels = Rgb::select(is_inside, inside.map(|n| one / n), outside);
            // Without dispersion after all (an image, or a kernel that leaves nothing out) light stays white.
            let is_white = light.is_dispersed | optics.dispersion.le(zero);
            spectral = Rgb::select(is_white, Rgb::white(), light.weights);
        } else if lobes.has(Lobe::dispersion) {
            eta_channels = Rgb::grey(L::select(is_inside, one / optics.eta, optics.eta_specular));
        }
        let eta = L::select(is_inside, one / eta_outside, eta_outside);
        let contrast = L::select(is_inside, (one - eta_outside) / eta_outside, eta_outside - one);
        let eta_fresnel = L::select(is_inside, eta, eta_specular);
        let glass_gain = if lobes.has(Lobe::transmission) && lobes.has(Lobe::multiple_scattering) {
            let outside = base.at(Quantity::GlassKept, &glass_place, &slant);
            let kept = L::select(is_inside, base.at(Quantity::GlassKeptInside, &glass_place, &slant), outside);
            one / kept.max(L::of(GLASS_KEPT_MIN))
        } else {
            one
        };

        let coat = L::select(is_inside, zero, optics.coat);
        let (mut e_coat, mut passage, mut coat_length_o, mut coat_bound) = (zero, Rgb::white(), one, one);
        let (mut coat_frame, mut coat_wo, mut coat) = (None, wo, coat);
        if lobes.has(Lobe::coat) {
            if let Some(n) = view.coat_normal {
                // Seen from below, the frame is mirrored, and so is the normal that faces the viewer.
                let frame = CoatFrame::new(V3::select(is_below, V3::new(-n.x, -n.y, n.z), n));
                coat_wo = frame.local(wo);
                coat = L::select(coat_wo.z.gt(zero), coat, zero);
                coat_wo = V3::new(coat_wo.x, coat_wo.y, coat_wo.z.max(L::of(COS_MIN)));
                coat_frame = Some(frame);
            }
            let mu = coat_wo.z.max(L::of(COS_MIN));
            let exact = fresnel(mu, optics.coat_eta);
            let at = [optics.coat_roughness, zero, optics.coat_level.sqrt(), zero, zero];
            let grid = &albedos.coat;
            let miss = grid.at(Quantity::DielectricMiss, &grid.place(at), &grid.slant(coat_wo));
            e_coat = coat * L::select(optics.coat_is_smooth, exact, one - miss);
            passage = Rgb::select(is_inside, Rgb::white(), coat_passage(optics.coat_ln_tint, mu));
            coat_length_o = smith_length(coat_wo, optics.coat_alpha, optics.coat_alpha);
            coat_bound = vndf_bound(coat_wo, optics.coat_alpha, optics.coat_alpha);
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
        let w_sheen = k1 * sheen * optics.sheen_color.max_channel() * e_sheen;
        let has_dielectric = lobes.has(Lobe::specular) || lobes.has(Lobe::transmission) || lobes.has(Lobe::diffuse);
        let miss = if has_dielectric { base.at(Quantity::DielectricMiss, &place, &slant) } else { one };
        let e_dielectric = L::select(is_inside, fresnel(mu, eta_fresnel), one - miss);
        let mut reflected = Rgb::black();
        let (mut w_diffuse, mut diffuse_scale, mut metal_scale) = (zero, zero, Rgb::black());
        if lobes.has(Lobe::metal) {
            reflected = f82_tint(mu, optics.base_color, optics.f82).scale(optics.w_metal);
        }
        if spreads_metal(lobes) {
            let lost = base.at(Quantity::MetalMiss, &place, &slant);
            let mean = base.mean(Quantity::MetalMiss, &place).max(L::of(1e-9));
            let average = f82_average(optics.base_color, optics.f82);
            let further = (average * average).scale(optics.w_metal * lost);
            metal_scale = further.scale(L::of(FRAC_1_PI) / mean);
            w_diffuse = k2 * (beta * further).max_channel();
        }
        if lobes.has(Lobe::specular) {
            let tint = Rgb::select(is_inside, Rgb::white(), optics.edge_color);
            reflected = reflected + tint.scale((optics.w_diffuse + optics.w_transmission) * e_dielectric);
        }
        let mut w_interface = k2 * (beta * reflected).max_channel();
        if lobes.has(Lobe::transmission) {
            w_interface += k2 * optics.w_transmission * (beta * optics.transmission_tint).max_channel() * (one - e_dielectric);
        }
        if lobes.has(Lobe::diffuse) {
            let mean = base.mean(Quantity::DielectricMiss, &place);
            w_diffuse += k2 * optics.w_diffuse * (beta * optics.base_color).max_channel() * miss;
            diffuse_scale = optics.w_diffuse * miss * L::of(FRAC_1_PI) / mean.max(L::of(1e-6));
        }
        let [p_coat, p_sheen, p_interface, p_diffuse] = probabilities([e_coat, w_sheen, w_interface, w_diffuse]);
        let transmits = optics.w_transmission.gt(zero);
        let bound = L::select(transmits, one, vndf_bound(wo_stretch, optics.alpha_x, optics.alpha_y));
        Self {
            optics,
            albedos,
            lobes,
            throughput: beta,
            place,
            wo,
            wo_stretch,
            is_below,
            is_inside,
            eta,
            contrast,
            eta_fresnel,
            eta_channels,
            spectral,
            glass_gain,
            length_o: smith_length(wo_stretch, optics.alpha_x, optics.alpha_y),
            bound,
            coat,
            coat_frame,
            coat_wo,
            coat_length_o,
            coat_bound,
            below_coat,
            below_sheen,
            sheen,
            diffuse_scale,
            metal_scale,
            p_coat,
            p_sheen,
            p_interface,
            p_diffuse,
        }
    }

    /// The same surface, with directions drawn from all lobes but the cosine lobe of even scattering.
    #[inline(always)]
    pub fn glossy(&self) -> Self {
        let sum = self.p_coat + self.p_sheen + self.p_interface;
        let scale = L::one() / L::select(sum.gt(L::zero()), sum, L::one());
        Self {
            p_coat: self.p_coat * scale,
            p_sheen: self.p_sheen * scale,
            p_interface: self.p_interface * scale,
            p_diffuse: L::zero(),
            ..*self
        }
    }

    /// The other direction in the mirrored frame, and back.
    #[inline(always)]
    fn mirrored(&self, w: V3<L>) -> V3<L> {
        V3::new(w.x, w.y, L::select(self.is_below, -w.z, w.z))
    }

    /// A direction of the mirrored frame in the frame of the coat.
    #[inline(always)]
    fn in_coat(&self, w: V3<L>) -> V3<L> {
        self.coat_frame.map_or(w, |frame| frame.local(w))
    }
}

/// [`Bsdf::prepare`].
struct Prepare<'a, 'b, L: Lanes> {
    optics: &'a Optics<L>,
    albedos: &'a Albedos,
    lobes: LobeSet,
    view: &'b View<L>,
}

impl<'a, L: Lanes> Routine<L> for Prepare<'a, '_, L> {
    type Output = Bsdf<'a, L>;
    #[inline(always)]
    fn run(self) -> Bsdf<'a, L> {
        Bsdf::prepare_inline(self)
    }
}

/// Whether metal has its further, diffuse lobe.
#[inline(always)]
fn spreads_metal(lobes: LobeSet) -> bool {
    lobes.has(Lobe::metal) && lobes.has(Lobe::multiple_scattering)
}

/// Weights to probabilities.
#[inline(always)]
fn probabilities<L: Lanes>(weights: [L; 4]) -> [L; 4] {
    let sum = weights[0] + weights[1] + weights[2] + weights[3];
    let inverse = L::one() / L::select(sum.gt(L::zero()), sum, L::one());
    let p = weights.map(|w| {
        let share = w * inverse;
        L::select(w.gt(L::zero()), share.max(L::of(SELECTION_MIN).min(L::of(10.0) * share)), L::zero())
    });
    let sum = p[0] + p[1] + p[2] + p[3];
    let inverse = L::one() / L::select(sum.gt(L::zero()), sum, L::one());
    p.map(|p| p * inverse)
}
