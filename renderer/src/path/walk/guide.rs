//! Steering towards the nearest surface with the exponential shape that light has deep in a medium.
//!
//! Sources: Krivanek and d'Eon 2014 (zero-variance walks after Dwivedi); Meng, Hanika, Dachsbacher 2016; the fit of the diffusion
//! length from d'Eon and Krivanek 2020.

use glam::DVec3;

/// Diffusion length in mean free paths, above 1: the root of `1 = (a/2) nu ln((nu + 1)/(nu - 1))`. `absorbed` is `1 - a` in `[0, 1]`,
/// kept apart because its digits are lost in `a`; infinite where nothing is absorbed. Albedos below 0.2 count as 0.2: lower roots
/// lie so close to 1 that steered flights would never turn.
pub(super) fn diffusion_length(absorbed: f64) -> f64 {
    let b = absorbed.clamp(0.0, 0.8);
    if b == 0.0 {
        return f64::INFINITY;
    }
    if b < 1e-3 {
        // Inverting 1 - x/artanh(x) = x^2/3 + 4 x^4/45 + ... for x = 1/nu.
        return 1.0 / (3.0 * b * (1.0 - 0.8 * b)).sqrt();
    }
    let a = 1.0 - b;
    let exponent = 2.442_94 - 0.021_581_3 * a + 0.578_637 / a;
    let mut x = (1.0 - a.powf(exponent)).sqrt();
    // Two steps of Newton's method turn the fit's 1e-4 into rounding.
    for _ in 0..2 {
        let t = x.atanh();
        let slope = x / (t * t * (1.0 - x * x)) - 1.0 / t;
        x = (x - (1.0 - x / t - b) / slope).min(1.0 - 1e-15);
    }
    1.0 / x
}

/// `ln((nu + 1)/(nu - 1))`.
pub(super) fn span(nu: f64) -> f64 {
    2.0 * (1.0 / nu).atanh()
}

/// A cosine against the guide direction, from a number in (0, 1).
pub(super) fn sample(nu: f64, span: f64, u: f64) -> f64 {
    (nu - (nu + 1.0) * (-u * span).exp()).clamp(-1.0, 1.0)
}

/// Density of [`sample`] over cosines.
pub(super) fn density(nu: f64, span: f64, mu: f64) -> f64 {
    1.0 / ((nu - mu) * span)
}

/// The unit vector at cosine `mu` from the unit vector `n`, at an azimuth given by a number in `[0, 1]`.
pub(super) fn around(n: DVec3, mu: f64, u: f64) -> DVec3 {
    // The frame is that of Duff et al. 2017.
    let sign = if n.z < 0.0 { -1.0 } else { 1.0 };
    let a = -1.0 / (sign + n.z);
    let b = n.x * n.y * a;
    let tangent = DVec3::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x);
    let bitangent = DVec3::new(b, sign + n.y * n.y * a, -n.y);
    let (sin, cos) = (u * std::f64::consts::TAU).sin_cos();
    let across = (1.0 - mu * mu).max(0.0).sqrt();
    tangent * (across * cos) + bitangent * (across * sin) + n * mu
}

/// A unit vector, uniform for two uniform numbers in `[0, 1]`.
pub(super) fn uniform(u0: f64, u1: f64) -> DVec3 {
    let z = 1.0 - 2.0 * u0;
    let (sin, cos) = (u1 * std::f64::consts::TAU).sin_cos();
    let across = (1.0 - z * z).max(0.0).sqrt();
    DVec3::new(across * cos, across * sin, z)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn diffusion_lengths_are_the_published_ones_and_solve_their_equation() {
        for (a, nu) in
            [(0.5, 1.044_382), (0.8, 1.407_634), (0.9, 1.903_205), (0.95, 2.635_149), (0.99, 5.796_729), (0.999, 18.264_726)]
        {
            let found = diffusion_length(1.0 - a);
            assert!((found - nu).abs() < 1e-6 * nu, "{a}: {found}");
        }
        for i in 0..400 {
            let b = 0.8 * 10f64.powf(-0.03 * f64::from(i));
            let nu = diffusion_length(b);
            // 1 - x/artanh(x) by its series where the difference has no digits.
            let x = 1.0 / nu;
            let solved = if x < 0.02 { x * x / 3.0 + 4.0 * x.powi(4) / 45.0 } else { 1.0 - x / x.atanh() };
            assert!((solved - b).abs() < 3e-6 * b, "{b}: {nu} {solved}");
        }
        assert_eq!(diffusion_length(1.0), diffusion_length(0.8));
        assert_eq!(diffusion_length(0.0), f64::INFINITY);
    }

    #[test]
    fn cosines_follow_their_density() {
        let nu = diffusion_length(0.03);
        let span = span(nu);
        for i in 0..100 {
            let (u, h) = (0.005 + 0.0099 * f64::from(i), 1e-6);
            let slope = (sample(nu, span, u + h) - sample(nu, span, u - h)) / (2.0 * h);
            assert!((slope * density(nu, span, sample(nu, span, u)) - 1.0).abs() < 1e-4);
        }
        assert!((sample(nu, span, 0.0) + 1.0).abs() < 1e-12 && (sample(nu, span, 1.0) - 1.0).abs() < 1e-12);
        let n = DVec3::new(0.3, -0.5, -0.8).normalize();
        for k in 0..8 {
            let d = around(n, 0.37, f64::from(k) / 8.0);
            assert!((d.dot(n) - 0.37).abs() < 1e-12 && (d.length() - 1.0).abs() < 1e-12);
        }
    }
}
