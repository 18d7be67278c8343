//! Asking for files and folders, and what goes on with the answers.

use super::App;
use super::exporting;
use crate::dialogs::{Purpose, Question};
use crate::files;
use crate::loading::Job;
use burnish_material::Property;
use egui::Context;
use std::path::{Path, PathBuf};

impl App {
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
            Purpose::ExportMaterial(format) => format!("{stem}.{}", format.def().ending),
            Purpose::SaveReport => "report.json".to_owned(),
            Purpose::SaveNotes => "changes.md".to_owned(),
            _ => String::new(),
        };
        let folder = document.folder().or(document.import().and_then(Path::parent)).map(Path::to_path_buf);
        self.dialogs.ask(Question { purpose, folder, file_name }, ctx);
    }

    /// Asks for an image for a property.
    pub(super) fn ask_for_map(&mut self, property: Property, ctx: &Context) {
        self.ask(Purpose::LoadTexture(property), ctx);
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
            Purpose::ExportMaterial(format) => {
                // An ending that is typed says more than the list.
                let is_named = crate::exchange::Format::of(&path).is_some_and(|named| named != crate::exchange::Format::Native);
                self.export_material(if is_named { path } else { with_ending(format.def().ending) }, ctx);
            }
        }
    }
}
