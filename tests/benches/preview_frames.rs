//! What a frame of the preview takes: under the hand (an edited value, drawn at once), and with a sample of rays for every pixel.
//!
//! `cargo bench -p burnish-tests --bench preview_frames -- [WIDTHxHEIGHT ...]` prints a table for five presets; 1920x1080 and 3840x2160 unless
//! sizes are given.

use burnish_assets::{ENVIRONMENTS, make_shape};
use burnish_material::{Material, Property, Value};
use burnish_presets::find;
use burnish_renderer::preview::{Preview, headless_device};
use burnish_renderer::scene::{EnvironmentLight, ModelMeshes, Scene};
use burnish_renderer::tonemap::Display;
use std::io::Write;
use std::sync::Arc;
use std::time::Instant;

/// What is measured: matt, metal, layered, refracting, scattering.
const PRESETS: [&str; 5] = ["Moulded plastic, red", "Gold, polished", "Aluminium, brushed", "Crown glass N-BK7", "Milk, whole"];
/// Edits in a row.
const EDITS: usize = 40;
/// Samples of rays.
const SAMPLES: usize = 16;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut out = std::io::stdout().lock();
    let words: Vec<String> = std::env::args().skip(1).filter(|word| word.contains('x')).collect();
    let sizes: Vec<(u32, u32)> = words
        .iter()
        .filter_map(|word| word.split_once('x'))
        .filter_map(|(w, h)| Some((w.parse().ok()?, h.parse().ok()?)))
        .collect();
    let sizes = if sizes.is_empty() { vec![(1920, 1080), (3840, 2160)] } else { sizes };
    let (adapter, device, queue) = headless_device()?;
    writeln!(out, "{}", adapter.get_info().name)?;
    writeln!(
        out,
        "milliseconds: passes of a drawn frame by the device's clock; from an edit until the device is done, median and worst; a frame with a\nsample of rays for every pixel until the device is done"
    )?;
    writeln!(out, "{:<22} {:>10} {:>8} {:>8} {:>8} {:>8}", "preset", "size", "drawn", "edit", "worst", "rays")?;
    let model: ModelMeshes = make_shape("shader-ball").ok_or("no shader ball")?.into();
    let map = Arc::new((ENVIRONMENTS[0].make)());
    for name in PRESETS {
        let material: Material = find(name).ok_or("no such preset")?.parse()?.0.material().clone();
        let scene = |roughness: f64| {
            let mut edited = material.clone();
            edited.set(Property::roughness, Value::Float(roughness));
            let light = EnvironmentLight { map: map.clone(), rotation_deg: 0.0, scale: 1.0 };
            Scene::of_model(&model, Arc::new(edited), Arc::default(), light, 100.0)
        };
        for &(width, height) in &sizes {
            let mut preview = Preview::new(&device, &queue)?;
            preview.set_scene(&device, &queue, &scene(0.3));
            preview.render(&device, &queue, width, height, 1)?;
            preview.set_rays(false);
            let (mut edits, mut drawn) = (Vec::new(), Vec::new());
            for i in 0..EDITS {
                let start = Instant::now();
                preview.set_scene(&device, &queue, &scene(0.3 + 0.005 * i as f64));
                preview.render_more(&device, &queue, width, height, Display::default())?;
                edits.push(1e3 * start.elapsed().as_secs_f64());
                drawn.push(preview.times().total());
            }
            preview.set_rays(true);
            preview.render(&device, &queue, width, height, 1)?;
            let mut rays = Vec::new();
            for _ in 0..SAMPLES {
                let start = Instant::now();
                preview.render_more(&device, &queue, width, height, Display::default())?;
                rays.push(1e3 * start.elapsed().as_secs_f64());
            }
            let median = |values: &mut Vec<f64>| {
                values.sort_by(f64::total_cmp);
                values[values.len() / 2]
            };
            let worst = edits.iter().copied().fold(0.0, f64::max);
            // The first one waits for the tree and the pipeline.
            let mut rays = rays.split_off(4);
            writeln!(
                out,
                "{name:<22} {:>10} {:>8.2} {:>8.2} {worst:>8.2} {:>8.2}",
                format!("{width}x{height}"),
                median(&mut drawn),
                median(&mut edits),
                median(&mut rays),
            )?;
        }
    }
    Ok(())
}
