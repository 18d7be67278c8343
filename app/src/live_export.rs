//! Pictures and turntables while they are made: one at a time, on a thread of its own, which can be ended at any time.

use crate::export::{ExportError, Picture};
use crate::files::check_writable;
use crate::offline::OfflineError;
use crate::offline::picture::{self, Order, Rendered, View};
use crate::offline::turntable::{Begun, Existing, Frame, PROBES, Prediction, Turntable, TurntableOrder};
use crate::offline::watch::{Step, Watch, error_text};
use burnish_renderer::path::StopRules;
use egui::Context;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;

/// What is to be made.
pub enum Task {
    /// One picture, into this file.
    Picture(Order, View, PathBuf),
    /// A picture that was rendered but could not be written, into another file.
    Write(Unwritten, PathBuf),
    /// Some frames of a turntable a little, to tell how long all take.
    Predict(TurntableOrder),
    /// To see whether a folder has a turntable that was begun before.
    Look(PathBuf),
    /// The frames of a turntable that are due.
    Turntable(TurntableOrder),
}

impl Task {
    /// Whether it needs all the threads there are.
    pub fn is_heavy(&self) -> bool {
        matches!(self, Self::Picture(_, View::Final, _) | Self::Predict(_) | Self::Turntable(_))
    }

    /// What the list of work calls it.
    fn title(&self) -> &'static str {
        match self {
            Self::Picture(..) => "Rendering a picture",
            Self::Write(..) => "Writing a picture",
            Self::Predict(_) => "Predicting the turntable",
            Self::Look(_) => "Looking into the folder",
            Self::Turntable(_) => "Rendering the turntable",
        }
    }
}

/// A picture that was rendered but could not be written: minutes of work that another file can hold.
pub struct Unwritten(Box<(Order, View, Rendered)>);

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

    fn new(name: String, frame: Option<&Frame>) -> Self {
        let Some(frame) = frame else { return Self { name, ..Self::default() } };
        let state = if frame.is_time_limited() { FrameState::Limited } else { FrameState::Done };
        Self { name, state, relmse: frame.relmse_estimate, seconds: frame.seconds, frame: Some(frame.without_curve()) }
    }
}

/// What there is to tell.
pub enum News {
    /// Something is strange; nothing is lost.
    Warning(String),
    /// All frames of the turntable.
    Rows(Vec<Row>),
    /// The frame of this place.
    Row(usize, Row),
    /// The folder has a turntable that was begun before, with these frames, or none.
    Begun(Option<Box<Begun>>, Vec<Row>),
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

/// What a thread and the window share.
#[derive(Default)]
struct Shared {
    is_cancelled: AtomicBool,
    tray: Mutex<Tray>,
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, Tray> {
        // The tray is whole between two statements, so a panic elsewhere cannot leave it half changed.
        self.tray.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

struct Running {
    title: &'static str,
    shared: Arc<Shared>,
    thread: JoinHandle<()>,
}

/// What is being made, if anything is.
#[derive(Default)]
pub struct LiveExport {
    running: Option<Running>,
}

impl LiveExport {
    /// Starts; an error where something is being made already, or no thread can be had.
    pub fn start(&mut self, task: Task, ctx: &Context) -> Result<(), String> {
        if let Some(running) = &self.running {
            return Err(format!("{}: expected to be over before the next begins", running.title));
        }
        let (title, shared) = (task.title(), Arc::<Shared>::default());
        let (theirs, ctx) = (shared.clone(), ctx.clone());
        let thread = std::thread::Builder::new().name("export".to_owned()).spawn(move || work(task, &theirs, &ctx));
        let thread = thread.map_err(|error| format!("{title}: no thread can be had: {error}"))?;
        self.running = Some(Running { title, shared, thread });
        Ok(())
    }

    /// What is being made, and how far it is.
    pub fn now(&self) -> Option<(&'static str, Step)> {
        self.running.as_ref().map(|running| (running.title, running.shared.lock().step.clone()))
    }

    /// Whether it was ended and only has to come to its next seam.
    pub fn is_ending(&self) -> bool {
        self.running.as_ref().is_some_and(|running| running.shared.is_cancelled.load(Ordering::Relaxed))
    }

    /// Ends it at its next seam. A turntable can go on later.
    pub fn cancel(&self) {
        if let Some(running) = &self.running {
            running.shared.is_cancelled.store(true, Ordering::Relaxed);
        }
    }

    /// What there is to tell since the last time. Once per frame.
    pub fn collect(&mut self) -> Vec<News> {
        let Some(running) = &self.running else { return Vec::new() };
        // Looked at first: what is told last would be missed otherwise.
        let is_over = running.thread.is_finished();
        let mut news = std::mem::take(&mut running.shared.lock().news);
        // A thread that has told everything ends at once.
        let is_told = news.iter().any(|news| !matches!(news, News::Warning(_) | News::Rows(_) | News::Row(..)));
        if (is_over || is_told)
            && let Some(running) = self.running.take()
        {
            let title = running.title;
            if running.thread.join().is_err() {
                news.push(News::Failed(OfflineError::unusable(format!("{title}: ended by a fault of the program"))));
            }
        }
        news
    }
}

impl Drop for LiveExport {
    fn drop(&mut self) {
        self.cancel();
        if let Some(running) = self.running.take() {
            // So that no file is left half written, and the samples of a frame are stored.
            let _ = running.thread.join();
        }
    }
}

fn work(task: Task, shared: &Shared, ctx: &Context) {
    let say = |news| {
        shared.lock().news.push(news);
        ctx.request_repaint();
    };
    let mut watch = Watch {
        is_cancelled: &|| shared.is_cancelled.load(Ordering::Relaxed),
        warn: &mut |sentence| say(News::Warning(sentence)),
        tell: &mut |step| {
            shared.lock().step = step.clone();
            ctx.request_repaint();
        },
    };
    let made = match task {
        Task::Picture(order, view, out) => check_writable(&out)
            .map_err(|error| OfflineError::Export(ExportError::Write(error)))
            .and_then(|()| picture::render(&order, view, None, &mut watch))
            .map(|rendered| write(Unwritten(Box::new((order, view, rendered))), &out, &mut watch)),
        Task::Write(unwritten, out) => Ok(write(unwritten, &out, &mut watch)),
        Task::Predict(order) => turntable(&order, true, &say, &mut watch),
        Task::Look(folder) => {
            let begun = Begun::of(&folder).map(Box::new);
            let rows = begun.iter().flat_map(|begun| &begun.rows).map(|(name, frame)| Row::new(name.clone(), frame.as_ref()));
            let rows = rows.collect();
            Ok(News::Begun(begun, rows))
        }
        Task::Turntable(order) => turntable(&order, false, &say, &mut watch),
    };
    say(made.unwrap_or_else(News::Failed));
}

fn write(mut unwritten: Unwritten, out: &Path, watch: &mut Watch<'_>) -> News {
    let (order, view, rendered) = &mut *unwritten.0;
    let files = match picture::write(order, *view, out, None, rendered, watch) {
        Ok(files) => files,
        Err(error) => return News::Unwritten(unwritten, error),
    };
    let Picture { width, height, .. } = rendered.picture;
    let error = rendered.error.as_ref().map_or_else(String::new, |error| format!(", {}", error_text(error)));
    let denoised = rendered.denoised.as_ref().map_or_else(String::new, |denoised| {
        format!("; denoised by {}, estimated {}, the raw picture is kept", denoised.denoiser, error_text(&denoised.error))
    });
    let (spp, seconds, reason) = (rendered.spp, rendered.seconds, &rendered.stop_reason);
    News::Wrote(files, format!("{width} × {height}, {spp} spp in {seconds:.1} s{error}{denoised}, stopped by {reason}"))
}

fn turntable(
    order: &TurntableOrder,
    is_prediction: bool,
    say: &dyn Fn(News),
    watch: &mut Watch<'_>,
) -> Result<News, OfflineError> {
    let mut table = Turntable::open(order.clone(), Existing::Restart, watch)?;
    let names: Vec<String> = table.numbers().map(|number| table.name(number)).collect();
    say(News::Rows(table.numbers().zip(&names).map(|(number, name)| Row::new(name.clone(), table.frame(number))).collect()));
    if is_prediction {
        let due = table.due().len();
        return Ok(News::Predicted(table.predict(PROBES, watch)?, due));
    }
    let mut told = |number: u32, frame: Option<&Frame>| {
        let mut row = Row::new(names[number as usize].clone(), frame);
        if frame.is_none() {
            row.state = FrameState::Working;
        }
        say(News::Row(number as usize, row));
    };
    match table.render(watch, &mut told) {
        Ok(()) | Err(OfflineError::Cancelled) => {}
        Err(error) => return Err(error),
    }
    let rows = table.numbers().zip(names).map(|(number, name)| Row::new(name, table.frame(number))).collect();
    say(News::Rows(rows));
    let (done, all) = table.progress();
    Ok(News::Ended(done, all))
}
