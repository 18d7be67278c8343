//! The pages over the window: finding things, preferences that hold at once, keys of one's own, references.

use burnish::command::Command;
use burnish::dock::{Dock, Pane};
use burnish::layout_file::save_layout;
use burnish::places::Places;
use burnish::preferences::MouseScheme;
use burnish::theme::{self, ThemeName};
use burnish_material::{MaterialFile, PROPERTIES, Property, Value};
use burnish_tests::window::{
    CTRL, HIGH, Window, app, app_mut, click, drag, gesture, key, material, press, rect, release, send, set_document, settle,
    slot, text, window, window_of, window_with,
};
use egui::accesskit::Role;
use egui::{Event, Key, Modifiers, vec2};
use egui_kittest::kittest::Queryable;

fn has(window: &Window, role: Role, name: &str) -> bool {
    window.query_all_by_role_and_label(role, name).next().is_some()
}

fn find_by_typing(window: &mut Window, typed: &str) {
    press(window, Command::Palette);
    assert!(has(window, Role::TextInput, "Find a command"));
    send(window, [Event::Text(typed.to_owned())]);
    window.step();
    key(window, Modifiers::NONE, Key::Enter);
    window.run_steps(3);
    assert!(!has(window, Role::TextInput, "Find a command"), "it closes");
}

#[test]
fn the_list_finds_commands_properties_and_presets() {
    let mut window = window_of(vec2(1280.0, 700.0), Vec::new());
    let preset = &burnish_presets::presets()[0];
    find_by_typing(&mut window, preset.name);
    assert_eq!(material(&window), *preset.parse().expect("it is built in").0.material());
    // A property far down comes into sight, even where its panel was hidden.
    app_mut(&mut window).carry_out(Command::ToggleProperties, &egui::Context::default());
    window.run_steps(2);
    find_by_typing(&mut window, "volumeThicknessScale");
    let row = rect(&window, Role::Slider, "Volume thickness scale");
    assert!(row.top() > 0.0 && row.bottom() < 700.0, "{row}");
    // Arrows walk, Esc closes, and what is typed is forgotten.
    press(&mut window, Command::Palette);
    for event in [Key::ArrowDown, Key::ArrowDown, Key::ArrowUp, Key::Escape] {
        key(&mut window, Modifiers::NONE, event);
    }
    window.run_steps(2);
    assert!(!has(&window, Role::TextInput, "Find a command"));
    assert_eq!(app(&window).document_count(), 1, "no command was carried out");
}

#[test]
fn letters_that_come_with_the_shortcut_are_for_the_list() {
    let mut window = window_of(vec2(1280.0, 700.0), Vec::new());
    let pressed = |key, modifiers| Event::Key { key, physical_key: None, pressed: true, repeat: false, modifiers };
    let letter = |key: Key, text: &str| [pressed(key, Modifiers::NONE), Event::Text(text.to_owned())];
    let mut events = vec![pressed(Key::K, CTRL)];
    // Alone, A stores a side and L hides the lobes.
    events.extend(letter(Key::A, "a").into_iter().chain(letter(Key::L, "l")));
    window.input_mut().events.extend(events);
    window.step();
    window.run_steps(2);
    assert!(app(&window).sides().stored().is_none() && app(&window).dock().is_drawn(Pane::Lobes), "they carried out commands");
    send(&mut window, [Event::Text("bedo".to_owned())]);
    window.run_steps(2);
    let typed = window.get_by_role_and_label(Role::TextInput, "Find a command").value();
    assert_eq!(typed.as_deref(), Some("albedo"));
}

#[test]
fn f1_explains_what_is_under_the_pointer() {
    let mut window = window();
    for def in PROPERTIES {
        let reset = vec2(-60.0, 0.0);
        let role = match def.default {
            Value::Float(_) => Role::Slider,
            Value::Bool(_) => Role::CheckBox,
            Value::Color(_) => Role::ColorWell,
            Value::Normal(_) => Role::SpinButton,
        };
        let name = if role == Role::SpinButton { format!("{} x", def.label) } else { def.label.to_owned() };
        let at = rect(&window, role, &name).left_center() + reset;
        send(&mut window, [Event::PointerMoved(at)]);
        press(&mut window, Command::Help);
        window.step();
        assert!(window.query_all_by_label(&format!("{}: reference", def.label)).next().is_some(), "{}", def.name);
        assert!(window.query_all_by_label(def.doc).next().is_some(), "{}", def.name);
        key(&mut window, Modifiers::NONE, Key::Escape);
        window.step();
        assert!(window.query_all_by_label(&format!("{}: reference", def.label)).next().is_none(), "{}", def.name);
    }
    send(&mut window, [Event::PointerMoved(egui::pos2(640.0, 10.0))]);
    press(&mut window, Command::Help);
    window.step();
    assert!(has(&window, Role::Label, "Mouse in the picture"));
}

/// Chooses one of a list.
fn choose(window: &mut Window, name: &str, choice: &str) {
    let at = rect(window, Role::ComboBox, name).center();
    click(window, at);
    window.run_steps(3);
    let at = window.query_all_by_role_and_label(Role::Button, choice).last().expect("a choice").rect().center();
    click(window, at);
    window.run_steps(3);
}

fn type_number(window: &mut Window, name: &str, typed: &str) {
    let at = rect(window, Role::SpinButton, name).center();
    click(window, at);
    window.step();
    key(window, CTRL, Key::A);
    send(window, [Event::Text(typed.to_owned())]);
    key(window, Modifiers::NONE, Key::Enter);
    window.run_steps(3);
}

#[test]
fn preferences_hold_at_once_and_leave_the_document_alone() {
    let mut window = window_of(vec2(1280.0, 1000.0), Vec::new());
    let before = text(&window);
    press(&mut window, Command::Preferences);
    window.run_steps(2);
    for (choice, name) in [("Light", ThemeName::Light), ("Middle grey", ThemeName::Grey), ("Dark", ThemeName::Dark)] {
        choose(&mut window, "Theme", choice);
        assert_eq!(app(&window).preferences().theme, name);
        assert_eq!(*theme::now(), *name.palette());
        assert_eq!(window.ctx.global_style().visuals.panel_fill, name.palette().panel, "{choice}");
    }
    let size = |window: &Window| egui::TextStyle::Body.resolve(&window.ctx.global_style()).size;
    let old = size(&window);
    type_number(&mut window, "Size of text, percent", "125");
    assert!((size(&window) / old - 1.25).abs() < 0.01, "{old} {}", size(&window));
    type_number(&mut window, "Size of text, percent", "100");
    type_number(&mut window, "Unit of lengths, mm", "10");
    choose(&mut window, "Mouse scheme", "Blender");
    assert_eq!(app(&window).preferences().mouse, MouseScheme::Blender);
    key(&mut window, Modifiers::NONE, Key::Escape);
    window.run_steps(2);
    assert!(!has(&window, Role::ComboBox, "Mouse scheme"), "Esc closes it");
    assert_eq!(text(&window), before);
    assert_eq!(app(&window).history().labels().count(), 1, "preferences are no step");

    // The left button does nothing in the picture any more.
    let at = rect(&window, Role::Image, "Viewport").center() + vec2(0.0, 150.0);
    let orbit = app(&window).editor().view.orbit;
    drag(&mut window, at, vec2(60.0, 0.0), Modifiers::NONE);
    release(&mut window);
    assert_eq!(app(&window).editor().view.orbit, orbit);
    press(&mut window, Command::Preferences);
    window.run_steps(2);
    choose(&mut window, "Mouse scheme", "Designer");
    key(&mut window, Modifiers::NONE, Key::Escape);
    window.run_steps(2);
    drag(&mut window, at, vec2(60.0, 0.0), Modifiers::NONE);
    release(&mut window);
    assert_ne!(app(&window).editor().view.orbit, orbit);
    // New materials are in the unit that was chosen.
    press(&mut window, Command::New);
    assert_eq!(material(&window).unit_mm, Some(10.0));
}

#[test]
fn keys_of_ones_own_take_the_place_of_the_usual_ones() {
    let mut window = window_of(vec2(1280.0, 2000.0), Vec::new());
    press(&mut window, Command::Preferences);
    window.run_steps(2);
    let name = "Keys of Store as side A";
    window.get_by_role_and_label(Role::Button, name).scroll_to_me();
    window.run_steps(4);
    let record = |window: &mut Window, modifiers, pressed| {
        let at = rect(window, Role::Button, name).center();
        click(window, at);
        window.run_steps(2);
        key(window, modifiers, pressed);
        window.run_steps(2);
    };
    // Esc ends choosing without a change, and does not close the page.
    record(&mut window, Modifiers::NONE, Key::Escape);
    assert!(has(&window, Role::Button, name));
    assert!(!app(&window).keymap().is_chosen(Command::StoreSide));
    // A key that another command has is taken from it, and is not carried out while it is chosen.
    record(&mut window, CTRL, Key::N);
    assert_eq!(app(&window).document_count(), 1);
    assert!(app(&window).keymap().keys(Command::New).is_empty());
    key(&mut window, Modifiers::NONE, Key::Escape);
    window.run_steps(2);

    key(&mut window, Modifiers::NONE, Key::A);
    assert!(app(&window).sides().stored().is_none(), "the old key");
    key(&mut window, CTRL, Key::N);
    assert!(app(&window).sides().stored().is_some(), "the new key");
    assert_eq!(app(&window).document_count(), 1);
    // The usual keys again.
    press(&mut window, Command::Preferences);
    window.run_steps(2);
    window.get_by_role_and_label(Role::Button, "Reset keys of Store as side A").click_accesskit();
    window.run_steps(2);
    window.get_by_role_and_label(Role::Button, "Reset keys of New").click_accesskit();
    window.run_steps(2);
    key(&mut window, Modifiers::NONE, Key::Escape);
    window.run_steps(2);
    press(&mut window, Command::New);
    assert_eq!(app(&window).document_count(), 2);
}

#[test]
fn files_that_were_open_are_found_again() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut window = window_of(vec2(1280.0, 800.0), Vec::new());
    let ctx = window.ctx.clone();
    for name in ["red-lacquer", "blue-glass"] {
        let path = folder.path().join(format!("{name}.asm.ron"));
        let mut material = burnish_material::Material::named(name);
        material.set(Property::roughness, Value::Float(0.7));
        std::fs::write(&path, MaterialFile::new(&material).text()).expect("it can be written");
        app_mut(&mut window).load_path(&path, &ctx);
        settle(&mut window);
    }
    // Closed, and found by a part of its name.
    press(&mut window, Command::CloseTab);
    assert_eq!(material(&window).name, "red-lacquer");
    press(&mut window, Command::OpenRecent);
    send(&mut window, [Event::Text("glass".to_owned())]);
    window.step();
    key(&mut window, Modifiers::NONE, Key::Enter);
    settle(&mut window);
    assert_eq!(material(&window).name, "blue-glass");
    assert_eq!(app(&window).document_count(), 2);
    // What is changed in one document stays out of the other.
    set_document(&mut window, |material| _ = material.set(Property::coat, Value::Float(0.5)));
    press(&mut window, Command::NextTab);
    assert_eq!((material(&window).name.as_str(), slot(&window, Property::coat).value), ("red-lacquer", None));
    press(&mut window, Command::Undo);
    press(&mut window, Command::PreviousTab);
    assert_eq!(slot(&window, Property::coat).value, Some(Value::Float(0.5)), "undo belongs to a document");
}

#[test]
fn edits_are_steps_also_where_the_view_is_behind_another_tab() {
    let mut dock = Dock::default();
    let [view, lobes] = [Pane::View, Pane::Lobes].map(|pane| dock.tree.tiles.find_pane(&pane).expect("every pane is there"));
    let tabs = dock.tree.tiles.parent_of(lobes).expect("it has tabs");
    dock.tree.move_tile_to_container(view, tabs, 0, false);
    dock.tree.make_active(|tile, _| tile == lobes);
    let folder = tempfile::tempdir().expect("a folder");
    save_layout(folder.path(), &dock.to_text().expect("a layout")).expect("it can be written");
    let places = Places { state: Some(folder.path().to_owned()), ..Places::default() };
    let mut window = window_with(HIGH, Vec::new(), move |app, ctx| app.keep_in(places.clone(), ctx));
    assert!(!app(&window).dock().is_drawn(Pane::View) && app(&window).dock().is_drawn(Pane::Lobes));
    gesture(&mut window, Property::roughness.def(), "a text", |window| type_number(window, "Roughness", "0.7"));
}

#[test]
fn a_property_reads_a_built_in_texture_that_keeps_its_value() {
    let mut window = window_of(vec2(1280.0, 900.0), Vec::new());
    set_document(&mut window, |material| {
        material.set(Property::base_color, Value::Color([0.25, 0.5, 0.75]));
    });
    let press_button = |window: &mut Window, name: &str| {
        let at =
            window.query_all_by_role_and_label(Role::Button, name).last().unwrap_or_else(|| panic!("{name}")).rect().center();
        click(window, at);
        window.run_steps(3);
    };
    for (property, texture, path) in [
        (Property::base_color, "wood-oak", "builtin:wood-oak/base_color?mean=0.25,0.5,0.75"),
        (Property::metallic, "rust", "builtin:rust/metallic"),
    ] {
        press_button(&mut window, &format!("{} map", property.def().label));
        press_button(&mut window, "Choose a built-in texture…");
        press_button(&mut window, texture);
        press_button(&mut window, &format!("Use {texture}"));
        settle(&mut window);
        let read = slot(&window, property).texture.expect("it reads a texture").path;
        assert_eq!(read, path);
        assert!(app(&window).editor().document.textures.contains_key(path), "{path} is not made");
        // The page stays for another choice, until it is closed.
        assert!(has(&window, Role::Button, &format!("Use {texture}")));
        key(&mut window, Modifiers::NONE, Key::Escape);
        window.run_steps(2);
        assert!(!has(&window, Role::Button, &format!("Use {texture}")));
        let (name, map) = path["builtin:".len()..].split_once('/').expect("a map");
        let map = map.split('?').next().unwrap_or_default().replace('_', " ");
        assert!(window.query_all_by_label(&format!("{name} · {map}")).next().is_some(), "the row does not say {name} · {map}");
        press(&mut window, Command::Undo);
        window.step();
        assert_eq!(slot(&window, property).texture, None);
    }
}
