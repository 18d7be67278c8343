//! The line above the picture: which view, on what, in which light, how bright.

use crate::command::Command;
use crate::editor::{Editor, ViewMode};
use crate::keymap::Keymap;
use crate::live_debug::{Choice, LiveDebug};
use crate::loading::Job;
use crate::small_pictures::SmallPictures;
use crate::theme;
use crate::thumbnails::Key;
use crate::widgets::number_field::NumberField;
use burnish_assets::{BACKDROPS, BackdropDef, ENVIRONMENTS, SHAPES};
use burnish_renderer::tonemap::DisplayTransform;
use egui::{Align2, ComboBox, Grid, Popup, Rect, Role, Sense, StrokeKind, Ui, WidgetInfo, pos2, vec2};

/// What the toolbar asks for.
pub enum Wish {
    /// A named action.
    Command(Command),
    /// Another mesh or environment.
    Load(Job),
}

/// What the toolbar needs to know beside the editor.
pub struct Tools<'a> {
    /// Whether there is a preview.
    pub has_preview: bool,
    /// Whether there is a stored side.
    pub has_side: bool,
    /// Keys for the tooltips.
    pub keymap: &'a Keymap,
    /// Pictures of meshes and lights.
    pub small: &'a mut SmallPictures,
    /// What is shown instead of the material.
    pub debug: &'a mut LiveDebug,
}

/// What stands in the choice of backdrops for what the mesh brings itself.
pub const AS_IT_COMES: &str = "As it comes";

/// Points across below which the views are a list instead of buttons.
const WIDE: f32 = 560.0;

/// Shows the toolbar: which view, on what, in which light, how bright.
pub fn show(ui: &mut Ui, editor: &mut Editor, tools: &mut Tools) -> Option<Wish> {
    let mut wish = None;
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing = vec2(5.0, 4.0);
        let hint = |command: Command| {
            let keys = tools.keymap.shown(command);
            if keys.is_empty() { command.tooltip().to_owned() } else { format!("{}\nkey {keys}", command.tooltip()) }
        };
        let is_wide = ui.available_width() > WIDE * theme::text_scale(ui);
        let mut views = |ui: &mut Ui| {
            for (mode, name) in ViewMode::ALL {
                let command = command_of(mode);
                let is_possible = tools.has_preview || !mode.has_preview() || mode == ViewMode::Preview;
                let button = ui.add_enabled(is_possible, egui::Button::selectable(editor.view.mode == mode, name));
                let button = button.on_hover_text(hint(command));
                if button.on_disabled_hover_text("There is no usable GPU for the preview.").clicked() {
                    wish = Some(Wish::Command(command));
                }
            }
        };
        if is_wide {
            views(ui);
        } else {
            let shown = ViewMode::ALL.into_iter().find(|(mode, _)| *mode == editor.view.mode).map_or("", |(_, name)| name);
            let combo = ComboBox::from_id_salt("view").width(70.0).selected_text(shown).show_ui(ui, views);
            combo.response.accessible_name("View").on_hover_text("Preview, final view, or both in some way");
        }
        let button = ui.add_enabled(tools.has_side, egui::Button::selectable(editor.view.compares_sides, "A/B"));
        button.widget_info(|| {
            WidgetInfo::selected(Role::Button, tools.has_side, editor.view.compares_sides, "Compare sides A and B")
        });
        let button = button.on_hover_text(hint(Command::CompareSides));
        if button.on_disabled_hover_text(format!("Store a side first. {}", hint(Command::StoreSide))).clicked() {
            wish = Some(Wish::Command(Command::CompareSides));
        }
        debug_menu(ui, tools.debug, is_wide);
        if is_wide {
            ui.separator();
        }

        let mesh = editor.model.as_ref().map_or("…", |model| model.name.as_str());
        let all = SHAPES.iter().map(|def| (Key::Shape(def.name), def.label, Job::Shape(def.name)));
        let tip = "What carries the material; drop a .gltf, .glb or .ply for your own";
        let (small, backdrop) = (&mut *tools.small, editor.backdrop());
        let mut other = None;
        let more = |ui: &mut Ui| other = backdrops(ui, backdrop);
        wish = scene_menu(ui, ["Mesh", mesh, tip], all, Command::LoadModel, small, more).or(wish.take());
        if let Some(backdrop) = other {
            editor.set_backdrop(backdrop);
        }
        let light = editor.environment.as_ref().map_or("…", |environment| environment.name.as_str());
        let all = ENVIRONMENTS.iter().map(|def| (Key::Environment(def.name), def.label, Job::BuiltInEnvironment(def.name)));
        let tip = "What lights the scene; drop an .hdr or .exr for your own";
        wish = scene_menu(ui, ["Environment", light, tip], all, Command::LoadEnvironment, tools.small, |_| {}).or(wish.take());
        let view = &mut editor.view;
        let field = NumberField {
            format: |x| format!("{x:.0}°"),
            step: 15.0,
            ..NumberField::plain("Environment rotation", 44.0 * theme::text_scale(ui), 1.0)
        };
        // Within a size of its own, so that it goes to the next line where it does not fit.
        let size = vec2(44.0 * theme::text_scale(ui), ui.spacing().interact_size.y);
        if let Some(new) = ui.allocate_ui(size, |ui| field.show(ui, f64::from(view.environment_deg))).inner {
            view.environment_deg = (new as f32).rem_euclid(360.0);
        }
        if is_wide {
            ui.separator();
        }

        exposure(ui, &mut view.display.exposure_ev);
        let (mode, has_final) = (view.mode, view.mode.has_final());
        let (is_bloom_on, is_denoise_on) = (view.is_bloom_on, view.is_denoise_on);
        let mut effects = |ui: &mut Ui| {
            let button = ui.add_enabled(mode == ViewMode::Preview, egui::Button::selectable(is_bloom_on, "Bloom"));
            let button = button.on_hover_text(hint(Command::ToggleBloom));
            if button.on_disabled_hover_text("Off where pictures are compared: only the preview has it.").clicked() {
                wish = Some(Wish::Command(Command::ToggleBloom));
            }
            let button = ui.add_enabled(has_final, egui::Button::selectable(is_denoise_on, "Denoise"));
            let button = button.on_hover_text(hint(Command::ToggleDenoise));
            if button.on_disabled_hover_text("The final view is not shown.").clicked() {
                wish = Some(Wish::Command(Command::ToggleDenoise));
            }
        };
        transform_menu(ui, "Display transform", &mut view.display.transform, |ui| {
            if !is_wide {
                ui.separator();
                effects(ui);
            }
        });
        if is_wide {
            effects(ui);
        }
    });
    wish
}

fn command_of(mode: ViewMode) -> Command {
    match mode {
        ViewMode::Preview => Command::ShowPreview,
        ViewMode::Final => Command::ShowFinal,
        ViewMode::Both => Command::ShowBoth,
        ViewMode::Wipe => Command::ShowWipe,
        ViewMode::Difference => Command::ShowDifference,
    }
}

fn debug_menu(ui: &mut Ui, debug: &mut LiveDebug, is_wide: bool) {
    let explain = |ui: &mut Ui, debug: &mut LiveDebug| {
        let button = ui.add(egui::Button::selectable(debug.is_explaining(), "Explain"));
        if button.on_hover_text(Command::ExplainPixel.tooltip()).clicked() {
            debug.toggle_explaining();
        }
    };
    let shown = debug.choice().map_or("Material", Choice::label);
    let combo = ComboBox::from_id_salt("debug").width(76.0).truncate().selected_text(shown).show_ui(ui, |ui| {
        if ui.selectable_label(debug.choice().is_none(), "Material").clicked() {
            debug.end();
        }
        for choice in Choice::all() {
            if ui.selectable_label(debug.choice() == Some(choice), choice.label()).on_hover_text(choice.doc()).clicked() {
                debug.set(Some(choice));
            }
        }
        if !is_wide {
            ui.separator();
            explain(ui, debug);
        }
    });
    let tip = "What is shown: the material, or what it is made of";
    combo.response.accessible_name("Debug view").on_hover_text(tip);
    if is_wide {
        explain(ui, debug);
    }
}

/// A choice among pictures of what is built in; `more` comes below them.
fn scene_menu(
    ui: &mut Ui,
    [name, shown, tip]: [&str; 3],
    all: impl Iterator<Item = (Key, &'static str, Job)>,
    load: Command,
    small: &mut SmallPictures,
    more: impl FnOnce(&mut Ui),
) -> Option<Wish> {
    let mut wish = None;
    let button = ui.add(egui::Button::new(format!("{shown} ⏷")).truncate());
    button.widget_info(|| WidgetInfo::labeled(Role::ComboBox, true, name));
    let button = button.on_hover_text(tip);
    Popup::menu(&button).show(|ui| {
        Grid::new(name).num_columns(2).spacing(vec2(6.0, 6.0)).show(ui, |ui| {
            for (index, (key, label, job)) in all.enumerate() {
                let texture = small.built_in(ui.ctx(), key);
                let size = vec2(112.0, 96.0);
                let (rect, response) = ui.allocate_exact_size(size, Sense::click());
                response.widget_info(|| WidgetInfo::selected(Role::Button, true, label == shown, label));
                let visuals = ui.style().interact_selectable(&response, label == shown);
                ui.painter().rect(rect, 4, visuals.weak_bg_fill, visuals.bg_stroke, StrokeKind::Inside);
                let room = Rect::from_min_size(rect.min + vec2(5.0, 5.0), vec2(102.0, 68.0));
                if let Some(texture) = texture {
                    let image = egui::Image::new((texture, room.size()));
                    let shape = if name == "Mesh" { vec2(90.7, 68.0) } else { vec2(102.0, 51.0) };
                    image.paint_at(ui, Rect::from_center_size(room.center(), shape));
                } else {
                    ui.painter().rect_filled(room, 2, theme::now().surround);
                }
                let font = egui::TextStyle::Small.resolve(ui.style());
                ui.painter().text(
                    pos2(rect.center().x, rect.bottom() - 5.0),
                    Align2::CENTER_BOTTOM,
                    label,
                    font,
                    visuals.text_color(),
                );
                if response.clicked() {
                    wish = Some(Wish::Load(job));
                    ui.close();
                }
                if index % 3 == 2 {
                    ui.end_row();
                }
            }
        });
        more(ui);
        ui.separator();
        if ui.button(load.text()).clicked() {
            wish = Some(Wish::Command(load));
            ui.close();
        }
    });
    wish
}

/// What the mesh stands on: the choice, if one was made.
fn backdrops(ui: &mut Ui, shown: Option<&'static BackdropDef>) -> Option<Option<&'static BackdropDef>> {
    let mut chosen = None;
    ui.separator();
    ui.label("Stands on");
    let own = (None, AS_IT_COMES, "What the mesh brings: tiles for most built-in ones, nothing for files.");
    for (choice, label, doc) in std::iter::once(own).chain(BACKDROPS.iter().map(|def| (Some(def), def.label, def.doc))) {
        let is_shown = choice.map(|def| def.name) == shown.map(|def| def.name);
        if ui.selectable_label(is_shown, label).on_hover_text(doc).clicked() {
            chosen = Some(choice);
            ui.close();
        }
    }
    chosen
}

fn exposure(ui: &mut Ui, ev: &mut f32) {
    let size = vec2(58.0 * theme::text_scale(ui), ui.spacing().interact_size.y);
    let field = NumberField { format: |x| format!("{x:.2} EV"), step: 0.25, ..NumberField::plain("Exposure", size.x, 0.02) };
    let exposure = ui.allocate_ui(size, |ui| field.show(ui, f64::from(*ev)));
    if let Some(new) = exposure.inner {
        *ev = new as f32;
    }
    exposure.response.on_hover_text("Exposure in stops\nkeys [ and ] change it by a third");
}

/// The display transforms; `more` comes below them.
pub(super) fn transform_menu(ui: &mut Ui, label: &str, transform: &mut DisplayTransform, more: impl FnOnce(&mut Ui)) {
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
        more(ui);
    });
    combo.response.accessible_name(label).on_hover_text("How radiance becomes screen colours, in both views");
}
