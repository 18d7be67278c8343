//! What a picture holds: size, format, background, passes, denoising, and what ends it. Frames of a turntable are pictures.

use super::{Around, ExportPanel, Kind, MAX_SIDE, heading, note, row, section};
use crate::export::{Format, LayerKind};
use crate::offline::picture::View;
use crate::offline::picture_options::{DEFAULT_SPP, Denoise};
use crate::panels::preferences::choice;
use crate::panels::{toolbar, viewport};
use crate::scene_file::MAX_PIXELS;
use crate::theme;
use crate::widgets::number_field::{NumberField, Scale};
use burnish_renderer::path::StopRules;
use egui::{Button, Label, RichText, Ui};
use std::path::Path;

/// Sizes to choose among.
const SIZES: [([usize; 2], &str); 9] = [
    ([1280, 720], "HD, 1280 × 720"),
    ([1920, 1080], "Full HD, 1920 × 1080"),
    ([3840, 2160], "4K, 3840 × 2160"),
    ([1080, 1350], "Portrait, 1080 × 1350"),
    ([1024, 1024], "Square, 1024"),
    ([2048, 2048], "Square, 2048"),
    ([4096, 4096], "Square, 4096"),
    ([8192, 4608], "8K, 8192 × 4608"),
    ([8192, 8192], "Square, 8192"),
];

/// What denoising does with the files.
const DENOISE: [(Option<Denoise>, &str); 4] = [
    (None, "Off"),
    (Some(Denoise::Auto), "Best there is"),
    (Some(Denoise::Own), "Own filter"),
    (Some(Denoise::Oidn), "Open Image Denoise"),
];

impl ExportPanel {
    /// The settings of a picture.
    pub(super) fn picture(&mut self, ui: &mut Ui, around: &mut Around<'_>) {
        section(ui, "Renderer", |ui| {
            row(ui, "Picture of", |ui| {
                ui.radio_value(&mut self.view, View::Final, "Final").on_hover_text("Path traced until a rule below ends it");
                ui.add_enabled_ui(around.has_preview, |ui| {
                    let hint = "As the view shows it at once, without passes, alpha and denoising";
                    ui.radio_value(&mut self.view, View::Preview, "Preview").on_hover_text(hint);
                });
            });
        });
        self.content(ui, around);
        if self.view == View::Preview {
            heading(ui, "Stop when it changes no more, or at");
            narrow(ui, |ui| viewport::time_rule(ui, &mut self.preview_seconds, " of the preview"));
            return;
        }
        stop_fields(ui, &mut self.stop, " of the picture");
    }

    /// What pictures and frames have in common.
    pub(super) fn content(&mut self, ui: &mut Ui, around: &mut Around<'_>) {
        self.size_rows(ui, around.view_size);
        let is_final = self.view == View::Final || self.kind == Kind::Turntable;
        section(ui, "File", |ui| {
            row(ui, "Format", |ui| self.format_fields(ui));
            row(ui, "Transform", |ui| {
                ui.add_enabled_ui(self.format == Format::Png, |ui| {
                    toolbar::transform_menu(ui, "Display transform of pictures", &mut around.display.transform, |_| {});
                });
                let ev = around.display.exposure_ev;
                ui.add(Label::new(RichText::new(format!("exposure {ev:+.2} EV, as the view")).small().weak()).truncate());
            });
            row(ui, "Background", |ui| {
                ui.add_enabled(is_final, egui::Checkbox::new(&mut self.options.transparent, "transparent"));
            });
            row(ui, "Denoise", |ui| {
                ui.add_enabled_ui(is_final, |ui| choice(ui, "Denoise pictures", &mut self.options.denoise, &DENOISE));
            });
        });
        note(ui, &format!("{}; {}", Format::Png.encoding(), Format::Exr.encoding()));
        if is_final && self.options.denoise.is_some() {
            note(
                ui,
                match self.format {
                    Format::Png => "NAME.png is denoised and says so; NAME.raw.png beside it is as rendered.",
                    Format::Exr => "Channels R, G, B are denoised; raw.R, raw.G, raw.B are as rendered.",
                },
            );
        }
        heading(ui, "Passes");
        ui.add_enabled_ui(is_final, |ui| {
            ui.horizontal_wrapped(|ui| {
                for (kind, word) in LayerKind::ALL {
                    let mut is_on = self.options.aov.contains(&kind);
                    if ui.checkbox(&mut is_on, word).on_hover_text(kind.meaning()).changed() {
                        self.options.aov.retain(|known| *known != kind);
                        self.options.aov.extend(is_on.then_some(kind));
                    }
                }
            });
        });
        if let Some(kind) = self.options.aov.first().filter(|_| is_final) {
            let (word, channel) = (kind.word(), kind.channels()[0]);
            note(
                ui,
                &match self.format {
                    Format::Png => format!("Beside the picture: NAME.{word}.png"),
                    Format::Exr => format!("As channels of the file: {word}.{channel}"),
                },
            );
        }
    }

    fn size_rows(&mut self, ui: &mut Ui, view_size: [usize; 2]) {
        section(ui, "Size", |ui| {
            row(ui, "Preset", |ui| {
                let mut sizes = vec![(None, "As the view")];
                sizes.extend(SIZES.map(|(size, text)| (Some(size), text)));
                let own = self.size.map_or_else(String::new, |[w, h]| format!("Own, {w} × {h}"));
                if sizes.iter().all(|(size, _)| *size != self.size) {
                    sizes.insert(1, (self.size, &own));
                }
                choice(ui, "Size preset", &mut self.size, &sizes);
            });
            row(ui, "Pixels", |ui| {
                let old = self.size(view_size);
                let mut new = old;
                for (k, name) in ["Width of pictures", "Height of pictures"].into_iter().enumerate() {
                    if k == 1 {
                        ui.label("×");
                    }
                    if let Some(side) = whole(ui, name, old[k] as f64, MAX_SIDE as f64) {
                        new[k] = side as usize;
                        if self.keeps_proportions {
                            let other = side * old[1 - k] as f64 / old[k] as f64;
                            new[1 - k] = (other.round() as usize).clamp(1, MAX_SIDE);
                        }
                    }
                }
                if new != old {
                    self.size = Some(new);
                }
                ui.checkbox(&mut self.keeps_proportions, "keep ratio")
                    .on_hover_text("Keep the proportions when one side changes")
                    .accessible_name("Keep proportions");
            });
        });
        let [width, height] = self.size(view_size);
        if width * height > MAX_PIXELS {
            note(ui, "Larger than 4096 × 4096: made in parts, without passes and denoising.");
        }
    }

    fn format_fields(&mut self, ui: &mut Ui) {
        let exact = |is_more: bool, less: &'static str, more: &'static str| if is_more { more } else { less };
        for format in [Format::Png, Format::Exr] {
            let text = exact(format == Format::Exr, "PNG", "EXR");
            ui.radio_value(&mut self.format, format, text);
        }
        match self.format {
            Format::Png => {
                choice(ui, "Bits of PNG", &mut self.options.bits, &[(None, "8 bit"), (Some(16), "16 bit")]);
            }
            Format::Exr => {
                choice(ui, "Precision of EXR", &mut self.options.half, &[(false, "32-bit float"), (true, "half")]);
            }
        }
    }

    /// Why this cannot be made.
    pub(super) fn problem(&self, around: &Around<'_>) -> Option<String> {
        let [width, height] = self.size(around.view_size);
        let is_more = !self.options.aov.is_empty() || self.options.denoise.is_some();
        let is_final = self.view == View::Final;
        match self.kind {
            Kind::Picture if !is_final && !around.has_preview => {
                Some("There is no preview; the final view can be rendered.".into())
            }
            Kind::Picture if is_final && is_more && width * height > MAX_PIXELS => {
                Some(format!("{width} × {height} is too large for passes and denoising: at most 4096 × 4096."))
            }
            Kind::Turntable if width * height > MAX_PIXELS => {
                Some(format!("{width} × {height} is too large for a turntable: at most 4096 × 4096."))
            }
            _ => None,
        }
    }
}

/// What ends a picture; the names of the fields end in `of`.
pub(super) fn stop_fields(ui: &mut Ui, stop: &mut StopRules, of: &str) {
    heading(ui, "Stop at, whichever comes first");
    narrow(ui, |ui| viewport::stop_rules(ui, stop, of));
    if *stop == StopRules::default() {
        note(ui, &format!("Without a rule: {DEFAULT_SPP} samples per pixel."));
    }
}

/// Keeps numbers near their names in wide panels.
fn narrow(ui: &mut Ui, content: impl FnOnce(&mut Ui)) {
    ui.scope(|ui| {
        ui.set_max_width(270.0 * theme::text_scale(ui));
        content(ui);
    });
}

/// A whole number from 1 on; the new one when it was edited.
pub(super) fn whole(ui: &mut Ui, name: &str, old: f64, most: f64) -> Option<f64> {
    let field = NumberField {
        range: 1.0..=most,
        step: 1.0,
        scale: Scale::Linear(1.0),
        format: |x| format!("{x:.0}"),
        ..NumberField::plain(name, 54.0, 1.0)
    };
    field.show(ui, old).map(f64::round)
}

/// What was made last, and the command that makes it again.
pub(super) fn last(ui: &mut Ui, path: &Path, text: &str) {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    ui.add(Label::new(RichText::new(format!("✔ {name}: {text}")).small()).wrap()).on_hover_text(path.display().to_string());
    let again = path.with_file_name(format!("again-{name}"));
    let command = format!("burnish render {} --out {}", quoted(path), quoted(&again));
    ui.horizontal(|ui| {
        let name = "Copy the command that renders it again";
        if ui.add(Button::new("Copy").small()).on_hover_text(name).accessible_name(name).clicked() {
            ui.ctx().copy_text(command.clone());
        }
        ui.add(Label::new(RichText::new(&command).small().monospace().weak()).truncate()).on_hover_text(&command);
    });
}

/// A path as a shell takes it.
fn quoted(path: &Path) -> String {
    format!("\"{}\"", path.display())
}
