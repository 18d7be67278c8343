//! Does everything hold where numbers get hard? The built-in suite says so, as `burnish stability` does.

use burnish_renderer::stability::{run, suite};

#[test]
fn every_case_of_the_built_in_suite_holds() {
    let threads = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    let reports = run(&suite(), threads, &|_| (), &|| false).expect("nobody cancels");
    let failed: Vec<String> = reports.iter().filter(|r| !r.holds()).map(|r| format!("{}: {}", r.name, r.worst)).collect();
    assert!(failed.is_empty(), "{} of {} cases:\n{}", failed.len(), reports.len(), failed.join("\n"));
}
