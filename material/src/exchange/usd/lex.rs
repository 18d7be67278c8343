//! The words of usda text.

use std::borrow::Cow;

use super::error::{MAX_NAME_BYTES, UsdError};
use crate::exchange::short::short;

/// One word of the text.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Token<'a> {
    /// A name or keyword, with its namespaces: `inputs:baseColor`.
    Word(&'a str),
    /// A number; not finite where the text says `inf` or `nan`, or more than a double holds.
    Number(f64),
    /// A quoted text without its escapes.
    Text(Cow<'a, str>),
    /// The path of a file, `@…@`.
    Asset(&'a str),
    /// A path in the scene, `<…>`.
    Path(&'a str),
    /// A bracket or separator.
    Mark(u8),
    /// The end of the text.
    End,
}

impl Token<'_> {
    /// The token for messages, shortened if it is long.
    pub fn shown(&self) -> String {
        let quoted = |text: &str| format!("`{}`", short(text));
        match self {
            Self::Word(word) => quoted(word),
            Self::Number(number) => quoted(&number.to_string()),
            Self::Text(text) => format!("the text {}", quoted(text)),
            Self::Asset(path) => format!("the file {}", quoted(path)),
            Self::Path(path) => format!("the path {}", quoted(path)),
            Self::Mark(mark) => quoted(&char::from(*mark).to_string()),
            Self::End => "the end of the file".to_owned(),
        }
    }
}

/// Cuts a text into tokens.
pub(super) struct Lexer<'a> {
    text: &'a str,
    at: usize,
    /// Line of the place in the text, from 1.
    pub line: usize,
}

impl<'a> Lexer<'a> {
    pub fn new(text: &'a str) -> Self {
        Self { text, at: 0, line: 1 }
    }

    /// The next token. Errors name what is not closed, or a character that has no place in usda.
    pub fn next(&mut self) -> Result<Token<'a>, UsdError> {
        self.skip_space()?;
        let Some(first) = self.byte(0) else { return Ok(Token::End) };
        match first {
            b'"' | b'\'' => self.quoted(first),
            b'@' => self.asset(),
            b'<' => self.enclosed(1, ">", "a path").map(Token::Path),
            b'0'..=b'9' | b'+' | b'-' => self.number(),
            b'.' if matches!(self.byte(1), Some(b'0'..=b'9')) => self.number(),
            b'(' | b')' | b'[' | b']' | b'{' | b'}' | b'=' | b',' | b':' | b'.' | b'&' => {
                self.at += 1;
                Ok(Token::Mark(first))
            }
            _ if is_name_start(first) => match self.take(is_name) {
                word if word.len() <= MAX_NAME_BYTES => Ok(Token::Word(word)),
                word => Err(self.error(format!("expected a name of at most {MAX_NAME_BYTES} bytes, found `{}`", short(word)))),
            },
            _ => {
                let found = self.text[self.at..].chars().next().unwrap_or_default();
                Err(self.error(format!("expected a name, a value or a bracket, found `{}`", found.escape_default())))
            }
        }
    }

    fn byte(&self, ahead: usize) -> Option<u8> {
        self.text.as_bytes().get(self.at + ahead).copied()
    }

    fn error(&self, message: String) -> UsdError {
        UsdError::Syntax { line: self.line, message }
    }

    /// Takes bytes while they fit; stops at a boundary of characters because all others are taken or refused whole.
    fn take(&mut self, fits: impl Fn(u8) -> bool) -> &'a str {
        let rest = &self.text[self.at..];
        let length = rest.bytes().position(|b| !fits(b)).unwrap_or(rest.len());
        self.at += length;
        &rest[..length]
    }

    /// Skips white space, separators of statements and comments.
    fn skip_space(&mut self) -> Result<(), UsdError> {
        loop {
            match (self.byte(0), self.byte(1)) {
                (Some(b'\n'), _) => (self.at, self.line) = (self.at + 1, self.line + 1),
                (Some(b' ' | b'\t' | b'\r' | b';'), _) => self.at += 1,
                (Some(b'#'), _) | (Some(b'/'), Some(b'/')) => _ = self.take(|b| b != b'\n'),
                (Some(b'/'), Some(b'*')) => _ = self.enclosed_lines(2, "*/", "a comment")?,
                _ => return Ok(()),
            }
        }
    }

    /// What stands between the mark here, `before` bytes long, and `end` on the same line.
    fn enclosed(&mut self, before: usize, end: &str, what: &str) -> Result<&'a str, UsdError> {
        let rest = &self.text[self.at + before..];
        let bytes = rest.as_bytes();
        let stop = (0..bytes.len()).find(|at| bytes[*at] == b'\n' || bytes[*at..].starts_with(end.as_bytes()));
        match stop.filter(|at| bytes[*at] != b'\n') {
            Some(length) => {
                self.at += before + length + end.len();
                Ok(&rest[..length])
            }
            None => Err(self.error(format!("expected the end of {what}, `{end}`, on the same line, found none"))),
        }
    }

    /// As [`Self::enclosed`], over several lines.
    fn enclosed_lines(&mut self, before: usize, end: &str, what: &str) -> Result<&'a str, UsdError> {
        let rest = &self.text[self.at + before..];
        match rest.find(end) {
            Some(length) => {
                self.at += before + length + end.len();
                self.line += rest[..length].bytes().filter(|b| *b == b'\n').count();
                Ok(&rest[..length])
            }
            None => Err(self.error(format!("expected the end of {what}, `{end}`, found none in the file"))),
        }
    }

    fn asset(&mut self) -> Result<Token<'a>, UsdError> {
        let is_triple = self.text[self.at..].starts_with("@@@");
        let (before, end) = if is_triple { (3, "@@@") } else { (1, "@") };
        self.enclosed(before, end, "a file path").map(Token::Asset)
    }

    fn number(&mut self) -> Result<Token<'a>, UsdError> {
        let sign = self.take(|b| matches!(b, b'+' | b'-'));
        if self.byte(0).is_some_and(|b| b.is_ascii_alphabetic()) {
            let word = self.take(is_name);
            return match word {
                "inf" | "nan" => Ok(Token::Number(f64::NAN)),
                _ => Err(self.error(format!("expected a number, found `{sign}{word}`"))),
            };
        }
        let mut before = b' ';
        let start = self.at - sign.len();
        while let Some(b) = self.byte(0) {
            let is_part =
                matches!(b, b'0'..=b'9' | b'.' | b'e' | b'E') || (matches!(b, b'+' | b'-') && matches!(before, b'e' | b'E'));
            if !is_part {
                break;
            }
            (before, self.at) = (b, self.at + 1);
        }
        let text = &self.text[start..self.at];
        match text.parse::<f64>() {
            Ok(number) => Ok(Token::Number(number)),
            Err(_) => Err(self.error(format!("expected a number, found {}", Token::Word(text).shown()))),
        }
    }

    fn quoted(&mut self, quote: u8) -> Result<Token<'a>, UsdError> {
        let start_line = self.line;
        let is_triple = self.byte(1) == Some(quote) && self.byte(2) == Some(quote);
        let width = if is_triple { 3 } else { 1 };
        let rest = &self.text[self.at + width..];
        let bytes = rest.as_bytes();
        let unclosed = UsdError::Syntax {
            line: start_line,
            message: format!("expected the end of a text, {}, found none", char::from(quote).to_string().repeat(width)),
        };
        let (mut at, mut has_escapes) = (0, false);
        loop {
            match bytes.get(at) {
                None => return Err(unclosed),
                Some(b'\\') => (at, has_escapes) = (at + 2, true),
                Some(b'\n') if !is_triple => return Err(unclosed),
                Some(b) if *b == quote && bytes[at..].iter().take(width).filter(|b| **b == quote).count() == width => break,
                Some(b'\n') => (at, self.line) = (at + 1, self.line + 1),
                Some(_) => at += 1,
            }
        }
        self.at += width + at + width;
        let raw = &rest[..at];
        Ok(Token::Text(if has_escapes { Cow::Owned(unescaped(raw)) } else { Cow::Borrowed(raw) }))
    }
}

/// The text that an escaped one means. Bytes that are no UTF-8 become the replacement character.
fn unescaped(raw: &str) -> String {
    let mut bytes = Vec::with_capacity(raw.len());
    let mut rest = raw.bytes().peekable();
    while let Some(b) = rest.next() {
        if b != b'\\' {
            bytes.push(b);
            continue;
        }
        match rest.next() {
            Some(b'n') => bytes.push(b'\n'),
            Some(b't') => bytes.push(b'\t'),
            Some(b'r') => bytes.push(b'\r'),
            Some(b'x') => {
                let mut code = 0_u8;
                for _ in 0..2 {
                    let Some(digit) = rest.peek().and_then(|b| char::from(*b).to_digit(16)) else { break };
                    code = code.wrapping_mul(16).wrapping_add(digit as u8);
                    rest.next();
                }
                bytes.push(code);
            }
            Some(other) => bytes.push(other),
            None => {}
        }
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

/// Whether a name can begin so. Letters of all scripts can.
fn is_name_start(b: u8) -> bool {
    b.is_ascii_alphabetic() || b == b'_' || b >= 0x80
}

fn is_name(b: u8) -> bool {
    is_name_start(b) || b.is_ascii_digit() || b == b':'
}
