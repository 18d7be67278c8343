//! Clicks, typing and keys that move the keyboard, in the order in which they were made.
//!
//! Slow frames gather events. But a widget takes the keyboard when it is drawn, after commands have looked at the keys, and Tab and Escape take it away before
//! anything is drawn. What is typed into a number after the click on it would be taken for commands, and what is typed before a Tab would be lost.
//! So what comes after such a change waits for the next frame.

use egui::{Context, Event, Key, Plugin, RawInput, ViewportId};

/// Divides the events of a frame where the keyboard changes hands.
#[derive(Default)]
pub struct TypingInOrder {
    waiting: Vec<Event>,
}

impl Plugin for TypingInOrder {
    fn debug_name(&self) -> &'static str {
        "typing in order"
    }

    fn input_hook(&mut self, ctx: &Context, input: &mut RawInput) {
        if input.viewport_id != ViewportId::ROOT {
            return;
        }
        self.waiting.append(&mut input.events);
        let rest = self.waiting.split_off(end_of_frame(&self.waiting));
        input.events = std::mem::replace(&mut self.waiting, rest);
        if !self.waiting.is_empty() {
            ctx.request_repaint();
        }
    }
}

/// How many of these events belong to this frame: those before the first key that follows a click, and before a Tab or Escape that follows a key.
fn end_of_frame(events: &[Event]) -> usize {
    let (mut has_click, mut has_key) = (false, false);
    let is_of_next = |event: &Event| {
        let is_key = is_key(event);
        if is_key && (has_click || has_key && moves_keyboard(event)) {
            return true;
        }
        has_click |= matches!(event, Event::PointerButton { pressed: false, .. });
        has_key |= is_key;
        false
    };
    events.iter().position(is_of_next).unwrap_or(events.len())
}

fn is_key(event: &Event) -> bool {
    matches!(
        event,
        Event::Key { pressed: true, .. } | Event::Text(_) | Event::Paste(_) | Event::Copy | Event::Cut | Event::Ime(_)
    )
}

fn moves_keyboard(event: &Event) -> bool {
    matches!(event, Event::Key { key: Key::Tab | Key::Escape, .. })
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui::{Modifiers, PointerButton, pos2};

    fn key(key: Key, pressed: bool) -> Event {
        Event::Key { key, physical_key: None, pressed, repeat: false, modifiers: Modifiers::NONE }
    }

    fn button(pressed: bool) -> Event {
        Event::PointerButton { pos: pos2(1.0, 1.0), button: PointerButton::Primary, pressed, modifiers: Modifiers::NONE }
    }

    /// What each frame gets, when all events come with the first.
    fn frames(events: &[Event]) -> Vec<Vec<Event>> {
        let (ctx, mut plugin) = (Context::default(), TypingInOrder::default());
        let mut input = RawInput { events: events.to_vec(), ..RawInput::default() };
        let mut frames = Vec::new();
        loop {
            plugin.input_hook(&ctx, &mut input);
            frames.push(std::mem::take(&mut input.events));
            if plugin.waiting.is_empty() {
                return frames;
            }
            assert!(ctx.has_requested_repaint(), "what waits comes at once");
        }
    }

    #[test]
    fn keys_wait_for_the_frame_after_a_click() {
        let typed = [key(Key::Num2, true), Event::Text("2".to_owned()), key(Key::Num2, false), key(Key::Enter, true)];
        let click = [button(true), button(false)];
        assert_eq!(frames(&[&click[..], &typed].concat()), [click.to_vec(), typed.to_vec()]);
        assert_eq!(frames(&[&typed[..], &click].concat()), [[&typed[..], &click].concat()], "keys before it do not");
        let all = [&click[..], &typed, &click, &typed].concat();
        let middle = [&typed[..], &click].concat();
        assert_eq!(frames(&all), [click.to_vec(), middle, typed.to_vec()], "nothing is lost or comes out of turn");
        // Keys that are let go, and the mouse, type nothing.
        let moved = [button(true), button(false), key(Key::Enter, false), Event::PointerMoved(pos2(2.0, 2.0)), button(true)];
        assert_eq!(frames(&moved), [moved.to_vec()]);
    }

    #[test]
    fn tab_and_escape_do_not_overtake_what_was_typed() {
        let text = |text: &str| Event::Text(text.to_owned());
        let [tab, escape] = [key(Key::Tab, true), key(Key::Escape, true)];
        let all = [text("1"), tab.clone(), text("2"), tab.clone(), tab.clone(), escape.clone()];
        let expected = [vec![text("1")], vec![tab.clone(), text("2")], vec![tab.clone()], vec![tab], vec![escape]];
        assert_eq!(frames(&all), expected);
    }

    #[test]
    fn other_windows_are_left_alone() {
        let events = vec![button(false), Event::Text("2".to_owned())];
        let viewport_id = ViewportId::from_hash_of("other");
        let mut input = RawInput { events: events.clone(), viewport_id, ..RawInput::default() };
        let mut plugin = TypingInOrder::default();
        plugin.input_hook(&Context::default(), &mut input);
        assert_eq!((input.events, plugin.waiting), (events, Vec::new()));
    }
}
