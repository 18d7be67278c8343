//! What dropped files do: shown before they are let go, refused with a reason.

use super::App;
use super::library::holds_materials;
use crate::dock::Pane;
use crate::exchange::{Format, endings};
use crate::files;
use crate::loading::Job;
use crate::panels::viewport;
use crate::picture_file::{PictureError, embedded_material};
use burnish_assets::{is_environment_path, is_image_path, is_model_path};
use burnish_material::{Kind, Property};
use egui::Context;
use std::path::{Path, PathBuf};

/// Whether a picture says which material it shows. One whose own words are damaged is ours as well, so that loading tells what is wrong.
fn is_picture_of_ours(path: &Path) -> bool {
    match embedded_material(path) {
        Ok(material) => material.is_some(),
        Err(error) => matches!(error, PictureError::Job { .. } | PictureError::JobTooLarge { .. }),
    }
}

/// What a dropped file would do at a place.
enum Drop {
    /// Something, in words.
    Do(String, Job),
    /// Open it as a material.
    Open(String),
    /// Open the folder as library.
    Library(String),
    /// Nothing; the reason.
    Refuse(String),
}

impl App {
    /// Opens a file by its ending.
    pub fn load_path(&mut self, path: &Path, ctx: &Context) {
        let path = std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf());
        match self.drop_of(&path, None) {
            Drop::Do(_, job) => self.loader.start(job, ctx),
            Drop::Open(_) => self.loader.start(Job::Material(path), ctx),
            Drop::Library(_) => self.open_library(&path, ctx),
            Drop::Refuse(reason) => self.messages.warning(reason),
        }
    }

    /// What dropping a file on the row of a property, or anywhere else, would do.
    fn drop_of(&self, path: &Path, row: Option<Property>) -> Drop {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let id = self.tabs.front_id();
        let file = path.to_path_buf();
        if is_picture_of_ours(path) {
            return Drop::Do(format!("Open the material of the picture {name}"), Job::Picture(file));
        }
        if let Some(property) = row.filter(|_| is_image_path(path)) {
            return Drop::Do(format!("Use as map for {}", property.def().label), Job::Texture(id, property, file));
        }
        if path.is_dir() && holds_materials(path) {
            return Drop::Library(format!("Open {name} as library"));
        }
        if path.is_dir() {
            return Drop::Do(format!("Use the images of {name} as maps, matched by their names"), Job::TextureSet(id, file));
        }
        if Format::of(path).is_some_and(|format| format != Format::Native) {
            Drop::Do(format!("Open the materials and the mesh of {name}"), Job::Import(file))
        } else if files::is_material_path(path) {
            Drop::Open(format!("Open material {name}"))
        } else if is_model_path(path) {
            Drop::Do(format!("Show the material on {name}"), Job::Model(file))
        } else if is_environment_path(path) {
            Drop::Do(format!("Light the scene with {name}"), Job::Environment(file))
        } else if is_image_path(path) {
            Drop::Do(format!("Show {name} beside the view, to look at and pick colours from"), Job::Reference(file))
        } else {
            Drop::Refuse(format!(
                "{name}: expected a material ({}), a mesh (.gltf, .glb, .ply), an environment (.hdr, .exr), an image or a folder of images.",
                endings()
            ))
        }
    }

    /// Shows what hovered files would do, and takes dropped ones.
    pub(super) fn take_drops(&mut self, ctx: &Context) {
        let (hovered, dropped) = ctx.input(|i| {
            let hovered: Vec<PathBuf> = i.raw.hovered_files.iter().filter_map(|file| file.path.clone()).collect();
            let dropped: Vec<PathBuf> = i.raw.dropped_files.iter().map(|file| file.path().to_path_buf()).collect();
            (hovered, dropped)
        });
        let is_shown = self.dock.is_drawn(Pane::Properties) && self.editor.view.are_panels_shown;
        let row = ctx.pointer_latest_pos().and_then(|place| self.properties.row_at(place)).filter(|_| is_shown);
        let mapped = row.filter(|property| property.def().vary != burnish_material::Vary::Uniform);
        if let Some(path) = hovered.first() {
            let (text, is_refused) = match self.drop_of(path, mapped) {
                Drop::Do(text, _) | Drop::Open(text) | Drop::Library(text) => (text, false),
                Drop::Refuse(_) => {
                    (format!("{} cannot be used here", path.file_name().unwrap_or_default().to_string_lossy()), true)
                }
            };
            viewport::paint_drop_hint(ctx, &text, is_refused);
        }
        for path in dropped {
            // An image on a colour that can have no map is looked at for its colour.
            if let Some(property) = row.filter(|_| mapped.is_none() && is_image_path(&path))
                && property.def().default.kind() == Kind::Color
            {
                self.picking = Some(property);
            }
            match self.drop_of(&path, mapped) {
                Drop::Do(_, job) => self.loader.start(job, ctx),
                Drop::Open(_) => self.loader.start(Job::Material(path), ctx),
                Drop::Library(_) => self.open_library(&path, ctx),
                Drop::Refuse(reason) => self.messages.warning(reason),
            }
        }
    }
}
