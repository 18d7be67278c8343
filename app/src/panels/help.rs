//! All keys, and what the mouse does.

use crate::command::{COMMANDS, Menu};
use crate::keymap::{self, Keymap};
use crate::preferences::MouseScheme;
use crate::theme;
use egui::{Grid, RichText, Ui, vec2};

/// What the mouse does in the picture, by scheme: action and gesture.
pub const fn mouse(scheme: MouseScheme) -> &'static [(&'static str, &'static str)] {
    match scheme {
        MouseScheme::Designer => &[
            ("Orbit", "left drag"),
            ("Pan", "middle drag, or Ctrl + right drag"),
            ("Zoom", "wheel, or right drag"),
            ("Turn the environment", "Shift + right drag"),
        ],
        MouseScheme::Maya => &[
            ("Orbit", "Alt + left drag"),
            ("Pan", "Alt + middle drag"),
            ("Zoom", "wheel, or Alt + right drag"),
            ("Turn the environment", "Shift + right drag"),
        ],
        MouseScheme::Blender => &[
            ("Orbit", "middle drag"),
            ("Pan", "Shift + middle drag"),
            ("Zoom", "wheel, or Ctrl + middle drag"),
            ("Turn the environment", "Shift + right drag"),
        ],
    }
}

const NUMBERS: &[(&str, &str)] = &[
    ("Change", "drag; Shift finer, Ctrl in steps, Esc back"),
    ("Type", "click or Tab to it; 20/64, 0.5*2, 12 mm, 90 deg, 30%; Enter, Tab goes on, Esc back"),
    ("Step", "Ctrl + wheel under the pointer; arrow keys in it"),
    ("Negate", "Minus under the pointer"),
    ("Reset", "Backspace under the pointer, two clicks on the name or track, its menu, the button ⟲"),
    ("Copy and paste", "Ctrl+C and Ctrl+V under the pointer; with Alt a whole colour"),
    ("Reference", "F1 under the pointer"),
];

const TRACKPAD: &[(&str, &str)] = &[("Orbit", "two fingers"), ("Pan", "Shift + two fingers"), ("Zoom", "pinch")];

/// Shows the page.
pub fn show(ui: &mut Ui, keymap: &Keymap, scheme: MouseScheme) {
    section(ui, "Mouse in the picture", mouse(scheme));
    section(ui, "Trackpad", TRACKPAD);
    section(ui, "Numbers and colours", NUMBERS);
    for (menu, title) in Menu::ALL {
        let rows: Vec<(&str, String)> = COMMANDS
            .iter()
            .filter(|def| def.menu == menu)
            .map(|def| (def.text, keymap.keys(def.command).iter().map(keymap::shown).collect::<Vec<_>>().join(", ")))
            .filter(|(_, keys)| !keys.is_empty())
            .collect();
        let rows: Vec<(&str, &str)> = rows.iter().map(|(text, keys)| (*text, keys.as_str())).collect();
        section(ui, title, &rows);
    }
}

fn section(ui: &mut Ui, title: &str, rows: &[(&str, &str)]) {
    ui.add_space(4.0);
    ui.label(RichText::new(title).heading().color(theme::now().strong));
    Grid::new(title).num_columns(2).spacing(vec2(18.0, 3.0)).min_col_width(170.0).show(ui, |ui| {
        for (what, how) in rows {
            ui.label(*what);
            ui.label(RichText::new(*how).color(theme::now().weak));
            ui.end_row();
        }
    });
}
