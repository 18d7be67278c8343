//! The page of preferences. What is changed here holds at once, and is kept.

use crate::command::{COMMANDS, Command};
use crate::keymap::{self, Keymap};
use crate::panels::help;
use crate::panels::toolbar::AS_IT_COMES;
use crate::preferences::{AUTOSAVE_SECONDS, MouseScheme, OWN_BACKDROP, Preferences, TEXT_SCALE, THREADS, UNIT_MM};
use crate::theme::{self, ThemeName};
use crate::widgets::number_field::NumberField;
use burnish_assets::{BACKDROPS, ENVIRONMENTS, SHAPES};
use burnish_renderer::tonemap::DisplayTransform;
use egui::{ComboBox, Grid, RichText, Ui, vec2};

/// Shows the page and edits the preferences in place.
pub fn show(ui: &mut Ui, preferences: &mut Preferences, keymap: &mut Keymap, recording: &mut Option<Command>) {
    grid(ui, "New scenes", |ui| {
        row(
            ui,
            "Unit of lengths",
            "How large one unit of a new material's lengths is. A file that is open keeps its own.",
            |ui| {
                number(ui, "Unit of lengths, mm", &mut preferences.unit_mm, 1.0, UNIT_MM);
                ui.label("mm");
            },
        );
        row(ui, "Mesh at start", "What carries the material when the window opens.", |ui| {
            let all: Vec<(String, &str)> = SHAPES.iter().map(|def| (def.name.to_owned(), def.label)).collect();
            choice(ui, "Mesh at start", &mut preferences.mesh, &all);
        });
        row(ui, "Backdrop at start", "What the mesh stands on when the window opens.", |ui| {
            let own = (OWN_BACKDROP.to_owned(), AS_IT_COMES);
            let all: Vec<(String, &str)> =
                std::iter::once(own).chain(BACKDROPS.iter().map(|def| (def.name.to_owned(), def.label))).collect();
            choice(ui, "Backdrop at start", &mut preferences.backdrop, &all);
        });
        row(ui, "Light at start", "What lights the scene when the window opens.", |ui| {
            let all: Vec<(String, &str)> = ENVIRONMENTS.iter().map(|def| (def.name.to_owned(), def.label)).collect();
            choice(ui, "Light at start", &mut preferences.light, &all);
        });
        row(ui, "Display transform", "How radiance becomes screen colours when the window opens.", |ui| {
            choice(ui, "Display transform at start", &mut preferences.display, &DisplayTransform::ALL);
        });
    });
    grid(ui, "Work", |ui| {
        row(ui, "Keep unsaved work", "Unsaved work is kept this often, for the case that the program ends badly.", |ui| {
            ui.label("every");
            number(ui, "Keep unsaved work every, seconds", &mut preferences.autosave_seconds, 0.1, AUTOSAVE_SECONDS);
            ui.label("s");
        });
        row(ui, "Threads", "How many threads the final view uses; all of them is fastest.", |ui| {
            let mut is_limited = preferences.threads.is_some();
            if ui.checkbox(&mut is_limited, "at most").accessible_name("Limit threads").changed() {
                preferences.threads = is_limited.then_some(1);
            }
            if let Some(threads) = &mut preferences.threads {
                let mut count = *threads as f64;
                number(ui, "Threads", &mut count, 0.1, *THREADS.start() as f64..=*THREADS.end() as f64);
                *threads = (count.round() as usize).max(1);
            }
        });
    });
    grid(ui, "Mouse", |ui| {
        row(ui, "Scheme", "Which buttons orbit, pan and zoom in the picture.", |ui| {
            let names =
                [(MouseScheme::Designer, "Designer"), (MouseScheme::Maya, "Painter, Maya"), (MouseScheme::Blender, "Blender")];
            choice(ui, "Mouse scheme", &mut preferences.mouse, &names);
        });
        row(ui, "Wheel", "Turns zooming with the wheel around.", |ui| {
            ui.checkbox(&mut preferences.is_wheel_flipped, "zooms the other way");
        });
        ui.label("");
        ui.vertical(|ui| {
            for (what, how) in help::mouse(preferences.mouse) {
                ui.label(RichText::new(format!("{what}: {how}")).small().color(theme::now().weak));
            }
        });
        ui.end_row();
    });
    grid(ui, "Look", |ui| {
        row(ui, "Theme", "Colours of the panels; the picture stands in grey in each.", |ui| {
            let names = [(ThemeName::Dark, "Dark"), (ThemeName::Grey, "Middle grey"), (ThemeName::Light, "Light")];
            choice(ui, "Theme", &mut preferences.theme, &names);
        });
        row(ui, "Size of text", "Enlarges all text and what holds it.", |ui| {
            let mut percent = (f64::from(preferences.text_scale) * 100.0).round();
            number(
                ui,
                "Size of text, percent",
                &mut percent,
                1.0,
                f64::from(*TEXT_SCALE.start()) * 100.0..=f64::from(*TEXT_SCALE.end()) * 100.0,
            );
            preferences.text_scale = (percent / 100.0) as f32;
            ui.label("%");
        });
        row(ui, "Motion", "Nothing fades or slides.", |ui| {
            ui.checkbox(&mut preferences.is_motion_reduced, "reduced");
        });
    });
    keys(ui, keymap, recording);
}

fn keys(ui: &mut Ui, keymap: &mut Keymap, recording: &mut Option<Command>) {
    if let Some(command) = *recording {
        if ui.input_mut(|i| i.consume_key(egui::Modifiers::NONE, egui::Key::Escape)) {
            *recording = None;
        } else if let Some(shortcut) = keymap::recorded(ui.ctx()) {
            keymap.set(command, vec![shortcut]);
            *recording = None;
        }
    }
    grid(ui, "Keys", |ui| {
        for def in COMMANDS {
            ui.label(def.text).on_hover_text(def.tooltip);
            ui.horizontal(|ui| {
                let is_awaited = *recording == Some(def.command);
                let shown: Vec<String> = keymap.keys(def.command).iter().map(keymap::shown).collect();
                let text = if is_awaited {
                    "press keys, or Esc".to_owned()
                } else if shown.is_empty() {
                    "none".to_owned()
                } else {
                    shown.join(", ")
                };
                let button = ui.add(egui::Button::selectable(is_awaited, text).min_size(vec2(120.0, 0.0)));
                if button.accessible_name(format!("Keys of {}", def.text)).on_hover_text("Choose other keys").clicked() {
                    *recording = Some(def.command);
                }
                let clear = ui.add_enabled(!shown.is_empty(), egui::Button::new("×").frame_when_inactive(false));
                if clear.accessible_name(format!("No keys for {}", def.text)).clicked() {
                    keymap.set(def.command, Vec::new());
                }
                let reset = ui.add_enabled(keymap.is_chosen(def.command), egui::Button::new("⟲").frame_when_inactive(false));
                if reset.accessible_name(format!("Reset keys of {}", def.text)).on_hover_text("The usual keys").clicked() {
                    keymap.reset(def.command);
                }
            });
            ui.end_row();
        }
    });
}

fn grid(ui: &mut Ui, title: &str, content: impl FnOnce(&mut Ui)) {
    ui.add_space(4.0);
    ui.label(RichText::new(title).heading().color(theme::now().strong));
    Grid::new(title).num_columns(2).spacing(vec2(16.0, 5.0)).min_col_width(150.0).show(ui, content);
    ui.add_space(4.0);
}

fn row(ui: &mut Ui, name: &str, hint: &str, content: impl FnOnce(&mut Ui)) {
    ui.label(name).on_hover_text(hint);
    ui.horizontal(content);
    ui.end_row();
}

fn number(ui: &mut Ui, name: &str, value: &mut f64, speed: f64, range: std::ops::RangeInclusive<f64>) {
    if let Some(new) = (NumberField { range, ..NumberField::plain(name, 70.0, speed) }).show(ui, *value) {
        *value = new;
    }
}

/// A list to choose from; `name` is for screen readers.
pub(super) fn choice<T: Clone + PartialEq>(ui: &mut Ui, name: &str, value: &mut T, all: &[(T, &str)]) {
    let shown = all.iter().find(|(choice, _)| choice == value).map_or("", |(_, word)| *word);
    let width = ui.available_width().clamp(40.0, 150.0);
    let combo = ComboBox::from_id_salt(name).width(width).selected_text(shown).show_ui(ui, |ui| {
        for (choice, word) in all {
            ui.selectable_value(value, choice.clone(), *word);
        }
    });
    combo.response.accessible_name(name);
}
