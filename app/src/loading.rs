//! Files and built-in scenes, read and made in the background. The window only collects what is finished.

use crate::background::Control;
use crate::exchange::{ExchangeError, Import, import, imported_images, load_mesh};
use crate::files::{self, Embedded, OpenedMaterial};
use crate::picture_file::embedded_job;
use crate::texture_set;
use crate::work::{Ends, Work};
use burnish_assets::{Environment, Image, Progress};
use burnish_material::{Channel, Material, Property};
use burnish_renderer::scene::{ModelMeshes, TextureSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};

/// Sentences about one file of another format, at most.
const MAX_WARNINGS: usize = 8;

/// Something to load. Numbers are those of documents, see [`crate::tabs::Tabs`].
#[derive(Clone, Debug, PartialEq)]
pub enum Job {
    /// A material file to open.
    Material(PathBuf),
    /// A picture of ours, whose material is to be opened.
    Picture(PathBuf),
    /// A file of another format, with its materials and its mesh.
    Import(PathBuf),
    /// A material file that another program has changed, for the document of this number.
    Reload(u64, PathBuf),
    /// A material file to compare the document of this number with.
    Compare(u64, PathBuf),
    /// A material file to put in the place of the document of this number.
    Apply(u64, PathBuf),
    /// The images that a material names, relative to a folder.
    Textures(u64, Box<Material>, Option<PathBuf>),
    /// The images inside of a file of another format, for a document that came from it.
    ImportedImages(u64, PathBuf),
    /// An image for one property.
    Texture(u64, Property, PathBuf),
    /// A map of a built-in texture for one property, by its path.
    BuiltInTexture(u64, Property, String),
    /// An image that another program has changed, by the path that the material names.
    Image(u64, String, PathBuf),
    /// A folder of images for many properties.
    TextureSet(u64, PathBuf),
    /// A photo to look at.
    Reference(PathBuf),
    /// A built-in model.
    Shape(&'static str),
    /// A mesh file.
    Model(PathBuf),
    /// A built-in environment.
    BuiltInEnvironment(&'static str),
    /// An environment file.
    Environment(PathBuf),
}

/// An image of a texture set, and how its property reads it.
pub struct SetImage {
    /// Whose map it is.
    pub property: Property,
    /// The file.
    pub path: PathBuf,
    /// What the property reads of it.
    pub channel: Channel,
    /// Whether it is read inverted.
    pub is_inverted: bool,
    /// The image.
    pub image: Arc<Image>,
}

/// What came of a job.
pub enum Loaded {
    /// An opened material.
    Material(Box<OpenedMaterial>),
    /// Materials of a file of another format, and its mesh.
    Import(Vec<OpenedMaterial>, Option<Box<ModelMeshes>>),
    /// Images for a document.
    Textures(TextureSet),
    /// Images for a document that lie in no file of their own.
    ImportedImages(Embedded, TextureSet),
    /// An image.
    Texture(Arc<Image>),
    /// Images for many properties.
    TextureSet(Vec<SetImage>),
    /// A photo.
    Reference(Arc<Image>),
    /// A model, with its file if it has one.
    Model(Box<ModelMeshes>, Option<PathBuf>),
    /// An environment, with its file if it has one.
    Environment(Arc<Environment>, Option<PathBuf>),
}

/// A finished job: what was asked, what came of it, and sentences for the user.
pub struct Done {
    /// What was asked.
    pub job: Job,
    /// The result, or one sentence saying why there is none.
    pub result: Result<Loaded, String>,
    /// What was strange.
    pub warnings: Vec<String>,
}

impl Job {
    /// Whether a newer job makes this one's result void. Images for different properties do not replace each other.
    fn is_replaced_by(&self, newer: &Self) -> bool {
        match (self, newer) {
            (Self::Shape(_) | Self::Model(_), Self::Shape(_) | Self::Model(_))
            | (Self::BuiltInEnvironment(_) | Self::Environment(_), Self::BuiltInEnvironment(_) | Self::Environment(_))
            | (Self::Reference(_), Self::Reference(_)) => true,
            (Self::Texture(a, p, _) | Self::BuiltInTexture(a, p, _), Self::Texture(b, q, _) | Self::BuiltInTexture(b, q, _)) => {
                (a, p) == (b, q)
            }
            (Self::Image(a, p, _), Self::Image(b, q, _)) => (a, p) == (b, q),
            (Self::Textures(a, ..), Self::Textures(b, ..)) => a == b,
            _ => self == newer,
        }
    }

    /// What is being loaded, for the status line.
    pub fn text(&self) -> String {
        let name = |path: &PathBuf| path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        match self {
            Self::Material(path)
            | Self::Import(path)
            | Self::Picture(path)
            | Self::ImportedImages(_, path)
            | Self::Reload(_, path)
            | Self::Compare(_, path)
            | Self::Apply(_, path)
            | Self::Texture(_, _, path)
            | Self::Image(_, _, path)
            | Self::TextureSet(_, path)
            | Self::Reference(path)
            | Self::Model(path)
            | Self::Environment(path) => name(path),
            Self::Textures(..) => "maps".into(),
            Self::BuiltInTexture(_, _, path) => path.clone(),
            Self::Shape(name) | Self::BuiltInEnvironment(name) => (*name).into(),
        }
    }

    fn run(&self, progress: Progress<'_>) -> (Result<Loaded, String>, Vec<String>) {
        let mut warnings = Vec::new();
        let result = match self {
            Self::Material(path) | Self::Reload(_, path) | Self::Compare(_, path) | Self::Apply(_, path) => {
                files::open_material(path).map_err(|error| error.to_string()).map(|mut opened| {
                    warnings.append(&mut opened.warnings);
                    Loaded::Material(Box::new(opened))
                })
            }
            Self::Import(path) => load_import(path, progress, &mut warnings),
            Self::Picture(path) => embedded_job(path)
                .map_err(|error| error.to_string())
                .and_then(|job| files::open_embedded(path, job.as_ref()).map_err(|error| error.to_string()))
                .map(|(mut opened, _)| {
                    warnings.append(&mut opened.warnings);
                    Loaded::Material(Box::new(opened))
                }),
            Self::Textures(_, material, folder) => {
                let (textures, missing) = files::load_textures(material, folder.as_deref());
                warnings = missing;
                Ok(Loaded::Textures(textures))
            }
            Self::ImportedImages(_, path) => imported_images(path, progress)
                .map(|(embedded, textures, missing)| {
                    warnings = missing;
                    Loaded::ImportedImages(embedded, textures)
                })
                .map_err(|error| error.to_string()),
            Self::Texture(_, _, path) | Self::Image(_, _, path) => image(path).map(Loaded::Texture),
            Self::BuiltInTexture(_, _, path) => files::make_built_in_texture(path).map(|image| Loaded::Texture(Arc::new(image))),
            Self::Reference(path) => image(path).map(Loaded::Reference),
            Self::TextureSet(_, folder) => load_set(folder, &mut warnings).map(Loaded::TextureSet),
            Self::Shape(name) => burnish_assets::make_shape(name)
                .map(|model| Loaded::Model(Box::new(model.into()), None))
                .ok_or_else(|| format!("There is no built-in mesh called {name}.")),
            Self::Model(path) => load_mesh(path, progress).map_err(|error| error.to_string()).map(|(model, notes)| {
                warnings = notes;
                Loaded::Model(Box::new(model.into()), Some(path.clone()))
            }),
            Self::BuiltInEnvironment(name) => burnish_assets::make_environment(name)
                .map(|environment| Loaded::Environment(Arc::new(environment), None))
                .ok_or_else(|| format!("There is no built-in environment called {name}.")),
            Self::Environment(path) => {
                burnish_assets::load_environment(path).map_err(|error| error.to_string()).map(|(environment, notes)| {
                    warnings = notes;
                    Loaded::Environment(Arc::new(environment), Some(path.clone()))
                })
            }
        };
        (result, warnings)
    }
}

/// The materials of a file, and its mesh.
fn load_import(path: &Path, progress: Progress<'_>, warnings: &mut Vec<String>) -> Result<Loaded, String> {
    let Import { materials, model, mut notes } = import(path, progress).map_err(|error| error.to_string())?;
    if notes.len() > MAX_WARNINGS {
        let more = notes.len() - MAX_WARNINGS;
        notes.truncate(MAX_WARNINGS);
        notes.push(format!("{}: {more} more notes; `burnish convert` prints all of them", path.display()));
    }
    warnings.append(&mut notes);
    Ok(Loaded::Import(materials, model.map(|model| Box::new(model.into()))))
}

fn image(path: &Path) -> Result<Arc<Image>, String> {
    burnish_assets::load_image(path).map(Arc::new).map_err(|error| error.to_string())
}

/// The images of a folder that fit a property by their names. Those that do not are told.
fn load_set(folder: &Path, warnings: &mut Vec<String>) -> Result<Vec<SetImage>, String> {
    let found = texture_set::match_set(&texture_set::read_folder(folder)?);
    warnings.extend(found.unmatched.iter().map(|(path, why)| format!("{}: not used: {why}", path.display())));
    if found.slots.is_empty() {
        return Err(ExchangeError::NoSet { path: folder.to_path_buf() }.to_string());
    }
    // A packed image serves several properties and is read once.
    let mut images: Vec<(PathBuf, Arc<Image>)> = Vec::new();
    let mut set = Vec::new();
    for slot in found.slots {
        let known = images.iter().find(|(path, _)| *path == slot.path).map(|(_, image)| image.clone());
        match known.map_or_else(|| image(&slot.path), Ok) {
            Ok(image) => {
                images.push((slot.path.clone(), image.clone()));
                let (property, channel, is_inverted) = (slot.property, slot.channel, slot.is_inverted);
                set.push(SetImage { property, path: slot.path, channel, is_inverted, image });
            }
            Err(problem) => warnings.push(problem),
        }
    }
    Ok(set)
}

struct Running {
    number: u64,
    job: Job,
    control: Arc<Control>,
}

impl Drop for Running {
    fn drop(&mut self) {
        self.control.cancel();
    }
}

/// Runs jobs on threads of their own. A newer job of the same kind makes an older one's result void.
pub struct Loader {
    sender: Sender<(u64, Done)>,
    receiver: Receiver<(u64, Done)>,
    running: Vec<Running>,
    next: u64,
}

impl Default for Loader {
    fn default() -> Self {
        let (sender, receiver) = channel();
        Self { sender, receiver, running: Vec::new(), next: 0 }
    }
}

impl Loader {
    /// Starts a job.
    pub fn start(&mut self, job: Job, ctx: &egui::Context) {
        self.running.retain(|running| !running.job.is_replaced_by(&job));
        self.next += 1;
        let (number, sender, control) = (self.next, self.sender.clone(), Control::new(ctx));
        self.running.push(Running { number, job: job.clone(), control: control.clone() });
        std::thread::spawn(move || {
            let told = |share| {
                control.tell(share);
                !control.is_cancelled()
            };
            let (result, warnings) = job.run(Progress::new(&told));
            // Nobody listens after the window has closed.
            let _ = sender.send((number, Done { job, result, warnings }));
            control.wake();
        });
    }

    /// The next finished job that is still wanted.
    pub fn poll(&mut self) -> Option<Done> {
        loop {
            let (number, done) = self.receiver.try_recv().ok()?;
            if let Some(index) = self.running.iter().position(|running| running.number == number) {
                self.running.remove(index);
                return Some(done);
            }
        }
    }

    /// What is being loaded, for the list of all work.
    pub fn work(&self) -> impl Iterator<Item = Work> {
        self.running.iter().map(|Running { number, job, control }| {
            let work = control.work(&format!("Loading {}…", job.text()), Ends::Loading(*number));
            // Most jobs are too short to tell.
            Work { progress: work.progress.filter(|share| *share > 0.0), ..work }
        })
    }

    /// Ends one job.
    pub fn end(&mut self, number: u64) {
        self.running.retain(|running| running.number != number);
    }

    /// Makes the results of everything that is being loaded void.
    pub fn cancel(&mut self) {
        self.running.clear();
    }

    /// Whether a job is running.
    pub fn is_busy(&self) -> bool {
        !self.running.is_empty()
    }
}
