//! stub
use super::environment::Level;
use super::floor::Floor;
use super::upload::BakedVertex;
use crate::scene::Scene;
use burnish_assets::Mesh;
use glam::Vec3;
use std::sync::Arc;

#[derive(Debug, Default)]
pub(super) struct Baker {}

#[derive(Debug)]
pub(super) struct Baked {
    pub meshes: Vec<(Arc<Mesh>, Vec<BakedVertex>)>,
    pub floor: Option<Level>,
}

impl Baker {
    pub fn request(&mut self, _scene: &Scene, _floor: Option<&Floor>, _floor_mean: Vec3) {}
    pub fn take(&mut self) -> Option<Baked> {
        None
    }
    pub fn is_busy(&self) -> bool {
        false
    }
    pub fn has_result(&self) -> bool {
        false
    }
    pub fn wait(&mut self) {}
}
