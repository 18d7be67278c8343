//! usda text to a tree.
//!
//! One layer is read: files that it refers to are named in notes and not followed. Of variants the selected one counts; of values that
//! change over time, the first. Prims are parsed without recursion, values with a bounded one.

use std::borrow::Cow;
use std::collections::HashMap;

use super::error::{
    MAX_ATTRIBUTES, MAX_DEPTH, MAX_ENTRIES, MAX_NAME_BYTES, MAX_PRIMS, MAX_USDA_BYTES, MAX_VARIANT_SETS, UsdError,
};
use super::layer::{Attribute, Entries, Layer, Prim, PrimId, Value, entry};
use super::lex::{Lexer, Token};
use crate::exchange::short::short;

/// Parses the text of a layer.
pub fn parse(text: &str) -> Result<Layer<'_>, UsdError> {
    if text.len() > MAX_USDA_BYTES {
        return Err(UsdError::TooLarge { bytes: text.len() });
    }
    let body = text.trim_start_matches('\u{feff}');
    if !body.starts_with("#usda ") {
        return Err(UsdError::NotUsd);
    }
    let mut parser = Parser {
        lexer: Lexer::new(body),
        token: Token::End,
        line: 1,
        layer: empty(),
        frames: vec![Frame::Prim(Layer::ROOT)],
        variant_sets: 0,
    };
    parser.advance()?;
    if parser.token == Token::Mark(b'(') {
        let line = parser.line;
        let metadata = parser.metadata()?;
        parser.tell_of_arcs(line, None, &metadata);
        parser.layer.prims[0].metadata = metadata;
    }
    while parser.statement()? {}
    Ok(parser.layer)
}

fn empty<'a>() -> Layer<'a> {
    Layer {
        prims: vec![empty_prim()],
        attributes: Vec::new(),
        prim_places: HashMap::new(),
        attribute_places: HashMap::new(),
        notes: Vec::new(),
        more_notes: 0,
    }
}

fn empty_prim<'a>() -> Prim<'a> {
    Prim {
        name: Cow::Borrowed(""),
        type_name: "",
        parent: Layer::ROOT,
        children: Vec::new(),
        attributes: Vec::new(),
        metadata: Vec::new(),
        is_defined: true,
    }
}

/// What an open brace belongs to.
enum Frame<'a> {
    Prim(PrimId),
    VariantSet(PrimId, Option<Cow<'a, str>>),
    Variant(PrimId),
}

/// Reads tokens into a layer. Values are read by [`super::values`].
pub(super) struct Parser<'a> {
    lexer: Lexer<'a>,
    /// The next token.
    pub token: Token<'a>,
    /// Line of the token.
    pub line: usize,
    pub layer: Layer<'a>,
    frames: Vec<Frame<'a>>,
    variant_sets: usize,
}

/// What a statement does to a list of the layers below.
pub(super) const OPERATIONS: [&str; 5] = ["prepend", "append", "add", "delete", "reorder"];
/// Metadata that bring in what another prim or file says.
const ARCS: [&str; 6] = ["references", "payload", "inherits", "specializes", "subLayers", "clips"];

impl<'a> Parser<'a> {
    /// Takes the token and reads the next one.
    pub fn advance(&mut self) -> Result<Token<'a>, UsdError> {
        let next = self.lexer.next()?;
        self.line = self.lexer.line;
        Ok(std::mem::replace(&mut self.token, next))
    }

    /// The error of a token that stands in another's place.
    pub fn expected<T>(&self, what: &str) -> Result<T, UsdError> {
        Err(UsdError::Syntax { line: self.line, message: format!("expected {what}, found {}", self.token.shown()) })
    }

    /// The error of a limit that was passed.
    pub fn too_much<T>(&self, what: String) -> Result<T, UsdError> {
        Err(UsdError::TooMuch { line: self.line, what })
    }

    /// Takes this bracket or separator.
    pub fn mark(&mut self, mark: u8) -> Result<(), UsdError> {
        if self.token != Token::Mark(mark) {
            return self.expected(&format!("`{}`", char::from(mark)));
        }
        self.advance().map(|_| ())
    }

    /// Takes this bracket or separator if it is there.
    pub fn take_mark(&mut self, mark: u8) -> Result<bool, UsdError> {
        let is_there = self.token == Token::Mark(mark);
        if is_there {
            self.advance()?;
        }
        Ok(is_there)
    }

    /// Takes a word.
    pub fn word(&mut self, what: &str) -> Result<&'a str, UsdError> {
        match self.token {
            Token::Word(word) => self.advance().map(|_| word),
            _ => self.expected(what),
        }
    }

    /// Takes a quoted text.
    pub fn text(&mut self, what: &str) -> Result<Cow<'a, str>, UsdError> {
        match self.token.clone() {
            Token::Text(text) => self.advance().map(|_| text),
            _ => self.expected(what),
        }
    }

    fn push(&mut self, frame: Frame<'a>) -> Result<(), UsdError> {
        if self.frames.len() > MAX_DEPTH {
            return self.too_much(format!("{MAX_DEPTH} prims inside each other"));
        }
        self.frames.push(frame);
        Ok(())
    }

    /// Reads one statement; false at the end of the text.
    fn statement(&mut self) -> Result<bool, UsdError> {
        let (prim, is_weak, selected) = match self.frames.last() {
            Some(Frame::Prim(prim)) => (*prim, self.is_in_variant(), None),
            Some(Frame::Variant(prim)) => (*prim, true, None),
            Some(Frame::VariantSet(prim, selected)) => (*prim, true, Some(selected.clone())),
            None => return Ok(false),
        };
        match (&self.token, selected) {
            (Token::End, _) if self.frames.len() == 1 => return Ok(false),
            (Token::Mark(b'}'), _) if self.frames.len() > 1 => {
                self.advance()?;
                self.frames.pop();
            }
            (Token::Text(_), Some(selected)) => {
                let name = self.text("the name of a variant")?;
                if self.token == Token::Mark(b'(') {
                    self.metadata()?;
                }
                if selected.as_ref() == Some(&name) {
                    self.mark(b'{')?;
                    self.push(Frame::Variant(prim))?;
                } else {
                    self.skip_block(b'{', b'}')?;
                }
            }
            (_, Some(_)) => return self.expected("the name of a variant, or `}`"),
            (Token::Word(word @ ("def" | "over" | "class")), None) => {
                let word = *word;
                self.prim(prim, word)?;
            }
            (Token::Word("variantSet"), None) => {
                self.advance()?;
                let name = self.text("the name of a set of variants")?;
                self.mark(b'=')?;
                self.mark(b'{')?;
                self.variant_sets += 1;
                if self.variant_sets > MAX_VARIANT_SETS {
                    return self.too_much(format!("{MAX_VARIANT_SETS} sets of variants"));
                }
                let selection = entry(&self.layer.prim(prim).metadata, "variants").and_then(Value::entries);
                let selected = selection.and_then(|entries| entry(entries, &name)).and_then(|value| value.texts().first());
                let selected = selected.filter(|name| name.len() <= MAX_NAME_BYTES).cloned();
                if selected.is_none() {
                    let what = format!("no variant of `{}` is selected; none is read", short(&name));
                    self.layer.note(self.line, Some(prim), &what);
                }
                self.push(Frame::VariantSet(prim, selected))?;
            }
            (Token::Word(_), None) => self.property(prim, is_weak)?,
            _ if self.frames.len() == 1 => return self.expected("`def`, `over` or `class`"),
            _ => return self.expected("a prim, a property, or `}`"),
        }
        Ok(true)
    }

    fn is_in_variant(&self) -> bool {
        self.frames.iter().any(|frame| matches!(frame, Frame::Variant(_)))
    }

    fn prim(&mut self, parent: PrimId, specifier: &str) -> Result<(), UsdError> {
        self.advance()?;
        let type_name = if let Token::Word(_) = self.token { self.word("a type")? } else { "" };
        let line = self.line;
        let name = self.text("the name of a prim in quotes")?;
        if name.len() > MAX_NAME_BYTES {
            return self.too_much(format!("{MAX_NAME_BYTES} bytes in the name of a prim"));
        }
        let metadata = if self.token == Token::Mark(b'(') { self.metadata()? } else { Vec::new() };
        self.mark(b'{')?;
        let id = match self.layer.child(parent, &name) {
            Some(id) => id,
            None => self.add_prim(parent, name.clone())?,
        };
        self.tell_of_arcs(line, Some(id), &metadata);
        let is_active = entry(&metadata, "active").and_then(Value::number) != Some(0.0);
        let prim = &mut self.layer.prims[id as usize];
        if prim.type_name.is_empty() {
            prim.type_name = type_name;
        }
        prim.is_defined |= specifier == "def";
        prim.is_defined &= is_active;
        if prim.metadata.len() < MAX_ENTRIES {
            prim.metadata.extend(metadata);
        }
        self.push(Frame::Prim(id))
    }

    fn add_prim(&mut self, parent: PrimId, name: Cow<'a, str>) -> Result<PrimId, UsdError> {
        if self.layer.prims.len() > MAX_PRIMS {
            return self.too_much(format!("{MAX_PRIMS} prims"));
        }
        let id = self.layer.prims.len() as PrimId;
        self.layer.prims.push(Prim { name: name.clone(), parent, is_defined: false, ..empty_prim() });
        self.layer.prims[parent as usize].children.push(id);
        self.layer.prim_places.insert((parent, name), id);
        Ok(id)
    }

    fn tell_of_arcs(&mut self, line: usize, prim: Option<PrimId>, metadata: &Entries<'a>) {
        for (key, value) in metadata.iter().filter(|(key, value)| ARCS.contains(&key.as_ref()) && *value != Value::None) {
            let named = value.text().map(|text| format!(" `{}`", short(text))).unwrap_or_default();
            let what = format!("{key}{named}: not followed; export the scene flattened to have all of it");
            self.layer.note(line, prim, &what);
        }
    }

    fn property(&mut self, prim: PrimId, is_weak: bool) -> Result<(), UsdError> {
        let line = self.line;
        let mut word = self.word("a property")?;
        let mut is_deleted = false;
        while matches!(word, "custom" | "uniform" | "varying" | "config") || OPERATIONS.contains(&word) {
            is_deleted |= matches!(word, "delete" | "reorder");
            let next = self.word("a type")?;
            // `reorder nameChildren = […]` has no type.
            if word == "reorder" && self.token == Token::Mark(b'=') {
                self.advance()?;
                return self.value(0).map(|_| ());
            }
            word = next;
        }
        // `relocates = {…}` of older files.
        if self.take_mark(b'=')? {
            return self.value(0).map(|_| ());
        }
        if self.take_mark(b'[')? {
            self.mark(b']')?;
        }
        let name = self.word("the name of a property")?;
        let suffix = if self.take_mark(b'.')? { self.word("`connect` or `timeSamples`")? } else { "" };
        let (mut value, mut targets) = (None, Vec::new());
        if self.take_mark(b'=')? {
            match suffix {
                "connect" => targets = self.targets()?,
                "timeSamples" => value = self.samples()?,
                "spline" => self.skip_block(b'{', b'}')?,
                _ if word == "rel" => targets = self.targets()?,
                _ => value = Some(self.value(0)?),
            }
        }
        let metadata = if self.token == Token::Mark(b'(') { self.metadata()? } else { Vec::new() };
        if value.as_ref().is_some_and(|value| !value.is_finite()) {
            self.layer.note(line, Some(prim), &format!("{name}: expected finite numbers, found others; not read"));
            value = None;
        }
        if is_deleted {
            return Ok(());
        }
        let new = Attribute { name, type_name: word, value, targets, metadata, line, is_weak };
        if self.layer.attributes.len() > MAX_ATTRIBUTES {
            return self.too_much(format!("{MAX_ATTRIBUTES} properties"));
        }
        self.add_attribute(prim, new);
        Ok(())
    }

    /// Puts together what several statements say about one property. What the prim itself says counts more than a variant's word.
    fn add_attribute(&mut self, prim: PrimId, new: Attribute<'a>) {
        let Some(place) = self.layer.attribute_places.get(&(prim, new.name)) else {
            let place = self.layer.attributes.len() as u32;
            self.layer.attribute_places.insert((prim, new.name), place);
            self.layer.prims[prim as usize].attributes.push(place);
            return self.layer.attributes.push(new);
        };
        let old = &mut self.layer.attributes[*place as usize];
        let wins = old.is_weak || !new.is_weak;
        if new.value.is_some() && (wins || old.value.is_none()) {
            (old.value, old.type_name) = (new.value, new.type_name);
        }
        if !new.targets.is_empty() && (wins || old.targets.is_empty()) {
            old.targets = new.targets;
        }
        if old.metadata.len() < MAX_ENTRIES {
            old.metadata.extend(new.metadata);
        }
        old.is_weak &= new.is_weak;
    }
}
