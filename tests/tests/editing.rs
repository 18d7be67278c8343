//! Every gesture on every property with real events of mouse and keyboard: each does what it says, as exactly one step.

use burnish::widgets::value_edit::edit_range;
use burnish_material::{Kind, PropertyDef, Unit, Value};
use burnish_tests::window::{
    CTRL, Window, app, button, click, drag, field_name, find, gesture, key, material, nothing, number, numeric, rect, release,
    send, set_all, slot, step_now, window,
};
use egui::accesskit::Role;
use egui::{Event, Key, Modifiers, Pos2, Rect, Vec2, vec2};
use egui_kittest::kittest::NodeT;

/// What a drag of a field goes, points.
const WAY: Vec2 = vec2(40.0, 0.0);

fn field(window: &Window, def: &PropertyDef) -> Pos2 {
    rect(window, Role::SpinButton, &field_name(def)).center()
}

/// Where on the track of a property its handle stands at a share of it.
fn on_track(window: &Window, def: &PropertyDef, share: f32) -> Pos2 {
    let rail = rect(window, Role::Slider, def.label).shrink2(vec2(5.0, 0.0));
    rail.left_center() + vec2(share * rail.width(), 0.0)
}

fn floats() -> impl Iterator<Item = &'static PropertyDef> {
    numeric().filter(|def| def.default.kind() == Kind::Float)
}

/// What Ctrl snaps a field or a track to.
fn step_of(window: &Window, role: Role, name: &str) -> f64 {
    find(window, role, name).accesskit_node().numeric_value_step().expect("it has one")
}

fn is_multiple(x: f64, step: f64) -> bool {
    (x / step - (x / step).round()).abs() < 1e-6
}

fn is_close(x: f64, y: f64) -> bool {
    (x - y).abs() < 1e-3 * (1.0 + y.abs())
}

/// The number that a property has while a drag is held, and lets go.
fn held(window: &mut Window, def: &PropertyDef, seen: &mut f64) {
    *seen = number(window, def);
    release(window);
}

#[test]
fn fields_are_dragged() {
    let mut window = window();
    set_all(&mut window);
    for def in numeric() {
        let (at, from) = (field(&window, def), number(&window, def));
        let [mut plain, mut fine, mut snapped] = [from; 3];
        for (what, modifiers, seen) in [
            ("a drag of the field", Modifiers::NONE, &mut plain),
            ("a drag of the field with Shift", Modifiers::SHIFT, &mut fine),
            ("a drag of the field with Ctrl", CTRL, &mut snapped),
        ] {
            gesture(&mut window, def, what, |window| {
                // Far enough that Ctrl comes to another step.
                drag(window, at, if modifiers == CTRL { 2.0 * WAY } else { WAY }, modifiers);
                held(window, def, seen);
            });
        }
        assert!(plain > from, "{}: {from} {plain}", def.name);
        let ratio = (fine - from) / (plain - from);
        assert!((0.02..0.2).contains(&ratio), "{}: {from} {plain} {fine}", def.name);
        let step = step_of(&window, Role::SpinButton, &field_name(def));
        assert!(is_multiple(snapped, step), "{}: {snapped} is no multiple of {step}", def.name);
        // Down is less.
        gesture(&mut window, def, "a drag down", |window| {
            drag(window, at, vec2(0.0, 30.0), Modifiers::NONE);
            held(window, def, &mut plain);
        });
        assert!(plain < from, "{}: {from} {plain}", def.name);
    }
}

#[test]
fn tracks_are_dragged() {
    let mut window = window();
    set_all(&mut window);
    for def in floats() {
        let from = number(&window, def);
        let (min, max) = (def.limits.min.unwrap_or(0.0), def.limits.slider_max);
        let [start, end] = [0.25, 0.75].map(|share| on_track(&window, def, share));
        let [mut plain, mut fine, mut snapped] = [from; 3];
        for (what, modifiers, seen) in [
            ("a drag of the track", Modifiers::NONE, &mut plain),
            ("a drag of the track with Shift", Modifiers::SHIFT, &mut fine),
            ("a drag of the track with Ctrl", CTRL, &mut snapped),
        ] {
            gesture(&mut window, def, what, |window| {
                drag(window, start, end - start, modifiers);
                held(window, def, seen);
            });
        }
        if matches!(def.unit, Unit::Length | Unit::Radiance) {
            assert!(plain > 0.0 && plain < max && fine > from, "{}: {from} {plain} {fine}", def.name);
        } else {
            assert!(is_close(plain, min + 0.75 * (max - min)), "{}: {plain}", def.name);
            // A tenth of the way, less what the drag took to begin.
            assert!((0.02..0.051).contains(&((fine - from) / (max - min))), "{}: {from} {fine}", def.name);
        }
        let step = step_of(&window, Role::Slider, def.label);
        assert!(is_multiple(snapped, step), "{}: {snapped} is no multiple of {step}", def.name);
        gesture(&mut window, def, "a click on the track", |window| {
            let near_the_end = on_track(window, def, 0.98);
            click(window, near_the_end);
            plain = number(window, def);
        });
        assert!(plain > from, "{}: {from} {plain}", def.name);
    }
}

#[test]
fn escape_takes_a_drag_back() {
    // From values that are set, and from values that are not: those are not set afterwards.
    for is_set in [true, false] {
        let mut window = window();
        if is_set {
            set_all(&mut window);
        }
        for def in numeric() {
            let is_full = number(&window, def) >= def.limits.slider_max;
            let at = field(&window, def);
            nothing(&mut window, def, "a drag of the field taken back", |window| {
                let before = slot(window, def.id);
                drag(window, at, if is_full { -WAY } else { WAY }, Modifiers::NONE);
                assert_ne!(slot(window, def.id), before, "{}", def.name);
                key(window, Modifiers::NONE, Key::Escape);
                send(window, [Event::PointerMoved(at)]);
                release(window);
            });
        }
        for def in floats() {
            let [start, end] = [0.25, 0.65].map(|share| on_track(&window, def, share));
            nothing(&mut window, def, "a drag of the track taken back", |window| {
                let before = slot(window, def.id);
                drag(window, start, end - start, Modifiers::NONE);
                assert_ne!(slot(window, def.id), before, "{}", def.name);
                key(window, Modifiers::NONE, Key::Escape);
                send(window, [Event::PointerMoved(start)]);
                release(window);
            });
        }
    }
}

/// Clicks into the field of a property and puts a text in place of what stands there.
fn type_text(window: &mut Window, name: &str, text: &str) {
    let at = rect(window, Role::SpinButton, name).center();
    click(window, at);
    window.step();
    key(window, CTRL, Key::A);
    send(window, [Event::Text(text.to_owned())]);
}

#[test]
fn fields_are_typed_into() {
    let mut window = window();
    set_all(&mut window);
    for def in numeric() {
        let name = field_name(def);
        // Every property takes a turn with each kind of text; the reader of texts has tests of its own.
        let all = [("20/64", 0.3125), ("0.5*2", 1.0), ("30%", 0.3), ("(1+2)/4", 0.75), ("1e-1", 0.1)];
        let mut texts = vec![("0.3125", 0.3125), all[def.id as usize % all.len()]];
        match def.unit {
            Unit::Length => texts.extend([("25 mm", 0.25), ("2.5cm", 0.25)]),
            Unit::Turn => texts.extend([("90 deg", 0.25), ("0.25 turn", 0.25), ("90°", 0.25)]),
            _ => {}
        }
        for (text, expected) in texts {
            let mut seen = 0.0;
            gesture(&mut window, def, text, |window| {
                type_text(window, &name, text);
                key(window, Modifiers::NONE, Key::Enter);
                seen = number(window, def);
            });
            assert_eq!(seen, expected, "{} {text}", def.name);
        }
        nothing(&mut window, def, "a text taken back", |window| {
            type_text(window, &name, "0.7");
            key(window, Modifiers::NONE, Key::Escape);
        });
        nothing(&mut window, def, "a text that is no number", |window| {
            type_text(window, &name, "much");
            key(window, Modifiers::NONE, Key::Enter);
        });
        nothing(&mut window, def, "a look with the keyboard", |window| {
            let at = field(window, def);
            click(window, at);
            key(window, Modifiers::NONE, Key::Enter);
        });
    }
}

/// The names of what has the focus.
fn focused(window: &Window) -> Option<(Role, String)> {
    let mut nodes = window.root().children_recursive();
    let node = nodes.find(|node| node.accesskit_node().is_focused() && node.accesskit_node().role() != Role::Window)?;
    Some((node.accesskit_node().role(), node.accesskit_node().label().unwrap_or_default()))
}

#[test]
fn tab_commits_and_goes_on() {
    let mut window = window();
    set_all(&mut window);
    for def in numeric() {
        let name = field_name(def);
        gesture(&mut window, def, "a text left with Tab", |window| {
            type_text(window, &name, "0.3125");
            assert_eq!(focused(window), Some((Role::SpinButton, name.clone())));
            key(window, Modifiers::NONE, Key::Tab);
            window.run_steps(2);
            assert_eq!(number(window, def), 0.3125, "{}", def.name);
            // Numbers are typed one after the other; nothing comes after the last.
            let next = focused(window);
            let is_last = numeric().last().is_some_and(|last| last.id == def.id);
            let is_next = |(role, next): &(Role, String)| *next != name && (is_last || *role == Role::SpinButton);
            assert!(next.as_ref().is_some_and(is_next), "{}: {next:?}", def.name);
            // So that the keys for undo are not taken by the field that is next.
            key(window, Modifiers::NONE, Key::Escape);
        });
    }
}

/// Goes on with Tab until the field of this name has the focus.
fn tab_to(window: &mut Window, name: &str) {
    for _ in 0..8 {
        key(window, Modifiers::NONE, Key::Tab);
        window.step();
        if focused(window) == Some((Role::SpinButton, name.to_owned())) {
            return;
        }
    }
    panic!("Tab does not lead to {name} but to {:?}", focused(window));
}

#[test]
fn two_fields_one_after_the_other_are_two_steps() {
    let mut window = window();
    set_all(&mut window);
    let mut names: Vec<[String; 2]> = Vec::new();
    for def in numeric() {
        match def.default.kind() {
            Kind::Color => names.push([format!("{} red", def.label), format!("{} green", def.label)]),
            Kind::Normal => names.push([format!("{} x", def.label), format!("{} y", def.label)]),
            Kind::Float | Kind::Bool => {}
        }
    }
    names.push(["Roughness".to_owned(), "Metallic".to_owned()]);
    for [first, second] in &names {
        let (before, step) = (material(&window), step_now(&window));
        type_text(&mut window, first, "0.11");
        tab_to(&mut window, second);
        // The text of the next field is selected, so that typing replaces it.
        send(&mut window, [Event::Text("0.22".to_owned())]);
        key(&mut window, Modifiers::NONE, Key::Enter);
        window.run_steps(2);
        assert_eq!(step_now(&window), step + 2, "{first}, {second}");
        for expected in [0.22, 0.11] {
            let name = if expected == 0.22 { second } else { first };
            assert_eq!(find(&window, Role::SpinButton, name).accesskit_node().numeric_value(), Some(expected), "{name}");
            burnish_tests::window::press(&mut window, burnish::command::Command::Undo);
            window.step();
        }
        assert!(material(&window) == before, "{first}, {second}");
    }
}

#[test]
fn one_slow_frame_holds_a_click_and_what_is_typed_after_it() {
    let mut window = window();
    set_all(&mut window);
    let mode = app(&window).editor().view.mode;
    for def in numeric() {
        let at = field(&window, def);
        let slot = gesture(&mut window, def, "a click and a number in one frame", |window| {
            let pressed =
                |key, pressed| Event::Key { key, physical_key: None, pressed, repeat: false, modifiers: Modifiers::NONE };
            let typed = ["0", ".", "1", "2", "5"].map(|text| (Key::from_name(text), Event::Text(text.to_owned())));
            let typed = typed.into_iter().flat_map(|(key, text)| key.map(|key| pressed(key, true)).into_iter().chain([text]));
            let enter = [pressed(Key::Enter, true), pressed(Key::Enter, false)];
            send(window, [Event::PointerMoved(at), button(at, true), button(at, false)].into_iter().chain(typed).chain(enter));
            window.run_steps(2);
        });
        let expected = 0.125_f64.max(*edit_range(def).start());
        let value = match slot.value {
            Some(Value::Float(x)) => x,
            Some(Value::Color(v) | Value::Normal(v)) => v[1],
            other => panic!("{}: {other:?}", def.name),
        };
        assert_eq!(value, expected, "{}", def.name);
    }
    assert_eq!(app(&window).editor().view.mode, mode, "digits are keys of commands, too");
}

/// Where the fields and tracks of all rows are.
fn rows(window: &Window) -> Vec<(String, Rect)> {
    let mut rows = Vec::new();
    for node in window.root().children_recursive() {
        let at = node.accesskit_node();
        if matches!(at.role(), Role::SpinButton | Role::Slider | Role::ColorWell | Role::CheckBox) {
            rows.push((at.label().unwrap_or_default(), node.rect()));
        }
    }
    rows
}

#[test]
fn nothing_moves_while_a_value_is_dragged() {
    let mut window = window();
    for def in numeric() {
        let (at, before) = (field(&window, def), rows(&window));
        let is_full = number(&window, def) >= def.limits.slider_max;
        drag(&mut window, at, if is_full { -WAY } else { WAY }, Modifiers::NONE);
        for by in [60.0, 300.0, -300.0, 5.0] {
            send(&mut window, [Event::PointerMoved(at + vec2(by, 0.0))]);
            window.step();
            let now = rows(&window);
            let moved = before.iter().zip(&now).find(|(a, b)| a != b);
            assert!(moved.is_none() && before.len() == now.len(), "dragging {} moved {moved:?}", def.name);
        }
        key(&mut window, Modifiers::NONE, Key::Escape);
        release(&mut window);
    }
}
