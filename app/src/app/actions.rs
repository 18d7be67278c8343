//! What commands, drops and dialogs do to the application.

use super::{After, App};
use crate::command::Command;
use crate::dialogs::{Purpose, Question};
use crate::editor::{Document, View, ViewMode};
use crate::export::{self, Picture};
use crate::files::{self, OpenedMaterial};
use crate::history::History;
use crate::live_denoise::DenoisedPicture;
use crate::live_final::{LiveFinal, SEED};
use crate::loading::{Done, Job, Loaded};
use crate::panels::viewport;
use burnish_assets::{is_environment_path, is_image_path, is_model_path};
use burnish_material::{Material, MaterialFile, Property, Slot, TextureRef};
use burnish_presets::Preset;
use burnish_renderer::path::StopReason;
use burnish_renderer::stability::Fix;
use burnish_renderer::worker::Snapshot;
use egui::{Context, Modal, ViewportCommand};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A third of a stop.
const EXPOSURE_STEP: f32 = 1.0 / 3.0;

impl App {
    /// Whether a command would do something now.
    pub(super) fn is_possible(&self, command: Command) -> bool {
        match command {
            Command::Undo => self.history.undo_label().is_some(),
            Command::Redo => self.history.redo_label().is_some(),
            Command::ResetAll => self.editor.document.material.slots().any(|(_, slot)| *slot != Slot::default()),
            // The preview's own place says why there is none, and tries again.
            Command::ShowBoth | Command::ShowWipe | Command::ShowDifference | Command::ToggleFinal => {
                self.preview.problem().is_none()
            }
            _ => true,
        }
    }

    /// Does what a command says.
    pub fn carry_out(&mut self, command: Command, ctx: &Context) {
        if !self.is_possible(command) {
            return;
        }
        let view = &mut self.editor.view;
        match command {
            Command::New => self.unless_unsaved(After::New, ctx),
            Command::Open => self.unless_unsaved(After::AskOpen, ctx),
            Command::Save => self.save(ctx),
            Command::SaveAs => self.ask(Purpose::SaveMaterial, ctx),
            Command::LoadModel => self.ask(Purpose::LoadModel, ctx),
            Command::LoadEnvironment => self.ask(Purpose::LoadEnvironment, ctx),
            Command::SavePng => self.ask(Purpose::SavePng, ctx),
            Command::SaveExr => self.ask(Purpose::SaveExr, ctx),
            Command::Quit => self.unless_unsaved(After::Close, ctx),
            Command::Undo => {
                if let Some((label, document)) = self.history.undo() {
                    self.return_to(document, format!("Undid: {label}"));
                }
            }
            Command::Redo => {
                if let Some((label, document)) = self.history.redo() {
                    self.return_to(document, format!("Redid: {label}"));
                }
            }
            Command::ResetAll => {
                for def in burnish_material::PROPERTIES {
                    *self.editor.document.material.slot_mut(def.id) = Slot::default();
                }
                self.history.commit("Reset all properties", &self.editor.document);
            }
            Command::ToggleFinal => {
                view.mode = if view.mode == ViewMode::Final { ViewMode::Preview } else { ViewMode::Final };
            }
            Command::ShowPreview => view.mode = ViewMode::Preview,
            Command::ShowFinal => view.mode = ViewMode::Final,
            Command::ShowBoth => view.mode = ViewMode::Both,
            Command::ShowWipe => view.mode = ViewMode::Wipe,
            Command::ShowDifference => view.mode = ViewMode::Difference,
            Command::Frame => {
                if let Some(model) = &self.editor.model {
                    view.orbit.frame(model);
                }
            }
            Command::ResetView => {
                let fresh = View::default();
                view.environment_deg = fresh.environment_deg;
                view.display = fresh.display;
                if let Some(model) = &self.editor.model {
                    view.orbit = crate::editor::Orbit::of_model(model);
                }
            }
            Command::ExposureUp => view.display.exposure_ev = third(view.display.exposure_ev + EXPOSURE_STEP),
            Command::ExposureDown => view.display.exposure_ev = third(view.display.exposure_ev - EXPOSURE_STEP),
            Command::ToggleBloom => view.is_bloom_on = !view.is_bloom_on,
            Command::ToggleDenoise => view.is_denoise_on = !view.is_denoise_on,
            Command::TogglePanels => view.are_panels_shown = !view.are_panels_shown,
            Command::ToggleChart => view.is_chart_shown = !view.is_chart_shown,
            Command::ToggleStability => view.is_stability_shown = !view.is_stability_shown,
        }
    }

    /// Makes the changes of a fix as one step of its name.
    pub(super) fn apply_fix(&mut self, fix: &Fix) {
        self.history.settle();
        fix.apply(&mut self.editor.document.material);
        self.history.commit(fix.name.as_str(), &self.editor.document);
        self.messages.info(format!("{}; undo takes it back.", fix.name));
    }

    fn return_to(&mut self, document: Document, info: String) {
        // Images loaded since stay loaded: an undone map may come back.
        let loaded = Arc::clone(&self.editor.document.textures);
        let is_same_file = self.editor.document.shares_origin(&document);
        self.editor.document = document;
        if is_same_file && loaded.len() > self.editor.document.textures.len() {
            self.editor.document.textures = loaded;
        }
        self.messages.info(info);
    }

    /// Takes the place of the document by a preset, as one step that undo takes back.
    pub fn load_preset(&mut self, preset: &'static Preset) {
        match preset.parse() {
            Ok((file, _)) => {
                let opened = OpenedMaterial { path: None, file, warnings: Vec::new(), textures: Arc::default() };
                self.history.settle();
                self.editor.document = self.editor.document.replaced_by(Document::opened(opened));
                self.history.commit(format!("Load preset {}", preset.name), &self.editor.document);
                self.messages.info(format!("Loaded preset {}; undo brings back what was here before.", preset.name));
            }
            Err(error) => self.messages.error(format!("The preset {} cannot be read: {error}", preset.name)),
        }
    }

    /// Opens a file by its ending.
    pub fn load_path(&mut self, path: &Path, ctx: &Context) {
        let path = std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf());
        if files::is_material_path(&path) {
            self.unless_unsaved(After::Open(path), ctx);
        } else if is_model_path(&path) {
            self.loader.start(Job::Model(path), ctx);
        } else if is_environment_path(&path) {
            self.loader.start(Job::Environment(path), ctx);
        } else {
            self.messages.warning(refusal(&path));
        }
    }

    /// Goes on at once, or after asking what to do with unsaved changes.
    fn unless_unsaved(&mut self, after: After, ctx: &Context) {
        self.history.settle();
        if self.editor.document.is_modified() {
            self.asking = Some(after);
        } else {
            self.go_on(after, ctx);
        }
    }

    fn go_on(&mut self, after: After, ctx: &Context) {
        match after {
            After::New => {
                self.editor.document = Document::new(Material::named("New material"));
                self.history = History::new(&self.editor.document);
                self.messages.info("New material: every property has its default.");
            }
            After::AskOpen => self.ask(Purpose::OpenMaterial, ctx),
            After::Open(path) => self.loader.start(Job::Material(path), ctx),
            After::Close => {
                self.is_closing = true;
                ctx.send_viewport_cmd(ViewportCommand::Close);
            }
        }
    }

    fn ask(&mut self, purpose: Purpose, ctx: &Context) {
        let document = &self.editor.document;
        let stem: String = document.title().to_lowercase().chars().map(|c| if c.is_alphanumeric() { c } else { '-' }).collect();
        let stem = stem.trim_matches('-');
        let own_name = document.path().and_then(Path::file_name).map(|name| name.to_string_lossy().into_owned());
        let file_name = match purpose {
            Purpose::SaveMaterial => own_name.unwrap_or_else(|| format!("{stem}.{}", files::MATERIAL_EXTENSION)),
            Purpose::SavePng => format!("{stem}.png"),
            Purpose::SaveExr => format!("{stem}.exr"),
            _ => String::new(),
        };
        let folder = document.folder().map(Path::to_path_buf);
        self.dialogs.ask(Question { purpose, folder, file_name }, ctx);
    }

    /// Asks for an image for a property.
    pub(super) fn ask_for_map(&mut self, property: Property, ctx: &Context) {
        self.ask(Purpose::LoadTexture(property), ctx);
    }

    fn save(&mut self, ctx: &Context) {
        match self.editor.document.path().map(Path::to_path_buf) {
            Some(path) => self.save_to(path, ctx),
            None => self.ask(Purpose::SaveMaterial, ctx),
        }
    }

    /// Writes the document; says what was changed, or why nothing was written.
    fn save_to(&mut self, path: PathBuf, ctx: &Context) {
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
                self.messages.info(format!("{}: saved, reread, {values}, all else identical", path.display()));
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

    /// Writes the picture that is shown, on a thread of its own.
    fn write_picture(&mut self, path: PathBuf, ctx: &Context) {
        let view = self.final_view.as_ref().filter(|_| self.editor.view.mode.has_final());
        let denoised = view.and_then(LiveFinal::denoised);
        let shown = denoised.map(|denoised| &denoised.raw).or_else(|| view.and_then(LiveFinal::newest));
        let picture = if let Some(snapshot) = shown {
            final_picture(snapshot, denoised)
        } else {
            match self.preview.read_linear() {
                Ok((width, height, pixels)) => {
                    Picture { width: width as usize, height: height as usize, pixels, ..Picture::default() }
                }
                Err(problem) => {
                    self.messages.error(format!("The picture was not written: {problem}."));
                    return;
                }
            }
        };
        let (width, height) = (picture.width, picture.height);
        let note = denoised.map_or_else(String::new, |denoised| format!(". {}; the raw picture is kept", denoised.label()));
        let (display, sender, ctx) = (self.editor.view.display, self.writer.clone(), ctx.clone());
        std::thread::spawn(move || {
            let result = export::write(&path, &picture, display)
                .map(|written| {
                    let names: Vec<String> = written.iter().map(|path| path.display().to_string()).collect();
                    format!("Wrote {} ({width} × {height}){note}", names.join(", "))
                })
                .map_err(|error| error.to_string());
            let _ = sender.send(result);
            ctx.request_repaint();
        });
    }

    /// Takes what finished in the background.
    pub(super) fn collect(&mut self, ctx: &Context) {
        while let Some((purpose, path)) = self.dialogs.poll() {
            match path {
                Some(path) => self.answered(purpose, path, ctx),
                None => self.after_save = None,
            }
        }
        while let Ok(written) = self.written.try_recv() {
            match written {
                Ok(info) => self.messages.info(info),
                Err(problem) => self.messages.error(problem),
            }
        }
        while let Some(done) = self.loader.poll() {
            self.loaded(done);
        }
    }

    fn answered(&mut self, purpose: Purpose, path: PathBuf, ctx: &Context) {
        let with_ending = |ending: &str| {
            let has = path.extension().is_some_and(|e| e.eq_ignore_ascii_case(ending));
            if has { path.clone() } else { PathBuf::from(format!("{}.{ending}", path.display())) }
        };
        match purpose {
            Purpose::OpenMaterial => self.go_on(After::Open(path), ctx),
            Purpose::SaveMaterial => {
                let path = if files::is_material_path(&path) { path } else { with_ending(files::MATERIAL_EXTENSION) };
                self.save_to(path, ctx);
            }
            Purpose::LoadModel => self.loader.start(Job::Model(path), ctx),
            Purpose::LoadEnvironment => self.loader.start(Job::Environment(path), ctx),
            Purpose::LoadTexture(property) => self.loader.start(Job::Texture(property, path), ctx),
            Purpose::SavePng => self.write_picture(with_ending("png"), ctx),
            Purpose::SaveExr => self.write_picture(with_ending("exr"), ctx),
        }
    }

    fn loaded(&mut self, done: Done) {
        if matches!(done.result, Ok(Loaded::Material(_))) {
            self.messages.clear();
        }
        for warning in done.warnings {
            self.messages.warning(warning);
        }
        match done.result {
            Err(problem) => self.messages.error(problem),
            Ok(Loaded::Material(opened)) => {
                let path = opened.path.clone().unwrap_or_default();
                self.editor.document = Document::opened(*opened);
                self.history = History::new(&self.editor.document);
                let document = &self.editor.document;
                let set = document.material.slots().filter(|(_, slot)| **slot != Slot::default()).count();
                let mut info = format!("Opened {}: {set} of {} properties set", path.display(), burnish_material::PROPERTY_COUNT);
                for (count, what) in [
                    (document.file().unknown_keys().len(), "unknown kept"),
                    (document.file().unreadable().len(), "unreadable kept"),
                ] {
                    if count > 0 {
                        info += &format!(", {count} {what}");
                    }
                }
                self.messages.info(info);
            }
            Ok(Loaded::Textures(textures)) => {
                Arc::make_mut(&mut self.editor.document.textures).extend(textures);
            }
            Ok(Loaded::Texture(property, path, image)) => {
                let name = files::texture_name(&path, self.editor.document.folder());
                Arc::make_mut(&mut self.editor.document.textures).insert(name.clone(), image);
                let slot = self.editor.document.material.slot_mut(property);
                match &mut slot.texture {
                    Some(texture) => texture.path = name,
                    None => slot.texture = Some(TextureRef::new(name)),
                }
                self.messages.info(format!("{} reads {}", property.def().label, path.display()));
            }
            Ok(Loaded::Model(model, path)) => {
                if path.is_some() || self.editor.model.is_some() {
                    self.messages.info(format!("Showing {}", model.name));
                }
                self.editor.set_model(*model);
            }
            Ok(Loaded::Environment(environment, path)) => {
                if path.is_some() || self.editor.environment.is_some() {
                    self.messages.info(format!("Lit by {}", environment.name));
                }
                self.editor.environment = Some(environment);
            }
        }
    }

    /// Shows what hovered files would do, and takes dropped ones.
    pub(super) fn take_drops(&mut self, ctx: &Context) {
        let (hovered, dropped) = ctx.input(|i| {
            let hovered: Vec<PathBuf> = i.raw.hovered_files.iter().filter_map(|file| file.path.clone()).collect();
            let dropped: Vec<PathBuf> = i.raw.dropped_files.iter().map(|file| file.path().to_path_buf()).collect();
            (hovered, dropped)
        });
        let row = ctx
            .pointer_latest_pos()
            .and_then(|place| self.properties.map_row_at(place))
            .filter(|_| self.editor.view.are_panels_shown);
        if let Some(path) = hovered.first() {
            let (text, is_refused) = match row.filter(|_| is_image_path(path)) {
                Some(property) => (format!("Use as map for {}", property.def().label), false),
                None => drop_text(path),
            };
            viewport::paint_drop_hint(ctx, &text, is_refused);
        }
        for path in dropped {
            match row.filter(|_| is_image_path(&path)) {
                Some(property) => self.loader.start(Job::Texture(property, path), ctx),
                None => self.load_path(&path, ctx),
            }
        }
    }

    /// Asks what to do with unsaved changes.
    pub(super) fn ask_about_unsaved(&mut self, ctx: &Context) {
        let Some(after) = self.asking.clone() else { return };
        let title = self.editor.document.title();
        let response = Modal::new(egui::Id::unique("unsaved")).show(ctx, |ui| {
            ui.set_width(340.0);
            ui.heading("Unsaved changes");
            ui.add_space(4.0);
            ui.label(format!("“{title}” has changes that are not saved."));
            ui.add_space(10.0);
            ui.horizontal(|ui| {
                let save = ui.button("Save").clicked();
                let discard = ui.button("Don’t save").clicked();
                let cancel = ui.button("Cancel").clicked();
                (save, discard, cancel)
            })
            .inner
        });
        let (save, discard, cancel) = response.inner;
        if save {
            self.asking = None;
            self.after_save = Some(after);
            self.save(ctx);
        } else if discard {
            self.asking = None;
            self.go_on(after, ctx);
        } else if cancel || response.should_close() {
            self.asking = None;
        }
    }

    /// Keeps the title current and asks before closing.
    pub(super) fn mind_the_window(&mut self, ctx: &Context) {
        if ctx.input(|i| i.viewport().close_requested()) && !self.is_closing {
            self.history.settle();
            if self.editor.document.is_modified() {
                ctx.send_viewport_cmd(ViewportCommand::CancelClose);
                self.asking = Some(After::Close);
            }
        }
        let document = &self.editor.document;
        let mark = if document.is_modified() { " •" } else { "" };
        let title = format!("{}{mark} — Burnish", document.title());
        if title != self.title {
            ctx.send_viewport_cmd(ViewportCommand::Title(title.clone()));
            self.title = title;
        }
    }
}

/// A picture of the final view for a file. The job says how far it is and what ended it; of a denoised picture also who denoised, and the
/// raw one goes with it.
fn final_picture(raw: &Snapshot, denoised: Option<&DenoisedPicture>) -> Picture {
    let mut job = export::reached(raw.spp, raw.done.map(StopReason::word), raw.error.as_ref());
    let mut say = |key: &str, value: serde_json::Value| job.insert(key.to_owned(), value);
    say("program", concat!("Burnish ", env!("CARGO_PKG_VERSION")).into());
    say("view", "final".into());
    say("seed", SEED.into());
    say("seconds", raw.seconds.into());
    say("denoiser", denoised.map(|denoised| denoised.denoiser.as_str()).into());
    let error = denoised.map(|denoised| &denoised.error);
    say("relmse_estimate_denoised", error.map(|error| error.relmse).into());
    say("relmse_low_denoised", error.map(|error| error.low).into());
    say("relmse_high_denoised", error.map(|error| error.high).into());
    Picture {
        width: raw.width,
        height: raw.height,
        pixels: denoised.map_or(&raw.pixels, |denoised| &denoised.picture.pixels).clone(),
        raw: denoised.map(|_| raw.pixels.clone()),
        job: Some(job.into()),
        ..Picture::default()
    }
}

/// Exposure on whole thirds of a stop.
fn third(ev: f32) -> f32 {
    (ev * 3.0).round() / 3.0
}

fn file_name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

/// Why a dropped file does nothing.
fn refusal(path: &Path) -> String {
    let name = file_name(path);
    if is_image_path(path) {
        format!("{name} is an image: drop it on the row of a property that can have a map, for example Roughness.")
    } else {
        format!(
            "{name}: expected a material (.asm.ron), a mesh (.gltf, .glb, .ply), an environment (.hdr, .exr) or an image on a property."
        )
    }
}

/// What dropping a file would do, and whether that is nothing.
fn drop_text(path: &Path) -> (String, bool) {
    let name = file_name(path);
    if files::is_material_path(path) {
        (format!("Open material {name}"), false)
    } else if is_model_path(path) {
        (format!("Show the material on {name}"), false)
    } else if is_environment_path(path) {
        (format!("Light the scene with {name}"), false)
    } else if is_image_path(path) {
        (format!("{name}: drop it on a property’s row to use it as a map"), true)
    } else {
        (format!("{name} cannot be used here"), true)
    }
}
