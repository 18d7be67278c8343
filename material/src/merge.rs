//! Two versions of a material made from a third, put together: what one of them changed is taken, what both changed is decided.
//!
//! Entries are merged one by one: each property with its texture, name, notes, and each text of the provenance and of other formats. Lengths and the unit they are in
//! are one entry where the unit was changed, because neither means anything without the other. Tags and other names are merged word by word.

use crate::diff::{self, Change};
use crate::file::{MaterialFile, TEXTS, same_slot, same_texture, same_value, slot_text, string, value_text};
use crate::foreign::{differing, entry_key};
use crate::material::Material;
use crate::properties::{PROPERTIES, Property};
use crate::value::{Unit, Value};

/// One of the two versions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Side {
    /// The first, whose text the merged file keeps.
    A,
    /// The second.
    B,
}

/// An entry that both versions changed, each in its own way.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Conflict {
    /// The entry, as in [`Change::key`].
    pub key: String,
    /// The property, if it is about one.
    pub property: Option<Property>,
    /// What stood there before, as a file writes it; `None` if nothing did.
    pub base: Option<String>,
    /// The first version's.
    pub a: Option<String>,
    /// The second version's.
    pub b: Option<String>,
}

/// What came of a merge.
#[derive(Clone, Debug, PartialEq)]
pub struct Merged {
    /// With the preferred side's entry where there is a conflict.
    pub material: Material,
    /// What both changed differently. Two new names are none: one is kept among [`Material::aliases`].
    pub conflicts: Vec<Conflict>,
    /// Keys of the entries that come from the second version, conflicts included.
    pub taken: Vec<String>,
}

/// What came of a merge of files.
#[derive(Clone, Debug, PartialEq)]
pub struct MergedFile {
    /// The values.
    pub merged: Merged,
    /// The first version's text with only what differs replaced: its comments and unknown keys are kept.
    pub text: String,
    /// What the second version changed beside the values, and what is not in the text: unknown keys and sources of single values. In each,
    /// `a` is what the text holds and `b` what it lacks.
    pub left_out: Vec<Change>,
}

enum Pick {
    A,
    B,
    Conflict,
}

/// Which side has changed an entry. `is_exact` tells entries that are written alike, `is_like` those that mean the same.
fn pick<T: ?Sized>(base: &T, a: &T, b: &T, is_exact: impl Fn(&T, &T) -> bool, is_like: impl Fn(&T, &T) -> bool) -> Pick {
    if is_exact(base, b) {
        Pick::A
    } else if is_exact(base, a) {
        Pick::B
    } else if is_like(a, b) || is_like(base, b) {
        Pick::A
    } else if is_like(base, a) {
        Pick::B
    } else {
        Pick::Conflict
    }
}

/// Merges two versions of `base`. Where both changed an entry differently, that of `prefer` is used.
pub fn merge(base: &Material, a: &Material, b: &Material, prefer: Side) -> Merged {
    let mut merger = Merger { base, a, b, prefer, material: a.clone(), conflicts: Vec::new(), taken: Vec::new() };
    merger.words();
    merger.foreign();
    merger.lengths();
    let has_one_unit = merger.has_one_unit();
    for def in PROPERTIES.iter().filter(|def| has_one_unit || def.unit != Unit::Length) {
        let id = def.id;
        let is_like = |x: &Material, y: &Material| same_meaning(x, y, id);
        let of = |m: &Material| slot_of(m, id);
        if merger.is_from_b(def.name, Some(id), pick(base, a, b, |x, y| same_slot(x.slot(id), y.slot(id)), is_like), of) {
            *merger.material.slot_mut(id) = b.slot(id).clone();
        }
    }
    let Merger { material, conflicts, taken, .. } = merger;
    Merged { material, conflicts, taken }
}

/// Merges two versions of a file.
pub fn merge_files(base: &MaterialFile, a: &MaterialFile, b: &MaterialFile, prefer: Side) -> MergedFile {
    let merged = merge(base.material(), a.material(), b.material(), prefer);
    let text = a.to_text(&merged.material);
    let (old, kept, other) = (diff::entries(base), diff::entries(a), diff::entries(b));
    let keys = other.keys().chain(old.keys().filter(|key| !other.contains_key(*key)));
    let is_lost = |key: &&String| other.get(*key) != old.get(*key) && other.get(*key) != kept.get(*key);
    let left_out = keys.filter(is_lost).map(|key| Change {
        key: key.clone(),
        property: None,
        a: kept.get(key).map(|text| (*text).to_owned()),
        b: other.get(key).map(|text| (*text).to_owned()),
        is_visible: false,
    });
    MergedFile { left_out: left_out.collect(), merged, text }
}

struct Merger<'a> {
    base: &'a Material,
    a: &'a Material,
    b: &'a Material,
    prefer: Side,
    material: Material,
    conflicts: Vec<Conflict>,
    taken: Vec<String>,
}

impl Merger<'_> {
    /// Whether an entry is taken from the second version; notes conflicts.
    fn is_from_b(&mut self, key: &str, property: Option<Property>, pick: Pick, of: impl Fn(&Material) -> Option<String>) -> bool {
        let is_from_b = match pick {
            Pick::A => false,
            Pick::B => true,
            Pick::Conflict => {
                let (base, a, b) = (of(self.base), of(self.a), of(self.b));
                self.conflicts.push(Conflict { key: key.to_owned(), property, base, a, b });
                self.prefer == Side::B
            }
        };
        if is_from_b {
            self.taken.push(key.to_owned());
        }
        is_from_b
    }

    fn words(&mut self) {
        let (base, a, b) = (self.base, self.a, self.b);
        let same = |x: &String, y: &String| x == y;
        self.material.tags = merged_words(&base.tags, &a.tags, &b.tags);
        self.material.aliases = merged_words(&base.aliases, &a.aliases, &b.aliases);
        let lists = [("tags", &a.tags, &self.material.tags), ("aliases", &a.aliases, &self.material.aliases)];
        self.taken.extend(lists.into_iter().filter(|(_, a, merged)| a != merged).map(|(key, ..)| key.to_owned()));
        let (name, other) = match pick(&base.name, &a.name, &b.name, same, same) {
            Pick::A => (&a.name, None),
            Pick::B => (&b.name, None),
            Pick::Conflict if self.prefer == Side::A && !a.name.is_empty() || b.name.is_empty() => (&a.name, Some(&b.name)),
            Pick::Conflict => (&b.name, Some(&a.name)),
        };
        if *name != a.name {
            self.taken.push("name".to_owned());
        }
        self.material.name.clone_from(name);
        if let Some(other) = other.filter(|other| !other.is_empty() && !self.material.aliases.contains(other)) {
            self.material.aliases.push(other.clone());
        }
        if self.is_from_b("notes", None, pick(&base.notes, &a.notes, &b.notes, same, same), |m| diff::text(&m.notes)) {
            self.material.notes.clone_from(&b.notes);
        }
        for (key, get) in TEXTS {
            let picked = pick(get(&base.provenance), get(&a.provenance), get(&b.provenance), same, same);
            if self.is_from_b(&format!("provenance.{key}"), None, picked, |m| diff::text(get(&m.provenance))) {
                let text = get(&b.provenance).clone();
                let provenance = &mut self.material.provenance;
                let place = match key {
                    "source" => &mut provenance.source,
                    "reference" => &mut provenance.reference,
                    "method" => &mut provenance.method,
                    _ => &mut provenance.licence,
                };
                *place = text;
            }
        }
    }

    /// Texts of other formats.
    fn foreign(&mut self) {
        let (base, a, b) = (self.base, self.a, self.b);
        for (format, key) in differing(a, b) {
            let same = |x: &Option<&str>, y: &Option<&str>| x == y;
            let [in_base, in_a, in_b] = [base, a, b].map(|m| m.foreign_text(format, key));
            let picked = pick(&in_base, &in_a, &in_b, same, same);
            if self.is_from_b(&entry_key(format, key), None, picked, |m| m.foreign_text(format, key).map(string)) {
                // Beyond what a material holds, the first version's stay.
                _ = self.material.set_foreign(format, key, in_b.map(str::to_owned));
            }
        }
    }

    fn has_one_unit(&self) -> bool {
        [self.a, self.b].iter().all(|m| m.unit_mm().to_bits() == self.base.unit_mm().to_bits())
    }

    /// The unit, with all lengths where it was changed.
    fn lengths(&mut self) {
        let same_unit = |x: &Material, y: &Material| x.unit_mm().to_bits() == y.unit_mm().to_bits();
        let is_exact = |x: &Material, y: &Material| x.unit_mm.map(f64::to_bits) == y.unit_mm.map(f64::to_bits);
        let (base, a, b) = (self.base, self.a, self.b);
        if self.has_one_unit() {
            if matches!(pick(base, a, b, is_exact, same_unit), Pick::B) {
                self.material.unit_mm = b.unit_mm;
            }
            return;
        }
        let all_exact = |x: &Material, y: &Material| is_exact(x, y) && lengths().all(|id| same_slot(x.slot(id), y.slot(id)));
        let is_like = |x: &Material, y: &Material| same_unit(x, y) && lengths().all(|id| same_meaning(x, y, id));
        let of = |m: &Material| {
            let slots = lengths().filter_map(|id| Some(format!(", {} {}", id.def().name, slot_of(m, id)?)));
            Some(format!("{}{}", value_text(Value::Float(m.unit_mm())), slots.collect::<String>()))
        };
        if self.is_from_b("unit_mm", None, pick(base, a, b, all_exact, is_like), of) {
            self.material.unit_mm = b.unit_mm;
            lengths().for_each(|id| *self.material.slot_mut(id) = b.slot(id).clone());
        }
    }
}

/// Properties that are lengths.
fn lengths() -> impl Iterator<Item = Property> {
    PROPERTIES.iter().filter(|def| def.unit == Unit::Length).map(|def| def.id)
}

/// Whether a property is the same in both, be the default written out or not.
fn same_meaning(x: &Material, y: &Material, id: Property) -> bool {
    same_value(Some(x.value(id)), Some(y.value(id))) && same_texture(x.slot(id).texture.as_ref(), y.slot(id).texture.as_ref())
}

/// What a file says of a property; `None` if nothing.
fn slot_of(material: &Material, id: Property) -> Option<String> {
    let slot = material.slot(id);
    (slot.value.is_some() || slot.texture.is_some()).then(|| slot_text(slot))
}

/// The first version's words without those that the second one took out, then those that it added.
fn merged_words(base: &[String], a: &[String], b: &[String]) -> Vec<String> {
    if a == base || a == b {
        return b.to_vec();
    }
    let kept = a.iter().filter(|tag| b.contains(tag) || !base.contains(tag));
    let added = b.iter().filter(|tag| !base.contains(tag) && !a.contains(tag));
    kept.chain(added).cloned().collect()
}
