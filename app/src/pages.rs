//! Pages over the window, one at a time: finding commands, preferences, keys, what is known about a property, and questions.

use crate::command::Command;
use burnish_material::Property;
use std::path::PathBuf;

/// A page over the window.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Page {
    /// Type to find a command, a property or a preset.
    Palette,
    /// Files that were open lately.
    Recent,
    /// Tags, licence and values of many files.
    BatchEdit,
    /// Another name for a file of the library.
    Rename,
    /// Measured materials to begin with.
    Measured,
    /// The material in another program's format, and what that costs.
    Exchange,
    /// A pack of the library, and the formats in it.
    Pack,
    /// What the user prefers.
    Preferences,
    /// Keys and mouse.
    Help,
    /// What is known about a property.
    Reference(Property),
    /// Built-in textures for a property.
    Textures(Property),
    /// What a program that ended badly has left.
    Recovery,
}

/// A file of an open document that another program has changed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Change {
    /// The document's number.
    pub id: u64,
    /// The file.
    pub path: PathBuf,
    /// What the document is called.
    pub title: String,
    /// Whether it has changes of its own.
    pub is_modified: bool,
}

/// Which page is open, and what is typed in it.
#[derive(Clone, Debug, Default)]
pub struct Pages {
    open: Option<Page>,
    /// Questions that wait, oldest first.
    changes: Vec<Change>,
    /// What is searched for.
    pub search: String,
    /// Which of the found is marked.
    pub marked: usize,
    /// Enter came together with the text it is for: the row is chosen once that was searched for.
    pub is_confirmed: bool,
    /// The command whose new keys are to be pressed next.
    pub recording: Option<Command>,
}

impl Pages {
    /// The open page.
    pub fn page(&self) -> Option<Page> {
        self.open
    }

    /// Opens a page in place of the one that is open; the same again closes it.
    pub fn open(&mut self, page: Page) {
        let is_same = self.open == Some(page);
        self.close();
        if !is_same {
            self.open = Some(page);
        }
    }

    /// Closes the page.
    pub fn close(&mut self) {
        self.open = None;
        self.search.clear();
        self.marked = 0;
        self.recording = None;
    }

    /// Whether keys belong to the page and not to commands.
    pub fn takes_keys(&self) -> bool {
        matches!(self.open, Some(Page::Palette | Page::Recent | Page::Recovery))
            || self.recording.is_some()
            || !self.changes.is_empty()
    }

    /// Asks what to do about a file that another program has changed; once, however often it changes.
    pub fn ask_about_change(&mut self, id: u64, path: PathBuf, title: String, is_modified: bool) {
        self.changes.retain(|change| change.id != id);
        self.changes.push(Change { id, path, title, is_modified });
    }

    /// The question that is to be answered first.
    pub fn change(&self) -> Option<&Change> {
        self.changes.first()
    }

    /// It was answered.
    pub fn take_change(&mut self) -> Option<Change> {
        (!self.changes.is_empty()).then(|| self.changes.remove(0))
    }
}
