//! One piece of work on a thread of its own that the window waits for: how far it is, how long yet, and an end before its time.

use crate::work::{Ends, Work};
use egui::Context;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

/// Shares below this are not worth a frame.
const STEP: f32 = 0.004;
/// Share from which the time that is left can be told.
const TELLING: f32 = 0.02;

/// What the thread tells and asks.
pub struct Control {
    share: AtomicU32,
    /// What is being done now; empty where the work has no stages.
    stage: Mutex<String>,
    is_cancelled: AtomicBool,
    since: Instant,
    wake: Context,
}

impl Control {
    /// Of work that begins now.
    pub fn new(ctx: &Context) -> Arc<Self> {
        let (share, stage, is_cancelled) = Default::default();
        Arc::new(Self { share, stage, is_cancelled, since: Instant::now(), wake: ctx.clone() })
    }

    /// This share of the work is done, 0 to 1.
    pub fn tell(&self, share: f32) {
        let before = self.share();
        if share - before >= STEP || share < before {
            self.share.store(share.to_bits(), Ordering::Relaxed);
            self.wake();
        }
    }

    /// So many of all are done.
    pub fn tell_count(&self, done: usize, total: usize) {
        self.tell(done as f32 / total.max(1) as f32);
    }

    /// So many of all of this stage are done.
    pub fn tell_stage(&self, stage: &str, done: usize, total: usize) {
        let mut now = self.stage();
        if *now != stage {
            stage.clone_into(&mut now);
            self.share.store(0, Ordering::Relaxed);
            self.wake();
        }
        drop(now);
        self.tell_count(done, total);
    }

    /// Whether it is to end.
    pub fn is_cancelled(&self) -> bool {
        self.is_cancelled.load(Ordering::Relaxed)
    }

    /// Asks it to end.
    pub fn cancel(&self) {
        self.is_cancelled.store(true, Ordering::Relaxed);
    }

    /// The work for the list of all work.
    pub fn work(&self, name: &str, ends: Ends) -> Work {
        let (share, stage) = (self.share(), self.stage());
        let text = if stage.is_empty() { name.to_owned() } else { format!("{name}: {}", stage.to_lowercase()) };
        let seconds = self.since.elapsed().as_secs_f64();
        // A stage tells nothing of the others.
        let can_tell = share > TELLING && stage.is_empty();
        let remaining = can_tell.then(|| seconds * f64::from((1.0 - share) / share));
        Work { text, progress: Some(share), remaining, ends: Some(ends) }
    }

    fn share(&self) -> f32 {
        f32::from_bits(self.share.load(Ordering::Relaxed))
    }

    fn stage(&self) -> MutexGuard<'_, String> {
        self.stage.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Lets the window draw a frame.
    pub fn wake(&self) {
        self.wake.request_repaint();
    }
}

struct Running<T> {
    name: String,
    control: Arc<Control>,
    receiver: Receiver<T>,
}

/// At most one piece of work, which a newer one takes the place of.
pub struct Background<T> {
    running: Option<Running<T>>,
}

impl<T> Default for Background<T> {
    fn default() -> Self {
        Self { running: None }
    }
}

impl<T> Drop for Background<T> {
    fn drop(&mut self) {
        self.cancel();
    }
}

impl<T> Background<T> {
    /// Whether something is being worked at.
    pub fn is_running(&self) -> bool {
        self.running.is_some()
    }

    /// Gives up what is being worked at; whether that was anything.
    pub fn cancel(&mut self) -> bool {
        let running = self.running.take();
        running.inspect(|running| running.control.cancel()).is_some()
    }

    /// Asks what is being worked at to end at its next seam; what came of it is told as ever.
    pub fn end(&self) {
        if let Some(running) = &self.running {
            running.control.cancel();
        }
    }

    /// Whether it was asked to end and is not there yet.
    pub fn is_ending(&self) -> bool {
        self.running.as_ref().is_some_and(|running| running.control.is_cancelled())
    }

    /// Waits until the work is over, if there is any.
    pub fn wait(&mut self) {
        if let Some(running) = self.running.take() {
            // An error is an end, too.
            let _ = running.receiver.recv();
        }
    }

    /// How far it is.
    pub fn share(&self) -> Option<f32> {
        Some(self.running.as_ref()?.control.share())
    }

    /// The work for the list of all work.
    pub fn work(&self, ends: Ends) -> Option<Work> {
        let running = self.running.as_ref()?;
        Some(running.control.work(&running.name, ends))
    }

    /// What came of it, once; an error in one sentence if the program failed at it. `None` while it goes on, and where there is nothing.
    pub fn poll(&mut self) -> Option<Result<T, String>> {
        let running = self.running.as_ref()?;
        let result = match running.receiver.try_recv() {
            Err(TryRecvError::Empty) => return None,
            Err(TryRecvError::Disconnected) => {
                Err(format!("{}: it came to no end, because the program failed at it.", running.name))
            }
            Ok(done) => Ok(done),
        };
        self.running = None;
        Some(result)
    }
}

impl<T: Send + 'static> Background<T> {
    /// Begins to work; what was being worked at is given up. `name` is for the list of all work.
    pub fn start(&mut self, name: impl Into<String>, ctx: &Context, work: impl FnOnce(&Control) -> T + Send + 'static) {
        self.cancel();
        let (sender, receiver) = channel();
        let control = Control::new(ctx);
        let theirs = control.clone();
        let work = move || {
            // Nobody listens where it was given up.
            _ = sender.send(work(&theirs));
            drop(sender);
            theirs.wake();
        };
        // Without a thread nothing is ever sent, and `poll` says so.
        _ = std::thread::Builder::new().name("background".to_owned()).spawn(work);
        self.running = Some(Running { name: name.into(), control, receiver });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Mutex;
    use std::time::Duration;

    fn wait<T>(work: &mut Background<T>) -> Result<T, String> {
        let start = Instant::now();
        loop {
            assert!(start.elapsed() < Duration::from_secs(60));
            match work.poll() {
                Some(result) => return result,
                None => std::thread::sleep(Duration::from_millis(1)),
            }
        }
    }

    #[test]
    fn work_is_told_of_ended_and_done() {
        let (ctx, gate) = (Context::default(), Arc::new(Mutex::new(())));
        let mut work = Background::default();
        assert!(work.poll().is_none() && work.work(Ends::Check).is_none() && !work.cancel());
        let (held, theirs) = (gate.lock().unwrap(), gate.clone());
        work.start("Sums", &ctx, move |control| {
            control.tell_count(1, 4);
            drop(theirs.lock());
            if control.is_cancelled() { 0 } else { 4 }
        });
        while work.share() != Some(0.25) {
            std::thread::sleep(Duration::from_millis(1));
        }
        let told = work.work(Ends::Check).unwrap();
        assert_eq!((told.text.as_str(), told.progress, told.ends), ("Sums", Some(0.25), Some(Ends::Check)));
        assert!(told.remaining.is_some_and(|seconds| seconds > 0.0) && work.poll().is_none());
        drop(held);
        assert_eq!(wait(&mut work), Ok(4));
        work.start("Nothing", &ctx, |control| {
            while !control.is_cancelled() {
                std::thread::yield_now();
            }
            0
        });
        assert!(work.cancel() && !work.is_running());
        work.start("Asked", &ctx, |control| {
            control.tell_stage("First Part", 1, 2);
            while !control.is_cancelled() {
                std::thread::yield_now();
            }
            control.tell_stage("Second", 1, 1);
            7
        });
        while work.share() != Some(0.5) {
            std::thread::sleep(Duration::from_millis(1));
        }
        let told = work.work(Ends::Check).unwrap();
        assert_eq!((told.text.as_str(), told.remaining), ("Asked: first part", None), "the other stage may be longer");
        assert!(!work.is_ending());
        work.end();
        assert!(work.is_ending() && work.is_running());
        assert_eq!(wait(&mut work), Ok(7), "what came of it is told");
        work.start("Waited for", &ctx, |_| 8);
        work.wait();
        assert!(!work.is_running() && work.poll().is_none());
        work.start("Failing", &ctx, |_| panic!("on purpose"));
        assert!(wait(&mut work).unwrap_err().starts_with("Failing: "));
    }
}
