//! Exports of the material in front in other programs' formats: what it costs is shown first, the rest happens in the background.

use super::App;
use crate::background::Background;
use crate::dialogs::Purpose;
use crate::exchange::measure::{Measured, Shown, measure, without_native_copy};
use crate::exchange::save::{SaveOptions, Saved, Source, save};
use crate::exchange::{ExchangeError, Format};
use crate::library::setup::{Frame, Setup, Stage};
use crate::pages::Page;
use crate::panels::exchange_page::{ExchangeAction, ExchangePage};
use crate::picture_diff::Drawing;
use crate::work::{Ends, Work};
use burnish_assets::Role;
use burnish_material::Material;
use burnish_material::exchange::ShadingModel;
use burnish_material::exchange::model::Context as Scale;
use egui::{Context, Ui};
use std::path::PathBuf;

/// Columns and rows of the pictures that are compared.
const SIDE: usize = 192;
/// Seconds for each of them, at most.
const SECONDS: f64 = 8.0;

/// The page, and what is being measured and written.
#[derive(Default)]
pub(super) struct Exchanging {
    page: ExchangePage,
    measuring: Background<Option<(&'static ShadingModel, Box<Material>, Measured)>>,
    saving: Background<(PathBuf, Result<Saved, ExchangeError>)>,
}

impl App {
    /// Opens the page.
    pub(super) fn open_exchange(&mut self) {
        self.pages.open(Page::Exchange);
    }

    /// The page; whether it stays open.
    pub(super) fn exchange_page(&mut self, ui: &mut Ui) -> bool {
        let share = self.exchanging.measuring.share();
        let action = self.exchanging.page.show(ui, &self.editor.document.material, share);
        let ctx = ui.ctx().clone();
        match action {
            None => {}
            Some(ExchangeAction::Measure) => self.measure_exchange(&ctx),
            Some(ExchangeAction::Stop) => self.end_work(Ends::Measuring, &ctx),
            Some(ExchangeAction::Export) => {
                self.ask(Purpose::ExportMaterial(self.exchanging.page.format), &ctx);
                return false;
            }
        }
        true
    }

    fn measure_exchange(&mut self, ctx: &Context) {
        let document = &self.editor.document;
        let (Some(model), Some(stage)) = (self.exchanging.page.model(), Stage::standard()) else { return };
        let (material, textures) = (document.material.clone(), document.textures.clone());
        let rows = self.exchanging.page.rows().to_vec();
        let drawing =
            Drawing { size: [SIDE; 2], seed: 0, threads: self.threads(), seconds: SECONDS, display: self.editor.view.display };
        self.exchanging.measuring.start("Measuring what other programs see", ctx, move |control| {
            let setup = Setup::new(stage, Frame::default(), Vec::new());
            let before = Shown { material: &material, textures: &textures };
            let (other, images) = without_native_copy(model, before, &Scale::of(&material));
            let after = Shown { material: &other, textures: &images };
            let tell = &mut |share| control.tell(share);
            let measured = measure(&setup, before, after, &rows, &drawing, tell, &|| control.is_cancelled())?;
            Some((model, Box::new(material), measured))
        });
    }

    /// Writes the material into a file that was chosen.
    pub(super) fn export_material(&mut self, path: PathBuf, ctx: &Context) {
        if self.exchanging.saving.is_running() {
            return self.messages.warning("An export is still being written; try again when it is done.");
        }
        let document = &self.editor.document;
        let source = Source {
            material: document.material.clone(),
            file: Some(document.file_shared()),
            folder: document.folder().map(PathBuf::from),
            textures: (*document.textures).clone(),
            embedded: document.embedded().map(|(path, bytes)| (path.clone(), bytes.clone())).collect(),
        };
        let model = self.editor.model.as_ref().filter(|_| self.exchanging.page.has_mesh);
        let mesh = model.and_then(|model| {
            let object = model.parts.iter().find(|(role, _)| *role == Role::Object)?;
            Some((object.1.clone(), model.unit_mm / 1000.0))
        });
        // A name of another format was perhaps chosen.
        let models = Format::of(&path).map_or(&[][..], |format| format.def().models);
        let chosen = self.exchanging.page.model();
        let model = chosen.filter(|chosen| models.iter().any(|model| model.name == chosen.name));
        self.exchanging.saving.start("Exporting the material", ctx, move |control| {
            let options = SaveOptions { mesh: mesh.as_ref().map(|(mesh, unit)| (&**mesh, *unit)), model, is_bare: false };
            let go_on = |share: f32| {
                control.tell(share);
                !control.is_cancelled()
            };
            let saved = save(&[source], &path, options, &go_on);
            (path, saved)
        });
    }

    /// Takes what was measured and written. Once per frame.
    pub(super) fn collect_exchange(&mut self) {
        match self.exchanging.measuring.poll() {
            Some(Ok(Some((model, material, measured)))) => self.exchanging.page.take_measured(model, &material, measured),
            Some(Err(problem)) => self.messages.error(problem),
            Some(Ok(None)) | None => {}
        }
        match self.exchanging.saving.poll() {
            None => {}
            Some(Ok((path, Ok(saved)))) => {
                saved.notes.into_iter().for_each(|note| self.messages.warning(note));
                let more = match saved.files.len() {
                    0 | 1 => String::new(),
                    count => format!(", with {} more files beside it", count - 1),
                };
                self.messages.info(format!("Exported {}{more}.", path.display()));
            }
            Some(Ok((_, Err(error)))) => self.messages.error(format!("Not exported. {error}")),
            Some(Err(problem)) => self.messages.error(problem),
        }
    }

    /// What is being measured and written, for the list of work.
    pub(super) fn exchange_work(&self) -> impl Iterator<Item = Work> {
        [self.exchanging.measuring.work(Ends::Measuring), self.exchanging.saving.work(Ends::Exchange)].into_iter().flatten()
    }

    /// Ends measuring.
    pub(super) fn end_measuring(&mut self) {
        self.exchanging.measuring.cancel();
    }

    /// Ends writing at its next seam.
    pub(super) fn end_exchange(&mut self) {
        self.exchanging.saving.end();
    }
}
