//! Pictures and turntables that the window makes: what is set is what is written, it can be made again, ended and resumed, and what fails is told once.

use burnish::cli::Outcome;
use burnish::cli::render::{self, RenderArguments};
use burnish::command::Command;
use burnish::dock::Pane;
use burnish::export::Format;
use burnish::live_export::FrameState;
use burnish::offline::turntable::Turn;
use burnish::panels::export::Kind;
use burnish::picture_file::embedded_job;
use burnish_renderer::path::StopRules;
use burnish_tests::export_panel::{PATIENCE, SIZE, errors, names, press_button, until, until_done, window};
use burnish_tests::window::{Window, app, app_mut, click, find, press, rect, step_now, window_with};
use egui::accesskit::Role;
use egui::vec2;
use egui_kittest::kittest::Queryable;
use std::fs;
use std::path::Path;
use std::time::{Duration, Instant};

fn tick(window: &mut Window, role: Role, name: &str) {
    find(window, role, name).click_accesskit();
    window.run_steps(2);
}

/// The picture made again from what it holds, by the command line.
fn again(picture: &Path, out: &Path) -> Vec<u8> {
    let mut arguments = RenderArguments::default();
    arguments.material = Some(picture.display().to_string());
    arguments.out = out.to_path_buf();
    assert_eq!(render::run(&arguments).expect("it can be made again"), Outcome::Done);
    fs::read(out).expect("it was written")
}

#[test]
fn a_picture_with_passes_is_made_again_bit_by_bit() {
    let folder = tempfile::tempdir().expect("a folder");
    let [png, exr] = ["a.png", "b.exr"].map(|name| folder.path().join(name));
    // The dialog's answer may lack the ending.
    let mut window = window(vec![png.with_extension(""), exr.clone()]);
    let step = step_now(&window);
    for name in ["normal", "samples", "transparent"] {
        tick(&mut window, Role::CheckBox, name);
    }
    find(&window, Role::SpinButton, "Width of pictures").set_value_accesskit(30.0);
    window.run_steps(2);
    let panel = app_mut(&mut window).export_panel_mut();
    assert_eq!(panel.size, Some([30, 25]), "the proportions are kept");
    panel.options.denoise = Some(burnish::offline::picture_options::Denoise::Own);
    window.run_steps(2);
    press_button(&mut window, "Render to file…");
    until_done(&mut window);
    assert_eq!(errors(&window), [""; 0]);
    assert_eq!(names(folder.path()), ["a.normal.png", "a.png", "a.raw.png", "a.samples.png"]);
    let said = app(&window).messages().last_info().to_owned();
    for part in ["Wrote ", "a.png", "a.raw.png", "30 × 25", "8 spp", "error ", "denoised by burnish", "stopped by spp"] {
        assert!(said.contains(part), "{part}: {said}");
    }
    let picture = image::open(&png).expect("a picture").to_rgba8();
    assert_eq!((picture.dimensions(), picture.get_pixel(0, 0)[3]), ((30, 25), 0), "no background");

    // By the key of the command, as EXR of halves, with the light by lobes.
    tick(&mut window, Role::RadioButton, "EXR");
    tick(&mut window, Role::CheckBox, "lobes");
    app_mut(&mut window).export_panel_mut().options.half = true;
    press(&mut window, Command::RenderPicture);
    until_done(&mut window);
    let job = embedded_job(&exr).expect("it can be read").expect("it is ours");
    assert_eq!((job.size, job.half, job.transparent, job.denoiser.as_deref()), ([30, 25], true, true, Some("burnish")));
    assert_eq!(job.aov, ["normal", "samples", "lobes"]);
    assert!(
        job.scene.mesh.is_some() && job.scene.environment.is_some() && job.material.is_some() && job.relmse_estimate.is_some()
    );
    for (picture, name) in [(&png, "a2.png"), (&exr, "b2.exr")] {
        assert!(again(picture, &folder.path().join(name)) == fs::read(picture).expect("it is there"), "{name}");
    }
    assert_eq!(step_now(&window), step, "undo has nothing to do with it");
    // What to type to make it again stands below.
    assert!(window.query_all_by_label_contains("burnish render \"").next().is_some());
}

#[test]
fn frames_that_hit_their_limit_are_marked_and_resumed() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("turn");
    let mut window = window(vec![out.clone()]);
    press_button(&mut window, "Turntable");
    find(&window, Role::SpinButton, "Frames of the turntable").set_value_accesskit(3.0);
    tick(&mut window, Role::RadioButton, "light");
    let panel = app_mut(&mut window).export_panel_mut();
    assert_eq!((panel.frames, panel.turn, panel.kind), (3, Turn::Light, Kind::Turntable));
    panel.frame_stop = StopRules { spp: None, seconds: None, relmse: Some(1e-6) };
    panel.format = Format::Exr;
    window.run_steps(2);
    // The folder is asked for, and then it goes on.
    press_button(&mut window, "Predict");
    until_done(&mut window);
    assert_eq!(errors(&window), [""; 0]);
    assert_eq!(app(&window).export_panel().folder.as_deref(), Some(&*out));
    let (prediction, due) = app(&window).export_panel().prediction.clone().expect("it is predicted");
    assert_eq!(due, 3);
    assert!(prediction.total(Some(1e-6), 3).is_some_and(|seconds| seconds > 0.0));
    assert!(window.query_all_by_label_contains("About ").next().is_some());
    // Another error is another time.
    find(&window, Role::Slider, "Error of a frame, percent").set_value_accesskit(2.0);
    window.run_steps(2);
    let chosen = app(&window).export_panel().frame_stop.relmse.expect("an error");
    assert!((chosen - 4e-4).abs() < 1e-9, "{chosen}");
    // Far more samples than any machine makes in that time.
    app_mut(&mut window).export_panel_mut().frame_stop = StopRules { spp: None, seconds: Some(0.01), relmse: Some(1e-6) };
    window.run_steps(2);
    press_button(&mut window, "Start 3 frames");
    until_done(&mut window);
    let rows = &app(&window).export_panel().rows;
    assert!(rows.iter().all(|row| row.state == FrameState::Limited && row.relmse.is_some()), "{rows:?}");
    assert!(window.query_all_by_label_contains("hit its time limit").next().is_some());
    assert!(names(&out).contains(&"frame_0002.samples".to_owned()), "{:?}", names(&out));
    // As large an error as the stored samples nearly have.
    let worst = rows.iter().filter_map(|row| row.relmse).fold(0.0, f64::max);
    app_mut(&mut window).export_panel_mut().frame_stop = StopRules { spp: None, seconds: None, relmse: Some(worst) };
    window.run_steps(2);
    let resume = window
        .query_all_by(|node| node.role() == Role::Button && node.label().is_some_and(|l| l.starts_with("Resume those 3 to ")));
    let at = resume.into_iter().next().expect("the button says so").rect().center();
    click(&mut window, at);
    until_done(&mut window);
    let rows = &app(&window).export_panel().rows;
    assert!(rows.iter().all(|row| row.state == FrameState::Done), "{rows:?}");
    assert_eq!(names(&out), ["frame_0001.exr", "frame_0002.exr", "frame_0003.exr", "turntable.json"]);
    let frame = out.join("frame_0003.exr");
    assert!(again(&frame, &out.join("again.exr")) == fs::read(&frame).expect("it is there"), "a frame is a picture like others");
    // Another day the folder tells how it was begun.
    let mut other = window_with(vec2(1280.0, 1000.0), vec![out.clone()], |app, _| app);
    app_mut(&mut other).dock_mut().set_shown(Pane::Export, true);
    app_mut(&mut other).export_panel_mut().kind = Kind::Turntable;
    other.run_steps(3);
    press_button(&mut other, "Choose the folder of the turntable");
    until(&mut other, "the frames to be known", |app| !app.export_panel().rows.is_empty());
    let (now, before) = (app(&other).export_panel(), app(&window).export_panel());
    assert_eq!((now.frames, now.turn, now.format, now.size, &now.rows), (3, Turn::Light, Format::Exr, Some(SIZE), &before.rows));
    // With other settings the folder is not touched.
    app_mut(&mut window).export_panel_mut().size = Some([20, 20]);
    press(&mut window, Command::RenderTurntable);
    until_done(&mut window);
    assert!(
        matches!(errors(&window)[..], [text] if text.contains("was begun with another `picture.size`")),
        "{:?}",
        errors(&window)
    );
}

#[test]
fn what_is_cancelled_leaves_no_half_file_and_a_turntable_goes_on() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("turn");
    let mut window = window(vec![folder.path().join("long.png"), out.clone()]);
    app_mut(&mut window).export_panel_mut().stop.spp = Some(1_000_000);
    window.run_steps(2);
    press_button(&mut window, "Render to file…");
    until(&mut window, "it to be in the list of work", |app| app.is_exporting());
    assert!(window.query_all_by_label_contains("Work: Rendering a picture").next().is_some());
    until(&mut window, "a sample", |app| {
        app.export_work().is_some_and(|work| work.text.contains("spp") && work.progress.is_some())
    });
    // Closing the window asks first.
    press(&mut window, Command::Quit);
    press_button(&mut window, "Go on rendering");
    assert!(app(&window).is_exporting());
    press_button(&mut window, "Cancel rendering");
    until_done(&mut window);
    assert_eq!((names(folder.path()), errors(&window)), (Vec::new(), Vec::new()));
    assert!(app(&window).messages().last_info().contains("ended"));

    let panel = app_mut(&mut window).export_panel_mut();
    (panel.kind, panel.frames) = (Kind::Turntable, 3);
    panel.frame_stop = StopRules { spp: Some(400), seconds: None, relmse: None };
    window.run_steps(2);
    press_button(&mut window, "Start 3 frames");
    until(&mut window, "a frame", |app| app.export_panel().rows.iter().any(|row| row.state == FrameState::Done));
    let ctx = window.ctx.clone();
    app_mut(&mut window).carry_out(Command::StopRendering, &ctx);
    until_done(&mut window);
    let rows = &app(&window).export_panel().rows;
    assert!(rows.iter().all(|row| row.state != FrameState::Working), "{rows:?}");
    assert!(names(&out).iter().all(|name| !name.ends_with(".tmp")));
    let done = rows.iter().filter(|row| row.state == FrameState::Done).count();
    app_mut(&mut window).carry_out(Command::RenderTurntable, &ctx);
    until_done(&mut window);
    let rows = &app(&window).export_panel().rows;
    assert!(done >= 1 && rows.iter().all(|row| row.state == FrameState::Done), "{rows:?}");
    assert_eq!(names(&out), ["frame_0001.png", "frame_0002.png", "frame_0003.png", "turntable.json"]);
}

#[test]
fn folders_that_cannot_be_written_are_told_once() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("file.txt");
    fs::write(&file, "no folder").expect("it can be written");
    let [missing, gone, elsewhere] = ["missing/a.png", "gone/a.png", "elsewhere.png"].map(|name| folder.path().join(name));
    fs::create_dir(folder.path().join("gone")).expect("a folder");
    let paths = vec![file.join("a.png"), missing.clone(), file.join("turn"), gone.clone(), elsewhere.clone()];
    let mut window = window(paths);
    for path in [file.join("a.png"), missing] {
        press_button(&mut window, "Render to file…");
        until_done(&mut window);
        let name = path.display().to_string();
        assert!(errors(&window).iter().filter(|text| text.contains(&name)).count() == 1, "{name}: {:?}", errors(&window));
    }
    assert_eq!(errors(&window).len(), 2);
    press_button(&mut window, "Turntable");
    press(&mut window, Command::RenderTurntable);
    until_done(&mut window);
    assert_eq!(errors(&window).len(), 3, "{:?}", errors(&window));
    // It vanishes while minutes of work are done: they can go elsewhere.
    press_button(&mut window, "Picture");
    app_mut(&mut window).export_panel_mut().stop = StopRules { spp: None, seconds: Some(1.5), relmse: None };
    window.run_steps(2);
    press_button(&mut window, "Render to file…");
    // Without frames, which may take long.
    let start = Instant::now();
    while app(&window).export_work().is_none_or(|work| !work.text.contains("spp")) {
        assert!(start.elapsed() < PATIENCE, "no sample is taken");
        std::thread::sleep(Duration::from_millis(1));
    }
    fs::remove_dir_all(folder.path().join("gone")).expect("it can be removed");
    until_done(&mut window);
    assert_eq!(errors(&window).len(), 4, "{:?}", errors(&window));
    assert!(!gone.exists() && names(folder.path()) == ["file.txt"]);
    press_button(&mut window, "Write elsewhere…");
    until_done(&mut window);
    assert_eq!(errors(&window).len(), 4);
    assert!(again(&elsewhere, &folder.path().join("again.png")) == fs::read(&elsewhere).expect("it was written"));
}

#[test]
fn controls_have_names_and_stay_in_small_windows() {
    let mut window = window_with(vec2(1280.0, 720.0), Vec::new(), |app, _| app);
    app_mut(&mut window).dock_mut().set_shown(Pane::Export, true);
    window.run_steps(4);
    for kind in ["Picture", "Turntable"] {
        press_button(&mut window, kind);
        let screen = window.ctx.content_rect();
        let begin = if kind == "Picture" { "Render to file…" } else { "Start 120 frames" };
        let at = rect(&window, Role::Button, begin);
        assert!(screen.contains_rect(at), "{begin} at {at}");
        for (role, name) in [
            (Role::ComboBox, "Size preset"),
            (Role::SpinButton, "Width of pictures"),
            (Role::SpinButton, "Height of pictures"),
            (Role::CheckBox, "Keep proportions"),
            (Role::ComboBox, "Bits of PNG"),
            (Role::ComboBox, "Display transform of pictures"),
            (Role::ComboBox, "Denoise pictures"),
        ] {
            let at = rect(&window, role, name);
            assert!(at.right() <= screen.right() && at.width() > 10.0, "{name} at {at}");
        }
        for (_, word) in burnish::export::LayerKind::ALL {
            assert!(rect(&window, Role::CheckBox, word).right() <= screen.right(), "{word}");
        }
    }
    // Where there is no device there is no preview to choose.
    assert!(window.query_all_by_label_contains("PNG: display-referred sRGB; EXR: linear Rec.709, no transform").next().is_some());
}
