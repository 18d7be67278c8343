//! Notices that other programs have written files: the material that is open, the textures that it names, the folder of the library.
//!
//! Files are looked at, by time and length, instead of asking the system to tell: notifications do not come from
//! network drives, and are lost when an editor puts a new file in the place of the old one.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant, SystemTime};

/// Time between two looks. A change is reported after the second look that finds it.
pub const INTERVAL: Duration = Duration::from_millis(500);

/// Calls the window's attention to changes.
type Wake = Box<dyn Fn() + Send>;

/// Watches a set of files from a thread of its own, which runs only while there are any.
pub struct Watch {
    shared: Arc<Shared>,
}

struct Shared {
    state: Mutex<State>,
    /// There is something to do before the next look is due: files without a baseline, or nothing any more.
    hurry: Condvar,
    wake: Mutex<Wake>,
    interval: Duration,
}

#[derive(Default)]
struct State {
    files: BTreeMap<PathBuf, Watched>,
    changed: BTreeSet<PathBuf>,
    /// Number for the next baseline.
    next: u64,
    is_hurried: bool,
    is_running: bool,
    is_over: bool,
}

/// When a file or folder was written and how long it is; `None` for a missing one.
type Stamp = Option<Written>;

#[derive(Clone, Copy, PartialEq, Eq)]
struct Written {
    time: Option<SystemTime>,
    length: u64,
    is_folder: bool,
}

struct Watched {
    /// What counts as known; `None` until the next look.
    known: Option<Stamp>,
    last: Stamp,
    /// Tells baselines apart: what a look finds that began before the newest one means nothing.
    baseline: u64,
}

impl Watch {
    /// Watches nothing yet. `wake` is called from another thread whenever [`poll`](Self::poll) has something new.
    pub fn new(wake: Box<dyn Fn() + Send>) -> Self {
        Self::with_interval(wake, INTERVAL)
    }

    fn with_interval(wake: Wake, interval: Duration) -> Self {
        let shared = Shared { state: Mutex::default(), hurry: Condvar::new(), wake: Mutex::new(wake), interval };
        Self { shared: Arc::new(shared) }
    }

    /// Watches these files and no others; what is known about those that were watched before stays known.
    ///
    /// Call it before reading them: what changes while they are read is then reported. Missing files are reported when
    /// they appear. A folder is reported when something in it comes or goes, and when it goes itself.
    pub fn set(&self, paths: impl IntoIterator<Item = PathBuf>) {
        let mut state = self.shared.lock();
        let mut old = std::mem::take(&mut state.files);
        let first = state.next;
        for path in paths {
            let watched = old.remove(&path).unwrap_or_else(|| state.fresh());
            state.files.entry(path).or_insert(watched);
        }
        let State { files, changed, .. } = &mut *state;
        changed.retain(|path| files.contains_key(path));
        if state.next != first || state.files.is_empty() {
            self.shared.hurry(&mut state);
        }
        if state.files.is_empty() || state.is_running {
            return;
        }
        let shared = self.shared.clone();
        // Without a thread nothing is noticed, and the next call tries again.
        state.is_running = thread::Builder::new().name("watch".into()).spawn(move || shared.run()).is_ok();
    }

    /// Files that others have changed since they were last reported, and that were the same at two looks in a row, so
    /// that nothing half-written is reported.
    pub fn poll(&self) -> Vec<PathBuf> {
        std::mem::take(&mut self.shared.lock().changed).into_iter().collect()
    }

    /// What is in this file now is known: for files that the program has just written itself, by the path that
    /// [`set`](Self::set) was told.
    pub fn seen(&self, path: &Path) {
        let mut state = self.shared.lock();
        state.changed.remove(path);
        let fresh = state.fresh();
        if let Some(watched) = state.files.get_mut(path) {
            *watched = fresh;
            self.shared.hurry(&mut state);
        }
    }
}

impl Drop for Watch {
    fn drop(&mut self) {
        let mut state = self.shared.lock();
        state.is_over = true;
        // The thread is not waited for: a network drive that is gone answers after minutes.
        self.shared.hurry(&mut state);
    }
}

impl State {
    fn fresh(&mut self) -> Watched {
        self.next += 1;
        Watched { known: None, last: None, baseline: self.next }
    }

    /// Takes in what a look has found.
    fn take(&mut self, path: PathBuf, baseline: u64, stamp: Stamp) {
        let Some(watched) = self.files.get_mut(&path).filter(|watched| watched.baseline == baseline) else { return };
        let has_settled = watched.last == stamp;
        watched.last = stamp;
        match watched.known {
            None => watched.known = Some(stamp),
            Some(known) if known == stamp => {}
            Some(Some(Written { is_folder: true, .. })) if stamp.is_none() => {
                if has_settled {
                    watched.known = Some(None);
                    self.changed.insert(path);
                }
            }
            // Whatever comes in its place is new, even with the same time and length.
            Some(_) if stamp.is_none() => watched.known = Some(None),
            Some(_) if has_settled => {
                watched.known = Some(stamp);
                self.changed.insert(path);
            }
            Some(_) => {}
        }
    }
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn hurry(&self, state: &mut State) {
        state.is_hurried = true;
        self.hurry.notify_all();
    }

    /// Looks at the files again and again until there are none, or nobody asks any more.
    fn run(&self) {
        let mut due = Instant::now();
        loop {
            let mut state = self.lock();
            state.is_hurried = false;
            if state.is_over || state.files.is_empty() {
                state.is_running = false;
                return;
            }
            // In between only baselines are taken: two looks without time between them would tell nothing.
            let is_due = Instant::now() >= due;
            let asked = state.files.iter().filter(|(_, watched)| is_due || watched.known.is_none());
            let files: Vec<(PathBuf, u64)> = asked.map(|(path, watched)| (path.clone(), watched.baseline)).collect();
            // Not held while the file system is asked: the window must not wait for it.
            drop(state);
            let stamps: Vec<Stamp> = files.iter().map(|(path, _)| stamp(path)).collect();
            if is_due {
                due = Instant::now() + self.interval;
            }

            let mut state = self.lock();
            let before = state.changed.len();
            for ((path, baseline), stamp) in files.into_iter().zip(stamps) {
                state.take(path, baseline, stamp);
            }
            if state.changed.len() > before && !state.is_over {
                drop(state);
                (self.wake.lock().unwrap_or_else(PoisonError::into_inner))();
                state = self.lock();
            }
            let rest = due.saturating_duration_since(Instant::now());
            let waits = self.hurry.wait_timeout_while(state, rest, |state| !state.is_hurried);
            drop(waits.unwrap_or_else(PoisonError::into_inner));
        }
    }
}

fn stamp(path: &Path) -> Stamp {
    let metadata = fs::metadata(path).ok().filter(|metadata| metadata.is_file() || metadata.is_dir())?;
    Some(Written { time: metadata.modified().ok(), length: metadata.len(), is_folder: metadata.is_dir() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicUsize, Ordering};
    use tempfile::TempDir;

    const QUICK: Duration = Duration::from_millis(20);
    const PATIENCE: Duration = Duration::from_secs(20);

    struct Rig {
        folder: TempDir,
        watch: Watch,
        wakes: Arc<AtomicUsize>,
    }

    fn rig() -> Rig {
        let wakes = Arc::new(AtomicUsize::new(0));
        let counted = wakes.clone();
        let wake = Box::new(move || _ = counted.fetch_add(1, Ordering::SeqCst));
        Rig { folder: tempfile::tempdir().unwrap(), watch: Watch::with_interval(wake, QUICK), wakes }
    }

    impl Rig {
        fn file(&self, name: &str, text: &str) -> PathBuf {
            let path = self.folder.path().join(name);
            fs::write(&path, text).unwrap();
            path
        }

        /// Waits until everything that was set has a baseline.
        fn settle(&self) {
            wait(|| self.watch.shared.lock().files.values().all(|watched| watched.known.is_some()));
        }

        /// Waits for the next report.
        fn report(&self) -> Vec<PathBuf> {
            let mut report = Vec::new();
            wait(|| {
                report = self.watch.poll();
                !report.is_empty()
            });
            report
        }

        /// Several looks later nothing was reported.
        fn is_quiet(&self) -> bool {
            thread::sleep(QUICK * 10);
            self.watch.poll().is_empty()
        }
    }

    fn wait(mut is_so: impl FnMut() -> bool) {
        let start = Instant::now();
        while !is_so() {
            assert!(start.elapsed() < PATIENCE, "waited in vain");
            thread::sleep(Duration::from_millis(2));
        }
    }

    #[test]
    fn a_folder_is_reported_when_something_comes_and_when_it_goes() {
        let rig = rig();
        let folder = rig.folder.path().join("library");
        fs::create_dir(&folder).unwrap();
        rig.watch.set([folder.clone()]);
        rig.settle();
        fs::write(folder.join("a"), "1").unwrap();
        assert_eq!(rig.report(), std::slice::from_ref(&folder));
        fs::remove_dir_all(&folder).unwrap();
        assert_eq!(rig.report(), std::slice::from_ref(&folder));
        assert!(rig.is_quiet());
        fs::create_dir(&folder).unwrap();
        assert_eq!(rig.report(), [folder]);
    }

    #[test]
    fn what_others_write_is_reported_once() {
        let rig = rig();
        let (a, b) = (rig.file("a", "1"), rig.file("b", "1"));
        rig.watch.set([a.clone(), b.clone()]);
        rig.settle();
        assert!(rig.is_quiet() && rig.wakes.load(Ordering::SeqCst) == 0);
        rig.file("b", "22");
        assert_eq!(rig.report(), [&*b]);
        assert!(rig.is_quiet());
        // As editors save: a new file takes the name.
        fs::rename(rig.file("new", "333"), &a).unwrap();
        assert_eq!(rig.report(), [&*a]);
        wait(|| rig.wakes.load(Ordering::SeqCst) >= 2);
        rig.watch.set([b]);
        rig.file("a", "4444");
        assert!(rig.is_quiet(), "it is not watched any more");
    }

    #[test]
    fn missing_files_are_reported_when_they_appear() {
        let rig = rig();
        let (never, gone) = (rig.folder.path().join("never"), rig.file("gone", "1"));
        rig.watch.set([never.clone(), gone.clone()]);
        rig.settle();
        let aside = rig.folder.path().join("aside");
        fs::rename(&gone, &aside).unwrap();
        assert!(rig.is_quiet());
        rig.file("never", "");
        assert_eq!(rig.report(), [never]);
        // The same file with the same time and length, but who looked meanwhile found none.
        fs::rename(&aside, &gone).unwrap();
        assert_eq!(rig.report(), [gone]);
    }

    #[test]
    fn own_writing_is_not_reported() {
        let rig = rig();
        let path = rig.file("own", "1");
        rig.watch.set([path.clone()]);
        for length in 2..10 {
            rig.settle();
            rig.file("own", &"x".repeat(length));
            rig.watch.seen(&path);
        }
        assert!(rig.is_quiet());
        rig.file("own", "of others");
        wait(|| !rig.watch.shared.lock().changed.is_empty());
        rig.watch.seen(&path);
        assert!(rig.is_quiet(), "a report that nobody has fetched yet is taken back");
        rig.file("own", "of others again");
        assert_eq!(rig.report(), [path]);
    }

    #[test]
    fn what_is_still_growing_is_not_reported() {
        let mut state = State::default();
        let path = PathBuf::from("growing");
        let fresh = state.fresh();
        let baseline = fresh.baseline;
        state.files.insert(path.clone(), fresh);
        let look = |state: &mut State, length| {
            state.take(path.clone(), baseline, Some(Written { time: None, length, is_folder: false }))
        };
        for length in [1, 2, 3, 4] {
            look(&mut state, length);
            assert!(state.changed.is_empty());
        }
        look(&mut state, 4);
        assert!(state.changed.contains(&path));
        // A look that began before the baseline was renewed.
        state.changed.clear();
        let fresh = state.fresh();
        state.files.insert(path.clone(), fresh);
        look(&mut state, 5);
        assert!(state.files[&path].known.is_none());
    }

    #[test]
    fn setting_again_and_again_does_not_make_looks_come_early() {
        let rig = rig();
        let (path, other) = (rig.file("slow", ""), rig.file("other", ""));
        rig.watch.set([path.clone()]);
        rig.settle();
        // It grows between any two looks, however often the set changes.
        let start = Instant::now();
        let mut text = String::new();
        let mut written = Instant::now();
        while start.elapsed() < QUICK * 20 {
            let writing = Instant::now();
            text.push('x');
            rig.file("slow", &text);
            for _ in 0..3 {
                rig.watch.set([path.clone()]);
                rig.watch.set([path.clone(), other.clone()]);
                thread::sleep(Duration::from_millis(1));
            }
            let is_reported = !rig.watch.poll().is_empty();
            // A machine that stops for so long between two writings tells nothing.
            assert!(!is_reported || written.elapsed() >= QUICK, "after {} writings", text.len());
            written = writing;
        }
    }

    #[test]
    fn there_is_a_thread_only_while_there_are_files() {
        let rig = rig();
        let threads = || Arc::strong_count(&rig.watch.shared) - 1;
        rig.watch.set([]);
        assert_eq!(threads(), 0);
        for _ in 0..3 {
            rig.watch.set([rig.folder.path().join("a")]);
            assert_eq!(threads(), 1);
            rig.settle();
            rig.watch.set([]);
            wait(|| threads() == 0);
        }
        rig.watch.set([rig.folder.path().join("a")]);
        let shared = Arc::downgrade(&rig.watch.shared);
        drop(rig);
        wait(|| shared.strong_count() == 0);
    }
}
