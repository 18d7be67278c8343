//! One file: everything that can be said of it alone.

use super::super::entry::{Entry, reason, stem, values_hash};
use super::super::setup::Setup;
use super::super::shelf::State;
use super::threads::Kept;
use super::{Kind, Look, Options, Row, Shelved, doubts};
use crate::digest::Digest;
use crate::files::{self, FilesError};
use burnish_material::{FileError, Material, MaterialFile, Severity, Warning};
use burnish_renderer::stability::{self, Case};
use image::ImageReader;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// What was found of one file, and what it is compared with others by.
#[derive(Clone)]
pub(super) struct Report {
    pub rows: Vec<Row>,
    /// Name of the material, or of the file where it has none.
    pub name: String,
    /// Hash of all that can be seen but for the pixels of images; `None` for what cannot be read whole.
    pub values: Option<Digest>,
    /// Where its images lie, in the order of the hash.
    pub images: Vec<PathBuf>,
    pub look: Option<Arc<Look>>,
}

impl Report {
    pub fn add(&mut self, path: &Path, line: Option<usize>, severity: Severity, key: &str, message: String, kind: Kind) {
        self.rows.push(Row { path: path.to_path_buf(), line, severity, key: key.to_owned(), message, kind });
    }
}

/// How files are looked at.
pub(super) struct Checker<'a> {
    /// `None` for files that are no library.
    pub library: Option<&'a Shelved<'a>>,
    pub options: &'a Options,
    /// The scene to render and probe in, if that is asked for.
    pub setup: Option<&'a Setup>,
    pub is_cancelled: &'a (dyn Fn() -> bool + Sync),
}

impl Checker<'_> {
    /// Reads a file and everything about it that was asked for. `entry` is what the library knows of it.
    pub fn report(&self, path: &Path, entry: Option<&Entry>, kept: &mut Kept) -> Report {
        self.report_of(path, files::read_material(path), entry, kept)
    }

    /// The same of what is not read from disk, or was.
    pub fn report_of(
        &self,
        path: &Path,
        read: Result<(MaterialFile, Vec<Warning>), FilesError>,
        entry: Option<&Entry>,
        kept: &mut Kept,
    ) -> Report {
        let mut report = Report { rows: Vec::new(), name: stem(path), values: None, images: Vec::new(), look: None };
        let (file, warnings) = match read {
            Ok(read) => read,
            Err(error) => {
                let (line, message) = place(&error, path);
                report.add(path, line, Severity::Error, "", message, Kind::Parse);
                return report;
            }
        };
        let is_refused = warnings.iter().any(|warning| warning.is_refused);
        for warning in warnings {
            let severity = if warning.is_refused { Severity::Error } else { Severity::Warning };
            report.add(path, Some(warning.line), severity, &warning.key, warning.message, Kind::Parse);
        }
        self.values(path, &file, &mut report);
        let material = file.material();
        if !material.name.trim().is_empty() {
            report.name.clone_from(&material.name);
        }
        if !is_refused {
            self.neighbours(path, material, &mut report);
            self.pictures(path, material, entry, kept, &mut report);
        }
        report
    }

    /// What the values, the images and the texts beside them tell.
    fn values(&self, path: &Path, file: &MaterialFile, report: &mut Report) {
        // A value outside its range can be rendered, clamped: only a library for others has to be without.
        let worst = if self.library.is_some() { Severity::Error } else { Severity::Warning };
        let material = file.material();
        let findings = burnish_material::check(material);
        for finding in &findings {
            let key = finding.property.map_or("", |property| property.def().name);
            let message = doubts::with_nearest(material, finding);
            report.add(path, None, finding.severity.min(worst), key, message, finding.kind.into());
        }
        for (key, message) in unusable_textures(material, path.parent()) {
            report.add(path, None, worst, key, message, Kind::Texture);
        }
        for (property, message) in doubts::unlikely(material, &findings) {
            report.add(path, None, Severity::Note, property.def().name, message, Kind::Unlikely);
        }
        for (key, message) in doubts::scale(file) {
            report.add(path, None, Severity::Warning, key, message, Kind::Scale);
        }
        for (key, message) in doubts::provenance(material) {
            // What is not handed out may keep its origin to itself.
            let severity = if self.library.is_some() { Severity::Warning } else { Severity::Note };
            report.add(path, None, severity, key, message.to_owned(), Kind::Provenance);
        }
    }

    /// What the file is compared with others by.
    fn neighbours(&self, path: &Path, material: &Material, report: &mut Report) {
        let mut names: Vec<String> = Vec::new();
        let textures = material.slots().filter_map(|(_, slot)| slot.texture.as_ref());
        for texture in textures.filter(|texture| !texture.path.is_empty()) {
            if !names.contains(&texture.path) {
                names.push(texture.path.clone());
            }
        }
        report.values = Some(values_hash(material, &names));
        report.images = names.iter().map(|name| image_place(name, path.parent())).collect();
    }

    fn pictures(&self, path: &Path, material: &Material, entry: Option<&Entry>, kept: &mut Kept, report: &mut Report) {
        if let (Some(library), Some(entry)) = (self.library, entry) {
            let message = match library.shelf.state(entry, library.setup) {
                State::Fresh => None,
                State::Stale => Some("the small picture is stale: taken of other values or in another way"),
                State::Draft | State::Missing => Some("there is no small picture"),
            };
            if let Some(message) = message {
                report.add(path, None, Severity::Note, "", message.to_owned(), Kind::Thumbnail);
            }
            if !self.options.renders_looks {
                report.look = library.look(entry).map(Arc::new);
            }
        }
        let Some(setup) = self.setup else { return };
        let (textures, _) = files::load_textures(material, path.parent());
        let scene = setup.scene_of(material.clone(), textures);
        // A picture that fails must not end the check of the others.
        let done = catch_unwind(AssertUnwindSafe(|| {
            if self.options.renders_looks {
                report.look = Look::render(&scene, &mut kept.look, self.is_cancelled).map(Arc::new);
            }
            let case = Case { name: report.name.clone(), scene };
            self.options.probes_stability.then(|| stability::probe(&case, &mut kept.probe, self.is_cancelled)).flatten()
        }));
        match done {
            Ok(Some(probe)) => {
                let (severity, verdict) =
                    if probe.holds() { (Severity::Note, "holds; the worst") } else { (Severity::Error, "does not hold") };
                report.add(path, None, severity, "", format!("{verdict}: {}", probe.worst), Kind::Stability);
            }
            Ok(None) => {}
            Err(_) => {
                *kept = Kept::default();
                let message = "could not be rendered, because the renderer failed".to_owned();
                report.add(path, None, Severity::Error, "", message, Kind::Stability);
            }
        }
    }
}

/// The line to blame, and the reason without the path.
fn place(error: &FilesError, path: &Path) -> (Option<usize>, String) {
    match error {
        FilesError::Material { source, .. } => {
            let line = match source {
                FileError::NotRon { line, .. } | FileError::NotMap { line, .. } | FileError::DuplicateKey { line, .. } => {
                    Some(*line)
                }
                FileError::TooLarge { .. } => None,
            };
            (line, source.to_string())
        }
        _ => (None, reason(error, path)),
    }
}

/// Where an image lies; one that the program makes, by its name alone.
fn image_place(name: &str, folder: Option<&Path>) -> PathBuf {
    files::texture_path(name, folder).unwrap_or_else(|| PathBuf::from(name))
}

/// Images that a material names and that cannot be read; of those that can, only the head is looked at.
fn unusable_textures(material: &Material, folder: Option<&Path>) -> Vec<(&'static str, String)> {
    let textures = material.slots().filter_map(|(property, slot)| Some((property.def().name, slot.texture.as_ref()?)));
    // A texture without a path is a finding already.
    textures
        .filter(|(_, texture)| !texture.path.is_empty())
        .filter_map(|(key, texture)| {
            let unreadable = || head_problem(&files::texture_path(&texture.path, folder)?);
            Some((key, files::texture_problem(&texture.path, folder).or_else(unreadable)?))
        })
        .collect()
}

/// Why the head of an image cannot be read.
fn head_problem(place: &Path) -> Option<String> {
    let is_exr = place.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("exr"));
    let problem = if is_exr {
        exr::meta::MetaData::read_from_file(place, false).err().map(|error| error.to_string())
    } else {
        let size = ImageReader::open(place).and_then(ImageReader::with_guessed_format).map(ImageReader::into_dimensions);
        match size {
            Ok(Ok(_)) => None,
            Ok(Err(error)) => Some(error.to_string()),
            Err(error) => Some(error.to_string()),
        }
    };
    problem.map(|problem| format!("expected an image (.png, .jpg, .jpeg, .exr or .hdr) at {}, but: {problem}", place.display()))
}
