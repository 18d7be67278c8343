//! A slider's track with what is known about its property drawn on it: where real materials lie, which ones were measured, the default, and
//! what another version of the material has.

use crate::theme;
use crate::widgets::number_field::{FINE, LOG_FLOOR, Scale, tidied, under_pointer};
use crate::widgets::{gesture, number};
use egui::{CornerRadius, Key, Modifiers, Rect, Response, Sense, StrokeKind, Ui, WidgetInfo, accesskit, pos2, vec2};

/// What stands on a track.
#[derive(Clone, Debug, Default)]
pub struct Marks<'a> {
    /// Where real materials lie.
    pub zone: Option<(f64, f64)>,
    /// Single measurements.
    pub measured: &'a [f64],
    /// How far the datasets of this very value are apart.
    pub spread: Option<(f64, f64)>,
    /// The default.
    pub default: f64,
    /// What the other side has.
    pub other: Option<f64>,
}

/// A slider over a range.
pub struct Track<'a> {
    /// Accessible name.
    pub name: &'a str,
    /// The ends of the track.
    pub min: f64,
    /// The right end.
    pub max: f64,
    /// Whether equal distances are equal ratios.
    pub is_logarithmic: bool,
    /// What Ctrl snaps to, and one press of an arrow key.
    pub step: f64,
    /// What is drawn on it.
    pub marks: Marks<'a>,
}

/// Space at each end, so that the handle stays inside.
const END: f32 = 5.0;

impl Track<'_> {
    /// The least positive number of a logarithmic track.
    fn floor(&self) -> f64 {
        (self.max * 1e-4).max(LOG_FLOOR)
    }

    /// Where a number stands, 0 to 1.
    fn place(&self, value: f64) -> f32 {
        let t = if self.is_logarithmic {
            let floor = self.floor();
            if value <= floor { 0.0 } else { (value / floor).ln() / (self.max / floor).ln() }
        } else {
            (value - self.min) / (self.max - self.min)
        };
        (t as f32).clamp(0.0, 1.0)
    }

    /// The number at a place.
    fn value(&self, t: f64) -> f64 {
        if !self.is_logarithmic {
            return self.min + t * (self.max - self.min);
        }
        if t <= 0.0 { 0.0 } else { self.floor() * (self.max / self.floor()).powf(t) }
    }

    /// Shows the track with its handle at `old`; the new number when it was moved. Two clicks ask for a reset, which is left to the caller.
    pub fn show(&self, ui: &mut Ui, width: f32, old: f64) -> (Response, Option<f64>) {
        let size = vec2(width, ui.spacing().interact_size.y);
        let (rect, mut response) = ui.allocate_exact_size(size, Sense::click_and_drag());
        let rail = Rect::from_center_size(rect.center(), vec2(rect.width() - 2.0 * END, 4.0));
        let new = self.moved(ui, &response, rail, old);
        if new.is_some() {
            response.mark_changed();
        }
        let value = new.unwrap_or(old);
        if ui.is_rect_visible(rect) {
            self.paint(ui, &response, rail, value);
        }
        response.widget_info(|| WidgetInfo::slider(ui.is_enabled(), value, self.name));
        ui.ctx().accesskit_node_builder(response.id, |builder| {
            builder.set_min_numeric_value(self.min);
            builder.set_max_numeric_value(self.max);
            builder.set_numeric_value_step(self.step);
            for action in [accesskit::Action::SetValue, accesskit::Action::Increment, accesskit::Action::Decrement] {
                builder.add_action(action);
            }
        });
        (response, new)
    }

    fn moved(&self, ui: &Ui, response: &Response, rail: Rect, old: f64) -> Option<f64> {
        if !ui.is_enabled() {
            return None;
        }
        let id = response.id.with("drag");
        let modifiers = ui.input(|i| i.modifiers);
        // Where the handle is without rounding, and what Esc goes back to.
        let start = ui.data(|data| data.get_temp::<(f64, f64)>(id));
        if response.drag_stopped() {
            // Esc ends a drag, like letting go.
            ui.data_mut(|data| data.remove::<(f64, f64)>(id));
            return start.filter(|_| ui.input(|i| i.key_pressed(Key::Escape))).map(|(_, from)| {
                gesture::cancel(ui.ctx());
                from
            });
        }
        if (response.dragged() || response.clicked())
            && let Some(pointer) = response.interact_pointer_pos()
        {
            let here = f64::from((pointer.x - rail.left()) / rail.width().max(1.0)).clamp(0.0, 1.0);
            let (t, from) = match start {
                Some((t, from)) if modifiers.shift => {
                    (t + FINE * f64::from(response.drag_delta().x / rail.width().max(1.0)), from)
                }
                None if modifiers.shift => (f64::from(self.place(old)), old),
                Some((_, from)) => (here, from),
                None => (here, old),
            };
            let t = t.clamp(0.0, 1.0);
            ui.data_mut(|data| data.insert_temp(id, (t, from)));
            return Some(tidied(self.value(t), self.step, modifiers)).filter(|new| *new != old);
        }
        if start.is_some() && !response.is_pointer_button_down_on() {
            ui.data_mut(|data| data.remove::<(f64, f64)>(id));
        }
        if response.contains_pointer() && !ui.ctx().text_edit_focused() {
            let scale = if self.is_logarithmic { Scale::Logarithmic } else { Scale::Linear(self.step * 0.1) };
            if let Some(value) = under_pointer(ui, old, scale, self.step) {
                return Some(value);
            }
        }
        self.keyed(ui, response, old)
    }

    /// Arrow keys while it has the focus, and what screen readers ask for.
    fn keyed(&self, ui: &Ui, response: &Response, old: f64) -> Option<f64> {
        use accesskit::{Action, ActionData};
        let mut steps = 0.0;
        if response.has_focus() {
            ui.memory_mut(|memory| {
                let filter = egui::EventFilter { horizontal_arrows: true, ..Default::default() };
                memory.set_focus_lock_filter(response.id, filter);
            });
            steps = ui.input_mut(|input| {
                let mut count =
                    |modifiers, key| f64::from(u32::try_from(input.count_and_consume_key(modifiers, key)).unwrap_or(0));
                count(Modifiers::NONE, Key::ArrowRight) - count(Modifiers::NONE, Key::ArrowLeft)
                    + FINE * (count(Modifiers::SHIFT, Key::ArrowRight) - count(Modifiers::SHIFT, Key::ArrowLeft))
            });
        }
        ui.input(|input| {
            steps += input.num_accesskit_action_requests(response.id, Action::Increment) as f64
                - input.num_accesskit_action_requests(response.id, Action::Decrement) as f64;
            let asked = input.accesskit_action_requests(response.id, Action::SetValue).find_map(|request| match request.data {
                Some(ActionData::NumericValue(value)) => Some(value),
                _ => None,
            });
            let stepped = || {
                let t = f64::from(self.place(old)) + steps * self.step / (self.max - self.min);
                let value = if self.is_logarithmic { self.value(t) } else { old + steps * self.step };
                number::rounded(value.clamp(self.min, self.max), 4)
            };
            asked.or_else(|| (steps != 0.0).then(stepped)).filter(|new| *new != old)
        })
    }

    fn paint(&self, ui: &Ui, response: &Response, rail: Rect, value: f64) {
        let (palette, painter) = (theme::now(), ui.painter());
        let x = |value: f64| rail.left() + self.place(value) * rail.width();
        let visuals = ui.style().interact(response);
        painter.rect_filled(rail, 2, palette.field);
        let fill = Rect::from_x_y_ranges(rail.left()..=x(value), rail.y_range());
        painter.rect_filled(fill, 2, palette.accent.gamma_multiply(0.55));
        // Above the rail where real materials lie, below it what was measured: neither is hidden by the handle.
        let above = |low: f64, high: f64, y: f32, color| {
            let (left, right) = (x(low), x(high).max(x(low) + 1.5));
            painter.rect_filled(Rect::from_min_max(pos2(left, y), pos2(right, y + 2.0)), CornerRadius::ZERO, color);
        };
        if let Some((low, high)) = self.marks.zone {
            above(low, high, rail.top() - 5.0, palette.good.gamma_multiply(0.75));
        }
        if let Some((low, high)) = self.marks.spread {
            above(low, high, rail.top() - 2.5, palette.warning);
        }
        let mut last = f32::MIN;
        for value in self.marks.measured {
            let place = x(*value).round();
            if place - last >= 2.0 {
                painter.vline(place, rail.bottom() + 1.5..=rail.bottom() + 4.5, (1.0, palette.weak.gamma_multiply(0.7)));
                last = place;
            }
        }
        painter.vline(x(self.marks.default), rail.top() - 1.0..=rail.bottom() + 1.0, (1.5, palette.weak));
        if let Some(other) = self.marks.other {
            painter.circle_stroke(pos2(x(other), rail.center().y), 4.0, (1.5, palette.good));
        }
        let handle = Rect::from_center_size(pos2(x(value), rail.center().y), vec2(7.0, 15.0));
        let stroke = if response.has_focus() { (1.5, palette.accent).into() } else { visuals.fg_stroke };
        painter.rect(handle, 2, visuals.bg_fill, stroke, StrokeKind::Inside);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_and_values_are_inverse() {
        for is_logarithmic in [false, true] {
            let track = Track { name: "", min: 0.0, max: 10.0, is_logarithmic, step: 0.1, marks: Marks::default() };
            for value in [0.0, 0.01, 0.5, 3.0, 10.0] {
                let again = track.value(f64::from(track.place(value)));
                assert!((again - value).abs() < 1e-4 * 10.0, "{is_logarithmic} {value} {again}");
            }
            assert_eq!(track.place(1e9), 1.0);
        }
    }
}
