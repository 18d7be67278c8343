//! Numbers that the model reference states for its formulas.

#![allow(clippy::needless_range_loop, reason = "a channel indexes several arrays at once")]

use burnish_material::{Lobe, LobeSet, Material, Property, Value};
use burnish_renderer::bsdf::albedos::Quantity;
use burnish_renderer::bsdf::coat::coat_exponent;
use burnish_renderer::bsdf::dispersion::{LAMBDA_D, dispersed_ior, spectrum};
use burnish_renderer::bsdf::fresnel::{f0_from_ior, f82_average, f82_coefficient, f82_tint, fresnel, ior_from_f0, level_to_ior};
use burnish_renderer::bsdf::ggx::alphas;
use burnish_renderer::bsdf::tables::sheen_albedo;
use burnish_renderer::bsdf::{View, interpret};
use burnish_renderer::vector::Rgb;
use burnish_tests::materials::{c, f, material};
use burnish_tests::number::unit;
use burnish_tests::quadrature::direction;
use burnish_tests::surface::Surface;

fn close(what: &str, found: f64, expected: f64, tolerance: f64) {
    assert!((found - expected).abs() <= tolerance, "{what}: found {found}, expected {expected}");
}

#[test]
fn roughness_and_anisotropy_to_alpha() {
    let cases = [
        (0.0, 0.5, 0.0625, 1e-4), // alpha_y 0 is raised to the smallest that is evaluated
        (0.0, 1.0, 1.0, 1e-4),
        (0.3, 0.5, 0.1525, 0.09),
        (0.3, 0.8, 0.4996, 0.09),
        (0.3, 1.0, 1.0, 0.09),
        (1.0, 0.5, 1.0, 1.0),
    ];
    for (roughness, anisotropy, x, y) in cases {
        let (alpha_x, alpha_y, is_smooth) = alphas::<f64>(roughness, anisotropy);
        close("alpha_x", alpha_x, x, 1e-9);
        close("alpha_y", alpha_y, y, 1e-9);
        assert!(!is_smooth, "only both below the smallest alpha make a mirror");
    }
    assert!(alphas::<f64>(0.0, 0.0).2);
    assert!(alphas::<f64>(0.0099, 0.0).2 && !alphas::<f64>(0.0101, 0.0).2);
}

#[test]
fn specular_level_to_index() {
    for (ior, expected) in [(1.5, [1.0, 1.3294, 1.5, 1.6488, 1.7888]), (3.0, [1.0, 2.0938, 3.0, 4.1596, 5.8284])] {
        for (level, expected) in [0.0, 0.25, 0.5, 0.75, 1.0].into_iter().zip(expected) {
            close(&format!("IOR {ior} at level {level}"), level_to_ior::<f64>(ior, level), expected, 5e-5);
        }
    }
    assert_eq!(level_to_ior::<f32>(1.5, 0.0), 1.0, "level 0 matches the index exactly");
}

#[test]
fn dielectric_fresnel() {
    assert_eq!(fresnel::<f32>(0.0, 1.0), 0.0, "matched media reflect nothing, even at grazing");
    assert_eq!(fresnel::<f32>(0.3, 1.0 / 1.5), 1.0, "total reflection");
    close("normal incidence", fresnel::<f64>(1.0, 1.5), 0.04, 1e-12);
    // Textbook form in double precision, for many angles and ratios.
    for i in 0..=200 {
        let c: f64 = f64::from(i) / 200.0;
        for eta in [1.0001, 1.01, 1.33, 1.5, 3.0, 0.5, 0.99] {
            let s2 = (1.0 - c * c) / (eta * eta);
            let expected = if s2 >= 1.0 {
                1.0
            } else {
                let t = (1.0 - s2).sqrt();
                let (s, p) = ((c - eta * t) / (c + eta * t), (eta * c - t) / (eta * c + t));
                0.5 * (s * s + p * p)
            };
            close(&format!("c {c}, eta {eta}"), fresnel(c, eta), expected, 1e-9);
            let single = f64::from(fresnel::<f32>(c as f32, eta as f32));
            assert!(
                (single - fresnel(f64::from(c as f32), f64::from(eta as f32))).abs() <= 2e-5 * single + 1e-12,
                "f32, c {c}, eta {eta}"
            );
        }
    }
}

/// A material's tables at the direction of cosine `mu` and azimuth `phi`, and their mean.
fn tabulated(values: &[(Property, Value)], quantity: Quantity, mu: f64, phi: f64) -> (f64, f64) {
    let surface = Surface::<f64>::new(&material(values));
    let (grid, o) = (&surface.albedos.base, &surface.optics);
    let place = grid.place([o.roughness, o.anisotropy, o.level.sqrt(), o.coat, 0.0]);
    (grid.at(quantity, &place, &grid.slant(direction::<f64>(mu, phi))), grid.mean(quantity, &place))
}

#[test]
fn average_fresnel_of_a_smooth_dielectric() {
    for (ior, expected) in [(1.5, 0.09178), (1.6, 0.10625), (2.0, 0.16060), (3.0, 0.27620)] {
        let values = [(Property::specular_ior, f(ior)), (Property::roughness, f(0.0))];
        let (_, mean) = tabulated(&values, Quantity::DielectricMiss, 1.0, 0.0);
        close(&format!("IOR {ior}"), 1.0 - mean, expected, 6e-4);
    }
}

#[test]
fn white_conductor_albedo() {
    let metal = |alpha: f64| [(Property::metallic, f(1.0)), (Property::roughness, f(alpha.sqrt()))];
    for (alpha, expected) in [(1.0, 0.409), (0.64, 0.604), (0.36, 0.803), (0.16, 0.940), (0.04, 0.995)] {
        // The reference rounds the last of these by almost a thousandth.
        let tolerance = if alpha < 0.1 { 1e-3 } else { 6e-4 };
        let (_, mean) = tabulated(&metal(alpha), Quantity::MetalMiss, 1.0, 0.0);
        close(&format!("alpha {alpha}"), 1.0 - mean, expected, tolerance);
    }
    close("alpha 1, normal", 1.0 - tabulated(&metal(1.0), Quantity::MetalMiss, 1.0, 0.0).0, 0.307, 6e-4);
    close("alpha 1, cosine 0.5", 1.0 - tabulated(&metal(1.0), Quantity::MetalMiss, 0.5, 0.0).0, 0.451, 6e-4);
}

/// The reference says what isotropic tables would make of stretched materials; ours make 1 of them, so the difference of the two tables
/// is what is missing there.
#[test]
fn stretched_albedos_are_their_own() {
    let rows = [(0.0, 0.5, 0.9997), (0.0, 1.0, 0.982), (1.0, 0.5, 0.990), (1.0, 0.7, 0.926), (1.0, 1.0, 0.539)];
    for (metal, stretch, expected) in rows {
        let quantity = if metal > 0.0 { Quantity::MetalMiss } else { Quantity::DielectricMiss };
        let values = [
            (Property::metallic, f(metal)),
            (Property::roughness, f(0.3)),
            (Property::base_color, c(1.0, 1.0, 1.0)),
            (Property::anisotropy, f(stretch)),
        ];
        let (lost, _) = tabulated(&values, quantity, 1.0, 0.0);
        let (lost_round, _) = tabulated(&values[..3], quantity, 1.0, 0.0);
        close(&format!("metal {metal}, anisotropy {stretch}"), 1.0 - lost + lost_round, expected, 1.5e-3);
        let surface = Surface::<f64>::new(&material(&values));
        for (mu, phi) in [(1.0, 0.0), (0.5, 0.1), (0.5, 1.5), (0.1, 0.8)] {
            let bsdf = surface.bsdf(&View::new(direction(mu, phi)));
            let n = 32768;
            let sum: f64 =
                (0..n).map(|i| bsdf.sample([0, 1, 2, 3].map(|d| unit(i, d)))).filter(|s| s.is_valid).map(|s| s.weight.0[0]).sum();
            close(
                &format!("furnace, metal {metal}, anisotropy {stretch}, cosine {mu}, azimuth {phi}"),
                sum / n as f64,
                1.0,
                3e-3,
            );
        }
    }
}

#[test]
fn stretch_is_that_of_gltf() {
    for roughness in [0.0, 0.3, 0.7] {
        for strength in [0.1, 0.5, 1.0] {
            let square = (1.0 - roughness * roughness) * strength * strength;
            let anisotropy = f64::sqrt(f64::sqrt(square));
            let (x, y, _) = alphas::<f64>(roughness, anisotropy);
            let along = roughness * roughness + (1.0 - roughness * roughness) * strength * strength;
            close("along the stretch", x, along.max(1e-4), 1e-12);
            close("across", y, (roughness * roughness).max(1e-4), 1e-12);
            close("and back", anisotropy * anisotropy / f64::sqrt(1.0 - roughness * roughness), strength, 1e-12);
        }
    }
}

#[test]
fn index_by_wavelength() {
    let rows = [
        (1.5, 1.0, [(700.0, 1.4888), (400.0, 1.5439)]),
        (1.5, 20.0, [(700.0, 1.2761), (400.0, 2.3778)]),
        (3.0, 20.0, [(700.0, 2.10), (400.0, 6.51)]),
    ];
    for (n_d, dispersion, expected) in rows {
        close("at the sodium line", dispersed_ior(n_d, dispersion, LAMBDA_D.powi(-2)), n_d, 2e-5 * dispersion);
        for (nm, expected) in expected {
            let tolerance = if n_d > 2.0 { 6e-3 } else { 6e-5 };
            let found = dispersed_ior::<f64>(n_d, dispersion, f64::powi(nm, -2));
            close(&format!("{n_d}, dispersion {dispersion}, {nm} nm"), found, expected, tolerance);
            let thin = dispersed_ior::<f64>(1.0 / n_d, dispersion, f64::powi(nm, -2));
            close("the reciprocal", thin, 1.0 / found, 1e-12);
        }
    }
    for nm in [380.0, 780.0] {
        assert!(dispersed_ior::<f64>(1.5, 20.0, f64::powi(nm, -2)) > 1.0);
        assert_eq!(dispersed_ior::<f64>(1.5, 40.0, f64::powi(780.0, -2)), 1.0, "never below the surroundings");
    }
}

/// Wavelengths average to white, and to the same indices as the channels.
#[test]
fn wavelengths_sum_to_white() {
    let n = 100_000;
    let mut sum = [0.0; 3];
    let mut squares = [0.0; 3];
    for i in 0..n {
        let nm = spectrum().wavelength((f64::from(i) + 0.5) / f64::from(n));
        let weights = spectrum().weights(nm);
        close("weights sum to 3", weights.iter().map(|w| f64::from(*w)).sum(), 3.0, 1e-5);
        for c in 0..3 {
            sum[c] += f64::from(weights[c]) / f64::from(n);
            squares[c] += f64::from(weights[c]) / f64::from(n) / nm.powi(2);
        }
    }
    for c in 0..3 {
        close("white", sum[c], 1.0, 1e-5);
        close("mean of 1/nm^2", squares[c] / spectrum().inverse_square[c], 1.0, 1e-5);
    }
}

/// `sigma_t`, `sigma_s` and `sigma_a` of a scattering colour.
fn medium(color: [f64; 3], rayleigh: f64, red_shift: f64, distance: f64) -> [[f64; 3]; 3] {
    let mut inputs = Material::default().inputs();
    inputs.scatter = true;
    inputs.scatter_color = color;
    inputs.scatter_distance = distance;
    inputs.scatter_rayleigh = rayleigh;
    inputs.scatter_red_shift = red_shift;
    let o = interpret(&inputs, LobeSet::EMPTY.with(Lobe::scattering), 1.0);
    [[0, 1, 2].map(|c| o.sigma_s.0[c] + o.sigma_a.0[c]), o.sigma_s.0, o.sigma_a.0]
}

#[test]
fn scattering_coefficients() {
    let near = |what: &str, found: [f64; 3], expected: [f64; 3], tolerance: f64| {
        for c in 0..3 {
            close(&format!("{what}, channel {c}"), found[c], expected[c], tolerance * expected[c].max(1.0));
        }
    };
    let [t, s, a] = medium([0.8, 0.5, 0.2], 0.0, 0.0, 1.0);
    near("sigma_t", t, [1.0, 1.08652, 1.61504], 6e-6);
    near("sigma_s", s, [0.990588; 3], 6e-7);
    near("sigma_a", a, [0.009412, 0.095933, 0.624448], 6e-7);
    near("albedo", [0, 1, 2].map(|c| s[c] / t[c]), [0.990588, 0.911707, 0.613353], 6e-7);
    let [t, s, _] = medium([0.8, 0.5, 0.2], 0.3, 0.5, 1.0);
    near("sigma_t with Rayleigh and red shift", t, [0.26944, 1.08652, 2.05065], 6e-6);
    near("the albedo stays", [0, 1, 2].map(|c| s[c] / t[c]), [0.990588, 0.911707, 0.613353], 6e-7);
    let [t, s, a] = medium([1.0, 0.0, 0.5], 0.0, 0.0, 1.0);
    near("sigma_t with the floor at work", t, [1.0, 1000.0, 1.09684], 6e-6);
    assert_eq!((a[0], s[1]), (0.0, 0.0), "white loses nothing, black scatters nothing");
    let [t, s, _] = medium([0.0; 3], 0.0, 0.0, 0.25);
    assert_eq!((t, s), ([4.0; 3], [0.0; 3]), "a pure absorber");
    let [t, ..] = medium([1.0; 3], 0.0, 0.0, 0.0);
    near("no distance", t, [1e6; 3], 1e-9);
    // Factors of the fourth power of frequency, clamped so that all stay positive.
    near("Rayleigh 1", medium([1.0; 3], 1.0, 0.0, 1.0)[0], [0.50682, 1.0, 1.89908], 6e-6);
    near("Rayleigh 5", medium([1.0; 3], 5.0, 0.0, 1.0)[0], [0.0136, 1.0, 2.79816], 5e-5);
    near("Rayleigh -5", medium([1.0; 3], -5.0, 0.0, 1.0)[0], [1.49318, 1.0, 0.10092], 5e-5);
    near("red shift 1", medium([1.0; 3], 0.0, 1.0, 1.0)[0], [0.1, 1.0, 1.0], 1e-9);
}

#[test]
fn absorption_coefficients() {
    let absorb = |color: [f64; 3], distance: f64| {
        let mut inputs = Material::default().inputs();
        (inputs.absorption_color, inputs.absorption_distance) = (color, distance);
        interpret(&inputs, LobeSet::EMPTY.with(Lobe::absorption), 1.0)
    };
    let o = absorb([1.0, 0.5, 0.0], 2.0);
    for (found, expected) in o.sigma_a.0.into_iter().zip([0.0, 0.5 * 2f64.ln(), 0.5 * 1000f64.ln()]) {
        close("by distance", found, expected, 1e-12);
    }
    assert_eq!((o.sigma_a.0[0], o.transmission_tint.0), (0.0, [1.0; 3]));
    let o = absorb([1.0, 0.25, 0.0], 0.0);
    assert_eq!((o.sigma_a.0, o.transmission_tint.0), ([0.0; 3], [1.0, 0.5, 0.0]), "by crossing");
}

#[test]
fn f82_tint_of_gold() {
    let r = Rgb([1.0, 0.7099, 0.3148]);
    let b = r.zip(Rgb([0.9408, 0.9636, 0.9099]), f82_coefficient::<f64>);
    let rows = [
        (0.5, [0.99184, 0.71473, 0.32836]),
        (1.0 / 7.0, [0.94080, 0.81339, 0.57489]),
        (0.05, [0.96159, 0.91444, 0.80806]),
        (1.0, [1.0, 0.7099, 0.3148]),
        (0.0, [1.0, 1.0, 1.0]),
    ];
    for (mu, expected) in rows {
        for c in 0..3 {
            close(&format!("mu {mu}, channel {c}"), f82_tint(mu, r, b).0[c], expected[c], 1e-5);
        }
    }
    for (found, expected) in f82_average(r, b).0.into_iter().zip([0.99171, 0.71941, 0.33945]) {
        close("average", found, expected, 1e-5);
    }
    // At cosine 1/7 the tint is what the Schlick curve is multiplied with.
    for (t, r) in [(0.2, 0.9), (0.9, 0.5), (1.0, 0.1)] {
        let schlick = r + (1.0 - r) * f64::powi(6.0 / 7.0, 5);
        let found = f82_tint(1.0 / 7.0, Rgb::grey(r), Rgb::grey(f82_coefficient(r, t)));
        close("tint at 82 degrees", found.0[0], t * schlick, 1e-9);
    }
    // Where the curve is clamped the average is too low, but never negative.
    close("dark edge", f82_average(Rgb::grey(0.04), Rgb::grey(f82_coefficient(0.04, 0.0))).0[0], 0.0179, 5e-5);
    assert_eq!(f82_average(Rgb::grey(0.0), Rgb::grey(f82_coefficient(0.0, 0.0))).0[0], 0.0);
}

#[test]
fn f82_tint_never_leaves_its_range() {
    for i in 0..=100 {
        let mu = f64::from(i) / 100.0;
        for r in [0.0, 0.04, 0.5, 1.0] {
            for t in [0.0, 0.5, 1.0] {
                let b = Rgb::grey(f82_coefficient(r, t));
                let f = f82_tint(mu, Rgb::grey(r), b).0[0];
                assert!((0.0..=1.0).contains(&f), "mu {mu}, r {r}, t {t}: {f}");
            }
        }
    }
}

#[test]
fn sheen_albedo_of_the_tables() {
    let rows = [
        (0.5, [0.7329, 0.4170, 0.2331, 0.1415, 0.0916, 0.0633]),
        (1.0, [0.8478, 0.6409, 0.4911, 0.3963, 0.3312, 0.2842]),
        (0.25, [0.5716, 0.2004, 0.0698, 0.0305, 0.0159, 0.0098]),
        (0.1, [0.3128, 0.0392, 0.0073, 0.0025, 0.0011, 0.0007]),
    ];
    for (r, expected) in rows {
        for (mu, expected) in [0.05, 0.2, 0.4, 0.6, 0.8, 1.0].into_iter().zip(expected) {
            close(&format!("sheen roughness {r}, cosine {mu}"), sheen_albedo::<f64>(r, mu), expected, 2.5e-3);
        }
    }
}

#[test]
fn coat_exponents_and_the_layer_below() {
    for (mu, expected) in [(1.0, 0.4075), (0.5, 0.6163), (0.0, 0.90625)] {
        close(&format!("exponent at {mu}"), coat_exponent::<f64>(mu), expected, 5e-5);
    }
    let n = 10_000;
    let mean: f64 = (0..n).map(|i| coat_exponent(f64::sqrt((f64::from(i) + 0.5) / f64::from(n)))).sum();
    close("mean exponent", mean / f64::from(n), 0.546, 5e-4);
    // Half a coat: reflectances are blended, not indices.
    let coated = |amount: f64, ior: f64| {
        let m = material(&[(Property::coat, f(amount)), (Property::specular_ior, f(ior))]);
        interpret::<f64>(&m.inputs(), LobeSet::of(&m), 1.0)
    };
    close("1.5 under half a coat of 1.6", f0_from_ior(coated(0.5, 1.5).eta_specular), 0.0205, 5e-5);
    close("refraction does not see it", coated(1.0, 1.5).eta, 1.5, 1e-12);
    assert_eq!(coated(1.0, 1.6).eta_specular, 1.0, "a coat of the same index hides the reflection");
    assert!(coated(1.0, 1.2).eta_specular > 1.0, "no total reflection from a denser coat");
    close("1.5 under a coat of 1.6", f0_from_ior(1.5f64 / 1.6), 0.00104, 5e-6);
    close("index of that", f0_from_ior(ior_from_f0(0.00104f64)), 0.00104, 1e-12);
}
