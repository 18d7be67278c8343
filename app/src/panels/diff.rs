//! Two materials beside each other: at the left the entries that differ, each to be taken over, at the right both pictures and their difference.

use super::source_picker::{self, Choices, Picked};
use crate::cli::one_line;
use crate::sources::{Source, Sourced};
use crate::theme;
use crate::widgets::color_edit::display_color;
use crate::widgets::row_notes::value_text;
use burnish_material::diff::{Change, can_take};
use burnish_material::{Property, Value};
use egui::{
    Align, Button, Image, Label, Layout, ProgressBar, Rect, RichText, ScrollArea, Sense, StrokeKind, TextureHandle, Ui,
    UiBuilder, pos2, vec2,
};

/// Points across below which the pictures stand under the values.
const WIDE: f32 = 560.0;

/// What the panel asks of the application.
#[derive(Clone, Debug, PartialEq)]
pub enum DiffAction {
    /// Compare another one: the second of both where it says so.
    Choose(bool, Source),
    /// Ask for a file to compare: the second of both where it says so.
    ChooseFile(bool),
    /// Exchange both.
    Exchange,
    /// Take these entries over from the other one: into the second of both where it says so.
    Take(bool, Vec<String>),
    /// Open the merge of both.
    Merge,
    /// Make both files one that has both names.
    Unite,
    /// End drawing the pictures.
    EndPictures,
    /// Draw them after all.
    DrawPictures,
}

/// Both pictures and their difference.
pub struct Drawn {
    /// A, B, and the difference.
    pub textures: [TextureHandle; 3],
    /// Mean of FLIP.
    pub mean: f64,
}

/// How far the pictures are.
pub enum Pictures<'a> {
    /// They are there.
    Drawn(&'a Drawn),
    /// They are being drawn: the share that is done.
    Drawing(f32),
    /// They wait for the materials to rest.
    Waiting,
    /// They are not drawn, for this reason.
    None(&'a str),
}

/// What is shown.
pub struct DiffView<'a> {
    /// What is compared.
    pub sources: [&'a Source; 2],
    /// What could be.
    pub choices: &'a Choices,
    /// What both hold, or why that is not known.
    pub sides: [Result<&'a Sourced, &'a str>; 2],
    /// What differs.
    pub changes: &'a [Change],
    /// Whether entries can be taken over into each.
    pub can_take: [bool; 2],
    /// Whether both are files that can become one.
    pub can_unite: bool,
    /// The pictures.
    pub pictures: Pictures<'a>,
}

/// Shows the panel.
pub fn show(ui: &mut Ui, view: &DiffView) -> Option<DiffAction> {
    let mut action = head(ui, view);
    for problem in view.sides.iter().filter_map(|side| side.err()) {
        ui.add(Label::new(RichText::new(problem).color(theme::now().weak)).wrap());
    }
    let room = ui.available_rect_before_wrap();
    let (values, pictures) = if room.width() >= WIDE * theme::text_scale(ui) {
        let at = room.left() + (0.56 * room.width()).max(WIDE - 200.0);
        (Rect::from_min_max(room.min, pos2(at - 6.0, room.bottom())), Rect::from_min_max(pos2(at, room.top()), room.max))
    } else {
        let at = room.bottom() - (0.42 * room.height()).min(room.width() / 2.4);
        (Rect::from_min_max(room.min, pos2(room.right(), at - 4.0)), Rect::from_min_max(pos2(room.left(), at), room.max))
    };
    let layout = Layout::top_down(Align::Min);
    ui.scope_builder(UiBuilder::new().max_rect(values).layout(layout), |ui| {
        action = table(ui, view).or(action.take());
    });
    ui.scope_builder(UiBuilder::new().max_rect(pictures).layout(layout), |ui| {
        action = show_pictures(ui, view).or(action.take());
    });
    action
}

/// What is compared, and what can be done with all of it.
fn head(ui: &mut Ui, view: &DiffView) -> Option<DiffAction> {
    let mut action = None;
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        let width = ((ui.available_width() - 60.0) / 2.0).clamp(90.0, 220.0);
        for (number, name) in ["Material A", "Material B"].into_iter().enumerate() {
            if number == 1 && ui.button("⇄").accessible_name("Exchange A and B").on_hover_text("Exchange A and B").clicked() {
                action = Some(DiffAction::Exchange);
            }
            match source_picker::show(ui, name, width, Some(view.sources[number]), view.choices, None) {
                Some(Picked::Source(Some(source))) => action = Some(DiffAction::Choose(number == 1, source)),
                Some(Picked::ChooseFile) => action = Some(DiffAction::ChooseFile(number == 1)),
                Some(Picked::Source(None)) | None => {}
            }
        }
        let keys: Vec<String> =
            view.changes.iter().filter(|change| is_takeable(view, change)).map(|change| change.key.clone()).collect();
        for (is_b, name, tip) in [
            (false, "All of B → A", "Take every entry over into A, as one step that undo takes back"),
            (true, "All of A → B", "Take every entry over into B, as one step that undo takes back"),
        ] {
            let can = view.can_take[usize::from(is_b)] && !keys.is_empty();
            if ui.add_enabled(can, Button::new(name).small()).on_hover_text(tip).clicked() {
                action = Some(DiffAction::Take(is_b, keys.clone()));
            }
        }
        if ui.add(Button::new("Merge…").small()).on_hover_text("Decide entry by entry, with what both were made from").clicked()
        {
            action = Some(DiffAction::Merge);
        }
        if view.can_unite {
            let tip = "A keeps its values and gets B’s names as other names; the file of B goes. One step that undo takes back.";
            if ui.add(Button::new("One file, both names").small()).on_hover_text(tip).clicked() {
                action = Some(DiffAction::Unite);
            }
        }
    });
    action
}

/// Whether one side's entry can be given to the other: unknown keys and sources of values belong to the file alone.
fn is_takeable(view: &DiffView, change: &Change) -> bool {
    matches!(view.sides, [Ok(a), Ok(b)] if can_take(&a.material, &b.material, &change.key))
}

fn table(ui: &mut Ui, view: &DiffView) -> Option<DiffAction> {
    let [Ok(a), Ok(b)] = view.sides else { return None };
    let mut action = None;
    let count = view.changes.len();
    let text = match count {
        0 => "No entry differs.".to_owned(),
        1 => "1 entry differs; all others are equal.".to_owned(),
        n => format!("{n} entries differ; all others are equal."),
    };
    ui.label(RichText::new(text).small().color(theme::now().weak));
    let height = ui.spacing().interact_size.y;
    let (button, gap) = (24.0, ui.spacing().item_spacing.x);
    ScrollArea::vertical().id_salt("differences").auto_shrink([false, false]).show_rows(ui, height, count, |ui, rows| {
        let all = ui.available_width() - 2.0 * button - 4.0 * gap;
        let (name, cell) = (0.36 * all, 0.32 * all);
        for change in &view.changes[rows] {
            ui.horizontal(|ui| {
                let label = change_label(change);
                fixed(ui, vec2(name, height), |ui| {
                    ui.add(Label::new(RichText::new(&label).color(theme::now().text)).truncate()).on_hover_text(&change.key);
                });
                fixed(ui, vec2(cell, height), |ui| value_cell(ui, a, change, &change.a));
                for (is_b, arrow, what) in [(false, "◀", "Take B’s"), (true, "▶", "Take A’s")] {
                    let can = view.can_take[usize::from(is_b)] && is_takeable(view, change);
                    let arrow = ui.add_enabled(can, Button::new(arrow).min_size(vec2(button, height)));
                    let name = format!("{what} {}", label.to_lowercase());
                    let into = if is_b { "B" } else { "A" };
                    let tip = format!("{name} over into {into}; undo takes it back");
                    let no = format!("{into} is no open document or file, or only its file can hold this");
                    if arrow.accessible_name(name).on_hover_text(tip).on_disabled_hover_text(no).clicked() {
                        action = Some(DiffAction::Take(is_b, vec![change.key.clone()]));
                    }
                }
                fixed(ui, vec2(cell, height), |ui| value_cell(ui, b, change, &change.b));
            });
        }
    });
    action
}

/// What an entry is called.
pub fn change_label(change: &Change) -> String {
    entry_label(&change.key, change.property)
}

/// The same of a key.
pub fn entry_label(key: &str, property: Option<Property>) -> String {
    match property.map(|property| property.def()) {
        Some(def) if key == def.name => def.label.to_owned(),
        Some(def) => format!("{} map", def.label),
        None => match key {
            "name" => "Name".to_owned(),
            "aliases" => "Other names".to_owned(),
            "tags" => "Tags".to_owned(),
            "notes" => "Notes".to_owned(),
            "unit_mm" => "Unit of lengths".to_owned(),
            "provenance.source" => "Source".to_owned(),
            "provenance.reference" => "Reference".to_owned(),
            "provenance.method" => "Method".to_owned(),
            "provenance.licence" => "Licence".to_owned(),
            key => key.to_owned(),
        },
    }
}

fn fixed(ui: &mut Ui, size: egui::Vec2, content: impl FnOnce(&mut Ui)) {
    ui.allocate_ui_with_layout(size, Layout::left_to_right(Align::Center), |ui| {
        ui.set_min_size(size);
        ui.set_max_width(size.x);
        content(ui);
    });
}

/// A text or a list of texts of a file without its quotes, in one line; anything else as it is written.
pub fn plain(text: &str) -> String {
    let words = ron::from_str::<String>(text).or_else(|_| ron::from_str::<Vec<String>>(text).map(|words| words.join(", ")));
    one_line(&words.unwrap_or_else(|_| text.to_owned()))
}

/// One side's value: colours with a swatch, defaults said to be such, texts in one line.
fn value_cell(ui: &mut Ui, side: &Sourced, change: &Change, written: &Option<String>) {
    let def = change.property.map(|property| property.def()).filter(|def| def.name == change.key);
    let (text, is_default) = match (def, written) {
        (Some(def), written) => (value_text(side.material.value(def.id)), written.is_none()),
        (None, Some(text)) => (plain(text), false),
        (None, None) => ("nothing".to_owned(), true),
    };
    if let Some(Value::Color(color)) = def.map(|def| side.material.value(def.id)) {
        let (rect, _) = ui.allocate_exact_size(vec2(14.0, 14.0), Sense::hover());
        ui.painter().rect(rect, 2, display_color(color), (1.0, theme::now().line), StrokeKind::Inside);
    }
    let shown = if is_default && def.is_some() { format!("{text} (default)") } else { text.clone() };
    let color = if is_default { theme::now().weak } else { theme::now().strong };
    let full = written.as_ref().map_or_else(|| shown.clone(), |written| written.clone());
    ui.add(Label::new(RichText::new(shown).color(color)).truncate()).on_hover_text(full);
}

fn show_pictures(ui: &mut Ui, view: &DiffView) -> Option<DiffAction> {
    let mut action = None;
    match &view.pictures {
        Pictures::Drawn(drawn) => three(ui, view, drawn),
        Pictures::Drawing(share) => {
            ui.horizontal(|ui| {
                let width = (ui.available_width() - 60.0).clamp(40.0, 220.0);
                ui.add(ProgressBar::new(*share).desired_width(width).text("drawing both"));
                if ui.small_button("End").accessible_name("End drawing both").clicked() {
                    action = Some(DiffAction::EndPictures);
                }
            });
        }
        Pictures::Waiting => {
            ui.label(RichText::new("Waiting for the material to rest.").weak());
        }
        Pictures::None(reason) => {
            ui.add(Label::new(RichText::new(*reason).weak()).wrap());
            if ui.small_button("Draw both").clicked() {
                action = Some(DiffAction::DrawPictures);
            }
        }
    }
    action
}

/// The three pictures as large as they can be, side by side or below each other, with what they are.
fn three(ui: &mut Ui, view: &DiffView, drawn: &Drawn) {
    let caption = ui.text_style_height(&egui::TextStyle::Small) + 4.0;
    let room = ui.available_rect_before_wrap();
    let side = |columns: f32, rows: f32| ((room.width() - 4.0 * columns) / columns).min(room.height() / rows - caption - 4.0);
    let (columns, side) = [1, 2, 3]
        .map(|columns| (columns, side(columns as f32, (3.0 / columns as f32).ceil())))
        .into_iter()
        .fold((1, 0.0), |best, one| if one.1 > best.1 { one } else { best });
    if side < 16.0 {
        return;
    }
    let title = |number: usize| view.sides[number].map_or_else(|_| String::new(), |side| side.title.clone());
    let percent = format!("Difference, FLIP {:.3}", drawn.mean);
    let captions = [format!("A  {}", title(0)), format!("B  {}", title(1)), percent];
    for (number, (texture, text)) in drawn.textures.iter().zip(captions).enumerate() {
        let at = room.min + vec2((number % columns) as f32 * (side + 4.0), (number / columns) as f32 * (side + caption + 4.0));
        let place = Rect::from_min_size(at, vec2(side, side));
        let size = texture.size_vec2();
        let shown = Rect::from_center_size(place.center(), size * (side / size.x.max(size.y)));
        let name = if number == 2 { format!("Difference of both: FLIP {:.3}", drawn.mean) } else { format!("Picture of {text}") };
        ui.put(shown, Image::new((texture.id(), shown.size())).alt_text(name));
        let line = Rect::from_min_size(place.left_bottom(), vec2(side, caption));
        ui.put(line, Label::new(RichText::new(&text).small().color(theme::now().text)).truncate()).on_hover_text(
            if number == 2 { "0 dark blue: nobody sees it; 1 yellow: as different as black and white" } else { text.as_str() },
        );
    }
}
