//! Which keys carry out which commands: the table's, unless the user chose others.

use crate::command::{COMMANDS, Command};
use egui::{Context, Key, KeyboardShortcut, ModifierNames, Modifiers};
use std::collections::BTreeMap;

/// The keys of this user.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Keymap {
    /// Commands whose keys are not the table's; an empty list means none.
    chosen: BTreeMap<Command, Vec<KeyboardShortcut>>,
}

impl Keymap {
    /// The keys as stored: command names with key texts. What cannot be read is told and left out.
    pub fn from_stored(stored: &BTreeMap<String, Vec<String>>) -> (Self, Vec<String>) {
        let (mut map, mut problems) = (Self::default(), Vec::new());
        for (id, texts) in stored {
            let Some(command) = Command::from_id(id) else {
                problems.push(format!("preferences: shortcuts: {id}: expected the name of a command"));
                continue;
            };
            let mut keys = Vec::new();
            for text in texts {
                match parse(text) {
                    Some(shortcut) => keys.push(shortcut),
                    None => {
                        problems.push(format!("preferences: shortcuts: {id}: expected keys such as Ctrl+Shift+S, found {text}"))
                    }
                }
            }
            map.chosen.insert(command, keys);
        }
        (map, problems)
    }

    /// The keys for storing.
    pub fn to_stored(&self) -> BTreeMap<String, Vec<String>> {
        let texts = |keys: &Vec<KeyboardShortcut>| keys.iter().map(text).collect();
        self.chosen.iter().map(|(command, keys)| (command.def().id.to_owned(), texts(keys))).collect()
    }

    /// The keys of a command, the one that menus show first.
    pub fn keys(&self, command: Command) -> &[KeyboardShortcut] {
        self.chosen.get(&command).map_or(command.def().keys, Vec::as_slice)
    }

    /// Whether the user chose these.
    pub fn is_chosen(&self, command: Command) -> bool {
        self.chosen.contains_key(&command)
    }

    /// Gives a command these keys and takes them from others; returns who lost them.
    pub fn set(&mut self, command: Command, keys: Vec<KeyboardShortcut>) -> Vec<Command> {
        let mut robbed = Vec::new();
        for other in COMMANDS.iter().map(|def| def.command).filter(|other| *other != command) {
            let left: Vec<KeyboardShortcut> =
                self.keys(other).iter().copied().filter(|shortcut| !keys.contains(shortcut)).collect();
            if left.len() != self.keys(other).len() {
                self.chosen.insert(other, left);
                robbed.push(other);
            }
        }
        if keys == command.def().keys {
            self.chosen.remove(&command);
        } else {
            self.chosen.insert(command, keys);
        }
        robbed
    }

    /// The table's keys again.
    pub fn reset(&mut self, command: Command) {
        self.set(command, command.def().keys.to_vec());
    }

    /// How menus and tooltips write the first key of a command; empty if it has none.
    pub fn shown(&self, command: Command) -> String {
        self.keys(command).first().map_or_else(String::new, shown)
    }

    /// The commands whose keys were pressed. Keys that type or move a cursor are left to a text field that has the focus, arrows to anything
    /// that has it.
    pub fn pressed(&self, ctx: &Context) -> Vec<Command> {
        let is_typing = ctx.text_edit_focused();
        let is_focused = ctx.memory(|memory| memory.focused().is_some());
        ctx.input_mut(|input| {
            let mut keys: Vec<(Command, KeyboardShortcut)> =
                COMMANDS.iter().flat_map(|def| self.keys(def.command).iter().map(move |keys| (def.command, *keys))).collect();
            // Longer shortcuts first: Ctrl+Shift+Z also contains Ctrl+Z.
            keys.sort_by_key(|(_, keys)| std::cmp::Reverse(u8::from(keys.modifiers.shift) + u8::from(keys.modifiers.command)));
            keys.into_iter()
                .filter(|(command, keys)| !is_typing || !(keys.conflicts_with_text_editing() || is_own_to_text_fields(*command)))
                .filter(|(_, keys)| !is_focused || !is_arrow(keys.logical_key))
                .filter(|(_, keys)| input.consume_shortcut(keys))
                .map(|(command, _)| command)
                .collect()
        })
    }
}

/// Whether a text field has its own meaning for the keys: undo there takes back typing.
fn is_own_to_text_fields(command: Command) -> bool {
    matches!(command, Command::Undo | Command::Redo)
}

fn is_arrow(key: Key) -> bool {
    matches!(key, Key::ArrowUp | Key::ArrowDown | Key::ArrowLeft | Key::ArrowRight)
}

/// A shortcut in words that [`parse`] reads on every system: `Ctrl+Shift+Z`, where Ctrl is the command key of a Mac.
pub fn text(shortcut: &KeyboardShortcut) -> String {
    let mut parts = Vec::new();
    for (is_held, name) in [
        (shortcut.modifiers.command || shortcut.modifiers.ctrl, "Ctrl"),
        (shortcut.modifiers.alt, "Alt"),
        (shortcut.modifiers.shift, "Shift"),
    ] {
        if is_held {
            parts.push(name);
        }
    }
    parts.push(shortcut.logical_key.name());
    parts.join("+")
}

/// Reads `Ctrl+Shift+Z`, `F11` or `[`.
pub fn parse(text: &str) -> Option<KeyboardShortcut> {
    let (held, key) = match text.rsplit_once('+') {
        // The plus key itself.
        Some((held, "")) => (held.strip_suffix('+').unwrap_or(held), "Plus"),
        Some((held, key)) => (held, key),
        None => ("", text),
    };
    let mut modifiers = Modifiers::NONE;
    for name in held.split('+').map(str::trim).filter(|name| !name.is_empty()) {
        match name.to_lowercase().as_str() {
            "ctrl" | "cmd" | "command" => modifiers.command = true,
            "alt" | "option" => modifiers.alt = true,
            "shift" => modifiers.shift = true,
            _ => return None,
        }
    }
    Some(KeyboardShortcut::new(modifiers, Key::from_name(key.trim())?))
}

/// The shortcut that is being pressed, if it is one: for choosing keys. Esc and Tab stay what they are everywhere.
pub fn recorded(ctx: &Context) -> Option<KeyboardShortcut> {
    ctx.input_mut(|input| {
        let found = input.events.iter().find_map(|event| match event {
            egui::Event::Key { key, pressed: true, modifiers, .. } if !matches!(key, Key::Escape | Key::Tab) => {
                let modifiers = Modifiers {
                    command: modifiers.command || modifiers.ctrl,
                    alt: modifiers.alt,
                    shift: modifiers.shift,
                    ..Modifiers::NONE
                };
                Some(KeyboardShortcut::new(modifiers, *key))
            }
            _ => None,
        })?;
        input.events.clear();
        Some(found)
    })
}

/// How menus and tooltips write a shortcut: with the signs that are on the keys.
pub fn shown(shortcut: &KeyboardShortcut) -> String {
    let names = if cfg!(target_os = "macos") { ModifierNames::SYMBOLS } else { ModifierNames::NAMES };
    let held = names.format(&shortcut.modifiers, cfg!(target_os = "macos"));
    let between = if held.is_empty() || cfg!(target_os = "macos") { "" } else { "+" };
    format!("{held}{between}{}", shortcut.logical_key.symbol_or_name())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_survive_storing() {
        for def in COMMANDS {
            for keys in def.keys {
                assert_eq!(parse(&text(keys)), Some(*keys), "{}", text(keys));
            }
        }
        assert_eq!(parse("Ctrl+Nonsense"), None);
        assert_eq!(parse("Hyper+S"), None);
        let mut map = Keymap::default();
        let robbed = map.set(Command::New, vec![parse("Ctrl+S").unwrap()]);
        assert_eq!(robbed, [Command::Save]);
        assert!(map.keys(Command::Save).is_empty());
        let (again, problems) = Keymap::from_stored(&map.to_stored());
        assert_eq!((again, problems.len()), (map, 0));
        let stored = BTreeMap::from([("file.never".to_owned(), Vec::new()), ("file.new".to_owned(), vec!["?!".to_owned()])]);
        assert_eq!(Keymap::from_stored(&stored).1.len(), 2);
    }

    #[test]
    fn the_longer_shortcut_wins() {
        let ctx = Context::default();
        let event = |modifiers| egui::Event::Key { key: Key::Z, physical_key: None, pressed: true, repeat: false, modifiers };
        for (shift, command) in [(true, Command::Redo), (false, Command::Undo)] {
            let modifiers = Modifiers { ctrl: true, command: true, shift, ..Modifiers::NONE };
            let input = egui::RawInput { events: vec![event(modifiers)], ..Default::default() };
            let mut pressed = Vec::new();
            let mut output = ctx.run_ui(input, |ui| pressed.extend(Keymap::default().pressed(ui.ctx())));
            // Nothing is drawn here, so the font's texture is dropped on purpose.
            output.textures_delta.clear();
            assert_eq!(pressed, [command]);
        }
    }
}
