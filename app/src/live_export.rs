//! Pictures and turntables while they are made: one at a time, on a thread of its own, which can be ended at any time; others wait for their turn.

mod making;
mod rows;

pub use rows::{FrameState, Row, begun, due};

use crate::background::Background;
use crate::offline::OfflineError;
use crate::offline::picture::{Order, Rendered, View};
use crate::offline::turntable::{Prediction, TurntableOrder};
use crate::offline::watch::Step;
use egui::Context;
use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Most that wait at once.
pub const MAX_WAITING: usize = 100;

/// What is to be made.
pub enum Task {
    /// One picture, into this file.
    Picture(Order, View, PathBuf),
    /// A picture that was rendered but could not be written, into another file.
    Write(Unwritten, PathBuf),
    /// Some frames of a turntable a little, to tell how long all take.
    Predict(TurntableOrder),
    /// The frames of a turntable that are due.
    Turntable(TurntableOrder),
}

impl Task {
    /// Whether it needs all the threads there are.
    pub fn is_heavy(&self) -> bool {
        matches!(self, Self::Picture(_, View::Final, _) | Self::Predict(_) | Self::Turntable(_))
    }

    /// The file or folder that it writes into.
    pub fn target(&self) -> &Path {
        match self {
            Self::Picture(_, _, path) | Self::Write(_, path) => path,
            Self::Predict(order) | Self::Turntable(order) => &order.out,
        }
    }

    /// What it is about, for a list: `a.png, 1920 × 1080` or `turn, 120 frames, 640 × 480`.
    pub fn text(&self) -> String {
        let name = self.target().file_name().unwrap_or(self.target().as_os_str()).to_string_lossy();
        let size = |order: &Order| format!("{} × {}", order.loaded.width, order.loaded.height);
        match self {
            Self::Picture(order, ..) => format!("{name}, {}", size(order)),
            Self::Write(..) => name.into_owned(),
            Self::Predict(order) | Self::Turntable(order) => {
                format!("{name}, {} frames, {}", order.frames, size(&order.frame))
            }
        }
    }

    /// What the list of work calls it.
    fn title(&self) -> &'static str {
        match self {
            Self::Picture(..) => "Rendering a picture",
            Self::Write(..) => "Writing a picture",
            Self::Predict(_) => "Predicting the turntable",
            Self::Turntable(_) => "Rendering the turntable",
        }
    }
}

/// A picture that was rendered but could not be written: minutes of work that another file can hold.
pub struct Unwritten(Box<(Order, View, Rendered)>);

/// What there is to tell.
pub enum News {
    /// Something is strange; nothing is lost.
    Warning(String),
    /// All frames of the turntable.
    Rows(Vec<Row>),
    /// The frame of this place.
    Row(usize, Row),
    /// The picture was written: its files, the picture first, and what is told of it.
    Wrote(Vec<PathBuf>, String),
    /// The picture is there, but could not be written, and why.
    Unwritten(Unwritten, OfflineError),
    /// How long the frames will take that are due, of which there are so many.
    Predicted(Option<Prediction>, usize),
    /// The turntable ended: frames that are finished, and all.
    Ended(usize, usize),
    /// It was not made.
    Failed(OfflineError),
}

#[derive(Default)]
struct Tray {
    step: Step,
    news: Vec<News>,
}

fn lock(tray: &Mutex<Tray>) -> MutexGuard<'_, Tray> {
    // The tray is whole between two statements, so a panic elsewhere cannot leave it half changed.
    tray.lock().unwrap_or_else(PoisonError::into_inner)
}

/// What is being made.
struct Now {
    title: &'static str,
    /// The file or folder that is written into; `None` where nothing is, as by a prediction.
    target: Option<PathBuf>,
    is_heavy: bool,
    tray: Arc<Mutex<Tray>>,
}

/// What waits for its turn, with scene, material and settings as they were when it was ordered.
pub struct Waiting {
    /// Tells it from all others.
    pub number: u64,
    task: Task,
}

impl Waiting {
    /// What it is about, as [`Task::text`] says it.
    pub fn text(&self) -> String {
        self.task.text()
    }

    /// The file or folder that it writes into.
    pub fn target(&self) -> &Path {
        self.task.target()
    }
}

/// What is being made, if anything is, and what comes after it.
#[derive(Default)]
pub struct LiveExport {
    work: Background<News>,
    now: Option<Now>,
    waiting: VecDeque<Waiting>,
    /// How many have waited so far.
    count: u64,
}

impl LiveExport {
    /// Starts; an error where something is being made already.
    pub fn start(&mut self, task: Task, ctx: &Context) -> Result<(), String> {
        if let Some(now) = &self.now {
            return Err(format!("{}: expected to be over before the next begins", now.title));
        }
        let (title, is_heavy, tray) = (task.title(), task.is_heavy(), Arc::default());
        let target = (!matches!(task, Task::Predict(_))).then(|| task.target().to_path_buf());
        let theirs = Arc::clone(&tray);
        self.work.start(title, ctx, move |control| making::make(task, &theirs, control));
        self.now = Some(Now { title, target, is_heavy, tray });
        Ok(())
    }

    /// Puts a task behind those that wait. An error where it is one too many, or one of them writes to the same place.
    pub fn queue(&mut self, task: Task) -> Result<(), String> {
        let target = task.target();
        if self.waiting.len() >= MAX_WAITING {
            return Err(format!("{}: not queued, because {MAX_WAITING} wait already", target.display()));
        }
        let now = self.now.as_ref().and_then(|now| now.target.as_deref());
        if self.waiting.iter().map(Waiting::target).chain(now).any(|known| known == target) {
            return Err(format!("{}: is being made or waits already; expected another file or folder", target.display()));
        }
        self.count += 1;
        self.waiting.push_back(Waiting { number: self.count, task });
        Ok(())
    }

    /// The first that waits, to be started; `None` where something is being made.
    pub fn take_next(&mut self) -> Option<Task> {
        if self.now.is_some() { None } else { Some(self.waiting.pop_front()?.task) }
    }

    /// What waits, in order.
    pub fn waiting(&self) -> impl ExactSizeIterator<Item = &Waiting> {
        self.waiting.iter()
    }

    /// Gives up one that waits.
    pub fn remove(&mut self, number: u64) {
        self.waiting.retain(|waiting| waiting.number != number);
    }

    /// Gives up all that wait.
    pub fn remove_all(&mut self) {
        self.waiting.clear();
    }

    /// What is being made, and how far it is.
    pub fn now(&self) -> Option<(&'static str, Step)> {
        self.now.as_ref().map(|now| (now.title, lock(&now.tray).step.clone()))
    }

    /// Whether what is being made needs all the threads there are.
    pub fn is_heavy(&self) -> bool {
        self.now.as_ref().is_some_and(|now| now.is_heavy)
    }

    /// Whether it was ended and only has to come to its next seam.
    pub fn is_ending(&self) -> bool {
        self.work.is_ending()
    }

    /// Ends it at its next seam. A turntable can go on later.
    pub fn cancel(&self) {
        self.work.end();
    }

    /// What there is to tell since the last time. Once per frame.
    pub fn collect(&mut self) -> Vec<News> {
        let Some(now) = &self.now else { return Vec::new() };
        // Looked at first: what is told last would be missed otherwise.
        let over = self.work.poll();
        let mut news = std::mem::take(&mut lock(&now.tray).news);
        if let Some(over) = over {
            let fault = format!("{}: ended by a fault of the program", now.title);
            news.push(over.unwrap_or_else(|_| News::Failed(OfflineError::unusable(fault))));
            self.now = None;
        }
        news
    }
}

impl Drop for LiveExport {
    fn drop(&mut self) {
        self.cancel();
        // So that no file is left half written, and the samples of a frame are stored.
        self.work.wait();
    }
}
