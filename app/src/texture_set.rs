//! Which file of a texture set belongs to which property, told by the names that painting programs and libraries give.
//!
//! The name of a map is the last word of a file name, apart from resolutions, tiles, versions and the like:
//! `Rust_1001_BaseColor.png`, `rust_02_nor_gl_2k.exr`, `Rust01_2K-JPG_Roughness.jpg`, `Rust_GLOSS_4K_METALNESS.jpg`. Case and separators do
//! not matter. No file is opened here.

mod names;
#[cfg(test)]
mod tests;

use burnish_assets::is_image_path;
use burnish_material::exchange::texture_set::copy::ENDING;
use burnish_material::{Channel, Property};
use names::{Meaning, Use, bits_of, meaning_of, resolution_of, set_name, words_of};
use std::cmp::Reverse;
use std::path::{Path, PathBuf};

/// Entries of a folder beyond this number are no texture set.
const MAX_FILES: usize = 10_000;

/// What a set of files means.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TextureSetMatch {
    /// At most one texture per property, in the order of the property table.
    pub slots: Vec<MatchedSlot>,
    /// Files of which nothing is used, in the order given, each with a reason that follows its name.
    pub unmatched: Vec<(PathBuf, String)>,
}

/// A texture for a property.
#[derive(Clone, Debug, PartialEq)]
pub struct MatchedSlot {
    /// The slot.
    pub property: Property,
    /// The image.
    pub path: PathBuf,
    /// The channels that are read.
    pub channel: Channel,
    /// Whether the texture is read inverted: gloss as roughness, green of normal maps with -Y.
    pub is_inverted: bool,
}

/// A file that could fill a slot.
struct Candidate<'a> {
    place: Use,
    file: usize,
    path: &'a Path,
    /// The least one is taken.
    rank: Rank,
}

/// Packed, ending, bits of the name, resolution, inverted, place of the name in the table, file name.
type Rank = (bool, usize, Reverse<u32>, Reverse<u32>, bool, usize, String);

/// The files of one set in a folder.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SetFiles {
    /// Its name, as its files begin; empty where they have none.
    pub name: String,
    /// Its native copy.
    pub native: Option<PathBuf>,
    /// Its images, sorted.
    pub files: Vec<PathBuf>,
}

/// Finds the texture of every property by file names alone. Order does not matter, apart from that of the files without use.
pub fn match_set(files: &[PathBuf]) -> TextureSetMatch {
    match_named(files, "")
}

/// The same for a set whose name is known, so that no word of it is taken for the name of a map.
pub fn match_named(files: &[PathBuf], name: &str) -> TextureSetMatch {
    let words: Vec<Vec<String>> = files.iter().map(|file| words_of(after_name(&stem(file), name))).collect();
    let images: Vec<&Vec<String>> = files.iter().zip(&words).filter(|(file, _)| is_image_path(file)).map(|(_, w)| w).collect();
    let common = common_end(&images);
    let mut reasons: Vec<Option<String>> = vec![None; files.len()];
    let mut candidates = Vec::new();
    for (file, (path, words)) in files.iter().zip(&words).enumerate() {
        if !is_image_path(path) {
            reasons[file] = Some("is no image that can be read; expected .png, .jpg, .jpeg, .exr or .hdr".into());
            continue;
        }
        let without_set = &words[..words.len().saturating_sub(common)];
        match meaning_of(words).or_else(|| meaning_of(without_set)) {
            None => reasons[file] = Some("does not end in a name of a map, such as BaseColor or Roughness".into()),
            Some(Meaning::WithoutPlace(why)) => reasons[file] = Some(why.into()),
            Some(Meaning::Uses(uses, number)) => {
                let rank = |is_inverted| {
                    let (bits, resolution) = (bits_of(words), resolution_of(words));
                    let name = path.to_string_lossy().into_owned();
                    (uses.len() > 1, ending_rank(path), Reverse(bits), Reverse(resolution), is_inverted, number, name)
                };
                candidates.extend(uses.iter().map(|place| Candidate { place: *place, file, path, rank: rank(place.2) }));
            }
        }
    }
    candidates.sort_by(|a, b| (a.place.0, &a.rank).cmp(&(b.place.0, &b.rank)));
    let mut slots: Vec<MatchedSlot> = Vec::new();
    let mut is_used = vec![false; files.len()];
    for Candidate { place: (property, channel, is_inverted), file, path, .. } in candidates {
        match slots.last().filter(|slot| slot.property == property) {
            Some(slot) => {
                let taken = slot.path.file_name().unwrap_or_default().to_string_lossy();
                reasons[file] = Some(format!("is not needed: {} is read from {taken}", property.def().label));
            }
            None => {
                is_used[file] = true;
                slots.push(MatchedSlot { property, path: path.to_owned(), channel, is_inverted });
            }
        }
    }
    let unused = files.iter().zip(reasons).zip(is_used).filter(|(_, is_used)| !is_used);
    let unmatched = unused.filter_map(|((file, reason), _)| Some((file.clone(), reason?))).collect();
    TextureSetMatch { slots, unmatched }
}

/// The images directly in a folder, sorted; no folder in it is opened.
///
/// The error is a sentence that names the folder: it cannot be read, or holds more than 10,000 entries.
pub fn read_folder(path: &Path) -> Result<Vec<PathBuf>, String> {
    list(path, &is_image_path)
}

/// A file that belongs to no set, and why.
pub type LeftOut = (PathBuf, String);

/// The sets of a folder in the order of their names, and the images that belong to none, each with a reason that follows its name.
///
/// A set is what begins alike before the name of a map, or begins as a native copy is called. The error is a sentence that names the folder.
pub fn read_sets(path: &Path) -> Result<(Vec<SetFiles>, Vec<LeftOut>), String> {
    let is_copy = |file: &Path| copy_name(file).is_some();
    let copies = list(path, &is_copy)?;
    let mut sets: Vec<SetFiles> = copies
        .into_iter()
        .map(|file| SetFiles { name: copy_name(&file).unwrap_or_default(), native: Some(file), files: Vec::new() })
        .collect();
    let count = sets.len();
    let mut left = Vec::new();
    let images = read_folder(path)?;
    let words: Vec<Vec<String>> = images.iter().map(|file| words_of(&stem(file))).collect();
    let common = common_end(&words.iter().collect::<Vec<_>>());
    for (file, words) in images.into_iter().zip(&words) {
        let stem = stem(&file);
        let begins = |set: &&mut SetFiles| after_name(&stem, &set.name).len() < stem.len();
        // Of `Wood` and `Wood_Old`, the longer one.
        if let Some(set) = sets[..count].iter_mut().filter(begins).max_by_key(|set| set.name.len()) {
            set.files.push(file);
            continue;
        }
        let without_set = &words[..words.len().saturating_sub(common)];
        let name = match set_name(&stem, words) {
            Some(name) => name,
            // The name of the set stands last.
            None if meaning_of(without_set).is_some() => words[without_set.len()..].join("_"),
            None => {
                left.push((file, "does not end in a name of a map, such as BaseColor or Roughness".to_owned()));
                continue;
            }
        };
        match sets.iter_mut().find(|set| set.name.to_lowercase() == name.to_lowercase()) {
            Some(set) => set.files.push(file),
            None => sets.push(SetFiles { name, native: None, files: vec![file] }),
        }
    }
    sets.sort_by(|a, b| a.name.cmp(&b.name));
    Ok((sets, left))
}

/// The name of the set that a file is the native copy of; `None` for other files.
fn copy_name(file: &Path) -> Option<String> {
    let name = file.file_name()?.to_string_lossy().into_owned();
    let at = name.len().checked_sub(ENDING.len() + 1)?;
    let ending = name.get(at..)?.strip_prefix('.')?;
    (ending.eq_ignore_ascii_case(ENDING) && at > 0).then(|| name[..at].to_owned())
}

/// What stands behind the name of a set; the whole text where it does not begin so.
fn after_name<'a>(stem: &'a str, name: &str) -> &'a str {
    let rest = stem.get(..name.len()).filter(|start| start.eq_ignore_ascii_case(name)).map(|start| &stem[start.len()..]);
    rest.and_then(|rest| rest.strip_prefix(['_', '-', ' ', '.'])).filter(|_| !name.is_empty()).unwrap_or(stem)
}

fn list(path: &Path, is_wanted: &dyn Fn(&Path) -> bool) -> Result<Vec<PathBuf>, String> {
    let unreadable = |problem: std::io::Error| format!("{}: cannot be read: {problem}", path.display());
    let mut files = Vec::new();
    for (count, entry) in std::fs::read_dir(path).map_err(unreadable)?.enumerate() {
        if count >= MAX_FILES {
            return Err(format!("{}: expected a folder of at most {MAX_FILES} entries, found more", path.display()));
        }
        let file = entry.map_err(unreadable)?.path();
        // What a link leads to counts; one that leads nowhere or in circles is no file.
        if is_wanted(&file) && std::fs::metadata(&file).is_ok_and(|metadata| metadata.is_file()) {
            files.push(file);
        }
    }
    files.sort();
    Ok(files)
}

fn stem(path: &Path) -> String {
    path.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

/// Words that all names end in: the name of the set, where it stands last.
fn common_end(names: &[&Vec<String>]) -> usize {
    let [first, others @ ..] = names else { return 0 };
    if others.is_empty() {
        return 0;
    }
    let ends_alike = |n: &usize| others.iter().all(|name| name.ends_with(&first[first.len() - n..]));
    (1..=first.len()).take_while(ends_alike).last().unwrap_or(0)
}

/// Formats by how much they hold: floats, then up to 16 bits, then 8 bits with losses.
fn ending_rank(path: &Path) -> usize {
    let ending = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    ["exr", "hdr", "png"].iter().position(|e| *e == ending).unwrap_or(3)
}
