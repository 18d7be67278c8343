//! Reads modules of our own, and calls of Adobe's material with constants; says no to all else.

use std::fmt;

use super::super::model::Notes;
use super::super::native;
use super::super::short::short;
use super::{ADOBE, ANNOTATION, OWN};
use crate::file::MAX_FILE_BYTES;
use crate::material::Material;
use crate::properties::Property;
use crate::value::{Kind, Value};

/// Most sentences about a material.
const MAX_NOTES: usize = 100;

/// A material of a module.
#[derive(Clone, Debug, PartialEq)]
pub struct Imported {
    /// The material.
    pub material: Material,
    /// What did not go as it stands in the file.
    pub notes: Notes,
}

/// Why a module cannot be read. The caller names the file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum MdlError {
    /// More bytes than a material file may have.
    TooLarge(usize),
    /// No MDL: it does not begin with a version.
    NoVersion,
    /// MDL without a material that is a call.
    NoMaterial,
    /// The material calls something else.
    OtherCall {
        /// Name of the material.
        material: String,
        /// What it is made of.
        found: String,
    },
    /// An argument is not a constant, and no native copy says what it means.
    NotConstant {
        /// Name of the material.
        material: String,
        /// Name of the argument.
        argument: String,
        /// What was expected.
        expected: &'static str,
    },
    /// The text ends, or goes on otherwise, within a material.
    Broken {
        /// Name of the material.
        material: String,
        /// What was expected.
        expected: &'static str,
        /// Line, from 1.
        line: usize,
    },
}

impl fmt::Display for MdlError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooLarge(bytes) => write!(f, "expected an MDL module of at most {MAX_FILE_BYTES} bytes, found {bytes} bytes"),
            Self::NoVersion => write!(f, "expected an MDL module, which begins with `mdl` and a version"),
            Self::NoMaterial => {
                write!(f, "expected an exported material that this program wrote, or a call of `{ADOBE}`; found none")
            }
            Self::OtherCall { material, found } => {
                let (material, found) = (short(material), short(found));
                write!(f, "`{material}`: expected a call of `{ADOBE}` or a material that this program wrote, found `{found}`")
            }
            Self::NotConstant { material, argument, expected } => {
                let (material, argument) = (short(material), short(argument));
                write!(f, "`{material}`: {argument}: expected {expected} as a constant, found an expression")
            }
            Self::Broken { material, expected, line } => write!(f, "`{}`: line {line}: expected {expected}", short(material)),
        }
    }
}

impl std::error::Error for MdlError {}

/// The exported materials of a module, at least one.
pub fn read(text: &str) -> Result<Vec<Imported>, MdlError> {
    if text.len() > MAX_FILE_BYTES {
        return Err(MdlError::TooLarge(text.len()));
    }
    let tokens = tokens(text);
    let is = |at: usize, text: &str| tokens.get(at).is_some_and(|token| token.text == text);
    if !is(0, "mdl") {
        return Err(MdlError::NoVersion);
    }
    let mut found = Vec::new();
    for at in 0..tokens.len() {
        if is(at, "export") && is(at + 1, "material") && tokens.get(at + 2).is_some_and(|token| token.kind == Word) {
            found.push(Parser { tokens: &tokens, at: at + 3, name: tokens[at + 2].text }.material()?);
        }
    }
    if found.is_empty() { Err(MdlError::NoMaterial) } else { Ok(found) }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum TokenKind {
    /// A name, with `::` where it has that, or a keyword.
    Word,
    Number,
    /// With its quotes.
    Text,
    Sign,
}
use TokenKind::{Number, Sign, Text, Word};

#[derive(Clone, Copy, Debug)]
struct Token<'a> {
    kind: TokenKind,
    text: &'a str,
    line: usize,
}

/// The tokens of a text without comments.
fn tokens(text: &str) -> Vec<Token<'_>> {
    let mut tokens = Vec::new();
    let (mut rest, mut line) = (text.strip_prefix('\u{feff}').unwrap_or(text), 1);
    while let Some(c) = rest.chars().next() {
        let is_word = |c: char| c.is_alphanumeric() || c == '_' || c == ':';
        let end_of = |is_in: &dyn Fn(char) -> bool| rest.find(|c| !is_in(c)).unwrap_or(rest.len());
        let (kind, length) = if rest.starts_with("//") {
            (None, end_of(&|c| c != '\n'))
        } else if rest.starts_with("/*") {
            (None, rest.find("*/").map_or(rest.len(), |end| end + 2))
        } else if c.is_whitespace() {
            (None, end_of(&char::is_whitespace))
        } else if c == '"' {
            (Some(Text), end_of_string(rest))
        } else if c.is_ascii_digit() || (c == '.' && rest[1..].starts_with(|c: char| c.is_ascii_digit())) {
            (Some(Number), end_of_number(rest))
        } else if c.is_alphabetic() || c == '_' || rest.starts_with("::") {
            let length = end_of(&is_word);
            // A single colon ends the name of an argument.
            let name = &rest[..length];
            let single = name.char_indices().filter(|(_, c)| *c == ':').map(|(at, _)| at);
            let single = single.into_iter().find(|at| !name[at + 1..].starts_with(':') && !name[..*at].ends_with(':'));
            (Some(Word), single.unwrap_or(length))
        } else {
            (Some(Sign), c.len_utf8())
        };
        let length = length.max(c.len_utf8());
        if let Some(kind) = kind {
            tokens.push(Token { kind, text: &rest[..length], line });
        }
        line += rest[..length].matches('\n').count();
        rest = &rest[length..];
    }
    tokens
}

fn end_of_string(text: &str) -> usize {
    let mut is_escaped = false;
    for (at, c) in text.char_indices().skip(1) {
        match c {
            _ if is_escaped => is_escaped = false,
            '\\' => is_escaped = true,
            '"' => return at + 1,
            _ => {}
        }
    }
    text.len()
}

/// Digits, a point, an exponent with its sign, and a suffix of the type.
fn end_of_number(text: &str) -> usize {
    let bytes = text.as_bytes();
    let mut at = 0;
    while at < bytes.len() {
        let is_sign = matches!(bytes[at], b'+' | b'-') && at > 0 && matches!(bytes[at - 1], b'e' | b'E');
        if !(bytes[at].is_ascii_alphanumeric() || bytes[at] == b'.' || is_sign) {
            break;
        }
        at += 1;
    }
    at
}

struct Parser<'a> {
    tokens: &'a [Token<'a>],
    at: usize,
    name: &'a str,
}

/// Arguments of a call: the name, and what stands for its value.
type Arguments<'a> = Vec<(&'a str, &'a [Token<'a>])>;

impl<'a> Parser<'a> {
    fn broken(&self, expected: &'static str) -> MdlError {
        let line = self.tokens.get(self.at).or(self.tokens.last()).map_or(1, |token| token.line);
        MdlError::Broken { material: self.name.to_owned(), expected, line }
    }

    fn take(&mut self, text: &str) -> bool {
        let is = self.tokens.get(self.at).is_some_and(|token| token.text == text);
        self.at += usize::from(is);
        is
    }

    /// The tokens up to the bracket that closes the one just taken, which is passed as well.
    fn inside(&mut self) -> Result<&'a [Token<'a>], MdlError> {
        let start = self.at;
        let mut depth = 1usize;
        while let Some(token) = self.tokens.get(self.at) {
            match token.text {
                "(" | "[" | "{" if token.kind == Sign => depth += 1,
                ")" | "]" | "}" if token.kind == Sign => depth -= 1,
                _ => {}
            }
            self.at += 1;
            if depth == 0 {
                return Ok(&self.tokens[start..self.at - 1]);
            }
        }
        Err(self.broken("a closing bracket"))
    }

    /// The material after its name.
    fn material(mut self) -> Result<Imported, MdlError> {
        if !self.take("(") {
            return Err(self.broken("`(*)`"));
        }
        let parameters = self.inside()?;
        let mut annotations: &[Token<'_>] = &[];
        if self.take("[") {
            annotations = self.inside()?;
        }
        if !self.take("=") {
            return Err(self.broken("`=`"));
        }
        let callee = self.tokens.get(self.at).ok_or_else(|| self.broken("a call"))?;
        self.at += 1;
        let is_known = [ADOBE, ADOBE.trim_start_matches(':'), OWN].contains(&callee.text);
        let has_parameters = !matches!(parameters, [star] if star.text == "*");
        if !is_known || has_parameters || !self.take("(") {
            let found = if has_parameters { "a material with parameters of its own" } else { callee.text };
            return Err(MdlError::OtherCall { material: self.name.to_owned(), found: found.chars().take(80).collect() });
        }
        let arguments = self.inside()?;
        if !self.take(";") {
            return Err(self.broken("`;`"));
        }
        let arguments = self.arguments(arguments)?;
        let mut notes = Notes::new();
        match native_copy(annotations, &mut notes) {
            Some(material) => Ok(merged(material, &arguments, notes)),
            None => self.plain(&arguments, notes),
        }
    }

    fn arguments(&self, tokens: &'a [Token<'a>]) -> Result<Arguments<'a>, MdlError> {
        let mut arguments = Vec::new();
        let (mut depth, mut start) = (0usize, 0);
        for (at, token) in tokens.iter().enumerate() {
            match token.text {
                "(" | "[" | "{" if token.kind == Sign => depth += 1,
                ")" | "]" | "}" if token.kind == Sign => depth = depth.saturating_sub(1),
                _ => {}
            }
            let is_end = at + 1 == tokens.len();
            if is_end || (depth == 0 && token.text == ",") {
                let argument = &tokens[start..if is_end { at + 1 } else { at }];
                start = at + 1;
                match argument {
                    [name, colon, value @ ..] if name.kind == Word && colon.text == ":" && !value.is_empty() => {
                        arguments.push((name.text, value));
                    }
                    _ => return Err(self.broken("arguments as `name: value`")),
                }
            }
        }
        Ok(arguments)
    }

    /// The material of a call without a native copy.
    fn plain(&self, arguments: &Arguments<'_>, mut notes: Notes) -> Result<Imported, MdlError> {
        let mut material = Material::named(self.name);
        for (name, value) in arguments {
            let Some(property) = Property::from_name(name) else {
                notes.push(format!("`{}` is no property of ASM; not read", short(name)));
                continue;
            };
            let kind = property.def().default.kind();
            match constant(kind, value) {
                Some(value) => _ = material.set(property, value),
                None => {
                    return Err(MdlError::NotConstant {
                        material: self.name.to_owned(),
                        argument: (*name).to_owned(),
                        expected: kind.expectation(),
                    });
                }
            }
        }
        notes.truncate(MAX_NOTES);
        Ok(Imported { material, notes })
    }
}

/// The material in the annotation.
fn native_copy(annotations: &[Token<'_>], notes: &mut Notes) -> Option<Material> {
    let copy = annotations.windows(3).find_map(|tokens| match tokens {
        [name, open, text] if name.text.rsplit("::").next() == Some(ANNOTATION) && open.text == "(" && text.kind == Text => {
            Some(text)
        }
        _ => None,
    })?;
    let json = serde_json::from_str::<String>(copy.text).ok().and_then(|text| serde_json::from_str(&text).ok());
    let Some(json) = json else {
        notes.push("the native copy is no JSON: the call is read instead".to_owned());
        return None;
    };
    native::read(&json, None, notes).map(|native| native.material)
}

/// The native copy, with what somebody changed in the call since. An expression says what the copy says.
fn merged(mut material: Material, arguments: &Arguments<'_>, mut notes: Notes) -> Imported {
    for (name, tokens) in arguments {
        let Some(property) = Property::from_name(name) else {
            notes.push(format!("`{}` is no property of ASM; not read", short(name)));
            continue;
        };
        let Some(value) = constant(property.def().default.kind(), tokens) else { continue };
        let slot = material.slot_mut(property);
        // Of an image without a file the call has the uniform value.
        if slot.value != Some(value) {
            notes.push(format!("{name}: the call was changed by hand; its value holds"));
            (slot.value, slot.texture) = (Some(value), None);
        }
    }
    let unsaid: Vec<Property> = material
        .slots()
        .filter(|(property, slot)| {
            let is_written = slot.texture.is_none() && slot.value.and_then(super::literal).is_some();
            is_written && !arguments.iter().any(|(name, _)| *name == property.def().name)
        })
        .map(|(property, _)| property)
        .collect();
    for property in unsaid {
        notes.push(format!("{}: the call does not say it any more; it has its default", property.def().name));
        material.slot_mut(property).value = None;
    }
    notes.truncate(MAX_NOTES);
    Imported { material, notes }
}

/// A constant of this kind: a number, a truth, `color(...)`.
fn constant(kind: Kind, tokens: &[Token<'_>]) -> Option<Value> {
    match kind {
        Kind::Bool => match tokens {
            [one] if one.text == "true" => Some(Value::Bool(true)),
            [one] if one.text == "false" => Some(Value::Bool(false)),
            _ => None,
        },
        Kind::Float => number(tokens).map(Value::Float),
        Kind::Color => {
            let [name, open, inside @ .., close] = tokens else { return None };
            if name.text != "color" || open.text != "(" || close.text != ")" {
                return None;
            }
            let numbers: Option<Vec<f64>> = inside.split(|token| token.text == ",").map(number).collect();
            match numbers?.as_slice() {
                [grey] => Some(Value::Color([*grey; 3])),
                [r, g, b] => Some(Value::Color([*r, *g, *b])),
                _ => None,
            }
        }
        Kind::Normal => None,
    }
}

fn number(tokens: &[Token<'_>]) -> Option<f64> {
    let (sign, digits) = match tokens {
        [digits] => (1.0, digits),
        [minus, digits] if minus.text == "-" => (-1.0, digits),
        _ => return None,
    };
    if digits.kind != Number {
        return None;
    }
    let digits = digits.text.trim_end_matches(['f', 'F', 'd', 'D']);
    digits.parse::<f64>().ok().filter(|x| x.is_finite()).map(|x| sign * x)
}
