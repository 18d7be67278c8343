//! XML as a tree of elements and attributes, within bounds, however hostile the text is.
//!
//! Text between elements means nothing in MaterialX and is skipped. No entities are defined, no other file is opened.

use std::borrow::Cow;
use std::fmt;

use crate::exchange::short::short;

use quick_xml::XmlVersion;
use quick_xml::events::Event;
use quick_xml::events::attributes::Attributes;

/// Largest text that is read, bytes.
pub const MAX_BYTES: usize = 64 << 20;
/// Most elements of a document.
pub const MAX_ELEMENTS: usize = 1 << 20;
/// Most attributes of a document.
pub const MAX_ATTRIBUTES: usize = 1 << 22;
/// Most attributes of an element.
const MAX_ATTRIBUTES_EACH: usize = 256;
/// Deepest nesting; MaterialX needs five.
pub const MAX_DEPTH: usize = 64;

/// Why a text is no MaterialX document with a material. The caller adds the file name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ReadError {
    /// More text than a document can need.
    TooLarge {
        /// Size of the text.
        bytes: usize,
    },
    /// More elements or attributes than a document can need.
    TooMany {
        /// What there are too many of.
        what: &'static str,
        /// Most that are read.
        most: usize,
    },
    /// Elements in elements in elements.
    TooDeep {
        /// Line where it becomes too deep, from 1.
        line: usize,
    },
    /// The text is not well-formed XML.
    NotXml {
        /// Line of the fault, from 1.
        line: usize,
        /// What is wrong.
        message: String,
    },
    /// The text defines entities of its own, or takes them from another file.
    Entities {
        /// Line of the definition, from 1.
        line: usize,
    },
    /// XML of another kind.
    NotMaterialX {
        /// The outermost element; empty where there is none.
        found: String,
    },
    /// MaterialX without a material that can be read.
    NoMaterial {
        /// What stands there instead, in words for the user; may be empty.
        found: String,
    },
}

impl fmt::Display for ReadError {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::TooLarge { bytes } => write!(f, "expected a MaterialX file of at most {MAX_BYTES} bytes, found {bytes} bytes"),
            Self::TooMany { what, most } => write!(f, "expected at most {most} {what}, found more"),
            Self::TooDeep { line } => {
                write!(f, "line {line}: expected at most {MAX_DEPTH} elements inside each other, found more")
            }
            Self::NotXml { line, message } => write!(f, "line {line}: not valid XML: {message}"),
            Self::Entities { line } => {
                write!(f, "line {line}: expected no entities of its own in a MaterialX file, found a <!DOCTYPE> with some")
            }
            Self::NotMaterialX { found } if found.is_empty() => write!(f, "expected <materialx>, found no element"),
            Self::NotMaterialX { found } => write!(f, "expected <materialx>, found <{found}>"),
            Self::NoMaterial { found } if found.is_empty() => write!(f, "expected a surfacematerial, found none"),
            Self::NoMaterial { found } => write!(f, "expected a surfacematerial with a surface that can be read, found {found}"),
        }
    }
}

impl std::error::Error for ReadError {}

/// Number of an element in its tree.
pub type Id = u32;
const NONE: Id = Id::MAX;
/// The outermost element.
pub const ROOT: Id = 0;

/// One element.
#[derive(Clone, Debug)]
struct Element<'a> {
    tag: &'a str,
    attributes: std::ops::Range<u32>,
    parent: Id,
    first: Id,
    last: Id,
    next: Id,
}

/// The elements of a document in the order of its text.
#[derive(Clone, Debug, Default)]
pub struct Tree<'a> {
    elements: Vec<Element<'a>>,
    attributes: Vec<(&'a str, Cow<'a, str>)>,
}

impl<'a> Tree<'a> {
    /// Reads a document. Its outermost element has the number [`ROOT`].
    pub fn parse(text: &'a str) -> Result<Self, ReadError> {
        if text.len() > MAX_BYTES {
            return Err(ReadError::TooLarge { bytes: text.len() });
        }
        let text = text.trim_start_matches('\u{feff}');
        let line = |at: usize| text.as_bytes().iter().take(at).filter(|byte| **byte == b'\n').count() + 1;
        let fault = |at: usize, message: String| ReadError::NotXml { line: line(at), message: short(&message) };
        let mut tree = Self::default();
        let mut reader = quick_xml::Reader::from_str(text);
        let mut open: Vec<Id> = Vec::new();
        loop {
            let start = reader.buffer_position() as usize;
            let event = reader.read_event().map_err(|error| fault(reader.error_position() as usize, error.to_string()))?;
            let end = reader.buffer_position() as usize;
            match event {
                Event::Start(_) | Event::Empty(_) => {
                    if open.len() >= MAX_DEPTH {
                        return Err(ReadError::TooDeep { line: line(start) });
                    }
                    if open.is_empty() && !tree.elements.is_empty() {
                        return Err(fault(start, "expected one outermost element, found another".to_owned()));
                    }
                    let is_empty = matches!(event, Event::Empty(_));
                    let inside = text.get(start..end).unwrap_or_default().trim_start_matches('<').trim_end_matches('>');
                    let inside = if is_empty { inside.trim_end_matches('/') } else { inside };
                    let id = tree.add(inside, open.last().copied()).map_err(|error| match error {
                        ReadError::NotXml { message, .. } => fault(start, message),
                        error => error,
                    })?;
                    if !is_empty {
                        open.push(id);
                    }
                }
                Event::End(_) => _ = open.pop(),
                Event::DocType(content) if content.contains(&b'[') || is_external(&content) => {
                    return Err(ReadError::Entities { line: line(start) });
                }
                Event::Eof if open.is_empty() => return Ok(tree),
                Event::Eof => return Err(fault(text.len(), "the text ends inside of an element".to_owned())),
                _ => {}
            }
        }
    }

    /// Adds the element that stands between `<` and `>` as the last child of another.
    fn add(&mut self, inside: &'a str, parent: Option<Id>) -> Result<Id, ReadError> {
        if self.elements.len() >= MAX_ELEMENTS {
            return Err(ReadError::TooMany { what: "elements", most: MAX_ELEMENTS });
        }
        let length = inside.find(|c: char| c.is_ascii_whitespace()).unwrap_or(inside.len());
        let fault = |message: String| ReadError::NotXml { line: 0, message };
        let first = self.attributes.len();
        for attribute in Attributes::new(inside, length) {
            let attribute = attribute.map_err(|error| fault(error.to_string()))?;
            if self.attributes.len() >= MAX_ATTRIBUTES {
                return Err(ReadError::TooMany { what: "attributes", most: MAX_ATTRIBUTES });
            }
            if self.attributes.len() - first >= MAX_ATTRIBUTES_EACH {
                return Err(ReadError::TooMany { what: "attributes of one element", most: MAX_ATTRIBUTES_EACH });
            }
            let key = std::str::from_utf8(attribute.key.0).map_err(|error| fault(error.to_string()))?;
            let value = attribute.normalized_value(XmlVersion::Explicit1_0).map_err(|error| fault(error.to_string()))?;
            self.attributes.push((key, value));
        }
        let id = self.elements.len() as Id;
        let attributes = first as u32..self.attributes.len() as u32;
        let tag = &inside[..length];
        self.elements.push(Element { tag, attributes, parent: parent.unwrap_or(NONE), first: NONE, last: NONE, next: NONE });
        if let Some(parent) = parent {
            let last = std::mem::replace(&mut self.elements[parent as usize].last, id);
            match last {
                NONE => self.elements[parent as usize].first = id,
                last => self.elements[last as usize].next = id,
            }
        }
        Ok(id)
    }

    /// Number of elements.
    pub fn len(&self) -> usize {
        self.elements.len()
    }

    /// Name of an element; empty for one that does not exist.
    pub fn tag(&self, id: Id) -> &'a str {
        self.elements.get(id as usize).map_or("", |element| element.tag)
    }

    /// The element around this one.
    pub fn parent(&self, id: Id) -> Option<Id> {
        self.elements.get(id as usize).map(|element| element.parent).filter(|parent| *parent != NONE)
    }

    /// An attribute of an element.
    pub fn attribute(&self, id: Id, name: &str) -> Option<&str> {
        let range = self.elements.get(id as usize)?.attributes.clone();
        let all = self.attributes.get(range.start as usize..range.end as usize)?;
        all.iter().find(|(key, _)| *key == name).map(|(_, value)| value.as_ref())
    }

    /// The attribute of this name of the element or of the nearest one around it.
    pub fn inherited(&self, id: Id, name: &str) -> Option<&str> {
        std::iter::successors(Some(id), |id| self.parent(*id)).find_map(|id| self.attribute(id, name))
    }

    /// The elements inside an element.
    pub fn children(&self, id: Id) -> impl Iterator<Item = Id> + '_ {
        let valid = |id: Id| if id == NONE { None } else { Some(id) };
        let first = self.elements.get(id as usize).and_then(|element| valid(element.first));
        std::iter::successors(first, move |id| self.elements.get(*id as usize).and_then(|element| valid(element.next)))
    }
}

/// Whether a document type takes its definitions from elsewhere.
fn is_external(content: &[u8]) -> bool {
    let text = String::from_utf8_lossy(content);
    text.split_ascii_whitespace().any(|word| word == "SYSTEM" || word == "PUBLIC")
}

/// Adds text to an attribute's value so that it reads back the same. Characters that XML cannot hold become spaces.
pub fn escape(text: &str, into: &mut String) {
    for c in text.chars() {
        match c {
            '&' => into.push_str("&amp;"),
            '<' => into.push_str("&lt;"),
            '>' => into.push_str("&gt;"),
            '"' => into.push_str("&quot;"),
            '\n' => into.push_str("&#10;"),
            '\r' => into.push_str("&#13;"),
            '\t' => into.push_str("&#9;"),
            c if (c as u32) < 0x20 || matches!(c, '\u{fffe}' | '\u{ffff}') => into.push(' '),
            c => into.push(c),
        }
    }
}
