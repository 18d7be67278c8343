//! A list to type into: commands, properties and presets, or files.

use crate::command::{COMMANDS, Command};
use crate::keymap::Keymap;
use crate::pages::Pages;
use crate::theme;
use burnish_material::{PROPERTIES, Property};
use burnish_presets::Preset;
use egui::text::{CCursor, CCursorRange};
use egui::text_edit::TextEditState;
use egui::{Align2, Button, Context, Id, Key, Modal, Modifiers, RichText, ScrollArea, TextEdit};
use std::path::{Path, PathBuf};

/// Rows shown at most.
const MAX_FOUND: usize = 60;

/// What can be chosen.
#[derive(Clone, Debug)]
pub enum Choice {
    /// Carry it out.
    Command(Command),
    /// Go to its row.
    Property(Property),
    /// Load it.
    Preset(&'static Preset),
    /// Open it.
    File(PathBuf),
}

/// A row of the list.
#[derive(Clone, Debug)]
pub struct Found {
    /// What it stands for.
    pub choice: Choice,
    /// What it says.
    pub text: String,
    /// Keys, or where it belongs.
    pub note: String,
}

/// How well the typed words fit a text: all must occur; at the start of words is best. `None` if they do not.
fn score(text: &str, typed: &str) -> Option<usize> {
    let text = text.to_lowercase();
    let mut total = 0;
    for word in typed.to_lowercase().split_whitespace() {
        let at = text.find(word)?;
        let is_start = at == 0 || !text.as_bytes()[at - 1].is_ascii_alphanumeric();
        total += at.min(50) + if is_start { 0 } else { 100 };
    }
    Some(total)
}

/// What fits the typed text, best first.
pub fn find(typed: &str, keymap: &Keymap, is_possible: impl Fn(Command) -> bool) -> Vec<Found> {
    let mut found: Vec<(usize, Found)> = Vec::new();
    for def in COMMANDS.iter().filter(|def| def.command != Command::Palette && is_possible(def.command)) {
        let by_text = score(def.text, typed);
        if let Some(score) = by_text.or_else(|| score(def.tooltip, typed).map(|score| score + 300)) {
            let choice = Choice::Command(def.command);
            found.push((score, Found { choice, text: def.text.to_owned(), note: keymap.shown(def.command) }));
        }
    }
    if !typed.trim().is_empty() {
        for def in PROPERTIES {
            let best = [def.label, def.name, def.usage].iter().filter_map(|name| score(name, typed)).min();
            if let Some(score) = best {
                let note = format!("property, {}", def.name);
                found.push((score + 20, Found { choice: Choice::Property(def.id), text: def.label.to_owned(), note }));
            }
        }
        for preset in burnish_presets::search(typed) {
            let score = score(preset.name, typed).map_or(400, |score| score + 40);
            let note = format!("preset, {}", burnish_presets::group_title(preset.group));
            found.push((score, Found { choice: Choice::Preset(preset), text: preset.name.to_owned(), note }));
        }
    }
    found.sort_by_key(|(score, _)| *score);
    found.into_iter().map(|(_, found)| found).take(MAX_FOUND).collect()
}

/// The files whose names fit, in their order; which are not there is said.
pub fn find_files(typed: &str, paths: &[PathBuf], missing: &[bool]) -> Vec<Found> {
    let name = |path: &Path| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let row = |(path, is_missing): (&PathBuf, &bool)| Found {
        choice: Choice::File(path.clone()),
        text: name(path),
        note: format!("{}{}", if *is_missing { "⚠ not there: " } else { "" }, path.display()),
    };
    paths.iter().zip(missing).filter(|(path, _)| score(&path.to_string_lossy(), typed).is_some()).map(row).collect()
}

/// Shows the list; which row was chosen, and whether it is to close.
pub fn show(ctx: &Context, name: &str, hint: &str, pages: &mut Pages, found: &[Found]) -> (Option<usize>, bool) {
    let last = found.len().saturating_sub(1);
    pages.marked = pages.marked.min(last);
    let (up, down, enter) = ctx.input_mut(|input| {
        let mut pressed = |key| input.consume_key(Modifiers::NONE, key);
        (pressed(Key::ArrowUp), pressed(Key::ArrowDown), pressed(Key::Enter))
    });
    if down {
        pages.marked = (pages.marked + 1).min(last);
    }
    if up {
        pages.marked = pages.marked.saturating_sub(1);
    }
    let is_confirmed = std::mem::take(&mut pages.is_confirmed);
    let mut chosen = (enter || is_confirmed).then_some(pages.marked).filter(|index| *index < found.len());
    let area = Modal::default_area(Id::unique("palette")).anchor(Align2::CENTER_TOP, [0.0, 70.0]);
    let response = Modal::new(Id::unique("palette")).area(area).show(ctx, |ui| {
        ui.set_width(460.0);
        let edit = TextEdit::singleline(&mut pages.search).hint_text(hint).desired_width(f32::INFINITY);
        let edit = ui.add(edit).accessible_name(name);
        if edit.changed() {
            pages.marked = 0;
            // What was found is not yet what is typed: a slow frame takes both at once.
            if enter {
                (chosen, pages.is_confirmed) = (None, true);
                ui.request_repaint();
            }
        }
        if !edit.has_focus() {
            // Letters that came with the shortcut stand there already; what is typed goes on behind them.
            let mut state = TextEditState::load(ui.ctx(), edit.id).unwrap_or_default();
            state.cursor.set_char_range(Some(CCursorRange::one(CCursor::new(pages.search.chars().count()))));
            state.store(ui.ctx(), edit.id);
        }
        edit.request_focus();
        ui.add_space(4.0);
        ScrollArea::vertical().max_height(320.0).auto_shrink([false, true]).show(ui, |ui| {
            if found.is_empty() {
                ui.label(RichText::new("Nothing has this in its name.").color(theme::now().weak));
            }
            for (index, row) in found.iter().enumerate() {
                let is_marked = index == pages.marked;
                let button = Button::selectable(is_marked, row.text.as_str()).shortcut_text(row.note.as_str()).truncate();
                let response = ui.add_sized([ui.available_width(), ui.spacing().interact_size.y], button);
                if is_marked && (up || down) {
                    response.scroll_to_me(None);
                }
                if response.clicked() {
                    chosen = Some(index);
                }
            }
        });
    });
    (chosen, response.should_close())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_best_fit_comes_first() {
        let first = |typed: &str| find(typed, &Keymap::default(), |_| true).into_iter().next().map(|found| found.text);
        assert_eq!(first("save as").as_deref(), Some("Save as…"));
        assert_eq!(first("anisotropyAngle").as_deref(), Some("Anisotropy angle"));
        assert_eq!(first("gold").map(|text| text.contains("Gold")), Some(true));
        assert_eq!(first("no such thing"), None);
        assert!(find("", &Keymap::default(), |_| true).len() > 30);
    }

    #[test]
    fn enter_waits_for_the_text_that_came_with_it() {
        let ctx = Context::default();
        let mut pages = Pages::default();
        let mut frame = |events: Vec<egui::Event>| {
            let found = find(&pages.search, &Keymap::default(), |_| true);
            let mut chosen = None;
            let mut output = ctx.run_ui(egui::RawInput { events, ..Default::default() }, |ui| {
                chosen = show(ui.ctx(), "Find", "", &mut pages, &found).0.or(chosen);
            });
            // Nothing is drawn here, so the font's texture is dropped on purpose.
            output.textures_delta.clear();
            chosen.map(|index| found[index].text.clone())
        };
        let enter =
            egui::Event::Key { key: Key::Enter, physical_key: None, pressed: true, repeat: false, modifiers: Modifiers::NONE };
        assert_eq!((frame(Vec::new()), frame(Vec::new())), (None, None));
        assert_eq!(frame(vec![egui::Event::Text("save as".into()), enter]), None);
        assert_eq!(frame(Vec::new()).as_deref(), Some("Save as…"));
    }
}
