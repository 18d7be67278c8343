//! The way back: the native copy, and assignments of plain numbers.

use super::NATIVE;
use super::write::split;
use crate::exchange::field::Fields;
use crate::exchange::model::{Context, Notes};
use crate::exchange::models::filament::{Filament, MODEL};
use crate::exchange::{merge, native};
use crate::material::Material;
use crate::value::Value;

/// Longest text of a definition that is read, in bytes.
pub const MAX_BYTES: usize = 4 << 20;
/// Most sentences about a definition.
const MAX_NOTES: usize = 100;
/// Longest piece of a definition in a sentence, in characters.
const MAX_QUOTE: usize = 60;

/// Why a text is no definition that can be read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum FilamentError {
    /// The text is longer than [`MAX_BYTES`].
    TooLong {
        /// Its length in bytes.
        bytes: usize,
    },
    /// There is no native copy and no fragment block.
    NoFragment,
    /// The definition has another shading model than the lit one.
    OtherModel {
        /// The word that it has.
        found: String,
    },
}

impl std::fmt::Display for FilamentError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::TooLong { bytes } => write!(f, "expected a material definition of at most {MAX_BYTES} bytes, found {bytes}"),
            Self::NoFragment => write!(f, "expected `fragment {{ … }}` of a Filament material definition, found none"),
            Self::OtherModel { found } => write!(f, "shadingModel: expected `lit`, found `{found}`"),
        }
    }
}

impl std::error::Error for FilamentError {}

/// What a definition means.
#[derive(Clone, Debug)]
pub struct Read {
    /// The material.
    pub material: Material,
    /// Whether it comes from a native copy.
    pub is_native: bool,
    /// Sentences for the user about what did not go as it stands in the file.
    pub notes: Notes,
}

/// Parameters that a text sets, and the rest of it.
pub(super) struct Assignments {
    pub fields: Fields,
    pub notes: Notes,
}

/// Reads a definition.
pub fn read(text: &str) -> Result<Read, FilamentError> {
    if text.len() > MAX_BYTES {
        return Err(FilamentError::TooLong { bytes: text.len() });
    }
    let mut notes = Notes::new();
    let copy = text.lines().find_map(|line| line.trim_start().strip_prefix(NATIVE));
    let copy = copy.and_then(|json| match serde_json::from_str(json) {
        Ok(json) => native::read(&json, Some(Filament::FIELDS), &mut notes),
        Err(error) => {
            notes.push(format!("the native copy is no JSON ({error}): the assignments are read instead"));
            None
        }
    });
    if copy.is_none() && !text.contains("fragment") {
        return Err(FilamentError::NoFragment);
    }
    let found = assignments(text);
    if let Some(native) = copy {
        let context = Context::of(&native.material);
        let material = merge::merge(&MODEL, &native, &found.fields, &context, &mut notes);
        return Ok(Read { material, is_native: true, notes });
    }
    let code = without_comments(text);
    if let Some(model) = word_after(&code, "shadingModel").filter(|word| word != "lit") {
        return Err(FilamentError::OtherModel { found: quote(&model) });
    }
    notes.extend(found.notes);
    let mut material = MODEL.interpret(&found.fields, &Context::of(&Material::default()), &mut notes);
    material.name = quoted_after(&code, "name").unwrap_or_default();
    notes.truncate(MAX_NOTES);
    Ok(Read { material, is_native: false, notes })
}

/// All assignments of numbers to parameters. Of several to one parameter the last holds.
pub(super) fn assignments(text: &str) -> Assignments {
    let code = without_comments(text);
    let mut all = Assignments { fields: Fields::unsaid(Filament::FIELDS), notes: Notes::new() };
    let fragment = code.find("fragment").map_or("", |start| &code[start..]);
    for statement in fragment.split([';', '{', '}']) {
        let Some(rest) = statement.trim().strip_prefix("material.") else { continue };
        let Some((left, right)) = rest.split_once('=') else { continue };
        let left = left.trim();
        // The product with alpha is how the engine wants colours that are not opaque.
        if left == "baseColor.rgb *" {
            continue;
        }
        if !all.take(left, right.trim()) && all.notes.len() < MAX_NOTES {
            all.notes.push(format!("fragment: `material.{}` is no number of the lit model; not read", quote(rest.trim())));
        }
    }
    all
}

impl Assignments {
    /// Takes an assignment; false where it is none of a number to a parameter.
    fn take(&mut self, left: &str, right: &str) -> bool {
        let Some(numbers) = numbers(right) else { return false };
        match (left, numbers.as_slice()) {
            // A number fills all components.
            ("baseColor", [r, g, b, a]) => self.say("baseColor.rgb", &[*r, *g, *b]) && self.say("baseColor.a", &[*a]),
            ("baseColor" | "emissive", [x]) => self.say(&format!("{left}.rgb"), &[*x; 3]),
            ("emissive", [r, g, b, _]) => self.say("emissive.rgb", &[*r, *g, *b]),
            (_, numbers) => self.say(left, numbers),
        }
    }

    fn say(&mut self, name: &str, numbers: &[f64]) -> bool {
        let Some(place) = Filament::FIELDS.iter().position(|def| def.name == name) else { return false };
        let value = match (Filament::FIELDS[place].default, numbers) {
            (Value::Float(_), [x]) => Value::Float(*x),
            (Value::Color(_), [x]) => Value::Color([*x; 3]),
            (Value::Color(_), [x, y, z]) => Value::Color([*x, *y, *z]),
            (Value::Normal(_), [x, y, z]) => Value::Normal([*x, *y, *z]),
            _ => return false,
        };
        let field = &mut self.fields.0[place];
        (field.value, field.is_authored) = (value, true);
        // A coat of which only the roughness is said is there.
        let is_unsaid = self.fields.get(Filament::FIELDS, "clearCoat").is_some_and(|coat| !coat.is_authored);
        if split(name).0 == "clearCoatRoughness"
            && is_unsaid
            && let Some(coat) = self.fields.say(Filament::FIELDS, "clearCoat")
        {
            coat.value = Value::Float(1.0);
        }
        true
    }
}

/// Numbers of `0.5`, `vec3(1.0)` or `vec4(1.0, 0.5, 0.2, 1.0)`, all finite.
fn numbers(text: &str) -> Option<Vec<f64>> {
    let number = |text: &str| {
        let text = text.trim();
        let text = text.strip_suffix(['f', 'F']).unwrap_or(text);
        let is_plain = text.chars().all(|c| c.is_ascii_digit() || "+-.eE".contains(c));
        text.parse::<f64>().ok().filter(|x| is_plain && x.is_finite())
    };
    let vector = [("vec2", 2), ("vec3", 3), ("vec4", 4), ("float3", 3), ("float4", 4)].iter().find_map(|(word, count)| {
        let inside = text.strip_prefix(word)?.trim_start().strip_prefix('(')?.trim_end().strip_suffix(')')?;
        Some((inside, *count))
    });
    let Some((inside, count)) = vector else { return Some(vec![number(text)?]) };
    let list = inside.split(',').take(count + 1).map(number).collect::<Option<Vec<f64>>>()?;
    match list.as_slice() {
        [x] => Some(vec![*x; count]),
        list => (list.len() == count).then(|| list.to_vec()),
    }
}

/// The text with blanks for its comments.
fn without_comments(text: &str) -> String {
    let mut code = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(start) = rest.find("//").into_iter().chain(rest.find("/*")).min() {
        code.push_str(&rest[..start]);
        code.push(' ');
        let (comment, end) = (&rest[start..], if rest[start..].starts_with("//") { "\n" } else { "*/" });
        rest = comment[2..].find(end).map_or("", |at| &comment[2 + at + end.len()..]);
        code.push(if end == "\n" { '\n' } else { ' ' });
    }
    code + rest
}

/// What follows a key and its colon in the definition.
fn after<'a>(code: &'a str, key: &str) -> Option<&'a str> {
    let head = code.split("fragment").next()?;
    head.match_indices(key).find_map(|(at, _)| head[at + key.len()..].trim_start().strip_prefix(':')).map(str::trim_start)
}

fn word_after(code: &str, key: &str) -> Option<String> {
    let rest = after(code, key)?;
    Some(rest.trim_start_matches('"').chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect())
}

fn quoted_after(code: &str, key: &str) -> Option<String> {
    let rest = after(code, key)?;
    match rest.strip_prefix('"') {
        Some(rest) => rest.split_once('"').map(|(text, _)| text.chars().take(200).collect()),
        None => word_after(code, key),
    }
}

fn quote(text: &str) -> String {
    let line = text.split_whitespace().collect::<Vec<_>>().join(" ");
    if line.chars().count() <= MAX_QUOTE { line } else { line.chars().take(MAX_QUOTE).chain(['…']).collect() }
}
