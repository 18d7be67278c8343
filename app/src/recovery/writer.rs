//! The thread that writes unsaved documents, so that the window never waits for a disk.

use super::{Abandoned, Kept};
use crate::files::save_atomic;
use std::collections::BTreeMap;
use std::fs;
use std::io::ErrorKind;
use std::path::PathBuf;
use std::sync::mpsc::{Receiver, Sender};
use std::sync::{Arc, Mutex, PoisonError};

/// What the writer is asked.
pub(super) enum Request {
    /// Hold these documents, then discard what some of them came from.
    Write(Vec<Kept>, Option<Abandoned>),
    /// Tell when everything before is done, and whether that went well.
    Flush(Sender<Result<(), String>>),
}

/// What is on disk, and who is told what failed.
pub(super) struct Writer {
    folder: PathBuf,
    on_disk: BTreeMap<u64, Kept>,
    /// Waits until a writing goes well.
    abandoned: Vec<Abandoned>,
    /// What went wrong the last time.
    failure: Option<String>,
    problem: Arc<Mutex<Option<String>>>,
}

impl Writer {
    pub fn new(folder: PathBuf, problem: Arc<Mutex<Option<String>>>) -> Self {
        Self { folder, on_disk: BTreeMap::new(), abandoned: Vec::new(), failure: None, problem }
    }

    /// Works until there is nobody left to ask.
    pub fn run(&mut self, requests: &Receiver<Request>) {
        while let Ok(first) = requests.recv() {
            let mut newest = None;
            let mut flushes = Vec::new();
            // On a slow disk requests pile up; only the newest state counts.
            for request in std::iter::once(first).chain(requests.try_iter()) {
                match request {
                    Request::Write(documents, abandoned) => {
                        newest = Some(documents);
                        self.abandoned.extend(abandoned);
                    }
                    Request::Flush(sender) => flushes.push(sender),
                }
            }
            if let Some(documents) = newest {
                self.write(documents);
            }
            for sender in flushes {
                let _ = sender.send(self.failure.clone().map_or(Ok(()), Err));
            }
        }
    }

    fn write(&mut self, documents: Vec<Kept>) {
        let mut failure = None;
        let gone: Vec<u64> = self.on_disk.keys().copied().filter(|id| documents.iter().all(|kept| kept.id != *id)).collect();
        for document in documents {
            if self.on_disk.get(&document.id).is_some_and(|old| old.is_like(&document)) {
                continue;
            }
            let path = self.path(document.id);
            let written = document.to_ron().map_err(|error| format!("{}: {error}", path.display()));
            match written.and_then(|text| save_atomic(&path, text.as_bytes()).map_err(|error| error.to_string())) {
                Ok(()) => _ = self.on_disk.insert(document.id, document),
                Err(error) => failure = Some(error),
            }
        }
        for id in gone {
            let path = self.path(id);
            match fs::remove_file(&path) {
                Err(error) if error.kind() != ErrorKind::NotFound => {
                    failure = Some(format!("{}: cannot be removed: {error}", path.display()));
                }
                _ => _ = self.on_disk.remove(&id),
            }
        }
        if failure.is_none() {
            for abandoned in self.abandoned.drain(..) {
                failure = abandoned.discard().err().map(|error| error.to_string()).or(failure);
            }
        }
        self.report(failure);
    }

    /// Tells of a failure, unless it is the same as the last time.
    fn report(&mut self, failure: Option<String>) {
        if failure.is_some() && failure != self.failure {
            let sentence = failure.as_ref().map(|error| format!("Unsaved changes are not safe from a crash: {error}"));
            *self.problem.lock().unwrap_or_else(PoisonError::into_inner) = sentence;
        }
        self.failure = failure;
    }

    fn path(&self, id: u64) -> PathBuf {
        self.folder.join(format!("{id}.ron"))
    }
}
