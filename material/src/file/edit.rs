//! Changing a text by spans: replaced values, entries that come and entries that go.
//!
//! Edits are collected against the source and carried out at once, so every position is one of the source.

use std::ops::Range;

use super::tree::{Block, Node, comment_length};

/// Edits of one text.
pub(super) struct Edits<'a> {
    text: &'a str,
    newline: &'static str,
    /// One level of indentation.
    unit: &'a str,
    is_one_line: bool,
    list: Vec<(Range<usize>, String)>,
}

/// One level of indentation inside an entry that is to be added; lines end in `\n`.
pub(super) const INDENT: char = '\t';

impl<'a> Edits<'a> {
    /// No edits yet. Line ends and indentation follow the text, whose outermost map is `top`.
    pub fn of(text: &'a str, top: &Block) -> Self {
        let newline = match text.find('\n') {
            Some(at) if text[..at].ends_with('\r') => "\r\n",
            _ => "\n",
        };
        let is_one_line = !text[top.open..top.close].contains('\n');
        let unit = top.nodes.iter().find_map(|node| own_indent(text, node.start)).filter(|unit| !unit.is_empty());
        Self { text, newline, unit: unit.unwrap_or("    "), is_one_line, list: Vec::new() }
    }

    /// Puts `new` in the place of a span.
    pub fn replace(&mut self, span: Range<usize>, new: String) {
        self.list.push((span, new));
    }

    /// Puts an entry or value that may have several lines in the place of a span, in the indentation of its line.
    pub fn replace_entry(&mut self, span: Range<usize>, new: &str) {
        let new = self.laid_out(new, line_indent(self.text, span.start));
        self.replace(span, new);
    }

    /// Takes entries out of a block and adds others behind the last one. The result stays valid, whichever go.
    ///
    /// `removed` holds entry numbers; `added` holds entries without commas.
    pub fn change_block(&mut self, block: &Block, removed: &[usize], added: &[String]) {
        let Some(last) = block.nodes.len().checked_sub(1) else {
            return self.fill_empty(block, added);
        };
        let mut goes = vec![false; block.nodes.len()];
        removed.iter().for_each(|index| goes[*index] = true);
        let mut added = added;
        if let (true, Some((first, rest))) = (goes.iter().all(|goes| *goes), added.split_first()) {
            // Something has to stay that the others can follow: the last entry makes room for the first new one.
            self.replace_entry(block.nodes[last].start..block.nodes[last].value.end, first);
            (goes[last], added) = (false, rest);
        }
        let mut done = block.open + 1;
        for index in (0..=last).filter(|index| goes[*index]) {
            let Range { start, end } = self.span_to_remove(block, index, &goes, added.is_empty());
            // The blanks between two entries that both go are counted once.
            self.replace(start.max(done)..end, String::new());
            done = end;
        }
        if let Some(anchor) = (0..=last).rev().find(|index| !goes[*index]).filter(|_| !added.is_empty()) {
            self.append(&block.nodes[anchor], added, block.nodes[last].comma.is_some());
        }
    }

    /// The entry with its comma, the blanks on one side, and its line if it stands alone there.
    fn span_to_remove(&self, block: &Block, index: usize, goes: &[bool], is_comma_free: bool) -> Range<usize> {
        let node = &block.nodes[index];
        let (mut start, mut end) = (node.start, node.comma.map_or(node.value.end, |comma| comma + 1));
        let line_start = line_start(self.text, start);
        let line_end = self.rest_of_line(end);
        if let (Some(_), Some(line_end)) = (own_indent(self.text, start), line_end) {
            // The entry has its lines to itself. A comma that now ends the map is valid and stays.
            let newline = if self.text[line_end..].starts_with('\r') { 2 } else { 1 };
            return line_start..line_end + newline;
        }
        let before = index.checked_sub(1).filter(|before| !goes[*before]).and_then(|before| block.nodes[before].comma);
        match before {
            Some(comma) if is_comma_free && node.comma.is_none() && self.text[comma + 1..start].trim().is_empty() => {
                start = comma
            }
            _ => {
                let is_space = |c: char| c == ' ' || c == '\t';
                let rest = &self.text[end..];
                let spaces = rest.len() - rest.trim_start_matches(is_space).len();
                let is_last = index + 1 == block.nodes.len();
                if is_last || rest[spaces..].starts_with(['\r', '\n']) {
                    start = self.text[..start].trim_end_matches(is_space).len();
                } else {
                    end += spaces;
                }
            }
        }
        start..end
    }

    fn append(&mut self, anchor: &Node, added: &[String], has_last_comma: bool) {
        let last_comma = if has_last_comma { "," } else { "" };
        let end = anchor.comma.map_or(anchor.value.end, |comma| comma + 1);
        let Some(indent) = own_indent(self.text, anchor.start) else {
            let first_comma = if anchor.comma.is_none() { "," } else { "" };
            let entries: Vec<_> = added.iter().map(|entry| on_one_line(entry)).collect();
            return self.replace(end..end, format!("{first_comma} {}{last_comma}", entries.join(", ")));
        };
        if anchor.comma.is_none() {
            self.replace(end..end, ",".into());
        }
        let mut new = String::new();
        for (index, entry) in added.iter().enumerate() {
            let comma = if index + 1 < added.len() { "," } else { last_comma };
            new += &format!("{}{indent}{}{comma}", self.newline, self.laid_out(entry, indent));
        }
        let at = self.rest_of_line(end).unwrap_or(end);
        self.replace(at..at, new);
    }

    fn fill_empty(&mut self, block: &Block, added: &[String]) {
        if added.is_empty() {
            return;
        }
        let inside = &self.text[block.open + 1..block.close];
        let entries = added.iter().map(|entry| on_one_line(entry)).collect::<Vec<_>>().join(", ");
        let is_list = self.text[block.open..].starts_with('[');
        let outer = line_indent(self.text, block.open);
        let inner = format!("{outer}{}", self.unit);
        let newline = self.newline;
        let lines: String = added.iter().map(|entry| format!("{inner}{},{newline}", self.laid_out(entry, &inner))).collect();
        if inside.trim().is_empty() {
            let new = match (is_list, self.is_one_line && !inside.contains('\n')) {
                (true, _) => entries,
                (false, true) => format!(" {entries} "),
                (false, false) => format!("{newline}{lines}{outer}"),
            };
            self.replace(block.open + 1..block.close, new);
        } else if own_indent(self.text, block.close).is_some() {
            let at = line_start(self.text, block.close);
            self.replace(at..at, lines);
        } else {
            let space = if inside.ends_with(' ') { "" } else { " " };
            self.replace(block.close..block.close, format!("{space}{entries} "));
        }
    }

    /// Where the line that `at` stands in ends, if nothing but blanks and comments follow in it.
    fn rest_of_line(&self, mut at: usize) -> Option<usize> {
        loop {
            let rest = self.text[at..].trim_start_matches([' ', '\t']);
            at = self.text.len() - rest.len();
            if rest.starts_with('\n') || rest.starts_with("\r\n") {
                return Some(at);
            }
            let length = comment_length(rest);
            if length == 0 || (rest.starts_with("/*") && rest[..length].contains('\n')) {
                return None;
            }
            // The carriage return before a line feed belongs to the line end, not to the comment.
            at += if rest[..length].ends_with('\r') { length - 1 } else { length };
        }
    }

    /// An entry that begins in `indent`, with the line ends and the indentation of this text.
    fn laid_out(&self, entry: &str, indent: &str) -> String {
        if self.is_one_line {
            return on_one_line(entry);
        }
        let mut lines = entry.split('\n');
        let mut new = lines.next().unwrap_or_default().to_owned();
        for line in lines {
            let inner = line.trim_start_matches(INDENT);
            new += &format!("{}{indent}{}{inner}", self.newline, self.unit.repeat(line.len() - inner.len()));
        }
        new
    }

    /// The text with all edits carried out.
    pub fn finish(mut self) -> String {
        self.list.sort_by_key(|(span, _)| (span.start, span.end));
        let mut new = String::with_capacity(self.text.len());
        let mut done = 0;
        for (span, replacement) in &self.list {
            debug_assert!(done <= span.start, "edits overlap at byte {}", span.start);
            new += &self.text[done..span.start];
            new += replacement;
            done = span.end;
        }
        new + &self.text[done..]
    }
}

/// An entry that was written for several lines, on one.
fn on_one_line(entry: &str) -> String {
    let lines: Vec<_> = entry.split('\n').map(|line| line.trim_start_matches(INDENT)).collect();
    lines.join(" ")
}

fn line_start(text: &str, at: usize) -> usize {
    text[..at].rfind('\n').map_or(0, |newline| newline + 1)
}

/// The blanks that the line of `at` begins with.
fn line_indent(text: &str, at: usize) -> &str {
    let line = &text[line_start(text, at)..at];
    &line[..line.len() - line.trim_start_matches([' ', '\t']).len()]
}

/// The blanks before `at` if nothing else stands before it in a line that is not the first.
fn own_indent(text: &str, at: usize) -> Option<&str> {
    let start = line_start(text, at);
    let indent = line_indent(text, at);
    (start > 0 && start + indent.len() == at).then_some(indent)
}
