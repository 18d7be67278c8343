//! The window with the Export panel in front, and waiting for what it makes.

use crate::window::{Window, app, app_mut, click, rect, window_with};
use burnish::app::App;
use burnish::dock::Pane;
use burnish::panels::messages::{Message, Severity};
use burnish_renderer::path::StopRules;
use egui::accesskit::Role;
use egui::vec2;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Longest wait for anything that happens in the background.
pub const PATIENCE: Duration = Duration::from_secs(60);
/// So few pixels that a sample of all takes no time.
pub const SIZE: [usize; 2] = [24, 20];

/// A window with the panel in front, whose dialogs answer with these paths in turn.
pub fn window(paths: Vec<PathBuf>) -> Window {
    let mut window = window_with(vec2(1280.0, 1000.0), paths, |app, _| app);
    app_mut(&mut window).dock_mut().set_shown(Pane::Export, true);
    window.run_steps(3);
    let panel = app_mut(&mut window).export_panel_mut();
    panel.size = Some(SIZE);
    panel.stop = StopRules { spp: Some(8), seconds: None, relmse: None };
    panel.frame_stop = panel.stop;
    window.run_steps(2);
    window
}

/// Draws until something holds.
pub fn until(window: &mut Window, what: &str, holds: impl Fn(&App) -> bool) {
    let start = Instant::now();
    while !holds(app(window)) {
        assert!(start.elapsed() < PATIENCE, "waited in vain for {what}; said: {:?}", app(window).messages());
        std::thread::sleep(Duration::from_millis(5));
        window.run_steps(1);
    }
    window.run_steps(2);
}

/// Draws until nothing is being made, and nothing waits.
pub fn until_done(window: &mut Window) {
    window.run_steps(2);
    until(window, "the rendering to end", |app| !app.is_exporting());
}

/// A click on the button of this name.
pub fn press_button(window: &mut Window, name: &str) {
    let at = rect(window, Role::Button, name).center();
    click(window, at);
    window.run_steps(2);
}

/// Names of what is in a folder, in their order.
pub fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).expect("it is there");
    let mut names: Vec<String> = entries.flatten().map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

/// Errors that the user was told.
pub fn errors(window: &Window) -> Vec<&str> {
    let of = |severity| move |message: &&Message| message.severity == severity;
    app(window).messages().iter().filter(of(Severity::Error)).map(|message| message.text.as_str()).collect()
}
