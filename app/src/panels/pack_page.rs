//! The page before a pack of the library is exported: in which formats of other programs its materials are written, too.

use crate::library::pack::{FORMATS, Formats};
use egui::{RichText, Ui};

/// Shows the page; whether the place of the pack is to be chosen.
pub fn show(ui: &mut Ui, formats: &mut Formats) -> bool {
    ui.label("A folder to hand out: materials with their images, contact sheet, licences, report of the check, and a list of all files.");
    ui.add_space(6.0);
    ui.label(RichText::new("For other programs").strong());
    for ((word, format), is_written) in FORMATS.iter().zip(&mut formats.0) {
        let def = format.def();
        ui.checkbox(is_written, format!("{} (.{})", def.label, def.ending))
            .on_hover_text(format!("A file for each material in the folder “{word}”, with the images that it needs beside it."));
    }
    let cost = "What each format costs is listed in losses.json.";
    ui.label(RichText::new(if *formats == Formats::NONE { "Only material files are written." } else { cost }).weak());
    ui.add_space(6.0);
    ui.button("Export…").clicked()
}
