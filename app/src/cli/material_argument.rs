//! `MATERIAL` on the command line: a path to a material file or to a picture of ours, or `preset:NAME`.

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

/// Reads what `MATERIAL` means. A refused value is an error here, whereas the editor opens the rest.
pub fn load(text: &str, messages: &mut Messages) -> Result<LoadedMaterial, CliError> {
    let path = Path::new(text);
    if preset_name(text).is_none() && burnish_assets::is_image_path(path) {
        return of_picture(path, messages);
    }
    if preset_name(text).is_none()
        && let Some(opened) = of_other_format(path, messages)?
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
    let file = load_file(text, messages)?;
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
pub fn load_file(text: &str, messages: &mut Messages) -> Result<MaterialFile, CliError> {
    if let Some(name) = preset_name(text) {
        let preset = find_preset(name)?;
        let place = format!("preset:{}", preset.name);
        let (file, warnings) = preset.parse().map_err(|error| CliError::unusable(format!("{place}: {error}")))?;
        report(&place, &warnings, messages)?;
        return Ok(file);
    }
    let path = Path::new(text);
    if let Some(opened) = of_other_format(path, messages)? {
        return Ok(opened.file);
    }
    if !path.exists() && burnish_presets::find(text).is_some() {
        return Err(CliError::unusable(format!("{text}: there is no such file; did you mean `preset:{text}`?")));
    }
    let (file, warnings) = files::read_material(path).map_err(CliError::unusable)?;
    report(text, &warnings, messages)?;
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

/// The first material of a file in another format; a warning names the others. `None` for a native file.
fn of_other_format(path: &Path, messages: &mut Messages) -> Result<Option<Opened>, CliError> {
    match Format::of(path) {
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
    let others: Vec<String> = all.drain(1..).map(|other| other.file.material().name.clone()).collect();
    if !others.is_empty() {
        messages.warn(format!("{}: the first material is taken; the others are {}", path.display(), others.join(", ")));
    }
    let first = all.pop();
    first.iter().flat_map(|first| &first.notes).for_each(|note| messages.warn_about(path, note));
    Ok(first)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn presets_are_found_in_any_case_and_others_refused_with_a_sentence() {
        let first = burnish_presets::presets().first().unwrap();
        let mut messages = Messages::default();
        for prefix in ["preset:", "PRESET:"] {
            let loaded = load(&format!("{prefix}{}", first.name.to_uppercase()), &mut messages).unwrap();
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
            let error = load(text, &mut messages).unwrap_err().to_string();
            assert!(error.contains(expected), "{text}: {error}");
        }
    }
}
