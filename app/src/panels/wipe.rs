//! The line between preview and final view in one picture, and dragging it.

use crate::theme;
use egui::{Color32, CursorIcon, Key, Rect, Role, Sense, Ui, WidgetInfo, pos2, vec2};

/// Points on each side of the line where it can be taken hold of.
const REACH: f32 = 9.0;
/// Step of the arrow keys, as a share of the width.
const STEP: f32 = 0.02;

/// Splits a picture at a share of its width.
pub fn split(rect: Rect, share: f32) -> (Rect, Rect) {
    let x = (rect.left() + share.clamp(0.0, 1.0) * rect.width()).round();
    (Rect::from_min_max(rect.min, pos2(x, rect.bottom())), Rect::from_min_max(pos2(x, rect.top()), rect.max))
}

/// Lets the line be dragged, or moved with the arrow keys while it has the focus. `share` is its place, 0 to 1 of the width.
pub fn interact(ui: &mut Ui, rect: Rect, share: &mut f32) {
    let x = split(rect, *share).1.left();
    let handle = Rect::from_center_size(pos2(x, rect.center().y), vec2(2.0 * REACH, rect.height()));
    let response = ui.interact(handle, ui.scope_id().with("wipe"), Sense::drag()).on_hover_cursor(CursorIcon::ResizeHorizontal);
    if response.has_focus() {
        let (left, right) = ui.input(|i| (i.num_presses(Key::ArrowLeft), i.num_presses(Key::ArrowRight)));
        *share += STEP * (right as f32 - left as f32);
    }
    if let Some(pointer) = response.interact_pointer_pos().filter(|_| response.dragged()) {
        *share = (pointer.x - rect.left()) / rect.width().max(1.0);
    }
    *share = share.clamp(0.0, 1.0);
    let value = f64::from(*share);
    response.widget_info(|| WidgetInfo { value: Some(value), ..WidgetInfo::labeled(Role::Slider, true, "Wipe") });
}

/// Paints the line over both pictures.
pub fn paint(ui: &Ui, rect: Rect, share: f32) {
    let x = split(rect, share).1.left();
    let painter = ui.painter_at(rect);
    painter.vline(x, rect.y_range(), (3.0, Color32::from_black_alpha(140)));
    painter.vline(x, rect.y_range(), (1.0, Color32::from_gray(235)));
    let grip = Rect::from_center_size(pos2(x, rect.center().y), vec2(6.0, 30.0));
    painter.rect_filled(grip, 3, theme::ON_PICTURE.accent);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_make_up_the_whole() {
        let rect = Rect::from_min_max(pos2(10.0, 5.0), pos2(111.0, 55.0));
        for share in [-1.0, 0.0, 0.3, 0.5, 1.0, 2.0] {
            let (left, right) = split(rect, share);
            assert_eq!((left.left(), left.right(), right.right()), (10.0, right.left(), 111.0), "{share}");
        }
    }
}
