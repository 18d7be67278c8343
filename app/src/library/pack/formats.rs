//! The materials of a pack for other programs: a folder for each format with a file for each material and their images once each, and what that costs.

use super::super::sheet::slashed;
use super::content::{Content, Packed, plain};
use super::{MATERIALS, PackError, Tell, create, write};
use crate::digest::Digest;
use crate::exchange::names::FileNames;
use crate::exchange::save::{MAX_IMAGE_BYTES, Made, SaveOptions, Source, make};
use crate::exchange::{ExchangeError, Format};
use crate::files::{self, Embedded};
use crate::library::scan::Progress;
use burnish_assets::BuiltInTexture;
use burnish_material::PROPERTIES;
use burnish_material::exchange::loss::{Fate, Row};
use burnish_renderer::scene::TextureSet;
use serde_json::{Map, Value, json};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// What every material is written as, with the word on the command line that is the name of its folder, too.
pub const FORMATS: [(&str, Format); 3] = [("usd", Format::Usda), ("materialx", Format::MaterialX), ("gltf", Format::Gltf)];
/// What the formats cost.
pub(super) const LOSSES: &str = "losses.json";

/// Which of [`FORMATS`] are written. All, unless something says otherwise.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Formats(pub [bool; FORMATS.len()]);

impl Default for Formats {
    fn default() -> Self {
        Self([true; FORMATS.len()])
    }
}

impl Formats {
    /// None of them.
    pub const NONE: Self = Self([false; FORMATS.len()]);

    /// Words between commas, or `none`. An error says what is expected.
    pub fn parse(text: &str) -> Result<Self, String> {
        let mut formats = Self::NONE;
        if text.trim() == "none" {
            return Ok(formats);
        }
        for word in text.split(',').map(str::trim) {
            let place = FORMATS.iter().position(|(name, _)| *name == word).ok_or_else(|| {
                format!("expected {} with commas between, or none, found `{word}`", FORMATS.map(|(name, _)| name).join(", "))
            })?;
            formats.0[place] = true;
        }
        Ok(formats)
    }

    /// Those that are written.
    pub fn chosen(self) -> impl Iterator<Item = (&'static str, Format)> {
        FORMATS.into_iter().zip(self.0).filter_map(|(format, is_written)| is_written.then_some(format))
    }
}

/// Files of a material in the pack, by the words of their formats.
pub(super) type Written = BTreeMap<&'static str, String>;

/// Writes every material in every chosen format below `folder`, and what that costs. Files by material; `None` if it is cancelled.
pub(super) fn write_all(
    content: &Content<'_>,
    folder: &Path,
    formats: Formats,
    warnings: &mut Vec<String>,
    (tell, is_cancelled): (&Tell<'_>, &(dyn Fn() -> bool + Sync)),
) -> Result<Option<Vec<Written>>, PackError> {
    let mut written = vec![Written::new(); content.materials.len()];
    if formats == Formats::NONE {
        return Ok(Some(written));
    }
    let names = FileNames::of(content.materials.iter().flat_map(|one| &one.images).map(String::as_str));
    let mut shelves: Vec<Shelf> =
        formats.chosen().map(|(word, _)| Shelf { root: folder.join(word), word, files: BTreeMap::new() }).collect();
    let mut losses = Vec::new();
    let total = content.materials.len();
    for (done, (one, stem)) in content.materials.iter().zip(stems(&content.materials)).enumerate() {
        tell("other formats", Progress { done, total });
        let source = source(one, &folder.join(MATERIALS), &names)?;
        let mut of_material = Map::new();
        for ((word, format), shelf) in formats.chosen().zip(&mut shelves) {
            let file = format!("{stem}.{}", format.def().ending);
            let made = make(std::slice::from_ref(&source), Path::new(&file), SaveOptions::default(), &|_| !is_cancelled());
            let made = match made {
                Ok(made) => made,
                Err(ExchangeError::Cancelled) => return Ok(None),
                Err(error) => return Err(PackError::Exchange(error)),
            };
            let path = shelf.put(&stem, &file, &made)?;
            warnings.extend(made.notes.iter().map(|note| format!("{path}: {note}")));
            of_material.insert(word.to_owned(), loss(format, &path, &made));
            written[done].insert(word, path);
        }
        let path = format!("{MATERIALS}/{}", slashed(&one.entry.path));
        losses.push(json!({ "path": path, "name": one.entry.name, "formats": of_material }));
    }
    write(&folder.join(LOSSES), format!("{:#}\n", json!({ "materials": losses })).as_bytes())?;
    Ok(Some(written))
}

/// Names of files without their endings: those of the material files, no two the same.
fn stems(materials: &[Packed<'_>]) -> Vec<String> {
    let own = |one: &Packed<'_>| {
        let name = one.entry.path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        name.strip_suffix(".asm.ron").map_or(name.clone(), str::to_owned)
    };
    let mut taken = BTreeSet::new();
    materials
        .iter()
        .map(|one| {
            let own = own(one);
            let mut free = (1..).map(|n| if n == 1 { own.clone() } else { format!("{own}-{n}") });
            free.find(|name| taken.insert(name.to_lowercase())).unwrap_or_default()
        })
        .collect()
}

/// A packed material on its way out, with its images under their new names. Those that are not in the pack are left out.
fn source(one: &Packed<'_>, materials: &Path, names: &FileNames) -> Result<Source, PackError> {
    let group = one.entry.path.parent().unwrap_or(Path::new(""));
    let (read, _) = files::load_textures(one.file.material(), Some(&materials.join(group)));
    let mut material = one.file.material().clone();
    let (mut textures, mut embedded) = (TextureSet::new(), Embedded::new());
    for def in PROPERTIES {
        let slot = material.slot_mut(def.id);
        let Some(texture) = &mut slot.texture else { continue };
        let image = read.get(&texture.path).cloned();
        if BuiltInTexture::parse(&texture.path).is_none() {
            let packed = slashed(&plain(&group.join(&texture.path)));
            if !one.images.contains(&packed) {
                slot.texture = None;
                continue;
            }
            texture.path = names.file(&packed);
            if !embedded.contains_key(&texture.path) {
                let bytes = files::read_file(&materials.join(&packed), MAX_IMAGE_BYTES)?;
                embedded.insert(texture.path.clone(), bytes.into());
            }
        }
        textures.extend(image.map(|image| (texture.path.clone(), image)));
    }
    Ok(Source { material, file: Some(Arc::new(one.file.clone())), folder: None, textures, embedded })
}

/// The folder of a format.
struct Shelf {
    root: PathBuf,
    word: &'static str,
    /// What is in it, by paths in lower case: not every system tells cases apart.
    files: BTreeMap<String, Digest>,
}

impl Shelf {
    /// Writes a document with all that goes beside it; its path in the pack. Where another file has a name already, it gets a folder of its own.
    fn put(&mut self, stem: &str, file: &str, made: &Made) -> Result<String, PackError> {
        let beside: Vec<(&String, &Vec<u8>, Digest)> =
            made.files.iter().map(|(name, bytes)| (name, bytes, Digest::of(bytes))).collect();
        let is_other = |(name, _, digest): &(&String, &Vec<u8>, Digest)| {
            self.files.get(&name.to_lowercase()).is_some_and(|known| known != digest)
        };
        let own = if beside.iter().any(is_other) { format!("{stem}/") } else { String::new() };
        for (name, bytes, digest) in beside {
            let name = format!("{own}{name}");
            if self.files.insert(name.to_lowercase(), digest).is_none() {
                self.write(&name, bytes)?;
            }
        }
        self.write(&format!("{own}{file}"), &made.document)?;
        Ok(format!("{}/{own}{file}", self.word))
    }

    fn write(&self, name: &str, bytes: &[u8]) -> Result<(), PackError> {
        let path = self.root.join(name);
        path.parent().map_or(Ok(()), create)?;
        write(&path, bytes)
    }
}

/// What a format costs a material: those properties that do not come back as they are from what other programs see.
fn loss(format: Format, path: &str, made: &Made) -> Value {
    let lost = made.rows.iter().flatten().filter(|row| row.fate > Fate::Remapped);
    let row = |Row { property, target, fate, note, has_effect }: &Row| {
        json!({
            "property": property.def().name,
            "target": target,
            "fate": fate.word(),
            "note": note,
            "has_effect": has_effect,
        })
    };
    json!({
        "file": path,
        "model": format.def().model().map(|model| model.name),
        "rows": lost.map(row).collect::<Vec<_>>(),
        "notes": made.notes,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formats_are_words_between_commas() {
        assert_eq!(Formats::parse("usd,materialx,gltf"), Ok(Formats::default()));
        assert_eq!(Formats::parse("gltf, usd"), Ok(Formats([true, false, true])));
        assert_eq!(Formats::parse("none"), Ok(Formats::NONE));
        let expected = "expected usd, materialx, gltf with commas between, or none, found `glTF`";
        assert_eq!(Formats::parse("usd,glTF"), Err(expected.to_owned()));
        assert!(Formats::parse("").is_err());
    }
}
