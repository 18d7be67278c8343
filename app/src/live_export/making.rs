//! Making a picture or a turntable, on whichever thread.

use super::{News, Row, Task, Tray, Unwritten};
use crate::background::Control;
use crate::export::{ExportError, Picture};
use crate::files::check_writable;
use crate::live_export::FrameState;
use crate::offline::OfflineError;
use crate::offline::picture;
use crate::offline::turntable::{Existing, Frame, PROBES, Turntable, TurntableOrder};
use crate::offline::watch::{Watch, error_text};
use std::path::Path;
use std::sync::Mutex;

/// Does what is to be done. What there is to tell meanwhile comes into the tray.
pub(super) fn make(task: Task, tray: &Mutex<Tray>, control: &Control) -> News {
    let say = |news| {
        super::lock(tray).news.push(news);
        control.wake();
    };
    let mut watch = Watch {
        is_cancelled: &|| control.is_cancelled(),
        warn: &mut |sentence| say(News::Warning(sentence)),
        tell: &mut |step| {
            super::lock(tray).step = step.clone();
            control.wake();
        },
    };
    let made = match task {
        Task::Picture(order, view, out) => check_writable(&out)
            .map_err(|error| OfflineError::Export(ExportError::Write(error)))
            .and_then(|()| picture::render(&order, view, None, &mut watch))
            .map(|rendered| write(Unwritten(Box::new((order, view, rendered))), &out, &mut watch)),
        Task::Write(unwritten, out) => Ok(write(unwritten, &out, &mut watch)),
        Task::Predict(order) => turntable(&order, true, &say, &mut watch),
        Task::Turntable(order) => turntable(&order, false, &say, &mut watch),
    };
    made.unwrap_or_else(News::Failed)
}

fn write(mut unwritten: Unwritten, out: &Path, watch: &mut Watch<'_>) -> News {
    let (order, view, rendered) = &mut *unwritten.0;
    let files = match picture::write(order, *view, out, None, rendered, watch) {
        Ok(files) => files,
        Err(error) => return News::Unwritten(unwritten, error),
    };
    let Picture { width, height, .. } = rendered.picture;
    let error = rendered.error.as_ref().map_or_else(String::new, |error| format!(", {}", error_text(error)));
    let denoised = rendered.denoised.as_ref().map_or_else(String::new, |denoised| {
        format!("; denoised by {}, estimated {}, the raw picture is kept", denoised.denoiser, error_text(&denoised.error))
    });
    let (spp, seconds, reason) = (rendered.spp, rendered.seconds, &rendered.stop_reason);
    News::Wrote(files, format!("{width} × {height}, {spp} spp in {seconds:.1} s{error}{denoised}, stopped by {reason}"))
}

fn turntable(
    order: &TurntableOrder,
    is_prediction: bool,
    say: &dyn Fn(News),
    watch: &mut Watch<'_>,
) -> Result<News, OfflineError> {
    let mut table = Turntable::open(order.clone(), Existing::Restart, watch)?;
    let names: Vec<String> = table.numbers().map(|number| table.name(number)).collect();
    say(News::Rows(table.numbers().zip(&names).map(|(number, name)| Row::new(name.clone(), table.frame(number))).collect()));
    if is_prediction {
        let due = table.due().len();
        return Ok(News::Predicted(table.predict(PROBES, watch)?, due));
    }
    let mut told = |number: u32, frame: Option<&Frame>| {
        let mut row = Row::new(names[number as usize].clone(), frame);
        if frame.is_none() {
            row.state = FrameState::Working;
        }
        say(News::Row(number as usize, row));
    };
    match table.render(watch, &mut told) {
        Ok(()) | Err(OfflineError::Cancelled) => {}
        Err(error) => return Err(error),
    }
    let rows = table.numbers().zip(names).map(|(number, name)| Row::new(name, table.frame(number))).collect();
    say(News::Rows(rows));
    let (done, all) = table.progress();
    Ok(News::Ended(done, all))
}
