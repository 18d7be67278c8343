//! XML, indented by two spaces.

use super::xml::escape;

/// A text that grows.
#[derive(Clone, Debug, Default)]
pub struct Xml {
    text: String,
    depth: usize,
}

/// An attribute and its value, unescaped.
pub type Attribute<'a> = (&'a str, &'a str);

impl Xml {
    /// An empty text whose elements will stand in this many others.
    pub fn inside(depth: usize) -> Self {
        Self { text: String::new(), depth }
    }

    /// Begins an element.
    pub fn open(&mut self, tag: &str, attributes: &[Attribute]) {
        self.tag(tag, attributes, ">");
        self.depth += 1;
    }

    /// Ends it.
    pub fn close(&mut self, tag: &str) {
        self.depth = self.depth.saturating_sub(1);
        self.text += &format!("{}</{tag}>\n", "  ".repeat(self.depth));
    }

    /// An element with nothing inside.
    pub fn empty(&mut self, tag: &str, attributes: &[Attribute]) {
        self.tag(tag, attributes, " />");
    }

    /// Text that is XML already.
    pub fn raw(&mut self, text: &str) {
        self.text += text;
    }

    /// The text.
    pub fn into_text(self) -> String {
        self.text
    }

    fn tag(&mut self, tag: &str, attributes: &[Attribute], end: &str) {
        self.text += &"  ".repeat(self.depth);
        self.text.push('<');
        self.text += tag;
        for (name, value) in attributes {
            self.text += &format!(" {name}=\"");
            escape(value, &mut self.text);
            self.text.push('"');
        }
        self.text += end;
        self.text.push('\n');
    }
}
