//! Saving the document in front: what is written is read again and compared.

use super::App;
use crate::dialogs::Purpose;
use crate::files;
use burnish_material::MaterialFile;
use egui::Context;
use std::path::{Path, PathBuf};

impl App {
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
        let images = document.embedded().try_for_each(|(name, bytes)| save_image(&path.with_file_name(name), bytes));
        let written = images.and_then(|()| files::save_atomic(&path, text.as_bytes()).map_err(|error| error.to_string()));
        let saved = written.and_then(|()| {
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
}

/// Writes an image that came inside of another file. What is there already and another one stays as it is: an error.
fn save_image(path: &Path, bytes: &[u8]) -> Result<(), String> {
    match files::read_file(path, bytes.len() as u64) {
        Ok(old) if old == bytes => return Ok(()),
        _ if path.exists() => {
            return Err(format!(
                "{}: expected no file or the same image, found another; save into another folder",
                path.display()
            ));
        }
        _ => {}
    }
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).map_err(|error| format!("{}: cannot be made: {error}", folder.display()))?;
    }
    files::save_atomic(path, bytes).map_err(|error| error.to_string())
}
