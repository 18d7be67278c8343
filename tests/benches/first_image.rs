//! Seconds from an edit to the first picture, as the editor makes it: `cargo bench -p burnish-tests --bench first_image -- [SCENE.json] [SIDE]`.
//!
//! Prints one JSON object: medians, and the best of all, which other work on the machine disturbs least. Without a scene: a preset on the
//! default scene. The edit changes the roughness (of smooth glass: its index). `prepare_*` is the part of it that comes before any ray.

#![allow(clippy::print_stdout, reason = "a program for the terminal")]

use burnish::cli::Messages;
use burnish::cli::scene_options::SceneOptions;
use burnish_material::{Material, Property, Value};
use burnish_renderer::path::{Prepared, Settings, StopRules};
use burnish_renderer::scene::Scene;
use burnish_renderer::worker::Worker;
use std::error::Error;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

const EDITS: usize = 9;
/// A picture that takes longer counts as a failure.
const PATIENCE: Duration = Duration::from_secs(120);

fn run() -> Result<(), Box<dyn Error>> {
    let words: Vec<String> = std::env::args().skip(1).filter(|word| word != "--bench").collect();
    let side: usize = words.get(1).map_or(Ok(512), |side| side.parse())?;
    let mut options = SceneOptions { size: Some((side, side)), ..SceneOptions::default() };
    options.scene = words.first().map(Into::into);
    let material = if options.scene.is_some() { None } else { Some("preset:Moulded plastic, red") };
    let mut scene = options.load(material, None, &mut Messages::default())?.scene;
    let settings = Settings {
        width: side,
        height: side,
        seed: 0,
        threads: options.threads(),
        stop: StopRules::default(),
        is_adaptive: true,
    };

    let (sender, pictures) = channel();
    let note = move || {
        // Nobody listens any more once the last edit has been shown.
        let _ = sender.send(Instant::now());
    };
    let worker = Worker::new(options.threads(), Box::new(note));
    show(&worker, &pictures, &scene, settings)?;
    let (mut first, mut full) = (Vec::new(), Vec::new());
    for edit in 0..EDITS {
        change(&mut scene, if edit.is_multiple_of(2) { 1.03 } else { 0.97 });
        let [to_first, to_full] = show(&worker, &pictures, &scene, settings)?;
        first.push(to_first);
        full.push(to_full);
        // The next edit comes while rendering goes on, as in the editor.
        std::thread::sleep(Duration::from_millis(200));
    }
    drop(worker);
    let prepare = [Property::roughness, Property::specular_ior].map(|property| prepare(&mut scene, property));
    let median = |values: &mut Vec<f64>| {
        values.sort_by(f64::total_cmp);
        values[values.len() / 2]
    };
    let object = serde_json::json!({
        "size": side,
        "threads": options.threads(),
        "edit_to_first_s": median(&mut first),
        "edit_to_full_resolution_s": median(&mut full),
        "edit_to_first_best_s": first.first(),
        "edit_to_first_worst_s": first.last(),
        "prepare_roughness_s": prepare[0],
        "prepare_index_s": prepare[1],
    });
    println!("{object}");
    Ok(())
}

/// Seconds from the request to its first picture, and to its first one at full resolution.
fn show(worker: &Worker, pictures: &Receiver<Instant>, scene: &Scene, settings: Settings) -> Result<[f64; 2], Box<dyn Error>> {
    let scene = Arc::new(scene.clone());
    let start = Instant::now();
    let revision = worker.request(scene, settings);
    let mut first = None;
    loop {
        let shown = pictures.recv_timeout(PATIENCE)?;
        let Some(snapshot) = worker.snapshot().filter(|snapshot| snapshot.revision == revision) else { continue };
        let seconds = shown.saturating_duration_since(start).as_secs_f64();
        let first = *first.get_or_insert(seconds);
        if snapshot.scale == 1 {
            return Ok([first, seconds]);
        }
    }
}

fn change(scene: &mut Scene, factor: f64) {
    for object in scene.objects.iter_mut().filter(|object| object.is_document) {
        let is_rough = object.material.float(Property::roughness) > 0.0;
        scale(Arc::make_mut(&mut object.material), if is_rough { Property::roughness } else { Property::specular_ior }, factor);
    }
}

fn scale(material: &mut Material, property: Property, factor: f64) {
    material.set(property, Value::Float(factor * material.float(property)));
}

/// Seconds that preparing takes after an edit of one property, at best.
fn prepare(scene: &mut Scene, property: Property) -> f64 {
    let mut last = Prepared::new(scene, None);
    let once = |edit: usize| {
        for object in scene.objects.iter_mut().filter(|object| object.is_document) {
            scale(Arc::make_mut(&mut object.material), property, if edit.is_multiple_of(2) { 1.03 } else { 0.97 });
        }
        let start = Instant::now();
        last = Prepared::new(scene, Some(&last));
        start.elapsed().as_secs_f64()
    };
    (0..EDITS).map(once).fold(f64::INFINITY, f64::min)
}

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}
