//! Measures what each shading model costs each preset in looks, and writes `benches/results/interchange_loss.md`.
//!
//! `cargo run --release -p burnish-tests --example interchange_loss -- KEPT.json [MINUTES]`: measures for so many minutes at most, 25 unless stated,
//! and keeps in the file what it has; run again, it goes on, and measures anew only what has changed. The page tells of those presets that are
//! measured in the models of the files that we write, and of those other models that are measured for all of them.

mod kept;
mod page;
mod studio;

use burnish::digest::Digesting;
use burnish::exchange::measure::{Shown, suspects, with_one, without_native_copy};
use burnish_material::exchange::loss::{Fate, Row};
use burnish_material::exchange::model::Context;
use burnish_material::exchange::models::{
    dassault, disney_principled, filament, gltf, gltf_pbr, maps, open_pbr, specular_glossiness, standard_surface, usd_preview,
};
use burnish_material::exchange::{MODELS, ShadingModel};
use burnish_material::{Material, MaterialFile, PROPERTIES};
use burnish_presets::{Preset, presets};
use burnish_renderer::PICTURE_VERSION;
use kept::{Found, Kept};
use page::{Cell, Column, Table};
use std::error::Error;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use studio::{SIDE, Studio, images, is_entered, samples};

/// Those of the files that we write, then the others.
const TURNS: [&[&ShadingModel]; 2] = [
    &[&gltf::MODEL, &open_pbr::MODEL, &usd_preview::MODEL],
    &[
        &maps::MODEL,
        &standard_surface::MODEL,
        &disney_principled::MODEL,
        &filament::MODEL,
        &gltf_pbr::MODEL,
        &dassault::MODEL,
        &specular_glossiness::MODEL,
    ],
];
/// How many of the worst are explained, for each model.
const WORST: usize = 3;
/// Values that are as near as this, relative or below 1 absolute, are not drawn.
const SAME: f64 = 1e-5;

/// A preset on its way through a model.
struct Case<'a> {
    preset: &'a Preset,
    model: &'static ShadingModel,
    material: Material,
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut words = std::env::args().skip(1);
    let place = PathBuf::from(words.next().ok_or("expected the file that keeps what is measured")?);
    let minutes: f64 = words.next().map_or(Ok(25.0), |text| text.parse())?;
    let end = Instant::now() + Duration::from_secs_f64(60.0 * minutes);
    assert_eq!(TURNS.iter().map(|turn| turn.len()).sum::<usize>(), MODELS.len(), "every model has its turn");
    let mut kept = Kept::load(&place);
    let mut studio = Studio::new()?;
    let mut out = std::io::stdout().lock();
    // The quick ones first.
    let mut order = presets()
        .iter()
        .map(|preset| Ok((is_entered(preset.parse()?.0.material()), preset)))
        .collect::<Result<Vec<_>, Box<dyn Error>>>()?;
    order.sort_by_key(|(is_entered, _)| *is_entered);
    'all: for turn in TURNS {
        for (number, (_, preset)) in order.iter().enumerate() {
            if Instant::now() > end {
                break 'all;
            }
            let start = Instant::now();
            let drawn = look(preset, turn, &mut studio, &mut kept)?;
            if drawn > 0 {
                kept.save(&place)?;
                let seconds = start.elapsed().as_secs_f64();
                writeln!(out, "{} of {}: {}, {drawn} pictures, {seconds:.1} s", number + 1, presets().len(), preset.file_stem)?;
            }
        }
        for model in turn.iter().copied() {
            let mut all = Vec::new();
            for preset in presets() {
                let case = Case::new(preset, model)?;
                all.extend(kept.get(&case.name(), &case.state()).map(|found| (found.flip, case)));
            }
            all.sort_by(|(a, _), (b, _)| b.total_cmp(a));
            for (_, case) in all.iter().take(WORST) {
                explain(case, &mut studio, &mut kept)?;
            }
            kept.save(&place)?;
        }
    }
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/results/interchange_loss.md");
    Ok(std::fs::write(path, page::page(&measured(&kept)?, presets().len()))?)
}

/// What is known of the presets that are measured in all models of the first turn, with the models that all of them are measured in.
fn measured(kept: &Kept) -> Result<Table, Box<dyn Error>> {
    let mut rows = Vec::new();
    for preset in presets() {
        let mut cells = Vec::new();
        for model in TURNS.concat() {
            let case = Case::new(preset, model)?;
            cells.push(kept.get(&case.name(), &case.state()).map(|found| Cell { found, rows: case.rows() }));
        }
        let noise = kept.get(&noise_name(preset), &noise_state(preset)).map(|found| found.flip);
        if let Some(noise) = noise.filter(|_| cells.iter().take(TURNS[0].len()).all(Option::is_some)) {
            rows.push((preset, noise, cells));
        }
    }
    let mut table = Table { presets: rows.iter().map(|(preset, noise, _)| (*preset, *noise)).collect(), columns: Vec::new() };
    for (place, model) in TURNS.concat().into_iter().enumerate() {
        let cells = rows.iter_mut().map(|(_, _, cells)| cells[place].take()).collect::<Option<Vec<_>>>();
        table.columns.extend(cells.map(|cells| Column { model, cells }));
    }
    Ok(table)
}

impl<'a> Case<'a> {
    fn new(preset: &'a Preset, model: &'static ShadingModel) -> Result<Self, Box<dyn Error>> {
        Ok(Self { preset, model, material: preset.parse()?.0.material().clone() })
    }

    fn name(&self) -> String {
        format!("{}/{}", self.model.name, self.preset.file_stem)
    }

    /// What the measurement hangs on: both materials, but for images that have to be computed.
    fn state(&self) -> String {
        let context = Context::of(&self.material);
        let translation = self.model.translate(&self.material, &context);
        let back = self.model.interpret(&translation.fields, &context, &mut Vec::new());
        let mut all = Digesting::default();
        all.text(self.preset.text).text(MaterialFile::new(&back).text());
        translation.images.iter().for_each(|image| _ = all.whole(&[image.field as u64]));
        all.text(&setting()).end().to_string()
    }

    fn rows(&self) -> Vec<Row> {
        self.model.translate(&self.material, &Context::of(&self.material)).rows
    }

    /// Whether nothing can differ but rounding.
    fn is_same(&self, back: &Material) -> bool {
        let (here, there) = (self.material.inputs(), back.inputs());
        PROPERTIES.iter().all(|def| {
            let (a, b) = (here.value(def.id), there.value(def.id));
            let is_near =
                a.row().iter().zip(b.row()).all(|(a, b)| f64::from((a - b).abs()) <= SAME * f64::from(a.abs()).max(1.0));
            is_near && self.material.slot(def.id).texture == back.slot(def.id).texture
        })
    }
}

fn setting() -> String {
    format!("{PICTURE_VERSION} {SIDE} {:?}", studio::SAMPLES)
}

fn noise_name(preset: &Preset) -> String {
    format!("noise/{}", preset.file_stem)
}

fn noise_state(preset: &Preset) -> String {
    Digesting::default().text(preset.text).text(&setting()).end().to_string()
}

/// Measures a preset in some models, and its noise. How many pictures that took.
fn look(preset: &Preset, turn: &[&'static ShadingModel], studio: &mut Studio, kept: &mut Kept) -> Result<usize, Box<dyn Error>> {
    let cases = turn.iter().map(|model| Case::new(preset, model)).collect::<Result<Vec<_>, _>>()?;
    let is_missing = |case: &&Case<'_>| kept.get(&case.name(), &case.state()).is_none();
    let missing: Vec<&Case<'_>> = cases.iter().filter(is_missing).collect();
    let is_noise_known = kept.get(&noise_name(preset), &noise_state(preset)).is_some();
    let Some(material) = cases.first().map(|case| &case.material).filter(|_| !missing.is_empty() || !is_noise_known) else {
        return Ok(0);
    };
    let before = studio.drawn;
    let textures = images(material)?;
    let shown = Shown { material, textures: &textures };
    let spp = samples(material);
    let picture = studio.picture(shown, spp, 0);
    if !is_noise_known {
        let flip = studio.flip(&picture, shown, spp, 1);
        kept.put(noise_name(preset), noise_state(preset), Found { flip, by_property: Vec::new() });
    }
    for case in missing {
        let (back, images) = without_native_copy(case.model, shown, &Context::of(material));
        let after = Shown { material: &back, textures: &images };
        let flip = if case.is_same(&back) { 0.0 } else { studio.flip(&picture, after, spp, 0) };
        kept.put(case.name(), case.state(), Found { flip, by_property: Vec::new() });
    }
    Ok(studio.drawn - before)
}

/// Finds the property that a difference is due to.
fn explain(case: &Case<'_>, studio: &mut Studio, kept: &mut Kept) -> Result<(), Box<dyn Error>> {
    let Some(found) = kept.get(&case.name(), &case.state()).filter(|found| found.by_property.is_empty()) else { return Ok(()) };
    let textures = images(&case.material)?;
    let shown = Shown { material: &case.material, textures: &textures };
    let (back, images) = without_native_copy(case.model, shown, &Context::of(&case.material));
    let after = Shown { material: &back, textures: &images };
    let spp = samples(&case.material);
    let picture = studio.picture(shown, spp, 0);
    let mut by_property = Vec::new();
    for property in suspects(&case.material, &back, &case.rows()) {
        let (one, textures) = with_one(shown, after, property);
        let flip = studio.flip(&picture, Shown { material: &one, textures: &textures }, spp, 0);
        by_property.push((property.def().name.to_owned(), flip));
    }
    by_property.sort_by(|(_, a), (_, b)| b.total_cmp(a));
    kept.put(case.name(), case.state(), Found { flip: found.flip, by_property });
    Ok(())
}

/// Whether a material comes through without a loss that a picture could show, as the sheet of losses says.
fn is_lossless(rows: &[Row]) -> bool {
    !rows.iter().any(|row| row.fate > Fate::Remapped && row.has_effect)
}
