//! The document and the view settings: everything the user can change, and the scene they make together.

use crate::files::{self, Embedded, OpenedMaterial};
use crate::picture_job::Place;
use burnish_assets::{BackdropDef, Environment};
use burnish_material::{Material, MaterialFile};
use burnish_renderer::path::StopRules;
use burnish_renderer::scene::{Camera, DEFAULT_ELEVATION_DEG, DEFAULT_FOV_DEG, EnvironmentLight, ModelMeshes, Scene, TextureSet};
use burnish_renderer::tonemap::Display;
use glam::Vec3;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The file a document came from, or the text it would have.
#[derive(Debug)]
struct Origin {
    path: Option<PathBuf>,
    /// The file of another format that it came from, as long as it has none of its own.
    import: Option<PathBuf>,
    /// The text as opened. Every save starts from it, so that an edit taken back gives its spelling again, also after saves between.
    file: Arc<MaterialFile>,
    /// What the disk holds.
    saved: Arc<MaterialFile>,
}

/// The material being edited, its images, and what its file held when it was opened or saved last.
#[derive(Clone, Debug)]
pub struct Document {
    /// The material, edited in place by the widgets.
    pub material: Material,
    /// Images by the path that the material names.
    pub textures: Arc<TextureSet>,
    /// Those that lie in no file of their own.
    embedded: Arc<Embedded>,
    origin: Arc<Origin>,
    /// Whether this document replaced one with unsaved changes that only undo can bring back.
    covers_unsaved: bool,
}

impl Document {
    /// A document without a file.
    pub fn new(material: Material) -> Self {
        let file = MaterialFile::new(&material);
        // The file's own reading is the reference, so that a fresh document never counts as changed.
        Self::with_origin(file, None, Arc::default(), Arc::default())
    }

    /// A document as opened from a file or made from a preset's text.
    pub fn opened(opened: OpenedMaterial) -> Self {
        Self::with_origin(opened.file, opened.path, opened.textures, opened.embedded).imported(opened.import)
    }

    fn with_origin(file: MaterialFile, path: Option<PathBuf>, textures: Arc<TextureSet>, embedded: Arc<Embedded>) -> Self {
        let material = file.material().clone();
        let file = Arc::new(file);
        let origin = Arc::new(Origin { path, import: None, saved: file.clone(), file });
        Self { material, textures, embedded, origin, covers_unsaved: false }
    }

    /// Images that the material names and that lie in no file of their own, as whole files.
    pub fn embedded(&self) -> impl Iterator<Item = (&String, &Arc<[u8]>)> {
        let is_named =
            |path: &str| self.material.slots().any(|(_, slot)| slot.texture.as_ref().is_some_and(|texture| texture.path == path));
        self.embedded.iter().filter(move |(path, _)| is_named(path))
    }

    /// A document that takes the place of `self` as one step that undo can take back.
    #[must_use]
    pub fn replaced_by(&self, mut next: Self) -> Self {
        next.covers_unsaved = self.is_modified();
        next
    }

    /// The same content as a document that no file holds yet; its maps lead to the same images.
    #[must_use]
    pub fn without_path(mut self) -> Self {
        self.move_to_folder(None);
        let Origin { file, saved, .. } = &*self.origin;
        self.origin = Arc::new(Origin { path: None, import: None, file: file.clone(), saved: saved.clone() });
        self
    }

    /// A document that was being edited when its program ended: what it held then, over what its file held.
    pub fn recovered(original: MaterialFile, path: Option<PathBuf>, material: Material, textures: Arc<TextureSet>) -> Self {
        Self { material, ..Self::with_origin(original, path, textures, Arc::default()) }
    }

    /// The same as a document that came from this file of another format.
    #[must_use]
    pub fn imported(mut self, import: Option<PathBuf>) -> Self {
        let Origin { path, file, saved, .. } = &*self.origin;
        self.origin = Arc::new(Origin { path: path.clone(), import, file: file.clone(), saved: saved.clone() });
        self
    }

    /// Takes images that lie in no file of their own, and what they decode to.
    pub fn add_embedded(&mut self, embedded: Embedded, textures: TextureSet) {
        Arc::make_mut(&mut self.embedded).extend(embedded);
        Arc::make_mut(&mut self.textures).extend(textures);
    }

    /// The file with its text as opened.
    pub fn file(&self) -> &MaterialFile {
        &self.origin.file
    }

    /// The same, to be kept while the material is edited.
    pub fn file_shared(&self) -> Arc<MaterialFile> {
        self.origin.file.clone()
    }

    /// The file as the disk holds it.
    pub fn saved(&self) -> &MaterialFile {
        &self.origin.saved
    }

    /// The same, to be kept while the document is saved again.
    pub fn saved_shared(&self) -> Arc<MaterialFile> {
        self.origin.saved.clone()
    }

    /// Where the document was opened from or saved to.
    pub fn path(&self) -> Option<&Path> {
        self.origin.path.as_deref()
    }

    /// The file of another format that it came from, as long as it has none of its own.
    pub fn import(&self) -> Option<&Path> {
        self.origin.import.as_deref()
    }

    /// The folder that relative texture paths start at.
    pub fn folder(&self) -> Option<&Path> {
        self.path().and_then(Path::parent)
    }

    /// Whether closing would lose something.
    pub fn is_modified(&self) -> bool {
        self.covers_unsaved || self.material != *self.origin.saved.material()
    }

    /// Whether nothing that undo restores differs.
    pub fn is_same(&self, other: &Self) -> bool {
        self.material == other.material && self.shares_origin(other)
    }

    /// Whether both came from the same opening, saving or preset.
    pub fn shares_origin(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.origin, &other.origin)
    }

    /// Takes over which file this is, and what it holds.
    pub fn take_origin(&mut self, other: &Self) {
        self.origin = other.origin.clone();
    }

    /// Prepares for saving in another folder: relative paths of maps are made to lead to the same images from there.
    pub fn move_to_folder(&mut self, folder: Option<&Path>) {
        let old = self.folder().map(Path::to_path_buf);
        for (old, new) in files::move_textures(&mut self.material, old.as_deref(), folder) {
            if let Some(image) = self.textures.get(&old).cloned() {
                Arc::make_mut(&mut self.textures).insert(new, image);
            }
        }
    }

    /// Records that `path` now holds `saved`.
    pub fn set_saved(&mut self, path: PathBuf, saved: MaterialFile) {
        self.origin = Arc::new(Origin { path: Some(path), import: None, file: self.origin.file.clone(), saved: Arc::new(saved) });
        self.covers_unsaved = false;
    }

    /// What to call the document: its name, else its file, else `Untitled`.
    pub fn title(&self) -> String {
        if !self.material.name.is_empty() {
            return self.material.name.clone();
        }
        self.path().and_then(Path::file_name).map_or_else(|| "Untitled".into(), |name| name.to_string_lossy().into_owned())
    }
}

/// Which renderer's picture is shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ViewMode {
    /// The GPU's picture, at once.
    Preview,
    /// The path tracer's picture, refined.
    Final,
    /// Preview on the left, final on the right.
    #[default]
    Both,
    /// Preview left of a line, final right of it, in one picture.
    Wipe,
    /// How far both are apart, pixel by pixel.
    Difference,
}

impl ViewMode {
    /// All modes with their names.
    pub const ALL: [(Self, &'static str); 5] = [
        (Self::Preview, "Preview"),
        (Self::Final, "Final"),
        (Self::Both, "Both"),
        (Self::Wipe, "Wipe"),
        (Self::Difference, "Diff"),
    ];

    /// Whether the path tracer's picture is visible.
    pub fn has_final(self) -> bool {
        self != Self::Preview
    }

    /// Whether the GPU's picture is visible.
    pub fn has_preview(self) -> bool {
        self != Self::Final
    }
}

/// The camera as the user turns it: on a sphere about a point. Angles in degrees, lengths in scene units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Orbit {
    /// Point in the middle of the picture.
    pub target: Vec3,
    /// Angle about +Y; 0 looks along -Z.
    pub azimuth_deg: f32,
    /// Angle above the horizon.
    pub elevation_deg: f32,
    /// From the target.
    pub distance: f32,
    /// Vertical field of view.
    pub fov_deg: f32,
}

impl Default for Orbit {
    fn default() -> Self {
        Self {
            target: Vec3::ZERO,
            azimuth_deg: 0.0,
            elevation_deg: DEFAULT_ELEVATION_DEG,
            distance: 5.0,
            fov_deg: DEFAULT_FOV_DEG,
        }
    }
}

impl Orbit {
    /// The camera at this place for a picture of this aspect (width over height).
    ///
    /// In a picture that is higher than wide the field of view holds across, so that the object stays inside.
    pub fn camera(&self, aspect: f32) -> Camera {
        let half = (self.fov_deg.to_radians() * 0.5).tan() / aspect.clamp(0.05, 1.0);
        let fov_deg = 2.0 * half.atan().to_degrees();
        Camera::orbit(self.target, self.azimuth_deg, self.elevation_deg, self.distance, fov_deg)
    }

    /// The first look at a model: its own default camera.
    pub fn of_model(model: &ModelMeshes) -> Self {
        let mut orbit = Self::default();
        orbit.frame(model);
        orbit
    }

    /// Moves and zooms so that the object fills the picture; angles stay.
    pub fn frame(&mut self, model: &ModelMeshes) {
        let camera = model.default_camera();
        self.target = camera.target;
        self.distance = camera.origin.distance(camera.target).max(1e-6);
        self.fov_deg = camera.fov_deg;
    }

    /// Turns by a drag, in fractions of the picture's height.
    pub fn turn(&mut self, dx: f32, dy: f32) {
        self.azimuth_deg = (self.azimuth_deg - 240.0 * dx).rem_euclid(360.0);
        self.elevation_deg = (self.elevation_deg + 240.0 * dy).clamp(-89.0, 89.0);
    }

    /// Shifts the target so that it follows the pointer; in fractions of the picture's height.
    pub fn pan(&mut self, dx: f32, dy: f32) {
        let basis = self.camera(1.0).basis(1.0);
        let shift = (-dx * basis.right + dy * basis.up) * 2.0 * self.distance;
        if shift.is_finite() {
            self.target += shift;
        }
    }

    /// Comes closer for positive `amount`; 1 is a factor of e.
    pub fn zoom(&mut self, amount: f32) {
        self.distance = (self.distance * (-amount.clamp(-2.0, 2.0)).exp()).clamp(1e-4, 1e6);
    }
}

/// How the document is looked at. Not part of the document, and not undone.
#[derive(Clone, Debug)]
pub struct View {
    /// Which renderer's picture is shown.
    pub mode: ViewMode,
    /// Where the line of the wipe is, 0 to 1 of the width.
    pub wipe: f32,
    /// Point of view.
    pub orbit: Orbit,
    /// Exposure and display transform.
    pub display: Display,
    /// Rotation of the environment about +Y, degrees.
    pub environment_deg: f32,
    /// When the final view stops by itself.
    pub stop: StopRules,
    /// Whether the preview shows bloom where it stands alone.
    pub is_bloom_on: bool,
    /// Whether the final view is shown denoised.
    pub is_denoise_on: bool,
    /// Whether two pictures are the two sides, and not the two renderers.
    pub compares_sides: bool,
    /// Points of view to come back to.
    pub bookmarks: Vec<Orbit>,
    /// Whether anything but the view is shown.
    pub are_panels_shown: bool,
}

impl Default for View {
    fn default() -> Self {
        Self {
            mode: ViewMode::default(),
            wipe: 0.5,
            orbit: Orbit::default(),
            display: Display::default(),
            environment_deg: 0.0,
            // A still picture on a busy machine should end by itself; 0.5 % error is below what the eye sees.
            stop: StopRules { spp: Some(4096), seconds: None, relmse: Some(0.005 * 0.005) },
            is_bloom_on: false,
            is_denoise_on: false,
            compares_sides: false,
            bookmarks: Vec::new(),
            are_panels_shown: true,
        }
    }
}

/// The document, what it is shown on, and how.
#[derive(Clone, Debug)]
pub struct Editor {
    /// The material being edited.
    pub document: Document,
    /// How it is looked at.
    pub view: View,
    /// What carries the material; `None` while the first one is being made.
    pub model: Option<Arc<ModelMeshes>>,
    /// The same on what it brings itself.
    bare_model: Option<Arc<ModelMeshes>>,
    backdrop: Option<&'static BackdropDef>,
    /// What lights it; `None` while the first one is being made.
    pub environment: Option<Arc<Environment>>,
    /// Where the model and the environment came from, for pictures to say.
    pub places: [Option<Place>; 2],
}

impl Editor {
    /// An editor of a new material.
    pub fn new() -> Self {
        let document = Document::new(Material::named("New material"));
        Self {
            document,
            view: View::default(),
            model: None,
            bare_model: None,
            backdrop: None,
            environment: None,
            places: [None, None],
        }
    }

    /// The scene that both renderers draw, for pictures of this aspect; `None` while a part of it is being made.
    pub fn scene(&self, aspect: f32) -> Option<Scene> {
        self.scene_of(Arc::new(self.document.material.clone()), self.document.textures.clone(), aspect)
    }

    /// The same with another material.
    pub fn scene_of(&self, material: Arc<Material>, textures: Arc<TextureSet>, aspect: f32) -> Option<Scene> {
        let model = self.model.as_ref()?;
        let environment =
            EnvironmentLight { map: self.environment.clone()?, rotation_deg: self.view.environment_deg, scale: 1.0 };
        let mut scene = Scene::of_model(model, material, textures, environment, model.unit_mm);
        scene.camera = self.view.orbit.camera(aspect);
        Some(scene)
    }

    /// Shows another model, framed, on the backdrop that is chosen. The angles of the view stay.
    pub fn set_model(&mut self, model: ModelMeshes) {
        if self.model.is_none() {
            self.view.orbit = Orbit::of_model(&model);
        } else {
            self.view.orbit.frame(&model);
        }
        self.bare_model = Some(Arc::new(model));
        self.set_backdrop(self.backdrop);
    }

    /// Shows the model on another backdrop; `None`: on what it brings.
    pub fn set_backdrop(&mut self, backdrop: Option<&'static BackdropDef>) {
        self.backdrop = backdrop;
        self.model = match (&self.bare_model, backdrop) {
            (Some(model), Some(backdrop)) => Some(Arc::new(model.on(backdrop))),
            (model, _) => model.clone(),
        };
    }

    /// What the model stands on; `None`: on what it brings.
    pub fn backdrop(&self) -> Option<&'static BackdropDef> {
        self.backdrop
    }
}

impl Default for Editor {
    fn default() -> Self {
        Self::new()
    }
}
