//! What is known of a turntable: one JSON file in its folder, rewritten after every frame.

use crate::files::{read_text_file, save_atomic};
use crate::offline::OfflineError;
use burnish_renderer::path::{Rendering, StopReason, StopRules};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Larger files are not read: a curve has some dozens of points.
const MAX_BYTES: u64 = 1 << 30;

/// Name of the file that tells of a turntable that is not divided.
const WHOLE: &str = "turntable.json";

/// What becomes of a turntable that is in the folder already.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Existing {
    /// It is an error.
    Refuse,
    /// It goes on, which needs the same settings.
    Resume,
    /// The same, but one without a finished frame begins anew with other settings.
    Restart,
}

/// A finished frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Frame {
    /// Name of the file in the folder.
    pub file: String,
    /// Seconds of rendering, all sittings together.
    pub seconds: f64,
    /// Samples per pixel.
    pub spp: u32,
    /// Error that it reached.
    pub relmse_estimate: Option<f64>,
    /// The rule that ended it.
    pub stop_reason: String,
    /// The rules that it had: samples per pixel, seconds of the last sitting, error.
    rules: (Option<u32>, Option<f64>, Option<f64>),
    /// Seconds, samples per pixel and error on the way.
    curve: Vec<(f64, u32, f64)>,
}

impl Frame {
    pub(super) fn new(file: String, rendering: &Rendering, rules: &StopRules) -> Self {
        Self {
            file,
            seconds: rendering.seconds,
            spp: rendering.film.spp(),
            relmse_estimate: rendering.error.map(|error| error.relmse),
            stop_reason: rendering.stop_reason.word().to_owned(),
            rules: (rules.spp, rules.seconds, rules.relmse),
            curve: rendering.history.iter().map(|point| (point.seconds, point.spp, point.relmse)).collect(),
        }
    }

    /// Whether these rules would have ended it where it is, or earlier.
    pub fn meets(&self, rules: &StopRules) -> bool {
        let (_, seconds, relmse) = self.rules;
        let is_within = |had: Option<f64>, now: Option<f64>| had.zip(now).is_some_and(|(had, now)| had <= now);
        let by_error = self.stop_reason == "error" && is_within(relmse, rules.relmse);
        // Where there is no other goal, time itself is one.
        let is_timed = rules.relmse.is_none() && rules.spp.is_none();
        let by_time = is_timed && self.stop_reason == "time" && is_within(rules.seconds, seconds);
        rules.spp.is_some_and(|spp| self.spp >= spp) || by_error || by_time
    }

    /// The same without what it was on the way.
    #[must_use]
    pub fn without_curve(&self) -> Self {
        Self { curve: Vec::new(), file: self.file.clone(), stop_reason: self.stop_reason.clone(), ..*self }
    }

    /// Whether its time was up before its error was reached.
    pub fn is_time_limited(&self) -> bool {
        self.stop_reason == StopReason::Time.word()
    }

    /// `frame_0007.png (1.4 %)`.
    pub fn text(&self) -> String {
        let error = self.relmse_estimate.map_or("no estimate".to_owned(), |e| format!("{:.1} %", 100.0 * e.max(0.0).sqrt()));
        format!("{} ({error})", self.file)
    }
}

/// What the file holds.
#[derive(Debug, Serialize, Deserialize)]
struct Content {
    settings: Value,
    frames: BTreeMap<u32, Frame>,
}

/// The frames so far.
pub(super) struct State {
    path: PathBuf,
    content: Content,
}

impl State {
    /// A new one, or that of the folder.
    pub(super) fn open(
        folder: &Path,
        shard: Option<(u32, u32)>,
        settings: Value,
        existing: Existing,
    ) -> Result<Self, OfflineError> {
        let name = match shard {
            None => WHOLE.to_owned(),
            Some((part, parts)) => format!("turntable-{part}-of-{parts}.json"),
        };
        let path = folder.join(name);
        let new = Content { settings, frames: BTreeMap::new() };
        if !path.exists() {
            let state = Self { path, content: new };
            state.save()?;
            return Ok(state);
        }
        let shown = path.display();
        if existing == Existing::Refuse {
            return Err(OfflineError::HasTurntable { path });
        }
        let text = read_text_file(&path, MAX_BYTES).map_err(OfflineError::unusable)?;
        let content: Content = serde_json::from_str(&text)
            .map_err(|error| OfflineError::unusable(format!("{shown}: expected a turntable: {error}")))?;
        if let Some(key) = difference("", &content.settings, &new.settings) {
            // Probes alone are quickly made again.
            if existing == Existing::Restart && content.frames.is_empty() {
                remove_samples(folder);
                let state = Self { path, content: new };
                state.save()?;
                return Ok(state);
            }
            return Err(OfflineError::unusable(format!(
                "{shown}: was begun with another `{key}`; expected the same settings, or another folder"
            )));
        }
        Ok(Self { path, content })
    }

    /// The settings and frames of a folder that has a whole turntable; `None` where it has none that can be read.
    pub(super) fn read(folder: &Path) -> Option<(Value, BTreeMap<u32, Frame>)> {
        let text = read_text_file(&folder.join(WHOLE), MAX_BYTES).ok()?;
        let Content { settings, frames } = serde_json::from_str(&text).ok()?;
        Some((settings, frames))
    }

    pub(super) fn frame(&self, number: u32) -> Option<&Frame> {
        self.content.frames.get(&number)
    }

    /// Notes a frame whose picture has been written.
    pub(super) fn finish(&mut self, number: u32, frame: Frame) -> Result<(), OfflineError> {
        self.content.frames.insert(number, frame);
        self.save()
    }

    fn save(&self) -> Result<(), OfflineError> {
        let text = serde_json::to_string_pretty(&self.content).map_err(OfflineError::unusable)?;
        save_atomic(&self.path, text.as_bytes()).map_err(OfflineError::unusable)
    }
}

/// The first key, from the top, whose values differ.
fn difference(key: &str, a: &Value, b: &Value) -> Option<String> {
    let (Some(before), Some(now)) = (a.as_object(), b.as_object()) else { return (a != b).then(|| key.to_owned()) };
    let keys = before.keys().chain(now.keys().filter(|key| !before.contains_key(*key)));
    keys.filter_map(|inner| {
        let full = if key.is_empty() { inner.clone() } else { format!("{key}.{inner}") };
        difference(&full, before.get(inner).unwrap_or(&Value::Null), now.get(inner).unwrap_or(&Value::Null))
    })
    .next()
}

/// Files of stored samples in a folder.
fn sample_files(folder: &Path) -> impl Iterator<Item = PathBuf> {
    let paths = std::fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
    paths.filter(|path| path.extension().is_some_and(|ending| ending == "samples"))
}

fn remove_samples(folder: &Path) {
    // One that stays is found to be of another size, or replaced.
    sample_files(folder).for_each(|path| _ = std::fs::remove_file(path));
}

/// Bytes of stored samples in a folder, without those of one file.
pub(super) fn stored_bytes(folder: &Path, without: &Path) -> u64 {
    sample_files(folder)
        .filter(|path| path != without)
        .filter_map(|path| path.metadata().ok())
        .map(|metadata| metadata.len())
        .sum()
}
