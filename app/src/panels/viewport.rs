//! The middle of the window: the toolbar above the picture, the pictures themselves, and the mouse over them.

use crate::command::Command;
use crate::editor::{Editor, View, ViewMode};
use crate::loading::Job;
use crate::panels::chart::{self, ErrorCurve};
use crate::panels::wipe;
use crate::theme;
use burnish_assets::{ENVIRONMENTS, SHAPES};
use burnish_renderer::path::StopRules;
use burnish_renderer::tonemap::DisplayTransform;
use egui::{
    Align2, Color32, ComboBox, DragValue, FontId, Label, PointerButton, Rect, Response, RichText, Role, Sense, Slider,
    SliderClamping, StrokeKind, Ui, Vec2, WidgetInfo, pos2, vec2,
};

/// What the toolbar asks for.
pub enum Wish {
    /// A named action.
    Command(Command),
    /// Another mesh or environment.
    Load(Job),
}

/// Shows the toolbar: which view, on what, in which light, how bright.
pub fn toolbar(ui: &mut Ui, editor: &mut Editor, has_preview: bool) -> Option<Wish> {
    let mut wish = None;
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing = vec2(5.0, 4.0);
        for (mode, name) in ViewMode::ALL {
            let command = match mode {
                ViewMode::Preview => Command::ShowPreview,
                ViewMode::Final => Command::ShowFinal,
                ViewMode::Both => Command::ShowBoth,
                ViewMode::Wipe => Command::ShowWipe,
                ViewMode::Difference => Command::ShowDifference,
            };
            let is_possible = has_preview || !mode.has_preview() || mode == ViewMode::Preview;
            let button = ui.add_enabled(is_possible, egui::Button::selectable(editor.view.mode == mode, name));
            let keys = command.shortcuts().first().map_or_else(String::new, |keys| ui.ctx().format_shortcut(keys));
            let button = button.on_hover_text(format!("{}\nkey {keys}; \\ switches", command.tooltip()));
            if button.on_disabled_hover_text("There is no usable GPU for the preview.").clicked() {
                wish = Some(Wish::Command(command));
            }
        }
        ui.separator();

        let mesh = editor.model.as_ref().map_or("…", |model| model.name.as_str());
        let combo = ComboBox::from_id_salt("mesh").width(88.0).truncate().selected_text(mesh).show_ui(ui, |ui| {
            for def in SHAPES {
                if ui.selectable_label(mesh == def.label, def.label).clicked() {
                    wish = Some(Wish::Load(Job::Shape(def.name)));
                }
            }
            ui.separator();
            if ui.button(Command::LoadModel.text()).clicked() {
                wish = Some(Wish::Command(Command::LoadModel));
            }
        });
        combo
            .response
            .accessible_name("Mesh")
            .on_hover_text("What carries the material; drop a .gltf, .glb or .ply for your own");

        let light = editor.environment.as_ref().map_or("…", |environment| environment.name.as_str());
        let combo = ComboBox::from_id_salt("environment").width(88.0).truncate().selected_text(light).show_ui(ui, |ui| {
            for def in ENVIRONMENTS {
                if ui.selectable_label(light == def.label, def.label).clicked() {
                    wish = Some(Wish::Load(Job::BuiltInEnvironment(def.name)));
                }
            }
            ui.separator();
            if ui.button(Command::LoadEnvironment.text()).clicked() {
                wish = Some(Wish::Command(Command::LoadEnvironment));
            }
        });
        combo.response.accessible_name("Environment").on_hover_text("What lights the scene; drop an .hdr or .exr for your own");
        let view = &mut editor.view;
        let rotation = DragValue::new(&mut view.environment_deg).suffix("°").speed(1.0).max_decimals(0).clip_text(true);
        ui.add(rotation)
            .accessible_name("Environment rotation")
            .on_hover_text("Rotation of the environment\nShift + right drag in the picture turns it too");
        ui.separator();

        display_controls(ui, view);
        let command = Command::ToggleBloom;
        let button = ui.add_enabled(view.mode == ViewMode::Preview, egui::Button::selectable(view.is_bloom_on, "Bloom"));
        let button = button.on_hover_text(command.tooltip());
        if button.on_disabled_hover_text("Off where pictures are compared: only the preview has it.").clicked() {
            wish = Some(Wish::Command(command));
        }
        let command = Command::ToggleDenoise;
        let button = ui.add_enabled(view.mode.has_final(), egui::Button::selectable(view.is_denoise_on, "Denoise"));
        let button = button.on_hover_text(format!("{}\nkey D", command.tooltip()));
        if button.on_disabled_hover_text("The final view is not shown.").clicked() {
            wish = Some(Wish::Command(command));
        }
    });
    wish
}

fn display_controls(ui: &mut Ui, view: &mut View) {
    ui.spacing_mut().slider_width = 52.0;
    let exposure =
        Slider::new(&mut view.display.exposure_ev, -6.0..=6.0).clamping(SliderClamping::Never).max_decimals(2).suffix(" EV");
    ui.add(exposure).accessible_name("Exposure").on_hover_text("Exposure in stops\nkeys [ and ] change it by a third");
    let transform = &mut view.display.transform;
    let name = |transform: DisplayTransform| match transform {
        DisplayTransform::Neutral => "Neutral",
        DisplayTransform::Agx => "AgX",
        DisplayTransform::Aces => "ACES",
        DisplayTransform::Standard => "Standard",
    };
    let combo = ComboBox::from_id_salt("transform").width(74.0).selected_text(name(*transform)).show_ui(ui, |ui| {
        for (choice, _) in DisplayTransform::ALL {
            let text = match choice {
                DisplayTransform::Neutral => "Khronos PBR Neutral: keeps base colours",
                DisplayTransform::Agx => "AgX: soft highlights, film-like",
                DisplayTransform::Aces => "ACES: high contrast",
                DisplayTransform::Standard => "Standard: the sRGB curve alone",
            };
            ui.selectable_value(transform, choice, name(choice)).on_hover_text(text);
        }
    });
    combo.response.accessible_name("Display transform").on_hover_text("How radiance becomes screen colours, in both views");
}

/// Where the pictures go: one rectangle each.
#[derive(Clone, Copy, Debug)]
pub struct Layout {
    /// The whole area.
    pub all: Rect,
    /// The preview, if visible.
    pub preview: Option<Rect>,
    /// The final view, if visible.
    pub final_view: Option<Rect>,
}

impl Layout {
    /// Splits `all` by the view mode.
    pub fn of(all: Rect, mode: ViewMode) -> Self {
        match mode {
            ViewMode::Preview => Self { all, preview: Some(all), final_view: None },
            ViewMode::Final => Self { all, preview: None, final_view: Some(all) },
            ViewMode::Wipe | ViewMode::Difference => Self { all, preview: Some(all), final_view: Some(all) },
            ViewMode::Both => {
                let (left, right) = all.split_left_right_at_fraction(0.5);
                // Whole points, so that both pictures have the same size.
                let width = (left.width() - 1.0).floor();
                Self {
                    all,
                    preview: Some(Rect::from_min_size(all.min, vec2(width, all.height()))),
                    final_view: Some(Rect::from_min_size(pos2(right.right() - width, all.top()), vec2(width, all.height()))),
                }
            }
        }
    }

    /// Size of one picture in points.
    pub fn picture_size(&self) -> egui::Vec2 {
        self.preview.or(self.final_view).unwrap_or(self.all).size()
    }
}

/// Takes the rest of the panel and lets the mouse turn, shift and zoom. Returns what was allocated and how it is split.
pub fn interact(ui: &mut Ui, editor: &mut Editor) -> (Response, Layout) {
    let (rect, response) = ui.allocate_exact_size(ui.available_size().max(vec2(16.0, 16.0)), Sense::click_and_drag());
    response.widget_info(|| WidgetInfo::labeled(Role::Image, true, "Viewport"));
    let layout = Layout::of(rect, editor.view.mode);
    if editor.view.mode == ViewMode::Wipe {
        wipe::interact(ui, rect, &mut editor.view.wipe);
    }
    let height = layout.picture_size().y.max(1.0);
    let view = &mut editor.view;
    let modifiers = ui.input(|i| i.modifiers);

    let delta = response.drag_delta() / height;
    let is_turning_light = response.dragged_by(PointerButton::Secondary) && modifiers.shift;
    if is_turning_light {
        view.environment_deg = (view.environment_deg + 240.0 * delta.x).rem_euclid(360.0);
        ui.set_cursor_icon(egui::CursorIcon::ResizeHorizontal);
    } else if response.dragged_by(PointerButton::Middle) || (response.dragged_by(PointerButton::Secondary) && modifiers.command) {
        view.orbit.pan(delta.x, delta.y);
        ui.set_cursor_icon(egui::CursorIcon::Move);
    } else if response.dragged_by(PointerButton::Secondary) {
        view.orbit.zoom(2.5 * (delta.x - delta.y));
        ui.set_cursor_icon(egui::CursorIcon::ResizeVertical);
    } else if response.dragged_by(PointerButton::Primary) {
        view.orbit.turn(delta.x, delta.y);
        ui.set_cursor_icon(egui::CursorIcon::Grabbing);
    }
    if response.hovered() {
        let (scroll, pinch) = ui.input(|i| (i.smooth_scroll_delta().y, i.zoom_delta()));
        if scroll != 0.0 {
            view.orbit.zoom(scroll * 0.0025);
        }
        if pinch != 1.0 && pinch > 0.0 {
            view.orbit.zoom(pinch.ln());
        }
    }
    (response, layout)
}

/// What the viewport needs to show one of its pictures.
pub struct Picture<'a> {
    /// The texture, once there is one.
    pub texture: Option<egui::TextureId>,
    /// The word in the corner.
    pub name: &'a str,
    /// What the picture is if not what its name says.
    pub label: Option<String>,
    /// Sentences about what is missing in the picture.
    pub notes: Vec<String>,
    /// Height at the bottom that the notes leave free.
    pub reserved: f32,
    /// Why there is no picture, if there never will be one.
    pub problem: Option<&'a str>,
}

/// A way out of having no preview.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WayOut {
    /// To the other picture.
    ShowFinal,
    /// The device may have recovered.
    TryAgain,
}

/// Paints the part of a picture that lies in `part` of its rectangle. Returns the way out of a problem that was clicked.
pub fn paint(ui: &mut Ui, whole: Rect, part: Rect, picture: &Picture, is_named: bool) -> Option<WayOut> {
    let rect = part.intersect(whole);
    let painter = ui.painter_at(rect);
    painter.rect_filled(rect, 0, theme::SURROUND);
    if let Some(problem) = picture.problem {
        return paint_problem(ui, rect, problem);
    }
    match picture.texture {
        Some(texture) => {
            painter.image(texture, whole, Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0)), Color32::WHITE);
        }
        None => {
            painter.text(rect.center(), Align2::CENTER_CENTER, "preparing…", FontId::proportional(14.0), theme::WEAK);
        }
    }
    let line = |text: String, color, bottom: f32| {
        let width = (rect.width() - 40.0).max(60.0);
        let galley = painter.layout(text, FontId::proportional(12.0), color, width);
        let place = pos2(rect.left() + 14.0, bottom - galley.size().y);
        painter.rect_filled(Rect::from_min_size(place, galley.size()).expand2(vec2(6.0, 3.0)), 3, Color32::from_black_alpha(165));
        painter.galley(place, galley, color);
        place.y - 9.0
    };
    let mut bottom = rect.bottom() - 10.0;
    if is_named {
        bottom = line(picture.name.to_owned(), Color32::from_gray(225), bottom);
    }
    if let Some(label) = &picture.label {
        bottom = line(label.clone(), theme::ACCENT, bottom);
    }
    bottom = bottom.min(rect.bottom() - picture.reserved);
    for note in &picture.notes {
        bottom = line(format!("⚠ {note}"), theme::WARNING, bottom);
    }
    None
}

fn paint_problem(ui: &mut Ui, rect: Rect, problem: &str) -> Option<WayOut> {
    let mut inner = ui.new_child(
        egui::UiBuilder::new()
            .max_rect(Rect::from_center_size(rect.center(), vec2(rect.width().min(440.0), 156.0)))
            .layout(egui::Layout::top_down(egui::Align::Center)),
    );
    inner.label(RichText::new("⚠ No usable GPU for the preview").size(16.0).color(theme::WARNING));
    inner.add(Label::new(RichText::new(format!("Reason: {problem}.")).color(theme::TEXT)).wrap());
    inner.label(RichText::new("The final view needs none and works on.").color(theme::TEXT));
    inner.add_space(6.0);
    let mut way = None;
    for (text, out) in [("Show final view", WayOut::ShowFinal), ("Try again", WayOut::TryAgain)] {
        if inner.button(text).clicked() {
            way = Some(out);
        }
    }
    way
}

/// When the final view stops by itself: each rule can be switched off; whichever comes first ends the picture.
pub fn stop_rules(ui: &mut Ui, stop: &mut StopRules) {
    ui.set_min_width(230.0);
    let mut percent = stop.relmse.map(|e| 100.0 * e.sqrt());
    let mut spp = stop.spp.map(f64::from);
    rule(ui, "Estimated error", " %", &mut percent, (0.5, 0.01, 100.0));
    rule(ui, "Samples per pixel", "", &mut spp, (4096.0, 1.0, 1e6));
    rule(ui, "Time", " s", &mut stop.seconds, (60.0, 0.1, 1e6));
    // Written back only where it changed: the square root does not come back to the same bits.
    if percent != stop.relmse.map(|e| 100.0 * e.sqrt()) {
        stop.relmse = percent.map(|p| (0.01 * p) * (0.01 * p));
    }
    stop.spp = spp.map(|x| x as u32);
}

fn rule(ui: &mut Ui, name: &str, suffix: &str, value: &mut Option<f64>, (default, min, max): (f64, f64, f64)) {
    ui.horizontal(|ui| {
        let mut is_on = value.is_some();
        if ui.checkbox(&mut is_on, name).changed() {
            *value = is_on.then_some(default);
        }
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            if let Some(value) = value {
                let field =
                    DragValue::new(value).range(min..=max).clamp_existing_to_range(false).speed(default / 100.0).suffix(suffix);
                ui.add(field).accessible_name(format!("{name} limit"));
            }
        });
    });
}

/// Shows the error chart in the lower right corner of the final view.
pub fn show_chart(ui: &Ui, rect: Rect, size: Vec2, curve: &ErrorCurve) {
    chart::show(ui, Rect::from_min_size(rect.max - size - vec2(10.0, 10.0), size), curve);
}

/// Shows over the whole window what dropping the hovered files would do.
pub fn paint_drop_hint(ctx: &egui::Context, text: &str, is_refused: bool) {
    let rect = ctx.content_rect();
    let painter = ctx.layer_painter(egui::LayerId::new(egui::Order::Foreground, egui::Id::unique("drop hint")));
    let color = if is_refused { theme::ERROR } else { theme::ACCENT };
    painter.rect_filled(rect, 0, Color32::from_black_alpha(150));
    painter.rect_stroke(rect.shrink(6.0), 6, (3.0, color), StrokeKind::Inside);
    painter.text(rect.center(), Align2::CENTER_CENTER, text, FontId::proportional(22.0), color);
}
