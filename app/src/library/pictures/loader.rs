//! Loading small pictures from disk, on a thread of its own.

use super::{Done, Key, Wake};
use crate::library::queue::Queue;
use crate::library::shelf::Shelf;
use crate::thumbnails::Thumbnail;
use image::ImageReader;
use std::io::Cursor;
use std::path::Path;
use std::sync::Arc;
use std::sync::mpsc::Sender;

/// Larger files are none of ours.
const MAX_FILE_BYTES: u64 = 64 << 20;
/// Wider or higher pictures are not shown.
const MAX_SIDE: u32 = 2048;

/// What the thread needs.
pub(super) struct Loader {
    pub shelf: Option<Shelf>,
    pub queue: Arc<Queue<Key>>,
    pub sender: Sender<Done>,
    pub wake: Wake,
}

impl Loader {
    /// Loads until nobody orders any more.
    pub fn run(self) {
        while let Some(key) = self.queue.next() {
            let path = self.shelf.as_ref().map(|shelf| shelf.path(key.0, key.1));
            if self.sender.send(Done::Loaded(key, path.and_then(|path| load(&path)))).is_err() {
                return;
            }
            (self.wake)();
        }
    }
}

/// A picture from disk; `None` if it cannot be used.
pub fn load(path: &Path) -> Option<Thumbnail> {
    if std::fs::metadata(path).ok()?.len() > MAX_FILE_BYTES {
        return None;
    }
    let mut reader = ImageReader::new(Cursor::new(std::fs::read(path).ok()?)).with_guessed_format().ok()?;
    let mut limits = image::Limits::default();
    (limits.max_image_width, limits.max_image_height) = (Some(MAX_SIDE), Some(MAX_SIDE));
    reader.limits(limits);
    let picture = reader.decode().ok()?.into_rgba8();
    Some(Thumbnail { width: picture.width(), height: picture.height(), rgba: picture.into_raw() })
}
