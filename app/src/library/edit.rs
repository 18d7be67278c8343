//! Edits of many material files in one step that can be taken back.
//!
//! Planning reads files and changes none; it says what each would hold. Carrying out writes each file whole or not at all, and only if it still
//! holds what was planned for; undoing is carrying out the reverse. Everything that the edit is not about keeps its bytes.

use super::entry::{reason, stem};
use crate::files::{self, FilesError, save_atomic};
use burnish_material::{MAX_FILE_BYTES, Material, MaterialFile, Property, Value};
use std::fmt;
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// Longest name of a file in bytes that every usual file system takes, with room for a temporary name.
const MAX_NAME: usize = 200;

/// A change of one material.
#[derive(Clone, Debug, PartialEq)]
pub enum Change {
    /// Adds a tag, unless it is there in any case.
    AddTag(String),
    /// Takes a tag away, in whatever case it is written.
    RemoveTag(String),
    /// Sets the licence of the data; an empty one is taken away.
    SetLicence(String),
    /// Sets the notes; empty ones are taken away.
    SetNotes(String),
    /// Sets a value; a texture in its place goes, because it would hide the value.
    SetValue(Property, Value),
}

impl fmt::Display for Change {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::AddTag(tag) => write!(f, "Add tag {tag}"),
            Self::RemoveTag(tag) => write!(f, "Remove tag {tag}"),
            Self::SetLicence(licence) if licence.is_empty() => f.write_str("Remove licence"),
            Self::SetLicence(licence) => write!(f, "Set licence {licence}"),
            Self::SetNotes(_) => f.write_str("Set notes"),
            Self::SetValue(property, _) => write!(f, "Set {}", property.def().label.to_lowercase()),
        }
    }
}

impl Change {
    fn apply(&self, material: &mut Material) {
        let same = |a: &str, b: &str| a.to_lowercase() == b.to_lowercase();
        match self {
            Self::AddTag(tag) if material.tags.iter().any(|other| same(other, tag)) => {}
            Self::AddTag(tag) => material.tags.push(tag.clone()),
            Self::RemoveTag(tag) => material.tags.retain(|other| !same(other, tag)),
            Self::SetLicence(licence) => material.provenance.licence.clone_from(licence),
            Self::SetNotes(notes) => material.notes.clone_from(notes),
            Self::SetValue(property, value) => _ = material.set(*property, *value).slot_mut(*property).texture.take(),
        }
    }
}

/// The text of a material file after some changes; everything else keeps its spelling. An error if it is no material file.
pub fn changed_text(text: &str, changes: &[Change]) -> Result<String, String> {
    edited(text, |material| changes.iter().for_each(|change| change.apply(material)))
}

fn edited(text: &str, edit: impl FnOnce(&mut Material)) -> Result<String, String> {
    let (file, _) = MaterialFile::parse(text).map_err(|error| error.to_string())?;
    let mut material = file.material().clone();
    edit(&mut material);
    Ok(file.to_text(&material))
}

/// A file and what it holds.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Content {
    /// Where it lies.
    pub path: PathBuf,
    /// All of it.
    pub text: String,
}

/// One file before and after; `None` where there is none. With two paths it is renamed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FileEdit {
    /// What is there.
    pub before: Option<Content>,
    /// What is to be there.
    pub after: Option<Content>,
}

/// An edit of many files: one step of undo.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct BatchEdit {
    /// What is done, for the list of steps.
    pub title: String,
    /// Files, each once. Those that would stay as they are, are not among them.
    pub files: Vec<FileEdit>,
}

/// An edit, and a sentence for each file that it cannot be made for.
#[derive(Clone, Debug, Default)]
pub struct Planned {
    /// What can be done.
    pub edit: BatchEdit,
    /// Why files were left out.
    pub refused: Vec<String>,
}

impl Planned {
    fn new(title: String) -> Self {
        Self { edit: BatchEdit { title, files: Vec::new() }, refused: Vec::new() }
    }

    fn add(&mut self, path: &Path, planned: Result<FileEdit, String>) {
        match planned {
            Ok(edit) if edit.before == edit.after => {}
            Ok(edit) => self.edit.files.push(edit),
            Err(problem) => self.refused.push(format!("{}: {problem}", path.display())),
        }
    }
}

/// Plans the same changes for many files.
pub fn change(paths: &[PathBuf], changes: &[Change]) -> Planned {
    let titles: Vec<String> = changes.iter().map(ToString::to_string).collect();
    let mut planned = Planned::new(format!("{} in {}", titles.join(", "), count(paths.len())));
    for path in paths {
        let edit = read(path).and_then(|before| {
            let after = Content { path: path.clone(), text: changed_text(&before.text, changes)? };
            Ok(FileEdit { before: Some(before), after: Some(after) })
        });
        planned.add(path, edit);
    }
    planned
}

/// Plans a new name for a material and its file, in the folder where it lies.
pub fn rename(path: &Path, name: &str) -> Planned {
    let mut planned = Planned::new(format!("Rename {} to {name}", stem(path)));
    let edit = read(path).and_then(|before| {
        let to = path.with_file_name(file_name(name)?);
        if to != path && fs::symlink_metadata(&to).is_ok() && !is_same_file(path, &to) {
            return Err(format!("expected a name that is free, found {}", to.display()));
        }
        let text = edited(&before.text, |material| material.name = name.trim().to_owned())?;
        Ok(FileEdit { before: Some(before), after: Some(Content { path: to, text }) })
    });
    planned.add(path, edit);
    planned
}

/// Plans a copy of each file beside it, under the first of `NAME copy`, `NAME copy 2`, ... that is free.
pub fn duplicate(paths: &[PathBuf]) -> Planned {
    let mut planned = Planned::new(format!("Duplicate {}", count(paths.len())));
    let mut taken = Vec::new();
    for path in paths {
        let edit = read(path).and_then(|original| {
            let (to, suffix) = free_name(path, &format!("{} copy", stem(path)), &taken);
            let text = edited(&original.text, |material| {
                if !material.name.is_empty() {
                    material.name += &format!(" copy{suffix}");
                }
            })?;
            taken.push(to.clone());
            Ok(FileEdit { before: None, after: Some(Content { path: to, text }) })
        });
        planned.add(path, edit);
    }
    planned
}

/// Plans a new file of this text for a material of this name in a folder.
pub fn create(folder: &Path, name: &str, text: String) -> Planned {
    let mut planned = Planned::new(format!("New material {name}"));
    let edit = file_name(name).map(|name| {
        let (path, _) = free_name(&folder.join(&name), &stem(Path::new(&name)), &[]);
        FileEdit { before: None, after: Some(Content { path, text }) }
    });
    planned.add(folder, edit);
    planned
}

/// Plans that a file takes in another one that is the same material: it gets the other's names as aliases, its tags, and the texts that it lacks;
/// values stay as they are. The other file goes.
pub fn unite(path: &Path, other: &Path) -> Planned {
    let mut planned = Planned::new(format!("Merge {} into {}", stem(other), stem(path)));
    let name_of = |path: &Path, material: &Material| match material.name.trim() {
        "" => stem(path),
        name => name.to_owned(),
    };
    let united = read(path).and_then(|before| {
        let gone = read(other).map_err(|problem| format!("{}: {problem}", other.display()))?;
        let (theirs, _) = MaterialFile::parse(&gone.text).map_err(|error| format!("{}: {error}", other.display()))?;
        let theirs = theirs.material();
        let text = edited(&before.text, |material| {
            let own = name_of(path, material);
            for name in std::iter::once(name_of(other, theirs)).chain(theirs.aliases.iter().cloned()) {
                if name != own && !material.aliases.contains(&name) {
                    material.aliases.push(name);
                }
            }
            theirs.tags.iter().for_each(|tag| Change::AddTag(tag.clone()).apply(material));
            let (mine, yours) = (&mut material.provenance, &theirs.provenance);
            for (text, other) in [
                (&mut material.notes, &theirs.notes),
                (&mut mine.source, &yours.source),
                (&mut mine.reference, &yours.reference),
                (&mut mine.method, &yours.method),
                (&mut mine.licence, &yours.licence),
            ] {
                if text.is_empty() {
                    text.clone_from(other);
                }
            }
            for (format, texts) in &theirs.foreign {
                for (key, text) in texts {
                    if material.foreign_text(format, key).is_none() {
                        // What is too much stays out; the file that goes can be brought back.
                        _ = material.set_foreign(format, key, Some(text.clone()));
                    }
                }
            }
        })?;
        let kept = FileEdit { before: Some(before), after: Some(Content { path: path.to_path_buf(), text }) };
        Ok([kept, FileEdit { before: Some(gone), after: None }])
    });
    match united {
        Ok(edits) => planned.edit.files.extend(edits),
        Err(problem) => planned.refused.push(format!("{}: {problem}", path.display())),
    }
    planned
}

/// Plans that a file that holds `before` holds `after`.
pub fn replace(path: &Path, title: String, before: String, after: String) -> Planned {
    let content = |text| Some(Content { path: path.to_path_buf(), text });
    let mut planned = Planned::new(title);
    planned.add(path, Ok(FileEdit { before: content(before), after: content(after) }));
    planned
}

impl BatchEdit {
    /// The edit that takes this one back.
    pub fn reversed(&self) -> Self {
        let reverse = |file: &FileEdit| FileEdit { before: file.after.clone(), after: file.before.clone() };
        Self { title: self.title.clone(), files: self.files.iter().map(reverse).collect() }
    }

    /// Carries the edit out. Returns the part of it that was done, which is what can be taken back, and a sentence for each file that
    /// was left as it was: because somebody else has changed it, or because it cannot be written.
    pub fn carry_out(&self) -> (Self, Vec<String>) {
        let (mut done, mut refused) = (Self { title: self.title.clone(), files: Vec::new() }, Vec::new());
        for file in &self.files {
            match file.carry_out() {
                Ok(()) => done.files.push(file.clone()),
                Err(sentence) => refused.push(sentence),
            }
        }
        (done, refused)
    }
}

impl FileEdit {
    fn carry_out(&self) -> Result<(), String> {
        if let Some(before) = &self.before {
            let found = read(&before.path).map_err(|problem| format!("{}: {problem}", before.path.display()))?;
            if found.text != before.text {
                return Err(format!("{}: left as it is, because another program has changed it", before.path.display()));
            }
        }
        let moves = |before: &Content, after: &Content| before.path != after.path;
        match (&self.before, &self.after) {
            (Some(before), Some(after)) if moves(before, after) => {
                if is_same_file(&before.path, &after.path) {
                    // Only the case of letters differs, where the file system does not tell them apart.
                    rename_file(&before.path, &after.path)?;
                    return save(after);
                }
                save_new(after)?;
                remove(&before.path)
            }
            (None, Some(after)) => save_new(after),
            (Some(_), Some(after)) => save(after),
            (Some(before), None) => remove(&before.path),
            (None, None) => Ok(()),
        }
    }
}

fn save(content: &Content) -> Result<(), String> {
    save_atomic(&content.path, content.text.as_bytes()).map_err(|error| error.to_string())
}

/// Writes a file where there is none.
fn save_new(content: &Content) -> Result<(), String> {
    let path = &content.path;
    match fs::File::create_new(path) {
        Err(error) if error.kind() == ErrorKind::AlreadyExists => {
            return Err(format!("{}: left as it is, because another file has this name now", path.display()));
        }
        Err(error) => return Err(format!("{}: cannot be written: {error}", path.display())),
        Ok(_) => {}
    }
    save(content).inspect_err(|_| _ = fs::remove_file(path))
}

fn remove(path: &Path) -> Result<(), String> {
    fs::remove_file(path).map_err(|error| format!("{}: cannot be removed: {error}", path.display()))
}

fn rename_file(from: &Path, to: &Path) -> Result<(), String> {
    fs::rename(from, to).map_err(|error| format!("{}: cannot be renamed: {error}", from.display()))
}

/// Whether two paths in one folder differ at most in the case of letters and lead to one file.
fn is_same_file(a: &Path, b: &Path) -> bool {
    let lower = |path: &Path| path.to_string_lossy().to_lowercase();
    lower(a) == lower(b) && fs::canonicalize(a).ok().is_some_and(|a| fs::canonicalize(b).ok() == Some(a))
}

fn read(path: &Path) -> Result<Content, String> {
    let read = files::read_text_file(path, MAX_FILE_BYTES as u64);
    let text = read.map_err(|error: FilesError| reason(&error, path))?;
    Ok(Content { path: path.to_path_buf(), text })
}

/// A file name for a material of this name. An error if no usual file system takes it.
fn file_name(name: &str) -> Result<String, String> {
    let name = name.trim();
    let is_bad = |c: char| c.is_control() || r#"/\:*?"<>|"#.contains(c);
    if name.is_empty() || name.starts_with('.') || name.ends_with('.') || name.len() > MAX_NAME || name.contains(is_bad) {
        return Err(format!(
            "expected a name of 1 to {MAX_NAME} bytes without / \\ : * ? \" < > | and without a dot at its ends, found `{name}`"
        ));
    }
    Ok(format!("{name}.{}", files::MATERIAL_EXTENSION))
}

/// The first of `NAME`, `NAME 2`, `NAME 3`, ... beside `path` that is free, with what was added.
fn free_name(path: &Path, name: &str, taken: &[PathBuf]) -> (PathBuf, String) {
    let mut number = 1_u64;
    loop {
        let suffix = if number == 1 { String::new() } else { format!(" {number}") };
        let to = path.with_file_name(format!("{name}{suffix}.{}", files::MATERIAL_EXTENSION));
        // A link that leads nowhere takes its name, too.
        if fs::symlink_metadata(&to).is_err() && !taken.contains(&to) {
            return (to, suffix);
        }
        number += 1;
    }
}

fn count(files: usize) -> String {
    format!("{files} file{}", if files == 1 { "" } else { "s" })
}
