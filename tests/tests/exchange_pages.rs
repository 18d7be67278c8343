//! The window and other formats: the material in front is exported from a page that tells what it costs, and comes back with the mesh.

use burnish::command::Command;
use burnish::places::Places;
use burnish_material::{Property, Value};
use burnish_tests::export_panel::{errors, press_button, until};
use burnish_tests::window::{Window, app, app_mut, set_document, settle, window_with};
use egui::accesskit::Role;
use egui::vec2;
use egui_kittest::kittest::Queryable;
use std::fs;
use std::path::{Path, PathBuf};

fn window(paths: Vec<PathBuf>) -> Window {
    window_with(vec2(1280.0, 1000.0), paths, |app, _| app)
}

fn open(window: &mut Window, path: &Path) {
    let ctx = window.ctx.clone();
    app_mut(window).load_path(path, &ctx);
    settle(window);
}

#[test]
fn a_material_is_exported_with_its_mesh_and_comes_back() {
    let folder = tempfile::tempdir().expect("a folder");
    let glb = folder.path().join("red.glb");
    let mut first = window(vec![glb.clone()]);
    set_document(&mut first, |material| {
        material.name = "Red".to_owned();
        material.set(Property::roughness, Value::Float(0.1 + 0.2)).set(Property::scatter_red_shift, Value::Float(0.5));
    });
    let ctx = first.ctx.clone();
    app_mut(&mut first).carry_out(Command::ExportMaterial, &ctx);
    first.run_steps(3);
    // What glTF cannot say stands there before anything is written.
    assert!(first.query_by_label("dropped").is_some(), "the sheet names what is lost");
    press_button(&mut first, "Export…");
    until(&mut first, "the file", |app| app.messages().last_info().starts_with("Exported "));
    assert!(fs::read(&glb).is_ok_and(|bytes| bytes.starts_with(b"glTF")), "{:?}", errors(&first));

    let mut second = window(Vec::new());
    open(&mut second, &glb);
    assert_eq!(errors(&second), [""; 0]);
    let material = &app(&second).editor().document.material;
    assert_eq!((material.name.as_str(), material.float(Property::roughness)), ("Red", 0.1 + 0.2));
    assert_eq!(material.float(Property::scatter_red_shift), 0.5);
    assert_eq!(app(&second).editor().model.as_ref().map(|model| model.name.as_str()), Some("red"));
    assert!(!app(&second).editor().document.is_modified() && app(&second).editor().document.path().is_none());
}

#[test]
fn an_image_inside_of_a_file_is_written_when_its_material_is_saved() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    image::save_buffer(at("rough.png"), &[0, 80, 160, 240], 2, 2, image::ExtendedColorType::L8).expect("a file");
    let text = r#"{ "asm": "4.0", "name": "Map", "properties": { "roughness": { "texture": { "path": "rough.png" } } } }"#;
    fs::write(at("map.asm.ron"), text).expect("a file");
    let glb = at("map.glb");
    let mut first = window(vec![glb.clone()]);
    open(&mut first, &at("map.asm.ron"));
    let ctx = first.ctx.clone();
    app_mut(&mut first).carry_out(Command::ExportMaterial, &ctx);
    first.run_steps(3);
    press_button(&mut first, "Export…");
    until(&mut first, "the file", |app| app.messages().last_info().starts_with("Exported "));

    let elsewhere = at("elsewhere");
    fs::create_dir(&elsewhere).expect("a folder");
    fs::copy(&glb, elsewhere.join("map.glb")).expect("a copy");
    let saved = elsewhere.join("saved.asm.ron");
    let mut second = window(vec![saved.clone()]);
    open(&mut second, &elsewhere.join("map.glb"));
    assert_eq!(app(&second).editor().document.textures.len(), 1, "{:?}", app(&second).messages());
    let ctx = second.ctx.clone();
    app_mut(&mut second).carry_out(Command::SaveAs, &ctx);
    second.run_steps(5);
    assert_eq!(errors(&second), [""; 0]);
    let text = fs::read_to_string(&saved).expect("it was saved");
    let image = fs::read_dir(&elsewhere).expect("a folder").flatten().find(|entry| {
        let name = entry.file_name().to_string_lossy().into_owned();
        name.ends_with(".png") && text.contains(&name)
    });
    assert!(image.is_some(), "{text}");
}

#[test]
fn a_broken_file_is_one_sentence_and_changes_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut window = window(Vec::new());
    let before = app(&window).editor().document.material.clone();
    for (name, text) in [("a.gltf", "{"), ("b.mtlx", "<materialx"), ("c.usda", "#usda 1.0\ndef"), ("d.usdz", "PK"), ("e.mdl", "")]
    {
        let path = folder.path().join(name);
        fs::write(&path, text).expect("a file");
        open(&mut window, &path);
        let errors = errors(&window);
        assert!(errors.last().is_some_and(|sentence| sentence.contains(name)), "{name}: {errors:?}");
    }
    assert_eq!(app(&window).editor().document.material, before);
}

#[test]
fn an_import_is_told_of_and_can_be_ended() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("large.gltf");
    // Long enough to be ended.
    let name = "x".repeat(40_000_000);
    fs::write(&path, format!(r#"{{"asset":{{"version":"2.0","generator":"{name}"}},"materials":[{{"name":"One"}}]}}"#))
        .expect("a file");
    let mut window = window(Vec::new());
    let before = app(&window).editor().document.material.clone();
    let ctx = window.ctx.clone();
    app_mut(&mut window).load_path(&path, &ctx);
    window.run_steps(1);
    press_button(&mut window, "Work: Loading large.gltf…");
    window.run_steps(2);
    press_button(&mut window, "End Loading large.gltf…");
    window.run_steps(2);
    assert_eq!(app(&window).messages().last_info(), "Loading was ended.");
    std::thread::sleep(std::time::Duration::from_secs(1));
    settle(&mut window);
    assert_eq!(app(&window).editor().document.material, before);
    // The next one comes as ever.
    fs::write(&path, r#"{"asset":{"version":"2.0"},"materials":[{"name":"Two"}]}"#).expect("a file");
    open(&mut window, &path);
    assert_eq!(app(&window).editor().document.material.name, "Two");
    let info = app(&window).messages().last_info();
    assert!(info.contains("1 material, ") && info.contains(" of 40 properties set"), "{info}");
}

#[test]
fn every_material_of_a_file_gets_a_tab_that_nothing_takes_the_place_of() {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, materials: &[&str]| {
        let materials: Vec<String> = materials.iter().map(|name| format!(r#"{{"name":"{name}"}}"#)).collect();
        let path = folder.path().join(name);
        fs::write(&path, format!(r#"{{"asset":{{"version":"2.0"}},"materials":[{}]}}"#, materials.join(","))).expect("a file");
        path
    };
    let mut window = window(Vec::new());
    open(&mut window, &write("a.gltf", &["Body", "Lid", "Label"]));
    open(&mut window, &write("b.gltf", &["Other"]));
    for tab in ["Body", "Lid", "Label", "Other"] {
        assert!(window.query_by_role_and_label(Role::Tab, tab).is_some(), "{tab}");
    }
    assert!(window.query_by_role_and_label(Role::Tab, "New material").is_none(), "it was untouched");
    assert_eq!(app(&window).editor().document.import(), Some(folder.path().join("b.gltf").as_path()));
}

#[test]
fn images_inside_of_a_file_survive_a_crash() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("map.gltf");
    let image = "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAAAAAA6fptVAAAACklEQVR4nGNoAAAAggCBd81ytgAAAABJRU5ErkJggg==";
    let text = format!(
        r#"{{"asset":{{"version":"2.0"}},"images":[{{"uri":"data:image/png;base64,{image}"}}],"textures":[{{"source":0}}],
            "materials":[{{"name":"Map","pbrMetallicRoughness":{{"baseColorTexture":{{"index":0}}}}}}]}}"#
    );
    fs::write(&path, text).expect("a file");
    let state = folder.path().to_path_buf();
    let window = || {
        window_with(vec2(1280.0, 1000.0), Vec::new(), {
            let state = state.clone();
            let places = |folder: &Path| Places { config: None, state: Some(folder.to_path_buf()), cache: None };
            move |app, ctx| app.keep_in(places(&state), ctx)
        })
    };
    let mut first = window();
    open(&mut first, &path);
    set_document(&mut first, |material| _ = material.set(Property::coat, Value::Float(0.5)));
    until(&mut first, "a copy on disk", |_| {
        fs::read_dir(state.join("recovery")).is_ok_and(|mut processes| {
            processes.any(|process| fs::read_dir(process.expect("a folder").path()).is_ok_and(|files| files.count() > 1))
        })
    });
    drop(first);
    let mut second = window();
    second.get_by_label("Bring back").click();
    second.run_steps(2);
    until(&mut second, "the image", |app| app.editor().document.textures.len() == 1);
    assert_eq!(errors(&second), [""; 0]);
    let document = &app(&second).editor().document;
    assert_eq!((document.embedded().count(), document.import()), (1, Some(path.as_path())));
    assert!(document.is_modified() && document.material.float(Property::coat) == 0.5);
}

#[test]
fn the_model_of_a_format_is_chosen_on_the_page() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("red.mtlx");
    let mut window = window(vec![path.clone()]);
    let ctx = window.ctx.clone();
    app_mut(&mut window).carry_out(Command::ExportMaterial, &ctx);
    window.run_steps(3);
    assert!(window.query_by_label("Model of the export").is_none(), "glTF is one model");
    for (list, entry) in [("Format of the export", "MaterialX (.mtlx)"), ("Model of the export", "Standard Surface")] {
        window.get_by_label(list).click();
        window.run_steps(3);
        window.get_by_label(entry).click();
        window.run_steps(3);
    }
    press_button(&mut window, "Export…");
    until(&mut window, "the file", |app| app.messages().last_info().starts_with("Exported "));
    let text = fs::read_to_string(&path).expect("it was written");
    assert!(text.contains("<standard_surface "), "{text}");
}
