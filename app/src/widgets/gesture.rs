//! Where one gesture ends and the next begins, for the undo history.
//!
//! The history makes a step when the mouse is up and no text is typed. A field that was left with Tab has been committed all the same, while the
//! next one is being typed in: it says so here.

use egui::{Context, Id};

const END: &str = "a gesture has ended";
const CANCEL: &str = "a gesture was taken back";

/// What was edited in this frame is done.
pub fn end(ctx: &Context) {
    ctx.data_mut(|data| data.insert_temp(Id::unique(END), true));
}

/// What was edited since the last step is to be as it was: a value that was not set is not set again.
pub fn cancel(ctx: &Context) {
    ctx.data_mut(|data| data.insert_temp(Id::unique(CANCEL), true));
}

/// Whether [`end`] was called since the last time.
pub fn take_end(ctx: &Context) -> bool {
    take(ctx, END)
}

/// Whether [`cancel`] was called since the last time.
pub fn take_cancel(ctx: &Context) -> bool {
    take(ctx, CANCEL)
}

fn take(ctx: &Context, what: &'static str) -> bool {
    ctx.data_mut(|data| data.remove_temp::<bool>(Id::unique(what))).unwrap_or(false)
}
