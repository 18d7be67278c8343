//! Pictures that come back: a dropped picture opens its material, and what is no picture of ours keeps its meaning. Parts of large previews fit.

use burnish::export::{Picture, write};
use burnish::files::FilesError;
use burnish::picture_file::{MAX_JOB_BYTES, PictureError, embedded_material};
use burnish::picture_job::PictureJob;
use burnish_assets::make_shape;
use burnish_material::{Material, Property, Value};
use burnish_renderer::preview::{Crop, Preview};
use burnish_renderer::scene::{ModelMeshes, Scene};
use burnish_renderer::tonemap::Display;
use burnish_tests::gpu::device;
use burnish_tests::scenes::environment;
use burnish_tests::window::{Window, app, app_mut, settle, window_of};
use egui::vec2;
use std::path::Path;
use std::sync::Arc;

/// A file that only its own bytes are equal to: comments, an unknown key, odd spaces.
const TEXT: &str = "{\n  // how it came about: Käse 🧀\n  \"asm\": \"4.0\",\n  \"name\" : \"Cheese\",\n  \"properties\": { \"roughness\":0.250, \"velvet\": 1 },\n}\n";

fn picture(job: Option<serde_json::Value>) -> Picture {
    Picture { width: 4, height: 2, pixels: vec![[0.5, 0.25, 0.0, 1.0]; 8], job, ..Picture::default() }
}

fn job(material: &str) -> serde_json::Value {
    PictureJob { material: Some(material.to_owned()), ..PictureJob::new() }.json()
}

fn drop_on(window: &mut Window, path: &Path) {
    let ctx = window.ctx.clone();
    app_mut(window).load_path(path, &ctx);
    settle(window);
}

#[test]
fn a_dropped_picture_opens_its_material_and_foreign_ones_keep_their_meaning() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = window_of(vec2(900.0, 700.0), Vec::new());
    for ending in ["png", "exr"] {
        let path = folder.path().join(format!("ours.{ending}"));
        write(&path, &picture(Some(job(TEXT))), Display::default()).unwrap();
        assert_eq!(embedded_material(&path).unwrap().as_deref(), Some(TEXT.as_bytes()), "{ending}");
        app_mut(&mut window).editor_mut().document.material = Material::named("another");
        let before = app(&window).document_count();
        let light = app(&window).editor().environment.clone();
        drop_on(&mut window, &path);
        let document = &app(&window).editor().document;
        assert_eq!((document.file().text(), document.title().as_str()), (TEXT, "Cheese"), "{ending}");
        assert!(document.path().is_none() && !document.is_modified(), "the picture is not what is saved to");
        assert!(app(&window).document_count() > before, "what was there stays");
        assert!(Arc::ptr_eq(light.as_ref().unwrap(), app(&window).editor().environment.as_ref().unwrap()), "it is no light");
    }
    // The same without a job: an environment, and a photo.
    let documents = app(&window).document_count();
    let [light, photo] = ["light.exr", "photo.png"].map(|name| folder.path().join(name));
    write(&light, &picture(None), Display::default()).unwrap();
    write(&photo, &picture(None), Display::default()).unwrap();
    assert!(matches!((embedded_material(&light), embedded_material(&photo)), (Ok(None), Ok(None))));
    drop_on(&mut window, &light);
    drop_on(&mut window, &photo);
    assert_eq!(app(&window).editor().environment.as_ref().map(|environment| environment.name.as_str()), Some("light"));
    assert!(app(&window).dock().is_drawn(burnish::dock::Pane::Reference));
    assert_eq!(app(&window).document_count(), documents);
}

#[test]
fn words_that_are_no_job_or_too_many_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    for ending in ["png", "exr"] {
        let path = folder.path().join(format!("a.{ending}"));
        write(&path, &picture(Some("no job".into())), Display::default()).unwrap();
        assert!(matches!(embedded_material(&path), Err(PictureError::Job { .. })), "{ending}");
        // Of a picture that never had a material there is none, and that is no error.
        write(&path, &picture(Some(PictureJob::new().json())), Display::default()).unwrap();
        assert!(matches!(embedded_material(&path), Ok(None)), "{ending}");
        // 100 MB, in a PNG of some kilobytes.
        write(&path, &picture(Some(job(&"x".repeat(100_000_000)))), Display::default()).unwrap();
        let error = embedded_material(&path).expect_err("too long");
        assert!(matches!(error, PictureError::JobTooLarge { .. }), "{ending}: {error}");
        assert!(error.to_string().contains(&format!("a.{ending}: expected at most {} MiB", MAX_JOB_BYTES >> 20)), "{error}");
        // Cut anywhere, it is refused or holds nothing, and never ends the program.
        write(&path, &picture(Some(job(TEXT))), Display::default()).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        for length in (0..bytes.len()).step_by(37) {
            std::fs::write(&path, &bytes[..length]).unwrap();
            if let Ok(Some(material)) = embedded_material(&path) {
                assert_eq!(material, TEXT.as_bytes());
            }
        }
        let mut damaged = bytes.clone();
        for at in (0..bytes.len()).step_by(11) {
            damaged[at] ^= 0x55;
            std::fs::write(&path, &damaged).unwrap();
            let _ = embedded_material(&path);
            damaged[at] = bytes[at];
        }
    }
    assert!(embedded_material(&folder.path().join("none.png")).is_err_and(|error| error.to_string().contains("none.png")));
}

#[test]
fn a_full_disk_is_called_so() {
    let source = std::io::Error::from(std::io::ErrorKind::StorageFull);
    let sentence = FilesError::Write { path: "a.png".into(), source }.to_string();
    assert!(sentence.starts_with("a.png: ") && sentence.contains("the disk is full"), "{sentence}");
}

#[test]
fn parts_of_a_preview_are_parts_of_the_whole() {
    let Some((device, queue)) = device() else { return };
    let model: ModelMeshes = make_shape("torus").expect("it is built in").into();
    let mut material = Material::named("red");
    material.set(Property::base_color, Value::Color([0.7, 0.2, 0.1]));
    let light = environment(&[0.5, 1.0, 2.0, 0.2, 0.1, 0.7, 1.0, 3.0]);
    let scene = Scene::of_model(&model, Arc::new(material), Arc::default(), light, 100.0);
    let mut preview = Preview::new(&device, &queue).expect("the preview can be made");
    preview.set_scene(&device, &queue, &scene);
    let (width, height) = (72u32, 48u32);
    // The first frame is drawn alone; further ones add samples of the rays.
    for frames in [1, 4] {
        let whole = preview.render(&device, &queue, width, height, frames).expect("it draws");
        for (at, size) in [([0, 0], [40, 24]), ([40, 24], [32, 24]), ([7, 3], [50, 40])] {
            preview.set_crop(Some(Crop { full: [width, height], at }));
            let part = preview.render(&device, &queue, size[0], size[1], frames).expect("it draws");
            let of_whole = |i: usize| {
                let (x, y) = (at[0] as usize + i % size[0] as usize, at[1] as usize + i / size[0] as usize);
                whole[y * width as usize + x]
            };
            let is_near = |a: [f32; 4], b: [f32; 4]| (0..3).all(|k| (a[k] - b[k]).abs() <= 0.01 * a[k].abs().max(0.1));
            // Rounding decides which side of an edge a place lies on.
            let far = (0..part.len()).filter(|i| !is_near(part[*i], of_whole(*i))).count();
            assert!(far * 50 <= part.len(), "{frames} frames, {at:?}: {far} of {} pixels differ", part.len());
        }
        preview.set_crop(None);
    }
}

#[test]
fn the_window_knows_where_its_scene_came_from() {
    let window = window_of(vec2(900.0, 700.0), Vec::new());
    let places = &app(&window).editor().places;
    assert!(places.iter().all(Option::is_some), "pictures name the first mesh and light: {places:?}");
}
