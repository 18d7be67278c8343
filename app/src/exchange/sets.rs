//! Texture sets on disk: a folder of images named after properties, with the native copy of each set beside them.

use super::documents::compute;
use super::error::{ExchangeError, Fault};
use super::open::Opened;
use super::save::{Beside, Source, image_bytes, names_of};
use crate::digest::Digest;
use crate::files::{self, Embedded};
use crate::texture_set::{SetFiles, match_named, read_sets};
use burnish_material::Slot;
use burnish_material::exchange::ShadingModel;
use burnish_material::exchange::model::Context;
use burnish_material::exchange::models::maps;
use burnish_material::exchange::texture_set::copy::{self, MAX_BYTES, Placed};
use burnish_material::exchange::texture_set::{Copy, Flavour, Options, plan};
use std::collections::BTreeMap;
use std::path::Path;

/// Largest image whose changes are found.
const MAX_IMAGE_BYTES: u64 = 1 << 30;

/// The materials of a folder, one for each set.
pub(super) fn open_folder(folder: &Path) -> Result<Vec<Opened>, ExchangeError> {
    let (sets, left) = read_sets(folder).map_err(ExchangeError::Folder)?;
    let opened = sets.into_iter().map(|set| open_set(folder, set)).collect::<Result<Vec<Opened>, ExchangeError>>()?;
    let says_something = |found: &Opened| found.file.material().slots().any(|(_, slot)| *slot != Slot::default());
    let (mut opened, empty): (Vec<Opened>, Vec<Opened>) = opened.into_iter().partition(says_something);
    let notes = empty.into_iter().flat_map(|found| found.notes).chain(left.iter().map(|(path, why)| not_used(path, why)));
    match opened.first_mut() {
        Some(first) => first.notes.extend(notes),
        None => return Err(ExchangeError::NoSet { path: folder.to_path_buf() }),
    }
    Ok(opened)
}

/// The material of the set that a native copy belongs to.
pub(super) fn open_copy(path: &Path) -> Result<Opened, ExchangeError> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let (sets, _) = read_sets(folder).map_err(ExchangeError::Folder)?;
    let is_it = |set: &SetFiles| set.native.as_ref().is_some_and(|native| native.file_name() == path.file_name());
    let set = sets.into_iter().find(is_it);
    // What is no file of the folder is told as such by whoever reads it.
    open_set(folder, set.unwrap_or_else(|| SetFiles { native: Some(path.to_path_buf()), ..SetFiles::default() }))
}

fn open_set(folder: &Path, set: SetFiles) -> Result<Opened, ExchangeError> {
    let native = match &set.native {
        Some(path) => {
            let text = files::read_text_file(path, MAX_BYTES as u64)?;
            let content = |error| ExchangeError::Content { path: path.clone(), fault: Fault::Set(error) };
            Some(copy::read(&text).map_err(content)?)
        }
        None => None,
    };
    let is_native = native.is_some();
    let matched = match_named(&set.files, &set.name);
    let name = |path: &Path| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let placed = |slot: &crate::texture_set::MatchedSlot| Placed {
        property: slot.property,
        file: name(&slot.path),
        channel: slot.channel,
        is_inverted: slot.is_inverted,
    };
    let found: Vec<Placed> = matched.slots.iter().map(placed).collect();
    // No other file is looked at, whatever the native copy names.
    let print_of = |file: &str| {
        let path = set.files.iter().find(|path| name(path) == file)?;
        files::read_file(path, MAX_IMAGE_BYTES).ok().map(|bytes| Digest::of(&bytes).to_string())
    };
    let is_known = |path: &Path| native.as_ref().is_some_and(|native| native.images.contains_key(&name(path)));
    let unused: Vec<String> =
        matched.unmatched.iter().filter(|(path, _)| !is_known(path)).map(|(path, why)| not_used(path, why)).collect();
    let (mut material, mut notes) = copy::merge(native, &found, &print_of);
    notes.extend(unused);
    if !is_native {
        material.name = if set.name.is_empty() { name(folder) } else { set.name };
    }
    Ok(Opened::of(&material, Some(folder), &Embedded::new(), notes))
}

fn not_used(path: &Path, why: &str) -> String {
    format!("{}: not used: {why}", path.file_name().unwrap_or_default().to_string_lossy())
}

/// Makes the images of a set, and the text of its native copy.
pub(super) fn write(
    source: &Source,
    name: &str,
    model: Option<&'static ShadingModel>,
    beside: &mut Beside,
    go_on: &dyn Fn(f32) -> bool,
) -> Result<String, ExchangeError> {
    let names = names_of(std::slice::from_ref(source));
    let flavour = Flavour::of(model.unwrap_or(&maps::MODEL));
    let options = Options { flavour, has_uniform: true };
    let set = plan(&source.material, name, &|path| names.file(path), options);
    for Copy { path, file } in set.copies.iter().chain(&set.originals) {
        match image_bytes(source, path) {
            Some(Ok(bytes)) => _ = beside.files.insert(file.clone(), bytes),
            Some(Err(problem)) => beside.notes.push(problem),
            None => {}
        }
    }
    let (sources, contexts) = (std::slice::from_ref(source), [Context::of(&source.material)]);
    for image in &set.images {
        compute(std::slice::from_ref(&image.job), image.model, sources, &contexts, beside, go_on)?;
    }
    beside.notes.extend(set.notes.iter().cloned());
    let images = set.copies.iter().map(|copy| &copy.file).chain(set.images.iter().map(|image| &image.job.file));
    let prints: BTreeMap<String, String> =
        images.filter_map(|file| Some((file.clone(), Digest::of(beside.files.get(file)?).to_string()))).collect();
    Ok(copy::write(&set.placed(&source.material), &prints))
}
