//! WGSL of our own as a tree: declarations, and the statements of functions. Knows what the files of `bsdf` use, and no more of the language.

/// A declaration at the outermost level.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Item {
    /// What it declares.
    pub name: String,
    /// Lines that stand directly above it, with `//`.
    pub comment: Vec<String>,
    pub kind: ItemKind,
}

#[derive(Clone, Debug, PartialEq)]
pub(super) enum ItemKind {
    /// Everything up to the body, and the body.
    Function {
        head: String,
        body: Vec<Node>,
    },
    Struct {
        members: Vec<Member>,
    },
    /// Constants and bindings: the whole text.
    Other(String),
}

/// A member of a struct.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Member {
    pub name: String,
    pub comment: Vec<String>,
    /// `name: type`.
    pub text: String,
}

/// A statement.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Node {
    /// Whether an empty line stands above it.
    pub has_gap: bool,
    pub comment: Vec<String>,
    pub kind: NodeKind,
}

#[derive(Clone, Debug, PartialEq)]
pub(super) enum NodeKind {
    /// Text with its semicolon; further lines are indented relative to the first.
    Simple(String),
    If {
        arms: Vec<(String, Vec<Node>)>,
        otherwise: Vec<Node>,
    },
    /// A loop, or a block of its own where the head is empty.
    Nested {
        head: String,
        body: Vec<Node>,
    },
}

/// The declarations of a text. Comments that an empty line parts from what follows are left out.
pub(super) fn parse(text: &str) -> Vec<Item> {
    let mut reader = Reader { text, at: 0 };
    let mut items = Vec::new();
    let mut comment = Vec::new();
    loop {
        if reader.skip_space() > 1 {
            comment.clear();
        }
        if let Some(line) = reader.comment() {
            comment.push(line);
            continue;
        }
        if reader.rest().is_empty() {
            return items;
        }
        let kind = if reader.rest().starts_with("fn ") {
            let head = reader.until('{');
            ItemKind::Function { head, body: reader.block() }
        } else if reader.rest().starts_with("struct ") {
            let head = reader.until('{');
            items.push(Item { name: declared(&head), comment: std::mem::take(&mut comment), kind: reader.members() });
            continue;
        } else {
            let text = reader.until(';');
            ItemKind::Other(text + ";")
        };
        let name = match &kind {
            ItemKind::Function { head, .. } => declared(head),
            ItemKind::Struct { .. } => String::new(),
            ItemKind::Other(text) => declared(text),
        };
        items.push(Item { name, comment: std::mem::take(&mut comment), kind });
    }
}

/// The name after the keyword of a declaration.
fn declared(text: &str) -> String {
    let mut words = words(text).map(|(_, word)| word);
    let is_keyword = |word: &&str| ["fn", "struct", "const", "var", "override"].contains(word);
    words.find(is_keyword);
    // The address space of a variable stands in between.
    words.find(|word| !["private", "uniform", "storage", "read", "read_write"].contains(word)).unwrap_or_default().to_owned()
}

/// Names and numbers in a text, with their places.
pub(super) fn words(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let is_part = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let mut at = 0;
    std::iter::from_fn(move || {
        let start = at + text[at..].find(is_part)?;
        let length = text[start..].find(|c| !is_part(c)).unwrap_or(text.len() - start);
        at = start + length;
        Some((start, &text[start..at]))
    })
}

struct Reader<'a> {
    text: &'a str,
    at: usize,
}

impl<'a> Reader<'a> {
    fn rest(&self) -> &'a str {
        &self.text[self.at..]
    }

    /// Passes white space; how many line ends it held.
    fn skip_space(&mut self) -> usize {
        let rest = self.rest();
        let space = &rest[..rest.len() - rest.trim_start().len()];
        self.at += space.len();
        space.matches('\n').count()
    }

    /// The comment that begins here.
    fn comment(&mut self) -> Option<String> {
        if !self.rest().starts_with("//") {
            return None;
        }
        let line = self.rest().lines().next()?;
        self.at += line.len();
        Some(line.trim_end().to_owned())
    }

    /// The text up to a character outside of brackets, which is passed as well. Further lines lose the indentation of the first.
    fn until(&mut self, end: char) -> String {
        let line_start = self.text[..self.at].rfind('\n').map_or(0, |place| place + 1);
        let indent = self.at - line_start;
        let mut depth = 0usize;
        let found = self.rest().char_indices().find(|(_, c)| {
            match c {
                '(' | '[' => depth += 1,
                ')' | ']' => depth = depth.saturating_sub(1),
                // Members are types, in which these are brackets too.
                '<' if end == ',' => depth += 1,
                '>' if end == ',' => depth = depth.saturating_sub(1),
                _ => {}
            }
            depth == 0 && *c == end
        });
        let length = found.map_or(self.rest().len(), |(place, _)| place);
        let text = &self.rest()[..length];
        self.at = (self.at + length + end.len_utf8()).min(self.text.len());
        let shorter = |line: &str| line.chars().skip(indent.min(line.len() - line.trim_start().len())).collect::<String>();
        let lines = text.trim_end().split('\n').enumerate();
        lines.map(|(i, line)| if i == 0 { line.to_owned() } else { shorter(line) }).collect::<Vec<_>>().join("\n")
    }

    /// The members of a struct, after its opening brace.
    fn members(&mut self) -> ItemKind {
        let mut members = Vec::new();
        let mut comment = Vec::new();
        loop {
            self.skip_space();
            if let Some(line) = self.comment() {
                comment.push(line);
            } else if self.rest().starts_with('}') || self.rest().is_empty() {
                self.at = (self.at + 1).min(self.text.len());
                return ItemKind::Struct { members };
            } else {
                let text = self.until(',');
                let name = words(&text).next().map_or("", |(_, word)| word).to_owned();
                members.push(Member { name, comment: std::mem::take(&mut comment), text });
            }
        }
    }

    fn is_at_word(&self, word: &str) -> bool {
        self.rest().strip_prefix(word).is_some_and(|rest| rest.starts_with([' ', '(', '{']))
    }

    /// The statements of a block, after its opening brace.
    fn block(&mut self) -> Vec<Node> {
        let mut nodes = Vec::new();
        let (mut comment, mut has_gap) = (Vec::new(), false);
        loop {
            has_gap |= self.skip_space() > 1;
            if let Some(line) = self.comment() {
                comment.push(line);
                continue;
            }
            if self.rest().starts_with('}') || self.rest().is_empty() {
                self.at = (self.at + 1).min(self.text.len());
                return nodes;
            }
            let kind = if self.is_at_word("if") {
                self.branches()
            } else if ["for", "while", "loop"].iter().any(|word| self.is_at_word(word)) || self.rest().starts_with('{') {
                let head = self.until('{');
                NodeKind::Nested { head, body: self.block() }
            } else {
                NodeKind::Simple(self.until(';') + ";")
            };
            nodes.push(Node {
                has_gap: std::mem::take(&mut has_gap) && !nodes.is_empty(),
                comment: std::mem::take(&mut comment),
                kind,
            });
        }
    }

    fn branches(&mut self) -> NodeKind {
        let mut arms = Vec::new();
        loop {
            let condition = self.until('{');
            arms.push((condition.trim_start_matches("if").trim().to_owned(), self.block()));
            let after = self.at;
            self.skip_space();
            if !self.is_at_word("else") {
                self.at = after;
                return NodeKind::If { arms, otherwise: Vec::new() };
            }
            self.at += "else".len();
            self.skip_space();
            if !self.is_at_word("if") {
                self.until('{');
                return NodeKind::If { arms, otherwise: self.block() };
            }
        }
    }
}

/// The text of declarations.
pub(super) fn print(items: &[Item]) -> String {
    let mut text = String::new();
    let is_plain = |item: &Item| matches!(item.kind, ItemKind::Other(_)) && item.comment.is_empty();
    for (i, item) in items.iter().enumerate() {
        if i > 0 && !(is_plain(item) && is_plain(&items[i - 1])) {
            text.push('\n');
        }
        item.comment.iter().for_each(|line| add(&mut text, 0, line));
        match &item.kind {
            ItemKind::Other(other) => add(&mut text, 0, other),
            ItemKind::Struct { members } => {
                add(&mut text, 0, &format!("struct {} {{", item.name));
                for member in members {
                    member.comment.iter().for_each(|line| add(&mut text, 1, line));
                    add(&mut text, 1, &format!("{},", member.text));
                }
                add(&mut text, 0, "}");
            }
            ItemKind::Function { head, body } => {
                add(&mut text, 0, &format!("{head} {{"));
                print_nodes(&mut text, 1, body);
                add(&mut text, 0, "}");
            }
        }
    }
    text
}

fn add(text: &mut String, depth: usize, lines: &str) {
    for line in lines.split('\n') {
        if !line.is_empty() {
            text.push_str(&"    ".repeat(depth));
        }
        text.push_str(line);
        text.push('\n');
    }
}

fn print_nodes(text: &mut String, depth: usize, nodes: &[Node]) {
    for (i, node) in nodes.iter().enumerate() {
        if node.has_gap && i > 0 {
            text.push('\n');
        }
        node.comment.iter().for_each(|line| add(text, depth, line));
        match &node.kind {
            NodeKind::Simple(statement) => add(text, depth, statement),
            NodeKind::Nested { head, body } => {
                add(text, depth, format!("{head} {{").trim_start());
                print_nodes(text, depth + 1, body);
                add(text, depth, "}");
            }
            NodeKind::If { arms, otherwise } => {
                for (k, (condition, body)) in arms.iter().enumerate() {
                    add(text, depth, &format!("{}if {condition} {{", if k == 0 { "" } else { "} else " }));
                    print_nodes(text, depth + 1, body);
                }
                if !otherwise.is_empty() {
                    add(text, depth, "} else {");
                    print_nodes(text, depth + 1, otherwise);
                }
                add(text, depth, "}");
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_read_is_printed_as_it_was() {
        let text = include_str!("../bsdf/sample.wgsl");
        // The comment at the head of a file belongs to no declaration.
        let (_, declarations) = text.split_once("\n\n").expect("a head");
        assert_eq!(print(&parse(text)), declarations);
        for text in [include_str!("../bsdf/eval.wgsl"), include_str!("../bsdf/interpret.wgsl"), include_str!("../bsdf/bsdf.wgsl")]
        {
            let once = print(&parse(text));
            assert_eq!(print(&parse(&once)), once);
            assert_eq!(words(&once).count(), words(text).count() - words(text.split("\n\n").next().expect("a head")).count());
        }
    }
}
