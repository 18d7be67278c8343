//! The merge that is being decided, and what becomes of its result.

use super::App;
use crate::dialogs::{Purpose, Version as Asked};
use crate::dock::Pane;
use crate::editor::Document;
use crate::library::edit;
use crate::merging::Merging;
use crate::panels::merge::{self, MergeAction, MergeView, Version};
use crate::sources::{Source, Sourced};
use burnish_material::merge::Side;
use egui::{Context, Ui};
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

/// What is merged and how it is decided.
pub(super) struct MergeWork {
    /// Base, mine and theirs.
    pub versions: [Option<Source>; 3],
    decided: BTreeMap<String, Side>,
    merging: Option<Known>,
}

/// A merge and what it is of.
struct Known {
    versions: [Option<Arc<Sourced>>; 3],
    merging: Merging,
}

impl Default for MergeWork {
    fn default() -> Self {
        Self { versions: [None, Some(Source::Front), Some(Source::Saved)], decided: BTreeMap::new(), merging: None }
    }
}

impl Known {
    fn is_of(&self, versions: &[Option<Arc<Sourced>>; 3]) -> bool {
        self.versions.iter().zip(versions).all(|(known, now)| match (known, now) {
            (Some(a), Some(b)) => Arc::ptr_eq(a, b),
            (a, b) => a.is_none() && b.is_none(),
        })
    }
}

impl MergeWork {
    /// Merges another one from now on.
    pub fn choose(&mut self, version: Version, source: Option<Source>) {
        self.versions[version as usize] = source;
        self.decided.clear();
    }
}

impl App {
    /// Opens the merge of versions.
    pub(super) fn merge_of(&mut self, base: Option<Source>, mine: Source, theirs: Source) {
        self.merge = MergeWork { versions: [base, Some(mine), Some(theirs)], ..MergeWork::default() };
        self.show_pane(Pane::Merge);
    }

    /// The pane.
    pub(super) fn merge_pane(&mut self, ui: &mut Ui) {
        let ctx = ui.ctx().clone();
        let sources = self.merge.versions.clone();
        let problem = self.read_versions(&sources, &ctx).err();
        let choices = self.source_choices();
        let target = self.merge_target();
        let view = MergeView {
            sources: sources.each_ref().map(Option::as_ref),
            choices: &choices,
            merging: match (&problem, &self.merge.merging) {
                (None, Some(known)) => Ok(&known.merging),
                (Some(problem), _) => Err(problem),
                (None, None) => Err(""),
            },
            target: target.as_deref(),
        };
        match merge::show(ui, &view, &mut self.merge.decided) {
            Some(MergeAction::Choose(version, source)) => self.merge.choose(version, source),
            Some(MergeAction::ChooseFile(version)) => {
                let asked = match version {
                    Version::Base => Asked::Base,
                    Version::Mine => Asked::Mine,
                    Version::Theirs => Asked::Theirs,
                };
                self.ask(Purpose::ChooseVersion(asked), &ctx);
            }
            Some(MergeAction::Open) => self.open_merged(),
            Some(MergeAction::Save) => self.save_merged(target, &ctx),
            None => {}
        }
    }

    /// Reads the versions and compares them, where that was not done yet. A sentence where it cannot be.
    fn read_versions(&mut self, sources: &[Option<Source>; 3], ctx: &Context) -> Result<(), String> {
        let mut versions: [Option<Arc<Sourced>>; 3] = [None, None, None];
        for (version, source) in versions.iter_mut().zip(sources) {
            *version = source.as_ref().map(|source| self.sourced(source, ctx)).transpose()?;
        }
        if self.merge.merging.as_ref().is_some_and(|known| known.is_of(&versions)) {
            return Ok(());
        }
        self.merge.merging = None;
        let [base, Some(mine), Some(theirs)] = &versions else { return Err("Choose two versions to merge.".to_owned()) };
        let merging = Merging::new(base.as_deref(), mine, theirs);
        self.merge.decided.retain(|key, _| merging.conflicts.iter().any(|conflict| conflict.key == *key));
        self.merge.merging = Some(Known { versions, merging });
        Ok(())
    }

    /// The file that the result can be written over: that of the first version, if it holds nothing else.
    fn merge_target(&self) -> Option<PathBuf> {
        let of = |document: &Document| document.path().filter(|_| !document.is_modified()).map(std::path::Path::to_path_buf);
        match self.merge.versions[Version::Mine as usize].as_ref()? {
            Source::File(path) => Some(path.clone()),
            Source::Front => of(&self.editor.document),
            Source::Tab(id) => of(self.tabs.documents(&self.editor.document).find(|(other, _)| other == id)?.1),
            Source::Opened | Source::Saved | Source::Side => None,
        }
    }

    fn open_merged(&mut self) {
        let Some(Known { versions: [_, Some(mine), Some(theirs)], merging }) = &self.merge.merging else { return };
        let material = merging.material(&self.merge.decided);
        let said = format!("Merged {} and {} into a new document.", mine.title, theirs.title);
        let textures = Arc::new(merging.textures.clone());
        let document = Document::recovered((*mine.file).clone(), mine.path.clone(), material, textures).without_path();
        self.open_document(document);
        self.messages.info(said);
    }

    fn save_merged(&mut self, target: Option<PathBuf>, ctx: &Context) {
        let (Some(path), Some(known)) = (target, &self.merge.merging) else { return };
        let [_, Some(mine), Some(theirs)] = &known.versions else { return };
        let (before, after) = (mine.file.text().to_owned(), known.merging.text(&self.merge.decided));
        let title = format!("Merge {} into {}", theirs.title, mine.title);
        self.edit_files_anew(move || edit::replace(&path, title, before, after), ctx);
    }
}
