//! What a frame of the window's panels takes on the processor while a value is dragged, without any picture.
//!
//! `cargo bench -p burnish-tests --bench editor_frames` prints milliseconds, median and worst, at 1920 × 1080 with the panels as at first: of the
//! window alone (without a screen reader), and of the window with the tessellation of what it painted.

use burnish::app::App;
use burnish::command::Command;
use burnish::dialogs::PreparedDialogs;
use egui::{Event, Modifiers, PointerButton, Pos2, RawInput, Rect, accesskit, pos2, vec2};
use std::io::Write;
use std::time::{Duration, Instant};

/// Frames that are measured, per property.
const FRAMES: usize = 300;
/// Whose fields are dragged: one alone, and two that put lobes in and leave them out.
const FIELDS: [&str; 3] = ["Roughness", "Metallic", "Translucency"];

struct Bench {
    ctx: egui::Context,
    app: App,
    time: f64,
}

impl Bench {
    /// Draws a frame with these events; seconds of the window, and with the tessellation. The tree for screen readers if there is one.
    fn frame(&mut self, events: Vec<Event>) -> (f64, f64, Option<accesskit::TreeUpdate>) {
        self.time += 1.0 / 60.0;
        let screen_rect = Some(Rect::from_min_size(Pos2::ZERO, vec2(1920.0, 1080.0)));
        let input = RawInput { screen_rect, time: Some(self.time), events, ..RawInput::default() };
        let start = Instant::now();
        let app = &mut self.app;
        let mut output = self.ctx.run_ui(input, |ui| app.frame(ui));
        let ui = start.elapsed().as_secs_f64();
        let shapes = self.ctx.tessellate(output.shapes, output.pixels_per_point);
        let all = start.elapsed().as_secs_f64();
        drop(shapes);
        // Nothing is drawn, so the textures are dropped on purpose.
        output.textures_delta.clear();
        (ui, all, output.platform_output.accesskit_update)
    }

    /// The middle of a field, as a screen reader is told it.
    fn field(&mut self, name: &str) -> Option<Pos2> {
        self.ctx.enable_accesskit();
        self.frame(Vec::new());
        let tree = self.frame(Vec::new()).2;
        self.ctx.disable_accesskit();
        self.frame(Vec::new());
        let is_it = |node: &accesskit::Node| node.role() == accesskit::Role::SpinButton && node.label() == Some(name);
        let bounds = tree?.nodes.iter().find(|(_, node)| is_it(node))?.1.bounds()?;
        Some(pos2(0.5 * (bounds.x0 + bounds.x1) as f32, 0.5 * (bounds.y0 + bounds.y1) as f32))
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut out = std::io::stdout().lock();
    let ctx = egui::Context::default();
    let app = App::new(&ctx, None, Box::new(PreparedDialogs::default())).without_final_view();
    let mut bench = Bench { ctx, app, time: 0.0 };
    while {
        bench.frame(Vec::new());
        bench.app.is_loading()
    } {
        std::thread::sleep(Duration::from_millis(10));
    }
    let ctx = bench.ctx.clone();
    writeln!(out, "milliseconds of a frame: median and worst of {FRAMES}, of the window and with the tessellation")?;
    writeln!(out, "{:<24} {:>8} {:>8} {:>8} {:>8}", "dragged", "median", "worst", "median", "worst")?;
    for name in FIELDS {
        let at = bench.field(name).ok_or("the field is not in sight")?;
        let button =
            |pos, pressed| Event::PointerButton { pos, button: PointerButton::Primary, pressed, modifiers: Modifiers::NONE };
        bench.frame(vec![Event::PointerMoved(at), button(at, true)]);
        bench.frame(vec![Event::PointerMoved(at + vec2(10.0, 0.0))]);
        let (mut ui, mut all) = (Vec::new(), Vec::new());
        let before = bench.app.editor().document.material.clone();
        let mut last = at;
        for i in 0..FRAMES {
            last = at + vec2(20.0 + 60.0 * (i as f32 * 0.05).sin(), 0.0);
            let times = bench.frame(vec![Event::PointerMoved(last)]);
            ui.push(1e3 * times.0);
            all.push(1e3 * times.1);
        }
        if bench.app.editor().document.material == before {
            return Err(format!("{name} was not dragged").into());
        }
        bench.frame(vec![button(last, false)]);
        bench.frame(Vec::new());
        bench.app.carry_out(Command::Undo, &ctx);
        let numbers = |values: &mut Vec<f64>| {
            values.sort_by(f64::total_cmp);
            (values[values.len() / 2], values[values.len() - 1])
        };
        let ((a, b), (c, d)) = (numbers(&mut ui), numbers(&mut all));
        writeln!(out, "{name:<24} {a:>8.2} {b:>8.2} {c:>8.2} {d:>8.2}")?;
    }
    Ok(())
}
