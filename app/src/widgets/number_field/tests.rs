use super::*;
use crate::typing::TypingInOrder;
use egui::{Context, PointerButton, RawInput, pos2};

#[test]
fn drags_move_by_points_and_snap() {
    assert_eq!(Scale::Linear(0.01).moved(0.3, 12.0), 0.42);
    let twice = Scale::Logarithmic.moved(2.0, 100.0 * 2_f64.ln());
    assert!((twice - 4.0).abs() < 1e-12, "{twice}");
    assert_eq!(Scale::Logarithmic.moved(2.0, -5000.0), 0.0);
    assert!(Scale::Logarithmic.moved(0.0, 10.0) > 0.0);
    assert_eq!(tidied(0.423_456, 0.05, Modifiers::NONE), 0.4235);
    assert_eq!(tidied(0.423_456, 0.05, Modifiers::SHIFT), 0.423_46);
    assert_eq!(tidied(0.423_456, 0.05, Modifiers::COMMAND), 0.4);
    assert_eq!(tidied(1e-9, 0.05, Modifiers::NONE), 0.0);
}

/// What a field of 0.25 becomes with these events, frame by frame, and the text keys that were left to commands.
fn shown(frames: &[&[Event]]) -> (f64, usize) {
    let (ctx, mut value, mut left) = (Context::default(), 0.25, 0);
    ctx.add_plugin(TypingInOrder::default());
    for events in [&[][..], &[]].iter().chain(frames).chain(&[&[][..]; 4]) {
        let input = RawInput { events: events.to_vec(), ..RawInput::default() };
        let output = ctx.run_ui(input, |ui| {
            // As commands look at keys: before anything is drawn, unless a text is being typed.
            let is_typing = ui.ctx().text_edit_focused();
            left += ui.input(|i| i.events.iter().filter(|event| matches!(event, Event::Text(_)) && !is_typing).count());
            value = NumberField::plain("number", 60.0, 0.01).show(ui, value).unwrap_or(value);
        });
        output.drop_without_applying_deltas();
    }
    (value, left)
}

fn keys(keys: &[(Key, Option<&str>)]) -> Vec<Event> {
    let event = |key, pressed| Event::Key { key, physical_key: None, pressed, repeat: false, modifiers: Modifiers::NONE };
    let typed = |text: Option<&str>| text.map(|text| Event::Text(text.to_owned()));
    keys.iter().flat_map(|(key, text)| [Some(event(*key, true)), typed(*text), Some(event(*key, false))]).flatten().collect()
}

#[test]
fn what_is_typed_in_the_frame_of_the_click_is_not_lost() {
    let pos = pos2(10.0, 10.0);
    let button = |pressed| Event::PointerButton { pos, button: PointerButton::Primary, pressed, modifiers: Modifiers::NONE };
    let (press, release) = ([Event::PointerMoved(pos), button(true)], [button(false)]);
    let typed = keys(&[(Key::Minus, Some("-")), (Key::Num2, Some("2"))]);
    let [enter, escape, backspace] = [Key::Enter, Key::Escape, Key::Backspace].map(|key| keys(&[(key, None)]));
    let joined = |parts: &[&[Event]]| parts.concat();
    for (frames, expected) in [
        (vec![joined(&[&press, &release, &typed, &enter])], -2.0),
        (vec![joined(&[&press, &release, &typed]), enter.clone()], -2.0),
        (vec![press.to_vec(), joined(&[&release, &typed]), enter.clone()], -2.0),
        (vec![joined(&[&press, &release]), joined(&[&typed, &enter])], -2.0),
        // The whole number is replaced, or none of it.
        (vec![joined(&[&press, &release, &backspace, &keys(&[(Key::Num3, Some("3"))]), &enter])], 3.0),
        (vec![joined(&[&press, &release, &typed, &escape])], 0.25),
        (vec![joined(&[&press, &release, &enter])], 0.25),
    ] {
        let frames: Vec<&[Event]> = frames.iter().map(Vec::as_slice).collect();
        assert_eq!(shown(&frames), (expected, 0), "{frames:?}");
    }
    // Without a click the keys are no text of the field.
    assert_eq!(shown(&[&typed]), (0.25, 2));
}
