//! Ctrl+C and termination: noted, so that work stops at the next seam and leaves no half file. The second one does not
//! wait for a seam.

use super::CliError;
use std::sync::atomic::{AtomicBool, Ordering};

static IS_INTERRUPTED: AtomicBool = AtomicBool::new(false);

/// Starts to note interruptions instead of dying from them.
pub fn listen() {
    // Without a handler the system's own way of ending stays in force, which leaves no half file either.
    let _ = ctrlc::set_handler(|| {
        if IS_INTERRUPTED.swap(true, Ordering::Relaxed) {
            // Results get their names only once they are whole, so at worst a file with a temporary name stays.
            std::process::exit(130);
        }
    });
}

/// Whether the user has asked to stop.
pub fn is_interrupted() -> bool {
    IS_INTERRUPTED.load(Ordering::Relaxed)
}

/// An error once the user has asked to stop; for the seams between steps.
pub fn check() -> Result<(), CliError> {
    if is_interrupted() { Err(CliError::Interrupted) } else { Ok(()) }
}
