//! A library in the window: searched, selected, edited many at once and taken back, opened, applied, dragged onto the view.

use burnish::app::App;
use burnish::command::Command;
use burnish::dock::Pane;
use burnish::library::shelf::Shelf;
use burnish::library::{LibraryPlaces, State};
use burnish::panels::library::LibraryAction;
use burnish::places::Places;
use burnish_material::{Material, MaterialFile, Property, Value};
use burnish_tests::window::{
    CTRL, Window, app, app_mut, button, card, cards, click, click_secondary, material, press, rect, release, send, window_with,
    with_modifiers,
};
use egui::accesskit::Role;
use egui::{Event, Modifiers, vec2};
use egui_kittest::kittest::Queryable;
use std::fs;
use std::io::Cursor;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Longest wait for anything that happens in the background.
const PATIENCE: Duration = Duration::from_secs(60);
const NAMES: [&str; 5] = ["Brass", "Copper", "Glass", "Gold", "Velvet"];

/// A folder with five materials: three metals with roughness 0.1, 0.2 and 0.4, and a comment in each file.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, metallic, roughness) in
        [("Brass", 1.0, 0.1), ("Copper", 1.0, 0.2), ("Glass", 0.0, 0.0), ("Gold", 1.0, 0.4), ("Velvet", 0.0, 0.9)]
    {
        let mut material = Material::named(name);
        material.set(Property::metallic, Value::Float(metallic));
        material.set(Property::roughness, Value::Float(roughness));
        let text = format!("// kept: {name}\n{}", MaterialFile::new(&material).text());
        fs::write(path(folder.path(), name), text).expect("the folder can be written");
    }
    folder
}

fn path(folder: &Path, name: &str) -> PathBuf {
    folder.join(format!("{name}.asm.ron"))
}

fn bytes(folder: &Path) -> Vec<Option<Vec<u8>>> {
    NAMES.iter().map(|name| fs::read(path(folder, name)).ok()).collect()
}

fn until(window: &mut Window, what: &str, holds: impl Fn(&App) -> bool) {
    let start = Instant::now();
    while !holds(app(window)) {
        assert!(start.elapsed() < PATIENCE, "waited in vain for {what}; said: {:?}", said(window));
        std::thread::sleep(Duration::from_millis(20));
        window.run_steps(1);
    }
    window.run_steps(3);
}

fn said(window: &Window) -> Vec<&str> {
    let messages = app(window).messages();
    messages.iter().map(|message| message.text.as_str()).chain([messages.last_info()]).collect()
}

fn has_said(app: &App, holds: impl Fn(&str) -> bool) -> bool {
    holds(app.messages().last_info()) || app.messages().iter().any(|message| holds(&message.text))
}

/// A window with the folder open as library, everything read, and no pictures made.
fn library(root: &Path, home: &Path) -> Window {
    library_answering(root, home, Vec::new())
}

/// The same, whose dialogs answer with these paths in turn.
fn library_answering(root: &Path, home: &Path, paths: Vec<PathBuf>) -> Window {
    let (root, part) = (root.to_path_buf(), |name: &str| Some(home.join(name)));
    let places = Places { config: part("config"), state: part("state"), cache: part("cache") };
    let mut window = window_with(vec2(1280.0, 900.0), paths, move |app, ctx| {
        let mut app = app.keep_in(places.clone(), ctx);
        app.open_library(&root, ctx);
        app
    });
    until(&mut window, "the library to be read", |app| app.library().is_some_and(|library| library.progress().is_none()));
    window
}

fn is_shown(window: &Window, name: &str) -> bool {
    cards(window, name).next().is_some()
}

fn shown(window: &Window) -> Vec<&'static str> {
    NAMES.into_iter().filter(|name| is_shown(window, name)).collect()
}

fn choose(window: &mut Window, name: &str, modifiers: Modifiers) {
    let at = card(window, name).center();
    with_modifiers(window, modifiers, [Event::PointerMoved(at), button(at, true)]);
    with_modifiers(window, modifiers, [button(at, false)]);
    window.run_steps(2);
}

fn type_into(window: &mut Window, field: &str, text: &str) {
    let at = rect(window, Role::TextInput, field).left_center() + vec2(12.0, 0.0);
    click(window, at);
    send(window, [Event::Text(text.to_owned())]);
    window.run_steps(2);
}

fn press_button(window: &mut Window, name: &str) {
    let at = rect(window, Role::Button, name).center();
    click(window, at);
    window.run_steps(2);
}

#[test]
fn many_files_are_edited_in_one_step_that_is_taken_back() {
    let (folder, home) = (folder(), tempfile::tempdir().expect("a folder"));
    let mut window = library(folder.path(), home.path());
    assert_eq!(shown(&window), NAMES);
    type_into(&mut window, "Search library", "metal rough<0.3");
    assert_eq!(shown(&window), ["Brass", "Copper"]);
    let before = bytes(folder.path());
    choose(&mut window, "Brass", Modifiers::NONE);
    choose(&mut window, "Copper", CTRL);
    press_button(&mut window, "Edit…");
    type_into(&mut window, "Add tags", "measured, worn");
    press_button(&mut window, "Change 2 materials");
    until(&mut window, "the files to be written", |app| has_said(app, |text| text.ends_with("2 files written.")));
    let after = bytes(folder.path());
    let changed: Vec<&str> = (0..5).filter(|i| after[*i] != before[*i]).map(|i| NAMES[i]).collect();
    assert_eq!(changed, ["Brass", "Copper"]);
    let brass = fs::read_to_string(path(folder.path(), "Brass")).expect("it is there");
    assert!(brass.starts_with("// kept: Brass") && brass.contains("\"tags\": [\"measured\", \"worn\"]"), "{brass}");
    until(&mut window, "the library to be read", |app| app.library().is_some_and(|library| library.progress().is_none()));
    press(&mut window, Command::Undo);
    until(&mut window, "the files to be as before", |app| has_said(app, |text| text.starts_with("Undid")));
    assert!(bytes(folder.path()) == before, "every byte is as before");
    press(&mut window, Command::Redo);
    until(&mut window, "the files to be edited again", |app| has_said(app, |text| text.starts_with("Redid")));
    assert!(bytes(folder.path()) == after);
}

#[test]
fn after_an_edit_of_the_material_undo_is_about_that() {
    let (folder, home) = (folder(), tempfile::tempdir().expect("a folder"));
    let mut window = library(folder.path(), home.path());
    let before = bytes(folder.path());
    let ctx = window.ctx.clone();
    app_mut(&mut window).do_in_library(LibraryAction::Duplicate(vec!["Gold.asm.ron".into()]), &ctx);
    until(&mut window, "the copy", |_| path(folder.path(), "Gold copy").exists());
    until(&mut window, "it to be said", |app| has_said(app, |text| text.ends_with("1 file written.")));
    app_mut(&mut window).editor_mut().document.material.set(Property::roughness, Value::Float(0.77));
    window.run_steps(3);
    press(&mut window, Command::Undo);
    assert!(material(&window).float(Property::roughness) != 0.77);
    assert!(path(folder.path(), "Gold copy").exists(), "the files were not edited last");
    app_mut(&mut window).do_in_library(LibraryAction::Undo, &ctx);
    until(&mut window, "the copy to be gone", |_| !path(folder.path(), "Gold copy").exists());
    assert!(bytes(folder.path()) == before);
}

#[test]
fn a_file_is_opened_applied_and_renamed() {
    let (folder, home) = (folder(), tempfile::tempdir().expect("a folder"));
    let mut window = library(folder.path(), home.path());
    // The menu of a card.
    let at = card(&window, "Velvet").center();
    click_secondary(&mut window, at);
    window.run_steps(2);
    press_button(&mut window, "Apply to this material");
    until(&mut window, "it to be applied", |app| !app.is_loading() && app.editor().document.material.name == "Velvet");
    assert!(app(&window).editor().document.path().is_none(), "it is no open file");
    press(&mut window, Command::Undo);
    assert!(material(&window).name != "Velvet");
    // Dragged onto the view.
    let (from, to) = (card(&window, "Gold").center(), egui::pos2(500.0, 400.0));
    send(&mut window, [Event::PointerMoved(from), button(from, true)]);
    for part in [0.1, 0.5, 1.0] {
        send(&mut window, [Event::PointerMoved(from + part * (to - from))]);
    }
    release(&mut window);
    until(&mut window, "it to be applied", |app| !app.is_loading() && app.editor().document.material.name == "Gold");
    // Two clicks open it.
    choose(&mut window, "Copper", Modifiers::NONE);
    choose(&mut window, "Copper", Modifiers::NONE);
    until(&mut window, "it to be opened", |app| app.editor().document.path() == Some(&*path(folder.path(), "Copper")));
    // Another name, for the file as well.
    let ctx = window.ctx.clone();
    app_mut(&mut window).do_in_library(LibraryAction::Rename("Glass.asm.ron".into()), &ctx);
    window.run_steps(3);
    send(&mut window, [Event::Text(" green".to_owned())]);
    press_button(&mut window, "Rename");
    until(&mut window, "the new name", |_| path(folder.path(), "Glass green").exists());
    assert!(!path(folder.path(), "Glass").exists());
}

#[test]
fn a_measurement_becomes_a_file_and_the_library_comes_back() {
    let (folder, home) = (folder(), tempfile::tempdir().expect("a folder"));
    let mut window = library(folder.path(), home.path());
    let silver = burnish_presets::measured::find("silver").expect("it was measured");
    let ctx = window.ctx.clone();
    app_mut(&mut window).new_from_measured(silver, &ctx);
    let file = path(folder.path(), silver.name);
    until(&mut window, "the file", |_| file.exists());
    let (silver_file, warnings) =
        MaterialFile::parse(&fs::read_to_string(&file).expect("it is there")).expect("it is a material");
    assert!(warnings.is_empty() && silver_file.material().float(Property::metallic) == 1.0);
    drop(window);
    // The next window has the library that was open.
    let part = |name: &str| Some(home.path().join(name));
    let places = Places { config: part("config"), state: part("state"), cache: part("cache") };
    let mut window = window_with(vec2(1280.0, 900.0), Vec::new(), move |app, ctx| app.keep_in(places.clone(), ctx));
    app_mut(&mut window).dock_mut().set_shown(Pane::Folder, true);
    until(&mut window, "the library to be read", |app| {
        app.library().is_some_and(|l| l.progress().is_none() && l.entries().len() == 6)
    });
}

#[test]
fn a_query_that_means_nothing_says_so() {
    let (folder, home) = (folder(), tempfile::tempdir().expect("a folder"));
    let mut window = library(folder.path(), home.path());
    type_into(&mut window, "Search library", "metal rouhg<0.3");
    assert!(window.query_all_by_label_contains("rouhg").next().is_some());
    assert_eq!(shown(&window), ["Brass", "Copper", "Gold"], "what is understood holds");
    fs::remove_dir_all(folder.path()).expect("it can be removed");
    let ctx = window.ctx.clone();
    app_mut(&mut window).do_in_library(LibraryAction::Rescan, &ctx);
    until(&mut window, "the missing folder to be noticed", |app| has_said(app, |text| text.contains("expected a folder")));
}

#[test]
fn drafts_say_that_the_full_picture_is_still_to_come() {
    let (folder, home) = (folder(), tempfile::tempdir().expect("a folder"));
    let mut window = library(folder.path(), home.path());
    let is_draft = |app: &App| {
        let library = app.library().expect("it is open");
        // The first of five: no full picture is begun before all of them are there.
        library.entries().iter().any(|entry| library.state(entry) == State::Draft)
    };
    until(&mut window, "a draft", is_draft);
    assert!(window.query_all_by_label_contains(", draft: the full picture is still to come").next().is_some());
    assert_eq!(shown(&window), NAMES, "drafts have their names");
    type_into(&mut window, "Search library", "is:draft");
    assert!(!shown(&window).is_empty());
    let at = card(&window, shown(&window)[0]).center();
    send(&mut window, [Event::PointerMoved(at)]);
    // It comes after a moment.
    window.run_steps(60);
    assert!(window.query_all_by_label("draft: the full picture is still to come").next().is_some());
}

/// Puts small pictures there as if they had been made.
fn give_pictures(window: &mut Window, root: &Path, home: &Path) {
    until(window, "the setup", |app| app.library().is_some_and(|library| library.setup().is_some()));
    let cache = Some(home.join("cache"));
    let folder = LibraryPlaces::of(root, &Places { cache, ..Places::default() }).pictures.expect("there is a cache");
    let mut png = Cursor::new(Vec::new());
    image::RgbImage::from_pixel(8, 8, image::Rgb([200, 40, 40])).write_to(&mut png, image::ImageFormat::Png).expect("it fits");
    let library = app(window).library().expect("it is open");
    let setup = library.setup().expect("it is there").digest();
    let mut shelf = Shelf::open(&folder);
    for entry in library.entries() {
        shelf.put(entry.look, setup, png.get_ref()).expect("the cache can be written");
    }
}

/// Opens the page, switches a format, and goes on to the place of the pack.
fn export_pack(window: &mut Window, switched: Option<&str>) {
    let ctx = window.ctx.clone();
    app_mut(window).carry_out(Command::ExportPack, &ctx);
    window.run_steps(3);
    for (role, name) in switched.map(|name| (Role::CheckBox, name)).into_iter().chain([(Role::Button, "Export…")]) {
        let at = rect(window, role, name).center();
        click(window, at);
        window.run_steps(2);
    }
}

#[test]
fn the_library_becomes_a_sheet_and_a_pack() {
    let (folder, home, out) = (folder(), tempfile::tempdir().expect("a folder"), tempfile::tempdir().expect("a folder"));
    let (sheet, pack) = (out.path().join("all"), out.path().join("pack"));
    let answers = vec![sheet.clone(), folder.path().join("inside"), pack.clone(), pack.clone()];
    let mut window = library_answering(folder.path(), home.path(), answers);
    give_pictures(&mut window, folder.path(), home.path());
    let ctx = window.ctx.clone();
    app_mut(&mut window).carry_out(Command::ContactSheet, &ctx);
    until(&mut window, "the sheet", |app| has_said(app, |text| text.contains("all.html: 5 materials")));
    let page = fs::read_to_string(sheet.with_extension("html")).expect("it was written");
    assert_eq!(page.matches("data:image/jpeg").count(), 5);
    export_pack(&mut window, None);
    until(&mut window, "the refusal", |app| has_said(app, |text| text.contains("outside the library's folder")));
    export_pack(&mut window, Some("MaterialX (.mtlx)"));
    until(&mut window, "the pack", |app| has_said(app, |text| text.contains("materials 5, images 0, files 21")));
    let expected = ["materials/Gold.asm.ron", "LICENCES.md", "losses.json", "usd/Gold.usda", "gltf/Velvet.gltf"];
    assert!(expected.iter().all(|file| pack.join(file).is_file()) && !pack.join("materialx").exists());

    // A value out of range is not handed out.
    fs::write(path(folder.path(), "Velvet"), "{\"properties\": {\"roughness\": 1.5}}").expect("it can be written");
    app_mut(&mut window).do_in_library(LibraryAction::Rescan, &ctx);
    until(&mut window, "the library to be read", |app| app.library().is_some_and(|library| library.progress().is_none()));
    export_pack(&mut window, None);
    until(&mut window, "the refusal", |app| has_said(app, |text| text.contains("the check finds errors (1); the first: ")));
}
