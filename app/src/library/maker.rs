//! Making small pictures one after the other.

use super::entry::Entry;
use super::setup::{self, Made, Setup};
use super::shelf::Shelf;
use burnish_renderer::path::{Kept, Prepared, Progress, Rendering, StopReason};
use std::path::{Path, PathBuf};

/// When a picture that does not become good enough is done, and who works at it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Seconds of rendering, from its very beginning.
    pub seconds: f64,
    /// Threads; 0 counts as 1.
    pub threads: usize,
}

/// Renders pictures of one library.
pub struct Renderer {
    root: PathBuf,
    /// Pictures that follow each other share tables of their light.
    last: Option<Prepared>,
}

impl Renderer {
    /// For the library in `root`.
    pub fn new(root: &Path) -> Self {
        Self { root: root.to_path_buf(), last: None }
    }

    /// The library's folder.
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// Renders the picture of an entry, from its beginning or from where it was put aside, until its error is small enough, a limit is reached or
    /// `go_on` says no after a pass. Also returns a sentence for each image that could not be read. An error, without the path, if there can be no
    /// picture.
    pub fn render(
        &mut self,
        setup: &Setup,
        entry: &Entry,
        begun: Option<Kept>,
        limits: Limits,
        go_on: &mut dyn FnMut(&Progress<'_>) -> bool,
    ) -> Result<(Rendering, Vec<String>), String> {
        let (material, textures, missing) = setup::read(&self.root, entry)?;
        let scene = setup.scene_of(material, textures);
        Ok((setup.expose(&scene, &mut self.last, begun, limits, go_on), missing))
    }
}

/// Fills a shelf with pictures of one library in one setup, each of them kept on disk before the next is begun.
pub struct Maker<'a> {
    renderer: Renderer,
    setup: &'a Setup,
    limits: Limits,
    /// Size of the last picture, if it could not be written.
    refused_bytes: Option<usize>,
}

impl<'a> Maker<'a> {
    /// For the library in `root`, with these limits for each picture.
    pub fn new(root: &Path, setup: &'a Setup, limits: Limits) -> Self {
        Self { renderer: Renderer::new(root), setup, limits, refused_bytes: None }
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
        let (renderer, setup, limits) = (&mut self.renderer, self.setup, self.limits);
        let (rendering, missing) = setup::guarded(|| renderer.render(setup, entry, None, limits, go_on))?;
        if rendering.stop_reason == StopReason::Cancelled {
            return Ok(None);
        }
        let made = setup.develop(&rendering)?;
        let put = shelf.put(entry.look, setup.digest(), &made.png);
        self.refused_bytes = put.is_err().then_some(made.png.len());
        put.map_err(|error| error.to_string())?;
        Ok(Some((made, missing)))
    }
}
