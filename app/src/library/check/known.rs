//! What was found of each file before, so that a check after an edit looks only at what was edited.

use super::file::Report;
use super::{Options, Shelved};
use crate::digest::Digest;
use crate::library::entry::Entry;
use crate::library::shelf::State;
use std::collections::HashMap;
use std::path::PathBuf;

/// What a report depends on: the bytes of the file and of its images, its small picture, and what was asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Key {
    content: Digest,
    is_broken: bool,
    state: State,
    renders_looks: bool,
    probes_stability: bool,
}

impl Key {
    fn of(library: &Shelved<'_>, entry: &Entry, options: &Options) -> Self {
        Self {
            content: entry.content,
            is_broken: entry.problem.is_some(),
            state: library.shelf.state(entry, library.setup),
            renders_looks: options.renders_looks,
            probes_stability: options.probes_stability,
        }
    }
}

/// The reports of a library's last check that came to its end.
#[derive(Default)]
pub struct Known {
    reports: HashMap<PathBuf, (Key, Report)>,
}

impl Known {
    /// What is known of an entry, if it is still so. What could not be read may have become readable.
    pub(super) fn get(&self, library: &Shelved<'_>, entry: &Entry, options: &Options) -> Option<Report> {
        let (key, report) = self.reports.get(&entry.path)?;
        (!key.is_broken && *key == Key::of(library, entry, options)).then(|| report.clone())
    }

    /// Takes the place of what was known; reports in the order of the entries.
    pub(super) fn set(&mut self, library: &Shelved<'_>, reports: &[Report], options: &Options) {
        let all = library.entries.iter().zip(reports);
        self.reports =
            all.map(|(entry, report)| (entry.path.clone(), (Key::of(library, entry, options), report.clone()))).collect();
    }
}
