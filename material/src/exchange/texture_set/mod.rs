//! Texture sets as Substance programs name them: one image for each channel, `NAME_Usage.png`, with the native copy beside them ([`copy`]).
//!
//! A set says nothing about how images lie, nor about numbers beside them: what a reference changes about its image is computed into a new
//! one, which covers uv from 0 to 1, and the image itself goes into a folder of originals. Normals are +Y. Values for the whole material
//! stay in the native copy.

pub mod copy;

use super::loss::Row;
use super::model::{Context, ShadingModel};
use super::models::{maps, specular_glossiness};
use super::plan::Job;
use super::texture::Image;
use crate::material::Material;
use crate::properties::Property;
use crate::slot::{Channel, ColorSpace, TextureRef};
use crate::value::{Kind, Value, Vary};

/// Endings of images that are copied as they are.
const COPIED: [&str; 7] = ["png", "jpg", "jpeg", "tga", "tif", "tiff", "exr"];
/// End of the name of the folder of originals, after that of the set.
const ORIGINALS: &str = "_originals";

/// Which channels a set has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Flavour {
    /// Base colour, metallic, roughness and all other properties by their usage strings.
    #[default]
    MetalRoughness,
    /// Diffuse, specular and glossiness in their place.
    SpecularGlossiness,
}

impl Flavour {
    /// That of a shading model; the usual one where it is no other's.
    pub fn of(model: &ShadingModel) -> Self {
        if model.name == specular_glossiness::MODEL.name { Self::SpecularGlossiness } else { Self::MetalRoughness }
    }
}

/// How a set is written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Options {
    /// Its channels.
    pub flavour: Flavour,
    /// Whether values without an image that are not at their default become images of one texel.
    pub has_uniform: bool,
}

/// A file that is copied byte for byte.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Copy {
    /// Path as the material has it.
    pub path: String,
    /// Its name in the folder of the set.
    pub file: String,
}

/// An image that is computed.
#[derive(Clone, Debug)]
pub struct Computed {
    /// The model that [`Job::texel`] needs.
    pub model: &'static ShadingModel,
    /// The image.
    pub job: Job,
}

/// All files of a set.
#[derive(Clone, Debug)]
pub struct TextureSet {
    /// Name of the native copy, which holds what images do not.
    pub native_file: String,
    /// Images that are taken as they are.
    pub copies: Vec<Copy>,
    /// Images that others are computed from; they lie in a folder of their own, for the way back.
    pub originals: Vec<Copy>,
    /// Images that have to be computed.
    pub images: Vec<Computed>,
    /// What the images do not say, in sentences for the user.
    pub notes: Vec<String>,
}

/// The plan of a texture set. `name` is what its files begin with, which has to be fit for that; `last_name` gives the name that an image has without its folder, no two the same.
pub fn plan(material: &Material, name: &str, last_name: &dyn Fn(&str) -> String, options: Options) -> TextureSet {
    let native_file = format!("{name}.{}", copy::ENDING);
    let mut set = TextureSet { native_file, copies: Vec::new(), originals: Vec::new(), images: Vec::new(), notes: Vec::new() };
    let is_held = |property: Property| is_held(options.flavour, property);
    if options.flavour == Flavour::SpecularGlossiness {
        set.add(&specular_glossiness::MODEL, material, name, options.has_uniform, |_| false);
    }
    set.add(&maps::MODEL, material, name, options.has_uniform, is_held);
    for texture in material.slots().filter_map(|(_, slot)| slot.texture.as_ref()) {
        let is_known = set.copies.iter().chain(&set.originals).any(|copy| copy.path == texture.path);
        if !is_known && !texture.path.is_empty() && !is_builtin(&texture.path) {
            let file = format!("{name}{ORIGINALS}/{}", last_name(&texture.path));
            set.originals.push(Copy { path: texture.path.clone(), file });
        }
    }
    for (property, _) in material.slots().filter(|(property, _)| property.def().vary == Vary::Uniform) {
        if material.value(property) != property.def().default {
            set.notes.push(format!("{}: one value for the whole material, in {} alone", property.def().name, set.native_file));
        }
    }
    set
}

/// What becomes of each property for whoever sees the images alone.
pub fn rows(material: &Material, flavour: Flavour) -> Vec<Row> {
    let context = Context::of(material);
    let mut rows = maps::MODEL.translate(material, &context).rows;
    if flavour == Flavour::SpecularGlossiness {
        let first = specular_glossiness::MODEL.translate(material, &context).rows;
        for (row, first) in rows.iter_mut().zip(first).filter(|(row, _)| is_held(flavour, row.property)) {
            *row = first;
        }
    }
    rows
}

/// Whether the model that stands for metal and roughness holds a property. It is then not written a second time.
fn is_held(flavour: Flavour, property: Property) -> bool {
    let holds = |cell: &super::loss::Cell| cell.property == property && !cell.target.is_empty();
    flavour == Flavour::SpecularGlossiness && specular_glossiness::MODEL.cells.iter().any(holds)
}

fn is_builtin(path: &str) -> bool {
    path.starts_with("builtin:")
}

impl TextureSet {
    /// The material with its images where the set has them.
    pub fn placed(&self, material: &Material) -> Material {
        let mut placed = material.clone();
        for (property, slot) in material.slots() {
            let file = |texture: &TextureRef| self.copies.iter().chain(&self.originals).find(|copy| copy.path == texture.path);
            let Some(copy) = slot.texture.as_ref().and_then(file) else { continue };
            if let Some(texture) = &mut placed.slot_mut(property).texture {
                texture.path.clone_from(&copy.file);
            }
        }
        placed
    }

    fn add(
        &mut self,
        model: &'static ShadingModel,
        material: &Material,
        name: &str,
        has_uniform: bool,
        is_held: impl Fn(Property) -> bool,
    ) {
        let translation = model.translate(material, &Context::of(material));
        for (place, (def, field)) in model.fields.iter().zip(&translation.fields.0).enumerate() {
            if !def.takes_image || def.from.iter().any(|property| is_held(*property)) {
                continue;
            }
            let kind = def.default.kind();
            let stem = format!("{name}_{}", usage(def.name));
            let textured: Vec<Property> = def.from.iter().copied().filter(|p| material.is_textured(*p)).collect();
            let is_computed = translation.images.iter().any(|image| image.field == place);
            let from = match &field.texture {
                Some(texture) => match copied_ending(texture, kind) {
                    Some(ending) => {
                        let file = format!("{stem}.{ending}");
                        self.copies.push(Copy { path: texture.path.clone(), file });
                        continue;
                    }
                    None => {
                        self.tell_of_range(def.name, texture, kind);
                        textured
                    }
                },
                None if is_computed => textured,
                None if has_uniform && field.is_authored => {
                    if field.value.numbers().iter().any(|x| !(0.0..=1.0).contains(x)) && !matches!(field.value, Value::Normal(_))
                    {
                        self.notes.push(format!(
                            "{}: images hold 0 to 1; {:?} is cut off there",
                            def.name,
                            field.value.numbers()
                        ));
                    }
                    Vec::new()
                }
                None => continue,
            };
            let is_in_place = from.iter().all(|p| material.slot(*p).texture.as_ref().is_none_or(covers_the_square));
            let image = Image { field: place, from };
            if let Some(job) = Job::of_parameter(model, &image, format!("{stem}.png"), 1.0) {
                self.images.push(Computed { model, job: Job { is_in_place, ..job } });
            }
        }
    }

    fn tell_of_range(&mut self, name: &str, texture: &TextureRef, kind: Kind) {
        let ends = (0..3).flat_map(|k| [texture.bias[k], texture.bias[k] + texture.scale[k]]);
        if kind != Kind::Normal && ends.into_iter().any(|x| !(-1e-9..=1.0 + 1e-9).contains(&x)) {
            self.notes.push(format!("{name}: scale and bias of `{}` lead out of 0 to 1, where images end", texture.path));
        }
    }
}

/// The ending of an image that means the same without its reference.
fn copied_ending(texture: &TextureRef, kind: Kind) -> Option<String> {
    let plain = TextureRef { wrap: texture.wrap, color_space: texture.color_space, ..TextureRef::new(texture.path.clone()) };
    let is_usual_space = match kind {
        Kind::Color => texture.color_space != ColorSpace::Linear,
        _ => texture.color_space != ColorSpace::Srgb,
    };
    if *texture != plain || !is_usual_space || texture.channel != Channel::Rgb || is_builtin(&texture.path) {
        return None;
    }
    let ending = texture.path.rsplit_once('.')?.1.to_ascii_lowercase();
    COPIED.contains(&ending.as_str()).then_some(ending)
}

fn covers_the_square(texture: &TextureRef) -> bool {
    texture.uv_scale == [1.0; 2] && texture.uv_offset == [0.0; 2] && texture.uv_rotation == 0.0
}

/// A usage string as file names have it: its first letter in capitals.
fn usage(name: &str) -> String {
    let mut letters = name.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}
