//! `--set PROPERTY=VALUE`: one property by formal name, usage string or common name.

use super::suggest;
use burnish_material::{Kind, Material, PROPERTIES, Property, PropertyDef, Value};
use burnish_renderer::tonemap::srgb_decode;

/// A property and its new value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Assignment {
    /// What is set.
    pub property: Property,
    /// Finite, of the property's own kind; possibly outside its range.
    pub value: Value,
}

impl Assignment {
    /// Reads `PROPERTY=VALUE`. The error says what was expected.
    pub fn parse(text: &str) -> Result<Self, String> {
        let (name, value) = text.split_once('=').ok_or_else(|| format!("expected PROPERTY=VALUE, found `{text}`"))?;
        let (name, value) = (name.trim(), value.trim());
        let def = find_property(name)?;
        let value = parse_value(def, value)
            .ok_or_else(|| format!("{}: expected {}, found `{value}`", def.name, expectation(def.default.kind())))?;
        Ok(Self { property: def.id, value })
    }

    /// Sets the value; a texture in its place goes, because it would hide the value. Returns what the user should know.
    pub fn apply(&self, material: &mut Material) -> Vec<String> {
        let def = self.property.def();
        let mut notes = Vec::new();
        material.set(self.property, self.value);
        if material.slot_mut(self.property).texture.take().is_some() {
            notes.push(format!("--set {}: replaces the texture", def.name));
        }
        notes.extend(outside_range(def, self.value).map(|note| format!("--set {note}")));
        notes
    }
}

/// What is said about a value outside the property's range.
pub fn outside_range(def: &PropertyDef, value: Value) -> Option<String> {
    let numbers = value.numbers();
    let outside = numbers.iter().find(|x| !def.limits.contains(**x))?;
    Some(format!("{}: expected {}, found {outside}", def.name, def.limits.text()))
}

/// The property that a name means: formal name, usage string or common name.
pub fn find_property(name: &str) -> Result<&'static PropertyDef, String> {
    PROPERTIES.iter().find(|def| def.is_named(name)).ok_or_else(|| {
        let known = PROPERTIES.iter().flat_map(|def| [def.name, def.usage]);
        format!("`{name}` is no property; expected a name such as base_color or baseColor{}", suggest::hint(name, known))
    })
}

fn expectation(kind: Kind) -> &'static str {
    match kind {
        Kind::Color => "a colour as r,g,b (linear) or #rrggbb (sRGB)",
        Kind::Float => "a finite number",
        Kind::Bool => "true or false",
        Kind::Normal => "a direction as x,y,z",
    }
}

fn parse_value(def: &PropertyDef, text: &str) -> Option<Value> {
    Some(match def.default.kind() {
        Kind::Color => Value::Color(parse_hex(text).or_else(|| parse_triple(text))?),
        Kind::Float => Value::Float(parse_number(text)?),
        Kind::Bool => Value::Bool(match text {
            "true" | "1" | "on" | "yes" => true,
            "false" | "0" | "off" | "no" => false,
            _ => return None,
        }),
        Kind::Normal => Value::Normal(parse_triple(text)?),
    })
}

/// A finite number.
pub fn parse_number(text: &str) -> Option<f64> {
    text.trim().parse().ok().filter(|x: &f64| x.is_finite())
}

/// Three finite numbers with commas between them.
pub fn parse_triple(text: &str) -> Option<[f64; 3]> {
    let numbers: Option<Vec<f64>> = text.trim_start_matches('(').trim_end_matches(')').split(',').map(parse_number).collect();
    numbers?.try_into().ok()
}

/// `#rgb` or `#rrggbb` in sRGB, as linear values.
fn parse_hex(text: &str) -> Option<[f64; 3]> {
    let digits = text.strip_prefix('#')?;
    let digits: Option<Vec<u32>> = digits.chars().map(|c| c.to_digit(16)).collect();
    let bytes = match digits?.as_slice() {
        [r, g, b] => [r * 17, g * 17, b * 17],
        [r, s, g, h, b, c] => [r * 16 + s, g * 16 + h, b * 16 + c],
        _ => return None,
    };
    Some(bytes.map(|byte| f64::from(srgb_decode(byte as f32 / 255.0))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use burnish_material::TextureRef;

    #[test]
    fn every_property_can_be_set_by_each_of_its_names() {
        for def in PROPERTIES {
            let text = match def.default {
                Value::Bool(_) => "true",
                Value::Float(_) => "0.25",
                Value::Color(_) | Value::Normal(_) => "0.25, 0.5,0.75",
            };
            for name in [def.name, def.usage, def.label] {
                let read = Assignment::parse(&format!("{name}={text}")).unwrap();
                assert_eq!(read.value.kind(), def.default.kind(), "{name}");
            }
        }
    }

    #[test]
    fn hex_colours_are_srgb() {
        let read = |text: &str| Assignment::parse(text).unwrap().value;
        assert_eq!(read("base_color=#fff"), Value::Color([1.0; 3]));
        let Value::Color([r, g, b]) = read("baseColor=#BC0000") else { panic!("a colour") };
        assert!((r - 0.5029).abs() < 1e-3 && g == 0.0 && b == 0.0, "{r} {g} {b}");
    }

    #[test]
    fn errors_say_what_was_expected() {
        let cases = [
            ("roughness", "PROPERTY=VALUE"),
            ("roughnes=1", "did you mean `roughness`"),
            ("roughness=rough", "a finite number"),
            ("roughness=NaN", "a finite number"),
            ("roughness=1e999", "a finite number"),
            ("roughness=", "a finite number"),
            ("base_color=0.5", "r,g,b"),
            ("base_color=#12345", "#rrggbb"),
            ("base_color=#ééé", "#rrggbb"),
            ("scatter=maybe", "true or false"),
            ("normal=0,1", "x,y,z"),
        ];
        for (text, expected) in cases {
            let error = Assignment::parse(text).unwrap_err();
            assert!(error.contains(expected), "{text}: {error}");
        }
    }

    #[test]
    fn setting_replaces_a_texture_and_names_ranges() {
        let mut material = Material::default();
        material.slot_mut(Property::roughness).texture = Some(TextureRef::new("r.png"));
        let notes = Assignment::parse("roughness=1.5").unwrap().apply(&mut material);
        assert!(!material.is_textured(Property::roughness));
        assert_eq!(material.float(Property::roughness), 1.5);
        assert_eq!(notes.len(), 2, "{notes:?}");
        assert!(notes[1].contains("range 0 to 1"), "{notes:?}");
    }
}
