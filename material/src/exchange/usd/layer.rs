//! A layer of USD as a tree: prims with their properties, flat in memory and found by name.

use std::borrow::Cow;
use std::collections::HashMap;

use crate::exchange::model::Notes;
use crate::exchange::short::short;

/// Notes beyond this number are counted, not listed.
const MAX_NOTES: usize = 200;

/// Longest path that is followed, bytes.
const MAX_PATH_BYTES: usize = 1_000;

/// Place of a prim in its layer; 0 is the layer's root.
pub type PrimId = u32;

/// A value in a layer.
#[derive(Clone, Debug, PartialEq)]
pub enum Value<'a> {
    /// Blocked: `None`.
    None,
    /// Numbers, truths, vectors, matrices, and lists of them, all in a row.
    Numbers {
        /// Numbers of one item: 1, 3 for a colour, 16 for a matrix.
        width: usize,
        /// Whether they stood in a list.
        is_list: bool,
        /// `width` numbers for each item.
        data: Vec<f64>,
    },
    /// Texts, tokens, files and paths, one or a list.
    Texts {
        /// Whether they stood in a list.
        is_list: bool,
        /// Without quotes.
        items: Vec<Cow<'a, str>>,
    },
    /// Entries by name.
    Dictionary(Entries<'a>),
}

/// Named values in the order of the text.
pub type Entries<'a> = Vec<(Cow<'a, str>, Value<'a>)>;

/// The entry of this name.
pub fn entry<'t, 'a>(entries: &'t Entries<'a>, name: &str) -> Option<&'t Value<'a>> {
    entries.iter().find(|(key, _)| key == name).map(|(_, value)| value)
}

impl<'a> Value<'a> {
    /// The numbers of a single value that has this many.
    pub fn tuple(&self, count: usize) -> Option<&[f64]> {
        match self {
            Self::Numbers { width, is_list: false, data } if *width == count => Some(data),
            _ => None,
        }
    }

    /// A single number.
    pub fn number(&self) -> Option<f64> {
        self.tuple(1).and_then(|data| data.first().copied())
    }

    /// The numbers of a list whose items have this many each.
    pub fn list(&self, count: usize) -> Option<&[f64]> {
        match self {
            Self::Numbers { width, is_list: true, data } if *width == count || data.is_empty() => Some(data),
            _ => None,
        }
    }

    /// A single text.
    pub fn text(&self) -> Option<&str> {
        match self {
            Self::Texts { items, .. } => items.first().map(Cow::as_ref),
            _ => None,
        }
    }

    /// A list of texts; a single one is a list of one.
    pub fn texts(&self) -> &[Cow<'a, str>] {
        match self {
            Self::Texts { items, .. } => items,
            _ => &[],
        }
    }

    /// The entries of a dictionary.
    pub fn entries(&self) -> Option<&Entries<'a>> {
        match self {
            Self::Dictionary(entries) => Some(entries),
            _ => None,
        }
    }

    /// Whether all numbers in it are finite.
    pub fn is_finite(&self) -> bool {
        match self {
            Self::Numbers { data, .. } => data.iter().all(|x| x.is_finite()),
            Self::Dictionary(entries) => entries.iter().all(|(_, value)| value.is_finite()),
            _ => true,
        }
    }
}

/// An attribute or relationship.
#[derive(Clone, Debug)]
pub struct Attribute<'a> {
    /// Its name with namespaces.
    pub name: &'a str,
    /// Its type without `[]`; `rel` for a relationship.
    pub type_name: &'a str,
    /// Its value, or the first of its samples.
    pub value: Option<Value<'a>>,
    /// Paths that it is connected to, or that a relationship names.
    pub targets: Vec<&'a str>,
    /// What stands in brackets behind it.
    pub metadata: Entries<'a>,
    /// Line in the text, from 1.
    pub line: usize,
    /// Whether it was said in a variant, which what the prim says itself overrides.
    pub(super) is_weak: bool,
}

/// A prim.
#[derive(Clone, Debug)]
pub struct Prim<'a> {
    /// Its name; empty for the root.
    pub name: Cow<'a, str>,
    /// Its type; empty where the text says none.
    pub type_name: &'a str,
    /// The prim that it stands in.
    pub parent: PrimId,
    /// Prims in it, in the order of the text.
    pub children: Vec<PrimId>,
    /// Its attributes and relationships, in the order of the text.
    pub attributes: Vec<u32>,
    /// What stands in brackets behind it.
    pub metadata: Entries<'a>,
    /// Whether the scene holds it: defined by `def` and active.
    pub is_defined: bool,
}

/// A layer: a text of USD, parsed.
#[derive(Clone, Debug)]
pub struct Layer<'a> {
    pub(super) prims: Vec<Prim<'a>>,
    pub(super) attributes: Vec<Attribute<'a>>,
    pub(super) prim_places: HashMap<(PrimId, Cow<'a, str>), PrimId>,
    pub(super) attribute_places: HashMap<(PrimId, &'a str), u32>,
    pub(super) notes: Notes,
    pub(super) more_notes: usize,
}

impl<'a> Layer<'a> {
    /// The layer's root.
    pub const ROOT: PrimId = 0;

    /// The prim at a place that this layer gave.
    pub fn prim(&self, prim: PrimId) -> &Prim<'a> {
        &self.prims[prim as usize]
    }

    /// All prims but the root, parents before their children.
    pub fn prims(&self) -> impl Iterator<Item = (PrimId, &Prim<'a>)> {
        self.prims.iter().enumerate().skip(1).map(|(place, prim)| (place as PrimId, prim))
    }

    /// The prims of a type that the scene holds, in the order of the text.
    pub fn in_scene(&self, type_name: &str) -> impl Iterator<Item = PrimId> {
        let of_type = self.prims().filter(move |(_, prim)| prim.type_name == type_name);
        of_type.map(|(id, _)| id).filter(|id| self.is_in_scene(*id))
    }

    fn is_in_scene(&self, mut prim: PrimId) -> bool {
        while prim != Self::ROOT {
            if !self.prim(prim).is_defined {
                return false;
            }
            prim = self.prim(prim).parent;
        }
        true
    }

    /// A metadata entry of the layer, such as `metersPerUnit`.
    pub fn metadata(&self, name: &str) -> Option<&Value<'a>> {
        entry(&self.prim(Self::ROOT).metadata, name)
    }

    /// The prim of this name in another.
    pub fn child(&self, parent: PrimId, name: &str) -> Option<PrimId> {
        self.prim_places.get(&(parent, Cow::Borrowed(name))).copied()
    }

    /// The attribute or relationship of this name.
    pub fn attribute(&self, prim: PrimId, name: &str) -> Option<&Attribute<'a>> {
        self.attribute_places.get(&(prim, name)).map(|place| &self.attributes[*place as usize])
    }

    /// The attributes and relationships of a prim.
    pub fn attributes(&self, prim: PrimId) -> impl Iterator<Item = &Attribute<'a>> {
        self.prim(prim).attributes.iter().map(|place| &self.attributes[*place as usize])
    }

    /// The value of an attribute.
    pub fn value(&self, prim: PrimId, name: &str) -> Option<&Value<'a>> {
        self.attribute(prim, name)?.value.as_ref()
    }

    /// The path of a prim: `/World/Looks/Wood`.
    pub fn path(&self, mut prim: PrimId) -> String {
        let mut names = Vec::new();
        while prim != Self::ROOT {
            names.push(self.prim(prim).name.as_ref());
            prim = self.prim(prim).parent;
        }
        names.iter().rev().fold(String::new(), |path, name| path + "/" + name)
    }

    /// The prim that a path means, seen from another prim, and the property behind its dot, which is empty without one.
    pub fn find<'p>(&self, from: PrimId, path: &'p str) -> Option<(PrimId, &'p str)> {
        if path.len() > MAX_PATH_BYTES {
            return None;
        }
        let names_end = path.rfind('/').map_or(0, |slash| slash + 1);
        let (prims, property) = match path[names_end..].find('.') {
            _ if path.ends_with("..") => (path, ""),
            Some(dot) => (&path[..names_end + dot], &path[names_end + dot + 1..]),
            None => (path, ""),
        };
        let mut prim = if path.starts_with('/') { Self::ROOT } else { from };
        for name in prims.split('/').filter(|name| !name.is_empty() && *name != ".") {
            prim = if name == ".." { self.prim(prim).parent } else { self.child(prim, name)? };
        }
        Some((prim, property))
    }

    /// What did not go as it stands in the text.
    pub fn notes(&self) -> Notes {
        let mut notes = self.notes.clone();
        if self.more_notes > 0 {
            notes.push(format!("{} more notes are not listed", self.more_notes));
        }
        notes
    }

    /// Tells of something in a line, about a prim where it is known.
    pub fn note(&mut self, line: usize, prim: Option<PrimId>, what: &str) {
        if self.notes.len() >= MAX_NOTES {
            self.more_notes += 1;
            return;
        }
        let place = prim.map(|prim| format!("<{}>: ", short(&self.path(prim)))).unwrap_or_default();
        self.notes.push(format!("line {line}: {place}{what}"));
    }
}
