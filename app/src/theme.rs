//! The look: neutral, so that the only colours are the material's and what needs attention.

use egui::{Color32, CornerRadius, FontId, Margin, Stroke, Style, TextStyle, Visuals, vec2};
use std::cell::Cell;

/// Which set of colours the window has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ThemeName {
    /// Dark grey, the picture in middle grey.
    #[default]
    Dark,
    /// Middle grey throughout, for judging colours.
    Grey,
    /// Light grey.
    Light,
}

impl ThemeName {
    /// All themes with their words in files.
    pub const ALL: [(Self, &'static str); 3] = [(Self::Dark, "dark"), (Self::Grey, "grey"), (Self::Light, "light")];

    /// Its colours.
    pub const fn palette(self) -> &'static Palette {
        match self {
            Self::Dark => &DARK,
            Self::Grey => &GREY,
            Self::Light => &LIGHT,
        }
    }
}

/// The colours of a theme. Text reaches a contrast of 4.5 on every ground it stands on, weak text of 3.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Palette {
    /// Whether text is lighter than what it stands on.
    pub is_dark: bool,
    /// What the picture stands in: middle grey, which leaves the eye's judgement of colour alone.
    pub surround: Color32,
    /// Behind panels.
    pub panel: Color32,
    /// Behind the menu and the status line.
    pub bar: Color32,
    /// Behind menus, tooltips and dialogs.
    pub popup: Color32,
    /// Behind text that is typed.
    pub field: Color32,
    /// Buttons and tracks at rest.
    pub control: Color32,
    /// Lines between things.
    pub line: Color32,
    /// Marks what is selected, set or running.
    pub accent: Color32,
    /// Behind what is selected.
    pub selection: Color32,
    /// Text that needs attention.
    pub warning: Color32,
    /// Text about what failed.
    pub error: Color32,
    /// Text about what went well.
    pub good: Color32,
    /// Headings, and values that somebody set.
    pub strong: Color32,
    /// Ordinary text.
    pub text: Color32,
    /// Text that stands back.
    pub weak: Color32,
}

const DARK: Palette = Palette {
    is_dark: true,
    surround: Color32::from_gray(58),
    panel: Color32::from_gray(36),
    bar: Color32::from_gray(29),
    popup: Color32::from_gray(44),
    field: Color32::from_gray(22),
    control: Color32::from_gray(56),
    line: Color32::from_gray(64),
    accent: Color32::from_rgb(232, 163, 84),
    selection: Color32::from_rgb(112, 74, 30),
    warning: Color32::from_rgb(240, 190, 70),
    error: Color32::from_rgb(250, 128, 114),
    good: Color32::from_rgb(130, 200, 130),
    strong: Color32::from_gray(240),
    text: Color32::from_gray(208),
    weak: Color32::from_gray(152),
};

const GREY: Palette = Palette {
    is_dark: true,
    surround: Color32::from_gray(119),
    panel: Color32::from_gray(72),
    bar: Color32::from_gray(62),
    popup: Color32::from_gray(76),
    field: Color32::from_gray(52),
    control: Color32::from_gray(88),
    line: Color32::from_gray(104),
    accent: Color32::from_rgb(255, 196, 120),
    selection: Color32::from_rgb(118, 80, 36),
    warning: Color32::from_rgb(255, 214, 102),
    error: Color32::from_rgb(255, 180, 168),
    good: Color32::from_rgb(170, 232, 170),
    strong: Color32::from_gray(255),
    text: Color32::from_gray(236),
    weak: Color32::from_gray(196),
};

const LIGHT: Palette = Palette {
    is_dark: false,
    surround: Color32::from_gray(119),
    panel: Color32::from_gray(226),
    bar: Color32::from_gray(212),
    popup: Color32::from_gray(238),
    field: Color32::from_gray(250),
    control: Color32::from_gray(202),
    line: Color32::from_gray(176),
    accent: Color32::from_rgb(134, 70, 0),
    selection: Color32::from_rgb(250, 206, 150),
    warning: Color32::from_rgb(118, 76, 0),
    error: Color32::from_rgb(166, 28, 16),
    good: Color32::from_rgb(16, 96, 24),
    strong: Color32::from_gray(8),
    text: Color32::from_gray(36),
    weak: Color32::from_gray(84),
};

/// Colours of what is written over the picture, on nearly black.
pub const ON_PICTURE: &Palette = &DARK;

thread_local! {
    // A window is drawn by one thread, and everything in it has one theme.
    static NOW: Cell<&'static Palette> = const { Cell::new(&DARK) };
}

/// The colours of the window that is being drawn.
pub fn now() -> &'static Palette {
    NOW.get()
}

/// Makes this theme the one of the window that is being drawn.
pub fn set(name: ThemeName) {
    NOW.set(name.palette());
}

/// Size of ordinary text where the user does not scale it, points.
const BODY: f32 = 13.5;

/// How much larger than usual text is.
pub fn text_scale(ui: &egui::Ui) -> f32 {
    TextStyle::Body.resolve(ui.style()).size / BODY
}

/// Points that the window's content needs at the usual size of text, so that nothing is cut off.
const ROOM: egui::Vec2 = vec2(950.0, 530.0);
/// Points are not made smaller than this part of their size.
const ZOOM_MIN: f32 = 0.35;

/// Makes all points smaller where the window has too few of them, as a small screen with large text has.
pub fn fit(ctx: &egui::Context, text_scale: f32) {
    let points = ctx.viewport_rect().size() * ctx.zoom_factor();
    if points.is_finite() {
        let fits = (points / (ROOM * text_scale)).min_elem();
        // In steps, so that a window that is being resized is not set anew for every pixel.
        ctx.set_zoom_factor(((fits * 32.0).floor() / 32.0).clamp(ZOOM_MIN, 1.0));
    }
}

/// Applies the look to a context. `text_scale` enlarges all text and what holds it.
pub fn apply(ctx: &egui::Context, name: ThemeName, text_scale: f32, is_motion_reduced: bool) {
    set(name);
    let palette = name.palette();
    ctx.set_theme(if palette.is_dark { egui::Theme::Dark } else { egui::Theme::Light });
    // On a slow machine a frame may take longer than egui's 0.8 seconds, and a click must not get lost by that.
    // Its size is what [`fit`] makes of it, and the keys are the commands' own.
    ctx.options_mut(|options| {
        options.input_options.max_click_duration = 3.0;
        options.zoom_with_keyboard = false;
    });
    ctx.all_styles_mut(|style| set_style(style, palette, text_scale, is_motion_reduced));
}

/// The default fonts, with the monospaced one to fall back on: it has the arrows that the others lack.
pub fn fonts() -> egui::FontDefinitions {
    let mut fonts = egui::FontDefinitions::default();
    let monospace = fonts.families.get(&egui::FontFamily::Monospace).and_then(|names| names.first().cloned());
    if let (Some(name), Some(proportional)) = (monospace, fonts.families.get_mut(&egui::FontFamily::Proportional)) {
        proportional.push(name);
    }
    fonts
}

fn set_style(style: &mut Style, palette: &Palette, text_scale: f32, is_motion_reduced: bool) {
    use egui::FontFamily::{Monospace, Proportional};
    let size = |points: f32, family| FontId::new((points * text_scale * 2.0).round() / 2.0, family);
    style.text_styles = [
        (TextStyle::Small, size(11.5, Proportional)),
        (TextStyle::Body, size(BODY, Proportional)),
        (TextStyle::Button, size(BODY, Proportional)),
        (TextStyle::Heading, size(15.0, Proportional)),
        (TextStyle::Monospace, size(12.5, Monospace)),
    ]
    .into();
    let spacing = &mut style.spacing;
    spacing.item_spacing = vec2(6.0, 4.0);
    spacing.button_padding = vec2(7.0, 2.0);
    spacing.interact_size = vec2(36.0, (21.0 * text_scale).round());
    spacing.icon_width = (14.0 * text_scale).round();
    spacing.menu_margin = Margin::same(5);
    spacing.slider_rail_height = 4.0;
    spacing.tooltip_width = 380.0;
    spacing.combo_width = 90.0;
    spacing.scroll = egui::style::ScrollStyle::solid();
    spacing.scroll.bar_width = 8.0;
    spacing.scroll.bar_inner_margin = 3.0;
    spacing.scroll.bar_outer_margin = 0.0;
    style.interaction.tooltip_delay = 0.35;
    style.animation_time = if is_motion_reduced { 0.0 } else { 0.08 };
    style.visuals = visuals(palette);
}

fn visuals(palette: &Palette) -> Visuals {
    let mut visuals = if palette.is_dark { Visuals::dark() } else { Visuals::light() };
    let towards_text = |color: Color32, amount: f32| color.lerp_to_gamma(palette.strong, amount);
    visuals.panel_fill = palette.panel;
    visuals.window_fill = palette.popup;
    visuals.window_stroke = Stroke::new(1.0, palette.line);
    visuals.extreme_bg_color = palette.field;
    visuals.faint_bg_color = towards_text(palette.panel, 0.03);
    visuals.warn_fg_color = palette.warning;
    visuals.error_fg_color = palette.error;
    visuals.hyperlink_color = palette.accent;
    visuals.weak_text_color = Some(palette.weak);
    visuals.selection.bg_fill = palette.selection;
    visuals.selection.stroke = Stroke::new(1.0, palette.strong);
    visuals.slider_trailing_fill = true;
    visuals.handle_shape = egui::style::HandleShape::Rect { aspect_ratio: 0.42 };
    visuals.window_corner_radius = CornerRadius::same(6);
    visuals.menu_corner_radius = CornerRadius::same(5);
    visuals.disabled_alpha = 0.4;
    let widgets = &mut visuals.widgets;
    widgets.noninteractive.bg_fill = palette.panel;
    widgets.noninteractive.weak_bg_fill = palette.panel;
    widgets.noninteractive.bg_stroke = Stroke::new(1.0, palette.line);
    widgets.noninteractive.fg_stroke.color = palette.text;
    for (state, amount, stroke) in [
        (&mut widgets.inactive, 0.0, Stroke::NONE),
        (&mut widgets.hovered, 0.07, Stroke::new(1.0, towards_text(palette.line, 0.25))),
        (&mut widgets.active, 0.12, Stroke::new(1.0, palette.accent)),
        (&mut widgets.open, 0.05, Stroke::new(1.0, palette.line)),
    ] {
        state.bg_fill = towards_text(palette.control, amount + 0.03);
        state.weak_bg_fill = towards_text(palette.control, amount);
        state.bg_stroke = stroke;
        state.fg_stroke.color = if amount > 0.0 { palette.strong } else { palette.text };
    }
    for state in
        [&mut widgets.noninteractive, &mut widgets.inactive, &mut widgets.hovered, &mut widgets.active, &mut widgets.open]
    {
        state.corner_radius = CornerRadius::same(3);
        state.expansion = 0.0;
    }
    visuals
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Relative luminance of a colour (WCAG 2.2, section "relative luminance").
    fn luminance(color: Color32) -> f32 {
        let [r, g, b, _] = egui::Rgba::from(color).to_array();
        0.2126 * r + 0.7152 * g + 0.0722 * b
    }

    /// WCAG 2.2, section "contrast ratio".
    fn contrast(a: Color32, b: Color32) -> f32 {
        let (a, b) = (luminance(a), luminance(b));
        (a.max(b) + 0.05) / (a.min(b) + 0.05)
    }

    #[test]
    fn text_can_be_read_on_every_ground() {
        for (name, word) in ThemeName::ALL {
            let p = name.palette();
            for ground in [p.panel, p.bar, p.popup, p.field, p.control] {
                for (color, least) in [(p.strong, 7.0), (p.text, 4.5), (p.weak, 3.0), (p.accent, 3.0), (p.warning, 4.5)] {
                    let found = contrast(color, ground);
                    assert!(found >= least, "{word}: {color:?} on {ground:?} has {found:.2}, wanted {least}");
                }
            }
            for ground in [p.panel, p.popup, p.bar] {
                for color in [p.error, p.good] {
                    let found = contrast(color, ground);
                    assert!(found >= 4.5, "{word}: {color:?} on {ground:?} has {found:.2}, wanted 4.5");
                }
            }
            assert!(contrast(p.strong, p.selection) >= 4.5, "{word}: selected text");
        }
    }
}
