//! Which materials are compared or merged, and what they hold: open documents as they are, as opened and as saved, and files.

use crate::background::Background;
use crate::files::{self, OpenedMaterial};
use burnish_material::{Material, MaterialFile};
use burnish_renderer::scene::TextureSet;
use egui::Context;
use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Where a material is taken from.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Source {
    /// The document in front.
    Front,
    /// The document in front as it was opened, or the preset that it began with.
    Opened,
    /// The document in front as the disk holds it.
    Saved,
    /// The stored side of the document in front.
    Side,
    /// Another open document, by its number.
    Tab(u64),
    /// A file.
    File(PathBuf),
}

/// What a source holds.
#[derive(Clone, Debug)]
pub struct Sourced {
    /// What to call it.
    pub title: String,
    /// The file with its text.
    pub file: Arc<MaterialFile>,
    /// Its material.
    pub material: Arc<Material>,
    /// Images by the path that the material names.
    pub textures: Arc<TextureSet>,
    /// Its file on disk.
    pub path: Option<PathBuf>,
}

impl Sourced {
    /// Where relative paths of its images begin.
    pub fn folder(&self) -> Option<&Path> {
        self.path.as_deref().and_then(Path::parent)
    }

    /// Its material with paths of images that lead to the same files from another folder, and the images by these.
    pub fn seen_from(&self, folder: Option<&Path>) -> (Material, TextureSet) {
        let (mut material, mut images) = ((*self.material).clone(), (*self.textures).clone());
        for (old, new) in files::move_textures(&mut material, self.folder(), folder) {
            if let Some(image) = self.textures.get(&old) {
                images.insert(new, image.clone());
            }
        }
        (material, images)
    }
}

/// A document's state: the text it began with, its values, images and place.
pub struct Live {
    /// What to call it.
    pub title: String,
    /// The text; `None` where only values are kept.
    pub file: Option<Arc<MaterialFile>>,
    /// The values.
    pub material: Material,
    /// The images.
    pub textures: Arc<TextureSet>,
    /// Its file on disk.
    pub path: Option<PathBuf>,
}

impl Live {
    fn is_same(&self, other: &Self) -> bool {
        let is_file = match (&self.file, &other.file) {
            (Some(a), Some(b)) => Arc::ptr_eq(a, b),
            (a, b) => a.is_none() && b.is_none(),
        };
        is_file
            && Arc::ptr_eq(&self.textures, &other.textures)
            && self.title == other.title
            && self.path == other.path
            && self.material == other.material
    }

    fn sourced(&self) -> Option<Sourced> {
        let file = match &self.file {
            None => Arc::new(MaterialFile::new(&self.material)),
            Some(file) if *file.material() == self.material => file.clone(),
            Some(file) => Arc::new(MaterialFile::parse(&file.to_text(&self.material)).ok()?.0),
        };
        let material = Arc::new(file.material().clone());
        Some(Sourced { title: self.title.clone(), file, material, textures: self.textures.clone(), path: self.path.clone() })
    }
}

/// What came of reading a file.
type Opened = Result<Arc<Sourced>, String>;

/// What sources hold, kept as long as it is so: the same source gives the same pointer.
#[derive(Default)]
pub struct Sources {
    live: HashMap<Source, (Live, Arc<Sourced>)>,
    files: HashMap<PathBuf, Opened>,
    /// Files that may hold something else by now.
    outdated: HashSet<PathBuf>,
    reading: HashMap<PathBuf, Background<Result<OpenedMaterial, String>>>,
}

impl Sources {
    /// What a document holds now.
    pub fn live(&mut self, source: &Source, live: Live) -> Option<Arc<Sourced>> {
        if let Some((known, sourced)) = self.live.get(source)
            && known.is_same(&live)
        {
            return Some(sourced.clone());
        }
        let sourced = Arc::new(live.sourced()?);
        self.live.insert(source.clone(), (live, sourced.clone()));
        Some(sourced)
    }

    /// What a file holds, or held before it was read again; `None` while it is read for the first time.
    pub fn file(&mut self, path: &Path, ctx: &Context) -> Option<Opened> {
        let known = self.files.get(path);
        if known.is_some() && !self.outdated.contains(path) {
            return known.cloned();
        }
        let reading = self.reading.entry(path.to_path_buf()).or_default();
        if !reading.is_running() {
            let path = path.to_path_buf();
            let name = format!("Reading {}", path.display());
            reading.start(name, ctx, move |_| files::open_material(&path).map_err(|error| error.to_string()));
        }
        let Some(read) = reading.poll() else { return known.cloned() };
        let opened = read.and_then(|opened| opened).map(|opened| {
            let material = opened.file.material();
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            let title = if material.name.trim().is_empty() { name.into_owned() } else { material.name.clone() };
            let path = Some(path.to_path_buf());
            let material = Arc::new(material.clone());
            Arc::new(Sourced { title, material, file: Arc::new(opened.file), textures: opened.textures, path })
        });
        self.reading.remove(path);
        self.outdated.remove(path);
        if let (Some(Ok(known)), Ok(now)) = (self.files.get(path), &opened)
            && known.file.text() == now.file.text()
            && known.textures.is_empty()
            && now.textures.is_empty()
        {
            return Some(Ok(known.clone()));
        }
        self.files.insert(path.to_path_buf(), opened.clone());
        Some(opened)
    }

    /// Files may have changed: they are read again when they are asked for.
    pub fn forget_files(&mut self) {
        self.outdated.extend(self.files.keys().cloned());
        self.reading.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use burnish_material::{Property, Value};

    #[test]
    fn what_is_the_same_is_not_made_again() {
        let mut sources = Sources::default();
        let file = Arc::new(MaterialFile::parse("{ \"asm\": \"4.0\", /* kept */ \"velvet\": 1 }").unwrap().0);
        let (textures, mut material) = (Arc::new(TextureSet::new()), file.material().clone());
        let mut of = |material: &Material| {
            let (material, textures, file) = (material.clone(), textures.clone(), Some(file.clone()));
            sources.live(&Source::Front, Live { title: "m".into(), file, material, textures, path: None }).unwrap()
        };
        let (first, again) = (of(&material), of(&material));
        assert!(Arc::ptr_eq(&first, &again));
        material.set(Property::coat, Value::Float(1.0));
        let edited = of(&material);
        assert!(!Arc::ptr_eq(&first, &edited) && edited.file.text().contains("kept") && edited.file.text().contains("velvet"));
        assert_eq!(*edited.material, material);
    }
}
