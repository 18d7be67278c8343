//! Ctrl+C and termination: noted, so that work stops at the next seam and leaves no half file.

use super::CliError;
use std::sync::atomic::{AtomicBool, Ordering};

static IS_INTERRUPTED: AtomicBool = AtomicBool::new(false);

/// Starts to note interruptions instead of dying from them.
pub fn listen() {
    // Without a handler the system's own way of ending stays in force, which leaves no half file either.
    let _ = ctrlc::set_handler(|| IS_INTERRUPTED.store(true, Ordering::Relaxed));
}

/// Whether the user has asked to stop.
pub fn is_interrupted() -> bool {
    IS_INTERRUPTED.load(Ordering::Relaxed)
}

/// An error once the user has asked to stop; for the seams between steps.
pub fn check() -> Result<(), CliError> {
    if is_interrupted() { Err(CliError::Interrupted) } else { Ok(()) }
}
