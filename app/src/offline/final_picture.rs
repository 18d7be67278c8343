//! The final view as a picture: whole, or in parts where it is large.

use super::develop::{Exposed, develop, develop_tile};
use super::picture::{Order, Rendered, Repeat, lobes};
use super::watch::{Step, Watch};
use super::{OfflineError, tiles};
use crate::export::Picture;
use burnish_material::{LobeSet, Property, TextureRef};
use burnish_renderer::path::{self, ErrorEstimate, Prepared, Rendering, Settings, StopReason, StopRules, Tile};
use burnish_renderer::scene::Scene;
use std::sync::Arc;
use std::time::Instant;

/// Renders, until a rule says so or as far as `again` says.
pub(super) fn final_view(order: &Order, again: Option<&Repeat>, watch: &mut Watch<'_>) -> Result<Rendered, OfflineError> {
    let (loaded, options) = (&order.loaded, &order.options);
    for sentence in left_out(&loaded.scene) {
        (watch.warn)(sentence);
    }
    let parts = tiles::of_final(loaded.width, loaded.height);
    let settings = Settings {
        width: loaded.width,
        height: loaded.height,
        seed: order.seed,
        threads: order.threads,
        stop: order.rules(),
        is_adaptive: !options.no_adaptive,
    };
    let start = Instant::now();
    let prepared = options.prepare(&loaded.scene, None);
    let mut camera = Parts { prepared: &prepared, settings, again, start, rest: parts.len(), number: 0, seconds: 0.0 };
    if let [whole] = parts[..] {
        let rendering = camera.expose(whole, watch)?;
        let film = &rendering.film;
        let exposed = Exposed { scene: &loaded.scene, prepared: &prepared, film, seed: settings.seed, threads: settings.threads };
        (watch.tell)(&Step { part: "developing".to_owned(), ..Step::default() });
        let (picture, denoised) = develop(&exposed, options, watch)?;
        return Ok(Rendered { denoised, ..rendered(order, again, picture, &[told(&rendering)]) });
    }
    let mut pixels = vec![[0.0; 4]; loaded.width * loaded.height];
    let mut all = Vec::new();
    for part in parts {
        let rendering = camera.expose(part, watch)?;
        let of_part = develop_tile(&loaded.scene, &rendering.film, options, part.at, [loaded.width, loaded.height]);
        tiles::put(&mut pixels, loaded.width, part, &of_part);
        all.push(told(&rendering));
    }
    let picture = Picture {
        width: loaded.width,
        height: loaded.height,
        pixels,
        has_alpha: options.transparent,
        precision: options.precision(),
        ..Picture::default()
    };
    Ok(rendered(order, again, picture, &all))
}

/// Renders one part after the other.
struct Parts<'a> {
    prepared: &'a Prepared,
    settings: Settings,
    again: Option<&'a Repeat>,
    start: Instant,
    rest: usize,
    number: usize,
    seconds: f64,
}

impl Parts<'_> {
    fn expose(&mut self, part: Tile, watch: &mut Watch<'_>) -> Result<Rendering, OfflineError> {
        let (number, parts) = (self.number, self.number + self.rest);
        let place = if parts > 1 { format!("part {} of {parts}", number + 1) } else { String::new() };
        // What time is left is shared by the parts that are left.
        let seconds = self.settings.stop.seconds.map(|end| (end - self.seconds).max(0.0) / self.rest as f64);
        let settings = Settings { stop: StopRules { seconds, ..self.settings.stop }, ..self.settings };
        let before = self.seconds;
        let mut progress = |state: &path::Progress<'_>| {
            let mut step = Step::of(&place, state, &settings.stop);
            if parts > 1 {
                step.share = step.share.map(|share| (number as f64 + share) / parts as f64);
                step.remaining = step.share.map(|share| (before + state.seconds) * (1.0 / share.max(1e-6) - 1.0));
            }
            (watch.tell)(&step);
            !(watch.is_cancelled)()
        };
        let rendering = match self.again.map(|again| again.samples[number]) {
            Some(samples) => path::repeat(self.prepared, &self.settings, part, samples, self.start, &mut progress),
            None => path::render_tile(self.prepared, &settings, part, self.start, &mut progress),
        };
        self.number += 1;
        self.rest -= 1;
        self.seconds += rendering.seconds;
        if rendering.stop_reason == StopReason::Cancelled { Err(OfflineError::Cancelled) } else { Ok(rendering) }
    }
}

/// What is told of a part after its samples are gone.
struct Told {
    samples: u64,
    pixels: usize,
    seconds: f64,
    first_image_seconds: f64,
    load_seconds: f64,
    stop_reason: StopReason,
    error: Option<ErrorEstimate>,
    nonfinite: u64,
}

fn told(rendering: &Rendering) -> Told {
    Told {
        samples: rendering.film.total_samples(),
        pixels: rendering.film.width * rendering.film.height,
        seconds: rendering.seconds,
        first_image_seconds: rendering.first_image_seconds,
        load_seconds: rendering.load_seconds,
        stop_reason: rendering.stop_reason,
        error: rendering.error,
        nonfinite: rendering.nonfinite,
    }
}

fn rendered(order: &Order, again: Option<&Repeat>, picture: Picture, parts: &[Told]) -> Rendered {
    let pixels: usize = parts.iter().map(|part| part.pixels).sum();
    let samples: Vec<u64> = parts.iter().map(|part| part.samples).collect();
    // A picture is as far as its parts on average, and ended by time if any was.
    let is_timed = parts.iter().any(|part| part.stop_reason == StopReason::Time);
    let reason = if is_timed { StopReason::Time } else { parts.first().map_or(StopReason::Spp, |part| part.stop_reason) };
    let first = parts.first();
    let less = order.options.left_out();
    Rendered {
        picture,
        spp: (samples.iter().sum::<u64>() / pixels.max(1) as u64) as u32,
        samples,
        seconds: parts.iter().map(|part| part.seconds).sum(),
        first_image_seconds: first.map_or(0.0, |part| part.first_image_seconds),
        load_seconds: first.map_or(0.0, |part| part.load_seconds),
        stop_reason: again.and_then(|again| again.stop_reason.clone()).unwrap_or_else(|| reason.word().to_owned()),
        error: joint_error(parts, pixels),
        denoised: None,
        adapter: None,
        nonfinite: parts.iter().map(|part| part.nonfinite).sum(),
        lobes: lobes(&order.loaded.scene, LobeSet::of).minus(less),
    }
}

/// The error of the whole: the mean of the parts by their pixels.
fn joint_error(parts: &[Told], pixels: usize) -> Option<ErrorEstimate> {
    if let [part] = parts {
        return part.error;
    }
    let mean = |of: fn(&ErrorEstimate) -> f64| -> Option<f64> {
        parts.iter().map(|part| Some(of(part.error.as_ref()?) * part.pixels as f64 / pixels.max(1) as f64)).sum()
    };
    Some(ErrorEstimate {
        relmse: mean(|error| error.relmse)?,
        low: mean(|error| error.low)?,
        high: mean(|error| error.high)?,
        is_firefly_limited: parts.iter().filter_map(|part| part.error).any(|error| error.is_firefly_limited),
    })
}

/// What the path tracer leaves out, other than images that are not there: loading told each with its reason.
pub(super) fn left_out(scene: &Scene) -> Vec<String> {
    let mut scene = scene.clone();
    for object in &mut scene.objects {
        let textures = &object.textures;
        let is_missing = |texture: &TextureRef| !textures.contains_key(&texture.path);
        let slots = object.material.slots().filter(|(_, slot)| slot.texture.as_ref().is_some_and(is_missing));
        let missing: Vec<Property> = slots.map(|(property, _)| property).collect();
        for property in missing {
            Arc::make_mut(&mut object.material).slot_mut(property).texture = None;
        }
    }
    path::unsupported(&scene)
}
