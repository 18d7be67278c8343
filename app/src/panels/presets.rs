//! The preset list: grouped, with a filter, and a small picture of each; a dot in the colour that makes it known where there is no picture yet.

use crate::theme;
use crate::widgets::color_edit::display_color;
use crate::widgets::search_field::search_field;
use burnish_material::{Material, Property};
use burnish_presets::{Preset, pictures};
use egui::{
    CollapsingHeader, Color32, ColorImage, Context, CornerRadius, Label, Rect, RichText, Role, ScrollArea, Sense, TextureHandle,
    TextureOptions, Ui, Vec2, WidgetInfo, vec2,
};
use std::sync::OnceLock;
use std::sync::mpsc::{Receiver, channel};

/// Side of the pictures in the rows, points.
const SIDE: f32 = 34.0;

/// State of the panel.
#[derive(Default)]
pub struct PresetPanel {
    filter: String,
    /// The sheet of pictures, once it was decoded on a thread.
    sheet: Option<TextureHandle>,
    decoding: Option<Receiver<ColorImage>>,
}

/// A preset with what the list shows of it.
struct Entry {
    preset: &'static Preset,
    color: Color32,
    is_metal: bool,
    note: String,
    /// Column and row of its picture.
    cell: Option<[usize; 2]>,
}

fn entries() -> &'static [Entry] {
    static ENTRIES: OnceLock<Vec<Entry>> = OnceLock::new();
    ENTRIES.get_or_init(|| {
        let entry = |preset: &'static Preset| {
            let material = preset.parse().map(|(file, _)| file.material().clone()).unwrap_or_default();
            Entry {
                preset,
                color: display_color(known_color(&material)),
                is_metal: material.float(Property::metallic) > 0.5,
                note: material.notes.clone(),
                cell: pictures::cell(preset.file_stem),
            }
        };
        burnish_presets::presets().iter().map(entry).collect()
    })
}

/// The colour people know a material by: its glow, what it filters, how it scatters, or its surface.
fn known_color(material: &Material) -> [f64; 3] {
    if material.float(Property::emission) > 0.0 {
        return material.color(Property::emission_color);
    }
    if material.float(Property::translucency) > 0.5 {
        if material.switch(Property::scatter) {
            return material.color(Property::scatter_color);
        }
        return material.color(Property::absorption_color);
    }
    material.color(Property::base_color)
}

impl PresetPanel {
    /// Takes the sheet when it is decoded, which takes longer than a frame may.
    fn load_sheet(&mut self, ctx: &Context) {
        if self.sheet.is_some() {
            return;
        }
        let decoding = self.decoding.get_or_insert_with(|| {
            let (sender, receiver) = channel();
            let wake = ctx.clone();
            std::thread::spawn(move || {
                if let Ok(image) = image::load_from_memory(pictures::SHEET) {
                    let image = image.to_rgb8();
                    let size = [image.width() as usize, image.height() as usize];
                    // Nobody waits where the window has closed.
                    _ = sender.send(ColorImage::from_rgb(size, image.as_raw()));
                    wake.request_repaint();
                }
            });
            receiver
        });
        if let Ok(image) = decoding.try_recv() {
            self.sheet = Some(ctx.load_texture("preset pictures", image, TextureOptions::LINEAR));
        }
    }

    /// Shows the list; the preset that was clicked.
    pub fn show(&mut self, ui: &mut Ui, current_name: &str) -> Option<&'static Preset> {
        self.load_sheet(&ui.ctx().clone());
        let sheet = self.sheet.as_ref();
        search_field(ui, &mut self.filter, "Filter presets", "Filter by name or tag");
        ui.add_space(2.0);
        let mut clicked = None;
        let found = burnish_presets::search(&self.filter);
        ScrollArea::vertical().auto_shrink([false, false]).show(ui, |ui| {
            if found.is_empty() {
                ui.label(RichText::new("No preset has this in its name or tags.").weak());
            }
            let is_filtered = !self.filter.trim().is_empty();
            let mut groups: Vec<&str> = Vec::new();
            for preset in &found {
                if !groups.contains(&preset.group) {
                    groups.push(preset.group);
                }
            }
            for group in groups {
                let in_group =
                    || entries().iter().filter(|e| e.preset.group == group && found.iter().any(|p| std::ptr::eq(*p, e.preset)));
                let title = RichText::new(burnish_presets::group_title(group)).color(theme::now().weak);
                let mut list = |ui: &mut Ui| {
                    for entry in in_group() {
                        if row(ui, entry, sheet, entry.preset.name == current_name) {
                            clicked = Some(entry.preset);
                        }
                    }
                };
                if is_filtered {
                    ui.label(title);
                    list(ui);
                } else {
                    CollapsingHeader::new(title).id_salt(group).default_open(true).show_unindented(ui, list);
                }
            }
        });
        clicked
    }
}

/// The part of the sheet with a preset's picture.
fn part(sheet: &TextureHandle, entry: &Entry) -> Option<Rect> {
    let [column, row] = entry.cell?;
    let size = sheet.size_vec2();
    let corner = pictures::SIDE as f32 * vec2(column as f32, row as f32) / size;
    Some(Rect::from_min_size(corner.to_pos2(), Vec2::splat(pictures::SIDE as f32) / size))
}

fn row(ui: &mut Ui, entry: &Entry, sheet: Option<&TextureHandle>, is_current: bool) -> bool {
    let picture = sheet.and_then(|sheet| Some((sheet, part(sheet, entry)?)));
    let size = vec2(ui.available_width(), (SIDE + 2.0).max(ui.spacing().interact_size.y));
    let (rect, response) = ui.allocate_exact_size(size, Sense::click());
    let name = entry.preset.name;
    response.widget_info(|| WidgetInfo::selected(Role::Button, ui.is_enabled(), is_current, name));
    if ui.is_rect_visible(rect) {
        let visuals = ui.style().interact_selectable(&response, is_current);
        if is_current || response.hovered() || response.has_focus() {
            ui.painter().rect_filled(rect, 3, visuals.weak_bg_fill);
        }
        let place = Rect::from_center_size(rect.left_center() + vec2(2.0 + 0.5 * SIDE, 0.0), Vec2::splat(SIDE));
        match picture {
            Some((sheet, part)) => {
                let image = egui::Image::new((sheet.id(), place.size())).uv(part).corner_radius(CornerRadius::same(3));
                image.paint_at(ui, place);
            }
            None => {
                ui.painter().circle(place.center(), 6.5, entry.color, (1.0, theme::now().line));
                let sheen = if entry.is_metal { 170 } else { 60 };
                ui.painter().circle_filled(place.center() - vec2(2.0, 2.2), 1.7, Color32::from_white_alpha(sheen));
            }
        }
        let text_rect = rect.with_min_x(place.right() + 7.0);
        let color = if is_current { visuals.text_color() } else { theme::now().text };
        let mut inner =
            ui.new_child(egui::UiBuilder::new().max_rect(text_rect).layout(egui::Layout::left_to_right(egui::Align::Center)));
        // The row carries the name for readers; the label is its picture only.
        inner.add(Label::new(RichText::new(name).color(color)).truncate().selectable(false).sense(Sense::empty()));
    }
    response
        .on_hover_ui(|ui| {
            if let Some((sheet, part)) = picture {
                ui.add(egui::Image::new((sheet.id(), Vec2::splat(pictures::SIDE as f32))).uv(part));
            }
            ui.label(RichText::new(name).strong());
            if !entry.note.is_empty() {
                ui.label(&entry.note);
            }
            if !entry.preset.source.is_empty() {
                ui.label(RichText::new(format!("Source: {}", entry.preset.source)).small().weak());
            }
        })
        .clicked()
}
