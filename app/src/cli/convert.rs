//! `burnish convert`: a material from one format to another, with a sheet of what that costs.

use super::material_argument::{chosen, find_preset, preset_name};
use super::scene_options::{SceneOptions, positive};
use super::target::refuse_target;
use super::{CliError, Messages, Outcome, interrupt, one_line, print_out};
use crate::exchange::measure::{Measured, Shown, measure, without_native_copy};
use crate::exchange::open::{Opened, open};
use crate::exchange::save::{SaveOptions, Saved, Source, save};
use crate::exchange::{ExchangeError, Format, load_mesh};
use crate::files::{self, save_atomic};
use crate::library::setup::{Frame, Setup, Stage};
use crate::picture_diff::Drawing;
use crate::picture_file::embedded_job;
use burnish_assets::{Mesh, Progress, is_image_path, make_shape};
use burnish_material::exchange::ShadingModel;
use burnish_material::exchange::loss::{Fate, Row};
use burnish_material::exchange::model::Context;
use burnish_renderer::tonemap::Display;
use clap::Args;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Side of the pictures of `--measure`.
const SIDE: usize = 192;

/// Arguments of `burnish convert`.
#[derive(Debug, Args)]
pub struct ConvertArguments {
    /// Material in any format that is read, a folder of texture sets, a picture of ours, or preset:NAME
    #[arg(value_name = "IN")]
    input: String,
    /// File whose ending says the format, or a folder: one file per material
    #[arg(value_name = "OUT")]
    out: PathBuf,
    /// Which of several materials, by name or number from 1 [default: all]
    #[arg(long, value_name = "NAME|INDEX")]
    material: Option<String>,
    /// Format of the files in a folder, by its ending; textures.json is a texture set: images named NAME_BaseColor.png and so on
    #[arg(long, value_name = "ENDING", default_value = "asm.ron")]
    format: String,
    /// What the material becomes for other programs, where OUT can hold several models: of .mtlx open_pbr, standard_surface, gltf_pbr, usd_preview or disney_principled; of .textures.json metallic_roughness or specular_glossiness [default: the first of them]
    #[arg(long, value_name = "NAME")]
    model: Option<String>,
    /// Mesh that wears the material, for glTF and USD: built in, or a .gltf, .glb or .ply file
    #[arg(long, value_name = "NAME|FILE")]
    mesh: Option<String>,
    /// Leaves the native copy out: what other programs see is all there is. MDL and texture sets have none to leave out
    #[arg(long)]
    bare: bool,
    /// Writes the sheet of losses as JSON
    #[arg(long, value_name = "FILE.json")]
    report: Option<PathBuf>,
    /// Draws each material before, and as other programs see it, and names the property that explains the difference
    #[arg(long)]
    measure: bool,
    /// Seconds for each picture of --measure, at most
    #[arg(long, value_name = "SECONDS", default_value_t = 10.0, allow_hyphen_values = true, value_parser = positive)]
    time: f64,
    /// Prints one JSON object
    #[arg(long)]
    json: bool,
}

/// What became of one material.
struct Sheet {
    name: String,
    rows: Vec<Row>,
    measured: Option<Measured>,
}

/// Reads, writes and prints.
pub fn run(arguments: &ConvertArguments) -> Result<Outcome, CliError> {
    let mut messages = Messages::default();
    let is_folder = arguments.out.is_dir() || arguments.out.as_os_str().to_string_lossy().ends_with(['/', '\\']);
    let ending = if is_folder { PathBuf::from(format!("x.{}", arguments.format)) } else { arguments.out.clone() };
    let format = Format::of(&ending).ok_or_else(|| CliError::unusable(ExchangeError::UnknownFormat { path: ending.clone() }))?;
    let model = arguments.model.as_deref().map(|name| model(format, name)).transpose()?.or(format.def().model());
    if !is_folder {
        refuse_target("OUT", &arguments.out)?;
    }
    let mut opened = read(&arguments.input, &mut messages)?;
    if let Some(wanted) = &arguments.material {
        opened = vec![chosen(opened, wanted, &arguments.input)?];
    }
    interrupt::check()?;
    let sources: Vec<Source> = opened.iter().map(|opened| source(opened, &arguments.input, &mut messages)).collect();
    let mesh = arguments.mesh.as_deref().map(|text| mesh(text, &mut messages)).transpose()?;
    let options = SaveOptions { mesh: mesh.as_ref().map(|(mesh, unit)| (mesh, *unit)), is_bare: arguments.bare, model };
    let go_on = |_: f32| interrupt::check().is_ok();
    let write = |sources: &[Source], out: &Path| {
        save(sources, out, options, &go_on).map_err(|error| match error {
            ExchangeError::Cancelled => CliError::Interrupted,
            error => CliError::unusable(error),
        })
    };
    let mut saved = Saved::default();
    if is_folder {
        std::fs::create_dir_all(&arguments.out)
            .map_err(|error| CliError::unusable(format!("{}: cannot be made: {error}", arguments.out.display())))?;
        for (source, name) in sources.iter().zip(file_names(&sources)) {
            let one = write(std::slice::from_ref(source), &arguments.out.join(format!("{name}.{}", format.def().ending)))?;
            saved.files.extend(one.files);
            saved.rows.extend(one.rows);
            saved.notes.extend(one.notes);
        }
    } else {
        let all = if format.holds_one() { &sources[..1] } else { &sources[..] };
        if all.len() < sources.len() {
            let others: Vec<&str> = sources[1..].iter().map(|source| source.material.name.as_str()).collect();
            messages.warn(format!("{}: holds one material; not written: {}", arguments.out.display(), others.join(", ")));
        }
        saved = write(all, &arguments.out)?;
    }
    saved.notes.iter().for_each(|note| messages.warn_about(&arguments.out, note));
    let mut sheets = Vec::new();
    for (source, rows) in sources.iter().zip(saved.rows) {
        let measured = if arguments.measure { measured(arguments, model, source, &rows)? } else { None };
        sheets.push(Sheet { name: source.material.name.clone(), rows, measured });
    }
    let report = report(arguments, &saved.files, &sheets, &messages);
    if let Some(path) = &arguments.report {
        save_atomic(path, format!("{report:#}\n").as_bytes()).map_err(CliError::unusable)?;
    }
    print_out(&if arguments.json { report.to_string() } else { text(&saved.files, &sheets) })?;
    Ok(Outcome::Done)
}

fn read(input: &str, messages: &mut Messages) -> Result<Vec<Opened>, CliError> {
    let path = Path::new(input);
    if let Some(name) = preset_name(input) {
        let (file, _) = find_preset(name)?.parse().map_err(|error| CliError::unusable(format!("{input}: {error}")))?;
        return Ok(vec![Opened { file, folder: None, embedded: Default::default(), notes: Vec::new() }]);
    }
    if is_image_path(path) {
        let job = embedded_job(path).map_err(CliError::unusable)?;
        let (opened, _) = files::open_embedded(path, job.as_ref()).map_err(CliError::unusable)?;
        let folder = path.parent().map(Path::to_path_buf);
        return Ok(vec![Opened { file: opened.file, folder, embedded: Default::default(), notes: opened.warnings }]);
    }
    let opened = open(path).map_err(CliError::unusable)?;
    for found in &opened {
        let name = &found.file.material().name;
        for note in &found.notes {
            messages.warn_about(path, &if opened.len() > 1 { format!("{name}: {note}") } else { note.clone() });
        }
    }
    Ok(opened)
}

/// The model of a format that is meant.
fn model(format: Format, name: &str) -> Result<&'static ShadingModel, CliError> {
    let def = format.def();
    def.model_named(name).ok_or_else(|| {
        let known: Vec<&str> = def.models.iter().map(|model| model.name).collect();
        let expected = match known.as_slice() {
            [] => format!("expected no model for .{}", def.ending),
            known => format!("expected {} for .{}", known.join(", "), def.ending),
        };
        CliError::unusable(format!("--model: {expected}, found `{name}`"))
    })
}

fn source(opened: &Opened, input: &str, messages: &mut Messages) -> Source {
    let (textures, problems) = opened.textures();
    problems.iter().for_each(|problem| messages.warn_about(Path::new(input), problem));
    Source {
        material: opened.file.material().clone(),
        file: Some(Arc::new(opened.file.clone())),
        folder: opened.folder.clone(),
        textures,
        embedded: opened.embedded.clone(),
    }
}

/// A mesh, and metres per unit of it.
fn mesh(text: &str, messages: &mut Messages) -> Result<(Mesh, f64), CliError> {
    let model = match make_shape(text) {
        Some(model) => model,
        None => {
            let (model, warnings) = load_mesh(Path::new(text), Progress::NONE).map_err(CliError::unusable)?;
            warnings.iter().for_each(|warning| messages.warn_about(Path::new(text), warning));
            model
        }
    };
    let unit = model.unit_mm.unwrap_or(burnish_material::DEFAULT_UNIT_MM) / 1000.0;
    let part = model.parts.into_iter().next().ok_or_else(|| CliError::unusable(format!("--mesh: {text}: holds no mesh")))?;
    Ok((part.mesh, unit))
}

/// Names for files of these materials: safe everywhere, no two the same.
fn file_names(sources: &[Source]) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for source in sources {
        let safe = |c: char| if c.is_alphanumeric() || "-_ ".contains(c) { c } else { '_' };
        let base: String = source.material.name.chars().map(safe).collect::<String>().trim().to_owned();
        let base = if base.is_empty() { "material".to_owned() } else { base };
        let mut name = base.clone();
        let mut number = 1;
        while names.iter().any(|other| other.eq_ignore_ascii_case(&name)) {
            number += 1;
            name = format!("{base}-{number}");
        }
        names.push(name);
    }
    names
}

fn measured(
    arguments: &ConvertArguments,
    model: Option<&ShadingModel>,
    source: &Source,
    rows: &[Row],
) -> Result<Option<Measured>, CliError> {
    let (Some(model), Some(stage)) = (model, Stage::standard()) else { return Ok(None) };
    let setup = Setup::new(stage, Frame::default(), Vec::new());
    let before = Shown { material: &source.material, textures: &source.textures };
    let (material, textures) = without_native_copy(model, before, &Context::of(&source.material));
    let after = Shown { material: &material, textures: &textures };
    let threads = SceneOptions::default().threads();
    let drawing = Drawing { size: [SIDE; 2], seed: 0, threads, seconds: arguments.time, display: Display::default() };
    let is_cancelled = || interrupt::check().is_err();
    let measured = measure(&setup, before, after, rows, &drawing, &mut |_| {}, &is_cancelled);
    measured.map(Some).ok_or(CliError::Interrupted)
}

fn report(arguments: &ConvertArguments, files: &[PathBuf], sheets: &[Sheet], messages: &Messages) -> Value {
    let row = |name: &str, row: &Row| {
        let Row { property, target, fate, note, has_effect } = row;
        json!({
            "material": name,
            "property": property.def().name,
            "target": target,
            "fate": fate.word(),
            "note": note,
            "has_effect": has_effect,
        })
    };
    let rows: Vec<Value> = sheets.iter().flat_map(|sheet| sheet.rows.iter().map(|r| row(&sheet.name, r))).collect();
    let flips: Vec<f64> = sheets.iter().filter_map(|sheet| sheet.measured.as_ref()).map(|measured| measured.flip_mean).collect();
    let mean = (!flips.is_empty()).then(|| flips.iter().sum::<f64>() / flips.len() as f64);
    let materials: Vec<Value> = sheets
        .iter()
        .map(|sheet| {
            let measured = sheet.measured.as_ref();
            let because = measured.and_then(Measured::explanation).map(|(property, _)| property.def().name);
            let alone = |(property, flip): &(burnish_material::Property, f64)| json!({ "property": property.def().name, "flip_mean": flip });
            json!({
                "name": sheet.name,
                "flip_mean": measured.map(|measured| measured.flip_mean),
                "explained_by": because,
                "by_property": measured.map(|measured| measured.by_property.iter().map(alone).collect::<Vec<_>>()),
            })
        })
        .collect();
    json!({
        "in": arguments.input,
        "out": files,
        "materials": materials,
        "rows": rows,
        "flip_mean": mean,
        "warnings": messages.warnings(),
    })
}

fn text(files: &[PathBuf], sheets: &[Sheet]) -> String {
    let mut lines = String::new();
    for sheet in sheets.iter().filter(|sheet| !sheet.rows.is_empty()) {
        let of = |fate: Fate| sheet.rows.iter().filter(|row| row.fate == fate).count();
        let counts: Vec<String> = Fate::ALL.iter().map(|(fate, word)| format!("{} {word}", of(*fate))).collect();
        lines += &format!("{}: {}\n", sheet.name, counts.join(", "));
        for row in sheet.rows.iter().filter(|row| row.fate > Fate::Remapped) {
            let note = if row.note.is_empty() { String::new() } else { format!(": {}", one_line(&row.note)) };
            lines += &format!("  {} {}{note}\n", row.property.def().name, row.fate.word());
        }
        if let Some(measured) = &sheet.measured {
            let because = measured.explanation().map_or_else(String::new, |(property, flip)| {
                format!(", most of it by {} ({flip:.3} alone)", property.def().name)
            });
            lines += &format!("  seen by other programs: FLIP {:.3}{because}\n", measured.flip_mean);
        }
    }
    let names: Vec<String> = files.iter().map(|file| file.display().to_string()).collect();
    format!("{lines}wrote {}", names.join(", "))
}
