//! The window without a GPU and without a display, driven as by a hand: several events in one frame where a desktop would send them together.

use burnish::app::App;
use burnish::command::Command;
use burnish::dialogs::PreparedDialogs;
use burnish_material::{Kind, Material, PROPERTIES, Property, PropertyDef, Slot, Value};
use egui::accesskit::Role;
use egui::{Context, Event, Key, Modifiers, MouseWheelSource, MouseWheelUnit, PointerButton, Pos2, Rect, TouchPhase, Vec2, vec2};
use egui_kittest::kittest::Queryable;
use egui_kittest::{Harness, Node};
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// A window and its application.
pub type Window = Harness<'static, Option<App>>;

/// High enough that every row of the properties lies on it, points.
pub const HIGH: Vec2 = vec2(1280.0, 2600.0);

/// The control keys as a desktop that is not a Mac sends them.
pub const CTRL: Modifiers = Modifiers { ctrl: true, command: true, ..Modifiers::NONE };

/// A window of a size in points, whose file dialogs answer with these paths in turn, and then cancel.
pub fn window_of(size: Vec2, paths: Vec<PathBuf>) -> Window {
    window_with(size, paths, |app, _| app)
}

/// The same, with an application that is prepared when it is made.
pub fn window_with(size: Vec2, paths: Vec<PathBuf>, prepare: impl Fn(App, &Context) -> App + 'static) -> Window {
    let mut window = Harness::builder().with_size(size).with_step_dt(1.0 / 60.0).build_ui_state(
        move |ui: &mut egui::Ui, app: &mut Option<App>| {
            let dialogs = PreparedDialogs::new(paths.clone());
            let app = app.get_or_insert_with(|| {
                let app = App::new(ui.ctx(), None, Box::new(dialogs)).without_final_view();
                prepare(app, ui.ctx())
            });
            app.frame(ui);
        },
        None,
    );
    settle(&mut window);
    window
}

/// A window on which every row lies.
pub fn window() -> Window {
    window_of(HIGH, Vec::new())
}

/// The application.
pub fn app(window: &Window) -> &App {
    window.state().as_ref().expect("the first frame makes it")
}

/// The same, to be changed.
pub fn app_mut(window: &mut Window) -> &mut App {
    window.state_mut().as_mut().expect("the first frame makes it")
}

/// The material being edited.
pub fn material(window: &Window) -> Material {
    app(window).editor().document.material.clone()
}

/// The slot of a property of the material being edited.
pub fn slot(window: &Window, property: Property) -> Slot {
    app(window).editor().document.material.slot(property).clone()
}

/// Draws until nothing is being loaded any more, and some frames beyond.
pub fn settle(window: &mut Window) {
    let start = Instant::now();
    window.run_steps(3);
    while app(window).is_loading() {
        assert!(start.elapsed() < Duration::from_secs(120), "still loading");
        std::thread::sleep(Duration::from_millis(10));
        window.run_steps(1);
    }
    window.run_steps(3);
}

/// Changes the material behind the window's back and lets it notice; one step of the history.
pub fn set_document(window: &mut Window, edit: impl FnOnce(&mut Material)) {
    edit(&mut app_mut(window).editor_mut().document.material);
    window.run_steps(2);
}

/// One frame with these events.
pub fn send(window: &mut Window, events: impl IntoIterator<Item = Event>) {
    window.input_mut().events.extend(events);
    window.step();
}

/// A key pressed and let go within a frame.
pub fn key(window: &mut Window, modifiers: Modifiers, key: Key) {
    let event = |pressed| Event::Key { key, physical_key: None, pressed, repeat: false, modifiers };
    with_modifiers(window, modifiers, [event(true), event(false)]);
}

/// One frame with these events while keys are held; with the next frame they are let go.
pub fn with_modifiers(window: &mut Window, modifiers: Modifiers, events: impl IntoIterator<Item = Event>) {
    window.input_mut().events.push(Event::ModifiersChanged(modifiers));
    send(window, events);
    window.input_mut().events.push(Event::ModifiersChanged(Modifiers::NONE));
}

/// The first keys of a command, in one frame.
pub fn press_keys(window: &mut Window, command: Command) {
    let keys = command.def().keys[0];
    key(window, Modifiers { ctrl: keys.modifiers.command, ..keys.modifiers }, keys.logical_key);
}

/// The same, and a frame in which what was opened is drawn.
pub fn press(window: &mut Window, command: Command) {
    press_keys(window, command);
    window.step();
}

/// A button of the mouse at a place.
pub fn button(pos: Pos2, pressed: bool) -> Event {
    Event::PointerButton { pos, button: PointerButton::Primary, pressed, modifiers: Modifiers::NONE }
}

/// A click, in the two frames that it takes.
pub fn click(window: &mut Window, pos: Pos2) {
    send(window, [Event::PointerMoved(pos), button(pos, true)]);
    send(window, [button(pos, false)]);
}

/// The same with the other button.
pub fn click_secondary(window: &mut Window, pos: Pos2) {
    let event = |pressed| Event::PointerButton { pos, button: PointerButton::Secondary, pressed, modifiers: Modifiers::NONE };
    send(window, [Event::PointerMoved(pos), event(true)]);
    send(window, [event(false)]);
}

/// A drag from a place by a distance, with keys held; the button stays down.
pub fn drag(window: &mut Window, from: Pos2, by: Vec2, modifiers: Modifiers) {
    send(window, [Event::PointerMoved(from), Event::ModifiersChanged(modifiers), button(from, true)]);
    // As a hand does: more than one move, the first beyond what still counts as a click.
    for part in [0.5, 1.0] {
        send(window, [Event::PointerMoved(from + part * by)]);
    }
}

/// Lets the button go where the pointer is, and the keys.
pub fn release(window: &mut Window) {
    let pos = window.ctx.input(|i| i.pointer.latest_pos()).expect("the pointer is somewhere");
    send(window, [button(pos, false), Event::ModifiersChanged(Modifiers::NONE)]);
    window.step();
}

/// One notch of the wheel.
pub fn notch(lines: f32, modifiers: Modifiers) -> Event {
    Event::MouseWheel {
        unit: MouseWheelUnit::Line,
        delta: vec2(0.0, lines),
        phase: TouchPhase::Move,
        source: MouseWheelSource::Unknown,
        modifiers,
    }
}

/// The node of a role and a name.
pub fn find<'a>(window: &'a Window, role: Role, name: &'a str) -> Node<'a> {
    window.get_by_role_and_label(role, name)
}

/// Where it is.
pub fn rect(window: &Window, role: Role, name: &str) -> Rect {
    find(window, role, name).rect()
}

/// The cards of the library of this name, whether their pictures are drafts or not.
pub fn cards<'a>(window: &'a Window, name: &'a str) -> impl Iterator<Item = Node<'a>> {
    let is_name =
        move |label: String| label.strip_prefix(name).is_some_and(|rest| rest.is_empty() || rest.starts_with(", draft"));
    window.query_all_by(move |node| node.role() == Role::ListBoxOption && node.label().is_some_and(is_name))
}

/// Where the first of them is.
pub fn card(window: &Window, name: &str) -> Rect {
    cards(window, name).next().expect("there is such a card").rect()
}

/// The name of the field that changes a number of a property, its second if it has three.
pub fn field_name(def: &PropertyDef) -> String {
    match def.default.kind() {
        Kind::Float | Kind::Bool => def.label.to_owned(),
        Kind::Color => format!("{} green", def.label),
        Kind::Normal => format!("{} y", def.label),
    }
}

/// What the file of the document in front would be.
pub fn text(window: &Window) -> String {
    let document = &app(window).editor().document;
    document.file().to_text(&document.material)
}

/// The second number of a property, or its only one; 0 and 1 for a switch.
pub fn number(window: &Window, def: &PropertyDef) -> f64 {
    match material(window).value(def.id) {
        Value::Float(v) => v,
        Value::Bool(v) => f64::from(u8::from(v)),
        Value::Color(v) | Value::Normal(v) => v[1],
    }
}

/// Which step of the history is the present one.
pub fn step_now(window: &Window) -> usize {
    app(window).history().labels().position(|(_, is_now)| is_now).expect("one of them is")
}

/// Does something to a property and holds it to its promise: nothing else changes, it is exactly one step with the name of the property in it,
/// and undo and redo lead over it. Returns the slot that it led to; the material is what it was before.
pub fn gesture(window: &mut Window, def: &PropertyDef, what: &str, act: impl FnOnce(&mut Window)) -> Slot {
    let (before, step) = (material(window), step_now(window));
    act(window);
    window.step();
    let after = material(window);
    let what = format!("{what} on {}", def.name);
    for other in PROPERTIES.iter().filter(|other| other.id != def.id) {
        assert!(after.slot(other.id) == before.slot(other.id), "{what} changed {}", other.name);
    }
    assert!(after != before, "{what} changed nothing");
    let labels: Vec<String> = app(window).history().labels().skip(step + 1).map(|(label, _)| label.to_owned()).collect();
    assert!(labels.len() == 1 && labels[0].contains(def.label), "{what} made the steps {labels:?}");
    for (command, expected) in [(Command::Undo, &before), (Command::Redo, &after), (Command::Undo, &before)] {
        press_keys(window, command);
        assert!(material(window) == *expected, "{what}: {command:?} led to {:?}", slot(window, def.id));
    }
    after.slot(def.id).clone()
}

/// Does something and holds it to changing nothing, and to making no step.
pub fn nothing(window: &mut Window, def: &PropertyDef, what: &str, act: impl FnOnce(&mut Window)) {
    let (before, step) = (material(window), step_now(window));
    act(window);
    window.step();
    assert!(material(window) == before, "{what} on {}: {:?} became {:?}", def.name, before.slot(def.id), slot(window, def.id));
    assert!(step_now(window) == step, "{what} on {} made the step {:?}", def.name, app(window).history().undo_label());
}

/// Gives every number a place 0.4 along its range and switches all switches on, so that there is room in both directions.
pub fn set_all(window: &mut Window) {
    set_document(window, |material| {
        for def in PROPERTIES {
            let low = def.limits.min.unwrap_or(0.0);
            let x = low + 0.4 * (def.limits.slider_max - low);
            let value = match def.default {
                Value::Float(_) => Value::Float(x),
                Value::Bool(v) => Value::Bool(!v),
                Value::Color(_) => Value::Color([0.2, 0.4, 0.6]),
                Value::Normal(_) => Value::Normal([0.1, 0.4, 0.9]),
            };
            material.set(def.id, value);
        }
    });
}

/// The properties that are numbers, or have three.
pub fn numeric() -> impl Iterator<Item = &'static PropertyDef> {
    PROPERTIES.iter().filter(|def| def.default.kind() != Kind::Bool)
}
