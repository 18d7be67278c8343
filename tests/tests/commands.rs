//! Every command does what it says, by its keys and by the list of commands.

use burnish::command::{COMMANDS, Command};
use burnish::dock::Pane;
use burnish::editor::{Orbit, View, ViewMode};
use burnish_material::{Property, Value};
use burnish_tests::window::{
    CTRL, Window, app, app_mut, key, press, press_keys, send, set_document, settle, step_now, window_of,
};
use egui::accesskit::Role;
use egui::{Event, Key, Modifiers, ViewportCommand, ViewportId, vec2};
use egui_kittest::kittest::Queryable;
use std::path::Path;

/// What a command may change, before it is carried out.
struct Before {
    view: View,
    model: String,
    environment: String,
    title: String,
    documents: usize,
    step: usize,
    letters: (&'static str, &'static str),
}

impl Before {
    fn of(window: &Window) -> Self {
        let editor = app(window).editor();
        Self {
            view: editor.view.clone(),
            model: editor.model.as_ref().expect("it is loaded").name.clone(),
            environment: editor.environment.as_ref().expect("it is loaded").name.clone(),
            title: editor.document.title(),
            documents: app(window).document_count(),
            step: step_now(window),
            letters: app(window).sides().letters(),
        }
    }
}

fn view_mut(window: &mut Window) -> &mut View {
    &mut app_mut(window).editor_mut().view
}

/// A window in which a command has something to do.
fn window_for(command: Command, folder: &Path) -> Window {
    let mut window = window_of(vec2(1280.0, 800.0), vec![folder.join("chosen.asm.ron")]);
    let edit = |window: &mut Window| {
        set_document(window, |material| {
            material.name = "edited".to_owned();
            material.set(Property::roughness, Value::Float(0.8));
        });
    };
    // The final view is not of interest, and one sample ends it.
    view_mut(&mut window).stop.spp = Some(1);
    match command {
        Command::Undo | Command::ResetAll | Command::Save => edit(&mut window),
        Command::Redo => {
            edit(&mut window);
            press(&mut window, Command::Undo);
        }
        Command::FlipSides | Command::CompareSides => press(&mut window, Command::StoreSide),
        Command::ShowPreview => view_mut(&mut window).mode = ViewMode::Final,
        Command::Frame => view_mut(&mut window).orbit.distance = 100.0,
        Command::ResetView => view_mut(&mut window).display.exposure_ev = 2.0,
        Command::NextBookmark => {
            press(&mut window, Command::BookmarkCamera);
            view_mut(&mut window).orbit = Orbit { azimuth_deg: 77.0, ..Orbit::default() };
        }
        Command::ShowMaterial => press(&mut window, Command::NextDebug),
        Command::NextTab | Command::PreviousTab | Command::CloseTab => {
            edit(&mut window);
            press(&mut window, Command::New);
        }
        Command::ResetLayout => press(&mut window, Command::ToggleStability),
        Command::CompareRelease => {
            let ctx = window.ctx.clone();
            app_mut(&mut window).open_library(folder, &ctx);
        }
        Command::StopRendering => press(&mut window, Command::RenderPicture),
        _ => {}
    }
    window.run_steps(2);
    window
}

/// Whether the window asked its system for something in the last frame.
fn asks(window: &Window, command: &ViewportCommand) -> bool {
    window.output().viewport_output[&ViewportId::ROOT].commands.contains(command)
}

fn is_said(window: &Window, text: &str) -> bool {
    app(window).messages().iter().any(|message| message.text.contains(text)) || app(window).messages().last_info().contains(text)
}

fn has(window: &Window, role: Role, name: &str) -> bool {
    window.query_all_by_role_and_label(role, name).next().is_some()
}

/// What the toolbar says is shown.
fn shown(window: &Window) -> String {
    window.get_by_role_and_label(Role::ComboBox, "Debug view").value().unwrap_or_default()
}

fn is_explaining(window: &Window) -> bool {
    use egui::accesskit::Toggled;
    use egui_kittest::kittest::NodeT;
    window.get_by_role_and_label(Role::Button, "Explain").accesskit_node().toggled() == Some(Toggled::True)
}

/// Whether what a command says has come about.
fn has_happened(window: &Window, command: Command, before: &Before, folder: &Path) -> bool {
    let (app, now) = (app(window), Before::of(window));
    let (view, old) = (&now.view, &before.view);
    let is_drawn = |pane: Pane, at_first: bool| app.dock().is_drawn(pane) != at_first;
    match command {
        Command::New => now.documents == before.documents + 1,
        Command::Open | Command::LoadModel | Command::LoadEnvironment | Command::LoadTextureSet | Command::LoadReference => {
            is_said(window, "chosen")
        }
        Command::OpenLibrary => is_said(window, "Library ") && app.library().is_some(),
        Command::CompareRelease => app.dock().is_drawn(Pane::Validation),
        Command::NewFromMeasured => has(window, Role::TextInput, "Search measured materials"),
        Command::OpenRecent => has(window, Role::TextInput, "Open recent"),
        Command::Save | Command::SaveAs => is_said(window, "saved, reread") && folder.join("chosen.asm.ron").exists(),
        Command::CloseTab => now.documents + 1 == before.documents,
        Command::RenderPicture => is_drawn(Pane::Export, false) && (is_said(window, "Wrote ") || app.is_exporting()),
        Command::RenderTurntable => is_drawn(Pane::Export, false) && app.export_panel().folder.is_some(),
        Command::StopRendering => app.export_work().is_none_or(|work| work.text.starts_with("Ending")),
        Command::SavePng | Command::SaveExr => is_said(window, "The picture was not written"),
        // There is no library here; `library_panel.rs` has one.
        Command::ContactSheet | Command::ExportPack => app.library().is_none(),
        Command::ExportMaterial => has(window, Role::Button, "Export…"),
        Command::Preferences => has(window, Role::SpinButton, "Size of text, percent"),
        Command::Quit => asks(window, &ViewportCommand::Close),
        Command::Undo => now.step + 1 == before.step,
        Command::Redo => now.step == before.step + 1,
        Command::ResetAll => app.history().undo_label() == Some("Reset all properties"),
        Command::StoreSide => app.sides().stored().is_some(),
        Command::FlipSides => now.letters != before.letters,
        // Without a GPU there is no preview to compare with, and these are not possible.
        Command::ToggleFinal | Command::ShowBoth | Command::ShowWipe | Command::ShowDifference => view.mode == old.mode,
        Command::ShowPreview => view.mode == ViewMode::Preview,
        Command::ShowFinal => view.mode == ViewMode::Final,
        Command::CompareSides => view.compares_sides && view.mode == ViewMode::Both,
        Command::Frame => view.orbit.distance < 100.0,
        Command::ResetView => view.display.exposure_ev == 0.0,
        Command::BookmarkCamera => view.bookmarks == [old.orbit],
        Command::NextBookmark => view.orbit == old.bookmarks[0],
        Command::NextMesh | Command::PreviousMesh => now.model != before.model,
        Command::NextBackdrop => app.editor().backdrop().is_some(),
        Command::NextEnvironment => now.environment != before.environment,
        Command::ExposureUp => view.display.exposure_ev > old.display.exposure_ev,
        Command::ExposureDown => view.display.exposure_ev < old.display.exposure_ev,
        Command::ToggleDenoise => view.is_denoise_on != old.is_denoise_on,
        Command::ToggleBloom => view.is_bloom_on != old.is_bloom_on,
        Command::NextDebug => shown(window) != "Material",
        Command::ShowMaterial => shown(window) == "Material",
        Command::ExplainPixel => is_explaining(window),
        Command::TogglePanels => !view.are_panels_shown,
        Command::Fullscreen => asks(window, &ViewportCommand::Fullscreen(true)),
        Command::NextTab | Command::PreviousTab => now.title != before.title,
        Command::ToggleLibrary => is_drawn(Pane::Library, true),
        Command::ToggleFolder => is_drawn(Pane::Folder, false),
        Command::ToggleProperties => is_drawn(Pane::Properties, true),
        Command::ToggleLobes => is_drawn(Pane::Lobes, true),
        Command::ToggleChart => is_drawn(Pane::Chart, true),
        Command::ToggleStability => is_drawn(Pane::Stability, false),
        Command::ToggleValidation => is_drawn(Pane::Validation, false),
        Command::ToggleDiff => is_drawn(Pane::Diff, false),
        Command::ToggleMerge => is_drawn(Pane::Merge, false),
        Command::ToggleHistory => is_drawn(Pane::History, false),
        Command::ToggleMessages => is_drawn(Pane::Messages, false),
        Command::ToggleExport => is_drawn(Pane::Export, false),
        Command::ResetLayout => !app.dock().is_drawn(Pane::Stability) && app.dock().is_drawn(Pane::Lobes),
        Command::Palette => has(window, Role::TextInput, "Find a command"),
        Command::Help => has(window, Role::Label, "Mouse in the picture"),
    }
}

/// Whether it needs what this window has not.
fn is_possible(command: Command) -> bool {
    !matches!(
        command,
        Command::ToggleFinal
            | Command::ShowBoth
            | Command::ShowWipe
            | Command::ShowDifference
            | Command::ContactSheet
            | Command::ExportPack
    )
}

/// Carries a command out in a window made for it, and sees what comes of it.
fn check(command: Command, how: &str, carry_out: impl FnOnce(&mut Window)) {
    let folder = tempfile::tempdir().expect("a folder");
    let mut window = window_for(command, folder.path());
    let before = Before::of(&window);
    assert!(
        !is_possible(command) || !has_happened(&window, command, &before, folder.path()),
        "{command:?} has happened before {how}"
    );
    carry_out(&mut window);
    // What is asked of the system is seen in the very frame only.
    if has_happened(&window, command, &before, folder.path()) {
        return;
    }
    settle(&mut window);
    assert!(has_happened(&window, command, &before, folder.path()), "{command:?} by {how}: nothing came of it");
}

#[test]
fn keys_carry_out_commands() {
    for def in COMMANDS.iter().filter(|def| !def.keys.is_empty()) {
        check(def.command, "its key", |window| press_keys(window, def.command));
    }
}

#[test]
fn commands_without_keys_are_in_the_list() {
    for def in COMMANDS.iter().filter(|def| def.keys.is_empty()) {
        check(def.command, "the list", |window| {
            press(window, Command::Palette);
            send(window, [Event::Text(def.text.to_owned())]);
            window.step();
            key(window, Modifiers::NONE, Key::Enter);
        });
    }
}

#[test]
fn further_keys_do_the_same() {
    for def in COMMANDS {
        for keys in def.keys.iter().skip(1) {
            check(def.command, "a further key", |window| {
                let modifiers = Modifiers { ctrl: keys.modifiers.command, ..keys.modifiers };
                key(window, modifiers, keys.logical_key);
            });
        }
    }
}

#[test]
fn keys_that_type_are_left_to_a_text_that_is_being_typed() {
    let mut window = window_of(vec2(1280.0, 800.0), Vec::new());
    window.get_by_role_and_label(Role::TextInput, "Search properties").focus();
    window.run_steps(2);
    for def in COMMANDS {
        for keys in def.keys.iter().filter(|keys| keys.modifiers == Modifiers::NONE && !keys.logical_key.name().starts_with('F'))
        {
            let (view, dock) = (app(&window).editor().view.clone(), app(&window).dock().to_text());
            key(&mut window, Modifiers::NONE, keys.logical_key);
            let now = &app(&window).editor().view;
            assert_eq!(format!("{view:?}"), format!("{now:?}"), "{:?}", def.command);
            assert_eq!(dock, app(&window).dock().to_text(), "{:?}", def.command);
            assert!(app(&window).sides().stored().is_none() && app(&window).document_count() == 1, "{:?}", def.command);
        }
    }
    // Keys with Ctrl that no text field has a meaning for hold everywhere.
    key(&mut window, CTRL, Key::K);
    window.step();
    assert!(has(&window, Role::TextInput, "Find a command"));
}
