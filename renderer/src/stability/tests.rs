//! The detectors: each must find what it is for.

use super::*;
use std::collections::HashSet;

#[test]
#[ignore = "prints all numbers of the suite; for those who change limits"]
fn show_the_suite() {
    let cases = suite();
    println!("{} cases", cases.len());
    let start = Instant::now();
    let reports = run(&cases, 2, &|_| true).expect("nobody cancels");
    println!("{:.1} s", start.elapsed().as_secs_f64());
    for r in &reports {
        let n = &r.numbers;
        println!(
            "{} | {:.2}s t{:.1} bad {} {} co {} pdf {:.1e} den {:.3} gain {:.4} loss {:.4} prec {:.1e} br {:.3} | {}",
            if r.holds() { "ok  " } else { "FAIL" },
            r.seconds,
            n.time_ratio,
            n.nonfinite,
            n.negative,
            n.coefficients.len(),
            n.pdf_mismatch.value,
            n.density_excess.value,
            n.gain.value,
            n.loss.as_ref().map_or(0.0, |w| w.value),
            n.precision.value,
            n.brightness.unwrap_or(0.0),
            r.name,
        );
        if !r.holds() {
            println!("     {:?} {}", r.failed, r.worst);
        }
    }
}

#[test]
fn the_suite_has_many_cases_with_names_of_their_own() {
    let cases = suite();
    assert!(cases.len() >= 200, "{}", cases.len());
    let names: HashSet<&str> = cases.iter().map(|case| case.name.as_str()).collect();
    assert_eq!(names.len(), cases.len());
    let again: Vec<String> = suite().into_iter().map(|case| case.name).collect();
    assert!(again.iter().zip(&cases).all(|(a, b)| *a == b.name), "the order is the same in every run");
}
