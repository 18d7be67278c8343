//! A number that is dragged, typed, stepped, copied or pasted. Showing it, or passing through it with the keyboard, never changes it.

#[cfg(test)]
mod tests;

use crate::theme;
use crate::widgets::{gesture, number};
use burnish_material::Unit;
use egui::text::{CCursor, CCursorRange};
use egui::text_edit::TextEditState;
use egui::{Button, CursorIcon, Event, Id, Key, Modifiers, Response, Sense, TextEdit, Ui, WidgetInfo, accesskit, vec2};
use std::ops::RangeInclusive;

/// Slower by this while Shift is held.
pub const FINE: f64 = 0.1;
/// Share of a logarithmic number that one point of dragging changes.
const LOG_SPEED: f64 = 0.01;
/// Below this a logarithmic number is 0 when it is dragged.
pub const LOG_FLOOR: f64 = 1e-4;

/// How a drag moves a number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Scale {
    /// By this much per point.
    Linear(f64),
    /// By a share of itself, with 0 below [`LOG_FLOOR`].
    Logarithmic,
}

impl Scale {
    /// The number after a drag of `points`.
    pub fn moved(self, from: f64, points: f64) -> f64 {
        match self {
            Self::Linear(speed) => from + speed * points,
            Self::Logarithmic => {
                let size = from.abs().max(LOG_FLOOR) * (LOG_SPEED * points).exp();
                if size <= LOG_FLOOR { 0.0 } else { size.copysign(from) }
            }
        }
    }

    /// A number of steps further: a twentieth of what 300 points would do, or a tenth of itself.
    pub fn stepped(self, from: f64, steps: f64, step: f64) -> f64 {
        match self {
            Self::Linear(_) => from + step * steps,
            Self::Logarithmic => self.moved(from, 10.0 * steps),
        }
    }
}

/// How a number is shown and edited.
pub struct NumberField<'a> {
    /// Accessible name.
    pub name: &'a str,
    /// Width in points.
    pub width: f32,
    /// How a drag moves it.
    pub scale: Scale,
    /// What Ctrl snaps to, and one notch of Ctrl + wheel.
    pub step: f64,
    /// What an edit may set; values that lie outside already stay.
    pub range: RangeInclusive<f64>,
    /// What may be typed after the number.
    pub unit: Unit,
    /// Millimetres per unit of length.
    pub unit_mm: f64,
    /// How it is written while it is not being typed.
    pub format: fn(f64) -> String,
}

/// In which pass a typed number was left with Tab, so that the next field drawn takes the focus.
fn tabbed() -> Id {
    Id::unique("a typed number was left with Tab")
}

/// A drag that goes on: where it began, and where it is without rounding.
#[derive(Clone, Copy, Default)]
struct Drag {
    start: f64,
    precise: f64,
}

impl<'a> NumberField<'a> {
    /// A field for a plain number without limits.
    pub fn plain(name: &'a str, width: f32, speed: f64) -> Self {
        Self {
            name,
            width,
            scale: Scale::Linear(speed),
            step: 10.0 * speed,
            range: f64::MIN..=f64::MAX,
            unit: Unit::None,
            unit_mm: 1.0,
            format: number::field,
        }
    }

    /// Shows `old` and returns the new value when it was edited.
    pub fn show(self, ui: &mut Ui, old: f64) -> Option<f64> {
        ui.push_id(self.name, |ui| {
            ui.spacing_mut().button_padding.x = 3.0;
            ui.set_max_width(self.width);
            self.show_inner(ui, old)
        })
        .inner
    }

    fn show_inner(self, ui: &mut Ui, old: f64) -> Option<f64> {
        // The same in both states, so that the keyboard finds it again.
        let id = ui.next_auto_id();
        if ui.is_enabled() && ui.data_mut(|data| data.remove_temp::<u64>(tabbed())) == Some(ui.ctx().cumulative_pass_nr()) {
            ui.memory_mut(|memory| memory.request_focus(id));
        }
        let is_typing = ui.is_enabled()
            && ui.memory_mut(|memory| {
                memory.interested_in_focus(id, ui.layer_id());
                memory.has_focus(id)
            });
        let mut new = self.asked(ui, id, old);
        if !is_typing
            // The text of a field that was left before it was drawn.
            && let Some(text) = ui.data_mut(|data| data.remove_temp::<String>(id.with("text")))
            && !ui.input(|i| i.key_pressed(Key::Escape))
        {
            new = self.typed(ui, &text, old).or(new);
            // Numbers are typed one after the other. Tab without typing stops at everything between.
            if new.is_some() && ui.input(|i| i.key_pressed(Key::Tab) && !i.modifiers.shift) {
                let pass = ui.ctx().cumulative_pass_nr();
                ui.data_mut(|data| data.insert_temp(tabbed(), pass));
            }
        }
        let response = if is_typing { self.text(ui, id, old, &mut new) } else { self.button(ui, old, &mut new) };
        response.widget_info(|| WidgetInfo::drag_value(ui.is_enabled(), new.unwrap_or(old)));
        self.describe(ui, &response, new.unwrap_or(old));
        new.filter(|new| *new != old)
    }

    /// What a typed text means; an untouched text stands for the number it was made from, with all its digits.
    fn typed(&self, ui: &Ui, text: &str, old: f64) -> Option<f64> {
        if text.trim() == (self.format)(old) {
            return None;
        }
        let value = number::parse(text, self.unit, self.unit_mm)?;
        gesture::end(ui.ctx());
        Some(self.limited(value))
    }

    fn limited(&self, value: f64) -> f64 {
        value.max(*self.range.start()).min(*self.range.end())
    }

    /// What a screen reader asks for.
    fn asked(&self, ui: &Ui, id: Id, old: f64) -> Option<f64> {
        use accesskit::{Action, ActionData};
        ui.input(|input| {
            let set = input.accesskit_action_requests(id, Action::SetValue).find_map(|request| match &request.data {
                Some(ActionData::NumericValue(value)) => Some(*value),
                Some(ActionData::Value(text)) => number::parse(text, self.unit, self.unit_mm),
                _ => None,
            });
            let steps = input.num_accesskit_action_requests(id, Action::Increment) as f64
                - input.num_accesskit_action_requests(id, Action::Decrement) as f64;
            set.or((steps != 0.0).then(|| number::rounded(self.scale.stepped(old, steps, self.step), 6)))
                .map(|value| self.limited(value))
        })
    }

    fn text(&self, ui: &mut Ui, id: Id, old: f64, new: &mut Option<f64>) -> Response {
        let text_id = id.with("text");
        let kept = ui.data_mut(|data| data.remove_temp::<String>(text_id));
        let mut text = kept.unwrap_or_else(|| {
            let text = (self.format)(old);
            select_all(ui, id, &text);
            text
        });
        let is_read = text.trim() == (self.format)(old) || number::parse(&text, self.unit, self.unit_mm).is_some();
        let color = if is_read { ui.visuals().strong_text_color() } else { theme::now().error };
        let steps = ui.input_mut(|input| {
            input.count_and_consume_key(Modifiers::NONE, Key::ArrowUp) as f64
                - input.count_and_consume_key(Modifiers::NONE, Key::ArrowDown) as f64
        });
        let edit = TextEdit::singleline(&mut text)
            .id(id)
            .clip_text(true)
            .align(ui.layout().align2())
            .min_size(vec2(self.width, ui.spacing().interact_size.y))
            .desired_width(0.0)
            .text_color(color);
        let output = edit.show(ui);
        if steps != 0.0 {
            *new = Some(self.limited(number::rounded(self.scale.stepped(old, steps, self.step), 6)));
            gesture::end(ui.ctx());
            return output.response.response;
        }
        if output.response.lost_focus() {
            if !ui.input(|i| i.key_pressed(Key::Escape)) {
                *new = self.typed(ui, &text, old).or(*new);
            }
        } else {
            ui.data_mut(|data| data.insert_temp(text_id, text));
        }
        let response = output.response.response;
        if is_read { response } else { response.on_hover_text("This is no number: the value stays as it is.") }
    }

    fn button(&self, ui: &mut Ui, old: f64, new: &mut Option<f64>) -> Response {
        let button = Button::new((self.format)(new.unwrap_or(old)))
            .truncate()
            .sense(Sense::click_and_drag())
            .min_size(vec2(self.width, ui.spacing().interact_size.y));
        let response = ui.add(button).on_hover_cursor(CursorIcon::ResizeHorizontal);
        if response.clicked() {
            ui.memory_mut(|memory| memory.request_focus(response.id));
            // From now on keys type: commands must not take the first of them.
            select_all(ui, response.id, &(self.format)(old));
        }
        if let Some(value) = dragged(ui, &response, old, |from, points| self.scale.moved(from, points), self.step) {
            *new = Some(self.limited(value));
        }
        if response.contains_pointer() && !ui.ctx().text_edit_focused() {
            *new = under_pointer(ui, old, self.scale, self.step).map(|value| self.limited(value)).or(*new);
            let read = |text: &str| number::parse(text, self.unit, self.unit_mm);
            *new = copy_paste(ui, || old.to_string(), read).map(|value| self.limited(value)).or(*new);
        }
        response
    }

    fn describe(&self, ui: &Ui, response: &Response, value: f64) {
        ui.ctx().accesskit_node_builder(response.id, |builder| {
            use accesskit::Action;
            for (limit, is_low) in [(*self.range.start(), true), (*self.range.end(), false)] {
                if limit.abs() < f64::MAX {
                    if is_low { builder.set_min_numeric_value(limit) } else { builder.set_max_numeric_value(limit) }
                }
            }
            builder.set_numeric_value_step(self.step);
            builder.add_action(Action::SetValue);
            builder.add_action(Action::Increment);
            builder.add_action(Action::Decrement);
            builder.set_value((self.format)(value) + self.unit.suffix());
            builder.set_label(self.name);
        });
    }
}

/// Lets what is typed next take the place of the whole text of a field.
fn select_all(ui: &Ui, id: Id, text: &str) {
    let mut state = TextEditState::load(ui.ctx(), id).unwrap_or_default();
    let range = CCursorRange::two(CCursor::default(), CCursor::new(text.chars().count()));
    state.cursor.set_char_range(Some(range));
    state.store(ui.ctx(), id);
}

/// The number after this frame's part of a drag: Shift is slower, Ctrl snaps, Esc goes back to the start.
///
/// `moved` says where a number is after so many points; up and to the right is more.
pub fn dragged(ui: &Ui, response: &Response, old: f64, moved: impl Fn(f64, f64) -> f64, step: f64) -> Option<f64> {
    let id = response.id.with("drag");
    if response.drag_started() {
        ui.data_mut(|data| data.insert_temp(id, Drag { start: old, precise: old }));
    }
    if response.drag_stopped() {
        // Esc ends a drag, like letting go.
        let drag = ui.data_mut(|data| data.remove_temp::<Drag>(id))?;
        return ui.input(|i| i.key_pressed(Key::Escape)).then(|| {
            gesture::cancel(ui.ctx());
            drag.start
        });
    }
    if !response.dragged() {
        return None;
    }
    let mut drag = ui.data(|data| data.get_temp::<Drag>(id))?;
    let (modifiers, delta) = (ui.input(|i| i.modifiers), response.drag_delta());
    let points = f64::from(delta.x - delta.y) * if modifiers.shift { FINE } else { 1.0 };
    if points == 0.0 {
        return None;
    }
    drag.precise = moved(drag.precise, points);
    ui.data_mut(|data| data.insert_temp(id, drag));
    Some(tidied(drag.precise, step, modifiers))
}

/// A dragged number without digits that nobody chose: on a step while Ctrl is held.
pub fn tidied(value: f64, step: f64, modifiers: Modifiers) -> f64 {
    if modifiers.command && step > 0.0 {
        return number::rounded((value / step).round() * step, 12);
    }
    let digits = if modifiers.shift { 5 } else { 4 };
    // Near zero a fixed number of digits would mean ever smaller numbers.
    if value.abs() < step * 1e-4 { 0.0 } else { number::rounded(value, digits) }
}

/// What keys and the wheel do to the number under the pointer: Ctrl + wheel steps, Minus negates.
pub fn under_pointer(ui: &Ui, old: f64, scale: Scale, step: f64) -> Option<f64> {
    let notches = ui.input_mut(|input| {
        let mut notches = 0.0;
        input.events.retain(|event| match event {
            Event::MouseWheel { delta, modifiers, .. } if modifiers.command && delta.y != 0.0 => {
                notches += f64::from(delta.y.signum());
                false
            }
            _ => true,
        });
        notches
    });
    if notches != 0.0 {
        return Some(number::rounded(scale.stepped(old, notches, step), 6));
    }
    ui.input_mut(|input| input.consume_key(Modifiers::NONE, Key::Minus)).then_some(-old)
}

/// Copies on Ctrl+C, and returns what Ctrl+V brought; with Alt they belong to the whole row.
pub fn copy_paste<T>(ui: &Ui, copied: impl FnOnce() -> String, read: impl Fn(&str) -> Option<T>) -> Option<T> {
    if ui.input(|input| input.modifiers.alt) {
        return None;
    }
    take_copy_paste(ui, copied, read)
}

/// The same, whatever keys are held. A text that cannot be read is left to what lies around.
pub fn take_copy_paste<T>(ui: &Ui, copied: impl FnOnce() -> String, read: impl Fn(&str) -> Option<T>) -> Option<T> {
    let (mut is_copied, mut pasted) = (false, None);
    ui.input_mut(|input| {
        input.events.retain(|event| match event {
            Event::Copy => {
                is_copied = true;
                false
            }
            Event::Paste(text) => {
                let value = read(text);
                let is_left = value.is_none();
                pasted = value.or(pasted.take());
                is_left
            }
            _ => true,
        });
    });
    if is_copied {
        ui.ctx().copy_text(copied());
    }
    pasted
}
