//! Our own node in MaterialX: its definition from the property table, and its implementation as a graph that ends in OpenPBR.
//!
//! With both in the file, every renderer that knows OpenPBR renders the native copy too. Height, ambient occlusion and thickness have no
//! place in a surface shader and stay unused.

use super::numbers;
use super::xml_write::Xml;
use crate::file::ASM_VERSION;
use crate::properties::PROPERTIES;
use crate::value::{Kind, LimitKind, PropertyDef, Value};

/// Category of the node.
pub const NODE: &str = "adobe_standard_material";
/// Its graph; the formulas are those of the shading model OpenPBR.
const IMPLEMENTATION: &str = include_str!("implementation.xml");

/// Names of the definition and of the graph that implements it.
pub fn names() -> [String; 2] {
    ["ND", "NG"].map(|prefix| format!("{prefix}_{NODE}_surfaceshader"))
}

/// MaterialX's type of a property.
pub fn type_of(kind: Kind) -> &'static str {
    match kind {
        Kind::Color => "color3",
        Kind::Float => "float",
        Kind::Bool => "boolean",
        Kind::Normal => "vector3",
    }
}

/// A value as MaterialX holds it.
pub fn value_text(value: Value) -> String {
    match value {
        Value::Bool(on) => on.to_string(),
        value => numbers::list(value.numbers()),
    }
}

/// Writes the definition and the implementation.
pub fn write(xml: &mut Xml) {
    let [name, _] = names();
    let attributes =
        [("name", name.as_str()), ("node", NODE), ("nodegroup", "pbr"), ("version", ASM_VERSION), ("isdefaultversion", "true")];
    xml.open("nodedef", &attributes);
    for def in PROPERTIES {
        write_input(xml, def);
    }
    xml.empty("output", &[("name", "out"), ("type", "surfaceshader")]);
    xml.close("nodedef");
    xml.raw(IMPLEMENTATION);
}

fn write_input(xml: &mut Xml, def: &PropertyDef) {
    let kind = def.default.kind();
    let default = value_text(def.default);
    let mut attributes = vec![("name", def.name), ("type", type_of(kind))];
    if kind == Kind::Normal {
        attributes.push(("defaultgeomprop", "Nworld"));
    } else {
        attributes.push(("value", &default));
    }
    let count = if kind == Kind::Color { 3 } else { 1 };
    let end = |x: Option<f64>| x.map(|x| numbers::list(&vec![x; count]));
    let (min, max) = (end(def.limits.min), end(def.limits.max));
    let is_soft = def.limits.kind == LimitKind::Typical;
    if let Some(min) = &min {
        attributes.push(("uimin", min));
    }
    if let Some(max) = &max {
        attributes.push((if is_soft { "uisoftmax" } else { "uimax" }, max));
    }
    attributes.extend([("uiname", def.label), ("uifolder", def.group.title()), ("doc", def.doc)]);
    xml.empty("input", &attributes);
}
