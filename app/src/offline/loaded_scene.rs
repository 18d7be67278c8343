//! A scene that can be rendered, with where its parts came from, for pictures of it to say.

use crate::picture_job::{PictureJob, Place, SceneSource, Source, Texture};
use burnish_assets::BackdropDef;
use burnish_material::{Material, MaterialFile};
use burnish_renderer::scene::Scene;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Where the parts of a scene came from.
#[derive(Clone, Debug, Default)]
pub struct Origin {
    /// The mesh; `None`: that of the scene file.
    pub mesh: Option<Place>,
    /// What the mesh stands on, where that is not what it brings.
    pub backdrop: Option<&'static BackdropDef>,
    /// The environment; `None`: that of the scene file.
    pub environment: Option<Place>,
    /// A scene file.
    pub scene: Option<PathBuf>,
    /// What the scene file names.
    pub assets: Vec<PathBuf>,
    /// Whether the material took the place of the scene file's.
    pub replaces_material: bool,
    /// Millimetres per scene unit, where that was given.
    pub unit_mm: Option<f64>,
    /// The material's file with its text.
    pub file: Option<Arc<MaterialFile>>,
    /// Images by the path that the material names.
    pub texture_files: Vec<(String, PathBuf)>,
    /// By how much the objects were turned about the vertical, degrees.
    pub turn_deg: f64,
}

/// A scene that can be rendered.
#[derive(Clone, Debug)]
pub struct LoadedScene {
    /// What is drawn, with every option applied.
    pub scene: Scene,
    /// Pixels.
    pub width: usize,
    /// Pixels.
    pub height: usize,
    /// Where its parts came from.
    pub origin: Origin,
}

impl LoadedScene {
    /// The material that it is about; that of the first object where none carries the document.
    pub fn material(&self) -> Option<&Arc<Material>> {
        let objects = &self.scene.objects;
        objects.iter().find(|object| object.is_document).or(objects.first()).map(|object| &object.material)
    }

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
            backdrop: origin.backdrop.map(|def| def.name.to_owned()),
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
