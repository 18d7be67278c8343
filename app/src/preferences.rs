//! What the user prefers, as `preferences.ron` in the folder for configuration: a map from names to values in RON.
//!
//! Each value is read by itself, so that one that is wrong costs only itself. Names that this version does not know are
//! written back as they were: an older version must not forget what a newer one was told.

use crate::files::FilesError;
use crate::own_files;
use crate::theme::ThemeName;
use burnish_assets::{BACKDROPS, ENVIRONMENTS, SHAPES};
use burnish_material::DEFAULT_UNIT_MM;
use burnish_renderer::tonemap::DisplayTransform;
use ron::extensions::Extensions;
use ron::ser::PrettyConfig;
use ron::value::RawValue;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::collections::BTreeMap;
use std::ops::RangeInclusive;
use std::path::Path;

const FILE: &str = "preferences.ron";

/// Millimetres that a unit of a scene may have.
pub const UNIT_MM: RangeInclusive<f64> = 1e-6..=1e9;
/// How many threads the final view may be told to use.
pub const THREADS: RangeInclusive<usize> = 1..=1024;
/// Seconds between two looks at what is unsaved.
pub const AUTOSAVE_SECONDS: RangeInclusive<f64> = 1.0..=60.0;
/// Factors on the size of all text.
pub const TEXT_SCALE: RangeInclusive<f32> = 0.75..=2.0;

/// Which buttons of the mouse move the view.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MouseScheme {
    /// Left drag orbits, middle drag or Ctrl + right drag pans, right drag or wheel zooms.
    #[default]
    Designer,
    /// Alt + left, middle, right drag orbits, pans, zooms.
    Maya,
    /// Middle drag orbits, Shift + middle drag pans, wheel zooms.
    Blender,
}

impl MouseScheme {
    /// All schemes with their words in files.
    pub const ALL: [(Self, &'static str); 3] = [(Self::Designer, "designer"), (Self::Maya, "maya"), (Self::Blender, "blender")];
}

/// The word for what a mesh brings itself.
pub const OWN_BACKDROP: &str = "own";

/// What the user prefers. Everything has a default, and everything read from a file is in range.
#[derive(Clone, Debug, PartialEq)]
pub struct Preferences {
    /// Millimetres per unit of a new scene, in [`UNIT_MM`].
    pub unit_mm: f64,
    /// Threads of the final view, in [`THREADS`]; `None` takes one per core.
    pub threads: Option<usize>,
    /// Built-in mesh to start with, a name in [`SHAPES`].
    pub mesh: String,
    /// What the mesh stands on at the start, a name in [`BACKDROPS`]; [`OWN_BACKDROP`]: what it brings.
    pub backdrop: String,
    /// Built-in environment to start with, a name in [`ENVIRONMENTS`].
    pub light: String,
    /// Display transform to start with.
    pub display: DisplayTransform,
    /// Seconds until what is unsaved goes to the recovery store, in [`AUTOSAVE_SECONDS`].
    pub autosave_seconds: f64,
    /// Which buttons of the mouse move the view.
    pub mouse: MouseScheme,
    /// Whether the wheel zooms the other way round.
    pub is_wheel_flipped: bool,
    /// How light the window is.
    pub theme: ThemeName,
    /// Factor on the size of all text, in [`TEXT_SCALE`].
    pub text_scale: f32,
    /// Whether nothing moves by itself.
    pub is_motion_reduced: bool,
    /// Keys of commands whose keys differ from the default, by the command's id; an empty list means none.
    pub shortcuts: BTreeMap<String, Vec<String>>,
    /// What this version does not know, as written.
    unknown: BTreeMap<String, Box<RawValue>>,
}

impl Default for Preferences {
    fn default() -> Self {
        Self {
            unit_mm: DEFAULT_UNIT_MM,
            threads: None,
            mesh: SHAPES.first().map_or("", |def| def.name).to_owned(),
            backdrop: OWN_BACKDROP.to_owned(),
            light: ENVIRONMENTS.first().map_or("", |def| def.name).to_owned(),
            display: DisplayTransform::default(),
            autosave_seconds: 3.0,
            mouse: MouseScheme::default(),
            is_wheel_flipped: false,
            theme: ThemeName::default(),
            text_scale: 1.0,
            is_motion_reduced: false,
            shortcuts: BTreeMap::new(),
            unknown: BTreeMap::new(),
        }
    }
}

impl Preferences {
    /// The preferences in a folder, and sentences for the user.
    ///
    /// Without a file all are the default. A file that is broken as a whole is set aside, never deleted.
    pub fn load(folder: &Path) -> (Self, Vec<String>) {
        let path = folder.join(FILE);
        let mut preferences = Self::default();
        let (values, message) = own_files::load(&path, own_files::MAX_BYTES, |text| {
            ron::from_str(text).map_err(|error| format!("expected preferences, a map from names to values: {error}"))
        });
        if let Some(message) = message {
            return (preferences, vec![format!("{message}; the defaults are used")]);
        }
        let mut reader = Reader { path: &path, values: values.unwrap_or_default(), messages: Vec::new() };
        preferences.each(&mut reader);
        let Reader { values, messages, .. } = reader;
        preferences.unknown = values;
        (preferences, messages)
    }

    /// Saves the preferences in a folder, which is made if it is missing.
    pub fn save(&self, folder: &Path) -> Result<(), FilesError> {
        let path = folder.join(FILE);
        Self::write(&path, &self.values(&path)?)
    }

    /// Saves what differs from `before`, and leaves the rest as the folder has it: another window may have saved since.
    pub fn save_changes(&self, before: &Self, folder: &Path) -> Result<(), FilesError> {
        let path = folder.join(FILE);
        let (mut values, before) = (self.values(&path)?, before.values(&path)?);
        let stored = std::fs::read_to_string(&path).unwrap_or_default();
        // A file that is broken was set aside when it was loaded; one that broke since holds nothing to keep.
        let stored: BTreeMap<String, Box<RawValue>> = ron::from_str(&stored).unwrap_or_default();
        for (key, value) in stored {
            let is_changed = values.get(&key).map(|ours| ours.get_ron()) != before.get(&key).map(|old| old.get_ron());
            if !is_changed {
                values.insert(key, value);
            }
        }
        Self::write(&path, &values)
    }

    /// All entries of the file at `path`, which is for errors.
    fn values(&self, path: &Path) -> Result<BTreeMap<String, Box<RawValue>>, FilesError> {
        let mut writer = Writer { values: self.unknown.clone(), problem: None };
        self.clone().each(&mut writer);
        match writer.problem {
            None => Ok(writer.values),
            Some(problem) => Err(FilesError::Write { path: path.to_path_buf(), source: std::io::Error::other(problem) }),
        }
    }

    fn write(path: &Path, values: &BTreeMap<String, Box<RawValue>>) -> Result<(), FilesError> {
        let text = ron::ser::to_string_pretty(values, PrettyConfig::new())
            .map_err(|error| FilesError::Write { path: path.to_path_buf(), source: std::io::Error::other(error) })?;
        own_files::save(path, &(text + "\n"))
    }

    /// Every preference with its name and what it may be: the one place for reading and writing.
    fn each(&mut self, access: &mut impl Access) {
        let default = Self::default();
        access.value("unit_mm", &mut self.unit_mm, "millimetres, 1e-6 to 1e9", |v| within(*v, UNIT_MM, default.unit_mm));
        access.value("threads", &mut self.threads, "Some(1) to Some(1024), or None for one per core", |v| {
            v.map(|threads| threads.clamp(*THREADS.start(), *THREADS.end()))
        });
        access.name("mesh", &mut self.mesh, SHAPES.iter().map(|def| def.name));
        access.name("backdrop", &mut self.backdrop, [OWN_BACKDROP].into_iter().chain(BACKDROPS.iter().map(|def| def.name)));
        access.name("light", &mut self.light, ENVIRONMENTS.iter().map(|def| def.name));
        access.word("display", &mut self.display, &DisplayTransform::ALL);
        access.value("autosave_seconds", &mut self.autosave_seconds, "seconds, 1 to 60", |v| {
            within(*v, AUTOSAVE_SECONDS, default.autosave_seconds)
        });
        access.word("mouse", &mut self.mouse, &MouseScheme::ALL);
        access.value("is_wheel_flipped", &mut self.is_wheel_flipped, "true or false", |v| *v);
        access.word("theme", &mut self.theme, &ThemeName::ALL);
        access.value("text_scale", &mut self.text_scale, "a factor, 0.75 to 2", |v| {
            within((*v).into(), (*TEXT_SCALE.start()).into()..=(*TEXT_SCALE.end()).into(), 1.0) as f32
        });
        access.value("is_motion_reduced", &mut self.is_motion_reduced, "true or false", |v| *v);
        let keys = "a map from commands to lists of keys, {\"undo\": [\"Ctrl+Z\"]}";
        access.value("shortcuts", &mut self.shortcuts, keys, Clone::clone);
    }
}

/// The nearest number in `range`; `default` for what is no number.
fn within(number: f64, range: RangeInclusive<f64>, default: f64) -> f64 {
    if number.is_nan() { default } else { number.clamp(*range.start(), *range.end()) }
}

/// Reads or writes one preference after the other.
trait Access {
    /// A value that is `expected` to be something; `fit` makes that of what a file holds.
    fn value<T>(&mut self, key: &str, value: &mut T, expected: &str, fit: impl FnOnce(&T) -> T)
    where
        T: Clone + PartialEq + Serialize + DeserializeOwned;

    /// One of some names, in any case.
    fn name(&mut self, key: &str, value: &mut String, names: impl Iterator<Item = &'static str> + Clone) {
        let expected = format!("one of {}", names.clone().map(|name| format!("{name:?}")).collect::<Vec<_>>().join(", "));
        let current = value.clone();
        self.value(key, value, &expected, |found: &String| {
            // In whatever case: not worth a sentence. The window looks names up in any case as well.
            if names.clone().any(|name| name.eq_ignore_ascii_case(found)) { found.clone() } else { current }
        });
    }

    /// One of some meanings, by its word.
    fn word<T: Copy + PartialEq>(&mut self, key: &str, value: &mut T, all: &[(T, &'static str)]) {
        let names: Vec<&'static str> = all.iter().map(|(_, word)| *word).collect();
        let mut word = all.iter().find(|(meaning, _)| meaning == value).map_or("", |(_, word)| *word).to_owned();
        self.name(key, &mut word, names.into_iter());
        if let Some((meaning, _)) = all.iter().find(|(_, other)| other.eq_ignore_ascii_case(&word)) {
            *value = *meaning;
        }
    }
}

struct Reader<'a> {
    path: &'a Path,
    /// What has not been asked for yet.
    values: BTreeMap<String, Box<RawValue>>,
    messages: Vec<String>,
}

impl Access for Reader<'_> {
    fn value<T>(&mut self, key: &str, value: &mut T, expected: &str, fit: impl FnOnce(&T) -> T)
    where
        T: Clone + PartialEq + Serialize + DeserializeOwned,
    {
        let Some(raw) = self.values.remove(key) else { return };
        let raw = raw.trim().get_ron();
        // Who writes `threads: 4` by hand means `Some(4)`.
        let found = ron::Options::default().with_default_extension(Extensions::IMPLICIT_SOME).from_str::<T>(raw).ok();
        if let Some(found) = &found {
            *value = fit(found);
        }
        if found.as_ref() != Some(value) {
            let used = ron::to_string(value).unwrap_or_default();
            let sentence = format!("expected {expected}, found {}; {} is used", shortened(raw), shortened(&used));
            self.messages.push(format!("{}: {key}: {sentence}", self.path.display()));
        }
    }
}

struct Writer {
    values: BTreeMap<String, Box<RawValue>>,
    problem: Option<ron::Error>,
}

impl Access for Writer {
    fn value<T>(&mut self, key: &str, value: &mut T, _: &str, _: impl FnOnce(&T) -> T)
    where
        T: Clone + PartialEq + Serialize + DeserializeOwned,
    {
        match RawValue::from_rust(value) {
            Ok(raw) => _ = self.values.insert(key.to_owned(), raw),
            Err(error) => self.problem = Some(error),
        }
    }
}

/// At most a line of a text.
fn shortened(text: &str) -> String {
    const MAX: usize = 60;
    let line = text.lines().next().unwrap_or_default();
    if line.len() == text.len() && line.chars().count() <= MAX {
        return text.to_owned();
    }
    line.chars().take(MAX).chain("...".chars()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn two_windows_keep_what_each_changed() {
        let folder = tempfile::tempdir().unwrap();
        let first = Preferences::default();
        let larger = Preferences { text_scale: 1.5, ..first.clone() };
        let other = Preferences { threads: Some(3), ..first.clone() };
        larger.save_changes(&first, folder.path()).unwrap();
        other.save_changes(&first, folder.path()).unwrap();
        let (both, messages) = Preferences::load(folder.path());
        assert_eq!((both.text_scale, both.threads, messages), (1.5, Some(3), vec![]));
        first.save_changes(&larger, folder.path()).unwrap();
        assert_eq!(Preferences::load(folder.path()).0, other, "what is set back to the default is a change");
    }

    fn load(text: &str) -> (Preferences, Vec<String>) {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join(FILE), text).unwrap();
        Preferences::load(folder.path())
    }

    /// Differs from the default in everything.
    fn other() -> Preferences {
        Preferences {
            unit_mm: 1.5,
            threads: Some(7),
            mesh: "torus".to_owned(),
            backdrop: "grey-sweep".to_owned(),
            light: "sun".to_owned(),
            display: DisplayTransform::Agx,
            autosave_seconds: 10.0,
            mouse: MouseScheme::Blender,
            is_wheel_flipped: true,
            theme: ThemeName::Light,
            text_scale: 1.25,
            is_motion_reduced: true,
            shortcuts: [("edit.undo".to_owned(), vec!["Ctrl+Z".to_owned(), "\"\\".to_owned()]), ("b".to_owned(), vec![])].into(),
            unknown: BTreeMap::new(),
        }
    }

    #[test]
    fn no_file_means_the_defaults() {
        let folder = tempfile::tempdir().unwrap();
        let (preferences, messages) = Preferences::load(&folder.path().join("never/made"));
        assert_eq!((preferences, messages.len()), (Preferences::default(), 0));
        let Preferences { unit_mm, threads, mesh, light, autosave_seconds, .. } = Preferences::default();
        assert_eq!((unit_mm, threads, autosave_seconds), (100.0, None, 3.0));
        assert_eq!((&*mesh, &*light), (SHAPES[0].name, ENVIRONMENTS[0].name));
    }

    #[test]
    fn everything_comes_back_as_saved() {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path().join("made/when/saving");
        for preferences in [Preferences::default(), other()] {
            preferences.save(&folder).unwrap();
            assert_eq!(Preferences::load(&folder), (preferences, vec![]), "{:?}", fs::read_to_string(folder.join(FILE)));
        }
    }

    #[test]
    fn a_wrong_value_costs_only_itself() {
        let (preferences, messages) = load(
            "{
                \"unit_mm\": -3, \"threads\": 5000, \"mesh\": \"teapot\", \"light\": \"SUN\", \"theme\": \"sepia\",
                \"autosave_seconds\": 0.01, \"text_scale\": NaN, \"is_motion_reduced\": \"yes\", \"mouse\": \"Maya\",
                \"shortcuts\": {\"undo\": \"Ctrl+Z\"},
            }",
        );
        let expected = Preferences {
            unit_mm: 1e-6,
            threads: Some(1024),
            light: "SUN".to_owned(),
            autosave_seconds: 1.0,
            mouse: MouseScheme::Maya,
            ..Preferences::default()
        };
        assert_eq!(preferences, expected);
        let keys = ["unit_mm", "threads", "mesh", "autosave_seconds", "theme", "text_scale", "is_motion_reduced", "shortcuts"];
        assert_eq!(messages.len(), keys.len(), "{messages:#?}");
        for (key, message) in keys.iter().zip(&messages) {
            assert!(message.contains(&format!("{FILE}: {key}: expected ")) && message.ends_with(" is used"), "{message}");
        }
        assert!(messages[2].contains("\"rounded-cube\"") && messages[2].contains("found \"teapot\""), "{}", messages[2]);
    }

    #[test]
    fn what_a_newer_version_was_told_is_kept() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(FILE);
        let text = "{\"of the future\": Some((1, {\"a\": Deep(x: 'c')})), // why\n \"theme\": \"grey\", \"z\": [1, // two\n 2 // three\n ]}";
        fs::write(&path, text).unwrap();
        let (mut preferences, messages) = Preferences::load(folder.path());
        assert!(messages.is_empty(), "{messages:?}");
        assert_eq!(preferences.theme, ThemeName::Grey);
        preferences.theme = ThemeName::Light;
        for _ in 0..3 {
            preferences.save(folder.path()).unwrap();
            assert_eq!(Preferences::load(folder.path()), (preferences.clone(), vec![]));
        }
        let text = fs::read_to_string(&path).unwrap();
        assert!(text.contains("Some((1, {\"a\": Deep(x: 'c')}))") && text.contains("// three"), "{text}");
    }

    #[test]
    fn a_broken_file_is_set_aside_with_one_sentence() {
        let folder = tempfile::tempdir().unwrap();
        let huge = format!("{{\"mesh\": \"{}\"}}", "x".repeat(own_files::MAX_BYTES as usize));
        for (index, text) in ["{\"theme\": ", "", "[1, 2]", "{\"theme\": \"grey\"} more", &huge].into_iter().enumerate() {
            let path = folder.path().join(FILE);
            fs::write(&path, text).unwrap();
            let (preferences, messages) = Preferences::load(folder.path());
            assert_eq!((preferences, messages.len()), (Preferences::default(), 1), "{messages:?}");
            let aside = format!("preferences.broken-{}.ron", index + 1);
            let message = &messages[0];
            assert!(message.contains(FILE) && message.contains("expected") && message.contains(&aside), "{message}");
            assert!(fs::read_to_string(folder.path().join(aside)).unwrap() == text, "the file was changed");
            assert!(!path.exists());
        }
    }
}
