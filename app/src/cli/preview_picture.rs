//! The preview as a picture: whole, or in parts where it is larger than a graphics adapter should hold.

use super::render::{RenderArguments, Rendered, lobes};
use super::repeat::Repeat;
use super::scene_options::LoadedScene;
use super::{CliError, Messages, interrupt, tiles};
use crate::export::Picture;
use burnish_material::LobeSet;
use burnish_renderer::path::{StopReason, Tile};
use burnish_renderer::preview::{self, Crop, Preview};
use burnish_renderer::tonemap::Display;
use std::time::Instant;

/// Frames without a stop rule; it settles earlier by itself.
const FRAMES: u32 = 4096;

/// Side of the parts of a large picture: about 0.5 GB on the adapter.
const SIDE: usize = 2048;

/// Draws until it changes no more, a rule says so, or as far as `again` says.
pub(super) fn preview(
    arguments: &RenderArguments,
    loaded: &LoadedScene,
    again: Option<&Repeat>,
    messages: &mut Messages,
) -> Result<Rendered, CliError> {
    let options = &arguments.picture;
    if options.transparent || !options.aov.is_empty() || arguments.error.is_some() || options.denoise.is_some() {
        return Err(CliError::unusable(
            "--view preview: expected no --transparent, --aov, --error or --denoise; they belong to --view final",
        ));
    }
    let unusable = |error| CliError::unusable(format!("--view preview: {error}"));
    let start = Instant::now();
    let (adapter, device, queue) = preview::headless_device().map_err(unusable)?;
    let mut preview = Preview::new(&device, &queue).map_err(unusable)?;
    preview.set_scene(&device, &queue, &loaded.scene);
    // The first frame waits for everything that the window would show later.
    preview.settle(&device, &queue).map_err(unusable)?;
    let load_seconds = start.elapsed().as_secs_f64();
    let adapter = adapter.get_info().name;
    if let Some(sentence) = again.and_then(|again| again.adapter_note(&adapter)) {
        messages.warn(sentence);
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
        return Err(CliError::unusable(
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
        let room = arguments.time.map(|end| (end - start.elapsed().as_secs_f64()).max(0.0) / (parts.len() - number) as f64);
        let frames = match again {
            Some(again) => again.samples[number] as u32,
            None => arguments.spp.unwrap_or(FRAMES),
        };
        let begin = Instant::now();
        let mut drawn = 0;
        let reason = loop {
            let [columns, rows] = part.size.map(|side| side as u32);
            let would_refine = preview.render_more(&device, &queue, columns, rows, Display::default()).map_err(unusable)?;
            drawn += 1;
            if first_image_seconds == 0.0 {
                first_image_seconds = load_seconds + start.elapsed().as_secs_f64();
            }
            interrupt::check()?;
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
            return Err(CliError::unusable(format!("--view preview: {error}")));
        }
        if reason != "converged" {
            stop_reason = reason;
        }
        let of_part = preview.read_linear(&device, &queue).map_err(unusable)?;
        tiles::put(&mut pixels, width, *part, &of_part);
        frames_of_parts.push(u64::from(drawn));
    }
    let nonfinite = pixels.iter().filter(|pixel| pixel.iter().any(|x| !x.is_finite())).count() as u64;
    if arguments.scene.threads.is_some() {
        messages.warn("--threads has no effect with --view preview");
    }
    Ok(Rendered {
        picture: Picture { width, height, pixels, precision: options.precision(), ..Picture::default() },
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
