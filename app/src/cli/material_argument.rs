//! `MATERIAL` on the command line: a path to a file of any format that holds materials, to a folder of texture sets or to a picture of ours, or
//! `preset:NAME`; and `--material`, which says which of several.

use super::set::outside_range;
use super::{CliError, Messages, suggest};
use crate::exchange::open::{Opened, open};
use crate::exchange::{ExchangeError, Format};
use crate::files;
use crate::picture_file::embedded_job;
use burnish_material::{Finding, LimitKind, Material, MaterialFile, Severity, Warning};
use burnish_renderer::scene::TextureSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A material that can be rendered, with the images it names.
#[derive(Clone, Debug, Default)]
pub struct LoadedMaterial {
    /// The values, none of them refused.
    pub material: Arc<Material>,
    /// Images by the path that the material names.
    pub textures: Arc<TextureSet>,
    /// The file with its text; `None` for a material without one.
    pub file: Option<Arc<MaterialFile>>,
    /// Where the images came from, by the path that the material names.
    pub texture_files: Vec<(String, PathBuf)>,
}

/// The name in `preset:NAME`; `None` for a path.
pub fn preset_name(text: &str) -> Option<&str> {
    let (prefix, name) = text.split_once(':')?;
    prefix.eq_ignore_ascii_case("preset").then_some(name)
}

/// The preset of that name in any case.
pub fn find_preset(name: &str) -> Result<&'static burnish_presets::Preset, CliError> {
    burnish_presets::find(name).ok_or_else(|| {
        let known = burnish_presets::presets().iter().flat_map(|preset| [preset.name, preset.file_stem]);
        let hint = suggest::hint(name, known);
        CliError::unusable(format!("preset:{name}: expected a name from `burnish presets list`{hint}"))
    })
}

/// The place of the material that `wanted` means, by its name in any case or its number from 1. `input`: what holds them.
fn place_of(names: &[&str], wanted: &str, input: &str) -> Result<usize, CliError> {
    let by_name = names.iter().position(|name| name.eq_ignore_ascii_case(wanted));
    let by_number = || wanted.parse::<usize>().ok().filter(|n| (1..=names.len()).contains(n)).map(|n| n - 1);
    by_name.or_else(by_number).ok_or_else(|| {
        let hint = suggest::hint(wanted, names.iter().copied());
        let count = names.len();
        CliError::unusable(format!(
            "--material: expected a name or a number from 1 to {count} of {input}, found `{wanted}`{hint}"
        ))
    })
}

/// The material that is meant among several.
pub fn chosen(mut opened: Vec<Opened>, wanted: &str, input: &str) -> Result<Opened, CliError> {
    let names: Vec<&str> = opened.iter().map(|found| found.file.material().name.as_str()).collect();
    let place = place_of(&names, wanted, input)?;
    Ok(opened.swap_remove(place))
}

/// An error where another material is asked for than the only one.
fn expect_only(material: &Material, choice: Option<&str>, input: &str) -> Result<(), CliError> {
    choice.map_or(Ok(()), |wanted| place_of(&[&material.name], wanted, input).map(|_| ()))
}

/// Reads what `MATERIAL` means; `choice`: what `--material` says. A refused value is an error here, whereas the editor opens the rest.
pub fn load(text: &str, choice: Option<&str>, messages: &mut Messages) -> Result<LoadedMaterial, CliError> {
    let path = Path::new(text);
    if preset_name(text).is_none() && burnish_assets::is_image_path(path) {
        let loaded = of_picture(path, messages)?;
        expect_only(&loaded.material, choice, text)?;
        return Ok(loaded);
    }
    if preset_name(text).is_none()
        && let Some(opened) = of_other_format(path, choice, messages)?
    {
        let (textures, problems) = opened.textures();
        problems.iter().for_each(|problem| messages.warn_about(path, problem));
        return Ok(LoadedMaterial {
            material: Arc::new(opened.file.material().clone()),
            textures: Arc::new(textures),
            file: Some(Arc::new(opened.file)),
            ..LoadedMaterial::default()
        });
    }
    let file = load_file(text, choice, messages)?;
    let material = file.material().clone();
    if preset_name(text).is_some() {
        let (textures, problems) = files::load_textures(&material, None);
        problems.into_iter().for_each(|problem| messages.warn(format!("{text}: {problem}")));
        return Ok(LoadedMaterial {
            material: Arc::new(material),
            textures: Arc::new(textures),
            file: Some(Arc::new(file)),
            ..LoadedMaterial::default()
        });
    }
    let (textures, missing) = files::load_textures(&material, path.parent());
    for sentence in missing {
        messages.warn_about(path, &sentence);
    }
    let file_of = |name: &String| Some((name.clone(), files::texture_path(name, path.parent())?));
    let texture_files = textures.keys().filter_map(file_of).collect();
    for finding in burnish_material::check(&material).iter().filter(|finding| finding.severity >= Severity::Warning) {
        messages.warn(format!("{text}: {}", finding_text(&material, finding)));
    }
    Ok(LoadedMaterial { material: Arc::new(material), textures: Arc::new(textures), file: Some(Arc::new(file)), texture_files })
}

/// The material that a picture of ours was made from. Images that are no longer where they were are warned about.
fn of_picture(path: &Path, messages: &mut Messages) -> Result<LoadedMaterial, CliError> {
    let job = embedded_job(path).map_err(CliError::unusable)?;
    let (opened, texture_files) = files::open_embedded(path, job.as_ref()).map_err(CliError::unusable)?;
    opened.warnings.iter().for_each(|warning| messages.warn_about(path, warning));
    let material = Arc::new(opened.file.material().clone());
    Ok(LoadedMaterial { material, textures: opened.textures, file: Some(Arc::new(opened.file)), texture_files })
}

/// The same as the file with its text, without its images.
pub fn load_file(text: &str, choice: Option<&str>, messages: &mut Messages) -> Result<MaterialFile, CliError> {
    let path = Path::new(text);
    let (place, (file, warnings)) = if let Some(name) = preset_name(text) {
        let preset = find_preset(name)?;
        let place = format!("preset:{}", preset.name);
        let read = preset.parse().map_err(|error| CliError::unusable(format!("{place}: {error}")))?;
        (place, read)
    } else if let Some(opened) = of_other_format(path, choice, messages)? {
        return Ok(opened.file);
    } else if !path.exists() && burnish_presets::find(text).is_some() {
        return Err(CliError::unusable(format!("{text}: there is no such file; did you mean `preset:{text}`?")));
    } else {
        (text.to_owned(), files::read_material(path).map_err(CliError::unusable)?)
    };
    report(&place, &warnings, messages)?;
    expect_only(file.material(), choice, &place)?;
    Ok(file)
}

/// A finding with its property; a value outside a range that renderers enforce is told as `--set` tells it.
fn finding_text(material: &Material, finding: &Finding) -> String {
    let Some(property) = finding.property else { return finding.message.clone() };
    let def = property.def();
    let value = material.slot(property).value.filter(|_| def.limits.kind == LimitKind::Hard);
    let outside = value.and_then(|value| outside_range(def, value));
    outside.unwrap_or_else(|| format!("{}: {}", def.name, finding.message))
}

/// Passes warnings on; the first refused value is an error instead.
fn report(place: &str, warnings: &[Warning], messages: &mut Messages) -> Result<(), CliError> {
    if let Some(refused) = warnings.iter().find(|warning| warning.is_refused) {
        return Err(CliError::unusable(format!("{place}: {refused}")));
    }
    for warning in warnings {
        messages.warn(format!("{place}: {warning}"));
    }
    Ok(())
}

/// The material of a file in another format, or of a folder of texture sets: the one that is chosen, else the first, and a warning names the
/// others. `None` for a native file.
fn of_other_format(path: &Path, choice: Option<&str>, messages: &mut Messages) -> Result<Option<Opened>, CliError> {
    match Format::of(path) {
        None if path.is_dir() => {}
        None => {
            let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase()).unwrap_or_default();
            if ["usd", "usdc", "sbsar"].contains(&ending.as_str()) {
                return Err(CliError::unusable(ExchangeError::UnknownFormat { path: path.to_path_buf() }));
            }
            return Ok(None);
        }
        Some(Format::Native) => return Ok(None),
        Some(_) => {}
    }
    let mut all = open(path).map_err(CliError::unusable)?;
    let taken = match choice {
        Some(wanted) => Some(chosen(all, wanted, &path.display().to_string())?),
        None => {
            let others: Vec<String> = all.drain(1..).map(|other| other.file.material().name.clone()).collect();
            if !others.is_empty() {
                let others = others.join(", ");
                messages.warn(format!(
                    "{}: the first material is taken; --material chooses among the others: {others}",
                    path.display()
                ));
            }
            all.pop()
        }
    };
    taken.iter().flat_map(|taken| &taken.notes).for_each(|note| messages.warn_about(path, note));
    Ok(taken)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn presets_are_found_in_any_case_and_others_refused_with_a_sentence() {
        let first = burnish_presets::presets().first().unwrap();
        let mut messages = Messages::default();
        for prefix in ["preset:", "PRESET:"] {
            let loaded = load(&format!("{prefix}{}", first.name.to_uppercase()), None, &mut messages).unwrap();
            assert_eq!(loaded.material.name, first.name);
        }
        assert!(messages.warnings().is_empty());

        let cases = [
            ("preset:no such thing at all", "presets list"),
            (first.name, "did you mean `preset:"),
            ("chair.gltf", "chair.gltf: cannot be read"),
            ("picture.PNG", "picture.PNG: cannot be read"),
            ("nowhere.asm.ron", "nowhere.asm.ron: cannot be read"),
        ];
        for (text, expected) in cases {
            let error = load(text, None, &mut messages).unwrap_err().to_string();
            assert!(error.contains(expected), "{text}: {error}");
        }
    }
}
