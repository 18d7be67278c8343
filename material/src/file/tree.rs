//! Where things stand in the text: spans of keys, values and commas, as ron finds them.
//!
//! ron alone decides what valid RON is. Values are read as raw slices of the source, so their addresses give the
//! spans; the only thing scanned here is the whitespace and the comments between them.

use std::ops::Range;

use ron::Deserializer;
use ron::error::SpannedError;
use ron::value::RawValue;
use serde::Deserializer as _;
use serde::de::{MapAccess, SeqAccess, Visitor};

/// One entry of a map, or one item of a list (then without a key).
#[derive(Clone, Debug)]
pub(super) struct Node {
    /// The key, decoded if it is a string, else as written; empty for items.
    pub key: String,
    /// Whether the key is a string. Other keys mean nothing to this format and are kept.
    pub is_name: bool,
    /// Where the entry begins.
    pub start: usize,
    /// The value, without the comments around it.
    pub value: Range<usize>,
    /// The comma behind the value.
    pub comma: Option<usize>,
}

/// A map, list or tuple.
#[derive(Clone, Debug)]
pub(super) struct Block {
    /// The opening bracket.
    pub open: usize,
    /// The closing bracket.
    pub close: usize,
    /// Entries in the order of the text.
    pub nodes: Vec<Node>,
}

impl Block {
    /// The entry with this string as its key.
    pub fn find(&self, key: &str) -> Option<usize> {
        self.nodes.iter().position(|node| node.is_name && node.key == key)
    }

    /// The entry with this string as its key.
    pub fn get(&self, key: &str) -> Option<&Node> {
        self.find(key).map(|index| &self.nodes[index])
    }
}

type Raw<'a> = (Option<&'a RawValue>, &'a RawValue);

struct Entries;

impl<'de> Visitor<'de> for Entries {
    type Value = Vec<Raw<'de>>;

    fn expecting(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        f.write_str("a map or a list")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self::Value, A::Error> {
        let mut entries = Vec::new();
        while let Some((key, value)) = map.next_entry::<&RawValue, &RawValue>()? {
            entries.push((Some(key), value));
        }
        Ok(entries)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Self::Value, A::Error> {
        let mut items = Vec::new();
        while let Some(value) = seq.next_element::<&RawValue>()? {
            items.push((None, value));
        }
        Ok(items)
    }
}

/// The map, list or tuple that `span` of the text holds, or ron's complaint (its position counts from the span).
pub(super) fn block(text: &str, span: Range<usize>) -> Result<Block, SpannedError> {
    let source = &text[span.clone()];
    let mut ron = Deserializer::from_str(source)?;
    let open = span.end - ron.remainder().len();
    let raws = match text.as_bytes().get(open) {
        Some(b'[') => ron.deserialize_seq(Entries),
        Some(b'(') => ron.deserialize_tuple(0, Entries),
        _ => ron.deserialize_map(Entries),
    };
    let raws = raws.map_err(|error| ron.span_error(error))?;
    let close = span.end - ron.remainder().len() - 1;
    ron.end().map_err(|error| ron.span_error(error))?;

    let place = |raw: &RawValue| {
        let slice = raw.trim().get_ron();
        let start = slice.as_ptr() as usize - text.as_ptr() as usize;
        start..start + slice.len()
    };
    let nodes = raws.into_iter().map(|(key, value)| {
        let value = place(value);
        let after = skip_trivia(text, value.end);
        let comma = (text.as_bytes().get(after) == Some(&b',')).then_some(after);
        let Some(key) = key.map(place) else {
            return Node { key: String::new(), is_name: false, start: value.start, value, comma };
        };
        let word = string(&text[key.clone()]);
        Node { is_name: word.is_some(), key: word.unwrap_or_else(|| text[key.clone()].into()), start: key.start, value, comma }
    });
    Ok(Block { open, close, nodes: nodes.collect() })
}

/// The block in `span`, which is known to hold one value, if its first character is one of `brackets`.
pub(super) fn block_of(text: &str, span: &Range<usize>, brackets: &[u8]) -> Option<Block> {
    let first = text.as_bytes().get(span.start)?;
    if brackets.contains(first) { block(text, span.clone()).ok() } else { None }
}

/// The string that a piece of RON holds.
pub(super) fn string(ron: &str) -> Option<String> {
    ron::from_str(ron).ok()
}

/// The first place at or after `at` that is neither whitespace nor comment by RON's rules.
pub(super) fn skip_trivia(text: &str, mut at: usize) -> usize {
    loop {
        let rest = &text[at..];
        let trimmed = rest.trim_start_matches(is_whitespace);
        at += rest.len() - trimmed.len();
        match comment_length(trimmed) {
            0 => return at,
            length => at += length,
        }
    }
}

fn is_whitespace(c: char) -> bool {
    matches!(c, ' ' | '\t' | '\n' | '\r' | '\x0B' | '\x0C' | '\u{85}' | '\u{200E}' | '\u{200F}' | '\u{2028}' | '\u{2029}')
}

/// Length of the comment that `text` begins with: to the line feed, which is not part of it, or to the end of a block
/// comment with the comments nested in it; 0 without a comment.
pub(super) fn comment_length(text: &str) -> usize {
    if text.starts_with("//") {
        return text.find('\n').unwrap_or(text.len());
    }
    if !text.starts_with("/*") {
        return 0;
    }
    let bytes = text.as_bytes();
    let (mut level, mut at) = (0_usize, 0);
    while at < bytes.len() {
        match &bytes[at..(at + 2).min(bytes.len())] {
            b"/*" => (level, at) = (level + 1, at + 2),
            b"*/" => (level, at) = (level - 1, at + 2),
            _ => at += 1,
        }
        if level == 0 {
            break;
        }
    }
    at
}

/// Line starts of a text, so that a position is found without counting from the beginning each time.
pub(super) struct Lines<'a> {
    text: &'a str,
    starts: Vec<usize>,
}

impl<'a> Lines<'a> {
    pub fn of(text: &'a str) -> Self {
        let starts = std::iter::once(0).chain(text.match_indices('\n').map(|(at, _)| at + 1)).collect();
        Self { text, starts }
    }

    /// Line and column of a byte offset, both from 1; columns count characters.
    pub fn place(&self, offset: usize) -> (usize, usize) {
        let line = self.starts.partition_point(|start| *start <= offset);
        let start = self.starts[line - 1];
        (line, self.text[start..offset].trim_start_matches('\u{feff}').chars().count() + 1)
    }
}
