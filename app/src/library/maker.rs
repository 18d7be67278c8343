//! Making small pictures one after the other, each of them kept on disk before the next is begun.

use super::entry::Entry;
use super::setup::{self, Made, Setup};
use super::shelf::Shelf;
use burnish_renderer::path::{Prepared, Progress};
use std::path::Path;

/// Makes pictures of one library in one setup.
pub struct Maker<'a> {
    root: &'a Path,
    setup: &'a Setup,
    threads: usize,
    seconds: f64,
    /// Pictures that follow each other share tables of their light.
    last: Option<Prepared>,
    /// Size of the last picture, if it could not be written.
    refused_bytes: Option<usize>,
}

impl<'a> Maker<'a> {
    /// For the library in `root`, on so many threads, with at most so many seconds for a picture.
    pub fn new(root: &'a Path, setup: &'a Setup, threads: usize, seconds: f64) -> Self {
        Self { root, setup, threads, seconds, last: None, refused_bytes: None }
    }

    /// Makes and keeps the picture of an entry. Returns it, and a sentence for each image that could not be read; `None` if `go_on` says no after
    /// a pass. An error, without the path, if there can be no picture or it cannot be kept.
    pub fn make(
        &mut self,
        entry: &Entry,
        shelf: &mut Shelf,
        go_on: &mut dyn FnMut(&Progress<'_>) -> bool,
    ) -> Result<Option<(Made, Vec<String>)>, String> {
        if let Some(bytes) = self.refused_bytes {
            shelf.probe(bytes).map_err(|error| error.to_string())?;
        }
        let (material, textures, missing) = setup::guarded(|| setup::read(self.root, entry))?;
        let scene = self.setup.scene_of(material, textures);
        let (last, seconds, threads) = (&mut self.last, self.seconds, self.threads);
        let Some(made) = setup::guarded(|| self.setup.render(&scene, last, seconds, threads, go_on))? else { return Ok(None) };
        let put = shelf.put(entry.look, self.setup.digest(), &made.png);
        self.refused_bytes = put.is_err().then_some(made.png.len());
        put.map_err(|error| error.to_string())?;
        Ok(Some((made, missing)))
    }
}
