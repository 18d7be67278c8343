//! The way out.

use std::fmt::Write;

use super::{NATIVE, context, read};
use crate::exchange::field::FieldDef;
use crate::exchange::loss::Row;
use crate::exchange::models::filament::{Filament, MODEL};
use crate::exchange::native;
use crate::exchange::plan::{Job, largest};
use crate::material::Material;
use crate::properties::Inputs;
use crate::slot::{Channel, TextureRef};
use crate::value::{Kind, Value};

/// A sampler that the application binds to an image.
#[derive(Clone, Debug, PartialEq)]
pub struct Bound {
    /// Name of the parameter: `baseColorMap`.
    pub parameter: String,
    /// Path of the image: that of the material, or of a computed one.
    pub path: String,
    /// Whether the image has to be uploaded in an sRGB format.
    pub is_srgb: bool,
}

/// A definition.
#[derive(Clone, Debug)]
pub struct Written {
    /// Its text.
    pub text: String,
    /// Its images.
    pub bound: Vec<Bound>,
    /// Images that have to be computed, for the model [`MODEL`].
    pub jobs: Vec<Job>,
    /// What the translation costs.
    pub rows: Vec<Row>,
}

/// Where the images of a definition lie.
pub struct WriteOptions<'a> {
    /// The path beside the definition of an image whose path a material has.
    pub path: &'a dyn Fn(&str) -> String,
    /// What stands before the names of computed images.
    pub prefix: &'a str,
    /// Whether the native copy stands before the definition, as a comment.
    pub has_native_copy: bool,
}

impl Default for WriteOptions<'_> {
    fn default() -> Self {
        Self { path: &str::to_owned, prefix: "", has_native_copy: true }
    }
}

/// Parameters that only a refracting material has.
const REFRACTION: [&str; 4] = ["ior", "transmission", "absorption", "thickness"];
/// Parameters that have to be set before the shading is prepared.
const NORMALS: [&str; 2] = ["normal", "clearCoatNormal"];

/// Makes a definition of a material.
pub fn write(material: &Material, options: &WriteOptions) -> Written {
    let (inputs, translation) = (material.inputs(), MODEL.translate(material, &context(material)));
    let said = |name: &str| translation.fields.get(Filament::FIELDS, name).is_some_and(|field| field.is_authored);
    let computed = |place: usize| translation.images.iter().find(|image| image.field == place);
    let is_refracting = said("transmission")
        || Filament::FIELDS.iter().enumerate().any(|(place, def)| def.name == "transmission" && computed(place).is_some());
    // A coat of which nothing but these is said is there.
    let has_coat_parts = said("clearCoatRoughness") || said("clearCoatNormal");
    let (mut bound, mut jobs, mut early, mut late) = (Vec::new(), Vec::new(), String::new(), String::new());
    for (place, (def, field)) in Filament::FIELDS.iter().zip(&translation.fields.0).enumerate() {
        let (name, _) = split(def.name);
        let own_image = computed(place).and_then(|image| {
            let file = format!("{}{}.png", options.prefix, parameter(def.name));
            let value_of = |inputs: &Inputs<f64>| (MODEL.translate)(inputs, &context(material)).get(place).copied();
            let factor = largest(image, &inputs, value_of).max(1.0);
            Job::of_parameter(&MODEL, image, file, factor).map(|job| (job, factor))
        });
        let is_needed = field.is_authored || own_image.is_some() || (def.name == "clearCoat" && has_coat_parts);
        if !is_needed || (REFRACTION.contains(&name) && name != "ior" && !is_refracting) {
            continue;
        }
        let texture =
            own_image.as_ref().map(|(job, factor)| TextureRef { scale: [*factor; 3], ..TextureRef::new(job.file.clone()) });
        jobs.extend(own_image.map(|(job, _)| job));
        let into = if NORMALS.contains(&name) { &mut early } else { &mut late };
        let right = match texture.as_ref().or(field.texture.as_ref()) {
            Some(texture) => {
                let is_computed = jobs.iter().any(|job: &Job| job.file == texture.path);
                bound.push(Bound {
                    parameter: parameter(def.name),
                    path: if is_computed { texture.path.clone() } else { (options.path)(&texture.path) },
                    is_srgb: def.default.kind() == Kind::Color,
                });
                sampled(def, texture)
            }
            None => literal(field.value),
        };
        // Writing to a String cannot fail.
        _ = writeln!(into, "        material.{} = {right};", def.name);
    }
    let has_alpha = said("baseColor.a") || bound.iter().any(|bound| bound.parameter == parameter("baseColor.a"));
    if has_alpha {
        late += "        material.baseColor.rgb *= material.baseColor.a;\n";
    }
    let head = head(material, &bound, has_alpha, is_refracting);
    let body = format!(
        "{head}\nfragment {{\n    void material(inout MaterialInputs material) {{\n{early}        prepareMaterial(material);\n{late}    }}\n}}\n"
    );
    let record = read::assignments(&body).fields;
    let copy = || format!("{NATIVE}{}\n", native::write(&moved(material, options), Some((Filament::FIELDS, &record))));
    let copy = if options.has_native_copy { copy() } else { String::new() };
    let images = bound.iter().map(|Bound { parameter, path, is_srgb }| {
        format!("// {parameter}: {path:?}{}\n", if *is_srgb { ", an sRGB format" } else { "" })
    });
    let images: String = images.collect();
    Written { text: format!("{copy}{images}{body}"), bound, jobs, rows: translation.rows }
}

/// The material with its images where they lie beside the definition. Textures that come with the program are the same everywhere.
fn moved(material: &Material, options: &WriteOptions) -> Material {
    let mut moved = material.clone();
    for (property, slot) in material.slots() {
        let is_file = |texture: &&TextureRef| !texture.path.starts_with("builtin:");
        let path = slot.texture.as_ref().filter(is_file).map(|texture| (options.path)(&texture.path));
        if let (Some(path), Some(texture)) = (path, &mut moved.slot_mut(property).texture) {
            texture.path = path;
        }
    }
    moved
}

fn head(material: &Material, bound: &[Bound], has_alpha: bool, is_refracting: bool) -> String {
    let name: String = material.name.chars().map(|c| if c.is_alphanumeric() || c == ' ' || c == '-' { c } else { '_' }).collect();
    let mut lines = vec![format!("name : \"{name}\""), "shadingModel : lit".to_owned()];
    if has_alpha {
        lines.push("blending : fade".to_owned());
    }
    if is_refracting {
        lines.extend(["refractionMode : cubemap", "refractionType : solid"].map(str::to_owned));
    }
    if !bound.is_empty() {
        // Images lie on the surface as they do in glTF: v grows downwards.
        lines.extend(["flipUV : false", "requires : [ uv0 ]"].map(str::to_owned));
        let samplers = bound.iter().map(|bound| format!("        {{ type : sampler2d, name : {} }}", bound.parameter));
        lines.push(format!("parameters : [\n{}\n    ]", samplers.collect::<Vec<_>>().join(",\n")));
    }
    format!("material {{\n    {}\n}}\n", lines.join(",\n    "))
}

/// The parameter without the components behind it, and these.
pub(super) fn split(name: &str) -> (&str, &str) {
    name.split_once('.').unwrap_or((name, ""))
}

fn parameter(name: &str) -> String {
    let (name, part) = split(name);
    if part == "a" { "opacityMap".to_owned() } else { format!("{name}Map") }
}

/// A number as a shader has it.
fn number(x: f64) -> String {
    let x = if x.is_finite() { x.clamp(f64::from(f32::MIN), f64::from(f32::MAX)) } else { 0.0 };
    format!("{x:?}")
}

fn literal(value: Value) -> String {
    match value {
        Value::Bool(on) => on.to_string(),
        Value::Float(x) => number(x),
        Value::Color(v) | Value::Normal(v) => format!("vec3({})", v.map(number).join(", ")),
    }
}

fn sampled(def: &FieldDef, texture: &TextureRef) -> String {
    let channel = match (def.default.kind(), texture.channel) {
        (Kind::Color | Kind::Normal, Channel::Rgb) => "rgb",
        (_, Channel::Rgb | Channel::R) => "r",
        (_, Channel::G) => "g",
        (_, Channel::B) => "b",
        (_, Channel::A) => "a",
    };
    let image = format!("texture(materialParams_{}, {}).{channel}", parameter(def.name), coordinates(texture));
    match def.default.kind() {
        Kind::Normal => {
            let green = if texture.is_inverted { -1.0 } else { 1.0 };
            format!("({image} * 2.0 - 1.0) * vec3(1.0, {}, 1.0)", number(green))
        }
        Kind::Color => {
            let image = if channel == "rgb" { image } else { format!("vec3({image})") };
            affine(image, texture, |v| format!("vec3({})", v.map(number).join(", ")))
        }
        Kind::Float | Kind::Bool => affine(image, texture, |v| number(v[0])),
    }
}

fn affine(image: String, texture: &TextureRef, text: impl Fn([f64; 3]) -> String) -> String {
    let mut out = if texture.is_inverted { format!("(1.0 - {image})") } else { image };
    if texture.scale != [1.0; 3] {
        out += &format!(" * {}", text(texture.scale));
    }
    if texture.bias != [0.0; 3] {
        out += &format!(" + {}", text(texture.bias));
    }
    out
}

/// Coordinates of an image: scaled, turned counterclockwise as seen with v upwards, shifted.
fn coordinates(texture: &TextureRef) -> String {
    let (scale, offset) = (texture.uv_scale, texture.uv_offset);
    if scale == [1.0; 2] && offset == [0.0; 2] && texture.uv_rotation == 0.0 {
        return "getUV0()".to_owned();
    }
    let (sin, cos) = texture.uv_rotation.to_radians().sin_cos();
    let columns = [cos * scale[0], -sin * scale[0], sin * scale[1], cos * scale[1]].map(number).join(", ");
    format!("mat2({columns}) * getUV0() + vec2({}, {})", number(offset[0]), number(offset[1]))
}
