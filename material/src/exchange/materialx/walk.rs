//! Computing a graph: every node once, those before it first, however deep or circular the connections are.

use std::collections::{HashMap, HashSet};

use super::color::Space;
use super::graph::{Graph, Link};
use super::image::ImageSource;
use super::nodes;
use super::numbers::{self, Part, Parts};
use super::xml::Id;
use crate::exchange::model::Notes;
use crate::exchange::short::short;

/// What an output of a node is.
#[derive(Clone, Debug, PartialEq)]
pub enum Term {
    /// Numbers, constant or following an image or the coordinates.
    Numbers(Box<Parts>),
    /// A normal map, or a constant direction in tangent space.
    Normal(Normal),
    /// A direction of the surface itself.
    Direction(Direction),
    /// The tangent, turned about the normal by this many turns, counterclockwise.
    Tangent(Part),
    /// Nothing that a material can hold: the node, and why.
    Unknown(Id, &'static str),
}

/// A direction of the surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// Its normal.
    Normal,
    /// Its tangent.
    Tangent,
    /// Any other.
    Other,
}

/// A normal in tangent space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Normal {
    /// The image; none for a constant.
    pub source: Option<u32>,
    /// Whether green points down.
    pub is_flipped: bool,
    /// The direction where there is no image.
    pub constant: [f64; 3],
    /// Factor on the slope.
    pub scale: f64,
}

impl Normal {
    /// The normal of a flat surface.
    pub const FLAT: Self = Self { source: None, is_flipped: false, constant: [0.0, 0.0, 1.0], scale: 1.0 };
}

/// What numbers can follow.
#[derive(Clone, Debug, PartialEq)]
pub enum Source {
    /// The coordinates of the surface.
    Coordinates,
    /// An image.
    Image(ImageSource),
}

/// Most notes that are kept while a material is read.
const MAX_NOTES: usize = 1000;

/// The coordinates' place among the sources.
pub const COORDINATES: u32 = 0;

/// A graph while it is computed.
pub struct Walk<'a> {
    /// The graph.
    pub graph: &'a Graph<'a>,
    /// What is told to the user.
    pub notes: Notes,
    /// What is told of the whole document.
    pub document_notes: Notes,
    sources: Vec<Source>,
    terms: HashMap<Id, Term>,
}

impl<'a> Walk<'a> {
    /// Nothing computed yet.
    pub fn of(graph: &'a Graph<'a>) -> Self {
        Self {
            graph,
            notes: Notes::new(),
            document_notes: Notes::new(),
            sources: vec![Source::Coordinates],
            terms: HashMap::new(),
        }
    }

    /// Adds a source; its number.
    pub fn add_source(&mut self, source: ImageSource) -> u32 {
        self.sources.push(Source::Image(source));
        self.sources.len() as u32 - 1
    }

    /// The image of this number.
    pub fn image(&self, source: u32) -> Option<&ImageSource> {
        match self.sources.get(source as usize) {
            Some(Source::Image(image)) => Some(image),
            _ => None,
        }
    }

    /// What stands behind an input, with everything before it computed. None without a value.
    pub fn at(&mut self, input: Id) -> Option<Term> {
        if let Link::Node(node, _) = self.graph.link(input) {
            self.compute(node);
        }
        self.behind(input)
    }

    /// Computes a node and everything before it. What leads back to itself is unknown.
    fn compute(&mut self, start: Id) {
        let (mut open, mut needs) = (HashSet::new(), Vec::new());
        let mut stack = vec![start];
        while let Some(id) = stack.last().copied() {
            if self.terms.contains_key(&id) {
                stack.pop();
            } else if open.insert(id) {
                self.graph.needs(id, &mut needs);
                for need in needs.drain(..) {
                    if open.contains(&need) && !self.terms.contains_key(&need) {
                        self.note(format!("{}: is connected to itself; the circle is cut", self.graph.path(need)));
                    } else {
                        stack.push(need);
                    }
                }
            } else {
                let term = match self.graph.tree.tag(id) {
                    "output" => self.behind(id).unwrap_or(Term::Unknown(id, "has no value")),
                    _ => nodes::compute(self, id),
                };
                self.terms.insert(id, term);
                stack.pop();
            }
        }
    }

    /// What stands behind an input of a node whose needs are computed.
    fn behind(&mut self, input: Id) -> Option<Term> {
        match self.graph.link(input) {
            Link::Value(element) => self.value(element),
            Link::Node(node, output) => {
                let term = self.terms.get(&node).cloned().unwrap_or(Term::Unknown(node, "is connected to itself"));
                Some(select(term, &output))
            }
            Link::Missing(name) => {
                self.note(format!("{}: nothing has the name `{}`", self.graph.path(input), short(&name)));
                self.value(input)
            }
        }
    }

    /// The numbers that stand in an element, in linear Rec.709 if they are a colour.
    fn value(&mut self, element: Id) -> Option<Term> {
        let tree = self.graph.tree;
        let text = tree.attribute(element, "value").filter(|text| !text.trim().is_empty())?;
        let kind = tree.attribute(element, "type").unwrap_or("float");
        let count = numbers::count_of(kind)?;
        let Some(mut all) = numbers::parse(text, count) else {
            let path = self.graph.path(element);
            self.note(format!("{path}: expected a {kind} of finite numbers, found `{}`", short(text)));
            return None;
        };
        if matches!(kind, "color3" | "color4")
            && let Some(name) = tree.inherited(element, "colorspace")
        {
            let note = match Space::named(name) {
                Some(space) if space.is_linear_rec709() => None,
                Some(space) => {
                    let [r, g, b] = space.to_linear_rec709([all[0], all[1], all[2]]);
                    (all[0], all[1], all[2]) = (r, g, b);
                    Some(format!("colour space `{}`: colours were converted to linear Rec.709", short(name)))
                }
                None => Some(format!("colour space `{}`: not known, taken as linear Rec.709", short(name))),
            };
            if let Some(note) = note {
                self.note_of_document(note);
            }
        }
        Parts::constants(&all[..count]).map(|parts| Term::Numbers(Box::new(parts)))
    }

    /// Tells something of the whole document once.
    pub fn note_of_document(&mut self, note: String) {
        if self.document_notes.len() < MAX_NOTES && !self.document_notes.contains(&note) {
            self.document_notes.push(note);
        }
    }

    /// Tells something once. Who wrote a thousand faults knows by then.
    pub fn note(&mut self, note: String) {
        if self.notes.len() < MAX_NOTES && !self.notes.contains(&note) {
            self.notes.push(note);
        }
    }

    /// What stands behind the input of this name of a node whose needs are computed.
    pub fn input(&mut self, node: Id, name: &str) -> Option<Term> {
        let input = self.graph.input(node, name)?;
        self.behind(input)
    }

    /// The numbers of an input; those given where it has none.
    pub fn numbers(&mut self, node: Id, name: &str, default: &[f64]) -> Result<Parts, Term> {
        match self.input(node, name) {
            Some(Term::Numbers(parts)) => Ok(*parts),
            Some(Term::Unknown(at, why)) => Err(Term::Unknown(at, why)),
            Some(_) => Err(Term::Unknown(node, "has a direction where it needs numbers")),
            None => Parts::constants(default).ok_or(Term::Unknown(node, "has no value")),
        }
    }

    /// The constants of an input; those given where it has none.
    pub fn constants<const N: usize>(&mut self, node: Id, name: &str, default: [f64; N]) -> Result<[f64; N], Term> {
        let parts = self.numbers(node, name, &default)?;
        let mut all = default;
        for (place, number) in all.iter_mut().enumerate() {
            *number = parts.at(place).as_constant().ok_or(Term::Unknown(node, "has settings that vary over the surface"))?;
        }
        Ok(all)
    }

    /// The text of an input: a file name or a word. Empty where there is none.
    pub fn text(&self, node: Id, name: &str) -> (&'a str, Id) {
        let Some(input) = self.graph.input(node, name) else { return ("", node) };
        let mut at = input;
        // A few constant nodes and outputs may stand in between.
        for _ in 0..8 {
            match self.graph.link(at) {
                Link::Value(element) => return (self.graph.tree.attribute(element, "value").unwrap_or_default(), element),
                Link::Node(next, _) if self.graph.tree.tag(next) == "output" => at = next,
                Link::Node(next, _) => match self.graph.input(next, "value") {
                    Some(value) => at = value,
                    None => break,
                },
                Link::Missing(_) => break,
            }
        }
        (self.graph.tree.attribute(input, "value").unwrap_or_default(), input)
    }
}

/// The output of this name of a node with several.
fn select(term: Term, output: &str) -> Term {
    let Term::Numbers(parts) = &term else { return term };
    let one = |place: usize| parts.all().get(place).and_then(|part| Parts::of(&[*part]));
    let selected = match output {
        "outr" | "outx" | "r" => one(0),
        "outg" | "outy" | "g" => one(1),
        "outb" | "outz" | "b" => one(2),
        "outa" | "outw" | "a" => one(3),
        "outcolor" | "rgb" => Parts::of(parts.all().get(..3).unwrap_or(parts.all())),
        _ => None,
    };
    selected.map_or(term.clone(), |parts| Term::Numbers(Box::new(parts)))
}
