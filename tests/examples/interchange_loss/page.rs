//! The page of results.

use crate::kept::Found;
use crate::studio::{SAMPLES, SIDE, TEXELS};
use crate::{WORST, is_lossless};
use burnish_material::PROPERTIES;
use burnish_material::exchange::ShadingModel;
use burnish_material::exchange::loss::{Fate, Row};
use burnish_presets::{Preset, group_title};
use std::fmt::Write;

/// What became of a preset in a model.
pub struct Cell {
    pub found: Found,
    pub rows: Vec<Row>,
}

/// Presets with their noise, FLIP between two pictures of other random numbers; a column for each model.
pub struct Table {
    pub presets: Vec<(&'static Preset, f64)>,
    pub columns: Vec<Column>,
}

/// A model, with a cell for each preset.
pub struct Column {
    pub model: &'static ShadingModel,
    pub cells: Vec<Cell>,
}

impl Cell {
    /// Properties of this fate that the material needs.
    fn lost(&self, fate: Fate) -> impl Iterator<Item = &'static str> {
        self.rows.iter().filter(move |row| row.fate == fate && row.has_effect).map(|row| row.property.def().name)
    }
}

/// The page. `total`: presets that there are.
pub fn page(Table { presets, columns }: &Table, total: usize) -> String {
    let [opaque, entered] = SAMPLES;
    let noise: Vec<f64> = presets.iter().map(|(_, noise)| *noise).collect();
    let all_or_some = if presets.len() == total { format!("the {total}") } else { format!("{} of the {total}", presets.len()) };
    let mut page = format!(
        "# What other programs see of the presets\n\n\
         `cargo run --release -p burnish-tests --example interchange_loss`: {all_or_some} presets before and after the translation to a shading \
         model and back, without the native copy; this program itself gets every bit back from that. Shader ball in the studio, {SIDE}x{SIDE}, {opaque} \
         samples per pixel, {entered} where light enters the material; mean of FLIP over the picture, 0 to 1, stand and background included. Images, of {TEXELS} texels a side at \
         most, are computed where a model needs one that nobody has, as an export does; the way back is measured along with the way there. What each loss means is in `material/INTERCHANGE.md`.\n\n\
         Noise: the same preset with other random numbers gives {median:.3} in the median, {high:.3} at the 90th percentile, {most:.3} at most. Before and \
         after are drawn with the same random numbers, so that noise cancels where they do the same; a value below the noise of its row still shows a \
         difference, but not how large it is. 0 stands for materials that are the same to five digits, which are not drawn.\n",
        median = quantile(&noise, 0.5),
        high = quantile(&noise, 0.9),
        most = quantile(&noise, 1.0),
    );
    summary(&mut page, &noise, columns);
    worst(&mut page, presets, columns);
    properties(&mut page, columns);
    all(&mut page, presets, columns);
    page
}

fn quantile(values: &[f64], share: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let place = (share * sorted.len().saturating_sub(1) as f64).round() as usize;
    sorted.get(place).copied().unwrap_or_default()
}

fn summary(page: &mut String, noise: &[f64], columns: &[Column]) {
    *page += "\n## By shading model\n\nExact: presets that lose nothing with an effect, as the sheet of losses says. Seen: presets that differ by more than the noise \
              of two pictures.\n\n| Model | mean | median | 90th percentile | worst | exact | seen |\n| --- | --: | --: | --: | --: | --: | --: |\n";
    for Column { model, cells } in columns {
        let flips: Vec<f64> = cells.iter().map(|cell| cell.found.flip).collect();
        let mean = flips.iter().sum::<f64>() / flips.len().max(1) as f64;
        let exact = cells.iter().filter(|cell| is_lossless(&cell.rows)).count();
        let seen = flips.iter().zip(noise).filter(|(flip, noise)| flip > noise).count();
        let [median, high, most] = [0.5, 0.9, 1.0].map(|share| quantile(&flips, share));
        // Writing to a String cannot fail.
        _ = writeln!(page, "| {} | {mean:.3} | {median:.3} | {high:.3} | {most:.3} | {exact} | {seen} |", model.label);
    }
}

fn worst(page: &mut String, presets: &[(&Preset, f64)], columns: &[Column]) {
    *page += "\n## The worst\n\nIn brackets, properties with the FLIP that each gives alone.\n\n";
    for Column { model, cells } in columns {
        let mut order: Vec<(&Preset, &Cell)> = presets.iter().map(|(preset, _)| *preset).zip(cells).collect();
        order.sort_by(|(_, a), (_, b)| b.found.flip.total_cmp(&a.found.flip));
        let named = order.iter().filter(|(_, cell)| cell.found.flip > 0.0).take(WORST).map(|(preset, cell)| {
            let by = cell.found.by_property.iter().take(3).map(|(name, flip)| format!("`{name}` {flip:.3}"));
            let by = by.collect::<Vec<_>>().join(", ");
            let by = if by.is_empty() { "nothing is said to be lost" } else { &by };
            format!("{} {:.3} ({by})", preset.name, cell.found.flip)
        });
        let named = named.collect::<Vec<_>>().join("; ");
        _ = writeln!(page, "- **{}**: {}", model.label, if named.is_empty() { "nothing to tell" } else { &named });
    }
}

fn properties(page: &mut String, columns: &[Column]) {
    *page += "\n## By property\n\nPresets in which a property that the material needs is dropped, or, in brackets, approximated.\n\n| Property |";
    columns.iter().for_each(|column| _ = write!(page, " {} |", column.model.label));
    _ = writeln!(page, "\n| --- |{}", " --: |".repeat(columns.len()));
    for def in PROPERTIES {
        let count =
            |column: &Column, fate| column.cells.iter().filter(|cell| cell.lost(fate).any(|name| name == def.name)).count();
        let counts: Vec<[usize; 2]> =
            columns.iter().map(|column| [Fate::Dropped, Fate::Approximated].map(|fate| count(column, fate))).collect();
        if counts.as_flattened().iter().all(|count| *count == 0) {
            continue;
        }
        let texts = counts.iter().map(|[dropped, approximated]| match (dropped, approximated) {
            (0, 0) => String::new(),
            (dropped, 0) => dropped.to_string(),
            (0, approximated) => format!("({approximated})"),
            (dropped, approximated) => format!("{dropped} ({approximated})"),
        });
        _ = writeln!(page, "| `{}` | {} |", def.name, texts.collect::<Vec<_>>().join(" | "));
    }
}

fn all(page: &mut String, presets: &[(&Preset, f64)], columns: &[Column]) {
    *page += "\n## Every preset\n\nFLIP, and the properties that are dropped.\n";
    let mut group = "";
    for (number, (preset, noise)) in presets.iter().enumerate() {
        if preset.group != group {
            group = preset.group;
            _ = write!(page, "\n### {}\n\n| Preset | noise |", group_title(group));
            columns.iter().for_each(|column| _ = write!(page, " {} |", column.model.label));
            _ = writeln!(page, "\n| --- | --: |{}", " --- |".repeat(columns.len()));
        }
        let cells = columns.iter().filter_map(|column| column.cells.get(number)).map(|cell| {
            let flip = if cell.found.flip == 0.0 { "0".to_owned() } else { format!("{:.3}", cell.found.flip) };
            let dropped: Vec<&str> = cell.lost(Fate::Dropped).collect();
            if dropped.is_empty() { flip } else { format!("{flip}: {}", dropped.join(", ")) }
        });
        _ = writeln!(page, "| {} | {noise:.3} | {} |", preset.name, cells.collect::<Vec<_>>().join(" | "));
    }
}
