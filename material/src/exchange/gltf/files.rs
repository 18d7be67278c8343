//! Names of the images of a document on the way out, and its lists of images, samplers and textures.

use std::collections::{BTreeMap, BTreeSet};

use serde_json::{Map, Value as Json, json};

use super::plan::{Copy, Plan};
use super::read::is_builtin;
use super::uri;
use super::write::Part;
use crate::material::Material;
use crate::slot::Wrap;

/// Folder, beside the document, of images that have no place of their own there.
const FOLDER: &str = "textures";

/// Names of image files.
pub(super) struct Files {
    pub plan: Plan,
    /// Files by the path that a material has them by.
    by_path: BTreeMap<String, String>,
    /// Files in use, in lower case: some systems do not tell case apart.
    taken: BTreeSet<String>,
}

impl Files {
    /// Those that the materials have. A relative path is kept; any other file gets a place beside the document.
    pub fn of(parts: &[Part]) -> Self {
        let mut files = Self { plan: Plan::default(), by_path: BTreeMap::new(), taken: BTreeSet::new() };
        let textures = parts.iter().flat_map(|part| part.material.slots()).filter_map(|(_, slot)| slot.texture.as_ref());
        let paths: BTreeSet<&String> = textures.map(|texture| &texture.path).collect();
        // Kept names first, so that no made one takes them.
        let (kept, moved): (Vec<&String>, Vec<&String>) = paths.into_iter().partition(|path| portable(path).is_some());
        for path in kept.into_iter().chain(moved) {
            files.add(path);
        }
        files
    }

    fn add(&mut self, path: &str) -> String {
        let file = portable(path).unwrap_or_else(|| {
            // With the parameters of a made one: documents in one folder must not share a name for different images.
            let bare = path.trim_start_matches("builtin:");
            let name = bare.rsplit(['/', '\\']).next().unwrap_or_default();
            let (stem, end) = match (is_builtin(path), name.rsplit_once('.')) {
                (false, Some((stem, end))) => (uri::file_word(stem), uri::file_word(end)),
                _ => (uri::file_word(bare), "png".to_owned()),
            };
            self.unused(&stem, &end)
        });
        self.taken.insert(file.to_lowercase());
        self.by_path.insert(path.to_owned(), file.clone());
        self.plan.copies.push(Copy { path: path.to_owned(), file: file.clone(), is_used: false });
        file
    }

    fn unused(&mut self, stem: &str, end: &str) -> String {
        let names = (1..).map(|n| if n == 1 { format!("{FOLDER}/{stem}.{end}") } else { format!("{FOLDER}/{stem}_{n}.{end}") });
        let free = names.take(100_000).find(|name| !self.taken.contains(&name.to_lowercase())).unwrap_or_default();
        self.taken.insert(free.to_lowercase());
        free
    }

    /// The file of a path that the document uses.
    pub fn used(&mut self, path: &str) -> String {
        let file = self.by_path.get(path).cloned().unwrap_or_else(|| self.add(path));
        for copy in self.plan.copies.iter_mut().filter(|copy| copy.path == path) {
            copy.is_used = true;
        }
        file
    }

    /// A name for an image that is made for a material.
    pub fn fresh(&mut self, material: &str, suffix: &str) -> String {
        self.unused(&format!("{}_{suffix}", uri::file_word(material)), "png")
    }

    /// Forgets files that no texture uses, unless native copies do.
    pub fn keep_needed(&mut self, has_native_copy: bool) {
        self.plan.copies.retain(|copy| copy.is_used || has_native_copy);
    }

    /// The material with images where the document has them. Paths that mean the same beside the document stay as they are.
    pub fn portable(&self, material: &Material) -> Material {
        let mut moved = material.clone();
        for (property, slot) in material.slots() {
            let Some(texture) = &slot.texture else { continue };
            let is_kept = is_builtin(&texture.path) || portable(&texture.path).is_some();
            if let (false, Some(file), Some(texture)) =
                (is_kept, self.by_path.get(&texture.path), &mut moved.slot_mut(property).texture)
            {
                texture.path.clone_from(file);
            }
        }
        moved
    }
}

/// The path itself, if it can stand in a document: relative, and inside of its folder.
fn portable(path: &str) -> Option<String> {
    uri::safe(path).filter(|_| !is_builtin(path))
}

/// Textures of a document, and the images and samplers that they are made of.
#[derive(Default)]
pub(super) struct Textures {
    images: Vec<String>,
    samplers: Vec<Wrap>,
    textures: Vec<(usize, usize)>,
}

impl Textures {
    /// The number of the texture of a file, laid out in this way.
    pub fn number(&mut self, file: String, wrap: Wrap) -> usize {
        let texture = (place(&mut self.images, file), place(&mut self.samplers, wrap));
        place(&mut self.textures, texture)
    }

    /// The lists, and the files that only native copies use.
    pub fn write(mut self, files: &Files, body: &mut Map<String, Json>) {
        let textures = self.textures.iter().map(|(image, sampler)| {
            let extension = match self.images.get(*image).map(|file| uri::extension(file)).as_deref() {
                Some("webp") => "EXT_texture_webp",
                Some("ktx2") => "KHR_texture_basisu",
                _ => return json!({ "sampler": sampler, "source": image }),
            };
            json!({ "sampler": sampler, "extensions": { extension: { "source": image } } })
        });
        let textures: Vec<Json> = textures.collect();
        for copy in files.plan.copies.iter().filter(|copy| !is_builtin(&copy.path)) {
            if ["png", "jpg", "jpeg"].contains(&uri::extension(&copy.file).as_str()) {
                place(&mut self.images, copy.file.clone());
            }
        }
        let samplers = self.samplers.iter().map(|wrap| {
            let code = match wrap {
                Wrap::Repeat => 10497,
                Wrap::Clamp => 33071,
                Wrap::Mirror => 33648,
            };
            json!({ "wrapS": code, "wrapT": code })
        });
        let samplers: Vec<Json> = samplers.collect();
        let images: Vec<Json> = self.images.iter().map(|file| json!({ "uri": uri::write(file) })).collect();
        for (key, list) in [("textures", textures), ("images", images), ("samplers", samplers)] {
            if !list.is_empty() {
                body.insert(key.to_owned(), Json::Array(list));
            }
        }
    }
}

/// The place of something in a list; its end, where it then stands, if it is new.
fn place<T: PartialEq>(list: &mut Vec<T>, item: T) -> usize {
    list.iter().position(|other| *other == item).unwrap_or_else(|| {
        list.push(item);
        list.len() - 1
    })
}
