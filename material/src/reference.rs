//! The reference page for users, made from the two tables.

use std::fmt::Write;

use crate::lobes::LOBES;
use crate::properties::PROPERTIES;
use crate::value::{Group, Kind, Unit, Value, Vary};

/// Makes the text of `PROPERTIES.md`; a test keeps the file current.
pub fn reference_page() -> String {
    let mut page = String::from(
        "# Properties\n\n\
         Generated from `src/properties.rs` and `src/lobes.rs`; a test keeps it current.\n\n\
         A *range* is enforced by the renderers, a *typical range* is only a hint; files keep what was written in either case.\n\
         A property that is absent from a file has its default. Colours are linear Rec.709; lengths are in units of the file (`unit_mm`).\n",
    );
    // Writing to a String cannot fail.
    for group in Group::ALL {
        _ = writeln!(page, "\n## {}\n", group.title());
        for def in PROPERTIES.iter().filter(|def| def.group == group) {
            _ = writeln!(page, "### {}\n", def.label);
            _ = writeln!(page, "{}\n", def.doc);
            _ = writeln!(page, "- Name in files: `{}`; channel usage: `{}`", def.name, def.usage);
            let range = Some(def.limits.text()).filter(|range| !range.is_empty());
            let facts = [Some(kind_word(def.default.kind()).to_owned()), range, unit_words(def.unit), Some(vary_words(def.vary))];
            let facts: Vec<_> = facts.into_iter().flatten().collect();
            _ = writeln!(page, "- Value: {}; default `{}`\n", facts.join(", "), value_text(def.default));
        }
        page.truncate(page.trim_end().len());
        page.push('\n');
    }
    page += "\n## Lobes\n\nWhat a material does not need is left out of the shader and the path tracer.\n\n";
    page += "| Lobe | What it is, and when it is left out | Without effect while it is out |\n| --- | --- | --- |\n";
    for def in LOBES {
        let names: Vec<_> = def.properties.iter().map(|property| format!("`{}`", property.def().name)).collect();
        _ = writeln!(page, "| `{}` | {} | {} |", def.name, def.doc, names.join(", "));
    }
    page
}

fn kind_word(kind: Kind) -> &'static str {
    match kind {
        Kind::Color => "color",
        Kind::Float => "number",
        Kind::Bool => "switch",
        Kind::Normal => "direction",
    }
}

fn unit_words(unit: Unit) -> Option<String> {
    match unit {
        Unit::None => None,
        Unit::Length => Some("a length".into()),
        Unit::Turn => Some("in full turns".into()),
        Unit::Radiance => Some("a radiance".into()),
    }
}

fn vary_words(vary: Vary) -> String {
    match vary {
        Vary::Uniform => "one value for the whole material",
        Vary::Texturable => "uniform or a texture",
        Vary::TextureOnly => "a texture by nature",
    }
    .into()
}

fn value_text(value: Value) -> String {
    match value {
        Value::Bool(value) => value.to_string(),
        Value::Float(value) => value.to_string(),
        Value::Color([x, y, z]) | Value::Normal([x, y, z]) => format!("({x}, {y}, {z})"),
    }
}
