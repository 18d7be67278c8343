//! MDL: a module with one material, for programs that read NVIDIA's Material Definition Language.
//!
//! The material is a call with ASM's properties as arguments. In one flavour it calls Adobe's own material, which has to be installed there;
//! in the other the module brings a material of the same parameters, built on `df`. The native copy stands in an annotation.
//! Only what this program writes is read back, and plain calls of Adobe's material. Source: MDL specification 1.7.

mod read;

pub use read::{Imported, MdlError, read};

use std::fmt::Write;

use super::loss::{Cell, Fate, Row, rows};
use super::native;
use crate::material::Material;
use crate::properties::{Inputs, PROPERTIES, Property};
use crate::slot::{Channel, ColorSpace, TextureRef, Wrap};
use crate::value::{Kind, Value, Vary};

/// Adobe's material, as a call names it.
const ADOBE: &str = "::adobe::materials::standard";
/// The material of the same parameters that a module brings along.
const OWN: &str = "adobe_standard_material";
/// The annotation that holds the native copy.
const ANNOTATION: &str = "asm_native";

const OWN_TEXT: &str = include_str!("asm.mdl");
const IMAGES_TEXT: &str = include_str!("images.mdl");

/// What the material of a module calls.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Flavour {
    /// Adobe's material, exactly; only where Adobe's module is installed.
    Adobe,
    /// A material in the module itself, which approximates; everywhere.
    Own,
}

/// The text of a module with this material.
///
/// `path_of` says where an image lies, relative to the module, such as `textures/wood.png`; a property whose image has no path (`None`) has its
/// uniform value for others, while the native copy keeps the image.
pub fn write(material: &Material, flavour: Flavour, path_of: &dyn Fn(&TextureRef) -> Option<String>) -> String {
    let name = identifier(&material.name);
    let mut arguments = Vec::new();
    let mut has_images = false;
    for (property, slot) in material.slots() {
        let image = slot.texture.as_ref().filter(|_| property.def().vary != Vary::Uniform);
        let path = image.and_then(|image| Some((image, path_of(image)?)));
        let text = match path {
            Some((image, path)) => {
                has_images = true;
                Some(image_text(material, property, image, &path, flavour))
            }
            None => slot.value.and_then(literal),
        };
        if let Some(text) = text {
            arguments.push(format!("    {}: {text}", property.def().name));
        }
    }
    let callee = if flavour == Flavour::Adobe { ADOBE } else { OWN };
    let mut text = String::from("mdl 1.7;\n\n");
    let modules = ["anno", "df", "math", "state", "tex"];
    // Writing to a String cannot fail.
    modules.iter().for_each(|module| _ = writeln!(text, "import ::{module}::*;"));
    if flavour == Flavour::Adobe {
        _ = writeln!(text, "import {ADOBE};");
    }
    _ = write!(
        text,
        "\n// Everything that the material holds, for the program that wrote this.\nannotation {ANNOTATION}(string json);\n\n"
    );
    if has_images {
        _ = writeln!(text, "{IMAGES_TEXT}");
    }
    if flavour == Flavour::Own {
        _ = writeln!(text, "{OWN_TEXT}");
    }
    let display = string(if material.name.is_empty() { &name } else { &material.name });
    let copy = string(&native::write(material, None).to_string());
    let arguments = if arguments.is_empty() { String::new() } else { format!("\n{}", arguments.join(",\n")) };
    _ = write!(
        text,
        "export material {name}(*)\n[[\n    anno::display_name({display}),\n    {ANNOTATION}({copy})\n]]\n= {callee}({arguments});\n"
    );
    text
}

/// What the translation costs.
pub fn loss(material: &Material, flavour: Flavour) -> Vec<Row> {
    match flavour {
        Flavour::Adobe => {
            let cells: Vec<Cell> = PROPERTIES.iter().map(|def| Cell::exact(def.id, def.name)).collect();
            rows(&cells, material)
        }
        Flavour::Own => rows(&PROPERTIES.iter().map(|def| own_cell(def.id)).collect::<Vec<_>>(), material),
    }
}

/// How the material on `df` holds a property.
fn own_cell(property: Property) -> Cell {
    let name = property.def().name;
    let approximated = |fate: fn(&Inputs<f64>) -> (Fate, &'static str)| Cell { property, target: name, fate };
    match property {
        Property::specular_level => approximated(|i| match i.translucency {
            0.0 => (Fate::Exact, ""),
            _ if i.specular_level == 0.5 => (Fate::Exact, ""),
            _ => (Fate::Approximated, "glass reflects by its index of refraction alone"),
        }),
        Property::specular_edge_color => approximated(|i| match i.metallic {
            0.0 => (Fate::Exact, ""),
            _ if i.specular_edge_color == [1.0; 3] => (Fate::Exact, ""),
            _ => (Fate::Approximated, "metal is tinted at grazing angles, on another curve"),
        }),
        Property::sheen | Property::sheen_color | Property::sheen_roughness => approximated(|i| match i.sheen {
            0.0 => (Fate::Exact, ""),
            _ => (Fate::Approximated, "another lobe with the same numbers"),
        }),
        Property::coat_color => approximated(|i| match i.coat_color {
            [1.0, 1.0, 1.0] => (Fate::Exact, ""),
            _ => (Fate::Approximated, "the tint does not deepen towards grazing angles"),
        }),
        Property::normal_scale | Property::coat_normal_scale => {
            approximated(|_| (Fate::Approximated, "scales the slope, where ASM scales the angle below 1"))
        }
        Property::dispersion
        | Property::combine_normal_and_height
        | Property::ambient_occlusion
        | Property::volume_thickness
        | Property::volume_thickness_scale => Cell::dropped(property),
        _ => Cell::exact(property, name),
    }
}

/// A value as MDL; `None` for one that cannot be said in a constant.
fn literal(value: Value) -> Option<String> {
    if value.numbers().iter().any(|x| !x.is_finite()) {
        return None;
    }
    match value {
        Value::Color([r, g, b]) => Some(format!("color({r:?}, {g:?}, {b:?})")),
        Value::Float(x) => Some(format!("{x:?}")),
        Value::Bool(on) => Some(on.to_string()),
        // A direction of tangent space is none of the space that MDL means.
        Value::Normal(_) => None,
    }
}

/// The lookup that stands in for a value.
fn image_text(material: &Material, property: Property, image: &TextureRef, path: &str, flavour: Flavour) -> String {
    let kind = property.def().default.kind();
    let is_srgb = match image.color_space {
        ColorSpace::Auto => kind == Kind::Color,
        ColorSpace::Srgb => true,
        ColorSpace::Linear => false,
    };
    let gamma = if is_srgb { "srgb" } else { "linear" };
    let path = string(&if path.starts_with("../") { path.to_owned() } else { format!("./{}", path.trim_start_matches("./")) });
    let wrap = match image.wrap {
        Wrap::Repeat => "tex::wrap_repeat",
        Wrap::Clamp => "tex::wrap_clamp",
        Wrap::Mirror => "tex::wrap_mirrored_repeat",
    };
    let number = |x: f64| format!("{:?}", if x.is_finite() { x } else { 0.0 });
    let list = |numbers: &[f64]| numbers.iter().map(|x| number(*x)).collect::<Vec<_>>().join(", ");
    let (scale, turn, shift) = (list(&image.uv_scale), number(image.uv_rotation.to_radians()), list(&image.uv_offset));
    let uv = format!("asm_uv(float2({scale}), {turn}, float2({shift}))");
    let lookup = format!("texture_2d({path}, ::tex::gamma_{gamma}), {uv}, {wrap}");
    // 1 - x, scaled and shifted, is x with another scale and shift.
    let sign = if image.is_inverted { -1.0 } else { 1.0 };
    let scale = image.scale.map(|s| sign * s);
    let bias: [f64; 3] = std::array::from_fn(|k| image.bias[k] + if image.is_inverted { image.scale[k] } else { 0.0 });
    match kind {
        Kind::Color => format!("asm_color({lookup}, float3({}), float3({}))", list(&scale), list(&bias)),
        Kind::Float | Kind::Bool => {
            let channel = match image.channel {
                Channel::Rgb => -1,
                Channel::R => 0,
                Channel::G => 1,
                Channel::B => 2,
                Channel::A => 3,
            };
            format!("asm_float({lookup}, {channel}, {}, {})", number(scale[0]), number(bias[0]))
        }
        Kind::Normal => {
            // Adobe's material scales by itself.
            let strength = match (flavour, property) {
                (Flavour::Adobe, _) => 1.0,
                (_, Property::coat_normal) => material.float(Property::coat_normal_scale),
                _ => material.float(Property::normal_scale),
            };
            format!("asm_normal({lookup}, {}, {})", number(sign), number(strength))
        }
    }
}

/// A text as a string of MDL, which escapes as JSON does.
fn string(text: &str) -> String {
    serde_json::Value::from(text).to_string()
}

/// A name that MDL takes for a material.
fn identifier(name: &str) -> String {
    const TAKEN: [&str; 3] = ["material", "annotation", OWN];
    let cleaned: String = name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    let cleaned = cleaned.trim_matches('_');
    match cleaned.chars().next() {
        None => "asm_material".to_owned(),
        // Keywords and names of modules are lower case.
        Some(c) if c.is_ascii_digit() || !cleaned.contains(|c: char| c.is_ascii_uppercase() || c == '_') => {
            format!("asm_{cleaned}")
        }
        _ if TAKEN.contains(&cleaned) => format!("asm_{cleaned}"),
        _ => cleaned.to_owned(),
    }
}
