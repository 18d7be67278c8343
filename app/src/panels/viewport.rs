//! The middle of the window: where the pictures go, the mouse over them, and what is written on them.

use crate::editor::{Editor, View, ViewMode};
use crate::live_debug::{self, Choice};
use crate::panels::chart::{self, ErrorCurve};
use crate::panels::wipe;
use crate::preferences::MouseScheme;
use crate::theme;
use burnish_renderer::path::StopRules;
use egui::{
    Align2, Color32, DragValue, FontId, Label, Modifiers, PointerButton, Rect, Response, RichText, Role, Sense, StrokeKind, Ui,
    Vec2, WidgetInfo, pos2, vec2,
};

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

/// How the mouse moves the view.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Motion {
    Orbit,
    Pan,
    Zoom,
    Light,
}

/// What a drag with a button does.
fn motion(scheme: MouseScheme, button: PointerButton, modifiers: Modifiers) -> Option<Motion> {
    use PointerButton::{Middle, Primary, Secondary};
    let Modifiers { alt, shift, command, .. } = modifiers;
    if button == Secondary && shift {
        return Some(Motion::Light);
    }
    match (scheme, button) {
        (MouseScheme::Designer, Primary) => Some(Motion::Orbit),
        (MouseScheme::Designer, Middle) => Some(Motion::Pan),
        (MouseScheme::Designer, Secondary) => Some(if command { Motion::Pan } else { Motion::Zoom }),
        (MouseScheme::Maya, Primary) => alt.then_some(Motion::Orbit),
        (MouseScheme::Maya, Middle) => alt.then_some(Motion::Pan),
        (MouseScheme::Maya, Secondary) => alt.then_some(Motion::Zoom),
        (MouseScheme::Blender, Middle) if shift => Some(Motion::Pan),
        (MouseScheme::Blender, Middle) if command => Some(Motion::Zoom),
        (MouseScheme::Blender, Middle) => Some(Motion::Orbit),
        _ => None,
    }
}

/// Takes the rest of the panel and lets the mouse turn, shift and zoom, unless it is `held` for something else. Returns what was allocated and
/// how it is split.
pub fn interact(
    ui: &mut Ui,
    editor: &mut Editor,
    scheme: MouseScheme,
    is_wheel_flipped: bool,
    is_held: bool,
) -> (Response, Layout) {
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
    let buttons = [PointerButton::Primary, PointerButton::Middle, PointerButton::Secondary];
    let held = buttons.into_iter().find(|button| response.dragged_by(*button)).filter(|_| !is_held);
    match held.and_then(|button| motion(scheme, button, modifiers)) {
        Some(Motion::Light) => {
            view.environment_deg = (view.environment_deg + 240.0 * delta.x).rem_euclid(360.0);
            ui.set_cursor_icon(egui::CursorIcon::ResizeHorizontal);
        }
        Some(Motion::Pan) => {
            view.orbit.pan(delta.x, delta.y);
            ui.set_cursor_icon(egui::CursorIcon::Move);
        }
        Some(Motion::Zoom) => {
            view.orbit.zoom(2.5 * (delta.x - delta.y));
            ui.set_cursor_icon(egui::CursorIcon::ResizeVertical);
        }
        Some(Motion::Orbit) => {
            view.orbit.turn(delta.x, delta.y);
            ui.set_cursor_icon(egui::CursorIcon::Grabbing);
        }
        None => {}
    }
    if response.hovered() {
        scroll(ui, view, height, is_wheel_flipped);
    }
    (response, layout)
}

/// The wheel zooms; two fingers on a trackpad, which sends points and not lines, orbit, or pan with Shift; pinching zooms.
fn scroll(ui: &Ui, view: &mut View, height: f32, is_wheel_flipped: bool) {
    let (scroll, pinch, modifiers) = ui.input(|i| (i.smooth_scroll_delta(), i.zoom_delta(), i.modifiers));
    let is_trackpad = ui.input(|i| {
        i.events.iter().any(|event| matches!(event, egui::Event::MouseWheel { unit: egui::MouseWheelUnit::Point, .. }))
    });
    if is_trackpad {
        let delta = scroll / height;
        if modifiers.shift { view.orbit.pan(delta.x, delta.y) } else { view.orbit.turn(delta.x, delta.y) }
    } else if scroll.y != 0.0 {
        view.orbit.zoom(scroll.y * if is_wheel_flipped { -0.0025 } else { 0.0025 });
    }
    if pinch != 1.0 && pinch > 0.0 {
        view.orbit.zoom(pinch.ln());
    }
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
    painter.rect_filled(rect, 0, theme::now().surround);
    if let Some(problem) = picture.problem {
        return paint_problem(ui, rect, problem);
    }
    match picture.texture {
        Some(texture) => {
            painter.image(texture, whole, Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0)), Color32::WHITE);
        }
        None => {
            painter.text(rect.center(), Align2::CENTER_CENTER, "preparing…", FontId::proportional(14.0), theme::ON_PICTURE.weak);
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
        bottom = line(label.clone(), theme::ON_PICTURE.accent, bottom);
    }
    for note in &picture.notes {
        bottom = line(format!("⚠ {note}"), theme::ON_PICTURE.warning, bottom);
    }
    None
}

fn paint_problem(ui: &mut Ui, rect: Rect, problem: &str) -> Option<WayOut> {
    let mut inner = ui.new_child(
        egui::UiBuilder::new()
            .max_rect(Rect::from_center_size(rect.center(), vec2(rect.width().min(440.0), 156.0)))
            .layout(egui::Layout::top_down(egui::Align::Center)),
    );
    inner.label(RichText::new("⚠ No usable GPU for the preview").size(16.0).color(theme::now().warning));
    inner.add(Label::new(RichText::new(format!("Reason: {problem}.")).color(theme::now().text)).wrap());
    inner.label(RichText::new("The final view needs none and works on.").color(theme::now().text));
    inner.add_space(6.0);
    let mut way = None;
    for (text, out) in [("Show final view", WayOut::ShowFinal), ("Try again", WayOut::TryAgain)] {
        if inner.button(text).clicked() {
            way = Some(out);
        }
    }
    way
}

/// What ends a picture by itself: each rule can be switched off; whichever comes first ends it. The names of the fields end in `of`.
pub fn stop_rules(ui: &mut Ui, stop: &mut StopRules, of: &str) {
    ui.set_min_width(230.0);
    let mut percent = stop.relmse.map(|e| 100.0 * e.sqrt());
    let mut spp = stop.spp.map(f64::from);
    rule(ui, ["Estimated error", " %", of], &mut percent, (0.5, 0.01, 100.0));
    rule(ui, ["Samples per pixel", "", of], &mut spp, (4096.0, 1.0, 1e6));
    time_rule(ui, &mut stop.seconds, of);
    // Written back only where it changed: the square root does not come back to the same bits.
    if percent != stop.relmse.map(|e| 100.0 * e.sqrt()) {
        stop.relmse = percent.map(|p| (0.01 * p) * (0.01 * p));
    }
    stop.spp = spp.map(|x| x as u32);
}

/// The rule of a time.
pub(super) fn time_rule(ui: &mut Ui, seconds: &mut Option<f64>, of: &str) {
    rule(ui, ["Time", " s", of], seconds, (60.0, 0.1, 1e6));
}

/// One rule that can be switched off: its name, its suffix and what ends the name of its field; default, least and most.
fn rule(ui: &mut Ui, [name, suffix, of]: [&str; 3], value: &mut Option<f64>, (default, min, max): (f64, f64, f64)) {
    ui.horizontal(|ui| {
        let mut is_on = value.is_some();
        if ui.checkbox(&mut is_on, name).changed() {
            *value = is_on.then_some(default);
        }
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            if let Some(value) = value {
                let field =
                    DragValue::new(value).range(min..=max).clamp_existing_to_range(false).speed(default / 100.0).suffix(suffix);
                ui.add(field).accessible_name(format!("{name} limit{of}"));
            }
        });
    });
}

/// Shows the error chart over a panel.
pub fn chart_pane(ui: &mut Ui, size: Vec2, curve: Option<&ErrorCurve>, has_final: bool) {
    let (rect, _) = ui.allocate_exact_size(size.max(vec2(20.0, 20.0)), Sense::hover());
    match curve {
        Some(curve) => chart::show(ui, rect, curve),
        None => {
            let text = if has_final { "The curve begins after a few estimates." } else { "The final view is not shown." };
            let color = theme::now().weak;
            let galley = ui.painter().layout(text.into(), FontId::proportional(12.0), color, rect.width());
            ui.painter().galley(rect.center() - 0.5 * galley.size(), galley, color);
        }
    }
}

/// Shows what the colours of a debug view stand for, in the lower right corner of the picture.
pub fn paint_legend(ui: &Ui, rect: Rect, choice: Choice) {
    let painter = ui.painter_at(rect);
    let font = FontId::proportional(12.0);
    let mut place = rect.right_bottom() - vec2(14.0, 12.0);
    for (name, color) in choice.legend().into_iter().rev() {
        let galley = painter.layout_no_wrap(name.to_owned(), font.clone(), theme::ON_PICTURE.text);
        let size = galley.size() + vec2(22.0, 0.0);
        let line = Rect::from_min_size(place - size, size);
        painter.rect_filled(line.expand2(vec2(6.0, 2.0)), 2, Color32::from_black_alpha(165));
        let swatch = Rect::from_center_size(line.left_center() + vec2(6.0, 0.0), vec2(12.0, 12.0));
        let [r, g, b] = live_debug::shown(color);
        painter.rect_filled(swatch, 2, Color32::from_rgb(r, g, b));
        painter.galley(line.min + vec2(20.0, 0.0), galley, theme::ON_PICTURE.text);
        place.y -= line.height() + 4.0;
    }
}

/// Shows over the whole window what dropping the hovered files would do.
pub fn paint_drop_hint(ctx: &egui::Context, text: &str, is_refused: bool) {
    let rect = ctx.content_rect();
    let painter = ctx.layer_painter(egui::LayerId::new(egui::Order::Foreground, egui::Id::unique("drop hint")));
    let color = if is_refused { theme::ON_PICTURE.error } else { theme::ON_PICTURE.accent };
    painter.rect_filled(rect, 0, Color32::from_black_alpha(150));
    painter.rect_stroke(rect.shrink(6.0), 6, (3.0, color), StrokeKind::Inside);
    painter.text(rect.center(), Align2::CENTER_CENTER, text, FontId::proportional(22.0), color);
}
