//! Displaced meshes for the drawn picture: made on a thread of its own while the picture shows the last ones.

use super::Preview;
use crate::path::{HeightKey, displaced_mesh};
use crate::scene::{Object, Scene};
use burnish_assets::Mesh;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError, channel};

/// A mesh and what its height makes of it.
#[derive(Debug)]
struct Made {
    mesh: Arc<Mesh>,
    height: HeightKey,
    displaced: Arc<Mesh>,
}

impl Made {
    fn new(object: &Object, height: HeightKey) -> Self {
        Self { mesh: object.mesh.clone(), height, displaced: displaced_mesh(object) }
    }

    fn is_of(&self, mesh: &Arc<Mesh>, height: &HeightKey) -> bool {
        Arc::ptr_eq(&self.mesh, mesh) && self.height == *height
    }
}

/// The displaced meshes of a scene.
#[derive(Debug, Default)]
pub(super) struct Reliefs {
    made: Vec<Made>,
    making: Option<Making>,
}

/// Meshes that are being made.
#[derive(Debug)]
struct Making {
    wanted: Vec<(Object, HeightKey)>,
    result: Receiver<Vec<Made>>,
}

impl Making {
    fn start(wanted: Vec<(Object, HeightKey)>) -> Self {
        let (sender, result) = channel();
        let given = wanted.clone();
        std::thread::spawn(move || {
            // Nobody waits any more if the preview is gone.
            _ = sender.send(given.into_iter().map(|(object, height)| Made::new(&object, height)).collect());
        });
        Self { wanted, result }
    }
}

impl Reliefs {
    /// Whether meshes are being made.
    pub fn is_making(&self) -> bool {
        self.making.is_some()
    }

    /// The mesh to draw now for each object. Where its own is not made yet, that of an earlier height, or the flat one: while a value changes
    /// all the time, pictures follow as fast as meshes are made.
    pub fn meshes(&mut self, objects: &[Object]) -> Vec<Arc<Mesh>> {
        self.take_made();
        // Of each mesh what is wanted, or the last that was.
        let is_wanted = |made: &Made| {
            objects
                .iter()
                .any(|o| Arc::ptr_eq(&o.mesh, &made.mesh) && HeightKey::of(o).is_some_and(|height| height == made.height))
        };
        for i in (0..self.made.len()).rev() {
            let is_last = !self.made[i + 1..].iter().any(|later| Arc::ptr_eq(&later.mesh, &self.made[i].mesh));
            let is_used = objects.iter().any(|o| Arc::ptr_eq(&o.mesh, &self.made[i].mesh));
            if !(is_wanted(&self.made[i]) || is_last && is_used) {
                self.made.remove(i);
            }
        }
        let mut missing = Vec::new();
        let meshes = objects
            .iter()
            .map(|object| {
                let Some(height) = HeightKey::of(object) else { return object.mesh.clone() };
                let made = self.made.iter().find(|made| made.is_of(&object.mesh, &height));
                let earlier = || self.made.iter().rfind(|made| Arc::ptr_eq(&made.mesh, &object.mesh));
                if made.is_none() {
                    missing.push((object.clone(), height));
                }
                made.or_else(earlier).map_or_else(|| object.mesh.clone(), |made| made.displaced.clone())
            })
            .collect();
        if !missing.is_empty() && self.making.is_none() {
            self.making = Some(Making::start(missing));
        }
        meshes
    }

    fn take_made(&mut self) {
        let Some(making) = self.making.take() else { return };
        match making.result.try_recv() {
            Ok(new) => self.made.extend(new),
            Err(TryRecvError::Empty) => self.making = Some(making),
            // The thread is gone without a result: the flat meshes have to do.
            Err(TryRecvError::Disconnected) => self.made.extend(making.wanted.into_iter().map(|(object, height)| Made {
                mesh: object.mesh.clone(),
                height,
                displaced: object.mesh,
            })),
        }
    }
}

impl Preview {
    /// The scene as it is drawn: with displaced meshes.
    pub(super) fn displaced(&mut self, scene: &Scene) -> Scene {
        let meshes = self.reliefs.meshes(&scene.objects);
        let objects = scene.objects.iter().zip(meshes).map(|(object, mesh)| Object { mesh, ..object.clone() }).collect();
        Scene { objects, ..scene.clone() }
    }
}
