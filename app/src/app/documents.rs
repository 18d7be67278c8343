//! Documents: opening, saving, closing, and what other programs do to their files.

use super::App;
use super::exporting;
use super::pages::{Answer, question};
use crate::dialogs::{Purpose, Question};
use crate::dock::Pane;
use crate::editor::Document;
use crate::files::{self, OpenedMaterial};
use crate::loading::{Done, Job, Loaded, SetImage};
use crate::picture_job::Place;
use crate::sides::Side;
use crate::tabs::Work;
use burnish_assets::Image;
use burnish_material::{MaterialFile, Property, Slot, TextureRef};
use burnish_presets::Preset;
use egui::{Context, ViewportCommand};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// What waits for an answer about unsaved changes of the document in front.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum After {
    CloseTab,
    CloseWindow,
}

impl App {
    /// Takes the place of the document by a preset, as one step that undo takes back.
    pub fn load_preset(&mut self, preset: &'static Preset, ctx: &Context) {
        match preset.parse() {
            Ok((file, _)) => {
                let opened = OpenedMaterial { path: None, file, warnings: Vec::new(), textures: Arc::default() };
                self.history.settle();
                self.editor.document = self.editor.document.replaced_by(Document::opened(opened));
                self.history.commit(format!("Load preset {}", preset.name), &self.editor.document);
                let material = self.editor.document.material.clone();
                if material.slots().any(|(_, slot)| slot.texture.is_some()) {
                    self.loader.start(Job::Textures(self.tabs.front_id(), Box::new(material), None), ctx);
                }
                self.messages.info(format!("Loaded preset {}; undo brings back what was here before.", preset.name));
            }
            Err(error) => self.messages.error(format!("The preset {} cannot be read: {error}", preset.name)),
        }
    }

    /// A new material that begins with what a file holds, in a tab of its own.
    pub(super) fn open_new(&mut self, file: MaterialFile) {
        let opened = OpenedMaterial { path: None, file, warnings: Vec::new(), textures: Arc::default() };
        self.open_document(Document::opened(opened));
    }

    /// A new material in a tab of its own.
    pub(super) fn new_tab(&mut self) {
        let work = Work::new(self.new_document());
        self.with_front(|tabs, front| tabs.open(front, work));
        self.messages.info("New material: every property has its default.");
    }

    /// Brings a document to the front; it opens anew where nothing was done in the one that is there.
    pub(super) fn open_document(&mut self, document: Document) {
        let here = document.path();
        let known = self
            .tabs
            .documents(&self.editor.document)
            .position(|(_, other)| here.is_some() && other.path() == here && !other.is_modified());
        let work = Work::new(document);
        let is_blank = self.editor.document.path().is_none() && self.history.labels().count() == 1 && !self.history.is_pending();
        self.with_front(|tabs, front| match known {
            Some(place) => {
                tabs.bring_to_front(place, front);
                *front = work;
            }
            None if is_blank && !front.document.is_modified() => *front = work,
            None => tabs.open(front, work),
        });
    }

    /// Closes the document in front, after asking if it has unsaved changes.
    pub(super) fn close_tab(&mut self, ctx: &Context) {
        self.history.settle();
        if self.editor.document.is_modified() {
            self.asking = Some(After::CloseTab);
        } else {
            self.go_on(After::CloseTab, ctx);
        }
    }

    /// Closes the window, after asking about each document with unsaved changes.
    pub(super) fn close_window(&mut self, ctx: &Context) {
        self.history.settle();
        let modified = self.tabs.documents(&self.editor.document).position(|(_, document)| document.is_modified());
        match modified {
            Some(place) => {
                self.with_front(|tabs, front| tabs.bring_to_front(place, front));
                self.asking = Some(After::CloseWindow);
            }
            None if self.asks_to_end_rendering() => {}
            None => {
                self.is_closing = true;
                ctx.send_viewport_cmd(ViewportCommand::Close);
            }
        }
    }

    fn go_on(&mut self, after: After, ctx: &Context) {
        let title = self.editor.document.title();
        let new = Work::new(self.new_document());
        self.with_front(|tabs, front| tabs.close_front(front, || new));
        match after {
            After::CloseTab => self.messages.info(format!("Closed {title}.")),
            After::CloseWindow => self.close_window(ctx),
        }
    }

    /// Asks what to do with unsaved changes.
    pub(super) fn ask_about_unsaved(&mut self, ctx: &Context) {
        let Some(after) = self.asking else { return };
        let title = self.editor.document.title();
        let answers = [("Save", ""), ("Don’t save", ""), ("Cancel", "")];
        let answer = question(ctx, "Unsaved changes", &answers, |ui| {
            ui.label(format!("“{title}” has changes that are not saved."));
        });
        if matches!(answer, Answer::Waiting) {
            return;
        }
        self.asking = None;
        match answer {
            Answer::Chosen(0) => {
                self.after_save = Some(after);
                self.save(ctx);
            }
            Answer::Chosen(1) => self.go_on(after, ctx),
            Answer::Chosen(_) | Answer::None | Answer::Waiting => {}
        }
    }

    pub(super) fn ask(&mut self, purpose: Purpose, ctx: &Context) {
        let document = &self.editor.document;
        let stem: String = document.title().to_lowercase().chars().map(|c| if c.is_alphanumeric() { c } else { '-' }).collect();
        let stem = stem.trim_matches('-');
        let own_name = document.path().and_then(Path::file_name).map(|name| name.to_string_lossy().into_owned());
        let file_name = match purpose {
            Purpose::SaveMaterial => own_name.unwrap_or_else(|| format!("{stem}.{}", files::MATERIAL_EXTENSION)),
            Purpose::RenderPicture(format) | Purpose::WriteElsewhere(format) => format!("{stem}.{}", format.ending()),
            Purpose::SavePng => format!("{stem}.png"),
            Purpose::SaveExr => format!("{stem}.exr"),
            Purpose::SaveSheet | Purpose::SavePack => self.hand_out_name(purpose),
            Purpose::SaveReport => "report.json".to_owned(),
            Purpose::SaveNotes => "changes.md".to_owned(),
            _ => String::new(),
        };
        let folder = document.folder().map(Path::to_path_buf);
        self.dialogs.ask(Question { purpose, folder, file_name }, ctx);
    }

    /// Asks for an image for a property.
    pub(super) fn ask_for_map(&mut self, property: Property, ctx: &Context) {
        self.ask(Purpose::LoadTexture(property), ctx);
    }

    pub(super) fn save(&mut self, ctx: &Context) {
        match self.editor.document.path().map(Path::to_path_buf) {
            Some(path) => self.save_to(path, ctx),
            None => self.ask(Purpose::SaveMaterial, ctx),
        }
    }

    /// Writes the document; says what was changed, or why nothing was written.
    pub(super) fn save_to(&mut self, path: PathBuf, ctx: &Context) {
        self.history.settle();
        let path = std::path::absolute(&path).unwrap_or(path);
        let mut document = self.editor.document.clone();
        document.move_to_folder(path.parent());
        let changed = document.saved().changed(&document.material);
        let text = document.file().to_text(&document.material);
        let saved = files::save_atomic(&path, text.as_bytes()).map_err(|error| error.to_string()).and_then(|()| {
            let reread =
                std::fs::read_to_string(&path).map_err(|error| format!("{}: cannot be read back: {error}", path.display()))?;
            let (file, _) = MaterialFile::parse(&reread).map_err(|error| format!("{}: {error}", path.display()))?;
            Ok((reread == text, file))
        });
        self.keeping.saved(&path);
        match saved {
            Ok((is_same, file)) if is_same && *file.material() == document.material => {
                let old = self.editor.document.clone();
                document.set_saved(path.clone(), file);
                self.history.rebase(&old, &document);
                self.editor.document = document;
                let values = match changed {
                    0 => "no value changed".into(),
                    1 => "1 value changed".into(),
                    n => format!("{n} values changed"),
                };
                self.saved_in_library(&path);
                self.messages.info(format!("{}: saved, reread, {values}, all else identical", path.display()));
                self.keeping.opened(&path);
                if let Some(after) = self.after_save.take() {
                    self.go_on(after, ctx);
                }
            }
            Ok(_) => self
                .fail_saving(format!("{}: what was read back is not what was edited; save under another name", path.display())),
            Err(problem) => self.fail_saving(problem),
        }
    }

    fn fail_saving(&mut self, problem: String) {
        self.after_save = None;
        self.messages.error(format!("Not saved. {problem}"));
    }

    pub(super) fn answered(&mut self, purpose: Purpose, path: PathBuf, ctx: &Context) {
        let with_ending = |ending: &str| {
            let has = path.extension().is_some_and(|e| e.eq_ignore_ascii_case(ending));
            if has { path.clone() } else { PathBuf::from(format!("{}.{ending}", path.display())) }
        };
        let id = self.tabs.front_id();
        match purpose {
            Purpose::OpenMaterial => self.load_path(&path, ctx),
            Purpose::SaveMaterial => {
                let path = if files::is_material_path(&path) { path } else { with_ending(files::MATERIAL_EXTENSION) };
                self.save_to(path, ctx);
            }
            Purpose::OpenLibrary => self.open_library(&path, ctx),
            Purpose::ChooseVersion(version) => self.chosen_version(version, path),
            Purpose::CompareRelease => self.set_release(path),
            Purpose::SaveReport => self.save_report(path, ctx),
            Purpose::SaveNotes => self.save_notes(path, ctx),
            Purpose::LoadModel => self.loader.start(Job::Model(path), ctx),
            Purpose::LoadEnvironment => self.loader.start(Job::Environment(path), ctx),
            Purpose::LoadTexture(property) => self.loader.start(Job::Texture(id, property, path), ctx),
            Purpose::LoadTextureSet => self.loader.start(Job::TextureSet(id, path), ctx),
            Purpose::LoadReference => self.loader.start(Job::Reference(path), ctx),
            Purpose::RenderPicture(format) => self.render_picture(exporting::with_ending(path, format), ctx),
            Purpose::WriteElsewhere(format) => self.write_elsewhere(exporting::with_ending(path, format), ctx),
            Purpose::TurntableFolder => self.turntable_folder(path, ctx),
            Purpose::SavePng => self.write_picture(with_ending("png"), ctx),
            Purpose::SaveExr => self.write_picture(with_ending("exr"), ctx),
            Purpose::SaveSheet | Purpose::SavePack => self.hand_out(purpose, path, ctx),
        }
    }

    /// Changes the document of a number, whether it is in front or not, as one step of this name.
    pub(super) fn edit_document(&mut self, id: u64, label: Option<&str>, edit: impl FnOnce(&mut Document)) {
        if id == self.tabs.front_id() {
            self.history.settle();
            edit(&mut self.editor.document);
            if let Some(label) = label {
                self.history.commit(label, &self.editor.document);
            }
        } else if let Some(work) = self.tabs.parked_mut(id) {
            edit(&mut work.document);
            if let Some(label) = label {
                work.history.commit(label, &work.document);
            }
        }
    }

    /// Takes what was loaded to where it belongs.
    pub(super) fn loaded(&mut self, done: Done) {
        for warning in done.warnings {
            self.messages.warning(warning);
        }
        match (done.job, done.result) {
            (_, Err(problem)) => self.messages.error(problem),
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
            (Job::Textures(id, ..), Ok(Loaded::Textures(textures))) => {
                self.edit_document(id, None, |document| Arc::make_mut(&mut document.textures).extend(textures));
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
        let document = &self.editor.document;
        let set = document.material.slots().filter(|(_, slot)| **slot != Slot::default()).count();
        let mut info = format!("Opened {}: {set} of {} properties set", path.display(), burnish_material::PROPERTY_COUNT);
        for (count, what) in
            [(document.file().unknown_keys().len(), "unknown kept"), (document.file().unreadable().len(), "unreadable kept")]
        {
            if count > 0 {
                info += &format!(", {count} {what}");
            }
        }
        self.messages.info(info);
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

    /// Brings back what a program that ended badly had not saved.
    pub(super) fn recover(&mut self, kept: &crate::recovery::Kept, ctx: &Context) {
        let parsed = MaterialFile::parse(&kept.text).and_then(|(file, _)| Ok((file, MaterialFile::parse(&kept.original)?.0)));
        match parsed {
            Ok((now, original)) => {
                let document = Document::recovered(original, kept.path.clone(), now.material().clone(), Arc::default());
                let (material, folder) = (document.material.clone(), document.folder().map(Path::to_path_buf));
                self.open_document(document);
                self.loader.start(Job::Textures(self.tabs.front_id(), Box::new(material), folder), ctx);
            }
            Err(error) => self.messages.error(format!("“{}” cannot be brought back: {error}", kept.title)),
        }
    }
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
