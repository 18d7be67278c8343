//! Debug views and explained pixels: made on a thread from the scene as the path tracer sees it, when something is asked for and no sooner.

use burnish_renderer::path::{DebugProgress, DebugView, Explanation, LegendEntry, Prepared, SampleView, debug_picture, explain};
use burnish_renderer::scene::Scene;
use burnish_renderer::tonemap::srgb_encode;
use burnish_renderer::worker::Snapshot;
use egui::{Color32, ColorImage, Context, TextureHandle, TextureOptions};
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::sync::{Arc, Mutex, PoisonError};

/// Samples of an explained pixel.
const EXPLAIN_SAMPLES: u32 = 512;

/// What is shown instead of the material.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Choice {
    /// A property of the surface.
    Surface(DebugView),
    /// A property of the final view's samples.
    Samples(SampleView),
}

impl Choice {
    /// All choices in order.
    pub fn all() -> impl Iterator<Item = Self> {
        let surface = DebugView::ALL.iter().map(|def| Self::Surface(def.view));
        surface.chain(SampleView::ALL.iter().map(|def| Self::Samples(def.view)))
    }

    /// What menus call it.
    pub fn label(self) -> &'static str {
        match self {
            Self::Surface(view) => view.def().label,
            Self::Samples(view) => view.def().label,
        }
    }

    /// One sentence about it.
    pub fn doc(self) -> &'static str {
        match self {
            Self::Surface(view) => view.def().doc,
            Self::Samples(view) => view.def().doc,
        }
    }

    /// Colours and what they stand for.
    pub fn legend(self) -> Vec<LegendEntry> {
        match self {
            Self::Surface(view) => view.legend(),
            Self::Samples(view) => view.legend(),
        }
    }
}

/// Where a picture is from: the scene's revision, size in pixels, and the final view's samples where they matter.
type Key = (Choice, u64, (usize, usize), (u64, u32));

/// What a thread made.
enum Made {
    Picture(Key, ColorImage),
    Pixel(Box<Explanation>),
}

/// The scene prepared last with its revision, for the threads that need it.
type PreparedScene = Arc<Mutex<Option<(u64, Arc<Prepared>)>>>;

/// What is shown and what is being made.
#[derive(Default)]
pub struct LiveDebug {
    choice: Option<Choice>,
    is_explaining: bool,
    job: Option<Receiver<Made>>,
    /// Of the picture that is being made, with its rows.
    progress: Option<(Arc<DebugProgress>, usize)>,
    made: Option<Key>,
    texture: Option<TextureHandle>,
    explanation: Option<Box<Explanation>>,
    /// The scene prepared last, by its revision.
    prepared: PreparedScene,
}

impl LiveDebug {
    /// What is shown, if anything.
    pub fn choice(&self) -> Option<Choice> {
        self.choice
    }

    /// Shows something else, or the material.
    pub fn set(&mut self, choice: Option<Choice>) {
        if let Some((progress, _)) = &self.progress {
            progress.end();
        }
        (self.choice, self.texture, self.made) = (choice, None, None);
    }

    /// Shows what comes after what is shown; after the last the material.
    pub fn next(&mut self) {
        let mut all = Choice::all();
        let next = match self.choice {
            None => all.next(),
            Some(choice) => all.skip_while(|other| *other != choice).nth(1),
        };
        self.set(next);
    }

    /// Back to the material, and no more explaining.
    pub fn end(&mut self) {
        self.set(None);
        (self.is_explaining, self.explanation) = (false, None);
    }

    /// Whether the next click in a picture is to be explained.
    pub fn is_explaining(&self) -> bool {
        self.is_explaining
    }

    /// Begins or ends explaining.
    pub fn toggle_explaining(&mut self) {
        (self.is_explaining, self.explanation) = (!self.is_explaining, None);
    }

    /// What the pixel clicked last is made of.
    pub fn explanation(&self) -> Option<&Explanation> {
        self.explanation.as_deref()
    }

    /// Whether something is being made.
    pub fn is_busy(&self) -> bool {
        self.job.is_some()
    }

    /// How much of the picture is made, 0 to 1, if that is known.
    pub fn progress(&self) -> Option<f32> {
        self.progress.as_ref().map(|(progress, rows)| progress.rows() as f32 / (*rows).max(1) as f32)
    }

    /// Takes what was made, and begins what is missing. `revision` counts scenes; `scene` makes the one to draw.
    pub fn update(
        &mut self,
        ctx: &Context,
        revision: u64,
        size: (usize, usize),
        snapshot: Option<&Arc<Snapshot>>,
        scene: impl FnOnce() -> Option<Scene>,
    ) {
        match self.job.as_ref().map(Receiver::try_recv) {
            Some(Ok(Made::Picture(key, image))) => {
                self.job = None;
                if self.choice == Some(key.0) {
                    self.made = Some(key);
                    match &mut self.texture {
                        Some(texture) => texture.set(image, TextureOptions::NEAREST),
                        None => self.texture = Some(ctx.load_texture("debug view", image, TextureOptions::NEAREST)),
                    }
                }
            }
            Some(Ok(Made::Pixel(explanation))) => {
                self.job = None;
                self.explanation = self.is_explaining.then_some(explanation);
            }
            Some(Err(TryRecvError::Disconnected)) => self.job = None,
            Some(Err(TryRecvError::Empty)) => return,
            None => {}
        }
        self.progress = None;
        let Some(choice) = self.choice else { return };
        match choice {
            Choice::Surface(view) => {
                let key = (choice, revision, size, (0, 0));
                if self.made == Some(key) {
                    return;
                }
                let Some(scene) = scene() else { return };
                let kept = self.prepared.clone();
                let progress: Arc<DebugProgress> = Arc::default();
                self.progress = Some((progress.clone(), size.1));
                self.start(ctx, move || {
                    let prepared = prepared(&kept, revision, scene);
                    let pixels = debug_picture(&prepared, view, size, 1, &progress)?;
                    Some(Made::Picture(key, image(pixels, size.0)))
                });
            }
            Choice::Samples(view) => {
                let Some((snapshot, samples)) = snapshot.and_then(|snapshot| Some((snapshot, snapshot.samples.clone()?))) else {
                    return;
                };
                let key = (choice, 0, (snapshot.width, snapshot.height), (snapshot.revision, snapshot.spp));
                if self.made != Some(key) {
                    let width = snapshot.width;
                    self.start(ctx, move || Some(Made::Picture(key, image(samples.picture(view), width))));
                }
            }
        }
    }

    /// Begins to explain a pixel of a picture of this size.
    pub fn explain(
        &mut self,
        ctx: &Context,
        revision: u64,
        (x, y): (usize, usize),
        (width, height): (usize, usize),
        scene: Scene,
    ) {
        let kept = self.prepared.clone();
        self.start(ctx, move || {
            let prepared = prepared(&kept, revision, scene);
            Some(Made::Pixel(Box::new(explain(&prepared, x, y, width, height, EXPLAIN_SAMPLES))))
        });
    }

    fn start(&mut self, ctx: &Context, make: impl FnOnce() -> Option<Made> + Send + 'static) {
        let (sender, receiver) = channel();
        let repaint = ctx.clone();
        std::thread::spawn(move || {
            // Nobody waits any more if something else was chosen.
            if let Some(made) = make() {
                _ = sender.send(made);
            }
            drop(sender);
            repaint.request_repaint();
        });
        self.job = Some(receiver);
    }

    /// The picture, once it is made.
    pub fn texture(&self) -> Option<&TextureHandle> {
        self.texture.as_ref()
    }
}

/// The scene as the path tracer sees it: the one kept if it is of this revision.
fn prepared(kept: &PreparedScene, revision: u64, scene: Scene) -> Arc<Prepared> {
    let lock = || kept.lock().unwrap_or_else(PoisonError::into_inner);
    let known = lock().as_ref().filter(|(of, _)| *of == revision).map(|(_, prepared)| prepared.clone());
    known.unwrap_or_else(|| {
        let prepared = Arc::new(Prepared::new(&scene, None));
        *lock() = Some((revision, prepared.clone()));
        prepared
    })
}

/// Linear colours that are meant to be shown as they are, without a display transform.
fn image(pixels: Vec<[f32; 3]>, width: usize) -> ColorImage {
    let height = pixels.len() / width.max(1);
    let colors = pixels.into_iter().map(|color| {
        let [r, g, b] = shown(color);
        Color32::from_rgb(r, g, b)
    });
    ColorImage::new([width, height], colors.collect())
}

/// A linear colour from 0 to 1 as the screen shows it.
pub fn shown(color: [f32; 3]) -> [u8; 3] {
    color.map(|x| (srgb_encode(x.clamp(0.0, 1.0)) * 255.0 + 0.5) as u8)
}
