//! A measurement as a material file: the values, and for each where it comes from.

use super::Measured;
use burnish_material::{LimitKind, Property, Unit, Value};
use std::fmt::Write as _;

/// The rule by which measured values outside a property's range are brought into it, as the built-in files name it.
const CLAMP_RULE: &str = "clamp per channel to [0,1]";

impl Measured {
    /// The text of a material file with everything that was measured and nothing else; lengths in millimetres.
    ///
    /// What lies outside the range of its property is clamped, and the measured value stands beside it.
    pub fn file_text(&self) -> String {
        let mut text = format!("// {}, as measured.\n{{\n    \"asm\": \"4.0\",\n    \"name\": {:?},\n", self.name, self.name);
        let tag = if self.is_computed() { "computed" } else { "measured" };
        // Writing into a text cannot fail.
        _ = writeln!(text, "    \"tags\": [{:?}, {tag:?}],", self.group);
        if self.values.iter().any(|(property, _)| property.def().unit == Unit::Length) {
            text += "    \"unit_mm\": 1.0,\n";
        }
        _ = writeln!(text, "    \"provenance\": {{\n        \"source\": {:?},", self.dataset);
        _ = writeln!(text, "        \"reference\": {:?},\n        \"licence\": {:?},\n    }},", self.reference, self.licence);
        text += "    \"properties\": {\n";
        for (property, value) in &self.values {
            _ = writeln!(text, "        {:?}: {},", property.def().name, written(clamped(*property, *value)));
        }
        text += "    },\n    \"sources\": {\n";
        for (property, value) in &self.values {
            _ = writeln!(text, "        {:?}: {{", property.def().name);
            for (key, what) in [("dataset", self.dataset), ("paper", self.reference), ("method", tag), ("licence", self.licence)]
            {
                _ = writeln!(text, "            {key:?}: {what:?},");
            }
            if clamped(*property, *value) != *value {
                _ = writeln!(text, "            \"note\": {CLAMP_RULE:?},\n            \"measured\": {},", written(*value));
            }
            if let Some((low, high)) = self.spread(*property) {
                _ = writeln!(
                    text,
                    "            \"spread_min\": {},\n            \"spread_max\": {},",
                    written(low),
                    written(high)
                );
            }
            text += "        },\n";
        }
        text += "    },\n}\n";
        text
    }
}

/// The value within the hard range of its property.
fn clamped(property: Property, value: Value) -> Value {
    let limits = property.def().limits;
    if limits.kind != LimitKind::Hard {
        return value;
    }
    let within = |x: f64| x.max(limits.min.unwrap_or(f64::MIN)).min(limits.max.unwrap_or(f64::MAX));
    match value {
        Value::Float(x) => Value::Float(within(x)),
        Value::Color(color) => Value::Color(color.map(within)),
        Value::Bool(_) | Value::Normal(_) => value,
    }
}

fn written(value: Value) -> String {
    match value {
        Value::Float(x) => format!("{x:?}"),
        Value::Bool(is_on) => is_on.to_string(),
        Value::Color([x, y, z]) | Value::Normal([x, y, z]) => format!("({x:?}, {y:?}, {z:?})"),
    }
}

#[cfg(test)]
mod tests {
    use super::super::{find, measured};
    use super::*;
    use burnish_material::MaterialFile;

    #[test]
    fn every_measurement_becomes_a_file_without_a_warning() {
        for row in measured() {
            let text = row.file_text();
            let (file, warnings) = MaterialFile::parse(&text).unwrap_or_else(|error| panic!("{}: {error}\n{text}", row.id));
            assert!(warnings.is_empty() && file.unknown_keys().is_empty(), "{}: {warnings:?}", row.id);
            assert_eq!(file.material().name, row.name);
            for (property, value) in &row.values {
                assert_eq!(file.material().value(*property), clamped(*property, *value), "{}", row.id);
                assert!(file.source_of(*property).is_some_and(|source| !source.method.is_empty()), "{}", row.id);
            }
        }
    }

    #[test]
    fn what_is_clamped_keeps_what_was_measured() {
        let gold = find("gold").unwrap().file_text();
        assert!(gold.contains("\"base_color\": (1.0, 0.7733, 0.3073),"), "{gold}");
        assert!(gold.contains("\"note\": \"clamp per channel to [0,1]\",\n            \"measured\": (1.0588, 0.7733, 0.3073),"));
        assert!(gold.contains("\"spread_min\": (0.9432, 0.641, 0.3073),"));
    }
}
