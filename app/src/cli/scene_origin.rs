//! Where the parts of a scene came from, for pictures of it to say.

use super::scene_options::LoadedScene;
use crate::picture_job::{PictureJob, Place, SceneSource, Source, Texture};
use burnish_material::MaterialFile;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Where the parts of a scene came from.
#[derive(Clone, Debug, Default)]
pub(super) struct Origin {
    pub mesh: Option<Place>,
    pub environment: Option<Place>,
    pub scene: Option<PathBuf>,
    pub assets: Vec<PathBuf>,
    pub replaces_material: bool,
    pub unit_mm: Option<f64>,
    pub file: Option<Arc<MaterialFile>>,
    pub texture_files: Vec<(String, PathBuf)>,
    pub turn_deg: f64,
}

impl LoadedScene {
    /// The same with the objects turned about the vertical, degrees.
    #[must_use]
    pub fn turned(mut self, deg: f64) -> Self {
        self.scene = self.scene.turned(deg);
        self.origin.turn_deg = deg;
        self
    }

    /// By how much the objects were turned, degrees.
    pub fn turn_deg(&self) -> f64 {
        self.origin.turn_deg
    }

    /// Notes what a picture in `folder` has to say about its scene and material. Reads all files of the scene.
    pub fn describe(&self, job: &mut PictureJob, folder: Option<&Path>) {
        let origin = &self.origin;
        let source = |place: &Option<Place>| place.as_ref().map(|place| place.source(folder));
        job.size = [self.width, self.height];
        job.scene = SceneSource {
            mesh: source(&origin.mesh),
            environment: source(&origin.environment),
            scene: origin.scene.as_ref().map(|path| Source::of_file(path, folder)),
            assets: origin.assets.iter().map(|path| Source::of_file(path, folder)).collect(),
            replaces_material: origin.replaces_material,
            unit_mm: origin.unit_mm,
            rotation_deg: self.scene.environment.rotation_deg,
            turn_deg: origin.turn_deg,
            camera: self.scene.camera.into(),
            max_bounces: self.scene.max_bounces,
        };
        job.textures = origin.texture_files.iter().map(|(name, path)| Texture::of_file(name, path, folder)).collect();
        job.material = self.material().map(|material| match &origin.file {
            Some(file) => file.to_text(material),
            None => MaterialFile::new(material).text().to_owned(),
        });
    }
}
