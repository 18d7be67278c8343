//! The preview as a picture: whole, or in parts where it is larger than a graphics adapter should hold.

use super::picture::{Order, Rendered, Repeat, lobes};
use super::watch::{Step, Watch};
use super::{OfflineError, tiles};
use crate::export::Picture;
use burnish_material::LobeSet;
use burnish_renderer::path::{StopReason, Tile};
use burnish_renderer::preview::{self, Crop, Preview, PreviewError};
use burnish_renderer::tonemap::Display;
use std::time::Instant;

/// Frames without a stop rule; it settles earlier by itself.
const FRAMES: u32 = 4096;

/// Side of the parts of a large picture: about 0.5 GB on the adapter.
const SIDE: usize = 2048;

/// Draws until it changes no more, a rule says so, or as far as `again` says.
pub(super) fn preview(order: &Order, again: Option<&Repeat>, watch: &mut Watch<'_>) -> Result<Rendered, OfflineError> {
    let loaded = &order.loaded;
    let failed = |error: PreviewError| OfflineError::Preview(error.to_string());
    let start = Instant::now();
    let (adapter, device, queue) = preview::headless_device().map_err(failed)?;
    let mut preview = Preview::new(&device, &queue).map_err(failed)?;
    preview.set_scene(&device, &queue, &loaded.scene);
    // The first frame waits for everything that the window would show later.
    preview.settle(&device, &queue).map_err(failed)?;
    let load_seconds = start.elapsed().as_secs_f64();
    let adapter = adapter.get_info().name;
    if let Some(sentence) = again.and_then(|again| again.adapter_note(&adapter)) {
        (watch.warn)(sentence);
    }

    let most = device.limits().max_texture_dimension_2d as usize;
    let side = SIDE.min(most);
    let (width, height) = (loaded.width, loaded.height);
    let parts = if width * height <= side * side && width.max(height) <= most {
        vec![Tile { at: [0, 0], size: [width, height] }]
    } else {
        tiles::of_side(width, height, side)
    };
    if again.is_some_and(|again| again.samples.len() != parts.len()) {
        return Err(OfflineError::unusable(
            "the picture was drawn in other parts than this adapter draws, so that it cannot be made again",
        ));
    }
    let mut pixels = vec![[0.0; 4]; width * height];
    let (mut frames_of_parts, mut stop_reason, mut first_image_seconds) = (Vec::new(), "converged", 0.0);
    let start = Instant::now();
    for (number, part) in parts.iter().enumerate() {
        let at = part.at.map(|place| place as u32);
        preview.set_crop((parts.len() > 1).then_some(Crop { full: [width as u32, height as u32], at }));
        // What time is left is shared by the parts that are left.
        let room = order.stop.seconds.map(|end| (end - start.elapsed().as_secs_f64()).max(0.0) / (parts.len() - number) as f64);
        let frames = match again {
            Some(again) => again.samples[number] as u32,
            None => order.stop.spp.unwrap_or(FRAMES),
        };
        let begin = Instant::now();
        let mut drawn = 0;
        let reason = loop {
            let [columns, rows] = part.size.map(|side| side as u32);
            let would_refine = preview.render_more(&device, &queue, columns, rows, Display::default()).map_err(failed)?;
            drawn += 1;
            if first_image_seconds == 0.0 {
                first_image_seconds = load_seconds + start.elapsed().as_secs_f64();
            }
            let by_time = room.map_or(0.0, |room| begin.elapsed().as_secs_f64() / room.max(1e-6));
            let of_part = (f64::from(drawn) / f64::from(frames.max(1))).max(by_time).min(1.0);
            let share = (number as f64 + of_part) / parts.len() as f64;
            let part = if parts.len() > 1 { format!("part {} of {}", number + 1, parts.len()) } else { String::new() };
            let (seconds, share) = (start.elapsed().as_secs_f64(), Some(share));
            (watch.tell)(&Step { part, spp: drawn, seconds, share, ..Step::default() });
            if (watch.is_cancelled)() {
                return Err(OfflineError::Cancelled);
            }
            if drawn >= frames {
                break StopReason::Spp.word();
            }
            if room.is_some_and(|room| begin.elapsed().as_secs_f64() >= room) {
                break StopReason::Time.word();
            }
            if !would_refine {
                break "converged";
            }
        };
        if let Some(error) = preview.error() {
            return Err(OfflineError::Preview(error.to_string()));
        }
        if reason != "converged" {
            stop_reason = reason;
        }
        let of_part = preview.read_linear(&device, &queue).map_err(failed)?;
        tiles::put(&mut pixels, width, *part, &of_part);
        frames_of_parts.push(u64::from(drawn));
    }
    let nonfinite = pixels.iter().filter(|pixel| pixel.iter().any(|x| !x.is_finite())).count() as u64;
    Ok(Rendered {
        picture: Picture { width, height, pixels, precision: order.options.precision(), ..Picture::default() },
        spp: frames_of_parts.iter().min().map_or(0, |frames| *frames as u32),
        samples: frames_of_parts,
        seconds: start.elapsed().as_secs_f64(),
        first_image_seconds,
        load_seconds,
        stop_reason: again.and_then(|again| again.stop_reason.clone()).unwrap_or_else(|| stop_reason.to_owned()),
        error: None,
        denoised: None,
        adapter: Some(adapter),
        nonfinite,
        lobes: lobes(&loaded.scene, LobeSet::of),
    })
}
