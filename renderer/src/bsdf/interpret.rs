//! What the properties mean: inputs at one point to the numbers that the lobes use. Twin of `interpret.wgsl`.

use super::dispersion::{dispersed_ior, spectrum};
use super::fresnel::{f0_from_ior, f82_coefficient, ior_from_f0, level_to_ior};
use super::ggx::alphas;
use super::sheen::SHEEN_ROUGHNESS_MIN;
use crate::lanes::{Lanes, Routine};
use crate::vector::Rgb;
use burnish_material::{Inputs, Lobe, LobeSet};
use std::f64::consts::PI;

/// Smallest absorption colour: caps the optical depth at 6.9 per absorption distance. Model reference 10.1.
const ABSORPTION_COLOR_MIN: f64 = 1e-3;
/// Smallest length in scene units. Model reference 10.2.
const LENGTH_MIN: f64 = 1e-6;

/// Contrast of refraction below which light passes straight on.
const MATCHED_CONTRAST: f64 = 1e-6;
/// Smallest other contrast: half vectors made from it err by about 1 % of the narrowest lobe in single precision.
const CONTRAST_MIN: f64 = 5e-4;
/// Smallest channel of the distance scale, and smallest ratio of albedos between channels. Model reference 10.2.
const SCATTER_RATIO_MIN: f64 = 1e-3;
/// Largest dispersion: an Abbe number of 1.
const DISPERSION_MAX: f64 = 20.0;

/// Largest emitted radiance: sums along a path and over a picture stay within single precision.
pub const EMISSION_MAX: f64 = 1e30;

/// Everything that the lobes and the integrator need at one point.
#[derive(Clone, Copy, Debug)]
pub struct Optics<L: Lanes> {
    /// Diffuse albedo; reflectance of metal at normal incidence. `[0, 1]`.
    pub base_color: Rgb<L>,
    /// Tint of dielectric reflections from outside. `[0, 1]`.
    pub edge_color: Rgb<L>,
    /// Coefficient of the F82-tint curve.
    pub f82: Rgb<L>,
    /// Share of metal. The three shares sum to 1.
    pub w_metal: L,
    /// Share of the opaque dielectric.
    pub w_diffuse: L,
    /// Share of the refracting dielectric.
    pub w_transmission: L,
    /// Roughness as authored, `[0, 1]`: an axis of the albedo tables, like the next two.
    pub roughness: L,
    /// Anisotropy as authored, `[0, 1]`.
    pub anisotropy: L,
    /// Specular level as authored, `[0, 1]`.
    pub level: L,
    /// GGX alpha along the stretch.
    pub alpha_x: L,
    /// GGX alpha across the stretch.
    pub alpha_y: L,
    /// Cosine of the rotation of the stretch from the tangent.
    pub rotation_cos: L,
    /// Sine of the rotation of the stretch from the tangent.
    pub rotation_sin: L,
    /// The base is a perfect mirror.
    pub is_smooth: L::Mask,
    /// Index of refraction for bending, relative to the exterior; level included, coat not.
    pub eta: L,
    /// Index of refraction for the Fresnel reflectance from outside; level and coat included.
    pub eta_specular: L,
    /// Strength of dispersion, `[0, 20]`.
    pub dispersion: L,
    /// Refraction passes straight through.
    pub is_matched: L::Mask,
    /// Amount of sheen, `[0, 1]`.
    pub sheen: L,
    /// Tint of the sheen.
    pub sheen_color: Rgb<L>,
    /// Roughness of the sheen, at least 1e-3.
    pub sheen_roughness: L,
    /// Presence of the coat, `[0, 1]`.
    pub coat: L,
    /// Logarithm of the coat's tint, presence included.
    pub coat_ln_tint: Rgb<L>,
    /// Roughness of the coat as authored.
    pub coat_roughness: L,
    /// Specular level of the coat as authored.
    pub coat_level: L,
    /// GGX alpha of the coat.
    pub coat_alpha: L,
    /// The coat is a perfect mirror.
    pub coat_is_smooth: L::Mask,
    /// Index of refraction of the coat, level included.
    pub coat_eta: L,
    /// Factor on light at each refractive crossing (modulative absorption), else 1.
    pub transmission_tint: Rgb<L>,
    /// Absorption in the body, 1/scene unit: that of the absorption colour and that of the scattering medium.
    pub sigma_a: Rgb<L>,
    /// Scattering in the body, 1/scene unit.
    pub sigma_s: Rgb<L>,
    /// Emitted radiance of the front side.
    pub emission: Rgb<L>,
    /// Cut-through opacity.
    pub opacity: L,
}

/// Meaning of the inputs. `length_scale` is scene units per unit of the material's lengths.
///
/// Inputs may lie outside their hard ranges (textures): they are clamped here. Lobes that are not in `lobes` are not computed;
/// their fields hold what leaves them without effect.
#[inline(always)]
pub fn interpret<L: Lanes>(inputs: &Inputs<L>, lobes: LobeSet, length_scale: L) -> Optics<L> {
    L::call(Interpret { inputs, lobes, length_scale })
}

/// [`interpret`].
struct Interpret<'a, L> {
    inputs: &'a Inputs<L>,
    lobes: LobeSet,
    length_scale: L,
}

impl<L: Lanes> Routine<L> for Interpret<'_, L> {
    type Output = Optics<L>;
    #[inline(always)]
    fn run(self) -> Optics<L> {
        interpret_inline(self)
    }
}

#[inline(always)]
fn interpret_inline<L: Lanes>(Interpret { inputs, lobes, length_scale }: Interpret<'_, L>) -> Optics<L> {
    let one = L::one();
    let white = Rgb::white();
    let sat = |c: [L; 3]| Rgb(c.map(L::sat));
    let base_color = sat(inputs.base_color);
    let edge_color = sat(inputs.specular_edge_color);

    // Metal covers everything dielectric; translucency divides the rest (specification, "Metal and dielectric").
    let w_metal = if lobes.has(Lobe::metal) { inputs.metallic.sat() } else { L::zero() };
    let translucency = if lobes.has(Lobe::transmission) { inputs.translucency.sat() } else { L::zero() };
    let w_transmission = (one - w_metal) * translucency;
    let w_diffuse = (one - w_metal) * (one - translucency);

    let roughness = inputs.roughness.sat();
    let anisotropy = if lobes.has(Lobe::anisotropy) { inputs.anisotropy.sat() } else { L::zero() };
    let (alpha_x, alpha_y, is_smooth) = alphas(roughness, anisotropy);
    // Whole turns go first: times 2 pi, those of an image of large texels would leave no digits.
    let turn = inputs.anisotropy_rotation - inputs.anisotropy_rotation.floor();
    let (rotation_sin, rotation_cos) =
        if lobes.has(Lobe::anisotropy) { (L::of(2.0 * PI) * turn).sin_cos() } else { (L::zero(), one) };

    let coat = if lobes.has(Lobe::coat) { inputs.coat.sat() } else { L::zero() };
    let ior = inputs.specular_ior.max(L::of(1e-3));
    let level = inputs.specular_level.sat();
    let eta = level_to_ior(ior, level);
    let coat_ior = inputs.coat_ior.max(L::of(1e-3));
    let eta_specular = if lobes.has(Lobe::coat) {
        // The base sees the coat as its surroundings. Blending reflectances keeps the ratio above 1, so no false total
        // reflection appears where the coat is the denser medium (model reference 8.2).
        let f0 = f0_from_ior(ior).lerp(f0_from_ior(ior / coat_ior), coat) * L::of(2.0) * level;
        L::select(coat.gt(L::zero()), ior_from_f0(f0), eta)
    } else {
        eta
    };
    // The same in every precision: tables are made in double, pictures in single.
    let is_matched = (eta - one).abs().lt(L::of(MATCHED_CONTRAST));
    let eta = L::select(is_matched, one, eta);
    // A half vector needs some contrast: nearly matched media are moved to the smallest that single precision holds.
    let contrast = (eta - one).abs();
    let eta_apart = L::select(eta.lt(one), L::of(1.0 - CONTRAST_MIN), L::of(1.0 + CONTRAST_MIN));
    let eta = L::select(contrast.lt(L::of(CONTRAST_MIN)) & !is_matched, eta_apart, eta);

    let coat_tint = Rgb(inputs.coat_color.map(|c| one.lerp(c.sat(), coat)));
    let coat_roughness = inputs.coat_roughness.sat();
    let coat_level = inputs.coat_specular_level.sat();
    let (coat_alpha, _, coat_is_smooth) = alphas(coat_roughness, L::zero());

    let (sigma_s, sigma_s_a) = if lobes.has(Lobe::scattering) && inputs.scatter {
        scattering(inputs, length_scale)
    } else {
        (Rgb::black(), Rgb::black())
    };
    let (transmission_tint, sigma_a) = if lobes.has(Lobe::absorption) {
        let color = sat(inputs.absorption_color);
        let distance = inputs.absorption_distance.max(L::zero()) * length_scale;
        let is_modulative = inputs.absorption_distance.le(L::zero());
        let sigma = color.map(|c| {
            let ln = c.max(L::of(ABSORPTION_COLOR_MIN)).ln();
            L::select(is_modulative, L::zero(), (-ln / distance.max(L::of(LENGTH_MIN))).max(L::zero()))
        });
        (color.map(|c| L::select(is_modulative, c.sqrt(), one)), sigma)
    } else {
        (white, Rgb::black())
    };

    let emission = if lobes.has(Lobe::emission) {
        let strength = inputs.emission.max(L::zero());
        Rgb(inputs.emission_color.map(|c| (c.max(L::zero()) * strength).min(L::of(EMISSION_MAX))))
    } else {
        Rgb::black()
    };

    Optics {
        base_color,
        edge_color,
        f82: base_color.zip(edge_color, f82_coefficient),
        w_metal,
        w_diffuse,
        w_transmission,
        roughness,
        anisotropy,
        level,
        alpha_x,
        alpha_y,
        rotation_cos,
        rotation_sin,
        is_smooth,
        eta,
        eta_specular,
        dispersion: if lobes.has(Lobe::dispersion) {
            inputs.dispersion.max(L::zero()).min(L::of(DISPERSION_MAX))
        } else {
            L::zero()
        },
        is_matched,
        sheen: if lobes.has(Lobe::sheen) { inputs.sheen.sat() } else { L::zero() },
        sheen_color: sat(inputs.sheen_color),
        sheen_roughness: inputs.sheen_roughness.sat().max(L::of(SHEEN_ROUGHNESS_MIN)),
        coat,
        coat_ln_tint: coat_tint.map(|t| t.max(L::of(1e-6)).ln()),
        coat_roughness,
        coat_level,
        coat_alpha,
        coat_is_smooth,
        coat_eta: level_to_ior(coat_ior, coat_level),
        transmission_tint,
        sigma_a: sigma_a + sigma_s_a,
        sigma_s,
        emission,
        opacity: if lobes.has(Lobe::opacity) { inputs.opacity.sat() } else { one },
    }
}

/// Scattering and absorption coefficients of the scattering medium, 1/scene unit. Model reference 10.2.
///
/// The single-scattering albedo inverts van de Hulst's formula for the colour of a thick body (Kulla and Conty 2017); its complement
/// is kept as a square of its own, because `1 - a` loses all digits near white.
#[inline(always)]
fn scattering<L: Lanes>(inputs: &Inputs<L>, length_scale: L) -> (Rgb<L>, Rgb<L>) {
    let one = L::one();
    let s = Rgb(inputs.scatter_color.map(|c| {
        let dark = one - c.sat();
        let b = L::of(1.139) + L::of(1.17) * c.sat();
        L::of(2.0) * dark / (b + (b * b - L::of(0.556) * dark).sqrt())
    }));
    let albedo = s.map(|s| (one - s) * (one + s));
    let largest = albedo.max_channel();
    let has_albedo = largest.gt(L::zero());
    let distance = (inputs.scatter_distance.max(L::zero()) * length_scale).max(L::of(LENGTH_MIN));
    let scale = Rgb(inputs.scatter_distance_scale);
    let extinction = albedo.zip(scale, |a, scale| {
        let ratio = largest / a.max(largest * L::of(SCATTER_RATIO_MIN)).max(L::of(1e-30));
        L::select(has_albedo, ratio, one) / (distance * scale.max(L::of(SCATTER_RATIO_MIN)))
    });
    // Rayleigh scattering grows with the fourth power of frequency: factors at 640, 540 and 460 nm.
    let rayleigh = inputs.scatter_rayleigh.max(L::of(-1.0)).min(L::of(2.0));
    let factor = |g: f64| one + rayleigh * L::of(g - 1.0);
    // Red shift 1 lets red travel ten times further.
    let shift = (inputs.scatter_red_shift * L::of(-std::f64::consts::LN_10)).max(L::of(-60.0)).min(L::of(60.0)).exp();
    let factors = Rgb([factor((540.0f64 / 640.0).powi(4)) * shift, one, factor((540.0f64 / 460.0).powi(4))]);
    let extinction = (extinction * factors).map(|x| x.min(L::of(1.0 / LENGTH_MIN / LENGTH_MIN)));
    (extinction * albedo, extinction.zip(s, |x, s| x * s * s))
}

impl<L: Lanes> Optics<L> {
    /// The same for light of one wavelength, nanometres.
    #[inline(always)]
    #[must_use]
    pub fn at_wavelength(&self, wavelength: L) -> Self {
        let x = L::one() / (wavelength * wavelength);
        let mut optics = *self;
        optics.eta = dispersed_ior(self.eta, self.dispersion, x);
        optics.eta_specular = dispersed_ior(self.eta_specular, self.dispersion, x);
        optics
    }

    /// Index of refraction for the reflectance from outside, or of its bending, as red, green and blue see it.
    #[inline(always)]
    pub fn per_channel(&self, eta: L) -> Rgb<L> {
        Rgb(spectrum().inverse_square.map(|x| dispersed_ior(eta, self.dispersion, L::of(x))))
    }
}
