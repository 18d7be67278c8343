//! Does the stated interval hold the true error, and does rendering stop where it was told to? 20 situations, each at 5 numbers of samples.
//!
//! `cargo bench -p burnish-tests --bench error_coverage -- [SIZE] [even]` prints a table; `even` switches adaptive sampling off. It takes some
//! minutes of two cores at the default of 64 pixels a side.

use burnish_renderer::path::{Prepared, StopReason};
use burnish_tests::coverage::{Reference, SITUATIONS, cases, scene, stopped};
use std::io::{self, Write};

/// Samples per pixel at which the estimate is judged.
const SPPS: [u32; 5] = [16, 32, 64, 128, 256];
/// Samples per pixel of the references: 16 times the most that is judged.
const REFERENCE_SPP: u32 = 4096;
/// Target of the stop rule.
const TARGET: f64 = 0.005;

fn main() -> io::Result<()> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let size = words.iter().find_map(|word| word.parse().ok()).unwrap_or(64);
    let is_adaptive = !words.iter().any(|word| word == "even");
    let mut out = io::stdout().lock();
    writeln!(out, "true relMSE [low, estimate, high], `!` outside, `w` wider than 2; stop at {TARGET}: spp, true relMSE")?;
    let (mut all, mut inside, mut late, mut narrow, mut met) = (0, 0, 0, 0, 0);
    for situation in SITUATIONS {
        let prepared = Prepared::new(&scene(situation), None);
        let reference = Reference::new(&prepared, size, REFERENCE_SPP);
        write!(out, "{} {} {}", situation.0, situation.1, situation.2)?;
        for case in cases(&prepared, &reference, size, 1, &SPPS, is_adaptive) {
            let is_wide = case.spp >= 64 && case.span() > 2.0;
            all += 1;
            inside += u32::from(case.is_inside());
            late += u32::from(case.spp >= 64);
            narrow += u32::from(case.spp >= 64 && !is_wide);
            let [truth, low, relmse, high] =
                [case.truth, case.told.low, case.told.relmse, case.told.high].map(|e| format!("{e:.2e}"));
            let marks = [if case.is_inside() { "" } else { " !" }, if is_wide { " w" } else { "" }].concat();
            let fireflies = if case.told.is_firefly_limited { " f" } else { "" };
            write!(out, "\n  {:4} {truth} [{low}, {relmse}, {high}]{marks}{fireflies}", case.spp)?;
        }
        let (reason, spp, truth) = stopped(&prepared, &reference, size, TARGET, SPPS[4], is_adaptive);
        let is_met = reason == StopReason::Error && (truth / TARGET - 1.0).abs() <= 0.25;
        met += u32::from(is_met);
        writeln!(out, "\n  stop {} at {spp}: {truth:.2e}{}", reason.word(), if is_met { "" } else { " !" })?;
        out.flush()?;
    }
    writeln!(out, "inside {inside} of {all}, narrow {narrow} of {late}, stopped within 25 % {met} of {}", SITUATIONS.len())
}
