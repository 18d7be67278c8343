//! One line on standard error that is written over again and again; nothing where that is no terminal.

use std::io::{IsTerminal, Write};
use std::time::Instant;

/// The line.
pub struct ProgressLine {
    is_terminal: bool,
    last: Option<Instant>,
    width: usize,
}

impl ProgressLine {
    /// A line without text.
    pub fn new() -> Self {
        Self { is_terminal: std::io::stderr().is_terminal(), last: None, width: 0 }
    }

    /// Shows a text, at most ten times a second.
    pub fn show(&mut self, text: impl FnOnce() -> String) {
        if !self.is_terminal || self.last.is_some_and(|last| last.elapsed().as_millis() < 100) {
            return;
        }
        self.last = Some(Instant::now());
        self.write(&text());
    }

    /// Takes the text away.
    pub fn clear(&mut self) {
        if self.width > 0 {
            self.write("");
            self.write("");
        }
    }

    fn write(&mut self, text: &str) {
        // A terminal that has gone away must not stop the work.
        let _ = write!(std::io::stderr(), "\r{text:<width$}", width = self.width);
        self.width = text.chars().count();
    }
}

impl Default for ProgressLine {
    fn default() -> Self {
        Self::new()
    }
}
