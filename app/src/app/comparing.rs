//! Two materials beside each other: which they are, what differs, what is taken over, and their pictures.

use super::App;
use crate::background::Background;
use crate::dialogs::{Purpose, Version};
use crate::dock::Pane;
use crate::editor::Document;
use crate::library::edit;
use crate::panels::diff::{self, DiffAction, DiffView, Drawn, Pictures, entry_label};
use crate::panels::merge;
use crate::picture_diff::{self, Drawing, PictureDiff};
use crate::sources::{Live, Source, Sourced, Sources};
use burnish_material::Property;
use burnish_material::diff::{Change, file_changes, take};
use burnish_renderer::scene::{Camera, Scene};
use burnish_renderer::tonemap::Display;
use egui::{ColorImage, Context, TextureOptions, Ui};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Materials rest this long before they are drawn: a slider that moves changes them with every frame.
const REST: Duration = Duration::from_millis(400);
/// Columns and rows of a picture.
const SIDE: usize = 256;
/// Seconds after which a picture is done.
const SECONDS: f64 = 8.0;
/// Selected files of the library that are listed to choose from.
const MAX_CARDS: usize = 12;

/// What pictures are of.
struct Shown {
    sides: [Arc<Sourced>; 2],
    place: Place,
}

/// Where both are shown.
#[derive(PartialEq)]
struct Place {
    model: usize,
    environment: usize,
    rotation_deg: f32,
    camera: Camera,
    display: Display,
}

impl Shown {
    fn is_same(&self, other: &Self) -> bool {
        self.place == other.place && self.sides.iter().zip(&other.sides).all(|(a, b)| Arc::ptr_eq(a, b))
    }
}

/// The comparison and what belongs to it.
pub(super) struct CompareWork {
    /// What sources hold.
    pub sources: Sources,
    /// A and B.
    pub pair: [Source; 2],
    changes: Vec<Change>,
    /// What the changes are between.
    changes_of: Option<[Arc<Sourced>; 2]>,
    shown: Option<Shown>,
    since: Instant,
    drawing: Background<Option<PictureDiff>>,
    drawn: Option<Drawn>,
    /// Why nothing is drawn.
    reason: Option<String>,
    /// Whether the user wants it drawn in any case.
    is_asked: bool,
}

impl Default for CompareWork {
    fn default() -> Self {
        Self {
            sources: Sources::default(),
            pair: [Source::Opened, Source::Front],
            changes: Vec::new(),
            changes_of: None,
            shown: None,
            since: Instant::now(),
            drawing: Background::default(),
            drawn: None,
            reason: None,
            is_asked: false,
        }
    }
}

impl CompareWork {
    /// The drawing for the list of all work.
    pub fn work(&self) -> Option<crate::work::Work> {
        self.drawing.work(crate::work::Ends::PictureDiff)
    }

    /// Gives up drawing until somebody asks for it.
    pub fn end(&mut self) {
        if self.drawing.cancel() {
            self.reason = Some("Drawing was ended.".to_owned());
        }
    }

    /// Draws what was ended, or what need not be drawn.
    fn draw_after_all(&mut self) {
        (self.reason, self.is_asked) = (None, true);
    }

    /// Nobody looks: nothing is drawn, and later it begins anew.
    pub fn forget(&mut self) {
        if self.drawing.cancel() {
            self.shown = None;
        }
    }
}

impl App {
    /// What differs between the two materials that are compared, for tests.
    pub fn compared(&self) -> &[Change] {
        &self.compare.changes
    }

    /// Mean difference of both pictures once they are drawn, for tests.
    pub fn picture_difference(&self) -> Option<f64> {
        self.compare.drawn.as_ref().map(|drawn| drawn.mean)
    }

    /// What a source holds now; a sentence where it is not known yet, or not any more.
    pub(super) fn sourced(&mut self, source: &Source, ctx: &Context) -> Result<Arc<Sourced>, String> {
        let document = match source {
            Source::File(path) => {
                let read = self.compare.sources.file(path, ctx);
                return read.unwrap_or_else(|| Err(format!("Reading {}…", path.display())));
            }
            Source::Tab(id) => {
                self.tabs.documents(&self.editor.document).find(|(other, _)| other == id).map(|(_, document)| document)
            }
            _ => Some(&self.editor.document),
        };
        let Some(document) = document else { return Err("That document was closed.".to_owned()) };
        let (textures, path) = (document.textures.clone(), document.path().map(Path::to_path_buf));
        let title = named(document);
        let live = match source {
            Source::Opened | Source::Saved => {
                let is_saved = *source == Source::Saved;
                let file = if is_saved { document.saved_shared() } else { document.file_shared() };
                let title = format!("{title}, as {}", if is_saved { "saved" } else { "opened" });
                Live { title, material: file.material().clone(), file: Some(file), textures, path }
            }
            Source::Side => {
                let Some(side) = self.sides.stored() else { return Err("No other side is stored.".to_owned()) };
                let (title, material) = (format!("{title}, side {}", side.label), (*side.material).clone());
                Live { title, file: None, material, textures: side.textures.clone(), path }
            }
            _ => Live { title, file: Some(document.file_shared()), material: document.material.clone(), textures, path },
        };
        self.compare.sources.live(source, live).ok_or_else(|| "It cannot be written as a file.".to_owned())
    }

    /// What can be compared and merged.
    pub(super) fn source_choices(&self) -> Vec<(Source, String)> {
        let document = &self.editor.document;
        let title = named(document);
        let mut choices = vec![(Source::Front, title.clone()), (Source::Opened, format!("{title}, as opened"))];
        if document.path().is_some() {
            choices.push((Source::Saved, format!("{title}, as saved")));
        }
        if let Some(side) = self.sides.stored() {
            choices.push((Source::Side, format!("{title}, side {}", side.label)));
        }
        let front = self.tabs.front_id();
        let others = self.tabs.documents(document).filter(|(id, _)| *id != front);
        choices.extend(others.map(|(id, document)| (Source::Tab(id), named(document))));
        choices.extend(self.selected_cards().into_iter().take(MAX_CARDS).map(|path| {
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            (Source::File(path), name)
        }));
        choices
    }

    /// Shows two materials beside each other.
    pub(super) fn compare_sources(&mut self, a: Source, b: Source) {
        self.compare.pair = [a, b];
        self.show_pane(Pane::Diff);
    }

    /// Compares what is selected in the library: two files, or one with the document in front; else what was compared last.
    pub(super) fn compare_selected(&mut self) {
        match self.selected_cards().as_slice() {
            [a, b] => self.compare.pair = [Source::File(a.clone()), Source::File(b.clone())],
            [one] if self.editor.document.path() != Some(one) => self.compare.pair = [Source::File(one.clone()), Source::Front],
            _ => {}
        }
    }

    /// The pane.
    pub(super) fn diff_pane(&mut self, ui: &mut Ui) {
        let ctx = ui.ctx().clone();
        let pair = self.compare.pair.clone();
        let sides = [self.sourced(&pair[0], &ctx), self.sourced(&pair[1], &ctx)];
        if let [Ok(a), Ok(b)] = &sides {
            let is_same = self.compare.changes_of.as_ref().is_some_and(|[x, y]| Arc::ptr_eq(x, a) && Arc::ptr_eq(y, b));
            if !is_same {
                self.compare.changes = file_changes(&a.file, &b.file);
                self.compare.changes_of = Some([a.clone(), b.clone()]);
            }
            self.draw_both([a.clone(), b.clone()], &ctx);
        } else {
            (self.compare.changes, self.compare.changes_of) = (Vec::new(), None);
            self.compare.forget();
        }
        let choices = self.source_choices();
        let is_in_library = |path: &Path| self.library().is_some_and(|library| path.starts_with(library.root()));
        let is_changeable = |source: &Source| match source {
            Source::Front | Source::Tab(_) => true,
            // What was released stays as it is.
            Source::File(path) => is_in_library(path) || !self.is_released(path),
            Source::Opened | Source::Saved | Source::Side => false,
        };
        let can_unite = match &pair {
            [Source::File(a), Source::File(b)] => a != b && is_in_library(a) && is_in_library(b),
            _ => false,
        };
        let pictures = match (&self.compare.drawn, self.compare.drawing.share(), &self.compare.reason) {
            (Some(drawn), ..) => Pictures::Drawn(drawn),
            (None, Some(share), _) => Pictures::Drawing(share),
            (None, None, Some(reason)) => Pictures::None(reason),
            (None, None, None) => Pictures::Waiting,
        };
        let side = |number: usize| sides[number].as_ref().map(AsRef::as_ref).map_err(String::as_str);
        let view = DiffView {
            sources: [&pair[0], &pair[1]],
            choices: &choices,
            sides: [side(0), side(1)],
            changes: &self.compare.changes,
            can_take: [0, 1].map(|number| is_changeable(&pair[number]) && sides.iter().all(Result::is_ok)),
            can_unite,
            pictures,
        };
        let Some(action) = diff::show(ui, &view) else { return };
        match action {
            DiffAction::Choose(is_b, source) => self.compare.pair[usize::from(is_b)] = source,
            DiffAction::ChooseFile(is_b) => {
                let version = if is_b { Version::DiffB } else { Version::DiffA };
                self.ask(Purpose::ChooseVersion(version), &ctx);
            }
            DiffAction::Exchange => self.compare.pair.swap(0, 1),
            DiffAction::Take(is_b, keys) => {
                if let [Ok(a), Ok(b)] = &sides {
                    let (from, into) = if is_b { (a, b) } else { (b, a) };
                    self.take_entries(&pair[usize::from(is_b)], into, from, &keys, &ctx);
                }
            }
            DiffAction::Merge => self.merge_of(None, pair[0].clone(), pair[1].clone()),
            DiffAction::Unite => {
                if let [Source::File(a), Source::File(b)] = pair {
                    self.compare.pair = [Source::Opened, Source::Front];
                    self.unite(a, b, &ctx);
                }
            }
            DiffAction::EndPictures => self.compare.end(),
            DiffAction::DrawPictures => self.compare.draw_after_all(),
        }
    }

    /// Draws both where that was not done yet.
    fn draw_both(&mut self, sides: [Arc<Sourced>; 2], ctx: &Context) {
        match self.compare.drawing.poll() {
            Some(Ok(Some(drawn))) => self.compare.drawn = Some(textures_of(&drawn, ctx)),
            Some(Ok(None)) => {}
            Some(Err(problem)) => self.compare.reason = Some(problem),
            None => {}
        }
        let (Some(model), Some(environment)) = (&self.editor.model, &self.editor.environment) else { return };
        let view = &self.editor.view;
        let place = Place {
            model: Arc::as_ptr(model).addr(),
            environment: Arc::as_ptr(environment).addr(),
            rotation_deg: view.environment_deg,
            camera: view.orbit.camera(1.0),
            display: view.display,
        };
        let shown = Shown { sides, place };
        if self.compare.shown.as_ref().is_none_or(|known| !known.is_same(&shown)) {
            self.compare.drawing.cancel();
            (self.compare.drawn, self.compare.reason, self.compare.since) = (None, None, Instant::now());
            self.compare.is_asked = false;
            self.compare.shown = Some(shown);
        }
        let is_same_folder = |sides: &[Arc<Sourced>; 2]| sides[0].folder() == sides[1].folder();
        if self.compare.shown.as_ref().is_some_and(|shown| is_same_folder(&shown.sides))
            && !self.compare.is_asked
            && self.compare.changes.iter().all(|change| !change.is_visible)
        {
            self.compare.drawing.cancel();
            self.compare.reason = Some("They look the same: nothing that differs can be seen.".to_owned());
        }
        if self.compare.drawn.is_some() || self.compare.reason.is_some() || self.compare.drawing.is_running() {
            return;
        }
        let rest = REST.saturating_sub(self.compare.since.elapsed());
        if !rest.is_zero() {
            return ctx.request_repaint_after(rest);
        }
        let Some(Shown { sides, .. }) = &self.compare.shown else { return };
        let scene = |side: &Sourced| self.editor.scene_of(side.material.clone(), side.textures.clone(), 1.0);
        let (Some(a), Some(b)): (Option<Scene>, Option<Scene>) = (scene(&sides[0]), scene(&sides[1])) else { return };
        let drawing =
            Drawing { size: [SIDE; 2], seed: 0, threads: self.threads(), seconds: SECONDS, display: self.editor.view.display };
        self.compare.drawing.start("Drawing both materials", ctx, move |control| {
            picture_diff::draw([&a, &b], &drawing, &mut |share| control.tell(share), &|| control.is_cancelled())
        });
    }

    /// Gives a document or a file entries of another material, as one step.
    fn take_entries(&mut self, into: &Source, known: &Sourced, from: &Sourced, keys: &[String], ctx: &Context) {
        let what = match keys {
            [key] => {
                let property = Property::from_name(key.strip_suffix(".texture").unwrap_or(key));
                entry_label(key, property)
            }
            keys => format!("{} entries", keys.len()),
        };
        let label = format!("Take {what} of {}", from.title);
        let id = match into {
            Source::Front => self.tabs.front_id(),
            Source::Tab(id) => *id,
            Source::File(path) => {
                let (material, _) = from.seen_from(known.folder());
                let mut edited = (*known.material).clone();
                keys.iter().for_each(|key| _ = take(&mut edited, &material, key));
                let (path, before) = (path.clone(), known.file.text().to_owned());
                let after = known.file.to_text(&edited);
                return self.edit_files_anew(move || edit::replace(&path, label, before, after), ctx);
            }
            Source::Opened | Source::Saved | Source::Side => return,
        };
        self.edit_document(id, Some(&label), |document: &mut Document| {
            let (material, images) = from.seen_from(document.folder());
            keys.iter().for_each(|key| _ = take(&mut document.material, &material, key));
            let textures = Arc::make_mut(&mut document.textures);
            images.into_iter().for_each(|(name, image)| _ = textures.entry(name).or_insert(image));
        });
        self.messages.info(format!("{label}; undo takes it back."));
    }

    /// Compares or merges a file that was chosen.
    pub(super) fn chosen_version(&mut self, version: Version, path: PathBuf) {
        let source = Source::File(path);
        match version {
            Version::DiffA => self.compare.pair[0] = source,
            Version::DiffB => self.compare.pair[1] = source,
            Version::Base => self.merge.choose(merge::Version::Base, Some(source)),
            Version::Mine => self.merge.choose(merge::Version::Mine, Some(source)),
            Version::Theirs => self.merge.choose(merge::Version::Theirs, Some(source)),
        }
    }

    /// Makes two files one that has both names.
    pub(super) fn unite(&mut self, path: PathBuf, other: PathBuf, ctx: &Context) {
        self.edit_files_anew(move || edit::unite(&path, &other), ctx);
    }
}

/// What to call a document: its name, with that of its file where it is another one.
fn named(document: &Document) -> String {
    let (title, file) = (document.title(), document.path().and_then(Path::file_name));
    match file.map(|name| name.to_string_lossy().trim_end_matches(".asm.ron").to_owned()) {
        Some(file) if !file.eq_ignore_ascii_case(&title) => format!("{title} ({file})"),
        _ => title,
    }
}

fn textures_of(drawn: &PictureDiff, ctx: &Context) -> Drawn {
    let height = |bytes: &[u8]| bytes.len() / 3 / drawn.width.max(1);
    let texture = |name: &str, bytes: &[u8]| {
        let image = ColorImage::from_rgb([drawn.width, height(bytes)], &bytes[..3 * drawn.width * height(bytes)]);
        ctx.load_texture(name, image, TextureOptions::LINEAR)
    };
    let [a, b] = [drawn.bytes(0), drawn.bytes(1)];
    Drawn { textures: [texture("a", &a), texture("b", &b), texture("difference", &drawn.map.bytes)], mean: drawn.mean }
}
