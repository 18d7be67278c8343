//! No control without a name, in every state of the window: what a screen reader, and a test, can go by.

use burnish::command::{Command, Menu};
use burnish::editor::ViewMode;
use burnish_material::{PROPERTIES, Property, TextureRef, Value, Vary};
use burnish_tests::window::{HIGH, Window, app, app_mut, click, key, press, rect, set_document, settle, window, window_of};
use egui::accesskit::Role;
use egui::{Event, Key, Modifiers};
use egui_kittest::kittest::{NodeT, Queryable};
use std::collections::BTreeSet;

/// Whether something of this role can be operated.
fn is_operable(role: Role) -> bool {
    matches!(
        role,
        Role::Button
            | Role::CheckBox
            | Role::ColorWell
            | Role::ComboBox
            | Role::Link
            | Role::MenuItem
            | Role::MultilineTextInput
            | Role::RadioButton
            | Role::Slider
            | Role::SpinButton
            | Role::Switch
            | Role::Tab
            | Role::TextInput
    )
}

/// Holds every control of the window to having a name, sliders and fields to names of their own and numbers.
fn check(window: &Window, state: &str) {
    let (mut seen, mut count) = (BTreeSet::new(), 0);
    for node in window.root().children_recursive() {
        let at = node.accesskit_node();
        let (role, name) = (at.role(), at.label().unwrap_or_default());
        if !is_operable(role) || at.is_hidden() {
            continue;
        }
        count += 1;
        assert!(!name.trim().is_empty(), "{state}: a {role:?} without a name at {}, value {:?}", node.rect(), at.value());
        if matches!(role, Role::Slider | Role::SpinButton) {
            assert!(at.numeric_value().is_some_and(f64::is_finite), "{state}: {role:?} {name} has no number");
            assert!(seen.insert((format!("{role:?}"), name.clone())), "{state}: two are called {role:?} {name}");
        }
    }
    assert!(count > 40, "{state}: {count} controls are not the whole window");
}

#[test]
fn panels_and_menus() {
    let mut window = window();
    check(&window, "at first");
    for (_, title) in Menu::ALL {
        let at = window.query_all_by_role_and_label(Role::Button, title).next().expect("the menu bar").rect().center();
        click(&mut window, at);
        window.run_steps(2);
        check(&window, title);
        key(&mut window, Modifiers::NONE, Key::Escape);
        window.run_steps(2);
    }
    for (_, title) in [("View", "Final view stops at"), ("View", "Camera bookmarks")] {
        press(&mut window, Command::BookmarkCamera);
        let at = window.query_all_by_role_and_label(Role::Button, "View").next().expect("the menu bar").rect().center();
        click(&mut window, at);
        window.run_steps(2);
        let at = window.get_by_label_contains(title).rect().center();
        click(&mut window, at);
        window.run_steps(3);
        check(&window, title);
        key(&mut window, Modifiers::NONE, Key::Escape);
        key(&mut window, Modifiers::NONE, Key::Escape);
    }
    for command in
        [Command::ToggleHistory, Command::ToggleStability, Command::TogglePanels, Command::TogglePanels, Command::ToggleExport]
    {
        set_document(&mut window, |material| _ = material.set(Property::roughness, Value::Float(0.123)));
        press(&mut window, command);
        window.run_steps(2);
        if app(&window).editor().view.are_panels_shown {
            check(&window, command.text());
        }
    }
    for command in [Command::ToggleValidation, Command::ToggleDiff, Command::ToggleMerge] {
        press(&mut window, command);
        window.run_steps(3);
        check(&window, command.text());
        press(&mut window, command);
    }
    let at = rect(&window, Role::Button, "Turntable").center();
    click(&mut window, at);
    window.run_steps(2);
    check(&window, "a turntable");
    app_mut(&mut window).carry_out(Command::ToggleMessages, &egui::Context::default());
    press(&mut window, Command::New);
    set_document(&mut window, |material| _ = material.set(Property::roughness, Value::Float(0.123)));
    check(&window, "messages, two tabs");
    press(&mut window, Command::CloseTab);
    window.run_steps(2);
    check(&window, "the question about unsaved changes");
}

#[test]
fn pages() {
    let mut window = window();
    for command in [Command::Palette, Command::OpenRecent, Command::Preferences, Command::Help] {
        press(&mut window, command);
        window.run_steps(2);
        check(&window, command.text());
        key(&mut window, Modifiers::NONE, Key::Escape);
        window.run_steps(2);
    }
    let at = rect(&window, Role::SpinButton, "Roughness").center();
    window.input_mut().events.push(Event::PointerMoved(at));
    press(&mut window, Command::Help);
    window.run_steps(2);
    check(&window, "a reference");
}

#[test]
fn the_panes_of_a_library() {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, color) in [("a", "(1.4, 0.2, 0.1)"), ("b", "(1.4, 0.2, 0.1)"), ("c", "(0.4, 0.2, 0.1)")] {
        let text = format!("{{ \"asm\": \"4.0\", \"name\": \"{name}\", \"properties\": {{ \"base_color\": {color} }} }}");
        std::fs::write(folder.path().join(format!("{name}.asm.ron")), text).expect("it can be written");
    }
    let mut window = window();
    let ctx = window.ctx.clone();
    app_mut(&mut window).open_library(folder.path(), &ctx);
    press(&mut window, Command::ToggleValidation);
    let start = std::time::Instant::now();
    while app(&window).checked().is_none_or(|checked| checked.pairs.is_empty()) {
        assert!(start.elapsed().as_secs() < 60, "not checked");
        std::thread::sleep(std::time::Duration::from_millis(10));
        window.run_steps(1);
    }
    window.run_steps(3);
    check(&window, "findings");
    for name in ["How to check", "Report of the check"] {
        check_opened(&mut window, Role::Button, name);
    }
    let at = rect(&window, Role::Button, "Side by side a and b").center();
    click(&mut window, at);
    window.run_steps(10);
    check(&window, "differences");
    check_opened(&mut window, Role::ComboBox, "Material A");
    app_mut(&mut window).carry_out(Command::CompareRelease, &ctx);
    window.run_steps(3);
    check(&window, "a release");
}

/// Opens what a control opens, checks, and closes it.
fn check_opened(window: &mut Window, role: Role, name: &str) {
    let at = rect(window, role, name).center();
    click(window, at);
    window.run_steps(4);
    check(window, name);
    key(window, Modifiers::NONE, Key::Escape);
    window.run_steps(2);
}

#[test]
fn pickers_maps_and_combos() {
    let mut window = window();
    for def in PROPERTIES.iter().filter(|def| matches!(def.default, Value::Color(_))) {
        check_opened(&mut window, Role::ColorWell, def.label);
    }
    for name in ["Mesh", "Environment", "Display transform", "Debug view"] {
        check_opened(&mut window, Role::ComboBox, name);
    }
    // A map on every property that can have one makes the panel higher.
    let mut window = window_of(egui::vec2(HIGH.x, 4000.0), Vec::new());
    set_document(&mut window, |material| {
        for def in PROPERTIES.iter().filter(|def| def.vary != Vary::Uniform) {
            material.slot_mut(def.id).texture = Some(TextureRef::new("missing.png"));
        }
    });
    settle(&mut window);
    check(&window, "maps everywhere");
    for def in PROPERTIES.iter().filter(|def| def.vary != Vary::Uniform) {
        check_opened(&mut window, Role::Button, &format!("{} map settings", def.label));
    }
}

#[test]
fn views_that_compare() {
    let mut window = window();
    press(&mut window, Command::StoreSide);
    for mode in [ViewMode::Both, ViewMode::Wipe, ViewMode::Difference, ViewMode::Final] {
        let view = &mut app_mut(&mut window).editor_mut().view;
        (view.mode, view.stop.spp) = (mode, Some(1));
        window.run_steps(4);
        check(&window, &format!("{mode:?}"));
    }
}
