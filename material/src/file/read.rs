//! Reading: spans to values, and a warning for everything that is not as expected.

mod foreign;
mod texture;

use std::collections::HashMap;
use std::ops::Range;

use serde::de::IgnoredAny;

use super::tree::{self, Block, Lines, Node};
use super::{ASM_VERSION, FileError, MaterialFile, Unreadable, ValueSource, Warning};
use crate::material::Material;
use crate::properties::{PROPERTIES, Property};
use crate::value::{Kind, Value};

/// Warnings beyond this number are counted, not listed, so that a strange file cannot fill the memory with messages.
const MAX_WARNINGS: usize = 1000;

/// Reads a text of any size.
pub(super) fn read(text: String) -> Result<(MaterialFile, Vec<Warning>), FileError> {
    let body = if text.starts_with('\u{feff}') { '\u{feff}'.len_utf8() } else { 0 };
    let top = tree::block(&text, body..text.len()).map_err(|error| not_a_file(&text[body..], error))?;
    if text.as_bytes()[top.open] != b'{' {
        let (line, column) = Lines::of(&text).place(top.open);
        return Err(FileError::NotMap { line, column });
    }
    let mut reader = Reader::new(&text);
    let properties = reader.top(&top)?;
    let Reader { material, unreadable, unknown, unknown_spans, warnings, more_warnings, .. } = reader;
    let mut warnings = warnings;
    if let (true, Some(last)) = (more_warnings > 0, warnings.last()) {
        let message = format!("{more_warnings} more warnings are not listed");
        warnings.push(Warning { key: "file".into(), message, is_refused: false, ..last.clone() });
    }
    Ok((MaterialFile { text, material, top, properties, unreadable, unknown, unknown_spans }, warnings))
}

fn not_a_file(body: &str, error: ron::error::SpannedError) -> FileError {
    let place = error.span.end;
    if error.code == ron::Error::ExpectedMap && ron::from_str::<IgnoredAny>(body).is_ok() {
        return FileError::NotMap { line: place.line, column: place.col };
    }
    // ron begins its sentences with a capital letter; here they follow a colon.
    let mut message = error.code.to_string();
    if let Some(first) = message.get_mut(..1) {
        first.make_ascii_lowercase();
    }
    FileError::NotRon { line: place.line, column: place.col, message }
}

struct Reader<'a> {
    text: &'a str,
    lines: Lines<'a>,
    material: Material,
    unreadable: Vec<Unreadable>,
    unknown: Vec<String>,
    unknown_spans: Vec<Range<usize>>,
    warnings: Vec<Warning>,
    more_warnings: usize,
}

impl<'a> Reader<'a> {
    fn new(text: &'a str) -> Self {
        Self {
            text,
            lines: Lines::of(text),
            material: Material::default(),
            unreadable: Vec::new(),
            unknown: Vec::new(),
            unknown_spans: Vec::new(),
            warnings: Vec::new(),
            more_warnings: 0,
        }
    }

    fn top(&mut self, top: &Block) -> Result<Option<Block>, FileError> {
        self.expect_unique(top, "")?;
        let mut properties = None;
        if top.get("asm").is_none() {
            self.warn(top.open, "asm", format!("expected \"{ASM_VERSION}\", found no version; read as {ASM_VERSION}"));
        }
        for node in &top.nodes {
            match node.key.as_str() {
                _ if !node.is_name => self.unknown_key("", node, "expected a key in quotes"),
                "asm" => {
                    if self.string(node).as_deref() != Some(ASM_VERSION) {
                        let found = self.excerpt(&node.value);
                        self.warn(
                            node.value.start,
                            "asm",
                            format!("expected \"{ASM_VERSION}\", found {found}; read as {ASM_VERSION}"),
                        );
                    }
                }
                "name" => self.material.name = self.text_entry(node, "name"),
                "notes" => self.material.notes = self.text_entry(node, "notes"),
                "aliases" => self.material.aliases = self.texts(node, "aliases"),
                "tags" => self.material.tags = self.texts(node, "tags"),
                "unit_mm" => match number(self.text, &node.value) {
                    Ok(value) => {
                        self.material.unit_mm = Some(value);
                        self.warn_underflow(&node.value, value, "unit_mm");
                    }
                    Err(reason) => self.refuse(&node.value, "unit_mm", &reason),
                },
                "provenance" => self.provenance(node)?,
                "properties" => match self.map(node) {
                    Some(block) => {
                        self.properties(&block)?;
                        properties = Some(block);
                    }
                    None => self.refuse_kind(node, "properties", "a map { … } of properties"),
                },
                "foreign" => self.foreign(node)?,
                "sources" => {}
                _ => self.unknown_key("", node, "unknown key"),
            }
        }
        Ok(properties)
    }

    fn provenance(&mut self, node: &Node) -> Result<(), FileError> {
        let Some(block) = self.map(node) else {
            self.refuse_kind(node, "provenance", "a map { … } of texts");
            return Ok(());
        };
        self.expect_unique(&block, "provenance")?;
        for node in &block.nodes {
            let key = format!("provenance.{}", node.key);
            match node.key.as_str() {
                "source" if node.is_name => self.material.provenance.source = self.text_entry(node, &key),
                "reference" if node.is_name => self.material.provenance.reference = self.text_entry(node, &key),
                "method" if node.is_name => self.material.provenance.method = self.text_entry(node, &key),
                "licence" if node.is_name => self.material.provenance.licence = self.text_entry(node, &key),
                _ => self.unknown_key("provenance", node, "unknown key"),
            }
        }
        Ok(())
    }

    fn properties(&mut self, block: &Block) -> Result<(), FileError> {
        self.expect_unique(block, "properties")?;
        for node in &block.nodes {
            match Property::from_name(&node.key).filter(|_| node.is_name) {
                Some(property) => self.property(property, node)?,
                None => match PROPERTIES.iter().find(|def| def.is_named(&node.key)) {
                    Some(def) => self.unknown_key("properties", node, &format!("expected the formal name {:?}", def.name)),
                    None => self.unknown_key("properties", node, "unknown property"),
                },
            }
        }
        Ok(())
    }

    fn property(&mut self, property: Property, node: &Node) -> Result<(), FileError> {
        let name = property.def().name;
        let Some(block) = self.map(node) else {
            self.material.slot_mut(property).value = self.value(property, &node.value, name);
            return Ok(());
        };
        self.expect_unique(&block, name)?;
        for node in &block.nodes {
            match node.key.as_str() {
                "value" if node.is_name => {
                    self.material.slot_mut(property).value = self.value(property, &node.value, name);
                }
                "texture" if node.is_name => {
                    self.material.slot_mut(property).texture = self.texture(property, node)?;
                }
                _ => self.unknown_key(name, node, "unknown key"),
            }
        }
        Ok(())
    }

    fn value(&mut self, property: Property, span: &Range<usize>, key: &str) -> Option<Value> {
        match value(self.text, span, property.def().default.kind()) {
            Ok(value) => {
                let mut spans = vec![span.clone()];
                if let Some(block) = tree::block_of(self.text, span, b"([") {
                    spans = block.nodes.into_iter().map(|node| node.value).collect();
                }
                for (number, span) in value.numbers().iter().zip(&spans) {
                    self.warn_underflow(span, *number, key);
                }
                Some(value)
            }
            Err(reason) => {
                self.refuse_of(property, span, key, &reason);
                None
            }
        }
    }

    fn texts(&mut self, node: &Node, key: &str) -> Vec<String> {
        let items = tree::block_of(self.text, &node.value, b"[");
        let words: Option<Vec<_>> = items.and_then(|block| block.nodes.iter().map(|node| self.string(node)).collect());
        words.unwrap_or_else(|| {
            self.refuse_kind(node, key, "a list [\"…\"] of texts");
            Vec::new()
        })
    }

    fn text_entry(&mut self, node: &Node, key: &str) -> String {
        self.string(node).unwrap_or_else(|| {
            self.refuse_kind(node, key, "a text in quotes");
            String::new()
        })
    }

    fn string(&self, node: &Node) -> Option<String> {
        tree::string(&self.text[node.value.clone()])
    }

    fn map(&self, node: &Node) -> Option<Block> {
        tree::block_of(self.text, &node.value, b"{")
    }

    fn excerpt(&self, span: &Range<usize>) -> String {
        excerpt(&self.text[span.clone()])
    }

    /// Two equal keys: which one would an edit change, and which one holds?
    fn expect_unique(&self, block: &Block, above: &str) -> Result<(), FileError> {
        let mut first: HashMap<&str, usize> = HashMap::with_capacity(block.nodes.len());
        for node in block.nodes.iter().filter(|node| node.is_name) {
            if let Some(start) = first.insert(&node.key, node.start) {
                let (line, first_line) = (self.lines.place(node.start).0, self.lines.place(start).0);
                return Err(FileError::DuplicateKey { line, first_line, key: path(above, &excerpt(&node.key)) });
            }
        }
        Ok(())
    }

    fn unknown_key(&mut self, above: &str, node: &Node, what: &str) {
        let key = path(above, &excerpt(&node.key));
        self.warn(node.start, &key, format!("{what}; kept in the file"));
        self.unknown.push(key);
        self.unknown_spans.push(node.value.clone());
    }

    fn refuse_kind(&mut self, node: &Node, key: &str, expected: &str) {
        let found = self.excerpt(&node.value);
        self.refuse(&node.value, key, &format!("expected {expected}, found {found}"));
    }

    fn refuse_of(&mut self, property: Property, span: &Range<usize>, key: &str, reason: &str) {
        let (line, text) = (self.lines.place(span.start).0, self.excerpt(span));
        self.unreadable.push(Unreadable { property, text, line, reason: reason.into() });
        self.refuse(span, key, reason);
    }

    fn refuse(&mut self, span: &Range<usize>, key: &str, reason: &str) {
        self.push(span.start, key, format!("{reason}; kept in the file, default used"), true);
    }

    fn warn(&mut self, at: usize, key: &str, message: String) {
        self.push(at, key, message, false);
    }

    /// A number that is not 0 as written but too small for an `f64`.
    fn warn_underflow(&mut self, span: &Range<usize>, value: f64, key: &str) {
        let mantissa = self.text[span.clone()].split(['e', 'E']).next().unwrap_or_default();
        if value == 0.0 && mantissa.contains(|c: char| matches!(c, '1'..='9')) {
            let found = self.excerpt(span);
            self.warn(span.start, key, format!("expected a number from 5e-324 on, found {found}; used as 0"));
        }
    }

    fn push(&mut self, at: usize, key: &str, message: String, is_refused: bool) {
        // A refusal is always listed: it decides whether the command line stops. There are few keys that can be refused.
        if self.warnings.len() >= MAX_WARNINGS && !is_refused {
            self.more_warnings += 1;
            return;
        }
        let (line, column) = self.lines.place(at);
        self.warnings.push(Warning { line, column, key: key.into(), message, is_refused });
    }
}

fn path(above: &str, key: &str) -> String {
    if above.is_empty() { key.into() } else { format!("{above}.{key}") }
}

/// The text on one line, shortened if it is long.
fn excerpt(text: &str) -> String {
    const LENGTH: usize = 60;
    let mut line: String = text.chars().take(LENGTH).map(|c| if c.is_control() { ' ' } else { c }).collect();
    if text.chars().nth(LENGTH).is_some() {
        line.push('…');
    }
    line
}

/// The finite number in a span, or what was expected and found.
fn number(text: &str, span: &Range<usize>) -> Result<f64, String> {
    let ron = &text[span.clone()];
    match ron::from_str::<f64>(ron) {
        Ok(value) if value.is_finite() => Ok(value),
        Ok(_) => Err(format!("expected a finite number, found {}", excerpt(ron))),
        Err(_) => Err(format!("expected a number, found {}", excerpt(ron))),
    }
}

/// The finite numbers of a list or tuple; `None` if the count or one of them is not as expected.
pub(super) fn numbers<const N: usize>(text: &str, span: &Range<usize>) -> Option<[f64; N]> {
    let block = tree::block_of(text, span, b"([")?;
    let numbers: Option<Vec<f64>> = block.nodes.iter().take(N + 1).map(|node| number(text, &node.value).ok()).collect();
    numbers?.try_into().ok()
}

/// The value of a kind in a span, or what was expected and found.
fn value(text: &str, span: &Range<usize>, kind: Kind) -> Result<Value, String> {
    let ron = &text[span.clone()];
    let wrong = || format!("expected {}, found {}", kind.expectation(), excerpt(ron));
    match kind {
        Kind::Float => number(text, span).map(Value::Float),
        Kind::Bool => ron::from_str(ron).map(Value::Bool).map_err(|_| wrong()),
        Kind::Color => numbers(text, span).map(Value::Color).ok_or_else(wrong),
        Kind::Normal => numbers(text, span).map(Value::Normal).ok_or_else(wrong),
    }
}

/// Where the value of one property comes from.
pub(super) fn source_of(text: &str, top: &Block, property: Property) -> Option<ValueSource> {
    let sources = tree::block_of(text, &top.get("sources")?.value, b"{")?;
    let source = tree::block_of(text, &sources.get(property.def().name)?.value, b"{")?;
    let word = |key| source.get(key).and_then(|node| tree::string(&text[node.value.clone()])).unwrap_or_default();
    let kind = property.def().default.kind();
    let spread = |key| source.get(key).and_then(|node| value(text, &node.value, kind).ok());
    Some(ValueSource {
        dataset: word("dataset"),
        paper: word("paper"),
        method: word("method"),
        licence: word("licence"),
        spread_min: spread("spread_min"),
        spread_max: spread("spread_max"),
    })
}

/// Key and text of all that stands under `sources`.
pub(super) fn sources<'a>(text: &'a str, top: &Block) -> Vec<(String, &'a str)> {
    let Some(node) = top.get("sources") else { return Vec::new() };
    match tree::block_of(text, &node.value, b"{") {
        Some(block) => block.nodes.iter().map(|node| (format!("sources.{}", node.key), &text[node.value.clone()])).collect(),
        None => vec![("sources".to_owned(), &text[node.value.clone()])],
    }
}
