//! What is remembered between runs: preferences, layout, recent files, and unsaved work should the program end badly.

use super::App;
use crate::bookmarks;
use crate::dock::Dock;
use crate::editor::Orbit;
use crate::keymap::Keymap;
use crate::layout_file;
use crate::pages::Page;
use crate::places::Places;
use crate::preferences::Preferences;
use crate::recent::Recent;
use crate::recovery::{self, Abandoned, Kept, Store};
use crate::theme;
use crate::watch::Watch;
use egui::Context;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant, SystemTime};

/// Where things are kept, and when that was done last.
#[derive(Default)]
pub(super) struct Keeping {
    places: Places,
    recent: Recent,
    store: Option<Store>,
    watch: Option<Watch>,
    /// What programs that ended badly left, until the user says what to do with it.
    pub left: Vec<Abandoned>,
    watched: BTreeSet<PathBuf>,
    stored: Option<Instant>,
    /// What the disk holds.
    preferences: Preferences,
    layout: Option<String>,
    bookmarks: Vec<Orbit>,
}

impl Keeping {
    /// The folders.
    pub fn places(&self) -> &Places {
        &self.places
    }

    /// Files that were open lately, newest first.
    pub fn recent(&self) -> &[PathBuf] {
        self.recent.paths()
    }

    /// Whether one of them is known not to be there.
    pub fn is_missing(&mut self, path: &Path) -> bool {
        self.recent.is_missing(path)
    }

    /// A file was opened or saved.
    pub fn opened(&mut self, path: &Path) {
        self.recent.add(path);
        if let Some(state) = &self.places.state {
            // Not being remembered is no reason to disturb anybody.
            _ = self.recent.save(state);
        }
    }

    /// This program wrote a file itself.
    pub fn saved(&self, path: &Path) {
        if let Some(watch) = &self.watch {
            watch.seen(path);
        }
    }
}

impl App {
    /// Remembers in these folders, and takes up what is there.
    #[must_use]
    pub fn keep_in(mut self, places: Places, ctx: &Context) -> Self {
        if let Some(config) = &places.config {
            let (preferences, problems) = Preferences::load(config);
            problems.into_iter().for_each(|problem| self.messages.warning(problem));
            let (keymap, problems) = Keymap::from_stored(&preferences.shortcuts);
            problems.into_iter().for_each(|problem| self.messages.warning(problem));
            (self.preferences, self.keymap) = (preferences.clone(), keymap);
            self.keeping.preferences = preferences;
            self.editor.view.display.transform = self.preferences.display;
            self.editor.document = self.new_document();
            self.history = crate::history::History::new(&self.editor.document);
            self.apply_preferences(ctx);
            self.load_first_scene(ctx);
        }
        if let Some(state) = &places.state {
            let (recent, problems) = Recent::load(state);
            self.keeping.recent = recent;
            let wake = ctx.clone();
            self.keeping.recent.look(move || wake.request_repaint());
            problems.into_iter().for_each(|problem| self.messages.warning(problem));
            let (layout, problems) = layout_file::load_layout(state);
            problems.into_iter().for_each(|problem| self.messages.warning(problem));
            if let Some(text) = layout {
                match Dock::from_text(&text) {
                    Some(dock) => self.dock = dock,
                    None => self.messages.warning(layout_file::set_layout_aside(state, "expected a layout with every panel")),
                }
                self.keeping.layout = Some(text);
            }
            let (cameras, problem) = bookmarks::load_bookmarks(state);
            problem.into_iter().for_each(|problem| self.messages.warning(problem));
            self.editor.view.bookmarks.clone_from(&cameras);
            self.keeping.bookmarks = cameras;
            let (left, problems) = recovery::left_behind(state);
            problems.into_iter().for_each(|problem| self.messages.warning(problem));
            if !left.is_empty() {
                self.keeping.left = left;
                self.pages.open(Page::Recovery);
            }
            match Store::open(state) {
                Ok(store) => self.keeping.store = Some(store),
                Err(error) => self.messages.warning(format!("Unsaved work is not kept for a crash: {error}")),
            }
        }
        self.keeping.places = places;
        let wake = ctx.clone();
        self.keeping.watch = Some(Watch::new(Box::new(move || wake.request_repaint())));
        self.reopen_library(ctx);
        self
    }

    /// Makes the window as the user prefers it.
    pub(super) fn apply_preferences(&mut self, ctx: &Context) {
        let Preferences { theme, text_scale, is_motion_reduced, .. } = self.preferences;
        theme::apply(ctx, theme, text_scale, is_motion_reduced);
        if self.preferences.threads != self.keeping.preferences.threads {
            // Made anew, with everything told to it again.
            (self.final_view, self.sent) = (None, None);
        }
    }

    /// Writes what changed and is due. Once per frame.
    pub(super) fn keep(&mut self, ctx: &Context) {
        // The theme belongs to the thread, and other windows may have been drawn by it.
        theme::set(self.preferences.theme);
        self.preferences.shortcuts = self.keymap.to_stored();
        if self.preferences != self.keeping.preferences {
            self.apply_preferences(ctx);
            let before = std::mem::replace(&mut self.keeping.preferences, self.preferences.clone());
            if let Some(config) = &self.keeping.places.config
                && let Err(error) = self.preferences.save_changes(&before, config)
            {
                self.messages.warning(format!("Preferences are not kept: {error}"));
            }
        }
        if self.editor.view.bookmarks != self.keeping.bookmarks {
            self.keeping.bookmarks.clone_from(&self.editor.view.bookmarks);
            if let Some(state) = &self.keeping.places.state
                && let Err(error) = bookmarks::save_bookmarks(state, &self.keeping.bookmarks)
            {
                self.messages.warning(format!("Camera bookmarks are not kept: {error}"));
            }
        }
        self.mind_files(ctx);
        let Some(store) = &self.keeping.store else { return };
        let pause = Duration::from_secs_f64(self.preferences.autosave_seconds);
        let due = self.keeping.stored.map_or(Duration::ZERO, |at| pause.saturating_sub(at.elapsed()));
        if due > Duration::ZERO {
            ctx.request_repaint_after(due);
            return;
        }
        let kept = self.unsaved();
        if !kept.is_empty() {
            ctx.request_repaint_after(pause);
        }
        store.write(kept);
        if let Some(problem) = store.problem() {
            self.messages.warning(format!("Unsaved work is not kept for a crash: {problem}"));
        }
        self.keeping.stored = Some(Instant::now());
    }

    /// Watches the files of all documents and the folder of the library, and says what other programs did to them.
    fn mind_files(&mut self, ctx: &Context) {
        let Some(watch) = &self.keeping.watch else { return };
        let mut paths = BTreeSet::new();
        for (_, document) in self.tabs.documents(&self.editor.document) {
            paths.extend(document.path().map(Path::to_path_buf));
            let maps = document.material.slots().filter_map(|(_, slot)| slot.texture.as_ref());
            let maps = maps.filter(|map| !map.path.is_empty());
            paths.extend(maps.filter_map(|map| crate::files::texture_path(&map.path, document.folder())));
        }
        paths.extend(self.library().map(|library| library.root().to_path_buf()));
        if paths != self.keeping.watched {
            watch.set(paths.iter().cloned());
            self.keeping.watched = paths;
        }
        for path in watch.poll() {
            if self.library().is_some_and(|library| library.root() == path) {
                self.look_for_changes();
                continue;
            }
            self.changed_outside(&path, ctx);
        }
    }

    /// The window closes in order: the layout is kept, and nothing is left to recover.
    pub(super) fn keep_for_next_time(&mut self) {
        let layout = self.dock.to_text();
        if let (Some(state), Some(text)) =
            (&self.keeping.places.state, layout.filter(|text| self.keeping.layout.as_ref() != Some(text)))
        {
            // There is no window any more to complain in.
            _ = layout_file::save_layout(state, &text);
        }
        // What was not closed in order is kept for the next time.
        if self.is_closing
            && self.preview.loss().is_none()
            && let Some(store) = self.keeping.store.take()
        {
            _ = store.close();
        }
    }

    /// Brings back what programs that ended badly had not saved, or throws it away.
    pub(super) fn take_left(&mut self, is_wanted: bool, ctx: &Context) {
        for abandoned in std::mem::take(&mut self.keeping.left) {
            if is_wanted {
                let documents = abandoned.documents().to_vec();
                documents.iter().rev().for_each(|kept| self.recover(kept, ctx));
                let kept = self.unsaved();
                if let Some(store) = &self.keeping.store {
                    store.adopt(kept, abandoned);
                }
            } else if let Err(error) = abandoned.discard() {
                self.messages.warning(error.to_string());
            }
        }
    }

    /// All documents with unsaved changes, as the store keeps them.
    fn unsaved(&self) -> Vec<Kept> {
        let documents = self.tabs.documents(&self.editor.document);
        documents
            .filter(|(_, document)| document.is_modified())
            .map(|(id, document)| Kept {
                id,
                path: document.path().map(Path::to_path_buf),
                import: document.import().map(Path::to_path_buf),
                title: document.title(),
                text: document.file().to_text(&document.material),
                original: document.saved().text().to_owned(),
                when: SystemTime::now(),
            })
            .collect()
    }
}
