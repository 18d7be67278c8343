//! The final view in the window: what restarts it and what does not, and what its chart and status line say.

use burnish::app::App;
use burnish::command::Command;
use burnish::dialogs::PreparedDialogs;
use burnish::live_final::LiveFinal;
use burnish::panels::chart::{self, ErrorCurve};
use burnish_material::{Property, Value};
use burnish_renderer::path::{ErrorPoint, StopRules};
use burnish_renderer::tonemap::DisplayTransform;
use egui::{Rect, pos2, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use std::path::PathBuf;
use std::time::{Duration, Instant};

type Window = Harness<'static, Option<App>>;

/// A small window that shows the final view alone, as there is no GPU; dialogs are answered with `paths`.
fn window(paths: Vec<PathBuf>) -> Window {
    let mut window = Harness::builder().with_size([500.0, 360.0]).build_ui_state(
        move |ui: &mut egui::Ui, app: &mut Option<App>| {
            let paths = paths.clone();
            app.get_or_insert_with(|| {
                let mut app = App::new(ui.ctx(), None, Box::new(PreparedDialogs::new(paths)));
                app.editor_mut().view.are_panels_shown = false;
                app.editor_mut().view.stop = StopRules { spp: Some(2), ..StopRules::default() };
                app
            })
            .frame(ui);
        },
        None,
    );
    wait(&mut window, "a finished picture", |app| view(app).is_some_and(is_done));
    window
}

fn view(app: &App) -> Option<&LiveFinal> {
    app.final_view()
}

fn is_done(view: &LiveFinal) -> bool {
    view.current().is_some_and(|snapshot| snapshot.done.is_some())
}

fn app(window: &mut Window) -> &mut App {
    window.state_mut().as_mut().expect("the first frame makes it")
}

fn wait(window: &mut Window, what: &str, is_it: impl Fn(&App) -> bool) {
    let start = Instant::now();
    loop {
        window.run_steps(1);
        if is_it(app(window)) {
            return;
        }
        assert!(start.elapsed() < Duration::from_secs(180), "waited in vain for {what}");
        std::thread::sleep(Duration::from_millis(5));
    }
}

fn revision(window: &mut Window) -> Option<u64> {
    view(app(window)).and_then(LiveFinal::revision)
}

#[test]
fn only_what_changes_the_picture_restarts_it() {
    let mut window = window(Vec::new());
    let before = revision(&mut window);
    assert!(before.is_some());
    let ctx = window.ctx.clone();
    for command in [Command::ExposureUp, Command::ExposureUp, Command::ExposureDown, Command::ToggleDenoise] {
        app(&mut window).carry_out(command, &ctx);
        window.run_steps(3);
    }
    app(&mut window).editor_mut().view.display.transform = DisplayTransform::Agx;
    window.run_steps(3);
    assert_eq!(revision(&mut window), before, "exposure, display and denoising leave the rendering alone");
    assert!(view(app(&mut window)).is_some_and(is_done));

    app(&mut window).editor_mut().document.material.set(Property::roughness, Value::Float(0.77));
    wait(&mut window, "the edited picture", |app| {
        view(app).and_then(LiveFinal::revision) > before && view(app).is_some_and(is_done)
    });
    let edited = revision(&mut window);
    app(&mut window).editor_mut().view.orbit.turn(0.1, 0.0);
    wait(&mut window, "the turned picture", |app| {
        view(app).and_then(LiveFinal::revision) > edited && view(app).is_some_and(is_done)
    });
}

#[test]
fn the_rule_that_stopped_is_shown_and_saved() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("final.exr");
    let mut window = window(vec![path.clone()]);
    // The status line is drawn before the pictures.
    window.run_steps(1);
    window.get_by_label_contains("stopped: 2 samples per pixel reached   2 spp");
    let ctx = window.ctx.clone();
    app(&mut window).carry_out(Command::SaveExr, &ctx);
    wait(&mut window, "the file", |app| app.messages().last_info().starts_with("Wrote"));
    let job = burnish::picture_file::read_picture(&path).unwrap().job.expect("a picture of ours has a job");
    assert_eq!((&job["stop_reason"], &job["spp"], &job["view"]), (&"spp".into(), &2.into(), &"final".into()), "{job}");
    for key in ["relmse_estimate", "relmse_low", "relmse_high", "is_firefly_limited", "denoiser"] {
        // With two samples per pixel there is no estimate yet, and the file says so.
        assert!(job.get(key).is_some_and(serde_json::Value::is_null), "{key}: {job}");
    }
}

#[test]
fn the_chart_can_be_heard() {
    let point = |i: i32| {
        let seconds = 0.5 * 2_f64.powi(i);
        let relmse = 0.04 / seconds;
        ErrorPoint { seconds, spp: 4 << i, relmse, low: relmse / 1.2, high: relmse * 1.2 }
    };
    let history: Vec<ErrorPoint> = (0..5).map(point).collect();
    for (count, is_shown) in [(2, false), (5, true)] {
        let curve = ErrorCurve::new(&history[..count], Some(1e-4), false);
        assert_eq!(curve.is_some(), is_shown);
        for size in [vec2(40.0, 30.0), vec2(225.0, 150.0), vec2(360.0, 240.0)] {
            let curve = curve.clone();
            let mut harness = Harness::new_ui(move |ui| {
                if let Some(curve) = &curve {
                    chart::show(ui, Rect::from_min_size(pos2(0.0, 0.0), size), curve);
                }
            });
            harness.run();
            let name =
                "estimated error 7.1 % (6.5 to 7.7 %) after 8 s and 64 samples per pixel; error² falls as t^−1.0; predicted: 1 %";
            assert_eq!(harness.query_by_label_contains(name).is_some(), is_shown, "{size}");
        }
    }
}
