//! Options that say what is drawn: mesh, light, camera, changed values, size. Shared by all commands that render.

use super::material_argument::{self, LoadedMaterial};
use super::set::{Assignment, parse_number, parse_triple};
use super::{CliError, Messages, interrupt, suggest};
pub use crate::offline::loaded_scene::LoadedScene;

use crate::exchange::{is_mesh_path, load_mesh};
use crate::offline::loaded_scene::Origin;
use crate::picture_job::Place;
use crate::scene_file::{DOCUMENT_MATERIAL, MAX_PIXELS, MAX_SIDE, MAX_TILED_PIXELS, load_scene};
use burnish_assets::{
    BACKDROPS, BackdropDef, ENVIRONMENTS, Environment, Model, Progress, SHAPES, is_environment_path, load_environment,
    make_environment, make_shape,
};
use burnish_renderer::scene::{Camera, EnvironmentLight, ModelMeshes, Object, Scene};
use clap::Args;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Width and height unless something says otherwise.
pub const DEFAULT_SIDE: usize = 512;
/// Shorter and longer distances overflow where lengths are squared in single precision.
const CAMERA_DISTANCES: std::ops::RangeInclusive<f64> = 1e-15..=1e15;
const MAX_THREADS: usize = 1024;

/// What is drawn, and how large.
#[derive(Clone, Debug, Default, PartialEq, Args)]
#[command(next_help_heading = "Scene")]
pub struct SceneOptions {
    /// Which material of a file with several, by name or number from 1 [default: the first]
    #[arg(long = "material", value_name = "NAME|INDEX")]
    pub choice: Option<String>,
    /// Built-in mesh, or a .gltf, .glb or .ply file
    #[arg(long, value_name = "NAME|FILE", conflicts_with = "scene")]
    pub mesh: Option<String>,
    /// What the mesh stands on [default: what it brings: tiles for most built-in ones, nothing for files]
    #[arg(long, value_name = "none|tiles|grey-sweep", conflicts_with = "scene", value_parser = backdrop)]
    pub backdrop: Option<&'static BackdropDef>,
    /// Built-in environment, or a latitude-longitude .hdr or .exr file
    #[arg(long, value_name = "NAME|FILE")]
    pub environment: Option<String>,
    /// Turns the environment counterclockwise, seen from above
    #[arg(long, value_name = "DEG", allow_hyphen_values = true, value_parser = finite)]
    pub rotate_environment: Option<f64>,
    /// Stops by which PNG and preview are brighter; EXR keeps the radiance as it is
    #[arg(long, value_name = "EV", allow_hyphen_values = true, value_parser = finite)]
    pub exposure: Option<f64>,
    /// Orbit around the object in degrees, and distance in scene units; 0,0 looks from the front
    #[arg(long, value_name = "AZ,EL,DIST", allow_hyphen_values = true, value_parser = orbit)]
    pub camera: Option<Orbit>,
    /// Full vertical angle of view, 0.1 to 179 degrees; the camera stays where it is
    #[arg(long, value_name = "DEG", allow_hyphen_values = true, value_parser = field_of_view)]
    pub fov: Option<f64>,
    /// Scattering events after the first hit, at most
    #[arg(long, value_name = "N", allow_hyphen_values = true, value_parser = bounces)]
    pub max_bounces: Option<u32>,
    /// Sets a property by formal name or usage string; colours as r,g,b (linear) or #rrggbb (sRGB). Repeatable
    #[arg(long, value_name = "PROPERTY=VALUE", allow_hyphen_values = true, value_parser = Assignment::parse)]
    pub set: Vec<Assignment>,
    /// Threads that render [default: all]
    #[arg(long, value_name = "N", allow_hyphen_values = true, value_parser = threads)]
    pub threads: Option<usize>,
    /// Random stream; equal seeds give equal pictures
    #[arg(long, value_name = "N", default_value_t = 0, allow_hyphen_values = true, value_parser = seed)]
    pub seed: u64,
    /// Size of the picture, at most 16384 pixels a side and 16777216 (2^24) in all; of `render` 67108864 (2^26), in tiles [default: 512x512, or that of the scene file]
    #[arg(long, value_name = "WxH", allow_hyphen_values = true, value_parser = size)]
    pub size: Option<(usize, usize)>,
    /// Whole scene as asm-bench-scene/1 JSON; its material `test` is the one that MATERIAL replaces
    #[arg(long, value_name = "FILE")]
    pub scene: Option<PathBuf>,
    /// Millimetres per scene unit [default: what the mesh file says, else 100]
    #[arg(long, value_name = "MM", allow_hyphen_values = true, value_parser = positive)]
    pub unit_mm: Option<f64>,
}

/// Where the camera stands around the object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Orbit {
    azimuth_deg: f32,
    elevation_deg: f32,
    distance: f32,
}

impl SceneOptions {
    /// How many threads render.
    pub fn threads(&self) -> usize {
        self.threads.unwrap_or_else(|| std::thread::available_parallelism().map_or(1, std::num::NonZero::get)).min(MAX_THREADS)
    }

    /// Exposure in stops, 0 unless given.
    pub fn exposure_ev(&self) -> f32 {
        self.exposure.unwrap_or(0.0) as f32
    }

    /// Loads everything and applies the options. `material` may be left out with `--scene`, or if there is a default.
    pub fn load(
        &self,
        material: Option<&str>,
        default: Option<LoadedMaterial>,
        messages: &mut Messages,
    ) -> Result<LoadedScene, CliError> {
        let loaded = self.load_tiled(material, default, messages)?;
        if loaded.width * loaded.height > MAX_PIXELS {
            let (width, height) = (loaded.width, loaded.height);
            return Err(CliError::unusable(format!(
                "--size: expected at most {MAX_PIXELS} (2^24) pixels in all, found {width} x {height}"
            )));
        }
        Ok(loaded)
    }

    /// [`Self::load`] for whoever renders large pictures in tiles.
    pub fn load_tiled(
        &self,
        material: Option<&str>,
        default: Option<LoadedMaterial>,
        messages: &mut Messages,
    ) -> Result<LoadedScene, CliError> {
        let choice = self.choice.as_deref();
        if let (None, Some(wanted)) = (material, choice) {
            return Err(CliError::unusable(format!("--material {wanted}: expected a file with several materials before it")));
        }
        let material = material.map(|text| material_argument::load(text, choice, messages)).transpose()?.or(default);
        interrupt::check()?;
        let mut origin = Origin {
            replaces_material: material.is_some() || !self.set.is_empty(),
            unit_mm: self.unit_mm,
            scene: self.scene.clone(),
            ..Origin::default()
        };
        if let Some(material) = &material {
            (origin.file, origin.texture_files) = (material.file.clone(), material.texture_files.clone());
        }
        let (mut scene, size) = match (&self.scene, material) {
            (Some(path), material) => self.scene_of_file(path, material, &mut origin, messages)?,
            (None, Some(material)) => (self.scene_of_model(material, &mut origin, messages)?, (DEFAULT_SIDE, DEFAULT_SIDE)),
            (None, None) => {
                let expected = "expected MATERIAL (an .asm.ron file or preset:NAME) or --scene FILE";
                return Err(CliError::unusable(expected));
            }
        };
        interrupt::check()?;
        self.change(&mut scene, messages)?;
        let (width, height) = self.size.unwrap_or(size);
        // An image that a value took the place of is not needed any more.
        let is_named = |name: &str| {
            let mut slots = scene.objects.iter().filter(|object| object.is_document).flat_map(|object| object.material.slots());
            slots.any(|(_, slot)| slot.texture.as_ref().is_some_and(|texture| texture.path == name))
        };
        origin.texture_files.retain(|(name, _)| is_named(name));
        Ok(LoadedScene { scene, width, height, origin })
    }

    /// The default scene, or what the options make of it, around a material.
    fn scene_of_model(&self, material: LoadedMaterial, origin: &mut Origin, messages: &mut Messages) -> Result<Scene, CliError> {
        let model = self.model(origin, messages)?;
        origin.backdrop = self.backdrop;
        let model = self.backdrop.map_or_else(|| model.clone(), |backdrop| model.on(backdrop));
        let map = match &self.environment {
            Some(text) => environment(text, origin, messages)?,
            None => {
                let def = ENVIRONMENTS.first().ok_or_else(|| CliError::unusable("there is no environment"))?;
                origin.environment = Some(Place::BuiltIn(def.name.to_owned()));
                (def.make)()
            }
        };
        let light = EnvironmentLight { map: Arc::new(map), rotation_deg: 0.0, scale: 1.0 };
        let unit_mm = self.unit_mm.unwrap_or(model.unit_mm);
        let mut scene = Scene::of_model(&model, material.material, material.textures, light, unit_mm);
        if let Some(orbit) = self.camera {
            scene.camera = orbit.around(model.object_bounds.center(), scene.camera.fov_deg);
        }
        Ok(scene)
    }

    fn model(&self, origin: &mut Origin, messages: &mut Messages) -> Result<ModelMeshes, CliError> {
        let name = self.mesh.as_deref().or(SHAPES.first().map(|def| def.name));
        let model: Model = match name {
            None => return Err(CliError::unusable("there is no mesh")),
            Some(text) => match make_shape(text) {
                Some(model) => {
                    origin.mesh = Some(Place::BuiltIn(text.to_owned()));
                    model
                }
                None => {
                    let path = existing("--mesh", text, is_mesh_path(Path::new(text)), SHAPES.iter().map(|def| def.name))?;
                    origin.mesh = Some(Place::File(path.to_path_buf()));
                    let (model, warnings) = load_mesh(path, Progress::NONE).map_err(CliError::unusable)?;
                    warnings.iter().for_each(|warning| messages.warn_about(path, warning));
                    model
                }
            },
        };
        Ok(model.into())
    }

    fn scene_of_file(
        &self,
        path: &Path,
        material: Option<LoadedMaterial>,
        origin: &mut Origin,
        messages: &mut Messages,
    ) -> Result<(Scene, (usize, usize)), CliError> {
        let (file, warnings) = load_scene(path).map_err(CliError::unusable)?;
        warnings.into_iter().for_each(|warning| messages.warn(warning));
        let mut scene = file.scene;
        origin.assets = file.files;
        match material {
            Some(material) => {
                // Lengths are taken as they stand unless the user says how large the scene is.
                let length_scale = self.unit_mm.map_or(1.0, |scene_mm| material.material.unit_mm() / scene_mm);
                for object in self.documents(&mut scene)? {
                    object.material = material.material.clone();
                    object.textures = material.textures.clone();
                    object.length_scale = length_scale;
                }
            }
            None if self.unit_mm.is_some() => {
                messages.warn("--unit-mm has no effect: lengths in a scene file are taken as they stand")
            }
            None => {}
        }
        if let Some(text) = &self.environment {
            scene.environment =
                EnvironmentLight { map: Arc::new(environment(text, origin, messages)?), rotation_deg: 0.0, scale: 1.0 };
        }
        if let Some(orbit) = self.camera {
            scene.camera = orbit.around(scene.camera.target, scene.camera.fov_deg);
        }
        Ok((scene, (file.width, file.height)))
    }

    /// The objects that carry the document; an error where there is none to change.
    fn documents<'a>(&self, scene: &'a mut Scene) -> Result<impl Iterator<Item = &'a mut Object>, CliError> {
        if scene.objects.iter().all(|object| !object.is_document) {
            let file = self.scene.as_deref().unwrap_or(Path::new("the scene")).display();
            return Err(CliError::unusable(format!(
                "{file}: objects: expected one with the material `{DOCUMENT_MATERIAL}`, found none"
            )));
        }
        Ok(scene.objects.iter_mut().filter(|object| object.is_document))
    }

    /// Applies what holds for scenes of any origin.
    fn change(&self, scene: &mut Scene, messages: &mut Messages) -> Result<(), CliError> {
        if let Some(fov) = self.fov {
            scene.camera.fov_deg = fov as f32;
        }
        if let Some(deg) = self.rotate_environment {
            scene.environment.rotation_deg = deg.rem_euclid(360.0) as f32;
        }
        if let Some(bounces) = self.max_bounces {
            scene.max_bounces = bounces;
        }
        if !self.set.is_empty() {
            for object in self.documents(scene)? {
                let material = Arc::make_mut(&mut object.material);
                for note in self.set.iter().flat_map(|assignment| assignment.apply(material)) {
                    messages.warn(note);
                }
            }
        }
        Ok(())
    }
}

impl Orbit {
    fn around(self, target: glam::Vec3, fov_deg: f32) -> Camera {
        Camera::orbit(target, self.azimuth_deg, self.elevation_deg, self.distance, fov_deg)
    }
}

fn environment(text: &str, origin: &mut Origin, messages: &mut Messages) -> Result<Environment, CliError> {
    if let Some(made) = make_environment(text) {
        origin.environment = Some(Place::BuiltIn(text.to_owned()));
        return Ok(made);
    }
    let path = existing("--environment", text, is_environment_path(Path::new(text)), ENVIRONMENTS.iter().map(|def| def.name))?;
    origin.environment = Some(Place::File(path.to_path_buf()));
    let (map, warnings) = load_environment(path).map_err(CliError::unusable)?;
    warnings.iter().for_each(|warning| messages.warn_about(path, warning));
    Ok(map)
}

/// A path, unless the text is neither a file nor has the ending of one: then a name was meant.
fn existing<'a>(
    option: &str,
    text: &'a str,
    has_ending: bool,
    known: impl Iterator<Item = &'static str> + Clone,
) -> Result<&'a Path, CliError> {
    let path = Path::new(text);
    if has_ending || path.exists() {
        return Ok(path);
    }
    let names: Vec<&str> = known.clone().collect();
    let hint = suggest::hint(text, known);
    Err(CliError::unusable(format!("{option}: expected a file or one of {}, found `{text}`{hint}", names.join(", "))))
}

/// A finite number, for options.
pub fn finite(text: &str) -> Result<f64, String> {
    parse_number(text).ok_or_else(|| "expected a finite number".to_owned())
}

/// A finite number above 0, for options.
pub fn positive(text: &str) -> Result<f64, String> {
    parse_number(text).filter(|x| *x > 0.0).ok_or_else(|| "expected a number above 0".to_owned())
}

fn backdrop(text: &str) -> Result<&'static BackdropDef, String> {
    let names = || BACKDROPS.iter().map(|def| def.name).collect::<Vec<_>>().join(", ");
    BackdropDef::named(text).ok_or_else(|| format!("expected one of {}", names()))
}

fn field_of_view(text: &str) -> Result<f64, String> {
    parse_number(text).filter(|x| (0.1..=179.0).contains(x)).ok_or_else(|| "expected an angle of 0.1 to 179 degrees".to_owned())
}

pub(super) fn threads(text: &str) -> Result<usize, String> {
    let threads = text.parse().ok().filter(|n| (1..=MAX_THREADS).contains(n));
    threads.ok_or_else(|| format!("expected a whole number, 1 to {MAX_THREADS}"))
}

fn bounces(text: &str) -> Result<u32, String> {
    text.parse().map_err(|_| format!("expected a whole number, 0 to {}", u32::MAX))
}

fn seed(text: &str) -> Result<u64, String> {
    text.parse().map_err(|_| format!("expected a whole number, 0 to {}", u64::MAX))
}

fn orbit(text: &str) -> Result<Orbit, String> {
    let orbit = parse_triple(text)
        .filter(|[_, elevation, distance]| (*elevation as f32).is_finite() && CAMERA_DISTANCES.contains(distance));
    let orbit = orbit.map(|[azimuth, elevation, distance]| Orbit {
        azimuth_deg: azimuth.rem_euclid(360.0) as f32,
        elevation_deg: elevation as f32,
        distance: distance as f32,
    });
    orbit.ok_or_else(|| {
        let (nearest, farthest) = CAMERA_DISTANCES.into_inner();
        format!("expected AZIMUTH,ELEVATION,DISTANCE in degrees and scene units, distance {nearest:e} to {farthest:e}")
    })
}

/// Columns and rows of a picture, for options.
pub fn size(text: &str) -> Result<(usize, usize), String> {
    let read = text.split_once(['x', 'X']).and_then(|(w, h)| Some((w.trim().parse().ok()?, h.trim().parse().ok()?)));
    read.filter(|(w, h)| (1..=MAX_SIDE).contains(w) && (1..=MAX_SIDE).contains(h) && w * h <= MAX_TILED_PIXELS)
        .ok_or_else(|| format!("expected WIDTHxHEIGHT in pixels, each 1 to {MAX_SIDE}, at most {MAX_TILED_PIXELS} (2^26) in all"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_and_cameras_are_read_or_refused() {
        assert_eq!(size("64x32"), Ok((64, 32)));
        for text in ["", "64", "0x5", "64x", "x64", "-1x5", "99999x1", "16384x16384", "8192x8193", "1e3x5"] {
            assert!(size(text).is_err(), "{text}");
        }
        assert_eq!(orbit("-90, 10,5").map(|o| (o.azimuth_deg, o.elevation_deg, o.distance)), Ok((270.0, 10.0, 5.0)));
        for text in ["", "1,2", "1,2,0", "1,2,-3", "a,b,c", "1,2,3,4", "NaN,0,1", "0,1e300,1", "0,0,1e39", "0,0,1e-300"] {
            assert!(orbit(text).is_err(), "{text}");
        }
    }

    #[test]
    fn unknown_names_list_the_known_ones() {
        let mut messages = Messages::default();
        let options = SceneOptions { mesh: Some("no-such-mesh".to_owned()), ..SceneOptions::default() };
        let error =
            options.load(Some(&format!("preset:{}", burnish_presets::presets()[0].name)), None, &mut messages).unwrap_err();
        assert!(error.to_string().contains(SHAPES[0].name), "{error}");
        let error = environment("studi", &mut Origin::default(), &mut messages).unwrap_err();
        assert!(error.to_string().contains("did you mean `studio`"), "{error}");
        let error = environment("missing.exr", &mut Origin::default(), &mut messages).unwrap_err();
        assert!(error.to_string().starts_with("missing.exr"), "{error}");
    }
}
