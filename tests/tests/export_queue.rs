//! Pictures and turntables that wait for each other: made as they were ordered, one after the other, given up one by one or with the window.

use burnish::app::App;
use burnish::command::Command;
use burnish::panels::export::Kind;
use burnish::picture_file::embedded_job;
use burnish_material::{MaterialFile, Property, Value};
use burnish_renderer::path::StopRules;
use burnish_tests::export_panel::{PATIENCE, errors, names, press_button, until, until_done, window};
use burnish_tests::window::{Window, app, app_mut, press, set_document};
use egui::accesskit::Role;
use egui_kittest::kittest::{NodeT, Queryable};
use std::fs;
use std::path::Path;
use std::time::{Duration, Instant};

/// What waits, as the panel shows it.
fn queued(window: &Window) -> Vec<String> {
    let buttons =
        window.query_all_by(|node| node.role() == Role::Button && node.label().is_some_and(|l| l.starts_with("Remove ")));
    let names = buttons.filter_map(|button| button.accesskit_node().label());
    names.filter_map(|name| Some(name.strip_prefix("Remove ")?.strip_suffix(" from the queue")?.to_owned())).collect()
}

fn set_roughness(window: &mut Window, roughness: f64) {
    set_document(window, |material| {
        material.set(Property::roughness, Value::Float(roughness));
    });
}

/// The roughness and the size that a picture was made with.
fn made_with(picture: &Path) -> (f64, [usize; 2]) {
    let job = embedded_job(picture).expect("it can be read").expect("it is ours");
    let (file, _) = MaterialFile::parse(job.material.as_deref().expect("it has one")).expect("it is a material");
    (file.material().float(Property::roughness), job.size)
}

#[test]
fn more_pictures_wait_in_a_queue_as_they_were_ordered() {
    let folder = tempfile::tempdir().expect("a folder");
    let [long, second, third, table] = ["long.png", "b.png", "c.png", "turn"].map(|name| folder.path().join(name));
    let mut window = window(vec![long, second.clone(), third.clone(), second.clone(), table.clone()]);
    app_mut(&mut window).export_panel_mut().stop.spp = Some(1_000_000);
    window.run_steps(2);
    press_button(&mut window, "Render to file…");
    until(&mut window, "it to begin", App::is_exporting);
    app_mut(&mut window).export_panel_mut().stop.spp = Some(8);
    for (roughness, size) in [(0.25, [24, 20]), (0.5, [30, 20])] {
        set_roughness(&mut window, roughness);
        app_mut(&mut window).export_panel_mut().size = Some(size);
        window.run_steps(2);
        press_button(&mut window, "Add to queue…");
    }
    set_roughness(&mut window, 0.75);
    assert_eq!(queued(&window), ["b.png, 24 × 20", "c.png, 30 × 20"]);
    // Two cannot go into one file.
    press_button(&mut window, "Add to queue…");
    assert!(
        matches!(errors(&window)[..], [text] if text.contains("b.png: is being made or waits already")),
        "{:?}",
        errors(&window)
    );
    // The folder of a turntable can be chosen, and looked into, meanwhile.
    let panel = app_mut(&mut window).export_panel_mut();
    (panel.kind, panel.frames) = (Kind::Turntable, 2);
    window.run_steps(2);
    press_button(&mut window, "Add to queue");
    until(&mut window, "the folder to be looked into", |app| {
        app.messages().last_info().starts_with("Queued turn, 2 frames, 30 × 20")
    });
    assert_eq!(queued(&window).len(), 3);
    // The panel goes on to another turntable, whose frames are not those of the first.
    app_mut(&mut window).export_panel_mut().folder = Some(folder.path().join("other"));
    press_button(&mut window, "Remove c.png, 30 × 20 from the queue");
    assert_eq!(queued(&window), ["b.png, 24 × 20", "turn, 2 frames, 30 × 20"]);
    press(&mut window, Command::Quit);
    press_button(&mut window, "Don’t save");
    assert!(window.query_all_by_label_contains("2 more wait in the queue").next().is_some());
    press_button(&mut window, "Go on rendering");
    press_button(&mut window, "Cancel rendering");
    until_done(&mut window);
    assert_eq!((queued(&window).len(), errors(&window).len()), (0, 1), "{:?}", errors(&window));
    assert_eq!(names(folder.path()), ["b.png", "turn"]);
    assert_eq!(made_with(&second), (0.25, [24, 20]));
    assert_eq!(made_with(&table.join("frame_0002.png")), (0.75, [30, 20]));
    assert!(app(&window).export_panel().rows.is_empty());
    let said = app(&window).messages().last_info();
    assert!(said.contains("turn: 2 of 2 frames are finished"), "{said}");
}

#[test]
fn a_queue_waits_where_nothing_can_be_written_and_ends_with_the_window() {
    let folder = tempfile::tempdir().expect("a folder");
    let [gone, next, last] = ["gone/a.png", "b.png", "c.png"].map(|name| folder.path().join(name));
    fs::create_dir(folder.path().join("gone")).expect("a folder");
    let mut window = window(vec![gone, next.clone(), last]);
    app_mut(&mut window).export_panel_mut().stop = StopRules { spp: None, seconds: Some(1.5), relmse: None };
    window.run_steps(2);
    press_button(&mut window, "Render to file…");
    press_button(&mut window, "Add to queue…");
    let start = Instant::now();
    while app(&window).export_work().is_none_or(|work| !work.text.contains("spp")) {
        assert!(start.elapsed() < PATIENCE, "no sample is taken");
        std::thread::sleep(Duration::from_millis(1));
    }
    fs::remove_dir_all(folder.path().join("gone")).expect("it can be removed");
    until_done(&mut window);
    assert_eq!((errors(&window).len(), queued(&window)), (1, vec!["b.png, 24 × 20".to_owned()]));
    assert!(names(folder.path()).is_empty(), "the next would not be written either");
    press_button(&mut window, "Discard it");
    until(&mut window, "the next to begin", App::is_exporting);
    // Closing the window gives up what waits, and ends what is being made.
    press_button(&mut window, "Add to queue…");
    press(&mut window, Command::Quit);
    assert!(window.query_all_by_label_contains("1 more waits in the queue").next().is_some());
    press_button(&mut window, "End it and quit");
    until_done(&mut window);
    assert!(names(folder.path()).is_empty() && queued(&window).is_empty() && errors(&window).len() == 1);
}
