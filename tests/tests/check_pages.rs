//! The pages of a library's author: what a check found, files that are one, two materials beside each other, a merge, and what changed since a release.

use burnish::app::App;
use burnish::command::Command;
use burnish::dock::Pane;
use burnish::library::check::against::LookChange;
use burnish::picture_diff::{Drawing, draw};
use burnish::places::Places;
use burnish_material::{MaterialFile, Property, Severity, Value};
use burnish_renderer::scene::TextureSet;
use burnish_renderer::tonemap::Display;
use burnish_tests::window::{
    CTRL, Window, app, button, card, cards, click, key, material, press, rect, send, set_document, text, window_with,
    with_modifiers,
};
use egui::accesskit::Role;
use egui::{Event, Key, Modifiers, vec2};
use egui_kittest::kittest::{NodeT, Queryable};
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Longest wait for anything that happens in the background.
const PATIENCE: Duration = Duration::from_secs(60);

fn file(name: &str, properties: &str) -> String {
    format!(
        "// kept: {name}\n{{\n    \"asm\": \"4.0\",\n    \"name\": \"{name}\",\n    \"tags\": [\"test\"],\n    \
         \"provenance\": {{ \"source\": \"Tests\", \"licence\": \"CC0-1.0\" }},\n    \"properties\": {{ {properties} }},\n}}\n"
    )
}

/// A library with three errors, an unlikely metal, and two files that are the same; all as a user would write them.
fn library_files() -> Vec<(&'static str, String)> {
    vec![
        ("brass", file("Brass", r#""metallic": 1.0, "base_color": (0.91, 0.78, 0.42), "roughness": 0.12"#)),
        ("gold", file("Gold", r#""metallic": 1.0, "base_color": (1.0, 0.71, 0.31), "roughness": 0.2"#)),
        ("gold-old", file("Old gold", r#""metallic": 1, "base_color": (1.0, 0.710, 0.31), "roughness": 0.20"#)),
        ("oak", file("Oak", r#""roughness": { "value": 0.6, "texture": { "path": "maps/oak.png" } }"#)),
        ("paint", file("Paint", r#""base_color": (1.4, 0.2, 0.1)"#)),
        ("violet", file("Violet", r#""metallic": 1.0, "base_color": (0.5, 0.3, 0.9)"#)),
        ("wax", file("Wax", r#""translucency": 1.0, "scatter": true, "scatter_distance": 0.0"#)),
    ]
}

fn folder(files: &[(&str, String)]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    files.iter().for_each(|(name, text)| fs::write(path(folder.path(), name), text).expect("it can be written"));
    folder
}

fn path(folder: &Path, name: &str) -> PathBuf {
    folder.join(format!("{name}.asm.ron"))
}

fn bytes(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let entries = fs::read_dir(folder).expect("the folder").map(|entry| entry.expect("an entry").path());
    entries.map(|path| (path.clone(), fs::read(path).expect("a file"))).collect()
}

/// A window of this size with a library open, whose dialogs answer with these paths.
fn open(size: [f32; 2], root: Option<&Path>, home: &Path, dialogs: Vec<PathBuf>) -> Window {
    let part = |name: &str| Some(home.join(name));
    let places = Places { config: part("config"), state: part("state"), cache: part("cache") };
    let root = root.map(Path::to_path_buf);
    let mut window = window_with(size.into(), dialogs, move |app, ctx| {
        let mut app = app.keep_in(places.clone(), ctx);
        root.iter().for_each(|root| app.open_library(root, ctx));
        app
    });
    until(&mut window, "the library to be read", |app| app.library().is_none_or(|library| library.progress().is_none()));
    window
}

fn until(window: &mut Window, what: &str, holds: impl Fn(&App) -> bool) {
    let start = Instant::now();
    while !holds(app(window)) {
        let said: Vec<&str> = app(window).messages().iter().map(|message| message.text.as_str()).collect();
        let info = app(window).messages().last_info();
        assert!(start.elapsed() < PATIENCE, "waited in vain for {what}; said: {said:?}, {info}");
        std::thread::sleep(Duration::from_millis(10));
        window.run_steps(1);
    }
    window.run_steps(3);
}

fn has_said(app: &App, text: &str) -> bool {
    app.messages().last_info().contains(text) || app.messages().iter().any(|message| message.text.contains(text))
}

fn press_button(window: &mut Window, name: &str) {
    let at = rect(window, Role::Button, name).center();
    click(window, at);
    window.run_steps(2);
}

/// The name of the only control of a role with a part of a name.
fn name_of(window: &Window, role: Role, part: &str) -> String {
    let found = window.query_all_by_label_contains(part);
    let names: Vec<String> =
        found.map(|node| node.accesskit_node()).filter(|node| node.role() == role).filter_map(|node| node.label()).collect();
    assert_eq!(names.len(), 1, "{part}: {names:?}");
    names[0].clone()
}

fn is_shown(window: &Window, part: &str) -> bool {
    window.query_all_by_label_contains(part).next().is_some()
}

fn type_into(window: &mut Window, field: &str, text: &str) {
    let at = rect(window, Role::TextInput, field).left_center() + vec2(12.0, 0.0);
    click(window, at);
    send(window, [Event::Text(text.to_owned())]);
    window.run_steps(2);
}

fn choose_card(window: &mut Window, name: &str, modifiers: Modifiers) {
    let at = card(window, name).center();
    with_modifiers(window, modifiers, [Event::PointerMoved(at), button(at, true)]);
    with_modifiers(window, modifiers, [button(at, false)]);
    window.run_steps(2);
}

#[test]
fn findings_are_counted_filtered_and_opened() {
    let (root, home) = (folder(&library_files()), tempfile::tempdir().expect("a folder"));
    let report = home.path().join("report.json");
    let mut window = open([1280.0, 720.0], Some(root.path()), home.path(), vec![report.clone()]);
    press(&mut window, Command::ToggleValidation);
    until(&mut window, "the check", |app| app.checked().is_some());
    let checked = app(&window).checked().expect("it is there");
    let errors = checked.rows.iter().filter(|row| row.severity == Severity::Error);
    let errors: Vec<_> = errors.map(|row| (row.path.file_name().and_then(|n| n.to_str()), row.key.as_str())).collect();
    assert_eq!(
        errors,
        [(Some("oak.asm.ron"), "roughness"), (Some("paint.asm.ron"), "base_color"), (Some("wax.asm.ron"), "scatter_distance")]
    );
    assert!(is_shown(&window, "Show errors, 3") && is_shown(&window, "Show pairs, 1"));
    // By words, then by severity.
    type_into(&mut window, "Search findings", "violet nearest");
    assert!(is_shown(&window, "note in violet.asm.ron: base_color") && !is_shown(&window, "error in "));
    press_button(&mut window, "Clear search findings");
    let notes = name_of(&window, Role::Button, "Show notes");
    press_button(&mut window, &notes);
    assert!(!is_shown(&window, "note in ") && is_shown(&window, "error in paint.asm.ron: base_color"));
    // One click shows the card and the whole sentence, a button opens the file.
    type_into(&mut window, "Search findings", "paint");
    let error = name_of(&window, Role::Button, "error in paint.asm.ron");
    press_button(&mut window, &error);
    assert!(app(&window).dock().is_drawn(Pane::Folder));
    let sentence = "1.4 is outside the range 0 to 1";
    assert!(
        window.query_all_by_label_contains(sentence).any(|node| node.accesskit_node().role() == Role::Label),
        "the whole sentence"
    );
    press_button(&mut window, "Open paint.asm.ron at base_color");
    let paint = path(root.path(), "paint");
    until(&mut window, "it to be opened", |app| app.editor().document.path() == Some(&paint));
    // The report is that of the command line.
    press_button(&mut window, "Report of the check");
    assert!(is_shown(&window, &format!("burnish library check {}", root.path().display())));
    press_button(&mut window, "Save report…");
    until(&mut window, "the report", |app| has_said(app, "Wrote "));
    let json: serde_json::Value = serde_json::from_slice(&fs::read(report).expect("a report")).expect("JSON");
    assert_eq!((json["files"].as_u64(), json["errors"].as_u64()), (Some(7), Some(3)));
    assert_eq!(json["pairs"].as_array().map(Vec::len), Some(1));
    // What is mended is found anew by itself.
    set_document(&mut window, |material| _ = material.set(Property::base_color, Value::Color([0.9, 0.2, 0.1])));
    press(&mut window, Command::Save);
    until(&mut window, "the mended file", |app| app.checked().is_some_and(|checked| checked.errors == 2));
}

#[test]
fn without_a_library_the_open_material_is_checked() {
    let home = tempfile::tempdir().expect("a folder");
    let mut window = open([1280.0, 720.0], None, home.path(), Vec::new());
    press(&mut window, Command::ToggleValidation);
    until(&mut window, "the check", |app| app.checked().is_some_and(|checked| checked.files == 1));
    set_document(&mut window, |material| _ = material.set(Property::base_color, Value::Color([1.4, 0.2, 0.1])));
    until(&mut window, "the finding", |app| {
        app.checked().is_some_and(|checked| checked.rows.iter().any(|row| row.key == "base_color" && row.message.contains("1.4")))
    });
}

#[test]
fn a_pair_becomes_one_file_with_both_names_and_two_again() {
    let (root, home) = (folder(&library_files()), tempfile::tempdir().expect("a folder"));
    let mut window = open([1280.0, 900.0], Some(root.path()), home.path(), Vec::new());
    press(&mut window, Command::ToggleValidation);
    until(&mut window, "the check", |app| app.checked().is_some());
    let before = bytes(root.path());
    press_button(&mut window, "Merge gold and gold-old");
    until(&mut window, "the files", |app| has_said(app, "2 files written."));
    let gold = fs::read_to_string(path(root.path(), "gold")).expect("it is there");
    assert!(gold.contains(r#""aliases": ["Old gold"]"#) && gold.starts_with("// kept: Gold\n"), "{gold}");
    assert!(!path(root.path(), "gold-old").exists());
    until(&mut window, "the check", |app| app.checked().is_some_and(|checked| checked.files == 6 && checked.pairs.is_empty()));
    // It is found by its other name.
    type_into(&mut window, "Search library", "old");
    assert!(cards(&window, "Gold").next().is_some());
    key(&mut window, Modifiers::NONE, Key::Escape);
    press(&mut window, Command::Undo);
    until(&mut window, "the files to be as before", |app| has_said(app, "Undid: Merge gold-old into gold"));
    assert!(bytes(root.path()) == before, "every byte is as before");
}

#[test]
fn entries_are_taken_over_in_one_step() {
    let (root, home) = (folder(&library_files()), tempfile::tempdir().expect("a folder"));
    let mut window = open([1280.0, 900.0], Some(root.path()), home.path(), Vec::new());
    let before = bytes(root.path());
    choose_card(&mut window, "Brass", Modifiers::NONE);
    choose_card(&mut window, "Gold", CTRL);
    press(&mut window, Command::ToggleDiff);
    until(&mut window, "the differences", |app| !app.compared().is_empty());
    let keys: Vec<&str> = app(&window).compared().iter().map(|change| change.key.as_str()).collect();
    assert_eq!(keys, ["name", "base_color", "roughness"]);
    press_button(&mut window, "Take B’s roughness");
    until(&mut window, "the file", |app| has_said(app, "1 file written."));
    let brass = fs::read_to_string(path(root.path(), "brass")).expect("it is there");
    assert!(brass == library_files()[0].1.replace("0.12", "0.2"), "{brass}");
    until(&mut window, "the other differences", |app| app.compared().len() == 2);
    press(&mut window, Command::Undo);
    until(&mut window, "the file to be as before", |app| has_said(app, "Undid"));
    assert!(bytes(root.path()) == before);

    // The open document against what it began with. Three clicks in a moment are not two.
    window.run_steps(60);
    choose_card(&mut window, "Gold", Modifiers::NONE);
    choose_card(&mut window, "Gold", Modifiers::NONE);
    until(&mut window, "it to be opened", |app| app.editor().document.path() == Some(&path(root.path(), "gold")));
    let (opened, began) = (material(&window), text(&window));
    set_document(&mut window, |material| {
        material.set(Property::roughness, Value::Float(0.9)).set(Property::coat, Value::Float(1.0));
    });
    for (combo, choice) in [("Material A", "Gold, as opened"), ("Material B", "Gold")] {
        let at = rect(&window, Role::ComboBox, combo).center();
        click(&mut window, at);
        window.run_steps(2);
        let popup = window.query_all_by_role_and_label(Role::Button, choice).last().expect("it is listed").rect().center();
        click(&mut window, popup);
        window.run_steps(2);
    }
    until(&mut window, "the differences", |app| app.compared().len() == 2);
    press_button(&mut window, "All of A → B");
    assert!(material(&window) == opened && text(&window) == began);
    let label = app(&window).history().undo_label().map(str::to_owned);
    assert_eq!(label.as_deref(), Some("Take 2 entries of Gold, as opened"));
    press(&mut window, Command::Undo);
    assert_eq!(material(&window).float(Property::coat), 1.0);
    // What is drawn can be ended.
    until(&mut window, "both to be drawn", |app| app.picture_difference().is_none());
    let start = Instant::now();
    while window.query_all_by_role_and_label(Role::Button, "End drawing both").next().is_none() {
        assert!(start.elapsed() < PATIENCE, "nothing is drawn");
        std::thread::sleep(Duration::from_millis(10));
        window.run_steps(1);
    }
    press_button(&mut window, "End drawing both");
    assert!(is_shown(&window, "Drawing was ended."));
}

#[test]
fn a_conflict_is_decided_and_written() {
    let version = |roughness: &str, more: &str| file("Wax", &format!(r#""roughness": {roughness}{more}"#));
    let files = [
        ("base", version("0.30", "")),
        ("mine", version("0.40", r#", "coat": 1.0"#)),
        ("theirs", version("0.60", r#", "sheen": 0.5"#)),
    ];
    let (root, home) = (folder(&files), tempfile::tempdir().expect("a folder"));
    let dialogs = files.iter().map(|(name, _)| path(root.path(), name)).collect();
    let mut window = open([1280.0, 720.0], None, home.path(), dialogs);
    press(&mut window, Command::ToggleMerge);
    for combo in ["Merge base", "Merge mine", "Merge theirs"] {
        let at = rect(&window, Role::ComboBox, combo).center();
        click(&mut window, at);
        window.run_steps(2);
        press_button(&mut window, "Choose a file…");
    }
    let start = Instant::now();
    while !is_shown(&window, "1 conflict, 1 to decide; 1 entry taken from theirs") {
        assert!(start.elapsed() < PATIENCE, "no conflict is shown");
        std::thread::sleep(Duration::from_millis(10));
        window.run_steps(1);
    }
    window.run_steps(2);
    let before = bytes(root.path());
    press_button(&mut window, "Open result");
    assert_eq!(app(&window).document_count(), 1, "it is not decided");
    let at = rect(&window, Role::RadioButton, "Roughness: theirs, 0.6").center();
    click(&mut window, at);
    window.run_steps(2);
    press_button(&mut window, "Open result");
    let merged = material(&window);
    let [roughness, coat, sheen] = [Property::roughness, Property::coat, Property::sheen].map(|property| merged.float(property));
    assert_eq!((roughness, coat, sheen), (0.6, 1.0, 0.5));
    let document = &app(&window).editor().document;
    assert!(document.path().is_none() && document.is_modified() && text(&window).starts_with("// kept: Wax"));
    press_button(&mut window, "Write over mine");
    until(&mut window, "the file", |app| has_said(app, "1 file written."));
    let mine = fs::read_to_string(path(root.path(), "mine")).expect("it is there");
    let (read, _) = MaterialFile::parse(&mine).expect("it is a material");
    assert!(*read.material() == merged && mine.contains("\"coat\": 1.0") && mine.starts_with("// kept: Wax"), "{mine}");
    press(&mut window, Command::Undo);
    until(&mut window, "the file to be as before", |app| has_said(app, "Undid: Merge Wax into Wax"));
    assert!(bytes(root.path()) == before);
}

#[test]
fn what_changed_since_a_release_is_listed_and_exported() {
    let (root, home) = (folder(&library_files()), tempfile::tempdir().expect("a folder"));
    let mut old = library_files();
    old.retain(|(name, _)| *name != "violet");
    old[0].1 = old[0].1.replace("0.12", "0.25");
    old[1].1 = old[1].1.replace("\"test\"", "\"test\", \"shop\"");
    old.push(("velvet", file("Velvet", r#""sheen": 1.0"#)));
    let release = folder(&old);
    let notes = home.path().join("changes.md");
    let dialogs = vec![release.path().to_path_buf(), notes.clone()];
    let mut window = open([1280.0, 720.0], Some(root.path()), home.path(), dialogs);
    press(&mut window, Command::Palette);
    send(&mut window, [Event::Text("compare library with a release".to_owned())]);
    window.step();
    key(&mut window, Modifiers::NONE, Key::Enter);
    until(&mut window, "the comparison", |app| app.against().is_some());
    let against = app(&window).against().expect("it is there");
    let changed: Vec<_> =
        against.changed.iter().map(|changed| (changed.path.to_str(), changed.is_by_value, changed.look)).collect();
    let expected = [(Some("brass.asm.ron"), true, LookChange::Unknown), (Some("gold.asm.ron"), false, LookChange::Same(0.0))];
    assert_eq!(changed, expected);
    assert_eq!((against.added.len(), against.removed.len(), against.unchanged), (1, 1, 4));
    assert!(is_shown(&window, "+ violet   new") && is_shown(&window, "− velvet   gone"));
    press_button(&mut window, "Save notes…");
    until(&mut window, "the notes", |app| has_said(app, "Wrote "));
    let text = fs::read_to_string(notes).expect("they are there");
    assert!(text.contains("- `violet.asm.ron`") && text.contains("  - roughness: `0.25` → `0.12`"), "{text}");
    // Both versions of a file beside each other.
    let line = name_of(&window, Role::Button, "brass   changed by value");
    press_button(&mut window, &line);
    until(&mut window, "the differences", |app| app.compared().iter().any(|change| change.key == "roughness"));
    assert!(app(&window).dock().is_drawn(Pane::Diff));
}

#[test]
fn both_are_drawn_and_so_is_their_difference() {
    let stage = burnish::library::setup::Stage::standard().expect("there are scenes");
    let scene = |roughness: f64| {
        let mut material = burnish_material::Material::named("m");
        material.set(Property::metallic, Value::Float(1.0)).set(Property::roughness, Value::Float(roughness));
        let setup = burnish::library::setup::Setup::new(stage.clone(), burnish::library::setup::Frame::default(), Vec::new());
        setup.scene_of(material, TextureSet::new())
    };
    let (smooth, rough) = (scene(0.1), scene(0.9));
    let drawing = Drawing { size: [64, 48], seed: 0, threads: 2, seconds: 1.0, display: Display::default() };
    let mut shares = Vec::new();
    let both = draw([&smooth, &rough], &drawing, &mut |share| shares.push(share), &|| false).expect("nobody cancels");
    assert!(shares.is_sorted() && shares.iter().all(|share| (0.0..=1.0).contains(share)), "{shares:?}");
    let (bytes, width, height) = both.beside_each_other();
    assert_eq!((width, height, bytes.len()), (192, 48 + 16, 3 * 192 * 64));
    let same = draw([&smooth, &smooth], &drawing, &mut |_| {}, &|| false).expect("nobody cancels");
    assert!(both.mean > 0.02 && same.mean < 0.5 * both.mean, "{} {}", both.mean, same.mean);
    assert!(draw([&smooth, &rough], &drawing, &mut |_| {}, &|| true).is_none());
}
