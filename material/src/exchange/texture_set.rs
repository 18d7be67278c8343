//! Texture sets as Substance programs name them: one image for each channel, `NAME_Usage.png`, with the native file beside them.
//!
//! A set says nothing about how images lie, nor about numbers beside them: what a reference changes about its image is computed into a new
//! one, which covers uv from 0 to 1. Normals are +Y. Values for the whole material stay in the native file.

use super::model::{Context, ShadingModel};
use super::models::{asm, specular_glossiness};
use super::plan::Job;
use super::texture::Image;
use crate::material::Material;
use crate::properties::Property;
use crate::slot::{Channel, ColorSpace, TextureRef};
use crate::value::{Kind, Value, Vary};

/// Endings of images that are copied as they are.
const COPIED: [&str; 7] = ["png", "jpg", "jpeg", "tga", "tif", "tiff", "exr"];
/// Longest name of a set, in characters.
const MAX_NAME: usize = 120;

/// Which channels a set has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Flavour {
    /// Base colour, metallic, roughness and all other properties by their usage strings.
    #[default]
    MetalRoughness,
    /// Diffuse, specular and glossiness in their place.
    SpecularGlossiness,
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
    /// Name of the native file, which holds what images do not.
    pub native_file: String,
    /// Images that are taken as they are.
    pub copies: Vec<Copy>,
    /// Images that have to be computed.
    pub images: Vec<Computed>,
    /// What the images do not say, in sentences for the user.
    pub notes: Vec<String>,
}

/// The plan of a texture set.
pub fn plan(material: &Material, options: Options) -> TextureSet {
    let name = file_stem(&material.name);
    let native_file = format!("{name}.asm.ron");
    let mut set = TextureSet { native_file, copies: Vec::new(), images: Vec::new(), notes: Vec::new() };
    let first = match options.flavour {
        Flavour::MetalRoughness => None,
        Flavour::SpecularGlossiness => Some(&specular_glossiness::MODEL),
    };
    // What the first model holds is not written a second time as a property.
    let is_held = |property: Property| {
        first.is_some_and(|model| model.cells.iter().any(|cell| cell.property == property && !cell.target.is_empty()))
    };
    if let Some(model) = first {
        set.add(model, material, &name, options.has_uniform, |_| false);
    }
    set.add(&asm::MODEL, material, &name, options.has_uniform, is_held);
    for (property, _) in material.slots().filter(|(property, _)| property.def().vary == Vary::Uniform) {
        if material.value(property) != property.def().default {
            set.notes.push(format!("{}: one value for the whole material, in {} alone", property.def().name, set.native_file));
        }
    }
    set
}

impl TextureSet {
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
    if *texture != plain || !is_usual_space || texture.channel != Channel::Rgb || texture.path.starts_with("builtin:") {
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

/// A name that every file system takes.
fn file_stem(name: &str) -> String {
    let plain = |c: char| if c.is_alphanumeric() || c == '-' || c == '_' { c } else { '_' };
    let stem: String = name.trim().chars().take(MAX_NAME).map(plain).collect();
    if stem.is_empty() { "Material".to_owned() } else { stem }
}
