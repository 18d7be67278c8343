//! From an edit to the picture that shows it: milliseconds and frames, the last and the worst of late.

use std::collections::VecDeque;
use std::time::Instant;

/// Edits that the worst is taken of.
const KEPT: usize = 100;

/// One edit that has reached the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shown {
    /// Until the device had finished the picture.
    pub ms: f64,
    /// Frames of the window, that of the edit included.
    pub frames: u32,
}

/// Follows edits. While a picture shows an earlier state, further edits belong to the same wait.
#[derive(Debug, Default)]
pub struct Latency {
    waiting: Option<(Instant, u32)>,
    /// Pictures that the device has not finished.
    finishing: u32,
    shown: VecDeque<Shown>,
}

impl Latency {
    /// An edit was made.
    pub fn edited(&mut self) {
        self.waiting.get_or_insert_with(|| (Instant::now(), 0));
    }

    /// A frame of the window was drawn, which shows the newest state or not yet. Returns the edit that it shows.
    pub fn drawn(&mut self, is_current: bool) -> Option<(Instant, u32)> {
        let (_, frames) = self.waiting.as_mut()?;
        *frames += 1;
        if !is_current {
            return None;
        }
        self.finishing += 1;
        self.waiting.take()
    }

    /// Nobody waits any more.
    pub fn forget(&mut self) {
        self.waiting = None;
    }

    /// Whether the device works on a picture that shows an edit.
    pub fn is_finishing(&self) -> bool {
        self.finishing > 0
    }

    /// The device has finished the picture that shows an edit.
    pub fn finished(&mut self, (since, frames): (Instant, u32)) {
        self.finishing = self.finishing.saturating_sub(1);
        self.shown.push_back(Shown { ms: 1e3 * since.elapsed().as_secs_f64(), frames });
        if self.shown.len() > KEPT {
            self.shown.pop_front();
        }
    }

    /// The last edit, and the worst of the last hundred by either measure.
    pub fn last_and_worst(&self) -> Option<(Shown, Shown)> {
        let last = *self.shown.back()?;
        let worst = self.shown.iter().fold(last, |w, s| Shown { ms: w.ms.max(s.ms), frames: w.frames.max(s.frames) });
        Some((last, worst))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edits_that_wait_are_one() {
        let mut latency = Latency::default();
        assert!(latency.drawn(true).is_none(), "nothing was edited");
        latency.edited();
        latency.forget();
        assert!(latency.drawn(true).is_none() && !latency.is_finishing(), "the edit was forgotten");
        latency.edited();
        assert!(latency.drawn(false).is_none());
        latency.edited();
        let (since, frames) = latency.drawn(true).expect("the edit is shown");
        assert_eq!(frames, 2);
        latency.finished((since, frames));
        latency.edited();
        let next = latency.drawn(true).expect("the next one");
        latency.finished(next);
        let (last, worst) = latency.last_and_worst().expect("two were shown");
        assert_eq!((last.frames, worst.frames), (1, 2));
        assert!(worst.ms >= last.ms);
    }
}
