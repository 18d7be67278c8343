//! Files and built-in scenes, read and made in the background. The window only collects what is finished.

use crate::files::{self, OpenedMaterial};
use burnish_assets::{Environment, Image};
use burnish_material::{Material, Property};
use burnish_renderer::scene::{ModelMeshes, TextureSet};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};

/// Something to load.
#[derive(Clone, Debug, PartialEq)]
pub enum Job {
    /// A material file to open.
    Material(PathBuf),
    /// Images that a material names, relative to a folder.
    Textures(Box<Material>, Option<PathBuf>),
    /// An image for one property.
    Texture(Property, PathBuf),
    /// A built-in model.
    Shape(&'static str),
    /// A mesh file.
    Model(PathBuf),
    /// A built-in environment.
    BuiltInEnvironment(&'static str),
    /// An environment file.
    Environment(PathBuf),
}

/// What came of a job.
pub enum Loaded {
    /// An opened material.
    Material(Box<OpenedMaterial>),
    /// Images for the current document.
    Textures(TextureSet),
    /// An image for one property.
    Texture(Property, PathBuf, Arc<Image>),
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
    /// What a newer job of the same kind replaces; textures for different properties do not replace each other.
    fn kind(&self) -> (u8, usize) {
        match self {
            Self::Material(_) => (0, 0),
            Self::Textures(..) => (1, 0),
            Self::Texture(property, _) => (2, *property as usize),
            Self::Shape(_) | Self::Model(_) => (3, 0),
            Self::BuiltInEnvironment(_) | Self::Environment(_) => (4, 0),
        }
    }

    /// What is being loaded, for the status line.
    pub fn text(&self) -> String {
        let name = |path: &PathBuf| path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        match self {
            Self::Material(path) | Self::Texture(_, path) | Self::Model(path) | Self::Environment(path) => name(path),
            Self::Textures(..) => "maps".into(),
            Self::Shape(name) | Self::BuiltInEnvironment(name) => (*name).into(),
        }
    }

    fn run(&self) -> (Result<Loaded, String>, Vec<String>) {
        let mut warnings = Vec::new();
        let result = match self {
            Self::Material(path) => files::open_material(path).map_err(|error| error.to_string()).map(|mut opened| {
                warnings.append(&mut opened.warnings);
                Loaded::Material(Box::new(opened))
            }),
            Self::Textures(material, folder) => {
                let (textures, missing) = files::load_textures(material, folder.as_deref());
                warnings = missing;
                Ok(Loaded::Textures(textures))
            }
            Self::Texture(property, path) => burnish_assets::load_image(path)
                .map(|image| Loaded::Texture(*property, path.clone(), Arc::new(image)))
                .map_err(|error| error.to_string()),
            Self::Shape(name) => burnish_assets::make_shape(name)
                .map(|model| Loaded::Model(Box::new(model.into()), None))
                .ok_or_else(|| format!("There is no built-in mesh called {name}.")),
            Self::Model(path) => burnish_assets::load_model(path).map_err(|error| error.to_string()).map(|(model, notes)| {
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

/// Runs jobs on threads of their own. A newer job of the same kind makes an older one's result void.
pub struct Loader {
    sender: Sender<(u64, Done)>,
    receiver: Receiver<(u64, Done)>,
    running: Vec<(u64, Job)>,
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
        self.running.retain(|(_, other)| other.kind() != job.kind());
        self.next += 1;
        let (number, sender, ctx) = (self.next, self.sender.clone(), ctx.clone());
        self.running.push((number, job.clone()));
        std::thread::spawn(move || {
            let (result, warnings) = job.run();
            // Nobody listens after the window has closed.
            let _ = sender.send((number, Done { job, result, warnings }));
            ctx.request_repaint();
        });
    }

    /// The next finished job that is still wanted.
    pub fn poll(&mut self) -> Option<Done> {
        loop {
            let (number, done) = self.receiver.try_recv().ok()?;
            if let Some(index) = self.running.iter().position(|(other, _)| *other == number) {
                self.running.remove(index);
                return Some(done);
            }
        }
    }

    /// What is being loaded: `Loading studio, wood.png…`, or `None`.
    pub fn text(&self) -> Option<String> {
        let names: Vec<String> = self.running.iter().map(|(_, job)| job.text()).collect();
        (!names.is_empty()).then(|| format!("Loading {}…", names.join(", ")))
    }

    /// Whether a job is running.
    pub fn is_busy(&self) -> bool {
        !self.running.is_empty()
    }
}
