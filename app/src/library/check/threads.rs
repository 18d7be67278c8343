//! One answer per number, on several threads.

use super::super::scan::Progress;
use burnish_renderer::path::Prepared;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

/// What a thread keeps from one material to the next: pictures of one scene share the tables of its light.
#[derive(Default)]
pub struct Kept {
    /// The scene that was rendered last.
    pub look: Option<Prepared>,
    /// The scene that was probed last.
    pub probe: Option<Prepared>,
}

/// Calls `work` for each number below `count` on `threads` threads and returns the answers in order. `progress` is told after each, from any thread.
/// `None` if it is cancelled, which is asked before each.
pub fn map<T: Send>(
    count: usize,
    threads: usize,
    progress: &(dyn Fn(Progress) + Sync),
    is_cancelled: &(dyn Fn() -> bool + Sync),
    work: impl Fn(&mut Kept, usize) -> T + Sync,
) -> Option<Vec<T>> {
    let (next, done) = (AtomicUsize::new(0), AtomicUsize::new(0));
    let answers: Mutex<Vec<(usize, T)>> = Mutex::new(Vec::with_capacity(count));
    let run = || {
        let mut kept = Kept::default();
        let mut own = Vec::new();
        while let Some(at) = Some(next.fetch_add(1, Ordering::Relaxed)).filter(|at| *at < count && !is_cancelled()) {
            own.push((at, work(&mut kept, at)));
            progress(Progress { done: done.fetch_add(1, Ordering::Relaxed) + 1, total: count });
        }
        answers.lock().unwrap_or_else(PoisonError::into_inner).append(&mut own);
    };
    std::thread::scope(|scope| {
        for _ in 1..threads.clamp(1, count.max(1)) {
            // Where the system has no more threads, this one does all.
            _ = std::thread::Builder::new().name("check".to_owned()).spawn_scoped(scope, run);
        }
        run();
    });
    let mut answers = answers.into_inner().unwrap_or_else(PoisonError::into_inner);
    answers.sort_by_key(|(at, _)| *at);
    (answers.len() == count && !is_cancelled()).then(|| answers.into_iter().map(|(_, answer)| answer).collect())
}
