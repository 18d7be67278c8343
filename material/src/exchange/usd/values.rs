//! Values in usda text: numbers, texts, lists, dictionaries, and what stands in brackets behind a prim or property.

use std::borrow::Cow;

use super::error::{MAX_DEPTH, MAX_ENTRIES, UsdError};
use super::layer::{Entries, Value};
use super::lex::Token;
use super::parse::{OPERATIONS, Parser};

impl<'a> Parser<'a> {
    /// Where a connection or relationship leads: one path, a list of them, or none.
    pub fn targets(&mut self) -> Result<Vec<&'a str>, UsdError> {
        let mut targets = Vec::new();
        if self.token == Token::Word("None") {
            self.advance()?;
            return Ok(targets);
        }
        let is_list = self.take_mark(b'[')?;
        loop {
            match self.token {
                Token::Path(path) => {
                    self.advance()?;
                    targets.push(path);
                }
                Token::Mark(b']') if is_list => break,
                _ => return self.expected("a path `<…>`"),
            }
            if !is_list {
                return Ok(targets);
            }
            self.take_mark(b',')?;
        }
        self.mark(b']')?;
        Ok(targets)
    }

    /// The first sample of a value that changes over time.
    pub fn samples(&mut self) -> Result<Option<Value<'a>>, UsdError> {
        let mut first = None;
        self.mark(b'{')?;
        while self.token != Token::Mark(b'}') {
            let Token::Number(_) = self.token else { return self.expected("a time, or `}`") };
            self.advance()?;
            self.mark(b':')?;
            let value = self.value(0)?;
            first = first.or_else(|| (value != Value::None).then_some(value));
            self.take_mark(b',')?;
        }
        self.mark(b'}')?;
        Ok(first)
    }

    /// What stands between round brackets behind a layer, prim or property.
    pub fn metadata(&mut self) -> Result<Entries<'a>, UsdError> {
        self.mark(b'(')?;
        let mut entries = Entries::new();
        loop {
            match self.token {
                Token::Mark(b')') => break,
                Token::Text(_) => {
                    self.advance()?;
                    continue;
                }
                Token::Word(_) => {}
                _ => return self.expected("metadata, or `)`"),
            }
            let line = self.line;
            let (mut key, mut is_deleted) = (self.word("metadata")?, false);
            if OPERATIONS.contains(&key) && matches!(self.token, Token::Word(_)) {
                is_deleted = matches!(key, "delete" | "reorder");
                key = self.word("metadata")?;
            }
            self.mark(b'=')?;
            let value = self.value(0)?;
            self.skip_time_offset()?;
            if !value.is_finite() {
                self.layer.note(line, None, &format!("{key}: expected finite numbers, found others; not read"));
            } else if !is_deleted {
                entries.push((Cow::Borrowed(key), value));
            }
            self.check_entries(&entries)?;
        }
        self.advance()?;
        Ok(entries)
    }

    /// A value of any kind, `depth` dictionaries deep.
    pub fn value(&mut self, depth: usize) -> Result<Value<'a>, UsdError> {
        match self.token {
            Token::Mark(b'[') => self.list(),
            Token::Mark(b'{') => self.dictionary(depth).map(Value::Dictionary),
            Token::Word("None" | "AnimationBlock") => self.advance().map(|_| Value::None),
            Token::Mark(b'(') | Token::Number(_) | Token::Word("true" | "false" | "inf" | "nan") => {
                let mut data = Vec::new();
                let width = self.numbers(&mut data, 0)?;
                Ok(Value::Numbers { width, is_list: false, data })
            }
            _ => Ok(Value::Texts { is_list: false, items: vec![self.one_text()?] }),
        }
    }

    fn list(&mut self) -> Result<Value<'a>, UsdError> {
        self.mark(b'[')?;
        let (mut data, mut width, mut items) = (Vec::new(), 0, Vec::new());
        while self.token != Token::Mark(b']') {
            match self.token {
                Token::Mark(b'(') | Token::Number(_) | Token::Word("true" | "false" | "inf" | "nan") if items.is_empty() => {
                    let count = self.numbers(&mut data, 0)?;
                    if width != 0 && width != count {
                        let message = format!("expected items of {width} numbers in a list, found one of {count}");
                        return Err(UsdError::Syntax { line: self.line, message });
                    }
                    width = count;
                }
                _ if width == 0 => {
                    items.push(self.one_text()?);
                    self.skip_time_offset()?;
                }
                _ => return self.expected("a number, or `]`"),
            }
            if !self.take_mark(b',')? && self.token != Token::Mark(b']') {
                return self.expected("`,` or `]`");
            }
        }
        self.advance()?;
        Ok(match items.is_empty() {
            true => Value::Numbers { width: width.max(1), is_list: true, data },
            false => Value::Texts { is_list: true, items },
        })
    }

    /// A number, or a tuple of numbers and tuples; how many numbers it has.
    fn numbers(&mut self, data: &mut Vec<f64>, depth: usize) -> Result<usize, UsdError> {
        let number = match self.token {
            Token::Number(number) => number,
            Token::Word("true") => 1.0,
            Token::Word("false") => 0.0,
            Token::Word("inf" | "nan") => f64::NAN,
            Token::Mark(b'(') if depth < 2 => {
                self.advance()?;
                let mut count = 0;
                while self.token != Token::Mark(b')') {
                    count += self.numbers(data, depth + 1)?;
                    if !self.take_mark(b',')? && self.token != Token::Mark(b')') {
                        return self.expected("`,` or `)`");
                    }
                }
                if count == 0 {
                    return self.expected("a number");
                }
                return self.advance().map(|_| count);
            }
            _ => return self.expected("a number"),
        };
        self.advance()?;
        data.push(number);
        Ok(1)
    }

    /// A text, file or path. The path behind the file of a reference is not kept.
    fn one_text(&mut self) -> Result<Cow<'a, str>, UsdError> {
        let text = match self.token.clone() {
            Token::Text(text) => text,
            Token::Word(text) | Token::Asset(text) | Token::Path(text) => Cow::Borrowed(text),
            _ => return self.expected("a value"),
        };
        let is_file = matches!(self.advance()?, Token::Asset(_));
        if is_file && matches!(self.token, Token::Path(_)) {
            self.advance()?;
        }
        Ok(text)
    }

    fn check_entries(&self, entries: &Entries) -> Result<(), UsdError> {
        if entries.len() > MAX_ENTRIES { self.too_much(format!("{MAX_ENTRIES} entries in one place")) } else { Ok(()) }
    }

    /// Skips how the times of a reference are shifted: `(offset = 1; scale = 2)`.
    fn skip_time_offset(&mut self) -> Result<(), UsdError> {
        if self.token == Token::Mark(b'(') { self.skip_block(b'(', b')') } else { Ok(()) }
    }

    fn dictionary(&mut self, depth: usize) -> Result<Entries<'a>, UsdError> {
        if depth >= MAX_DEPTH {
            return self.too_much(format!("{MAX_DEPTH} dictionaries inside each other"));
        }
        self.mark(b'{')?;
        let mut entries = Entries::new();
        while self.token != Token::Mark(b'}') {
            // Other maps have no types: `<path>: <path>` and `time: value`.
            if let Token::Path(_) | Token::Number(_) = self.token {
                self.advance()?;
                self.mark(b':')?;
                self.value(depth + 1)?;
            } else {
                self.word("the type of an entry, or `}`")?;
                if self.take_mark(b'[')? {
                    self.mark(b']')?;
                }
                let key = match self.token.clone() {
                    Token::Word(word) => Cow::Borrowed(word),
                    Token::Text(text) => text,
                    _ => return self.expected("the name of an entry"),
                };
                self.advance()?;
                self.mark(b'=')?;
                let value = self.value(depth + 1)?;
                entries.push((key, value));
                self.check_entries(&entries)?;
            }
            self.take_mark(b',')?;
        }
        self.advance()?;
        Ok(entries)
    }

    /// Skips a block with all blocks in it.
    pub fn skip_block(&mut self, open: u8, close: u8) -> Result<(), UsdError> {
        let line = self.line;
        self.mark(open)?;
        let mut level = 1_usize;
        while level > 0 {
            match self.advance()? {
                Token::Mark(mark) if mark == open => level += 1,
                Token::Mark(mark) if mark == close => level -= 1,
                Token::End => {
                    let message = format!("expected the end of a block, `{}`, found none in the file", char::from(close));
                    return Err(UsdError::Syntax { line, message });
                }
                _ => {}
            }
        }
        Ok(())
    }
}
