//! Random walks through commands and edits: the window never panics, and undo leads back to the bytes that every document began with.
//!
//! A thousand walks are what the product promises; they take about a quarter of an hour:
//! `BURNISH_WALKS=1000 cargo test -p burnish-tests --test random_walk`. `BURNISH_WALK=17` takes the one of this number alone.

use burnish::command::{COMMANDS, Command};
use burnish_material::{DEFAULT_UNIT_MM, Kind, Material, MaterialFile, PROPERTIES, PropertyDef, Slot, TextureRef, Value, Vary};
use burnish_tests::number::Random;
use burnish_tests::window::{Window, app, app_mut, button, settle, text, window_of};
use egui::{Event, Key, Modifiers, Pos2, pos2, vec2};
use egui_kittest::kittest::Queryable;
use std::collections::HashSet;
use std::time::{Duration, Instant};

/// Steps of a walk.
const STEPS: usize = 200;
/// Walks unless the environment asks for more: a walk takes about a second and a half, and a test may take half a minute.
const WALKS: u64 = 24;
/// No walk is begun after this long unless the environment asks for a number, so that a busy machine does not wait.
const PATIENCE: Duration = Duration::from_secs(40);
/// Small, since what lies outside is not painted.
const SIZE: egui::Vec2 = vec2(900.0, 600.0);

/// What a walk begins with: a file with comments, an unknown key, a value that cannot be read, and numbers in spellings of their own.
const FILE: &str = "// mine\n{\n    \"asm\": \"4.0\",\n    \"name\": \"walked\", // a name\n    \"properties\": {\n        \"roughness\": 2.50e-1,\n        \
                    \"metallic\": \"very\",\n        \"base_color\": (0.25, 5e-1, 0.75),\n        \"specular_ior\": { \"value\": 1.330 },\n    },\n    \
                    \"velvet\": [1, 2], /* kept */\n}\n";

/// A value for a property, sometimes outside what its widgets would set.
fn value(random: &mut Random, def: &PropertyDef) -> Value {
    let mut number = || {
        let low = def.limits.min.unwrap_or(-1.0);
        [low, def.limits.slider_max, low + random.unit() * (def.limits.slider_max - low), -1e9 * random.unit(), 1e-12]
            [random.below(5)]
    };
    match def.default.kind() {
        Kind::Float => Value::Float(number()),
        Kind::Bool => Value::Bool(number() > 0.5),
        Kind::Color => Value::Color([number(), number(), number()]),
        Kind::Normal => Value::Normal([number(), number(), number()]),
    }
}

/// Changes the material as the panels do.
fn edit(random: &mut Random, window: &mut Window) {
    let def = &PROPERTIES[random.below(PROPERTIES.len())];
    let (new, choice) = (value(random, def), random.below(10));
    let rotation = random.unit() * 360.0;
    let material = &mut app_mut(window).editor_mut().document.material;
    match choice {
        0 => *material.slot_mut(def.id) = Slot::default(),
        1 if def.vary != Vary::Uniform => material.slot_mut(def.id).texture = Some(TextureRef::new("missing/map.png")),
        2 => {
            if let Some(texture) = &mut material.slot_mut(def.id).texture {
                texture.uv_rotation = rotation;
            }
        }
        3 => material.name = format!("name {}", rotation as u32),
        4 => material.notes.push_str("a \"note\"\n"),
        5 => material.unit_mm = Some(1.0 + rotation),
        _ => _ = material.set(def.id, new),
    }
}

/// A press, a move and a release anywhere, or a key: whatever they mean there.
fn touch(random: &mut Random, window: &mut Window) {
    let mut place = || pos2(random.unit() as f32 * SIZE.x, 40.0 + random.unit() as f32 * (SIZE.y - 70.0));
    let (from, to): (Pos2, Pos2) = (place(), place());
    // The menu bar lies above, so that no one quits; and files are not asked for by it.
    let mut frame = |events: Vec<Event>| {
        window.input_mut().events.extend(events);
        window.step();
    };
    frame(vec![Event::PointerMoved(from), button(from, true)]);
    if random.below(2) == 0 {
        frame(vec![Event::PointerMoved(to)]);
        frame(vec![button(to, false)]);
    } else {
        frame(vec![button(from, false)]);
        let keys = [Key::Backspace, Key::Minus, Key::Tab, Key::Enter, Key::ArrowUp, Key::ArrowRight, Key::Num7, Key::Escape];
        let pressed = keys[random.below(keys.len())];
        let event = |is_down| Event::Key {
            key: pressed,
            physical_key: None,
            pressed: is_down,
            repeat: false,
            modifiers: Modifiers::NONE,
        };
        frame(vec![event(true), event(false)]);
    }
}

/// What keeps the other threads at work for long, so that a walk would wait for them and not for the window.
fn works_long(command: Command) -> bool {
    use Command::{CompareSides, NextBackdrop, NextDebug, NextEnvironment, NextMesh, PreviousMesh, ShowFinal, ToggleStability};
    matches!(
        command,
        NextBackdrop | NextDebug | NextEnvironment | NextMesh | PreviousMesh | ShowFinal | ToggleStability | CompareSides
    )
}

/// Answers what the window asks, so that the walk can go on.
fn answer(random: &mut Random, window: &mut Window) {
    let answers = ["Don’t save", "Cancel"];
    let name = answers[random.below(answers.len())];
    let Some(node) = window.query_by_label(name) else { return };
    node.click();
    window.run_steps(2);
}

fn walk(seed: u64) {
    // Walks save, each over its own file.
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("walked.asm.ron");
    std::fs::write(&path, FILE).expect("it can be written");
    let mut random = Random::new(seed);
    let mut window = window_of(SIZE, Vec::new());
    let fresh = text(&window);
    let ctx = window.ctx.clone();
    app_mut(&mut window).load_path(&path, &ctx);
    settle(&mut window);
    assert_eq!(text(&window), FILE);
    // What a document may begin with: the walk saves, and opens again what it saved.
    let mut beginnings = HashSet::from([fresh, FILE.to_owned()]);
    beginnings.extend(burnish_presets::measured::measured().iter().map(|row| row.file_text()));
    let presets = burnish_presets::presets();
    for _ in 0..STEPS {
        // One sample ends the final view, where it is shown.
        app_mut(&mut window).editor_mut().view.stop.spp = Some(1);
        match random.below(20) {
            0..=7 => {
                let command = COMMANDS[random.below(COMMANDS.len())].command;
                let is_rare = works_long(command) && random.below(12) > 0;
                if command != Command::Quit && !is_rare {
                    app_mut(&mut window).carry_out(command, &ctx);
                }
            }
            8..=15 => edit(&mut random, &mut window),
            16 => app_mut(&mut window).load_preset(&presets[random.below(presets.len())], &ctx),
            _ => touch(&mut random, &mut window),
        }
        window.step();
        answer(&mut random, &mut window);
        beginnings.insert(std::fs::read_to_string(&path).expect("it is there"));
        // And what is new has the unit that the preferences say, which are commands as well.
        let unit_mm = app(&window).preferences().unit_mm;
        let mut new = Material::named("New material");
        new.unit_mm = (unit_mm != DEFAULT_UNIT_MM).then_some(unit_mm);
        beginnings.insert(MaterialFile::new(&new).text().to_owned());
    }
    settle(&mut window);
    // Nothing is being typed or held any more, and no question waits.
    for _ in 0..3 {
        burnish_tests::window::key(&mut window, Modifiers::NONE, Key::Escape);
        window.step();
    }
    for _ in 0..app(&window).document_count() {
        let (last, mut undone) = (text(&window), 0);
        while app(&window).history().undo_label().is_some() {
            app_mut(&mut window).carry_out(Command::Undo, &ctx);
            undone += 1;
        }
        window.step();
        let first = text(&window);
        assert!(beginnings.contains(&first), "walk {seed}: after {undone} steps back:\n{first}");
        for _ in 0..undone {
            app_mut(&mut window).carry_out(Command::Redo, &ctx);
        }
        let again = text(&window);
        assert!(again == last, "walk {seed}: {undone} steps back and forth made of\n{last}\nthis:\n{again}");
        app_mut(&mut window).carry_out(Command::NextTab, &ctx);
        window.step();
    }
}

/// A number from the environment.
fn asked(name: &str) -> Option<u64> {
    std::env::var(name).ok()?.parse().ok()
}

#[test]
fn undo_leads_back_from_anywhere() {
    if let Some(seed) = asked("BURNISH_WALK") {
        return walk(seed);
    }
    let (walks, start) = (asked("BURNISH_WALKS"), Instant::now());
    let threads = std::thread::available_parallelism().map_or(1, |count| count.get() as u64);
    let done = std::sync::atomic::AtomicU64::new(0);
    std::thread::scope(|scope| {
        for thread in 0..threads {
            let done = &done;
            scope.spawn(move || {
                for seed in (thread..walks.unwrap_or(WALKS)).step_by(threads as usize) {
                    if walks.is_none() && start.elapsed() > PATIENCE {
                        return;
                    }
                    let result = std::panic::catch_unwind(|| walk(seed));
                    assert!(result.is_ok(), "walk {seed} failed; BURNISH_WALK={seed} takes it alone");
                    done.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
                }
            });
        }
    });
    eprintln!("{} walks in {:.1} s", done.into_inner(), start.elapsed().as_secs_f64());
}
