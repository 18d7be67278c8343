//! Writing: what differs between two materials, and how it is spelled.

mod texture;

use std::collections::BTreeMap;
use std::ops::Range;

use super::MaterialFile;
use super::edit::{Edits, INDENT};
use super::tree::{self, Block, Node};
use crate::foreign::differing;
use crate::material::{Material, Provenance};
use crate::properties::{PROPERTIES, Property};
use crate::slot::Slot;
use crate::value::Value;
pub(crate) use texture::{same_texture, texture};

/// The source of `file` with the spans of what differs replaced.
pub(super) fn to_text(file: &MaterialFile, edited: &Material) -> String {
    let mut writer = Writer { file, text: &file.text, edits: Edits::of(&file.text, &file.top) };
    writer.top(edited);
    writer.edits.finish()
}

/// Number of entries that differ.
pub(super) fn changed(a: &Material, b: &Material) -> usize {
    let slots = PROPERTIES.iter().filter(|def| !same_slot(a.slot(def.id), b.slot(def.id))).count();
    let provenance = TEXTS.iter().filter(|(_, get)| get(&a.provenance) != get(&b.provenance)).count();
    let others = [a.name != b.name, a.aliases != b.aliases, a.tags != b.tags, a.notes != b.notes, !same_unit(a, b)];
    slots + provenance + others.into_iter().filter(|differs| *differs).count() + differing(a, b).len()
}

pub(crate) type TextOf = fn(&Provenance) -> &String;
/// Texts of the provenance with their keys.
pub(crate) const TEXTS: [(&str, TextOf); 4] =
    [("source", |p| &p.source), ("reference", |p| &p.reference), ("method", |p| &p.method), ("licence", |p| &p.licence)];

/// What becomes of one entry of a map.
enum Fate<'f> {
    Keep,
    Remove,
    Write(String),
    /// The entry is a map: what becomes of its entries. One that is left without any goes, too.
    Edit(Vec<(&'f str, Fate<'f>)>),
}

impl Fate<'_> {
    /// The text of the entry where none stands yet; `None` if none comes.
    fn fresh(self) -> Option<String> {
        match self {
            Self::Keep | Self::Remove => None,
            Self::Write(new) => Some(new),
            Self::Edit(fates) => {
                let entries = fates.into_iter().filter_map(|(key, fate)| Some(format!("{}: {}", string(key), fate.fresh()?)));
                map(&entries.collect::<Vec<_>>())
            }
        }
    }
}

struct Writer<'a> {
    file: &'a MaterialFile,
    text: &'a str,
    edits: Edits<'a>,
}

/// Entries that go and entries that come, collected for one map.
#[derive(Default)]
struct Changes {
    removed: Vec<usize>,
    added: Vec<String>,
}

impl<'a> Writer<'a> {
    fn top(&mut self, new: &Material) {
        let old = &self.file.material;
        let top = &self.file.top;
        let mut changes = Changes::default();
        let text_fate = |old: &str, new: &str| match new {
            _ if old == new => Fate::Keep,
            "" => Fate::Remove,
            _ => Fate::Write(string(new)),
        };
        self.entry(top, "name", text_fate(&old.name, &new.name), &mut changes);
        self.texts("aliases", &old.aliases, &new.aliases, &mut changes);
        self.texts("tags", &old.tags, &new.tags, &mut changes);
        self.entry(top, "notes", text_fate(&old.notes, &new.notes), &mut changes);
        let unit = match new.unit_mm {
            _ if same_unit(old, new) => Fate::Keep,
            None => Fate::Remove,
            Some(unit) => Fate::Write(number(unit)),
        };
        self.entry(top, "unit_mm", unit, &mut changes);

        let fates = TEXTS.map(|(key, get)| (key, text_fate(get(&old.provenance), get(&new.provenance))));
        self.entry(top, "provenance", Fate::Edit(fates.into()), &mut changes);
        self.properties(new, &mut changes);
        self.entry(top, "foreign", foreign(old, new), &mut changes);
        self.edits.change_block(top, &changes.removed, &changes.added);
    }

    /// Carries out what becomes of a value; entries that come or go are left to the caller's `changes`.
    fn entry(&mut self, block: &Block, key: &str, fate: Fate, changes: &mut Changes) {
        let index = block.find(key);
        match (fate, index.map(|index| &block.nodes[index])) {
            (Fate::Keep, _) | (Fate::Remove, None) => {}
            (Fate::Remove, Some(_)) => changes.removed.extend(index),
            (Fate::Write(new), Some(node)) => self.edits.replace_entry(node.value.clone(), &new),
            (Fate::Edit(fates), Some(node)) => match self.block(&node.value, b"{") {
                Some(inner) => {
                    if self.inside(&inner, fates) {
                        changes.removed.extend(index);
                    }
                }
                // What stands there is no map and has no meaning.
                None => {
                    let new = Fate::Edit(fates).fresh();
                    new.into_iter().for_each(|new| self.edits.replace_entry(node.value.clone(), &new));
                }
            },
            (fate, None) => changes.added.extend(fate.fresh().map(|new| format!("{}: {new}", string(key)))),
        }
    }

    /// Edits the entries of a map, unless all of them go and none comes: then it is left to the caller to take the map out.
    fn inside(&mut self, block: &Block, fates: Vec<(&str, Fate)>) -> bool {
        let mut changes = Changes::default();
        for (key, fate) in fates {
            self.entry(block, key, fate, &mut changes);
        }
        let is_left_empty = !changes.removed.is_empty() && changes.removed.len() == block.nodes.len() && changes.added.is_empty();
        if !is_left_empty {
            self.edits.change_block(block, &changes.removed, &changes.added);
        }
        is_left_empty
    }

    fn texts(&mut self, key: &str, old: &[String], new: &[String], changes: &mut Changes) {
        if old == new {
            return;
        }
        let fate = if new.is_empty() { Fate::Remove } else { Fate::Write(list(new)) };
        let node = self.file.top.get(key);
        // An unreadable list reads as none, so that a list of equal length is the one that was read.
        let block = node.and_then(|node| self.block(&node.value, b"[")).filter(|block| block.nodes.len() == old.len());
        let Some(block) = block.filter(|_| !new.is_empty()) else {
            return self.entry(&self.file.top, key, fate, changes);
        };
        if new.len() >= old.len() {
            for ((node, old), new) in block.nodes.iter().zip(old).zip(new) {
                if old != new {
                    self.edits.replace(node.value.clone(), string(new));
                }
            }
            let added: Vec<_> = new[old.len()..].iter().map(|word| string(word)).collect();
            return self.edits.change_block(&block, &[], &added);
        }
        let mut rest = new.iter().peekable();
        let removed: Vec<_> = (0..old.len()).filter(|index| rest.next_if(|word| **word == old[*index]).is_none()).collect();
        match rest.peek() {
            None => self.edits.change_block(&block, &removed, &[]),
            Some(_) => self.entry(&self.file.top, key, fate, changes),
        }
    }

    fn properties(&mut self, new: &Material, changes: &mut Changes) {
        let old = &self.file.material;
        let differing = PROPERTIES.iter().map(|def| def.id).filter(|id| !same_slot(old.slot(*id), new.slot(*id)));
        let Some(block) = &self.file.properties else {
            let fates = differing.map(|id| (id.def().name, Fate::Write(slot(new.slot(id)))));
            return self.entry(&self.file.top, "properties", Fate::Edit(fates.collect()), changes);
        };
        let mut inner = Changes::default();
        for id in differing {
            let fate = match block.get(id.def().name) {
                Some(node) => self.property(id, node, new.slot(id)),
                None => Fate::Write(slot(new.slot(id))),
            };
            self.entry(block, id.def().name, fate, &mut inner);
        }
        self.edits.change_block(block, &inner.removed, &inner.added);
    }

    /// Edits one property that stands in the file, as deep inside as possible; returns what is left to do.
    fn property(&mut self, property: Property, node: &Node, new: &Slot) -> Fate<'static> {
        let old = self.file.material.slot(property);
        let Some(block) = self.block(&node.value, b"{") else {
            return match (new.value, &new.texture) {
                (None, None) => Fate::Remove,
                (Some(value), None) => self.value(&node.value, old.value, value),
                (value, Some(texture)) if same_value(old.value, value) => {
                    // The text that stands there goes along as it is: a spelling, or what could not be read.
                    let Range { start, end } = node.value;
                    self.edits.replace(start..start, format!("{{ {}: ", string("value")));
                    self.edits.replace(end..end, format!(", {}: {} }}", string("texture"), self::texture(texture)));
                    Fate::Keep
                }
                _ => Fate::Write(slot(new)),
            };
        };

        let value_node = block.get("value");
        let value_fate = match (new.value, value_node) {
            _ if same_value(old.value, new.value) => Fate::Keep,
            (None, _) => Fate::Remove,
            (Some(value), Some(node)) => self.value(&node.value, old.value, value),
            (Some(value), None) => Fate::Write(self::value(value)),
        };
        let is_texture_same = same_texture(old.texture.as_ref(), new.texture.as_ref());
        let texture_fate = match (&old.texture, &new.texture) {
            _ if is_texture_same => Fate::Keep,
            (_, None) => Fate::Remove,
            (None, Some(texture)) => Fate::Write(self::texture(texture)),
            (Some(old), Some(new)) => {
                if let Some(node) = block.get("texture") {
                    self.texture(node, old, new);
                }
                Fate::Keep
            }
        };
        let is_left_empty = self.inside(&block, vec![("value", value_fate), ("texture", texture_fate)]);
        if is_left_empty { Fate::Remove } else { Fate::Keep }
    }

    /// Of a colour, only the numbers that differ are replaced.
    fn value(&mut self, span: &Range<usize>, old: Option<Value>, new: Value) -> Fate<'static> {
        let old = match old {
            Some(old) if old.kind() == new.kind() => old,
            _ => return Fate::Write(value(new)),
        };
        let block = self.block(span, b"([").filter(|block| block.nodes.len() == 3);
        match (old, new, block) {
            (Value::Color(old) | Value::Normal(old), Value::Color(new) | Value::Normal(new), Some(block)) => {
                self.numbers(&block, &old, &new);
                Fate::Keep
            }
            _ => Fate::Write(value(new)),
        }
    }

    fn numbers(&mut self, block: &Block, old: &[f64], new: &[f64]) {
        for ((node, old), new) in block.nodes.iter().zip(old).zip(new) {
            if old.to_bits() != new.to_bits() {
                self.edits.replace(node.value.clone(), number(*new));
            }
        }
    }

    fn block(&self, span: &Range<usize>, brackets: &[u8]) -> Option<Block> {
        tree::block_of(self.text, span, brackets)
    }
}

/// What becomes of the texts of other formats.
fn foreign<'m>(old: &'m Material, new: &'m Material) -> Fate<'m> {
    let mut formats: BTreeMap<&str, Vec<(&str, Fate)>> = BTreeMap::new();
    for (format, key) in differing(old, new) {
        let fate = new.foreign_text(format, key).map_or(Fate::Remove, |text| Fate::Write(string(text)));
        formats.entry(format).or_default().push((key, fate));
    }
    Fate::Edit(formats.into_iter().map(|(format, fates)| (format, Fate::Edit(fates))).collect())
}

fn same_unit(a: &Material, b: &Material) -> bool {
    a.unit_mm.map(f64::to_bits) == b.unit_mm.map(f64::to_bits)
}

pub(crate) fn same_slot(a: &Slot, b: &Slot) -> bool {
    same_value(a.value, b.value) && same_texture(a.texture.as_ref(), b.texture.as_ref())
}

/// Equal to the last bit, so that 0 and −0 differ and NaN equals itself.
pub(crate) fn same_value(a: Option<Value>, b: Option<Value>) -> bool {
    match (a, b) {
        (None, None) => true,
        (Some(Value::Bool(a)), Some(Value::Bool(b))) => a == b,
        (Some(a), Some(b)) => a.kind() == b.kind() && same_numbers(a.numbers(), b.numbers()),
        _ => false,
    }
}

fn same_numbers(a: &[f64], b: &[f64]) -> bool {
    a.iter().map(|x| x.to_bits()).eq(b.iter().map(|x| x.to_bits()))
}

/// The shortest text that reads back as the same number, with a point or an exponent.
fn number(x: f64) -> String {
    format!("{x:?}")
}

fn tuple(numbers: &[f64]) -> String {
    format!("({})", numbers.iter().map(|x| number(*x)).collect::<Vec<_>>().join(", "))
}

/// A map with a line for each entry; `None` without any.
fn map(entries: &[String]) -> Option<String> {
    let lines: String =
        entries.iter().map(|entry| format!("\n{INDENT}{},", entry.replace('\n', &format!("\n{INDENT}")))).collect();
    (!entries.is_empty()).then(|| format!("{{{lines}\n}}"))
}

/// A list of texts on one line.
pub(crate) fn list(words: &[String]) -> String {
    format!("[{}]", words.iter().map(|word| string(word)).collect::<Vec<_>>().join(", "))
}

/// A RON string on one line; letters of all scripts stay as they are.
pub(crate) fn string(text: &str) -> String {
    let mut ron = String::with_capacity(text.len() + 2);
    ron.push('"');
    for c in text.chars() {
        match c {
            '"' | '\\' => ron.extend(['\\', c]),
            '\n' => ron += "\\n",
            '\r' => ron += "\\r",
            '\t' => ron += "\\t",
            c if c.is_control() => ron += &format!("\\u{{{:x}}}", u32::from(c)),
            c => ron.push(c),
        }
    }
    ron + "\""
}

pub(crate) fn value(value: Value) -> String {
    match value {
        Value::Float(x) => number(x),
        Value::Bool(x) => x.to_string(),
        Value::Color(x) | Value::Normal(x) => tuple(&x),
    }
}

pub(crate) fn slot(slot: &Slot) -> String {
    match (slot.value, &slot.texture) {
        (Some(plain), None) => value(plain),
        (Some(plain), Some(image)) => format!("{{ \"value\": {}, \"texture\": {} }}", value(plain), texture(image)),
        (None, Some(image)) => format!("{{ \"texture\": {} }}", texture(image)),
        (None, None) => "{}".into(),
    }
}
