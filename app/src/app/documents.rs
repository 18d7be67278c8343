//! Documents: opening, changing and closing them.

use super::App;
use super::pages::{Answer, question};
use crate::editor::Document;
use crate::files::{self, OpenedMaterial};
use crate::loading::Job;
use crate::tabs::Work;
use burnish_material::MaterialFile;
use burnish_presets::Preset;
use egui::{Context, ViewportCommand};
use std::path::Path;
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
                self.history.settle();
                self.editor.document = self.editor.document.replaced_by(Document::opened(OpenedMaterial::new(file)));
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
        self.open_document(Document::opened(OpenedMaterial::new(file)));
    }

    /// A new material in a tab of its own.
    pub(super) fn new_tab(&mut self) {
        let work = Work::new(self.new_document());
        self.with_front(|tabs, front| tabs.open(front, work));
        self.messages.info("New material: every property has its default.");
    }

    /// Brings a document to the front, in the place of one that is still new and untouched.
    pub(super) fn open_document(&mut self, document: Document) {
        let here = document.path();
        let known = self
            .tabs
            .documents(&self.editor.document)
            .position(|(_, other)| here.is_some() && other.path() == here && !other.is_modified());
        let work = Work::new(document);
        let in_front = &self.editor.document;
        let is_blank = in_front.path().is_none()
            && in_front.material == self.new_document().material
            && self.history.labels().count() == 1
            && !self.history.is_pending();
        self.with_front(|tabs, front| match known {
            Some(place) => {
                tabs.bring_to_front(place, front);
                *front = work;
            }
            None if is_blank => *front = work,
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

    /// Closes the document in front, and with it what waited for an answer about it.
    pub(super) fn go_on(&mut self, after: After, ctx: &Context) {
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

    /// Brings back what a program that ended badly had not saved.
    pub(super) fn recover(&mut self, kept: &crate::recovery::Kept, ctx: &Context) {
        let parsed = MaterialFile::parse(&kept.text).and_then(|(file, _)| Ok((file, MaterialFile::parse(&kept.original)?.0)));
        match parsed {
            Ok((now, original)) => {
                let document = Document::recovered(original, kept.path.clone(), now.material().clone(), Arc::default());
                let document = document.imported(kept.import.clone());
                let (mut material, folder) = (document.material.clone(), document.folder().map(Path::to_path_buf));
                // Images with relative names stand in the imported file, not beside it.
                let is_inside = |path: &str| files::texture_path(path, None).is_some_and(|path| path.is_relative());
                for def in burnish_material::PROPERTIES.iter().filter(|_| kept.import.is_some()) {
                    _ = material.slot_mut(def.id).texture.take_if(|texture| is_inside(&texture.path));
                }
                self.open_document(document);
                let id = self.tabs.front_id();
                self.loader.start(Job::Textures(id, Box::new(material), folder), ctx);
                if let Some(import) = &kept.import {
                    self.loader.start(Job::ImportedImages(id, import.clone()), ctx);
                }
            }
            Err(error) => self.messages.error(format!("“{}” cannot be brought back: {error}", kept.title)),
        }
    }
}
