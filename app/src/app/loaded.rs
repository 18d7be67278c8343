//! What was loaded comes to where it belongs; also what other programs have changed.

use super::App;
use crate::dock::Pane;
use crate::editor::Document;
use crate::files::{self, OpenedMaterial};
use crate::loading::{Done, Job, Loaded, SetImage};
use crate::picture_job::Place;
use crate::sides::Side;
use burnish_assets::Image;
use burnish_material::{Property, Slot, TextureRef};
use egui::Context;
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

impl App {
    /// Takes what was loaded to where it belongs.
    pub(super) fn loaded(&mut self, done: Done, ctx: &Context) {
        for warning in done.warnings {
            self.messages.warning(warning);
        }
        match (done.job, done.result) {
            (job, Err(problem)) => {
                self.messages.error(problem);
                // It came in the place of the first mesh or light.
                if matches!(job, Job::Model(_) | Job::Environment(_)) {
                    self.load_first_scene(ctx);
                }
            }
            (Job::Reload(id, path), Ok(Loaded::Material(opened))) => {
                self.edit_document(id, Some("Reload from disk"), |document| *document = Document::opened(*opened));
                self.messages.info(format!("Reloaded {}; undo brings back what was here before.", path.display()));
            }
            (Job::Compare(id, path), Ok(Loaded::Material(opened))) => {
                let side = Side::of(&Document::opened(*opened), "on disk");
                if id == self.tabs.front_id() {
                    self.sides.store(side);
                    self.editor.view.compares_sides = true;
                    self.editor.view.mode = crate::editor::ViewMode::Both;
                    self.messages.info(format!("Comparing with {} as it is on disk.", path.display()));
                }
            }
            (Job::Apply(id, path), Ok(Loaded::Material(opened))) => {
                let name = opened.file.material().name.clone();
                self.edit_document(id, Some(&format!("Apply {name}")), |document| {
                    *document = document.replaced_by(Document::opened(*opened).without_path());
                });
                self.messages.info(format!("Applied {}; undo brings back what was here before.", path.display()));
            }
            (Job::Picture(picture), Ok(Loaded::Material(opened))) => {
                self.open_document(Document::opened(*opened));
                self.messages.info(format!("Opened the material that {} was made of, as a new document.", picture.display()));
            }
            (_, Ok(Loaded::Material(opened))) => self.show_opened(*opened),
            (Job::Import(path), Ok(Loaded::Import(materials, model))) => {
                let count = materials.len();
                // The first one comes to the front.
                materials.into_iter().rev().for_each(|opened| self.open_document(Document::opened(opened)));
                let what = match count {
                    0 => String::new(),
                    1 => format!("1 material, {}", properties_of(&self.editor.document)),
                    count => format!("{count} materials"),
                };
                let mesh = match (count, model.is_some()) {
                    (_, false) => "",
                    (0, true) => "its mesh",
                    (1, true) => ", and its mesh",
                    (_, true) => " and their mesh",
                };
                self.messages.info(format!("Opened {}: {what}{mesh}; materials are new documents.", path.display()));
                if let Some(model) = model {
                    self.editor.places[0] = Some(Place::File(path));
                    self.editor.set_model(*model);
                }
            }
            (Job::Textures(id, ..), Ok(Loaded::Textures(textures))) => {
                self.edit_document(id, None, |document| Arc::make_mut(&mut document.textures).extend(textures));
            }
            (Job::ImportedImages(id, _), Ok(Loaded::ImportedImages(embedded, textures))) => {
                self.edit_document(id, None, |document| document.add_embedded(embedded, textures));
            }
            (Job::Texture(id, property, path), Ok(Loaded::Texture(image))) => {
                let label = format!("{} map {}", property.def().label, path.display());
                self.edit_document(id, Some(&label), |document| {
                    let name = files::texture_name(&path, document.folder());
                    set_map(document, property, name, image, |_| {});
                });
                self.messages.info(format!("{} reads {}", property.def().label, path.display()));
            }
            (Job::BuiltInTexture(id, property, path), Ok(Loaded::Texture(image))) => {
                let label = format!("{} map {path}", property.def().label);
                self.edit_document(id, Some(&label), |document| {
                    set_map(document, property, path, image, |texture| {
                        // What was said of another image does not hold for this one.
                        let fresh = TextureRef::new(String::new());
                        (texture.channel, texture.color_space) = (fresh.channel, fresh.color_space);
                        (texture.is_inverted, texture.scale, texture.bias) = (fresh.is_inverted, fresh.scale, fresh.bias);
                    });
                });
            }
            (Job::Image(id, name, path), Ok(Loaded::Texture(image))) => {
                self.edit_document(id, None, |document| drop(Arc::make_mut(&mut document.textures).insert(name, image)));
                self.messages.info(format!("{} was changed by another program and read again.", path.display()));
            }
            (Job::TextureSet(id, folder), Ok(Loaded::TextureSet(set))) => {
                let names: Vec<&str> = set.iter().map(|image| image.property.def().label).collect();
                let said = format!("{}: {}", folder.display(), names.join(", "));
                self.edit_document(id, Some(&format!("Texture set {}", folder.display())), |document| {
                    for SetImage { property, path, channel, is_inverted, image } in set {
                        let name = files::texture_name(&path, document.folder());
                        set_map(document, property, name, image, |texture| {
                            (texture.channel, texture.is_inverted) = (channel, is_inverted);
                        });
                    }
                });
                self.messages.info(said);
            }
            (Job::Reference(path), Ok(Loaded::Reference(image))) => {
                self.reference.set(&path, &image);
                self.dock.set_shown(Pane::Reference, true);
                self.messages.info(format!("{} is shown beside the view; colours can be picked from it.", path.display()));
            }
            (job, Ok(Loaded::Model(model, path))) => {
                self.editor.places[0] = place_of(&job);
                if path.is_some() || self.editor.model.is_some() {
                    self.messages.info(format!("Showing {}", model.name));
                }
                self.editor.set_model(*model);
            }
            (job, Ok(Loaded::Environment(environment, path))) => {
                self.editor.places[1] = place_of(&job);
                if path.is_some() || self.editor.environment.is_some() {
                    self.messages.info(format!("Lit by {}", environment.name));
                }
                self.editor.environment = Some(environment);
            }
            // No job has a result of another kind.
            (_, Ok(_)) => {}
        }
    }

    fn show_opened(&mut self, opened: OpenedMaterial) {
        let path = opened.path.clone().unwrap_or_default();
        self.open_document(Document::opened(opened));
        self.keeping.opened(&path);
        self.messages.info(format!("Opened {}: {}", path.display(), properties_of(&self.editor.document)));
    }

    /// What to do about a file that another program has changed.
    pub(super) fn changed_outside(&mut self, path: &Path, ctx: &Context) {
        let mut reloaded = Vec::new();
        for (id, document) in self.tabs.documents(&self.editor.document) {
            if document.path() == Some(path) {
                let title = document.title();
                self.pages.ask_about_change(id, path.to_path_buf(), title, document.is_modified());
            }
            let folder = document.folder();
            for (_, slot) in document.material.slots() {
                let Some(texture) = &slot.texture else { continue };
                if files::texture_path(&texture.path, folder).as_deref() == Some(path) {
                    reloaded.push(Job::Image(id, texture.path.clone(), path.to_path_buf()));
                }
            }
        }
        reloaded.into_iter().for_each(|job| self.loader.start(job, ctx));
    }
}

/// How many properties a document sets, and what it keeps without knowing it.
fn properties_of(document: &Document) -> String {
    let set = document.material.slots().filter(|(_, slot)| **slot != Slot::default()).count();
    let mut text = format!("{set} of {} properties set", burnish_material::PROPERTY_COUNT);
    let unknown = document.file().unknown_keys().len() + document.material.foreign.values().map(BTreeMap::len).sum::<usize>();
    for (count, what) in [(unknown, "unknown kept"), (document.file().unreadable().len(), "unreadable kept")] {
        if count > 0 {
            text += &format!(", {count} {what}");
        }
    }
    text
}

/// Where a job loads a model or an environment from.
fn place_of(job: &Job) -> Option<Place> {
    match job {
        Job::Shape(name) | Job::BuiltInEnvironment(name) => Some(Place::BuiltIn((*name).to_owned())),
        Job::Model(path) | Job::Environment(path) => Some(Place::File(path.clone())),
        _ => None,
    }
}

/// Lets a property read an image by the path that the file is to name.
fn set_map(document: &mut Document, property: Property, name: String, image: Arc<Image>, settings: impl FnOnce(&mut TextureRef)) {
    Arc::make_mut(&mut document.textures).insert(name.clone(), image);
    let slot = document.material.slot_mut(property);
    let texture = slot.texture.get_or_insert_with(|| TextureRef::new(name.clone()));
    texture.path = name;
    settings(texture);
}
