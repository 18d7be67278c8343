//! Inputs of MaterialX's surfaces that no property of ASM means. They are kept with the material and go back out to the same surface while
//! the properties that they belong to are as they were.

use serde_json::{Value as Json, json};

use super::numbers;
use super::walk::{Term, Walk};
use super::write::{Feed, Input};
use super::xml::Id;
use crate::exchange::model::Notes;
use crate::exchange::native::{texture_json, value_json};
use crate::material::Material;
use crate::properties::Property;
use crate::value::Group;

/// The format in a material's entries of other formats.
const FORMAT: &str = "materialx";

/// An input without a property.
struct Foreign {
    surface: &'static str,
    name: &'static str,
    kind: &'static str,
    /// Its value where a file says nothing.
    default: &'static [f64],
    /// The value that means what ASM does; that is not kept.
    neutral: &'static [f64],
    /// Groups of the properties that it belongs to.
    beside: &'static [Group],
}

const fn plain(
    surface: &'static str,
    name: &'static str,
    kind: &'static str,
    default: &'static [f64],
    beside: &'static [Group],
) -> Foreign {
    Foreign { surface, name, kind, default, neutral: default, beside }
}

const SURFACE: &[Group] = &[Group::Surface];
const FILM: &[Group] = &[Group::Surface, Group::Interior];
const BODY: &[Group] = &[Group::Interior, Group::Absorption];
const SCATTER: &[Group] = &[Group::Scattering];
const COAT: &[Group] = &[Group::Coat];
const OPEN: &str = "open_pbr_surface";
const STANDARD: &str = "standard_surface";
const GLTF: &str = "gltf_pbr";

const FOREIGN: &[Foreign] = &[
    plain(OPEN, "base_diffuse_roughness", "float", &[0.0], SURFACE),
    plain(OPEN, "transmission_scatter", "color3", &[0.0; 3], BODY),
    plain(OPEN, "transmission_scatter_anisotropy", "float", &[0.0], BODY),
    plain(OPEN, "subsurface_scatter_anisotropy", "float", &[0.0], SCATTER),
    plain(OPEN, "coat_roughness_anisotropy", "float", &[0.0], COAT),
    // ASM's coat does not darken what lies below it, so that a file which says nothing means something else.
    Foreign { surface: OPEN, name: "coat_darkening", kind: "float", default: &[1.0], neutral: &[0.0], beside: COAT },
    plain(OPEN, "thin_film_weight", "float", &[0.0], FILM),
    plain(OPEN, "thin_film_thickness", "float", &[0.5], FILM),
    plain(OPEN, "thin_film_ior", "float", &[1.4], FILM),
    plain(OPEN, "geometry_thin_walled", "boolean", &[0.0], BODY),
    plain(STANDARD, "diffuse_roughness", "float", &[0.0], SURFACE),
    plain(STANDARD, "transmission_scatter", "color3", &[0.0; 3], BODY),
    plain(STANDARD, "transmission_scatter_anisotropy", "float", &[0.0], BODY),
    plain(STANDARD, "transmission_extra_roughness", "float", &[0.0], BODY),
    plain(STANDARD, "subsurface_anisotropy", "float", &[0.0], SCATTER),
    plain(STANDARD, "coat_anisotropy", "float", &[0.0], COAT),
    plain(STANDARD, "coat_rotation", "float", &[0.0], COAT),
    plain(STANDARD, "coat_affect_color", "float", &[0.0], COAT),
    plain(STANDARD, "coat_affect_roughness", "float", &[0.0], COAT),
    plain(STANDARD, "thin_film_thickness", "float", &[0.0], FILM),
    plain(STANDARD, "thin_film_IOR", "float", &[1.5], FILM),
    plain(STANDARD, "thin_walled", "boolean", &[0.0], BODY),
    plain(GLTF, "iridescence", "float", &[0.0], FILM),
    plain(GLTF, "iridescence_ior", "float", &[1.3], FILM),
    plain(GLTF, "iridescence_thickness", "float", &[100.0], FILM),
];

/// Whether an input is one of these.
pub fn is_foreign(surface: &str, name: &str) -> bool {
    FOREIGN.iter().any(|foreign| foreign.surface == surface && foreign.name == name)
}

/// Keeps the foreign inputs of a surface with the material that was read from it.
pub fn keep(walk: &mut Walk, shader: Id, surface: &str, material: &mut Material) {
    for foreign in FOREIGN.iter().filter(|foreign| foreign.surface == surface) {
        let input = walk.graph.input(shader, foreign.name);
        let said = input.and_then(|input| walk.at(input));
        let values = match &said {
            None => foreign.default.to_vec(),
            Some(Term::Numbers(parts)) if parts.count == foreign.default.len() => match parts.as_constants() {
                Some(values) => values,
                None => {
                    walk.note(format!("{}: ASM has no place for it, and an image in it cannot be kept", foreign.name));
                    continue;
                }
            },
            Some(_) => {
                walk.note(format!("{}: expected a constant {}; not kept", foreign.name, foreign.kind));
                continue;
            }
        };
        let is_idle = foreign.beside == COAT
            && material.float(Property::coat) == 0.0
            && !material.is_textured(Property::coat)
            && foreign.neutral != foreign.default;
        if values == foreign.neutral || is_idle {
            continue;
        }
        let key = format!("{surface}.{}", foreign.name);
        if material.foreign_text(FORMAT, &key).and_then(read).is_some_and(|(kept, _)| kept == values) {
            continue;
        }
        let entry = json!({ "value": values, "beside": beside(material, foreign.beside) });
        walk.note(match material.set_foreign(FORMAT, &key, Some(entry.to_string())) {
            Ok(()) => format!("{}: ASM has no place for it; kept for the way back to MaterialX", foreign.name),
            Err(error) => format!("{}: ASM has no place for it; {error}; not kept", foreign.name),
        });
    }
}

/// Adds the foreign inputs of a surface that the material brought along, where the properties beside them are as they were.
pub(super) fn add(material: &Material, surface: &str, inputs: &mut Vec<Input>) {
    let Some(entries) = material.foreign.get(FORMAT) else { return };
    for foreign in FOREIGN.iter().filter(|foreign| foreign.surface == surface) {
        let Some((values, was)) = entries.get(&format!("{surface}.{}", foreign.name)).and_then(|text| read(text)) else {
            continue;
        };
        if values.len() != foreign.default.len() || was != beside(material, foreign.beside) {
            continue;
        }
        let text = match foreign.kind {
            "boolean" => (values != [0.0]).to_string(),
            _ => numbers::list(&values),
        };
        inputs.retain(|input| input.name != foreign.name);
        inputs.push(Input::plain(foreign.name, foreign.kind, Feed::Value(text)));
    }
}

fn read(text: &str) -> Option<(Vec<f64>, Json)> {
    let json: Json = serde_json::from_str(text).ok()?;
    let values = json.get("value")?.as_array()?;
    let values: Option<Vec<f64>> = values.iter().map(|x| x.as_f64().filter(|x| x.is_finite())).collect();
    Some((values?, json.get("beside")?.clone()))
}

/// What a material says about the properties of these groups.
fn beside(material: &Material, groups: &[Group]) -> Json {
    let slots = material.slots().filter(|(property, _)| groups.contains(&property.def().group));
    let said = slots.filter_map(|(property, slot)| {
        let entry = match (&slot.texture, slot.value) {
            (Some(texture), _) => texture_json(texture),
            (None, Some(value)) if value != property.def().default => value_json(value),
            _ => return None,
        };
        Some((property.def().name.to_owned(), entry))
    });
    Json::Object(said.collect())
}

/// Tells of inputs that stand in the file and mean nothing to us.
pub fn tell_unknown(walk: &Walk, shader: Id, surface: &str, is_known: impl Fn(&str) -> bool, notes: &mut Notes) {
    for input in walk.graph.inputs(shader).take(256) {
        let name = walk.graph.tree.attribute(input, "name").unwrap_or_default();
        if !is_known(name) && !is_foreign(surface, name) {
            notes.push(format!("{}: nothing in ASM means this input of <{surface}>; not taken", walk.graph.path(input)));
        }
    }
}
