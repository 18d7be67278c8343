//! What a frame of the window's panels takes on the processor while a value is dragged.
//!
//! `cargo bench -p burnish-tests --bench editor_frames` prints milliseconds, median and worst, at 1920 × 1080: of the window alone (without a screen
//! reader), and of the window with the tessellation of what it painted. With the panels as at first, with all panels in sight beside each other, and
//! with all of them while the final view renders on all threads that it takes.

use burnish::app::App;
use burnish::command::Command;
use burnish::dialogs::PreparedDialogs;
use burnish::dock::{Dock, Pane};
use egui::{Event, Modifiers, PointerButton, Pos2, RawInput, Rect, accesskit, pos2, vec2};
use egui_tiles::{ContainerKind, Tile};
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
    /// A window with its first mesh and light loaded.
    fn open(has_final_view: bool) -> Self {
        let ctx = egui::Context::default();
        let app = App::new(&ctx, None, Box::new(PreparedDialogs::default()));
        let app = if has_final_view { app } else { app.without_final_view() };
        let mut bench = Self { ctx, app, time: 0.0 };
        while {
            bench.frame(Vec::new());
            bench.app.is_loading()
        } {
            std::thread::sleep(Duration::from_millis(10));
        }
        bench
    }

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

    /// Puts every panel in sight: what is behind another tab comes beside it.
    fn show_all(&mut self) -> Result<(), Box<dyn std::error::Error>> {
        let dock: &mut Dock = self.app.dock_mut();
        for pane in Pane::ALL {
            dock.set_shown(pane, true);
        }
        for tile in dock.tree.tiles.tiles_mut() {
            if let Tile::Container(container) = tile
                && container.num_children() > 1
                && container.kind() == ContainerKind::Tabs
            {
                container.set_kind(ContainerKind::Horizontal);
            }
        }
        match Pane::ALL.into_iter().find(|pane| !self.app.dock().is_drawn(*pane)) {
            Some(pane) => Err(format!("{} is not in sight", pane.title()).into()),
            None => Ok(()),
        }
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

    /// Drags the field of a property; milliseconds of the frames, sorted: of the window, and with the tessellation.
    fn drag(&mut self, name: &str) -> Result<[Vec<f64>; 2], Box<dyn std::error::Error>> {
        let at = self.field(name).ok_or("the field is not in sight")?;
        let button =
            |pos, pressed| Event::PointerButton { pos, button: PointerButton::Primary, pressed, modifiers: Modifiers::NONE };
        self.frame(vec![Event::PointerMoved(at), button(at, true)]);
        self.frame(vec![Event::PointerMoved(at + vec2(10.0, 0.0))]);
        let mut times = [Vec::new(), Vec::new()];
        let before = self.app.editor().document.material.clone();
        let mut last = at;
        for i in 0..FRAMES {
            last = at + vec2(20.0 + 60.0 * (i as f32 * 0.05).sin(), 0.0);
            let (ui, all, _) = self.frame(vec![Event::PointerMoved(last)]);
            times[0].push(1e3 * ui);
            times[1].push(1e3 * all);
        }
        if self.app.editor().document.material == before {
            return Err(format!("{name} was not dragged").into());
        }
        self.frame(vec![button(last, false)]);
        self.frame(Vec::new());
        let ctx = self.ctx.clone();
        self.app.carry_out(Command::Undo, &ctx);
        times.iter_mut().for_each(|times| times.sort_by(f64::total_cmp));
        Ok(times)
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut out = std::io::stdout().lock();
    writeln!(out, "milliseconds of a frame: median and worst of {FRAMES}, of the window and with the tessellation")?;
    for (title, has_all, has_final_view) in
        [("as at first", false, false), ("all panels", true, false), ("all panels, final view renders", true, true)]
    {
        let mut bench = Bench::open(has_final_view);
        if has_all {
            bench.show_all()?;
        }
        writeln!(out, "{title:<32} {:>8} {:>8} {:>8} {:>8}", "median", "worst", "median", "worst")?;
        for name in FIELDS {
            let [ui, all] = bench.drag(name)?;
            let (median, worst) = (FRAMES / 2, FRAMES - 1);
            writeln!(out, "  {name:<30} {:>8.2} {:>8.2} {:>8.2} {:>8.2}", ui[median], ui[worst], all[median], all[worst])?;
        }
        if has_final_view && bench.app.final_view().is_none() {
            return Err("the final view did not run".into());
        }
    }
    Ok(())
}
