//! Small pictures of textures, meshes and environments, made one after the other on a thread of its own.
//!
//! Nothing here blocks: what is asked for is there some [`Thumbnails::poll`] later. The same request gives the same bits. A request is made
//! once ([`Thumbnails::is_started`]), and again when what it shows has changed.

mod make;

pub use make::{environment_thumbnail, image_thumbnail, scene_thumbnail};

use burnish_assets::{BuiltInTexture, ENVIRONMENTS, Image, SHAPES, TextureMaker};
use burnish_material::Channel;
use burnish_renderer::path::Prepared;
use std::collections::{HashMap, VecDeque};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, Sender, TryRecvError, channel};

/// Bytes of finished pictures that are kept; the oldest go first.
pub const MAX_BYTES: usize = 64 << 20;
/// Longest side of a picture, pixels.
pub const MAX_SIDE: usize = 512;

/// A picture as plain data.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Thumbnail {
    /// Columns, at least 1.
    pub width: u32,
    /// Rows, at least 1.
    pub height: u32,
    /// Red, green, blue, alpha in sRGB, row by row from the top: `4 * width * height` bytes. Alpha is 255.
    pub rgba: Vec<u8>,
}

/// What a picture shows.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Key {
    /// A texture by the path that the material names, and the channels that are shown.
    Texture(String, Channel),
    /// A map of a built-in texture as a material may name it.
    BuiltInTexture(String),
    /// A built-in mesh by its name in [`SHAPES`].
    Shape(&'static str),
    /// A built-in environment by its name in [`ENVIRONMENTS`].
    Environment(&'static str),
}

/// What a picture is made of.
enum Job {
    Texture { image: Arc<Image>, channel: Channel, side: usize },
    BuiltInTexture { texture: BuiltInTexture, side: usize },
    Shape(&'static str),
    Environment(&'static str),
}

/// A picture that was asked for.
struct Pending {
    number: u64,
    key: Key,
    stop: Arc<AtomicBool>,
}

/// A job on its way to the thread.
type Order = (u64, Job, Arc<AtomicBool>);

/// The pictures that are there and those that will be.
pub struct Thumbnails {
    /// `None` where a picture could not be made.
    made: HashMap<Key, Option<Thumbnail>>,
    /// Keys of `made`, oldest first.
    order: VecDeque<Key>,
    pending: Vec<Pending>,
    next: u64,
    /// Pictures asked for since nothing was.
    asked: usize,
    orders: Sender<Order>,
    results: Receiver<(u64, Option<Thumbnail>)>,
}

impl Thumbnails {
    /// Starts the thread. `on_made` is called there after each picture: the moment to poll.
    pub fn new(on_made: impl Fn() + Send + 'static) -> Self {
        let (orders, inbox) = channel::<Order>();
        let (sender, results) = channel();
        // Without a thread nothing receives, and `start` takes note of that.
        _ = std::thread::Builder::new().name("thumbnails".to_owned()).spawn(move || work(&inbox, &sender, &on_made));
        Self { made: HashMap::new(), order: VecDeque::new(), pending: Vec::new(), next: 0, asked: 0, orders, results }
    }

    /// The newest picture of something; `None` if there is none yet, or none can be made.
    pub fn get(&self, key: &Key) -> Option<&Thumbnail> {
        self.made.get(key)?.as_ref()
    }

    /// Whether a picture was asked for: it is there, will be, or cannot be made.
    pub fn is_started(&self, key: &Key) -> bool {
        self.made.contains_key(key) || self.pending.iter().any(|p| p.key == *key)
    }

    /// Asks for the picture of a texture, `side` pixels (at most [`MAX_SIDE`]) along its longer side or as many as the image has.
    pub fn start_texture(&mut self, path: &str, image: &Arc<Image>, channel: Channel, side: usize) {
        self.start(Key::Texture(path.to_owned(), channel), Job::Texture { image: image.clone(), channel, side });
    }

    /// Asks for the picture of a map of a built-in texture, `side` pixels (at most [`MAX_SIDE`]) along each side.
    pub fn start_built_in_texture(&mut self, texture: BuiltInTexture, side: usize) {
        self.start(Key::BuiltInTexture(texture.path()), Job::BuiltInTexture { texture, side });
    }

    /// Asks for pictures of all built-in meshes and environments that were not asked for yet.
    pub fn start_built_in(&mut self) {
        for def in ENVIRONMENTS {
            if !self.is_started(&Key::Environment(def.name)) {
                self.start(Key::Environment(def.name), Job::Environment(def.name));
            }
        }
        for def in SHAPES {
            if !self.is_started(&Key::Shape(def.name)) {
                self.start(Key::Shape(def.name), Job::Shape(def.name));
            }
        }
    }

    /// Asks for a picture in place of one that is still to come.
    fn start(&mut self, key: Key, job: Job) {
        self.stop_where(|p| p.key == key);
        self.asked = if self.pending.is_empty() { 1 } else { self.asked + 1 };
        self.next += 1;
        let stop: Arc<AtomicBool> = Arc::default();
        match self.orders.send((self.next, job, stop.clone())) {
            Ok(()) => self.pending.push(Pending { number: self.next, key, stop }),
            Err(_) => self.keep(key, None),
        }
    }

    /// Takes what was made. True if there is something new.
    pub fn poll(&mut self) -> bool {
        let mut is_new = false;
        loop {
            match self.results.try_recv() {
                Ok((number, thumbnail)) => {
                    // What was cancelled is waited for no more.
                    let Some(at) = self.pending.iter().position(|p| p.number == number) else { continue };
                    let key = self.pending.remove(at).key;
                    self.keep(key, thumbnail);
                    is_new = true;
                }
                Err(TryRecvError::Empty) => return is_new,
                Err(TryRecvError::Disconnected) => {
                    for pending in std::mem::take(&mut self.pending) {
                        self.keep(pending.key, None);
                        is_new = true;
                    }
                    return is_new;
                }
            }
        }
    }

    /// Pictures made of those asked for since nothing was; `None` if nothing is being made.
    pub fn progress(&self) -> Option<(usize, usize)> {
        (!self.pending.is_empty()).then(|| (self.asked.saturating_sub(self.pending.len()), self.asked))
    }

    /// Gives up what is not made yet; what is there stays.
    pub fn cancel(&mut self) {
        self.stop_where(|_| true);
    }

    /// Forgets a picture and gives up making it.
    pub fn forget(&mut self, key: &Key) {
        self.stop_where(|p| p.key == *key);
        self.made.remove(key);
        self.order.retain(|k| k != key);
    }

    fn stop_where(&mut self, is_meant: impl Fn(&Pending) -> bool) {
        self.pending.retain(|p| {
            let is_meant = is_meant(p);
            if is_meant {
                p.stop.store(true, Ordering::Relaxed);
            }
            !is_meant
        });
    }

    fn keep(&mut self, key: Key, thumbnail: Option<Thumbnail>) {
        self.order.retain(|k| *k != key);
        self.order.push_back(key.clone());
        self.made.insert(key, thumbnail);
        let bytes = |t: &Option<Thumbnail>| t.as_ref().map_or(0, |t| t.rgba.len());
        let mut sum: usize = self.made.values().map(bytes).sum();
        while sum > MAX_BYTES
            && let Some(oldest) = self.order.pop_front()
        {
            sum -= self.made.remove(&oldest).as_ref().map_or(0, bytes);
        }
    }
}

impl Drop for Thumbnails {
    fn drop(&mut self) {
        // The thread ends with the queue, which is through at once.
        self.cancel();
    }
}

/// Makes what is ordered until nobody can order any more.
fn work(inbox: &Receiver<Order>, results: &Sender<(u64, Option<Thumbnail>)>, on_made: &dyn Fn()) {
    let mut studio = None;
    // Scenes that follow each other share tables of their light.
    let mut last: Option<Prepared> = None;
    let mut maker = TextureMaker::default();
    loop {
        let order = match inbox.try_recv() {
            Ok(order) => order,
            Err(_) => {
                // Between requests hours may go by.
                (last, maker) = (None, TextureMaker::default());
                match inbox.recv() {
                    Ok(order) => order,
                    Err(_) => return,
                }
            }
        };
        let (number, job, stop) = order;
        if stop.load(Ordering::Relaxed) {
            continue;
        }
        let is_stopped = || stop.load(Ordering::Relaxed);
        let made = catch_unwind(AssertUnwindSafe(|| match job {
            Job::Texture { image, channel, side } => image_thumbnail(&image, channel, side, &is_stopped),
            Job::BuiltInTexture { texture, side } => image_thumbnail(&maker.make(&texture), Channel::Rgb, side, &is_stopped),
            Job::Environment(name) => burnish_assets::make_environment(name).as_ref().and_then(environment_thumbnail),
            Job::Shape(name) => make::shape_thumbnail(name, &mut studio, &mut last, &is_stopped),
        }));
        if results.send((number, made.unwrap_or(None))).is_err() {
            return;
        }
        on_made();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::thumbnails::make::shape_scene;
    use burnish_material::{Material, Property, Value};
    use burnish_renderer::scene::Scene;
    use std::time::{Duration, Instant};

    fn red() -> Arc<Image> {
        Arc::new(Image { width: 8, height: 4, texels: vec![[1.0, 0.0, 0.0, 1.0]; 32], is_eight_bit: true })
    }

    /// Polls until nothing is being made.
    fn wait(thumbnails: &mut Thumbnails) {
        let start = Instant::now();
        while thumbnails.progress().is_some() {
            assert!(start.elapsed() < Duration::from_secs(60), "thumbnails take too long");
            thumbnails.poll();
            std::thread::sleep(Duration::from_millis(2));
        }
    }

    fn ball() -> Scene {
        let mut material = Material::default();
        material.set(Property::base_color, Value::Color([0.8, 0.05, 0.05]));
        shape_scene("sphere", material, &mut None).expect("the sphere is built in")
    }

    #[test]
    fn everything_built_in_has_a_picture() {
        let mut thumbnails = Thumbnails::new(|| {});
        thumbnails.start_built_in();
        thumbnails.start_built_in();
        let all = SHAPES.len() + ENVIRONMENTS.len();
        assert_eq!(thumbnails.progress(), Some((0, all)));
        wait(&mut thumbnails);
        for def in ENVIRONMENTS {
            let made = thumbnails.get(&Key::Environment(def.name)).expect("it was made");
            assert_eq!((made.width, made.height, made.rgba.len()), (144, 72, 144 * 72 * 4), "{}", def.name);
        }
        let mut pictures = Vec::new();
        for def in SHAPES {
            let made = thumbnails.get(&Key::Shape(def.name)).expect("it was made");
            assert_eq!((made.width, made.height, made.rgba.len()), (96, 72, 96 * 72 * 4), "{}", def.name);
            assert!(made.rgba.chunks(4).all(|p| p[3] == 255));
            // Clay is grey, and neither black nor white in the middle.
            let middle = &made.rgba[(36 * 96 + 48) * 4..][..3];
            assert!(
                middle.iter().all(|x| (20..250).contains(x)) && middle[0].abs_diff(middle[2]) < 30,
                "{}: {middle:?}",
                def.name
            );
            assert!(!pictures.contains(&made), "{} looks like another mesh", def.name);
            pictures.push(made);
        }
        let pixel = |name, x: usize| thumbnails.get(&Key::Environment(name)).expect("it was made").rgba[x * 4..][..3].to_vec();
        assert_eq!(pixel("black", 100), [0; 3]);
        assert!(pixel("white-furnace", 100)[0] > 200);
        assert!(!thumbnails.poll() && thumbnails.progress().is_none());
    }

    #[test]
    fn the_same_scene_gives_the_same_bits() {
        let mut last = None;
        // The second shares tables with the first.
        let [a, b] = [(); 2].map(|()| scene_thumbnail(&ball(), [24, 24], &mut last, &|| false).expect("it is made"));
        assert!(a == b, "pictures differ");
        assert_eq!((a.width, a.height), (24, 24));
        let [r, g, ..] = a.rgba[(12 * 24 + 12) * 4..] else { panic!("four bytes") };
        assert!(r > g.saturating_add(50), "{r} {g}");
    }

    #[test]
    fn what_is_cancelled_never_comes() {
        let mut thumbnails = Thumbnails::new(|| {});
        let key = Key::Shape(SHAPES[SHAPES.len() - 1].name);
        thumbnails.start_built_in();
        thumbnails.start_texture("red", &red(), Channel::Rgb, 4);
        assert!(thumbnails.is_started(&key));
        thumbnails.cancel();
        assert!(thumbnails.progress().is_none() && !thumbnails.is_started(&key));
        let start = Instant::now();
        thumbnails.start_texture("red", &red(), Channel::R, 4);
        wait(&mut thumbnails);
        assert!(start.elapsed() < Duration::from_secs(30), "{:?}", start.elapsed());
        assert!(thumbnails.get(&key).is_none() && thumbnails.get(&Key::Texture("red".into(), Channel::Rgb)).is_none());
        assert!(thumbnails.get(&Key::Texture("red".into(), Channel::R)).is_some());
        thumbnails.forget(&Key::Texture("red".into(), Channel::R));
        assert!(!thumbnails.is_started(&Key::Texture("red".into(), Channel::R)));
    }

    #[test]
    fn memory_is_bounded() {
        let mut thumbnails = Thumbnails::new(|| {});
        let large = |key: &str| {
            (Key::Texture(key.into(), Channel::Rgb), Some(Thumbnail { width: 1, height: 1, rgba: vec![0; MAX_BYTES / 2] }))
        };
        for key in ["a", "b", "c"] {
            let (key, thumbnail) = large(key);
            thumbnails.keep(key, thumbnail);
        }
        let has = |key: &str| thumbnails.get(&Key::Texture(key.into(), Channel::Rgb)).is_some();
        assert!(!has("a") && has("b") && has("c"));
    }
}
