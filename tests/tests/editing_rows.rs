//! What the mouse and the keyboard do to a row of the properties as a whole: reset, copy, paste, step, negate, switch.

use burnish::widgets::value_edit::exact_text;
use burnish_material::{Kind, Material, PROPERTIES, Property, PropertyDef, Slot, TextureRef, Unit, Value};
use burnish_tests::window::{
    CTRL, Window, click, click_secondary, drag, field_name, gesture, key, material, notch, nothing, number, numeric, rect,
    release, send, set_all, set_document, settle, slot, step_now, window, window_of, with_modifiers,
};
use egui::accesskit::Role;
use egui::{Event, Key, Modifiers, OutputCommand, Pos2, pos2, vec2};
use egui_kittest::kittest::{NodeT, Queryable};

/// The middle of the control that changes a property.
fn control(window: &Window, def: &PropertyDef) -> Pos2 {
    let role = if def.default.kind() == Kind::Bool { Role::CheckBox } else { Role::SpinButton };
    rect(window, role, &field_name(def)).center()
}

/// On the name of a property.
fn label(window: &Window, def: &PropertyDef) -> Pos2 {
    let left = rect(window, Role::TextInput, "Search properties").left();
    pos2(left + 24.0, control(window, def).y)
}

/// What was copied in the last frame.
fn copied(window: &Window) -> Option<String> {
    window.output().platform_output.commands.iter().find_map(|command| match command {
        OutputCommand::CopyText(text) => Some(text.clone()),
        _ => None,
    })
}

/// Lets a second pass, so that the next click is the first of two.
fn pause(window: &mut Window) {
    let now = window.ctx.input(|i| i.time);
    window.input_mut().time = Some(now + 1.0);
    window.step();
}

fn click_named(window: &mut Window, name: &str) {
    let at = window.get_by_role_and_label(Role::Button, name).rect().center();
    click(window, at);
}

#[test]
fn there_are_four_ways_to_reset() {
    let mut window = window();
    set_all(&mut window);
    for def in PROPERTIES {
        let (control, label) = (control(&window, def), label(&window, def));
        let mut results = vec![
            gesture(&mut window, def, "Backspace over the field", |window| {
                send(window, [Event::PointerMoved(control)]);
                key(window, Modifiers::NONE, Key::Backspace);
            }),
            gesture(&mut window, def, "two clicks on the name", |window| {
                pause(window);
                click(window, label);
                click(window, label);
            }),
            gesture(&mut window, def, "the button for reset", |window| click_named(window, &format!("Reset {}", def.label))),
            gesture(&mut window, def, "reset in the menu", |window| {
                click_secondary(window, label);
                window.step();
                let at = window.get_by_label_contains("Reset to default").rect().center();
                click(window, at);
            }),
        ];
        if def.default.kind() == Kind::Float {
            let track = rect(&window, Role::Slider, def.label).center();
            pause(&mut window);
            click(&mut window, track);
            click(&mut window, track);
            window.run_steps(2);
            results.push(slot(&window, def.id));
        }
        assert!(results.iter().all(|result| *result == Slot::default()), "{}: {results:?}", def.name);
    }
}

#[test]
fn a_switch_is_one_step() {
    let mut window = window();
    for def in PROPERTIES.iter().filter(|def| def.default.kind() == Kind::Bool) {
        let at = control(&window, def);
        let after = gesture(&mut window, def, "a click", |window| click(window, at));
        assert_eq!(after.value, Some(Value::Bool(def.default != Value::Bool(true))), "{}", def.name);
        let after = gesture(&mut window, def, "the space bar", |window| {
            window.get_by_role_and_label(Role::CheckBox, def.label).focus();
            window.run_steps(2);
            key(window, Modifiers::NONE, Key::Space);
        });
        assert_eq!(after.value, Some(Value::Bool(def.default != Value::Bool(true))), "{}", def.name);
    }
}

#[test]
fn values_are_copied_with_all_digits_and_pasted() {
    let mut window = window();
    set_all(&mut window);
    for def in PROPERTIES {
        let (control, label) = (control(&window, def), label(&window, def));
        // Over the name: the whole value.
        let odd = match def.default {
            Value::Float(_) => Value::Float(1.0 / 3.0),
            Value::Bool(v) => Value::Bool(v),
            Value::Color(_) | Value::Normal(_) => match def.default.kind() {
                Kind::Color => Value::Color([0.1, 1.0 / 3.0, 0.7]),
                _ => Value::Normal([0.1, 1.0 / 3.0, -0.7]),
            },
        };
        let after = gesture(&mut window, def, "a paste over the name", |window| {
            send(window, [Event::PointerMoved(label)]);
            send(window, [Event::Paste(exact_text(odd))]);
        });
        assert_eq!(after.value, Some(odd), "{}", def.name);
        let before = material(&window).value(def.id);
        send(&mut window, [Event::PointerMoved(label)]);
        send(&mut window, [Event::Copy]);
        assert_eq!(copied(&window), Some(exact_text(before)), "{}", def.name);
        nothing(&mut window, def, "a paste of something else", |window| {
            send(window, [Event::Paste("velvet".to_owned())]);
            send(window, [Event::PointerMoved(control), Event::Paste("velvet".to_owned())]);
        });
        if def.default.kind() == Kind::Bool {
            continue;
        }
        // Over the field: its number, also with the unit of a length.
        let third = (1.0_f64 / 3.0).to_string();
        gesture(&mut window, def, "a paste over the field", |window| {
            send(window, [Event::PointerMoved(control)]);
            send(window, [Event::Paste(third.clone())]);
            window.step();
            assert_eq!(number(window, def), 1.0 / 3.0, "{}", def.name);
            // Rows above may have come into effect, and lost their notes.
            let control = rect(window, Role::SpinButton, &field_name(def)).center();
            send(window, [Event::PointerMoved(control)]);
            send(window, [Event::Copy]);
            assert_eq!(copied(window), Some(third.clone()), "{}", def.name);
        });
        for at in [control, label].into_iter().filter(|_| def.unit == Unit::Length) {
            let after = gesture(&mut window, def, "a paste of a length", |window| {
                send(window, [Event::PointerMoved(at)]);
                send(window, [Event::Paste("25 mm".to_owned())]);
            });
            assert_eq!(after.value, Some(Value::Float(0.25)), "{}", def.name);
        }
        if def.default.kind() == Kind::Color {
            whole_colors(&mut window, def, control, label);
        }
    }
}

/// Colours in hexadecimal over any part of the row, and whole ones over a field with Alt.
fn whole_colors(window: &mut Window, def: &PropertyDef, control: Pos2, label: Pos2) {
    let swatch = rect(window, Role::ColorWell, def.label).center();
    for at in [label, swatch, control] {
        let after = gesture(window, def, "a paste of a hexadecimal colour", |window| {
            send(window, [Event::PointerMoved(at)]);
            send(window, [Event::Paste("#ff8000".to_owned())]);
        });
        assert_eq!(after.value, Some(Value::Color([1.0, 0.2159, 0.0])), "{}", def.name);
    }
    let after = gesture(window, def, "a paste with Alt", |window| {
        send(window, [Event::PointerMoved(control)]);
        with_modifiers(window, Modifiers::ALT, [Event::Paste("(0.25, 0.5, 0.75)".to_owned())]);
    });
    assert_eq!(after.value, Some(Value::Color([0.25, 0.5, 0.75])), "{}", def.name);
    send(window, [Event::PointerMoved(control)]);
    with_modifiers(window, Modifiers::ALT, [Event::Copy]);
    assert_eq!(copied(window), Some(exact_text(material(window).value(def.id))), "{}", def.name);
    window.step();
}

#[test]
fn the_wheel_steps_and_minus_negates() {
    let mut window = window();
    set_all(&mut window);
    for def in numeric() {
        let from = number(&window, def);
        let mut places = vec![control(&window, def)];
        if def.default.kind() == Kind::Float {
            places.push(rect(&window, Role::Slider, def.label).center());
        }
        let range = burnish::widgets::value_edit::edit_range(def);
        for at in places {
            for (lines, is_more) in [(1.0, true), (-1.0, false)] {
                let mut now = from;
                gesture(&mut window, def, "Ctrl and the wheel", |window| {
                    send(window, [Event::PointerMoved(at)]);
                    with_modifiers(window, CTRL, [notch(lines, CTRL)]);
                    window.step();
                    now = number(window, def);
                });
                assert!(now != from && (now > from) == is_more, "{}: {from} {now}", def.name);
            }
            let mut now = from;
            gesture(&mut window, def, "Minus", |window| {
                send(window, [Event::PointerMoved(at)]);
                key(window, Modifiers::NONE, Key::Minus);
                window.step();
                now = number(window, def);
            });
            assert_eq!(now, (-from).max(*range.start()), "{}", def.name);
            // Thirty notches in one frame stay within what an edit may set.
            gesture(&mut window, def, "many notches", |window| {
                send(window, [Event::PointerMoved(at)]);
                with_modifiers(window, CTRL, std::iter::repeat_n(notch(1.0, CTRL), 300));
                window.step();
                now = number(window, def);
            });
            assert!(range.contains(&now), "{}: {now}", def.name);
        }
    }
}

#[test]
fn a_text_and_a_drag_right_after_it_are_two_steps() {
    let mut window = window();
    set_document(&mut window, |material| _ = material.set(Property::metallic, Value::Float(0.5)));
    let (before, step) = (material(&window), step_now(&window));
    let [first, second] = [Property::roughness, Property::metallic].map(Property::def);
    let [at, there] = [first, second].map(|def| control(&window, def));
    click(&mut window, at);
    window.step();
    key(&mut window, CTRL, Key::A);
    send(&mut window, [Event::Text("0.9".to_owned())]);
    // The field is left by pressing on the next.
    drag(&mut window, there, vec2(50.0, 0.0), Modifiers::NONE);
    release(&mut window);
    assert_eq!(number(&window, first), 0.9);
    assert!(number(&window, second) > 0.5);
    assert_eq!(step_now(&window), step + 2);
    for _ in 0..2 {
        burnish_tests::window::press(&mut window, burnish::command::Command::Undo);
    }
    assert!(material(&window) == before);
    assert!(window.root().children_recursive().all(|node| !node.is_focused() || node.accesskit_node().role() == Role::Window));
}

#[test]
fn maps_are_scaled_and_shifted_in_their_settings() {
    let mut window = window_of(vec2(1600.0, 4000.0), Vec::new());
    let has = |window: &Window, name: &str| window.query_by_role_and_label(Role::SpinButton, name).is_some();
    for property in [Property::roughness, Property::base_color, Property::normal] {
        let def = property.def();
        set_document(&mut window, |material| {
            *material = Material::default();
            material.slot_mut(property).texture = Some(TextureRef::new("missing.png"));
        });
        settle(&mut window);
        let settings = |window: &mut Window| {
            click_named(window, &format!("{} map settings", def.label));
            window.run_steps(4);
        };
        settings(&mut window);
        let fields: &[&str] = match def.default.kind() {
            Kind::Float => &["scale", "bias"],
            Kind::Color => &["scale green", "bias green"],
            _ => &[],
        };
        if fields.is_empty() {
            assert!(has(&window, &format!("{} map repeat u", def.label)));
            assert!(!has(&window, &format!("{} map scale", def.label)) && !has(&window, &format!("{} map bias red", def.label)));
        }
        for field in fields {
            let name = format!("{} map {field}", def.label);
            let at = rect(&window, Role::SpinButton, &name).center();
            let made = gesture(&mut window, def, field, |window| {
                click(window, at);
                window.step();
                key(window, CTRL, Key::A);
                send(window, [Event::Text("-2.5".to_owned())]);
                key(window, Modifiers::NONE, Key::Enter);
            });
            let texture = made.texture.expect("the map stays");
            let (changed, other, old) = if field.starts_with("scale") {
                (texture.scale, texture.bias, [0.0; 3])
            } else {
                (texture.bias, texture.scale, [1.0; 3])
            };
            let rest = if field.starts_with("scale") { 1.0 } else { 0.0 };
            let expected = if def.default.kind() == Kind::Color { [rest, -2.5, rest] } else { [-2.5; 3] };
            assert_eq!((changed, other), (expected, old), "{name}");
        }
        key(&mut window, Modifiers::NONE, Key::Escape);
        window.run_steps(2);
    }
}
