//! `burnish [FILE...]`: the window, or one picture where there is no display to show it on.

use super::material_argument::LoadedMaterial;
use super::render::{self, RenderArguments};
use super::scene_options::SceneOptions;
use super::{CliError, Outcome, interrupt};
use crate::app::{WindowError, WindowOptions};
use crate::exchange::{Format, is_mesh_path};
use burnish_assets::is_environment_path;
use std::path::{Path, PathBuf};

/// Where the picture goes when there is no display.
const FALLBACK_FILE: &str = "burnish.png";
/// Whichever is first: the picture should be good on any machine and not take long on a slow one.
const FALLBACK_SPP: u32 = 64;
const FALLBACK_SECONDS: f64 = 20.0;

/// Opens the editor on the files. With no display, or where the window does not start, it renders the default scene.
pub fn run(files: Vec<PathBuf>, options: &WindowOptions) -> Result<Outcome, CliError> {
    if let Some(missing) = files.iter().find(|file| !file.exists()) {
        return Err(CliError::unusable(format!("{}: expected a file or a folder, found none", missing.display())));
    }
    let reason = if has_display() {
        match crate::app::run(files.clone(), options) {
            Ok(()) => return Ok(Outcome::Done),
            Err(WindowError::Lost(why)) => return Err(CliError::unusable(why)),
            Err(WindowError::NotOpened(error)) => format!("the window did not open: {error}"),
        }
    } else {
        "there is no display: neither WAYLAND_DISPLAY nor DISPLAY is set".to_owned()
    };
    if let Some(file) = &options.screenshot {
        return Err(CliError::unusable(format!("--screenshot {}: expected a display: {reason}", file.display())));
    }
    picture_instead(&files, &reason)
}

/// Whether a window could be shown. Only Linux tells before trying.
fn has_display() -> bool {
    let is_set = |name| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    !cfg!(target_os = "linux") || is_set("WAYLAND_DISPLAY") || is_set("DISPLAY")
}

/// Renders the default scene, with the files that were named where they fit in.
fn picture_instead(files: &[PathBuf], reason: &str) -> Result<Outcome, CliError> {
    interrupt::listen();
    eprintln!("{reason}; rendering the default scene to {FALLBACK_FILE} in the current folder instead");
    let first =
        |fits: fn(&Path) -> bool| files.iter().find(|file| fits(file) && file.is_file()).map(|file| file.display().to_string());
    let mut arguments = RenderArguments::default();
    arguments.material = first(|path| Format::of(path).is_some());
    arguments.out = PathBuf::from(FALLBACK_FILE);
    arguments.spp = Some(FALLBACK_SPP);
    arguments.time = Some(FALLBACK_SECONDS);
    arguments.scene =
        SceneOptions { mesh: first(is_mesh_path), environment: first(is_environment_path), ..SceneOptions::default() };
    render::run_or_default(&arguments, LoadedMaterial::default())
}
