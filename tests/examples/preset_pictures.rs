//! Makes the sheet of small pictures that the program shows beside its presets; cells of presets that look as before are kept.
//!
//! `cargo run --release -p burnish-tests --example preset_pictures [SECONDS]`: at most so many seconds for a picture, 8 unless stated. What is
//! made is written after each picture, so that it can be interrupted.

use burnish::library::entry::Entry;
use burnish::library::maker::{Limits, Renderer};
use burnish::library::setup::{Frame, Setup, Stage};
use burnish::library::walk::walk;
use burnish_presets::pictures::{ACROSS, SIDE};
use image::{RgbImage, codecs::jpeg::JpegEncoder, imageops};
use std::collections::HashMap;
use std::error::Error;
use std::fs;
use std::io::Write;
use std::path::Path;

/// Error at which a picture is done, as relMSE: 3 %.
const RELMSE: f64 = 0.0009;
/// Rendered larger, so that edges are smooth in the cell.
const OVER: usize = 2;
const QUALITY: u8 = 88;

fn main() -> Result<(), Box<dyn Error>> {
    let seconds: f64 = std::env::args().nth(1).map_or(Ok(8.0), |text| text.parse())?;
    let presets = Path::new(env!("CARGO_MANIFEST_DIR")).join("../presets");
    let (data, sheet, looks) = (presets.join("data"), presets.join("pictures/sheet.jpg"), presets.join("pictures/looks.txt"));
    let old_looks = fs::read_to_string(&looks).unwrap_or_default();
    let old_sheet = image::open(&sheet).map(|image| image.to_rgb8()).unwrap_or_default();
    let old: HashMap<&str, (usize, &str)> = old_looks
        .lines()
        .enumerate()
        .filter_map(|(n, line)| line.split_once(' ').map(|(stem, look)| (stem, (n, look))))
        .collect();
    let frame = Frame { width: OVER * SIDE, height: OVER * SIDE, relmse: RELMSE, ..Frame::default() };
    let setup = Setup::new(Stage::standard().ok_or("there is no built-in scene")?, frame, Vec::new());
    let files = walk(&data, &|| false)?;
    let entries: Vec<Entry> = files.files.iter().map(|found| Entry::read(&data, found)).collect();
    let side = SIDE as u32;
    let mut picture = RgbImage::new(side * ACROSS as u32, side * entries.len().div_ceil(ACROSS) as u32);
    let place = |n: usize| (i64::from(side) * (n % ACROSS) as i64, i64::from(side) * (n / ACROSS) as i64);
    let mut lines = vec![String::new(); entries.len()];
    let stem = |entry: &Entry| entry.path.file_name().unwrap_or_default().to_string_lossy().replace(".asm.ron", "");
    let mut missing = Vec::new();
    for (n, entry) in entries.iter().enumerate() {
        let known = old.get(&*stem(entry)).copied();
        if let Some((old, look)) = known {
            let (x, y) = place(old);
            let cell = imageops::crop_imm(&old_sheet, x as u32, y as u32, side, side).to_image();
            let (x, y) = place(n);
            imageops::replace(&mut picture, &cell, x, y);
            lines[n] = format!("{} {look}", stem(entry));
        }
        if known.is_none_or(|(_, look)| look != entry.look.to_string()) {
            missing.push(n);
        }
    }
    let limits = Limits { seconds, threads: std::thread::available_parallelism()?.get() };
    let (mut renderer, mut out) = (Renderer::new(&data), std::io::stdout().lock());
    for (count, n) in missing.iter().copied().enumerate() {
        let entry = &entries[n];
        let (rendering, problems) = renderer.render(&setup, entry, None, limits, &mut |_| true)?;
        problems.iter().try_for_each(|problem| writeln!(out, "{problem}"))?;
        let made = setup.develop(&rendering)?;
        let large = RgbImage::from_raw(frame.width as u32, frame.height as u32, made.rgb).ok_or("it has another size")?;
        let (x, y) = place(n);
        imageops::replace(&mut picture, &imageops::resize(&large, side, side, imageops::FilterType::Triangle), x, y);
        lines[n] = format!("{} {}", stem(entry), entry.look);
        let error = 100.0 * made.relmse.unwrap_or(f64::NAN).sqrt();
        writeln!(out, "{} of {}: {}, {:.1} s, {error:.1} %", count + 1, missing.len(), stem(entry), made.seconds)?;
        write(&sheet, &looks, &picture, &lines)?;
    }
    write(&sheet, &looks, &picture, &lines)
}

fn write(sheet: &Path, looks: &Path, picture: &RgbImage, lines: &[String]) -> Result<(), Box<dyn Error>> {
    let mut bytes = Vec::new();
    picture.write_with_encoder(JpegEncoder::new_with_quality(&mut bytes, QUALITY))?;
    fs::write(sheet, bytes)?;
    let text: String = lines
        .iter()
        .enumerate()
        .map(|(n, line)| if line.is_empty() { format!("? {n}\n") } else { format!("{line}\n") })
        .collect();
    fs::write(looks, text)?;
    Ok(())
}
