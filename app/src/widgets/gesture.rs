//! Where one gesture ends and the next begins, for the undo history.
//!
//! The history makes a step when the mouse is up and no text is typed. A field that was left with Tab has been committed all the same, while the
//! next one is being typed in: it says so here.

use egui::{Context, Id};

fn id() -> Id {
    Id::unique("a gesture has ended")
}

/// What was edited in this frame is done.
pub fn end(ctx: &Context) {
    ctx.data_mut(|data| data.insert_temp(id(), true));
}

/// Whether [`end`] was called since the last time.
pub fn take_end(ctx: &Context) -> bool {
    ctx.data_mut(|data| data.remove_temp::<bool>(id())).unwrap_or(false)
}
