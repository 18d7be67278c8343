//! How small pictures of materials are made: one scene, one size, one quality for all of them.

use super::entry::{Entry, reason};
use super::maker::Limits;
use crate::digest::{Digest, Digesting};
use crate::export::{Picture, png_bytes};
use crate::files;
use burnish_assets::{BackdropDef, ENVIRONMENTS, Mesh, SHAPES, make_shape};
use burnish_material::{DEFAULT_UNIT_MM, MAX_FILE_BYTES, Material, MaterialFile, Property, Value};
use burnish_renderer::PICTURE_VERSION;
use burnish_renderer::path::{Kept, Prepared, Progress, Rendering, Settings, StopReason, StopRules, render_prepared};
use burnish_renderer::scene::{EnvironmentLight, ModelMeshes, Object, Scene, TextureSet};
use burnish_renderer::tonemap::Display;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

/// Columns and rows unless something says otherwise.
pub const DEFAULT_SIDE: usize = 256;
/// Error at which pictures are done unless something says otherwise: 2 %.
pub const DEFAULT_RELMSE: f64 = 0.0004;
/// Seconds after which a picture is done in any case, unless something says otherwise.
pub const DEFAULT_SECONDS: f64 = 120.0;
/// Error at which a draft is done: 10 %.
const DRAFT_RELMSE: f64 = 0.01;
/// Seconds after which a draft is done in any case.
pub const DRAFT_SECONDS: f64 = 1.0;

/// What all pictures have in common.
#[derive(Clone, Debug)]
pub struct Setup {
    /// The scene; the material of its documents is replaced.
    scene: Scene,
    /// Whether lengths of materials are converted to those of the scene.
    has_unit: bool,
    /// Values that replace those of every material.
    set: Vec<(Property, Value)>,
    /// Columns, rows and random stream.
    frame: Frame,
    digest: Digest,
}

/// How pictures are taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// Columns, at least 1.
    pub width: usize,
    /// Rows, at least 1.
    pub height: usize,
    /// Error at which a picture is done, as relMSE.
    pub relmse: f64,
    /// Random stream.
    pub seed: u64,
    /// How radiance becomes colours.
    pub display: Display,
}

impl Default for Frame {
    fn default() -> Self {
        let (width, height) = (DEFAULT_SIDE, DEFAULT_SIDE);
        Self { width, height, relmse: DEFAULT_RELMSE, seed: 0, display: Display::default() }
    }
}

/// A scene to take pictures in.
#[derive(Clone, Debug)]
pub struct Stage {
    /// With any material on its documents, of the default unit.
    pub scene: Scene,
    /// The built-in mesh that it shows, if it does. Its name counts instead of its numbers, which processors may round differently.
    pub shape: Option<String>,
    /// What the mesh stands on, where that is not what it brings.
    pub backdrop: Option<&'static BackdropDef>,
    /// The built-in environment that it shows, if it does.
    pub environment: Option<String>,
    /// Whether lengths of materials are converted to those of the scene.
    pub has_unit: bool,
}

impl Stage {
    /// The first built-in mesh under the first built-in environment; `None` in a program without any.
    pub fn standard() -> Option<Self> {
        let (shape, environment) = (SHAPES.first()?, ENVIRONMENTS.first()?);
        let model: ModelMeshes = make_shape(shape.name)?.into();
        let light = EnvironmentLight { map: Arc::new((environment.make)()), rotation_deg: 0.0, scale: 1.0 };
        Some(Self {
            scene: Scene::of_model(&model, Arc::default(), Arc::default(), light, model.unit_mm),
            shape: Some(shape.name.to_owned()),
            backdrop: None,
            environment: Some(environment.name.to_owned()),
            has_unit: true,
        })
    }
}

/// A picture and how far it got.
#[derive(Clone, Debug)]
pub struct Made {
    /// Red, green and blue in sRGB, row by row from the top.
    pub rgb: Vec<u8>,
    /// The same as a file.
    pub png: Vec<u8>,
    /// Estimated error, if there are samples enough to tell.
    pub relmse: Option<f64>,
    /// Seconds of rendering, with preparing it last.
    pub seconds: f64,
    /// Samples per pixel.
    pub spp: u32,
    /// Why it ended.
    pub stop_reason: StopReason,
}

impl Setup {
    /// A setup; its hash is made once here.
    pub fn new(stage: Stage, frame: Frame, set: Vec<(Property, Value)>) -> Self {
        let digest = digest(&stage, &frame, &set);
        Self { scene: stage.scene, has_unit: stage.has_unit, set, frame, digest }
    }

    /// Hash of everything that pictures have in common, the quality included, but for time limit and threads.
    pub fn digest(&self) -> Digest {
        self.digest
    }

    /// The same in half the size and in a quality that is reached in a moment, to have something to look at before the real pictures.
    pub fn draft(&self) -> Self {
        let Frame { width, height, relmse, .. } = self.frame;
        let (width, height) = (width.div_ceil(2), height.div_ceil(2));
        let frame = Frame { width, height, relmse: relmse.max(DRAFT_RELMSE), ..self.frame };
        let digest = Digesting::default().text(&format!("draft of {}", self.digest)).end();
        Self { scene: self.scene.clone(), set: self.set.clone(), frame, digest, ..*self }
    }

    /// How pictures are taken.
    pub fn frame(&self) -> Frame {
        self.frame
    }

    /// The scene around a material.
    pub fn scene_of(&self, material: Material, textures: TextureSet) -> Scene {
        let mut material = material;
        for (property, value) in &self.set {
            material.set(*property, *value).slot_mut(*property).texture = None;
        }
        let (material, textures) = (Arc::new(material), Arc::new(textures));
        let mut scene = self.scene.clone();
        for object in scene.objects.iter_mut().filter(|object| object.is_document) {
            if self.has_unit {
                object.length_scale *= material.unit_mm() / DEFAULT_UNIT_MM;
            }
            (object.material, object.textures) = (material.clone(), textures.clone());
        }
        scene
    }

    /// Renders a scene, from its beginning or from where that was put aside, until its error is small enough, a limit is reached or `go_on` says no
    /// after a pass.
    ///
    /// What the scene shares with `last` is taken from there; it becomes that scene.
    pub fn expose(
        &self,
        scene: &Scene,
        last: &mut Option<Prepared>,
        begun: Option<Kept>,
        limits: Limits,
        go_on: &mut dyn FnMut(&Progress<'_>) -> bool,
    ) -> Rendering {
        let start = Instant::now();
        let prepared = &*last.insert(Prepared::new(scene, last.as_ref()));
        let Frame { width, height, relmse, seed, .. } = self.frame;
        let stop = StopRules { spp: None, seconds: Some(limits.seconds), relmse: Some(relmse) };
        let settings = Settings { width, height, seed, threads: limits.threads, stop, is_adaptive: true };
        // What was begun in another size is of no use.
        let further = begun.and_then(|begun| begun.go_on(prepared, &settings, start, go_on).ok());
        further.unwrap_or_else(|| render_prepared(prepared, &settings, start, go_on))
    }

    /// The picture that was rendered. An error if it cannot become a file.
    pub fn develop(&self, rendering: &Rendering) -> Result<Made, String> {
        let Frame { width, height, display, .. } = self.frame;
        let pixels: Vec<[f32; 4]> = rendering.film.mean().iter().map(|[r, g, b]| [*r, *g, *b, 1.0]).collect();
        let rgb = pixels.iter().flat_map(|[r, g, b, _]| display.apply_u8([*r, *g, *b])).collect();
        let png = png_bytes(&Picture { width, height, pixels, ..Picture::default() }, display)?;
        Ok(Made {
            rgb,
            png,
            relmse: rendering.error.map(|error| error.relmse),
            seconds: rendering.load_seconds + rendering.seconds,
            spp: rendering.film.spp(),
            stop_reason: rendering.stop_reason,
        })
    }
}

/// The result of work on one material; an error if it panics, so that the others can go on.
pub fn guarded<T>(work: impl FnOnce() -> Result<T, String>) -> Result<T, String> {
    catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|_| Err("no picture, because the program failed at it".to_owned()))
}

/// Why there is no picture of a file that has changed since: nothing that anybody has to do something about.
pub const CHANGED: &str = "was changed after the library had been read; its picture comes with the next reading";

/// Reads the material of an entry with its images. An error, without the path, if it cannot be used or is not what the entry is about any more.
///
/// Images that cannot be read are left out, as in every view; a sentence tells of each.
pub fn read(root: &Path, entry: &Entry) -> Result<(Material, TextureSet, Vec<String>), String> {
    if let Some(problem) = &entry.problem {
        return Err(problem.clone());
    }
    let path = root.join(&entry.path);
    let text = files::read_text_file(&path, MAX_FILE_BYTES as u64).map_err(|error| reason(&error, &path))?;
    if Digest::of(text.as_bytes()) != entry.bytes {
        return Err(CHANGED.to_owned());
    }
    let (file, _) = MaterialFile::parse(&text).map_err(|error| error.to_string())?;
    let (textures, missing) = files::load_textures(file.material(), path.parent());
    Ok((file.material().clone(), textures, missing))
}

fn digest(stage: &Stage, frame: &Frame, set: &[(Property, Value)]) -> Digest {
    let Scene { objects, environment, camera, max_bounces } = &stage.scene;
    let mut all = Digesting::default();
    let Frame { width, height, relmse, seed, display } = *frame;
    all.whole(&[u64::from(PICTURE_VERSION), width as u64, height as u64, seed, u64::from(*max_bounces)]);
    all.numbers(&[relmse, f64::from(display.exposure_ev)]).text(&display.transform.to_string());
    for (property, value) in set {
        all.text(property.def().name).text(&format!("{value:?}"));
    }
    // Processors may round the last digits of a camera that was placed by angles differently.
    let distance = camera.origin.distance(camera.target).max(f32::MIN_POSITIVE);
    let place = [camera.origin / distance, camera.target / distance, camera.up].map(|v| (v * 1e3).round().to_array());
    let place: Vec<i64> = place.as_flattened().iter().map(|x| *x as i64).collect();
    all.text(&format!("{place:?} {distance:.3e} {:.3}", camera.fov_deg));
    all.numbers(&[environment.rotation_deg, environment.scale].map(f64::from));
    match &stage.environment {
        Some(name) => all.text(name),
        None => all.whole(&[environment.map.width as u64]).bytes(&floats(environment.map.texels.iter().flatten())),
    };
    match &stage.shape {
        Some(name) => _ = all.text(name),
        None => objects.iter().for_each(|object| add_object(&mut all, object)),
    }
    if let Some(backdrop) = stage.backdrop {
        all.text("backdrop").text(backdrop.name);
    }
    for object in objects {
        all.text(&format!("{:.5e}", object.length_scale));
    }
    all.whole(&[u64::from(stage.has_unit)]).end()
}

fn add_object(all: &mut Digesting, object: &Object) {
    let Mesh { name: _, positions, normals, tangents, uvs, triangles } = &*object.mesh;
    all.bytes(&floats(positions.iter().flat_map(|v| v.as_ref()))).bytes(&floats(normals.iter().flat_map(|v| v.as_ref())));
    all.bytes(&floats(tangents.iter().flat_map(|v| v.as_ref()))).bytes(&floats(uvs.iter().flat_map(|v| v.as_ref())));
    all.bytes(&triangles.iter().flatten().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>());
    all.whole(&[u64::from(object.is_document)]);
    if !object.is_document {
        all.text(MaterialFile::new(&object.material).text());
    }
}

fn floats<'a>(numbers: impl Iterator<Item = &'a f32>) -> Vec<u8> {
    numbers.flat_map(|x| x.to_le_bytes()).collect()
}
