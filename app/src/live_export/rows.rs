//! Frames of a turntable, as lists show them.

use crate::offline::turntable::{Begun, Frame};
use burnish_renderer::path::StopRules;
use std::path::Path;

/// How far a frame of a turntable is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FrameState {
    /// Not yet.
    #[default]
    Waiting,
    /// Being rendered.
    Working,
    /// Finished.
    Done,
    /// Its time was up before its error was reached.
    Limited,
}

/// A frame of a turntable, as the list shows it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Row {
    /// Name of its file.
    pub name: String,
    /// How far it is.
    pub state: FrameState,
    /// Error that it reached.
    pub relmse: Option<f64>,
    /// Seconds of rendering so far.
    pub seconds: f64,
    /// What is known of it, but for its curve.
    frame: Option<Frame>,
}

impl Row {
    /// Whether it is to be rendered, or further, by these rules.
    pub fn is_due(&self, rules: &StopRules) -> bool {
        self.frame.as_ref().is_none_or(|frame| !frame.meets(rules))
    }

    pub(super) fn new(name: String, frame: Option<&Frame>) -> Self {
        let Some(frame) = frame else { return Self { name, ..Self::default() } };
        let state = if frame.is_time_limited() { FrameState::Limited } else { FrameState::Done };
        Self { name, state, relmse: frame.relmse_estimate, seconds: frame.seconds, frame: Some(frame.without_curve()) }
    }
}

/// How many of these frames are due by these rules: those that hit their time limit, and the others.
pub fn due(rows: &[Row], rules: &StopRules) -> (usize, usize) {
    let due: Vec<&Row> = rows.iter().filter(|row| row.is_due(rules)).collect();
    let limited = due.iter().filter(|row| row.state == FrameState::Limited).count();
    (limited, due.len() - limited)
}

/// The turntable that was begun in a folder, and its frames; `None` where it has none that can be read.
pub fn begun(folder: &Path) -> Option<(Begun, Vec<Row>)> {
    let begun = Begun::of(folder)?;
    let rows = begun.rows.iter().map(|(name, frame)| Row::new(name.clone(), frame.as_ref())).collect();
    Some((begun, rows))
}
