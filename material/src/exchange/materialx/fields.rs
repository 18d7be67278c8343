//! What a surface of a document says about the parameters of its shading model.

use super::graph::Link;
use super::image::{binding, normal_binding};
use super::nodes::unpacked;
use super::surfaces::PREVIEW;
use super::walk::{Direction, Normal, Term, Walk};
use super::xml::Id;
use crate::exchange::field::{Field, FieldDef, Fields};
use crate::exchange::model::ShadingModel;
use crate::exchange::short::short;
use crate::slot::TextureRef;
use crate::value::{Kind, Value};

/// Parameters whose name ends so are settings of the node in front of the input before it.
const SCALE: &str = ".scale";
const DISPLACEMENT: &str = "displacement";
/// Value of a parameter that follows an image, for formulas that ask whether there is any of it.
const MIDDLE: f64 = 0.5;

/// Reads a surface, and the displacement that the material has beside it.
pub fn read(walk: &mut Walk, shader: Id, displacement: Option<Id>, model: &ShadingModel) -> Fields {
    let mut fields = Fields::unsaid(model.fields);
    for (def, field) in model.fields.iter().zip(&mut fields.0) {
        let base = def.name.strip_suffix(SCALE).unwrap_or(def.name);
        let is_scale = base != def.name;
        let input = match (base, displacement) {
            (DISPLACEMENT, Some(node)) => walk.graph.input(node, if is_scale { "scale" } else { DISPLACEMENT }),
            (DISPLACEMENT, None) if is_scale => None,
            _ => walk.graph.input(shader, base),
        };
        let Some(input) = input else { continue };
        if is_scale && base != DISPLACEMENT {
            if let Some(Term::Normal(normal)) = as_normal(walk, input, shader) {
                *field = Field { value: Value::Float(normal.scale), texture: None, is_authored: true };
            }
            continue;
        }
        match read_parameter(walk, input, shader, def) {
            Ok(found) => *field = found,
            Err(note) if note.is_empty() => {}
            Err(note) => walk.note(format!("{note}; the default is taken")),
        }
    }
    fields
}

/// The normal behind an input. USD's surface takes the direction itself, the others take a normal map.
fn as_normal(walk: &mut Walk, input: Id, shader: Id) -> Option<Term> {
    match walk.at(input)? {
        Term::Numbers(parts) if walk.graph.tree.tag(shader) == PREVIEW => unpacked(&parts, 1.0, 0.0, 1.0).map(Term::Normal),
        term => Some(term),
    }
}

fn read_parameter(walk: &mut Walk, input: Id, shader: Id, def: &FieldDef) -> Result<Field, String> {
    let constant = |value: Value| Ok(Field { value, texture: None, is_authored: true });
    let kind = def.default.kind();
    if kind == Kind::Normal {
        return match as_normal(walk, input, shader) {
            Some(Term::Normal(normal)) => read_normal(walk, input, &normal),
            Some(Term::Direction(Direction::Normal)) | None => Err(String::new()),
            Some(term) => Err(reason(walk, input, &term, kind)),
        };
    }
    if def.name == "geometry_tangent" {
        return match walk.at(input) {
            Some(Term::Direction(Direction::Tangent)) | None => Err(String::new()),
            Some(Term::Tangent(turns)) => match turns.as_constant() {
                Some(turns) => constant(Value::Float(turns)),
                None => {
                    let parts = super::numbers::Parts::of(&[turns]).ok_or_else(String::new)?;
                    textured(walk, input, binding(walk, &parts, Kind::Float), Value::Float(MIDDLE))
                }
            },
            Some(term) => Err(reason(walk, input, &term, Kind::Normal)),
        };
    }
    read_input(walk, input, kind)
}

fn read_normal(walk: &Walk, input: Id, normal: &Normal) -> Result<Field, String> {
    match normal.source {
        None => Ok(Field { value: Value::Normal(normal.constant), texture: None, is_authored: true }),
        Some(_) => textured(
            walk,
            input,
            normal_binding(walk, normal).ok_or("lies on sheared coordinates"),
            Value::Normal(normal.constant),
        ),
    }
}

fn textured(walk: &Walk, input: Id, texture: Result<TextureRef, &'static str>, value: Value) -> Result<Field, String> {
    match texture {
        Ok(texture) => Ok(Field { value, texture: Some(texture), is_authored: true }),
        Err(reason) => Err(format!("{}: {reason}", walk.graph.path(input))),
    }
}

/// What an input says that has to be of this kind: a value or an image. Errors are notes without their end.
pub fn read_input(walk: &mut Walk, input: Id, kind: Kind) -> Result<Field, String> {
    let term = walk.at(input);
    let count = match kind {
        Kind::Color => 3,
        Kind::Float | Kind::Bool => 1,
        Kind::Normal => {
            return match term {
                Some(Term::Normal(normal)) => read_normal(walk, input, &normal),
                Some(Term::Direction(Direction::Normal)) => read_normal(walk, input, &Normal::FLAT),
                Some(term) => Err(reason(walk, input, &term, kind)),
                None => Err(missing(walk, input, kind)),
            };
        }
    };
    let parts = match term {
        Some(Term::Numbers(parts)) if parts.count == count => *parts,
        Some(term) => return Err(reason(walk, input, &term, kind)),
        None => return Err(missing(walk, input, kind)),
    };
    let value = match (kind, parts.as_constants().as_deref()) {
        (Kind::Color, Some([r, g, b])) => Value::Color([*r, *g, *b]),
        (Kind::Float, Some([x])) => Value::Float(*x),
        (Kind::Bool, Some([x])) => Value::Bool(*x != 0.0),
        _ => {
            let middle = if kind == Kind::Color { Value::Color([MIDDLE; 3]) } else { Value::Float(MIDDLE) };
            return textured(walk, input, binding(walk, &parts, kind), middle);
        }
    };
    Ok(Field { value, texture: None, is_authored: true })
}

fn word(kind: Kind) -> &'static str {
    match kind {
        Kind::Color => "a color3",
        Kind::Float => "a float",
        Kind::Bool => "a boolean",
        Kind::Normal => "a normal map",
    }
}

fn reason(walk: &Walk, input: Id, term: &Term, kind: Kind) -> String {
    let path = walk.graph.path(input);
    match term {
        Term::Unknown(node, why) => {
            format!("{path}: the node `{}` <{}> {why}", walk.graph.path(*node), short(walk.graph.tree.tag(*node)))
        }
        Term::Numbers(parts) => format!("{path}: expected {}, found a value of {} numbers", word(kind), parts.count),
        Term::Normal(_) | Term::Direction(_) | Term::Tangent(_) => format!("{path}: expected {}, found a direction", word(kind)),
    }
}

/// Nothing to say about an input that is there and empty, or whose fault was told already.
fn missing(walk: &Walk, input: Id, kind: Kind) -> String {
    let tree = walk.graph.tree;
    let kind_there = short(tree.attribute(input, "type").unwrap_or_default());
    match walk.graph.link(input) {
        Link::Value(_) if tree.attribute(input, "value").is_some_and(|text| !text.is_empty()) => {
            format!("{}: expected {}, found a {kind_there} that is none", walk.graph.path(input), word(kind))
        }
        _ => format!("{}: expected {}, found nothing", walk.graph.path(input), word(kind)),
    }
}
