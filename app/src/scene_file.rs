//! Reads whole scenes in the neutral `asm-bench-scene/1` JSON: camera, film, environment, meshes and materials.
//!
//! Paths in a scene start at the folder above its file. Lengths are taken as they stand. What other renderers are told
//! about the same materials is not looked at.

use crate::files::{FilesError, read_text_file};
use burnish_assets::{AssetError, load_environment, load_model};
use burnish_material::{Kind, Material, PROPERTIES, Value as MaterialValue};
use burnish_renderer::scene::{Camera, DEFAULT_MAX_BOUNCES, EnvironmentLight, Object, Scene, TextureSet};
use glam::Vec3;
use serde_json::Value;
use std::collections::BTreeMap;
use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The value of `schema` in files that this module reads.
pub const SCHEMA: &str = "asm-bench-scene/1";

/// Name of the material that stands for the document's.
pub const DOCUMENT_MATERIAL: &str = "test";

/// Largest width or height of a picture.
pub const MAX_SIDE: usize = 16_384;

/// Most pixels that are rendered at a time, 2^24: a film needs 212 bytes for each, so that more would not fit into most machines.
pub const MAX_PIXELS: usize = 1 << 24;

/// Most pixels of a picture that is rendered in tiles, 2^26: that of 8192 x 8192.
pub const MAX_TILED_PIXELS: usize = 1 << 26;

/// Larger scene files are refused: they hold names and numbers, while meshes have files of their own.
const MAX_SCENE_BYTES: u64 = 64 << 20;

/// A scene and the size of its picture.
#[derive(Clone, Debug)]
pub struct SceneFile {
    /// What is drawn; objects with the material `test` carry the document.
    pub scene: Scene,
    /// Pixels.
    pub width: usize,
    /// Pixels.
    pub height: usize,
    /// The meshes and environments that it names.
    pub files: Vec<PathBuf>,
}

/// Why a scene could not be read; shown to the user as one sentence.
#[derive(Debug)]
pub enum SceneFileError {
    /// The file cannot be read as text.
    File(FilesError),
    /// The text is not JSON.
    NotJson {
        /// The scene file.
        path: PathBuf,
        /// Where and why.
        source: serde_json::Error,
    },
    /// A value is missing or not what was expected.
    Unexpected {
        /// The scene file.
        path: PathBuf,
        /// Keys from the top, such as `camera.fov_deg`.
        key: String,
        /// What was expected and found.
        problem: String,
    },
    /// A mesh or environment could not be loaded.
    Asset {
        /// The scene file.
        path: PathBuf,
        /// Key that names the asset.
        key: String,
        /// Why.
        source: Box<AssetError>,
    },
}

impl fmt::Display for SceneFileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File(source) => source.fmt(f),
            Self::NotJson { path, source } => write!(f, "{}: expected a scene as JSON: {source}", path.display()),
            Self::Unexpected { path, key, problem } => write!(f, "{}: {key}: {problem}", path.display()),
            Self::Asset { path, key, source } => write!(f, "{}: {key}: {source}", path.display()),
        }
    }
}

impl std::error::Error for SceneFileError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Self::File(source) => Some(source),
            Self::NotJson { source, .. } => Some(source),
            Self::Asset { source, .. } => Some(source.as_ref()),
            Self::Unexpected { .. } => None,
        }
    }
}

/// Reads a scene with everything it names, and sentences about what has no effect here.
pub fn load_scene(path: &Path) -> Result<(SceneFile, Vec<String>), SceneFileError> {
    let text = read_text_file(path, MAX_SCENE_BYTES).map_err(SceneFileError::File)?;
    let json: Value =
        serde_json::from_str(&text).map_err(|source| SceneFileError::NotJson { path: path.to_path_buf(), source })?;
    let mut reader = Reader { path, folder: folder_above(path), warnings: Vec::new(), files: Vec::new() };
    let scene = reader.scene(&json)?;
    Ok((scene, reader.warnings))
}

/// The folder above the one that holds the scene.
fn folder_above(path: &Path) -> PathBuf {
    let folder = path.parent().unwrap_or(Path::new(""));
    // A bare name has no folder to go up from, and `scenes/..` also holds where `scenes` is a link.
    folder.join("..")
}

/// A value with the keys that lead to it.
#[derive(Clone)]
struct Node<'a> {
    value: &'a Value,
    key: String,
}

impl<'a> Node<'a> {
    fn child(&self, key: &str) -> Option<Self> {
        let value = self.value.get(key).filter(|value| !value.is_null())?;
        let key = if self.key.is_empty() { key.to_owned() } else { format!("{}.{key}", self.key) };
        Some(Self { value, key })
    }

    fn numbers<const N: usize>(&self) -> Option<[f64; N]> {
        let numbers: Option<Vec<f64>> = self.value.as_array()?.iter().map(Value::as_f64).collect();
        numbers?.try_into().ok()
    }
}

struct Reader<'a> {
    path: &'a Path,
    folder: PathBuf,
    warnings: Vec<String>,
    files: Vec<PathBuf>,
}

impl Reader<'_> {
    fn unexpected(&self, key: &str, problem: impl Into<String>) -> SceneFileError {
        SceneFileError::Unexpected { path: self.path.to_path_buf(), key: key.to_owned(), problem: problem.into() }
    }

    fn expected(&self, node: &Node, expected: &str) -> SceneFileError {
        self.unexpected(&node.key, format!("expected {expected}, found {}", shortened(node.value)))
    }

    fn required<'a>(&self, node: &Node<'a>, key: &str) -> Result<Node<'a>, SceneFileError> {
        node.child(key).ok_or_else(|| {
            let key = if node.key.is_empty() { key.to_owned() } else { format!("{}.{key}", node.key) };
            self.unexpected(&key, "expected a value, found none")
        })
    }

    fn warn(&mut self, key: &str, sentence: &str) {
        self.warnings.push(format!("{}: {key}: {sentence}", self.path.display()));
    }

    fn scene(&mut self, json: &Value) -> Result<SceneFile, SceneFileError> {
        let top = Node { value: json, key: String::new() };
        let schema = self.required(&top, "schema")?;
        if schema.value.as_str() != Some(SCHEMA) {
            return Err(self.expected(&schema, &format!("\"{SCHEMA}\"")));
        }
        let camera = self.camera(&self.required(&top, "camera")?)?;
        let (width, height) = self.film(&top)?;
        let max_bounces = self.max_bounces(&top)?;
        let environment = self.environment(&self.required(&top, "environment")?)?;
        let materials = self.materials(&self.required(&top, "materials")?)?;
        let objects = self.objects(&self.required(&top, "objects")?, &materials)?;
        let files = std::mem::take(&mut self.files);
        Ok(SceneFile { scene: Scene { objects, environment, camera, max_bounces }, width, height, files })
    }

    fn camera(&self, node: &Node) -> Result<Camera, SceneFileError> {
        if let Some(kind) = node.child("type").filter(|kind| kind.value.as_str() != Some("pinhole")) {
            return Err(self.expected(&kind, "\"pinhole\""));
        }
        let origin = self.vector(&self.required(node, "origin")?)?;
        let target = self.vector(&self.required(node, "target")?)?;
        let up = node.child("up").map_or(Ok(Vec3::Y), |up| self.vector(&up))?;
        let fov = self.required(node, "fov_deg")?;
        let fov_deg = fov.value.as_f64().filter(|deg| (0.1..=179.0).contains(deg));
        let fov_deg = fov_deg.ok_or_else(|| self.expected(&fov, "an angle of 0.1 to 179 degrees"))? as f32;
        if (target - origin).cross(up).try_normalize().is_none() {
            return Err(self.unexpected(&node.key, "expected a target apart from the origin and an up direction across the view"));
        }
        Ok(Camera { origin, target, up, fov_deg })
    }

    fn vector(&self, node: &Node) -> Result<Vec3, SceneFileError> {
        let vector = node.numbers().map(|v: [f64; 3]| Vec3::from_array(v.map(|x| x as f32))).filter(|v| v.is_finite());
        vector.ok_or_else(|| self.expected(node, "three numbers [x, y, z]"))
    }

    fn film(&mut self, top: &Node) -> Result<(usize, usize), SceneFileError> {
        let film = self.required(top, "film")?;
        let side = |key: &str| {
            let node = self.required(&film, key)?;
            let side =
                node.value.as_u64().and_then(|side| usize::try_from(side).ok()).filter(|side| (1..=MAX_SIDE).contains(side));
            side.ok_or_else(|| self.expected(&node, &format!("pixels, 1 to {MAX_SIDE}")))
        };
        let size = (side("width")?, side("height")?);
        if size.0 * size.1 > MAX_PIXELS {
            let problem = format!("expected at most {MAX_PIXELS} pixels in all, found {} x {}", size.0, size.1);
            return Err(self.unexpected("film.width", problem));
        }
        let is_box = film.child("filter").is_none_or(|filter| filter.value.as_str() == Some("box"));
        let is_pixel = film.child("filter_width_px").is_none_or(|width| width.value.as_f64() == Some(1.0));
        if !is_box || !is_pixel {
            self.warn("film.filter", "a box of one pixel is used instead");
        }
        Ok(size)
    }

    fn max_bounces(&mut self, top: &Node) -> Result<u32, SceneFileError> {
        let Some(integrator) = top.child("integrator") else { return Ok(DEFAULT_MAX_BOUNCES) };
        if integrator.child("clamp").is_some() {
            self.warn("integrator.clamp", "samples are not clamped; it has no effect");
        }
        for key in ["denoise", "adaptive"] {
            if integrator.child(key).is_some_and(|node| node.value.as_bool() == Some(true)) {
                self.warn(&format!("integrator.{key}"), "it has no effect");
            }
        }
        let Some(node) = integrator.child("max_bounces") else { return Ok(DEFAULT_MAX_BOUNCES) };
        let bounces = node.value.as_u64().and_then(|n| u32::try_from(n).ok());
        bounces.ok_or_else(|| self.expected(&node, "a whole number, 0 or more"))
    }

    fn environment(&mut self, node: &Node) -> Result<EnvironmentLight, SceneFileError> {
        const MAPPING: &str = "latlong_yup_center_plus_z";
        if let Some(mapping) = node.child("mapping").filter(|mapping| mapping.value.as_str() != Some(MAPPING)) {
            return Err(self.expected(&mapping, &format!("\"{MAPPING}\"")));
        }
        let scale = match node.child("scale") {
            None => 1.0,
            Some(scale) => {
                let number = scale.value.as_f64().map(|x| x as f32).filter(|x| x.is_finite() && *x >= 0.0);
                number.ok_or_else(|| self.expected(&scale, "a factor of 0 or more"))?
            }
        };
        let file = self.required(node, "file")?;
        let path = self.file(&file)?;
        self.files.push(path.clone());
        let (map, warnings) = load_environment(&path).map_err(|source| self.asset(&file, source))?;
        self.warnings.extend(warnings);
        Ok(EnvironmentLight { map: Arc::new(map), rotation_deg: 0.0, scale })
    }

    fn file(&self, node: &Node) -> Result<PathBuf, SceneFileError> {
        let name = node.value.as_str().ok_or_else(|| self.expected(node, "a path"))?;
        Ok(self.folder.join(name))
    }

    fn asset(&self, node: &Node, source: AssetError) -> SceneFileError {
        SceneFileError::Asset { path: self.path.to_path_buf(), key: node.key.clone(), source: Box::new(source) }
    }

    fn materials(&mut self, node: &Node) -> Result<BTreeMap<String, Arc<Material>>, SceneFileError> {
        let entries = node.value.as_object().ok_or_else(|| self.expected(node, "materials by name"))?;
        let mut materials = BTreeMap::new();
        for name in entries.keys() {
            let entry = self.required(node, name)?;
            let material = self.material(name, &self.required(&entry, "asm")?)?;
            materials.insert(name.clone(), Arc::new(material));
        }
        Ok(materials)
    }

    /// A material from property names or usage strings.
    fn material(&mut self, name: &str, asm: &Node) -> Result<Material, SceneFileError> {
        let entries = asm.value.as_object().ok_or_else(|| self.expected(asm, "values by property name or usage string"))?;
        let mut material = Material::named(name);
        for key in entries.keys() {
            // `null` says as little as an absent key.
            let Some(node) = asm.child(key) else { continue };
            let Some(def) = PROPERTIES.iter().find(|def| def.is_named(key)) else {
                self.warn(&node.key, "is no property and has no effect");
                continue;
            };
            let kind = def.default.kind();
            let value = match kind {
                Kind::Color => node.numbers().map(MaterialValue::Color),
                Kind::Normal => node.numbers().map(MaterialValue::Normal),
                Kind::Float => node.value.as_f64().map(MaterialValue::Float),
                Kind::Bool => node.value.as_bool().map(MaterialValue::Bool),
            };
            let value = value.ok_or_else(|| self.expected(&node, kind.expectation()))?;
            if let Some(x) = value.numbers().iter().find(|x| !def.limits.contains(**x)) {
                self.warn(&node.key, &format!("expected {}, found {x}", def.limits.text()));
            }
            material.set(def.id, value);
        }
        Ok(material)
    }

    fn objects(&mut self, node: &Node, materials: &BTreeMap<String, Arc<Material>>) -> Result<Vec<Object>, SceneFileError> {
        let entries = node.value.as_array().filter(|entries| !entries.is_empty());
        let entries = entries.ok_or_else(|| self.expected(node, "a list of at least one object"))?;
        let textures: Arc<TextureSet> = Arc::default();
        let mut objects = Vec::new();
        for (i, value) in entries.iter().enumerate() {
            let entry = Node { value, key: format!("{}[{i}]", node.key) };
            let name = self.required(&entry, "material")?;
            let material = name.value.as_str().and_then(|name| materials.get(name));
            let material = material.ok_or_else(|| self.expected(&name, "a name that stands under `materials`"))?.clone();
            let is_document = name.value.as_str() == Some(DOCUMENT_MATERIAL);
            let file = self.required(&entry, "mesh")?;
            let path = self.file(&file)?;
            if !self.files.contains(&path) {
                self.files.push(path.clone());
            }
            let (model, warnings) = load_model(&path).map_err(|source| self.asset(&file, source))?;
            self.warnings.extend(warnings.iter().map(|warning| format!("{}: {}: {warning}", self.path.display(), file.key)));
            objects.extend(model.parts.into_iter().map(|part| Object {
                mesh: Arc::new(part.mesh),
                material: material.clone(),
                textures: textures.clone(),
                is_document,
                length_scale: 1.0,
            }));
        }
        Ok(objects)
    }
}

/// A value as JSON, cut where it would fill the message.
fn shortened(value: &Value) -> String {
    const LENGTH: usize = 60;
    let text = value.to_string();
    if text.chars().count() <= LENGTH { text } else { format!("{}…", text.chars().take(LENGTH).collect::<String>()) }
}
