//! The look: dark and neutral, so that the only colours are the material's and what needs attention.

use egui::{Color32, CornerRadius, FontId, Margin, Stroke, Style, TextStyle, Visuals, vec2};

/// What the picture stands in: middle grey, which leaves the eye's judgement of colour alone.
pub const SURROUND: Color32 = Color32::from_gray(58);
/// Behind panels.
pub const PANEL: Color32 = Color32::from_gray(36);
/// Behind the menu and the status line.
pub const BAR: Color32 = Color32::from_gray(29);
/// Marks what is selected, set or running.
pub const ACCENT: Color32 = Color32::from_rgb(232, 163, 84);
/// Text that needs attention.
pub const WARNING: Color32 = Color32::from_rgb(240, 190, 70);
/// Text about what failed.
pub const ERROR: Color32 = Color32::from_rgb(240, 110, 95);
/// Text about what went well.
pub const GOOD: Color32 = Color32::from_rgb(130, 200, 130);
/// Ordinary text.
pub const TEXT: Color32 = Color32::from_gray(208);
/// Text that stands back.
pub const WEAK: Color32 = Color32::from_gray(146);

/// Applies the look to a context.
pub fn apply(ctx: &egui::Context) {
    ctx.set_theme(egui::Theme::Dark);
    ctx.set_fonts(fonts());
    // On a slow machine a frame may take longer than egui's 0.8 seconds, and a click must not get lost by that.
    ctx.options_mut(|options| options.input_options.max_click_duration = 3.0);
    ctx.style_mut_of(egui::Theme::Dark, style);
}

/// The default fonts, with the monospaced one to fall back on: it has the arrows that the others lack.
fn fonts() -> egui::FontDefinitions {
    let mut fonts = egui::FontDefinitions::default();
    let monospace = fonts.families.get(&egui::FontFamily::Monospace).and_then(|names| names.first().cloned());
    if let (Some(name), Some(proportional)) = (monospace, fonts.families.get_mut(&egui::FontFamily::Proportional)) {
        proportional.push(name);
    }
    fonts
}

fn style(style: &mut Style) {
    use egui::FontFamily::{Monospace, Proportional};
    style.text_styles = [
        (TextStyle::Small, FontId::new(11.5, Proportional)),
        (TextStyle::Body, FontId::new(13.5, Proportional)),
        (TextStyle::Button, FontId::new(13.5, Proportional)),
        (TextStyle::Heading, FontId::new(15.0, Proportional)),
        (TextStyle::Monospace, FontId::new(12.5, Monospace)),
    ]
    .into();
    let spacing = &mut style.spacing;
    spacing.item_spacing = vec2(6.0, 4.0);
    spacing.button_padding = vec2(7.0, 2.0);
    spacing.interact_size = vec2(36.0, 21.0);
    spacing.menu_margin = Margin::same(5);
    spacing.slider_rail_height = 4.0;
    spacing.tooltip_width = 380.0;
    spacing.combo_width = 90.0;
    spacing.scroll = egui::style::ScrollStyle::solid();
    spacing.scroll.bar_width = 8.0;
    spacing.scroll.bar_inner_margin = 3.0;
    spacing.scroll.bar_outer_margin = 0.0;
    style.interaction.tooltip_delay = 0.35;
    style.animation_time = 0.08;
    style.visuals = visuals();
}

fn visuals() -> Visuals {
    let mut visuals = Visuals::dark();
    visuals.panel_fill = PANEL;
    visuals.window_fill = Color32::from_gray(44);
    visuals.window_stroke = Stroke::new(1.0, Color32::from_gray(70));
    visuals.extreme_bg_color = Color32::from_gray(22);
    visuals.faint_bg_color = Color32::from_gray(42);
    visuals.warn_fg_color = WARNING;
    visuals.error_fg_color = ERROR;
    visuals.hyperlink_color = ACCENT;
    visuals.weak_text_color = Some(WEAK);
    visuals.selection.bg_fill = Color32::from_rgb(120, 80, 34);
    visuals.selection.stroke = Stroke::new(1.0, Color32::from_rgb(255, 226, 190));
    visuals.slider_trailing_fill = true;
    visuals.handle_shape = egui::style::HandleShape::Rect { aspect_ratio: 0.42 };
    visuals.window_corner_radius = CornerRadius::same(6);
    visuals.menu_corner_radius = CornerRadius::same(5);
    visuals.disabled_alpha = 0.4;
    let radius = CornerRadius::same(3);
    let widgets = &mut visuals.widgets;
    widgets.noninteractive.bg_stroke = Stroke::new(1.0, Color32::from_gray(50));
    widgets.noninteractive.fg_stroke.color = TEXT;
    widgets.inactive.bg_fill = Color32::from_gray(62);
    widgets.inactive.weak_bg_fill = Color32::from_gray(54);
    widgets.inactive.fg_stroke.color = TEXT;
    widgets.hovered.bg_fill = Color32::from_gray(78);
    widgets.hovered.weak_bg_fill = Color32::from_gray(66);
    widgets.hovered.bg_stroke = Stroke::new(1.0, Color32::from_gray(110));
    widgets.active.bg_fill = Color32::from_gray(84);
    widgets.active.weak_bg_fill = Color32::from_gray(74);
    widgets.active.bg_stroke = Stroke::new(1.0, ACCENT);
    widgets.open.weak_bg_fill = Color32::from_gray(60);
    for state in
        [&mut widgets.noninteractive, &mut widgets.inactive, &mut widgets.hovered, &mut widgets.active, &mut widgets.open]
    {
        state.corner_radius = radius;
        state.expansion = 0.0;
    }
    visuals
}
