//! What each lobe costs the preview, measured on a thread when the user asks for it.

use crate::lobe_costs::{Change, Meter};
use burnish_material::{LOBES, Lobe, LobeSet};
use burnish_renderer::preview::PreviewError;
use burnish_renderer::scene::Scene;
use egui::Context;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

/// Pictures that take longer are made smaller.
const SECONDS: f64 = 0.2;
/// Differences below this share of a frame are noise.
const NOISE: f64 = 0.02;
/// Pairs of pictures by lobe.
const REPEATS: usize = 7;

/// What is known of the lobes of one material.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Costs {
    /// Milliseconds of a frame that a lobe takes, or would.
    pub lobes: Vec<(Lobe, f64)>,
    /// Why there is no more.
    pub problem: Option<String>,
    /// Whether more will come.
    pub is_running: bool,
}

impl Costs {
    /// Milliseconds of a lobe, once it was measured.
    pub fn of(&self, lobe: Lobe) -> Option<f64> {
        self.lobes.iter().find(|(l, _)| *l == lobe).map(|(_, ms)| *ms)
    }
}

/// The measurement that was asked for last.
#[derive(Default)]
pub struct LiveCosts {
    found: Arc<Mutex<Costs>>,
    stop: Arc<AtomicBool>,
    /// The lobes that the measured material needs.
    needed: LobeSet,
}

impl LiveCosts {
    /// What was found for a material with these lobes; nothing if another was measured.
    pub fn found(&self, needed: LobeSet) -> Costs {
        if needed != self.needed {
            self.cancel();
            return Costs::default();
        }
        self.found.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Measures a scene for pictures of this size, in place of what was being measured.
    pub fn start(&mut self, ctx: &Context, scene: Scene, needed: LobeSet, size: [u32; 2]) {
        self.cancel();
        let found = Arc::new(Mutex::new(Costs { is_running: true, ..Costs::default() }));
        let stop: Arc<AtomicBool> = Arc::default();
        (self.found, self.stop, self.needed) = (found.clone(), stop.clone(), needed);
        let ctx = ctx.clone();
        let work = move || {
            let tell = |change: &dyn Fn(&mut Costs)| {
                change(&mut found.lock().unwrap_or_else(PoisonError::into_inner));
                ctx.request_repaint();
            };
            let found = |lobe, ms| tell(&|costs| costs.lobes.push((lobe, ms)));
            // A device of its own, whose failures must not leave the window waiting.
            let result = catch_unwind(AssertUnwindSafe(|| measure(&scene, needed, size, &stop, &found)));
            let problem = match result {
                Ok(result) => result.err().map(|error| error.to_string()),
                Err(_) => Some("the graphics device failed".to_owned()),
            };
            tell(&|costs| (costs.is_running, costs.problem) = (false, problem.clone()));
        };
        if let Err(error) = std::thread::Builder::new().name("lobe costs".to_owned()).spawn(work) {
            *self.found.lock().unwrap_or_else(PoisonError::into_inner) =
                Costs { problem: Some(error.to_string()), ..Costs::default() };
        }
    }

    /// Ends the measurement; what was found stays.
    pub fn cancel(&self) {
        self.stop.store(true, Ordering::Relaxed);
    }
}

impl Drop for LiveCosts {
    fn drop(&mut self) {
        self.cancel();
    }
}

fn measure(
    scene: &Scene,
    needed: LobeSet,
    size: [u32; 2],
    stop: &AtomicBool,
    tell: &dyn Fn(Lobe, f64),
) -> Result<(), PreviewError> {
    let mut meter = Meter::new(scene, size)?;
    // Lobes are evaluated by pixel: what differs between two pictures grows with them.
    let pixels = meter.hurry(SECONDS)?;
    for def in LOBES {
        if stop.load(Ordering::Relaxed) {
            break;
        }
        let (change, sign) = Change::of(def.lobe, needed);
        let ([as_is, changed], _) = meter.compare([Change::default(), change], REPEATS)?;
        // What drowns in the noise of two pictures counts as nothing.
        let seconds = if (changed - as_is).abs() > NOISE * as_is { changed - as_is } else { 0.0 };
        tell(def.lobe, 1e3 * sign * pixels * seconds);
    }
    Ok(())
}
