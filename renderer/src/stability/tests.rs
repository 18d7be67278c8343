//! The detectors: each must find what it is for.

use super::lobes::{Draw, Scattering, probe_scattering};
use super::picture::brightness;
use super::scenes::Stage;
use super::*;
use burnish_material::{Material, Property, Value};
use std::collections::HashSet;
use std::f64::consts::{FRAC_1_PI, PI};
use std::time::Duration;

#[test]
fn the_suite_has_many_cases_with_names_of_their_own() {
    let cases = suite();
    assert!(cases.len() >= 200, "{}", cases.len());
    let names: HashSet<&str> = cases.iter().map(|case| case.name.as_str()).collect();
    assert_eq!(names.len(), cases.len());
    let again: Vec<String> = suite().into_iter().map(|case| case.name).collect();
    assert!(again.iter().zip(&cases).all(|(a, b)| *a == b.name), "the order is the same in every run");
}

fn material(values: &[(Property, f64)]) -> Material {
    let mut m = Material::named("case");
    for (property, value) in values {
        m.set(*property, Value::Float(*value));
    }
    m
}

fn report(material: Material) -> Report {
    probe(&Stage::new().case("case", material), &mut None, &|| false).expect("nobody cancels")
}

#[test]
fn good_materials_hold() {
    for values in [
        &[][..],
        &[(Property::metallic, 1.0), (Property::roughness, 0.4)],
        &[(Property::translucency, 1.0), (Property::roughness, 0.2)],
        &[(Property::coat, 1.0), (Property::sheen, 0.5)],
    ] {
        let report = report(material(values));
        assert!(report.holds(), "{values:?}: {:?} {}", report.failed, report.worst);
        assert!(!report.worst.is_empty() && report.numbers.time_ratio > 0.0);
    }
}

/// A grey wall whose answers can be spoilt one by one.
struct Wall {
    value: fn([f64; 3]) -> f64,
    density: fn([f64; 3]) -> f64,
    weight: fn([f64; 3]) -> f64,
}

const WALL: Wall = Wall { value: |wi| 0.8 * FRAC_1_PI * wi[2], density: |wi| FRAC_1_PI * wi[2], weight: |_| 0.8 };

impl Scattering for Wall {
    fn sample(&self, u: [f64; 4]) -> Draw {
        let (r, phi) = (u[1].sqrt(), 2.0 * PI * u[2]);
        let wi = [r * phi.cos(), r * phi.sin(), (1.0 - u[1]).max(0.0).sqrt()];
        Draw { wi, weight: [(self.weight)(wi); 3], pdf: (self.density)(wi), is_delta: false, is_valid: wi[2] > 0.0 }
    }

    fn eval(&self, wi: [f64; 3]) -> ([f64; 3], f64) {
        if wi[2] > 0.0 { ([(self.value)(wi); 3], (self.density)(wi)) } else { ([0.0; 3], 0.0) }
    }
}

/// What is found of a wall in single precision beside a sound one in double precision, or beside itself.
fn found(wall: &Wall, exact: &Wall) -> Vec<Check> {
    let mut numbers = Numbers::default();
    probe_scattering(wall, Some(exact), wall, &|| "here".to_owned(), &mut numbers);
    numbers.judge().0
}

#[test]
fn each_fault_of_a_bsdf_is_found() {
    assert_eq!(found(&WALL, &WALL), []);
    let spoilt = |expected: Check, wall: Wall| {
        let found = found(&wall, &wall);
        assert!(found.contains(&expected), "{expected:?}: {found:?}");
    };
    spoilt(Check::NonFinite, Wall { value: |wi| if wi[2] < 0.2 { f64::NAN } else { 0.1 * wi[2] }, ..WALL });
    spoilt(Check::NonFinite, Wall { weight: |wi| if wi[2] < 0.2 { f64::INFINITY } else { 0.8 }, ..WALL });
    spoilt(Check::NonFinite, Wall { density: |wi| 1.0 / (wi[2] - wi[2]), ..WALL });
    spoilt(Check::Negative, Wall { value: |wi| wi[2] - 0.1, ..WALL });
    spoilt(Check::Negative, Wall { weight: |wi| wi[0], ..WALL });
    spoilt(Check::PdfMismatch, Wall { weight: |wi| if wi[2] < 0.3 { 0.81 } else { 0.8 }, ..WALL });
    spoilt(Check::PdfMismatch, Wall { value: |wi| 0.801 * FRAC_1_PI * wi[2], ..WALL });
    spoilt(Check::Density, Wall { density: |wi| 1.2 * FRAC_1_PI * wi[2], ..WALL });
    spoilt(Check::Gain, Wall { weight: |_| 1.02, value: |wi| 1.02 * FRAC_1_PI * wi[2], ..WALL });
    let close = Wall { value: |wi| 0.8 * 1.03 * FRAC_1_PI * wi[2], ..WALL };
    assert_eq!(found(&WALL, &close), [Check::Precision]);
}

#[test]
fn a_loss_of_white_is_found() {
    let mut numbers = Numbers::default();
    super::lobes::probe_loss(&Wall { weight: |_| 1.0, ..WALL }, &|| String::new(), &mut numbers);
    assert_eq!(numbers.judge().0, []);
    super::lobes::probe_loss(&WALL, &|| String::new(), &mut numbers);
    assert_eq!(numbers.judge().0, [Check::Loss]);
}

#[test]
fn coefficients_outside_their_ranges_are_found() {
    use crate::bsdf::{Optics, interpret};
    let m = material(&[(Property::translucency, 1.0)]);
    let sound: Optics<f32> = interpret(&m.inputs().convert(|x| x as f32), burnish_material::LobeSet::of(&m), 1.0);
    let found = |edit: fn(&mut Optics<f32>)| {
        let (mut optics, mut numbers) = (sound, Numbers::default());
        edit(&mut optics);
        super::coefficients::check_optics(&optics, "", &mut numbers);
        numbers.judge().0
    };
    assert_eq!(found(|_| ()), []);
    assert_eq!(found(|o| o.eta = f32::INFINITY), [Check::NonFinite]);
    assert_eq!(found(|o| o.sigma_a.0[1] = f32::NAN), [Check::NonFinite]);
    assert_eq!(found(|o| o.sheen_roughness = 0.0), [Check::Coefficient]);
    assert_eq!(found(|o| o.emission.0[2] = 1e38), [Check::Coefficient]);
    assert_eq!(found(|o| o.transmission_tint.0[0] = 1.5), [Check::Coefficient]);
}

#[test]
fn pictures_brighter_than_white_are_found() {
    // Noise about white is none; a little more than white on all pixels is.
    let noisy = |mean: f32| -> Vec<[f32; 3]> { (0..256).map(|i| [mean + 0.2 * ((i % 7) as f32 - 3.0); 3]).collect() };
    let alpha = vec![1.0; 256];
    assert!(brightness(&noisy(1.0), &alpha) <= BRIGHTNESS_MAX);
    assert!(brightness(&noisy(1.3), &alpha) > BRIGHTNESS_MAX);
    assert_eq!(brightness(&noisy(1.3), &vec![0.0; 256]), 0.0);
    let numbers = Numbers { brightness: Some(0.1), ..Numbers::default() };
    assert_eq!(numbers.judge().0, [Check::Brightness]);
    let numbers = Numbers { darkness: Some(0.95), ..Numbers::default() };
    assert_eq!(numbers.judge().0, [Check::Darkness]);
}

#[test]
fn an_explosion_of_time_is_found() {
    let wait = |time: Duration| {
        let start = Instant::now();
        while start.elapsed() < time {
            std::hint::spin_loop();
        }
        Some(())
    };
    let long = Duration::from_micros(100).mul_f64(3.0 * TIME_RATIO_MAX);
    let ratio = |case: Duration| time_ratio(3, &mut || wait(Duration::from_micros(100)), &mut || wait(case));
    let judged = |ratio: Option<f64>| Numbers { time_ratio: ratio.expect("nobody cancels"), ..Numbers::default() }.judge().0;
    assert_eq!(judged(ratio(Duration::from_micros(500))), []);
    assert_eq!(judged(ratio(long)), [Check::Time]);
    assert_eq!(time_ratio(3, &mut || None, &mut || Some(())), None);
}

#[test]
fn runs_report_progress_and_can_be_cancelled() {
    let stage = Stage::new();
    let cases: Vec<Case> = (0..4).map(|i| stage.case(format!("case {i}"), material(&[]))).collect();
    let done = AtomicUsize::new(0);
    let progress = |p: &Progress| {
        assert!(p.done <= p.total && p.remaining_seconds >= 0.0);
        done.fetch_add(1, Ordering::Relaxed);
    };
    let reports = run(&cases, 2, &progress, &|| false);
    let names: Vec<String> = reports.expect("nobody cancels").into_iter().map(|r| r.name).collect();
    assert_eq!(names, ["case 0", "case 1", "case 2", "case 3"]);
    assert_eq!(done.into_inner(), 4);
    assert_eq!(run(&cases, 2, &|_| (), &|| true), None);
}

#[test]
fn fixes_fix() {
    use Property as P;
    let dense = {
        let mut m = material(&[(P::translucency, 1.0), (P::scatter_distance, 1e-9)]);
        m.set(P::scatter, Value::Bool(true));
        m
    };
    let dark = {
        let mut m = material(&[(P::translucency, 1.0), (P::absorption_distance, 1e-5)]);
        m.set(P::absorption_color, Value::Color([0.5, 0.01, 0.2]));
        m
    };
    for (made, property) in [
        (material(&[(P::roughness, 7.0)]), P::roughness),
        (material(&[(P::coat, f64::NAN)]), P::coat),
        (dense, P::scatter_distance),
        (dark, P::absorption_distance),
        (material(&[(P::anisotropy, 0.8), (P::roughness, 0.0)]), P::roughness),
        (material(&[(P::translucency, 1.0), (P::dispersion, 20.0), (P::specular_ior, 2.5)]), P::dispersion),
        (material(&[(P::emission, 1e38)]), P::emission),
        (material(&[(P::translucency, 1.0), (P::specular_ior, 1.000_1)]), P::specular_ior),
    ] {
        let offered = fixes(&made, None);
        assert!(offered.iter().any(|fix| fix.changes.iter().any(|(p, _)| *p == property)), "{offered:?}");
        let mut fixed = made.clone();
        for fix in &offered {
            assert!(fix.name.starts_with("Set ") && fix.reason.ends_with('.'), "{fix:?}");
            fix.apply(&mut fixed);
        }
        assert_eq!(fixes(&fixed, None), [], "{offered:?}");
        let report = report(fixed);
        assert!(report.holds(), "{offered:?}: {}", report.worst);
    }
    assert_eq!(fixes(&material(&[]), None), []);
}
