//! Writing: what differs between two materials, and how it is spelled.

use std::ops::Range;

use super::edit::{Edits, INDENT};
use super::tree::{self, Block, Node};
use super::{MaterialFile, read};
use crate::material::{Material, Provenance};
use crate::properties::{PROPERTIES, Property};
use crate::slot::{Slot, TextureRef};
use crate::value::Value;

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
    slots + provenance + others.into_iter().filter(|differs| *differs).count()
}

pub(crate) type TextOf = fn(&Provenance) -> &String;
/// Texts of the provenance with their keys.
pub(crate) const TEXTS: [(&str, TextOf); 4] =
    [("source", |p| &p.source), ("reference", |p| &p.reference), ("method", |p| &p.method), ("licence", |p| &p.licence)];

/// What becomes of one entry of a map.
enum Fate {
    Keep,
    Remove,
    Write(String),
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
        self.map("provenance", fates, &mut changes);
        self.properties(new, &mut changes);
        self.edits.change_block(top, &changes.removed, &changes.added);
    }

    /// Carries out what becomes of a value; entries that come or go are left to the caller's `changes`.
    fn entry(&mut self, block: &Block, key: &str, fate: Fate, changes: &mut Changes) {
        match (fate, block.find(key)) {
            (Fate::Keep, _) | (Fate::Remove, None) => {}
            (Fate::Remove, Some(index)) => changes.removed.push(index),
            (Fate::Write(new), Some(index)) => self.edits.replace_entry(block.nodes[index].value.clone(), &new),
            (Fate::Write(new), None) => changes.added.push(format!("{}: {new}", string(key))),
        }
    }

    /// Edits the map at `key` of the outermost map, which may be missing, unreadable or left without any entry.
    fn map<const N: usize>(&mut self, key: &str, fates: [(&str, Fate); N], changes: &mut Changes) {
        let top = &self.file.top;
        let old = top.get(key).and_then(|node| self.block(&node.value, b"{"));
        let mut inner = Changes::default();
        let Some(block) = old else {
            let written = fates.into_iter().filter_map(|(key, fate)| match fate {
                Fate::Write(new) => Some(format!("{}: {new}", string(key))),
                _ => None,
            });
            return self.new_map(key, written.collect(), changes);
        };
        for (key, fate) in fates {
            self.entry(&block, key, fate, &mut inner);
        }
        if !inner.removed.is_empty() && inner.removed.len() == block.nodes.len() && inner.added.is_empty() {
            return self.entry(top, key, Fate::Remove, changes);
        }
        self.edits.change_block(&block, &inner.removed, &inner.added);
    }

    /// Writes a whole map at `key` of the outermost map, if there is anything to write.
    fn new_map(&mut self, key: &str, entries: Vec<String>, changes: &mut Changes) {
        if entries.is_empty() {
            return;
        }
        let lines: String = entries.iter().map(|entry| format!("\n{INDENT}{entry},")).collect();
        self.entry(&self.file.top, key, Fate::Write(format!("{{{lines}\n}}")), changes);
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
            let entries = differing.map(|id| format!("{}: {}", string(id.def().name), slot(new.slot(id))));
            return self.new_map("properties", entries.collect(), changes);
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
    fn property(&mut self, property: Property, node: &Node, new: &Slot) -> Fate {
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
        let mut inner = Changes::default();
        self.entry(&block, "value", value_fate, &mut inner);
        self.entry(&block, "texture", texture_fate, &mut inner);
        if !inner.removed.is_empty() && inner.removed.len() == block.nodes.len() && inner.added.is_empty() {
            return Fate::Remove;
        }
        self.edits.change_block(&block, &inner.removed, &inner.added);
        Fate::Keep
    }

    /// Of a colour, only the numbers that differ are replaced.
    fn value(&mut self, span: &Range<usize>, old: Option<Value>, new: Value) -> Fate {
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

    fn texture(&mut self, node: &Node, old: &TextureRef, new: &TextureRef) {
        let Some(block) = self.block(&node.value, b"{") else { return };
        let mut changes = Changes::default();
        let differing = texture_fields(old).into_iter().zip(texture_fields(new)).filter(|(old, new)| old != new);
        for ((key, _), (_, new_text)) in differing {
            let pairs = match key {
                "uv_scale" => Some((old.uv_scale, new.uv_scale)),
                "uv_offset" => Some((old.uv_offset, new.uv_offset)),
                _ => None,
            };
            let node = block.get(key).filter(|node| read::numbers::<2>(self.text, &node.value).is_some());
            match (pairs, node.and_then(|node| self.block(&node.value, b"(["))) {
                (Some((old, new)), Some(items)) => self.numbers(&items, &old, &new),
                _ => self.entry(&block, key, Fate::Write(new_text), &mut changes),
            }
        }
        self.edits.change_block(&block, &[], &changes.added);
    }

    fn block(&self, span: &Range<usize>, brackets: &[u8]) -> Option<Block> {
        tree::block_of(self.text, span, brackets)
    }
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

pub(crate) fn same_texture(a: Option<&TextureRef>, b: Option<&TextureRef>) -> bool {
    match (a, b) {
        (None, None) => true,
        (Some(a), Some(b)) => texture_fields(a) == texture_fields(b),
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

/// All fields of a texture reference as they are written.
fn texture_fields(t: &TextureRef) -> [(&'static str, String); 8] {
    [
        ("path", string(&t.path)),
        ("channel", string(t.channel.word())),
        ("color_space", string(t.color_space.word())),
        ("invert", t.is_inverted.to_string()),
        ("wrap", string(t.wrap.word())),
        ("uv_scale", tuple(&t.uv_scale)),
        ("uv_offset", tuple(&t.uv_offset)),
        ("uv_rotation", number(t.uv_rotation)),
    ]
}

/// A texture reference with its path and whatever is not at its default.
pub(crate) fn texture(texture: &TextureRef) -> String {
    let plain = texture_fields(&TextureRef::new(""));
    let fields =
        texture_fields(texture).into_iter().zip(plain).filter(|((key, text), (_, plain))| *key == "path" || text != plain);
    let fields: Vec<_> = fields.map(|((key, text), _)| format!("{}: {text}", string(key))).collect();
    format!("{{ {} }}", fields.join(", "))
}

pub(crate) fn slot(slot: &Slot) -> String {
    match (slot.value, &slot.texture) {
        (Some(plain), None) => value(plain),
        (Some(plain), Some(image)) => format!("{{ \"value\": {}, \"texture\": {} }}", value(plain), texture(image)),
        (None, Some(image)) => format!("{{ \"texture\": {} }}", texture(image)),
        (None, None) => "{}".into(),
    }
}
