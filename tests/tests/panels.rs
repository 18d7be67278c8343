//! The window without a GPU and without a display: one case per property made from the table, and the straight line from a
//! widget to the document, the history and the file.

use burnish::command::Command;
use burnish::panels::properties::without_effect;
use burnish_material::{
    Kind, LimitKind, Lobe, LobeSet, Material, MaterialFile, PROPERTIES, Property, PropertyDef, Slot, TextureRef, Value, Vary,
};
use burnish_tests::window::{HIGH, Window, app, app_mut, find, material, press, set_document, settle, window, window_of};
use egui::accesskit::Role;
use egui_kittest::kittest::Queryable;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

fn window_with(paths: Vec<PathBuf>) -> Window {
    window_of(HIGH, paths)
}

/// Role and accessible name of the control that changes a property.
fn control(def: &PropertyDef) -> (Role, String) {
    match def.default.kind() {
        Kind::Float => (Role::Slider, def.label.to_owned()),
        Kind::Bool => (Role::CheckBox, def.label.to_owned()),
        Kind::Color => (Role::SpinButton, format!("{} green", def.label)),
        Kind::Normal => (Role::SpinButton, format!("{} y", def.label)),
    }
}

/// A number inside the limits that differs from the default.
fn other_number(def: &PropertyDef) -> f64 {
    let default = def.default.numbers().get(1).or(def.default.numbers().first()).copied().unwrap_or(0.0);
    let low = def.limits.min.unwrap_or(0.0);
    let x = low + 0.25 * (def.limits.slider_max - low);
    if (x - default).abs() < 1e-3 { low + 0.5 * (def.limits.slider_max - low) } else { x }
}

#[test]
fn every_property_has_named_controls() {
    let window = window();
    for def in PROPERTIES {
        let (role, name) = control(def);
        find(&window, role, &name);
        match def.default.kind() {
            Kind::Float => drop(find(&window, Role::SpinButton, def.label)),
            Kind::Color => drop(find(&window, Role::ColorWell, def.label)),
            Kind::Bool | Kind::Normal => {}
        }
        let has_map = window.query_by_role_and_label(Role::Button, &format!("{} map", def.label)).is_some();
        assert_eq!(has_map, def.vary != Vary::Uniform, "{}", def.name);
    }
}

#[test]
fn changing_a_control_changes_the_document_and_undo_restores_it() {
    let mut window = window();
    for def in PROPERTIES {
        let before = material(&window);
        let (role, name) = control(def);
        let wanted = other_number(def);
        let node = find(&window, role, &name);
        if def.default.kind() == Kind::Bool {
            node.click();
        } else {
            node.set_value_accesskit(wanted);
        }
        window.run_steps(2);
        let after = material(&window);
        let expected = match def.default {
            Value::Float(_) => Value::Float(wanted),
            Value::Bool(v) => Value::Bool(!v),
            Value::Color(v) => Value::Color([v[0], wanted, v[2]]),
            Value::Normal(v) => Value::Normal([v[0], wanted, v[2]]),
        };
        assert_eq!(after.slot(def.id).value, Some(expected), "{}", def.name);
        for other in PROPERTIES.iter().filter(|other| other.id != def.id) {
            assert_eq!(after.slot(other.id), before.slot(other.id), "{} changed {}", def.name, other.name);
        }
        let label = app(&window).history().undo_label().unwrap_or_default().to_owned();
        assert!(label.contains(def.label), "{}: {label}", def.name);

        press(&mut window, Command::Undo);
        assert_eq!(material(&window), before, "{}: undo", def.name);
        assert!(!app(&window).editor().document.is_modified(), "{}: unsaved mark after undo", def.name);
        press(&mut window, Command::Redo);
        assert_eq!(material(&window), after, "{}: redo", def.name);
        press(&mut window, Command::Undo);
    }
}

#[test]
fn reset_makes_every_property_absent_again() {
    let mut window = window();
    set_document(&mut window, |material| {
        for def in PROPERTIES {
            material.set(def.id, def.default);
        }
    });
    for def in PROPERTIES {
        assert_ne!(*material(&window).slot(def.id), Slot::default());
        window.get_by_label(&format!("Reset {}", def.label)).click();
        window.run_steps(3);
        assert_eq!(*material(&window).slot(def.id), Slot::default(), "{}", def.name);
    }
}

/// Values that a careless widget would clamp or round: outside hard ranges, with digits no field shows.
fn odd_material() -> Material {
    let mut material = Material::named("odd");
    for def in PROPERTIES {
        let odd = |x: f64| -0.123_456_789_012_345 - 3.0 * x;
        let value = match def.default {
            Value::Float(v) => Value::Float(if def.limits.kind == LimitKind::Typical { 7.0 / 3.0 } else { odd(v) }),
            Value::Color(v) => Value::Color([odd(v[0]), 1.000_000_1, 1.0 / 3.0]),
            Value::Normal(_) => Value::Normal([0.1 / 3.0, -2.0, 0.0]),
            Value::Bool(v) => Value::Bool(!v),
        };
        material.set(def.id, value);
        if def.vary != Vary::Uniform {
            material.slot_mut(def.id).texture = Some(TextureRef { uv_rotation: 1.0 / 3.0, ..TextureRef::new("missing/map.png") });
        }
    }
    material
}

#[test]
fn showing_changes_nothing() {
    let mut window = window();
    let odd = odd_material();
    set_document(&mut window, |material| *material = odd.clone());
    window.run_steps(5);
    assert_eq!(material(&window), odd);

    // Neither does the pointer passing over, nor the keyboard passing through each field.
    for def in PROPERTIES {
        let (role, name) = control(def);
        find(&window, role, &name).hover();
        window.run_steps(1);
    }
    assert_eq!(material(&window), odd);
    for def in PROPERTIES.iter().filter(|def| def.default.kind() != Kind::Bool) {
        let name = if def.default.kind() == Kind::Float { def.label.to_owned() } else { control(def).1 };
        find(&window, Role::SpinButton, &name).focus();
        window.run_steps(2);
        window.key_press(egui::Key::Enter);
        window.run_steps(1);
        assert_eq!(*material(&window).slot(def.id), *odd.slot(def.id));
    }
    assert_eq!(material(&window), odd);
}

#[test]
fn an_open_color_picker_changes_nothing() {
    let mut window = window();
    set_document(&mut window, |material| {
        material.set(Property::base_color, Value::Color([0.773_3, 1.0 / 3.0, 0.0]));
        material.set(Property::emission_color, Value::Color([4.0 / 3.0, 2.0, 0.1]));
    });
    let before = material(&window);
    for property in [Property::base_color, Property::emission_color] {
        find(&window, Role::ColorWell, property.def().label).click();
        window.run_steps(8);
        assert!(window.query_by_label(&format!("{} hex", property.def().label)).is_some(), "the picker is open");
        assert_eq!(material(&window), before);
        window.key_press(egui::Key::Escape);
        window.run_steps(3);
    }
}

fn type_into(window: &mut Window, name: &str, text: &str) {
    find(window, Role::SpinButton, name).focus();
    window.run_steps(2);
    window.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::A);
    find(window, Role::SpinButton, name).type_text(text);
    window.run_steps(2);
    window.key_press(egui::Key::Enter);
    window.run_steps(3);
}

#[test]
fn typing_goes_beyond_typical_ranges_and_stops_at_hard_ones() {
    let mut window = window();
    for (property, text, expected) in [
        (Property::specular_ior, "4.2", 4.2),
        (Property::roughness, "20/64", 0.3125),
        (Property::roughness, "7", 1.0),
        (Property::scatter_distance, "25 mm", 0.25),
        (Property::anisotropy_rotation, "90 deg", 0.25),
        (Property::scatter_red_shift, "-0.5", -0.5),
    ] {
        type_into(&mut window, property.def().label, text);
        assert_eq!(material(&window).float(property), expected, "{text}");
        assert_eq!(app(&window).history().undo_label().map(|label| label.contains(property.def().label)), Some(true));
    }
    // What cannot be read changes nothing.
    let before = material(&window);
    type_into(&mut window, "Roughness", "rough");
    assert_eq!(material(&window), before);
}

#[test]
fn the_search_knows_all_three_names() {
    let mut window = window();
    for text in ["Anisotropy angle", "anisotropy_rotation", "anisotropyangle"] {
        window.get_by_label("Search properties").focus();
        window.run_steps(2);
        window.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::A);
        window.get_by_label("Search properties").type_text(text);
        window.run_steps(3);
        find(&window, Role::Slider, "Anisotropy angle");
        assert!(window.query_by_role_and_label(Role::Slider, "Roughness").is_none(), "{text}");
    }
}

#[test]
fn loading_a_preset_is_one_step() {
    let mut window = window();
    let preset = &burnish_presets::presets()[0];
    window.get_by_role_and_label(Role::Button, preset.name).click();
    window.run_steps(3);
    let (file, _) = preset.parse().unwrap();
    assert_eq!(material(&window), *file.material());
    assert_eq!(app(&window).history().undo_label(), Some(format!("Load preset {}", preset.name).as_str()));
    assert!(!app(&window).editor().document.is_modified(), "nothing was lost, so there is nothing to ask about");
    press(&mut window, Command::Undo);
    assert_eq!(material(&window).name, "New material");
}

#[test]
fn saving_clears_the_mark_and_undo_sets_it_again() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("saved.asm.ron");
    let mut window = window_with(vec![path.clone()]);
    find(&window, Role::Slider, "Roughness").set_value_accesskit(0.75);
    window.run_steps(3);
    assert!(app(&window).editor().document.is_modified());

    press(&mut window, Command::Save);
    let (file, warnings) = MaterialFile::parse(&std::fs::read_to_string(&path).unwrap()).unwrap();
    assert!(warnings.is_empty());
    assert_eq!(file.material().float(Property::roughness), 0.75);
    assert!(!app(&window).editor().document.is_modified());
    let info = app(&window).messages().last_info();
    assert!(info.contains("saved, reread, 1 value changed, all else identical"), "{info}");

    press(&mut window, Command::Undo);
    assert!(app(&window).editor().document.is_modified(), "the file now holds the other state");
    press(&mut window, Command::Redo);
    assert!(!app(&window).editor().document.is_modified());

    // Saving again without an edit writes the same bytes.
    let before = std::fs::read(&path).unwrap();
    press(&mut window, Command::Save);
    assert_eq!(std::fs::read(&path).unwrap(), before);
}

fn open(window: &mut Window, path: &Path) {
    let ctx = window.ctx.clone();
    app_mut(window).load_path(path, &ctx);
    settle(window);
}

#[test]
fn unreadable_values_are_shown_and_kept() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("odd.asm.ron");
    let text = "// mine\n{\n    \"asm\": \"4.0\",\n    \"properties\": { \"roughness\": \"very\", \"metallic\": 0.5e0 },\n    \"velvet\": 3,\n}\n";
    std::fs::write(&path, text).unwrap();
    let mut window = window_with(vec![path.clone()]);
    open(&mut window, &path);
    assert_eq!(material(&window).float(Property::metallic), 0.5);
    assert!(window.query_all_by_label_contains("\"very\"").count() > 0, "the text is shown");
    press(&mut window, Command::Save);
    assert_eq!(std::fs::read_to_string(&path).unwrap(), text);
}

#[test]
fn a_file_that_cannot_be_read_costs_one_message_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("broken.asm.ron");
    std::fs::write(&path, "{ \"asm\": ").unwrap();
    let mut window = window();
    let before = material(&window);
    open(&mut window, &path);
    assert_eq!(material(&window), before);
    let messages: Vec<_> = app(&window).messages().iter().collect();
    assert_eq!(messages.len(), 1, "{messages:?}");
    assert!(messages[0].text.contains("broken.asm.ron"));
}

#[test]
fn closing_asks_before_it_drops_changes() {
    let mut window = window();
    find(&window, Role::Slider, "Coat opacity").set_value_accesskit(1.0);
    window.run_steps(3);
    let edited = material(&window);
    press(&mut window, Command::New);
    assert_eq!((app(&window).document_count(), material(&window).float(Property::coat)), (2, 0.0), "a tab of its own");
    press(&mut window, Command::CloseTab);
    assert_eq!(material(&window), edited, "nothing was done in the new one");
    press(&mut window, Command::CloseTab);
    window.get_by_label("Cancel").click();
    window.run_steps(3);
    assert_eq!(material(&window), edited);
    press(&mut window, Command::CloseTab);
    window.get_by_label("Don’t save").click();
    window.run_steps(3);
    assert_eq!(material(&window).float(Property::coat), 0.0);
    assert_eq!(app(&window).history().undo_label(), None);
}

#[test]
fn properties_of_a_lobe_that_is_out_say_why() {
    let material = Material::named("plain");
    let lobes = LobeSet::of(&material);
    assert!(without_effect(Property::coat_color, lobes).is_some_and(|reason| reason.contains("opacity is 0")));
    assert_eq!(without_effect(Property::coat, lobes), None);
    assert_eq!(without_effect(Property::coat_color, lobes.with(Lobe::coat)), None);
}

#[test]
fn without_a_gpu_the_viewport_says_so() {
    let window = window();
    window.get_by_label_contains("No usable GPU");
    window.get_by_label("Show final view");
    window.get_by_label("Try again");
}

/// Draws until a label that contains this is there.
fn wait_for(window: &mut Window, text: &str) {
    let start = Instant::now();
    while window.query_all_by_label_contains(text).count() == 0 {
        assert!(start.elapsed() < Duration::from_secs(180), "no label `{text}` appeared");
        std::thread::sleep(Duration::from_millis(20));
        window.run_steps(1);
    }
}

#[test]
fn the_stability_report_is_made_in_the_background_and_its_fixes_are_single_steps() {
    let mut window = window();
    set_document(&mut window, |material| {
        material.set(Property::translucency, Value::Float(1.0));
        material.set(Property::scatter, Value::Bool(true));
        material.set(Property::scatter_distance, Value::Float(1e-9));
    });
    assert_eq!(window.query_all_by_label_contains("This material").count(), 0, "nothing is probed while the panel is closed");
    let start = Instant::now();
    press(&mut window, Command::ToggleStability);
    window.run_steps(3);
    assert!(start.elapsed() < Duration::from_secs(20), "the window does not wait for the report");
    wait_for(&mut window, "This material");

    let before = material(&window);
    let steps = app(&window).history().labels().count();
    window.get_by_label("Set Scattering distance to 0.001").click();
    window.run_steps(3);
    let fixed = material(&window);
    assert_eq!(fixed.float(Property::scatter_distance), 0.001);
    assert_eq!(app(&window).history().undo_label(), Some("Set Scattering distance to 0.001"));
    assert_eq!(app(&window).history().labels().count(), steps + 1);
    assert_eq!(window.query_all_by_label_contains("This material").count(), 0, "the report of the old values is gone");
    press(&mut window, Command::Undo);
    assert_eq!(material(&window), before);
    press(&mut window, Command::Redo);
    assert_eq!(material(&window), fixed);
    wait_for(&mut window, "This material");
    assert!(window.query_by_label("Set Scattering distance to 0.001").is_none());
    press(&mut window, Command::ToggleStability);
    assert_eq!(window.query_all_by_label_contains("This material").count(), 0);
}
