//! The numbers that lobes are made from: finite, and within the ranges that their documentation states.

use super::Numbers;
use crate::bsdf::Optics;
use crate::lanes::Lanes;

/// Coefficients that must be finite and within the range that their documentation states.
pub(super) fn check_optics(o: &Optics<f32>, prefix: &str, numbers: &mut Numbers) {
    let mut check = |name: &str, value: f32, low: f32, high: f32| {
        if !value.is_finite() {
            numbers.nonfinite += 1;
            if numbers.first_bad.is_empty() {
                numbers.first_bad = format!("{prefix}{name}");
            }
        } else if !(low..=high).contains(&value) {
            numbers.coefficients.push(format!("{prefix}{name} {value:e}"));
        }
    };
    for (name, value) in [
        ("w_metal", o.w_metal),
        ("w_diffuse", o.w_diffuse),
        ("w_transmission", o.w_transmission),
        ("roughness", o.roughness),
        ("anisotropy", o.anisotropy),
        ("specular level", o.level),
        ("sheen", o.sheen),
        ("coat", o.coat),
        ("coat roughness", o.coat_roughness),
        ("coat level", o.coat_level),
        ("opacity", o.opacity),
    ] {
        check(name, value, 0.0, 1.0);
    }
    for (name, value) in [("alpha along", o.alpha_x), ("alpha across", o.alpha_y), ("coat alpha", o.coat_alpha)] {
        check(name, value, 0.999 * <f32 as Lanes>::ALPHA_MIN as f32, 1.0);
    }
    // Reflectance is capped below 1, so that indices of refraction have an end, 40000 for a cap of 0.9999.
    for (name, value) in [("eta", o.eta), ("eta of the reflection", o.eta_specular), ("coat eta", o.coat_eta)] {
        check(name, value, 1e-5, 1e5);
    }
    check("rotation", o.rotation_cos.hypot(o.rotation_sin), 0.999, 1.001);
    check("sheen roughness", o.sheen_roughness, 0.999e-3, 1.0);
    check("dispersion", o.dispersion, 0.0, 20.0);
    for c in 0..3 {
        for (name, value) in [
            ("base color", o.base_color.0[c]),
            ("edge color", o.edge_color.0[c]),
            ("sheen color", o.sheen_color.0[c]),
            ("transmission tint", o.transmission_tint.0[c]),
        ] {
            check(name, value, 0.0, 1.0);
        }
        check("F82 coefficient", o.f82.0[c], 0.0, 18.0);
        check("logarithm of the coat tint", o.coat_ln_tint.0[c], -14.0, 0.0);
        // Optical depths of bodies of any size that is modelled, and sums of light, stay within single precision.
        check("absorption coefficient", o.sigma_a.0[c], 0.0, 1e13);
        check("scattering coefficient", o.sigma_s.0[c], 0.0, 1e13);
        check("emission", o.emission.0[c], 0.0, 1.001e30);
    }
}
