//! Documents over their lives: tabs, sides, files that other programs change, texture sets, what is kept for the next time and after a crash.

use burnish::app::App;
use burnish::command::Command;
use burnish::places::Places;
use burnish_material::{Channel, Material, MaterialFile, Property, Slot, TextureRef, Value};
use burnish_tests::window::{Window, app, app_mut, material, window_with};
use egui::vec2;
use egui_kittest::kittest::Queryable;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Longest wait for anything that happens in the background.
const PATIENCE: Duration = Duration::from_secs(60);

fn places(folder: &Path) -> Places {
    let part = |name: &str| Some(folder.join(name));
    Places { config: part("config"), state: part("state"), cache: part("cache") }
}

/// A window that keeps what it remembers in `folder`, and answers dialogs with `paths`.
fn window(folder: &Path, paths: Vec<PathBuf>) -> Window {
    let places = places(folder);
    window_with(vec2(1280.0, 1600.0), paths, move |app, ctx| app.keep_in(places.clone(), ctx))
}

fn until(window: &mut Window, what: &str, holds: impl Fn(&App) -> bool) {
    let start = Instant::now();
    while !holds(app(window)) {
        assert!(start.elapsed() < PATIENCE, "waited in vain for {what}");
        std::thread::sleep(Duration::from_millis(20));
        window.run_steps(1);
    }
    window.run_steps(2);
}

fn carry_out(window: &mut Window, command: Command) {
    let ctx = window.ctx.clone();
    app_mut(window).carry_out(command, &ctx);
    window.run_steps(2);
}

fn set(window: &mut Window, property: Property, value: f64) {
    app_mut(window).editor_mut().document.material.set(property, Value::Float(value));
    window.run_steps(3);
}

fn open(window: &mut Window, path: &Path) {
    let ctx = window.ctx.clone();
    app_mut(window).load_path(path, &ctx);
    window.run_steps(1);
    until(window, "the file", |app| !app.is_loading());
}

fn write_material(path: &Path, roughness: f64) {
    let mut material = Material::named(path.file_stem().unwrap_or_default().to_string_lossy());
    material.set(Property::roughness, Value::Float(roughness));
    std::fs::write(path, MaterialFile::new(&material).text()).expect("the folder can be written");
}

fn write_image(path: &Path, value: u8) {
    image::RgbImage::from_pixel(4, 4, image::Rgb([value; 3])).save(path).expect("the folder can be written");
}

#[test]
fn tabs_keep_their_own_histories() {
    let folder = tempfile::tempdir().unwrap();
    let [a, b] = ["a.asm.ron", "b.asm.ron"].map(|name| folder.path().join(name));
    write_material(&a, 0.1);
    write_material(&b, 0.2);
    let mut window = window(folder.path(), Vec::new());
    open(&mut window, &a);
    assert_eq!(app(&window).document_count(), 1, "takes the place of the untouched new one");
    set(&mut window, Property::coat, 0.5);
    open(&mut window, &b);
    assert_eq!((app(&window).document_count(), material(&window).float(Property::roughness)), (2, 0.2));
    set(&mut window, Property::coat, 0.75);
    set(&mut window, Property::metallic, 1.0);

    carry_out(&mut window, Command::PreviousTab);
    assert_eq!((material(&window).float(Property::roughness), material(&window).float(Property::coat)), (0.1, 0.5));
    carry_out(&mut window, Command::Undo);
    assert_eq!(material(&window).float(Property::coat), 0.0);
    assert!(app(&window).history().undo_label().is_none());
    carry_out(&mut window, Command::NextTab);
    assert_eq!(material(&window).float(Property::metallic), 1.0);
    assert_eq!(app(&window).history().labels().count(), 3);
    // A file that is open comes to the front instead of opening twice, unless it has changes.
    open(&mut window, &a);
    assert_eq!((app(&window).document_count(), material(&window).float(Property::roughness)), (2, 0.1));
}

#[test]
fn sides_are_stored_flipped_and_undone() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = window(folder.path(), Vec::new());
    set(&mut window, Property::roughness, 0.2);
    carry_out(&mut window, Command::StoreSide);
    set(&mut window, Property::roughness, 0.8);
    carry_out(&mut window, Command::FlipSides);
    assert_eq!((material(&window).float(Property::roughness), app(&window).sides().letters()), (0.2, ("A", "B")));
    carry_out(&mut window, Command::FlipSides);
    assert_eq!((material(&window).float(Property::roughness), app(&window).sides().letters()), (0.8, ("B", "A")));
    carry_out(&mut window, Command::CompareSides);
    assert!(app(&window).editor().view.compares_sides);
    for _ in 0..3 {
        carry_out(&mut window, Command::Undo);
    }
    assert_eq!(material(&window).float(Property::roughness), 0.2);
}

#[test]
fn a_file_changed_outside_is_offered_and_never_taken_unasked() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("shared.asm.ron");
    write_material(&path, 0.1);
    let mut window = window(folder.path(), Vec::new());
    open(&mut window, &path);
    set(&mut window, Property::coat, 0.5);
    for (answer, roughness, coat, compares) in
        [("Keep what is here", 0.1, 0.5, false), ("Compare", 0.1, 0.5, true), ("Reload", 0.3, 0.0, true)]
    {
        write_material(&path, 0.3);
        let start = Instant::now();
        while window.query_by_label(answer).is_none() {
            assert!(start.elapsed() < PATIENCE, "nobody asked: {answer}");
            std::thread::sleep(Duration::from_millis(50));
            window.run_steps(1);
        }
        window.get_by_label(answer).click();
        window.run_steps(2);
        until(&mut window, "the answer", |app| !app.is_loading());
        assert_eq!(material(&window).float(Property::roughness), roughness, "{answer}");
        assert_eq!(material(&window).float(Property::coat), coat, "{answer}");
        assert_eq!(app(&window).editor().view.compares_sides, compares, "{answer}");
        // Looks are half a second apart, and a file has a time of its own only from then on.
        std::thread::sleep(Duration::from_millis(1200));
    }
    carry_out(&mut window, Command::Undo);
    assert_eq!(material(&window).float(Property::coat), 0.5, "reloading is one step");
}

#[test]
fn what_this_program_saves_is_no_change_from_outside() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("own.asm.ron");
    write_material(&path, 0.1);
    let mut window = window(folder.path(), Vec::new());
    open(&mut window, &path);
    set(&mut window, Property::coat, 0.5);
    carry_out(&mut window, Command::Save);
    let start = Instant::now();
    while start.elapsed() < Duration::from_secs(3) {
        std::thread::sleep(Duration::from_millis(100));
        window.run_steps(1);
        assert!(window.query_by_label("Reload").is_none());
    }
}

#[test]
fn maps_are_read_again_when_another_program_saves_them() {
    let folder = tempfile::tempdir().unwrap();
    let [path, map] = ["mapped.asm.ron", "gloss.png"].map(|name| folder.path().join(name));
    write_image(&map, 10);
    let mut material = Material::named("mapped");
    material.slot_mut(Property::roughness).texture = Some(TextureRef::new("gloss.png"));
    std::fs::write(&path, MaterialFile::new(&material).text()).unwrap();
    let mut window = window(folder.path(), Vec::new());
    open(&mut window, &path);
    let value = |app: &App| app.editor().document.textures.get("gloss.png").map(|image| (image.texels[0][0] * 255.0).round());
    assert_eq!(value(app(&window)), Some(10.0));
    // Long enough for the first look at the file.
    std::thread::sleep(Duration::from_millis(1200));
    window.run_steps(2);
    write_image(&map, 200);
    until(&mut window, "the new image", |app| value(app) == Some(200.0));
    assert!(!app(&window).editor().document.is_modified());
}

#[test]
fn a_folder_of_images_becomes_the_maps_it_is_named_after() {
    let folder = tempfile::tempdir().unwrap();
    let set = folder.path().join("oak");
    std::fs::create_dir(&set).unwrap();
    for name in ["oak_BaseColor.png", "oak_Roughness.png", "oak_Normal.png", "readme.txt"] {
        if name.ends_with("png") { write_image(&set.join(name), 128) } else { std::fs::write(set.join(name), "x").unwrap() }
    }
    let mut window = window(folder.path(), vec![set.clone()]);
    carry_out(&mut window, Command::LoadTextureSet);
    until(&mut window, "the set", |app| !app.is_loading() && app.history().undo_label().is_some());
    for property in [Property::base_color, Property::roughness, Property::normal] {
        let texture = material(&window).slot(property).texture.clone().expect("it has a map");
        assert!(app(&window).editor().document.textures.contains_key(&texture.path));
    }
    assert_eq!(material(&window).slot(Property::base_color).texture.as_ref().map(|t| t.channel), Some(Channel::Rgb));
    carry_out(&mut window, Command::Undo);
    assert!(material(&window).slots().all(|(_, slot)| *slot == Slot::default()), "one step");
}

#[test]
fn preferences_layout_and_recent_files_come_back() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.asm.ron");
    write_material(&path, 0.1);
    let mut first = window(folder.path(), Vec::new());
    open(&mut first, &path);
    carry_out(&mut first, Command::Preferences);
    first.get_by_label("Limit threads").click();
    first.run_steps(3);
    carry_out(&mut first, Command::ToggleHistory);
    assert!(app(&first).dock().is_drawn(burnish::dock::Pane::History));
    eframe::App::on_exit(app_mut(&mut first));
    drop(first);
    let mut second = window(folder.path(), Vec::new());
    assert_eq!(app(&second).preferences().threads, Some(1));
    assert!(app(&second).dock().is_drawn(burnish::dock::Pane::History));
    carry_out(&mut second, Command::OpenRecent);
    second.key_press(egui::Key::Enter);
    second.run_steps(2);
    until(&mut second, "the recent file", |app| app.editor().document.path().is_some());
    assert_eq!(material(&second).float(Property::roughness), 0.1);
}

#[test]
fn unsaved_work_is_offered_after_a_crash() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.asm.ron");
    write_material(&path, 0.1);
    let mut first = window(folder.path(), Vec::new());
    open(&mut first, &path);
    set(&mut first, Property::coat, 0.5);
    carry_out(&mut first, Command::New);
    set(&mut first, Property::metallic, 1.0);
    // Longer than the pause between two writings.
    let start = Instant::now();
    while start.elapsed() < Duration::from_secs(5) {
        std::thread::sleep(Duration::from_millis(100));
        first.run_steps(1);
    }
    // Not closed in order: what was unsaved stays.
    drop(first);
    let mut second = window(folder.path(), Vec::new());
    second.get_by_label("Bring back").click();
    second.run_steps(2);
    until(&mut second, "both documents", |app| app.document_count() == 2 && !app.is_loading());
    let mut found = Vec::new();
    for _ in 0..2 {
        let document = &app(&second).editor().document;
        assert!(document.is_modified());
        found.push((
            document.material.float(Property::coat),
            document.material.float(Property::metallic),
            document.path().is_some(),
        ));
        carry_out(&mut second, Command::NextTab);
    }
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    assert_eq!(found, [(0.0, 1.0, false), (0.5, 0.0, true)]);
}
