//! Light that neighbours take and give, computed on a thread while the picture is shown without: shadows on the floor, dark
//! corners, and what stands in the way of reflections.
//!
//! All points share the directions of a pass, half of them chosen where the environment is bright, half evenly. So a
//! pass has no noise, only edges, and these fade as passes add up. What is stored is the difference to an
//! open sky over an endless floor, which the shader knows exactly. For the floor,
//! bodies being edited count as black, and what white ones would add is stored beside it; for their own walls they count as themselves. So no
//! value of a material makes this work anew.

use super::bake_job::Job;
use super::environment::{Level, Prefiltered};
use super::floor::Floor;
use super::upload::BakedVertex;
use crate::scene::Scene;
use burnish_assets::{Environment, Mesh};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, TryRecvError, channel};

/// Runs the work and keeps what it is working on.
#[derive(Debug, Default)]
pub(super) struct Baker {
    key: Option<Key>,
    generation: Arc<AtomicU64>,
    /// Results of the newest request; `None` once the last one was taken.
    results: Option<Receiver<Message>>,
    has_result: bool,
    last: Option<Baked>,
}

/// Results of all passes so far.
#[derive(Clone, Debug)]
pub(super) struct Baked {
    /// One entry per vertex of each mesh that is not floor.
    pub meshes: Vec<(Arc<Mesh>, Vec<BakedVertex>)>,
    /// What the floor gains or loses.
    pub floor: Option<BakedFloor>,
}

/// Light on the floor, and the radiance with its averages that follows.
#[derive(Clone, Debug)]
pub(super) struct BakedFloor {
    /// Irradiance beside black bodies, less that of the open floor.
    pub light: Level,
    /// What white bodies in the place of the edited ones add, and what bodies that shine with radiance 1 do.
    pub glow: Level,
    pub shine: Level,
    pub radiance: Vec<Level>,
    pub glow_radiance: Vec<Level>,
    pub shine_radiance: Vec<Level>,
}

#[derive(Debug)]
struct Message {
    baked: Baked,
    is_last: bool,
}

/// What the result depends on.
#[derive(Debug)]
struct Key {
    meshes: Vec<Arc<Mesh>>,
    environment: Arc<Environment>,
    rotation_deg: f32,
}

impl Key {
    fn is(&self, scene: &Scene) -> bool {
        self.meshes.len() == scene.objects.len()
            && self.meshes.iter().zip(&scene.objects).all(|(mesh, object)| Arc::ptr_eq(mesh, &object.mesh))
            && Arc::ptr_eq(&self.environment, &scene.environment.map)
            && self.rotation_deg == scene.environment.rotation_deg
    }
}

impl Drop for Baker {
    fn drop(&mut self) {
        self.generation.fetch_add(1, Ordering::Relaxed);
    }
}

impl Baker {
    /// Starts anew if meshes or light changed.
    pub fn request(&mut self, scene: &Scene, floor: Option<&Floor>, light: &Arc<Prefiltered>) {
        if self.key.as_ref().is_some_and(|key| key.is(scene)) {
            return;
        }
        self.key = Some(Key {
            meshes: scene.objects.iter().map(|o| o.mesh.clone()).collect(),
            environment: scene.environment.map.clone(),
            rotation_deg: scene.environment.rotation_deg,
        });
        let generation = self.generation.fetch_add(1, Ordering::Relaxed) + 1;
        let (scene, floor, light) = (scene.clone(), floor.cloned(), light.clone());
        let (sender, results) = channel();
        let current = self.generation.clone();
        let work = move || {
            Job::new(&scene, floor, light).run(&|| current.load(Ordering::Relaxed) != generation, &|baked, is_last| {
                // Nobody listens any more once the preview is gone.
                _ = sender.send(Message { baked, is_last });
            })
        };
        self.results = std::thread::Builder::new().name("preview light".to_owned()).spawn(work).ok().map(|_| results);
    }

    /// The newest result, if one has come since the last call.
    pub fn take(&mut self) -> Option<Baked> {
        while let Some(results) = &self.results {
            match results.try_recv() {
                Ok(message) => self.accept(message),
                Err(TryRecvError::Empty) => break,
                // The thread ended early: what is there has to do.
                Err(TryRecvError::Disconnected) => self.results = None,
            }
        }
        self.last.take()
    }

    fn accept(&mut self, message: Message) {
        if message.is_last {
            self.results = None;
        }
        self.has_result = true;
        self.last = Some(message.baked);
    }

    /// Whether more results will come.
    pub fn is_busy(&self) -> bool {
        self.results.is_some()
    }

    /// Whether any result was there.
    pub fn has_result(&self) -> bool {
        self.has_result
    }

    /// Waits for the last result.
    pub fn wait(&mut self) {
        while let Some(results) = &self.results {
            match results.recv() {
                Ok(message) => self.accept(message),
                Err(_) => self.results = None,
            }
        }
    }
}
