//! The page with all built-in textures: which map of which one a property reads, and what it averages.

use crate::small_pictures::SmallPictures;
use crate::theme;
use crate::widgets::number_field::NumberField;
use crate::widgets::search_field::search_field;
use burnish_assets::{BuiltInTexture, MAX_CONTRAST, TEXTURES, TextureDef, TextureMap};
use burnish_material::{Kind, Material, Property, Value};
use egui::{
    ComboBox, CornerRadius, Direction, Image, Label, Layout, Rect, RichText, Role, ScrollArea, Sense, Stroke, StrokeKind, Ui,
    UiBuilder, WidgetInfo, vec2,
};

/// Side of a picture, points.
const SIDE: f32 = 92.0;

/// What is typed and chosen for one property.
#[derive(Clone, Debug, Default)]
pub struct TexturePage {
    property: Option<Property>,
    search: String,
    chosen: Option<BuiltInTexture>,
    map: Option<TextureMap>,
    /// Whether the map is to average the value of the property.
    keeps_value: bool,
    contrast: f64,
}

impl TexturePage {
    /// The page for a property, with the built-in texture that it reads now.
    pub fn new(material: &Material, property: Property) -> Self {
        let path = material.slot(property).texture.as_ref().map(|texture| texture.path.as_str());
        let chosen = path.and_then(BuiltInTexture::parse).and_then(Result::ok);
        Self {
            property: Some(property),
            search: String::new(),
            chosen,
            map: chosen.map(|texture| texture.map).or_else(|| maps_for(property).first().copied()),
            keeps_value: chosen.is_none_or(|texture| texture.mean.is_some()),
            contrast: chosen.map_or(1.0, |texture| f64::from(texture.contrast)),
        }
    }

    /// Shows the page; the path that the property is to read.
    pub fn show(&mut self, ui: &mut Ui, material: &Material, small: &mut SmallPictures) -> Option<String> {
        let property = self.property?;
        let maps = maps_for(property);
        let mut map = self.map.filter(|map| maps.contains(map)).or_else(|| maps.first().copied())?;
        search_field(ui, &mut self.search, "Search built-in textures", "wood, cloth, stone…");
        if maps.len() > 1 {
            ui.horizontal(|ui| {
                ui.label("Reads the map of");
                let combo = ComboBox::from_id_salt("map").selected_text(title(map)).show_ui(ui, |ui| {
                    for choice in maps {
                        ui.selectable_value(&mut map, *choice, title(*choice));
                    }
                });
                combo.response.accessible_name("Map of the texture");
            });
        }
        self.map = Some(map);
        ui.add_space(4.0);
        let words = self.search.to_lowercase();
        let holds = |def: &TextureDef| {
            let text = format!("{} {}", def.name, def.doc).to_lowercase();
            words.split_whitespace().all(|word| text.contains(word))
        };
        let found: Vec<BuiltInTexture> =
            TEXTURES.iter().filter(|def| holds(def)).filter_map(|def| BuiltInTexture::new(def, map)).collect();
        let chosen = self.chosen.map(|texture| texture.def.name);
        ScrollArea::vertical().max_height(300.0).auto_shrink([false, true]).show(ui, |ui| {
            if found.is_empty() {
                ui.label(RichText::new("No built-in texture of this name has such a map.").weak());
            }
            ui.horizontal_wrapped(|ui| {
                ui.spacing_mut().item_spacing = vec2(8.0, 8.0);
                for texture in found {
                    if card(ui, texture, chosen == Some(texture.def.name), small) {
                        self.chosen = Some(texture);
                        ui.ctx().request_repaint();
                    }
                }
            });
        });
        ui.separator();
        let texture = self.chosen.and_then(|texture| BuiltInTexture::new(texture.def, map));
        let Some(mut texture) = texture else {
            ui.label(RichText::new("Choose a texture. It tiles, and is made the same on every machine.").weak());
            return None;
        };
        ui.add(Label::new(texture.def.doc).wrap());
        if texture.has_settings() {
            let value = value_for(material, property);
            let text = format!("Averages the value of {}", property.def().label);
            ui.checkbox(&mut self.keeps_value, text).on_hover_text("Else it has the mean of its own.");
            texture.mean = Some(value).filter(|_| self.keeps_value);
            ui.horizontal(|ui| {
                ui.label("Contrast");
                if let Some(x) = NumberField::plain("Contrast of the texture", 62.0, 0.01).show(ui, self.contrast) {
                    self.contrast = x.clamp(0.0, f64::from(MAX_CONTRAST));
                }
                ui.label(RichText::new("0: even; 1: its own; 4: the most").small().weak());
            });
            texture.contrast = self.contrast as f32;
        }
        ui.add_space(4.0);
        ui.button(format!("Use {}", texture.def.name)).clicked().then(|| texture.path())
    }
}

/// The maps that a property can read, the one made for it first.
fn maps_for(property: Property) -> &'static [TextureMap] {
    const NUMBERS: &[TextureMap] =
        &[TextureMap::Roughness, TextureMap::Height, TextureMap::Metallic, TextureMap::AnisotropyRotation];
    match property.def().default.kind() {
        Kind::Color => &[TextureMap::BaseColor],
        Kind::Normal => &[TextureMap::Normal],
        Kind::Bool => &[],
        Kind::Float => match property {
            Property::height => &[TextureMap::Height],
            Property::metallic => &[TextureMap::Metallic, TextureMap::Roughness, TextureMap::Height],
            Property::anisotropy_rotation => &[TextureMap::AnisotropyRotation],
            _ => NUMBERS,
        },
    }
}

fn title(map: TextureMap) -> String {
    map.word().replace('_', " ")
}

/// The value of a property as the mean of a map, 0 to 1.
fn value_for(material: &Material, property: Property) -> [f32; 3] {
    let numbers = match material.value(property) {
        Value::Color(color) => color,
        Value::Float(x) => [x; 3],
        _ => [0.5; 3],
    };
    numbers.map(|x| x.clamp(0.0, 1.0) as f32)
}

/// A picture with its name; whether it was clicked.
fn card(ui: &mut Ui, texture: BuiltInTexture, is_chosen: bool, small: &mut SmallPictures) -> bool {
    let name = texture.def.name;
    let (rect, response) = ui.allocate_exact_size(vec2(SIDE, SIDE + 18.0), Sense::click());
    response.widget_info(|| WidgetInfo::selected(Role::Button, true, is_chosen, name));
    // Those out of sight are not made before they are scrolled to.
    if ui.is_rect_visible(rect) {
        let palette = theme::now();
        let picture = Rect::from_min_size(rect.min, vec2(SIDE, SIDE));
        match small.built_in_texture(ui.ctx(), texture) {
            Some(id) => Image::new((id, picture.size())).corner_radius(4).paint_at(ui, picture),
            None => drop(ui.painter().rect_filled(picture, CornerRadius::same(4), palette.line)),
        }
        if is_chosen || response.hovered() || response.has_focus() {
            let color = if is_chosen { palette.accent } else { palette.weak };
            ui.painter().rect_stroke(picture, 4, Stroke::new(2.0, color), StrokeKind::Inside);
        }
        let place = Rect::from_min_max(picture.left_bottom(), rect.max);
        let mut line = ui.new_child(UiBuilder::new().max_rect(place).layout(Layout::centered_and_justified(Direction::TopDown)));
        line.add(Label::new(RichText::new(name).small()).truncate().selectable(false));
    }
    response.on_hover_text(texture.def.doc).clicked()
}
