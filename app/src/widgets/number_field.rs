//! A number that is dragged or typed. Showing it, or passing through it with the keyboard, never changes it.

use crate::widgets::number;
use burnish_material::Unit;
use egui::{DragValue, Ui, vec2};
use std::cell::Cell;
use std::ops::RangeInclusive;

/// How a number is shown and edited.
pub struct NumberField<'a> {
    /// Accessible name.
    pub name: &'a str,
    /// Width in points.
    pub width: f32,
    /// Change per point of dragging.
    pub speed: f64,
    /// What an edit may set; values that lie outside already stay.
    pub range: RangeInclusive<f64>,
    /// What may be typed after the number.
    pub unit: Unit,
    /// Millimetres per unit of length.
    pub unit_mm: f64,
    /// How it is written while it is not being typed.
    pub format: fn(f64) -> String,
}

impl<'a> NumberField<'a> {
    /// A field for a plain number without limits.
    pub fn plain(name: &'a str, width: f32, speed: f64) -> Self {
        Self { name, width, speed, range: f64::MIN..=f64::MAX, unit: Unit::None, unit_mm: 1.0, format: number::field }
    }

    /// Shows `old` and returns the new value when it was edited.
    pub fn show(self, ui: &mut Ui, old: f64) -> Option<f64> {
        let Self { name, width, speed, range, unit, unit_mm, format } = self;
        let mut new = None;
        let shown = format(old);
        let is_untouched = Cell::new(false);
        let field = DragValue::from_get_set(|set| {
            // An untouched text stands for the number it was made from, with all its digits and even outside the range,
            // which egui would enforce on whatever comes from a text.
            if let Some(v) = set
                && v != old
                && !is_untouched.get()
            {
                new = Some(v);
            }
            new.unwrap_or(old)
        })
        .range(range)
        .clamp_existing_to_range(false)
        .update_while_editing(false)
        .clip_text(true)
        .speed(speed)
        .min_size(vec2(width, ui.spacing().interact_size.y))
        .custom_formatter(|v, _| format(v))
        .custom_parser(|text| {
            is_untouched.set(text.trim() == shown);
            if is_untouched.get() { Some(old) } else { number::parse(text, unit, unit_mm) }
        });
        ui.scope(|ui| {
            ui.spacing_mut().button_padding.x = 3.0;
            ui.set_max_width(width);
            ui.add(field).accessible_name(name)
        });
        new
    }
}
