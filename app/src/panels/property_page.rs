//! Everything that is known about one property.

use crate::theme;
use crate::widgets::number;
use crate::widgets::row_notes::value_text;
use burnish_material::{LOBES, LobeSet, Material, Property, Vary};
use burnish_presets::measured;
use egui::{Grid, Label, RichText, Ui, vec2};

/// Measured materials listed.
const MAX_MEASURED: usize = 14;

/// Shows the page.
pub fn show(ui: &mut Ui, property: Property, material: &Material) {
    let (def, palette) = (property.def(), theme::now());
    ui.label(def.doc);
    ui.add_space(6.0);
    let mut rows: Vec<(&str, String)> = vec![
        ("Name", def.label.to_owned()),
        ("Formal name", def.name.to_owned()),
        ("Usage", def.usage.to_owned()),
        ("Group", def.group.title().to_owned()),
        ("Default", value_text(def.default) + def.unit.suffix()),
        ("Now", value_text(material.value(property)) + def.unit.suffix()),
    ];
    if !def.limits.text().is_empty() {
        rows.push(("Limits", def.limits.text()));
    }
    rows.push((
        "Varies",
        match def.vary {
            Vary::Uniform => "no, one value for the whole material",
            Vary::Texturable => "a value or a map",
            Vary::TextureOnly => "a map; a value is a constant map",
        }
        .to_owned(),
    ));
    if let Some((low, high)) = measured::zone(material, property) {
        let zone = format!("{} to {}{}", number::format(low, 3), number::format(high, 3), def.unit.suffix());
        rows.push(("Real materials", zone));
    }
    rows.extend(measured::sentence(material, property).map(|near| ("", near)));
    Grid::new("facts").num_columns(2).spacing(vec2(14.0, 3.0)).show(ui, |ui| {
        for (name, text) in rows {
            ui.label(RichText::new(name).color(palette.weak));
            ui.add(Label::new(text).wrap());
            ui.end_row();
        }
    });
    let lobes = LobeSet::of(material);
    let users: Vec<_> = LOBES.iter().filter(|lobe| lobe.properties.contains(&property)).collect();
    if !users.is_empty() {
        ui.add_space(6.0);
        ui.label(RichText::new("Used by").color(palette.strong));
        for lobe in users {
            let state = if lobes.has(lobe.lobe) { "in use" } else { "left out now" };
            ui.label(format!("{} ({state}): {}", lobe.name.replace('_', " "), lobe.doc));
        }
    }
    let mut known: Vec<_> = measured::measured().iter().filter_map(|m| Some((m.name, m.value(property)?, m.dataset))).collect();
    if known.is_empty() {
        return;
    }
    ui.add_space(6.0);
    ui.label(RichText::new(format!("Measured ({} in all; lengths in mm)", known.len())).color(palette.strong));
    // Evenly over all, so that the list shows the range and not one group.
    known.sort_by(|a, b| a.1.numbers().first().copied().unwrap_or(0.0).total_cmp(&b.1.numbers().first().copied().unwrap_or(0.0)));
    let step = known.len().div_ceil(MAX_MEASURED);
    Grid::new("measured").num_columns(3).spacing(vec2(14.0, 2.0)).striped(true).show(ui, |ui| {
        for (name, value, dataset) in known.into_iter().step_by(step) {
            ui.label(name);
            ui.label(value_text(value));
            ui.label(RichText::new(dataset).small().color(palette.weak));
            ui.end_row();
        }
    });
}
