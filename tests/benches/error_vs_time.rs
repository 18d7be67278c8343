//! Error against run time of whole scenes and of presets, as CSV and as a page of curves.
//!
//! `cargo bench -p burnish-tests --bench error_vs_time -- --scenes FOLDER` renders every `asm-bench-scene/1` file of a folder (also from the
//! variable `BURNISH_BENCH_SCENES`; without either, presets alone) and eight presets on the default scene in doublings of samples. Each curve has
//! its own reference of another seed, whose noise is taken off. Options: `--seconds S` per curve (1), `--size N` pixels a side (128),
//! `--spp-max N`, `--reference-spp N` (8 times the largest count), `--threads N` (all), `--only TEXT` (names that hold it), `--out FOLDER`
//! (`target/error_vs_time`).

#![allow(clippy::print_stdout, reason = "a program for the terminal")]

use burnish::cli::Messages;
use burnish::cli::scene_options::SceneOptions;
use burnish::curve::{Curve, ReferenceSource, csv, html, measure};
use burnish::files::save_atomic;
use burnish_renderer::path::{Settings, StopRules};
use burnish_renderer::tonemap::Display;
use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// One of every kind of transport: metal, glass, jewel, coat, cloth, scattering, liquid, rough dielectric.
const PRESETS: [&str; 8] = [
    "Gold, polished",
    "Frosted glass",
    "Diamond",
    "Car paint, metallic blue",
    "Velvet, crimson",
    "Milk, whole",
    "Red wine",
    "Moulded plastic, red",
];

/// What the command line asks for.
struct Options {
    scenes: Option<PathBuf>,
    seconds: f64,
    size: usize,
    spp_max: Option<u32>,
    reference_spp: Option<u32>,
    threads: Option<usize>,
    only: Option<String>,
    out: PathBuf,
}

impl Options {
    fn read() -> Result<Self, Box<dyn Error>> {
        let mut options = Self {
            scenes: std::env::var_os("BURNISH_BENCH_SCENES").map(PathBuf::from),
            seconds: 1.0,
            size: 128,
            spp_max: None,
            reference_spp: None,
            threads: None,
            only: None,
            out: Path::new(env!("CARGO_MANIFEST_DIR")).join("../target/error_vs_time"),
        };
        let mut words = std::env::args().skip(1);
        while let Some(word) = words.next() {
            // What `cargo bench` adds by itself.
            if word == "--bench" {
                continue;
            }
            let value = words.next().ok_or_else(|| format!("{word}: expected a value"))?;
            let problem = |error: &dyn Error| format!("{word} {value}: {error}");
            match word.as_str() {
                "--scenes" => options.scenes = Some(value.into()),
                "--seconds" => options.seconds = value.parse().map_err(|e| problem(&e))?,
                "--size" => options.size = value.parse().map_err(|e| problem(&e))?,
                "--spp-max" => options.spp_max = Some(value.parse().map_err(|e| problem(&e))?),
                "--reference-spp" => options.reference_spp = Some(value.parse().map_err(|e| problem(&e))?),
                "--threads" => options.threads = Some(value.parse().map_err(|e| problem(&e))?),
                "--only" => options.only = Some(value.to_lowercase()),
                "--out" => options.out = value.into(),
                _ => return Err(format!("{word}: expected an option that the head of error_vs_time.rs names").into()),
            }
        }
        Ok(options)
    }

    /// What is measured: a name, and what the command line calls it.
    fn cases(&self) -> Result<Vec<(String, Case)>, Box<dyn Error>> {
        let mut cases = Vec::new();
        match &self.scenes {
            Some(folder) if folder.is_dir() => {
                let mut files: Vec<PathBuf> = std::fs::read_dir(folder)?.flatten().map(|entry| entry.path()).collect();
                files.retain(|file| file.extension().is_some_and(|ending| ending == "json"));
                files.sort();
                for file in files {
                    let name = file.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
                    cases.push((name, Case::Scene(file)));
                }
            }
            Some(folder) => println!("skipped: whole scenes: {} is no folder", folder.display()),
            None => println!("skipped: whole scenes: neither --scenes nor BURNISH_BENCH_SCENES names their folder"),
        }
        cases.extend(PRESETS.map(|name| (name.to_owned(), Case::Preset(name))));
        if let Some(only) = &self.only {
            cases.retain(|(name, _)| name.to_lowercase().contains(only));
        }
        Ok(cases)
    }
}

enum Case {
    Scene(PathBuf),
    Preset(&'static str),
}

fn curve(name: &str, case: &Case, options: &Options) -> Result<Curve, Box<dyn Error>> {
    let mut scene =
        SceneOptions { threads: options.threads, size: Some((options.size, options.size)), ..SceneOptions::default() };
    let material = match case {
        Case::Scene(file) => {
            scene.scene = Some(file.clone());
            None
        }
        Case::Preset(name) => Some(format!("preset:{name}")),
    };
    let loaded = scene.load(material.as_deref(), None, &mut Messages::default())?;
    let settings = Settings {
        width: loaded.width,
        height: loaded.height,
        seed: scene.seed,
        threads: scene.threads(),
        stop: StopRules { spp: options.spp_max, seconds: Some(options.seconds), relmse: None },
        is_adaptive: true,
    };
    let source = ReferenceSource::Own(options.reference_spp);
    let curve = measure(name, &loaded.scene, &settings, source, Display::default(), &mut |_| true);
    curve.ok_or_else(|| "cancelled".into())
}

fn run() -> Result<(), Box<dyn Error>> {
    let options = Options::read()?;
    let mut curves = Vec::new();
    println!(
        "{:<28} {:>8} {:>8} {:>11} {:>11} {:>9} {:>9}",
        "", "spp", "seconds", "relMSE", "trimmed", "s to 0.01", "s to 0.001"
    );
    for (name, case) in options.cases()? {
        let curve = curve(&name, &case, &options)?;
        if let Some(row) = curve.rows.last() {
            let time = |i: usize| {
                let target = curve.targets()[0][i];
                let mark = if target.is_extrapolated { "*" } else { "" };
                target.seconds.map_or_else(|| "-".to_owned(), |seconds| format!("{seconds:.2}{mark}"))
            };
            println!(
                "{name:<28} {:>8} {:>8.2} {:>11.3e} {:>11.3e} {:>9} {:>9}",
                row.spp,
                row.seconds,
                row.relmse,
                row.relmse_trimmed,
                time(0),
                time(1)
            );
        }
        curves.push(curve);
        // After every curve, so that a run that is cut short has shown something.
        std::fs::create_dir_all(&options.out)?;
        save_atomic(&options.out.join("error_vs_time.csv"), csv(&curves).as_bytes())?;
        save_atomic(&options.out.join("error_vs_time.html"), html("Error against run time", &curves).as_bytes())?;
    }
    println!("* predicted; {} and .html", options.out.join("error_vs_time.csv").display());
    Ok(())
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
